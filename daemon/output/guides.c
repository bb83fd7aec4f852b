#include "daemon/output/guides.h"

#include <math.h>

void lf_guides_mark(const lf_depth *depth, double exposure, const float *layers, size_t n,
                    float *film)
{
    static const float near[3] = {0.9f, 0.05f, 0.02f}, far[3] = {0.02f, 0.15f, 0.9f};
    const float shown = (float)exp2(-exposure); /* radiance that is shown as 1 */
    for (size_t i = 0; i < n; i++, layers += 2, film += 3) {
        const double z = (double)layers[0];
        const float *colour = z < depth->sharp_from ? near : z > depth->sharp_to ? far : NULL;
        const float share = 0.5f * layers[1];
        if (!colour || !(z > 0.0))
            continue;
        for (int c = 0; c < 3; c++)
            film[c] += share * (shown * colour[c] - film[c]);
    }
}
