#include "render/general/light_path.h"

#include "render/general/depth.h"
#include "render/transport/phase.h"

/* The media at a point. */
typedef struct mixture {
    const lf_volume *volume[LF_MAX_VOLUMES];
    float sigma[LF_MAX_VOLUMES], total;
    lf_vec3 albedo[LF_MAX_VOLUMES];
    int n;
} mixture;

static void mix(const lf_path_space *space, lf_vec3 p, lf_tracer *tracer, mixture *out)
{
    const lf_scene *scene = space->scene;
    out->n = 0;
    out->total = 0.0f;
    tracer->lookups += scene->n_volumes;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        float sigma = lf_volume_sigma_t(volume, p);
        if (!(sigma > 0.0f))
            continue;
        out->volume[out->n] = volume;
        out->sigma[out->n] = sigma;
        out->albedo[out->n++] = lf_volume_albedo(volume, p);
        out->total += sigma;
    }
}

/* sigma_s times phase function, and the density with which draw_direction draws `on`. */
static lf_vec3 scatter(const mixture *m, lf_vec3 w, lf_vec3 on, float *out_pdf)
{
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    float pdf = 0.0f;
    for (int i = 0; i < m->n; i++) {
        float lobe = m->sigma[i] * lf_volume_phase(m->volume[i], w, on);
        sum = lf_madd(sum, lobe, m->albedo[i]);
        pdf += lobe;
    }
    *out_pdf = pdf / m->total;
    return sum;
}

static lf_vec3 draw_direction(const mixture *m, lf_vec3 w, lf_tracer *tracer)
{
    float left = lf_rng(tracer) * m->total;
    int i = 0;
    for (; i < m->n - 1 && left >= m->sigma[i]; i++)
        left -= m->sigma[i];
    const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
    return lf_volume_phase_sample(m->volume[i], w, u);
}

/* What a light sample brings there, over its density and the walk's; nothing stands between. */
static lf_vec3 lit(const lf_path_space *space, const mixture *m, lf_vec3 p, lf_vec3 w,
                   const float u[3], lf_light_sample *out)
{
    float pdf;
    if (!lf_light_draw(space->scene, p, u, out))
        return lf_v3(0.0f, 0.0f, 0.0f);
    lf_vec3 f = scatter(m, w, out->wi, &pdf);
    return lf_scale(lf_mul(f, out->radiance), 1.0f / (out->pdf + (out->delta ? 0.0f : pdf)));
}

/* What a direction finds at infinity that light samples leave to it. */
static lf_vec3 escaped(const lf_path_space *space, lf_vec3 w, float pdf)
{
    float light_pdf;
    lf_vec3 radiance = lf_light_escape(space->scene, w, &light_pdf);
    return lf_scale(radiance, pdf / (pdf + light_pdf));
}

/* ------------------------------------------------------------------------------ what it brings --
 */

static double depth_along(const lf_path_space *space, bool exact, lf_vec3 o, lf_vec3 w, double end,
                          lf_tracer *tracer)
{
    return exact ? lf_depth_along(tracer, o, w, end)
                 : lf_coarse_grid_depth(space->coarse, o, w, end);
}

static lf_vec3 bring(const lf_path_space *space, const lf_camera_ray *ray,
                     const lf_light_path *path, bool exact, lf_tracer *tracer)
{
    const lf_vec3 nothing = {0.0f, 0.0f, 0.0f};
    lf_vec3 p = ray->o, w = ray->w, f = {1.0f, 1.0f, 1.0f};
    lf_light_sample light = {.distance = INFINITY};
    mixture m;
    float pdf = 0.0f;
    double depth = 0.0;
    for (int i = 0; i < path->n; i++) {
        float z = path->vertex[i].z + (i == 0 ? ray->from : 0.0f);
        lf_vec3 next = lf_madd(p, z, w);
        if (!(z > 0.0f))
            return nothing;
        mix(space, next, tracer, &m);
        if (m.n == 0)
            return nothing;
        depth += depth_along(space, exact, p, w, (double)z, tracer);
        p = next;
        if (i == path->n - 1 && !path->escape) {
            f = lf_mul(f, lit(space, &m, p, w, path->u, &light));
            w = light.wi;
            continue;
        }
        f = lf_mul(f, scatter(&m, w, path->vertex[i].w, &pdf));
        w = path->vertex[i].w;
    }
    if (path->escape)
        f = lf_mul(f, escaped(space, w, pdf));
    if (!(lf_max3(f) > 0.0f))
        return nothing;
    depth += depth_along(space, exact, p, w, (double)light.distance, tracer);
    return lf_scale(f, expf(-(float)depth));
}

lf_vec3 lf_camera_ray_behind(const lf_camera_ray *ray, lf_tracer *tracer)
{
    double depth =
        lf_max3(ray->sky) > 0.0f ? lf_depth_along(tracer, ray->o, ray->w, (double)INFINITY) : 0.0;
    return lf_scale(ray->sky, expf(-(float)depth));
}

lf_vec3 lf_light_path_radiance(const lf_path_space *space, const lf_camera_ray *ray,
                               const lf_light_path *path, lf_tracer *tracer)
{
    return bring(space, ray, path, true, tracer);
}

double lf_light_path_target(const lf_path_space *space, const lf_camera_ray *ray,
                            const lf_light_path *path, lf_tracer *tracer)
{
    return (double)lf_mean3(bring(space, ray, path, false, tracer));
}

/* --------------------------------------------------------------------------------- candidates --
 */

/* A walk at a vertex, or at the camera. */
typedef struct walk {
    lf_light_path path;
    lf_vec3 p, w, f; /* f: what the path so far brings, without transmittance */
    float pdf;       /* of w, where it scattered */
    double inverse;  /* 1 / its density without transmittance, which p-hat has, too */
    double depth;
} walk;

static void offer(const walk *at, lf_vec3 f, double shadow, lf_candidate_fn found, void *context)
{
    double brought = (double)lf_mean3(f) * exp(-shadow), weight = brought * at->inverse;
    if (weight > 0.0)
        found(context, &at->path, brought * exp(-at->depth), weight);
}

static void offer_light(const lf_path_space *space, walk *at, const mixture *m, lf_tracer *tracer,
                        lf_candidate_fn found, void *context)
{
    lf_light_sample light = {.distance = INFINITY};
    for (int i = 0; i < 3; i++)
        at->path.u[i] = lf_rng(tracer);
    at->path.escape = 0;
    lf_vec3 f = lf_mul(at->f, lit(space, m, at->p, at->w, at->path.u, &light));
    if (lf_max3(f) > 0.0f)
        offer(at, f, lf_coarse_grid_depth(space->coarse, at->p, light.wi, (double)light.distance),
              found, context);
}

static void turn(walk *at, const mixture *m, lf_tracer *tracer)
{
    lf_vec3 on = draw_direction(m, at->w, tracer);
    at->f = lf_mul(at->f, scatter(m, at->w, on, &at->pdf));
    at->inverse /= (double)at->pdf;
    at->w = on;
    at->path.vertex[at->path.n - 1].w = on;
}

void lf_light_path_walk(const lf_path_space *space, const lf_camera_ray *ray, double u,
                        lf_tracer *tracer, lf_candidate_fn found, void *context)
{
    const double scatters = -expm1(-ray->depth);
    double goal = -log1p(-u * scatters), way;
    walk at = {.p = ray->o, .w = ray->w, .f = {1.0f, 1.0f, 1.0f}, .inverse = scatters};
    for (;; goal = (double)lf_rng_exponential(tracer)) {
        lf_coarse_point next;
        mixture m;
        if (!lf_coarse_grid_at_depth(space->coarse, at.p, at.w, goal, &next, &way)) {
            if (at.path.n == 0)
                return; /* rounding, at the end of the media */
            at.depth += way;
            at.path.escape = 1;
            offer(&at, lf_mul(at.f, escaped(space, at.w, at.pdf)), 0.0, found, context);
            return;
        }
        float z = (float)next.t;
        at.p = lf_madd(at.p, z, at.w);
        if (at.path.n == space->max_depth)
            return;
        mix(space, at.p, tracer, &m);
        if (m.n == 0)
            return;
        at.path.vertex[at.path.n].z = z - (at.path.n == 0 ? ray->from : 0.0f);
        at.path.n++;
        at.depth += goal;
        at.inverse /= (double)next.sigma;
        offer_light(space, &at, &m, tracer, found, context);
        turn(&at, &m, tracer);
        if (!(lf_max3(at.f) > 0.0f))
            return;
    }
}
