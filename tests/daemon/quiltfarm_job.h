/* A job of quiltfarm for the engine list, and what its status answers. */
#ifndef LF_TESTS_DAEMON_QUILTFARM_JOB_H
#define LF_TESTS_DAEMON_QUILTFARM_JOB_H

#include "tests/daemon/quiltfarm.h"

#include <jansson.h>

#define PLAN "bin/quiltfarm plan job --engine list -- scene.json -o out"

static void plan(const char *folder)
{
    says(folder, PLAN, 0, "5 tasks and 3 finishes, for list");
}

/* A part of what status --json answers; a new reference. */
static json_t *status_of(const char *folder, const char *key)
{
    assert_int_equal(run(folder, "bin/quiltfarm status job --json 2> /dev/null"), 0);
    json_t *status = json_loads(got.text, 0, NULL);
    assert_non_null(status);
    json_t *value = json_incref(json_object_get(status, key));
    json_decref(status);
    assert_non_null(value);
    return value;
}

static void assert_state(const char *folder, const char *expected)
{
    json_t *state = status_of(folder, "state");
    assert_string_equal(json_string_value(state), expected);
    json_decref(state);
}

static void assert_tasks(const char *folder, const char *key, int expected)
{
    json_t *tasks = status_of(folder, "tasks");
    assert_int_equal(json_integer_value(json_object_get(tasks, key)), expected);
    json_decref(tasks);
}

/* The words of the first failed step. */
static void assert_failed(const char *folder, const char *expected)
{
    json_t *failed = status_of(folder, "failed");
    const char *words = json_string_value(json_object_get(json_array_get(failed, 0), "words"));
    if (!words || !strstr(words, expected))
        fail_msg("\"%s\" instead of \"%s\"", words ? words : "no failure", expected);
    json_decref(failed);
}

static bool is_there(const char *folder, const char *name)
{
    return access(lf_test_path(folder, name), F_OK) == 0;
}

#define EVERYTHING "sh -e job/tasks && bin/quiltfarm merge job"
/* What one run writes. */
#define DIRECT "bin/quiltrender scene.json -o direct --camera-rows 0:2"
#define SAME "diff -r out direct"

#endif
