#include "daemon/output/options.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

/* How many long options the text before any '=' could mean. */
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

int lf_options_append(struct option *table, int n, int n_most, const lf_param *params,
                      int first_code)
{
    for (const lf_param *row = params; row->name || row->option; row = lf_param_next(row)) {
        if (!row->option)
            continue;
        assert(n < n_most);
        const bool bare = row->type == LF_PARAM_SWITCH && !row->words;
        table[n++] = (struct option){row->option, bare ? no_argument : required_argument, NULL,
                                     first_code + (int)(row - params)};
    }
    table[n] = (struct option){0};
    return n;
}

lf_status lf_options_next(int argc, char *const argv[], const char *letters,
                          const struct option *table, int *out_code, lf_error *err)
{
    char where[128];
    opterr = 0;
    int code = getopt_long(argc, argv, letters, table, NULL);
    if (code != '?' && code != ':') {
        *out_code = code;
        return LF_OK;
    }
    const char *text = optind > 0 && optind <= argc ? argv[optind - 1] : "";
    if (optopt >= LF_OPTION_PRESET) {
        snprintf(where, sizeof where, "--%s", name_of_code(table, optopt));
        return lf_error_set(err, LF_E_ARG, where,
                            code == ':' ? "expects an argument" : "takes no argument");
    }
    if (optopt != 0) {
        snprintf(where, sizeof where, "-%c", optopt);
        return lf_error_set(err, LF_E_ARG, where,
                            code == ':' ? "expects an argument" : "unknown option (see --help)");
    }
    snprintf(where, sizeof where, "%.100s", text);
    if (strncmp(text, "--", 2) == 0 && count_matches(table, text + 2) > 1)
        return lf_error_set(err, LF_E_ARG, where, "could mean several options (see --help)");
    return lf_error_set(err, LF_E_ARG, where, "unknown option (see --help)");
}

lf_status lf_options_read(int argc, char *const argv[], const lf_options_rules *rules,
                          bool *out_done, lf_error *err)
{
    *out_done = false;
    for (;;) {
        int code = 0;
        bool taken = false;
        lf_status status = lf_options_next(argc, argv, rules->letters, rules->table, &code, err);
        if (status != LF_OK || code == -1)
            return status;
        if (code == LF_OPTION_HELP || code == LF_OPTION_VERSION) {
            code == LF_OPTION_HELP ? rules->print_help() : lf_print_version(rules->program);
            *out_done = true;
            return LF_OK;
        }
        if (rules->shared)
            status = lf_options_take(rules->shared, code, optarg, &taken, err);
        if (status == LF_OK && !taken)
            status = rules->take(rules->context, code, optarg, err);
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
