/* Private to quilt/proof: how much of a pixel lies in a lens's spot, by its distance from the
 * spot's middle. A pixel is a rectangle, a spot a strip that ink blurs across. */
#ifndef LF_QUILT_SIMULATE_WEIGHT_H
#define LF_QUILT_SIMULATE_WEIGHT_H

#include "quilt/proof/simulate.h"

enum { LF_WEIGHT_STEPS = 4096 };

typedef struct lf_weight {
    double reach; /* mm to either side, beyond which weights are 0 */
    float table[2 * LF_WEIGHT_STEPS + 1];
} lf_weight;

/* right_mm, down_mm: how far a pixel's two sides reach across the strip. spots may be NULL. All
 * lengths in mm. */
void lf_weight_make(lf_weight *weight, double right_mm, double down_mm, double spot_mm,
                    double ink_mm, const lf_proof_spots *spots);
/* The weight of a pixel whose middle is this many mm to the right of the lens's place. */
static inline double lf_weight_at(const lf_weight *weight, double off_mm)
{
    const double at = (off_mm / weight->reach + 1.0) * LF_WEIGHT_STEPS + 0.5;
    return at >= 0.0 && at < 2 * LF_WEIGHT_STEPS + 1 ? (double)weight->table[(int)at] : 0.0;
}
/* The width of a blurred strip around 0 that lies to the left of x. */
double lf_weight_before(double x, double spot_mm, double ink_mm);
/* Sets the spots of a sheet by the crosstalk of print->blur; without it does nothing. pixel_mm:
 * across the lenses. */
void lf_proof_fit_spots(const lf_print *print, double pixel_mm, lf_proof_sheet *sheet);

#endif
