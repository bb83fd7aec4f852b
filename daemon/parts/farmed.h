/* farmed: exports that a farm renders. Each has a thread of its own: it writes the scene into the
 * job's folder, lets quiltfarm plan and submit it, and asks quiltfarm at intervals how far it is.
 * What the farm does goes on when this process ends. Thread: event, except the jobs' own threads.
 *
 * quiltfarm is found in PATH and runs as a child process: while it plans and submits as long as the
 * limits allow, later one call at a time. What it prints is read up to a limit. */
#ifndef LF_DAEMON_FARMED_H
#define LF_DAEMON_FARMED_H

#include "base/calibration.h"
#include "daemon/output/content.h"
#include "daemon/output/render_words.h"
#include "daemon/threads/inbox.h"

typedef struct lf_farmed lf_farmed;

#define LF_FARMED_MOST 8 /* jobs at a time */

/* Names of the kinds of farm, as quiltfarm's --engine; NULL after the last. */
const char *lf_farmed_engine_at(int index);
/* "slurm,list" as bits of lf_farmed_engine_at. LF_E_ARG. */
LF_NODISCARD lf_status lf_farmed_engines(const char *list, unsigned *out, lf_error *err);

/* What to render. Zeroed except folder.folder_fd, which is -1. */
typedef struct lf_farmed_order {
    uint64_t client;
    const char *engine; /* static */
    const char *kind;   /* static */
    char *file;         /* final name of the output */
    bool overwrite;
    bool has_calibration;       /* calibration becomes LF_FARMED_PANEL in the job's folder */
    lf_calibration calibration; /* named in `words` by lf_farmed_panel */
    lf_held_name folder;        /* of the job; must not exist */
    lf_content *content;        /* the scene: a reference */
    json_t *camera;             /* replaces these keys of the scene's camera; NULL: none */
    lf_render_words words;      /* options of quiltrender, without scene and output */
} lf_farmed_order;
void lf_farmed_order_finish(lf_farmed_order *order);
#define LF_FARMED_PANEL "panel.json"
#define LF_FARMED_SCENE "scene.json"

/* How far a job is, as quiltfarm said last. */
typedef struct lf_farmed_look {
    /* of quiltfarm, or "planning" and "submitting" before it knows the job */
    char state[16];
    int64_t total, complete, running, failed, missing; /* tasks */
    double planned, spent;                             /* CPU seconds; < 0: unknown */
    double seconds_left;                               /* < 0: unknown */
    char problem[256]; /* why the last look failed; "": it did not */
} lf_farmed_look;

typedef enum lf_farmed_state {
    LF_FARMED_RUNNING,
    LF_FARMED_DONE,
    LF_FARMED_CANCELLED,
    LF_FARMED_FAILED,
} lf_farmed_state;

/* Report of a job; borrowed until the next call. */
typedef struct lf_farmed_told {
    int64_t id;
    uint64_t client; /* who asked; 0: it was taken up */
    const char *engine, *kind, *file, *folder;
    lf_farmed_state state;
    double progress; /* 0 to 1: share of its tasks that are complete */
    const lf_farmed_look *look;
    const lf_error *err; /* why it failed; otherwise NULL */
} lf_farmed_told;

/* A callback may query the jobs, but not add or cancel one. */
typedef struct lf_farmed_events {
    /* A job has begun, is further or has ended. An ended job is no longer in the list. */
    void (*told)(void *context, const lf_farmed_told *job);
    /* A job has ended, or was left to its farm by lf_farmed_leave: its data is freed. */
    void (*ended)(void *context);
} lf_farmed_events;

/* Environment of the jobs; all of it is borrowed and must outlive them. */
typedef struct lf_farmed_home {
    lf_inbox *inbox;
    const char *export_root; /* canonical; NULL: nothing is taken up */
    const char *state_dir;   /* records of the jobs; NULL: none are kept */
    double plan_s;           /* limit for plan … */
    double call_s;           /* … and for status and cancel */
    double interval_s;       /* between two looks */
    int most_vain;           /* failed looks in a row, until the job fails */
} lf_farmed_home;

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farmed_create(const lf_farmed_home *home, const lf_farmed_events *events,
                                        void *context, lf_farmed **out_farmed);
/* To be called when no job is left. Accepts NULL. */
void lf_farmed_destroy(lf_farmed *farmed);
/* Takes up the jobs of an earlier run that are recorded and whose engine is among these bits, as
 * jobs after the number *id, which becomes the last one. Reads files. */
void lf_farmed_take_up(lf_farmed *farmed, unsigned engines, int64_t *id);
/* Starts a job with this number and takes the contents of `order`. LF_E_BUSY: there are
 * LF_FARMED_MOST; LF_E_NOMEM: nothing was taken. */
LF_NODISCARD lf_status lf_farmed_add(lf_farmed *farmed, int64_t id, const lf_farmed_order *order,
                                     lf_error *err);
/* Lets quiltfarm cancel a job, which then ends. False: there is no such job. */
bool lf_farmed_cancel(lf_farmed *farmed, int64_t id);
/* Ends the threads; jobs that were submitted go on. Jobs that were not are given up. */
void lf_farmed_leave(lf_farmed *farmed);
/* The i-th job, newest first; false: i is past the last. */
bool lf_farmed_at(const lf_farmed *farmed, int i, lf_farmed_told *out);

#endif
