/* Warns of the grids of a volume's file that no volume is made of, and, while the shutter is open,
 * of velocities that none moves by, and of voxels that no density is; private to render/. */
#ifndef LF_RENDER_UNUSED_GRIDS_H
#define LF_RENDER_UNUSED_GRIDS_H

#include "render/import/scene/scene_parse.h"

/* grid: one of that file, which knows the names of the others. */
void lf_warn_of_unused_grids(lf_warnings *warnings, const lf_scene_desc *desc, const lf_grid *grid,
                             const char *file);

/* Warns of voxels that the file says and that count as 0. names: the grid's, each on its line. */
void lf_warn_of_odd_voxels(lf_warnings *warnings, const lf_grid *grid, const char *names,
                           const char *file);

#endif
