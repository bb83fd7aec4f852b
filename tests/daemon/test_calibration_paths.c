/* From where a calibration is written down to the view that a subpixel shows: by a file, by the
 * drive of a later panel, and by the EEPROM of a first-generation one. The panels are those whose
 * views are known, and the real ones of the shared data. */
#include "tests/testing.h"

#include <sys/stat.h>

#include "base/alloc.h"
#include "base/file.h"
#include "device/find/drive.h"
#include "device/hid/hid.h"
#include "device/model/model.h"
#include "quilt/quilt.h"

#define VALUE(x) "{\"value\":" #x "}"
#define FIRST_KEYS(serial, pitch, slope, center)                                                   \
    "{\"configVersion\":\"3.0\",\"serial\":\"" serial                                              \
    "\",\"pitch\":" VALUE(pitch) ",\"slope\":" VALUE(slope) ",\"center\":" VALUE(center)
#define PANEL(serial, pitch, slope, center, dpi, width, height, more)                              \
    FIRST_KEYS(serial, pitch, slope, center)                                                       \
    ",\"DPI\":" VALUE(dpi) ",\"screenW\":" VALUE(width) ",\"screenH\":" VALUE(                     \
        height) ",\"invView\":" VALUE(1) more "}"
#define CELL(rx, ry, gx, gy, bx, by)                                                               \
    "{\"ROffsetX\":" #rx ",\"ROffsetY\":" #ry ",\"GOffsetX\":" #gx ",\"GOffsetY\":" #gy            \
    ",\"BOffsetX\":" #bx ",\"BOffsetY\":" #by "}"
#define CELLS(mode, a, b) ",\"CellPatternMode\":" VALUE(mode) ",\"subpixelCells\":[" a "," b "]"

/* looking-glass.md sections 2 and 8: what red, green and blue of three pixels (the lower left, 100
 * to the right and 200 up, the upper right) show of n views. */
static const struct known {
    const char *json;
    int n, view[3][3];
} known[] = {
    {PANEL("LKG-2K-04409", 47.56401443481445, -5.480000019073486, 0.374184787273407, 338, 2560,
           1600, ""),
     45,
     {{14, 12, 10}, {23, 21, 19}, {20, 18, 16}}},
    {PANEL("LKG-PORT-", 52.594383239746094, -7.21152925491333, 0.40277382731437683, 324, 1536, 2048,
           ""),
     48,
     {{16, 13, 10}, {34, 31, 29}, {7, 5, 2}}},
    {PANEL("LKG-E00001", 80.74475016919882, -6.6587766801719095, 0.47708486403293315, 491, 1440,
           2560, ""),
     66,
     {{26, 23, 19}, {1, 64, 60}, {58, 54, 51}}},
    {PANEL("LKG-H00001", 44.72, -7.45, 0, 283, 2160, 3840,
           CELLS(4, CELL(-0.25, -0.31, -0.25, 0.28, 0.25, 0),
                 CELL(0.25, -0.31, 0.25, 0.28, -0.25, 0))),
     66,
     {{63, 64, 58}, {33, 34, 28}, {30, 30, 35}}},
    {PANEL("LKG-J00001", 44.72, -6.9, 0.5, 283, 3840, 2160,
           CELLS(2, CELL(-0.31, 0.25, 0.28, 0.25, 0, -0.25),
                 CELL(-0.31, -0.25, 0.28, -0.25, 0, 0.25))),
     49,
     {{23, 19, 20}, {18, 14, 15}, {1, 46, 0}}},
};
enum { N_KNOWN = sizeof known / sizeof known[0] };

/* --------------------------------------------------------------------------------- the paths -- */

static lf_calibration by_file(const char *folder, const char *json)
{
    lf_calibration c;
    lf_error err = {0};
    lf_assert_ok(lf_calibration_load(lf_test_write(folder, "visual.json", json), &c, &err), &err);
    return c;
}

/* A volume of this label, mounted. */
static lf_calibration by_drive(const char *folder, const char *json)
{
    char mounts[PATH_MAX + 128], mountinfo[PATH_MAX];
    lf_found found[2];
    (void)mkdir(lf_test_path(folder, "LKG-P1"), 0700);
    (void)mkdir(lf_test_path(folder, "LKG-P1/LKG_calibration"), 0700);
    lf_test_write(folder, "LKG-P1/LKG_calibration/visual.json", json);
    snprintf(mounts, sizeof mounts, "310 30 8:17 / %s ro shared:172 - vfat /dev/nonexistent1 ro\n",
             lf_test_path(folder, "LKG-P1"));
    snprintf(mountinfo, sizeof mountinfo, "%s", lf_test_write(folder, "mountinfo", mounts));
    const lf_drive_places places = {mountinfo, "/nonexistent"};
    assert_int_equal(lf_drive_list(&places, found, 2), 1);
    assert_string_equal(found[0].problem, "");
    return found[0].calibration;
}

static int wire_send(void *model, const uint8_t *report, size_t n)
{
    return lf_model_hid_feature(model, report + 1, n - 1) < 0 ? -1 : (int)n;
}

static int wire_read(void *model, uint8_t *out, size_t max, int timeout_ms)
{
    (void)timeout_ms;
    int n = lf_model_hid_input(model, out, max);
    return n > 0 ? n : 0;
}

/* Nothing is waited for. */
static uint64_t wire_now(void *model)
{
    (void)model;
    return 0;
}

static lf_calibration by_hid(const char *folder, const char *json)
{
    uint8_t eeprom[LF_MODEL_EEPROM_MAX];
    const lf_model_hid_faults faults = {.split = true, .stale = 1};
    lf_model_hid *model = NULL;
    lf_calibration c;
    lf_error err = {0};
    (void)folder;
    size_t n = lf_model_hid_eeprom(json, strlen(json), eeprom, sizeof eeprom);
    lf_assert_ok(lf_model_hid_create(eeprom, n, &faults, &model), NULL);
    lf_hid_link link = {wire_send, wire_read, wire_now, NULL, model};
    lf_assert_ok(lf_hid_read_calibration(&link, &lf_hid_patient, "hid", &c, &err), &err);
    lf_model_hid_destroy(model);
    return c;
}

static lf_calibration (*const paths[])(const char *folder, const char *json) = {by_file, by_drive,
                                                                                by_hid};
static const char *const path_names[] = {"file", "drive", "hid"};
enum { N_PATHS = sizeof paths / sizeof paths[0] };

/* --------------------------------------------------------------------------------- the facts -- */

static int view_of(const lf_calibration *c, int n, int point, int channel)
{
    const int at[3][2] = {{0, 0}, {100, 200}, {c->screen_width_px - 1, c->screen_height_px - 1}};
    return lf_view_of_subpixel(c, n, LF_INVERT_AUTO, at[point][0], at[point][1], channel, NULL);
}

static int differing_views(const lf_calibration *c, const struct known *k)
{
    int n = 0;
    for (int i = 0; i < 9; i++)
        n += view_of(c, k->n, i / 3, i % 3) != k->view[i / 3][i % 3];
    return n;
}

static void known_views_are_shown_whichever_way_the_calibration_came(void **state)
{
    for (int i = 0; i < N_KNOWN; i++) {
        for (int p = 0; p < N_PATHS; p++) {
            lf_calibration c = paths[p](*state, known[i].json);
            if (differing_views(&c, &known[i]) != 0)
                fail_msg("panel %d by %s: %d of 9 subpixels show another view", i, path_names[p],
                         differing_views(&c, &known[i]));
            c.center += 0.25; /* another panel's */
            assert_int_equal(differing_views(&c, &known[i]), 9);
        }
    }
}

static void real_panels_show_the_same_views_whichever_way_the_calibration_came(void **state)
{
    static const char *const names[] = {"16in_gen3_LKG-J00332", "portrait_LKG-P00655",
                                        "portrait_LKG-PORT-05935", "standard_00297",
                                        "standard_8.9in_LKG-2K-01338"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char name[128], *json = NULL;
        size_t n = 0;
        lf_error err = {0};
        snprintf(name, sizeof name, "calibration/%s.visual.json", names[i]);
        const char *path = lf_test_shared(name);
        if (!path)
            skip();
        lf_assert_ok(lf_file_read(path, NULL, LF_CALIBRATION_MAX_BYTES, &json, &n, &err), &err);
        lf_calibration first = paths[0](*state, json);
        for (int p = 1; p < N_PATHS; p++) {
            lf_calibration c = paths[p](*state, json);
            assert_memory_equal(&c, &first, sizeof c);
            for (int k = 0; k < 9; k++)
                assert_int_equal(view_of(&c, 45, k / 3, k % 3), view_of(&first, 45, k / 3, k % 3));
        }
        lf_free(json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_views_are_shown_whichever_way_the_calibration_came),
        cmocka_unit_test(real_panels_show_the_same_views_whichever_way_the_calibration_came),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
