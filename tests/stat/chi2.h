/* Pearson's chi-square test of a sampler against its pdf, after pbrt-v4's and Mitsuba 3's.
 * Directions are binned about an axis in (t, phi) with 1 - cos = m_max (e^(warp t) - 1) / (e^warp -
 * 1): a warp of 20 gives every decade of a narrow lobe its bins. */
#ifndef LF_TESTS_CHI2_H
#define LF_TESTS_CHI2_H

#include "render/scene/vec.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct lf_chi2_sphere {
    /* Draws a direction from u[3]; false = none (absorbed). */
    bool (*sample)(const void *context, const float u[3], lf_vec3 *w);
    /* Per unit solid angle. */
    double (*pdf)(const void *context, lf_vec3 w);
    const void *context;
    lf_vec3 axis;   /* unit */
    double m_max;   /* 2 = whole sphere, 1 = hemisphere */
    double warp;    /* > 0 */
    int n_t, n_phi; /* bins */
    int n_samples;
    uint64_t seed;
} lf_chi2_sphere;

/* p-value; 0 when samples fall where the pdf is 0 or the pdf's integral exceeds 1. What the domain
 * misses (absorbed or outside) is one more cell, expected 1 - integral; an integral within 1e-3 of
 * 1 counts as 1. *out_mass (may be NULL) is the pdf's integral over the domain. */
double lf_chi2_sphere_p(const lf_chi2_sphere *test, double *out_mass);

/* p-value of observed counts against expected ones (of the same sum up to rounding); cells
 * expecting fewer than 5 are pooled in rising order. 0 when more than 1e-5 of all fall into cells
 * that expect none. Arrays are reordered. */
double lf_chi2_p(double *observed, double *expected, int n);

#endif
