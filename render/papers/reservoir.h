/* Weighted reservoirs (Chao 1982; Talbot et al. 2005; Lin, Wyman and Yuksel 2021, supplement,
 * algorithm 2): one sample kept of a stream, each with a probability in proportion to its weight;
 * private to render/. Pure functions; samples are the caller's to keep.
 *
 * A candidate x of density p weighs p-hat(x)/p(x), p-hat the target function. What is kept stands
 * for the whole stream with
 *
 *     W = sum of weights / (M p-hat(x)),        E[f(x) W] = int f    where p-hat is not 0
 *
 * M counts candidates, those that came to nothing too. A kept sample goes into another pixel's
 * stream with p-hat there times M W times its share m (lf_reservoir_share). M is a weight and
 * nothing else: it may be capped, W being what it was. */
#ifndef LF_RENDER_RESERVOIR_H
#define LF_RENDER_RESERVOIR_H

#include <math.h>
#include <stdbool.h>

typedef struct lf_reservoir {
    double sum, target, m; /* of weights; p-hat of what is kept; M */
} lf_reservoir;

/* Offers a sample; u in [0, 1). true: it is the one that is kept now. M is not touched. */
static inline bool lf_reservoir_offer(lf_reservoir *r, double weight, double target, double u)
{
    if (!(weight > 0.0) || !isfinite(weight)) /* one that is not would stay for ever */
        return false;
    r->sum += weight;
    if (!(u * r->sum < weight))
        return false;
    r->target = target;
    return true;
}

/* W of what is kept; 0: nothing is. */
static inline double lf_reservoir_weight(const lf_reservoir *r)
{
    return r->target > 0.0 && r->m > 0.0 ? r->sum / (r->m * r->target) : 0.0;
}

/* What a sample of stream `own` counts among n streams, its target function in each and their M
 * given: m = p-hat_own sum M / sum M p-hat, so that of every sample sum_i M_i m_i = sum M. The
 * biased shortcut is to take 1 in its place, which counts samples that some streams could not have
 * found as if they could: what is found is then short of these streams' part of sum M. */
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
