/* Prints of the shown image: warnings about their depth. */
#include "tests/daemon/live_panel.h"

/* The warnings of the answer to an export, which is then written. */
static json_t *export_warnings(live_client *c, json_t *params)
{
    json_t *answer = live_call(c, "export", params);
    const json_t *result = json_object_get(answer, "result");
    json_t *warnings = json_object_get(result, "warnings");
    assert_true(json_is_array(warnings));
    json_incref(warnings);
    assert_string_equal(live_job_end(c, json_integer_value(json_object_get(result, "job"))),
                        "done");
    json_decref(answer);
    return warnings;
}

static size_t count_export_warnings(live_client *c, json_t *params)
{
    json_t *warnings = export_warnings(c, params);
    const size_t n = json_array_size(warnings);
    json_decref(warnings);
    return n;
}

static json_t *print_params(const char *file, double lpi, int width, int height,
                            const char *orientation)
{
    return json_pack("{s:s, s:s, s:f, s:i, s:i, s:i, s:s}", "kind", "print", "file", file, "lpi",
                     lpi, "dpi", 300, "width", width, "height", height, "orientation", orientation);
}

/* Shift of the deepest point between neighbouring views of the shown image, in shares of their
 * width, times the number of views. */
static double shift_of_status(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL);
    const json_t *status = json_object_get(answer, "result"),
                 *depth = json_object_get(status, "depth_budget");
    const double shift = fmax(-json_number_value(json_object_get(depth, "nearest_step")),
                              json_number_value(json_object_get(depth, "farthest_step"))),
                 share = shift / json_number_value(json_object_get(status, "view_width")) *
                         json_number_value(json_object_get(status, "views"));
    json_decref(answer);
    return share;
}

static void a_print_that_is_too_deep_is_told(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *warnings = export_warnings(&c, print_params("deep.tif", 60, 60, 80, "vertical"));
    assert_int_equal(json_array_size(warnings), 1);
    const char *words = json_string_value(json_array_get(warnings, 0));
    assert_ptr_equal(strstr(words, "too deep for lenses: objects "), words);
    json_decref(warnings);
    /* four views of 5 dots each, 60 mm wide */
    json_t *manifest = json_load_file(lf_test_path(l.exports, "deep.json"), 0, NULL);
    words = json_string_value(json_array_get(json_object_get(manifest, "warnings"), 0));
    double told = 0;
    assert_int_equal(sscanf(words, "points shift by up to %lf lenses", &told), 1);
    lf_assert_close(told, shift_of_status(&c) / 4 * 60 * 60 / 25.4, 0.02, 0.01);
    json_decref(manifest);
    /* few lenses; views that change along y; no print */
    assert_int_equal(count_export_warnings(&c, print_params("few.tif", 5, 15, 20, "vertical")), 0);
    assert_int_equal(count_export_warnings(&c, print_params("row.tif", 60, 60, 80, "horizontal")),
                     0);
    json_t *chart =
        json_pack("{s:s, s:s, s:i, s:f, s:f, s:i, s:i, s:i}", "kind", "chart", "file", "c.tif",
                  "lpi", 30, "range", 0.2, "step", 0.1, "dpi", 300, "width", 60, "height", 40);
    assert_int_equal(count_export_warnings(&c, chart), 0);
    json_t *quilt = json_pack("{s:s, s:s}", "kind", "quilt", "file", "q.png");
    assert_int_equal(count_export_warnings(&c, quilt), 0);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_print_that_is_too_deep_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
