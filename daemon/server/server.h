/* server: the daemon behind its socket. */
#ifndef LF_DAEMON_SERVER_H
#define LF_DAEMON_SERVER_H

#include "base/paths.h"
#include "daemon/engine/engine.h"
#include "daemon/output/options.h"
#include "daemon/parts/farmed.h"
#include "daemon/parts/play_list.h"
#include "daemon/server/button_actions.h"

#define LF_SERVER_WEB_PORT 8033 /* default of --web */

/* --playlist and what belongs to it. */
typedef struct lf_server_playlist {
    const char *folder; /* absolute; NULL = none */
    double seconds;     /* of entries that are no videos */
    double crossfade;   /* seconds */
} lf_server_playlist;

typedef struct lf_server_config {
    const char *scene;           /* as on the command line; NULL = none */
    lf_server_playlist playlist; /* instead of a scene */
    const char *socket;          /* --socket; NULL = the default */
    const char *device;          /* spec */
    const char *calibration;     /* file; NULL = the device's own */
    const char *state_dir;       /* NULL = none */
    const char *export_dir;      /* NULL = none */
    unsigned farms;              /* bits of lf_farmed_engine_at: those that exports may use */
    const char *allow[LF_MAX_ROOTS];
    int n_allow;
    bool watch;
    bool web;       /* start quiltweb (daemon/parts/web_child.h) */
    int web_port;   /* 0: any free one */
    double run_for; /* seconds; 0 = until stopped */
    lf_button_actions buttons;
    lf_options options;
    lf_response response; /* of the panel */
} lf_server_config;

/* Runs the daemon; returns the exit code. */
int lf_server_run(const lf_server_config *config);

#endif
