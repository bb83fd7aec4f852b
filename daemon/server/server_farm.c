/* Exports that a farm renders (daemon/parts/farmed.h): their parameters, their words for
 * quiltrender, and reports to clients. */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/server/server_internal.h"

/* quiltfarm plan reads the whole scene. */
#define PLAN_S 1800
#define CALL_S 60
#define INTERVAL_S 10
#define MOST_VAIN 360 /* an hour of looks */

static const char *string_of(const json_t *params, const char *key)
{
    return json_string_value(json_object_get(params, key));
}

/* The farm's engine as the table has it, if it is allowed. */
static lf_status take_engine(const lf_server *server, const char *name, const char **out,
                             lf_error *err)
{
    int i = 0;
    while (lf_farmed_engine_at(i) && strcmp(lf_farmed_engine_at(i), name) != 0)
        i++;
    *out = lf_farmed_engine_at(i);
    if (*out && server->config.farms >> i & 1)
        return LF_OK;
    return lf_error_set_at(err, LF_E_STATE, "export", 0, "/farm",
                           "quiltd may not use the farm %s; start it with --farm %s", name, name);
}

/* Keys that belong together, and those that a farm has no use for. */
static lf_status check_keys(const json_t *params, lf_error *err)
{
    static const char *const needing[] = {"job", "spp", "passes"}, *const useless[] = {"fds",
                                                                                       "wait"};
    const bool has_farm = json_object_get(params, "farm");
    char pointer[16];
    for (size_t i = 0; i < sizeof needing / sizeof *needing; i++) {
        snprintf(pointer, sizeof pointer, "/%s", needing[i]);
        if (!has_farm && json_object_get(params, needing[i]))
            return lf_error_set_at(err, LF_E_ARG, "export", 0, pointer,
                                   "needs farm; quiltd itself exports what is shown");
    }
    for (size_t i = 0; has_farm && i < sizeof useless / sizeof *useless; i++) {
        snprintf(pointer, sizeof pointer, "/%s", useless[i]);
        if (json_object_get(params, useless[i]))
            return lf_error_set_at(err, LF_E_ARG, "export", 0, pointer,
                                   "cannot be combined with farm, which renders anew and by name");
    }
    if (has_farm && !json_object_get(params, "job"))
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/farm",
                               "needs job, the name of a new folder below --export-dir");
    if (json_object_get(params, "spp") && json_object_get(params, "passes"))
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/spp",
                               "cannot be combined with passes; give only one of them");
    return LF_OK;
}

lf_status lf_server_farm_check(const lf_server *server, const json_t *params, lf_error *err)
{
    const char *name = string_of(params, "farm"), *engine = NULL;
    lf_status status = check_keys(params, err);
    return status == LF_OK && name ? take_engine(server, name, &engine, err) : status;
}

/* What the farm can render: quiltrender makes it of a scene whose files it can open. */
static lf_status check_kind(const lf_server *server, const lf_export *what, lf_error *err)
{
    const lf_content *content = server->content;
    if (!what->kind || what->kind->rendered == LF_RENDERED_NOTHING)
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/kind",
                               "no farm makes this kind; leave farm out");
    if (!content->scene)
        return lf_error_set(err, LF_E_STATE, "export",
                            "a farm renders scenes, and a finished image is shown; leave farm out");
    if (lf_passed_at(content->passed, 0))
        return lf_error_set(err, LF_E_STATE, lf_passed_at(content->passed, 0),
                            "was passed to quiltd, so a farm cannot open it; start quiltd with "
                            "--allow-path and load the scene again");
    return LF_OK;
}

static lf_status take_folder(const lf_server *server, const char *name, lf_held_name *out,
                             lf_error *err)
{
    const size_t n = strlen(name);
    if (n == 0 || name[n - 1] == '/')
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/job",
                               "expects the name of a folder without a final slash");
    return lf_server_write_path(server, name, out, err);
}

/* ------------------------------------------------------------------------------------- words -- */

/* Cameras on a track or a grid are rendered as the scene has them. */
static bool has_track(const lf_content *content)
{
    return lf_scene_camera(content->scene)->track > 0;
}

/* How the panel changes the scene's camera, for kinds that quiltrender gives no panel. */
static json_t *camera_of(const lf_server *server, const lf_export *what)
{
    const lf_content *content = server->content;
    const lf_calibration *panel = lf_show_calibration(server->show);
    if (has_track(content) || what->kind->needs_panel)
        return NULL;
    json_t *camera = json_pack("{s:f}", "aspect", content->settings.camera.aspect);
    if (camera && panel && panel->view_cone_deg > 0)
        json_object_set_new(camera, "cone", json_real(panel->view_cone_deg));
    return camera;
}

/* A print chooses its own views and their size. */
static void add_views(lf_render_words *words, const lf_server *server, const lf_export *what,
                      const json_t *params)
{
    const lf_content *content = server->content;
    const lf_layout *layout = &content->layout;
    const bool is_free = !has_track(content), tiles = what->kind->has_tiles || what->kind->layers;
    if (what->kind->check_print) {
        if (json_object_get(params, "views"))
            lf_render_words_add(words, "--views=%d", what->print.n_views);
        return;
    }
    if (is_free && what->kind->rendered == LF_RENDERED_VIEWS)
        lf_render_words_add(words, "--views=%d", layout->n_views);
    if (is_free && tiles)
        lf_render_words_add(words, "--quilt=%dx%d", layout->columns, layout->rows);
    lf_render_words_add(words, "--view-size=%dx%d", layout->view_width, layout->view_height);
}

/* Measured exposure is written as a number, because each task of a farm sees only a part. */
static void add_exposure(lf_render_words *words, const lf_server *server)
{
    const lf_engine_controls controls = lf_engine_get_controls(server->engine);
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    const lf_options options = {.exposure =
                                    now.film.auto_exposure ? now.film.exposure : controls.exposure};
    if (controls.has_exposure || now.film.auto_exposure)
        lf_render_words_row(words, lf_param_find(lf_option_params, "exposure"), &options);
}

static bool is_denoised(const lf_server *server, const lf_export *what)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    return what->denoise == LF_DENOISE_AUTO ? now.reconstructed : what->denoise == LF_DENOISE_ON;
}

static void add_kind(lf_render_words *words, const lf_export *what, const char *folder,
                     const json_t *params)
{
    static const lf_panel_options plain;
    static const lf_rgbd_options no_depth;
    const lf_output_kind *kind = what->kind;
    if (kind->needs_panel) {
        lf_render_words_add(words, "--%s=%s/" LF_FARMED_PANEL, kind->option, folder);
        lf_render_words_differing(words, lf_panel_params, NULL, &what->panel, &plain);
        lf_render_words_differing(words, lf_response_params, NULL, &what->panel.response,
                                  &plain.response);
    } else if (kind->check_print) {
        lf_render_words_given(words, lf_print_params, params, &what->print);
        lf_render_words_given(words, lf_profile_params, params, &what->named);
    } else if (kind->layers) {
        lf_render_words_row(words, lf_param_find(lf_rgbd_params, kind->option), &what->rgbd);
        lf_render_words_differing(words, lf_rgbd_params, "rgbd-of depth-inversion near far",
                                  &what->rgbd, &no_depth);
    } else if (kind->option) {
        lf_render_words_add(words, "--%s", kind->option);
    }
}

static void add_budget(lf_render_words *words, const json_t *params)
{
    static const char *const names[] = {"spp", "passes"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const json_t *value = json_object_get(params, names[i]);
        if (value)
            lf_render_words_add(words, "--%s=%.0f", names[i], json_number_value(value));
    }
}

static lf_status add_words(const lf_server *server, const lf_export *what, const json_t *params,
                           lf_farmed_order *order, lf_error *err)
{
    const lf_engine_controls controls = lf_engine_get_controls(server->engine);
    lf_render_words *words = &order->words;
    add_kind(words, what, order->folder.path, params);
    add_views(words, server, what, params);
    add_budget(words, params);
    add_exposure(words, server);
    lf_render_words_settings(words, &server->content->settings, controls.estimator,
                             is_denoised(server, what));
    return words->failed ? lf_error_set(err, LF_E_NOMEM, "export", "out of memory") : LF_OK;
}

/* ---------------------------------------------------------------------------------- starting -- */

static lf_status take_order(const lf_call *call, const lf_export *what, lf_farmed_order *out,
                            lf_error *err)
{
    const lf_server *server = call->server;
    lf_status status = check_kind(server, what, err);
    if (status == LF_OK)
        status = take_engine(server, string_of(call->params, "farm"), &out->engine, err);
    if (status == LF_OK)
        status = take_folder(server, string_of(call->params, "job"), &out->folder, err);
    if (status != LF_OK)
        return status;
    out->client = lf_client_serial(call->client);
    out->kind = what->kind->name;
    out->overwrite = what->overwrite;
    out->file = lf_strdup(what->name ? what->name : what->file);
    out->content = lf_content_ref(server->content);
    out->camera = camera_of(server, what);
    out->has_calibration = what->kind->needs_panel;
    out->calibration = what->calibration;
    if (!out->file)
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    return add_words(server, what, call->params, out, err);
}

void lf_server_farm(lf_call *call, const lf_export *what)
{
    lf_server *server = call->server;
    lf_farmed_order order = {.folder.folder_fd = -1};
    lf_error err;
    lf_status status = take_order(call, what, &order, &err);
    if (status == LF_OK)
        status = lf_farmed_add(server->gallery.farmed, server->n_jobs + 1, &order, &err);
    if (status != LF_OK) {
        lf_farmed_order_finish(&order);
        lf_fail(call, &err, false);
        return;
    }
    lf_reply(call, json_pack("{s:I, s:o, s:[]}", "job", (json_int_t)++server->n_jobs, "file",
                             lf_rpc_text(order.file), "warnings"));
}

/* -------------------------------------------------------------------------------------- told -- */

static json_t *known(double seconds)
{
    return seconds >= 0 ? json_real(seconds) : json_null();
}

static json_t *farm_json(const lf_farmed_told *job)
{
    const lf_farmed_look *look = job->look;
    json_t *tasks =
        json_pack("{s:I, s:I, s:I, s:I, s:I}", "total", (json_int_t)look->total, "complete",
                  (json_int_t)look->complete, "running", (json_int_t)look->running, "failed",
                  (json_int_t)look->failed, "missing", (json_int_t)look->missing);
    return json_pack("{s:s, s:o, s:s, s:o, s:{s:o, s:o}, s:o, s:o}", "engine", job->engine,
                     "folder", lf_rpc_text(job->folder), "state", look->state, "tasks", tasks,
                     "cpu_seconds", "planned", known(look->planned), "spent", known(look->spent),
                     "seconds_left", known(look->seconds_left), "problem",
                     look->problem[0] != '\0' ? lf_rpc_text(look->problem) : json_null());
}

static json_t *told_json(const lf_farmed_told *job)
{
    static const char *const states[] = {[LF_FARMED_RUNNING] = "running",
                                         [LF_FARMED_DONE] = "done",
                                         [LF_FARMED_CANCELLED] = "cancelled",
                                         [LF_FARMED_FAILED] = "failed"};
    json_t *told = json_pack("{s:I, s:s, s:o, s:s, s:f, s:o}", "job", (json_int_t)job->id, "kind",
                             job->kind, "file", lf_rpc_text(job->file), "state", states[job->state],
                             "progress", job->progress, "farm", farm_json(job));
    if (job->err) {
        json_t *answer = lf_rpc_error_of(NULL, job->err, false);
        json_object_set(told, "error", json_object_get(answer, "error"));
        json_decref(answer);
    }
    return told;
}

void lf_server_farm_json(const lf_server *server, json_t *list)
{
    lf_farmed_told job;
    for (int i = 0; lf_farmed_at(server->gallery.farmed, i, &job); i++)
        json_array_append_new(list, told_json(&job));
}

json_t *lf_server_farms_json(const lf_server *server)
{
    json_t *names = json_array();
    for (int i = 0; lf_farmed_engine_at(i); i++)
        if (server->config.farms >> i & 1)
            json_array_append_new(names, json_string(lf_farmed_engine_at(i)));
    return names;
}

void lf_server_tell_export(lf_server *server, uint64_t asker, json_t *params)
{
    lf_client *client = lf_clients_find(server->clients, asker);
    if (client && (*lf_client_flags(client) & LF_EVENT_EXPORT) == 0)
        lf_client_send(client, lf_rpc_notification("export", json_incref(params)));
    lf_notify(server->clients, LF_EVENT_EXPORT, "export", params);
}

static void on_told(void *context, const lf_farmed_told *job)
{
    lf_server_tell_export(context, job->client, told_json(job));
}

static void on_ended(void *context)
{
    if (lf_server_is_stopping(context))
        lf_server_shutdown(context);
}

lf_status lf_server_make_farmed(lf_server *server)
{
    static const lf_farmed_events events = {.told = on_told, .ended = on_ended};
    const lf_farmed_home home = {.inbox = &server->inbox,
                                 .export_root = server->export_root,
                                 .state_dir = server->config.state_dir,
                                 .plan_s = PLAN_S,
                                 .call_s = CALL_S,
                                 .interval_s = INTERVAL_S,
                                 .most_vain = MOST_VAIN};
    return lf_farmed_create(&home, &events, server, &server->gallery.farmed);
}

void lf_server_take_up_farmed(lf_server *server)
{
    lf_farmed_take_up(server->gallery.farmed, server->config.farms, &server->n_jobs);
}
