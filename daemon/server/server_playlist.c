/* The slideshow (daemon/parts/play_list.h): its methods, the loads of its entries, and its
 * notification. */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "daemon/server/server_internal.h"
#include "quilt/quilt.h"

/* Of the entries as JSON: they are in each answer and notification. */
#define MOST_BYTES ((size_t)256 << 10)
/* Clients whose entries are checked at the same time; the others wait. */
#define CHECKS_AT_ONCE 2

/* -------------------------------------------------------------------------------------- told -- */

static json_t *entry_json(const lf_playlist_entry *entry)
{
    return json_pack("{s:o, s:f}", "file", lf_rpc_text(entry->file), "seconds", entry->seconds);
}

static json_t *whole_json(const lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    json_t *entries = json_array();
    for (int i = 0; i < now.n; i++)
        (void)json_array_append_new(entries, entry_json(&now.entries[i]));
    return json_pack("{s:o, s:i, s:b, s:b}", "entries", entries, "index", now.index, "playing",
                     (int)now.playing, "loop", (int)now.loop);
}

json_t *lf_server_playlist_json(const lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    return now.n == 0 ? json_null()
                      : json_pack("{s:i, s:b, s:i}", "index", now.index, "playing",
                                  (int)now.playing, "entries", now.n);
}

/* ------------------------------------------------------------------------------------ events -- */

/* An image whose name has no tiles is shown as one view. */
static bool on_due(void *context, const char *file)
{
    lf_server *server = context;
    int columns, rows;
    double aspect;
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    if (load)
        load->file = lf_strdup(file);
    if (!load || !load->file) {
        lf_load_destroy(load);
        return false;
    }
    load->job.listed = load->fresh = true;
    if (lf_image_ending(file) && !lf_layout_from_name(file, &columns, &rows, &aspect))
        load->words.columns = load->words.rows = 1;
    lf_server_load(server, load, NULL);
    server->gallery.listed = load->job.id;
    return true;
}

static void on_vain(void *context)
{
    lf_server *server = context;
    lf_server_cancel_load(server, server->gallery.listed);
}

static void on_changed(void *context)
{
    const lf_server *server = context;
    lf_notify(server->clients, LF_EVENT_PLAYLIST, "playlist", whole_json(server));
}

lf_status lf_server_make_playlist(lf_server *server)
{
    static const lf_playlist_events events = {
        .due = on_due, .vain = on_vain, .changed = on_changed};
    lf_status status =
        lf_playlist_create(server->event, &events, server, &server->gallery.playlist);
    return status == LF_OK ? lf_errands_create("lf-playlist", CHECKS_AT_ONCE, server,
                                               &server->inbox, &server->gallery.checks)
                           : status;
}

/* ------------------------------------------------------------------------------ playlist.set -- */

/* Entries whose paths are checked. */
typedef struct checking {
    lf_errand errand;
    const lf_roots *roots;
    lf_deferred *deferred;
    lf_playlist_entry *entries;
    int n;
    bool loop;
} checking;

static void free_checking(checking *c)
{
    lf_playlist_entries_free(c->entries, c->n);
    lf_free(c);
}

static lf_status refuse(int index, const char *file, lf_status status, const lf_error *why,
                        lf_error *err)
{
    char pointer[48];
    snprintf(pointer, sizeof pointer, "/entries/%d/file", index);
    return lf_error_set_at(err, status, "playlist.set", 0, pointer, "%s%s %s", file,
                           status == LF_E_PATH ? "" : ":", why->what);
}

static size_t bytes_of(const lf_playlist_entry *entry)
{
    json_t *json = entry_json(entry);
    const size_t n = json ? json_dumpb(json, NULL, 0, JSON_COMPACT) : 0;
    json_decref(json);
    return n;
}

/* On a thread of its own, since a file system may hang. */
static lf_status check_entries(lf_errand *errand, lf_error *err)
{
    checking *c = (checking *)(void *)errand;
    size_t bytes = 0;
    for (int i = 0; i < c->n; i++) {
        char *real;
        lf_error why;
        if (atomic_load(&errand->cancel))
            return lf_error_set(err, LF_E_CANCELLED, "playlist.set", "cancelled");
        lf_status status = lf_server_resolve(c->roots, c->entries[i].file, &real, &why);
        if (status == LF_E_PATH)
            (void)lf_say_outside(c->entries[i].file, &why);
        if (status != LF_OK)
            return refuse(i, c->entries[i].file, status, &why, err);
        lf_free(c->entries[i].file);
        c->entries[i].file = real;
        bytes += bytes_of(&c->entries[i]);
    }
    return bytes <= MOST_BYTES
               ? LF_OK
               : lf_error_set_at(err, LF_E_ARG, "playlist.set", 0, "/entries",
                                 "the names of the entries are longer than 256 KiB together");
}

static void on_checked(void *context, lf_errand *errand)
{
    lf_server *server = context;
    checking *c = (checking *)(void *)errand;
    if (errand->status == LF_OK && lf_server_is_stopping(server))
        errand->status = lf_error_set(&errand->err, LF_E_CANCELLED, "playlist.set",
                                      "the daemon is shutting down");
    if (errand->status != LF_OK) {
        lf_deferred_fail(c->deferred, &errand->err, errand->status != LF_E_ARG);
    } else {
        lf_playlist_set(server->gallery.playlist, c->entries, c->n, c->loop);
        c->entries = NULL;
        c->n = 0;
        lf_deferred_reply(c->deferred, whole_json(server));
    }
    free_checking(c);
    if (lf_server_is_stopping(server))
        lf_server_shutdown(server);
}

/* NULL: out of memory. */
static checking *make_checking(const lf_call *call)
{
    const json_t *list = json_object_get(call->params, "entries"),
                 *loop = json_object_get(call->params, "loop");
    const size_t n = json_array_size(list);
    checking *c = lf_calloc(1, sizeof *c);
    if (!c)
        return NULL;
    *c = (checking){.errand = {.client = lf_client_serial(call->client),
                               .run = check_entries,
                               .done = on_checked},
                    .roots = &call->server->roots,
                    .entries = lf_calloc(n > 0 ? n : 1, sizeof *c->entries),
                    .loop = !json_is_false(loop)};
    for (size_t i = 0; i < n && c->entries; i++) {
        const json_t *entry = json_array_get(list, i);
        const char *file = json_string_value(json_object_get(entry, "file"));
        c->entries[i] =
            (lf_playlist_entry){.file = lf_server_absolute(call->server, file),
                                .seconds = json_number_value(json_object_get(entry, "seconds"))};
        c->n++;
        if (!c->entries[i].file)
            break;
    }
    if (c->entries && (c->n == 0 || c->entries[c->n - 1].file))
        return c;
    free_checking(c);
    return NULL;
}

/* An empty name would be the folder of the scene. */
static lf_status check_names(const lf_call *call, lf_error *err)
{
    const uint64_t client = lf_client_serial(call->client);
    size_t i;
    json_t *entry;
    json_array_foreach(json_object_get(call->params, "entries"), i, entry)
    {
        const lf_error why = {.what = "the file name is empty"};
        if (json_string_length(json_object_get(entry, "file")) == 0)
            return refuse((int)i, "\"\"", LF_E_ARG, &why, err);
    }
    return lf_errands_count_of(call->server->gallery.checks, client) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, call->method,
                              "another playlist.set of this client is open; wait for its answer");
}

void lf_server_playlist_set(lf_call *call)
{
    lf_error err;
    if (check_names(call, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    checking *c = make_checking(call);
    if (!c) {
        lf_reply(call, NULL);
        return;
    }
    c->deferred = lf_defer(call);
    if (!c->deferred) {
        free_checking(c);
    } else if (lf_errands_add(call->server->gallery.checks, &c->errand, &err) != LF_OK) {
        lf_deferred_fail(c->deferred, &err, false);
        free_checking(c);
    }
}

/* -------------------------------------------------------------------------------- the others -- */

void lf_server_playlist_get(lf_call *call)
{
    lf_reply(call, whole_json(call->server));
}

/* False: the call has failed. */
static bool check_index(lf_call *call, int index)
{
    const int n = lf_playlist_now(call->server->gallery.playlist).n;
    lf_error err;
    if (index < n)
        return true;
    if (n == 0)
        (void)lf_error_set(&err, LF_E_STATE, call->method,
                           "the playlist has no entries; call playlist.set first");
    else
        (void)lf_error_set_at(&err, LF_E_ARG, call->method, 0, "/index",
                              "there is no entry %d; the last one is %d", index, n - 1);
    lf_fail(call, &err, false);
    return false;
}

void lf_server_playlist_play(lf_call *call)
{
    const int index = lf_param_integer(call->params, "index", -1);
    if (!check_index(call, index < 0 ? 0 : index))
        return;
    lf_playlist_play(call->server->gallery.playlist, index);
    lf_reply(call, whole_json(call->server));
}

void lf_server_playlist_stop(lf_call *call)
{
    lf_playlist_stop(call->server->gallery.playlist);
    lf_reply(call, whole_json(call->server));
}

static void step(lf_call *call, int by)
{
    if (!check_index(call, 0))
        return;
    lf_playlist_step(call->server->gallery.playlist, by);
    lf_reply(call, whole_json(call->server));
}

void lf_server_playlist_next(lf_call *call)
{
    step(call, 1);
}

void lf_server_playlist_previous(lf_call *call)
{
    step(call, -1);
}
