/* The expected cost of a job, without doing it: --plan. Thread: the main thread. */
#ifndef LF_DAEMON_RENDERING_PLAN_H
#define LF_DAEMON_RENDERING_PLAN_H

#include "daemon/tools/rendering.h"

/* Prints to stdout; to be called after lf_rendering_open. Prints comment lines that begin with "#",
 * then one command per task into which the job can be divided. A task is a row of cameras, a frame,
 * several frames that share parts of their shutters, or the whole job. CPU time is measured by
 * rendering a few image rows of one task; it excludes loading and writing. LF_E_CANCELLED; errors
 * of renderers. */
LF_NODISCARD lf_status lf_rendering_plan(lf_rendering *r, lf_error *err);

#endif
