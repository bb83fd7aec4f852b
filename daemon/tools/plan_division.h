/* How a job is divided into tasks: arithmetic over what its light fields cost. A task renders one
 * or more light fields, or a band of image rows of one light field. A finish makes files from what
 * several tasks have kept. No state. Thread: any. */
#ifndef LF_DAEMON_PLAN_DIVISION_H
#define LF_DAEMON_PLAN_DIVISION_H

#include "base/status.h"

/* The cost of a task or a finish. */
typedef struct lf_plan_cost {
    double cpu_seconds; /* of the process and its children; negative: unknown */
    double memory;      /* peak of the process, bytes */
} lf_plan_cost;

/* The cost of a light field that was looked at. The costs of others lie between those of their
 * neighbours. */
typedef struct lf_plan_sample {
    double field;     /* its number */
    double begin_cpu; /* scene of this frame and renderer, in every task that renders any of it */
    double *row_cpu;  /* [height] passes of each image row; NULL: unknown */
} lf_plan_sample;

enum { LF_PLAN_SAMPLES = 5 };

/* What a job costs. Times in CPU seconds, memory in bytes. */
typedef struct lf_plan_model {
    lf_plan_sample samples[LF_PLAN_SAMPLES]; /* in the order of their fields */
    int n_samples;                           /* at least 1 */
    int height;                              /* image rows of a light field */
    double load_cpu;                         /* in every task and finish */
    double answer_cpu;    /* of a light field: holes, fit, answer, layers, files */
    double save_cpu;      /* of a saved state, per image row in it */
    double save_interval; /* CPU seconds of passes between two saves; 0: no states */
    double join_cpu;      /* of the finish of a job of several light fields, per light field */
    double loading;       /* peak while it loads */
    double base;          /* scene, renderer, workers and program */
    double row;           /* sums of an image row */
    double answer;        /* what a light field's answer and files need besides its sums */
    double join;          /* peak of the finish of a job of several light fields */
    lf_plan_cost close;   /* of the last finish of a job that is closed */
} lf_plan_model;

/* What is to be divided. */
typedef struct lf_plan_job {
    bool has_fields; /* tasks can name light fields */
    int first, last; /* light fields */
    bool is_whole;   /* nothing of it can be divided */
    bool can_band;   /* image rows are independent, and states of them can be merged */
    /* The files are made of all light fields. Tasks then keep states, unless the job is one task.
     */
    bool is_joined;
    /* Tasks write files, which a finish joins, unless the job is one task. */
    bool joins_files;
    /* After all files, one more finish makes files of them all, unless the job is one task. Either
     * all light fields are in bands or none. */
    bool is_closed;
    int group;    /* least light fields of a task, because neighbours share work; >= 1 */
    double again; /* share of a light field's passes that a neighbour in its task repeats */
} lf_plan_job;

typedef struct lf_plan_limits {
    double cpu_seconds; /* of a task. 0: one light field a task, or one group */
    double memory;      /* of a task, bytes. 0: none */
} lf_plan_limits;

/* Light fields and image rows, inclusive. */
typedef struct lf_plan_task {
    int fields[2]; /* last < first: the whole job */
    int rows[2];   /* last < first: all rows, and the task writes the files */
    lf_plan_cost cost;
} lf_plan_task;

typedef struct lf_plan_finish {
    int fields[2]; /* last < first: the whole job */
    int tasks[2];  /* indices */
    bool closes;   /* it needs the finishes of its tasks, if they have some */
    lf_plan_cost cost;
} lf_plan_finish;

/* Most tasks of a job. */
#define LF_PLAN_MOST_TASKS 1000000

/* Release with lf_plan_division_finish. Zeroed: no tasks. */
typedef struct lf_plan_division {
    int n_tasks, n_finishes;
    lf_plan_task *tasks;
    lf_plan_finish *finishes;
} lf_plan_division;

/* The memory of the smallest task that a job can be divided into. */
double lf_plan_least_memory(const lf_plan_job *job, const lf_plan_model *model);
/* Divides a job so that tasks stay within the limits. A task that cannot be divided further may
 * exceed them. Bands cost about the same. A band lasts at least as long as a task needs to begin.
 * A limit of memory below the smallest task makes a few bands only.
 * LF_E_ARG: more than LF_PLAN_MOST_TASKS; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plan_divide(const lf_plan_job *job, const lf_plan_model *model,
                                      const lf_plan_limits *limits, lf_plan_division *out,
                                      lf_error *err);
void lf_plan_division_finish(lf_plan_division *parts);

#endif
