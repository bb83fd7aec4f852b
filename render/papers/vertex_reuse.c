#include "render/papers/vertex_reuse.h"

#include <string.h>

#include "render/papers/path_vertex.h"

/* A path from the vertex where rays join it. */
typedef struct joint {
    const lf_light_path *path;
    bool second; /* at x2, with the rest of the path; false: the direction or light sample at x1 */
    lf_vec3 p;   /* x2 */
    lf_mixture mixture; /* there */
    lf_leaving leaving;
    lf_path_value beyond; /* x2, or x1 */
} joint;

/* How a pixel's ray reaches it. */
typedef struct reach {
    bool found;
    lf_path_value value; /* of the path along this ray */
    lf_coarse_ray gap;   /* the joint: to x2 or to the light */
    double squared;      /* its squared length; 1: no second vertex */
} reach;

typedef struct block {
    const lf_path_space *space;
    lf_tracer *tracer;
    int n;
    const lf_block_pixel *pixels;
    double depth[LF_MAX_BLOCK][LF_MAX_BLOCK]; /* [ray][path]: along the ray, up to x1 */
    lf_path_keeper keepers[LF_MAX_BLOCK];
} block;

/* The streams that have a path, by its first distance. */
static int sort(const block *b, int out[LF_MAX_BLOCK])
{
    int n = 0;
    for (int i = 0; i < b->n; i++) {
        if (!b->pixels[i].sample->kept)
            continue;
        int at = n++;
        for (; at > 0 && b->pixels[out[at - 1]].sample->path.vertex[0].z >
                             b->pixels[i].sample->path.vertex[0].z;
             at--)
            out[at] = out[at - 1];
        out[at] = i;
    }
    return n;
}

/* All first segments: one walk through cells per ray. */
static void find_depths(block *b)
{
    int order[LF_MAX_BLOCK];
    const int n = sort(b, order);
    for (int s = 0; s < b->n; s++) {
        const lf_block_pixel *pixel = &b->pixels[s];
        double ends[LF_MAX_BLOCK], depths[LF_MAX_BLOCK];
        for (int i = 0; i < n; i++)
            ends[i] = (double)lf_light_path_first(pixel->ray, &b->pixels[order[i]].sample->path);
        lf_coarse_grid_depths(b->space->coarse, pixel->ray->o, pixel->ray->w, n, ends, depths);
        for (int i = 0; i < n; i++)
            b->depth[s][order[i]] = depths[i];
    }
}

/* The path after its second vertex, as the path of a ray that begins there. */
static lf_path_value behind_second(const block *b, const lf_light_path *path, const joint *at)
{
    const lf_camera_ray ray = {.o = at->p, .w = at->leaving.w};
    lf_light_path rest = *path;
    if (path->n == 2)
        return (lf_path_value){
            {1.0f, 1.0f, 1.0f},
            lf_coarse_grid_depth(b->space->coarse, ray.o, ray.w, at->leaving.distance)};
    rest.n = path->n - 2;
    memmove(rest.vertex, rest.vertex + 2, (size_t)rest.n * sizeof *rest.vertex);
    return lf_light_path_value(b->space, &ray, &rest, b->tracer);
}

static void find_joint(const block *b, int i, joint *out)
{
    const lf_block_pixel *pixel = &b->pixels[i];
    const lf_light_path *path = &pixel->sample->path;
    const lf_vec3 first =
        lf_madd(pixel->ray->o, lf_light_path_first(pixel->ray, path), pixel->ray->w);
    out->path = path;
    out->second = path->n > 1;
    out->p = first;
    out->mixture.n = 0;
    out->mixture.total = 0.0f;
    if (out->second) {
        out->p = lf_madd(first, path->vertex[1].z, path->vertex[0].w);
        lf_mixture_at(b->tracer, out->p, &out->mixture);
    }
    out->leaving = lf_light_path_leaving(b->space, path, out->second, out->p);
    out->beyond =
        out->second ? behind_second(b, path, out) : (lf_path_value){{1.0f, 1.0f, 1.0f}, 0.0};
}

static void join_light(const block *b, const joint *to, const lf_mixture *m, lf_vec3 p, lf_vec3 w,
                       reach *out)
{
    const bool moves = isfinite(to->leaving.distance);
    const lf_leaving leaving =
        moves ? lf_light_path_leaving(b->space, to->path, 0, p) : to->leaving;
    out->value.f = lf_mixture_leave(m, w, &leaving);
    out->gap = (lf_coarse_ray){p, leaving.w, leaving.distance, (double)INFINITY};
    out->squared = 1.0;
}

static void join_second(const joint *to, const lf_mixture *m, lf_vec3 p, lf_vec3 w, reach *out)
{
    const lf_vec3 way = lf_sub(to->p, p);
    const float length = lf_length(way);
    if (!(length > 0.0f)) {
        out->value.f = lf_v3(0.0f, 0.0f, 0.0f);
        return;
    }
    const lf_leaving on = lf_leave_on(lf_scale(way, 1.0f / length));
    out->value.f = lf_mul(lf_mixture_leave(m, w, &on),
                          lf_mul(lf_mixture_leave(&to->mixture, on.w, &to->leaving), to->beyond.f));
    out->gap = (lf_coarse_ray){p, on.w, (double)length, (double)INFINITY};
    out->squared = (double)length * (double)length;
}

/* All but the depth of the gap. */
static void find_reach(const block *b, int s, int i, const joint *to, reach *out)
{
    const lf_camera_ray *ray = b->pixels[s].ray;
    const float z = lf_light_path_first(ray, to->path);
    const lf_vec3 p = lf_madd(ray->o, z, ray->w);
    lf_mixture m = {.n = 0};
    out->found = false;
    if (z > 0.0f)
        lf_mixture_at(b->tracer, p, &m);
    if (m.n == 0)
        return;
    if (to->second)
        join_second(to, &m, p, ray->w, out);
    else
        join_light(b, to, &m, p, ray->w, out);
    out->value.depth = b->depth[s][i] + to->beyond.depth;
    out->found = lf_max3(out->value.f) > 0.0f;
}

/* Path i along a ray that reaches it so. */
static void adopt(const joint *to, const reach *by, lf_light_path *out)
{
    *out = *to->path;
    if (to->second) {
        out->vertex[0].w = by->gap.w;
        out->vertex[1].z = (float)by->gap.end;
    }
}

/* Path i along its own ray, as it was found: short joints are not rounded there. */
static void reach_own(const block *b, int i, reach *out)
{
    const lf_path_sample *sample = b->pixels[i].sample;
    const lf_path_vertex *vertex = sample->path.vertex;
    const double length = sample->path.n > 1 ? (double)vertex[1].z : 1.0;
    *out = (reach){.found = true,
                   .value = sample->value,
                   .gap = {.w = vertex[0].w, .end = length},
                   .squared = length * length};
}

/* All but path i's own, which has its depth. */
static void close_gaps(const block *b, int i, reach *reaches)
{
    lf_coarse_ray rays[LF_MAX_BLOCK];
    lf_coarse_end ends[LF_MAX_BLOCK];
    int of[LF_MAX_BLOCK], n = 0;
    for (int s = 0; s < b->n; s++)
        if (s != i && reaches[s].found) {
            rays[n] = reaches[s].gap;
            of[n++] = s;
        }
    lf_coarse_grid_trace(b->space->coarse, lf_depth_kernel_get(), n, rays, ends);
    for (int k = 0; k < n; k++)
        reaches[of[k]].value.depth += ends[k].depth;
}

/* Offers path i to all. */
static void spread(block *b, int i)
{
    const lf_path_sample *sample = b->pixels[i].sample;
    reach reaches[LF_MAX_BLOCK];
    double m[LF_MAX_BLOCK] = {0.0}, q[LF_MAX_BLOCK] = {0.0};
    joint to;
    find_joint(b, i, &to);
    for (int s = 0; s < b->n; s++)
        if (s != i)
            find_reach(b, s, i, &to, &reaches[s]);
    reach_own(b, i, &reaches[i]);
    close_gaps(b, i, reaches);
    for (int s = 0; s < b->n; s++) {
        m[s] = b->pixels[s].sample->m;
        q[s] = reaches[s].found ? lf_path_target(&reaches[s].value) / reaches[s].squared : 0.0;
    }
    const double share = lf_reservoir_share(b->n, m, q, i) * sample->m * sample->weight;
    for (int s = 0; s < b->n; s++) {
        const reach *by = &reaches[s];
        if (!by->found)
            continue;
        const double weight = lf_path_target(&by->value) * share * reaches[i].squared / by->squared;
        if (lf_path_keeper_offer(&b->keepers[s], &by->value, weight, (double)lf_rng(b->tracer)))
            adopt(&to, by, &b->pixels[s].out->path);
    }
}

void lf_path_block_combine(const lf_path_space *space, int n, const lf_block_pixel *pixels,
                           lf_tracer *tracer)
{
    block b = {.space = space, .tracer = tracer, .n = n, .pixels = pixels};
    double all = 0.0;
    if (n == 1) { /* it has all its colours */
        *pixels[0].out = *pixels[0].sample;
        return;
    }
    for (int i = 0; i < n; i++)
        all += pixels[i].sample->m;
    for (int i = 0; i < n; i++)
        lf_path_keeper_begin(&b.keepers[i], all, pixels[i].out);
    find_depths(&b);
    for (int i = 0; i < n; i++)
        if (pixels[i].sample->kept)
            spread(&b, i);
    for (int i = 0; i < n; i++)
        lf_path_keeper_end(&b.keepers[i]);
}
