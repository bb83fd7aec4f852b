/* The meshes cut by the plane of a row: from which views a surface hides a point of it, and which
 * surface the rays of a fan meet first; private to render/.
 *
 * All rays of a visit lie in one plane (rig.h), and meshes intersect it in segments. With d = 1/Z -
 * 1/Z0 and s = X/Z straight lines stay straight, and the ray from the camera position c to the
 * point (d0, s0) is the line s = s0 + c (d - d0): cameras are slopes. So a point (d, s) with d > d0
 * hides (d0, s0) from one camera position, (s - s0) / (d - d0), and a segment hides it from all
 * positions between the positions for its ends. Two divisions per segment in front of the point
 * answer for all views; shadow rays would take one ray per view. The results differ only by
 * rounding: tests/render/test_section.c. */
#ifndef LF_RENDER_SECTION_H
#define LF_RENDER_SECTION_H

#include "base/thread.h"
#include "render/plane/rig.h"
#include "render/transport/path/track.h"

/* ------------------------------------------------------------------------- triangles per row -- */

typedef struct lf_row_triangle {
    uint32_t mesh, triangle;
    /* along a Z curve in (d, s): neighbours in a row's list are neighbours in the plane */
    uint32_t order;
} lf_row_triangle;

/* For each row, the triangles in front of the cameras that any plane of the row can intersect,
 * through any point of row and lens. Excludes hidden and instanced meshes. */
typedef struct lf_row_triangles {
    size_t *first;         /* [height + 1] */
    lf_row_triangle *list; /* of row r: [first[r], first[r + 1]) */
    /* [meshes + 1] number of a mesh's first triangle, counted over all listed meshes */
    uint32_t *mesh_start;
    size_t longest;       /* number of triangles of the longest row */
    uint32_t n_instances; /* of instanced meshes, which rows do not list */
} lf_row_triangles;

/* Sorts the scene's triangles into the rig's rows, on the pool; moving triangles into all rows that
 * they meet while the shutter is open. rigs[n_rigs] as in lf_slice_frame_init. LF_E_NOMEM; *out may
 * then be finished. Release with lf_row_triangles_finish. */
LF_NODISCARD lf_status lf_row_triangles_init(lf_row_triangles *out, const lf_scene *scene,
                                             const lf_rig *rigs, int n_rigs, lf_pool *pool);
/* Accepts a zeroed struct. */
void lf_row_triangles_finish(lf_row_triangles *rows);

/* --------------------------------------------------------------------------- one row's plane -- */

#define LF_SECTION_WIDE 8

/* Segments, d0 <= d1; unused ones lie at d = -LF_SECTION_FAR. */
typedef struct lf_section_leaf {
    float d0[LF_SECTION_WIDE], s0[LF_SECTION_WIDE], d1[LF_SECTION_WIDE], s1[LF_SECTION_WIDE];
    /* counted over all meshes; for an instanced mesh the number of the segment itself */
    uint32_t triangle[LF_SECTION_WIDE];
    int material[LF_SECTION_WIDE];
} lf_section_leaf;

/* Boxes of eight leaves, or of eight nodes, from number 8 i on. */
typedef struct lf_section_node {
    float d0[LF_SECTION_WIDE], s0[LF_SECTION_WIDE], d1[LF_SECTION_WIDE], s1[LF_SECTION_WIDE];
} lf_section_node;
#define LF_SECTION_FAR 1e30f

/* An instance whose segments are consecutive, and the number of its first segment. */
typedef struct lf_section_slot {
    uint32_t mesh, place, first;
} lf_section_slot;

/* Segments of instanced meshes (section_instances.h). They are numbered from 0 on. In leaves they
 * are numbered from .first on, after the triangles of all other meshes. */
typedef struct lf_section_instances {
    size_t listed; /* number of triangles of the longest row */
    /* capacity in segments, including the triangles of the rows' lists; 0: not allocated yet */
    size_t most;
    size_t n, room;
    lf_section_slot *slot; /* [n] of room */
    uint32_t *triangle;    /* [most] number in its mesh, by segment number */
    uint32_t *slot_of;     /* [instances of the scene] slot of an instance; NULL: no instances */
    uint32_t first, n_segments;
} lf_section_instances;

/* Which triangles: alpha surfaces (alpha.h), or the others. */
typedef enum lf_cut_what { LF_CUT_ALL, LF_CUT_OPAQUE, LF_CUT_ALPHAS } lf_cut_what;

/* Rays replace the segments of instances where these would be too many (section_rays.h). */
typedef struct lf_section_rays {
    bool on;
    lf_cut_what what;
    lf_row_plane plane;
    /* the worker's, with the scene of the visit; set by the owner of the section if n_instances > 0
     */
    lf_tracer *tracer;
} lf_section_rays;

struct lf_fans;

typedef struct lf_section {
    const struct lf_fans *fans; /* the functions that search it (fan.h) */
    lf_section_leaf *leaves;
    lf_section_node *nodes, *roots;
    int n_leaves, n_roots;
    lf_section_instances places;
    lf_section_rays rays;
} lf_section;

/* Memory for sections of up to `longest` triangles and n_instances instances. LF_E_NOMEM. Release
 * with lf_section_finish, also after a failure. */
LF_NODISCARD lf_status lf_section_init(lf_section *section, size_t longest, uint32_t n_instances);
/* Accepts a zeroed struct. */
void lf_section_finish(lf_section *section);

/* Cuts the row's triangles and the instanced meshes with a plane of the row. Allocates only if it
 * finds more segments of instances than ever before. */
void lf_section_cut(lf_section *section, const lf_row_triangles *rows, const lf_scene *scene,
                    const lf_rig *rig, int row, const lf_row_plane *plane, lf_cut_what what);

/* A section, and its inputs. */
typedef struct lf_row_cut {
    const lf_section *section;
    const lf_row_triangles *rows;
    const lf_scene *scene;
    const lf_rig *rig;
    const lf_row_plane *plane;
} lf_row_cut;

/* n rays that leave the camera positions c[k], increasing in k, through one point of the plane Z =
 * Z0 (for a lens: through one point of the plane's image by the lens). They are the lines s = s0 +
 * c d. n is a multiple of LF_LANES. */
typedef struct lf_lines {
    float s0;
    int n;
    const float *c;
} lf_lines;

/* Sets scale[k] to 0 for every camera position c[k] from which a surface hides the point p of the
 * plane, k < n, n a multiple of LF_LANES. Positions increase in k, except in lanes after the last
 * view, whose scale must be 0. Views with scale 0 are skipped. `on` is the surface that contains p
 * and therefore does not hide it; NULL for a point in a medium. */
void lf_section_hide(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n, const float *c,
                     float *scale);

/* The nearest surface along each of these rays. z[k] is its depth, INFINITY: no hit. segment[k] is
 * its number in the section, -1: none. */
void lf_section_nearest(const lf_row_cut *cut, const lf_lines *lines, float *z, int *segment);

/* A segment's material in the scene. */
static inline int lf_section_material(const lf_section *section, int segment)
{
    return section->leaves[segment / LF_SECTION_WIDE].material[segment % LF_SECTION_WIDE];
}

/* The number of a segment's triangle among those of the scene's meshes, the same in all sections.
 * For instanced meshes a number >= lf_row_triangles.mesh_start[meshes], without further meaning. */
static inline uint32_t lf_section_triangle(const lf_section *section, int segment)
{
    return section->leaves[segment / LF_SECTION_WIDE].triangle[segment % LF_SECTION_WIDE];
}

/* The triangle that a segment is cut from. */
void lf_section_face(const lf_row_cut *cut, int segment, lf_face *out);

#endif
