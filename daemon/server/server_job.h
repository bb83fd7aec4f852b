/* The inside of exports and of saving the state, shared by server_export.c (a call's words),
 * server_job.c (threads and ends) and server_state.c (--state). Everything is the event thread's,
 * but for what the job's own thread does between start and end. */
#ifndef LF_DAEMON_SERVER_JOB_H
#define LF_DAEMON_SERVER_JOB_H

#include <pthread.h>

#include "daemon/server/server.h"

/* Who asked for a job; hears of it without subscribing. */
typedef struct lf_asker {
    uint64_t client; /* 0 = the daemon itself, into --state */
    bool detached;   /* the job outlives that client */
    bool holds;      /* the client's connection, which stays half-closed as long */
    size_t bytes;    /* of the client's lines that are held with it */
} lf_asker;

struct lf_job {
    lf_task task;
    lf_job *next;
    lf_server *server;
    int64_t id;
    lf_asker asker;
    const lf_output_kind *kind; /* NULL: "state" */
    char *file;                 /* as asked for, canonical */
    char *name;                 /* on the disk, by the picture there was; NULL: file is */
    char *final;                /* name written; the thread's until it has ended */
    int folder_fd;              /* of file: what was checked is what is written to; -1 = none */
    bool overwrite;
    int64_t generation; /* what to wait for … */
    lf_level wait;
    bool started;
    lf_cancel cancel;
    pthread_t thread;
    lf_reconstruct reconstruct;
    lf_panel_options panel;
    bool has_calibration;
    lf_calibration calibration;
    lf_print print;
    lf_rgbd_options rgbd;
    char *icc;
    int *fds;
    int n_fds;
    atomic_int permille;
    int told; /* progress told last, in permille */
    lf_status status;
    lf_error err;
    sd_event_source *timer;
};

/* Made without a picture, and so waits for none. */
static inline bool job_is_drawn(const lf_job *job)
{
    return job->kind && job->kind->is_drawn;
}

/* An empty job of this server, not in its list yet; NULL = out of memory. */
lf_job *job_create(lf_server *server);
/* A job that is in no list. */
void job_free(lf_job *job);
/* Puts it into the server's list, which owns it from then on. */
void job_list(lf_job *job);
/* Starts its thread; the job ends by itself. */
void job_start(lf_job *job);
/* Whether the picture is as good as the job waits for. */
bool job_may_start(const lf_job *job);

#endif
