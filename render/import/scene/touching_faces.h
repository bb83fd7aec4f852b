/* Finds coplanar faces of different glass; private to render/. */
#ifndef LF_RENDER_TOUCHING_FACES_H
#define LF_RENDER_TOUCHING_FACES_H

#include "render/scene/scene.h"

/* Sets nested.touching: triangles of different solids (nested.solids) that are coplanar within the
 * precision of rays and may share a point. Instanced and moving meshes are excluded. If there are
 * too many, all are dropped with a warning. false: no memory. */
bool lf_touching_find(lf_scene *scene);

#endif
