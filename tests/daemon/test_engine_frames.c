/* Which frames the engine posts while the camera moves. */
#include "tests/testing.h"

#include <math.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/wakeup.h"
#include "daemon/engine/engine.h"
#include "tests/scene_file.h"

/* The scene with the camera `aside`, and fog of this density. */
static lf_content *content_of(double aside, double density)
{
    const lf_options options = {.views = 6, .view_width = 48, .view_height = 64};
    lf_calibration calibration;
    lf_content *content = NULL;
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc = lf_test_scene_document("live-fog"),
           *patch = json_pack("{s:{s:[f,f,f]}, s:{s:{s:f}}}", "camera", "position", aside, 0.4, 9.0,
                              "volumes", "fog", "density", density),
           *patched = lf_json_merge_patch(doc, patch);
    lf_calibration_portrait(&calibration);
    lf_assert_ok(lf_scene_from_json(patched, ".", "fog", NULL, NULL, &scene, &err), &err);
    lf_assert_ok(lf_content_from_scene(scene, "fog", &options, &calibration, &content, &err), &err);
    lf_scene_unref(scene);
    json_decref(doc);
    json_decref(patch);
    json_decref(patched);
    return content;
}

static int64_t commit(lf_engine *engine, double aside, double density)
{
    lf_error err = {0};
    int64_t generation = 0;
    lf_content *content = content_of(aside, density);
    lf_assert_ok(lf_engine_commit(engine, content, false, &generation, NULL, &err), &err);
    lf_content_unref(content);
    return generation;
}

/* The next frame there is, of this generation. */
static const lf_frame *next_frame(lf_engine *engine, int fd, int64_t generation)
{
    for (;;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        assert_int_equal(poll(&p, 1, 600000), 1);
        lf_wakeup_clear(fd);
        const lf_frame *frame = lf_mailbox_take(lf_engine_mailbox(engine));
        if (frame && frame->generation == generation) {
            lf_mailbox_shown(lf_engine_mailbox(engine));
            return frame;
        }
    }
}

static void wait_for_a_fit(lf_engine *engine, int fd, int64_t generation)
{
    assert_true(next_frame(engine, fd, generation)->reconstructed);
}

/* The camera moves whenever it likes, also while a fit is made or before there was a frame. */
static void no_frame_of_a_camera_that_moves_is_unfiltered(void **state)
{
    (void)state;
    const lf_engine_controls controls = {.threads = 2, .denoise = LF_DENOISE_AUTO};
    lf_engine *engine = NULL;
    lf_error err = {0};
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_engine_create(&controls, fd, &engine, &err), &err);
    wait_for_a_fit(engine, fd, commit(engine, 0.0, 4.0));
    for (int i = 1; i <= 60; i++) {
        int64_t generation = commit(engine, 0.01 * i, 4.0);
        if (i % 3 > 0)
            usleep((useconds_t)(1000 * (i % 17)));
        else
            for (int k = 0; k <= i % 4; k++)
                assert_true(next_frame(engine, fd, generation)->reconstructed);
    }
    lf_engine_destroy(engine);
    close(fd);
}

/* Nor is that of another scene: what was shown before it was not. */
static void no_first_frame_of_a_scene_is_unfiltered(void **state)
{
    (void)state;
    const lf_engine_controls controls = {.threads = 2, .denoise = LF_DENOISE_AUTO};
    lf_engine *engine = NULL;
    lf_error err = {0};
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_engine_create(&controls, fd, &engine, &err), &err);
    for (int i = 0; i <= 20; i++) {
        int64_t generation = commit(engine, 0.0, 4.0 + 0.1 * i);
        for (int k = 0; k <= i % 4; k++)
            assert_true(next_frame(engine, fd, generation)->reconstructed);
    }
    lf_engine_destroy(engine);
    close(fd);
}

/* Of a scene that is played, noise would flicker between one frame and the next. */
static void no_frame_of_many_is_unfiltered(void **state)
{
    (void)state;
    const lf_engine_controls controls = {.threads = 2, .denoise = LF_DENOISE_AUTO};
    lf_engine *engine = NULL;
    lf_error err = {0};
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_engine_create(&controls, fd, &engine, &err), &err);
    wait_for_a_fit(engine, fd, commit(engine, 0.0, 4.0));
    for (int i = 1; i <= 20; i++) {
        int64_t generation = 0;
        lf_content *content = content_of(0.0, 4.0 + 0.1 * i);
        content->is_frame = true;
        lf_assert_ok(lf_engine_commit(engine, content, false, &generation, NULL, &err), &err);
        lf_content_unref(content);
        assert_true(next_frame(engine, fd, generation)->reconstructed);
    }
    lf_engine_destroy(engine);
    close(fd);
}

enum { VALUES = 48 * 64 * 6 * 3 };

/* When it is complete: after the coarse sweep of a quarter pass and one of two passes, or before
 * the rows of the coarse sweep have their turn in that, which come last where it is cut into
 * batches. */
static const double complete_at[2] = {1.75, 2.25};

/* The first complete frame's views as [row][view][column][3], and which of complete_at it is; -1:
 * it was replaced by a later one before it was taken. */
static int first_complete(lf_engine *engine, int fd, int64_t generation, uint8_t out[VALUES])
{
    lf_mailbox *mailbox = lf_engine_mailbox(engine);
    const lf_frame *frame;
    do {
        frame = next_frame(engine, fd, generation);
    } while (frame->level < LF_LEVEL_COMPLETE);
    const lf_views8 *views = lf_mailbox_views(mailbox, frame);
    int which = -1;
    for (int i = 0; views && i < 2; i++)
        which = fabs(frame->passes - complete_at[i]) < 1e-6 ? i : which;
    for (int i = 0; which >= 0 && i < 64 * 6; i++)
        memcpy(out + (size_t)i * 48 * 3,
               views->data + (size_t)(i / 6) * views->row_stride +
                   (size_t)(i % 6) * views->view_stride,
               48 * 3);
    lf_mailbox_views_done(mailbox);
    return which;
}

/* The same by a fit of all that such a frame is made of. */
static void fit_of_all(const lf_content *content, int which, uint8_t out[VALUES])
{
    static float film[VALUES];
    static const int first_rows[] = {0, 1, 3, 2};
    const lf_part coarse = {.first_row = 2, .row_step = 4};
    lf_render_settings settings = content->settings;
    lf_pool *pool = NULL;
    lf_renderer *r = NULL;
    lf_tone *tone = NULL;
    lf_error err = {0};
    settings.features = true;
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    lf_assert_ok(lf_renderer_create(content->scene, &settings, pool, &r, &err), &err);
    lf_assert_ok(lf_renderer_pass_coarse(r, &coarse, -1, NULL, NULL, NULL), NULL);
    for (int i = 0; i < 3 + which; i++) {
        const lf_part part = {.first_row = first_rows[i], .row_step = 4};
        lf_assert_ok(lf_renderer_pass_filling(r, &part, 2, -1, NULL, NULL, NULL), NULL);
    }
    lf_assert_ok(lf_renderer_show(r, film, NULL), NULL);
    lf_assert_ok(lf_tone_create(content->film.exposure, content->film.tonemap, &tone, &err), &err);
    lf_tone_map(tone, VALUES / 3, film, out);
    lf_tone_destroy(tone);
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
}

/* A fit of a quarter of the rows knows little of the others: the first complete frame is of a fit
 * to all of them, though the one before was made just then. What is dithered is a code off. Without
 * that fit half of the values are off, where the one before took long: in one round of four. */
static void the_first_complete_frame_is_fitted_to_all_rows(void **state)
{
    (void)state;
    static uint8_t seen[VALUES], fitted[2][VALUES];
    const lf_engine_controls controls = {.threads = 2, .denoise = LF_DENOISE_AUTO};
    lf_content *content = content_of(0.0, 4.0);
    for (int i = 0; i < 2; i++)
        fit_of_all(content, i, fitted[i]);
    int rounds = 0;
    for (int tries = 0; rounds < 16 && tries < 64; tries++) {
        lf_engine *engine = NULL;
        lf_error err = {0};
        int64_t generation = 0;
        int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
        lf_assert_ok(lf_engine_create(&controls, fd, &engine, &err), &err);
        lf_engine_set_panel(engine, NULL, 1, true);
        lf_assert_ok(lf_engine_commit(engine, content, false, &generation, NULL, &err), &err);
        const int which = first_complete(engine, fd, generation, seen);
        int off = 0;
        for (int i = 0; which >= 0 && i < VALUES; i++)
            off += abs(seen[i] - fitted[which][i]) > 1;
        assert_int_equal(off, 0);
        rounds += which >= 0;
        lf_engine_destroy(engine);
        close(fd);
    }
    assert_int_equal(rounds, 16);
    lf_content_unref(content);
}

/* A consumer that reads views just then gets no others; after the last frame no more would come. */
static void the_last_frame_has_its_views(void **state)
{
    (void)state;
    lf_engine_controls controls = {.threads = 2};
    lf_engine_status status;
    lf_engine *engine = NULL;
    lf_error err = {0};
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_engine_create(&controls, fd, &engine, &err), &err);
    lf_mailbox *mailbox = lf_engine_mailbox(engine);
    lf_engine_set_panel(engine, NULL, 1, true);
    int64_t generation = commit(engine, 0.0, 4.0);
    const lf_frame *frame = next_frame(engine, fd, generation);
    while (!lf_mailbox_views(mailbox, frame))
        frame = next_frame(engine, fd, generation);
    controls.paused = true;
    lf_engine_set_controls(engine, &controls);
    do {
        usleep(1000);
        lf_engine_get_status(engine, &status);
    } while (status.state != LF_STATE_PAUSED);
    for (int i = 0; i < 2; i++) /* one may be from before */
        frame = next_frame(engine, fd, generation);
    assert_null(lf_mailbox_views(mailbox, frame));
    while (!lf_mailbox_views(mailbox, frame) || frame->passes < status.passes)
        frame = next_frame(engine, fd, generation);
    lf_mailbox_views_done(mailbox);
    lf_engine_destroy(engine);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_frame_of_a_camera_that_moves_is_unfiltered),
        cmocka_unit_test(no_first_frame_of_a_scene_is_unfiltered),
        cmocka_unit_test(no_frame_of_many_is_unfiltered),
        cmocka_unit_test(the_first_complete_frame_is_fitted_to_all_rows),
        cmocka_unit_test(the_last_frame_has_its_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
