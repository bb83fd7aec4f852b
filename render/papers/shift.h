/* Shifts of null-scattering chains between views: the six mappings of the supplement of Fraboni et
 * al., "Volumetric Multi-View Rendering" (2022), and what a chain weighs with them; private to
 * render/. Only reference estimators use them: rows/ knows the same densities in closed form
 * (docs/developer/papers.md). Pure functions of their arguments, in double precision.
 *
 * A chain is what tracking with a majorant meets between a lens and the pivot: m null collisions at
 * distances t_q. A mapping takes each to a distance t' on the ray from another lens to the same
 * pivot. Each family goes by one coordinate of majorant.h, y(t) = l, tau or u, and
 *
 *     copies         y'(t') = y(t),      stretches      y'(t') = C y(t),  C = y'_max / y_max
 *     its Jacobian   dt'/dt = C (dy/dt) / (dy'/dt')     (copies: C = 1)
 *
 *     raw-copy         t' = t         1                              equation 1
 *     raw-stretch      l' = C l       C                              equations 7 and 9
 *     optical-copy     tau' = tau     mu / mu'                       section 1.3
 *     optical-stretch  tau' = C tau   C mu / mu'                     equations 13 and 15
 *     primary-copy     u' = u         mu / mu'                       equation 3
 *     primary-stretch  u' = C u       C exp(tau' - tau) mu / mu'     equations 19 and 21
 *
 * optical-stretch is the paper's. The numbers are the supplement's.
 *
 * What differs from what is printed there:
 * - raw-copy: "t' = t" counts from where media begin, l' = l: the same with one section that begins
 *   at the lens, as in the supplement's figure, and it has a meaning with several.
 * - Since u = 1 - exp(-tau), primary-copy and optical-copy are one mapping.
 * - Equation 17: u = int mu(s) T(s) ds, without mu it is no probability.
 * - Equation 20: a_1 sums mu'_i where l'_i is printed.
 * - Equation 21: C / (C - (C - 1) exp(tau)) overflows; it is C exp(tau' - tau), and
 *   tau' = -log(1 - C u) is taken from a sum of positive terms where C u is near 1.
 * - Equations 2, 4, 10, 16, 22: the density of a shifted chain, p(x') = p(t) |S'|^-1 P_n(x'), holds
 *   the null probability of the BASE point, P_n(x): it is the base that drew it. P_n(x') belongs to
 *   what the target would have drawn (lf_shift_ratio has both).
 * - Main paper, equation 4: the film's Jacobian is g(l,f)/g(l,p) g(l',p)/g(l',f'), the first
 *   factor upside down as printed (lf_shift_area).
 * - Main paper, equation 3: r'^2/r^2 is the Jacobian of the lens; lenses of one size leave 1, and
 *   a uniform density on them always does.
 */
#ifndef LF_RENDER_SHIFT_H
#define LF_RENDER_SHIFT_H

#include "render/papers/majorant.h"

typedef struct lf_shift {
    const char *name; /* as in --shift */
    /* A point of `from` on `to`, and dt'/dt; false: it lands on no medium of `to`. */
    bool (*map)(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                lf_majorant_point *out, double *out_jacobian);
} lf_shift;

extern const lf_shift lf_shift_raw_copy, lf_shift_raw_stretch, lf_shift_optical_copy,
    lf_shift_optical_stretch, lf_shift_primary_copy, lf_shift_primary_stretch;

/* The first is the default, the paper's own; NULL behind the last. */
const lf_shift *lf_shift_at(int index);

/* A null collision: where it is, and the extinction there, below the majorant. */
typedef struct lf_null {
    lf_majorant_point at;
    double extinction;
} lf_null;

/* Extinction of the media at a distance along a ray. */
typedef double (*lf_extinction_fn)(void *ray, double t);

/* How much likelier the shifted chain is, drawn by the target itself, than the base's, drawn by the
 * base and shifted: p_jj / p_ij without film and lens, both without what they have in common at the
 * pivot,
 *
 *     exp(tau_i - tau_j) prod_q |dt'_q/dt_q| mu_n(t'_q) / mu_n(t_q),     mu_n = mu - extinction
 *
 * with tau the majorant depths of the whole rays. Its mean over the base's chains with the same
 * pivot is T_j / T_i where the mapping reaches all chains of the target that have a density there:
 * not where mu_n of the base is 0 (in homogeneous media) and that of the target is not. Stretches
 * reach all, unless one of the rays alone has media (then m = 0 alone is reached), copies where the
 * target's
 * coordinate ends first. 0: some point lands on no medium. */
double lf_shift_ratio(const lf_shift *shift, const lf_majorant *from, const lf_majorant *to, int n,
                      const lf_null *nulls, lf_extinction_fn extinction, void *target);

/* Area at the pivot for an area on the film: g(l,f)/g(l,p), g(a,b) = |cos at b|/|b - a|^2. film is
 * the point where the ray from the lens meets any plane across the camera's unit axis, the same for
 * all views; normal: of the surface that the pivot is on, NULL in a medium. The film's Jacobian
 * from i to j is area_i / area_j. */
double lf_shift_area(const double lens[3], const double film[3], const double axis[3],
                     const double pivot[3], const double *normal);

#endif
