/* How many light paths a rendering takes, found by a pilot; private to render/rows/. */
#ifndef LF_RENDER_LIGHT_PILOT_H
#define LF_RENDER_LIGHT_PILOT_H

#include "render/transport/path/forward_path.h"

typedef struct lf_light_plan {
    const lf_emitters *emitters;
    int per_pass; /* light paths for each pass, even; 0: none */
    float m;      /* for one native sample of every view pixel */
    float cut;    /* roulette: light below this survives in proportion; 0: all survives */
} lf_light_plan;

#endif
