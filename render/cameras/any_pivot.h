/* Pivots of cameras listed one by one: their weights for all views, and their distribution to the
 * views that see them; private to render/cameras/. docs/developer/estimators/cameras.md. */
#ifndef LF_RENDER_ANY_PIVOT_H
#define LF_RENDER_ANY_PIVOT_H

#include "render/cameras/pinhole.h"
#include "render/cameras/splat.h"
#include "render/integrator.h"
#include "render/transport/lanes/suffix_batch.h"
#include "render/transport/path/path.h"
#include "render/transport/sampler.h"

/* Suffixes per shared pivot: its weights for all views cost as much as many suffixes. And suffixes
 * in lanes per pivot that is not shared. */
enum { LF_ANY_SUFFIXES = 4, LF_ANY_SUFFIXES_ALONE = 2 };

/* A view of a pivot. */
typedef struct lf_any_sight {
    double density; /* D; 0: the view does not see the pivot */
    int row;
    size_t pixel; /* index in the row */
    lf_vec3 wo;   /* unit, back to the eye */
} lf_any_sight;

/* Pivots that wait until lanes trace their suffixes. */
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
    lf_any_queue *queue; /* NULL: suffixes are traced one at a time */
    lf_film_sums sums;
    int64_t base_paths, contributions;
    float brightest; /* largest radiance in the pilot */
    lf_any_sight sight[LF_MAX_VIEWS];
    lf_vec3 f[LF_MAX_VIEWS];     /* scattering of a direction, per view */
    lf_vec3 found[LF_MAX_VIEWS]; /* result of a pivot, per view */
} lf_any_worker;

typedef struct lf_any_cameras {
    lf_scene seen;
    lf_pool *pool;
    const lf_lane_scene *lanes; /* traces suffixes; NULL: not used */
    const lf_suffixes *suffixes;
    lf_film *film;
    lf_pinhole *views; /* [n_views] */
    int n_views, width, height;
    bool alone; /* nothing is shared (vpt) */
    bool has_meshes, has_volumes;
    lf_sampler_kind sampler;
    int max_depth, n_workers;
    lf_any_worker *workers; /* [n_workers] */
    lf_splats splats;
    bool spilt;      /* splats contain a rest of a cancelled pass */
    bool *in_pass;   /* [height] rows that the pass visits */
    uint8_t *halves; /* [height] the half of each */
} lf_any_cameras;

/* A base sample that has found a pivot. */
typedef struct lf_any_pivot {
    lf_event event;
    int view, row, column;
    float lens[2]; /* lens point of its ray */
    lf_sampler *sampler;
} lf_any_pivot;

/* Draws a pivot's suffixes one by one and adds their light to the sums of all views that see it.
 * pilot: only determines the largest radiance. */
void lf_any_scatter(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, bool pilot);

/* Adds a pivot in a medium to the queue for lanes and draws its sampler's numbers at once. Flushes
 * a full queue. */
void lf_any_push(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p,
                 const lf_cancel *cancel);
/* Traces the suffixes of all queued pivots and adds their light. If cancelled, drops the rest. */
void lf_any_flush(lf_any_cameras *s, lf_any_worker *w, const lf_cancel *cancel);

#endif
