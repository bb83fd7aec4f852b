/* Expected counts of base samples, and the map of amvpt. */
#include "render/rows/adaptive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

/* A tile of one row. The pilot estimates a pixel's error from a single difference between halves; a
 * tile and its neighbours contain enough of them. */
enum { NEIGHBOURS = 2 };

/* ------------------------------------------------------------------------------------ counts -- */

lf_status lf_counts_init(lf_counts *counts, int n_views, int width, int height)
{
    *counts = (lf_counts){.n_views = n_views, .width = width, .height = height};
    counts->tiles_down = (n_views + LF_COUNTS_VIEWS - 1) / LF_COUNTS_VIEWS;
    counts->tiles_across = (width + LF_COUNTS_COLUMNS - 1) / LF_COUNTS_COLUMNS;
    size_t n = (size_t)height * (size_t)counts->tiles_down * (size_t)counts->tiles_across;
    counts->tile = lf_calloc(n, sizeof *counts->tile);
    counts->delta = lf_calloc(n, sizeof *counts->delta);
    for (size_t i = 0; counts->tile && i < n; i++)
        counts->tile[i] = 1.0f;
    if (counts->tile && counts->delta)
        return LF_OK;
    lf_counts_finish(counts);
    return LF_E_NOMEM;
}

void lf_counts_finish(lf_counts *counts)
{
    lf_free(counts->tile);
    lf_free(counts->delta);
    *counts = (lf_counts){0};
}

size_t lf_counts_words(const lf_counts *counts)
{
    return ((size_t)counts->n_views * (size_t)counts->width + 63) / 64;
}

static size_t row_start(const lf_counts *counts, int row)
{
    return (size_t)row * (size_t)counts->tiles_down * (size_t)counts->tiles_across;
}

size_t lf_counts_tile(const lf_counts *counts, int view, int column)
{
    return (size_t)(view / LF_COUNTS_VIEWS) * (size_t)counts->tiles_across +
           (size_t)(column / LF_COUNTS_COLUMNS);
}

void lf_counts_mark_delta(const lf_counts *counts, int row, int view, int column)
{
    counts->delta[row_start(counts, row) + lf_counts_tile(counts, view, column)] = 1;
}

void lf_counts_row(const lf_counts *counts, int row, float *out)
{
    size_t pixels = (size_t)counts->n_views * (size_t)counts->width;
    const float *tiles = counts->tile ? counts->tile + row_start(counts, row) : NULL;
    const uint64_t *wanted =
        counts->wanted ? counts->wanted + (size_t)row * lf_counts_words(counts) : NULL;
    for (int view = 0; view < counts->n_views; view++) {
        for (int column = 0; column < counts->width; column++) {
            size_t pixel = (size_t)view * (size_t)counts->width + (size_t)column;
            out[pixel] = tiles ? tiles[lf_counts_tile(counts, view, column)] : 1.0f;
        }
    }
    for (size_t pixel = 0; wanted && pixel < pixels; pixel++)
        out[pixel] = wanted[pixel / 64] >> (pixel % 64) & 1 ? out[pixel] : 0.0f;
}

/* --------------------------------------------------------------------------------------- map -- */

/* The pilot's statistics of a tile: sums over its pixels. */
typedef struct lf_pilot_tile {
    float error, q, pixels;
    bool delta;
} lf_pilot_tile;

typedef struct lf_map_job {
    const lf_film *film;
    lf_counts *counts;
    lf_pilot_tile *pilot; /* [row][tile of views][tile of columns] */
    float *least;         /* [row][tile of views][tile of columns] smallest count */
    /* [row][tile of views][tile of columns] of the tile's neighbourhood, without its own row */
    double *merit;
    double *spent; /* [row] cost of the sample counts by merit … */
    double *cost;  /* [row] … and of one sample per pixel */
    atomic_bool failed;
} lf_map_job;

static lf_pilot_tile *row_pilot(const lf_map_job *job, int row)
{
    return job->pilot + row_start(job->counts, row);
}

/* Cost of a base sample in the tile, in units of one that finds a pivot. */
static double cost_of(const lf_pilot_tile *tile)
{
    const double empty = 0.25;
    return tile->pixels > 0.0f ? empty + (1.0 - empty) * (double)(tile->q / tile->pixels) : 1.0;
}

static void read_row(void *context, int row, int worker)
{
    lf_map_job *job = context;
    const lf_counts *counts = job->counts;
    size_t pixels = (size_t)counts->n_views * (size_t)counts->width;
    float *error = lf_calloc(2 * pixels, sizeof *error);
    lf_pilot_tile *tiles = row_pilot(job, row);
    (void)worker;
    if (!error) {
        atomic_store(&job->failed, true);
        return;
    }
    float *q = error + pixels;
    lf_film_row_errors(job->film, row, error, q);
    for (size_t i = 0; i < pixels; i++) {
        int view = (int)(i / (size_t)counts->width), column = (int)(i % (size_t)counts->width);
        lf_pilot_tile *tile = &tiles[lf_counts_tile(counts, view, column)];
        tile->error += error[i];
        tile->q += q[i];
        tile->pixels += 1.0f;
    }
    for (int i = 0; i < counts->tiles_down * counts->tiles_across; i++)
        tiles[i].delta = counts->delta[row_start(counts, row) + (size_t)i];
    lf_free(error);
}

/* A tile's pilot with its neighbours', rows above and below but not its own. */
static lf_pilot_tile pooled(const lf_map_job *job, int row, int down, int across)
{
    const lf_counts *counts = job->counts;
    lf_pilot_tile sum = {0};
    for (int r = row - NEIGHBOURS; r <= row + NEIGHBOURS; r++) {
        if (r < 0 || r >= counts->height || r == row)
            continue;
        for (int i = -1; i <= 1; i++) {
            for (int j = -1; j <= 1; j++) {
                int y = down + i, x = across + j;
                if (y < 0 || y >= counts->tiles_down || x < 0 || x >= counts->tiles_across)
                    continue;
                const lf_pilot_tile *tile = row_pilot(job, r) + y * counts->tiles_across + x;
                float weight =
                    (float)((NEIGHBOURS + 1 - abs(r - row)) * (2 - abs(i)) * (2 - abs(j)));
                sum.error += weight * tile->error;
                sum.q += weight * tile->q;
                sum.pixels += weight * tile->pixels;
                sum.delta |= tile->delta;
            }
        }
    }
    return sum;
}

/* With error/count to be lost and count x cost to be spent, counts in proportion to sqrt(error /
 * cost) are best. */
static void judge_row(void *context, int row, int worker)
{
    lf_map_job *job = context;
    const lf_counts *counts = job->counts;
    int n = counts->tiles_down * counts->tiles_across;
    (void)worker;
    for (int i = 0; i < n; i++) {
        lf_pilot_tile tile = pooled(job, row, i / counts->tiles_across, i % counts->tiles_across);
        double cost = cost_of(&tile),
               error = tile.pixels > 0.0f ? (double)(tile.error / tile.pixels) : 0.0;
        job->merit[row_start(counts, row) + (size_t)i] = sqrt(error / cost);
        /* In tiles with a delta lobe, native samples are the only samples: a plain sum, to which
         * their number must not add noise. */
        job->least[row_start(counts, row) + (size_t)i] = tile.delta ? 1.0f : 0.125f;
        job->spent[row] += sqrt(error / cost) * cost;
        job->cost[row] += cost;
    }
}

/* Converts merits to counts. They are scaled so that a pass costs the same as without a map, judged
 * by rows on which this row's pilot has no influence. */
static void map_row(void *context, int row, int worker)
{
    const lf_map_job *job = context;
    const lf_counts *counts = job->counts;
    const double most = 16.0;
    double spent = 0.0, cost = 0.0;
    (void)worker;
    for (int r = 0; r < counts->height; r++) {
        spent += abs(r - row) > NEIGHBOURS ? job->spent[r] : 0.0;
        cost += abs(r - row) > NEIGHBOURS ? job->cost[r] : 0.0;
    }
    for (size_t i = row_start(counts, row); i < row_start(counts, row + 1); i++) {
        double least = (double)job->least[i],
               count = spent > 0.0 ? job->merit[i] * cost / spent : 1.0;
        counts->tile[i] = (float)fmin(fmax(least, 0.125 + 0.875 * count), most);
    }
}

bool lf_adaptive_ready(const lf_film *film)
{
    for (int row = 0; row < film->height; row++)
        if (film->rows[row].n[0] < LF_PILOT_SPP || film->rows[row].n[1] < LF_PILOT_SPP)
            return false;
    return film->height > 2 * NEIGHBOURS + 1;
}

/* A restored film does not store where its pilot met delta lobes, so any tile may have them. */
static void assume_delta(const lf_film *film, const lf_counts *counts)
{
    size_t n = row_start(counts, counts->height);
    if (film->layout.has_delta && !memchr(counts->delta, 1, n))
        memset(counts->delta, 1, n);
}

lf_status lf_adaptive_map(const lf_film *film, lf_pool *pool, lf_counts *counts)
{
    size_t tiles =
        (size_t)counts->tiles_down * (size_t)counts->tiles_across * (size_t)counts->height;
    lf_map_job job = {.film = film, .counts = counts};
    lf_status status = LF_E_NOMEM;
    atomic_init(&job.failed, false);
    assume_delta(film, counts);
    job.pilot = lf_calloc(tiles, sizeof *job.pilot);
    job.merit = lf_calloc(tiles, sizeof *job.merit);
    job.least = lf_calloc(tiles, sizeof *job.least);
    job.spent = lf_calloc((size_t)film->height, sizeof *job.spent);
    job.cost = lf_calloc((size_t)film->height, sizeof *job.cost);
    if (job.pilot && job.merit && job.least && job.spent && job.cost)
        status = lf_pool_run(pool, film->height, read_row, &job, NULL);
    if (status == LF_OK && atomic_load(&job.failed))
        status = LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_pool_run(pool, film->height, judge_row, &job, NULL);
    if (status == LF_OK)
        status = lf_pool_run(pool, film->height, map_row, &job, NULL);
    lf_free(job.pilot);
    lf_free(job.merit);
    lf_free(job.least);
    lf_free(job.spent);
    lf_free(job.cost);
    return status;
}
