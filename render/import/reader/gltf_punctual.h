/* Lights of a glTF file (KHR_lights_punctual). One thread. */
#ifndef LF_RENDER_GLTF_PUNCTUAL_H
#define LF_RENDER_GLTF_PUNCTUAL_H

#include "render/import/reader/gltf_node.h"
#include "render/import/scene/mesh_import.h"

/* Those of nodes that are shown, into zeroed out->lights.open, as far as there is room (a warning
 * tells of the others): where their node stands, along its -z, as strong as the file says whatever
 * the node's scale. What they say of a range is no matter of light. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_lights(const lf_gltf *gltf, const lf_gltf_nodes *nodes,
                                      lf_mesh_data *out, lf_error *err);

#endif
