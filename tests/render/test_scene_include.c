/* Scene files that include others: what comes of them, whose the errors are, what is refused. */
#include "tests/testing.h"

#include <jansson.h>
#include <sys/stat.h>

#include "render/render.h"
#include "render/renderer.h"
#include "render/scene/scene.h"

/* Writes a file, ' standing for ". */
static const char *put(const char *folder, const char *name, const char *text)
{
    char copy[4096];
    snprintf(copy, sizeof copy, "%s", text);
    for (char *c = copy; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    return lf_test_write(folder, name, copy);
}

static lf_scene *load(const char *folder, const char *name)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    if (lf_scene_load(lf_test_path(folder, name), NULL, NULL, &scene, &err) != LF_OK)
        fail_msg("%s:%d: %s: %s", err.where, err.line, err.pointer, err.what);
    return scene;
}

static void assert_json(const lf_scene *scene, const char *text)
{
    char copy[2048];
    snprintf(copy, sizeof copy, "%s", text);
    for (char *c = copy; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *want = json_loads(copy, 0, NULL);
    assert_non_null(want);
    if (!json_equal(want, lf_scene_json(scene))) {
        char *is = json_dumps(lf_scene_json(scene), 0);
        fail_msg("%s", is);
    }
    json_decref(want);
}

/* Error of a scene that must not load: the name that where ends in, line, pointer and some words.
 */
static void assert_refused(const char *folder, const char *name, lf_status status,
                           const char *where, int line, const char *pointer, const char *words)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_assert_status(lf_scene_load(lf_test_path(folder, name), NULL, NULL, &scene, &err), status,
                     &err);
    size_t n = strlen(err.where), end = strlen(where);
    if (n < end || strcmp(err.where + n - end, where) != 0 || err.line != line ||
        strcmp(err.pointer, pointer) != 0 || !strstr(err.what, words))
        fail_msg("%s:%d: %s: %s", err.where, err.line, err.pointer, err.what);
}

/* RFC 7396, one after the other: the last name of a list before those ahead of it, what a file
 * includes behind all of its own. */
static void own_keys_win_over_included_ones(void **state)
{
    const char *folder = *state;
    put(folder, "rig.json", "{ 'camera': { 'fov_y': 20, 'views': 5 }, 'film': { 'exposure': 1 } }");
    put(folder, "lit.json",
        "{ 'include': 'rig.json', 'camera': { 'views': 6 }, 'lights': { 'a': { 'type': 'point', "
        "'intensity': 2 }, 'b': { 'type': 'point' } }, 'backdrop': { 'top': 1, 'bottom': 2 } }");
    put(folder, "last.json", "{ 'lights': { 'a': { 'intensity': 5 } }, 'film': null }");
    put(folder, "main.json",
        "{ 'include': ['lit.json', 'last.json'], 'lights': { 'b': null, 'c': { 'type': 'point' } "
        "}, 'camera': { 'cone': 9 }, 'backdrop': [1, 2, 3] }");
    lf_scene *scene = load(folder, "main.json");
    assert_json(scene, "{ 'camera': { 'fov_y': 20, 'views': 6, 'cone': 9 }, 'lights': { 'a': { "
                       "'type': 'point', 'intensity': 5 }, 'c': { 'type': 'point' } }, 'backdrop': "
                       "[1, 2, 3] }");
    assert_int_equal(lf_scene_camera(scene)->n_views, 6);
    static const char *const names[] = {"last.json", "lit.json", "rig.json"};
    for (int i = 0; i < 3; i++)
        assert_string_equal(strrchr(lf_scene_included(scene, i), '/') + 1, names[i]);
    assert_null(lf_scene_included(scene, 3));
    lf_scene_unref(scene);
}

/* Names are relative to the file that says them, in whatever folder. */
static void files_are_looked_for_beside_the_scene_that_names_them(void **state)
{
    const char *folder = *state;
    mkdir(lf_test_path(folder, "parts"), 0700);
    mkdir(lf_test_path(folder, "parts/deep"), 0700);
    put(folder, "parts/deep/one.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
        "0\n0 1 0\n3 0 1 2\n");
    put(folder, "parts/deep/meshes.json",
        "{ 'include': '../lights.json', 'meshes': { 'm': { 'file': 'one.ply' } } }");
    put(folder, "parts/lights.json", "{ 'lights': { 'l': { 'type': 'point' } } }");
    put(folder, "main.json", "{ 'include': 'parts/deep/meshes.json' }");
    lf_scene *scene = load(folder, "main.json");
    assert_json(scene, "{ 'meshes': { 'm': { 'file': 'parts/deep/one.ply' } }, 'lights': { 'l': { "
                       "'type': 'point' } } }");
    assert_int_equal(scene->n_meshes, 1);
    assert_int_equal(scene->n_lights, 1);
    lf_scene_unref(scene);
    /* Beneath roots as everything: the scene's folder is one, what is beside it is none. */
    put(folder, "outside.json", "{ 'lights': { 'l': { 'type': 'point' } } }");
    put(folder, "parts/reaching.json", "{ 'include': '../outside.json' }");
    lf_roots roots = {0};
    lf_error err = {0};
    lf_assert_ok(lf_roots_add(&roots, lf_test_path(folder, "parts"), &err), &err);
    lf_assert_status(
        lf_scene_load(lf_test_path(folder, "parts/reaching.json"), &roots, NULL, &scene, &err),
        LF_E_PATH, &err);
    lf_assert_ok(lf_roots_add(&roots, folder, &err), &err);
    lf_assert_ok(
        lf_scene_load(lf_test_path(folder, "parts/reaching.json"), &roots, NULL, &scene, &err),
        &err);
    lf_scene_unref(scene);
    lf_roots_finish(&roots);
}

/* The picture is not there: the error says where it was looked for. */
static void textures_are_looked_for_beside_the_scene_that_names_them(void **state)
{
    const char *folder = *state;
    mkdir(lf_test_path(folder, "looks"), 0700);
    put(folder, "looks/hide.json",
        "{ 'materials': { 'hide': { 'albedo': { 'file': 'hide.png' } } } }");
    put(folder, "textured.json",
        "{ 'include': 'looks/hide.json', 'meshes': { 'm': { 'shape': 'quad', 'material': 'hide' } "
        "} }");
    lf_scene *scene = NULL;
    lf_error err = {0};
    char line[2000];
    lf_assert_status(lf_scene_load(lf_test_path(folder, "textured.json"), NULL, NULL, &scene, &err),
                     LF_E_IO, &err);
    if (!strstr(lf_error_format(&err, line, sizeof line), "looks/hide.png"))
        fail_msg("%s", line);
}

static void errors_name_the_file_and_line_that_the_value_is_in(void **state)
{
    const char *folder = *state;
    put(folder, "base.json",
        "{\n 'lights': {\n  'sun': { 'type': 'distant',\n   'angle': 100 },\n  'l': { 'type': "
        "'point' } } }");
    put(folder, "main.json", "{\n 'include': 'base.json' }");
    assert_refused(folder, "main.json", LF_E_FORMAT, "base.json", 4, "/lights/sun/angle",
                   "out of range");
    /* Whoever has the last word has the error. */
    put(folder, "main.json",
        "{ 'include': 'base.json',\n 'lights': { 'sun': {\n 'angle': 101 } } }");
    assert_refused(folder, "main.json", LF_E_FORMAT, "main.json", 3, "/lights/sun/angle", "101");
    put(folder, "main.json",
        "{ 'include': 'base.json', 'lights': { 'sun': { 'angle': 1 },\n 'l': { 'colour': 1 } } }");
    assert_refused(folder, "main.json", LF_E_FORMAT, "main.json", 2, "/lights/l/colour",
                   "unknown key");
    put(folder, "base.json", "{\n 'camera': {},\n 'Lights': {} }");
    assert_refused(folder, "main.json", LF_E_FORMAT, "base.json", 3, "/Lights", "unknown key");
    put(folder, "base.json", "{\n\n 'meshes': { 'm': { 'file': 'none.ply' } } }");
    put(folder, "main.json", "{\n 'include': 'base.json' }");
    assert_refused(folder, "main.json", LF_E_IO, "base.json", 3, "/meshes/m/file", "none.ply");
    put(folder, "base.json", "{\n 'lights': }");
    assert_refused(folder, "main.json", LF_E_FORMAT, "main.json", 2, "/include", "base.json:2");
    put(folder, "base.json", "[]");
    assert_refused(folder, "main.json", LF_E_FORMAT, "main.json", 2, "/include", "base.json");
    put(folder, "main.json", "{\n 'include': ['none.json'] }");
    assert_refused(folder, "main.json", LF_E_IO, "main.json", 2, "/include/0", "none.json");
}

static void a_file_that_includes_itself_is_refused(void **state)
{
    const char *folder = *state;
    put(folder, "main.json", "{ 'include': 'main.json' }");
    assert_refused(folder, "main.json", LF_E_FORMAT, "main.json", 1, "/include", "includes itself");
    put(folder, "main.json", "{ 'include': 'one.json' }");
    put(folder, "one.json", "{\n 'include': ['two.json'] }");
    put(folder, "two.json", "{ 'include':\n\n 'link.json' }");
    assert_int_equal(symlink("one.json", lf_test_path(folder, "link.json")), 0);
    assert_refused(folder, "main.json", LF_E_FORMAT, "two.json", 3, "/include", "includes itself");
    /* Twice the same, not within itself: that is none. */
    put(folder, "two.json", "{ 'lights': { 'l': { 'type': 'point' } } }");
    put(folder, "main.json", "{ 'include': ['one.json', 'two.json'] }");
    lf_scene *scene = load(folder, "main.json");
    assert_int_equal(scene->n_lights, 1);
    lf_scene_unref(scene);
    /* More than there may be. */
    put(folder, "9.json", "{}");
    for (int i = 8; i >= 0; i--) {
        char name[16], text[64];
        snprintf(name, sizeof name, "%d.json", i);
        snprintf(text, sizeof text, "{ 'include': ['%d.json', '%d.json'] }", i + 1, i + 1);
        put(folder, name, text);
    }
    lf_error err = {0};
    lf_assert_status(lf_scene_load(lf_test_path(folder, "0.json"), NULL, NULL, &scene, &err),
                     LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "more than 64"));
    /* 2 MiB each. */
    enum { WIDE = 2 << 20 };
    char *wide = malloc(WIDE + 1);
    assert_non_null(wide);
    memset(wide, ' ', WIDE);
    memcpy(wide + WIDE - 2, "{}", 3);
    lf_test_write(folder, "wide.json", wide);
    free(wide);
    put(folder, "main.json",
        "{ 'include': ['wide.json', 'wide.json', 'wide.json', 'wide.json', 'wide.json', "
        "'wide.json', 'wide.json', 'wide.json', 'wide.json'] }");
    lf_assert_status(lf_scene_load(lf_test_path(folder, "main.json"), NULL, NULL, &scene, &err),
                     LF_E_NOMEM, &err);
    assert_non_null(strstr(err.what, "16 MiB"));
}

/* What is shown is what counts, however it is spread over files. */
static void pictures_are_the_same_whatever_is_included(void **state)
{
    const char *folder = *state;
    put(folder, "whole.json", "{ 'backdrop': 2, 'lights': { 'l': { 'type': 'point' } } }");
    put(folder, "base.json", "{ 'backdrop': 1, 'lights': { 'l': { 'type': 'point' } } }");
    put(folder, "main.json", "{ 'include': 'base.json', 'backdrop': 2 }");
    put(folder, "other.json", "{ 'include': 'base.json', 'backdrop': 3 }");
    lf_scene *scene[3] = {load(folder, "whole.json"), load(folder, "main.json"),
                          load(folder, "other.json")};
    lf_render_settings settings = {.camera = *lf_scene_camera(scene[0]), .width = 4, .height = 4};
    assert_true(lf_same_picture(scene[0], &settings, scene[1], &settings));
    assert_false(lf_same_picture(scene[0], &settings, scene[2], &settings));
    for (int i = 0; i < 3; i++)
        lf_scene_unref(scene[i]);
    put(folder, "base.json", "{ 'backdrop': 1, 'lights': { 'l': { 'type': 'spot' } } }");
    scene[0] = load(folder, "whole.json");
    scene[1] = load(folder, "main.json");
    assert_false(lf_same_picture(scene[0], &settings, scene[1], &settings));
    lf_scene_unref(scene[0]);
    lf_scene_unref(scene[1]);
}

/* A document in memory may include too: what a patch says. */
static void a_patch_may_include(void **state)
{
    const char *folder = *state;
    put(folder, "base.json", "{ 'lights': { 'l': { 'type': 'point', 'intensity': 7 } } }");
    json_t *doc =
        json_pack("{s:s, s:{s:{s:i}}}", "include", "base.json", "lights", "l", "intensity", 8);
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_scene_from_json(doc, folder, "no file", NULL, NULL, &scene, &err), &err);
    assert_json(scene, "{ 'lights': { 'l': { 'type': 'point', 'intensity': 8 } } }");
    lf_scene_unref(scene);
    json_decref(doc);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(own_keys_win_over_included_ones),
        lf_test_in_folder(files_are_looked_for_beside_the_scene_that_names_them),
        lf_test_in_folder(textures_are_looked_for_beside_the_scene_that_names_them),
        lf_test_in_folder(errors_name_the_file_and_line_that_the_value_is_in),
        lf_test_in_folder(a_file_that_includes_itself_is_refused),
        lf_test_in_folder(pictures_are_the_same_whatever_is_included),
        lf_test_in_folder(a_patch_may_include),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
