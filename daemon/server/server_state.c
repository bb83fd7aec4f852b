/* --state: the accumulation that a daemon leaves behind and goes on with. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "daemon/server/server_job.h"

/* At most 60 s are to be lost, with what saving itself takes. */
#define SAVE_USEC UINT64_C(45000000)
/* How long systemd is asked to wait for the last save. */
#define SAVE_MORE_USEC 30000000

/* Holds the folder for this daemon alone, until it ends. */
static lf_status lock_folder(lf_server *server, lf_error *err)
{
    const char *folder = server->config.state_dir;
    server->state_fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (server->state_fd < 0)
        return lf_error_set(err, LF_E_IO, "--state", "%s: cannot open: %s", folder,
                            lf_errno_text(errno));
    if (flock(server->state_fd, LOCK_EX | LOCK_NB) == 0)
        return LF_OK;
    if (errno == EWOULDBLOCK)
        return lf_error_set(
            err, LF_E_BUSY, "--state",
            "%s is another quiltd's, which is still running: each needs a folder of "
            "its own",
            folder);
    /* some network file systems have no locks */
    lf_log(LF_LOG_WARNING, "--state: %s cannot be locked: %s", folder, lf_errno_text(errno));
    return LF_OK;
}

/* Something is shown that the saved state does not hold. */
static bool has_news(const lf_server *server, lf_engine_status *out_now)
{
    if (!server->saved.states || !server->content || !server->content->scene)
        return false;
    lf_engine_get_status(server->engine, out_now);
    return out_now->generation != server->saved.generation ||
           out_now->passes > server->saved.passes;
}

/* On a thread; not when one is under way. */
static void save(lf_server *server)
{
    lf_engine_status now;
    if (server->saved.saving || lf_server_is_stopping(server) || !has_news(server, &now))
        return;
    lf_job *job = job_create(server);
    if (!job)
        return;
    job->file = lf_strdup(server->config.state_dir);
    if (!job->file) {
        job_free(job);
        return;
    }
    job_list(job);
    server->saved.saving = true;
    server->saved.generation = now.generation;
    server->saved.passes = now.passes;
    job_start(job);
}

lf_status lf_server_open_states(lf_server *server, lf_error *err)
{
    lf_status status = lock_folder(server, err);
    if (status == LF_OK)
        status = lf_states_create(server->config.state_dir, &server->saved.states, err);
    return status;
}

static int on_save_timer(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)usec;
    save(server);
    lf_server_save_later(server);
    return 0;
}

void lf_server_save_later(lf_server *server)
{
    if (!server->saved.states || lf_server_is_stopping(server))
        return;
    sd_event_source_disable_unref(server->saved.timer);
    server->saved.timer = NULL;
    (void)sd_event_add_time_relative(server->event, &server->saved.timer, CLOCK_MONOTONIC,
                                     SAVE_USEC, 0, on_save_timer, server);
}

void lf_server_state_restored(lf_server *server, int64_t generation, double passes)
{
    server->saved.generation = generation;
    server->saved.passes = passes;
}

void lf_server_state_saved(lf_server *server, lf_status status)
{
    server->saved.saving = false;
    server->saved.passes = status == LF_OK ? server->saved.passes : 0;
}

void lf_server_save_state_now(lf_server *server)
{
    lf_engine_status now;
    lf_error err;
    if (!has_news(server, &now))
        return;
    sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d\nSTATUS=saving the accumulation", SAVE_MORE_USEC);
    lf_status status = lf_engine_keep(server->engine, &err);
    if (status != LF_OK && (status != LF_E_STATE || now.passes > 0))
        lf_log(LF_LOG_ERROR, "the accumulation is not saved: %s", err.what);
}
