/* Meshes of patches of facets. */
#include "render/import/scene/mesh_shape.h"

#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/mesh_import.h"
#include "render/scene/vec_double.h"

#define LIST(name) &lf_mesh_##name,
const lf_mesh_shape *const lf_mesh_shapes[] = {LF_MESH_SHAPES(LIST) NULL};

static lf_status allocate_patches(lf_mesh_data *out, const lf_mesh_shape *shape, lf_error *err)
{
    size_t corners =
               (size_t)shape->n_patches * (size_t)(shape->across + 1) * (size_t)(shape->down + 1),
           facets = (size_t)shape->n_patches * (size_t)shape->across * (size_t)shape->down;
    out->positions = lf_calloc(corners, 3 * sizeof *out->positions);
    out->triangles = lf_calloc(2 * facets, 3 * sizeof *out->triangles);
    if (!out->positions || !out->triangles)
        return lf_error_set(err, LF_E_NOMEM, "mesh", "out of memory");
    return LF_OK;
}

static bool same_point(const double *a, const double *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void append_triangle(lf_mesh_data *out, int a, int b, int c)
{
    const double *p = out->positions + 3 * (size_t)a, *q = out->positions + 3 * (size_t)b,
                 *r = out->positions + 3 * (size_t)c;
    if (same_point(p, q) || same_point(q, r) || same_point(r, p))
        return; /* a side of a patch is a single point */
    uint32_t t[3] = {(uint32_t)a, (uint32_t)b, (uint32_t)c};
    memcpy(out->triangles + 3 * (size_t)out->n_triangles++, t, sizeof t);
}

static void make_patches(lf_mesh_data *out, const lf_mesh_shape *shape)
{
    const int across = shape->across, down = shape->down;
    for (int patch = 0; patch < shape->n_patches; patch++) {
        int base = out->n_vertices;
        for (int j = 0; j <= down; j++)
            for (int i = 0; i <= across; i++)
                shape->corner(patch, i, j, out->positions + 3 * (size_t)out->n_vertices++);
        for (int j = 0; j < down; j++) {
            for (int i = 0; i < across; i++) {
                int at = base + j * (across + 1) + i, above = at + across + 1;
                append_triangle(out, at, at + 1, above + 1);
                append_triangle(out, at, above + 1, above);
            }
        }
    }
}

static lf_status set_normals(lf_mesh_data *out, const lf_mesh_shape *shape, lf_error *err)
{
    out->normals = lf_calloc((size_t)out->n_vertices, 3 * sizeof *out->normals);
    if (!out->normals)
        return lf_error_set(err, LF_E_NOMEM, "mesh", "out of memory");
    for (size_t v = 0; v < (size_t)out->n_vertices; v++)
        shape->normal(out->positions + 3 * v, out->normals + 3 * v);
    return LF_OK;
}

/* Texture coordinates at the corners, which are as make_patches left them. */
static lf_status set_uvs(lf_mesh_data *out, const lf_mesh_shape *shape, lf_error *err)
{
    const int across = shape->across, down = shape->down, each = (across + 1) * (down + 1);
    out->uvs = lf_calloc((size_t)out->n_vertices, 2 * sizeof *out->uvs);
    if (!out->uvs)
        return lf_error_set(err, LF_E_NOMEM, "mesh", "out of memory");
    out->n_uv_sets = 1;
    for (int v = 0; v < out->n_vertices; v++) {
        const int i = v % each % (across + 1), j = v % each / (across + 1);
        double at[2] = {(double)i / across, 1.0 - (double)j / down};
        if (shape->place)
            shape->place(v / each, out->positions + 3 * (size_t)v, at);
        for (int k = 0; k < 2; k++)
            out->uvs[2 * (size_t)v + (size_t)k] = (float)at[k];
    }
    return LF_OK;
}

/* Moves a made shape into the world, as append_vertices does for files. */
static void place(lf_mesh_data *out, const lf_affine *transform)
{
    double to_world[3][3];
    lf_affine_normals(transform, to_world);
    for (int v = 0; v < out->n_vertices; v++) {
        double *p = out->positions + 3 * (size_t)v, moved[3];
        lf_affine_point(transform, p, moved);
        memcpy(p, moved, sizeof moved);
        float *n = out->normals ? out->normals + 3 * (size_t)v : NULL;
        double w[3], length = 0;
        for (int i = 0; n && i < 3; i++) {
            w[i] = to_world[i][0] * (double)n[0] + to_world[i][1] * (double)n[1] +
                   to_world[i][2] * (double)n[2];
            length += w[i] * w[i];
        }
        for (int i = 0; n && i < 3; i++)
            n[i] = (float)(w[i] / sqrt(length));
    }
    if (lf_affine_determinant(transform) >= 0)
        return;
    for (int t = 0; t < out->n_triangles; t++) {
        uint32_t *corner = out->triangles + 3 * (size_t)t, swap = corner[1];
        corner[1] = corner[2];
        corner[2] = swap;
    }
}

static double area_of(const lf_mesh_data *data)
{
    double sum = 0;
    for (int t = 0; t < data->n_triangles; t++) {
        const uint32_t *corner = data->triangles + 3 * (size_t)t;
        double ab[3], ac[3], cross[3];
        lf_sub_double(data->positions + 3 * (size_t)corner[1],
                      data->positions + 3 * (size_t)corner[0], ab);
        lf_sub_double(data->positions + 3 * (size_t)corner[2],
                      data->positions + 3 * (size_t)corner[0], ac);
        lf_cross_double(ab, ac, cross);
        sum += 0.5 * lf_length_double(cross);
    }
    return sum;
}

/* Scales a transformed shape about its middle. */
static void scale_to_area(lf_mesh_data *out, const lf_affine *transform, double area)
{
    double by = sqrt(area / area_of(out));
    for (int i = 0; i < 3 * out->n_vertices; i++) {
        double middle = transform->m[i % 3][3];
        out->positions[i] = middle + by * (out->positions[i] - middle);
    }
}

/* Shapes without a material of the scene's are grey. */
static lf_status grey_material(lf_mesh_data *out, lf_error *err)
{
    out->materials = lf_calloc(1, sizeof *out->materials);
    out->triangle_material = lf_calloc((size_t)out->n_triangles, sizeof *out->triangle_material);
    if (!out->materials || !out->triangle_material)
        return lf_error_set(err, LF_E_NOMEM, "mesh", "out of memory");
    out->materials[0] = (lf_material){
        .kind = &lf_surface_diffuse, .albedo = {0.5f, 0.5f, 0.5f}, .roughness = 0.3f, .ior = 1.5f};
    out->n_materials = 1;
    return LF_OK;
}

static lf_status check_reach(const lf_mesh_data *data, const char *name, lf_error *err)
{
    double most = 0.0;
    for (int i = 0; i < 3 * data->n_vertices; i++) {
        if (!isfinite(data->positions[i]))
            return lf_error_set(err, LF_E_FORMAT, name,
                                "it is too small so far from the origin: its corners coincide");
        most = fmax(most, fabs(data->positions[i]));
    }
    if (most <= LF_MAX_REACH)
        return LF_OK;
    return lf_error_set(err, LF_E_FORMAT, name, "it has coordinates up to %g; expected at most %g",
                        most, LF_MAX_REACH);
}

lf_status lf_mesh_shape_make(const lf_mesh_desc *desc, lf_mesh_data *out, lf_error *err)
{
    lf_status status = allocate_patches(out, desc->shape, err);
    if (status != LF_OK)
        return status;
    make_patches(out, desc->shape);
    if (desc->shape->normal && desc->normals != LF_NORMALS_FLAT)
        status = set_normals(out, desc->shape, err);
    if (status == LF_OK && desc->wants.uvs)
        status = set_uvs(out, desc->shape, err);
    if (status == LF_OK && desc->material < 0)
        status = grey_material(out, err);
    if (status == LF_OK)
        place(out, &desc->transform);
    if (status == LF_OK && desc->area > 0)
        scale_to_area(out, &desc->transform, desc->area);
    return status == LF_OK ? check_reach(out, desc->name, err) : status;
}
