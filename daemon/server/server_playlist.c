/* The slideshow (daemon/parts/play_list.h): its methods, the loads of its entries, and its
 * notification. Its entries come from server_entries.c. */
#include <string.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "daemon/server/server_internal.h"
#include "quilt/quilt.h"

/* -------------------------------------------------------------------------------------- told -- */

json_t *lf_server_playlist_json(const lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    return now.n == 0 ? json_null()
                      : json_pack("{s:i, s:b, s:b, s:i, s:o}", "index", now.index, "playing",
                                  (int)now.playing, "paused", (int)now.paused, "entries", now.n,
                                  "file", lf_rpc_text(now.entries[now.index].file));
}

/* ------------------------------------------------------------------------------------ events -- */

static bool on_due(void *context, const lf_playlist_entry *entry, bool once)
{
    lf_server *server = context;
    lf_error err;
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    if (load)
        load->file = lf_strdup(entry->file);
    if (!load || !load->file || lf_server_entry_words(server, entry, &load->words, &err) != LF_OK) {
        lf_load_destroy(load);
        return false;
    }
    load->words.plays_once = once;
    load->job.listed = load->fresh = true;
    load->job.turn = lf_playlist_now(server->gallery.playlist).turn;
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
    lf_server *server = context;
    lf_server_hold_movie(server);
    lf_notify(server->clients, LF_EVENT_PLAYLIST, "playlist",
              lf_server_whole_playlist_json(server));
}

lf_status lf_server_make_playlist(lf_server *server)
{
    static const lf_playlist_events events = {
        .due = on_due, .vain = on_vain, .changed = on_changed};
    lf_status status =
        lf_playlist_create(server->event, &events, server, &server->gallery.playlist);
    return status == LF_OK ? lf_server_make_entries(server) : status;
}

/* ----------------------------------------------------------------------------------- methods -- */

static void reply(lf_call *call)
{
    lf_reply(call, lf_server_whole_playlist_json(call->server));
}

void lf_server_playlist_get(lf_call *call)
{
    reply(call);
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
    reply(call);
}

void lf_server_playlist_stop(lf_call *call)
{
    lf_playlist_stop(call->server->gallery.playlist);
    reply(call);
}

void lf_server_playlist_pause(lf_call *call)
{
    const bool paused = !json_is_false(json_object_get(call->params, "paused"));
    lf_error err;
    if (!lf_playlist_now(call->server->gallery.playlist).playing) {
        (void)lf_error_set(&err, LF_E_STATE, call->method,
                           "the slideshow is stopped; call playlist.play first");
        lf_fail(call, &err, false);
        return;
    }
    lf_playlist_pause(call->server->gallery.playlist, paused);
    reply(call);
}

/* The keys of the call take the place of the entry's. */
static lf_status change(lf_call *call, int index, lf_error *err)
{
    lf_playlist *playlist = call->server->gallery.playlist;
    const lf_playlist_state now = lf_playlist_now(playlist);
    const lf_playlist_entry *before = &now.entries[index];
    lf_playlist_entry entry = {.file = before->file, .seconds = before->seconds};
    json_t *merged = before->keys ? json_copy(before->keys) : json_object();
    lf_load_words words = {0};
    (void)json_object_update(merged, call->params);
    (void)json_object_del(merged, "index");
    lf_status status = lf_server_take_entry(merged, &entry, err);
    if (status == LF_OK)
        status = lf_server_entry_words(call->server, &entry, &words, err);
    if (status == LF_OK)
        lf_playlist_change(playlist, index, entry.seconds, entry.keys);
    json_decref(entry.keys);
    json_decref(merged);
    return status;
}

void lf_server_playlist_change(lf_call *call)
{
    const lf_playlist_state now = lf_playlist_now(call->server->gallery.playlist);
    const int index = lf_param_integer(call->params, "index", now.index);
    lf_error err;
    if (!check_index(call, index))
        return;
    if (change(call, index, &err) == LF_OK)
        reply(call);
    else
        lf_fail(call, &err, false);
}

static void step(lf_call *call, int by)
{
    if (!check_index(call, 0))
        return;
    lf_playlist_step(call->server->gallery.playlist, by);
    reply(call);
}

void lf_server_playlist_next(lf_call *call)
{
    step(call, 1);
}

void lf_server_playlist_previous(lf_call *call)
{
    step(call, -1);
}
