/* presses: what the buttons of a panel have asked for and is not done yet: turning to other files
 * of a folder, one load at a time, and setting the camera back to what its file says. Whoever made
 * them loads, and tells what became of it. Everything is the event thread's. */
#ifndef LF_DAEMON_PRESSES_H
#define LF_DAEMON_PRESSES_H

#include <jansson.h>

#include "base/status.h"

typedef struct lf_presses lf_presses;

typedef struct lf_presses_events {
    /* The file is to be shown that is so many on from this one in its folder; lf_presses_browsed is
     * called when that has ended, and not from within. false: it cannot be. */
    bool (*browse)(void *context, const char *from, int step);
    /* The camera of what is shown is to become what the file says (borrowed); lf_presses_was_reset
     * is called when that has ended, and not from within. false: it cannot be. */
    bool (*reset)(void *context, const json_t *camera);
    /* Frees a value that may be large (NULL: nothing). */
    void (*release)(void *context, json_t *value);
} lf_presses_events;

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_presses_create(const lf_presses_events *events, void *context,
                                         lf_presses **out_presses);
/* Accepts NULL. */
void lf_presses_destroy(lf_presses *presses);
/* The next file (1), or the previous one (-1). shown: the file that is shown, or is to be; NULL:
 * none is. */
void lf_presses_turn(lf_presses *presses, int step, const char *shown);
/* The file that was turned to was loaded, or could not be: goes on when buttons were pressed
 * meanwhile. */
void lf_presses_browsed(lf_presses *presses, const char *file);
/* The camera is to be set back; nothing until a file was shown. */
void lf_presses_reset(lf_presses *presses);
/* It was, or could not be: once more when that was asked for meanwhile. */
void lf_presses_was_reset(lf_presses *presses);
/* A file is shown as it is, its camera (NULL: it has none) is what changes of it are set back to.
 * browsed: a button asked for it. */
void lf_presses_file(lf_presses *presses, json_t *camera, bool browsed);

#endif
