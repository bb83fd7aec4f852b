#include "daemon/output/options.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/former.h"
#include "base/nearest.h"
#include "base/version.h"
#include "daemon/output/completion.h"

#define MAX_OPTIONS 256

/* Codes after a program's own: help, the version, then PART_SIZE rows per part. */
enum { CODE_HELP = 2 * LF_OPTION_OWN, CODE_VERSION, CODE_PART, PART_SIZE = 256 };

/* The number of long options that the text before any '=' may abbreviate. */
static int count_matches(const struct option *table, const char *text)
{
    size_t n = strcspn(text, "=");
    int matches = 0;
    for (; table->name; table++)
        matches += strncmp(table->name, text, n) == 0;
    return matches;
}

static const char *name_of_code(const struct option *table, int code)
{
    for (; table->name; table++)
        if (table->val == code)
            return table->name;
    return "";
}

/* ------------------------------------------------------------------------ getopt's own table -- */

static int append(struct option *table, int n, const char *name, int has_argument, int code)
{
    assert(n < MAX_OPTIONS);
    table[n++] = (struct option){name, has_argument, NULL, code};
    table[n] = (struct option){0};
    return n;
}

/* With the code of the option that replaced it; name_of_code finds that one first. */
static int append_former(struct option *table, int n, const char *former, const char *name)
{
    int i = 0;
    while (table[i].name && strcmp(table[i].name, name) != 0)
        i++;
    assert(i < n);
    return append(table, n, former, table[i].has_arg, table[i].val);
}

static void make_table(const lf_options_rules *rules, struct option *table)
{
    int n = 0;
    for (int i = 0; rules->parts && rules->parts[i].params; i++) {
        const lf_options_part *part = &rules->parts[i];
        for (const lf_param *row = part->params; row->name || row->option;
             row = lf_param_next(row)) {
            const int takes = row->type == LF_PARAM_SWITCH && !row->words ? no_argument
                              : row->optional                             ? optional_argument
                                                                          : required_argument;
            if (lf_param_among(row, part->names))
                n = append(table, n, row->option, takes,
                           CODE_PART + i * PART_SIZE + (int)(row - part->params));
        }
    }
    for (const struct option *own = rules->table; own && own->name; own++)
        n = append(table, n, own->name, own->has_arg, own->val);
    for (int i = 0; rules->former && rules->former[i][0]; i++)
        n = append_former(table, n, rules->former[i][0], rules->former[i][1]);
    if (!rules->print_help)
        return;
    n = append(table, n, "help", no_argument, CODE_HELP);
    append(table, n, "version", no_argument, CODE_VERSION);
}

/* where: the argument with its dashes. */
static lf_status unknown(const struct option *table, const char *where, lf_error *err)
{
    const char *names[MAX_OPTIONS + 1], *meant = NULL;
    char word[128] = "";
    int n = 0;
    for (int i = 0; table[i].name; i++) /* not former names, whose code another one has first */
        if (strcmp(table[i].name, name_of_code(table, table[i].val)) == 0)
            names[n++] = table[i].name;
    names[n] = NULL;
    if (strncmp(where, "--", 2) == 0)
        snprintf(word, sizeof word, "%.*s", (int)strcspn(where + 2, "="), where + 2);
    if (word[0])
        meant = lf_nearest_name(word, names);
    return meant ? lf_error_set(err, LF_E_ARG, where, "unknown option; did you mean --%s?", meant)
                 : lf_error_set(err, LF_E_ARG, where, "unknown option; see --help");
}

static void log_former(const char *former, const char *name)
{
    char old[64], now[64];
    snprintf(old, sizeof old, "--%s", former);
    snprintf(now, sizeof now, "--%s", name);
    (void)lf_former_used(LF_VERSION, NULL, old, now);
}

/* getopt_long without its own messages; *out_code is -1 after the last option. */
static lf_status read_next(int argc, char *const argv[], const char *letters,
                           const struct option *table, int *out_code, lf_error *err)
{
    char where[128];
    opterr = 0;
    int at = -1, code = getopt_long(argc, argv, letters, table, &at);
    if (code != '?' && code != ':') {
        const char *given = at >= 0 && code < CODE_HELP ? table[at].name : NULL;
        if (given && strcmp(given, name_of_code(table, code)) != 0)
            log_former(given, name_of_code(table, code));
        *out_code = code;
        return LF_OK;
    }
    const char *text = optind > 0 && optind <= argc ? argv[optind - 1] : "";
    if (optopt >= LF_OPTION_OWN) {
        snprintf(where, sizeof where, "--%s", name_of_code(table, optopt));
        return lf_error_set(err, LF_E_ARG, where,
                            code == ':' ? "expects an argument" : "takes no argument");
    }
    if (optopt != 0) {
        snprintf(where, sizeof where, "-%c", optopt);
        return lf_error_set(err, LF_E_ARG, where,
                            code == ':' ? "expects an argument" : "unknown option; see --help");
    }
    snprintf(where, sizeof where, "%.100s", text);
    if (strncmp(text, "--", 2) == 0 && count_matches(table, text + 2) > 1)
        return lf_error_set(err, LF_E_ARG, where,
                            "is ambiguous; give the whole name of the option (see --help)");
    return unknown(table, where, err);
}

static bool is_word_of(const lf_param *row, const char *word)
{
    for (int i = 0; row->words && row->words[i]; i++)
        if (strcmp(row->words[i], word) == 0)
            return true;
    return false;
}

/* True if the word after an option is its optional argument; a word that looks like a file is an
 * operand. One of the option's words never is; a folder's name is, too, if it has words. */
static bool is_argument(const lf_param *row, const char *word)
{
    struct stat file;
    if (!word || word[0] == '-' || word[0] == '\0')
        return false;
    if (is_word_of(row, word))
        return true;
    return !strpbrk(word, "./") &&
           !(stat(word, &file) == 0 && (S_ISREG(file.st_mode) || row->words));
}

static lf_status take_row(const lf_options_rules *rules, char *const argv[], int code,
                          lf_error *err)
{
    const lf_options_part *part = &rules->parts[code / PART_SIZE];
    const lf_param *row = &part->params[code % PART_SIZE];
    const char *text = optarg;
    if (row->optional && !text && is_argument(row, argv[optind])) /* argv ends with NULL */
        text = argv[optind++];
    if (row->former)
        log_former(row->option, row->former);
    lf_status status = lf_param_from_text(row, text, part->object, err);
    if (status == LF_OK && rules->taken)
        rules->taken(rules->context, part->params, row);
    return status;
}

lf_status lf_options_read(int argc, char *const argv[], const lf_options_rules *rules,
                          bool *out_done, lf_error *err)
{
    struct option table[MAX_OPTIONS + 1] = {0};
    *out_done = lf_completion_takes_rules(rules);
    if (*out_done)
        return LF_OK;
    if (rules->print_help && argc == 3 && strcmp(argv[1], "--completion") == 0) {
        *out_done = true;
        return lf_completion_write(rules, argv[2], stdout, err);
    }
    make_table(rules, table);
    for (;;) {
        int code = 0;
        lf_status status = read_next(argc, argv, rules->letters, table, &code, err);
        if (status != LF_OK || code == -1)
            return status;
        if (code == CODE_HELP || code == CODE_VERSION) {
            assert(rules->print_help); /* otherwise the table has neither option */
            code == CODE_HELP ? rules->print_help() : lf_print_version(rules->program);
            *out_done = true;
            return LF_OK;
        }
        status = code >= CODE_PART ? take_row(rules, argv, code - CODE_PART, err)
                                   : rules->take(rules->context, code, optarg, err);
        if (status != LF_OK)
            return status;
    }
}

int lf_usage_error(const char *program, const lf_error *err)
{
    char line[1400];
    fprintf(stderr, "%s: %s\n", program, lf_error_format(err, line, sizeof line));
    return LF_EXIT_USAGE;
}

void lf_print_version(const char *program)
{
    printf("%s %s\n", program, LF_VERSION);
}
