#include "quilt/proof/simulate_weight.h"

#include <math.h>

/* Of the shorter side of a pixel. */
#define PARTS 32
/* Standard deviations of ink that count. */
#define REACH 4.0

static const double root_2 = 1.41421356237309504880, root_2_pi = 2.50662827463100050242;

/* The integral of the ink's step response. */
static double ramp(double x, double ink)
{
    if (!(ink > 0.0))
        return x > 0.0 ? x : 0.0;
    return x * 0.5 * erfc(-x / (ink * root_2)) + ink * exp(-0.5 * x * x / (ink * ink)) / root_2_pi;
}

/* The blurred strip's integral from far left to x. */
static double before(double x, double spot, double ink)
{
    return ramp(x + 0.5 * spot, ink) - ramp(x - 0.5 * spot, ink);
}

void lf_weight_make(lf_weight *weight, double right_mm, double down_mm, double spot_mm,
                    double ink_mm)
{
    const double wide = fmax(right_mm, down_mm), narrow = fmin(right_mm, down_mm);
    weight->reach = 0.5 * (wide + narrow + spot_mm) + REACH * ink_mm;
    for (int i = 0; i <= LF_WEIGHT_STEPS; i++) {
        const double off = weight->reach * i / LF_WEIGHT_STEPS;
        double sum = 0.0;
        for (int k = 0; k < PARTS; k++) {
            const double at = off + narrow * ((k + 0.5) / PARTS - 0.5);
            sum +=
                before(at + 0.5 * wide, spot_mm, ink_mm) - before(at - 0.5 * wide, spot_mm, ink_mm);
        }
        weight->table[i] = (float)(sum / (PARTS * wide * spot_mm));
    }
}
