#include "daemon/server/methods.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/frame_name.h"
#include "base/nearest.h"

/* More are not looked at for what was meant. */
#define MOST_METHODS 64

struct lf_deferred {
    uint64_t client;
    json_t *id;   /* a copy */
    bool silent;  /* a notification: nobody waits for an answer */
    size_t bytes; /* of the client's lines that are held */
};

/* ----------------------------------------------------------------------------------- answers -- */

void lf_reply(lf_call *call, json_t *result)
{
    call->answered = true;
    if (!call->id) {
        json_decref(result);
    } else if (!result) {
        lf_client_send(call->client,
                       lf_rpc_error(call->id, LF_RPC_INTERNAL, "out of memory", NULL));
    } else {
        lf_client_send(call->client, lf_rpc_result(call->id, result));
    }
}

/* The result is the last member of the answer: what is added to it stands before two brackets. */
static char *answer_with(const lf_call *call, json_t *result, const char *key, const char *text)
{
    json_t *message = lf_rpc_result(call->id, result);
    char *head = message ? json_dumps(message, JSON_COMPACT) : NULL, *whole = NULL;
    if (head && asprintf(&whole, "%.*s,\"%s\":%s}}", (int)strlen(head) - 2, head, key, text) < 0)
        whole = NULL;
    free(head);
    json_decref(message);
    return whole;
}

void lf_reply_with(lf_call *call, json_t *result, const char *key, const char *text)
{
    call->answered = true;
    if (!call->id) {
        json_decref(result);
        return;
    }
    char *answer = answer_with(call, result, key, text);
    size_t n = answer ? strlen(answer) : 0;
    lf_error err;
    if (!answer) {
        lf_reply(call, NULL);
    } else if (n >= LF_RPC_MAX_LINE) {
        (void)lf_error_set(&err, LF_E_NOMEM, call->method, "the answer is longer than 1 MiB");
        lf_fail(call, &err, false);
    } else {
        lf_client_send_text(call->client, answer, n);
    }
    free(answer);
}

void lf_fail(lf_call *call, const lf_error *err, bool scene)
{
    call->answered = true;
    if (call->id)
        lf_client_send(call->client, lf_rpc_error_of(call->id, err, scene));
}

lf_deferred *lf_defer(lf_call *call)
{
    size_t bytes = 0;
    bool held = lf_client_hold(call->client, &bytes);
    lf_deferred *deferred = held ? lf_calloc(1, sizeof *deferred) : NULL;
    if (held && !deferred)
        lf_clients_release(call->server->clients, lf_client_serial(call->client), bytes);
    if (!deferred) {
        lf_error err;
        (void)lf_error_set(&err, LF_E_BUSY, call->method,
                           "too many calls of this client are waiting for an answer");
        lf_fail(call, &err, false);
        return NULL;
    }
    *deferred = (lf_deferred){.client = lf_client_serial(call->client),
                              .id = json_deep_copy(call->id),
                              .silent = !call->id,
                              .bytes = bytes};
    call->answered = true;
    return deferred;
}

size_t lf_deferred_bytes(const lf_deferred *deferred)
{
    return deferred->bytes;
}

uint64_t lf_deferred_client(const lf_deferred *deferred)
{
    return deferred->client;
}

/* Sends message to whoever waits for it, and frees the deferred call. */
static void send_answer(lf_server *server, lf_deferred *deferred, json_t *message)
{
    lf_client *client = server->clients ? lf_clients_find(server->clients, deferred->client) : NULL;
    if (client && !deferred->silent)
        lf_client_send(client, json_incref(message));
    if (server->clients)
        lf_clients_release(server->clients, deferred->client, deferred->bytes);
    json_decref(message);
    json_decref(deferred->id);
    lf_free(deferred);
}

void lf_deferred_reply(lf_server *server, lf_deferred *deferred, json_t *result)
{
    if (!deferred)
        json_decref(result);
    else if (!result)
        send_answer(server, deferred,
                    lf_rpc_error(deferred->id, LF_RPC_INTERNAL, "out of memory", NULL));
    else
        send_answer(server, deferred, lf_rpc_result(deferred->id, result));
}

void lf_deferred_fail(lf_server *server, lf_deferred *deferred, const lf_error *err, bool scene)
{
    if (deferred)
        send_answer(server, deferred, lf_rpc_error_of(deferred->id, err, scene));
}

/* ------------------------------------------------------------------------------------- lines -- */

static int find_method(const char *name)
{
    int index = 0;
    while (lf_method_at(index) && strcmp(lf_method_at(index)->name, name) != 0)
        index++;
    return lf_method_at(index) ? index : -1;
}

static void refuse_method(lf_client *client, const lf_rpc_request *request)
{
    const char *names[MOST_METHODS + 1] = {NULL};
    lf_error err;
    for (int i = 0; i < MOST_METHODS && lf_method_at(i); i++)
        names[i] = lf_method_at(i)->name;
    const char *meant = lf_nearest_name(request->method, names);
    if (meant)
        (void)lf_error_set(&err, LF_E_ARG, "", "there is no method \"%.64s\"; did you mean \"%s\"?",
                           request->method, meant);
    else
        (void)lf_error_set(&err, LF_E_ARG, "", "there is no method \"%.64s\"; hello lists them",
                           request->method);
    if (request->id)
        lf_client_send(client, lf_rpc_error(request->id, LF_RPC_METHOD_NOT_FOUND, err.what, NULL));
}

void lf_server_request(lf_server *server, lf_client *client, const lf_rpc_request *request)
{
    lf_call call = {.server = server,
                    .client = client,
                    .id = request->id,
                    .params = request->params,
                    .method = request->method};
    int index = find_method(request->method);
    if (index < 0) {
        refuse_method(client, request);
        return;
    }
    const lf_method *method = lf_method_at(index);
    lf_error err;
    if (lf_schema_check(lf_method_schema(index), request->params, method->name, &err) != LF_OK) {
        lf_fail(&call, &err, false);
    } else if (lf_server_is_stopping(server)) {
        (void)lf_error_set(&err, LF_E_BUSY, method->name, "the daemon is shutting down");
        lf_fail(&call, &err, false);
    } else {
        method->run(&call);
    }
}

void lf_server_line(void *context, lf_client *client, const char *line, size_t n)
{
    lf_server *server = context;
    lf_rpc_request request;
    json_t *answer;
    if (n >= LF_LONG_LINE) {
        if (!lf_server_parse_later(server, client, line, n))
            lf_client_send(client, lf_rpc_error(NULL, LF_RPC_INTERNAL, "out of memory", NULL));
        return;
    }
    if (!lf_rpc_parse(line, n, &request, &answer)) {
        lf_client_send(client, answer);
        return;
    }
    lf_server_request(server, client, &request);
    lf_rpc_request_finish(&request);
}

/* ------------------------------------------------------------------------------- other names -- */

lf_status lf_denoise_word(const json_t *params, const char *where, const char **out_word,
                          lf_error *err)
{
    const char *word = json_string_value(json_object_get(params, "reconstruct")),
               *other = json_string_value(json_object_get(params, "denoise"));
    *out_word = word ? word : other;
    return word && other ? lf_error_set_at(err, LF_E_ARG, where, 0, "/denoise",
                                           "is another name for reconstruct: give one of them")
                         : LF_OK;
}

/* ------------------------------------------------------------------------------------- paths -- */

/* Paths of clients are absolute (quiltctl makes them so); others are taken from the scene's folder.
 */
static char *absolute(const lf_server *server, const char *path)
{
    char *folder = server->config.scene ? lf_path_folder(server->config.scene) : NULL;
    char *joined = lf_path_join(folder ? folder : "/", path);
    lf_free(folder);
    return joined;
}

/* Of a name with a place for a frame's number no file need be there, but its folder. */
static lf_status resolve(const lf_server *server, const char *name, char **out_path, lf_error *why)
{
    lf_status status = lf_roots_resolve(&server->roots, name, out_path, why);
    if (status != LF_E_IO || !lf_frame_name_varies(name))
        return status;
    char *folder = lf_path_folder(name), *real = NULL;
    status = folder ? lf_roots_resolve(&server->roots, folder, &real, why) : LF_E_NOMEM;
    if (status == LF_OK) {
        *out_path = lf_path_join(real, strrchr(name, '/') + 1);
        status = *out_path ? LF_OK : LF_E_NOMEM;
    }
    lf_free(folder);
    lf_free(real);
    return status;
}

lf_status lf_server_read_path(const lf_server *server, const char *path, char **out_path,
                              lf_error *err)
{
    if (path[0] == '\0')
        return lf_error_set(err, LF_E_ARG, path, "a file's name is empty");
    char *name = absolute(server, path);
    if (!name)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_error why;
    lf_status status = resolve(server, name, out_path, &why);
    lf_free(name);
    if (status == LF_OK)
        return LF_OK;
    if (status == LF_E_PATH)
        return lf_error_set(err, status, path,
                            "lies neither beneath the scene's folder nor beneath an --allow-path "
                            "of quiltd, and its descriptor was not passed (quiltctl passes those "
                            "of files that you may read)%s",
                            lf_hidden_home(path));
    return lf_error_set(err, status, path, "%s", why.what);
}

lf_status lf_server_write_path(const lf_server *server, const char *path, lf_held_name *out,
                               lf_error *err)
{
    if (!server->export_root)
        return lf_error_set(
            err, LF_E_PATH, path,
            "the daemon was started without --export-dir: it writes no files by name");
    return lf_held_name_open(server->export_root, "--export-dir", path, out, err);
}
