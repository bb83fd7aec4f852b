/* quiltbench --out DIR: the published benchmarks, one after the other, each as a table and as JSON
 * and plots in DIR. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/file.h"
#include "bench/bench.h"
#include "daemon/output/options.h"

/* One after the other; NAME.json and so on end up in DIR. */
static const struct step {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *
        arguments; /* the command first; "{scenes}" is the folder of the scenes, "{out}" DIR/NAME */
} steps[] = {
    {"micro", lf_bench_micro, "micro {scenes}/cloud.json --json {out}.json"},
    {"quilt", lf_bench_quilt, "quilt --json {out}.json"},
    {"usb", lf_bench_usb, "usb {scenes}/first-light.json --json {out}.json"},
    {"skip", lf_bench_skip, "skip --json {out}.json"},
    {"live", lf_bench_live, "live {scenes}/first-light.json --json {out}.json"},
    {"compare", lf_bench_compare,
     "compare {scenes}/cloud.json --view-size 105x140 --time 20 --seeds 8 --reference-spp 64 "
     "--json {out}.json"},
    {"curve", lf_bench_curve,
     "curve {scenes}/cloud.json --view-size 60x80 --contenders "
     "vpt:mwis,mvpt:mwis,amvpt:mwis,mvpt:mis,mvpt:cv --seeds 8 --json "
     "{out}.json "
     "--plot {out}"},
    {"views", lf_bench_views, "views {scenes}/cloud.json --seeds 8 --json {out}.json --plot {out}"},
    {"table", lf_bench_table, "table {scenes} --json {out}.json --markdown {out}.md"},
};

enum { N_STEPS = sizeof steps / sizeof steps[0], MAX_WORDS = 32 };

enum { OPTION_OUT = LF_OPTION_OWN, OPTION_SCENES };

static const struct option table[] = {
    {"out", required_argument, NULL, OPTION_OUT},
    {"scenes", required_argument, NULL, OPTION_SCENES},
    {NULL, 0, NULL, 0},
};

typedef struct folders {
    const char *out, *scenes;
} folders;

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    folders *f = context;
    (void)err;
    *(code == OPTION_OUT ? &f->out : &f->scenes) = text;
    return LF_OK;
}

static lf_status parse(int argc, char **argv, folders *out, bool *out_done, lf_error *err)
{
    const lf_options_rules rules = {
        .program = LF_BENCH_PROGRAM, .letters = ":", .table = table, .take = take, .context = out};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (optind < argc)
        return lf_error_set(err, LF_E_ARG, argv[optind],
                            "unexpected argument; --out takes only --scenes (see --help)");
    return out->out ? LF_OK : lf_error_set(err, LF_E_ARG, "--out", "is missing; see --help");
}

/* The word with the folders filled in; caller frees. NULL = out of memory. */
static char *fill(const char *word, int n, const char *scenes, const char *folder, const char *name)
{
    char *filled = NULL;
    int length = -1;
    if (strncmp(word, "{scenes}", 8) == 0)
        length = asprintf(&filled, "%s%.*s", scenes, n - 8, word + 8);
    else if (strncmp(word, "{out}", 5) == 0)
        length = asprintf(&filled, "%s/%s%.*s", folder, name, n - 5, word + 5);
    else
        length = asprintf(&filled, "%.*s", n, word);
    return length < 0 ? NULL : filled;
}

static int run(const struct step *step, const char *scenes, const char *folder)
{
    char *argv[MAX_WORDS + 1] = {0};
    int argc = 0;
    int code = LF_EXIT_FAILED;
    bool whole = true;
    for (const char *at = step->arguments; *at && argc < MAX_WORDS; at += strspn(at, " ")) {
        int n = (int)strcspn(at, " ");
        argv[argc] = fill(at, n, scenes, folder, step->name);
        whole = whole && argv[argc++];
        at += n;
    }
    if (whole) {
        printf("== %s\n", step->name);
        optind = 0; /* GNU: another command line */
        code = step->run(argc, argv);
        putchar('\n');
        fflush(stdout);
    } else {
        lf_error err = {0};
        lf_error_set(&err, LF_E_NOMEM, step->name, "out of memory");
        lf_bench_fail(&err);
    }
    for (int i = 0; i < argc; i++)
        free(argv[i]);
    return code;
}

int lf_bench_all(int argc, char **argv)
{
    folders into = {0};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    bool done = false;
    if (parse(argc, argv, &into, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    if (mkdir(into.out, 0777) != 0 && errno != EEXIST) {
        lf_error_set(&err, LF_E_IO, into.out, "cannot make the folder: %s", strerror(errno));
        return lf_bench_fail(&err);
    }
    /* make puts the scenes with their data beside the results */
    char *beside = lf_path_join(into.out, "../scenes");
    if (!beside) {
        lf_error_set(&err, LF_E_NOMEM, into.out, "out of memory");
        return lf_bench_fail(&err);
    }
    for (int i = 0; i < N_STEPS; i++) {
        int failed = run(&steps[i], into.scenes ? into.scenes : beside, into.out);
        code = failed ? failed : code; /* the others may still be of use */
    }
    lf_free(beside);
    return code;
}
