/* What a picture that converges puts on the wire of a USB display. The engine's schedule, but with
 * a clock of its own: the same batches, frames and bytes every time. */
#include "tests/device/gud_testing.h"
#include "tests/scene_file.h"

#include "daemon/engine/picture.h"
#include "daemon/engine/schedule.h"
#include "daemon/output/content.h"
#include "device/model/usb_model.h"
#include "device/usb/gud_host.h"

enum {
    VIEWS = 8,
    VIEW_WIDTH = 48,
    VIEW_HEIGHT = 280,
    WIDTH = 384,
    HEIGHT = 1024,
    THREADS = 2,
    SWEEPS = 5
};
enum { PIXELS = VIEWS * VIEW_WIDTH * VIEW_HEIGHT };

#define ROW_SECONDS 0.005 /* of a pass over a row, by the clock of this test */

typedef struct converging {
    lf_content *content;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_picture picture;
    lf_interlacer *interlacer;
    lf_image8 frames[2]; /* in turn */
    lf_model_gud *gud;
    lf_usb_link *link;
    lf_gud_host *host;
    int updates;
} converging;

static lf_calibration panel(void)
{
    lf_calibration c;
    lf_calibration_portrait(&c);
    c.screen_width_px = WIDTH;
    c.screen_height_px = HEIGHT;
    return c;
}

static void make_picture(converging *c, const lf_calibration *calibration)
{
    lf_error err = {0};
    lf_scene *scene = NULL;
    json_t *doc =
        lf_test_json("live-fog", lf_test_scene_patched("live-fog", "{'camera': {'views': null}}"));
    const lf_options options = {
        .views = VIEWS, .view_width = VIEW_WIDTH, .view_height = VIEW_HEIGHT};
    lf_assert_ok(lf_scene_from_json(doc, ".", "fog", NULL, NULL, &scene, &err), &err);
    json_decref(doc);
    lf_assert_ok(lf_content_from_scene(scene, "fog", &options, calibration, &c->content, &err),
                 &err);
    lf_scene_unref(scene);
    lf_assert_ok(lf_pool_create(THREADS, &c->pool), NULL);
    lf_assert_ok(
        lf_renderer_create(c->content->scene, &c->content->settings, c->pool, &c->renderer, &err),
        &err);
    lf_assert_ok(lf_picture_shape(&c->picture, VIEWS, VIEW_WIDTH, VIEW_HEIGHT, THREADS,
                                  &c->content->film, &err),
                 &err);
    c->picture.renderer = c->renderer;
    lf_assert_ok(lf_interlacer_create(calibration, VIEWS, VIEW_WIDTH, VIEW_HEIGHT,
                                      c->content->layout.aspect, LF_FILTER_NEAREST, LF_INVERT_AUTO,
                                      &c->interlacer, &err),
                 &err);
}

static void make_display(converging *c, bool lz4)
{
    lf_error err = {0};
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.lz4 = lz4;
    c->gud = gud_model(&o, NULL);
    c->link = lf_usb_model_open(c->gud);
    assert_non_null(c->link);
    lf_assert_ok(lf_gud_host_open(c->link, &c->host, &err), &err);
    lf_assert_ok(lf_gud_host_choose(c->host, WIDTH, HEIGHT, &err), &err);
    lf_assert_ok(lf_gud_host_start(c->host, &err), &err);
}

static void set_up(converging *c, bool lz4)
{
    lf_calibration calibration = panel();
    *c = (converging){0};
    make_picture(c, &calibration);
    make_display(c, lz4);
    for (int i = 0; i < 2; i++)
        c->frames[i] = gud_frame(WIDTH, HEIGHT);
}

static void tear_down(converging *c)
{
    lf_gud_host_destroy(c->host);
    c->link->ops->close(c->link);
    lf_model_gud_destroy(c->gud);
    lf_interlacer_destroy(c->interlacer);
    lf_picture_finish(&c->picture);
    lf_renderer_destroy(c->renderer);
    lf_pool_destroy(c->pool);
    lf_content_unref(c->content);
    for (int i = 0; i < 2; i++)
        lf_image8_finish(&c->frames[i]);
}

/* Shows the picture as it is; the display must then show exactly that. */
static void show(converging *c)
{
    int64_t unfilled, blank;
    lf_error err = {0};
    lf_rect rects[64] = {{0, 0, WIDTH, HEIGHT}};
    const lf_image8 *before = &c->frames[c->updates % 2];
    lf_image8 *frame = &c->frames[(c->updates + 1) % 2];
    lf_views8 views = lf_picture_views(&c->picture, c->pool, &unfilled, &blank);
    lf_interlace(c->interlacer, &views, frame, c->pool);
    int n = c->updates == 0 ? 1 : lf_changed_rects(before, frame, rects, 64);
    lf_assert_ok(lf_gud_host_update(c->host, frame, rects, n, &err), &err);
    assert_int_equal(gud_differences(c->gud, frame, rects[0], LF_GUD_RGB888), 0);
    c->updates++;
}

/* Renders and shows each batch of about target_seconds. */
static void converge(converging *c, double target_seconds)
{
    lf_schedule schedule = {0};
    lf_schedule_start(&schedule, VIEW_HEIGHT, VIEWS, false, 0);
    schedule.row_seconds = ROW_SECONDS;
    while (schedule.sweep < SWEEPS) {
        lf_batch batch = lf_schedule_next(&schedule, target_seconds);
        int reach = batch.coarse ? LF_COARSE_REACH : 0;
        lf_assert_ok(lf_renderer_pass_filling(
                         c->renderer, &(lf_part){.first_row = batch.first, .row_step = batch.step},
                         batch.subsets, reach, lf_picture_row, &c->picture, NULL),
                     NULL);
        (void)lf_schedule_done(&schedule, &batch, ROW_SECONDS * batch.n_rows * batch.subsets);
        if (lf_schedule_covers(&schedule))
            show(c);
    }
}

static double share_of_full_frames(const converging *c)
{
    lf_gud_host_counters counters;
    lf_gud_host_counters_get(c->host, &counters);
    double share = (double)counters.bytes / ((double)c->updates * WIDTH * HEIGHT * 3);
    print_message("%d updates, %.2f %% of full frames\n", c->updates, 100 * share);
    return share;
}

static void updates_cost_less_than_a_tenth_of_full_frames_and_the_last_is_exact(void **state)
{
    (void)state;
    static const lf_rect whole = {0, 0, WIDTH, HEIGHT};
    for (int lz4 = 0; lz4 < 2; lz4++) {
        converging c;
        set_up(&c, lz4 > 0);
        converge(&c, 0.15);
        assert_true(c.updates > 60);
        assert_true(share_of_full_frames(&c) < 0.1);
        assert_int_equal(gud_differences(c.gud, &c.frames[c.updates % 2], whole, LF_GUD_RGB888), 0);
        /* negative control: the frame before was another */
        assert_true(gud_differences(c.gud, &c.frames[(c.updates + 1) % 2], whole, LF_GUD_RGB888) >
                    0);
        tear_down(&c);
    }
}

/* Negative control: what changes as a whole is sent as a whole. */
static void updates_of_whole_sweeps_cost_more(void **state)
{
    (void)state;
    converging c;
    set_up(&c, false);
    converge(&c, 1e9);
    assert_true(share_of_full_frames(&c) > 0.5);
    tear_down(&c);
}

/* Later visits find that something is possible where the first found nothing: no hole where there
 * was a pixel. */
static void a_pixel_that_was_there_stays(void **state)
{
    (void)state;
    static uint8_t before[PIXELS];
    converging c;
    set_up(&c, false);
    for (int visit = 0; visit < 6; visit++) {
        lf_assert_ok(lf_renderer_pass(c.renderer, NULL, 1, lf_picture_row, &c.picture, NULL), NULL);
        for (int i = 0; i < PIXELS && visit > 0; i++)
            if (before[i] == 0 && c.picture.missing[i] != 0)
                fail_msg("visit %d: pixel %d was there and is missing", visit, i);
        memcpy(before, c.picture.missing, PIXELS);
    }
    tear_down(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_cost_less_than_a_tenth_of_full_frames_and_the_last_is_exact),
        cmocka_unit_test(updates_of_whole_sweeps_cost_more),
        cmocka_unit_test(a_pixel_that_was_there_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
