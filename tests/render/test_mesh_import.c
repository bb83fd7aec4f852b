#include "tests/testing.h"

#include "base/alloc.h"
#include "render/import/scene/mesh_import.h"
#include "render/scene/geometry.h"
#include "render/scene/scene.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* A mesh of a file as the scene would describe it: its own materials, nothing moved. */
static lf_mesh_desc of_file(const char *file)
{
    return (lf_mesh_desc){
        .name = "m", .file = file, .material = -1, .transform = lf_affine_identity()};
}

static lf_mesh_data imported(const lf_mesh_desc *desc, const char *folder)
{
    lf_mesh_data data = {0};
    lf_error err;
    lf_assert_ok(lf_mesh_import(desc, folder, NULL, &data, &err), &err);
    assert_true(data.n_triangles > 0 && data.n_vertices > 0);
    return data;
}

static lf_mesh_data imported_file(const char *file, const char *folder)
{
    lf_mesh_desc desc = of_file(file);
    return imported(&desc, folder);
}

static lf_mesh_data imported_obj(const char *text, const char *folder)
{
    lf_test_write(folder, "a.obj", text);
    return imported_file("a.obj", folder);
}

static void assert_refused(const char *file, const char *folder, lf_status expected,
                           const char *text)
{
    lf_mesh_desc desc = of_file(file);
    lf_mesh_data data = {0};
    lf_error err = {0};
    lf_assert_status(lf_mesh_import(&desc, folder, NULL, &data, &err), expected, &err);
    lf_mesh_data_finish(&data);
    if (!strstr(err.what, text))
        fail_msg("%s: \"%s\" does not say \"%s\"", file, err.what, text);
    assert_true(strstr(err.where, file));
}

static const double *corner(const lf_mesh_data *data, int triangle, int c)
{
    return data->positions + 3 * (size_t)data->triangles[3 * triangle + c];
}

/* Twice the area times the unit normal of a triangle. */
static void area_vector(const lf_mesh_data *data, int triangle, double out[3])
{
    const double *a = corner(data, triangle, 0), *b = corner(data, triangle, 1),
                 *c = corner(data, triangle, 2);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
    }
}

static double total_area(const lf_mesh_data *data)
{
    double sum = 0, n[3];
    for (int t = 0; t < data->n_triangles; t++) {
        area_vector(data, t, n);
        sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return sum;
}

/* Six times the enclosed volume: positive when the faces of a closed mesh look outwards. */
static double signed_volume(const lf_mesh_data *data)
{
    double sum = 0, n[3];
    for (int t = 0; t < data->n_triangles; t++) {
        const double *a = corner(data, t, 0);
        area_vector(data, t, n);
        sum += a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
    }
    return sum / 6;
}

static const char *const SQUARE = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nf 1 2 3 4\n";

/* ------------------------------------------------------------------------------------- files -- */

static void polygons_are_split_and_points_and_lines_left_out(void **state)
{
    lf_mesh_data data = imported_obj(
        "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nv 9 9 9\np 5\nl 1 5\nf 1 2 3 4\n", *state);
    assert_int_equal(data.n_triangles, 2);
    assert_int_equal(data.n_vertices, 4);
    assert_null(data.normals);
    lf_assert_close(total_area(&data), 6, 1e-12, 0);
    assert_int_equal(data.n_files, 1);
    lf_mesh_data_finish(&data);
}

static void the_scenes_transform_moves_positions_in_double(void **state)
{
    lf_test_write(*state, "a.obj", SQUARE);
    lf_mesh_desc desc = of_file("a.obj");
    desc.transform = (lf_affine){{{0, -1, 0, 1e8 + 0.125}, {1, 0, 0, 0}, {0, 0, 1, -3}}};
    lf_mesh_data data = imported(&desc, *state);
    double low = INFINITY, high = -INFINITY;
    for (int v = 0; v < data.n_vertices; v++) {
        low = fmin(low, data.positions[3 * v]);
        high = fmax(high, data.positions[3 * v]);
        assert_true(data.positions[3 * v + 2] == -3);
    }
    assert_true(high == 1e8 + 0.125 && low == 1e8 + 0.125 - 3);
    lf_mesh_data_finish(&data);
}

static void normals_are_the_files_or_smooth_or_flat(void **state)
{
    /* A roof: two faces that share a ridge; the file's normals all look up. */
    lf_test_write(*state, "roof.obj",
                  "v -1 0 0\nv -1 0 2\nv 0 1 0\nv 0 1 2\nv 1 0 0\nv 1 0 2\nvn 0 1 0\n"
                  "f 1//1 2//1 4//1 3//1\nf 3//1 4//1 6//1 5//1\n");
    lf_mesh_desc desc = of_file("roof.obj");
    lf_mesh_data data = imported(&desc, *state);
    assert_non_null(data.normals);
    for (int v = 0; v < data.n_vertices; v++)
        assert_true(data.normals[3 * v + 1] == 1.0f);
    lf_mesh_data_finish(&data);
    desc.normals = LF_NORMALS_FLAT;
    data = imported(&desc, *state);
    assert_null(data.normals);
    assert_int_equal(data.n_vertices, 6);
    lf_mesh_data_finish(&data);
    desc.normals = LF_NORMALS_SMOOTH;
    data = imported(&desc, *state);
    for (int v = 0; v < data.n_vertices; v++) {
        const double *p = data.positions + 3 * v;
        const float *n = data.normals + 3 * v;
        /* across the slopes at the eaves, up on the ridge */
        lf_assert_close(n[0], p[0] * M_SQRT1_2, 0, 1e-5);
        lf_assert_close(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-5, 0);
    }
    lf_mesh_data_finish(&data);
}

static void normals_follow_a_stretching_transform(void **state)
{
    lf_test_write(*state, "a.obj",
                  "v 0 0 0\nv 1 -1 0\nv 0 0 1\nvn 0.70710678 0.70710678 0\nf 1//1 3//1 2//1\n");
    lf_mesh_desc desc = of_file("a.obj");
    desc.transform.m[0][0] = 3;
    lf_mesh_data data = imported(&desc, *state);
    double n[3];
    area_vector(&data, 0, n);
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++)
        lf_assert_close(data.normals[i], n[i] / length, 0, 1e-6);
    lf_assert_close(data.normals[0], 1 / sqrt(10), 1e-5, 0);
    lf_mesh_data_finish(&data);
}

static void a_mirror_keeps_faces_and_normals_outside(void **state)
{
    (void)state;
    lf_mesh_desc desc = {.name = "m", .shape = &lf_mesh_sphere, .transform = lf_affine_identity()};
    lf_error err;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        lf_mesh_data data = {0};
        desc.transform.m[1][1] = mirrored ? -2 : 2;
        lf_assert_ok(lf_mesh_shape_make(&desc, &data, &err), &err);
        lf_assert_close(signed_volume(&data), 4.0 / 3 * M_PI * 2, 0.01, 0);
        for (int v = 0; v < data.n_vertices; v++) {
            const double *p = data.positions + 3 * v;
            const float *n = data.normals + 3 * v;
            assert_true(p[0] * (double)n[0] + p[1] * (double)n[1] + p[2] * (double)n[2] > 0.5);
        }
        lf_mesh_data_finish(&data);
    }
}

static void obj_materials_become_ours(void **state)
{
    lf_test_write(*state, "m.mtl",
                  "newmtl matte\nKd 0.2 0.4 0.6\nKs 0 0 0\n"
                  "newmtl shiny\nKd 0.5 0.1 0.1\nKs 0.3 0.3 0.3\nNs 30\nNi 1.4\n"
                  "newmtl steel\nKd 0 0 0\nKs 0.7 0.8 0.9\nNs 1998\n"
                  "newmtl lamp\nKd 0 0 0\nKe 5 4 3\n");
    lf_test_write(*state, "m.obj",
                  "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl matte\nf 1 2 3\nusemtl "
                  "shiny\nf 1 2 4\n"
                  "usemtl steel\nf 1 3 4\nusemtl lamp\nf 2 3 4\n");
    lf_mesh_desc desc = of_file("m.obj");
    lf_mesh_data data = imported(&desc, *state);
    assert_int_equal(data.n_files, 2);
    int seen[4] = {0};
    for (int t = 0; t < data.n_triangles; t++) {
        const lf_material *m = &data.materials[data.triangle_material[t]];
        if (m->emission.x > 0) {
            assert_true(m->emission.x == 5 && m->emission.z == 3);
            seen[3]++;
        } else if (m->kind == &lf_surface_diffuse) {
            lf_assert_close(m->albedo.y, 0.4, 1e-6, 0);
            seen[0]++;
        } else if (m->kind == &lf_surface_plastic) {
            lf_assert_close(m->roughness, pow(2.0 / 32, 0.25), 1e-5, 0);
            lf_assert_close(m->ior, 1.4, 1e-6, 0);
            lf_assert_close(m->albedo.x, 0.5, 1e-6, 0);
            seen[1]++;
        } else {
            lf_assert_close(m->albedo.z, 0.9, 1e-6, 0);
            lf_assert_close(m->roughness, pow(2.0 / 2000, 0.25), 1e-5, 0);
            seen[2]++;
        }
    }
    assert_true(seen[0] == 1 && seen[1] == 1 && seen[2] == 1 && seen[3] == 1);
    lf_mesh_data_finish(&data);
    /* A name of the scene's replaces them all. */
    desc.material = 0;
    data = imported(&desc, *state);
    assert_int_equal(data.n_materials, 0);
    assert_null(data.triangle_material);
    lf_mesh_data_finish(&data);
}

static void a_mesh_without_materials_is_grey(void **state)
{
    lf_mesh_data data = imported_obj(SQUARE, *state);
    const lf_material *m = &data.materials[data.triangle_material[0]];
    assert_true(m->kind == &lf_surface_diffuse && m->albedo.x == 0.5f && m->emission.x == 0.0f);
    lf_mesh_data_finish(&data);
}

static void write_corners(const char *folder)
{
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    FILE *file = fopen(lf_test_path(folder, "tri.bin"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(corners, sizeof corners, 1, file), 1);
    fclose(file);
}

/* Two nodes in another one, a mesh in each, two materials by their factors. */
static void gltf_nodes_and_factors_arrive(void **state)
{
    write_corners(*state);
    lf_test_write(*state, "a.gltf", lf_test_scene_text("gltf-two-nodes"));
    lf_mesh_data data = imported_file("a.gltf", *state);
    assert_int_equal(data.n_triangles, 2);
    assert_int_equal(data.n_files, 2);
    for (int t = 0; t < 2; t++) {
        const lf_material *m = &data.materials[data.triangle_material[t]];
        double n[3];
        area_vector(&data, t, n);
        if (corner(&data, t, 0)[2] == 0) {
            assert_true(m->metallic == 1 && m->roughness == 0.25f);
            lf_assert_close(m->albedo.y, 0.6, 1e-6, 0);
            assert_true(corner(&data, t, 0)[0] == 10 && n[2] == 4);
        } else {
            assert_true(m->metallic == 0 && m->roughness == 0.5f && m->emission.x == 1 &&
                        m->emission.y == 0.5f);
            assert_true(corner(&data, t, 0)[2] == 7 && n[2] == 1);
        }
    }
    lf_mesh_data_finish(&data);
}

/* Three triangles whose materials have colours and no names, and a fourth without a material. */
static void materials_without_a_name_keep_their_colours(void **state)
{
    write_corners(*state);
    lf_test_write(*state, "nameless.gltf", lf_test_scene_text("gltf-nameless-materials"));
    lf_test_write(*state, "nameless.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
                  "y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nelement material "
                  "1\nproperty float diffuse_red\n"
                  "property float diffuse_green\nproperty float diffuse_blue\nend_header\n0 0 0\n1 "
                  "0 0\n0 1 0\n3 0 1 2\n0.25 0.5 1\n");
    lf_mesh_data data = imported_file("nameless.gltf", *state);
    assert_int_equal(data.n_triangles, 4);
    const lf_material *m[4];
    for (int i = 0; i < 4; i++)
        m[i] = &data.materials[data.triangle_material[i]];
    assert_true(m[0]->albedo.x == 0.9f && m[0]->albedo.y == 0.0f && m[0]->metallic == 0.0f);
    assert_true(m[1]->albedo.y == 0.8f && m[1]->albedo.x == 0.0f && m[1]->metallic == 1.0f);
    assert_true(m[2]->emission.z == 1.0f);
    assert_true(m[3]->albedo.x == 0.5f && m[3]->albedo.y == 0.5f && m[3]->emission.x == 0.0f &&
                m[3]->kind == &lf_surface_diffuse);
    lf_mesh_data_finish(&data);
    data = imported_file("nameless.ply", *state);
    const lf_material *blue = &data.materials[data.triangle_material[0]];
    assert_true(blue->albedo.x == 0.25f && blue->albedo.y == 0.5f && blue->albedo.z == 1.0f);
    lf_mesh_data_finish(&data);
    lf_test_write(*state, "plain.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
                  "y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
                  "0\n0 1 0\n3 0 1 2\n");
    data = imported_file("plain.ply", *state);
    assert_true(data.materials[data.triangle_material[0]].albedo.x == 0.5f);
    lf_mesh_data_finish(&data);
}

static void ply_and_stl_are_read(void **state)
{
    lf_test_write(*state, "a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
                  "y\nproperty float z\nelement face 1\n"
                  "property list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 3 0\n0 3 "
                  "0\n4 0 1 2 3\n");
    lf_test_write(*state, "a.stl",
                  "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 6 "
                  "0\nendloop\nendfacet\nendsolid a\n");
    static const char *const files[] = {"a.ply", "a.stl"};
    for (int i = 0; i < 2; i++) {
        lf_mesh_data data = imported_file(files[i], *state);
        lf_assert_close(total_area(&data), 6, 1e-6, 0);
        lf_mesh_data_finish(&data);
    }
}

static void useless_triangles_are_dropped_and_the_rest_kept(void **state)
{
    lf_mesh_data data = imported_obj(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1e30 0 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf "
        "1 2 5\nf 1 1 2\nf 1 2 6\n",
        *state);
    assert_int_equal(data.n_triangles, 1);
    for (int i = 0; i < 3 * data.n_vertices; i++)
        assert_true(fabs(data.positions[i]) <= 2);
    lf_mesh_data_finish(&data);
}

static void malformed_files_are_refused_in_words(void **state)
{
    const char *folder = *state;
    lf_test_write(folder, "empty.obj", "");
    lf_test_write(folder, "words.obj", "this is not a mesh\nat all\n");
    lf_test_write(folder, "index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n");
    lf_test_write(folder, "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n");
    lf_test_write(folder, "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    lf_test_write(
        folder, "short.ply",
        "ply\nformat ascii 1.0\nelement vertex 400000000\nproperty float x\nend_header\n0\n");
    lf_test_write(folder, "short.glb", "glTF\x02");
    lf_test_write(folder, "garbage.stl", "\x01\x02\x03\x04garbage");
    lf_test_write(folder, "nobin.gltf",
                  lf_test_scene_text("gltf-two-nodes")); /* tri.bin is not there */
    lf_test_write(folder, "no.gltf",
                  "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
                  "\"POSITION\":7}}]}]}");
    lf_test_write(folder, "json.gltf", "{\"asset\":");
    assert_refused("empty.obj", folder, LF_E_FORMAT, "");
    assert_refused("words.obj", folder, LF_E_FORMAT, "");
    assert_refused("points.obj", folder, LF_E_FORMAT, "no triangles in this file");
    assert_refused("flat.obj", folder, LF_E_FORMAT, "no usable triangle");
    assert_refused("short.ply", folder, LF_E_FORMAT,
                   "announces at least 800000000 bytes of elements, but the file has 76");
    assert_refused("short.glb", folder, LF_E_FORMAT, "cannot be read as a mesh");
    assert_refused("garbage.stl", folder, LF_E_FORMAT, "cannot be read as a mesh");
    assert_refused("no.gltf", folder, LF_E_FORMAT, "");
    assert_refused("json.gltf", folder, LF_E_FORMAT, "cannot be read as a mesh");
    assert_refused("absent.obj", folder, LF_E_IO, "");
    lf_mesh_desc desc = of_file("nobin.gltf");
    lf_mesh_data data = {0};
    lf_error err;
    assert_int_not_equal(lf_mesh_import(&desc, folder, NULL, &data, &err), LF_OK);
    /* the file that is missing is the one that is named */
    assert_true(strstr(err.where, "tri.bin"));
    lf_mesh_data_finish(&data);
    /* A face that points beyond the vertices is refused or dropped, never followed. */
    desc = of_file("index.obj");
    lf_status status = lf_mesh_import(&desc, folder, NULL, &data, &err);
    assert_true(status == LF_E_FORMAT && data.n_triangles == 0);
    lf_mesh_data_finish(&data);
}

static void a_missing_material_library_is_no_reason_to_refuse_a_mesh(void **state)
{
    lf_mesh_data data =
        imported_obj("mtllib gone.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", *state);
    assert_int_equal(data.n_triangles, 1);
    lf_mesh_data_finish(&data);
}

/* ------------------------------------------------------------------------------------ shapes -- */

static void shapes_are_what_the_manual_says(void **state)
{
    (void)state;
    static const struct {
        const lf_mesh_shape *shape;
        int n_triangles;
        double area, volume;
    } cases[] = {{&lf_mesh_quad, 2, 4, 0},
                 {&lf_mesh_cube, 12, 24, 8},
                 {&lf_mesh_sphere, 16128, 4 * M_PI, 4 * M_PI / 3},
                 {&lf_mesh_disk, 128, M_PI, 0}};
    for (int i = 0; i < 4; i++) {
        lf_mesh_desc desc = {
            .shape = cases[i].shape, .material = -1, .transform = lf_affine_identity()};
        lf_mesh_data data = {0};
        lf_error err;
        lf_assert_ok(lf_mesh_shape_make(&desc, &data, &err), &err);
        assert_int_equal(data.n_triangles, cases[i].n_triangles);
        lf_assert_close(total_area(&data), cases[i].area, 2e-3, 0);
        lf_assert_close(signed_volume(&data), cases[i].volume, 2e-3, 1e-12);
        assert_int_equal(data.n_materials, 1);
        assert_int_equal(!!data.normals, cases[i].shape == &lf_mesh_sphere);
        double n[3];
        area_vector(&data, 0, n);
        if (cases[i].shape == &lf_mesh_quad)
            assert_true(n[0] == 0 && n[1] == 4 && n[2] == 0);
        if (cases[i].shape == &lf_mesh_disk)
            assert_true(n[0] == 0 && n[1] > 0 && n[2] == 0);
        lf_mesh_data_finish(&data);
        desc.normals = LF_NORMALS_FLAT;
        lf_assert_ok(lf_mesh_shape_make(&desc, &data, &err), &err);
        assert_null(data.normals);
        lf_mesh_data_finish(&data);
    }
    assert_null(lf_mesh_shapes[4]); /* the next has a row above, too */
}

/* --------------------------------------------------------------------------------- committed -- */

/* Distance along a ray in scene-local coordinates, INFINITY when nothing is hit; *out_mesh is whose
 * triangle. */
static float trace(const lf_scene *scene, lf_vec3 from, lf_vec3 along, unsigned *out_mesh)
{
    struct RTCRayHit ray = {.ray = {.org_x = from.x,
                                    .org_y = from.y,
                                    .org_z = from.z,
                                    .dir_x = along.x,
                                    .dir_y = along.y,
                                    .dir_z = along.z,
                                    .tfar = INFINITY,
                                    .mask = ~0u}};
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    lf_embree_intersect(scene->embree, &ray);
    *out_mesh = ray.hit.geomID;
    return ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : ray.ray.tfar;
}

static void rays_meet_the_meshes_in_their_order(void **state)
{
    (void)state;
    lf_scene *scene =
        lf_test_scene("{'meshes': {'low': {'shape': 'quad'}, 'high': {'shape': 'quad',"
                      "'transform': {'scale': 0.5, 'translate': [0, 2, 0]}}}}");
    unsigned mesh;
    lf_assert_close(trace(scene, lf_v3(0.1f, 5, 0.2f), lf_v3(0, -1, 0), &mesh), 3, 1e-6, 0);
    assert_int_equal(mesh, 1);
    lf_assert_close(trace(scene, lf_v3(0.8f, 5, 0.2f), lf_v3(0, -1, 0), &mesh), 5, 1e-6, 0);
    assert_int_equal(mesh, 0);
    assert_true(trace(scene, lf_v3(1.1f, 5, 0.2f), lf_v3(0, -1, 0), &mesh) == INFINITY);
    lf_scene_unref(scene);
}

static void a_scene_far_away_loses_nothing(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{'meshes': {'q': {'shape': 'quad', 'transform': "
                                    "{'translate': [3e8, 0.0625, 7e8]}}}}");
    unsigned mesh;
    assert_true(scene->origin[0] == 3e8 && scene->origin[2] == 7e8);
    const float *v = scene->meshes[0].vertices;
    assert_true(fabsf(v[0]) == 1.0f && v[1] == 0.0625f && fabsf(v[2]) == 1.0f);
    lf_assert_close(trace(scene, lf_v3(0.5f, 1, 0.5f), lf_v3(0, -1, 0), &mesh), 0.9375, 1e-6, 0);
    lf_scene_unref(scene);
}

static void materials_of_files_and_of_the_scene_share_one_table(void **state)
{
    lf_test_write(*state, "m.mtl", "newmtl red\nKd 1 0 0\n");
    lf_test_write(*state, "m.obj",
                  "mtllib m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    lf_scene *scene =
        lf_test_scene_in(*state,
                         "{'materials': {'a': {'albedo': 0.25}}, 'meshes': {'x': {'shape': "
                         "'quad'}, 'own':"
                         "{'file': 'm.obj'}, 'named': {'file': 'm.obj', 'material': 'a'}}}",
                         NULL);
    const lf_mesh *grey = &scene->meshes[0], *own = &scene->meshes[1], *named = &scene->meshes[2];
    assert_true(scene->materials[grey->triangle_material[1]].albedo.x == 0.5f);
    const lf_material *red = &scene->materials[own->triangle_material[0]];
    assert_true(red->albedo.x == 1.0f && red->albedo.y == 0.0f);
    assert_null(named->triangle_material);
    assert_true(scene->materials[named->material].albedo.x == 0.25f);
    lf_scene_unref(scene);
}

static void the_shared_meshes_are_read(void **state)
{
    (void)state;
    static const struct {
        const char *file;
        int n_triangles;
    } cases[] = {{"meshes/spot.obj", 5856},
                 {"meshes/BoxVertexColors.glb", 12},
                 {"meshes/ShapeCollection.glb", 3542},
                 {"meshes/babylon_cornellBox.glb", 4006},
                 {"meshes/stanford_dragon_res4.ply", 11102},
                 {"meshes/babylon_shaderBall.glb", 3392},
                 {"meshes/babylon_roundedCube.glb", 300},
                 {"references/bunny_zup.ply", 69666}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *path = lf_test_shared(cases[i].file);
        if (!path)
            skip();
        lf_mesh_data data = imported_file(path, ".");
        assert_int_equal(data.n_triangles, cases[i].n_triangles);
        lf_mesh_data_finish(&data);
    }
}

#define IN_FOLDER(test)                                                                            \
    cmocka_unit_test_setup_teardown(test, lf_test_folder_setup, lf_test_folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(polygons_are_split_and_points_and_lines_left_out),
        IN_FOLDER(the_scenes_transform_moves_positions_in_double),
        IN_FOLDER(normals_are_the_files_or_smooth_or_flat),
        IN_FOLDER(normals_follow_a_stretching_transform),
        cmocka_unit_test(a_mirror_keeps_faces_and_normals_outside),
        IN_FOLDER(obj_materials_become_ours),
        IN_FOLDER(a_mesh_without_materials_is_grey),
        IN_FOLDER(gltf_nodes_and_factors_arrive),
        IN_FOLDER(materials_without_a_name_keep_their_colours),
        IN_FOLDER(ply_and_stl_are_read),
        IN_FOLDER(useless_triangles_are_dropped_and_the_rest_kept),
        IN_FOLDER(malformed_files_are_refused_in_words),
        IN_FOLDER(a_missing_material_library_is_no_reason_to_refuse_a_mesh),
        cmocka_unit_test(shapes_are_what_the_manual_says),
        cmocka_unit_test(rays_meet_the_meshes_in_their_order),
        cmocka_unit_test(a_scene_far_away_loses_nothing),
        IN_FOLDER(materials_of_files_and_of_the_scene_share_one_table),
        cmocka_unit_test(the_shared_meshes_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
