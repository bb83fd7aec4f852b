/* A grid whose voxels have edges (interpolation "nearest") on one row's plane, without resampling.
 * Along a ray its extinction is constant from face to face, so optical depths and collisions are
 * exact; private to render/. (docs/developer/estimators.md, "6. Optical depth to all views") */
#ifndef LF_RENDER_VOXELS_H
#define LF_RENDER_VOXELS_H

#include "render/plane/rig.h"

typedef struct lf_voxels {
    const lf_grid *grid;
    float sigma_scale;
    /* as in lf_body; a voxel is the cube of side 1 around its integer coordinates */
    float origin[3], across[3], depth[3];
} lf_voxels;

/* Cuts the grid with the row's plane; the volume must outlive *voxels. Returns false if the plane
 * misses it. */
bool lf_voxels_cut(lf_voxels *voxels, const lf_volume *volume, const lf_rig *rig,
                   const lf_row_plane *plane);

/* As lf_slice_march: from brick to brick, and from voxel to voxel in bricks that are not empty
 * (Amanatides and Woo 1987). A ray along a face is in one of the two voxels. */
float lf_voxels_march(const lf_voxels *voxels, float x0, float slope, float z_end, float stop,
                      float *out_z);

/* Adds to tau[n] the optical depths per unit of Z of n rays up to z_end. */
void lf_voxels_depths(const lf_voxels *voxels, int n, const float *x0, const float *slope,
                      const float *z_end, float *tau);

/* lf_voxels_depths with the sums of lf_kernels.moments. */
void lf_voxels_moments(const lf_voxels *voxels, const lf_feature_rays *rays, float *tau,
                       float *const sums[3]);

/* sigma_t at the point (x, z) of the row's plane: the same for every ray through it. */
float lf_voxels_density(const lf_voxels *voxels, float x, float z);

#endif
