/* Images of the scene file's materials; private to render/. */
#ifndef LF_RENDER_SCENE_PICTURES_H
#define LF_RENDER_SCENE_PICTURES_H

#include "base/file.h"
#include "render/import/scene/scene_parse.h"

/* Loads the images of a material's slot (picture[2], at least one with a file) through a reader
 * process, combines them for the slot and prepares them for look-ups. Shares with scene, which is
 * being made, or with previous (may be NULL) what was made of the same files. On LF_OK the caller
 * owns a reference. On failure *out_part is the image that failed. LF_E_IO, LF_E_PATH, LF_E_FORMAT,
 * LF_E_NOMEM, and errors of lf_import_run. */
LF_NODISCARD lf_status lf_scene_picture_load(const lf_picture_desc picture[2],
                                             const lf_material *material, lf_slot slot,
                                             const lf_roots *roots, const lf_scene *scene,
                                             const lf_scene *previous, lf_scene_picture **out,
                                             int *out_part, lf_error *err);

#endif
