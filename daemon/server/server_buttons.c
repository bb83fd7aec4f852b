/* Actions of a panel's buttons: --buttons, and the method `button`. */
#include "base/alloc.h"
#include "daemon/server/server_internal.h"

static bool on_browse(void *context, const char *from, int step)
{
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    if (!load)
        return false;
    load->file = lf_strdup(from);
    if (!load->file) {
        lf_load_destroy(load);
        return false;
    }
    load->step = step;
    load->job.browsed = load->fresh = true;
    lf_server_load(context, load, NULL);
    return true;
}

/* The file's own camera block, with null for the keys it does not have. */
static json_t *camera_patch(const lf_scene *scene, const json_t *own)
{
    json_t *camera = json_copy((json_t *)(uintptr_t)own);
    const json_t *now = json_object_get(lf_scene_json(scene), "camera");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)now, key, value)
    {
        if (!json_object_get(camera, key))
            json_object_set_new(camera, key, json_null());
    }
    return json_pack("{s:o}", "camera", camera);
}

static bool on_reset(void *context, const json_t *camera)
{
    lf_server *server = context;
    bool shown = server->content && server->content->scene;
    lf_load *load = shown ? lf_load_create(LF_LOAD_PATCH) : NULL;
    if (!load)
        return false;
    load->patch = camera_patch(server->content->scene, camera);
    load->reset = true;
    lf_server_load(server, load, NULL);
    return true;
}

static void on_release(void *context, json_t *value)
{
    const lf_server *server = context;
    lf_release_json(server->releaser, value);
}

lf_status lf_server_make_presses(lf_server *server)
{
    static const lf_presses_events events = {
        .browse = on_browse, .reset = on_reset, .release = on_release};
    return lf_presses_create(&events, server, &server->presses);
}

/* A playlist that is played takes the place of rendering. */
static void toggle_pause(lf_server *server)
{
    const lf_playlist_state list = lf_playlist_now(server->gallery.playlist);
    if (list.playing) {
        lf_playlist_pause(server->gallery.playlist, !list.paused);
        return;
    }
    lf_server_pause(server, !lf_server_is_paused(server));
}

/* A playlist that is played takes the place of the folder. */
static void turn(lf_server *server, int step)
{
    const char *shown = server->content ? server->content->file : server->config.scene;
    if (lf_playlist_now(server->gallery.playlist).playing)
        lf_playlist_step(server->gallery.playlist, step);
    else
        lf_presses_turn(server->presses, step, shown);
}

void lf_server_press(lf_server *server, lf_button button)
{
    lf_action action = server->config.buttons.of[button];
    lf_notify(server->clients, LF_EVENT_BUTTON, "button",
              json_pack("{s:s, s:s}", "button", lf_button_name(button), "action",
                        lf_action_name(action)));
    switch (action) {
    case LF_ACTION_NEXT:
        turn(server, 1);
        break;
    case LF_ACTION_PREVIOUS:
        turn(server, -1);
        break;
    case LF_ACTION_PAUSE:
        toggle_pause(server);
        break;
    case LF_ACTION_RESET:
        lf_presses_reset(server->presses);
        break;
    case LF_ACTION_NONE:
    case LF_ACTIONS_N:
        break;
    }
}
