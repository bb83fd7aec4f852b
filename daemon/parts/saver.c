#include "daemon/parts/saver.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "base/thread.h"

/* How long systemd is asked to wait for the last save. */
#define SAVE_MORE_USEC 30000000

struct lf_saver {
    lf_task task; /* the save in progress */
    lf_saver_home home;
    lf_saver_events events;
    void *context;
    int folder_fd;     /* locked; -1 = none */
    lf_states *states; /* NULL without a folder */
    sd_event_source *timer;
    bool stopping;
    bool busy;
    lf_saved saved; /* content of the newest save, including the one in progress */
    pthread_t thread;
    /* owned by the thread while busy */
    lf_status status;
    lf_error err;
};

/* Locks the folder for this daemon until it ends. */
static lf_status lock_folder(lf_saver *saver, lf_error *err)
{
    const char *folder = saver->home.folder;
    saver->folder_fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (saver->folder_fd < 0)
        return lf_error_set(err, LF_E_IO, "--state", "%s: cannot open: %s", folder,
                            lf_errno_text(errno));
    if (flock(saver->folder_fd, LOCK_EX | LOCK_NB) == 0)
        return LF_OK;
    if (errno == EWOULDBLOCK)
        return lf_error_set(err, LF_E_BUSY, "--state",
                            "another running quiltd uses %s; choose another folder", folder);
    /* some network file systems have no locks */
    lf_log(LF_LOG_WARNING, "--state: cannot lock %s: %s", folder, lf_errno_text(errno));
    return LF_OK;
}

lf_status lf_saver_create(const lf_saver_home *home, const lf_saver_events *events, void *context,
                          lf_saver **out_saver, lf_error *err)
{
    lf_saver *saver = lf_calloc(1, sizeof *saver);
    if (!saver)
        return lf_error_set(err, LF_E_NOMEM, "--state", "out of memory");
    *saver = (lf_saver){.home = *home, .events = *events, .context = context, .folder_fd = -1};
    lf_status status = home->folder ? lock_folder(saver, err) : LF_OK;
    if (status == LF_OK && home->folder)
        status = lf_states_create(home->folder, &saver->states, err);
    if (status == LF_OK)
        *out_saver = saver;
    else
        lf_saver_destroy(saver);
    return status;
}

void lf_saver_destroy(lf_saver *saver)
{
    if (!saver)
        return;
    sd_event_source_disable_unref(saver->timer);
    lf_states_destroy(saver->states);
    if (saver->folder_fd >= 0)
        close(saver->folder_fd);
    lf_free(saver);
}

lf_states *lf_saver_states(lf_saver *saver)
{
    return saver->states;
}

/* True if the accumulation has changed since the last save. */
static bool has_news(const lf_saver *saver, lf_saved *out_now)
{
    return saver->states && saver->events.asked(saver->context, out_now) &&
           (out_now->generation != saver->saved.generation ||
            out_now->passes > saver->saved.passes);
}

/* ------------------------------------------------------------------------- from time to time -- */

static void end_save(lf_saver *saver)
{
    saver->busy = false;
    if (saver->status != LF_OK)
        saver->saved.passes = 0;
    if (saver->status != LF_OK && saver->status != LF_E_CANCELLED && saver->status != LF_E_STATE)
        lf_log_error(&saver->err);
    saver->events.ended(saver->context);
}

static void on_saved(void *reader, lf_task *task)
{
    lf_saver *saver = (lf_saver *)(void *)task;
    (void)reader;
    pthread_join(saver->thread, NULL);
    end_save(saver);
}

static void *save_main(void *context)
{
    lf_saver *saver = context;
    saver->status = saver->events.save(saver->context, &saver->err);
    lf_inbox_post(saver->home.inbox, &saver->task);
    return NULL;
}

/* Starts a save on a thread, unless one is in progress. */
static void save(lf_saver *saver)
{
    lf_saved now;
    if (saver->busy || saver->stopping || !has_news(saver, &now))
        return;
    saver->busy = true;
    saver->saved = now;
    saver->task.done = on_saved;
    if (lf_thread_start("lf-save", save_main, saver, &saver->thread) != LF_OK) {
        saver->status =
            lf_error_set(&saver->err, LF_E_NOMEM, saver->home.folder, "cannot start a thread");
        end_save(saver);
    }
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    save(context);
    lf_saver_begin(context);
    return 0;
}

void lf_saver_begin(lf_saver *saver)
{
    if (!saver->states || saver->stopping)
        return;
    sd_event_source_disable_unref(saver->timer);
    saver->timer = NULL;
    (void)sd_event_add_time_relative(saver->home.event, &saver->timer, CLOCK_MONOTONIC,
                                     saver->home.usec, 0, on_time, saver);
}

void lf_saver_restored(lf_saver *saver, const lf_saved *state)
{
    saver->saved = *state;
}

bool lf_saver_is_busy(const lf_saver *saver)
{
    return saver->busy;
}

/* -------------------------------------------------------------------------------- at the end -- */

void lf_saver_stop(lf_saver *saver)
{
    saver->stopping = true;
}

void lf_saver_save_now(lf_saver *saver)
{
    lf_saved now;
    lf_error err;
    if (!has_news(saver, &now))
        return;
    sd_notifyf(0,
               "EXTEND_TIMEOUT_USEC=%d\n"
               "STATUS=saving the rendering state",
               SAVE_MORE_USEC);
    lf_status status = saver->events.save(saver->context, &err);
    if (status != LF_OK && (status != LF_E_STATE || now.passes > 0))
        lf_log(LF_LOG_ERROR, "the rendering state was not saved: %s", err.what);
}
