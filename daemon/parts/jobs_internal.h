/* Internals of jobs.h, shared by jobs.c (event thread) and jobs_write.c (a job's thread). */
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
    int told; /* last reported progress, in permille */
    sd_event_source *timer;
    pthread_t thread;
    lf_cancel cancel;
    atomic_int permille;
    /* owned by the job's thread until it has ended */
    char *final; /* name of the written file */
    lf_status status;
    lf_error err;
    json_t *account; /* of the profiles that filled the print; NULL: none */
} lf_job;

struct lf_jobs {
    lf_jobs_home home;
    lf_jobs_events events;
    void *context;
    lf_job *first; /* the newest */
};

/* Writes the export; the job's status, err and final hold the outcome. */
void lf_job_write(lf_job *job);

#endif
