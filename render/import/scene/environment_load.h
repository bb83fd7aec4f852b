/* Latitude-longitude sky images, from file to committed tables; private to render/. */
#ifndef LF_RENDER_ENVIRONMENT_LOAD_H
#define LF_RENDER_ENVIRONMENT_LOAD_H

#include "base/file.h"
#include "render/scene/scene.h"
#include "render/transport/light/light_kind.h"

#define LF_MAX_ENVIRONMENT_SIDE 16384

/* Loads an EXR or HDR image under roots through a reader (base/sandbox/raster.h). If path, time,
 * size and inode are the same, it shares the environment of scene, which is being made, or of
 * previous (may be NULL). Negative values become 0 (a debug line counts them), and cubes are
 * converted (environment_cube.h). The file's ignored features are in its warnings. On LF_OK the
 * caller owns a reference. Errors: LF_E_IO, LF_E_PATH, LF_E_FORMAT, LF_E_NOMEM, and errors of
 * lf_import_run. */
LF_NODISCARD lf_status lf_environment_load(const char *path, const lf_roots *roots,
                                           const lf_scene *scene, const lf_scene *previous,
                                           lf_environment **out_environment, lf_error *err);

/* The image that a kind of light paints for these values. It is shared with both scenes, as above,
 * if painted from the same values. The caller owns a reference; NULL = out of memory. */
lf_environment *lf_environment_paint(const lf_light_kind *kind, const lf_value values[],
                                     const lf_scene *scene, const lf_scene *previous);

#endif
