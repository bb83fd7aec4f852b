/* Shapes of homogeneous volumes; private to render/. A shape is one header (shape_box.h, …) with
 * three inline functions, and one line of LF_VOLUME_SHAPES with its #include below. No other code
 * knows its name. The functions are inline because vector loops intersect shapes: lf_shape_interval
 * and its siblings switch once, without function pointers.
 *
 * Every shape is convex, fills part of [-1,1]^3 of volume space, and has
 * lf_NAME_interval: the part [*from, *to] of the line o + t d inside the shape, any sign;
 *     *from >= *to: no intersection. No branches; d is never 0 in all components.
 * lf_NAME_contains: whether a point is inside.
 * lf_NAME_reach: the largest distance of the shape from its middle along an axis of another space,
 *     from that axis's row of the map. Exact. */
#ifndef LF_RENDER_SHAPE_H
#define LF_RENDER_SHAPE_H

#include "render/scene/shape_box.h"
#include "render/scene/shape_sphere.h"

/* All shapes, one line each: the name in the constant, and the name in the functions, which is also
 * the value of "shape" in a scene file. */
#define LF_VOLUME_SHAPES(SHAPE)                                                                    \
    SHAPE(SPHERE, sphere)                                                                          \
    SHAPE(BOX, box)

/* Kind of a volume: LF_VOLUME_GRID, or a shape, LF_VOLUME_SPHERE …, in the table's order. */
#define LF_VOLUME_CONSTANT(NAME, name) LF_VOLUME_##NAME,
typedef enum lf_volume_kind { LF_VOLUME_GRID, LF_VOLUME_SHAPES(LF_VOLUME_CONSTANT) } lf_volume_kind;
#undef LF_VOLUME_CONSTANT

/* The shapes' names, ended by NULL; LF_VOLUME_GRID + 1 first. */
extern const char *const lf_volume_shapes[];

static inline void lf_shape_interval(lf_volume_kind shape, const float o[3], const float d[3],
                                     float *from, float *to)
{
    switch (shape) {
#define LF_CASE(NAME, name)                                                                        \
    case LF_VOLUME_##NAME:                                                                         \
        lf_##name##_interval(o, d, from, to);                                                      \
        return;
        LF_VOLUME_SHAPES(LF_CASE)
#undef LF_CASE
    case LF_VOLUME_GRID:
        break;
    }
    *from = *to = 0.0f;
}

static inline bool lf_shape_contains(lf_volume_kind shape, const float p[3])
{
    switch (shape) {
#define LF_CASE(NAME, name)                                                                        \
    case LF_VOLUME_##NAME:                                                                         \
        return lf_##name##_contains(p);
        LF_VOLUME_SHAPES(LF_CASE)
#undef LF_CASE
    case LF_VOLUME_GRID:
        break;
    }
    return false;
}

/* Grids fill a box. */
static inline double lf_shape_reach(lf_volume_kind shape, const double row[3])
{
    switch (shape) {
#define LF_CASE(NAME, name)                                                                        \
    case LF_VOLUME_##NAME:                                                                         \
        return lf_##name##_reach(row);
        LF_VOLUME_SHAPES(LF_CASE)
#undef LF_CASE
    case LF_VOLUME_GRID:
        break;
    }
    return lf_box_reach(row);
}

#endif
