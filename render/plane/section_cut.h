/* A triangle cut by a row's plane; private to render/plane/. */
#ifndef LF_RENDER_SECTION_CUT_H
#define LF_RENDER_SECTION_CUT_H

#include "render/plane/section.h"

/* Surfaces nearer than this many D hide nothing: a camera would have to touch them. */
#define LF_SECTION_NEAR 1e-7

/* A corner of a triangle: position, and height above the plane. */
typedef struct lf_cut_corner {
    double x, z, height;
} lf_cut_corner;

/* Coordinate of a point along one of the rig's axes. In double, because heights above the plane are
 * small differences; the same arithmetic for corners and pivots. */
static inline double lf_cut_along(const lf_rig *rig, lf_vec3 axis, lf_vec3 p)
{
    return ((double)p.x - (double)rig->eye.x) * (double)axis.x +
           ((double)p.y - (double)rig->eye.y) * (double)axis.y +
           ((double)p.z - (double)rig->eye.z) * (double)axis.z;
}

static inline void lf_cut_to_camera(const lf_rig *rig, lf_vec3 p, double out[3])
{
    out[0] = lf_cut_along(rig, rig->right, p);
    out[1] = lf_cut_along(rig, rig->up, p);
    out[2] = lf_cut_along(rig, rig->forward, p);
}

/* d of a depth (section.h). */
static inline float lf_cut_to_d(const lf_rig *rig, double z)
{
    double window = (double)rig->window;
    return (float)((window - z) / (z * window));
}

/* The depth of a d. */
static inline float lf_cut_depth(const lf_rig *rig, float d)
{
    return rig->window / (d * rig->window + 1.0f);
}

/* The point where an edge crosses the plane, always computed from above to below, so that triangles
 * that share the edge get the same bits. */
static inline lf_cut_corner lf_cut_crossing(lf_cut_corner a, lf_cut_corner b)
{
    lf_cut_corner above = a.height >= 0.0 ? a : b, below = a.height >= 0.0 ? b : a;
    double t = above.height / (above.height - below.height);
    return (lf_cut_corner){above.x + t * (below.x - above.x), above.z + t * (below.z - above.z),
                           0.0};
}

/* The ends of the segment that plane and triangle share, in front of the cameras. above: number of
 * corners that are not below the plane. false: they do not intersect there. */
static inline bool lf_cut_corners(const lf_rig *rig, const lf_cut_corner c[3], int above,
                                  lf_cut_corner out[2])
{
    if (above == 0 || above == 3)
        return false;
    int alone = 0; /* the corner alone on its side of the plane */
    while (alone < 2 && (c[alone].height >= 0.0) != (above == 1))
        alone++;
    out[0] = lf_cut_crossing(c[alone], c[(alone + 1) % 3]);
    out[1] = lf_cut_crossing(c[alone], c[(alone + 2) % 3]);
    double near = LF_SECTION_NEAR * (double)rig->distance;
    if (out[0].z < out[1].z) {
        lf_cut_corner swap = out[0];
        out[0] = out[1];
        out[1] = swap;
    }
    if (!(out[0].z > near))
        return false;
    if (out[1].z < near) {
        double t = (out[0].z - near) / (out[0].z - out[1].z);
        out[1] = (lf_cut_corner){out[0].x + t * (out[1].x - out[0].x), near, 0.0};
    }
    return true;
}

/* Stores segment i of a leaf, without its triangle and material. */
static inline void lf_cut_put(lf_section_leaf *leaf, int i, const lf_rig *rig,
                              const lf_cut_corner end[2])
{
    leaf->d0[i] = lf_cut_to_d(rig, end[0].z);
    leaf->s0[i] = (float)(end[0].x / end[0].z);
    leaf->d1[i] = lf_cut_to_d(rig, end[1].z);
    leaf->s1[i] = (float)(end[1].x / end[1].z);
}

#endif
