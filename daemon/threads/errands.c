#include "daemon/threads/errands.h"

#include <stddef.h>

#include "base/alloc.h"

/* Threads, in times of at_once: those above it belong to cancelled errands that do not end. */
#define MOST_TIMES 4

struct lf_errands {
    const char *name;
    int at_once;
    void *context;
    lf_inbox *inbox;
    lf_errand *first; /* the oldest */
};

lf_status lf_errands_create(const char *name, int at_once, void *context, lf_inbox *inbox,
                            lf_errands **out_errands)
{
    lf_errands *errands = lf_calloc(1, sizeof *errands);
    if (!errands)
        return LF_E_NOMEM;
    *errands = (lf_errands){name, at_once, context, inbox, NULL};
    *out_errands = errands;
    return LF_OK;
}

void lf_errands_destroy(lf_errands *errands)
{
    lf_free(errands);
}

int lf_errands_count(const lf_errands *errands)
{
    int n = 0;
    for (const lf_errand *e = errands->first; e; e = e->next)
        n++;
    return n;
}

int lf_errands_count_of(const lf_errands *errands, uint64_t client)
{
    int n = 0;
    for (const lf_errand *e = errands->first; e; e = e->next)
        n += e->client == client;
    return n;
}

static void unlink_errand(lf_errand *errand)
{
    lf_errand **at = &errand->errands->first;
    while (*at != errand)
        at = &(*at)->next;
    *at = errand->next;
}

static void *errand_main(void *context)
{
    lf_errand *errand = context;
    errand->status = errand->run(errand, &errand->err);
    lf_inbox_post(errand->errands->inbox, &errand->task);
    return NULL;
}

static lf_status start(lf_errand *errand)
{
    errand->started =
        lf_thread_start(errand->errands->name, errand_main, errand, &errand->thread) == LF_OK;
    return errand->started ? LF_OK
                           : lf_error_set(&errand->err, LF_E_NOMEM, "", "cannot start a thread");
}

/* Posts an errand that does not run. */
static void post(lf_errand *errand, lf_status status)
{
    errand->status = status;
    errand->posted = true;
    lf_inbox_post(errand->errands->inbox, &errand->task);
}

/* Its threads, and those of errands that are not cancelled. */
typedef struct crew {
    int all, wanted;
} crew;

static crew count_threads(const lf_errands *errands)
{
    crew n = {0, 0};
    for (const lf_errand *e = errands->first; e; e = e->next) {
        n.all += e->started;
        n.wanted += e->started && !atomic_load(&e->cancel);
    }
    return n;
}

static lf_status refuse(const lf_errands *errands, lf_error *err)
{
    return lf_error_set(err, LF_E_BUSY, "",
                        "%d cancelled calls still wait for a file system; mend or unmount it, or "
                        "try again later",
                        (MOST_TIMES - 1) * errands->at_once);
}

static void start_waiting(lf_errands *errands)
{
    crew n = count_threads(errands);
    for (lf_errand *e = errands->first; e && n.wanted < errands->at_once; e = e->next) {
        if (e->started || e->posted)
            continue;
        lf_status status =
            n.all < MOST_TIMES * errands->at_once ? start(e) : refuse(errands, &e->err);
        if (status != LF_OK)
            post(e, status);
        n.all += e->started;
        n.wanted += e->started;
    }
}

static void on_done(void *reader, lf_task *task)
{
    lf_errand *errand = (lf_errand *)(void *)((char *)(void *)task - offsetof(lf_errand, task));
    lf_errands *errands = errand->errands;
    (void)reader;
    if (errand->started)
        pthread_join(errand->thread, NULL);
    unlink_errand(errand);
    errand->done(errands->context, errand);
    start_waiting(errands);
}

lf_status lf_errands_add(lf_errands *errands, lf_errand *errand, lf_error *err)
{
    lf_errand **at = &errands->first;
    const crew n = count_threads(errands);
    if (n.all >= MOST_TIMES * errands->at_once)
        return refuse(errands, err);
    while (*at)
        at = &(*at)->next;
    errand->task = (lf_task){.done = on_done};
    errand->errands = errands;
    errand->next = NULL;
    errand->started = errand->posted = false;
    *at = errand;
    if (n.wanted >= errands->at_once || start(errand) == LF_OK)
        return LF_OK;
    *at = NULL;
    return lf_error_set(err, LF_E_NOMEM, "", "cannot start a thread");
}

static void cancel(lf_errand *errand)
{
    atomic_store(&errand->cancel, 1);
    if (errand->started && errand->stop)
        errand->stop(errand);
    if (!errand->started && !errand->posted)
        post(errand, lf_error_set(&errand->err, LF_E_CANCELLED, "", "cancelled"));
}

void lf_errands_end_of(lf_errands *errands, uint64_t client)
{
    for (lf_errand *e = errands->first; e; e = e->next)
        if (e->client == client)
            cancel(e);
    start_waiting(errands);
}

void lf_errands_end(lf_errands *errands)
{
    for (lf_errand *e = errands->first; e; e = e->next)
        cancel(e);
}
