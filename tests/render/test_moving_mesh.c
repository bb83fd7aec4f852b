/* What moves in the files of meshes stands where the scene's frame has it, and what does not is not
 * read again. */
#include "tests/testing.h"

#include "render/scene/geometry.h"
#include "tests/render/walker.h"
#include "tests/stat/fixture.h"

/* A triangle of unit legs; two animations of it, 8 along x in 2 seconds, "up" 4 along y in 2. */
#define WALKER                                                                                     \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"       \
    "\"mesh\":0}]," WALKER_BYTES

static void write_files(const char *folder)
{
    lf_test_write(folder, "walk.gltf",
                  WALKER ",\"animations\":[{" WALKER_MOVES(
                      "0", "2") "},{\"name\":\"up\"," WALKER_MOVES("0", "3") "}]}");
    lf_test_write(folder, "still.gltf", WALKER "}");
}

/* Where the mesh begins along x or y; more: members of the scene, words: of the mesh. */
static void assert_at(const char *folder, const char *more, const char *words, double x, double y)
{
    char text[512];
    snprintf(text, sizeof text, "{%s 'meshes': {'m': {'file': 'walk.gltf'%s}}}", more, words);
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    lf_assert_close(scene->geometry->bounds[0][0], x, 0, 1e-5);
    lf_assert_close(scene->geometry->bounds[0][1], y, 0, 1e-5);
    assert_true(lf_scene_has_frames(scene));
    lf_scene_unref(scene);
}

static void the_frame_and_the_rate_say_where_it_stands(void **state)
{
    write_files(*state);
    assert_at(*state, "", "", 0, 0);
    assert_at(*state, "'frame': 7,", "", 1, 0);
    assert_at(*state, "'frame': 7, 'rate': 12,", "", 2, 0);
    assert_at(*state, "'frame': 55,", "", 1, 0);
    assert_at(*state, "'frame': 0, 'rate': 4,", "", 7, 0);
    assert_at(*state, "'frame': 7,", ", 'animation': {}", 1, 0);
    assert_at(*state, "'frame': 7,", ", 'animation': {'speed': 2}", 2, 0);
    assert_at(*state, "'frame': 7,", ", 'animation': {'speed': -1}", 7, 0);
    assert_at(*state, "'frame': 7,", ", 'animation': {'speed': 0, 'offset': 1}", 4, 0);
    assert_at(*state, "'frame': 999,", ", 'animation': {'loop': false}", 8, 0);
    assert_at(*state, "'frame': 7,", ", 'animation': {'clip': 1}", 0, 0.5);
    assert_at(*state, "'frame': 7,", ", 'animation': {'clip': 'up', 'offset': 1}", 0, 2.5);
}

static void what_stands_in_the_same_place_is_not_read_again(void **state)
{
    static const struct {
        const char *file, *words, *more;
        bool shared;
    } cases[] = {{"walk.gltf", "", "'frame': 9,", false},
                 {"walk.gltf", "", "'rate': 9,", true},
                 {"walk.gltf", "", "'frame': 49,", true},
                 {"walk.gltf", ", 'animation': {'speed': 2}", "'frame': 1,", true},
                 {"walk.gltf", ", 'animation': {'speed': 0}", "'frame': 9,", true},
                 {"walk.gltf", ", 'animation': {'clip': 'up'}", "'frame': 1,", false},
                 {"still.gltf", "", "'frame': 9,", true}};
    write_files(*state);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, "{'meshes': {'m': {'file': '%s'}}}", cases[i].file);
        lf_scene *first = lf_test_scene_in(*state, text, NULL);
        snprintf(text, sizeof text, "{%s 'meshes': {'m': {'file': '%s'%s}}}", cases[i].more,
                 cases[i].file, cases[i].words);
        lf_scene *next = lf_test_scene_in(*state, text, first);
        if ((next->geometry == first->geometry) != cases[i].shared)
            fail_msg("%s%s in %s", cases[i].file, cases[i].words, cases[i].more);
        assert_true(json_equal(next->subject, first->subject) == cases[i].shared);
        assert_true(lf_scene_has_frames(first) == (cases[i].file[0] == 'w'));
        lf_scene_unref(first);
        lf_scene_unref(next);
    }
}

/* A scene in a frame, whose shutter is open for 6 of 24 a second. */
static lf_scene *open_in(const char *folder, int frame, const char *more, const char *file,
                         const lf_scene *previous)
{
    char text[512];
    snprintf(text, sizeof text,
             "{'frame': %d, 'camera': {'shutter': 6%s}, 'meshes': {'m': {'file': '%s'}}}", frame,
             more, file);
    return lf_test_scene_in(folder, text, previous);
}

static void an_open_shutter_sees_it_move(void **state)
{
    write_files(*state);
    lf_scene *scene = open_in(*state, 7, "", "walk.gltf", NULL);
    const lf_mesh *mesh = &scene->meshes[0];
    assert_true(lf_has(scene, LF_TRAIT_MOTION));
    for (int i = 0; i < 3 * mesh->n_vertices; i++)
        lf_assert_close((double)(mesh->close.vertices[i] - mesh->vertices[i]), i % 3 ? 0 : 1, 0,
                        1e-5);
    lf_assert_close(scene->geometry->bounds[0][0], 1, 0, 1e-5);
    lf_assert_close(scene->geometry->bounds[1][0], 3, 0, 1e-5);
    lf_scene *again = open_in(*state, 10, ", 'shutter_open': -3", "walk.gltf", scene);
    assert_ptr_equal(again->geometry, scene->geometry);
    assert_true(json_equal(again->subject, scene->subject));
    lf_scene_unref(again);
    again = open_in(*state, 9, "", "walk.gltf", scene);
    assert_ptr_not_equal(again->geometry, scene->geometry);
    lf_scene_unref(scene);
    lf_scene_unref(again);
    scene = open_in(*state, 7, "", "still.gltf", NULL);
    assert_false(lf_has(scene, LF_TRAIT_MOTION));
    lf_scene_unref(scene);
}

static void assert_refused(const char *folder, const char *mesh, const char *pointer,
                           const char *words)
{
    char text[512];
    snprintf(text, sizeof text, "{\"meshes\": {\"m\": {%s}}}", mesh);
    lf_test_assert_refused(folder, text, pointer, words);
}

static void a_wrong_animation_is_told_where_it_is_said(void **state)
{
    write_files(*state);
    assert_refused(*state, "\"file\": \"walk.gltf\", \"animation\": {\"clip\": \"run\"}",
                   "/meshes/m/animation", "no animation \"run\"; expected one of 0, \"up\"");
    assert_refused(*state, "\"file\": \"still.gltf\", \"animation\": {\"clip\": 0}",
                   "/meshes/m/animation", "the file has no animations");
    assert_refused(*state, "\"file\": \"a.obj\", \"animation\": {}", "/meshes/m/animation",
                   "only glTF files can have animations");
    assert_refused(*state, "\"shape\": \"cube\", \"animation\": {}", "/meshes/m/animation",
                   "only glTF files can have animations");
    assert_refused(*state, "\"file\": \"walk.gltf\", \"animation\": {\"clip\": 0.5}",
                   "/meshes/m/animation/clip", "whole number");
    assert_refused(*state, "\"file\": \"walk.gltf\", \"animation\": {\"fast\": true}",
                   "/meshes/m/animation/fast", "unknown key");
}

/* Of what a file leaves to choose, variants of materials are told as its animations are. */
static void a_wrong_variant_is_told_where_it_is_said(void **state)
{
    write_files(*state);
    assert_refused(*state, "\"file\": \"still.gltf\", \"variant\": \"night\"", "/meshes/m/variant",
                   "no variant \"night\"; the file has no variants");
    assert_refused(*state, "\"file\": \"a.obj\", \"variant\": \"night\"", "/meshes/m/variant",
                   "only glTF files can have variants");
    assert_refused(*state, "\"file\": \"still.gltf\", \"variant\": 3", "/meshes/m/variant", "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(the_frame_and_the_rate_say_where_it_stands),
        lf_test_in_folder(what_stands_in_the_same_place_is_not_read_again),
        lf_test_in_folder(an_open_shutter_sees_it_move),
        lf_test_in_folder(a_wrong_animation_is_told_where_it_is_said),
        lf_test_in_folder(a_wrong_variant_is_told_where_it_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
