/* Correction weights: samples drawn from slices (slice.h) are weighted so that they count for the
 * grids themselves; private to render/.
 *
 * A pivot p that slices send to view k with density D~_k has the weight R_k = sigma(p) T_k /
 * (sigma~_k(p) T~_k), the true density over the slice's. Only its mean matters. So T_k / T~_k =
 * exp(-int (sigma - sigma~)) along the ray is estimated, as the product of 1 - (sigma - sigma~) /
 * lambda over the points of a Poisson process of density lambda (the power series of the
 * exponential, Georgiev et al. 2019). The mean is exact for any lambda that is above 0 wherever the
 * two differ. The relative variance is exp(int (sigma - sigma~)^2 / lambda) - 1. lambda is the
 * slice's own estimate of its error, so that a whole fan of views needs a few look-ups. Homogeneous
 * shapes and voxels with edges are cut exactly: R = 1. docs/developer/estimators/grids.md, "The
 * weight". */
#ifndef LF_RENDER_CORRECTION_H
#define LF_RENDER_CORRECTION_H

#include "render/plane/media.h"

/* Point densities in units of the slice's `rough`. A pivot is one of many that a pixel receives.
 * Volume emission along a ray of the unscattered light represents a whole visit. */
#define LF_CORRECTION_PIVOT 2.0f
#define LF_CORRECTION_EXIT 16.0f

/* Point density for B and q in a visit that gives each view pixel `contributions` contributions,
 * its own included: at least four times a pivot's density, at most LF_CORRECTION_EXIT. The variance
 * of the weights falls with their density, and the variance of paths with their number, so both
 * should grow together. A fit removes most path noise but keeps B and q unchanged, so that noise at
 * wisps would be visible. */
static inline float lf_correction_exit_density(float contributions, bool fitted)
{
    return fitted ? LF_CORRECTION_EXIT
                  : lf_min(lf_max(0.5f * contributions, 4.0f * LF_CORRECTION_PIVOT),
                           LF_CORRECTION_EXIT);
}

/* Whether any medium on this row's plane is a slice; if not, all R are 1. */
bool lf_correction_needed(const lf_media *media);

/* Multiplies factor[n], or factor[3][n] of the channels, by unbiased estimates of T / T~; all rays
 * share the depths of the points. dense: lambda in units of the slice's `rough` where the fan
 * passes. It is multiplied by the squared number of cells that the steepest ray crosses between two
 * planes. least: minimum expected number of points over the whole depth. Thin media need some
 * points if the difference of T / T~ to 1 matters. Random numbers come from the tracer, which
 * counts the look-ups. */
void lf_correction_transmittance(const lf_media *media, const lf_rays *rays, float dense,
                                 float least, lf_tracer *tracer, float *factor);

/* sigma_t of the grid at a collision with a medium that is a slice of the grid. */
float lf_correction_density(const lf_media *media, int medium, const lf_scene *scene, lf_vec3 p,
                            lf_tracer *tracer);

#endif
