/* The inside of server.h: one struct, one event thread. What can live without it are objects of its
 * own, which do not see it and tell by events (daemon/show, daemon/parts, the engine, the loader,
 * the clients); these files ask them and say what follows from what they tell:
 *
 *   server.c          putting it together, the loop, the way down
 *   server_socket.c   which socket: systemd's, or a path with its lock
 *   server_device.c   the panel (daemon/show) as clients see it
 *   server_card.c     words on the panel where there is no picture
 *   server_buttons.c  what its buttons do
 *   server_engine.c   what comes back from the engine and the loader; waits
 *   server_loading.c  loads: how far the reading of files is, cancelling
 *   server_signals.c  signals, timers, systemd's ears
 *   server_parts.c    what is played, saved and watched (daemon/parts)
 *   server_export.c   exports (daemon/parts/jobs.h): what a call's words say, what clients hear
 *   server_work.c     what takes too long for this thread: long lines parsed, large things freed
 *   methods*.c        the table of methods
 *
 * Everything here is called on the event thread. */
#ifndef LF_DAEMON_SERVER_INTERNAL_H
#define LF_DAEMON_SERVER_INTERNAL_H

#include "daemon/engine/engine.h"
#include "daemon/engine/loader.h"
#include "daemon/parts/jobs.h"
#include "daemon/parts/play.h"
#include "daemon/parts/saver.h"
#include "daemon/parts/watch.h"
#include "daemon/server/server.h"
#include "daemon/show/show.h"
#include "daemon/wire/client.h"

/* Bits of lf_client_flags: what a client subscribed to. */
enum {
    LF_EVENT_FRAME = 1,
    LF_EVENT_CONVERGED = 2,
    LF_EVENT_DEVICE = 4,
    LF_EVENT_SCENE = 8,
    LF_EVENT_EXPORT = 16,
    LF_EVENT_BUTTON = 32,
};

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
typedef struct lf_deferred lf_deferred;

typedef struct lf_wait {
    struct lf_wait *next;
    lf_deferred *deferred;
    int64_t generation;
    lf_level level;
    double seconds;         /* at most */
    sd_event_source *timer; /* NULL: for ever */
    bool over;              /* to be answered, as soon as there is time */
    lf_server *server;
} lf_wait;

/* Those that wait for a frame, the newest first: server_engine.c. */
typedef struct lf_waits {
    lf_wait *first;
    sd_event_source *more; /* on while some may be over that a turn did not come to */
} lf_waits;

typedef struct lf_button_work lf_button_work; /* server_buttons.c's */
typedef struct lf_loading lf_loading;         /* server_loading.c's */
typedef struct lf_work lf_work;               /* server_work.c's */

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
    lf_work *work;
    lf_clients *clients;
    char *socket_path;     /* to unlink at the end; NULL = systemd's */
    int lock_fd;           /* locked: the socket's */
    lf_show *show;
    lf_button_work *button_work;
    lf_watch *watch; /* NULL without --watch */
    lf_loading *loading;
    lf_play *play;
    lf_saver *saver;
    lf_content *content; /* what is shown, as far as this thread knows; NULL = nothing */
    int64_t generation;
    lf_error error;        /* of the last attempt to load the scene; status LF_OK = none */
    lf_engine_status last; /* as last seen */
    lf_shown shown;        /* what the panel shows */
    lf_waits waits;
    lf_jobs *jobs;
    int64_t n_jobs; /* numbers given so far, to exports and loads */
};

/* ---------------------------------------------------------------------------------- server.c -- */

/* The scene's first attempt begins, once: when the device's has ended, or takes long. */
void lf_server_begin(lf_server *server);
/* Begins the way down. */
void lf_server_shutdown(lf_server *server);
/* Whether it has begun. */
bool lf_server_is_stopping(const lf_server *server);

/* --------------------------------------------------------------------------- server_socket.c -- */

/* The listening socket and *server's socket_path and lock_fd. LF_E_BUSY: a living daemon has it. */
LF_NODISCARD lf_status lf_server_listen(lf_server *server, int *out_fd, lf_error *err);
/* Removes the socket's name. */
void lf_server_unlisten(lf_server *server);

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

/* ----------------------------------------------------------------------------- server_work.c -- */

/* Lines from here on are parsed on a thread: a mebibyte of JSON takes tens of milliseconds. */
#define LF_LONG_LINE ((size_t)16384)
/* What such lines were parsed into is given back to the system: it is twenty times as large. */
#define LF_HUGE_LINE ((size_t)262144)

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_work(lf_server *server);
/* Ends the threads; what is released from then on is freed at once. Accepts what was not made. */
void lf_server_end_work(lf_server *server);
/* Frees a thing (NULL: nothing) on a thread, which takes its time. */
void lf_server_release(lf_server *server, void (*destroy)(void *thing), void *thing);
void lf_server_release_content(lf_server *server, lf_content *content);
/* A value that may be large; its memory is given back to the system. */
void lf_server_release_json(lf_server *server, json_t *value);
/* Parses a client's line on a thread and then does what it asks for; until then the client's next
 * lines wait. false: out of memory. */
LF_NODISCARD bool lf_server_parse_later(lf_server *server, lf_client *client, const char *text,
                                        size_t n);

/* -------------------------------------------------------------------------- server_loading.c -- */

/* LF_E_NOMEM. To be dropped when the loader is gone. */
LF_NODISCARD lf_status lf_server_make_loading(lf_server *server);
/* Accepts what was not made. */
void lf_server_drop_loading(lf_server *server);
/* A load is about to be queued: it gets a number, and clients hear how far it is until none is
 * left. */
void lf_server_loads(lf_server *server, lf_load *load);
/* It has come back; accepts one that was never queued. */
void lf_server_load_ended(lf_server *server, lf_load *load);
/* The file of the first load that waits or is under way; NULL: none is, or it is not known yet. */
const char *lf_server_loading_file(const lf_server *server);
/* The load in progress, as `status` shows it; null: none. */
json_t *lf_server_load_json(lf_server *server);
/* A client has left: where those that have left keep much waiting, their loads that have not begun
 * end. */
void lf_server_end_loads_of_gone(lf_server *server);
/* Ends the load of that number; false: there is none. */
bool lf_server_cancel_load(lf_server *server, int64_t id);
/* The file that is being read, as `status` and the notification `scene.load` show it; null: none.
 */
json_t *lf_server_reading_json(lf_server *server);

/* -------------------------------------------------------------------------- server_buttons.c -- */

LF_NODISCARD lf_status lf_server_make_button_work(lf_server *server);
void lf_server_drop_button_work(lf_server *server);
/* A button was pressed: tells subscribers, and does what --buttons says. */
void lf_server_press(lf_server *server, lf_button button);
/* The file that a button asked for was loaded, or could not be: goes on when the buttons have gone
 * on meanwhile. */
void lf_server_browsed(lf_server *server, const char *file);
/* A file is shown, as it is: what patches change later can be taken back. browsed: a button
 * asked for it. */
void lf_server_file_shown(lf_server *server, bool browsed);
/* The camera was reset, or could not be: once more when that was asked for meanwhile. */
void lf_server_was_reset(lf_server *server);

/* --------------------------------------------------------------------------- server_engine.c -- */

/* The engine has posted a frame or changed its state. */
int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context);
/* A frame is shown: answers waits, tells subscribers. */
void lf_server_shown(lf_server *server, const lf_shown *shown);
/* What is in the panel's files has changed: answers waits; with an error (may be NULL) those that
 * wait for no more than files. */
void lf_server_kept(lf_server *server, const lf_error *err);
/* Queues a load with the options and the panel there are now, behind the scene of the command line;
 * deferred may be NULL. */
void lf_server_load(lf_server *server, lf_load *load, lf_deferred *deferred);
/* Queues those that came before that scene was queued; on the way down they fail. */
void lf_server_release_loads(lf_server *server);
/* What is to be said of what is shown, as `status` and the answers to loads tell it. */
json_t *lf_server_warnings_json(const lf_server *server);
/* The scene file again. */
void lf_server_reload(lf_server *server);
/* Answers when generation is shown at that level, and in the files of a panel that has some, or
 * when seconds (0 = for ever) have passed; at once with what is wrong when there is no picture
 * because the scene was refused. Takes the call over. */
void lf_server_wait(lf_server *server, lf_deferred *deferred, int64_t generation, lf_level level,
                    double seconds);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_waits(lf_server *server);
/* Ends all waits with an error. */
void lf_server_fail_waits(lf_server *server, const lf_error *err, bool scene);
/* "rendering", "converged", "paused", "idle", "error". */
const char *lf_server_state_name(const lf_server *server);
/* "reconstructed", "unfiltered" (also a finished picture), "card". */
const char *lf_server_picture_name(const lf_shown *shown);
/* Sends a notification to those who subscribed to `event`; params are taken over. */
void lf_server_notify(lf_server *server, unsigned event, const char *method, json_t *params);

/* -------------------------------------------------------------------------- server_signals.c -- */

/* Installs signals, watchdog, timers. */
LF_NODISCARD lf_status lf_server_install(lf_server *server, lf_error *err);
/* Tells systemd READY=1 (once) and what the daemon is doing. */
void lf_server_ready(lf_server *server);
void lf_server_tell_status(lf_server *server);
/* A reload that systemd was told of has ended. */
void lf_server_reloaded(lf_server *server);

/* ---------------------------------------------------------------------------- server_parts.c -- */

/* The folder of --state is this daemon's alone from now on. LF_E_BUSY; LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_saver(lf_server *server, lf_error *err);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_play(lf_server *server);
/* --watch. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_watch(lf_server *server, lf_error *err);
/* Another file is shown: watches that and what it includes; nothing without --watch. */
void lf_server_watch(lf_server *server);
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

/* Does what a request of a client asks for, which is borrowed. */
void lf_server_request(lf_server *server, lf_client *client, const lf_rpc_request *request);
/* An lf_line_fn with the server as context. */
void lf_server_line(void *context, lf_client *client, const char *line, size_t n);
/* Answers. result is taken over (NULL = out of memory). */
void lf_reply(lf_call *call, json_t *result);
/* The same of a result that has a member and gets another one, key, which is a JSON text already.
 */
void lf_reply_with(lf_call *call, json_t *result, const char *key, const char *text);
void lf_fail(lf_call *call, const lf_error *err, bool scene);
/* Puts the answer off; NULL (and answered) when the client has too many calls open. */
lf_deferred *lf_defer(lf_call *call);
/* The serial number of the client whose call it is. */
uint64_t lf_deferred_client(const lf_deferred *deferred);
/* Bytes of the line that it came in. */
size_t lf_deferred_bytes(const lf_deferred *deferred);
/* Answers now; frees the call; nothing when it is NULL or the client has gone. */
void lf_deferred_reply(lf_server *server, lf_deferred *deferred, json_t *result);
void lf_deferred_fail(lf_server *server, lf_deferred *deferred, const lf_error *err, bool scene);

/* What the call says by reconstruct, or by denoise, its other name; NULL: by neither. LF_E_ARG: by
 * both. */
LF_NODISCARD lf_status lf_denoise_word(const json_t *params, const char *where,
                                       const char **out_word, lf_error *err);
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
