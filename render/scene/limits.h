/* How large the numbers of a scene may be, and why; private to render/. Everything that reaches a
 * ray of Embree is bounded here: Embree ends the program (an assertion, in Debian's build) when a
 * component of a ray is beyond 1.844e18 or is no number.
 *
 * A number of a file is at most LF_MAX_COORDINATE. What is put together of several (a shape that is
 * scaled and moved, an instance of an instance, a volume in a unit of its own) lies within
 * LF_MAX_REACH, or is refused, or left out with a warning. It is a little more than one number, so
 * that a ground with a scale of 1e9 may stand anywhere near the origin, and so little that squared
 * areas are finite in single precision: sides of at most 2.2e9 along each axis have a cross product
 * of at most 2 (2.2e9)^2 = 9.7e18 along each, and the squares of three are 2.8e38 (of 3.4e38).
 *
 * Where rays begin follows: in surfaces and media, within LF_MAX_REACH; at cameras, which stand at
 * most 5e9 from the origin (a path through keys overshoots) and look at most 1e10 far, and whose
 * rig is D tan(80 degrees) wide to each side: 1e11. A camera that lf_camera_fit moves back looks
 * 1e13 far. Directions are unit vectors, or lead from one such point to another, or are a slope of
 * at most LF_MAX_COORDINATE (half a track, a lens) over LF_MIN_DISTANCE: 1e18, which Embree takes.
 *
 * A ray in the space of an instance has the inverse's entries times that. An inverse has entries of
 * at most LF_MAX_INVERSE: what a thing of 1e-12 has in a scene of metres. The product with the
 * above may be 1e25 and more. So instances.c starts such a ray beside the instance, where its
 * coordinates are those of the mesh, and gives it a unit direction where it would be longer than
 * LF_MAX_STRETCH or shorter than its inverse. Volumes are met in single precision, by no library:
 * 1e12 times 1e13 is a number there. */
#ifndef LF_RENDER_LIMITS_H
#define LF_RENDER_LIMITS_H

#include <math.h>
#include <stdbool.h>

#define LF_MAX_COORDINATE 1e9
#define LF_MAX_REACH 1.1e9
#define LF_MIN_DISTANCE 1e-9 /* of a camera from its target, and of what it focuses on */
#define LF_MAX_INVERSE 1e12
#define LF_MAX_STRETCH 1e12

/* Of the sum of a ray's components: below Embree's limit for each. */
#define LF_MAX_RAY 1.8e18f

/* Whether a box (lower corner, upper corner) is finite and lies within LF_MAX_REACH. An empty one,
 * from INFINITY to -INFINITY, does. */
static inline bool lf_is_within_reach(const double box[2][3])
{
    bool within = true;
    for (int i = 0; i < 3; i++)
        within = within && box[0][i] >= -LF_MAX_REACH && box[1][i] <= LF_MAX_REACH;
    return within;
}

#endif
