/* Integrators that know no rows of rectified rigs: reference modes, plain and slow, as the renderer
 * drives them (integrator.h); private to render/.
 *
 * mvpt2022 (docs/developer/papers.md): multi-view path tracing as Fraboni et al. (2022) have it.
 * Media are tracked with one majorant a volume; the null-scattering chain of a base prefix is
 * shifted to every view (--shift), views are selected (--selection), one suffix from
 * the mixture of their lobes is shared, and view j gets it with the weight of equation 23, over the
 * selected views:
 *
 *     w_ij = rho_j / sum_k rho_k,   rho_k = p_kk / p_ik = |S'_ik film| x lf_shift_ratio
 *
 * The lens point is copied: all views have one radius, so its Jacobian is 1. Film: N sums w y, W
 * sums w, of pivots and of what escapes (w = 1, its own pixel's alone), so that q is 1, B is 0,
 * mwis is the paper's N/W, and mis, N/n, is algorithm 1. mismvpt is that under a name of its own:
 * all views share, and W is n, so that every answer is N/n. amvpt2022 is mvpt2022 with counts of
 * its pilot's, amv2019 and amv2019k are in amv2019.h. Rigs are rectified, so a copied lens point
 * and film height leave a path in its row, which is what makes rows of the film the unit of work
 * here, too; nothing else is taken from it: each sample has a film point and a lens point of its
 * own.
 *
 * A pivot may lie on a surface: it is copied, |S'_ik film| holds its normal, a ray says which views
 * it is hidden from (those that look at the other side do not share), null collisions of media
 * before it are shifted as any, and each view has the light that leaves it its own way. Delta lobes
 * are the base's alone: a sum of its own, M of the film. */
#ifndef LF_RENDER_GENERAL_H
#define LF_RENDER_GENERAL_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_general;

#endif
