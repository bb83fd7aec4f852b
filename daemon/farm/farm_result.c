#include "daemon/farm/farm_result.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/escape.h"
#include "base/file.h"
#include "base/log.h"
#include "base/number.h"
#include "base/version.h"
#include "daemon/farm/farm_file.h"

/* The files of a step, as bits and by their endings. */
enum { RECEIPT = 1, FAILED = 2, COST = 4, RUNNING = 8, ALL = 15 };
static const char *const endings[] = {".json", ".failed", ".cost", ".running"};
enum { N_ENDINGS = sizeof endings / sizeof *endings };

static char *file_of(const lf_farm_job *job, int step, int bit, char name[64])
{
    char base[LF_FARM_STEP_NAME];
    int i = 0;
    while (!(bit & 1 << i))
        i++;
    snprintf(name, 64, "done/%s%s", lf_farm_step_name(job, step, base), endings[i]);
    return name;
}

/* A file's object; NULL: missing or damaged. */
static json_t *object_of(const lf_farm_job *job, int step, int bit)
{
    char name[64];
    json_t *object = NULL;
    return lf_farm_job_read(job, file_of(job, step, bit, name), &object, NULL) == LF_OK ? object
                                                                                        : NULL;
}

static void remove_file(const lf_farm_job *job, int step, int bit)
{
    char name[64];
    char *path = lf_farm_job_path(job, "%s", file_of(job, step, bit, name));
    if (path)
        (void)unlink(path);
    lf_free(path);
}

/* -------------------------------------------------------------------------------------- read -- */

/* A file of a receipt is there with its size. */
static bool is_there(const lf_farm_job *job, const json_t *file)
{
    return lf_farm_file_compare(job->folder, file, false) == LF_FARM_FILE_SAME;
}

static bool is_complete(const lf_farm_job *job, int step)
{
    json_t *receipt = object_of(job, step, RECEIPT);
    const json_t *files = json_object_get(receipt, "files"), *file;
    bool is = json_is_array(files);
    size_t i;
    json_array_foreach(files, i, file) is = is && is_there(job, file);
    json_decref(receipt);
    return is;
}

static void copy_text(char *out, size_t size, const json_t *text)
{
    lf_escape(out, size, json_is_string(text) ? json_string_value(text) : ""); /* for terminals */
}

static void read_failed(const lf_farm_job *job, int step, lf_farm_result *out)
{
    json_t *failed = object_of(job, step, FAILED);
    out->failures = (int)json_integer_value(json_object_get(failed, "failures"));
    out->failures = failed && out->failures < 1 ? 1 : out->failures;
    out->is_given_up =
        json_is_true(json_object_get(failed, "given_up")) || out->failures >= LF_FARM_MOST_FAILURES;
    copy_text(out->words, sizeof out->words, json_object_get(failed, "words"));
    json_decref(failed);
}

static void read_cost(const lf_farm_job *job, int step, lf_farm_result *out)
{
    json_t *cost = object_of(job, step, COST);
    out->cpu_seconds = json_number_value(json_object_get(cost, "cpu_seconds"));
    out->seconds = json_number_value(json_object_get(cost, "seconds"));
    json_decref(cost);
}

/* True if the process was on this machine and is no more: it was killed. */
static bool is_killed(const json_t *running)
{
    const char *there = json_string_value(json_object_get(running, "host"));
    const pid_t pid = (pid_t)json_integer_value(json_object_get(running, "pid"));
    char host[64] = "";
    (void)gethostname(host, sizeof host - 1);
    return there && strcmp(there, host) == 0 && pid > 0 && kill(pid, 0) != 0 && errno == ESRCH;
}

static void read_running(const lf_farm_job *job, int step, lf_farm_result *out)
{
    char name[64];
    struct stat found;
    char *path = lf_farm_job_path(job, "%s", file_of(job, step, RUNNING, name));
    if (path && stat(path, &found) == 0) {
        json_t *running = object_of(job, step, RUNNING);
        out->silent = difftime(time(NULL), found.st_mtime);
        out->is_lost = out->silent > LF_FARM_SILENT_SECONDS || is_killed(running);
        out->is_running = !out->is_lost;
        copy_text(out->host, sizeof out->host, json_object_get(running, "host"));
        json_decref(running);
    }
    lf_free(path);
}

/* bits: files of the step that may be there. */
static void read_result(const lf_farm_job *job, int step, int bits, lf_farm_result *out)
{
    *out = (lf_farm_result){.complete = bits & RECEIPT && is_complete(job, step)};
    if (bits & COST)
        read_cost(job, step, out);
    if (bits & FAILED && !out->complete)
        read_failed(job, step, out);
    if (bits & RUNNING && !out->complete)
        read_running(job, step, out);
}

/* A task of a complete finish is complete: its states have been removed. */
static void complete_by_finish(lf_farm_result *out)
{
    *out = (lf_farm_result){
        .complete = true, .cpu_seconds = out->cpu_seconds, .seconds = out->seconds};
}

lf_status lf_farm_result_read(const lf_farm_job *job, int step, lf_farm_result *out, lf_error *err)
{
    const int finish = job->steps[step].finish;
    (void)err;
    read_result(job, step, ALL, out);
    if (!out->complete && finish >= 0 && is_complete(job, finish))
        complete_by_finish(out);
    return LF_OK;
}

/* The step and the bit of a name in done/; false: it is another file. */
static bool read_name(const lf_farm_job *job, const char *name, int *out_step, int *out_bit)
{
    const bool is_task = strncmp(name, "task_", 5) == 0;
    uint64_t number;
    const char *end = is_task || strncmp(name, "finish_", 7) == 0
                          ? lf_whole_read(name + (is_task ? 5 : 7), &number)
                          : NULL;
    if (!end || number >= (uint64_t)(is_task ? job->n_tasks : job->n_finishes))
        return false;
    for (int i = 0; i < N_ENDINGS; i++)
        if (strcmp(end, endings[i]) == 0) {
            *out_step = (int)number + (is_task ? 0 : job->n_tasks);
            *out_bit = 1 << i;
            return true;
        }
    return false;
}

static lf_status read_names(const lf_farm_job *job, unsigned char *bits, lf_error *err)
{
    char *path = lf_farm_job_path(job, "done");
    DIR *folder = path ? opendir(path) : NULL;
    const int why = errno;
    lf_free(path);
    if (!folder)
        return lf_error_set(err, LF_E_IO, job->path, "its folder done cannot be read: %s",
                            lf_errno_text(why));
    for (const struct dirent *entry; (entry = readdir(folder));) {
        int step, bit;
        if (read_name(job, entry->d_name, &step, &bit))
            bits[step] = (unsigned char)(bits[step] | bit);
    }
    closedir(folder);
    return LF_OK;
}

lf_status lf_farm_results_read(const lf_farm_job *job, lf_farm_result **out, lf_error *err)
{
    const int n = job->n_tasks + job->n_finishes;
    lf_farm_result *results = lf_calloc((size_t)n, sizeof *results);
    unsigned char *bits = lf_calloc((size_t)n, 1);
    lf_status status =
        results && bits ? read_names(job, bits, err) : lf_farm_no_memory(job->path, err);
    for (int i = n - 1; i >= 0 && status == LF_OK; i--) { /* finishes first */
        const int finish = job->steps[i].finish;
        const bool is_finished = finish >= 0 && results[finish].complete;
        read_result(job, i, is_finished ? bits[i] & COST : bits[i], &results[i]);
        if (is_finished)
            complete_by_finish(&results[i]);
    }
    lf_free(bits);
    if (status == LF_OK)
        *out = results;
    else
        lf_free(results);
    return status;
}

/* ------------------------------------------------------------------------------------- write -- */

/* What cannot be written is missed by a reader of status, and by nothing else. False: so it is. */
static bool write_object(const lf_farm_job *job, int step, int bit, json_t *object)
{
    char name[64];
    const bool is_written =
        object && lf_farm_job_write(job, file_of(job, step, bit, name), object, NULL) == LF_OK;
    if (object && !is_written)
        remove_file(job, step, bit);
    json_decref(object);
    return is_written;
}

static lf_status add_state(const lf_farm_job *job, int step, int field, json_t *files,
                           lf_error *err)
{
    char *path = lf_farm_step_state(job, step, field);
    struct stat found;
    lf_status status = path ? LF_OK : lf_farm_no_memory(job->path, err);
    if (path && stat(path, &found) != 0)
        status = lf_error_set(err, LF_E_IO, path, "is missing, though its task ended well");
    else if (path && json_array_append_new(files, json_pack("{s:s, s:I}", "name", path, "bytes",
                                                            (json_int_t)found.st_size)) != 0)
        status = lf_farm_no_memory(job->path, err);
    lf_free(path);
    return status;
}

lf_status lf_farm_result_receipt(const lf_farm_job *job, int step, lf_error *err)
{
    int fields[2];
    json_t *files = json_array(),
           *receipt = json_pack("{s:s, s:O?}", "quiltd", LF_VERSION, "files", files);
    lf_status status = files && receipt ? LF_OK : lf_farm_no_memory(job->path, err);
    char name[64];
    lf_farm_step_fields(job, step, fields);
    for (int field = fields[0]; field <= fields[1] && status == LF_OK; field++)
        status = add_state(job, step, field, files, err);
    if (status == LF_OK)
        status = lf_farm_job_write(job, file_of(job, step, RECEIPT, name), receipt, err);
    json_decref(receipt);
    json_decref(files);
    return status;
}

void lf_farm_result_revoke(const lf_farm_job *job, int step)
{
    remove_file(job, step, RECEIPT);
}

void lf_farm_result_begin(const lf_farm_job *job, int step)
{
    char host[64] = "";
    (void)gethostname(host, sizeof host - 1);
    (void)write_object(job, step, RUNNING,
                       json_pack("{s:s, s:I}", "host", host, "pid", (json_int_t)getpid()));
}

/* A full disk is as full for the next run. */
static bool is_of_disk(const char *words)
{
    return strstr(words, "No space left on device") || strstr(words, "Disk quota exceeded");
}

static bool write_failed(const lf_farm_job *job, int step, int failures, bool given_up,
                         const char *words)
{
    return write_object(
        job, step, FAILED,
        json_pack("{s:i, s:b, s:s}", "failures", failures, "given_up", given_up, "words", words));
}

void lf_farm_result_end(const lf_farm_job *job, int step, double cpu_seconds, double seconds,
                        const char *words, bool gives_up)
{
    lf_farm_result before = {0};
    read_cost(job, step, &before);
    read_failed(job, step, &before);
    (void)write_object(job, step, COST,
                       json_pack("{s:f, s:f}", "cpu_seconds", before.cpu_seconds + cpu_seconds,
                                 "seconds", before.seconds + seconds));
    if (words)
        (void)write_failed(job, step, before.failures + 1, gives_up || is_of_disk(words), words);
    remove_file(job, step, RUNNING);
}

void lf_farm_result_abandon(const lf_farm_job *job, int step, lf_farm_result *result)
{
    const char *words = "was killed without a word, perhaps because memory was short";
    if (write_failed(job, step, result->failures + 1, result->is_given_up, words))
        result->failures++;
    result->is_given_up |= result->failures >= LF_FARM_MOST_FAILURES;
    remove_file(job, step, RUNNING);
    result->is_running = result->is_lost = false;
}

void lf_farm_result_forgive(const lf_farm_job *job, int step)
{
    remove_file(job, step, FAILED);
}

/* -------------------------------------------------------------------------------------- tidy -- */

static void remove_states(const lf_farm_job *job, int step)
{
    int fields[2];
    lf_farm_step_fields(job, step, fields);
    for (int field = fields[0]; field <= fields[1]; field++) {
        char *path = lf_farm_step_state(job, step, field);
        if (path)
            (void)unlink(path);
        lf_free(path);
    }
}

void lf_farm_result_tidy(const lf_farm_job *job, int step)
{
    const lf_farm_step *s = &job->steps[step];
    if (s->rows[0] < 0)
        remove_states(job, step);
    for (int i = s->tasks[0]; step >= job->n_tasks && i <= s->tasks[1]; i++)
        remove_states(job, i);
}

/* seen: an object whose keys are the names so far. */
static void add_name(const lf_farm_job *job, const json_t *file, bool if_differing, json_t *seen,
                     json_t *names)
{
    const char *name = json_string_value(json_object_get(file, "name"));
    char *path = name ? lf_path_join(job->folder, name) : NULL;
    if (path && !json_object_get(seen, path)) {
        json_object_set_new(seen, path, json_true());
        const lf_farm_file found =
            if_differing ? lf_farm_file_compare(job->folder, file, true) : LF_FARM_FILE_SAME;
        if (found == LF_FARM_FILE_UNREADABLE)
            lf_log(LF_LOG_WARNING, "%s: cannot be read", path);
        if (!if_differing || found == LF_FARM_FILE_OTHER_BYTES || found == LF_FARM_FILE_UNREADABLE)
            json_array_append_new(names, json_string(path));
    }
    lf_free(path);
}

/* Steps that make output files: no states, and no frames to be joined. */
static bool makes_output(const lf_farm_job *job, int step)
{
    return job->steps[step].rows[0] < 0 && (step >= job->n_tasks || !job->join);
}

/* results NULL: those that differ, of all steps. */
static json_t *list_files(const lf_farm_job *job, const lf_farm_result *results)
{
    json_t *names = json_array(), *seen = json_object();
    for (int i = 0; names && i < job->n_tasks + job->n_finishes; i++) {
        if ((results && !results[i].complete) || !makes_output(job, i))
            continue;
        json_t *receipt = object_of(job, i, RECEIPT), *file;
        size_t at;
        json_array_foreach(json_object_get(receipt, "files"), at, file)
            add_name(job, file, !results, seen, names);
        json_decref(receipt);
    }
    json_decref(seen);
    return names;
}

json_t *lf_farm_result_files(const lf_farm_job *job, const lf_farm_result *results)
{
    return list_files(job, results);
}

json_t *lf_farm_result_differing(const lf_farm_job *job)
{
    return list_files(job, NULL);
}
