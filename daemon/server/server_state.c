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

#define STATE_NAME "film.lfstate"
/* How long systemd is asked to wait for the last save. */
#define SAVE_MORE_USEC 30000000

static char *state_path(const lf_server *server)
{
    return lf_path_join(server->config.state_dir, STATE_NAME);
}

lf_status lf_server_lock_state(lf_server *server, lf_error *err)
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

int lf_server_open_state(const lf_server *server)
{
    char *path = server->config.state_dir ? state_path(server) : NULL;
    int fd = -1;
    lf_error err;
    if (path && access(path, F_OK) == 0 &&
        lf_file_open(path, NULL, UINT64_MAX, &fd, NULL, &err) != LF_OK) {
        lf_log(LF_LOG_INFO, "the saved state is left aside: %s", err.what);
        fd = -1;
    }
    lf_free(path);
    return fd;
}

void lf_server_save_state(lf_server *server)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    bool news = now.generation != server->saved.generation || now.passes > server->saved.passes;
    if (server->saved.saving || lf_server_is_stopping(server) || !server->content ||
        !server->content->scene || !news)
        return;
    lf_job *job = job_create(server);
    if (!job)
        return;
    job->overwrite = true;
    job->file = state_path(server);
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

void lf_server_state_saved(lf_server *server, lf_status status)
{
    server->saved.saving = false;
    server->saved.passes = status == LF_OK ? server->saved.passes : 0;
}

void lf_server_save_state_now(lf_server *server)
{
    char *path = server->config.state_dir ? state_path(server) : NULL;
    lf_outfile file = {.fd = -1};
    lf_error err;
    if (!path || !server->content || !server->content->scene) {
        lf_free(path);
        return;
    }
    sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d\nSTATUS=saving the accumulation", SAVE_MORE_USEC);
    lf_status status = lf_outfile_open(&file, path, true, &err);
    if (status == LF_OK)
        status = lf_engine_save(server->engine, &file, false, &err);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, &err);
    else
        lf_outfile_abandon(&file);
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    if (status != LF_OK && (status != LF_E_STATE || now.passes > 0))
        lf_log(LF_LOG_ERROR, "the accumulation is not saved: %s", err.what);
    lf_free(path);
}
