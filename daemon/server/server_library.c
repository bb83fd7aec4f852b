/* library.list and library.thumbnail (daemon/parts/library.h): their calls and answers. */
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/server/server_internal.h"

#define WIDTH 160

static void on_ended(void *context, void *call, json_t *result, const lf_error *err)
{
    lf_server *server = context;
    if (result)
        lf_deferred_reply(call, result);
    else
        lf_deferred_fail(call, err, err->status != LF_E_ARG);
    if (lf_server_is_stopping(server))
        lf_server_shutdown(server);
}

lf_status lf_server_make_library(lf_server *server)
{
    return lf_library_create(&server->inbox, &server->roots, on_ended, server,
                             &server->gallery.library);
}

/* The absolute path of a parameter, owned by the caller. */
static lf_status take_path(const lf_call *call, const char *key, char **out, lf_error *err)
{
    const char *path = json_string_value(json_object_get(call->params, key));
    char pointer[32];
    snprintf(pointer, sizeof pointer, "/%s", key);
    if (path && path[0] == '\0')
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, pointer, "the name is empty");
    *out = path ? lf_server_absolute(call->server, path) : NULL;
    return *out || !path ? LF_OK : lf_error_set(err, LF_E_NOMEM, call->method, "out of memory");
}

void lf_server_library_list(lf_call *call)
{
    const uint64_t client = lf_client_serial(call->client);
    lf_library *library = call->server->gallery.library;
    char *folder = NULL;
    lf_error err;
    if (lf_library_check_room(library, client, call->method, &err) != LF_OK ||
        take_path(call, "folder", &folder, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    lf_deferred *deferred = lf_defer(call);
    if (!deferred)
        lf_free(folder);
    else if (lf_library_list(library, client, folder, deferred, &err) != LF_OK)
        lf_deferred_fail(deferred, &err, false);
}

/* Takes ownership of fd. */
static void make_thumbnail(lf_call *call, int fd)
{
    const uint64_t client = lf_client_serial(call->client);
    const int width = lf_param_integer(call->params, "width", WIDTH);
    lf_library *library = call->server->gallery.library;
    char *file = NULL;
    lf_error err;
    if (lf_library_check_room(library, client, call->method, &err) != LF_OK ||
        take_path(call, "file", &file, &err) != LF_OK) {
        close(fd);
        lf_fail(call, &err, false);
        return;
    }
    lf_deferred *deferred = lf_defer(call);
    if (!deferred) {
        lf_free(file);
        close(fd);
    } else if (lf_library_thumbnail(library, client, file, width, fd, deferred, &err) != LF_OK) {
        lf_deferred_fail(deferred, &err, false);
    }
}

void lf_server_thumbnail(lf_call *call)
{
    lf_error err;
    int fd;
    if (lf_client_take_fds(call->client, &fd, 1)) {
        make_thumbnail(call, fd);
        return;
    }
    (void)lf_error_set(&err, LF_E_ARG, call->method,
                       "expects a file descriptor to write to; none came with the call");
    lf_fail(call, &err, false);
}
