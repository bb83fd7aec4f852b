/* Scenes of tests from files, and their patches. */
#include "tests/testing.h"

#include "tests/scene_file.h"

static void assert_document(const char *text, const char *expected)
{
    json_t *got = json_loads(text, 0, NULL), *wanted = lf_test_json("expected", expected);
    assert_non_null(got);
    assert_true(json_equal(got, wanted));
    json_decref(got);
    json_decref(wanted);
}

static void a_scene_is_the_document_of_its_file(void **state)
{
    (void)state;
    json_t *doc = lf_test_scene_document("fogs");
    json_t *text = json_loads(lf_test_scene_text("fogs"), 0, NULL);
    assert_true(json_equal(doc, text));
    assert_string_equal(json_object_iter_key(json_object_iter(doc)), "quiltd");
    json_decref(text);
    json_decref(doc);
}

static void a_patch_changes_adds_and_removes(void **state)
{
    (void)state;
    assert_document(lf_test_scene_patched("fogs",
                                          "{'comment': null, 'camera': {'views': %d, 'position': "
                                          "null, 'cone': null, 'fov_y': null, 'aspect': null}, "
                                          "'volumes': null, 'lights': {'sky': {'radiance': %g}, "
                                          "'sun': null}, 'render': {}}",
                                          7, 0.5),
                    "{'quiltd': 1, 'camera': {'views': 7}, 'lights': {'sky': {'type': "
                    "'environment', 'radiance': 0.5}}, 'render': {}}");
}

static void texts_of_one_scene_differ_in_their_views(void **state)
{
    (void)state;
    const char *three = lf_test_scene_views("fogs", 3), *nine = lf_test_scene_views("fogs", 9);
    assert_non_null(strstr(three, "\"views\": 3"));
    assert_non_null(strstr(nine, "\"views\": 9"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_is_the_document_of_its_file),
        cmocka_unit_test(a_patch_changes_adds_and_removes),
        cmocka_unit_test(texts_of_one_scene_differ_in_their_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
