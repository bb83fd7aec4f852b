/* The program quiltfarm in a folder of a test, with a renderer of the test's own (tests/farm/fake).
 */
#ifndef LF_TESTS_DAEMON_QUILTFARM_H
#define LF_TESTS_DAEMON_QUILTFARM_H

#include "tests/testing.h"

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

#endif
