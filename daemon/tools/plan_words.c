/* The commands of a plan. */
#include <stdio.h>
#include <string.h>

#include "daemon/tools/plan.h"

/* An option that a task's command lacks. */
typedef struct left_out {
    const char *option;
    bool takes_argument;
} left_out;

/* Options of plans, of light fields, and of one run, whose files tasks must not share. */
static const left_out of_plan[] = {{"--plan", false},
                                   {"--json", false},
                                   {"--task-minutes", true},
                                   {"--task-memory", true},
                                   {NULL, false}};
static const left_out of_rows[] = {{"--camera-rows", true}, {NULL, false}};
static const left_out of_frames[] = {{"--frames", true}, {NULL, false}};
static const left_out of_run[] = {{"--state", true}, {"--rows", true},  {"--stream", true},
                                  {"--files", true}, {"--stats", true}, {NULL, false}};

/* True if a word is this option, in full or abbreviated as getopt allows; with "=" it includes its
 * value. */
static bool is_option(const char *word, const char *option)
{
    const size_t n = strcspn(word, "=");
    return n > 2 && strncmp(word, "--", 2) == 0 && strncmp(word, option, n) == 0;
}

static const left_out *find(const left_out *list, const char *word)
{
    for (; list->option; list++)
        if (is_option(word, list->option))
            return list;
    return NULL;
}

/* Whether a word is an option of videos, and whether its value is the next word. */
static bool is_of_video(const char *word, bool *out_takes_argument)
{
    for (const lf_param *row = lf_video_params; row->option; row = lf_param_next(row)) {
        char option[64];
        snprintf(option, sizeof option, "--%s", row->option);
        if (!is_option(word, option))
            continue;
        *out_takes_argument = (row->type != LF_PARAM_SWITCH || row->words) && !strchr(word, '=');
        return true;
    }
    return false;
}

/* -o OUT, -oOUT, --output OUT, --output=OUT. */
static bool is_output(const char *word, bool *out_takes_argument)
{
    const bool is_short = strncmp(word, "-o", 2) == 0;
    *out_takes_argument = strcmp(word, "-o") == 0 || !strchr(word, '=');
    if (is_short)
        *out_takes_argument = word[2] == '\0';
    return is_short || is_option(word, "--output");
}

/* Whether a word is left out of a task's command. A task that is the job keeps its files. */
static bool leaves_out(const lf_rendering *r, const lf_plan *plan, const char *word,
                       bool *out_takes_argument)
{
    const lf_plan_division *d = &plan->division;
    const bool is_job = !r->arguments->plan.json && d->n_tasks == 1 && d->n_finishes == 0,
               has_frames = plan->option && strcmp(plan->option, "--frames") == 0;
    const left_out *found = find(of_plan, word);
    if (!found && plan->option)
        found = find(has_frames ? of_frames : of_rows, word);
    if (!found && !is_job)
        found = find(of_run, word);
    if (found)
        *out_takes_argument = found->takes_argument && !strchr(word, '=');
    return found || (plan->frames && (is_of_video(word, out_takes_argument) ||
                                      is_output(word, out_takes_argument)));
}

static void append(json_t *words, const char *word)
{
    json_array_append_new(words, json_string(word));
}

json_t *lf_plan_command(const lf_rendering *r, const lf_plan *plan)
{
    char *const *argv = r->arguments->argv;
    json_t *words = json_array();
    bool is_operand = false;
    if (words && plan->frames) {
        append(words, "-o");
        append(words, plan->frames);
    }
    for (int i = 1; words && argv[i]; i++) {
        bool takes_argument = false;
        is_operand |= strcmp(argv[i], "--") == 0;
        if (is_operand || !leaves_out(r, plan, argv[i], &takes_argument))
            append(words, argv[i]);
        else if (takes_argument && argv[i + 1])
            i++;
    }
    return words;
}

json_t *lf_plan_join_command(const lf_rendering *r, const lf_plan *plan)
{
    const lf_render_arguments *a = r->arguments;
    char range[32];
    snprintf(range, sizeof range, "%d:%d", plan->job.first, plan->job.last);
    json_t *words = json_pack("[s,s,s,s,s]", plan->frames, "-o", a->out, "--frames", range);
    if (words && r->layout.n_views == 1 && a->options.columns == 0)
        append(words, "--still");
    for (int i = 1; words && a->argv[i]; i++) {
        bool takes_argument = false;
        if (strcmp(a->argv[i], "--") == 0)
            break;
        if (!is_of_video(a->argv[i], &takes_argument))
            continue;
        append(words, a->argv[i]);
        if (takes_argument && a->argv[i + 1])
            append(words, a->argv[++i]);
    }
    return words;
}
