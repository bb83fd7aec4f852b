/* What is played. A playlist of Bridge becomes quiltd's slideshow; what quiltd then says of its
 * slideshow decides what programs are told. */
#include "daemon/web/bridge_internal.h"

#include <stdio.h>
#include <string.h>

#include "daemon/web/bridge_entry.h"

/* ------------------------------------------------------------------------------------- shown -- */

static bool is_any_shown(const lf_bridge *bridge)
{
    return bridge->shown.token[0] != '\0';
}

bool lf_bridge_is_shown(const lf_bridge_call *call)
{
    const lf_bridge_shown *shown = &call->bridge->shown;
    return call->list && strcmp(shown->token, lf_orchestration_token(call->orchestration)) == 0 &&
           strcmp(shown->name, call->list->name) == 0;
}

void lf_bridge_show_forget(lf_bridge *bridge)
{
    json_decref(bridge->shown.files);
    json_decref(bridge->shown.tags);
    bridge->shown = (lf_bridge_shown){.told = -1};
}

/* The files of a result of playlist.set, a new reference. */
static json_t *files_of(const json_t *result)
{
    json_t *files = json_array(), *entry;
    size_t i;
    json_array_foreach(json_object_get(result, "entries"), i, entry)
        json_array_append(files, json_object_get(entry, "file"));
    return files;
}

void lf_bridge_show_take(const lf_bridge_call *call, const json_t *result)
{
    lf_bridge_shown *shown = &call->bridge->shown;
    json_decref(shown->files);
    json_decref(shown->tags);
    shown->files = files_of(result);
    shown->tags = json_copy(call->list->tags);
    shown->index = (int)json_integer_value(json_object_get(result, "index"));
}

/* ------------------------------------------------------------------------------------ events -- */

static void tell(const lf_bridge *bridge, const char *token, const char *event, int index,
                 const char *name, const char *tag)
{
    json_t *told =
        json_pack("{s:o, s:o, s:o, s:o}", "event", lf_bridge_text("event", event), "index",
                  lf_bridge_number_value("index", index), "playlist_name",
                  lf_bridge_text("playlist_name", name), "tag", lf_bridge_text("tag", tag));
    if (told)
        bridge->config.tell(bridge->config.context, token, told);
    json_decref(told);
}

static void tell_shown(const lf_bridge *bridge, const char *event)
{
    const lf_bridge_shown *shown = &bridge->shown;
    const char *tag = json_string_value(json_array_get(shown->tags, (size_t)shown->index));
    tell(bridge, shown->token, event, shown->index, shown->name, tag ? tag : "");
}

void lf_bridge_show_tell(lf_bridge_call *call, const char *event)
{
    const char *name = lf_bridge_param(call, "name");
    if (name[0] == '\0')
        tell_shown(call->bridge, event);
    else
        tell(call->bridge, lf_bridge_param(call, "orchestration"), event, call->index, name,
             lf_bridge_param(call, "tag"));
}

/* ----------------------------------------------------------------------------------- waiting -- */

static lf_bridge_call *take_waiting(lf_bridge *bridge)
{
    lf_bridge_call *call = bridge->waiting;
    bridge->waiting = NULL;
    sd_event_source_set_enabled(bridge->patience, SD_EVENT_OFF);
    return call;
}

static void fail_waiting(lf_bridge *bridge, const char *why)
{
    lf_bridge_call *call = take_waiting(bridge);
    if (call)
        lf_bridge_fail(call, "%s", why);
}

int lf_bridge_show_patience(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_bridge_call *call = take_waiting(context);
    if (call)
        lf_bridge_pend(call);
    return 0;
}

static void look_at_panel(lf_bridge *bridge);

/* The image that quiltd has begun to load by this answer, not one that it has loaded before. */
static void take_turn(lf_bridge_call *call, const json_t *result)
{
    call->turn = json_integer_value(json_object_get(result, "turn"));
}

/* A call that waited before, for the same slideshow, does not know whether its own image comes. */
static void wait_for_image(lf_bridge_call *call)
{
    lf_bridge *bridge = call->bridge;
    lf_bridge_call *before = take_waiting(bridge);
    bridge->waiting = call;
    sd_event_source_set_time_relative(bridge->patience, LF_BRIDGE_SHOW_S * (uint64_t)1000000);
    sd_event_source_set_enabled(bridge->patience, SD_EVENT_ONESHOT);
    if (before)
        lf_bridge_pend(before);
    lf_bridge_step_aside(call);
    look_at_panel(bridge); /* it may be there already */
}

bool lf_bridge_show_begin(lf_bridge_call *call)
{
    lf_bridge *bridge = call->bridge;
    call->current = bridge->shown.index;
    call->scenes = bridge->scenes;
    bridge->reason[0] = '\0';
    if (!is_any_shown(bridge))
        lf_bridge_fail(call, "no playlist of a program is on the panel; call play_playlist first");
    else if (bridge->knows_panel && !bridge->has_panel)
        lf_bridge_fail(call, "no panel is connected");
    else
        return true;
    return false;
}

void lf_bridge_show_await(lf_bridge_call *call, const json_t *result)
{
    call->index = (int)json_integer_value(json_object_get(result, "index"));
    call->is_exact = true;
    take_turn(call, result);
    wait_for_image(call);
}

/* A call that wants this entry alone. */
static bool wants(const lf_bridge_call *call, int index)
{
    return call && call->is_exact && call->index == index;
}

/* quiltd has gone on to another entry than the one that a call waits for, or stopped. */
static bool waits_in_vain(const lf_bridge *bridge)
{
    const lf_bridge_call *call = bridge->waiting;
    return call &&
           (!bridge->shown.playing || (call->is_exact && !wants(call, bridge->shown.index)));
}

/* After all that quiltd had to say of the failure. */
static void on_said(void *context, const json_t *result, const char *why)
{
    (void)result;
    (void)why;
    lf_bridge *bridge = context;
    if (!waits_in_vain(bridge))
        return;
    if (bridge->reason[0])
        fail_waiting(bridge, bridge->reason);
    else
        fail_waiting(bridge, bridge->shown.playing
                                 ? "quiltd has gone on to another entry; see its log"
                                 : "the slideshow was stopped before the image was there");
}

/* -------------------------------------------------------------------------------------- play -- */

static void on_played(lf_bridge_call *call, const json_t *result, const char *why)
{
    lf_bridge *bridge = call->bridge;
    json_t *files = files_of(result);
    const bool same = json_equal(files, call->kept);
    json_decref(files);
    if (!result) {
        lf_bridge_fail(call, "%s", why);
        return;
    }
    if (!same) {
        lf_bridge_fail(call, "another client of quiltd has replaced the playlist");
        return;
    }
    lf_bridge_show_forget(bridge);
    snprintf(bridge->shown.token, sizeof bridge->shown.token, "%s",
             lf_orchestration_token(call->orchestration));
    snprintf(bridge->shown.name, sizeof bridge->shown.name, "%s", call->list->name);
    lf_bridge_show_take(call, result);
    bridge->shown.playing = true;
    take_turn(call, result);
    wait_for_image(call);
}

static void on_set(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (!result) {
        lf_bridge_fail(call, "%s", why);
        return;
    }
    call->kept = files_of(result);
    lf_bridge_ask(call, "playlist.play", json_pack("{s:i}", "index", 0), on_played);
}

static void on_stopped(lf_bridge_call *call, const json_t *result, const char *why)
{
    lf_bridge *bridge = call->bridge;
    bridge->reason[0] = '\0';
    call->scenes = bridge->scenes;
    if (!result)
        lf_bridge_fail(call, "%s", why);
    else
        lf_bridge_ask(
            call, "playlist.set",
            json_pack("{s:O, s:b}", "entries", call->list->entries, "loop", call->list->loop),
            on_set);
}

static void on_looked(lf_bridge_call *call, const json_t *info, const char *why)
{
    if (!info) {
        lf_bridge_fail(call, "%s", why);
        return;
    }
    fail_waiting(call->bridge, "another playlist is played"); /* not: it was stopped */
    lf_bridge_ask(call, "playlist.stop", NULL, on_stopped);
}

void lf_bridge_run_play(lf_bridge_call *call)
{
    const json_t *given = json_object_get(call->body, "head_index");
    int head = -1;
    if (!lf_bridge_find_list(call))
        return;
    if (given && (!lf_bridge_whole(given, &head) || (head != -1 && head != 0)))
        lf_bridge_fail(call, "head_index: expects 0, or -1 for any: quiltd has one panel");
    else if (lf_bridge_list_length(call->list) == 0)
        lf_bridge_fail(
            call,
            "the playlist \"%s\" has no entries: none was inserted, or each insert has failed",
            call->list->name);
    else
        lf_bridge_look(call, on_looked);
}

/* --------------------------------------------------------------------------------- transport -- */

static void on_done(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (result)
        lf_bridge_complete(call, NULL);
    else
        lf_bridge_fail(call, "%s", why);
}

static void on_begun(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (result)
        lf_bridge_show_await(call, result);
    else
        lf_bridge_fail(call, "%s", why);
}

/* quiltd shows nothing anew at the end of a list, or if there is one entry. */
static void on_stepped(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (json_integer_value(json_object_get(result, "index")) == call->current)
        on_done(call, result, why);
    else
        on_begun(call, result, why);
}

void lf_bridge_run_transport(lf_bridge_call *call)
{
    if (lf_bridge_show_begin(call))
        lf_bridge_ask(call, call->endpoint->method, NULL, on_stepped);
}

static void on_paused(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (result && !json_is_true(json_object_get(result, "paused")))
        lf_bridge_fail(call, "nothing is played that could be paused");
    else
        on_done(call, result, why);
}

void lf_bridge_run_pause(lf_bridge_call *call)
{
    if (lf_bridge_show_begin(call))
        lf_bridge_ask(call, "playlist.pause", json_pack("{s:b}", "paused", 1), on_paused);
}

/* After a pause, or where the playlist has stopped. */
void lf_bridge_run_resume(lf_bridge_call *call)
{
    if (!lf_bridge_show_begin(call))
        return;
    if (call->bridge->shown.playing)
        lf_bridge_ask(call, "playlist.pause", json_pack("{s:b}", "paused", 0), on_done);
    else
        lf_bridge_ask(call, "playlist.play", NULL, on_begun);
}

void lf_bridge_run_seek(lf_bridge_call *call)
{
    if (!lf_bridge_show_begin(call))
        return;
    if (!lf_bridge_whole(json_object_get(call->body, "index"), &call->index) || call->index < 0)
        lf_bridge_fail(call, "index: expects a whole number from 0");
    else
        lf_bridge_ask(call, "playlist.play", json_pack("{s:i}", "index", call->index), on_begun);
}

/* ----------------------------------------------------------------------------- notifications -- */

static void complete_waiting(lf_bridge *bridge)
{
    lf_bridge_call *call = take_waiting(bridge);
    lf_bridge_complete(
        call, call->is_exact
                  ? NULL
                  : lf_bridge_value("payload", "VARIANT_MAP",
                                    json_pack("{s:o}", "message", lf_bridge_text("message", ""))));
}

/* The current entry is on the panel, if its file is, and it came there since a call waits. */
static void look_at_panel(lf_bridge *bridge)
{
    lf_bridge_shown *shown = &bridge->shown;
    const lf_bridge_call *call = bridge->waiting;
    const char *file = json_string_value(json_array_get(shown->files, (size_t)shown->index));
    const bool is_there = file && strcmp(file, bridge->on_panel) == 0;
    if (is_there && call && bridge->scenes != call->scenes && bridge->turn >= call->turn &&
        (call->is_exact ? wants(call, shown->index) : shown->playing))
        complete_waiting(bridge);
    if (!is_there || !shown->playing)
        return;
    if (shown->told == shown->index)
        return;
    shown->told = shown->index;
    tell_shown(bridge, "New Item Playing");
}

/* A call that runs may be the one that changes the entries. */
static void note_playlist(lf_bridge *bridge, const json_t *params)
{
    lf_bridge_shown *shown = &bridge->shown;
    lf_error err = {0};
    json_t *files = files_of(params);
    const bool same = json_equal(files, shown->files);
    json_decref(files);
    if (!same) {
        if (is_any_shown(bridge) && !bridge->running) {
            fail_waiting(bridge, "another client of quiltd has replaced the playlist");
            lf_bridge_show_forget(bridge);
        }
        return;
    }
    shown->index = (int)json_integer_value(json_object_get(params, "index"));
    shown->playing = json_is_true(json_object_get(params, "playing"));
    if (waits_in_vain(bridge) &&
        lf_calls_ask(bridge->calls, "status", NULL, on_said, bridge, &err) != LF_OK)
        fail_waiting(bridge, err.what);
    look_at_panel(bridge);
}

/* "playlist: entry 0 is skipped: WHY" */
static void note_log(lf_bridge *bridge, const json_t *params)
{
    static const char name[] = "playlist: ", start[] = "playlist: entry ",
                      middle[] = " is skipped: ";
    char expected[64];
    const char *text = json_string_value(json_object_get(params, "text"));
    const char *why =
        text && strncmp(text, start, strlen(start)) == 0 ? strstr(text, middle) : NULL;
    if (!why)
        return;
    snprintf(bridge->reason, sizeof bridge->reason, "%s", why + strlen(middle));
    if (is_any_shown(bridge))
        lf_bridge_log_failure(bridge, "playlist", text + strlen(name));
    if (!bridge->waiting || !bridge->waiting->is_exact)
        return;
    snprintf(expected, sizeof expected, "%s%d%s", start, bridge->waiting->index, middle);
    if (strncmp(text, expected, strlen(expected)) == 0)
        fail_waiting(bridge, bridge->reason);
}

void lf_bridge_show_note(lf_bridge *bridge, const char *method, const json_t *params)
{
    if (strcmp(method, "playlist") == 0) {
        note_playlist(bridge, params);
    } else if (strcmp(method, "log") == 0) {
        note_log(bridge, params);
    } else if (strcmp(method, "scene") == 0) {
        const char *file = json_string_value(json_object_get(params, "file"));
        const json_t *turn = json_object_get(params, "turn");
        bridge->scenes++;
        bridge->turn = turn ? json_integer_value(turn) : bridge->turn;
        snprintf(bridge->on_panel, sizeof bridge->on_panel, "%s", file ? file : "");
        look_at_panel(bridge);
    }
}

void lf_bridge_show_ended(lf_bridge *bridge)
{
    fail_waiting(bridge, "quiltd has closed the connection");
    lf_bridge_show_forget(bridge);
}
