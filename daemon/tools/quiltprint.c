/* quiltprint: keeps profiles of lens sheets and printers, and checks prints. See
 * docs/man/quiltprint.1. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/nearest.h"
#include "daemon/output/options.h"
#include "daemon/tools/print_check.h"

#define PROGRAM "quiltprint"

enum { OPTION_FOLDER = LF_OPTION_OWN, OPTION_JSON, OPTION_MANIFEST };

static const struct option table[] = {
    {"folder", required_argument, NULL, OPTION_FOLDER},
    {"json", no_argument, NULL, OPTION_JSON},
    {"manifest", required_argument, NULL, OPTION_MANIFEST},
    {NULL, 0, NULL, 0},
};

static const struct command {
    const char *name, *words, *what;
    lf_status (*run)(const lf_profiles_command *command, lf_error *err);
    const char *followers[3];
} commands[] = {
    {"list", "[lenses|printers]", "list all profiles", lf_profiles_list, {"lenses", "printers"}},
    {"show", "[lens|printer] NAME", "print a profile", lf_profiles_show, {"lens", "printer"}},
    {"set",
     "lens|printer NAME KEY=VALUE ...",
     "change a profile, or make one; KEY= removes a key",
     lf_profiles_set,
     {"lens", "printer"}},
    {"calibrate",
     "LENS PRINTER RESULT.json",
     "keep the result of a chart in a lens; KEY=VALUE by hand",
     lf_profiles_calibrate,
     {NULL}},
    {"remove",
     "[lens|printer] NAME",
     "remove a profile of yours",
     lf_profiles_remove,
     {"lens", "printer"}},
    {"check",
     "PRINT.tif",
     "read a print back and check it against its manifest",
     lf_print_check_command,
     {NULL}},
};

enum { N_COMMANDS = sizeof commands / sizeof *commands };

static void print_rows(const char *title, const lf_param *rows)
{
    printf("\n%s\n", title);
    for (; rows->name; rows++)
        printf("  %-22s %s%s%s\n", rows->name, rows->help, rows->unit ? ", in " : "",
               rows->unit ? rows->unit : "");
}

static void print_help(void)
{
    char left[80];
    printf("Usage: quiltprint COMMAND [words] [options]\n"
           "Keep profiles of lens sheets and printers, which quiltrender and quiltd print with, "
           "and check prints.\n"
           "\n");
    for (int i = 0; i < N_COMMANDS; i++) {
        snprintf(left, sizeof left, "%s %s", commands[i].name, commands[i].words);
        printf("  %-42s %s\n", left, commands[i].what);
    }
    printf(
        "\n"
        "  --folder DIR           write to DIR, such as /etc/quiltd, instead of your own folder\n"
        "  --json                 list, show, check: print JSON\n"
        "  --manifest FILE.json   check: the manifest (beside PRINT.tif)\n" LF_OPTIONS_HELP_LAST
            LF_OPTIONS_HELP_SHELLS);
    print_rows("Keys of a lens:", lf_profile_rows(LF_PROFILE_LENS));
    print_rows("Keys of a printer:", lf_profile_rows(LF_PROFILE_PRINTER));
    printf("  %-22s %s\n", "native_dpi", "rasters that the driver does not resample: 300,600");
    print_rows("Keys of a calibration:", lf_calibration_rows);
    printf("  %-22s %s\n", "crosstalk", "shares of light from view -n to n, sum 1");
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    lf_profiles_command *command = context;
    if (code == OPTION_JSON)
        command->json = true;
    else if (code == OPTION_MANIFEST)
        command->manifest = text;
    else if (text[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "--folder", "is empty");
    else
        command->folder = text;
    return LF_OK;
}

static const char *operand_at(int index)
{
    return index < N_COMMANDS ? commands[index].name : NULL;
}

static bool follower_at(int operand, int index, char *word, size_t size)
{
    const char *follower = index < 2 ? commands[operand].followers[index] : NULL;
    if (follower)
        snprintf(word, size, "%s", follower);
    return follower;
}

static lf_status unknown_command(const char *word, lf_error *err)
{
    const char *names[N_COMMANDS + 1] = {NULL};
    for (int i = 0; i < N_COMMANDS; i++)
        names[i] = commands[i].name;
    return lf_nearest_refuse(word, "command", names, err);
}

static lf_status read_arguments(int argc, char *const argv[], lf_profiles_command *command,
                                const struct command **out, bool *out_done, lf_error *err)
{
    const lf_options_rules rules = {.program = PROGRAM,
                                    .letters = ":",
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .context = command,
                                    .operand_at = operand_at,
                                    .follower_at = follower_at};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (optind >= argc)
        return lf_error_set(err, LF_E_ARG, "COMMAND", "is missing; see --help");
    for (int i = 0; i < N_COMMANDS; i++)
        if (strcmp(argv[optind], commands[i].name) == 0)
            *out = &commands[i];
    if (!*out)
        return unknown_command(argv[optind], err);
    command->n = argc - optind - 1;
    command->words = argv + optind + 1;
    return LF_OK;
}

int main(int argc, char *argv[])
{
    lf_profiles_command command = {0};
    const struct command *chosen = NULL;
    lf_error err = {0};
    bool done = false;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    lf_status status = read_arguments(argc, argv, &command, &chosen, &done, &err);
    if (status == LF_OK && !done)
        status = chosen->run(&command, &err);
    if (status == LF_E_ARG)
        return lf_usage_error(PROGRAM, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    return status == LF_OK && fflush(stdout) == 0 ? LF_EXIT_OK : LF_EXIT_FAILED;
}
