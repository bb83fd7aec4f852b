/* What a scene leaves to be placed: grounds, and a camera that fits; and what fits leave out. */
#include "tests/testing.h"

#include "tests/stat/fixture.h"

#define CUBE(scale, at)                                                                            \
    "'cube': {'shape': 'cube', 'transform': {'scale': " scale ", 'translate': " at "}}"
#define GROUND "'floor': {'shape': 'disk', 'ground': true}"

static json_t *member(const lf_scene *scene, const char *section, const char *name, const char *key)
{
    json_t *of = json_object_get(lf_scene_json(scene), section);
    return json_object_get(name ? json_object_get(of, name) : of, key);
}

static double number_at(json_t *array, size_t i)
{
    assert_true(json_is_number(json_array_get(array, i)));
    return json_number_value(json_array_get(array, i));
}

static void assert_refused(const char *text, const char *pointer, const char *words)
{
    char said[1000];
    lf_scene *scene = NULL;
    lf_error err = {0};
    snprintf(said, sizeof said, "%s", text);
    for (char *at = said; *at; at++)
        *at = *at == '\'' ? '"' : *at;
    json_t *doc = json_loads(said, 0, NULL);
    assert_non_null(doc);
    lf_assert_status(lf_scene_from_json(doc, "/nowhere", "test", NULL, NULL, &scene, &err),
                     LF_E_FORMAT, &err);
    json_decref(doc);
    if (!strstr(err.what, words) || strcmp(err.pointer, pointer) != 0)
        fail_msg("%s: %s, expected %s: %s", err.pointer, err.what, pointer, words);
}

static bool leaves_out(const char *meshes)
{
    char text[1000];
    snprintf(text, sizeof text, "{'meshes': {%s, " CUBE("1", "[0, 1, 0]") "}}", meshes);
    lf_scene *scene = lf_test_scene(text);
    double all[2][3];
    assert_true(lf_scene_bounds(scene, NULL, all));
    const char *ground = lf_scene_ground(scene, 0);
    const bool out = all[0][0] == -1 && all[1][0] == 1;
    assert_true(out == (ground && strcmp(ground, "floor") == 0));
    lf_scene_unref(scene);
    return out;
}

static void a_fit_leaves_grounds_out(void **state)
{
    (void)state;
    assert_true(leaves_out("'floor': {'shape': 'quad', 'transform': {'scale': 20}}"));
    assert_true(
        leaves_out("'floor': {'shape': 'quad', 'transform': {'scale': 1.5}, 'ground': true}"));
    assert_false(
        leaves_out("'floor': {'shape': 'quad', 'transform': {'scale': 20}, 'ground': false}"));
    assert_false(leaves_out("'floor': {'shape': 'quad', 'transform': {'scale': 1.5}}"));
    assert_false(leaves_out("'floor': {'shape': 'cube', 'transform': {'scale': 20}}"));
    /* when all is ground, all is framed */
    lf_scene *scene =
        lf_test_scene("{'meshes': {'floor': {'shape': 'quad', 'transform': {'scale': 20}, "
                      "'ground': true}}}");
    double all[2][3];
    assert_true(lf_scene_bounds(scene, NULL, all) && all[1][0] == 20);
    assert_null(lf_scene_ground(scene, 0));
    lf_scene_unref(scene);
}

/* The share of the window's height that the model takes up, seen from the middle of the rig. */
static double height_of(const lf_scene *scene, const double half)
{
    const lf_camera *camera = lf_scene_camera(scene);
    double distance = 0;
    for (int i = 0; i < 3; i++)
        distance +=
            (camera->target[i] - camera->position[i]) * (camera->target[i] - camera->position[i]);
    return half / (sqrt(distance) * tan(0.5 * camera->fov_y));
}

static void assert_stands(const char *scale, const char *at, double half, const double middle[3])
{
    char text[1000];
    snprintf(text, sizeof text,
             "{'camera': {'fit': true}, 'meshes': {'cube': {'shape': 'cube', 'transform': "
             "{'scale': %s, 'translate': %s}}, " GROUND "}}",
             scale, at);
    lf_scene *scene = lf_test_scene(text);
    json_t *transform = member(scene, "meshes", "floor", "transform"),
           *to = json_object_get(transform, "translate");
    const double tiny = 1e-6 * half;
    lf_assert_close(number_at(to, 0), middle[0], 0, tiny);
    lf_assert_close(number_at(to, 1), middle[1] - half, 0, tiny);
    lf_assert_close(number_at(to, 2), middle[2], 0, tiny);
    assert_true(json_number_value(json_object_get(transform, "scale")) > 100 * half);
    assert_null(member(scene, "camera", NULL, "fit"));
    json_t *target = member(scene, "camera", NULL, "target"),
           *position = member(scene, "camera", NULL, "position");
    for (size_t i = 0; i < 3; i++) {
        lf_assert_close(number_at(target, i), middle[i], 0, tiny);
        lf_assert_close(number_at(position, i), lf_scene_camera(scene)->position[i], 0, tiny);
    }
    /* from the right, above the ground */
    assert_true(number_at(position, 0) > middle[0] && number_at(position, 2) > middle[2] &&
                number_at(position, 1) > middle[1]);
    assert_true(height_of(scene, half) > 0.3 && height_of(scene, half) < 0.9);
    lf_scene_unref(scene);
}

static void a_model_of_any_size_stands_on_its_ground_before_the_camera(void **state)
{
    (void)state;
    assert_stands("0.005", "[0, 0, 0]", 0.005, (double[]){0, 0, 0});
    assert_stands("1", "[10, -20, 30]", 1, (double[]){10, -20, 30});
    assert_stands("36", "[0, 36, 0]", 36, (double[]){0, 36, 0});
    assert_stands("2500", "[100000, 0, -7]", 2500, (double[]){100000, 0, -7});
}

static void a_volume_stands_on_a_ground_too(void **state)
{
    (void)state;
    lf_scene *scene =
        lf_test_scene("{'volumes': {'fog': {'shape': 'sphere', 'transform': "
                      "{'scale': 3, 'translate': [0, 5, 0]}}}, 'meshes': {" GROUND "}}");
    json_t *to = json_object_get(member(scene, "meshes", "floor", "transform"), "translate");
    lf_assert_close(number_at(to, 1), 2, 0, 1e-5);
    lf_scene_unref(scene);
}

static double ground_below(const char *mesh)
{
    char text[1000];
    snprintf(text, sizeof text, "{'meshes': {%s, " GROUND "}}", mesh);
    lf_scene *scene = lf_test_scene(text);
    json_t *to = json_object_get(member(scene, "meshes", "floor", "transform"), "translate");
    const double y = number_at(to, 1);
    lf_scene_unref(scene);
    return y;
}

static void a_floor_of_a_model_hides_the_ground(void **state)
{
    (void)state;
    const double gap = 1e-3 * sqrt(2); /* a quad's half diagonal */
    lf_assert_close(ground_below("'tiles': {'shape': 'quad', 'ground': false}"), -gap, 0, 1e-9);
    lf_assert_close(ground_below("'tiles': {'shape': 'quad', 'ground': false, 'transform': "
                                 "{'rotate': [180, 0, 0]}}"),
                    -gap, 0, 1e-9);
    /* the bottom of a body, alone and beside a floor that lies higher */
    lf_assert_close(ground_below(CUBE("1", "[0, 1, 0]")), 0, 0, 1e-12);
    lf_assert_close(
        ground_below("'tiles': {'shape': 'quad', 'ground': false}, " CUBE("1", "[0, 0.99, 0]")),
        -0.01, 0, 1e-9);
}

static void the_camera_fits_one_thing_and_looks_from_where_it_is_told(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{'camera': {'fit': 'small', 'position': [-3, 0, 0], 'focus_distance': 1}, 'meshes': "
        "{'small': {'shape': 'cube', 'transform': {'scale': 0.1, 'translate': [7, 0, 0]}}, " CUBE(
            "1", "[0, 0, 0]") "}}");
    const lf_camera *camera = lf_scene_camera(scene);
    lf_assert_close(camera->target[0], 7, 0, 1e-6);
    assert_true(camera->position[0] < 7 && camera->position[1] == 0 && camera->position[2] == 0);
    lf_assert_close(camera->focus_distance, camera->target[0] - camera->position[0], 0, 1e-6);
    lf_scene_unref(scene);
    scene = lf_test_scene("{'camera': {'fit': false}, 'meshes': {" CUBE("1", "[0, 0, 0]") "}}");
    assert_true(lf_scene_camera(scene)->position[2] == 5);
    lf_scene_unref(scene);
}

static void what_cannot_be_placed_is_told(void **state)
{
    (void)state;
    static const char cube[] = "'meshes': {" CUBE("1", "[0, 0, 0]") "}}";
    char text[400];
    snprintf(text, sizeof text, "{'camera': {'fit': 'cub'}, %s", cube);
    assert_refused(text, "/camera/fit", "did you mean \"cube\"?");
    snprintf(text, sizeof text, "{'camera': {'fit': 1}, %s", cube);
    assert_refused(text, "/camera/fit", "expected true, false or the name");
    snprintf(text, sizeof text, "{'camera': {'fit': true, 'from': {'mesh': 'cube'}}, %s", cube);
    assert_refused(text, "/camera/fit", "\"fit\" and \"from\" both place the camera");
    snprintf(text, sizeof text, "{'camera': {'fit': true, 'views': {'circle': {'count': 9}}}, %s",
             cube);
    assert_refused(text, "/camera/fit", "needs as \"views\" a number, or a track or grid");
    snprintf(text, sizeof text,
             "{'camera': {'fit': true, 'views': {'grid': {'columns': 2, 'rows': 2, 'width': 1, "
             "'height': 1, 'window': 'own'}}}, %s",
             cube);
    assert_refused(text, "/camera/fit", "or give position and target");
    assert_refused("{'camera': {'fit': true}}", "/camera/fit", "no object to frame");
    assert_refused("{'meshes': {'floor': {'shape': 'sphere', 'ground': true}}}", "/meshes/floor",
                   "needs a \"transform\"");
}

/* In frame 3 the cube is higher; where the camera and the ground are is found in the scene's own
 * frame. */
static void what_is_placed_is_so_in_all_frames(void **state)
{
    const char *path = lf_test_write(
        *state, "s.json",
        "{\"camera\": {\"fit\": true}, \"meshes\": {\"cube\": {\"shape\": \"cube\", \"transform\": "
        "{\"translate\": {\"keys\": [[1, [0, 0, 0]], [3, [0, 9, 0]]]}}}, \"floor\": {\"shape\": "
        "\"quad\", \"ground\": true}}}");
    lf_scene *scene[2] = {NULL};
    lf_error err;
    json_t *patch = json_pack("{s:i}", "frame", 3);
    lf_assert_ok(lf_scene_load(path, NULL, NULL, &scene[0], &err), &err);
    lf_assert_ok(lf_scene_load_patched(path, NULL, patch, NULL, NULL, &scene[1], &err), &err);
    json_decref(patch);
    double high[2][3];
    assert_true(lf_scene_bounds(scene[1], "cube", high) && high[0][1] == 8);
    assert_true(json_equal(member(scene[0], "meshes", "floor", "transform"),
                           member(scene[1], "meshes", "floor", "transform")));
    assert_true(json_equal(json_object_get(lf_scene_json(scene[0]), "camera"),
                           json_object_get(lf_scene_json(scene[1]), "camera")));
    lf_scene_unref(scene[0]);
    lf_scene_unref(scene[1]);
}

static bool is_seen(const char *camera)
{
    char text[1000];
    snprintf(text, sizeof text,
             "{'camera': {%s}, 'meshes': {'floor': {'shape': 'quad', 'transform': {'scale': 50, "
             "'translate': [0, -1, 0]}}, " CUBE("1", "[0, 0, 0]") "}}",
             camera);
    lf_scene *scene = lf_test_scene(text);
    const lf_render_settings settings = {
        .camera = *lf_scene_camera(scene), .width = 30, .height = 40};
    const bool seen = lf_scene_is_seen(scene, &settings);
    lf_scene_unref(scene);
    return seen;
}

static void what_no_camera_sees_is_not_seen(void **state)
{
    (void)state;
    assert_true(is_seen("'position': [0, 0, 9]"));
    assert_true(is_seen("'position': [0, 0, 0.5]"));
    assert_false(is_seen("'position': [0, 0, 9], 'target': [0, 0, 20]"));
    assert_false(is_seen("'position': [9, 0, 9], 'target': [9, 0, 0], 'cone': 0"));
    /* seen by an outer camera only */
    assert_true(is_seen("'position': [6, 0, 9], 'target': [6, 0, 5], 'cone': 120"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_fit_leaves_grounds_out),
        cmocka_unit_test(a_model_of_any_size_stands_on_its_ground_before_the_camera),
        cmocka_unit_test(a_volume_stands_on_a_ground_too),
        cmocka_unit_test(a_floor_of_a_model_hides_the_ground),
        cmocka_unit_test(the_camera_fits_one_thing_and_looks_from_where_it_is_told),
        cmocka_unit_test(what_cannot_be_placed_is_told),
        lf_test_in_folder(what_is_placed_is_so_in_all_frames),
        cmocka_unit_test(what_no_camera_sees_is_not_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
