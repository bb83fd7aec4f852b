/* The daemon with a simulated panel, from outside: pictures that move, patches, exports, faults of
 * the panel, state. */
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
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    lf_image8 panel = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(l.panel, NULL, &panel, &err), &err);
    assert_int_equal(panel.width, 96);
    lf_image8_finish(&panel);
    assert_int_equal(access(lf_test_path(l.folder, "sim/quilt.png"), F_OK), 0);
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
    assert_true(live_number(&c, "status", NULL, "generation") == 1);
    assert_true(
        live_number(&c, "render.set", json_pack("{s:s}", "integrator", "vpt"), "generation") == 2);
    assert_true(live_number(&c, "render.set", json_pack("{s:i}", "threads", 1), "generation") == 3);
    assert_true(live_number(&c, "status", NULL, "threads") == 1);
    live_wait(&c, "complete");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    double passes = -1;
    for (int i = 0; i < 500 && strcmp(live_status_text(&c, "state"), "paused") != 0; i++)
        live_nap(10);
    passes = live_number(&c, "status", NULL, "passes");
    live_nap(200);
    assert_true(live_number(&c, "status", NULL, "passes") == passes);
    assert_int_equal(
        live_code(&c, "render.set", json_pack("{s:b, s:f}", "paused", 0, "target_error", 0.05)), 0);
    live_wait(&c, "converged");
    assert_string_equal(live_status_text(&c, "state"), "converged");
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
    lf_test_write(l.folder, "scene/gas.json", live_scene_text);
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
    lf_test_write(l.folder, "scene/gas.json", live_scene_text);
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
    for (int i = 0; i < 3000 && !panel_is_there(&c); i++)
        live_nap(10);
    assert_true(panel_is_there(&c));
    live_close(&c);
    live_finish(&l);
}

/* Starts an export by name; the error code, or 0 and how the job ended. */
static int export_to(live_client *c, const char *kind, const char *file, bool overwrite,
                     const char **out_end)
{
    json_t *params =
        json_pack("{s:s, s:s, s:b}", "kind", kind, "file", file, "overwrite", overwrite);
    if (strcmp(kind, "print") == 0) {
        json_object_update_new(params,
                               json_pack("{s:i, s:i, s:i, s:i, s:i, s:b}", "lpi", 60, "dpi", 300,
                                         "width", 20, "height", 20, "bleed", 1, "marks", true));
    } else if (strcmp(kind, "chart") == 0) {
        json_object_update_new(params,
                               json_pack("{s:i, s:f, s:f, s:i, s:i, s:i}", "lpi", 30, "range", 0.2,
                                         "step", 0.1, "dpi", 300, "width", 60, "height", 40));
    }
    json_t *answer = live_call(c, "export", params);
    int code = (int)json_integer_value(json_object_get(json_object_get(answer, "error"), "code"));
    json_int_t job = json_integer_value(json_object_get(json_object_get(answer, "result"), "job"));
    json_decref(answer);
    *out_end = code == 0 ? live_job_end(c, job) : "refused";
    return code;
}

/* An export that fails once it runs tells the name that was asked for. */
static void assert_fails_at(live_client *c, const char *kind, const char *file, const char *path)
{
    json_t *params = json_pack("{s:s, s:s}", "kind", kind, "file", file), *error = NULL;
    json_int_t job = (json_int_t)live_number(c, "export", params, "job");
    while (!error) {
        json_t *message = live_receive(c);
        assert_non_null(message);
        const json_t *told = json_object_get(message, "params");
        if (json_integer_value(json_object_get(told, "job")) == job)
            error = json_incref(json_object_get(told, "error"));
        json_decref(message);
    }
    const json_t *data = json_object_get(error, "data");
    assert_string_equal(json_string_value(json_object_get(data, "file")), path);
    json_decref(error);
}

static void an_export_that_fails_tells_the_name_asked_for(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    static const char *const kinds[][2] = {{"panel", "p.png"}, {"state", "s.lfstate"}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const char *end;
        assert_int_equal(export_to(&c, kinds[i][0], kinds[i][1], false, &end), 0);
        assert_string_equal(end, "done");
        assert_fails_at(&c, kinds[i][0], kinds[i][1], lf_test_path(l.exports, kinds[i][1]));
    }
    live_close(&c);
    live_finish(&l);
}

/* What an export is refused with. */
static void assert_refused(live_client *c, json_t *params, const char *why)
{
    json_t *answer = live_call(c, "export", params);
    const char *message =
        json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
    assert_non_null(message);
    if (!strstr(message, why))
        fail_msg("\"%s\" does not say \"%s\"", message, why);
    json_decref(answer);
}

static void a_print_and_a_chart_tell_what_they_need(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_refused(&c, json_pack("{s:s, s:s}", "kind", "print", "file", "t.tif"), "a print needs");
    assert_refused(&c, json_pack("{s:s, s:s}", "kind", "chart", "file", "c.tif"), "a chart needs");
    assert_refused(&c,
                   json_pack("{s:s, s:s, s:i, s:i, s:i}", "kind", "chart", "file", "c.tif", "lpi",
                             30, "width", 60, "height", 40),
                   "a chart needs range and step (lpi)");
    live_close(&c);
    live_finish(&l);
}

static void exports_are_written_beneath_the_export_dir_only(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    const char *end;
    char path[PATH_MAX];
    static const char *const kinds[][3] = {{"quilt", "q.png", "q_qs"},
                                           {"quilt", "f.exr", "f_qs"},
                                           {"views", "v/", "v"},
                                           {"panel", "p.png", "p.png"},
                                           {"print", "t.tif", "t.tif"},
                                           {"chart", "c.tif", "c.tif"},
                                           {"state", "s.lfstate", "s.lfstate"}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        assert_int_equal(export_to(&c, kinds[i][0], kinds[i][1], false, &end), 0);
        assert_string_equal(end, "done");
    }
    assert_int_equal(access(lf_test_path(l.exports, "v/view_004.exr"), F_OK), 0);
    assert_int_equal(access(lf_test_path(l.exports, "t.json"), F_OK), 0);
    /* Not over an existing file, unless asked. */
    int code = export_to(&c, "panel", "p.png", false, &end);
    assert_true(code != 0 || strcmp(end, "failed") == 0);
    assert_int_equal(export_to(&c, "panel", "p.png", true, &end), 0);
    assert_string_equal(end, "done");
    /* Not anywhere else. */
    snprintf(path, sizeof path, "%s/away.png", l.folder);
    assert_int_equal(export_to(&c, "panel", path, false, &end), -32001);
    assert_int_equal(export_to(&c, "panel", "../away.png", false, &end), -32001);
    assert_int_equal(export_to(&c, "panel", "/etc/away.png", false, &end), -32001);
    assert_int_equal(symlink(l.folder, lf_test_path(l.exports, "out")), 0);
    assert_int_equal(export_to(&c, "panel", "out/away.png", false, &end), -32001);
    assert_int_equal(symlink(path, lf_test_path(l.exports, "link.png")), 0);
    assert_int_equal(export_to(&c, "panel", "link.png", true, &end), -32001);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(export_to(&c, "views", "../", false, &end), -32001);
    /* Not with an unknown ending. */
    assert_int_equal(export_to(&c, "panel", "p.sh", false, &end), -32602);
    assert_int_equal(export_to(&c, "state", "s.png", false, &end), -32602);
    assert_int_equal(live_code(&c, "job.cancel", json_pack("{s:i}", "job", 999)), -32602);
    assert_int_equal(
        live_code(&c, "export",
                  json_pack("{s:s, s:s, s:i}", "kind", "panel", "file", "x.png", "fds", 1)),
        -32602);
    live_close(&c);
    live_finish(&l);
}

/* Share of the picture's pixels that are black. */
static double black(const char *path)
{
    lf_image8 picture = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(path, NULL, &picture, &err), &err);
    size_t n = (size_t)picture.width * (size_t)picture.height, dark = 0;
    for (int y = 0; y < picture.height; y++) {
        const uint8_t *p = picture.data + (size_t)y * picture.stride;
        for (int x = 0; x < picture.width; x++, p += 3)
            dark += (p[0] | p[1] | p[2]) == 0;
    }
    lf_image8_finish(&picture);
    return (double)dark / (double)n;
}

/* There is light everywhere in this scene, but rows that were not visited yet have none of their
 * own. */
static void an_export_of_a_coarse_picture_is_filled_as_the_screen_is(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--views", "45", "--view-size", "210x280", "--quilt",
               "5x9", NULL);
    live_client c;
    live_connect(&l, &c);
    const char *end = "";
    bool coarse = false;
    for (int i = 0; i < 50 && !coarse; i++) {
        assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
        live_wait(&c, "coarse");
        assert_int_equal(export_to(&c, "quilt", "q_qs5x9a0.75.png", true, &end), 0);
        assert_string_equal(end, "done");
        /* a picture that is coarse behind the export was so before */
        coarse = strcmp(live_status_text(&c, "level"), "coarse") == 0;
    }
    assert_true(coarse);
    assert_true(black(lf_test_path(l.exports, "q_qs5x9a0.75.png")) < 0.001);
    live_close(&c);
    live_finish(&l);
}

static void an_export_that_waits_can_be_cancelled(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    json_t *params =
        json_pack("{s:s, s:s, s:s}", "kind", "panel", "file", "p.png", "wait", "converged");
    json_int_t job = (json_int_t)live_number(&c, "export", params, "job");
    /* A picture that moves meanwhile is no better for it. */
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    json_t *status = live_call(&c, "status", NULL);
    const json_t *waiting =
        json_array_get(json_object_get(json_object_get(status, "result"), "jobs"), 0);
    assert_string_equal(json_string_value(json_object_get(waiting, "state")), "waiting");
    json_decref(status);
    assert_int_equal(live_code(&c, "job.cancel", json_pack("{s:I}", "job", job)), 0);
    assert_int_not_equal(access(lf_test_path(l.exports, "p.png"), F_OK), 0);
    live_close(&c);
    live_finish(&l);
}

static void a_folder_that_is_swapped_leads_no_export_away(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    char folder[PATH_MAX], moved[PATH_MAX], away[PATH_MAX];
    snprintf(folder, sizeof folder, "%s/d", l.exports);
    snprintf(moved, sizeof moved, "%s/moved", l.exports);
    snprintf(away, sizeof away, "%s/away", l.folder);
    assert_int_equal(mkdir(folder, 0700), 0);
    assert_int_equal(mkdir(away, 0700), 0);
    json_t *params =
        json_pack("{s:s, s:s, s:s}", "kind", "panel", "file", "d/p.png", "wait", "converged");
    json_int_t job = (json_int_t)live_number(&c, "export", params, "job");
    assert_int_equal(rename(folder, moved), 0);
    assert_int_equal(symlink(away, folder), 0);
    assert_int_equal(
        live_code(&c, "render.set", json_pack("{s:b, s:f}", "paused", 0, "target_error", 10.0)), 0);
    assert_string_equal(live_job_end(&c, job), "done");
    assert_int_equal(access(lf_test_path(moved, "p.png"), F_OK), 0);
    assert_int_not_equal(access(lf_test_path(away, "p.png"), F_OK), 0);
    live_close(&c);
    live_finish(&l);
}

static void quiltctl_exports_with_the_rights_of_its_caller(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    char out[PATH_MAX];
    static const char *const names[][2] = {{"panel", "p.png"},
                                           {"views", "v/"},
                                           {"print", "t.tif"},
                                           {"state", "s.lfstate"},
                                           {"quilt", "q.png"}};
    static const char *const made[] = {"p.png", "v/view_000.exr", "t.json", "s.lfstate",
                                       "q_qs1x5a0.75.png"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(out, sizeof out, "%s/%s", l.folder, names[i][1]);
        bool print = strcmp(names[i][0], "print") == 0;
        assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "export", names[i][0], out,
                                  print ? "lpi=60" : NULL, "width=20", "height=20", "dpi=300",
                                  NULL),
                         0);
        if (i < 4)
            assert_int_equal(access(lf_test_path(l.folder, made[i]), F_OK), 0);
    }
    snprintf(out, sizeof out, "%s/p.png", l.folder);
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "export", "panel", out, NULL),
                     1);
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "export", "panel", out,
                              "overwrite=true", NULL),
                     0);
    /* A refused print leaves nothing. */
    snprintf(out, sizeof out, "%s/bad.tif", l.folder);
    assert_int_equal(
        live_run(&l, "quiltctl", "--socket", l.socket, "export", "print", out, "lpi=60", NULL), 1);
    assert_int_not_equal(access(out, F_OK), 0);
    live_finish(&l);
}

/* The quilt that an export made, in this folder. */
static const char *find_quilt(const char *folder, const char *stem)
{
    for (int columns = 1; columns <= 5; columns++) {
        for (int rows = 1; rows <= 5; rows++) {
            char name[64];
            snprintf(name, sizeof name, "%s_qs%dx%da0.75.png", stem, columns, rows);
            const char *path = lf_test_path(folder, name);
            if (access(path, F_OK) == 0)
                return path;
        }
    }
    fail_msg("no quilt in %s", folder);
    return NULL;
}

/* How many bytes of the panel's last picture are not what interlacing the exported quilt gives. */
static long count_differences(const live *l, const char *quilt_path)
{
    lf_calibration calibration;
    lf_quilt_file quilt;
    lf_interlacer *interlacer;
    lf_image8 panel = {0}, expected = {0};
    lf_error err;
    lf_assert_ok(
        lf_calibration_load(lf_test_path(l->folder, "sim/calibration.json"), &calibration, &err),
        &err);
    lf_assert_ok(lf_quilt_read(quilt_path, NULL, 0, 0, &quilt, &err), &err);
    lf_assert_ok(lf_interlacer_create(&calibration, quilt.layout.n_views, quilt.layout.view_width,
                                      quilt.layout.view_height, quilt.layout.aspect,
                                      LF_FILTER_NEAREST, LF_INVERT_AUTO, &interlacer, &err),
                 &err);
    lf_assert_ok(lf_image8_init(&expected, 96, 128, 3), NULL);
    lf_interlace(interlacer, &quilt.views8, &expected, NULL);
    lf_assert_ok(lf_image8_read(l->panel, NULL, &panel, &err), &err);
    long differences = 0;
    for (int y = 0; y < 128; y++) {
        for (size_t i = 0; i < 96 * 3; i++) {
            differences += panel.data[(size_t)y * panel.stride + i] !=
                           expected.data[(size_t)y * expected.stride + i];
        }
    }
    lf_image8_finish(&panel);
    lf_image8_finish(&expected);
    lf_interlacer_destroy(interlacer);
    lf_quilt_finish(&quilt);
    return differences;
}

static void the_last_panel_is_the_exported_quilt_interlaced(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    const char *end;
    assert_int_equal(export_to(&c, "quilt", "early.png", false, &end), 0);
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 20)), 0);
    live_wait(&c, "complete");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    assert_int_equal(export_to(&c, "quilt", "late.png", false, &end), 0);
    assert_string_equal(end, "done");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(count_differences(&l, find_quilt(l.exports, "late")), 0);
    /* the comparison can fail */
    assert_true(count_differences(&l, find_quilt(l.exports, "early")) > 0);
    live_finish(&l);
}

static void a_quilt_picture_is_shown_as_it_is(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--allow-path", "/tmp", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    const char *end;
    assert_int_equal(export_to(&c, "quilt", "q.png", false, &end), 0);
    char quilt[PATH_MAX];
    snprintf(quilt, sizeof quilt, "%s", find_quilt(l.exports, "q"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_start(&l, quilt, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "converged");
    assert_string_equal(live_status_text(&c, "state"), "idle");
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), -32000);
    assert_int_equal(export_to(&c, "panel", "woven.png", false, &end), 0);
    assert_string_equal(end, "done");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(count_differences(&l, quilt), 0);
    live_finish(&l);
}

static void texts_that_are_not_utf8_and_large_seeds_are_told_whole(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char name[PATH_MAX];
    snprintf(name, sizeof name, "%s", lf_test_write(l.folder, "scene/f\xff.json", live_scene_text));
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

static void a_panel_with_faults_shows_the_picture_in_the_end(void **state)
{
    (void)state;
    static const char *const faults[] = {"error_every=2", "error=1", "stall=2:300", "latency=30",
                                         "unplug=2,replug=200"};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        live l;
        live_prepare(&l);
        char spec[PATH_MAX];
        snprintf(spec, sizeof spec, "%s,%s", l.sim, faults[i]);
        live_start(&l, l.scene, "--device", spec, NULL);
        live_client c;
        live_connect(&l, &c);
        live_wait(&c, "complete");
        assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
        const char *end;
        assert_int_equal(export_to(&c, "quilt", "q.png", false, &end), 0);
        /* With every second push failing, the last one may still be on its way. */
        live_nap(500);
        live_close(&c);
        assert_int_equal(live_stop(&l), 0);
        assert_int_equal(count_differences(&l, find_quilt(l.exports, "q")), 0);
        live_finish(&l);
    }
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

static void a_killed_daemon_goes_on_from_its_state(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    double passes = live_number(&c, "status", NULL, "passes");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(access(lf_test_path(l.state, "film.lfstate"), F_OK), 0);
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_true(live_logged(&l, "going on with the saved state"));
    assert_true(live_number(&c, "status", NULL, "passes") >= passes);
    live_close(&c);
    kill(l.pid, SIGKILL);
    live_reap(l.pid);
    /* A state of something else, or of nothing, is left aside. */
    lf_test_write(l.state, "film.lfstate", "no state at all");
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_true(live_logged(&l, "left aside"));
    live_close(&c);
    live_finish(&l);
}

static void the_batch_in_progress_ends_before_its_state_is_saved(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    static const char *const more[] = {"--view-size", "900x1200", "--threads", "1"};
    live_start(&l, l.scene, "--device", "none", "--state", l.state, more[0], more[1], more[2],
               more[3], NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    double passes = live_number(&c, "status", NULL, "passes");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(access(lf_test_path(l.state, "film.lfstate"), F_OK), 0);
    assert_false(live_logged(&l, "not saved"));
    live_start(&l, l.scene, "--device", "none", "--state", l.state, more[0], more[1], more[2],
               more[3], NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_true(live_logged(&l, "going on with the saved state"));
    assert_true(live_number(&c, "status", NULL, "passes") >= passes);
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
    lf_test_write(l.folder, "scene/next.json", live_scene_text);
    char next[PATH_MAX];
    snprintf(next, sizeof next, "%s/scene/next.json", l.folder);
    assert_int_equal(rename(next, l.scene), 0);
    assert_true(wait_for_generation(&c, 4) == 4);
    lf_test_write(l.folder, "scene/fog.json", "{\"quiltd\":1,");
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && !live_logged(&l, "fog.json:1"); i++)
        live_nap(20);
    assert_true(live_logged(&l, "fog.json:1"));
    assert_true(live_number(&c, "status", NULL, "generation") == 4);
    assert_string_not_equal(live_status_text(&c, "state"), "error");
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
        cmocka_unit_test(an_export_that_fails_tells_the_name_asked_for),
        cmocka_unit_test(a_print_and_a_chart_tell_what_they_need),
        cmocka_unit_test(exports_are_written_beneath_the_export_dir_only),
        cmocka_unit_test(an_export_of_a_coarse_picture_is_filled_as_the_screen_is),
        cmocka_unit_test(an_export_that_waits_can_be_cancelled),
        cmocka_unit_test(a_folder_that_is_swapped_leads_no_export_away),
        cmocka_unit_test(quiltctl_exports_with_the_rights_of_its_caller),
        cmocka_unit_test(the_last_panel_is_the_exported_quilt_interlaced),
        cmocka_unit_test(a_quilt_picture_is_shown_as_it_is),
        cmocka_unit_test(texts_that_are_not_utf8_and_large_seeds_are_told_whole),
        cmocka_unit_test(a_panel_with_faults_shows_the_picture_in_the_end),
        cmocka_unit_test(a_panel_that_stalls_for_ever_stops_neither_rendering_nor_the_end),
        cmocka_unit_test(a_killed_daemon_goes_on_from_its_state),
        cmocka_unit_test(the_batch_in_progress_ends_before_its_state_is_saved),
        cmocka_unit_test(the_scene_file_is_read_again_on_hangup_and_when_it_changes),
        cmocka_unit_test(a_scene_that_cannot_be_loaded_does_not_end_the_daemon),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
