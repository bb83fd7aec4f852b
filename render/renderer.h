/* The renderer's insides, for renderer.c, state.c and the tests; private to render/. */
#ifndef LF_RENDER_RENDERER_H
#define LF_RENDER_RENDERER_H

#include "render/integrator.h"

struct lf_renderer {
    lf_scene *scene;
    lf_scene seen; /* what the integrators see of it (skip.h); borrows from scene and empty */
    struct lf_geometry *empty;
    lf_render_settings settings;
    lf_pool *pool;
    lf_rig rig;
    lf_media_frame frame;
    lf_film film;
    lf_visit_plan plan;
    lf_row_triangles triangles; /* all zero without meshes */
    int visit_passes;           /* passes in a visit of the offline schedule */
    lf_counts counts;           /* tiles only for adaptive integrators */
    bool mapped;                /* the map has been made: plan.counts */
    lf_scratch **workers;       /* [lf_pool_threads] each its own allocation: no shared cache lines */
    int n_workers;
};

#endif
