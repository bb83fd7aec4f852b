/* web_internal: what the files of the HTTP server share.
 *
 * web.c       sockets, libmicrohttpd's turns, the life of a request
 * routes.c    the table of paths, and requests without a body
 * puts.c      PUT: uploads, and quilts for quiltd
 * sends.c     downloads, and streams of images
 * seats.c     WebSockets: handshakes, and who sits behind them
 * sessions.c  WebSockets of the page
 * webxr.c     WebSockets of WebXR pages
 * bridge_http.c, bridge_events.c  services of programs that speak to Bridge
 *
 * libmicrohttpd calls a request several times: once its headers are there (`check` may refuse it
 * before a byte of the body is read), for each part of the body, when the body is there (`act`),
 * and after the request was suspended (`finish`). Thread: event. */
#ifndef LF_DAEMON_WEB_WEB_INTERNAL_H
#define LF_DAEMON_WEB_WEB_INTERNAL_H

#include <jansson.h>
#include <microhttpd.h>

#include "daemon/web/bridge.h"
#include "daemon/web/counts.h"
#include "daemon/web/downloads.h"
#include "daemon/web/fetch.h"
#include "daemon/web/guard.h"
#include "daemon/web/listen.h"
#include "daemon/web/patience.h"
#include "daemon/web/peer.h"
#include "daemon/web/stream.h"
#include "daemon/web/uploads.h"
#include "daemon/web/web.h"

#define LF_WEB_MAX_STREAMS 4
#define LF_BRIDGE_BODY ((size_t)32768) /* of a request of Bridge */
/* A request has so long, except where pace or patience of its own are set. */
#define LF_WEB_DEADLINE_USEC ((uint64_t)10000000)
/* A client of a download has so long for LF_PATIENCE_BYTES. Of a stream it has so long for what
 * waits, and quiltd for the next image. */
#define LF_WEB_SLOW_S 60u

typedef struct lf_seat lf_seat;
typedef struct lf_request lf_request;

/* Calls of quiltd that do not get into the way of each other: each lane has places of its own. */
typedef enum lf_web_lane {
    LF_LANE_SHORT,      /* status, metrics, one image */
    LF_LANE_THUMBNAILS, /* these wait for a place */
    LF_LANE_QUILTS,     /* quiltd may need a minute */
    LF_WEB_LANES,
} lf_web_lane;

/* The sockets of a service. */
typedef struct lf_entrance {
    int port; /* 0: closed */
    lf_guard guard;
    lf_web_sockets sockets;
    sd_event_source *accept[LF_WEB_MAX_LISTENERS];
    int n_seats, n_connections;
} lf_entrance;

struct lf_web {
    sd_event *event;
    char *socket;
    uint64_t upload_limit;
    lf_entrance services[LF_SERVICES];
    lf_origins allowed;
    lf_strangers strangers;
    lf_driver *driver;               /* NULL: none */
    const lf_panel_only *panel_only; /* NULL: off */
    char url[LF_WEB_URL_SIZE];
    struct MHD_Daemon *http;
    sd_event_source *io, *timer; /* timer: libmicrohttpd wants to run */
    lf_seat *seats;
    lf_peer *peers; /* the newest */
    lf_request *requests;
    int n_fetches[LF_WEB_LANES], n_streams;
    lf_uploads *uploads;
    lf_downloads *downloads;
    char *bridge_version;
    lf_bridge *bridge; /* NULL: its services are closed */
    lf_web_counts counts;
    bool ending; /* nobody is let in any more */
};

/* Who may ask. */
typedef enum lf_route_needs {
    LF_NEEDS_NOTHING,
    LF_NEEDS_TOKEN,
    LF_NEEDS_TOKEN_OR_COOKIE,
    LF_NEEDS_TO_WRITE, /* lf_guard_may_write */
} lf_route_needs;

typedef struct lf_route {
    const char *path, *method;
    /* Each answers the request, or leaves it as it is (check), or suspends it (act). NULL: nothing
     * to do. */
    enum MHD_Result (*check)(lf_request *r);
    enum MHD_Result (*act)(lf_request *r);
    enum MHD_Result (*finish)(lf_request *r);
    /* Takes a part of the body. NULL: there is none. */
    enum MHD_Result (*take)(lf_request *r, const char *body, size_t n);
    uint64_t body_limit; /* bytes; 0: that of uploads */
    lf_service service;
    lf_route_needs needs;
    lf_web_lane lane;
    bool is_start; /* path is the start of longer ones, which are meant */
} lf_route;

/* A request that passed the guard. */
struct lf_request {
    lf_request *next;
    lf_web *web;
    struct MHD_Connection *connection;
    lf_service service;
    const char *path;
    const lf_route *route; /* NULL: it is answered */
    bool acted;
    bool secure;      /* it came through the public server */
    json_t *query;    /* NULL: none was read */
    lf_fetch *fetch;  /* NULL: none was asked for */
    lf_web_lane lane; /* of the fetch */
    bool fetching;    /* it takes a place in its lane */
    bool waiting;     /* for a place; the connection is suspended */
    int fd;           /* that goes with the fetch; -1: none */
    lf_status status; /* of fetch or stream, with its error */
    lf_error error;
    lf_stream *stream; /* NULL: none */
    lf_upload *upload; /* the body; NULL: none */
    char *body;        /* a short one; NULL: none */
    size_t body_used;
    lf_bridge_call *bridge_call; /* NULL: none */
};

/* web.c */
/* libmicrohttpd has something to do. */
void lf_web_wake(lf_web *web);
/* Continues a suspended request. */
void lf_request_resume(lf_request *r);
lf_patience *lf_request_patience(struct MHD_Connection *connection);
/* An answer after which the request needs nothing any more, and its body, if one comes, is lost. */
enum MHD_Result lf_request_refuse(lf_request *r, unsigned status, const char *why);
/* The same with {"error": {"code", "message"}}. */
enum MHD_Result lf_request_refuse_json(lf_request *r, unsigned status, int code,
                                       const lf_error *err);

/* routes.c */
/* The route of a path and a method at a service. NULL: *out_status is 404 or 405. */
const lf_route *lf_route_find(lf_service service, const char *path, const char *method,
                              unsigned *out_status);
/* Asks quiltd and suspends the request; `finish` follows, at once if nobody listens. Refuses it
 * with 503 if its lane is full. params: taken. r->fd goes with the call. */
enum MHD_Result lf_route_fetch(lf_request *r, const char *method, json_t *params,
                               unsigned patience_s);
/* The request needs its place no more. */
void lf_route_leave_lane(lf_request *r);
/* The answer, in `finish`; on failure also r->status and r->error. *out_code: of quiltd's error. */
LF_NODISCARD lf_status lf_route_result(lf_request *r, const json_t **out_result, int *out_code);
/* Answers such a failure: 422 if quiltd has refused, otherwise 503, as JSON. */
enum MHD_Result lf_route_fetch_failed(lf_request *r, int code);

/* puts.c */
enum MHD_Result lf_put_check_upload(lf_request *r);
enum MHD_Result lf_put_upload(lf_request *r);
enum MHD_Result lf_put_check_quilt(lf_request *r);
enum MHD_Result lf_put_quilt(lf_request *r);
enum MHD_Result lf_put_quilt_shown(lf_request *r);
/* A part of the body. */
enum MHD_Result lf_put_take(lf_request *r, const char *body, size_t n);

/* sends.c */
enum MHD_Result lf_send_download(lf_request *r);
enum MHD_Result lf_send_stream(lf_request *r);
enum MHD_Result lf_send_stream_begun(lf_request *r);

/* seats.c */
/* Who sits behind the WebSockets of a path. */
typedef struct lf_seat_kind lf_seat_kind;
struct lf_seat_kind {
    const char *protocol; /* Sec-WebSocket-Protocol that a client must offer; NULL: any or none */
    /* Makes a guest of a socket (lf_ws_create). It calls lf_seat_leave, which ends it, once it uses
     * the socket no more. */
    lf_status (*create)(lf_seat *seat, int fd, const void *early, size_t n, void **out_guest,
                        lf_error *err);
    void (*destroy)(void *guest);
};

/* A guest, and the socket that libmicrohttpd lends it. */
struct lf_seat {
    lf_seat *next;
    lf_web *web;
    lf_service service;
    const lf_seat_kind *kind;
    void *guest;
    struct MHD_UpgradeResponseHandle *handle;
};

/* Answers a handshake, and seats a guest of this kind after it. */
enum MHD_Result lf_seats_answer(lf_request *r, const lf_seat_kind *kind);
/* The guest has ended. Not from within an event of the WebSocket. */
void lf_seat_leave(lf_seat *gone);
void lf_seats_leave(lf_web *web);
/* WebSockets of all services. */
int lf_seats_count(const lf_web *web);

/* bridge_http.c, bridge_events.c */
enum MHD_Result lf_bridge_put(lf_request *r);
enum MHD_Result lf_bridge_put_take(lf_request *r, const char *body, size_t n);
enum MHD_Result lf_bridge_put_done(lf_request *r);
enum MHD_Result lf_bridge_events_answer(lf_request *r);
/* lf_bridge_tell_fn; context: the web. */
void lf_bridge_events_tell(void *context, const char *token, json_t *event);

/* sessions.c */
enum MHD_Result lf_sessions_answer(lf_request *r);

/* webxr.c */
enum MHD_Result lf_webxr_driver(lf_request *r);
/* GET /: a WebSocket that tells the calibration, or that somebody is there. */
enum MHD_Result lf_webxr_root(lf_request *r);

#endif
