/* What files hold and pictures lack is said, in one line each, and nothing else is. */
#include "tests/testing.h"

#include <math.h>

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* A lit scene with one mesh, of a file unless shape says otherwise; ' stands for ". */
static lf_scene *scene_of(const char *folder, const char *meshes, const lf_scene *previous)
{
    char text[2048];
    snprintf(text, sizeof text,
             "{'meshes': {%s}, 'materials': {%s}, 'lights': {'sky': {'type': 'environment', "
             "'radiance': 1}}}",
             meshes, strstr(meshes, "'lamp'") ? "'lamp': {'emission': 3}" : "");
    return lf_test_scene_in(folder, text, previous);
}

static bool says(const lf_scene *scene, const char *words)
{
    for (int i = 0; lf_scene_warning(scene, i); i++)
        if (strstr(lf_scene_warning(scene, i), words))
            return true;
    return false;
}

static void assert_lines(const lf_scene *scene, const char *const words[], int n)
{
    int lines = 0;
    for (int i = 0; i < n; i++)
        if (!says(scene, words[i]))
            fail_msg("no warning says \"%s\"", words[i]);
    while (lf_scene_warning(scene, lines))
        lines++;
    if (lines != n)
        fail_msg("%d warnings instead of %d; the first: %s", lines, n, lf_scene_warning(scene, 0));
}

static void lines_are_kept_once_escaped_and_counted_beyond_their_limit(void **state)
{
    (void)state;
    lf_warnings w = {0}, all = {0};
    char last[32];
    assert_null(lf_warnings_at(&w, 0));
    lf_warnings_add(&w, "a\nb.obj", "two\x1b[31m %d", 2);
    lf_warnings_add(&w, "a\nb.obj", "two\x1b[31m %d", 2);
    assert_string_equal(lf_warnings_at(&w, 0), "a\\nb.obj: two\\x1b[31m 2");
    assert_null(lf_warnings_at(&w, 1));
    for (int i = 0; i < 100; i++)
        lf_warnings_add(&w, "x", "%d", i);
    lf_warnings_add_all(&all, &w);
    lf_warnings_add(&all, "one", "more");
    snprintf(last, sizeof last, "and %d more", 101 - LF_MAX_WARNINGS);
    assert_string_equal(lf_warnings_at(&w, LF_MAX_WARNINGS), last);
    snprintf(last, sizeof last, "and %d more", 102 - LF_MAX_WARNINGS);
    assert_string_equal(lf_warnings_at(&all, LF_MAX_WARNINGS), last);
    assert_null(lf_warnings_at(&all, LF_MAX_WARNINGS + 1));
    lf_warnings_finish(&w);
    lf_warnings_finish(&all);
}

/* One triangle with the material given, and more members of the document. */
static void write_gltf(const char *folder, const char *material, const char *more)
{
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    FILE *file = fopen(lf_test_path(folder, "tri.bin"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(corners, sizeof corners, 1, file), 1);
    fclose(file);
    lf_test_write(folder, "a.gltf",
                  lf_test_scene_patched("gltf-triangle-with-camera-and-light",
                                        "{'materials': [%s], %s}", material, more));
}

#define NOTHING "'cameras':[],'extensions':{}"
#define EXTENSIONS                                                                                 \
    "'extensionsUsed': ['KHR_lights_punctual', 'KHR_materials_transmission', "                     \
    "'KHR_materials_clearcoat', 'KHR_materials_sheen', 'KHR_materials_volume', "                   \
    "'KHR_materials_unlit'], 'cameras': [{'type': 'perspective', 'perspective': {'yfov': 1, "      \
    "'znear': 0.1}}], "                                                                            \
    "'extensions': {'KHR_lights_punctual': {'lights': [{'type': 'point', 'intensity': 3}]}}"

static void what_a_gltf_material_loses_is_said(void **state)
{
    write_gltf(*state,
               "{'name': 'wo\\nod', 'alphaMode': 'BLEND', 'pbrMetallicRoughness': "
               "{'baseColorTexture': {'index': 0}, 'metallicFactor': 0.4}, 'emissiveTexture': "
               "{'index': 0}, 'emissiveFactor': [1, 1, 1], 'extensions': {"
               "'KHR_materials_transmission': {'transmissionFactor': 0.9}, "
               "'KHR_materials_clearcoat': {'clearcoatFactor': 1}, "
               "'KHR_materials_sheen': {'sheenColorFactor': [1, 0, 0]}, "
               "'KHR_materials_volume': {'thicknessFactor': 1, 'thicknessTexture': {'index': 0}}, "
               "'KHR_materials_iridescence': {'iridescenceFactor': 1}}, "
               "'occlusionTexture': {'index': 0}}",
               EXTENSIONS);
    lf_scene *scene = scene_of(*state, "'m': {'file': 'a.gltf'}", NULL);
    static const char *const words[] = {
        "the emission texture is not supported",
        "textures of thickness",
        "the ambient occlusion texture is ignored",
        "iridescence is left out",
        "is missing or may not be read",
        "a.gltf: 1 camera is not used",
        "a.gltf: 1 light is not used",
    };
    assert_lines(scene, words, sizeof words / sizeof *words);
    assert_false(
        lf_has(scene, LF_TRAIT_EMISSION)); /* what glows by a texture would glow all over */
    lf_scene_unref(scene);
    /* Where the scene says what the mesh is made of, the file's materials are not missed. */
    scene = scene_of(*state, "'m': {'file': 'a.gltf', 'material': 'lamp'}", NULL);
    assert_lines(scene, words + 5, 2);
    lf_scene_unref(scene);
}

static void a_file_that_is_shown_whole_says_nothing(void **state)
{
    lf_test_write(*state, "m.mtl",
                  "newmtl red\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 30\nNi 1.4\nd 1\nTf 1 1 1\n");
    lf_test_write(
        *state, "m.obj",
        "mtllib m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n");
    lf_scene *scene = scene_of(*state,
                               "'m': {'file': 'm.obj'}, 'c': {'shape': 'cube'}, "
                               "'s': {'shape': 'sphere', 'material': 'lamp'}",
                               NULL);
    assert_lines(scene, NULL, 0);
    lf_scene_unref(scene);
}

static void what_an_obj_or_ply_holds_beside_triangles_is_said(void **state)
{
    lf_test_write(*state, "m.mtl",
                  "newmtl glass\nKd 1 1 1\nd 0\nmap_Kd foo.png\nnewmtl green\nKd 0 1 0\n");
    lf_test_write(*state, "m.obj",
                  "mtllib m.mtl\nusemtl glass\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 2 "
                  "3 4\nusemtl green\nl 1 2\nl 2 3\n");
    lf_scene *scene = scene_of(*state, "'m': {'file': 'm.obj'}", NULL);
    static const char *const obj[] = {"1 texture is left out: the mesh has no texture",
                                      "\"glass\": transparency", "2 points and lines",
                                      "1 of 2 triangles is left out: a vertex is not finite"};
    assert_lines(scene, obj, 4);
    lf_scene_unref(scene);
    lf_test_write(*state, "n.obj",
                  "mtllib gone.mtl\nusemtl glass\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    scene = scene_of(*state, "'m': {'file': 'n.obj'}", NULL);
    static const char *const library[] = {"gone.mtl: "};
    assert_lines(scene, library, 1);
    lf_scene_unref(scene);
    lf_test_write(*state, "c.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
                  "y\nproperty float z\nproperty uchar red\n"
                  "property uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar "
                  "int vertex_indices\nend_header\n"
                  "0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2\n");
    scene = scene_of(*state, "'m': {'file': 'c.ply'}", NULL);
    assert_lines(scene, NULL, 0); /* its colours are seen */
    lf_scene_unref(scene);
}

static void an_obj_whose_material_is_not_in_its_library_is_said(void **state)
{
    lf_test_write(*state, "r.mtl", "newmtl blue ink\nKd 0 0 1\n newmtl  red \r\nKd 1 0 0\n");
    lf_test_write(*state, "r.obj",
                  "mtllib r.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nusemtl "
                  "blue\nf 2 4 3\n");
    lf_scene *scene = scene_of(*state, "'m': {'file': 'r.obj'}", NULL);
    static const char *const words[] = {
        "r.obj: material \"blue\": not in the file's material libraries"};
    assert_lines(scene, words, 1);
    lf_scene_unref(scene);
    scene = scene_of(*state, "'m': {'file': 'r.obj', 'material': 'lamp'}", NULL);
    assert_lines(scene, NULL, 0);
    lf_scene_unref(scene);
}

/* Vertices that are not numbers, first or last, in files whose faces share them. */
static void a_ply_with_vertices_that_are_not_numbers_is_said(void **state)
{
    static const char *const vertices[] = {"0 0 0\n1 0 0\n0 1 0\nnan 0 0\n3 0 1 2\n3 1 2 3\n",
                                           "0 nan 0\n1 0 0\n0 1 0\n0 0 0\n3 0 1 2\n3 1 2 3\n"};
    for (int i = 0; i < 2; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
                 "y\nproperty float z\nelement face 2\n"
                 "property list uchar int vertex_indices\nend_header\n%s",
                 vertices[i]);
        lf_test_write(*state, "n.ply", text);
        lf_scene *scene = scene_of(*state, "'m': {'file': 'n.ply'}", NULL);
        static const char *const words[] = {
            "n.ply: 1 of 2 triangles is left out: a vertex is not finite"};
        assert_lines(scene, words, 1);
        assert_int_equal(scene->meshes[0].n_triangles, 1);
        lf_scene_unref(scene);
    }
}

static void faces_in_one_place_are_said_and_one_of_them_stays(void **state)
{
    lf_test_write(
        *state, "d.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 -0.0\nv 1 0 0\nf 1 2 3\nf 3 2 1\nf 3 4 5\nf 1 2 3\n");
    lf_scene *scene =
        scene_of(*state,
                 "'one': {'shape': 'quad'}, 'two': {'shape': 'quad', 'material': 'lamp', "
                 "'transform': {'rotate': [0, 180, 0]}}, 'three': {'shape': 'quad', "
                 "'transform': {'translate': [0, 1e-6, 0]}}, 'own': {'file': 'd.obj'}",
                 NULL);
    static const char *const words[] = {
        "test.json: mesh \"two\": 2 of its triangles", "because \"one\" has the same",
        "mesh \"own\": 3 of its triangles are left out because \"own\" has the same"};
    assert_true(says(scene, words[0]) && says(scene, words[1]) && says(scene, words[2]));
    assert_int_equal(scene->meshes[0].n_triangles, 2);
    assert_int_equal(scene->meshes[1].n_triangles, 0);
    assert_int_equal(scene->meshes[2].n_triangles, 2);
    assert_int_equal(scene->meshes[3].n_triangles, 1);
    assert_false(lf_has(scene, LF_TRAIT_EMISSION));
    /* What is shared with the scene before is said again. */
    static const char again[] = "'one': {'shape': 'quad', 'material': 'lamp'}, "
                                "'two': {'shape': 'quad', 'transform': {'rotate': [0, 180, 0]}}";
    lf_scene *next = scene_of(*state, again, NULL), *after = scene_of(*state, again, next);
    assert_ptr_equal(after->geometry, next->geometry);
    assert_true(says(next, words[1]) && says(after, words[1]) && lf_has(after, LF_TRAIT_EMISSION));
    lf_scene_unref(after);
    lf_scene_unref(next);
    lf_scene_unref(scene);
}

static void what_a_material_has_no_use_for_is_said(void **state)
{
    lf_scene *scene = lf_test_scene_in(
        *state,
        "{'materials': {'clay': {'roughness': 0.2}, 'gold': {'type': 'conductor', "
        "'metal': 'gold', 'roughness': 0.2, 'ior': 1.3}, 'glaze': {'type': 'plastic', "
        "'roughness': 0.2, 'ior': 1.3}, 'wax': {'type': 'plastic', 'subsurface': 1}}, "
        "'lights': {'sky': {'type': 'environment', 'radiance': 1}}}",
        NULL);
    static const char *const words[] = {
        "test.json: material \"clay\": roughness has no effect because diffuse surfaces do not use "
        "it",
        "test.json: material \"gold\": ior has no effect because metals use eta and k",
        "test.json: material \"wax\": subsurface has no effect because plastic surfaces do not use "
        "it; it needs type \"principled\"",
        "test.json: materials \"clay\", \"gold\", \"glaze\", \"wax\" are not used by any mesh"};
    assert_lines(scene, words, 4);
    lf_scene_unref(scene);
}

/* A lamp and other faces in one place are said in these words alone; NULL = there are none. */
static void assert_overlap(const char *folder, const char *meshes, const char *words)
{
    lf_scene *scene = scene_of(folder, meshes, NULL);
    assert_lines(scene, &words, words ? 1 : 0);
    assert_int_equal(lf_has(scene, LF_TRAIT_OVERLAPS), words ? 1 : 0);
    lf_scene_unref(scene);
}

static void lamps_in_the_plane_of_other_faces_are_said(void **state)
{
    static const struct {
        const char *ceiling, *height;
        bool overlaps;
    } cases[] = {
        {"3", "1", true}, {"3000", "1", true}, {"3", "0.999", false}, {"3000", "0.99", false}};
    for (int i = 0; i < 4; i++) {
        char meshes[512];
        snprintf(
            meshes, sizeof meshes,
            "'ceiling': {'shape': 'quad', 'transform': {'scale': %s, 'translate': [0, 1, 0]}}, "
            "'ball': {'shape': 'sphere', 'material': 'lamp', 'transform': {'scale': 0.1}}, "
            "'panel': {'shape': 'quad', 'material': 'lamp', 'transform': {'scale': 0.5, "
            "'translate': [0.1, %s, 0]}}",
            cases[i].ceiling, cases[i].height);
        assert_overlap(*state, meshes,
                       cases[i].overlaps
                           ? "emissive mesh \"panel\" coincides with faces of \"ceiling\""
                           : NULL);
    }
}

static void two_lamps_in_one_place_are_said_in_one_line(void **state)
{
    assert_overlap(*state,
                   "'wide': {'shape': 'quad', 'material': 'lamp', 'transform': {'scale': 2}}, "
                   "'narrow': {'shape': 'quad', 'material': 'lamp'}",
                   "emissive mesh \"wide\" coincides with faces of \"narrow\"");
}

static void a_lamp_that_stands_on_the_ground_by_its_edge_is_no_overlap(void **state)
{
    assert_overlap(*state,
                   "'ground': {'shape': 'quad', 'transform': {'scale': 5}}, "
                   "'screen': {'shape': 'quad', 'material': 'lamp', "
                   "'transform': {'rotate': [90, 0, 0], 'translate': [0, 1, 0]}}",
                   NULL);
}

/* The file holds three grids called density. */
static void grids_that_nothing_is_made_of_are_said(void **state)
{
    (void)state;
    static const char *const volumes[] = {
        "'v': {'file': 'names.vdb'}",
        "'v': {'file': 'names.vdb'}, 'w': {'file': 'names.vdb', 'grid': 'density[2]'}",
        "'a': {'file': 'names.vdb', 'grid': 'density[0]'}, 'b': {'file': 'names.vdb', "
        "'grid': 'density[1]'}, 'c': {'file': 'names.vdb', 'grid': 'density[2]'}"};
    static const char *const words[] = {"names.vdb: unused grids: density[1], density[2]",
                                        "names.vdb: unused grids: density[1]"};
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", lf_test_built("testdata"));
    for (int i = 0; i < 3; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "{'volumes': {%s}, 'lights': {'sky': {'type': 'environment', 'radiance': 1}}}",
                 volumes[i]);
        lf_scene *scene = lf_test_scene_in(folder, text, NULL);
        assert_lines(scene, words + i, i < 2);
        lf_scene_unref(scene);
    }
}

/* ------------------------------------------------------------------------------------ camera -- */

/* A camera in, or beside, something: the line of warning, and whether its picture is black. */
static void assert_walled(const char *folder, const char *at, const char *meshes,
                          const char *material, const char *light, bool walled)
{
    char text[2048];
    const bool walls = strstr(meshes, "'material': 'wall'");
    snprintf(text, sizeof text,
             "{'camera': {'position': %s, 'target': [0, 0, 0.1], 'views': 2, 'cone': 4}, "
             "'meshes': {%s}, 'materials': {%s%s%s%s}, 'lights': {'l': {%s}}}",
             at, meshes, walls ? "'wall': {" : "", material, walls ? "}" : "",
             strstr(meshes, "'lamp'") ? ", 'lamp': {'emission': 3}" : "", light);
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    static const char *const words[] = {"test.json: the camera is inside the mesh \"wall\", where "
                                        "no light arrives; its view is black"};
    if (says(scene, "the camera is inside") != walled)
        fail_msg("%s: %s", text, walled ? "no warning" : "a warning");
    assert_lines(scene, words, walled ? 1 : 0);
    double *picture = lf_test_picture_by(scene, 8, 8, 1), sum = 0;
    for (int i = 0; i < 2 * 8 * 8; i++)
        sum += picture[i];
    if (walled ? sum != 0 : !(sum > 0))
        fail_msg("%s: a picture of %g", text, sum);
    free(picture);
    lf_scene_unref(scene);
}

#define SKY "'type': 'environment', 'radiance': 1"
#define BULB(at) "'type': 'point', 'intensity': 5, 'position': " at
#define IN "[0.1, 0.2, 1.1]"
#define CUBE "'wall': {'shape': 'cube', 'material': 'wall', 'transform': {'scale': 2}}"
#define BALL "'wall': {'shape': 'sphere', 'material': 'wall', 'transform': {'scale': 2}}"

static void a_camera_that_no_light_gets_to_is_said(void **state)
{
    static const struct {
        const char *at, *meshes, *material, *light;
        bool walled;
    } cases[] = {
        {IN, CUBE, "", SKY, true},
        {IN, BALL, "", SKY, true},
        {IN, CUBE, "'type': 'conductor', 'roughness': 0", SKY, true},
        {IN, CUBE, "", BULB("[0, 9, 9]"), true},
        /* a thing in a room that is dark, and a lamp before its walls */
        {IN, CUBE ", 'ball': {'shape': 'sphere', 'transform': {'scale': 0.3}}", "", SKY, true},
        {IN,
         CUBE ", 'a': {'shape': 'quad', 'material': 'lamp', "
              "'transform': {'translate': [0, 5, 0]}}",
         "", SKY, true},
        /* in the open, also in the ball's box */
        {"[0, 0, 9]", CUBE, "", SKY, false},
        {"[1.7, 1.7, 1.7]", BALL, "", SKY, false},
        /* rooms that are lit */
        {IN, CUBE, "", BULB("[0, 1, 0]"), false},
        {IN, CUBE ", 'a': {'shape': 'quad', 'material': 'lamp', 'transform': {'scale': 0.3}}", "",
         SKY, false},
        {IN, CUBE, "'emission': 1", SKY, false},
        {IN,
         BALL ", 'b': {'shape': 'sphere', 'material': 'lamp', 'transform': {'scale': 0.2, "
              "'translate': [0, 0, 0.1]}}",
         "", SKY, false},
        /* what lets light through */
        {IN, CUBE, "'type': 'principled', 'transmission': 1, 'roughness': 0", SKY, false},
        {IN, CUBE, "'type': 'principled', 'subsurface': 1, 'subsurface_radius': 1", SKY, false},
        {IN, "'wall': {'shape': 'cube', 'catcher': true, 'transform': {'scale': 2}}", "", SKY,
         false},
        {IN, "'wall': {'file': 'open.obj', 'material': 'wall'}", "", SKY, false},
        {IN, "'wall': {'file': 'shut.obj', 'material': 'wall'}", "", SKY, true},
    };
#define TENT "v -3 -3 -3\nv 3 -3 -3\nv 0 -3 4\nv 0 5 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\n"
    lf_test_write(*state, "open.obj", TENT);
    lf_test_write(*state, "shut.obj", TENT "f 3 4 1\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_walled(*state, cases[i].at, cases[i].meshes, cases[i].material, cases[i].light,
                      cases[i].walled);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_kept_once_escaped_and_counted_beyond_their_limit),
        cmocka_unit_test(what_a_gltf_material_loses_is_said),
        cmocka_unit_test(a_file_that_is_shown_whole_says_nothing),
        cmocka_unit_test(what_an_obj_or_ply_holds_beside_triangles_is_said),
        cmocka_unit_test(an_obj_whose_material_is_not_in_its_library_is_said),
        cmocka_unit_test(a_ply_with_vertices_that_are_not_numbers_is_said),
        cmocka_unit_test(faces_in_one_place_are_said_and_one_of_them_stays),
        cmocka_unit_test(what_a_material_has_no_use_for_is_said),
        cmocka_unit_test(lamps_in_the_plane_of_other_faces_are_said),
        cmocka_unit_test(two_lamps_in_one_place_are_said_in_one_line),
        cmocka_unit_test(a_lamp_that_stands_on_the_ground_by_its_edge_is_no_overlap),
        cmocka_unit_test(grids_that_nothing_is_made_of_are_said),
        cmocka_unit_test(a_camera_that_no_light_gets_to_is_said),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
