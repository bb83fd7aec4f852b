/* Buttons: presses from reports, told once each, over the simulated panel. */
#include "tests/testing.h"

#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include "base/thread.h"
#include "device/hid/buttons_link.h"
#include "device/model/model.h"

enum { PATIENCE_MS = 20000 };

static void every_button_has_its_name(void **state)
{
    (void)state;
    assert_string_equal(lf_button_name(LF_BUTTON_SQUARE), "square");
    assert_string_equal(lf_button_name(LF_BUTTON_LEFT), "left");
    assert_string_equal(lf_button_name(LF_BUTTON_RIGHT), "right");
    assert_string_equal(lf_button_name(LF_BUTTON_CIRCLE), "circle");
}

static void a_press_is_told_once_and_again_after_release(void **state)
{
    (void)state;
    static const struct {
        uint8_t mask;
        unsigned pressed;
    } reports[] = {{0, 0}, {1, 1}, {1, 0},       {1, 0},    {3, 2},    {2, 0},
                   {3, 1}, {0, 0}, {0x0f, 0x0f}, {0x0f, 0}, {0xf0, 0}, {0xff, 15},
                   {0, 0}, {8, 8}, {4, 4},       {0x84, 0}};
    unsigned down = 0;
    for (size_t i = 0; i < sizeof reports / sizeof reports[0]; i++)
        assert_int_equal(lf_buttons_pressed(&down, reports[i].mask), reports[i].pressed);
}

/* The model behind a link that two threads use. */
typedef struct wire {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    lf_model_hid *model;
    bool unplugged;
    atomic_int n_closed;
    atomic_bool ended; /* the reader knows that it is unplugged */
} wire;

static int wire_send(void *context, const uint8_t *report, size_t n)
{
    (void)context;
    (void)report;
    (void)n;
    fail_msg("buttons send nothing");
    return -1;
}

static int wire_read(void *context, uint8_t *out, size_t max, int timeout_ms)
{
    wire *w = context;
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += timeout_ms * 1000000L;
    until.tv_sec += until.tv_nsec / 1000000000L;
    until.tv_nsec %= 1000000000L;
    pthread_mutex_lock(&w->lock);
    int n = lf_model_hid_input(w->model, out, max);
    if (n < 0 && !w->unplugged && pthread_cond_timedwait(&w->changed, &w->lock, &until) == 0)
        n = lf_model_hid_input(w->model, out, max);
    if (n < 0)
        n = w->unplugged ? -1 : 0;
    pthread_mutex_unlock(&w->lock);
    if (n < 0)
        atomic_store(&w->ended, true);
    return n;
}

static uint64_t wire_now(void *context)
{
    (void)context;
    return lf_time_now_ns() / LF_NS_PER_MS;
}

static void wire_close(void *context)
{
    wire *w = context;
    atomic_fetch_add(&w->n_closed, 1);
}

static lf_buttons *plug_in(wire *w, const lf_model_hid_faults *faults)
{
    static const pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    static const pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
    *w = (wire){.lock = lock, .changed = changed};
    lf_assert_ok(lf_model_hid_create(NULL, 0, faults, &w->model), NULL);
    lf_hid_link link = {wire_send, wire_read, wire_now, wire_close, w};
    lf_buttons *buttons = NULL;
    lf_assert_ok(lf_buttons_watch(&link, &buttons, NULL), NULL);
    return buttons;
}

static void unplug(wire *w, lf_buttons *buttons)
{
    lf_buttons_destroy(buttons);
    assert_int_equal(atomic_load(&w->n_closed), 1);
    lf_model_hid_destroy(w->model);
}

static void press(wire *w, uint8_t mask)
{
    pthread_mutex_lock(&w->lock);
    lf_model_hid_press(w->model, mask);
    pthread_cond_signal(&w->changed);
    pthread_mutex_unlock(&w->lock);
}

static bool rings(const lf_buttons *buttons, int timeout_ms)
{
    struct pollfd p = {.fd = lf_buttons_poll_fd(buttons), .events = POLLIN};
    return poll(&p, 1, timeout_ms) == 1;
}

static lf_button next_press(lf_buttons *buttons)
{
    lf_button button = LF_BUTTONS_N;
    assert_true(rings(buttons, PATIENCE_MS));
    assert_int_equal(lf_buttons_next(buttons, &button), LF_BUTTONS_PRESSED);
    return button;
}

static void assert_nothing(lf_buttons *buttons)
{
    lf_button button;
    assert_int_equal(lf_buttons_next(buttons, &button), LF_BUTTONS_NOTHING);
    assert_false(rings(buttons, 0));
}

static void presses_come_in_their_order(void **state)
{
    (void)state;
    wire w;
    const lf_model_hid_faults split = {.split = true};
    lf_buttons *buttons = plug_in(&w, &split);
    assert_nothing(buttons);
    press(&w, 1 << LF_BUTTON_RIGHT);
    assert_int_equal(next_press(buttons), LF_BUTTON_RIGHT);
    press(&w, 0);
    press(&w, 1 << LF_BUTTON_CIRCLE);
    press(&w, 1 << LF_BUTTON_CIRCLE);
    press(&w, 1 << LF_BUTTON_CIRCLE | 1 << LF_BUTTON_SQUARE);
    press(&w, 0);
    press(&w, 1 << LF_BUTTON_LEFT);
    assert_int_equal(next_press(buttons), LF_BUTTON_CIRCLE);
    assert_int_equal(next_press(buttons), LF_BUTTON_SQUARE);
    assert_int_equal(next_press(buttons), LF_BUTTON_LEFT);
    assert_nothing(buttons);
    unplug(&w, buttons);
}

static void the_bell_rings_until_the_last_press_is_taken(void **state)
{
    (void)state;
    wire w;
    lf_button button;
    lf_buttons *buttons = plug_in(&w, NULL);
    press(&w, 0x0f);
    for (int i = 0; i < LF_BUTTONS_N; i++) {
        assert_true(rings(buttons, i == 0 ? PATIENCE_MS : 0)); /* all four came in one report */
        assert_int_equal(lf_buttons_next(buttons, &button), LF_BUTTONS_PRESSED);
    }
    assert_nothing(buttons);
    unplug(&w, buttons);
}

static void replies_to_others_press_nothing(void **state)
{
    (void)state;
    wire w;
    lf_buttons *buttons = plug_in(&w, NULL);
    uint8_t request[LF_MODEL_FEATURE] = {0};
    for (int i = 0; i < 100; i++) {
        pthread_mutex_lock(&w.lock);
        assert_int_equal(lf_model_hid_feature(w.model, request, sizeof request), LF_MODEL_FEATURE);
        pthread_cond_signal(&w.changed);
        pthread_mutex_unlock(&w.lock);
    }
    while (pthread_mutex_lock(&w.lock) == 0) {
        uint8_t out[LF_MODEL_INPUT];
        bool drained = lf_model_hid_input(w.model, out, 0) < 0;
        pthread_mutex_unlock(&w.lock);
        if (drained)
            break;
    }
    press(&w, 1 << LF_BUTTON_LEFT);
    assert_int_equal(next_press(buttons), LF_BUTTON_LEFT);
    assert_nothing(buttons);
    unplug(&w, buttons);
}

static void a_flood_of_presses_is_bounded(void **state)
{
    (void)state;
    wire w;
    lf_buttons *buttons = plug_in(&w, NULL);
    for (int i = 0; i < 20000; i++)
        press(&w, i % 2 == 0 ? 0x0f : 0);
    pthread_mutex_lock(&w.lock);
    w.unplugged = true;
    pthread_cond_signal(&w.changed);
    pthread_mutex_unlock(&w.lock);
    while (!atomic_load(&w.ended))
        usleep(1000);
    /* Nobody has taken any so far: what was kept comes now, and then the end. */
    int kept = 0;
    lf_button button;
    for (lf_buttons_event event = LF_BUTTONS_NOTHING; event != LF_BUTTONS_GONE;) {
        assert_true(rings(buttons, PATIENCE_MS));
        event = lf_buttons_next(buttons, &button);
        kept += event == LF_BUTTONS_PRESSED;
    }
    assert_in_range(kept, 1, 32);
    unplug(&w, buttons);
}

static void unplugging_is_told_after_the_last_press_and_from_then_on(void **state)
{
    (void)state;
    wire w;
    lf_buttons *buttons = plug_in(&w, NULL);
    lf_button button;
    press(&w, 1 << LF_BUTTON_LEFT);
    pthread_mutex_lock(&w.lock);
    w.unplugged = true;
    pthread_cond_signal(&w.changed);
    pthread_mutex_unlock(&w.lock);
    assert_int_equal(next_press(buttons), LF_BUTTON_LEFT);
    for (int i = 0; i < 3; i++) {
        assert_true(rings(buttons, PATIENCE_MS));
        assert_int_equal(lf_buttons_next(buttons, &button), LF_BUTTONS_GONE);
    }
    unplug(&w, buttons);
}

static void what_is_no_panel_is_not_opened(void **state)
{
    (void)state;
    lf_buttons *buttons = NULL;
    lf_error err = {0};
    lf_assert_status(lf_buttons_open("/nonexistent/hidraw0", &buttons, &err), LF_E_NODEV, &err);
    lf_assert_status(lf_buttons_open("/dev/null", &buttons, &err), LF_E_IO, &err);
    assert_null(buttons);
    lf_buttons_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_button_has_its_name),
        cmocka_unit_test(a_press_is_told_once_and_again_after_release),
        cmocka_unit_test(presses_come_in_their_order),
        cmocka_unit_test(the_bell_rings_until_the_last_press_is_taken),
        cmocka_unit_test(replies_to_others_press_nothing),
        cmocka_unit_test(a_flood_of_presses_is_bounded),
        cmocka_unit_test(unplugging_is_told_after_the_last_press_and_from_then_on),
        cmocka_unit_test(what_is_no_panel_is_not_opened),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
