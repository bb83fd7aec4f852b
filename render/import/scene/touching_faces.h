/* Finds faces of glass that lie in faces of other glass; private to render/. */
#ifndef LF_RENDER_TOUCHING_FACES_H
#define LF_RENDER_TOUCHING_FACES_H

#include "render/scene/scene.h"

/* Sets looks.touching: triangles of different solids (looks.solids) that share their plane, as
 * closely as rays resolve it, and may share a point. Meshes in many places, and those that move,
 * are left out, and all, with a warning, where there are too many. false: no memory. */
bool lf_touching_find(lf_scene *scene);

#endif
