/* quiltfarm: divides a job of quiltrender into tasks, and has a farm run them. See
 * docs/man/quiltfarm.1. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/nearest.h"
#include "daemon/farm/farm.h"
#include "daemon/farm/farm_process.h"
#include "daemon/output/options.h"

#define PROGRAM "quiltfarm"

/* What a command does, which says what it takes: options, steps, and words behind "--". */
enum { PLANS = 1, SENDS = 2, LOOKS = 4, RUNS = 8, OTHER = 16 };

static const struct command {
    const char *name, *words, *what;
    lf_status (*run)(const lf_farm_command *command, lf_error *err);
    int kind;
} commands[] = {
    {"plan", "JOB -- SCENE -o OUT ...", "divide a job, tell its cost, and make its folder",
     lf_farm_plan, PLANS},
    {"submit", "JOB [-- OPTION ...]", "send what is missing, with options for sbatch or parallel",
     lf_farm_submit, SENDS},
    {"status", "JOB", "show what is complete, what failed, the cost and the time left",
     lf_farm_status, LOOKS},
    {"resume", "JOB [-- OPTION ...]", "submit again as last time, failed tasks, too",
     lf_farm_resume, SENDS},
    {"merge", "JOB", "make the output here when all tasks are complete", lf_farm_merge, OTHER},
    {"cancel", "JOB", "end all tasks; what they rendered is kept", lf_farm_cancel, OTHER},
    {"task", "JOB K[:L]", "run tasks: the commands in JOB/tasks", lf_farm_task, RUNS},
    {"finish", "JOB K[:L]", "run finishes: the commands in JOB/finishes", lf_farm_finish, RUNS},
};

enum { N_COMMANDS = sizeof commands / sizeof *commands, MOST_WORDS = 4096 };

static void print_help(void)
{
    char left[80];
    printf(
        "Usage: quiltfarm COMMAND JOB [options] [-- words]\n"
        "Render what quiltrender renders, on the machines of a farm. JOB is a folder that all of "
        "them see.\n"
        "\n");
    for (int i = 0; i < N_COMMANDS; i++) {
        snprintf(left, sizeof left, "%s %s", commands[i].name, commands[i].words);
        printf("  %-30s %s\n", left, commands[i].what);
    }
    printf("\n");
    lf_param_print_help(lf_farm_params, NULL);
    printf(LF_OPTIONS_HELP_LAST LF_OPTIONS_HELP_SHELLS);
}

static const char *operand_at(int index)
{
    return index < N_COMMANDS ? commands[index].name : NULL;
}

/* JOB is a folder. */
static bool follower_at(int operand, int index, char *word, size_t size)
{
    (void)operand;
    (void)index;
    if (size > 0)
        word[0] = '\0';
    return false;
}

static lf_status unknown_command(const char *word, lf_error *err)
{
    const char *names[N_COMMANDS + 1] = {NULL};
    for (int i = 0; i < N_COMMANDS; i++)
        names[i] = commands[i].name;
    return lf_nearest_refuse(word, "command", names, err);
}

static const struct command *find_command(const char *name)
{
    for (int i = 0; i < N_COMMANDS; i++)
        if (strcmp(name, commands[i].name) == 0)
            return &commands[i];
    return NULL;
}

static lf_status forgotten_dashes(const struct command *command, const char *word, lf_error *err)
{
    return lf_error_set(err, LF_E_ARG, word,
                        "is no word of quiltfarm %s; pass words of %s after --", command->name,
                        command->kind == PLANS ? "quiltrender" : "sbatch or parallel");
}

/* quiltfarm has no options of one letter, so such a word is meant for another program. n: words
 * before "--". */
static lf_status check_letters(int n, char *const argv[], lf_error *err)
{
    const struct command *command = n > 1 ? find_command(argv[1]) : NULL;
    for (int i = 2; i < n && command && command->kind & (PLANS | SENDS); i++)
        if (argv[i][0] == '-' && isalpha((unsigned char)argv[i][1]))
            return forgotten_dashes(command, argv[i], err);
    return LF_OK;
}

static lf_status check_options(const struct command *command, const lf_farm_options *o,
                               lf_error *err)
{
    const struct {
        const char *name;
        int kinds;
        bool given;
    } options[] = {
        {"engine", PLANS, o->engine},           {"task-minutes", PLANS, o->task_minutes >= 0},
        {"task-memory", PLANS, o->task_memory}, {"threads", PLANS, o->threads > 0},
        {"slots", PLANS | SENDS, o->slots > 0}, {"json", PLANS | LOOKS, o->json},
        {"check", LOOKS | SENDS, o->check}};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        if (options[i].given && !(options[i].kinds & command->kind))
            return lf_error_set(err, LF_E_ARG, command->name, "takes no --%s", options[i].name);
    return LF_OK;
}

static lf_status take_operands(int n, char *const operands[], lf_farm_command *command,
                               const struct command **out, lf_error *err)
{
    if (n < 1)
        return lf_error_set(err, LF_E_ARG, "COMMAND", "is missing; see --help");
    *out = find_command(operands[0]);
    if (!*out)
        return unknown_command(operands[0], err);
    const int expected = (*out)->kind == RUNS ? 3 : 2;
    const bool takes_words = (*out)->kind & (PLANS | SENDS);
    if (n > expected && takes_words && !command->words[0])
        return forgotten_dashes(*out, operands[expected], err);
    if (n > expected)
        return lf_error_set(err, LF_E_ARG, operands[expected],
                            "is one word too many; %s expects %s", (*out)->name, (*out)->words);
    if (n < expected)
        return lf_error_set(err, LF_E_ARG, (*out)->name, "expects %s", (*out)->words);
    if (command->words[0] && !takes_words)
        return lf_error_set(err, LF_E_ARG, (*out)->name, "takes no words after --");
    command->job = operands[1];
    command->steps = (*out)->kind == RUNS ? operands[2] : NULL;
    return check_options(*out, command->options, err);
}

/* argv without what follows "--", which goes to command->words. */
static lf_status read_arguments(int argc, char *argv[], lf_farm_options *options,
                                lf_farm_command *command, const struct command **out,
                                bool *out_done, lf_error *err)
{
    static char *own[MOST_WORDS];
    const lf_options_part parts[] = {{.params = lf_farm_params, .object = options}, {NULL}};
    const lf_options_rules rules = {.program = PROGRAM,
                                    .letters = ":",
                                    .parts = parts,
                                    .print_help = print_help,
                                    .operand_at = operand_at,
                                    .follower_at = follower_at};
    int n = 0;
    while (n < argc && strcmp(argv[n], "--") != 0)
        n++;
    if (n >= MOST_WORDS)
        return lf_error_set(err, LF_E_ARG, "COMMAND", "has too many words");
    memcpy(own, argv, (size_t)n * sizeof *own);
    command->words = argv + (n < argc ? n + 1 : argc);
    lf_status status = check_letters(n, own, err);
    if (status == LF_OK)
        status = lf_options_read(n, own, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    return take_operands(n - optind, own + optind, command, out, err);
}

int main(int argc, char *argv[])
{
    lf_farm_options options = {.task_minutes = -1};
    lf_farm_command command = {.options = &options};
    const struct command *chosen = NULL;
    lf_error err = {0};
    bool done = false;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    lf_farm_keep_others_out();
    lf_status status = read_arguments(argc, argv, &options, &command, &chosen, &done, &err);
    if (status == LF_OK && !done)
        status = chosen->run(&command, &err);
    if (status == LF_E_ARG)
        return lf_usage_error(PROGRAM, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    if (status == LF_E_CANCELLED)
        return LF_EXIT_INTERRUPTED;
    return status == LF_OK && fflush(stdout) == 0 ? LF_EXIT_OK : LF_EXIT_FAILED;
}
