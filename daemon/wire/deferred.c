#include "daemon/wire/deferred.h"

#include "base/alloc.h"

struct lf_deferred {
    lf_clients *clients;
    uint64_t client;
    json_t *id;   /* a copy */
    bool silent;  /* a notification: no answer */
    size_t bytes; /* bytes of the client's line that are held */
};

lf_deferred *lf_deferred_create(lf_clients *clients, lf_client *client, const json_t *id)
{
    size_t bytes = 0;
    if (!lf_client_hold(client, &bytes))
        return NULL;
    lf_deferred *deferred = lf_calloc(1, sizeof *deferred);
    if (!deferred) {
        lf_clients_release(clients, lf_client_serial(client), bytes);
        return NULL;
    }
    *deferred = (lf_deferred){.clients = clients,
                              .client = lf_client_serial(client),
                              .id = json_deep_copy(id),
                              .silent = !id,
                              .bytes = bytes};
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

bool lf_deferred_is_vain(const lf_deferred *deferred)
{
    return !lf_clients_find(deferred->clients, deferred->client);
}

/* Sends message to the client, if it is still there, and frees the deferred call. */
static void send_answer(lf_deferred *deferred, json_t *message)
{
    lf_client *client = lf_clients_find(deferred->clients, deferred->client);
    if (client && !deferred->silent)
        lf_client_send(client, json_incref(message));
    lf_clients_release(deferred->clients, deferred->client, deferred->bytes);
    json_decref(message);
    json_decref(deferred->id);
    lf_free(deferred);
}

void lf_deferred_reply(lf_deferred *deferred, json_t *result)
{
    if (!deferred)
        json_decref(result);
    else if (!result)
        send_answer(deferred, lf_rpc_error(deferred->id, LF_RPC_INTERNAL, "out of memory", NULL));
    else
        send_answer(deferred, lf_rpc_result(deferred->id, result));
}

void lf_deferred_fail(lf_deferred *deferred, const lf_error *err, bool scene)
{
    if (deferred)
        send_answer(deferred, lf_rpc_error_of(deferred->id, err, scene));
}

void lf_deferred_fail_saying(lf_deferred *deferred, const lf_error *err, bool scene,
                             const char *message)
{
    if (deferred)
        send_answer(deferred, lf_rpc_error_saying(deferred->id, err, scene, message));
}
