/* The host of GUD displays against the simulated one: every lie, every fault, and that the display
 * shows the frame in the end. */
#include "tests/device/gud_testing.h"

#include "base/alloc.h"
#include "base/thread.h"
#include "device/model/usb_model.h"
#include "device/usb/gud_host.h"
#include "device/usb/gud_plan.h"

enum { WIDTH = 420, HEIGHT = 150, RECTS = 1000 };

typedef struct rig {
    lf_model_gud *gud;
    lf_usb_link *link;
    lf_gud_host *host;
    lf_image8 frame;
} rig;

static lf_status try_rig(const lf_model_gud_options *options, const lf_model_gud_faults *faults,
                         rig *out, lf_error *err)
{
    *out = (rig){.gud = gud_model(options, faults),
                 .frame = gud_frame(options->width, options->height)};
    out->link = lf_usb_model_open(out->gud);
    assert_non_null(out->link);
    lf_status status = lf_gud_host_open(out->link, &out->host, err);
    if (status == LF_OK)
        status = lf_gud_host_choose(out->host, options->width, options->height, err);
    if (status == LF_OK)
        status = lf_gud_host_start(out->host, err);
    return status;
}

static rig make_rig(const lf_model_gud_options *options, const lf_model_gud_faults *faults)
{
    rig r;
    lf_error err = {0};
    lf_assert_ok(try_rig(options, faults, &r, &err), &err);
    return r;
}

static void free_rig(rig *r)
{
    lf_gud_host_destroy(r->host);
    r->link->ops->close(r->link);
    lf_model_gud_destroy(r->gud);
    lf_image8_finish(&r->frame);
}

static lf_rect whole_of(const rig *r)
{
    return (lf_rect){0, 0, r->frame.width, r->frame.height};
}

static lf_gud_host_counters host_counters(const rig *r)
{
    lf_gud_host_counters counters;
    lf_gud_host_counters_get(r->host, &counters);
    return counters;
}

/* Pushes as the daemon does: after a failure the whole frame. Returns the failures. */
static int update(rig *r, const lf_rect *rects, int n)
{
    lf_error err = {0};
    const lf_rect whole = whole_of(r);
    lf_status status = lf_gud_host_update(r->host, &r->frame, rects, n, &err);
    int failures = 0;
    for (; status != LF_OK; failures++) {
        if (status != LF_E_IO || failures == 1000)
            lf_assert_ok(status, &err);
        status = lf_gud_host_update(r->host, &r->frame, &whole, 1, &err);
    }
    return failures;
}

/* -------------------------------------------------------------------------------- rectangles -- */

/* Paints and shows rectangles; the display must show the frame at the end, and in each rectangle
 * after each. Returns the failures. */
static int show_random_rects(rig *r, int count, lf_gud_format format, uint64_t seed)
{
    uint64_t random = seed;
    int failures = 0;
    gud_paint(&r->frame, whole_of(r), true, &random);
    const lf_rect whole = whole_of(r);
    failures += update(r, &whole, 1);
    for (int done = 0; done < count;) {
        lf_rect rects[5];
        int n = 1 + (int)(gud_random(&random) % 5);
        for (int i = 0; i < n; i++) {
            rects[i] = gud_random_rect(r->frame.width, r->frame.height, &random);
            gud_paint(&r->frame, rects[i], gud_random(&random) % 2 == 0, &random);
        }
        failures += update(r, rects, n);
        for (int i = 0; i < n; i++)
            assert_int_equal(gud_differences(r->gud, &r->frame, rects[i], format), 0);
        done += n;
    }
    assert_int_equal(gud_differences(r->gud, &r->frame, whole, format), 0);
    assert_int_equal(gud_counters(r->gud).refused, 0);
    assert_true(lf_model_gud_lit(r->gud));
    return failures;
}

static void a_thousand_rectangles_arrive_in_every_format_and_manner(void **state)
{
    (void)state;
    static const uint8_t formats[] = {LF_GUD_RGB888, LF_GUD_XRGB8888, LF_GUD_RGB565};
    for (int k = 0; k < 3 * 2 * 2 * 2; k++) {
        lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
        o.formats = &formats[k % 3];
        o.lz4 = k / 3 % 2 == 1;
        o.status_on_set = k / 6 % 2 == 1;
        o.max_buffer_size = k / 12 % 2 == 1 ? WIDTH * 4 + 100 : 0; /* a row of the widest format */
        rig r = make_rig(&o, NULL);
        assert_int_equal(lf_gud_host_format(r.host), formats[k % 3]);
        assert_int_equal(show_random_rects(&r, RECTS / 8, formats[k % 3], 11 + (uint64_t)k), 0);
        assert_int_equal(host_counters(&r).bytes, gud_counters(r.gud).bytes);
        assert_int_equal(host_counters(&r).compressed, gud_counters(r.gud).compressed_rects);
        if (o.lz4) {
            assert_true(host_counters(&r).compressed > 0);
            /* noise goes as it is */
            assert_true(host_counters(&r).compressed < host_counters(&r).bands);
        }
        free_rig(&r);
    }
}

static void a_thousand_rectangles_arrive_through_faults(void **state)
{
    (void)state;
    static const uint8_t formats[] = {LF_GUD_RGB888, LF_GUD_XRGB8888, LF_GUD_RGB565};
    for (int k = 0; k < 6; k++) {
        lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
        o.formats = &formats[k % 3];
        o.lz4 = k >= 3;
        o.status_on_set = k % 2 == 1;
        o.max_buffer_size = 8000;
        rig r = make_rig(&o, &(lf_model_gud_faults){.stall_every = 23, .fail_every = 17});
        assert_true(show_random_rects(&r, RECTS, formats[k % 3], 5 + (uint64_t)k) > 10);
        assert_true(host_counters(&r).failures > 10);
        free_rig(&r);
    }
}

/* Were a failed rectangle taken for shown, the half that the model spoils would stay: this is seen.
 */
static void a_host_that_trusts_failed_rectangles_would_be_caught(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(300, 100);
    rig r = make_rig(&o, &(lf_model_gud_faults){.fail_every = 2});
    uint64_t random = 1;
    const lf_rect whole = whole_of(&r), part = {10, 10, 100, 20};
    assert_int_equal(update(&r, &whole, 1), 0);
    gud_paint(&r.frame, part, true, &random);
    lf_assert_status(lf_gud_host_update(r.host, &r.frame, &part, 1, NULL), LF_E_IO, NULL);
    assert_true(gud_differences(r.gud, &r.frame, part, LF_GUD_RGB888) > 100);
    assert_int_equal(update(&r, &part, 1), 0);
    assert_int_equal(gud_differences(r.gud, &r.frame, whole, LF_GUD_RGB888), 0);
    free_rig(&r);
}

static void displays_of_whole_frames_get_them_whole(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(60, 40);
    o.full_update = true;
    rig r = make_rig(&o, &(lf_model_gud_faults){.fail_every = 5});
    show_random_rects(&r, 100, LF_GUD_RGB888, 4);
    assert_true(host_counters(&r).failures > 3);
    lf_model_gud_counters c = gud_counters(r.gud);
    assert_int_equal(c.bytes, c.rects * 60 * 40 * 3);
    free_rig(&r);
}

static void what_the_display_shows_already_is_not_sent(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    for (int k = 0; k < 2; k++) {
        o.full_update = k == 1;
        rig r = make_rig(&o, NULL);
        uint64_t random = 9;
        const lf_rect whole = whole_of(&r), pixel = {333, 111, 1, 1};
        gud_paint(&r.frame, whole, true, &random);
        assert_int_equal(update(&r, &whole, 1), 0);
        lf_model_gud_counters before = gud_counters(r.gud);
        assert_int_equal(update(&r, &whole, 1), 0);
        assert_int_equal(update(&r, &pixel, 1), 0);
        assert_int_equal(update(&r, NULL, 0), 0);
        assert_int_equal(gud_counters(r.gud).bytes, before.bytes);
        /* but the least change is */
        r.frame.data[(size_t)pixel.y * r.frame.stride + (size_t)pixel.x * 3] ^= 1;
        assert_int_equal(update(&r, &pixel, 1), 0);
        assert_int_equal(gud_counters(r.gud).bytes,
                         before.bytes + (k == 1 ? (uint64_t)WIDTH * HEIGHT * 3 : 3));
        assert_int_equal(gud_differences(r.gud, &r.frame, whole, LF_GUD_RGB888), 0);
        free_rig(&r);
    }
}

static void a_new_start_trusts_nothing(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    rig r = make_rig(&o, NULL);
    const lf_rect whole = whole_of(&r);
    assert_int_equal(update(&r, &whole, 1), 0);
    lf_assert_ok(lf_gud_host_start(r.host, NULL), NULL);
    assert_int_equal(update(&r, &whole, 1), 0);
    assert_int_equal(gud_counters(r.gud).bytes, 2 * WIDTH * HEIGHT * 3);
    lf_gud_host_stop(r.host);
    assert_false(lf_model_gud_lit(r.gud));
    free_rig(&r);
}

static void updates_do_not_allocate(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.lz4 = true;
    rig r = make_rig(&o, NULL);
    uint64_t before = lf_alloc_count();
    show_random_rects(&r, 50, LF_GUD_RGB888, 2);
    assert_int_equal(lf_alloc_count(), before);
    free_rig(&r);
}

/* -------------------------------------------------------------------------------------- plan -- */

static void bands_are_whole_rows_within_the_limit(void **state)
{
    (void)state;
    lf_gud_plan *plan = NULL;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    const lf_rect whole = {0, 0, WIDTH, HEIGHT};
    uint64_t random = 77;
    lf_assert_ok(lf_gud_plan_create(WIDTH, HEIGHT, &plan), NULL);
    const size_t limits[] = {1, WIDTH - 1, WIDTH, WIDTH * 7 + 3, WIDTH * 100, SIZE_MAX};
    for (size_t k = 0; k < sizeof limits / sizeof *limits; k++) {
        lf_gud_plan_forget(plan);
        int n = lf_gud_plan_update(plan, &frame, &whole, 1, limits[k]), y = 0;
        for (int i = 0; i < n; i++) {
            lf_rect b = lf_gud_plan_band(plan, i);
            assert_int_equal(b.x, 0);
            assert_int_equal(b.width, WIDTH);
            assert_int_equal(b.y, y);
            assert_true((size_t)b.height * WIDTH <= limits[k] || b.height == 1);
            y += b.height;
            lf_gud_plan_shown(plan, i);
        }
        assert_int_equal(y, HEIGHT);
    }
    assert_int_equal(lf_gud_plan_update(plan, &frame, &whole, 1, SIZE_MAX), 0);
    gud_paint(&frame, (lf_rect){400, 100, 3, 3}, true, &random);
    assert_int_equal(lf_gud_plan_update(plan, &frame, &whole, 1, SIZE_MAX), 1);
    lf_gud_plan_failed(plan);
    assert_int_equal(lf_gud_plan_update(plan, &frame, &(lf_rect){401, 101, 1, 1}, 1, SIZE_MAX), 1);
    assert_true(lf_gud_plan_band(plan, 0).width > 1); /* nothing is known of what lies around it */
    lf_gud_plan_destroy(plan);
    lf_gud_plan_destroy(NULL);
    lf_image8_finish(&frame);
}

/* -------------------------------------------------------------------------------------- lies -- */

static const char *const faults[LF_GUD_FAULTS] = {
    [LF_GUD_WRONG_MAGIC] = "descriptor",
    [LF_GUD_VERSION_0] = "version 0",
    [LF_GUD_VERSION_9] = "version 9",
    [LF_GUD_SHORT_DESCRIPTOR] = "23 bytes",
    [LF_GUD_NO_FORMATS] = "formats",
    [LF_GUD_UNKNOWN_FORMATS] = "formats",
    [LF_GUD_MANY_FORMATS] = "formats",
    [LF_GUD_NO_CONNECTORS] = "connector",
    [LF_GUD_MODE_0X0] = "0x0",
    [LF_GUD_MODE_65535] = "65535x65535",
    [LF_GUD_MODES_CUT] = "modes is cut off",
    [LF_GUD_TINY_BUFFER] = "smaller than a row",
    [LF_GUD_SHORT_EDID] = "EDID has 100",
    [LF_GUD_NO_MODES] = "neither modes nor",
    [LF_GUD_COMPRESSED_FULL] = "compression",
    [LF_GUD_BAD_STATUS] = "returned status 200",
};

static void every_lie_is_a_clear_error(void **state)
{
    (void)state;
    uint8_t edid[128] = {0};
    for (int fault = 0; fault < LF_GUD_FAULTS; fault++) {
        lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
        o.status_on_set = true;
        o.edid = edid;
        o.n_edid = sizeof edid;
        rig r;
        lf_error err = {0};
        lf_status status = try_rig(&o, &(lf_model_gud_faults){.fault = fault}, &r, &err);
        if (fault == LF_GUD_HONEST) {
            lf_assert_ok(status, &err);
        } else {
            if (status != LF_E_FORMAT || !strstr(err.what, faults[fault]))
                fail_msg("lie %d: %s \"%s\", expected \"%s\"", fault, lf_status_name(status),
                         err.what, faults[fault]);
        }
        free_rig(&r);
    }
}

static void a_buffer_must_hold_a_row_and_for_whole_frames_a_frame(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    lf_error err = {0};
    rig r;
    o.max_buffer_size = WIDTH * 3;
    lf_assert_ok(try_rig(&o, NULL, &r, &err), &err);
    free_rig(&r);
    o.max_buffer_size--;
    lf_assert_status(try_rig(&o, NULL, &r, &err), LF_E_FORMAT, &err);
    free_rig(&r);
    o.full_update = true;
    o.max_buffer_size = WIDTH * HEIGHT * 3 - 1;
    lf_assert_status(try_rig(&o, NULL, &r, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "smaller than a frame"));
    free_rig(&r);
}

static void a_size_that_it_does_not_have_is_told(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    lf_model_gud *gud = gud_model(&o, NULL);
    lf_usb_link *link = lf_usb_model_open(gud);
    lf_gud_host *host = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_gud_host_open(link, &host, &err), &err);
    lf_assert_status(lf_gud_host_choose(host, 1536, 2048, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "420x150"));
    assert_non_null(strstr(err.what, "1536x2048"));
    lf_assert_ok(lf_gud_host_choose(host, 0, 0, &err), &err);
    assert_int_equal(lf_gud_host_mode(host)->hdisplay, WIDTH);
    assert_false(lf_model_gud_lit(gud)); /* asked, and not touched */
    lf_gud_host_destroy(host);
    link->ops->close(link);
    lf_model_gud_destroy(gud);
}

/* A link that answers some questions by itself and hands the others on. */
typedef struct odd_link {
    lf_usb_link base;
    lf_usb_link *inner;
    bool poor;      /* refuses what a display need not have */
    bool unplugged; /* its connector has nothing on it */
} odd_link;

static lf_usb_result odd_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                 uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    odd_link *odd = (odd_link *)(void *)link;
    if (odd->poor &&
        (request == LF_GUD_GET_CONNECTOR_EDID || request == LF_GUD_GET_CONNECTOR_PROPERTIES))
        return LF_USB_STALL;
    if (odd->unplugged && request == LF_GUD_GET_CONNECTOR_STATUS) {
        data[0] = 0x80 | LF_GUD_DISCONNECTED;
        *out_n = 1;
        return LF_USB_OK;
    }
    return odd->inner->ops->control(odd->inner, in, request, value, data, n, out_n, timeout_ms);
}

static lf_status open_odd(odd_link odd, size_t *out_n_edid, lf_error *err)
{
    static const lf_usb_link_ops odd_ops = {.control = odd_control};
    uint8_t edid[128] = {0};
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.edid = edid;
    o.n_edid = sizeof edid;
    lf_model_gud *gud = gud_model(&o, NULL);
    lf_gud_host *host = NULL;
    odd.base.ops = &odd_ops;
    odd.inner = lf_usb_model_open(gud);
    lf_status status = lf_gud_host_open(&odd.base, &host, err);
    if (status == LF_OK)
        lf_gud_host_edid(host, out_n_edid);
    lf_gud_host_destroy(host);
    odd.inner->ops->close(odd.inner);
    lf_model_gud_destroy(gud);
    return status;
}

static void a_display_need_not_have_an_edid_but_something_on_its_connector(void **state)
{
    (void)state;
    size_t n = 99;
    lf_error err = {0};
    lf_assert_ok(open_odd((odd_link){0}, &n, &err), &err);
    assert_int_equal(n, 128);
    lf_assert_ok(open_odd((odd_link){.poor = true}, &n, &err), &err);
    assert_int_equal(n, 0);
    lf_assert_status(open_odd((odd_link){.unplugged = true}, &n, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "no panel connected"));
}

/* ------------------------------------------------------------------------------------ faults -- */

static void refusals_come_with_the_displays_reason(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
        o.status_on_set = k == 1;
        rig r = make_rig(&o, &(lf_model_gud_faults){.stall_every = 1});
        const lf_rect whole = whole_of(&r);
        lf_error err = {0};
        lf_assert_status(lf_gud_host_update(r.host, &r.frame, &whole, 1, &err), LF_E_IO, &err);
        assert_non_null(strstr(err.what, "busy"));
        lf_assert_ok(lf_gud_host_alive(r.host), NULL);
        free_rig(&r);
    }
}

static void unplugging_is_told_apart(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.max_buffer_size = WIDTH * 3 * 10;
    rig r = make_rig(&o, &(lf_model_gud_faults){.unplug_after = 3});
    const lf_rect whole = whole_of(&r);
    lf_error err = {0};
    lf_assert_status(lf_gud_host_update(r.host, &r.frame, &whole, 1, &err), LF_E_NODEV, &err);
    assert_int_equal(host_counters(&r).bands, 3);
    lf_assert_status(lf_gud_host_alive(r.host), LF_E_NODEV, NULL);
    lf_gud_host_stop(r.host);
    free_rig(&r);
}

static void a_display_that_hangs_is_left_after_a_while(void **state)
{
    (void)state;
    lf_model_gud_options o = gud_options(300, 100);
    rig r = make_rig(&o, &(lf_model_gud_faults){.hang_every = 2});
    uint64_t random = 1;
    const lf_rect whole = whole_of(&r);
    assert_int_equal(update(&r, &whole, 1), 0);
    gud_paint(&r.frame, whole, true, &random);
    lf_error err = {0};
    lf_assert_status(lf_gud_host_update(r.host, &r.frame, &whole, 1, &err), LF_E_TIMEOUT, &err);
    assert_int_equal(update(&r, &whole, 1), 0);
    assert_int_equal(gud_differences(r.gud, &r.frame, whole, LF_GUD_RGB888), 0);
    gud_paint(&r.frame, whole, true, &random);
    r.link->ops->cancel(r.link);
    lf_assert_status(lf_gud_host_update(r.host, &r.frame, &whole, 1, &err), LF_E_CANCELLED, &err);
    free_rig(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_thousand_rectangles_arrive_in_every_format_and_manner),
        cmocka_unit_test(a_thousand_rectangles_arrive_through_faults),
        cmocka_unit_test(a_host_that_trusts_failed_rectangles_would_be_caught),
        cmocka_unit_test(displays_of_whole_frames_get_them_whole),
        cmocka_unit_test(what_the_display_shows_already_is_not_sent),
        cmocka_unit_test(a_new_start_trusts_nothing),
        cmocka_unit_test(updates_do_not_allocate),
        cmocka_unit_test(bands_are_whole_rows_within_the_limit),
        cmocka_unit_test(every_lie_is_a_clear_error),
        cmocka_unit_test(a_buffer_must_hold_a_row_and_for_whole_frames_a_frame),
        cmocka_unit_test(a_size_that_it_does_not_have_is_told),
        cmocka_unit_test(a_display_need_not_have_an_edid_but_something_on_its_connector),
        cmocka_unit_test(refusals_come_with_the_displays_reason),
        cmocka_unit_test(unplugging_is_told_apart),
        cmocka_unit_test(a_display_that_hangs_is_left_after_a_while),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
