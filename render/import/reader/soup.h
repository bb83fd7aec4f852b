/* The result of our own mesh readers: points, normals, texture coordinates and triangles in file
 * order; lf_weld makes a mesh from it. One thread. */
#ifndef LF_RENDER_SOUP_H
#define LF_RENDER_SOUP_H

#include "render/import/reader/maps.h"

/* Index of a missing normal: use the triangle's own. */
#define LF_NO_NORMAL UINT32_MAX
/* Index of a missing texture coordinate, which counts as (0, 0). */
#define LF_NO_UV UINT32_MAX

typedef struct lf_soup_uvs {
    float *values; /* [n][2], as in the file, limited to LF_MAX_UV */
    size_t n, room;
    bool are_own; /* one per point, with the same number; `of` is unused */
    uint32_t *of; /* [n_triangles][3]: index into values, LF_NO_UV; NULL: no texture coordinates */
    size_t of_room;
} lf_soup_uvs;

typedef struct lf_soup_colours {
    float *values;  /* [n][4] of points, linear, 0..1 */
    size_t n, room; /* n: n_points; otherwise the colours are ignored */
} lf_soup_colours;

/* Names of ignored features, each once. Zeroed: empty. */
typedef struct lf_left_out {
    char names[256];
} lf_left_out;

/* name: n bytes; unprintable ones become '?'. */
void lf_leave_out(lf_left_out *list, const char *name, size_t n);
/* Adds one warning line if the list is not empty: "WHAT: a, b". */
void lf_left_out_warn(const lf_left_out *list, const char *what, lf_warnings *warnings);

/* Zeroed: empty. Arrays are realloc's. */
typedef struct lf_soup {
    double *points; /* [n_points][3] */
    size_t n_points, points_room;
    float *normals; /* [n_normals][3], as in the file */
    size_t n_normals, normals_room;
    bool has_own_normals; /* one per point, with the same number; normals_of is unused */
    lf_soup_uvs uvs;
    lf_soup_colours colours;
    uint32_t *corners; /* [n_triangles][3]: index of a point */
    size_t n_triangles, corners_room;
    uint32_t *normals_of; /* [n_triangles][3]: index of a normal, LF_NO_NORMAL */
    size_t normals_of_room;
    uint16_t *choices; /* [n_triangles]: index into source; NULL: all use the first */
    size_t choices_room;
    /* [n_parts]: the first triangle of each part, ascending; vertices of different parts are not
     * joined */
    uint32_t *parts;
    size_t n_parts, parts_room;
    lf_source_material *source; /* [n_sources] */
    size_t n_sources, source_room;
    lf_map *maps; /* [n_maps] */
    size_t n_maps, maps_room;
    /* report materials that it uses and lacks: all of its libraries were read */
    bool tells_missing;
    size_t n_coloured;      /* parts with vertex colours */
    size_t n_beside;        /* points and lines */
    size_t n_wrong_normals; /* faces with indices of vertices that do not exist */
    lf_warnings warnings;
} lf_soup;

/* The corners of a triangle or polygon, as indices into a soup. */
typedef struct lf_soup_face {
    const uint32_t *corners;
    const uint32_t *normals; /* NULL unless normals_of is used */
    const uint32_t *uvs;     /* NULL: LF_NO_UV each */
    unsigned choice;         /* index into source */
} lf_soup_face;

/* Accepts a zeroed struct; leaves it zeroed. */
void lf_soup_finish(lf_soup *soup);

/* Each appends one element; LF_E_NOMEM, also beyond the limits. */
LF_NODISCARD lf_status lf_soup_point(lf_soup *soup, const double at[3], lf_error *err);
LF_NODISCARD lf_status lf_soup_normal(lf_soup *soup, const float normal[3], lf_error *err);
/* NaN and values beyond LF_MAX_UV become 0. */
LF_NODISCARD lf_status lf_soup_uv(lf_soup *soup, const double uv[2], lf_error *err);
/* Decodes a display-encoded sRGB value to linear, 0..1; NaN becomes 0. */
float lf_soup_light(double code);
/* Colour of the next point without one; clamped to its range. */
LF_NODISCARD lf_status lf_soup_colour(lf_soup *soup, const float rgba[4], lf_error *err);
LF_NODISCARD lf_status lf_soup_triangle(lf_soup *soup, const lf_soup_face *face, lf_error *err);
/* Starts a part: later triangles are not joined to earlier ones. */
LF_NODISCARD lf_status lf_soup_part(lf_soup *soup, lf_error *err);
/* Takes ownership of the map, also on failure. A second map of the same use replaces the first. */
LF_NODISCARD lf_status lf_soup_map(lf_soup *soup, lf_map map, lf_error *err);
/* Takes ownership of source.name, also on failure. LF_E_FORMAT: too many. */
LF_NODISCARD lf_status lf_soup_say(lf_soup *soup, lf_source_material source, lf_error *err);

/* Appends a polygon of n points as triangles. Fewer than three points add no triangle and count in
 * n_beside. The corners must be coplanar; convex or not, in either direction. Ear clipping, in time
 * n^2, LF_MAX_CORNERS at most. Otherwise as lf_soup_triangle. LF_E_FORMAT: too many corners. */
#define LF_MAX_CORNERS 65536
LF_NODISCARD lf_status lf_soup_polygon(lf_soup *soup, size_t n, const lf_soup_face *face,
                                       lf_error *err);

/* Makes a mesh of the soup, as lf_mesh_import promises. It reads the images of used materials, and
 * joins vertices of a part with the same position and normal (and, with images or colours, with the
 * same of these). It transforms vertices by desc and drops triangles that no ray can meet. Vertex
 * colours count if the file has no material, or one without values. Consumes soup. LF_E_FORMAT: no
 * triangle is left; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_weld(lf_soup *soup, const lf_mesh_desc *desc, lf_mesh_data *out,
                               lf_error *err);

#endif
