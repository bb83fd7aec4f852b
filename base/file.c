#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"

static lf_status fail_errno(lf_error *err, const char *path, const char *what)
{
    int e = errno;
    return lf_error_set(err, e == ENOMEM ? LF_E_NOMEM : LF_E_IO, path, "%s: %s", what, lf_errno_text(e));
}

/* ----------------------------------------------------------------------------------------------------------- roots -- */

lf_status lf_roots_add(lf_roots *roots, const char *folder, lf_error *err)
{
    struct stat st;
    char real[PATH_MAX];
    if (!realpath(folder, real) || stat(real, &st) != 0)
        return fail_errno(err, folder, "cannot open the folder");
    if (!S_ISDIR(st.st_mode))
        return lf_error_set(err, LF_E_ARG, folder, "not a folder");
    for (int i = 0; i < roots->n_roots; i++) {
        if (strcmp(roots->root[i], real) == 0)
            return LF_OK;
    }
    if (roots->n_roots == LF_MAX_ROOTS)
        return lf_error_set(err, LF_E_ARG, folder, "more than %d folders", LF_MAX_ROOTS);
    char *copy = lf_strdup(real);
    if (!copy)
        return lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    roots->root[roots->n_roots++] = copy;
    return LF_OK;
}

void lf_roots_finish(lf_roots *roots)
{
    for (int i = 0; i < roots->n_roots; i++)
        lf_free(roots->root[i]);
    *roots = (lf_roots){0};
}

/* path is canonical. */
static bool beneath(const lf_roots *roots, const char *path)
{
    for (int i = 0; i < roots->n_roots; i++) {
        const char *root = roots->root[i];
        size_t n = strcmp(root, "/") == 0 ? 0 : strlen(root);
        if (strncmp(path, root, n) == 0 && (path[n] == '/' || path[n] == 0))
            return true;
    }
    return false;
}

/* Whether what does not exist (or cannot be opened) would lie beneath the roots: the nearest folder above it that exists
 * decides. Otherwise the difference of two errors would tell a client which files exist outside. */
static bool would_lie_beneath(const lf_roots *roots, const char *path)
{
    char above[PATH_MAX], real[PATH_MAX];
    size_t n = strlen(path);
    if (n >= sizeof above)
        return false;
    memcpy(above, path, n + 1);
    for (;;) {
        char *slash = strrchr(above, '/');
        if (!slash)
            return realpath(".", real) && beneath(roots, real);
        if (slash == above)
            return beneath(roots, "/");
        *slash = 0;
        if (realpath(above, real))
            return beneath(roots, real);
    }
}

static lf_status outside(lf_error *err, const char *path)
{
    return lf_error_set(err, LF_E_PATH, path, "lies outside the folders that may be read");
}

/* The name of an open descriptor, links resolved by the kernel itself. */
static bool descriptor_name(int fd, char name[static PATH_MAX])
{
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, name, PATH_MAX - 1);
    if (n <= 0 || n >= PATH_MAX - 1)
        return false;
    name[n] = 0;
    return true;
}

/* O_PATH opens nothing: no device notices, no FIFO waits. Only what passed both checks is opened for reading. */
static lf_status open_beneath(const char *path, const lf_roots *roots, int *out_fd, lf_error *err)
{
    char name[PATH_MAX], link[64];
    struct stat st;
    int handle = open(path, O_PATH | O_CLOEXEC);
    if (handle < 0) {
        int why = errno;
        if (!would_lie_beneath(roots, path))
            return outside(err, path);
        errno = why;
        return fail_errno(err, path, "cannot open");
    }
    if (!descriptor_name(handle, name) || !beneath(roots, name)) {
        close(handle);
        return outside(err, path);
    }
    if (fstat(handle, &st) != 0 || !S_ISREG(st.st_mode)) {
        close(handle);
        return lf_error_set(err, LF_E_FORMAT, path, "not a regular file");
    }
    snprintf(link, sizeof link, "/proc/self/fd/%d", handle);
    int fd = open(link, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) {
        lf_status status = fail_errno(err, path, "cannot open");
        close(handle);
        return status;
    }
    close(handle);
    *out_fd = fd;
    return LF_OK;
}

/* --------------------------------------------------------------------------------------------------------- reading -- */

lf_status lf_file_open(const char *path, const lf_roots *roots, uint64_t max_bytes, int *out_fd, uint64_t *out_size, lf_error *err)
{
    int fd = -1;
    struct stat st;
    if (roots && roots->n_roots > 0) {
        lf_status status = open_beneath(path, roots, &fd, err);
        if (status != LF_OK)
            return status;
    } else {
        fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
        if (fd < 0)
            return fail_errno(err, path, "cannot open");
    }
    lf_status status = LF_OK;
    if (fstat(fd, &st) != 0)
        status = fail_errno(err, path, "cannot stat");
    else if (!S_ISREG(st.st_mode))
        status = lf_error_set(err, LF_E_FORMAT, path, "not a regular file");
    else if ((uint64_t)st.st_size > max_bytes)
        status =
            lf_error_set(err, LF_E_FORMAT, path, "%ju bytes, expected at most %ju", (uintmax_t)st.st_size, (uintmax_t)max_bytes);
    if (status != LF_OK) {
        close(fd);
        return status;
    }
    *out_fd = fd;
    if (out_size)
        *out_size = (uint64_t)st.st_size;
    return LF_OK;
}

/* Up to n bytes; *out_n is less when the file has shrunk meanwhile. */
static lf_status read_all(int fd, char *data, size_t n, size_t *out_n, const char *path, lf_error *err)
{
    size_t done = 0;
    while (done < n) {
        ssize_t got = read(fd, data + done, n - done);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return fail_errno(err, path, "cannot read");
        if (got == 0)
            break;
        done += (size_t)got;
    }
    *out_n = done;
    return LF_OK;
}

lf_status lf_file_read(const char *path, const lf_roots *roots, uint64_t max_bytes, char **out_data, size_t *out_size,
                       lf_error *err)
{
    int fd;
    uint64_t size;
    lf_status status = lf_file_open(path, roots, max_bytes, &fd, &size, err);
    if (status != LF_OK)
        return status;
    size_t got = 0;
    char *data = size < SIZE_MAX ? lf_calloc((size_t)size + 1, 1) : NULL;
    if (data)
        status = read_all(fd, data, (size_t)size, &got, path, err);
    else
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory for %ju bytes", (uintmax_t)size);
    close(fd);
    if (status != LF_OK) {
        lf_free(data);
        return status;
    }
    data[got] = 0;
    *out_data = data;
    *out_size = got;
    return LF_OK;
}

/* ----------------------------------------------------------------------------------------------------------- names -- */

char *lf_path_join(const char *folder, const char *relative)
{
    if (relative[0] == '/' || folder[0] == 0)
        return lf_strdup(relative);
    size_t n = strlen(folder), m = strlen(relative);
    bool slash = folder[n - 1] != '/';
    char *path = lf_calloc(n + slash + m + 1, 1);
    if (!path)
        return NULL;
    memcpy(path, folder, n);
    if (slash)
        path[n] = '/';
    memcpy(path + n + slash, relative, m);
    return path;
}

char *lf_path_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return lf_strdup(".");
    size_t n = slash == path ? 1 : (size_t)(slash - path);
    char *folder = lf_calloc(n + 1, 1);
    return folder ? memcpy(folder, path, n) : NULL;
}
