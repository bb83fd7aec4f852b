/* The renderer's insides, for renderer*.c and the tests; private to render/. */
#ifndef LF_RENDER_RENDERER_H
#define LF_RENDER_RENDERER_H

#include "render/integrator.h"
#include "render/reconstruct/reconstruct.h"

struct lf_renderer {
    lf_scene *scene;
    struct lf_geometry *empty; /* what the integrator sees in place of meshes (skip.h), or NULL */
    lf_render_settings settings;
    lf_pool *pool;
    struct lf_sunlight *sunlight; /* made by the first pass whose film has features; NULL: none */
    lf_film film;
    lf_reconstruction *shown; /* NULL until it is asked for; of this film's shape and rig */
    const lf_integrator *integrator;
    void *state;      /* its own */
    int visit_passes; /* passes in a visit of the offline schedule */
    unsigned faults;  /* lf_fault (rows/visit.h), of every pass from now on */
};

/* What the picture is of, whatever its random numbers: a hash of scene, files of volumes, rig and
 * settings but the seed; integrator is the name of the one in use. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_renderer_identify(const lf_scene *scene,
                                            const lf_render_settings *settings,
                                            const char *integrator, uint8_t out[LF_PICTURE_BYTES]);

#endif
