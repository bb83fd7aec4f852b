#include "render/reconstruct/reconstruct.h"

#include <string.h>

#include "base/alloc.h"
#include "base/cpu.h"
#include "render/reconstruct/bright.h"
#include "render/reconstruct/moments.h"
#include "render/reconstruct/residual.h"
#include "render/reconstruct/scratch.h"
#include "render/reconstruct/shrink.h"
#include "render/reconstruct/solve.h"

static lf_isa_tables kernels = {
    [LF_ISA_C] = &lf_reconstruct_kernels_c,
#if defined(__x86_64__)
    [LF_ISA_AVX2] = &lf_reconstruct_kernels_avx2,
    [LF_ISA_AVX512] = &lf_reconstruct_kernels_avx512,
#endif
};

static int bands_of(int height, int level)
{
    int side = LF_CELL_SIDE << level;
    return (height + side - 1) / side;
}

lf_status lf_reconstruct_create(const lf_reconstruct_view *view, lf_pool *pool,
                                lf_reconstruction **out)
{
    lf_reconstruction *r = lf_calloc(1, sizeof *r);
    if (!r)
        return LF_E_NOMEM;
    r->view = *view;
    r->pool = pool;
    r->kernels = lf_isa_get(kernels);
    r->cell_depth = fmaxf(LF_CELL_DEPTH, LF_NEARNESS_MAX * view->depth / LF_MAX_DEPTHS);
    pthread_mutex_init(&r->lock, NULL);
    r->shift = lf_calloc((size_t)view->n_views, sizeof *r->shift);
    r->bright = lf_calloc((size_t)bands_of(view->height, 1), sizeof *r->bright);
    r->second = lf_calloc((size_t)view->height, sizeof *r->second);
    bool whole = r->shift && r->bright && r->second;
    for (int l = 0; l < LF_LEVELS && whole; l++) {
        r->level[l].n_bands = bands_of(view->height, l);
        r->level[l].bands = lf_calloc((size_t)r->level[l].n_bands, sizeof *r->level[l].bands);
        whole = r->level[l].bands;
    }
    if (!whole) {
        lf_reconstruct_destroy(r);
        return LF_E_NOMEM;
    }
    memcpy(r->shift, view->shift, (size_t)view->n_views * sizeof *r->shift);
    r->view.shift = r->shift;
    *out = r;
    return LF_OK;
}

void lf_reconstruct_destroy(lf_reconstruction *r)
{
    if (!r)
        return;
    lf_reconstruct_destroy(r->bounded);
    for (int i = 0; r->bright && i < r->level[1].n_bands; i++)
        lf_bright_finish(&r->bright[i]);
    lf_free(r->bright);
    for (int l = 0; l < LF_LEVELS; l++) {
        for (int i = 0; r->level[l].bands && i < r->level[l].n_bands; i++)
            lf_band_finish(&r->level[l].bands[i]);
        lf_free(r->level[l].bands);
    }
    for (int i = 0; r->second && i < r->view.height; i++)
        lf_free(r->second[i].is);
    lf_free(r->second);
    lf_residual_destroy(r->residual);
    lf_scratch_drop(r);
    pthread_mutex_destroy(&r->lock);
    lf_free(r->shift);
    lf_free(r);
}

bool lf_reconstruct_ready(const lf_reconstruction *r)
{
    return r->ready;
}

/* ----------------------------------------------------------------------------------- the fit -- */

typedef enum lf_step {
    GATHER,
    COARSEN,
    SOLVE,
    WEIGH,
    WEIGH_PAST,
    WEIGH_RAW,
    COLLECT,
    SETTLE,
    SETTLE_RAW,
    TAKE,
    TAKE_PAST,
    TAKE_RAW,
    BRIGHT_TELL,
    BRIGHT_BOUND,
    BRIGHT_COMPARE,
    BRIGHT_SETTLE,
    BRIGHT_TAKE,
    RESIDUAL_SUM
} lf_step;

typedef struct lf_fit_job {
    lf_reconstruction *r;
    const lf_film *film;
    const lf_cancel *cancel;
    lf_step step;
    int level;
    atomic_int failed;
} lf_fit_job;

static lf_status gather(const lf_fit_job *job, int band)
{
    lf_reconstruct_scratch *scratch = lf_scratch_take(job->r);
    if (!scratch)
        return LF_E_NOMEM;
    lf_status status = lf_moments_gather(job->r, job->film, band, scratch);
    lf_scratch_give(job->r, scratch);
    return status;
}

static void run_band(void *context, int band, int worker)
{
    (void)worker;
    lf_fit_job *job = context;
    lf_status status = LF_OK;
    switch (job->step) {
    case GATHER:
        status = gather(job, band);
        break;
    case COARSEN:
        status = lf_moments_coarsen(job->r, job->level, band);
        break;
    case SOLVE:
        lf_solve_band(job->r, job->level, band);
        break;
    case WEIGH:
        lf_shrink_weigh(job->r, job->level, band);
        break;
    case WEIGH_PAST:
        lf_shrink_weigh_past(job->r, band);
        break;
    case WEIGH_RAW:
        lf_shrink_weigh_raw(job->r, band);
        break;
    case COLLECT:
        lf_shrink_collect(job->r, band);
        break;
    case SETTLE:
        lf_shrink_settle(job->r, job->level, band);
        break;
    case SETTLE_RAW:
        lf_shrink_settle_raw(job->r, band);
        break;
    case TAKE:
        lf_shrink_take(job->r, job->level, band);
        break;
    case TAKE_PAST:
        lf_shrink_take_past(job->r, band);
        break;
    case TAKE_RAW:
        lf_shrink_take_raw(job->r, band);
        break;
    case BRIGHT_TELL:
        status = lf_bright_tell(job->r, job->film, band);
        break;
    case BRIGHT_BOUND:
        lf_bright_settle_bound(job->r, band);
        break;
    case BRIGHT_COMPARE:
        status = lf_bright_compare(job->r, job->film, band);
        break;
    case BRIGHT_SETTLE:
        lf_bright_settle(job->r, band);
        break;
    case BRIGHT_TAKE:
        lf_shrink_take_bright(job->r, band);
        break;
    case RESIDUAL_SUM:
        status = lf_residual_sum(job->r, job->film, band);
        break;
    }
    if (status != LF_OK)
        atomic_store_explicit(&job->failed, 1, memory_order_relaxed);
}

static lf_status run(lf_fit_job *job, lf_step step, int level)
{
    job->step = step;
    job->level = level;
    lf_status status =
        lf_pool_run(job->r->pool, job->r->level[level].n_bands, run_band, job, job->cancel);
    return atomic_load_explicit(&job->failed, memory_order_relaxed) ? LF_E_NOMEM : status;
}

/* A step of the finest level, with the shares of the level above it. */
static lf_status shrink_finest(lf_fit_job *job, lf_step weigh, lf_step settle, lf_step take)
{
    lf_status status = run(job, weigh, 0);
    if (status == LF_OK)
        status = run(job, COLLECT, 1);
    if (status == LF_OK)
        status = run(job, settle, 1);
    return status == LF_OK ? run(job, take, 0) : status;
}

static lf_status fit_levels(lf_reconstruction *r, const lf_film *film, const lf_cancel *cancel)
{
    lf_fit_job job = {.r = r, .film = film, .cancel = cancel};
    lf_status status = run(&job, GATHER, 0);
    for (int l = 1; l < LF_LEVELS && status == LF_OK; l++)
        status = run(&job, COARSEN, l);
    for (int l = 0; l < LF_LEVELS && status == LF_OK; l++)
        status = run(&job, SOLVE, l);
    for (int l = LF_LEVELS - 2; l > 0 && status == LF_OK; l--) {
        const lf_step steps[] = {WEIGH, SETTLE, TAKE};
        for (int i = 0; i < 3 && status == LF_OK; i++)
            status = run(&job, steps[i], l);
    }
    if (status == LF_OK)
        status = shrink_finest(&job, WEIGH, SETTLE, TAKE);
    if (status == LF_OK && r->past)
        status = shrink_finest(&job, WEIGH_PAST, SETTLE, TAKE_PAST);
    if (status == LF_OK)
        status = shrink_finest(&job, WEIGH_RAW, SETTLE_RAW, TAKE_RAW);
    return status;
}

/* Finds where halves agree on excesses over the surroundings, and fits the rest. */
static lf_status fit_bounded(lf_reconstruction *r, const lf_film *film, const lf_cancel *cancel)
{
    static const lf_step steps[] = {BRIGHT_TELL, BRIGHT_BOUND, BRIGHT_COMPARE, BRIGHT_SETTLE,
                                    BRIGHT_TAKE};
    lf_fit_job job = {.r = r, .film = film, .cancel = cancel};
    lf_status status = LF_OK;
    for (int i = 0; i < 5 && status == LF_OK; i++)
        status = run(&job, steps[i], steps[i] == BRIGHT_TAKE ? 0 : 1);
    r->is_bright = status == LF_OK && lf_bright_anywhere(r);
    if (!r->is_bright)
        return status;
    if (!r->bounded)
        status = lf_reconstruct_create(&r->view, r->pool, &r->bounded);
    if (status != LF_OK)
        return status;
    r->bounded->whole = r;
    r->bounded->kernels = r->kernels;
    for (int l = 0; l < LF_LEVELS; l++)
        for (int i = 0; i < r->level[l].n_bands; i++)
            lf_band_lend_sums(&r->bounded->level[l].bands[i], &r->level[l].bands[i]);
    return fit_levels(r->bounded, film, cancel);
}

static void weigh_tiles(void *context, int view, int worker)
{
    lf_fit_job *job = context;
    (void)worker;
    lf_residual_weigh(job->r, job->level, view);
}

static void share_tiles(void *context, int view, int worker)
{
    lf_fit_job *job = context;
    (void)worker;
    lf_residual_share(job->r, job->level, view);
}

static void take_tiles(void *context, int view, int worker)
{
    lf_fit_job *job = context;
    (void)worker;
    lf_residual_take(job->r, job->level, view);
}

static bool has_both_halves(const lf_film *film)
{
    for (int row = 0; row < film->height; row++)
        if (film->rows[row].n[0] > 0.0 && film->rows[row].n[1] > 0.0)
            return true;
    return false;
}

/* Corrections per tile; the halves must agree on them. */
static lf_status fit_residual(lf_reconstruction *r, const lf_film *film, const lf_cancel *cancel)
{
    if (!has_both_halves(film)) {
        lf_residual_destroy(r->residual);
        r->residual = NULL;
        return LF_OK;
    }
    if (!r->residual)
        r->residual = lf_residual_create(&r->view);
    if (!r->residual)
        return LF_E_NOMEM;
    lf_fit_job job = {.r = r, .film = film, .cancel = cancel};
    lf_status status = lf_residual_begin(r->residual, r->view.n_views);
    if (status == LF_OK)
        status = run(&job, RESIDUAL_SUM, 0);
    void (*const steps[])(void *, int, int) = {weigh_tiles, share_tiles, take_tiles};
    for (job.level = LF_RESIDUAL_LEVELS - 1; job.level >= 0 && status == LF_OK; job.level--)
        for (int i = 0; i < 3 && status == LF_OK; i++)
            status = lf_pool_run(r->pool, r->view.n_views, steps[i], &job, cancel);
    lf_residual_end(r->residual);
    return status;
}

static void drop_sums(lf_reconstruction *r)
{
    for (int l = 0; r && l < LF_LEVELS; l++)
        for (int i = 0; i < r->level[l].n_bands; i++)
            lf_band_drop_sums(&r->level[l].bands[i]);
}

lf_status lf_reconstruct_fit(lf_reconstruction *r, const lf_film *film, const lf_cancel *cancel)
{
    r->ready = false;
    lf_status status = fit_levels(r, film, cancel);
    lf_scratch_drop(r); /* later steps need no list of places */
    if (status == LF_OK)
        status = fit_bounded(r, film, cancel);
    if (r->bounded)
        lf_scratch_drop(r->bounded);
    drop_sums(r);
    drop_sums(r->bounded);
    if (status == LF_OK)
        status = fit_residual(r, film, cancel);
    r->ready = status == LF_OK;
    return status;
}
