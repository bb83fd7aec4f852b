/* Groups of files read for one purpose, such as a scene: they share the time limit of
 * lf_import_limit and are cancelled together. A file belongs to the group of the thread that reads
 * it. Without a group, each file has the whole time. */
#ifndef LF_BASE_IMPORT_GROUP_H
#define LF_BASE_IMPORT_GROUP_H

#include <stdatomic.h>

#include "base/status.h"

typedef struct lf_import_group {
    struct lf_import_group *whole; /* parent group, whose time limit applies; NULL: none */
    atomic_bool cancelled;
    /* lf_import_watch hears nothing of its files, and they are read in memory of their own
     * (lf_import_expect_quiet); to be set after the begin */
    bool is_quiet;
    /* private to import_group.c: files being read, start of the current period of reading, total
     * seconds of earlier periods */
    int n_reading;
    double since, spent;
} lf_import_group;

/* Starts a new group for this thread, as a part of its current group, if any. Returns the current
 * group, for lf_import_group_enter at the end. *group may be a finished group to reuse, and must
 * stay valid while a thread is in it. */
lf_import_group *lf_import_group_begin(lf_import_group *group);
/* Puts this thread into a group begun by any thread, or into none (NULL). Returns its previous
 * group. */
lf_import_group *lf_import_group_enter(lf_import_group *group);
/* The group of this thread; NULL: none. */
lf_import_group *lf_import_group_current(void);

/* Cancels a group and its parts: reading in progress ends within a tenth of a second, new reading
 * fails: LF_E_CANCELLED. Thread: any. */
void lf_import_group_cancel(lf_import_group *group);
/* True if the group or a parent was cancelled, or the program ends (lf_import_stop); NULL: only the
 * latter. Thread: any. */
bool lf_import_group_is_stopped(const lf_import_group *group);
/* True if this thread's group or a parent is quiet. */
bool lf_import_is_quiet(void);

/* To be called before and after this thread reads a file of its group. Returns the deadline
 * (lf_time_now). Time in which several files of a group are read counts once. */
double lf_import_begin_reading(void);
void lf_import_end_reading(void);
/* Errors for reading that lf_import_is_stopped ends, or that takes too long: LF_E_CANCELLED,
 * LF_E_TIMEOUT. */
lf_status lf_import_say_stopped(const char *where, lf_error *err);
lf_status lf_import_say_late(const char *where, lf_error *err);

#endif
