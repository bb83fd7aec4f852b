/* Correction weights: what is drawn from slices (slice.h) counts for the grids themselves; private
 * to render/.
 *
 * A pivot p that slices send to view k with density D~_k carries the weight R_k = sigma(p) T_k /
 * (sigma~_k(p) T~_k), the truth over the slice. Its mean is all that matters, so T_k / T~_k =
 * exp(-int (sigma - sigma~)) along the ray is estimated, as the product of 1 - (sigma - sigma~) /
 * lambda over the points of a Poisson process of density lambda (the power series of the
 * exponential, Georgiev et al. 2019): right in the mean for any lambda that is above 0 wherever the
 * two differ, with the relative variance exp(int (sigma - sigma~)^2 / lambda) - 1. lambda is what
 * the slice knows of its own roughness, so that a whole fan of views takes a few look-ups.
 * Homogeneous shapes, and voxels with edges, are cut exactly: R = 1.
 * docs/developer/estimators/grids.md, "The weight". */
#ifndef LF_RENDER_CORRECTION_H
#define LF_RENDER_CORRECTION_H

#include "render/plane/media.h"

/* How dense points are, in units of the slice's rough: a pivot's are one of many that a pixel
 * receives, what volumes emit along an exit's ray stands for a whole visit. */
#define LF_CORRECTION_PIVOT 2.0f
#define LF_CORRECTION_EXIT 16.0f

/* The same of B and q in a visit that gives a view pixel so many contributions, its own included:
 * four times a pivot's density at least, LF_CORRECTION_EXIT at most. The variance of weights falls
 * with their density as that of paths with their number, so that one is to grow with the other. A
 * fit has little noise of paths left, and keeps B and q as they are: sparks at wisps would be seen.
 */
static inline float lf_correction_exit_density(float contributions, bool fitted)
{
    return fitted ? LF_CORRECTION_EXIT
                  : lf_min(lf_max(0.5f * contributions, 4.0f * LF_CORRECTION_PIVOT),
                           LF_CORRECTION_EXIT);
}

/* True when something on this row's plane is a slice; without, all R are 1. */
bool lf_correction_needed(const lf_media *media);

/* Multiplies factor[n], or factor[3][n] of the channels, by estimates of T / T~ that are right in
 * the mean; they share their depths.
 * dense: lambda in units of what the slice calls rough where the fan passes, more by the square of
 * the cells that its steepest ray crosses between two planes. least: points to expect in all of its
 * depth, at least: thin media ask for some where the difference of T / T~ to 1 is what is wanted.
 * Numbers come from the tracer, which counts the look-ups. */
void lf_correction_transmittance(const lf_media *media, const lf_rays *rays, float dense,
                                 float least, lf_tracer *tracer, float *factor);

/* sigma_t of the grid at a collision with a medium that is a slice of it. */
float lf_correction_density(const lf_media *media, int medium, const lf_scene *scene, lf_vec3 p,
                            lf_tracer *tracer);

#endif
