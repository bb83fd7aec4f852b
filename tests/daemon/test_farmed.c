/* Jobs of farms without a server: what quiltfarm says, how long it may take, and how jobs end. Most
 * jobs here are taken up from records, so they need no scene. */
#include "tests/testing.h"

#include <pthread.h>
#include <signal.h>

#include <systemd/sd-event.h>

#include "base/alloc.h"
#include "daemon/parts/farmed.h"
#include "tests/daemon/farm_script.h"

enum { WAIT_S = 60 };

typedef struct owner {
    char *folder;
    char farm[PATH_MAX / 2], exports[PATH_MAX / 2], state[PATH_MAX / 2];
    char path[2 * PATH_MAX]; /* $PATH as it was */
    lf_inbox inbox;
    sd_event *event;
    lf_farmed *farmed;
    int ended;
    lf_farmed_state end;
    char words[sizeof(lf_error)]; /* of a failure */
    lf_farmed_look look;          /* the last one */
} owner;

static void on_told(void *context, const lf_farmed_told *job)
{
    owner *o = context;
    o->look = *job->look;
    o->end = job->state;
    assert_int_equal(!!job->err, job->state == LF_FARMED_FAILED);
    if (job->err)
        lf_error_format(job->err, o->words, sizeof o->words);
}

static void on_ended(void *context)
{
    owner *o = context;
    o->ended++;
}

static int on_inbox(sd_event_source *source, int fd, uint32_t events, void *context)
{
    owner *o = context;
    (void)source, (void)fd, (void)events;
    lf_inbox_read(&o->inbox, NULL);
    return 0;
}

static void make(owner *o, double call_s, int most_vain)
{
    static const lf_farmed_events events = {.told = on_told, .ended = on_ended};
    const lf_farmed_home home = {.inbox = &o->inbox,
                                 .export_root = o->exports,
                                 .state_dir = o->state,
                                 .plan_s = call_s,
                                 .call_s = call_s,
                                 .interval_s = 0.001,
                                 .most_vain = most_vain};
    lf_assert_ok(lf_farmed_create(&home, &events, o, &o->farmed), NULL);
}

static int set_up(void **state)
{
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->folder = lf_test_folder();
    snprintf(o->path, sizeof o->path, "%s", getenv("PATH"));
    snprintf(o->farm, sizeof o->farm, "%s/farm", o->folder);
    snprintf(o->exports, sizeof o->exports, "%s/exports", o->folder);
    snprintf(o->state, sizeof o->state, "%s/state", o->folder);
    assert_int_equal(mkdir(o->farm, 0700) | mkdir(o->exports, 0700) | mkdir(o->state, 0700), 0);
    farm_prepare(o->farm);
    lf_assert_ok(lf_inbox_init(&o->inbox), NULL);
    assert_true(sd_event_new(&o->event) >= 0);
    assert_true(sd_event_add_io(o->event, NULL, o->inbox.event_fd, 1, on_inbox, o) >= 0);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_farmed_told job;
    assert_false(lf_farmed_at(o->farmed, 0, &job));
    lf_farmed_destroy(o->farmed);
    lf_inbox_finish(&o->inbox, NULL);
    sd_event_unref(o->event);
    setenv("PATH", o->path, 1);
    lf_test_folder_remove(o->folder);
    free(o);
    return 0;
}

/* Waits for an event; WAIT_S seconds without any fail. */
static void run_once(owner *o)
{
    for (int i = 0; i < WAIT_S; i++) {
        const int found = sd_event_run(o->event, 1000000);
        assert_true(found >= 0);
        if (found > 0)
            return;
    }
    fail_msg("nothing happens");
}

static void await_end(owner *o, lf_farmed_state end)
{
    while (o->ended == 0)
        run_once(o);
    assert_int_equal(o->ended, 1);
    assert_int_equal(o->end, end);
    o->ended = 0;
}

static void assert_words(const owner *o, const char *words)
{
    if (!strstr(o->words, words))
        fail_msg("\"%s\" does not say \"%s\"", o->words, words);
}

/* A record of a job of the folder exports/NAME. */
static void record(const owner *o, const char *file, const char *name, const char *engine)
{
    char text[2 * PATH_MAX];
    snprintf(text, sizeof text,
             "{\"job\":\"%s/%s\",\"engine\":\"%s\",\"kind\":\"quilt\",\"file\":\"q.png\"}",
             o->exports, name, engine);
    lf_test_write(o->state, file, text);
}

#define RECORD "farm-0123456789abcdef.json"

/* Takes up one job. */
static void take_up(owner *o, const char *engine)
{
    int64_t id = 6;
    assert_int_equal(mkdir(lf_test_path(o->exports, "j"), 0700), 0);
    record(o, RECORD, "j", engine);
    lf_farmed_take_up(o->farmed, 7, &id);
    assert_int_equal(id, 7);
}

/* ------------------------------------------------------------------------------------- looks -- */

/* Waits until looks fail, or do no longer. */
static void await_problem(owner *o, bool fails)
{
    for (int i = 0; (o->look.problem[0] != '\0') != fails; i++) {
        assert_true(i < 200);
        run_once(o);
    }
}

static void what_is_no_status_is_told_and_the_job_goes_on(void **state)
{
    owner *o = *state;
    static const char *const wrong[] = {
        "",
        "{",
        "[]",
        "{\"state\":\"running\"}",
        "{\"state\":\"happy\",\"tasks\":{}}",
        "{\"state\":7,\"tasks\":7,\"failed\":7}",
        "{\"state\":\"running\",\"tasks\":{\"total\":1,\"complete\":2,\"running\":0,\"failed\":0,"
        "\"missing\":0}}",
        "{\"state\":\"running\",\"tasks\":{\"total\":-1,\"complete\":0,\"running\":0,\"failed\":0,"
        "\"missing\":0}}",
        "{\"state\":\"running\",\"tasks\":{\"total\":1.5,\"complete\":0,\"running\":0,\"failed\":"
        "0,\"missing\":0}}"};
    make(o, WAIT_S, 1 << 20);
    take_up(o, "slurm");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        farm_write(o->farm, "status", wrong[i]);
        await_problem(o, true);
        assert_non_null(strstr(o->look.problem, "expected a state and its tasks"));
        farm_write(o->farm, "status", farm_status("queued", 2));
        await_problem(o, false);
        assert_string_equal(o->look.state, "queued");
        assert_int_equal(o->look.complete, 2);
    }
    farm_write(o->farm, "status", farm_status("complete", 4));
    await_end(o, LF_FARMED_DONE);
    assert_int_not_equal(access(lf_test_path(o->state, RECORD), F_OK), 0);
}

static void numbers_that_are_none_are_unknown(void **state)
{
    owner *o = *state;
    make(o, WAIT_S, 1 << 20);
    farm_write(o->farm, "status",
               "{\"state\":\"complete\",\"tasks\":{\"total\":1,\"complete\":1,\"running\":0,"
               "\"failed\":0,\"missing\":0},\"cpu_seconds\":{\"planned\":-3,\"spent\":\"a\"},"
               "\"seconds_left\":null}");
    take_up(o, "slurm");
    await_end(o, LF_FARMED_DONE);
    assert_true(o->look.planned < 0 && o->look.spent < 0 && o->look.seconds_left < 0);
}

static void looks_that_hang_or_fail_again_and_again_end_the_job(void **state)
{
    owner *o = *state;
    make(o, 0.1, 3);
    farm_write(o->farm, "status.hangs", "");
    take_up(o, "slurm");
    await_end(o, LF_FARMED_FAILED);
    assert_words(o, "has failed 3 times");
    assert_words(o, "status has not ended within 0.1 s");
    assert_int_equal(farm_calls(o->farm, "status"), 3);
}

/* More than there is room for. */
static void what_floods_is_cut(void **state)
{
    owner *o = *state;
    make(o, WAIT_S, 2);
    lf_test_write(o->farm, "quiltfarm",
                  "#!/bin/sh\nhead -c 9000000 /dev/zero | tr '\\0' x 2>&1\nexit 0\n");
    take_up(o, "slurm");
    await_end(o, LF_FARMED_FAILED);
    assert_words(o, "status prints too much");
}

static void a_job_whose_tasks_are_lost_fails_in_the_end(void **state)
{
    owner *o = *state;
    make(o, WAIT_S, 2);
    farm_write(o->farm, "status", farm_status("interrupted", 1));
    take_up(o, "slurm");
    await_end(o, LF_FARMED_FAILED);
    assert_words(o, "run quiltfarm resume");
    assert_true(farm_calls(o->farm, "status") > 10);
    assert_int_equal(farm_calls(o->farm, "resume"), 0);
}

static void parallel_that_ended_with_quiltd_is_resumed_once(void **state)
{
    owner *o = *state;
    make(o, WAIT_S, 2);
    farm_write(o->farm, "status", farm_status("interrupted", 1));
    take_up(o, "parallel");
    while (o->ended == 0) {
        run_once(o);
        assert_true(farm_calls(o->farm, "resume") <= 1);
    }
    assert_int_equal(o->end, LF_FARMED_FAILED);
    assert_int_equal(farm_calls(o->farm, "resume"), 1);
}

/* ----------------------------------------------------------------------------------- records -- */

static void records_of_nothing_are_told_and_left(void **state)
{
    owner *o = *state;
    int64_t id = 0;
    make(o, WAIT_S, 2);
    lf_test_write(o->state, "farm-0000000000000001.json", "{");
    lf_test_write(o->state, "farm-0000000000000002.json", "{\"job\":7}");
    record(o, "farm-0000000000000003.json", "../state", "slurm");
    record(o, "farm-0000000000000004.json", "j", "pbs");
    record(o, "farm-5.json", "j", "slurm"); /* not a name of a record */
    record(o, "farm-000000000000000g.json", "j", "slurm");
    record(o, "farm-0000000000000006.json", "j", "list"); /* not allowed now */
    lf_farmed_take_up(o->farmed, 3, &id);
    assert_int_equal(id, 0);
    assert_int_equal(access(lf_test_path(o->state, "farm-0000000000000003.json"), F_OK), 0);
}

static void a_job_that_is_left_keeps_its_record(void **state)
{
    owner *o = *state;
    make(o, WAIT_S, 2);
    take_up(o, "slurm");
    while (farm_calls(o->farm, "status") == 0)
        run_once(o);
    lf_farmed_leave(o->farmed);
    while (o->ended == 0)
        run_once(o);
    assert_int_equal(o->end, LF_FARMED_RUNNING); /* nothing else was told */
    assert_int_equal(access(lf_test_path(o->state, RECORD), F_OK), 0);
    assert_int_equal(farm_calls(o->farm, "cancel"), 0);
}

static void a_cancelled_job_has_no_record(void **state)
{
    owner *o = *state;
    make(o, WAIT_S, 2);
    take_up(o, "slurm");
    assert_false(lf_farmed_cancel(o->farmed, 6));
    assert_true(lf_farmed_cancel(o->farmed, 7));
    await_end(o, LF_FARMED_CANCELLED);
    assert_int_equal(farm_calls(o->farm, "cancel "), 1);
    assert_int_not_equal(access(lf_test_path(o->state, RECORD), F_OK), 0);
}

/* ----------------------------------------------------------------------------------- engines -- */

static void lists_of_farms_are_read(void **state)
{
    (void)state;
    unsigned bits = 0;
    lf_error err;
    lf_assert_ok(lf_farmed_engines("list,slurm", &bits, &err), &err);
    assert_int_equal(bits, 5);
    static const char *const wrong[] = {"", "slurm,", ",", "slur", "slurms", "slurm parallel"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(lf_farmed_engines(wrong[i], &bits, &err), LF_E_ARG);
    assert_int_equal(bits, 5);
}

int main(void)
{
#define JOB(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        JOB(what_is_no_status_is_told_and_the_job_goes_on),
        JOB(numbers_that_are_none_are_unknown),
        JOB(looks_that_hang_or_fail_again_and_again_end_the_job),
        JOB(what_floods_is_cut),
        JOB(a_job_whose_tasks_are_lost_fails_in_the_end),
        JOB(parallel_that_ended_with_quiltd_is_resumed_once),
        JOB(records_of_nothing_are_told_and_left),
        JOB(a_job_that_is_left_keeps_its_record),
        JOB(a_cancelled_job_has_no_record),
        cmocka_unit_test(lists_of_farms_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
