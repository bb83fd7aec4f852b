#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/errno_text.h"
#include "device/sim/sim.h"

enum { MAX_LINE = 256, BLOCK = 16384 };

static const char name[] = "updates.jsonl", old_name[] = "updates.jsonl.1";

void lf_sim_log_init(lf_sim_log *log, int folder_fd, uint64_t rotate_bytes)
{
    *log = (lf_sim_log){.folder_fd = folder_fd, .rotate_bytes = rotate_bytes, .fd = -1};
}

void lf_sim_log_finish(lf_sim_log *log)
{
    if (log->fd >= 0)
        close(log->fd);
    log->fd = -1;
}

/* Removes an incomplete last line, left by a kill during a write. */
static void cut_half_line(int fd)
{
    char tail[MAX_LINE];
    struct stat st;
    if (fstat(fd, &st) != 0 || st.st_size == 0)
        return;
    off_t start = st.st_size > (off_t)sizeof tail ? st.st_size - (off_t)sizeof tail : 0;
    ssize_t n = pread(fd, tail, sizeof tail, start);
    while (n > 0 && tail[n - 1] != '\n')
        n--;
    if (n >= 0 && start + n < st.st_size && ftruncate(fd, start + n) != 0)
        return; /* one line stays damaged; readers skip it */
}

static lf_status open_log(lf_sim_log *log, lf_error *err)
{
    log->fd = openat(log->folder_fd, name,
                     O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (log->fd < 0)
        return lf_error_set(err, LF_E_IO, name, "cannot open: %s", lf_errno_text(errno));
    struct stat st;
    if (fstat(log->fd, &st) != 0 || !S_ISREG(st.st_mode)) {
        lf_sim_log_finish(log);
        return lf_error_set(err, LF_E_IO, name, "is not a regular file");
    }
    cut_half_line(log->fd);
    return LF_OK;
}

static lf_status rotate(lf_sim_log *log, lf_error *err)
{
    lf_sim_log_finish(log);
    if (renameat(log->folder_fd, name, log->folder_fd, old_name) != 0)
        return lf_error_set(err, LF_E_IO, name, "cannot rotate: %s", lf_errno_text(errno));
    return open_log(log, err);
}

/* Appends text, all or nothing. */
static lf_status append_text(lf_sim_log *log, const char *text, size_t length, lf_error *err)
{
    struct stat st;
    if (fstat(log->fd, &st) != 0)
        return lf_error_set(err, LF_E_IO, name, "%s", lf_errno_text(errno));
    size_t done = 0;
    while (done < length) {
        ssize_t n = write(log->fd, text + done, length - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            int why = n < 0 ? errno : ENOSPC;
            if (ftruncate(log->fd, st.st_size) != 0)
                lf_sim_log_finish(log); /* opening it again removes the incomplete line */
            return lf_error_set(err, LF_E_IO, name, "cannot write: %s", lf_errno_text(why));
        }
        done += (size_t)n;
    }
    if ((uint64_t)st.st_size + length >= log->rotate_bytes)
        return rotate(log, err);
    return LF_OK;
}

static size_t format_line(const lf_sim_update *u, char *out)
{
    int n = snprintf(
        out, MAX_LINE,
        "{\"seq\":%" PRIu64 ",\"x\":%d,\"y\":%d,\"width\":%d,\"height\":%d,\"bytes\":%" PRIu64
        ",\"time_ns\":%" PRIu64 "}\n",
        u->seq, u->rect.x, u->rect.y, u->rect.width, u->rect.height, u->bytes, u->time_ns);
    return (size_t)n;
}

lf_status lf_sim_log_append(lf_sim_log *log, const lf_sim_update *updates, int n, lf_error *err)
{
    char block[BLOCK];
    size_t used = 0;
    /* A small limit needs writing line by line; the usual one does not. */
    size_t full = log->rotate_bytes < BLOCK ? 0 : BLOCK - MAX_LINE;
    for (int i = 0; i < n; i++) {
        used += format_line(&updates[i], block + used);
        if (used <= full && i + 1 < n)
            continue;
        lf_status status = log->fd >= 0 ? LF_OK : open_log(log, err);
        if (status == LF_OK)
            status = append_text(log, block, used, err);
        if (status != LF_OK)
            return status;
        used = 0;
    }
    return LF_OK;
}
