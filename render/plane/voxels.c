#include "render/plane/voxels.h"

#include "render/plane/body.h"
#include "render/scene/look_up.h"

/* Cells of a grid are counted from -1 (scene.h): in the coordinates here, voxel space + 1.5, voxel
 * v fills [v + 1, v + 2) and brick b [8 b, 8 b + 8). */
#define SHIFT 1.5f

typedef struct ray {
    float o[3], inverse[3]; /* of the direction, never 0 */
    float d[3];
    int step[3], up[3]; /* -1 and 0, or 1 and 1 */
    float from, to;     /* its part inside of the grid; from >= to: none */
} ray;

/* A march in progress. */
typedef struct march {
    float z, depth, stop; /* depths in units of the grid's values */
} march;

bool lf_voxels_cut(lf_voxels *voxels, const lf_volume *volume, const lf_rig *rig,
                   const lf_row_plane *plane)
{
    voxels->grid = volume->grid;
    voxels->sigma_scale = volume->sigma_scale;
    return lf_body_rays(volume, rig, plane, voxels->origin, voxels->across, voxels->depth);
}

static ray aim(const lf_voxels *voxels, float x0, float slope, float z_end)
{
    ray r = {.from = 0.0f, .to = z_end};
    for (int i = 0; i < 3; i++) {
        r.o[i] = voxels->origin[i] + x0 * voxels->across[i] + SHIFT;
        r.d[i] = voxels->depth[i] + slope * voxels->across[i];
        /* Along faces: they are far away, or right here, never 0/0. */
        r.d[i] = fabsf(r.d[i]) > 1e-30f ? r.d[i] : 1e-30f;
        r.inverse[i] = 1.0f / r.d[i];
        r.up[i] = r.d[i] > 0.0f;
        r.step[i] = 2 * r.up[i] - 1;
        float a = (1.0f - r.o[i]) * r.inverse[i],
              b = ((float)voxels->grid->size[i] + 1.0f - r.o[i]) * r.inverse[i];
        r.from = lf_max(r.from, lf_min(a, b));
        r.to = lf_min(r.to, lf_max(a, b));
    }
    return r;
}

/* The cell of the ray at Z = z, among 0 .. n - 1 with this side; `first` is the lower face of cell
 * 0. Rounding never leads outside. */
static int cell_at(const ray *r, int axis, float z, int first, int side, int n)
{
    float cell = (r->o[axis] + r->d[axis] * z - (float)first) / (float)side;
    return (int)lf_min(lf_max(cell, 0.0f), (float)(n - 1));
}

/* Where the ray leaves a cell along an axis. */
static float leaves(const ray *r, int axis, int first, int side, int cell)
{
    return ((float)(first + side * (cell + r->up[axis])) - r->o[axis]) * r->inverse[axis];
}

static int first_of(const float next[3])
{
    int axis = next[1] < next[0] ? 1 : 0;
    return next[2] < next[axis] ? 2 : axis;
}

/* Sums of lf_kernels.moments in progress. */
typedef struct moments {
    float scale, distance; /* optical depth of a step through value 1; D */
    float rest, sum[3];
} moments;

static inline void lose(moments *m, float step, float z)
{
    float x = step * m->scale, behind = m->rest / (1.0f + x * (1.0f + 0.5f * x)),
          w = m->rest - behind, y = lf_nearness(m->distance, z);
    m->rest = behind;
    m->sum[0] += w;
    m->sum[1] += w * y;
    m->sum[2] += w * (y * y);
}

/* Walks through the voxels of one brick, up to Z = to. true: it has stopped. lost: NULL, or the
 * moments are summed. */
static inline bool cross_brick(const ray *r, const lf_grid *grid, size_t place, const int brick[3],
                               float to, march *m, moments *lost)
{
    static const int stride[3] = {1, LF_BRICK_VALUES, LF_BRICK_VALUES * LF_BRICK_VALUES};
    float next[3];
    int at[3], first[3];
    for (int i = 0; i < 3; i++) {
        first[i] = LF_BRICK * brick[i];
        at[i] = cell_at(r, i, m->z, first[i], 1, LF_BRICK);
        next[i] = leaves(r, i, first[i], 1, at[i]);
        place += (size_t)(at[i] * stride[i]);
    }
    for (;;) {
        int axis = first_of(next);
        float end = lf_max(lf_min(next[axis], to), m->z), value = lf_grid_stored(grid, place),
              step = value * (end - m->z);
        if (m->depth + step > m->stop) {
            m->z = lf_min(m->z + (m->stop - m->depth) / value, end);
            return true;
        }
        if (lost)
            lose(lost, step, 0.5f * (m->z + end));
        m->depth += step;
        m->z = end;
        at[axis] += r->step[axis];
        if (next[axis] >= to || at[axis] < 0 || at[axis] >= LF_BRICK)
            return false;
        place += (size_t)(ptrdiff_t)(r->step[axis] * stride[axis]);
        next[axis] = leaves(r, axis, first[axis], 1, at[axis]);
    }
}

static inline float cross(const lf_voxels *voxels, float x0, float slope, float z_end, float stop,
                          float *out_z, moments *lost)
{
    const lf_grid *grid = voxels->grid;
    ray r = aim(voxels, x0, slope, z_end);
    march m = {.z = r.from, .stop = stop / voxels->sigma_scale};
    float next[3];
    int brick[3];
    *out_z = z_end;
    if (!(r.from < r.to))
        return 0.0f;
    for (int i = 0; i < 3; i++) {
        brick[i] = cell_at(&r, i, m.z, 0, LF_BRICK, grid->bricks[i]);
        next[i] = leaves(&r, i, 0, LF_BRICK, brick[i]);
    }
    for (;;) {
        int axis = first_of(next);
        float end = lf_max(lf_min(next[axis], r.to), m.z);
        size_t number = grid->index[lf_grid_brick(grid, brick[0], brick[1], brick[2])];
        if (number > 0 && cross_brick(&r, grid, number * LF_BRICK_STRIDE, brick, end, &m, lost)) {
            *out_z = lf_min(m.z, z_end);
            return stop;
        }
        m.z = end;
        brick[axis] += r.step[axis];
        if (next[axis] >= r.to || brick[axis] < 0 || brick[axis] >= grid->bricks[axis])
            return voxels->sigma_scale * m.depth;
        next[axis] = leaves(&r, axis, 0, LF_BRICK, brick[axis]);
    }
}

float lf_voxels_march(const lf_voxels *voxels, float x0, float slope, float z_end, float stop,
                      float *out_z)
{
    return cross(voxels, x0, slope, z_end, stop, out_z, NULL);
}

/* Lanes after the last view repeat it. */
static bool repeats(const float *x0, const float *slope, const float *z_end, int k)
{
    return k > 0 && x0[k] == x0[k - 1] && slope[k] == slope[k - 1] && z_end[k] == z_end[k - 1];
}

void lf_voxels_moments(const lf_voxels *voxels, const lf_feature_rays *rays, float *tau,
                       float *const sums[3])
{
    const float *x0 = rays->x0, *slope = rays->slope, *z_end = rays->z_end;
    moments lost = {.rest = 1.0f};
    float depth = 0.0f, z;
    for (int k = 0; k < rays->n; k++) {
        if (!repeats(x0, slope, z_end, k)) {
            lost = (moments){voxels->sigma_scale * rays->length[k], rays->distance, 1.0f, {0}};
            depth = cross(voxels, x0[k], slope[k], z_end[k], INFINITY, &z, &lost);
        }
        tau[k] += depth;
        for (int i = 0; i < 3; i++)
            sums[i][k] = lost.sum[i];
    }
}

void lf_voxels_depths(const lf_voxels *voxels, int n, const float *x0, const float *slope,
                      const float *z_end, float *tau)
{
    float depth = 0.0f, z;
    for (int k = 0; k < n; k++) {
        if (!repeats(x0, slope, z_end, k))
            depth = lf_voxels_march(voxels, x0[k], slope[k], z_end[k], INFINITY, &z);
        tau[k] += depth;
    }
}

float lf_voxels_density(const lf_voxels *voxels, float x, float z)
{
    float p[3];
    for (int i = 0; i < 3; i++)
        p[i] = voxels->origin[i] + x * voxels->across[i] + z * voxels->depth[i];
    return voxels->sigma_scale * lf_grid_voxel(voxels->grid, p[0], p[1], p[2]);
}
