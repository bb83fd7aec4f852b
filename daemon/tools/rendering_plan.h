/* What a job would take, told before any of it is done: --plan. Thread: the main thread. */
#ifndef LF_DAEMON_RENDERING_PLAN_H
#define LF_DAEMON_RENDERING_PLAN_H

#include "daemon/tools/rendering.h"

/* Prints to stdout, behind lf_rendering_open: lines of words that begin with "#", and the command
 * of each task that the job can be parted into: a row of cameras or a frame, some frames where they
 * share what their shutters have in common, or all of it. CPU time is that of a few image rows,
 * which are rendered for it, of one task; loading and writing are not in it. LF_E_CANCELLED; errors
 * of renderers. */
LF_NODISCARD lf_status lf_rendering_plan(lf_rendering *r, lf_error *err);

#endif
