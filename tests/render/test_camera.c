/* The camera's table: what scene files and docs/scene.schema.json say of a camera is what it says.
 */
#include "tests/testing.h"

#include <jansson.h>

#include "render/plane/rig.h"
#include "render/render.h"
#include "tests/stat/fixture.h"

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
    assert_int_equal(json_object_size(properties), json_object_size(table) + 2); /* "from", "fit" */
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

static void views_stand_on_a_track(void **state)
{
    (void)state;
    static const char text[] = "{'camera': {'fov_y': 30, 'cone': 20, "
                               "'views': {'track': {'length': 2.5%s}}}}";
    char scene_text[256];
    for (int i = 0; i < 3; i++) {
        static const char *const more[] = {"", ", 'count': 100, 'window': 'own'",
                                           ", 'window': 'shared'"};
        snprintf(scene_text, sizeof scene_text, text, more[i]);
        lf_scene *scene = lf_test_scene(scene_text);
        const lf_camera *camera = lf_scene_camera(scene);
        lf_assert_close(camera->fov_y, M_PI / 6, 1e-15, 0);
        assert_true(camera->track == 2.5 && camera->n_views == (i == 1 ? 100 : 45));
        assert_true(camera->own_windows == (i < 2) && camera->has_views);
        lf_scene_unref(scene);
    }
}

/* The parts of a long track are its cameras, from the left on, each where the track has it: as many
 * rigs of shorter tracks, moved. */
static void a_long_track_is_parts_of_equal_length(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{'camera': {'position': [0, 0, 5], 'views': {'track': "
                                    "{'length': 3, 'count': 1000}}}}");
    const lf_camera *camera = lf_scene_camera(scene);
    assert_true(camera->n_views == 250 && camera->n_rows == 4 && lf_camera_views(camera) == 1000);
    lf_render_settings settings = {.width = 8, .height = 8};
    for (int part = 0; part < 4; part++) {
        lf_rig rig;
        settings.camera = lf_camera_row(camera, part);
        assert_int_equal(lf_camera_views(&settings.camera), 250);
        lf_assert_ok(lf_rig_init(&rig, &settings, scene->origin, NULL), NULL);
        for (int k = 0; k < 250; k++)
            lf_assert_close((double)rig.b[k], 3 * ((250 * part + k) / 999.0 - 0.5), 1e-6, 1e-7);
        assert_true(rig.skew[249] == 0.0f);
    }
    settings.camera.first_view = 751;
    lf_rig rig;
    lf_assert_status(lf_rig_init(&rig, &settings, scene->origin, NULL), LF_E_ARG, NULL);
    lf_scene_unref(scene);
}

static void views_stand_in_a_grid(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{'camera': {'views': {'grid': {'columns': 9, 'rows': 5, "
                                    "'width': 2, 'height': 3}}}}");
    const lf_camera *camera = lf_scene_camera(scene);
    assert_true(camera->n_views == 9 && camera->n_rows == 5 && lf_camera_views(camera) == 45);
    assert_true(camera->track == 2 && camera->rows_height == 3 && !camera->own_windows);
    for (int row = 0; row < 5; row++) {
        const lf_camera one = lf_camera_row(camera, row);
        lf_assert_close(one.rise, -1.5 + 0.75 * row, 1e-15, 1e-15);
        assert_true(lf_camera_views(&one) == 9 && one.track == 2);
    }
    lf_scene_unref(scene);
}

static void a_track_that_is_none_is_refused(void **state)
{
    (void)state;
    static const char *const bad[][3] = {
        {"{}", "", "expected {\"track\": {\"count\""},
        {"{'track': {'length': 1}, 'grid': {}}", "", "{\"grid\": {…}}, {\"list\""},
        {"{'grid': {'columns': 3, 'width': 1, 'height': 1}}", "/grid", "\"rows\" is missing"},
        {"{'grid': {'columns': 3, 'rows': 0, 'width': 1, 'height': 1}}", "/grid/rows",
         "out of range: 1 to 256"},
        {"{'trak': {}}", "/trak", "did you mean \"track\"?"},
        {"{'track': {'count': 9}}", "/track", "\"length\" is missing"},
        {"{'track': {'length': 0}}", "/track/length", "out of range"},
        {"{'track': {'length': 1, 'count': 3000}}", "/track/count", "out of range: 1 to 2048"},
        {"{'track': {'length': 1, 'count': 1999}}", "/track/count",
         "cannot be divided into equal parts of 64 to 256 cameras; 1998 can"},
        {"{'track': {'length': 1, 'window': 'one'}}", "/track/window", "did you mean \"own\"?"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char text[256], pointer[64];
        snprintf(text, sizeof text, "{'camera': {'views': %s}}", bad[i][0]);
        snprintf(pointer, sizeof pointer, "/camera/views%s", bad[i][1]);
        lf_test_assert_refused(".", text, pointer, bad[i][2]);
    }
    lf_test_assert_refused(".", "{'camera': {'fov': 3, 'views': {'track': {'length': 1}}}}",
                           "/camera/fov", "unknown key");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_schema_of_scenes_says_of_the_camera_what_its_table_says),
        cmocka_unit_test(a_scene_that_says_nothing_has_the_camera_of_the_table),
        cmocka_unit_test(views_stand_on_a_track),
        cmocka_unit_test(views_stand_in_a_grid),
        cmocka_unit_test(a_long_track_is_parts_of_equal_length),
        cmocka_unit_test(a_track_that_is_none_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
