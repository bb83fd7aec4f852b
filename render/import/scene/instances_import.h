/* Importing the instances of a mesh; private to render/. */
#ifndef LF_RENDER_INSTANCES_IMPORT_H
#define LF_RENDER_INSTANCES_IMPORT_H

#include "render/import/scene/mesh_import.h"

/* Per mesh: the limit of Embree and of sections. */
#define LF_MAX_INSTANCES 20000000

/* Whether an object with this box may have an instance with this transform: the map, in single
 * precision, is not singular, and the transformed box lies within LF_MAX_REACH. */
bool lf_instance_is_sound(const lf_affine *place, const double own[2][3]);

/* Checks all instances of data, which has been read: LF_E_FORMAT; the error uses `where` as the
 * name. */
LF_NODISCARD lf_status lf_instances_check(const lf_mesh_data *data, const char *where,
                                          lf_error *err);

/* Appends the instances of a parcel to data. The parcel is not trusted and fully checked. Errors
 * name path: LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_instances_take(const lf_parcel *parcel, const char *path,
                                         lf_mesh_data *data, lf_error *err);

/* A file of instances, read for the first mesh that uses it and kept for others. Zeroed: not read
 * yet. */
typedef struct lf_instances_file {
    lf_parcel parcel;
    lf_mesh_file noted; /* its path is owned by the struct; NULL: not read */
} lf_instances_file;

/* Gives data, which has been read, the instances of desc. They come from the scene itself, or from
 * a file that quiltimport reads (import/reader/instances_read.h) and that is recorded in
 * data->files.
 *
 * file: shared by meshes with the same instance file, or zeroed; release it with
 * lf_instances_file_close, also after a failure. emits: a material of the mesh emits; its instances
 * are then copied (mesh_repeat.h). Errors as of lf_mesh_import, and LF_E_NOMEM for too many copies.
 * They name the mesh's file or the instance file. */
LF_NODISCARD lf_status lf_instances_import(const lf_mesh_desc *desc, const char *folder,
                                           const lf_roots *roots, bool emits,
                                           lf_instances_file *file, lf_mesh_data *data,
                                           lf_error *err);
void lf_instances_file_close(lf_instances_file *file);

#endif
