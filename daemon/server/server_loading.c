/* Loads that wait or are under way: how far the reading of files is, which its readers tell on
 * threads of their own, and how a load ends before its time: by job.cancel, or for a later one. */
#include <string.h>

#include "base/alloc.h"
#include "base/import/import.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/server/server_internal.h"

/* A client hears of what takes longer than that, so often. */
#define TELL_USEC 500000
/* What is seen under way so often takes longer than a second. */
#define LOOKS_OF_LONG 3

struct lf_loading {
    pthread_mutex_t lock; /* of what follows */
    char path[PATH_MAX];  /* of the file that is read, of several one; "" = none is */
    uint64_t bytes;
    double begun;
    int n_read; /* files, since the daemon had nothing to load */
    /* the event thread's */
    sd_event_source *timer;
    lf_load *first; /* those that the loader has, as they were queued */
    lf_load *last;
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

/* ------------------------------------------------------------------------------ as it is told --
 */

static lf_load *find_load(const lf_server *server, int64_t id)
{
    lf_load *load = server->loading->first;
    while (load && load->job.id != id)
        load = load->job.later;
    return load;
}

/* Of one that a button turns to, the loader finds out what it is. */
static const char *file_of(const lf_load *load)
{
    return load->kind == LF_LOAD_FILE && !load->browsed ? load->file : NULL;
}

const char *lf_server_loading_file(const lf_server *server)
{
    const lf_load *load = server->loading->first;
    return load ? file_of(load) : NULL;
}

json_t *lf_server_load_json(lf_server *server)
{
    static const char *const kinds[] = {[LF_LOAD_FILE] = "file",
                                        [LF_LOAD_PATCH] = "patch",
                                        [LF_LOAD_ORBIT] = "orbit",
                                        [LF_LOAD_FIT] = "fit",
                                        [LF_LOAD_APPLY] = "settings"};
    const lf_load *load = find_load(server, lf_loader_current(server->loader));
    if (!load)
        return json_null();
    const char *file = file_of(load);
    return json_pack("{s:I, s:s, s:o}", "job", (json_int_t)load->job.id, "kind", kinds[load->kind],
                     "file", file ? lf_rpc_text(file) : json_null());
}

static void tell_reading(lf_server *server)
{
    json_t *reading = lf_server_reading_json(server);
    int64_t job = lf_loader_current(server->loader);
    if (json_is_object(reading) && job > 0) {
        json_object_set_new(reading, "job", json_integer((json_int_t)job));
        lf_server_notify(server, LF_EVENT_SCENE, "scene.load", reading);
    } else {
        json_decref(reading);
    }
}

/* --------------------------------------------------------------------------- before its time -- */

bool lf_server_cancel_load(lf_server *server, int64_t id)
{
    lf_load *load = find_load(server, id);
    if (load) {
        lf_loader_cancel(server->loader, load);
        lf_loader_drop_cancelled(server->loader);
    }
    return load;
}

/* Whoever asked has left. A half-closed connection stays for its answer. */
static bool asker_is_gone(const lf_server *server, const lf_load *load)
{
    return load->deferred && !lf_clients_find(server->clients, lf_deferred_client(load->deferred));
}

/* Of clients that have left little waits: what one of them has asked for is made all the same, and
 * yet nobody fills the queue by coming and going. */
void lf_server_end_loads_of_gone(lf_server *server)
{
    if (!lf_clients_left_much(server->clients))
        return;
    for (lf_load *load = server->loading->first; load; load = load->job.later)
        if (!atomic_load(&load->job.running) && asker_is_gone(server, load))
            lf_loader_cancel(server->loader, load);
    lf_loader_drop_cancelled(server->loader);
}

/* Whether somebody wants that file instead of what is loaded. */
static bool asks_for_file(const lf_load *load)
{
    return load->kind == LF_LOAD_FILE && (load->deferred || load->browsed);
}

static bool same_file(const lf_load *a, const lf_load *b)
{
    const char *file = file_of(a), *other = file_of(b);
    return file && other && strcmp(file, other) == 0;
}

/* A load that takes longer than LOOKS_OF_LONG and that nobody waits for makes room. One that
 * somebody asked for who has left makes room for any later one; what nobody asked for (the first
 * scene, a file that changed, a frame that is played) for another file alone. Quick ones are made
 * all the same. */
static void make_room(lf_server *server)
{
    const lf_load *last = NULL, *last_file = NULL;
    lf_load *load;
    for (load = server->loading->first; load; load = load->job.later) {
        if (asker_is_gone(server, load))
            continue;
        last = load;
        last_file = asks_for_file(load) ? load : last_file;
    }
    bool before = last, before_file = last_file;
    for (load = server->loading->first; load; load = load->job.later) {
        before = before && load != last;
        before_file = before_file && load != last_file;
        bool unasked = !load->deferred && (load->kind == LF_LOAD_FILE || load->played);
        bool replaced = (before && asker_is_gone(server, load) && !same_file(load, last)) ||
                        (before_file && unasked && !same_file(load, last_file));
        load->job.looks += atomic_load(&load->job.running) ? 1 : 0;
        if (load->job.looks < LOOKS_OF_LONG || !replaced || atomic_load(&load->job.cancelled))
            continue;
        lf_log(LF_LOG_INFO, "%s: its load ends for a later one",
               file_of(load) ? file_of(load) : "a change of what is shown");
        lf_loader_cancel(server->loader, load);
    }
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
    tell_reading(server);
    make_room(server);
    (void)sd_event_source_set_time_relative(source, TELL_USEC);
    (void)sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
    return 0;
}

static void put_last(lf_loading *loading, lf_load *load)
{
    load->job.later = NULL;
    load->job.earlier = loading->last;
    if (loading->last)
        loading->last->job.later = load;
    else
        loading->first = load;
    loading->last = load;
}

void lf_server_load_ended(lf_server *server, lf_load *load)
{
    lf_loading *loading = server->loading;
    lf_load *earlier = load->job.earlier, *later = load->job.later;
    if (load->job.id == 0) /* it was never queued */
        return;
    *(earlier ? &earlier->job.later : &loading->first) = later;
    *(later ? &later->job.earlier : &loading->last) = earlier;
}

void lf_server_loads(lf_server *server, lf_load *load)
{
    load->job.id = ++server->n_jobs;
    put_last(server->loading, load);
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
