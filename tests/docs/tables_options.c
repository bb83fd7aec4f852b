/* Options of quiltd and quiltrender: those that they share from their tables, others from --help.
 */
#include <stdlib.h>
#include <string.h>

#include "daemon/output/frames.h"
#include "daemon/output/hologram.h"
#include "daemon/output/options.h"
#include "daemon/output/output.h"
#include "daemon/output/video.h"
#include "daemon/tools/print_check.h"
#include "daemon/tools/render_arguments.h"
#include "daemon/tools/simulate.h"
#include "tests/docs/tables.h"

enum { N_PROGRAMS = 2, MOST_HELP = 1 << 16, COLUMN = 25 };
static const char *const programs[N_PROGRAMS] = {"quiltd", "quiltrender"};

/* A table: rows of up to two tables, or the options of a program that are in no table. */
static const struct group {
    const char *name;
    const lf_param *params, *more; /* more: NULL, none */
    const char *names;             /* of those of params; NULL: all */
    const char *program;           /* whose own options follow; NULL: nobody's */
    const char *own;               /* the names of these; NULL: all others of the program */
} groups[] = {
    {"views", lf_option_params, NULL, LF_OPTIONS_VIEWS " fit still", NULL, NULL},
    {"rendering", lf_option_params, NULL, LF_OPTIONS_RENDER " light-paths suffixes", NULL, NULL},
    {"length", lf_option_params, NULL, "target-error target-denoised-error", "quiltrender",
     "passes spp time"},
    {"reference", NULL, NULL, NULL, NULL, NULL}, /* lf_integrator_params */
    {"output", lf_option_params, NULL, "exposure guides png quality aov", NULL, NULL},
    {"panel", lf_option_params, lf_response_params, "panel calibration", NULL, NULL},
    {"interlacing", lf_panel_params, NULL, NULL, NULL, NULL},
    {"print", lf_print_params, lf_profile_params, NULL, NULL, NULL},
    {"simulate", lf_simulate_params, NULL, NULL, NULL, NULL},
    {"check", lf_check_params, NULL, NULL, NULL, NULL},
    {"depth", lf_rgbd_params, NULL, NULL, NULL, NULL},
    {"hologram", lf_hologram_params, NULL, NULL, NULL, NULL},
    {"alone", lf_alone_params, NULL, NULL, NULL, NULL},
    {"photo", lf_photo_params, lf_picture_params, NULL, NULL, NULL},
    {"standing", lf_standing_params, NULL, NULL, NULL, NULL},
    {"sequence", lf_frames_params, NULL, NULL, NULL, NULL},
    {"video", lf_video_params, NULL, NULL, NULL, NULL},
    {"import", lf_option_params, NULL, LF_OPTIONS_IMPORT, NULL, NULL},
    {"quiltd", NULL, NULL, NULL, "quiltd",
     "socket device state allow-path export-dir buttons web playlist seconds crossfade watch "
     "run-for farm"},
    {"quiltrender", lf_state_params, NULL, NULL, "quiltrender",
     "state state-info stats files plan json task-minutes task-memory read-chart "
     "chart-file"},
    {"every", NULL, NULL, NULL, "quiltd", "help version completion"},
};
enum { N_GROUPS = sizeof groups / sizeof *groups };

const char *lf_table_options_at(int index)
{
    return index < N_GROUPS ? groups[index].name : NULL;
}

/* -------------------------------------------------------------------------------------- help -- */

/* What each program prints, once; never freed. */
static const char *help_of(const lf_table_source *source, int program)
{
    static char texts[N_PROGRAMS][MOST_HELP];
    char command[4096];
    if (texts[program][0] != '\0')
        return texts[program];
    snprintf(command, sizeof command, "'%s/%s' --help", source->build, programs[program]);
    FILE *from = popen(command, "r"); /* NOLINT(cert-env33-c) */
    if (!from)
        return "";
    texts[program][fread(texts[program], 1, MOST_HELP - 1, from)] = '\0';
    (void)pclose(from);
    return texts[program];
}

/* The line of an option; NULL: it has none. */
static const char *line_of(const char *help, const char *option)
{
    char head[80];
    const size_t length = (size_t)snprintf(head, sizeof head, "\n  --%s", option);
    for (const char *at = help; (at = strstr(at, head)); at++)
        if (strchr(" \n[", at[length]))
            return at + 1;
    return NULL;
}

/* -------------------------------------------------------------------------------------- rows -- */

static const char *word_of(const lf_param *row, int index)
{
    if (row->word_at)
        return row->word_at(index);
    return row->words ? row->words[index] : NULL;
}

static void print_programs(const lf_table_source *source, const char *option, FILE *out)
{
    const char *comma = "";
    for (int i = 0; i < N_PROGRAMS; i++)
        if (line_of(help_of(source, i), option)) {
            fprintf(out, "%s%s", comma, programs[i]);
            comma = ", ";
        }
}

/* "`a`, `b`", "5 to 600 lpi" */
static void print_value(const lf_param *row, FILE *out)
{
    const char *comma = "";
    if (row->type == LF_PARAM_LIST)
        fputs("`all`, `none`, or some of ", out);
    if (row->type == LF_PARAM_SEED)
        fputs("0 to 2^64 - 1", out);
    for (int i = 0; word_of(row, i); i++, comma = ", ")
        fprintf(out, "%s`%s`", comma, word_of(row, i));
    if ((row->type != LF_PARAM_NUMBER && word_of(row, 0)) || row->high <= row->low)
        return;
    fputs(comma, out);
    lf_table_number(row->low, out);
    fputs(" to ", out);
    lf_table_number(row->high, out);
    if (row->unit)
        fprintf(out, " %s", row->unit);
    if (row->type == LF_PARAM_RASTER)
        fputs(", or `XxY`", out);
}

static bool same_value(const lf_param *a, const lf_param *b)
{
    return a->type == b->type && a->low == b->low && a->high == b->high && a->words == b->words;
}

/* Of all parts of an option; of parts that differ with what --help calls them. */
static void print_values(const lf_param *row, FILE *out)
{
    const lf_param *end = lf_param_next(row);
    bool differ = false;
    for (const lf_param *part = row + 1; part < end; part++)
        differ = differ || !same_value(row, part);
    for (const lf_param *part = row; part < (differ ? end : row + 1); part++) {
        if (differ)
            fprintf(out, "%s%s: ", part > row ? "; " : "", part->argument);
        print_value(part, out);
    }
}

/* What it is if it is not given: by the row, or in brackets at the end of its help. */
static void print_default(const lf_param *row, const char *in_brackets, FILE *out)
{
    const bool switched = row->type == LF_PARAM_SWITCH && !word_of(row, 0);
    if (in_brackets[0] != '\0')
        fputs(in_brackets, out);
    else if (switched || row->required || row->type == LF_PARAM_LIST)
        fputs(switched ? "off" : "", out);
    else if (row->type == LF_PARAM_WHOLE && word_of(row, 0))
        fprintf(out, "`%g`", row->initial);
    else if (word_of(row, 0) && row->type != LF_PARAM_NUMBER) {
        if (row->initial >= 0)
            fprintf(out, "`%s`", word_of(row, (int)row->initial));
    } else if (!row->has && row->high > row->low && row->initial >= row->low &&
               row->initial <= row->high)
        lf_table_number(row->initial, out);
}

/* "mvpt: all views share each path; vpt: …" */
static void print_what(const lf_table_source *source, const lf_param *row, const char *before,
                       FILE *out)
{
    for (int i = 0; row->what_at && word_of(row, i); i++)
        if (row->what_at(i) && row->what_at(i)[0] != '\0') {
            fprintf(out, "%s`%s`: ", before, word_of(row, i));
            lf_table_text(source, row->what_at(i), NULL, out);
            before = "; ";
        }
}

static json_t *words_of(const lf_param *row)
{
    json_t *words = json_array();
    for (int i = 0; word_of(row, i); i++)
        json_array_append_new(words, json_string(word_of(row, i)));
    return words;
}

static void print_option(const lf_table_source *source, const lf_param *row, FILE *out)
{
    char argument[64], kept[1000], in_brackets[1000];
    const char *text = row->help ? row->help : row->about ? row->about : "";
    json_t *words = words_of(row);
    lf_table_default(text, kept, in_brackets, sizeof kept);
    lf_param_argument(row, argument, sizeof argument);
    fprintf(out, "| `--%s%s", row->option, argument[0] != '\0' ? " " : "");
    for (const char *c = argument; *c != '\0'; c++)
        fprintf(out, "%s%c", *c == '|' ? "\\" : "", *c);
    fputs("` | ", out);
    print_values(row, out);
    fputs(" | ", out);
    print_default(row, in_brackets, out);
    fputs(" | ", out);
    lf_table_text(source, kept, words, out);
    print_what(source, row, kept[0] != '\0' ? ": " : "", out);
    fputs(" | ", out);
    print_programs(source, row->option, out);
    fputs(" |\n", out);
    json_decref(words);
}

static void print_rows(const lf_table_source *source, const lf_param *params, const char *names,
                       FILE *out)
{
    for (const lf_param *row = params; row && (row->name || row->option); row = lf_param_next(row))
        if (!row->former && lf_param_among(row, names))
            print_option(source, row, out);
}

/* The text of --help from a column on, and of the lines below it. */
static void join_help(const char *line, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    const char *at = line + strcspn(line, "\n");
    const size_t first = (size_t)(at - line);
    if (first > COLUMN && line[COLUMN - 1] == ' ')
        used = (size_t)snprintf(text, size, "%.*s", (int)(first - COLUMN), line + COLUMN);
    while (*at == '\n' && strspn(at + 1, " ") == COLUMN && used < size) {
        at += 1 + COLUMN;
        const size_t length = strcspn(at, "\n");
        used += (size_t)snprintf(text + used, size - used, "%s%.*s", used > 0 ? " " : "",
                                 (int)length, at);
        at += length;
    }
}

/* "--socket PATH", up to two blanks or the column. */
static void print_head(const char *line, FILE *out)
{
    const char *end = strstr(line + 2, "  ");
    size_t length = strcspn(line, "\n");
    if (end && (size_t)(end - line) < length)
        length = (size_t)(end - line);
    if (length > COLUMN && line[COLUMN - 1] == ' ')
        length = COLUMN - 1;
    fprintf(out, "| `%.*s`", (int)length - 2, line + 2);
}

static bool print_own(const lf_table_source *source, const struct group *group, FILE *out)
{
    int program = 0;
    while (strcmp(programs[program], group->program) != 0)
        program++;
    for (const char *at = group->own; *at != '\0';) {
        char option[64], text[1000];
        const size_t length = strcspn(at, " ");
        snprintf(option, sizeof option, "%.*s", (int)length, at);
        at += length + (at[length] == ' ');
        const char *line = line_of(help_of(source, program), option);
        if (!line)
            return false;
        join_help(line, text, sizeof text);
        print_head(line, out);
        fputs(" | | | ", out);
        lf_table_text(source, text, NULL, out);
        fputs(" | ", out);
        if (strcmp(group->name, group->program) == 0)
            fputs(group->program, out); /* another program's option of this name is another one */
        else
            print_programs(source, option, out);
        fputs(" |\n", out);
    }
    return true;
}

bool lf_table_options(const lf_table_source *source, const char *name, FILE *out)
{
    int i = 0;
    while (i < N_GROUPS && strcmp(groups[i].name, name) != 0)
        i++;
    if (i == N_GROUPS)
        return false;
    const struct group *group = &groups[i];
    fputs("| option | values | default | meaning | programs |\n|---|---|---|---|---|\n", out);
    const bool reference = strcmp(name, "reference") == 0;
    print_rows(source, reference ? lf_integrator_params() : group->params, group->names, out);
    print_rows(source, group->more, NULL, out);
    return !group->program || print_own(source, group, out);
}
