#include "render/plane/body.h"

/* Whether all corners of the volume's box lie on one side of the plane, or behind the cameras. */
static bool misses(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane)
{
    float lowest = INFINITY, highest = -INFINITY, farthest = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        lf_vec3 p = lf_v3(corner & 1 ? volume->bounds_max.x : volume->bounds_min.x,
                          corner & 2 ? volume->bounds_max.y : volume->bounds_min.y,
                          corner & 4 ? volume->bounds_max.z : volume->bounds_min.z);
        lf_vec3 d = lf_sub(p, rig->eye);
        float z = lf_dot(d, rig->forward), above = lf_dot(d, rig->up) - (plane->ly + plane->my * z);
        lowest = lf_min(lowest, above);
        highest = lf_max(highest, above);
        farthest = lf_max(farthest, z);
    }
    return lowest > 0.0f || highest < 0.0f || farthest <= 0.0f;
}

bool lf_body_rays(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane,
                  float origin[3], float across[3], float depth[3])
{
    lf_vec3 o = lf_rig_point(rig, 0.0f, plane->ly, 0.0f),
            d = lf_rig_direction(rig, 0.0f, plane->my, 1.0f);
    if (misses(volume, rig, plane))
        return false;
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        origin[i] = m[0] * o.x + m[1] * o.y + m[2] * o.z + m[3];
        across[i] = m[0] * rig->right.x + m[1] * rig->right.y + m[2] * rig->right.z;
        depth[i] = m[0] * d.x + m[1] * d.y + m[2] * d.z;
    }
    return true;
}

bool lf_body_cut(lf_body *body, const lf_volume *volume, const lf_rig *rig,
                 const lf_row_plane *plane)
{
    body->shape = volume->kind;
    body->sigma_t = volume->sigma_scale;
    return lf_body_rays(volume, rig, plane, body->origin, body->across, body->depth);
}
