#include "render/transport/lanes/suffix_batch.h"

#include <math.h>

#include "render/transport/lanes/lane_surfaces.h"
#include "render/transport/path/phase.h"

/* Look-ups between two checks for cancellation: some hundredths of a second. A_RAY: look-ups that a
 * ray to surfaces costs. LEAST_PIVOTS: pivots that keep lanes busy. FIRST_PIVOTS: pivots of a first
 * batch, when the length of paths is unknown. */
enum { MOST_LOOKUPS = 1 << 20, A_RAY = 8, LEAST_PIVOTS = 16, FIRST_PIVOTS = 64 };

void lf_suffix_batch_init(lf_suffix_batch *batch, const lf_lane_scene *lanes,
                          const lf_suffixes *suffixes, int each)
{
    batch->lanes = lanes;
    batch->suffixes = suffixes;
    batch->each = each;
    batch->most = FIRST_PIVOTS;
}

static void set_key(uint32_t *low, uint32_t *high, uint64_t key)
{
    *low = (uint32_t)key;
    *high = (uint32_t)(key >> 32);
}

/* The pivot's light, and what its shadow ray starts with. */
static void prepare_light(lf_suffix_batch *batch, const lf_scene *scene, int at,
                          lf_sampler *sampler)
{
    lf_batch_pivot *pivot = &batch->pivot[at];
    const lf_vec3 p = pivot->p;
    float u[3];
    u[0] = lf_sampler_1d(sampler);
    lf_sampler_2d(sampler, u + 1);
    pivot->has_light = lf_light_draw(scene, p, u, &pivot->light);
    /* arbitrary, if there is none */
    lf_vec3 toward = pivot->has_light ? pivot->light.wi : lf_v3(0.0f, 1.0f, 0.0f);
    batch->toward[0][at] = toward.x;
    batch->toward[1][at] = toward.y;
    batch->toward[2][at] = toward.z;
    for (int i = 0; i < 3; i++) {
        const float *row = batch->lanes->to_volume[i];
        batch->q[i][at] = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
    }
    set_key(&batch->random[0][at], &batch->random[1][at], lf_hash64(pivot->rng, 0));
}

/* Directions of its suffixes: the sampler's, and a lattice around the sphere that starts there. */
static void prepare_paths(lf_suffix_batch *batch, const lf_scene *scene, int at,
                          lf_sampler *sampler)
{
    const lf_batch_pivot *pivot = &batch->pivot[at];
    float u[3];
    lf_sampler_2d(sampler, u);
    u[2] = lf_sampler_1d(sampler);
    for (int k = 0; k < batch->each; k++) {
        const int path = at * batch->each + k;
        const float golden = 0.61803399f, share = (float)k / (float)batch->each;
        float v[3] = {u[0] + share, u[1] + golden * (float)k, u[2]};
        v[0] -= floorf(v[0]);
        v[1] -= floorf(v[1]);
        lf_vec3 wi = lf_volume_phase_sample(&scene->volumes[pivot->volume], pivot->w, v);
        for (int i = 0; i < 3; i++)
            batch->from[i][path] = batch->q[i][at];
        batch->wi[0][path] = wi.x;
        batch->wi[1][path] = wi.y;
        batch->wi[2][path] = wi.z;
        set_key(&batch->path_random[0][path], &batch->path_random[1][path],
                lf_hash64(pivot->rng, (uint64_t)k + 1));
    }
}

int lf_suffix_batch_add(lf_suffix_batch *batch, const lf_scene *scene, const lf_batch_pivot *pivot,
                        lf_sampler *sampler)
{
    const int at = batch->n++;
    batch->pivot[at] = *pivot;
    prepare_light(batch, scene, at, sampler);
    prepare_paths(batch, scene, at, sampler);
    return at;
}

static int64_t work_of(const lf_tracer *tracer)
{
    return tracer->lookups + A_RAY * tracer->rays;
}

/* Doubles the number, or sets it to what takes MOST_LOOKUPS, judged by the cost of n. */
static void set_most(lf_suffix_batch *batch, int n, int64_t work)
{
    const int64_t fit = work > 0 ? n * (int64_t)MOST_LOOKUPS / work : LF_BATCH_PIVOTS;
    int64_t most = 2 * (int64_t)batch->most;
    most = most < fit ? most : fit;
    most = most < LF_BATCH_PIVOTS ? most : LF_BATCH_PIVOTS;
    batch->most = most > LEAST_PIVOTS ? (int)most : LEAST_PIVOTS;
}

void lf_suffix_batch_trace(lf_suffix_batch *batch, lf_tracer *tracer, int max_depth)
{
    const int first = batch->traced, n = batch->n - first, path = first * batch->each;
    lf_lane_paths paths = {.n = n * batch->each,
                           .max_depth = max_depth,
                           .random = {batch->path_random[0] + path, batch->path_random[1] + path},
                           .escaped = batch->escaped + path};
    lf_lane_points points = {.n = n,
                             .random = {batch->random[0] + first, batch->random[1] + first},
                             .left = batch->left + first};
    for (int i = 0; i < 3; i++) {
        paths.q[i] = batch->from[i] + path;
        paths.w[i] = batch->wi[i] + path;
        paths.radiance[i] = batch->radiance[i] + path;
        paths.lit[i] = batch->lit[i] + path;
        points.q[i] = batch->q[i] + first;
        points.w[i] = batch->toward[i] + first;
    }
    if (n == 0)
        return;
    const int64_t before = work_of(tracer);
    const double cut = tracer->suffixes_cut;
    batch->memory.cut = 0.0;
    batch->memory.surfaces = lf_lane_surfaces_of(tracer);
    const int64_t lookups = batch->suffixes->trace(batch->lanes, &paths, &batch->memory) +
                            batch->suffixes->light(batch->lanes, &points, &batch->memory);
    tracer->lookups += lookups;
    /* of each pivot's paths the mean */
    tracer->suffixes += n;
    tracer->suffixes_cut = cut + (tracer->suffixes_cut - cut + batch->memory.cut) / batch->each;
    batch->traced = batch->n;
    set_most(batch, n, work_of(tracer) - before);
}

void lf_suffix_batch_keep_up(lf_suffix_batch *batch, lf_tracer *tracer, int max_depth)
{
    if (batch->n - batch->traced >= batch->most)
        lf_suffix_batch_trace(batch, tracer, max_depth);
}

void lf_suffix_batch_direction(const lf_suffix_batch *batch, const lf_scene *scene, int at, int k,
                               lf_suffix *out)
{
    const int path = at * batch->each + k;
    out->has_direction = true;
    out->wi = lf_v3(batch->wi[0][path], batch->wi[1][path], batch->wi[2][path]);
    out->scattered =
        lf_v3(batch->radiance[0][path], batch->radiance[1][path], batch->radiance[2][path]);
    if (batch->lanes->has & LF_LANE_SKY && batch->escaped[path] > 0.0f)
        out->found = lf_light_escape(scene, out->wi, &out->found_pdf);
}
