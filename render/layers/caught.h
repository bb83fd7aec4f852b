/* Shadow and reflection catchers, sample by sample, for layers and images; private to render/. */
#ifndef LF_RENDER_CAUGHT_H
#define LF_RENDER_CAUGHT_H

#include "render/plane/rig.h"
#include "render/renderer.h"
#include "render/transport/path/catcher.h"

/* Limits of the samples per pixel. */
#define LF_CATCH_LEAST 8
#define LF_CATCH_MOST 4096

/* Number of catcher samples for a pixel with `native` native samples. */
int lf_catch_points(double native);

typedef struct lf_catch_pixel {
    const lf_rig *rig;
    uint64_t seed;
    int max_depth; /* of reflected paths, in vertices from the catcher on */
    int view, row, column;
} lf_catch_pixel;

lf_catch_pixel lf_catch_pixel_of(const lf_renderer *renderer, const lf_rig *rig, int view, int row,
                                 int column);
/* The key of its random numbers. */
uint64_t lf_catch_key(const lf_catch_pixel *pixel);

/* A ray through a pixel, and the random numbers for its samples. */
typedef struct lf_catch_ray {
    lf_vec3 eye, w; /* w is not unit */
    float x;        /* of the film point, in columns */
    float u[5];     /* for lf_catcher_light; u[1] to u[3] also for lf_catcher_reflection */
} lf_catch_ray;

/* Ray i of the pixel with this key. */
lf_catch_ray lf_catch_ray_of(const lf_catch_pixel *pixel, uint64_t key, int i);

/* Upper bound of a pixel's catcher share, if the share `met` of the film's points met another
 * surface. This is known from more samples than the pixel's own rays as long as these are few. 1 in
 * scenes with volumes, where a noisy bound would reduce shadows behind them. */
float lf_catch_open(const lf_scene *scene, double met);
/* That share for a pixel [view][column] of a visited row, which is open. */
double lf_catch_met(const lf_film *film, int row, size_t pixel);

/* The share of shadowed catchers in a pixel, from n of its own rays, each with light samples; at
 * most `open`. */
double lf_catch_shade(lf_tracer *tracer, const lf_catch_pixel *pixel, int n, float open);

/* The reflection of a catcher on ray i of a pixel, if the ray has hit a reflection catcher with
 * transmittance `passed`; with its own random numbers. Non-finite values become 0. */
lf_vec3 lf_catch_reflected(lf_tracer *tracer, const lf_catch_pixel *pixel, uint64_t key, int i,
                           const lf_catch_ray *ray, const lf_hit *hit, float passed);
/* The reflection of catchers in a pixel, from n of its rays, the same as in lf_catch_shade.
 * Unbiased, because added light cannot make a pixel too dark. */
lf_vec3 lf_catch_reflection(lf_tracer *tracer, const lf_catch_pixel *pixel, int n);

/* Whether catchers affect the images of a scene. */
static inline bool lf_catch_shows(const lf_scene *scene)
{
    return lf_has(scene, LF_TRAIT_CATCHERS) && scene->backdrop.given;
}
/* The backdrop behind the catchers of a row. */
lf_vec3 lf_catch_behind(const lf_scene *scene, const lf_rig *rig, int row);

static inline void lf_catch_take(float *out, float shade, lf_vec3 backdrop)
{
    out[0] -= shade * backdrop.x;
    out[1] -= shade * backdrop.y;
    out[2] -= shade * backdrop.z;
}

static inline void lf_catch_put(float *out, lf_vec3 reflection)
{
    out[0] += reflection.x;
    out[1] += reflection.y;
    out[2] += reflection.z;
}

#endif
