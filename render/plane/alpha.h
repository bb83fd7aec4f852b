/* Alpha surfaces (glTF's alpha: leaves, lace, curtains) and thin glass, cut by a row's plane: the
 * transmittance of all of them between a point and each view, and along the rays of a fan; private
 * to render/. They have a section of their own. Their transmittance is a factor of D_k. It is
 * evaluated for each view and never decided at random. Only the end of a base sample is random, and
 * its probability is part of D_k (docs/developer/estimators/alpha.md, "Alpha surfaces"). */
#ifndef LF_RENDER_ALPHA_H
#define LF_RENDER_ALPHA_H

#include "render/plane/section.h"

/* The alpha surfaces that one ray of a fan crosses from depth `first` on, near to far, up to depth
 * `known`. known is INFINITY if these are all. */
#define LF_ALPHA_CROSSINGS_KEPT 16
typedef struct lf_alpha_crossings {
    float first, known;
    int n, next; /* number of crossings, and how many of them lf_alphas_to has counted */
    bool wanted; /* while they are being collected */
    float z[LF_ALPHA_CROSSINGS_KEPT], passes[LF_ALPHA_CROSSINGS_KEPT];
    int segment[LF_ALPHA_CROSSINGS_KEPT]; /* in the section; -1: found by rays */
} lf_alpha_crossings;

/* A walk along the rays of a fan, for transmittances from the cameras to increasing depths. */
typedef struct lf_alpha_walk {
    lf_row_cut alphas;
    lf_lines lines;
    const float *z_end;
    lf_alpha_crossings ray[LF_MAX_LANES];
} lf_alpha_walk;

/* Multiplies scale[k] by the transmittance of all alpha surfaces between the point p and the camera
 * position c[k]. Arguments as for lf_section_hide. */
void lf_alphas_before(const lf_row_cut *alphas, lf_vec3 p, const lf_hit *on, int n, const float *c,
                      float *scale);

/* Walks along the rays of lf_section_nearest, in front of z_end[k]. Multiplies through[k] by the
 * transmittance of the alpha surfaces, and sets mirrors[k] if one of them has delta lobes. Unless
 * it is NULL, kept[k] receives the nearest crossings of each ray, up to the first opaque one. */
void lf_alphas_along(const lf_row_cut *alphas, const lf_lines *lines, const float *z_end,
                     float *through, bool *mirrors, lf_alpha_crossings *kept);

/* Begins a walk along the same rays; z_end and lines->c must outlive it. */
void lf_alphas_begin(lf_alpha_walk *walk, const lf_row_cut *alphas, const lf_lines *lines,
                     const float *z_end);
/* Restarts at the cameras. */
void lf_alphas_rewind(lf_alpha_walk *walk);
/* Multiplies through[k] by the transmittance of the alpha surfaces between the depth of the
 * previous call (the camera) and z[k] <= z_end[k]. z[k] must not decrease between calls. A ray
 * whose through[k] is 0 may keep its z. */
void lf_alphas_to(lf_alpha_walk *walk, const float *z, float *through);
/* Inserts one more crossing, sorted by depth; crossings of equal depth become one. If there are too
 * many, the farthest is dropped and `known` becomes its depth. Crossings behind an opaque one are
 * dropped. */
void lf_alpha_keep(lf_alpha_crossings *ray, float z, float passes, int segment);

#endif
