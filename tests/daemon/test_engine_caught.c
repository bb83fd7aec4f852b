/* What frames of the engine have besides what is rendered: what catchers get, as a picture has it
 * that is made by itself, and guides. */
#include "tests/testing.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/wakeup.h"
#include "daemon/engine/engine.h"
#include "tests/scene_file.h"

enum { VIEWS = 5, SIDE = 48, PIXELS = VIEWS * SIDE * SIDE };

typedef struct running {
    lf_engine *engine;
    lf_content *content;
    lf_engine_controls controls;
    int fd;
} running;

static lf_content *content_of(const char *name, lf_denoise denoise)
{
    const lf_options options = {.views = VIEWS,
                                .view_width = SIDE,
                                .view_height = SIDE,
                                .target_error = 1e-9,
                                .denoise = denoise};
    lf_scene *scene = NULL;
    lf_content *content = NULL;
    lf_error err = {0};
    json_t *doc = lf_test_scene_document(name);
    lf_assert_ok(lf_scene_from_json(doc, ".", "scene", NULL, NULL, &scene, &err), &err);
    lf_assert_ok(lf_content_from_scene(scene, "scene", &options, NULL, &content, &err), &err);
    lf_scene_unref(scene);
    json_decref(doc);
    return content;
}

static void begin(running *r, const char *scene, lf_denoise denoise)
{
    lf_error err = {0};
    int64_t generation = 0;
    *r = (running){.fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    r->controls = (lf_engine_controls){.threads = 2, .denoise = denoise, .target_error = 1e-9};
    lf_assert_ok(lf_engine_create(&r->controls, r->fd, &r->engine, &err), &err);
    lf_engine_set_panel(r->engine, NULL, 1, true);
    r->content = content_of(scene, denoise);
    lf_assert_ok(lf_engine_commit(r->engine, r->content, false, &generation, NULL, &err), &err);
}

static void end(running *r)
{
    lf_engine_destroy(r->engine);
    lf_content_unref(r->content);
    close(r->fd);
}

static lf_engine_status status_of(const running *r)
{
    lf_engine_status now;
    lf_engine_get_status(r->engine, &now);
    return now;
}

/* Stands still after so many native samples. */
static void run_to(running *r, double spp)
{
    r->controls.paused = false;
    lf_engine_set_controls(r->engine, &r->controls);
    while (status_of(r).spp < spp)
        usleep(2000);
    r->controls.paused = true;
    lf_engine_set_controls(r->engine, &r->controls);
}

/* The views of the last frame, which stands still: [row][view][column][3]. */
static void last_views(running *r, uint8_t out[3 * PIXELS])
{
    bool have = false;
    for (int quiet = 0; quiet < 2 || !have;) {
        struct pollfd p = {.fd = r->fd, .events = POLLIN};
        quiet = poll(&p, 1, 300) == 0 && status_of(r).state == LF_STATE_PAUSED ? quiet + 1 : 0;
        lf_wakeup_clear(r->fd);
        const lf_frame *frame = lf_mailbox_take(lf_engine_mailbox(r->engine));
        if (!frame)
            continue;
        const lf_views8 *views = lf_mailbox_views(lf_engine_mailbox(r->engine), frame);
        for (int i = 0; views && i < VIEWS * SIDE; i++)
            memcpy(out + 3 * SIDE * i,
                   views->data + (size_t)(i / VIEWS) * views->row_stride +
                       (size_t)(i % VIEWS) * views->view_stride,
                   3 * SIDE);
        have = have || views;
        lf_mailbox_views_done(lf_engine_mailbox(r->engine));
        lf_mailbox_shown(lf_engine_mailbox(r->engine));
    }
}

/* What quiltrender would make of it, with shadows or without. */
static void make_picture(const lf_content *content, bool shadows, float film[3 * PIXELS],
                         uint8_t shown[3 * PIXELS])
{
    lf_pool *pool = NULL;
    lf_renderer *r = NULL;
    lf_tone *tone = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    lf_assert_ok(lf_renderer_create(content->scene, &content->settings, pool, &r, &err), &err);
    lf_assert_ok(lf_renderer_passes(r, NULL, 24 * VIEWS, true, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, film, NULL), NULL);
    if (shadows)
        lf_assert_ok(lf_renderer_catch(r, film, NULL), NULL);
    lf_assert_ok(lf_tone_create(0, "srgb", &tone, &err), &err);
    lf_tone_map(tone, PIXELS, film, shown);
    lf_tone_destroy(tone);
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
}

static double apart(const uint8_t *a, const uint8_t *b)
{
    double sum = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++)
        sum += abs(a[i] - b[i]);
    return sum / (3 * PIXELS);
}

static uint8_t seen[3 * PIXELS], with[3 * PIXELS], without[3 * PIXELS];
static float film[3 * PIXELS], bare[3 * PIXELS];

/* Noise and edges are a level or two in the mean; what catchers get is several times that. */
static void frames_have_what_catchers_of_files_get(void **state)
{
    (void)state;
    static const struct {
        const char *scene;
        double noise, caught;
    } scenes[] = {{"ball-in-catcher-light", 2.0, 5.0}, {"light-on-mirror", 2.0, 5.0}};
    for (int i = 0; i < 4; i++) {
        running r;
        begin(&r, scenes[i / 2].scene, i % 2 == 0 ? LF_DENOISE_OFF : LF_DENOISE_ON);
        if (i % 2 == 0) {
            make_picture(r.content, true, film, with);
            make_picture(r.content, false, bare, without);
        }
        run_to(&r, 8);
        last_views(&r, seen);
        assert_int_equal(status_of(&r).reconstructed, i % 2 == 1);
        assert_true(apart(seen, with) < scenes[i / 2].noise);
        assert_true(apart(seen, without) > scenes[i / 2].caught); /* a negative control */
        end(&r);
    }
}

static double film_apart(const float *a, const float *b)
{
    double sum = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++)
        sum += fabs((double)a[i] - (double)b[i]);
    return sum / (3 * PIXELS);
}

static void exports_have_them_too(void **state)
{
    (void)state;
    running r;
    begin(&r, "ball-in-catcher-light", LF_DENOISE_ON);
    make_picture(r.content, true, film, with);
    make_picture(r.content, false, bare, without);
    run_to(&r, 8);
    for (int i = 0; i < 2; i++) {
        lf_snapshot snapshot;
        lf_error err = {0};
        lf_assert_ok(lf_engine_snapshot(r.engine, i == 0 ? LF_DENOISE_OFF : LF_DENOISE_ON, 0,
                                        &snapshot, &err),
                     &err);
        assert_true(film_apart(snapshot.film, film) < 0.01);
        assert_true(film_apart(snapshot.film, bare) > 0.03);
        lf_snapshot_finish(&snapshot);
    }
    end(&r);
}

/* How much redder than blue the middle of a cube is, in the middle view. */
static int redder(const uint8_t *picture, double slope)
{
    const int column = SIDE / 2 + (int)(SIDE / 2 * slope / tan(10 * M_PI / 180));
    const uint8_t *at = picture + 3 * ((SIDE / 2 * VIEWS + VIEWS / 2) * SIDE + column);
    return at[0] - at[2];
}

/* Near is marked red, far blue, and what is sharp not at all; or nothing is. */
static bool is_marked(const uint8_t *picture, bool on)
{
    const int near = redder(picture, -0.6 / 6), far = redder(picture, 2.0 / 18);
    return abs(redder(picture, 0)) < 3 &&
           (on ? near > 40 && far < -40 : abs(near) < 3 && abs(far) < 3);
}

/* A frame that was under way when guides were switched may come in between. */
static void guides_are_switched_on_and_off(void **state)
{
    (void)state;
    running r;
    begin(&r, "cubes-in-depth", LF_DENOISE_AUTO);
    run_to(&r, 4);
    for (int i = 0; i < 3; i++) {
        lf_snapshot snapshot;
        r.controls.guides = i == 1;
        lf_engine_set_controls(r.engine, &r.controls);
        do
            last_views(&r, seen);
        while (!is_marked(seen, i == 1));
        lf_assert_ok(lf_engine_snapshot(r.engine, LF_DENOISE_ON, 0, &snapshot, NULL), NULL);
        for (int k = 0; k < PIXELS; k++) /* exports are of the picture alone */
            assert_true(fabsf(snapshot.film[3 * k] - snapshot.film[3 * k + 2]) < 0.02f);
        lf_snapshot_finish(&snapshot);
    }
    end(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_have_what_catchers_of_files_get),
        cmocka_unit_test(exports_have_them_too),
        cmocka_unit_test(guides_are_switched_on_and_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
