#include "base/parse.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

lf_status lf_parse_int(const char *option, const char *text, int64_t low, int64_t high,
                       int64_t *out, lf_error *err)
{
    int64_t value;
    if (!lf_integer_is(text, &value) || value < low || value > high)
        return lf_error_set(err, LF_E_ARG, option,
                            "expects a whole number from %" PRId64 " to %" PRId64 ", not \"%s\"",
                            low, high, text);
    *out = value;
    return LF_OK;
}

static bool read_double(const char *text, double low, double high, double *out)
{
    double value;
    if (!lf_decimal_is(text, &value) || !(value >= low && value <= high))
        return false;
    *out = value;
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
    if (!read_double(text, low, high, out))
        return lf_error_set(err, LF_E_ARG, option, "expects a number from %g to %g, not \"%s\"",
                            low, high, text);
    return LF_OK;
}

lf_status lf_parse_pair(const char *option, const char *text, char separator, double low,
                        double high, double out[2], lf_error *err)
{
    const char *cut = strchr(text, separator);
    char first[64];
    double pair[2];
    if (cut && (size_t)(cut - text) < sizeof first) {
        memcpy(first, text, (size_t)(cut - text));
        first[cut - text] = '\0';
        if (read_double(first, low, high, &pair[0]) && read_double(cut + 1, low, high, &pair[1])) {
            memcpy(out, pair, sizeof pair);
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, option, "expects two numbers A%cB from %g to %g, not \"%s\"",
                        separator, low, high, text);
}

lf_status lf_parse_seed(const char *option, const char *text, uint64_t *out, lf_error *err)
{
    if (!lf_whole_is(text, out))
        return lf_error_set(err, LF_E_ARG, option,
                            "expects a whole number from 0 to %" PRIu64 ", not \"%s\"", UINT64_MAX,
                            text);
    return LF_OK;
}

lf_status lf_parse_bytes(const char *option, const char *text, double *out, lf_error *err)
{
    static const char units[] = "KMGT";
    const size_t n = strlen(text);
    const char *unit = n > 1 ? strchr(units, text[n - 1]) : NULL;
    char number[64];
    double value = 0;
    snprintf(number, sizeof number, "%.*s", (int)(unit ? n - 1 : n), text);
    const bool is_number = n < sizeof number && lf_decimal_is(number, &value);
    if (unit)
        value = ldexp(value, 10 * (int)(unit - units + 1));
    if (!is_number || !(value >= 1 && value <= 1e18))
        return lf_error_set(err, LF_E_ARG, option, "expects a size such as 500M or 2G, not \"%s\"",
                            text);
    *out = value;
    return LF_OK;
}
