/* The renderer's insides, for renderer*.c and the tests; private to render/. */
#ifndef LF_RENDER_RENDERER_H
#define LF_RENDER_RENDERER_H

#include "render/integrator.h"
#include "render/plane/rig.h"
#include "render/reconstruct/reconstruct.h"
#include "render/transport/lanes/lane_scene.h"

/* What a fit knew, and the rig that it was of. */
typedef struct lf_known_past {
    lf_past *past; /* NULL: nothing */
    lf_rig rig;
} lf_known_past;

struct lf_renderer {
    lf_scene *scene;
    struct lf_geometry *empty; /* what the integrator sees in place of meshes (skip.h), or NULL */
    lf_render_settings settings;
    lf_pool *pool;
    struct lf_sunlight *sunlight; /* made by the first pass whose film has features; NULL: none */
    lf_lane_scene *lanes;         /* its own, for suffixes; NULL: they go one by one */
    lf_film film;
    lf_reconstruction *shown; /* NULL until it is asked for; of this film's shape and rig */
    lf_known_past before;     /* of an earlier film; until every row of this one has been fitted */
    lf_known_past spare;      /* of this one, while it is fitted again: that may be cancelled */
    const lf_integrator *integrator;
    void *state;      /* its own */
    int visit_passes; /* passes in a visit of the offline schedule */
    unsigned faults;  /* lf_fault (rows/visit.h), of every pass from now on */
};

/* Gives up the fit before another film begins: of the same scene it becomes the first guess. */
void lf_renderer_retire_fit(lf_renderer *renderer, const lf_scene *scene,
                            const lf_render_settings *settings);
/* Forgets fit and pasts. */
void lf_renderer_drop_fits(lf_renderer *renderer);

/* What the picture is of, whatever its random numbers: a hash of scene, files of volumes, rig and
 * settings but the seed; integrator is the name of the one in use. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_identify(const lf_scene *scene,
                                            const lf_render_settings *settings,
                                            const char *integrator, uint8_t out[LF_PICTURE_BYTES]);

#endif
