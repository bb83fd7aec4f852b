/* Lights of a glTF file (KHR_lights_punctual). One thread. */
#ifndef LF_RENDER_GLTF_PUNCTUAL_H
#define LF_RENDER_GLTF_PUNCTUAL_H

#include "render/import/reader/gltf_node.h"
#include "render/import/scene/mesh_import.h"

/* Stores the lights of visible nodes in zeroed out->lights.open, as far as there is room (a warning
 * reports the others). A light is at its node, along the node's -z, with the file's intensity
 * whatever the node's scale. Their range is ignored. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_lights(const lf_gltf *gltf, const lf_gltf_nodes *nodes,
                                      lf_mesh_data *out, lf_error *err);

#endif
