/* What catchers get, sample by sample, for layers and pictures; private to render/. */
#ifndef LF_RENDER_CAUGHT_H
#define LF_RENDER_CAUGHT_H

#include "render/plane/rig.h"
#include "render/renderer.h"
#include "render/transport/path/catcher.h"

/* At least so many samples a pixel gets, and at most. */
#define LF_CATCH_LEAST 8
#define LF_CATCH_MOST 4096

/* How many a pixel gets that has so many native ones. */
int lf_catch_points(double native);

typedef struct lf_catch_pixel {
    const lf_rig *rig;
    uint64_t seed;
    int max_depth; /* of reflected paths, in vertices from the catcher on */
    int view, row, column;
} lf_catch_pixel;

lf_catch_pixel lf_catch_pixel_of(const lf_renderer *renderer, const lf_rig *rig, int view, int row,
                                 int column);
/* Names its random numbers. */
uint64_t lf_catch_key(const lf_catch_pixel *pixel);

/* A ray through a pixel, and the numbers for its samples. */
typedef struct lf_catch_ray {
    lf_vec3 eye, w; /* w is not unit */
    float x;        /* of the film point, in columns */
    float u[5];     /* for lf_catcher_light; the last but one of it for lf_catcher_reflection */
} lf_catch_ray;

/* The i-th of the pixel with this key. */
lf_catch_ray lf_catch_ray_of(const lf_catch_pixel *pixel, uint64_t key, int i);

/* What catchers may have of a pixel where the share `met` of the film's points met something: known
 * from more samples than the pixel's own rays while these are few. 1 in scenes with volumes, where
 * a noisy bound would take from what is caught behind them. */
float lf_catch_open(const lf_scene *scene, double met);
/* That share of a pixel [view][column], of a row that was visited. */
double lf_catch_met(const lf_film *film, int row, size_t pixel);

/* How much of a pixel is catchers in the shade, from n samples: rays of its own, each with light
 * samples; of the pixel at most what is open. */
double lf_catch_shade(lf_tracer *tracer, const lf_catch_pixel *pixel, int n, float open);

/* What the i-th ray of a pixel brings of what a catcher reflects, where it has hit one that does
 * and so much has passed; random numbers are its own. Not finite: 0. */
lf_vec3 lf_catch_reflected(lf_tracer *tracer, const lf_catch_pixel *pixel, uint64_t key, int i,
                           const lf_catch_ray *ray, const lf_hit *hit, float passed);
/* What catchers reflect into a pixel, from n of its rays, the same ones as lf_catch_shade's:
 * without bias, as what is added makes nothing too dark. */
lf_vec3 lf_catch_reflection(lf_tracer *tracer, const lf_catch_pixel *pixel, int n);

/* Whether catchers change the pictures of a scene. */
static inline bool lf_catch_shows(const lf_scene *scene)
{
    return scene->looks.caught && scene->backdrop.given;
}
/* What is seen behind the catchers of a row. */
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
