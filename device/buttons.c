/* The thread only reads reports and tells presses apart; what it saw waits in a small ring, behind a descriptor that is readable
 * as long as there is something in it. */
#include "device/buttons.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/alloc.h"
#include "device/buttons_link.h"

/* More presses that nobody has taken are not those of a person. */
#define MAX_WAITING 32
#define WAIT_MS 50
#define REST_MS 10

struct lf_buttons {
    lf_hid_link link; /* thread only, once it runs */
    pthread_t thread;
    bool has_thread;
    atomic_bool stop;
    int event_fd;
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

static void ring(const lf_buttons *buttons)
{
    uint64_t one = 1;
    while (write(buttons->event_fd, &one, sizeof one) < 0 && errno == EINTR)
        ;
}

static void tell_pressed(lf_buttons *buttons, unsigned pressed)
{
    pthread_mutex_lock(&buttons->lock);
    for (int b = 0; b < LF_BUTTONS_N; b++)
        if ((pressed & 1u << b) != 0 && buttons->n_waiting < MAX_WAITING)
            buttons->waiting[(buttons->first + buttons->n_waiting++) % MAX_WAITING] = (lf_button)b;
    ring(buttons);
    pthread_mutex_unlock(&buttons->lock);
}

static void tell_gone(lf_buttons *buttons)
{
    pthread_mutex_lock(&buttons->lock);
    buttons->gone = true;
    ring(buttons);
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

/* Signals are the event thread's. */
static int start_thread(lf_buttons *buttons)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int e = pthread_create(&buttons->thread, NULL, watch, buttons);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (e == 0)
        pthread_setname_np(buttons->thread, "lf-buttons");
    return e;
}

lf_status lf_buttons_watch(lf_hid_link *link, lf_buttons **out, lf_error *err)
{
    lf_buttons *buttons = lf_calloc(1, sizeof *buttons);
    if (buttons == NULL)
        return lf_error_set(err, LF_E_NOMEM, "buttons", "out of memory");
    pthread_mutex_init(&buttons->lock, NULL);
    buttons->event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    buttons->link = *link;
    buttons->has_thread = buttons->event_fd >= 0 && start_thread(buttons) == 0;
    if (!buttons->has_thread) {
        buttons->link = (lf_hid_link){0}; /* stays the caller's */
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
    if (buttons == NULL)
        return;
    atomic_store_explicit(&buttons->stop, true, memory_order_relaxed);
    if (buttons->has_thread)
        pthread_join(buttons->thread, NULL);
    lf_hid_close(&buttons->link);
    if (buttons->event_fd >= 0)
        close(buttons->event_fd);
    pthread_mutex_destroy(&buttons->lock);
    lf_free(buttons);
}

int lf_buttons_poll_fd(const lf_buttons *buttons)
{
    return buttons->event_fd;
}

/* Silences the descriptor while nothing waits; what is gone stays readable. */
static void silence(const lf_buttons *buttons)
{
    uint64_t rings;
    while (read(buttons->event_fd, &rings, sizeof rings) < 0 && errno == EINTR)
        ;
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
        silence(buttons);
    pthread_mutex_unlock(&buttons->lock);
    return event;
}
