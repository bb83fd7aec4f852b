/* Internals of the renderer, for renderer*.c and the tests; private to render/. */
#ifndef LF_RENDER_RENDERER_H
#define LF_RENDER_RENDERER_H

#include "render/integrator.h"
#include "render/plane/rig.h"
#include "render/reconstruct/reconstruct.h"
#include "render/transport/lanes/lane_scene.h"

/* The data of an earlier fit, and its rig. */
typedef struct lf_known_past {
    lf_past *past; /* NULL: none */
    lf_rig rig;
} lf_known_past;

struct lf_renderer {
    lf_scene *scene;
    struct lf_geometry *empty; /* the integrator's substitute for meshes (skip.h), or NULL */
    lf_render_settings settings;
    lf_pool *pool;
    struct lf_sunlight *sunlight; /* made by the first pass whose film has features; NULL: none */
    lf_lane_scene *lanes;         /* owned, for suffixes; NULL: suffixes are traced one by one */
    lf_film film;
    lf_reconstruction *shown; /* NULL until the first fit; has this film's shape and rig */
    /* of an earlier film; kept until every row of this film has been fitted */
    lf_known_past before;
    lf_known_past spare; /* of this film, kept during a new fit because that may be cancelled */
    const lf_integrator *integrator;
    void *state;      /* of the integrator */
    int visit_passes; /* passes in a visit of the offline schedule */
    unsigned faults;  /* lf_fault (rows/visit.h), of all later passes */
};

/* Drops the fit before another film begins. If the scene is the same, the fit becomes the first
 * guess of the next one. */
void lf_renderer_retire_fit(lf_renderer *renderer, const lf_scene *scene,
                            const lf_render_settings *settings);
/* Drops the fit and the data of earlier fits. */
void lf_renderer_drop_fits(lf_renderer *renderer);

/* Hash of everything that defines the image except the random numbers: scene, volume files, rig and
 * settings without the seed. integrator is the name of the one in use. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_identify(const lf_scene *scene,
                                            const lf_render_settings *settings,
                                            const char *integrator, uint8_t out[LF_PICTURE_BYTES]);

#endif
