/* The nearest pixel in a row is found by one sweep from either side, and the nearest of all by comparing what the rows around
 * have: the work is a few comparisons a missing pixel, and none where nothing is missing. */
#include <string.h>

#include "quilt/quilt.h"

#define MAX_REACH 16
#define BLOCK_PX 256
#define NONE INT8_MAX

typedef struct fill_job {
    int n_views, width, height, reach;
    const uint8_t *rgb, *missing;
    uint8_t *filled;
    atomic_int_least64_t n_unfilled;
} fill_job;

/* For each pixel of a block's row the way along the row to the nearest one that is there, NONE beyond reach. */
typedef struct swept_row {
    int row; /* -1: not swept yet */
    bool any;
    int8_t dx[BLOCK_PX];
} swept_row;

/* Rows come and go as the block is walked down: row y lies at y % (2 reach + 1). */
typedef struct block {
    const fill_job *job;
    int view, x0, n; /* columns [x0, x0 + n) */
    swept_row swept[2 * MAX_REACH + 1];
} block;

static size_t start_of(const fill_job *job, int row, int view)
{
    return ((size_t)row * (size_t)job->n_views + (size_t)view) * (size_t)job->width;
}

static void sweep(const block *b, const uint8_t *flags, swept_row *s)
{
    const int reach = b->job->reach, width = b->job->width, end = b->x0 + b->n;
    int from = b->x0 - reach > 0 ? b->x0 - reach : 0, to = end + reach < width ? end + reach : width;
    int last = from - reach - 1, next = to + reach;
    s->any = false;
    for (int x = from; x < end; x++) {
        last = flags[x] ? last : x;
        if (x >= b->x0)
            s->dx[x - b->x0] = (int8_t)(x - last <= reach ? last - x : NONE);
    }
    for (int x = to - 1; x >= b->x0; x--) {
        next = flags[x] ? next : x;
        if (x >= end)
            continue;
        int8_t *dx = &s->dx[x - b->x0];
        int right = next - x;
        if (right <= reach && (*dx == NONE || right < -*dx))
            *dx = (int8_t)right;
        s->any = s->any || *dx != NONE;
    }
}

static const swept_row *row_around(block *b, int row)
{
    swept_row *s = &b->swept[row % (2 * b->job->reach + 1)];
    if (s->row != row) {
        sweep(b, b->job->missing + start_of(b->job, row, b->view), s);
        s->row = row;
    }
    return s;
}

/* The rows in reach that have anything, from the top. */
static int rows_around(block *b, int row, const swept_row **rows, int *dys)
{
    int n = 0, reach = b->job->reach;
    for (int dy = -reach; dy <= reach; dy++) {
        if (row + dy < 0 || row + dy >= b->job->height)
            continue;
        const swept_row *s = row_around(b, row + dy);
        if (!s->any)
            continue;
        rows[n] = s;
        dys[n++] = dy;
    }
    return n;
}

static int next_missing(const uint8_t *flags, int x, int end)
{
    for (; x + 8 <= end; x += 8) {
        uint64_t eight;
        memcpy(&eight, flags + x, sizeof eight);
        if (eight)
            break;
    }
    while (x < end && !flags[x])
        x++;
    return x;
}

/* Copies the nearest pixel; rows come from the top and the left one of a row is swept first, so that the first of equals
 * wins. Only pixels that are there are read and only missing ones written: in place is safe, on any thread. */
static bool fill_pixel(const block *b, int row, int x, const swept_row *const *rows, const int *dys, int n_rows)
{
    const fill_job *job = b->job;
    int nearest = job->reach * job->reach + 1, dx = 0, dy = 0;
    for (int i = 0; i < n_rows; i++) {
        int along = rows[i]->dx[x - b->x0], distance = along * along + dys[i] * dys[i];
        if (along != NONE && distance < nearest) {
            nearest = distance;
            dx = along;
            dy = dys[i];
        }
    }
    if (nearest > job->reach * job->reach)
        return false;
    size_t from = start_of(job, row + dy, b->view) + (size_t)(x + dx), to = start_of(job, row, b->view) + (size_t)x;
    memcpy(job->filled + to * 3, job->rgb + from * 3, 3);
    return true;
}

static int64_t fill_row(block *b, int row)
{
    const fill_job *job = b->job;
    size_t start = start_of(job, row, b->view);
    const uint8_t *flags = job->missing + start;
    int end = b->x0 + b->n;
    if (job->filled != job->rgb)
        memcpy(job->filled + (start + (size_t)b->x0) * 3, job->rgb + (start + (size_t)b->x0) * 3, (size_t)b->n * 3);
    int x = next_missing(flags, b->x0, end);
    if (x == end)
        return 0;
    const swept_row *rows[2 * MAX_REACH + 1];
    int dys[2 * MAX_REACH + 1], n_rows = rows_around(b, row, rows, dys);
    int64_t n_unfilled = 0;
    for (; x < end; x = next_missing(flags, x + 1, end))
        n_unfilled += !fill_pixel(b, row, x, rows, dys, n_rows);
    return n_unfilled;
}

static void fill_view(void *context, int view, int worker)
{
    (void)worker;
    fill_job *job = context;
    block b = {.job = job, .view = view};
    int64_t n_unfilled = 0;
    for (b.x0 = 0; b.x0 < job->width; b.x0 += BLOCK_PX) {
        b.n = job->width - b.x0 < BLOCK_PX ? job->width - b.x0 : BLOCK_PX;
        for (int i = 0; i < 2 * MAX_REACH + 1; i++)
            b.swept[i].row = -1;
        for (int row = 0; row < job->height; row++)
            n_unfilled += fill_row(&b, row);
    }
    /* a sum: no order is needed, and the end of the run publishes it */
    atomic_fetch_add_explicit(&job->n_unfilled, n_unfilled, memory_order_relaxed);
}

int64_t lf_fill(int n_views, int width, int height, const uint8_t *rgb, const uint8_t *missing, int reach, uint8_t *filled,
                lf_pool *pool)
{
    fill_job job = {.n_views = n_views, .width = width, .height = height, .rgb = rgb, .missing = missing};
    job.filled = filled;
    job.reach = reach < 0 ? 0 : reach > MAX_REACH ? MAX_REACH : reach;
    bool done = pool && lf_pool_run(pool, n_views, fill_view, &job, NULL) == LF_OK;
    for (int view = 0; view < n_views && !done; view++)
        fill_view(&job, view, 0);
    return atomic_load_explicit(&job.n_unfilled, memory_order_relaxed);
}
