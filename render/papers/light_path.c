#include "render/papers/light_path.h"

#include <string.h>

lf_leaving lf_light_path_leaving(const lf_path_space *space, const lf_light_path *path, int i,
                                 lf_vec3 p)
{
    if (i < path->n - 1)
        return lf_leave_on(path->vertex[i].w);
    return path->escape ? lf_leave_to_sky(space->scene, path->vertex[i].w)
                        : lf_leave_to_light(space->scene, p, path->u);
}

lf_path_value lf_light_path_value(const lf_path_space *space, const lf_camera_ray *ray,
                                  const lf_light_path *path, lf_tracer *tracer)
{
    const lf_path_value nothing = {.depth = 0.0};
    lf_path_value out = {{1.0f, 1.0f, 1.0f}, 0.0};
    lf_leaving leaving = {.w = ray->w};
    lf_vec3 p = ray->o;
    lf_mixture m;
    for (int i = 0; i < path->n; i++) {
        const float z = i == 0 ? lf_light_path_first(ray, path) : path->vertex[i].z;
        const lf_vec3 w = leaving.w, next = lf_madd(p, z, w);
        if (!(z > 0.0f))
            return nothing;
        lf_mixture_at(tracer, next, &m);
        if (m.n == 0)
            return nothing;
        out.depth += lf_coarse_grid_depth(space->coarse, p, w, (double)z);
        p = next;
        leaving = lf_light_path_leaving(space, path, i, p);
        out.f = lf_mul(out.f, lf_mixture_leave(&m, w, &leaving));
    }
    if (!(lf_max3(out.f) > 0.0f))
        return nothing;
    out.depth += lf_coarse_grid_depth(space->coarse, p, leaving.w, leaving.distance);
    return out;
}

void lf_light_path_segments(const lf_path_space *space, const lf_camera_ray *ray,
                            const lf_light_path *path, lf_depth_ray *out)
{
    lf_vec3 p = ray->o, w = ray->w;
    for (int i = 0; i < path->n; i++) {
        const float z = i == 0 ? lf_light_path_first(ray, path) : path->vertex[i].z;
        out[i] = (lf_depth_ray){p, w, (double)z};
        p = lf_madd(p, z, w);
        w = path->vertex[i].w;
    }
    const lf_leaving last = lf_light_path_leaving(space, path, path->n - 1, p);
    out[path->n] = (lf_depth_ray){p, last.w, last.distance};
}

/* --------------------------------------------------------------------------------- the walks -- */

/* One step of a group of walks. */
typedef struct wave {
    const lf_path_space *space;
    const lf_depth_kernel *kernel;
    lf_tracer *tracer;
    int n, n_shadows;
    lf_light_walk *walks[LF_MAX_WALKS]; /* that continue */
    double goals[LF_MAX_WALKS];
    lf_coarse_end ends[LF_MAX_WALKS];
    lf_coarse_ray shadows[LF_MAX_WALKS];
    lf_path_candidate *lit[LF_MAX_WALKS]; /* the owners of the shadow rays */
} wave;

/* Adds a candidate with value f, without the light after the walk's last vertex. */
static lf_path_candidate *found(lf_light_walk *walk, lf_vec3 f)
{
    lf_path_candidate *out = &walk->candidates[walk->n_candidates++];
    *out = (lf_path_candidate){.n = walk->path.n, .value = {f, walk->depth}};
    out->weight = (double)lf_mean3(f) * walk->inverse;
    return out;
}

static void find_light(wave *at, lf_light_walk *walk, const lf_mixture *m)
{
    float u[3];
    for (int i = 0; i < 3; i++)
        u[i] = lf_rng(at->tracer);
    const lf_leaving light = lf_leave_to_light(at->space->scene, walk->p, u);
    const lf_vec3 f = lf_mul(walk->f, lf_mixture_leave(m, walk->w, &light));
    if (!(lf_max3(f) > 0.0f))
        return;
    lf_path_candidate *candidate = found(walk, f);
    memcpy(candidate->u, u, sizeof u);
    at->lit[at->n_shadows] = candidate;
    at->shadows[at->n_shadows++] =
        (lf_coarse_ray){walk->p, light.w, light.distance, (double)INFINITY};
}

static void escape(const wave *at, lf_light_walk *walk, double depth)
{
    const lf_leaving sky = lf_leave_to_sky(at->space->scene, walk->w);
    /* the phase function and its pdf are in f and in the walk's density */
    const lf_vec3 f =
        lf_scale(lf_mul(walk->f, sky.brings), walk->pdf / (walk->pdf + sky.light_pdf));
    if (!(lf_max3(f) > 0.0f))
        return;
    lf_path_candidate *candidate = found(walk, f);
    candidate->escape = 1;
    candidate->value.depth += depth; /* which its weight has both in p-hat and in p */
}

static void turn(lf_light_walk *walk, const lf_mixture *m, lf_tracer *tracer)
{
    lf_vec3 on = lf_mixture_draw(m, walk->w, tracer);
    walk->f = lf_mul(walk->f, lf_mixture_scatter(m, walk->w, on, &walk->pdf));
    walk->inverse /= (double)walk->pdf;
    walk->w = on;
    walk->path.vertex[walk->path.n - 1].w = on;
}

/* false: it ends. */
static bool scatter(wave *at, lf_light_walk *walk, const lf_coarse_end *end)
{
    const float z = (float)end->point.t;
    lf_mixture m;
    if (!(end->point.sigma > 0.0f)) {
        if (walk->path.n > 0) /* else: rounding, at the end of the media */
            escape(at, walk, end->depth);
        return false;
    }
    walk->p = lf_madd(walk->p, z, walk->w);
    if (walk->path.n == at->space->max_depth)
        return false;
    lf_mixture_at(at->tracer, walk->p, &m);
    if (m.n == 0)
        return false;
    walk->path.vertex[walk->path.n].z = z - (walk->path.n == 0 ? walk->ray->from : 0.0f);
    walk->path.n++;
    walk->depth += end->depth;
    walk->inverse /= (double)end->point.sigma;
    find_light(at, walk, &m);
    turn(walk, &m, at->tracer);
    return lf_max3(walk->f) > 0.0f;
}

static void begin(wave *at, lf_light_walk *walk)
{
    const double scatters = -expm1(-walk->ray->depth);
    walk->path.n = walk->n_candidates = 0;
    walk->p = walk->ray->o;
    walk->w = walk->ray->w;
    walk->f = lf_v3(1.0f, 1.0f, 1.0f);
    walk->inverse = scatters;
    walk->depth = 0.0;
    at->goals[at->n] = -log1p(-walk->u * scatters);
    at->walks[at->n++] = walk;
}

static void find_collisions(wave *at)
{
    lf_coarse_ray rays[LF_MAX_WALKS];
    for (int i = 0; i < at->n; i++)
        rays[i] = (lf_coarse_ray){at->walks[i]->p, at->walks[i]->w, (double)INFINITY, at->goals[i]};
    lf_coarse_grid_trace(at->space->coarse, at->kernel, at->n, rays, at->ends);
}

static void find_shadows(const wave *at)
{
    lf_coarse_end ends[LF_MAX_WALKS];
    lf_coarse_grid_trace(at->space->coarse, at->kernel, at->n_shadows, at->shadows, ends);
    for (int i = 0; i < at->n_shadows; i++) {
        at->lit[i]->value.depth += ends[i].depth;
        at->lit[i]->weight *= exp(-ends[i].depth);
    }
}

void lf_light_path_walk(const lf_path_space *space, int n, lf_light_walk *walks, lf_tracer *tracer)
{
    wave at = {.space = space, .kernel = lf_depth_kernel_get(), .tracer = tracer};
    for (int i = 0; i < n; i++)
        begin(&at, &walks[i]);
    while (at.n > 0) {
        int left = 0;
        find_collisions(&at);
        at.n_shadows = 0;
        for (int i = 0; i < at.n; i++) {
            lf_light_walk *walk = at.walks[i];
            tracer->rng = walk->random;
            if (scatter(&at, walk, &at.ends[i])) {
                at.goals[left] = (double)lf_rng_exponential(tracer);
                at.walks[left++] = walk;
            }
            walk->random = tracer->rng;
        }
        find_shadows(&at);
        at.n = left;
    }
}

void lf_light_walk_path(const lf_light_walk *walk, const lf_path_candidate *candidate,
                        lf_light_path *out)
{
    *out = walk->path;
    out->n = candidate->n;
    out->escape = candidate->escape;
    memcpy(out->u, candidate->u, sizeof out->u);
}
