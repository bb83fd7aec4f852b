/* The inside of server.h: one struct, one event thread. What can live without it are objects of its
 * own, which do not see it and tell by events (daemon/show, daemon/parts, the engine, the loader,
 * the clients); these files ask them and say what follows from what they tell:
 *
 *   server.c          putting it together, the loop
 *   server_down.c     the way down
 *   server_device.c   the panel (daemon/show) as clients see it
 *   server_card.c     words on the panel where there is no picture
 *   server_buttons.c  what its buttons do
 *   server_engine.c   what comes back from the engine and the loader
 *   server_status.c   what the daemon is doing, in words
 *   server_signals.c  signals, timers
 *   server_parts.c    what is played, saved, watched, waited for and read (daemon/parts)
 *   server_export.c   exports (daemon/parts/jobs.h): what a call's words say, what clients hear
 *   call.c            what methods answer by, and where paths may lie
 *   methods*.c        the table of methods, and the lines that ask for them
 *
 * Everything here is called on the event thread. */
#ifndef LF_DAEMON_SERVER_INTERNAL_H
#define LF_DAEMON_SERVER_INTERNAL_H

#include "daemon/engine/engine.h"
#include "daemon/engine/loader.h"
#include "daemon/parts/jobs.h"
#include "daemon/parts/loading.h"
#include "daemon/parts/parser.h"
#include "daemon/parts/play.h"
#include "daemon/parts/presses.h"
#include "daemon/parts/releaser.h"
#include "daemon/parts/saver.h"
#include "daemon/parts/waits.h"
#include "daemon/parts/watch.h"
#include "daemon/server/server.h"
#include "daemon/show/show.h"
#include "daemon/wire/deferred.h"
#include "daemon/wire/listen.h"
#include "daemon/wire/notify.h"

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

typedef enum lf_life_phase {
    LF_PHASE_OPENING, /* the scene waits for the first device */
    LF_PHASE_RUNNING,
    LF_PHASE_STOPPING, /* what is under way comes to its end */
    LF_PHASE_LEAVING,
} lf_life_phase;

/* What the panel says while there is no picture: server_card.c. */
typedef struct lf_card {
    sd_event_source *timer;
    bool late;                /* it has been dark for long */
    char words[LF_CARD_TEXT]; /* as the engine has them */
    bool waits;               /* for a picture */
} lf_card;

/* The daemon from its start to its end: server.c. */
typedef struct lf_life {
    lf_life_phase phase;
    double started, stopped_at; /* lf_time_now; when the way down began */
    int exit_code;
    sd_event_source *begin_timer, *stop_timer;
    bool ready_sent; /* systemd was told */
    int reloads;     /* for systemd that have not ended */
    lf_card card;
    lf_load_words words; /* of the file that is shown, for when it is read again */
    lf_task *held;       /* loads that came before the scene of the command line */
    /* seconds of this thread's CPU time, of the longest turn of the event loop (turns.h) */
    double longest_turn;
} lf_life;

struct lf_server {
    lf_server_config config;
    lf_life life;
    sd_event *event;
    lf_inbox inbox;
    int engine_fd;
    lf_roots roots;       /* fixed once the loader runs */
    char *export_root;    /* canonical; NULL = none */
    lf_options options;   /* as changed by render.set */
    lf_response response; /* as changed by device.set */
    lf_engine *engine;
    lf_loader *loader;
    lf_releaser *releaser; /* NULL when it has ended */
    lf_parser *parser;
    lf_clients *clients; /* NULL until there is a socket */
    lf_listener listener;
    lf_show *show;
    lf_presses *presses;
    lf_watch *watch; /* NULL without --watch */
    lf_loading *loading;
    lf_play *play;
    lf_saver *saver;
    lf_content *content; /* what is shown, as far as this thread knows; NULL = nothing */
    int64_t generation;
    lf_error error;        /* of the last attempt to load the scene; status LF_OK = none */
    lf_engine_status last; /* as last seen */
    lf_shown shown;        /* what the panel shows */
    lf_waits *waits;
    lf_jobs *jobs;
    int64_t n_jobs; /* numbers given so far, to exports and loads */
};

/* ----------------------------------------------------------------------------- server_down.c -- */

/* Begins the way down. */
void lf_server_shutdown(lf_server *server);
/* Whether it has begun. */
bool lf_server_is_stopping(const lf_server *server);

/* Ends what is left when the loop has ended; threads that cannot be joined in time are left to the
 * kernel, and then it does not return. */
void lf_server_finish(lf_server *server);

/* --------------------------------------------------------------------------- server_device.c -- */

/* The show and what follows from its events. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_show(lf_server *server);
/* The device as status, device.set and the event `device` show it. */
json_t *lf_server_device_json(const lf_server *server);

/* ----------------------------------------------------------------------------- server_card.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_card(lf_server *server);
/* What the panel is to say may have changed. */
void lf_server_tell_card(lf_server *server);

/* -------------------------------------------------------------------------- server_buttons.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_presses(lf_server *server);
/* A button was pressed: tells subscribers, and does what --buttons says. */
void lf_server_press(lf_server *server, lf_button button);

/* --------------------------------------------------------------------------- server_engine.c -- */

/* The scene's first attempt begins, once: when the device's has ended, or takes long. */
void lf_server_begin(lf_server *server);
/* The engine has posted a frame or changed its state. */
int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context);
/* A frame is shown: answers waits, tells subscribers. */
void lf_server_shown(lf_server *server, const lf_shown *shown);
/* Queues a load with the options and the panel there are now, behind the scene of the command line;
 * deferred may be NULL. */
void lf_server_load(lf_server *server, lf_load *load, lf_deferred *deferred);
/* Queues those that came before that scene was queued; on the way down they fail. */
void lf_server_release_loads(lf_server *server);
/* The scene file again. */
void lf_server_reload(lf_server *server);
/* Another file is shown: watches that and what it includes; nothing without --watch. */
void lf_server_watch(lf_server *server);

/* --------------------------------------------------------------------------- server_status.c -- */

/* "rendering", "converged", "paused", "idle", "error". */
const char *lf_server_state_name(const lf_server *server);
/* "denoised", "unfiltered" (also a finished image), "card". */
const char *lf_server_image_name(const lf_shown *shown);
/* The same for the former field `picture`, which says "reconstructed". */
const char *lf_server_picture_name(const lf_shown *shown);
/* What is to be said of what is shown, as `status` and the answers to loads tell it. */
json_t *lf_server_warnings_json(const lf_server *server);
/* The load in progress, and the file that is read, as `status` shows them; null: none. */
json_t *lf_server_load_json(const lf_server *server);
json_t *lf_server_reading_json(lf_server *server);
/* What `scene.load` says too. */
json_t *lf_reading_json(const lf_load_reading *reading);
/* Tells systemd READY=1 (once) and what the daemon is doing. */
void lf_server_ready(lf_server *server);
void lf_server_tell_status(lf_server *server);
/* A reload that systemd was told of has ended. */
void lf_server_reloaded(lf_server *server);

/* -------------------------------------------------------------------------- server_signals.c -- */

/* Installs signals, watchdog, timers. */
LF_NODISCARD lf_status lf_server_install(lf_server *server, lf_error *err);

/* ---------------------------------------------------------------------------- server_parts.c -- */

/* The folder of --state is this daemon's alone from now on. LF_E_BUSY; LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_saver(lf_server *server, lf_error *err);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_play(lf_server *server);
/* --watch. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_watch(lf_server *server, lf_error *err);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_waits(lf_server *server);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_loading(lf_server *server);
/* A patch of the scene's frame; NULL = out of memory. */
lf_load *lf_server_frame_load(int frame);

/* --------------------------------------------------------------------------- server_export.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_jobs(lf_server *server);
/* Begins an export; answers the call. */
void lf_server_export(lf_call *call);
/* The jobs, as `status` shows them. */
json_t *lf_server_jobs_json(const lf_server *server);

/* --------------------------------------------------------------------------------- methods.c -- */

/* LF_E_NOMEM. When there are clients. */
LF_NODISCARD lf_status lf_server_make_parser(lf_server *server);
/* An lf_line_fn with the server as context. */
void lf_server_line(void *context, lf_client *client, const char *line, size_t n);

/* ------------------------------------------------------------------------------------ call.c -- */

/* Answers. result is taken over (NULL = out of memory). */
void lf_reply(lf_call *call, json_t *result);
/* The same of a result that has a member and gets another one, key, which is a JSON text already.
 */
void lf_reply_with(lf_call *call, json_t *result, const char *key, const char *text);
void lf_fail(lf_call *call, const lf_error *err, bool scene);
/* Puts the answer off; NULL (and answered) when the client has too many calls open. */
lf_deferred *lf_defer(lf_call *call);
/* Logs former names of parameters (base/former.h). LF_E_ARG: a former name stands next to the
 * current one. */
LF_NODISCARD lf_status lf_check_former(const json_t *params, const char *method, lf_error *err);
/* The value of a parameter under its current or its former name, borrowed; NULL: under neither. */
const json_t *lf_param_or_former(const json_t *params, const char *name, const char *former);
/* A path parameter of a client: must lie beneath the roots (LF_E_PATH, whether it exists or not),
 * and exist there (LF_E_IO); relative ones are relative to the folder of the scene the daemon was
 * started with. *out_path (lf_free) is canonical. LF_E_PATH, LF_E_IO, LF_E_ARG (empty), LF_E_NOMEM.
 */
LF_NODISCARD lf_status lf_server_read_path(const lf_server *server, const char *path,
                                           char **out_path, lf_error *err);
/* A file to write: its folder must exist beneath --export-dir, and is held. As lf_held_name_open.
 */
LF_NODISCARD lf_status lf_server_write_path(const lf_server *server, const char *path,
                                            lf_held_name *out, lf_error *err);

#endif
