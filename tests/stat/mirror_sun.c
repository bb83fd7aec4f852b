#include "tests/stat/mirror_sun.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void unit(const double a[3], double sign, double out[3])
{
    double scale = sign / sqrt(dot(a, a));
    for (int k = 0; k < 3; k++)
        out[k] = scale * a[k];
}

lf_mirror_sun lf_mirror_sun_scene(double angle)
{
    return (lf_mirror_sun){.centre = {-3, 0.2, 1.5},
                           .u = {-0.05, 0.43, 0},
                           .v = {-0.15, 0, 0.36},
                           .direction = {-0.3, -0.2, -0.93},
                           .irradiance = 2,
                           .angle = angle,
                           .rings = 12};
}

double lf_mirror_sun_direct(const lf_mirror_sun *scene)
{
    double to[3];
    unit(scene->direction, -1.0, to);
    return scene->irradiance * to[2];
}

/* Schlick's approximation of a metal. */
static double reflectance(double cosine)
{
    return LF_MIRROR_SUN_MIRROR + (1.0 - LF_MIRROR_SUN_MIRROR) * pow(1.0 - fabs(cosine), 5.0);
}

/* What a sun in the direction `to` of this irradiance sends to p by way of the mirror. */
static double through_mirror(const lf_mirror_sun *scene, const double p[3], const double to[3])
{
    double across[3], n[3], mirrored[3], from[3], at[3], un[3], vn[3];
    cross(scene->u, scene->v, across);
    unit(across, 1.0, n);
    for (int k = 0; k < 3; k++) {
        mirrored[k] = to[k] - 2.0 * dot(to, n) * n[k];
        from[k] = scene->centre[k] - p[k];
    }
    double t = dot(from, n) / dot(mirrored, n);
    if (!(t > 0.0 && mirrored[2] > 0.0))
        return 0.0;
    for (int k = 0; k < 3; k++)
        at[k] = t * mirrored[k] - from[k];
    cross(scene->v, n, un);
    cross(scene->u, n, vn);
    if (fabs(dot(at, un) / dot(scene->u, un)) > 1.0 || fabs(dot(at, vn) / dot(scene->v, vn)) > 1.0)
        return 0.0;
    return reflectance(dot(to, n)) * mirrored[2];
}

/* A direction at the polar angle with this cosine from the middle of the sun. */
static void towards_sun(const double axis[3], double cosine, double turn, double out[3])
{
    const double aside[3] = {axis[1], axis[2], axis[0]};
    double a[3], x[3], y[3], sine = sqrt(1.0 - cosine * cosine);
    cross(axis, aside, a);
    unit(a, 1.0, x);
    cross(axis, x, y);
    for (int k = 0; k < 3; k++)
        out[k] = cosine * axis[k] + sine * (cos(turn) * x[k] + sin(turn) * y[k]);
}

double lf_mirror_sun_reflected(const lf_mirror_sun *scene, double x, double y)
{
    const double p[3] = {x, y, 0.0};
    double to[3], axis[3], sum = 0.0;
    unit(scene->direction, -1.0, axis);
    if (!(scene->angle > 0.0))
        return scene->irradiance * through_mirror(scene, p, axis);
    double radius = 0.5 * scene->angle * M_PI / 180.0, rest = 2.0 * pow(sin(0.5 * radius), 2.0);
    for (int ring = 0, before = 0; ring < scene->rings; ring++) {
        int parts = 6 * ring + 3, all = 3 * scene->rings * scene->rings;
        double cosine = 1.0 - rest * (before + 0.5 * parts) / all;
        for (int i = 0; i < parts; i++) {
            towards_sun(axis, cosine, 2.0 * M_PI * (i + 0.5) / parts, to);
            sum += through_mirror(scene, p, to) / all;
        }
        before += parts;
    }
    /* radiance times solid angle, irradiance / (pi sin^2) 2 pi (1 - cos) */
    return scene->irradiance * sum * 2.0 * rest / pow(sin(radius), 2.0);
}

double lf_mirror_sun_power(const lf_mirror_sun *scene)
{
    double across[3], n[3], to[3];
    cross(scene->u, scene->v, across);
    unit(across, 1.0, n);
    unit(scene->direction, -1.0, to);
    double cosine = fabs(dot(to, n));
    return scene->irradiance * 4.0 * sqrt(dot(across, across)) * cosine * reflectance(cosine);
}

/* ------------------------------------------------------------------------------ sky pictures -- */

lf_mirror_sky lf_mirror_sky_scene(void)
{
    return (lf_mirror_sky){.rows = 128, .row = 55, .column = 243, .radiance = 3392, .parts = 8};
}

/* Part (i, j) of the texel's tent: its direction, and its radiance times solid angle. */
static double tent(const lf_mirror_sky *sky, int i, int j, double out_to[3])
{
    double a = 2.0 * (i + 0.5) / sky->parts - 1.0, b = 2.0 * (j + 0.5) / sky->parts - 1.0,
           step = M_PI / sky->rows, side = 2.0 * step / sky->parts;
    double theta = step * (sky->row + 0.5 + b), phi = step * (sky->column + 0.5 + a) - M_PI;
    /* the middle of the picture is towards -z, and columns run to the right of it */
    out_to[0] = sin(theta) * sin(phi);
    out_to[1] = cos(theta);
    out_to[2] = -sin(theta) * cos(phi);
    return sky->radiance * (1.0 - fabs(a)) * (1.0 - fabs(b)) * side * side * sin(theta);
}

double lf_mirror_sky_direct(const lf_mirror_sky *sky)
{
    double sum = 0.0, to[3];
    for (int i = 0; i < sky->parts; i++)
        for (int j = 0; j < sky->parts; j++) {
            double light = tent(sky, i, j, to);
            sum += light * to[2];
        }
    return sum;
}

double lf_mirror_sky_reflected(const lf_mirror_sun *scene, const lf_mirror_sky *sky, double x,
                               double y)
{
    const double p[3] = {x, y, 0.0};
    double sum = 0.0, to[3];
    for (int i = 0; i < sky->parts; i++)
        for (int j = 0; j < sky->parts; j++) {
            double light = tent(sky, i, j, to);
            sum += light * through_mirror(scene, p, to);
        }
    return sum;
}
