/* Which calibration is a display's, and the cache. */
#include "tests/testing.h"

#include <sys/stat.h>

#include "device/find/find.h"

static char *folder; /* the cache's */

static int make_folder(void **state)
{
    (void)state;
    folder = lf_test_folder();
    setenv("CACHE_DIRECTORY", folder, 1);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    unsetenv("CACHE_DIRECTORY");
    lf_test_folder_remove(folder);
    return 0;
}

static lf_found place(lf_source source, const char *label, const char *serial, int width,
                      int height)
{
    lf_found f = {.source = source, .path = "/dev/place"};
    lf_calibration_portrait(&f.calibration);
    snprintf(f.label, sizeof f.label, "%s", label);
    memset(f.calibration.serial, 0, sizeof f.calibration.serial);
    snprintf(f.calibration.serial, sizeof f.calibration.serial, "%s", serial);
    f.calibration.screen_width_px = width;
    f.calibration.screen_height_px = height;
    return f;
}

static lf_found broken(lf_source source, const char *label, const char *problem)
{
    lf_found f = {.source = source, .path = "/dev/broken"};
    snprintf(f.label, sizeof f.label, "%s", label);
    snprintf(f.problem, sizeof f.problem, "%s", problem);
    return f;
}

static lf_edid display(const char *name, const char *serial, int width, int height)
{
    lf_edid d = {.width_px = width, .height_px = height};
    snprintf(d.name, sizeof d.name, "%s", name);
    snprintf(d.serial, sizeof d.serial, "%s", serial);
    return d;
}

/* The 8.9" panel: its own EEPROM, what was cached of it, and its display, named by its maker. */
static lf_found standard(const char *serial)
{
    return place(LF_SOURCE_HID, "HoloPlay", serial, 2560, 1600);
}

static lf_found cached_standard(const char *serial)
{
    return place(LF_SOURCE_CACHE, serial, serial, 2560, 1600);
}

static lf_edid standards_display(void)
{
    return display("LKG01Do12HjQE", "", 2560, 1600);
}

static void assert_match(const lf_found *found, int n, lf_edid d, int expected)
{
    lf_error err = {0};
    const lf_found *match = lf_find_match(found, n, &d, &err);
    if (!match)
        fail_msg("no match: %s", err.what);
    assert_int_equal(match - found, expected);
}

static void assert_none(const lf_found *found, int n, lf_edid d, lf_status status, const char *word)
{
    lf_error err = {0};
    assert_null(lf_find_match(found, n, &d, &err));
    lf_assert_status(err.status, status, &err);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

static void a_display_finds_its_panel_by_name_among_equals(void **state)
{
    (void)state;
    const lf_found found[] = {
        place(LF_SOURCE_DRIVE, "LKG-P00655", "LKG-PORT-", 1536, 2048),
        place(LF_SOURCE_DRIVE, "LKG-P00671", "LKG-PORT-02283", 1536, 2048),
        place(LF_SOURCE_DRIVE, "LKG-J00332", "LKG-J00332", 3840, 2160),
    };
    assert_match(found, 3, display("LKG-P00671", "", 1536, 2048), 1);
    assert_match(found, 3, display("LKG-P00655", "", 1536, 2048), 0);
    assert_match(found, 3, display("", "LKG-PORT-0228", 1536, 2048), 1);
    assert_match(found, 3, display("LKG-J00332", "", 0, 0), 2);
}

static void a_display_with_a_name_of_its_own_is_found_by_size(void **state)
{
    (void)state;
    const lf_found found[] = {
        standard("LKG-2K-01338"),
        place(LF_SOURCE_DRIVE, "LKG-P00655", "LKG-PORT-", 1536, 2048),
    };
    assert_match(found, 2, standards_display(), 0);
    assert_match(found, 2, display("LKG", "", 1536, 2048), 1);
    assert_match(found, 2, display("LKG-", "", 1536, 2048), 1);
    assert_none(found, 2, display("LKG01Do12HjQE", "", 2048, 1536), LF_E_NODEV, "none of the 2");
}

static void what_two_panels_fit_is_not_guessed(void **state)
{
    (void)state;
    const lf_found found[] = {
        standard("LKG-2K-1"),
        standard("LKG-2K-2"),
    };
    assert_none(found, 2, standards_display(), LF_E_NODEV, "2 calibrations fit this display");
    assert_none(found, 2, display("", "", 0, 0), LF_E_NODEV, "2 calibrations fit this display");
    assert_none(found, 2, display("LKG-2K-", "", 2560, 1600), LF_E_NODEV,
                "2 calibrations fit this display");
    assert_match(found, 1, display("", "", 0, 0), 0);
}

static void what_is_plugged_in_goes_before_the_cache(void **state)
{
    (void)state;
    const lf_found found[] = {
        standard("LKG-2K-1"),
        cached_standard("LKG-2K-2"),
        cached_standard("LKG-2K-3"),
    };
    assert_match(found, 3, standards_display(), 0);
    assert_match(found, 3, display("", "", 0, 0), 0);
    assert_match(found, 3, display("LKG-2K-3", "", 2560, 1600), 2);
    assert_none(found + 1, 2, standards_display(), LF_E_NODEV, "2 calibrations fit this display");
    assert_match(found + 1, 1, standards_display(), 0);
}

static void an_unreadable_panel_is_told_and_only_the_cache_stands_in(void **state)
{
    (void)state;
    const lf_found found[] = {
        broken(LF_SOURCE_DRIVE, "LKG-P00671", "is not mounted"),
        place(LF_SOURCE_DRIVE, "LKG-P00655", "LKG-PORT-", 1536, 2048),
        place(LF_SOURCE_CACHE, "LKG-PORT-02283", "LKG-PORT-02283", 1536, 2048),
    };
    assert_none(found, 2, display("LKG-P00671", "", 1536, 2048), LF_E_FORMAT, "is not mounted");
    assert_match(found, 3, display("LKG-P00671", "", 1536, 2048), 2);
    assert_match(found, 3, display("LKG-P00655", "", 1536, 2048), 1);
}

static void what_was_found_instead_is_told(void **state)
{
    (void)state;
    const lf_found found[] = {
        place(LF_SOURCE_DRIVE, "LKG-P00655", "LKG-PORT-", 1536, 2048),
        broken(LF_SOURCE_HID, "HoloPlay", "no permission: do this"),
    };
    assert_none(NULL, 0, standards_display(), LF_E_NODEV, "connect the panel's USB cable");
    assert_none(found, 2, standards_display(), LF_E_NODEV, "no permission: do this");
    assert_none(found, 1, standards_display(), LF_E_NODEV, "LKG-PORT-, 1536x2048");
}

static void what_is_plugged_in_later_denies_a_cached_calibration(void **state)
{
    (void)state;
    const lf_edid named = display("LKG-P1", "", 1536, 2048),
                  nameless = display("HDMI-A-1", "", 1536, 2048);
    lf_found found[] = {
        standard("LKG-2K-1"), /* another's: a smaller one */
        broken(LF_SOURCE_DRIVE, "LKG-P9", "damaged"),
        place(LF_SOURCE_DRIVE, "LKG-P1", "LKG-PORT-1", 1536, 2048),
        place(LF_SOURCE_DRIVE, "LKG-P2", "LKG-PORT-2", 1536, 2048),
    };
    const lf_calibration used = found[2].calibration;
    assert_false(lf_found_deny(found, 2, &named, &used));
    assert_false(lf_found_deny(found, 2, &nameless, &used));
    assert_false(lf_found_deny(found, 4, &named, &used)); /* it is there itself */
    found[2].calibration.pitch += 1e-6;
    assert_true(lf_found_deny(found, 4, &named, &used));
    assert_true(lf_found_deny(found, 3, &nameless, &used));
    assert_false(lf_found_deny(found, 4, &nameless, &used)); /* one of two: nobody knows which */
}

/* To open a panel anew that gets the same lens again would only interrupt the picture. */
static void a_cached_calibration_that_would_be_taken_again_is_not_denied(void **state)
{
    (void)state;
    const lf_edid one = standards_display(), desktops = display("Looking Glass", "", 2560, 1600);
    lf_found found[] = {
        standard("LKG-2K-2"),
        cached_standard("LKG-2K-1"),
    };
    const lf_calibration used = found[1].calibration;
    found[1].display = one;
    assert_match(found, 2, one, 1);
    assert_false(lf_found_deny(found, 2, &one, &used));
    /* found by its size alone, and now by that of what is plugged in */
    assert_true(lf_found_deny(found, 2, &desktops, &used));
    /* two of the same name: the serial number, which only the cache tells here, says which is which
     */
    snprintf(found[0].display.name, sizeof found[0].display.name, "%s", one.name);
    snprintf(found[0].display.serial, sizeof found[0].display.serial, "2");
    snprintf(found[1].display.serial, sizeof found[1].display.serial, "1");
    assert_false(lf_found_deny(found, 2, &one, &used));
    found[0].display.serial[0] = '1';
    assert_true(lf_found_deny(found, 2, &one, &used));
}

/* A calibration whose every field is its own. */
static lf_calibration full(const char *serial)
{
    lf_calibration c = {.config_version = "3.0",
                        .pitch = 44.75058319896644,
                        .slope = -6.874565686767793,
                        .center = 0.1 + 0.2,
                        .view_cone_deg = 1.0 / 3,
                        .dpi = 283,
                        .screen_width_px = 3840,
                        .screen_height_px = 2160,
                        .inv_view = 0,
                        .flip_image_x = 1,
                        .flip_subp = 1,
                        .cell_pattern_mode = 2,
                        .n_cells = LF_MAX_CELLS};
    snprintf(c.serial, sizeof c.serial, "%s", serial);
    for (int i = 0; i < LF_MAX_CELLS * 6; i++)
        c.cells[i / 6][i / 2 % 3][i % 2] = (float)i / 7 - 6;
    return c;
}

static void store(const lf_calibration *c)
{
    lf_found found = {.source = LF_SOURCE_HID, .label = "HoloPlay", .calibration = *c};
    lf_cache_store(&found);
}

static const lf_found *cached(const lf_found *found, int n, const char *serial)
{
    for (int i = 0; i < n; i++)
        if (strcmp(found[i].calibration.serial, serial) == 0)
            return &found[i];
    return NULL;
}

static void the_cache_gives_back_what_was_stored(void **state)
{
    (void)state;
    lf_calibration a = full("LKG-J00332"), b = full("LKG-K1");
    lf_found found[8];
    a.n_cells = 0;
    memset(a.cells, 0, sizeof a.cells);
    store(&a);
    store(&b);
    store(&b);
    int n = lf_cache_list(found, 8);
    assert_int_equal(n, 2);
    assert_memory_equal(&cached(found, n, "LKG-J00332")->calibration, &a, sizeof a);
    assert_memory_equal(&cached(found, n, "LKG-K1")->calibration, &b, sizeof b);
    assert_int_equal(found[0].source, LF_SOURCE_CACHE);
    assert_string_equal(found[0].label, found[0].calibration.serial);
    assert_int_equal(lf_cache_list(found, 1), 1);
    b.pitch += 1e-12;
    store(&b);
    n = lf_cache_list(found, 8);
    assert_int_equal(n, 2);
    assert_memory_equal(&cached(found, n, "LKG-K1")->calibration, &b, sizeof b);
}

static lf_found stored_for(const char *serial, const char *display_name)
{
    lf_found found = {.source = LF_SOURCE_HID, .label = "HoloPlay", .calibration = full(serial)};
    found.display = display(display_name, "", 0, 0);
    lf_cache_store(&found);
    return found;
}

static void the_cache_knows_which_display_a_calibration_was_found_for(void **state)
{
    (void)state;
    lf_found found[8];
    stored_for("LKG-2K-04409", "LKG01Do12HjQE");
    int n = lf_cache_list(found, 8);
    assert_int_equal(n, 1);
    assert_match(found, n, display("LKG01Do12HjQE", "", 0, 0), 0);
    assert_match(found, n, display("LKG01Do12HjQE 9", "", 0, 0), 0); /* as a desktop calls it */
    assert_match(found, n, display("Looking Glass F", "", 3840, 2160), 0);
    /* another panel of the same size, whose own calibration is not there yet */
    assert_none(found, n, display("LKG030nffpp24", "", 3840, 2160), LF_E_NODEV, "none of the 1");
    stored_for("LKG-2K-00001", "LKG030nffpp24");
    n = lf_cache_list(found, 8);
    assert_int_equal(n, 2);
    int second = strcmp(found[0].calibration.serial, "LKG-2K-00001") == 0 ? 0 : 1;
    assert_match(found, n, display("LKG030nffpp24", "", 3840, 2160), second);
    /* what it was found for last is what counts */
    stored_for("LKG-2K-00001", "LKG-OTHER");
    n = lf_cache_list(found, 8);
    assert_int_equal(n, 2);
    assert_none(found, n, display("LKG030nffpp24", "", 3840, 2160), LF_E_NODEV, "none of the 2");
    for (int i = 0; i < n; i++)
        assert_int_equal(unlink(found[i].path), 0);
}

static void a_serial_leads_nowhere_else(void **state)
{
    (void)state;
    static const char *const serials[] = {
        "../../../../tmp/owned", "/etc/passwd",     "..", ".", ".hidden", "a/b",
        "a\nb c\"'$(id)",        "\xc3\xa4\xc3\xa4"};
    lf_found found[16];
    int before = lf_cache_list(found, 16);
    for (size_t i = 0; i < sizeof serials / sizeof serials[0]; i++) {
        lf_calibration c = full(serials[i]);
        store(&c);
    }
    assert_int_equal(lf_cache_list(found, 16), before + 8);
    lf_calibration nameless = full("");
    store(&nameless);
    assert_int_equal(lf_cache_list(found, 16), before + 8);
    assert_int_not_equal(access("/tmp/owned.json", F_OK), 0);
}

static void panels_of_the_same_bare_serial_are_remembered_by_their_labels(void **state)
{
    (void)state;
    lf_found found[16], a = place(LF_SOURCE_DRIVE, "LKG-P00655", "LKG-PORT-", 1536, 2048);
    lf_found b = place(LF_SOURCE_DRIVE, "LKG-P00671", "LKG-PORT-", 1536, 2048);
    b.calibration.center = 0.25;
    lf_cache_store(&a);
    lf_cache_store(&b);
    int n = lf_cache_list(found, 16);
    lf_edid d = display("LKG-P00671", "", 1536, 2048);
    const lf_found *match = lf_find_match(found, n, &d, NULL);
    assert_non_null(match);
    assert_memory_equal(&match->calibration, &b.calibration, sizeof b.calibration);
    d = display("LKG-P00655", "", 1536, 2048);
    match = lf_find_match(found, n, &d, NULL);
    assert_non_null(match);
    assert_memory_equal(&match->calibration, &a.calibration, sizeof a.calibration);
}

static void damaged_and_foreign_files_in_the_cache_are_passed_over(void **state)
{
    (void)state;
    lf_found found[16];
    int before = lf_cache_list(found, 16);
    char panels[PATH_MAX];
    snprintf(panels, sizeof panels, "%s/panels", folder);
    lf_test_write(panels, "torn.json", "{\"pitch\":");
    lf_test_write(panels, "notes.txt", "x");
    lf_test_write(panels, ".json", "x");
    assert_int_equal(mkfifo(lf_test_path(panels, "fifo.json"), 0600), 0);
    assert_int_equal(mkdir(lf_test_path(panels, "folder.json"), 0700), 0);
    assert_int_equal(lf_cache_list(found, 16), before);
}

static void a_cache_that_cannot_be_is_no_error(void **state)
{
    (void)state;
    lf_calibration c = full("LKG-X1");
    lf_found found[4];
    const char *file = lf_test_write(folder, "file", "");
    setenv("CACHE_DIRECTORY", file, 1);
    store(&c);
    assert_int_equal(lf_cache_list(found, 4), 0);
    setenv("CACHE_DIRECTORY", lf_test_path(folder, "deeper/down"), 1);
    assert_int_equal(lf_cache_list(found, 4), 0);
    store(&c);
    assert_int_equal(lf_cache_list(found, 4), 1);
    setenv("CACHE_DIRECTORY", folder, 1);
}

/* What is plugged into the machine that runs this is not known; that looking is harmless is. */
static void looking_everywhere_comes_to_an_end(void **state)
{
    (void)state;
    lf_found found[8];
    assert_in_range(lf_find_all(found, 8), 0, 8);
    lf_calibration c;
    lf_origin origin = {0};
    lf_error err = {0};
    lf_edid d = display("LKG-NOBODY", "", 1, 1);
    lf_assert_status(lf_find_for_display(&d, &c, &origin, &err), LF_E_NODEV, &err);
    lf_calibration known = full("LKG-SOMEBODY-1");
    store(&known);
    d = display("LKG-SOMEBODY-", "", 1, 1);
    lf_assert_ok(lf_find_for_display(&d, &c, &origin, &err), &err);
    assert_memory_equal(&c, &known, sizeof c);
    assert_true(origin.cached);
    assert_int_equal(strncmp(origin.words, "cache, ", 7), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_display_finds_its_panel_by_name_among_equals),
        cmocka_unit_test(a_display_with_a_name_of_its_own_is_found_by_size),
        cmocka_unit_test(what_two_panels_fit_is_not_guessed),
        cmocka_unit_test(what_is_plugged_in_goes_before_the_cache),
        cmocka_unit_test(an_unreadable_panel_is_told_and_only_the_cache_stands_in),
        cmocka_unit_test(what_was_found_instead_is_told),
        cmocka_unit_test(what_is_plugged_in_later_denies_a_cached_calibration),
        cmocka_unit_test(a_cached_calibration_that_would_be_taken_again_is_not_denied),
        cmocka_unit_test(the_cache_knows_which_display_a_calibration_was_found_for),
        cmocka_unit_test(the_cache_gives_back_what_was_stored),
        cmocka_unit_test(a_serial_leads_nowhere_else),
        cmocka_unit_test(panels_of_the_same_bare_serial_are_remembered_by_their_labels),
        cmocka_unit_test(damaged_and_foreign_files_in_the_cache_are_passed_over),
        cmocka_unit_test(a_cache_that_cannot_be_is_no_error),
        cmocka_unit_test(looking_everywhere_comes_to_an_end),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
