#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/errno_text.h"
#include "device/sim/sim.h"

enum { MAX_STATE = 128 };

static const char state_name[] = ".unplugged";

static bool read_small(int folder_fd, const char *name, char *out, size_t size)
{
    int fd = openat(folder_fd, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (fd < 0)
        return false;
    ssize_t n = read(fd, out, size - 1);
    close(fd);
    out[n > 0 ? n : 0] = 0;
    return n > 0;
}

/* Start time of this process, in clock ticks. With the process id it identifies the process, even
 * across restarts of a container that always uses the same id. */
static uint64_t start_time(void)
{
    char stat[1024];
    if (!read_small(AT_FDCWD, "/proc/self/stat", stat, sizeof stat))
        return 0;
    /* the second field, the program's name, may contain any character */
    const char *field = strrchr(stat, ')');
    for (int i = 2; field && i < 22; i++)
        field = strchr(field + 1, ' ');
    uint64_t ticks = 0;
    if (field && sscanf(field, " %" SCNu64, &ticks) != 1)
        return 0;
    return ticks;
}

lf_sim_plug lf_sim_plug_state(int folder_fd, uint64_t now_ns)
{
    char text[MAX_STATE];
    if (!read_small(folder_fd, state_name, text, sizeof text))
        return LF_SIM_PLUGGED;
    int pid = 0;
    uint64_t started = 0, back_ns = 0;
    if (sscanf(text, "%d %" SCNu64 " %" SCNu64, &pid, &started, &back_ns) != 3 ||
        pid != (int)getpid() || started != start_time())
        return LF_SIM_PLUGGED;
    return back_ns == LF_SIM_NEVER || now_ns < back_ns ? LF_SIM_UNPLUGGED : LF_SIM_REPLUGGED;
}

lf_status lf_sim_plug_out(int folder_fd, uint64_t back_ns, lf_error *err)
{
    char text[MAX_STATE];
    int n = snprintf(text, sizeof text, "%d %" PRIu64 " %" PRIu64 "\n", (int)getpid(), start_time(),
                     back_ns);
    int fd = openat(folder_fd, state_name,
                    O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (fd < 0)
        return lf_error_set(err, LF_E_IO, state_name, "cannot open: %s", lf_errno_text(errno));
    ssize_t written = write(fd, text, (size_t)n);
    int why = written < 0 ? errno : ENOSPC;
    close(fd);
    return written == n
               ? LF_OK
               : lf_error_set(err, LF_E_IO, state_name, "cannot write: %s", lf_errno_text(why));
}

void lf_sim_plug_clear(int folder_fd)
{
    unlinkat(folder_fd, state_name, 0);
}

bool lf_sim_removed(int folder_fd)
{
    struct stat st;
    return fstat(folder_fd, &st) == 0 && st.st_nlink == 0;
}
