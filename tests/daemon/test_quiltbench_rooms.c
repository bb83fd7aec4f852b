/* Rows of quiltbench table whose scenes no other test renders: rooms, caustics, fog, a fire. */
#include "tests/daemon/quiltbench.h"

static void each_row_is_measured(void **state)
{
    static const char *const names[] = {"room-shade",       "room-window", "fog-post",
                                        "textured-sky",     "glass-sun",   "mirror-sun",
                                        "rough-mirror-sun", "fire"};
    enum { n_names = sizeof names / sizeof names[0] };
    const char *d = *state;
    char list[256] = "", line[PATH_MAX + 512], scenes[PATH_MAX];
    for (int i = 0; i < n_names; i++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i > 0 ? "," : "",
                 names[i]);
    snprintf(scenes, sizeof scenes, "%s", lf_test_built("../scenes"));
    if (access(scenes, R_OK) != 0)
        snprintf(scenes, sizeof scenes, "%s", lf_test_built("scenes"));
    snprintf(line, sizeof line,
             "table %s --scenes %s --views 2 --view-size 6x8 --time 0.1 --seeds 1 --json t.json",
             scenes, list);
    assert_int_equal(bench_run(d, line), 0);
    json_t *t = bench_load(d, "t.json");
    const json_t *rows = json_object_get(t, "rows");
    assert_int_equal(json_array_size(rows), n_names);
    for (int i = 0; i < n_names; i++) {
        const json_t *row = json_array_get(rows, (size_t)i);
        assert_string_equal(json_string_value(json_object_get(row, "scene")), names[i]);
        assert_true(bench_number(json_object_get(row, "ours"), "rel_mse_median") > 0);
        assert_true(bench_number(row, "reference_rel_mse") > 0);
    }
    json_decref(t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(each_row_is_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
