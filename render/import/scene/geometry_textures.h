/* The pictures of all mesh files made ready to be looked up; private to render/. */
#ifndef LF_RENDER_GEOMETRY_TEXTURES_H
#define LF_RENDER_GEOMETRY_TEXTURES_H

#include "render/import/scene/mesh_import.h"

/* Takes the pictures of data[n] over into the geometry, whose materials are theirs in their order,
 * makes pyramids of those that are used and gives materials their textures. LF_E_NOMEM; what was
 * taken over is then the geometry's all the same. */
LF_NODISCARD lf_status lf_geometry_take_textures(lf_geometry *geometry, lf_mesh_data *data, int n);

/* What a material's picture is looked up for; *out_threshold as lf_pyramid_make has it. */
lf_texels_use lf_slot_use(const lf_material *m, int slot, float *out_threshold);

#endif
