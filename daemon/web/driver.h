/* driver: the older protocol of programs for Looking Glass panels (HoloPlay Service, and Bridge's
 * endpoint for it): WebXR pages by a WebSocket, AliceLG and others by nng's ipc (nng.h).
 *
 * A message is a header of the protocols REQ and REP of nanomsg, and a map in CBOR: {cmd: {NAME:
 * {…}}, bin: an image}. Commands: init, info, show, cache, check, delete, wipe and hide. The answer
 * is the same header, and a map {error, …}; what failed is in `message`, too, and in the log. A
 * command is done before its answer goes. Messages that come meanwhile wait, and the transport is
 * asked to read no more. Thread: event. */
#ifndef LF_DAEMON_WEB_DRIVER_H
#define LF_DAEMON_WEB_DRIVER_H

#include <jansson.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"
#include "daemon/web/panel_only.h"

/* Clients of a transport. */
#define LF_DRIVER_MAX_CLIENTS 16
/* Bytes that a message may have besides its image. */
#define LF_DRIVER_MAX_REST ((uint64_t)1 << 20)

/* What `error` says. */
typedef enum lf_driver_error {
    LF_DRIVER_NONE = 0,
    LF_DRIVER_BAD_CBOR = 1,
    LF_DRIVER_BAD_COMMAND = 2,
    LF_DRIVER_NO_IMAGE = 3,
    LF_DRIVER_NO_PANEL = 4,
    LF_DRIVER_NOT_CACHED = 5,
    LF_DRIVER_NOT_ALLOWED = 7,
    LF_DRIVER_FAILED = 8,
} lf_driver_error;

typedef struct lf_driver lf_driver;               /* what all clients share */
typedef struct lf_driver_client lf_driver_client; /* one that talks */

typedef struct lf_driver_config {
    sd_event *event;
    const char *socket;        /* path of quiltd's */
    const char *version;       /* that init and info say */
    uint64_t image_limit;      /* bytes of one image (bin.h) */
    lf_panel_only *panel_only; /* borrowed; NULL: quiltd keeps its panel */
} lf_driver_config;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_driver_create(const lf_driver_config *config, lf_driver **out,
                                        lf_error *err);
/* After its clients. Accepts NULL. */
void lf_driver_destroy(lf_driver *driver);
/* Commands that were answered since the start, and those of them that failed. */
uint64_t lf_driver_commands(const lf_driver *driver);
uint64_t lf_driver_failures(const lf_driver *driver);
/* Bytes of all images that are received, shown or kept. */
uint64_t lf_driver_bytes(const lf_driver *driver);
/* The longest message that is worth reading; of longer ones the end would be skipped. */
uint64_t lf_driver_longest(const lf_driver *driver);

/* Called from the event loop alone; they may not destroy the client. */
typedef struct lf_driver_events {
    /* An answer. */
    void (*reply)(void *context, const uint8_t *data, size_t n);
    /* Nothing waits any more: the next messages may be read. */
    void (*ready)(void *context);
    void *context;
} lf_driver_events;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_driver_join(lf_driver *driver, const lf_driver_events *events,
                                      lf_driver_client **out);
/* A command that runs is given up. Accepts NULL. */
void lf_driver_leave(lf_driver_client *client);

/* Takes the next data[n] of a message. LF_E_BUSY: too much has come since the client was busy;
 * LF_E_NOMEM. After a failure the client has to be dropped. */
LF_NODISCARD lf_status lf_driver_take(lf_driver_client *client, const uint8_t *data, size_t n);
/* The message has ended. An answer follows, unless its header is wrong. Errors as above. */
LF_NODISCARD lf_status lf_driver_end(lf_driver_client *client);
/* A command runs; `ready` follows. */
bool lf_driver_is_busy(const lf_driver_client *client);

#endif
