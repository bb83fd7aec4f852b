#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "device/sim/sim.h"

#define MAX_NUMBER UINT64_C(1000000000000)
#define ROTATE_BYTES (UINT64_C(16) << 20)

/* Options whose value is one whole number. */
static const struct number_option {
    const char *name;
    size_t offset;
    uint64_t least;
} number_options[] = {
    {"latency", offsetof(lf_sim_options, latency_ms), 0},
    {"bandwidth", offsetof(lf_sim_options, bandwidth), 1},
    {"error", offsetof(lf_sim_options, error_push), 1},
    {"error_every", offsetof(lf_sim_options, error_every), 1},
    {"unplug", offsetof(lf_sim_options, unplug_updates), 1},
    {"replug", offsetof(lf_sim_options, replug_ms), 0},
    {"rotate", offsetof(lf_sim_options, rotate_bytes), 1},
};

/* A whole number at text up to `end`; false when it is anything else. */
static bool parse_number(const char *text, const char *end, uint64_t least, uint64_t *out)
{
    uint64_t value = 0;
    if (text == end)
        return false;
    for (; text < end; text++) {
        if (*text < '0' || *text > '9')
            return false;
        value = value * 10 + (uint64_t)(*text - '0');
        if (value > MAX_NUMBER)
            return false;
    }
    *out = value;
    return value >= least;
}

static bool parse_stall(const char *text, const char *end, lf_sim_options *out)
{
    const char *colon = memchr(text, ':', (size_t)(end - text));
    out->stall_ms = LF_SIM_NEVER;
    if (colon && !parse_number(colon + 1, end, 0, &out->stall_ms))
        return false;
    return parse_number(text, colon ? colon : end, 1, &out->stall_push);
}

static bool parse_eye(const char *text, const char *end, double *out)
{
    char number[32];
    size_t length = (size_t)(end - text);
    if (length == 0 || length >= sizeof number || strspn(text, "+-.0123456789") < length)
        return false;
    memcpy(number, text, length);
    number[length] = 0;
    return lf_decimal_is(number, out) && fabs(*out) <= 90;
}

/* One "name=value" of `length` bytes. */
static lf_status parse_option(const char *option, size_t length, lf_sim_options *out, lf_error *err)
{
    const char *end = option + length, *equals = memchr(option, '=', length);
    if (!equals)
        return lf_error_set(err, LF_E_ARG, "sim",
                            "option \"%.*s\" has no value; expected name=value", (int)length,
                            option);
    size_t name_length = (size_t)(equals - option);
    bool known = true, good = false;
    if (name_length == 3 && memcmp(option, "eye", 3) == 0) {
        good = parse_eye(equals + 1, end, &out->eye_deg);
    } else if (length == 8 && memcmp(option, "links=no", 8) == 0) {
        good = out->no_links = true;
    } else if (name_length == 5 && memcmp(option, "stall", 5) == 0) {
        good = parse_stall(equals + 1, end, out);
    } else {
        known = false;
        for (size_t i = 0; i < sizeof number_options / sizeof *number_options && !known; i++) {
            const struct number_option *o = &number_options[i];
            known = strlen(o->name) == name_length && memcmp(o->name, option, name_length) == 0;
            if (known)
                good = parse_number(equals + 1, end, o->least,
                                    (uint64_t *)(void *)((char *)out + o->offset));
        }
    }
    if (!known)
        return lf_error_set(err, LF_E_ARG, "sim",
                            "unknown option \"%.*s\"; expected eye, latency, bandwidth, stall, "
                            "error, error_every, unplug, replug, rotate or links=no",
                            (int)name_length, option);
    if (!good)
        return lf_error_set(err, LF_E_ARG, "sim", "option \"%.*s\" has a value outside its range",
                            (int)length, option);
    return LF_OK;
}

lf_status lf_sim_options_parse(const char *argument, lf_sim_options *out, lf_error *err)
{
    lf_sim_options options = {.replug_ms = LF_SIM_NEVER, .rotate_bytes = ROTATE_BYTES};
    size_t length = strcspn(argument, ",");
    if (length == 0)
        return lf_error_set(err, LF_E_ARG, "sim",
                            "no folder given; expected sim:DIR[,option=value]");
    if (length >= sizeof options.dir)
        return lf_error_set(err, LF_E_ARG, "sim", "the folder's name is longer than %zu bytes",
                            sizeof options.dir - 1);
    memcpy(options.dir, argument, length);
    while (argument[length] == ',') {
        argument += length + 1;
        length = strcspn(argument, ",");
        lf_status status = parse_option(argument, length, &options, err);
        if (status != LF_OK)
            return status;
    }
    *out = options;
    return LF_OK;
}
