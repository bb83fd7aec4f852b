/* Rectified rows: the integrators that visit one epipolar row at a time (vpt, mvpt, amvpt), as the
 * renderer makes and drives them (integrator.h); private to render/, but for bench/ and the tests,
 * which look inside. */
#ifndef LF_RENDER_ROWS_H
#define LF_RENDER_ROWS_H

#include "render/integrator.h"
#include "render/rows/visit.h"

extern const lf_integrator lf_integrator_rows;

/* Its state. */
typedef struct lf_rows {
    lf_scene seen; /* what is seen of the scene; borrows from it */
    lf_pool *pool;
    const lf_lane_scene *lanes; /* what does its suffixes (queue.h); NULL: one by one */
    const lf_suffixes *suffixes;
    lf_rig rig;
    lf_media_frame frame, emissive;
    lf_row_triangles triangles; /* all zero without meshes */
    lf_outline_map outlines;    /* all zero where something moves, or films have no features */
    lf_counts counts;           /* tiles only where sharing->adaptive */
    bool mapped;                /* the map has been made: plan.counts */
    lf_visit_plan plan;         /* of every visit, before an order is known */
    /* [lf_pool_threads] each its own allocation: no shared cache lines */
    lf_scratch *workers;
    struct lf_queue *queues;  /* [n_workers]; NULL: suffixes go one by one */
    lf_shutter_time *moments; /* [n_workers] of `moving`; NULL: nothing moves */
    lf_moving moving;
    int n_workers;
} lf_rows;

#endif
