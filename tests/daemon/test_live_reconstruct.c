/* What a panel shows while the picture is reconstructed, against the same film from outside: an
 * export of it, by a fit of its own. */
#include "tests/daemon/live_panel.h"
#include "tests/daemon/written.h"

#define ON "on_qs3x2a0.75.png"
#define OFF "off_qs3x2a0.75.png"
#define USUAL "usual_qs3x2a0.75.png"

static void export_quilt(live_client *c, const char *file, const char *word)
{
    json_t *params = json_pack("{s:s, s:s, s:b, s:s*}", "kind", "quilt", "file", file, "overwrite",
                               1, "reconstruct", word);
    assert_string_equal(live_job_end(c, (json_int_t)live_number(c, "export", params, "job")),
                        "done");
}

static void export_three(live_client *c)
{
    export_quilt(c, ON, "on");
    export_quilt(c, OFF, "off");
    export_quilt(c, USUAL, NULL);
}

static const char *exported(const live *l, const char *file)
{
    return lf_test_path(l->exports, file);
}

/* Whether the panel shows that picture; level NULL: at any level. */
static bool shows(live_client *c, const char *picture, const char *level)
{
    json_t *answer = live_call(c, "status", NULL);
    const char *shown = NULL, *at = NULL;
    assert_int_equal(json_unpack(answer, "{s:{s:{s:s, s:s}}}", "result", "shown", "picture", &shown,
                                 "level", &at),
                     0);
    const bool same = strcmp(shown, picture) == 0 && (!level || strcmp(at, level) == 0);
    json_decref(answer);
    return same;
}

static void assert_shows(live_client *c, const char *picture)
{
    assert_true(shows(c, picture, NULL));
    assert_string_equal(live_status_text(c, "reconstruct"),
                        strcmp(picture, "unfiltered") == 0 ? "off" : "on");
}

/* "wait" would also end by what was shown before. */
static void wait_for_shown(live_client *c, const char *picture, const char *level)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 100 && !shows(c, picture, level); i++)
        live_nap(10);
    assert_shows(c, picture);
}

/* -1: not known, because a half has not seen all of it, or nothing is reconstructed. */
static double shown_error(live_client *c, const char *key)
{
    json_t *answer = live_call(c, "status", NULL);
    const json_t *error = json_object_get(json_object_get(answer, "result"), key);
    assert_non_null(error);
    double x = json_is_number(error) ? json_number_value(error) : -1.0;
    json_decref(answer);
    return x;
}

static void turn(live_client *c, const char *word)
{
    assert_int_equal(live_code(c, "render.set", json_pack("{s:s}", "reconstruct", word)), 0);
}

/* A complete picture that stands still: what is exported is what is shown. */
static void begin(live *l, live_client *c, const char *word)
{
    live_prepare(l);
    live_start(l, l->scene, "--device", l->sim, "--reconstruct", word, NULL);
    live_connect(l, c);
    live_wait(c, "complete");
}

/* The last frame is made before a second export is taken. */
static void pause_it(live_client *c)
{
    assert_int_equal(live_code(c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    while (strcmp(live_status_text(c, "state"), "paused") != 0)
        live_nap(10);
    for (int i = 0; i < 2; i++)
        export_quilt(c, USUAL, NULL);
}

/* Also after a move of the camera: nothing of the fit before is left. */
static void the_panel_shows_the_reconstruction_of_the_film(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c, "auto");
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 20)), 0);
    live_wait(&c, "complete");
    while (shown_error(&c, "shown_error") < 0.0)
        live_nap(10);
    pause_it(&c);
    double error = shown_error(&c, "shown_error");
    assert_true(error > 0.0 && error < shown_error(&c, "shown_error_bound"));
    assert_true(error < shown_error(&c, "error_estimate"));
    export_three(&c);
    assert_shows(&c, "reconstructed");
    live_wait_for_panel(&l, exported(&l, ON));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(live_panel_differences(&l, exported(&l, ON)), 0);
    assert_true(live_panel_differences(&l, exported(&l, OFF)) > 1000);
    assert_int_equal(live_panel_differences(&l, exported(&l, USUAL)), 0);
    live_finish(&l);
}

/* key NULL: nothing is said of it. */
static void assert_saved(const live *l, live_client *c, const char *kind, const char *file,
                         const char *key, const char *word, const char *looked_at, bool expected)
{
    json_t *params = json_pack("{s:s, s:s, s:b}", "kind", kind, "file", file, "overwrite", 1);
    if (key)
        json_object_set_new(params, key, json_string(word));
    if (strcmp(kind, "print") == 0)
        json_object_update_new(params, json_pack("{s:i, s:i, s:i, s:i, s:i}", "lpi", 20, "dpi", 100,
                                                 "width", 9, "height", 12, "views", 2));
    print_message("%s %s %s\n", kind, file, key ? key : "");
    assert_string_equal(live_job_end(c, (json_int_t)live_number(c, "export", params, "job")),
                        "done");
    assert_int_equal(written_reconstructed(exported(l, looked_at)), expected);
}

static void what_is_shown_is_what_is_saved(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c, "auto");
    pause_it(&c);
    export_quilt(&c, ON, "on");
    live_wait_for_panel(&l, exported(&l, ON));
    static const struct {
        const char *kind, *file, *key, *word, *looked_at;
        bool expected;
    } all[] = {{"panel", "p.png", NULL, NULL, "p.png", true},
               {"pictures", "v/", NULL, NULL, "v/view_000.png", true},
               {"rgbd", "d.png", NULL, NULL, "d.png", true},
               {"print", "s.tif", NULL, NULL, "s.json", true},
               {"quilt", USUAL, NULL, NULL, USUAL, true},
               {"quilt", USUAL, "denoise", "off", USUAL, false},
               {"quilt", USUAL, "denoise", "on", USUAL, true},
               /* light is for measurements */
               {"views", "e/", NULL, NULL, "e/view_000.exr", false},
               {"quilt", "q_qs3x2a0.75.exr", NULL, NULL, "q_qs3x2a0.75.exr", false},
               {"quilt", "q_qs3x2a0.75.exr", "reconstruct", "on", "q_qs3x2a0.75.exr", true}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        assert_saved(&l, &c, all[i].kind, all[i].file, all[i].key, all[i].word, all[i].looked_at,
                     all[i].expected);
    assert_int_equal(live_code(&c, "export",
                               json_pack("{s:s, s:s, s:s, s:s}", "kind", "quilt", "file", "b.png",
                                         "reconstruct", "on", "denoise", "off")),
                     -32602);
    assert_int_equal(
        live_code(&c, "render.set", json_pack("{s:s, s:s}", "reconstruct", "on", "denoise", "off")),
        -32602);
    assert_int_equal(written_difference(l.panel, exported(&l, "p.png")), 0);
    /* unfiltered, where that is what is shown */
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "denoise", "off")), 0);
    assert_saved(&l, &c, "quilt", USUAL, NULL, NULL, USUAL, false);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

/* `denoise` is a setting, which does not wait for an image. */
static void it_is_on_before_the_first_frame(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c, "auto");
    wait_for_shown(&c, "reconstructed", NULL);
    pause_it(&c);
    live_number(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5), "generation");
    assert_true(live_number(&c, "status", NULL, "passes") == 0.0);
    assert_string_equal(live_status_text(&c, "denoise"), "on");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_finish(&l);
}

static void it_is_switched_off_and_on_at_once(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        live l;
        live_client c;
        begin(&l, &c, "auto");
        turn(&c, "off");
        if (i > 0)
            turn(&c, "on");
        assert_int_equal(live_number(&c, "status", NULL, "generation"), 1);
        /* what an unfiltered picture lacks is found first */
        wait_for_shown(&c, i > 0 ? "reconstructed" : "unfiltered", "complete");
        pause_it(&c);
        export_three(&c);
        assert_shows(&c, i > 0 ? "reconstructed" : "unfiltered");
        assert_true(i > 0 || shown_error(&c, "shown_error") < 0.0);
        live_wait_for_panel(&l, exported(&l, i > 0 ? ON : OFF));
        live_close(&c);
        assert_int_equal(live_stop(&l), 0);
        assert_int_equal(live_panel_differences(&l, exported(&l, i > 0 ? ON : OFF)), 0);
        assert_true(live_panel_differences(&l, exported(&l, i > 0 ? OFF : ON)) > 1000);
        /* who says on gets files of it too */
        assert_int_equal(live_panel_differences(&l, exported(&l, USUAL)), 0);
        live_finish(&l);
    }
}

static void begun_without_it_starts_over(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c, "off");
    assert_shows(&c, "unfiltered");
    json_t *params =
        json_pack("{s:s, s:s, s:s}", "kind", "quilt", "file", "q.png", "reconstruct", "on");
    json_int_t job = (json_int_t)live_number(&c, "export", params, "job");
    assert_string_equal(live_job_end(&c, job), "failed");
    /* nor has it depth */
    params = json_pack("{s:s, s:s}", "kind", "rgbd", "file", "d.png");
    job = (json_int_t)live_number(&c, "export", params, "job");
    assert_string_equal(live_job_end(&c, job), "failed");
    turn(&c, "auto");
    assert_int_equal(live_number(&c, "status", NULL, "generation"), 2);
    live_wait(&c, "complete");
    pause_it(&c);
    export_quilt(&c, ON, "on");
    assert_shows(&c, "reconstructed");
    live_wait_for_panel(&l, exported(&l, ON));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(live_panel_differences(&l, exported(&l, ON)), 0);
    live_finish(&l);
}

/* mis and cv were asked for because they are unbiased. */
static void another_estimator_is_shown_as_it_is(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin(&l, &c, "auto");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:s}", "estimator", "cv")), 0);
    pause_it(&c);
    export_quilt(&c, USUAL, NULL); /* the controls are in force */
    assert_shows(&c, "unfiltered");
    turn(&c, "on");
    export_quilt(&c, ON, NULL);
    for (int i = 0; strcmp(live_status_text(&c, "reconstruct"), "on") != 0; i++) {
        assert_true(i < 6000);
        live_nap(100);
    }
    live_close(&c);
    live_finish(&l);
}

static void a_state_without_features_is_not_gone_on_with(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    static const char *const words[] = {"off", "auto", "auto"};
    for (int i = 0; i < 3; i++) {
        live_start(&l, l.scene, "--device", l.sim, "--state", l.state, "--reconstruct", words[i],
                   NULL);
        live_connect(&l, &c);
        live_wait(&c, "complete");
        assert_int_equal(
            live_logged(
                &l, "from the beginning; the newest saved state differs in the render settings"),
            i > 0);
        assert_int_equal(live_logged(&l, "continuing from the saved state"), i > 1);
        live_close(&c);
        assert_int_equal(live_stop(&l), 0);
    }
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_panel_shows_the_reconstruction_of_the_film),
        cmocka_unit_test(what_is_shown_is_what_is_saved),
        cmocka_unit_test(it_is_on_before_the_first_frame),
        cmocka_unit_test(it_is_switched_off_and_on_at_once),
        cmocka_unit_test(begun_without_it_starts_over),
        cmocka_unit_test(another_estimator_is_shown_as_it_is),
        cmocka_unit_test(a_state_without_features_is_not_gone_on_with),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
