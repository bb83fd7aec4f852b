#include "daemon/web/patience.h"

#include <sys/socket.h>
#include <time.h>

#include "base/alloc.h"

struct lf_patience {
    int fd;
    sd_event_source *timer;
    uint64_t period_usec;
    size_t moved;            /* in this period */
    uint64_t all, past_usec; /* since the pace began: bytes; ended periods */
    bool paced, over;
};

static void arm(lf_patience *patience)
{
    patience->moved = 0;
    sd_event_source_set_time_relative(patience->timer, patience->period_usec);
    sd_event_source_set_enabled(patience->timer, SD_EVENT_ONESHOT);
}

void lf_patience_end(lf_patience *patience)
{
    if (!patience)
        return;
    patience->over = true;
    shutdown(patience->fd, SHUT_RDWR);
}

bool lf_patience_is_over(const lf_patience *patience)
{
    return patience && patience->over;
}

/* At the end of a period. */
static bool has_pace(lf_patience *patience)
{
    const uint64_t free_usec = (uint64_t)LF_PATIENCE_FREE_S * 1000000;
    patience->all += patience->moved;
    patience->past_usec += patience->period_usec;
    const uint64_t counted = patience->past_usec > free_usec ? patience->past_usec - free_usec : 0;
    return patience->moved >= LF_PATIENCE_BYTES &&
           patience->all >= counted / 1000000 * LF_PATIENCE_RATE;
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_patience *patience = context;
    if (patience->paced && has_pace(patience))
        arm(patience);
    else
        lf_patience_end(patience);
    return 0;
}

lf_status lf_patience_create(sd_event *event, int fd, uint64_t usec, lf_patience **out)
{
    lf_patience *patience = lf_calloc(1, sizeof *patience);
    if (!patience)
        return LF_E_NOMEM;
    *patience = (lf_patience){.fd = fd, .period_usec = usec};
    if (sd_event_add_time_relative(event, &patience->timer, CLOCK_MONOTONIC, usec, 0, on_time,
                                   patience) < 0) {
        lf_free(patience);
        return LF_E_NOMEM;
    }
    *out = patience;
    return LF_OK;
}

void lf_patience_destroy(lf_patience *patience)
{
    if (!patience)
        return;
    sd_event_source_disable_unref(patience->timer);
    lf_free(patience);
}

void lf_patience_wait(lf_patience *patience, uint64_t usec)
{
    if (!patience)
        return;
    patience->paced = false;
    patience->period_usec = usec;
    arm(patience);
}

void lf_patience_pace(lf_patience *patience, uint64_t usec)
{
    if (!patience)
        return;
    patience->paced = true;
    patience->all = patience->past_usec = 0;
    patience->period_usec = usec;
    arm(patience);
}

void lf_patience_note(lf_patience *patience, size_t n)
{
    if (patience)
        patience->moved += n;
}

void lf_patience_stop(lf_patience *patience)
{
    if (patience)
        sd_event_source_set_enabled(patience->timer, SD_EVENT_OFF);
}
