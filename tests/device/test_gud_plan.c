/* Which pixels a display is sent: few where few changed, and always enough. */
#include "tests/device/gud_testing.h"

#include "device/usb/gud_plan.h"

enum { WIDTH = 1536, HEIGHT = 2048, ROUNDS = 300 };

static const lf_rect whole = {0, 0, WIDTH, HEIGHT};

static lf_gud_plan *plan_of(int width, int height)
{
    lf_gud_plan *plan = NULL;
    lf_assert_ok(lf_gud_plan_create(width, height, &plan), NULL);
    return plan;
}

/* Plans an update as if all of it arrived; returns its pixels. */
static size_t send_all(lf_gud_plan *plan, const lf_image8 *frame, const lf_rect *rects, int n,
                       int *out_bands)
{
    size_t pixels = 0;
    *out_bands = lf_gud_plan_update(plan, frame, rects, n, (size_t)WIDTH * HEIGHT);
    for (int i = 0; i < *out_bands; i++) {
        lf_rect r = lf_gud_plan_band(plan, i);
        pixels += (size_t)r.width * (size_t)r.height;
        lf_gud_plan_shown(plan, i);
    }
    return pixels;
}

static void rows_far_apart_are_sent_without_what_lies_between(void **state)
{
    (void)state;
    uint64_t random = 1;
    int bands;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    lf_gud_plan *plan = plan_of(WIDTH, HEIGHT);
    assert_int_equal(send_all(plan, &frame, &whole, 1, &bands), WIDTH * HEIGHT);
    for (int y = 40; y < HEIGHT; y += 120)
        gud_paint(&frame, (lf_rect){0, y, WIDTH, 1}, true, &random);
    size_t pixels = send_all(plan, &frame, &whole, 1, &bands);
    assert_int_equal(bands, 17);
    assert_true(pixels <= 17 * 4 * WIDTH);
    assert_int_equal(send_all(plan, &frame, &whole, 1, &bands), 0);
    lf_gud_plan_destroy(plan);
    lf_image8_finish(&frame);
}

static void what_is_near_is_joined_rather_than_announced(void **state)
{
    (void)state;
    int bands;
    uint64_t random = 2;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    lf_gud_plan *plan = plan_of(WIDTH, HEIGHT);
    (void)send_all(plan, &frame, &whole, 1, &bands);
    for (int y = 100; y < 200; y += 5)
        gud_paint(&frame, (lf_rect){0, y, 1000, 1}, true, &random);
    assert_true(send_all(plan, &frame, &whole, 1, &bands) <= 104 * 1024);
    assert_int_equal(bands, 1);
    /* two narrow ones, one above the other and side by side */
    gud_paint(&frame, (lf_rect){300, 400, 20, 20}, true, &random);
    gud_paint(&frame, (lf_rect){310, 430, 20, 20}, true, &random);
    gud_paint(&frame, (lf_rect){700, 404, 20, 20}, true, &random);
    (void)send_all(plan, &frame, &whole, 1, &bands);
    assert_true(bands <= 2);
    /* and two that are worth an announcement each */
    gud_paint(&frame, (lf_rect){0, 0, WIDTH, 20}, true, &random);
    gud_paint(&frame, (lf_rect){0, 60, WIDTH, 20}, true, &random);
    (void)send_all(plan, &frame, &whole, 1, &bands);
    assert_int_equal(bands, 2);
    lf_gud_plan_destroy(plan);
    lf_image8_finish(&frame);
}

static void copy_band(lf_image8 *display, const lf_image8 *frame, lf_rect r)
{
    for (int y = r.y; y < r.y + r.height; y++)
        memcpy(display->data + (size_t)y * display->stride + (size_t)r.x * 3,
               frame->data + (size_t)y * frame->stride + (size_t)r.x * 3, (size_t)r.width * 3);
}

static bool same(const lf_image8 *a, const lf_image8 *b)
{
    for (int y = 0; y < a->height; y++)
        if (memcmp(a->data + (size_t)y * a->stride, b->data + (size_t)y * b->stride,
                   (size_t)a->width * 3) != 0)
            return false;
    return true;
}

/* Sends an update to `display`; when it breaks off at a band, that one is noise there. */
static bool send_some(lf_gud_plan *plan, const lf_image8 *frame, const lf_rect *rects, int n,
                      lf_image8 *display, uint64_t *random)
{
    size_t most = 1 + gud_random(random) % 20000;
    int bands = lf_gud_plan_update(plan, frame, rects, n, most);
    int breaks = gud_random(random) % 4 == 0 ? (int)(gud_random(random) % 8) : -1;
    for (int i = 0; i < bands; i++) {
        lf_rect r = lf_gud_plan_band(plan, i);
        assert_true((size_t)r.width * (size_t)r.height <= most || r.height == 1);
        if (i == breaks) {
            gud_paint(display, r, true, random);
            lf_gud_plan_failed(plan);
            return false;
        }
        copy_band(display, frame, r);
        lf_gud_plan_shown(plan, i);
    }
    return true;
}

static void whatever_changes_and_breaks_off_the_display_ends_up_exact(void **state)
{
    (void)state;
    static const int sizes[][2] = {{700, 90}, {1, 1}, {255, 5}, {257, 3}, {1100, 200}};
    uint64_t random = lf_test_seed();
    int failures = 0;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        int width = sizes[s][0], height = sizes[s][1];
        lf_image8 frame = gud_frame(width, height), display = gud_frame(width, height);
        const lf_rect all = {0, 0, width, height};
        lf_gud_plan *plan = plan_of(width, height);
        gud_paint(&display, all, true, &random);
        bool good = send_some(plan, &frame, &all, 1, &display, &random);
        for (int i = 0; i < ROUNDS; i++) {
            lf_rect rects[3];
            int n = 1 + (int)(gud_random(&random) % 3);
            for (int k = 0; k < n; k++) {
                rects[k] = gud_random_rect(width, height, &random);
                gud_paint(&frame, rects[k], gud_random(&random) % 2 == 0, &random);
            }
            /* after a failure everything is pushed, as the daemon does */
            good = good ? send_some(plan, &frame, rects, n, &display, &random)
                        : send_some(plan, &frame, &all, 1, &display, &random);
            failures += !good;
            assert_true(!good || same(&display, &frame));
        }
        lf_gud_plan_destroy(plan);
        lf_image8_finish(&frame);
        lf_image8_finish(&display);
    }
    assert_true(failures > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_far_apart_are_sent_without_what_lies_between),
        cmocka_unit_test(what_is_near_is_joined_rather_than_announced),
        cmocka_unit_test(whatever_changes_and_breaks_off_the_display_ends_up_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
