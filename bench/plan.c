/* quiltbench plan JOBS: what plans of quiltrender say against what their jobs take. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/spawn.h"
#include "bench/bench.h"
#include "bench/command.h"

#define MOST_JOBS_BYTES ((size_t)1 << 20)
/* Small, because the peak of a child begins with the memory of this process. */
#define MOST_OUTPUT ((size_t)1 << 20)

typedef struct arguments {
    const char *json;
    int repeat;
} arguments;

/* CPU seconds with ended children, and peak of resident memory in bytes. */
typedef struct usage {
    double cpu_seconds, memory;
} usage;

/* A job: plans and runs in turns. */
typedef struct job {
    const char *line;
    lf_timing planned, took, plan_took; /* CPU seconds */
    double planned_memory, memory;      /* the largest */
} job;

static const lf_param own[] = {
    LF_BENCH_REPEAT(offsetof(arguments, repeat), 1, "plans and runs of each job, in turns"),
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench plan JOBS [options]\n"
           "Compare the CPU time and the memory in plans of quiltrender with what the jobs "
           "take.\n"
           "JOBS is a text file with the words of one job a line, parted by blanks: SCENE -o OUT "
           "options. The jobs write their files.\n\n");
    lf_param_print_help(own, NULL);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {"plan", "", own, print_help, 1, 1, "one JOBS"};

/* -------------------------------------------------------------------------------------- runs -- */

/* Runs quiltrender with the words of a line and some more; out_fd receives what it prints. */
static lf_status run(const char *line, const char *const more[], int out_fd, usage *out,
                     lf_error *err)
{
    char program[PATH_MAX], *copy = lf_strdup(line);
    const char *words[256] = {program};
    int n = 1, status = 0;
    lf_status found = copy ? lf_find_program("quiltrender", NULL, program, err) : LF_E_NOMEM;
    char *state = NULL;
    for (char *word = copy ? strtok_r(copy, " \t", &state) : NULL; word && n < 240;
         word = strtok_r(NULL, " \t", &state))
        words[n++] = word;
    for (; *more; more++)
        words[n++] = *more;
    words[n] = NULL;
    pid_t pid = -1;
    const int fds[] = {-1, out_fd, STDERR_FILENO};
    const int failure = found == LF_OK ? lf_spawn(program, fds, 3, words, environ, &pid) : 0;
    struct rusage use = {0};
    if (found == LF_OK && failure == 0)
        while (wait4(pid, &status, 0, &use) < 0 && errno == EINTR)
            ;
    lf_free(copy);
    if (found != LF_OK)
        return found;
    if (failure != 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return lf_error_set(err, LF_E_IO, line, "quiltrender failed");
    out->cpu_seconds = (double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
                       1e-6 * (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
    out->memory = 1024.0 * (double)use.ru_maxrss;
    return LF_OK;
}

static lf_status read_plan(int fd, const char *line, json_t **out, lf_error *err)
{
    char *text = lf_calloc(MOST_OUTPUT, 1);
    const ssize_t n = text ? pread(fd, text, MOST_OUTPUT - 1, 0) : -1;
    *out = n > 0 ? json_loadb(text, (size_t)n, 0, NULL) : NULL;
    lf_free(text);
    return *out ? LF_OK : lf_error_set(err, LF_E_FORMAT, line, "quiltrender printed no plan");
}

/* A plan of the job as one task, and the job. */
static lf_status measure(job *j, lf_error *err)
{
    static const char *const plan[] = {"--plan", "--json", "--task-minutes", "1000000", NULL},
                             *const nothing[] = {NULL};
    usage of_plan, of_job;
    json_t *object = NULL;
    const int fd = memfd_create("plan", MFD_CLOEXEC);
    if (fd < 0)
        return lf_error_set(err, LF_E_IO, j->line, "cannot make a file in memory");
    lf_status status = run(j->line, plan, fd, &of_plan, err);
    if (status == LF_OK)
        status = read_plan(fd, j->line, &object, err);
    close(fd);
    if (status == LF_OK)
        status = run(j->line, nothing, -1, &of_job, err);
    if (status == LF_OK) {
        lf_timing_add(&j->plan_took, of_plan.cpu_seconds);
        lf_timing_add(&j->took, of_job.cpu_seconds);
        lf_timing_add(&j->planned, json_number_value(json_object_get(object, "cpu_seconds")));
        const double planned = json_number_value(json_object_get(object, "memory"));
        j->planned_memory = planned > j->planned_memory ? planned : j->planned_memory;
        j->memory = of_job.memory > j->memory ? of_job.memory : j->memory;
    }
    json_decref(object);
    return status;
}

/* ------------------------------------------------------------------------------------ report -- */

static double median(const lf_timing *timing)
{
    return lf_timing_quantile(timing, 0.5);
}

static void print_job(const job *j)
{
    printf("%9.2f %9.2f %6.2f %9.2f %9.1f %9.1f %6.2f  %s\n", median(&j->planned), median(&j->took),
           median(&j->planned) / median(&j->took), median(&j->plan_took), 1e-6 * j->planned_memory,
           1e-6 * j->memory, j->planned_memory / j->memory, j->line);
    fflush(stdout);
}

static json_t *job_json(const job *j)
{
    return json_pack("{s:s, s:f, s:f, s:f, s:f, s:f}", "job", j->line, "planned_cpu_seconds",
                     median(&j->planned), "cpu_seconds", median(&j->took), "plan_cpu_seconds",
                     median(&j->plan_took), "planned_memory", j->planned_memory, "memory",
                     j->memory);
}

static lf_status measure_all(const arguments *a, char *text, json_t *rows, lf_error *err)
{
    char *state = NULL;
    lf_status status = LF_OK;
    if (!lf_bench_is_stdout(a->json))
        printf("  CPU seconds: planned, taken, ratio; of the plan; MB: planned, taken, ratio; "
               "job\n");
    for (char *line = strtok_r(text, "\n", &state); line && status == LF_OK;
         line = strtok_r(NULL, "\n", &state)) {
        job j = {.line = line};
        if (line[strspn(line, " \t")] == '\0' || line[0] == '#')
            continue;
        for (int i = 0; i < a->repeat && status == LF_OK; i++)
            status = measure(&j, err);
        if (status != LF_OK)
            break;
        if (!lf_bench_is_stdout(a->json))
            print_job(&j);
        json_array_append_new(rows, job_json(&j));
    }
    return status;
}

int lf_bench_plan(int argc, char **argv)
{
    arguments a;
    lf_options shared;
    lf_error err = {0};
    char *text = NULL;
    size_t n = 0;
    int code;
    if (!lf_bench_command_begin(&command, argc, argv, &shared, &a, &code))
        return code;
    json_t *rows = json_array();
    lf_status status = rows ? lf_file_read(argv[optind], NULL, MOST_JOBS_BYTES, &text, &n, &err)
                            : lf_error_set(&err, LF_E_NOMEM, argv[optind], "out of memory");
    if (status == LF_OK)
        status = measure_all(&a, text, rows, &err);
    if (status == LF_OK && a.json)
        status = lf_bench_write_json(
            a.json, json_pack("{s:o, s:O}", "machine", lf_bench_machine(), "jobs", rows), &err);
    json_decref(rows);
    lf_free(text);
    if (status == LF_OK)
        return LF_EXIT_OK;
    fprintf(stderr, "%s: %s: %s\n", LF_BENCH_PROGRAM, err.where, err.what);
    return LF_EXIT_FAILED;
}
