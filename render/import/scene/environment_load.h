/* Latitude-longitude pictures of the sky, from file to committed tables; private to render/. */
#ifndef LF_RENDER_ENVIRONMENT_LOAD_H
#define LF_RENDER_ENVIRONMENT_LOAD_H

#include "base/file.h"
#include "render/scene/scene.h"
#include "render/transport/light/light_kind.h"

#define LF_MAX_ENVIRONMENT_SIDE 16384

/* Has an EXR or HDR picture under roots read (base/sandbox/raster.h). Shares the environment
 * of scene, which is being made, or of previous (may be NULL) when path, time, size and inode are
 * the same. Values below 0 become 0 (a debug line counts them), cubes are unfolded
 * (environment_cube.h), and what the file says without effect is in its warnings. On LF_OK the
 * caller owns a reference. Errors: LF_E_IO, LF_E_PATH, LF_E_FORMAT, LF_E_NOMEM, and what
 * lf_import_run gives. */
LF_NODISCARD lf_status lf_environment_load(const char *path, const lf_roots *roots,
                                           const lf_scene *scene, const lf_scene *previous,
                                           lf_environment **out_environment, lf_error *err);

/* The picture that a kind of lights paints of these values; shares that of both scenes, as above,
 * which was painted of the same. The caller owns a reference; NULL = out of memory. */
lf_environment *lf_environment_paint(const lf_light_kind *kind, const lf_value values[],
                                     const lf_scene *scene, const lf_scene *previous);

#endif
