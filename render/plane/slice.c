#include "render/plane/slice.h"

#include <string.h>

#include "base/alloc.h"
#include "render/plane/kernel.h"

typedef struct plane_box {
    float x_lo, x_hi, z_lo, z_hi;
} plane_box;

/* Camera-space box of one volume: the corners of its scene-local bounds. */
static plane_box camera_box(const lf_volume *volume, const lf_rig *rig)
{
    plane_box box = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; corner++) {
        lf_vec3 p = lf_v3(corner & 1 ? volume->bounds_max.x : volume->bounds_min.x,
                          corner & 2 ? volume->bounds_max.y : volume->bounds_min.y,
                          corner & 4 ? volume->bounds_max.z : volume->bounds_min.z);
        lf_vec3 d = lf_sub(p, rig->eye);
        float x = lf_dot(d, rig->right), z = lf_dot(d, rig->forward);
        box = (plane_box){lf_min(box.x_lo, x), lf_max(box.x_hi, x), lf_min(box.z_lo, z),
                          lf_max(box.z_hi, z)};
    }
    box.z_lo = lf_max(box.z_lo, 0.0f);
    return box;
}

/* X between the outermost rays of the rig at either end of the box's depths. */
static void grow_fan(const plane_box *box, const lf_rig *rig, float *lo, float *hi)
{
    float window[2] = {rig->x0, rig->x0 + (float)rig->width * rig->dx};
    float depth[2] = {box->z_lo, box->z_hi};
    for (int i = 0; i < 8; i++) {
        const int k = i & 1 ? rig->n_views - 1 : 0;
        float z = depth[i >> 2 & 1];
        float x = rig->b[k] + (window[i >> 1 & 1] - rig->skew[k]) * z / rig->distance,
              lens = (rig->lens_radius + rig->blur) * fabsf(1.0f - z / rig->focus);
        *lo = lf_min(*lo, x - lens);
        *hi = lf_max(*hi, x + lens);
    }
}

static float step_between(const plane_box *a, const plane_box *b)
{
    return lf_max(lf_max(fabsf(a->x_lo - b->x_lo), fabsf(a->x_hi - b->x_hi)),
                  lf_max(fabsf(a->z_lo - b->z_lo), fabsf(a->z_hi - b->z_hi)));
}

/* The part of the volume that the rig's rays can meet. For a moving rig the boxes at all sampled
 * times, widened by the largest step. */
static plane_box box_of(const lf_volume *volume, const lf_rig *rigs, int n)
{
    plane_box box = camera_box(volume, &rigs[0]), last = box;
    float lo = INFINITY, hi = -INFINITY, step = 0.0f;
    for (int i = 1; i < n; i++) {
        plane_box next = camera_box(volume, &rigs[i]);
        step = lf_max(step, step_between(&last, &next));
        box = (plane_box){lf_min(box.x_lo, next.x_lo), lf_max(box.x_hi, next.x_hi),
                          lf_min(box.z_lo, next.z_lo), lf_max(box.z_hi, next.z_hi)};
        last = next;
    }
    if (step > 0.0f)
        box = (plane_box){box.x_lo - 0.5f * step, box.x_hi + 0.5f * step,
                          lf_max(box.z_lo - 0.5f * step, 0.0f), box.z_hi + 0.5f * step};
    for (int i = 0; i < n; i++)
        grow_fan(&box, &rigs[i], &lo, &hi);
    if (step > 0.0f) {
        lo -= step;
        hi += step;
    }
    box.x_lo = lf_max(box.x_lo, lo);
    box.x_hi = lf_min(box.x_hi, hi);
    return box;
}

bool lf_slice_frame_init(lf_slice_frame *frame, const lf_volume *volume, const lf_rig *rigs, int n)
{
    plane_box box = box_of(volume, rigs, n);
    if (!(volume->sigma_max > 0.0f) || !(box.z_hi > box.z_lo) || !(box.x_hi > box.x_lo))
        return false;
    float side = (float)(LF_SLICE_MAX_SIDE - 4);
    frame->dx = lf_max(volume->slice_cell, (box.x_hi - box.x_lo) / side);
    frame->dz = lf_max(volume->slice_cell, (box.z_hi - box.z_lo) / side);
    frame->nx = (int)ceilf((box.x_hi - box.x_lo) / frame->dx) + 4;
    frame->nz = (int)ceilf((box.z_hi - box.z_lo) / frame->dz) + 2;
    frame->x_min = 0.5f * (box.x_lo + box.x_hi) - 0.5f * (float)(frame->nx - 2) * frame->dx;
    frame->z_min = box.z_lo;
    return true;
}

static int tiles(int cells, int *out_cells)
{
    enum { LEAST = 8 };
    int each = (cells + LF_SLICE_TILES - 1) / LF_SLICE_TILES;
    *out_cells = each > LEAST ? each : LEAST;
    return (cells + *out_cells - 1) / *out_cells;
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
    slice->filled = lf_calloc((size_t)slice->nz, sizeof *slice->filled);
    slice->tiles_x = tiles(slice->nx, &slice->tile_cells_x);
    slice->tiles_z = tiles(slice->nz + 1, &slice->tile_cells_z);
    slice->rough = lf_calloc((size_t)slice->tiles_z * (size_t)slice->tiles_x, sizeof *slice->rough);
    slice->roughest = lf_calloc((size_t)slice->tiles_z, sizeof *slice->roughest);
    slice->near = lf_calloc((size_t)slice->tiles_z * (size_t)slice->tiles_x, sizeof *slice->near);
    bool complete = slice->sigma && slice->behind && slice->spans && slice->filled &&
                    slice->rough && slice->roughest && slice->near;
    return complete ? LF_OK : LF_E_NOMEM;
}

void lf_slice_finish(lf_slice *slice)
{
    lf_free(slice->sigma);
    lf_free(slice->behind);
    lf_free(slice->spans);
    lf_free(slice->filled);
    lf_free(slice->rough);
    lf_free(slice->roughest);
    lf_free(slice->near);
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

lf_line lf_slice_line(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane,
                      float z)
{
    lf_line line;
    lf_vec3 p = lf_rig_point(rig, 0.0f, plane->ly + plane->my * z, z);
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        line.origin[i] = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
        line.across[i] = m[0] * rig->right.x + m[1] * rig->right.y + m[2] * rig->right.z;
    }
    return line;
}

/* Marks that cells on either side of plane s, in one column of tiles, have this value near them. */
static void note_near(lf_slice *slice, int s, int tile, float sigma)
{
    for (int z = s / slice->tile_cells_z; z <= (s + 1) / slice->tile_cells_z; z++) {
        float *near = &slice->near[z * slice->tiles_x + tile];
        *near = lf_max(*near, sigma);
    }
}

/* The samples of a plane that may have a nonzero value near. */
static lf_samples clip_plane(const lf_slice *slice, const lf_grid *grid, const lf_line *line)
{
    float lo = 1.0f, hi = (float)(slice->nx - 2), dx = 1.0f / slice->inv_dx;
    for (int i = 0; i < 3; i++)
        clip(line->origin[i] + slice->x_min * line->across[i], dx * line->across[i],
             -(float)LF_BRICK_REACH, (float)(grid->size[i] + LF_BRICK_REACH), &lo, &hi);
    return hi >= lo ? (lf_samples){(int)ceilf(lo), (int)floorf(hi)} : (lf_samples){0, -1};
}

/* The samples of plane s in [lo, hi] that are not 0. */
static lf_samples occupied(const lf_slice *slice, int s, int lo, int hi)
{
    const float *sigma = slice->sigma + (size_t)s * (size_t)slice->stride;
    while (lo <= hi && sigma[lo] == 0.0f)
        lo++;
    while (hi > lo && sigma[hi] == 0.0f)
        hi--;
    return (lf_samples){lo, hi};
}

/* Samples plane s along its line. Returns the number of look-ups. */
static int sample(lf_slice *slice, int s, const lf_volume *volume, const lf_line *line,
                  const lf_kernels *kernels)
{
    enum { GROUP = 4 * LF_LANES };
    float *sigma = slice->sigma + (size_t)s * (size_t)slice->stride, dx = 1.0f / slice->inv_dx,
          most = 0.0f;
    int lookups = 0;
    lf_samples in = clip_plane(slice, volume->grid, line);
    /* its sample belongs to both tiles */
    int tile = in.first / slice->tile_cells_x, border = (tile + 1) * slice->tile_cells_x;
    for (int i = in.first; i <= in.last; i += GROUP) {
        float x[GROUP], value[GROUP], near[GROUP];
        bool any = false;
        for (int j = 0; j < GROUP; j++) {
            x[j] = slice->x_min + (float)(i + j) * dx;
            near[j] = i + j > in.last
                          ? 0.0f
                          : lf_grid_near(volume->grid, line->origin[0] + x[j] * line->across[0],
                                         line->origin[1] + x[j] * line->across[1],
                                         line->origin[2] + x[j] * line->across[2]);
            any = any || near[j] > 0.0f;
        }
        if (any)
            kernels->sample(volume, line, GROUP, x, value);
        lookups += any ? GROUP : 0;
        for (int j = 0; j < GROUP && i + j <= in.last; j++) {
            most = lf_max(most, near[j]);
            if (i + j == border) {
                note_near(slice, s, tile++, volume->sigma_scale * most);
                border += slice->tile_cells_x;
                most = near[j];
            }
            if (any)
                sigma[i + j] = value[j];
        }
    }
    note_near(slice, s, tile, volume->sigma_scale * most);
    slice->filled[s] = occupied(slice, s, in.first, in.last);
    return lookups;
}

/* A corner of the grid's support may lie between samples: zero samples next to a nonzero one get a
 * small value. New ones are negative until all are found. */
static void grow(lf_slice *slice, int s, lf_samples around)
{
    const float little = 0x1p-10f;
    float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
    const float *before = s > 0 ? row - slice->stride : row,
                *behind = s + 1 < slice->nz ? row + slice->stride : row;
    for (int i = around.first; i <= around.last; i++) {
        if (row[i] != 0.0f)
            continue;
        float a = lf_max(lf_max(before[i - 1], before[i]), before[i + 1]),
              b = lf_max(row[i - 1], row[i + 1]);
        float c = lf_max(lf_max(behind[i - 1], behind[i]), behind[i + 1]);
        row[i] = -little * lf_max(lf_max(a, b), lf_max(c, 0.0f));
    }
}

/* The samples of plane s within one of any nonzero sample. */
static lf_samples samples_around(const lf_slice *slice, int s)
{
    lf_samples around = {slice->nx, -1};
    for (int p = s > 0 ? s - 1 : s; p <= s + 1 && p < slice->nz; p++) {
        lf_samples f = slice->filled[p];
        around.first = f.first <= f.last && f.first - 1 < around.first ? f.first - 1 : around.first;
        around.last = f.first <= f.last && f.last + 1 > around.last ? f.last + 1 : around.last;
    }
    return (lf_samples){around.first > 1 ? around.first : 1,
                        around.last < slice->nx - 2 ? around.last : slice->nx - 2};
}

static void settle(lf_slice *slice, int s, lf_samples around)
{
    float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
    for (int i = around.first; i <= around.last; i++)
        row[i] = fabsf(row[i]);
    around = occupied(slice, s, around.first, around.last);
    slice->spans[s] = (lf_plane_span){INFINITY, -INFINITY};
    if (around.first > around.last)
        return;
    slice->spans[s].x_lo = slice->x_min + (float)(around.first - 1) / slice->inv_dx;
    slice->spans[s].x_hi = slice->x_min + (float)(around.last + 1) / slice->inv_dx;
    if (slice->first > slice->last)
        slice->first = s;
    slice->last = s;
}

/* Estimates the distance of linear interpolation from the grid, from the second difference d of
 * samples: d / 8 on a parabola, d / 4 at a kink. Returns the sum of squares over a tile's row. */
static float distances(const lf_slice *slice, int s, int from, int to)
{
    const float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
    const float *before = s > 0 ? row - slice->stride : row,
                *behind = s + 1 < slice->nz ? row + slice->stride : row;
    float sum = 0.0f;
    for (int i = from; i < to; i++) {
        float along = fabsf(row[i - 1] - 2.0f * row[i] + row[i + 1]),
              across = fabsf(before[i] - 2.0f * row[i] + behind[i]);
        sum += (along + across) * (along + across);
    }
    return 0.0625f * sum;
}

/* Sets rough from the samples, and to a small value where they are flat. */
static void note_rough(lf_slice *slice)
{
    const float little = 0x1p-10f;
    int nx = slice->tile_cells_x, nz = slice->tile_cells_z;
    for (int z = 0; z < slice->tiles_z; z++) {
        slice->roughest[z] = 0.0f;
        for (int x = 0; x < slice->tiles_x; x++) {
            float *rough = &slice->rough[z * slice->tiles_x + x],
                  near = slice->near[z * slice->tiles_x + x], sum = 0.0f;
            int from = x * nx, to = from + nx < slice->nx - 1 ? from + nx : slice->nx - 1;
            *rough = 0.0f;
            if (!(near > 0.0f))
                continue;
            for (int s = z * nz; s < (z + 1) * nz && s < slice->nz; s++)
                sum += distances(slice, s, from > 0 ? from : 1, to);
            *rough = sqrtf(sum / (float)(nx * nz)) + little * near;
            slice->roughest[z] = lf_max(slice->roughest[z], *rough);
        }
    }
}

int64_t lf_slice_fill(lf_slice *slice, const lf_slice_frame *frame, const lf_volume *volume,
                      const lf_rig *rig, const lf_row_plane *plane, const float phase[2],
                      const lf_kernels *kernels)
{
    int64_t lookups = 0;
    slice->x_min = frame->x_min - phase[0] * frame->dx;
    slice->z0 = frame->z_min - phase[1] * frame->dz;
    slice->first = 0;
    slice->last = -1;
    memset(slice->sigma, 0, sizeof *slice->sigma * (size_t)slice->nz * (size_t)slice->stride);
    memset(slice->near, 0, sizeof *slice->near * (size_t)slice->tiles_z * (size_t)slice->tiles_x);
    for (int s = 0; s < slice->nz; s++) {
        float z = slice->z0 + (float)s * slice->dz;
        lf_line line = lf_slice_line(volume, rig, plane, z);
        lookups += sample(slice, s, volume, &line, kernels);
        slice->behind[s] = lf_slice_share(lf_max(-z * slice->inv_dz, -1.0f));
    }
    for (int s = 0; s < slice->nz; s++)
        grow(slice, s, samples_around(slice, s));
    for (int s = 0; s < slice->nz; s++)
        settle(slice, s, samples_around(slice, s));
    note_rough(slice);
    return lookups;
}

/* Position in a step (from = its start in units of the step) at which the integral of a density
 * that rises linearly from a by b reaches r; r must be below the integral over the whole step. */
static float invert(float a, float b, float from, float r)
{
    float at = lf_max(a + b * from, 0.0f);
    return from + 2.0f * r / (at + sqrtf(lf_max(at * at + 2.0f * b * r, 0.0f)));
}

float lf_slice_march(const lf_slice *slice, float x0, float slope, float z_end, float stop,
                     float *out_z)
{
    float tau = 0.0f, before = 0.0f;
    *out_z = z_end;
    for (int s = slice->first; s <= slice->last + 1; s++) {
        float z = slice->z0 + (float)s * slice->dz, lo = z - slice->dz, x = x0 + slope * z,
              here = 0.0f;
        if (lo >= z_end)
            break;
        if (s <= slice->last && x > slice->spans[s].x_lo && x < slice->spans[s].x_hi)
            here = lf_slice_at(slice, s, x);
        float a = before, b = here - before;
        before = here;
        if (!(a + here > 0.0f) || z <= 0.0f)
            continue;
        float from = lf_max(-lo * slice->inv_dz, 0.0f),
              to = lf_min((z_end - lo) * slice->inv_dz, 1.0f);
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
