/* A scene and its rig at one moment of its shutter, for one worker; private to render/. Time is one
 * more coordinate of a visit: all that the visit draws, and all that is known of it, is of one
 * moment (docs/developer/estimators/motion.md, "One time per visit"). */
#ifndef LF_RENDER_SHUTTER_TIME_H
#define LF_RENDER_SHUTTER_TIME_H

#include "render/plane/rig.h"

/* What moments are made of. */
typedef struct lf_moving {
    const lf_scene *scene;
    lf_rig rig;                  /* of the settings, where the frame has it */
    lf_render_settings settings; /* of a view; what it points to may be gone */
} lf_moving;

/* Something is elsewhere when the shutter closes. */
static inline bool lf_moving_moves(const lf_moving *moving)
{
    return lf_has(moving->scene, LF_TRAIT_MOTION) || moving->settings.camera.moves;
}

typedef struct lf_shutter_time {
    /* All of the scene, whose meshes, lights and volumes, in their order, are what they are at the
     * moment; lf_tracer.time has to say the same moment. Borrows from that scene. */
    lf_scene scene;
    lf_rig rig;
    lf_volume *media; /* .scene.volumes, what of them emits, and fields of albedo */
    float *places;    /* what .scene.meshes that move have of their own, one after the other */
} lf_shutter_time;

/* LF_E_NOMEM. Release with lf_shutter_time_finish in any case. */
LF_NODISCARD lf_status lf_shutter_time_init(lf_shutter_time *shutter, const lf_moving *moving);
/* Accepts a zeroed one. */
void lf_shutter_time_finish(lf_shutter_time *shutter);

/* time: 0 when the shutter opens, 1 when it closes. moving is what the moment was made for. */
void lf_shutter_time_set(lf_shutter_time *shutter, const lf_moving *moving, float time);

#endif
