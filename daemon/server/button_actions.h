/* Actions of a panel's buttons: --buttons. No sockets or devices here. */
#ifndef LF_DAEMON_BUTTON_ACTIONS_H
#define LF_DAEMON_BUTTON_ACTIONS_H

#include "device/hid/buttons.h"

typedef enum lf_action {
    LF_ACTION_NONE,     /* none; only notified */
    LF_ACTION_NEXT,     /* the next scene or quilt picture of the folder by name; after the last,
                         * the first. While a playlist plays: its next entry */
    LF_ACTION_PREVIOUS, /* the previous one; before the first, the last */
    LF_ACTION_PAUSE,    /* pause or resume rendering. While a playlist plays: the playlist */
    LF_ACTION_RESET,    /* restore the camera of the scene's file */
    LF_ACTIONS_N,
} lf_action;

typedef struct lf_button_actions {
    lf_action of[LF_BUTTONS_N];
} lf_button_actions;

/* "none", "next", "previous", "pause", "reset". */
const char *lf_action_name(lf_action action);
/* square=pause, left=previous, right=next, circle=reset. */
void lf_button_actions_default(lf_button_actions *out);
/* "left=next,circle=none": changes the named buttons. LF_E_ARG with the unknown word; *out is then
 * untouched. */
LF_NODISCARD lf_status lf_button_actions_parse(const char *text, lf_button_actions *out,
                                               lf_error *err);
/* The button with this name; LF_BUTTONS_N = none. */
lf_button lf_button_of_name(const char *name);

#endif
