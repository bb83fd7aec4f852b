/* Cuts polygons into triangles: quads from a reflex corner, if there is one, others by ear clipping
 * (Meisters 1975). An ear is a corner whose triangle with its two neighbours faces the same way as
 * the polygon and contains no other corner, inside or on its sides. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/soup.h"
#include "render/scene/vec_double.h"

/* Tolerance of an angle near pi: collinear corners count as reflex, so that the cut starts from
 * them. */
#define ANGLE_SLACK 1e-6

/* A polygon in the plane that it covers most of. */
typedef struct flat_polygon {
    size_t n;
    double (*at)[2];
    uint32_t *before, *behind; /* corners that are left, in a ring */
    bool *is_ear;
} flat_polygon;

static const double *corner_at(const lf_soup *soup, uint32_t corner)
{
    return soup->points + 3 * (size_t)corner;
}

static lf_status put_corners(lf_soup *soup, const lf_soup_face *face, const uint32_t which[3],
                             lf_error *err)
{
    uint32_t c[3], n[3] = {0}, t[3] = {0};
    for (int i = 0; i < 3; i++) {
        c[i] = face->corners[which[i]];
        n[i] = face->normals ? face->normals[which[i]] : 0;
        t[i] = face->uvs ? face->uvs[which[i]] : 0;
    }
    return lf_soup_triangle(
        soup, &(lf_soup_face){c, face->normals ? n : NULL, face->uvs ? t : NULL, face->choice},
        err);
}

static double angle_between(const double a[3], const double b[3])
{
    double lengths = lf_length_double(a) * lf_length_double(b),
           cosine = lengths > 0 ? lf_dot_double(a, b) / lengths : 0;
    return acos(fmin(fmax(cosine, -1.0), 1.0));
}

/* Whether corner i of a quad is reflex: the angles on both sides of its diagonal add up. */
static bool is_inward(const lf_soup *soup, const uint32_t *corners, size_t i)
{
    double left[3], diagonal[3], right[3];
    const double *p = corner_at(soup, corners[i]);
    lf_sub_double(corner_at(soup, corners[(i + 3) % 4]), p, left);
    lf_sub_double(corner_at(soup, corners[(i + 2) % 4]), p, diagonal);
    lf_sub_double(corner_at(soup, corners[(i + 1) % 4]), p, right);
    return angle_between(left, diagonal) + angle_between(right, diagonal) > M_PI - ANGLE_SLACK;
}

static lf_status split_quad(lf_soup *soup, const lf_soup_face *face, lf_error *err)
{
    uint32_t from = 0;
    while (from < 4 && !is_inward(soup, face->corners, from))
        from++;
    const uint32_t both[2][3] = {{from % 4, (from + 1) % 4, (from + 2) % 4},
                                 {from % 4, (from + 2) % 4, (from + 3) % 4}};
    lf_status status = put_corners(soup, face, both[0], err);
    if (status == LF_OK)
        status = put_corners(soup, face, both[1], err);
    return status;
}

/* Along the axis that its normal (Newell's) is longest in, so that it runs counter-clockwise. */
static void flatten(const lf_soup *soup, const uint32_t *corners, flat_polygon *out)
{
    double normal[3] = {0};
    for (size_t i = 0; i < out->n; i++) {
        const double *a = corner_at(soup, corners[i]),
                     *b = corner_at(soup, corners[(i + 1) % out->n]);
        for (int k = 0; k < 3; k++) {
            int u = (k + 1) % 3, v = (k + 2) % 3;
            normal[k] += (a[u] - b[u]) * (a[v] + b[v]);
        }
    }
    int along = 0;
    for (int k = 1; k < 3; k++)
        if (fabs(normal[k]) > fabs(normal[along]))
            along = k;
    int u = (along + 1) % 3, v = (along + 2) % 3;
    for (size_t i = 0; i < out->n; i++) {
        const double *p = corner_at(soup, corners[i]);
        out->at[i][0] = p[normal[along] < 0 ? v : u];
        out->at[i][1] = p[normal[along] < 0 ? u : v];
        out->before[i] = (uint32_t)((i + out->n - 1) % out->n);
        out->behind[i] = (uint32_t)((i + 1) % out->n);
    }
}

static double doubled_area(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static bool same_place(const double a[2], const double b[2])
{
    return a[0] == b[0] && a[1] == b[1];
}

static bool is_ear(const flat_polygon *p, uint32_t corner)
{
    const double *a = p->at[p->before[corner]], *b = p->at[corner], *c = p->at[p->behind[corner]];
    double area = doubled_area(a, b, c);
    if (area <= 0) /* a collinear corner stays a corner of its neighbours */
        return false;
    for (uint32_t i = p->behind[p->behind[corner]]; i != p->before[corner]; i = p->behind[i]) {
        const double *q = p->at[i];
        if (doubled_area(a, b, q) >= 0 && doubled_area(b, c, q) >= 0 &&
            doubled_area(c, a, q) >= 0 && !same_place(q, a) && !same_place(q, b) &&
            !same_place(q, c))
            return false;
    }
    return true;
}

/* If no ear is left the polygon intersects itself, and any corner is used. */
static uint32_t next_ear(const flat_polygon *p, uint32_t from)
{
    uint32_t i = from;
    do {
        if (p->is_ear[i])
            return i;
        i = p->behind[i];
    } while (i != from);
    return from;
}

static lf_status cut_ears(lf_soup *soup, const lf_soup_face *face, flat_polygon *p, lf_error *err)
{
    lf_status status = LF_OK;
    uint32_t at = 0;
    flatten(soup, face->corners, p);
    for (uint32_t i = 0; i < p->n; i++)
        p->is_ear[i] = is_ear(p, i);
    for (size_t left = p->n; left >= 3 && status == LF_OK; left--) {
        uint32_t ear = next_ear(p, at), before = p->before[ear], behind = p->behind[ear];
        status = put_corners(soup, face, (uint32_t[]){before, ear, behind}, err);
        p->behind[before] = behind;
        p->before[behind] = before;
        p->is_ear[before] = is_ear(p, before);
        p->is_ear[behind] = is_ear(p, behind);
        at = behind;
    }
    return status;
}

static lf_status split_by_ears(lf_soup *soup, size_t n, const lf_soup_face *face, lf_error *err)
{
    flat_polygon p = {.n = n,
                      .at = malloc(n * sizeof *p.at),
                      .before = malloc(n * sizeof *p.before),
                      .behind = malloc(n * sizeof *p.behind),
                      .is_ear = malloc(n)};
    lf_status status = p.at && p.before && p.behind && p.is_ear
                           ? cut_ears(soup, face, &p, err)
                           : lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    free(p.at);
    free(p.before);
    free(p.behind);
    free(p.is_ear);
    return status;
}

/* The first corner without a valid position, n: none. Its triangles are unusable in any case. */
static size_t odd_corner(const lf_soup *soup, size_t n, const lf_soup_face *face)
{
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            if (!(fabs(corner_at(soup, face->corners[i])[k]) <= LF_MAX_COORDINATE))
                return i;
    return n;
}

/* All triangles contain that corner, so that no part of the face is visible. */
static lf_status split_about(lf_soup *soup, size_t n, size_t corner, const lf_soup_face *face,
                             lf_error *err)
{
    lf_status status = LF_OK;
    for (size_t i = 1; i + 1 < n && status == LF_OK; i++)
        status = put_corners(soup, face,
                             (uint32_t[]){(uint32_t)corner, (uint32_t)((corner + i) % n),
                                          (uint32_t)((corner + i + 1) % n)},
                             err);
    return status;
}

lf_status lf_soup_polygon(lf_soup *soup, size_t n, const lf_soup_face *face, lf_error *err)
{
    size_t odd = odd_corner(soup, n, face);
    if (n == 3)
        return lf_soup_triangle(soup, face, err);
    if (n > 3 && odd < n)
        return split_about(soup, n, odd, face, err);
    if (n == 4)
        return split_quad(soup, face, err);
    if (n > LF_MAX_CORNERS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "a face has %zu corners; expected at most %d", n, LF_MAX_CORNERS);
    if (n > 4)
        return split_by_ears(soup, n, face, err);
    soup->n_beside++;
    return LF_OK;
}
