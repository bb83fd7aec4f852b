/* The farms that quiltfarm drives, a table with one file per member (CONTRIBUTING.md). An engine
 * sends commands and answers what it knows of them. What is complete is read from the disk
 * (farm_result.h), never asked of an engine. Thread: one at a time. */
#ifndef LF_DAEMON_FARM_ENGINE_H
#define LF_DAEMON_FARM_ENGINE_H

#include "daemon/farm/farm_job.h"
#include "daemon/farm/farm_result.h"

/* What to send. */
typedef struct lf_farm_batch {
    const bool *wanted; /* per step */
    int slots;          /* tasks at once; 0: as many as the engine likes */
    char *const *words; /* options for the engine's program, ended by NULL */
} lf_farm_batch;

/* What an engine knows of a step. */
typedef enum lf_farm_place { LF_FARM_NOWHERE, LF_FARM_QUEUED, LF_FARM_RUNNING } lf_farm_place;

typedef struct lf_farm_queue {
    lf_farm_place *places; /* per step; owned */
    int n_queued, n_running;
    char note[256]; /* why steps wait, if somebody has to do something; "" */
} lf_farm_queue;

struct lf_farm_engine {
    const char *name;
    /* Sends all wanted steps: tasks, and finishes that begin when the tasks that they need are
     * complete. Adds what `look` and `cancel` need to `sent`, which the caller has written before
     * to sent.json, and writes it again there. An engine may run everything before it returns.
     * LF_E_CANCELLED: it was told to end; what was rendered is saved. LF_E_ARG: unusable words.
     * LF_E_IO: its program failed; what was sent may run. */
    lf_status (*send)(lf_farm_job *job, const lf_farm_batch *batch, json_t *sent, lf_error *err);
    /* Fills *out, whose places are zeroed. sent: as `send` left it. NULL: nobody can be asked, and
     * files say where steps run. LF_E_IO. */
    lf_status (*look)(const lf_farm_job *job, const json_t *sent, lf_farm_queue *out,
                      lf_error *err);
    /* LF_E_BUSY: it has steps of an older plan of this folder, which was removed. NULL: it cannot
     * have any. LF_E_IO. */
    lf_status (*check)(const lf_farm_job *job, const json_t *sent, lf_error *err);
    /* Ends all that is queued or running. sent NULL: this plan was not submitted, but an older one
     * of its folder may be. LF_E_STATE: nothing is, as far as the engine knows. */
    lf_status (*cancel)(const lf_farm_job *job, const json_t *sent, lf_error *err);
};

extern const lf_farm_engine lf_farm_slurm, lf_farm_parallel, lf_farm_list;

/* The name of an engine; NULL after the last. */
const char *lf_farm_engine_name(int index);
/* NULL: there is none of this name. */
const lf_farm_engine *lf_farm_engine_find(const char *name);

/* What the engine of a job knows; sent may be NULL. Release with lf_farm_queue_finish. */
LF_NODISCARD lf_status lf_farm_queue_read(const lf_farm_job *job, const json_t *sent,
                                          lf_farm_queue *out, lf_error *err);
void lf_farm_queue_finish(lf_farm_queue *queue);
/* Notes the steps that run as far as their files say, which an engine may not know. LF_E_IO,
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farm_queue_by_files(const lf_farm_job *job, lf_farm_queue *queue,
                                              lf_error *err);
/* Notes a step's place, if it is not behind the last. */
void lf_farm_queue_place(const lf_farm_job *job, lf_farm_queue *queue, int step,
                         lf_farm_place place);

#endif
