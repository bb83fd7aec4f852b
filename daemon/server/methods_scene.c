#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/server/methods.h"

void lf_method_queue(lf_call *call, lf_load *load)
{
    if (!load) {
        lf_reply(call, NULL);
        return;
    }
    lf_deferred *deferred = lf_defer(call);
    if (!deferred) {
        lf_load_destroy(load);
        return;
    }
    lf_server_load(call->server, load, deferred);
}

void lf_method_scene_load(lf_call *call)
{
    lf_error err;
    char *file = NULL;
    lf_photo photo = call->server->options.photo;
    lf_status status =
        lf_param_from_json(lf_photo_params, call->params, &photo, "scene.load", &err);
    if (status == LF_OK)
        status = lf_param_from_json(lf_picture_params, call->params, &photo, "scene.load", &err);
    if (status == LF_OK)
        status = lf_server_read_path(
            call->server, json_string_value(json_object_get(call->params, "file")), &file, &err);
    if (status != LF_OK) {
        lf_fail(call, &err, status != LF_E_ARG);
        return;
    }
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    if (load) {
        load->file = file;
        load->photo = photo;
        load->has_photo = true;
    } else {
        lf_free(file);
    }
    lf_method_queue(call, load);
}

static json_t *bounds_json(const lf_scene *scene)
{
    double b[2][3];
    if (!scene || !lf_scene_bounds(scene, NULL, b))
        return json_null();
    return json_pack("{s:[f,f,f], s:[f,f,f]}", "min", b[0][0], b[0][1], b[0][2], "max", b[1][0],
                     b[1][1], b[1][2]);
}

void lf_method_scene_get(lf_call *call)
{
    const lf_content *content = call->server->content;
    lf_error err;
    if (!content) {
        (void)lf_error_set(&err, LF_E_STATE, call->method, "nothing is shown");
        lf_fail(call, &err, false);
        return;
    }
    if (content->scene && !content->document) {
        (void)lf_error_set(&err, LF_E_NOMEM, call->method,
                           "the scene's document is longer than 1 MiB, or memory for it ran out: "
                           "it is not sent");
        lf_fail(call, &err, false);
        return;
    }
    json_t *result =
        json_pack("{s:o, s:I, s:o}", "file", lf_rpc_text(content->file), "generation",
                  (json_int_t)call->server->generation, "bounds", bounds_json(content->scene));
    lf_reply_with(call, result, "scene", content->document ? content->document : "null");
}

static void queue_patch(lf_call *call, json_t *patch)
{
    lf_load *load = patch ? lf_load_create(LF_LOAD_PATCH) : NULL;
    if (load)
        load->patch = patch;
    else
        json_decref(patch);
    lf_method_queue(call, load);
}

void lf_method_scene_patch(lf_call *call)
{
    queue_patch(call, json_incref(json_object_get(call->params, "patch")));
}

void lf_method_camera_set(lf_call *call)
{
    queue_patch(call, json_pack("{s:O}", "camera", call->params));
}

static double number_of(const json_t *params, const char *key, double absent)
{
    const json_t *value = json_object_get(params, key);
    return value ? json_number_value(value) : absent;
}

void lf_method_camera_orbit(lf_call *call)
{
    lf_load *load = lf_load_create(LF_LOAD_ORBIT);
    if (load) {
        load->yaw = number_of(call->params, "yaw", 0);
        load->pitch = number_of(call->params, "pitch", 0);
        load->zoom = number_of(call->params, "zoom", 1);
    }
    lf_method_queue(call, load);
}

void lf_method_camera_fit(lf_call *call)
{
    lf_load *load = lf_load_create(LF_LOAD_FIT);
    const char *name = json_string_value(json_object_get(call->params, "name"));
    if (load) {
        load->fill = number_of(call->params, "fill", LF_CAMERA_FILL);
        load->steps = number_of(call->params, "steps", 0);
        load->name = name ? lf_strdup(name) : NULL;
    }
    if (load && name && !load->name) {
        lf_load_destroy(load);
        load = NULL;
    }
    lf_method_queue(call, load);
}

/* -------------------------------------------------------------------------------- render.set -- */

/* What the keys say, checked whole before anything is changed. */
static lf_status take_keys(const json_t *params, lf_engine_controls *controls, lf_options *options,
                           lf_error *err)
{
    const json_t *paused = json_object_get(params, "paused");
    options->estimator = controls->estimator;
    options->target_error = controls->target_error;
    options->exposure = controls->has_exposure ? controls->exposure : -(double)INFINITY;
    options->reconstruct = controls->reconstruct;
    options->guides = controls->guides;
    lf_status status = lf_param_from_json(lf_option_params, params, options, "render.set", err);
    if (status != LF_OK)
        return status;
    controls->estimator = options->estimator;
    controls->threads = options->threads;
    controls->target_error = options->target_error;
    controls->exposure = options->exposure;
    controls->has_exposure = true;
    controls->reconstruct = options->reconstruct;
    controls->guides = options->guides;
    controls->paused = paused ? json_is_true(paused) : controls->paused;
    return LF_OK;
}

static bool same_name(const char *a, const char *b)
{
    const char *x = a ? a : lf_integrator_at(0)->name, *y = b ? b : lf_integrator_at(0)->name;
    return strcmp(x, y) == 0;
}

void lf_method_render_set(lf_call *call)
{
    lf_server *server = call->server;
    lf_engine_controls before = lf_engine_get_controls(server->engine), controls = before;
    lf_options options = server->options;
    lf_error err;
    if (take_keys(call->params, &controls, &options, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    bool over = controls.threads != before.threads ||
                !same_name(options.integrator, server->options.integrator);
    lf_options_fit_integrator(&options);
    server->options = options;
    lf_engine_set_controls(server->engine, &controls);
    /* Features, which a film that was begun without them lacks. */
    bool more = before.reconstruct == LF_RECONSTRUCT_OFF &&
                (controls.reconstruct != before.reconstruct || (controls.guides && !before.guides));
    if (!over && !more) {
        lf_reply(call, json_pack("{s:I}", "generation", (json_int_t)server->generation));
        return;
    }
    lf_load *load = lf_load_create(LF_LOAD_APPLY);
    if (load)
        load->force = over;
    lf_method_queue(call, load);
}
