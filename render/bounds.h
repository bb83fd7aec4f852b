/* The boxes of what is in a scene, and which of its meshes are grounds; private to render/. */
#ifndef LF_RENDER_BOUNDS_H
#define LF_RENDER_BOUNDS_H

#include "render/scene/scene.h"

/* Things are numbered: volumes in the document's order, then meshes; lights that are faces come
 * last. */
int lf_scene_things(const lf_scene *scene);
/* The box of a thing, of a volume with what it emits, seen from the scene's origin; false: empty
 * volumes and meshes that the camera does not see have none. */
bool lf_thing_box(const lf_scene *scene, int thing, lf_box *out);

/* Which things a fit leaves out (docs/reference/scene-format.md, "Framing"): out[lf_scene_things].
 * Whether there are any. */
bool lf_find_grounds(const lf_scene *scene, bool *out);

/* A box as numbers, and the axis along which it is thinnest. */
int lf_box_sides(const lf_box *box, double out[3]);

#endif
