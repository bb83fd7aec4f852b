/* Command lines, calls and scenes with the words of releases before 0.2 work as with the current
 * ones, in silence, and clients of those releases find the fields that they read. */
#include "base/former.h"
#include "base/version.h"
#include "tests/daemon/live.h"
#include "tests/daemon/quiltrender.h"

/* ----------------------------------------------------------------------------------- options -- */

#define LINE "%s -o %s/%s.png --quilt 3x2 --view-size 20x12 --passes 2 --overwrite %s"

static void assert_same_output(const qr_files *f, const char *former, const char *current)
{
    qr_outcome o;
    qr_run(&o, LINE, f->scene, f->folder, "former", former);
    if (o.code != 0 || (strstr(o.err, "former name") && !lf_former_is_logged(LF_VERSION)))
        fail_msg("%s: exit %d, %s", former, o.code, o.err);
    qr_succeed(LINE, f->scene, f->folder, "current", current);
}

static void former_options_do_what_the_current_ones_do(void **state)
{
    const qr_files *f = *state;
    assert_same_output(f, "--reconstruct on", "--denoise on");
    qr_assert_same_files(lf_test_path(f->folder, "former_qs3x2a0.75.png"),
                         lf_test_path(f->folder, "current_qs3x2a0.75.png"));
    assert_same_output(f, "--rgbd right --near-is black", "--rgbd right --depth-inversion on");
    qr_assert_same_files(lf_test_path(f->folder, "former.png"),
                         lf_test_path(f->folder, "current.png"));
}

static void a_former_target_is_a_target(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s -o %s/t.png --view-size 20x12 --reconstruct off --target-shown-error 0.5",
           f->scene, f->folder);
    qr_assert_fails(&o, 2, "--target-denoised-error");
}

static void help_names_current_options_alone(void **state)
{
    (void)state;
    qr_outcome o;
    qr_run(&o, "--help");
    assert_int_equal(o.code, 0);
    assert_null(strstr(o.out, "--reconstruct"));
    assert_null(strstr(o.out, "--target-shown-error"));
    assert_null(strstr(o.out, "--near-is"));
}

/* ----------------------------------------------------------------------------------- clients -- */

static json_t *status_of(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL),
           *status = json_incref(json_object_get(answer, "result"));
    json_decref(answer);
    return status;
}

static void assert_same_member(const json_t *object, const char *former, const char *current)
{
    const json_t *a = json_object_get(object, former), *b = json_object_get(object, current);
    if (!a || !b || !json_equal((json_t *)(uintptr_t)a, (json_t *)(uintptr_t)b))
        fail_msg("%s is not %s", former, current);
}

static void begin(live *l, live_client *c)
{
    live_prepare(l);
    live_start(l, l->scene, "--device", l->sim, "--reconstruct", "on", NULL);
    live_connect(l, c);
    live_wait(c, "complete");
}

static void end(live *l, live_client *c)
{
    live_close(c);
    live_finish(l);
}

static void status_has_former_fields_with_the_values_of_the_current_ones(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c);
    json_t *status = status_of(&c);
    assert_same_member(status, "shown_error", "denoised_error");
    assert_same_member(status, "shown_error_bound", "denoised_error_bound");
    assert_same_member(status, "reconstruct", "denoise");
    assert_string_equal(json_string_value(json_object_get(status, "reconstruct")), "on");
    const json_t *shown = json_object_get(status, "shown");
    assert_string_equal(json_string_value(json_object_get(shown, "image")), "denoised");
    assert_string_equal(json_string_value(json_object_get(shown, "picture")), "reconstructed");
    json_decref(status);
    end(&l, &c);
}

static void former_parameters_are_read(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "reconstruct", "off")), 0);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && strcmp(live_status_text(&c, "denoise"), "off"); i++)
        live_nap(20);
    assert_string_equal(live_status_text(&c, "denoise"), "off");
    assert_int_equal(live_code(&c, "scene.patch", json_pack("{s:{s:i}}", "patch", "rate", 12)), 0);
    json_t *answer = live_call(&c, "scene.get", NULL);
    const json_t *scene = json_object_get(json_object_get(answer, "result"), "scene");
    assert_int_equal(json_integer_value(json_object_get(scene, "fps")), 12);
    assert_null(json_object_get(scene, "rate"));
    json_decref(answer);
    end(&l, &c);
}

/* The member of the notification `frame`, of the time while it plays, and of a depth image. */
static void both_names_are_sent_and_taken_while_frames_play(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c);
    json_t *keyed = json_pack("{s:{s:{s:{s:[[i,i],[i,i]]}}}}", "patch", "camera", "fov_y", "keys",
                              1, 20, 9, 30);
    assert_int_equal(live_code(&c, "scene.patch", keyed), 0);
    static const char *const names[] = {"rate", "fps"};
    for (int i = 0; i < 2; i++) {
        json_t *answer = live_call(&c, "time.play", json_pack("{s:i, s:i}", "to", 9, names[i], 7));
        const json_t *time = json_object_get(answer, "result");
        assert_same_member(time, "rate", "fps");
        assert_true(json_number_value(json_object_get(time, "fps")) == 7.0);
        json_decref(answer);
        assert_int_equal(live_code(&c, "time.stop", NULL), 0);
    }
    json_t *answer = live_call(&c, "subscribe", json_pack("{s:[s]}", "events", "frame"));
    json_decref(answer);
    live_ask(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5));
    const json_t *image = NULL;
    for (json_t *message; !image && (message = live_receive(&c)); json_decref(message)) {
        const json_t *params = json_object_get(message, "params");
        image = json_object_get(params, "image");
        assert_true(!image || json_object_get(params, "picture"));
    }
    assert_non_null(image);
    end(&l, &c);
}

static void a_former_parameter_next_to_the_current_one_is_refused(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c);
    json_t *both = json_pack("{s:s, s:s}", "reconstruct", "off", "denoise", "on");
    assert_int_equal(live_code(&c, "render.set", both), -32602);
    assert_string_equal(live_status_text(&c, "denoise"), "on");
    end(&l, &c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(former_options_do_what_the_current_ones_do, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_former_target_is_a_target, qr_set_up, qr_tear_down),
        cmocka_unit_test(help_names_current_options_alone),
        cmocka_unit_test(status_has_former_fields_with_the_values_of_the_current_ones),
        cmocka_unit_test(former_parameters_are_read),
        cmocka_unit_test(both_names_are_sent_and_taken_while_frames_play),
        cmocka_unit_test(a_former_parameter_next_to_the_current_one_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
