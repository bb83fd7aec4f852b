/* Shadows and reflections of catchers in an image that is shown while it is rendered. Shadows are
 * the same for all views, which share their samples; reflections are not. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/layers/caught.h"
#include "render/transport/sampler.h"

/* Samples of lights in a smooth shadow value, and maximum distance of averaged pixels. At this
 * number, where averaging ends, the error of a half shadow is 0.8 %, which is not visible per
 * pixel. */
#define ENOUGH 4096
#define MOST_REACH 3
/* Averages of fewer samples reach farther, up to this number of pixels: at the sides of the outer
 * views few or no other views see the same points. */
#define FEW_SAMPLES 32.0f
#define FARTHEST_REACH 24
/* The same for a pixel that objects cover in part. */
#define FEW_BESIDE 16.0f
#define FARTHEST_BESIDE 3
/* With this many samples, only neighbours with a similar shadow are averaged. */
#define KNOWN 32.0f
/* The same for reflections, with a pixel's own samples; and the number of samples in an average
 * before. */
#define KNOWN_REFLECTED 4.0f
#define FEW_REFLECTED 16
/* This many of its own rays determine the catcher share of a pixel. */
#define KNOWN_SHARE 4.0f
/* Samples of a row that counts as converged: of lights, and of each pixel's reflection. */
#define CONVERGED_LIGHTS 64
#define CONVERGED_REFLECTED 16

/* Sums of a view pixel. A pixel without a sample of its own uses the ray of its first one, which
 * shows whether and where it sees a catcher. */
typedef struct caught_sums {
    float lit, all; /* lf_catcher_light's, of this and other views */
    float samples;  /* how many these are of */
    float caught;   /* light at catchers on its own rays ... */
    float n;        /* ... and how many these were */
    float nearness; /* D/Z of the first that did */
} caught_sums;

/* Sums over a view pixel's own rays, besides caught_sums. */
typedef struct reflected_sums {
    lf_vec3 sum;
    float squares; /* of the three channels together */
} reflected_sums;

struct lf_caught {
    const lf_renderer *renderer;
    lf_rig rig;
    int n_views, width, height;
    int stride;        /* from one step's view to the next step's: visits all views in turn */
    caught_sums *sums; /* [row][view][column] */
    float *smooth;     /* [row][view][column]: fraction of a pixel's light that is subtracted */
    bool *smoothed;    /* [row]: it has been */
    /* [row][view][column], and smoothed, over the light at catchers; NULL: no catcher reflects */
    reflected_sums *reflected;
    lf_vec3 *mirrored;
    int *steps; /* [row]; each is a sample of one view's pixel in every column */
};

void lf_caught_destroy(lf_caught *caught)
{
    if (!caught)
        return;
    lf_free(caught->sums);
    lf_free(caught->smooth);
    lf_free(caught->smoothed);
    lf_free(caught->steps);
    lf_free(caught->reflected);
    lf_free(caught->mirrored);
    lf_free(caught);
}

static size_t row_pixels(const lf_caught *caught)
{
    return (size_t)caught->n_views * (size_t)caught->width;
}

static int divisor(int a, int b)
{
    return b == 0 ? a : divisor(b, a % b);
}

static lf_caught *make(int n_views, int width, int height, bool reflects)
{
    lf_caught *caught = lf_calloc(1, sizeof *caught);
    if (!caught)
        return NULL;
    caught->n_views = n_views;
    caught->width = width;
    caught->height = height;
    /* by the golden section: any number of steps is spread evenly over the views */
    caught->stride = (int)(0.618 * n_views) + 1;
    while (divisor(caught->stride, n_views) > 1)
        caught->stride++;
    caught->sums = lf_calloc(row_pixels(caught) * (size_t)height, sizeof *caught->sums);
    caught->steps = lf_calloc((size_t)height, sizeof *caught->steps);
    caught->smooth = lf_calloc(row_pixels(caught) * (size_t)height, sizeof *caught->smooth);
    caught->smoothed = lf_calloc((size_t)height, sizeof *caught->smoothed);
    if (reflects) {
        const size_t n = row_pixels(caught) * (size_t)height;
        caught->reflected = lf_calloc(n, sizeof *caught->reflected);
        caught->mirrored = lf_calloc(n, sizeof *caught->mirrored);
    }
    if (caught->sums && caught->steps && caught->smooth && caught->smoothed &&
        (caught->reflected && caught->mirrored) == reflects)
        return caught;
    lf_caught_destroy(caught);
    return NULL;
}

lf_status lf_caught_begin(lf_caught **caught, const lf_renderer *renderer)
{
    const int n_views = renderer->settings.camera.n_views, width = renderer->settings.width,
              height = renderer->settings.height;
    const bool reflects = lf_has(renderer->scene, LF_TRAIT_REFLECTIONS);
    lf_caught *c = *caught;
    if (c && (!lf_catch_shows(renderer->scene) || !!c->reflected != reflects ||
              c->n_views != n_views || c->width != width || c->height != height)) {
        lf_caught_destroy(c);
        c = NULL;
    }
    *caught = c;
    if (!lf_catch_shows(renderer->scene))
        return LF_OK;
    if (!c)
        *caught = c = make(n_views, width, height, reflects);
    if (!c)
        return LF_E_NOMEM;
    c->renderer = renderer;
    memset(c->steps, 0, (size_t)height * sizeof *c->steps);
    memset(c->smoothed, 0, (size_t)height * sizeof *c->smoothed);
    return lf_rig_init(&c->rig, &renderer->settings, renderer->scene->origin, NULL);
}

static float nearness_of(const lf_rig *rig, lf_vec3 p)
{
    return rig->distance / lf_max(lf_dot(lf_sub(p, rig->eye), rig->forward), 1e-30f);
}

/* The first ray of every pixel. */
static void look(lf_tracer *tracer, const lf_caught *caught, int row, caught_sums *sums)
{
    for (int view = 0; view < caught->n_views; view++)
        for (int column = 0; column < caught->width; column++, sums++) {
            const lf_catch_pixel pixel =
                lf_catch_pixel_of(caught->renderer, &caught->rig, view, row, column);
            const uint64_t key = lf_catch_key(&pixel);
            const lf_catch_ray ray = lf_catch_ray_of(&pixel, key, 0);
            lf_hit hit;
            *sums = (caught_sums){0};
            if (caught->reflected)
                caught->reflected[sums - caught->sums] = (reflected_sums){0};
            tracer->rng = lf_hash64(key, 1);
            lf_trace_caught(tracer, ray.eye, ray.w, &hit, &sums->caught);
            if (sums->caught > 0.0f)
                sums->nearness = nearness_of(&caught->rig, hit.p);
        }
}

/* Whether two depths D/Z within a pixel may belong to one surface. */
static bool may_be_one_place(float a, float b)
{
    return fabsf(a - b) < 0.01f + 0.01f * lf_min(a, b);
}

/* Adds a sample at x of a view to all other views that see the catcher there: its point lies in one
 * row of all views. */
static void share(const lf_caught *caught, caught_sums *sums, int view, float x, float nearness,
                  const double light[2])
{
    const lf_rig *rig = &caught->rig;
    const float apart = (rig->still - nearness) / rig->dx;
    for (int other = 0; other < caught->n_views; other++) {
        const float there = x + (rig->b[other] - rig->b[view]) * apart;
        if (other == view || !(there >= 0.0f && there < (float)caught->width))
            continue;
        caught_sums *s = sums + (size_t)other * (size_t)caught->width + (int)there;
        if (!(s->caught > 0.0f) || !may_be_one_place(s->nearness, nearness))
            continue;
        s->lit += (float)light[0];
        s->all += (float)light[1];
        s->samples += 1.0f;
    }
}

static void add_reflected(reflected_sums *to, lf_vec3 reflected)
{
    to->sum = lf_add(to->sum, reflected);
    to->squares += lf_dot(reflected, reflected);
}

static void add_sample(lf_tracer *tracer, const lf_caught *caught, const lf_catch_pixel *pixel,
                       caught_sums *sums)
{
    caught_sums *own = sums + (size_t)pixel->view * (size_t)caught->width + pixel->column;
    const uint64_t key = lf_catch_key(pixel);
    const lf_catch_ray ray = lf_catch_ray_of(pixel, key, (int)own->n);
    double light[2] = {0.0, 0.0};
    lf_hit hit;
    float passed;
    tracer->rng = lf_hash64(key, 1 + (uint64_t)own->n);
    const int number = (int)own->n;
    lf_trace_caught(tracer, ray.eye, ray.w, &hit, &passed);
    if (own->n == 0.0f)
        own->caught = 0.0f; /* it was of this very ray */
    own->n += 1.0f;
    if (!(passed > 0.0f))
        return;
    lf_catcher_light(tracer, &hit, ray.u, light);
    const float nearness = nearness_of(&caught->rig, hit.p);
    if (!(own->caught > 0.0f))
        own->nearness = nearness;
    own->caught += passed;
    own->lit += (float)light[0];
    own->all += (float)light[1];
    own->samples += 1.0f;
    share(caught, sums, pixel->view, ray.x, nearness, light);
    if (hit.mesh->reflects)
        add_reflected(&caught->reflected[own - caught->sums],
                      lf_catch_reflected(tracer, pixel, key, number, &ray, &hit, passed));
}

/* Number of steps of a row after this call; a row without passes gets the minimum. */
static int steps_wanted(const lf_caught *caught, int row)
{
    const lf_film *film = &caught->renderer->film;
    const int steps = caught->steps[row];
    const double passes = film->rows[row].n[0] + film->rows[row].n[1],
                 native = passes > 0.0 ? passes : 1.0 / caught->n_views;
    /* shadows are shared, so the samples of a single pixel are enough; reflections are not shared
     */
    const double all = ceil(native * caught->n_views),
                 most_of_all = (double)LF_CATCH_MOST * (caught->reflected ? caught->n_views : 1);
    const int wanted = (int)fmin(fmax(all, LF_CATCH_LEAST), most_of_all),
              most = steps == 0                         ? LF_CATCH_LEAST
                     : caught->n_views > LF_CATCH_LEAST ? steps + caught->n_views
                                                        : steps + LF_CATCH_LEAST;
    return wanted < most ? wanted : most;
}

void lf_caught_add(lf_caught *caught, int row)
{
    const int wanted = steps_wanted(caught, row);
    caught_sums *sums = caught->sums + (size_t)row * row_pixels(caught);
    lf_tracer tracer = {.scene = caught->renderer->scene};
    if (caught->steps[row] == 0 && wanted > 0)
        look(&tracer, caught, row, sums);
    for (int step = caught->steps[row]; step < wanted; step++) {
        for (int column = 0; column < caught->width; column++) {
            const int view = (int)(((int64_t)step + 3 * column) * caught->stride % caught->n_views);
            const lf_catch_pixel pixel =
                lf_catch_pixel_of(caught->renderer, &caught->rig, view, row, column);
            add_sample(&tracer, caught, &pixel, sums);
        }
        caught->steps[row] = step + 1;
    }
}

int lf_caught_samples(const lf_caught *caught, int row)
{
    return caught->steps[row];
}

bool lf_caught_settled(const lf_caught *caught, int row)
{
    return caught->steps[row] >= CONVERGED_LIGHTS &&
           (!caught->reflected || caught->steps[row] >= CONVERGED_REFLECTED * caught->n_views);
}

/* The share of the lights' light that is missing. */
static float darkness(float lit, float all)
{
    return all > 0.0f ? lf_max(1.0f - lit / all, 0.0f) : 0.0f;
}

/* How far pixels are averaged over: none once there are enough samples. */
static int reach_of(int steps)
{
    int reach = 0;
    while (reach < MOST_REACH && steps * (2 * reach + 1) * (2 * reach + 1) < ENOUGH)
        reach++;
    return reach;
}

/* Whether the shadows of two pixels may differ by chance alone: the test of two proportions, at
 * three standard deviations, as if each sample were lit or not; differences of 0.02 are not
 * visible. So averaging ends at the edge of a sharp shadow. */
static bool may_be_one_shade(const caught_sums *a, const caught_sums *b)
{
    if (a->samples < KNOWN || b->samples < KNOWN || !(a->all > 0.0f && b->all > 0.0f))
        return true;
    const float mean = lf_min((a->lit + b->lit) / (a->all + b->all), 1.0f),
                apart = a->lit / a->all - b->lit / b->all,
                variance = mean * (1.0f - mean) * (1.0f / a->samples + 1.0f / b->samples);
    return apart * apart <= 9.0f * variance + 0.02f * 0.02f;
}

/* Sums over the pixels around one. */
typedef struct sums_around {
    float lit, all, samples;
} sums_around;

static void add_around(sums_around *to, const caught_sums *s)
{
    to->lit += s->lit;
    to->all += s->all;
    to->samples += s->samples;
}

/* Neighbours that lie as deep and are as dark, as far as is known. */
static sums_around alike_around(const lf_caught *caught, int row, int view, int column, int reach)
{
    const size_t line = (size_t)view * (size_t)caught->width;
    const caught_sums *own =
        caught->sums + (size_t)row * row_pixels(caught) + line + (size_t)column;
    const int top = row > reach ? row - reach : 0, left = column > reach ? column - reach : 0,
              bottom = row + reach < caught->height ? row + reach : caught->height - 1,
              right = column + reach < caught->width ? column + reach : caught->width - 1;
    sums_around sum = {0.0f, 0.0f, 0.0f};
    for (int r = top; own->caught > 0.0f && r <= bottom; r++) {
        if (caught->steps[r] == 0)
            continue;
        const caught_sums *s = caught->sums + (size_t)r * row_pixels(caught) + line;
        for (int c = left; c <= right; c++)
            if (s[c].caught > 0.0f && may_be_one_place(s[c].nearness, own->nearness) &&
                may_be_one_shade(s + c, own))
                add_around(&sum, s + c);
    }
    return sum;
}

/* Their mean; over more pixels if they have few samples, until the pixel has rays of its own. */
static float smooth_at(const lf_caught *caught, int row, int view, int column, int reach)
{
    const caught_sums *own = caught->sums + (size_t)row * row_pixels(caught) +
                             (size_t)view * (size_t)caught->width + (size_t)column;
    sums_around sum = alike_around(caught, row, view, column, reach);
    while (own->caught > 0.0f && own->n < KNOWN_SHARE && sum.samples < FEW_SAMPLES &&
           reach < FARTHEST_REACH) {
        reach = 2 * reach + 1 < FARTHEST_REACH ? 2 * reach + 1 : FARTHEST_REACH;
        sum = alike_around(caught, row, view, column, reach);
    }
    return darkness(sum.lit, sum.all);
}

/* Catcher share of a pixel, from its own rays. */
static float own_share(const caught_sums *s)
{
    return s->caught / lf_max(s->n, 1.0f);
}

/* Opens a row of the film and its neighbours. */
static void open_around(const lf_caught *caught, int row)
{
    for (int r = row > 0 ? row - 1 : 0; r <= row + 1 && r < caught->height; r++)
        lf_film_open(&caught->renderer->film, r);
}

static void close_around(const lf_caught *caught, int row)
{
    for (int r = row > 0 ? row - 1 : 0; r <= row + 1 && r < caught->height; r++)
        lf_film_close(&caught->renderer->film, r, false);
}

/* Catcher share of the surrounding pixels that no object covers. */
static float share_beside(const lf_caught *caught, int row, int view, int column)
{
    const size_t line = (size_t)view * (size_t)caught->width;
    float share = 0.0f, n = 0.0f;
    for (int r = row > 0 ? row - 1 : 0; r <= row + 1 && r < caught->height; r++)
        for (int c = column > 0 ? column - 1 : 0; c <= column + 1 && c < caught->width; c++) {
            const size_t i = line + (size_t)c;
            if (caught->steps[r] == 0 || lf_catch_met(&caught->renderer->film, r, i) > 0.0)
                continue;
            share += own_share(caught->sums + (size_t)r * row_pixels(caught) + i);
            n += 1.0f;
        }
    return n > 0.0f ? share / n : 1.0f;
}

static sums_around all_around(const lf_caught *caught, int row, int view, int column, int reach)
{
    sums_around sum = {0.0f, 0.0f, 0.0f};
    for (int r = row > reach ? row - reach : 0; r <= row + reach && r < caught->height; r++) {
        const caught_sums *s =
            caught->sums + (size_t)r * row_pixels(caught) + (size_t)view * (size_t)caught->width;
        for (int c = column > reach ? column - reach : 0; c <= column + reach && c < caught->width;
             c++)
            if (caught->steps[r] > 0 && s[c].caught > 0.0f)
                add_around(&sum, s + c);
    }
    return sum;
}

/* Subtracted light in a pixel that objects cover in part. Its own few rays determine neither the
 * uncovered share, which the film knows, nor the shadow behind them. The surrounding pixels
 * determine both. */
static float taken_beside(const lf_caught *caught, int row, int view, int column, float open)
{
    int reach = 1;
    sums_around sum = all_around(caught, row, view, column, reach);
    while (sum.samples < FEW_BESIDE && reach < FARTHEST_BESIDE)
        sum = all_around(caught, row, view, column, ++reach);
    return darkness(sum.lit, sum.all) * open * share_beside(caught, row, view, column);
}

static float taken_at(const lf_caught *caught, int row, int view, int column, int reach)
{
    const size_t i = (size_t)view * (size_t)caught->width + (size_t)column;
    const lf_renderer *renderer = caught->renderer;
    const float open = lf_catch_open(renderer->scene, lf_catch_met(&renderer->film, row, i));
    const caught_sums *own = caught->sums + (size_t)row * row_pixels(caught) + i;
    if (own->n < KNOWN_SHARE && open > 0.0f && open < 1.0f)
        return taken_beside(caught, row, view, column, open);
    return smooth_at(caught, row, view, column, reach) * lf_min(own_share(own), open);
}

static lf_vec3 over_caught(lf_vec3 reflected, float caught)
{
    return caught > 0.0f ? lf_scale(reflected, 1.0f / caught) : lf_v3(0.0f, 0.0f, 0.0f);
}

/* Few samples are averaged until there are some; then many, but only such as are alike. */
static int reach_of_reflected(float n)
{
    const int enough = n < KNOWN_REFLECTED ? FEW_REFLECTED : ENOUGH;
    int reach = n > 0.0f ? 0 : MOST_REACH;
    while (reach < MOST_REACH && (int)n * (2 * reach + 1) * (2 * reach + 1) < enough)
        reach++;
    return reach;
}

/* The mean of a pixel's samples, and its variance, of the channels together. */
typedef struct image_mean {
    lf_vec3 mean;
    float variance;
} image_mean;

static image_mean mean_of(const reflected_sums *r, float n)
{
    return (image_mean){lf_scale(r->sum, 1.0f / n),
                        lf_max(r->squares - lf_dot(r->sum, r->sum) / n, 0.0f) / (n * (n - 1.0f))};
}

/* Whether all of it comes from one of many samples. */
static bool is_chance(const image_mean *m)
{
    return m->variance > 0.0f && lf_dot(m->mean, m->mean) <= 1.5f * m->variance;
}

/* Whether the reflections of two pixels may differ by chance alone, at three standard deviations,
 * with the uncertainty of the surer one for both. At the rim of an image, samples differ because
 * some show it and some do not; otherwise neighbouring pixels would accept the rim's light. A
 * single bright sample has its own uncertainty. Differences of 2 % are not visible. */
static bool may_be_one_image(const reflected_sums *a, float n_a, const reflected_sums *b, float n_b)
{
    if (n_a < KNOWN_REFLECTED || n_b < KNOWN_REFLECTED)
        return true;
    const image_mean p = mean_of(a, n_a), q = mean_of(b, n_b);
    const lf_vec3 apart = lf_sub(p.mean, q.mean);
    const float variance = is_chance(&p) || is_chance(&q) ? p.variance + q.variance
                                                          : 2.0f * lf_min(p.variance, q.variance);
    return lf_dot(apart, apart) <=
           9.0f * variance + 4e-4f * lf_max(lf_dot(p.mean, p.mean), lf_dot(q.mean, q.mean));
}

/* The mean over neighbours of the same view that lie as deep and reflect as much, as far as is
 * known. */
static lf_vec3 smooth_reflection(const lf_caught *caught, int row, int view, int column)
{
    const size_t line = (size_t)view * (size_t)caught->width,
                 at = (size_t)row * row_pixels(caught) + line + (size_t)column;
    const caught_sums *own = caught->sums + at;
    const int reach = reach_of_reflected(own->n), top = row > reach ? row - reach : 0,
              left = column > reach ? column - reach : 0,
              bottom = row + reach < caught->height ? row + reach : caught->height - 1,
              right = column + reach < caught->width ? column + reach : caught->width - 1;
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    float all = 0.0f;
    for (int r = top; own->caught > 0.0f && r <= bottom; r++)
        for (int c = left; caught->steps[r] > 0 && c <= right; c++) {
            const size_t other = (size_t)r * row_pixels(caught) + line + (size_t)c;
            const caught_sums *s = caught->sums + other;
            if (!(s->n > 0.0f && s->caught > 0.0f) ||
                !may_be_one_place(s->nearness, own->nearness) ||
                !may_be_one_image(caught->reflected + other, s->n, caught->reflected + at, own->n))
                continue;
            sum = lf_add(sum, caught->reflected[other].sum);
            all += s->caught;
        }
    return over_caught(sum, all);
}

static void smooth_row(void *context, int row, int worker)
{
    lf_caught *caught = context;
    const int reach = reach_of(caught->steps[row]);
    float *out = caught->smooth + (size_t)row * row_pixels(caught);
    (void)worker;
    caught->smoothed[row] = caught->steps[row] > 0;
    open_around(caught, row);
    for (int view = 0; view < caught->n_views && caught->smoothed[row]; view++)
        for (int column = 0; column < caught->width; column++)
            *out++ = taken_at(caught, row, view, column, reach);
    close_around(caught, row);
    if (!caught->reflected || !caught->smoothed[row])
        return;
    lf_vec3 *image = caught->mirrored + (size_t)row * row_pixels(caught);
    for (int view = 0; view < caught->n_views; view++)
        for (int column = 0; column < caught->width; column++)
            *image++ = smooth_reflection(caught, row, view, column);
}

lf_status lf_caught_smooth(lf_caught *caught, const lf_cancel *cancel)
{
    return lf_pool_run(caught->renderer->pool, caught->height, smooth_row, caught, cancel);
}

/* Over the light at catchers. A pixel without samples of its own uses the samples of the previous
 * one. */
static lf_vec3 reflection_at(const lf_caught *caught, size_t i, bool smooth)
{
    const caught_sums *s = caught->sums + i;
    const size_t before = i % (size_t)caught->width;
    if (smooth)
        return caught->mirrored[i];
    for (size_t back = 0; back <= before && s[0].caught > 0.0f; back++, s--)
        if (s->n > 0.0f && s->caught > 0.0f)
            return over_caught(caught->reflected[i - back].sum, s->caught);
    return lf_v3(0.0f, 0.0f, 0.0f);
}

void lf_caught_take(const lf_caught *caught, int row, bool smooth, float *picture)
{
    const lf_renderer *renderer = caught->renderer;
    const size_t first = (size_t)row * row_pixels(caught);
    const caught_sums *s = caught->sums + first;
    const lf_vec3 backdrop = lf_catch_behind(renderer->scene, &caught->rig, row);
    if (caught->steps[row] == 0)
        return;
    smooth = smooth && caught->smoothed[row];
    lf_film_open(&renderer->film, row);
    for (size_t i = 0; i < row_pixels(caught); i++, s++, picture += 3) {
        if (smooth) {
            lf_catch_take(picture, caught->smooth[first + i], backdrop);
        } else if (s->caught > 0.0f && s->lit < s->all) {
            const float open =
                lf_catch_open(renderer->scene, lf_catch_met(&renderer->film, row, i));
            lf_catch_take(picture, darkness(s->lit, s->all) * lf_min(own_share(s), open), backdrop);
        }
        if (caught->reflected && s->caught > 0.0f)
            lf_catch_put(picture, lf_scale(reflection_at(caught, first + i, smooth), own_share(s)));
    }
    lf_film_close(&renderer->film, row, false);
}
