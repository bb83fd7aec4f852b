/* Rectified rows: the integrators that visit one epipolar row at a time (vpt, mvpt, amvpt), as the
 * renderer makes and drives them (integrator.h). Private to render/, except for bench/ and the
 * tests, which inspect the state. */
#ifndef LF_RENDER_ROWS_H
#define LF_RENDER_ROWS_H

#include "render/integrator.h"
#include "render/rows/light_paths.h"
#include "render/rows/visit.h"

extern const lf_integrator lf_integrator_rows;

/* The integrator's state. */
typedef struct lf_rows {
    lf_scene seen; /* the part of the scene that is used; borrows from it */
    lf_pool *pool;
    const lf_lane_scene *lanes; /* traces suffixes (queue.h); NULL: one at a time */
    const lf_suffixes *suffixes;
    lf_rig rig;
    lf_media_frame frame, emissive;
    lf_row_triangles triangles; /* all zero without meshes */
    lf_outline_map outlines;    /* all zero if the scene moves, or the film has no features */
    lf_counts counts;           /* has tiles only if sharing->adaptive */
    bool mapped;                /* the map is made and in plan.counts */
    lf_splitting splitting;
    lf_light_paths light; /* none if its plan.per_pass is 0 */
    lf_visit_plan plan;   /* template for every visit, without an order */
    /* [lf_pool_threads] allocated separately: no shared cache lines */
    lf_scratch *workers;
    struct lf_queue *queues;  /* [n_workers]; NULL: suffixes are traced one at a time */
    lf_shutter_time *moments; /* [n_workers] of `moving`; NULL: static scene */
    lf_moving moving;
    int n_workers;
} lf_rows;

#endif
