#include "render/papers/variation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

/* Rows on both sides that a row's map is made of. */
enum { NEIGHBOURS = 2 };

/* How many differences a tile has: those at the end are smaller. */
static int differences_of(const lf_counts *counts, int tile)
{
    int view = tile / counts->tiles_across * LF_COUNTS_VIEWS,
        column = tile % counts->tiles_across * LF_COUNTS_COLUMNS,
        down = counts->n_views - view < LF_COUNTS_VIEWS ? counts->n_views - view : LF_COUNTS_VIEWS,
        across = counts->width - 1 - column < LF_COUNTS_COLUMNS ? counts->width - 1 - column
                                                                : LF_COUNTS_COLUMNS;
    return across > 0 ? down * across : down;
}

/* For a row, [tile of views][tile of columns]: the mean of |difference| of the error estimate from
 * one column to the next. */
static void row_variation(const lf_film *film, const lf_counts *counts, int row, float *error,
                          float *out)
{
    int width = counts->width, views = counts->n_views, across = counts->tiles_across;
    lf_film_row_errors(film, row, error, error + (size_t)views * (size_t)width);
    for (int i = 0; i < counts->tiles_down * across; i++)
        out[i] = 0.0f;
    for (int view = 0; view < views; view++)
        for (int column = 0; column + 1 < width; column++) {
            const float *at = error + (size_t)view * (size_t)width + (size_t)column;
            out[lf_counts_tile(counts, view, column)] += fabsf(at[1] - at[0]);
        }
    for (int i = 0; i < counts->tiles_down * across; i++)
        out[i] /= (float)differences_of(counts, i);
}

/* For tile i of a row, from the neighbouring rows and tiles; *out_delta: these have met a delta
 * lobe. */
static double pooled(const lf_counts *counts, const float *variation, int row, int i,
                     bool *out_delta)
{
    int across = counts->tiles_across, tiles = counts->tiles_down * across;
    double sum = 0.0, n = 0.0;
    *out_delta = false;
    for (int r = row - NEIGHBOURS; r <= row + NEIGHBOURS; r++)
        for (int j = -1; j <= 1; j++) {
            int x = i % across + j;
            if (r < 0 || r >= counts->height || r == row || x < 0 || x >= across)
                continue;
            double weight = (NEIGHBOURS + 1 - abs(r - row)) * (2 - abs(j));
            int at = r * tiles + i - i % across + x;
            sum += weight * (double)variation[at];
            *out_delta |= counts->delta[at];
            n += weight;
        }
    return n > 0.0 ? sum / n : 0.0;
}

/* Scales the mean of a pass to one sample per pixel, judged by the other rows. */
static double mean_without(const double *sums, int height, int row)
{
    double sum = 0.0;
    int n = 0;
    for (int r = 0; r < height; r++) {
        sum += abs(r - row) > NEIGHBOURS ? sums[r] : 0.0;
        n += abs(r - row) > NEIGHBOURS;
    }
    return n > 0 ? sum / n : 0.0;
}

/* In tiles with a delta lobe, native samples are the only samples: a plain sum, to which their
 * number must not add noise. */
static void fill(lf_counts *counts, const float *variation, double *sums)
{
    const double least = 0.125, most = 16.0;
    int tiles = counts->tiles_down * counts->tiles_across;
    bool delta;
    for (int row = 0; row < counts->height; row++)
        for (int i = 0; i < tiles; i++)
            sums[row] += pooled(counts, variation, row, i, &delta) / tiles;
    for (int row = 0; row < counts->height; row++) {
        double mean = mean_without(sums, counts->height, row);
        for (int i = 0; i < tiles; i++) {
            double own = pooled(counts, variation, row, i, &delta),
                   count = least + (1.0 - least) * (mean > 0.0 ? own / mean : 1.0);
            counts->tile[row * tiles + i] = (float)fmin(fmax(count, delta ? 1.0 : least), most);
        }
    }
}

/* A restored film does not store where its pilot met delta lobes, so any tile may have them. */
static void assume_delta(const lf_film *film, lf_counts *counts, size_t n)
{
    if (film->layout.has_delta && !memchr(counts->delta, 1, n))
        memset(counts->delta, 1, n);
}

lf_status lf_variation_map(const lf_film *film, lf_counts *counts)
{
    size_t tiles = (size_t)counts->tiles_down * (size_t)counts->tiles_across;
    float *variation = lf_calloc(tiles * (size_t)counts->height, sizeof *variation),
          *error = lf_calloc(2 * (size_t)counts->n_views * (size_t)counts->width, sizeof *error);
    double *sums = lf_calloc((size_t)counts->height, sizeof *sums);
    lf_status status = variation && error && sums ? LF_OK : LF_E_NOMEM;
    for (int row = 0; status == LF_OK && row < counts->height; row++)
        row_variation(film, counts, row, error, variation + (size_t)row * tiles);
    assume_delta(film, counts, tiles * (size_t)counts->height);
    if (status == LF_OK)
        fill(counts, variation, sums);
    lf_free(variation);
    lf_free(error);
    lf_free(sums);
    return status;
}
