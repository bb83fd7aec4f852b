/* Crossfades of the engine, by a clock that only the test moves (wrap_test_engine_fade): every
 * mixed image is known exactly. */
#include "tests/testing.h"

#include <poll.h>
#include <stdatomic.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "daemon/engine/engine.h"
#include "tests/scene_file.h"

static atomic_int clock_seconds;
static atomic_bool clock_races; /* every look at the clock moves it */
static atomic_int looks;

double __wrap_lf_time_now(void);
double __wrap_lf_time_now(void)
{
    const int moved = atomic_load(&clock_races) ? atomic_fetch_add(&looks, 1) : 0;
    return 1000 + atomic_load(&clock_seconds) + moved * 0.05;
}

enum { VIEWS = 5, VIEW = 12, WIDTH = 48, HEIGHT = 64, BYTES = WIDTH * HEIGHT * 3, SECONDS = 4 };

typedef struct fixture {
    lf_engine *engine;
    int fd;
    uint64_t panel;
} fixture;

static void plug(fixture *f, bool views)
{
    lf_calibration calibration;
    lf_calibration_portrait(&calibration);
    calibration.screen_width_px = WIDTH;
    calibration.screen_height_px = HEIGHT;
    lf_engine_set_panel(f->engine, &calibration, ++f->panel, views);
}

static int set_up(void **state)
{
    const lf_engine_controls controls = {.threads = 2, .denoise = LF_DENOISE_AUTO};
    fixture *f = *state = calloc(1, sizeof *f);
    lf_error err = {0};
    assert_non_null(f);
    f->fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    lf_assert_ok(lf_engine_create(&controls, f->fd, &f->engine, &err), &err);
    plug(f, false);
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    lf_engine_destroy(f->engine);
    close(f->fd);
    free(f);
    return 0;
}

/* A finished picture; each seed has pixels of its own. */
static lf_content *picture(const char *file, unsigned seed)
{
    lf_content *content = lf_calloc(1, sizeof *content);
    assert_non_null(content);
    lf_quilt_file *quilt = &content->quilt;
    lf_assert_ok(lf_image8_init(&quilt->image8, VIEW, VIEW * VIEWS, 3), NULL);
    for (unsigned i = 0; i < VIEW * VIEW * VIEWS * 3; i++)
        quilt->image8.data[i] = (uint8_t)(i * (seed * 2 + 5) + i / 31 + seed * 77);
    quilt->views8 = (lf_views8){.n_views = VIEWS,
                                .width = VIEW,
                                .height = VIEW,
                                .row_stride = quilt->image8.stride,
                                .view_stride = quilt->image8.stride * VIEW,
                                .data = quilt->image8.data};
    atomic_init(&content->references, 1);
    content->file = lf_strdup(file);
    content->layout = quilt->layout = (lf_layout){VIEWS, 1, VIEWS, VIEW, VIEW, 0.75};
    return content;
}

static int64_t commit(fixture *f, lf_content *content)
{
    int64_t generation = 0;
    lf_error err = {0};
    lf_assert_ok(lf_engine_commit(f->engine, content, false, &generation, NULL, &err), &err);
    lf_content_unref(content);
    return generation;
}

/* Waits for a frame. */
static const lf_frame *take(fixture *f)
{
    for (;;) {
        struct pollfd p = {.fd = f->fd, .events = POLLIN};
        assert_int_equal(poll(&p, 1, 600000), 1);
        lf_wakeup_clear(f->fd);
        const lf_frame *frame = lf_mailbox_take(lf_engine_mailbox(f->engine));
        if (frame) {
            lf_mailbox_shown(lf_engine_mailbox(f->engine));
            return frame;
        }
    }
}

/* A picture as the panel shows it without a crossfade. */
static void whole(unsigned seed, uint8_t out[BYTES])
{
    lf_calibration calibration;
    lf_interlacer *interlacer;
    lf_image8 panel = {WIDTH, HEIGHT, 3, WIDTH * 3, out};
    lf_content *content = picture("/x", seed);
    lf_error err;
    lf_calibration_portrait(&calibration);
    calibration.screen_width_px = WIDTH;
    calibration.screen_height_px = HEIGHT;
    lf_assert_ok(lf_interlacer_create(&calibration, VIEWS, VIEW, VIEW, 0.75, LF_FILTER_NEAREST,
                                      LF_INVERT_AUTO, &interlacer, &err),
                 &err);
    lf_interlace(interlacer, &content->quilt.views8, &panel, NULL);
    lf_interlacer_destroy(interlacer);
    lf_content_unref(content);
}

/* Replaces `from` by its mix with `to`. */
static void mix(uint8_t from[BYTES], const uint8_t to[BYTES], double share)
{
    for (int i = 0; i < BYTES; i++)
        from[i] = (uint8_t)floor(from[i] * (1 - share) + to[i] * share + 0.5);
}

static void expect(const lf_frame *frame, const uint8_t image[BYTES], int64_t generation,
                   bool fades)
{
    assert_int_equal(frame->generation, generation);
    assert_int_equal(frame->fades, fades);
    assert_int_equal(frame->level, fades ? LF_LEVEL_COARSE : LF_LEVEL_CONVERGED);
    assert_memory_equal(frame->image.data, image, BYTES);
}

/* What the engine has posted so far; everything that it was told to do is done. */
static uint64_t posted(const fixture *f)
{
    const lf_cancel cancel = 0;
    lf_shown_views shown;
    lf_engine_status status;
    lf_error err;
    if (lf_engine_shown(f->engine, 1, &cancel, &shown, &err) == LF_OK)
        lf_shown_views_finish(&shown);
    lf_engine_get_status(f->engine, &status);
    return status.frames;
}

static void it_goes_from_one_image_to_the_next_and_ends_on_it(void **state)
{
    fixture *f = *state;
    static uint8_t a[BYTES], b[BYTES], mixed[BYTES];
    whole(1, a);
    whole(2, b);
    lf_engine_set_fade(f->engine, SECONDS);
    int64_t generation = commit(f, picture("/a", 1));
    expect(take(f), a, generation, false); /* nothing was shown before */
    generation = commit(f, picture("/b", 2));
    expect(take(f), a, generation, true);
    for (int i = 1; i < SECONDS; i++) {
        atomic_fetch_add(&clock_seconds, 1);
        memcpy(mixed, a, BYTES);
        mix(mixed, b, (double)i / SECONDS);
        expect(take(f), mixed, generation, true);
    }
    atomic_fetch_add(&clock_seconds, 3);
    expect(take(f), b, generation, false);
    const uint64_t n = posted(f);
    atomic_fetch_add(&clock_seconds, 60);
    usleep(100000);
    assert_int_equal(posted(f), n);
}

static void another_change_starts_from_the_mixed_image(void **state)
{
    fixture *f = *state;
    static uint8_t a[BYTES], b[BYTES], c[BYTES];
    whole(1, a);
    whole(2, b);
    whole(3, c);
    commit(f, picture("/a", 1));
    (void)take(f);
    lf_engine_set_fade(f->engine, SECONDS);
    commit(f, picture("/b", 2));
    (void)take(f);
    atomic_fetch_add(&clock_seconds, 1);
    (void)take(f);
    mix(a, b, 0.25);
    int64_t generation = commit(f, picture("/c", 3));
    expect(take(f), a, generation, true);
    atomic_fetch_add(&clock_seconds, 2);
    mix(a, c, 0.5);
    expect(take(f), a, generation, true);
    lf_engine_set_fade(f->engine, 0); /* this one goes on, later ones change at once */
    atomic_fetch_add(&clock_seconds, 1);
    assert_true(take(f)->fades);
    generation = commit(f, picture("/b", 2));
    expect(take(f), b, generation, false);
}

static void the_same_file_frames_of_a_sequence_and_cards_change_at_once(void **state)
{
    fixture *f = *state;
    static uint8_t image[4][BYTES];
    for (unsigned i = 0; i < 4; i++)
        whole(i, image[i]);
    lf_engine_set_fade(f->engine, SECONDS);
    lf_engine_set_card(f->engine, "no picture yet");
    assert_string_equal(take(f)->card, "no picture yet");
    expect(take(f), image[0], commit(f, picture("/a", 0)), false); /* from a card */
    expect(take(f), image[1], commit(f, picture("/a", 1)), false);
    lf_content *content = picture("/b", 2);
    content->is_frame = true;
    expect(take(f), image[2], commit(f, content), false);
    assert_true((commit(f, picture("/c", 3)), take(f)->fades));
}

static void the_same_file_does_not_end_one_that_runs(void **state)
{
    fixture *f = *state;
    static uint8_t a[BYTES], c[BYTES];
    whole(1, a);
    whole(3, c);
    commit(f, picture("/a", 1));
    (void)take(f);
    lf_engine_set_fade(f->engine, SECONDS);
    commit(f, picture("/b", 2));
    (void)take(f);
    atomic_fetch_add(&clock_seconds, 1);
    (void)take(f);
    const int64_t generation = commit(f, picture("/b", 3));
    mix(a, c, 0.25);
    expect(take(f), a, generation, true);
    atomic_fetch_add(&clock_seconds, SECONDS);
    expect(take(f), c, generation, false);
}

static void without_a_panel_and_on_another_one_nothing_is_mixed(void **state)
{
    fixture *f = *state;
    static uint8_t b[BYTES];
    whole(2, b);
    lf_engine_set_fade(f->engine, SECONDS);
    commit(f, picture("/a", 1));
    (void)take(f);
    const int64_t generation = commit(f, picture("/b", 2));
    assert_true(take(f)->fades);
    plug(f, false);
    expect(take(f), b, generation, false);
    lf_engine_set_panel(f->engine, NULL, ++f->panel, false);
    const lf_frame *frame = take(f);
    assert_null(frame->image.data);
    commit(f, picture("/a", 1));
    frame = take(f);
    assert_null(frame->image.data);
    assert_false(frame->fades);
    assert_int_equal(frame->level, LF_LEVEL_CONVERGED);
}

/* Images that the panel does not take are left out, never queued; the whole one comes. */
static void a_panel_that_is_busy_gets_the_last_image_alone(void **state)
{
    fixture *f = *state;
    static uint8_t b[BYTES];
    whole(2, b);
    commit(f, picture("/a", 1));
    (void)take(f);
    lf_engine_set_fade(f->engine, 100); /* cut to LF_MAX_FADE */
    const int64_t generation = commit(f, picture("/b", 2));
    const uint64_t n = posted(f);
    for (int i = 1; i < LF_MAX_FADE; i++) {
        atomic_fetch_add(&clock_seconds, 1);
        usleep(40000);
        assert_int_equal(posted(f), n);
    }
    atomic_fetch_add(&clock_seconds, 1);
    while (posted(f) == n)
        usleep(10000);
    assert_int_equal(posted(f), n + 1);
    expect(take(f), b, generation, false);
    /* and one whose image does not change for long gets nothing */
    commit(f, picture("/a", 1));
    (void)take(f);
    const uint64_t before = posted(f);
    usleep(100000);
    assert_int_equal(posted(f), before);
}

/* However fast panel and machine are. */
static void there_are_at_most_60_images_a_second(void **state)
{
    fixture *f = *state;
    int n = 0;
    commit(f, picture("/a", 1));
    (void)take(f);
    lf_engine_set_fade(f->engine, LF_MAX_FADE);
    const uint64_t start = lf_time_now_ns();
    commit(f, picture("/b", 2));
    atomic_store(&clock_races, true);
    while (take(f)->fades)
        n++;
    atomic_store(&clock_races, false);
    const double seconds = (double)(lf_time_now_ns() - start) / LF_NS_PER_S;
    assert_true(n > 2); /* not one image alone */
    assert_true(n <= 60 * seconds + 2);
}

static void views_change_at_once(void **state)
{
    fixture *f = *state;
    plug(f, true);
    commit(f, picture("/a", 1));
    (void)take(f);
    lf_engine_set_fade(f->engine, SECONDS);
    lf_content *content = picture("/b", 2), *kept = lf_content_ref(content);
    commit(f, content);
    const lf_frame *frame = take(f);
    lf_mailbox *mailbox = lf_engine_mailbox(f->engine);
    const lf_views8 *views = lf_mailbox_views(mailbox, frame);
    assert_true(frame->fades && views && !frame->lacks_views);
    for (int v = 0; v < VIEWS; v++)
        for (int y = 0; y < VIEW; y++)
            assert_memory_equal(lf_views8_row(views, v, y),
                                lf_views8_row(&kept->quilt.views8, v, y), VIEW * 3);
    lf_mailbox_views_done(mailbox);
    atomic_fetch_add(&clock_seconds, SECONDS);
    frame = take(f);
    assert_false(frame->fades || frame->lacks_views);
    lf_content_unref(kept);
}

static lf_content *fog(void)
{
    const lf_options options = {.views = 6, .view_width = 48, .view_height = 64};
    lf_calibration calibration;
    lf_content *content = NULL;
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc = lf_test_scene_document("live-fog");
    lf_calibration_portrait(&calibration);
    lf_assert_ok(lf_scene_from_json(doc, ".", "fog", NULL, NULL, &scene, &err), &err);
    lf_assert_ok(lf_content_from_scene(scene, "fog", &options, &calibration, &content, &err), &err);
    lf_scene_unref(scene);
    json_decref(doc);
    return content;
}

/* Better frames change the image that is mixed, and the level is told at the end. */
static void a_scene_fades_from_its_first_coarse_frame_on(void **state)
{
    fixture *f = *state;
    static uint8_t a[BYTES];
    whole(1, a);
    commit(f, picture("/a", 1));
    (void)take(f);
    lf_engine_set_fade(f->engine, SECONDS);
    const int64_t generation = commit(f, fog());
    expect(take(f), a, generation, true);
    atomic_fetch_add(&clock_seconds, SECONDS - 1);
    const lf_frame *frame = take(f);
    for (; frame->fades; frame = take(f)) {
        assert_int_equal(frame->level, LF_LEVEL_COARSE);
        assert_int_equal(frame->generation, generation);
        assert_true(frame->reconstructed);
        if (memcmp(frame->image.data, a, BYTES) != 0)
            atomic_store(&clock_seconds, atomic_load(&clock_seconds) + 1);
    }
    while (frame->level < LF_LEVEL_COMPLETE)
        frame = take(f);
    assert_int_equal(frame->generation, generation);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(it_goes_from_one_image_to_the_next_and_ends_on_it),
        TEST(another_change_starts_from_the_mixed_image),
        TEST(the_same_file_frames_of_a_sequence_and_cards_change_at_once),
        TEST(the_same_file_does_not_end_one_that_runs),
        TEST(without_a_panel_and_on_another_one_nothing_is_mixed),
        TEST(a_panel_that_is_busy_gets_the_last_image_alone),
        TEST(there_are_at_most_60_images_a_second),
        TEST(views_change_at_once),
        TEST(a_scene_fades_from_its_first_coarse_frame_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
