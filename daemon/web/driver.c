#include "daemon/web/driver_internal.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/wire/rpc.h"

enum { ID = 4, REQUEST_BIT = 0x80 };

static const char where[] = "driver";

lf_status lf_driver_create(const lf_driver_config *config, lf_driver **out, lf_error *err)
{
    lf_driver *driver = lf_calloc(1, sizeof *driver);
    char *socket = lf_strdup(config->socket), *version = lf_strdup(config->version);
    if (!driver || !socket || !version) {
        lf_free(driver);
        lf_free(socket);
        lf_free(version);
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    }
    *driver = (lf_driver){.event = config->event,
                          .socket = socket,
                          .version = version,
                          .panel_only = config->panel_only};
    driver->bins =
        (lf_bins){.limit = config->image_limit, .make_room = lf_cache_make_room, .context = driver};
    *out = driver;
    return LF_OK;
}

void lf_driver_destroy(lf_driver *driver)
{
    if (!driver)
        return;
    while (lf_cache_make_room(driver))
        continue;
    lf_free(driver->socket);
    lf_free(driver->version);
    lf_free(driver);
}

uint64_t lf_driver_commands(const lf_driver *driver)
{
    return driver->n_commands;
}

uint64_t lf_driver_failures(const lf_driver *driver)
{
    return driver->n_failures;
}

uint64_t lf_driver_bytes(const lf_driver *driver)
{
    return driver->bins.used;
}

uint64_t lf_driver_longest(const lf_driver *driver)
{
    return 16 * (driver->bins.limit + LF_DRIVER_MAX_REST);
}

/* ----------------------------------------------------------------------------------- answers -- */

/* The next message may come. */
static void forget_message(lf_driver_client *client)
{
    lf_cbor_destroy(client->cbor);
    client->cbor = NULL;
    lf_bin_destroy(client->bin);
    client->bin = NULL;
    lf_fetch_destroy(client->fetch);
    client->fetch = NULL;
    json_decref(client->message);
    json_decref(client->calibration);
    json_decref(client->quilt);
    client->message = client->calibration = client->quilt = NULL;
    if (client->quilt_fd >= 0)
        close(client->quilt_fd);
    client->quilt_fd = -1;
    client->command = NULL;
    client->params = NULL;
    client->n_ids = 0;
    client->has_request = client->malformed = client->busy = client->is_taken = false;
}

/* The header, and the answer in CBOR. */
static void send_answer(lf_driver_client *client, json_t *answer)
{
    uint8_t *body = NULL;
    size_t n = 0;
    if (lf_cbor_write(answer, &body, &n) != LF_OK) {
        lf_log(LF_LOG_WARNING, "%s: an answer was lost: out of memory", where);
        return;
    }
    uint8_t *data = lf_calloc(client->n_ids + n, 1);
    if (data) {
        memcpy(data, client->ids, client->n_ids);
        memcpy(data + client->n_ids, body, n);
        client->events.reply(client->events.context, data, client->n_ids + n);
    }
    lf_free(data);
    free(body);
}

void lf_driver_answer(lf_driver_client *client, json_t *answer)
{
    json_t *whole =
        json_pack("{s:i, s:s}", "error", LF_DRIVER_NONE, "version", client->driver->version);
    if (whole && answer)
        json_object_update(whole, answer);
    client->driver->n_commands++;
    send_answer(client, answer ? whole : NULL);
    json_decref(answer);
    json_decref(whole);
    forget_message(client);
}

void lf_driver_fail(lf_driver_client *client, lf_driver_error error, const char *why, json_t *more)
{
    const char *name = client->command ? client->command->name : "message";
    lf_log(LF_LOG_WARNING, "%s: %s: %s", where, name, why);
    client->driver->n_failures++;
    json_t *answer = json_pack("{s:i, s:o}", "error", (int)error, "message", lf_rpc_text(why));
    if (answer && more)
        json_object_update(answer, more);
    json_decref(more);
    lf_driver_answer(client, answer);
}

/* --------------------------------------------------------------------------- calls of quiltd -- */

static void on_fetched(void *context)
{
    const lf_driver_client *client = context;
    sd_event_source_set_enabled(client->turn, SD_EVENT_ONESHOT);
}

void lf_driver_ask(lf_driver_client *client, const char *method, json_t *params, int fd,
                   unsigned patience_s)
{
    const lf_fetch_call call = {
        .method = method, .params = params, .fd = fd, .patience_s = patience_s};
    lf_error err = {0};
    lf_fetch_destroy(client->fetch);
    client->fetch = NULL;
    lf_status status = lf_fetch_create(client->driver->event, client->driver->socket, &call,
                                       on_fetched, client, &client->fetch, &err);
    json_decref(params);
    if (status != LF_OK)
        lf_driver_fail(client, LF_DRIVER_FAILED, err.what, NULL);
}

lf_status lf_driver_result(lf_driver_client *client, const json_t **out_result, int *out_code,
                           lf_error *err)
{
    *out_code = 0;
    return lf_fetch_result(client->fetch, out_result, out_code, err);
}

/* ---------------------------------------------------------------------------------- commands -- */

/* The message is whole. */
static void begin_command(lf_driver_client *client)
{
    lf_error err = {0};
    lf_status status = client->cbor
                           ? lf_cbor_finish(client->cbor, &client->message, &err)
                           : lf_error_set(&err, LF_E_FORMAT, "CBOR", "the message is empty");
    if (status != LF_OK) {
        lf_driver_fail(client, status == LF_E_NOMEM ? LF_DRIVER_FAILED : LF_DRIVER_BAD_CBOR,
                       err.what, NULL);
        return;
    }
    client->command = lf_command_find(client->message, &client->params);
    if (!client->command)
        lf_driver_fail(client, LF_DRIVER_BAD_COMMAND,
                       "expects one command of init, info, show, cache, check, delete, wipe and "
                       "hide",
                       NULL);
    else if (client->command->shows && lf_panel_only_is_on(client->driver->panel_only))
        lf_driver_fail(client, LF_DRIVER_NOT_ALLOWED, LF_PANEL_ONLY_WORDS, NULL);
    else
        client->command->begin(client);
}

/* ------------------------------------------------------------------------------------- input -- */

static void on_bin(void *context, const uint8_t *data, size_t n)
{
    lf_driver_client *client = context;
    if (!client->bin && lf_bin_create(&client->driver->bins, &client->bin) != LF_OK)
        return; /* as if no image had come */
    lf_bin_take(client->bin, data, n);
}

/* Takes the ids at the start of a message: the last has the top bit. *out_used: bytes. */
static void take_ids(lf_driver_client *client, const uint8_t *data, size_t n, size_t *out_used)
{
    size_t used = 0;
    while (used < n && !client->has_request && !client->malformed) {
        const size_t first = client->n_ids / ID * ID;
        client->ids[client->n_ids++] = data[used++];
        const bool whole = client->n_ids % ID == 0;
        client->has_request = whole && (client->ids[first] & REQUEST_BIT);
        client->malformed = !client->has_request && client->n_ids == sizeof client->ids;
    }
    *out_used = used;
}

/* What is wrong with the CBOR is said at the end of the message. */
static lf_status take_now(lf_driver_client *client, const uint8_t *data, size_t n)
{
    size_t used = 0;
    take_ids(client, data, n, &used);
    if (used == n || client->malformed)
        return LF_OK;
    if (!client->cbor && lf_cbor_create(on_bin, client, &client->cbor) != LF_OK)
        return LF_E_NOMEM;
    lf_cbor_take(client->cbor, data + used, n - used);
    return LF_OK;
}

static void end_now(lf_driver_client *client)
{
    if (!client->has_request) {
        forget_message(client);
        return;
    }
    client->busy = true;
    sd_event_source_set_enabled(client->turn, SD_EVENT_ONESHOT);
}

/* Keeps a part for later: its length and its bytes. No bytes: the message ends. */
static lf_status keep(lf_driver_client *client, const uint8_t *data, size_t n)
{
    const size_t size = client->later.n + sizeof n + n;
    if (n > LF_DRIVER_MAX_LATER || size > LF_DRIVER_MAX_LATER)
        return LF_E_BUSY;
    if (size > client->later.size) {
        uint8_t *more = lf_calloc(LF_DRIVER_MAX_LATER, 1);
        if (!more)
            return LF_E_NOMEM;
        client->later.data = more;
        client->later.size = LF_DRIVER_MAX_LATER;
    }
    memcpy(client->later.data + client->later.n, &n, sizeof n);
    if (n > 0)
        memcpy(client->later.data + client->later.n + sizeof n, data, n);
    client->later.n = size;
    return LF_OK;
}

/* Takes what was kept, until a command runs. */
static lf_status take_kept(lf_driver_client *client)
{
    size_t at = 0, n = 0;
    lf_status status = LF_OK;
    while (at < client->later.n && !client->busy && status == LF_OK) {
        memcpy(&n, client->later.data + at, sizeof n);
        at += sizeof n;
        if (n > 0)
            status = take_now(client, client->later.data + at, n);
        else
            end_now(client);
        at += n;
    }
    client->later.n -= at;
    memmove(client->later.data, client->later.data + at, client->later.n);
    return status;
}

lf_status lf_driver_take(lf_driver_client *client, const uint8_t *data, size_t n)
{
    if (n == 0)
        return LF_OK;
    return client->busy || client->later.n > 0 ? keep(client, data, n) : take_now(client, data, n);
}

lf_status lf_driver_end(lf_driver_client *client)
{
    if (client->busy || client->later.n > 0)
        return keep(client, NULL, 0);
    end_now(client);
    return LF_OK;
}

bool lf_driver_is_busy(const lf_driver_client *client)
{
    return client->busy;
}

/* ---------------------------------------------------------------------------------- its life -- */

/* Here, and not in a callback of the fetch or of the transport, a command may end. */
static int on_turn(sd_event_source *source, void *context)
{
    (void)source;
    lf_driver_client *client = context;
    if (client->fetch)
        client->command->go_on(client);
    else
        begin_command(client);
    if (client->busy)
        return 0;
    if (client->later.n > 0 && take_kept(client) != LF_OK)
        lf_log(LF_LOG_WARNING, "%s: a message was lost: out of memory", where);
    if (!client->busy)
        client->events.ready(client->events.context);
    return 0;
}

lf_status lf_driver_join(lf_driver *driver, const lf_driver_events *events, lf_driver_client **out)
{
    lf_driver_client *client = lf_calloc(1, sizeof *client);
    if (!client)
        return LF_E_NOMEM;
    *client = (lf_driver_client){.driver = driver, .events = *events, .quilt_fd = -1};
    if (sd_event_add_defer(driver->event, &client->turn, on_turn, client) < 0) {
        lf_free(client);
        return LF_E_NOMEM;
    }
    sd_event_source_set_enabled(client->turn, SD_EVENT_OFF);
    *out = client;
    return LF_OK;
}

void lf_driver_leave(lf_driver_client *client)
{
    if (!client)
        return;
    forget_message(client);
    sd_event_source_disable_unref(client->turn);
    lf_free(client->later.data);
    lf_free(client);
}
