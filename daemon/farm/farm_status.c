#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/farm/farm.h"
#include "daemon/farm/farm_engine.h"
#include "daemon/farm/farm_text.h"

/* Failed and lost steps that are printed as text; JSON has all. */
#define MOST_LINES 10

/* Everything about a job at one time. */
typedef struct report {
    lf_farm_job job;
    json_t *sent;      /* NULL: never submitted */
    json_t *differing; /* output files that are not as their receipts; NULL: not looked at */
    lf_farm_result *results;
    lf_farm_queue queue;
    bool asked;                                            /* the engine has answered */
    int n_complete, n_running, n_queued, n_failed, n_lost; /* of tasks */
    int n_finished, n_finishing, n_finishes_failed;        /* of finishes */
    double planned, spent, left;                           /* CPU seconds */
    double seconds_left;                                   /* < 0: unknown */
} report;

/* ------------------------------------------------------------------------------------- count -- */

static bool runs(const report *r, int step)
{
    return r->queue.places[step] == LF_FARM_RUNNING ||
           (r->queue.places[step] == LF_FARM_NOWHERE && r->results[step].is_running);
}

static void count(report *r)
{
    const lf_farm_job *job = &r->job;
    for (int i = 0; i < job->n_tasks + job->n_finishes; i++) {
        const lf_farm_result *result = &r->results[i];
        const bool is_task = i < job->n_tasks, is_running = !result->complete && runs(r, i),
                   is_queued = !result->complete && r->queue.places[i] == LF_FARM_QUEUED,
                   has_failed =
                       !result->complete && !is_running && !is_queued && result->failures > 0;
        *(is_task ? &r->n_complete : &r->n_finished) += result->complete;
        *(is_task ? &r->n_running : &r->n_finishing) += is_running;
        *(is_task ? &r->n_failed : &r->n_finishes_failed) += has_failed;
        r->n_queued += is_queued;
        r->n_lost += result->is_lost && !is_queued;
    }
}

/* The measured cost of complete steps tells what the others cost. */
static void estimate(report *r)
{
    const lf_farm_job *job = &r->job;
    double planned_done = 0, spent_done = 0, left = 0, longest = 0;
    for (int i = 0; i < job->n_tasks + job->n_finishes; i++) {
        const lf_farm_result *result = &r->results[i];
        const double planned = job->steps[i].cpu_seconds;
        r->planned += planned;
        r->spent += result->cpu_seconds;
        if (result->complete && result->cpu_seconds > 0) {
            planned_done += planned;
            spent_done += result->cpu_seconds;
        }
        if (!result->complete) {
            const double rest = planned > result->cpu_seconds ? planned - result->cpu_seconds : 0;
            left += rest;
            longest = rest > longest ? rest : longest;
        }
    }
    const double ratio = planned_done > 0 && spent_done > 0 ? spent_done / planned_done : 1;
    const int asked = (int)json_integer_value(json_object_get(r->sent, "slots"));
    const int at_once = r->n_running + r->n_finishing, slots = at_once > 0 ? at_once : asked;
    r->left = left * ratio;
    r->seconds_left = left > 0 && slots == 0 ? -1 : 0;
    if (left > 0 && slots > 0) {
        const double even = left / slots;
        r->seconds_left = ratio * (even > longest ? even : longest) / job->threads;
    }
}

static bool is_complete(const report *r)
{
    return r->n_complete == r->job.n_tasks && r->n_finished == r->job.n_finishes;
}

static const char *state_of(const report *r)
{
    if (is_complete(r))
        return "complete";
    if (r->n_finishing > 0 && r->n_complete == r->job.n_tasks)
        return "merging";
    if (r->n_running + r->n_finishing > 0)
        return "running";
    if (r->n_queued > 0)
        return "queued";
    if (r->n_failed + r->n_finishes_failed > 0)
        return "failed";
    if (r->sent && r->job.engine == &lf_farm_list)
        return "queued"; /* as far as anybody knows */
    return r->sent || r->n_complete > 0 || r->spent > 0 ? "interrupted" : "planned";
}

/* -------------------------------------------------------------------------------------- read -- */

static lf_status read_report(const char *path, report *r, lf_error *err)
{
    lf_error why = {0};
    char text[sizeof why];
    lf_status status = lf_farm_job_open(path, &r->job, err);
    if (status == LF_OK)
        status = lf_farm_job_read(&r->job, "sent.json", &r->sent, err);
    if (status == LF_OK)
        status = lf_farm_results_read(&r->job, &r->results, err);
    if (status != LF_OK)
        return status;
    const lf_status asked = lf_farm_queue_read(&r->job, r->sent, &r->queue, &why);
    if (!r->queue.places)
        return lf_farm_no_memory(path, err);
    r->asked = asked == LF_OK;
    if (!r->asked)
        lf_log(LF_LOG_WARNING, "%s; showing only what is on the disk",
               lf_error_format(&why, text, sizeof text));
    count(r);
    estimate(r);
    return LF_OK;
}

static void release(report *r)
{
    lf_farm_queue_finish(&r->queue);
    lf_free(r->results);
    json_decref(r->differing);
    json_decref(r->sent);
    lf_farm_job_close(&r->job);
}

/* -------------------------------------------------------------------------------------- tell -- */

static bool is_failed(const report *r, int step)
{
    return !r->results[step].complete && r->results[step].failures > 0;
}

static json_t *steps_json(const report *r, bool lost)
{
    json_t *array = json_array();
    char name[LF_FARM_STEP_NAME];
    for (int i = 0; i < r->job.n_tasks + r->job.n_finishes; i++) {
        const lf_farm_result *result = &r->results[i];
        const bool is_task = i < r->job.n_tasks;
        const int number = is_task ? i : i - r->job.n_tasks;
        lf_farm_step_name(&r->job, i, name);
        if (lost && result->is_lost)
            json_array_append_new(array,
                                  json_pack("{s:i, s:s, s:f}", is_task ? "task" : "finish", number,
                                            "host", result->host, "seconds", result->silent));
        else if (!lost && is_failed(r, i))
            json_array_append_new(array,
                                  json_pack("{s:i, s:s, s:i}", is_task ? "task" : "finish", number,
                                            "words", result->words, "failures", result->failures));
    }
    return array;
}

static void print_json(const report *r)
{
    const lf_farm_job *job = &r->job;
    json_t *left = r->seconds_left < 0 ? json_null() : json_real(r->seconds_left);
    json_t *json = json_pack(
        "{s:s, s:s, s:s, s:{s:i, s:i, s:i, s:i, s:i}, s:{s:i, s:i, s:i, s:i}, s:{s:f, s:f}, s:o, "
        "s:{s:f, s:f}, s:o, s:o, s:s, s:o}",
        "job", job->path, "engine", job->engine->name, "state", state_of(r), "tasks", "total",
        job->n_tasks, "complete", r->n_complete, "running", r->n_running, "failed", r->n_failed,
        "missing", job->n_tasks - r->n_complete, "finishes", "total", job->n_finishes, "complete",
        r->n_finished, "running", r->n_finishing, "failed", r->n_finishes_failed, "cpu_seconds",
        "planned", r->planned, "spent", r->spent, "seconds_left", left, "cost", "cpu_hours_spent",
        r->spent / 3600, "cpu_hours_left", r->left / 3600, "failed", steps_json(r, false), "lost",
        steps_json(r, true), "note", r->queue.note, "outputs",
        lf_farm_result_files(job, r->results));
    if (r->differing)
        json_object_set(json, "differing", r->differing);
    json_dumpf(json, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(json);
}

static void print_steps(const report *r)
{
    char text[LF_FARM_STEP_NAME], name[LF_FARM_STEP_NAME], time[32];
    int n = 0;
    for (int i = 0; i < r->job.n_tasks + r->job.n_finishes; i++) {
        const lf_farm_result *result = &r->results[i];
        if ((!is_failed(r, i) && !result->is_lost) || n++ >= MOST_LINES)
            continue;
        lf_farm_step_text(&r->job, i, text);
        if (is_failed(r, i))
            printf("  failed    %s, %d time%s: %s\n            see %s/log/%s.log\n", text,
                   result->failures, result->failures == 1 ? "" : "s", result->words, r->job.path,
                   lf_farm_step_name(&r->job, i, name));
        else
            printf("  lost      %s on %s, silent for %s\n", text, result->host,
                   lf_farm_seconds(result->silent, time, sizeof time));
    }
    if (n > MOST_LINES)
        printf("  and %d more; --json lists all\n", n - MOST_LINES);
}

static void print_differing(const report *r)
{
    const size_t n = json_array_size(r->differing);
    for (size_t i = 0; i < n && i < MOST_LINES; i++)
        printf("  differs   %s\n", json_string_value(json_array_get(r->differing, i)));
    if (n > MOST_LINES)
        printf("  and %zu more; --json lists all\n", n - MOST_LINES);
}

static void print_next(const report *r)
{
    const char *state = state_of(r), *path = r->job.path;
    const bool is_list = r->job.engine == &lf_farm_list;
    const char *next = NULL;
    if (strcmp(state, "planned") == 0)
        next = "submit";
    else if (!is_complete(r) && is_list && r->n_complete == r->job.n_tasks)
        next = "merge";
    else if (strcmp(state, "failed") == 0 || strcmp(state, "interrupted") == 0)
        next = "resume";
    if (next)
        printf("next: quiltfarm %s %s\n", next, path);
}

static void print_text(const report *r)
{
    char a[32], b[32];
    printf("%s: %s\n", r->job.path, state_of(r));
    printf("  tasks     %d of %d complete, %d running, %d failed\n", r->n_complete, r->job.n_tasks,
           r->n_running, r->n_failed);
    if (r->job.n_finishes > 0)
        printf("  finishes  %d of %d complete, %d running, %d failed\n", r->n_finished,
               r->job.n_finishes, r->n_finishing, r->n_finishes_failed);
    printf("  cost      %s of CPU time spent, %s planned\n", lf_farm_seconds(r->spent, a, sizeof a),
           lf_farm_seconds(r->planned, b, sizeof b));
    if (!is_complete(r) && r->seconds_left >= 0)
        printf("  left      about %s, %s of CPU time\n",
               lf_farm_seconds(r->seconds_left, a, sizeof a),
               lf_farm_seconds(r->left, b, sizeof b));
    if (r->queue.note[0] != '\0')
        printf("  note      %s\n", r->queue.note);
    print_steps(r);
    print_differing(r);
    print_next(r);
}

lf_status lf_farm_status(const lf_farm_command *c, lf_error *err)
{
    report r = {.job.lock_fd = -1};
    lf_status status = read_report(c->job, &r, err);
    if (status == LF_OK && c->options->check && !(r.differing = lf_farm_result_differing(&r.job)))
        status = lf_farm_no_memory(c->job, err);
    if (status == LF_OK && c->options->json)
        print_json(&r);
    else if (status == LF_OK)
        print_text(&r);
    const size_t n = json_array_size(r.differing);
    if (status == LF_OK && n > 0)
        status = lf_error_set(err, LF_E_STATE, r.job.path,
                              "%zu output file%s not as rendered; quiltfarm resume --check makes "
                              "%s again",
                              n, n == 1 ? " is" : "s are", n == 1 ? "it" : "them");
    release(&r);
    return status;
}
