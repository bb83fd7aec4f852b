/* quiltbench --out DIR: the published benchmarks, one after the other, each as a table and as JSON in DIR. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/file.h"
#include "bench/bench.h"
#include "daemon/options.h"

enum { OPTION_OUT = LF_OPTION_OWN, OPTION_SCENES };

static const struct option table[] = {
    {"out", required_argument, NULL, OPTION_OUT},
    {"scenes", required_argument, NULL, OPTION_SCENES},
    {NULL, 0, NULL, 0},
};

static lf_status parse(int argc, char **argv, const char **out_folder, const char **out_scenes, lf_error *err)
{
    int code = 0;

    for (;;) {
        lf_status status = lf_options_next(argc, argv, ":", table, &code, err);
        if (status != LF_OK)
            return status;
        if (code == -1)
            break;
        *(code == OPTION_OUT ? out_folder : out_scenes) = optarg;
    }
    if (optind < argc)
        return lf_error_set(err, LF_E_ARG, argv[optind], "does not go with --out (see --help)");
    return *out_folder ? LF_OK : lf_error_set(err, LF_E_ARG, "--out", "missing (see --help)");
}

/* Equal CPU time on the cloud, the number that the README states. */
static int compare_cloud(char *scene, char *json)
{
    char words[][16] = {"compare", "--view-size", "105x140", "--time", "20", "--seeds", "8", "--reference-spp", "64", "--json"};
    char *argv[sizeof words / sizeof words[0] + 3];
    int argc = 0;

    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        argv[argc++] = words[i];
    argv[argc++] = json;
    argv[argc++] = scene;
    argv[argc] = NULL;
    optind = 0; /* GNU: another command line */
    return lf_bench_compare(argc, argv);
}

int lf_bench_all(int argc, char **argv)
{
    const char *folder = NULL;
    const char *scenes = NULL;
    lf_error err = {0};

    if (parse(argc, argv, &folder, &scenes, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        lf_error_set(&err, LF_E_IO, folder, "cannot make the folder: %s", strerror(errno));
        return lf_bench_fail(&err);
    }
    /* make puts the scenes with their data beside the results */
    char *beside = lf_path_join(folder, "../scenes");
    char *scene = beside ? lf_path_join(scenes ? scenes : beside, "cloud.json") : NULL;
    char *json = lf_path_join(folder, "compare.json");
    int code = LF_EXIT_FAILED;
    if (scene && json) {
        code = compare_cloud(scene, json);
    } else {
        lf_error_set(&err, LF_E_NOMEM, folder, "out of memory");
        lf_bench_fail(&err);
    }
    lf_free(beside);
    lf_free(scene);
    lf_free(json);
    return code;
}
