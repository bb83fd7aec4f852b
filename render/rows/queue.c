#include "render/rows/queue.h"

/* Look-ups between two questions whether the visit is cancelled, about: some hundredths of a
 * second. And pivots that keep lanes busy. */
enum { MOST_LOOKUPS = 1 << 20, LEAST_PIVOTS = 16 };

static void set_key(uint32_t *low, uint32_t *high, uint64_t key)
{
    *low = (uint32_t)key;
    *high = (uint32_t)(key >> 32);
}

/* The pivot's light, and what its shadow ray starts with. */
static void prepare_light(lf_queue *queue, const lf_visit *visit, const lf_pivot *pivot, int at)
{
    lf_queued *item = &queue->item[at];
    const lf_vec3 p = pivot->event.p;
    float u[3];
    u[0] = lf_sampler_1d(pivot->sampler);
    lf_sampler_2d(pivot->sampler, u + 1);
    item->has_light = lf_light_draw(visit->scene, p, u, &item->light);
    /* anywhere, where there is none */
    lf_vec3 toward = item->has_light ? item->light.wi : lf_v3(0.0f, 1.0f, 0.0f);
    queue->toward[0][at] = toward.x;
    queue->toward[1][at] = toward.y;
    queue->toward[2][at] = toward.z;
    for (int i = 0; i < 3; i++) {
        const float *row = queue->lanes->to_volume[i];
        queue->q[i][at] = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
    }
    set_key(&queue->random[0][at], &queue->random[1][at], lf_hash64(item->rng, 0));
}

/* Directions of its suffixes: the sampler's, and from it a lattice around the sphere. */
static void prepare_paths(lf_queue *queue, const lf_visit *visit, const lf_pivot *pivot, int at)
{
    const lf_volume *volume = &visit->scene->volumes[pivot->event.volume];
    lf_queued *item = &queue->item[at];
    float u[3];
    lf_sampler_2d(pivot->sampler, u);
    u[2] = lf_sampler_1d(pivot->sampler);
    for (int k = 0; k < queue->each; k++) {
        const int path = at * queue->each + k;
        const float golden = 0.61803399f, share = (float)k / (float)queue->each;
        float v[3] = {u[0] + share, u[1] + golden * (float)k, u[2]};
        v[0] -= floorf(v[0]);
        v[1] -= floorf(v[1]);
        lf_vec3 wi = lf_volume_phase_sample(volume, pivot->event.w, v);
        item->wi = k == 0 ? wi : item->wi;
        for (int i = 0; i < 3; i++)
            queue->from[i][path] = queue->q[i][at];
        queue->wi[0][path] = wi.x;
        queue->wi[1][path] = wi.y;
        queue->wi[2][path] = wi.z;
        set_key(&queue->path_random[0][path], &queue->path_random[1][path],
                lf_hash64(item->rng, (uint64_t)k + 1));
    }
}

void lf_queue_push(lf_queue *queue, lf_visit *visit, int view, int column, const lf_pivot *pivot)
{
    const int at = queue->n++;
    queue->item[at] = (lf_queued){.p = pivot->event.p,
                                  .w = pivot->event.w,
                                  .x = pivot->x,
                                  .z = pivot->z,
                                  .lx = pivot->lx,
                                  .boost = pivot->boost,
                                  .alone = visit->alone,
                                  .medium = pivot->medium,
                                  .volume = pivot->event.volume,
                                  .view = view,
                                  .column = column,
                                  .rng = visit->worker->tracer.rng};
    prepare_light(queue, visit, pivot, at);
    prepare_paths(queue, visit, pivot, at);
    if (queue->n >= queue->most)
        lf_queue_flush(queue, visit);
}

/* One of a pivot's directions and what it brings. */
static void take_direction(const lf_queue *queue, const lf_scene *scene, int path, lf_suffix *out)
{
    out->has_direction = true;
    out->wi = lf_v3(queue->wi[0][path], queue->wi[1][path], queue->wi[2][path]);
    out->scattered =
        lf_v3(queue->radiance[0][path], queue->radiance[1][path], queue->radiance[2][path]);
    if (queue->lanes->has && queue->escaped[path] > 0.0f)
        out->found = lf_light_escape(scene, out->wi, &out->found_pdf);
}

/* The suffix of a pivot whose every view is sent the same: the mean of what its directions bring,
 * what they found in balance with the light sample. */
static void take_mean(const lf_queue *queue, const lf_scene *scene, int at, lf_suffix *out)
{
    const lf_queued *item = &queue->item[at];
    const lf_volume *volume = &scene->volumes[item->volume];
    const float n = (float)queue->each;
    for (int k = 0; k < queue->each; k++) {
        lf_suffix one = {0};
        take_direction(queue, scene, at * queue->each + k, &one);
        if (one.found_pdf > 0.0f) {
            float density = n * lf_volume_phase(volume, item->w, one.wi);
            one.found = lf_scale(one.found, density / (density + one.found_pdf));
        }
        out->scattered = lf_madd(out->scattered, 1.0f / n, lf_add(one.scattered, one.found));
    }
    out->has_direction = true;
    out->wi = item->wi;
    if (item->has_light && !item->light.delta) /* one of n is counted where it is spread */
        out->light.pdf += (n - 1.0f) * lf_volume_phase(volume, item->w, item->light.wi);
}

/* The suffix of a pivot: where every view is sent the same, one; else a chain of them. */
static void take_suffixes(const lf_queue *queue, const lf_scene *scene, int at, bool same,
                          lf_suffix out[LF_QUEUE_EACH])
{
    const lf_queued *item = &queue->item[at];
    out[0] = (lf_suffix){
        .has_light = item->has_light, .light = item->light, .light_visible = queue->left[at]};
    if (same) {
        take_mean(queue, scene, at, &out[0]);
        return;
    }
    for (int k = 0; k < queue->each; k++) {
        if (k > 0) {
            out[k] = (lf_suffix){0};
            out[k - 1].next = &out[k];
        }
        take_direction(queue, scene, at * queue->each + k, &out[k]);
    }
}

static void spread(const lf_queue *queue, lf_visit *visit, int at)
{
    const lf_queued *item = &queue->item[at];
    /* a view's own lobe is divided out */
    bool same = !visit->acting->entry.shares ||
                lf_volume_is_isotropic(&visit->scene->volumes[item->volume]);
    lf_pivot pivot;
    lf_suffix suffix[LF_QUEUE_EACH];
    lf_pivot_begin(&pivot, item->w, item->lx, NULL);
    pivot.event.kind = LF_EVENT_MEDIUM;
    pivot.event.p = item->p;
    pivot.event.volume = item->volume;
    pivot.medium = item->medium;
    pivot.x = item->x;
    pivot.z = item->z;
    pivot.boost = item->boost;
    take_suffixes(queue, visit->scene, at, same, suffix);
    visit->alone = item->alone;
    visit->worker->tracer.rng = item->rng;
    visit->acting->pivot(visit, item->view, item->column, &pivot, suffix);
}

/* Twice as many as it was, or as many as take MOST_LOOKUPS by what these took. */
static void set_most(lf_queue *queue, int64_t lookups)
{
    const int64_t fit = lookups > 0 ? queue->n * (int64_t)MOST_LOOKUPS / lookups : LF_QUEUE_PIVOTS;
    int64_t most = 2 * queue->most;
    most = most < fit ? most : fit;
    most = most < LF_QUEUE_PIVOTS ? most : LF_QUEUE_PIVOTS;
    queue->most = most > LEAST_PIVOTS ? most : LEAST_PIVOTS;
}

void lf_queue_flush(lf_queue *queue, lf_visit *visit)
{
    const lf_lane_paths paths = {
        .n = queue->n * queue->each,
        .max_depth = visit->max_depth,
        .q = {queue->from[0], queue->from[1], queue->from[2]},
        .w = {queue->wi[0], queue->wi[1], queue->wi[2]},
        .random = {queue->path_random[0], queue->path_random[1]},
        .radiance = {queue->radiance[0], queue->radiance[1], queue->radiance[2]},
        .lit = {queue->lit[0], queue->lit[1], queue->lit[2]},
        .escaped = queue->escaped,
    };
    const lf_lane_points points = {
        .n = queue->n,
        .q = {queue->q[0], queue->q[1], queue->q[2]},
        .w = {queue->toward[0], queue->toward[1], queue->toward[2]},
        .random = {queue->random[0], queue->random[1]},
        .left = queue->left,
    };
    if (queue->n == 0)
        return;
    const int64_t lookups = queue->suffixes->trace(queue->lanes, &paths, &queue->memory) +
                            queue->suffixes->light(queue->lanes, &points, &queue->memory);
    visit->worker->tracer.lookups += lookups;
    set_most(queue, lookups);
    const float alone = visit->alone;
    for (int i = 0; i < queue->n; i++)
        spread(queue, visit, i);
    visit->alone = alone;
    queue->n = 0;
}
