/* Exports without a server: what is told of them, in its order, and how they end. What is drawn
 * needs no picture; everything else waits here, for an engine that has none. */
#include "tests/testing.h"

#include <fcntl.h>
#include <sys/eventfd.h>

#include "base/alloc.h"
#include "daemon/parts/jobs.h"

enum { WAIT_S = 60 };

typedef struct owner {
    char *folder;
    sd_event *event;
    lf_inbox inbox;
    int posted;
    lf_engine *engine;
    lf_jobs *jobs;
    char told[1024]; /* a word or two an event, a comma behind each */
    int ended;
} owner;

__attribute__((format(printf, 2, 3))) static void tell(owner *o, const char *format, ...)
{
    va_list args;
    size_t used = strlen(o->told);
    va_start(args, format);
    vsnprintf(o->told + used, sizeof o->told - used, format, args);
    va_end(args);
}

static void on_told(void *context, const lf_job_told *job)
{
    static const char *const names[] = {"waiting", "running", "done", "cancelled", "failed"};
    owner *o = context;
    const char *file = strrchr(job->file, '/');
    lf_job_told other;
    if (job->state == LF_JOB_RUNNING && job->progress > 0)
        return; /* as many as there was time for */
    for (int i = 0; job->state > LF_JOB_RUNNING && lf_jobs_at(o->jobs, i, &other); i++)
        assert_true(other.id != job->id);
    assert_int_equal(!!job->err, job->state == LF_JOB_FAILED);
    tell(o, "%d %s %s %s%s%s, ", (int)job->id, job->kind, file ? file + 1 : job->file,
         names[job->state], job->err ? " " : "", job->err ? lf_status_name(job->err->status) : "");
}

static void on_ended(void *context, const lf_asker *asker)
{
    owner *o = context;
    tell(o, "of %d, ", (int)asker->client);
    o->ended++;
}

static int on_inbox(sd_event_source *source, int fd, uint32_t events, void *context)
{
    owner *o = context;
    (void)source, (void)fd, (void)events;
    lf_inbox_read(&o->inbox, NULL);
    return 0;
}

static int set_up(void **state)
{
    static const lf_jobs_events events = {.told = on_told, .ended = on_ended};
    const lf_engine_controls controls = {.threads = 1};
    lf_error err;
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->folder = lf_test_folder();
    o->posted = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_engine_create(&controls, o->posted, &o->engine, &err), &err);
    lf_assert_ok(lf_inbox_init(&o->inbox), NULL);
    assert_true(sd_event_new(&o->event) >= 0);
    assert_true(sd_event_add_io(o->event, NULL, o->inbox.event_fd, 1, on_inbox, o) >= 0);
    const lf_jobs_home home = {o->event, &o->inbox, o->engine};
    lf_assert_ok(lf_jobs_create(&home, &events, o, &o->jobs), NULL);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_job_told job;
    lf_jobs_end(o->jobs);
    assert_false(lf_jobs_at(o->jobs, 0, &job));
    lf_jobs_destroy(o->jobs);
    lf_inbox_finish(&o->inbox, NULL);
    sd_event_unref(o->event);
    lf_engine_destroy(o->engine);
    close(o->posted);
    lf_test_folder_remove(o->folder);
    free(o);
    return 0;
}

/* What was told since the last look. */
static void assert_told(owner *o, const char *expected)
{
    assert_string_equal(o->told, expected);
    o->told[0] = '\0';
}

static void await_end(owner *o)
{
    for (int i = 0; o->ended == 0 && i < WAIT_S * 10; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_int_equal(o->ended, 1);
    o->ended = 0;
}

/* A file of this kind (NULL: a state), for a client. */
static lf_export export_of(owner *o, const char *kind, const char *name, uint64_t client)
{
    lf_error err;
    lf_export what = {.asker.client = client, .folder_fd = -1};
    if (kind)
        lf_assert_ok(lf_output_kind_from_name(kind, &what.kind, &err), &err);
    what.file = lf_strdup(lf_test_path(o->folder, name));
    what.generation = 1; /* the engine has none */
    return what;
}

static lf_export chart(owner *o, const char *name)
{
    lf_export what = export_of(o, "chart", name, 5);
    lf_param_defaults(lf_print_params, &what.print);
    what.print.lpi = 60;
    what.print.chart_range = 0.5;
    what.print.chart_step = 0.1;
    what.print.width_mm = 60;
    what.print.height_mm = 60;
    what.print.dpi = 360;
    return what;
}

static void add(owner *o, int64_t id, const lf_export *what)
{
    lf_error err;
    lf_assert_ok(lf_jobs_add(o->jobs, id, what, &err), &err);
}

/* A job that will wait. */
static void add_quilt(owner *o, int64_t id, uint64_t client, bool detached)
{
    lf_export what = export_of(o, "quilt", "q.png", client);
    what.asker.detached = detached;
    add(o, id, &what);
}

static void what_is_drawn_is_written_at_once(void **state)
{
    owner *o = *state;
    const lf_export what = chart(o, "c.tif");
    add(o, 3, &what);
    assert_told(o, "");
    lf_jobs_start(o->jobs);
    assert_told(o, "3 chart c.tif running, ");
    await_end(o);
    assert_told(o, "3 chart c.tif done, of 5, ");
    assert_int_equal(access(lf_test_path(o->folder, "c.tif"), R_OK), 0);
}

static void what_is_there_already_is_not_written_over(void **state)
{
    owner *o = *state;
    lf_test_write(o->folder, "c.tif", "mine");
    lf_export what = chart(o, "c.tif");
    what.folder_fd = open(o->folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
    add(o, 1, &what);
    lf_jobs_start(o->jobs);
    await_end(o);
    assert_told(o, "1 chart c.tif running, 1 chart c.tif failed LF_E_EXISTS, of 5, ");
}

static void a_job_waits_for_its_picture_until_it_is_cancelled(void **state)
{
    owner *o = *state;
    lf_job_told job;
    lf_error err;
    add_quilt(o, 1, 5, false);
    add_quilt(o, 2, 5, false);
    lf_jobs_start(o->jobs);
    assert_told(o, "");
    assert_true(lf_jobs_at(o->jobs, 0, &job));
    assert_int_equal(job.id, 2);
    assert_int_equal(job.state, LF_JOB_WAITING);
    assert_true(lf_jobs_at(o->jobs, 1, &job));
    assert_int_equal(job.id, 1);
    assert_false(lf_jobs_at(o->jobs, 2, &job));
    lf_assert_status(lf_jobs_cancel(o->jobs, 3, &err), LF_E_ARG, &err);
    lf_assert_ok(lf_jobs_cancel(o->jobs, 1, &err), &err);
    assert_told(o, "1 quilt q.png cancelled, of 5, ");
    lf_assert_status(lf_jobs_cancel(o->jobs, 1, &err), LF_E_ARG, &err);
}

static void jobs_of_a_client_that_has_left_end_unless_they_are_detached(void **state)
{
    owner *o = *state;
    lf_job_told job;
    add_quilt(o, 1, 5, false);
    add_quilt(o, 2, 5, true);
    add_quilt(o, 3, 6, false);
    lf_jobs_end_of(o->jobs, 5);
    assert_told(o, "1 quilt q.png cancelled, of 5, ");
    assert_true(lf_jobs_at(o->jobs, 1, &job));
    assert_int_equal(job.id, 2);
    lf_jobs_end(o->jobs); /* the way down: nobody is told */
    assert_told(o, "");
    assert_false(lf_jobs_at(o->jobs, 0, &job));
}

static void a_state_needs_a_scene(void **state)
{
    owner *o = *state;
    lf_export what = export_of(o, NULL, "s.lfstate", 5);
    what.generation = 0;
    add(o, 1, &what);
    lf_jobs_start(o->jobs);
    await_end(o);
    assert_told(o, "1 state s.lfstate running, 1 state s.lfstate failed LF_E_STATE, of 5, ");
    assert_int_not_equal(access(lf_test_path(o->folder, "s.lfstate"), F_OK), 0);
}

/* How many may wait of this client's, or of those that are detached. */
static int count_waiting(owner *o, uint64_t client, bool detached, int64_t id)
{
    int n = 0;
    lf_error err;
    for (;; n++) {
        lf_export what = export_of(o, "quilt", "q.png", client);
        what.asker.detached = detached;
        if (lf_jobs_check_wait(o->jobs, &what, &err) != LF_OK) {
            assert_int_equal(err.status, LF_E_BUSY);
            lf_export_finish(&what);
            return n;
        }
        add(o, id + n, &what);
        client += detached ? 1 : 0; /* each of another */
    }
}

static void few_jobs_wait(void **state)
{
    owner *o = *state;
    lf_error err;
    assert_int_equal(count_waiting(o, 5, false, 10), 2);
    assert_int_equal(count_waiting(o, 100, true, 20), 4);
    assert_int_equal(count_waiting(o, 6, false, 30), 0); /* six wait: that is all */
    const lf_export drawn = chart(o, "c.tif");
    lf_assert_ok(lf_jobs_check_wait(o->jobs, &drawn, &err), &err);
    lf_assert_ok(lf_jobs_check_room(o->jobs, 1, &err), &err);
    lf_assert_status(lf_jobs_check_room(o->jobs, 2, &err), LF_E_BUSY, &err);
    add(o, 40, &drawn);
    lf_assert_status(lf_jobs_check_room(o->jobs, 1, &err), LF_E_BUSY, &err);
}

#define jobs_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        jobs_test(what_is_drawn_is_written_at_once),
        jobs_test(what_is_there_already_is_not_written_over),
        jobs_test(a_job_waits_for_its_picture_until_it_is_cancelled),
        jobs_test(jobs_of_a_client_that_has_left_end_unless_they_are_detached),
        jobs_test(a_state_needs_a_scene),
        jobs_test(few_jobs_wait),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
