/* The thread reads reports and detects presses. They wait in a small ring; a descriptor is readable
 * while it is not empty. */
#include "device/hid/buttons.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "device/hid/buttons_link.h"

/* A person does not make more unread presses than this. */
#define MAX_WAITING 32
#define WAIT_MS 50
#define REST_MS 10

struct lf_buttons {
    lf_hid_link link; /* thread only, after its start */
    pthread_t thread;
    bool has_thread;
    atomic_bool stop;
    int wakeup; /* readable while a press waits, and permanently once the link is gone */
    pthread_mutex_t lock;
    /* under lock */
    lf_button waiting[MAX_WAITING];
    int first, n_waiting;
    bool gone;
};

const char *lf_button_name(lf_button button)
{
    static const char *const names[LF_BUTTONS_N] = {"square", "left", "right", "circle"};
    return names[button];
}

unsigned lf_buttons_pressed(unsigned *down, uint8_t mask)
{
    unsigned now = mask & ((1u << LF_BUTTONS_N) - 1), pressed = now & ~*down;
    *down = now;
    return pressed;
}

static void tell_pressed(lf_buttons *buttons, unsigned pressed)
{
    pthread_mutex_lock(&buttons->lock);
    for (int b = 0; b < LF_BUTTONS_N; b++)
        if ((pressed & 1u << b) != 0 && buttons->n_waiting < MAX_WAITING)
            buttons->waiting[(buttons->first + buttons->n_waiting++) % MAX_WAITING] = (lf_button)b;
    lf_wakeup_signal(buttons->wakeup);
    pthread_mutex_unlock(&buttons->lock);
}

static void tell_gone(lf_buttons *buttons)
{
    pthread_mutex_lock(&buttons->lock);
    buttons->gone = true;
    lf_wakeup_signal(buttons->wakeup);
    pthread_mutex_unlock(&buttons->lock);
}

static void *watch(void *data)
{
    lf_buttons *buttons = data;
    uint8_t report[LF_HID_REPORT];
    unsigned down = 0;
    while (!atomic_load_explicit(&buttons->stop, memory_order_relaxed)) {
        int got = lf_hid_read_report(&buttons->link, WAIT_MS, REST_MS, report);
        unsigned pressed = got > 0 ? lf_buttons_pressed(&down, report[0]) : 0;
        if (pressed != 0)
            tell_pressed(buttons, pressed);
        if (got < 0) {
            tell_gone(buttons);
            break;
        }
    }
    return NULL;
}

lf_status lf_buttons_watch(lf_hid_link *link, lf_buttons **out, lf_error *err)
{
    lf_buttons *buttons = lf_calloc(1, sizeof *buttons);
    if (!buttons)
        return lf_error_set(err, LF_E_NOMEM, "buttons", "out of memory");
    pthread_mutex_init(&buttons->lock, NULL);
    buttons->wakeup = lf_wakeup_make();
    buttons->link = *link;
    buttons->has_thread = buttons->wakeup >= 0 &&
                          lf_thread_start("lf-buttons", watch, buttons, &buttons->thread) == LF_OK;
    if (!buttons->has_thread) {
        buttons->link = (lf_hid_link){0}; /* the caller keeps the link */
        lf_buttons_destroy(buttons);
        return lf_error_set(err, LF_E_NOMEM, "buttons", "out of threads or descriptors");
    }
    *out = buttons;
    return LF_OK;
}

lf_status lf_buttons_open(const char *path, lf_buttons **out, lf_error *err)
{
    lf_hid_link link = {0};
    lf_status status = lf_hid_open(path, &link, err);
    if (status != LF_OK)
        return status;
    status = lf_buttons_watch(&link, out, err);
    if (status != LF_OK)
        lf_hid_close(&link);
    return status;
}

void lf_buttons_destroy(lf_buttons *buttons)
{
    if (!buttons)
        return;
    atomic_store_explicit(&buttons->stop, true, memory_order_relaxed);
    if (buttons->has_thread)
        pthread_join(buttons->thread, NULL);
    lf_hid_close(&buttons->link);
    if (buttons->wakeup >= 0)
        close(buttons->wakeup);
    pthread_mutex_destroy(&buttons->lock);
    lf_free(buttons);
}

int lf_buttons_poll_fd(const lf_buttons *buttons)
{
    return buttons->wakeup;
}

lf_buttons_event lf_buttons_next(lf_buttons *buttons, lf_button *out_button)
{
    lf_buttons_event event = LF_BUTTONS_NOTHING;
    pthread_mutex_lock(&buttons->lock);
    if (buttons->n_waiting > 0) {
        *out_button = buttons->waiting[buttons->first];
        buttons->first = (buttons->first + 1) % MAX_WAITING;
        buttons->n_waiting--;
        event = LF_BUTTONS_PRESSED;
    } else if (buttons->gone) {
        event = LF_BUTTONS_GONE;
    }
    if (buttons->n_waiting == 0 && !buttons->gone)
        lf_wakeup_clear(buttons->wakeup);
    pthread_mutex_unlock(&buttons->lock);
    return event;
}
