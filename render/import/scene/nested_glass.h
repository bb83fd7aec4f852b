/* Finds glass solids inside each other (transport/path/nest.h); private to render/. */
#ifndef LF_RENDER_NESTED_GLASS_H
#define LF_RENDER_NESTED_GLASS_H

#include "render/import/scene/scene_parse.h"

/* Sets LF_TRAIT_NESTED_GLASS and nested.solids if the boxes of two glass solids overlap or touch. A
 * solid is enclosed by the triangles of a mesh with one material or, if these are not closed, by
 * all glass triangles of the mesh together. A solid that is inside out is a cavity in the smallest
 * other solid of its material around it. Warns of glass that encloses nothing; its faces are
 * boundaries between glass and air, as without nesting. Call it after lf_scene_find_traits. false:
 * no memory. */
bool lf_nest_glass(lf_scene *scene, const lf_scene_desc *desc, lf_warnings *warnings);

#endif
