/* Quads, cubes and spheres as meshes: one rectangular patch of facets each, or six of them. */
#include <string.h>

#include "base/alloc.h"
#include "render/load/mesh_import.h"

#define SPHERE_ACROSS 128
#define SPHERE_DOWN 64

/* Position of a corner (i, j) of a patch of facets. */
typedef void (*patch_fn)(int patch, int i, int j, double out[3]);

static void quad_corner(int patch, int i, int j, double out[3])
{
    (void)patch;
    out[0] = 2 * i - 1;
    out[1] = 0;
    out[2] = 1 - 2 * j;
}

/* Faces -x, +x, -y, … seen from outside. */
static void cube_corner(int patch, int i, int j, double out[3])
{
    int axis = patch / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    double sign = patch % 2 ? 1 : -1;
    out[axis] = sign;
    out[u] = sign * (2 * i - 1);
    out[v] = 2 * j - 1;
}

static void sphere_corner(int patch, int i, int j, double out[3])
{
    (void)patch;
    double phi = -2 * M_PI * (i % SPHERE_ACROSS) / SPHERE_ACROSS,
           theta = M_PI * (SPHERE_DOWN - j) / SPHERE_DOWN;
    double ring = j == 0 || j == SPHERE_DOWN ? 0 : sin(theta);
    out[0] = ring * cos(phi);
    out[1] = cos(theta);
    out[2] = ring * sin(phi);
}

static lf_status allocate_patches(lf_mesh_data *out, int n_patches, int across, int down,
                                  lf_error *err)
{
    size_t corners = (size_t)n_patches * (size_t)(across + 1) * (size_t)(down + 1);
    out->positions = lf_calloc(corners, 3 * sizeof *out->positions);
    out->triangles = lf_calloc((size_t)(2 * n_patches * across * down), 3 * sizeof *out->triangles);
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
        return; /* at the poles of the sphere */
    uint32_t t[3] = {(uint32_t)a, (uint32_t)b, (uint32_t)c};
    memcpy(out->triangles + 3 * (size_t)out->n_triangles++, t, sizeof t);
}

static void make_patches(lf_mesh_data *out, int n_patches, int across, int down, patch_fn corner)
{
    for (int patch = 0; patch < n_patches; patch++) {
        int base = out->n_vertices;
        for (int j = 0; j <= down; j++)
            for (int i = 0; i <= across; i++)
                corner(patch, i, j, out->positions + 3 * (size_t)out->n_vertices++);
        for (int j = 0; j < down; j++) {
            for (int i = 0; i < across; i++) {
                int at = base + j * (across + 1) + i, above = at + across + 1;
                append_triangle(out, at, at + 1, above + 1);
                append_triangle(out, at, above + 1, above);
            }
        }
    }
}

/* Normals of the unit sphere are its points. */
static lf_status sphere_normals(lf_mesh_data *out, lf_error *err)
{
    size_t n = 3 * (size_t)out->n_vertices;
    out->normals = lf_calloc(n, sizeof *out->normals);
    if (!out->normals)
        return lf_error_set(err, LF_E_NOMEM, "mesh", "out of memory");
    for (size_t i = 0; i < n; i++)
        out->normals[i] = (float)out->positions[i];
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

lf_status lf_mesh_shape_make(const lf_mesh_desc *desc, lf_mesh_data *out, lf_error *err)
{
    static const struct {
        int n_patches, across, down;
        patch_fn corner;
    } shapes[] = {[LF_SHAPE_QUAD] = {1, 1, 1, quad_corner},
                  [LF_SHAPE_CUBE] = {6, 1, 1, cube_corner},
                  [LF_SHAPE_SPHERE] = {1, SPHERE_ACROSS, SPHERE_DOWN, sphere_corner}};
    const int n = shapes[desc->shape].n_patches, across = shapes[desc->shape].across,
              down = shapes[desc->shape].down;
    lf_status status = allocate_patches(out, n, across, down, err);
    if (status != LF_OK)
        return status;
    make_patches(out, n, across, down, shapes[desc->shape].corner);
    if (desc->shape == LF_SHAPE_SPHERE && desc->normals != LF_NORMALS_FLAT)
        status = sphere_normals(out, err);
    if (status == LF_OK && desc->material < 0)
        status = grey_material(out, err);
    if (status == LF_OK)
        place(out, &desc->transform);
    return status;
}
