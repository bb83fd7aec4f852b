/* Programs that quiltfarm runs and waits for. Thread: the main thread of a program with no
 * others. */
#ifndef LF_DAEMON_FARM_PROCESS_H
#define LF_DAEMON_FARM_PROCESS_H

#include <limits.h>

#include "base/status.h"

/* From now on TERM, INT and HUP are noted, and passed on to the program that runs. */
void lf_farm_catch_signals(void);
/* True once one of these signals has come. */
bool lf_farm_is_told_to_end(void);

/* From now on only this user can write the files that this program makes. Programs that it runs get
 * the user's own umask. */
void lf_farm_keep_others_out(void);

/* A program's work and its cost. */
typedef struct lf_farm_run {
    char *const *words;   /* words[0]: a path, or a name that is looked up in PATH */
    const char *folder;   /* its working folder; NULL: this program's */
    const char *log;      /* a file that what it prints is appended to; NULL: none */
    const char *running;  /* a file that is touched every minute while it runs; NULL: none */
    void (*look)(void *); /* called every few seconds while it runs; NULL: none */
    void *context;        /* of look */
    double cpu_seconds;   /* out: with its children */
    double seconds;       /* out: from start to end */
    int signal;           /* out: that ended it; 0: none */
    int code;             /* out: exit status */
    bool quiet;           /* print nothing: what it prints goes to the log only */
    char last[1280];      /* out: the last line that it printed, without control characters */
} lf_farm_run;

/* Finds a program of ours: installed with this one, or in PATH. LF_E_IO. */
LF_NODISCARD lf_status lf_farm_find(const char *name, char path[PATH_MAX], lf_error *err);

/* Runs a program to its end. What it prints, on stdout and stderr, goes to stderr, too. A signal is
 * passed on as its counterpart (TERM as INT, others as TERM): schedulers often send the signal to
 * all processes, and a program may end at once when the same one comes twice. The program gets TERM
 * when this one is killed. LF_E_IO: it cannot be started. */
LF_NODISCARD lf_status lf_farm_process_run(lf_farm_run *run, lf_error *err);

/* Runs a program and returns what it prints on stdout (lf_free), at most 64 MiB. Its stderr is this
 * program's. *out_code: its exit status, or 128 plus the signal that ended it. LF_E_IO: it cannot
 * be started or read; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farm_process_read(char *const words[], char **out_text, int *out_code,
                                            lf_error *err);

#endif
