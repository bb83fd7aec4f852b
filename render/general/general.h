/* Integrators that know no rows of rectified rigs: reference modes, plain and slow, as the renderer
 * drives them (integrator.h); private to render/.
 *
 * mvpt2022 (docs/papers.md): multi-view path tracing as Fraboni et al. (2022) have it. The media of
 * a scene are tracked with one majorant a volume; the null-scattering chain of a base prefix is
 * shifted to every view (settings.shift), views are selected (settings.selection), one suffix from
 * the mixture of their lobes is shared, and view j gets it with the weight of equation 23, over the
 * selected views:
 *
 *     w_ij = rho_j / sum_k rho_k,   rho_k = p_kk / p_ik = |S'_ik film| x lf_shift_ratio
 *
 * The lens point is copied: all views have one radius, so its Jacobian is 1. Film: N sums w y, W
 * sums w, of pivots and of what escapes (w = 1, its own pixel's alone), so that q is 1, B is 0,
 * mwis is the paper's N/W, and mis, N/n, is algorithm 1. mismvpt is that under a name of its own:
 * all views share, and W is n, so that every answer is N/n. Rigs are rectified (render.h has no
 * others yet), so a copied lens point and film height leave a path in its row, which is what makes
 * rows of the film the unit of work here, too; nothing else is taken from it: each sample has a
 * film point and a lens point of its own. Media alone so far.
 *
 * restir (docs/papers.md): Volumetric ReSTIR as Lin, Wyman and Yuksel (2021) have it, each view
 * alone. A visit gives every view pixel that it takes a ray and a reservoir of LF_RESTIR_WALKS
 * walks (light_path.h), puts it together with what an earlier visit of the same half left in the
 * pixel (settings.reuse; M capped) and with those of LF_RESTIR_NEIGHBOURS columns of its row drawn
 * within LF_RESTIR_REACH, and adds F W of what is kept, its transmittances exact. W of the film is
 * n: every answer is N/n. Halves never see each other's reservoirs. What is kept is no part of the
 * film: one that is read from a file goes on with new reservoirs.
 *
 * mvrestir is restir whose neighbours are pixels of other views, LF_MVRESTIR_VIEWS to either side,
 * near the same place in the window. The first vertex's distance counts from the window there, so
 * that what lies in it stays where it is; the Jacobian is 1 as before. */
#ifndef LF_RENDER_GENERAL_H
#define LF_RENDER_GENERAL_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_mvpt2022, lf_integrator_restir;

#define LF_RESTIR_WALKS 4
#define LF_RESTIR_NEIGHBOURS 3
#define LF_RESTIR_REACH 10 /* columns */
#define LF_MVRESTIR_VIEWS 4
#define LF_MVRESTIR_REACH 2  /* columns */
#define LF_RESTIR_HISTORY 20 /* visits' worth of M that an earlier reservoir counts at most */

#endif
