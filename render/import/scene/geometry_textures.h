/* Prepares the images of all mesh files for look-ups; private to render/. */
#ifndef LF_RENDER_GEOMETRY_TEXTURES_H
#define LF_RENDER_GEOMETRY_TEXTURES_H

#include "render/import/scene/mesh_import.h"

/* Moves the images of data[n] into the geometry, whose materials are theirs in the same order.
 * Makes mip levels of used images and gives materials their textures. LF_E_NOMEM; the geometry owns
 * the moved images also after a failure. */
LF_NODISCARD lf_status lf_geometry_take_textures(lf_geometry *geometry, lf_mesh_data *data, int n);

/* The use of a material's image; *out_threshold as in lf_pyramid_make. */
lf_texels_use lf_slot_use(const lf_material *m, int slot, float *out_threshold);

#endif
