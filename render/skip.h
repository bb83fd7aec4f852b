/* What is left out where a scene or a view does not need it: one table, so that each can be
 * switched off, shown and timed; private to render/ but for lf_skip in render.h. */
#ifndef LF_RENDER_SKIP_H
#define LF_RENDER_SKIP_H

#include "render/scene/scene.h"

/* The scene as the integrators see it: what is not in `skip` is there whether the scene needs
 * it or not. *out_empty (a counted reference, or NULL) holds what it borrows beyond the
 * scene: release it with lf_geometry_unref after the last use of *out. out->refs is not set.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_skip_scene(const lf_scene *scene, unsigned skip, lf_scene *out,
                                     struct lf_geometry **out_empty, lf_error *err);

/* What the scene does not need: bits of lf_skip. */
unsigned lf_skip_found(const lf_scene *scene);

#endif
