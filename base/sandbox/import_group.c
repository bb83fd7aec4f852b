#include "base/sandbox/import_group.h"

#include <pthread.h>

#include "base/sandbox/import.h"
#include "base/thread.h"

static atomic_bool stopped;
static _Thread_local lf_import_group *current;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* protects the times of all groups */

lf_import_group *lf_import_group_begin(lf_import_group *group)
{
    group->whole = current;
    group->is_quiet = false;
    group->n_reading = 0;
    group->since = group->spent = 0;
    atomic_store(&group->cancelled, false);
    return lf_import_group_enter(group);
}

lf_import_group *lf_import_group_enter(lf_import_group *group)
{
    lf_import_group *before = current;
    current = group;
    return before;
}

lf_import_group *lf_import_group_current(void)
{
    return current;
}

/* ----------------------------------------------------------------------------------- the end -- */

void lf_import_stop(void)
{
    atomic_store(&stopped, true);
}

void lf_import_group_cancel(lf_import_group *group)
{
    atomic_store(&group->cancelled, true);
}

bool lf_import_group_is_stopped(const lf_import_group *group)
{
    bool found = atomic_load(&stopped);
    for (; group && !found; group = group->whole)
        found = atomic_load(&group->cancelled);
    return found;
}

bool lf_import_is_stopped(void)
{
    return lf_import_group_is_stopped(current);
}

bool lf_import_is_quiet(void)
{
    const lf_import_group *group = current;
    while (group && !group->is_quiet)
        group = group->whole;
    return group;
}

lf_status lf_import_say_stopped(const char *where, lf_error *err)
{
    return lf_error_set(err, LF_E_CANCELLED, where, "stopped");
}

/* ---------------------------------------------------------------------------------- the time -- */

static lf_import_group *whole_of(lf_import_group *group)
{
    while (group && group->whole)
        group = group->whole;
    return group;
}

double lf_import_begin_reading(void)
{
    const double now = lf_time_now();
    double deadline = now + lf_import_seconds();
    lf_import_group *whole = whole_of(current);
    if (!whole)
        return deadline;
    pthread_mutex_lock(&lock);
    if (whole->n_reading++ == 0)
        whole->since = now;
    deadline = whole->since + lf_import_seconds() - whole->spent;
    pthread_mutex_unlock(&lock);
    return deadline;
}

void lf_import_end_reading(void)
{
    lf_import_group *whole = whole_of(current);
    if (!whole)
        return;
    pthread_mutex_lock(&lock);
    if (--whole->n_reading == 0)
        whole->spent += lf_time_now() - whole->since;
    pthread_mutex_unlock(&lock);
}

lf_status lf_import_say_late(const char *where, lf_error *err)
{
    return lf_error_set(err, LF_E_TIMEOUT, where,
                        "reading all files takes longer than %u s; raise --import-time, or look "
                        "for a damaged or very large file",
                        lf_import_seconds());
}
