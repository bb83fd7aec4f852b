#include "render/transport/flame.h"

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

/* The CIE 1931 observer (flame.h). */
static void observer(double nm, double out_xyz[3])
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

/* Planck's spectrum over its value at the red end. */
static double planck(double nm, double kelvin)
{
    const double c2 = 1.438776877e7, end = 780.0; /* nm K */
    double x = c2 / (nm * kelvin), x_end = c2 / (end * kelvin), ratio = end / nm,
           square = ratio * ratio;
    return square * square * ratio * exp(x_end - x) * (-expm1(-x_end) / -expm1(-x));
}

void lf_black_body(double kelvin, double out_rgb[3])
{
    /* IEC 61966-2-1 */
    static const double to_rgb[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                        {-0.9692660, 1.8760108, 0.0415560},
                                        {0.0556434, -0.2040259, 1.0572252}},
                        luminance[3] = {0.2126, 0.7152, 0.0722};
    const double coldest =
        700.0; /* of colder ones the eye sees what the fit's tails are made up of */
    double sum[3] = {0.0}, bright = 0.0;
    kelvin = fmax(kelvin, coldest);
    for (int nm = 380; nm <= 780; nm += 2) {
        double xyz[3], power = planck(nm, kelvin);
        observer(nm, xyz);
        for (int i = 0; i < 3; i++)
            sum[i] += power * xyz[i];
    }
    for (int i = 0; i < 3; i++) {
        double c = to_rgb[i][0] * sum[0] + to_rgb[i][1] * sum[1] + to_rgb[i][2] * sum[2];
        out_rgb[i] = fmax(c, 0.0);
        bright += luminance[i] * out_rgb[i];
    }
    for (int i = 0; i < 3; i++)
        out_rgb[i] /= bright;
}

double lf_flame_light_init(lf_flame_light *light, lf_vec3 colour, double kelvin, double most)
{
    const double channel[3] = {(double)colour.x, (double)colour.y, (double)colour.z};
    double power = most, brightest = 0.0;
    light->colour = colour;
    light->inverse = most > 0.0 ? (float)(1.0 / most) : 0.0f;
    light->per_value = 0.0f;
    if (kelvin > 0.0 && most > 0.0) {
        light->per_value = (float)(LF_FLAME_STEPS / most);
        power = pow(kelvin * most / LF_FLAME_KELVIN, 4.0);
    }
    for (int i = 0; i <= LF_FLAME_STEPS; i++) {
        double rgb[3] = {1.0, 1.0, 1.0};
        if (light->per_value > 0.0f)
            lf_black_body(kelvin * most * i / LF_FLAME_STEPS, rgb);
        for (int j = 0; j < 3; j++) {
            rgb[j] *= channel[j] * power;
            brightest = fmax(brightest, i == LF_FLAME_STEPS ? rgb[j] : 0.0);
        }
        light->table[i] = lf_v3((float)rgb[0], (float)rgb[1], (float)rgb[2]);
    }
    return brightest;
}
