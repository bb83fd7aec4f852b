/* The inside of jobs.h, shared by jobs.c (the event thread's side) and jobs_write.c (what a job
 * does on its own thread). */
#ifndef LF_DAEMON_JOBS_INTERNAL_H
#define LF_DAEMON_JOBS_INTERNAL_H

#include <pthread.h>

#include "daemon/parts/jobs.h"

typedef struct lf_job {
    lf_task task;
    struct lf_job *next;
    lf_jobs *jobs;
    int64_t id;
    lf_export asked;
    bool started;
    int told; /* progress told last, in permille */
    sd_event_source *timer;
    pthread_t thread;
    lf_cancel cancel;
    atomic_int permille;
    /* the thread's until it has ended */
    char *final; /* name written */
    lf_status status;
    lf_error err;
} lf_job;

struct lf_jobs {
    lf_jobs_home home;
    lf_jobs_events events;
    void *context;
    lf_job *first; /* the newest */
};

/* Writes what is asked for; the job's status, err and final say what became of it. */
void lf_job_write(lf_job *job);

#endif
