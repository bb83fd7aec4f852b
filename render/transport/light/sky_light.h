/* What lights at infinity do to a matte white surface, by its normal alone, as if nothing stood in
 * their way. Private to render/transport: sunlight.h makes a feature of it.
 *
 * Irradiance is so smooth in the normal that nine numbers tell it within a few percent: spherical
 * harmonics up to order 2 (Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance
 * Environment Maps", 2001). */
#ifndef LF_RENDER_SKY_LIGHT_H
#define LF_RENDER_SKY_LIGHT_H

#include "render/scene/scene.h"

enum { LF_SKY_HARMONICS = 9 };

/* Of the radiance that a white matte surface reflects, mean of the channels: coefficients, in the
 * order of the paper's equation 3. */
typedef struct lf_sky_light {
    float white[LF_SKY_HARMONICS];
} lf_sky_light;

/* Reads the lights at infinity of a committed scene: the same scene, the same numbers. All 0 where
 * it has none. Takes about a millisecond a light. */
void lf_sky_light_init(lf_sky_light *light, const lf_scene *scene);

/* Radiance that a white matte surface with the unit normal n reflects; never below 0. */
float lf_sky_light_white(const lf_sky_light *light, lf_vec3 n);
/* The mean of that over all normals. */
float lf_sky_light_mean(const lf_sky_light *light);

#endif
