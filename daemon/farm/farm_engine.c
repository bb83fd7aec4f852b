#include "daemon/farm/farm_engine.h"

#include <string.h>

#include "base/alloc.h"

static const lf_farm_engine *const engines[] = {&lf_farm_slurm, &lf_farm_parallel, &lf_farm_list};
enum { N_ENGINES = sizeof engines / sizeof *engines };

const char *lf_farm_engine_name(int index)
{
    return index < N_ENGINES ? engines[index]->name : NULL;
}

const lf_farm_engine *lf_farm_engine_find(const char *name)
{
    for (int i = 0; i < N_ENGINES; i++)
        if (strcmp(engines[i]->name, name) == 0)
            return engines[i];
    return NULL;
}

lf_status lf_farm_queue_read(const lf_farm_job *job, const json_t *sent, lf_farm_queue *out,
                             lf_error *err)
{
    *out = (lf_farm_queue){0};
    out->places = lf_calloc((size_t)(job->n_tasks + job->n_finishes), sizeof *out->places);
    if (!out->places)
        return lf_farm_no_memory(job->path, err);
    return sent && job->engine->look ? job->engine->look(job, sent, out, err) : LF_OK;
}

void lf_farm_queue_finish(lf_farm_queue *queue)
{
    lf_free(queue->places);
    *queue = (lf_farm_queue){0};
}

void lf_farm_queue_place(const lf_farm_job *job, lf_farm_queue *queue, int step,
                         lf_farm_place place)
{
    if (step < 0 || step >= job->n_tasks + job->n_finishes)
        return;
    if (queue->places[step] < place)
        queue->places[step] = place;
}

lf_status lf_farm_queue_by_files(const lf_farm_job *job, lf_farm_queue *queue, lf_error *err)
{
    lf_farm_result *results = NULL;
    const lf_status status = lf_farm_results_read(job, &results, err);
    for (int i = 0; i < job->n_tasks + job->n_finishes && status == LF_OK; i++)
        if (results[i].is_running) {
            lf_farm_queue_place(job, queue, i, LF_FARM_RUNNING);
            queue->n_running++;
        }
    lf_free(results);
    return status;
}
