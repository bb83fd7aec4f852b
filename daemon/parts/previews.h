/* previews: copies of the shown image for clients. Each is made on a thread of its own, which
 * takes the views from the engine and writes them to the client's descriptor while rendering
 * continues. A preview knows its client only as a number; its owner answers. Thread: event, except
 * the preview's own thread. */
#ifndef LF_DAEMON_PREVIEWS_H
#define LF_DAEMON_PREVIEWS_H

#include "daemon/engine/engine.h"
#include "daemon/output/preview.h"
#include "daemon/threads/inbox.h"

typedef struct lf_previews lf_previews;

typedef struct lf_preview {
    uint64_t client;
    int n_views; /* 0: all */
    lf_preview_options options;
    int fd;     /* to write to */
    void *call; /* of the owner */
} lf_preview;

/* What was written. */
typedef struct lf_preview_written {
    lf_layout layout;
    int64_t generation, bytes;
    lf_level level;
    double passes;
    bool reconstructed;
} lf_preview_written;

/* A preview has ended: written, or err (the other is NULL). A callback may add no
 * preview. */
typedef void (*lf_preview_ended_fn)(void *context, const lf_preview *asked,
                                    const lf_preview_written *written, const lf_error *err);

/* inbox and engine are borrowed and must outlive the previews. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_previews_create(lf_inbox *inbox, lf_engine *engine,
                                          lf_preview_ended_fn ended, void *context,
                                          lf_previews **out_previews);
/* To be called when no preview is left. Accepts NULL. */
void lf_previews_destroy(lf_previews *previews);
/* Checks that this client may have one more: one per client, and few in all. LF_E_BUSY. */
LF_NODISCARD lf_status lf_previews_check_room(const lf_previews *previews, uint64_t client,
                                              lf_error *err);
/* Begins a preview. Takes ownership of the descriptor, also on failure. LF_E_NOMEM: `ended` is not
 * called. */
LF_NODISCARD lf_status lf_previews_add(lf_previews *previews, const lf_preview *what,
                                       lf_error *err);
/* True while one is being made. */
bool lf_previews_busy(const lf_previews *previews);
/* Cancels the preview of a client that has left; `ended` is still called. */
void lf_previews_end_of(lf_previews *previews, uint64_t client);
/* Cancels all. */
void lf_previews_end(lf_previews *previews);

#endif
