/* Cameras of a glTF file (specification, section 3.10). One thread. */
#ifndef LF_RENDER_GLTF_CAMERA_H
#define LF_RENDER_GLTF_CAMERA_H

#include "render/import/reader/gltf_node.h"
#include "render/import/scene/mesh_import.h"

/* Stores the cameras of visible nodes, in the order of the nodes, in zeroed out->cameras.open, as
 * far as there is room. They look along -z of their node, whose +y is up. Their aspect and clipping
 * planes are ignored. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_cameras(const lf_gltf *gltf, const lf_gltf_nodes *nodes,
                                       lf_mesh_data *out, lf_error *err);

#endif
