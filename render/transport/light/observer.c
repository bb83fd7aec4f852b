#include "render/transport/light/observer.h"

#include <math.h>

/* A lobe of the fit: a Gaussian with a width on either side. */
typedef struct lobe {
    double height, middle, below, above; /* nm */
} lobe;

static double sum_of(const lobe lobes[], int n, double nm)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        double d =
            (nm - lobes[i].middle) / (nm < lobes[i].middle ? lobes[i].below : lobes[i].above);
        sum += lobes[i].height * exp(-0.5 * d * d);
    }
    return sum;
}

void lf_observer(double nm, double out_xyz[3])
{
    static const lobe x[] = {{1.056, 599.8, 37.9, 31.0},
                             {0.362, 442.0, 16.0, 26.7},
                             {-0.065, 501.1, 20.4, 26.2}},
                      y[] = {{0.821, 568.8, 46.9, 40.5}, {0.286, 530.9, 16.3, 31.1}},
                      z[] = {{1.217, 437.0, 11.8, 36.0}, {0.681, 459.0, 26.0, 13.8}};
    out_xyz[0] = sum_of(x, 3, nm);
    out_xyz[1] = sum_of(y, 2, nm);
    out_xyz[2] = sum_of(z, 2, nm);
}

void lf_xyz_to_rgb(const double xyz[3], double out_rgb[3])
{
    static const double to_rgb[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                        {-0.9692660, 1.8760108, 0.0415560},
                                        {0.0556434, -0.2040259, 1.0572252}};
    for (int i = 0; i < 3; i++)
        out_rgb[i] = to_rgb[i][0] * xyz[0] + to_rgb[i][1] * xyz[1] + to_rgb[i][2] * xyz[2];
}
