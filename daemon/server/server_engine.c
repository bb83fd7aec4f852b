#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/wakeup.h"
#include "daemon/server/server_internal.h"

/* Of one client, at a time. */
#define MAX_WAITS 64
/* Answered at a time. */
#define WAITS_A_TURN 64

const char *lf_server_picture_name(const lf_shown *shown)
{
    if (shown->card[0] != '\0')
        return "card";
    return shown->reconstructed ? "reconstructed" : "unfiltered";
}

const char *lf_server_state_name(const lf_server *server)
{
    if (!server->content)
        return server->error.status != LF_OK ? "error" : "idle";
    if (!server->content->scene)
        return "idle";
    lf_engine_status status;
    lf_engine_get_status(server->engine, &status);
    switch (status.state) {
    case LF_STATE_RENDERING:
        return "rendering";
    case LF_STATE_CONVERGED:
        return "converged";
    case LF_STATE_PAUSED:
        return "paused";
    case LF_STATE_IDLE:
        break;
    }
    return "idle";
}

/* ----------------------------------------------------------------------------- notifications -- */

typedef struct broadcast {
    unsigned event;
    const char *text;
    size_t n;
} broadcast;

static void send_to(void *context, lf_client *client)
{
    const broadcast *b = context;
    if ((*lf_client_flags(client) & b->event) == 0)
        return;
    if (b->event == LF_EVENT_FRAME)
        lf_client_send_frame(client, b->text, b->n);
    else
        lf_client_send_text(client, b->text, b->n);
}

void lf_server_notify(lf_server *server, unsigned event, const char *method, json_t *params)
{
    json_t *message = lf_rpc_notification(method, params);
    char *text = message && server->clients ? json_dumps(message, JSON_COMPACT) : NULL;
    if (text)
        lf_clients_each(server->clients, send_to,
                        &(broadcast){.event = event, .text = text, .n = strlen(text)});
    free(text);
    json_decref(message);
}

/* ------------------------------------------------------------------------------------- waits -- */

static json_t *shown_json(const lf_server *server)
{
    return json_pack("{s:I, s:s}", "generation", (json_int_t)server->shown.generation, "level",
                     lf_level_name(server->shown.level));
}

/* A frame may be shown before the loader's word has come that its scene is shown, and whoever
 * waits asks for that next. */
static bool is_shown(const lf_server *server, const lf_wait *wait)
{
    return server->generation >= server->shown.generation &&
           server->shown.generation >= wait->generation && server->shown.level >= wait->level;
}

static bool is_over(const lf_server *server, const lf_wait *wait)
{
    return is_shown(server, wait) && lf_show_keeps(server->show, wait->generation, wait->level);
}

static void forget_wait(lf_wait *wait)
{
    sd_event_source_disable_unref(wait->timer);
    lf_free(wait);
}

static bool has_left(const lf_server *server, const lf_wait *wait)
{
    return !server->clients ||
           !lf_clients_find(server->clients, lf_deferred_client(wait->deferred));
}

/* Those of clients that have left end too. Thousands may be over at once: they are answered in
 * several turns. */
static void answer_waits(lf_server *server)
{
    int answered = 0;
    bool rest = false, unwritten = false;
    for (lf_wait **at = &server->waits.first; *at;) {
        lf_wait *wait = *at;
        wait->over = wait->over || is_over(server, wait) || has_left(server, wait);
        if (!wait->over || answered == WAITS_A_TURN) {
            rest = rest || wait->over;
            unwritten = unwritten || (!wait->over && is_shown(server, wait));
            at = &wait->next;
            continue;
        }
        *at = wait->next;
        lf_deferred_reply(server, wait->deferred, shown_json(server));
        forget_wait(wait);
        answered++;
    }
    if (rest)
        (void)sd_event_source_set_enabled(server->waits.more, SD_EVENT_ONESHOT);
    if (unwritten)
        lf_show_await_files(server->show);
}

void lf_server_kept(lf_server *server, const lf_error *err)
{
    for (lf_wait **at = &server->waits.first; err && *at;) {
        lf_wait *wait = *at;
        if (wait->over || !is_shown(server, wait) || is_over(server, wait)) {
            at = &wait->next;
            continue;
        }
        *at = wait->next;
        lf_deferred_fail(server, wait->deferred, err, false);
        forget_wait(wait);
    }
    answer_waits(server);
}

/* At most so many; true when none is left. */
static bool fail_waits(lf_server *server, const lf_error *err, bool scene, int most)
{
    for (int n = 0; server->waits.first && n < most; n++) {
        lf_wait *wait = server->waits.first;
        server->waits.first = wait->next;
        lf_deferred_fail(server, wait->deferred, err, scene);
        forget_wait(wait);
    }
    return !server->waits.first;
}

void lf_server_fail_waits(lf_server *server, const lf_error *err, bool scene)
{
    (void)fail_waits(server, err, scene, INT_MAX);
}

/* There is no picture, and none is being made. */
static void end_vain_waits(lf_server *server)
{
    bool vain = server->life.phase != LF_PHASE_LEAVING && !server->content &&
                server->error.status != LF_OK && !server->life.held &&
                lf_loader_pending(server->loader) == 0;
    if (vain && !fail_waits(server, &server->error, true, WAITS_A_TURN))
        (void)sd_event_source_set_enabled(server->waits.more, SD_EVENT_ONESHOT);
}

static int on_more_waits(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    answer_waits(context);
    end_vain_waits(context);
    return 0;
}

lf_status lf_server_make_waits(lf_server *server)
{
    /* with the time 0 a timer is due at once, and yet behind what was there before */
    return sd_event_add_time(server->event, &server->waits.more, CLOCK_MONOTONIC, 0, 1,
                             on_more_waits, server) >= 0 &&
                   sd_event_source_set_enabled(server->waits.more, SD_EVENT_OFF) >= 0
               ? LF_OK
               : LF_E_NOMEM;
}

static int on_wait_over(sd_event_source *source, uint64_t usec, void *context)
{
    lf_wait *wait = context;
    lf_server *server = wait->server;
    lf_wait **at = &server->waits.first;
    lf_error err;
    (void)source;
    (void)usec;
    while (*at != wait)
        at = &(*at)->next;
    *at = wait->next;
    (void)lf_error_set(&err, LF_E_TIMEOUT, "wait", "not %s within %g s%s",
                       lf_level_name(wait->level), wait->seconds,
                       lf_engine_get_controls(server->engine).paused
                           ? ": rendering is paused (render.set paused=false)"
                           : "");
    if (wait->over) /* in time, and not answered yet */
        lf_deferred_reply(server, wait->deferred, shown_json(server));
    else
        lf_deferred_fail(server, wait->deferred, &err, false);
    forget_wait(wait);
    return 0;
}

void lf_server_wait(lf_server *server, lf_deferred *deferred, int64_t generation, lf_level level,
                    double seconds)
{
    lf_error err;
    int n = 0, all = 0;
    for (const lf_wait *other = server->waits.first; other; other = other->next, all++)
        n += lf_deferred_client(other->deferred) == lf_deferred_client(deferred) ? 1 : 0;
    if (n >= MAX_WAITS) {
        (void)lf_error_set(&err, LF_E_BUSY, "wait", "this client waits %d times already", n);
        lf_deferred_fail(server, deferred, &err, false);
        return;
    }
    lf_wait *wait = lf_calloc(1, sizeof *wait);
    if (!wait) {
        lf_deferred_reply(server, deferred, NULL);
        return;
    }
    *wait = (lf_wait){.next = server->waits.first,
                      .deferred = deferred,
                      .generation = generation,
                      .level = level,
                      .seconds = seconds,
                      .server = server};
    if (seconds > 0 &&
        sd_event_add_time_relative(server->event, &wait->timer, CLOCK_MONOTONIC,
                                   (uint64_t)(seconds * 1e6), 1000, on_wait_over, wait) < 0) {
        lf_free(wait);
        lf_deferred_reply(server, deferred, NULL);
        return;
    }
    server->waits.first = wait;
    /* more than clients may have: some have left */
    if (all >= MAX_WAITS * LF_MAX_CLIENTS || is_shown(server, wait))
        answer_waits(server);
    end_vain_waits(server);
}

static json_t *frame_json(const lf_shown *shown)
{
    json_t *frame = json_pack("{s:I, s:s, s:f, s:s}", "generation", (json_int_t)shown->generation,
                              "level", lf_level_name(shown->level), "passes", shown->passes,
                              "picture", lf_server_picture_name(shown));
    if (frame && shown->card[0] != '\0')
        (void)json_object_set_new(frame, "card", lf_rpc_text(shown->card));
    return frame;
}

void lf_server_shown(lf_server *server, const lf_shown *shown)
{
    const lf_shown *before = &server->shown;
    bool news = shown->generation != before->generation || shown->level != before->level;
    if (shown->card[0] != '\0' && strcmp(shown->card, before->card) != 0 &&
        lf_show_calibration(server->show))
        lf_log(LF_LOG_INFO, "the panel says: %s", shown->card);
    server->shown = *shown;
    lf_server_notify(server, LF_EVENT_FRAME, "frame", frame_json(shown));
    if (!news)
        return;
    lf_log(LF_LOG_DEBUG, "generation %lld: %s after %.1f passes", (long long)shown->generation,
           lf_level_name(shown->level), shown->passes);
    if (shown->level == LF_LEVEL_CONVERGED) {
        lf_server_notify(server, LF_EVENT_CONVERGED, "converged",
                         json_pack("{s:I, s:f}", "generation", (json_int_t)shown->generation,
                                   "passes", shown->passes));
    }
    answer_waits(server);
    lf_play_shown(server->play, shown->generation, shown->level);
    lf_server_tell_card(server);
}

/* ------------------------------------------------------------------------------------ engine -- */

int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)events;
    lf_wakeup_clear(fd);
    lf_engine_state before = server->last.state;
    lf_engine_get_status(server->engine, &server->last);
    lf_show_pump(server->show);
    lf_jobs_start(server->jobs);
    if (server->last.state != before)
        lf_server_tell_status(server);
    if (lf_server_is_stopping(server) && lf_engine_stopped(server->engine))
        lf_server_shutdown(server);
    return 0;
}

/* ------------------------------------------------------------------------------------ loader -- */

static void append_notes(json_t *lines, const lf_content *content)
{
    char line[512], text[PATH_MAX + sizeof line];
    for (size_t at = 0; lf_image_notes_next(&content->quilt.notes, &at, line, sizeof line);) {
        snprintf(text, sizeof text, "%s: %s", content->file, line);
        (void)json_array_append_new(lines, lf_rpc_text(text));
    }
}

json_t *lf_server_warnings_json(const lf_server *server)
{
    const lf_content *content = server->content;
    json_t *lines = json_array();
    char words[LF_DEPTH_WORDS];
    if (!content)
        return lines;
    for (int i = 0; content->scene && lf_scene_warning(content->scene, i); i++)
        (void)json_array_append_new(lines, lf_rpc_text(lf_scene_warning(content->scene, i)));
    append_notes(lines, content);
    if (content->depth.exceeded)
        (void)json_array_append_new(
            lines, json_string(lf_depth_words(&content->depth, content->settings.width,
                                              LF_DEPTH_PANEL, words, sizeof words)));
    if (content->is_unseen)
        (void)json_array_append_new(lines, json_string(lf_unseen_words(true)));
    return lines;
}

/* The answer to a load, and with it what is to be said of the scene's files. */
static json_t *load_answer(const lf_server *server, const lf_load *load)
{
    json_t *answer = json_pack("{s:I}", "generation", (json_int_t)server->generation);
    if (answer && (load->kind == LF_LOAD_FILE || load->kind == LF_LOAD_PATCH))
        (void)json_object_set_new(answer, "warnings", lf_server_warnings_json(server));
    return answer;
}

/* What is played goes on with the same file, read again. */
static void play_file(lf_server *server, bool same)
{
    if (same && server->content->scene && lf_scene_has_frames(server->content->scene))
        lf_play_again(server->play);
    else
        lf_play_stop(server->play);
}

static void load_succeeded(lf_server *server, lf_load *load)
{
    if (load->committed) {
        bool same = server->content && strcmp(server->content->file, load->content->file) == 0;
        lf_server_release_content(server, server->content);
        server->content = load->content;
        load->content = NULL;
        server->generation = load->generation;
        if (load->restored > 0)
            lf_saver_restored(server->saver, &(lf_saved){.generation = load->generation,
                                                         .passes = load->restored});
        if (!load->goes_on)
            lf_saver_begin(server->saver);
        lf_server_notify(server, LF_EVENT_SCENE, "scene",
                         json_pack("{s:I, s:o}", "generation", (json_int_t)load->generation, "file",
                                   lf_rpc_text(server->content->file)));
        if (load->kind == LF_LOAD_FILE) {
            server->life.words = load->words;
            lf_server_file_shown(server, load->browsed);
            play_file(server, same);
            server->error.status = LF_OK;
            lf_server_watch(server);
            lf_log(LF_LOG_INFO, "%s: generation %lld%s", server->content->file,
                   (long long)load->generation,
                   load->restored > 0 ? ", going on with the saved state" : "");
        }
        answer_waits(server);
    }
    lf_deferred_reply(server, load->deferred, load_answer(server, load));
}

static void load_failed(lf_server *server, const lf_load *load)
{
    bool ended = load->status == LF_E_CANCELLED && !atomic_load(&load->job.cancelled);
    if (!load->deferred && !load->played && !ended) {
        lf_log_error(&load->err);
        server->error = load->err;
    }
    bool of_call = load->status == LF_E_STATE || load->status == LF_E_CANCELLED ||
                   (load->kind == LF_LOAD_FIT && load->status == LF_E_ARG);
    lf_deferred_fail(server, load->deferred, &load->err, !of_call);
}

static void destroy_load(void *load)
{
    lf_load_destroy(load);
}

static void destroy_huge_load(void *load)
{
    lf_load_destroy(load);
    lf_trim();
}

static void on_load_done(void *reader, lf_task *task)
{
    lf_server *server = reader;
    lf_load *load = (lf_load *)(void *)task;
    size_t bytes = load->deferred ? lf_deferred_bytes(load->deferred) : 0;
    lf_server_load_ended(server, load);
    if (load->status == LF_OK)
        load_succeeded(server, load);
    else
        load_failed(server, load);
    if (load->played)
        lf_play_loaded(server->play, load->generation, load->status == LF_OK ? NULL : &load->err);
    bool browsed = load->browsed;
    bool plain = load->kind == LF_LOAD_FILE && !load->deferred && !browsed;
    if (browsed && !lf_server_is_stopping(server))
        lf_server_browsed(server, load->file);
    if (load->reset && !lf_server_is_stopping(server))
        lf_server_was_reset(server);
    if (bytes >= LF_LONG_LINE)
        lf_server_release(server, bytes >= LF_HUGE_LINE ? destroy_huge_load : destroy_load, load);
    else
        lf_load_destroy(load);
    end_vain_waits(server);
    lf_server_tell_card(server);
    if (lf_server_is_stopping(server)) {
        lf_server_shutdown(server);
    } else if (plain) {
        lf_server_reloaded(server);
        lf_server_ready(server);
    }
}

static void queue_load(lf_server *server, lf_load *load)
{
    load->options = server->options;
    if (load->words.said) {
        load->options.alone = load->words.alone;
        load->options.photo = load->words.photo;
    }
    const lf_calibration *calibration = lf_show_calibration(server->show);
    load->has_calibration = calibration;
    if (calibration)
        load->calibration = *calibration;
    lf_server_loads(server, load);
    lf_loader_queue(server->loader, load);
    lf_server_tell_card(server);
}

void lf_server_load(lf_server *server, lf_load *load, lf_deferred *deferred)
{
    load->task.done = on_load_done;
    load->meant = server->config.scene;
    load->deferred = deferred;
    if (server->life.phase != LF_PHASE_OPENING) {
        queue_load(server, load);
        return;
    }
    lf_task **at = &server->life.held;
    while (*at)
        at = &(*at)->next;
    load->task.next = NULL;
    *at = &load->task;
}

void lf_server_release_loads(lf_server *server)
{
    while (server->life.held) {
        lf_load *load = (lf_load *)(void *)server->life.held;
        server->life.held = server->life.held->next;
        if (!lf_server_is_stopping(server)) {
            queue_load(server, load);
            continue;
        }
        load->status = lf_error_set(&load->err, LF_E_CANCELLED, "", "the daemon is shutting down");
        on_load_done(server, &load->task);
    }
}

void lf_server_reload(lf_server *server)
{
    const char *file = server->content ? server->content->file : server->config.scene;
    lf_load *load = file ? lf_load_create(LF_LOAD_FILE) : NULL;
    if (load) {
        load->file = lf_strdup(file);
        load->passed = lf_passed_ref(server->content ? server->content->passed : NULL);
        load->words = server->life.words;
    }
    if (!load || !load->file) {
        if (load)
            lf_load_destroy(load);
        lf_server_reloaded(server);
        return;
    }
    lf_server_load(server, load, NULL);
}
