/* The folder of a job, which quiltfarm makes and every machine of a farm sees by the same name.
 *
 *     job.json      what is rendered and how it is divided; never changes
 *     tasks         one command per line, task K in line K + 1
 *     finishes      the same for finishes, which need the tasks' states
 *     frames/       of a film, until they are joined
 *     states/       saved and finished accumulations
 *     done/         per step: NAME.json, a receipt: the files that it made; NAME.failed, how it
 *                   failed; NAME.cost, what it has used; NAME.running, where it runs
 *     log/          what steps and schedulers print
 *     sent.json     how it was submitted last
 *
 * A step is a task or a finish; NAME is task_K or finish_J. Several processes may read and write
 * the folder: every file is replaced as a whole. Thread: one at a time. */
#ifndef LF_DAEMON_FARM_JOB_H
#define LF_DAEMON_FARM_JOB_H

#include <jansson.h>

#include "base/status.h"
#include "daemon/farm/farm_words.h"

/* A step. Numbers are inclusive; -1: none. */
typedef struct lf_farm_step {
    int fields[2]; /* light fields: frames or rows of cameras */
    int rows[2];   /* of tasks: image rows; such a task makes states only */
    int tasks[2];  /* of finishes: the tasks that it needs */
    int finish;    /* of tasks: the step of the first finish that needs it; -1: none */
    bool closes;   /* of finishes: it needs the finishes of its tasks, and merges nothing */
    double cpu_seconds, memory; /* planned; bytes of the whole process; 0: unknown */
} lf_farm_step;

typedef struct lf_farm_engine lf_farm_engine;

/* Release with lf_farm_job_close. */
typedef struct lf_farm_job {
    char *path;   /* absolute */
    json_t *json; /* job.json */
    const lf_farm_engine *engine;
    const json_t *plan, *command; /* borrowed from json */
    const json_t *join;           /* words of the finish, without the program; NULL: as tasks */
    const char *folder;           /* that words of the command are relative to */
    const char *id;               /* of this plan: hexadecimal digits; "": of an earlier build */
    const char *field_option;     /* NULL: no fields */
    bool names_fields;            /* the user's command has the option */
    int fields[2];                /* of the job */
    int n_tasks, n_finishes;
    int threads;
    lf_farm_step *steps; /* n_tasks tasks, then n_finishes finishes */
    int lock_fd;         /* -1: not locked */
} lf_farm_job;

/* Makes the folder from a plan (quiltrender --plan --json) of a command with these words. All
 * strings are borrowed; folder is absolute. Adds keys to plan. LF_E_EXISTS: there is a job, or
 * another file; LF_E_FORMAT: the plan is not one; LF_E_ARG: a name that schedulers would change. */
LF_NODISCARD lf_status lf_farm_job_make(const char *path, const lf_farm_engine *engine,
                                        const char *folder, char *const words[], json_t *plan,
                                        lf_error *err);
/* Reads a job. Zeroes *out first. LF_E_FORMAT: damaged, or of another version; LF_E_STATE: its
 * folder was moved; LF_E_IO. */
LF_NODISCARD lf_status lf_farm_job_open(const char *path, lf_farm_job *out, lf_error *err);
void lf_farm_job_close(lf_farm_job *job);
/* For whoever runs what the folder says. LF_E_STATE: the folder, or a file in it that holds
 * commands or words, belongs to another user than this one and root, or others may write it. */
LF_NODISCARD lf_status lf_farm_job_check_mine(const lf_farm_job *job, lf_error *err);
/* For whoever sends or finishes, until the job is closed. LF_E_BUSY: another process has it. A file
 * system without locks gets a warning, and LF_OK. */
LF_NODISCARD lf_status lf_farm_job_lock(lf_farm_job *job, lf_error *err);
/* True if another process has the lock. */
bool lf_farm_job_is_locked(const lf_farm_job *job);

/* Adds words of the plan from an index on. The names of a film's frames, which are in the folder,
 * get its path. */
void lf_farm_job_words(const lf_farm_job *job, const json_t *texts, size_t first,
                       lf_farm_words *words);
/* A name in the folder; caller frees with lf_free. NULL = out of memory. */
char *lf_farm_job_path(const lf_farm_job *job, const char *format, ...) LF_PRINTF(2, 3);
/* "task_3"; returns buf. */
#define LF_FARM_STEP_NAME 32
const char *lf_farm_step_name(const lf_farm_job *job, int step, char buf[LF_FARM_STEP_NAME]);
/* "task 3", for messages; returns buf. */
const char *lf_farm_step_text(const lf_farm_job *job, int step, char buf[LF_FARM_STEP_NAME]);
/* Reads "K" or "K:L", numbers of n steps from 0; L is cut to the last. LF_E_ARG. */
LF_NODISCARD lf_status lf_farm_read_steps(const char *text, int n, int out[2], lf_error *err);
/* The step that a finish needs for one of its tasks: the task, or the finish of the task. */
int lf_farm_step_needed(const lf_farm_job *job, int finish, int task);
/* The light fields whose states a step has; -1 to -1: one without a number. A step without fields
 * has all of the job. */
void lf_farm_step_fields(const lf_farm_job *job, int step, int out[2]);
/* The state of a step's light field (-1: the step has no fields); caller frees with lf_free. NULL =
 * out of memory. */
char *lf_farm_step_state(const lf_farm_job *job, int step, int field);
/* The path of this program. LF_E_IO. */
LF_NODISCARD lf_status lf_farm_own_program(char *buf, size_t size, lf_error *err);
/* The shell command of steps first to last, which are of one kind; caller frees with lf_free.
 * LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farm_step_command(const lf_farm_job *job, int first, int last, char **out,
                                            lf_error *err);

/* Reads and writes a JSON object in the folder. *out: a new reference; NULL if there is no such
 * file. LF_E_IO, LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farm_job_read(const lf_farm_job *job, const char *name, json_t **out,
                                        lf_error *err);
LF_NODISCARD lf_status lf_farm_job_write(const lf_farm_job *job, const char *name,
                                         const json_t *object, lf_error *err);

#endif
