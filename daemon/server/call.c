/* Answers of methods, and the allowed paths of their calls. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/former.h"
#include "base/frame_name.h"
#include "base/version.h"
#include "daemon/server/server_internal.h"

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

/* The result is the last member of the answer, so an addition goes before two closing brackets. */
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

char *lf_call_words(const char *method, const lf_error *err, char *buf, size_t size)
{
    char text[sizeof *err + 32];
    bool named = strcmp(err->where, method) == 0;
    snprintf(buf, size, "%s%s%s", named ? "" : method, named ? "" : ": ",
             lf_error_format(err, text, sizeof text));
    return buf;
}

lf_deferred *lf_defer(lf_call *call)
{
    lf_deferred *deferred = lf_deferred_create(call->server->clients, call->client, call->id);
    call->answered = true;
    if (!deferred) {
        lf_error err;
        (void)lf_error_set(
            &err, LF_E_BUSY, call->method,
            "too many calls of this client are waiting for an answer; wait for some of them");
        lf_fail(call, &err, false);
    }
    return deferred;
}

/* ------------------------------------------------------------------------------ former names -- */

lf_status lf_check_former(const json_t *schema, json_t *params, const char *method, lf_error *err)
{
    const json_t *properties = json_object_get(schema, "properties");
    const char *key;
    json_t *value;
    json_object_foreach(params, key, value)
    {
        const char *name = lf_former_name_of(json_object_get(properties, key));
        char pointer[64];
        snprintf(pointer, sizeof pointer, "/%s", key);
        if (name && json_object_get(params, name))
            return lf_error_set_at(err, LF_E_ARG, method, 0, pointer,
                                   "is the former name of %s; give only one of them", name);
        if (name)
            (void)lf_former_used(LF_VERSION, method, key, name);
    }
    return LF_OK;
}

const json_t *lf_param_or_former(const json_t *params, const char *name, const char *former)
{
    const json_t *value = json_object_get(params, name);
    return value ? value : json_object_get(params, former);
}

int lf_param_integer(const json_t *params, const char *key, int absent)
{
    const json_t *value = json_object_get(params, key);
    return value ? (int)json_number_value(value) : absent;
}

/* ------------------------------------------------------------------------------------- paths -- */

char *lf_server_absolute(const lf_server *server, const char *path)
{
    const char *played = server->config.playlist.folder;
    char *folder = server->config.scene ? lf_path_folder(server->config.scene) : NULL;
    char *joined = lf_path_join(folder ? folder : played ? played : "/", path);
    lf_free(folder);
    return joined;
}

lf_status lf_server_resolve(const lf_roots *roots, const char *name, char **out_path, lf_error *why)
{
    lf_status status = lf_roots_resolve(roots, name, out_path, why);
    if (status != LF_E_IO || !lf_frame_name_varies(name))
        return status;
    char *folder = lf_path_folder(name), *real = NULL;
    status = folder ? lf_roots_resolve(roots, folder, &real, why) : LF_E_NOMEM;
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
        return lf_error_set(err, LF_E_ARG, path, "the file name is empty");
    char *name = lf_server_absolute(server, path);
    if (!name)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_error why;
    lf_status status = lf_server_resolve(&server->roots, name, out_path, &why);
    lf_free(name);
    if (status == LF_OK)
        return LF_OK;
    if (status == LF_E_PATH)
        return lf_error_set(err, status, path,
                            "is outside the scene's folder and the folders of --allow-path; pass "
                            "its descriptor, as quiltctl does%s",
                            lf_hidden_home(path));
    return lf_error_set(err, status, path, "%s", why.what);
}

lf_status lf_server_write_path(const lf_server *server, const char *path, lf_held_name *out,
                               lf_error *err)
{
    if (!server->export_root)
        return lf_error_set(err, LF_E_PATH, path,
                            "quiltd has no --export-dir, so it writes no files by name; pass file "
                            "descriptors, as quiltctl export does");
    return lf_held_name_open(server->export_root, "--export-dir", path, out, err);
}
