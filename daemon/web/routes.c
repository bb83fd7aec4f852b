/* The table of paths, and requests without a body that are answered from memory or by one call of
 * quiltd. */
#include "daemon/web/web_internal.h"

#include <stdlib.h>
#include <string.h>

#include "daemon/web/image.h"
#include "daemon/web/memory.h"
#include "daemon/web/query.h"
#include "daemon/web/reply.h"
#include "daemon/wire/prometheus.h"
#include "daemon/wire/rpc.h"

#define PATIENCE_S 8u /* within the deadline of a request */

/* --------------------------------------------------------------------------- calls of quiltd -- */

static const int places[LF_WEB_LANES] = {8, 4, 2};

static void on_fetched(void *context)
{
    lf_request *r = context;
    lf_route_leave_lane(r);
    lf_request_resume(r);
}

static bool is_full(const lf_request *r)
{
    return r->web->n_fetches[r->route->lane] >= places[r->route->lane];
}

/* Begins a fetch in the lane of the request. params: taken. */
static lf_status ask(lf_request *r, const char *method, json_t *params, unsigned patience_s)
{
    lf_web *web = r->web;
    const lf_fetch_call call = {
        .method = method, .params = params, .fd = r->fd, .patience_s = patience_s};
    r->status =
        lf_fetch_create(web->event, web->socket, &call, on_fetched, r, &r->fetch, &r->error);
    json_decref(params);
    if (r->status != LF_OK)
        return r->status;
    r->lane = r->route->lane;
    r->fetching = true;
    web->n_fetches[r->lane]++;
    return LF_OK;
}

static lf_status ask_thumbnail(lf_request *r)
{
    if (lf_patience_is_over(lf_request_patience(r->connection)))
        r->status = lf_error_set(&r->error, LF_E_TIMEOUT, "quiltd", "no answer in time");
    else
        r->status = lf_memory_create(&r->fd, &r->error);
    if (r->status != LF_OK)
        return r->status;
    return ask(r, "library.thumbnail", json_incref(r->query), PATIENCE_S);
}

/* The request that has waited longest; NULL: none waits. */
static lf_request *find_waiting(const lf_web *web)
{
    lf_request *oldest = NULL;
    for (lf_request *r = web->requests; r; r = r->next)
        oldest = r->waiting ? r : oldest;
    return oldest;
}

void lf_route_leave_lane(lf_request *r)
{
    lf_web *web = r->web;
    lf_request *next;
    if (!r->fetching)
        return;
    r->fetching = false;
    web->n_fetches[r->lane]--;
    while (!web->ending && (next = find_waiting(web)) && !is_full(next)) {
        next->waiting = false;
        if (ask_thumbnail(next) != LF_OK)
            lf_request_resume(next);
    }
}

enum MHD_Result lf_route_fetch(lf_request *r, const char *method, json_t *params,
                               unsigned patience_s)
{
    if (is_full(r)) {
        json_decref(params);
        return lf_request_refuse(r, 503, "too many requests");
    }
    if (ask(r, method, params, patience_s) != LF_OK)
        return r->route->finish(r);
    MHD_suspend_connection(r->connection);
    return MHD_YES;
}

lf_status lf_route_result(lf_request *r, const json_t **out_result, int *out_code)
{
    *out_code = 0;
    if (r->fetch)
        r->status = lf_fetch_result(r->fetch, out_result, out_code, &r->error);
    return r->status;
}

enum MHD_Result lf_route_fetch_failed(lf_request *r, int code)
{
    const bool refused = r->status == LF_E_STATE && code != 0;
    if (refused)
        r->error.where[0] = '\0'; /* the words are quiltd's */
    return lf_request_refuse_json(r, refused ? 422 : 503, refused ? code : LF_RPC_BUSY, &r->error);
}

/* The file of r->fd as the JPEG that quiltd says it is. */
static enum MHD_Result reply_jpeg(lf_request *r, size_t bytes)
{
    const int fd = r->fd;
    r->fd = -1;
    return lf_reply_jpeg(r->connection, fd, bytes);
}

/* ---------------------------------------------------------------------------------- requests -- */

static enum MHD_Result act_page(lf_request *r)
{
    return lf_reply_page(r->connection, lf_page_find(r->path));
}

/* A program, or a page that asks its user for access, looks whether somebody is there. */
static enum MHD_Result act_alive(lf_request *r)
{
    return lf_reply_text(r->connection, 200, "quiltweb");
}

static enum MHD_Result act_options(lf_request *r)
{
    return lf_reply_options(r->connection);
}

static enum MHD_Result act_login(lf_request *r)
{
    return lf_reply_cookie(r->connection, &r->web->services[r->service].guard, r->secure);
}

static enum MHD_Result act_status(lf_request *r)
{
    return lf_route_fetch(r, "status", NULL, PATIENCE_S);
}

static enum MHD_Result finish_status(lf_request *r)
{
    const json_t *result = NULL;
    int code = 0;
    if (lf_route_result(r, &result, &code) != LF_OK)
        return lf_request_refuse(r, 503, r->error.what);
    return lf_reply_json(r->connection, 200, result);
}

static enum MHD_Result act_still(lf_request *r)
{
    r->status = lf_memory_create(&r->fd, &r->error);
    if (r->status != LF_OK)
        return r->route->finish(r);
    return lf_route_fetch(r, "frame.get", json_pack("{s:i, s:s}", "views", 1, "format", "jpeg"),
                          PATIENCE_S);
}

static enum MHD_Result finish_still(lf_request *r)
{
    const json_t *result = NULL;
    lf_web_image image = {0};
    int code = 0;
    lf_status status = lf_route_result(r, &result, &code);
    if (status == LF_OK)
        status = lf_web_image_read(result, r->fd, &image, &r->error);
    return status == LF_OK ? reply_jpeg(r, image.bytes) : lf_request_refuse(r, 503, r->error.what);
}

static enum MHD_Result check_thumbnail(lf_request *r)
{
    static const lf_query_key keys[] = {{"file", "file", LF_QUERY_TEXT, true},
                                        {"width", "width", LF_QUERY_WHOLE, false},
                                        {NULL, NULL, LF_QUERY_TEXT, false}};
    lf_error err = {0};
    if (lf_query_read(r->connection, keys, &r->query, &err) != LF_OK)
        return lf_request_refuse_json(r, 400, LF_RPC_INVALID_PARAMS, &err);
    return MHD_YES;
}

static enum MHD_Result act_thumbnail(lf_request *r)
{
    r->waiting = is_full(r);
    if (!r->waiting && ask_thumbnail(r) != LF_OK)
        return r->route->finish(r);
    MHD_suspend_connection(r->connection);
    return MHD_YES;
}

static enum MHD_Result finish_thumbnail(lf_request *r)
{
    const json_t *result = NULL;
    int code = 0;
    if (lf_route_result(r, &result, &code) == LF_OK) {
        const json_int_t bytes = json_integer_value(json_object_get(result, "bytes"));
        if (bytes > 0 && (uint64_t)bytes == lf_memory_bytes(r->fd))
            return reply_jpeg(r, (size_t)bytes);
        r->status = lf_error_set(&r->error, LF_E_FORMAT, "library.thumbnail",
                                 "the image has another size than said");
    }
    return lf_route_fetch_failed(r, code);
}

static void count(lf_web *web, lf_web_counts *counts)
{
    counts->websockets = lf_seats_count(web);
    counts->streams = web->n_streams;
    counts->upload_files = lf_uploads_count(web->uploads);
    counts->upload_bytes = lf_uploads_bytes(web->uploads);
    counts->download_files = lf_downloads_count(web->downloads);
    counts->download_bytes = lf_downloads_bytes(web->downloads);
    if (web->driver) {
        counts->driver_commands = lf_driver_commands(web->driver);
        counts->driver_failures = lf_driver_failures(web->driver);
        counts->driver_bytes = lf_driver_bytes(web->driver);
    }
    if (!web->bridge)
        return;
    counts->bridge_requests = lf_bridge_requests(web->bridge);
    counts->bridge_failures = lf_bridge_failures(web->bridge);
}

static void write_metrics(lf_request *r, const json_t *status, FILE *out)
{
    lf_web *web = r->web;
    lf_web_counts counts = web->counts;
    count(web, &counts);
    lf_prometheus_write(status, out);
    lf_web_counts_write(&counts, out);
}

/* Also of a quiltd that does not answer. */
static enum MHD_Result finish_metrics(lf_request *r)
{
    const json_t *result = NULL;
    char *text = NULL;
    size_t n = 0;
    int code = 0;
    FILE *out = open_memstream(&text, &n);
    if (!out)
        return MHD_NO;
    write_metrics(r, lf_route_result(r, &result, &code) == LF_OK ? result : NULL, out);
    const bool written = fclose(out) == 0;
    enum MHD_Result sent = written ? lf_reply_metrics(r->connection, text) : MHD_NO;
    free(text);
    return sent;
}

/* ------------------------------------------------------------------------------------- paths -- */

static const lf_route page_route = {.act = act_page};
static const lf_route options_route = {.act = act_options};

static const lf_route routes[] = {
    {.path = "/api/login", .method = "POST", .needs = LF_NEEDS_TOKEN, .act = act_login},
    {.path = "/api/status",
     .method = "GET",
     .needs = LF_NEEDS_TOKEN_OR_COOKIE,
     .act = act_status,
     .finish = finish_status},
    {.path = "/preview.jpg",
     .method = "GET",
     .needs = LF_NEEDS_TOKEN_OR_COOKIE,
     .act = act_still,
     .finish = finish_still},
    {.path = "/preview.mjpg",
     .method = "GET",
     .needs = LF_NEEDS_TOKEN_OR_COOKIE,
     .act = lf_send_stream,
     .finish = lf_send_stream_begun},
    {.path = "/metrics",
     .method = "GET",
     .needs = LF_NEEDS_TOKEN_OR_COOKIE,
     .act = act_status,
     .finish = finish_metrics},
    {.path = "/api/thumbnail",
     .method = "GET",
     .needs = LF_NEEDS_TOKEN_OR_COOKIE,
     .lane = LF_LANE_THUMBNAILS,
     .check = check_thumbnail,
     .act = act_thumbnail,
     .finish = finish_thumbnail},
    {.path = LF_DOWNLOADS_PREFIX,
     .is_start = true,
     .method = "GET",
     .needs = LF_NEEDS_TOKEN_OR_COOKIE,
     .act = lf_send_download},
    {.path = "/api/upload",
     .method = "PUT",
     .needs = LF_NEEDS_TO_WRITE,
     .take = lf_put_take,
     .check = lf_put_check_upload,
     .act = lf_put_upload},
    {.path = "/api/quilt",
     .method = "PUT",
     .needs = LF_NEEDS_TO_WRITE,
     .lane = LF_LANE_QUILTS,
     .take = lf_put_take,
     .check = lf_put_check_quilt,
     .act = lf_put_quilt,
     .finish = lf_put_quilt_shown},
    /* it looks at the secrets itself */
    {.path = "/rpc", .method = "GET", .act = lf_sessions_answer},
    {.service = LF_SERVICE_BRIDGE, .path = "/", .method = "GET", .act = act_alive},
    {.service = LF_SERVICE_BRIDGE,
     .path = "/",
     .is_start = true,
     .method = "PUT",
     .body_limit = LF_BRIDGE_BODY,
     .take = lf_bridge_put_take,
     .act = lf_bridge_put,
     .finish = lf_bridge_put_done},
    {.service = LF_SERVICE_EVENTS, .path = "/", .method = "GET", .act = act_alive},
    {.service = LF_SERVICE_EVENTS,
     .path = "/event_source",
     .method = "GET",
     .act = lf_bridge_events_answer},
    {.service = LF_SERVICE_WEBXR, .path = "/", .method = "GET", .act = lf_webxr_root},
    {.service = LF_SERVICE_WEBXR, .path = "/driver", .method = "GET", .act = lf_webxr_driver},
};

enum { N_ROUTES = sizeof routes / sizeof routes[0] };

static bool leads(const lf_route *route, const char *path)
{
    const size_t n = strlen(route->path);
    return route->is_start ? strncmp(route->path, path, n) == 0 && path[n] != '\0'
                           : strcmp(route->path, path) == 0;
}

const lf_route *lf_route_find(lf_service service, const char *path, const char *method,
                              unsigned *out_status)
{
    const bool page = service == LF_SERVICE_PAGE && lf_page_find(path);
    *out_status = page ? 405 : 404;
    if (page && (strcmp(method, "GET") == 0 || strcmp(method, "HEAD") == 0))
        return &page_route;
    for (int i = 0; i < N_ROUTES; i++) {
        if (routes[i].service != service || !leads(&routes[i], path))
            continue;
        if (strcmp(routes[i].method, method) == 0)
            return &routes[i];
        if (service != LF_SERVICE_PAGE && strcmp(method, "OPTIONS") == 0)
            return &options_route;
        *out_status = 405;
    }
    return NULL;
}
