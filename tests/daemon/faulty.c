#include "tests/daemon/faulty.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/hid/hid.h"
#include "device/model/usb_model.h"
#include "device/usb/gud.h"
#include "tests/scene_file.h"

#define WHERE "faulty panel"
#define SERIAL "LKG-FAULTY-1"

enum { EDID_BYTES = 128, NAP_MS = 5 };

static const char *const names[LF_FAULTY_KINDS] = {
    "unplugged",     "refused", "stalled",        "errors of its own",
    "hung",          "slow",    "lied",           "garbage",
    "short",         "mute",    "EEPROM damaged", "stale replies",
    "button floods",
};

/* The plug that both sides of the panel share. */
static struct {
    pthread_mutex_t lock;
    const char *calibration;
    /* under lock */
    lf_faulty_orders *orders;
    uint64_t random;
    bool was_sick;
    uint64_t epoch;     /* rises when it is pulled out: what was opened before is gone for ever */
    double out_at;      /* lf_time_now when it will be … */
    double in_at;       /* … and when it is back */
    bool display_taken; /* by a link that is open */
} plug = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* A thing on the plug. */
typedef struct opened {
    uint64_t epoch;
    bool sick;
} opened;

const char *lf_faulty_name(lf_faulty_kind kind)
{
    return names[kind];
}

/* ------------------------------------------------------------------------------------ chance -- */

static uint64_t draw_locked(void)
{
    plug.random ^= plug.random << 13;
    plug.random ^= plug.random >> 7;
    plug.random ^= plug.random << 17;
    return plug.random >> 11;
}

/* 0..n-1 */
static unsigned draw(unsigned n)
{
    pthread_mutex_lock(&plug.lock);
    unsigned drawn = (unsigned)(draw_locked() % n);
    pthread_mutex_unlock(&plug.lock);
    return drawn;
}

static void count(lf_faulty_kind kind)
{
    atomic_fetch_add(&plug.orders->struck[kind], 1);
}

static void nap(int ms)
{
    poll(NULL, 0, ms);
}

/* -------------------------------------------------------------------------------------- plug -- */

void lf_faulty_use(lf_faulty_orders *orders)
{
    plug.orders = orders;
    plug.calibration = lf_test_scene_patched(
        "panel", "{'serial': '" SERIAL "', 'screenW': {'value': 192}, 'screenH': {'value': 256}}");
    plug.random = orders->seed * UINT64_C(0x9e3779b97f4a7c15) | 1;
    plug.was_sick = atomic_load(&orders->sick);
    plug.epoch = 1;
}

static void pull_out_locked(double now, double away)
{
    plug.epoch++;
    plug.in_at = now + away;
    plug.out_at = plug.in_at + 0.2 + 5e-3 * (double)(draw_locked() % 1000);
}

/* Whether the panel is there now. */
static bool is_in_locked(void)
{
    double now = lf_time_now();
    bool sick = atomic_load(&plug.orders->sick);
    if (sick != plug.was_sick) {
        plug.was_sick = sick;
        pull_out_locked(now, 0);
    } else if (sick && now >= plug.out_at) {
        pull_out_locked(now, 1e-3 * (double)(draw_locked() % 500));
        count(LF_FAULTY_UNPLUG);
    }
    return now >= plug.in_at;
}

static bool is_in(opened *out)
{
    pthread_mutex_lock(&plug.lock);
    bool in = is_in_locked();
    *out = (opened){.epoch = plug.epoch, .sick = plug.was_sick};
    pthread_mutex_unlock(&plug.lock);
    return in;
}

static bool is_gone(const opened *o)
{
    pthread_mutex_lock(&plug.lock);
    bool gone = !is_in_locked() || plug.epoch != o->epoch;
    pthread_mutex_unlock(&plug.lock);
    return gone;
}

/* ----------------------------------------------------------------------------------- display -- */

typedef struct display {
    lf_usb_link base;
    opened on;
    lf_faulty_kind illness; /* LF_FAULTY_UNPLUG: nothing but that */
    lf_model_gud *gud;
    lf_usb_link *inner;
    atomic_bool cancelled;
} display;

static display *display_of(lf_usb_link *link)
{
    return (display *)(void *)link;
}

/* Whether an answer of a display with this illness goes wrong. */
static bool strikes(const display *d, lf_faulty_kind illness)
{
    if (d->illness != illness || draw(4) != 0)
        return false;
    count(illness);
    return true;
}

/* A question that is never answered. */
static lf_usb_result silence(display *d, int timeout_ms)
{
    double end = lf_time_now() + 1e-3 * timeout_ms;
    while (lf_time_now() < end) {
        if (atomic_load(&d->cancelled))
            return LF_USB_CANCELLED;
        if (is_gone(&d->on))
            return LF_USB_GONE;
        nap(NAP_MS);
    }
    return LF_USB_TIMEOUT;
}

static lf_usb_result display_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                     uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    display *d = display_of(link);
    size_t moved = 0;
    lf_usb_result result = LF_USB_GONE;
    if (strikes(d, LF_FAULTY_MUTE))
        result = silence(d, timeout_ms);
    else if (!is_gone(&d->on))
        result = d->inner->ops->control(d->inner, in, request, value, data, n, &moved, timeout_ms);
    if (result == LF_USB_STALL)
        count(LF_FAULTY_STALL);
    if (in && moved > 0 && strikes(d, LF_FAULTY_SHORT))
        moved = draw((unsigned)moved);
    if (in && moved > 0 && strikes(d, LF_FAULTY_GARBAGE))
        for (size_t i = draw((unsigned)moved); i < moved; i++)
            data[i] = (uint8_t)draw(256);
    if (out_n)
        *out_n = moved;
    return result;
}

static void display_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    display *d = display_of(link);
    d->inner->ops->bulk_begin(d->inner, data, n);
}

static lf_usb_result display_bulk_end(lf_usb_link *link, int timeout_ms)
{
    display *d = display_of(link);
    lf_usb_result result = d->inner->ops->bulk_end(d->inner, timeout_ms);
    if (result == LF_USB_STALL)
        count(LF_FAULTY_STALL);
    else if (d->illness == LF_FAULTY_HANG && result != LF_USB_OK)
        count(LF_FAULTY_HANG);
    if (is_gone(&d->on))
        return LF_USB_GONE;
    if (result == LF_USB_OK)
        atomic_fetch_add(&plug.orders->rects, 1);
    return result;
}

static void display_cancel(lf_usb_link *link)
{
    display *d = display_of(link);
    atomic_store(&d->cancelled, true);
    d->inner->ops->cancel(d->inner);
}

static void display_close(lf_usb_link *link)
{
    display *d = display_of(link);
    if (d->inner)
        d->inner->ops->close(d->inner);
    lf_model_gud_destroy(d->gud);
    lf_free(d);
    pthread_mutex_lock(&plug.lock);
    plug.display_taken = false;
    pthread_mutex_unlock(&plug.lock);
}

static const lf_usb_link_ops display_ops = {
    .control = display_control,
    .bulk_begin = display_bulk_begin,
    .bulk_end = display_bulk_end,
    .cancel = display_cancel,
    .close = display_close,
};

/* Faults that the model has by itself. */
static lf_model_gud_faults model_faults(lf_faulty_kind illness)
{
    lf_model_gud_faults f = {0};
    switch (illness) {
    case LF_FAULTY_STALL:
        f.fail_every = 2 + draw(12);
        break;
    case LF_FAULTY_STATUS:
        f.stall_every = 2 + draw(8);
        count(illness);
        break;
    case LF_FAULTY_HANG:
        f.hang_every = 2 + draw(8);
        break;
    case LF_FAULTY_SLOW:
        f.bytes_per_s = 20000 + draw(1000000);
        count(illness);
        break;
    case LF_FAULTY_LIE:
        f.fault = 1 + (int)draw(LF_GUD_FAULTS - 1);
        count(illness);
        break;
    default:
        break;
    }
    return f;
}

static lf_status make_model(display *d)
{
    static const uint8_t formats[] = {LF_GUD_RGB888, LF_GUD_XRGB8888, LF_GUD_RGB565};
    uint8_t edid[EDID_BYTES];
    lf_model_edid("LKG-FAULTY", "1", LF_FAULTY_WIDTH, LF_FAULTY_HEIGHT, edid);
    lf_model_gud_options o = {
        .width = LF_FAULTY_WIDTH,
        .height = LF_FAULTY_HEIGHT,
        .formats = &formats[draw(3)],
        .n_formats = 1,
        .lz4 = draw(2) == 0,
        .status_on_set = draw(2) == 0,
        .edid = edid,
        .n_edid = sizeof edid,
        .max_buffer_size = draw(2) == 0 ? 0 : LF_FAULTY_WIDTH * 4 * (1 + draw(64)),
    };
    if (draw(8) == 0) {
        o.full_update = true;
        o.lz4 = false;
        o.max_buffer_size = 0;
    }
    lf_model_gud_faults faults = model_faults(d->illness);
    return lf_model_gud_create(&o, &faults, &d->gud);
}

static lf_faulty_kind draw_display_illness(const opened *on)
{
    static const lf_faulty_kind illnesses[] = {
        LF_FAULTY_UNPLUG,  LF_FAULTY_STALL, LF_FAULTY_STATUS, LF_FAULTY_HANG,
        LF_FAULTY_SLOW,    LF_FAULTY_SLOW,  LF_FAULTY_LIE,    LF_FAULTY_LIE,
        LF_FAULTY_GARBAGE, LF_FAULTY_SHORT, LF_FAULTY_MUTE,
    };
    return on->sick ? illnesses[draw(sizeof illnesses / sizeof *illnesses)] : LF_FAULTY_UNPLUG;
}

/* The plug's for one link at a time. */
static bool take_display(void)
{
    pthread_mutex_lock(&plug.lock);
    bool taken = !plug.display_taken;
    plug.display_taken = true;
    pthread_mutex_unlock(&plug.lock);
    return taken;
}

static void fill_place(lf_usb_place *out)
{
    *out = (lf_usb_place){.address = "1-1",
                          .product = "HoloPlay",
                          .vendor_id = 0x04d8,
                          .product_id = 0xef7e,
                          .endpoint = 2};
}

int __wrap_lf_usb_list(lf_usb_place *out, int max);
int __wrap_lf_usb_list(lf_usb_place *out, int max)
{
    opened on;
    if (max < 1 || !is_in(&on))
        return 0;
    fill_place(out);
    return 1;
}

lf_status __wrap_lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                             lf_error *err);
lf_status __wrap_lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                             lf_error *err)
{
    opened on;
    if (!is_in(&on) || (address[0] != 0 && strcmp(address, "1-1") != 0))
        return lf_error_set(err, LF_E_NODEV, WHERE, "is not plugged in");
    if (on.sick && draw(16) == 0) {
        count(LF_FAULTY_REFUSED);
        return lf_error_set(err, LF_E_IO, WHERE, "no permission");
    }
    display *d = lf_calloc(1, sizeof *d);
    if (!d)
        return lf_error_set(err, LF_E_NOMEM, WHERE, "out of memory");
    if (!take_display()) {
        lf_free(d);
        return lf_error_set(err, LF_E_BUSY, WHERE, "another program has it");
    }
    d->base.ops = &display_ops;
    d->on = on;
    d->illness = draw_display_illness(&on);
    d->inner = make_model(d) == LF_OK ? lf_usb_model_open(d->gud) : NULL;
    if (!d->inner) {
        display_close(&d->base);
        return lf_error_set(err, LF_E_NOMEM, WHERE, "out of memory");
    }
    atomic_fetch_add(&plug.orders->opened, 1);
    fill_place(out_place);
    *out_link = &d->base;
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- HID side -- */

typedef struct side {
    opened on;
    bool flood;
    lf_model_hid *model;
} side;

static int side_send(void *context, const uint8_t *report, size_t n)
{
    side *s = context;
    if (is_gone(&s->on))
        return -1;
    uint64_t before = lf_model_hid_violations(s->model);
    int answer = lf_model_hid_feature(s->model, report + 1, n - 1);
    atomic_fetch_add(&plug.orders->pages, 1);
    atomic_fetch_add(&plug.orders->violations, lf_model_hid_violations(s->model) - before);
    if (answer < 0) {
        count(LF_FAULTY_STALL);
        return -1;
    }
    return (int)n;
}

static int side_read(void *context, uint8_t *out, size_t max, int timeout_ms)
{
    side *s = context;
    double end = lf_time_now() + 1e-3 * timeout_ms;
    for (;;) {
        if (is_gone(&s->on))
            return -1;
        int n = lf_model_hid_input(s->model, out, max);
        if (n > 0)
            return n;
        if (lf_time_now() >= end)
            return 0;
        nap(1);
        if (s->flood) {
            lf_model_hid_press(s->model, (uint8_t)draw(256));
            atomic_fetch_add(&plug.orders->presses, 1);
        }
    }
}

static uint64_t side_now(void *context)
{
    (void)context;
    return (uint64_t)(lf_time_now() * 1e3);
}

static void side_close(void *context)
{
    side *s = context;
    lf_model_hid_destroy(s->model);
    lf_free(s);
}

/* What an EEPROM says in place of a calibration. */
static size_t damage(uint8_t *eeprom, size_t n)
{
    static const char *const texts[] = {
        "{\"serial\":\"" SERIAL
        "\",\"pitch\":{\"value\":1e308},\"slope\":{\"value\":0},\"screenW\":{\"value\":1e9}}",
        "{\"serial\":\"" SERIAL
        "\",\"pitch\":{\"value\":NaN},\"screenW\":{\"value\":192},\"screenH\":{\"value\":256}}",
        "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
        "",
    };
    count(LF_FAULTY_EEPROM);
    unsigned way = draw(7);
    if (way < 4)
        return lf_model_hid_eeprom(texts[way], strlen(texts[way]), eeprom, LF_MODEL_EEPROM_MAX);
    if (way == 4) /* blank */
        memset(eeprom, 0xff, n);
    else if (way == 5) /* a length that no EEPROM has */
        eeprom[0] = 0x7f;
    else
        for (unsigned i = 1 + draw(20); i > 0; i--)
            eeprom[4 + draw((unsigned)n - 4)] = (uint8_t)draw(256);
    return n;
}

static lf_model_hid_faults side_faults(lf_faulty_kind illness)
{
    lf_model_hid_faults f = {.split = draw(2) == 0};
    switch (illness) {
    case LF_FAULTY_STALE:
        f.stale = 1 + (int)draw(70);
        f.press_every = 1 + (int)draw(3);
        f.wrong_echo = draw(3) == 0;
        count(illness);
        break;
    case LF_FAULTY_STALL:
        f.stall_every = 1 + (int)draw(5);
        break;
    case LF_FAULTY_SHORT:
        f.short_every = 1 + (int)draw(5);
        count(illness);
        break;
    case LF_FAULTY_MUTE:
        f.mute_every = 1 + (int)draw(8);
        count(illness);
        break;
    default:
        break;
    }
    return f;
}

static lf_faulty_kind draw_side_illness(const opened *on)
{
    static const lf_faulty_kind illnesses[] = {
        LF_FAULTY_UNPLUG, LF_FAULTY_UNPLUG, LF_FAULTY_UNPLUG, LF_FAULTY_UNPLUG,
        LF_FAULTY_FLOOD,  LF_FAULTY_FLOOD,  LF_FAULTY_STALE,  LF_FAULTY_STALL,
        LF_FAULTY_SHORT,  LF_FAULTY_MUTE,   LF_FAULTY_EEPROM,
    };
    return on->sick ? illnesses[draw(sizeof illnesses / sizeof *illnesses)] : LF_FAULTY_UNPLUG;
}

int __wrap_lf_hid_list(lf_hid_place *out, int max);
int __wrap_lf_hid_list(lf_hid_place *out, int max)
{
    opened on;
    if (max < 1 || !is_in(&on))
        return 0;
    *out = (lf_hid_place){.path = "/dev/hidraw-faulty", .product = "HoloPlay"};
    return 1;
}

lf_status __wrap_lf_hid_open(const char *path, lf_hid_link *out, lf_error *err);
lf_status __wrap_lf_hid_open(const char *path, lf_hid_link *out, lf_error *err)
{
    opened on;
    if (!is_in(&on))
        return lf_error_set(err, LF_E_NODEV, path, "is not there (any more)");
    if (on.sick && draw(16) == 0) {
        count(LF_FAULTY_REFUSED);
        return lf_error_set(err, LF_E_IO, path, "no permission");
    }
    uint8_t eeprom[LF_MODEL_EEPROM_MAX];
    lf_faulty_kind illness = draw_side_illness(&on);
    size_t n =
        lf_model_hid_eeprom(plug.calibration, strlen(plug.calibration), eeprom, sizeof eeprom);
    if (illness == LF_FAULTY_EEPROM)
        n = damage(eeprom, n);
    if (illness == LF_FAULTY_FLOOD)
        count(illness);
    lf_model_hid_faults faults = side_faults(illness);
    side *s = lf_calloc(1, sizeof *s);
    if (!s || lf_model_hid_create(eeprom, n, &faults, &s->model) != LF_OK) {
        lf_free(s);
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    s->on = on;
    s->flood = illness == LF_FAULTY_FLOOD;
    *out = (lf_hid_link){side_send, side_read, side_now, side_close, s};
    return LF_OK;
}
