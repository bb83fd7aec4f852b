/* Directions in volume space, segments that may meet a surface, and shadow rays through surfaces;
 * private to suffix_lanes.h. */
#ifndef LF_RENDER_SUFFIX_SURFACE_LANES_H
#define LF_RENDER_SUFFIX_SURFACE_LANES_H

#include "render/transport/lanes/lanes.h"
#include "render/transport/lanes/suffix.h"

/* Whether q + t d, volume space, 0 <= t <= end, passes through the box of a mesh. */
LF_INLINE mask may_meet(const lf_lane_boxes *boxes, const lanes q[3], const lanes d[3], lanes end)
{
    mask any = mask_of(0);
    lanes inverse[3];
    for (int i = 0; i < 3; i++)
        inverse[i] = inverse_of(d[i]);
    for (int b = 0; b < boxes->n; b++) {
        lanes first = all(0.0f), last = end;
        for (int i = 0; i < 3; i++) {
            lanes near = (boxes->min[b][i] - q[i]) * inverse[i],
                  far = (boxes->max[b][i] - q[i]) * inverse[i];
            first = most(least(near, far), first);
            last = least(most(near, far), last);
        }
        any = either(any, is_at_most(first, last));
    }
    return any;
}

/* One axis of a scene direction in volume space. */
LF_INLINE lanes along_axis(const lf_lane_scene *scene, int axis, const lanes w[3])
{
    const float *row = scene->to_volume[axis];
    return row[0] * w[0] + row[1] * w[1] + row[2] * w[2];
}

/* Multiplies the transmittance of shadow rays through media by the transmittance of surfaces. */
LF_INLINE void pass_surfaces(const lf_lane_scene *scene, lf_lane_memory *memory, unsigned has)
{
    const int words = (int)(sizeof *memory->shadow_ray / sizeof(float));
    for (int first = 0; first < memory->n; first += LF_WIDTH) {
        const lanes_int at = (count_up() + first) * words;
        lanes q[3], w[3], d[3];
        for (int i = 0; i < 3; i++) {
            q[i] = gather(memory->shadow_ray->q + i, at);
            w[i] = has & LF_LANE_SKY ? load(memory->w[i] + first) : all(scene->toward[i]);
        }
        for (int i = 0; i < 3; i++)
            d[i] = along_axis(scene, i, w);
        mask m = both(may_meet(&scene->boxes, q, d, all(INFINITY)),
                      is_less(all(0.0f), load(memory->left + first)));
        for (unsigned b = bits_of(m); b; b &= b - 1) {
            const int k = __builtin_ctz(b);
            if (first + k >= memory->n)
                break;
            const float along[3] = {w[0][k], w[1][k], w[2][k]};
            memory->left[first + k] *= memory->surfaces.passed(
                memory->surfaces.of, memory->shadow_ray[first + k].q, along);
        }
    }
}

#endif
