/* quiltmerge: puts the states of parts of a light field together. See docs/man/quiltmerge.1. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/output/options.h"
#include "daemon/tools/job_merge.h"
#include "daemon/tools/progress_line.h"

#define PROGRAM "quiltmerge"
#define MOST_LIST (UINT64_C(64) << 20)
#define MOST_PARTS 1000000
#define MOST_WAIT 86400

enum { OPTION_FILES_FROM = LF_OPTION_OWN, OPTION_PARTIAL, OPTION_WAIT };

static const struct option table[] = {
    {"files-from", required_argument, NULL, OPTION_FILES_FROM},
    {"partial", no_argument, NULL, OPTION_PARTIAL},
    {"wait", required_argument, NULL, OPTION_WAIT},
    {NULL, 0, NULL, 0},
};

typedef struct arguments {
    lf_job_merge merge;
    const char *list;
    char *text;         /* of the list; parts point into it */
    const char **parts; /* owned */
} arguments;

static lf_cancel cancel;

static void on_signal(int number)
{
    (void)number;
    atomic_store_explicit(&cancel, 1, memory_order_relaxed);
}

static void print_help(void)
{
    printf(
        "Usage: quiltmerge PART ... -o WHOLE.lfstate [options]\n"
        "Put the states of parts of a light field together: bands of image rows bit for bit, "
        "random\n"
        "streams as sums. quiltrender with the result as its state then writes the output at "
        "once.\n"
        "\n"
        "  -o FILE                write the merged state here; never one of the parts\n"
        "  --files-from LIST      read more names of parts from a file, one per line\n"
        "  --partial              accept missing rows and incomplete parts; quiltrender continues "
        "them\n"
        "  --wait SECONDS         wait so long for parts that are not there, 0 to %d (0)\n"
        "\n" LF_OPTIONS_HELP_LAST LF_OPTIONS_HELP_SHELLS,
        MOST_WAIT);
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    arguments *a = context;
    if (code == 'o' && text[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "-o", "is empty; expected the name of a file");
    if (code == 'o')
        a->merge.out = text;
    else if (code == OPTION_FILES_FROM)
        a->list = text;
    else if (code == OPTION_PARTIAL)
        a->merge.partial = true;
    else
        return lf_parse_double("--wait", text, 0, MOST_WAIT, &a->merge.wait, err);
    return LF_OK;
}

/* Adds the lines of the list to the parts. */
static lf_status read_list(arguments *a, int n, lf_error *err)
{
    size_t size = 0;
    lf_status status =
        a->list ? lf_file_read(a->list, NULL, MOST_LIST, &a->text, &size, err) : LF_OK;
    if (status != LF_OK)
        return status;
    size_t lines = 1;
    for (size_t i = 0; i < size; i++)
        lines += a->text[i] == '\n';
    const char **parts = lf_calloc((size_t)n + lines, sizeof *parts);
    if (!parts)
        return lf_error_set(err, LF_E_NOMEM, a->merge.out, "out of memory");
    for (int i = 0; i < n; i++)
        parts[i] = a->parts[i];
    char *place = NULL;
    for (char *line = a->text ? strtok_r(a->text, "\n", &place) : NULL; line && n < MOST_PARTS;
         line = strtok_r(NULL, "\n", &place))
        parts[n++] = line;
    lf_free(a->parts);
    a->parts = parts;
    a->merge.parts = parts;
    a->merge.n_parts = n;
    return LF_OK;
}

static lf_status read_arguments(int argc, char *const argv[], arguments *a, bool *out_done,
                                lf_error *err)
{
    const lf_options_rules rules = {.program = PROGRAM,
                                    .letters = ":o:",
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .context = a};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (!a->merge.out)
        return lf_error_set(err, LF_E_ARG, "-o", "is missing: the name of the merged state");
    const int n = argc - optind;
    a->parts = lf_calloc((size_t)n, sizeof *a->parts);
    if (!a->parts)
        return lf_error_set(err, LF_E_NOMEM, a->merge.out, "out of memory");
    for (int i = 0; i < n; i++)
        a->parts[i] = argv[optind + i];
    status = read_list(a, n, err);
    return status == LF_OK && a->merge.n_parts == 0
               ? lf_error_set(err, LF_E_ARG, "PART", "is missing: name the states to merge")
               : status;
}

static void show(void *context, double done)
{
    char text[64];
    snprintf(text, sizeof text, "merging: %.0f %%", 100.0 * done);
    lf_progress_line_draw(context, text);
}

static void tell(const lf_job_merge *merge, const lf_job_merged *m)
{
    char streams[64] = "";
    if (m->n_streams > 1)
        snprintf(streams, sizeof streams, ", %d random streams", m->n_streams);
    lf_log(LF_LOG_INFO, "wrote %s (%d parts, %d of %d rows, %.4g spp%s, %s)", merge->out,
           m->n_parts, m->n_rows, m->height, m->spp, streams,
           m->complete ? "complete" : "not complete");
}

static int run(arguments *a)
{
    const bool is_terminal = isatty(STDERR_FILENO) == 1;
    const struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND},
                           ignore = {.sa_handler = SIG_IGN};
    lf_progress_line line = {.on = is_terminal,
                             .logs = !is_terminal,
                             .program = PROGRAM,
                             .interval = LF_PROGRESS_INTERVAL};
    lf_job_merged merged;
    lf_error err = {0};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGXFSZ, &ignore, NULL); /* a file too large is an error like a full disk */
    a->merge.progress = show;
    a->merge.context = &line;
    a->merge.cancel = &cancel;
    const lf_status status = lf_job_merge_run(&a->merge, &merged, &err);
    lf_progress_line_clear(&line);
    if (status == LF_OK)
        tell(&a->merge, &merged);
    else
        lf_log_error(&err);
    return status == LF_OK ? LF_EXIT_OK : LF_EXIT_FAILED;
}

int main(int argc, char *argv[])
{
    arguments a = {0};
    lf_error err = {0};
    bool done = false;
    int code = LF_EXIT_OK;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    const lf_status status = read_arguments(argc, argv, &a, &done, &err);
    if (status == LF_E_ARG) {
        code = lf_usage_error(PROGRAM, &err);
    } else if (status != LF_OK) {
        lf_log_error(&err);
        code = LF_EXIT_FAILED;
    } else if (!done) {
        code = run(&a);
    }
    lf_free(a.parts);
    lf_free(a.text);
    return code;
}
