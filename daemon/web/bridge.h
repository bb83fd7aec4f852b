/* bridge: answers programs that speak to Looking Glass Bridge: playlists, which become quiltd's
 * slideshow, and the panel. It knows no HTTP.
 *
 * A request is an endpoint and a JSON object; the reply is a JSON object whose status.value is
 * "Completion", "Pending" or "Failure". Completion is only said once quiltd has done it. What
 * failed is said in words in payload.value.message.value, and in the log. So is an entry that
 * quiltd skips. (bridge.js reads all members of the payload of available_output_devices as panels:
 * there the words are in message.value of the reply.) Requests are done one after another; versions
 * and what can never be done are answered at once. Thread: event. */
#ifndef LF_DAEMON_WEB_BRIDGE_H
#define LF_DAEMON_WEB_BRIDGE_H

#include <jansson.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"
#include "daemon/web/panel_only.h"

#define LF_BRIDGE_VERSION "2.6.3"
/* Time for quiltd to load what is to be shown; then the reply is Pending. */
#define LF_BRIDGE_SHOW_S 20u
/* The same failure is logged again after this time. */
#define LF_BRIDGE_QUIET_S 10u
/* Within this time every request has its reply. */
#define LF_BRIDGE_PATIENCE_S 60u

typedef struct lf_bridge lf_bridge;
typedef struct lf_bridge_call lf_bridge_call;

/* An event for those who listen to an orchestration; token NULL: to any. event is borrowed: the
 * map of payload.value. */
typedef void (*lf_bridge_tell_fn)(void *context, const char *token, json_t *event);

typedef struct lf_bridge_config {
    sd_event *event;
    const char *socket;              /* path of quiltd's; borrowed */
    const char *version;             /* that bridge_version answers; borrowed */
    const lf_panel_only *panel_only; /* borrowed; NULL: quiltd keeps its panel */
    lf_bridge_tell_fn tell;
    void *context; /* of tell */
} lf_bridge_config;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bridge_create(const lf_bridge_config *config, lf_bridge **out,
                                        lf_error *err);
/* All calls must be gone. Accepts NULL. */
void lf_bridge_destroy(lf_bridge *bridge);

/* The reply is there. Called once, from the event loop, not from within lf_bridge_begin. */
typedef void (*lf_bridge_done_fn)(void *context);

/* Begins a request. body: taken, an object. If the reply is there already, `done` is not called.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bridge_begin(lf_bridge *bridge, const char *endpoint, json_t *body,
                                       lf_bridge_done_fn done, void *context, lf_bridge_call **out,
                                       lf_error *err);
/* The reply, which stays the call's; NULL: it is not there yet. */
const json_t *lf_bridge_reply(const lf_bridge_call *call);
/* Nobody waits for the reply any more. What was begun goes on. Accepts NULL. */
void lf_bridge_leave(lf_bridge_call *call);
/* True if there is such an endpoint. */
bool lf_bridge_knows(const char *endpoint);

/* The reply to a request that could not be read. A new reference; NULL: out of memory. */
json_t *lf_bridge_failure(lf_bridge *bridge, const char *endpoint, const char *why);
/* A message with an event for this orchestration. A new reference; NULL: out of memory. */
json_t *lf_bridge_event(const char *token, json_t *event);
/* Somebody listens to an orchestration. False: there is none with this token. */
bool lf_bridge_listen(lf_bridge *bridge, const char *token);

/* Requests since the start, and those of them that failed. */
uint64_t lf_bridge_requests(const lf_bridge *bridge);
uint64_t lf_bridge_failures(const lf_bridge *bridge);

#endif
