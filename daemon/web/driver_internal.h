/* driver_internal: what the files of the driver share.
 *
 * driver.c           clients: messages in, answers out
 * driver_commands.c  the table of commands
 * driver_cache.c     images that programs have named
 *
 * A command answers at once, or asks quiltd. It is called again, as `go_on`, when quiltd's answer
 * is there. Thread: event. */
#ifndef LF_DAEMON_WEB_DRIVER_INTERNAL_H
#define LF_DAEMON_WEB_DRIVER_INTERNAL_H

#include "daemon/web/bin.h"
#include "daemon/web/cbor.h"
#include "daemon/web/driver.h"
#include "daemon/web/fetch.h"

#define LF_DRIVER_MAX_HOPS 8 /* 4 bytes each, in the header of a message */
#define LF_DRIVER_MAX_LATER ((size_t)65536)
#define LF_DRIVER_MAX_CACHED 16 /* images */
#define LF_DRIVER_MAX_NAME 128

typedef struct lf_command lf_command;
typedef struct lf_cached lf_cached;

struct lf_driver {
    sd_event *event;
    char *socket, *version;
    lf_panel_only *panel_only;
    lf_bins bins;
    lf_cached *cached; /* the newest */
    uint64_t n_commands, n_failures;
};

struct lf_driver_client {
    lf_driver *driver;
    lf_driver_events events;
    sd_event_source *turn; /* on: a command begins, or quiltd has answered */
    /* The message that comes, and then the command that is made of it. */
    uint8_t ids[4 * LF_DRIVER_MAX_HOPS];
    size_t n_ids;     /* bytes of ids */
    bool has_request; /* the last id is the request's */
    bool malformed;   /* the header is wrong: no answer can find its way */
    lf_cbor *cbor;    /* NULL: nothing of the message came */
    lf_bin *bin;      /* NULL: no byte of it came */
    bool busy;
    json_t *message;
    const lf_command *command; /* NULL: it is not known yet */
    const json_t *params;      /* of the command, in the message */
    lf_fetch *fetch;           /* NULL: none */
    json_t *calibration;       /* of `info` */
    json_t *quilt;             /* of `show`, until quiltd gets it: the parameters … */
    int quilt_fd;              /* … and the image; -1: none */
    bool is_taken;             /* quiltd has the quilt */
    struct {
        uint8_t *data; /* [n] of [size] parts of messages that came while it was busy */
        size_t n, size;
    } later;
};

struct lf_command {
    const char *name;
    /* Each calls lf_driver_answer, lf_driver_fail or lf_driver_ask. */
    void (*begin)(lf_driver_client *client);
    void (*go_on)(lf_driver_client *client); /* NULL: it asks nothing */
    bool shows;                              /* not with --panel-only */
};

/* driver.c */
/* Ends the command. answer: taken; {error: 0} and version are added. NULL: out of memory. */
void lf_driver_answer(lf_driver_client *client, json_t *answer);
/* Ends the command with an error, in the log, too. more: taken, further keys; NULL: none. */
void lf_driver_fail(lf_driver_client *client, lf_driver_error error, const char *why, json_t *more);
/* Calls quiltd, and `go_on` follows; or the command fails. params: taken. fd: kept; -1: none. */
void lf_driver_ask(lf_driver_client *client, const char *method, json_t *params, int fd,
                   unsigned patience_s);
/* In `go_on`: quiltd's answer, which is the next lf_driver_ask's to forget. Errors of
 * lf_fetch_result. */
LF_NODISCARD lf_status lf_driver_result(lf_driver_client *client, const json_t **out_result,
                                        int *out_code, lf_error *err);

/* driver_commands.c */
/* Finds the command of a message; NULL: it has none that is known, or several. */
const lf_command *lf_command_find(const json_t *message, const json_t **out_params);

/* driver_cache.c */
/* Keeps an image, which is taken on LF_OK, with its settings under a name, instead of what had the
 * name. If there are too many, the oldest goes. LF_E_ARG: a name is too long or empty;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_cache_put(lf_driver *driver, const char *name, lf_bin *bin,
                                    const json_t *settings, lf_error *err);
/* Finds an image; false: there is none. It and its settings stay the cache's. */
bool lf_cache_find(const lf_driver *driver, const char *name, const lf_bin **out_bin,
                   const json_t **out_settings);
/* Forgets an image; false: there is none. */
bool lf_cache_drop(lf_driver *driver, const char *name);
/* Forgets the oldest image; false: there is none. */
bool lf_cache_make_room(void *driver);

#endif
