/* Scene files with the keys of former releases (0.1 and before 0.2.0: "rate", "kelvin") are read as
 * if they had the current names, from files, documents, includes and patches. */
#include "tests/testing.h"

#include "render/import/scene/former_keys.h"
#include "render/render.h"
#include "render/scene/handle.h"

static json_t *parse(const char *text)
{
    json_error_t problem;
    json_t *doc = json_loads(text, JSON_REJECT_DUPLICATES, &problem);
    if (!doc)
        fail_msg("%s: %s", text, problem.text);
    return doc;
}

static void check(const char *former, const char *current)
{
    json_t *doc = parse(former), *wanted = parse(current), *renamed = lf_former_keys_renamed(doc);
    if (!json_equal(renamed, wanted))
        fail_msg("%s became %s", former, json_dumps(renamed, 0));
    json_decref(renamed);
    json_decref(wanted);
    json_decref(doc);
}

static void former_names_become_current_names(void **state)
{
    (void)state;
    check("{\"rate\": 12}", "{\"fps\": 12}");
    check("{\"rate\": null}", "{\"fps\": null}");
    check("{\"volumes\": {\"v\": {\"emission\": {\"kelvin\": 2000, \"scale\": 4}}}}",
          "{\"volumes\": {\"v\": {\"emission\": {\"scale\": 4, \"temperature_scale\": 2000}}}}");
    /* names of objects, and keys of other objects, are not keys of these */
    check("{\"volumes\": {\"rate\": {\"kelvin\": 1}}}",
          "{\"volumes\": {\"rate\": {\"kelvin\": 1}}}");
    check("{\"meshes\": {\"m\": {\"rate\": 1}}}", "{\"meshes\": {\"m\": {\"rate\": 1}}}");
}

static void a_document_without_former_names_is_the_same_one(void **state)
{
    (void)state;
    json_t *doc = parse("{\"fps\": 12, \"volumes\": {\"v\": {\"emission\": 3}}}");
    json_t *renamed = lf_former_keys_renamed(doc);
    assert_ptr_equal(renamed, doc);
    json_decref(renamed);
    json_decref(doc);
}

static lf_status load(const char *text, lf_scene **out, lf_error *err)
{
    json_t *doc = parse(text);
    lf_status status = lf_scene_from_json(doc, "/", "test", NULL, NULL, out, err);
    json_decref(doc);
    return status;
}

static void a_scene_with_a_former_name_is_the_same_scene(void **state)
{
    (void)state;
    lf_scene *former = NULL, *current = NULL;
    lf_error err;
    lf_assert_ok(load("{\"quiltd\": 1, \"rate\": 12.5}", &former, &err), &err);
    lf_assert_ok(load("{\"quiltd\": 1, \"fps\": 12.5}", &current, &err), &err);
    assert_true(lf_scene_rate(former) == 12.5);
    assert_true(json_equal(lf_scene_json(former), lf_scene_json(current)));
    lf_scene_unref(former);
    lf_scene_unref(current);
}

static void both_names_at_once_are_refused(void **state)
{
    (void)state;
    lf_scene *scene = NULL;
    lf_error err;
    assert_int_equal(load("{\"fps\": 24, \"rate\": 12}", &scene, &err), LF_E_FORMAT);
    assert_string_equal(err.pointer, "/rate");
    assert_string_equal(err.what, "is the former name of fps; give only one of them");
}

static void patches_with_a_former_name_change_the_current_key(void **state)
{
    (void)state;
    json_t *doc = parse("{\"fps\": 24}"), *patch = parse("{\"rate\": 12}"),
           *wanted = parse("{\"fps\": 12}"), *merged = lf_json_merge_patch(doc, patch);
    assert_true(json_equal(merged, wanted));
    assert_true(lf_json_merge_into(doc, patch));
    assert_true(json_equal(doc, wanted));
    json_decref(merged);
    json_decref(wanted);
    json_decref(patch);
    json_decref(doc);
}

/* A former client gets the current name, sets its own, and sends the whole document back. */
static void in_a_patch_the_former_name_replaces_the_current_one(void **state)
{
    (void)state;
    json_t *doc = parse("{\"fps\": 24}"), *patch = parse("{\"fps\": 24, \"rate\": 12}"),
           *wanted = parse("{\"fps\": 12}"), *merged = lf_json_merge_patch(doc, patch);
    assert_true(json_equal(merged, wanted));
    json_decref(merged);
    json_decref(wanted);
    json_decref(patch);
    json_decref(doc);
}

static void errors_of_a_former_name_have_its_line(void **state)
{
    const char *path =
        lf_test_write(*state, "old.json", "{\n \"quiltd\": 1,\n \"rate\": \"fast\"\n}\n");
    lf_scene *scene = NULL;
    lf_error err;
    assert_int_equal(lf_scene_load(path, NULL, NULL, &scene, &err), LF_E_FORMAT);
    assert_int_equal(err.line, 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(former_names_become_current_names),
        cmocka_unit_test(a_document_without_former_names_is_the_same_one),
        cmocka_unit_test(a_scene_with_a_former_name_is_the_same_scene),
        cmocka_unit_test(both_names_at_once_are_refused),
        cmocka_unit_test(patches_with_a_former_name_change_the_current_key),
        cmocka_unit_test(in_a_patch_the_former_name_replaces_the_current_one),
        cmocka_unit_test_setup_teardown(errors_of_a_former_name_have_its_line, lf_test_folder_setup,
                                        lf_test_folder_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
