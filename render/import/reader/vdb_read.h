/* Reading one grid of an OpenVDB file; private to render/import/reader. C face of its one C++ file:
 * no exception and no OpenVDB type comes out of it. */
#ifndef LF_RENDER_VDB_READ_H
#define LF_RENDER_VDB_READ_H

#include "render/scene/grid.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LF_VDB_NAMES_BYTES 4096 /* of all grids of a file that are listed */
#define LF_READER_NOMEM "needs more memory than file readers may use; raise --import-memory"

/* As lf_vdb_import (vdb_import.h) says, or of velocities as lf_vdb_import_velocity does of each,
 * from fd, which stays the caller's; the grid is filled but not finished. Before lf_confine the
 * library has to be begun. */
void lf_vdb_begin(void);
LF_NODISCARD lf_status lf_vdb_read(int fd, const char *name, bool is_velocity, lf_grid **out_grid,
                                   lf_error *err);
/* The names of the grids of floats, halves and doubles, each with a newline behind it; at most
 * `size` bytes with the end, whole names. Errors as of lf_vdb_read. */
LF_NODISCARD lf_status lf_vdb_list(int fd, char *out, size_t size, lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
