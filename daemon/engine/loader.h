/* loader: a thread that makes contents out of files, patches and camera moves, one after the other,
 * and commits them to the engine. Moves that wait become one, and so do patches, and reloads of a
 * file: nobody sees what they would be in between. A picture that changes is given a moment to be
 * shown before the next change, and where one change has cost a picture its coarse frame the next
 * one lets it come: whoever moves a slider sees something move. The picture shown goes on being
 * rendered meanwhile; the event thread hears of the outcome through its inbox. The files of a load
 * are a group (base/sandbox/import_group.h): they have one limit of time. */
#ifndef LF_DAEMON_LOADER_H
#define LF_DAEMON_LOADER_H

#include <stdatomic.h>

#include "daemon/engine/engine.h"
#include "daemon/threads/inbox.h"

typedef enum lf_load_kind {
    LF_LOAD_FILE,  /* a scene file or a quilt picture */
    LF_LOAD_PATCH, /* a merge patch on the scene shown */
    LF_LOAD_ORBIT, /* a move of its camera around its target */
    LF_LOAD_FIT,   /* a move of its camera to where its things fill the window */
    LF_LOAD_APPLY, /* the same scene, with other options or another panel */
} lf_load_kind;

/* A load as something that can be cancelled. */
typedef struct lf_load_job {
    int64_t id;                      /* the poster's number of it */
    struct lf_load *earlier, *later; /* the poster's: queued before and behind it, … */
    int looks;                       /* … and how often it was seen under way */
    atomic_bool running;             /* alone or with others */
    atomic_bool cancelled;           /* lf_loader_cancel */
} lf_load_job;

/* What a call says of its file, in place of the command line's options. */
typedef struct lf_load_words {
    bool said;         /* the rest counts */
    int columns, rows; /* tiles of a picture, whatever its name says; 0 = not given */
    lf_photo photo;
    lf_alone alone;
} lf_load_words;

typedef struct lf_load {
    lf_task task; /* posted when it is done; the poster sets done */
    lf_load_job job;
    lf_load_kind kind;
    /* FILE: so many files on from `file` in its folder (lf_folder_neighbour); 0 = itself */
    int step;
    char *file; /* FILE: absolute; what it came to, after step */
    /* FILE: what the options are for, borrowed; in another quilt's name the layout wins over theirs
     */
    const char *meant;
    lf_load_words words;     /* FILE */
    json_t *patch;           /* PATCH */
    lf_passed *passed;       /* FILE, PATCH: files that the client has passed; NULL = none */
    double yaw, pitch, zoom; /* ORBIT: degrees to the right and up, and how many times nearer */
    char *name;              /* FIT: of what is to fill it; NULL = all */
    double fill, steps;      /* FIT: as in lf_camera_fit */
    lf_options options;
    lf_calibration calibration;
    bool has_calibration;
    bool force;     /* APPLY: commit even when the settings come out the same */
    bool browsed;   /* the poster's: a button asked for it, … */
    bool reset;     /* … or for this */
    bool played;    /* it is a frame of many */
    void *deferred; /* the poster's */
    /* the outcome */
    lf_status status;
    lf_error err; /* when status is not LF_OK */
    bool committed;
    bool goes_on;    /* the accumulation that there was: only how it is shown is new */
    double restored; /* passes of the saved state that it goes on from; 0 = none */
    int64_t generation;
    lf_content *content; /* when committed: a reference for the poster */
} lf_load;

typedef struct lf_loader lf_loader;

/* roots, inbox and engine are borrowed; roots must not change from now on. */
LF_NODISCARD lf_status lf_loader_create(lf_engine *engine, const lf_roots *roots, lf_inbox *inbox,
                                        lf_loader **out_loader);
/* Ends after the load in progress; those not begun are posted as LF_E_CANCELLED. Accepts NULL. */
void lf_loader_destroy(lf_loader *loader);

/* A zeroed load; NULL = out of memory. */
lf_load *lf_load_create(lf_load_kind kind);
void lf_load_destroy(lf_load *load);
/* Takes the load over until it is posted back. */
void lf_loader_queue(lf_loader *loader, lf_load *load);
/* Loads queued or in progress. */
int lf_loader_pending(lf_loader *loader);
/* Ends a load that was not posted back yet: LF_E_CANCELLED, soon where it is in progress, else when
 * its turn has come or lf_loader_drop_cancelled is called. Others that are made together with it
 * are made without it. One that is being committed already is not ended. */
void lf_loader_cancel(lf_loader *loader, lf_load *load);
/* Posts back those that are cancelled and wait for their turn. */
void lf_loader_drop_cancelled(lf_loader *loader);
/* job.id of the load in progress, of several that are made together of the first; 0: none is. */
int64_t lf_loader_current(lf_loader *loader);

#endif
