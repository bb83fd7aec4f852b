/* Files that are read for one thing, such as a scene: they end together, and have the time that
 * lf_import_limit says together. What a thread reads belongs to the group that it is in; files that
 * are read by a thread in none have that time each. */
#ifndef LF_BASE_IMPORT_GROUP_H
#define LF_BASE_IMPORT_GROUP_H

#include <stdatomic.h>

#include "base/status.h"

typedef struct lf_import_group {
    struct lf_import_group *whole; /* that it is a part of, whose time it has; NULL: of none */
    atomic_bool cancelled;
    /* import_group.c's: files that are being read, since when any is, and seconds for which any was
     * before */
    int n_reading;
    double since, spent;
} lf_import_group;

/* Puts this thread into a new group, a part of the one that it is in, if any. Returns that one, for
 * lf_import_group_enter when all is read. *group may be one that is over, and has to stay as long
 * as a thread is in it. */
lf_import_group *lf_import_group_begin(lf_import_group *group);
/* Puts this thread into a group that was begun by any thread, or NULL: into none. Returns the one
 * that it was in. */
lf_import_group *lf_import_group_enter(lf_import_group *group);
/* The group that this thread is in; NULL: none. */
lf_import_group *lf_import_group_current(void);

/* Reading that is in progress in a group and its parts ends within a tenth of a second, and what
 * would begin does not: LF_E_CANCELLED. Thread: any. */
void lf_import_group_cancel(lf_import_group *group);
/* Whether it, or what it is a part of, was cancelled, or the program ends (lf_import_stop); NULL:
 * whether that does. Thread: any. */
bool lf_import_group_is_stopped(const lf_import_group *group);

/* Before and after a file of this thread's group is read: when reading has to be over
 * (lf_time_now). Time in which several files of a group are read counts once. */
double lf_import_begin_reading(void);
void lf_import_end_reading(void);
/* What is said of reading that lf_import_is_stopped ends, or that takes too long: LF_E_CANCELLED,
 * LF_E_TIMEOUT. */
lf_status lf_import_say_stopped(const char *where, lf_error *err);
lf_status lf_import_say_late(const char *where, lf_error *err);

#endif
