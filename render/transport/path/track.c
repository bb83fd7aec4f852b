#include "render/transport/path/track.h"
#include "render/transport/surface/surface_texture.h"

#include <string.h>

#include "render/scene/geometry.h"
#include "render/scene/look_up.h"
#include "render/scene/ray.h"
#include "render/transport/light/volume_emission.h"
#include "render/transport/path/coloured.h"
#include "render/transport/surface/instance_hit.h"

/* ---------------------------------------------------------------------------------- surfaces -- */

static lf_vec3 shading_normal(const lf_mesh *mesh, const uint32_t *tri, float u, float v,
                              lf_vec3 ng)
{
    if (!mesh->normals)
        return ng;
    lf_vec3 n[3];
    for (int i = 0; i < 3; i++) {
        const float *p = mesh->normals + 3 * (size_t)tri[i];
        n[i] = lf_v3(p[0], p[1], p[2]);
    }
    lf_vec3 ns = lf_madd(lf_madd(lf_scale(n[0], 1.0f - u - v), u, n[1]), v, n[2]);
    float length = lf_length(ns);
    if (!(length > 1e-6f))
        return ng;
    ns = lf_scale(ns, 1.0f / length);
    return lf_dot(ns, ng) < 0.0f ? lf_scale(ns, -1.0f) : ns;
}

/* Everything of a hit except its position. */
static void describe(const lf_scene *scene, unsigned mesh_number, unsigned triangle, float u,
                     float v, lf_vec3 w, lf_hit *hit)
{
    const lf_mesh *mesh = &scene->meshes[mesh_number];
    const uint32_t *tri = mesh->triangles + 3 * (size_t)triangle;
    lf_vec3 a = lf_mesh_vertex(mesh, tri[0]), ab = lf_sub(lf_mesh_vertex(mesh, tri[1]), a),
            ac = lf_sub(lf_mesh_vertex(mesh, tri[2]), a);
    lf_vec3 n = lf_cross(ab, ac);
    float length = lf_length(n);
    hit->ng = length > 0.0f ? lf_scale(n, 1.0f / length) : lf_scale(w, -1.0f / lf_length(w));
    hit->front = !(lf_dot(hit->ng, w) > 0.0f);
    if (!hit->front)
        hit->ng = lf_scale(hit->ng, -1.0f);
    hit->ns = shading_normal(mesh, tri, u, v, hit->ng);
    hit->mesh = mesh;
    hit->triangle = triangle;
    hit->u = u;
    hit->v = v;
    hit->varies = false;
    hit->material = &scene->materials[lf_mesh_material(mesh, triangle)];
}

/* Barycentric coordinates have an error of 1e-7 of a triangle's size; for large ones this is too
 * much, and the ray gives the point. */
static lf_vec3 point_of(const lf_large_triangle *large, lf_vec3 o, lf_vec3 w)
{
    const double from[3] = {(double)o.x, (double)o.y, (double)o.z},
                 along[3] = {(double)w.x, (double)w.y, (double)w.z};
    double t = 0.0, uv[2];
    lf_large_meet(large, from, along, &t, uv);
    return lf_v3((float)(from[0] + t * along[0]), (float)(from[1] + t * along[1]),
                 (float)(from[2] + t * along[2]));
}

/* Fills *hit from what Embree reported. */
static void find_hit(const lf_scene *scene, const struct RTCRayHit *rh, lf_vec3 o, lf_vec3 w,
                     lf_hit *hit)
{
    hit->t = rh->ray.tfar;
    if (rh->hit.geomID < (unsigned)scene->n_meshes) {
        const lf_mesh *mesh = &scene->meshes[rh->hit.geomID];
        if (lf_has(scene, LF_TRAIT_INSTANCES) && mesh->instances) {
            lf_instance_hit(scene, mesh, rh->hit.primID, rh->hit.instID[0], rh->hit.u, rh->hit.v, w,
                            hit);
            return;
        }
        describe(scene, rh->hit.geomID, rh->hit.primID, rh->hit.u, rh->hit.v, w, hit);
        hit->p = lf_mesh_point(hit->mesh, hit->triangle, rh->hit.u, rh->hit.v);
        return;
    }
    const lf_large_triangle *large = &scene->geometry->large.triangles[rh->hit.primID];
    describe(scene, large->mesh, large->triangle, rh->hit.u, rh->hit.v, w, hit);
    hit->p = point_of(large, o, w);
}

static float averaged_at(const lf_tracer *tracer, float t)
{
    return tracer->width + tracer->spread * t;
}

/* Decides at random whether the ray meets an alpha surface; otherwise it continues. */
static bool is_there(lf_tracer *tracer, const lf_hit *hit, lf_vec3 w, struct RTCRay *ray,
                     float t_max)
{
    if (!lf_is_alpha_surface(hit->material))
        return true;
    float cover = lf_hit_stops(hit, w, averaged_at(tracer, hit->t));
    if (cover >= 1.0f || lf_rng(tracer) < cover)
        return true;
    ray->tnear = lf_behind(hit->t);
    ray->tfar = t_max;
    return false;
}

/* Rough solid glass refracts differently from inside; subsurface is left there. */
static void tell_side(lf_hit *hit)
{
    if (hit->front || !lf_is_sided(hit->material))
        return;
    if (!hit->varies) {
        hit->own = *hit->material;
        hit->width = 0.0f;
        hit->varies = true;
    }
    hit->own.glass.is_inside = true;
}

static struct RTCRay ray_of(const lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max)
{
    return (struct RTCRay){.org_x = o.x,
                           .org_y = o.y,
                           .org_z = o.z,
                           .tnear = t_min,
                           .time = tracer->time,
                           .dir_x = w.x,
                           .dir_y = w.y,
                           .dir_z = w.z,
                           .tfar = t_max,
                           .mask = ~0u};
}

/* Whether a ray meets a surface, and its hit. */
static bool meets(lf_tracer *tracer, struct RTCRayHit *rh)
{
    tracer->rays++;
    rh->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    if (lf_ray_is_sound(&rh->ray))
        lf_embree_intersect(tracer->scene->embree, rh);
    return rh->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

/* t_min < t < t_max */
static bool trace(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit)
{
    const lf_scene *scene = tracer->scene;
    if (!scene->embree)
        return false;
    struct RTCRayHit rh = {.ray = ray_of(tracer, o, w, t_min, t_max)};
    do {
        if (!meets(tracer, &rh))
            return false;
        find_hit(scene, &rh, o, w, hit);
    } while (lf_has(scene, LF_TRAITS_SEEN_THROUGH) && !is_there(tracer, hit, w, &rh.ray, t_max));
    if (lf_has(scene, LF_TRAIT_VARYING) && lf_is_varied(hit->mesh, hit->material))
        lf_hit_vary(hit, averaged_at(tracer, hit->t));
    if (lf_has(scene, LF_TRAITS_SIDED))
        tell_side(hit);
    return true;
}

bool lf_trace_next(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit)
{
    struct RTCRayHit rh = {.ray = ray_of(tracer, o, w, t_min, nextafterf(t_max, INFINITY))};
    if (!meets(tracer, &rh))
        return false;
    find_hit(tracer->scene, &rh, o, w, hit);
    return true;
}

bool lf_trace_thin(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit)
{
    while (lf_trace_next(tracer, o, w, t_min, t_max, hit)) {
        if (hit->material->glass.is_thin && !hit->mesh->hidden)
            return true;
        t_min = lf_behind(hit->t);
    }
    return false;
}

static float passed_by(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, bool seen)
{
    const float last = nextafterf(t_max, -INFINITY);
    const struct RTCRay whole = ray_of(tracer, o, w, 0.0f, last);
    float passed = lf_ray_is_sound(&whole) ? 1.0f : 0.0f, t = 0.0f;
    lf_hit hit;
    while (passed > 0.0f && lf_trace_next(tracer, o, w, t, last, &hit)) {
        if (!(seen && hit.mesh->hidden))
            passed *= 1.0f - lf_hit_stops(&hit, w, averaged_at(tracer, hit.t));
        t = lf_behind(hit.t);
    }
    return passed;
}

bool lf_trace_surface(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_hit *hit)
{
    return trace(tracer, o, w, 0.0f, t_max, hit);
}

bool lf_trace_beyond(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_min, float t_max, lf_hit *hit)
{
    return trace(tracer, o, w, t_min, t_max, hit);
}

bool lf_trace_seen(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_hit *hit)
{
    bool found = trace(tracer, o, w, 0.0f, t_max, hit);
    while (found && hit->mesh->hidden)
        found = trace(tracer, o, w, lf_behind(hit->t), t_max, hit);
    return found;
}

float lf_trace_passed(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max)
{
    if (lf_has(tracer->scene, LF_TRAITS_SEEN_THROUGH))
        return passed_by(tracer, o, w, t_max, false);
    return lf_trace_occluded(tracer, o, w, t_max) ? 0.0f : 1.0f;
}

float lf_trace_passed_seen(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max)
{
    if (lf_has(tracer->scene, LF_TRAITS_SEEN_THROUGH) ||
        lf_has(tracer->scene, LF_TRAIT_HIDDEN_MESHES))
        return passed_by(tracer, o, w, t_max, true);
    return lf_trace_occluded(tracer, o, w, t_max) ? 0.0f : 1.0f;
}

bool lf_trace_occluded(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max)
{
    if (!tracer->scene->embree)
        return false;
    struct RTCRay ray = ray_of(tracer, o, w, 0.0f, t_max);
    tracer->rays++;
    if (!lf_ray_is_sound(&ray))
        return true;
    lf_embree_occluded(tracer->scene->embree, &ray);
    return ray.tfar < 0.0f;
}

lf_vec3 lf_offset(const lf_scene *scene, lf_vec3 p, lf_vec3 n, lf_vec3 w, float length)
{
    /* Twice half a unit in the last place of every coordinate, plus a quarter. */
    float eps =
        scene->offset + 1.5e-7f * (fabsf(n.x * p.x) + fabsf(n.y * p.y) + fabsf(n.z * p.z) + length);
    return lf_madd(p, lf_dot(n, w) >= 0.0f ? eps : -eps, n);
}

/* ----------------------------------------------------------------------------------- volumes -- */

/* A ray in a volume's own space, clipped to its box; t keeps its meaning. */
typedef struct lf_local_ray {
    /* inverse = 1 / d; not finite along axes that the ray does not move on */
    float o[3], d[3], inverse[3];
    float t0, t1;
} lf_local_ray;

static bool clip_axis(lf_local_ray *r, int axis, float min, float max)
{
    if (r->d[axis] == 0.0f)
        return r->o[axis] > min && r->o[axis] < max;
    float a = (min - r->o[axis]) * r->inverse[axis], b = (max - r->o[axis]) * r->inverse[axis];
    r->t0 = lf_max(r->t0, lf_min(a, b));
    r->t1 = lf_min(r->t1, lf_max(a, b));
    return r->t1 > r->t0;
}

static void to_local(const lf_volume *volume, lf_vec3 o, lf_vec3 w, float t_max, lf_local_ray *r)
{
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        r->o[i] = m[0] * o.x + m[1] * o.y + m[2] * o.z + m[3];
        r->d[i] = m[0] * w.x + m[1] * w.y + m[2] * w.z;
        r->inverse[i] = 1.0f / r->d[i];
    }
    r->t0 = 0.0f;
    r->t1 = t_max;
}

/* Clips the ray to the shape, or to the grid's box in voxels: interpolation reaches one voxel
 * beyond the centres of the outermost ones. false: the ray misses it. */
static bool clip_volume(const lf_volume *volume, lf_local_ray *r)
{
    if (volume->kind != LF_VOLUME_GRID) {
        float from, to;
        lf_shape_interval(volume->kind, r->o, r->d, &from, &to);
        r->t0 = lf_max(r->t0, from);
        r->t1 = lf_min(r->t1, to);
        return r->t1 > r->t0;
    }
    for (int i = 0; i < 3; i++)
        if (!clip_axis(r, i, -1.0f, (float)volume->grid->size[i]))
            return false;
    return true;
}

/* How a grid is looked up. */
typedef enum filter { LINEAR, LINEAR_SHORT, NEAREST } filter;

/* Steps from brick to brick along a ray. */
typedef struct lf_walk {
    const lf_grid *grid;
    filter by;
    int b[3], step[3];
    size_t brick, stride[3]; /* of the current brick, per step (modulo 2^64) */
    float next[3], delta[3];
    float t0, t1; /* the present brick's part of the ray */
    float end;
    float corner[3]; /* the ray's start as seen from the present brick's corner */
    size_t first;    /* of the present brick's values */
    float max;       /* its largest value */
    int left;        /* tentative collisions that may still come at this t */
} lf_walk;

static void enter(lf_walk *k)
{
    const lf_grid *g = k->grid;
    k->first = (size_t)g->index[k->brick] * LF_BRICK_STRIDE;
    k->max = g->brick_max[k->brick];
    k->t1 = lf_max(k->t0, lf_min(k->end, lf_min(k->next[0], lf_min(k->next[1], k->next[2]))));
}

static void walk_begin(lf_walk *k, const lf_volume *volume, const lf_local_ray *r)
{
    const lf_grid *grid = k->grid = volume->grid;
    k->by = volume->nearest ? NEAREST : grid->values ? LINEAR : LINEAR_SHORT;
    k->t0 = r->t0;
    k->end = r->t1;
    k->brick = 0;
    k->left = LF_MOST_STILL;
    size_t stride = 1;
    for (int i = 0; i < 3; i++) {
        /* below 0 only by rounding */
        int b = (int)((r->o[i] + r->t0 * r->d[i] + 1.0f) * (1.0f / LF_BRICK));
        b = b < 0 ? 0 : b < grid->bricks[i] ? b : grid->bricks[i] - 1;
        bool up = r->d[i] > 0.0f;
        float face = (float)((b + up) * LF_BRICK - 1);
        k->b[i] = b;
        k->step[i] = up ? 1 : -1;
        k->stride[i] = up ? stride : -stride;
        k->next[i] = r->d[i] != 0.0f ? (face - r->o[i]) * r->inverse[i] : INFINITY;
        k->delta[i] = LF_BRICK * fabsf(r->inverse[i]);
        k->corner[i] = r->o[i] + 1.0f - (float)(b * LF_BRICK);
        k->brick += (size_t)b * stride;
        stride *= (size_t)grid->bricks[i];
    }
    enter(k);
}

static bool walk_next(lf_walk *k)
{
    if (k->t1 >= k->end)
        return false;
    int axis = k->next[0] <= k->next[1] ? (k->next[0] <= k->next[2] ? 0 : 2)
                                        : (k->next[1] <= k->next[2] ? 1 : 2);
    k->b[axis] += k->step[axis];
    if (k->b[axis] < 0 || k->b[axis] >= k->grid->bricks[axis])
        return false;
    k->t0 = k->t1;
    k->next[axis] += k->delta[axis];
    k->brick += k->stride[axis];
    k->corner[axis] -= (float)(k->step[axis] * LF_BRICK);
    enter(k);
    return true;
}

/* Clamped coordinate inside the present brick, 0..8. */
static inline float inside(const lf_walk *k, const lf_local_ray *r, float t, int axis)
{
    float x = k->corner[axis] + t * r->d[axis];
    return lf_min(lf_max(x, 0.0f), (float)LF_BRICK);
}

/* The grid's value at t, which lies in the present brick, without sigma_scale. */
static float look_up(const lf_walk *k, const lf_local_ray *r, float t)
{
    const lf_grid *grid = k->grid;
    float x = inside(k, r, t, 0), y = inside(k, r, t, 1), z = inside(k, r, t, 2);
    if (k->by == NEAREST)
        return lf_grid_stored(grid, k->first + (size_t)lf_in_brick((int)(x + 0.5f), (int)(y + 0.5f),
                                                                   (int)(z + 0.5f)));
    int i = (int)lf_min(x, LF_BRICK - 1), j = (int)lf_min(y, LF_BRICK - 1),
        l = (int)lf_min(z, LF_BRICK - 1);
    const float at[3] = {x - (float)i, y - (float)j, z - (float)l};
    size_t cell = k->first + (size_t)lf_in_brick(i, j, l);
    return k->by == LINEAR ? lf_cell_linear(grid->values + cell, at)
                           : lf_cell_linear_short(grid->shorts + cell, grid->short_scale, at);
}

/* Steps to the next tentative collision at the bricks' majorants. depth is the remaining optical
 * distance to it, carried from brick to brick (the exponential has no memory). On success *t is the
 * position, and the walk is in its brick. */
static inline bool tentative(lf_walk *k, float sigma_scale, float *depth, float *t)
{
    for (;;) {
        float majorant = sigma_scale * k->max, room = majorant * (k->t1 - *t);
        if (*depth < room) {
            float from = *t;
            *t += *depth / majorant;
            k->left = *t > from ? LF_MOST_STILL : k->left - 1;
            return true;
        }
        *depth -= room;
        if (!walk_next(k))
            return false;
        *t = k->t0;
    }
}

static float collide_grid(lf_tracer *tracer, const lf_volume *volume, const lf_local_ray *r)
{
    lf_walk k;
    walk_begin(&k, volume, r);
    float t = k.t0, depth = lf_rng_exponential(tracer);
    while (tentative(&k, volume->sigma_scale, &depth, &t)) {
        tracer->lookups++;
        if (lf_rng(tracer) * k.max < look_up(&k, r, t) || k.left == 0)
            return t;
        depth = lf_rng_exponential(tracer);
    }
    return INFINITY;
}

float lf_track_collision(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, int *out_volume)
{
    const lf_scene *scene = tracer->scene;
    float nearest = INFINITY;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        lf_local_ray r;
        to_local(volume, o, w, lf_min(t_max, nearest), &r);
        if (!(volume->sigma_max > 0.0f) || !clip_volume(volume, &r))
            continue;
        float t;
        if (volume->kind == LF_VOLUME_GRID) {
            t = collide_grid(tracer, volume, &r);
        } else {
            t = r.t0 + lf_rng_exponential(tracer) / volume->sigma_scale;
            t = t < r.t1 ? t : INFINITY;
        }
        if (t < nearest) {
            nearest = t;
            *out_volume = i;
        }
    }
    return nearest;
}

/* Densities of channels, up to a common factor. */
typedef struct channels {
    int drawn;      /* the channel that is tracked */
    float share[3]; /* with what probability each is */
    float density[3];
} channels;

static void keep_in_range(channels *c)
{
    float most = lf_max(c->density[0], lf_max(c->density[1], c->density[2]));
    for (int i = 0; i < 3 && most < 1e-20f; i++)
        c->density[i] *= 1e20f;
}

static channels draw_channel(lf_tracer *tracer, lf_vec3 beta)
{
    float sum = beta.x + beta.y + beta.z, u = lf_rng(tracer);
    channels c = {.share = {beta.x / sum, beta.y / sum, beta.z / sum}, .density = {1, 1, 1}};
    for (int i = 0; i < 3 && u >= 0.0f; i++) {
        c.drawn = c.share[i] > 0.0f ? i : c.drawn;
        u -= c.share[i];
    }
    return c;
}

static float collide_grid_channels(lf_tracer *tracer, const lf_volume *volume,
                                   const lf_local_ray *r, const float colour[3], channels *c)
{
    lf_walk k;
    walk_begin(&k, volume, r);
    float t = k.t0, depth = lf_rng_exponential(tracer);
    while (tentative(&k, volume->sigma_scale, &depth, &t)) {
        tracer->lookups++;
        float share = look_up(&k, r, t) / k.max;
        bool collides = lf_rng(tracer) < colour[c->drawn] * share;
        for (int i = 0; i < 3; i++)
            c->density[i] *= collides ? colour[i] * share : lf_max(1.0f - colour[i] * share, 0.0f);
        keep_in_range(c);
        if (collides || k.left == 0)
            return t;
        depth = lf_rng_exponential(tracer);
    }
    return INFINITY;
}

/* sigma: of the largest channel. */
static float collide_shape_channels(lf_tracer *tracer, float sigma, const lf_local_ray *r,
                                    const float colour[3], channels *c)
{
    float length = r->t1 - r->t0, least = lf_min(colour[0], lf_min(colour[1], colour[2]));
    float way = lf_rng_exponential(tracer) / (colour[c->drawn] * sigma);
    bool collides = way < length;
    for (int i = 0; i < 3; i++) {
        float beyond = (colour[i] - least) * sigma;
        c->density[i] *= (collides ? colour[i] : 1.0f) * expf(-beyond * (collides ? way : length));
    }
    keep_in_range(c);
    return collides ? r->t0 + way : INFINITY;
}

float lf_track_channels(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max, lf_vec3 beta,
                        int *out_volume, lf_vec3 *out_channels)
{
    const lf_scene *scene = tracer->scene;
    float nearest = INFINITY, mean = 0.0f;
    int whose = 0;
    channels c = draw_channel(tracer, beta);
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        lf_vec3 of = lf_volume_colour(volume);
        const float colour[3] = {of.x, of.y, of.z};
        lf_local_ray r;
        to_local(volume, o, w, lf_min(t_max, nearest), &r);
        if (!(volume->sigma_max > 0.0f) || !clip_volume(volume, &r))
            continue;
        float t = volume->kind == LF_VOLUME_GRID
                      ? collide_grid_channels(tracer, volume, &r, colour, &c)
                      : collide_shape_channels(tracer, volume->sigma_scale, &r, colour, &c);
        whose = t < nearest ? i : whose;
        nearest = lf_min(t, nearest);
    }
    *out_volume = whose;
    for (int i = 0; i < 3; i++)
        mean += c.share[i] * c.density[i];
    float over = mean > 0.0f ? 1.0f / mean : 0.0f;
    *out_channels = lf_scale(lf_v3(c.density[0], c.density[1], c.density[2]), over);
    return nearest;
}

/* Ratio tracking with roulette below 1/10. */
static float transmit_grid(lf_tracer *tracer, const lf_volume *volume, const lf_local_ray *r,
                           float transmittance)
{
    lf_walk k;
    walk_begin(&k, volume, r);
    float t = k.t0, depth = lf_rng_exponential(tracer);
    while (tentative(&k, volume->sigma_scale, &depth, &t)) {
        tracer->lookups++;
        transmittance *= k.left > 0 ? lf_max(0.0f, 1.0f - look_up(&k, r, t) / k.max) : 0.0f;
        if (transmittance < 0.1f) {
            if (lf_rng(tracer) >= 0.5f)
                return 0.0f;
            transmittance *= 2.0f;
        }
        depth = lf_rng_exponential(tracer);
    }
    return transmittance;
}

float lf_track_transmittance(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max)
{
    const lf_scene *scene = tracer->scene;
    float transmittance = 1.0f;
    for (int i = 0; i < scene->n_volumes && transmittance > 0.0f; i++) {
        const lf_volume *volume = &scene->volumes[i];
        lf_local_ray r;
        to_local(volume, o, w, t_max, &r);
        if (!(volume->sigma_max > 0.0f) || !clip_volume(volume, &r))
            continue;
        if (volume->kind == LF_VOLUME_GRID)
            transmittance = transmit_grid(tracer, volume, &r, transmittance);
        else
            transmittance *= expf(-volume->sigma_scale * (r.t1 - r.t0));
    }
    return transmittance;
}

/* transmit_grid with one set of tentative collisions for all channels. */
static lf_vec3 transmit_grid_channels(lf_tracer *tracer, const lf_volume *volume,
                                      const lf_local_ray *r, lf_vec3 colour, lf_vec3 left)
{
    lf_walk k;
    walk_begin(&k, volume, r);
    float t = k.t0, depth = lf_rng_exponential(tracer);
    while (tentative(&k, volume->sigma_scale, &depth, &t)) {
        tracer->lookups++;
        float share = look_up(&k, r, t) / k.max;
        left = lf_mul(left, lf_v3(lf_max(0.0f, 1.0f - colour.x * share),
                                  lf_max(0.0f, 1.0f - colour.y * share),
                                  lf_max(0.0f, 1.0f - colour.z * share)));
        if (k.left == 0 || lf_max3(left) < 0.1f) {
            if (k.left == 0 || lf_rng(tracer) >= 0.5f)
                return lf_v3(0.0f, 0.0f, 0.0f);
            left = lf_scale(left, 2.0f);
        }
        depth = lf_rng_exponential(tracer);
    }
    return left;
}

lf_vec3 lf_track_transmittances(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t_max)
{
    const lf_scene *scene = tracer->scene;
    lf_vec3 left = lf_v3(1.0f, 1.0f, 1.0f);
    for (int i = 0; i < scene->n_volumes && lf_max3(left) > 0.0f; i++) {
        const lf_volume *volume = &scene->volumes[i];
        lf_vec3 colour = lf_volume_colour(volume);
        lf_local_ray r;
        to_local(volume, o, w, t_max, &r);
        if (!(volume->sigma_max > 0.0f) || !clip_volume(volume, &r))
            continue;
        float depth = volume->sigma_scale * (r.t1 - r.t0);
        if (volume->kind == LF_VOLUME_GRID)
            left = transmit_grid_channels(tracer, volume, &r, colour, left);
        else
            left = lf_mul(left, lf_v3(expf(-colour.x * depth), expf(-colour.y * depth),
                                      expf(-colour.z * depth)));
    }
    return left;
}

/* The integral over an emission grid. It chooses one of its bricks, by the brightest value there
 * times the length inside, and a point of that part. */
static lf_vec3 emit_grid(lf_tracer *tracer, const lf_volume *emissive,
                         const lf_volume_emission *light, const lf_local_ray *r,
                         const lf_dimming *dimming)
{
    lf_walk k;
    float sum = 0.0f, reached = 0.0f, power;
    walk_begin(&k, emissive, r);
    do
        sum += lf_emission_power(light, k.max) * (k.t1 - k.t0);
    while (walk_next(&k));
    if (!(sum > 0.0f))
        return lf_v3(0.0f, 0.0f, 0.0f);
    /* The sums are repeated in the same order, so they reach any share of the total, at a brick
     * that adds to them. */
    float wanted = lf_rng_fine(tracer) * sum;
    walk_begin(&k, emissive, r);
    do {
        power = lf_emission_power(light, k.max);
        reached += power * (k.t1 - k.t0);
    } while (reached < wanted && walk_next(&k));
    float t = lf_max(k.t1 - (reached - wanted) / power, k.t0);
    tracer->lookups++;
    lf_vec3 radiance = lf_scale(lf_emission_radiance(light, look_up(&k, r, t)), sum / power);
    return dimming ? lf_mul(radiance, lf_dimming_at(dimming, t)) : radiance;
}

/* An emissive shape between t0 and t1. */
static lf_vec3 emit_shape(lf_tracer *tracer, const lf_volume_emission *light, float t0, float t1,
                          const lf_dimming *dimming)
{
    return dimming ? lf_mul(light->colour, lf_dimming_between(dimming, tracer, t0, t1))
                   : lf_scale(light->colour, t1 - t0);
}

lf_vec3 lf_track_emission(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t,
                          const lf_dimming *dimming)
{
    const lf_scene *scene = tracer->scene;
    lf_vec3 radiance = lf_v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < scene->emissive.n; i++) {
        const lf_volume *emissive = &scene->emissive.field[i];
        const lf_volume_emission *light = &scene->emissive.light[i];
        lf_local_ray r;
        to_local(emissive, o, w, t, &r);
        if (!(emissive->sigma_max > 0.0f) || !clip_volume(emissive, &r))
            continue;
        radiance = lf_add(radiance, emissive->kind == LF_VOLUME_GRID
                                        ? emit_grid(tracer, emissive, light, &r, dimming)
                                        : emit_shape(tracer, light, r.t0, r.t1, dimming));
    }
    return radiance;
}
