#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server/methods_internal.h"

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
    load->job.method = call->method;
    lf_server_load(call->server, load, deferred);
}

void lf_method_refuse(lf_call *call, lf_load *load, const lf_error *err, bool scene)
{
    char text[LF_CALL_WORDS];
    lf_load_destroy(load);
    if (err->status != LF_E_ARG)
        lf_log(LF_LOG_ERROR, "%s", lf_call_words(call->method, err, text, sizeof text));
    lf_fail(call, err, scene);
}

/* ------------------------------------------------------------------------------- descriptors -- */

/* The descriptors of a call, in their order: a scene, files, arrays. */
typedef struct descriptors {
    bool scene;
    const json_t *files, *arrays; /* NULL: none */
    int n;
    int fd[LF_MAX_CLIENT_FDS]; /* owned; -1: handed on */
} descriptors;

/* Takes what the call's parameters announce. */
static lf_status take_descriptors(const lf_call *call, descriptors *out, lf_error *err)
{
    *out = (descriptors){.scene = json_is_true(json_object_get(call->params, "scene_fd")),
                         .files = json_object_get(call->params, "files"),
                         .arrays = json_object_get(call->params, "arrays")};
    const int n_files = (int)json_array_size(out->files),
              n_arrays = (int)json_object_size(out->arrays), n = out->scene + n_files + n_arrays,
              given = lf_client_count_fds(call->client);
    if (!out->scene && !out->files && !out->arrays)
        return LF_OK;
    if (given == n && n <= LF_MAX_CLIENT_FDS && lf_client_take_fds(call->client, out->fd, n)) {
        out->n = n;
        return LF_OK;
    }
    if (out->scene || out->arrays)
        return lf_error_set_at(err, LF_E_ARG, call->method, 0,
                               out->arrays ? "/arrays" : "/scene_fd",
                               "the call names %d descriptors (%d scene, %d files, %d arrays), but "
                               "%d came with it",
                               n, out->scene, n_files, n_arrays, given);
    return lf_error_set_at(
        err, LF_E_ARG, call->method, 0, "/files",
        "names %d files, but %d descriptors came with the call; pass one descriptor per file", n,
        given);
}

static void close_descriptors(descriptors *d)
{
    for (int i = 0; i < d->n; i++)
        if (d->fd[i] >= 0)
            close(d->fd[i]);
}

static lf_status add_files(descriptors *d, lf_passed *passed, lf_error *err)
{
    int *fd = d->fd + d->scene;
    lf_status status = LF_OK;
    for (size_t i = 0; i < json_array_size(d->files) && status == LF_OK; i++) {
        status = lf_passed_add(passed, json_string_value(json_array_get(d->files, i)), fd[i], err);
        if (status == LF_OK)
            fd[i] = -1;
    }
    return status;
}

/* Types of arrays in calls. */
static bool type_of(const json_t *array, lf_array_type *out)
{
    const char *type = json_string_value(json_object_get(array, "type"));
    for (int i = LF_ARRAY_FLOAT32; type && i <= LF_ARRAY_UINT32; i++) {
        *out = (lf_array_type)i;
        if (strcmp(type, lf_array_type_name(i)) == 0)
            return true;
    }
    return false;
}

/* "shape": the slowest axis first, as numpy's. */
static lf_status read_shape(const json_t *array, const char *name, lf_array *out, lf_error *err)
{
    const json_t *shape = json_object_get(array, "shape");
    const size_t n = json_array_size(shape);
    bool good = n == 2 || n == 3;
    for (size_t i = 0; i < n && good; i++) {
        good = json_is_integer(json_array_get(shape, i));
        out->length[i] = json_integer_value(json_array_get(shape, i));
    }
    out->n_axes = (int)n;
    if (!good)
        return lf_error_set(err, LF_E_ARG, name,
                            "\"shape\" of an array must be [nz, ny, nx] or [n, columns]");
    if (!type_of(array, &out->type))
        return lf_error_set(err, LF_E_ARG, name,
                            "\"type\" of an array must be \"float32\" or \"uint32\"");
    return json_object_size(array) == 2
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, name, "an array has only \"shape\" and \"type\"");
}

static lf_status add_arrays(descriptors *d, lf_passed *passed, lf_error *err)
{
    int *fd = d->fd + d->scene + json_array_size(d->files);
    lf_status status = LF_OK;
    const char *name;
    json_t *array;
    json_object_foreach((json_t *)(uintptr_t)d->arrays, name, array)
    {
        lf_array is = {0};
        status = read_shape(array, name, &is, err);
        if (status == LF_OK)
            status = lf_passed_add_array(passed, name, &is, *fd, err);
        if (status != LF_OK)
            break;
        *fd++ = -1;
    }
    return status;
}

/* Errors about arrays name the method, as errors about other parameters do. */
static lf_status name_array(const lf_call *call, lf_status status, lf_error *err)
{
    lf_error inner;
    if (status == LF_OK)
        return LF_OK;
    inner = *err;
    return lf_error_set_at(err, status, call->method, 0, "/arrays", "%s: %s", inner.where,
                           inner.what);
}

/* Files and arrays of the client; *out NULL: none. Descriptors that are not handed on stay d's. */
static lf_status add_passed(const lf_call *call, descriptors *d, lf_passed **out, lf_error *err)
{
    *out = NULL;
    if (!d->files && !d->arrays)
        return LF_OK;
    lf_passed *passed = lf_passed_create();
    if (!passed)
        return lf_error_set(err, LF_E_NOMEM, call->method, "out of memory");
    lf_status status = add_files(d, passed, err);
    if (status == LF_OK)
        status = name_array(call, add_arrays(d, passed, err), err);
    if (status == LF_OK)
        *out = passed;
    else
        lf_passed_unref(passed);
    return status;
}

/* Hands the call's descriptors to the load. If one is refused, all are closed. */
static lf_status take_passed(lf_call *call, lf_load *load, lf_error *err)
{
    descriptors d;
    lf_status status = take_descriptors(call, &d, err);
    if (status == LF_OK)
        status = add_passed(call, &d, &load->sent.passed, err);
    if (status == LF_OK && d.scene) {
        load->sent.fd = d.fd[0];
        d.fd[0] = -1;
    }
    close_descriptors(&d);
    return status;
}

/* -------------------------------------------------------------------------------- scene.load -- */

/* The name is no path, so that nothing opens it. */
lf_status lf_method_name(const lf_call *call, const char *otherwise, char **out, lf_error *err)
{
    const char *name = json_string_value(json_object_get(call->params, "name"));
    if (name && (name[0] == '\0' || strlen(name) > LF_MAX_ARRAY_NAME || strchr(name, '/')))
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/name",
                               "expected a name of 1 to %d bytes without \"/\"", LF_MAX_ARRAY_NAME);
    lf_status status = name ? lf_check_name(name, err) : LF_OK;
    if (status != LF_OK)
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/name",
                               "control characters are not allowed");
    *out = lf_strdup(name ? name : otherwise);
    return *out ? LF_OK : lf_error_set(err, LF_E_NOMEM, call->method, "out of memory");
}

/* A scene that is sent needs no file, only a name for messages. */
static lf_status take_scene(const lf_call *call, lf_load *load, lf_error *err)
{
    load->sent.document = json_incref(json_object_get(call->params, "scene"));
    return lf_method_name(call, "scene", &load->file, err);
}

/* The scene is named, or sent in one of two ways. */
static lf_status check_source(const lf_call *call, lf_error *err)
{
    const bool file = json_object_get(call->params, "file"),
               fd = json_is_true(json_object_get(call->params, "scene_fd"));
    const int n = file + fd + !!json_object_get(call->params, "scene");
    if (n != 1)
        return lf_error_set(err, LF_E_ARG, call->method, "%s: \"file\", \"scene\" or \"scene_fd\"",
                            n == 0 ? "one is missing" : "only one is allowed");
    if (file && json_object_get(call->params, "name"))
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/name",
                               "applies only to a scene that is sent; a file has its own name");
    return LF_OK;
}

/* The file to show: inside the readable folders, otherwise a passed file. */
static lf_status find_file(const lf_call *call, const lf_passed *passed, char **out, lf_error *err)
{
    const char *file = json_string_value(json_object_get(call->params, "file"));
    lf_status status = lf_server_read_path(call->server, file, out, err);
    if (status == LF_OK || file[0] != '/' || !lf_passed_has(passed, file))
        return status;
    *out = lf_strdup(file);
    return *out ? LF_OK : lf_error_set(err, LF_E_NOMEM, file, "out of memory");
}

/* The tiles given in the call; 0: none. */
static lf_status take_tiles(const lf_call *call, lf_load *load, lf_error *err)
{
    const char *text = json_string_value(json_object_get(call->params, "quilt"));
    lf_options options = {0};
    lf_error wrong;
    if (!text)
        return LF_OK;
    if (!json_object_get(call->params, "file"))
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/quilt", "applies only to images");
    if (lf_param_from_text(lf_param_find(lf_option_params, "quilt"), text, &options, &wrong) !=
        LF_OK)
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/quilt", "%s", wrong.what);
    load->words.columns = options.columns;
    load->words.rows = options.rows;
    return LF_OK;
}

/* Options for placing a picture in its view, if the call has any. */
static lf_status take_photo(const lf_call *call, lf_load *load, lf_error *err)
{
    load->words.photo = call->server->options.photo;
    load->words.said = true;
    lf_status status =
        lf_param_from_json(lf_photo_params, call->params, &load->words.photo, "scene.load", err);
    if (status == LF_OK)
        status = lf_param_from_json(lf_picture_params, call->params, &load->words.photo,
                                    "scene.load", err);
    return status;
}

/* How a finished picture stands; missing keys are taken from the command line. */
static lf_status take_standing(const lf_call *call, lf_load *load, lf_error *err)
{
    load->words.standing = call->server->config.options.standing;
    return lf_param_from_json(lf_standing_params, call->params, &load->words.standing, "scene.load",
                              err);
}

/* Options for a file without a scene; missing ones are taken from the command line. */
static lf_status take_alone(const lf_call *call, lf_load *load, lf_error *err)
{
    load->words.alone = call->server->config.options.alone;
    return lf_param_from_json(lf_alone_params, call->params, &load->words.alone, "scene.load", err);
}

/* A scene defines its own look, so these options are errors. */
static lf_status refuse_words(const lf_call *call, const lf_load *load, lf_error *err)
{
    static const lf_param *const tables[] = {lf_alone_params, lf_photo_params, lf_picture_params,
                                             lf_standing_params};
    char pointer[32];
    const bool is_scene = lf_load_is_sent(load) || lf_path_has_ending(load->file, ".json");
    for (size_t i = 0; is_scene && i < sizeof tables / sizeof *tables; i++)
        for (const lf_param *row = tables[i]; row->name || row->option; row++) {
            if (!row->name || !json_object_get(call->params, row->name))
                continue;
            snprintf(pointer, sizeof pointer, "/%s", row->name);
            return lf_error_set_at(
                err, LF_E_ARG, call->method, 0, pointer,
                "applies only to files without a scene; set it in the scene file instead");
        }
    return LF_OK;
}

/* The parameters of a call that loads a file or a scene. */
static lf_status take_load(lf_call *call, lf_load *load, lf_error *err)
{
    lf_status status = check_source(call, err);
    if (status == LF_OK)
        status = take_passed(call, load, err);
    if (status == LF_OK)
        status = take_photo(call, load, err);
    if (status == LF_OK)
        status = take_standing(call, load, err);
    if (status == LF_OK)
        status = take_alone(call, load, err);
    if (status == LF_OK)
        status = take_tiles(call, load, err);
    if (status == LF_OK)
        status = json_object_get(call->params, "file")
                     ? find_file(call, load->sent.passed, &load->file, err)
                     : take_scene(call, load, err);
    if (status == LF_OK)
        status = refuse_words(call, load, err);
    return status == LF_OK && json_object_get(call->params, "file")
               ? lf_server_check_standing(call->params, load->file, &load->words, call->method, err)
               : status;
}

void lf_method_scene_load(lf_call *call)
{
    lf_error err;
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    lf_status status = load ? take_load(call, load, &err) : LF_OK;
    if (status == LF_OK)
        lf_method_queue(call, load);
    else
        lf_method_refuse(call, load, &err, status != LF_E_ARG);
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
        (void)lf_error_set(&err, LF_E_STATE, call->method,
                           "nothing is loaded; call scene.load first");
        lf_fail(call, &err, false);
        return;
    }
    if (content->scene && !content->document) {
        (void)lf_error_set(
            &err, LF_E_NOMEM, call->method,
            "the scene document is not sent, because it is longer than 1 MiB or memory ran out");
        lf_fail(call, &err, false);
        return;
    }
    json_t *result =
        json_pack("{s:o, s:I, s:o}", "file", lf_rpc_text(content->file), "generation",
                  (json_int_t)call->server->generation, "bounds", bounds_json(content->scene));
    lf_reply_with(call, result, "scene", content->document ? content->document : "null");
}

void lf_method_scene_patch(lf_call *call)
{
    lf_error err;
    lf_load *load = lf_load_create(LF_LOAD_PATCH);
    if (load && take_passed(call, load, &err) != LF_OK) {
        lf_method_refuse(call, load, &err, false);
        return;
    }
    if (load)
        load->patch = json_incref(json_object_get(call->params, "patch"));
    lf_method_queue(call, load);
}

void lf_method_camera_set(lf_call *call)
{
    json_t *patch = json_pack("{s:O}", "camera", call->params);
    lf_load *load = patch ? lf_load_create(LF_LOAD_PATCH) : NULL;
    if (load)
        load->patch = patch;
    else
        json_decref(patch);
    lf_method_queue(call, load);
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

/* Reads and checks all keys before anything is changed. */
static lf_status take_keys(const json_t *params, lf_engine_controls *controls, lf_options *options,
                           lf_error *err)
{
    options->estimator = controls->estimator;
    options->target_error = controls->target_error;
    options->exposure = controls->has_exposure ? controls->exposure : -(double)INFINITY;
    options->denoise = controls->denoise;
    options->guides = controls->guides;
    lf_status status = lf_param_from_json(lf_option_params, params, options, "render.set", err);
    if (status != LF_OK)
        return status;
    controls->estimator = options->estimator;
    controls->threads = options->threads;
    controls->target_error = options->target_error;
    controls->exposure = options->exposure;
    controls->has_exposure = true;
    controls->denoise = options->denoise;
    controls->guides = options->guides;
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
    server->options = options;
    lf_engine_set_controls(server->engine, &controls);
    if (json_object_get(call->params, "paused"))
        lf_server_pause(server, json_is_true(json_object_get(call->params, "paused")));
    /* Features, which a film without them lacks. */
    bool more = before.denoise == LF_DENOISE_OFF &&
                (controls.denoise != before.denoise || (controls.guides && !before.guides));
    if (!over && !more) {
        lf_reply(call, json_pack("{s:I}", "generation", (json_int_t)server->generation));
        return;
    }
    lf_load *load = lf_load_create(LF_LOAD_APPLY);
    if (load)
        load->force = over;
    lf_method_queue(call, load);
}
