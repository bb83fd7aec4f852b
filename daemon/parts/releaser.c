#include "daemon/parts/releaser.h"

#include "base/alloc.h"
#include "daemon/threads/worker.h"

struct lf_releaser {
    lf_worker *worker;
};

typedef struct release {
    lf_task task;
    void (*destroy)(void *thing);
    void *thing;
} release;

static void run_release(void *context, lf_task *task)
{
    const release *r = (release *)(void *)task;
    (void)context;
    r->destroy(r->thing);
}

static void on_released(void *reader, lf_task *task)
{
    (void)reader;
    lf_free(task);
}

void lf_release(lf_releaser *releaser, void (*destroy)(void *thing), void *thing)
{
    release *r = thing && releaser ? lf_calloc(1, sizeof *r) : NULL;
    if (r) {
        *r = (release){.task.done = on_released, .destroy = destroy, .thing = thing};
        lf_worker_queue(releaser->worker, &r->task);
    } else if (thing) {
        destroy(thing);
    }
}

static void free_content(void *content)
{
    lf_content_unref(content);
}

void lf_release_content(lf_releaser *releaser, lf_content *content)
{
    lf_release(releaser, free_content, content);
}

static void free_json(void *value)
{
    json_decref(value);
    lf_trim();
}

void lf_release_json(lf_releaser *releaser, json_t *value)
{
    lf_release(releaser, free_json, value);
}

lf_status lf_releaser_create(lf_inbox *inbox, lf_releaser **out_releaser)
{
    lf_releaser *releaser = lf_calloc(1, sizeof *releaser);
    lf_status status = releaser ? lf_worker_create("lf-release", run_release, run_release, NULL,
                                                   inbox, &releaser->worker)
                                : LF_E_NOMEM;
    if (status == LF_OK)
        *out_releaser = releaser;
    else
        lf_free(releaser);
    return status;
}

void lf_releaser_destroy(lf_releaser *releaser)
{
    if (releaser)
        lf_worker_destroy(releaser->worker);
    lf_free(releaser);
}
