/* loader: a thread that makes contents from files, patches and camera moves, one at a time, and
 * commits them to the engine. The event thread receives the outcome through its inbox. The current
 * picture continues to render meanwhile.
 *
 * Queued moves are merged into one; so are queued patches, and reloads of a file.
 *
 * After a change the loader gives the picture a short time to be shown before the next change. If a
 * change cost the picture its coarse frame, the next change waits for one, so that a user who drags
 * a slider sees motion.
 *
 * The files of one load are a group with one time limit (base/sandbox/import_group.h). */
#ifndef LF_DAEMON_LOADER_H
#define LF_DAEMON_LOADER_H

#include <stdatomic.h>

#include "daemon/engine/engine.h"
#include "daemon/threads/inbox.h"

typedef enum lf_load_kind {
    LF_LOAD_FILE,  /* a scene file, a scene that a client sent, or a quilt picture */
    LF_LOAD_PATCH, /* a merge patch on the scene shown */
    LF_LOAD_ORBIT, /* an orbit of its camera around its target */
    LF_LOAD_FIT,   /* a move of its camera so that its objects fill the window */
    LF_LOAD_APPLY, /* the same scene, with other options or another panel */
} lf_load_kind;

/* The part of a load that serves to find and cancel it. */
typedef struct lf_load_job {
    int64_t id;                      /* number given by the poster */
    int64_t turn;                    /* the poster's: lf_playlist_state.turn; 0: none */
    const char *method;              /* the poster's: the call that waits, static; NULL: none */
    struct lf_load *earlier, *later; /* the poster's: neighbours in the queue */
    int looks;                       /* the poster's: how often it was seen in progress */
    bool listed, browsed;            /* the poster's: by the playlist; by a button */
    atomic_bool running;             /* in progress, alone or merged with others */
    atomic_bool cancelled;           /* lf_loader_cancel */
} lf_load_job;

/* Parameters of a call that replace the command line's options for its file. */
typedef struct lf_load_words {
    bool said;         /* the other members are valid */
    int columns, rows; /* tiles of a quilt picture, overriding its name; 0 = not given */
    lf_photo photo;
    lf_standing standing;
    lf_alone alone;
    lf_sent_quilt quilt; /* the quilt that the client sent with the call */
    bool plays_once;     /* a video holds its last frame at the end instead of looping */
} lf_load_words;

/* What a client sent with its call. */
typedef struct lf_load_sent {
    lf_passed *passed; /* files and arrays; NULL: none */
    /* FILE: the scene itself, as a document or in an open file; NULL and -1: it is in a file */
    json_t *document;
    int fd;
} lf_load_sent;

typedef struct lf_load {
    lf_task task; /* posted when done; the poster sets `done` */
    lf_load_job job;
    lf_load_kind kind;
    /* FILE: steps from `file` in its folder (lf_folder_neighbour); 0 = the file itself */
    int step;
    char *file; /* FILE: absolute; replaced by the result of step. For a sent scene its name */
    /* FILE: the file that the options were given for, borrowed. If the name of another quilt holds
     * a layout, that layout overrides the options. */
    const char *meant;
    lf_load_words words;     /* FILE */
    json_t *patch;           /* PATCH */
    lf_load_sent sent;       /* FILE, PATCH */
    double yaw, pitch, zoom; /* ORBIT: yaw right and pitch up in degrees, zoom as a factor */
    char *name;              /* FIT: the object that is to fill the window; NULL = all */
    double fill, steps;      /* FIT: as in lf_camera_fit */
    lf_options options;
    lf_calibration calibration;
    bool has_calibration;
    bool force;     /* APPLY: commit even if the settings do not change */
    bool fresh;     /* FILE: resumes from no saved state, and is not merged with others */
    bool reset;     /* the poster's: a camera reset by a button */
    bool played;    /* one frame of an animation */
    void *deferred; /* the poster's */
    /* the outcome */
    lf_status status;
    lf_error err; /* valid if status is not LF_OK */
    bool committed;
    bool goes_on;    /* the accumulation continued; only its display changed */
    double restored; /* passes of the saved state it resumed from; 0 = none */
    int64_t generation;
    lf_content *content; /* if committed: a reference for the poster */
} lf_load;

typedef struct lf_loader lf_loader;

/* roots, inbox and engine are borrowed; roots must not change from now on. */
LF_NODISCARD lf_status lf_loader_create(lf_engine *engine, const lf_roots *roots, lf_inbox *inbox,
                                        lf_loader **out_loader);
/* Waits for the load in progress; posts the others as LF_E_CANCELLED. Accepts NULL. */
void lf_loader_destroy(lf_loader *loader);

/* A zeroed load; NULL = out of memory. */
lf_load *lf_load_create(lf_load_kind kind);
/* True if the load brings its scene instead of naming a file. */
bool lf_load_is_sent(const lf_load *load);
void lf_load_destroy(lf_load *load);
/* Takes ownership of the load until it is posted back. */
void lf_loader_queue(lf_loader *loader, lf_load *load);
/* Loads queued or in progress. */
int lf_loader_pending(lf_loader *loader);
/* Cancels a load that was not posted back yet (LF_E_CANCELLED). A load in progress ends soon. A
 * queued one ends at its turn or at lf_loader_drop_cancelled. Loads merged with it go on without
 * it. A load that is already being committed is not cancelled. */
void lf_loader_cancel(lf_loader *loader, lf_load *load);
/* Posts back cancelled loads that are still queued. */
void lf_loader_drop_cancelled(lf_loader *loader);
/* job.id of the load in progress, or of the first one if several are merged; 0: none. */
int64_t lf_loader_current(lf_loader *loader);

#endif
