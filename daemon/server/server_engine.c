#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/frame_name.h"
#include "base/log.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "daemon/server/server_internal.h"

static json_t *frame_json(const lf_shown *shown)
{
    json_t *frame =
        json_pack("{s:I, s:s, s:f, s:s, s:s}", "generation", (json_int_t)shown->generation, "level",
                  lf_level_name(shown->level), "passes", shown->passes, "image",
                  lf_server_image_name(shown), "picture", lf_server_picture_name(shown));
    if (frame && shown->card[0] != '\0')
        (void)json_object_set_new(frame, "card", lf_rpc_text(shown->card));
    return frame;
}

/* A video or a crossfade shows more frames than clients need to hear of. When it pauses or ends,
 * its last frame is shown once more, as one that does not move. */
#define FRAME_NEWS_S 0.25
static bool is_worth_telling(lf_server *server, const lf_shown *shown, bool news)
{
    const double now = lf_time_now();
    if (!news &&
        (shown->fades || (shown->moves && now - server->life.told_of_frame < FRAME_NEWS_S)))
        return false;
    server->life.told_of_frame = now;
    return true;
}

void lf_server_shown(lf_server *server, const lf_shown *shown)
{
    const lf_shown *before = &server->shown;
    bool news = shown->generation != before->generation || shown->level != before->level;
    if (shown->card[0] != '\0' && strcmp(shown->card, before->card) != 0 &&
        lf_show_calibration(server->show))
        lf_log(LF_LOG_INFO, "message on the panel: %s", shown->card);
    server->shown = *shown;
    if (is_worth_telling(server, shown, news)) {
        lf_notify(server->clients, LF_EVENT_FRAME, "frame", frame_json(shown));
        lf_server_warn_of_movie(server);
    }
    if (!news)
        return;
    lf_log(LF_LOG_DEBUG, "generation %lld: %s after %.1f passes", (long long)shown->generation,
           lf_level_name(shown->level), shown->passes);
    if (shown->level == LF_LEVEL_CONVERGED) {
        lf_notify(server->clients, LF_EVENT_CONVERGED, "converged",
                  json_pack("{s:I, s:f}", "generation", (json_int_t)shown->generation, "passes",
                            shown->passes));
    }
    lf_waits_look(server->waits);
    lf_play_shown(server->play, shown->generation, shown->level);
    lf_playlist_shown(server->gallery.playlist, shown->generation, shown->level);
    lf_server_tell_card(server);
}

/* ------------------------------------------------------------------------------------ engine -- */

int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)events;
    lf_wakeup_clear(fd);
    lf_engine_state before = server->last.state;
    lf_engine_get_status(server->engine, &server->last);
    lf_show_pump(server->show);
    lf_server_look_at_movie(server);
    lf_jobs_start(server->jobs);
    if (server->last.state != before)
        lf_server_tell_status(server);
    if (lf_server_is_stopping(server) && lf_engine_stopped(server->engine))
        lf_server_shutdown(server);
    return 0;
}

/* ------------------------------------------------------------------------------------ loader -- */

/* The answer to a load, with the warnings about the scene's files. */
static json_t *load_answer(const lf_server *server, const lf_load *load)
{
    json_t *answer = json_pack("{s:I}", "generation", (json_int_t)server->generation);
    if (answer && (load->kind == LF_LOAD_FILE || load->kind == LF_LOAD_PATCH))
        (void)json_object_set_new(answer, "warnings", lf_server_warnings_json(server));
    return answer;
}

/* Playback continues with the same file, read again. */
static void play_file(lf_server *server, bool same)
{
    if (same && server->content->scene && lf_scene_has_frames(server->content->scene))
        lf_play_again(server->play);
    else
        lf_play_stop(server->play);
}

static json_t *camera_of(const lf_scene *scene)
{
    return scene ? json_object_get(lf_scene_json(scene), "camera") : NULL;
}

static void tell_scene(const lf_server *server, const lf_load *load)
{
    json_t *told = json_pack("{s:I, s:o}", "generation", (json_int_t)load->generation, "file",
                             lf_rpc_text(server->content->file));
    if (told && load->job.turn > 0)
        (void)json_object_set_new(told, "turn", json_integer(load->job.turn));
    lf_notify(server->clients, LF_EVENT_SCENE, "scene", told);
}

static void load_succeeded(lf_server *server, lf_load *load)
{
    if (load->committed) {
        bool same = server->content && strcmp(server->content->file, load->content->file) == 0;
        lf_release_content(server->releaser, server->content);
        server->content = load->content;
        load->content = NULL;
        server->generation = load->generation;
        if (load->restored > 0)
            lf_saver_restored(server->saver, &(lf_saved){.generation = load->generation,
                                                         .passes = load->restored});
        if (!load->goes_on)
            lf_saver_begin(server->saver);
        tell_scene(server, load);
        if (load->kind == LF_LOAD_FILE) {
            server->life.words = load->words;
            lf_presses_file(server->presses, camera_of(server->content->scene), load->job.browsed);
            play_file(server, same);
            server->error.status = LF_OK;
            lf_server_watch(server);
            lf_log(load->job.listed ? LF_LOG_DEBUG : LF_LOG_INFO, "%s: generation %lld%s",
                   server->content->file, (long long)load->generation,
                   load->restored > 0 ? ", continuing from the saved state" : "");
        }
        lf_waits_look(server->waits);
    }
    lf_deferred_reply(load->deferred, load_answer(server, load));
}

/* The answer to a patch that failed. The file is as it was, so where only the document is wrong,
 * the pointer says where. */
static const char *patch_words(const lf_server *server, const lf_load *load, char *buf, size_t size)
{
    lf_error said = load->err, shown;
    (void)lf_error_set(&shown, LF_OK, server->content ? server->content->file : "", "shown");
    if (said.pointer[0] != '\0' && strcmp(said.where, shown.where) == 0) {
        said.where[0] = '\0';
        said.line = 0;
    }
    return lf_call_words(load->job.method, &said, buf, size);
}

static void call_failed(const lf_server *server, const lf_load *load)
{
    char text[LF_CALL_WORDS];
    bool wrong = load->kind == LF_LOAD_FIT && load->status == LF_E_ARG; /* a parameter */
    bool of_call = wrong || load->status == LF_E_STATE || load->status == LF_E_CANCELLED;
    if (load->kind == LF_LOAD_PATCH)
        patch_words(server, load, text, sizeof text);
    else
        lf_call_words(load->job.method, &load->err, text, sizeof text);
    if (!wrong && load->status != LF_E_CANCELLED)
        lf_log(LF_LOG_ERROR, "%s", text);
    if (load->kind == LF_LOAD_PATCH)
        lf_deferred_fail_saying(load->deferred, &load->err, !of_call, text);
    else
        lf_deferred_fail(load->deferred, &load->err, !of_call);
}

static void load_failed(lf_server *server, const lf_load *load)
{
    bool ended = load->status == LF_E_CANCELLED && !atomic_load(&load->job.cancelled);
    if (load->deferred) {
        call_failed(server, load);
        return;
    }
    if (load->job.listed && !server->content && !ended)
        server->error = load->err; /* for the card */
    if (!load->played && !load->job.listed && !ended) {
        lf_log_error(&load->err);
        server->error = load->err;
    }
}

static void destroy_load(void *load)
{
    lf_load_destroy(load);
}

static void destroy_huge_load(void *load)
{
    lf_load_destroy(load);
    lf_trim();
}

static void on_load_done(void *reader, lf_task *task)
{
    lf_server *server = reader;
    lf_load *load = (lf_load *)(void *)task;
    size_t bytes = load->deferred ? lf_deferred_bytes(load->deferred) : 0;
    lf_loading_ended(server->loading, load);
    if (load->status == LF_OK)
        load_succeeded(server, load);
    else
        load_failed(server, load);
    if (load->played)
        lf_play_loaded(server->play, load->generation, load->status == LF_OK ? NULL : &load->err);
    if (load->job.listed)
        lf_server_entry_loaded(server, load);
    bool browsed = load->job.browsed;
    const bool listed = load->job.listed;
    bool plain = load->kind == LF_LOAD_FILE && !load->deferred && !browsed && !listed;
    if (browsed && !lf_server_is_stopping(server))
        lf_presses_browsed(server->presses, load->file);
    if (load->reset && !lf_server_is_stopping(server))
        lf_presses_was_reset(server->presses);
    /* the last descriptor of a memory file frees its pages */
    if (bytes >= LF_LONG_LINE || load->sent.passed || load->sent.fd >= 0)
        lf_release(server->releaser, bytes >= LF_HUGE_LINE ? destroy_huge_load : destroy_load,
                   load);
    else
        lf_load_destroy(load);
    lf_waits_look_at_failure(server->waits);
    lf_server_tell_card(server);
    if (lf_server_is_stopping(server)) {
        lf_server_shutdown(server);
    } else if (plain) {
        lf_server_reloaded(server);
        lf_server_ready(server);
    } else if (listed) {
        lf_server_ready(server);
    }
}

static void queue_load(lf_server *server, lf_load *load)
{
    load->options = server->options;
    if (load->words.said) {
        load->options.alone = load->words.alone;
        load->options.photo = load->words.photo;
        load->options.standing = load->words.standing;
    }
    const lf_calibration *calibration = lf_show_calibration(server->show);
    load->has_calibration = calibration;
    if (calibration)
        load->calibration = *calibration;
    lf_loading_add(server->loading, load, load->job.id);
    lf_loader_queue(server->loader, load);
    lf_server_tell_card(server);
}

void lf_server_load(lf_server *server, lf_load *load, lf_deferred *deferred)
{
    load->task.done = on_load_done;
    load->job.id = ++server->n_jobs;
    load->meant = server->config.scene;
    load->deferred = deferred;
    if (load->kind == LF_LOAD_FILE && deferred) /* a client shows something else */
        lf_playlist_stop(server->gallery.playlist);
    if (load->kind == LF_LOAD_FILE)
        lf_engine_set_fade(
            server->engine,
            load->job.listed ? lf_playlist_now(server->gallery.playlist).how.crossfade : 0);
    if (server->life.phase != LF_PHASE_OPENING) {
        queue_load(server, load);
        return;
    }
    lf_task **at = &server->life.held;
    while (*at)
        at = &(*at)->next;
    load->task.next = NULL;
    *at = &load->task;
}

void lf_server_cancel_load(lf_server *server, int64_t id)
{
    for (lf_task *task = server->life.held; task; task = task->next) {
        lf_load *load = (lf_load *)(void *)task;
        if (load->job.id == id)
            lf_loader_cancel(server->loader, load);
    }
    (void)lf_loading_cancel(server->loading, id);
}

void lf_server_release_loads(lf_server *server)
{
    while (server->life.held) {
        lf_load *load = (lf_load *)(void *)server->life.held;
        server->life.held = server->life.held->next;
        if (!lf_server_is_stopping(server)) {
            queue_load(server, load);
            continue;
        }
        load->status = lf_error_set(&load->err, LF_E_CANCELLED, "", "the daemon is shutting down");
        on_load_done(server, &load->task);
    }
}

void lf_server_reload(lf_server *server)
{
    const char *file = server->content ? server->content->file : server->config.scene;
    if (lf_playlist_now(server->gallery.playlist).loads) /* it would replace the entry */
        file = NULL;
    lf_load *load = file ? lf_load_create(LF_LOAD_FILE) : NULL;
    if (load) {
        load->file = lf_strdup(file);
        load->sent.passed = lf_passed_ref(server->content ? server->content->passed : NULL);
        load->sent.document = server->content ? json_incref(server->content->sent) : NULL;
        load->words = server->life.words;
    }
    if (!load || !load->file) {
        if (load)
            lf_load_destroy(load);
        lf_server_reloaded(server);
        return;
    }
    lf_server_load(server, load, NULL);
}

/* Files on disk under the names of passed files are not those files, so they are not watched. A
 * scene that was sent has only files that it includes. */
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
    if (files && !is_passed && !(content && content->sent))
        files[n++] = file;
    for (int i = 0; files && !is_passed && i < n_included; i++)
        if (!lf_passed_has(content->passed, lf_scene_included(scene, i)))
            files[n++] = lf_scene_included(scene, i);
    lf_watch_files(server->watch, files, n);
    lf_free((void *)files);
}

/* ------------------------------------------------------------------------------ at the start -- */

static void load_first(lf_server *server, const char *scene)
{
    bool there = access(scene, R_OK) == 0 || lf_frame_name_varies(scene);
    int why = errno;
    lf_load *load = there ? lf_load_create(LF_LOAD_FILE) : NULL;
    if (!load) {
        /* Reported here: a missing folder is no root either, and the error "outside" would not
         * help. */
        (void)lf_error_set(&server->error, LF_E_IO, scene, "cannot open: %s",
                           there ? "out of memory" : lf_errno_text(why));
        lf_log_error(&server->error);
        lf_server_tell_card(server);
        lf_server_ready(server);
        return;
    }
    load->file = lf_strdup(scene);
    lf_server_load(server, load, NULL);
}

/* Waits for the panel, because its calibration determines views and aspect. */
void lf_server_begin(lf_server *server)
{
    if (server->life.phase != LF_PHASE_OPENING)
        return;
    server->life.phase = LF_PHASE_RUNNING;
    if (server->config.playlist.folder)
        lf_server_begin_playlist(server);
    else if (server->config.scene)
        load_first(server, server->config.scene);
    else
        lf_server_ready(server);
    lf_server_release_loads(server);
    lf_server_tell_card(server);
}
