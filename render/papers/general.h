/* Reference integrators that do not use rows of rectified rigs, simple and slow, as the renderer
 * drives them (integrator.h); private to render/.
 *
 * mvpt2022 (docs/developer/papers.md): multi-view path tracing by Fraboni et al. (2022). Media are
 * tracked with one majorant per volume. The null-scattering chain of a base prefix is shifted to
 * every view (--shift), and views are selected (--selection). One suffix from the mixture of their
 * lobes is shared. View j receives it with the weight of equation 23, over the selected views:
 *
 *     w_ij = rho_j / sum_k rho_k,   rho_k = p_kk / p_ik = |S'_ik film| x lf_shift_ratio
 *
 * The lens point is copied: all views have one radius, so its Jacobian is 1. Film: N sums w y, W
 * sums w, of pivots and of escapes (w = 1, only for its own pixel), so that q is 1 and B is 0. mwis
 * is then the paper's N/W, and mis, N/n, is algorithm 1. mismvpt is a separate name for the latter:
 * all views share, and W is n, so that every estimate is N/n. amvpt2022 is mvpt2022 with counts
 * from its pilot; amv2019 and amv2019k are in amv2019.h. Rigs are rectified, so a copied lens point
 * and film height keep a path in its row. So rows of the film are the unit of work here, too, but
 * rectification is not used otherwise: each sample has its own film point and lens point.
 *
 * A pivot may lie on a surface. It is copied, |S'_ik film| contains its normal, and a ray tests
 * from which views it is hidden (views on the other side do not share). Null collisions of media in
 * front of it are shifted as usual, and each view receives the light that leaves towards it. Delta
 * lobes belong to the base view only: a separate sum, M of the film. */
#ifndef LF_RENDER_GENERAL_H
#define LF_RENDER_GENERAL_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_general;

#endif
