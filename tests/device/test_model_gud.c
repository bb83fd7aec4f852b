/* The simulated GUD display: what it takes, and that it refuses whatever the protocol does not
 * allow. */
#include "tests/device/gud_testing.h"

#include <errno.h>

#include "base/calibration.h"

enum { WIDTH = 40, HEIGHT = 30, PIXELS = WIDTH * HEIGHT };

static int set(lf_model_gud *gud, uint8_t request, uint8_t *data, size_t n)
{
    return lf_model_gud_control(gud, false, request, 0, data, n);
}

static int status_of(lf_model_gud *gud)
{
    uint8_t status = 99;
    assert_int_equal(lf_model_gud_control(gud, true, LF_GUD_GET_STATUS, 0, &status, 1), 1);
    return status;
}

static int set_byte(lf_model_gud *gud, uint8_t request, uint8_t value)
{
    return set(gud, request, &value, 1);
}

static int check(lf_model_gud *gud, uint8_t format)
{
    uint8_t modes[LF_GUD_MODE_BYTES], bytes[LF_GUD_STATE_MAX_BYTES];
    lf_gud_mode mode[LF_GUD_MAX_MODES];
    int n;
    assert_int_equal(
        lf_model_gud_control(gud, true, LF_GUD_GET_CONNECTOR_MODES, 0, modes, sizeof modes),
        LF_GUD_MODE_BYTES);
    lf_assert_ok(lf_gud_modes_read(modes, sizeof modes, mode, &n, NULL), NULL);
    lf_gud_state s = {.mode = mode[0],
                      .format = format,
                      .n_properties = 2,
                      .properties = {{LF_GUD_PROPERTY_BACKLIGHT, 50},
                                     {LF_GUD_PROPERTY_ROTATION, LF_GUD_ROTATE_0}}};
    return set(gud, LF_GUD_SET_STATE_CHECK, bytes, lf_gud_state_write(&s, bytes));
}

static void switch_on(lf_model_gud *gud)
{
    assert_true(check(gud, LF_GUD_RGB888) > 0);
    assert_int_equal(set_byte(gud, LF_GUD_SET_CONTROLLER_ENABLE, 1), 1);
    assert_int_equal(set(gud, LF_GUD_SET_STATE_COMMIT, NULL, 0), 0);
    assert_int_equal(set_byte(gud, LF_GUD_SET_DISPLAY_ENABLE, 1), 1);
    assert_true(lf_model_gud_lit(gud));
}

static lf_model_gud *lit_model(const lf_model_gud_options *options,
                               const lf_model_gud_faults *faults)
{
    lf_model_gud *gud = gud_model(options, faults);
    switch_on(gud);
    return gud;
}

static int announce(lf_model_gud *gud, lf_gud_buffer b)
{
    uint8_t bytes[LF_GUD_BUFFER_BYTES];
    lf_gud_buffer_write(&b, bytes);
    return set(gud, LF_GUD_SET_BUFFER, bytes, sizeof bytes);
}

static const lf_gud_buffer whole = {0, 0, WIDTH, HEIGHT, PIXELS * 3, 0, 0};

static void a_rectangle_shows_with_its_last_byte(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    lf_model_gud *gud = lit_model(&o, NULL);
    const uint8_t two[] = {3, 2, 1, 6, 5, 4};
    const uint8_t *at = lf_model_gud_pixels(gud) + (5 * WIDTH + 7) * 3;
    assert_int_equal(announce(gud, (lf_gud_buffer){7, 5, 1, 2, 6, 0, 0}), LF_GUD_BUFFER_BYTES);
    assert_int_equal(lf_model_gud_bulk(gud, two, 5), 5);
    assert_int_equal(at[0], 0);
    assert_int_equal(lf_model_gud_bulk(gud, two + 5, 1), 1);
    assert_memory_equal(at, ((uint8_t[]){1, 2, 3}), 3);
    assert_memory_equal(at + WIDTH * 3, ((uint8_t[]){4, 5, 6}), 3);
    assert_int_equal(gud_counters(gud).rects, 1);
    assert_int_equal(gud_counters(gud).bytes, 6);
    assert_int_equal(gud_counters(gud).refused, 0);
    lf_model_gud_destroy(gud);
}

static void wrong_announcements_are_refused(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.max_buffer_size = WIDTH * 3 * 4;
    lf_model_gud *gud = lit_model(&o, NULL);
    const lf_gud_buffer bad[] = {
        whole,                             /* larger than the buffer */
        {0, 0, 0, 1, 0, 0, 0},             /* empty */
        {0, 0, 1, 1, 4, 0, 0},             /* wrong length */
        {0, 0, 1, 1, 3, 0, 3},             /* not compressed, and yet */
        {0, 0, 10, 1, 30, 1, 20},          /* LZ4 was not offered */
        {WIDTH - 1, 0, 2, 1, 6, 0, 0},     /* beyond the right edge */
        {0, HEIGHT, 1, 1, 3, 0, 0},        /* below */
        {UINT32_MAX, 0, 2, 1, 6, 0, 0},    /* x + width overflows */
        {0, 0, 0x10000, 0x10000, 0, 0, 0}, /* width * height overflows */
        {0, 0, 0x80000001, 2, 6, 0, 0},    /* … to the right length */
    };
    const int n = sizeof bad / sizeof *bad;
    for (int i = 0; i < n; i++) {
        assert_int_equal(announce(gud, bad[i]), -EPIPE);
        assert_int_equal(status_of(gud), LF_GUD_STATUS_INVALID_PARAMETER);
    }
    assert_int_equal(gud_counters(gud).refused, n);
    assert_int_equal(announce(gud, (lf_gud_buffer){WIDTH - 1, HEIGHT - 1, 1, 1, 3, 0, 0}),
                     LF_GUD_BUFFER_BYTES);
    assert_int_equal(lf_model_gud_bulk(gud, (uint8_t[4]){0}, 4), -EPIPE); /* more than announced */
    /* nothing is announced any more */
    assert_int_equal(lf_model_gud_bulk(gud, (uint8_t[3]){0}, 3), -EPIPE);
    assert_int_equal(gud_counters(gud).rects, 0);
    lf_model_gud_destroy(gud);
}

static void requests_out_of_order_are_refused(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    lf_model_gud *gud = gud_model(&o, NULL);
    uint8_t data[64] = {0};
    assert_int_equal(announce(gud, whole), -EPIPE);
    assert_int_equal(set(gud, LF_GUD_SET_STATE_COMMIT, NULL, 0), -EPIPE);
    assert_int_equal(status_of(gud), LF_GUD_STATUS_PROTOCOL_ERROR);
    assert_int_equal(check(gud, LF_GUD_RGB565), -EPIPE); /* not listed */
    assert_int_equal(status_of(gud), LF_GUD_STATUS_INVALID_PARAMETER);
    assert_int_equal(set(gud, LF_GUD_SET_STATE_CHECK, data, 25), -EPIPE);
    assert_int_equal(set(gud, LF_GUD_SET_STATE_CHECK, data, 26), -EPIPE);
    assert_int_equal(set_byte(gud, LF_GUD_SET_CONTROLLER_ENABLE, 2), -EPIPE);
    assert_int_equal(set(gud, LF_GUD_SET_DISPLAY_ENABLE, data, 0), -EPIPE);
    assert_int_equal(set(gud, 0x65, data, 1), -EPIPE);
    assert_int_equal(status_of(gud), LF_GUD_STATUS_NOT_SUPPORTED);
    assert_int_equal(
        lf_model_gud_control(gud, true, LF_GUD_GET_CONNECTOR_TV_MODE_VALUES, 0, data, 64), -EPIPE);
    assert_int_equal(lf_model_gud_control(gud, true, LF_GUD_GET_CONNECTOR_STATUS, 1, data, 1),
                     -EPIPE);
    assert_int_equal(lf_model_gud_bulk(gud, data, 3), -EPIPE);
    assert_false(lf_model_gud_lit(gud));
    switch_on(gud);
    assert_int_equal(announce(gud, whole), LF_GUD_BUFFER_BYTES);
    assert_int_equal(set_byte(gud, LF_GUD_SET_CONTROLLER_ENABLE, 0), 1);
    assert_int_equal(announce(gud, whole), -EPIPE);
    lf_model_gud_destroy(gud);
}

static void a_display_asked_after_every_set_tells_there_what_was_wrong(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.status_on_set = true;
    lf_model_gud *gud = lit_model(&o, NULL);
    assert_int_equal(announce(gud, (lf_gud_buffer){0, 0, 1, 1, 4, 0, 0}), LF_GUD_BUFFER_BYTES);
    assert_int_equal(status_of(gud), LF_GUD_STATUS_INVALID_PARAMETER);
    assert_int_equal(lf_model_gud_bulk(gud, (uint8_t[3]){0}, 3), -EPIPE);
    assert_int_equal(announce(gud, (lf_gud_buffer){0, 0, 1, 1, 3, 0, 0}), LF_GUD_BUFFER_BYTES);
    assert_int_equal(status_of(gud), LF_GUD_STATUS_OK);
    lf_model_gud_destroy(gud);
}

static void damaged_lz4_never_shows(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.lz4 = true;
    lf_model_gud *gud = lit_model(&o, NULL);
    uint8_t bytes[64];
    uint64_t random = 3;
    for (int round = 0; round < 1000; round++) {
        uint32_t n = 1 + gud_random(&random) % 60;
        for (uint32_t i = 0; i < n; i++)
            bytes[i] = (uint8_t)gud_random(&random);
        assert_int_equal(announce(gud, (lf_gud_buffer){0, 0, WIDTH, HEIGHT, PIXELS * 3, 1, n}),
                         LF_GUD_BUFFER_BYTES);
        assert_int_equal(lf_model_gud_bulk(gud, bytes, n), -EPIPE);
    }
    assert_int_equal(gud_counters(gud).rects, 0);
    lf_model_gud_destroy(gud);
}

static void whole_frames_need_an_announcement_only_after_a_failure(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.full_update = true;
    static uint8_t frame[PIXELS * 3];
    lf_model_gud *gud = lit_model(&o, &(lf_model_gud_faults){.fail_every = 2});
    memset(frame, 5, sizeof frame);
    assert_int_equal(lf_model_gud_bulk(gud, frame, sizeof frame), sizeof frame);
    assert_int_equal(lf_model_gud_bulk(gud, frame, sizeof frame), -EPIPE);
    assert_int_equal(lf_model_gud_pixels(gud)[0], 250); /* half of it is something else now */
    assert_int_equal(lf_model_gud_pixels(gud)[PIXELS * 3 - 1], 5);
    assert_int_equal(lf_model_gud_bulk(gud, frame, sizeof frame), -EPIPE);
    assert_int_equal(announce(gud, (lf_gud_buffer){0, 0, 1, 1, 3, 0, 0}), -EPIPE);
    assert_int_equal(announce(gud, whole), LF_GUD_BUFFER_BYTES);
    assert_int_equal(lf_model_gud_bulk(gud, frame, sizeof frame), sizeof frame);
    assert_int_equal(lf_model_gud_pixels(gud)[0], 5);
    lf_model_gud_destroy(gud);
}

static void faults_strike_when_they_are_asked_for(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    const lf_gud_buffer one = {0, 0, 1, 1, 3, 0, 0};
    const uint8_t pixel[3] = {0};
    lf_model_gud *gud = lit_model(
        &o, &(lf_model_gud_faults){
                .stall_every = 2, .hang_every = 3, .unplug_after = 3, .bytes_per_s = 1000});
    assert_int_equal(announce(gud, one), LF_GUD_BUFFER_BYTES);
    assert_int_equal(announce(gud, one), -EPIPE);
    assert_int_equal(status_of(gud), LF_GUD_STATUS_BUSY);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(announce(gud, one), LF_GUD_BUFFER_BYTES);
        assert_int_equal(lf_model_gud_bulk(gud, pixel, 3), 3);
        assert_int_equal(announce(gud, one), -EPIPE);
    }
    assert_int_equal(announce(gud, one), LF_GUD_BUFFER_BYTES);
    assert_int_equal(lf_model_gud_bulk(gud, pixel, 3), -ETIMEDOUT);
    assert_int_equal(announce(gud, one), -EPIPE);
    assert_int_equal(announce(gud, one), LF_GUD_BUFFER_BYTES);
    assert_int_equal(lf_model_gud_bulk(gud, pixel, 3), 3);
    assert_int_equal(lf_model_gud_bulk(gud, pixel, 3), -ENODEV);
    assert_int_equal(announce(gud, one), -ENODEV);
    assert_int_equal(lf_model_gud_delay_ns(gud, 500), 500000000);
    lf_model_gud_destroy(gud);
    gud = gud_model(&o, NULL);
    assert_int_equal(lf_model_gud_delay_ns(gud, 500), 0);
    lf_model_gud_destroy(gud);
    lf_model_gud_destroy(NULL);
}

static void answers_are_cut_at_what_was_asked_for(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    lf_model_gud *gud = gud_model(&o, NULL);
    for (int request = 0; request < 256; request++)
        for (size_t n = 0; n < 40; n++) {
            uint8_t data[41];
            memset(data, 0xa5, sizeof data);
            int got = lf_model_gud_control(gud, true, (uint8_t)request, 0, data, n);
            assert_true(got == -EPIPE || (got >= 0 && (size_t)got <= n));
            assert_int_equal(data[n], 0xa5);
        }
    lf_model_gud_destroy(gud);
}

static void impossible_displays_are_not_made(void **state)
{
    (void)state;
    const uint8_t unknown[] = {LF_GUD_RGB888, 0x01};
    lf_model_gud *gud = NULL;
    lf_model_gud_options bad[6];
    for (int i = 0; i < 6; i++)
        bad[i] = gud_options(WIDTH, HEIGHT);
    bad[0].width = 0;
    bad[1].height = LF_MAX_SIDE + 1;
    bad[2].n_formats = 0;
    bad[3].n_formats = 9;
    bad[4].formats = unknown;
    bad[4].n_formats = 2;
    bad[5].n_edid = 128;
    for (int i = 0; i < 6; i++)
        lf_assert_status(lf_model_gud_create(&bad[i], NULL, &gud), LF_E_ARG, NULL);
    assert_null(gud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rectangle_shows_with_its_last_byte),
        cmocka_unit_test(wrong_announcements_are_refused),
        cmocka_unit_test(requests_out_of_order_are_refused),
        cmocka_unit_test(a_display_asked_after_every_set_tells_there_what_was_wrong),
        cmocka_unit_test(damaged_lz4_never_shows),
        cmocka_unit_test(whole_frames_need_an_announcement_only_after_a_failure),
        cmocka_unit_test(faults_strike_when_they_are_asked_for),
        cmocka_unit_test(answers_are_cut_at_what_was_asked_for),
        cmocka_unit_test(impossible_displays_are_not_made),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
