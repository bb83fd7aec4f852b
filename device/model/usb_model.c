/* The link to a simulated display in the same process. bulk_end moves the data in pieces, as over a
 * wire; cancel ends a wait at once. */
#include <assert.h>
#include <errno.h>
#include <pthread.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/model/usb_model.h"

enum { PIECE_BYTES = 256 * 1024 };

typedef struct model_link {
    lf_usb_link base;
    lf_model_gud *gud;
    const uint8_t *data;
    size_t n;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    bool cancelled; /* under lock */
} model_link;

static model_link *model_of(lf_usb_link *link)
{
    return (model_link *)(void *)link;
}

/* Sleeps; false: the link is or was cancelled. */
static bool sleep_ns(model_link *m, uint64_t ns)
{
    uint64_t end = lf_time_now_ns() + ns;
    bool in_time = ns > 0;
    pthread_mutex_lock(&m->lock);
    while (!m->cancelled && in_time)
        in_time = lf_cond_wait_until(&m->wake, &m->lock, end);
    bool cancelled = m->cancelled;
    pthread_mutex_unlock(&m->lock);
    return !cancelled;
}

static lf_usb_result result_of(model_link *m, int answer, int timeout_ms)
{
    switch (answer) {
    case -EPIPE:
        return LF_USB_STALL;
    case -ENODEV:
        return LF_USB_GONE;
    case -ETIMEDOUT:
    case -EAGAIN:
        return sleep_ns(m, (uint64_t)timeout_ms * LF_NS_PER_MS) ? LF_USB_TIMEOUT : LF_USB_CANCELLED;
    default:
        return answer < 0 ? LF_USB_IO : LF_USB_OK;
    }
}

static lf_usb_result model_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                   uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    model_link *m = model_of(link);
    if (out_n)
        *out_n = 0;
    if (!sleep_ns(m, 0))
        return LF_USB_CANCELLED;
    int answer = lf_model_gud_control(m->gud, in, request, value, data, n);
    if (out_n && answer > 0)
        *out_n = (size_t)answer;
    return result_of(m, answer, timeout_ms);
}

static void model_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    model_link *m = model_of(link);
    assert(n > 0 && m->n == 0);
    m->data = data;
    m->n = n;
}

/* Sends the next piece, at the display's speed. */
static lf_usb_result send_piece(model_link *m, int timeout_ms)
{
    size_t piece = m->n < PIECE_BYTES ? m->n : PIECE_BYTES;
    uint64_t limit = (uint64_t)timeout_ms * LF_NS_PER_MS,
             delay = lf_model_gud_delay_ns(m->gud, piece);
    if (!sleep_ns(m, delay < limit ? delay : limit))
        return LF_USB_CANCELLED;
    if (delay > limit)
        return LF_USB_TIMEOUT;
    int answer = lf_model_gud_bulk(m->gud, m->data, piece);
    m->data += piece;
    m->n -= piece;
    return result_of(m, answer, timeout_ms);
}

static lf_usb_result model_bulk_end(lf_usb_link *link, int timeout_ms)
{
    model_link *m = model_of(link);
    lf_usb_result result = LF_USB_OK;
    while (result == LF_USB_OK && m->n > 0)
        result = send_piece(m, timeout_ms);
    m->n = 0;
    return result;
}

static void model_cancel(lf_usb_link *link)
{
    model_link *m = model_of(link);
    pthread_mutex_lock(&m->lock);
    m->cancelled = true;
    pthread_cond_broadcast(&m->wake);
    pthread_mutex_unlock(&m->lock);
}

static void model_close(lf_usb_link *link)
{
    model_link *m = model_of(link);
    pthread_cond_destroy(&m->wake);
    pthread_mutex_destroy(&m->lock);
    lf_free(m);
}

static const lf_usb_link_ops model_ops = {
    .control = model_control,
    .bulk_begin = model_bulk_begin,
    .bulk_end = model_bulk_end,
    .cancel = model_cancel,
    .close = model_close,
};

static bool make_locks(model_link *m)
{
    bool has_lock = pthread_mutex_init(&m->lock, NULL) == 0;
    bool has_wake = has_lock && lf_cond_init(&m->wake) == LF_OK;
    if (has_lock && !has_wake)
        pthread_mutex_destroy(&m->lock);
    return has_wake;
}

lf_usb_link *lf_usb_model_open(lf_model_gud *gud)
{
    model_link *m = lf_calloc(1, sizeof *m);
    if (!m)
        return NULL;
    m->base.ops = &model_ops;
    m->gud = gud;
    if (make_locks(m))
        return &m->base;
    lf_free(m);
    return NULL;
}
