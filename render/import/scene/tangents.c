#include "render/import/scene/tangents.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/scene/vec_double.h"

/* Sums at a vertex. */
typedef struct frame {
    double normal[3];            /* of its faces, if the mesh has none */
    double tangent[3], above[3]; /* directions right and up in the image */
} frame;

bool lf_mesh_wants_tangents(const lf_mesh_data *data)
{
    for (int i = 0; i < data->n_materials; i++)
        if (data->materials[i].anisotropy > 0.0f ||
            (data->textures && (data->textures[i].slot[LF_SLOT_NORMAL].picture > 0 ||
                                data->textures[i].slot[LF_SLOT_COAT_NORMAL].picture > 0)))
            return true;
    return false;
}

/* The texture that defines the tangents of a triangle: its normal map, its coat's, its anisotropy
 * texture, or for anisotropy alone the first coordinates; NULL: none. */
static const lf_texture *map_of(const lf_mesh_data *data, int triangle)
{
    static const lf_texture plain = {.map = {{1, 0, 0}, {0, 1, 0}}};
    const int material = data->triangle_material[triangle];
    const bool anisotropic = data->materials[material].anisotropy > 0.0f;
    const lf_texture *map = anisotropic ? &plain : NULL;
    if (data->textures) {
        const lf_texture *slot = data->textures[material].slot;
        map = slot[LF_SLOT_NORMAL].picture > 0                      ? &slot[LF_SLOT_NORMAL]
              : slot[LF_SLOT_COAT_NORMAL].picture > 0               ? &slot[LF_SLOT_COAT_NORMAL]
              : anisotropic && slot[LF_SLOT_ANISOTROPY].picture > 0 ? &slot[LF_SLOT_ANISOTROPY]
                                                                    : map;
    }
    return map && map->set < data->n_uv_sets ? map : NULL;
}

/* A vertex's position in the image: to the right, and up. */
static void place_in_picture(const lf_mesh_data *data, const lf_texture *map, uint32_t vertex,
                             double out[2])
{
    const float *uv = data->uvs + 2 * ((size_t)map->set * (size_t)data->n_vertices + vertex);
    for (int i = 0; i < 2; i++)
        out[i] = (double)map->map[i][0] * (double)uv[0] + (double)map->map[i][1] * (double)uv[1];
    out[1] = -out[1];
}

/* Derivatives of the position to the right and upwards in the image, as unit vectors. false: the
 * triangle is degenerate in the image. */
static bool gradients_of(const lf_mesh_data *data, const lf_texture *map, const uint32_t t[3],
                         double right[3], double up[3])
{
    double at[3][2], ab[3], ac[3];
    for (int c = 0; c < 3; c++)
        place_in_picture(data, map, t[c], at[c]);
    const double *p = data->positions + 3 * (size_t)t[0];
    lf_sub_double(data->positions + 3 * (size_t)t[1], p, ab);
    lf_sub_double(data->positions + 3 * (size_t)t[2], p, ac);
    double bu = at[1][0] - at[0][0], bv = at[1][1] - at[0][1], cu = at[2][0] - at[0][0],
           cv = at[2][1] - at[0][1], side = bu * cv - cu * bv < 0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; i++) {
        right[i] = side * (ab[i] * cv - ac[i] * bv);
        up[i] = side * (ac[i] * bu - ab[i] * cu);
    }
    double r = lf_length_double(right), u = lf_length_double(up);
    for (int i = 0; i < 3; i++) {
        right[i] /= r;
        up[i] /= u;
    }
    return bu * cv - cu * bv != 0 && r > 0 && u > 0 && isfinite(r + u);
}

static void add_scaled(double to[3], double scale, const double v[3])
{
    for (int i = 0; i < 3; i++)
        to[i] += scale * v[i];
}

static void add_triangle(const lf_mesh_data *data, int triangle, frame *frames)
{
    const uint32_t *t = data->triangles + 3 * (size_t)triangle;
    const lf_texture *map = map_of(data, triangle);
    double right[3], up[3];
    bool mapped = map && gradients_of(data, map, t, right, up);
    for (int c = 0; c < 3; c++) {
        const double *p = data->positions + 3 * (size_t)t[c];
        frame *f = &frames[t[c]];
        double a[3], b[3], w[3];
        lf_sub_double(data->positions + 3 * (size_t)t[(c + 1) % 3], p, a);
        lf_sub_double(data->positions + 3 * (size_t)t[(c + 2) % 3], p, b);
        lf_cross_double(a, b, w);
        double length = lf_length_double(w), angle = atan2(length, lf_dot_double(a, b));
        if (length > 0)
            add_scaled(f->normal, angle / length, w);
        if (mapped) {
            add_scaled(f->tangent, angle, right);
            add_scaled(f->above, angle, up);
        }
    }
}

/* Makes v unit and perpendicular to n. false: v is parallel to n. */
static bool put_across(const double n[3], double v[3])
{
    double length = lf_length_double(v);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    add_scaled(v, -lf_dot_double(n, v), n);
    double left = lf_length_double(v);
    for (int i = 0; i < 3; i++)
        v[i] /= left;
    return length > 0 && isfinite(length) && left > 1e-4;
}

/* The normal at a vertex, of unit length. */
static void normal_at(const lf_mesh_data *data, size_t vertex, const frame *f, double out[3])
{
    for (size_t i = 0; i < 3; i++)
        out[i] = data->normals ? (double)data->normals[3 * vertex + i] : f->normal[i];
    double length = lf_length_double(out);
    for (int i = 0; i < 3; i++)
        out[i] = length > 0 ? out[i] / length : i == 1;
}

/* Uses the file's tangent, the sum, or any direction: the first that is valid. */
static void finish_frame(const double n[3], const frame *f, float tangent[4])
{
    double across[3], told[3] = {(double)tangent[0], (double)tangent[1], (double)tangent[2]},
                      made[3] = {f->tangent[0], f->tangent[1], f->tangent[2]},
                      any[3] = {fabs(n[0]) < 0.5, fabs(n[0]) >= 0.5, 0};
    double *use = any;
    float side = 1.0f;
    if (put_across(n, told)) {
        use = told;
        side = tangent[3] < 0 ? -1.0f : 1.0f;
    } else if (put_across(n, made)) {
        use = made;
        lf_cross_double(n, made, across);
        side = lf_dot_double(across, f->above) < 0 ? -1.0f : 1.0f;
    } else {
        (void)put_across(n, any);
    }
    for (int i = 0; i < 3; i++)
        tangent[i] = (float)use[i];
    tangent[3] = side;
}

lf_status lf_mesh_tangents(lf_mesh_data *data, lf_error *err)
{
    size_t n = (size_t)data->n_vertices;
    if (!lf_mesh_wants_tangents(data)) {
        lf_free(data->tangents);
        data->tangents = NULL;
        return LF_OK;
    }
    frame *frames = lf_calloc(n, sizeof *frames);
    if (frames && !data->tangents)
        data->tangents = lf_calloc(n, 4 * sizeof *data->tangents);
    if (!frames || !data->tangents) {
        lf_free(frames);
        return lf_error_set(err, LF_E_NOMEM, "mesh", "out of memory");
    }
    for (int t = 0; t < data->n_triangles; t++)
        add_triangle(data, t, frames);
    for (size_t v = 0; v < n; v++) {
        double normal[3];
        normal_at(data, v, &frames[v], normal);
        finish_frame(normal, &frames[v], data->tangents + 4 * v);
    }
    lf_free(frames);
    return LF_OK;
}
