/* The plan of a job: what it is, what it costs, and its tasks; for rendering_plan.c and plan_*.c.
 * Thread: the main thread. */
#ifndef LF_DAEMON_PLAN_H
#define LF_DAEMON_PLAN_H

#include "daemon/tools/plan_division.h"
#include "daemon/tools/rendering.h"

typedef struct lf_plan {
    lf_plan_job job;
    lf_plan_model model;
    lf_plan_division division;
    const char *option;   /* names light fields: "--camera-rows" or "--frames"; NULL: none */
    int n_parts, a_frame; /* of shared shutters; 0: frames are whole */
    int n_rows, n_views;  /* cameras of a light field, and pixels of a view */
    int width, height;
    int64_t passes;     /* of each film of a light field; 0: another limit applies */
    int n_sums;         /* such films of a light field, one after the other */
    double film_bytes;  /* sums of one light field */
    double files_bytes; /* of all files, uncompressed; negative: unknown */
    double least_fit;   /* memory that the fit of a denoised image needs whatever its size */
    int rows_measured;  /* 0: nothing was measured */
    char *frames;       /* names of frames to be joined, with a number field; NULL: none */
} lf_plan;

/* Measures the cost of some light fields of the job and fills plan->model. Leaves the last of them
 * in r. LF_E_CANCELLED; errors of scenes and renderers. */
LF_NODISCARD lf_status lf_plan_measure(lf_rendering *r, lf_plan *plan, lf_error *err);
void lf_plan_model_finish(lf_plan_model *model);

/* The words of a task's command without its light fields, rows and state: those of the command line
 * without the options of plans, light fields, states and receipts. A task whose frames are joined
 * has no options of videos, and plan->frames as its output. A new reference to an array; NULL = out
 * of memory. */
json_t *lf_plan_command(const lf_rendering *r, const lf_plan *plan);
/* The words of the finish that joins frames. NULL = out of memory. */
json_t *lf_plan_join_command(const lf_rendering *r, const lf_plan *plan);

/* Prints comment lines, then one command per task and finish for a shell. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plan_print_text(const lf_rendering *r, const lf_plan *plan,
                                          lf_error *err);
/* Prints the object of --json. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plan_print_json(const lf_rendering *r, const lf_plan *plan,
                                          lf_error *err);

#endif
