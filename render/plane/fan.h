/* The cost of a pivot on a surface: loops over the views, and over the segments of a section, as a
 * table of functions. fan_lanes.h holds the algorithm, written with lanes (lanes.h) and compiled
 * once per instruction set. All give bitwise the same results. Private to render/. */
#ifndef LF_RENDER_FAN_H
#define LF_RENDER_FAN_H

#include "render/plane/section_walk.h"
#include "render/transport/surface/surface.h"

/* A pivot, to be projected into the views. */
typedef struct lf_projection {
    const lf_rig *rig;
    float x, z, lx; /* lf_pivot */
    bool surface;
    /* h of the view at c: -(nx (x - c) + nyz) on a surface, sqrt((x - c)^2 + yz2) in a medium. */
    float nx, nyz, yz2;
} lf_projection;

/* Results per view, [lanes]. */
typedef struct lf_projected {
    float *x0, *slope, *z_end; /* its ray to the pivot */
    int *column;               /* film column; 0 outside the film */
    float *h; /* 0: the view does not see the pivot's side, or has it out of frame */
} lf_projected;

/* What a pivot sends to the views, summed over its directions. Lanes after the last view are
 * undefined. */
typedef struct lf_sent {
    float n[3][LF_MAX_LANES]; /* radiance times weight */
    float w2[LF_MAX_LANES];   /* weights of the directions, W' */
} lf_sent;

/* A direction in the frame of the rays X = slope Z, Y = my Z: the vector across the views, the part
 * along Z of a ray with slope 0, and 1 + my^2. */
typedef struct lf_fan_axis {
    float across, along, my2;
} lf_fan_axis;

/* W' of one direction. Where z <= LF_MIN_COS, a view draws no directions and gets `blind`. */
typedef struct lf_fan_share {
    const float *lobe; /* pdf of every view; NULL: no direction was drawn */
    const float *z;    /* cosine to the view; NULL: every view draws directions */
    float drawn, blind;
} lf_fan_share;

typedef struct lf_fans {
    const char *name;

    /* Fills *out for this number of lanes, a multiple of LF_LANES; lanes after the last view have h
     * 0. */
    void (*project)(const lf_projection *of, int lanes, const lf_projected *out);

    /* lf_kernels.densities for depths that are all 0. */
    float (*densities)(int n, const float *scale, float *d);

    /* The cosine between an axis and each ray. out may not alias slope. */
    void (*cosines)(const lf_fan_axis *axis, int n, const float *slope, float *out);
    /* Henyey-Greenstein of every ray towards a direction, whose axis has the sign of g; |g| < 1. */
    void (*phases)(float g, const float to[3], float my, int n, const float *slope, float *out);
    /* The sum of strategy[k] pdf[k], added in the order of densities. */
    float (*pdf)(int n, const float *strategy, const float *pdf);
    /* Adds density[c][k] f[c][k] times the radiance, which includes the colour of the lobes. */
    void (*collect)(int n, const float *const density[3], const lf_fan_lobes *lobes,
                    lf_vec3 radiance, lf_sent *sent);
    /* Adds density[k] times the share of W'. */
    void (*collect_shares)(int n, const float *density, const lf_fan_share *share, lf_sent *sent);

    /* Boxes that may hide the point from positions between the outermost ones, one bit each. */
    unsigned (*meets)(const lf_section_node *node, const lf_question *q);
    /* Segments that hide the point, one bit each; [lo, hi] are the positions from which each one
     * hides it. */
    unsigned (*intervals)(const lf_section_leaf *leaf, const lf_question *q,
                          float lo[LF_SECTION_WIDE], float hi[LF_SECTION_WIDE]);
    /* Sets q->scale to 0 where a segment hides the point. q must be narrowed and not empty. */
    void (*hide)(const lf_section *section, lf_question *q);

    /* lf_section_nearest, but returns d instead of Z; -LF_SECTION_FAR: no hit. */
    void (*nearest)(const lf_section *section, float s0, int n, const float *c, float *d,
                    int *segment);
} lf_fans;

extern const lf_fans lf_fans_c;
#if defined(__x86_64__)
extern const lf_fans lf_fans_avx2;
#endif

#endif
