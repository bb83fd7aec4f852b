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

/* How much of a pixel is catchers in the shade, from n samples: rays of its own, each with light
 * samples. */
double lf_catch_shade(lf_tracer *tracer, const lf_catch_pixel *pixel, int n);

#endif
