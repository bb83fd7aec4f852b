/* What the buttons of a panel do: --buttons, and the method `button`. */
#include <stdlib.h>

#include "base/alloc.h"
#include "daemon/server/server_internal.h"

/* Presses between two loads count together: who presses faster than scenes load gets to the last
 * one, and a panel whose buttons chatter keeps nothing else from being done. */
#define MAX_TURNS 1000000

typedef enum reset_state {
    RESET_REST,
    RESET_BUSY,
    RESET_AGAIN, /* busy, and asked for once more */
} reset_state;

struct lf_button_work {
    json_t *file_camera; /* the camera block as the scene's file has it: shared with the scene */
    char *browsed;       /* where next and previous have come to; NULL = what is shown */
    bool browsing;       /* a scene that they asked for is being loaded */
    int turns;           /* presses since that was begun (previous: negative) */
    reset_state reset;   /* the camera on its way back */
};

lf_status lf_server_make_button_work(lf_server *server)
{
    server->button_work = lf_calloc(1, sizeof *server->button_work);
    return server->button_work ? LF_OK : LF_E_NOMEM;
}

void lf_server_drop_button_work(lf_server *server)
{
    lf_button_work *work = server->button_work;
    if (!work)
        return;
    json_decref(work->file_camera);
    lf_free(work->browsed);
    lf_free(work);
    server->button_work = NULL;
}

/* ---------------------------------------------------------------------------------- browsing -- */

/* One at a time. The folder is looked at on the loader's thread: it may be large, or on a drive
 * that does not answer. */
static void load_browsed(lf_server *server)
{
    lf_button_work *work = server->button_work;
    const char *shown = server->content ? server->content->file : server->config.scene;
    const char *from = work->browsed ? work->browsed : shown;
    if (!from) {
        work->turns = 0;
        return;
    }
    lf_load *load = work->browsing ? NULL : lf_load_create(LF_LOAD_FILE);
    if (!load)
        return;
    load->file = lf_strdup(from);
    load->step = work->turns;
    load->browsed = true;
    work->turns = 0;
    if (!load->file) {
        lf_load_destroy(load);
        return;
    }
    work->browsing = true;
    lf_server_load(server, load, NULL);
}

void lf_server_browsed(lf_server *server, const char *file)
{
    lf_button_work *work = server->button_work;
    work->browsing = false;
    /* From here on when a button is pressed again, also when this one cannot be shown. */
    lf_free(work->browsed);
    work->browsed = lf_strdup(file);
    if (work->turns != 0)
        load_browsed(server);
}

void lf_server_file_shown(lf_server *server, bool browsed)
{
    lf_button_work *work = server->button_work;
    const lf_scene *scene = server->content->scene;
    lf_server_release_json(server, work->file_camera);
    json_t *camera = scene ? json_object_get(lf_scene_json(scene), "camera") : NULL;
    work->file_camera = camera ? json_incref(camera) : json_object();
    if (!browsed) {
        lf_free(work->browsed);
        work->browsed = NULL;
    }
}

static void turn_page(lf_server *server, int step)
{
    lf_button_work *work = server->button_work;
    if (abs(work->turns) < MAX_TURNS)
        work->turns += step;
    if (work->turns != 0)
        load_browsed(server);
}

/* ----------------------------------------------------------------------------------- actions -- */

static void toggle_pause(lf_server *server)
{
    lf_engine_controls controls = lf_engine_get_controls(server->engine);
    controls.paused = !controls.paused;
    lf_engine_set_controls(server->engine, &controls);
}

/* The file's own camera block, and null for the keys that it does not have. */
static json_t *camera_patch(const lf_server *server)
{
    json_t *camera = json_copy(server->button_work->file_camera);
    const json_t *now = json_object_get(lf_scene_json(server->content->scene), "camera");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)now, key, value)
    {
        if (!json_object_get(camera, key))
            json_object_set_new(camera, key, json_null());
    }
    return json_pack("{s:o}", "camera", camera);
}

/* One on the way, and one that takes back what came after it, stand for any number. */
static void reset_camera(lf_server *server)
{
    lf_button_work *work = server->button_work;
    if (!server->content || !server->content->scene || !work->file_camera)
        return;
    if (work->reset != RESET_REST) {
        work->reset = RESET_AGAIN;
        return;
    }
    lf_load *load = lf_load_create(LF_LOAD_PATCH);
    if (load) {
        load->patch = camera_patch(server);
        load->reset = true;
        work->reset = RESET_BUSY;
        lf_server_load(server, load, NULL);
    }
}

void lf_server_was_reset(lf_server *server)
{
    bool again = server->button_work->reset == RESET_AGAIN;
    server->button_work->reset = RESET_REST;
    if (again)
        reset_camera(server);
}

void lf_server_press(lf_server *server, lf_button button)
{
    lf_action action = server->config.buttons.of[button];
    lf_server_notify(server, LF_EVENT_BUTTON, "button",
                     json_pack("{s:s, s:s}", "button", lf_button_name(button), "action",
                               lf_action_name(action)));
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
