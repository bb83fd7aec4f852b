#include "daemon/engine/picture.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/output/guides.h"

static size_t row_pixels(const lf_picture *picture)
{
    return (size_t)picture->n_views * (size_t)picture->width;
}

void lf_picture_forget(lf_picture *picture)
{
    size_t n = row_pixels(picture);
    if (n == 0)
        return;
    memset(picture->missing, LF_PIXEL_UNSEEN, n * (size_t)picture->height);
    for (int row = 0; row < picture->height; row++)
        picture->row_missing[row] = (int64_t)n;
}

static void release(lf_picture *picture)
{
    lf_free(picture->rgb);
    lf_free(picture->missing);
    lf_free(picture->row_missing);
    lf_free(picture->scratch);
    lf_free(picture->beside);
    lf_free(picture->flags);
}

void lf_picture_finish(lf_picture *picture)
{
    release(picture);
    lf_caught_destroy(picture->caught);
    lf_tone_destroy(picture->tone);
    *picture = (lf_picture){0};
}

/* Allocates the new buffers before it frees the old ones, so that a failure leaves the picture
 * unchanged. */
static lf_status reshape(lf_picture *picture, int n_views, int width, int height, int n_threads,
                         lf_error *err)
{
    lf_picture fresh = {
        .n_views = n_views, .width = width, .height = height, .n_threads = n_threads};
    size_t row = row_pixels(&fresh);
    fresh.rgb = lf_calloc(row * (size_t)height, 3);
    fresh.missing = lf_calloc(row * (size_t)height, 1);
    fresh.row_missing = lf_calloc((size_t)height, sizeof *fresh.row_missing);
    fresh.scratch = lf_calloc(row * (size_t)n_threads, 3 * sizeof *fresh.scratch);
    fresh.flags = lf_calloc(row * (size_t)n_threads, 1);
    if (!fresh.rgb || !fresh.missing || !fresh.row_missing || !fresh.scratch || !fresh.flags) {
        release(&fresh);
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory for %d views of %dx%d", n_views,
                            width, height);
    }
    release(picture);
    fresh.tone = picture->tone;
    fresh.film = picture->film;
    fresh.metered = picture->metered;
    fresh.renderer = picture->renderer;
    fresh.caught = picture->caught;
    fresh.estimator = picture->estimator;
    fresh.reconstructs = picture->reconstructs;
    *picture = fresh;
    return LF_OK;
}

/* Uses the scene's film settings, but keeps an exposure that was measured before. */
static lf_status take_tone(lf_picture *picture, const lf_film_settings *film, lf_error *err)
{
    lf_film_settings wanted = *film;
    lf_tone *tone = NULL;
    if (film->auto_exposure && picture->metered)
        wanted.exposure = picture->film.exposure;
    lf_status status = lf_tone_create(wanted.exposure, wanted.tonemap, &tone, err);
    if (status != LF_OK)
        return status;
    lf_tone_destroy(picture->tone);
    picture->tone = tone;
    picture->film = wanted;
    picture->metered = film->auto_exposure && picture->metered;
    picture->settled = false;
    return LF_OK;
}

lf_status lf_picture_shape(lf_picture *picture, int n_views, int width, int height, int n_threads,
                           const lf_film_settings *film, lf_error *err)
{
    lf_status status = LF_OK;
    if (picture->n_views != n_views || picture->width != width || picture->height != height ||
        picture->n_threads != n_threads) {
        status = reshape(picture, n_views, width, height, n_threads, err);
        if (status != LF_OK)
            return status;
    }
    status = take_tone(picture, film, err);
    if (status != LF_OK)
        return status;
    picture->sampled = false;
    lf_picture_forget(picture);
    return LF_OK;
}

lf_status lf_picture_follow(lf_picture *picture, lf_renderer *renderer)
{
    picture->renderer = renderer;
    if (renderer)
        return lf_caught_begin(&picture->caught, renderer);
    lf_caught_destroy(picture->caught);
    picture->caught = NULL;
    return LF_OK;
}

lf_status lf_picture_guide(lf_picture *picture, const lf_depth *depth)
{
    if (!depth) {
        lf_free(picture->beside);
        picture->beside = NULL;
        return LF_OK;
    }
    if (!picture->beside)
        picture->beside = lf_calloc(row_pixels(picture) * (size_t)picture->n_threads,
                                    2 * sizeof *picture->beside);
    picture->sharp = *depth;
    return picture->beside ? LF_OK : LF_E_NOMEM;
}

/* Takes samples of catchers for a row without any, as in a coarse frame. */
static void catch_row(void *context, int row, int worker)
{
    lf_picture *picture = context;
    (void)worker;
    if (lf_caught_samples(picture->caught, row) == 0)
        lf_caught_add(picture->caught, row);
}

lf_status lf_picture_fitted(lf_picture *picture, lf_pool *pool, const lf_cancel *cancel)
{
    lf_status status = LF_OK;
    if (picture->caught)
        status = lf_pool_run(pool, picture->height, catch_row, picture, cancel);
    if (status == LF_OK && picture->caught)
        status = lf_caught_smooth(picture->caught, cancel);
    return status == LF_OK ? lf_picture_resolve(picture, pool, cancel) : status;
}

bool lf_picture_caught(const lf_picture *picture)
{
    for (int row = 0; picture->caught && row < picture->height; row++)
        if (!lf_caught_settled(picture->caught, row))
            return false;
    return true;
}

static uint8_t not_there(const lf_picture *picture)
{
    return picture->sampled ? LF_PIXEL_UNSEEN : LF_PIXEL_HOLE | LF_PIXEL_UNSEEN;
}

/* Tone-maps a row with catchers and guides. A fitted row is dithered, because it has no noise to do
 * that. */
static void tone_row(lf_picture *picture, int row, bool fitted, int worker)
{
    const size_t n = row_pixels(picture), width = (size_t)picture->width;
    float *linear = picture->scratch + (size_t)worker * n * 3;
    if (picture->caught)
        lf_caught_take(picture->caught, row, fitted, linear);
    if (picture->beside) {
        float *layers = picture->beside + (size_t)worker * n * 2;
        if (lf_renderer_layers_row(picture->renderer, picture->estimator, LF_GUIDE_LAYERS, row,
                                   layers) == LF_OK)
            lf_guides_mark(&picture->sharp, picture->film.exposure, layers, n, linear);
    }
    uint8_t *rgb = picture->rgb + (size_t)row * n * 3;
    if (!fitted)
        lf_tone_map(picture->tone, n, linear, rgb);
    for (size_t view = 0, at = 0; fitted && at < 3 * n; view++, at += 3 * width)
        lf_tone_dither(picture->tone, (int)view, row, width, linear + at, rgb + at);
}

/* A fit answers every pixel of a row that has features; without paths the row still counts as
 * missing. */
static bool show_row(lf_picture *picture, int row, int worker)
{
    size_t n = row_pixels(picture);
    float *linear = picture->scratch + (size_t)worker * n * 3;
    if (lf_renderer_show_row(picture->renderer, row, linear) != LF_OK)
        return false;
    tone_row(picture, row, true, worker);
    lf_renderer_show_flags(picture->renderer, row, picture->missing + (size_t)row * n);
    picture->row_missing[row] = lf_renderer_visited(picture->renderer, row) ? 0 : (int64_t)n;
    return true;
}

static void resolve_row(lf_picture *picture, int row, int worker)
{
    size_t n = row_pixels(picture);
    float *linear = picture->scratch + (size_t)worker * n * 3;
    uint8_t *flags = picture->flags + (size_t)worker * n;
    if (lf_renderer_resolve_row(picture->renderer, picture->estimator, row, linear, flags) != LF_OK)
        return; /* never visited: stays missing */
    tone_row(picture, row, false, worker);
    uint8_t *missing = picture->missing + (size_t)row * n;
    const uint8_t absent = not_there(picture);
    int64_t count = 0;
    for (size_t i = 0; i < n; i++) {
        /* A pixel with a value keeps it, although unseen light may appear later. */
        missing[i] &= flags[i] & absent ? LF_PIXEL_UNSEEN : 0;
        count += missing[i] != 0;
    }
    picture->row_missing[row] = count;
}

static void show_again(void *context, int row, int worker)
{
    lf_picture *picture = context;
    if (picture->caught && lf_caught_samples(picture->caught, row) == 0)
        lf_caught_add(picture->caught, row);
    if (!picture->reconstructs || !show_row(picture, row, worker))
        resolve_row(picture, row, worker);
}

void lf_picture_row(void *context, int row, int worker)
{
    lf_picture *picture = context;
    if (picture->caught)
        lf_caught_add(picture->caught, row);
    show_again(context, row, worker);
}

void lf_picture_row_later(void *context, int row, int worker)
{
    const lf_picture *picture = context;
    (void)worker;
    if (picture->caught)
        lf_caught_add(picture->caught, row);
}

lf_status lf_picture_resolve(lf_picture *picture, lf_pool *pool, const lf_cancel *cancel)
{
    return lf_pool_run(pool, picture->height, show_again, picture, cancel);
}

static void estimate_row(void *context, int row, int worker)
{
    const lf_picture *picture = context;
    float *linear = picture->scratch + (size_t)worker * row_pixels(picture) * 3;
    (void)lf_renderer_resolve_row(picture->renderer, picture->estimator, row, linear, NULL);
}

void lf_picture_estimate(lf_picture *picture, lf_pool *pool, const lf_cancel *cancel)
{
    (void)!lf_pool_run(pool, picture->height, estimate_row, picture, cancel);
}

lf_status lf_picture_retone(lf_picture *picture, const lf_film_settings *film, lf_pool *pool,
                            lf_error *err)
{
    lf_status status = take_tone(picture, film, err);
    if (status == LF_OK)
        (void)!lf_picture_resolve(picture, pool, NULL);
    return status;
}

/* ---------------------------------------------------------------------------------- exposure -- */

/* How far the exposure in use may be off before it changes, in stops. */
#define KEPT_WITHIN 0.5

typedef struct metering {
    const lf_picture *picture;
    lf_meter *meters; /* [thread] */
} metering;

/* Filled and unvisited pixels do not count. */
static void meter_row(void *context, int row, int worker)
{
    const metering *m = context;
    const lf_picture *picture = m->picture;
    size_t n = row_pixels(picture);
    float *linear = picture->scratch + (size_t)worker * n * 3;
    uint8_t *flags = picture->flags + (size_t)worker * n;
    if (lf_renderer_resolve_row(picture->renderer, picture->estimator, row, linear, flags) != LF_OK)
        return;
    if (picture->caught)
        lf_caught_take(picture->caught, row, false, linear);
    for (size_t i = 0; i < n; i++)
        if (!(flags[i] & (LF_PIXEL_HOLE | LF_PIXEL_UNSEEN)))
            lf_meter_add(&m->meters[worker], 1, linear + 3 * i);
}

static bool expose(lf_picture *picture, const lf_meter *meter)
{
    lf_film_settings film = picture->film;
    film.exposure = lf_meter_exposure(meter);
    bool keep = picture->metered && fabs(film.exposure - picture->film.exposure) <= KEPT_WITHIN;
    lf_tone *tone = NULL;
    picture->metered = true;
    if (keep || lf_tone_create(film.exposure, film.tonemap, &tone, NULL) != LF_OK)
        return false;
    lf_tone_destroy(picture->tone);
    picture->tone = tone;
    picture->film = film;
    return true;
}

bool lf_picture_expose(lf_picture *picture, lf_pool *pool)
{
    if (!picture->film.auto_exposure || picture->settled || !picture->renderer)
        return false;
    picture->settled = true;
    metering m = {picture, lf_calloc((size_t)picture->n_threads, sizeof *m.meters)};
    if (!m.meters)
        return false;
    (void)!lf_pool_run(pool, picture->height, meter_row, &m, NULL);
    for (int i = 1; i < picture->n_threads; i++)
        lf_meter_merge(&m.meters[0], &m.meters[i]);
    bool changed = expose(picture, &m.meters[0]);
    lf_free(m.meters);
    if (changed)
        (void)!lf_picture_resolve(picture, pool, NULL);
    return changed;
}

void lf_picture_take(lf_picture *picture, const lf_views32 *views)
{
    size_t width = (size_t)picture->width;
    lf_meter *meter = picture->film.auto_exposure ? lf_calloc(1, sizeof *meter) : NULL;
    if (meter) {
        lf_meter_add_views(meter, views);
        (void)expose(picture, meter);
        lf_free(meter);
    }
    for (int row = 0; row < picture->height; row++) {
        for (int view = 0; view < picture->n_views; view++) {
            size_t at = ((size_t)row * (size_t)picture->n_views + (size_t)view) * width;
            lf_tone_map(picture->tone, width, lf_views32_row(views, view, row),
                        picture->rgb + at * 3);
        }
        picture->row_missing[row] = 0;
    }
    memset(picture->missing, 0, row_pixels(picture) * (size_t)picture->height);
}

int64_t lf_picture_missing(const lf_picture *picture)
{
    int64_t sum = 0;
    for (int row = 0; row < picture->height; row++)
        sum += picture->row_missing[row];
    return sum;
}

lf_views8 lf_picture_views(lf_picture *picture, lf_pool *pool, int64_t *out_unfilled,
                           int64_t *out_blank)
{
    lf_views8 views = {
        .n_views = picture->n_views, .width = picture->width, .height = picture->height};
    views.view_stride = (size_t)picture->width * 3;
    views.row_stride = row_pixels(picture) * 3;
    views.data = picture->rgb;
    *out_unfilled = *out_blank = 0;
    if (lf_picture_missing(picture) > 0) {
        lf_fill_counts counts =
            lf_fill(picture->n_views, picture->width, picture->height, picture->rgb,
                    picture->missing, LF_COARSE_REACH, LF_FILL_REACH, picture->rgb, pool);
        *out_unfilled = counts.far;
        *out_blank = counts.unfilled;
    }
    return views;
}

/* A pixel that the picture has but the film lacks was restored, and is not a hole. */
static void mark_missing(const lf_picture *picture, bool reconstructed, uint8_t *flags)
{
    const size_t row = row_pixels(picture), n = row * (size_t)picture->height;
    if (!reconstructed && !picture->reconstructs)
        memcpy(flags, picture->missing, n);
    for (int i = 0; i < picture->height && reconstructed; i++)
        lf_renderer_show_flags(picture->renderer, i, flags + (size_t)i * row);
    for (size_t i = 0; i < n && !reconstructed && picture->reconstructs; i++)
        flags[i] &= not_there(picture);
}

typedef struct taking {
    const lf_caught *caught;
    float *film;
    size_t row; /* floats per row */
    bool smooth;
} taking;

static void take_caught(void *context, int row, int worker)
{
    const taking *t = context;
    (void)worker;
    lf_caught_take(t->caught, row, t->smooth, t->film + (size_t)row * t->row);
}

lf_status lf_picture_film(const lf_picture *picture, bool reconstructed, lf_pool *pool, float *film)
{
    uint8_t *flags = lf_calloc(row_pixels(picture) * (size_t)picture->height, 1);
    if (!flags)
        return LF_E_NOMEM;
    lf_status status = lf_renderer_resolve(picture->renderer, picture->estimator, film, flags);
    if (status == LF_OK && reconstructed)
        status = lf_renderer_show(picture->renderer, film, NULL);
    taking t = {picture->caught, film, row_pixels(picture) * 3, reconstructed};
    if (status == LF_OK && picture->caught && reconstructed)
        status = lf_caught_smooth(picture->caught, NULL);
    if (status == LF_OK && picture->caught)
        status = lf_pool_run(pool, picture->height, take_caught, &t, NULL);
    if (status == LF_OK) {
        mark_missing(picture, reconstructed, flags);
        lf_fill_film(picture->n_views, picture->width, picture->height, film, flags, LF_FILL_REACH,
                     pool);
    }
    lf_free(flags);
    return status;
}
