/* loading: queued and current loads, the progress of reading their files, and their early end. File
 * readers report progress on their own threads. A load ends early if it is cancelled or superseded
 * by a later one. One instance per process. Thread: event. */
#ifndef LF_DAEMON_LOADING_H
#define LF_DAEMON_LOADING_H

#include <limits.h>
#include <systemd/sd-event.h>

#include "daemon/engine/loader.h"

typedef struct lf_loading lf_loading;

/* The file being read, or one of several. */
typedef struct lf_load_reading {
    char path[PATH_MAX];
    uint64_t bytes;
    double begun; /* lf_time_now */
    int n_read;   /* files read since the queue was last empty */
} lf_load_reading;

typedef struct lf_loading_events {
    /* True if the client that asked for this load has left. */
    bool (*is_vain)(void *context, const lf_load *load);
    /* Every half second: progress of the load with this number. */
    void (*reads)(void *context, int64_t id, const lf_load_reading *reading);
} lf_loading_events;

/* events is copied, event and loader are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_loading_create(sd_event *event, lf_loader *loader,
                                         const lf_loading_events *events, void *context,
                                         lf_loading **out_loading);
/* To be called after lf_loader_destroy. Accepts NULL. */
void lf_loading_destroy(lf_loading *loading);
/* Registers a load, numbered from 1, that is about to be queued. */
void lf_loading_add(lf_loading *loading, lf_load *load, int64_t id);
/* The load was posted back; accepts a load that was never queued. */
void lf_loading_ended(lf_loading *loading, lf_load *load);
/* The first load, queued or current; the current load. NULL: none. */
const lf_load *lf_loading_first(const lf_loading *loading);
const lf_load *lf_loading_current(const lf_loading *loading);
/* The file of a load; NULL: none, or not known yet. */
const char *lf_loading_file(const lf_load *load);
/* The file being read; false: none. */
bool lf_loading_reading(lf_loading *loading, lf_load_reading *out);
/* Cancels the load with this number; false: there is none. */
bool lf_loading_cancel(lf_loading *loading, int64_t id);
/* Cancels loads that have not begun and whose client has left. */
void lf_loading_end_vain(lf_loading *loading);

#endif
