/* A scene and its rig at one time of the shutter, for one worker; private to render/. Time is one
 * more coordinate of a visit: all samples and all known light of a visit use the same time
 * (docs/developer/estimators/motion.md, "One time per visit"). */
#ifndef LF_RENDER_SHUTTER_TIME_H
#define LF_RENDER_SHUTTER_TIME_H

#include "render/plane/rig.h"

/* The scene and rig that are interpolated in time. */
typedef struct lf_moving {
    const lf_scene *scene;
    lf_rig rig;                  /* of the settings, at the frame */
    lf_render_settings settings; /* of a view; its pointers may be invalid */
} lf_moving;

/* Whether anything moves while the shutter is open. */
static inline bool lf_moving_moves(const lf_moving *moving)
{
    return lf_has(moving->scene, LF_TRAIT_MOTION) || moving->settings.camera.moves;
}

typedef struct lf_shutter_time {
    /* The whole scene, with meshes, lights and volumes in the same order, as it is at this shutter
     * time. lf_tracer.time must be the same time. Borrows from the moving scene. */
    lf_scene scene;
    lf_rig rig;
    lf_volume *media; /* scene.volumes, their emission, and albedo fields */
    float *places;    /* own data of moving meshes in scene.meshes, one after the other */
} lf_shutter_time;

/* LF_E_NOMEM. Release with lf_shutter_time_finish, also after a failure. */
LF_NODISCARD lf_status lf_shutter_time_init(lf_shutter_time *shutter, const lf_moving *moving);
/* Accepts a zeroed struct. */
void lf_shutter_time_finish(lf_shutter_time *shutter);

/* Interpolates to time: 0 when the shutter opens, 1 when it closes. moving must be the struct given
 * to lf_shutter_time_init. */
void lf_shutter_time_set(lf_shutter_time *shutter, const lf_moving *moving, float time);

#endif
