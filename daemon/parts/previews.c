#include "daemon/parts/previews.h"

#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/threads/errands.h"

/* Each holds a copy of the views. */
#define MAX_PREVIEWS 8

typedef struct entry {
    lf_errand errand;
    lf_previews *previews;
    lf_preview asked;
    lf_preview_written written; /* owned by the thread until it has ended */
} entry;

struct lf_previews {
    lf_errands *errands;
    lf_engine *engine;
    lf_preview_ended_fn ended;
    void *context;
};

lf_status lf_previews_create(lf_inbox *inbox, lf_engine *engine, lf_preview_ended_fn ended,
                             void *context, lf_previews **out_previews)
{
    lf_previews *previews = lf_calloc(1, sizeof *previews);
    if (!previews)
        return LF_E_NOMEM;
    *previews = (lf_previews){NULL, engine, ended, context};
    if (lf_errands_create("lf-preview", MAX_PREVIEWS, previews, inbox, &previews->errands) !=
        LF_OK) {
        lf_free(previews);
        return LF_E_NOMEM;
    }
    *out_previews = previews;
    return LF_OK;
}

void lf_previews_destroy(lf_previews *previews)
{
    if (previews)
        lf_errands_destroy(previews->errands);
    lf_free(previews);
}

lf_status lf_previews_check_room(const lf_previews *previews, uint64_t client, lf_error *err)
{
    if (lf_errands_count_of(previews->errands, client) > 0)
        return lf_error_set(err, LF_E_BUSY, "frame.get",
                            "an image for this client is being written; wait for its answer");
    return lf_errands_count(previews->errands) < MAX_PREVIEWS
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, "frame.get",
                              "%d images are being written; try again when one has ended",
                              MAX_PREVIEWS);
}

/* -------------------------------------------------------------------------------- the thread -- */

static lf_status write_to(entry *e, const lf_shown_views *shown, lf_outfile *file, lf_error *err)
{
    lf_preview_written *written = &e->written;
    lf_status status = lf_preview_write(&e->asked.options, shown->rgb, &shown->layout,
                                        &e->errand.cancel, file, &written->layout, err);
    struct stat st;
    if (status == LF_OK && fstat(file->fd, &st) != 0)
        status = lf_error_set(err, LF_E_IO, "descriptor", "cannot be read back");
    if (status != LF_OK)
        return status;
    written->bytes = st.st_size;
    written->generation = shown->generation;
    written->level = shown->level;
    written->passes = shown->passes;
    written->reconstructed = shown->reconstructed;
    return LF_OK;
}

static lf_status make(entry *e, lf_error *err)
{
    lf_outfile file = {.fd = -1};
    lf_shown_views shown = {0};
    lf_status status = lf_outfile_adopt(&file, e->asked.fd, err);
    if (status != LF_OK)
        return status;
    e->asked.fd = -1;
    status = lf_engine_shown(e->previews->engine, e->asked.n_views, &e->errand.cancel, &shown, err);
    if (status == LF_OK)
        status = write_to(e, &shown, &file, err);
    lf_shown_views_finish(&shown);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, err);
    else
        lf_outfile_abandon(&file);
    return status;
}

static lf_status run(lf_errand *errand, lf_error *err)
{
    lf_status status = make((entry *)(void *)errand, err);
    if (status != LF_OK && err->where[0] == '\0')
        (void)snprintf(err->where, sizeof err->where, "frame.get");
    return status;
}

static void close_file(const entry *e)
{
    if (e->asked.fd >= 0)
        close(e->asked.fd);
}

static void on_done(void *context, lf_errand *errand)
{
    entry *e = (entry *)(void *)errand;
    const lf_previews *previews = context;
    const bool ok = errand->status == LF_OK;
    close_file(e);
    previews->ended(previews->context, &e->asked, ok ? &e->written : NULL,
                    ok ? NULL : &errand->err);
    lf_free(e);
}

/* ------------------------------------------------------------------------------------ asking -- */

lf_status lf_previews_add(lf_previews *previews, const lf_preview *what, lf_error *err)
{
    entry *e = lf_calloc(1, sizeof *e);
    if (e) {
        *e = (entry){.errand = {.client = what->client, .run = run, .done = on_done},
                     .previews = previews,
                     .asked = *what};
        if (lf_errands_add(previews->errands, &e->errand, NULL) == LF_OK)
            return LF_OK;
    }
    close(what->fd);
    lf_free(e);
    return lf_error_set(err, LF_E_NOMEM, "frame.get", "cannot start a thread");
}

bool lf_previews_busy(const lf_previews *previews)
{
    return lf_errands_count(previews->errands) > 0;
}

void lf_previews_end_of(lf_previews *previews, uint64_t client)
{
    lf_errands_end_of(previews->errands, client);
}

void lf_previews_end(lf_previews *previews)
{
    lf_errands_end(previews->errands);
}
