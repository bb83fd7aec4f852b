#include "render/papers/count.h"

#include <math.h>

lf_count_share lf_count_share_of(double expected, double phase, double n, double share)
{
    lf_count_share s = {(uint32_t)floor(phase + expected * n),
                        (uint32_t)floor(phase + expected * (n + share)), 1.0f};
    /* With at least one certain sample, the realised number is as good as the expected one, and
     * adds no noise. */
    double count = expected * share < 1.0 ? expected * share : (double)(s.end - s.begin);
    s.alone = s.end > s.begin ? (float)(share / count) : 1.0f;
    return s;
}
