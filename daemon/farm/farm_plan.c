#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "daemon/farm/farm.h"
#include "daemon/farm/farm_engine.h"
#include "daemon/farm/farm_file.h"
#include "daemon/farm/farm_process.h"
#include "daemon/farm/farm_text.h"

#define RENDERER "quiltrender"
#define MERGER "quiltmerge"

/* ----------------------------------------------------------------------------------- options -- */

const lf_param lf_farm_params[] = {
    {.option = "engine",
     .argument = "ENGINE",
     .help = "plan: what runs the tasks",
     .type = LF_PARAM_NAME,
     .word_at = lf_farm_engine_name,
     .place = offsetof(lf_farm_options, engine)},
    {.option = "task-minutes",
     .argument = "M",
     .help = "plan: minutes of a task; 0: one light field each (20)",
     .type = LF_PARAM_NUMBER,
     .low = 0,
     .high = 1e6,
     .place = offsetof(lf_farm_options, task_minutes)},
    {.option = "task-memory",
     .argument = "SIZE",
     .help = "plan: most memory of a task, such as 2G (no limit)",
     .type = LF_PARAM_TEXT,
     .place = offsetof(lf_farm_options, task_memory)},
    {.option = "threads",
     .argument = "N",
     .help = "plan: threads of a task (4)",
     .type = LF_PARAM_WHOLE,
     .low = 1,
     .high = 1024,
     .place = offsetof(lf_farm_options, threads)},
    {.option = "slots",
     .argument = "N",
     .help = "submit, resume: most tasks at once; plan: tell the time with so many",
     .type = LF_PARAM_WHOLE,
     .low = 1,
     .high = 100000,
     .place = offsetof(lf_farm_options, slots)},
    {.option = "json",
     .help = "plan, status: print JSON",
     .type = LF_PARAM_SWITCH,
     .place = offsetof(lf_farm_options, json)},
    {.option = "check",
     .help =
         "status: compare the SHA-256 of all outputs; submit, resume: make those anew that differ",
     .type = LF_PARAM_SWITCH,
     .place = offsetof(lf_farm_options, check)},
    {0}};

/* -------------------------------------------------------------------------------------- cost -- */

/* Planned sums of a job. */
typedef struct cost {
    double tasks, finishes;         /* CPU seconds */
    double longest, longest_finish; /* of one task or finish */
    double memory, finish_memory;   /* of the largest task and finish */
} cost;

static cost cost_of(const lf_farm_job *job)
{
    cost c = {0};
    for (int i = 0; i < job->n_tasks + job->n_finishes; i++) {
        const lf_farm_step *s = &job->steps[i];
        double *sum = i < job->n_tasks ? &c.tasks : &c.finishes,
               *most = i < job->n_tasks ? &c.longest : &c.longest_finish,
               *memory = i < job->n_tasks ? &c.memory : &c.finish_memory;
        *sum += s->cpu_seconds;
        *most = s->cpu_seconds > *most ? s->cpu_seconds : *most;
        *memory = s->memory > *memory ? s->memory : *memory;
    }
    return c;
}

/* From the first start to the last end, if no task waits. */
static double wall_seconds(const lf_farm_job *job, const cost *c, int slots)
{
    const double even = (c->tasks + c->finishes) / ((double)job->threads * slots),
                 least = (c->longest + c->longest_finish) / job->threads;
    return even > least ? even : least;
}

static double plan_number(const lf_farm_job *job, const char *key)
{
    return json_number_value(json_object_get(job->plan, key));
}

/* Bytes of all states at once. */
static double all_states(const lf_farm_job *job)
{
    return plan_number(job, "state_bytes") * job->n_tasks;
}

static void warn_of_room(const lf_farm_job *job)
{
    struct statvfs fs;
    char needed[32], room[32];
    const double bytes = plan_number(job, "files_bytes") + all_states(job);
    if (statvfs(job->path, &fs) != 0)
        return;
    const double free_bytes = (double)fs.f_bavail * (double)fs.f_frsize;
    if (bytes > free_bytes)
        lf_log(LF_LOG_WARNING, "%s: the disk has %s free; the job may need %s", job->path,
               lf_farm_bytes(free_bytes, room, sizeof room),
               lf_farm_bytes(bytes, needed, sizeof needed));
}

/* Hours of work are in vain if the programs of the last step are missing. */
static void warn_of_merger(const lf_farm_job *job)
{
    char path[PATH_MAX];
    bool has_bands = false;
    for (int i = 0; i < job->n_tasks; i++)
        has_bands |= job->steps[i].rows[0] >= 0;
    if (has_bands && lf_farm_find(MERGER, path, NULL) != LF_OK)
        lf_log(LF_LOG_WARNING, MERGER ": not found beside quiltfarm and in PATH; the finishes "
                                      "need it");
}

static void print_wall(const lf_farm_job *job, const cost *c, int asked)
{
    const int usual[] = {1, 10, 100};
    char text[32];
    printf("  wall time   ");
    for (int i = 0; i < 3 && (i == 0 || (asked == 0 && usual[i - 1] < job->n_tasks)); i++) {
        const int slots = asked > 0 ? asked : usual[i];
        printf("%s%s with %d task%s at once", i > 0 ? ", " : "",
               lf_farm_seconds(wall_seconds(job, c, slots), text, sizeof text), slots,
               slots == 1 ? "" : "s");
    }
    putchar('\n');
}

static void print_cost(const lf_farm_job *job, int slots)
{
    const cost c = cost_of(job);
    char a[32], b[32];
    printf("%s: %d task%s", job->path, job->n_tasks, job->n_tasks == 1 ? "" : "s");
    if (job->n_finishes > 0)
        printf(" and %d finish%s", job->n_finishes, job->n_finishes == 1 ? "" : "es");
    printf(", for %s\n", job->engine->name);
    if (c.longest > 0) {
        printf("  work        %s of CPU time; the longest task %s\n",
               lf_farm_seconds(c.tasks + c.finishes, a, sizeof a),
               lf_farm_seconds(c.longest, b, sizeof b));
        print_wall(job, &c, slots);
    } else {
        printf("  work        unknown: an error ends it\n");
    }
    printf("  a task      %d thread%s, at most %s of memory\n", job->threads,
           job->threads == 1 ? "" : "s", lf_farm_bytes(c.memory, a, sizeof a));
    if (c.finish_memory > 0)
        printf("  a finish    at most %s of memory\n", lf_farm_bytes(c.finish_memory, a, sizeof a));
    const double files = plan_number(job, "files_bytes");
    printf("  disk        %s of files, at most %s of states\n",
           files > 0 ? lf_farm_bytes(files, a, sizeof a) : "an unknown size",
           lf_farm_bytes(all_states(job), b, sizeof b));
    printf("next: quiltfarm submit %s\n", job->path);
}

static void print_json(const lf_farm_job *job, int slots)
{
    const cost c = cost_of(job);
    json_t *json =
        json_pack("{s:s, s:s, s:i, s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f}", "job", job->path,
                  "engine", job->engine->name, "tasks", job->n_tasks, "finishes", job->n_finishes,
                  "threads", job->threads, "cpu_seconds", c.tasks + c.finishes, "memory",
                  c.memory > c.finish_memory ? c.memory : c.finish_memory, "task_memory", c.memory,
                  "finish_memory", c.finish_memory, "files_bytes", plan_number(job, "files_bytes"),
                  "state_bytes", all_states(job));
    if (json && slots > 0)
        json_object_set_new(json, "wall_seconds", json_real(wall_seconds(job, &c, slots)));
    json_dumpf(json, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(json);
}

/* -------------------------------------------------------------------------------------- plan -- */

static lf_status ask_renderer(const lf_farm_command *c, json_t **out, lf_error *err)
{
    const lf_farm_options *o = c->options;
    lf_farm_words words = {0};
    char path[PATH_MAX];
    char *text = NULL;
    int code = 0;
    json_error_t why;
    lf_status status = lf_farm_find(RENDERER, path, err);
    if (status != LF_OK)
        return status;
    lf_farm_words_add(&words, "%s", path);
    lf_farm_words_add(&words, "--plan"); /* before the user's words, whose last may want a value */
    lf_farm_words_add(&words, "--json");
    lf_farm_words_add(&words, "--threads");
    lf_farm_words_add(&words, "%d", o->threads > 0 ? o->threads : LF_FARM_THREADS);
    if (o->task_minutes >= 0) {
        lf_farm_words_add(&words, "--task-minutes");
        lf_farm_words_add(&words, "%.17g", o->task_minutes);
    }
    if (o->task_memory) {
        lf_farm_words_add(&words, "--task-memory");
        lf_farm_words_add(&words, "%s", o->task_memory);
    }
    lf_farm_words_add_list(&words, c->words);
    status = words.failed ? lf_farm_no_memory(RENDERER, err)
                          : lf_farm_process_read(words.list, &text, &code, err);
    lf_farm_words_finish(&words);
    if (status == LF_OK && code == 2)
        status = lf_error_set(err, LF_E_ARG, RENDERER, "refuses the words after --");
    else if (status == LF_OK && code != 0)
        status = lf_error_set(err, LF_E_IO, RENDERER, "made no plan, as it says above");
    if (status == LF_OK && !(*out = json_loads(text, 0, &why)))
        status = lf_error_set(err, LF_E_FORMAT, RENDERER, "its plan is not JSON: %s", why.text);
    lf_free(text);
    return status;
}

/* Names that a folder may have beside the scene: quiltd writes this one. */
#define PANEL "panel.json"

/* True if a folder holds the scene and nothing that a job would write over. */
static bool holds_only(const char *path, const char *scene)
{
    const char *slash = strrchr(scene, '/'), *own = slash ? slash + 1 : scene;
    DIR *folder = opendir(path);
    bool has_scene = false, has_more = !folder;
    for (const struct dirent *entry; folder && (entry = readdir(folder));) {
        const char *name = entry->d_name;
        const bool is_scene = strcmp(name, own) == 0;
        has_scene |= is_scene;
        has_more |= !is_scene && strcmp(name, PANEL) != 0 && strcmp(name, ".") != 0 &&
                    strcmp(name, "..") != 0;
    }
    if (folder)
        closedir(folder);
    return has_scene && !has_more;
}

/* A folder that exists is taken if only the scene is in it, as quiltd writes it. */
static bool is_free(const char *folder, const char *scene)
{
    struct stat given, inside;
    char *parent = lf_path_folder(scene);
    const bool is_free =
        access(folder, F_OK) != 0 || (parent && stat(folder, &given) == 0 &&
                                      stat(parent, &inside) == 0 && given.st_dev == inside.st_dev &&
                                      given.st_ino == inside.st_ino && holds_only(folder, scene));
    lf_free(parent);
    return is_free;
}

/* The renderer may be in a container, whose names mean nothing here: such files are not compared.
 */
static void forget_inputs(json_t *plan, const char *folder)
{
    json_t *inputs = json_object_get(plan, "inputs");
    size_t n = 0;
    for (size_t i = json_array_size(inputs); i-- > 0;) {
        const json_t *note = json_array_get(inputs, i);
        const char *name = json_string_value(json_object_get(note, "name"));
        if (lf_farm_file_compare(folder, note, true) == LF_FARM_FILE_SAME)
            continue;
        if (n++ == 0)
            lf_log(LF_LOG_WARNING,
                   "%s: is not the same file outside the renderer; tasks do not see if it changes",
                   name ? name : RENDERER);
        json_array_remove(inputs, i);
    }
    if (n > 1)
        lf_log(LF_LOG_WARNING, "%zu more files are not the same outside the renderer", n - 1);
}

/* The output of the renderer's words; NULL: none is named. */
static const char *output_of(char *const *words)
{
    for (; *words && strcmp(*words, "--") != 0; words++)
        if (strncmp(*words, "-o", 2) == 0)
            return (*words)[2] != '\0' ? *words + 2 : words[1];
    return NULL;
}

/* Length of a folder's name without slashes at its end. */
static size_t bare_length(const char *folder)
{
    size_t n = strlen(folder);
    while (n > 1 && folder[n - 1] == '/')
        n--;
    return n;
}

/* Whether an output would be mixed with the files of a job, this one or another. */
static bool is_job_folder(const char *output, const char *job)
{
    const size_t n = bare_length(output);
    char *there = lf_path_join(output, "job.json");
    const bool is = (there && access(there, F_OK) == 0) ||
                    (n == bare_length(job) && strncmp(output, job, n) == 0);
    lf_free(there);
    return is;
}

lf_status lf_farm_plan(const lf_farm_command *c, lf_error *err)
{
    const char *name = c->options->engine ? c->options->engine : lf_farm_engine_name(0);
    char folder[PATH_MAX];
    json_t *plan = NULL;
    lf_farm_job job;
    if (!c->words[0])
        return lf_error_set(err, LF_E_ARG, "plan",
                            "has nothing to render; pass it as -- SCENE -o OUT");
    const char *output = output_of(c->words);
    if (output && is_job_folder(output, c->job))
        return lf_error_set(err, LF_E_ARG, output,
                            "is the folder of a job; choose another one for the output");
    if (!is_free(c->job, c->words[0]))
        return lf_error_set(err, LF_E_EXISTS, c->job, "exists; choose a new folder for the job");
    if (!getcwd(folder, sizeof folder))
        return lf_error_set(err, LF_E_IO, ".", "the working folder has no name");
    lf_status status = ask_renderer(c, &plan, err);
    if (status == LF_OK) {
        forget_inputs(plan, folder);
        status = lf_farm_job_make(c->job, lf_farm_engine_find(name), folder, c->words, plan, err);
    }
    json_decref(plan);
    if (status != LF_OK)
        return status;
    status = lf_farm_job_open(c->job, &job, err);
    if (status == LF_OK && c->options->json)
        print_json(&job, c->options->slots);
    else if (status == LF_OK)
        print_cost(&job, c->options->slots);
    if (status == LF_OK) {
        warn_of_room(&job);
        warn_of_merger(&job);
    }
    lf_farm_job_close(&job);
    return status;
}
