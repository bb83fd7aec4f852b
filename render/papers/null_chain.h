/* Null-scattering chains: delta tracking of a whole volume's majorant along a ray, which records
 * the collisions (Miller, Georgiev and Jarosz 2019); private to render/. Media may overlap: their
 * majorants and extinctions add up. Unlike transport/path/track.h the result can be shifted to
 * other views: shift.h. A chain belongs to one worker; nothing allocates. */
#ifndef LF_RENDER_NULL_CHAIN_H
#define LF_RENDER_NULL_CHAIN_H

#include "render/papers/shift.h"
#include "render/transport/path/track.h"

/* Maximum number of null collisions in a chain. */
#define LF_MAX_NULLS 4096
/* The largest majorant depth of a scene for which the probability of more is negligible: 22
 * standard deviations. */
#define LF_MAX_NULL_DEPTH 2900.0

/* A ray through the media of a scene; w unit. */
typedef struct lf_media_path {
    lf_tracer *tracer; /* holds the scene; counts look-ups */
    lf_vec3 o, w;
    lf_majorant majorant;
} lf_media_path;

typedef struct lf_null_chain {
    int n;
    lf_null nulls[LF_MAX_NULLS];
} lf_null_chain;

/* Along 0 <= t <= end, which may be infinite. */
void lf_media_path_init(lf_media_path *path, lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end);

/* Upper bound of the majorant depth of any ray through the scene. */
double lf_media_path_depth_bound(const lf_scene *scene);

/* An lf_extinction_fn for an lf_media_path. */
double lf_media_path_extinction(void *path, double t);

/* Tracks along the path: returns the distance of its first real collision and in *out_volume its
 * volume, or INFINITY. *out: the null collisions before it. Random numbers are the tracer's. */
double lf_null_chain_draw(lf_media_path *path, lf_null_chain *out, int *out_volume);

#endif
