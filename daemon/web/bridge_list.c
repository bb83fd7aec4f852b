/* Endpoints of orchestrations and playlists. Entries are checked by quiltd before they are kept. */
#include "daemon/web/bridge_internal.h"

#include <string.h>

#include "daemon/web/bridge_entry.h"

/* The orchestration whose playlist is played; NULL: none. */
static const char *played(const lf_bridge *bridge)
{
    return bridge->shown.token[0] ? bridge->shown.token : NULL;
}

static json_t *named(const lf_bridge_call *call)
{
    return lf_bridge_value(
        "payload", "VARIANT_MAP",
        json_pack("{s:o}", "name", lf_bridge_text("name", lf_bridge_param(call, "name"))));
}

/* ---------------------------------------------------------------------------- orchestrations -- */

void lf_bridge_run_enter(lf_bridge_call *call)
{
    lf_bridge *bridge = call->bridge;
    lf_error err = {0};
    if (lf_bridge_lists_enter(bridge->lists, played(bridge), &call->orchestration, &err) != LF_OK)
        lf_bridge_fail(call, "%s", err.what);
    else
        lf_bridge_complete(
            call, lf_bridge_text("orchestration", lf_orchestration_token(call->orchestration)));
}

/* What it plays goes on. */
void lf_bridge_run_exit(lf_bridge_call *call)
{
    lf_bridge_lists_exit(call->bridge->lists, call->orchestration);
    call->orchestration = NULL;
    lf_bridge_complete(call,
                       lf_bridge_text("orchestration", lf_bridge_param(call, "orchestration")));
}

/* --------------------------------------------------------------------------------- playlists -- */

/* An emptied playlist is another one: quiltd goes on with what it has. */
void lf_bridge_run_instance(lf_bridge_call *call)
{
    lf_bridge *bridge = call->bridge;
    const json_t *given = json_object_get(call->body, "loop");
    double loop = 1;
    lf_error err = {0};
    char text[sizeof err + 32];
    if (given && !lf_bridge_number(given, &loop)) {
        lf_bridge_fail(call, "loop: expects true or false");
        return;
    }
    if (lf_orchestration_make(bridge->lists, call->orchestration, lf_bridge_param(call, "name"),
                              loop != 0, played(bridge), &call->list, &err) != LF_OK) {
        lf_bridge_fail(call, "%s", lf_error_format(&err, text, sizeof text));
        return;
    }
    if (lf_bridge_is_shown(call))
        lf_bridge_show_forget(bridge);
    lf_bridge_complete(call, named(call));
}

static void drop_list(lf_bridge_call *call)
{
    lf_orchestration_drop(call->orchestration, call->list);
    call->list = NULL;
    lf_bridge_complete(call, named(call));
}

static void on_stopped(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (!result) {
        lf_bridge_fail(call, "%s", why);
        return;
    }
    lf_bridge_show_forget(call->bridge);
    drop_list(call);
}

/* What is on the panel stays there. */
void lf_bridge_run_delete(lf_bridge_call *call)
{
    if (!lf_bridge_find_list(call))
        return;
    if (lf_bridge_is_shown(call) && call->bridge->shown.playing)
        lf_bridge_ask(call, "playlist.stop", NULL, on_stopped);
    else
        drop_list(call);
}

/* ----------------------------------------------------------------------------------- entries -- */

/* Of one that is not played, quiltd checks the entry alone; of one that is played it gets all. */
static void check_entry(lf_bridge_call *call, json_t *entries, lf_bridge_then_fn then)
{
    const bool shown = lf_bridge_is_shown(call);
    json_t *params = json_pack("{s:o, s:b}", "entries", entries, "loop", call->list->loop);
    if (params && !shown)
        json_object_set_new(params, "check", json_true());
    lf_bridge_ask(call, "playlist.set", params, then);
}

/* All entries, with the call's one put in or in the place of another one. */
static json_t *entries_with(const lf_bridge_call *call, bool replace)
{
    json_t *all;
    if (!lf_bridge_is_shown(call))
        return json_pack("[O]", call->entry);
    all = json_copy(call->list->entries);
    if (replace)
        json_array_set(all, (size_t)call->index, call->entry);
    else
        json_array_insert(all, (size_t)call->index, call->entry);
    return all;
}

static void on_inserted(lf_bridge_call *call, const json_t *result, const char *why)
{
    lf_error err = {0};
    json_t *tag = json_string(lf_bridge_param(call, "tag"));
    if (!result) {
        json_decref(tag);
        lf_bridge_fail(call, "%s", why);
        return;
    }
    lf_status status = lf_bridge_list_insert(call->list, call->index, json_incref(call->said),
                                             json_incref(call->entry), tag, &call->index, &err);
    if (status == LF_OK && lf_bridge_is_shown(call))
        lf_bridge_show_take(call, result);
    if (status != LF_OK)
        lf_bridge_fail(call, "%s", err.what);
    else
        lf_bridge_complete(
            call, lf_bridge_value("payload", "VARIANT_MAP",
                                  json_pack("{s:o}", "index",
                                            lf_bridge_value("index", "WSTRING",
                                                            json_sprintf("%d", call->index)))));
}

void lf_bridge_run_insert(lf_bridge_call *call)
{
    const json_t *given = json_object_get(call->body, "index");
    json_t *nothing = json_object();
    lf_error err = {0};
    char text[sizeof err + 32];
    call->index = -1;
    if (!lf_bridge_find_list(call)) {
        json_decref(nothing);
        return;
    }
    if (lf_bridge_entry_make(nothing, call->body, &call->said, &call->entry, &err) != LF_OK)
        lf_bridge_fail(call, "%s", lf_error_format(&err, text, sizeof text));
    else if (given && !lf_bridge_whole(given, &call->index))
        lf_bridge_fail(call, "index: expects a whole number");
    else {
        const int n = lf_bridge_list_length(call->list);
        call->index = call->index < 0 || call->index > n ? n : call->index;
        check_entry(call, entries_with(call, false), on_inserted);
    }
    json_decref(nothing);
}

/* quiltd has the changed entries. It shows the current one again if that one is another now. */
static void go_on_shown(lf_bridge_call *call, const json_t *result)
{
    const bool playing = json_is_true(json_object_get(result, "playing")),
               again = call->shows_again && call->index == call->current;
    lf_bridge_show_take(call, result);
    if (call->endpoint->shows && !playing)
        lf_bridge_fail(call, "the slideshow has stopped; call transport_control_play first");
    else if (playing && again)
        lf_bridge_show_await(call, result);
    else
        lf_bridge_complete(call, NULL);
}

static void on_changed(lf_bridge_call *call, const json_t *result, const char *why)
{
    lf_error err = {0};
    if (!result)
        lf_bridge_fail(call, "%s", why);
    else if (lf_bridge_list_change(call->list, call->index, json_incref(call->said),
                                   json_incref(call->entry), &err) != LF_OK)
        lf_bridge_fail(call, "%s", err.what);
    else if (!lf_bridge_is_shown(call))
        lf_bridge_complete(call, NULL);
    else
        go_on_shown(call, result);
}

/* The entry with this index, as the request wants it. */
static void change(lf_bridge_call *call)
{
    const size_t at = (size_t)call->index;
    const json_t *before = json_array_get(call->list->entries, at);
    lf_error err = {0};
    char text[sizeof err + 32];
    if (call->index < 0 || !before) {
        lf_bridge_fail(call, "index: there is no entry %d", call->index);
        return;
    }
    if (lf_bridge_entry_make(json_array_get(call->list->said, at), call->body, &call->said,
                             &call->entry, &err) != LF_OK) {
        lf_bridge_fail(call, "%s", lf_error_format(&err, text, sizeof text));
        return;
    }
    json_t *changes = lf_bridge_entry_changes(call->entry, before);
    const bool same_file = !json_object_get(changes, "file");
    call->shows_again = json_object_size(changes) > 0;
    call->current = call->bridge->shown.index;
    call->scenes = call->bridge->scenes;
    if (lf_bridge_is_shown(call) && same_file) {
        json_object_set_new(changes, "index", json_integer(call->index));
        lf_bridge_ask(call, "playlist.change", json_incref(changes), on_changed);
    } else {
        check_entry(call, entries_with(call, true), on_changed);
    }
    json_decref(changes);
}

void lf_bridge_run_update(lf_bridge_call *call)
{
    if (!lf_bridge_find_list(call))
        return;
    if (!lf_bridge_whole(json_object_get(call->body, "index"), &call->index))
        lf_bridge_fail(call, "index: expects a whole number");
    else
        change(call);
}

void lf_bridge_run_update_current(lf_bridge_call *call)
{
    if (!lf_bridge_find_list(call))
        return;
    call->index = call->bridge->shown.index;
    if (!lf_bridge_is_shown(call))
        lf_bridge_fail(call, "the playlist \"%s\" is not played", lf_bridge_param(call, "name"));
    else if (lf_bridge_show_begin(call))
        change(call);
}
