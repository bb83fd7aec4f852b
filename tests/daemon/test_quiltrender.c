/* quiltrender from outside: exit codes, error lines, files that are whole or absent, the same bytes
 * for any threads. */
#include "tests/testing.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include <jansson.h>

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/quilt.h"

static const char fog[] =
    "{ \"quiltd\": 1,\n"
    "  \"camera\": { \"target\": [0,0,0], \"position\": [0,0.5,6], \"fov_y\": 26, \"aspect\": "
    "0.75, \"views\": 6, \"cone\": 35 },\n"
    "  \"volumes\": { \"fog\": { \"shape\": \"sphere\", \"density\": 3, \"albedo\": 0.9, \"g\": "
    "0.4 } },\n"
    "  \"meshes\": { \"ground\": { \"shape\": \"quad\", \"material\": \"clay\", \"transform\": { "
    "\"scale\": 4, \"translate\": "
    "[0,-1.05,0] } } },\n"
    "  \"materials\": { \"clay\": { \"type\": \"diffuse\", \"albedo\": 0.5 } },\n"
    "  \"lights\": { \"sky\": { \"type\": \"environment\", \"radiance\": 0.5 } } }\n";

#define VIEWS 6
#define WIDTH 20
#define HEIGHT 12

typedef struct fixture {
    char *folder;
    char scene[PATH_MAX];       /* fog above */
    char quilt[PATH_MAX];       /* a small 8-bit quilt picture */
    char large[PATH_MAX];       /* one that takes a while to write */
    char calibration[PATH_MAX]; /* a small panel */
} fixture;

static void write_quilt(char *path, const char *folder, const char *name, int view_width,
                        int view_height)
{
    lf_error err = {0};
    lf_outfile file;
    size_t row = (size_t)view_width * 3;
    uint8_t *data = lf_calloc(VIEWS * (size_t)view_height, row);
    const lf_views8 views = {VIEWS, view_width, view_height, row * (size_t)view_height, row, data};
    const lf_layout layout = {3, 2, VIEWS, view_width, view_height, 1.5};
    assert_non_null(data);
    for (size_t i = 0; i < VIEWS * (size_t)view_height * row; i++)
        data[i] = (uint8_t)((i * 2654435761u) >> 13);
    snprintf(path, PATH_MAX, "%s/%s", folder, name);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_quilt_write_png(&file, &views, &layout, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_free(data);
}

static int set_up(void **state)
{
    static fixture f;
    f.folder = lf_test_folder();
    snprintf(f.scene, sizeof f.scene, "%s", lf_test_write(f.folder, "fog.json", fog));
    snprintf(f.calibration, sizeof f.calibration, "%s",
             lf_test_write(f.folder, "panel.json",
                           "{\"pitch\": {\"value\": 52.5}, \"slope\": {\"value\": -7.2}, "
                           "\"center\": {\"value\": 0.5}, "
                           "\"DPI\": {\"value\": 324}, \"screenW\": {\"value\": 90}, \"screenH\": "
                           "{\"value\": 60}, "
                           "\"viewCone\": {\"value\": 40}, \"invView\": {\"value\": 1}, "
                           "\"flipImageX\": {\"value\": 0}, "
                           "\"flipImageY\": {\"value\": 0}, \"flipSubp\": {\"value\": 0}}"));
    write_quilt(f.quilt, f.folder, "card_qs3x2a1.5.png", WIDTH, HEIGHT);
    write_quilt(f.large, f.folder, "large_qs3x2a1.5.png", 240, 160);
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    lf_test_folder_remove(f->folder);
    return 0;
}

/* -------------------------------------------------------------------------- running programs -- */

typedef struct outcome {
    int code; /* exit code, or 1000 + the signal's number */
    char out[8192], err[8192];
} outcome;

/* Starts quiltrender with its words in `line` (parted by single blanks); stderr goes to err_fd,
 * stdout to out_fd. */
static pid_t start(const char *line, int out_fd, int err_fd, rlim_t file_limit)
{
    static char copy[8 * PATH_MAX];
    char program[PATH_MAX];
    char *argv[64] = {program};
    int argc = 1;
    snprintf(program, sizeof program, "%s", lf_test_built("quiltrender"));
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word && argc < 63; word = strtok(NULL, " "))
        argv[argc++] = word;
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        const struct rlimit limit = {file_limit, file_limit};
        if (file_limit != RLIM_INFINITY)
            setrlimit(RLIMIT_FSIZE, &limit);
        dup2(out_fd, STDOUT_FILENO);
        dup2(err_fd, STDERR_FILENO);
        execv(program, argv);
        _exit(127);
    }
    return pid;
}

static int ended(pid_t pid)
{
    int status = 0;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

static void read_back(int fd, char *text, size_t size)
{
    ssize_t n = pread(fd, text, size - 1, 0);
    text[n > 0 ? n : 0] = '\0';
    close(fd);
}

static void run_limited(outcome *o, const char *line, rlim_t file_limit)
{
    int out = memfd_create("stdout", 0);
    int err = memfd_create("stderr", 0);
    assert_true(out >= 0 && err >= 0);
    o->code = ended(start(line, out, err, file_limit));
    read_back(out, o->out, sizeof o->out);
    read_back(err, o->err, sizeof o->err);
}

static void run(outcome *o, const char *fmt, ...) LF_PRINTF(2, 3);
static void run(outcome *o, const char *fmt, ...)
{
    char line[8 * PATH_MAX];
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    run_limited(o, line, RLIM_INFINITY);
}

static void succeed(const char *fmt, ...) LF_PRINTF(1, 2);
static void succeed(const char *fmt, ...)
{
    char line[8 * PATH_MAX];
    outcome o;
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    run_limited(&o, line, RLIM_INFINITY);
    if (o.code != 0)
        fail_msg("quiltrender %s: exit %d, %s", line, o.code, o.err);
}

/* One line "quiltrender: WHERE: WHAT", exit `code`, holding `words`. */
static void assert_fails(const outcome *o, int code, const char *words)
{
    if (o->code != code || strncmp(o->err, "quiltrender: ", 13) != 0 || !strstr(o->err, words))
        fail_msg("exit %d with \"%s\", expected exit %d with \"%s\"", o->code, o->err, code, words);
    const char *end = strchr(o->err, '\n');
    assert_non_null(end);
    assert_int_equal(end[1], '\0');
    assert_string_equal(o->out, "");
}

static bool exists(const char *folder, const char *name)
{
    return access(lf_test_path(folder, name), F_OK) == 0;
}

static int count_files(const char *folder)
{
    DIR *dir = opendir(folder);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir))
        n += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return n;
}

static void assert_same_files(const char *a, const char *b)
{
    char *x = NULL;
    char *y = NULL;
    size_t n = 0;
    size_t m = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(a, NULL, UINT64_C(1) << 30, &x, &n, &err), &err);
    lf_assert_ok(lf_file_read(b, NULL, UINT64_C(1) << 30, &y, &m, &err), &err);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    lf_free(x);
    lf_free(y);
}

static void assert_different_files(const char *a, const char *b)
{
    char *x = NULL;
    char *y = NULL;
    size_t n = 0;
    size_t m = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(a, NULL, UINT64_C(1) << 30, &x, &n, &err), &err);
    lf_assert_ok(lf_file_read(b, NULL, UINT64_C(1) << 30, &y, &m, &err), &err);
    assert_true(n != m || memcmp(x, y, n) != 0);
    lf_free(x);
    lf_free(y);
}

/* ------------------------------------------------------------------------------- wrong usage -- */

static void wrong_usage_is_one_line_and_exit_2(void **state)
{
    static const struct {
        const char *line, *words; /* %S = the scene, %Q = the quilt, %D = the folder */
    } cases[] = {
        {"", "SCENE: missing"},
        {"%S", "-o: missing"},
        {"%S other.json -o %D/x.png", "other.json: one SCENE"},
        {"%S -o %D/x.jpg", ".png or .exr"},
        {"%S -o %D/x.tif", "--print LPI@DPI"},
        {"%S -o %D/x.png --shiny", "--shiny: unknown option"},
        {"%S -o %D/x.png --views many", "--views: expects a whole number"},
        {"%S -o %D/x.png --preset phone", "--preset: "},
        {"%S -o %D/x.png --quilt 2x2", "--quilt: 2x2 holds 4 tiles"},
        {"%S -o %D/x_qs5x9a0.75.png", "the name says 5x9"},
        {"%S -o %D/x.png --passes 4 --spp 4", "only one of them"},
        {"%S -o %D/x.png --time 1 --target-error 0.1", "only one of them"},
        {"%S -o %D/x.png --time 0", "--time: expects"},
        {"%S -o %D/x.png --filter linear", "--filter: only goes with --panel"},
        {"%S -o %D/x.png --bleed 3", "--bleed: only goes with --print"},
        {"%S -o %D/x.tif --print 60@600", "needs --print-size"},
        {"%S -o %D/x.tif --print 60 --print-size 20x20", "--print: expects"},
        {"%S -o %D/x.tif --print 60@600.5 --print-size 20x20", "DPI a whole number"},
        {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --bits 12", "--bits: expects 8 or 16"},
        {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --compress zip",
         "--compress: expects none, lzw or deflate"},
        {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --orientation up", "--orientation: "},
        {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --views 12", "12"},
        {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --preset go", "no --preset"},
        {"%S -o %D/x.png --print 60@600 --print-size 20x20", "ends in .tif"},
        {"%S -o %D/x.png --panel p.json --print 60@600 --print-size 20x20", "one job"},
        {"%S -o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60", "nothing is rendered"},
        {"-o %D/x.tif --chart 60+-0.5@600 --print-size 60x60",
         "--chart: expects LPI+-RANGE/STEP@DPI"},
        {"-o %D/x.tif --chart 60+-0.5/0.1@600", "needs --print-size"},
        {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60 --marks", "marks"},
        {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60 --spp 4",
         "--spp: does not go with --chart"},
        {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x20", "11 bands"},
        {"-o %D/x.png --chart 60+-0.5/0.1@600 --print-size 60x60", "ends in .tif"},
        {"%S -o %D/fog.tif --print 60@600 --print-size 2x2 --views 2 --spp 1",
         "what is being rendered"},
        {"%S -o %D/x.png --stats %S", "what is being rendered"},
        {"%S -o %D/panel.tif --print 60@600 --print-size 2x2 --views 2 --spp 1",
         "no manifest of a print"},
        {"%S -o %D/x.png --skip all,none", "stands alone"},
        {"%Q -o %D/x.png --view-size 4x4", "--view-size: does not go with a finished quilt"},
        {"%Q -o %D/x.png --spp 64", "--spp: does not go with a finished quilt"},
        {"%Q -o %D/x.png --threads 1 --estimator cv",
         "--estimator: does not go with a finished quilt"},
        {"%Q -o %D/x.png --views 7", "--views: 7 views asked for, but the quilt has 6"},
        {"%S -o %D/x.png --estimator best", "--estimator: "},
    };
    const fixture *f = *state;
    int before = count_files(f->folder);

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char line[4 * PATH_MAX] = "";
        outcome o;
        for (const char *c = cases[i].line; *c; c++) {
            const char *insert = c[0] != '%'   ? NULL
                                 : c[1] == 'S' ? f->scene
                                 : c[1] == 'Q' ? f->quilt
                                               : f->folder;
            size_t used = strlen(line);
            snprintf(line + used, sizeof line - used, insert ? "%s" : "%.1s", insert ? insert : c);
            c += !!insert;
        }
        print_message("%s\n", cases[i].line);
        run(&o, "%s", line);
        assert_fails(&o, 2, cases[i].words);
    }
    assert_int_equal(count_files(f->folder), before);
}

static void failing_jobs_are_one_line_and_exit_1(void **state)
{
    const fixture *f = *state;
    outcome o;
    int before = count_files(f->folder);
    run(&o, "%s/absent.json -o %s/x.png", f->folder, f->folder);
    assert_fails(&o, 1, "absent.json");
    run(&o, "%s -o %s/nowhere/x.png", f->scene, f->folder);
    assert_fails(&o, 1, "nowhere");
    run(&o, "%s -o %s/x.png --panel %s/absent.json", f->scene, f->folder, f->folder);
    assert_fails(&o, 1, "absent.json");
    run(&o, "%s -o %s/x.png --panel %s", f->scene, f->folder, f->scene);
    assert_fails(&o, 1, "fog.json");
    run(&o, "%s -o %s/x.png --stats %s/nowhere/s.json", f->scene, f->folder, f->folder);
    assert_fails(&o, 1, "s.json");
    assert_int_equal(count_files(f->folder), before);
    const char *bad =
        lf_test_write(f->folder, "bad.json", "{ \"quiltd\": 1,\n  \"camera\": { \"fov\": 14 } }\n");
    run(&o, "%s -o %s/x.png", bad, f->folder);
    assert_fails(&o, 1, "bad.json:2");
    bad = lf_test_write(f->folder, "bad_qs3x2.png", "no picture");
    run(&o, "%s -o %s/x.png", bad, f->folder);
    assert_int_equal(o.code, 1);
    assert_false(exists(f->folder, "x.png"));
}

static void help_and_version_answer_on_stdout(void **state)
{
    outcome o;
    (void)state;
    run(&o, "--help");
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.out, "Usage: quiltrender SCENE -o OUT"));
    assert_string_equal(o.err, "");
    run(&o, "--version");
    assert_int_equal(o.code, 0);
    assert_true(strncmp(o.out, "quiltrender ", 12) == 0);
    assert_string_equal(o.err, "");
}

/* ---------------------------------------------------------------------------- quilt pictures -- */

static void a_quilt_goes_to_floats_and_folders_and_back(void **state)
{
    const fixture *f = *state;
    const char *d = f->folder;
    lf_image8 before = {0};
    lf_image8 after = {0};
    lf_error err = {0};
    succeed("%s -o %s/a.exr", f->quilt, d);
    succeed("%s/a_qs3x2a1.5.exr -o %s/a/", d, d);
    succeed("%s/a/ -o %s/b_qs3x2a1.5.png --quilt 3x2", d, d);
    lf_assert_ok(lf_image8_read(f->quilt, NULL, &before, &err), &err);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "b_qs3x2a1.5.png"), NULL, &after, &err), &err);
    assert_int_equal(before.width, after.width);
    assert_int_equal(before.height, after.height);
    for (int y = 0; y < before.height; y++)
        assert_memory_equal(before.data + (size_t)y * before.stride,
                            after.data + (size_t)y * after.stride, (size_t)before.width * 3);
    lf_image8_finish(&before);
    lf_image8_finish(&after);
}

static void a_quilt_is_woven_for_a_panel(void **state)
{
    const fixture *f = *state;
    lf_calibration calibration;
    lf_interlacer *interlacer = NULL;
    lf_quilt_file quilt = {0};
    lf_image8 expected = {0};
    lf_image8 got = {0};
    lf_error err = {0};
    lf_assert_ok(lf_calibration_load(f->calibration, &calibration, &err), &err);
    lf_assert_ok(lf_quilt_read(f->quilt, NULL, 0, 0, &quilt, &err), &err);
    for (int variant = 0; variant < 2; variant++) {
        lf_filter filter = variant ? LF_FILTER_LINEAR : LF_FILTER_NEAREST;
        lf_invert invert = variant ? LF_INVERT_NO : LF_INVERT_AUTO;
        succeed("%s -o %s/w.png --panel %s%s", f->quilt, f->folder, f->calibration,
                variant ? " --filter linear --invert no" : "");
        lf_assert_ok(lf_interlacer_create(&calibration, VIEWS, WIDTH, HEIGHT, 1.5, filter, invert,
                                          &interlacer, &err),
                     &err);
        lf_assert_ok(lf_image8_init(&expected, 90, 60, 3), NULL);
        lf_interlace(interlacer, &quilt.views8, &expected, NULL);
        lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "w.png"), NULL, &got, &err), &err);
        for (int y = 0; y < 60; y++)
            assert_memory_equal(got.data + (size_t)y * got.stride,
                                expected.data + (size_t)y * expected.stride, 90 * 3);
        lf_interlacer_destroy(interlacer);
        lf_image8_finish(&expected);
        lf_image8_finish(&got);
    }
    lf_quilt_finish(&quilt);
}

static json_t *load(const char *folder, const char *name)
{
    json_t *object = json_load_file(lf_test_path(folder, name), 0, NULL);
    assert_true(json_is_object(object));
    return object;
}

static void a_chart_needs_no_scene(void **state)
{
    const fixture *f = *state;
    json_error_t error;
    succeed("--chart 30+-0.2/0.1@300 --print-size 60x40 -o %s/chart.tif", f->folder);
    json_t *manifest = json_load_file(lf_test_path(f->folder, "chart.json"), 0, &error);
    const json_t *chart = json_object_get(manifest, "chart");
    assert_int_equal(json_array_size(json_object_get(chart, "bands")), 5);
    json_decref(manifest);
}

static void a_quilt_is_printed(void **state)
{
    const fixture *f = *state;
    succeed("%s -o %s/p.tif --print 60@600 --print-size 20x15 --bleed 2 --compress lzw --views 5",
            f->quilt, f->folder);
    json_t *manifest = load(f->folder, "p.json");
    assert_true(exists(f->folder, "p.tif"));
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(manifest, "stripes"), "views")), 5);
    json_decref(manifest);
    succeed("%s -o %s/q.tif --print 60@600 --print-size 20x15", f->quilt, f->folder);
    manifest = load(f->folder, "q.json");
    /* ten would fit */
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(manifest, "stripes"), "views")), VIEWS);
    json_decref(manifest);
}

/* --------------------------------------------------------------------------------- rendering -- */

static void stats_have_the_stated_keys_and_nothing_made_up(void **state)
{
    static const char *const keys[] = {"scene",
                                       "integrator",
                                       "estimator",
                                       "views",
                                       "width",
                                       "height",
                                       "threads",
                                       "seed",
                                       "passes",
                                       "seconds",
                                       "cpu_seconds",
                                       "base_paths",
                                       "native_spp_mean",
                                       "effective_spp_mean",
                                       "rel_mse_estimate",
                                       "rel_mse_bound",
                                       "rays_traced",
                                       "volume_lookups",
                                       "contributions",
                                       "nonfinite_dropped",
                                       "peak_rss_bytes",
                                       "skipped"};
    const size_t n = sizeof keys / sizeof keys[0];
    const fixture *f = *state;
    succeed("%s -o %s/s.exr --view-size 12x16 --spp 4 --seed 5 --threads 2 --estimator mis --stats "
            "%s/s.json",
            f->scene, f->folder, f->folder);
    succeed("%s -o %s/t.exr --stats %s/t.json", f->quilt, f->folder, f->folder);
    for (int quilt = 0; quilt < 2; quilt++) {
        json_t *stats = load(f->folder, quilt ? "t.json" : "s.json");
        assert_int_equal(json_object_size(stats), n);
        for (size_t i = 0; i < n; i++)
            assert_non_null(json_object_get(stats, keys[i]));
        assert_int_equal(json_integer_value(json_object_get(stats, "views")), VIEWS);
        assert_true(json_integer_value(json_object_get(stats, "peak_rss_bytes")) > 1000000);
        assert_true(json_is_object(json_object_get(stats, "skipped")));
        for (size_t i = 0; quilt && i < n; i++) {
            bool applies = strcmp(keys[i], "scene") == 0 || strcmp(keys[i], "views") == 0 ||
                           strcmp(keys[i], "width") == 0 || strcmp(keys[i], "height") == 0 ||
                           strcmp(keys[i], "threads") == 0 ||
                           strcmp(keys[i], "peak_rss_bytes") == 0 ||
                           strcmp(keys[i], "skipped") == 0;
            assert_int_equal(json_is_null(json_object_get(stats, keys[i])), !applies);
        }
        json_decref(stats);
    }
    json_t *stats = load(f->folder, "s.json");
    assert_string_equal(json_string_value(json_object_get(stats, "integrator")), "mvpt");
    assert_string_equal(json_string_value(json_object_get(stats, "estimator")), "mis");
    assert_int_equal(json_integer_value(json_object_get(stats, "seed")), 5);
    assert_int_equal(json_integer_value(json_object_get(stats, "threads")), 2);
    assert_int_equal(json_integer_value(json_object_get(stats, "passes")), 4 * VIEWS);
    assert_int_equal(json_integer_value(json_object_get(stats, "base_paths")), 4 * VIEWS * 12 * 16);
    assert_int_equal(json_integer_value(json_object_get(stats, "nonfinite_dropped")), 0);
    assert_true(json_is_integer(json_object_get(stats, "rays_traced")));
    json_decref(stats);
}

static void the_same_bytes_for_any_number_of_threads(void **state)
{
    const fixture *f = *state;
    const char *d = f->folder;
    static const char *const ways[] = {"--estimator mwis", "--estimator cv",
                                       "--estimator mis --sampler independent",
                                       "--integrator vpt --estimator mis"};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        for (int threads = 1; threads <= 3; threads++)
            succeed("%s -o %s/n%d_qs2x3a0.75.exr --view-size 15x20 --quilt 2x3 --spp 3 --seed 7 "
                    "--threads %d %s",
                    f->scene, d, threads, threads, ways[i]);
        for (int threads = 2; threads <= 3; threads++) {
            char other[64];
            snprintf(other, sizeof other, "n%d_qs2x3a0.75.exr", threads);
            assert_same_files(lf_test_path(d, "n1_qs2x3a0.75.exr"), lf_test_path(d, other));
        }
    }
    /* and they are not the same by accident */
    succeed("%s -o %s/n2_qs2x3a0.75.exr --view-size 15x20 --quilt 2x3 --spp 3 --seed 8 %s",
            f->scene, d, ways[3]);
    assert_different_files(lf_test_path(d, "n1_qs2x3a0.75.exr"),
                           lf_test_path(d, "n2_qs2x3a0.75.exr"));
}

static void spp_is_so_many_passes_a_view(void **state)
{
    const fixture *f = *state;
    succeed("%s -o %s/e1_qs2x3a0.75.exr --quilt 2x3 --view-size 15x20 --spp 2", f->scene,
            f->folder);
    succeed("%s -o %s/e2_qs2x3a0.75.exr --quilt 2x3 --view-size 15x20 --passes 12", f->scene,
            f->folder);
    assert_same_files(lf_test_path(f->folder, "e1_qs2x3a0.75.exr"),
                      lf_test_path(f->folder, "e2_qs2x3a0.75.exr"));
}

static void every_budget_ends(void **state)
{
    const fixture *f = *state;
    succeed("%s -o %s/b_qs2x3a0.75.png --quilt 2x3 --view-size 6x8 --time 0.2 --stats %s/b.json",
            f->scene, f->folder, f->folder);
    json_t *stats = load(f->folder, "b.json");
    assert_true(json_integer_value(json_object_get(stats, "passes")) >= 2);
    json_decref(stats);
    succeed("%s -o %s/b_qs2x3a0.75.png --quilt 2x3 --view-size 6x8 --target-error 0.05 --stats "
            "%s/b.json",
            f->scene, f->folder, f->folder);
    stats = load(f->folder, "b.json");
    const json_t *error = json_object_get(stats, "rel_mse_estimate");
    assert_true(json_is_real(error));
    assert_true(json_real_value(error) <= 0.05 && json_real_value(error) > 0);
    const json_t *bound = json_object_get(stats, "rel_mse_bound");
    assert_true(json_real_value(bound) <= 0.05 && json_real_value(bound) > json_real_value(error));
    json_decref(stats);
    succeed("%s -o %s/b_qs2x3a0.75.png --quilt 2x3 --view-size 6x8 --passes 1 --estimator cv",
            f->scene, f->folder);
}

static void a_scene_becomes_what_the_options_say(void **state)
{
    const fixture *f = *state;
    const char *d = f->folder;
    lf_quilt_file quilt = {0};
    lf_image8 panel = {0};
    lf_error err = {0};
    succeed("%s -o %s/o/ --views 3 --view-size 9x7 --spp 1", f->scene, d);
    lf_assert_ok(lf_quilt_read(lf_test_path(d, "o/"), NULL, 0, 0, &quilt, &err), &err);
    assert_int_equal(quilt.layout.n_views, 3);
    assert_int_equal(quilt.layout.view_width, 9);
    assert_int_equal(quilt.layout.view_height, 7);
    lf_quilt_finish(&quilt);

    succeed("%s -o %s/o.png --views 5 --quilt 3x2 --view-size 9x12 --spp 1", f->scene, d);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "o_qs3x2a0.75.png"), NULL, &panel, &err), &err);
    assert_int_equal(panel.width, 27);
    assert_int_equal(panel.height, 24);
    for (int x = 18; x < 27; x++) /* the sixth tile, top right, is black */
        assert_int_equal(panel.data[(size_t)5 * panel.stride + (size_t)x * 3], 0);
    lf_image8_finish(&panel);

    succeed("%s -o %s/o.png --panel %s --view-size 18x12 --spp 1", f->scene, d, f->calibration);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "o.png"), NULL, &panel, &err), &err);
    assert_int_equal(panel.width, 90);
    assert_int_equal(panel.height, 60);
    lf_image8_finish(&panel);

    for (int horizontal = 0; horizontal < 2; horizontal++) {
        succeed("%s -o %s/o.tif --print 20.04@100 --print-size 30x20 --bleed 1 --orientation %s "
                "--spp 1 --stats %s/o_stats.json",
                f->scene, d, horizontal ? "horizontal" : "vertical", d);
        json_t *stats = load(d, "o_stats.json");
        /* floor(100 / 20.04) */
        assert_int_equal(json_integer_value(json_object_get(stats, "views")), 4);
        int across = (int)json_integer_value(json_object_get(stats, "width"));
        int lenses = (int)ceil((horizontal ? 22 : 32) * 20.04 / 25.4);
        assert_in_range(across, lenses, lenses + 2);
        assert_int_equal(json_integer_value(json_object_get(stats, "height")),
                         (int)lround((horizontal ? 32 : 22) * 100 / 25.4));
        json_decref(stats);
    }
}

/* ----------------------------------------------------------------------- whole or not at all -- */

static void nap(double seconds)
{
    const struct timespec time = {(time_t)seconds, (long)((seconds - floor(seconds)) * 1e9)};
    nanosleep(&time, NULL);
}

/* Until the process catches SIGTERM: it has read its arguments. */
static void await_handler(pid_t pid)
{
    char path[64];
    char text[4096];
    snprintf(path, sizeof path, "/proc/%d/status", (int)pid);
    for (int i = 0; i < 3000; i++, nap(0.01)) {
        FILE *file = fopen(path, "re");
        assert_non_null(file);
        size_t n = fread(text, 1, sizeof text - 1, file);
        fclose(file);
        text[n] = '\0';
        const char *caught = strstr(text, "SigCgt:");
        if (caught && (strtoull(caught + 7, NULL, 16) >> (SIGTERM - 1) & 1))
            return;
    }
    fail_msg("quiltrender never catches SIGTERM");
}

static void a_terminated_job_leaves_nothing_and_exits_1(void **state)
{
    const fixture *f = *state;
    static const char *const outs[] = {"k.exr", "k/"};
    static const int signals[] = {SIGTERM, SIGINT};
    for (int i = 0; i < 2; i++) {
        char line[4 * PATH_MAX];
        char text[4096];
        int before = count_files(f->folder);
        int err = memfd_create("stderr", 0);
        int out = memfd_create("stdout", 0);
        snprintf(line, sizeof line, "%s -o %s/%s --view-size 240x320 --spp 100000 --threads 2",
                 f->scene, f->folder, outs[i]);
        pid_t pid = start(line, out, err, RLIM_INFINITY);
        await_handler(pid);
        nap(0.2);
        kill(pid, signals[i]);
        assert_int_equal(ended(pid), 1);
        read_back(err, text, sizeof text);
        close(out);
        assert_non_null(strstr(text, "interrupted"));
        assert_int_equal(count_files(f->folder), before);
    }
}

static void a_killed_job_leaves_no_broken_file(void **state)
{
    const fixture *f = *state;
    char folder[PATH_MAX];
    char line[4 * PATH_MAX];
    int null = open("/dev/null", O_RDWR);
    lf_quilt_file expected = {0};
    lf_error err = {0};
    int whole = 0;
    snprintf(folder, sizeof folder, "%s/kill", f->folder);
    assert_int_equal(mkdir(folder, 0777), 0);
    lf_assert_ok(lf_quilt_read(f->large, NULL, 0, 0, &expected, &err), &err);
    for (int i = 0; i < 20; i++) {
        snprintf(line, sizeof line, "%s -o %s/k_qs3x2a1.5.png", f->large, folder);
        pid_t pid = start(line, null, null, RLIM_INFINITY);
        nap(0.008 * i); /* from before main to after the end */
        kill(pid, SIGKILL);
        ended(pid);
        if (!exists(folder, "k_qs3x2a1.5.png"))
            continue;
        lf_quilt_file got = {0};
        lf_assert_ok(lf_quilt_read(lf_test_path(folder, "k_qs3x2a1.5.png"), NULL, 0, 0, &got, &err),
                     &err);
        for (int view = 0; view < VIEWS; view++)
            for (int y = 0; y < 160; y++)
                assert_memory_equal(lf_views8_row(&got.views8, view, y),
                                    lf_views8_row(&expected.views8, view, y), 240 * 3);
        lf_quilt_finish(&got);
        whole++;
        if (i % 2)
            unlink(lf_test_path(folder, "k_qs3x2a1.5.png"));
    }
    print_message("%d of 20 killed runs had finished\n", whole);
    succeed("%s", line);
    assert_int_equal(count_files(folder), 1); /* what killed runs left behind is gone */
    lf_quilt_finish(&expected);
    close(null);
}

static void a_full_disk_is_an_error_and_leaves_nothing(void **state)
{
    const fixture *f = *state;
    static const char *const outs[] = {"d_qs3x2a1.5.exr", "d_qs3x2a1.5.png", "d/",
                                       "d.tif --print 60@600 --print-size 40x40"};
    for (size_t i = 0; i < sizeof outs / sizeof outs[0]; i++) {
        char line[4 * PATH_MAX];
        outcome o;
        int before = count_files(f->folder);
        snprintf(line, sizeof line, "%s -o %s/%s", f->large, f->folder, outs[i]);
        run_limited(&o, line, 16384);
        assert_fails(&o, 1, "File too large");
        assert_int_equal(count_files(f->folder), before);
    }
}

static void what_a_scene_lacks_is_a_line_on_stderr(void **state)
{
    const fixture *f = *state;
    outcome o;
    char scene[PATH_MAX];
    lf_test_write(f->folder, "bare.mtl", "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nd 0.5\n");
    lf_test_write(f->folder, "bare.obj",
                  "mtllib bare.mtl\nusemtl wood\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    snprintf(
        scene, sizeof scene, "%s",
        lf_test_write(f->folder, "bare.json", "{\"meshes\": {\"m\": {\"file\": \"bare.obj\"}}}"));
    run(&o, "%s --spp 1 --views 2 --quilt 2x1 --view-size 8x8 -o %s/bare.png", scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "bare.obj: material \"wood\": textures are not read"));
    assert_non_null(strstr(o.err, "bare.obj: material \"wood\": transparency is left out"));
    assert_non_null(strstr(o.err, "bare.json: no light shines here"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage_is_one_line_and_exit_2),
        cmocka_unit_test(failing_jobs_are_one_line_and_exit_1),
        cmocka_unit_test(help_and_version_answer_on_stdout),
        cmocka_unit_test(a_quilt_goes_to_floats_and_folders_and_back),
        cmocka_unit_test(a_quilt_is_woven_for_a_panel),
        cmocka_unit_test(a_chart_needs_no_scene),
        cmocka_unit_test(a_quilt_is_printed),
        cmocka_unit_test(stats_have_the_stated_keys_and_nothing_made_up),
        cmocka_unit_test(the_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(spp_is_so_many_passes_a_view),
        cmocka_unit_test(every_budget_ends),
        cmocka_unit_test(a_scene_becomes_what_the_options_say),
        cmocka_unit_test(a_terminated_job_leaves_nothing_and_exits_1),
        cmocka_unit_test(a_killed_job_leaves_no_broken_file),
        cmocka_unit_test(what_a_scene_lacks_is_a_line_on_stderr),
        cmocka_unit_test(a_full_disk_is_an_error_and_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
