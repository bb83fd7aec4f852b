#include "render/transport/light/volume_emission.h"

#include <math.h>

#include "render/transport/light/observer.h"

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
    static const double luminance[3] = {0.2126, 0.7152, 0.0722};
    const double coldest =
        700.0; /* for colder bodies the visible part is only the tails of the fit */
    double sum[3] = {0.0}, rgb[3], bright = 0.0;
    kelvin = fmax(kelvin, coldest);
    for (int nm = 380; nm <= 780; nm += 2) {
        double xyz[3], power = planck(nm, kelvin);
        lf_observer(nm, xyz);
        for (int i = 0; i < 3; i++)
            sum[i] += power * xyz[i];
    }
    lf_xyz_to_rgb(sum, rgb);
    for (int i = 0; i < 3; i++) {
        out_rgb[i] = fmax(rgb[i], 0.0);
        bright += luminance[i] * out_rgb[i];
    }
    for (int i = 0; i < 3; i++)
        out_rgb[i] /= bright;
}

double lf_volume_emission_init(lf_volume_emission *light, lf_vec3 colour, double kelvin,
                               double most)
{
    const double channel[3] = {(double)colour.x, (double)colour.y, (double)colour.z};
    double power = most, brightest = 0.0;
    light->colour = colour;
    light->inverse = most > 0.0 ? (float)(1.0 / most) : 0.0f;
    light->per_value = 0.0f;
    if (kelvin > 0.0 && most > 0.0) {
        light->per_value = (float)(LF_EMISSION_STEPS / most);
        power = pow(kelvin * most / LF_EMISSION_KELVIN, 4.0);
    }
    for (int i = 0; i <= LF_EMISSION_STEPS; i++) {
        double rgb[3] = {1.0, 1.0, 1.0};
        if (light->per_value > 0.0f)
            lf_black_body(kelvin * most * i / LF_EMISSION_STEPS, rgb);
        for (int j = 0; j < 3; j++) {
            rgb[j] *= channel[j] * power;
            brightest = fmax(brightest, i == LF_EMISSION_STEPS ? rgb[j] : 0.0);
        }
        light->table[i] = lf_v3((float)rgb[0], (float)rgb[1], (float)rgb[2]);
    }
    return brightest;
}
