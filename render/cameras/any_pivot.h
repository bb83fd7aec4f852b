/* Pivots that cameras listed one by one have found, weighed for all of them and spread over those
 * that see them; private to render/papers/. docs/developer/estimators/cameras.md. */
#ifndef LF_RENDER_ANY_PIVOT_H
#define LF_RENDER_ANY_PIVOT_H

#include "render/cameras/pinhole.h"
#include "render/cameras/splat.h"
#include "render/integrator.h"
#include "render/transport/lanes/suffix_batch.h"
#include "render/transport/path/path.h"
#include "render/transport/sampler.h"

/* Suffixes behind a shared pivot: what it weighs for all views costs as much as many of them. And
 * in lanes behind one that is not. */
enum { LF_ANY_SUFFIXES = 4, LF_ANY_SUFFIXES_ALONE = 2 };

/* A view of a pivot. */
typedef struct lf_any_sight {
    double density; /* D; 0: it is not seen */
    int row;
    size_t pixel; /* in the row */
    lf_vec3 wo;   /* unit, back to the eye */
} lf_any_sight;

/* Pivots that wait for lanes to draw their suffixes. */
typedef struct lf_any_queue {
    lf_suffix_batch batch;
    struct {
        int view, row, column;
        float lens[2];
    } base[LF_BATCH_PIVOTS];
} lf_any_queue;

/* One worker's memory. */
typedef struct lf_any_worker {
    _Alignas(LF_CACHE_LINE) lf_tracer tracer;
    lf_any_queue *queue; /* NULL: suffixes go one by one */
    lf_film_sums sums;
    int64_t base_paths, contributions;
    float brightest; /* radiance of the pilot's */
    lf_any_sight sight[LF_MAX_VIEWS];
    lf_vec3 f[LF_MAX_VIEWS];     /* of a direction, by views */
    lf_vec3 found[LF_MAX_VIEWS]; /* of a pivot: what it brings */
} lf_any_worker;

typedef struct lf_any_cameras {
    lf_scene seen;
    lf_pool *pool;
    const lf_lane_scene *lanes; /* what does its suffixes; NULL: none */
    const lf_suffixes *suffixes;
    lf_film *film;
    lf_pinhole *views; /* [n_views] */
    int n_views, width, height;
    bool alone; /* nothing is shared */
    bool has_meshes, has_volumes;
    lf_sampler_kind sampler;
    int max_depth, n_workers;
    lf_any_worker *workers; /* [n_workers] */
    lf_splats splats;
    bool spilt;      /* something is left there of a pass that was cancelled */
    bool *in_pass;   /* [height] rows that the pass visits */
    uint8_t *halves; /* [height] and which half */
} lf_any_cameras;

/* A base sample that has found a pivot. */
typedef struct lf_any_pivot {
    lf_event event;
    int view, row, column;
    float lens[2]; /* the point that its ray has left */
    lf_sampler *sampler;
} lf_any_pivot;

/* Draws a pivot's suffixes one by one and adds what they bring to the sums of all views that see
 * it; pilot: only finds how bright it gets. */
void lf_any_scatter(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, bool pilot);

/* Takes in a pivot in a medium for lanes, whose sampler's numbers it draws at once; flushes when it
 * is full. */
void lf_any_push(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p,
                 const lf_cancel *cancel);
/* Draws the suffixes of all that wait and adds what they bring; cancelled: leaves the rest out. */
void lf_any_flush(lf_any_cameras *s, lf_any_worker *w, const lf_cancel *cancel);

#endif
