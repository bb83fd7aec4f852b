/* The accumulation of one job as a file, for --state of quiltrender: what it is of and how far it
 * is, and behind that the film as lf_renderer_save writes it.
 *
 *     "quiltdJB", u32 version, u32 n, u32 CRC-32 of n and the text, n bytes of JSON, the film
 *
 * All little-endian. Thread: one at a time. */
#ifndef LF_DAEMON_JOB_STATE_H
#define LF_DAEMON_JOB_STATE_H

#include <jansson.h>

#include "daemon/output/render_job.h"

/* What the accumulation of a renderer is of: scene is the name to record. A new reference; NULL =
 * out of memory. */
json_t *lf_job_state_of(const char *scene, const lf_renderer *renderer, const lf_budget *budget);

/* How far it is. */
typedef struct lf_job_progress {
    lf_render_times times;
    bool complete; /* the budget was spent */
} lf_job_progress;

/* Writes path, beside and renamed: `of` is as lf_job_state_of makes it. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_job_state_write(const char *path, const json_t *of,
                                          const lf_renderer *renderer,
                                          const lf_job_progress *progress, lf_error *err);

/* Makes the renderer hold what path does. *out_progress is complete where it is so with the budget
 * of `of`. LF_E_STATE names what the file is of and `of` is not, or says that it is of another
 * version; LF_E_FORMAT: it is none, or damaged; LF_E_IO, LF_E_NOMEM. The renderer is then as it
 * was. */
LF_NODISCARD lf_status lf_job_state_restore(const char *path, const json_t *of,
                                            lf_renderer *renderer, lf_job_progress *out_progress,
                                            lf_error *err);

/* What the head of a file says, with the bytes of all of it: the object of --state-info. A new
 * reference, in *out. Errors as of restoring. */
LF_NODISCARD lf_status lf_job_state_info(const char *path, json_t **out, lf_error *err);

#endif
