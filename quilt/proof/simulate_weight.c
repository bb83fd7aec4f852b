#include "quilt/proof/simulate_weight.h"

#include <math.h>

/* Of the shorter side of a pixel. */
#define PARTS 32
/* Standard deviations of ink that count. */
#define REACH 4.0
/* Of all light; weaker spots do not count. */
#define LEAST_SHARE 1e-4

static const double root_2 = 1.41421356237309504880, root_2_pi = 2.50662827463100050242;

/* The integral of the ink's step response. */
static double ramp(double x, double ink)
{
    if (!(ink > 0.0))
        return x > 0.0 ? x : 0.0;
    return x * 0.5 * erfc(-x / (ink * root_2)) + ink * exp(-0.5 * x * x / (ink * ink)) / root_2_pi;
}

double lf_weight_before(double x, double spot_mm, double ink_mm)
{
    return ramp(x + 0.5 * spot_mm, ink_mm) - ramp(x - 0.5 * spot_mm, ink_mm);
}

/* Of a pixel that is off the middle of one spot. */
static double one_weight(double off, double wide, double narrow, double spot, double ink)
{
    double sum = 0.0;
    for (int k = 0; k < PARTS; k++) {
        const double at = off + narrow * ((k + 0.5) / PARTS - 0.5);
        sum += lf_weight_before(at + 0.5 * wide, spot, ink) -
               lf_weight_before(at - 0.5 * wide, spot, ink);
    }
    return sum / (PARTS * wide * spot);
}

static void make_one(lf_weight *weight, double wide, double narrow, double spot_mm, double ink_mm)
{
    weight->reach = 0.5 * (wide + narrow + spot_mm) + REACH * ink_mm;
    for (int i = 0; i <= LF_WEIGHT_STEPS; i++)
        weight->table[LF_WEIGHT_STEPS + i] = weight->table[LF_WEIGHT_STEPS - i] =
            (float)one_weight(weight->reach * i / LF_WEIGHT_STEPS, wide, narrow, spot_mm, ink_mm);
}

void lf_weight_make(lf_weight *weight, double right_mm, double down_mm, double spot_mm,
                    double ink_mm, const lf_proof_spots *spots)
{
    lf_weight one;
    double most = 0.0;
    make_one(&one, fmax(right_mm, down_mm), fmin(right_mm, down_mm), spot_mm, ink_mm);
    *weight = one;
    if (!spots || spots->n == 0)
        return;
    for (int k = 0; k < spots->n; k++)
        if (spots->share[k] > LEAST_SHARE)
            most = fmax(most, fabs(spots->right_mm[k]));
    weight->reach = one.reach + most;
    for (int i = 0; i <= 2 * LF_WEIGHT_STEPS; i++) {
        const double off = weight->reach * (i - LF_WEIGHT_STEPS) / LF_WEIGHT_STEPS;
        double sum = 0.0;
        for (int k = 0; k < spots->n; k++)
            if (spots->share[k] > LEAST_SHARE)
                sum += spots->share[k] * lf_weight_at(&one, off - spots->right_mm[k]);
        weight->table[i] = (float)sum;
    }
}
