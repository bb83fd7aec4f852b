/* watch: files that change on disk. Whoever made it says which, and is told. Everything is the
 * event thread's. */
#ifndef LF_DAEMON_WATCH_H
#define LF_DAEMON_WATCH_H

#include <systemd/sd-event.h>

#include "base/status.h"

typedef struct lf_watch lf_watch;

typedef struct lf_watch_events {
    /* A file has changed, or was put in its place, and has been quiet since for a tenth of a
     * second. */
    void (*changed)(void *context);
} lf_watch_events;

/* Watches nothing yet. events is copied, event borrowed. LF_E_NOMEM, LF_E_IO: there is no inotify
 * to be had. */
LF_NODISCARD lf_status lf_watch_create(sd_event *event, const lf_watch_events *events,
                                       void *context, lf_watch **out_watch, lf_error *err);
/* Accepts NULL. */
void lf_watch_destroy(lf_watch *watch);
/* Watches these n from now on, by their paths, and no others; a folder that cannot be watched is
 * left out with a line in the log. */
void lf_watch_files(lf_watch *watch, const char *const *files, size_t n);

#endif
