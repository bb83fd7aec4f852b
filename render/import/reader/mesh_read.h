/* Reading meshes, in quiltimport alone: formats that are read by ourselves, a file each, and the
 * rest through Assimp. One thread. */
#ifndef LF_RENDER_MESH_READ_H
#define LF_RENDER_MESH_READ_H

#include "render/import/reader/soup.h"

/* The mesh file behind fd (the caller's), called desc->file; out as lf_mesh_import fills it but for
 * its files. PLY, STL and OBJ by ourselves, others through Assimp. LF_E_FORMAT, LF_E_NOMEM,
 * LF_E_IO. */
LF_NODISCARD lf_status lf_mesh_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                    lf_error *err);

/* The same of one format into a zeroed soup, which the caller finishes. LF_E_FORMAT: which line or
 * byte, and what was expected. */
typedef lf_status lf_format_read_fn(const lf_mesh_desc *desc, int fd, lf_soup *soup, lf_error *err);

lf_format_read_fn lf_ply_read, lf_stl_read, lf_obj_read;

LF_NODISCARD lf_status lf_assimp_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                      lf_error *err);
/* glTF 2.0, which is JSON, and GLB. */
LF_NODISCARD lf_status lf_gltf_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                    lf_error *err);

#endif
