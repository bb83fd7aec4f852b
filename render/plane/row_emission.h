/* Volume emission along a fan of rays, one per view, up to their ends: int T eps ds, without a
 * path. T is the transmittance of media and of the alpha surfaces and thin glass among them. The
 * integral can be above 0 also where nothing collides. Its mean over a visit's jitter is exact:
 * homogeneous shapes in closed form, if no other medium is on the row's plane; grids with a look-up
 * of the field at one depth per voxel length, jittered together. Private to render/.
 * docs/developer/estimators/volume-emission.md, "Along camera rays". */
#ifndef LF_RENDER_ROW_EMISSION_H
#define LF_RENDER_ROW_EMISSION_H

#include "render/plane/alpha.h"
#include "render/plane/correction.h"

/* A worker's memory for row emission. */
typedef struct lf_row_emission_memory {
    lf_media emissive;               /* the volume emission, as cut by the row's plane */
    lf_vec3 light[LF_MAX_LANES];     /* emission that the fan's rays receive, if there is any */
    float behind[LF_SLICE_MAX_SIDE]; /* zero between calls */
} lf_row_emission_memory;

typedef struct lf_row_emission {
    const lf_media *media; /* of this row's plane */
    const lf_rays *rays;   /* from Z = 0 on */
    const float *length;   /* of the rays, per unit of Z */
    bool corrected;        /* correct T by weights where media are slices */
    lf_alpha_walk *alphas; /* along the same rays; NULL: the scene has no alpha surfaces */
} lf_row_emission;

/* Adds to out[rays->n], which may be lanes of memory->light. u in [0, 1): the jitter; further
 * numbers from the tracer, which counts the look-ups. */
void lf_row_emission_fan(const lf_row_emission *emission, float u, lf_tracer *tracer,
                         lf_row_emission_memory *memory, lf_vec3 *out);

#endif
