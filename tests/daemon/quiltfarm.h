/* The program quiltfarm in a folder of a test, with a renderer of the test's own (tests/farm/fake).
 */
#ifndef LF_TESTS_DAEMON_QUILTFARM_H
#define LF_TESTS_DAEMON_QUILTFARM_H

#include "tests/testing.h"

#include <jansson.h>
#include <sys/stat.h>
#include <sys/wait.h>

static struct {
    int code;
    char text[16384]; /* stdout and stderr */
} got;

/* Runs shell words in the folder. */
static int run(const char *folder, const char *words)
{
    const char *said = lf_test_path(folder, "said");
    char command[8192];
    const int n =
        snprintf(command, sizeof command, "cd '%s' && { %s\n} > said 2>&1", folder, words);
    assert_true(n < (int)sizeof command);
    const int status = system(command); /* NOLINT: words of this file */
    assert_true(WIFEXITED(status));
    FILE *file = fopen(said, "r");
    assert_non_null(file);
    got.text[fread(got.text, 1, sizeof got.text - 1, file)] = '\0';
    fclose(file);
    got.code = WEXITSTATUS(status);
    return got.code;
}

/* Runs shell words, which must end with this code and say these words. */
static void says(const char *folder, const char *line, int code, const char *words)
{
    if (run(folder, line) != code || !strstr(got.text, words))
        fail_msg("%s: exit status %d, \"%s\"; expected %d, \"%s\"", line, got.code, got.text, code,
                 words);
}

/* A folder with the scene of tests/farm, and bin/ with quiltfarm and the renderer. */
static int set_up(void **state)
{
    char *folder = lf_test_folder(), words[4096];
    assert_int_equal(mkdir(lf_test_path(folder, "bin"), 0755), 0);
    snprintf(words, sizeof words, "cp '%s' bin/ && cp '%s' '%s' bin/ && cp '%s' .",
             lf_test_built("quiltfarm"), lf_test_source("tests/farm/fake/quiltrender"),
             lf_test_source("tests/farm/fake/quiltmerge"), lf_test_source("tests/farm/scene.json"));
    says(folder, words, 0, "");
    *state = folder;
    return 0;
}

#define in_folder(test) cmocka_unit_test_setup_teardown(test, set_up, lf_test_folder_teardown)
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
