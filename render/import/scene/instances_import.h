/* Where the instances of a mesh stand; private to render/. */
#ifndef LF_RENDER_INSTANCES_IMPORT_H
#define LF_RENDER_INSTANCES_IMPORT_H

#include "render/import/scene/mesh_import.h"

/* Of one mesh, with every place: what Embree and sections can hold. */
#define LF_MAX_INSTANCES 20000000

/* Whether what lies in a box of its own may stand at a place: the map, which is kept in single
 * precision, does not flatten space, and the box is there within LF_MAX_REACH. */
bool lf_instance_is_sound(const lf_affine *place, const double own[2][3]);

/* Whether all that data holds, which is read, may stand where it does: LF_E_FORMAT, where names it
 * in the error. */
LF_NODISCARD lf_status lf_instances_check(const lf_mesh_data *data, const char *where,
                                          lf_error *err);

/* The places of a parcel, which is checked as if an enemy had written it, behind those that data
 * has. path names it in errors: LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_instances_take(const lf_parcel *parcel, const char *path,
                                         lf_mesh_data *data, lf_error *err);

/* A file of places, read for the first mesh that stands there and kept for others. Zeroed: not
 * read yet. */
typedef struct lf_instances_file {
    lf_parcel parcel;
    lf_mesh_file noted; /* its path is the struct's own; NULL: not read */
} lf_instances_file;

/* Gives data, which is read, the places of desc, from the scene itself or from a file that
 * quiltimport reads (import/reader/places_read.h), noted in data->files. file is that of meshes
 * whose places are in the same file, or zeroed; lf_instances_file_close releases it in any case.
 * emits: some material of the mesh shines: it is written out as copies then (mesh_repeat.h). Errors
 * as of lf_mesh_import, and LF_E_NOMEM for more copies than are possible; they name the mesh's file
 * or its places'. */
LF_NODISCARD lf_status lf_instances_import(const lf_mesh_desc *desc, const char *folder,
                                           const lf_roots *roots, bool emits,
                                           lf_instances_file *file, lf_mesh_data *data,
                                           lf_error *err);
void lf_instances_file_close(lf_instances_file *file);

#endif
