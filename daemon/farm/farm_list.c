/* list: prints the commands, for farms that this program does not know. */
#include <stdio.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/farm/farm_engine.h"

static lf_status send_list(lf_farm_job *job, const lf_farm_batch *batch, json_t *sent,
                           lf_error *err)
{
    bool finishes = false;
    (void)sent;
    for (int i = 0; i < job->n_tasks + job->n_finishes; i++) {
        char *command = NULL;
        finishes |= batch->wanted[i] && i >= job->n_tasks;
        if (!batch->wanted[i] || i >= job->n_tasks)
            continue;
        const lf_status status = lf_farm_step_command(job, i, i, &command, err);
        if (status != LF_OK)
            return status;
        puts(command);
        lf_free(command);
    }
    lf_log(LF_LOG_INFO, "run these commands in any order%s quiltfarm status %s",
           finishes ? ", then quiltfarm merge; see" : "; see", job->path);
    return LF_OK;
}

static lf_status cancel_list(const lf_farm_job *job, const json_t *sent, lf_error *err)
{
    (void)sent;
    return lf_error_set(err, LF_E_STATE, job->path,
                        "quiltfarm does not know its farm; end the tasks there");
}

const lf_farm_engine lf_farm_list = {.name = "list", .send = send_list, .cancel = cancel_list};
