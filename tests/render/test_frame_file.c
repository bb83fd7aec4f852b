/* Which file a volume is in which frame, and what a wrong number is told as. */
#include "tests/testing.h"

#include "render/render.h"

/* What the parser says of the file in a frame: none of them is there. */
static void assert_says(const char *volume, int frame, const char *pointer, const char *words)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc =
        json_pack("{s:i, s:{s:o}}", "frame", frame, "volumes", "v", json_loads(volume, 0, NULL));
    assert_non_null(doc);
    assert_int_not_equal(lf_scene_from_json(doc, "/nowhere", "test", NULL, NULL, &scene, &err),
                         LF_OK);
    json_decref(doc);
    if (!strstr(err.what, words) || strcmp(err.pointer, pointer) != 0)
        fail_msg("%s: %s, expected %s: %s", err.pointer, err.what, pointer, words);
}

static void the_file_has_the_number_of_the_frame_or_what_the_sequence_says(void **state)
{
    (void)state;
    static const char slow[] =
        "{\"file\": \"a_%04d.vdb\", \"sequence\": {\"first\": 101, \"step\": 0.5}}",
                      back[] =
                          "{\"file\": \"a%d.vdb\", \"sequence\": {\"first\": 9, \"step\": -4}}",
                      cents[] =
                          "{\"file\": \"a%d.vdb\", \"sequence\": {\"first\": 0, \"step\": 0.29}}";
    assert_says("{\"file\": \"a_%04d.vdb\"}", 7, "/volumes/v/file", "/nowhere/a_0007.vdb");
    assert_says("{\"file\": \"a_%04d.vdb\"}", 0, "/volumes/v/file", "/nowhere/a_0000.vdb");
    assert_says("{\"file\": \"a%20.vdb\"}", 7, "/volumes/v/file", "/nowhere/a%20.vdb");
    assert_says(slow, 1, "/volumes/v/file", "a_0101.vdb");
    assert_says(slow, 2, "/volumes/v/file", "a_0101.vdb");
    assert_says(slow, 3, "/volumes/v/file", "a_0102.vdb");
    assert_says(back, 3, "/volumes/v/file", "a1.vdb");
    assert_says(back, 4, "/volumes/v",
                "the number of the file would be out of range in frame 4: -3");
    assert_says(cents, 101, "/volumes/v/file", "a29.vdb");
    assert_says("{\"file\": \"a.vdb\", \"sequence\": {\"first\": 2}}", 1, "/volumes/v/sequence",
                "needs a field for the frame number");
}

/* Of frame 1 nothing is read that only others need. */
static void a_frame_is_checked_without_reading_it(void **state)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    char there[PATH_MAX];
    snprintf(there, sizeof there, "%s", lf_test_built("testdata/block.vdb"));
    assert_int_equal(
        symlink(there[0] == '/' ? there : realpath(there, NULL), lf_test_path(*state, "b_1.vdb")),
        0);
    const char *path = lf_test_write(*state, "s.json",
                                     "{\"volumes\": {\n\"v\": {\n\"file\": \"b_%d.vdb\", "
                                     "\"sequence\": {\"missing\": \"error\"}}}}");
    lf_test_write(*state, "b_3.vdb", "no grid");
    lf_assert_ok(lf_scene_load(path, NULL, NULL, &scene, &err), &err);
    assert_true(lf_scene_has_frames(scene));
    lf_assert_ok(lf_scene_check_frame(scene, 1, &err), &err);
    lf_assert_ok(lf_scene_check_frame(scene, 3, &err), &err);
    lf_assert_status(lf_scene_check_frame(scene, 2, &err), LF_E_IO, &err);
    assert_string_equal(err.pointer, "/volumes/v/file");
    assert_non_null(strstr(err.what, "b_2.vdb: cannot open"));
    lf_scene_unref(scene);
    json_t *patch = json_pack("{s:i}", "frame", 2);
    lf_assert_status(lf_scene_load_patched(path, NULL, patch, NULL, NULL, &scene, &err), LF_E_IO,
                     &err);
    assert_int_equal(err.line, 3);
    assert_non_null(strstr(err.what, "b_2.vdb"));
    json_decref(patch);
    json_t *doc = json_pack("{s:{s:{s:s}}}", "volumes", "v", "shape", "box");
    lf_assert_ok(lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, &err), &err);
    assert_false(lf_scene_has_frames(scene));
    lf_scene_unref(scene);
    json_decref(doc);
}

static lf_scene *load_frame(const char *path, int frame)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *patch = json_pack("{s:i}", "frame", frame);
    lf_assert_ok(lf_scene_load_patched(path, NULL, patch, NULL, NULL, &scene, &err), &err);
    json_decref(patch);
    return scene;
}

static bool has_warned(const lf_scene *scene, const char *words)
{
    for (int i = 0; lf_scene_warning(scene, i); i++)
        if (strstr(lf_scene_warning(scene, i), words))
            return true;
    return false;
}

static void a_hole_holds_the_file_before_it_or_nothing(void **state)
{
    char there[PATH_MAX];
    double box[2][3];
    lf_error err = {0};
    assert_non_null(realpath(lf_test_built("testdata/block.vdb"), there));
    for (int i = 1; i <= 4; i += 3) {
        char name[16];
        snprintf(name, sizeof name, "c_%d.vdb", i);
        assert_int_equal(symlink(there, lf_test_path(*state, name)), 0);
    }
    const char *held =
        lf_test_write(*state, "held.json", "{\"volumes\": {\"v\": {\"file\": \"c_%d.vdb\"}}}");
    lf_scene *scene = load_frame(held, 3);
    assert_true(has_warned(scene, "c_3.vdb: the file is missing; frame 3 shows c_1.vdb"));
    assert_true(lf_scene_bounds(scene, "v", box));
    lf_assert_ok(lf_scene_check_frame(scene, 2, &err), &err);
    /* behind the last file nothing is held */
    lf_assert_status(lf_scene_check_frame(scene, 5, &err), LF_E_IO, &err);
    lf_assert_status(lf_scene_check_frame(scene, 0, &err), LF_E_IO, &err);
    lf_scene_unref(scene);
    scene = load_frame(held, 4);
    assert_false(has_warned(scene, "missing"));
    lf_scene_unref(scene);
    scene = load_frame(lf_test_write(*state, "empty.json",
                                     "{\"volumes\": {\"v\": {\"file\": \"c_%d.vdb\", \"emission\": "
                                     "{\"grid\": \"density\"}, \"sequence\": {\"missing\": "
                                     "\"empty\"}}}}"),
                       2);
    assert_true(
        has_warned(scene, "c_2.vdb: the file is missing; volume \"v\" is empty in frame 2"));
    assert_false(lf_scene_bounds(scene, "v", box));
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_file_has_the_number_of_the_frame_or_what_the_sequence_says),
        lf_test_in_folder(a_frame_is_checked_without_reading_it),
        lf_test_in_folder(a_hole_holds_the_file_before_it_or_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
