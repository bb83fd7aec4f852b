/* What a reader says a mesh is, taken over by whoever asked: checked as if an enemy had made it. */
#ifndef LF_RENDER_MESH_TAKE_H
#define LF_RENDER_MESH_TAKE_H

#include "base/sandbox/parcel.h"
#include "render/import/scene/mesh_import.h"

/* What was asked for besides the mesh itself: the file's own materials and what they look at, and
 * texture coordinates for others. */
typedef struct lf_mesh_asked {
    bool materials, uvs;
} lf_mesh_asked;

/* Copies a parcel's mesh into zeroed *out, as lf_mesh_import promises it. Release with
 * lf_mesh_data_finish in any case. LF_E_FORMAT: sections do not fit together, or hold what there is
 * not; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_take(const lf_parcel *parcel, lf_mesh_asked asked, lf_mesh_data *out,
                                    lf_error *err);

/* The pictures alone, into out->pictures; errors as above. */
LF_NODISCARD lf_status lf_mesh_take_pictures(const lf_parcel *parcel, lf_mesh_data *out,
                                             lf_error *err);

#endif
