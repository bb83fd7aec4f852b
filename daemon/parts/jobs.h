/* jobs: exports. One waits until the picture is as good as was asked for, then runs on a thread of
 * its own: it takes a snapshot from the engine between two batches and writes it while rendering
 * goes on. Who asked is a number here; whoever made the jobs tells him what is told by events.
 * Everything is the event thread's, but for what a job's own thread does. */
#ifndef LF_DAEMON_JOBS_H
#define LF_DAEMON_JOBS_H

#include <systemd/sd-event.h>

#include "daemon/engine/engine.h"
#include "daemon/threads/inbox.h"

typedef struct lf_jobs lf_jobs;

/* Who asked for a job. */
typedef struct lf_asker {
    uint64_t client;
    bool detached; /* the job outlives that client */
    bool holds;    /* the client's connection, which stays half-closed as long */
    size_t bytes;  /* of the client's lines that are held with it */
} lf_asker;

/* What is asked for. Zeroed but for folder_fd, which is -1. */
typedef struct lf_export {
    lf_asker asker;
    const lf_output_kind *kind; /* NULL: "state" */
    char *file;                 /* as asked for, canonical */
    char *name;                 /* on the disk, by the picture there is now; NULL: file is */
    int folder_fd;              /* of file: what was checked is what is written to; -1 = none */
    bool overwrite;
    int64_t generation; /* what to wait for … */
    lf_level wait;      /* … at that level; kinds that are drawn wait for nothing */
    lf_denoise denoise;
    lf_panel_options panel;
    bool has_calibration;
    lf_calibration calibration;
    lf_print print; /* its icc_path is icc */
    lf_rgbd_options rgbd;
    char *icc;
    int *fds; /* to write to instead of by name */
    int n_fds;
} lf_export;

typedef enum lf_job_state {
    LF_JOB_WAITING,
    LF_JOB_RUNNING,
    LF_JOB_DONE,
    LF_JOB_CANCELLED,
    LF_JOB_FAILED,
} lf_job_state;

/* A job as it is told; borrowed until the next call. */
typedef struct lf_job_told {
    int64_t id;
    const lf_asker *asker;
    const char *kind;
    const char *file;
    lf_job_state state;
    double progress;     /* 0 to 1 */
    const lf_error *err; /* why it has failed; else NULL */
} lf_job_told;

/* An event may ask the jobs, but not begin or end one. */
typedef struct lf_jobs_events {
    /* A job runs, is further than before, or has ended and is none of the jobs any more. */
    void (*told)(void *context, const lf_job_told *job);
    /* Behind the last of them: everything of the job is gone. */
    void (*ended)(void *context, const lf_asker *asker);
} lf_jobs_events;

/* Where jobs live; all of it is borrowed and outlives them. */
typedef struct lf_jobs_home {
    sd_event *event;
    lf_inbox *inbox;   /* read by the event thread */
    lf_engine *engine; /* not asked for what is drawn */
} lf_jobs_home;

/* Closes and frees what an export has, not the struct. */
void lf_export_finish(lf_export *what);
/* Made without a picture, and so waits for none. */
bool lf_export_is_drawn(const lf_export *what);

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_jobs_create(const lf_jobs_home *home, const lf_jobs_events *events,
                                      void *context, lf_jobs **out_jobs);
/* When none is left. Accepts NULL. */
void lf_jobs_destroy(lf_jobs *jobs);
/* Whether there may be one more, beside so many other threads that write. LF_E_BUSY. */
LF_NODISCARD lf_status lf_jobs_check_room(const lf_jobs *jobs, int others, lf_error *err);
/* Whether this one may wait, where it must: it is one of a few of its client, of those that are
 * detached, and of all. LF_E_BUSY. */
LF_NODISCARD lf_status lf_jobs_check_wait(const lf_jobs *jobs, const lf_export *what,
                                          lf_error *err);
/* Takes over what is asked for (lf_export_finish), as the job of that number; it waits until
 * lf_jobs_start. LF_E_NOMEM: nothing was taken. */
LF_NODISCARD lf_status lf_jobs_add(lf_jobs *jobs, int64_t id, const lf_export *what, lf_error *err);
/* Starts those whose wait is over. */
void lf_jobs_start(lf_jobs *jobs);
/* LF_E_ARG: there is no such job. */
LF_NODISCARD lf_status lf_jobs_cancel(lf_jobs *jobs, int64_t id, lf_error *err);
/* A client has left: its jobs end which still wait, or are written to its descriptors; those that
 * were detached go on. */
void lf_jobs_end_of(lf_jobs *jobs, uint64_t client);
/* Cancels all, and tells nothing of those that wait. */
void lf_jobs_end(lf_jobs *jobs);
/* The i-th, the newest first; false: there are no more. */
bool lf_jobs_at(const lf_jobs *jobs, int i, lf_job_told *out);

#endif
