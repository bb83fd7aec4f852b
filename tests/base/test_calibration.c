#include "tests/testing.h"

#include <jansson.h>

#include "base/calibration.h"

#define GOOD                                                                                       \
    "\"pitch\":{\"value\":52.5},\"slope\":{\"value\":-7.25},\"center\":{\"value\":0.375},\"DPI\":" \
    "{\"value\":324.0},"                                                                           \
    "\"screenW\":{\"value\":1536.0},\"screenH\":{\"value\":2048}"

static lf_calibration parsed(const char *text)
{
    lf_calibration c = {0};
    lf_error err;
    lf_assert_ok(lf_calibration_parse(text, strlen(text), "visual.json", &c, &err), &err);
    return c;
}

/* Refused, with this pointer, this line and this word; the output is untouched. */
static void assert_refused(const char *text, size_t n, const char *pointer, int line,
                           const char *word)
{
    lf_calibration c, before;
    lf_error err = {0};
    memset(&c, 0x5a, sizeof c);
    before = c;
    lf_assert_status(lf_calibration_parse(text, n, "visual.json", &c, &err), LF_E_FORMAT, &err);
    assert_memory_equal(&c, &before, sizeof c);
    assert_string_equal(err.where, "visual.json");
    assert_string_equal(err.pointer, pointer);
    assert_int_equal(err.line, line);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

static void numbers_are_wrapped_or_plain(void **state)
{
    (void)state;
    lf_calibration a = parsed("{" GOOD ",\"viewCone\":{\"value\":40}}");
    lf_calibration b = parsed("{\"pitch\":52.5,\"slope\":-7.25,\"center\":0.375,\"DPI\":324,"
                              "\"screenW\":1536,\"screenH\":2048.0,\"viewCone\":40}");
    assert_memory_equal(&a, &b, sizeof a);
    lf_assert_close(a.pitch, 52.5, 0, 0);
    lf_assert_close(a.slope, -7.25, 0, 0);
    lf_assert_close(a.center, 0.375, 0, 0);
    lf_assert_close(a.dpi, 324, 0, 0);
    lf_assert_close(a.view_cone_deg, 40, 0, 0);
    assert_int_equal(a.screen_width_px, 1536);
    assert_int_equal(a.screen_height_px, 2048);
}

static void absent_keys_have_their_defaults(void **state)
{
    (void)state;
    lf_calibration c = parsed("{" GOOD "}");
    assert_string_equal(c.config_version, "");
    assert_string_equal(c.serial, "");
    assert_int_equal(c.inv_view, 1);
    assert_int_equal(c.flip_image_x, 0);
    assert_int_equal(c.flip_subp, 0);
    assert_int_equal(c.cell_pattern_mode, 0);
    assert_int_equal(c.n_cells, 0);
    lf_assert_close(c.view_cone_deg, 0, 0, 0);
}

static void flags_are_set_from_a_half_upwards(void **state)
{
    (void)state;
    lf_calibration c = parsed(
        "{" GOOD ",\"invView\":{\"value\":0.49},\"flipImageX\":{\"value\":0.5},\"flipSubp\":true}");
    assert_int_equal(c.inv_view, 0);
    assert_int_equal(c.flip_image_x, 1);
    assert_int_equal(c.flip_subp, 1);
}

static void cells_are_read_in_pixels(void **state)
{
    (void)state;
    lf_calibration c = parsed("{" GOOD ",\"cellPatternMode\":{\"value\":3},\"subpixelCells\":["
                              "{\"ROffsetX\":-0.25,\"ROffsetY\":1,\"GOffsetX\":2,\"GOffsetY\":3,"
                              "\"BOffsetX\":4,\"BOffsetY\":5},"
                              "{\"ROffsetX\":{\"value\":6},\"ROffsetY\":7,\"GOffsetX\":8,"
                              "\"GOffsetY\":9,\"BOffsetX\":10,\"BOffsetY\":11}]}");
    assert_int_equal(c.cell_pattern_mode, 3);
    assert_int_equal(c.n_cells, 2);
    const float expected[2][3][2] = {{{-0.25f, 1}, {2, 3}, {4, 5}}, {{6, 7}, {8, 9}, {10, 11}}};
    assert_memory_equal(c.cells, expected, sizeof expected);
}

/* Every required key in turn: absent, of a wrong type, and with values that no panel has. */
static void required_numbers_are_checked_one_by_one(void **state)
{
    (void)state;
    static const char *const keys[] = {"pitch", "slope", "center", "DPI", "screenW", "screenH"};
    static const char *const values[] = {"52", "-7", "0.5", "324", "1536", "2048"};
    static const char *const bad[] = {"{}",     "{\"value\":null}",         "\"5\"", "[5]", "1e300",
                                      "-1e300", "{\"value\":{\"value\":5}}"};
    for (size_t k = 0; k < 6; k++) {
        for (size_t b = 0; b <= sizeof bad / sizeof bad[0]; b++) {
            char text[512] = "{", pointer[32];
            for (size_t i = 0; i < 6; i++) {
                if (i == k && b == 0)
                    continue;
                snprintf(text + strlen(text), sizeof text - strlen(text), "\n\"%s\": %s,", keys[i],
                         i == k ? bad[b - 1] : values[i]);
            }
            strcat(text, "\n\"serial\":\"\"}");
            snprintf(pointer, sizeof pointer, "/%s", keys[k]);
            assert_refused(text, strlen(text), pointer, b == 0 ? 0 : (int)k + 2, "expected");
        }
    }
}

static void values_out_of_range_are_refused(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"\"pitch\":0", "/pitch"},
        {"\"pitch\":-52", "/pitch"},
        {"\"slope\":0", "/slope"},
        {"\"slope\":1e-9", "/slope"},
        {"\"DPI\":0", "/DPI"},
        {"\"screenW\":0", "/screenW"},
        {"\"screenW\":16385", "/screenW"},
        {"\"screenW\":15.5", "/screenW"},
        {"\"screenH\":-1", "/screenH"},
        {"\"screenH\":1e18", "/screenH"},
        {"\"center\":1e9", "/center"},
        {"\"viewCone\":180", "/viewCone"},
        {"\"viewCone\":-1", "/viewCone"},
        {"\"CellPatternMode\":5", "/CellPatternMode"},
        {"\"CellPatternMode\":-1", "/CellPatternMode"},
        {"\"invView\":\"1\"", "/invView"},
        {"\"serial\":7", "/serial"},
    };
    static const char *const all[] = {"\"pitch\":52", "\"slope\":-7",  "\"center\":0",
                                      "\"DPI\":324",  "\"screenW\":8", "\"screenH\":8"};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[512] = "{";
        size_t key = strcspn(cases[i][0], ":");
        for (size_t k = 0; k < 6; k++)
            if (strncmp(all[k], cases[i][0], key) != 0)
                snprintf(text + strlen(text), sizeof text - strlen(text), "%s,", all[k]);
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s}", cases[i][0]);
        assert_refused(text, strlen(text), cases[i][1], 1, "expected");
    }
}

static void hostile_texts_are_refused(void **state)
{
    (void)state;
    const char *const plain[] = {"",
                                 "[]x",
                                 "{\"pitch\":NaN}",
                                 "{\"pitch\":1e999}",
                                 "{\"pitch\":5",
                                 "{" GOOD ",\"pitch\":5}"};
    for (size_t i = 0; i < sizeof plain / sizeof plain[0]; i++)
        assert_refused(plain[i], strlen(plain[i]), "", 1, "");
    assert_refused("[1]", 3, "", 0, "object");
    static const char huge[] =
        "{\"pitch\":52,\"slope\":-7,\"center\":0,\"DPI\":324,\"screenW\":8192,\"screenH\":8193}";
    assert_refused(huge, strlen(huge), "/screenW", 1, "are too many for a panel");
    assert_refused("{\n\n\"pitch\": oops}", 17, "", 3, "not JSON");
    assert_refused("{" GOOD "} x", sizeof "{" GOOD "} x" - 1, "", 1,
                   "text follows the JSON object");
    static char deep[LF_CALIBRATION_MAX_BYTES];
    memset(deep, '[', sizeof deep);
    assert_refused(deep, sizeof deep, "", 1, "not JSON");
    assert_refused(deep, (size_t)LF_CALIBRATION_MAX_BYTES + 1, "", 0, "at most");
    char longest[512];
    snprintf(longest, sizeof longest, "{" GOOD ",\"serial\":\"%0100d\"}", 0);
    assert_refused(longest, strlen(longest), "/serial", 1, "short");
}

static void texts_hold_no_control_characters(void **state)
{
    (void)state;
    lf_calibration c = parsed(
        "{" GOOD ",\"serial\":\"LKG\\u001b[2J\\u007f\\u009b\\u00e4\",\"configVersion\":\"3\\n\"}");
    assert_string_equal(c.serial, "LKG?[2J???\xc3\xa4");
    assert_string_equal(c.config_version, "3?");
    assert_refused("{\n" GOOD ",\"serial\":\"a\\u0000b\"}",
                   strlen("{\n" GOOD ",\"serial\":\"a\\u0000b\"}"), "", 2, "not JSON");
}

static void too_many_or_malformed_cells_are_refused(void **state)
{
    (void)state;
    static char text[LF_CALIBRATION_MAX_BYTES];
    for (int n = 15; n <= 700; n += n < 17 ? 1 : 683) {
        strcpy(text, "{" GOOD ",\"subpixelCells\":[");
        for (int i = 0; i < n; i++)
            strcat(text, i ? ",{\"ROffsetX\":0,\"ROffsetY\":0,\"GOffsetX\":0,\"GOffsetY\":0,"
                             "\"BOffsetX\":0,\"BOffsetY\":0}"
                           : "{\"ROffsetX\":0,\"ROffsetY\":0,\"GOffsetX\":0,\"GOffsetY\":0,"
                             "\"BOffsetX\":0,\"BOffsetY\":0}");
        strcat(text, "]}");
        if (n <= LF_MAX_CELLS)
            assert_int_equal(parsed(text).n_cells, n);
        else
            assert_refused(text, strlen(text), "/subpixelCells", 1, "at most 16");
    }
    const char *const bad[][2] = {
        {"5", "/subpixelCells"},
        {"[5]", "/subpixelCells/0/ROffsetX"},
        {"[{\"ROffsetX\":0,\"ROffsetY\":99}]", "/subpixelCells/0/ROffsetY"},
        {"[{\"ROffsetX\":0,\"ROffsetY\":0,\"GOffsetX\":null}]", "/subpixelCells/0/GOffsetX"}};
    for (size_t i = 0; i < 4; i++) {
        snprintf(text, sizeof text, "{" GOOD ",\"subpixelCells\":%s}", bad[i][0]);
        assert_refused(text, strlen(text), bad[i][1], 1, "expected");
    }
}

/* Whatever becomes of the bytes: a calibration whose numbers are in range, or one clear line. */
static void damaged_texts_give_sane_numbers_or_an_error(void **state)
{
    (void)state;
    const char text[] = "{\"configVersion\":\"1.0\",\"serial\":\"LKG\",\"CellPatternMode\":1,"
                        "\"subpixelCells\":[]," GOOD "}";
    uint64_t seed = lf_test_seed();
    int n_ok = 0;
    for (int round = 0; round < 20000; round++) {
        char copy[sizeof text];
        memcpy(copy, text, sizeof text);
        size_t n = round % 5 ? sizeof text - 1 : (size_t)round % sizeof text;
        for (int k = 0; k < 1 + round % 3; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            copy[(seed >> 40) % (sizeof text - 1)] = "0123456789-.eE\"{}[]:,x"[(seed >> 33) % 22];
        }
        lf_calibration c;
        lf_error err = {0};
        if (lf_calibration_parse(copy, n, "fuzz", &c, &err) != LF_OK) {
            assert_true(err.what[0]);
            continue;
        }
        n_ok++;
        assert_true(c.pitch >= 1 && c.pitch <= 1000 && fabs(c.slope) >= 1e-3 &&
                    fabs(c.center) <= 1000 && c.dpi >= 1);
        assert_in_range(c.screen_width_px, 1, LF_MAX_SIDE);
        assert_in_range(c.screen_height_px, 1, LF_MAX_SIDE);
        assert_in_range(c.cell_pattern_mode, 0, 4);
    }
    assert_true(n_ok > 0);
}

static lf_calibration there_and_back(const lf_calibration *c)
{
    json_t *json = lf_calibration_json(c);
    char *text = json_dumps(json, JSON_REAL_PRECISION(17));
    lf_calibration back = parsed(text);
    free(text);
    json_decref(json);
    return back;
}

static void what_is_written_parses_as_the_same(void **state)
{
    (void)state;
    lf_calibration c = parsed("{\"configVersion\":\"3.0\",\"serial\":\"LKG-E01\",\"pitch\":52.1,"
                              "\"slope\":-7.3,\"center\":-0.1,"
                              "\"DPI\":323.9,\"screenW\":1440,\"screenH\":2560,\"viewCone\":53.7,"
                              "\"invView\":0,\"flipImageX\":1,"
                              "\"flipSubp\":1,\"CellPatternMode\":2,\"subpixelCells\":[{"
                              "\"ROffsetX\":0.1,\"ROffsetY\":-0.2,"
                              "\"GOffsetX\":0.3,\"GOffsetY\":0.4,\"BOffsetX\":0.5,\"BOffsetY\":16},"
                              "{\"ROffsetX\":1,\"ROffsetY\":2,"
                              "\"GOffsetX\":3,\"GOffsetY\":4,\"BOffsetX\":5,\"BOffsetY\":6}]}");
    lf_calibration back = there_and_back(&c);
    assert_memory_equal(&back, &c, sizeof c);
    c.cells[1][2][1] = 6.5f; /* all of it counts, to the last number */
    assert_memory_not_equal(&back, &c, sizeof c);
    lf_calibration_portrait(&c);
    back = there_and_back(&c);
    assert_memory_equal(&back, &c, sizeof c);
}

static void a_missing_or_huge_file_is_an_error(void **state)
{
    lf_calibration c;
    lf_error err;
    lf_assert_status(lf_calibration_load(lf_test_path(*state, "none.json"), &c, &err), LF_E_IO,
                     &err);
    const char *path = lf_test_write(*state, "visual.json", "{" GOOD "}");
    lf_assert_ok(lf_calibration_load(path, &c, &err), &err);
    assert_int_equal(truncate(path, LF_CALIBRATION_MAX_BYTES + 1), 0);
    lf_assert_status(lf_calibration_load(path, &c, &err), LF_E_FORMAT, &err);
}

static void the_nominal_portrait_is_one(void **state)
{
    (void)state;
    lf_calibration c;
    lf_calibration_portrait(&c);
    assert_int_equal(c.screen_width_px, 1536);
    assert_int_equal(c.screen_height_px, 2048);
    lf_assert_close(c.dpi, 324, 0, 0);
    lf_assert_close(c.view_cone_deg, 40, 0, 0);
    assert_int_equal(strncmp(c.serial, "LKG-P", 5), 0);
}

static void real_calibrations_are_read(void **state)
{
    (void)state;
    static const struct {
        const char *name, *version, *serial;
        double pitch, slope, center, dpi, cone;
        int width, height, inv_view, mode, n_cells;
    } files[] = {
        {"16in_gen3_LKG-J00332", "3.0", "LKG-J00332", 44.75058319896644, -6.874565686767793,
         0.16935753461833172, 283, 50, 3840, 2160, 1, 2, 2},
        {"portrait_LKG-P00655", "3.0", "LKG-PORT-", 52.58183670043945, -7.2032060623168945,
         0.901610791683197, 324, 40, 1536, 2048, 1, 0, 0},
        {"portrait_LKG-PORT-05935", "1.0", "LKG-PORT-05935", 52.56046553048362, -7.1423088016812,
         0.47345216539737284, 324, 40, 1536, 2048, 1, 0, 0},
        {"standard_00297", "1.0", "00297", 49.81804275512695, 5.044347763061523, 0.176902174949646,
         338, 40, 2560, 1600, 1, 0, 0},
        {"standard_8.9in_LKG-2K-01338", "1.0", "LKG-2K-01338", 49.91, 5.8, 0, 338, 40, 2560, 1600,
         0, 0, 0},
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char name[128];
        snprintf(name, sizeof name, "calibration/%s.visual.json", files[i].name);
        const char *path = lf_test_shared(name);
        if (!path)
            skip();
        lf_calibration c;
        lf_error err;
        lf_assert_ok(lf_calibration_load(path, &c, &err), &err);
        assert_string_equal(c.config_version, files[i].version);
        assert_string_equal(c.serial, files[i].serial);
        lf_assert_close(c.pitch, files[i].pitch, 0, 0);
        lf_assert_close(c.slope, files[i].slope, 0, 0);
        lf_assert_close(c.center, files[i].center, 0, 0);
        lf_assert_close(c.dpi, files[i].dpi, 0, 0);
        lf_assert_close(c.view_cone_deg, files[i].cone, 0, 0);
        assert_int_equal(c.screen_width_px, files[i].width);
        assert_int_equal(c.screen_height_px, files[i].height);
        assert_int_equal(c.inv_view, files[i].inv_view);
        assert_int_equal(c.cell_pattern_mode, files[i].mode);
        assert_int_equal(c.n_cells, files[i].n_cells);
    }
}

/* A panel with a default quilt, or what Bridge says of a device, in the vendor's older and newer
 * words. */
static void a_panel_may_say_its_own_quilt(void **state)
{
    (void)state;
#define PANEL                                                                                      \
    "\"pitch\":52,\"slope\":-7,\"center\":0.5,\"DPI\":324,\"screenW\":1536,\"screenH\":2048"
    static const struct {
        const char *text;
        int columns, rows, width, height;
    } cases[] = {
        {"{" PANEL "}", 0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":null}", 0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":3360,\"quiltY\":3361,\"tileX\":8,\"tileY\":6,"
         "\"quiltAspect\":0.75}}",
         8, 6, 3360, 3361},
        {"{\"calibration\":{" PANEL "},\"defaultQuilt\":{\"quiltWidth\":{\"value\":4096},"
         "\"quiltHeight\":4000,\"columns\":5,\"rows\":9,\"renderAspect\":0.75,\"tileCount\":45}}",
         5, 9, 4096, 4000},
        {"{\"calibration\":\"{\\\"pitch\\\":52,\\\"slope\\\":-7,\\\"center\\\":0.5,"
         "\\\"DPI\\\":324,\\\"screenW\\\":1536,\\\"screenH\\\":2048}\",\"defaultQuilt\":"
         "\"{\\\"quiltX\\\":960,\\\"quiltY\\\":960,\\\"tileX\\\":8,\\\"tileY\\\":6}\"}",
         8, 6, 960, 960},
        /* none that could be used: the panel is, all the same */
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":3360,\"quiltY\":3360,\"tileX\":0,\"tileY\":6}}",
         0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":4,\"quiltY\":3360,\"tileX\":8,\"tileY\":6}}", 0,
         0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":1e9,\"quiltY\":3360,\"tileX\":8,\"tileY\":6}}", 0,
         0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":4000,\"quiltY\":4000,\"tileX\":20,\"tileY\":20}}",
         0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":4000,\"quiltY\":4000,\"tileX\":8.9,\"tileY\":6}}",
         0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":{\"quiltX\":16384,\"quiltY\":16384,\"tileX\":1,\"tileY\":1}}",
         0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":\"8x6\"}", 0, 0, 0, 0},
        {"{" PANEL ",\"defaultQuilt\":[8,6]}", 0, 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_calibration c, again;
        lf_error err;
        print_message("case %zu\n", i);
        lf_assert_ok(lf_calibration_parse(cases[i].text, strlen(cases[i].text), "c", &c, &err),
                     &err);
        lf_assert_close(c.pitch, 52, 0, 0);
        assert_int_equal(c.quilt_columns, cases[i].columns);
        assert_int_equal(c.quilt_rows, cases[i].rows);
        assert_int_equal(c.quilt_width, cases[i].width);
        assert_int_equal(c.quilt_height, cases[i].height);
        json_t *json = lf_calibration_json(&c);
        char *text = json_dumps(json, 0);
        lf_assert_ok(lf_calibration_parse(text, strlen(text), "again", &again, &err), &err);
        assert_memory_equal(&c, &again, sizeof c);
        free(text);
        json_decref(json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_wrapped_or_plain),
        cmocka_unit_test(a_panel_may_say_its_own_quilt),
        cmocka_unit_test(absent_keys_have_their_defaults),
        cmocka_unit_test(flags_are_set_from_a_half_upwards),
        cmocka_unit_test(cells_are_read_in_pixels),
        cmocka_unit_test(required_numbers_are_checked_one_by_one),
        cmocka_unit_test(values_out_of_range_are_refused),
        cmocka_unit_test(hostile_texts_are_refused),
        cmocka_unit_test(texts_hold_no_control_characters),
        cmocka_unit_test(too_many_or_malformed_cells_are_refused),
        cmocka_unit_test(damaged_texts_give_sane_numbers_or_an_error),
        cmocka_unit_test(what_is_written_parses_as_the_same),
        cmocka_unit_test(a_missing_or_huge_file_is_an_error),
        cmocka_unit_test(the_nominal_portrait_is_one),
        cmocka_unit_test(real_calibrations_are_read),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
