/* The buttons of the panel: found beside its display, told to subscribers, and what they do. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server.h"

/* --------------------------------------------------------------------------------------------------------- actions -- */

/* Presses between two loads count together: who presses faster than scenes load gets to the last one, and a panel whose buttons chatter
 * keeps nothing else from being done. */
#define MAX_TURNS 1000000

/* One at a time. The folder is looked at on the loader's thread: it may be large, or on a drive that does not answer. */
static void load_browsed(lf_server *server)
{
    const char *shown = server->stage != NULL ? server->stage->file : server->config.scene;
    const char *from = server->browsed != NULL ? server->browsed : shown;
    if (from == NULL) {
        server->turns = 0;
        return;
    }
    lf_load *load = server->browsing ? NULL : lf_load_create(LF_LOAD_FILE);
    if (load == NULL) {
        return;
    }
    load->file = lf_strdup(from);
    load->step = server->turns;
    load->browsed = true;
    server->turns = 0;
    if (load->file == NULL) {
        lf_load_destroy(load);
        return;
    }
    server->browsing = true;
    lf_server_load(server, load, NULL);
}

void lf_server_browsed(lf_server *server, const char *file)
{
    server->browsing = false;
    /* From here on when a button is pressed again, also when this one cannot be shown. */
    lf_free(server->browsed);
    server->browsed = lf_strdup(file);
    if (server->turns != 0) {
        load_browsed(server);
    }
}

static void turn_page(lf_server *server, int step)
{
    if (abs(server->turns) < MAX_TURNS) {
        server->turns += step;
    }
    if (server->turns != 0) {
        load_browsed(server);
    }
}

static void toggle_pause(lf_server *server)
{
    lf_engine_controls controls = lf_engine_get_controls(server->engine);
    controls.paused = !controls.paused;
    lf_engine_set_controls(server->engine, &controls);
}

/* The file's own camera block, and null for the keys that it does not have. */
static json_t *camera_patch(const lf_server *server)
{
    json_t *camera = json_deep_copy(server->file_camera);
    const json_t *now = json_object_get(lf_scene_json(server->stage->scene), "camera");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)now, key, value)
    {
        if (json_object_get(camera, key) == NULL) {
            json_object_set_new(camera, key, json_null());
        }
    }
    return json_pack("{s:o}", "camera", camera);
}

/* One on the way, and one that takes back what came after it, stand for any number. */
static void reset_camera(lf_server *server)
{
    if (server->stage == NULL || server->stage->scene == NULL || server->file_camera == NULL) {
        return;
    }
    server->reset_again = server->resetting;
    lf_load *load = server->resetting ? NULL : lf_load_create(LF_LOAD_PATCH);
    if (load != NULL) {
        load->patch = camera_patch(server);
        load->reset = server->resetting = true;
        lf_server_load(server, load, NULL);
    }
}

void lf_server_was_reset(lf_server *server)
{
    server->resetting = false;
    if (server->reset_again) {
        reset_camera(server);
    }
}

void lf_server_press(lf_server *server, lf_button button)
{
    lf_action action = server->config.buttons.of[button];
    lf_server_notify(server, LF_EVENT_BUTTON, "button",
                     json_pack("{s:s, s:s}", "button", lf_button_name(button), "action", lf_action_name(action)));
    switch (action) {
    case LF_ACTION_NEXT:
        turn_page(server, 1);
        break;
    case LF_ACTION_PREVIOUS:
        turn_page(server, -1);
        break;
    case LF_ACTION_PAUSE:
        toggle_pause(server);
        break;
    case LF_ACTION_RESET:
        reset_camera(server);
        break;
    case LF_ACTION_NONE:
    case LF_ACTIONS_N:
        break;
    }
}

/* -------------------------------------------------------------------------------------------------------- watching -- */

void lf_server_drop_buttons(lf_server *server)
{
    sd_event_source_disable_unref(server->buttons_io);
    server->buttons_io = NULL;
    if (server->buttons == NULL) {
        return;
    }
    lf_errand *errand = lf_errand_create(LF_ERRAND_CLOSE);
    if (errand == NULL) {
        lf_buttons_destroy(server->buttons);
    } else {
        errand->buttons = server->buttons;
        errand->letter.open = lf_errand_forget;
        lf_opener_queue(server->opener, errand);
    }
    server->buttons = NULL;
}

/* Presses that are dealt with in a row; the rest come when all else had its turn. */
#define PRESSES_AT_ONCE 32

static int on_buttons(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    lf_button button;
    (void)source;
    (void)fd;
    (void)events;
    for (int i = 0; i < PRESSES_AT_ONCE; i++) {
        switch (lf_buttons_next(server->buttons, &button)) {
        case LF_BUTTONS_PRESSED:
            lf_server_press(server, button);
            break;
        case LF_BUTTONS_GONE:
            lf_server_drop_buttons(server);
            return 0;
        case LF_BUTTONS_NOTHING:
            return 0;
        }
    }
    return 0;
}

/* Whether they belong to the panel that is there now. */
static bool are_wanted(const lf_server *server, const lf_errand *errand)
{
    const lf_panel *panel = &server->panel;
    return !server->stopping && panel->device != NULL && panel->has_calibration &&
           strcmp(errand->spec, panel->calibration.serial) == 0;
}

static void on_buttons_found(void *reader, lf_letter *letter)
{
    lf_server *server = reader;
    lf_errand *errand = (lf_errand *)(void *)letter;
    bool again = server->seek_again || !are_wanted(server, errand);
    server->seeking_buttons = server->seek_again = false;
    if (errand->status == LF_OK && are_wanted(server, errand)) {
        int fd = lf_buttons_poll_fd(errand->buttons);
        if (sd_event_add_io(server->event, &server->buttons_io, fd, EPOLLIN, on_buttons, server) >= 0) {
            server->buttons = errand->buttons;
            errand->buttons = NULL;
        }
    } else if (errand->status != LF_OK && errand->status != LF_E_NODEV && errand->status != LF_E_CANCELLED) {
        lf_log_error(&errand->err);
    }
    if (errand->buttons != NULL && !server->stopping) { /* closing may wait */
        errand->kind = LF_ERRAND_CLOSE;
        errand->letter.open = lf_errand_forget;
        lf_opener_queue(server->opener, errand);
    } else {
        lf_errand_destroy(errand);
    }
    if (again && !server->stopping) {
        lf_server_find_buttons(server);
    }
}

void lf_server_find_buttons(lf_server *server)
{
    const lf_panel *panel = &server->panel;
    bool panel_there = panel->device != NULL && panel->has_calibration && strcmp(panel->device->ops->kind, "sim") != 0;
    if (server->buttons != NULL || !panel_there) {
        return;
    }
    if (server->seeking_buttons) {
        server->seek_again = true;
        return;
    }
    lf_errand *errand = lf_errand_create(LF_ERRAND_BUTTONS);
    if (errand != NULL) {
        snprintf(errand->spec, sizeof errand->spec, "%s", panel->calibration.serial);
        errand->letter.open = on_buttons_found;
        server->seeking_buttons = true;
        lf_opener_queue(server->opener, errand);
    }
}
