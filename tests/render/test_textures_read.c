/* Pictures that mesh files name: which there are, where they lie, what they change of a material,
 * and what is told of those that are not to be had. */
#include "tests/testing.h"

#include "base/file.h"
#include "render/import/scene/mesh_import.h"
#include "tests/base/pictures.h"
#include "tests/scene_file.h"

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
#define FACE "usemtl x\nf 1/1 2/2 3/3 4/4\n"

static lf_mesh_data import_named(const char *folder, const char *name, lf_normals normals)
{
    lf_mesh_desc desc = {.name = "m",
                         .file = name,
                         .material = -1,
                         .normals = normals,
                         .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    lf_roots roots = {0};
    lf_error err;
    lf_assert_ok(lf_roots_add(&roots, folder, &err), &err);
    lf_assert_ok(lf_mesh_import(&desc, folder, &roots, &data, &err), &err);
    lf_roots_finish(&roots);
    return data;
}

/* A square of one material, x, whose lines these are. */
static lf_mesh_data square_of(const char *folder, const char *lines)
{
    char text[1024];
    snprintf(text, sizeof text, "newmtl x\n%s\n", lines);
    lf_test_write(folder, "x.mtl", text);
    lf_test_write(folder, "x.obj", "mtllib x.mtl\n" SQUARE FACE);
    return import_named(folder, "x.obj", LF_NORMALS_FILE);
}

static void assert_silent(const lf_mesh_data *data)
{
    if (lf_warnings_at(&data->warnings, 0))
        fail_msg("%s", lf_warnings_at(&data->warnings, 0));
}

/* One line, which has these words. */
static void assert_told(const lf_mesh_data *data, const char *words)
{
    const char *line = lf_warnings_at(&data->warnings, 0);
    if (!line || !strstr(line, words) || lf_warnings_at(&data->warnings, 1))
        fail_msg("\"%s\" is not all: %s", words, line ? line : "nothing");
}

/* 2 x 2 texels of these channels. */
static void write_png(const char *folder, const char *name, int channels, const uint8_t *texels)
{
    uint8_t rows[16];
    memcpy(rows, texels, (size_t)(4 * channels));
    lf_picture_png(lf_test_path(folder, name), 2, 2, 8,
                   channels == 4   ? PNG_COLOR_TYPE_RGBA
                   : channels == 3 ? PNG_COLOR_TYPE_RGB
                                   : PNG_COLOR_TYPE_GRAY,
                   false, NULL, rows, (size_t)(2 * channels));
}

static const uint8_t opaque[12] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9};
static const uint8_t holes[16] = {255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 0, 9, 9, 9, 255};
static const uint8_t mask[4] = {0, 64, 128, 255};

static void a_picture_comes_with_its_mesh(void **state)
{
    write_png(*state, "a b.png", 3, opaque);
    lf_mesh_data data = square_of(*state, "Kd 1 0.5 0.25\nmap_Kd -s 2 3 -o 0.5 0.25 a b.png");
    assert_silent(&data);
    assert_int_equal(data.n_vertices, 4);
    assert_int_equal(data.n_uv_sets, 1);
    for (int v = 0; v < 4; v++) { /* the square's own */
        assert_true(data.uvs[2 * v] == (float)data.positions[3 * v]);
        assert_true(data.uvs[2 * v + 1] == (float)data.positions[3 * v + 1]);
    }
    assert_int_equal(data.n_pictures, 1);
    assert_true(data.pictures[0].width == 2 && data.pictures[0].height == 2);
    assert_memory_equal(data.pictures[0].rgba + 4, ((uint8_t[]){0, 255, 0, 255}), 4);
    const lf_texture *t = &data.textures[0].slot[LF_SLOT_BASE];
    assert_int_equal(t->picture, 1);
    assert_true(t->map[0][0] == 2 && t->map[0][2] == 0.5f);
    assert_true(t->map[1][1] == -3 && t->map[1][2] == 0.75f);
    assert_true(data.materials[0].albedo.y == 0.5f && data.materials[0].cover == LF_COVER_OPAQUE);
    assert_true(!data.tangents && !data.colours);
    assert_int_equal(data.n_files, 3); /* whose digests say which picture it is */
    lf_mesh_data_finish(&data);
}

static void black_beside_a_picture_is_white(void **state)
{
    static const char *const lines[] = {"map_Kd a.png\nKd 0 0 0", "map_Kd a.png",
                                        "map_Kd a.png\nKd 0.25 0 0"};
    write_png(*state, "a.png", 3, opaque);
    for (int i = 0; i < 3; i++) {
        lf_mesh_data data = square_of(*state, lines[i]);
        assert_true(data.materials[0].albedo.x == (i < 2 ? 1.0f : 0.25f));
        assert_true(data.materials[0].albedo.y == (i < 2 ? 1.0f : 0.0f));
        lf_mesh_data_finish(&data);
    }
}

static void what_glows_by_a_picture_glows_there_alone(void **state)
{
    write_png(*state, "a.png", 3, opaque);
    lf_mesh_data data = square_of(*state, "Kd 0.5 0.5 0.5\nKe 3 3 3\nmap_Ke a.png");
    assert_int_equal(data.textures[0].slot[LF_SLOT_EMISSION].picture, 1);
    assert_true(data.materials[0].emission.x == 3);
    lf_mesh_data_finish(&data);
    data = square_of(*state, "map_Ke a.png");
    assert_true(data.materials[0].emission.x == 1);
    lf_mesh_data_finish(&data);
    data = square_of(*state, "Ke 3 3 3\nmap_Ke gone.png");
    assert_told(&data, "material \"x\": texture \"gone.png\": missing");
    assert_true(data.materials[0].emission.x == 0 && !data.textures);
    lf_mesh_data_finish(&data);
}

static void what_is_not_to_be_had_is_told_once_a_material(void **state)
{
    lf_test_write(*state, "broken.png", "\x89PNG\r\n\x1a\nand nothing else");
    lf_test_write(*state, "a.ktx2", "\xabKTX 20\xbb\r\n\x1a\n");
    static const char *const lines[][2] = {
        {"map_Kd gone.png", "texture \"gone.png\": missing, or may not be read"},
        {"map_Kd gone.png\nnorm lost.png\nmap_Ke no.png", "texture \"gone.png\""},
        {"map_Kd broken.png", "texture \"broken.png\": PNG: "},
        {"map_Kd a.ktx2", "texture \"a.ktx2\": KTX2 images are not supported"},
        {"map_Kd x.mtl", "texture \"x.mtl\": not an image; expected PNG, JPEG or WebP"},
        {"map_Kd /etc/passwd", "texture \"passwd\": missing, or may not be read"},
        {"map_Kd ../../gone.png", "texture \"gone.png\": missing"},
        {"map_Ns gone.png", "only textures of colour"}};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char text[256];
        snprintf(text, sizeof text, "Kd 0.25 0 0\n%s", lines[i][0]);
        lf_mesh_data data = square_of(*state, text);
        assert_told(&data, lines[i][1]);
        assert_true(data.materials[0].albedo.x == 0.25f && !data.textures && !data.uvs);
        assert_int_equal(data.n_pictures, 0);
        lf_mesh_data_finish(&data);
    }
}

/* Wherever its author had them. */
static void pictures_of_other_folders_may_lie_beside_the_library(void **state)
{
    static const char *const lines[] = {"map_Kd C:\\Users\\me\\a.png", "map_Kd /home/me/a.png",
                                        "map_Kd textures/a.png"};
    write_png(*state, "a.png", 3, opaque);
    for (int i = 0; i < 3; i++) {
        lf_mesh_data data = square_of(*state, lines[i]);
        assert_silent(&data);
        assert_int_equal(data.n_pictures, 1);
        lf_mesh_data_finish(&data);
    }
}

static void a_picture_of_several_materials_is_read_once_and_of_unused_ones_never(void **state)
{
    write_png(*state, "a.png", 3, opaque);
    lf_test_write(*state, "x.mtl",
                  "newmtl x\nmap_Kd a.png\nnewmtl y\nmap_Kd a.png\nmap_Ke a.png\nnewmtl unused\n"
                  "map_Kd gone.png\n");
    lf_test_write(*state, "x.obj",
                  "mtllib x.mtl\n" SQUARE "usemtl x\nf 1/1 2/2 3/3\nusemtl y\nf 1/1 3/3 4/4\n");
    lf_mesh_data data = import_named(*state, "x.obj", LF_NORMALS_FILE);
    assert_silent(&data);
    assert_int_equal(data.n_pictures, 1);
    assert_int_equal(data.textures[0].slot[LF_SLOT_BASE].picture, 1);
    assert_int_equal(data.textures[1].slot[LF_SLOT_EMISSION].picture, 1);
    lf_mesh_data_finish(&data);
}

/* ---------------------------------------------------------------------------------- coverage -- */

static void alpha_covers_where_the_library_says_so(void **state)
{
    write_png(*state, "holes.png", 4, holes);
    write_png(*state, "opaque.png", 3, opaque);
    static const struct {
        const char *lines;
        lf_cover cover;
    } cases[] = {{"map_Kd holes.png", LF_COVER_OPAQUE},
                 {"map_Kd holes.png\nmap_d holes.png", LF_COVER_BLEND},
                 {"map_d holes.png\nmap_Kd holes.png", LF_COVER_BLEND},
                 {"map_Kd opaque.png\nmap_d opaque.png", LF_COVER_OPAQUE},
                 {"map_Kd holes.png\nd 0.5", LF_COVER_BLEND}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_mesh_data data = square_of(*state, cases[i].lines);
        assert_silent(&data);
        if (data.materials[0].cover != cases[i].cover || data.n_pictures != 1)
            fail_msg("%s: %d", cases[i].lines, (int)data.materials[0].cover);
        lf_mesh_data_finish(&data);
    }
}

static void a_mask_becomes_the_alpha_of_what_it_covers(void **state)
{
    write_png(*state, "mask.png", 1, mask);
    write_png(*state, "opaque.png", 3, opaque);
    lf_mesh_data data = square_of(*state, "map_Kd opaque.png\nmap_d mask.png");
    assert_silent(&data);
    assert_int_equal(data.n_pictures, 1); /* the mask itself is no part of the mesh */
    assert_int_equal(data.materials[0].cover, LF_COVER_BLEND);
    for (int i = 0; i < 4; i++) {
        assert_memory_equal(data.pictures[0].rgba + 4 * i, opaque + 3 * i, 3);
        assert_int_equal(data.pictures[0].rgba[4 * i + 3], mask[i]);
    }
    lf_mesh_data_finish(&data);
    data = square_of(*state, "Kd 0.5 0.25 0\nmap_d mask.png");
    assert_silent(&data);
    assert_int_equal(data.textures[0].slot[LF_SLOT_BASE].picture, 1);
    assert_true(data.materials[0].albedo.y == 0.25f);
    for (int i = 0; i < 4; i++)
        assert_memory_equal(data.pictures[0].rgba + 4 * i, ((uint8_t[]){255, 255, 255, mask[i]}),
                            4);
    lf_mesh_data_finish(&data);
}

/* ---------------------------------------------------------------------------------- vertices -- */

static void vertices_are_joined_by_their_coordinates_too(void **state)
{
    static const struct {
        const char *lines, *faces;
        int n;
    } cases[] = {{"map_Kd a.png", "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", 4},
                 {"map_Kd a.png", "f 1/1 2/2 3/3\nf 1/2 3/3 4/4\n", 5},
                 {"map_Kd a.png", "f 1/1 2/2 3/3\nf 1/9 3/3 4/-9\n", 4}, /* none is (0, 0) */
                 {"Kd 1 1 1", "f 1/1 2/2 3/3\nf 1/2 3/3 4/4\n", 4}};
    write_png(*state, "a.png", 3, opaque);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, "newmtl x\n%s\n", cases[i].lines);
        lf_test_write(*state, "x.mtl", text);
        snprintf(text, sizeof text, "mtllib x.mtl\n" SQUARE "usemtl x\n%s", cases[i].faces);
        lf_test_write(*state, "x.obj", text);
        lf_mesh_data data = import_named(*state, "x.obj", LF_NORMALS_FILE);
        assert_int_equal(data.n_vertices, cases[i].n);
        if (i == 2)
            assert_told(&data, "2 corners refer to missing texture coordinates");
        else
            assert_silent(&data);
        lf_mesh_data_finish(&data);
    }
}

/* Two sides of a roof, whose ridge is a seam. */
static void smooth_normals_go_on_across_a_seam(void **state)
{
    write_png(*state, "a.png", 3, opaque);
    lf_test_write(*state, "x.mtl", "newmtl x\nmap_Kd a.png\n");
    lf_test_write(*state, "x.obj",
                  "mtllib x.mtl\nv 0 1 0\nv 0 1 1\nv -1 0 0\nv 1 0 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                  "vt 1 1\nusemtl x\nf 1/1 3/2 2/3\nf 1/4 2/3 4/2\n");
    lf_mesh_data data = import_named(*state, "x.obj", LF_NORMALS_SMOOTH);
    assert_int_equal(data.n_vertices, 5);
    for (int v = 0; v < 5; v++)
        if (data.positions[3 * v + 1] == 1)
            lf_assert_close((double)data.normals[3 * v + 1], 1, 0, 1e-6);
    lf_mesh_data_finish(&data);
}

static void a_mesh_without_coordinates_has_no_pictures(void **state)
{
    write_png(*state, "a.png", 3, opaque);
    lf_test_write(*state, "x.mtl", "newmtl x\nKd 0.5 0 0\nKe 9 9 9\nmap_Kd a.png\nmap_Ke a.png\n");
    lf_test_write(*state, "x.obj", "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n");
    lf_mesh_data data = import_named(*state, "x.obj", LF_NORMALS_FILE);
    assert_told(&data, "2 textures are left out: the mesh has no texture coordinates");
    assert_true(data.materials[0].albedo.x == 0.5f && data.materials[0].emission.x == 0);
    assert_true(!data.textures && data.n_pictures == 0 && data.n_files == 2);
    lf_mesh_data_finish(&data);
}

/* ---------------------------------------------------------------------------------- tangents -- */

static const uint8_t flat_normals[12] = {128, 128, 255, 128, 128, 255, 128, 128, 255, 90, 160, 230};

/* Where the picture goes right as the tangent, where it goes up by the side, on a square whose
 * coordinates are turned, stretched or mirrored. */
static void tangents_follow_the_picture(void **state)
{
    static const struct {
        const char *uvs, *options;
        float tangent[3], up[3];
    } cases[] = {{"vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n", "", {1, 0, 0}, {0, 1, 0}},
                 {"vt 0 0\nvt 3 0\nvt 3 0.5\nvt 0 0.5\n", "", {1, 0, 0}, {0, 1, 0}},
                 {"vt 1 0\nvt 1 1\nvt 0 1\nvt 0 0\n", "", {0, -1, 0}, {1, 0, 0}},
                 {"vt 1 0\nvt 0 0\nvt 0 1\nvt 1 1\n", "", {-1, 0, 0}, {0, 1, 0}},
                 {"vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n", "-s 1 -1", {1, 0, 0}, {0, -1, 0}}};
    write_png(*state, "n.png", 3, flat_normals);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, "newmtl x\nnorm %s n.png\n", cases[i].options);
        lf_test_write(*state, "x.mtl", text);
        snprintf(text, sizeof text, "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n%s" FACE,
                 cases[i].uvs);
        lf_test_write(*state, "x.obj", text);
        lf_mesh_data data = import_named(*state, "x.obj", LF_NORMALS_FILE);
        assert_silent(&data);
        assert_int_equal(data.textures[0].slot[LF_SLOT_NORMAL].picture, 1);
        for (int v = 0; v < data.n_vertices; v++) {
            const float *n = data.normals + 3 * v, *t = data.tangents + 4 * v;
            const float b[3] = {t[3] * (n[1] * t[2] - n[2] * t[1]),
                                t[3] * (n[2] * t[0] - n[0] * t[2]),
                                t[3] * (n[0] * t[1] - n[1] * t[0])};
            for (int k = 0; k < 3; k++) {
                lf_assert_close((double)t[k], (double)cases[i].tangent[k], 0, 1e-6);
                lf_assert_close((double)b[k], (double)cases[i].up[k], 0, 1e-6);
            }
        }
        lf_mesh_data_finish(&data);
    }
}

/* A corner of a cube: faces that are flat have their own normals, and so frames. */
static void flat_faces_under_a_normal_map_keep_their_normals(void **state)
{
    write_png(*state, "n.png", 3, flat_normals);
    lf_test_write(*state, "x.mtl", "newmtl x\nnorm n.png\n");
    lf_test_write(*state, "x.obj",
                  "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
                  "usemtl x\nf 1/1 2/2 3/3\nf 1/1 3/2 4/3\nf 1/1 4/2 2/3\n");
    for (lf_normals how = LF_NORMALS_FILE; how <= LF_NORMALS_FLAT; how++) {
        lf_mesh_data data = import_named(*state, "x.obj", how);
        if (how != LF_NORMALS_SMOOTH) {
            assert_int_equal(data.n_vertices, 9);
            assert_true(data.normals[2] == 1);
        }
        assert_non_null(data.tangents);
        lf_mesh_data_finish(&data);
    }
}

static void a_bump_map_that_holds_normals_is_one(void **state)
{
    write_png(*state, "n.png", 3, flat_normals);
    write_png(*state, "h.png", 1, mask);
    lf_mesh_data data = square_of(*state, "map_Bump -bm 0.5 n.png");
    assert_silent(&data);
    assert_true(data.textures[0].slot[LF_SLOT_NORMAL].scale == 0.5f && data.tangents);
    lf_mesh_data_finish(&data);
    data = square_of(*state, "map_Bump h.png");
    assert_told(&data, "only textures of colour");
    assert_true(!data.textures && !data.tangents && data.n_pictures == 0);
    lf_mesh_data_finish(&data);
}

/* Beyond the folders that may be read, or nowhere: the mesh is there without it. */
static void a_gltf_file_does_without_pictures_that_are_not_to_be_had(void **state)
{
    static const char *const names[] = {"../n.png", "gone.png"};
    for (int i = 0; i < 2; i++) {
        char words[64];
        snprintf(words, sizeof words, "texture \"%s\" is missing or may not be read; ", names[i]);
        lf_test_write(*state, "x.gltf",
                      lf_test_scene_patched("gltf-textured-triangle", "{'images': [{'uri': '%s'}]}",
                                            names[i]));
        lf_mesh_data data = import_named(*state, "x.gltf", LF_NORMALS_FILE);
        assert_int_equal(data.n_triangles, 1);
        assert_true(!data.textures && data.n_pictures == 0);
        assert_non_null(strstr(lf_warnings_at(&data.warnings, 0), words));
        assert_int_equal(data.warnings.n, 1);
        lf_mesh_data_finish(&data);
    }
}

/* ---------------------------------------------------------------------------------- PLY, STL -- */

#define PLY_POINTS                                                                                 \
    "ply\nformat ascii 1.0\n%s"                                                                    \
    "element vertex 4\nproperty float x\n"                                                         \
    "property float y\nproperty float z\n%selement face 1\n"                                       \
    "property list uchar int vertex_indices\n%send_header\n"

static lf_mesh_data ply_of(const char *folder, const char *comments, const char *of_vertices,
                           const char *of_faces, const char *body)
{
    char text[1024];
    snprintf(text, sizeof text, PLY_POINTS "%s", comments, of_vertices, of_faces, body);
    lf_test_write(folder, "a.ply", text);
    return import_named(folder, "a.ply", LF_NORMALS_FILE);
}

#define RGB(type) "property " type " red\nproperty " type " green\nproperty " type " blue\n"

/* Bytes are display encoded, floats are not; white carries them. */
static void colours_of_vertices_are_albedo(void **state)
{
    static const struct {
        const char *properties, *codes[4];
        double red, alpha;
    } cases[] = {{RGB("uchar"), {"188 0 255", "188 0 255", "188 0 255", "188 0 255"}, 0.5029, 1},
                 {RGB("ushort"),
                  {"48316 0 65535", "48316 0 65535", "48316 0 65535", "48316 0 65535"},
                  0.5029,
                  1},
                 {RGB("float"), {"0.25 -1 7", "0.25 nan 1", "0.25 0 1", "0.25 0 1"}, 0.25, 1},
                 {RGB("uchar") "property uchar alpha\n",
                  {"188 0 255 51", "188 0 255 51", "188 0 255 51", "188 0 255 51"},
                  0.5029,
                  0.2},
                 {RGB("uchar") "property uchar alpha\n",
                  {"188 0 255 0", "188 0 255 0", "188 0 255 0", "188 0 255 0"},
                  0.5029,
                  1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char body[256];
        snprintf(body, sizeof body, "0 0 0 %s\n1 0 0 %s\n1 1 0 %s\n0 1 0 %s\n4 0 1 2 3\n",
                 cases[i].codes[0], cases[i].codes[1], cases[i].codes[2], cases[i].codes[3]);
        lf_mesh_data data = ply_of(*state, "", cases[i].properties, "", body);
        assert_silent(&data);
        assert_non_null(data.colours);
        for (int v = 0; v < 4; v++) {
            lf_assert_close((double)data.colours[4 * v], cases[i].red, 2e-4, 0);
            assert_true(data.colours[4 * v + 1] == 0 && data.colours[4 * v + 2] == 1);
            lf_assert_close((double)data.colours[4 * v + 3], cases[i].alpha, 1e-6, 0);
        }
        assert_true(data.materials[0].albedo.y == 1 && !data.uvs);
        assert_int_equal(data.materials[0].cover,
                         cases[i].alpha < 1 ? LF_COVER_BLEND : LF_COVER_OPAQUE);
        lf_mesh_data_finish(&data);
    }
}

static void points_of_two_colours_stay_two(void **state)
{
    lf_test_write(*state, "c.obj",
                  "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 1 0 0 0 0 0.5\nv 1 1 0 1 0 0\n"
                  "v 0 1 0 1 0 0\nf 1 2 3\nf 4 5 6\n");
    lf_mesh_data data = import_named(*state, "c.obj", LF_NORMALS_FILE);
    assert_silent(&data);
    assert_int_equal(data.n_vertices, 5);
    lf_assert_close((double)data.colours[4 * (size_t)data.triangles[3] + 2], 0.21404, 1e-4, 0);
    lf_mesh_data_finish(&data);
    /* where not all have one nobody has */
    lf_test_write(*state, "c.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n");
    data = import_named(*state, "c.obj", LF_NORMALS_FILE);
    assert_told(&data, "vertex colours are ignored because not every vertex has one");
    assert_true(!data.colours && data.materials[0].albedo.x == 0.5f);
    lf_mesh_data_finish(&data);
}

#define TEXTURE "comment TextureFile a b.png\n"
#define OF_CORNERS "property list uchar float texcoord\n"

static void a_ply_names_its_texture_in_a_comment(void **state)
{
    static const struct {
        const char *of_vertices, *of_faces, *body;
    } cases[] = {{"property float s\nproperty float t\n", "",
                  "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n"},
                 {"property float texture_u\nproperty float texture_v\n", "",
                  "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n"},
                 {"", OF_CORNERS, "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"},
                 {"", OF_CORNERS "property int texnumber\n",
                  "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1 1\n"}};
    write_png(*state, "a b.png", 3, opaque);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_mesh_data data =
            ply_of(*state, i == 3 ? "comment TextureFile gone.png\n" TEXTURE : TEXTURE,
                   cases[i].of_vertices, cases[i].of_faces, cases[i].body);
        const lf_texture *t = &data.textures[data.triangle_material[0]].slot[LF_SLOT_BASE];
        assert_silent(&data);
        assert_true(data.n_vertices == 4 && data.n_uv_sets == 1 && data.n_pictures == 1);
        assert_true(t->picture == 1 && t->map[1][1] == -1 && t->map[1][2] == 1);
        assert_true(data.materials[data.triangle_material[0]].albedo.x == 1);
        for (int v = 0; v < 4; v++)
            assert_true(data.uvs[2 * v] == (float)data.positions[3 * v] &&
                        data.uvs[2 * v + 1] == (float)data.positions[3 * v + 1]);
        lf_mesh_data_finish(&data);
    }
    lf_mesh_data data = ply_of(*state, TEXTURE, "", "", "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
    assert_told(&data, "1 texture is left out: the mesh has no texture coordinates");
    lf_mesh_data_finish(&data);
    data =
        ply_of(*state, "comment TextureFile gone.png\n", cases[0].of_vertices, "", cases[0].body);
    assert_told(&data, "a.ply: texture \"gone.png\": missing");
    assert_true(data.materials[0].albedo.x == 0.5f && !data.textures);
    lf_mesh_data_finish(&data);
}

/* Two facets; bits: the two bytes behind each. */
static lf_mesh_data stl_of(const char *folder, const char *title, const uint16_t bits[2])
{
    unsigned char bytes[184] = {0};
    const float corners[2][9] = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, 0, 1, 1, 0, 0, 1, 0}};
    memcpy(bytes, title, strlen(title));
    bytes[80] = 2;
    for (int i = 0; i < 2; i++) {
        memcpy(bytes + 84 + 50 * i + 12, corners[i], sizeof corners[i]);
        memcpy(bytes + 84 + 50 * i + 48, &bits[i], 2);
    }
    lf_picture_write(lf_test_path(folder, "a.stl"), bytes, sizeof bytes);
    return import_named(folder, "a.stl", LF_NORMALS_FILE);
}

static void facets_of_stl_have_colours_by_two_customs(void **state)
{
    static const struct {
        const char *title;
        uint16_t bits[2];
        float rgb[2][3];
    } cases[] = {{"", {0x8000 | 31 << 10, 0x8000 | 31 << 5}, {{1, 0, 0}, {0, 1, 0}}},
                 {"", {0, 0x8000 | 31}, {{0.5f, 0.5f, 0.5f}, {0, 0, 1}}},
                 {"COLOR=\xff\xff\x01\xff", {31, 0x8000}, {{1, 0, 0}, {1, 1, 0.000304f}}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_mesh_data data = stl_of(*state, cases[i].title, cases[i].bits);
        assert_silent(&data);
        assert_int_equal(data.n_vertices, 6);
        for (int t = 0; t < 6; t++)
            for (int c = 0; c < 3; c++)
                lf_assert_close((double)data.colours[4 * (size_t)data.triangles[t] + (size_t)c],
                                (double)cases[i].rgb[t / 3][c], 0, 1e-5);
        lf_mesh_data_finish(&data);
    }
    lf_mesh_data data = stl_of(*state, "none", (uint16_t[2]){0, 31});
    assert_silent(&data);
    assert_true(!data.colours && data.n_vertices == 4 && data.materials[0].albedo.x == 0.5f);
    lf_mesh_data_finish(&data);
}

static void the_cow_has_its_spots(void **state)
{
    const char *mesh = lf_test_shared("meshes/spot.obj"),
               *picture = lf_test_shared("meshes/spot_texture.png");
    size_t n, size;
    char *text, *bytes;
    lf_error err;
    if (!mesh || !picture)
        skip();
    lf_assert_ok(lf_file_read(mesh, NULL, 1 << 26, &text, &n, &err), &err);
    lf_assert_ok(lf_file_read(picture, NULL, 1 << 26, &bytes, &size, &err), &err);
    FILE *file = fopen(lf_test_path(*state, "spot.obj"), "wb");
    assert_non_null(file);
    fprintf(file, "mtllib spot.mtl\nusemtl spot\n");
    assert_int_equal(fwrite(text, 1, n, file), n);
    fclose(file);
    lf_picture_write(lf_test_path(*state, "spot_texture.png"), bytes, size);
    lf_test_write(*state, "spot.mtl", "newmtl spot\nKd 0 0 0\nmap_Kd spot_texture.png\n");
    lf_mesh_data data = import_named(*state, "spot.obj", LF_NORMALS_FILE);
    assert_silent(&data);
    assert_int_equal(data.n_pictures, 1);
    assert_int_equal(data.n_triangles, 5856);
    for (int v = 0; v < 2 * data.n_vertices; v++)
        assert_true(data.uvs[v] > -0.1f && data.uvs[v] < 1.1f);
    lf_mesh_data_finish(&data);
    free(text);
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_picture_comes_with_its_mesh),
        lf_test_in_folder(black_beside_a_picture_is_white),
        lf_test_in_folder(what_glows_by_a_picture_glows_there_alone),
        lf_test_in_folder(what_is_not_to_be_had_is_told_once_a_material),
        lf_test_in_folder(pictures_of_other_folders_may_lie_beside_the_library),
        lf_test_in_folder(a_picture_of_several_materials_is_read_once_and_of_unused_ones_never),
        lf_test_in_folder(alpha_covers_where_the_library_says_so),
        lf_test_in_folder(a_mask_becomes_the_alpha_of_what_it_covers),
        lf_test_in_folder(vertices_are_joined_by_their_coordinates_too),
        lf_test_in_folder(smooth_normals_go_on_across_a_seam),
        lf_test_in_folder(a_mesh_without_coordinates_has_no_pictures),
        lf_test_in_folder(tangents_follow_the_picture),
        lf_test_in_folder(flat_faces_under_a_normal_map_keep_their_normals),
        lf_test_in_folder(a_bump_map_that_holds_normals_is_one),
        lf_test_in_folder(a_gltf_file_does_without_pictures_that_are_not_to_be_had),
        lf_test_in_folder(colours_of_vertices_are_albedo),
        lf_test_in_folder(points_of_two_colours_stay_two),
        lf_test_in_folder(a_ply_names_its_texture_in_a_comment),
        lf_test_in_folder(facets_of_stl_have_colours_by_two_customs),
        lf_test_in_folder(the_cow_has_its_spots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
