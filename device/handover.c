#include "device/handover.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "device/device_table.h"

enum { STOP_WAIT_MS = 1000 };

static lf_handover *handover_of(lf_device *device)
{
    return (lf_handover *)(void *)device;
}

/* Locking does not violate the const. */
static lf_handover *unconst(const void *handover)
{
    return (lf_handover *)(uintptr_t)handover;
}

/* ----------------------------------------------------------------------------- begin and end -- */

lf_status lf_handover_init(lf_handover *h, int width, int height, lf_error *err)
{
    *h = (lf_handover){
        .base = h->base, .made = true, .wake_fd = lf_wakeup_make(), .tell_fd = lf_wakeup_make()};
    h->has_lock = pthread_mutex_init(&h->lock, NULL) == 0;
    h->has_ended = lf_cond_init(&h->ended) == LF_OK;
    h->rects = lf_calloc(LF_DEVICE_MAX_RECTS, sizeof *h->rects);
    if (!h->has_lock || !h->has_ended || h->wake_fd < 0 || h->tell_fd < 0 || !h->rects ||
        lf_image8_init(&h->picture, width, height, 3) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "device", "out of memory or descriptors");
    /* touches its pages now; otherwise this would take most of the first push */
    memset(h->picture.data, 0, (size_t)height * h->picture.stride);
    return LF_OK;
}

lf_status lf_handover_start(lf_handover *h, void *(*main)(void *), void *context, const char *name,
                            lf_error *err)
{
    h->has_thread = lf_thread_start(name, main, context, &h->thread) == LF_OK;
    return h->has_thread ? LF_OK : lf_error_set(err, LF_E_NOMEM, "device", "cannot start a thread");
}

void lf_handover_ask_stop(lf_handover *h)
{
    lf_status status = lf_handover_flush(&h->base, STOP_WAIT_MS);
    (void)status; /* a push that has not ended is dropped */
    pthread_mutex_lock(&h->lock);
    h->stop = true;
    pthread_mutex_unlock(&h->lock);
    lf_wakeup_signal(h->wake_fd);
}

void lf_handover_stop(lf_handover *h)
{
    if (!h->has_thread)
        return;
    lf_handover_ask_stop(h);
    pthread_join(h->thread, NULL);
    h->has_thread = false;
}

void lf_handover_finish(lf_handover *h)
{
    if (h->has_lock)
        pthread_mutex_destroy(&h->lock);
    if (h->has_ended)
        pthread_cond_destroy(&h->ended);
    if (h->made && h->wake_fd >= 0)
        close(h->wake_fd);
    if (h->made && h->tell_fd >= 0)
        close(h->tell_fd);
    lf_image8_finish(&h->picture);
    lf_free(h->rects);
    *h = (lf_handover){.base = h->base};
}

/* -------------------------------------------------------------------------- the event thread -- */

static void copy_rect(lf_image8 *to, const lf_image8 *from, const lf_rect *r)
{
    for (int y = r->y; y < r->y + r->height; y++)
        memcpy(to->data + (size_t)y * to->stride + (size_t)r->x * 3,
               from->data + (size_t)y * from->stride + (size_t)r->x * 3, (size_t)r->width * 3);
}

lf_status lf_handover_push(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                           uint64_t generation)
{
    lf_handover *h = handover_of(device);
    (void)generation;
    pthread_mutex_lock(&h->lock);
    lf_status status = h->gone ? LF_E_NODEV : h->busy || h->retry ? LF_E_STATE : LF_OK;
    pthread_mutex_unlock(&h->lock);
    if (status != LF_OK)
        return status;
    if (!lf_device_push_fits(h->picture.width, h->picture.height, frame, rects, n))
        return LF_E_ARG;
    for (int i = 0; i < n; i++)
        copy_rect(&h->picture, frame, &rects[i]);
    if (n > 0)
        memcpy(h->rects, rects, (size_t)n * sizeof *rects);
    h->n_rects = n;
    pthread_mutex_lock(&h->lock);
    h->busy = h->pushed = true;
    pthread_mutex_unlock(&h->lock);
    lf_wakeup_signal(h->wake_fd);
    return LF_OK;
}

int lf_handover_poll_fd(const lf_device *device)
{
    return unconst(device)->tell_fd;
}

lf_device_event lf_handover_dispatch(lf_device *device)
{
    lf_handover *h = handover_of(device);
    lf_wakeup_clear(h->tell_fd);
    pthread_mutex_lock(&h->lock);
    lf_device_event event = LF_DEVICE_READY;
    if (h->gone)
        event = LF_DEVICE_GONE;
    else if (h->busy)
        event = LF_DEVICE_BUSY;
    else if (h->retry)
        event = LF_DEVICE_RETRY;
    h->retry = false;
    pthread_mutex_unlock(&h->lock);
    return event;
}

lf_status lf_handover_flush(lf_device *device, int timeout_ms)
{
    lf_handover *h = handover_of(device);
    uint64_t end = lf_time_now_ns() + (uint64_t)(timeout_ms > 0 ? timeout_ms : 0) * LF_NS_PER_MS;
    bool in_time = true;
    pthread_mutex_lock(&h->lock);
    while (h->busy && !h->gone && in_time)
        in_time = lf_cond_wait_until(&h->ended, &h->lock, end);
    lf_status status = h->gone ? LF_E_NODEV : h->busy ? LF_E_TIMEOUT : LF_OK;
    pthread_mutex_unlock(&h->lock);
    return status;
}

void lf_handover_counters(const lf_device *device, lf_device_counters *out)
{
    lf_handover *h = unconst(device);
    pthread_mutex_lock(&h->lock);
    *out = h->counters;
    pthread_mutex_unlock(&h->lock);
}

void lf_handover_problem(const lf_handover *h, char out[256])
{
    pthread_mutex_lock(&unconst(h)->lock);
    memcpy(out, h->problem, sizeof h->problem);
    pthread_mutex_unlock(&unconst(h)->lock);
}

/* ------------------------------------------------------------------------- the device thread -- */

lf_handover_word lf_handover_take(lf_handover *h)
{
    lf_wakeup_clear(h->wake_fd);
    pthread_mutex_lock(&h->lock);
    lf_handover_word word = h->stop     ? LF_HANDOVER_STOP
                            : h->pushed ? LF_HANDOVER_PUSH
                                        : LF_HANDOVER_NOTHING;
    h->pushed = false;
    pthread_mutex_unlock(&h->lock);
    return word;
}

void lf_handover_end(lf_handover *h, bool shown, uint64_t bytes)
{
    pthread_mutex_lock(&h->lock);
    h->busy = false;
    h->retry = !shown;
    if (shown) {
        h->counters.updates += (uint64_t)h->n_rects;
        h->counters.bytes += bytes;
    } else {
        h->counters.errors++;
    }
    pthread_cond_broadcast(&h->ended);
    pthread_mutex_unlock(&h->lock);
    lf_wakeup_signal(h->tell_fd);
}

bool lf_handover_lost(lf_handover *h)
{
    pthread_mutex_lock(&h->lock);
    bool told = !h->busy;
    if (told) {
        h->retry = true;
        h->counters.errors++;
    }
    pthread_mutex_unlock(&h->lock);
    if (told)
        lf_wakeup_signal(h->tell_fd);
    return told;
}

void lf_handover_gone(lf_handover *h)
{
    pthread_mutex_lock(&h->lock);
    h->gone = true;
    h->busy = false;
    pthread_cond_broadcast(&h->ended);
    pthread_mutex_unlock(&h->lock);
    lf_wakeup_signal(h->tell_fd);
}

void lf_handover_problem_set(lf_handover *h, const char *text)
{
    pthread_mutex_lock(&h->lock);
    lf_device_text(h->problem, sizeof h->problem, text);
    pthread_mutex_unlock(&h->lock);
}
