/* One grid of an OpenVDB file as our own bricks, read by quiltimport (import.h); private to
 * render/. */
#ifndef LF_RENDER_VDB_IMPORT_H
#define LF_RENDER_VDB_IMPORT_H

#include "render/scene/grid.h"

#define LF_VDB_MAX_BYTES ((uint64_t)16 << 30)

/* Reads grid `name` of the file open at fd (path only names it in messages): floats, halves and
 * doubles; active voxels and active tiles; whatever is not active is 0. Level sets become fog: 1
 * deeper inside than the narrow band, falling linearly to 0 at the surface. When several grids
 * carry the name, the first is taken; "NAME[1]" is the second, and so on. An empty or all-zero grid
 * gives LF_OK and a grid without bricks. fd stays the caller's. On LF_OK the caller owns a
 * reference to *out_grid. Errors, LF_E_FORMAT: not a VDB file, no such grid (the message lists
 * those there are), a grid of another kind, a map that is not affine,
 * signed distances without their class (voxels that are no densities count as 0 else, in odd);
 * LF_E_NOMEM: more than LF_GRID_MAX_BYTES; and what lf_import_run gives. Thread: any, several at
 * once. */
LF_NODISCARD lf_status lf_vdb_import(int fd, const char *path, const char *name, lf_grid **out_grid,
                                     lf_error *err);

/* The names of the file's grids of numbers, each with a newline behind it, "" if there are none.
 * On LF_OK *out_names is the caller's (lf_free). Errors: as of lf_vdb_import. */
LF_NODISCARD lf_status lf_vdb_import_names(int fd, const char *path, char **out_names,
                                           lf_error *err);

/* The sum of the grids of these names, each with a newline behind it but the last (lf_grid_sum: its
 * errors, too); one alone is lf_vdb_import. */
LF_NODISCARD lf_status lf_vdb_import_sum(int fd, const char *path, const char *names,
                                         lf_grid **out_grid, lf_error *err);

/* Velocities: one grid for each component, of either sign. "NAME.x" is a grid of that name, or else
 * the first component of a grid of vectors NAME; vectors that the file calls staggered lie on the
 * faces of voxels, and so do the grids' maps. Values may be looked up, their majorants mean
 * nothing. Errors as of lf_vdb_import, but that values below 0 are taken. On LF_OK the caller owns
 * a reference to each. */
LF_NODISCARD lf_status lf_vdb_import_velocity(int fd, const char *path, const char *const names[3],
                                              lf_grid *out[3], lf_error *err);

#endif
