/* Exports that a farm renders: a quiltd with a quiltfarm that is a script. */
#include "tests/daemon/live.h"

#include "tests/daemon/farm_script.h"

typedef struct farm {
    live l;
    live_client c;
    char path[2 * PATH_MAX];   /* $PATH as it was */
    char folder[PATH_MAX / 2]; /* of the script */
} farm;

/* A quiltd with a panel that may use slurm and list. */
static void begin(farm *f)
{
    snprintf(f->path, sizeof f->path, "%s", getenv("PATH"));
    live_prepare(&f->l);
    snprintf(f->folder, sizeof f->folder, "%s/farm", f->l.folder);
    assert_int_equal(mkdir(f->folder, 0700), 0);
    farm_prepare(f->folder);
    setenv("QUILTRENDER", lf_test_built("quiltrender"), 1);
}

static void start(farm *f)
{
    live_start(&f->l, f->l.scene, "--device", f->l.sim, "--farm", "slurm,list", "--state",
               f->l.state, NULL);
    live_connect(&f->l, &f->c);
    live_wait(&f->c, "coarse");
}

static void finish(farm *f)
{
    live_close(&f->c);
    live_finish(&f->l);
    setenv("PATH", f->path, 1);
}

static json_t *params_of(const char *kind, const char *file, const char *job)
{
    return json_pack("{s:s, s:s, s:s, s:s}", "kind", kind, "file", file, "farm", "slurm", "job",
                     job);
}

static json_int_t export(farm *f, json_t *params)
{
    return (json_int_t)live_number(&f->c, "export", params, "job");
}

/* The next notification of a job: a new reference. */
static json_t *next_of(live_client *c, json_int_t job)
{
    for (;;) {
        json_t *message = live_receive(c);
        assert_non_null(message);
        json_t *params = json_incref(json_object_get(message, "params"));
        json_decref(message);
        if (json_integer_value(json_object_get(params, "job")) == job)
            return params;
        json_decref(params);
    }
}

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* Waits until a job's farm has this state. */
static void await(farm *f, json_int_t job, const char *state)
{
    for (bool on = true; on;) {
        json_t *told = next_of(&f->c, job);
        assert_string_equal(text_of(told, "state"), "running");
        on = strcmp(text_of(json_object_get(told, "farm"), "state"), state) != 0;
        json_decref(told);
    }
}

/* Waits for the end of a job, which fails with words that have these. */
static void assert_fails(farm *f, json_int_t job, const char *words)
{
    json_t *told = next_of(&f->c, job);
    while (strcmp(text_of(told, "state"), "running") == 0) {
        json_decref(told);
        told = next_of(&f->c, job);
    }
    assert_string_equal(text_of(told, "state"), "failed");
    const char *said = text_of(json_object_get(told, "error"), "message");
    if (!strstr(said, words))
        fail_msg("\"%s\" does not say \"%s\"", said, words);
    json_decref(told);
}

/* The farm jobs of status. */
static json_t *jobs_of(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL);
    json_t *jobs = json_incref(json_object_get(json_object_get(answer, "result"), "jobs"));
    json_decref(answer);
    return jobs;
}

/* ---------------------------------------------------------------------------------- refusals -- */

static void assert_refused(farm *f, const char *words, int code, json_t *params)
{
    json_t *answer = live_call(&f->c, "export", params);
    const json_t *error = json_object_get(answer, "error");
    if (!strstr(text_of(error, "message"), words))
        fail_msg("\"%s\" does not say \"%s\"", text_of(error, "message"), words);
    assert_int_equal(json_integer_value(json_object_get(error, "code")), code);
    json_decref(answer);
}

static json_t *with(json_t *params, const char *key, json_t *value)
{
    json_object_set_new(params, key, value);
    return params;
}

static void wrong_calls_are_refused_before_anything_begins(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    start(&f);
    json_t *hello = live_call(&f.c, "hello", NULL), *farms = json_pack("[s, s]", "slurm", "list");
    assert_true(json_equal(json_object_get(json_object_get(hello, "result"), "farms"), farms));
    json_decref(farms);
    json_decref(hello);
    assert_refused(&f, "may not use the farm parallel", -32000,
                   with(params_of("quilt", "q.png", "j"), "farm", json_string("parallel")));
    assert_refused(&f, "/farm", -32602,
                   with(params_of("quilt", "q.png", "j"), "farm", json_string("pbs")));
    assert_refused(&f, "needs job", -32602,
                   json_pack("{s:s, s:s, s:s}", "kind", "quilt", "file", "q.png", "farm", "slurm"));
    static const char *const needing[] = {"spp", "passes", "job"};
    for (int i = 0; i < 3; i++)
        assert_refused(&f, "needs farm", -32602,
                       json_pack("{s:s, s:s, s:o}", "kind", "quilt", "file", "q.png", needing[i],
                                 i < 2 ? json_integer(1) : json_string("j")));
    assert_refused(&f, "cannot be combined with passes", -32602,
                   with(with(params_of("quilt", "q.png", "j"), "spp", json_integer(1)), "passes",
                        json_integer(1)));
    assert_refused(&f, "cannot be combined with farm", -32602,
                   with(params_of("quilt", "q.png", "j"), "wait", json_string("coarse")));
    assert_refused(&f, "cannot be combined with farm", -32602,
                   with(params_of("quilt", "q.png", "j"), "fds", json_integer(1)));
    assert_refused(&f, "no farm makes this kind", -32602, params_of("state", "s.lfstate", "j"));
    json_t *chart = params_of("chart", "c.tif", "j");
    json_object_update_new(chart, json_pack("{s:i, s:f, s:f, s:i, s:i}", "lpi", 30, "range", 0.2,
                                            "step", 0.1, "width", 60, "height", 40));
    assert_refused(&f, "no farm makes this kind", -32602, chart);
    static const char *const outside[] = {"../j", "/etc/j", "j/../../j"};
    for (int i = 0; i < 3; i++)
        assert_refused(&f, outside[i], -32001, params_of("quilt", "q.png", outside[i]));
    assert_refused(&f, "", -32001, params_of("quilt", "../q.png", "j"));
    assert_refused(&f, "without a final slash", -32602, params_of("quilt", "q.png", "j/"));
    assert_refused(&f, "without a final slash", -32602, params_of("quilt", "q.png", ""));
    assert_int_equal(farm_calls(f.folder, ""), 0);
    assert_int_not_equal(access(lf_test_path(f.l.exports, "j"), F_OK), 0);
    finish(&f);
}

static void no_farm_is_used_without_the_option(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    live_start(&f.l, f.l.scene, "--device", f.l.sim, NULL);
    live_connect(&f.l, &f.c);
    live_wait(&f.c, "coarse");
    assert_refused(&f, "start it with --farm slurm", -32000, params_of("quilt", "q.png", "j"));
    assert_int_equal(farm_calls(f.folder, ""), 0);
    finish(&f);
}

static void a_scene_that_was_passed_is_refused(void **state)
{
    (void)state;
    farm f;
    char *away = lf_test_folder();
    begin(&f);
    start(&f);
    const char *scene = lf_test_write(away, "fog.json", LIVE_SCENE);
    const int fd = open(scene, O_RDONLY | O_CLOEXEC);
    live_ask_with(&f.c, "scene.load", json_pack("{s:s, s:[s]}", "file", scene, "files", scene), &fd,
                  1);
    json_t *answer = live_answer(&f.c);
    assert_non_null(json_object_get(answer, "result"));
    json_decref(answer);
    close(fd);
    assert_refused(&f, "a farm cannot open it", -32000, params_of("quilt", "q.png", "j"));
    finish(&f);
    lf_test_folder_remove(away);
}

/* ------------------------------------------------------------------------------------- a job -- */

static void a_job_is_planned_submitted_and_followed_to_its_end(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    start(&f);
    const json_int_t job = export(&f, params_of("quilt", "q.png", "j"));
    await(&f, job, "running");
    json_t *jobs = jobs_of(&f.c), *told = json_array_get(jobs, 0);
    const json_t *at = json_object_get(told, "farm"), *tasks = json_object_get(at, "tasks");
    assert_string_equal(text_of(told, "kind"), "quilt");
    assert_string_equal(text_of(at, "engine"), "slurm");
    assert_non_null(strstr(text_of(at, "folder"), "/exports/j"));
    assert_int_equal(json_integer_value(json_object_get(tasks, "complete")), 1);
    assert_int_equal(json_integer_value(json_object_get(tasks, "missing")), 2);
    assert_true(json_real_value(json_object_get(told, "progress")) == 0.25);
    assert_true(json_real_value(json_object_get(at, "seconds_left")) == 50);
    assert_true(json_is_null(json_object_get(at, "problem")));
    json_decref(jobs);
    assert_int_equal(farm_calls(f.folder, "plan "), 1);
    assert_int_equal(farm_calls(f.folder, "submit "), 1);
    /* the client that asked leaves, and another one sees the end */
    live_client other;
    live_connect(&f.l, &other);
    assert_int_equal(live_code(&other, "subscribe", json_pack("{s:[s]}", "events", "export")), 0);
    live_close(&f.c);
    f.c = other;
    farm_write(f.folder, "status", farm_status("complete", 4));
    assert_string_equal(live_job_end(&f.c, job), "done");
    jobs = jobs_of(&f.c);
    assert_int_equal(json_array_size(jobs), 0);
    json_decref(jobs);
    finish(&f);
}

/* The scene has the patches of clients, and names its files wherever it is. */
static void the_farm_gets_the_scene_as_it_is_shown(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    assert_int_equal(mkdir(lf_test_path(f.l.folder, "scene/parts"), 0700), 0);
    lf_test_write(f.l.folder, "scene/parts/card.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    lf_test_write(f.l.folder, "scene/parts/part.json",
                  "{\"meshes\":{\"card\":{\"file\":\"card.obj\"}}}");
    lf_test_write(f.l.folder, "scene/fog.json",
                  lf_test_scene_patched("live-fog", "{'include':'parts/part.json'}"));
    start(&f);
    assert_int_equal(
        live_code(&f.c, "scene.patch",
                  json_pack("{s:{s:{s:{s:f}}}}", "patch", "volumes", "fog", "density", 2.5)),
        0);
    const json_int_t job = export(&f, params_of("quilt", "q.png", "j"));
    await(&f, job, "running");
    json_t *scene = json_load_file(lf_test_path(f.l.exports, "j/scene.json"), 0, NULL);
    const char *file = NULL;
    double density = 0, cone = 0, aspect = 0;
    assert_int_equal(json_unpack(scene, "{s:{s:{s:F}}, s:{s:F, s:F}, s:{s:{s:s}}}", "volumes",
                                 "fog", "density", &density, "camera", "cone", &cone, "aspect",
                                 &aspect, "meshes", "card", "file", &file),
                     0);
    assert_true(density == 2.5);
    assert_true(cone == 40); /* the panel's */
    assert_true(aspect == 0.75);
    assert_null(json_object_get(scene, "include"));
    assert_string_equal(file, lf_test_path(f.l.folder, "scene/parts/card.obj"));
    json_decref(scene);
    finish(&f);
}

/* --------------------------------------------------------------------------- what goes wrong -- */

static void a_missing_quiltfarm_is_told(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    assert_int_equal(unlink(lf_test_path(f.folder, "quiltfarm")), 0);
    setenv("PATH", f.folder, 1);
    start(&f);
    assert_fails(&f, export(&f, params_of("quilt", "q.png", "j")), "not in the PATH of quiltd");
    assert_int_not_equal(access(lf_test_path(f.l.exports, "j"), F_OK), 0);
    finish(&f);
}

static void a_plan_that_is_refused_tells_its_words_and_leaves_nothing(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    farm_write(f.folder, "plan.says",
               "progress\nquiltfarm: --spp: a task needs 3 GiB; give --task-memory\n");
    start(&f);
    assert_fails(&f, export(&f, params_of("panel", "p.png", "j")),
                 "quiltfarm plan: --spp: a task needs 3 GiB; give --task-memory");
    assert_int_not_equal(access(lf_test_path(f.l.exports, "j"), F_OK), 0);
    assert_int_equal(farm_calls(f.folder, "submit"), 0);
    /* a name that is taken */
    assert_int_equal(mkdir(lf_test_path(f.l.exports, "j"), 0700), 0);
    assert_fails(&f, export(&f, params_of("quilt", "q.png", "j")), "exists; choose another name");
    lf_test_write(f.l.exports, "s.png", "");
    assert_fails(&f, export(&f, params_of("still", "s.png", "k")), "exists; choose another name");
    assert_int_equal(farm_calls(f.folder, "plan"), 1);
    finish(&f);
}

static void a_submit_that_fails_and_a_task_that_fails_tell_their_words(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    farm_write(f.folder, "submit.says", "quiltfarm: sbatch: no partition\n");
    start(&f);
    assert_fails(&f, export(&f, params_of("quilt", "q.png", "j")), "sbatch: no partition");
    assert_int_equal(unlink(lf_test_path(f.folder, "submit.says")), 0);
    farm_write(f.folder, "status",
               "{\"state\":\"failed\",\"tasks\":{\"total\":4,\"complete\":3,\"running\":0,"
               "\"failed\":1,\"missing\":0},\"failed\":[{\"task\":2,\"words\":\"no memory\"}]}");
    assert_fails(&f, export(&f, params_of("quilt", "q.png", "k")), "a task has failed: no memory");
    finish(&f);
}

static void a_job_is_cancelled_by_quiltfarm(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    start(&f);
    const json_int_t job = export(&f, params_of("quilt", "q.png", "j"));
    await(&f, job, "running");
    assert_int_equal(live_code(&f.c, "job.cancel", json_pack("{s:I}", "job", job)), 0);
    assert_string_equal(live_job_end(&f.c, job), "cancelled");
    assert_int_equal(farm_calls(f.folder, "cancel "), 1);
    assert_int_equal(live_code(&f.c, "job.cancel", json_pack("{s:I}", "job", job)), -32602);
    /* what quiltfarm cannot cancel may run on, and is told */
    farm_write(f.folder, "cancel.says", "quiltfarm: scancel: no route\n");
    const json_int_t second = export(&f, params_of("quilt", "q.png", "k"));
    await(&f, second, "running");
    assert_int_equal(live_code(&f.c, "job.cancel", json_pack("{s:I}", "job", second)), 0);
    assert_fails(&f, second, "quiltfarm cancel: scancel: no route");
    finish(&f);
}

static void a_plan_that_hangs_is_ended(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    farm_write(f.folder, "plan.hangs", "");
    start(&f);
    const json_int_t job = export(&f, params_of("quilt", "q.png", "j"));
    while (farm_calls(f.folder, "plan") == 0)
        live_nap(20);
    assert_int_equal(live_code(&f.c, "job.cancel", json_pack("{s:I}", "job", job)), 0);
    assert_string_equal(live_job_end(&f.c, job), "cancelled");
    assert_int_equal(farm_calls(f.folder, "cancel"), 0); /* the farm knows nothing of it */
    (void)export(&f, params_of("quilt", "q.png", "k"));
    while (farm_calls(f.folder, "plan") == 1)
        live_nap(20);
    finish(&f); /* ends with it */
}

static void only_so_many_jobs_run_and_they_keep_out_no_exports(void **state)
{
    (void)state;
    farm f;
    char name[16];
    begin(&f);
    start(&f);
    for (int i = 0; i < 8; i++) {
        snprintf(name, sizeof name, "j%d", i);
        (void)export(&f, params_of("quilt", "q.png", name));
    }
    assert_refused(&f, "8 farm jobs are running already", -32000, params_of("quilt", "q.png", "k"));
    const json_int_t own = export(&f, json_pack("{s:s, s:s}", "kind", "panel", "file", "p.png"));
    assert_string_equal(live_job_end(&f.c, own), "done");
    finish(&f);
}

/* ------------------------------------------------------------------------------ quiltd's end -- */

static void a_job_goes_on_without_quiltd_which_follows_it_again(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    start(&f);
    const json_int_t job = export(&f, params_of("quilt", "q.png", "j"));
    await(&f, job, "running");
    live_close(&f.c);
    assert_int_equal(live_stop(&f.l), 0);
    assert_int_equal(farm_calls(f.folder, "cancel"), 0);
    /* not by a quiltd that may use no farm */
    live_start(&f.l, f.l.scene, "--device", f.l.sim, "--farm", "list", "--state", f.l.state, NULL);
    live_await_logged(&f.l, "start it with --farm slurm");
    assert_int_equal(live_stop(&f.l), 0);
    start(&f);
    json_t *jobs = jobs_of(&f.c);
    const json_t *told = json_array_get(jobs, 0);
    const json_int_t again = json_integer_value(json_object_get(told, "job"));
    assert_int_equal(json_array_size(jobs), 1);
    assert_non_null(strstr(text_of(json_object_get(told, "farm"), "folder"), "/exports/j"));
    assert_non_null(strstr(text_of(told, "file"), "/exports/q_qs3x2"));
    json_decref(jobs);
    assert_int_equal(live_code(&f.c, "job.cancel", json_pack("{s:I}", "job", again)), 0);
    for (size_t n = 1; n > 0; live_nap(20)) {
        jobs = jobs_of(&f.c);
        n = json_array_size(jobs);
        json_decref(jobs);
    }
    assert_int_equal(farm_calls(f.folder, "cancel "), 1);
    assert_int_equal(farm_calls(f.folder, "plan "), 1);
    live_close(&f.c);
    assert_int_equal(live_stop(&f.l), 0);
    /* and not once it has ended */
    start(&f);
    jobs = jobs_of(&f.c);
    assert_int_equal(json_array_size(jobs), 0);
    json_decref(jobs);
    finish(&f);
}

/* --------------------------------------------------------------------------------- the bytes -- */

static char *bytes_of(const char *path, size_t *out_n)
{
    FILE *file = fopen(path, "rb");
    char *bytes = calloc(1, (size_t)1 << 22);
    if (!file)
        fail_msg("%s is missing", path);
    assert_non_null(bytes);
    *out_n = fread(bytes, 1, (size_t)1 << 22, file);
    fclose(file);
    return bytes;
}

static void assert_same_bytes(const char *path, const char *other)
{
    size_t n, m;
    char *a = bytes_of(path, &n), *b = bytes_of(other, &m);
    assert_int_equal(n, m);
    assert_true(n > 0 && memcmp(a, b, n) == 0);
    free(a);
    free(b);
}

/* Runs the job with quiltrender. Then the job's scene is replaced by the test's own of the same
 * name, since files record it, for the quiltrender that the test runs with its own words. */
static void render_by_farm(farm *f, json_t *params, const char *job, const char *scene)
{
    const json_int_t number = export(f, params);
    assert_string_equal(live_job_end(&f->c, number), "done");
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s/%s", f->l.exports, job);
    farm_write(folder, "scene.json", scene);
}

static void the_farms_files_are_those_of_quiltrender(void **state)
{
    (void)state;
    farm f;
    char scene[PATH_MAX], out[PATH_MAX];
    begin(&f);
    farm_write(f.folder, "runs", "");
    start(&f);
    snprintf(out, sizeof out, "%s/own.png", f.l.folder);
    /* as on the panel: its cone, the daemon's view size, an exposure of the call, denoised */
    assert_int_equal(live_code(&f.c, "render.set", json_pack("{s:f}", "exposure", 0.5)), 0);
    render_by_farm(&f, with(params_of("pictures", "v/", "j"), "passes", json_integer(6)), "j",
                   lf_test_scene_patched("live-fog", "{'camera':{'cone':40,'aspect':0.75}}"));
    snprintf(scene, sizeof scene, "%s/j/scene.json", f.l.exports);
    snprintf(out, sizeof out, "%s/own/", f.l.folder);
    assert_int_equal(live_run(&f.l, "quiltrender", scene, "-o", out, "--png", "--views", "6",
                              "--view-size", "24x32", "--passes", "6", "--exposure", "0.5", NULL),
                     0);
    assert_same_bytes(lf_test_path(f.l.exports, "v/view_004.png"),
                      lf_test_path(f.l.folder, "own/view_004.png"));
    /* for the panel: quiltrender reads the calibration itself */
    render_by_farm(&f,
                   with(with(params_of("panel", "p.png", "k"), "passes", json_integer(6)), "gamma",
                        json_real(2.2)),
                   "k", LIVE_SCENE);
    snprintf(scene, sizeof scene, "%s/k/scene.json", f.l.exports);
    snprintf(out, sizeof out, "%s/own.png", f.l.folder);
    assert_int_equal(live_run(&f.l, "quiltrender", scene, "-o", out, "--panel",
                              lf_test_path(f.l.folder, "sim/calibration.json"), "--views", "6",
                              "--view-size", "24x32", "--passes", "6", "--exposure", "0.5",
                              "--gamma", "2.2", NULL),
                     0);
    assert_same_bytes(lf_test_path(f.l.exports, "p.png"), out);
    /* linear light is not denoised, and a changed estimator is the farm's, too */
    assert_int_equal(live_code(&f.c, "render.set", json_pack("{s:s}", "estimator", "mis")), 0);
    render_by_farm(&f, with(params_of("still", "s.exr", "m"), "spp", json_integer(3)), "m",
                   lf_test_scene_patched("live-fog", "{'camera':{'cone':40,'aspect':0.75}}"));
    snprintf(scene, sizeof scene, "%s/m/scene.json", f.l.exports);
    snprintf(out, sizeof out, "%s/own.exr", f.l.folder);
    assert_int_equal(live_run(&f.l, "quiltrender", scene, "-o", out, "--still", "--view-size",
                              "24x32", "--spp", "3", "--exposure", "0.5", "--estimator", "mis",
                              NULL),
                     0);
    assert_same_bytes(lf_test_path(f.l.exports, "s.exr"), out);
    finish(&f);
}

static void quiltctl_hands_a_job_over_and_shows_it(void **state)
{
    (void)state;
    farm f;
    begin(&f);
    start(&f);
    assert_int_equal(live_run(&f.l, "quiltctl", "--socket", f.l.socket, "export", "quilt", "q.png",
                              "farm=slurm", "job=j", "spp=4", NULL),
                     0);
    json_t *jobs = jobs_of(&f.c);
    assert_int_equal(json_array_size(jobs), 1);
    json_decref(jobs);
    assert_int_equal(live_run(&f.l, "quiltctl", "--socket", f.l.socket, "status", NULL), 0);
    assert_true(live_logged(&f.l, "slurm running, 1 of 4 tasks, about 50 s left"));
    farm_write(f.folder, "plan.says", "quiltfarm: too much\n");
    assert_int_equal(live_run(&f.l, "quiltctl", "--socket", f.l.socket, "export", "quilt", "q.png",
                              "farm=slurm", "job=k", NULL),
                     1);
    assert_true(live_logged(&f.l, "too much"));
    finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_calls_are_refused_before_anything_begins),
        cmocka_unit_test(no_farm_is_used_without_the_option),
        cmocka_unit_test(a_scene_that_was_passed_is_refused),
        cmocka_unit_test(a_job_is_planned_submitted_and_followed_to_its_end),
        cmocka_unit_test(the_farm_gets_the_scene_as_it_is_shown),
        cmocka_unit_test(a_missing_quiltfarm_is_told),
        cmocka_unit_test(a_plan_that_is_refused_tells_its_words_and_leaves_nothing),
        cmocka_unit_test(a_submit_that_fails_and_a_task_that_fails_tell_their_words),
        cmocka_unit_test(a_job_is_cancelled_by_quiltfarm),
        cmocka_unit_test(a_plan_that_hangs_is_ended),
        cmocka_unit_test(only_so_many_jobs_run_and_they_keep_out_no_exports),
        cmocka_unit_test(a_job_goes_on_without_quiltd_which_follows_it_again),
        cmocka_unit_test(the_farms_files_are_those_of_quiltrender),
        cmocka_unit_test(quiltctl_hands_a_job_over_and_shows_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
