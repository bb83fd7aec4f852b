/* The panel as programs for Looking Glass know it. */
#include "tests/testing.h"

#include <jansson.h>

#include "daemon/web/panel_info.h"

static json_t *panel(const char *serial, int width, int height)
{
    return json_pack("{s:s, s:s, s:f, s:f, s:f, s:f, s:f, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:[]}",
                     "configVersion", "3.0", "serial", serial, "pitch", 52.5, "slope", -7.25,
                     "center", 0.5, "viewCone", 40.0, "DPI", 324.0, "screenW", width, "screenH",
                     height, "invView", 1, "flipImageX", 0, "flipImageY", 0, "flipSubp", 1,
                     "CellPatternMode", 2, "subpixelCells");
}

static json_t *info_of(json_t *calibration, bool present)
{
    json_t *device = json_pack("{s:b}", "present", present);
    json_t *info = lf_panel_info(calibration, device);
    json_decref(calibration);
    json_decref(device);
    return info;
}

static double at(const json_t *info, const char *object, const char *key)
{
    const json_t *value = json_object_get(json_object_get(info, object), key);
    value = json_is_object(value) ? json_object_get(value, "value") : value;
    assert_true(json_is_number(value));
    return json_number_value(value);
}

static const char *text(const json_t *info, const char *key)
{
    assert_true(json_is_string(json_object_get(info, key)));
    return json_string_value(json_object_get(info, key));
}

/* bridge.js reads the value of each, and throws all panels away if one lacks it. */
static void every_number_is_there_and_wrapped(void **state)
{
    (void)state;
    static const struct {
        const char *key;
        double value;
    } rows[] = {{"pitch", 52.5},      {"slope", -7.25},      {"center", 0.5},   {"viewCone", 40},
                {"DPI", 324},         {"screenW", 1536},     {"screenH", 2048}, {"invView", 1},
                {"flipSubp", 1},      {"flipImageX", 0},     {"flipImageY", 0}, {"fringe", 0},
                {"verticalAngle", 0}, {"CellPatternMode", 2}};
    json_t *info = info_of(panel("LKG-P01234", 1536, 2048), true);
    const json_t *calibration = json_object_get(info, "calibration");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_true(json_is_object(json_object_get(calibration, rows[i].key)));
        assert_true(at(info, "calibration", rows[i].key) == rows[i].value);
    }
    assert_string_equal(text(calibration, "serial"), "LKG-P01234");
    assert_string_equal(text(calibration, "configVersion"), "3.0");
    assert_null(json_object_get(calibration, "subpixelCells"));
    json_decref(info);
    json_t *bare = json_pack("{s:s, s:i, s:i}", "serial", "LKG-P1", "screenW", 8, "screenH", 4);
    info = info_of(bare, true);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        (void)at(info, "calibration", rows[i].key);
    json_decref(info);
}

static void cells_are_passed_on(void **state)
{
    (void)state;
    json_t *from = panel("LKG-J00332", 3840, 2160);
    json_array_append_new(json_object_get(from, "subpixelCells"),
                          json_pack("{s:f}", "ROffsetX", -0.31));
    json_t *info = info_of(from, true);
    const json_t *cells = json_object_get(json_object_get(info, "calibration"), "subpixelCells");
    assert_int_equal(json_array_size(cells), 1);
    assert_true(json_number_value(json_object_get(json_array_get(cells, 0), "ROffsetX")) == -0.31);
    json_decref(info);
}

static void the_model_follows_from_serial_or_size(void **state)
{
    (void)state;
    static const struct {
        const char *serial;
        int width, height;
        const char *version, *hwid;
        int columns, rows;
    } rows[] = {{"LKG-P01234", 1536, 2048, "portrait", "LKG-P01234", 8, 6},
                {"LKG-PORT-NOMINAL", 1536, 2048, "portrait", "LKG-PORT-NOMINAL", 8, 6},
                {"lkg-e00001", 1440, 2560, "go_p", "LKG-lkg-e00001", 11, 6},
                {"LKG-J00332", 3840, 2160, "16_gen3_l", "LKG-J00332", 7, 7},
                {"LKG-H00332", 2160, 3840, "16_gen3_p", "LKG-H00332", 11, 6},
                {"LKG-4K-1", 3840, 2160, "large", "LKG-4K-1", 5, 9},
                {"00297", 2560, 1600, "standard", "LKG-00297", 5, 9},
                {"", 4320, 7680, "32_gen3_p", "LKG-", 11, 6},
                {"LKG-Z", 1000, 500, "standard", "LKG-Z", 8, 6}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        json_t *info = info_of(panel(rows[i].serial, rows[i].width, rows[i].height), true);
        assert_string_equal(text(info, "hardwareVersion"), rows[i].version);
        assert_string_equal(text(info, "hwid"), rows[i].hwid);
        assert_string_equal(text(info, "state"), "ok");
        assert_true(at(info, "defaultQuilt", "tileX") == rows[i].columns);
        assert_true(at(info, "defaultQuilt", "tileY") == rows[i].rows);
        assert_true(at(info, "defaultQuilt", "quiltAspect") ==
                    (double)rows[i].width / rows[i].height);
        json_decref(info);
    }
}

static void the_quilt_of_the_panel_comes_first(void **state)
{
    (void)state;
    json_t *from = panel("LKG-P01234", 1536, 2048);
    json_object_set_new(
        from, "defaultQuilt",
        json_pack("{s:i, s:i, s:i, s:i}", "quiltX", 3000, "quiltY", 2000, "tileX", 10, "tileY", 5));
    json_t *info = info_of(from, true);
    assert_true(at(info, "defaultQuilt", "quiltX") == 3000);
    assert_true(at(info, "defaultQuilt", "quiltY") == 2000);
    assert_true(at(info, "defaultQuilt", "tileX") == 10);
    json_decref(info);
    info = info_of(panel("LKG-P01234", 1536, 2048), true);
    assert_true(at(info, "defaultQuilt", "quiltX") == 3360);
    json_decref(info);
}

static void without_a_panel_there_is_none(void **state)
{
    (void)state;
    json_t *device = json_pack("{s:b}", "present", true);
    assert_null(lf_panel_info(NULL, device));
    assert_null(info_of(panel("LKG-P1", 1536, 2048), false));
    assert_null(info_of(panel("LKG-P1", 0, 2048), true));
    json_decref(device);
    json_t *calibration = panel("LKG-P1", 1536, 2048);
    assert_null(lf_panel_info(calibration, NULL));
    json_decref(calibration);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_number_is_there_and_wrapped),
        cmocka_unit_test(cells_are_passed_on),
        cmocka_unit_test(the_model_follows_from_serial_or_size),
        cmocka_unit_test(the_quilt_of_the_panel_comes_first),
        cmocka_unit_test(without_a_panel_there_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
