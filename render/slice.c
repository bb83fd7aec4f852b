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

bool lf_slice_frame_init(lf_slice_frame *frame, const lf_volume *volume, const lf_rig *rig)
{
    lf_box box = camera_box(volume, rig);
    cut_to_fan(&box, rig);
    if (!(volume->sigma_max > 0.0f) || !(box.z_hi > box.z_lo) || !(box.x_hi > box.x_lo))
        return false;
    float side = (float)(LF_SLICE_MAX_SIDE - 4);
    frame->dx = lf_max(volume->slice_cell, (box.x_hi - box.x_lo) / side);
    frame->dz = lf_max(volume->slice_cell, (box.z_hi - box.z_lo) / side);
    frame->nx = (int)ceilf((box.x_hi - box.x_lo) / frame->dx) + 3;
    frame->nz = (int)ceilf((box.z_hi - box.z_lo) / frame->dz) + 2;
    frame->x_min = 0.5f * (box.x_lo + box.x_hi) - 0.5f * (float)(frame->nx - 1) * frame->dx;
    frame->z_min = box.z_lo;
    return true;
}

lf_status lf_slice_init(lf_slice *slice, const lf_slice_frame *frame)
{
    slice->first = 0;
    slice->last = -1;
    slice->nx = frame->nx;
    slice->nz = frame->nz;
    slice->stride = frame->nx + LF_SLICE_PADDING;
    slice->x_min = frame->x_min;
    slice->inv_dx = 1.0f / frame->dx;
    slice->dz = frame->dz;
    slice->inv_dz = 1.0f / frame->dz;
    slice->sigma = lf_calloc((size_t)slice->nz * (size_t)slice->stride, sizeof *slice->sigma);
    slice->behind = lf_calloc((size_t)slice->nz, sizeof *slice->behind);
    slice->spans = lf_calloc((size_t)slice->nz, sizeof *slice->spans);
    return slice->sigma && slice->behind && slice->spans ? LF_OK : LF_E_NOMEM;
}

void lf_slice_finish(lf_slice *slice)
{
    lf_free(slice->sigma);
    lf_free(slice->behind);
    lf_free(slice->spans);
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

static void clip_box(lf_vec3 start, lf_vec3 step, lf_vec3 min, lf_vec3 max, float *lo, float *hi)
{
    clip(start.x, step.x, min.x, max.x, lo, hi);
    clip(start.y, step.y, min.y, max.y, lo, hi);
    clip(start.z, step.z, min.z, max.z, lo, hi);
}

/* Samples one plane; start is volume space at sample 0, step per sample. Returns the look-ups made. */
static int sample(const lf_volume *volume, lf_vec3 start, lf_vec3 step, int nx, float *sigma)
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
        sigma[i] = volume->sigma_scale * v;
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
    slice->spans[s] = (lf_plane_span){INFINITY, -INFINITY};
    if (lo > hi)
        return;
    slice->spans[s].x_lo = slice->x_min + (float)(lo - 1) * dx;
    slice->spans[s].x_hi = slice->x_min + (float)(hi + 1) * dx;
    if (slice->first > slice->last)
        slice->first = s;
    slice->last = s;
}

int64_t lf_slice_fill(lf_slice *slice, const lf_slice_frame *frame, const lf_volume *volume, const lf_rig *rig,
                      const lf_row_plane *plane, float phase)
{
    int64_t lookups = 0;
    slice->z0 = frame->z_min - phase * frame->dz;
    slice->first = 0;
    slice->last = -1;
    memset(slice->sigma, 0, sizeof *slice->sigma * (size_t)slice->nz * (size_t)slice->stride);
    for (int s = 0; s < slice->nz; s++) {
        float z = slice->z0 + (float)s * slice->dz, *sigma = slice->sigma + (size_t)s * (size_t)slice->stride;
        lf_vec3 p = lf_rig_point(rig, slice->x_min, plane->ly + plane->my * z, z);
        lf_vec3 q = lf_madd(p, frame->dx, rig->right);
        lf_vec3 start = apply(volume->to_volume, p), step = lf_sub(apply(volume->to_volume, q), start);
        lookups += sample(volume, start, step, slice->nx, sigma);
        slice->behind[s] = lf_slice_share(lf_max(-z * slice->inv_dz, -1.0f));
        note_occupied(slice, s, sigma, frame->dx);
    }
    return lookups;
}

/* Where in a step, from = where it starts in units of the step, a density that rises linearly from a by b has the integral r; r is
 * below the integral over the whole step. */
static float invert(float a, float b, float from, float r)
{
    float at = lf_max(a + b * from, 0.0f);
    return from + 2.0f * r / (at + sqrtf(lf_max(at * at + 2.0f * b * r, 0.0f)));
}

float lf_slice_march(const lf_slice *slice, float x0, float slope, float z_end, float stop, float *out_z)
{
    float tau = 0.0f, before = 0.0f;
    *out_z = z_end;
    for (int s = slice->first; s <= slice->last + 1; s++) {
        float z = slice->z0 + (float)s * slice->dz, lo = z - slice->dz, x = x0 + slope * z, here = 0.0f;
        if (lo >= z_end)
            break;
        if (s <= slice->last && x > slice->spans[s].x_lo && x < slice->spans[s].x_hi)
            here = lf_slice_at(slice, s, x);
        float a = before, b = here - before;
        before = here;
        if (!(a + here > 0.0f) || z <= 0.0f)
            continue;
        float from = lf_max(-lo * slice->inv_dz, 0.0f), to = lf_min((z_end - lo) * slice->inv_dz, 1.0f);
        float step = (to - from) * (a + 0.5f * b * (from + to)) * slice->dz;
        if (tau + step > stop) {
            float t = lf_min(invert(a, b, from, (stop - tau) * slice->inv_dz), to);
            *out_z = lf_min(lo + t * slice->dz, z_end);
            return stop;
        }
        tau += step;
    }
    return tau;
}
