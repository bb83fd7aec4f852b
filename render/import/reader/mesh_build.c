#include "render/import/reader/mesh_build.h"

#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/scene/vec_double.h"

lf_mesh_place lf_mesh_place_of(const lf_affine *to_world)
{
    lf_mesh_place place = {.to_world = *to_world, .mirrored = lf_affine_determinant(to_world) < 0};
    lf_affine_normals(to_world, place.normals);
    return place;
}

lf_status lf_mesh_allocate(lf_mesh_data *data, int64_t n_vertices, int64_t n_triangles,
                           bool normals, lf_error *err)
{
    if (n_triangles > LF_MAX_TRIANGLES || n_vertices > 3 * (int64_t)LF_MAX_TRIANGLES)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE,
                            "%lld triangles are too many; expected at most %d",
                            (long long)n_triangles, LF_MAX_TRIANGLES);
    data->positions = lf_calloc((size_t)n_vertices, 3 * sizeof *data->positions);
    data->triangles = lf_calloc((size_t)n_triangles, 3 * sizeof *data->triangles);
    if (normals)
        data->normals = lf_calloc((size_t)n_vertices, 3 * sizeof *data->normals);
    if (data->n_materials > 0)
        data->triangle_material = lf_calloc((size_t)n_triangles, sizeof *data->triangle_material);
    if (!data->positions || !data->triangles || (normals && !data->normals) ||
        (data->n_materials && !data->triangle_material))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    return LF_OK;
}

void lf_mesh_put_vertex(lf_mesh_data *data, const lf_mesh_place *place, const double position[3],
                        const float *normal)
{
    size_t at = 3 * (size_t)data->n_vertices++;
    double *out = data->positions + at, w[3], length = 0;
    lf_affine_point(&place->to_world, position, out);
    for (int i = 0; i < 3; i++)
        if (!(fabs(out[i]) <= LF_MAX_COORDINATE))
            out[0] = (double)NAN;
    if (!data->normals || !normal)
        return;
    for (int i = 0; i < 3; i++) {
        const double *row = place->normals[i];
        w[i] = row[0] * (double)normal[0] + row[1] * (double)normal[1] + row[2] * (double)normal[2];
        length += w[i] * w[i];
    }
    length = sqrt(length);
    for (size_t i = 0; i < 3; i++)
        data->normals[at + i] = length > 0 && isfinite(length) ? (float)(w[i] / length) : 0.0f;
}

static bool has_area(const double *a, const double *b, const double *c)
{
    double ab[3], ac[3], n[3];
    lf_sub_double(b, a, ab);
    lf_sub_double(c, a, ac);
    lf_cross_double(ab, ac, n);
    return fabs(n[0]) + fabs(n[1]) + fabs(n[2]) > 0; /* false for NaN too */
}

void lf_mesh_put_triangle(lf_mesh_data *data, const lf_mesh_place *place, const uint32_t corners[3],
                          unsigned material)
{
    /* swapping two corners keeps the geometric normal with the shading normal */
    const uint32_t t[3] = {corners[0], corners[place->mirrored ? 2 : 1],
                           corners[place->mirrored ? 1 : 2]};
    const double *p = data->positions;
    if (!has_area(p + 3 * (size_t)t[0], p + 3 * (size_t)t[1], p + 3 * (size_t)t[2])) {
        data->n_broken += isnan(p[3 * (size_t)t[0]] + p[3 * (size_t)t[1]] + p[3 * (size_t)t[2]]);
        return;
    }
    memcpy(data->triangles + 3 * (size_t)data->n_triangles, t, sizeof t);
    if (data->triangle_material)
        data->triangle_material[data->n_triangles] =
            (uint16_t)(material < (unsigned)data->n_materials ? material : 0);
    data->n_triangles++;
}

/* Vertex normals: the mean of the face normals, weighted by the faces' angles there (Thuermer and
 * Wuethrich 1998). Assimp's are the normals of one face if a file's faces share their vertices. */
static void smooth(lf_mesh_data *data, const uint32_t *twins)
{
    for (size_t c = 0; c < 3 * (size_t)data->n_triangles; c++) {
        const uint32_t *t = data->triangles + c - c % 3;
        const double *p = data->positions + 3 * (size_t)t[c % 3],
                     *q = data->positions + 3 * (size_t)t[(c + 1) % 3],
                     *r = data->positions + 3 * (size_t)t[(c + 2) % 3];
        double a[3], b[3], w[3];
        lf_sub_double(q, p, a);
        lf_sub_double(r, p, b);
        lf_cross_double(a, b, w);
        double length = lf_length_double(w),
               weight = length > 0 ? atan2(length, lf_dot_double(a, b)) / length : 0;
        size_t vertex = twins ? twins[t[c % 3]] : t[c % 3];
        for (size_t i = 0; i < 3; i++)
            data->normals[3 * vertex + i] += (float)(weight * w[i]);
    }
    for (float *n = data->normals, *end = n + 3 * (size_t)data->n_vertices; n < end; n += 3) {
        float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int i = 0; i < 3; i++)
            n[i] = length > 1e-6f ? n[i] / length : 0.0f;
    }
    for (size_t v = 0; twins && v < (size_t)data->n_vertices; v++)
        memmove(data->normals + 3 * v, data->normals + 3 * (size_t)twins[v], 3 * sizeof(float));
}

/* Gives vertices without a usable normal the normal of a face at them, and removes NaN from
 * positions that no face uses. */
static void repair(lf_mesh_data *data)
{
    for (int v = 0; v < data->n_vertices; v++)
        if (isnan(data->positions[3 * (size_t)v]))
            memset(data->positions + 3 * (size_t)v, 0, 3 * sizeof(double));
    for (size_t c = 0; data->normals && c < 3 * (size_t)data->n_triangles; c++) {
        float *n = data->normals + 3 * (size_t)data->triangles[c];
        if (n[0] != 0.0f || n[1] != 0.0f || n[2] != 0.0f)
            continue;
        const uint32_t *t = data->triangles + c - c % 3;
        const double *a = data->positions + 3 * (size_t)t[0],
                     *b = data->positions + 3 * (size_t)t[1],
                     *d = data->positions + 3 * (size_t)t[2];
        double ab[3], ad[3], w[3];
        lf_sub_double(b, a, ab);
        lf_sub_double(d, a, ad);
        lf_cross_double(ab, ad, w);
        double length = lf_length_double(w);
        for (int i = 0; i < 3; i++)
            n[i] = length > 0 ? (float)(w[i] / length) : i == 1 ? 1.0f : 0.0f;
    }
}

lf_status lf_mesh_complete(lf_mesh_data *data, const lf_mesh_desc *desc, int64_t n_triangles,
                           lf_error *err)
{
    return lf_mesh_complete_twins(data, desc, n_triangles, NULL, err);
}

lf_status lf_mesh_complete_twins(lf_mesh_data *data, const lf_mesh_desc *desc, int64_t n_triangles,
                                 const uint32_t *twins, lf_error *err)
{
    if (n_triangles == 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "no triangles in this file");
    if (data->n_triangles == 0)
        return lf_error_set(
            err, LF_E_FORMAT, LF_HERE,
            "no usable triangles: all %lld have no area, or missing or non-finite vertices",
            (long long)n_triangles);
    if (data->n_broken > 0)
        lf_warnings_add(&data->warnings, LF_HERE,
                        "%d of %lld triangles %s left out: a vertex is not finite or beyond %g",
                        data->n_broken, (long long)n_triangles, data->n_broken == 1 ? "is" : "are",
                        LF_MAX_COORDINATE);
    if (desc->normals == LF_NORMALS_SMOOTH)
        smooth(data, twins);
    repair(data);
    return LF_OK;
}
