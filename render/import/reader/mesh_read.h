/* Reading meshes, only in quiltimport: one file for each format that we read ourselves, and Assimp
 * for the others. One thread. */
#ifndef LF_RENDER_MESH_READ_H
#define LF_RENDER_MESH_READ_H

#include "render/import/reader/soup.h"

/* Reads the mesh file behind fd (owned by the caller), named desc->file. Fills out as
 * lf_mesh_import does, except its files. PLY, STL, OBJ and glTF by our readers, others through
 * Assimp. LF_E_FORMAT, LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_mesh_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                    lf_error *err);

/* Reads one format into a zeroed soup, which the caller finishes. LF_E_FORMAT: names the line or
 * byte, and what was expected. */
typedef lf_status lf_format_read_fn(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err);

lf_format_read_fn lf_ply_read, lf_stl_read, lf_obj_read;
/* Arrays instead of a file: fd has the positions, and the asker gives the others (import.h). */
lf_format_read_fn lf_arrays_read;

LF_NODISCARD lf_status lf_assimp_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                      lf_error *err);
/* glTF 2.0, which is JSON, and GLB. */
LF_NODISCARD lf_status lf_gltf_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                    lf_error *err);

#endif
