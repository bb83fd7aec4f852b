/* The camera's table: what scene files and docs/scene.schema.json say of a camera is what it says.
 */
#include "tests/testing.h"

#include <jansson.h>

#include "render/render.h"

/* A schema without references: those of this file name parts under $defs. */
static const json_t *resolve(const json_t *schema, const json_t *part)
{
    const char *reference = json_string_value(json_object_get(part, "$ref"));
    return reference
               ? json_object_get(json_object_get(schema, "$defs"), reference + strlen("#/$defs/"))
               : part;
}

/* What a number may be where it has no keys: those have the other form. */
static const json_t *plain(const json_t *schema, const json_t *part)
{
    const json_t *any = json_object_get(part, "anyOf");
    return any ? resolve(schema, json_array_get(any, 0)) : part;
}

static void same_number(const char *name, const json_t *a, const json_t *b, const char *key)
{
    if (json_number_value(json_object_get(a, key)) != json_number_value(json_object_get(b, key)))
        fail_msg("%s: another %s", name, key);
}

static void the_schema_of_scenes_says_of_the_camera_what_its_table_says(void **state)
{
    (void)state;
    json_t *schema = json_load_file(lf_test_source("docs/scene.schema.json"), 0, NULL);
    const json_t *camera = json_object_get(json_object_get(schema, "$defs"), "camera");
    json_t *properties = json_object_get(camera, "properties");
    json_t *table = lf_param_schema(lf_camera_params);
    lf_camera initial = {0};
    lf_param_defaults(lf_camera_params, &initial);
    json_t *defaults = lf_param_json(lf_camera_params, &initial);
    const char *name;
    json_t *said;
    assert_int_equal(json_object_size(properties), json_object_size(table) + 1); /* "from" */
    json_object_foreach(table, name, said)
    {
        const json_t *property = resolve(schema, json_object_get(properties, name));
        const json_t *value_of = plain(schema, property);
        const json_t *items = resolve(schema, json_object_get(value_of, "items"));
        if (!property)
            fail_msg("the schema has no \"%s\"", name);
        same_number(name, value_of, said, "minimum");
        same_number(name, value_of, said, "maximum");
        if (items) {
            same_number(name, items, json_object_get(said, "items"), "minimum");
            same_number(name, items, json_object_get(said, "items"), "maximum");
            continue;
        }
        assert_true(json_equal(json_object_get(property, "enum"), json_object_get(said, "enum")) ||
                    !json_object_get(said, "enum"));
        const json_t *fallback = json_object_get(property, "default");
        const json_t *value = json_object_get(defaults, name);
        if (fallback && json_is_number(fallback))
            lf_assert_close(json_number_value(fallback), json_number_value(value), 1e-12, 0.0);
        else if (fallback)
            assert_true(json_equal(fallback, value));
    }
    json_decref(defaults);
    json_decref(table);
    json_decref(schema);
}

static void a_scene_that_says_nothing_has_the_camera_of_the_table(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    const char *path = lf_test_write(
        folder, "s.json",
        "{\"quiltd\":1,\"lights\":{\"l\":{\"type\":\"environment\",\"radiance\":1}}}");
    lf_scene *scene = NULL;
    lf_error err;
    lf_assert_ok(lf_scene_load(path, NULL, NULL, &scene, &err), &err);
    lf_camera expected = {0};
    lf_param_defaults(lf_camera_params, &expected);
    expected.focus_distance = 5;
    json_t *said = lf_param_json(lf_camera_params, lf_scene_camera(scene));
    json_t *table = lf_param_json(lf_camera_params, &expected);
    assert_true(json_equal(said, table));
    json_decref(said);
    json_decref(table);
    lf_scene_unref(scene);
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_schema_of_scenes_says_of_the_camera_what_its_table_says),
        cmocka_unit_test(a_scene_that_says_nothing_has_the_camera_of_the_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
