/* The state of restir (restir.h), and its stages; private to render/. */
#ifndef LF_RENDER_RESTIR_STATE_H
#define LF_RENDER_RESTIR_STATE_H

#include "render/integrator.h"
#include "render/papers/vertex_reuse.h"
#include "render/plane/rig.h"
#include "render/transport/sampler.h"

/* Kinds of reuse of reservoirs. */
typedef struct lf_restir_reuse {
    const char *name;
    /* DRAWN: random neighbours */
    enum { LF_RESTIR_ALONE, LF_RESTIR_DRAWN, LF_RESTIR_BLOCKS } beside;
    bool temporal;
    int walks; /* per pixel; <= LF_MAX_WALKS */
} lf_restir_reuse;

/* A view pixel of a row. */
typedef struct lf_restir_pixel {
    lf_camera_ray ray;
    lf_path_sample sample;
} lf_restir_pixel;

/* The stored reservoirs of one half of a row. */
typedef struct lf_restir_left {
    uint64_t random;
    uint32_t visits, used;   /* number of visits; 0: empty */
    lf_restir_pixel *pixels; /* [view][column] */
} lf_restir_left;

/* A pixel of a block. */
typedef struct lf_restir_instanced {
    int block, at;
} lf_restir_instanced;

typedef struct lf_restir_worker {
    _Alignas(LF_CACHE_LINE) lf_tracer tracer;
    lf_film_sums sums;
    int64_t base_paths, contributions;
    lf_light_walk *walks;       /* [LF_MAX_WALKS] */
    lf_restir_pixel *pixels;    /* [view][column] of this visit */
    lf_path_sample *spread;     /* the same, combined with their neighbours */
    int *visited;               /* [view * width] pixels of this visit */
    lf_restir_instanced *order; /* [view * width] the same, sorted by block */
    int n_visited;
} lf_restir_worker;

typedef struct lf_restir {
    lf_scene seen;
    lf_rig rig;
    lf_film *film;
    lf_coarse_grid coarse;
    lf_path_space space;
    bool across; /* neighbours are in other views, and distances are counted from the window */
    const lf_restir_reuse *reuse;
    lf_reuse_weights weights;
    lf_sampler_kind sampler;
    int n_workers;
    lf_restir_worker *workers;   /* [n_workers] */
    lf_restir_left *rows;        /* [height][2]; NULL without temporal reuse */
    lf_restir_pixel *all_pixels; /* [height][2][view][column], their pixels */
} lf_restir;

/* Makes the rays, and the reservoirs of their walks, for n <= LF_MAX_WALKS / walks pixels of a row.
 */
void lf_restir_begin(const lf_restir *s, lf_restir_worker *w, int row, int n, const int *at,
                     uint64_t key, uint32_t index);
/* Combines a pixel with the reservoir of an earlier visit. */
void lf_restir_look_back(const lf_restir *s, lf_restir_worker *w, const lf_restir_left *before,
                         int at);
/* Combines all visited pixels with others of the same visit, by s->reuse; key: the visit's. false:
 * cancelled. */
bool lf_restir_look_beside(const lf_restir *s, lf_restir_worker *w, uint64_t key,
                           const lf_cancel *cancel);

#endif
