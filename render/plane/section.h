/* The meshes cut by the plane of a row: from which views a surface hides a point of it, and what
 * the rays of a fan meet first; private to render/.
 *
 * All rays of a visit lie in one plane (rig.h), and meshes meet it in segments. With d = 1/Z - 1/W
 * and s = X/Z straight lines stay straight, and the ray from the camera position c to the point
 * (d0, s0) is the line s = s0 + c (d - d0): cameras are slopes. A point (d, s) with d > d0
 * therefore hides (d0, s0) from the one camera position (s - s0) / (d - d0), and a segment from all
 * positions between those of its ends. Two divisions a segment that lies in front of the point
 * answer for all views; occlusion rays would take one each. What is hidden is the same but for
 * rounding: tests/render/test_section.c. */
#ifndef LF_RENDER_SECTION_H
#define LF_RENDER_SECTION_H

#include "base/thread.h"
#include "render/plane/rig.h"
#include "render/transport/path/track.h"

/* ------------------------------------------------------------------------ what rows can meet -- */

typedef struct lf_row_triangle {
    uint32_t mesh, triangle;
    /* along a Z curve in (d, s): neighbours in a row's list are neighbours in the plane */
    uint32_t order;
} lf_row_triangle;

/* The triangles of every row: all that a plane of it, through any point of row and lens, can meet
 * in front of the cameras, but those of hidden meshes and of those that stand in many places. */
typedef struct lf_row_triangles {
    size_t *first;         /* [height + 1] */
    lf_row_triangle *list; /* of row r: [first[r], first[r + 1]) */
    /* [meshes + 1] number of a mesh's first triangle, counted through all meshes that are listed */
    uint32_t *mesh_start;
    size_t longest;       /* triangles of the row that has most */
    uint32_t n_instances; /* of meshes that stand in many, which rows do not list */
} lf_row_triangles;

/* Sorts the scene's triangles into the rig's rows, on the pool: where they move, into all that they
 * are in while the shutter is open. rigs[n_rigs] as in lf_slice_frame_init. LF_E_NOMEM; *out may
 * then be finished. Release with lf_row_triangles_finish. */
LF_NODISCARD lf_status lf_row_triangles_init(lf_row_triangles *out, const lf_scene *scene,
                                             const lf_rig *rigs, int n_rigs, lf_pool *pool);
/* Accepts one that is all zero. */
void lf_row_triangles_finish(lf_row_triangles *rows);

/* --------------------------------------------------------------------------- one row's plane -- */

#define LF_SECTION_WIDE 8

/* Segments, d0 <= d1; unused ones lie at d = -LF_SECTION_FAR. */
typedef struct lf_section_leaf {
    float d0[LF_SECTION_WIDE], s0[LF_SECTION_WIDE], d1[LF_SECTION_WIDE], s1[LF_SECTION_WIDE];
    /* counted through all meshes, or of a mesh that stands in many places the segment's own */
    uint32_t triangle[LF_SECTION_WIDE];
    int material[LF_SECTION_WIDE];
} lf_section_leaf;

/* Boxes of the leaves, or nodes, from 8 i on. */
typedef struct lf_section_node {
    float d0[LF_SECTION_WIDE], s0[LF_SECTION_WIDE], d1[LF_SECTION_WIDE], s1[LF_SECTION_WIDE];
} lf_section_node;
#define LF_SECTION_FAR 1e30f

/* A place whose segments follow each other, and the number of the first of them. */
typedef struct lf_section_slot {
    uint32_t mesh, place, first;
} lf_section_slot;

/* Of meshes that stand in many places (section_instances.h). Their segments are numbered from 0 on,
 * and in leaves from .first on, behind the triangles of all other meshes. */
typedef struct lf_section_instances {
    size_t listed; /* triangles of the longest row */
    size_t most;   /* segments that there is room for, those of rows' lists included; 0: none yet */
    size_t n, room;
    lf_section_slot *slot; /* [n] of room */
    uint32_t *triangle;    /* [most] of its mesh, by number */
    uint32_t *slot_of;     /* [places of the scene] where a place was put; NULL: there are none */
    uint32_t first, n_segments;
} lf_section_instances;

/* Which triangles: those whose surface may not be there whole (alpha.h), or the others. */
typedef enum lf_cut_what { LF_CUT_ALL, LF_CUT_OPAQUE, LF_CUT_ALPHAS } lf_cut_what;

/* Where segments of places would be too many, rays are asked (section_rays.h). */
typedef struct lf_section_rays {
    bool on;
    lf_cut_what what;
    lf_row_plane plane;
    /* the worker's, with the scene of the visit; set by who owns the section, where n_instances > 0
     */
    lf_tracer *tracer;
} lf_section_rays;

struct lf_fans;

typedef struct lf_section {
    const struct lf_fans *fans; /* what looks into it (fan.h) */
    lf_section_leaf *leaves;
    lf_section_node *nodes, *roots;
    int n_leaves, n_roots;
    lf_section_instances places;
    lf_section_rays rays;
} lf_section;

/* Memory for sections of up to `longest` triangles, and of what n_instances places come to;
 * LF_E_NOMEM. Release with lf_section_finish, also then. */
LF_NODISCARD lf_status lf_section_init(lf_section *section, size_t longest, uint32_t n_instances);
/* Accepts one that is all zero. */
void lf_section_finish(lf_section *section);

/* Cuts the row's triangles with a plane of the row, and what stands in many places. Does not
 * allocate but for the latter, where more of them are cut than ever before. */
void lf_section_cut(lf_section *section, const lf_row_triangles *rows, const lf_scene *scene,
                    const lf_rig *rig, int row, const lf_row_plane *plane, lf_cut_what what);

/* A section, and what it is cut from. */
typedef struct lf_row_cut {
    const lf_section *section;
    const lf_row_triangles *rows;
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_row_plane *plane;
} lf_row_cut;

/* n rays that leave the camera positions c[k], rising in k, through one point of the plane Z = W,
 * or for a lens through one point of what it makes of that plane: the lines s = s0 + c d. n is a
 * multiple of LF_LANES. */
typedef struct lf_lines {
    float s0;
    int n;
    const float *c;
} lf_lines;

/* Sets scale[k] to 0 for every camera position c[k] from which a surface hides the point p of the
 * plane, k < n, n a multiple of LF_LANES; c rises in k but for lanes behind the views, whose scale
 * is 0. Views whose scale is 0 are not looked at. on: the surface that p lies on, which hides it
 * from nobody; NULL for a point of a medium. */
void lf_section_hide(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n, const float *c,
                     float *scale);

/* The nearest surface along each of these rays. z[k] is where it lies, INFINITY: nowhere;
 * segment[k] is which of the section it is, -1: none. */
void lf_section_nearest(const lf_row_cut *cut, const lf_lines *lines, float *z, int *segment);

/* A segment's material in the scene. */
static inline int lf_section_material(const lf_section *section, int segment)
{
    return section->leaves[segment / LF_SECTION_WIDE].material[segment % LF_SECTION_WIDE];
}

/* Its triangle's number among those of the scene's meshes, the same in all sections; of what stands
 * in many places one of lf_row_triangles.mesh_start[meshes] or more, which says nothing. */
static inline uint32_t lf_section_triangle(const lf_section *section, int segment)
{
    return section->leaves[segment / LF_SECTION_WIDE].triangle[segment % LF_SECTION_WIDE];
}

/* The triangle that it is cut from. */
void lf_section_face(const lf_row_cut *cut, int segment, lf_face *out);

#endif
