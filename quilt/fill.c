/* Valid pixels are stored as bits for the rows in reach. The nearest one of a row is then found
 * by counting zeros to both sides, and rows are searched from the pixel outwards until none can
 * be nearer. The work is a few operations per missing pixel, and almost none without missing
 * pixels. */
#include <endian.h>
#include <string.h>

#include "quilt/quilt.h"

#define MAX_REACH 16
#define BLOCK_PX 1024
#define WORD_PX 64
/* A block has one more word on each side, and one that a window may read past the end. */
#define BLOCK_WORDS (BLOCK_PX / WORD_PX + 3)
#define MAX_ROWS (2 * MAX_REACH + 1)

typedef struct fill_job {
    int n_views, width, height, reach, near;
    size_t pixel;  /* bytes of a pixel */
    bool is_float; /* a pixel has three floats; otherwise bytes */
    const uint8_t *pixels, *missing;
    uint8_t *filled;
    atomic_int_least64_t n_unfilled, n_far;
} fill_job;

/* Bit i of word w, in little-endian order, is column x0 + (w - 1) * WORD_PX + i: 1 if the pixel is
 * valid. */
typedef uint64_t row_bits[BLOCK_WORDS];

/* A ring of rows while the block is processed downwards: row y is at y % MAX_ROWS. */
typedef struct block {
    const fill_job *job;
    int view, x0, n; /* columns [x0, x0 + n) */
    int64_t n_unfilled, n_far;
    const uint64_t *around[MAX_ROWS]; /* the rows -reach to reach around the current one */
    row_bits there[MAX_ROWS], none;
} block;

static size_t start_of(const fill_job *job, int row, int view)
{
    return ((size_t)row * (size_t)job->n_views + (size_t)view) * (size_t)job->width;
}

/* The zeros among eight flags, as bits of a byte; the first flag is the lowest bit. */
static uint64_t zeros_of_eight(const uint8_t *flags)
{
    const uint64_t low = UINT64_C(0x7f7f7f7f7f7f7f7f);
    uint64_t f;
    memcpy(&f, flags, sizeof f);
    f = le64toh(f);
    uint64_t set = ((f & low) + low) | f; /* sets bit 7 of nonzero bytes */
    return ((~set >> 7 & UINT64_C(0x0101010101010101)) * UINT64_C(0x0102040810204080)) >> 56;
}

static uint64_t zeros_of_word(const uint8_t *flags, int x, int width)
{
    uint64_t bits = 0;
    if (x < 0 || x >= width)
        return 0;
    int n = width - x < WORD_PX ? width - x : WORD_PX, i = 0;
    for (; i + 8 <= n; i += 8)
        bits |= zeros_of_eight(flags + x + i) << i;
    for (; i < n; i++)
        bits |= (uint64_t)(flags[x + i] == 0) << i;
    return bits;
}

static void read_row(block *b, int row)
{
    const uint8_t *flags = b->job->missing + start_of(b->job, row, b->view);
    for (int w = 0; w < BLOCK_WORDS; w++)
        b->there[row % MAX_ROWS][w] =
            htole64(zeros_of_word(flags, b->x0 + (w - 1) * WORD_PX, b->job->width));
}

/* Makes `row` the current one; rows come in order from 0. */
static void go_to_row(block *b, int row)
{
    const int reach = b->job->reach, height = b->job->height;
    for (int y = row == 0 ? 0 : row + reach; y <= row + reach && y < height; y++)
        read_row(b, y);
    for (int dy = -reach; dy <= reach; dy++) {
        int y = row + dy;
        b->around[dy + reach] = y >= 0 && y < height ? b->there[y % MAX_ROWS] : b->none;
    }
}

/* Position of a pixel found, coded so that the smallest number is the nearest; ties go to the
 * upper, then the left one. */
#define MIDDLE 32
static inline int found_at(int dx, int dy)
{
    return (dx * dx + dy * dy) << 12 | (dy + MIDDLE) << 6 | (dx + MIDDLE);
}

/* The nearest valid pixel of the row at dy from column x0 + i; over reach if none. */
static inline int nearest_of_row(const block *b, int i, int dy)
{
    const int reach = b->job->reach, first = i + WORD_PX - reach;
    uint64_t window;
    memcpy(&window, (const char *)b->around[dy + reach] + first / 8, sizeof window);
    window = le64toh(window) >> first % 8;
    uint64_t left = window << (63 - reach) | UINT64_C(1) << (62 - reach),
             right = window >> reach | UINT64_C(2) << reach;
    int to_left = found_at(-__builtin_clzll(left), dy),
        to_right = found_at(__builtin_ctzll(right), dy);
    return to_left < to_right ? to_left : to_right;
}

static inline int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int nearest_of(const block *b, int i)
{
    int found = nearest_of_row(b, i, 0);
    for (int away = 1; away <= b->job->reach && away * away <= found >> 12; away++)
        found = smaller(found, smaller(nearest_of_row(b, i, -away), nearest_of_row(b, i, away)));
    return found;
}

/* Only valid pixels are read and only missing ones written, so in-place filling is safe on any
 * thread. */
static void fill_pixel(block *b, int row, int i)
{
    const fill_job *job = b->job;
    const int found = nearest_of(b, i);
    b->n_far += found >> 12 > job->near * job->near;
    if (found >> 12 > job->reach * job->reach) {
        b->n_unfilled++;
        return;
    }
    int dy = (found >> 6 & 63) - MIDDLE, dx = (found & 63) - MIDDLE;
    size_t x = (size_t)(b->x0 + i);
    size_t from = start_of(job, row + dy, b->view) + x + (size_t)dx,
           to = start_of(job, row, b->view) + x;
    memcpy(job->filled + to * job->pixel, job->pixels + from * job->pixel, job->pixel);
}

/* The nearest offsets, nearest first; ties in the order of found_at. */
static const struct {
    int dx, dy;
} nearest[] = {{0, -1}, {-1, 0}, {1, 0},  {0, 1},  {-1, -1}, {1, -1},
               {-1, 1}, {1, 1},  {0, -2}, {-2, 0}, {2, 0},   {0, 2}};

/* The columns from x0 + x on with a valid pixel at (dx, dy), |dx| < WORD_PX. */
static uint64_t there_from(const block *b, int x, int dx, int dy)
{
    const uint64_t *row = b->around[dy + b->job->reach] + x / WORD_PX + 1;
    uint64_t word = le64toh(row[0]);
    if (dx > 0)
        return word >> dx | le64toh(row[1]) << (WORD_PX - dx);
    return dx == 0 ? word : word << -dx | le64toh(row[-1]) >> (WORD_PX + dx);
}

/* Copies to the pixels of a mask from x0 + x on the pixels at (dx, dy), run by run. */
static void copy_runs(const block *b, int row, int x, uint64_t mask, int dx, int dy)
{
    const fill_job *job = b->job;
    uint8_t *to = job->filled + (start_of(job, row, b->view) + (size_t)(b->x0 + x)) * job->pixel;
    const uint8_t *from =
        job->pixels + (start_of(job, row + dy, b->view) + (size_t)(b->x0 + x + dx)) * job->pixel;
    while (mask) {
        int first = __builtin_ctzll(mask);
        uint64_t behind = ~(mask >> first); /* 0 only if every pixel of the word is copied */
        int n = behind ? __builtin_ctzll(behind) : WORD_PX;
        memcpy(to + (size_t)first * job->pixel, from + (size_t)first * job->pixel,
               (size_t)n * job->pixel);
        mask &= n < WORD_PX ? ~(((UINT64_C(1) << n) - 1) << first) : 0;
    }
}

/* Pairs of distances, in rows, of the pixels straight above and below a hole, nearest first. */
static const struct {
    int up, down;
} between[] = {{1, 1}, {1, 2}, {2, 1}, {1, 3}, {3, 1}, {2, 2}};

/* Interpolates the pixels of a mask from x0 + x on linearly between those above and below. */
static void mix_rows(const block *b, int row, int x, uint64_t mask, int up, int down)
{
    const fill_job *job = b->job;
    const size_t to = 3 * (start_of(job, row, b->view) + (size_t)(b->x0 + x)),
                 above = 3 * (start_of(job, row - up, b->view) + (size_t)(b->x0 + x)),
                 below = 3 * (start_of(job, row + down, b->view) + (size_t)(b->x0 + x));
    for (; mask; mask &= mask - 1) {
        const size_t first = 3 * (size_t)__builtin_ctzll(mask);
        for (size_t i = first; i < first + 3; i++) {
            if (job->is_float) {
                const float *in = (const float *)(const void *)job->pixels;
                ((float *)(void *)job->filled)[to + i] =
                    ((float)down * in[above + i] + (float)up * in[below + i]) / (float)(up + down);
            } else {
                const int sum = down * job->pixels[above + i] + up * job->pixels[below + i];
                job->filled[to + i] = (uint8_t)((2 * sum + up + down) / (2 * (up + down)));
            }
        }
    }
}

/* Fills holes between two rows, 64 at a time; returns the holes left. This alone nearly fills a
 * coarse frame, in which three of four rows are missing. */
static uint64_t fill_between(block *b, int row, int x, uint64_t holes)
{
    for (size_t i = 0; i < sizeof between / sizeof *between && holes; i++) {
        const int up = between[i].up, down = between[i].down, near = up < down ? up : down;
        if (up > b->job->reach || down > b->job->reach)
            continue;
        const uint64_t mask = holes & there_from(b, x, 0, -up) & there_from(b, x, 0, down);
        mix_rows(b, row, x, mask, up, down);
        holes &= ~mask;
        for (uint64_t far = near > b->job->near ? mask : 0; far; far &= far - 1)
            b->n_far += nearest_of(b, x + __builtin_ctzll(far)) >> 12 > b->job->near * b->job->near;
    }
    return holes;
}

/* Fills holes with a neighbour among the nearest offsets, 64 at a time; returns the holes left. */
static uint64_t fill_word(block *b, int row, int x, uint64_t holes)
{
    for (size_t i = 0; i < sizeof nearest / sizeof *nearest && holes; i++) {
        int dx = nearest[i].dx, dy = nearest[i].dy, distance2 = dx * dx + dy * dy;
        if (distance2 > b->job->reach * b->job->reach)
            break;
        uint64_t mask = holes & there_from(b, x, dx, dy);
        copy_runs(b, row, x, mask, dx, dy);
        holes &= ~mask;
        if (distance2 > b->job->near * b->job->near)
            b->n_far += __builtin_popcountll(mask);
    }
    return holes;
}

static void fill_row(block *b, int row)
{
    const fill_job *job = b->job;
    size_t start = start_of(job, row, b->view) + (size_t)b->x0;
    if (job->filled != job->pixels)
        memcpy(job->filled + start * job->pixel, job->pixels + start * job->pixel,
               (size_t)b->n * job->pixel);
    go_to_row(b, row);
    for (int x = 0; x < b->n; x += WORD_PX) {
        uint64_t all = b->n - x < WORD_PX ? (UINT64_C(1) << (b->n - x)) - 1 : ~UINT64_C(0);
        uint64_t holes = ~there_from(b, x, 0, 0) & all;
        holes = fill_between(b, row, x, holes);
        for (holes = fill_word(b, row, x, holes); holes; holes &= holes - 1)
            fill_pixel(b, row, x + __builtin_ctzll(holes));
    }
}

static void fill_view(void *context, int view, int worker)
{
    (void)worker;
    fill_job *job = context;
    block b = {.job = job, .view = view};
    for (; b.x0 < job->width; b.x0 += BLOCK_PX) {
        b.n = job->width - b.x0 < BLOCK_PX ? job->width - b.x0 : BLOCK_PX;
        for (int row = 0; row < job->height; row++)
            fill_row(&b, row);
    }
    /* relaxed, because sums need no order and the end of the run publishes them */
    atomic_fetch_add_explicit(&job->n_unfilled, b.n_unfilled, memory_order_relaxed);
    atomic_fetch_add_explicit(&job->n_far, b.n_far, memory_order_relaxed);
}

static lf_fill_counts fill(fill_job *job, int reach, lf_pool *pool)
{
    job->reach = reach < 0 ? 0 : reach > MAX_REACH ? MAX_REACH : reach;
    bool done = pool && lf_pool_run(pool, job->n_views, fill_view, job, NULL) == LF_OK;
    for (int view = 0; view < job->n_views && !done; view++)
        fill_view(job, view, 0);
    return (lf_fill_counts){
        .unfilled = atomic_load_explicit(&job->n_unfilled, memory_order_relaxed),
        .far = atomic_load_explicit(&job->n_far, memory_order_relaxed),
    };
}

lf_fill_counts lf_fill(int n_views, int width, int height, const uint8_t *rgb,
                       const uint8_t *missing, int near, int reach, uint8_t *filled, lf_pool *pool)
{
    fill_job job = {
        .n_views = n_views, .width = width, .height = height, .near = near, .missing = missing};
    job.pixel = 3;
    job.pixels = rgb;
    job.filled = filled;
    return fill(&job, reach, pool);
}

void lf_fill_film(int n_views, int width, int height, float *film, const uint8_t *missing,
                  int reach, lf_pool *pool)
{
    fill_job job = {
        .n_views = n_views, .width = width, .height = height, .near = reach, .missing = missing};
    job.pixel = 3 * sizeof *film;
    job.is_float = true;
    job.pixels = job.filled = (uint8_t *)film;
    (void)fill(&job, reach, pool);
}
