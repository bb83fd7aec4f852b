/* The plane of one row, resampled from one grid: a 2-D array of extinction, in which every prefix
 * of the row is tracked; private to render/.
 *
 * A slice is a stack of planes, dz apart in Z. Each plane has samples dx apart in X and is linear
 * between them. A ray X(Z) = x0 + slope Z has sigma_t of the planes where it crosses them; between
 * planes sigma_t is linear ALONG THE RAY. Optical depth (a quadratic in each step), collision
 * density and transmittance of unscattered light all use this one field. Pivots are drawn from it,
 * and correction.h makes them count for the grid itself. So the slice must be above 0 wherever the
 * grid is: samples next to a nonzero one get a small value. A cell is at most a voxel, unless the
 * rays' extent is longer than LF_SLICE_MAX_SIDE - 4 voxels; then it is that fraction of the extent.
 * Every visit draws new phases of planes and samples. docs/developer/estimators/grids.md, "Cells of
 * a slice". */
#ifndef LF_RENDER_SLICE_H
#define LF_RENDER_SLICE_H

#include "render/plane/rig.h"
#include "render/scene/look_up.h"

#define LF_SLICE_MAX_SIDE 2048
/* Readable samples after a plane's last: kernels load 32 from any sample on. */
#define LF_SLICE_PADDING 32
/* Maximum number of tiles along a side of a slice; each tile has an error estimate. */
#define LF_SLICE_TILES 32

/* Position of a grid in camera space; constant for a scene and rig. */
typedef struct lf_slice_frame {
    /* sample i is at X = x_min + (i - phase) dx; samples 0 and nx - 1 are outside the grid */
    float x_min, dx;
    float z_min, dz;
    int nx, nz;
} lf_slice_frame;

struct lf_kernels;

typedef struct lf_plane_span {
    /* X range outside of which the plane is empty; x_lo > x_hi: the plane is empty */
    float x_lo, x_hi;
} lf_plane_span;

typedef struct lf_samples {
    int first, last; /* first > last: none */
} lf_samples;

typedef struct lf_slice {
    int nx, nz, stride; /* stride = nx + LF_SLICE_PADDING */
    float x_min, inv_dx;
    /* plane s is at Z = z0 + s dz; its weight falls linearly to 0 at its neighbours */
    float z0, dz, inv_dz;
    int first, last; /* occupied planes first .. last; first > last: empty */
    float *sigma;    /* [nz][stride] sigma_t per scene unit; 0 from nx on */
    /* [nz] fraction of a plane's hat behind the cameras, Z < 0: 0 unless they are inside */
    float *behind;
    lf_plane_span *spans; /* [nz] */
    lf_samples *filled;   /* [nz] during lf_slice_fill: range of nonzero samples */
    /* Cell (c, i) lies between planes c - 1 and c and between samples i and i + 1. tile_cells_*:
     * cells per tile. */
    int tile_cells_x, tile_cells_z, tiles_x, tiles_z;
    /* [tiles_z][tiles_x] approximate root mean square difference between slice and grid, per scene
     * unit; above 0 wherever they differ */
    float *rough;
    float *roughest; /* [tiles_z] the largest of a row of tiles */
    float *near;     /* [tiles_z][tiles_x] during lf_slice_fill: largest sigma_t near a tile */
} lf_slice;

/* false: the rig's rays do not meet the volume (a grid). rigs[n]: one rig, or the rig at n shutter
 * times, evenly from opening to close. */
bool lf_slice_frame_init(lf_slice_frame *frame, const lf_volume *volume, const lf_rig *rigs, int n);

/* The row's plane at Z = z in a volume's space, along X. */
lf_line lf_slice_line(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane,
                      float z);

/* Memory for slices of this frame; slice must be zeroed. Release with lf_slice_finish, also after a
 * failure. */
LF_NODISCARD lf_status lf_slice_init(lf_slice *slice, const lf_slice_frame *frame);
void lf_slice_finish(lf_slice *slice);

/* Resamples the grid on the row's plane; phase[2] in [0,1) offsets samples and planes. Returns the
 * number of look-ups. */
int64_t lf_slice_fill(lf_slice *slice, const lf_slice_frame *frame, const lf_volume *volume,
                      const lf_rig *rig, const lf_row_plane *plane, const float phase[2],
                      const struct lf_kernels *kernels);

/* Walks the ray X(Z) = x0 + slope Z until the optical depth per unit of Z reaches stop or Z reaches
 * z_end. Returns the depth reached and in *out_z the position. (The caller multiplies by the ray's
 * length per Z.) */
float lf_slice_march(const lf_slice *slice, float x0, float slope, float z_end, float stop,
                     float *out_z);

/* sigma_t of plane s for a ray that crosses it at X. */
static inline float lf_slice_at(const lf_slice *slice, int s, float x)
{
    float g = (x - slice->x_min) * slice->inv_dx;
    g = lf_min(lf_max(g, 0.0f), (float)(slice->nx - 1));
    int i = (int)g;
    const float *row = slice->sigma + (size_t)s * (size_t)slice->stride + i;
    return row[0] + (g - (float)i) * (row[1] - row[0]);
}

/* The plane at or before Z = z, and in *out_t the position of z between it and the next (0..1). */
static inline int lf_slice_plane(const lf_slice *slice, float z, float *out_t)
{
    float g = (z - slice->z0) * slice->inv_dz, s = floorf(g);
    *out_t = g - s;
    return (int)s;
}

/* sigma_t along the ray X(Z) = x0 + slope Z at Z = z: the value that marches use, except for
 * rounding. */
static inline float lf_slice_density(const lf_slice *slice, float x0, float slope, float z)
{
    float t, density = 0.0f;
    int s = lf_slice_plane(slice, z, &t);
    if (s >= 0 && s < slice->nz)
        density =
            (1.0f - t) * lf_slice_at(slice, s, x0 + slope * (slice->z0 + (float)s * slice->dz));
    if (s + 1 >= 0 && s + 1 < slice->nz)
        density +=
            t * lf_slice_at(slice, s + 1, x0 + slope * (slice->z0 + (float)(s + 1) * slice->dz));
    return density;
}

/* The fraction of a plane's hat that lies before t steps behind the plane, in units of dz: 0 at t =
 * -1, 1 at t = 1. */
static inline float lf_slice_share(float t)
{
    float rest = 1.0f - fabsf(t), tail = 0.5f * rest * rest;
    return t < 0.0f ? tail : 1.0f - tail;
}

#endif
