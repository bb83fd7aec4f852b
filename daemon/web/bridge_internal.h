/* bridge_internal: what the files of bridge.h share.
 *
 * bridge.c        endpoints, the queue of calls, replies
 * bridge_list.c   orchestrations and playlists
 * bridge_show.c   what is played
 * bridge_panel.c  what panel there is
 *
 * A call that needs quiltd is a chain of functions, each of which is called with an answer. The
 * next call of the queue begins when the chain has ended. Thread: event. */
#ifndef LF_DAEMON_WEB_BRIDGE_INTERNAL_H
#define LF_DAEMON_WEB_BRIDGE_INTERNAL_H

#include "daemon/web/bridge.h"
#include "daemon/web/bridge_lists.h"
#include "daemon/web/calls.h"

/* result NULL: quiltd has refused, and why says so in words. */
typedef void (*lf_bridge_then_fn)(lf_bridge_call *call, const json_t *result, const char *why);

typedef struct lf_bridge_endpoint {
    const char *name;
    void (*run)(lf_bridge_call *call); /* NULL: it cannot be done, for this reason: */
    const char *why;
    const char *event;  /* that follows (lf_bridge_show_tell); NULL: none */
    const char *method; /* of quiltd, for endpoints that are one call */
    bool alone;         /* it needs no orchestration */
    bool at_once;       /* it needs no quiltd, and changes nothing */
    bool shows;         /* it needs a panel that is quiltd's */
} lf_bridge_endpoint;

struct lf_bridge_call {
    lf_bridge_call *next;
    lf_bridge *bridge;
    const lf_bridge_endpoint *endpoint;
    json_t *body;
    lf_bridge_done_fn done; /* NULL: nobody waits any more */
    void *context;
    bool beginning;
    json_t *reply;
    lf_bridge_then_fn then, looked; /* looked: of lf_bridge_look */
    /* what endpoints keep from answer to answer */
    lf_orchestration *orchestration;
    lf_bridge_list *list;
    int index;                   /* of an entry */
    int current;                 /* the entry on the panel, before it */
    uint64_t scenes;             /* of lf_bridge, before it */
    json_int_t turn;             /* of quiltd's slideshow, that it waits for */
    bool is_exact;               /* no other entry than `index` is waited for */
    bool shows_again;            /* what is changed is seen */
    json_t *kept, *said, *entry; /* NULL: nothing */
};

/* What is played. */
typedef struct lf_bridge_shown {
    char token[LF_BRIDGE_TOKEN + 1]; /* "": nothing of Bridge */
    char name[LF_BRIDGE_MAX_NAME + 1];
    json_t *files; /* of quiltd's entries, as it names them */
    json_t *tags;
    bool playing;
    int index;
    int told; /* index of the entry that New Item Playing has told; -1: none */
} lf_bridge_shown;

struct lf_bridge {
    lf_bridge_config config;
    lf_calls *calls;
    lf_bridge_lists *lists;
    lf_bridge_call *queue, *running;
    lf_bridge_call *waiting;   /* for what it plays to be shown; not in the queue */
    sd_event_source *patience; /* of the waiting one */
    lf_bridge_shown shown;
    char on_panel[4096]; /* file that quiltd has shown last */
    uint64_t scenes;     /* that quiltd has shown */
    json_int_t turn;     /* of its slideshow, that it has shown last */
    char reason[256];    /* why quiltd has skipped an entry last */
    bool has_panel, knows_panel;
    bool measures_panel; /* its size is asked for, for Monitor Connect */
    uint64_t requests, failures;
    struct {
        char text[320];
        int more;               /* the same, which were not logged */
        sd_event_source *quiet; /* on: they are not */
    } last_failure;
};

/* bridge.c */
/* Asks quiltd; `then` follows. params: taken. */
void lf_bridge_ask(lf_bridge_call *call, const char *method, json_t *params,
                   lf_bridge_then_fn then);
/* Counts a failure, and logs it. Of the same words within LF_BRIDGE_QUIET_S the number is logged at
 * its end. */
void lf_bridge_log_failure(lf_bridge *bridge, const char *endpoint, const char *why);
/* Both end the call. payload: taken; NULL: none. */
void lf_bridge_complete(lf_bridge_call *call, json_t *payload);
void lf_bridge_fail(lf_bridge_call *call, const char *fmt, ...) LF_PRINTF(2, 3);
/* As lf_bridge_complete, but it is still going on. */
void lf_bridge_pend(lf_bridge_call *call);
/* The next call may begin, and this one goes on. */
void lf_bridge_step_aside(lf_bridge_call *call);
/* {"name", "type", "value"}, as all values are wrapped. value: taken. */
json_t *lf_bridge_value(const char *name, const char *type, json_t *value);
json_t *lf_bridge_text(const char *name, const char *text);
json_t *lf_bridge_number_value(const char *name, json_int_t number);
/* A text of the request; "" if it is no text. */
const char *lf_bridge_param(const lf_bridge_call *call, const char *name);
/* Finds the playlist that the request names. False: the call has failed. */
bool lf_bridge_find_list(lf_bridge_call *call);

/* bridge_list.c */
void lf_bridge_run_enter(lf_bridge_call *call);
void lf_bridge_run_exit(lf_bridge_call *call);
void lf_bridge_run_instance(lf_bridge_call *call);
void lf_bridge_run_delete(lf_bridge_call *call);
void lf_bridge_run_insert(lf_bridge_call *call);
void lf_bridge_run_update(lf_bridge_call *call);
void lf_bridge_run_update_current(lf_bridge_call *call);

/* bridge_show.c */
void lf_bridge_run_play(lf_bridge_call *call);
void lf_bridge_run_transport(lf_bridge_call *call);
void lf_bridge_run_pause(lf_bridge_call *call);
void lf_bridge_run_resume(lf_bridge_call *call);
void lf_bridge_run_seek(lf_bridge_call *call);
/* Remembers what is on the panel, before quiltd is asked for something else. False: the call has
 * failed, because nothing of Bridge or no panel is there. */
bool lf_bridge_show_begin(lf_bridge_call *call);
/* quiltd's result is there: completes the call once this entry is on the panel. If quiltd skips it,
 * the call fails; if another call takes its place or it takes long, it is pending. */
void lf_bridge_show_await(lf_bridge_call *call, const json_t *result);
/* True if this is the playlist that quiltd's slideshow has. */
bool lf_bridge_is_shown(const lf_bridge_call *call);
void lf_bridge_show_forget(lf_bridge *bridge);
/* quiltd has taken the call's playlist, which is played already, with other entries. */
void lf_bridge_show_take(const lf_bridge_call *call, const json_t *result);
/* Tells an event of the current entry, or of the call's playlist. */
void lf_bridge_show_tell(lf_bridge_call *call, const char *event);
/* quiltd's notifications. */
void lf_bridge_show_note(lf_bridge *bridge, const char *method, const json_t *params);
/* The connection to quiltd broke. */
void lf_bridge_show_ended(lf_bridge *bridge);
int lf_bridge_show_patience(sd_event_source *source, uint64_t usec, void *context);

/* bridge_panel.c */
void lf_bridge_run_devices(lf_bridge_call *call);
void lf_bridge_run_window(lf_bridge_call *call);
/* Looks what panel there is, and calls `then` with it (lf_panel_info); NULL: none. The call has
 * failed if quiltd does not answer. */
void lf_bridge_look(lf_bridge_call *call, lf_bridge_then_fn then);
/* quiltd's notification `device`. */
void lf_bridge_panel_note(lf_bridge *bridge, const json_t *params);

#endif
