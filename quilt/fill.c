#include <string.h>

#include "quilt/quilt.h"

#define MAX_REACH 16
#define MAX_OFFSETS ((2 * MAX_REACH + 1) * (2 * MAX_REACH + 1))

/* Where to look, nearest first. */
typedef struct offset {
    int8_t dx, dy;
} offset;

typedef struct fill_job {
    int n_views, width, height, reach, n_offsets;
    const uint8_t *rgb, *missing;
    uint8_t *filled;
    offset offsets[MAX_OFFSETS];
    atomic_int_least64_t n_unfilled;
} fill_job;

/* Sorted by distance, then row, then column: rows and columns rise as they are listed, and insertion keeps equals in order. */
static int list_offsets(int reach, offset *offsets)
{
    int n = 0;
    for (int dy = -reach; dy <= reach; dy++) {
        for (int dx = -reach; dx <= reach; dx++) {
            int d = dx * dx + dy * dy;
            if (d == 0 || d > reach * reach)
                continue;
            int i = n++;
            for (; i > 0 && offsets[i - 1].dx * offsets[i - 1].dx + offsets[i - 1].dy * offsets[i - 1].dy > d; i--)
                offsets[i] = offsets[i - 1];
            offsets[i] = (offset){(int8_t)dx, (int8_t)dy};
        }
    }
    return n;
}

static const uint8_t *flags_of(const fill_job *job, int row, int view)
{
    return job->missing + ((size_t)row * (size_t)job->n_views + (size_t)view) * (size_t)job->width;
}

/* Keeps the offsets that lead to rows with anything in them: where whole rows are missing, which is what a coarse frame looks
 * like, the first one left is then at once the right one. */
static int useful_offsets(const fill_job *job, int row, int view, offset *useful)
{
    bool has[2 * MAX_REACH + 1];
    for (int dy = -job->reach; dy <= job->reach; dy++) {
        int y = row + dy;
        has[dy + job->reach] = y >= 0 && y < job->height && memchr(flags_of(job, y, view), 0, (size_t)job->width) != NULL;
    }
    int n = 0;
    for (int i = 0; i < job->n_offsets; i++)
        if (has[job->offsets[i].dy + job->reach])
            useful[n++] = job->offsets[i];
    return n;
}

/* Pixels from the flag at x to that of the nearest pixel found: in rows of views, as they lie; 0 when there is none. */
static ptrdiff_t find(const fill_job *job, const uint8_t *flags, int x, const offset *offsets, int n)
{
    ptrdiff_t pitch = (ptrdiff_t)job->n_views * job->width;
    for (int i = 0; i < n; i++) {
        int to_x = x + offsets[i].dx;
        if (to_x < 0 || to_x >= job->width)
            continue;
        ptrdiff_t way = offsets[i].dy * pitch + offsets[i].dx;
        if (!flags[x + way])
            return way;
    }
    return 0;
}

static int next_missing(const uint8_t *flags, int x, int width)
{
    for (; x + 8 <= width; x += 8) {
        uint64_t eight;
        memcpy(&eight, flags + x, sizeof eight);
        if (eight)
            break;
    }
    while (x < width && !flags[x])
        x++;
    return x;
}

/* Reads only pixels that are there and writes only those that are missing: in place is safe, on any thread. */
static int64_t fill_row_of_view(const fill_job *job, int row, int view)
{
    const uint8_t *flags = flags_of(job, row, view);
    size_t start = (size_t)(flags - job->missing);
    if (job->filled != job->rgb)
        memcpy(job->filled + start * 3, job->rgb + start * 3, (size_t)job->width * 3);
    int x = next_missing(flags, 0, job->width);
    if (x == job->width)
        return 0;
    offset useful[MAX_OFFSETS];
    int n = useful_offsets(job, row, view, useful);
    int64_t n_unfilled = 0;
    for (; x < job->width; x = next_missing(flags, x + 1, job->width)) {
        ptrdiff_t way = find(job, flags, x, useful, n);
        if (way == 0) {
            n_unfilled++;
            continue;
        }
        size_t to = start + (size_t)x;
        memcpy(job->filled + to * 3, job->rgb + (size_t)((ptrdiff_t)to + way) * 3, 3);
    }
    return n_unfilled;
}

static void fill_row(void *context, int row, int worker)
{
    (void)worker;
    fill_job *job = context;
    int64_t n_unfilled = 0;
    for (int view = 0; view < job->n_views; view++)
        n_unfilled += fill_row_of_view(job, row, view);
    /* a sum: no order is needed, and the end of the run publishes it */
    atomic_fetch_add_explicit(&job->n_unfilled, n_unfilled, memory_order_relaxed);
}

int64_t lf_fill(int n_views, int width, int height, const uint8_t *rgb, const uint8_t *missing, int reach, uint8_t *filled,
                lf_pool *pool)
{
    fill_job job = {.n_views = n_views, .width = width, .height = height, .rgb = rgb, .missing = missing, .filled = filled};
    job.reach = reach < 0 ? 0 : reach > MAX_REACH ? MAX_REACH : reach;
    job.n_offsets = list_offsets(job.reach, job.offsets);
    bool done = pool && lf_pool_run(pool, height, fill_row, &job, NULL) == LF_OK;
    for (int row = 0; row < height && !done; row++)
        fill_row(&job, row, 0);
    return atomic_load_explicit(&job.n_unfilled, memory_order_relaxed);
}
