/* Parallax between simulated views. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/proof/study.h"

/* Of squares of differences, per pixel: below, a block has no structure. Brightness is 0..1. */
#define LEAST_STRUCTURE 1e-4
/* The same, between two views without structure: above, they are of different images. */
#define MOST_UNLIKE 1e-2
/* What may remain after matching, as a share of the structure. */
#define MOST_LEFT 0.4
/* Shift in front of the print that counts at its edge, in lenses. */
#define IN_FRONT 0.25
enum { VIEWS = 3, BLOCK = LF_PROOF_BLOCK, CELL = LF_PROOF_CELL, SEARCH = LF_PROOF_SEARCH };

/* Brightness of a view, about as eyes see it; across the lenses first. */
typedef struct view {
    int n, n_lines; /* pixels across the lenses, and lines */
    float *value;   /* [n_lines][n] */
} view;

static lf_status take_view(const lf_image32 *image, bool horizontal, view *out)
{
    out->n = horizontal ? image->height : image->width;
    out->n_lines = horizontal ? image->width : image->height;
    out->value = lf_calloc((size_t)out->n * (size_t)out->n_lines, sizeof *out->value);
    if (!out->value)
        return LF_E_NOMEM;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            const float *p = image->data + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
            const int i = horizontal ? y : x, line = horizontal ? x : y;
            out->value[(size_t)line * (size_t)out->n + (size_t)i] =
                sqrtf(0.2126F * p[0] + 0.7152F * p[1] + 0.0722F * p[2]);
        }
    return LF_OK;
}

static double at(const view *v, int line, int i)
{
    i = i < 0 ? 0 : i >= v->n ? v->n - 1 : i;
    return (double)v->value[(size_t)line * (size_t)v->n + (size_t)i];
}

/* Mean square of what a shift leaves of a square. */
static double left_over(const view *a, const view *b, int i0, int line0, int side, int shift)
{
    double sum = 0.0;
    for (int line = line0; line < line0 + side; line++)
        for (int i = i0; i < i0 + side; i++) {
            const double d = at(a, line, i) - at(b, line, i + shift);
            sum += d * d;
        }
    return sum / (side * side);
}

static double structure(const view *a, int i0, int line0)
{
    double sum = 0.0;
    for (int line = line0; line < line0 + BLOCK; line++)
        for (int i = i0; i < i0 + BLOCK; i++) {
            const double d = at(a, line, i + 1) - at(a, line, i);
            sum += d * d;
        }
    return sum / (BLOCK * BLOCK);
}

typedef enum match { NOTHING, MATCHED, UNLIKE } match;

/* The shift of a block from a to b. */
static match match_block(const view *a, const view *b, int i0, int line0, double *out_shift)
{
    double cost[2 * SEARCH + 1];
    int best = 0;
    if (structure(a, i0, line0) < LEAST_STRUCTURE)
        return left_over(a, b, i0, line0, BLOCK, 0) < MOST_UNLIKE ? NOTHING : UNLIKE;
    double mean = 0.0;
    for (int s = 0; s <= 2 * SEARCH; s++) {
        cost[s] = left_over(a, b, i0, line0, BLOCK, s - SEARCH);
        mean += cost[s] / (2 * SEARCH + 1);
        best = cost[s] < cost[best] ? s : best;
    }
    if (best == 0 || best == 2 * SEARCH || cost[best] > MOST_LEFT * mean)
        return UNLIKE;
    const double before = cost[best - 1], after = cost[best + 1];
    const double bend = before - 2.0 * cost[best] + after;
    *out_shift = best - SEARCH + (bend > 0.0 ? 0.5 * (before - after) / bend : 0.0);
    return MATCHED;
}

/* ------------------------------------------------------------------------------------ blocks -- */

static void note_cut(lf_proof_depth *d, bool horizontal, int column, int row, double shift)
{
    if (shift > -IN_FRONT)
        return;
    /* only edges across the lenses move against the picture */
    if (horizontal) {
        d->cut[2] |= row == 0;
        d->cut[3] |= row == d->rows - 1;
    } else {
        d->cut[0] |= column == 0;
        d->cut[1] |= column == d->columns - 1;
    }
}

/* Marks what a block's shift explains, and no shift does not. */
static void mark_cells(const view *a, const view *b, bool horizontal, int across, int line,
                       double shift, lf_proof_depth *d)
{
    const int n = BLOCK / CELL;
    for (int k = 0; k < n * n; k++) {
        const int i = across * BLOCK + k % n * CELL, l = line * BLOCK + k / n * CELL;
        const double still = left_over(a, b, i, l, CELL, 0);
        const int x = (horizontal ? l : i) / CELL, y = (horizontal ? i : l) / CELL;
        if (still > LEAST_STRUCTURE &&
            left_over(a, b, i, l, CELL, (int)lround(shift)) < MOST_LEFT * still)
            d->doubled[(size_t)y * (size_t)(d->columns * n) + (size_t)x] = 1;
    }
}

static void match_all(const view views[VIEWS], int n_views, bool horizontal, lf_proof_depth *d)
{
    int n_matched = 0, n_unlike = 0, n_over = 0;
    for (int row = 0; row < d->rows; row++)
        for (int column = 0; column < d->columns; column++) {
            const int across = horizontal ? row : column, line = horizontal ? column : row;
            double found = NAN;
            bool unlike = false;
            for (int k = 0; k + 1 < n_views; k++) {
                double shift;
                const match m =
                    match_block(&views[k], &views[k + 1], across * BLOCK, line * BLOCK, &shift);
                unlike |= m == UNLIKE;
                if (m == MATCHED && fabs(shift) > 1.0)
                    mark_cells(&views[k], &views[k + 1], horizontal, across, line, shift, d);
                if (m == MATCHED && !(fabs(shift) <= fabs(found)))
                    found = shift;
            }
            d->shift[(size_t)row * (size_t)d->columns + (size_t)column] = (float)found;
            n_matched += !isnan(found);
            n_unlike += isnan(found) && unlike;
            if (isnan(found))
                continue;
            n_over += fabs(found) > 1.0;
            d->most = fmax(d->most, fabs(found));
            note_cut(d, horizontal, column, row, found);
        }
    d->measured = n_matched + n_unlike > 0 ? (double)n_matched / (n_matched + n_unlike) : 1.0;
    d->over = n_matched > 0 ? (double)n_over / n_matched : 0.0;
}

/* Views around the middle one. */
static lf_status see_views(lf_print_file *file, const lf_proof_sheet *sheet, double distance_mm,
                           lf_proof_depth *d, view views[VIEWS], int n_views,
                           const lf_cancel *cancel, lf_error *err)
{
    for (int k = 0; k < n_views; k++) {
        const int view_seen = sheet->n_views / 2 - 1 + k;
        const double share = (view_seen - 0.5 * (sheet->n_views - 1)) / sheet->n_views;
        const double at_mm = lf_proof_eye_at(sheet, distance_mm, share);
        const lf_eye eye = {sheet->horizontal ? 0.0 : at_mm, sheet->horizontal ? at_mm : 0.0,
                            distance_mm};
        lf_image32 image;
        lf_status status =
            lf_proof_picture(file, sheet, &eye, d->width, d->height, cancel, &image, err);
        if (status != LF_OK)
            return status;
        status = take_view(&image, sheet->horizontal, &views[k]);
        lf_image32_finish(&image);
        if (status != LF_OK)
            return lf_error_set(err, LF_E_NOMEM, "proof", "out of memory");
    }
    return LF_OK;
}

lf_status lf_proof_depth_of(lf_print_file *file, const lf_proof_sheet *sheet, double distance_mm,
                            const lf_cancel *cancel, lf_proof_depth *out, lf_error *err)
{
    view views[VIEWS] = {{0}};
    const int n_views = sheet->n_views < VIEWS ? sheet->n_views : VIEWS;
    *out = (lf_proof_depth){0};
    lf_status status = lf_proof_size(sheet, 0, &out->width, &out->height, err);
    if (status != LF_OK)
        return status;
    out->columns = out->width / BLOCK;
    out->rows = out->height / BLOCK;
    out->shift = lf_calloc((size_t)out->columns * (size_t)out->rows + 1, sizeof *out->shift);
    out->doubled =
        lf_calloc((size_t)out->columns * (size_t)out->rows + 1, (BLOCK / CELL) * (BLOCK / CELL));
    status = out->shift && out->doubled
                 ? see_views(file, sheet, distance_mm, out, views, n_views, cancel, err)
                 : lf_error_set(err, LF_E_NOMEM, "proof", "out of memory");
    if (status == LF_OK)
        match_all(views, n_views, sheet->horizontal, out);
    for (int k = 0; k < VIEWS; k++)
        lf_free(views[k].value);
    if (status != LF_OK)
        lf_proof_depth_finish(out);
    return status;
}

void lf_proof_depth_finish(lf_proof_depth *depth)
{
    lf_free(depth->shift);
    lf_free(depth->doubled);
    *depth = (lf_proof_depth){0};
}

/* ------------------------------------------------------------------------------------- marks -- */

static bool is_over(const lf_proof_depth *d, const lf_image32 *image, int x, int y)
{
    const int n_columns = d->columns * (BLOCK / CELL), n_rows = d->rows * (BLOCK / CELL);
    const int column = (int)((double)x * d->width / image->width) / CELL,
              row = (int)((double)y * d->height / image->height) / CELL;
    return column < n_columns && row < n_rows &&
           d->doubled[(size_t)row * (size_t)n_columns + (size_t)column];
}

void lf_proof_depth_mark(const lf_proof_depth *d, lf_image32 *image)
{
    const int edge = 2 + image->width / 200;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            float *p = image->data + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
            const bool cut = (d->cut[0] && x < edge) || (d->cut[1] && x >= image->width - edge) ||
                             (d->cut[2] && y < edge) || (d->cut[3] && y >= image->height - edge);
            if (cut)
                memcpy(p, (const float[3]){0.0F, 0.1F, 1.0F}, 3 * sizeof *p);
            else if ((x + y) % 8 < 2 && is_over(d, image, x, y))
                memcpy(p, (const float[3]){1.0F, 0.0F, 0.0F}, 3 * sizeof *p);
        }
}
