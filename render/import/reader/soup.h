/* What our own readers make of a mesh file: points, normals, texture coordinates and triangles as
 * they come, which lf_weld makes a mesh of. One thread. */
#ifndef LF_RENDER_SOUP_H
#define LF_RENDER_SOUP_H

#include "render/import/reader/maps.h"

/* In place of a normal's number: the triangle's own. */
#define LF_NO_NORMAL UINT32_MAX
/* In place of a texture coordinate's: there is none, which is (0, 0). */
#define LF_NO_UV UINT32_MAX

typedef struct lf_soup_uvs {
    float *values; /* [n][2], as the file has them, up to LF_MAX_UV */
    size_t n, room;
    bool are_own; /* every point has the one of its number; `of` is not used */
    uint32_t *of; /* [n_triangles][3]: values, LF_NO_UV; NULL: none has any */
    size_t of_room;
} lf_soup_uvs;

typedef struct lf_soup_colours {
    float *values;  /* [n][4] of points, linear, 0..1 */
    size_t n, room; /* n: n_points, or they do not count */
} lf_soup_colours;

/* Names of what a reader leaves out, each once. A zeroed one is empty. */
typedef struct lf_left_out {
    char names[256];
} lf_left_out;

/* name: n bytes; what is not printable is '?'. */
void lf_leave_out(lf_left_out *list, const char *name, size_t n);
/* One line, if there are any: "WHAT: a, b". */
void lf_left_out_warn(const lf_left_out *list, const char *what, lf_warnings *warnings);

/* A zeroed one is empty. Arrays are realloc's. */
typedef struct lf_soup {
    double *points; /* [n_points][3] */
    size_t n_points, points_room;
    float *normals; /* [n_normals][3], as the file has them */
    size_t n_normals, normals_room;
    bool has_own_normals; /* every point has the normal of its number; normals_of is not used */
    lf_soup_uvs uvs;
    lf_soup_colours colours;
    uint32_t *corners; /* [n_triangles][3]: points */
    size_t n_triangles, corners_room;
    uint32_t *normals_of; /* [n_triangles][3]: normals, LF_NO_NORMAL */
    size_t normals_of_room;
    uint16_t *choices; /* [n_triangles]: said; NULL: all are of the first */
    size_t choices_room;
    uint32_t *parts; /* [n_parts]: the first triangle of each, ascending; vertices of different
                        parts are not joined */
    size_t n_parts, parts_room;
    lf_source_material *source; /* [n_sources] */
    size_t n_sources, source_room;
    lf_map *maps; /* [n_maps] */
    size_t n_maps, maps_room;
    bool tells_missing;     /* materials that it uses and lacks: none of its libraries failed */
    size_t n_coloured;      /* parts with a colour a vertex */
    size_t n_beside;        /* points and lines */
    size_t n_wrong_normals; /* faces that name vertices that there are not */
    lf_warnings warnings;
} lf_soup;

/* Corners of a triangle or polygon by their numbers in a soup. */
typedef struct lf_soup_face {
    const uint32_t *corners;
    const uint32_t *normals; /* NULL unless normals_of is used */
    const uint32_t *uvs;     /* NULL: LF_NO_UV each */
    unsigned choice;         /* into said */
} lf_soup_face;

/* Accepts a zeroed one, and leaves it so. */
void lf_soup_finish(lf_soup *soup);

/* Each appends one; LF_E_NOMEM, or more than there may be. */
LF_NODISCARD lf_status lf_soup_point(lf_soup *soup, const double at[3], lf_error *err);
LF_NODISCARD lf_status lf_soup_normal(lf_soup *soup, const float normal[3], lf_error *err);
/* What is no number, or beyond LF_MAX_UV, is 0. */
LF_NODISCARD lf_status lf_soup_uv(lf_soup *soup, const double uv[2], lf_error *err);
/* The light of a display-encoded colour by sRGB, 0..1; no number is 0. */
float lf_soup_light(double code);
/* Of the next point without one; it is brought into its range. */
LF_NODISCARD lf_status lf_soup_colour(lf_soup *soup, const float rgba[4], lf_error *err);
LF_NODISCARD lf_status lf_soup_triangle(lf_soup *soup, const lf_soup_face *face, lf_error *err);
/* What comes from here on is joined to nothing before it. */
LF_NODISCARD lf_status lf_soup_part(lf_soup *soup, lf_error *err);
/* Takes the map over, on failure too; another of the same use takes the place of the first. */
LF_NODISCARD lf_status lf_soup_map(lf_soup *soup, lf_map map, lf_error *err);
/* Takes said->name over, on failure too. LF_E_FORMAT: more than there may be. */
LF_NODISCARD lf_status lf_soup_say(lf_soup *soup, lf_source_material source, lf_error *err);

/* Appends a polygon of n points as triangles; of fewer than three there are none, but one more
 * thing beside. Corners in a plane, convex or not, in either direction: ears are cut off, in time
 * n^2, LF_MAX_CORNERS at most. The rest as lf_soup_triangle. LF_E_FORMAT: more corners. */
#define LF_MAX_CORNERS 65536
LF_NODISCARD lf_status lf_soup_polygon(lf_soup *soup, size_t n, const lf_soup_face *face,
                                       lf_error *err);

/* Makes a mesh of it: reads the pictures of materials that triangles have, joins vertices of a part
 * that have one position and one normal (with pictures or colours: and one of these), moves them to
 * where desc says and leaves out triangles that no ray can meet, as lf_mesh_import promises.
 * Colours count where the file has no material, or one that says nothing. Takes apart soup.
 * LF_E_FORMAT: nothing is left, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_weld(lf_soup *soup, const lf_mesh_desc *desc, lf_mesh_data *out,
                               lf_error *err);

#endif
