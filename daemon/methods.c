#include "daemon/methods.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"

#define OUTSIDE "lies neither beneath the scene's folder nor beneath an --allow-path"

struct lf_ticket {
    uint64_t client;
    json_t *id;  /* a copy */
    bool silent; /* a notification: nobody waits for an answer */
};

/* --------------------------------------------------------------------------------------------------------- answers -- */

void lf_reply(lf_call *call, json_t *result)
{
    call->answered = true;
    if (call->id == NULL) {
        json_decref(result);
    } else if (result == NULL) {
        lf_client_send(call->client, lf_rpc_error(call->id, LF_RPC_INTERNAL, "out of memory", NULL));
    } else {
        lf_client_send(call->client, lf_rpc_result(call->id, result));
    }
}

void lf_fail(lf_call *call, const lf_error *err, bool scene)
{
    call->answered = true;
    if (call->id != NULL) {
        lf_client_send(call->client, lf_rpc_error_of(call->id, err, scene));
    }
}

lf_ticket *lf_defer(lf_call *call)
{
    lf_ticket *ticket = lf_client_hold(call->client) ? lf_calloc(1, sizeof *ticket) : NULL;
    if (ticket == NULL) {
        lf_error err;
        (void)lf_error_set(&err, LF_E_BUSY, call->method, "too many calls of this client are waiting for an answer");
        lf_fail(call, &err, false);
        return NULL;
    }
    *ticket = (lf_ticket){.client = lf_client_serial(call->client), .id = json_deep_copy(call->id), .silent = call->id == NULL};
    call->answered = true;
    return ticket;
}

uint64_t lf_ticket_client(const lf_ticket *ticket)
{
    return ticket->client;
}

/* Sends message to whoever holds the ticket, and frees it. */
static void redeem(lf_server *server, lf_ticket *ticket, json_t *message)
{
    lf_client *client = server->clients != NULL ? lf_clients_find(server->clients, ticket->client) : NULL;
    if (client != NULL) {
        if (!ticket->silent) {
            lf_client_send(client, json_incref(message));
        }
        lf_client_release(client);
    }
    json_decref(message);
    json_decref(ticket->id);
    lf_free(ticket);
}

void lf_ticket_reply(lf_server *server, lf_ticket *ticket, json_t *result)
{
    if (ticket == NULL) {
        json_decref(result);
    } else if (result == NULL) {
        redeem(server, ticket, lf_rpc_error(ticket->id, LF_RPC_INTERNAL, "out of memory", NULL));
    } else {
        redeem(server, ticket, lf_rpc_result(ticket->id, result));
    }
}

void lf_ticket_fail(lf_server *server, lf_ticket *ticket, const lf_error *err, bool scene)
{
    if (ticket != NULL) {
        redeem(server, ticket, lf_rpc_error_of(ticket->id, err, scene));
    }
}

/* ------------------------------------------------------------------------------------------------------------ lines -- */

static int find_method(const char *name)
{
    int index = 0;
    while (lf_method_at(index) != NULL && strcmp(lf_method_at(index)->name, name) != 0) {
        index++;
    }
    return lf_method_at(index) != NULL ? index : -1;
}

static void run_request(lf_server *server, lf_client *client, lf_rpc_request *request)
{
    lf_call call = {.server = server, .client = client, .id = request->id, .params = request->params, .method = request->method};
    int index = find_method(request->method);
    if (index < 0) {
        lf_error err;
        (void)lf_error_set(&err, LF_E_ARG, "", "there is no method \"%.64s\"; hello lists them", request->method);
        if (call.id != NULL) {
            lf_client_send(client, lf_rpc_error(call.id, LF_RPC_METHOD_NOT_FOUND, err.what, NULL));
        }
        return;
    }
    const lf_method *method = lf_method_at(index);
    lf_error err;
    if (lf_schema_check(lf_method_schema(index), request->params, method->name, &err) != LF_OK) {
        lf_fail(&call, &err, false);
    } else if (server->stopping) {
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
    if (!lf_rpc_parse(line, n, &request, &answer)) {
        lf_client_send(client, answer);
        return;
    }
    run_request(server, client, &request);
    lf_rpc_request_finish(&request);
}

/* ------------------------------------------------------------------------------------------------------------ paths -- */

static bool beneath(const char *root, const char *path)
{
    size_t n = strlen(root);
    return strcmp(root, "/") == 0 || (strncmp(root, path, n) == 0 && (path[n] == '/' || path[n] == '\0'));
}

/* Paths of clients are absolute (quiltctl makes them so); others are taken from the scene's folder. */
static char *absolute(const lf_server *server, const char *path)
{
    char *folder = server->config.scene != NULL ? lf_path_folder(server->config.scene) : NULL;
    char *joined = lf_path_join(folder != NULL ? folder : "/", path);
    lf_free(folder);
    return joined;
}

/* Nothing can be found there. Outside of the roots that is not said: it would tell which files exist. */
static lf_status refuse_missing(const lf_server *server, const char *path, const char *name, int why, lf_error *err)
{
    int fd = -1;
    lf_status status = name != NULL ? lf_file_open(name, &server->roots, UINT64_MAX, &fd, NULL, NULL) : LF_E_NOMEM;
    if (fd >= 0) {
        close(fd);
    }
    if (status == LF_E_PATH) {
        return lf_error_set(err, LF_E_PATH, path, OUTSIDE);
    }
    return lf_error_set(err, LF_E_IO, path, "cannot open: %s", lf_errno_text(why));
}

lf_status lf_server_read_path(const lf_server *server, const char *path, char **out_path, lf_error *err)
{
    char *name = absolute(server, path);
    char *real = name != NULL ? realpath(name, NULL) : NULL;
    int why = errno;
    bool allowed = false;
    for (int i = 0; real != NULL && i < server->roots.n_roots; i++) {
        allowed = allowed || beneath(server->roots.root[i], real);
    }
    lf_status status = LF_OK;
    if (real == NULL) {
        status = refuse_missing(server, path, name, why, err);
    } else if (!allowed) {
        status = lf_error_set(err, LF_E_PATH, path, OUTSIDE);
    } else {
        *out_path = lf_strdup(real);
        status = *out_path != NULL ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    free(real);
    lf_free(name);
    return status;
}

/* folder "/" name, with the slash that a folder of views ends in. */
static lf_status join_write_path(const char *path, const char *folder, const char *name, bool slash, char **out_path, lf_error *err)
{
    size_t size = strlen(folder) + strlen(name) + 3;
    char *joined = lf_calloc(size, 1);
    if (joined == NULL) {
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    snprintf(joined, size, "%s/%s%s", strcmp(folder, "/") == 0 ? "" : folder, name, slash ? "/" : "");
    *out_path = joined;
    return LF_OK;
}

/* name lies in the canonical folder real: it may not lead out of it by being a link. */
static bool is_link(const char *real, const char *name)
{
    char *joined = lf_path_join(real, name);
    struct stat st;
    bool link = joined == NULL || (lstat(joined, &st) == 0 && S_ISLNK(st.st_mode));
    lf_free(joined);
    return link;
}

lf_status lf_server_write_path(const lf_server *server, const char *path, char **out_path, lf_error *err)
{
    if (server->export_root == NULL) {
        return lf_error_set(err, LF_E_PATH, path, "the daemon was started without --export-dir: it writes no files by name");
    }
    char *name = path[0] == '/' ? lf_strdup(path) : lf_path_join(server->export_root, path);
    if (name == NULL) {
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    size_t n = strlen(name);
    bool slash = n > 1 && name[n - 1] == '/';
    while (n > 1 && name[n - 1] == '/') {
        name[--n] = '\0';
    }
    const char *last = strrchr(name, '/') + 1;
    char *folder = lf_path_folder(name);
    char *real = folder != NULL ? realpath(folder, NULL) : NULL;
    lf_status status;
    if (real == NULL) {
        status = lf_error_set(err, LF_E_PATH, path, "its folder cannot be opened: %s", lf_errno_text(errno));
    } else if (last[0] == '\0' || strcmp(last, ".") == 0 || strcmp(last, "..") == 0 || !beneath(server->export_root, real) ||
               is_link(real, last)) {
        status = lf_error_set(err, LF_E_PATH, path, "does not lie beneath the --export-dir %s", server->export_root);
    } else {
        status = join_write_path(path, real, last, slash, out_path, err);
    }
    free(real);
    lf_free(folder);
    lf_free(name);
    return status;
}
