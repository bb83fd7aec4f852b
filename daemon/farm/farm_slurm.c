/* slurm: arrays of tasks, and finishes that depend on them. Calls sbatch, squeue, scontrol and
 * scancel as programs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "base/number.h"
#include "daemon/farm/farm_engine.h"
#include "daemon/farm/farm_slurm_internal.h"

/* Limits of a Slurm that does not tell its own: its defaults. */
#define USUAL_ARRAY 1001
#define USUAL_JOBS 10000
#define MOST_FINISH_JOBS 500
#define SPARE_JOBS 16 /* for other users, who submit at the same time */
/* What a task asks for: memory and time of the plan with a margin, because machines differ. */
#define MORE_MEMORY 1.25
#define LEAST_MEMORY (256.0 * 1048576)
#define MORE_TIME 3.0
#define LEAST_MINUTES 10.0
/* From the signal to the time limit: what it takes to save a state on a slow disk. */
#define LEAST_SAVE_SECONDS 120
#define SAVE_SECONDS_PER_GB 15.0
/* sbatch waits for 120 s before it gives up; a cancel waits for longer. */
#define MOST_WAIT_TENTHS 1500
#define MARK "log/cancelled"

/* ------------------------------------------------------------------------------------ limits -- */

/* "KEY   = NUMBER" in what scontrol prints. */
static int limit_of(const char *text, const char *key, int otherwise)
{
    uint64_t number;
    const char *at = strstr(text, key);
    at = at ? at + strlen(key) : "";
    at += strspn(at, " =");
    return lf_whole_read(at, &number) && number > 1 && number < 1000000000 ? (int)number
                                                                           : otherwise;
}

/* How a submission is divided: steps per job of the queue, and indices per array. */
typedef struct limits {
    int stride, array;
    int n_arrays;      /* with a wanted task */
    int finish_stride; /* wanted ones */
} limits;

/* The jobs that the cluster holds of all users, finished ones too, as MaxJobCount counts them. */
static lf_status count_jobs(char *const *given, int *out, lf_error *err)
{
    lf_farm_words words = {0};
    char *text = NULL;
    lf_farm_words_add(&words, "squeue");
    lf_farm_slurm_cluster(given, &words);
    lf_farm_words_add(&words, "--noheader");
    lf_farm_words_add(&words, "--array");
    lf_farm_words_add(&words, "--states=all");
    lf_farm_words_add(&words, "--format=%%t");
    const lf_status status = lf_farm_slurm_call(&words, &text, err);
    lf_farm_words_finish(&words);
    *out = 0;
    for (const char *c = text; c && *c; c++)
        *out += *c == '\n';
    lf_free(text);
    return status;
}

static int quotient_up(int n, int of)
{
    return (n + of - 1) / of;
}

static bool is_wanted(const lf_farm_job *job, const bool *wanted, int first, int stride)
{
    for (int i = first; i < first + stride && i < job->n_tasks; i++)
        if (wanted[i])
            return true;
    return false;
}

/* How many ranges of so many tasks have a wanted one. */
static int count_ranges(const lf_farm_job *job, const bool *wanted, int range)
{
    int n = 0;
    for (int i = 0; i < job->n_tasks; i += range)
        n += is_wanted(job, wanted, i, range);
    return n;
}

static int count_wanted(const bool *wanted, int n)
{
    int count = 0;
    for (int i = 0; i < n; i++)
        count += wanted[i];
    return count;
}

/* Arrays of even length with this stride. Sets out->array, from most, and out->n_arrays. */
static void divide(const lf_farm_job *job, const bool *wanted, int stride, int most, limits *out)
{
    const int n = quotient_up(job->n_tasks, stride);
    out->stride = stride;
    out->array = quotient_up(n, quotient_up(n, most));
    out->n_arrays = count_ranges(job, wanted, out->array * stride);
}

/* A cluster that is nearly full gets more tasks in each job: sbatch would wait for minutes, and
 * then fail. Each array may run at least one task at once, so slots limit the arrays, too. */
static void choose(const lf_farm_job *job, const lf_farm_batch *batch, int room, int most_array,
                   limits *out)
{
    const int n_tasks = count_wanted(batch->wanted, job->n_tasks),
              n_wanted = count_wanted(batch->wanted + job->n_tasks, job->n_finishes),
              most = room / 4 < MOST_FINISH_JOBS ? room / 4 : MOST_FINISH_JOBS,
              n_finish = n_wanted < most ? n_wanted : most, n_elements = room - n_finish;
    out->finish_stride = n_finish > 0 ? quotient_up(n_wanted, n_finish) : 1;
    int stride = n_tasks > n_elements ? quotient_up(n_tasks, n_elements) : 1;
    divide(job, batch->wanted, stride, most_array, out);
    while (count_ranges(job, batch->wanted, stride) > n_elements ||
           (batch->slots > 0 && out->n_arrays > batch->slots)) {
        stride += 1 + stride / 8;
        divide(job, batch->wanted, stride, most_array, out);
    }
}

static lf_status ask_limits(const lf_farm_job *job, const lf_farm_batch *batch, limits *out,
                            lf_error *err)
{
    lf_farm_words words = {0};
    char *text = NULL;
    int used = 0;
    lf_farm_words_add(&words, "scontrol");
    lf_farm_slurm_cluster(batch->words, &words);
    lf_farm_words_add(&words, "show");
    lf_farm_words_add(&words, "config");
    lf_status status = lf_farm_slurm_call(&words, &text, err);
    lf_farm_words_finish(&words);
    if (status == LF_OK)
        status = count_jobs(batch->words, &used, err);
    if (status == LF_OK) {
        const int room = limit_of(text, "MaxJobCount", USUAL_JOBS) - used - SPARE_JOBS;
        if (room < 4)
            status =
                lf_error_set(err, LF_E_BUSY, job->path,
                             "Slurm holds %d jobs, and takes no more now; try again later", used);
        else
            choose(job, batch, room, limit_of(text, "MaxArraySize", USUAL_ARRAY), out);
    }
    lf_free(text);
    return status;
}

/* ------------------------------------------------------------------------------------ script -- */

static const char script[] =
    "#!/bin/sh\n"
    "#SBATCH --requeue\n"
    "#SBATCH --open-mode=append\n"
    "# task.sbatch task|finish FIRST STRIDE JOB QUILTFARM ID: written and sent by quiltfarm "
    "submit.\n"
    "# Index I of the array runs the steps FIRST + I * STRIDE and the next STRIDE - 1 ones.\n"
    "# ID is of the plan: the folder may have been removed, and another job planned there.\n"
    "grep -q \"\\\"id\\\": \\\"$6\\\"\" \"$4/job.json\" || { echo \"$4: is not the job that was "
    "sent\"; exit 1; }\n"
    "first=$(($2 + ${SLURM_ARRAY_TASK_ID:-0} * $3))\n"
    "[ ! -e \"$4/" MARK "\" ] || exit 75\n"
    "\"$5\" \"$1\" \"$4\" \"$first:$((first + $3 - 1))\" &\n"
    "child=$!\n"
    "trap 'kill -TERM \"$child\" 2> /dev/null' TERM\n"
    "while :; do\n"
    "    wait \"$child\"\n"
    "    code=$?\n"
    "    kill -0 \"$child\" 2> /dev/null || break\n"
    "done\n"
    "trap - TERM\n"
    "# 75: interrupted with its state saved. It returns to the queue, unless somebody cancelled "
    "it.\n"
    "# The last task of an array has the array's own number as its job id, so the id is put "
    "together.\n"
    "if [ \"$code\" -eq 75 ] && [ ! -e \"$4/" MARK "\" ]; then\n"
    "    id=${SLURM_ARRAY_JOB_ID:+${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID}\n"
    "    id=${id:-$SLURM_JOB_ID}\n"
    "    case $(squeue --noheader --states=all --jobs=\"$id\" --format='%T %r') in\n"
    "    'COMPLETING TimeLimit') ;;\n"
    "    COMPLETING* | CANCELLED*) exit 75 ;; # by scancel\n"
    "    esac\n"
    "    scontrol requeue \"$id\" && sleep 60\n"
    "fi\n"
    "exit \"$code\"\n";

static lf_status write_script(const lf_farm_job *job, lf_error *err)
{
    char *path = lf_farm_job_path(job, "task.sbatch");
    const lf_status status =
        path ? lf_outfile_text(path, script, err) : lf_farm_no_memory(job->path, err);
    lf_free(path);
    return status;
}

/* ------------------------------------------------------------------------------------ sbatch -- */

/* The seconds before the time limit at which tasks are told to save. */
static int save_seconds(const lf_farm_job *job)
{
    const double bytes = json_number_value(json_object_get(job->plan, "state_bytes")),
                 seconds = LEAST_SAVE_SECONDS + SAVE_SECONDS_PER_GB * bytes / 1e9;
    return seconds < 3600 ? (int)seconds : 3600;
}

/* The largest demands of jobs that run so many steps each, of a range. */
static void ask_for(const lf_farm_job *job, const lf_farm_batch *batch, const int range[2],
                    int stride, lf_farm_words *words)
{
    double memory = LEAST_MEMORY, most = 0, cpu = 0;
    for (int i = range[0]; i <= range[1]; i++) {
        const lf_farm_step *s = &job->steps[i];
        cpu = (i - range[0]) % stride == 0 ? 0 : cpu;
        if (!batch->wanted[i])
            continue;
        cpu += s->cpu_seconds;
        most = cpu > most ? cpu : most;
        memory = s->memory > memory ? s->memory : memory;
    }
    const int save = save_seconds(job);
    const double minutes = LEAST_MINUTES + MORE_TIME * most / (60.0 * job->threads) +
                           (save - LEAST_SAVE_SECONDS) / 60.0;
    lf_farm_words_add(words, "--signal=B:TERM@%d", save);
    lf_farm_words_add(words, "--cpus-per-task=%d", job->threads);
    lf_farm_words_add(words, "--mem=%.0fM", MORE_MEMORY * memory / 1048576 + 1);
    if (most > 0)
        lf_farm_words_add(words, "--time=%.0f", minutes);
}

static lf_status add_script(const lf_farm_job *job, bool is_task, int first, int stride,
                            lf_farm_words *words, lf_error *err)
{
    char own[4096];
    lf_status status = lf_farm_own_program(own, sizeof own, err);
    if (status != LF_OK)
        return status;
    lf_farm_words_add(words, "%s/task.sbatch", job->path);
    lf_farm_words_add(words, "%s", is_task ? "task" : "finish");
    lf_farm_words_add(words, "%d", first);
    lf_farm_words_add(words, "%d", stride);
    lf_farm_words_add(words, "%s", job->path);
    lf_farm_words_add(words, "%s", own);
    lf_farm_words_add(words, "%s", job->id);
    return LF_OK;
}

/* LF_E_CANCELLED: quiltfarm cancel was called meanwhile. */
static lf_status check_mark(const lf_farm_job *job, lf_error *err)
{
    char *path = lf_farm_job_path(job, MARK);
    const bool is_marked = path && access(path, F_OK) == 0;
    lf_free(path);
    return is_marked ? lf_error_set(err, LF_E_CANCELLED, job->path, "was cancelled") : LF_OK;
}

/* Calls sbatch; *out_id: the job's number. Records what index I of it runs, at once: it runs even
 * if the next call fails, or this program ends. */
static lf_status call_sbatch(const lf_farm_job *job, lf_farm_words *words, int first, int stride,
                             json_t *sent, uint64_t *out_id, lf_error *err)
{
    char *text = NULL;
    lf_status status = check_mark(job, err);
    if (status == LF_OK)
        status = lf_farm_slurm_call(words, &text, err);
    if (status != LF_OK)
        return status;
    if (!lf_whole_read(text, out_id)) /* "12" or "12;CLUSTER" */
        status = lf_error_set(err, LF_E_FORMAT, "sbatch", "prints no job number: %.60s", text);
    else if (json_array_append_new(json_object_get(sent, "jobs"),
                                   json_pack("{s:I, s:i, s:i}", "id", (json_int_t)*out_id, "first",
                                             first, "stride", stride)) != 0)
        status = lf_farm_no_memory("sbatch", err);
    else
        status = lf_farm_job_write(job, "sent.json", sent, err);
    lf_free(text);
    return status;
}

static void add_common(const lf_farm_job *job, const char *log, lf_farm_words *words)
{
    char name[LF_FARM_SLURM_NAME];
    lf_farm_slurm_name(job, name);
    lf_farm_words_add(words, "sbatch");
    lf_farm_words_add(words, "--parsable");
    lf_farm_words_add(words, "--job-name=%s", name);
    lf_farm_words_add(words, "--chdir=%s", job->path);
    lf_farm_words_add(words, "--output=%s/log/%s", job->path, log);
}

/* ------------------------------------------------------------------------------------- tasks -- */

/* The wanted indices below n, "0-5,8,10-20"; caller frees (free). NULL: none, or out of memory. */
static char *index_list(const lf_farm_job *job, const bool *wanted, int first, int stride, int n)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    bool any = false;
    for (int i = 0; i < n && out; i++) {
        const int begin = i;
        if (!is_wanted(job, wanted, first + i * stride, stride))
            continue;
        while (i + 1 < n && is_wanted(job, wanted, first + (i + 1) * stride, stride))
            i++;
        (void)fprintf(out, "%s%d", any ? "," : "", begin);
        if (i > begin)
            (void)fprintf(out, "-%d", i);
        any = true;
    }
    if (!out || fclose(out) != 0 || !any) {
        free(text);
        return NULL;
    }
    return text;
}

/* Jobs of the queue of one submission. */
typedef struct arrays {
    limits limits;
    uint64_t *ids;      /* per array; 0: it has no wanted task */
    uint64_t *finishes; /* per finish; 0: not sent */
    int n, n_sent;
} arrays;

static lf_status send_array(const lf_farm_job *job, const lf_farm_batch *batch, arrays *a,
                            int number, json_t *sent, lf_error *err)
{
    const int first = number * a->limits.array * a->limits.stride;
    const int left = quotient_up(job->n_tasks - first, a->limits.stride);
    const int n = left < a->limits.array ? left : a->limits.array;
    const int last = first + n * a->limits.stride - 1,
              n_arrays = a->limits.n_arrays > 0 ? a->limits.n_arrays : 1;
    const int range[2] = {first, last < job->n_tasks ? last : job->n_tasks - 1};
    lf_farm_words words = {0};
    char *list = index_list(job, batch->wanted, first, a->limits.stride, n);
    if (!list)
        return LF_OK;
    add_common(job, "slurm_%A_%a.log", &words);
    if (batch->slots > 0) /* the arrays share the slots */
        lf_farm_words_add(&words, "--array=%s%%%d", list,
                          batch->slots / n_arrays + (a->n_sent < batch->slots % n_arrays));
    else
        lf_farm_words_add(&words, "--array=%s", list);
    free(list);
    a->n_sent++;
    ask_for(job, batch, range, a->limits.stride, &words);
    lf_farm_words_add_list(&words, batch->words);
    lf_status status = add_script(job, true, first, a->limits.stride, &words, err);
    if (status == LF_OK)
        status = call_sbatch(job, &words, first, a->limits.stride, sent, &a->ids[number], err);
    lf_farm_words_finish(&words);
    return status;
}

static lf_status send_arrays(const lf_farm_job *job, const lf_farm_batch *batch, json_t *sent,
                             arrays *out, lf_error *err)
{
    lf_status status = ask_limits(job, batch, &out->limits, err);
    if (status != LF_OK)
        return status;
    const int covered = out->limits.array * out->limits.stride;
    out->n = quotient_up(job->n_tasks, covered);
    out->ids = lf_calloc((size_t)out->n, sizeof *out->ids);
    out->finishes = lf_calloc((size_t)job->n_finishes, sizeof *out->finishes);
    if (!out->ids || !out->finishes)
        return lf_farm_no_memory(job->path, err);
    for (int i = 0; i < out->n && status == LF_OK; i++)
        status = send_array(job, batch, out, i, sent, err);
    return status;
}

/* ---------------------------------------------------------------------------------- finishes -- */

/* Prints ":12_3:12_4" for the sent tasks first to last; ":12" for whole arrays. */
static void print_tasks(const lf_farm_job *job, const lf_farm_batch *batch, const arrays *a,
                        const int tasks[2], FILE *out)
{
    const int stride = a->limits.stride, covered = a->limits.array * stride;
    const bool all = tasks[0] == 0 && tasks[1] == job->n_tasks - 1;
    for (int i = tasks[0]; i <= tasks[1]; i += all ? covered - i % covered : stride - i % stride) {
        const int array = i / covered, begin = i - i % stride;
        if (a->ids[array] == 0 || (!all && !is_wanted(job, batch->wanted, begin, stride)))
            continue;
        (void)fprintf(out, ":%llu", (unsigned long long)a->ids[array]);
        if (!all)
            (void)fprintf(out, "_%d", (begin - array * covered) / stride);
    }
}

/* Prints ":12:13" for the sent finishes that a closing one needs. */
static void print_finishes(const lf_farm_job *job, const arrays *a, int finish, FILE *out)
{
    const lf_farm_step *s = &job->steps[finish];
    uint64_t before = 0;
    for (int i = s->tasks[0]; i <= s->tasks[1]; i++) {
        const int needed = lf_farm_step_needed(job, finish, i);
        const uint64_t id = needed >= job->n_tasks ? a->finishes[needed - job->n_tasks] : 0;
        if (id != 0 && id != before)
            (void)fprintf(out, ":%llu", (unsigned long long)id);
        before = id;
    }
}

/* Adds --dependency for what finishes need, if it is sent. tasks: of all these finishes. */
static void add_dependency(const lf_farm_job *job, const lf_farm_batch *batch, const arrays *a,
                           int finish, const int tasks[2], lf_farm_words *words)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out && job->steps[finish].closes)
        print_finishes(job, a, finish, out);
    else if (out)
        print_tasks(job, batch, a, tasks, out);
    if (!out || fclose(out) != 0)
        words->failed = true;
    else if (size > 0) {
        lf_farm_words_add(words, "--dependency=afterok%s", text);
        lf_farm_words_add(words, "--kill-on-invalid-dep=yes");
    }
    free(text);
}

static lf_status send_finishes(const lf_farm_job *job, const lf_farm_batch *batch, const arrays *a,
                               int first, int last, json_t *sent, lf_error *err)
{
    int tasks[2] = {job->n_tasks, -1};
    lf_farm_words words = {0};
    uint64_t id = 0;
    for (int i = first; i <= last; i++) {
        if (!batch->wanted[i])
            continue;
        tasks[0] = job->steps[i].tasks[0] < tasks[0] ? job->steps[i].tasks[0] : tasks[0];
        tasks[1] = job->steps[i].tasks[1] > tasks[1] ? job->steps[i].tasks[1] : tasks[1];
    }
    if (tasks[1] < 0)
        return LF_OK;
    add_common(job, "slurm_%j.log", &words);
    add_dependency(job, batch, a, first, tasks, &words);
    ask_for(job, batch, (int[]){first, last}, last - first + 1, &words);
    lf_farm_words_add_list(&words, batch->words);
    lf_status status = add_script(job, false, first - job->n_tasks, last - first + 1, &words, err);
    if (status == LF_OK)
        status = call_sbatch(job, &words, first, last - first + 1, sent, &id, err);
    for (int i = first; i <= last; i++)
        a->finishes[i - job->n_tasks] = id;
    lf_farm_words_finish(&words);
    return status;
}

/* The end of the finishes from first that one job makes: so many wanted ones. */
static int end_of_finishes(const lf_farm_job *job, const lf_farm_batch *batch, int first, int most)
{
    int next = first + 1, n = batch->wanted[first];
    for (; next < job->n_tasks + job->n_finishes && !job->steps[next].closes; next++) {
        n += batch->wanted[next];
        if (n > most)
            break;
    }
    return next;
}

static lf_status remove_mark(const lf_farm_job *job, lf_error *err)
{
    char *path = lf_farm_job_path(job, MARK);
    lf_status status = path ? LF_OK : lf_farm_no_memory(job->path, err);
    if (path && unlink(path) != 0 && access(path, F_OK) == 0)
        status = lf_error_set(err, LF_E_IO, path, "cannot be removed");
    lf_free(path);
    return status;
}

static lf_status send_slurm(lf_farm_job *job, const lf_farm_batch *batch, json_t *sent,
                            lf_error *err)
{
    const int end = job->n_tasks + job->n_finishes;
    arrays a = {0};
    char name[LF_FARM_SLURM_NAME];
    lf_status status = lf_farm_slurm_check_words(batch->words, err);
    if (status == LF_OK)
        status = remove_mark(job, err);
    if (status == LF_OK)
        status = write_script(job, err);
    if (status == LF_OK)
        status = send_arrays(job, batch, sent, &a, err);
    for (int i = job->n_tasks, next; i < end && status == LF_OK; i = next) {
        next = end_of_finishes(job, batch, i, a.limits.finish_stride);
        status = send_finishes(job, batch, &a, i, next - 1, sent, err);
    }
    lf_free(a.finishes);
    lf_free(a.ids);
    lf_farm_slurm_name(job, name);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "%s: sent to Slurm as %s; see quiltfarm status", job->path, name);
    return status;
}

/* -------------------------------------------------------------------------------------- look -- */

/* The next word of a line, ended in place; "" at the end. */
static char *next_word(char **line)
{
    char *word = *line + strspn(*line, " ");
    char *end = word + strcspn(word, " \n");
    *line = *end == ' ' ? end + 1 : end;
    *end = '\0';
    return word;
}

static const json_t *record_of(const json_t *sent, uint64_t id)
{
    const json_t *record;
    size_t i;
    json_array_foreach(json_object_get(sent, "jobs"), i,
                       record) if ((uint64_t)json_integer_value(json_object_get(record, "id")) ==
                                   id) return record;
    return NULL;
}

/* Reasons for which nobody has to do anything. */
static bool is_usual(const char *reason)
{
    static const char *const usual[] = {"None",       "Priority",  "Resources",
                                        "Dependency", "BeginTime", "JobArrayTaskLimit",
                                        "Cleaning",   "Prolog",    ""};
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++)
        if (strcmp(reason, usual[i]) == 0)
            return true;
    return false;
}

/* Reasons that a job asks for more than a node has. */
static bool is_of_nodes(const char *reason)
{
    return strcmp(reason, "PartitionConfig") == 0 || strcmp(reason, "BadConstraints") == 0;
}

/* "12 3 RUNNING None": number of the array, index, state, reason. */
static void take_line(const lf_farm_job *job, const json_t *sent, char *line, lf_farm_queue *out)
{
    uint64_t id = 0, index = 0;
    if (!lf_whole_is(next_word(&line), &id))
        return; /* "CLUSTER: name" */
    const char *at = next_word(&line), *state = next_word(&line), *reason = line;
    const json_t *record = record_of(sent, id);
    const bool runs = strcmp(state, "PENDING") != 0;
    if (!lf_whole_is(at, &index) || index > 1000000)
        index = 0;
    if (runs)
        out->n_running++;
    else
        out->n_queued++;
    const int stride = (int)json_integer_value(json_object_get(record, "stride")),
              first =
                  (int)json_integer_value(json_object_get(record, "first")) + (int)index * stride;
    for (int i = first; i < first + stride; i++)
        if ((i < job->n_tasks) == (first < job->n_tasks))
            lf_farm_queue_place(job, out, i, runs ? LF_FARM_RUNNING : LF_FARM_QUEUED);
    if (!runs && !is_usual(reason))
        snprintf(out->note, sizeof out->note, "Slurm keeps %llu_%s waiting: %s%s",
                 (unsigned long long)id, at, reason,
                 is_of_nodes(reason) ? "; do its nodes have the processors of --threads?" : "");
}

static lf_status look_slurm(const lf_farm_job *job, const json_t *sent, lf_farm_queue *out,
                            lf_error *err)
{
    char name[LF_FARM_SLURM_NAME];
    char *text = NULL;
    lf_farm_words words = {0};
    lf_farm_slurm_name(job, name);
    lf_farm_words_add(&words, "squeue");
    lf_farm_words_add(&words, "--noheader");
    lf_farm_words_add(&words, "--array");
    lf_farm_slurm_sent_cluster(sent, &words);
    lf_farm_words_add(&words, "--name=%s", name);
    lf_farm_words_add(&words, "--user=%ld,%ld", (long)lf_farm_slurm_owner(sent), (long)getuid());
    lf_farm_words_add(&words, "--format=%%F %%K %%T %%r");
    const lf_status status = lf_farm_slurm_call(&words, &text, err);
    lf_farm_words_finish(&words);
    for (char *line = text, *end; line && *line; line = end) {
        end = line + strcspn(line, "\n");
        if (*end)
            *end++ = '\0';
        take_line(job, sent, line, out);
    }
    lf_free(text);
    return status;
}

/* LF_E_BUSY: Slurm has jobs of a folder that was removed. */
static lf_status check_slurm(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    lf_farm_words older = {0};
    lf_status status = lf_farm_slurm_older(job, sent, &older, err);
    if (status == LF_OK && older.n > 0)
        status = lf_error_set(err, LF_E_BUSY, job->path,
                              "Slurm still has %s of an older plan; quiltfarm cancel ends it",
                              older.list[0]);
    lf_farm_words_finish(&older);
    return status;
}

/* ------------------------------------------------------------------------------------ cancel -- */

static lf_status end_named(const char *name, const json_t *sent, lf_error *err)
{
    char *text = NULL;
    lf_farm_words words = {0};
    lf_farm_words_add(&words, "scancel");
    lf_farm_slurm_sent_cluster(sent, &words);
    lf_farm_words_add(&words, "--name=%s", name);
    lf_farm_words_add(&words, "--user=%ld", (long)lf_farm_slurm_owner(sent));
    const lf_status status = lf_farm_slurm_call(&words, &text, err);
    lf_farm_words_finish(&words);
    lf_free(text);
    return status;
}

static lf_status end_all(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    char name[LF_FARM_SLURM_NAME];
    char *mark = lf_farm_job_path(job, MARK);
    const lf_status status = mark ? lf_outfile_text(mark, "by quiltfarm cancel\n", err)
                                  : lf_farm_no_memory(job->path, err);
    lf_free(mark);
    lf_farm_slurm_name(job, name);
    return status == LF_OK ? end_named(name, sent, err) : status;
}

/* Ends jobs of older plans of the folder. LF_E_STATE: there is none, and this one was not sent. */
static lf_status end_older(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    lf_farm_words older = {0};
    lf_status status = lf_farm_slurm_older(job, sent, &older, err);
    if (status == LF_OK && older.n == 0 && !sent)
        status = lf_error_set(err, LF_E_STATE, job->path, "was not submitted");
    for (int i = 0; i < older.n && status == LF_OK; i++) {
        lf_log(LF_LOG_INFO, "%s: an older plan is cancelled, %s", job->path, older.list[i]);
        status = end_named(older.list[i], sent, err);
    }
    lf_farm_words_finish(&older);
    return status;
}

/* A submission may be on its way: it ends at the mark, and what it sent meanwhile is ended then. A
 * task that begins or is interrupted later finds the mark. */
static lf_status cancel_slurm(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    if (lf_farm_slurm_owner(sent) != getuid() && getuid() != 0)
        return lf_error_set(err, LF_E_STATE, job->path,
                            "was submitted by user %ld, who has to cancel it",
                            (long)lf_farm_slurm_owner(sent));
    lf_status status = end_older(job, sent, err);
    if (status != LF_OK || !sent)
        return status;
    status = end_all(job, sent, err);
    int n = 0;
    while (status == LF_OK && n < MOST_WAIT_TENTHS && lf_farm_job_is_locked(job)) {
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
        n++;
    }
    if (n > 0 && status == LF_OK)
        status = end_all(job, sent, err);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "%s: cancelled; running tasks save first, see quiltfarm status",
               job->path);
    return status;
}

const lf_farm_engine lf_farm_slurm = {.name = "slurm",
                                      .send = send_slurm,
                                      .look = look_slurm,
                                      .check = check_slurm,
                                      .cancel = cancel_slurm};
