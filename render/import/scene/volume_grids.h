/* The grids of volumes: shared with existing scenes, or read, and advected by velocities while the
 * shutter is open; private to render/. */
#ifndef LF_RENDER_VOLUME_GRIDS_H
#define LF_RENDER_VOLUME_GRIDS_H

#include "render/import/scene/scene_parse.h"

/* Source of the grids. Zeroed except the first four members. */
typedef struct lf_grid_source {
    const lf_scene_desc *desc;
    const lf_roots *roots;
    const lf_scene *scene, *previous; /* the scene being made; previous may be NULL */
    char *of; /* file and names of these velocities; NULL: none were read yet */
    lf_grid *velocity[3];
} lf_grid_source;
void lf_grid_source_finish(lf_grid_source *source);

/* Whether velocities affect a volume's grids. */
bool lf_volume_flows(const lf_scene_desc *desc, const lf_volume_desc *volume);
/* Their factors at shutter open and close: seconds or frames. */
void lf_volume_flow_times(const lf_scene_desc *desc, const lf_volume_desc *volume, double out[2]);

/* Loads one grid of a volume's file at path, or the sum of several (lf_vdb_import_sum): sets
 * out->grid, and out->steps if it is advected. *out_key: the key of the volume that an error is
 * about. */
LF_NODISCARD lf_status lf_volume_grid_load(lf_grid_source *source, const lf_volume_desc *volume,
                                           const char *path, const char *names, lf_volume *out,
                                           const char **out_key, lf_error *err);

/* Loads an array of a volume: sets out->grid. size: its voxels along x, y and z; 0 for any number.
 * LF_E_FORMAT: it has another shape, or values that a grid cannot have. */
LF_NODISCARD lf_status lf_volume_array_load(lf_grid_source *source, const lf_volume_desc *volume,
                                            const char *name, const int64_t size[3], lf_volume *out,
                                            lf_error *err);

/* The largest value of its grid at any time; 0 without a grid. */
float lf_volume_largest(const lf_volume *volume);

#endif
