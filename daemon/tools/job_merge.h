/* Merging states of parts of one light field (job_state.h) into one state: bands of image rows, and
 * random streams. The films are merged by render/film/film_merge.h; this file compares the heads,
 * and makes the head of the result. Thread: one at a time. */
#ifndef LF_DAEMON_JOB_MERGE_H
#define LF_DAEMON_JOB_MERGE_H

#include "daemon/tools/job_state.h"
#include "render/film/film_merge.h"

typedef struct lf_job_merge {
    const char *const *parts;
    int n_parts;
    const char *out;
    bool partial;           /* accept missing rows and incomplete parts */
    double wait;            /* seconds to wait for parts that are not there */
    lf_merging_fn progress; /* as in lf_merging_write */
    void *context;
    const lf_cancel *cancel;
} lf_job_merge;

/* What the result holds. */
typedef struct lf_job_merged {
    int n_parts, n_streams; /* without copies */
    int n_rows, height;
    double spp;    /* mean over all rows */
    bool complete; /* all rows have what was asked for */
} lf_job_merged;

/* Merges the parts and writes out through a temporary file that is renamed. Logs a warning about
 * each copy of a part, which counts once. The result depends neither on the order of the parts nor
 * on copies. Errors name a file: LF_E_ARG (out is a part), LF_E_STATE (does not belong to the first
 * part, samples twice, rows missing, incomplete), LF_E_FORMAT (damaged, or its head says other
 * things than its film), LF_E_IO, LF_E_NOMEM, LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_job_merge_run(const lf_job_merge *merge, lf_job_merged *out,
                                        lf_error *err);

#endif
