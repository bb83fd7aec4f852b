/* What quiltbench tells with its numbers: why there is none, CSV, what it cannot draw. */
#include "tests/daemon/quiltbench.h"

static char *text_of(const char *folder, const char *name)
{
    static char text[1 << 16];
    FILE *file = fopen(lf_test_path(folder, name), "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return text;
}

static void assert_says(const char *folder, const char *name, const char *words)
{
    if (!strstr(text_of(folder, name), words))
        fail_msg("no \"%s\" in \"%s\"", words, text_of(folder, name));
}

static void assert_silent(const char *folder, const char *name, const char *words)
{
    if (strstr(text_of(folder, name), words))
        fail_msg("\"%s\" in \"%s\"", words, text_of(folder, name));
}

static int count_lines(const char *text)
{
    int n = 0;
    for (; *text != '\0'; text++)
        n += *text == '\n';
    return n;
}

static void numbers_that_are_missing_have_a_reason(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d,
                               "curve fog.json --view-size 6x8 --time 0.02 --budgets 2 --seeds 2 "
                               "--reference-spp 64"),
                     0);
    assert_silent(d, "out", "nan");
    assert_says(d, "out", "- correlations: none of the 6 views are this far apart");
    assert_int_equal(bench_run(d,
                               "curve fog.json --view-size 6x8 --time 0.02 --budgets 1 --seeds 1 "
                               "--reference-spp 64"),
                     0);
    assert_silent(d, "out", "nan");
    assert_says(d, "out", "- intervals: need at least two seeds (--seeds)");
    assert_int_equal(bench_run(d, "views fog.json --view-size 6x8 --counts 1,2 --spp 1 --seeds 1 "
                                  "--reference-spp 64"),
                     0);
    assert_silent(d, "out", "nan");
    assert_says(d, "out", "both need at least two seeds, two numbers of views");
    assert_int_equal(rename(lf_test_path(d, "fog.json"), lf_test_path(d, "cloud.json")), 0);
    assert_int_equal(bench_run(d, "table . --scenes cloud --views 2 --view-size 6x8 --time 0.4 "
                                  "--seeds 1 --reference-spp 64"),
                     0);
    assert_silent(d, "out", "nan");
    assert_says(d, "out", "\n* -: a ratio needs errors above the error of the reference");
}

/* The row of a table in JSON of this integrator. */
static const json_t *row_of(const json_t *object, const char *integrator)
{
    const json_t *rows = json_object_get(object, "rows"), *row;
    size_t i;
    json_array_foreach(rows, i,
                       row) if (strcmp(json_string_value(json_object_get(row, "integrator")),
                                       integrator) == 0) return row;
    fail_msg("no row of %s", integrator);
    return NULL;
}

/* A thirtieth of a sample a view pixel: most have no N/W, and that is no fault of the estimator. */
static void a_ratio_of_too_few_samples_is_told(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(rename(lf_test_path(d, "fog.json"), lf_test_path(d, "cloud.json")), 0);
    assert_int_equal(bench_run(d, "papers . --scenes cloud-1 --views 16 --view-size 40x40 --time "
                                  "0.01 --reference-time 0.2 --seeds 2 --threads 1 --json p.json "
                                  "--markdown p.md --csv p.csv"),
                     0);
    json_t *p = bench_load(d, "p.json");
    const json_t *row = row_of(p, "mvpt2022");
    assert_true(bench_number(row, "native_spp") > 0 && bench_number(row, "native_spp") < 8);
    assert_true(bench_number(row, "pixels_without_ratio") > 0.001);
    assert_true(bench_number(row_of(p, "mismvpt"), "pixels_without_ratio") <= 0); /* N/n */
    assert_true(json_is_null(json_object_get(row, "z")));
    json_decref(p);
    assert_says(d, "out",
                "\n* Pixels without N/W: no sample with a positive weight has reached them");
    assert_says(d, "out", "\n* (-): z needs at least 4 seeds");
    assert_says(d, "p.md", "\n* (-): z needs at least 4 seeds");
    assert_true(strncmp(text_of(d, "p.csv"), "scene,kind,integrator,", 22) == 0);
    assert_says(d, "p.csv", "\ncloud-1,\"2021, bunny cloud, 1 bounce\",vpt,mwis,,1,1,1,");
}

static void a_curve_tells_of_too_few_samples(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d, "curve fog.json --views 16 --view-size 40x40 --time 0.01 "
                                  "--budgets 1 --seeds 1 --reference-spp 4 --threads 1 "
                                  "--contenders vpt:mwis,mvpt2022:mwis"),
                     0);
    assert_says(d, "out", "% of the view pixels of mvpt2022: no sample has reached them");
}

static void csv_has_a_line_a_run(void **state)
{
    const char *d = *state;
    bench_write_ball(d);
    assert_int_equal(bench_run(d,
                               "curve fog.json --view-size 6x8 --time 0.02 --budgets 2 --seeds 3 "
                               "--reference-spp 64 --csv -"),
                     0);
    const char *text = text_of(d, "out");
    assert_true(strncmp(text, "integrator,estimator,budget,run,rel_mse,", 40) == 0);
    assert_int_equal(count_lines(text), 1 + 2 * 2 * 3);
    assert_non_null(strstr(text, "\nvpt,mwis,0.02,1,"));
    assert_non_null(strstr(text, "\nmvpt,mwis,0.04,3,"));
    assert_int_equal(bench_run(d, "compare fog.json --view-size 6x8 --time 0.02 --seeds 2 "
                                  "--reference-spp 64 --csv c.csv"),
                     0);
    assert_int_equal(count_lines(text_of(d, "c.csv")), 1 + 2 * 2);
    assert_int_equal(bench_run(d, "views fog.json --view-size 6x8 --counts 1,2 --spp 1 --seeds 2 "
                                  "--reference-spp 8 --csv v.csv"),
                     0);
    assert_true(strncmp(text_of(d, "v.csv"), "views,base_paths,rel_mse_estimate,", 34) == 0);
    assert_int_equal(bench_run(d, "shown fog.json --view-size 6x8 --budgets 0.02 --seeds 2 "
                                  "--reference-spp 8 --csv s.csv"),
                     0);
    assert_int_equal(count_lines(text_of(d, "s.csv")), 1 + 2);
    assert_int_equal(bench_run(d, "curve fog.json --csv - --json -"), 2);
    assert_says(d, "err", "--csv: cannot write to standard output, because --json does");
    assert_int_equal(bench_run(d, "papers . --markdown -"), 2);
    assert_says(d, "err", "--markdown: the table is always printed to standard output");
}

/* Before the first run, which here is none. */
static void what_cannot_be_drawn_is_told_first(void **state)
{
    const char *d = *state;
    char *path = strdup(getenv("PATH"));
    assert_int_equal(setenv("PATH", d, 1), 0);
    assert_int_equal(bench_run(d, "curve missing.json --plot curve"), 1);
    assert_says(d, "err",
                "quiltbench: --plot: gnuplot is not in PATH, so only curve.gp "
                "and curve.dat are written; install it (Debian: gnuplot-nox)\nquiltbench: ");
    assert_int_equal(bench_run(d, "views missing.json --plot v"), 1);
    assert_says(d, "err", "--plot: gnuplot is not in PATH");
    assert_int_equal(bench_run(d, "papers missing --plot p"), 1);
    assert_says(d, "err", "--plot: gnuplot is not in PATH");
    lf_test_write(d, "gnuplot", "#!/bin/true\n");
    assert_int_equal(chmod(lf_test_path(d, "gnuplot"), 0700), 0);
    assert_int_equal(bench_run(d, "curve missing.json --plot curve"), 1);
    assert_silent(d, "err", "--plot");
    assert_int_equal(setenv("PATH", path, 1), 0);
    free(path);
}

/* As bench/textured does; a file that is missing elsewhere is the user's own. */
static void data_that_a_clone_lacks_is_told(void **state)
{
    static const char scene[] =
        "{ \"quiltd\": 1, \"meshes\": { \"m\": { \"file\": \"%s/none.glb\" } } }";
    static const char *const folders[] = {"../shared/data/meshes", "mine"};
    const char *d = *state;
    char text[256];
    for (int i = 0; i < 2; i++) {
        snprintf(text, sizeof text, scene, folders[i]);
        lf_test_write(d, "textured.json", text);
        assert_int_equal(bench_run(d, "shown textured.json"), 1);
        assert_says(d, "err", "none.glb: cannot open");
        if (i == 0)
            assert_says(d, "err", "quiltd does not ship this file");
        else
            assert_silent(d, "err", "quiltd does not ship this file");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(numbers_that_are_missing_have_a_reason,
                                        lf_test_folder_setup, lf_test_folder_teardown),
        lf_test_in_folder(a_ratio_of_too_few_samples_is_told),
        lf_test_in_folder(a_curve_tells_of_too_few_samples),
        lf_test_in_folder(csv_has_a_line_a_run),
        lf_test_in_folder(what_cannot_be_drawn_is_told_first),
        lf_test_in_folder(data_that_a_clone_lacks_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
