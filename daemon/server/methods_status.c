#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/sandbox/import.h"
#include "daemon/server/methods_internal.h"

/* The folders whose files are read by name. */
static json_t *folders_json(const lf_server *server)
{
    json_t *folders = json_array();
    for (int i = 0; i < server->roots.n_roots; i++)
        json_array_append_new(folders, lf_rpc_text(server->roots.root[i]));
    return folders;
}

void lf_method_hello(lf_call *call)
{
    lf_reply(call,
             json_pack("{s:s, s:s, s:i, s:o, s:o, s:o, s:o, s:b}", "name", "quiltd", "version",
                       LF_VERSION, "protocol", LF_RPC_PROTOCOL, "folders",
                       folders_json(call->server), "farms", lf_server_farms_json(call->server),
                       "methods", lf_rights_methods_json(call->client), "events",
                       lf_rights_events_json(call->client), "limited",
                       lf_rights_limited(call->client)));
}

/* Exact, also beyond JSON's integers here. */
static json_t *seed_json(uint64_t seed)
{
    char text[24];
    snprintf(text, sizeof text, "%" PRIu64, seed);
    return seed <= INT64_MAX ? json_integer((json_int_t)seed) : json_string(text);
}

static json_t *known_or_null(double value)
{
    return value >= 0 ? json_real(value) : json_null();
}

/* Infinite values are null. */
static json_t *finite_or_null(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *depth_json(const lf_content *content)
{
    const lf_depth *d = &content->depth;
    if (!content->has_depth)
        return json_null();
    return json_pack("{s:f, s:f, s:o, s:f, s:f, s:f, s:o, s:b}", "nearest", d->nearest, "farthest",
                     d->farthest, "nearest_step", finite_or_null(d->nearest_step), "farthest_step",
                     d->farthest_step, "limit", d->limit, "sharp_from", d->sharp_from, "sharp_to",
                     finite_or_null(d->sharp_to), "exceeded", d->exceeded);
}

/* Files that clients have passed for the shown content. */
static json_t *passed_json(const lf_content *content)
{
    json_t *names = json_array();
    for (int i = 0; lf_passed_at(content->passed, i); i++)
        json_array_append_new(names, lf_rpc_text(lf_passed_at(content->passed, i)));
    return names;
}

static void add_content(const lf_server *server, json_t *status)
{
    const lf_content *content = server->content;
    if (!content) {
        json_object_set_new(status, "scene", json_null());
        return;
    }
    const lf_layout *layout = &content->layout;
    json_t *more = json_pack("{s:o, s:o, s:b, s:i, s:i, s:i, s:i, s:i, s:f}", "scene",
                             lf_rpc_text(content->file), "passed", passed_json(content), "is_quilt",
                             !content->scene, "views", layout->n_views, "columns", layout->columns,
                             "rows", layout->rows, "view_width", layout->view_width, "view_height",
                             layout->view_height, "aspect", layout->aspect);
    json_object_update(status, more);
    json_decref(more);
    if (!content->scene) {
        json_object_set_new(status, "is_rgbd", json_boolean(content->is_rgbd));
        json_object_set_new(status, "standing",
                            lf_param_json(lf_standing_params, &content->standing));
    }
    if (content->scene) {
        const char *integrator = content->settings.integrator;
        const lf_camera *camera = &content->settings.camera;
        if (camera->track > 0.0)
            json_object_set_new(status, "track", json_real(camera->track));
        else
            json_object_set_new(status, "cone",
                                json_real(camera->cone * (180 / 3.14159265358979323846)));
        json_object_set_new(status, "time", lf_time_json(server));
        json_object_set_new(status, "depth_budget", depth_json(content));
        json_object_set_new(status, "seed", seed_json(content->settings.seed));
        json_object_set_new(status, "integrator",
                            json_string(integrator ? integrator : lf_integrator_at(0)->name));
    }
}

/* null: no video is shown. */
static json_t *video_json(const lf_server *server)
{
    lf_movie_status now;
    if (!server->content || !server->content->player || !lf_engine_get_movie(server->engine, &now))
        return json_null();
    const lf_player_status *p = &now.player;
    return json_pack("{s:o, s:i, s:i, s:f, s:f, s:o, s:I, s:I, s:I, s:b, s:o}", "file",
                     lf_rpc_text(server->content->file), "width", p->width, "height", p->height,
                     "fps", p->fps, "seconds", p->seconds, "duration",
                     p->duration > 0 ? json_real(p->duration) : json_null(), "frame",
                     (json_int_t)p->frame, "shown", (json_int_t)now.shown, "dropped",
                     (json_int_t)now.dropped, "paused", (int)p->paused, "problem",
                     p->failed ? lf_rpc_text(p->err.what) : json_null());
}

/* null: no such frame yet. */
static json_t *cost_json(const lf_frame_cost *cost)
{
    return cost->paths >= 0
               ? json_pack("{s:f, s:f, s:f, s:f, s:f}", "paths", cost->paths, "fans", cost->fans,
                           "fit", cost->fit, "answer", cost->answer, "compose", cost->compose)
               : json_null();
}

static void add_engine(lf_server *server, json_t *status)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    lf_engine_controls controls = lf_engine_get_controls(server->engine);
    /* the engine may have a newer content than the server knows */
    int64_t generation = now.generation < server->generation ? now.generation : server->generation;
    json_t *more = json_pack(
        "{s:I, s:s, s:f, s:f, s:f, s:o, s:o, s:o, s:I, s:i, s:s, s:f, s:b, s:b, s:s, s:s}",
        "generation", (json_int_t)generation, "level", lf_level_name(now.level), "passes",
        now.passes, "seconds", now.seconds, "cpu_seconds", now.cpu_seconds, "spp",
        known_or_null(now.spp), "error_estimate", known_or_null(now.error_estimate), "error_bound",
        known_or_null(now.error_bound), "missing", (json_int_t)now.missing, "threads", now.threads,
        "estimator", lf_estimator_name(controls.estimator), "target_error", controls.target_error,
        "paused", (int)lf_server_is_paused(server), "guides", controls.guides, "denoise",
        now.reconstructed ? "on" : "off", "reconstruct", now.reconstructed ? "on" : "off");
    json_object_update(status, more);
    json_decref(more);
    json_object_set_new(status, "seconds_left", known_or_null(now.seconds_left));
    json_object_set_new(status, "denoised_error", known_or_null(now.shown_error));
    json_object_set_new(status, "denoised_error_bound", known_or_null(now.shown_error_bound));
    json_object_set_new(status, "shown_error", known_or_null(now.shown_error));
    json_object_set_new(status, "shown_error_bound", known_or_null(now.shown_error_bound));
    json_object_set_new(status, "coarse_cost", cost_json(&now.coarse_cost));
    json_object_set_new(status, "complete_cost", cost_json(&now.complete_cost));
    json_t *warnings = lf_server_warnings_json(server);
    if (lf_blank_words(now.blank, true))
        json_array_append_new(warnings, json_string(lf_blank_words(now.blank, true)));
    json_object_set_new(status, "warnings", warnings);
    json_object_set_new(status, "exposure",
                        json_pack("{s:f, s:b, s:s}", "stops", now.film.exposure, "auto",
                                  now.film.auto_exposure, "tonemap",
                                  now.film.tonemap[0] ? now.film.tonemap : "srgb"));
}

static json_t *card_json(const lf_shown *shown)
{
    return shown->card[0] != '\0' ? lf_rpc_text(shown->card) : json_null();
}

void lf_method_status(lf_call *call)
{
    lf_server *server = call->server;
    lf_device_counters counters = lf_show_counters(server->show);
    json_t *status = json_pack("{s:s}", "state", lf_server_state_name(server));
    add_content(server, status);
    add_engine(server, status);
    json_t *more = json_pack(
        "{s:{s:I, s:s, s:s, s:s, s:o}, s:o, s:I, s:I, s:I, s:i, s:o, s:o, s:s, s:i, s:I, s:o, s:f, "
        "s:f}",
        "shown", "generation", (json_int_t)server->shown.generation, "level",
        lf_level_name(server->shown.level), "image", lf_server_image_name(&server->shown),
        "picture", lf_server_picture_name(&server->shown), "card", card_json(&server->shown),
        "device", lf_server_device_json(server), "updates", (json_int_t)counters.updates, "bytes",
        (json_int_t)counters.bytes, "device_errors", (json_int_t)counters.errors, "loading",
        lf_loader_pending(server->loader), "load", lf_server_load_json(server), "reading",
        lf_server_reading_json(server), "landlock", lf_landlock_name(lf_import_landlock()),
        "clients", lf_clients_count(server->clients), "lines",
        (json_int_t)lf_clients_lines(server->clients), "jobs", lf_server_jobs_json(server),
        "uptime", lf_time_now() - server->life.started, "longest_turn", server->life.longest_turn);
    json_object_update(status, more);
    json_decref(more);
    json_object_set_new(status, "video", video_json(server));
    json_object_set_new(status, "playlist", lf_server_playlist_json(server));
    if (server->error.status != LF_OK) {
        json_t *answer = lf_rpc_error_of(NULL, &server->error, true);
        json_object_set(status, "error", json_object_get(answer, "error"));
        json_decref(answer);
    }
    lf_reply(call, status);
}

static lf_level level_of(const char *name)
{
    for (lf_level level = LF_LEVEL_COARSE; name && level < LF_LEVEL_CONVERGED; level++)
        if (strcmp(name, lf_level_name(level)) == 0)
            return level;
    return name ? LF_LEVEL_CONVERGED : LF_LEVEL_COARSE;
}

void lf_method_wait(lf_call *call)
{
    lf_server *server = call->server;
    const json_t *wanted = json_object_get(call->params, "generation");
    int64_t generation = wanted ? (int64_t)json_number_value(wanted) : server->generation;
    lf_error err;
    if (generation > server->generation) {
        (void)lf_error_set_at(&err, LF_E_ARG, call->method, 0, "/generation",
                              "generation %lld does not exist yet; the newest is %lld",
                              (long long)generation, (long long)server->generation);
        lf_fail(call, &err, false);
        return;
    }
    lf_deferred *deferred = lf_defer(call);
    if (!deferred)
        return;
    const lf_wait wait = {
        .call = deferred,
        .client = lf_deferred_client(deferred),
        .generation = generation,
        .level = level_of(json_string_value(json_object_get(call->params, "for"))),
        .seconds = json_number_value(json_object_get(call->params, "timeout")),
    };
    if (lf_waits_add(server->waits, &wait, &err) != LF_OK)
        lf_deferred_fail(deferred, &err, false);
}

void lf_method_subscribe(lf_call *call)
{
    static const char *const names[] = {"frame",  "converged", "device", "scene",
                                        "export", "button",    "log",    "playlist"};
    unsigned flags = 0;
    size_t i;
    json_t *event;
    json_array_foreach(json_object_get(call->params, "events"), i, event)
    {
        for (unsigned bit = 0; bit < sizeof names / sizeof *names; bit++)
            flags |= strcmp(names[bit], json_string_value(event)) == 0 ? 1u << bit : 0;
    }
    *lf_client_flags(call->client) = flags;
    lf_reply(call, json_pack("{s:O}", "events", json_object_get(call->params, "events")));
}

/* The bits of the named methods. LF_E_ARG: the client may not call one of them. */
static lf_status named_bits(lf_call *call, uint64_t *out_bits, lf_error *err)
{
    uint64_t bits = 0;
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(call->params, "methods"), i, name)
    {
        lf_error why;
        char pointer[32];
        const int index = lf_rights_find(call->client, json_string_value(name), &why);
        snprintf(pointer, sizeof pointer, "/methods/%zu", i);
        if (index < 0)
            return lf_error_set_at(err, LF_E_ARG, call->method, 0, pointer, "%s", why.what);
        bits |= UINT64_C(1) << index;
    }
    *out_bits = bits;
    return LF_OK;
}

void lf_method_rights_limit(lf_call *call)
{
    uint64_t kept = 0;
    lf_error err;
    if (named_bits(call, &kept, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    json_t *names = json_array();
    for (int i = 0; lf_method_at(i); i++)
        if ((kept >> i & 1) == 0)
            *lf_client_denied(call->client) |= UINT64_C(1) << i;
        else
            json_array_append_new(names, json_string(lf_method_at(i)->name));
    if (!lf_rights_have(call->client, "subscribe"))
        *lf_client_flags(call->client) = 0;
    lf_reply(call, json_pack("{s:o}", "methods", names));
}

void lf_method_shutdown(lf_call *call)
{
    lf_reply(call, json_object());
    lf_server_shutdown(call->server);
}
