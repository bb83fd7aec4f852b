/* The accumulation of one light field as a file, for --state of quiltrender: its identity and
 * progress, then the film as lf_renderer_save writes it.
 *
 *     "quiltdJB", u32 version, u32 n, u32 CRC-32 of n and the text, n bytes of JSON, the film
 *
 * All little-endian. The JSON is the head:
 *
 *     quiltd, scene, views, width, height, seed, integrator, denoise, reconstruct, hashes: what
 *     rows [first, last]   image rows, inclusive, row 0 the first of the film
 *     stream               random stream of the seed, 0 without --stream
 *     frame, camera_row    which light field of a sequence or grid; absent: the only one
 *     shutter_part         of the parts that begin in `frame` (rendering_shared.h); absent: none
 *     budget               what the job asked for
 *     passes, seconds, cpu_seconds   of all runs
 *     complete             all rows have what was asked for
 *     parts, streams       of a merged state: how many files and random streams; absent: 1
 *
 * A state of one stream can be continued, also if some of its rows have less than others. Thread:
 * one at a time. */
#ifndef LF_DAEMON_JOB_STATE_H
#define LF_DAEMON_JOB_STATE_H

#include <jansson.h>

#include "daemon/output/render_job.h"

/* Limit of --stream. */
#define LF_MAX_STREAM 65535

/* Which light field of a job, and which part of it. A number below 0: there is no such thing. */
typedef struct lf_job_place {
    int first_row, last_row; /* image rows, inclusive */
    uint32_t stream;
    int frame, camera_row, shutter_part;
} lf_job_place;

/* The identity of a renderer's accumulation. scene: the name to record. A new reference; NULL = out
 * of memory. */
json_t *lf_job_state_of(const char *scene, const lf_renderer *renderer, const lf_budget *budget,
                        const lf_job_place *place);

/* Progress of a job. */
typedef struct lf_job_progress {
    lf_render_times times;
    bool complete; /* the budget was spent */
    int n_streams; /* more than 1: the film can be answered, but not continued */
} lf_job_progress;

/* Opens a state and reads its head, with defaults for the keys that older files lack. *out_fd is
 * then at the film; the caller closes it. *out is a new reference. out_size may be NULL. Errors as
 * of lf_job_state_restore, but without a remedy. */
LF_NODISCARD lf_status lf_job_state_open(const char *path, int *out_fd, uint64_t *out_size,
                                         json_t **out, lf_error *err);
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

/* The progress in a file, from its head alone. Errors of lf_job_state_restore, except those of its
 * film. */
LF_NODISCARD lf_status lf_job_state_check(const char *path, const json_t *of,
                                          lf_job_progress *out_progress, lf_error *err);
/* Restores the renderer from path. *out_progress: complete if the file's job was complete with the
 * budget of `of`. LF_E_STATE: names the first difference between the file's identity and `of`, or
 * its other version; LF_E_FORMAT: not such a file, or damaged; LF_E_IO, LF_E_NOMEM. On failure the
 * renderer is unchanged. */
LF_NODISCARD lf_status lf_job_state_restore(const char *path, const json_t *of,
                                            lf_renderer *renderer, lf_job_progress *out_progress,
                                            lf_error *err);

/* The head of a file, its size (bytes) and how many rows of its film have visits (film_rows): the
 * object of --state-info. Reads no sums. *out is a new reference.
 * Errors of lf_job_state_restore. */
LF_NODISCARD lf_status lf_job_state_info(const char *path, json_t **out, lf_error *err);

#endif
