#include "render/rows/splitting.h"

#include <math.h>

#include "base/alloc.h"
#include "render/rows/pilot_path.h"

/* Pixels of the pilot, over all views, in chunks. */
enum { PIXELS = LF_PILOT_ACROSS * LF_PILOT_DOWN, CHUNK = 128 };
/* A pair of pivots in each pixel, a pair of suffixes at each pivot. */
enum { PAIR = 2 };
/* Thresholds of the roulette: LF_ROULETTE, or 1. */
enum { LATE, EARLY, ROULETTES };
/* Groups of pixels that must agree. */
enum { GROUPS = 4 };

/* Directions of pivots on other surfaces in mvpt (lf_fan_directions). */
#define OTHER_DIRECTIONS 4.0
/* What a pivot takes itself, in rays: its own ray, and its views, of which each takes a part. */
#define COST_OF_PIVOT 0.9
#define COST_OF_VIEW 0.033
/* Views of a pivot over the visits in which a pixel gets a sample of its own: an edge is found once
 * in each visit, and its views do not share it. */
#define SHARED 0.16
/* The gain from which twice the suffixes are better; and from which a choice is clear. */
#define LEAST_GAIN 1.04
#define CLEAR_GAIN 1.25
/* Most of the pivots that may lie on other surfaces: their rare highlights spoil the measurement.
 */
#define MOST_OTHERS 0.1
/* How far the effect of roulette may differ between groups. */
#define MOST_SPREAD 1.5
#define KEY UINT64_C(0x73756666697865)

bool lf_splitting_serves(const lf_scene *scene, const lf_render_settings *settings)
{
    const lf_traits has = scene->traits | lf_view_traits(settings);
    return scene->embree && !(has & ~LF_TRAITS_SURFACE_SCENES) &&
           lf_max_depth(scene, settings->max_depth) > 1;
}

/* ------------------------------------------------------------------------------- the samples -- */

/* What a pixel adds to the sums. */
typedef struct pixel_sample {
    int tile;
    float mean;    /* of the light that its rays bring */
    float between; /* variance between its pivots, without that within a pivot */
    float edge;    /* the same between a pivot and a ray without one */
    /* variance within diffuse pivots, of light samples and of directions, and of other pivots */
    float light, direction[ROULETTES], other[ROULETTES];
    /* rays: of light samples and of directions of diffuse pivots, and of other pivots; pivots, and
     * others of them */
    float light_rays, rays[ROULETTES], other_rays[ROULETTES], pivots, others;
} pixel_sample;

typedef struct piloting {
    const lf_scene *scene;
    const lf_rig *rig;
    lf_tracer *tracers;
    pixel_sample *pixels;
    int max_depth;
    bool alone;
} piloting;

/* A pivot with its suffixes. */
typedef struct split_pivot {
    lf_event event;
    bool met, diffuse;
    float seen; /* what the camera sees there itself */
    lf_vec3 light[PAIR], sum[ROULETTES][PAIR];
    float light_rays, rays[ROULETTES]; /* of the pair */
} split_pivot;

static float product(lf_vec3 a, lf_vec3 b)
{
    return lf_mean3(lf_mul(a, b));
}

static void sample_suffixes(const piloting *p, uint64_t key, lf_tracer *tracer, split_pivot *out)
{
    const float spread = tracer->spread;
    for (int i = 0; i < PAIR * ROULETTES; i++) {
        const int k = i / ROULETTES, roulette = i % ROULETTES;
        lf_sampler sampler;
        lf_suffix suffix = {0};
        tracer->rng = lf_hash64(key, (uint64_t)k + 1);
        tracer->spread = spread;
        tracer->roulette = roulette == EARLY ? 1.0f - LF_ROULETTE : 0.0f;
        lf_sampler_init(&sampler, LF_SAMPLER_INDEPENDENT, tracer->rng, 0);
        const int64_t rays = tracer->rays;
        lf_pilot_suffix(tracer, &out->event, &sampler, &suffix);
        lf_pilot_follow(tracer, &out->event, p->max_depth, NULL, &suffix);
        out->sum[roulette][k] = lf_pilot_radiance(p->scene, &out->event, &suffix);
        const float of_light = suffix.has_light ? 1.0f : 0.0f;
        out->rays[roulette] += (float)(tracer->rays - rays) - of_light;
        suffix.has_direction = false;
        out->light[k] = lf_pilot_radiance(p->scene, &out->event, &suffix);
        out->light_rays += of_light / ROULETTES;
    }
    tracer->roulette = 0.0f;
}

/* Adds what is within a pivot to its pixel. */
static void add_within(const split_pivot *pivot, pixel_sample *out)
{
    const lf_vec3 *l = pivot->light;
    out->pivots += 1.0f;
    out->others += pivot->diffuse ? 0.0f : 1.0f;
    out->mean += 0.25f * lf_mean3(lf_add(pivot->sum[LATE][0], pivot->sum[LATE][1]));
    if (pivot->diffuse) {
        out->light += lf_pilot_variance(l[0], l[1]);
        out->light_rays += 0.5f * pivot->light_rays;
    }
    for (int r = 0; r < ROULETTES; r++) {
        const lf_vec3 *y = pivot->sum[r];
        if (pivot->diffuse) {
            out->direction[r] += lf_pilot_variance(lf_sub(y[0], l[0]), lf_sub(y[1], l[1]));
            out->rays[r] += 0.5f * pivot->rays[r];
        } else {
            out->other[r] += lf_pilot_variance(y[0], y[1]);
            out->other_rays[r] += 0.5f * (pivot->rays[r] + pivot->light_rays);
        }
    }
}

/* What a pivot sends, and what the camera sees there. */
static float light_of(const split_pivot *pivot, int suffix)
{
    return pivot->seen + (pivot->met ? lf_mean3(pivot->sum[LATE][suffix]) : 0.0f);
}

/* Adds what is between the pivots of a pixel: products of independent differences. */
static void compare(const split_pivot pair[PAIR], pixel_sample *out)
{
    const split_pivot *a = &pair[0], *b = &pair[1];
    if (a->met != b->met)
        out->edge = 0.5f * (light_of(a, 0) - light_of(b, 0)) * (light_of(a, 1) - light_of(b, 1));
    for (int r = 0; r < ROULETTES && a->met && b->met; r++)
        out->between +=
            product(lf_sub(a->sum[r][0], b->sum[r][0]), lf_sub(a->sum[r][1], b->sum[r][1])) /
            ROULETTES;
}

static void sample_pixel(const piloting *p, int i, lf_tracer *tracer)
{
    const lf_rig *rig = p->rig;
    const int x = i % LF_PILOT_ACROSS, y = i / LF_PILOT_ACROSS,
              view = lf_pilot_view(rig->n_views, x, y),
              column = (int)(((float)x + 0.5f) / LF_PILOT_ACROSS * (float)rig->width),
              row = (int)(((float)y + 0.5f) / LF_PILOT_DOWN * (float)rig->height);
    pixel_sample *out = &p->pixels[i];
    split_pivot pair[PAIR] = {0};
    out->tile = lf_pilot_part(rig, row, column);
    for (int k = 0; k < PAIR; k++) {
        split_pivot *pivot = &pair[k];
        const uint64_t key = lf_hash64(KEY, (uint64_t)(PAIR * i + k));
        tracer->rng = key;
        const float u = lf_rng(tracer), v = lf_rng(tracer);
        pivot->met =
            lf_pilot_pivot(tracer, rig, view, (const float[]){(float)column + u, (float)row + v},
                           &pivot->event, &pivot->seen);
        out->mean += 0.5f * pivot->seen;
        if (!pivot->met)
            continue;
        pivot->diffuse = !lf_is_view_dependent(p->scene, &pivot->event);
        sample_suffixes(p, key, tracer, pivot);
        add_within(pivot, out);
    }
    compare(pair, out);
}

static void sample_chunk(void *context, int item, int worker)
{
    const piloting *p = context;
    lf_tracer *tracer = &p->tracers[worker];
    tracer->scene = p->scene;
    for (int i = item * CHUNK; i < (item + 1) * CHUNK; i++)
        sample_pixel(p, i, tracer);
}

/* -------------------------------------------------------------------------------- the choice -- */

/* Sums over pixels; variances are relative. */
typedef struct tally {
    double between, between_squares; /* of the pixels' shares of it */
    double edge, light, direction[ROULETTES], other[ROULETTES];
    double light_rays, rays[ROULETTES], other_rays[ROULETTES], pivots, others;
} tally;

static void add(tally *sum, const pixel_sample *pixel, double weight)
{
    const double between = weight * (double)pixel->between;
    sum->between += between;
    sum->between_squares += between * between;
    sum->edge += weight * (double)pixel->edge;
    sum->light += weight * (double)pixel->light;
    sum->light_rays += (double)pixel->light_rays;
    sum->pivots += (double)pixel->pivots;
    sum->others += (double)pixel->others;
    for (int r = 0; r < ROULETTES; r++) {
        sum->direction[r] += weight * (double)pixel->direction[r];
        sum->other[r] += weight * (double)pixel->other[r];
        sum->rays[r] += (double)pixel->rays[r];
        sum->other_rays[r] += (double)pixel->other_rays[r];
    }
}

static void sum_up(const piloting *p, tally out[GROUPS + 1])
{
    lf_pilot_light light = {0};
    for (int i = 0; i < PIXELS; i++)
        lf_pilot_light_add(&light, p->pixels[i].tile, p->pixels[i].mean);
    for (int i = 0; i < PIXELS; i++) {
        const double mean = lf_pilot_brightness(&light, p->pixels[i].tile),
                     weight = 1.0 / (mean * mean + 0.01);
        add(&out[i % GROUPS], &p->pixels[i], weight);
        add(&out[GROUPS], &p->pixels[i], weight);
    }
}

/* Variance times cost. */
static double loss(const piloting *p, const tally *sum, const lf_splitting *of)
{
    const int r = of->roulette > 0.0f ? EARLY : LATE;
    const double directions = p->alone ? 1.0 : OTHER_DIRECTIONS, n = of->suffixes, l = of->lights,
                 pivot = COST_OF_PIVOT + (p->alone ? 0.0 : COST_OF_VIEW * p->rig->n_views),
                 edge = p->alone ? 1.0 : SHARED * p->rig->n_views,
                 variance = fmax(sum->between, 0.0) + edge * fmax(sum->edge, 0.0) + sum->light / l +
                            sum->direction[r] / n + sum->other[r] / directions,
                 cost = (double)PAIR * PIXELS + pivot * sum->pivots + l * sum->light_rays +
                        n * sum->rays[r] + directions * sum->other_rays[r];
    return variance * cost;
}

static double gain(const piloting *p, const tally *sum, const lf_splitting *from,
                   const lf_splitting *to)
{
    const double before = loss(p, sum, from), after = loss(p, sum, to);
    return after > 0.0 ? before / after : 1.0;
}

/* Whether a choice is clearly better than one suffix, even if pivots differ by a standard error
 * more than found: the noise of their suffixes hides what is between them. */
static bool is_clear(const piloting *p, const tally sums[GROUPS + 1], const lf_splitting *chosen)
{
    tally all = sums[GROUPS];
    all.between = fmax(all.between, 0.0) + sqrt(all.between_squares);
    bool clear = gain(p, &all, &LF_SPLITTING_NONE, chosen) > CLEAR_GAIN;
    for (int i = 0; i < GROUPS; i++)
        clear = clear && gain(p, &sums[i], &LF_SPLITTING_NONE, chosen) > 1.0;
    return clear;
}

static double within(const tally *sum, int roulette)
{
    return sum->direction[roulette] + sum->other[roulette];
}

/* Whether the effect of early roulette is known. It can only add to the variance: if it seems not
 * to, or differs much between groups, rare bright paths decide. */
static bool knows_roulette(const tally sums[GROUPS + 1])
{
    double least = INFINITY, most = 0.0;
    for (int i = 0; i < GROUPS; i++) {
        const double before = within(&sums[i], LATE),
                     ratio = before > 0.0 ? within(&sums[i], EARLY) / before : 0.0;
        least = fmin(least, ratio);
        most = fmax(most, ratio);
    }
    return least >= 1.0 && most < MOST_SPREAD * least;
}

/* Goes from few suffixes to many, as long as each step is better. */
static lf_splitting best(const piloting *p, const tally sums[GROUPS + 1])
{
    const int roulettes = knows_roulette(sums) ? ROULETTES : 1;
    lf_splitting chosen = LF_SPLITTING_NONE;
    if (sums[GROUPS].others > MOST_OTHERS * sums[GROUPS].pivots)
        return chosen;
    for (int n = 2; n <= LF_SUFFIXES_MOST && 2 * chosen.suffixes == n; n *= 2) {
        lf_splitting of_n = chosen;
        double best_gain = LEAST_GAIN;
        for (int i = 0; i < 2 * roulettes; i++) {
            const lf_splitting other = {.suffixes = n,
                                        .lights = i % 2 ? 1 : n,
                                        .roulette = i / 2 == EARLY ? 1.0f - LF_ROULETTE : 0.0f};
            const double other_gain = gain(p, &sums[GROUPS], &chosen, &other);
            if (other_gain > best_gain) {
                of_n = other;
                best_gain = other_gain;
            }
        }
        chosen = of_n;
    }
    return is_clear(p, sums, &chosen) ? chosen : LF_SPLITTING_NONE;
}

static bool has_diffuse(const lf_scene *scene)
{
    bool any = false;
    for (int i = 0; i < scene->n_materials; i++)
        any |= scene->materials[i].has_lobe && !scene->materials[i].kind->view_dependent;
    return any;
}

static lf_status find(piloting *p, lf_pool *pool, lf_splitting *out)
{
    tally sums[GROUPS + 1] = {0};
    p->tracers = lf_calloc((size_t)lf_pool_threads(pool), sizeof *p->tracers);
    p->pixels = lf_calloc(PIXELS, sizeof *p->pixels);
    lf_status status = p->tracers && p->pixels ? LF_OK : LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_pool_run(pool, PIXELS / CHUNK, sample_chunk, p, NULL);
    if (status == LF_OK) {
        sum_up(p, sums);
        *out = best(p, sums);
    }
    lf_free(p->tracers);
    lf_free(p->pixels);
    return status;
}

lf_status lf_splitting_choose(const lf_integrator_input *input, const lf_scene *seen,
                              const lf_rig *rig, bool light_paths, bool alone, lf_splitting *out)
{
    const lf_render_settings *settings = input->settings;
    const int n = settings->suffixes;
    piloting p = {.scene = seen,
                  .rig = rig,
                  .max_depth = lf_max_depth(input->scene, settings->max_depth),
                  .alone = alone};
    *out = LF_SPLITTING_NONE;
    if (n == 0 || !lf_splitting_serves(input->scene, settings) || !has_diffuse(seen))
        return LF_OK;
    if (n == LF_SUFFIXES_AUTO)
        return light_paths ? LF_OK : find(&p, input->pool, out);
    *out =
        (lf_splitting){.suffixes = n,
                       .lights = settings->one_light ? 1 : n,
                       .roulette = n > 1 && settings->early_roulette ? 1.0f - LF_ROULETTE : 0.0f};
    return LF_OK;
}
