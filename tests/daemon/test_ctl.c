/* What quiltctl says to people: help of methods, the line of watch. */
#include "tests/daemon/live.h"

#include "daemon/server/methods.h"
#include "daemon/tools/ctl.h"

static const char *line_of(json_t *status)
{
    char *line = lf_test_buffer();
    lf_ctl_watch_line(status, line);
    json_decref(status);
    return line;
}

static json_t *rendering(const char *state, json_t *error, double target, json_t *left)
{
    return json_pack(
        "{s:s, s:s, s:b, s:f, s:f, s:o, s:f, s:o, s:n, s:{s:s, s:s}, s:{s:i, s:s}, s:i}", "state",
        state, "scene", "/a/fog.json", "is_quilt", 0, "seconds", 12.0, "passes", 34.0,
        "error_estimate", error, "target_error", target, "seconds_left", left, "load", "device",
        "kind", "sim", "problem", "", "shown", "generation", 3, "level", "complete", "generation",
        3);
}

static void the_line_of_watch_says_what_a_person_wants_to_know(void **state)
{
    (void)state;
    assert_string_equal(line_of(rendering("rendering", json_real(0.02), 0.01, json_real(11.7))),
                        "fog.json: rendering, 12 s, 34 passes, error 0.02, about 12 s left to "
                        "0.01; on the panel: complete");
    assert_string_equal(line_of(rendering("rendering", json_null(), 0.01, json_null())),
                        "fog.json: rendering, 12 s, 34 passes; on the panel: complete");
    assert_string_equal(line_of(rendering("paused", json_real(0.02), 0.01, json_null())),
                        "fog.json: paused, 12 s, 34 passes, error 0.02; on the panel: complete");
    assert_string_equal(line_of(rendering("converged", json_real(0.009), 0.01, json_integer(0))),
                        "fog.json: finished, 12 s, 34 passes, error 0.009; on the panel: complete");
    json_t *status = rendering("rendering", json_real(1), 1e-4, json_real(119880));
    json_object_set_new(status, "generation", json_integer(4));
    assert_string_equal(line_of(status), "fog.json: rendering, 12 s, 34 passes, error 1, about "
                                         "33.3 h left to 0.0001; not on the panel yet");
    status = rendering("converged", json_null(), 0.01, json_null());
    json_object_set_new(
        status, "playlist",
        json_pack("{s:i, s:i, s:b, s:b}", "index", 1, "entries", 5, "playing", 1, "paused", 1));
    assert_string_equal(line_of(status), "paused at entry 2 of 5, fog.json: finished, 12 s, 34 "
                                         "passes; on the panel: complete");
    assert_string_equal(line_of(json_pack("{s:s, s:n}", "state", "idle", "scene")), "no scene");
    assert_string_equal(line_of(json_pack("{s:s, s:{s:s}}", "state", "error", "error", "message",
                                          "fog.json:3: bad")),
                        "error: fog.json:3: bad");
    assert_string_equal(line_of(json_pack("{s:s, s:{s:s}, s:{s:s, s:i, s:f}}", "state", "idle",
                                          "load", "file", "/a/fog.json", "reading", "file",
                                          "/a/fog.vdb", "bytes", 2500000, "seconds", 120.0)),
                        "loading: reading fog.vdb (2.5 MB) for 2 min");
}

/* The screen of status, and its number of lines. */
static const char *screen_of(json_t *status, int *out_lines)
{
    char *text = lf_test_buffer();
    FILE *out = fmemopen(text, PATH_MAX, "w");
    assert_non_null(out);
    lf_ctl_print_status(status, out);
    fclose(out);
    json_decref(status);
    *out_lines = 0;
    for (const char *at = text; *at != '\0'; at++)
        *out_lines += *at == '\n';
    return text;
}

/* A status with every row of the screen, and so many warnings. */
static json_t *full_status(int n_warnings)
{
    json_t *status = json_loads(
        "{\"state\":\"rendering\",\"scene\":\"/a/"
        "fog.json\",\"is_quilt\":false,\"views\":45,\"columns\":5,"
        "\"rows\":9,\"view_width\":420,\"view_height\":560,\"cone\":35.0,\"denoise\":\"on\","
        "\"time\":{\"frame\":3,\"playing\":true,\"from\":1,\"to\":48,\"fps\":24.0},"
        "\"depth_budget\":{\"nearest\":10.5,\"farthest\":13.5,\"sharp_from\":8.0,\"sharp_to\":25.8}"
        ","
        "\"playlist\":{\"index\":1,\"entries\":5,\"playing\":true,\"paused\":true,"
        "\"file\":\"/a/b.png\"},\"seconds\":12.0,\"passes\":34."
        "2,"
        "\"spp\":102.0,\"error_estimate\":0.02,\"denoised_error\":0.01,\"target_error\":0.001,"
        "\"seconds_left\":240.0,\"load\":{\"file\":\"/a/b.json\"},"
        "\"reading\":{\"file\":\"/a/b.vdb\",\"bytes\":2500000,\"seconds\":3.0},"
        "\"jobs\":[{\"job\":7,\"kind\":\"quilt\",\"file\":\"/a/q.png\",\"state\":\"running\","
        "\"progress\":0.4},{}],\"generation\":2,"
        "\"shown\":{\"generation\":1,\"level\":\"complete\",\"card\":null},"
        "\"device\":{\"spec\":\"sim:/"
        "p\",\"kind\":\"sim\",\"model\":\"simulated\",\"serial\":\"L-1\","
        "\"problem\":\"unplugged\",\"present\":false},\"error\":{\"message\":\"b.json:3: bad\"}}",
        0, NULL);
    assert_non_null(status);
    json_t *warnings = json_array();
    for (int i = 0; i < n_warnings; i++)
        json_array_append_new(warnings, json_sprintf("left out\n%d", i));
    json_object_set_new(status, "warnings", warnings);
    return status;
}

static void status_is_one_screen(void **state)
{
    (void)state;
    int n;
    const char *text = screen_of(full_status(4), &n);
    assert_string_equal(text, "Shown\n"
                              "  scene      /a/fog.json\n"
                              "  views      45 of 420x560 pixels, 5x9 tiles, cone 35 degrees\n"
                              "  frame      3, playing 1 to 48 at 24 frames per second\n"
                              "  depth      objects from 10.5 to 13.5, sharp from 8 to 25.8\n"
                              "  slideshow  entry 2 of 5, b.png, paused\n"
                              "Progress\n"
                              "  state      rendering, denoised\n"
                              "  so far     12 s, 34.2 passes, 102 samples per pixel\n"
                              "  error      0.02, denoised 0.01, target 0.001\n"
                              "  time left  about 4 min\n"
                              "  loading    reading /a/b.vdb (2.5 MB) for 3 s\n"
                              "  export     7: quilt /a/q.png, running, 40 %; 1 more\n"
                              "Panel\n"
                              "  device     sim:/p: simulated, serial number L-1 (not open)\n"
                              "  shows      complete image of the scene before\n"
                              "Problems and warnings\n"
                              "  error      b.json:3: bad\n"
                              "  panel      unplugged\n"
                              "  warning    left out\\n0\n"
                              "  warning    left out\\n1\n"
                              "  warning    left out\\n2\n"
                              "  warning    left out\\n3\n");
    text = screen_of(full_status(40), &n);
    assert_true(n <= 24);
    assert_non_null(strstr(text, "left out\\n2\n  37 more; quiltctl status --all prints them\n"));
}

static void status_says_what_is_not_there(void **state)
{
    (void)state;
    int n;
    const char *text = screen_of(json_pack("{s:s, s:n, s:{s:s, s:s, s:b}, s:{s:s}}", "state",
                                           "idle", "scene", "device", "spec", "none", "kind",
                                           "none", "present", 1, "shown", "level", "none"),
                                 &n);
    assert_string_equal(text, "Shown\n"
                              "  scene      none; quiltctl scene.load file=PATH shows one\n"
                              "Progress\n"
                              "  state      idle, unfiltered\n"
                              "Panel\n"
                              "  device     none\n"
                              "Problems and warnings\n"
                              "  none\n");
    /* an older daemon, or another program */
    text = screen_of(json_object(), &n);
    assert_true(n <= 10);
    json_t *status = full_status(0);
    json_object_set_new(status, "error_estimate", json_null());
    json_object_set_new(json_object_get(status, "shown"), "level", json_string("none"));
    json_object_set_new(json_object_get(status, "depth_budget"), "sharp_to", json_null());
    text = screen_of(status, &n);
    assert_non_null(strstr(text, "  error      not known yet, target 0.001\n"));
    assert_null(strstr(text, "time left"));
    assert_non_null(strstr(text, "  shows      nothing yet\n"));
    assert_non_null(strstr(text, "sharp from 8 on\n"));
    /* a finished image */
    status = full_status(0);
    json_object_set_new(status, "is_quilt", json_true());
    json_object_set_new(json_object_get(status, "shown"), "card", json_string("Loading b.json"));
    text = screen_of(status, &n);
    assert_non_null(strstr(text, "  image      /a/fog.json\n"));
    assert_non_null(strstr(text, "  message    Loading b.json\n"));
    assert_null(strstr(text, "so far"));
}

/* The last line of doctor on a machine with so many calibrations that are wrong. */
static const char *end_of_doctor(int n_wrong)
{
    lf_found found[3] = {{.problem = ""}};
    const lf_error no_answer = {.what = "no quiltd answers"};
    char *text = lf_test_buffer();
    for (int i = 0; i < n_wrong; i++)
        snprintf(found[i].problem, sizeof found[i].problem, "is wrong; use another");
    FILE *out = fmemopen(text, PATH_MAX, "w");
    assert_non_null(out);
    assert_int_equal(lf_ctl_print_findings(&(lf_doctor_facts){.root = "/nowhere",
                                                              .no_answer = &no_answer,
                                                              .found = found,
                                                              .n_found = n_wrong},
                                           out),
                     n_wrong);
    fclose(out);
    text[strlen(text) - 1] = '\0';
    return strrchr(text, '\n') + 1;
}

static void doctor_ends_with_the_number_of_problems(void **state)
{
    (void)state;
    assert_string_equal(end_of_doctor(0), "no problem found");
    assert_string_equal(end_of_doctor(1), "1 problem found");
    assert_string_equal(end_of_doctor(3), "3 problems found");
}

/* stdout of quiltctl with these words. */
/* Until the next call. */
static const char *said(const char *words, int *out_code)
{
    static char text[1 << 14];
    char command[2 * PATH_MAX];
    snprintf(command, sizeof command, "%s %s 2>&1", lf_test_built("quiltctl"), words);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    text[fread(text, 1, sizeof text - 1, pipe)] = '\0';
    while (fgetc(pipe) != EOF)
        continue;
    *out_code = WEXITSTATUS(pclose(pipe));
    return text;
}

static void all_is_for_status_alone(void **state)
{
    (void)state;
    int code;
    const char *text = said("--socket /nowhere --all scene.get", &code);
    assert_int_equal(code, 2);
    assert_non_null(strstr(text, "--all: is only available for the method status"));
    (void)said("--socket /nowhere --all status", &code);
    assert_int_equal(code, 3);
}

static void a_method_has_help_without_a_daemon(void **state)
{
    (void)state;
    static const char *const words[] = {"Example: quiltctl wait ",
                                        "for=coarse|complete|converged",
                                        "(default coarse)",
                                        "timeout=NUMBER",
                                        "0.001 to 1e+09 seconds",
                                        "Answer:",
                                        "level",
                                        NULL};
    int code;
    const char *text = said("--socket /nowhere wait --help", &code);
    assert_int_equal(code, 0);
    for (int i = 0; words[i]; i++)
        if (!strstr(text, words[i]))
            fail_msg("\"%s\" is not in: %s", words[i], text);
    for (int i = 0; lf_method_at(i); i++) {
        char line[128];
        snprintf(line, sizeof line, "%s --help", lf_method_at(i)->name);
        text = said(line, &code);
        assert_int_equal(code, 0);
        if (!strstr(text, lf_method_at(i)->summary))
            fail_msg("%s: %s", line, text);
    }
    text = said("--help", &code);
    assert_non_null(strstr(text, "Usage:"));
    assert_non_null(strstr(text, "|pictures|"));
    assert_non_null(strstr(text, "--completion SHELL"));
}

static void hello_prints_the_words_that_are_allowed(void **state)
{
    (void)state;
    live l;
    char words[PATH_MAX];
    int code;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    snprintf(words, sizeof words, "--socket %s hello", l.socket);
    const char *text = said(words, &code);
    assert_int_equal(code, 0);
    assert_non_null(strstr(text, "for=coarse|complete|converged"));
    assert_non_null(strstr(text, "yaw=NUMBER  degrees"));
    assert_non_null(strstr(text, "target=X,Y,Z"));
    assert_null(strstr(text, "=..."));
    live_finish(&l);
}

static void watch_writes_a_line_where_stdout_is_no_terminal(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    char *args[] = {(char *)(uintptr_t)lf_test_built("quiltctl"), (char *)(uintptr_t) "--socket",
                    l.socket, (char *)(uintptr_t) "watch", NULL};
    const pid_t pid = live_spawn(&l, args);
    live_await_logged(&l, "fog.json: rendering");
    kill(pid, SIGINT);
    assert_int_equal(live_reap(pid), 0);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_line_of_watch_says_what_a_person_wants_to_know),
        cmocka_unit_test(status_is_one_screen),
        cmocka_unit_test(status_says_what_is_not_there),
        cmocka_unit_test(all_is_for_status_alone),
        cmocka_unit_test(doctor_ends_with_the_number_of_problems),
        cmocka_unit_test(a_method_has_help_without_a_daemon),
        cmocka_unit_test(hello_prints_the_words_that_are_allowed),
        cmocka_unit_test(watch_writes_a_line_where_stdout_is_no_terminal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
