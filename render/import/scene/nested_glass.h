/* Finds the solids of glass that stand in each other (transport/path/nest.h); private to render/.
 */
#ifndef LF_RENDER_NESTED_GLASS_H
#define LF_RENDER_NESTED_GLASS_H

#include "render/import/scene/scene_parse.h"

/* Sets looks.nested and looks.solids where the boxes of two solids of glass overlap or touch: a
 * solid is what the triangles of a mesh that share a material enclose, or, where these are open,
 * those of all its glass together. One that is inside out is a hollow in the smallest other one of
 * its material about it. Warns of what encloses nothing: its faces part glass from air as they
 * would alone. To be called after lf_scene_look. false: no memory. */
bool lf_nest_glass(lf_scene *scene, const lf_scene_desc *desc, lf_warnings *warnings);

#endif
