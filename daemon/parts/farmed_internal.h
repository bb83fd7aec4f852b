/* Internals of farmed.h: farmed.c (event thread), farmed_run.c (a job's thread), farmed_child.c
 * (quiltfarm as a child), farmed_look.c (what it says), farmed_engines.c (kinds of farm) and
 * farmed_record.c (what is kept of a job). */
#ifndef LF_DAEMON_FARMED_INTERNAL_H
#define LF_DAEMON_FARMED_INTERNAL_H

#include <sys/types.h>

#include "base/thread.h"
#include "daemon/parts/farmed.h"

#define LF_FARMED_PROGRAM "quiltfarm"

/* quiltfarm in progress; zeroed: none. */
typedef struct lf_farmed_child {
    pid_t pid; /* 0: it has ended */
    int said;  /* memory file of what it printed on stdout; valid while `open` … */
    int told;  /* … and on stderr */
    bool open;
} lf_farmed_child;

typedef struct lf_farmed_job {
    lf_task news; /* posted when there is something to tell */
    struct lf_farmed_job *next;
    lf_farmed *farmed;
    int64_t id;
    lf_farmed_order order;
    bool is_submitted;   /* an earlier run has submitted it */
    char *record;        /* path of what is kept of it; NULL: nothing is */
    lf_farmed_look seen; /* as told */
    pthread_t thread;
    lf_cancel cancel, leave; /* set under lock, with `wake` */
    pthread_mutex_t lock;
    pthread_cond_t wake;
    /* under lock */
    lf_farmed_look look;
    bool posted, has_ended;
    /* owned by the thread until it has ended */
    lf_farmed_child submit;
    int vain; /* failed looks in a row */
    int idle; /* looks in a row at which nothing waits or runs, though it is not complete */
    lf_status status;
    lf_error err;
} lf_farmed_job;

struct lf_farmed {
    lf_farmed_home home;
    lf_farmed_events events;
    void *context;
    lf_farmed_job *first; /* the newest */
};

/* farmed_run.c: the whole life of a job, told to the event thread; its status and err hold the
 * outcome. */
void lf_farmed_run(lf_farmed_job *job);

/* farmed_child.c */
/* Starts quiltfarm with these words, which end with NULL. LF_E_IO: it is not in PATH, or cannot be
 * started. */
LF_NODISCARD lf_status lf_farmed_start(const char *const words[], lf_farmed_child *child,
                                       lf_error *err);
/* Whether it has ended, without waiting; *out_status is then waitpid's. */
bool lf_farmed_has_ended(lf_farmed_child *child, int *out_status);
/* Judges an end: LF_E_IO with the last line of its stderr. what: the command, "plan". */
LF_NODISCARD lf_status lf_farmed_judge(const lf_farmed_child *child, const char *what, int status,
                                       lf_error *err);
/* What it printed on stdout (lf_free); NULL: out of memory, or more than there is room for. */
char *lf_farmed_said(const lf_farmed_child *child);
/* Sends a signal (0: none) to it and its children, and closes what it printed. Accepts what has
 * ended. */
void lf_farmed_drop(lf_farmed_child *child, int signal);

/* farmed_look.c: reads `quiltfarm status --json`. *out_words (lf_free): the words of the first task
 * that failed; NULL: none. LF_E_FORMAT: it is something else. */
LF_NODISCARD lf_status lf_farmed_look_read(const char *text, lf_farmed_look *out, char **out_words,
                                           lf_error *err);

/* farmed_record.c */
/* The path of a job's record; NULL: none is kept, or out of memory. */
char *lf_farmed_record_path(const lf_farmed *farmed, const char *folder);
/* Writes it; a failure is one line in the log. */
void lf_farmed_record_write(const lf_farmed_job *job);
/* Reads a record as an order without content. LF_E_IO, LF_E_FORMAT, LF_E_PATH, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farmed_record_read(const lf_farmed_home *home, const char *path,
                                             lf_farmed_order *out, lf_error *err);
/* True for the name of a record. */
bool lf_farmed_is_record(const char *name);

#endif
