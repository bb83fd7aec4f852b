#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"

/* A temporary name in NAME's folder: ".NAME.quiltd-XXXXXX". The writer holds a lock (flock) on it;
 * a file that can be locked was left by a killed run. */
#define SUFFIX ".quiltd-"
#define RANDOM_CHARS 6
#define ATTEMPTS 64

static lf_status fail_errno(lf_error *err, const char *path, const char *what)
{
    int e = errno;
    lf_status status = e == ENOMEM ? LF_E_NOMEM : e == EEXIST ? LF_E_EXISTS : LF_E_IO;
    return lf_error_set(err, status, path, "%s: %s", what, lf_errno_text(e));
}

static lf_status fail_exists(lf_error *err, const char *path)
{
    return lf_error_set(err, LF_E_EXISTS, path,
                        "the file exists already and overwriting is off; use another name");
}

/* The part of a temporary name before the random characters; long names are cut so that the whole
 * fits into NAME_MAX. */
static size_t temporary_prefix(const char *path, char out[static NAME_MAX + 1])
{
    const char *slash = strrchr(path, '/');
    int keep = NAME_MAX - 1 - (int)strlen(SUFFIX) - RANDOM_CHARS;
    return (size_t)snprintf(out, NAME_MAX + 1, ".%.*s%s", keep, slash ? slash + 1 : path, SUFFIX);
}

static void random_chars(char out[static RANDOM_CHARS])
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz012345";
    unsigned char bytes[RANDOM_CHARS] = {0};
    if (getrandom(bytes, sizeof bytes, GRND_NONBLOCK) != (ssize_t)sizeof bytes)
        for (int i = 0; i < RANDOM_CHARS; i++)
            bytes[i] = (unsigned char)((unsigned)getpid() >> (5 * i));
    for (int i = 0; i < RANDOM_CHARS; i++)
        out[i] = letters[bytes[i] & 31];
}

/* A fresh temporary name for path; caller frees. */
static char *temporary_name(const char *path)
{
    char prefix[NAME_MAX + 1];
    size_t n = temporary_prefix(path, prefix);
    char name[NAME_MAX + 1] = {0};
    memcpy(name, prefix, n);
    random_chars(name + n);
    char *folder = lf_path_folder(path);
    char *joined = folder ? lf_path_join(folder, name) : NULL;
    lf_free(folder);
    return joined;
}

/* Locks a writer's file. File systems of some clusters have no locks: then it is not needed,
 * because nobody can take the file for one that was left. */
static bool lock(int fd)
{
    return flock(fd, LOCK_EX | LOCK_NB) == 0 || errno == ENOSYS || errno == EOPNOTSUPP;
}

static void remove_if_dead(int folder, const char *name)
{
    int fd = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0)
        unlinkat(folder, name, 0);
    close(fd);
}

static void remove_leftovers(const char *path, const char *folder)
{
    char prefix[NAME_MAX + 1];
    size_t n = temporary_prefix(path, prefix);
    DIR *dir = opendir(folder);
    if (!dir)
        return;
    for (const struct dirent *entry; (entry = readdir(dir));)
        if (strncmp(entry->d_name, prefix, n) == 0 && strlen(entry->d_name) == n + RANDOM_CHARS)
            remove_if_dead(dirfd(dir), entry->d_name);
    closedir(dir);
}

/* True for ".NAME.quiltd-XXXXXX" where NAME has this beginning. */
static bool is_temporary(const char *name, const char *beginning)
{
    const size_t n = strlen(name), tail = strlen(SUFFIX) + RANDOM_CHARS, m = strlen(beginning);
    return n > tail + m && name[0] == '.' && strncmp(name + 1, beginning, m) == 0 &&
           strncmp(name + n - tail, SUFFIX, strlen(SUFFIX)) == 0;
}

void lf_outfile_clean(const char *folder, const char *beginning)
{
    DIR *dir = opendir(folder);
    if (!dir)
        return;
    for (const struct dirent *entry; (entry = readdir(dir));)
        if (is_temporary(entry->d_name, beginning))
            remove_if_dead(dirfd(dir), entry->d_name);
    closedir(dir);
}

/* Creates a locked temporary file. Another writer may remove it as a leftover between creation and
 * lock; then it tries again. */
static lf_status open_named(lf_outfile *file, lf_error *err)
{
    for (int i = 0; i < ATTEMPTS; i++) {
        struct stat st;
        char *name = temporary_name(file->path);
        if (!name)
            return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
        int fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (fd >= 0 && lock(fd) && fstat(fd, &st) == 0 && st.st_nlink > 0) {
            file->fd = fd;
            file->temporary = name;
            return LF_OK;
        }
        lf_free(name);
        if (fd >= 0)
            close(fd);
        else if (errno != EEXIST)
            return fail_errno(err, file->path, "cannot write into this folder");
    }
    return lf_error_set(err, LF_E_IO, file->path, "no name is free for a temporary file");
}

/* Unnamed if the file system supports it; publishing then uses /proc. */
static lf_status open_temporary(lf_outfile *file, const char *folder, lf_error *err)
{
    int fd = access("/proc/self/fd", X_OK) == 0 ? open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0666)
                                                : -1;
    if (fd < 0)
        return open_named(file, err);
    /* no other process can have it open; the lock is for later, when it gets a temporary name */
    if (!lock(fd)) {
        close(fd);
        return open_named(file, err);
    }
    file->fd = fd;
    return LF_OK;
}

static lf_status check_target(const char *path, bool overwrite, lf_error *err)
{
    struct stat st;
    if (lstat(path, &st) != 0)
        return errno == ENOENT ? LF_OK : fail_errno(err, path, "cannot write");
    if (!S_ISREG(st.st_mode) && !S_ISLNK(st.st_mode))
        return lf_error_set(err, LF_E_IO, path,
                            "exists already and is not a regular file; use another name");
    return overwrite ? LF_OK : fail_exists(err, path);
}

lf_status lf_outfile_open(lf_outfile *file, const char *path, bool overwrite, lf_error *err)
{
    *file = (lf_outfile){.fd = -1};
    size_t n = strlen(path);
    if (n == 0 || path[n - 1] == '/')
        return lf_error_set(err, LF_E_ARG, path,
                            "not a file name; expected one that does not end in \"/\"");
    lf_status status = check_target(path, overwrite, err);
    if (status != LF_OK)
        return status;
    char *folder = lf_path_folder(path);
    file->path = lf_strdup(path);
    if (folder && file->path) {
        remove_leftovers(path, folder);
        status = open_temporary(file, folder, err);
    } else {
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    lf_free(folder);
    if (status != LF_OK)
        lf_outfile_abandon(file);
    return status;
}

lf_status lf_outfile_adopt(lf_outfile *file, int fd, lf_error *err)
{
    struct stat st;
    *file = (lf_outfile){.fd = -1};
    int flags = fcntl(fd, F_GETFL);
    if (flags < 0 || fstat(fd, &st) != 0)
        return fail_errno(err, "descriptor", "cannot use it");
    if (!S_ISREG(st.st_mode) || (flags & O_ACCMODE) == O_RDONLY || (flags & O_PATH) != 0)
        return lf_error_set(err, LF_E_ARG, "descriptor",
                            "expected a regular file that is open for writing");
    if (ftruncate(fd, 0) != 0 || lseek(fd, 0, SEEK_SET) != 0 || fcntl(fd, F_SETFD, FD_CLOEXEC) != 0)
        return fail_errno(err, "descriptor", "cannot be emptied");
    file->fd = fd;
    file->borrowed = true;
    return LF_OK;
}

lf_status lf_outfile_write(lf_outfile *file, const void *data, size_t n, lf_error *err)
{
    const char *bytes = data;
    while (n > 0) {
        ssize_t done = write(file->fd, bytes, n);
        if (done < 0 && errno == EINTR)
            continue;
        if (done < 0)
            return fail_errno(err, file->path ? file->path : "descriptor", "cannot write");
        bytes += done;
        n -= (size_t)done;
    }
    return LF_OK;
}

lf_status lf_outfile_text(const char *path, const char *text, lf_error *err)
{
    lf_outfile file = {.fd = -1};
    lf_status status = lf_outfile_open(&file, path, true, err);
    if (status != LF_OK)
        return status;
    status = lf_outfile_write(&file, text, strlen(text), err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

/* Links an unnamed file as `name`, which must not exist. */
static int link_unnamed(int fd, const char *name)
{
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    return linkat(AT_FDCWD, link, AT_FDCWD, name, AT_SYMLINK_FOLLOW);
}

/* Only rename replaces a file, so an unnamed one gets a temporary name first. */
static lf_status name_temporarily(lf_outfile *file, lf_error *err)
{
    for (int i = 0; i < ATTEMPTS; i++) {
        char *name = temporary_name(file->path);
        if (!name)
            return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
        if (link_unnamed(file->fd, name) == 0) {
            file->temporary = name;
            return LF_OK;
        }
        lf_free(name);
        if (errno != EEXIST)
            return fail_errno(err, file->path, "cannot be named");
    }
    return lf_error_set(err, LF_E_IO, file->path, "no name is free for a temporary file");
}

/* rename without replacing; with a hard link if the file system does not support that */
static int rename_new(const char *from, const char *to)
{
    if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0)
        return 0;
    if (errno != EINVAL && errno != ENOSYS)
        return -1;
    if (link(from, to) != 0)
        return -1;
    unlink(from);
    return 0;
}

static lf_status publish(lf_outfile *file, bool overwrite, lf_error *err)
{
    if (!file->temporary) {
        if (link_unnamed(file->fd, file->path) == 0)
            return LF_OK;
        if (errno != EEXIST)
            return fail_errno(err, file->path, "cannot be named");
        if (!overwrite)
            return fail_exists(err, file->path);
        lf_status status = name_temporarily(file, err);
        if (status != LF_OK)
            return status;
    }
    int rc =
        overwrite ? rename(file->temporary, file->path) : rename_new(file->temporary, file->path);
    if (rc != 0)
        return errno == EEXIST ? fail_exists(err, file->path)
                               : fail_errno(err, file->path, "cannot be named");
    lf_free(file->temporary);
    file->temporary = NULL;
    return LF_OK;
}

/* The new name survives a power failure only if its folder is on disk too. A file system that
 * cannot sync folders is not an error. */
static void sync_folder(const char *path)
{
    char *folder = lf_path_folder(path);
    int fd = folder ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    lf_free(folder);
}

lf_status lf_outfile_commit(lf_outfile *file, bool overwrite, lf_error *err)
{
    const char *where = file->path ? file->path : "descriptor";
    lf_status status = LF_OK;
    if (fsync(file->fd) != 0 && errno != EINVAL && errno != EROFS)
        status = fail_errno(err, where, "cannot be written to the disk");
    else if (file->path)
        status = publish(file, overwrite, err);
    if (status != LF_OK) {
        lf_outfile_abandon(file);
        return status;
    }
    if (file->path)
        sync_folder(file->path);
    close(file->fd);
    lf_free(file->path);
    *file = (lf_outfile){.fd = -1};
    return LF_OK;
}

void lf_outfile_abandon(lf_outfile *file)
{
    bool open = file->fd >= 0 && (file->path || file->borrowed);
    if (file->temporary)
        unlink(file->temporary);
    if (open && file->borrowed) {
        int rc = ftruncate(file->fd, 0);
        (void)rc; /* an incomplete file is useless to its owner, but nothing more can be done */
    }
    if (open)
        close(file->fd);
    lf_free(file->temporary);
    lf_free(file->path);
    *file = (lf_outfile){.fd = -1};
}
