/* reply: answers of HTTP, all with the headers that keep other pages out. At a service of programs,
 * a page of an allowed origin may read them (lf_peer). Thread: event. */
#ifndef LF_DAEMON_WEB_REPLY_H
#define LF_DAEMON_WEB_REPLY_H

#include <jansson.h>
#include <microhttpd.h>

#include "daemon/web/guard.h"
#include "daemon/web/pages.h"

/* Collects the headers that lf_guard_check looks at. */
void lf_reply_read(struct MHD_Connection *connection, const char *target, lf_guard_request *out);

/* Sends a response, which is taken, with the headers of all answers. response NULL: out of memory,
 * the connection ends. type NULL: no Content-Type. */
enum MHD_Result lf_reply_send(struct MHD_Connection *connection, unsigned status,
                              struct MHD_Response *response, const char *type);
/* Each answers a connection. text: copied. */
enum MHD_Result lf_reply_text(struct MHD_Connection *connection, unsigned status, const char *text);
enum MHD_Result lf_reply_page(struct MHD_Connection *connection, const lf_page *page);
/* json: borrowed. NULL: out of memory, the connection ends. */
enum MHD_Result lf_reply_json(struct MHD_Connection *connection, unsigned status,
                              const json_t *json);
/* Prometheus text format. text: copied. */
enum MHD_Result lf_reply_metrics(struct MHD_Connection *connection, const char *text);
/* A JPEG of size bytes; fd is closed by libmicrohttpd. */
enum MHD_Result lf_reply_jpeg(struct MHD_Connection *connection, int fd, size_t size);
/* 204 with the cookie of the session; secure: for https alone. */
enum MHD_Result lf_reply_cookie(struct MHD_Connection *connection, const lf_guard *guard,
                                bool secure);
/* 101 for a handshake with this Sec-WebSocket-Key, and the protocol that was chosen (NULL: none);
 * then `upgraded` gets the socket. */
enum MHD_Result lf_reply_upgrade(struct MHD_Connection *connection, const char *key,
                                 const char *protocol, MHD_UpgradeHandler upgraded, void *context);
/* 204 to OPTIONS at a service of programs: what pages of an allowed origin may ask there. */
enum MHD_Result lf_reply_options(struct MHD_Connection *connection);

#endif
