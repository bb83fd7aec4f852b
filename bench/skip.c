/* quiltbench skip: what leaving out saves. Every entry of the table of skips on scenes that do not
 * need what it leaves out: CPU time with and without it, taken in turns, and whether the pictures
 * agree. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "bench/bench.h"
#include "bench/command.h"

typedef struct arguments {
    lf_options options; /* views, view size, threads, seed */
    const char *json;
    int repeat;
    int passes;
} arguments;

/* Little of the picture is covered, light comes from one colour of sky and a sun: what is left out
 * is there to be left out. */
#define CAMERA                                                                                     \
    "\"camera\": {\"position\": [0, 0.5, 7], \"fov_y\": 22, \"aspect\": 0.75, \"cone\": 35, "      \
    "\"views\": 45}, "                                                                             \
    "\"lights\": {\"sky\": {\"type\": \"environment\", \"radiance\": 0.5}, "                       \
    "\"sun\": {\"type\": \"distant\", \"direction\": [0.5, -0.7, -0.5], \"irradiance\": 3}}"
static const struct scene {
    const char *name, *text;
} scenes[] = {
    {"cloud", "{\"quiltd\": 1, " CAMERA
              ", \"volumes\": {\"puff\": {\"shape\": \"sphere\", \"density\": 6, \"albedo\": 0.9, "
              "\"transform\": {\"scale\": 0.6}}}}"},
    {"meshes",
     "{\"quiltd\": 1, " CAMERA
     ", \"meshes\": {\"ball\": {\"shape\": \"sphere\", \"material\": \"clay\", "
     "\"transform\": {\"scale\": 0.6}}, \"block\": {\"shape\": \"cube\", \"material\": \"clay\", "
     "\"transform\": {\"scale\": 0.3, \"rotate\": [0, 30, 0], \"translate\": [0.7, -0.4, 0.4]}}}, "
     "\"materials\": {\"clay\": {\"albedo\": 0.6}}, \"render\": {\"max_depth\": 6}}"},
};
enum { N_SCENES = sizeof scenes / sizeof scenes[0] };

typedef struct bench {
    const arguments *arguments;
    lf_pool *pool;
    lf_scene *scene;
    lf_render_settings settings;
    size_t values;
    float *with, *without; /* pictures of the last runs */
    json_t *lines;
} bench;

static const char shared[] = "views view-size threads seed";

static const lf_param own[] = {
    LF_BENCH_FIELD(LF_PARAM_WHOLE, "passes", offsetof(arguments, passes), "N", 1, 1000000, 90,
                   "passes per run"),
    LF_BENCH_REPEAT(offsetof(arguments, repeat), 5,
                    "runs per case; the median of their ratios is reported"),
    LF_BENCH_JSON(offsetof(arguments, json)),
    {0},
};

static void print_help(void)
{
    printf("Usage: quiltbench skip [options]\n"
           "Measure the CPU time with and without each optimisation of quiltrender --skip, in "
           "alternating runs, on a small cloud\n"
           "and on small meshes under a sky of one colour, and check that the images agree. "
           "Default: 45 views of 60x80 pixels.\n\n");
    lf_param_print_help(own, NULL);
    lf_param_print_help(lf_option_params, shared);
    printf(LF_OPTIONS_HELP_LAST);
}

static const lf_bench_command command = {"skip", shared, own, print_help, 0, 0, "options only"};

/* One picture from the start; CPU seconds of it. */
static lf_status run(bench *b, unsigned skip, float *picture, double *out_seconds, lf_error *err)
{
    lf_renderer *renderer = NULL;
    double start = lf_time_cpu();
    b->settings.skip = skip;
    lf_status status = lf_renderer_create(b->scene, &b->settings, b->pool, &renderer, err);
    if (status == LF_OK &&
        (lf_renderer_passes(renderer, NULL, b->arguments->passes, false, NULL, NULL, NULL) !=
             LF_OK ||
         lf_renderer_resolve(renderer, LF_ESTIMATOR_MWIS, picture, NULL) != LF_OK))
        status = lf_error_set(err, LF_E_STATE, "skip", "rendering failed");
    *out_seconds = lf_time_cpu() - start;
    lf_renderer_destroy(renderer);
    return status;
}

/* Largest difference of a value, relative to it plus a hundredth. */
static double difference(const bench *b)
{
    double largest = 0;
    for (size_t i = 0; i < b->values; i++) {
        double x = (double)b->with[i];
        largest = fmax(largest, fabs((double)b->without[i] - x) / (fabs(x) + 0.01));
    }
    return largest;
}

static lf_status measure(bench *b, const struct scene *scene, const char *name, unsigned bit,
                         lf_error *err)
{
    lf_timing with = {0};
    lf_timing ratio = {0};
    for (int i = 0; i < b->arguments->repeat; i++) {
        double seconds[2];
        lf_status status = run(b, LF_SKIP_ALL, b->with, &seconds[0], err);
        if (status == LF_OK)
            status = run(b, LF_SKIP_ALL & ~bit, b->without, &seconds[1], err);
        if (status != LF_OK)
            return status;
        lf_timing_add(&with, seconds[0]);
        lf_timing_add(&ratio, seconds[1] / seconds[0]);
    }
    bool same = memcmp(b->with, b->without, b->values * sizeof *b->with) == 0;
    double median = lf_timing_quantile(&ratio, 0.5);
    char agree[32] = "same bits";
    if (!same)
        snprintf(agree, sizeof agree, "within %.1e", difference(b));
    printf("%-12s %-8s %9.3f %8.3f   (%.3f .. %.3f)   %s\n", name, scene->name,
           lf_timing_quantile(&with, 0.5), median, lf_timing_quantile(&ratio, 0),
           lf_timing_quantile(&ratio, 1), agree);
    json_array_append_new(b->lines, json_pack("{s:s, s:s, s:f, s:f, s:f, s:f, s:b, s:f}", "skip",
                                              name, "scene", scene->name, "cpu_seconds",
                                              lf_timing_quantile(&with, 0.5), "without_over_with",
                                              median, "low", lf_timing_quantile(&ratio, 0), "high",
                                              lf_timing_quantile(&ratio, 1), "same_bits", same,
                                              "difference", same ? 0.0 : difference(b)));
    return LF_OK;
}

static lf_status open_scene(bench *b, const struct scene *scene, lf_error *err)
{
    lf_layout layout;
    json_t *doc = json_loads(scene->text, 0, NULL);
    lf_status status = doc ? lf_scene_from_json(doc, "/", scene->name, NULL, NULL, &b->scene, err)
                           : lf_error_set(err, LF_E_NOMEM, scene->name, "out of memory");
    json_decref(doc);
    if (status == LF_OK)
        status = lf_resolve_view(&b->arguments->options, lf_scene_camera(b->scene), NULL,
                                 &b->settings, &layout, err);
    if (status != LF_OK)
        return status;
    b->values = (size_t)b->settings.camera.n_views * (size_t)b->settings.width *
                (size_t)b->settings.height * 3;
    b->with = lf_calloc(b->values, sizeof *b->with);
    b->without = lf_calloc(b->values, sizeof *b->without);
    return b->with && b->without
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, scene->name, "out of memory for the images");
}

static void close_scene(bench *b)
{
    lf_free(b->with);
    lf_free(b->without);
    lf_scene_unref(b->scene);
    b->with = b->without = NULL;
    b->scene = NULL;
}

/* The names of what this scene does not need. */
static json_t *found(bench *b, lf_error *err)
{
    lf_renderer *renderer = NULL;
    b->settings.skip = LF_SKIP_ALL;
    if (lf_renderer_create(b->scene, &b->settings, b->pool, &renderer, err) != LF_OK)
        return NULL;
    json_t *skipped = lf_renderer_skipped(renderer);
    lf_renderer_destroy(renderer);
    return skipped;
}

static lf_status measure_scene(bench *b, const struct scene *scene, lf_error *err)
{
    unsigned all = 0;
    lf_status status = open_scene(b, scene, err);
    json_t *skipped = status == LF_OK ? found(b, err) : NULL;
    for (int i = 0; skipped && status == LF_OK && lf_skip_at(i); i++) {
        all |= lf_skip_at(i)->bit;
        if (json_object_get(skipped, lf_skip_at(i)->name))
            status = measure(b, scene, lf_skip_at(i)->name, lf_skip_at(i)->bit, err);
    }
    if (skipped && status == LF_OK)
        status = measure(b, scene, "all", all, err);
    if (status == LF_OK && !skipped)
        status = err->status;
    json_decref(skipped);
    close_scene(b);
    return status;
}

static lf_status report(const bench *b, lf_error *err)
{
    const arguments *a = b->arguments;
    if (!a->json)
        return LF_OK;
    json_t *object =
        json_pack("{s:o, s:I, s:i, s:i, s:i, s:i, s:i, s:O}", "machine", lf_bench_machine(),
                  "passes", (json_int_t)a->passes, "repeat", a->repeat, "views",
                  b->settings.camera.n_views, "width", b->settings.width, "height",
                  b->settings.height, "threads", lf_pool_threads(b->pool), "skips", b->lines);
    return lf_bench_write_json(a->json, object, err);
}

int lf_bench_skip(int argc, char **argv)
{
    arguments a = {.options = {.view_width = 60, .view_height = 80}};
    bench b = {.arguments = &a};
    lf_error err = {0};
    int code = LF_EXIT_OK;
    if (!lf_bench_command_begin(&command, argc, argv, &a.options, &a, &code))
        return code;
    lf_status status = lf_pool_create(a.options.threads, &b.pool);
    b.lines = json_array();
    if (status != LF_OK || !b.lines)
        status = lf_error_set(&err, LF_E_NOMEM, "--threads", "cannot start the worker threads");
    printf("skip         scene        CPU s  without/with (low .. high)      images\n");
    for (int i = 0; i < N_SCENES && status == LF_OK; i++)
        status = measure_scene(&b, &scenes[i], &err);
    if (status == LF_OK)
        status = report(&b, &err);
    json_decref(b.lines);
    lf_pool_destroy(b.pool);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
