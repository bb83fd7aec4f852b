/* Shifts of null-scattering chains between views: the six mappings of the supplement of Fraboni et
 * al., "Volumetric Multi-View Rendering" (2022), and the weights of shifted chains; private to
 * render/. Only reference integrators use them: rows/ has the same densities in closed form
 * (docs/developer/papers.md). Pure functions of their arguments, in double precision.
 *
 * A chain consists of the null collisions that tracking with a majorant meets between a lens and
 * the pivot: m of them, at distances t_q. A mapping moves each to a distance t' on the ray from
 * another lens to the same pivot. Each family uses one coordinate of majorant.h, y(t) = l, tau or
 * u, and
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
 * optical-stretch is the paper's choice. Equation numbers are the supplement's.
 *
 * Differences from the printed formulas:
 * - raw-copy: "t' = t" is counted from the start of the media, l' = l. This is the same with one
 *   section that begins at the lens, as in the supplement's figure, and is defined for several.
 * - Since u = 1 - exp(-tau), primary-copy and optical-copy are the same mapping.
 * - Equation 17: u = int mu(s) T(s) ds; without mu it is not a probability.
 * - Equation 20: a_1 sums mu'_i, not the printed l'_i.
 * - Equation 21: C / (C - (C - 1) exp(tau)) overflows. It equals C exp(tau' - tau), and
 *   tau' = -log(1 - C u) is computed from a sum of positive terms if C u is near 1.
 * - Equations 2, 4, 10, 16, 22: the density of a shifted chain, p(x') = p(t) |S'|^-1 P_n(x'), must
 *   contain the null probability of the BASE point, P_n(x), because the base drew it. P_n(x')
 *   belongs to the target's own density (lf_shift_ratio has both).
 * - Main paper, equation 4: the film's Jacobian is g(l,f)/g(l,p) g(l',p)/g(l',f'); the first
 *   factor is printed upside down (lf_shift_area).
 * - Main paper, equation 3: r'^2/r^2 is the Jacobian of the lens. It is 1 for lenses of one size,
 *   and a uniform density on the lenses always makes it 1. */
#ifndef LF_RENDER_SHIFT_H
#define LF_RENDER_SHIFT_H

#include "render/papers/majorant.h"

typedef struct lf_shift {
    const char *name; /* as in --shift */
    /* Maps a point of `from` to `to`, with dt'/dt; false: it is in no medium of `to`. */
    bool (*map)(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                lf_majorant_point *out, double *out_jacobian);
} lf_shift;

extern const lf_shift lf_shift_raw_copy, lf_shift_raw_stretch, lf_shift_optical_copy,
    lf_shift_optical_stretch, lf_shift_primary_copy, lf_shift_primary_stretch;

/* The first is the default, the paper's choice; NULL after the last. */
const lf_shift *lf_shift_at(int index);

/* A null collision: its position, and the extinction there, below the majorant. */
typedef struct lf_null {
    lf_majorant_point at;
    double extinction;
} lf_null;

/* Extinction of the media at a distance along a ray. */
typedef double (*lf_extinction_fn)(void *ray, double t);

/* The density of the shifted chain in the target over its density when drawn by the base and
 * shifted: p_jj / p_ij without film and lens, and without common factors at the pivot,
 *
 *     exp(tau_i - tau_j) prod_q |dt'_q/dt_q| mu_n(t'_q) / mu_n(t_q),     mu_n = mu - extinction
 *
 * with tau the majorant depths of the whole rays. Its mean over the base's chains with the same
 * pivot is T_j / T_i if the mapping reaches all chains of the target with a nonzero density. It
 * does not if mu_n of the base is 0 (in homogeneous media) and mu_n of the target is not. Stretches
 * reach all chains, unless only one of the rays has media (then only m = 0 is reached). Copies
 * reach all, unless the target's coordinate ends first. Returns 0 if a point lands in no medium. */
double lf_shift_ratio(const lf_shift *shift, const lf_majorant *from, const lf_majorant *to, int n,
                      const lf_null *nulls, lf_extinction_fn extinction, void *target);

/* Area at the pivot per area on the film: g(l,f)/g(l,p), g(a,b) = |cos at b|/|b - a|^2. The point
 * `film` is where the ray from the lens meets any plane perpendicular to the camera's unit axis,
 * the same plane for all views. The normal is of the surface at the pivot, NULL in a medium. The
 * film's Jacobian from i to j is area_i / area_j. */
double lf_shift_area(const double lens[3], const double film[3], const double axis[3],
                     const double pivot[3], const double *normal);

#endif
