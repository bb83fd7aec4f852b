/* Null-scattering chains: delta tracking of a whole volume's majorant along a ray, which keeps what
 * it meets (Miller, Georgiev and Jarosz 2019); private to render/. Media overlap freely: their
 * majorants and extinctions add up. In contrast to transport/path/track.h the chain is of use to
 * others: shift.h. A chain belongs to one worker; nothing allocates. */
#ifndef LF_RENDER_NULL_CHAIN_H
#define LF_RENDER_NULL_CHAIN_H

#include "render/papers/shift.h"
#include "render/transport/path/track.h"

/* Null collisions that a chain holds. */
#define LF_MAX_NULLS 4096
/* The largest majorant depth of a scene for which more have no probability that matters: 22
 * standard deviations. */
#define LF_MAX_NULL_DEPTH 2900.0

/* A ray through the media of a scene; w unit. */
typedef struct lf_media_path {
    lf_tracer *tracer; /* whose scene it is; counts look-ups */
    lf_vec3 o, w;
    lf_majorant majorant;
} lf_media_path;

typedef struct lf_null_chain {
    int n;
    lf_null nulls[LF_MAX_NULLS];
} lf_null_chain;

/* Along 0 <= t <= end, which may be infinite. */
void lf_media_path_init(lf_media_path *path, lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end);

/* The largest that the majorant depth of any ray through the scene can be. */
double lf_media_path_depth_bound(const lf_scene *scene);

/* lf_extinction_fn of an lf_media_path. */
double lf_media_path_extinction(void *path, double t);

/* Tracks along the path: the distance of its first real collision and whose it is, or INFINITY;
 * *out: the null collisions before it. Random numbers are the tracer's. */
double lf_null_chain_draw(lf_media_path *path, lf_null_chain *out, int *out_volume);

#endif
