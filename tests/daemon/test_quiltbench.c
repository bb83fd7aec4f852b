/* quiltbench from outside: its numbers on pictures whose errors are known, its limits as exit
 * codes. */
#include "tests/daemon/movies.h"
#include "tests/daemon/quiltbench.h"
#include "tests/scene_file.h"

#include "base/calibration.h"
#include "base/image_io.h"

#define WIDTH 21
#define HEIGHT 14

static void assert_error_line(const char *folder, const char *words)
{
    char text[4096] = "";
    FILE *file = fopen(lf_test_path(folder, "err"), "rb");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    fclose(file);
    if (strncmp(text, "quiltbench: ", 12) != 0 || !strstr(text, words) ||
        strchr(text, '\n') != text + strlen(text) - 1)
        fail_msg("\"%s\", expected one line with \"%s\"", text, words);
}

/* A picture of the value `value`, but `special` in the 7x7 block whose top left pixel is 7, 7. */
static void write_picture(const char *folder, const char *name, int views, float value,
                          float special)
{
    lf_image32 image = {0};
    lf_outfile file;
    lf_error err = {0};
    lf_assert_ok(lf_image32_init(&image, views * WIDTH, HEIGHT, 3), NULL);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < views * WIDTH; x++) {
            bool in = x % WIDTH >= 7 && x % WIDTH < 14 && y >= 7;
            /* another value in every view, so that --view has something to pick */
            for (int c = 0; c < 3; c++)
                image.data[((size_t)y * (size_t)(views * WIDTH) + (size_t)x) * 3 + (size_t)c] =
                    (in ? special : value) + (float)(x / WIDTH);
        }
    }
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, name), true, &err), &err);
    lf_assert_ok(lf_exr_write(&file, &image, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image32_finish(&image);
}

static void errors_are_the_stated_formulas(void **state)
{
    const char *d = *state;
    write_picture(d, "one.exr", 1, 1, 1);
    write_picture(d, "off.exr", 1, 1, 1.5f); /* one of six blocks is off by a half */
    assert_int_equal(bench_run(d, "error one.exr off.exr --epsilon 0.25 --json e.json"), 0);
    json_t *e = bench_load(d, "e.json");
    lf_assert_close(bench_number(e, "rel_mse"), 0.25 / 1.25 / 6, 1e-6, 0);
    lf_assert_close(bench_number(e, "rmse"), sqrt(0.25 / 6), 1e-6, 0);
    lf_assert_close(bench_number(e, "relative_mean"), 0.5 / 6, 1e-6, 0);
    lf_assert_close(bench_number(e, "bias"), 0.5 / 6, 1e-6, 0);
    /* six block differences, one of them 0.5: standard deviation 0.5/sqrt(6) */
    lf_assert_close(bench_number(e, "bias_se"), 0.5 / sqrt(6) / sqrt(6), 1e-6, 0);
    lf_assert_close(bench_number(e, "block_rms"), 0.5 / sqrt(6 * 1.0001), 1e-6, 0);
    lf_assert_close(bench_number(e, "pixels"), WIDTH * HEIGHT, 0, 0);
    lf_assert_close(bench_number(e, "holes"), 0, 0, 0);
    json_decref(e);

    write_picture(d, "hole.exr", 1, 1, 0);
    assert_int_equal(bench_run(d, "error one.exr hole.exr --json e.json"), 0);
    e = bench_load(d, "e.json");
    lf_assert_close(bench_number(e, "holes"), 49, 0, 0);
    json_decref(e);

    assert_int_equal(bench_run(d, "error one.exr one.exr --json e.json"), 0);
    e = bench_load(d, "e.json");
    lf_assert_close(bench_number(e, "rel_mse"), 0, 0, 0);
    lf_assert_close(bench_number(e, "block_rms"), 0, 0, 0);
    json_decref(e);
}

static void limits_are_exit_codes(void **state)
{
    const char *d = *state;
    write_picture(d, "one.exr", 1, 1, 1);
    write_picture(d, "off.exr", 1, 1.01f, 1.01f);
    assert_int_equal(
        bench_run(d, "error one.exr off.exr --max-mean 1.1% --max-block 1.1% --max-relmse 0.001"),
        0);
    assert_int_equal(bench_run(d, "error one.exr off.exr --max-mean 0.9%"), 1);
    assert_error_line(d, "the mean differs by +1.0000 %");
    assert_int_equal(bench_run(d, "error one.exr off.exr --max-block 0.009"), 1);
    assert_error_line(d, "7x7 blocks differ");
    assert_int_equal(bench_run(d, "error one.exr off.exr --max-relmse 1e-5"), 1);
    assert_error_line(d, "relMSE");
}

static void one_view_is_picked_out_of_many(void **state)
{
    const char *d = *state;
    write_picture(d, "one.exr", 1, 3, 3); /* is view 2 of the quilt */
    write_picture(d, "q_qs4x1.exr", 4, 1, 1);
    assert_int_equal(bench_run(d, "error one.exr q_qs4x1.exr --view 2 --max-relmse 0"), 0);
    assert_int_equal(bench_run(d, "error one.exr q_qs4x1.exr --view 1 --max-relmse 0.01"), 1);
    assert_int_equal(bench_run(d, "error q_qs4x1.exr q_qs4x1.exr --max-relmse 0"), 0);
    assert_int_equal(bench_run(d, "error one.exr q_qs4x1.exr"), 1);
    assert_error_line(d, "has 4 views, but the reference has 1");
    assert_int_equal(bench_run(d, "error one.exr q_qs4x1.exr --view 4"), 1);
    assert_error_line(d, "view 4 does not exist");
}

static void wrong_usage_is_one_line_and_exit_2(void **state)
{
    static const struct {
        const char *line, *words;
    } cases[] = {
        {"", "COMMAND: is missing"},
        {"measure", "measure: unknown command"},
        {"error one.exr", "expects REFERENCE and IMAGE"},
        {"error a b c", "expects REFERENCE and IMAGE"},
        {"error a b --block 0", "--block"},
        {"error a b --max-mean much", "--max-mean"},
        {"compare", "expects one SCENE"},
        {"compare s.json --ours mvpt", "INTEGRATOR:ESTIMATOR"},
        {"compare s.json --ours magic:mis", "INTEGRATOR mvpt"},
        {"compare s.json --seeds 0", "--seeds"},
        {"compare s.json --integrator vpt", "INTEGRATOR:ESTIMATOR"},
        {"curve", "expects one SCENE"},
        {"curve s.json --contenders vpt:mwis,mvpt", "INTEGRATOR:ESTIMATOR"},
        {"curve s.json --budgets 0", "--budgets"},
        {"table", "expects one FOLDER"},
        {"table x --scenes cloud,moon", "unknown scene \"moon\""},
        {"papers", "expects one FOLDER"},
        {"papers x --scenes cloud,moon", "unknown scene \"moon\""},
        {"papers x --selection none", "--selection: cannot be used here"},
        {"shown", "expects one SCENE"},
        {"shown s.json --budgets 1,,2", "--budgets"},
        {"shown s.json --budgets 2,1", "ascending"},
        {"shown s.json --passes 4,2", "ascending"},
        {"shown s.json --passes 2.5", "whole numbers"},
        {"views", "expects one SCENE"},
        {"views s.json --counts 4,2", "ascending"},
        {"views s.json --counts 0", "--counts"},
        {"--out", "--out: expects an argument"},
        {"--scenes x", "--out: is missing"},
    };
    const char *d = *state;

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        print_message("%s\n", cases[i].line);
        assert_int_equal(bench_run(d, cases[i].line), 2);
        assert_error_line(d, cases[i].words);
    }
    assert_int_equal(bench_run(d, "error absent.exr absent.exr"), 1);
    assert_error_line(d, "absent.exr");
}

static void a_comparison_says_what_it_compared(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d, "compare fog.json --view-size 6x8 --time 0.05 --seeds 3 "
                                  "--reference-spp 256 --ours vpt:mis "
                                  "--json c.json"),
                     0);
    json_t *c = bench_load(d, "c.json");
    assert_non_null(json_object_get(json_object_get(c, "machine"), "cpu"));
    lf_assert_close(bench_number(c, "views"), 6, 0, 0);
    lf_assert_close(bench_number(c, "seeds"), 3, 0, 0);
    assert_int_equal(json_array_size(json_object_get(c, "ratios")), 3);
    assert_true(bench_number(json_object_get(c, "reference"), "rel_mse") > 0);
    const json_t *runs = json_object_get(json_object_get(c, "ours"), "runs");
    assert_int_equal(json_array_size(runs), 3);
    assert_true(bench_number(json_array_get(runs, 0), "cpu_seconds") > 0);
    assert_true(bench_number(c, "ratio_low") <= bench_number(c, "ratio_median") &&
                bench_number(c, "ratio_median") <= bench_number(c, "ratio_high"));
    json_decref(c);
    assert_int_equal(bench_run(d, "compare fog.json --view-size 6x8 --time 0.05 --seeds 1 "
                                  "--reference-spp 256 --ours vpt:mis "
                                  "--min-ratio 1000"),
                     1);
    assert_error_line(d, "the median ratio is");
}

static double number_in(const json_t *object, const char *key, size_t i)
{
    return json_number_value(json_array_get(json_object_get(object, key), i));
}

static void what_is_shown_is_nearer_after_the_same_time(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d, "shown fog.json --view-size 24x32 --budgets 0.02,0.08 --seeds 2 "
                                  "--reference-spp 64 --json s.json"),
                     0);
    json_t *s = bench_load(d, "s.json");
    const json_t *budgets = json_object_get(s, "budgets");
    assert_int_equal(json_array_size(budgets), 2);
    for (size_t seed = 0; seed < 2; seed++) {
        const json_t *first = json_array_get(budgets, 0);
        const double shown = number_in(first, "shown", seed),
                     unfiltered = number_in(first, "unfiltered", seed);
        lf_assert_close(number_in(first, "gain", seed), unfiltered / shown, 0, 1e-6);
        assert_true(number_in(first, "gain", seed) > 2);
        assert_true(number_in(first, "worst_tile", seed) >= number_in(first, "mean_tile", seed));
        assert_true(number_in(first, "flicker_gain", seed) > 2);
        assert_true(number_in(first, "passes", seed) >= 2);
        assert_null(json_object_get(first, "eye_shown"));
    }
    json_decref(s);
}

/* Where nothing scatters there is nothing to filter: both pictures of one film are the same. After
 * twelve passes the unfiltered one alone would have had fewer visits, with three times the error.
 */
static void equal_passes_are_of_the_same_film(void **state)
{
    const char *d = *state;
    lf_test_write(d, "glow.json", lf_test_scene_text("lone-emissive-ball"));
    assert_int_equal(bench_run(d, "shown glow.json --view-size 24x32 --passes 12 --seeds 2 "
                                  "--reference-spp 64 --json s.json"),
                     0);
    json_t *s = bench_load(d, "s.json");
    const json_t *first = json_array_get(json_object_get(s, "budgets"), 0);
    for (size_t seed = 0; seed < 2; seed++) {
        assert_true(number_in(first, "shown", seed) > 0);
        lf_assert_close(number_in(first, "gain", seed), 1, 0, 1e-6);
    }
    json_decref(s);
}

/* A Portrait of as few pixels as its lenses let it have for such views. */
static void write_panel(const char *folder, const char *name)
{
    lf_calibration panel;
    lf_calibration_portrait(&panel);
    panel.screen_width_px = 192;
    panel.screen_height_px = 256;
    json_t *object = lf_calibration_json(&panel);
    assert_non_null(object);
    assert_int_equal(json_dump_file(object, lf_test_path(folder, name), 0), 0);
    json_decref(object);
}

/* What is seen through lenses is a mean over pixels, so its errors are smaller than those of the
 * views; and a rendering that goes on changes less the longer it has been going on. */
static void eyes_see_less_error_and_less_change_after_more_passes(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    write_panel(d, "panel.json");
    assert_int_equal(bench_run(d,
                               "shown fog.json --view-size 24x32 --passes 4,64 --seeds 2 "
                               "--reference-spp 64 --eye --calibration panel.json --json s.json"),
                     0);
    json_t *s = bench_load(d, "s.json");
    const json_t *budgets = json_object_get(s, "budgets"), *few = json_array_get(budgets, 0),
                 *many = json_array_get(budgets, 1);
    assert_string_equal(json_string_value(json_object_get(s, "budgets_of")), "passes");
    for (size_t seed = 0; seed < 2; seed++) {
        assert_true(number_in(few, "passes", seed) == 4 && number_in(many, "passes", seed) == 64);
        const double unfiltered = number_in(few, "eye_unfiltered", seed);
        assert_true(number_in(few, "eye_shown", seed) < unfiltered);
        assert_true(number_in(many, "eye_unfiltered", seed) < unfiltered);
        assert_true(number_in(few, "eye_flicker", seed) <
                    number_in(few, "eye_flicker_unfiltered", seed));
        const double change = number_in(few, "eye_frame_change", seed);
        assert_true(change > 0 && number_in(many, "eye_frame_change", seed) < 0.5 * change);
    }
    json_decref(s);
}

static void a_curve_falls_and_says_where_the_time_goes(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d,
                               "curve fog.json --view-size 12x16 --time 0.05 --budgets 3 --seeds 3 "
                               "--reference-spp 512 --json c.json "
                               "--plot plot"),
                     0);
    json_t *c = bench_load(d, "c.json");
    const json_t *contenders = json_object_get(c, "contenders");
    assert_int_equal(json_array_size(contenders), 2);
    for (size_t i = 0; i < 2; i++) {
        const json_t *who = json_array_get(contenders, i);
        const json_t *budgets = json_object_get(who, "budgets");
        assert_int_equal(json_array_size(budgets), 3);
        /* four times the time is a quarter of the error, and no less than half of it */
        double first =
            bench_number(json_object_get(json_array_get(budgets, 0), "rel_mse"), "estimate");
        double last =
            bench_number(json_object_get(json_array_get(budgets, 2), "rel_mse"), "estimate");
        assert_true(last > 0 && last < 0.5 * first);
        assert_true(bench_number(who, "path_us") > 0);
        assert_int_equal(json_array_size(json_object_get(json_array_get(budgets, 0), "runs")), 3);
    }
    /* the baseline is one times itself, its views do not share, and those of mvpt do */
    const json_t *alone =
        json_array_get(json_object_get(json_array_get(contenders, 0), "budgets"), 2);
    const json_t *shared =
        json_array_get(json_object_get(json_array_get(contenders, 1), "budgets"), 2);
    lf_assert_close(bench_number(json_object_get(alone, "equal_time_ratio"), "estimate"), 1, 1e-9,
                    0);
    lf_assert_close(bench_number(alone, "correlation_1"), 0, 0, 0.3);
    assert_true(bench_number(shared, "correlation_1") > 0.3);
    assert_true(bench_number(json_array_get(contenders, 0), "escape_share") > 0 &&
                bench_number(json_array_get(contenders, 0), "escape_share") < 1);
    json_decref(c);
    assert_int_equal(access(lf_test_path(d, "plot.dat"), R_OK), 0);
    assert_int_equal(access(lf_test_path(d, "plot.gp"), R_OK), 0);
    if (system("command -v gnuplot > /dev/null 2>&1") == 0) {
        assert_int_equal(access(lf_test_path(d, "plot.svg"), R_OK), 0);
        assert_int_equal(access(lf_test_path(d, "plot.png"), R_OK), 0);
    }
}

/* 6 views against one: the error falls, by no more than 6 (and 20 standard errors or so). */
static void more_views_have_less_error_at_equal_paths(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d,
                               "views fog.json --view-size 12x16 --counts 1,6 --spp 16 --seeds 4 "
                               "--reference-spp 512 --json v.json"),
                     0);
    json_t *v = bench_load(d, "v.json");
    const json_t *counts = json_object_get(v, "counts");
    assert_int_equal(json_array_size(counts), 2);
    double one = bench_number(json_object_get(json_array_get(counts, 0), "rel_mse"), "estimate");
    double six = bench_number(json_object_get(json_array_get(counts, 1), "rel_mse"), "estimate");
    assert_true(six < one && six > one / 12);
    /* the file has nine digits: 5e-9 of each number */
    lf_assert_close(bench_number(json_object_get(v, "exponent"), "estimate"),
                    log(six / one) / log(6), 5e-9, 2 * 5e-9 / log(6));
    assert_true(bench_number(v, "exponent_se") > 0);
    assert_true(bench_number(json_array_get(counts, 0), "base_paths") >= 16);
    json_decref(v);
}

static void a_table_says_what_is_met(void **state)
{
    const char *d = *state;
    assert_int_equal(mkdir(lf_test_path(d, "bench"), 0700), 0);
    bench_write_ball(d);
    assert_int_equal(rename(lf_test_path(d, "fog.json"), lf_test_path(d, "bench/cloud-g098.json")),
                     0);
    assert_int_equal(
        bench_run(d, "table . --scenes cloud-g098 --view-size 20x20 --time 0.05 --seeds 3 "
                     "--json t.json --markdown t.md"),
        0);
    json_t *t = bench_load(d, "t.json");
    const json_t *rows = json_object_get(t, "rows");
    assert_int_equal(json_array_size(rows), 2);
    const json_t *field = json_array_get(rows, 0);
    lf_assert_close(bench_number(field, "views"), 45, 0, 0);
    lf_assert_close(bench_number(json_array_get(rows, 1), "views"), 10, 0, 0);
    /* Three seeds bound no tile, and so none counts. */
    assert_int_equal((int)bench_number(json_object_get(field, "tiles"), "judged"), 0);
    assert_true(json_is_null(json_object_get(json_object_get(field, "tiles"), "worst_low")));
    assert_int_equal((int)bench_number(json_object_get(field, "view_tiles"), "judged"), 0);
    assert_true(bench_number(json_object_get(field, "must"), "tile") > 0);
    assert_true(strlen(json_string_value(json_object_get(field, "verdict"))) > 0);
    assert_string_equal(json_string_value(json_object_get(json_array_get(rows, 1), "verdict")), "");
    json_decref(t);
    assert_int_equal(access(lf_test_path(d, "t.md"), R_OK), 0);
    assert_int_equal(bench_run(d, "table . --scenes cloud"), 1);
    assert_error_line(d, "cloud.json");
}

static const json_t *row_of(const json_t *object, const char *integrator, const char *estimator)
{
    size_t i;
    const json_t *row;
    json_array_foreach(json_object_get(object, "rows"), i, row)
    {
        if (strcmp(json_string_value(json_object_get(row, "integrator")), integrator) == 0 &&
            strcmp(json_string_value(json_object_get(row, "estimator")), estimator) == 0)
            return row;
    }
    fail_msg("no row of %s", integrator);
    return NULL;
}

/* Sharing serves more view pixels a path and has less error for as many; what a member cannot
 * render is said in its row, and the rest goes on. */
static void the_papers_estimators_stand_beside_ours(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(rename(lf_test_path(d, "fog.json"), lf_test_path(d, "cloud.json")), 0);
    assert_int_equal(bench_run(d,
                               "papers . --scenes cloud-1 --views 9 --view-size 20x20 --time 0.1 "
                               "--seeds 3 --json p.json --markdown p.md"),
                     0);
    json_t *p = bench_load(d, "p.json");
    const json_t *base = row_of(p, "vpt", "mwis");
    lf_assert_close(bench_number(base, "equal_time"), 1, 0, 0);
    lf_assert_close(bench_number(base, "equal_paths"), 1, 0, 0);
    const char *const sharing[][2] = {{"mvpt", "mwis"}, {"mvpt2022", "mwis"}, {"mismvpt", "mis"}};
    for (int i = 0; i < 3; i++) {
        const json_t *row = row_of(p, sharing[i][0], sharing[i][1]);
        assert_true(bench_number(row, "path_contributions") >
                    3 * bench_number(base, "path_contributions"));
        assert_true(bench_number(row, "rel_mse") > 0 && fabs(bench_number(row, "mean_off")) < 0.1);
    }
    assert_true(bench_number(row_of(p, "mvpt", "mwis"), "equal_paths") > 1.5);
    json_decref(p);
    assert_int_equal(access(lf_test_path(d, "p.md"), R_OK), 0);
    lf_test_write(d, "cloud.json", lf_test_scene_text("coloured-fog"));
    assert_int_equal(bench_run(d, "papers . --scenes cloud-1 --view-size 6x6 --time 0.02 --seeds 1 "
                                  "--json p.json"),
                     0);
    p = bench_load(d, "p.json");
    assert_true(strlen(json_string_value(json_object_get(row_of(p, "mismvpt", "mis"), "refused"))) >
                0);
    assert_true(bench_number(row_of(p, "mvpt", "mwis"), "path_contributions") > 0);
    json_decref(p);
    assert_int_equal(bench_run(d, "papers . --scenes cloud-g085"), 1);
    assert_error_line(d, "cloud-g085.json");
}

/* The line of a table in JSON whose `key` is `value`, the k-th such. */
static const json_t *line_of(const json_t *object, const char *key, const char *value, int k)
{
    size_t i;
    const json_t *line;
    json_array_foreach(json_object_get(object, "lines"), i, line)
    {
        if (strcmp(json_string_value(json_object_get(line, key)), value) == 0 && k-- == 0)
            return line;
    }
    fail_msg("no line \"%s\"", value);
    return NULL;
}

static void write_fog(const char *folder)
{
    lf_test_write(folder, "fog.json", lf_test_scene_text("shifted-fog"));
}

static void kernels_are_timed_and_must_agree(void **state)
{
    const char *d = *state;
    write_fog(d);
    assert_int_equal(bench_run(d, "micro fog.json --view-size 40x30 --repeat 2 --json m.json"), 0);
    json_t *m = bench_load(d, "m.json");
    lf_assert_close(bench_number(m, "views"), 12, 0, 0);
    /* through the middle of the ball it is 8 mean free paths, on average over the row a quarter of
     * pi of that */
    lf_assert_close(bench_number(m, "optical_depth"), 6.283, 0.1, 0);
    static const char *const kernels[] = {"march to a collision", "densities",
                                          "march through (unscattered light)", "through a shape",
                                          "transmittances of a pivot"};
    for (size_t i = 0; i < sizeof kernels / sizeof kernels[0]; i++) {
        const json_t *plain = line_of(m, "what", kernels[i], 0);
        assert_string_equal(json_string_value(json_object_get(plain, "kernels")), "c");
        lf_assert_close(bench_number(plain, "times_plain_c"), 1, 1e-12, 0);
        assert_true(bench_number(plain, "ns") > 0);
    }
    assert_true(bench_number(line_of(m, "what", "suffix", 0), "ns") > 0);
    json_decref(m);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) {
        assert_int_equal(bench_run(d, "micro fog.json --view-size 40x30 --repeat 1 --fault"), 1);
        assert_error_line(d, "the avx2 kernels and the plain C kernels differ in their results");
    }
#endif
    assert_int_equal(bench_run(d, "micro"), 2);
    assert_error_line(d, "micro: expects one SCENE");
    assert_int_equal(bench_run(d, "micro fog.json --repeat 0"), 2);
    assert_int_equal(bench_run(d, "micro none.json"), 1);
}

/* A grid, which lanes serve: all instruction sets find the same, and a bit that is spoilt is told.
 */
static void suffixes_in_lanes_are_timed_and_must_agree(void **state)
{
    const char *d = *state;
    lf_test_write(d, "grid.json", lf_test_scene_text("block-of-voxels"));
    char *real = realpath(lf_test_built("testdata/block.vdb"), NULL);
    assert_non_null(real);
    assert_int_equal(symlink(real, lf_test_path(d, "block.vdb")), 0);
    free(real);
    assert_int_equal(bench_run(d, "micro grid.json --view-size 40x30 --repeat 1 --json l.json"), 0);
    json_t *m = bench_load(d, "l.json");
    const json_t *plain = line_of(m, "what", "suffix in lanes", 0);
    assert_string_equal(json_string_value(json_object_get(plain, "kernels")), "c");
    assert_true(bench_number(plain, "ns") > 0);
    assert_true(bench_number(line_of(m, "what", "suffix one by one, alternating with", 0), "ns") >
                0);
    json_decref(m);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) {
        assert_int_equal(bench_run(d, "micro grid.json --view-size 40x30 --repeat 1 --fault"), 1);
        assert_error_line(d, "the results of avx2 and of plain C differ");
    }
#endif
}

static void what_is_between_views_and_panel_is_timed(void **state)
{
    const char *d = *state;
    lf_test_write(d, "visual.json", lf_test_scene_text("panel-in-plain-numbers"));
    assert_int_equal(
        bench_run(
            d,
            "quilt visual.json --views 8 --view-size 24x16 --repeat 3 --threads 2 --json q.json"),
        0);
    json_t *q = bench_load(d, "q.json");
    for (int threads = 0; threads < 2; threads++) {
        const json_t *line = line_of(q, "what", "LKG-T 96x64: interlace nearest", threads);
        lf_assert_close(bench_number(line, "threads"), threads + 1, 0, 0);
        lf_assert_close(bench_number(line, "bytes_in"), 8 * 24 * 16 * 3, 0, 0);
        lf_assert_close(bench_number(line, "bytes_out"), 96 * 64 * 3, 0, 0);
        assert_true(bench_number(line, "ms") > 0 && bench_number(line, "cpu_ms") > 0 &&
                    bench_number(line, "ratio_to_copy") > 0);
    }
    lf_assert_close(bench_number(line_of(q, "what", "tone mapping, srgb", 0), "bytes_in"),
                    8 * 24 * 16 * 12, 0, 0);
    line_of(q, "what", "fill, 50 % missing", 1);
    line_of(q, "what", "print, nearest", 0);
    json_decref(q);
    assert_int_equal(bench_run(d, "quilt none.json"), 1);
    assert_int_equal(bench_run(d, "quilt --views 0"), 2);
    assert_int_equal(bench_run(d, "quilt --repeat"), 2);
}

static void what_is_shown_after_a_command_comes_closer(void **state)
{
    const char *d = *state;
    write_fog(d);
    lf_test_write(d, "visual.json", lf_test_scene_text("panel-in-plain-numbers"));
    assert_int_equal(
        bench_run(d, "live fog.json --calibration visual.json --view-size 24x32 --threads 2 "
                     "--seconds 1 --repeat 2 --yaw 20 "
                     "--reference-time 0.5 --speed-passes 1 --json l.json"),
        0);
    json_t *l = bench_load(d, "l.json");
    const json_t *shown = json_object_get(l, "shown");
    lf_assert_close((double)json_array_size(shown), 3, 0, 0);
    const json_t *first = json_object_get(json_array_get(shown, 0), "rel_mse"),
                 *last = json_object_get(json_array_get(shown, 2), "rel_mse");
    assert_true(bench_number(last, "low") < bench_number(first, "high"));
    assert_true(bench_number(last, "high") < 0.1);
    const json_t *coarse = json_object_get(l, "coarse_seconds"),
                 *complete = json_object_get(l, "complete_seconds");
    assert_true(bench_number(coarse, "median") > 0 &&
                bench_number(complete, "median") >= bench_number(coarse, "median"));
    assert_true(bench_number(json_object_get(l, "updates_per_second"), "low") >= 1);
    assert_true(bench_number(json_object_get(l, "wire_bytes_per_second"), "low") > 0);
    assert_true(bench_number(l, "converged_cpus") >= 0 && bench_number(l, "speed_up") > 0);
    json_decref(l);
    assert_int_equal(bench_run(d, "live"), 2);
    assert_error_line(d, "live: expects one SCENE");
    assert_int_equal(bench_run(d, "live fog.json --seconds 0"), 2);
    assert_int_equal(bench_run(d, "live none.json"), 1);
    assert_error_line(d, "none.json");
}

static void what_a_usb_display_is_sent_is_timed_and_ends_exact(void **state)
{
    const char *d = *state;
    int n_exact = 0;
    write_fog(d);
    lf_test_write(d, "visual.json", lf_test_scene_text("panel-in-plain-numbers"));
    assert_int_equal(
        bench_run(d, "usb fog.json --calibration visual.json --view-size 24x32 --threads 2 "
                     "--seconds 0.5 --repeat 2 --json u.json"),
        0);
    json_t *u = bench_load(d, "u.json");
    const json_t *line;
    size_t i;
    json_array_foreach(json_object_get(u, "lines"), i, line)
    {
        if (strcmp(json_string_value(json_object_get(line, "what")), "converging") != 0) {
            assert_true(bench_number(line, "ms") > 0 && bench_number(line, "mb_per_second") > 0);
            continue;
        }
        assert_true(json_is_true(json_object_get(line, "exact")));
        assert_true(bench_number(line, "bytes_an_update") > 0 &&
                    bench_number(line, "share_of_full_frames") <= 1);
        n_exact++;
    }
    assert_true(i > 10);
    assert_int_equal(n_exact, 2);
    json_decref(u);
    assert_int_equal(bench_run(d, "usb fog.json other.json"), 2);
    assert_error_line(d, "one SCENE");
    assert_int_equal(bench_run(d, "usb --seconds 0"), 2);
    assert_int_equal(bench_run(d, "usb none.json"), 1);
    assert_error_line(d, "none.json");
}

static void what_is_left_out_is_timed_and_leaves_the_picture(void **state)
{
    const char *d = *state;
    assert_int_equal(
        bench_run(d, "skip --views 3 --view-size 12x16 --passes 6 --repeat 2 --json s.json"), 0);
    json_t *s = bench_load(d, "s.json");
    const json_t *lines = json_object_get(s, "skips");
    size_t i;
    json_t *line;
    assert_true(json_array_size(lines) >= 12);
    json_array_foreach(lines, i, line)
    {
        assert_true(bench_number(line, "without_over_with") > 0);
        assert_true(bench_number(line, "difference") < 1e-5);
    }
    json_decref(s);
    assert_int_equal(bench_run(d, "skip scene.json"), 2);
    assert_int_equal(bench_run(d, "skip --passes 0"), 2);
}

/* A video is decoded frame by frame; the first frame only starts the clock. */
static void a_frame_of_a_video_is_timed(void **state)
{
    const char *d = *state;
    if (!movie_programs_exist()) {
        print_message("ffmpeg is not installed\n");
        skip();
    }
    (void)movie_make(d, "v_qs3x2a0.75.mp4", 6, 10, MOVIE_LOSSLESS);
    assert_int_equal(bench_run(d, "video v_qs3x2a0.75.mp4 --frames 100 --json v.json"), 0);
    json_t *v = bench_load(d, "v.json");
    assert_true(bench_number(v, "frames") > 4 && bench_number(v, "frames") < 6);
    assert_true(bench_number(v, "ffmpeg_cpu_ms") > 0);
    assert_true(bench_number(v, "interlace_ms") > 0);
    assert_true(bench_number(v, "frame_ms") >= bench_number(v, "interlace_ms"));
    json_decref(v);
    assert_int_equal(bench_run(d, "video v.json"), 1);
    assert_int_equal(bench_run(d, "video v_rgbd.mp4"), 1); /* no time of views that are not drawn */
    assert_int_equal(bench_run(d, "video"), 2);
}

static void plans_are_compared_with_their_jobs(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    lf_test_write(d, "jobs",
                  "# two jobs\nfog.json -o a.png --view-size 12x16 --passes 2\n\nfog.json -o "
                  "views/ --view-size 12x16 --spp 1 --threads 1\n");
    lf_test_write(d, "wrong", "fog.json -o a.png --no-such-option\n");
    assert_int_equal(bench_run(d, "plan jobs --json p.json"), 0);
    json_t *p = bench_load(d, "p.json");
    const json_t *job, *jobs = json_object_get(p, "jobs");
    size_t i;
    assert_int_equal(json_array_size(jobs), 2);
    json_array_foreach(jobs, i, job)
    {
        assert_true(bench_number(job, "planned_cpu_seconds") > 0);
        assert_true(bench_number(job, "cpu_seconds") > 0);
        assert_true(bench_number(job, "planned_memory") > 1e6);
        assert_true(bench_number(job, "memory") > 1e6);
    }
    json_decref(p);
    assert_int_equal(bench_run(d, "plan wrong"), 1);
    assert_int_equal(bench_run(d, "plan none"), 1);
    assert_int_equal(bench_run(d, "plan"), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(plans_are_compared_with_their_jobs),
        lf_test_in_folder(errors_are_the_stated_formulas),
        lf_test_in_folder(limits_are_exit_codes),
        lf_test_in_folder(one_view_is_picked_out_of_many),
        lf_test_in_folder(wrong_usage_is_one_line_and_exit_2),
        lf_test_in_folder(a_comparison_says_what_it_compared),
        lf_test_in_folder(equal_passes_are_of_the_same_film),
        cmocka_unit_test_setup_teardown(eyes_see_less_error_and_less_change_after_more_passes,
                                        lf_test_folder_setup, lf_test_folder_teardown),
        lf_test_in_folder(what_is_shown_is_nearer_after_the_same_time),
        lf_test_in_folder(a_curve_falls_and_says_where_the_time_goes),
        lf_test_in_folder(more_views_have_less_error_at_equal_paths),
        lf_test_in_folder(a_table_says_what_is_met),
        cmocka_unit_test_setup_teardown(the_papers_estimators_stand_beside_ours,
                                        lf_test_folder_setup, lf_test_folder_teardown),
        lf_test_in_folder(kernels_are_timed_and_must_agree),
        lf_test_in_folder(suffixes_in_lanes_are_timed_and_must_agree),
        lf_test_in_folder(what_is_between_views_and_panel_is_timed),
        lf_test_in_folder(what_is_shown_after_a_command_comes_closer),
        lf_test_in_folder(what_a_usb_display_is_sent_is_timed_and_ends_exact),
        lf_test_in_folder(what_is_left_out_is_timed_and_leaves_the_picture),
        lf_test_in_folder(a_frame_of_a_video_is_timed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
