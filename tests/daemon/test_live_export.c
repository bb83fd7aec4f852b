/* Files that the daemon writes on request, and the panel compared with them. */
#include "tests/daemon/live_panel.h"

static json_t *export_params(const char *kind, const char *file, bool overwrite)
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
    return params;
}

/* Starts an export by name; the error code, or 0 and how the job ended. */
static int export_to(live_client *c, const char *kind, const char *file, bool overwrite,
                     const char **out_end)
{
    json_t *answer = live_call(c, "export", export_params(kind, file, overwrite));
    int code = (int)json_integer_value(json_object_get(json_object_get(answer, "error"), "code"));
    json_int_t job = json_integer_value(json_object_get(json_object_get(answer, "result"), "job"));
    json_decref(answer);
    *out_end = code == 0 ? live_job_end(c, job) : "refused";
    return code;
}

/* An export that fails once it runs tells the name that was asked for. */
static void assert_fails_at(live_client *c, const char *kind, const char *file, const char *path)
{
    json_t *error = NULL;
    json_int_t job = (json_int_t)live_number(c, "export", export_params(kind, file, false), "job");
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
    static const char *const kinds[][2] = {{"panel", "p.png"},
                                           {"still", "s.jpg"},
                                           {"state", "s.lfstate"},
                                           {"print", "t.tif"},
                                           {"chart", "c.tif"}};
    const char *end;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        assert_int_equal(export_to(&c, kinds[i][0], kinds[i][1], false, &end), 0);
        assert_string_equal(end, "done");
        assert_fails_at(&c, kinds[i][0], kinds[i][1], lf_test_path(l.exports, kinds[i][1]));
    }
    /* the manifest beside it */
    assert_int_equal(unlink(lf_test_path(l.exports, "t.tif")), 0);
    assert_fails_at(&c, "print", "t.tif", lf_test_path(l.exports, "t.json"));
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
    assert_refused(&c,
                   json_pack("{s:s, s:s, s:i, s:i, s:i, s:i}", "kind", "chart", "file", "c.tif",
                             "lpi", 30, "width", 60, "height", 40, "slant", 3),
                   "slant has no effect on a chart");
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
    static const char *const kinds[][3] = {
        {"quilt", "q.png", "q_qs"},  {"quilt", "f.exr", "f_qs"},
        {"views", "v/", "v"},        {"panel", "p.png", "p.png"},
        {"print", "t.tif", "t.tif"}, {"chart", "c.tif", "c.tif"},
        {"rgbd", "d.png", "d.png"},  {"state", "s.lfstate", "s.lfstate"}};
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

static void names_that_are_none_are_refused(void **state)
{
    (void)state;
    static const char *const names[][2] = {
        {"quilt", ".png"},         {"panel", ".png"},          {"panel", "d/.png"},
        {"panel", "..png"},        {"state", ".lfstate"},      {"panel", "x\ny.png"},
        {"state", "\x1b.lfstate"}, {"views", "v\x7f/"},        {"quilt", "x\xe2\x80\xa8.png"},
        {"chart", ".tif"},         {"quilt", "x\xc2\x85.png"},
    };
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(mkdir(lf_test_path(l.exports, "d"), 0700), 0);
    const char *end;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (export_to(&c, names[i][0], names[i][1], false, &end) != -32602)
            fail_msg("\"%s\" is %s", names[i][1], end);
    assert_int_equal(export_to(&c, "panel", ".hidden.png", false, &end), 0);
    assert_string_equal(end, "done");
    char spec[PATH_MAX];
    snprintf(spec, sizeof spec, "sim:%s/a\nb", l.exports);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), -32602);
    assert_int_not_equal(access(spec + strlen("sim:"), F_OK), 0);
    live_close(&c);
    live_finish(&l);
}

/* A refusal's words, of a name for each method; without the name. */
static void why_refused(live_client *c, const char *method, json_t *params, char *why, size_t size)
{
    json_t *answer = live_call(c, method, params);
    const json_t *error = json_object_get(answer, "error");
    const char *message = json_string_value(json_object_get(error, "message"));
    assert_int_equal(json_integer_value(json_object_get(error, "code")), -32001);
    snprintf(why, size, "%s", strchr(message, ' '));
    json_decref(answer);
}

static void what_is_outside_is_told_the_same_whether_it_exists(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    char why[2][512], name[PATH_MAX];
    static const char *const folders[] = {"sim", "absent"}; /* both outside of exports/ */
    for (int i = 0; i < 2; i++) {
        snprintf(name, sizeof name, "%s/%s/x.png", l.folder, folders[i]);
        why_refused(&c, "export", export_params("panel", name, false), why[i], sizeof *why);
    }
    assert_string_equal(why[0], why[1]);
    for (int i = 0; i < 2; i++) {
        snprintf(name, sizeof name, "sim:%s/%s/panel", l.folder, folders[i]);
        why_refused(&c, "device.set", json_pack("{s:s}", "spec", name), why[i], sizeof *why);
    }
    assert_string_equal(why[0], why[1]);
    for (int i = 0; i < 2; i++) {
        snprintf(name, sizeof name, "%s/%s/x.icc", l.folder, folders[i]);
        json_t *params = export_params("print", "t.tif", false);
        json_object_set_new(params, "icc", json_string(name));
        why_refused(&c, "export", params, why[i], sizeof *why);
    }
    assert_string_equal(why[0], why[1]);
    /* through a folder outside and back: no difference either */
    for (int i = 0; i < 2; i++) {
        const char *end;
        snprintf(name, sizeof name, "%s/%s/../exports/back%d.png", l.folder, folders[i], i);
        assert_int_equal(export_to(&c, "panel", name, false, &end), 0);
        assert_string_equal(end, "done");
        snprintf(name, sizeof name, "%s/%s/../scene/fog.json", l.folder, folders[i]);
        assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", name)), 0);
    }
    live_close(&c);
    live_finish(&l);
}

/* A line with a descriptor. */
static void send_with(const live_client *c, const char *line, int fd)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control = {.bytes = {0}};
    char *text = strdup(line);
    struct iovec vector = {.iov_base = text, .iov_len = strlen(line)};
    struct msghdr message = {.msg_iov = &vector,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    memcpy(CMSG_DATA(head), &fd, sizeof fd);
    assert_int_equal(sendmsg(c->fd, &message, MSG_NOSIGNAL), strlen(line));
    free(text);
}

static void answers_name_the_file_that_is_meant(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    /* by a name: the one that is on the disk then */
    json_t *answer =
        live_call(&c, "export", json_pack("{s:s, s:s}", "kind", "quilt", "file", "q.png"));
    const json_t *result = json_object_get(answer, "result");
    char file[PATH_MAX];
    snprintf(file, sizeof file, "%s", json_string_value(json_object_get(result, "file")));
    assert_non_null(strstr(file, "/exports/q_qs3x2a"));
    assert_string_equal(live_job_end(&c, json_integer_value(json_object_get(result, "job"))),
                        "done");
    assert_int_equal(access(file, F_OK), 0);
    json_decref(answer);
    /* by a descriptor */
    static const char *const kinds[][2] = {{"panel", "mine.png"}, {"state", "mine.lfstate"}};
    for (int i = 0; i < 2; i++) {
        char line[200];
        int fd = open(file, O_RDONLY | O_CLOEXEC);
        snprintf(line, sizeof line,
                 "{\"jsonrpc\":\"2.0\",\"id\":\"x\",\"method\":\"export\",\"params\":{\"kind\":"
                 "\"%s\",\"file\":\"%s\",\"fds\":1}}\n",
                 kinds[i][0], kinds[i][1]);
        send_with(&c, line, fd);
        close(fd);
        for (const char *told = NULL; !told;) {
            json_t *message = live_receive(&c);
            const json_t *params = json_object_get(message, "params");
            told = json_string_value(json_object_get(json_object_get(params, "error"), "message"));
            if (told) {
                assert_non_null(strstr(told, "expected a regular file that is open for writing"));
                assert_ptr_equal(strstr(told, kinds[i][1]), told);
            }
            json_decref(message);
        }
    }
    live_close(&c);
    live_finish(&l);
}

/* The answer and the end of an export say the same name, with descriptors too. */
static void a_passed_quilt_has_one_name(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    int fd = open(lf_test_path(l.exports, "passed"), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    assert_true(fd >= 0);
    send_with(&c,
              "{\"jsonrpc\":\"2.0\",\"id\":\"x\",\"method\":\"export\",\"params\":{\"kind\":"
              "\"quilt\",\"file\":\"mine.png\",\"fds\":1}}\n",
              fd);
    close(fd);
    char answered[PATH_MAX] = "", ended[PATH_MAX] = "";
    while (!answered[0] || !ended[0]) {
        json_t *message = live_receive(&c);
        const json_t *result = json_object_get(message, "result"),
                     *params = json_object_get(message, "params");
        const char *job = json_string_value(json_object_get(params, "state"));
        if (result)
            snprintf(answered, sizeof answered, "%s",
                     json_string_value(json_object_get(result, "file")));
        if (job && strcmp(job, "done") == 0)
            snprintf(ended, sizeof ended, "%s", json_string_value(json_object_get(params, "file")));
        json_decref(message);
    }
    assert_non_null(strstr(answered, "mine_qs"));
    assert_string_equal(answered, ended);
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

static void pause_it(live_client *c, int paused)
{
    assert_int_equal(live_code(c, "render.set", json_pack("{s:b}", "paused", paused)), 0);
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
        pause_it(&c, 0);
        assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
        live_wait(&c, "coarse");
        /* not on, to a complete one, while a slow disk takes its time */
        pause_it(&c, 1);
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

static bool device_problem_holds(live_client *c, const char *text)
{
    json_t *answer = live_call(c, "status", NULL);
    const char *problem = NULL;
    assert_int_equal(json_unpack(answer, "{s:{s:{s:s}}}", "result", "device", "problem", &problem),
                     0);
    bool holds = strstr(problem, text);
    json_decref(answer);
    return holds;
}

/* The panel is unplugged with its first update, and opened again by its name. */
static void a_panels_folder_that_is_swapped_is_not_opened_again(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    char folder[PATH_MAX], moved[PATH_MAX], away[PATH_MAX], spec[PATH_MAX];
    snprintf(folder, sizeof folder, "%s/p", l.exports);
    snprintf(moved, sizeof moved, "%s/moved", l.exports);
    snprintf(away, sizeof away, "%s/away", l.folder);
    snprintf(spec, sizeof spec, "sim:%s/p,unplug=1,replug=0,latency=200", l.exports);
    assert_int_equal(mkdir(away, 0700), 0);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), 0);
    assert_int_equal(rename(folder, moved), 0);
    assert_int_equal(symlink(away, folder), 0);
    for (int i = 0; !device_problem_holds(&c, "cannot open the folder"); i++) {
        assert_true(i < 600);
        live_nap(50);
    }
    assert_int_equal(access(lf_test_path(moved, ".unplugged"), F_OK), 0);
    assert_int_equal(rmdir(away), 0); /* nothing is in it */
    live_close(&c);
    live_finish(&l);
}

static void quiltctl_exports_with_the_rights_of_its_caller(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse"); /* before that there may be nothing to export yet */
    live_close(&c);
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

static void the_last_panel_is_the_exported_quilt_interlaced(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--reconstruct", "off", NULL);
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
    live_wait_for_panel(&l, find_quilt(l.exports, "late"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(live_panel_differences(&l, find_quilt(l.exports, "late")), 0);
    /* the comparison can fail */
    assert_true(live_panel_differences(&l, find_quilt(l.exports, "early")) > 0);
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
    live_wait_for_panel(&l, quilt);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(live_panel_differences(&l, quilt), 0);
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
        live_start(&l, l.scene, "--device", spec, "--reconstruct", "on", NULL);
        live_client c;
        live_connect(&l, &c);
        live_wait(&c, "complete");
        assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
        const char *end;
        assert_int_equal(export_to(&c, "quilt", "q.png", false, &end), 0);
        /* With every second push failing, the last one may still be on its way. */
        live_wait_for_panel(&l, find_quilt(l.exports, "q"));
        live_close(&c);
        assert_int_equal(live_stop(&l), 0);
        assert_int_equal(live_panel_differences(&l, find_quilt(l.exports, "q")), 0);
        live_finish(&l);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_export_that_fails_tells_the_name_asked_for),
        cmocka_unit_test(a_passed_quilt_has_one_name),
        cmocka_unit_test(a_print_and_a_chart_tell_what_they_need),
        cmocka_unit_test(exports_are_written_beneath_the_export_dir_only),
        cmocka_unit_test(names_that_are_none_are_refused),
        cmocka_unit_test(what_is_outside_is_told_the_same_whether_it_exists),
        cmocka_unit_test(answers_name_the_file_that_is_meant),
        cmocka_unit_test(an_export_of_a_coarse_picture_is_filled_as_the_screen_is),
        cmocka_unit_test(an_export_that_waits_can_be_cancelled),
        cmocka_unit_test(a_folder_that_is_swapped_leads_no_export_away),
        cmocka_unit_test(a_panels_folder_that_is_swapped_is_not_opened_again),
        cmocka_unit_test(quiltctl_exports_with_the_rights_of_its_caller),
        cmocka_unit_test(the_last_panel_is_the_exported_quilt_interlaced),
        cmocka_unit_test(a_quilt_picture_is_shown_as_it_is),
        cmocka_unit_test(a_panel_with_faults_shows_the_picture_in_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
