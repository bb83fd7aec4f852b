#include "daemon/parts/waits.h"

#include <limits.h>

#include "base/alloc.h"

/* Most waits per client. */
#define MAX_WAITS 64
/* Most waits, including clients that have left, before those are searched for. */
#define MANY_WAITS 4096
/* Waits answered per turn. */
#define WAITS_A_TURN 64

typedef struct entry {
    struct entry *next;
    lf_waits *waits;
    lf_wait wait;
    sd_event_source *timer; /* NULL: no timeout */
    bool over;              /* to be answered at the next turn */
} entry;

struct lf_waits {
    sd_event *event;
    lf_waits_events events;
    void *context;
    entry *first;          /* the newest */
    sd_event_source *more; /* on while a turn has left some unchecked */
};

static lf_wait_state state_of(const entry *e)
{
    return e->waits->events.state(e->waits->context, &e->wait);
}

static void forget(entry *e)
{
    sd_event_source_disable_unref(e->timer);
    lf_free(e);
}

/* ---------------------------------------------------------------------------------- answered -- */

static void answer(entry *e)
{
    e->waits->events.answered(e->waits->context, &e->wait);
    forget(e);
}

static void fail(entry *e, const lf_error *err, bool scene)
{
    e->waits->events.ended(e->waits->context, &e->wait, err, scene);
    forget(e);
}

/* Also ends waits of clients that have left. Thousands may be over at once: they are answered in
 * several turns. */
void lf_waits_look(lf_waits *waits)
{
    int answered = 0;
    bool rest = false, unwritten = false;
    for (entry **at = &waits->first; *at;) {
        entry *e = *at;
        lf_wait_state state = e->over ? LF_WAIT_OVER : state_of(e);
        e->over = state == LF_WAIT_OVER || waits->events.is_vain(waits->context, &e->wait);
        if (!e->over || answered == WAITS_A_TURN) {
            rest = rest || e->over;
            unwritten = unwritten || (!e->over && state == LF_WAIT_SHOWN);
            at = &e->next;
            continue;
        }
        *at = e->next;
        answer(e);
        answered++;
    }
    if (rest)
        (void)sd_event_source_set_enabled(waits->more, SD_EVENT_ONESHOT);
    if (unwritten)
        waits->events.unwritten(waits->context);
}

void lf_waits_fail_files(lf_waits *waits, const lf_error *err)
{
    for (entry **at = &waits->first; *at;) {
        entry *e = *at;
        if (e->over || state_of(e) != LF_WAIT_SHOWN) {
            at = &e->next;
            continue;
        }
        *at = e->next;
        fail(e, err, false);
    }
}

/* Fails at most `most` waits; true: none is left. */
static bool fail_some(lf_waits *waits, const lf_error *err, bool scene, int most)
{
    for (int n = 0; waits->first && n < most; n++) {
        entry *e = waits->first;
        waits->first = e->next;
        fail(e, err, scene);
    }
    return !waits->first;
}

void lf_waits_fail(lf_waits *waits, const lf_error *err, bool scene)
{
    if (waits)
        (void)fail_some(waits, err, scene, INT_MAX);
}

void lf_waits_look_at_failure(lf_waits *waits)
{
    const lf_error *err = waits->events.failed(waits->context);
    if (err && !fail_some(waits, err, true, WAITS_A_TURN))
        (void)sd_event_source_set_enabled(waits->more, SD_EVENT_ONESHOT);
}

static int on_more(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_waits_look(context);
    lf_waits_look_at_failure(context);
    return 0;
}

static int on_late(sd_event_source *source, uint64_t usec, void *context)
{
    entry *e = context;
    entry **at = &e->waits->first;
    (void)source;
    (void)usec;
    while (*at != e)
        at = &(*at)->next;
    *at = e->next;
    if (e->over) { /* reached in time, but not answered yet */
        answer(e);
    } else {
        e->waits->events.late(e->waits->context, &e->wait);
        forget(e);
    }
    return 0;
}

/* ------------------------------------------------------------------------------------ adding -- */

lf_status lf_waits_add(lf_waits *waits, const lf_wait *wait, lf_error *err)
{
    int n = 0, all = 0;
    for (const entry *other = waits->first; other; other = other->next, all++)
        n += other->wait.client == wait->client ? 1 : 0;
    if (n >= MAX_WAITS)
        return lf_error_set(err, LF_E_BUSY, "wait",
                            "this client has %d waits already; end one first", n);
    entry *e = lf_calloc(1, sizeof *e);
    if (!e)
        return lf_error_set(err, LF_E_NOMEM, "wait", "out of memory");
    *e = (entry){.next = waits->first, .waits = waits, .wait = *wait};
    if (wait->seconds > 0 &&
        sd_event_add_time_relative(waits->event, &e->timer, CLOCK_MONOTONIC,
                                   (uint64_t)(wait->seconds * 1e6), 1000, on_late, e) < 0) {
        lf_free(e);
        return lf_error_set(err, LF_E_NOMEM, "wait", "out of memory");
    }
    waits->first = e;
    /* there are so many that some clients must have left */
    if (all >= MANY_WAITS || state_of(e) != LF_WAIT_ON)
        lf_waits_look(waits);
    lf_waits_look_at_failure(waits);
    return LF_OK;
}

lf_status lf_waits_create(sd_event *event, const lf_waits_events *events, void *context,
                          lf_waits **out_waits)
{
    lf_waits *waits = lf_calloc(1, sizeof *waits);
    if (!waits)
        return LF_E_NOMEM;
    *waits = (lf_waits){.event = event, .events = *events, .context = context};
    /* a timer with time 0 is due at once, but after all earlier events */
    if (sd_event_add_time(event, &waits->more, CLOCK_MONOTONIC, 0, 1, on_more, waits) < 0 ||
        sd_event_source_set_enabled(waits->more, SD_EVENT_OFF) < 0) {
        lf_waits_destroy(waits);
        return LF_E_NOMEM;
    }
    *out_waits = waits;
    return LF_OK;
}

void lf_waits_destroy(lf_waits *waits)
{
    if (waits)
        sd_event_source_disable_unref(waits->more);
    lf_free(waits);
}
