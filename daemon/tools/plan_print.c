/* A plan as text for a shell and as JSON. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/version.h"
#include "daemon/tools/plan.h"
#include "daemon/tools/plan_inputs.h"

/* ------------------------------------------------------------------------------------- words -- */

/* Prints a word quoted for a shell. */
static void print_word(const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "-_./:=,+@%";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0') {
        printf("%s", word);
        return;
    }
    putchar('\'');
    for (; *word; word++)
        printf(*word == '\'' ? "'\\''" : "%c", *word);
    putchar('\'');
}

static void print_words(const json_t *words)
{
    size_t i;
    const json_t *word;
    json_array_foreach(words, i, word)
    {
        putchar(' ');
        print_word(json_string_value(word));
    }
    putchar('\n');
}

static void print_option(const char *option, const char *word)
{
    printf(" %s ", option);
    print_word(word);
}

/* -------------------------------------------------------------------------------------- text -- */

static void print_amount(const char *what, double amount, const char *unit)
{
    static const char *const prefixes[] = {"", "k", "M", "G", "T", "P"};
    int i = 0;
    for (; amount >= 1000 && i < 5; i++)
        amount /= 1000;
    printf("# %-22s %.3g %s%s\n", what, amount, prefixes[i], unit);
}

static void print_time(const char *what, double seconds)
{
    const double hours = seconds / 3600;
    printf("# %-22s %.*f CPU %s\n", what, hours >= 2 || seconds < 1 ? 1 : 0,
           hours >= 2       ? hours
           : seconds >= 200 ? seconds / 60
                            : seconds,
           hours >= 2       ? "hours"
           : seconds >= 200 ? "minutes"
                            : "seconds");
}

/* The dearest task, the largest memory of tasks and finishes, and the time of all; negative times:
 * unknown. */
static lf_plan_cost most_of(const lf_plan_division *d, double *out_finish, double *out_all)
{
    lf_plan_cost most = {-1, 0};
    *out_finish = 0;
    *out_all = 0;
    for (int i = 0; i < d->n_tasks + d->n_finishes; i++) {
        const bool is_task = i < d->n_tasks;
        const lf_plan_cost *cost = is_task ? &d->tasks[i].cost : &d->finishes[i - d->n_tasks].cost;
        if (is_task && cost->cpu_seconds > most.cpu_seconds)
            most.cpu_seconds = cost->cpu_seconds;
        double *memory = is_task ? &most.memory : out_finish;
        *memory = cost->memory > *memory ? cost->memory : *memory;
        *out_all += cost->cpu_seconds;
    }
    if (most.cpu_seconds < 0)
        *out_all = -1;
    return most;
}

static void print_light_fields(const lf_rendering *r, const lf_plan *plan)
{
    const int fields = r->sequence.on ? lf_frames_count(&r->arguments->frames) : 1;
    const double pixels = (double)plan->n_views * plan->width * plan->height;
    printf("# %d %s of %d view%s of %dx%d pixels\n", fields,
           !r->sequence.on ? "light field" : lf_frames_noun(&r->arguments->frames), plan->n_views,
           plan->n_views == 1 ? "" : "s", plan->width, plan->height);
    print_amount("view pixels", pixels * fields, "");
    if (plan->files_bytes >= 0)
        print_amount("files, uncompressed", plan->files_bytes, "B");
    print_amount("film memory", plan->film_bytes, "B");
    print_amount("image memory", 12 * pixels, "B");
}

static void print_costs(const lf_rendering *r, const lf_plan *plan)
{
    const lf_plan_division *d = &plan->division;
    double all, finish;
    const lf_plan_cost most = most_of(d, &finish, &all);
    print_amount("memory of a task", most.memory, "B");
    if (d->n_finishes > 0)
        print_amount("memory of a finish", finish, "B");
    if (d->n_tasks > 1)
        printf("# %-22s %d\n", "tasks", d->n_tasks);
    if (all < 0) {
        printf("# the time depends on the target error\n");
        return;
    }
    if (d->n_tasks > 1)
        print_time("a task", most.cpu_seconds);
    print_time("all", all);
    if (lf_rendering_budget(r).seconds > 0)
        printf("# --time gives the time\n");
    else
        printf("# measured on %d of %d image rows\n", plan->rows_measured, plan->height);
}

/* The state of a task's rows; all: of the merged rows. The caller frees it. NULL = out of
 * memory. */
static char *state_of(const lf_plan *plan, const char *stem, const int rows[2])
{
    char *name;
    const bool is_all = rows[0] == 0 && rows[1] == plan->height - 1;
    const int n = is_all ? asprintf(&name, "%s.lfstate", stem)
                         : asprintf(&name, "%s_rows_%d_%d.lfstate", stem, rows[0], rows[1]);
    return n < 0 ? NULL : name;
}

/* What every command begins with. */
static void print_program(const lf_rendering *r, const lf_plan *plan, const int fields[2])
{
    print_word(r->arguments->argv[0]);
    if (plan->option && fields[0] <= fields[1])
        printf(" %s %d:%d", plan->option, fields[0], fields[1]);
    else if (plan->option && r->sequence.on && !plan->job.is_closed)
        printf(" %s %d:%d", plan->option, plan->job.first, plan->job.last);
}

static bool print_task(const lf_rendering *r, const lf_plan *plan, const lf_plan_task *task,
                       const char *stem, const json_t *words)
{
    print_program(r, plan, task->fields);
    if (task->rows[0] <= task->rows[1]) {
        char *state = state_of(plan, stem, task->rows);
        if (!state)
            return false;
        printf(" --rows %d:%d", task->rows[0], task->rows[1]);
        print_option("--state", state);
        free(state);
    }
    print_words(words);
    return true;
}

/* The name of a state of a light field, as quiltrender completes it. The caller frees it. */
static char *state_of_field(const lf_plan *plan, const char *stem, const int rows[2], int field)
{
    char *name = state_of(plan, stem, rows);
    char *full = !name ? NULL : plan->option ? lf_frames_path(name, field) : lf_strdup(name);
    free(name);
    return full;
}

/* Prints the command that merges the bands of a light field; nothing for one band. */
static bool print_merge(const lf_rendering *r, const lf_plan *plan, const int tasks[2],
                        const char *stem)
{
    const lf_plan_task *first = &plan->division.tasks[tasks[0]];
    const int all[2] = {0, plan->height - 1};
    char *whole = state_of_field(plan, stem, all, first->fields[0]);
    const char *slash = strrchr(r->arguments->argv[0], '/');
    if (slash)
        printf("%.*s", (int)(slash + 1 - r->arguments->argv[0]), r->arguments->argv[0]);
    printf("quiltmerge");
    for (int i = tasks[0]; i <= tasks[1] && whole; i++) {
        char *part = state_of_field(plan, stem, plan->division.tasks[i].rows, first->fields[0]);
        putchar(' ');
        print_word(part ? part : "");
        if (!part)
            return false;
        lf_free(part);
    }
    if (whole)
        print_option("-o", whole);
    putchar('\n');
    lf_free(whole);
    return whole;
}

/* Prints the merges of all light fields of these tasks that are in bands. */
static bool print_merges(const lf_rendering *r, const lf_plan *plan, const int tasks[2],
                         const char *stem)
{
    const lf_plan_task *all = plan->division.tasks;
    for (int first = tasks[0]; first <= tasks[1];) {
        int last = first;
        while (last < tasks[1] && all[last + 1].rows[0] > 0)
            last++;
        const int bands[2] = {first, last};
        if (last > first && !print_merge(r, plan, bands, stem))
            return false;
        first = last + 1;
    }
    return true;
}

static bool print_finish(const lf_rendering *r, const lf_plan *plan, const lf_plan_finish *finish,
                         const char *stem, const json_t *words)
{
    const int all[2] = {0, plan->height - 1};
    if (plan->frames) {
        json_t *join = lf_plan_join_command(r, plan);
        print_word(r->arguments->argv[0]);
        print_words(join);
        json_decref(join);
        return join;
    }
    if (finish->closes) {
        print_program(r, plan, finish->fields);
        print_words(words);
        return true;
    }
    char *state = state_of(plan, stem, all);
    if (!state || !print_merges(r, plan, finish->tasks, stem)) {
        free(state);
        return false;
    }
    print_program(r, plan, finish->fields);
    print_option("--state", state);
    free(state);
    print_words(words);
    return true;
}

/* The output's name without its ending or slash. The caller frees it. NULL = out of memory. */
static char *stem_of(const char *out)
{
    char *stem = lf_strdup(out);
    size_t n = stem ? strlen(stem) : 0;
    while (n > 1 && stem[n - 1] == '/')
        stem[--n] = '\0';
    char *dot = stem ? strrchr(stem, '.') : NULL, *slash = stem ? strrchr(stem, '/') : NULL;
    if (dot && dot > stem && dot != (slash ? slash + 1 : stem) && (!slash || dot > slash))
        *dot = '\0';
    return stem;
}

lf_status lf_plan_print_text(const lf_rendering *r, const lf_plan *plan, lf_error *err)
{
    const lf_plan_division *d = &plan->division;
    json_t *words = lf_plan_command(r, plan);
    char *stem = stem_of(r->arguments->out);
    bool is_done = words && stem;
    print_light_fields(r, plan);
    print_costs(r, plan);
    for (int i = 0; i < d->n_tasks && is_done; i++)
        is_done = print_task(r, plan, &d->tasks[i], stem, words);
    if (d->n_finishes > 0)
        printf("# after all of these:\n");
    for (int i = 0; i < d->n_finishes && is_done; i++)
        is_done = print_finish(r, plan, &d->finishes[i], stem, words);
    json_decref(words);
    lf_free(stem);
    return is_done ? LF_OK : lf_error_set(err, LF_E_NOMEM, r->arguments->out, "out of memory");
}

/* -------------------------------------------------------------------------------------- JSON -- */

/* [a, b], or null if b < a. */
static json_t *range_json(const int range[2])
{
    return range[0] <= range[1] ? json_pack("[i,i]", range[0], range[1]) : json_null();
}

static json_t *bytes_json(double bytes)
{
    return bytes >= 0 ? json_integer((json_int_t)bytes) : json_null();
}

static json_t *seconds_json(double seconds)
{
    return seconds >= 0 ? json_real(seconds) : json_null();
}

static json_t *tasks_json(const lf_plan_division *d)
{
    json_t *list = json_array();
    for (int i = 0; list && i < d->n_tasks; i++) {
        const lf_plan_task *t = &d->tasks[i];
        json_array_append_new(list, json_pack("{s:o, s:o, s:o, s:o}", "fields",
                                              range_json(t->fields), "rows", range_json(t->rows),
                                              "cpu_seconds", seconds_json(t->cost.cpu_seconds),
                                              "memory", bytes_json(t->cost.memory)));
    }
    return list;
}

static json_t *finishes_json(const lf_plan_division *d)
{
    json_t *list = json_array();
    for (int i = 0; list && i < d->n_finishes; i++) {
        const lf_plan_finish *f = &d->finishes[i];
        json_array_append_new(list,
                              json_pack("{s:o, s:[i,i], s:o, s:o}", "fields", range_json(f->fields),
                                        "tasks", f->tasks[0], f->tasks[1], "cpu_seconds",
                                        seconds_json(f->cost.cpu_seconds), "memory",
                                        bytes_json(f->cost.memory)));
    }
    return list;
}

/* The largest state of a task. */
static double state_bytes(const lf_plan *plan)
{
    int most = 0;
    for (int i = 0; i < plan->division.n_tasks; i++) {
        const int *rows = plan->division.tasks[i].rows,
                  n = rows[0] <= rows[1] ? rows[1] - rows[0] + 1 : plan->height;
        most = n > most ? n : most;
    }
    return plan->film_bytes / plan->height * most;
}

static json_t *plan_json(const lf_rendering *r, const lf_plan *plan)
{
    const int fields[2] = {plan->job.first, plan->job.last}, none[2] = {0, -1};
    double all, finish;
    const lf_plan_cost most = most_of(&plan->division, &finish, &all);
    json_t *command = lf_plan_command(r, plan);
    if (!command || json_array_insert_new(command, 0, json_string(LF_RENDER_PROGRAM)) != 0)
        return NULL;
    json_t *object = json_pack(
        "{s:o, s:s?, s:o, s:s, s:i, s:i, s:i, s:i, s:o, s:o, s:o, s:o, s:i, s:s?, s:o, s:o}",
        "command", command, "field_option", plan->option, "fields",
        range_json(plan->option ? fields : none), "kind", lf_rendering_kind(r)->name, "views",
        plan->n_views, "width", plan->width, "height", plan->height, "light_fields",
        fields[1] - fields[0] + 1, "cpu_seconds", seconds_json(all), "memory",
        bytes_json(fmax(most.memory, finish)), "files_bytes", bytes_json(plan->files_bytes),
        "state_bytes", bytes_json(state_bytes(plan)), "threads", lf_pool_threads(r->pool),
        "frames_output", plan->frames, "tasks", tasks_json(&plan->division), "finishes",
        finishes_json(&plan->division));
    if (object && plan->frames)
        json_object_set_new(object, "join", lf_plan_join_command(r, plan));
    if (object)
        json_object_set_new(object, "quiltd", json_string(LF_VERSION));
    return object;
}

lf_status lf_plan_print_json(const lf_rendering *r, const lf_plan *plan, lf_error *err)
{
    json_t *inputs = NULL;
    const lf_status status = lf_plan_inputs_end(&inputs, err);
    if (status != LF_OK)
        return status;
    json_t *object = plan_json(r, plan);
    if (json_object_set_new(object, "inputs", inputs) != 0) { /* of NULL, too */
        json_decref(object);
        object = NULL;
    }
    const bool is_done =
        object && json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(6)) == 0;
    json_decref(object);
    if (!object)
        return lf_error_set(err, LF_E_NOMEM, r->arguments->out, "out of memory");
    if (!is_done || putchar('\n') == EOF || fflush(stdout) != 0)
        return lf_error_set(err, LF_E_IO, "--json", "cannot write to standard output");
    return LF_OK;
}
