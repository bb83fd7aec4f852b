#include "daemon/server/methods_internal.h"

void lf_method_job_cancel(lf_call *call)
{
    lf_error err;
    int64_t id = (int64_t)json_number_value(json_object_get(call->params, "job"));
    if (!lf_loading_cancel(call->server->loading, id) &&
        !lf_farmed_cancel(call->server->gallery.farmed, id) &&
        lf_jobs_cancel(call->server->jobs, id, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    lf_reply(call, json_object());
}
