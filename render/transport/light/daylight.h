/* The sky and the sun of a clear or hazy day; private to render/. Preetham, Shirley and Smits, "A
 * Practical Analytic Model for Daylight" (SIGGRAPH 1999): luminance and chromaticity of the sky by
 * Perez's formula, from their appendix, and their spectrum of the sun after the atmosphere.
 *
 * Radiance here has a luminance of LF_LUMENS_A_WATT cd m^-2 for each W m^-2 sr^-1: the value for a
 * watt with a uniform spectrum between 380 and 780 nm. */
#ifndef LF_RENDER_DAYLIGHT_H
#define LF_RENDER_DAYLIGHT_H

#include <stdbool.h>

#define LF_LUMENS_A_WATT 179.0
/* Angular diameter of the sun in degrees, and the range of turbidity for which the model is made.
 */
#define LF_SUN_ANGLE 0.533
#define LF_LEAST_TURBIDITY 2.0
#define LF_MOST_TURBIDITY 10.0

/* A sky. In each pair of arrays, the first entry is for luminance, the others for chromaticity x
 * and y. */
typedef struct lf_daylight {
    double elevation;   /* of the sun, radians */
    double perez[3][5]; /* A to E */
    double scale[3];    /* of Perez's formula: cd m^-2 and chromaticities */
} lf_daylight;

/* elevation 0 .. pi/2. */
void lf_daylight_init(lf_daylight *sky, double turbidity, double elevation);

/* Radiance of the sky, linear Rec. 709 (never below 0), at a cosine from the zenith > 0 and a
 * cosine from the sun. */
void lf_daylight_radiance(const lf_daylight *sky, double cos_zenith, double cos_sun,
                          double out_rgb[3]);

/* Irradiance of the sun's disk on a plane perpendicular to its direction, in the same units and
 * colours. */
void lf_daylight_sun(double turbidity, double elevation, double out_rgb[3]);

/* Fills an image of all directions, with rows and columns as in lf_environment (height even) and
 * the sun's azimuth in the middle of the image. Below the horizon there is a uniform ground. It
 * reflects the share `ground` of the light from the sky and from a sun, whose irradiance is `sun`.
 */
void lf_daylight_paint(const lf_daylight *sky, const double ground[3], const double sun[3],
                       int width, int height, float *rgb);

#endif
