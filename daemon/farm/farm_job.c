#include "daemon/farm/farm_job.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "base/log.h"
#include "base/number.h"
#include "base/version.h"
#include "daemon/farm/farm_engine.h"

#define MOST_STEPS 1000000
#define MOST_JSON ((uint64_t)256 << 20)

/* ------------------------------------------------------------------------------------- names -- */

char *lf_farm_job_path(const lf_farm_job *job, const char *format, ...)
{
    va_list args;
    char name[256];
    va_start(args, format);
    (void)vsnprintf(name, sizeof name, format, args);
    va_end(args);
    return lf_path_join(job->path, name);
}

void lf_farm_job_words(const lf_farm_job *job, const json_t *texts, size_t first,
                       lf_farm_words *words)
{
    const char *frames = json_string_value(json_object_get(job->plan, "frames_output"));
    for (size_t i = first; i < json_array_size(texts); i++) {
        const char *word = json_string_value(json_array_get(texts, i));
        if (frames && strcmp(word, frames) == 0)
            lf_farm_words_add(words, "%s/%s", job->path, word);
        else
            lf_farm_words_add(words, "%s", word);
    }
}

static const char *step_words(const lf_farm_job *job, int step, char between,
                              char buf[LF_FARM_STEP_NAME])
{
    const bool is_task = step < job->n_tasks;
    snprintf(buf, LF_FARM_STEP_NAME, "%s%c%d", is_task ? "task" : "finish", between,
             is_task ? step : step - job->n_tasks);
    return buf;
}

const char *lf_farm_step_name(const lf_farm_job *job, int step, char buf[LF_FARM_STEP_NAME])
{
    return step_words(job, step, '_', buf);
}

const char *lf_farm_step_text(const lf_farm_job *job, int step, char buf[LF_FARM_STEP_NAME])
{
    return step_words(job, step, ' ', buf);
}

lf_status lf_farm_read_steps(const char *text, int n, int out[2], lf_error *err)
{
    uint64_t first, last;
    const char *end = lf_whole_read(text, &first);
    last = first;
    if (end && *end == ':')
        end = lf_whole_read(end + 1, &last);
    if (!end || *end != '\0' || last < first)
        return lf_error_set(err, LF_E_ARG, text, "is no number of a step, such as 3 or 3:7");
    if (first >= (uint64_t)n)
        return lf_error_set(err, LF_E_ARG, text, "is not a step: the job has %d, from 0", n);
    out[0] = (int)first;
    out[1] = last < (uint64_t)n ? (int)last : n - 1;
    return LF_OK;
}

int lf_farm_step_needed(const lf_farm_job *job, int finish, int task)
{
    const int own = job->steps[task].finish;
    return job->steps[finish].closes && own >= 0 && own != finish ? own : task;
}

void lf_farm_step_fields(const lf_farm_job *job, int step, int out[2])
{
    const lf_farm_step *s = &job->steps[step];
    const int *fields = s->fields[0] >= 0 ? s->fields : job->fields;
    out[0] = fields[0];
    out[1] = fields[1];
}

char *lf_farm_step_state(const lf_farm_job *job, int step, int field)
{
    char name[LF_FARM_STEP_NAME];
    lf_farm_step_name(job, step, name);
    return field < 0 ? lf_farm_job_path(job, "states/%s.lfstate", name)
                     : lf_farm_job_path(job, "states/%s_%04d.lfstate", name, field);
}

lf_status lf_farm_own_program(char *buf, size_t size, lf_error *err)
{
    const ssize_t n = readlink("/proc/self/exe", buf, size - 1);
    if (n <= 0 || (size_t)n >= size - 1)
        return lf_error_set(err, LF_E_IO, "/proc/self/exe", "cannot be read");
    buf[n] = '\0';
    if (strpbrk(buf, "\n\r"))
        return lf_error_set(err, LF_E_IO, buf, "has a line end in its name; install it elsewhere");
    return LF_OK;
}

lf_status lf_farm_step_command(const lf_farm_job *job, int first, int last, char **out,
                               lf_error *err)
{
    const bool is_task = first < job->n_tasks;
    const int from = is_task ? 0 : job->n_tasks;
    char own[4096], text[4 * 2 * sizeof own];
    lf_status status = lf_farm_own_program(own, sizeof own, err);
    if (status != LF_OK)
        return status;
    char *program = lf_farm_quoted(own), *path = lf_farm_quoted(job->path);
    if (program && path)
        snprintf(text, sizeof text, first == last ? "%s %s %s %d" : "%s %s %s %d:%d", program,
                 is_task ? "task" : "finish", path, first - from, last - from);
    *out = program && path ? lf_strdup(text) : NULL;
    lf_free(program);
    lf_free(path);
    return *out ? LF_OK : lf_farm_no_memory(job->path, err);
}

/* -------------------------------------------------------------------------------------- JSON -- */

lf_status lf_farm_job_read(const lf_farm_job *job, const char *name, json_t **out, lf_error *err)
{
    char *path = lf_farm_job_path(job, "%s", name), *text = NULL;
    size_t size = 0;
    json_error_t why;
    lf_status status = path ? LF_OK : lf_farm_no_memory(job->path, err);
    *out = NULL;
    if (status == LF_OK && access(path, F_OK) == 0)
        status = lf_file_read(path, NULL, MOST_JSON, &text, &size, err);
    if (text) {
        *out = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
        if (!json_is_object(*out)) {
            json_decref(*out);
            *out = NULL;
            status = lf_error_set(err, LF_E_FORMAT, path, "is damaged; remove it");
        }
    }
    lf_free(text);
    lf_free(path);
    return status;
}

lf_status lf_farm_job_write(const lf_farm_job *job, const char *name, const json_t *object,
                            lf_error *err)
{
    char *path = lf_farm_job_path(job, "%s", name);
    char *text = object ? json_dumps(object, JSON_INDENT(1)) : NULL;
    const lf_status status =
        path && text ? lf_outfile_text(path, text, err) : lf_farm_no_memory(job->path, err);
    free(text);
    lf_free(path);
    return status;
}

/* -------------------------------------------------------------------------------------- plan -- */

static lf_status bad_plan(const char *where, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, where, "is no plan of this version: %s; plan again",
                        what);
}

/* "KEY": [a, b] with 0 <= a <= b <= most, or null. */
static bool read_range(const json_t *step, const char *key, int most, int out[2])
{
    const json_t *range = json_object_get(step, key);
    json_int_t ends[2] = {-1, -1};
    if (range && !json_is_null(range)) {
        if (json_array_size(range) != 2)
            return false;
        for (size_t i = 0; i < 2; i++) {
            ends[i] = json_integer_value(json_array_get(range, i));
            if (!json_is_integer(json_array_get(range, i)) || ends[i] < 0 || ends[i] > most)
                return false;
        }
    }
    out[0] = (int)ends[0];
    out[1] = (int)ends[1];
    return ends[0] <= ends[1];
}

static bool read_step(const json_t *json, int n_tasks, lf_farm_step *out)
{
    const json_t *cpu = json_object_get(json, "cpu_seconds"),
                 *memory = json_object_get(json, "memory");
    out->finish = -1;
    out->cpu_seconds = json_number_value(cpu);
    out->memory = json_number_value(memory);
    return read_range(json, "fields", MOST_STEPS, out->fields) &&
           read_range(json, "rows", MOST_STEPS, out->rows) &&
           read_range(json, "tasks", n_tasks - 1, out->tasks) && out->cpu_seconds >= 0 &&
           out->memory >= 0;
}

/* The first finish that names a task gets its states. One that names only tasks of others closes
 * the job. */
static void join_tasks(lf_farm_job *job, int finish)
{
    lf_farm_step *step = &job->steps[finish];
    step->closes = true;
    for (int i = step->tasks[0]; i <= step->tasks[1]; i++)
        if (job->steps[i].finish < 0) {
            job->steps[i].finish = finish;
            step->closes = false;
        }
}

static lf_status read_steps(lf_farm_job *job, lf_error *err)
{
    const json_t *tasks = json_object_get(job->plan, "tasks"),
                 *finishes = json_object_get(job->plan, "finishes");
    const size_t n_tasks = json_array_size(tasks), n_finishes = json_array_size(finishes);
    if (n_tasks == 0 || n_tasks > MOST_STEPS || n_finishes > MOST_STEPS)
        return bad_plan(job->path, "it has no tasks, or too many", err);
    job->steps = lf_calloc(n_tasks + n_finishes, sizeof *job->steps);
    if (!job->steps)
        return lf_farm_no_memory(job->path, err);
    job->n_tasks = (int)n_tasks;
    job->n_finishes = (int)n_finishes;
    for (int i = 0; i < job->n_tasks + job->n_finishes; i++) {
        lf_farm_step *step = &job->steps[i];
        const bool is_task = i < job->n_tasks;
        const json_t *json = is_task ? json_array_get(tasks, (size_t)i)
                                     : json_array_get(finishes, (size_t)(i - job->n_tasks));
        if (!read_step(json, job->n_tasks, step) || (step->fields[0] >= 0 && !job->field_option) ||
            (!is_task && step->tasks[0] < 0))
            return bad_plan(job->path, "a step is not complete", err);
        if (!is_task)
            join_tasks(job, i);
    }
    return LF_OK;
}

static bool are_words(const json_t *list)
{
    for (size_t i = 0; i < json_array_size(list); i++)
        if (!json_is_string(json_array_get(list, i)))
            return false;
    return json_is_array(list);
}

/* True if words have an option, in full or abbreviated. */
static bool have_option(const json_t *words, const char *option)
{
    for (size_t i = 0; i < json_array_size(words); i++) {
        const char *word = json_string_value(json_array_get(words, i));
        const size_t n = strcspn(word, "=");
        if (strcmp(word, "--") == 0)
            return false;
        if (n > 2 && strncmp(word, option, n) == 0)
            return true;
    }
    return false;
}

static lf_status read_plan(lf_farm_job *job, lf_error *err)
{
    job->plan = json_object_get(job->json, "plan");
    job->command = json_object_get(job->plan, "command");
    job->join = json_object_get(job->plan, "join");
    job->folder = json_string_value(json_object_get(job->json, "folder"));
    job->id = json_string_value(json_object_get(job->json, "id"));
    job->id = job->id ? job->id : ""; /* cancel ends such a job, too */
    job->field_option = json_string_value(json_object_get(job->plan, "field_option"));
    job->threads = (int)json_integer_value(json_object_get(job->plan, "threads"));
    if (json_array_size(job->command) < 2 || !job->folder || job->threads < 1 ||
        job->id[strspn(job->id, "0123456789abcdef")] != '\0')
        return bad_plan(job->path, "a key is missing", err);
    if (!read_range(job->plan, "fields", MOST_STEPS, job->fields))
        return bad_plan(job->path, "its light fields are not numbers", err);
    if (!are_words(job->command) || (job->join && !are_words(job->join)))
        return bad_plan(job->path, "its command is no list of words", err);
    const json_t *words = json_object_get(job->json, "words");
    if (!are_words(words))
        return bad_plan(job->path, "the words of its command are missing", err);
    job->names_fields = job->field_option && have_option(words, job->field_option);
    return read_steps(job, err);
}

/* -------------------------------------------------------------------------------------- make -- */

static const char readme[] =
    "A job of quiltfarm: an image that many machines render (quiltfarm(1)).\n"
    "\n"
    "  quiltfarm status THIS_FOLDER    what is complete, what failed, and the time left\n"
    "  quiltfarm submit THIS_FOLDER    send what is missing\n"
    "  quiltfarm resume THIS_FOLDER    the same, and try failed tasks again\n"
    "  quiltfarm merge THIS_FOLDER     make the output when all tasks are complete\n"
    "\n"
    "job.json      what is rendered, and its division into tasks\n"
    "tasks         one command per line; task K is line K + 1\n"
    "finishes      commands that make files from the states of tasks\n"
    "task.sbatch   the script that Slurm runs\n"
    "frames/       frames of a film, which its finish joins\n"
    "states/       saved work of tasks\n"
    "done/         receipts of complete tasks (.json), and words of failed ones (.failed)\n"
    "log/          what tasks and schedulers printed\n"
    "\n"
    "Do not move the folder. Remove it when the output is complete.\n";

static lf_status write_commands(const lf_farm_job *job, const char *name, int first, int n,
                                lf_error *err)
{
    char *path = lf_farm_job_path(job, "%s", name), *text = NULL;
    size_t size = 0;
    FILE *out = path ? open_memstream(&text, &size) : NULL;
    lf_status status = out ? LF_OK : lf_farm_no_memory(job->path, err);
    for (int i = first; i < first + n && status == LF_OK; i++) {
        char *command = NULL;
        status = lf_farm_step_command(job, i, i, &command, err);
        if (status == LF_OK)
            (void)fprintf(out, "%s\n", command);
        lf_free(command);
    }
    if (out && fclose(out) != 0 && status == LF_OK)
        status = lf_farm_no_memory(job->path, err);
    if (status == LF_OK)
        status = lf_outfile_text(path, text, err);
    free(text);
    lf_free(path);
    return status;
}

static lf_status write_text(const lf_farm_job *job, const char *name, const char *text,
                            lf_error *err)
{
    char *path = lf_farm_job_path(job, "%s", name);
    const lf_status status =
        path ? lf_outfile_text(path, text, err) : lf_farm_no_memory(job->path, err);
    lf_free(path);
    return status;
}

static lf_status make_folders(const lf_farm_job *job, lf_error *err)
{
    static const char *const names[] = {"states", "done", "log", "frames"};
    const bool has_frames = json_is_string(json_object_get(job->plan, "frames_output"));
    const size_t n = sizeof names / sizeof *names - (has_frames ? 0 : 1);
    for (size_t i = 0; i < n; i++) {
        char *path = lf_farm_job_path(job, "%s", names[i]);
        const bool made = path && (mkdir(path, 0777) == 0 || errno == EEXIST);
        const int why = errno;
        lf_free(path);
        if (!made)
            return lf_error_set(err, LF_E_IO, job->path, "cannot make a folder: %s",
                                lf_errno_text(why));
    }
    return LF_OK;
}

/* LF_E_ARG: schedulers or shells would read another name. */
static lf_status check_name(const char *path, lf_error *err)
{
    return !strpbrk(path, "%\\\n\r")
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, path,
                              "has a character that schedulers replace (%%, backslash, line end); "
                              "choose another name");
}

/* An absolute path without "." and "..", of a folder that exists; caller frees with lf_free. */
static char *absolute(const char *path)
{
    char *found = realpath(path, NULL), *copy = lf_strdup(found);
    free(found);
    return copy;
}

/* Makes the folder, and sets the job's absolute path. */
static lf_status make_folder(const char *path, lf_farm_job *job, lf_error *err)
{
    const bool is_new = mkdir(path, 0777) == 0;
    if (!is_new && errno != EEXIST) /* with the scene, as plan has seen */
        return lf_error_set(err, LF_E_IO, path, "cannot be made: %s", lf_errno_text(errno));
    struct stat found;
    if (!is_new && stat(path, &found) == 0) /* lf_farm_job_check_mine asks for it */
        (void)chmod(path, found.st_mode & 07777 & ~(mode_t)(S_IWGRP | S_IWOTH));
    lf_free(job->path);
    job->path = absolute(path);
    const lf_status status = job->path ? check_name(job->path, err) : lf_farm_no_memory(path, err);
    if (status != LF_OK && is_new)
        (void)rmdir(path);
    return status;
}

/* The rows of a hologram plate are rendered one by one, and its manifest needs them all. A command
 * with --camera-rows makes rows only. */
static bool add_closing_finish(const json_t *words, json_t *plan)
{
    const char *kind = json_string_value(json_object_get(plan, "kind")),
               *option = json_string_value(json_object_get(plan, "field_option"));
    json_t *tasks = json_object_get(plan, "tasks"), *finishes = json_object_get(plan, "finishes"),
           *finish;
    size_t i;
    if (!kind || strcmp(kind, "hologram") != 0 || !option || have_option(words, option) ||
        !json_is_array(json_object_get(json_array_get(tasks, 0), "fields")))
        return true;
    json_array_foreach(finishes, i,
                       finish) if (json_is_null(json_object_get(finish, "fields"))) return true;
    return json_array_append_new(finishes, json_pack("{s:n, s:[i,i], s:f, s:i}", "fields", "tasks",
                                                     0, (int)json_array_size(tasks) - 1,
                                                     "cpu_seconds", 1.0, "memory", 0)) == 0;
}

/* A word that no other plan has: schedulers may still hold steps of a folder that was removed. */
static void make_id(char buf[16])
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    snprintf(buf, 16, "%06llx%04x", (unsigned long long)now.tv_sec & 0xffffff,
             ((unsigned)now.tv_nsec ^ (unsigned)getpid()) & 0xffff);
}

/* The content of job.json. A new reference; NULL = out of memory. */
static json_t *make_json(const char *path, const lf_farm_engine *engine, const char *folder,
                         char *const words[], json_t *plan)
{
    json_t *list = json_array();
    char id[16];
    make_id(id);
    for (; list && *words; words++)
        json_array_append_new(list, json_string(*words));
    if (list && !add_closing_finish(list, plan)) {
        json_decref(list);
        return NULL;
    }
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:O}", "quiltd", LF_VERSION, "id", id, "job",
                     path, "folder", folder, "engine", engine->name, "words", list, "plan", plan);
}

/* Removes what a plan that failed has made, such as on a full disk. */
static void unmake(const lf_farm_job *job)
{
    static const char *const names[] = {"README", "tasks", "finishes", "job.json", "states",
                                        "done",   "log",   "frames",   ""};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *path =
            names[i][0] != '\0' ? lf_farm_job_path(job, "%s", names[i]) : lf_strdup(job->path);
        if (path)
            (void)remove(path); /* the folder itself only if nothing of the user is in it */
        lf_free(path);
    }
}

lf_status lf_farm_job_make(const char *path, const lf_farm_engine *engine, const char *folder,
                           char *const words[], json_t *plan, lf_error *err)
{
    lf_farm_job job = {.lock_fd = -1, .path = lf_strdup(path)};
    job.json = make_json(path, engine, folder, words, plan);
    lf_status status = job.path && job.json ? read_plan(&job, err) : lf_farm_no_memory(path, err);
    if (status == LF_OK)
        status = make_folder(path, &job, err);
    const bool is_begun = status == LF_OK;
    if (status == LF_OK)
        status = json_object_set_new(job.json, "job", json_string(job.path)) == 0
                     ? make_folders(&job, err)
                     : lf_farm_no_memory(path, err);
    if (status == LF_OK)
        status = write_text(&job, "README", readme, err);
    if (status == LF_OK)
        status = write_commands(&job, "tasks", 0, job.n_tasks, err);
    if (status == LF_OK)
        status = write_commands(&job, "finishes", job.n_tasks, job.n_finishes, err);
    if (status == LF_OK)
        status = lf_farm_job_write(&job, "job.json", job.json, err);
    if (status != LF_OK && is_begun)
        unmake(&job);
    lf_farm_job_close(&job);
    return status;
}

/* -------------------------------------------------------------------------------------- open -- */

/* LF_E_STATE if the folder is not the one that the commands in it name. */
static lf_status check_place(const lf_farm_job *job, const char *planned, lf_error *err)
{
    struct stat here, there;
    const lf_status status = check_name(planned, err);
    if (status != LF_OK)
        return status;
    if (stat(job->path, &here) == 0 && stat(planned, &there) == 0 && here.st_dev == there.st_dev &&
        here.st_ino == there.st_ino)
        return LF_OK;
    return lf_error_set(err, LF_E_STATE, job->path,
                        "was planned as %s, and its commands name that folder; move it back",
                        planned);
}

lf_status lf_farm_job_open(const char *path, lf_farm_job *out, lf_error *err)
{
    *out = (lf_farm_job){.lock_fd = -1, .path = absolute(path)};
    if (!out->path)
        return lf_error_set(err, LF_E_IO, path, "there is no such folder");
    lf_status status = lf_farm_job_read(out, "job.json", &out->json, err);
    if (status == LF_OK && !out->json)
        return lf_error_set(
            err, LF_E_FORMAT, path,
            "is no job, because job.json is missing; pass a folder that quiltfarm plan "
            "has made");
    const char *planned = json_string_value(json_object_get(out->json, "job")),
               *engine = json_string_value(json_object_get(out->json, "engine"));
    if (status == LF_OK)
        status = planned ? check_place(out, planned, err) : bad_plan(path, "no folder", err);
    if (status == LF_OK)
        out->engine = lf_farm_engine_find(engine ? engine : "");
    if (status == LF_OK && !out->engine)
        status = bad_plan(path, "its engine is unknown", err);
    if (status == LF_OK) {
        lf_free(out->path);
        out->path = lf_strdup(planned); /* as all machines know it */
        status = out->path ? read_plan(out, err) : lf_farm_no_memory(path, err);
    }
    return status;
}

void lf_farm_job_close(lf_farm_job *job)
{
    if (job->lock_fd >= 0)
        close(job->lock_fd);
    json_decref(job->json);
    lf_free(job->steps);
    lf_free(job->path);
    *job = (lf_farm_job){.lock_fd = -1};
}

/* ------------------------------------------------------------------------------------- owner -- */

/* LF_E_STATE: another user may have written what is in it. A missing file is nobody's. */
static lf_status check_mine(const char *path, lf_error *err)
{
    struct stat found;
    if (lstat(path, &found) != 0)
        return LF_OK;
    if ((found.st_uid != geteuid() && found.st_uid != 0) || S_ISLNK(found.st_mode))
        return lf_error_set(err, LF_E_STATE, path,
                            "belongs to another user, whose commands are not run; plan a job of "
                            "your own");
    return (found.st_mode & (S_IWGRP | S_IWOTH)) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_STATE, path,
                              "can be written by others, whose commands would run as yours; use "
                              "chmod -R go-w on the job's folder");
}

lf_status lf_farm_job_check_mine(const lf_farm_job *job, lf_error *err)
{
    static const char *const names[] = {"job.json", "sent.json", "done", "log"};
    lf_status status = check_mine(job->path, err);
    for (size_t i = 0; i < sizeof names / sizeof *names && status == LF_OK; i++) {
        char *path = lf_farm_job_path(job, "%s", names[i]);
        status = path ? check_mine(path, err) : lf_farm_no_memory(job->path, err);
        lf_free(path);
    }
    return status;
}

/* -------------------------------------------------------------------------------------- lock -- */

static int open_lock(const lf_farm_job *job)
{
    char *path = lf_farm_job_path(job, "log/lock");
    const int fd = path ? open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666) : -1;
    lf_free(path);
    return fd;
}

lf_status lf_farm_job_lock(lf_farm_job *job, lf_error *err)
{
    job->lock_fd = open_lock(job);
    if (job->lock_fd < 0)
        return lf_error_set(err, LF_E_IO, job->path, "cannot be written: %s", lf_errno_text(errno));
    if (flock(job->lock_fd, LOCK_EX | LOCK_NB) == 0)
        return LF_OK;
    if (errno != EWOULDBLOCK) { /* a file system without locks */
        lf_log(LF_LOG_WARNING, "%s: cannot be locked (%s); let only one quiltfarm submit it",
               job->path, lf_errno_text(errno));
        return LF_OK;
    }
    return lf_error_set(err, LF_E_BUSY, job->path,
                        "another quiltfarm works on it; see quiltfarm status");
}

bool lf_farm_job_is_locked(const lf_farm_job *job)
{
    const int fd = open_lock(job);
    const bool is_locked = fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (fd >= 0)
        close(fd);
    return is_locked;
}
