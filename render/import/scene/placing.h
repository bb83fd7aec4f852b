/* What a scene leaves to be placed by what is in it: grounds, and a camera with "fit"; private to
 * render/. It is placed once, when the document is loaded or patched, and the document then holds
 * the numbers. */
#ifndef LF_RENDER_PLACING_H
#define LF_RENDER_PLACING_H

#include "render/import/scene/mesh_import.h"

/* Moves the shapes of data (of desc's meshes) that are grounds without a place beneath all others
 * and the box `beside`, which may hold nothing, and makes them large. key, of lf_geometry_key,
 * becomes that of a document which says so. *out_patch: the patch (RFC 7396) that makes it of this
 * one, a new reference; NULL: there are no such grounds. false: out of memory. */
bool lf_place_grounds(const lf_scene_desc *desc, const double beside[2][3], lf_mesh_data *data,
                      json_t *key, json_t **out_patch);

/* Whether the scene's document leaves anything to be placed. */
bool lf_scene_is_unplaced(const lf_scene *scene);
/* The patch after which it does not. Errors go through reader. A new reference, or NULL. */
json_t *lf_scene_placing(lf_reader *reader, const lf_scene *scene);

#endif
