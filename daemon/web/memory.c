#include "daemon/web/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "base/errno_text.h"

static const char where[] = "memory file";

lf_status lf_memory_create(int *out_fd, lf_error *err)
{
    int fd = memfd_create("quiltweb", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (fd < 0)
        return lf_error_set(err, LF_E_IO, where, "cannot make one: %s", lf_errno_text(errno));
    *out_fd = fd;
    return LF_OK;
}

lf_status lf_memory_seal(int fd, lf_error *err)
{
    if (fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) == 0)
        return LF_OK;
    return lf_error_set(err, LF_E_IO, where, "cannot seal it: %s", lf_errno_text(errno));
}

lf_status lf_memory_reopen(int fd, int *out_fd, lf_error *err)
{
    char path[40];
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    int reader = open(path, O_RDONLY | O_CLOEXEC);
    if (reader < 0)
        return lf_error_set(err, LF_E_IO, path, "cannot open: %s", lf_errno_text(errno));
    *out_fd = reader;
    return LF_OK;
}

uint64_t lf_memory_bytes(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 && st.st_size > 0 ? (uint64_t)st.st_size : 0;
}
