/* Adaptive Multi-view Path Tracing (Fraboni et al. 2019); private to render/. */
#ifndef LF_RENDER_AMV2019_H
#define LF_RENDER_AMV2019_H

#include "render/papers/state.h"

/* Probability of taking a view, equations 13 and 17: min(J, 1/J) of the film's Jacobian between
 * both, times (1 - delta)^(1/alpha). The arguments own and others are pdfs of the base's lobe and
 * of the view's lobe in the direction of the base lobe's maximum. The roughness alpha is the
 * surface's, 1 if nothing depends on the view. Delta is |own - others| / (own + others), the middle
 * of equation 16. Its right side, |1 - others/own|, is a different number, and exceeds 1 if the
 * view's lobe is twice as high. */
double lf_accepted(double jacobian, double own, double others, double alpha);

/* Estimates K of equation 9 for every pair of views: the mean over a view's samples of |T'| V, V
 * whether another view sees them, with the Jacobian of equation 11. Uses its own fixed random
 * numbers. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_normalise(lf_general *g);

#endif
