/* watch: watches files for changes on disk. Thread: event. */
#ifndef LF_DAEMON_WATCH_H
#define LF_DAEMON_WATCH_H

#include <systemd/sd-event.h>

#include "base/status.h"

typedef struct lf_watch lf_watch;

typedef struct lf_watch_events {
    /* A file was changed or replaced, and has not changed since for a tenth of a second. */
    void (*changed)(void *context);
} lf_watch_events;

/* Watches nothing yet. events is copied, event borrowed. LF_E_NOMEM; LF_E_IO: inotify is not
 * available. */
LF_NODISCARD lf_status lf_watch_create(sd_event *event, const lf_watch_events *events,
                                       void *context, lf_watch **out_watch, lf_error *err);
/* Accepts NULL. */
void lf_watch_destroy(lf_watch *watch);
/* From now on watches these n paths and no others. A folder that cannot be watched is skipped with
 * a line in the log. */
void lf_watch_files(lf_watch *watch, const char *const *files, size_t n);

#endif
