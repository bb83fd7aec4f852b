#include "daemon/parts/loading.h"

#include <pthread.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/sandbox/import.h"
#include "base/thread.h"

/* Interval of progress reports to a client; shorter loads have none. */
#define TELL_USEC 500000
/* A load seen in progress this often has taken longer than a second. */
#define LOOKS_OF_LONG 3

struct lf_loading {
    pthread_mutex_t lock;
    lf_load_reading reading; /* under lock; path "" = nothing is read */
    /* owned by the event thread */
    lf_loading_events events;
    void *context;
    lf_loader *loader;
    sd_event_source *timer;
    lf_load *first; /* the loader's loads, in order */
    lf_load *last;
};

static void on_reading(void *context, const lf_import_progress *progress)
{
    lf_loading *loading = context;
    lf_load_reading *r = &loading->reading;
    pthread_mutex_lock(&loading->lock);
    bool told = strcmp(r->path, progress->path) == 0;
    if (progress->ended) {
        r->n_read++;
        r->path[0] = told ? '\0' : r->path[0];
    } else if (!r->path[0] && strlen(progress->path) < sizeof r->path) {
        memcpy(r->path, progress->path, strlen(progress->path) + 1);
        r->bytes = progress->bytes;
        r->begun = lf_time_now() - progress->seconds;
    }
    pthread_mutex_unlock(&loading->lock);
}

bool lf_loading_reading(lf_loading *loading, lf_load_reading *out)
{
    pthread_mutex_lock(&loading->lock);
    *out = loading->reading;
    pthread_mutex_unlock(&loading->lock);
    return out->path[0] != '\0';
}

static lf_load *find_load(const lf_loading *loading, int64_t id)
{
    lf_load *load = loading->first;
    while (load && load->job.id != id)
        load = load->job.later;
    return load;
}

/* For a load by a button, the loader determines the file. */
const char *lf_loading_file(const lf_load *load)
{
    return load->kind == LF_LOAD_FILE && !load->job.browsed ? load->file : NULL;
}

const lf_load *lf_loading_first(const lf_loading *loading)
{
    return loading->first;
}

const lf_load *lf_loading_current(const lf_loading *loading)
{
    return find_load(loading, lf_loader_current(loading->loader));
}

static void tell_reading(lf_loading *loading)
{
    lf_load_reading reading;
    int64_t id = lf_loader_current(loading->loader);
    if (lf_loading_reading(loading, &reading) && id > 0)
        loading->events.reads(loading->context, id, &reading);
}

/* --------------------------------------------------------------------------- before its time -- */

bool lf_loading_cancel(lf_loading *loading, int64_t id)
{
    lf_load *load = find_load(loading, id);
    if (load) {
        lf_loader_cancel(loading->loader, load);
        lf_loader_drop_cancelled(loading->loader);
    }
    return load;
}

/* True if the client that asked has left. */
static bool is_vain(const lf_loading *loading, const lf_load *load)
{
    return loading->events.is_vain(loading->context, load);
}

void lf_loading_end_vain(lf_loading *loading)
{
    for (lf_load *load = loading->first; load; load = load->job.later)
        if (!atomic_load(&load->job.running) && is_vain(loading, load))
            lf_loader_cancel(loading->loader, load);
    lf_loader_drop_cancelled(loading->loader);
}

/* True if a client wants this file instead of the current load. */
static bool asks_for_file(const lf_load *load)
{
    return load->kind == LF_LOAD_FILE && (load->deferred || load->job.browsed);
}

static bool same_file(const lf_load *a, const lf_load *b)
{
    const char *file = lf_loading_file(a), *other = lf_loading_file(b);
    return file && other && strcmp(file, other) == 0;
}

/* Cancels long loads (LOOKS_OF_LONG) that nobody waits for. If the client that asked has left, the
 * load gives way to any later one. A load without a client (the first scene, a changed file, a
 * played frame) gives way only to another file. Short loads always finish. */
static void make_room(lf_loading *loading)
{
    const lf_load *last = NULL, *last_file = NULL;
    lf_load *load;
    for (load = loading->first; load; load = load->job.later) {
        if (is_vain(loading, load))
            continue;
        last = load;
        last_file = asks_for_file(load) ? load : last_file;
    }
    bool before = last, before_file = last_file;
    for (load = loading->first; load; load = load->job.later) {
        before = before && load != last;
        before_file = before_file && load != last_file;
        bool unasked = !load->deferred && (load->kind == LF_LOAD_FILE || load->played);
        bool replaced = (before && is_vain(loading, load) && !same_file(load, last)) ||
                        (before_file && unasked && !same_file(load, last_file));
        load->job.looks += atomic_load(&load->job.running) ? 1 : 0;
        if (load->job.looks < LOOKS_OF_LONG || !replaced || atomic_load(&load->job.cancelled))
            continue;
        lf_log(LF_LOG_INFO, "%s: the load was cancelled, because a later one replaces it",
               lf_loading_file(load) ? lf_loading_file(load) : "a change of the scene");
        lf_loader_cancel(loading->loader, load);
    }
}

static int on_tell(sd_event_source *source, uint64_t usec, void *context)
{
    lf_loading *loading = context;
    (void)usec;
    if (lf_loader_pending(loading->loader) == 0) {
        pthread_mutex_lock(&loading->lock);
        loading->reading.n_read = 0;
        pthread_mutex_unlock(&loading->lock);
        return 0;
    }
    tell_reading(loading);
    make_room(loading);
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

void lf_loading_ended(lf_loading *loading, lf_load *load)
{
    lf_load *earlier = load->job.earlier, *later = load->job.later;
    if (load->job.id == 0) /* it was never queued */
        return;
    *(earlier ? &earlier->job.later : &loading->first) = later;
    *(later ? &later->job.earlier : &loading->last) = earlier;
}

void lf_loading_add(lf_loading *loading, lf_load *load, int64_t id)
{
    load->job.id = id;
    put_last(loading, load);
    sd_event_source *timer = loading->timer;
    int enabled = SD_EVENT_OFF;
    (void)sd_event_source_get_enabled(timer, &enabled);
    if (enabled != SD_EVENT_OFF)
        return;
    (void)sd_event_source_set_time_relative(timer, TELL_USEC);
    (void)sd_event_source_set_enabled(timer, SD_EVENT_ONESHOT);
}

lf_status lf_loading_create(sd_event *event, lf_loader *loader, const lf_loading_events *events,
                            void *context, lf_loading **out_loading)
{
    lf_loading *loading = lf_calloc(1, sizeof *loading);
    if (!loading)
        return LF_E_NOMEM;
    *loading = (lf_loading){.events = *events, .context = context, .loader = loader};
    pthread_mutex_init(&loading->lock, NULL);
    if (sd_event_add_time_relative(event, &loading->timer, CLOCK_MONOTONIC, TELL_USEC, 0, on_tell,
                                   loading) < 0) {
        lf_loading_destroy(loading);
        return LF_E_NOMEM;
    }
    (void)sd_event_source_set_enabled(loading->timer, SD_EVENT_OFF);
    lf_import_watch(on_reading, loading);
    *out_loading = loading;
    return LF_OK;
}

void lf_loading_destroy(lf_loading *loading)
{
    if (!loading)
        return;
    lf_import_watch(NULL, NULL);
    sd_event_source_disable_unref(loading->timer);
    pthread_mutex_destroy(&loading->lock);
    lf_free(loading);
}
