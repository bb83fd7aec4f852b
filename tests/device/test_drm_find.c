/* Which output the drm device takes, and what it tells of outputs without taking them. */
#include "tests/device/drm_testing.h"

#include <errno.h>

#include "device/find/find.h"

static void names_of_outputs_are_understood(void **state)
{
    (void)state;
    lf_drm_name name;
    static const char *const good[] = {"DP-1",  "HDMI-A-1",   "Virtual-1",
                                       "eDP-1", "card0/DP-1", "card11/HDMI-A-12"};
    static const char *const bad[] = {"DP",
                                      "-1",
                                      "DP-",
                                      "DP-1x",
                                      "card0",
                                      "card0/",
                                      "card0/DP",
                                      "/dev/dri",
                                      "card/DP-1",
                                      "card999/DP-1",
                                      "card-1/DP-1",
                                      "card 1/DP-1",
                                      "D\nP-1",
                                      "card1/card2/DP-1",
                                      "1-1",
                                      "DP-12345678901",
                                      "a-very-long-name-of-a-connector-that-no-kernel-has-1"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        lf_assert_ok(lf_drm_name_parse(good[i], &name, NULL), NULL);
    assert_int_equal(name.card, 11);
    assert_string_equal(name.connector, "HDMI-A-12");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_status status = lf_drm_name_parse(bad[i], &name, NULL);
        if (status != LF_E_ARG)
            fail_msg("\"%s\" is taken", bad[i]);
    }
    lf_assert_ok(lf_drm_name_parse("", &name, NULL), NULL);
    assert_int_equal(name.card, -1);
    assert_string_equal(name.connector, "");
}

static void native_mode_is_the_preferred_one_that_can_be(void **state)
{
    (void)state;
    lf_kms_connector c = {.n_modes = 0};
    assert_null(lf_drm_native_mode(&c));
    c.modes[c.n_modes++] = lf_fake_mode(0, 0, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = lf_fake_mode(65535, 65535, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = lf_fake_mode(16385, 1, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] =
        lf_fake_mode(1920, 1080, DRM_MODE_TYPE_PREFERRED, DRM_MODE_FLAG_INTERLACE);
    c.modes[c.n_modes++] = lf_fake_mode(640, 480, DRM_MODE_TYPE_PREFERRED, DRM_MODE_FLAG_DBLSCAN);
    assert_null(lf_drm_native_mode(&c));
    c.modes[c.n_modes++] = lf_fake_mode(800, 600, 0, 0);
    c.modes[c.n_modes++] = lf_fake_mode(1024, 768, 0, 0);
    c.modes[c.n_modes++] = lf_fake_mode(640, 480, 0, 0);
    assert_int_equal(lf_drm_native_mode(&c)->hdisplay, 1024);
    c.modes[c.n_modes++] = lf_fake_mode(320, 200, DRM_MODE_TYPE_PREFERRED, 0);
    c.modes[c.n_modes++] = lf_fake_mode(1600, 1200, DRM_MODE_TYPE_PREFERRED, 0);
    assert_int_equal(lf_drm_native_mode(&c)->hdisplay, 320);
    c.n_modes = INT_MAX;
    assert_int_equal(lf_drm_native_mode(&c)->hdisplay, 320);
}

static void looking_glass_is_found_by_its_edid(void **state)
{
    (void)state;
    lf_fake_plug_in(true);
    lf_device *device = drm_open();
    lf_device_info info = device_info_of(device);
    assert_string_equal(info.spec, "drm:card0/DP-1");
    assert_string_equal(info.model, "LKG-TEST");
    assert_string_equal(info.output, "card0/DP-1 64x48 at 60 Hz");
    assert_string_equal(info.problem, "");
    assert_int_equal(lf_fake.modes, 0); /* opening leaves the display as it is */
    lf_device_destroy(device);
    assert_int_equal(lf_fake.shown.fb, FAKE_OLD_FB);
    lf_fake_nothing_is_left();
}

static void what_is_not_there_is_told_with_what_is(void **state)
{
    (void)state;
    lf_fake_plug_in(true);
    drm_refuses("DP-2", LF_E_NODEV,
                "no monitor is connected to DP-2; found: HDMI-A-1 (DELL U2720Q), DP-1 (LKG-TEST)");
    drm_refuses("card1/DP-1", LF_E_NODEV, "DP-1");
    drm_refuses("DP-x", LF_E_ARG, "expected drm, drm:DP-1 or drm:card1/HDMI-A-1");
    drm_refuses("HDMI-A-1", LF_E_ARG,
                "the native mode has 1920x1080 pixels, but the calibration (given by the caller) "
                "is for 64x48");
    lf_fake.n_connectors = 1;
    drm_refuses("", LF_E_NODEV, "no Looking Glass");
    lf_fake.n_cards = 0;
    drm_refuses("", LF_E_NODEV, "found: nothing");
    lf_fake_plug_in(true);
    lf_fake.open_error = EACCES;
    drm_refuses("", LF_E_IO, "group video");
    lf_fake_plug_in(true);
    lf_fake.taken = true;
    drm_refuses("", LF_E_BUSY,
                "Xorg (process 12) uses /dev/dri/card0; on a desktop use --device window");
    lf_fake_plug_in(true);
    lf_fake.connectors[1].n_modes = 0;
    drm_refuses("", LF_E_FORMAT, "no usable mode");
    lf_fake_plug_in(true);
    lf_fake.connectors[0].crtc = FAKE_CRTC; /* the only one there is drives the other monitor */
    drm_refuses("", LF_E_BUSY, "cannot drive another display");
    lf_fake_plug_in(true);
}

static void calibration_is_found_by_what_the_monitor_is_called(void **state)
{
    (void)state;
    char *dir = lf_test_folder();
    lf_device *device = NULL;
    lf_error err = {0};
    lf_found found = {.source = LF_SOURCE_DRIVE,
                      .label = "LKG-TEST",
                      .calibration = device_lens(FAKE_WIDTH, FAKE_HEIGHT)};
    setenv("CACHE_DIRECTORY", dir, 1);
    lf_fake_plug_in(true);
    lf_assert_status(lf_drm_open(&lf_fake_calls, "", NULL, &device, &err), LF_E_NODEV, &err);
    lf_fake_nothing_is_left();
    strcpy(found.calibration.serial, "LKG-TEST");
    lf_cache_store(&found);
    lf_assert_ok(lf_drm_open(&lf_fake_calls, "", NULL, &device, &err), &err);
    assert_int_equal(device->ops->calibration(device)->screen_width_px, FAKE_WIDTH);
    assert_string_equal(device_info_of(device).serial, "LKG-TEST");
    assert_non_null(strstr(device_info_of(device).calibration_from, dir));
    lf_device_destroy(device);
    lf_fake_nothing_is_left();
    unsetenv("CACHE_DIRECTORY");
    lf_test_folder_remove(dir);
}

static void damaged_edids_make_no_panel(void **state)
{
    (void)state;
    static const int sizes[] = {0, 1, 100, 127, -5};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        lf_fake_plug_in(true);
        lf_fake.n_edid[1] = sizes[i];
        drm_refuses("", LF_E_NODEV, "no Looking Glass");
    }
    lf_fake_plug_in(true);
    lf_fake.edid[1][127] ^= 1;
    drm_refuses("", LF_E_NODEV, "DP-1");
    lf_device *device = NULL; /* named, it is shown on */
    lf_assert_ok(drm_try("DP-1", &device, NULL), NULL);
    lf_device_destroy(device);
    lf_fake_plug_in(true);
    lf_fake.n_connectors = LF_KMS_CONNECTORS;
    lf_fake.connectors[1].connected = false;
    drm_refuses("", LF_E_NODEV, "no Looking Glass");
}

static void probe_tells_panels_and_what_may_be_one(void **state)
{
    (void)state;
    lf_device_info out[4];
    lf_fake_plug_in(true);
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    assert_string_equal(out[0].spec, "drm:card0/DP-1");
    assert_string_equal(out[0].model, "LKG-TEST");
    assert_string_equal(out[0].output, "card0/DP-1 64x48");
    assert_int_equal(lf_fake.dropped, 1); /* opening had made it master */
    assert_int_equal(lf_fake.modes + lf_fake.flips + lf_fake.looks, 0);
    lf_fake.n_edid[0] = 0;
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 2);
    assert_string_equal(out[0].model, ""); /* "auto" leaves it alone */
    assert_non_null(strstr(out[0].problem, "no EDID"));
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 1), 1);
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 0), 0);
    lf_fake.connectors[0].known = lf_fake.connectors[0].connected = false;
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    assert_int_equal(lf_fake.looks, 1); /* nobody had looked at that one before */
    lf_fake_nothing_is_left();
}

static void probe_tells_where_the_calibration_will_come_from(void **state)
{
    (void)state;
    lf_device_info out[4];
    char *dir = lf_test_folder();
    lf_found found = {.source = LF_SOURCE_HID, .calibration = device_lens(FAKE_WIDTH, FAKE_HEIGHT)};
    snprintf(found.calibration.serial, sizeof found.calibration.serial, "LKG-TEST-1");
    setenv("CACHE_DIRECTORY", dir, 1);
    lf_fake_plug_in(true);
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    if (out[0].calibration_from[0] == 0) /* this machine has no panel of its own */
        assert_non_null(
            strstr(out[0].problem, "no calibration was found; connect the panel's USB cable"));
    lf_cache_store(&found);
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    assert_non_null(strstr(out[0].calibration_from, "cache, "));
    assert_string_equal(out[0].problem, "");
    lf_fake.connector[FAKE_CONNECTOR_ORIENTATION] = 2;
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    assert_non_null(strstr(out[0].problem, "Left Side Up"));
    assert_non_null(strstr(out[0].problem, "video=DP-1:panel_orientation=normal"));
    assert_int_equal(lf_fake.modes + lf_fake.flips, 0);
    unsetenv("CACHE_DIRECTORY");
    lf_test_folder_remove(dir);
    lf_fake_nothing_is_left();
}

static void probe_tells_who_uses_a_panel_and_what_is_wrong(void **state)
{
    (void)state;
    lf_device_info out[4];
    lf_fake_plug_in(true);
    lf_fake.taken = true;
    lf_fake.connectors[1].crtc = FAKE_CRTC;
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    assert_non_null(strstr(out[0].problem, "used by Xorg (process 12), which scales the image; set "
                                           "the mode from 1024x768 to the native 64x48"));
    assert_non_null(strstr(out[0].problem, "--device window"));
    assert_int_equal(lf_fake.dropped, 0);
    lf_fake.shown.mode = lf_fake_mode(FAKE_WIDTH, FAKE_HEIGHT, 0, 0);
    lf_drm_probe(&lf_fake_calls, out, 4);
    assert_non_null(strstr(out[0].problem, "rotates the image"));
    lf_fake.plane[FAKE_PLANE_ROTATION] = lf_fake.cursor[FAKE_PLANE_ROTATION] = DRM_MODE_ROTATE_0;
    lf_drm_probe(&lf_fake_calls, out, 4);
    assert_string_equal(out[0].problem,
                        "used by Xorg (process 12); on a desktop use --device window");
    lf_fake.open_error = EACCES;
    assert_int_equal(lf_drm_probe(&lf_fake_calls, out, 4), 1);
    assert_string_equal(out[0].model, "");
    assert_non_null(strstr(out[0].problem, "group video"));
    lf_fake_nothing_is_left();
}

static void machines_without_displays_are_probed(void **state)
{
    (void)state;
    lf_device_info out[32];
    assert_in_range(lf_drm_ops.probe(out, 32), 0, 32);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_outputs_are_understood),
        cmocka_unit_test(native_mode_is_the_preferred_one_that_can_be),
        cmocka_unit_test(looking_glass_is_found_by_its_edid),
        cmocka_unit_test(what_is_not_there_is_told_with_what_is),
        cmocka_unit_test(calibration_is_found_by_what_the_monitor_is_called),
        cmocka_unit_test(damaged_edids_make_no_panel),
        cmocka_unit_test(probe_tells_panels_and_what_may_be_one),
        cmocka_unit_test(probe_tells_where_the_calibration_will_come_from),
        cmocka_unit_test(probe_tells_who_uses_a_panel_and_what_is_wrong),
        cmocka_unit_test(machines_without_displays_are_probed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
