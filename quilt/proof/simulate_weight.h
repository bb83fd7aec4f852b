/* Private to quilt/proof: how much of a pixel lies in a lens's spot, by its distance from the
 * spot's middle. A pixel is a rectangle, a spot a strip that ink blurs across. */
#ifndef LF_QUILT_SIMULATE_WEIGHT_H
#define LF_QUILT_SIMULATE_WEIGHT_H

enum { LF_WEIGHT_STEPS = 4096 };

typedef struct lf_weight {
    double reach; /* mm, beyond which weights are 0 */
    float table[LF_WEIGHT_STEPS + 1];
} lf_weight;

/* right_mm, down_mm: how far a pixel's two sides reach across the strip. All lengths in mm. */
void lf_weight_make(lf_weight *weight, double right_mm, double down_mm, double spot_mm,
                    double ink_mm);
/* The weight of a pixel whose middle is off the spot's by this many mm, either way. */
static inline double lf_weight_at(const lf_weight *weight, double off_mm)
{
    const double at = (off_mm < 0.0 ? -off_mm : off_mm) / weight->reach * LF_WEIGHT_STEPS;
    return at < LF_WEIGHT_STEPS ? (double)weight->table[(int)(at + 0.5)] : 0.0;
}

#endif
