/* One grid of an OpenVDB file in our bricks, read by quiltimport (import.h); private to render/. */
#ifndef LF_RENDER_VDB_IMPORT_H
#define LF_RENDER_VDB_IMPORT_H

#include "render/scene/grid.h"

#define LF_VDB_MAX_BYTES ((uint64_t)16 << 30)

/* Reads grid `name` of the file open at fd (path is its name in messages): floats, halves and
 * doubles; active voxels and active tiles; inactive ones are 0. Level sets become fog: 1 deeper
 * inside than the narrow band, falling linearly to 0 at the surface. If several grids have the
 * name, the first is taken; "NAME[1]" is the second, and so on. An empty or all-zero grid gives
 * LF_OK and a grid without bricks. Invalid densities count as 0 and are reported in odd. fd stays
 * the caller's. On LF_OK the caller owns a reference to *out_grid.
 *
 * LF_E_FORMAT: not a VDB file, no such grid (the message lists the existing ones), a grid of
 * another type, a map that is not affine, signed distances without their class. LF_E_NOMEM: more
 * than LF_GRID_MAX_BYTES; also errors of lf_import_run. Thread: any, several at once. */
LF_NODISCARD lf_status lf_vdb_import(int fd, const char *path, const char *name, lf_grid **out_grid,
                                     lf_error *err);

/* The names of the file's number grids, each followed by a newline, "" if there are none. On LF_OK
 * the caller owns *out_names (lf_free). Errors as of lf_vdb_import. */
LF_NODISCARD lf_status lf_vdb_import_names(int fd, const char *path, char **out_names,
                                           lf_error *err);

/* The sum of the grids of these names, separated by newlines (with lf_grid_sum's errors, too); for
 * one name lf_vdb_import. */
LF_NODISCARD lf_status lf_vdb_import_sum(int fd, const char *path, const char *names,
                                         lf_grid **out_grid, lf_error *err);

/* Velocities: one grid for each component, with signed values. "NAME.x" is a grid of that name, or
 * else the first component of a vector grid NAME. Vectors that the file marks as staggered are on
 * the faces of voxels, and the grids' maps account for it. Values may be looked up; their majorants
 * are meaningless. Errors as of lf_vdb_import, except that negative values are valid. On LF_OK the
 * caller owns a reference to each. */
LF_NODISCARD lf_status lf_vdb_import_velocity(int fd, const char *path, const char *const names[3],
                                              lf_grid *out[3], lf_error *err);

#endif
