/* Weighted reservoirs (Chao 1982; Talbot et al. 2005; Lin, Wyman and Yuksel 2021, supplement,
 * algorithm 2): one sample of a stream is kept, with a probability proportional to its weight;
 * private to render/. Pure functions; the caller stores the samples.
 *
 * A candidate x of density p has the weight p-hat(x)/p(x), p-hat the target function. The kept
 * sample represents the whole stream with
 *
 *     W = sum of weights / (M p-hat(x)),        E[f(x) W] = int f    where p-hat is not 0
 *
 * M counts candidates, including those with weight 0. A kept sample enters another pixel's stream
 * with the weight p-hat there, times M W, times its share m (lf_reservoir_share). M is only a
 * weight: it may be capped without changing W. */
#ifndef LF_RENDER_RESERVOIR_H
#define LF_RENDER_RESERVOIR_H

#include <math.h>
#include <stdbool.h>

typedef struct lf_reservoir {
    double sum, target, m; /* sum of weights; p-hat of the kept sample; M */
} lf_reservoir;

/* Offers a sample; u in [0, 1). true: it is kept now. M is unchanged. */
static inline bool lf_reservoir_offer(lf_reservoir *r, double weight, double target, double u)
{
    /* a weight that is not finite would be kept forever */
    if (!(weight > 0.0) || !isfinite(weight))
        return false;
    r->sum += weight;
    if (!(u * r->sum < weight))
        return false;
    r->target = target;
    return true;
}

/* W of the kept sample; 0: none. */
static inline double lf_reservoir_weight(const lf_reservoir *r)
{
    return r->target > 0.0 && r->m > 0.0 ? r->sum / (r->m * r->target) : 0.0;
}

/* The share of a sample of stream `own` among n streams, given its target function in each and
 * their M: m = p-hat_own sum M / sum M p-hat, so that for every sample sum_i M_i m_i = sum M. The
 * biased shortcut replaces it by 1, which assumes that every stream could have found the sample.
 * The result is then too small by the part of sum M of streams that could not. */
static inline double lf_reservoir_share(int n, const double *m, const double *target, int own)
{
    double all = 0.0, found = 0.0;
    for (int i = 0; i < n; i++) {
        all += m[i];
        found += m[i] * target[i];
    }
    return found > 0.0 ? target[own] * all / found : 0.0;
}

#endif
