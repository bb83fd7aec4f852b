#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/bell.h"
#include "base/log.h"
#include "daemon/server.h"

/* Of one client, at a time. */
#define MAX_WAITS 64

const char *lf_level_name(lf_level level)
{
    static const char *const names[] = {"none", "coarse", "complete", "converged"};
    return names[level];
}

const char *lf_server_state_name(const lf_server *server)
{
    if (server->stage == NULL) {
        return server->has_error ? "error" : "idle";
    }
    if (server->stage->scene == NULL) {
        return "idle";
    }
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

/* --------------------------------------------------------------------------------------------------- notifications -- */

typedef struct broadcast {
    unsigned event;
    const char *text;
    size_t n;
} broadcast;

static void send_frame(void *context, lf_client *client)
{
    const broadcast *b = context;
    if ((*lf_client_flags(client) & b->event) != 0) {
        lf_client_send_frame(client, b->text, b->n);
    }
}

typedef struct notification {
    unsigned event;
    json_t *message;
} notification;

static void send_message(void *context, lf_client *client)
{
    const notification *n = context;
    if ((*lf_client_flags(client) & n->event) != 0) {
        lf_client_send(client, json_incref(n->message));
    }
}

void lf_server_notify(lf_server *server, unsigned event, const char *method, json_t *params)
{
    json_t *message = lf_rpc_notification(method, params);
    if (message == NULL || server->clients == NULL) {
        json_decref(message);
        return;
    }
    if (event == LF_EVENT_FRAME) {
        char *text = json_dumps(message, JSON_COMPACT);
        broadcast b = {.event = event, .text = text, .n = text != NULL ? strlen(text) : 0};
        if (text != NULL) {
            lf_clients_each(server->clients, send_frame, &b);
        }
        free(text);
    } else {
        lf_clients_each(server->clients, send_message, &(notification){.event = event, .message = message});
    }
    json_decref(message);
}

/* ----------------------------------------------------------------------------------------------------------- waits -- */

static json_t *shown_json(const lf_server *server)
{
    return json_pack("{s:I, s:s}", "generation", (json_int_t)server->shown_generation, "level", lf_level_name(server->shown_level));
}

/* A frame may be shown before the loader's word has come that its scene is on stage, and whoever waits asks for that next. */
static bool is_over(const lf_server *server, const lf_wait *wait)
{
    return server->generation >= server->shown_generation && server->shown_generation >= wait->generation &&
           server->shown_level >= wait->level;
}

/* Those of clients that have left end too. */
static void answer_waits(lf_server *server)
{
    for (lf_wait **at = &server->waits; *at != NULL;) {
        lf_wait *wait = *at;
        bool left = server->clients == NULL || lf_clients_find(server->clients, lf_ticket_client(wait->ticket)) == NULL;
        if (!left && !is_over(server, wait)) {
            at = &wait->next;
            continue;
        }
        *at = wait->next;
        lf_ticket_reply(server, wait->ticket, shown_json(server));
        lf_free(wait);
    }
}

void lf_server_wait(lf_server *server, lf_ticket *ticket, int64_t generation, lf_level level)
{
    lf_error err;
    int n = 0;
    for (const lf_wait *other = server->waits; other != NULL; other = other->next) {
        n += lf_ticket_client(other->ticket) == lf_ticket_client(ticket) ? 1 : 0;
    }
    if (n >= MAX_WAITS) {
        (void)lf_error_set(&err, LF_E_BUSY, "wait", "this client waits %d times already", n);
        lf_ticket_fail(server, ticket, &err, false);
        return;
    }
    lf_wait *wait = lf_calloc(1, sizeof *wait);
    if (wait == NULL) {
        lf_ticket_reply(server, ticket, NULL);
        return;
    }
    *wait = (lf_wait){.next = server->waits, .ticket = ticket, .generation = generation, .level = level};
    server->waits = wait;
    answer_waits(server);
}

void lf_server_shown(lf_server *server, int64_t generation, lf_level level, double passes)
{
    bool news = generation != server->shown_generation || level != server->shown_level;
    server->shown_generation = generation;
    server->shown_level = level;
    lf_server_notify(
        server, LF_EVENT_FRAME, "frame",
        json_pack("{s:I, s:s, s:f}", "generation", (json_int_t)generation, "level", lf_level_name(level), "passes", passes));
    if (!news) {
        return;
    }
    lf_log(LF_LOG_DEBUG, "generation %lld: %s after %.1f passes", (long long)generation, lf_level_name(level), passes);
    if (level == LF_LEVEL_CONVERGED) {
        lf_server_notify(server, LF_EVENT_CONVERGED, "converged",
                         json_pack("{s:I, s:f}", "generation", (json_int_t)generation, "passes", passes));
    }
    answer_waits(server);
}

/* ---------------------------------------------------------------------------------------------------------- engine -- */

int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)events;
    lf_bell_silence(fd);
    lf_engine_state before = server->last.state;
    lf_engine_get_status(server->engine, &server->last);
    lf_server_pump(server);
    lf_server_start_jobs(server);
    if (server->last.state != before) {
        lf_server_tell_status(server);
    }
    if (server->stopping && lf_engine_stopped(server->engine)) {
        lf_server_shutdown(server);
    }
    return 0;
}

/* ---------------------------------------------------------------------------------------------------------- loader -- */

/* What the file itself says, for the buttons: patches come later. */
static void keep_file(lf_server *server)
{
    const lf_scene *scene = server->stage->scene;
    json_decref(server->file_camera);
    const json_t *camera = scene != NULL ? json_object_get(lf_scene_json(scene), "camera") : NULL;
    server->file_camera = camera != NULL ? json_deep_copy(camera) : json_object();
}

/* The answer to a load, and with it what is to be said of the scene's files. */
static json_t *load_answer(const lf_server *server, const lf_load *load)
{
    json_t *answer = json_pack("{s:I}", "generation", (json_int_t)server->generation), *lines;
    if (answer == NULL || load->kind == LF_LOAD_ORBIT || load->kind == LF_LOAD_APPLY) {
        return answer;
    }
    const lf_scene *scene = server->stage->scene;
    lines = json_array();
    for (int i = 0; scene != NULL && lf_scene_warning(scene, i) != NULL; i++) {
        (void)json_array_append_new(lines, lf_rpc_text(lf_scene_warning(scene, i)));
    }
    (void)json_object_set_new(answer, "warnings", lines);
    return answer;
}

static void load_succeeded(lf_server *server, lf_load *load)
{
    if (load->committed) {
        lf_stage_unref(server->stage);
        server->stage = load->stage;
        load->stage = NULL;
        server->generation = load->generation;
        lf_server_notify(
            server, LF_EVENT_SCENE, "scene",
            json_pack("{s:I, s:o}", "generation", (json_int_t)load->generation, "file", lf_rpc_text(server->stage->file)));
        if (load->kind == LF_LOAD_FILE) {
            keep_file(server);
            if (!load->browsed) {
                lf_free(server->browsed);
                server->browsed = NULL;
            }
            server->has_error = false;
            lf_server_watch(server);
            lf_log(LF_LOG_INFO, "%s: generation %lld%s", server->stage->file, (long long)load->generation,
                   load->restored ? ", going on with the saved state" : "");
        }
        answer_waits(server);
    }
    lf_ticket_reply(server, load->ticket, load_answer(server, load));
}

static void load_failed(lf_server *server, const lf_load *load)
{
    if (load->ticket == NULL && load->status != LF_E_CANCELLED) {
        lf_log_error(&load->err);
        server->has_error = true;
        server->error = load->err;
    }
    lf_ticket_fail(server, load->ticket, &load->err, load->status != LF_E_STATE && load->status != LF_E_CANCELLED);
}

static void on_load_done(void *reader, lf_letter *letter)
{
    lf_server *server = reader;
    lf_load *load = (lf_load *)(void *)letter;
    if (load->status == LF_OK) {
        load_succeeded(server, load);
    } else {
        load_failed(server, load);
    }
    bool browsed = load->browsed;
    bool plain = load->kind == LF_LOAD_FILE && load->ticket == NULL && !browsed;
    if (browsed && !server->stopping) {
        lf_server_browsed(server, load->file);
    }
    if (load->reset && !server->stopping) {
        lf_server_was_reset(server);
    }
    lf_load_destroy(load);
    if (server->stopping) {
        lf_server_shutdown(server);
    } else if (plain) {
        lf_server_reloaded(server);
        lf_server_ready(server);
    }
}

static void queue_load(lf_server *server, lf_load *load)
{
    load->options = server->options;
    load->has_calibration = server->panel.has_calibration;
    load->calibration = server->panel.calibration;
    lf_loader_queue(server->loader, load);
}

void lf_server_load(lf_server *server, lf_load *load, lf_ticket *ticket)
{
    load->letter.open = on_load_done;
    load->meant = server->config.scene;
    load->ticket = ticket;
    if (server->begun) {
        queue_load(server, load);
        return;
    }
    lf_letter **at = &server->held;
    while (*at != NULL) {
        at = &(*at)->next;
    }
    load->letter.next = NULL;
    *at = &load->letter;
}

void lf_server_release_loads(lf_server *server)
{
    while (server->held != NULL) {
        lf_load *load = (lf_load *)(void *)server->held;
        server->held = server->held->next;
        if (!server->stopping) {
            queue_load(server, load);
            continue;
        }
        load->status = lf_error_set(&load->err, LF_E_CANCELLED, "", "the daemon is shutting down");
        on_load_done(server, &load->letter);
    }
}

void lf_server_reload(lf_server *server)
{
    const char *file = server->stage != NULL ? server->stage->file : server->config.scene;
    lf_load *load = file != NULL ? lf_load_create(LF_LOAD_FILE) : NULL;
    if (load != NULL) {
        load->file = lf_strdup(file);
    }
    if (load == NULL || load->file == NULL) {
        if (load != NULL) {
            lf_load_destroy(load);
        }
        lf_server_reloaded(server);
        return;
    }
    lf_server_load(server, load, NULL);
}
