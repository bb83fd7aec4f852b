/* How far the reading of files is. Whoever reads them tells on threads of its own. */
#include <string.h>

#include "base/alloc.h"
#include "base/import/import.h"
#include "base/thread.h"
#include "daemon/server/server.h"

/* A client hears of what takes longer than that, so often. */
#define TELL_USEC 500000

struct lf_loading {
    pthread_mutex_t lock; /* of what follows */
    char path[PATH_MAX];  /* of the file that is read, of several one; "" = none is */
    uint64_t bytes;
    double begun;
    int n_read; /* files, since the daemon had nothing to load */
    /* the event thread's */
    sd_event_source *timer;
};

static void on_reading(void *context, const lf_import_progress *progress)
{
    lf_loading *loading = context;
    pthread_mutex_lock(&loading->lock);
    bool told = strcmp(loading->path, progress->path) == 0;
    if (progress->ended) {
        loading->n_read++;
        loading->path[0] = told ? '\0' : loading->path[0];
    } else if (!loading->path[0] && strlen(progress->path) < sizeof loading->path) {
        memcpy(loading->path, progress->path, strlen(progress->path) + 1);
        loading->bytes = progress->bytes;
        loading->begun = lf_time_now() - progress->seconds;
    }
    pthread_mutex_unlock(&loading->lock);
}

json_t *lf_server_reading_json(lf_server *server)
{
    lf_loading *loading = server->loading;
    json_t *reading = json_null();
    pthread_mutex_lock(&loading->lock);
    if (loading->path[0])
        reading = json_pack("{s:o, s:I, s:f, s:i}", "file", lf_rpc_text(loading->path), "bytes",
                            (json_int_t)loading->bytes, "seconds", lf_time_now() - loading->begun,
                            "files_read", loading->n_read);
    pthread_mutex_unlock(&loading->lock);
    return reading;
}

static int on_tell(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    (void)usec;
    if (lf_loader_pending(server->loader) == 0) {
        pthread_mutex_lock(&server->loading->lock);
        server->loading->n_read = 0;
        pthread_mutex_unlock(&server->loading->lock);
        return 0;
    }
    json_t *reading = lf_server_reading_json(server);
    if (json_is_object(reading))
        lf_server_notify(server, LF_EVENT_SCENE, "scene.load", reading);
    else
        json_decref(reading);
    (void)sd_event_source_set_time_relative(source, TELL_USEC);
    (void)sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
    return 0;
}

void lf_server_loads(lf_server *server)
{
    sd_event_source *timer = server->loading->timer;
    int enabled = SD_EVENT_OFF;
    (void)sd_event_source_get_enabled(timer, &enabled);
    if (enabled != SD_EVENT_OFF)
        return;
    (void)sd_event_source_set_time_relative(timer, TELL_USEC);
    (void)sd_event_source_set_enabled(timer, SD_EVENT_ONESHOT);
}

lf_status lf_server_make_loading(lf_server *server)
{
    lf_loading *loading = server->loading = lf_calloc(1, sizeof *loading);
    if (!loading)
        return LF_E_NOMEM;
    pthread_mutex_init(&loading->lock, NULL);
    if (sd_event_add_time_relative(server->event, &loading->timer, CLOCK_MONOTONIC, TELL_USEC, 0,
                                   on_tell, server) < 0)
        return LF_E_NOMEM;
    (void)sd_event_source_set_enabled(loading->timer, SD_EVENT_OFF);
    lf_import_watch(on_reading, loading);
    return LF_OK;
}

void lf_server_drop_loading(lf_server *server)
{
    lf_loading *loading = server->loading;
    if (!loading)
        return;
    lf_import_watch(NULL, NULL);
    sd_event_source_disable_unref(loading->timer);
    pthread_mutex_destroy(&loading->lock);
    lf_free(loading);
    server->loading = NULL;
}
