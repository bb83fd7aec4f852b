#include "render/transport/light/daylight.h"

#include <math.h>
#include <stddef.h>

#include "render/transport/light/observer.h"

/* ----------------------------------------------------------------------------------- the sky -- */

static double perez(const double c[5], double cos_zenith, double sun, double cos_sun)
{
    return (1.0 + c[0] * exp(c[1] / cos_zenith)) *
           (1.0 + c[2] * exp(c[3] * sun) + c[4] * cos_sun * cos_sun);
}

/* Luminance (cd m^-2) and chromaticities of the zenith, appendix A.2; s: the sun's angle from it.
 */
static void zenith(double t, double s, double out[3])
{
    static const double chroma[2][3][4] = {{{0.00166, -0.00375, 0.00209, 0.0},
                                            {-0.02903, 0.06377, -0.03202, 0.00394},
                                            {0.11693, -0.21196, 0.06052, 0.25886}},
                                           {{0.00275, -0.00610, 0.00317, 0.0},
                                            {-0.04214, 0.08970, -0.04153, 0.00516},
                                            {0.15346, -0.26756, 0.06670, 0.26688}}};
    double chi = (4.0 / 9.0 - t / 120.0) * (M_PI - 2.0 * s);
    out[0] = 1e3 * ((4.0453 * t - 4.9710) * tan(chi) - 0.2155 * t + 2.4192);
    for (int i = 0; i < 2; i++) {
        out[1 + i] = 0.0;
        for (int j = 0; j < 3; j++) {
            const double *c = chroma[i][j];
            out[1 + i] = out[1 + i] * t + ((c[0] * s + c[1]) * s + c[2]) * s + c[3];
        }
    }
}

void lf_daylight_init(lf_daylight *sky, double turbidity, double elevation)
{
    /* Appendix A.2: a T + b. */
    static const double distribution[3][5][2] = {{{0.1787, -1.4630},
                                                  {-0.3554, 0.4275},
                                                  {-0.0227, 5.3251},
                                                  {0.1206, -2.5771},
                                                  {-0.0670, 0.3703}},
                                                 {{-0.0193, -0.2592},
                                                  {-0.0665, 0.0008},
                                                  {-0.0004, 0.2125},
                                                  {-0.0641, -0.8989},
                                                  {-0.0033, 0.0452}},
                                                 {{-0.0167, -0.2608},
                                                  {-0.0950, 0.0092},
                                                  {-0.0079, 0.2102},
                                                  {-0.0441, -1.6537},
                                                  {-0.0109, 0.0529}}};
    double s = 0.5 * M_PI - elevation;
    sky->elevation = elevation;
    zenith(turbidity, s, sky->scale);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 5; j++)
            sky->perez[i][j] = distribution[i][j][0] * turbidity + distribution[i][j][1];
        sky->scale[i] /= perez(sky->perez[i], 1.0, s, cos(s));
    }
}

void lf_daylight_radiance(const lf_daylight *sky, double cos_zenith, double cos_sun,
                          double out_rgb[3])
{
    double sun = acos(fmin(fmax(cos_sun, -1.0), 1.0)), v[3];
    for (int i = 0; i < 3; i++)
        v[i] = sky->scale[i] * perez(sky->perez[i], cos_zenith, sun, cos_sun);
    double bright = v[0] / LF_LUMENS_A_WATT, x = v[1], y = v[2];
    const double xyz[3] = {bright * x / y, bright, bright * (1.0 - x - y) / y};
    lf_xyz_to_rgb(xyz, out_rgb);
    for (int i = 0; i < 3; i++)
        out_rgb[i] = fmax(out_rgb[i], 0.0);
}

/* ----------------------------------------------------------------------------------- the sun -- */

enum { FIRST = 380, STEP = 10, N_BANDS = 38 };

/* Transmittance of the atmosphere at this wavelength, appendix A.1; mass: path length through the
 * atmosphere over that from the zenith. The tables are the paper's table 2: ozone from 450 nm on,
 * water vapour from 690 nm on, both per centimetre; mixed gases begin at 760 nm, after the last
 * band. */
static double transmittance(int nm, double turbidity, double mass)
{
    static const double ozone[] = {0.003, 0.006, 0.009, 0.014, 0.021, 0.030, 0.040, 0.048,
                                   0.063, 0.075, 0.085, 0.103, 0.120, 0.120, 0.115, 0.125,
                                   0.120, 0.105, 0.090, 0.079, 0.067, 0.057, 0.048, 0.036,
                                   0.028, 0.023, 0.018, 0.014, 0.011, 0.010, 0.009},
                        vapour[] = {0.016, 0.024, 0.0125, 1.0, 0.87, 0.061, 0.001};
    const double ozone_cm = 0.35, vapour_cm = 2.0, um = 1e-3 * nm;
    double depth = 0.008735 * pow(um, -4.08) + (0.04608 * turbidity - 0.04586) * pow(um, -1.3);
    if (nm >= 450)
        depth += ozone[(nm - 450) / STEP] * ozone_cm;
    depth *= mass;
    if (nm >= 690) {
        double k = vapour[(nm - 690) / STEP] * vapour_cm * mass;
        depth += 0.2385 * k / pow(1.0 + 20.07 * k, 0.45);
    }
    return exp(-depth);
}

void lf_daylight_sun(double turbidity, double elevation, double out_rgb[3])
{
    /* Outside of the air, W cm^-2 um^-1 sr^-1: table 2. */
    static const double radiance[N_BANDS] = {
        1655.9,  1623.37, 2112.75, 2588.82, 2582.91, 2423.23, 2676.05, 2965.83, 3054.54, 3005.75,
        3066.37, 2883.04, 2871.21, 2782.5,  2710.06, 2723.36, 2636.13, 2550.38, 2506.02, 2531.16,
        2535.59, 2513.42, 2463.15, 2417.32, 2368.53, 2321.21, 2282.77, 2233.98, 2197.02, 2152.67,
        2109.79, 2072.83, 2024.04, 1987.08, 1942.72, 1907.24, 1862.89, 1825.92};
    const double per_nm = 10.0, lumens_a_watt = 683.0; /* W m^-2 nm^-1 sr^-1; at 555 nm */
    double degrees = elevation * 180.0 / M_PI,
           mass = 1.0 / (sin(elevation) + 0.15 * pow(3.885 + degrees, -1.253));
    double across = M_PI * pow(sin(0.5 * LF_SUN_ANGLE * M_PI / 180.0), 2.0), xyz[3] = {0.0};
    for (int i = 0; i < N_BANDS; i++) {
        double seen[3], light = radiance[i] * transmittance(FIRST + STEP * i, turbidity, mass);
        lf_observer(FIRST + STEP * i, seen);
        for (int j = 0; j < 3; j++)
            xyz[j] += light * seen[j];
    }
    for (int j = 0; j < 3; j++)
        xyz[j] *= per_nm * STEP * across * lumens_a_watt / LF_LUMENS_A_WATT;
    lf_xyz_to_rgb(xyz, out_rgb);
    for (int j = 0; j < 3; j++)
        out_rgb[j] = fmax(out_rgb[j], 0.0);
}

/* ------------------------------------------------------------------------------------ images -- */

/* A row above the horizon, both halves the same; adds what the row gives a horizontal plane. */
static void paint_row(const lf_daylight *sky, int row, int width, int height, float *rgb,
                      double irradiance[3])
{
    double upper = M_PI * row / height, lower = M_PI * (row + 1) / height,
           theta = 0.5 * (upper + lower),
           projected = M_PI * (pow(sin(lower), 2.0) - pow(sin(upper), 2.0)) / width;
    for (int x = 0; x < (width + 1) / 2; x++) {
        double phi = 2.0 * M_PI * (x + 0.5) / width, c[3];
        /* The sun is at phi = pi. */
        double cos_sun =
            cos(theta) * sin(sky->elevation) - sin(theta) * cos(sky->elevation) * cos(phi);
        lf_daylight_radiance(sky, cos(theta), cos_sun, c);
        for (int i = 0; i < 3; i++) {
            rgb[3 * x + i] = rgb[3 * (width - 1 - x) + i] = (float)c[i];
            irradiance[i] += (2 * x + 1 == width ? 1.0 : 2.0) * projected * c[i];
        }
    }
}

void lf_daylight_paint(const lf_daylight *sky, const double ground[3], const double sun[3],
                       int width, int height, float *rgb)
{
    double irradiance[3];
    for (int i = 0; i < 3; i++)
        irradiance[i] = sun[i] * sin(sky->elevation);
    for (int y = 0; y < height / 2; y++)
        paint_row(sky, y, width, height, rgb + 3 * (size_t)y * (size_t)width, irradiance);
    for (int y = height / 2; y < height; y++) {
        float *row = rgb + 3 * (size_t)y * (size_t)width;
        for (int x = 0; x < width; x++)
            for (int i = 0; i < 3; i++)
                row[3 * x + i] = (float)(ground[i] * irradiance[i] / M_PI);
    }
}
