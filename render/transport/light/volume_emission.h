/* Volume emission along a ray; private to render/. Line emission: radiance per scene unit,
 * independent of extinction. A field of temperatures emits as a black body. Its colour is from
 * Planck's spectrum (observer.h), scaled to luminance 1. Its brightness is proportional to T^4
 * (Stefan and Boltzmann), 1 at LF_EMISSION_KELVIN. The fact that the eye sees only a part of this,
 * and a smaller part for colder bodies, is ignored: otherwise a fire would show only its hottest
 * spot. docs/developer/estimators/volume-emission.md, "Black bodies". */
#ifndef LF_RENDER_VOLUME_EMISSION_H
#define LF_RENDER_VOLUME_EMISSION_H

#include "render/scene/scene.h"

#define LF_EMISSION_KELVIN 1500.0

/* Linear Rec. 709 colour of a black body, luminance 1, clipped to the gamut; below 700 K the colour
 * for 700 K. */
void lf_black_body(double kelvin, double out_rgb[3]);

/* Fills all fields except `volume`. kelvin 0: a value of 1 emits colour. kelvin > 0 (the
 * temperature scale): a value of 1 is this many kelvin, and a black body of LF_EMISSION_KELVIN
 * emits colour. most: the largest value. Returns the largest channel of its emission. */
double lf_volume_emission_init(lf_volume_emission *light, lf_vec3 colour, double kelvin,
                               double most);

/* Radiance per scene unit for this value of the field, 0 .. the largest. */
static inline lf_vec3 lf_emission_radiance(const lf_volume_emission *light, float value)
{
    if (!(light->per_value > 0.0f))
        return lf_scale(light->colour, value);
    float at = value * light->per_value, share = value * light->inverse, square = share * share;
    int i = (int)lf_min(at, LF_EMISSION_STEPS - 1);
    const lf_vec3 *step = &light->table[i];
    return lf_scale(lf_madd(step[0], at - (float)i, lf_sub(step[1], step[0])), square * square);
}

/* Approximate brightness of a value, above 0 for values above 0; samples are drawn in proportion to
 * it. */
static inline float lf_emission_power(const lf_volume_emission *light, float value)
{
    float share = value * light->inverse, square = share * share;
    return light->per_value > 0.0f ? square * square : share;
}

#endif
