/* Surfaces that are not there whole (glTF's alpha: leaves, lace, curtains), cut by a row's plane:
 * how much of them lies between a point and each view, and along the rays of a fan; private to
 * render/. They are a section of their own. What they let through is a factor of D_k, evaluated for
 * each view and never a coin: where a base sample ends is chosen by chance, and that chance is part
 * of D_k (docs/developer/estimators/alpha.md, "Alpha surfaces"). */
#ifndef LF_RENDER_ALPHA_H
#define LF_RENDER_ALPHA_H

#include "render/plane/section.h"

/* Of one ray of a fan, the veils that it crosses from depth `first` on, near to far: those before
 * depth `known`, which is INFINITY where these are all. */
#define LF_ALPHA_CROSSINGS_KEPT 16
typedef struct lf_alpha_crossings {
    float first, known;
    int n, next; /* how many there are, and how many of them lf_alphas_to has counted */
    bool wanted; /* while they are looked for */
    float z[LF_ALPHA_CROSSINGS_KEPT], passes[LF_ALPHA_CROSSINGS_KEPT];
    int segment[LF_ALPHA_CROSSINGS_KEPT]; /* of the section, -1: rays found it */
} lf_alpha_crossings;

/* A fan that asks what veils let through on its way from the cameras to ever greater depths. */
typedef struct lf_alpha_walk {
    lf_row_cut alphas;
    lf_lines lines;
    const float *z_end;
    lf_alpha_crossings ray[LF_MAX_LANES];
} lf_alpha_walk;

/* Multiplies scale[k] by what all veils between the point p and the camera position c[k] let
 * through; arguments as of lf_section_hide. */
void lf_alphas_before(const lf_row_cut *alphas, lf_vec3 p, const lf_hit *on, int n, const float *c,
                      float *scale);

/* Along the rays of lf_section_nearest, in front of z_end[k]: multiplies through[k] by what veils
 * let through, and sets mirrors[k] where one of them has delta lobes. kept: [k], gets the nearest
 * veils of each ray, up to one that lets nothing through; NULL: they are not wanted. */
void lf_alphas_along(const lf_row_cut *alphas, const lf_lines *lines, const float *z_end,
                     float *through, bool *mirrors, lf_alpha_crossings *kept);

/* Begins a walk along the same rays; z_end and lines->c must outlive it. */
void lf_alphas_begin(lf_alpha_walk *walk, const lf_row_cut *alphas, const lf_lines *lines,
                     const float *z_end);
/* Back to the cameras. */
void lf_alphas_rewind(lf_alpha_walk *walk);
/* Multiplies through[k] by what the veils between the depth of the call before (the camera) and
 * z[k] <= z_end[k] let through. z[k] never falls between two calls. A ray of which nothing is left
 * (through[k] 0) may stay where it is. */
void lf_alphas_to(lf_alpha_walk *walk, const float *z, float *through);
/* Keeps one more crossing, in its place by depth; equal depths become one. Where there are too
 * many, the farthest goes, and `known` is its depth. Behind what lets nothing through none is kept.
 */
void lf_alpha_keep(lf_alpha_crossings *ray, float z, float passes, int segment);

#endif
