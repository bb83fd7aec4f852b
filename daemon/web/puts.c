/* PUT: bodies that become uploads, or quilts of quiltd. */
#include "daemon/web/web_internal.h"

#include "base/log.h"
#include "base/number.h"
#include "daemon/web/query.h"
#include "daemon/web/reply.h"
#include "daemon/wire/rpc.h"

#define PACE_USEC ((uint64_t)10000000) /* for LF_PATIENCE_BYTES of a body */
#define SHOW_S 60u                     /* for quiltd to decode a quilt */

static enum MHD_Result refuse(lf_request *r, const lf_error *err)
{
    switch (err->status) {
    case LF_E_ARG:
        return lf_request_refuse_json(r, 400, LF_RPC_INVALID_PARAMS, err);
    case LF_E_EXISTS:
        return lf_request_refuse_json(r, 409, LF_RPC_INVALID_PARAMS, err);
    case LF_E_BUSY:
        return lf_request_refuse_json(r, 503, LF_RPC_BUSY, err);
    default:
        return lf_request_refuse_json(r, 500, LF_RPC_INTERNAL, err);
    }
}

/* Reads the query, and makes room for the body, whose length the guard has checked. */
static lf_status begin(lf_request *r, const lf_query_key *keys, lf_error *err)
{
    uint64_t size = 0;
    const char *length =
        MHD_lookup_connection_value(r->connection, MHD_HEADER_KIND, "Content-Length");
    lf_status status = lf_query_read(r->connection, keys, &r->query, err);
    if (status == LF_OK && (!length || !lf_whole_is(length, &size)))
        status = lf_error_set(err, LF_E_ARG, "Content-Length", "is no number");
    if (status == LF_OK)
        status = lf_uploads_begin(r->web->uploads, size, &r->upload, err);
    if (status == LF_OK)
        lf_patience_pace(lf_request_patience(r->connection), PACE_USEC);
    return status;
}

enum MHD_Result lf_put_take(lf_request *r, const char *body, size_t n)
{
    lf_error err = {0};
    if (r->upload && lf_upload_append(r->upload, body, n, &err) == LF_OK) {
        lf_patience_note(lf_request_patience(r->connection), n);
        return MHD_YES;
    }
    lf_log_error(&err);
    return MHD_NO; /* the connection ends: within a body there is no answer */
}

/* ----------------------------------------------------------------------------------- uploads -- */

static const char *param(const lf_request *r, const char *name)
{
    return json_string_value(json_object_get(r->query, name));
}

enum MHD_Result lf_put_check_upload(lf_request *r)
{
    static const lf_query_key keys[] = {{"name", "name", LF_QUERY_TEXT, true},
                                        {"folder", "folder", LF_QUERY_TEXT, false},
                                        {NULL, NULL, LF_QUERY_TEXT, false}};
    lf_error err = {0};
    lf_status status = begin(r, keys, &err);
    if (status == LF_OK)
        status = lf_uploads_check_name(r->web->uploads, param(r, "folder"), param(r, "name"), &err);
    return status == LF_OK ? MHD_YES : refuse(r, &err);
}

enum MHD_Result lf_put_upload(lf_request *r)
{
    char folder[LF_UPLOADS_FOLDER + 1] = "";
    lf_error err = {0};
    if (lf_upload_keep(r->upload, param(r, "folder"), param(r, "name"), folder, &err) != LF_OK)
        return refuse(r, &err);
    json_t *answer = json_pack("{s:s, s:s}", "path", lf_upload_path(r->upload), "folder", folder);
    r->upload = NULL; /* the store's */
    r->web->counts.uploads++;
    enum MHD_Result sent = lf_reply_json(r->connection, 201, answer);
    json_decref(answer);
    return sent;
}

/* ------------------------------------------------------------------------------------ quilts -- */

enum MHD_Result lf_put_check_quilt(lf_request *r)
{
    static const lf_query_key keys[] = {{"cols", "columns", LF_QUERY_WHOLE, true},
                                        {"rows", "rows", LF_QUERY_WHOLE, true},
                                        {"views", "views", LF_QUERY_WHOLE, false},
                                        {"aspect", "aspect", LF_QUERY_NUMBER, false},
                                        {NULL, NULL, LF_QUERY_TEXT, false}};
    lf_error err = {0};
    return begin(r, keys, &err) == LF_OK ? MHD_YES : refuse(r, &err);
}

enum MHD_Result lf_put_quilt(lf_request *r)
{
    lf_error err = {0};
    if (lf_upload_open(r->upload, &r->fd, &err) != LF_OK)
        return refuse(r, &err);
    r->web->counts.uploads++;
    lf_patience_wait(lf_request_patience(r->connection), (SHOW_S + 2) * (uint64_t)1000000);
    return lf_route_fetch(r, "quilt.show", json_incref(r->query), SHOW_S);
}

enum MHD_Result lf_put_quilt_shown(lf_request *r)
{
    const json_t *result = NULL;
    int code = 0;
    if (lf_route_result(r, &result, &code) != LF_OK)
        return lf_route_fetch_failed(r, code);
    return lf_reply_json(r->connection, 200, result);
}
