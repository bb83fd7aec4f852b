/* What the steps of a job have left on the disk. It alone says what is complete. Thread: any. */
#ifndef LF_DAEMON_FARM_RESULT_H
#define LF_DAEMON_FARM_RESULT_H

#include "daemon/farm/farm_job.h"

/* Failures after which a step is given up. */
#define LF_FARM_MOST_FAILURES 3
/* A step that runs touches its file every minute. After so many seconds without it, its machine is
 * thought to be lost. */
#define LF_FARM_SILENT_SECONDS 300.0

typedef struct lf_farm_result {
    bool complete;
    bool is_running;  /* as far as files say; false positive for LF_FARM_SILENT_SECONDS */
    bool is_lost;     /* it began and has been silent for longer, or its process is gone */
    bool is_given_up; /* it is sent again only by `resume` */
    int failures;     /* since it was sent anew by `resume` */
    double cpu_seconds, seconds; /* used so far, in all its runs */
    double silent;               /* seconds since it was last heard of, if it began */
    char host[64];               /* where it runs or ran; "" */
    char words[256];             /* why it failed last; "" */
} lf_farm_result;

/* Reads one step, or all (lf_free). LF_E_NOMEM, LF_E_IO: the folder cannot be read. Damaged files
 * count as missing. */
LF_NODISCARD lf_status lf_farm_result_read(const lf_farm_job *job, int step, lf_farm_result *out,
                                           lf_error *err);
LF_NODISCARD lf_status lf_farm_results_read(const lf_farm_job *job, lf_farm_result **out,
                                            lf_error *err);

/* Writes the receipt of a task that makes states: those of its light fields. LF_E_IO: one is
 * missing. */
LF_NODISCARD lf_status lf_farm_result_receipt(const lf_farm_job *job, int step, lf_error *err);
/* Removes a receipt: what it tells of is no longer there. */
void lf_farm_result_revoke(const lf_farm_job *job, int step);

/* A run begins: its file says where. */
void lf_farm_result_begin(const lf_farm_job *job, int step);
/* A run has ended: adds its cost. words: why it failed; NULL: it did not. gives_up: the next run
 * would fail, too; words of a full disk say the same. */
void lf_farm_result_end(const lf_farm_job *job, int step, double cpu_seconds, double seconds,
                        const char *words, bool gives_up);
/* A run that nobody has and that did not end: counts as a failure, in *result, too. */
void lf_farm_result_abandon(const lf_farm_job *job, int step, lf_farm_result *result);
/* Forgets the failures of a step. */
void lf_farm_result_forgive(const lf_farm_job *job, int step);

/* Removes states that are no longer needed: those of complete steps that made files, and of all
 * tasks whose finish is complete. */
void lf_farm_result_tidy(const lf_farm_job *job, int step);

/* The absolute names of output files that complete steps have made, as an array; a new reference.
 * NULL = out of memory. */
json_t *lf_farm_result_files(const lf_farm_job *job, const lf_farm_result *results);
/* Reads all output files. Those whose bytes are not those of their receipts, or that cannot be
 * read, as an array like the one before; a missing file, or one of another size, is not complete,
 * and not among them. */
json_t *lf_farm_result_differing(const lf_farm_job *job);

#endif
