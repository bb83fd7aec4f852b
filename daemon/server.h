/* server: the daemon behind its socket. One struct, one event thread; files by concern:
 *
 *   server.c          putting it together, the loop, the way down
 *   server_socket.c   which socket: systemd's, or a path with its lock
 *   server_device.c   which device: opening, closing, unplugging, trying again
 *   server_panel.c    what it shows: frames, pushed at its own pace
 *   server_buttons.c  its buttons
 *   server_plug.c     what udev tells of plugging in
 *   server_check.c    a cached calibration, when the panel's own turns up
 *   server_engine.c   what comes back from the engine and the loader; waits
 *   server_signals.c  signals, timers, the watched scene file, systemd's ears
 *   server_export.c   exports: what a call's words say
 *   server_job.c      exports: threads, progress, cancelling
 *   server_state.c    --state: saving and opening it
 *   methods*.c        the table of methods
 *
 * Everything here is called on the event thread. */
#ifndef LF_DAEMON_SERVER_H
#define LF_DAEMON_SERVER_H

#include <systemd/sd-device.h>

#include "daemon/button_actions.h"
#include "daemon/client.h"
#include "daemon/engine.h"
#include "daemon/loader.h"
#include "daemon/opener.h"
#include "device/device.h"

/* Bits of lf_client_flags: what a client subscribed to. */
enum {
    LF_EVENT_FRAME = 1,
    LF_EVENT_CONVERGED = 2,
    LF_EVENT_DEVICE = 4,
    LF_EVENT_SCENE = 8,
    LF_EVENT_EXPORT = 16,
    LF_EVENT_BUTTON = 32,
};

typedef struct lf_server_config {
    const char *scene;       /* as given; NULL = none */
    const char *socket;      /* --socket; NULL = the default */
    const char *device;      /* spec */
    const char *calibration; /* file; NULL = the device's own */
    const char *state_dir;   /* NULL = none */
    const char *export_dir;  /* NULL = none */
    const char *allow[LF_MAX_ROOTS];
    int n_allow;
    bool watch;
    double run_for; /* seconds; 0 = until told */
    lf_button_actions buttons;
    lf_options options;
} lf_server_config;

typedef struct lf_server lf_server;

/* A call that is being answered by its method. */
typedef struct lf_call {
    lf_server *server;
    lf_client *client;
    const json_t *id; /* NULL: a notification */
    json_t *params;
    const char *method;
    bool answered; /* or deferred */
} lf_call;

/* A call that will be answered later. */
typedef struct lf_ticket lf_ticket;

typedef struct lf_wait {
    struct lf_wait *next;
    lf_ticket *ticket;
    int64_t generation;
    lf_level level;
} lf_wait;

/* What the panel is and what it shows. */
typedef struct lf_panel {
    lf_device *device; /* NULL while unplugged */
    char wanted[512];  /* the spec asked for, which is tried again when a device has gone … */
    char spec[512];    /* … and the one that is open, or could not be opened */
    lf_error problem;  /* why there is none */
    uint64_t number;   /* rises with every panel that is not the one before; frames carry it */
    char last[512];    /* the panel that was open last, as its spec; empty = none yet */
    lf_calibration calibration;
    sd_event_source *io, *retry;
    bool has_problem;
    bool has_calibration; /* of the device or --calibration */
    bool has_views;       /* it takes the views behind a frame too */
    bool plugged;         /* something was, since a device was last looked for */
    bool in_flight;       /* a push is under way */
    bool whole;           /* the next push must be the whole frame */
    lf_status found;      /* what lf_device_find said last, for "auto" */
    lf_level flying_level;
    int64_t flying_generation;
    double flying_passes;
    lf_device_counters before;           /* of devices closed by now */
    lf_errand *opening[LF_OPENER_LANES]; /* under way; NULL = none … */
    lf_errand *queued;                   /* … and those that wait for their lane, in the order of the calls */
    uint64_t wishes, taken;              /* so many so far; the number of the one whose device is, or was last, this panel's */
    double retry_at;                     /* lf_time_now when retry is due */
    uint64_t patience_usec;              /* before the next attempt that is not hurried */
} lf_panel;

typedef struct lf_job lf_job;

struct lf_server {
    lf_server_config config;
    sd_event *event;
    lf_inbox inbox;
    sd_event_source *inbox_io, *engine_io;
    int engine_fd;
    lf_roots roots;     /* fixed once the loader runs */
    char *export_root;  /* canonical; NULL = none */
    lf_options options; /* as changed by render.set */
    lf_engine *engine;
    lf_loader *loader;
    lf_letter *held; /* loads that came before the scene of the command line */
    lf_opener *opener;
    lf_clients *clients;
    char *socket_path; /* to unlink at the end; NULL = systemd's */
    int lock_fd;
    lf_panel panel;
    lf_buttons *buttons; /* of the panel; NULL = none */
    sd_event_source *buttons_io;
    sd_device_monitor *plugs;
    json_t *file_camera; /* the camera block as the scene's file has it */
    char *browsed;       /* where next and previous have come to; NULL = what is shown */

    lf_stage *stage; /* what is on stage, as far as this thread knows; NULL = nothing */
    int64_t generation;
    bool told_of_plugs;    /* there is an udev to tell what is plugged in */
    bool has_error;        /* the last attempt to load the scene failed … */
    lf_error error;        /* … like this */
    lf_engine_status last; /* as last seen */
    int64_t shown_generation;
    lf_level shown_level;
    double started; /* lf_time_now */
    lf_wait *waits;
    lf_job *jobs;
    int64_t n_jobs;

    bool seeking_buttons; /* they are being looked for … */
    bool seek_again;      /* … and something was plugged in meanwhile */
    bool browsing;        /* a scene that next or previous asked for is being loaded … */
    int turns;            /* … and they were pressed so often since (previous: negative) */
    bool resetting;       /* the camera is on its way back … */
    bool reset_again;     /* … and was asked for again */
    bool begun, ready_sent, stopping, leaving;
    double stopped_at; /* lf_time_now when the way down began */
    int exit_code;
    sd_event_source *stop_timer, *begin_timer, *state_timer, *run_timer, *status_timer, *watch_io, *watch_timer;
    int watch_fd, watch_id;
    char *watch_name;
    int reloads; /* reloads for systemd that have not ended */
    bool saving;
    bool checking;            /* the cached calibration is being compared with what is plugged in … */
    bool check_again;         /* … and something was plugged in meanwhile */
    int64_t saved_generation; /* what the saved state holds */
    double saved_passes;
};

/* ------------------------------------------------------------------------------------------------------- server.c -- */

/* Runs the daemon; returns the exit code. */
int lf_server_run(const lf_server_config *config);
/* The scene's first attempt begins, once: when the device's has ended, or takes long. */
void lf_server_begin(lf_server *server);
/* Begins the way down. */
void lf_server_shutdown(lf_server *server);

/* ------------------------------------------------------------------------------------------------ server_socket.c -- */

/* The listening socket and *server's socket_path and lock_fd. LF_E_BUSY: a living daemon has it. */
LF_NODISCARD lf_status lf_server_listen(lf_server *server, int *out_fd, lf_error *err);
/* Removes the socket's name. */
void lf_server_unlisten(lf_server *server);
/* $QUILTD_SOCKET, else $XDG_RUNTIME_DIR/quiltd.sock, else /run/quiltd/control.sock, for index 0, 1, 2 (those that are not set are
 * left out); false behind the last. */
bool lf_default_socket(int index, char *out, size_t size);

/* ------------------------------------------------------------------------------------------------ server_device.c -- */

/* Opens a device in the place of the one there is now, which stays on failure where it need not be closed first; where it had to be, it is
 * opened again. Else on failure there is none (LF_E_NODEV, LF_E_BUSY, LF_E_IO: tried again from time to time). ticket (taken over, may be
 * NULL) is answered when that is known, with the device; without one a wrong spec or calibration ends the daemon before it is ready.
 * LF_E_ARG: the spec is longer than 511 bytes; nothing was begun, and the ticket is still the caller's. */
LF_NODISCARD lf_status lf_server_open_device(lf_server *server, const char *spec, lf_ticket *ticket, lf_error *err);
/* Something was plugged in: a device that is missing is tried again soon; at once, where it is a panel that is there with all its
 * parts and rights. */
void lf_server_plugged(lf_server *server, bool whole);
/* Opens what is wanted anew. */
void lf_server_open_again(lf_server *server);
/* Answers with the devices there are. */
void lf_server_list_devices(lf_server *server, lf_ticket *ticket);
/* The device said that it is gone. */
void lf_server_gone(lf_server *server);
/* Looks at the panel again after usec: pushes what failed, or opens what is missing. */
void lf_server_retry(lf_server *server, uint64_t usec);
/* At the end: waits for what was pushed, at most timeout_ms, and begins to close. */
void lf_server_close_device(lf_server *server, int timeout_ms);
/* At the end: devices that wait to be opened are not opened any more. */
void lf_server_drop_errands(lf_server *server);
/* Updates, bytes and errors of all devices so far. */
lf_device_counters lf_server_device_counters(const lf_server *server);
/* The device as status, device.set and the event `device` show it. */
json_t *lf_server_device_json(const lf_server *server);

/* ------------------------------------------------------------------------------------------------- server_panel.c -- */

/* Gives the panel the newest frame, if it can take one. */
void lf_server_pump(lf_server *server);
/* Asks the device what became of the push under way. */
void lf_server_dispatch(lf_server *server);

/* ----------------------------------------------------------------------------------------------- server_buttons.c -- */

/* A button was pressed: tells subscribers, and does what --buttons says. */
void lf_server_press(lf_server *server, lf_button button);
/* The file that a button asked for was loaded, or could not be: goes on when the buttons have gone on meanwhile. */
void lf_server_browsed(lf_server *server, const char *file);
/* The camera was reset, or could not be: once more when that was asked for meanwhile. */
void lf_server_was_reset(lf_server *server);
/* Looks for the buttons of the panel that was opened. */
void lf_server_find_buttons(lf_server *server);
void lf_server_drop_buttons(lf_server *server);

/* -------------------------------------------------------------------------------------------------- server_plug.c -- */

/* Watches udev for what is plugged in. */
void lf_server_watch_plugs(lf_server *server);
void lf_server_unwatch_plugs(lf_server *server);

/* ------------------------------------------------------------------------------------------------- server_check.c -- */

/* Something was plugged in that may be where the panel's own calibration is. */
void lf_server_check_calibration(lf_server *server);

/* ------------------------------------------------------------------------------------------------ server_engine.c -- */

/* The engine has posted a frame or changed its state. */
int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context);
/* A frame is shown: answers waits, tells subscribers. */
void lf_server_shown(lf_server *server, int64_t generation, lf_level level, double passes);
/* Queues a load with the options and the panel there are now, behind the scene of the command line; ticket may be NULL. */
void lf_server_load(lf_server *server, lf_load *load, lf_ticket *ticket);
/* Queues those that came before that scene was queued; on the way down they fail. */
void lf_server_release_loads(lf_server *server);
/* The scene file again. */
void lf_server_reload(lf_server *server);
/* Answers when generation is shown at that level; takes the ticket over. */
void lf_server_wait(lf_server *server, lf_ticket *ticket, int64_t generation, lf_level level);
/* "rendering", "converged", "paused", "idle", "error". */
const char *lf_server_state_name(const lf_server *server);
const char *lf_level_name(lf_level level);
/* Sends a notification to those who subscribed to `event`; params are taken over. */
void lf_server_notify(lf_server *server, unsigned event, const char *method, json_t *params);

/* ----------------------------------------------------------------------------------------------- server_signals.c -- */

/* Installs signals, watchdog, timers. */
LF_NODISCARD lf_status lf_server_install(lf_server *server, lf_error *err);
/* Watches the file on stage, when --watch was given. */
void lf_server_watch(lf_server *server);
/* Tells systemd READY=1 (once) and what the daemon is doing. */
void lf_server_ready(lf_server *server);
void lf_server_tell_status(lf_server *server);
/* A reload that systemd was told of has ended. */
void lf_server_reloaded(lf_server *server);

/* ------------------------------------------------------------------------------------------------ server_export.c -- */

/* Begins an export; answers the call. */
void lf_server_export(lf_call *call);

/* --------------------------------------------------------------------------------------------------- server_job.c -- */

/* LF_E_ARG: there is no such job. */
LF_NODISCARD lf_status lf_server_cancel_job(lf_server *server, int64_t id, lf_error *err);
/* Starts the jobs whose wait is over. */
void lf_server_start_jobs(lf_server *server);
/* Cancels all; true when none is left. */
bool lf_server_end_jobs(lf_server *server);
json_t *lf_server_jobs_json(const lf_server *server);

/* ------------------------------------------------------------------------------------------------- server_state.c -- */

/* Saves the accumulation into --state on a thread; not when one is under way. */
void lf_server_save_state(lf_server *server);
/* The same at the end, on this thread. */
void lf_server_save_state_now(lf_server *server);
/* Opens the saved state; -1 = none. */
int lf_server_open_state(const lf_server *server);

/* ------------------------------------------------------------------------------------------------------ methods.c -- */

/* An lf_line_fn with the server as context. */
void lf_server_line(void *context, lf_client *client, const char *line, size_t n);
/* Answers. result is taken over (NULL = out of memory). */
void lf_reply(lf_call *call, json_t *result);
void lf_fail(lf_call *call, const lf_error *err, bool scene);
/* Puts the answer off; NULL (and answered) when the client has too many calls open. */
lf_ticket *lf_defer(lf_call *call);
/* The serial number of the client whose call it is. */
uint64_t lf_ticket_client(const lf_ticket *ticket);
/* Answers now; frees the ticket; nothing when it is NULL or the client has gone. */
void lf_ticket_reply(lf_server *server, lf_ticket *ticket, json_t *result);
void lf_ticket_fail(lf_server *server, lf_ticket *ticket, const lf_error *err, bool scene);

/* A path parameter of a client: must lie beneath the roots (LF_E_PATH, whether it exists or not), and exist there (LF_E_IO);
 * relative ones are relative to the folder of the scene the daemon was started with. *out_path (lf_free) is canonical.
 * LF_E_PATH, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_read_path(const lf_server *server, const char *path, char **out_path, lf_error *err);
/* A file to write: its folder must exist beneath --export-dir. A final "/" is kept. */
LF_NODISCARD lf_status lf_server_write_path(const lf_server *server, const char *path, char **out_path, lf_error *err);

#endif
