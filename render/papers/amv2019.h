/* Adaptive Multi-view Path Tracing (Fraboni et al. 2019); private to render/. */
#ifndef LF_RENDER_AMV2019_H
#define LF_RENDER_AMV2019_H

#include "render/papers/state.h"

/* Probability with which a view is taken, equations 13 and 17: min(J, 1/J) of the film's Jacobian
 * between both, times (1 - delta)^(1/alpha). own, others: pdfs of the base's lobe and of the view's
 * in the direction in which the base's is highest; alpha of the surface's roughness, 1 where
 * nothing depends on the view. delta is |own - others| / (own + others), equation 16's middle: its
 * right side, |1 - others/own|, is another number, and more than 1 where the view's lobe is twice
 * as high. */
double lf_accepted(double jacobian, double own, double others, double alpha);

/* Estimates K of equation 9 for every pair of views, the mean over a view's samples of |T'| V: of
 * what another view sees, with the Jacobian of equation 11. Random numbers are its own and always
 * the same. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_normalise(lf_general *g);

#endif
