/* The service of Bridge: a PUT with a JSON body is a request of bridge.h. */
#include "daemon/web/web_internal.h"

#include <string.h>

#include "base/alloc.h"
#include "daemon/web/reply.h"

/* The body as it comes, at most LF_BRIDGE_BODY bytes (the guard has checked its length). */
enum MHD_Result lf_bridge_put_take(lf_request *r, const char *body, size_t n)
{
    if (n > LF_BRIDGE_BODY - r->body_used)
        return MHD_NO;
    char *grown = lf_calloc(r->body_used + n, 1);
    if (!grown)
        return MHD_NO;
    if (r->body_used > 0)
        memcpy(grown, r->body, r->body_used);
    memcpy(grown + r->body_used, body, n);
    lf_free(r->body);
    r->body = grown;
    r->body_used += n;
    return MHD_YES;
}

static enum MHD_Result answer(lf_request *r)
{
    return lf_reply_json(r->connection, 200, lf_bridge_reply(r->bridge_call));
}

static enum MHD_Result refuse(lf_request *r, unsigned status, const char *why)
{
    json_t *reply = lf_bridge_failure(r->web->bridge, r->path + 1, why);
    enum MHD_Result sent = lf_reply_json(r->connection, status, reply);
    r->route = NULL;
    json_decref(reply);
    return sent;
}

static void on_done(void *context)
{
    lf_request_resume(context);
}

enum MHD_Result lf_bridge_put(lf_request *r)
{
    lf_error err = {0};
    json_t *body = r->body_used > 0
                       ? json_loadb(r->body, r->body_used, JSON_REJECT_DUPLICATES, NULL)
                       : json_object();
    if (!json_is_object(body) || !lf_bridge_knows(r->path + 1)) {
        const bool known = lf_bridge_knows(r->path + 1);
        json_decref(body);
        return known ? refuse(r, 400, "the body is no JSON object")
                     : refuse(r, 404, "there is no such endpoint");
    }
    if (lf_bridge_begin(r->web->bridge, r->path + 1, body, on_done, r, &r->bridge_call, &err) !=
        LF_OK)
        return refuse(r, 503, err.what);
    if (lf_bridge_reply(r->bridge_call))
        return answer(r);
    lf_patience_wait(lf_request_patience(r->connection), LF_BRIDGE_PATIENCE_S * (uint64_t)1000000);
    MHD_suspend_connection(r->connection);
    return MHD_YES;
}

enum MHD_Result lf_bridge_put_done(lf_request *r)
{
    return lf_bridge_reply(r->bridge_call) ? answer(r) : MHD_NO;
}
