#include "daemon/threads/worker.h"

#include "base/alloc.h"
#include "base/thread.h"

struct lf_worker {
    pthread_t thread;
    bool has_wake, has_idle, started;
    lf_task_fn run, drop;
    void *context;
    lf_inbox *inbox;
    pthread_mutex_t lock;
    pthread_cond_t wake, idle;
    /* under lock */
    lf_task *first, **last;
    int pending;
    bool stop;
};

static lf_task *take(lf_worker *worker)
{
    lf_task *task = worker->first;
    if (task) {
        worker->first = task->next;
        if (!worker->first)
            worker->last = &worker->first;
    }
    return task;
}

static lf_task *next_task(lf_worker *worker)
{
    pthread_mutex_lock(&worker->lock);
    while (!worker->first && !worker->stop)
        pthread_cond_wait(&worker->wake, &worker->lock);
    lf_task *task = worker->stop ? NULL : take(worker);
    pthread_mutex_unlock(&worker->lock);
    return task;
}

static void post_back(lf_worker *worker, lf_task *task)
{
    pthread_mutex_lock(&worker->lock);
    worker->pending--;
    pthread_cond_broadcast(&worker->idle);
    pthread_mutex_unlock(&worker->lock);
    lf_inbox_post(worker->inbox, task);
}

static void *worker_main(void *context)
{
    lf_worker *worker = context;
    for (lf_task *task = next_task(worker); task; task = next_task(worker)) {
        task->next = NULL;
        worker->run(worker->context, task);
        for (lf_task *next; task; task = next) {
            next = task->next; /* the inbox uses `next` itself */
            post_back(worker, task);
        }
    }
    return NULL;
}

lf_task *lf_worker_take(lf_worker *worker, bool (*suits)(const lf_task *task, const lf_task *next),
                        const lf_task *task)
{
    pthread_mutex_lock(&worker->lock);
    bool good = worker->first && !worker->stop && suits(task, worker->first);
    lf_task *next = good ? take(worker) : NULL;
    pthread_mutex_unlock(&worker->lock);
    if (next)
        next->next = NULL;
    return next;
}

/* Removes the tasks that suit from the queue and returns them. */
static lf_task *take_all(lf_worker *worker, bool (*suits)(const lf_task *task))
{
    lf_task *taken = NULL, **last = &taken, **at = &worker->first;
    pthread_mutex_lock(&worker->lock);
    while (*at) {
        if (suits(*at)) {
            *last = *at;
            last = &(*at)->next;
            *at = (*at)->next;
        } else {
            at = &(*at)->next;
        }
    }
    *last = NULL;
    worker->last = at;
    pthread_mutex_unlock(&worker->lock);
    return taken;
}

void lf_worker_drop(lf_worker *worker, bool (*suits)(const lf_task *task))
{
    for (lf_task *task = take_all(worker, suits), *next; task; task = next) {
        next = task->next;
        worker->drop(worker->context, task);
        post_back(worker, task);
    }
}

lf_status lf_worker_create(const char *name, lf_task_fn run, lf_task_fn drop, void *context,
                           lf_inbox *inbox, lf_worker **out_worker)
{
    lf_worker *worker = lf_calloc(1, sizeof *worker);
    if (!worker)
        return LF_E_NOMEM;
    *worker = (lf_worker){.run = run, .drop = drop, .context = context, .inbox = inbox};
    worker->last = &worker->first;
    pthread_mutex_init(&worker->lock, NULL);
    worker->has_wake = lf_cond_init(&worker->wake) == LF_OK;
    worker->has_idle = lf_cond_init(&worker->idle) == LF_OK;
    worker->started = worker->has_wake && worker->has_idle &&
                      lf_thread_start(name, worker_main, worker, &worker->thread) == LF_OK;
    if (!worker->started) {
        lf_worker_destroy(worker);
        return LF_E_NOMEM;
    }
    *out_worker = worker;
    return LF_OK;
}

void lf_worker_destroy(lf_worker *worker)
{
    if (!worker)
        return;
    if (worker->started) {
        pthread_mutex_lock(&worker->lock);
        worker->stop = true;
        pthread_cond_signal(&worker->wake);
        pthread_mutex_unlock(&worker->lock);
        pthread_join(worker->thread, NULL);
    }
    for (lf_task *task = take(worker); task; task = take(worker)) {
        worker->drop(worker->context, task);
        post_back(worker, task);
    }
    if (worker->has_idle)
        pthread_cond_destroy(&worker->idle);
    if (worker->has_wake)
        pthread_cond_destroy(&worker->wake);
    pthread_mutex_destroy(&worker->lock);
    lf_free(worker);
}

void lf_worker_queue(lf_worker *worker, lf_task *task)
{
    task->next = NULL;
    pthread_mutex_lock(&worker->lock);
    *worker->last = task;
    worker->last = &task->next;
    worker->pending++;
    pthread_cond_signal(&worker->wake);
    pthread_mutex_unlock(&worker->lock);
}

int lf_worker_pending(lf_worker *worker)
{
    pthread_mutex_lock(&worker->lock);
    int pending = worker->pending;
    pthread_mutex_unlock(&worker->lock);
    return pending;
}

bool lf_worker_drain(lf_worker *worker, double end)
{
    bool in_time = true;
    pthread_mutex_lock(&worker->lock);
    while (worker->pending > 0 && in_time)
        in_time = lf_cond_wait_until(&worker->idle, &worker->lock, (uint64_t)(end * 1e9));
    bool done = worker->pending == 0;
    pthread_mutex_unlock(&worker->lock);
    return done;
}
