/* Cards without a picture: that there is no scene, what is being loaded, or why loading failed. A
 * shown picture stays, whatever happens to the next one. */
#include <stdio.h>
#include <string.h>

#include "daemon/server/server_internal.h"

/* Shorter loads show no card. */
#define LATE_USEC 1000000

static const char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] != '\0' ? slash + 1 : path;
}

/* The name of the scene being rendered or loaded. */
static const char *scene_name(const lf_server *server)
{
    const lf_load *load = lf_loading_first(server->loading);
    const char *file = server->content ? server->content->file : NULL;
    file = file || !load ? file : lf_loading_file(load);
    file = file ? file : server->config.scene;
    return file ? name_of(file) : "a scene";
}

/* For a text that begins with a path and a colon, such as an error about a file of the scene: the
 * text from the file name on, because a card has little room. */
static const char *without_folder(const char *words)
{
    const char *colon = words[0] == '/' ? strstr(words, ": ") : NULL;
    const char *name = words;
    for (const char *at = words; colon && at < colon; at++)
        name = *at == '/' ? at + 1 : name;
    return name;
}

static void say_error(const lf_error *err, char *out, size_t size)
{
    char line[14] = "";
    if (err->line > 0)
        snprintf(line, sizeof line, ":%d", err->line);
    snprintf(out, size, "Cannot show %.80s%s: %.270s", name_of(err->where), line,
             without_folder(err->what));
}

static void find_words(const lf_server *server, char *out, size_t size)
{
    const bool loads = server->life.held || lf_loader_pending(server->loader) > 0 ||
                       lf_errands_count(server->gallery.checks) > 0;
    out[0] = '\0';
    if (server->shown.level >= LF_LEVEL_COARSE || server->life.phase != LF_PHASE_RUNNING)
        return;
    if (server->content || loads) {
        if (server->life.card.late)
            snprintf(out, size, "%s %.120s", server->content ? "Rendering" : "Loading",
                     scene_name(server));
    } else if (server->error.status != LF_OK) {
        say_error(&server->error, out, size);
    } else {
        snprintf(out, size, "No scene is loaded. To load one: quiltctl scene.load file=NAME");
    }
}

/* Starts a wait, unless one is in progress. */
static void begin_wait(lf_server *server)
{
    const bool waits =
        server->content || server->life.held || lf_loader_pending(server->loader) > 0;
    if (waits && !server->life.card.waits && server->life.card.timer) {
        server->life.card.late = false;
        (void)sd_event_source_set_time_relative(server->life.card.timer, LATE_USEC);
        (void)sd_event_source_set_enabled(server->life.card.timer, SD_EVENT_ONESHOT);
    }
    server->life.card.waits = waits;
}

void lf_server_tell_card(lf_server *server)
{
    char words[LF_CARD_TEXT];
    if (lf_server_is_stopping(server))
        return;
    begin_wait(server);
    find_words(server, words, sizeof words);
    if (strcmp(words, server->life.card.words) == 0)
        return;
    memcpy(server->life.card.words, words, sizeof words);
    lf_engine_set_card(server->engine, words);
}

static int on_late(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)usec;
    server->life.card.late = true;
    lf_server_tell_card(server);
    return 0;
}

lf_status lf_server_make_card(lf_server *server)
{
    return sd_event_add_time_relative(server->event, &server->life.card.timer, CLOCK_MONOTONIC,
                                      LATE_USEC, 0, on_late, server) >= 0
               ? LF_OK
               : LF_E_NOMEM;
}
