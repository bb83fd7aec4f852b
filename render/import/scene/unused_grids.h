/* Warns of unused grids of a volume's file and of invalid voxels; while the shutter is open also of
 * unused velocities; private to render/. */
#ifndef LF_RENDER_UNUSED_GRIDS_H
#define LF_RENDER_UNUSED_GRIDS_H

#include "render/import/scene/scene_parse.h"

/* grid: one of that file, which stores the names of the others. */
void lf_warn_of_unused_grids(lf_warnings *warnings, const lf_scene_desc *desc, const lf_grid *grid,
                             const char *file);

/* Warns of voxels whose value in the file is invalid and counts as 0. names: the grid's names, one
 * per line. */
void lf_warn_of_odd_voxels(lf_warnings *warnings, const lf_grid *grid, const char *names,
                           const char *file);

#endif
