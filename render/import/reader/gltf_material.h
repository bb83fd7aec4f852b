/* Materials of glTF (specification, section 3.9, and Khronos' extensions) as source materials. One
 * thread. */
#ifndef LF_RENDER_GLTF_MATERIAL_H
#define LF_RENDER_GLTF_MATERIAL_H

#include "render/import/reader/gltf_file.h"
#include "render/import/reader/source_material.h"

/* materials[number]; scale: scene units per unit of the file. In texture slots, `picture` is 1 +
 * the number of an image of the file until lf_gltf_pictures. name NULL: no memory. */
lf_source_material lf_gltf_source_material(const lf_gltf *gltf, uint32_t number, float scale);
/* Called after the images are loaded: an unlit material emits its colour, times the vertex colours
 * if there are any (coloured). */
void lf_gltf_unlight(const lf_gltf *gltf, uint32_t number, bool coloured,
                     lf_source_material *source);

/* The texture that an object names by a key, or none. If it cannot be read, the result is also
 * none, and *out_why is the reason. */
lf_texture lf_gltf_texture(const lf_gltf *gltf, const json_t *object, const char *key,
                           lf_lost *out_why);

/* Decodes the images of used materials, once each, into out->pictures. An image that cannot be
 * decoded is a warning; then only the material's colours count, and an emission texture emits
 * nothing. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_pictures(lf_gltf *gltf, lf_source_material *source, size_t n,
                                        const bool *used, lf_mesh_data *out, lf_error *err);

#endif
