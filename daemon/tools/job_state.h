/* The accumulation of one job as a file, for --state of quiltrender: its identity and progress,
 * then the film as lf_renderer_save writes it.
 *
 *     "quiltdJB", u32 version, u32 n, u32 CRC-32 of n and the text, n bytes of JSON, the film
 *
 * All little-endian. Thread: one at a time. */
#ifndef LF_DAEMON_JOB_STATE_H
#define LF_DAEMON_JOB_STATE_H

#include <jansson.h>

#include "daemon/output/render_job.h"

/* The identity of a renderer's accumulation. scene: the name to record. A new reference; NULL = out
 * of memory. */
json_t *lf_job_state_of(const char *scene, const lf_renderer *renderer, const lf_budget *budget);

/* Progress of a job. */
typedef struct lf_job_progress {
    lf_render_times times;
    bool complete; /* the budget was spent */
} lf_job_progress;

/* Opens a state and reads its head. *out_fd is then at the film; the caller closes it. *out is a
 * new reference. out_size may be NULL. remedy: the end of errors of bad files, "; …". Errors as of
 * lf_job_state_restore. */
LF_NODISCARD lf_status lf_job_state_open(const char *path, const char *remedy, int *out_fd,
                                         uint64_t *out_size, json_t **out, lf_error *err);
/* Writes a head; the film follows. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_job_state_put(lf_outfile *file, const json_t *head, lf_error *err);
/* How the job of a head differs from `of`, as text after "it differs in"; empty: not at all. The
 * budget, the progress and the numbers of a merge are no part of it. */
void lf_job_state_differences(const json_t *there, const json_t *of, char *words, size_t size);

/* Writes path through a temporary file that is renamed. of: from lf_job_state_of. LF_E_IO,
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_job_state_write(const char *path, const json_t *of,
                                          const lf_renderer *renderer,
                                          const lf_job_progress *progress, lf_error *err);

/* Restores the renderer from path. *out_progress: complete if the file's job was complete with the
 * budget of `of`. LF_E_STATE: names the first difference between the file's identity and `of`, or
 * its other version; LF_E_FORMAT: not such a file, or damaged; LF_E_IO, LF_E_NOMEM. On failure the
 * renderer is unchanged. */
LF_NODISCARD lf_status lf_job_state_restore(const char *path, const json_t *of,
                                            lf_renderer *renderer, lf_job_progress *out_progress,
                                            lf_error *err);

/* The header of a file and its size in bytes: the object of --state-info. *out is a new reference.
 * Errors of lf_job_state_restore. */
LF_NODISCARD lf_status lf_job_state_info(const char *path, json_t **out, lf_error *err);

#endif
