/* Reading meshes, in quiltimport alone; private to render/reader. */
#ifndef LF_RENDER_READER_H
#define LF_RENDER_READER_H

#include "base/reader/reader.h"
#include "render/load/mesh_import.h"

typedef struct lf_named_file {
    char *name;
    int fd;
} lf_named_file;

/* A mesh's file, the first, and those that it has named and that were opened. */
typedef struct lf_mesh_reading {
    int n_files;
    lf_named_file files[LF_MESH_MAX_FILES];
} lf_mesh_reading;

/* The mesh file behind fd (the caller's), called desc->file; out as lf_mesh_import fills it but for
 * its files. PLY, STL and OBJ by ourselves (formats.h), others through Assimp. LF_E_FORMAT,
 * LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_mesh_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                    lf_error *err);
LF_NODISCARD lf_status lf_assimp_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out,
                                      lf_error *err);

#endif
