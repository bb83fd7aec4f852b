/* Internals of server.h: one struct, one event thread. Parts that do not need the struct are
 * objects of their own (daemon/show, daemon/parts, the engine, the loader, the clients). They do
 * not know the server and report through events. These files query them and react to their events:
 *
 *   server.c          construction, the loop.
 *   server_down.c     shutdown.
 *   server_device.c   the panel (daemon/show) as clients see it.
 *   server_loan.c     a panel that is lent to a client's programs.
 *   server_card.c     text on the panel if there is no picture.
 *   server_buttons.c  actions of its buttons.
 *   server_doctor.c   what panels and system lack (daemon/parts/doctor.h).
 *   server_engine.c   results of the engine and the loader.
 *   server_status.c   the daemon's state in words.
 *   server_log.c      the last lines of the log, and new ones as notifications.
 *   server_signals.c  signals, timers.
 *   server_parts.c    playback, saving, watching, waits, loading, quiltweb (daemon/parts).
 *   server_export.c   exports (daemon/parts/jobs.h): parameters and notifications.
 *   server_farm.c     exports that a farm renders (daemon/parts/farmed.h): the same.
 *   server_preview.c  frame.get (daemon/parts/previews.h).
 *   server_playlist.c the slideshow (daemon/parts/play_list.h): its methods, loads, notification.
 *   server_library.c  library.list, library.thumbnail (daemon/parts/library.h).
 *   call.c            answers of methods, paths of clients.
 *   methods*.c        the table of methods, and parsing their lines.
 *
 * Everything here is called on the event thread. */
#ifndef LF_DAEMON_SERVER_INTERNAL_H
#define LF_DAEMON_SERVER_INTERNAL_H

#include "daemon/engine/engine.h"
#include "daemon/engine/loader.h"
#include "daemon/parts/farmed.h"
#include "daemon/parts/jobs.h"
#include "daemon/parts/library.h"
#include "daemon/parts/loading.h"
#include "daemon/parts/parser.h"
#include "daemon/parts/play.h"
#include "daemon/parts/play_list.h"
#include "daemon/parts/presses.h"
#include "daemon/parts/previews.h"
#include "daemon/parts/releaser.h"
#include "daemon/parts/saver.h"
#include "daemon/parts/waits.h"
#include "daemon/parts/watch.h"
#include "daemon/parts/web_child.h"
#include "daemon/server/server.h"
#include "daemon/show/show.h"
#include "daemon/threads/errands.h"
#include "daemon/wire/deferred.h"
#include "daemon/wire/listen.h"
#include "daemon/wire/notify.h"

typedef struct lf_server lf_server;
typedef struct lf_examination lf_examination; /* server_doctor.c */

/* A call being answered by its method. */
typedef struct lf_call {
    lf_server *server;
    lf_client *client;
    const json_t *id; /* NULL: a notification */
    json_t *params;
    const char *method; /* static */
    bool answered;      /* or deferred */
} lf_call;

typedef enum lf_life_phase {
    LF_PHASE_OPENING, /* the scene waits for the first device */
    LF_PHASE_RUNNING,
    LF_PHASE_STOPPING, /* work in progress is coming to its end */
    LF_PHASE_LEAVING,
} lf_life_phase;

/* The card on the panel while there is no picture: server_card.c. */
typedef struct lf_card {
    sd_event_source *timer;
    bool late;                /* there has been no picture for long */
    char words[LF_CARD_TEXT]; /* as passed to the engine */
    bool waits;               /* waiting for a picture */
} lf_card;

/* The log's lines on their way to subscribers: server_log.c. */
typedef struct lf_log_watch {
    int fd;       /* wakes the event thread when a line was logged; -1: none */
    int64_t sent; /* number of the last line that was sent */
} lf_log_watch;

/* The folder that the slideshow's entries are from. */
typedef struct lf_played_folder {
    char *path; /* canonical, owned; NULL: none */
    bool more;  /* it has more files than the slideshow has entries */
} lf_played_folder;

/* Images and files for clients: server_preview.c, server_library.c, server_playlist.c,
 * server_farm.c. */
typedef struct lf_gallery {
    lf_farmed *farmed;
    lf_previews *previews;
    lf_library *library;
    lf_playlist *playlist;
    lf_played_folder folder;
    lf_errands *checks; /* entries of playlist.set */
    int64_t listed;     /* number of the playlist's last load */
    bool holds;         /* the video that is shown is paused with the playlist */
    unsigned warned;    /* its warnings that are in the log, by their bits */
    /* the video's rounds when it was last looked at, and its generation */
    int64_t rounds, round_of;
    int64_t warned_of; /* generation of the video that `warned` is about */
    int64_t failed;    /* generation of the last video that failed */
} lf_gallery;

/* The panel that a client's programs use: server_loan.c. */
typedef struct lf_loan {
    uint64_t client;        /* serial number; 0: it has left */
    char *spec;             /* to be opened again; NULL: none is lent */
    sd_event_source *again; /* on: it is opened soon */
    bool failed;            /* it could not be opened, which the log says */
} lf_loan;

/* The daemon from its start to its end: server.c. */
typedef struct lf_life {
    lf_life_phase phase;
    double started, stopped_at; /* lf_time_now; at the start, at the start of shutdown */
    int exit_code;
    sd_event_source *begin_timer, *stop_timer;
    bool ready_sent; /* systemd was notified */
    int reloads;     /* reloads by systemd that have not ended */
    lf_card card;
    lf_loan loan;
    lf_log_watch log;
    lf_web_child *web;           /* NULL without --web */
    lf_examination *examination; /* for doctor, in progress; NULL: none */
    lf_load_words words;         /* parameters of the shown file, for reading it again */
    lf_task *held;               /* loads that arrived before the scene of the command line */
    /* CPU seconds of the longest turn of the event loop (turns.h) */
    double longest_turn;
    double told_of_frame; /* lf_time_now of the last notification of a frame */
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
    lf_releaser *releaser; /* NULL after its end */
    lf_parser *parser;
    lf_clients *clients; /* NULL until there is a socket */
    lf_listener listener;
    lf_show *show;
    lf_presses *presses;
    lf_watch *watch; /* NULL without --watch */
    lf_loading *loading;
    lf_play *play;
    lf_saver *saver;
    lf_content *content; /* the content shown, as known to this thread; NULL = none */
    int64_t generation;
    lf_error error;        /* error of the last attempt to load the scene; status LF_OK = none */
    lf_engine_status last; /* as last seen */
    lf_shown shown;        /* the frame on the panel */
    lf_waits *waits;
    lf_jobs *jobs;
    lf_gallery gallery;
    int64_t n_jobs; /* numbers used so far for exports and loads */
};

/* ----------------------------------------------------------------------------- server_down.c -- */

/* Begins the shutdown. */
void lf_server_shutdown(lf_server *server);
/* True once it has begun. */
bool lf_server_is_stopping(const lf_server *server);

/* Ends everything else after the loop. If threads cannot be joined in time they are left to the
 * kernel, and the function does not return. */
void lf_server_finish(lf_server *server);

/* --------------------------------------------------------------------------- server_device.c -- */

/* Creates the show and handles its events. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_show(lf_server *server);
/* The device as `status`, `device.set` and the event `device` report it. */
json_t *lf_server_device_json(const lf_server *server);

/* ----------------------------------------------------------------------------- server_loan.c -- */

/* device.set closes the panel for this client's programs. LF_E_BUSY: another client has it;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_loan_begin(lf_server *server, uint64_t client, lf_error *err);
/* The client has left: the panel is opened again, unless another device was chosen meanwhile. If it
 * cannot be opened, that is tried again every 5 s. */
void lf_server_loan_end_of(lf_server *server, uint64_t client);
/* Says in `problem` of the open device that the panel is lent, if it is. */
void lf_server_loan_tell(const lf_server *server, lf_device_info *info);
/* An event of the show: lf_show_open with &server->life.loan as its answer has ended. */
void lf_server_loan_opened(lf_server *server, const lf_error *err);
/* The panel does not come back: another device was chosen, or the daemon ends. */
void lf_server_loan_forget(lf_server *server);

/* ----------------------------------------------------------------------------- server_card.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_card(lf_server *server);
/* Updates the card, whose text may have changed. */
void lf_server_tell_card(lf_server *server);

/* --------------------------------------------------------------------------- server_doctor.c -- */

/* Examines panels and system; the call is answered when all is known. */
void lf_server_doctor(lf_call *call);
/* Drops the call of a client that has left. */
void lf_server_doctor_end_of(lf_server *server, uint64_t client);
/* An event of the show: the examination has ended. */
void lf_server_examined(void *context, void *ended, const lf_error *err);

/* -------------------------------------------------------------------------- server_buttons.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_presses(lf_server *server);
/* A button was pressed: notifies subscribers and runs its action (--buttons). */
void lf_server_press(lf_server *server, lf_button button);

/* --------------------------------------------------------------------------- server_engine.c -- */

/* Starts loading the scene, once: when the device was opened or failed, or takes long. */
void lf_server_begin(lf_server *server);
/* The engine has posted a frame or changed state. */
int lf_server_on_engine(sd_event_source *source, int fd, uint32_t events, void *context);
/* A frame is shown: answers waits, notifies subscribers. */
void lf_server_shown(lf_server *server, const lf_shown *shown);
/* Queues a load with the current options and panel, after the scene of the command line, and
 * numbers it (job.id); deferred may be NULL. */
void lf_server_load(lf_server *server, lf_load *load, lf_deferred *deferred);
/* Cancels the load with this number, also while it waits for the panel. */
void lf_server_cancel_load(lf_server *server, int64_t id);
/* Queues the loads that arrived before that scene was queued; during shutdown they fail. */
void lf_server_release_loads(lf_server *server);
/* Loads the scene file again, unless an entry of the playlist is about to take its place. */
void lf_server_reload(lf_server *server);
/* Another file is shown: watches it and the files it includes. Does nothing without --watch. */
void lf_server_watch(lf_server *server);

/* --------------------------------------------------------------------------- server_status.c -- */

/* "rendering", "converged", "paused", "idle", "error". */
const char *lf_server_state_name(const lf_server *server);
/* "denoised", "unfiltered" (also a finished image), "card". */
const char *lf_server_image_name(const lf_shown *shown);
/* The same for the former field `picture`, which says "reconstructed". */
const char *lf_server_picture_name(const lf_shown *shown);
/* The warnings about the shown content, as `status` and the answers to loads contain them. */
json_t *lf_server_warnings_json(const lf_server *server);
/* The load in progress, and the file being read, as in `status`; null: none. */
json_t *lf_server_load_json(const lf_server *server);
json_t *lf_server_reading_json(lf_server *server);
/* The same object in answers of `scene.load`. */
json_t *lf_reading_json(const lf_load_reading *reading);
/* ready: sends systemd READY=1, once, and the status. tell_status: sends the status. */
void lf_server_ready(lf_server *server);
void lf_server_tell_status(lf_server *server);
/* A reload that systemd was notified of has ended. */
void lf_server_reloaded(lf_server *server);

/* -------------------------------------------------------------------------- server_signals.c -- */

/* Installs signals, watchdog, timers. */
LF_NODISCARD lf_status lf_server_install(lf_server *server, lf_error *err);

/* ---------------------------------------------------------------------------- server_parts.c -- */

/* Locks the folder of --state for this daemon. LF_E_BUSY, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_saver(lf_server *server, lf_error *err);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_play(lf_server *server);
/* --watch. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_watch(lf_server *server, lf_error *err);
/* --web: starts quiltweb. If that fails, the log has the reason, and quiltd goes on without it. */
void lf_server_start_web(lf_server *server);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_waits(lf_server *server);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_loading(lf_server *server);
/* A load that patches the scene's frame; NULL = out of memory. */
lf_load *lf_server_frame_load(int frame);

/* --------------------------------------------------------------------------- server_export.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_jobs(lf_server *server);
/* Starts an export; answers the call. */
void lf_server_export(lf_call *call);
/* The jobs, as in `status`; those of farms are the last. */
json_t *lf_server_jobs_json(const lf_server *server);

/* ----------------------------------------------------------------------------- server_farm.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_farmed(lf_server *server);
/* Follows the farm's jobs of an earlier run again. To be called before the loop. */
void lf_server_take_up_farmed(lf_server *server);
/* Checks the parameters of an export that are about farms: whether they fit each other, and whether
 * the farm is allowed. LF_E_ARG, LF_E_STATE. */
LF_NODISCARD lf_status lf_server_farm_check(const lf_server *server, const json_t *params,
                                            lf_error *err);
/* Starts an export on a farm; answers the call. what stays the caller's. */
void lf_server_farm(lf_call *call, const lf_export *what);
/* Appends the farm's jobs, as in `status`. */
void lf_server_farm_json(const lf_server *server, json_t *list);
/* The farms that may be used (--farm). */
json_t *lf_server_farms_json(const lf_server *server);
/* Sends a notification `export` to subscribers and to the client that asked, who gets it without
 * subscribing. Takes params. */
void lf_server_tell_export(lf_server *server, uint64_t asker, json_t *params);

/* -------------------------------------------------------------------------- server_preview.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_previews(lf_server *server);
/* Starts writing the shown image; the call is answered when it is written. */
void lf_server_preview(lf_call *call);

/* ------------------------------------------------------------------------- server_playlist.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_playlist(lf_server *server);
/* The methods. */
void lf_server_playlist_get(lf_call *call);
void lf_server_playlist_play(lf_call *call);
void lf_server_playlist_stop(lf_call *call);
void lf_server_playlist_pause(lf_call *call);
void lf_server_playlist_change(lf_call *call);
void lf_server_playlist_next(lf_call *call);
void lf_server_playlist_previous(lf_call *call);
/* The playlist as in `status`; null: no entries. */
json_t *lf_server_playlist_json(const lf_server *server);

/* -------------------------------------------------------------------------- server_entries.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_entries(lf_server *server);
/* playlist.set; answered when the paths of its entries have been checked, or the folder is
 * listed. */
void lf_server_playlist_set(lf_call *call);
/* Lists the folder of --playlist, and plays it. */
void lf_server_begin_playlist(lf_server *server);
/* Lists the folder of a slideshow that plays again; lf_server_reloaded follows. False: it plays no
 * folder. */
bool lf_server_reread_playlist(lf_server *server);
/* The playlist as in answers and notifications; one entry of it. NULL: out of memory. */
json_t *lf_server_whole_playlist_json(const lf_server *server);
json_t *lf_server_entry_json(const lf_playlist_entry *entry);
/* Takes seconds, if given, and the keys of an entry from a JSON object; *entry gets a reference to
 * keys. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_take_entry(const json_t *from, lf_playlist_entry *entry,
                                            lf_error *err);
/* The parameters of the load of an entry. LF_E_ARG: a key is wrong, with its pointer. */
LF_NODISCARD lf_status lf_server_entry_words(const lf_server *server,
                                             const lf_playlist_entry *entry, lf_load_words *words,
                                             lf_error *err);

/* ---------------------------------------------------------------------------- server_movie.c -- */

/* Checks keys of a call or an entry that say how a finished picture stands, and are in words, by
 * the name of its file. Tiles of 1x1 of a picture with depth are forgotten. LF_E_ARG: a key has no
 * effect on this file, and where is said with it. */
lf_status lf_server_check_standing(const json_t *keys, const char *file, lf_load_words *words,
                                   const char *where, lf_error *err);

/* The warnings about the video that is shown, from 0 on, as lf_server_warnings_json has them;
 * false: there is none of this number now, but one with a greater number may be. */
enum { LF_MOVIE_WARNINGS = 2, LF_MOVIE_WARNING = PATH_MAX + 200 };
bool lf_server_movie_warning(const lf_server *server, int index, char out[LF_MOVIE_WARNING]);
/* Logs each of them once for a video. */
void lf_server_warn_of_movie(lf_server *server);

/* Whether rendering is paused; of a video: whether it holds its frame. */
bool lf_server_is_paused(const lf_server *server);

/* Pauses rendering, or lets it go on. A video that is shown holds its frame instead, with the
 * slideshow that it is an entry of; what is shown after it starts unpaused. */
void lf_server_pause(lf_server *server, bool paused);

/* Pauses the video of an entry with the playlist, and tells it whether to loop. Another content
 * starts unpaused. */
void lf_server_hold_movie(lf_server *server);
/* The load of an entry has ended. */
void lf_server_entry_loaded(lf_server *server, const lf_load *load);
/* The video that is shown may have ended. */
void lf_server_look_at_movie(lf_server *server);

/* -------------------------------------------------------------------------- server_library.c -- */

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_library(lf_server *server);
/* Start listing a folder, or making a thumbnail; the call is answered at the end. */
void lf_server_library_list(lf_call *call);
void lf_server_thumbnail(lf_call *call);

/* ------------------------------------------------------------------------------ server_log.c -- */

/* Watches the log for subscribers. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_log(lf_server *server);
/* The log is not watched any more. */
void lf_server_end_log(lf_server *server);
/* log.tail; answers the call. */
void lf_server_log_tail(lf_call *call);

/* --------------------------------------------------------------------------------- methods.c -- */

/* To be called once clients exists. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_make_parser(lf_server *server);
/* An lf_line_fn with the server as context. */
void lf_server_line(void *context, lf_client *client, const char *line, size_t n);

/* ------------------------------------------------------------------------------------ call.c -- */

/* Answers. Takes ownership of result (NULL = out of memory). */
void lf_reply(lf_call *call, json_t *result);
/* Answers with a non-empty result and one more member, key, whose value is already JSON text. */
void lf_reply_with(lf_call *call, json_t *result, const char *key, const char *text);
void lf_fail(lf_call *call, const lf_error *err, bool scene);
/* Writes "METHOD: WHERE: WHAT" into buf, with the method once; returns buf. */
#define LF_CALL_WORDS (sizeof(lf_error) + 128)
char *lf_call_words(const char *method, const lf_error *err, char *buf, size_t size);
/* Defers the answer. NULL, and already answered: the client has too many open calls. */
lf_deferred *lf_defer(lf_call *call);
/* Logs former names of parameters (base/former.h). LF_E_ARG: a former name stands next to the
 * current one. */
LF_NODISCARD lf_status lf_check_former(const json_t *schema, json_t *params, const char *method,
                                       lf_error *err);
/* The value of a parameter under its current or its former name, borrowed; NULL: under neither. */
const json_t *lf_param_or_former(const json_t *params, const char *name, const char *former);
/* An integer that the schema has checked, which may be written as 8.0; `absent` without the key. */
int lf_param_integer(const json_t *params, const char *key, int absent);
/* The absolute path (lf_free) of a client's path parameter. Relative ones start at the folder of
 * the scene the daemon was started with, or at --playlist; quiltctl makes them absolute. NULL: out
 * of memory. */
char *lf_server_absolute(const lf_server *server, const char *path);
/* lf_roots_resolve; of a name with a frame number, only the folder must exist. Thread: any. */
LF_NODISCARD lf_status lf_server_resolve(const lf_roots *roots, const char *name, char **out_path,
                                         lf_error *why);
/* Resolves a client's path parameter. It must be inside the roots (LF_E_PATH, whether or not it
 * exists) and exist (LF_E_IO). Relative paths start at the folder of the scene the daemon was
 * started with. *out_path (lf_free) is canonical. LF_E_PATH, LF_E_IO, LF_E_ARG (empty),
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_server_read_path(const lf_server *server, const char *path,
                                           char **out_path, lf_error *err);
/* Resolves a file to write. Its folder must exist inside --export-dir; out keeps it open, as
 * lf_held_name_open does. */
LF_NODISCARD lf_status lf_server_write_path(const lf_server *server, const char *path,
                                            lf_held_name *out, lf_error *err);

#endif
