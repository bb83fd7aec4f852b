#include <math.h>

#include "render/papers/alike.h"
#include "render/papers/restir_state.h"

/* The ray of a view pixel, through its own film point and lens point. */
static void aim(const lf_restir *s, int row, int view, int column, lf_sampler *sampler,
                lf_camera_ray *out)
{
    const lf_rig *rig = &s->rig;
    float film[2], lens[2], chord;
    lf_row_plane plane;
    lf_sampler_2d(sampler, film);
    lf_sampler_2d(sampler, lens);
    lf_rig_row_plane(rig, (float)row + film[1], lens, &plane);
    chord = (2.0f * lf_sampler_1d(sampler) - 1.0f) * plane.lens_chord;
    float slope = lf_rig_slope(rig, view, (float)column + film[0]) - chord / rig->focus;
    out->o = lf_rig_point(rig, rig->b[view] + chord, plane.ly, 0.0f);
    out->w = lf_normalize(lf_rig_direction(rig, slope, plane.my, 1.0f));
    out->sky = lf_rig_sky(&s->rig, &s->seen, out->w, plane.my);
    out->from = s->across ? rig->distance / lf_dot(out->w, rig->forward) : 0.0f;
}

static void find_ray_depths(const lf_restir *s, lf_restir_worker *w, int n, const int *at)
{
    lf_coarse_ray rays[LF_MAX_WALKS];
    lf_coarse_end ends[LF_MAX_WALKS];
    for (int i = 0; i < n; i++) {
        const lf_camera_ray *ray = &w->pixels[at[i]].ray;
        rays[i] = (lf_coarse_ray){ray->o, ray->w, (double)INFINITY, (double)INFINITY};
    }
    lf_coarse_grid_trace(&s->coarse, lf_depth_kernel_get(), n, rays, ends);
    for (int i = 0; i < n; i++)
        w->pixels[at[i]].ray.depth = ends[i].depth;
}

/* First collisions are in strata. */
void lf_restir_begin(const lf_restir *s, lf_restir_worker *w, int row, int n, const int *at,
                     uint64_t key, uint32_t index)
{
    const int each = s->reuse->walks;
    int n_walks = 0;
    for (int i = 0; i < n; i++) {
        lf_sampler sampler;
        lf_sampler_init(&sampler, s->sampler, lf_hash64(key, (uint64_t)at[i] + 16), index);
        aim(s, row, at[i] / s->rig.width, at[i] % s->rig.width, &sampler, &w->pixels[at[i]].ray);
    }
    find_ray_depths(s, w, n, at);
    for (int i = 0; i < n; i++) {
        const lf_camera_ray *ray = &w->pixels[at[i]].ray;
        w->tracer.rng = lf_hash64(lf_hash64(key, 11), lf_hash64((uint64_t)at[i], index));
        const uint64_t walks = lf_hash64(lf_hash64(key, 12), lf_hash64((uint64_t)at[i], index));
        for (int k = 0; ray->depth > 0.0 && k < each; k++) {
            const double u = (k + (double)lf_rng_fine(&w->tracer)) / each;
            w->walks[n_walks].ray = ray;
            w->walks[n_walks].u = u;
            w->walks[n_walks++].random = lf_hash64(walks, (uint64_t)k);
        }
    }
    lf_light_path_walk(&s->space, n_walks, w->walks, &w->tracer);
    w->tracer.rng = lf_hash64(lf_hash64(key, 13), lf_hash64((uint64_t)at[0], index));
    n_walks = 0;
    for (int i = 0; i < n; i++) {
        lf_restir_pixel *p = &w->pixels[at[i]];
        const int taken = p->ray.depth > 0.0 ? each : 0;
        lf_path_sample_draw(each, w->walks + n_walks, taken, &w->tracer, &p->sample);
        n_walks += taken;
        w->base_paths += each;
    }
}
