/* jobs: exports. A job waits until the picture has the requested level. Then it runs on a thread of
 * its own: it takes a snapshot from the engine between two batches and writes it while rendering
 * continues. Jobs know who asked only as a number; they report through events, and their owner
 * informs the client. Thread: event, except the job's own thread. */
#ifndef LF_DAEMON_JOBS_H
#define LF_DAEMON_JOBS_H

#include <systemd/sd-event.h>

#include "daemon/engine/engine.h"
#include "daemon/threads/inbox.h"

typedef struct lf_jobs lf_jobs;

/* Who asked for a job. */
typedef struct lf_asker {
    uint64_t client;
    bool detached; /* the job survives that client */
    bool holds;    /* keeps the client's half-closed connection open */
    size_t bytes;  /* bytes of the client's lines that are held with it */
} lf_asker;

/* An export request. Zeroed except folder_fd, which is -1. */
typedef struct lf_export {
    lf_asker asker;
    const lf_output_kind *kind; /* NULL: "state" */
    char *file;                 /* the requested path, canonical */
    char *name;                 /* final name for the current picture, also with descriptors; NULL:
                                 * file is the final name */
    int folder_fd;              /* the checked folder of file, which is written to; -1 = none */
    bool overwrite;
    int64_t generation; /* generation to wait for … */
    lf_level wait;      /* … at this level; kinds that are drawn do not wait */
    lf_denoise denoise;
    lf_panel_options panel;
    bool has_calibration;
    lf_calibration calibration;
    lf_print print;         /* its icc_path is icc, its label is label */
    lf_profile_names named; /* profiles, which the job reads; owned */
    lf_print_given given;   /* keys of print that the call has */
    lf_rgbd_options rgbd;
    char *icc, *label;
    int *fds; /* descriptors to write to instead of a name */
    int n_fds;
} lf_export;

typedef enum lf_job_state {
    LF_JOB_WAITING,
    LF_JOB_RUNNING,
    LF_JOB_DONE,
    LF_JOB_CANCELLED,
    LF_JOB_FAILED,
} lf_job_state;

/* Report of a job; borrowed until the next call. */
typedef struct lf_job_told {
    int64_t id;
    const lf_asker *asker;
    const char *kind;
    const char *file;
    lf_job_state state;
    double progress;              /* 0 to 1 */
    const lf_error *err;          /* why it failed; otherwise NULL */
    const struct json_t *account; /* of a print that is done: lf_profile_account; otherwise NULL */
} lf_job_told;

/* A callback may query the jobs, but not add or cancel one. */
typedef struct lf_jobs_events {
    /* A job has started, progressed or ended. An ended job is no longer in the list. */
    void (*told)(void *context, const lf_job_told *job);
    /* After the last report: all data of the job is freed. */
    void (*ended)(void *context, const lf_asker *asker);
} lf_jobs_events;

/* Environment of the jobs; all of it is borrowed and must outlive them. */
typedef struct lf_jobs_home {
    sd_event *event;
    lf_inbox *inbox;   /* read by the event thread */
    lf_engine *engine; /* not used for kinds that are drawn */
} lf_jobs_home;

/* Closes and frees the contents of an export, not the struct. */
void lf_export_finish(lf_export *what);
/* True if the export needs no picture, and so waits for none. */
bool lf_export_is_drawn(const lf_export *what);

/* Chooses the number of views of an export's print, checks it, and notes its depth for the
 * manifest. content: the shown picture; not read for kinds that are drawn. LF_E_ARG. */
LF_NODISCARD lf_status lf_export_check_print(const lf_export *what, lf_print *print,
                                             const lf_content *content, lf_error *err);

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_jobs_create(const lf_jobs_home *home, const lf_jobs_events *events,
                                      void *context, lf_jobs **out_jobs);
/* To be called when no job is left. Accepts NULL. */
void lf_jobs_destroy(lf_jobs *jobs);
/* Checks that one more job is allowed, given `others` other writing threads. LF_E_BUSY. */
LF_NODISCARD lf_status lf_jobs_check_room(const lf_jobs *jobs, int others, lf_error *err);
/* Checks that the export may wait, if it must: waiting jobs are limited per client, among detached
 * ones and in total. LF_E_BUSY. */
LF_NODISCARD lf_status lf_jobs_check_wait(const lf_jobs *jobs, const lf_export *what,
                                          lf_error *err);
/* Adds a job with this number and takes ownership of the contents of `what` (lf_export_finish). The
 * job waits until lf_jobs_start. LF_E_NOMEM: nothing was taken. */
LF_NODISCARD lf_status lf_jobs_add(lf_jobs *jobs, int64_t id, const lf_export *what, lf_error *err);
/* Starts the jobs whose wait is over. */
void lf_jobs_start(lf_jobs *jobs);
/* LF_E_ARG: there is no such job. */
LF_NODISCARD lf_status lf_jobs_cancel(lf_jobs *jobs, int64_t id, lf_error *err);
/* A client has left: cancels its jobs that still wait or write to its descriptors. Detached jobs
 * continue. */
void lf_jobs_end_of(lf_jobs *jobs, uint64_t client);
/* Cancels all jobs; does not report waiting ones. */
void lf_jobs_end(lf_jobs *jobs);
/* The i-th job, newest first; false: i is past the last. */
bool lf_jobs_at(const lf_jobs *jobs, int i, lf_job_told *out);

#endif
