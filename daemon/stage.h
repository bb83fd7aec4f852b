/* stage: what is to be shown, settled: a scene with the rig and layout that follow from command line, panel and scene, or a quilt
 * picture as it is. Immutable once committed to the engine, and reference counted, so that exports can go on while the next
 * one is shown. Thread: any. */
#ifndef LF_DAEMON_STAGE_H
#define LF_DAEMON_STAGE_H

#include "daemon/options.h"

typedef struct lf_stage {
    atomic_int references;
    lf_scene *scene;             /* NULL: a quilt picture */
    lf_quilt_file quilt;         /* when scene is NULL */
    char *file;                  /* absolute path it came from; patches do not change it */
    lf_render_settings settings; /* scene only; integrator points to a static name */
    lf_layout layout;
    lf_film_settings film;
} lf_stage;

/* From a scene (a reference is taken) or from a quilt picture (read here). calibration may be NULL. On LF_OK the caller owns a
 * reference. */
LF_NODISCARD lf_status lf_stage_from_scene(lf_scene *scene, const char *file, const lf_options *options,
                                           const lf_calibration *calibration, lf_stage **out_stage, lf_error *err);
LF_NODISCARD lf_status lf_stage_from_quilt(const char *file, const lf_roots *roots, const lf_options *options, lf_stage **out_stage,
                                           lf_error *err);
/* Logs what the scene warns of, but for what `before` (may be NULL) has warned of already. */
void lf_log_warnings(const lf_scene *scene, const lf_scene *before);

lf_stage *lf_stage_ref(lf_stage *stage);
/* Accepts NULL. */
void lf_stage_unref(lf_stage *stage);

#endif
