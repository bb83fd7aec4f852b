/* What a pivot on a surface costs: loops over the views, and over the segments of a section, behind
 * a table of functions. fan_lanes.h is the algorithm, over lanes (lanes.h), compiled once an
 * instruction set; every one answers the same bits. Private to render/rows/. */
#ifndef LF_RENDER_FAN_H
#define LF_RENDER_FAN_H

#include "render/plane/section_walk.h"

/* A pivot, as views project it. */
typedef struct lf_projection {
    const lf_rig *rig;
    float x, z, lx; /* lf_pivot */
    bool surface;
    /* Of a surface, h of the view at c is -(nx (x - c) + nyz); of a point in a medium
     * sqrt((x - c)^2 + yz2). */
    float nx, nyz, yz2;
} lf_projection;

/* What is known of each view then, [lanes]. */
typedef struct lf_projected {
    float *x0, *slope, *z_end; /* its ray to the pivot */
    int *column;               /* of its film, 0 outside of it */
    float *h;                  /* 0: it does not see the pivot's side, or has it out of frame */
} lf_projected;

typedef struct lf_fans {
    const char *name;

    /* Fills *out for so many lanes, a multiple of LF_LANES; what lies behind the views has h 0. */
    void (*project)(const lf_projection *of, int lanes, const lf_projected *out);

    /* lf_kernels.densities where all depths are 0. */
    float (*densities)(int n, const float *scale, float *d);

    /* Boxes that hide the point from positions between the outermost, a bit each. */
    unsigned (*meets)(const lf_section_node *node, const lf_question *q);
    /* Segments that do, likewise; [lo, hi] are the positions that each hides it from. */
    unsigned (*intervals)(const lf_section_leaf *leaf, const lf_question *q,
                          float lo[LF_SECTION_WIDE], float hi[LF_SECTION_WIDE]);
    /* Sets q->scale to 0 wherever a segment hides the point; q is narrowed, and something left. */
    void (*hide)(const lf_section *section, lf_question *q);

    /* lf_section_nearest, but that it answers d, -LF_SECTION_FAR: nowhere. */
    void (*nearest)(const lf_section *section, float s0, int n, const float *c, float *d,
                    int *segment);
} lf_fans;

extern const lf_fans lf_fans_c;
#if defined(__x86_64__)
extern const lf_fans lf_fans_avx2;
#endif

#endif
