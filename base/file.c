#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"

static lf_status fail_errno(lf_error *err, const char *path, const char *what)
{
    int e = errno;
    return lf_error_set(err, e == ENOMEM ? LF_E_NOMEM : LF_E_IO, path, "%s: %s", what,
                        lf_errno_text(e));
}

/* ----------------------------------------------------------------------------------- reading -- */

/* True for an HTML page, which servers send instead of a missing file. */
static bool is_web_page(int fd)
{
    static const char *const beginnings[] = {"<!doctype html", "<html"};
    char text[64];
    ssize_t n = pread(fd, text, sizeof text - 1, 0);
    text[n > 0 ? n : 0] = '\0';
    const char *at = text + strspn(text, " \t\r\n");
    for (size_t i = 0; i < sizeof beginnings / sizeof *beginnings; i++)
        if (strncasecmp(at, beginnings[i], strlen(beginnings[i])) == 0)
            return true;
    return false;
}

static struct {
    lf_file_opened_fn opened;
    void *context;
} listener;

void lf_file_on_open(lf_file_opened_fn opened, void *context)
{
    listener.opened = opened;
    listener.context = context;
}

lf_status lf_file_open(const char *path, const lf_roots *roots, uint64_t max_bytes, int *out_fd,
                       uint64_t *out_size, lf_error *err)
{
    int fd = -1;
    struct stat st;
    if (roots && roots->n_roots > 0) {
        lf_status status = lf_roots_open(roots, path, &fd, err);
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
            lf_error_set(err, LF_E_FORMAT, path, "the file has %ju bytes; expected at most %ju",
                         (uintmax_t)st.st_size, (uintmax_t)max_bytes);
    else if (is_web_page(fd))
        status =
            lf_error_set(err, LF_E_FORMAT, path,
                         "this is a web page, not the expected file; download the file itself");
    if (status != LF_OK) {
        close(fd);
        return status;
    }
    if (listener.opened)
        listener.opened(listener.context, path);
    *out_fd = fd;
    if (out_size)
        *out_size = (uint64_t)st.st_size;
    return LF_OK;
}

/* Reads up to n bytes; *out_n is less if the file has shrunk meanwhile. */
static lf_status read_all(int fd, char *data, size_t n, size_t *out_n, const char *path,
                          lf_error *err)
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

lf_status lf_file_read(const char *path, const lf_roots *roots, uint64_t max_bytes, char **out_data,
                       size_t *out_size, lf_error *err)
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
        status =
            lf_error_set(err, LF_E_NOMEM, path, "out of memory for %ju bytes", (uintmax_t)size);
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

/* ------------------------------------------------------------------------------------- names -- */

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

char *lf_path_beside(const char *path, const char *ending)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const size_t stem = dot && (!slash || dot > slash) ? (size_t)(dot - path) : strlen(path);
    char *name = lf_calloc(stem + strlen(ending) + 1, 1);
    if (name) {
        memcpy(name, path, stem);
        memcpy(name + stem, ending, strlen(ending));
    }
    return name;
}

bool lf_path_has_ending(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n >= m && strcasecmp(path + n - m, ending) == 0;
}
