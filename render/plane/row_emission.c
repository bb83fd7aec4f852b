#include "render/plane/row_emission.h"

#include <string.h>

#include "render/transport/light/volume_emission.h"

/* The fan during its walk through the media, from the cameras to increasing depths. */
typedef struct walk {
    const lf_row_emission *emission;
    lf_tracer *tracer;
    float *behind; /* of slices: the share of a plane's hat that lies before z */
    float z;
    float tau[LF_MAX_LANES]; /* of grids, per unit of Z, up to z */
    /* correction weights, and transmittance of alpha surfaces, up to z */
    float factor[LF_MAX_LANES];
} walk;

/* A slice from w->z on: marches subtract the part before z in the same way as the part behind the
 * cameras. */
static void through_slice(const walk *w, const lf_slice *slice, const float *z_end, float *tau)
{
    const lf_rays *rays = w->emission->rays;
    float t, to = z_end[0];
    lf_slice part = *slice;
    for (int k = 1; k < rays->n; k++)
        to = lf_max(to, z_end[k]);
    int first = lf_slice_plane(slice, w->z, &t), last = lf_slice_plane(slice, to, &t) + 1;
    part.first = first > slice->first ? first : slice->first;
    part.last = last < slice->last ? last : slice->last;
    part.behind = w->behind;
    for (int s = part.first; s <= first + 1 && s <= part.last; s++) {
        t = (w->z - (slice->z0 + (float)s * slice->dz)) * slice->inv_dz;
        w->behind[s] = lf_slice_share(lf_min(lf_max(t, -1.0f), 1.0f));
    }
    rays->kernels->march(&part, rays->n, rays->x0, rays->slope, z_end, tau, NULL);
    for (int s = part.first; s <= first + 1 && s <= part.last; s++)
        w->behind[s] = 0.0f;
}

/* Voxels from w->z on, as for cameras at that depth. */
static void through_voxels(const walk *w, const lf_voxels *voxels, const float *z_end, float *tau)
{
    const lf_rays *rays = w->emission->rays;
    float x0[LF_MAX_LANES], end[LF_MAX_LANES];
    lf_voxels part = *voxels;
    for (int i = 0; i < 3; i++)
        part.origin[i] += w->z * voxels->depth[i];
    for (int k = 0; k < rays->n; k++) {
        x0[k] = rays->x0[k] + rays->slope[k] * w->z;
        end[k] = lf_max(z_end[k] - w->z, 0.0f);
    }
    lf_voxels_depths(&part, rays->n, x0, rays->slope, end, tau);
}

/* On to depth z; depth[n]: optical, from the cameras to there or to the ray's end. */
static void advance(walk *w, float z, float *depth)
{
    const lf_row_emission *emission = w->emission;
    const lf_rays *rays = emission->rays;
    float z_end[LF_MAX_LANES] = {0.0f};
    lf_rays part = *rays;
    part.z_from = w->z;
    part.z_end = z_end;
    for (int k = 0; k < rays->n; k++)
        z_end[k] = lf_min(z, rays->z_end[k]);
    for (int i = 0; i < emission->media->n_here; i++) {
        const lf_medium *medium = &emission->media->item[emission->media->here[i]];
        if (medium->kind == LF_MEDIUM_SLICE)
            through_slice(w, &medium->slice, z_end, w->tau);
        else if (medium->kind == LF_MEDIUM_VOXELS)
            through_voxels(w, &medium->voxels, z_end, w->tau);
    }
    memcpy(depth, w->tau, sizeof *depth * (size_t)rays->n);
    for (int i = 0; i < emission->media->n_here; i++) {
        const lf_medium *medium = &emission->media->item[emission->media->here[i]];
        if (medium->kind == LF_MEDIUM_BODY)
            rays->kernels->through(&medium->body, rays->n, rays->x0, rays->slope, z_end, depth);
    }
    for (int k = 0; k < rays->n; k++)
        depth[k] *= emission->length[k];
    if (emission->corrected)
        lf_correction_transmittance(emission->media, &part, LF_CORRECTION_EXIT, 0.0f, w->tracer,
                                    w->factor);
    if (emission->alphas)
        lf_alphas_to(emission->alphas, z_end, w->factor);
    w->z = z;
}

/* The depths between which a field lies, and its voxels' length. */
typedef struct range {
    float from, to, step;
} range;

static range range_of(const lf_medium *emissive, const lf_volume *volume, const lf_rig *rig)
{
    const lf_slice *slice = &emissive->slice;
    range r = {INFINITY, 0.0f, volume->voxel};
    if (emissive->kind == LF_MEDIUM_SLICE)
        return (range){lf_max(slice->z0 + (float)(slice->first - 1) * slice->dz, 0.0f),
                       slice->z0 + (float)(slice->last + 1) * slice->dz, slice->dz};
    for (int corner = 0; corner < 8; corner++) {
        lf_vec3 p = lf_v3(corner & 1 ? volume->bounds_max.x : volume->bounds_min.x,
                          corner & 2 ? volume->bounds_max.y : volume->bounds_min.y,
                          corner & 4 ? volume->bounds_max.z : volume->bounds_min.z);
        float z = lf_dot(lf_sub(p, rig->eye), rig->forward);
        r.from = lf_min(r.from, z);
        r.to = lf_max(r.to, z);
    }
    r.from = lf_max(r.from, 0.0f);
    return r;
}

/* Whether the fan may meet the slice at this depth, between two of its planes. */
static bool may_meet(const lf_slice *slice, const lf_rays *rays, float z)
{
    float t, a = rays->x0[0] + rays->slope[0] * z,
             b = rays->x0[rays->n - 1] + rays->slope[rays->n - 1] * z;
    int s = lf_slice_plane(slice, z, &t);
    bool met = false;
    for (int i = s; i <= s + 1; i++)
        met = met || (i >= 0 && i < slice->nz && lf_max(a, b) > slice->spans[i].x_lo &&
                      lf_min(a, b) < slice->spans[i].x_hi);
    return met;
}

/* The field's values on the rays at this depth; 0 for rays that have ended. Returns whether any is
 * nonzero. */
static bool look_up(const lf_volume *volume, const lf_rays *rays, float z, float *value)
{
    const lf_line line = lf_slice_line(volume, rays->rig, rays->plane, z);
    float x[LF_MAX_LANES];
    int lit = 0;
    for (int k = 0; k < rays->n; k++)
        x[k] = rays->x0[k] + rays->slope[k] * z;
    if (!volume->nearest)
        rays->kernels->sample(volume, &line, rays->n, x, value);
    for (int k = 0; k < rays->n && volume->nearest; k++)
        value[k] = lf_grid_voxel(volume->grid, line.origin[0] + x[k] * line.across[0],
                                 line.origin[1] + x[k] * line.across[1],
                                 line.origin[2] + x[k] * line.across[2]);
    for (int k = 0; k < rays->n; k++) {
        value[k] = z < rays->z_end[k] ? value[k] : 0.0f;
        lit |= value[k] > 0.0f;
    }
    return lit;
}

/* Adds the emission at depth z, where values[k] represent `step` of Z. */
static void add(walk *w, const lf_volume_emission *light, float z, float step, const float *value,
                lf_vec3 *out)
{
    const lf_row_emission *emission = w->emission;
    float depth[LF_MAX_LANES], through[LF_MAX_LANES], least = INFINITY;
    int n = emission->rays->n;
    advance(w, z, depth);
    for (int k = 0; k < n; k++) {
        through[k] = value[k] > 0.0f ? 1.0f : 0.0f;
        least = value[k] > 0.0f ? lf_min(least, depth[k]) : least;
    }
    emission->rays->kernels->densities(n, through, depth, through);
    float nearest = step * expf(-least);
    for (int k = 0; k < n; k++) {
        if (through[k] > 0.0f)
            out[k] = lf_madd(out[k], nearest * through[k] * w->factor[k] * emission->length[k],
                             lf_emission_radiance(light, value[k]));
    }
}

static void grid(const lf_row_emission *emission, const lf_medium *emissive, float u,
                 lf_tracer *tracer, float *behind, lf_vec3 *out)
{
    const lf_rays *rays = emission->rays;
    const lf_volume *volume = &rays->scene->emissive.field[emissive->volume];
    const range r = range_of(emissive, volume, rays->rig);
    walk w = {.emission = emission, .tracer = tracer};
    float value[LF_MAX_LANES] = {0.0f};
    w.behind = behind;
    for (int k = 0; k < rays->n; k++)
        w.factor[k] = 1.0f;
    for (int i = 0;; i++) {
        float z = r.from + ((float)i + u) * r.step;
        if (!(z < r.to))
            break;
        if (emissive->kind == LF_MEDIUM_SLICE && !may_meet(&emissive->slice, rays, z))
            continue;
        tracer->lookups += rays->n;
        if (look_up(volume, rays, z, value))
            add(&w, &rays->scene->emissive.light[emissive->volume], z, r.step, value, out);
    }
}

/* ------------------------------------------------------------------------------------ shapes -- */

/* A shape's part of the rays, in what it itself lets through. */
typedef struct inside {
    float sigma_t; /* its own */
    float from[LF_MAX_LANES], part[LF_MAX_LANES];
    float lost[LF_MAX_LANES]; /* 1 - exp(-its optical depth) */
} inside;

static const lf_medium *own_medium(const lf_media *media, int volume)
{
    const lf_medium *found = NULL;
    for (int i = 0; i < media->n_here; i++)
        if (media->item[media->here[i]].volume == volume)
            found = &media->item[media->here[i]];
    return found;
}

/* Returns in weight[k] the length of the part, weighted by its own transmittance: int exp(-sigma s)
 * ds. */
static void enter(const lf_row_emission *emission, const lf_body *body, inside *in, float *weight)
{
    const lf_rays *rays = emission->rays;
    for (int k = 0; k < rays->n; k++) {
        float to;
        lf_body_interval(body, rays->x0[k], rays->slope[k], &in->from[k], &to);
        in->part[k] = lf_max(lf_min(to, rays->z_end[k]) - in->from[k], 0.0f);
        float length = in->part[k] * emission->length[k], depth = in->sigma_t * length;
        in->lost[k] = -expm1f(-depth);
        /* 1 - x/2 is exact there */
        weight[k] = depth > 1e-4f ? in->lost[k] / in->sigma_t : length * (1.0f - 0.5f * depth);
    }
}

/* Multiplies factor[k] by the transmittance of all media except the shape's own, whose depth is
 * own[k], up to z[k]. */
static void through_others(const lf_row_emission *emission, const float *z, const float *own,
                           lf_tracer *tracer, float *factor)
{
    const lf_rays *rays = emission->rays;
    float tau[LF_MAX_LANES];
    lf_rays part = *rays;
    part.z_end = z;
    lf_media_depths(emission->media, &part, tau, -1, NULL);
    if (emission->corrected)
        lf_correction_transmittance(emission->media, &part, LF_CORRECTION_EXIT, 0.0f, tracer,
                                    factor);
    for (int k = 0; k < rays->n; k++)
        factor[k] *= expf(-lf_max(tau[k] * emission->length[k] - own[k], 0.0f));
}

/* Multiplies weight by the transmittance of other media and alpha surfaces: the mean over points in
 * the part, distributed by its own transmittance. */
static void behind_others(const lf_row_emission *emission, const inside *in, bool others, float u,
                          lf_tracer *tracer, float *weight)
{
    enum { POINTS = 4 };
    const lf_rays *rays = emission->rays;
    float z[LF_MAX_LANES], own[LF_MAX_LANES], factor[LF_MAX_LANES], passed[LF_MAX_LANES],
        mean[LF_MAX_LANES] = {0.0f};
    for (int k = 0; k < rays->n; k++)
        passed[k] = 1.0f;
    for (int i = 0; i < POINTS; i++) {
        float share = ((float)i + u) / POINTS;
        for (int k = 0; k < rays->n; k++) {
            float per_z = in->sigma_t * emission->length[k],
                  at = in->lost[k] > 1e-4f ? -log1pf(-share * in->lost[k]) / per_z
                                           : share * in->part[k];
            z[k] = lf_min(in->from[k] + lf_min(at, in->part[k]), rays->z_end[k]);
            own[k] = per_z * (z[k] - in->from[k]);
            factor[k] = 1.0f / POINTS;
        }
        if (others)
            through_others(emission, z, own, tracer, factor);
        if (emission->alphas)
            lf_alphas_to(emission->alphas, z, passed);
        for (int k = 0; k < rays->n; k++)
            mean[k] += factor[k] * passed[k];
    }
    for (int k = 0; k < rays->n; k++)
        weight[k] *= mean[k];
}

static void shape(const lf_row_emission *emission, const lf_medium *emissive, float u,
                  lf_tracer *tracer, lf_vec3 *out)
{
    const lf_scene *scene = emission->rays->scene;
    const lf_volume_emission *light = &scene->emissive.light[emissive->volume];
    const lf_medium *own = own_medium(emission->media, light->volume);
    inside in = {.sigma_t = own ? own->body.sigma_t : 0.0f};
    float weight[LF_MAX_LANES];
    enter(emission, &emissive->body, &in, weight);
    const bool others = emission->media->n_here > (own ? 1 : 0);
    if (others || emission->alphas)
        behind_others(emission, &in, others, u, tracer, weight);
    for (int k = 0; k < emission->rays->n; k++)
        out[k] = lf_madd(out[k], weight[k], light->colour);
}

void lf_row_emission_fan(const lf_row_emission *emission, float u, lf_tracer *tracer,
                         lf_row_emission_memory *memory, lf_vec3 *out)
{
    for (int i = 0; i < memory->emissive.n_here; i++) {
        const lf_medium *emissive = &memory->emissive.item[memory->emissive.here[i]];
        if (emission->alphas)
            lf_alphas_rewind(emission->alphas);
        if (emissive->kind == LF_MEDIUM_BODY)
            shape(emission, emissive, u, tracer, out);
        else
            grid(emission, emissive, u, tracer, memory->behind, out);
    }
}
