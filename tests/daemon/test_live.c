/* The daemon with a simulated panel, from outside: pictures that move, patches, buttons, faults of
 * the panel. */
#include "tests/daemon/live.h"

#include "base/calibration.h"
#include "base/image_io.h"
#include "quilt/quilt.h"

static void a_scene_becomes_complete_on_the_panel(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_true(live_number(&c, "status", NULL, "updates") >= 1);
    assert_true(live_number(&c, "status", NULL, "bytes") >= 96 * 128 * 3);
    assert_true(live_number(&c, "status", NULL, "missing") == 0);
    assert_true(live_number(&c, "status", NULL, "views") == 6);
    /* not at the end, when a slow disk has what can be left out left out */
    live_wait_for_file(lf_test_path(l.folder, "sim/quilt.png"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    lf_image8 panel = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(l.panel, NULL, &panel, &err), &err);
    assert_int_equal(panel.width, 96);
    lf_image8_finish(&panel);
    live_finish(&l);
}

static void every_move_is_a_new_generation_that_is_shown(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (int i = 0; i < 10; i++) {
        double generation = live_number(
            &c, "camera.orbit", json_pack("{s:i, s:i}", "yaw", 7, "pitch", 1), "generation");
        assert_true(generation == 2 + i);
        json_t *answer =
            live_call(&c, "wait", json_pack("{s:i, s:s}", "generation", 2 + i, "for", "coarse"));
        assert_true(json_integer_value(
                        json_object_get(json_object_get(answer, "result"), "generation")) >= 2 + i);
        json_decref(answer);
    }
    assert_true(live_number(&c, "camera.set", json_pack("{s:f}", "fov_y", 20.0), "generation") ==
                12);
    json_t *scene = live_call(&c, "scene.get", NULL);
    const json_t *camera =
        json_object_get(json_object_get(json_object_get(scene, "result"), "scene"), "camera");
    lf_assert_close(json_number_value(json_object_get(camera, "fov_y")), 20, 0, 0);
    double x = json_number_value(json_array_get(json_object_get(camera, "position"), 0));
    double z = json_number_value(json_array_get(json_object_get(camera, "position"), 2));
    lf_assert_close(atan2(x, z) * 180 / acos(-1.0), 70, 1e-9, 0);
    json_decref(scene);
    assert_int_equal(live_code(&c, "wait", json_pack("{s:i}", "generation", 13)), -32602);
    live_close(&c);
    live_finish(&l);
}

static void a_bad_patch_says_where_and_leaves_the_picture(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *patch = json_loads("{\"volumes\":{\"fog\":{\"density\":\"thick\"}}}", 0, NULL);
    json_t *answer = live_call(&c, "scene.patch", json_pack("{s:o}", "patch", patch));
    const json_t *error = json_object_get(answer, "error");
    assert_int_equal(json_integer_value(json_object_get(error, "code")), -32002);
    const json_t *data = json_object_get(error, "data");
    assert_string_equal(json_string_value(json_object_get(data, "pointer")),
                        "/volumes/fog/density");
    assert_string_equal(json_string_value(json_object_get(data, "file")), l.scene);
    json_decref(answer);
    assert_true(live_number(&c, "status", NULL, "generation") == 1);
    assert_int_equal(live_code(&c, "camera.set", json_pack("{s:i}", "views", 9)), 0);
    assert_true(live_number(&c, "status", NULL, "views") == 9);
    live_wait(&c, "coarse");
    live_close(&c);
    live_finish(&l);
}

/* Of status; < 0: null. */
static double seconds_left(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL);
    const json_t *left = json_object_get(json_object_get(answer, "result"), "seconds_left");
    assert_non_null(left);
    const double seconds = json_is_null(left) ? -1 : json_number_value(left);
    json_decref(answer);
    return seconds;
}

static void how_to_render_can_be_changed(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "estimator", "cv")), 0);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "estimator", "guess")), -32602);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "integrator", "guess")),
                     -32602);
    json_t *answer = live_call(&c, "render.set", json_pack("{s:s}", "integrator", "mvpt2022"));
    const json_t *refusal = json_object_get(answer, "error");
    assert_int_equal(json_integer_value(json_object_get(refusal, "code")), -32602);
    assert_non_null(strstr(json_string_value(json_object_get(refusal, "message")),
                           "mvpt2022 is a reference mode; use it with quiltrender or quiltbench"));
    json_decref(answer);
    assert_true(live_number(&c, "status", NULL, "generation") == 1);
    assert_true(
        live_number(&c, "render.set", json_pack("{s:s}", "integrator", "vpt"), "generation") == 2);
    assert_true(live_number(&c, "render.set", json_pack("{s:i}", "threads", 1), "generation") == 3);
    assert_true(live_number(&c, "status", NULL, "threads") == 1);
    live_wait(&c, "complete");
    /* while nothing is near this target */
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:f}", "target_error", 1e-12)), 0);
    while (seconds_left(&c) <= 0)
        live_nap(10);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    double passes = -1;
    for (int i = 0; i < 500 && strcmp(live_status_text(&c, "state"), "paused") != 0; i++)
        live_nap(10);
    assert_true(seconds_left(&c) < 0);
    passes = live_number(&c, "status", NULL, "passes");
    live_nap(200);
    assert_true(live_number(&c, "status", NULL, "passes") == passes);
    assert_int_equal(
        live_code(&c, "render.set", json_pack("{s:b, s:f}", "paused", 0, "target_error", 0.05)), 0);
    live_wait(&c, "converged");
    assert_string_equal(live_status_text(&c, "state"), "converged");
    assert_true(seconds_left(&c) == 0);
    live_close(&c);
    live_finish(&l);
}

static void subscribers_hear_what_they_asked_for(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--target-error", "0.05", NULL);
    live_client c, other;
    live_connect(&l, &c);
    live_connect(&l, &other);
    live_wait(&other, "coarse");
    json_t *events = json_loads("[\"scene\",\"converged\",\"device\",\"frame\"]", 0, NULL);
    assert_int_equal(live_code(&c, "subscribe", json_pack("{s:o}", "events", events)), 0);
    assert_int_equal(live_code(&other, "camera.orbit", json_pack("{s:i}", "yaw", 3)), 0);
    assert_int_equal(live_code(&other, "device.set", json_pack("{s:s}", "spec", l.sim)), 0);
    bool scene = false, converged = false, device = false, frame = false;
    while (!(scene && converged && device && frame)) {
        json_t *message = live_receive(&c);
        assert_non_null(message);
        const char *method = json_string_value(json_object_get(message, "method"));
        assert_non_null(method);
        scene = scene || strcmp(method, "scene") == 0;
        converged = converged || strcmp(method, "converged") == 0;
        device = device || strcmp(method, "device") == 0;
        frame = frame || strcmp(method, "frame") == 0;
        json_decref(message);
    }
    live_close(&c);
    live_close(&other);
    live_finish(&l);
}

/* Waits until the scene shown is the file of this name. */
static void await_scene(live_client *c, const char *name)
{
    for (int i = 0; i < 1000; i++) {
        const char *slash = strrchr(live_status_text(c, "scene"), '/');
        if (slash && strcmp(slash + 1, name) == 0)
            return;
        live_nap(10);
    }
    fail_msg("%s is not shown", name);
}

static double camera_x(live_client *c)
{
    json_t *answer = live_call(c, "scene.get", NULL);
    json_t *camera =
        json_object_get(json_object_get(json_object_get(answer, "result"), "scene"), "camera");
    double x = json_number_value(json_array_get(json_object_get(camera, "position"), 0));
    json_decref(answer);
    return x;
}

static void buttons_turn_pages_stop_rendering_and_reset_the_camera(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/gas.json", LIVE_SCENE);
    live_start(&l, l.scene, "--device", l.sim, "--buttons", "left=next", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "right")), 0);
    await_scene(&c, "gas.json");
    assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "left")), 0);
    await_scene(&c, "fog.json");
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 30)), 0);
    assert_true(fabs(camera_x(&c)) > 1);
    assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "circle")), 0);
    for (int i = 0; i < 1000 && camera_x(&c) != 0; i++)
        live_nap(10);
    assert_true(camera_x(&c) == 0);
    assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "square")), 0);
    for (int i = 0; i < 500 && strcmp(live_status_text(&c, "state"), "paused") != 0; i++)
        live_nap(10);
    assert_string_equal(live_status_text(&c, "state"), "paused");
    assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "top")), -32602);
    live_close(&c);
    live_finish(&l);
}

/* Waits until nothing is loaded any more. A load that has ended is not counted, and what follows
 * from it begins only when the event thread hears of it, which it does between two answers: several
 * in a row tell. */
static void await_rest(live_client *c)
{
    for (int calm = 0; calm < 5;) {
        calm = live_number(c, "status", NULL, "loading") > 0 ? 0 : calm + 1;
        live_nap(10);
    }
}

static void whoever_presses_faster_than_scenes_load_gets_to_the_last_one(void **state)
{
    (void)state;
    enum { PRESSES = 101 };
    live l;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/gas.json", LIVE_SCENE);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (int i = 0; i < PRESSES; i++)
        assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "right")), 0);
    await_rest(&c);
    assert_string_equal(strrchr(live_status_text(&c, "scene"), '/'), "/gas.json");
    assert_true(live_number(&c, "status", NULL, "generation") < PRESSES);
    live_close(&c);
    live_finish(&l);
}

static void a_camera_that_is_reset_again_and_again_is_reset_last(void **state)
{
    (void)state;
    enum { PRESSES = 100 };
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (int i = 0; i < PRESSES; i++)
        assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "circle")), 0);
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 30)), 0);
    assert_int_equal(live_code(&c, "button", json_pack("{s:s}", "name", "circle")), 0);
    await_rest(&c);
    assert_true(camera_x(&c) == 0);
    assert_true(live_number(&c, "status", NULL, "generation") < PRESSES);
    live_close(&c);
    live_finish(&l);
}

static bool panel_is_there(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL);
    bool there = json_is_true(
        json_object_get(json_object_get(json_object_get(answer, "result"), "device"), "present"));
    json_decref(answer);
    return there;
}

static void a_refused_device_forgets_no_panel_that_is_unplugged(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char spec[PATH_MAX];
    snprintf(spec, sizeof spec, "%s,unplug=1,replug=1500", l.sim);
    live_start(&l, l.scene, "--device", spec, NULL);
    live_client c;
    live_connect(&l, &c);
    for (int i = 0; i < 3000 && panel_is_there(&c); i++)
        live_nap(10);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", "foo:bar")), -32602);
    /* once: a push may have unplugged it again by the next look */
    bool there = false;
    for (int i = 0; i < 3000 && !(there = panel_is_there(&c)); i++)
        live_nap(10);
    assert_true(there);
    live_close(&c);
    live_finish(&l);
}

static void texts_that_are_not_utf8_and_large_seeds_are_told_whole(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char name[PATH_MAX];
    snprintf(name, sizeof name, "%s", lf_test_write(l.folder, "scene/f\xff.json", LIVE_SCENE));
    lf_test_write(l.folder, "scene/bad_qs3x2a0.75.png", "no picture");
    live_start(&l, name, "--device", "none", "--seed", "18446744073709551615", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_non_null(strstr(live_status_text(&c, "scene"), "\\xff.json"));
    assert_string_equal(live_status_text(&c, "seed"), "18446744073709551615");
    /* What is named as a quilt is judged as one. */
    json_t *answer = live_call(&c, "scene.load", json_pack("{s:s}", "file", "bad_qs3x2a0.75.png"));
    const json_t *error = json_object_get(answer, "error");
    assert_int_equal(json_integer_value(json_object_get(error, "code")), -32002);
    assert_null(strstr(json_string_value(json_object_get(error, "message")), "JSON"));
    json_decref(answer);
    live_close(&c);
    live_finish(&l);
}

static void a_panel_that_stalls_for_ever_stops_neither_rendering_nor_the_end(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char spec[PATH_MAX];
    snprintf(spec, sizeof spec, "%s,stall=1", l.sim);
    live_start(&l, l.scene, "--device", spec, NULL);
    live_client c;
    live_connect(&l, &c);
    for (int i = 0; i < 5; i++)
        assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    while (live_number(&c, "status", NULL, "passes") < 10)
        live_nap(20);
    assert_true(live_number(&c, "status", NULL, "updates") == 0);
    live_close(&c);
    live_finish(&l);
}

static double wait_for_generation(live_client *c, double generation)
{
    for (int i = 0;
         i < LIVE_PATIENCE_S * 50 && live_number(c, "status", NULL, "generation") < generation; i++)
        live_nap(20);
    return live_number(c, "status", NULL, "generation");
}

static void the_scene_file_is_read_again_on_hangup_and_when_it_changes(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--watch", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(live_code(&c, "camera.set", json_pack("{s:i}", "views", 9)), 0);
    kill(l.pid, SIGHUP);
    assert_true(wait_for_generation(&c, 3) == 3);
    assert_true(live_number(&c, "status", NULL, "views") == 6);
    lf_test_write(l.folder, "scene/next.json", LIVE_SCENE);
    char next[PATH_MAX];
    snprintf(next, sizeof next, "%s/scene/next.json", l.folder);
    assert_int_equal(rename(next, l.scene), 0);
    assert_true(wait_for_generation(&c, 4) == 4);
    lf_test_write(l.folder, "scene/fog.json", "{\"quiltd\":1,");
    live_await_logged(&l, "fog.json:1");
    assert_true(live_number(&c, "status", NULL, "generation") == 4);
    assert_string_not_equal(live_status_text(&c, "state"), "error");
    live_close(&c);
    live_finish(&l);
}

static void wait_for_views(live_client *c, double n_views)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && live_number(c, "status", NULL, "views") != n_views;
         i++)
        live_nap(20);
    assert_true(live_number(c, "status", NULL, "views") == n_views);
}

static void a_scene_is_read_again_when_what_it_includes_changes(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    mkdir(lf_test_path(l.folder, "scene/parts"), 0700);
    lf_test_write(l.folder, "scene/parts/base.json", "{\"camera\": {\"views\": 4}}");
    lf_test_write(l.folder, "scene/parts/other.json", "{\"camera\": {\"views\": 8}}");
    lf_test_write(l.folder, "scene/fog.json", "{\"include\": \"parts/base.json\"}");
    live_start(&l, l.scene, "--device", "none", "--watch", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    wait_for_views(&c, 4);
    lf_test_write(l.folder, "scene/parts/base.json", "{\"camera\": {\"views\": 7}}");
    wait_for_views(&c, 7);
    lf_test_write(l.folder, "scene/fog.json", "{\"include\": \"parts/other.json\"}");
    wait_for_views(&c, 8);
    lf_test_write(l.folder, "scene/parts/other.json", "{\"camera\": {\"views\": 5}}");
    wait_for_views(&c, 5);
    live_close(&c);
    live_finish(&l);
}

static void what_is_neither_scene_nor_picture_is_refused(void **state)
{
    static const char *const wrong[][2] = {{".", "the folder has no images"},
                                           {"notes.txt", "expected a scene"},
                                           {"empty.json", "expected a scene"},
                                           {"broken.json", "expected near"}};
    (void)state;
    live l;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/notes.txt", "remember the milk");
    lf_test_write(l.folder, "scene/empty.json", "");
    lf_test_write(l.folder, "scene/broken.json", "{\"quiltd\":1,");
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        json_t *answer = live_call(&c, "scene.load", json_pack("{s:s}", "file", wrong[i][0]));
        const char *message =
            json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
        if (!message || !strstr(message, wrong[i][1]))
            fail_msg("%s: \"%s\"", wrong[i][0], message ? message : "taken");
        json_decref(answer);
    }
    assert_true(live_number(&c, "status", NULL, "generation") == 1);
    live_close(&c);
    live_finish(&l);
}

static void a_scene_that_cannot_be_loaded_does_not_end_the_daemon(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char bad[PATH_MAX];
    snprintf(bad, sizeof bad, "%s",
             lf_test_write(l.folder, "scene/bad.json", "{\"quiltd\":1,\"camera\":{\"views\":-3}}"));
    live_start(&l, bad, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    for (int i = 0; i < 500 && strcmp(live_status_text(&c, "state"), "error") != 0; i++)
        live_nap(20);
    assert_string_equal(live_status_text(&c, "state"), "error");
    assert_int_equal(live_code(&c, "camera.orbit", NULL), -32000);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", l.scene)), 0);
    live_wait(&c, "coarse");
    assert_string_not_equal(live_status_text(&c, "state"), "error");
    live_close(&c);
    live_finish(&l);
}

static void what_a_scene_names_elsewhere_needs_a_word_of_the_owner(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char named[PATH_MAX];
    assert_int_equal(mkdir(lf_test_path(l.folder, "away"), 0700), 0);
    lf_test_write(l.folder, "away/wall.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    snprintf(named, sizeof named, "%s",
             lf_test_write(l.folder, "scene/named.json",
                           "{\"quiltd\":1,\"camera\":{\"target\":[0,0,0],\"position\":[0,0,5]},"
                           "\"meshes\":{\"wall\":{\"file\":\"../away/wall.obj\",\"material\":"
                           "\"clay\"}},\"materials\":{\"clay\":{\"type\":\"diffuse\"}}}"));
    live_start(&l, named, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    while (strcmp(live_status_text(&c, "state"), "error") != 0)
        live_nap(10);
    assert_true(live_logged(&l, "away/wall.obj"));
    assert_true(live_logged(&l, "start quiltd with --allow-path DIR"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_start(&l, named, "--device", "none", "--allow-path", lf_test_path(l.folder, "away"), NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_becomes_complete_on_the_panel),
        cmocka_unit_test(every_move_is_a_new_generation_that_is_shown),
        cmocka_unit_test(a_bad_patch_says_where_and_leaves_the_picture),
        cmocka_unit_test(how_to_render_can_be_changed),
        cmocka_unit_test(subscribers_hear_what_they_asked_for),
        cmocka_unit_test(buttons_turn_pages_stop_rendering_and_reset_the_camera),
        cmocka_unit_test(whoever_presses_faster_than_scenes_load_gets_to_the_last_one),
        cmocka_unit_test(a_camera_that_is_reset_again_and_again_is_reset_last),
        cmocka_unit_test(a_refused_device_forgets_no_panel_that_is_unplugged),
        cmocka_unit_test(texts_that_are_not_utf8_and_large_seeds_are_told_whole),
        cmocka_unit_test(a_panel_that_stalls_for_ever_stops_neither_rendering_nor_the_end),
        cmocka_unit_test(the_scene_file_is_read_again_on_hangup_and_when_it_changes),
        cmocka_unit_test(a_scene_is_read_again_when_what_it_includes_changes),
        cmocka_unit_test(what_is_neither_scene_nor_picture_is_refused),
        cmocka_unit_test(a_scene_that_cannot_be_loaded_does_not_end_the_daemon),
        cmocka_unit_test(what_a_scene_names_elsewhere_needs_a_word_of_the_owner),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
