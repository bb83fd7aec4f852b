/* What the buttons of a panel do: --buttons. No sockets, no devices here. */
#ifndef LF_DAEMON_BUTTON_ACTIONS_H
#define LF_DAEMON_BUTTON_ACTIONS_H

#include "device/hid/buttons.h"

typedef enum lf_action {
    LF_ACTION_NONE,     /* only told */
    LF_ACTION_NEXT,     /* the next scene or quilt picture of the folder, by name, then the first */
    LF_ACTION_PREVIOUS, /* the one before, then the last */
    LF_ACTION_PAUSE,    /* rendering stops, or goes on */
    LF_ACTION_RESET,    /* the camera as it is in the scene's file */
    LF_ACTIONS_N,
} lf_action;

typedef struct lf_button_actions {
    lf_action of[LF_BUTTONS_N];
} lf_button_actions;

/* "none", "next", "previous", "pause", "reset". */
const char *lf_action_name(lf_action action);
/* square=pause, left=previous, right=next, circle=reset. */
void lf_button_actions_default(lf_button_actions *out);
/* "left=next,circle=none": those named are changed. LF_E_ARG with the word that is not known; *out
 * is untouched then. */
LF_NODISCARD lf_status lf_button_actions_parse(const char *text, lf_button_actions *out,
                                               lf_error *err);
/* The button of that name; LF_BUTTONS_N = none. */
lf_button lf_button_of_name(const char *name);

#endif
