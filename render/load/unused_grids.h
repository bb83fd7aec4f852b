/* Warns of the grids of a volume's file that no volume is made of, and, while the shutter is open,
 * of velocities that none moves by; private to render/. */
#ifndef LF_RENDER_UNUSED_GRIDS_H
#define LF_RENDER_UNUSED_GRIDS_H

#include "render/load/scene_parse.h"

/* grid: one of that file, which knows the names of the others. */
void lf_warn_of_unused_grids(lf_warnings *warnings, const lf_scene_desc *desc, const lf_grid *grid,
                             const char *file);

#endif
