/* loading: loads that wait or are under way: how far the reading of files is, which its readers
 * tell on threads of their own, and how a load ends before its time: because it is cancelled, or
 * for a later one. One in a process. Thread: event. */
#ifndef LF_DAEMON_LOADING_H
#define LF_DAEMON_LOADING_H

#include <limits.h>
#include <systemd/sd-event.h>

#include "daemon/engine/loader.h"

typedef struct lf_loading lf_loading;

/* The file that is read, of several one. */
typedef struct lf_load_reading {
    char path[PATH_MAX];
    uint64_t bytes;
    double begun; /* lf_time_now */
    int n_read;   /* files, since there was nothing to load */
} lf_load_reading;

typedef struct lf_loading_events {
    /* Whether somebody has asked for this load who has left since. */
    bool (*is_vain)(void *context, const lf_load *load);
    /* Every half second: the load of that number reads. */
    void (*reads)(void *context, int64_t id, const lf_load_reading *reading);
} lf_loading_events;

/* events is copied, event and loader are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_loading_create(sd_event *event, lf_loader *loader,
                                         const lf_loading_events *events, void *context,
                                         lf_loading **out_loading);
/* When the loader is gone. Accepts NULL. */
void lf_loading_destroy(lf_loading *loading);
/* The load of that number (from 1) is about to be queued. */
void lf_loading_add(lf_loading *loading, lf_load *load, int64_t id);
/* It has come back; accepts one that was never queued. */
void lf_loading_ended(lf_loading *loading, lf_load *load);
/* The first that waits or is under way, and the one that is made; NULL: there is none. */
const lf_load *lf_loading_first(const lf_loading *loading);
const lf_load *lf_loading_current(const lf_loading *loading);
/* The file of a load; NULL: it has none, or it is not known yet. */
const char *lf_loading_file(const lf_load *load);
/* What is read; false: nothing is. */
bool lf_loading_reading(lf_loading *loading, lf_load_reading *out);
/* Ends the load of that number; false: there is none. */
bool lf_loading_cancel(lf_loading *loading, int64_t id);
/* Ends those that are in vain and have not begun. */
void lf_loading_end_vain(lf_loading *loading);

#endif
