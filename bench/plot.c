/* Plots by gnuplot, from files that stay: PREFIX.gp draws again by `gnuplot PREFIX.gp` in its
 * folder. */
#include <errno.h>
#include <limits.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "bench/bench.h"

/* Name as a string of gnuplot: quotes doubled. */
static void put_quoted(FILE *out, const char *name, const char *ending)
{
    fputc('\'', out);
    for (; *name; name++)
        fprintf(out, *name == '\'' ? "''" : "%c", *name);
    fprintf(out, "%s'", ending);
}

/* The commands twice, once for each kind of picture. Caller frees; NULL = out of memory. */
static char *script_of(const char *name, const char *commands)
{
    static const char *const pictures[][2] = {
        {"svg size 800,560 dynamic background 'white' font 'sans,13'", ".svg"},
        {"pngcairo size 1200,840 font 'sans,18'", ".png"},
    };
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs("data = ", out);
    put_quoted(out, name, ".dat");
    fputs("\nset grid\n", out);
    for (size_t i = 0; i < sizeof pictures / sizeof pictures[0]; i++) {
        fprintf(out, "set terminal %s\nset output ", pictures[i][0]);
        put_quoted(out, name, pictures[i][1]);
        fprintf(out, "\n%s\nunset output\n", commands);
    }
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

static lf_status write_beside(const char *prefix, const char *ending, const char *text,
                              lf_error *err)
{
    char *path = NULL;
    if (asprintf(&path, "%s%s", prefix, ending) < 0)
        return lf_error_set(err, LF_E_NOMEM, prefix, "out of memory");
    lf_status status = lf_bench_write_text(path, text, err);
    free(path);
    return status;
}

/* Runs gnuplot on NAME.gp in folder. */
static lf_status draw(const char *folder, const char *name, lf_error *err)
{
    char *script = NULL;
    posix_spawn_file_actions_t actions;
    pid_t pid = 0;
    int result = 0;
    if (asprintf(&script, "%s.gp", name) < 0)
        return lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    char program[] = "gnuplot";
    char *argv[] = {program, script, NULL};
    posix_spawn_file_actions_init(&actions);
    int code = posix_spawn_file_actions_addchdir_np(&actions, folder);
    if (code == 0)
        code = posix_spawnp(&pid, program, &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    free(script);
    if (code == ENOENT)
        return LF_OK;
    if (code != 0)
        return lf_error_set(err, LF_E_IO, "gnuplot", "cannot be started: %s", strerror(code));
    while (waitpid(pid, &result, 0) < 0 && errno == EINTR)
        continue;
    return WIFEXITED(result) && WEXITSTATUS(result) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_IO, name, "gnuplot failed to draw the plot");
}

static bool has_gnuplot(void)
{
    char program[PATH_MAX];
    for (const char *at = getenv("PATH"); at && *at != '\0';) {
        const size_t n = strcspn(at, ":");
        snprintf(program, sizeof program, "%.*s/gnuplot", (int)n, at);
        if (access(program, X_OK) == 0)
            return true;
        at += at[n] == ':' ? n + 1 : n;
    }
    return false;
}

void lf_bench_plot_begin(const char *prefix)
{
    if (prefix && !has_gnuplot())
        lf_log(LF_LOG_WARNING,
               "--plot: gnuplot is not in PATH, so only %s.gp and %s.dat are written; install it "
               "(Debian: gnuplot-nox)",
               prefix, prefix);
}

lf_status lf_bench_plot(const char *prefix, const char *data, const char *commands, lf_error *err)
{
    const char *slash = strrchr(prefix, '/');
    const char *name = slash ? slash + 1 : prefix;
    char *folder = lf_path_folder(prefix);
    char *script = script_of(name, commands);
    lf_status status = folder ? LF_OK : lf_error_set(err, LF_E_NOMEM, prefix, "out of memory");
    if (status == LF_OK)
        status = write_beside(prefix, ".dat", data, err);
    if (status == LF_OK)
        status = write_beside(prefix, ".gp", script, err);
    if (status == LF_OK)
        status = draw(folder, name, err);
    lf_free(folder);
    free(script);
    return status;
}
