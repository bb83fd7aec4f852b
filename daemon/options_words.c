#include "daemon/options.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
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

lf_status lf_options_next(int argc, char *const argv[], const char *letters, const struct option *table, int *out_code,
                          lf_error *err)
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
        return lf_error_set(err, LF_E_ARG, where, code == ':' ? "expects an argument" : "takes no argument");
    }
    if (optopt != 0) {
        snprintf(where, sizeof where, "-%c", optopt);
        return lf_error_set(err, LF_E_ARG, where, code == ':' ? "expects an argument" : "unknown option (see --help)");
    }
    snprintf(where, sizeof where, "%.100s", text);
    if (strncmp(text, "--", 2) == 0 && count_matches(table, text + 2) > 1)
        return lf_error_set(err, LF_E_ARG, where, "could mean several options (see --help)");
    return lf_error_set(err, LF_E_ARG, where, "unknown option (see --help)");
}

lf_status lf_options_read(int argc, char *const argv[], const lf_options_rules *rules, bool *out_done, lf_error *err)
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

/* ------------------------------------------------------------------------------------------------------- numbers -- */

lf_status lf_parse_int(const char *option, const char *text, int64_t low, int64_t high, int64_t *out, lf_error *err)
{
    char *end = NULL;
    bool starts = (text[0] >= '0' && text[0] <= '9') || text[0] == '-' || text[0] == '+';

    errno = 0;
    long long value = starts ? strtoll(text, &end, 10) : 0;
    if (!starts || errno != 0 || *end != '\0' || value < low || value > high)
        return lf_error_set(err, LF_E_ARG, option, "expects a whole number from %" PRId64 " to %" PRId64 ", not \"%s\"", low, high,
                            text);
    *out = value;
    return LF_OK;
}

/* Reads one decimal number up to `stop`, which must follow it. */
static bool read_double(const char *text, char stop, double low, double high, double *out, const char **out_end)
{
    char *end = NULL;

    if (strspn(text, "+-.0123456789") == 0 || strpbrk(text, "xXpP"))
        return false;
    double value = strtod(text, &end);
    if (end == text || *end != stop || !(value >= low && value <= high))
        return false;
    *out = value;
    *out_end = end;
    return true;
}

lf_status lf_parse_small(const char *option, const char *text, int low, int high, int *out, lf_error *err)
{
    int64_t value = 0;
    lf_status status = lf_parse_int(option, text, low, high, &value, err);

    if (status == LF_OK)
        *out = (int)value;
    return status;
}

lf_status lf_parse_double(const char *option, const char *text, double low, double high, double *out, lf_error *err)
{
    const char *end = NULL;

    if (!read_double(text, '\0', low, high, out, &end))
        return lf_error_set(err, LF_E_ARG, option, "expects a number from %g to %g, not \"%s\"", low, high, text);
    return LF_OK;
}

lf_status lf_parse_pair(const char *option, const char *text, char separator, double low, double high, double out[2], lf_error *err)
{
    /* "x" cannot be told from hexadecimal by strtod: cut the text in two first */
    const char *cut = strchr(text, separator);
    const char *end = NULL;
    char first[32];
    double pair[2];

    if (cut && (size_t)(cut - text) < sizeof first) {
        memcpy(first, text, (size_t)(cut - text));
        first[cut - text] = '\0';
        if (read_double(first, '\0', low, high, &pair[0], &end) && read_double(cut + 1, '\0', low, high, &pair[1], &end)) {
            memcpy(out, pair, sizeof pair);
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, option, "expects two numbers A%cB from %g to %g, not \"%s\"", separator, low, high, text);
}

lf_status lf_parse_seed(const char *option, const char *text, uint64_t *out, lf_error *err)
{
    char *end = NULL;
    bool starts = text[0] >= '0' && text[0] <= '9';

    errno = 0;
    unsigned long long value = starts ? strtoull(text, &end, 10) : 0;
    if (!starts || errno != 0 || *end != '\0')
        return lf_error_set(err, LF_E_ARG, option, "expects a whole number from 0 to %" PRIu64 ", not \"%s\"", UINT64_MAX, text);
    *out = value;
    return LF_OK;
}
