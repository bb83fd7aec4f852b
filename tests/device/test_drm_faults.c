/* The drm device when a step of opening or showing fails, and when its monitor, card or link goes.
 */
#include "tests/device/drm_testing.h"

#include <errno.h>

static void impossible_memory_is_refused(void **state)
{
    (void)state;
    static const struct {
        uint32_t pitch;
        uint64_t size;
    } bad[] = {{FAKE_WIDTH * 4 - 4, FAKE_PITCH * FAKE_HEIGHT},
               {0, FAKE_PITCH * FAKE_HEIGHT},
               {UINT32_MAX, UINT64_MAX},
               {FAKE_PITCH + 1, FAKE_PITCH * FAKE_HEIGHT * 2},
               {FAKE_PITCH, FAKE_PITCH * FAKE_HEIGHT - 1},
               {FAKE_PITCH, UINT64_MAX - 64},
               {FAKE_PITCH, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_fake_plug_in(true);
        lf_fake.pitch = bad[i].pitch;
        lf_fake.size = bad[i].size;
        drm_refuses("", LF_E_FORMAT, "wrong buffer");
    }
}

static void every_step_of_opening_may_fail(void **state)
{
    (void)state;
    for (int legacy = 0; legacy < 2; legacy++) {
        int n = 1;
        for (;; n++) {
            lf_fake_plug_in(legacy == 0);
            lf_fake.fail_call = n;
            lf_device *device = NULL;
            lf_error err = {0};
            lf_status status = drm_try("", &device, &err);
            if (status == LF_OK) {
                lf_device_destroy(device);
            } else {
                assert_null(device);
                assert_true(err.what[0] != 0);
            }
            lf_fake_nothing_is_left();
            if (lf_fake.calls < n)
                break;
        }
        assert_in_range(n, 10, 40);
    }
}

static void failed_picture_is_told_once_and_the_next_sets_the_mode(void **state)
{
    (void)state;
    for (int at = 1; at < 4; at++) {
        lf_fake_plug_in(true);
        lf_fake.fail_show = at;
        lf_fake.fail_with = EACCES;
        lf_device *device = drm_open();
        lf_image8 frame = drm_frame();
        for (int i = 1; i < at; i++)
            assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_RETRY);
        assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
        assert_non_null(strstr(device_info_of(device).problem,
                               "DP-1 does not accept images: Permission denied"));
        int modes = lf_fake.modes;
        drm_scribble(&frame, &drm_whole, 9);
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
        assert_int_equal(lf_fake.modes, modes + 1);
        assert_true(lf_fake_shows(&frame));
        assert_string_equal(device_info_of(device).problem, "");
        assert_int_equal(device_counters_of(device).errors, 1);
        drm_end(device, &frame);
    }
}

static void flip_without_an_end_is_given_up(void **state)
{
    (void)state;
    lf_fake_plug_in(true);
    lf_device *device = drm_open();
    lf_image8 frame = drm_frame();
    assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    lf_fake.silent = true;
    lf_assert_ok(device->ops->push(device, &frame, &drm_whole, 1, 2), NULL);
    lf_assert_status(device->ops->push(device, &frame, &drm_whole, 1, 3), LF_E_STATE, NULL);
    lf_assert_status(device->ops->flush(device, 10), LF_E_TIMEOUT, NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_RETRY);
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.silent = false;
    pthread_mutex_unlock(&lf_fake.lock);
    assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    assert_int_equal(lf_fake.modes, 2);
    lf_assert_ok(device->ops->push(device, &frame, &drm_whole, 1, 5), NULL);
    lf_device_destroy(device); /* in the middle of a push */
    lf_image8_finish(&frame);
    assert_int_equal(lf_fake.shown.fb, FAKE_OLD_FB);
    lf_fake_nothing_is_left();
}

static void stays_gone(lf_device *device, const lf_image8 *frame)
{
    assert_int_equal(device_outcome(device), LF_DEVICE_GONE);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_GONE);
    lf_assert_status(device->ops->push(device, frame, &drm_whole, 1, 9), LF_E_NODEV, NULL);
    lf_assert_status(device->ops->flush(device, 10), LF_E_NODEV, NULL);
    lf_device_destroy(device);
    lf_fake_nothing_is_left();
}

static void set_connected(bool connected)
{
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.connectors[1].connected = connected;
    pthread_mutex_unlock(&lf_fake.lock);
}

static void unplugged_monitor_is_told(void **state)
{
    (void)state;
    lf_image8 frame = drm_frame();
    lf_fake_plug_in(true);
    lf_device *device = drm_open();
    assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    lf_fake_announce(); /* of another display */
    assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    set_connected(false);
    lf_fake_announce();
    stays_gone(device, &frame);
    drm_refuses("", LF_E_NODEV, "no Looking Glass");
    lf_fake_plug_in(true);
    lf_fake.no_watch = true; /* nothing is announced: asked for now and then */
    device = drm_open();
    set_connected(false);
    stays_gone(device, &frame);
    lf_image8_finish(&frame);
}

static void unplugged_card_is_told(void **state)
{
    (void)state;
    lf_image8 frame = drm_frame();
    lf_fake_plug_in(false);
    lf_fake.fail_show = 2;
    lf_fake.fail_with = ENODEV;
    lf_device *device = drm_open();
    assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    lf_assert_ok(device->ops->push(device, &frame, &drm_whole, 1, 2), NULL);
    stays_gone(device, &frame);
    lf_fake_plug_in(true);
    device = drm_open();
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.connectors[1].n_modes = -1;
    pthread_mutex_unlock(&lf_fake.lock);
    lf_fake_announce();
    stays_gone(device, &frame);
    lf_image8_finish(&frame);
}

/* Another monitor, or one that does not say what it is (NULL). */
static void swap_monitor(const char *name)
{
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.n_edid[1] = 0;
    if (name)
        lf_fake_set_edid(1, name);
    pthread_mutex_unlock(&lf_fake.lock);
}

static void swapped_monitor_is_told(void **state)
{
    (void)state;
    lf_image8 frame = drm_frame();
    lf_fake_plug_in(true);
    lf_device *device = drm_open();
    for (int whole_edid = 0; whole_edid < 2; whole_edid++) {
        swap_monitor(whole_edid != 0 ? "LKG-TEST" : NULL);
        lf_fake_announce();
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
    }
    swap_monitor("LKG-OTHER");
    lf_fake_announce();
    stays_gone(device, &frame);
    lf_fake_plug_in(true);
    lf_fake.no_watch = true;
    device = drm_open();
    swap_monitor("LKG-OTHER");
    stays_gone(device, &frame);
    lf_fake_plug_in(true);
    lf_fake.n_edid[1] = 0; /* opened by its output's name, and then it says that it is another */
    lf_assert_ok(drm_try("DP-1", &device, NULL), NULL);
    swap_monitor("DELL U2720Q");
    lf_fake_announce();
    stays_gone(device, &frame);
    lf_image8_finish(&frame);
}

static void break_link(void)
{
    pthread_mutex_lock(&lf_fake.lock);
    lf_fake.connector[FAKE_CONNECTOR_LINK] = DRM_MODE_LINK_STATUS_BAD;
    pthread_mutex_unlock(&lf_fake.lock);
    lf_fake_announce();
}

static bool link_comes_back(void)
{
    bool good = false;
    for (int i = 0; i < DEVICE_WAIT_MS / 10 && !good; i++) {
        usleep(10000);
        pthread_mutex_lock(&lf_fake.lock);
        good = lf_fake.modes == 2 &&
               lf_fake.connector[FAKE_CONNECTOR_LINK] == DRM_MODE_LINK_STATUS_GOOD;
        pthread_mutex_unlock(&lf_fake.lock);
    }
    return good;
}

static void link_that_fails_is_set_up_again(void **state)
{
    (void)state;
    for (int refusing = 0; refusing < 2; refusing++) {
        lf_fake_plug_in(true);
        lf_fake.wishes_refused = refusing != 0;
        lf_device *device = drm_open();
        lf_image8 frame = drm_frame();
        drm_scribble(&frame, &drm_whole, 3);
        assert_int_equal(device_push(device, &frame, &drm_whole, 1), LF_DEVICE_READY);
        break_link();
        assert_true(link_comes_back());
        assert_true(lf_fake_shows(&frame));
        drm_end(device, &frame);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impossible_memory_is_refused),
        cmocka_unit_test(every_step_of_opening_may_fail),
        cmocka_unit_test(failed_picture_is_told_once_and_the_next_sets_the_mode),
        cmocka_unit_test(flip_without_an_end_is_given_up),
        cmocka_unit_test(unplugged_monitor_is_told),
        cmocka_unit_test(unplugged_card_is_told),
        cmocka_unit_test(swapped_monitor_is_told),
        cmocka_unit_test(link_that_fails_is_set_up_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
