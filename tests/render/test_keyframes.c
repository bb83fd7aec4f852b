/* Numbers with keys are those of the frame, wherever they stand, and a wrong key is told where it
 * is. */
#include "tests/testing.h"

#include "render/import/scene/keyframes.h"
#include "render/scene/geometry.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* text with ' for ". */
static json_t *document(const char *text)
{
    char copy[2048];
    snprintf(copy, sizeof copy, "%s", text);
    for (char *c = copy; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *doc = json_loads(copy, 0, NULL);
    if (!doc)
        fail_msg("not JSON: %s", copy);
    return doc;
}

/* What the camera's fov_y with these keys is in a frame. */
static double number_at(const char *keys, double frame)
{
    char text[512];
    lf_error err = {0};
    lf_reader reader = {"test", NULL, 0, LF_OK, &err, NULL, 0, false};
    bool keyed;
    snprintf(text, sizeof text, "{'frame': %g, 'camera': {'fov_y': {%s}}}", frame, keys);
    lf_node root = {NULL, NULL, 0, document(text)};
    json_t *still = lf_keyframes_still(&reader, &root, -1, &keyed);
    lf_assert_ok(reader.status, &err);
    assert_true(keyed);
    double value = json_number_value(json_object_get(json_object_get(still, "camera"), "fov_y"));
    json_decref(still);
    json_decref(root.value);
    return value;
}

static void a_number_is_that_of_its_keys_in_the_frame(void **state)
{
    (void)state;
    static const char line[] = "'keys': [[1, 10], [5, 30], [7, 20]]",
                      step[] = "'keys': [[1, 10], [5, 30]], 'interpolation': 'step'",
                      smooth[] = "'keys': [[1, 10], [5, 30]], 'interpolation': 'smooth'";
    const struct {
        const char *keys;
        double frame, value;
    } cases[] = {{line, 0, 10},   {line, 1, 10},      {line, 2, 15},   {line, 5, 30},
                 {line, 6, 25},   {line, 7, 20},      {line, 99, 20},  {step, 4, 10},
                 {step, 5, 30},   {step, 0, 10},      {smooth, 1, 10}, {smooth, 3, 20},
                 {smooth, 5, 30}, {smooth, 2, 13.125}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        lf_assert_close(number_at(cases[i].keys, cases[i].frame), cases[i].value, 0, 1e-12);
    assert_true(number_at("'keys': [[3, 0.1]]", 1) == 0.1);
}

static void keys_stand_wherever_numbers_stand_and_nowhere_else(void **state)
{
    (void)state;
    json_t *moving = lf_test_scene_document("keyed-everywhere"),
           *plain = lf_test_scene_document("keyed-at-frame-2");
    lf_scene *a = NULL, *b = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_scene_from_json(moving, "/", "test", NULL, NULL, &a, &err), &err);
    lf_assert_ok(lf_scene_from_json(plain, "/", "test", NULL, NULL, &b, &err), &err);
    assert_true(json_equal(a->file.still, plain) && json_equal(a->subject, b->subject));
    assert_true(json_equal(lf_scene_json(a), moving));
    assert_true(a->camera.position[0] == 1 && a->camera.position[2] == 5);
    assert_true(lf_scene_has_frames(a) && !lf_scene_has_frames(b));
    assert_ptr_equal(b->file.still, b->json);
    lf_scene_unref(a);
    lf_scene_unref(b);
    json_decref(moving);
    json_decref(plain);
}

/* Another frame is a patch; what stands still is shared. */
static void a_patch_of_the_frame_moves_what_has_keys(void **state)
{
    (void)state;
    json_t *doc = document("{'camera': {'position': {'keys': [[1, [0, 0, 4]], [5, [4, 0, 4]]]}},"
                           "'meshes': {'m': {'shape': 'cube'}}}"),
           *patch = document("{'frame': 2}"), *next_doc;
    lf_scene *scene = NULL, *next = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, &err), &err);
    next_doc = lf_json_merge_patch(lf_scene_json(scene), patch);
    lf_assert_ok(lf_scene_from_json(next_doc, "/", "test", NULL, scene, &next, &err), &err);
    assert_true(scene->camera.position[0] == 0 && next->camera.position[0] == 1);
    assert_ptr_equal(scene->geometry, next->geometry);
    lf_scene_unref(next);
    lf_scene_unref(scene);
    json_decref(next_doc);
    json_decref(patch);
    json_decref(doc);
}

static void assert_refused(const char *text, const char *pointer, const char *words)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc = document(text);
    lf_assert_status(lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, &err), LF_E_FORMAT,
                     &err);
    json_decref(doc);
    if (strcmp(err.pointer, pointer) != 0 || !strstr(err.what, words))
        fail_msg("%s: %s", err.pointer, err.what);
}

#define FOV(words) "{'camera': {'fov_y': {" words "}}}"

static void a_wrong_key_is_told_where_it_stands(void **state)
{
    (void)state;
    assert_refused(FOV("'keys': []"), "/camera/fov_y/keys", "at least one");
    assert_refused(FOV("'keys': [[1, 2], 3]"), "/camera/fov_y/keys/1", "[frame, value]");
    assert_refused(FOV("'keys': [[1, 2, 3]]"), "/camera/fov_y/keys/0", "[frame, value]");
    assert_refused(FOV("'keys': [[-1, 2]]"), "/camera/fov_y/keys/0/0", "0 to 999999");
    assert_refused(FOV("'keys': [[1, 'a']]"), "/camera/fov_y/keys/0/1", "expected a number");
    assert_refused(FOV("'keys': [[1, 9], [1, 9]]"), "/camera/fov_y/keys/1", "order");
    assert_refused(FOV("'keys': [[1, 9], [9, 9], [4, 9]]"), "/camera/fov_y/keys/2", "order");
    assert_refused(FOV("'keys': [[1, 9], [2, [9]]]"), "/camera/fov_y/keys/1", "as many numbers");
    assert_refused(FOV("'keys': [[1, 9]], 'interpolation': 'cubic'"), "/camera/fov_y/interpolation",
                   "cubic");
    assert_refused(FOV("'keys': [[1, 9]], 'key': 1"), "/camera/fov_y/key", "unknown key");
    assert_refused(FOV("'keys': [[1, 900]]"), "/camera/fov_y", "out of range");
    assert_refused(FOV("'keys': [[1, [9, 9]]]"), "/camera/fov_y", "expected a number");
    assert_refused("{'camera': {'views': {'keys': [[1, 9]]}}}", "/camera/views/keys",
                   "unknown key");
    assert_refused("{'frame': {'keys': [[1, 9]]}}", "/frame", "an object");
    assert_refused("{'volumes': {'v': {'file': 'a%d.vdb', 'sequence': {'step': {'keys': [[1, 9]]}}"
                   "}}}",
                   "/volumes/v/sequence/step", "an object");
}

static void what_is_wrong_in_a_later_frame_is_found_without_loading_it(void **state)
{
    (void)state;
    json_t *doc = document(FOV("'keys': [[1, 10], [11, 210]]"));
    lf_scene *scene = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, &err), &err);
    lf_assert_ok(lf_scene_check_frame(scene, 8, &err), &err);
    lf_assert_status(lf_scene_check_frame(scene, 9, &err), LF_E_FORMAT, &err);
    assert_string_equal(err.pointer, "/camera/fov_y");
    assert_non_null(strstr(err.what, "170 is out of range"));
    lf_scene_unref(scene);
    json_decref(doc);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_number_is_that_of_its_keys_in_the_frame),
        cmocka_unit_test(keys_stand_wherever_numbers_stand_and_nowhere_else),
        cmocka_unit_test(a_patch_of_the_frame_moves_what_has_keys),
        cmocka_unit_test(a_wrong_key_is_told_where_it_stands),
        cmocka_unit_test(what_is_wrong_in_a_later_frame_is_found_without_loading_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
