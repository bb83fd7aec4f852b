/* A panel kept alive, with a device, buttons and a list of the test's own (tests/module.mk wraps
 * what would look for real ones): the events of show.h in their order. */
#include "tests/testing.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>

#include "base/alloc.h"
#include "base/wakeup.h"
#include "daemon/show/opener.h"
#include "daemon/show/show.h"
#include "device/find/find.h"

enum { WIDTH = 8, HEIGHT = 4, WAIT_S = 60 };

/* ------------------------------------------------------------------------------ the hardware -- */

#define SPEC "usb:1-1"

typedef struct panel {
    lf_device base;
    lf_calibration calibration;
    int wakeup, pushes;
    bool gone, busy, done, whole; /* whole: the last push was */
    uint64_t generation;
} panel;

struct lf_buttons {
    int wakeup;
};

/* Openers make them, on threads of theirs; the test looks when it was told of it. */
static _Atomic(panel *) opened_panel;
static _Atomic(lf_buttons *) opened_buttons;
static atomic_int lens;
static atomic_bool pressed;

static panel *panel_of(const lf_device *device)
{
    return (panel *)(void *)(uintptr_t)device;
}

static void panel_destroy(lf_device *device)
{
    close(panel_of(device)->wakeup);
    lf_free(device);
}

static void panel_info(const lf_device *device, lf_device_info *out)
{
    (void)device;
    *out = (lf_device_info){.spec = SPEC, .kind = "usb", .model = "the test's"};
}

static const lf_calibration *panel_calibration(const lf_device *device)
{
    return &panel_of(device)->calibration;
}

static lf_status panel_push(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                            uint64_t generation)
{
    panel *p = panel_of(device);
    assert_false(p->busy);
    p->whole = n == 1 && rects->width == frame->width && rects->height == frame->height;
    p->busy = true;
    p->pushes++;
    p->generation = generation;
    return LF_OK;
}

static int panel_poll_fd(const lf_device *device)
{
    return panel_of(device)->wakeup;
}

static lf_device_event panel_dispatch(lf_device *device)
{
    panel *p = panel_of(device);
    lf_wakeup_clear(p->wakeup);
    if (p->gone)
        return LF_DEVICE_GONE;
    p->busy = p->busy && !p->done;
    p->done = false;
    return p->busy ? LF_DEVICE_BUSY : LF_DEVICE_READY;
}

static void panel_counters(const lf_device *device, lf_device_counters *out)
{
    *out = (lf_device_counters){.updates = (uint64_t)panel_of(device)->pushes};
}

static lf_status panel_flush(lf_device *device, int timeout_ms)
{
    (void)timeout_ms;
    panel_of(device)->done = true;
    return LF_OK;
}

static const lf_device_ops panel_ops = {.kind = "usb",
                                        .is_panel = true,
                                        .is_hardware = true,
                                        .destroy = panel_destroy,
                                        .info = panel_info,
                                        .calibration = panel_calibration,
                                        .push = panel_push,
                                        .poll_fd = panel_poll_fd,
                                        .dispatch = panel_dispatch,
                                        .counters = panel_counters,
                                        .flush = panel_flush};

lf_status __wrap_lf_device_open(const char *spec, const lf_calibration *calibration,
                                lf_device **out_device, lf_error *err);
lf_status __wrap_lf_device_open(const char *spec, const lf_calibration *calibration,
                                lf_device **out_device, lf_error *err)
{
    assert_null(calibration);
    if (strcmp(spec, SPEC) != 0)
        return lf_error_set(err, LF_E_IO, spec, "broken");
    panel *p = lf_calloc(1, sizeof *p);
    *p = (panel){.base = {&panel_ops}, .wakeup = lf_wakeup_make()};
    lf_calibration_portrait(&p->calibration);
    p->calibration.screen_width_px = WIDTH;
    p->calibration.screen_height_px = HEIGHT;
    p->calibration.center = 0.125 * lens;
    opened_panel = p;
    *out_device = &p->base;
    return LF_OK;
}

int __wrap_lf_find_hid(lf_found *out, int max);
int __wrap_lf_find_hid(lf_found *out, int max)
{
    assert_true(max > 0);
    *out = (lf_found){.path = "the test's"};
    lf_calibration_portrait(&out->calibration);
    return 1;
}

int __wrap_lf_find_all(lf_found *out, int max);
int __wrap_lf_find_all(lf_found *out, int max)
{
    return __wrap_lf_find_hid(out, max);
}

lf_status __wrap_lf_buttons_open(const char *path, lf_buttons **out, lf_error *err);
lf_status __wrap_lf_buttons_open(const char *path, lf_buttons **out, lf_error *err)
{
    (void)path, (void)err;
    *out = lf_calloc(1, sizeof **out);
    (*out)->wakeup = lf_wakeup_make();
    opened_buttons = *out; /* then it looks, as press stores and then looks here */
    if (pressed)
        lf_wakeup_signal((*out)->wakeup);
    return LF_OK;
}

void __wrap_lf_buttons_destroy(lf_buttons *buttons);
void __wrap_lf_buttons_destroy(lf_buttons *buttons)
{
    if (buttons)
        close(buttons->wakeup);
    lf_free(buttons);
}

int __wrap_lf_buttons_poll_fd(const lf_buttons *buttons);
int __wrap_lf_buttons_poll_fd(const lf_buttons *buttons)
{
    return buttons->wakeup;
}

lf_buttons_event __wrap_lf_buttons_next(lf_buttons *buttons, lf_button *out_button);
lf_buttons_event __wrap_lf_buttons_next(lf_buttons *buttons, lf_button *out_button)
{
    lf_wakeup_clear(buttons->wakeup);
    *out_button = LF_BUTTON_LEFT;
    return atomic_exchange(&pressed, false) ? LF_BUTTONS_PRESSED : LF_BUTTONS_NOTHING;
}

/* Where listing waits until its thread is joined. */
static struct {
    atomic_bool wanted, on;
    pthread_t thread;
    sem_t begun, may_end;
} hold;

int __wrap_lf_device_list(lf_device_info *out, int max);
int __wrap_lf_device_list(lf_device_info *out, int max)
{
    assert_true(max > 1);
    out[0] = (lf_device_info){.spec = SPEC, .model = "as others see it"};
    out[1] = (lf_device_info){.spec = "none"};
    if (hold.wanted) {
        hold.thread = pthread_self();
        hold.on = true;
        sem_post(&hold.begun);
        sem_wait(&hold.may_end);
        hold.on = false;
    }
    return 2;
}

int __real_pthread_join(pthread_t thread, void **out);
int __wrap_pthread_join(pthread_t thread, void **out);
int __wrap_pthread_join(pthread_t thread, void **out)
{
    if (hold.on && pthread_equal(thread, hold.thread))
        sem_post(&hold.may_end);
    return __real_pthread_join(thread, out);
}

/* --------------------------------------------------------------------------------- the owner -- */

static pthread_t main_thread;

/* Answers. */
static char it[] = "it", that[] = "that", them[] = "them", first[] = "first", second[] = "second";

typedef struct owner {
    sd_event *event;
    lf_inbox inbox;
    lf_mailbox *mailbox;
    int posted; /* borrowed by the mailbox */
    lf_show *show;
    char told[1024]; /* a word or two an event, a comma behind each */
    uint64_t number; /* of the panel, from the last lens */
} owner;

__attribute__((format(printf, 2, 3))) static void tell(owner *o, const char *format, ...)
{
    va_list args;
    size_t used = strlen(o->told);
    va_start(args, format);
    vsnprintf(o->told + used, sizeof o->told - used, format, args);
    va_end(args);
}

static void on_opened(void *context, void *answer, const lf_error *err)
{
    tell(context, "opened %s %s, ", (const char *)answer, err ? lf_status_name(err->status) : "ok");
}

static void on_listed(void *context, void *answer, const lf_device_info *devices, int n,
                      const lf_error *err)
{
    tell(context, "listed %s %d %s, ", (const char *)answer, n,
         err ? lf_status_name(err->status) : devices->model);
}

static atomic_int n_looks;

/* On the thread that has searched. */
static void look(void *answer, const lf_device_info *devices, int n_devices, const lf_found *found,
                 int n_found)
{
    assert_string_equal(answer, "first");
    assert_int_equal(n_devices, 2);
    assert_string_equal(devices->model, "as others see it");
    assert_int_equal(n_found, 1);
    assert_string_equal(found->path, "the test's");
    assert_false(pthread_equal(pthread_self(), main_thread));
    n_looks++;
}

static void on_examined(void *context, void *answer, const lf_error *err)
{
    tell(context, "examined %s %s, ", (const char *)answer,
         err ? lf_status_name(err->status) : "ok");
}

static void on_changed(void *context)
{
    owner *o = context;
    lf_device_info info;
    bool there = lf_show_info(o->show, &info);
    tell(o, "changed %s, ", there ? info.model : info.problem);
}

static void on_lens(void *context, const lf_calibration *calibration, uint64_t number, bool views,
                    bool is_new)
{
    owner *o = context;
    assert_false(views);
    assert_memory_equal(calibration, lf_show_calibration(o->show), sizeof *calibration);
    o->number = number;
    tell(o, "lens %g%s, ", calibration->center, is_new ? " new" : "");
}

static void on_shown(void *context, const lf_shown *shown)
{
    assert_int_equal(shown->level, LF_LEVEL_COMPLETE);
    assert_true(shown->passes == 0.5 * (double)shown->generation);
    assert_int_equal(shown->reconstructed, shown->generation == 8);
    tell(context, "shown %d, ", (int)shown->generation);
}

static void on_pressed(void *context, lf_button button)
{
    tell(context, "pressed %s, ", lf_button_name(button));
}

static int on_inbox(sd_event_source *source, int fd, uint32_t events, void *context)
{
    owner *o = context;
    (void)source, (void)fd, (void)events;
    lf_inbox_read(&o->inbox, NULL);
    return 0;
}

static int set_up(void **state)
{
    static const lf_show_events events = {.opened = on_opened,
                                          .listed = on_listed,
                                          .examined = on_examined,
                                          .changed = on_changed,
                                          .lens = on_lens,
                                          .shown = on_shown,
                                          .pressed = on_pressed};
    owner *o = calloc(1, sizeof *o);
    assert_non_null(o);
    o->posted = lf_wakeup_make();
    lf_assert_ok(lf_mailbox_create(o->posted, &o->mailbox), NULL);
    lf_assert_ok(lf_inbox_init(&o->inbox), NULL);
    assert_true(sd_event_new(&o->event) >= 0);
    assert_true(sd_event_add_io(o->event, NULL, o->inbox.event_fd, 1, on_inbox, o) >= 0);
    const lf_show_home home = {o->event, &o->inbox, o->mailbox, NULL};
    lf_assert_ok(lf_show_create(&home, &events, o, &o->show), NULL);
    lens = 1;
    opened_buttons = NULL;
    *state = o;
    return 0;
}

/* Ends the show; what it still had to tell is told. */
static void end_show(owner *o)
{
    lf_show_end(o->show);
    lf_inbox_read(&o->inbox, NULL);
}

static int tear_down(void **state)
{
    owner *o = *state;
    end_show(o);
    lf_inbox_finish(&o->inbox, NULL);
    lf_show_destroy(o->show);
    lf_mailbox_destroy(o->mailbox);
    sd_event_unref(o->event);
    close(o->posted);
    free(o);
    return 0;
}

/* Runs the loop until so much was told, and forgets it. */
static void await(owner *o, const char *expected)
{
    for (int i = 0; strlen(o->told) < strlen(expected) && i < WAIT_S; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_string_equal(o->told, expected);
    o->told[0] = '\0';
}

static void open_panel(owner *o)
{
    lf_assert_ok(lf_show_open(o->show, SPEC, it, NULL), NULL);
}

static void post_frame(owner *o, int64_t generation)
{
    lf_frame *frame = lf_mailbox_begin(o->mailbox, WIDTH, HEIGHT);
    assert_non_null(frame);
    memset(frame->image.data, (int)generation, HEIGHT * frame->image.stride);
    frame->generation = generation;
    frame->level = LF_LEVEL_COMPLETE;
    frame->passes = 0.5 * (double)generation;
    frame->reconstructed = generation == 8;
    frame->panel = o->number;
    lf_mailbox_post(o->mailbox, frame);
    lf_show_pump(o->show);
}

static void end_push(void)
{
    opened_panel->done = true;
    lf_wakeup_signal(opened_panel->wakeup);
}

/* Also before they are opened. */
static void press(void)
{
    pressed = true;
    lf_buttons *buttons = opened_buttons;
    if (buttons)
        lf_wakeup_signal(buttons->wakeup);
}

static void pull_out(void)
{
    opened_panel->gone = true;
    lf_wakeup_signal(opened_panel->wakeup);
}

/* --------------------------------------------------------------------------------- the facts -- */

static void a_panel_is_told_from_its_lens_to_its_buttons(void **state)
{
    owner *o = *state;
    lf_device_info info;
    assert_false(lf_show_info(o->show, &info));
    assert_null(lf_show_calibration(o->show));
    open_panel(o);
    await(o, "lens 0.125 new, changed the test's, opened it ok, ");
    post_frame(o, 7);
    assert_int_equal(opened_panel->pushes, 1);
    assert_true(opened_panel->whole);
    post_frame(o, 8);
    post_frame(o, 9); /* the newest wins */
    assert_int_equal(opened_panel->pushes, 1);
    end_push();
    await(o, "shown 7, ");
    assert_int_equal(opened_panel->generation, 9);
    end_push();
    await(o, "shown 9, ");
    assert_int_equal(lf_show_counters(o->show).updates, 2);
    press();
    await(o, "pressed left, ");
    lf_assert_ok(lf_show_list(o->show, them), NULL);
    await(o, "listed them 2 the test's, "); /* it is in use, and tells of itself */
}

static void a_panel_that_was_lost_comes_back_with_its_frame(void **state)
{
    owner *o = *state;
    open_panel(o);
    await(o, "lens 0.125 new, changed the test's, opened it ok, ");
    post_frame(o, 7);
    end_push();
    await(o, "shown 7, ");
    pull_out();
    await(o, "changed unplugged, ");
    assert_string_equal(lf_show_problem(o->show), "unplugged");
    assert_int_equal(lf_show_counters(o->show).updates, 1);
    await(o, "changed the test's, "); /* its lens is known, and nobody has asked for it */
    assert_null(lf_show_problem(o->show));
    assert_int_equal(opened_panel->pushes, 1);
    assert_true(opened_panel->whole);
    end_push();
    await(o, "shown 7, ");
    assert_int_equal(lf_show_counters(o->show).updates, 2);
}

static void another_lens_gets_no_frame_of_the_one_before(void **state)
{
    owner *o = *state;
    open_panel(o);
    await(o, "lens 0.125 new, changed the test's, opened it ok, ");
    post_frame(o, 7);
    end_push();
    await(o, "shown 7, ");
    lens = 2;
    pull_out();
    await(o, "changed unplugged, ");
    await(o, "lens 0.25 new, changed the test's, ");
    assert_int_equal(opened_panel->pushes, 0);
    post_frame(o, 8);
    end_push();
    await(o, "shown 8, ");
}

static void what_cannot_be_opened_leaves_the_panel_alone(void **state)
{
    owner *o = *state;
    open_panel(o);
    await(o, "lens 0.125 new, changed the test's, opened it ok, ");
    lf_assert_ok(lf_show_open(o->show, "sim:broken", that, NULL), NULL);
    await(o, "opened that LF_E_NODEV, ");
    assert_string_equal(lf_show_spec(o->show), SPEC);
    post_frame(o, 7);
    end_push();
    await(o, "shown 7, ");
}

/* One list is under way when the end comes; the next has not begun, as a device has not. */
static void what_the_end_drops_is_answered_as_cancelled(void **state)
{
    owner *o = *state;
    hold.wanted = true;
    lf_assert_ok(lf_show_list(o->show, first), NULL);
    sem_wait(&hold.begun);
    lf_assert_ok(lf_show_list(o->show, second), NULL);
    lf_show_stop(o->show);
    open_panel(o);
    end_show(o);
    hold.wanted = false;
    await(o, "opened it LF_E_CANCELLED, listed first 2 as others see it, "
             "listed second 0 LF_E_CANCELLED, ");
}

static void nothing_waits_for_an_examination(void **state)
{
    owner *o = *state;
    n_looks = 0;
    hold.wanted = true;
    lf_assert_ok(lf_show_examine(o->show, look, first), NULL);
    sem_wait(&hold.begun);
    hold.wanted = false;
    lf_assert_ok(lf_show_list(o->show, them), NULL);
    await(o, "listed them 2 as others see it, ");
    open_panel(o);
    await(o, "lens 0.125 new, changed the test's, opened it ok, ");
    assert_int_equal(n_looks, 0);
    sem_post(&hold.may_end);
    await(o, "examined first ok, ");
    assert_int_equal(n_looks, 1);
}

static void an_examination_that_the_end_drops_looks_at_nothing(void **state)
{
    owner *o = *state;
    n_looks = 0;
    hold.wanted = true;
    lf_assert_ok(lf_show_examine(o->show, look, first), NULL);
    sem_wait(&hold.begun);
    lf_assert_ok(lf_show_examine(o->show, look, second), NULL);
    lf_show_stop(o->show);
    end_show(o);
    hold.wanted = false;
    await(o, "examined first ok, examined second LF_E_CANCELLED, ");
    assert_int_equal(n_looks, 1);
}

int main(void)
{
    main_thread = pthread_self();
    sem_init(&hold.begun, 0, 0);
    sem_init(&hold.may_end, 0, 0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_panel_is_told_from_its_lens_to_its_buttons, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_panel_that_was_lost_comes_back_with_its_frame, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(another_lens_gets_no_frame_of_the_one_before, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(what_cannot_be_opened_leaves_the_panel_alone, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(nothing_waits_for_an_examination, set_up, tear_down),
        cmocka_unit_test_setup_teardown(an_examination_that_the_end_drops_looks_at_nothing, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(what_the_end_drops_is_answered_as_cancelled, set_up,
                                        tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
