/* Optimisations for scenes and views that need less: one table, so that each can be switched off,
 * reported and timed. Private to render/, except lf_skip in render.h. */
#ifndef LF_RENDER_SKIP_H
#define LF_RENDER_SKIP_H

#include "render/scene/scene.h"

/* The scene as the integrators see it. A part whose bit is not in `skip` is present whether or not
 * the scene needs it. *out_empty (a counted reference, or NULL) owns what *out borrows in addition
 * to the scene. Release it with lf_geometry_unref after the last use of *out. out->refs is not set.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_skip_scene(const lf_scene *scene, unsigned skip, lf_scene *out,
                                     struct lf_geometry **out_empty, lf_error *err);

/* Bits of lf_skip: the optimisations that the scene allows. */
unsigned lf_skip_found(const lf_scene *scene);

#endif
