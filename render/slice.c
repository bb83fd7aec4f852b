#include "render/slice.h"

#include <string.h>

#include "base/alloc.h"

typedef struct lf_box {
    float x_lo, x_hi, z_lo, z_hi;
} lf_box;

/* Camera-space box of one volume: the corners of its scene-local bounds. */
static lf_box camera_box(const lf_volume *volume, const lf_rig *rig)
{
    lf_box box = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; corner++) {
        lf_vec3 p = lf_v3(corner & 1 ? volume->bounds_max.x : volume->bounds_min.x,
                          corner & 2 ? volume->bounds_max.y : volume->bounds_min.y,
                          corner & 4 ? volume->bounds_max.z : volume->bounds_min.z);
        lf_vec3 d = lf_sub(p, rig->eye);
        float x = lf_dot(d, rig->right), z = lf_dot(d, rig->forward);
        box = (lf_box){lf_min(box.x_lo, x), lf_max(box.x_hi, x), lf_min(box.z_lo, z), lf_max(box.z_hi, z)};
    }
    box.z_lo = lf_max(box.z_lo, 0.0f);
    return box;
}

/* Cuts the box to what the rig's rays can meet: X between the outermost rays at either end of its depths. */
static void cut_to_fan(lf_box *box, const lf_rig *rig)
{
    float lo = INFINITY, hi = -INFINITY, window[2] = {rig->x0, rig->x0 + (float)rig->width * rig->dx};
    float depth[2] = {box->z_lo, box->z_hi};
    for (int i = 0; i < 8; i++) {
        float b = rig->b[i & 1 ? rig->n_views - 1 : 0], z = depth[i >> 2 & 1];
        float x = b + (window[i >> 1 & 1] - b) * z / rig->distance, lens = rig->lens_radius * fabsf(1.0f - z / rig->focus);
        lo = lf_min(lo, x - lens);
        hi = lf_max(hi, x + lens);
    }
    box->x_lo = lf_max(box->x_lo, lo);
    box->x_hi = lf_min(box->x_hi, hi);
}

void lf_slice_frame_init(lf_slice_frame *frame, const lf_scene *scene, const lf_rig *rig)
{
    lf_box all = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    float cell = INFINITY;
    memset(frame, 0, sizeof *frame);
    for (int i = 0; i < scene->n_volumes; i++) {
        lf_box box = camera_box(&scene->volumes[i], rig);
        cut_to_fan(&box, rig);
        if (!(scene->volumes[i].sigma_max > 0.0f) || !(box.z_hi > box.z_lo) || !(box.x_hi > box.x_lo))
            continue;
        all = (lf_box){lf_min(all.x_lo, box.x_lo), lf_max(all.x_hi, box.x_hi), lf_min(all.z_lo, box.z_lo),
                       lf_max(all.z_hi, box.z_hi)};
        cell = lf_min(cell, scene->volumes[i].slice_cell);
    }
    frame->empty = !(all.x_hi > all.x_lo && all.z_hi > all.z_lo);
    if (frame->empty)
        return;
    float side = (float)(LF_SLICE_MAX_SIDE - 4);
    frame->dx = lf_max(cell, (all.x_hi - all.x_lo) / side);
    frame->dz = lf_max(cell, (all.z_hi - all.z_lo) / side);
    frame->nx = (int)ceilf((all.x_hi - all.x_lo) / frame->dx) + 3;
    frame->nz = (int)ceilf((all.z_hi - all.z_lo) / frame->dz) + 1;
    frame->x_min = 0.5f * (all.x_lo + all.x_hi) - 0.5f * (float)(frame->nx - 1) * frame->dx;
    frame->z_min = all.z_lo;
}

lf_status lf_slice_init(lf_slice *slice, const lf_slice_frame *frame)
{
    slice->first = 0;
    slice->last = -1;
    if (frame->empty)
        return LF_OK;
    slice->sigma = lf_calloc((size_t)frame->nz * (size_t)(frame->nx + 1), sizeof *slice->sigma);
    slice->slabs = lf_calloc((size_t)frame->nz, sizeof *slice->slabs);
    return slice->sigma && slice->slabs ? LF_OK : LF_E_NOMEM;
}

void lf_slice_finish(lf_slice *slice)
{
    lf_free(slice->sigma);
    lf_free(slice->slabs);
    memset(slice, 0, sizeof *slice);
}

/* The part of i in [lo, hi] for which a + i d lies in [min, max]. */
static void clip(float a, float d, float min, float max, float *lo, float *hi)
{
    if (d == 0.0f) {
        if (a < min || a > max)
            *hi = -1.0f;
        return;
    }
    float t0 = (min - a) / d, t1 = (max - a) / d;
    *lo = lf_max(*lo, lf_min(t0, t1));
    *hi = lf_min(*hi, lf_max(t0, t1));
}

static lf_vec3 apply(const float m[3][4], lf_vec3 p)
{
    return lf_v3(m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3], m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                 m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]);
}

/* The part of i in [lo, hi] for which start + i step lies in the unit ball. */
static void clip_ball(lf_vec3 start, lf_vec3 step, float *lo, float *hi)
{
    float a = lf_dot(step, step), middle = -lf_dot(start, step) / a;
    lf_vec3 nearest = lf_madd(start, middle, step);
    float h2 = (1.0f - lf_dot(nearest, nearest)) / a;
    float h = h2 > 0.0f ? sqrtf(h2) : -1.0f;
    *lo = lf_max(*lo, middle - h);
    *hi = lf_min(*hi, middle + h);
}

static void clip_box(lf_vec3 start, lf_vec3 step, lf_vec3 min, lf_vec3 max, float *lo, float *hi)
{
    clip(start.x, step.x, min.x, max.x, lo, hi);
    clip(start.y, step.y, min.y, max.y, lo, hi);
    clip(start.z, step.z, min.z, max.z, lo, hi);
}

/* A homogeneous shape gives each sample the share of its surroundings (half a step to either side) that lies inside: edges
 * that do not depend on where the samples fall. */
static void add_shape(const lf_volume *volume, lf_vec3 start, lf_vec3 step, int nx, float *sigma)
{
    float lo = 0.0f, hi = (float)(nx - 1);
    if (volume->kind == LF_VOLUME_SPHERE)
        clip_ball(start, step, &lo, &hi);
    else
        clip_box(start, step, lf_v3(-1.0f, -1.0f, -1.0f), lf_v3(1.0f, 1.0f, 1.0f), &lo, &hi);
    if (!(hi > lo))
        return;
    int last = (int)floorf(hi + 0.5f);
    for (int i = (int)floorf(lo + 0.5f); i <= last && i < nx; i++) {
        float share = lf_min(hi, (float)i + 0.5f) - lf_max(lo, (float)i - 0.5f);
        sigma[i] += volume->sigma_scale * lf_max(share, 0.0f);
    }
}

/* Adds one grid to one slab's samples; start is volume space at sample 0, step per sample. Returns the look-ups made. */
static int add_grid(const lf_volume *volume, lf_vec3 start, lf_vec3 step, int nx, float *sigma)
{
    const lf_grid *grid = volume->grid;
    float lo = 0.0f, hi = (float)(nx - 1);
    clip_box(start, step, lf_v3(-1.0f, -1.0f, -1.0f), lf_v3((float)grid->size[0], (float)grid->size[1], (float)grid->size[2]), &lo,
             &hi);
    if (!(hi >= lo))
        return 0;
    int i0 = (int)ceilf(lo), i1 = (int)floorf(hi);
    for (int i = i0; i <= i1; i++) {
        lf_vec3 p = lf_madd(start, (float)i, step);
        float v = volume->nearest ? lf_grid_nearest(grid, p.x, p.y, p.z) : lf_grid_linear(grid, p.x, p.y, p.z);
        sigma[i] += volume->sigma_scale * v;
    }
    return i1 >= i0 ? i1 - i0 + 1 : 0;
}

static void note_occupied(lf_slice *slice, int s, const float *sigma, float dx)
{
    int lo = 0, hi = slice->nx - 1;
    while (lo <= hi && sigma[lo] == 0.0f)
        lo++;
    while (hi > lo && sigma[hi] == 0.0f)
        hi--;
    slice->slabs[s].x_lo = slice->x_min + (float)(lo - 1) * dx;
    slice->slabs[s].x_hi = lo > hi ? -INFINITY : slice->x_min + (float)(hi + 1) * dx;
    if (lo > hi) {
        slice->slabs[s].x_lo = INFINITY;
        return;
    }
    if (slice->first > slice->last)
        slice->first = s;
    slice->last = s;
}

void lf_slice_fill(lf_slice *slice, const lf_slice_frame *frame, const lf_scene *scene, const lf_rig *rig,
                   const lf_row_plane *plane, float phase, int64_t *lookups)
{
    slice->nx = frame->nx;
    slice->nz = frame->nz;
    slice->x_min = frame->x_min;
    slice->inv_dx = 1.0f / frame->dx;
    slice->dz = frame->dz;
    slice->z0 = frame->z_min - phase * frame->dz;
    slice->first = 0;
    slice->last = -1;
    for (int s = 0; s < slice->nz; s++) {
        float z = slice->z0 + ((float)s + 0.5f) * slice->dz;
        float *sigma = slice->sigma + (size_t)s * (size_t)(slice->nx + 1);
        memset(sigma, 0, sizeof *sigma * (size_t)(slice->nx + 1));
        lf_vec3 p = lf_rig_point(rig, slice->x_min, plane->ly + plane->my * z, z);
        lf_vec3 q = lf_madd(p, frame->dx, rig->right);
        for (int v = 0; v < scene->n_volumes; v++) {
            const lf_volume *volume = &scene->volumes[v];
            lf_vec3 start = apply(volume->to_volume, p);
            lf_vec3 step = lf_sub(apply(volume->to_volume, q), start);
            if (volume->kind == LF_VOLUME_GRID)
                *lookups += add_grid(volume, start, step, slice->nx, sigma);
            else
                add_shape(volume, start, step, slice->nx, sigma);
        }
        note_occupied(slice, s, sigma, frame->dx);
    }
}

float lf_slice_march(const lf_slice *slice, float x0, float slope, float z_end, float stop, float *out_z)
{
    float tau = 0.0f;
    for (int s = slice->first; s <= slice->last; s++) {
        float lo = slice->z0 + (float)s * slice->dz;
        if (lo >= z_end)
            break;
        float x = x0 + slope * (lo + 0.5f * slice->dz);
        if (x <= slice->slabs[s].x_lo || x >= slice->slabs[s].x_hi)
            continue;
        float from = lf_max(lo, 0.0f);
        float step = lf_min(z_end, lo + slice->dz) - from;
        float sigma = lf_slice_at(slice, s, x);
        float next = tau + sigma * step;
        if (next > stop) {
            *out_z = lf_min(from + (stop - tau) / sigma, from + step);
            return stop;
        }
        tau = next;
    }
    *out_z = z_end;
    return tau;
}
