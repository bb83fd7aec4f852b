/* What volumes emit, along a ray; private to render/. Line emission: radiance per scene unit,
 * whether or not anything is there that collides. A field of temperatures glows as a black body
 * does: the colour is that of Planck's spectrum (observer.h), of luminance 1, and its brightness
 * goes as T^4 (Stefan and Boltzmann), 1 at LF_EMISSION_KELVIN. (That the eye sees but a part of
 * that, and of colder bodies less of it, is left out: a flame would show its hottest spot alone.)
 * docs/developer/estimators/volume-emission.md, "Black bodies". */
#ifndef LF_RENDER_VOLUME_EMISSION_H
#define LF_RENDER_VOLUME_EMISSION_H

#include "render/scene/scene.h"

#define LF_EMISSION_KELVIN 1500.0

/* Linear Rec. 709 colour of a black body, luminance 1, what lies outside of the gamut brought to
 * its edge; below 700 K that of 700 K. */
void lf_black_body(double kelvin, double out_rgb[3]);

/* Fills all but `volume`: what a value of 1 emits, or (kelvin > 0) a black body of
 * LF_EMISSION_KELVIN, where a value of 1 stands for so many kelvin. most: the largest value.
 * Returns the largest channel of what that emits. */
double lf_volume_emission_init(lf_volume_emission *light, lf_vec3 colour, double kelvin,
                               double most);

/* Radiance per scene unit where the field has this value, 0 .. the largest. */
static inline lf_vec3 lf_emission_radiance(const lf_volume_emission *light, float value)
{
    if (!(light->per_value > 0.0f))
        return lf_scale(light->colour, value);
    float at = value * light->per_value, share = value * light->inverse, square = share * share;
    int i = (int)lf_min(at, LF_EMISSION_STEPS - 1);
    const lf_vec3 *step = &light->table[i];
    return lf_scale(lf_madd(step[0], at - (float)i, lf_sub(step[1], step[0])), square * square);
}

/* About how bright a value is, above 0 where it is: what samples are drawn by. */
static inline float lf_emission_power(const lf_volume_emission *light, float value)
{
    float share = value * light->inverse, square = share * share;
    return light->per_value > 0.0f ? square * square : share;
}

#endif
