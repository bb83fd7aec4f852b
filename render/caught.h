/* What catchers get, sample by sample, for layers and pictures; private to render/. */
#ifndef LF_RENDER_CAUGHT_H
#define LF_RENDER_CAUGHT_H

#include "render/rows/rig.h"
#include "render/transport/catcher.h"

/* How many samples a pixel gets that has so many native ones: at least 8, at most 4096. */
int lf_catch_points(double native);

typedef struct lf_catch_pixel {
    const lf_rig *rig;
    uint64_t seed;
    int view, row, column;
} lf_catch_pixel;

/* What catchers may have of a pixel where the share `met` of the film's points met something: known
 * from more samples than the pixel's own rays while these are few. 1 in scenes with volumes, where
 * a noisy bound would take from what is caught behind them. */
float lf_catch_open(const lf_scene *scene, double met);

/* How much of a pixel is catchers in the shade, from n samples: rays of its own, each with light
 * samples; of the pixel at most what is open. */
double lf_catch_shade(lf_tracer *tracer, const lf_catch_pixel *pixel, int n, float open);

#endif
