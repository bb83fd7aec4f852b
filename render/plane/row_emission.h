/* What volumes emit along a fan of rays, one a view, up to where they end: int T eps ds, known
 * without a path, T that of media and of the veils and panes among them, and above 0 also where
 * nothing collides; private to render/. A visit knows it in the mean over its jitter: homogeneous
 * shapes in closed form, where no other medium is on the row's plane; grids at one depth in each
 * voxel's length, jittered together, where the field itself is looked up.
 * docs/developer/estimators/volume-emission.md, "Along camera rays". */
#ifndef LF_RENDER_ROW_EMISSION_H
#define LF_RENDER_ROW_EMISSION_H

#include "render/plane/alpha.h"
#include "render/plane/correction.h"

/* A worker's memory for it. */
typedef struct lf_row_emission_memory {
    lf_media emissive;               /* what volumes emit, as cut by the row's plane */
    lf_vec3 light[LF_MAX_LANES];     /* what the fan's rays meet of it, where there is any */
    float behind[LF_SLICE_MAX_SIDE]; /* zero between calls */
} lf_row_emission_memory;

typedef struct lf_row_emission {
    const lf_media *media; /* of this row's plane */
    const lf_rays *rays;   /* from Z = 0 on */
    const float *length;   /* of the rays, per unit of Z */
    bool corrected;        /* T by correction weights where media are slices */
    lf_alpha_walk *alphas; /* along the same rays; NULL: the scene has none */
} lf_row_emission;

/* Adds to out[rays->n], which may be lanes of memory->light. u in [0, 1): the jitter; further
 * numbers from the tracer, which counts the look-ups. */
void lf_row_emission_fan(const lf_row_emission *emission, float u, lf_tracer *tracer,
                         lf_row_emission_memory *memory, lf_vec3 *out);

#endif
