/* Bounding boxes of the objects in a scene, and which meshes are grounds; private to render/. */
#ifndef LF_RENDER_BOUNDS_H
#define LF_RENDER_BOUNDS_H

#include "render/scene/scene.h"

/* Number of objects. They are numbered in this order: volumes in document order, meshes, area
 * lights. */
int lf_scene_things(const lf_scene *scene);
/* The box of an object in world axes, relative to the scene's origin. The box of a volume includes
 * its emission. false: the object has no box (empty volumes, meshes that the camera does not see).
 */
bool lf_thing_box(const lf_scene *scene, int thing, lf_box *out);

/* Sets out[lf_scene_things] to the objects that a fit excludes as grounds
 * (docs/reference/scene-format.md, "Framing"). Returns whether there are any. */
bool lf_find_grounds(const lf_scene *scene, bool *out);

/* Sets out to the sides of a box. Returns the axis along which the box is thinnest. */
int lf_box_sides(const lf_box *box, double out[3]);

#endif
