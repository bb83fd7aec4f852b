#include <assert.h>
#include <string.h>

#include "quilt/quilt.h"

#define MAX_TILES 256 /* per side */
#define MIN_TILE_PX 64

/* The differing tiles of a frame; on the stack, so that steady state allocates nothing. */
typedef struct tile_grid {
    int columns, rows; /* 1..MAX_TILES */
    int tile_px;
    bool changed[MAX_TILES][MAX_TILES]; /* [row][column] */
} tile_grid;

typedef struct frame_pair {
    const lf_image8 *before, *after;
} frame_pair;

/* True if the pixels [x0, x1) of a row differ. */
static bool differ(const frame_pair *f, int y, int x0, int x1)
{
    size_t channels = (size_t)f->after->channels, from = (size_t)x0 * channels;
    return memcmp(f->before->data + (size_t)y * f->before->stride + from,
                  f->after->data + (size_t)y * f->after->stride + from,
                  (size_t)(x1 - x0) * channels) != 0;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Reads unchanged tiles once, and no more of a tile that is known to have changed. */
static void mark_row(const frame_pair *f, tile_grid *grid, int y, int *n_left)
{
    bool *changed = grid->changed[y / grid->tile_px];
    if (*n_left == 0 || !differ(f, y, 0, f->after->width))
        return;
    for (int c = 0; c < grid->columns; c++) {
        int x0 = c * grid->tile_px, x1 = least(x0 + grid->tile_px, f->after->width);
        if (!changed[c] && differ(f, y, x0, x1)) {
            changed[c] = true;
            (*n_left)--;
        }
    }
}

static void mark_tiles(const frame_pair *f, tile_grid *grid)
{
    int longest = f->after->width > f->after->height ? f->after->width : f->after->height;
    grid->tile_px = MIN_TILE_PX;
    while ((longest + grid->tile_px - 1) / grid->tile_px > MAX_TILES)
        grid->tile_px *= 2;
    grid->columns = (f->after->width + grid->tile_px - 1) / grid->tile_px;
    grid->rows = (f->after->height + grid->tile_px - 1) / grid->tile_px;
    for (int r = 0; r < grid->rows; r++) {
        memset(grid->changed[r], 0, (size_t)grid->columns);
        int n_left = grid->columns;
        int last = least((r + 1) * grid->tile_px, f->after->height);
        for (int y = r * grid->tile_px; y < last; y++)
            mark_row(f, grid, y, &n_left);
    }
}

/* Doubles the tile size; a tile has changed if one of its four had. */
static void coarsen(tile_grid *grid)
{
    int columns = (grid->columns + 1) / 2, rows = (grid->rows + 1) / 2;
    for (int r = 0; r < rows; r++) {
        for (int c = 0; c < columns; c++) {
            bool any = false;
            for (int k = 0; k < 4; k++) {
                int from_r = 2 * r + k / 2, from_c = 2 * c + k % 2;
                any = any || (from_r < grid->rows && from_c < grid->columns &&
                              grid->changed[from_r][from_c]);
            }
            grid->changed[r][c] = any;
        }
    }
    grid->columns = columns;
    grid->rows = rows;
    grid->tile_px *= 2;
}

/* Adds a run of tiles, or extends the rectangle just above it with the same columns. */
static bool add_run(lf_rect *rects, int *n, int max_rects, int x, int y, int width)
{
    for (int i = *n - 1; i >= 0; i--) {
        if (rects[i].x == x && rects[i].width == width && rects[i].y + rects[i].height == y) {
            rects[i].height++;
            return true;
        }
    }
    if (*n == max_rects)
        return false;
    rects[(*n)++] = (lf_rect){x, y, width, 1};
    return true;
}

/* Covers the changed tiles exactly with rectangles; -1: more than max_rects. */
static int cover(const tile_grid *grid, lf_rect *rects, int max_rects)
{
    int n = 0;
    for (int r = 0; r < grid->rows; r++) {
        for (int c = 0; c < grid->columns; c++) {
            int start = c;
            while (c < grid->columns && grid->changed[r][c])
                c++;
            if (c > start && !add_run(rects, &n, max_rects, start, r, c - start))
                return -1;
        }
    }
    return n;
}

/* Converts tiles to pixels, and shrinks all sides to the outermost differences. */
static void tighten(const frame_pair *f, int tile_px, lf_rect *rect)
{
    int x0 = rect->x * tile_px, x1 = least((rect->x + rect->width) * tile_px, f->after->width);
    int y0 = rect->y * tile_px, y1 = least((rect->y + rect->height) * tile_px, f->after->height);
    while (y0 < y1 && !differ(f, y0, x0, x1))
        y0++;
    while (y1 > y0 && !differ(f, y1 - 1, x0, x1))
        y1--;
    int left = x1, right = x0;
    for (int y = y0; y < y1; y++) {
        if (left > x0 && differ(f, y, x0, left))
            for (left = x0; !differ(f, y, left, left + 1);)
                left++;
        if (right < x1 && differ(f, y, right, x1))
            for (right = x1; !differ(f, y, right - 1, right);)
                right--;
    }
    *rect = (lf_rect){left, y0, right - left, y1 - y0};
}

int lf_changed_rects(const lf_image8 *before, const lf_image8 *after, lf_rect *out_rects,
                     int max_rects)
{
    assert(before->width == after->width && before->height == after->height &&
           before->channels == after->channels);
    assert(max_rects >= 1);
    frame_pair f = {before, after};
    tile_grid grid;
    mark_tiles(&f, &grid);
    int n = cover(&grid, out_rects, max_rects);
    while (n < 0) {
        coarsen(&grid);
        n = cover(&grid, out_rects, max_rects);
    }
    for (int i = 0; i < n; i++)
        tighten(&f, grid.tile_px, &out_rects[i]);
    return n;
}
