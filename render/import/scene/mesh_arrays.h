/* Meshes from arrays that a client passed in memory (base/passed.h); private to render/. */
#ifndef LF_RENDER_MESH_ARRAYS_H
#define LF_RENDER_MESH_ARRAYS_H

#include "base/sandbox/import.h"
#include "render/import/scene/mesh_import.h"

/* Reads "arrays" of a mesh: the names of its arrays. Errors go through reader. */
void lf_mesh_arrays_parse(lf_reader *reader, const lf_node *node, lf_mesh_arrays *out);
/* Whether both name the same arrays. */
bool lf_mesh_arrays_alike(const lf_mesh_arrays *a, const lf_mesh_arrays *b);

/* Runs the reader on the arrays of desc, whose other wishes are in request. Checks types and shapes
 * first, and records the arrays in data->files. On LF_OK the caller closes *out. LF_E_FORMAT: an
 * array has another type or shape, is too large or has invalid values; LF_E_IO: one was not passed,
 * also if passed is NULL; errors of lf_import_run. */
LF_NODISCARD lf_status lf_mesh_arrays_run(const lf_mesh_desc *desc, lf_passed *passed,
                                          lf_import_request *request, lf_mesh_data *data,
                                          lf_parcel *out, lf_error *err);

#endif
