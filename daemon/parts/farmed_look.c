/* Reads what `quiltfarm status --json` says. Everything in it may be missing or wrong. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/parts/farmed_internal.h"

static const char where[] = LF_FARMED_PROGRAM " status";

static bool is_state(const char *name)
{
    static const char *const names[] = {"planned",  "queued",  "running",    "failed",
                                        "complete", "merging", "interrupted"};
    for (size_t i = 0; name && i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i], name) == 0)
            return true;
    return false;
}

/* A count of tasks; -1: it is none. */
static int64_t count_of(const json_t *tasks, const char *key)
{
    const json_t *value = json_object_get(tasks, key);
    const json_int_t n = json_integer_value(value);
    return json_is_integer(value) && n >= 0 ? (int64_t)n : -1;
}

/* -1: unknown. */
static double seconds_of(const json_t *value)
{
    const double seconds = json_number_value(value);
    return json_is_number(value) && seconds >= 0 && isfinite(seconds) ? seconds : -1;
}

static bool read_tasks(const json_t *tasks, lf_farmed_look *out)
{
    out->total = count_of(tasks, "total");
    out->complete = count_of(tasks, "complete");
    out->running = count_of(tasks, "running");
    out->failed = count_of(tasks, "failed");
    out->missing = count_of(tasks, "missing");
    return out->total >= 0 && out->complete >= 0 && out->complete <= out->total &&
           out->running >= 0 && out->failed >= 0 && out->missing >= 0;
}

lf_status lf_farmed_look_read(const char *text, lf_farmed_look *out, char **out_words,
                              lf_error *err)
{
    lf_farmed_look look = {.planned = -1};
    json_t *root = json_loads(text, 0, NULL);
    const char *state = json_string_value(json_object_get(root, "state"));
    const json_t *cpu = json_object_get(root, "cpu_seconds");
    const char *words = json_string_value(
        json_object_get(json_array_get(json_object_get(root, "failed"), 0), "words"));
    lf_status status = LF_OK;
    if (!is_state(state) || !read_tasks(json_object_get(root, "tasks"), &look))
        status = lf_error_set(err, LF_E_FORMAT, where,
                              "expected a state and its tasks as JSON; install quiltfarm of the "
                              "same version");
    if (status == LF_OK && words && !(*out_words = lf_strdup(words)))
        status = lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    if (status == LF_OK) {
        memcpy(look.state, state, strlen(state) + 1);
        look.planned = seconds_of(json_object_get(cpu, "planned"));
        look.spent = seconds_of(json_object_get(cpu, "spent"));
        look.seconds_left = seconds_of(json_object_get(root, "seconds_left"));
        *out = look;
    }
    json_decref(root);
    return status;
}
