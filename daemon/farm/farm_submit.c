#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "daemon/farm/farm.h"
#include "daemon/farm/farm_engine.h"
#include "daemon/farm/farm_file.h"
#include "daemon/farm/farm_process.h"
#include "daemon/farm/farm_run.h"

#define SENT "sent.json"

/* What is to be sent of a job. */
typedef struct selection {
    bool *wanted; /* per step; owned */
    int n_tasks, n_finishes, n_given_up;
} selection;

/* Opens a job whose words may be run. */
static lf_status open_mine(const char *path, lf_farm_job *job, lf_error *err)
{
    const lf_status status = lf_farm_job_open(path, job, err);
    return status == LF_OK ? lf_farm_job_check_mine(job, err) : status;
}

/* A finish is wanted if it is missing and can be reached: no step that it needs was given up. */
static bool can_be_reached(const lf_farm_job *job, const lf_farm_result *results,
                           const bool *wanted, int finish)
{
    const lf_farm_step *s = &job->steps[finish];
    for (int i = s->tasks[0]; i <= s->tasks[1]; i++) {
        const int needed = lf_farm_step_needed(job, finish, i);
        if (!results[needed].complete && !wanted[needed])
            return false;
    }
    return true;
}

/* A run that is lost was killed. */
static lf_status select_steps(const lf_farm_job *job, bool forgives, selection *out, lf_error *err)
{
    const int n = job->n_tasks + job->n_finishes;
    lf_farm_result *results = NULL;
    lf_status status = lf_farm_results_read(job, &results, err);
    if (status != LF_OK)
        return status;
    out->wanted = lf_calloc((size_t)n, sizeof *out->wanted);
    for (int i = 0; i < n && out->wanted; i++) {
        if (results[i].complete)
            continue;
        if (results[i].is_lost)
            lf_farm_result_abandon(job, i, &results[i]);
        const bool given_up = results[i].is_given_up && !forgives;
        if (results[i].failures > 0 && forgives)
            lf_farm_result_forgive(job, i);
        out->n_given_up += given_up;
        out->wanted[i] =
            !given_up && (i < job->n_tasks || can_be_reached(job, results, out->wanted, i));
        out->n_tasks += i < job->n_tasks && out->wanted[i];
        out->n_finishes += i >= job->n_tasks && out->wanted[i];
    }
    lf_free(results);
    return out->wanted ? LF_OK : lf_farm_no_memory(job->path, err);
}

/* Removes output files that are not as their receipts say, so that their steps are not complete. */
static lf_status remove_differing(const lf_farm_job *job, lf_error *err)
{
    json_t *names = lf_farm_result_differing(job);
    lf_status status = names ? LF_OK : lf_farm_no_memory(job->path, err);
    const json_t *entry;
    size_t i;
    json_array_foreach(names, i, entry)
    {
        const char *name = json_string_value(entry);
        lf_log(LF_LOG_INFO, "%s: is not as rendered; it is made again", name);
        if (unlink(name) != 0 && status == LF_OK)
            status =
                lf_error_set(err, LF_E_IO, name, "cannot be removed: %s", lf_errno_text(errno));
    }
    json_decref(names);
    return status;
}

/* LF_E_BUSY: the engine has steps of this job, or of a removed one of the same name, or somebody
 * runs one by hand. */
static lf_status check_idle(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    lf_farm_queue queue;
    json_t *nothing = json_object();
    lf_status status = lf_farm_queue_read(job, sent ? sent : nothing, &queue, err);
    const int n_sent = queue.n_queued + queue.n_running;
    if (status == LF_OK && n_sent == 0)
        status = lf_farm_queue_by_files(job, &queue, err);
    const int n = queue.n_queued + queue.n_running;
    json_decref(nothing);
    lf_farm_queue_finish(&queue);
    if (status == LF_OK && job->engine->check)
        status = job->engine->check(job, sent, err);
    if (status == LF_OK && n_sent > 0 && job->engine == &lf_farm_slurm)
        status = lf_error_set(err, LF_E_BUSY, job->path,
                              "was submitted already: %s has %d of its steps; see quiltfarm status",
                              job->engine->name, n);
    else if (status == LF_OK && n > 0)
        status = lf_error_set(err, LF_E_BUSY, job->path,
                              "%d of its steps run, or were lost in the last 5 minutes; end them, "
                              "or try again later",
                              n);
    return status;
}

/* The words of a submission: those that are given, or the recorded ones. */
static json_t *words_json(char *const *words, const json_t *before)
{
    if (!words[0] && before)
        return json_deep_copy(before);
    json_t *array = json_array();
    for (; array && *words; words++)
        json_array_append_new(array, json_string(*words));
    return array;
}

static json_t *new_record(const lf_farm_command *c, const json_t *before)
{
    char host[64] = "";
    int slots = c->options->slots;
    if (slots == 0)
        slots = (int)json_integer_value(json_object_get(before, "slots"));
    (void)gethostname(host, sizeof host - 1);
    return json_pack("{s:i, s:o, s:s, s:I, s:I, s:[]}", "slots", slots, "words",
                     words_json(c->words, json_object_get(before, "words")), "host", host, "pid",
                     (json_int_t)getpid(), "uid", (json_int_t)getuid(), "jobs");
}

static lf_status send_selection(lf_farm_job *job, const selection *s, json_t *record, lf_error *err)
{
    lf_farm_words words = {0};
    lf_farm_words_add_json(&words, json_object_get(record, "words"), 0);
    char *none[] = {NULL};
    const lf_farm_batch batch = {.wanted = s->wanted,
                                 .slots = (int)json_integer_value(json_object_get(record, "slots")),
                                 .words = words.list ? words.list : none};
    lf_status status = words.failed ? lf_farm_no_memory(job->path, err)
                                    : lf_farm_job_write(job, SENT, record, err);
    if (status == LF_OK)
        status = job->engine->send(job, &batch, record, err);
    lf_farm_words_finish(&words);
    return status;
}

/* Words that the engine refused are not kept: resume would use them again. */
static void take_back(const lf_farm_job *job, const json_t *before)
{
    char *path = lf_farm_job_path(job, SENT);
    if ((!before || lf_farm_job_write(job, SENT, before, NULL) != LF_OK) && path)
        (void)unlink(path);
    lf_free(path);
}

static lf_status tell_and_send(lf_farm_job *job, const selection *s, json_t *record, lf_error *err)
{
    if (s->n_given_up > 0)
        lf_log(LF_LOG_WARNING,
               "%s: %d step%s given up; see quiltfarm status, then use quiltfarm resume", job->path,
               s->n_given_up, s->n_given_up == 1 ? " is" : "s are");
    if (s->n_tasks + s->n_finishes > 0)
        return send_selection(job, s, record, err);
    if (s->n_given_up > 0)
        return lf_error_set(err, LF_E_STATE, job->path, "nothing is left to send");
    lf_log(LF_LOG_INFO, "%s: complete", job->path);
    return LF_OK;
}

static lf_status submit(const lf_farm_command *c, bool forgives, lf_error *err)
{
    lf_farm_job job;
    json_t *before = NULL, *record = NULL;
    selection s = {0};
    lf_status status = open_mine(c->job, &job, err);
    if (status == LF_OK)
        status = lf_farm_check_release(&job, err);
    if (status == LF_OK)
        status = lf_farm_job_lock(&job, err);
    if (status == LF_OK)
        status = lf_farm_job_read(&job, SENT, &before, err);
    if (status == LF_OK)
        status = check_idle(&job, before, err);
    if (status == LF_OK && c->options->check)
        status = remove_differing(&job, err);
    if (status == LF_OK)
        status = select_steps(&job, forgives, &s, err);
    if (status == LF_OK && !(record = new_record(c, forgives ? before : NULL)))
        status = lf_farm_no_memory(job.path, err);
    if (status == LF_OK)
        status = tell_and_send(&job, &s, record, err);
    if (status == LF_E_ARG && record)
        take_back(&job, before);
    lf_free(s.wanted);
    json_decref(record);
    json_decref(before);
    lf_farm_job_close(&job);
    return status;
}

lf_status lf_farm_submit(const lf_farm_command *c, lf_error *err)
{
    return submit(c, false, err);
}

lf_status lf_farm_resume(const lf_farm_command *c, lf_error *err)
{
    return submit(c, true, err);
}

lf_status lf_farm_cancel(const lf_farm_command *c, lf_error *err)
{
    lf_farm_job job;
    json_t *sent = NULL;
    lf_status status = open_mine(c->job, &job, err);
    if (status == LF_OK)
        status = lf_farm_job_read(&job, SENT, &sent, err);
    if (status == LF_OK && !sent && job.engine != &lf_farm_slurm)
        status = lf_error_set(err, LF_E_STATE, job.path, "was not submitted");
    if (status == LF_OK)
        status = job.engine->cancel(&job, sent, err);
    json_decref(sent);
    lf_farm_job_close(&job);
    return status;
}

/* ------------------------------------------------------------------------------------- steps -- */

/* Runs steps first to last. Keeps the first failure, and ends at an interruption. */
static lf_status run_steps(const lf_farm_job *job, int first, int last, lf_error *err)
{
    char text[LF_FARM_STEP_NAME];
    lf_status result = LF_OK;
    lf_farm_catch_signals();
    for (int i = first; i <= last; i++) {
        lf_error why = {0};
        const lf_status status = lf_farm_run_step(job, i, false, &why);
        if (status == LF_OK) {
            lf_log(LF_LOG_INFO, "%s is complete", lf_farm_step_text(job, i, text));
            continue;
        }
        if (result == LF_OK || status == LF_E_CANCELLED)
            *err = why;
        result = result == LF_OK || status == LF_E_CANCELLED ? status : result;
        if (status == LF_E_CANCELLED)
            break;
    }
    return result;
}

static lf_status run_command(const lf_farm_command *c, bool is_task, lf_error *err)
{
    lf_farm_job job;
    lf_status status = open_mine(c->job, &job, err);
    if (status == LF_OK) {
        const int n = is_task ? job.n_tasks : job.n_finishes, from = is_task ? 0 : job.n_tasks;
        int range[2];
        status = lf_farm_read_steps(c->steps, n, range, err);
        if (status == LF_OK)
            status = run_steps(&job, from + range[0], from + range[1], err);
    }
    lf_farm_job_close(&job);
    return status;
}

lf_status lf_farm_task(const lf_farm_command *c, lf_error *err)
{
    return run_command(c, true, err);
}

lf_status lf_farm_finish(const lf_farm_command *c, lf_error *err)
{
    return run_command(c, false, err);
}

lf_status lf_farm_merge(const lf_farm_command *c, lf_error *err)
{
    lf_farm_job job;
    lf_farm_result *results = NULL;
    lf_status status = open_mine(c->job, &job, err);
    if (status == LF_OK)
        status = lf_farm_job_lock(&job, err);
    if (status == LF_OK)
        status = lf_farm_results_read(&job, &results, err);
    int missing = 0;
    for (int i = 0; i < job.n_tasks && status == LF_OK; i++)
        missing += !results[i].complete;
    if (missing > 0)
        status = lf_error_set(err, LF_E_STATE, job.path,
                              "%d of %d tasks are not complete; see quiltfarm status", missing,
                              job.n_tasks);
    if (status == LF_OK)
        status = run_steps(&job, job.n_tasks, job.n_tasks + job.n_finishes - 1, err);
    for (int i = 0; i < job.n_tasks + job.n_finishes && status == LF_OK; i++)
        lf_farm_result_tidy(&job, i);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "%s: complete", job.path);
    lf_free(results);
    lf_farm_job_close(&job);
    return status;
}
