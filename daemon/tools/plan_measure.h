/* The parts of a plan's measurement. Thread: the main thread. */
#ifndef LF_DAEMON_PLAN_MEASURE_H
#define LF_DAEMON_PLAN_MEASURE_H

#include "daemon/tools/plan.h"

/* Image rows that are rendered for a plan: n strips of consecutive rows, evenly spread. */
typedef struct lf_plan_pilot {
    int n, strip; /* n 0: nothing was rendered */
    int n_rows;   /* in all strips */
    int height;   /* of the image */
    int n_fields; /* light fields that share the work of the pilot */
} lf_plan_pilot;

/* The rows of a strip: returns the first, and the row after the last. */
int lf_plan_strip(const lf_plan_pilot *pilot, int index, int *out_end);

/* Answers and writes the rows of a pilot that r->renderer holds, and fills what the model says of
 * answers, files and states. LF_E_CANCELLED, LF_E_NOMEM; errors of outputs. */
LF_NODISCARD lf_status lf_plan_measure_answer(lf_rendering *r, lf_plan *plan,
                                              const lf_plan_pilot *pilot, lf_error *err);

#endif
