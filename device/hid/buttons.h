/* The buttons of a first-generation panel: input reports of its HID interface. Threads: one
 * caller's thread (the daemon's event thread); a thread of the object reads the reports. */
#ifndef LF_DEVICE_BUTTONS_H
#define LF_DEVICE_BUTTONS_H

#include "base/status.h"

/* Names and order of the vendor's gamepad buttons. The assignment of bits is not yet confirmed on
 * hardware. */
typedef enum lf_button {
    LF_BUTTON_SQUARE,
    LF_BUTTON_LEFT,
    LF_BUTTON_RIGHT,
    LF_BUTTON_CIRCLE,
    LF_BUTTONS_N
} lf_button;
/* "square", "left", "right", "circle". */
const char *lf_button_name(lf_button button);

typedef struct lf_buttons lf_buttons;

typedef enum lf_buttons_event {
    LF_BUTTONS_NOTHING, /* nothing new */
    LF_BUTTONS_PRESSED, /* *out_button went down; once per press, also if several reports contain
                         * it */
    LF_BUTTONS_GONE,    /* unplugged: returned until destroy */
} lf_buttons_event;

/* Watches the HID device at this path (lf_found.path of LF_SOURCE_HID). LF_E_NODEV; LF_E_IO: no
 * permission, err says what to do. */
LF_NODISCARD lf_status lf_buttons_open(const char *path, lf_buttons **out, lf_error *err);
/* Ends the thread within 100 ms. Accepts NULL. */
void lf_buttons_destroy(lf_buttons *buttons);
/* Polls readable while lf_buttons_next has news. */
int lf_buttons_poll_fd(const lf_buttons *buttons);
lf_buttons_event lf_buttons_next(lf_buttons *buttons, lf_button *out_button);

#endif
