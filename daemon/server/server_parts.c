/* What is played, saved and watched (daemon/parts), and what follows from what these tell. */
#include "base/alloc.h"
#include "daemon/server/server_internal.h"

/* ------------------------------------------------------------------------------------ saving -- */

static bool on_asked(void *context, lf_saved *out_now)
{
    const lf_server *server = context;
    lf_engine_status now;
    if (!server->content || !server->content->scene)
        return false;
    lf_engine_get_status(server->engine, &now);
    *out_now = (lf_saved){.generation = now.generation, .passes = now.passes};
    return true;
}

static lf_status on_save(void *context, lf_error *err)
{
    const lf_server *server = context;
    return lf_engine_keep(server->engine, err);
}

static void on_saved(void *context)
{
    if (lf_server_is_stopping(context))
        lf_server_shutdown(context);
}

lf_status lf_server_make_saver(lf_server *server, lf_error *err)
{
    static const lf_saver_events events = {.asked = on_asked, .save = on_save, .ended = on_saved};
    const lf_saver_home home = {.folder = server->config.state_dir,
                                .usec = LF_SAVE_USEC,
                                .event = server->event,
                                .inbox = &server->inbox};
    return lf_saver_create(&home, &events, server, &server->saver, err);
}

/* ----------------------------------------------------------------------------------- playing -- */

lf_load *lf_server_frame_load(int frame)
{
    lf_load *load = lf_load_create(LF_LOAD_PATCH);
    if (load)
        load->patch = json_pack("{s:i}", "frame", frame);
    if (load && !load->patch) {
        lf_load_destroy(load);
        return NULL;
    }
    return load;
}

static bool on_due(void *context, int frame)
{
    lf_load *load = lf_server_frame_load(frame);
    if (!load)
        return false;
    load->played = true;
    lf_server_load(context, load, NULL);
    return true;
}

lf_status lf_server_make_play(lf_server *server)
{
    static const lf_play_events events = {.due = on_due};
    return lf_play_create(server->event, &events, server, &server->play);
}

/* ---------------------------------------------------------------------------------- watching -- */

static void on_file_changed(void *context)
{
    if (!lf_server_is_stopping(context))
        lf_server_reload(context);
}

lf_status lf_server_make_watch(lf_server *server, lf_error *err)
{
    static const lf_watch_events events = {.changed = on_file_changed};
    lf_status status = lf_watch_create(server->event, &events, server, &server->watch, err);
    if (status == LF_OK)
        lf_server_watch(server);
    return status;
}

/* What lies under the names of files that were passed is not those files. */
void lf_server_watch(lf_server *server)
{
    const lf_content *content = server->content;
    const char *file = content ? content->file : server->config.scene;
    const lf_scene *scene = content ? content->scene : NULL;
    int n_included = 0;
    size_t n = 0;
    if (!file || !server->watch)
        return;
    while (scene && lf_scene_included(scene, n_included))
        n_included++;
    const char **files = lf_calloc((size_t)n_included + 1, sizeof *files);
    bool is_passed = content && content->is_passed;
    if (files && !is_passed)
        files[n++] = file;
    for (int i = 0; files && !is_passed && i < n_included; i++)
        if (!lf_passed_has(content->passed, lf_scene_included(scene, i)))
            files[n++] = lf_scene_included(scene, i);
    lf_watch_files(server->watch, files, n);
    lf_free((void *)files);
}
