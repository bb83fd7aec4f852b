/* Materials of glTF (specification, section 3.9, and Khronos' extensions) as what a file says.
 * One thread. */
#ifndef LF_RENDER_GLTF_MATERIAL_H
#define LF_RENDER_GLTF_MATERIAL_H

#include "render/import/reader/gltf_file.h"
#include "render/import/reader/source_material.h"

/* materials[number]; scale: scene units in one of the file's. In textures' slots, `picture` is 1 +
 * the number of an image of the file until lf_gltf_pictures. NULL in name: no memory. */
lf_source_material lf_gltf_source_material(const lf_gltf *gltf, uint32_t number, float scale);
/* Once its pictures are there: what is unlit emits its colour, times those of vertices where they
 * have some (coloured). */
void lf_gltf_unlight(const lf_gltf *gltf, uint32_t number, bool coloured,
                     lf_source_material *source);

/* A texture that an object names by a key, or none: also where it is of no kind that can be read,
 * and *out_why says then what is lost. */
lf_texture lf_gltf_texture(const lf_gltf *gltf, const json_t *object, const char *key,
                           lf_lost *out_why);

/* Decodes the images that materials in use name, once each, into out->pictures. One that cannot be
 * decoded is a warning, and the colours beside it count alone (what glows by it does not).
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_pictures(lf_gltf *gltf, lf_source_material *source, size_t n,
                                        const bool *used, lf_mesh_data *out, lf_error *err);

#endif
