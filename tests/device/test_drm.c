/* The drm device shows frames by three kinds of drivers. */
#include "tests/device/drm_testing.h"

static void rectangles_make_the_frame(bool atomic, bool no_page_flip)
{
    lf_fake_plug_in(atomic);
    lf_fake.no_page_flip = no_page_flip;
    lf_device *device = drm_open();
    lf_image8 frame = drm_frame();
    drm_scribble(&frame, &drm_whole, 1);
    assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    uint64_t pushes = 1, rects_pushed = 1;
    for (int i = 2; i < 200; i++) {
        lf_rect rects[80];
        /* none at all, and more than a driver is told one by one */
        int n = i % 50 == 0 ? 80 : i % 5;
        for (int k = 0; k < n; k++) {
            rects[k] =
                (lf_rect){(i * 7 + k * 3) % FAKE_WIDTH, (i * 5 + k * 11) % FAKE_HEIGHT, 0, 0};
            rects[k].width = 1 + (i + k) % (FAKE_WIDTH - rects[k].x);
            rects[k].height = 1 + (i * 3 + k) % (FAKE_HEIGHT - rects[k].y);
            drm_scribble(&frame, &rects[k], i);
        }
        assert_int_equal(device_push(device, &frame, rects, n), LF_DEVICE_READY);
        assert_true(lf_fake_shows(&frame));
        pushes += n > 0;
        rects_pushed += (uint64_t)n;
    }
    frame.data[0] ^= 1;
    assert_false(lf_fake_shows(&frame));
    assert_int_equal(device_counters_of(device).updates, rects_pushed);
    assert_int_equal(device_counters_of(device).errors, 0);
    assert_int_equal(lf_fake.modes, no_page_flip ? pushes : 1);
    assert_int_equal(lf_fake.flips, no_page_flip ? 0 : pushes - 1);
    lf_image8_finish(&frame);
    lf_device_destroy(device);
    assert_int_equal(lf_fake.shown.fb, FAKE_OLD_FB);
    assert_int_equal(lf_fake.shown.mode.hdisplay, 1024);
    lf_fake_nothing_is_left();
}

static void rectangles_make_the_frame_on_atomic_drivers(void **state)
{
    (void)state;
    rectangles_make_the_frame(true, false);
}

static void rectangles_make_the_frame_on_legacy_drivers(void **state)
{
    (void)state;
    rectangles_make_the_frame(false, false);
}

static void rectangles_make_the_frame_without_page_flips(void **state)
{
    (void)state;
    rectangles_make_the_frame(false, true);
    assert_true(lf_fake.dirts > 100);
}

static void pixels_are_shown_unchanged_and_the_rest_is_put_back(void **state)
{
    (void)state;
    for (int legacy = 0; legacy < 2; legacy++) {
        lf_fake_plug_in(legacy == 0);
        lf_device *device = drm_open();
        lf_image8 frame = drm_frame();
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
        assert_int_equal(lf_fake.connector[FAKE_CONNECTOR_RANGE], 1);
        assert_int_equal(lf_fake.connector[FAKE_CONNECTOR_DEPTH], 8);
        if (legacy == 0) {
            assert_int_equal(lf_fake.plane[FAKE_PLANE_ROTATION], DRM_MODE_ROTATE_0);
            assert_int_equal(lf_fake.plane[FAKE_PLANE_SRC_W], FAKE_WIDTH << 16);
            assert_int_equal(lf_fake.crtc[FAKE_CRTC_GAMMA], 0);
            assert_int_equal(lf_fake.crtc[FAKE_CRTC_ACTIVE], 1);
            assert_int_equal(lf_fake.cursor[FAKE_PLANE_FB], 0);
        }
        assert_string_equal(device_info_of(device).problem, "");
        lf_image8_finish(&frame);
        lf_device_destroy(device);
        assert_int_equal(lf_fake.connector[FAKE_CONNECTOR_RANGE], 0);
        assert_int_equal(lf_fake.connector[FAKE_CONNECTOR_DEPTH], 12);
        assert_int_equal(lf_fake.shown.fb, FAKE_OLD_FB);
        lf_fake_nothing_is_left();
    }
}

static void refused_wishes_are_told_and_the_rest_is_shown(void **state)
{
    (void)state;
    for (int legacy = 0; legacy < 2; legacy++) {
        lf_fake_plug_in(legacy == 0);
        lf_fake.wishes_refused = true;
        lf_device *device = drm_open();
        lf_image8 frame = drm_frame();
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
        assert_true(lf_fake_shows(&frame));
        assert_non_null(strstr(device_info_of(device).problem, "full colour range"));
        assert_int_equal(lf_fake.connector[FAKE_CONNECTOR_RANGE], 0);
        if (legacy == 0) { /* which refuses that one alone */
            assert_int_equal(lf_fake.connector[FAKE_CONNECTOR_DEPTH], 8);
            assert_int_equal(lf_fake.plane[FAKE_PLANE_ROTATION], DRM_MODE_ROTATE_0);
            assert_int_equal(lf_fake.crtc[FAKE_CRTC_GAMMA], 0);
        }
        drm_end(device, &frame);
    }
}

static void pushes_of_the_wrong_shape_are_refused(void **state)
{
    (void)state;
    lf_fake_plug_in(true);
    lf_device *device = drm_open();
    lf_image8 frame = drm_frame();
    device_refuses_bad_pushes(device, &frame);
    lf_assert_ok(device->ops->push(device, &frame, &drm_whole, 1, 1), NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    lf_image8_finish(&frame);
    lf_device_destroy(device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rectangles_make_the_frame_on_atomic_drivers),
        cmocka_unit_test(rectangles_make_the_frame_on_legacy_drivers),
        cmocka_unit_test(rectangles_make_the_frame_without_page_flips),
        cmocka_unit_test(pixels_are_shown_unchanged_and_the_rest_is_put_back),
        cmocka_unit_test(refused_wishes_are_told_and_the_rest_is_shown),
        cmocka_unit_test(pushes_of_the_wrong_shape_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
