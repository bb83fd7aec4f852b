/* Automatic positions that depend on the scene: grounds, and a camera with "fit"; private to
 * render/. They are computed once, when the document is loaded or patched, and then stored in the
 * document. */
#ifndef LF_RENDER_PLACING_H
#define LF_RENDER_PLACING_H

#include "render/import/scene/mesh_import.h"

/* Moves the shapes of data (of desc's meshes) that are grounds without a position, and enlarges
 * them. They go below all other meshes and the box `beside`, which may be empty, and a little lower
 * if a model has a floor at its lowest point, which then hides the ground. key, of
 * lf_geometry_key, becomes the key of the document with these positions.
 *
 * *out_patch is the patch (RFC 7396) from this document to that one, a new reference; NULL: no such
 * grounds. false: out of memory. */
bool lf_place_grounds(const lf_scene_desc *desc, const double beside[2][3], lf_mesh_data *data,
                      json_t *key, json_t **out_patch);

/* Whether the scene's document has automatic positions. */
bool lf_scene_is_unplaced(const lf_scene *scene);
/* The patch that replaces them by numbers. Errors go through reader. A new reference, or NULL. */
json_t *lf_scene_placing(lf_reader *reader, const lf_scene *scene);

#endif
