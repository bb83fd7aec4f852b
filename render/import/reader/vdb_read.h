/* Reading one grid of an OpenVDB file; private to render/import/reader. The C interface of its one
 * C++ file: no exception and no OpenVDB type crosses it. */
#ifndef LF_RENDER_VDB_READ_H
#define LF_RENDER_VDB_READ_H

#include "render/scene/grid.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LF_VDB_NAMES_BYTES 4096 /* for the list of a file's grid names */
#define LF_READER_NOMEM "takes more memory than a reader may have (--import-memory)"

/* lf_vdb_import (vdb_import.h) from fd, which stays the caller's; for velocities
 * lf_vdb_import_velocity, one component. The grid is filled but not finished. Call lf_vdb_begin
 * before lf_confine. */
void lf_vdb_begin(void);
LF_NODISCARD lf_status lf_vdb_read(int fd, const char *name, bool is_velocity, lf_grid **out_grid,
                                   lf_error *err);
/* The names of the grids of floats, halves and doubles, each followed by a newline; at most `size`
 * bytes including the terminator, whole names only. Errors as of lf_vdb_read. */
LF_NODISCARD lf_status lf_vdb_list(int fd, char *out, size_t size, lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
