/* parallel: GNU parallel, on this machine or over ssh. It runs while quiltfarm submit runs. */
#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/farm/farm_engine.h"
#include "daemon/farm/farm_process.h"

#define PROGRAM "parallel"
/* Finishes of tasks, then those that close the job. */
#define FINISH_ROUNDS 2
#define TELL_SECONDS 10.0
/* Time for a task to save its state, milliseconds. */
#define SAVE_MS "60000"

/* ---------------------------------------------------------------------------------- progress -- */

typedef struct watcher {
    const lf_farm_job *job;
    int n_complete;
    double told; /* time of the last line */
} watcher;

static int count_complete(const lf_farm_job *job)
{
    lf_farm_result *results = NULL;
    int n = 0;
    if (lf_farm_results_read(job, &results, NULL) != LF_OK)
        return -1;
    for (int i = 0; i < job->n_tasks; i++)
        n += results[i].complete;
    lf_free(results);
    return n;
}

static void look_on(void *context)
{
    watcher *w = context;
    const double now = lf_time_now();
    if (now - w->told < TELL_SECONDS)
        return;
    const int n = count_complete(w->job);
    w->told = now;
    if (n == w->n_complete)
        return;
    w->n_complete = n;
    lf_log(LF_LOG_INFO, "%d of %d tasks are complete", n, w->job->n_tasks);
}

/* -------------------------------------------------------------------------------------- send -- */

/* Writes the commands of steps to a file in log/. *out_n: how many. */
static lf_status write_list(const lf_farm_job *job, const bool *wanted, int first, int last,
                            const char *path, int *out_n, lf_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    lf_status status = out ? LF_OK : lf_farm_no_memory(job->path, err);
    *out_n = 0;
    for (int i = first; i <= last && status == LF_OK; i++) {
        char *command = NULL;
        if (!wanted[i])
            continue;
        status = lf_farm_step_command(job, i, i, &command, err);
        if (status == LF_OK)
            (void)fprintf(out, "%s\n", command);
        *out_n += status == LF_OK;
        lf_free(command);
    }
    if (out && fclose(out) != 0 && status == LF_OK)
        status = lf_farm_no_memory(job->path, err);
    if (status == LF_OK && *out_n > 0)
        status = lf_outfile_text(path, text, err);
    free(text);
    return status;
}

static void add_options(const lf_farm_job *job, const lf_farm_batch *batch, const char *list,
                        const char *joblog, lf_farm_words *words)
{
    const int share = job->threads < 100 ? 100 / job->threads : 1;
    lf_farm_words_add(words, PROGRAM);
    lf_farm_words_add(words, "--arg-file");
    lf_farm_words_add(words, "%s", list);
    lf_farm_words_add(words, "--joblog");
    lf_farm_words_add(words, "%s", joblog);
    lf_farm_words_add(words, "--retries");
    lf_farm_words_add(words, "%d", LF_FARM_MOST_FAILURES);
    lf_farm_words_add(words, "--termseq");
    lf_farm_words_add(words, "TERM," SAVE_MS ",KILL,100");
    lf_farm_words_add(words, "--jobs");
    if (batch->slots > 0)
        lf_farm_words_add(words, "%d", batch->slots);
    else
        lf_farm_words_add(words, "%d%%", share); /* of the processors */
    lf_farm_words_add_list(words, batch->words);
}

/* Runs wanted steps from first to last. */
static lf_status run_list(const lf_farm_job *job, const lf_farm_batch *batch, int first, int last,
                          const char *name, lf_error *err)
{
    lf_farm_words words = {0};
    watcher w = {.job = job, .n_complete = -1, .told = lf_time_now()};
    char *list = lf_farm_job_path(job, "log/%s.list", name),
         *joblog = lf_farm_job_path(job, "log/%s.joblog", name),
         *log = lf_farm_job_path(job, "log/parallel.log");
    int n = 0;
    lf_status status = list && joblog && log
                           ? write_list(job, batch->wanted, first, last, list, &n, err)
                           : lf_farm_no_memory(job->path, err);
    if (status == LF_OK && n > 0) {
        add_options(job, batch, list, joblog, &words);
        lf_farm_run run = {
            .words = words.list, .log = log, .quiet = true, .look = look_on, .context = &w};
        status = words.failed ? lf_farm_no_memory(job->path, err) : lf_farm_process_run(&run, err);
        if (status == LF_E_IO)
            status = lf_error_set(err, status, PROGRAM,
                                  "not found; install GNU parallel, or plan with --engine list");
        if (status == LF_OK && run.code > 253 && !lf_farm_is_told_to_end())
            status = lf_error_set(err, LF_E_IO, PROGRAM, "failed: %s", run.last);
    }
    lf_farm_words_finish(&words);
    lf_free(list);
    lf_free(joblog);
    lf_free(log);
    return status;
}

/* LF_OK if all wanted steps from first to last are complete; otherwise names one that failed. */
static lf_status check_complete(const lf_farm_job *job, const lf_farm_batch *batch, lf_error *err)
{
    lf_farm_result *results = NULL;
    char text[LF_FARM_STEP_NAME];
    int n = 0, failed = -1;
    lf_status status = lf_farm_results_read(job, &results, err);
    for (int i = 0; i < job->n_tasks + job->n_finishes && status == LF_OK; i++)
        if (batch->wanted[i] && !results[i].complete) {
            n++;
            failed = failed < 0 && results[i].failures > 0 ? i : failed;
        }
    if (status == LF_OK && n > 0 && lf_farm_is_told_to_end())
        status =
            lf_error_set(err, LF_E_CANCELLED, job->path, "interrupted; quiltfarm resume goes on");
    else if (status == LF_OK && failed >= 0)
        status = lf_error_set(err, LF_E_STATE, job->path, "%d of its steps failed; %s: %s", n,
                              lf_farm_step_text(job, failed, text), results[failed].words);
    else if (status == LF_OK && n > 0)
        status = lf_error_set(err, LF_E_STATE, job->path,
                              "%d of its steps are not complete; see log/parallel.log", n);
    lf_free(results);
    return status;
}

/* Leaves out finishes that need a step which is not complete. */
static lf_status keep_ready(const lf_farm_job *job, const lf_farm_batch *batch, bool *ready,
                            lf_error *err)
{
    lf_farm_result *results = NULL;
    lf_status status = lf_farm_results_read(job, &results, err);
    for (int i = job->n_tasks; i < job->n_tasks + job->n_finishes && status == LF_OK; i++) {
        ready[i] = batch->wanted[i] && !results[i].complete;
        for (int k = job->steps[i].tasks[0]; k <= job->steps[i].tasks[1]; k++)
            ready[i] = ready[i] && results[lf_farm_step_needed(job, i, k)].complete;
    }
    lf_free(results);
    return status;
}

static lf_status run_finishes(const lf_farm_job *job, const lf_farm_batch *batch, lf_error *err)
{
    const int n = job->n_tasks + job->n_finishes;
    bool *ready = lf_calloc((size_t)n, sizeof *ready);
    lf_farm_batch finishes = *batch;
    finishes.wanted = ready;
    lf_status status =
        ready ? keep_ready(job, batch, ready, err) : lf_farm_no_memory(job->path, err);
    if (status == LF_OK && !lf_farm_is_told_to_end())
        status = run_list(job, &finishes, job->n_tasks, n - 1, "finishes", err);
    lf_free(ready);
    return status;
}

static lf_status send_parallel(lf_farm_job *job, const lf_farm_batch *batch, json_t *sent,
                               lf_error *err)
{
    (void)sent;
    lf_farm_catch_signals();
    lf_status status = run_list(job, batch, 0, job->n_tasks - 1, "tasks", err);
    for (int round = 0; round < FINISH_ROUNDS && status == LF_OK && job->n_finishes > 0; round++)
        status = run_finishes(job, batch, err);
    if (status == LF_OK)
        status = check_complete(job, batch, err);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "%s: complete", job->path);
    return status;
}

/* ------------------------------------------------------------------------------ look, cancel -- */

/* While it runs it holds the job's lock. If it was killed, files say which tasks run on. */
static lf_status look_parallel(const lf_farm_job *job, const json_t *sent, lf_farm_queue *out,
                               lf_error *err)
{
    lf_farm_result *results = NULL;
    (void)sent;
    if (job->lock_fd >= 0 || !lf_farm_job_is_locked(job))
        return LF_OK;
    const lf_status status = lf_farm_results_read(job, &results, err);
    for (int i = 0; i < job->n_tasks + job->n_finishes && status == LF_OK; i++) {
        const bool runs = results[i].is_running,
                   waits = !results[i].complete && results[i].failures == 0 && !runs;
        lf_farm_queue_place(job, out, i,
                            runs    ? LF_FARM_RUNNING
                            : waits ? LF_FARM_QUEUED
                                    : LF_FARM_NOWHERE);
        out->n_running += runs;
        out->n_queued += waits;
    }
    lf_free(results);
    return status;
}

/* True if a process runs this program: its number may have gone to another one. */
static bool is_quiltfarm(pid_t pid)
{
    char name[64], own[PATH_MAX] = "", its[PATH_MAX] = "";
    snprintf(name, sizeof name, "/proc/%ld/exe", (long)pid);
    return readlink("/proc/self/exe", own, sizeof own - 1) > 0 &&
           readlink(name, its, sizeof its - 1) > 0 && strcmp(own, its) == 0;
}

static lf_status cancel_parallel(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    char host[64] = "";
    const char *there = json_string_value(json_object_get(sent, "host"));
    const pid_t pid = (pid_t)json_integer_value(json_object_get(sent, "pid"));
    (void)gethostname(host, sizeof host - 1);
    if (!lf_farm_job_is_locked(job))
        return lf_error_set(err, LF_E_STATE, job->path, "does not run");
    if (!there || strcmp(there, host) != 0)
        return lf_error_set(err, LF_E_STATE, job->path, "was submitted on %s; cancel it there",
                            there ? there : "another machine");
    if (pid <= 1 || !is_quiltfarm(pid))
        return lf_error_set(err, LF_E_STATE, job->path, "is not run by quiltfarm submit");
    if (kill(pid, SIGTERM) != 0)
        return lf_error_set(err, LF_E_IO, job->path, "process %ld cannot be ended: %s", (long)pid,
                            lf_errno_text(errno));
    return LF_OK;
}

const lf_farm_engine lf_farm_parallel = {
    .name = "parallel", .send = send_parallel, .look = look_parallel, .cancel = cancel_parallel};
