/* Pictures that materials of the scene file name; private to render/. */
#ifndef LF_RENDER_SCENE_PICTURES_H
#define LF_RENDER_SCENE_PICTURES_H

#include "base/file.h"
#include "render/import/scene/scene_parse.h"

/* Has the pictures of a material's slot (picture[2], of which one at least has a file) read by a
 * reader process, puts them together as the slot has them and makes them ready to be looked up.
 * What was made of the same files for scene, which is being made, or for previous (may be NULL) is
 * shared. On LF_OK the caller owns a reference. On failure *out_part is the one that is to blame.
 * LF_E_IO, LF_E_PATH, LF_E_FORMAT, LF_E_NOMEM, and what lf_import_run gives. */
LF_NODISCARD lf_status lf_scene_picture_load(const lf_picture_desc picture[2],
                                             const lf_material *material, lf_slot slot,
                                             const lf_roots *roots, const lf_scene *scene,
                                             const lf_scene *previous, lf_scene_picture **out,
                                             int *out_part, lf_error *err);

#endif
