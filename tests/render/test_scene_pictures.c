/* Pictures of materials of the scene's own, and materials of the scene in the place of a file's: in
 * closed form, as the same said another way, across patches, and refused where something is wrong.
 */
#include "tests/testing.h"

#include "render/import/scene/mesh_import.h"
#include "render/scene/geometry.h"
#include "render/transport/surface/surface.h"
#include "tests/base/pictures.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* A quad seen from above, -z at the top, that fills three quarters of each side of the view. */
#define FROM_ABOVE                                                                                 \
    "'camera': {'position': [0, 10, 0], 'target': [0, 0, 0], 'up': [0, 0, -1], 'cone': 0, "        \
    "'fov_y': 15.2, 'views': 1}"
#define SKY "'lights': {'sky': {'type': 'environment', 'radiance': 1}}"
#define QUAD "'meshes': {'q': {'shape': 'quad', 'material': 'm'}}"

enum { SIDE = 32 };

static void write_rgba(const char *folder, const char *name, int width, int height,
                       const uint8_t *texels)
{
    uint8_t rows[4 * 64];
    const size_t n = (size_t)(4 * width * height);
    assert_true(n <= sizeof rows);
    memcpy(rows, texels, n);
    lf_picture_png(lf_test_path(folder, name), width, height, 8, PNG_COLOR_TYPE_RGBA, false, NULL,
                   rows, (size_t)(4 * width));
}

/* One colour. */
static void write_plain(const char *folder, const char *name, int r, int g, int b, int a)
{
    const uint8_t texel[4] = {(uint8_t)r, (uint8_t)g, (uint8_t)b, (uint8_t)a};
    write_rgba(folder, name, 1, 1, texel);
}

static lf_scene *scene_of(const char *folder, const char *members, const lf_scene *previous)
{
    char text[4096];
    snprintf(text, sizeof text, "{%s}", members);
    return lf_test_scene_in(folder, text, previous);
}

/* [SIDE][SIDE], by vpt. The scene is released. */
static double *seen(lf_scene *scene, int passes)
{
    lf_renderer *r = lf_test_renderer(scene, "vpt", SIDE, SIDE, NULL);
    lf_test_passes(r, passes);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return picture;
}

/* The mean of the middle 4 x 4 pixels of a quarter: 0 upper left, 1 upper right, 2 lower left. */
static double quarter(const double *picture, int which)
{
    double sum = 0;
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++)
            sum += picture[(8 + which / 2 * 13 + y) * SIDE + 8 + which % 2 * 13 + x] / 16;
    return sum;
}

static double grey(double r, double g, double b)
{
    return 0.5 * r + 0.3 * g + 0.2 * b;
}

/* What an sRGB code is of light. */
static double light_of(int code)
{
    const double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

/* ------------------------------------------------------------------------------ closed forms -- */

static void a_texel_is_seen_as_its_albedo_times_the_light(void **state)
{
    static const uint8_t texels[16] = {255, 0, 0,   255, 0,   255, 0,   255,
                                       0,   0, 255, 255, 188, 188, 188, 255};
    const double want[4] = {0.5, 0.3, 0.2, light_of(188)};
    write_rgba(*state, "four.png", 2, 2, texels);
    double *picture = seen(scene_of(*state,
                                    FROM_ABOVE "," SKY "," QUAD ", 'materials': {'m': {'albedo': "
                                               "{'file': 'four.png', 'interpolation': 'nearest', "
                                               "'scale': 0.5}}}",
                                    NULL),
                           40);
    for (int i = 0; i < 4; i++)
        lf_assert_close(quarter(picture, i), 0.5 * want[i], 0.01, 0);
    free(picture);
}

/* Half of the picture's height downwards, a quarter turn, twice as often: where each is. */
static void a_transform_moves_turns_and_repeats(void **state)
{
    static const uint8_t texels[16] = {255, 0, 0,   255, 0,   255, 0,   255,
                                       0,   0, 255, 255, 255, 255, 255, 255};
    static const struct {
        const char *transform;
        double want[4];
    } cases[] = {
        {"'offset': [0, 0.5]", {0.2, 1.0, 0.5, 0.3}},
        {"'rotate': 90", {0.2, 0.5, 1.0, 0.3}}, /* u' = v, v' = -u */
        {"'scale': [1, 0.5], 'offset': [0.5, 0]", {0.3, 0.5, 0.3, 0.5}},
    };
    write_rgba(*state, "four.png", 2, 2, texels);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char members[1024];
        snprintf(members, sizeof members,
                 FROM_ABOVE "," SKY "," QUAD ", 'materials': {'m': {'albedo': {'file': "
                            "'four.png', 'interpolation': 'nearest', 'transform': {%s}}}}",
                 cases[i].transform);
        double *picture = seen(scene_of(*state, members, NULL), 40);
        for (int k = 0; k < 4; k++)
            lf_assert_close(quarter(picture, k), cases[i].want[k], 0.01, 0);
        free(picture);
    }
}

/* Half there: half of what is behind it. */
static void alpha_is_how_much_is_there(void **state)
{
    static const uint8_t texels[16] = {128, 128, 128, 255, 0,   0,   0,   255,
                                       255, 255, 255, 255, 192, 192, 192, 255};
    const double half = 128 / 255.0, most = 192 / 255.0;
    const double blend[4] = {1 - 0.5 * half, 1, 0.5, 1 - 0.5 * most}, cut[4] = {1, 1, 0.5, 0.5};
    write_rgba(*state, "a.png", 2, 2, texels);
    for (int cuts = 0; cuts < 2; cuts++) {
        char members[1024];
        snprintf(members, sizeof members,
                 FROM_ABOVE "," SKY "," QUAD ", 'materials': {'m': {'albedo': 0.5, 'alpha': "
                            "{'file': 'a.png', 'interpolation': 'nearest'}%s}}",
                 cuts ? ", 'alpha_cutoff': 0.6" : "");
        double *picture = seen(scene_of(*state, members, NULL), 400);
        for (int i = 0; i < 4; i++)
            lf_assert_close(quarter(picture, i), cuts ? cut[i] : blend[i], 0.03, 0);
        free(picture);
    }
}

/* Normals that lean by 45 degrees towards +x, and upwards in the picture, which is -z. */
static void a_normal_map_leans_where_it_says(void **state)
{
    static const struct {
        int r, g;
        const char *light; /* comes from there */
        double cosine;
    } cases[] = {{218, 128, "-1, -1, 0", 1},
                 {218, 128, "1, -1, 0", 0},
                 {218, 128, "0, -1, 0", M_SQRT1_2},
                 {128, 218, "0, -1, 1", 1},
                 {128, 218, "0, -1, -1", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char members[1024];
        write_plain(*state, "n.png", cases[i].r, cases[i].g, 218, 255);
        snprintf(members, sizeof members,
                 FROM_ABOVE "," QUAD ", 'materials': {'m': {'albedo': 1, 'normal': {'file': "
                            "'n.png'}}}, 'lights': {'sun': {'type': 'distant', 'irradiance': 1, "
                            "'direction': [%s]}}",
                 cases[i].light);
        double *picture = seen(scene_of(*state, members, NULL), 40);
        lf_assert_close(quarter(picture, 0), cases[i].cosine / M_PI, 0.02, 0.01);
        free(picture);
    }
}

static void what_glows_by_a_picture_is_a_light(void **state)
{
    static const uint8_t texels[16] = {255, 0, 0,   255, 0, 255, 0, 255,
                                       0,   0, 255, 255, 0, 0,   0, 255};
    const double want[4] = {0.5, 0.3, 0.2, 0};
    write_rgba(*state, "glow.png", 2, 2, texels);
    double *picture = seen(scene_of(*state,
                                    FROM_ABOVE "," QUAD ", 'materials': {'m': {'albedo': 0, "
                                               "'emission': {'file': 'glow.png', 'interpolation': "
                                               "'nearest', 'scale': 3}}}",
                                    NULL),
                           20);
    for (int i = 0; i < 4; i++)
        lf_assert_close(quarter(picture, i), 3 * want[i], 0.01, 1e-9);
    free(picture);
}

/* Roughness is green, metal blue, of files of any size; what has no picture is whole. */
static void roughness_and_metal_share_a_slot(void **state)
{
    static const uint8_t rough[8] = {1, 100, 2, 255, 3, 200, 4, 255};
    write_rgba(*state, "rough.png", 2, 1, rough);
    write_plain(*state, "metal.png", 9, 8, 7, 255);
    lf_scene *both = scene_of(*state,
                              QUAD "," SKY ", 'materials': {'m': {'type': 'principled', "
                                   "'roughness': {'file': 'rough.png', 'scale': 0}, 'metallic': "
                                   "{'file': 'metal.png', 'scale': 0.5}}}",
                              NULL),
             *one = scene_of(*state,
                             QUAD "," SKY ", 'materials': {'m': {'type': 'plastic', 'roughness': "
                                  "{'file': 'rough.png'}}}",
                             NULL);
    const lf_texels *texels = &both->own_textures[0].picture[LF_SLOT_METAL_ROUGH]->texels;
    assert_true(texels->width == 2 && texels->height == 1);
    assert_true(texels->rgba[1] == 100 && texels->rgba[5] == 200);
    assert_true(texels->rgba[2] == 7 && texels->rgba[6] == 7);
    assert_true(both->materials[0].roughness == LF_LEAST_ROUGHNESS);
    assert_true(both->materials[0].metallic == 0.5f);
    assert_int_equal(one->own_textures[0].picture[LF_SLOT_METAL_ROUGH]->texels.rgba[2], 255);
    assert_non_null(one->materials[0].kind->vary);
    lf_scene_unref(both);
    lf_scene_unref(one);
}

/* No picture is mirrored: to the right, upwards and outwards are a right-handed frame. */
static void shapes_wear_pictures_the_right_way_round(void **state)
{
    (void)state;
    for (int s = 0; lf_mesh_shapes[s]; s++) {
        const lf_mesh_desc desc = {.name = "m",
                                   .shape = lf_mesh_shapes[s],
                                   .transform = lf_affine_identity(),
                                   .wants.uvs = true};
        lf_mesh_data data = {0};
        lf_assert_ok(lf_mesh_shape_make(&desc, &data, NULL), NULL);
        assert_int_equal(data.n_uv_sets, 1);
        for (int t = 0; t < data.n_triangles; t++) {
            const uint32_t *c = data.triangles + 3 * (size_t)t;
            const float *a = data.uvs + 2 * (size_t)c[0], *b = data.uvs + 2 * (size_t)c[1],
                        *e = data.uvs + 2 * (size_t)c[2];
            for (int k = 0; k < 2; k++)
                assert_true(a[k] >= 0 && a[k] <= 1);
            /* v points down */
            assert_true((b[0] - a[0]) * (e[1] - a[1]) - (b[1] - a[1]) * (e[0] - a[0]) < 0);
        }
        lf_mesh_data_finish(&data);
    }
}

/* ----------------------------------------------------------------- the same said another way -- */

#define SQUARE "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 1 0\n"
#define LEFT "usemtl left\nf 1/1/1 2/2/1 4/4/1\n"
#define RIGHT "usemtl right\nf 2/2/1 3/3/1 4/4/1\n"

/* Pictures that a file's material and the scene's have: colour by one, normals by another. */
static void write_square(const char *folder)
{
    uint8_t texels[64];
    for (int i = 0; i < 16; i++) {
        texels[4 * i] = (uint8_t)(16 * i);
        texels[4 * i + 1] = (uint8_t)(255 - 9 * i);
        texels[4 * i + 2] = (uint8_t)(i % 3 * 80);
        texels[4 * i + 3] = 255;
    }
    write_rgba(folder, "c.png", 4, 4, texels);
    for (int i = 0; i < 16; i++) {
        texels[4 * i] = (uint8_t)(128 + 4 * i);
        texels[4 * i + 1] = (uint8_t)(100 + 2 * i);
        texels[4 * i + 2] = 230;
    }
    write_rgba(folder, "n.png", 4, 4, texels);
    lf_test_write(folder, "x.mtl",
                  "newmtl left\nmap_Kd -s 2 3 1 -o .25 .1 0 c.png\nnorm n.png\n"
                  "newmtl right\nKd .3 .6 .2\n");
    lf_test_write(folder, "own.obj", "mtllib x.mtl\n" SQUARE LEFT RIGHT);
    lf_test_write(folder, "bare.obj", SQUARE LEFT RIGHT);
}

static void assert_same_picture(double *a, double *b, double tolerance)
{
    double most = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        most = fmax(most, fabs(a[i] - b[i]) / fmax(b[i], 0.05));
    print_message("at most %.2g apart\n", most);
    assert_true(most < tolerance);
    free(a);
    free(b);
}

#define SUN "'lights': {'sun': {'type': 'distant', 'direction': [-0.4, -1, 0.2], 'angle': 3}}"
/* v' = 1 - (3 (1 - v) + 0.1) */
#define LIKE_LEFT                                                                                  \
    "{'albedo': {'file': 'c.png', 'transform': {'scale': [2, 3], 'offset': [0.25, -2.1]}}, "       \
    "'normal': {'file': 'n.png'}}"

/* Both with the same seed: but for rounding the same paths. */
static void json_says_what_a_material_library_says(void **state)
{
    write_square(*state);
    lf_scene *own = scene_of(*state, FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'own.obj'}}",
                             NULL),
             *by_name =
                 scene_of(*state,
                          FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'own.obj', 'materials': "
                                     "{'left': 'l'}}}, 'materials': {'l': " LIKE_LEFT "}",
                          NULL);
    assert_null(lf_scene_warning(by_name, 0));
    assert_same_picture(seen(by_name, 16), seen(own, 16), 1e-3);

    lf_test_write(*state, "one.obj", "mtllib x.mtl\n" SQUARE LEFT "f 2/2/1 3/3/1 4/4/1\n");
    lf_scene *one = scene_of(*state, FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'one.obj'}}",
                             NULL),
             *whole =
                 scene_of(*state,
                          FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'bare.obj', 'material': "
                                     "'l'}}, 'materials': {'l': " LIKE_LEFT "}",
                          NULL),
             *other =
                 scene_of(*state,
                          FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'bare.obj', 'material': "
                                     "'l'}}, 'materials': {'l': {'albedo': {'file': "
                                     "'c.png'}}}",
                          NULL);
    double *got = seen(whole, 16), *want = seen(one, 16), *wrong = seen(other, 16);
    assert_true(fabs(quarter(wrong, 2) - quarter(want, 2)) > 0.01 * quarter(want, 2));
    free(wrong);
    assert_same_picture(got, want, 1e-3);
}

/* A square with coordinates of glTF, colours of vertices if they are asked for, and a material that
 * has c.png. */
static void write_gltf(const char *folder, bool coloured)
{
    static const float numbers[] = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1, /* positions */
                                    0,  1, 1, 1, 1, 0, 0, 0,                /* coordinates */
                                    1,  0, 0, 1, 0, 0, 1, 0, 0,  1,  0, 0}; /* colours */
    static const uint32_t corners[] = {0, 1, 2, 0, 2, 3};
    FILE *file = fopen(lf_test_path(folder, "g.bin"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(numbers, sizeof numbers, 1, file), 1);
    assert_int_equal(fwrite(corners, sizeof corners, 1, file), 1);
    fclose(file);
    lf_test_write(
        folder, "g.gltf",
        lf_test_scene_patched(
            "gltf-square", "%s",
            coloured
                ? "{'meshes': [{'primitives': [{'attributes': {'POSITION': 0, 'TEXCOORD_0': 1, "
                  "'COLOR_0': 2}, 'indices': 3, 'material': 0}]}]}"
                : "{}"));
}

static void json_says_what_gltf_says(void **state)
{
    static const char like[] =
        "'materials': {'Skin': {'type': 'principled', 'roughness': 0.5, 'albedo': {'file': "
        "'c.png'}}}";
    char members[2][1024];
    write_square(*state);
    write_gltf(*state, false);
    snprintf(members[0], sizeof members[0],
             FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'g.gltf', 'materials': {'Skin': "
                        "'Skin'}}}, %s",
             like);
    snprintf(members[1], sizeof members[1],
             FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'g.gltf', 'material': 'Skin'}}, %s",
             like);
    for (int i = 0; i < 2; i++)
        assert_same_picture(
            seen(scene_of(*state, members[i], NULL), 16),
            seen(scene_of(*state, FROM_ABOVE "," SUN ", 'meshes': {'q': {'file': 'g.gltf'}}", NULL),
                 16),
            1e-5);
}

/* The scene's material is what it says, whatever vertices say. */
static void colours_of_vertices_are_of_the_files_materials(void **state)
{
    write_square(*state);
    write_gltf(*state, true);
    double *own = seen(
               scene_of(*state, FROM_ABOVE "," SKY ", 'meshes': {'q': {'file': 'g.gltf'}}", NULL),
               8),
           *clay = seen(scene_of(*state,
                                 FROM_ABOVE "," SKY ", 'meshes': {'q': {'file': 'g.gltf', "
                                            "'materials': {'Skin': 'clay'}}}, 'materials': "
                                            "{'clay': {'albedo': [0.2, 0.8, 0.8]}}",
                                 NULL),
                        8);
    lf_assert_close(quarter(clay, 0), grey(0.2, 0.8, 0.8), 1e-3, 0);
    assert_true(quarter(own, 0) < 0.7 * quarter(clay, 0));
    free(own);
    free(clay);
}

/* ----------------------------------------------------------------------------------- patches -- */

static lf_scene *patched(const char *folder, const char *material, const lf_scene *previous)
{
    char members[1024];
    snprintf(members, sizeof members,
             SKY ", 'meshes': {'q': {'file': 'own.obj', 'materials': {'left': 'm'}}}, "
                 "'materials': {'m': %s}",
             material);
    return scene_of(folder, members, previous);
}

static const lf_scene_picture *base_of(const lf_scene *scene)
{
    return scene->own_textures[0].picture[LF_SLOT_BASE];
}

static void a_patch_reads_what_it_changes_and_nothing_else(void **state)
{
    write_square(*state);
    lf_scene *plain = patched(*state, "{'albedo': 0.3}", NULL),
             *red = patched(*state, "{'albedo': [0.5, 0, 0]}", plain),
             *one = patched(*state, "{'albedo': {'file': 'c.png'}}", red),
             *rough = patched(*state,
                              "{'albedo': {'file': 'c.png', 'scale': 0.5}, 'type': "
                              "'plastic'}",
                              one),
             *other = patched(*state, "{'albedo': {'file': 'n.png'}}", rough),
             *bent = patched(*state, "{'albedo': {'file': 'n.png'}, 'normal': {'file': 'n.png'}}",
                             other),
             *back = patched(*state, "{'albedo': 0.3}", bent);
    assert_ptr_equal(red->geometry, plain->geometry);
    assert_ptr_not_equal(one->geometry, red->geometry); /* which had no coordinates everywhere */
    assert_ptr_equal(rough->geometry, one->geometry);
    assert_ptr_equal(base_of(rough), base_of(one));
    assert_ptr_equal(other->geometry, one->geometry);
    assert_ptr_not_equal(base_of(other), base_of(one));
    assert_ptr_not_equal(bent->geometry, other->geometry);
    assert_ptr_equal(base_of(bent), base_of(other));
    /* the file's own is there again, and nothing of the pictures */
    assert_null(back->materials[0].textures);
    assert_ptr_equal(plain->materials[0].textures, NULL);
    lf_scene_unref(plain);
    lf_scene_unref(red);
    lf_scene_unref(one);
    lf_scene_unref(rough);
    lf_scene_unref(other);
    lf_scene_unref(bent);
    lf_scene_unref(back);
}

/* Another picture under the same name is another scene, for films as well. */
static void a_picture_that_changes_is_read_again(void **state)
{
    static const char members[] = SKY "," QUAD ", 'materials': {'m': {'albedo': {'file': "
                                      "'p.png'}}}";
    write_plain(*state, "p.png", 255, 0, 0, 255);
    lf_scene *red = scene_of(*state, members, NULL);
    write_plain(*state, "q.png", 0, 255, 0, 255);
    assert_int_equal(rename(lf_test_path(*state, "q.png"), lf_test_path(*state, "p.png")), 0);
    lf_scene *green = scene_of(*state, members, red), *same = scene_of(*state, members, green);
    assert_int_equal(base_of(green)->texels.rgba[1], 255);
    assert_false(json_equal(red->subject, green->subject));
    assert_ptr_equal(base_of(same), base_of(green));
    assert_true(json_equal(same->subject, green->subject));
    lf_scene_unref(red);
    lf_scene_unref(green);
    lf_scene_unref(same);
}

/* ---------------------------------------------------------------------------------- refusals -- */

/* By roots, at this pointer, in words that hold these. */
static void assert_refused(const char *folder, const char *text, const char *pointer,
                           const char *words)
{
    lf_scene *scene = NULL;
    lf_roots roots = {0};
    lf_error err = {0};
    char *json = strdup(text);
    for (char *c = json; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *doc = json_loads(json, 0, NULL);
    assert_non_null(doc);
    lf_assert_ok(lf_roots_add(&roots, folder, &err), &err);
    assert_int_not_equal(lf_scene_from_json(doc, folder, "test", &roots, NULL, &scene, &err),
                         LF_OK);
    json_decref(doc);
    free(json);
    lf_roots_finish(&roots);
    assert_string_equal(err.pointer, pointer);
    if (!strstr(err.what, words))
        fail_msg("%s", err.what);
}

static void what_is_wrong_is_refused_in_words(void **state)
{
    write_square(*state);
    write_plain(*state, "p.png", 255, 0, 0, 255);
    lf_test_write(*state, "broken.png", "\x89PNG\r\n\x1a\nnothing of it");
    lf_test_write(*state, "bald.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    lf_test_write(*state, "points.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                  "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                  "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    static const struct {
        const char *mesh, *material, *pointer, *words;
    } cases[] = {
        {"'shape': 'quad', 'material': 'm'", "'albedo': {'file': 'gone.png'}",
         "/materials/m/albedo/file", "gone.png"},
        {"'shape': 'quad', 'material': 'm'", "'albedo': {'file': '/etc/x.png'}",
         "/materials/m/albedo/file", "outside"},
        {"'shape': 'quad', 'material': 'm'", "'albedo': {'file': 'broken.png'}",
         "/materials/m/albedo/file", "broken.png"},
        {"'shape': 'quad', 'material': 'm'", "'albedo': {'file': 'p.exr'}",
         "/materials/m/albedo/file", "expected .png"},
        {"'shape': 'quad', 'material': 'm'", "'albedo': {'scale': 1}", "/materials/m/albedo",
         "\"file\" is missing"},
        {"'shape': 'quad', 'material': 'm'", "'albedo': {'file': 'p.png', 'scale': 2}",
         "/materials/m/albedo/scale", ""},
        {"'shape': 'quad', 'material': 'm'",
         "'albedo': {'file': 'p.png', 'transform': {'rotate': null}}",
         "/materials/m/albedo/transform/rotate", ""},
        {"'shape': 'quad', 'material': 'm'",
         "'albedo': {'file': 'p.png', 'transform': {'scale': [1, 1e300]}}",
         "/materials/m/albedo/transform/scale/1", ""},
        {"'shape': 'quad', 'material': 'm'", "'albedo': 'p.png'", "/materials/m/albedo",
         "use {\"file\": \"p.png\"}"},
        {"'shape': 'quad', 'material': 'm'", "'texture': 'p.png'", "/materials/m/texture",
         "use \"albedo\": {\"file\": ...}"},
        {"'shape': 'quad', 'material': 'm'", "'normal': 1", "/materials/m/normal", "normal map"},
        {"'shape': 'quad', 'material': 'm'",
         "'albedo': {'file': 'p.png'}, 'alpha': {'file': 'p.png', 'wrap': 'clamp'}",
         "/materials/m/alpha", "same transform"},
        {"'file': 'bald.obj', 'material': 'm'", "'albedo': {'file': 'p.png'}", "/meshes/q/material",
         "no readable texture coordinates"},
        {"'file': 'own.obj', 'materials': {'letf': 'm'}", "", "/meshes/q/materials/letf",
         "did you mean \"left\"? It has \"left\", \"right\""},
        {"'file': 'own.obj', 'materials': {'elsewhere': 'm'}", "", "/meshes/q/materials/elsewhere",
         "it has \"left\", \"right\""},
        {"'file': 'points.ply', 'materials': {'x': 'm'}", "", "/meshes/q/materials/x",
         "have no names"},
        {"'file': 'own.obj', 'materials': {'left': 'n'}", "", "/meshes/q/materials/left",
         "no material \"n\""},
        {"'file': 'own.obj', 'material': 'm', 'materials': {'left': 'm'}", "",
         "/meshes/q/materials", "replaces all"},
        {"'shape': 'quad', 'materials': {'left': 'm'}", "", "/meshes/q/materials",
         "only a mesh from a file"},
        {"'file': 'own.obj', 'materials': ['m']", "", "/meshes/q/materials", "expected an object"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1024];
        snprintf(text, sizeof text, "{" SKY ", 'meshes': {'q': {%s}}, 'materials': {'m': {%s}}}",
                 cases[i].mesh, cases[i].material);
        assert_refused(*state, text, cases[i].pointer, cases[i].words);
    }
}

static void unused_materials_are_told_by_name(void **state)
{
    write_square(*state);
    lf_scene *scene = scene_of(*state,
                               SKY ", 'meshes': {'q': {'file': 'own.obj', 'materials': {'right': "
                                   "'used'}}}, 'materials': {'left': {}, 'used': {}, 'x': {}, "
                                   "'y': {}}",
                               NULL);
    assert_non_null(strstr(lf_scene_warning(scene, 0), "\"materials\": {\"left\": \"left\"} in "
                                                       "mesh \"q\""));
    assert_non_null(strstr(lf_scene_warning(scene, 1), "materials \"x\", \"y\" are not used"));
    assert_null(lf_scene_warning(scene, 2));
    lf_scene_unref(scene);
}

static int finish(void **state)
{
    return lf_test_folder_teardown(state) + lf_test_finish(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_texel_is_seen_as_its_albedo_times_the_light),
        cmocka_unit_test(a_transform_moves_turns_and_repeats),
        cmocka_unit_test(alpha_is_how_much_is_there),
        cmocka_unit_test(a_normal_map_leans_where_it_says),
        cmocka_unit_test(what_glows_by_a_picture_is_a_light),
        cmocka_unit_test(roughness_and_metal_share_a_slot),
        cmocka_unit_test(shapes_wear_pictures_the_right_way_round),
        cmocka_unit_test(json_says_what_a_material_library_says),
        cmocka_unit_test(json_says_what_gltf_says),
        cmocka_unit_test(colours_of_vertices_are_of_the_files_materials),
        cmocka_unit_test(a_patch_reads_what_it_changes_and_nothing_else),
        cmocka_unit_test(a_picture_that_changes_is_read_again),
        cmocka_unit_test(what_is_wrong_is_refused_in_words),
        cmocka_unit_test(unused_materials_are_told_by_name),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, finish);
}
