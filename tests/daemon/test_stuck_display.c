/* The daemon's end while a USB display hangs: in a push, in one that cannot even be cancelled, and
 * while it is opened. The daemon is this program again, with the display in place of libusb's (see
 * wrap_test_stuck_display). Every case would wait for ever, and fail by that, if the daemon waited
 * for the display. */
#include "tests/daemon/live.h"

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server/server.h"
#include "device/model/usb_model.h"
#include "device/usb/gud.h"

enum { WIDTH = 96, HEIGHT = 128 };

typedef enum manner {
    HEALTHY,
    HANGS, /* a transfer ends when it is cancelled, or with its time-out, and begins again */
    DEAF,  /* a transfer never ends, cancelled or not: a driver at fault */
    MUTE,  /* answers no question */
} manner;

/* ------------------------------------------------------------------------------- the display -- */

static manner how; /* set before the server's first thread starts */

typedef struct display {
    lf_usb_link base;
    lf_model_gud *gud;
    lf_usb_link *inner;
} display;

static display *display_of(lf_usb_link *link)
{
    return (display *)(void *)link;
}

static void sleep_for_ever(void)
{
    for (;;)
        pause();
}

static lf_usb_result display_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                     uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    display *d = display_of(link);
    if (how == MUTE) {
        lf_log(LF_LOG_WARNING, "the display hangs");
        sleep_for_ever();
    }
    return d->inner->ops->control(d->inner, in, request, value, data, n, out_n, timeout_ms);
}

static void display_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    display *d = display_of(link);
    d->inner->ops->bulk_begin(d->inner, data, n);
}

static lf_usb_result display_bulk_end(lf_usb_link *link, int timeout_ms)
{
    display *d = display_of(link);
    if (how == HANGS || how == DEAF)
        lf_log(LF_LOG_WARNING, "the display hangs");
    if (how == DEAF)
        sleep_for_ever();
    /* the model takes none of them when it HANGS: only a cancel ends this one before its day is
     * over */
    return d->inner->ops->bulk_end(d->inner, how == HANGS ? 24 * 3600 * 1000 : timeout_ms);
}

static void display_cancel(lf_usb_link *link)
{
    display *d = display_of(link);
    d->inner->ops->cancel(d->inner);
}

static void display_close(lf_usb_link *link)
{
    display *d = display_of(link);
    d->inner->ops->close(d->inner);
    lf_model_gud_destroy(d->gud);
    lf_free(d);
}

int __wrap_lf_usb_list(lf_usb_place *out, int max);
int __wrap_lf_usb_list(lf_usb_place *out, int max)
{
    (void)out;
    (void)max;
    return 0;
}

lf_status __wrap_lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                             lf_error *err);
lf_status __wrap_lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                             lf_error *err)
{
    static const lf_usb_link_ops ops = {display_control, display_bulk_begin, display_bulk_end,
                                        display_cancel, display_close};
    static const uint8_t rgb888 = LF_GUD_RGB888;
    const lf_model_gud_options options = {
        .width = WIDTH, .height = HEIGHT, .formats = &rgb888, .n_formats = 1};
    const lf_model_gud_faults faults = {.hang_every = how == HANGS};
    display *d = lf_calloc(1, sizeof *d);
    (void)address;
    (void)err;
    if (!d || lf_model_gud_create(&options, &faults, &d->gud) != LF_OK ||
        !(d->inner = lf_usb_model_open(d->gud)))
        abort();
    d->base.ops = &ops;
    *out_place = (lf_usb_place){.address = "1-1", .endpoint = 2};
    *out_link = &d->base;
    return LF_OK;
}

/* -------------------------------------------------------------------------------- the daemon -- */

/* args: what start gives. */
static int run_server(char *args[])
{
    lf_server_config config = {.scene = args[2],
                               .socket = args[3],
                               .device = "usb",
                               .export_dir = args[4],
                               .calibration = args[5]};
    how = (manner)(args[1][0] - '0');
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_button_actions_default(&config.buttons);
    config.options.view_width = 24;
    config.options.view_height = 32;
    config.options.threads = 2;
    return lf_server_run(&config);
}

static void start(live *l, manner ill)
{
    char number[2] = {(char)('0' + ill), 0}, calibration[PATH_MAX];
    live_prepare(l);
    snprintf(calibration, sizeof calibration, "%s/sim/calibration.json", l->folder);
    char *args[] = {(char *)(uintptr_t) "/proc/self/exe",
                    number,
                    l->scene,
                    l->socket,
                    l->exports,
                    calibration,
                    NULL};
    l->pid = live_spawn(l, args);
}

static void wait_until_it_hangs(const live *l)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++) {
        if (live_logged(l, "the display hangs"))
            return;
        live_nap(20);
    }
    live_show_log(l);
    fail_msg("the display was not asked for anything");
}

/* Commands are answered meanwhile; then the end, by a signal or a command. */
static void end_while_it_hangs(manner ill, bool by_signal)
{
    live l;
    live_client c;
    start(&l, ill);
    live_connect(&l, &c);
    wait_until_it_hangs(&l);
    assert_string_not_equal(live_status_text(&c, "state"), "");
    if (by_signal)
        kill(l.pid, SIGTERM);
    else
        assert_int_equal(live_code(&c, "shutdown", NULL), 0);
    int code = live_reap(l.pid);
    l.pid = 0;
    if (code != 0)
        live_show_log(&l);
    assert_int_equal(code, 0);
    assert_int_not_equal(access(l.socket, F_OK), 0);
    live_close(&c);
    live_finish(&l);
}

static void a_display_that_hangs_in_a_push_does_not_hold_up_the_end(void **state)
{
    (void)state;
    end_while_it_hangs(HANGS, true);
    end_while_it_hangs(HANGS, false);
}

static void a_driver_that_cannot_be_interrupted_does_not_hold_up_the_end(void **state)
{
    (void)state;
    end_while_it_hangs(DEAF, true);
    end_while_it_hangs(DEAF, false);
}

static void a_display_that_hangs_while_it_is_opened_does_not_hold_up_the_end(void **state)
{
    (void)state;
    end_while_it_hangs(MUTE, true);
    end_while_it_hangs(MUTE, false);
}

/* Loads wait for the display, for ten seconds. The patch comes after them. */
static void what_waits_for_the_display_can_be_cancelled(void **state)
{
    (void)state;
    live l;
    live_client c;
    start(&l, MUTE);
    lf_test_write(l.folder, "scene/other.json", LIVE_SCENE);
    live_connect(&l, &c);
    wait_until_it_hangs(&l);
    json_t *entries = json_pack("{s:[{s:s, s:i}]}", "entries", "file", "other.json", "seconds", 9);
    assert_int_equal(live_code(&c, "playlist.set", entries), 0);
    assert_int_equal(live_code(&c, "playlist.play", NULL), 0);
    assert_int_equal(live_code(&c, "playlist.stop", NULL), 0);
    json_t *patch = json_pack("{s:{s:{s:i}}}", "patch", "camera", "fov_y", 20);
    assert_int_equal(live_code(&c, "scene.patch", patch), 0);
    assert_string_equal(live_status_text(&c, "scene"), l.scene);
    live_close(&c);
    live_finish(&l);
}

/* The rest of the file can show a picture, and a panel that is well leaves nothing to the kernel.
 */
static void a_healthy_display_is_shown_on_and_given_back(void **state)
{
    (void)state;
    live l;
    live_client c;
    start(&l, HEALTHY);
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_false(live_logged(&l, "the display hangs"));
    live_close(&c);
    live_finish(&l);
}

int main(int argc, char *argv[])
{
    if (argc > 1)
        return run_server(argv);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_display_that_hangs_in_a_push_does_not_hold_up_the_end),
        cmocka_unit_test(a_driver_that_cannot_be_interrupted_does_not_hold_up_the_end),
        cmocka_unit_test(a_display_that_hangs_while_it_is_opened_does_not_hold_up_the_end),
        cmocka_unit_test(what_waits_for_the_display_can_be_cancelled),
        cmocka_unit_test(a_healthy_display_is_shown_on_and_given_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
