/* Prints of the shown image: warnings about their depth. */
#include "tests/daemon/live_panel.h"

#include "base/image_io.h"
#include "daemon/output/output.h"

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

/* A print of 30 x 20 mm by profiles, with more parameters. */
static json_t *profile_params(const char *file, const char *lens, const char *more)
{
    json_t *params = json_pack("{s:s, s:s, s:s, s:s, s:i, s:i}", "kind", "print", "file", file,
                               "lens", lens, "printer", "ink", "width", 30, "height", 20);
    json_object_update_new(params, json_loads(more, 0, NULL));
    return params;
}

/* How the job of an export ends; "refused" if the call fails. */
static const char *export_end(live_client *c, json_t *params)
{
    json_t *answer = live_call(c, "export", params);
    const json_t *job = json_object_get(json_object_get(answer, "result"), "job");
    const char *end = job ? live_job_end(c, json_integer_value(job)) : "refused";
    json_decref(answer);
    return end;
}

static double option_of(const live *l, const char *manifest, const char *key)
{
    json_t *json = json_load_file(lf_test_path(l->exports, manifest), 0, NULL);
    const double value = json_number_value(json_object_get(json_object_get(json, "options"), key));
    assert_non_null(json);
    json_decref(json);
    return value;
}

static void prints_take_profiles_by_name(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    char *config = lf_test_folder();
    static const char *const folders[] = {"quiltd", "quiltd/lenses", "quiltd/printers"};
    for (int i = 0; i < 3; i++)
        assert_int_equal(mkdir(lf_test_path(config, folders[i]), 0700), 0);
    (void)lf_test_write(config, "quiltd/lenses/acme.json",
                        "{\"quiltd_lens\": 1, \"pitch_lpi\": 30.1, \"thickness_mm\": 0.6, "
                        "\"index\": 1.56, \"calibrations\": [{\"printer\": \"ink\", "
                        "\"visual_lpi\": 30, \"distance_mm\": 400}]}");
    (void)lf_test_write(config, "quiltd/printers/ink.json",
                        "{\"quiltd_printer\": 1, \"dpi\": 360, \"dot_gain\": 0.1, "
                        "\"native_dpi\": [360]}");
    char outside[PATH_MAX];
    snprintf(outside, sizeof outside, "%s", lf_test_path(config, "quiltd/lenses/acme.json"));
    setenv("XDG_CONFIG_HOME", config, 1);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_string_equal(export_end(&c, profile_params("a.tif", "acme", "{}")), "done");
    assert_true(option_of(&l, "a.json", "lpi") == 30 && option_of(&l, "a.json", "dpi") == 360);
    assert_true(option_of(&l, "a.json", "dot_gain") == 0.1);
    assert_true(option_of(&l, "a.json", "distance") == 400);
    json_t *manifest = json_load_file(lf_test_path(l.exports, "a.json"), 0, NULL);
    assert_int_equal(
        json_array_size(json_object_get(json_object_get(manifest, "profiles"), "used")), 2);
    json_decref(manifest);
    /* quiltctl prints what the profiles gave, and their warnings; 400 dpi are not native */
    char command[3 * PATH_MAX], text[4096] = "";
    snprintf(
        command, sizeof command,
        "'%s' --socket '%s' export print '%s' lens=acme printer=ink dpi=400 width=30 height=20",
        lf_test_built("quiltctl"), l.socket, lf_test_path(config, "d.tif"));
    FILE *from = popen(command, "r"); /* NOLINT(cert-env33-c) */
    assert_non_null(from);
    assert_true(fread(text, 1, sizeof text - 1, from) > 0);
    assert_int_equal(pclose(from), 0);
    assert_non_null(strstr(text, "lens acme: 30.0000 lpi at 400 mm"));
    assert_non_null(strstr(text, "400 dpi is not a native resolution of ink"));
    /* what the call has wins */
    assert_string_equal(
        export_end(&c, profile_params("b.tif", "acme", "{\"lpi\": 25, \"dpi\": 300}")), "done");
    assert_true(option_of(&l, "b.json", "lpi") == 25 && option_of(&l, "b.json", "dpi") == 300);
    /* no such profile, a print that the profile makes impossible, a file that may not be read */
    assert_string_equal(export_end(&c, profile_params("c.tif", "acme-2", "{}")), "failed");
    assert_string_equal(export_end(&c, profile_params("c.tif", "acme", "{\"views\": 900}")),
                        "failed");
    assert_string_equal(export_end(&c, profile_params("c.tif", outside, "{}")), "refused");
    assert_int_not_equal(access(lf_test_path(l.exports, "c.tif"), F_OK), 0);
    /* without a lens the pitch is asked for */
    json_t *params = profile_params("c.tif", "acme", "{}");
    json_object_del(params, "lens");
    assert_string_equal(export_end(&c, params), "refused");
    live_close(&c);
    live_finish(&l);
    unsetenv("XDG_CONFIG_HOME");
    lf_test_folder_remove(config);
}

static void a_proof_is_a_column_of_what_eyes_see(void **state)
{
    (void)state;
    live l;
    live_client c;
    lf_image8 column;
    lf_error err;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *params;
    for (int round = 0; round < 2; round++) {
        const char *name = round == 0 ? "proof.png" : "page.png";
        params = print_params(name, 60, 30, 40, "vertical");
        json_object_set_new(params, "kind", json_string("proof"));
        if (round == 1) { /* one copy of a page that is far larger than a proof may be */
            json_object_set_new(params, "columns", json_integer(20));
            json_object_set_new(params, "rows", json_integer(20));
            json_object_set_new(params, "gutter", json_integer(100));
            json_object_set_new(params, "label", json_string("copy"));
        }
        assert_string_equal(export_end(&c, params), "done");
        lf_assert_ok(lf_image8_read(lf_test_path(l.exports, name), NULL, &column, &err), &err);
        assert_int_equal(column.width, 71); /* lenses on 30 mm */
        assert_int_equal(column.height, LF_OUTPUT_PROOF_EYES * 95);
        /* eyes see different images */
        assert_memory_not_equal(column.data + 47 * column.stride,
                                column.data + (12 * 95 + 47) * column.stride, 3 * 71);
        lf_image8_finish(&column);
    }
    params = print_params("large.png", 60, 1000, 1000, "vertical");
    json_object_set_new(params, "kind", json_string("proof"));
    json_object_set_new(params, "dpi", json_integer(600));
    assert_string_equal(export_end(&c, params), "failed");
    assert_int_not_equal(access(lf_test_path(l.exports, "large.png"), F_OK), 0);
    live_close(&c);
    live_finish(&l);
}

static void sheets_of_copies_have_labels_and_what_does_not_fit_is_refused(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *params = print_params("cards.tif", 10, 15, 20, "vertical");
    json_object_update_new(params, json_pack("{s:i, s:i, s:i, s:s}", "columns", 2, "rows", 3,
                                             "gutter", 4, "label", "Job 4711"));
    assert_string_equal(export_end(&c, json_deep_copy(params)), "done");
    json_t *manifest = json_load_file(lf_test_path(l.exports, "cards.json"), 0, NULL);
    const json_t *sheet = json_object_get(manifest, "sheet");
    assert_int_equal(json_array_size(json_object_get(sheet, "copies")), 6);
    assert_string_equal(json_string_value(json_object_get(sheet, "label")), "Job 4711");
    json_decref(manifest);
    json_object_set_new(params, "guard", json_integer(64));
    assert_string_equal(export_end(&c, json_deep_copy(params)), "refused");
    json_object_del(params, "guard");
    json_object_update_new(params, json_pack("{s:i, s:i}", "paper_width", 30, "paper_height", 90));
    assert_string_equal(export_end(&c, params), "refused");
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_print_that_is_too_deep_is_told),
        cmocka_unit_test(prints_take_profiles_by_name),
        cmocka_unit_test(a_proof_is_a_column_of_what_eyes_see),
        cmocka_unit_test(sheets_of_copies_have_labels_and_what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
