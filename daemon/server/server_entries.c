/* The entries of the slideshow: playlist.set, --playlist, and reading a folder again. */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/image_io.h"
#include "base/log.h"
#include "daemon/parts/library_list.h"
#include "daemon/server/server_internal.h"
#include "quilt/quilt.h"
#include "quilt/rgbd.h"

/* Of the entries as JSON: they are in each answer and notification. */
#define MOST_BYTES ((size_t)256 << 10)
/* Clients whose entries are checked at the same time; the others wait. */
#define CHECKS_AT_ONCE 2

/* -------------------------------------------------------------------------------------- told -- */

json_t *lf_server_entry_json(const lf_playlist_entry *entry)
{
    json_t *json = entry->keys ? json_copy(entry->keys) : json_object();
    (void)json_object_set_new(json, "file", lf_rpc_text(entry->file));
    if (entry->seconds > 0)
        (void)json_object_set_new(json, "seconds", json_real(entry->seconds));
    return json;
}

static json_t *whole_json(const lf_playlist_state *state, const lf_played_folder *folder)
{
    json_t *entries = json_array();
    for (int i = 0; i < state->n; i++)
        (void)json_array_append_new(entries, lf_server_entry_json(&state->entries[i]));
    return json_pack("{s:o, s:o, s:b, s:i, s:I, s:b, s:b, s:b, s:f, s:f}", "entries", entries,
                     "folder", folder->path ? lf_rpc_text(folder->path) : json_null(), "more",
                     (int)folder->more, "index", state->index, "turn", (json_int_t)state->turn,
                     "playing", (int)state->playing, "paused", (int)state->paused, "loop",
                     (int)state->how.loop, "seconds", state->how.seconds, "crossfade",
                     state->how.crossfade);
}

json_t *lf_server_whole_playlist_json(const lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    return whole_json(&now, &server->gallery.folder);
}

/* --------------------------------------------------------------------------------- one entry -- */

static lf_status refuse_key(const char *key, const char *what, lf_error *err)
{
    char pointer[64];
    snprintf(pointer, sizeof pointer, "/%s", key);
    return lf_error_set_at(err, LF_E_ARG, "playlist", 0, pointer, "%s", what);
}

lf_status lf_server_take_entry(const json_t *from, lf_playlist_entry *entry, lf_error *err)
{
    const json_t *seconds = json_object_get(from, "seconds");
    json_t *keys = json_deep_copy(from); /* another thread reads it, and not the call's */
    if (!keys)
        return lf_error_set(err, LF_E_NOMEM, "playlist", "out of memory");
    if (seconds)
        entry->seconds = json_number_value(seconds);
    (void)json_object_del(keys, "file");
    (void)json_object_del(keys, "seconds");
    if (json_object_size(keys) > 0)
        entry->keys = keys;
    else
        json_decref(keys);
    return LF_OK;
}

/* The keys that files without a scene have. */
static lf_status read_keys(const json_t *keys, lf_load_words *words, lf_error *err)
{
    lf_status status = lf_param_from_json(lf_alone_params, keys, &words->alone, "playlist", err);
    if (status == LF_OK)
        status = lf_param_from_json(lf_photo_params, keys, &words->photo, "playlist", err);
    if (status == LF_OK)
        status = lf_param_from_json(lf_picture_params, keys, &words->photo, "playlist", err);
    return status == LF_OK
               ? lf_param_from_json(lf_standing_params, keys, &words->standing, "playlist", err)
               : status;
}

static bool is_rgbd(const lf_playlist_entry *entry, const lf_load_words *words)
{
    return lf_rgbd_side_of(&words->standing, entry->file) != LF_RGBD_IN_OFF;
}

/* An image or video whose name has no tiles, and no depth, is shown as one view. */
static bool is_plain(const lf_playlist_entry *entry, const lf_load_words *words)
{
    int columns, rows;
    double aspect;
    return (lf_image_ending(entry->file) || lf_movie_ending(entry->file)) &&
           !lf_layout_from_name(entry->file, &columns, &rows, &aspect) && !is_rgbd(entry, words);
}

/* Of a quilt whose tiles are known. */
static lf_status check_views(const lf_playlist_entry *entry, const lf_load_words *words,
                             lf_error *err)
{
    int columns = words->columns, rows = words->rows;
    double aspect;
    if (words->photo.n_views == 0 ||
        (columns == 0 && !lf_layout_from_name(entry->file, &columns, &rows, &aspect)))
        return LF_OK;
    return words->photo.n_views <= columns * rows
               ? LF_OK
               : refuse_key("views", "there are fewer tiles; give views up to their number", err);
}

lf_status lf_server_entry_words(const lf_server *server, const lf_playlist_entry *entry,
                                lf_load_words *words, lf_error *err)
{
    const char *quilt = json_string_value(json_object_get(entry->keys, "quilt"));
    lf_error why;
    *words = (lf_load_words){.said = entry->keys,
                             .alone = server->config.options.alone,
                             .photo = server->options.photo,
                             .standing = server->config.options.standing};
    if (entry->keys && lf_path_has_ending(entry->file, ".json"))
        return refuse_key(json_object_iter_key(json_object_iter(entry->keys)),
                          "applies only to files without a scene; set it in the scene file instead",
                          err);
    lf_status status = entry->keys ? read_keys(entry->keys, words, err) : LF_OK;
    if (status == LF_OK && quilt &&
        lf_parse_tiles(quilt, &words->columns, &words->rows, &why) != LF_OK)
        return refuse_key("quilt", why.what, err);
    if (status == LF_OK && !quilt && is_plain(entry, words))
        words->columns = words->rows = 1;
    if (status == LF_OK)
        status = lf_server_check_standing(entry->keys, entry->file, words, "playlist", err);
    return status == LF_OK ? check_views(entry, words, err) : status;
}

/* ---------------------------------------------------------------------------------- checking -- */

/* Entries whose paths are checked, or a folder that is listed. */
typedef struct checking {
    lf_errand errand;
    const lf_server *server; /* only what is constant */
    lf_deferred *deferred;   /* NULL: nobody waits for an answer */
    bool begins;             /* at the start: the entries are then played */
    bool only_checks;        /* the list stays as it is */
    char *folder;            /* absolute; NULL: entries are given */
    bool more;
    lf_playlist_entry *entries;
    int n;
    lf_playlist_how how;
} checking;

static void free_checking(checking *c)
{
    lf_playlist_entries_free(c->entries, c->n);
    lf_free(c->folder);
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
    json_t *json = lf_server_entry_json(entry);
    const size_t n = json ? json_dumpb(json, NULL, 0, JSON_COMPACT) : 0;
    json_decref(json);
    return n;
}

static lf_status check_entries(checking *c, lf_error *err)
{
    size_t bytes = 0;
    for (int i = 0; i < c->n; i++) {
        char *real;
        lf_error why;
        if (atomic_load(&c->errand.cancel))
            return lf_error_set(err, LF_E_CANCELLED, "playlist.set", "cancelled");
        lf_status status = lf_server_resolve(&c->server->roots, c->entries[i].file, &real, &why);
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

/* Entries of all files of the folder, as many as may be. */
static lf_status list_folder(checking *c, lf_error *err)
{
    lf_library_files files;
    size_t bytes = 0;
    lf_status status =
        lf_library_files_of(&c->server->roots, c->folder, &c->errand.cancel, &files, err);
    if (status == LF_E_PATH)
        (void)lf_say_outside(c->folder, err);
    if (status != LF_OK)
        return status;
    c->entries = lf_calloc((size_t)files.n, sizeof *c->entries);
    c->more = files.more;
    for (int i = 0; i < files.n && c->entries; i++) {
        const lf_playlist_entry entry = {.file = files.path[i]};
        bytes += bytes_of(&entry);
        if (bytes > MOST_BYTES) {
            c->more = true;
            break;
        }
        c->entries[c->n++] = entry;
        files.path[i] = NULL;
    }
    lf_free(c->folder);
    c->folder = files.folder;
    files.folder = NULL;
    lf_library_files_finish(&files);
    return c->entries ? LF_OK : lf_error_set(err, LF_E_NOMEM, "playlist", "out of memory");
}

/* On a thread of its own, since a file system may hang. */
static lf_status check(lf_errand *errand, lf_error *err)
{
    checking *c = (checking *)(void *)errand;
    return c->folder ? list_folder(c, err) : check_entries(c, err);
}

/* ------------------------------------------------------------------------------- the outcome -- */

/* Files that stay keep the keys of playlist.change. Both lists are in the order of the folder. */
static void keep_changes(const lf_server *server, checking *c)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    int at = 0;
    for (int i = 0; i < c->n; i++) {
        while (at < now.n && strverscmp(now.entries[at].file, c->entries[i].file) < 0)
            at++;
        if (at == now.n || strcmp(now.entries[at].file, c->entries[i].file) != 0)
            continue;
        c->entries[i].seconds = now.entries[at].seconds;
        c->entries[i].keys = json_incref(now.entries[at].keys);
    }
}

/* Once for a list: its first video that has no tiles in its name. */
static void warn_of_plain(const lf_server *server, const checking *c)
{
    for (int i = 0; i < c->n; i++) {
        const lf_playlist_entry *entry = &c->entries[i];
        lf_load_words words;
        if (lf_movie_ending(entry->file) && !json_object_get(entry->keys, "quilt") &&
            lf_server_entry_words(server, entry, &words, NULL) == LF_OK &&
            is_plain(entry, &words)) {
            lf_log(LF_LOG_WARNING,
                   "%s: is shown as one view, because its name has no tiles; quilt=8x6 of "
                   "playlist.change says which",
                   entry->file);
            return;
        }
    }
}

static void take(lf_server *server, checking *c)
{
    lf_gallery *gallery = &server->gallery;
    const char *before = gallery->folder.path;
    if (c->folder && before && strcmp(c->folder, before) == 0)
        keep_changes(server, c);
    if (c->more)
        lf_log(LF_LOG_WARNING, "%s: the folder has too many files; the slideshow has the first %d",
               c->folder, c->n);
    warn_of_plain(server, c);
    lf_free(gallery->folder.path);
    gallery->folder = (lf_played_folder){c->folder, c->more};
    c->folder = NULL;
    lf_playlist_set(gallery->playlist, c->entries, c->n, &c->how);
    c->entries = NULL;
    c->n = 0;
    if (c->begins)
        lf_playlist_play(gallery->playlist, 0);
}

/* Answers what the list would be. */
static void tell(const checking *c)
{
    const lf_playlist_state state = {.entries = c->entries, .n = c->n, .how = c->how};
    const lf_played_folder folder = {c->folder, c->more};
    lf_deferred_reply(c->deferred, whole_json(&state, &folder));
}

static void fail(lf_server *server, const checking *c)
{
    const lf_errand *errand = &c->errand;
    if (c->deferred) {
        lf_deferred_fail(c->deferred, &errand->err, errand->status != LF_E_ARG);
        return;
    }
    lf_log_error(&errand->err);
    if (!c->begins)
        return;
    server->error = errand->err;
    lf_server_tell_card(server);
    lf_server_ready(server);
}

static void on_checked(void *context, lf_errand *errand)
{
    lf_server *server = context;
    checking *c = (checking *)(void *)errand;
    const bool stops = lf_server_is_stopping(server), answers = c->deferred;
    if (errand->status == LF_OK && stops)
        errand->status = lf_error_set(&errand->err, LF_E_CANCELLED, "playlist.set",
                                      "the daemon is shutting down");
    if (errand->status != LF_OK && !(stops && !c->deferred)) {
        fail(server, c);
    } else if (errand->status == LF_OK && c->only_checks) {
        tell(c);
    } else if (errand->status == LF_OK) {
        take(server, c);
        if (c->deferred)
            lf_deferred_reply(c->deferred, lf_server_whole_playlist_json(server));
    }
    free_checking(c);
    if (stops)
        lf_server_shutdown(server);
    else if (!answers)
        lf_server_reloaded(server);
}

/* -------------------------------------------------------------------------------- the errand -- */

/* NULL: out of memory. */
static checking *make_checking(const lf_server *server, uint64_t client, const lf_playlist_how *how)
{
    checking *c = lf_calloc(1, sizeof *c);
    if (c)
        *c = (checking){.errand = {.client = client, .run = check, .done = on_checked},
                        .server = server,
                        .how = *how};
    return c;
}

static lf_status take_one(const lf_call *call, size_t i, const json_t *from,
                          lf_playlist_entry *entry, lf_error *err)
{
    const lf_error empty = {.what = "the file name is empty"};
    const char *file = json_string_value(json_object_get(from, "file"));
    char pointer[128];
    lf_load_words words;
    lf_error why;
    if (file[0] == '\0') /* it would be the folder of the scene */
        return refuse((int)i, "\"\"", LF_E_ARG, &empty, err);
    entry->file = lf_server_absolute(call->server, file);
    lf_status status = entry->file ? lf_server_take_entry(from, entry, &why) : LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_server_entry_words(call->server, entry, &words, &why);
    if (status == LF_E_NOMEM)
        return lf_error_set(err, status, call->method, "out of memory");
    snprintf(pointer, sizeof pointer, "/entries/%zu%.64s", i, status == LF_OK ? "" : why.pointer);
    return status == LF_OK ? LF_OK
                           : lf_error_set_at(err, status, call->method, 0, pointer, "%s", why.what);
}

static lf_status take_entries(const lf_call *call, checking *c, lf_error *err)
{
    const json_t *list = json_object_get(call->params, "entries");
    size_t i;
    json_t *from;
    lf_status status = LF_OK;
    c->entries = lf_calloc(json_array_size(list) + 1, sizeof *c->entries);
    if (!c->entries)
        return lf_error_set(err, LF_E_NOMEM, call->method, "out of memory");
    json_array_foreach(list, i, from)
    {
        if (status == LF_OK)
            status = take_one(call, i, from, &c->entries[c->n++], err);
    }
    return status;
}

static lf_status take_source(const lf_call *call, checking *c, lf_error *err)
{
    const char *folder = json_string_value(json_object_get(call->params, "folder"));
    if (!folder)
        return take_entries(call, c, err);
    if (folder[0] == '\0')
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/folder", "the name is empty");
    c->folder = lf_server_absolute(call->server, folder);
    return c->folder ? LF_OK : lf_error_set(err, LF_E_NOMEM, call->method, "out of memory");
}

static lf_status check_call(const lf_call *call, lf_error *err)
{
    const uint64_t client = lf_client_serial(call->client);
    const json_t *entries = json_object_get(call->params, "entries"),
                 *folder = json_object_get(call->params, "folder");
    if (!entries == !folder)
        return lf_error_set(err, LF_E_ARG, call->method,
                            entries ? "entries and folder exclude each other; give one of them"
                                    : "nothing to show is named; give entries or folder");
    return lf_errands_count_of(call->server->gallery.checks, client) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, call->method,
                              "another playlist.set of this client is open; wait for its answer");
}

static lf_playlist_how how_of(const lf_call *call)
{
    const json_t *seconds = json_object_get(call->params, "seconds");
    return (lf_playlist_how){.seconds = seconds ? json_number_value(seconds) : LF_PLAYLIST_SECONDS,
                             .loop = !json_is_false(json_object_get(call->params, "loop")),
                             .crossfade =
                                 json_number_value(json_object_get(call->params, "crossfade"))};
}

void lf_server_playlist_set(lf_call *call)
{
    lf_error err;
    const lf_playlist_how how = how_of(call);
    lf_status status = check_call(call, &err);
    checking *c =
        status == LF_OK ? make_checking(call->server, lf_client_serial(call->client), &how) : NULL;
    if (status == LF_OK)
        status = c ? take_source(call, c, &err)
                   : lf_error_set(&err, LF_E_NOMEM, call->method, "out of memory");
    if (status != LF_OK) {
        if (c)
            free_checking(c);
        lf_fail(call, &err, false);
        return;
    }
    c->only_checks = json_is_true(json_object_get(call->params, "check"));
    c->deferred = lf_defer(call);
    if (!c->deferred) {
        free_checking(c);
    } else if (lf_errands_add(call->server->gallery.checks, &c->errand, &err) != LF_OK) {
        lf_deferred_fail(c->deferred, &err, false);
        free_checking(c);
    }
}

/* Lists a folder for nobody. */
static lf_status start(lf_server *server, const char *folder, const lf_playlist_how *how,
                       bool begins, lf_error *err)
{
    checking *c = make_checking(server, 0, how);
    if (c)
        c->folder = lf_strdup(folder);
    lf_status status =
        c && c->folder ? LF_OK : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (status == LF_OK) {
        c->begins = begins;
        status = lf_errands_add(server->gallery.checks, &c->errand, err);
    }
    if (status != LF_OK && c)
        free_checking(c);
    return status;
}

void lf_server_begin_playlist(lf_server *server)
{
    const lf_server_playlist *option = &server->config.playlist;
    const lf_playlist_how how = {
        .seconds = option->seconds, .loop = true, .crossfade = option->crossfade};
    lf_error err;
    if (start(server, option->folder, &how, true, &err) == LF_OK)
        return;
    lf_log_error(&err);
    lf_server_ready(server);
    lf_server_reloaded(server);
}

bool lf_server_reread_playlist(lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    const char *folder = server->gallery.folder.path;
    lf_error err;
    if (server->config.playlist.folder && !server->content && !now.playing) {
        lf_server_begin_playlist(server);
        return true;
    }
    if (!now.playing || !folder)
        return false;
    if (start(server, folder, &now.how, false, &err) != LF_OK) {
        lf_log_error(&err);
        lf_server_reloaded(server);
    }
    return true;
}

lf_status lf_server_make_entries(lf_server *server)
{
    return lf_errands_create("lf-playlist", CHECKS_AT_ONCE, server, &server->inbox,
                             &server->gallery.checks);
}
