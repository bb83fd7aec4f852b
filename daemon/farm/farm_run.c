#include "daemon/farm/farm_run.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/farm/farm_process.h"
#include "daemon/farm/farm_result.h"
#include "daemon/output/options.h"

#define RENDERER "quiltrender"
#define MERGER "quiltmerge"
/* A network file system may show a new file to other machines only after a minute. */
#define MOST_NAPS 12
#define NAP_SECONDS 5

/* What all programs of one step share. */
typedef struct runner {
    const lf_farm_job *job;
    int step;
    bool quiet;
    char *log, *running;
    double cpu_seconds, seconds;
} runner;

/* ----------------------------------------------------------------------------------- program -- */

/* LF_E_CANCELLED: it was interrupted; LF_E_STATE: it failed, with its last words. */
static lf_status say_end(const lf_farm_run *run, const char *program, lf_error *err)
{
    if (run->signal == 0 && run->code == LF_EXIT_OK)
        return LF_OK;
    if (lf_farm_is_told_to_end() || run->code == LF_EXIT_INTERRUPTED)
        return lf_error_set(err, LF_E_CANCELLED, program, "interrupted");
    /* a shell between the two answers 128 + signal */
    const int number = run->signal == 0 && run->code > 128 ? run->code - 128 : run->signal;
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

static lf_status run_program(runner *r, const char *program, lf_farm_words *words, lf_error *err)
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
    return status == LF_OK ? say_end(&run, program, err) : status;
}

/* -------------------------------------------------------------------------------------- task -- */

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
    const lf_status status = run_program(r, RENDERER, &words, err);
    lf_farm_words_finish(&words);
    return status;
}

static lf_status run_task(runner *r, lf_error *err)
{
    const lf_status status = render(r, true, err);
    if (status != LF_OK || r->job->steps[r->step].rows[0] < 0)
        return status;
    return lf_farm_result_receipt(r->job, r->step, err);
}

/* ------------------------------------------------------------------------------------ finish -- */

static bool holds_field(const lf_farm_job *job, int task, int field)
{
    int fields[2];
    lf_farm_step_fields(job, task, fields);
    return job->steps[task].rows[0] >= 0 && fields[0] <= field && field <= fields[1];
}

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
    json_t *state = json_loads(info, 0, NULL);
    if (code != 0 || !json_is_true(json_object_get(state, "complete"))) {
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

/* Puts the parts of one light field (-1: the only one) together as the state of the finish. One
 * part that is the whole gets a second name. */
static lf_status merge_field(runner *r, int field, lf_error *err)
{
    const lf_farm_step *s = &r->job->steps[r->step];
    lf_farm_words words = {0};
    lf_status status = LF_OK;
    char *whole = lf_farm_step_state(r->job, r->step, field);
    lf_farm_words_add(&words, "%s", MERGER);
    for (int i = s->tasks[0]; i <= s->tasks[1] && status == LF_OK; i++) {
        char *part = holds_field(r->job, i, field) ? lf_farm_step_state(r->job, i, field) : NULL;
        if (!part)
            continue;
        status = check_part(r, i, part, err);
        add_path(&words, part);
    }
    if (!whole || words.failed)
        status = lf_farm_no_memory(MERGER, err);
    if (status == LF_OK && words.n == 2) {
        status = name_again(words.list[1], whole, err);
    } else if (status == LF_OK) {
        lf_farm_words_add(&words, "-o");
        lf_farm_words_add(&words, "%s", whole);
        status = run_program(r, MERGER, &words, err);
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
    return status == LF_OK ? render(r, merges, err) : status;
}

/* -------------------------------------------------------------------------------------- step -- */

static bool is_complete(const lf_farm_job *job, int step)
{
    lf_farm_result result;
    return lf_farm_result_read(job, step, &result, NULL) == LF_OK && result.complete;
}

static lf_status run(runner *r, lf_error *err)
{
    char words[sizeof *err];
    lf_farm_result_begin(r->job, r->step);
    lf_status status = r->step < r->job->n_tasks ? run_task(r, err) : run_finish(r, err);
    const bool complete = is_complete(r->job, r->step); /* by another run, perhaps */
    if (status == LF_OK && !complete)
        status = lf_error_set(err, LF_E_STATE, RENDERER, "ended well, but its files are missing");
    lf_error_format(err, words, sizeof words);
    lf_farm_result_end(r->job, r->step, r->cpu_seconds, r->seconds,
                       complete || status == LF_E_CANCELLED ? NULL : words);
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
