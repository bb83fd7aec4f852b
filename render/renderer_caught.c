/* Shadows of catchers over the backdrop: of a picture that is done, pixel by pixel; and of one that
 * is shown while it is rendered, where views share their samples. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/caught.h"
#include "render/renderer.h"
#include "render/transport/sampler.h"

#define LEAST_POINTS 8
#define MOST_POINTS 4096
/* A smooth shade is made of so many samples of lights, of so many pixels to each side: the error of
 * a half shadow is 0.8 % then, when the mean ends, which is not seen pixel by pixel. */
#define ENOUGH 4096
#define MOST_REACH 3
/* From so many samples on the darkness of a pixel tells it from that of others. */
#define KNOWN 32.0f

int lf_catch_points(double native)
{
    return (int)fmin(fmax(native, LEAST_POINTS), MOST_POINTS);
}

static uint64_t key_of(const lf_catch_pixel *p)
{
    return lf_hash64(p->seed, (uint64_t)(unsigned)p->row << 40 | (uint64_t)(unsigned)p->view << 32 |
                                  (unsigned)p->column);
}

/* A ray through a pixel, and the numbers for its light samples. */
typedef struct caught_ray {
    lf_vec3 eye, w;
    float x;    /* of the film point, in columns */
    float u[5]; /* for lf_catcher_light */
} caught_ray;

static caught_ray ray_of(const lf_catch_pixel *p, uint64_t key, int i)
{
    const lf_rig *rig = p->rig;
    lf_sampler sampler;
    caught_ray ray;
    float film[2];
    lf_sampler_init(&sampler, LF_SAMPLER_OWEN, key, (uint32_t)i);
    lf_sampler_2d(&sampler, film);
    lf_sampler_2d(&sampler, ray.u + 1);
    lf_sampler_2d(&sampler, ray.u + 3);
    ray.u[0] = lf_sampler_1d(&sampler);
    ray.x = (float)p->column + film[0];
    float y = rig->y0 + ((float)p->row + film[1]) * rig->dy;
    ray.eye = lf_rig_point(rig, rig->b[p->view], 0.0f, 0.0f);
    ray.w = lf_rig_direction(rig, lf_rig_slope(rig, p->view, ray.x), y / rig->distance, 1.0f);
    return ray;
}

float lf_catch_open(const lf_scene *scene, double met)
{
    return scene->n_volumes > 0 ? 1.0f : (float)fmin(fmax(1.0 - met, 0.0), 1.0);
}

double lf_catch_shade(lf_tracer *tracer, const lf_catch_pixel *pixel, int n, float open)
{
    const uint64_t key = key_of(pixel);
    double light[2] = {0.0, 0.0};
    double caught = 0.0;
    tracer->rng = lf_hash64(key, 1);
    for (int i = 0; i < n; i++) {
        const caught_ray ray = ray_of(pixel, key, i);
        lf_hit hit;
        float passed;
        lf_trace_caught(tracer, ray.eye, ray.w, &hit, &passed);
        if (!(passed > 0.0f))
            continue;
        lf_catcher_light(tracer, &hit, ray.u, light);
        caught += (double)passed;
    }
    return light[1] > 0.0 ? fmax(1.0 - light[0] / light[1], 0.0) * fmin(caught / n, (double)open)
                          : 0.0;
}

/* -------------------------------------------------------------------------- a whole picture -- */

typedef struct shade_job {
    const lf_renderer *renderer;
    lf_rig rig;
    float *out;
} shade_job;

static bool was_visited(const lf_film *film, int row)
{
    return row >= 0 && row < film->height && film->rows[row].n[0] + film->rows[row].n[1] > 0.0;
}

/* The nearest row that was visited; the row itself where none was. */
static int visited_near(const lf_film *film, int row)
{
    for (int apart = 0; apart < film->height; apart++)
        for (int side = -1; side <= 1; side += 2)
            if (was_visited(film, row + side * apart))
                return row + side * apart;
    return row;
}

/* The share of a pixel's film points that met something. */
static double met_by(const lf_film *film, int row, size_t pixel)
{
    const double *n = film->rows[row].n;
    double met = 0.0;
    for (int h = 0; h < 2; h++)
        met += n[h] > 0.0 ? n[h] * (double)lf_film_at(film, row, h).q[pixel] : 0.0;
    return met / fmax(n[0] + n[1], 1e-30);
}

/* What is seen behind the catchers of a row. */
static lf_vec3 behind(const lf_scene *scene, const lf_rig *rig, int row)
{
    const float y = rig->y0 + ((float)row + 0.5f) * rig->dy;
    return lf_backdrop_at(&scene->backdrop, lf_rig_height_between(rig, y / rig->distance));
}

static void take(float *out, float shade, lf_vec3 backdrop)
{
    out[0] -= shade * backdrop.x;
    out[1] -= shade * backdrop.y;
    out[2] -= shade * backdrop.z;
}

static void shade_row(void *context, int row, int worker)
{
    const shade_job *job = context;
    const lf_rig *rig = &job->rig;
    const lf_renderer *renderer = job->renderer;
    const int near = visited_near(&renderer->film, row);
    const double *native = renderer->film.rows[near].n;
    const int n = lf_catch_points(native[0] + native[1]);
    const lf_vec3 backdrop = behind(renderer->scene, rig, row);
    float *out = job->out + (size_t)row * (size_t)rig->n_views * (size_t)rig->width * 3;
    lf_tracer tracer = {.scene = renderer->scene};
    (void)worker;
    for (int view = 0; view < rig->n_views; view++)
        for (int column = 0; column < rig->width; column++, out += 3) {
            const lf_catch_pixel pixel = {rig, renderer->settings.seed, view, row, column};
            const float open = lf_catch_open(
                renderer->scene,
                met_by(&renderer->film, near, (size_t)view * (size_t)rig->width + (size_t)column));
            take(out, (float)lf_catch_shade(&tracer, &pixel, n, open), backdrop);
        }
}

static bool catches(const lf_scene *scene)
{
    return scene->looks.caught && scene->backdrop.given;
}

lf_status lf_renderer_catch_shadows(const lf_renderer *renderer, float *picture,
                                    const lf_cancel *cancel)
{
    shade_job job = {.renderer = renderer};
    job.out = picture;
    if (!catches(renderer->scene))
        return LF_OK;
    lf_status status = lf_rig_init(&job.rig, &renderer->settings, renderer->scene->origin, NULL);
    return status == LF_OK
               ? lf_pool_run(renderer->pool, renderer->film.height, shade_row, &job, cancel)
               : status;
}

/* ---------------------------------------------------------------------- while it is rendered -- */

/* Of a view pixel. A pixel without a sample of its own has the ray of its first one, so that it is
 * known whether it sees a catcher, and where. */
typedef struct caught_sums {
    float lit, all; /* lf_catcher_light's, of this and other views */
    float samples;  /* how many these are of */
    float caught;   /* what came to catchers of its own rays ... */
    float n;        /* ... and how many these were */
    float nearness; /* D/Z of the first that did */
} caught_sums;

struct lf_caught {
    const lf_renderer *renderer;
    lf_rig rig;
    int n_views, width, height;
    int stride;        /* from the view of a step to that of the next: all of them in turn */
    caught_sums *sums; /* [row][view][column] */
    float *smooth;     /* [row][view][column]: darkness */
    bool *smoothed;    /* [row]: it has been */
    int *steps;        /* [row]; each is a sample of one view's pixel in every column */
};

void lf_caught_destroy(lf_caught *caught)
{
    if (!caught)
        return;
    lf_free(caught->sums);
    lf_free(caught->smooth);
    lf_free(caught->smoothed);
    lf_free(caught->steps);
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

static lf_caught *make(int n_views, int width, int height)
{
    lf_caught *caught = lf_calloc(1, sizeof *caught);
    if (!caught)
        return NULL;
    caught->n_views = n_views;
    caught->width = width;
    caught->height = height;
    /* by the golden section: whatever steps there are lie evenly among the views */
    caught->stride = (int)(0.618 * n_views) + 1;
    while (divisor(caught->stride, n_views) > 1)
        caught->stride++;
    caught->sums = lf_calloc(row_pixels(caught) * (size_t)height, sizeof *caught->sums);
    caught->steps = lf_calloc((size_t)height, sizeof *caught->steps);
    caught->smooth = lf_calloc(row_pixels(caught) * (size_t)height, sizeof *caught->smooth);
    caught->smoothed = lf_calloc((size_t)height, sizeof *caught->smoothed);
    if (caught->sums && caught->steps && caught->smooth && caught->smoothed)
        return caught;
    lf_caught_destroy(caught);
    return NULL;
}

lf_status lf_caught_begin(lf_caught **caught, const lf_renderer *renderer)
{
    const int n_views = renderer->settings.camera.n_views, width = renderer->settings.width,
              height = renderer->settings.height;
    lf_caught *c = *caught;
    if (c && (!catches(renderer->scene) || c->n_views != n_views || c->width != width ||
              c->height != height)) {
        lf_caught_destroy(c);
        c = NULL;
    }
    *caught = c;
    if (!catches(renderer->scene))
        return LF_OK;
    if (!c)
        *caught = c = make(n_views, width, height);
    if (!c)
        return LF_E_NOMEM;
    c->renderer = renderer;
    memset(c->steps, 0, (size_t)height * sizeof *c->steps);
    memset(c->smoothed, 0, (size_t)height * sizeof *c->smoothed);
    return lf_rig_init(&c->rig, &renderer->settings, renderer->scene->origin, NULL);
}

static float nearness_of(const lf_rig *rig, lf_vec3 p)
{
    return lf_nearness(rig->distance, lf_dot(lf_sub(p, rig->eye), rig->forward));
}

/* The first ray of every pixel. */
static void look(lf_tracer *tracer, const lf_caught *caught, int row, caught_sums *sums)
{
    for (int view = 0; view < caught->n_views; view++)
        for (int column = 0; column < caught->width; column++, sums++) {
            const lf_catch_pixel pixel = {&caught->rig, caught->renderer->settings.seed, view, row,
                                          column};
            const uint64_t key = key_of(&pixel);
            const caught_ray ray = ray_of(&pixel, key, 0);
            lf_hit hit;
            *sums = (caught_sums){0};
            tracer->rng = lf_hash64(key, 1);
            lf_trace_caught(tracer, ray.eye, ray.w, &hit, &sums->caught);
            if (sums->caught > 0.0f)
                sums->nearness = nearness_of(&caught->rig, hit.p);
        }
}

/* Depths D/Z that may be of one place within a pixel. */
static bool may_be_one_place(float a, float b)
{
    return fabsf(a - b) < 0.01f + 0.01f * lf_min(a, b);
}

/* A sample at x of a view, in all others where the catcher is seen there: its point lies in one row
 * of all views. */
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

static void add_sample(lf_tracer *tracer, const lf_caught *caught, const lf_catch_pixel *pixel,
                       caught_sums *sums)
{
    caught_sums *own = sums + (size_t)pixel->view * (size_t)caught->width + pixel->column;
    const uint64_t key = key_of(pixel);
    const caught_ray ray = ray_of(pixel, key, (int)own->n);
    double light[2] = {0.0, 0.0};
    lf_hit hit;
    float passed;
    tracer->rng = lf_hash64(key, 1 + (uint64_t)own->n);
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
}

/* How many steps a row is to have after this call. */
static int steps_wanted(const lf_caught *caught, int row)
{
    const lf_film *film = &caught->renderer->film;
    const int steps = caught->steps[row];
    const double native = film->rows[row].n[0] + film->rows[row].n[1];
    if (!(native > 0.0))
        return 0;
    const int wanted = lf_catch_points(ceil(native * caught->n_views)),
              most = steps == 0                       ? LEAST_POINTS
                     : caught->n_views > LEAST_POINTS ? steps + caught->n_views
                                                      : steps + LEAST_POINTS;
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
            const lf_catch_pixel pixel = {&caught->rig, caught->renderer->settings.seed, view, row,
                                          column};
            add_sample(&tracer, caught, &pixel, sums);
        }
        caught->steps[row] = step + 1;
    }
}

int lf_caught_samples(const lf_caught *caught, int row)
{
    return caught->steps[row];
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

/* Whether the darkness of two pixels may differ by chance alone: the test of two proportions, at
 * three standard deviations, as if each sample were lit or not; 0.02 is not seen. So the mean ends
 * at the edge of a sharp shadow. */
static bool may_be_one_shade(const caught_sums *a, const caught_sums *b)
{
    if (a->samples < KNOWN || b->samples < KNOWN || !(a->all > 0.0f && b->all > 0.0f))
        return true;
    const float mean = lf_min((a->lit + b->lit) / (a->all + b->all), 1.0f),
                apart = a->lit / a->all - b->lit / b->all,
                variance = mean * (1.0f - mean) * (1.0f / a->samples + 1.0f / b->samples);
    return apart * apart <= 9.0f * variance + 0.02f * 0.02f;
}

/* The mean over neighbours that lie as deep and are as dark, as far as is known. */
static float smooth_at(const lf_caught *caught, int row, int view, int column, int reach)
{
    const size_t line = (size_t)view * (size_t)caught->width;
    const caught_sums *own =
        caught->sums + (size_t)row * row_pixels(caught) + line + (size_t)column;
    const int top = row > reach ? row - reach : 0, left = column > reach ? column - reach : 0,
              bottom = row + reach < caught->height ? row + reach : caught->height - 1,
              right = column + reach < caught->width ? column + reach : caught->width - 1;
    float lit = 0.0f, all = 0.0f;
    for (int r = top; own->caught > 0.0f && r <= bottom; r++) {
        if (caught->steps[r] == 0)
            continue;
        const caught_sums *s = caught->sums + (size_t)r * row_pixels(caught) + line;
        for (int c = left; c <= right; c++)
            if (s[c].caught > 0.0f && may_be_one_place(s[c].nearness, own->nearness) &&
                may_be_one_shade(s + c, own)) {
                lit += s[c].lit;
                all += s[c].all;
            }
    }
    return darkness(lit, all);
}

static void smooth_row(void *context, int row, int worker)
{
    lf_caught *caught = context;
    const int reach = reach_of(caught->steps[row]);
    float *out = caught->smooth + (size_t)row * row_pixels(caught);
    (void)worker;
    caught->smoothed[row] = caught->steps[row] > 0;
    for (int view = 0; view < caught->n_views && caught->smoothed[row]; view++)
        for (int column = 0; column < caught->width; column++)
            *out++ = smooth_at(caught, row, view, column, reach);
}

lf_status lf_caught_smooth(lf_caught *caught, const lf_cancel *cancel)
{
    return lf_pool_run(caught->renderer->pool, caught->height, smooth_row, caught, cancel);
}

void lf_caught_take(const lf_caught *caught, int row, bool smooth, float *picture)
{
    const lf_renderer *renderer = caught->renderer;
    const size_t first = (size_t)row * row_pixels(caught);
    const caught_sums *s = caught->sums + first;
    const lf_vec3 backdrop = behind(renderer->scene, &caught->rig, row);
    if (caught->steps[row] == 0)
        return;
    smooth = smooth && caught->smoothed[row];
    for (size_t i = 0; i < row_pixels(caught); i++, s++, picture += 3) {
        const float dark = smooth ? caught->smooth[first + i] : darkness(s->lit, s->all);
        if (dark > 0.0f)
            take(picture,
                 dark * lf_min(s->caught / lf_max(s->n, 1.0f),
                               lf_catch_open(renderer->scene, met_by(&renderer->film, row, i))),
                 backdrop);
    }
}

/* ------------------------------------------------------------------ a picture that is fitted -- */

typedef struct sharing_job {
    lf_caught *caught;
    shade_job whole; /* for rows that were not visited */
} sharing_job;

static void add_row(void *context, int row, int worker)
{
    lf_caught *caught = context;
    (void)worker;
    while (caught->steps[row] < steps_wanted(caught, row))
        lf_caught_add(caught, row);
}

static void take_row(void *context, int row, int worker)
{
    sharing_job *job = context;
    const lf_caught *caught = job->caught;
    if (caught->steps[row] == 0)
        shade_row(&job->whole, row, worker);
    else
        lf_caught_take(caught, row, true, job->whole.out + 3 * (size_t)row * row_pixels(caught));
}

lf_status lf_renderer_catch_smoothly(const lf_renderer *renderer, float *picture,
                                     const lf_cancel *cancel)
{
    sharing_job job = {.whole = {.renderer = renderer}};
    lf_pool *pool = renderer->pool;
    lf_status status = lf_caught_begin(&job.caught, renderer);
    if (!job.caught)
        return status;
    job.whole.rig = job.caught->rig;
    job.whole.out = picture;
    if (status == LF_OK)
        status = lf_pool_run(pool, job.caught->height, add_row, job.caught, cancel);
    if (status == LF_OK)
        status = lf_caught_smooth(job.caught, cancel);
    if (status == LF_OK)
        status = lf_pool_run(pool, job.caught->height, take_row, &job, cancel);
    lf_caught_destroy(job.caught);
    return status;
}
