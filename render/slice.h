/* The plane of one row, resampled: a 2-D array of extinction along which every prefix of the row is tracked; private to
 * render/.
 *
 * A slice is a stack of slabs of equal thickness in Z. The density that a ray X(Z) = x0 + slope Z meets inside slab s is ONE
 * number: sigma_t of all volumes at the slab's middle, sampled at nx points and interpolated linearly between them. Optical
 * depth, collision density and exit transmittance all use this one field, so weights, B and q are exactly consistent with
 * each other; what is left is the stated discretisation of camera segments. A cell is a voxel of the finest volume, or less where
 * that is optically thick (scene_commit.c: slice_cell), but never less than 1/LF_SLICE_MAX_SIDE of all that the rig sees of
 * the volumes: where very different sizes meet, or densities far above a hundred mean free paths across, it is coarse. The
 * slabs' phase is drawn anew in every visit.
 * docs/estimators.md, "Slices". */
#ifndef LF_RENDER_SLICE_H
#define LF_RENDER_SLICE_H

#include "render/rig.h"

#define LF_SLICE_MAX_SIDE 1024

/* Where the volumes lie in camera space: fixed for a scene and rig. */
typedef struct lf_slice_frame {
    bool empty;      /* no volumes in front of the cameras */
    float x_min, dx; /* sample i sits at X = x_min + i dx; samples 0 and nx - 1 are outside of the volumes */
    float z_min, dz;
    int nx, nz; /* nz slabs without the one more that the phase needs */
} lf_slice_frame;

typedef struct lf_slab {
    float x_lo, x_hi; /* X range outside of which this slab is empty; x_lo > x_hi: all of it */
} lf_slab;

typedef struct lf_slice {
    int nx, nz;
    float x_min, inv_dx;
    float z0, dz;    /* slab s covers Z in [z0 + s dz, z0 + (s + 1) dz) */
    int first, last; /* occupied slabs first .. last; first > last: empty */
    float *sigma;    /* [nz][nx + 1] sigma_t per scene unit; [nx] repeats 0 so that sample i + 1 can be read */
    lf_slab *slabs;  /* [nz] */
} lf_slice;

void lf_slice_frame_init(lf_slice_frame *frame, const lf_scene *scene, const lf_rig *rig);

/* Memory for slices of this frame; slice must be zeroed. Release with lf_slice_finish. */
LF_NODISCARD lf_status lf_slice_init(lf_slice *slice, const lf_slice_frame *frame);
void lf_slice_finish(lf_slice *slice);

/* Resamples the volumes on the row's plane; phase in [0,1) moves the slabs. Adds the look-ups made to *lookups. */
void lf_slice_fill(lf_slice *slice, const lf_slice_frame *frame, const lf_scene *scene, const lf_rig *rig,
                   const lf_row_plane *plane, float phase, int64_t *lookups);

/* Walks the ray X(Z) = x0 + slope Z until the optical depth per unit of Z reaches stop or Z reaches z_end; returns the depth
 * reached and in *out_z where. (Multiply by the ray's length per Z outside.) */
float lf_slice_march(const lf_slice *slice, float x0, float slope, float z_end, float stop, float *out_z);

/* Index of the slab that holds z, unclamped. */
static inline int lf_slice_slab(const lf_slice *slice, float z)
{
    return (int)floorf((z - slice->z0) / slice->dz);
}

/* sigma_t of slab s for a ray that is at X in its middle. */
static inline float lf_slice_at(const lf_slice *slice, int s, float x)
{
    float g = (x - slice->x_min) * slice->inv_dx;
    g = lf_min(lf_max(g, 0.0f), (float)(slice->nx - 1));
    int i = (int)g;
    const float *row = slice->sigma + (size_t)s * (size_t)(slice->nx + 1) + i;
    return row[0] + (g - (float)i) * (row[1] - row[0]);
}

#endif
