/* Taking over a mesh from a reader process, which is not trusted: everything is checked. */
#ifndef LF_RENDER_MESH_TAKE_H
#define LF_RENDER_MESH_TAKE_H

#include "base/sandbox/parcel.h"
#include "render/import/scene/mesh_import.h"

/* What was requested besides the mesh itself: the file's own materials with their vertex data, and
 * texture coordinates for other materials. */
typedef struct lf_mesh_asked {
    bool materials, uvs;
} lf_mesh_asked;

/* Copies a parcel's mesh into zeroed *out, as lf_mesh_import promises it. Release with
 * lf_mesh_data_finish, also after a failure. LF_E_FORMAT: sections are inconsistent, or contain
 * invalid values; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_take(const lf_parcel *parcel, lf_mesh_asked asked, lf_mesh_data *out,
                                    lf_error *err);

/* Copies only the images, into out->pictures; errors as above. */
LF_NODISCARD lf_status lf_mesh_take_pictures(const lf_parcel *parcel, lf_mesh_data *out,
                                             lf_error *err);

#endif
