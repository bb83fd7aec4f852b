/* The commands of quiltfarm. Each prints what a person wants to know to stdout, and logs what
 * happens. Thread: the main thread of a program with no others. */
#ifndef LF_DAEMON_FARM_H
#define LF_DAEMON_FARM_H

#include "base/param.h"
#include "base/status.h"

/* The options of all commands. Zeroed except task_minutes: none given. */
typedef struct lf_farm_options {
    const char *engine;      /* plan: a name of lf_farm_engine_name; NULL: the first */
    double task_minutes;     /* plan: negative = not given */
    const char *task_memory; /* plan: NULL = not given */
    int threads;             /* plan: of a task; 0 = LF_FARM_THREADS */
    int slots;               /* plan, submit, resume: tasks at once; 0 = not given */
    bool json;               /* plan, status: print JSON */
    bool check;              /* status, submit, resume: read the output files, too */
} lf_farm_options;
extern const lf_param lf_farm_params[];

#define LF_FARM_THREADS 4

/* What a command gets. */
typedef struct lf_farm_command {
    const lf_farm_options *options;
    const char *job;    /* the folder */
    const char *steps;  /* task, finish: "K" or "K:L"; NULL otherwise */
    char *const *words; /* behind "--", ended by NULL */
} lf_farm_command;

/* Divides what quiltrender would do into tasks, tells the cost, and makes the folder.
 * LF_E_EXISTS. */
LF_NODISCARD lf_status lf_farm_plan(const lf_farm_command *c, lf_error *err);
/* Sends what is missing, except steps that have failed LF_FARM_MOST_FAILURES times. LF_E_BUSY: some
 * is queued or running. LF_E_CANCELLED: the engine that runs tasks itself was told to end. */
LF_NODISCARD lf_status lf_farm_submit(const lf_farm_command *c, lf_error *err);
/* The same with the slots and words of the last submission, unless others are given. Forgets
 * failures. LF_E_STATE also: it was never submitted. */
LF_NODISCARD lf_status lf_farm_resume(const lf_farm_command *c, lf_error *err);
/* LF_E_STATE with options->check: a file is not as its receipt says. */
LF_NODISCARD lf_status lf_farm_status(const lf_farm_command *c, lf_error *err);
/* Runs the finishes that are missing, here. LF_E_STATE: tasks are missing. */
LF_NODISCARD lf_status lf_farm_merge(const lf_farm_command *c, lf_error *err);
LF_NODISCARD lf_status lf_farm_cancel(const lf_farm_command *c, lf_error *err);
/* Run steps, one after the other (farm_run.h). The first error that is not LF_E_CANCELLED does not
 * stop the others. */
LF_NODISCARD lf_status lf_farm_task(const lf_farm_command *c, lf_error *err);
LF_NODISCARD lf_status lf_farm_finish(const lf_farm_command *c, lf_error *err);

#endif
