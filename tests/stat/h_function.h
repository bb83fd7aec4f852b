/* Chandrasekhar's H function of isotropic scattering (Radiative Transfer, 1960, section 33), by its
 * integral equation. */
#ifndef LF_TESTS_H_FUNCTION_H
#define LF_TESTS_H_FUNCTION_H

#include <math.h>
#include <string.h>

enum { LF_H_NODES = 64 };

typedef struct lf_h_function {
    double albedo, node[LF_H_NODES], weight[LF_H_NODES], value[LF_H_NODES];
} lf_h_function;

/* Gauss and Legendre's rule on 0..1: the roots by Newton, from the cosines that they lie close to.
 */
static inline void lf_h_nodes(lf_h_function *h)
{
    for (int i = 0; i < LF_H_NODES; i++) {
        double x = cos(M_PI * (i + 0.75) / (LF_H_NODES + 0.5)), slope = 0;
        for (int step = 0; step < 10; step++) {
            double below = 1, p = x;
            for (int n = 2; n <= LF_H_NODES; n++) {
                double next = ((2 * n - 1) * x * p - (n - 1) * below) / n;
                below = p;
                p = next;
            }
            slope = LF_H_NODES * (x * p - below) / (x * x - 1);
            x -= p / slope;
        }
        h->node[i] = 0.5 * (1 + x);
        h->weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
}

/* 1/H(mu) = sqrt(1 - albedo) + albedo/2 int x H(x) / (mu + x) dx: the form that iteration converges
 * in when nothing is absorbed, too. */
static inline double lf_h_at(const lf_h_function *h, double mu)
{
    double sum = sqrt(1 - h->albedo);
    for (int i = 0; i < LF_H_NODES; i++)
        sum += 0.5 * h->albedo * h->weight[i] * h->node[i] * h->value[i] / (mu + h->node[i]);
    return 1 / sum;
}

static inline void lf_h_make(lf_h_function *h, double albedo)
{
    *h = (lf_h_function){.albedo = albedo};
    lf_h_nodes(h);
    for (int i = 0; i < LF_H_NODES; i++)
        h->value[i] = 1;
    for (int round = 0; round < 400; round++) {
        double next[LF_H_NODES];
        for (int i = 0; i < LF_H_NODES; i++)
            next[i] = 0.5 * (h->value[i] + lf_h_at(h, h->node[i]));
        memcpy(h->value, next, sizeof next);
    }
}

/* What a half-space gives back of light that enters it evenly but for the cosine. */
static inline double lf_h_spherical_albedo(const lf_h_function *h)
{
    double moment = 0;
    for (int i = 0; i < LF_H_NODES; i++)
        moment += h->weight[i] * h->node[i] * h->value[i];
    return 1 - 2 * sqrt(1 - h->albedo) * moment;
}

#endif
