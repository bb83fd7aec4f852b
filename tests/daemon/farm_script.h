/* A quiltfarm of tests, first in PATH: a script that notes its calls, answers `status` from a file,
 * and does what other files ask for. */
#ifndef LF_TESTS_DAEMON_FARM_SCRIPT_H
#define LF_TESTS_DAEMON_FARM_SCRIPT_H

#include "tests/testing.h"

#include <sys/stat.h>
#include <time.h>

/* FOLDER/calls has a line for each call. A file COMMAND.says is said on stderr, and the command
 * fails; COMMAND.hangs: it does not end. `plan` writes the command of quiltrender as the only line
 * of JOB/tasks. With a file `runs`, submit runs this line, and status tells whether it is done. */
static const char farm_script[] =
    "#!/bin/sh\n"
    "echo \"$*\" >> \"$FARM/calls\"\n"
    "command=$1 job=$2\n"
    "if [ -f \"$FARM/$1.hangs\" ]; then exec sleep 10000; fi\n"
    "if [ -f \"$FARM/$1.says\" ]; then cat \"$FARM/$1.says\" >&2; exit 1; fi\n"
    "case $command in\n"
    "plan)\n"
    "    shift 5\n"
    "    { printf '%s' \"$QUILTRENDER\"; for word; do printf \" '%s'\" \"$word\"; done; echo; } "
    "> \"$job/tasks\" ;;\n"
    "submit)\n"
    "    if [ -f \"$FARM/runs\" ]; then sh \"$job/tasks\" > \"$job/log\" 2>&1 && : > "
    "\"$job/done\"; "
    "fi ;;\n"
    "status)\n"
    "    if [ -f \"$job/done\" ]; then cat \"$FARM/complete\"; else cat \"$FARM/status\"; fi ;;\n"
    "esac\n";

/* quiltfarm's words of a job of four tasks. */
static inline const char *farm_status(const char *state, int complete)
{
    char *text = lf_test_buffer();
    snprintf(text, PATH_MAX,
             "{\"job\":\"j\",\"engine\":\"slurm\",\"state\":\"%s\",\"tasks\":{\"total\":4,"
             "\"complete\":%d,\"running\":%d,\"failed\":0,\"missing\":%d},\"cpu_seconds\":{"
             "\"planned\":100,\"spent\":30},\"seconds_left\":50,\"cost\":null,\"failed\":[],"
             "\"outputs\":[]}\n",
             state, complete, complete < 4, complete < 4 ? 3 - complete : 0);
    return text;
}

/* A file that is there at once or not at all. */
static inline void farm_write(const char *folder, const char *name, const char *text)
{
    const char *made = lf_test_write(folder, "new", text);
    assert_int_equal(rename(made, lf_test_path(folder, name)), 0);
}

/* Makes the script and its folder the first in PATH. */
static inline void farm_prepare(const char *folder)
{
    char path[2 * PATH_MAX], program[PATH_MAX];
    const char *old = getenv("PATH");
    snprintf(program, sizeof program, "%s", lf_test_write(folder, "quiltfarm", farm_script));
    assert_int_equal(chmod(program, 0700), 0);
    farm_write(folder, "status", farm_status("running", 1));
    farm_write(folder, "complete", farm_status("complete", 4));
    snprintf(path, sizeof path, "%s:%s", folder, old ? old : "/usr/bin:/bin");
    setenv("PATH", path, 1);
    setenv("FARM", folder, 1);
}

/* How many calls began with these words. */
static inline int farm_calls(const char *folder, const char *words)
{
    FILE *file = fopen(lf_test_path(folder, "calls"), "r");
    char line[4096];
    int n = 0;
    while (file && fgets(line, sizeof line, file))
        n += strncmp(line, words, strlen(words)) == 0;
    if (file)
        fclose(file);
    return n;
}

#endif
