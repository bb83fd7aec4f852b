/* quiltbench: measurements. See docs/man/quiltbench.1. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/utsname.h>

#include "base/file.h"
#include "base/log.h"
#include "base/thread.h"
#include "bench/bench.h"
#include "daemon/output/completion.h"
#include "render/papers/papers.h"

static const struct command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *what;
} commands[] = {
    {"error", lf_bench_error, "difference between an image and a reference"},
    {"compare", lf_bench_compare, "error of two integrators at equal CPU time"},
    {"curve", lf_bench_curve, "error against CPU time, with its parts"},
    {"table", lf_bench_table, "equal-time error ratios on many kinds of scenes"},
    {"papers", lf_bench_papers, "the estimators of the papers compared with ours"},
    {"shown", lf_bench_shown, "the denoised image against the unfiltered image"},
    {"views", lf_bench_views, "error against the number of views"},
    {"micro", lf_bench_micro, "the inner loops, each instruction set against plain C"},
    {"live", lf_bench_live, "what the panel shows after a command, and when"},
    {"skip", lf_bench_skip, "CPU time that skipping unneeded work saves"},
    {"quilt", lf_bench_quilt, "interlacing, tone mapping, filling and print against copying"},
    {"video", lf_bench_video, "a frame of a quilt video: decoding and interlacing"},
    {"plan", lf_bench_plan, "time and memory in plans of quiltrender against its jobs"},
    {"usb", lf_bench_usb, "updates of a simulated USB display against copying"},
};

static void print_help(void)
{
    printf("Usage: quiltbench COMMAND [arguments]   (for details: quiltbench COMMAND --help)\n"
           "       quiltbench --out DIR [--scenes DIR]   run the published benchmarks and write "
           "JSON files to DIR; the\n"
           "                                        shipped scenes and their data are in --scenes "
           "(DIR/../scenes)\n\n");
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
        printf("  %-10s %s\n", commands[i].name, commands[i].what);
    printf("\n"
           "  --completion bash|zsh|fish   print a completion script for the shell\n"
           "  --help                       print this help\n"
           "  --version                    print the version\n");
}

enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

static int complete(const char *shell)
{
    lf_completion_command all[N_COMMANDS + 1] = {{NULL, lf_bench_all}};
    lf_error err = {0};
    for (int i = 0; i < N_COMMANDS; i++)
        all[i + 1] = (lf_completion_command){commands[i].name, commands[i].run};
    lf_status status =
        lf_completion_write_commands(LF_BENCH_PROGRAM, all, N_COMMANDS + 1, shell, stdout, &err);
    return status == LF_OK ? LF_EXIT_OK : lf_usage_error(LF_BENCH_PROGRAM, &err);
}

static int usage(const char *where, const char *what)
{
    lf_error err = {0};
    lf_error_set(&err, LF_E_ARG, where, "%s", what);
    return lf_usage_error(LF_BENCH_PROGRAM, &err);
}

lf_status lf_bench_parse_share(const char *option, const char *text, double *out, lf_error *err)
{
    char number[64];
    double value = 0;
    size_t n = strlen(text);
    bool percent = n > 0 && text[n - 1] == '%';
    snprintf(number, sizeof number, "%.*s", (int)(percent ? n - 1 : n), text);
    lf_status status = lf_parse_double(option, number, 0, 1e9, &value, err);
    if (status == LF_OK)
        *out = percent ? value / 100 : value;
    return status;
}

static void cpu_model(char *out, size_t size)
{
    char line[512];
    FILE *file = fopen("/proc/cpuinfo", "re");
    snprintf(out, size, "unknown");
    while (file && fgets(line, sizeof line, file)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon) {
            snprintf(out, size, "%s", colon + 2);
            out[strcspn(out, "\n")] = '\0';
            break;
        }
    }
    if (file)
        fclose(file);
}

json_t *lf_bench_machine(void)
{
    char model[256];
    struct utsname name;
    cpu_model(model, sizeof model);
    if (uname(&name) != 0)
        snprintf(name.release, sizeof name.release, "unknown");
    return json_pack("{s:s, s:i, s:s}", "cpu", model, "cpus", lf_cpu_count(), "kernel",
                     name.release);
}

json_t *lf_bench_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

bool lf_bench_is_stdout(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

lf_status lf_bench_write_text(const char *path, const char *text, lf_error *err)
{
    return text ? lf_outfile_text(path, text, err)
                : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

lf_status lf_bench_write_json(const char *path, json_t *object, lf_error *err)
{
    char *text = object ? json_dumps(object, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    char *line = NULL;
    lf_status status = LF_OK;
    if (text && asprintf(&line, "%s\n", text) < 0)
        line = NULL;
    if (line && lf_bench_is_stdout(path))
        fputs(line, stdout);
    else
        status = lf_bench_write_text(path, line, err);
    json_decref(object);
    free(text);
    free(line);
    return status;
}

lf_status lf_bench_pool(int threads, lf_pool **out_pool, lf_error *err)
{
    lf_status status = lf_pool_create(threads, out_pool);
    return status == LF_OK
               ? LF_OK
               : lf_error_set(err, status, "--threads", "cannot start the worker threads");
}

/* Scenes of bench/textured and bench/reference need data that a clone does not have. */
static bool lacks_data(const lf_error *err)
{
    return err->status == LF_E_IO && strstr(err->what, "/shared/data/");
}

int lf_bench_fail(const lf_error *err)
{
    lf_log_error(err);
    if (lacks_data(err))
        lf_log(LF_LOG_ERROR, "quiltd does not ship this file; see \"Shipped scenes\" in "
                             "docs/reference/scene-format.md for its source");
    return LF_EXIT_FAILED;
}

int main(int argc, char **argv)
{
    lf_log_init(LF_BENCH_PROGRAM, LF_LOG_INFO);
    lf_papers_add();
    if (argc < 2)
        return usage("COMMAND", "is missing; see --help");
    if (strcmp(argv[1], "--help") == 0) {
        print_help();
        return LF_EXIT_OK;
    }
    if (strcmp(argv[1], "--version") == 0) {
        lf_print_version(LF_BENCH_PROGRAM);
        return LF_EXIT_OK;
    }
    if (argc == 3 && strcmp(argv[1], "--completion") == 0)
        return complete(argv[2]);
    if (strncmp(argv[1], "--", 2) == 0)
        return lf_bench_all(argc, argv);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
        if (strcmp(argv[1], commands[i].name) == 0)
            return commands[i].run(argc - 1, argv + 1);
    return usage(argv[1], "unknown command; see --help");
}
