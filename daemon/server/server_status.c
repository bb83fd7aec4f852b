/* The daemon's state, in answers and for systemd. */
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <systemd/sd-daemon.h>

#include "base/thread.h"
#include "daemon/server/server_internal.h"

const char *lf_server_image_name(const lf_shown *shown)
{
    if (shown->card[0] != '\0')
        return "card";
    return shown->reconstructed ? "denoised" : "unfiltered";
}

const char *lf_server_picture_name(const lf_shown *shown)
{
    const char *name = lf_server_image_name(shown);
    return strcmp(name, "denoised") == 0 ? "reconstructed" : name;
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
    char words[LF_DEPTH_WORDS], movie[LF_MOVIE_WARNING];
    if (!content)
        return lines;
    for (int i = 0; content->scene && lf_scene_warning(content->scene, i); i++)
        (void)json_array_append_new(lines, lf_rpc_text(lf_scene_warning(content->scene, i)));
    append_notes(lines, content);
    for (int i = 0; i < LF_MOVIE_WARNINGS; i++)
        if (lf_server_movie_warning(server, i, movie))
            (void)json_array_append_new(lines, lf_rpc_text(movie));
    if (content->depth.exceeded)
        (void)json_array_append_new(
            lines, json_string(lf_depth_words(&content->depth, content->settings.width,
                                              LF_DEPTH_PANEL, words, sizeof words)));
    if (content->is_unseen)
        (void)json_array_append_new(lines, json_string(lf_unseen_words(true)));
    return lines;
}

/* The current load. */
json_t *lf_server_load_json(const lf_server *server)
{
    static const char *const kinds[] = {[LF_LOAD_FILE] = "file",
                                        [LF_LOAD_PATCH] = "patch",
                                        [LF_LOAD_ORBIT] = "orbit",
                                        [LF_LOAD_FIT] = "fit",
                                        [LF_LOAD_APPLY] = "settings"};
    const lf_load *load = lf_loading_current(server->loading);
    if (!load)
        return json_null();
    const char *file = lf_loading_file(load);
    return json_pack("{s:I, s:s, s:o}", "job", (json_int_t)load->job.id, "kind", kinds[load->kind],
                     "file", file ? lf_rpc_text(file) : json_null());
}

json_t *lf_reading_json(const lf_load_reading *reading)
{
    return json_pack("{s:o, s:I, s:f, s:i}", "file", lf_rpc_text(reading->path), "bytes",
                     (json_int_t)reading->bytes, "seconds", lf_time_now() - reading->begun,
                     "files_read", reading->n_read);
}

json_t *lf_server_reading_json(lf_server *server)
{
    lf_load_reading reading;
    return lf_loading_reading(server->loading, &reading) ? lf_reading_json(&reading) : json_null();
}

/* ----------------------------------------------------------------------------------- systemd -- */

void lf_server_tell_status(lf_server *server)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    char error[sizeof server->error + 32];
    bool failed = !server->content && server->error.status != LF_OK;
    const char *problem = lf_show_problem(server->show);
    sd_notifyf(0, "STATUS=%s%s%s, generation %" PRId64 ", %.1f passes; panel %s%s%s",
               lf_server_state_name(server), failed ? ": " : "",
               failed ? lf_error_format(&server->error, error, sizeof error) : "", now.generation,
               now.passes, lf_show_spec(server->show), problem ? ": " : "", problem ? problem : "");
}

void lf_server_ready(lf_server *server)
{
    if (!server->life.ready_sent) {
        server->life.ready_sent = true;
        sd_notify(0, "READY=1");
    }
    lf_server_tell_status(server);
}

void lf_server_reloaded(lf_server *server)
{
    if (server->life.reloads > 0 && --server->life.reloads == 0)
        sd_notify(0, "READY=1");
}
