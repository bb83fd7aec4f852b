/* presses: pending actions of a panel's buttons: browsing to other files of a folder, one load at a
 * time, and resetting the camera to that of the file. Its owner loads and reports the outcome.
 * Thread: event. */
#ifndef LF_DAEMON_PRESSES_H
#define LF_DAEMON_PRESSES_H

#include <jansson.h>

#include "base/status.h"

typedef struct lf_presses lf_presses;

typedef struct lf_presses_events {
    /* Show the file `step` places after `from` in its folder. Call lf_presses_browsed when this has
     * ended, but not from within. False: not possible. */
    bool (*browse)(void *context, const char *from, int step);
    /* Reset the camera to that of the file (borrowed). Call lf_presses_was_reset when this has
     * ended, but not from within. False: not possible. */
    bool (*reset)(void *context, const json_t *camera);
    /* Frees a value that may be large (NULL: nothing). */
    void (*release)(void *context, json_t *value);
} lf_presses_events;

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_presses_create(const lf_presses_events *events, void *context,
                                         lf_presses **out_presses);
/* Accepts NULL. */
void lf_presses_destroy(lf_presses *presses);
/* Browse to the next file (1) or the previous one (-1). shown: the file that is shown or about to
 * be; NULL: none. */
void lf_presses_turn(lf_presses *presses, int step, const char *shown);
/* The file was loaded, or could not be. Continues if buttons were pressed meanwhile. */
void lf_presses_browsed(lf_presses *presses, const char *file);
/* Reset the camera; does nothing until a file was shown. */
void lf_presses_reset(lf_presses *presses);
/* The reset has ended or failed. Repeats it if it was requested meanwhile. */
void lf_presses_was_reset(lf_presses *presses);
/* A file is shown unchanged. Its camera (NULL: none) is the one that resets restore. browsed:
 * requested by a button. */
void lf_presses_file(lf_presses *presses, json_t *camera, bool browsed);

#endif
