#include "daemon/parts/previews.h"

#include <pthread.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/thread.h"

/* Each holds a copy of the views. */
#define MAX_PREVIEWS 8

typedef struct entry {
    lf_task task;
    struct entry *next;
    lf_previews *previews;
    lf_preview asked;
    pthread_t thread;
    lf_cancel cancel;
    /* owned by the thread until it has ended */
    lf_preview_written written;
    lf_status status;
    lf_error err;
} entry;

struct lf_previews {
    lf_inbox *inbox;
    lf_engine *engine;
    lf_preview_ended_fn ended;
    void *context;
    entry *first; /* the newest */
};

lf_status lf_previews_create(lf_inbox *inbox, lf_engine *engine, lf_preview_ended_fn ended,
                             void *context, lf_previews **out_previews)
{
    lf_previews *previews = lf_calloc(1, sizeof *previews);
    if (!previews)
        return LF_E_NOMEM;
    *previews = (lf_previews){inbox, engine, ended, context, NULL};
    *out_previews = previews;
    return LF_OK;
}

void lf_previews_destroy(lf_previews *previews)
{
    lf_free(previews);
}

lf_status lf_previews_check_room(const lf_previews *previews, uint64_t client, lf_error *err)
{
    int n = 0;
    for (const entry *e = previews->first; e; e = e->next, n++)
        if (e->asked.client == client)
            return lf_error_set(err, LF_E_BUSY, "frame.get",
                                "an image for this client is being written; wait for its answer");
    return n < MAX_PREVIEWS
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, "frame.get",
                              "%d images are being written; try again when one has ended",
                              MAX_PREVIEWS);
}

/* -------------------------------------------------------------------------------- the thread -- */

static lf_status write_to(entry *e, const lf_shown_views *shown, lf_outfile *file)
{
    lf_preview_written *written = &e->written;
    lf_status status = lf_preview_write(&e->asked.options, shown->rgb, &shown->layout, &e->cancel,
                                        file, &written->layout, &e->err);
    struct stat st;
    if (status == LF_OK && fstat(file->fd, &st) != 0)
        status = lf_error_set(&e->err, LF_E_IO, "descriptor", "cannot be read back");
    if (status != LF_OK)
        return status;
    written->bytes = st.st_size;
    written->generation = shown->generation;
    written->level = shown->level;
    written->passes = shown->passes;
    written->reconstructed = shown->reconstructed;
    return LF_OK;
}

static lf_status make(entry *e)
{
    lf_outfile file = {.fd = -1};
    lf_shown_views shown = {0};
    lf_status status = lf_outfile_adopt(&file, e->asked.fd, &e->err);
    if (status != LF_OK)
        close(e->asked.fd);
    if (status == LF_OK)
        status =
            lf_engine_shown(e->previews->engine, e->asked.n_views, &e->cancel, &shown, &e->err);
    if (status == LF_OK)
        status = write_to(e, &shown, &file);
    lf_shown_views_finish(&shown);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, &e->err);
    else
        lf_outfile_abandon(&file);
    return status;
}

static void *preview_main(void *context)
{
    entry *e = context;
    e->status = make(e);
    if (e->status != LF_OK && e->err.where[0] == '\0')
        (void)snprintf(e->err.where, sizeof e->err.where, "frame.get");
    lf_inbox_post(e->previews->inbox, &e->task);
    return NULL;
}

static void unlink_entry(entry *e)
{
    entry **at = &e->previews->first;
    while (*at != e)
        at = &(*at)->next;
    *at = e->next;
}

static void on_done(void *reader, lf_task *task)
{
    entry *e = (entry *)(void *)task;
    const lf_previews *previews = e->previews;
    (void)reader;
    pthread_join(e->thread, NULL);
    unlink_entry(e);
    const bool ok = e->status == LF_OK;
    previews->ended(previews->context, &e->asked, ok ? &e->written : NULL, ok ? NULL : &e->err);
    lf_free(e);
}

/* ------------------------------------------------------------------------------------ asking -- */

lf_status lf_previews_add(lf_previews *previews, const lf_preview *what, lf_error *err)
{
    entry *e = lf_calloc(1, sizeof *e);
    if (e) {
        *e = (entry){
            .task.done = on_done, .next = previews->first, .previews = previews, .asked = *what};
        previews->first = e;
        if (lf_thread_start("lf-preview", preview_main, e, &e->thread) == LF_OK)
            return LF_OK;
        unlink_entry(e);
    }
    close(what->fd);
    lf_free(e);
    return lf_error_set(err, LF_E_NOMEM, "frame.get", "cannot start a thread");
}

bool lf_previews_busy(const lf_previews *previews)
{
    return previews->first;
}

void lf_previews_end_of(lf_previews *previews, uint64_t client)
{
    for (entry *e = previews->first; e; e = e->next)
        if (e->asked.client == client)
            atomic_store_explicit(&e->cancel, 1, memory_order_relaxed);
}

void lf_previews_end(lf_previews *previews)
{
    for (entry *e = previews->first; e; e = e->next)
        atomic_store_explicit(&e->cancel, 1, memory_order_relaxed);
}
