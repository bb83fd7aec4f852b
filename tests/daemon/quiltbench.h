/* quiltbench run by tests in a folder of theirs, and what it writes there. */
#ifndef LF_TESTS_DAEMON_QUILTBENCH_H
#define LF_TESTS_DAEMON_QUILTBENCH_H

#include "tests/testing.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "tests/scene_file.h"

#include <jansson.h>

/* Runs quiltbench with words parted by blanks; its stdout and stderr end up in the files "out" and
 * "err" of the folder. Returns the exit code. */
static inline int bench_run(const char *folder, const char *line)
{
    static char copy[4 * PATH_MAX];
    char program[PATH_MAX];
    char out[PATH_MAX], err[PATH_MAX];
    char *argv[48] = {program};
    int argc = 1;
    int status = 0;
    snprintf(program, sizeof program, "%s", lf_test_built("quiltbench"));
    snprintf(out, sizeof out, "%s/out", folder);
    snprintf(err, sizeof err, "%s/err", folder);
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word && argc < 47; word = strtok(NULL, " "))
        argv[argc++] = word;
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        dup2(open(out, O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
        dup2(open(err, O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
        if (chdir(folder) == 0)
            execv(program, argv);
        _exit(127);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static inline double bench_number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value))
        fail_msg("no number \"%s\"", key);
    return json_number_value(value);
}

static inline json_t *bench_load(const char *folder, const char *name)
{
    json_t *object = json_load_file(lf_test_path(folder, name), 0, NULL);
    assert_true(json_is_object(object));
    return object;
}

static inline void bench_write_ball(const char *folder)
{
    lf_test_write(folder, "fog.json", lf_test_scene_text("fog-ball"));
}

#endif
