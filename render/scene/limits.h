/* Limits of a scene's numbers, and their reasons; private to render/. They bound everything that
 * reaches a ray of Embree: Embree ends the program (an assertion, in Debian's build) if a component
 * of a ray is beyond 1.844e18 or NaN.
 *
 * A number in a file is at most LF_MAX_COORDINATE. Combinations (a shape that is scaled and moved,
 * an instance of an instance, a volume with its own unit) must lie within LF_MAX_REACH. Otherwise
 * they are refused, or skipped with a warning. LF_MAX_REACH is a little above LF_MAX_COORDINATE, so
 * that a ground with a scale of 1e9 may be anywhere near the origin. It is small enough that
 * squared areas are finite in single precision. Sides of at most 2.2e9 along each axis have a cross
 * product of at most 2 (2.2e9)^2 = 9.7e18 along each; the squares of three are 2.8e38 (limit
 * 3.4e38).
 *
 * Origins of rays follow from this. In surfaces and media they lie within LF_MAX_REACH. Cameras are
 * at most 5e9 from the origin (an interpolated path overshoots its keys), look at most 1e10 far,
 * and have a rig D tan(80 degrees) wide to each side: 1e11. A camera that lf_camera_fit moves back
 * looks 1e13 far. Directions are unit vectors, or lead from one such point to another, or have a
 * slope of at most LF_MAX_COORDINATE (half a track, a lens) over LF_MIN_DISTANCE: 1e18, which
 * Embree accepts.
 *
 * A ray in the space of an instance is this times the entries of the inverse transform. These are
 * at most LF_MAX_INVERSE, as for an object of 1e-12 in a scene of metres. The product may be 1e25
 * and more. So instances.c starts such a ray near the instance, where its coordinates are as small
 * as the mesh's. It normalises a direction that would be longer than LF_MAX_STRETCH or shorter than
 * 1 / LF_MAX_STRETCH. Volumes are intersected in single precision without a library: 1e12 times
 * 1e13 is finite there. */
#ifndef LF_RENDER_LIMITS_H
#define LF_RENDER_LIMITS_H

#include <math.h>
#include <stdbool.h>

#define LF_MAX_COORDINATE 1e9
#define LF_MAX_REACH 1.1e9
#define LF_MIN_DISTANCE 1e-9 /* from a camera to its target and to its focus */
#define LF_MAX_INVERSE 1e12
#define LF_MAX_STRETCH 1e12

/* Limit for the sum of a ray's components, below Embree's limit for each. */
#define LF_MAX_RAY 1.8e18f

/* Whether a box (lower corner, upper corner) is finite and lies within LF_MAX_REACH. true for an
 * empty box, from INFINITY to -INFINITY. */
static inline bool lf_is_within_reach(const double box[2][3])
{
    bool within = true;
    for (int i = 0; i < 3; i++)
        within = within && box[0][i] >= -LF_MAX_REACH && box[1][i] <= LF_MAX_REACH;
    return within;
}

#endif
