/* Volumes from arrays that a client passed in memory (base/passed.h); private to render/. */
#ifndef LF_RENDER_ARRAY_IMPORT_H
#define LF_RENDER_ARRAY_IMPORT_H

#include "render/scene/scene.h"

/* Makes a grid of the array open at fd: size voxels along x, y and z, of size 1 each, centred at
 * the origin. It has the digest of the file. The file is sealed, so it is mapped. Errors name the
 * array: LF_E_FORMAT, LF_E_NOMEM, LF_E_IO; LF_E_TIMEOUT and LF_E_CANCELLED by the limits of
 * base/sandbox/import.h. */
LF_NODISCARD lf_status lf_array_import(int fd, const char *name, const int64_t size[3],
                                       lf_grid **out_grid, lf_error *err);

#endif
