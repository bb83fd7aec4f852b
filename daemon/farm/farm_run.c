#include "daemon/farm/farm_run.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/farm/farm_file.h"
#include "daemon/farm/farm_process.h"
#include "daemon/farm/farm_result.h"
#include "daemon/farm/farm_text.h"
#include "daemon/output/options.h"

#define RENDERER "quiltrender"
#define MERGER "quiltmerge"
/* A network file system may show a new file to other machines only after a minute. */
#define MOST_NAPS 12
#define NAP_SECONDS 5
/* Bytes for receipts, logs and other small files. */
#define LEAST_ROOM (1 << 20)

/* What all programs of one step share. */
typedef struct runner {
    const lf_farm_job *job;
    int step;
    bool quiet, gives_up; /* gives up: what failed now fails again */
    char *log, *running;
    char last[sizeof((lf_farm_run *)0)->last]; /* of the last program */
    double cpu_seconds, seconds;
} runner;

/* ----------------------------------------------------------------------------------- program -- */

/* LF_E_CANCELLED: it was interrupted, and nothing that it should have saved is lost; LF_E_STATE: it
 * failed, with its last words. */
static lf_status say_end(const lf_farm_run *run, const char *program, bool saves, lf_error *err)
{
    if (run->signal == 0 && run->code == LF_EXIT_OK)
        return LF_OK;
    /* a shell between the two answers 128 + signal */
    const int number = run->signal == 0 && run->code > 128 ? run->code - 128 : run->signal;
    const bool too_early = number == SIGTERM || number == SIGINT; /* it had nothing to save yet */
    if (run->code == LF_EXIT_INTERRUPTED || (lf_farm_is_told_to_end() && (too_early || !saves)))
        return lf_error_set(err, LF_E_CANCELLED, program, "interrupted");
    if (number == SIGKILL)
        return lf_error_set(err, LF_E_STATE, program,
                            "was killed, perhaps because memory was short; its last line: %s",
                            run->last);
    if (number != 0)
        return lf_error_set(err, LF_E_STATE, program, "was ended by signal %d; its last line: %s",
                            number, run->last);
    return run->last[0] != '\0'
               ? lf_error_set(err, LF_E_STATE, "", "%s", run->last)
               : lf_error_set(err, LF_E_STATE, program, "ended with status %d", run->code);
}

/* saves: it keeps a state, and ends with LF_EXIT_INTERRUPTED only if that was written. */
static lf_status run_program(runner *r, const char *program, bool saves, lf_farm_words *words,
                             lf_error *err)
{
    char path[PATH_MAX];
    lf_farm_run run = {
        .folder = r->job->folder, .log = r->log, .running = r->running, .quiet = r->quiet};
    lf_status status =
        words->failed ? lf_farm_no_memory(program, err) : lf_farm_find(program, path, err);
    if (status != LF_OK)
        return status;
    char *name = words->list[0];
    words->list[0] = path;
    run.words = words->list;
    status = lf_farm_process_run(&run, err);
    words->list[0] = name;
    r->cpu_seconds += run.cpu_seconds;
    r->seconds += run.seconds;
    snprintf(r->last, sizeof r->last, "%s", run.last);
    return status == LF_OK ? say_end(&run, program, saves, err) : status;
}

/* ------------------------------------------------------------------------------------ render -- */

static void add_path(lf_farm_words *words, char *path)
{
    if (path)
        lf_farm_words_add(words, "%s", path);
    else
        words->failed = true;
    lf_free(path);
}

/* Adds the light fields of a step. One without fields has all, which the user's command named or
 * not: for some outputs it makes a difference. */
static void add_fields(const runner *r, lf_farm_words *words)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    int fields[2];
    lf_farm_step_fields(r->job, r->step, fields);
    if (fields[0] < 0 || (s->fields[0] < 0 && !r->job->names_fields))
        return;
    lf_farm_words_add(words, "%s", r->job->field_option);
    lf_farm_words_add(words, "%d:%d", fields[0], fields[1]);
}

/* The options of a step, before the words of the command, which may end the options. */
static void add_options(const runner *r, bool joins, bool with_state, lf_farm_words *words)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    char name[LF_FARM_STEP_NAME];
    if (!joins)
        add_fields(r, words);
    if (with_state) {
        lf_farm_words_add(words, "--state");
        add_path(words, lf_farm_step_state(r->job, r->step, -1));
    }
    if (s->rows[0] >= 0) {
        lf_farm_words_add(words, "--rows");
        lf_farm_words_add(words, "%d:%d", s->rows[0], s->rows[1]);
    } else {
        lf_farm_words_add(words, "--files");
        add_path(words, lf_farm_job_path(r->job, "done/%s.json",
                                         lf_farm_step_name(r->job, r->step, name)));
    }
}

static lf_status render(runner *r, bool with_state, lf_error *err)
{
    const bool joins = r->step >= r->job->n_tasks && r->job->join;
    lf_farm_words words = {0};
    lf_farm_words_add(&words, "%s", RENDERER);
    add_options(r, joins, with_state, &words);
    if (joins)
        lf_farm_job_words(r->job, r->job->join, 0, &words);
    else
        lf_farm_job_words(r->job, r->job->command, 1, &words);
    const lf_status status = run_program(r, RENDERER, with_state, &words, err);
    lf_farm_words_finish(&words);
    return status;
}

/* ------------------------------------------------------------------------------------ states -- */

/* True if the last program has named the state of a step. */
static bool has_named(const runner *r, int step, int field)
{
    char *path = lf_farm_step_state(r->job, step, field);
    const char *name = path ? strrchr(path, '/') : NULL;
    const bool is = name && strstr(r->last, name);
    lf_free(path);
    return is;
}

/* A state that cannot be used is removed, and its step is to run again. */
static void drop_state(const runner *r, int step, int field)
{
    char *path = lf_farm_step_state(r->job, step, field);
    lf_farm_result_revoke(r->job, step);
    if (path)
        (void)unlink(path);
    lf_free(path);
}

static bool holds_field(const lf_farm_job *job, int task, int field)
{
    int fields[2];
    lf_farm_step_fields(job, task, fields);
    return job->steps[task].rows[0] >= 0 && fields[0] <= field && field <= fields[1];
}

/* Removes a state that the renderer has called damaged, and has the only task run again that has
 * written it. */
static void drop_damaged(const runner *r)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    const bool is_finish = r->step >= r->job->n_tasks;
    int fields[2];
    lf_farm_step_fields(r->job, r->step, fields);
    for (int field = fields[0]; field <= fields[1] && strstr(r->last, "is damaged"); field++) {
        int n = 0, task = 0;
        if (!has_named(r, r->step, field))
            continue;
        drop_state(r, r->step, field);
        for (int i = s->tasks[0]; is_finish && i <= s->tasks[1]; i++)
            if (holds_field(r->job, i, field)) {
                task = i;
                n++;
            }
        if (n == 1)
            drop_state(r, task, field);
    }
}

static lf_status render_from_state(runner *r, lf_error *err)
{
    const lf_status status = render(r, true, err);
    if (status == LF_E_STATE)
        drop_damaged(r);
    return status;
}

/* -------------------------------------------------------------------------------------- task -- */

static lf_status run_task(runner *r, lf_error *err)
{
    const lf_status status = render_from_state(r, err);
    if (status != LF_OK || r->job->steps[r->step].rows[0] < 0)
        return status;
    return lf_farm_result_receipt(r->job, r->step, err);
}

/* ------------------------------------------------------------------------------------ finish -- */

/* LF_E_STATE: a state is not complete. A machine that was thought to be lost may have replaced a
 * complete state by an older one. */
static lf_status check_part(const runner *r, int task, const char *path, lf_error *err)
{
    char program[PATH_MAX], text[LF_FARM_STEP_NAME];
    char *info = NULL;
    int code = 0;
    lf_status status = lf_farm_find(RENDERER, program, err);
    if (status != LF_OK)
        return status;
    lf_farm_words words = {0};
    lf_farm_words_add(&words, "%s", program);
    lf_farm_words_add(&words, "--state-info");
    lf_farm_words_add(&words, "%s", path);
    status = words.failed ? lf_farm_no_memory(program, err)
                          : lf_farm_process_read(words.list, &info, &code, err);
    lf_farm_words_finish(&words);
    if (status != LF_OK)
        return status;
    json_t *state = json_loads(info, 0, NULL); /* one that cannot be read fails the renderer, too */
    if (code == 0 && !json_is_true(json_object_get(state, "complete"))) {
        lf_farm_result_revoke(r->job, task);
        status = lf_error_set(err, LF_E_STATE, path, "is not complete; submit %s again",
                              lf_farm_step_text(r->job, task, text));
    }
    json_decref(state);
    lf_free(info);
    return status;
}

/* Gives a file a second name, which replaces an older file. */
static lf_status name_again(const char *path, const char *name, lf_error *err)
{
    char temporary[PATH_MAX];
    snprintf(temporary, sizeof temporary, "%s.%ld", name, (long)getpid());
    bool made = (link(path, temporary) == 0 || symlink(path, temporary) == 0) &&
                rename(temporary, name) == 0;
    const int why = errno;
    (void)unlink(temporary); /* still there if both names were the same file before */
    return made ? LF_OK
                : lf_error_set(err, LF_E_IO, name, "cannot be made: %s", lf_errno_text(why));
}

/* Has the tasks run again whose states quiltmerge refuses by name. One that is not complete goes on
 * from its state; others begin anew. *out: one of them. True: there is one. */
static bool drop_refused(const runner *r, int field, int *out)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    const bool is_bad =
                   strstr(r->last, "make this part again") || strstr(r->last, "of another job"),
               is_early = strstr(r->last, "is not complete");
    bool found = false;
    for (int i = s->tasks[0]; i <= s->tasks[1] && (is_bad || is_early); i++) {
        if (!holds_field(r->job, i, field) || !has_named(r, i, field))
            continue;
        if (is_bad)
            drop_state(r, i, field);
        else
            lf_farm_result_revoke(r->job, i);
        *out = i;
        found = true;
    }
    return found;
}

static lf_status merge_parts(runner *r, int field, lf_farm_words *words, lf_error *err)
{
    char text[LF_FARM_STEP_NAME];
    lf_error why = {0};
    int task = 0;
    lf_status status = run_program(r, MERGER, false, words, &why);
    if (status == LF_E_STATE && drop_refused(r, field, &task))
        return lf_error_set(err, status, lf_farm_step_text(r->job, task, text),
                            "must run again; resume the job (%s)", r->last);
    if (status != LF_OK && err)
        *err = why;
    return status;
}

/* Puts the parts of one light field (-1: the only one) together as the state of the finish. One
 * part that is the whole gets a second name. */
static lf_status merge_field(runner *r, int field, lf_error *err)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    lf_farm_words words = {0};
    lf_status status = LF_OK;
    char *whole = lf_farm_step_state(r->job, r->step, field);
    int task = 0;
    lf_farm_words_add(&words, "%s", MERGER);
    for (int i = s->tasks[0]; i <= s->tasks[1]; i++)
        if (holds_field(r->job, i, field)) {
            add_path(&words, lf_farm_step_state(r->job, i, field));
            task = i;
        }
    if (!whole || words.failed) {
        status = lf_farm_no_memory(MERGER, err);
    } else if (words.n == 2) {
        status = check_part(r, task, words.list[1], err);
        if (status == LF_OK)
            status = name_again(words.list[1], whole, err);
    } else {
        lf_farm_words_add(&words, "-o");
        lf_farm_words_add(&words, "%s", whole);
        status = merge_parts(r, field, &words, err);
    }
    lf_free(whole);
    lf_farm_words_finish(&words);
    return status;
}

static bool needs_merge(const lf_farm_job *job, const lf_farm_step *finish)
{
    for (int i = finish->tasks[0]; i <= finish->tasks[1] && !finish->closes; i++)
        if (job->steps[i].rows[0] >= 0)
            return true;
    return false;
}

/* The first step that a finish waits for; -1: none. */
static int first_missing(const lf_farm_job *job, int finish)
{
    const lf_farm_step *s = &job->steps[finish];
    for (int i = s->tasks[0]; i <= s->tasks[1]; i++) {
        lf_farm_result result;
        const int needed = lf_farm_step_needed(job, finish, i);
        if (lf_farm_result_read(job, needed, &result, NULL) != LF_OK || !result.complete)
            return needed;
    }
    return -1;
}

static lf_status wait_for_tasks(const lf_farm_job *job, int finish, lf_error *err)
{
    char text[LF_FARM_STEP_NAME], own[LF_FARM_STEP_NAME];
    int missing = first_missing(job, finish);
    for (int i = 0; i < MOST_NAPS && missing >= 0 && !lf_farm_is_told_to_end(); i++) {
        sleep(NAP_SECONDS);
        missing = first_missing(job, finish);
    }
    if (missing < 0)
        return LF_OK;
    if (lf_farm_is_told_to_end())
        return lf_error_set(err, LF_E_CANCELLED, job->path, "interrupted");
    return lf_error_set(err, LF_E_STATE, job->path,
                        "%s needs %s, which is not complete; submit the job again",
                        lf_farm_step_text(job, finish, own), lf_farm_step_text(job, missing, text));
}

static lf_status run_finish(runner *r, lf_error *err)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    const bool merges = needs_merge(r->job, s);
    int fields[2];
    lf_farm_step_fields(r->job, r->step, fields);
    lf_status status = wait_for_tasks(r->job, r->step, err);
    for (int field = fields[0]; field <= fields[1] && merges && status == LF_OK; field++)
        status = merge_field(r, field, err);
    if (status != LF_OK)
        return status;
    return merges ? render_from_state(r, err) : render(r, false, err);
}

/* -------------------------------------------------------------------------------------- step -- */

/* A state that cannot be saved is hours of work in vain: asked before, not after. Finishes make
 * room in the end, and file systems without blocks do not tell. */
static lf_status check_room(runner *r, lf_error *err)
{
    const lf_farm_job *job = r->job;
    const double needed = json_number_value(json_object_get(job->plan, "state_bytes")) + LEAST_ROOM;
    struct statvfs fs;
    char room[32], bytes[32];
    if (r->step >= job->n_tasks || statvfs(job->path, &fs) != 0 || fs.f_blocks == 0 ||
        (double)fs.f_bavail * (double)fs.f_frsize >= needed)
        return LF_OK;
    r->gives_up = true;
    return lf_error_set(err, LF_E_STATE, job->path,
                        "the disk has %s free, and a task needs %s; make room, and resume the job",
                        lf_farm_bytes((double)fs.f_bavail * (double)fs.f_frsize, room, sizeof room),
                        lf_farm_bytes(needed, bytes, sizeof bytes));
}

/* GNU parallel repeats what fails. submit sends no step that has failed so often. */
static lf_status check_failures(const runner *r, lf_error *err)
{
    lf_farm_result result;
    char text[LF_FARM_STEP_NAME];
    if (!getenv("PARALLEL_SEQ") || lf_farm_result_read(r->job, r->step, &result, err) != LF_OK ||
        !result.is_given_up)
        return LF_OK;
    return lf_error_set(err, LF_E_STATE, r->job->path,
                        "%s is given up after %d failure%s; use quiltfarm resume when this is "
                        "mended: %s",
                        lf_farm_step_text(r->job, r->step, text), result.failures,
                        result.failures == 1 ? "" : "s", result.words);
}

static bool is_complete(const lf_farm_job *job, int step)
{
    lf_farm_result result;
    return lf_farm_result_read(job, step, &result, NULL) == LF_OK && result.complete;
}

static lf_status run(runner *r, lf_error *err)
{
    char words[sizeof *err];
    lf_farm_result_begin(r->job, r->step);
    lf_status status = lf_farm_check_same(r->job, r->step, err);
    if (status == LF_OK)
        status = check_room(r, err);
    if (status == LF_OK)
        status = r->step < r->job->n_tasks ? run_task(r, err) : run_finish(r, err);
    const bool complete = is_complete(r->job, r->step); /* by another run, perhaps */
    if (status == LF_OK && !complete)
        status = lf_error_set(err, LF_E_STATE, RENDERER, "ended well, but its files are missing");
    lf_error_format(err, words, sizeof words);
    lf_farm_result_end(r->job, r->step, r->cpu_seconds, r->seconds,
                       complete || status == LF_E_CANCELLED ? NULL : words, r->gives_up);
    if (!complete)
        return status;
    lf_farm_result_forgive(r->job, r->step);
    lf_farm_result_tidy(r->job, r->step);
    return LF_OK;
}

lf_status lf_farm_run_step(const lf_farm_job *job, int step, bool quiet, lf_error *err)
{
    char name[LF_FARM_STEP_NAME];
    lf_error own = {0};
    runner r = {.job = job, .step = step, .quiet = quiet};
    if (is_complete(job, step))
        return LF_OK;
    const lf_status given_up = check_failures(&r, err);
    if (given_up != LF_OK)
        return given_up;
    lf_farm_step_name(job, step, name);
    r.log = lf_farm_job_path(job, "log/%s.log", name);
    r.running = lf_farm_job_path(job, "done/%s.running", name);
    const lf_status status =
        r.log && r.running ? run(&r, &own) : lf_farm_no_memory(job->path, &own);
    if (status != LF_OK && err)
        *err = own;
    lf_free(r.log);
    lf_free(r.running);
    return status;
}
