/* A scene at one moment of its shutter, for one worker; private to render/. Time is one more
 * coordinate of a visit: all that the visit draws, and all that is known of it, is of one moment
 * (docs/estimators.md, "A shutter that is open"). */
#ifndef LF_RENDER_MOMENT_H
#define LF_RENDER_MOMENT_H

#include "render/scene/scene.h"

typedef struct lf_moment {
    /* All of the scene that it was made for, whose meshes, in their order, stand where they are at
     * the moment; lf_tracer.time has to say the same moment. Borrows from that scene. */
    lf_scene scene;
    float *places; /* what .scene.meshes that move have of their own, one after the other */
} lf_moment;

/* Of scene->looks.moving. LF_E_NOMEM. Release with lf_moment_finish in any case. */
LF_NODISCARD lf_status lf_moment_init(lf_moment *moment, const lf_scene *scene);
/* Accepts a zeroed one. */
void lf_moment_finish(lf_moment *moment);

/* time: 0 when the shutter opens, 1 when it closes. scene is what the moment was made for. */
void lf_moment_set(lf_moment *moment, const lf_scene *scene, float time);

#endif
