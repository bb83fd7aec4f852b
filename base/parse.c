#include "base/parse.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

lf_status lf_parse_int(const char *option, const char *text, int64_t low, int64_t high,
                       int64_t *out, lf_error *err)
{
    char *end = NULL;
    bool starts = (text[0] >= '0' && text[0] <= '9') || text[0] == '-' || text[0] == '+';
    errno = 0;
    long long value = starts ? strtoll(text, &end, 10) : 0;
    if (!starts || errno != 0 || *end != '\0' || value < low || value > high)
        return lf_error_set(err, LF_E_ARG, option,
                            "expects a whole number from %" PRId64 " to %" PRId64 ", not \"%s\"",
                            low, high, text);
    *out = value;
    return LF_OK;
}

/* Reads one decimal number up to `stop`, which must follow it. */
static bool read_double(const char *text, char stop, double low, double high, double *out,
                        const char **out_end)
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

lf_status lf_parse_small(const char *option, const char *text, int low, int high, int *out,
                         lf_error *err)
{
    int64_t value = 0;
    lf_status status = lf_parse_int(option, text, low, high, &value, err);
    if (status == LF_OK)
        *out = (int)value;
    return status;
}

lf_status lf_parse_double(const char *option, const char *text, double low, double high,
                          double *out, lf_error *err)
{
    const char *end = NULL;
    if (!read_double(text, '\0', low, high, out, &end))
        return lf_error_set(err, LF_E_ARG, option, "expects a number from %g to %g, not \"%s\"",
                            low, high, text);
    return LF_OK;
}

lf_status lf_parse_pair(const char *option, const char *text, char separator, double low,
                        double high, double out[2], lf_error *err)
{
    /* "x" cannot be told from hexadecimal by strtod: cut the text in two first */
    const char *cut = strchr(text, separator);
    const char *end = NULL;
    char first[32];
    double pair[2];
    if (cut && (size_t)(cut - text) < sizeof first) {
        memcpy(first, text, (size_t)(cut - text));
        first[cut - text] = '\0';
        if (read_double(first, '\0', low, high, &pair[0], &end) &&
            read_double(cut + 1, '\0', low, high, &pair[1], &end)) {
            memcpy(out, pair, sizeof pair);
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, option, "expects two numbers A%cB from %g to %g, not \"%s\"",
                        separator, low, high, text);
}

lf_status lf_parse_seed(const char *option, const char *text, uint64_t *out, lf_error *err)
{
    char *end = NULL;
    bool starts = text[0] >= '0' && text[0] <= '9';
    errno = 0;
    unsigned long long value = starts ? strtoull(text, &end, 10) : 0;
    if (!starts || errno != 0 || *end != '\0')
        return lf_error_set(err, LF_E_ARG, option,
                            "expects a whole number from 0 to %" PRIu64 ", not \"%s\"", UINT64_MAX,
                            text);
    *out = value;
    return LF_OK;
}
