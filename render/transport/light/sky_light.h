/* Light from infinity on a matte white surface, as a function of its normal only, without
 * occlusion. Private to render/transport: sunlight.h makes a feature from it.
 *
 * Irradiance is so smooth in the normal that nine numbers represent it within a few percent:
 * spherical harmonics up to order 2 (Ramamoorthi and Hanrahan, "An Efficient Representation for
 * Irradiance Environment Maps", 2001). */
#ifndef LF_RENDER_SKY_LIGHT_H
#define LF_RENDER_SKY_LIGHT_H

#include "render/scene/scene.h"

enum { LF_SKY_HARMONICS = 9 };

/* Coefficients of the radiance that a white matte surface reflects, mean of the channels, in the
 * order of the paper's equation 3. */
typedef struct lf_sky_light {
    float white[LF_SKY_HARMONICS];
} lf_sky_light;

/* Computed from the lights at infinity of a committed scene, deterministic. All 0 without such
 * lights. Takes about a millisecond per light. */
void lf_sky_light_init(lf_sky_light *light, const lf_scene *scene);

/* Radiance that a white matte surface with the unit normal n reflects; never below 0. */
float lf_sky_light_white(const lf_sky_light *light, lf_vec3 n);
/* The mean of lf_sky_light_white over all normals. */
float lf_sky_light_mean(const lf_sky_light *light);

#endif
