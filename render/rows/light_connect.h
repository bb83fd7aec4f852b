/* Connects vertices of light paths to the views; private to render/rows/. */
#ifndef LF_RENDER_LIGHT_CONNECT_H
#define LF_RENDER_LIGHT_CONNECT_H

#include "render/rows/light_pilot.h"
#include "render/rows/visit.h"

/* Where light arrives. */
typedef struct lf_light_sink {
    void *context;
    /* Whether a row is wanted. */
    bool (*wants)(void *context, int row);
    /* Takes light for a view pixel of a row, an index [view][column]. */
    void (*take)(void *context, int row, size_t pixel, lf_vec3 rgb);
    /* Ends the light of a vertex. */
    void (*close)(void *context, const lf_forward_vertex *vertex);
} lf_light_sink;

typedef struct lf_light_connect {
    lf_visit visit; /* of the vertex: its plane and worker */
    const lf_light_plan *plan;
    lf_light_sink sink;
    int view;   /* the only view that the path serves; -1: all */
    float over; /* of the last vertex that was taken: the density of camera paths */
} lf_light_connect;

void lf_light_connect_init(lf_light_connect *connect, const lf_scene *scene, const lf_rig *rig,
                           lf_scratch *worker, const lf_light_plan *plan);
/* Traces a light path and connects its vertices. */
void lf_light_connect_path(lf_light_connect *connect, uint64_t random, int max_depth, bool alone);

#endif
