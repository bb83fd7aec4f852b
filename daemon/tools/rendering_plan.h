/* The expected cost of a job, without doing it: --plan. Thread: the main thread. */
#ifndef LF_DAEMON_RENDERING_PLAN_H
#define LF_DAEMON_RENDERING_PLAN_H

#include "daemon/tools/rendering.h"

/* Prints to stdout, as the options of plans in r->arguments say; to be called after
 * lf_rendering_open. The text is comment lines that begin with "#", then one command per task and
 * finish. Some image rows are rendered, to measure their time. LF_E_CANCELLED; LF_E_ARG: too many
 * tasks; LF_E_STATE: frames exist that tasks would refuse; errors of renderers. */
LF_NODISCARD lf_status lf_rendering_plan(lf_rendering *r, lf_error *err);

#endif
