/* The slideshow (daemon/parts/play_list.h): its methods, the loads of its entries, and its
 * notification. Its entries come from server_entries.c. */
#include <string.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "daemon/server/server_internal.h"
#include "quilt/quilt.h"

/* -------------------------------------------------------------------------------------- told -- */

json_t *lf_server_entry_json(const lf_playlist_entry *entry)
{
    json_t *json = entry->keys ? json_copy(entry->keys) : json_object();
    (void)json_object_set_new(json, "file", lf_rpc_text(entry->file));
    if (entry->seconds > 0)
        (void)json_object_set_new(json, "seconds", json_real(entry->seconds));
    return json;
}

json_t *lf_server_whole_playlist_json(const lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    const char *folder = server->gallery.folder.path;
    json_t *entries = json_array();
    for (int i = 0; i < now.n; i++)
        (void)json_array_append_new(entries, lf_server_entry_json(&now.entries[i]));
    return json_pack("{s:o, s:o, s:b, s:i, s:b, s:b, s:b, s:f, s:f}", "entries", entries, "folder",
                     folder ? lf_rpc_text(folder) : json_null(), "more",
                     (int)server->gallery.folder.more, "index", now.index, "playing",
                     (int)now.playing, "paused", (int)now.paused, "loop", (int)now.how.loop,
                     "seconds", now.how.seconds, "crossfade", now.how.crossfade);
}

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
    lf_server_load(server, load, NULL);
    server->gallery.listed = load->job.id;
    return true;
}

static void on_vain(void *context)
{
    lf_server *server = context;
    lf_server_cancel_load(server, server->gallery.listed);
}

/* Another content starts unpaused. */
static void hold_movie(lf_server *server)
{
    const bool paused = lf_playlist_now(server->gallery.playlist).paused;
    if (paused != server->gallery.holds)
        lf_engine_pause_movie(server->engine, paused);
    server->gallery.holds = paused;
}

static void on_changed(void *context)
{
    lf_server *server = context;
    hold_movie(server);
    lf_notify(server->clients, LF_EVENT_PLAYLIST, "playlist",
              lf_server_whole_playlist_json(server));
}

void lf_server_entry_loaded(lf_server *server, const lf_load *load)
{
    const bool failed = load->status != LF_OK;
    if (!failed) {
        server->gallery.holds = false;
        hold_movie(server);
    }
    lf_playlist_loaded(server->gallery.playlist, load->generation,
                       !failed && server->content->player, failed ? &load->err : NULL);
    lf_server_look_at_movie(server); /* it may have ended already */
}

void lf_server_look_at_movie(lf_server *server)
{
    lf_gallery *gallery = &server->gallery;
    const int64_t generation = server->last.generation;
    lf_movie_status now;
    if (!lf_engine_get_movie(server->engine, &now))
        return;
    const bool more = generation == gallery->round_of && now.player.rounds > gallery->rounds;
    gallery->round_of = generation;
    gallery->rounds = now.player.rounds;
    if (now.player.failed || now.player.ended || more)
        lf_playlist_played(gallery->playlist, generation,
                           now.player.failed ? &now.player.err : NULL);
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
    const lf_playlist_entry *before = &lf_playlist_now(playlist).entries[index];
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
