/* The files that a plan has read: who runs its tasks later sees whether one has changed. Thread:
 * the main thread, while no other one opens files. */
#ifndef LF_DAEMON_PLAN_INPUTS_H
#define LF_DAEMON_PLAN_INPUTS_H

#include <jansson.h>

#include "base/status.h"

/* A larger file has no hash: its bytes alone stand for it. The same holds for files beyond the sum,
 * the largest first: each process of a farm reads them once more. */
#define LF_PLAN_HASHED_BYTES (16 << 20)
#define LF_PLAN_HASHED_SUM (64 << 20)

/* From now on every opened file is noted, in any thread. */
void lf_plan_inputs_begin(void);
/* Files that are opened meanwhile are no inputs, such as outputs of an earlier run. */
void lf_plan_inputs_pause(bool on);
/* Ends it, and makes the list, in the order of names:
 *
 *     [{"name": path as opened, "bytes": n, "sha256": digits, if it is small}, ...]
 *
 * *out: a new reference. LF_E_IO: a file is gone meanwhile, or cannot be read; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plan_inputs_end(json_t **out, lf_error *err);

#endif
