#include "base/passed.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/frame_name.h"

#define COPY_BYTES ((size_t)1 << 20) /* bytes copied at a time */

typedef struct passed_file {
    atomic_int references;
    int fd;
    char *path;
    pthread_mutex_t lock; /* protects copy */
    int copy;             /* a copy in memory; -1: none */
    uint64_t copied;      /* size of the copy */
    lf_array array;       /* n_axes 0: a file */
} passed_file;

struct lf_passed {
    atomic_int references;
    int n;
    passed_file *file[LF_MAX_PASSED];
    atomic_bool opened[LF_MAX_PASSED]; /* opened since the list was made */
};

static atomic_int n_held;
static _Atomic uint64_t n_copied;        /* bytes of all copies */
static bool (*_Atomic is_stopped)(void); /* NULL: never stopped */

void lf_passed_stop_when(bool (*stopped)(void))
{
    atomic_store(&is_stopped, stopped);
}

/* ------------------------------------------------------------------------------------- names -- */

/* Removes the last part. */
static void go_up(char *name)
{
    char *slash = strrchr(name, '/');
    if (slash)
        *slash = '\0';
}

bool lf_passed_name(const char *path, char *out)
{
    size_t used = 0;
    out[0] = '\0';
    if (path[0] != '/') {
        if (!getcwd(out, PATH_MAX))
            return false;
        used = strcmp(out, "/") == 0 ? 0 : strlen(out);
        out[used] = '\0';
    }
    for (const char *part = path; *part != '\0';) {
        part += strspn(part, "/");
        const size_t n = strcspn(part, "/");
        const bool nothing = n == 0 || (n == 1 && part[0] == '.');
        if (n == 2 && part[0] == '.' && part[1] == '.') {
            go_up(out);
        } else if (!nothing) {
            used = strlen(out);
            if (used + n + 2 > PATH_MAX)
                return false;
            snprintf(out + used, PATH_MAX - used, "/%.*s", (int)n, part);
        }
        part += n;
    }
    if (out[0] == '\0')
        memcpy(out, "/", 2);
    return true;
}

/* name: normalised, or an array's. -1: not found. */
static int find_name(const lf_passed *passed, const char *name)
{
    for (int i = 0; passed && i < passed->n; i++)
        if (strcmp(passed->file[i]->path, name) == 0)
            return i;
    return -1;
}

/* -1: not found. Never an array, because these names are absolute. */
static int find(const lf_passed *passed, const char *path)
{
    char name[PATH_MAX];
    return passed && passed->n > 0 && lf_passed_name(path, name) ? find_name(passed, name) : -1;
}

bool lf_passed_has(const lf_passed *passed, const char *path)
{
    return find(passed, path) >= 0;
}

const char *lf_passed_at(const lf_passed *passed, int index)
{
    return passed && index < passed->n ? passed->file[index]->path : NULL;
}

/* ------------------------------------------------------------------------------------- lists -- */

lf_passed *lf_passed_create(void)
{
    lf_passed *passed = lf_calloc(1, sizeof *passed);
    if (passed)
        atomic_init(&passed->references, 1);
    return passed;
}

lf_passed *lf_passed_ref(lf_passed *passed)
{
    if (passed)
        atomic_fetch_add_explicit(&passed->references, 1, memory_order_relaxed);
    return passed;
}

/* fd: of the copy, or negative. */
static void drop_copy(passed_file *file, int fd)
{
    atomic_fetch_sub(&n_copied, file->copied);
    file->copied = 0;
    if (fd >= 0)
        close(fd);
}

static void file_unref(passed_file *file)
{
    if (atomic_fetch_sub_explicit(&file->references, 1, memory_order_acq_rel) != 1)
        return;
    close(file->fd);
    drop_copy(file, file->copy);
    pthread_mutex_destroy(&file->lock);
    lf_free(file->path);
    lf_free(file);
    atomic_fetch_sub(&n_held, 1);
}

void lf_passed_unref(lf_passed *passed)
{
    if (!passed || atomic_fetch_sub_explicit(&passed->references, 1, memory_order_acq_rel) != 1)
        return;
    for (int i = 0; i < passed->n; i++)
        file_unref(passed->file[i]);
    lf_free(passed);
}

/* Adds a file of another list. */
static void share(lf_passed *passed, passed_file *file)
{
    atomic_fetch_add_explicit(&file->references, 1, memory_order_relaxed);
    atomic_init(&passed->opened[passed->n], false);
    passed->file[passed->n++] = file;
}

static lf_status check_path(const lf_passed *passed, const char *path, lf_error *err)
{
    char name[PATH_MAX];
    if (path[0] != '/' || !lf_passed_name(path, name) || strcmp(path, name) != 0)
        return lf_error_set(
            err, LF_E_ARG, path,
            "a passed file needs an absolute path without \".\", \"..\" and \"//\"");
    if (lf_frame_name_varies(path))
        return lf_error_set(err, LF_E_ARG, path,
                            "a name with a frame number cannot be passed; pass one file");
    return find(passed, path) < 0 ? LF_OK
                                  : lf_error_set(err, LF_E_ARG, path, "the file was passed twice");
}

/* Checks a passed descriptor. O_PATH grants no read access: reopening would use the daemon's
 * rights. Writable descriptors are refused, since readers are not trusted, unless a seal prevents
 * writing. Only the kernel is asked for the file type, so a hanging file system does not block. */
static lf_status check_descriptor(const char *path, int fd, lf_error *err)
{
    struct statx st;
    const int flags = fcntl(fd, F_GETFL), seals = fcntl(fd, F_GET_SEALS);
    const bool sealed = seals > 0 && (seals & F_SEAL_WRITE) != 0 && (flags & O_ACCMODE) == O_RDWR;
    if (flags < 0 || (flags & O_PATH) != 0 || ((flags & O_ACCMODE) != O_RDONLY && !sealed))
        return lf_error_set(err, LF_E_ARG, path, "its descriptor must be open for reading only");
    if (statx(fd, "", AT_EMPTY_PATH | AT_STATX_DONT_SYNC, STATX_TYPE, &st) != 0 ||
        !S_ISREG(st.stx_mode))
        return lf_error_set(err, LF_E_ARG, path, "its descriptor must be a regular file");
    return LF_OK;
}

/* Adds what was checked, under a name that is new; on LF_OK takes fd. */
static lf_status add(lf_passed *passed, const char *name, int fd, passed_file **out, lf_error *err)
{
    if (passed->n == LF_MAX_PASSED)
        return lf_error_set(err, LF_E_ARG, name, "more than %d files were passed; pass fewer",
                            LF_MAX_PASSED);
    if (atomic_fetch_add(&n_held, 1) >= LF_MAX_PASSED_ALL) {
        atomic_fetch_sub(&n_held, 1);
        return lf_error_set(err, LF_E_BUSY, name,
                            "quiltd already holds %d passed files; try again later",
                            LF_MAX_PASSED_ALL);
    }
    passed_file *file = lf_calloc(1, sizeof *file);
    char *copy = lf_strdup(name);
    if (!file || !copy) {
        atomic_fetch_sub(&n_held, 1);
        lf_free(file);
        lf_free(copy);
        return lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    }
    *file = (passed_file){.fd = fd, .path = copy, .copy = -1};
    atomic_init(&file->references, 1);
    pthread_mutex_init(&file->lock, NULL);
    atomic_init(&passed->opened[passed->n], false);
    passed->file[passed->n++] = file;
    *out = file;
    return LF_OK;
}

lf_status lf_passed_add(lf_passed *passed, const char *path, int fd, lf_error *err)
{
    passed_file *file;
    lf_status status = check_path(passed, path, err);
    if (status == LF_OK)
        status = check_descriptor(path, fd, err);
    return status == LF_OK ? add(passed, path, fd, &file, err) : status;
}

/* ------------------------------------------------------------------------------------ arrays -- */

static lf_status check_array_name(const lf_passed *passed, const char *name, lf_error *err)
{
    const size_t n = strlen(name);
    if (n < 1 || n > LF_MAX_ARRAY_NAME || strchr(name, '/'))
        return lf_error_set(err, LF_E_ARG, name,
                            "an array needs a name of 1 to %d bytes without \"/\"",
                            LF_MAX_ARRAY_NAME);
    return find_name(passed, name) < 0
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, name, "the array was passed twice");
}

#define MOST_ARRAY_BYTES ((uint64_t)16 << 30) /* as of volume files */

/* The seals make the size that was checked the size that is read, and keep the client from changing
 * values that were checked. */
static lf_status check_array_file(const char *name, const lf_array *array, int fd, lf_error *err)
{
    const int needed = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW, seals = fcntl(fd, F_GET_SEALS),
              flags = fcntl(fd, F_GETFL);
    const uint64_t bytes = lf_array_bytes(array);
    struct stat st;
    char words[LF_ARRAY_TEXT];
    if (seals < 0 || (seals & needed) != needed || fstat(fd, &st) != 0)
        return lf_error_set(err, LF_E_ARG, name,
                            "its descriptor must be a memory file (memfd_create) with the seals "
                            "F_SEAL_WRITE, F_SEAL_SHRINK and F_SEAL_GROW");
    if (flags < 0 || (flags & O_ACCMODE) == O_WRONLY)
        return lf_error_set(err, LF_E_ARG, name, "its descriptor must be open for reading");
    if (bytes == 0)
        return lf_error_set(err, LF_E_ARG, name,
                            "its shape has a length below 1, or more values than a file can hold");
    if (bytes > MOST_ARRAY_BYTES)
        return lf_error_set(err, LF_E_ARG, name, "its values have more than %d GiB",
                            (int)(MOST_ARRAY_BYTES >> 30));
    if ((uint64_t)st.st_size != bytes)
        return lf_error_set(err, LF_E_ARG, name, "its file has %jd bytes; %s have %ju",
                            (intmax_t)st.st_size, lf_array_text(array, words), (uintmax_t)bytes);
    /* Reading a hole through a mapping would take memory that its sender never had to have. */
    if ((uint64_t)st.st_blocks * 512 < (uint64_t)st.st_size)
        return lf_error_set(err, LF_E_ARG, name,
                            "its memory file has holes; write all of its values");
    return LF_OK;
}

lf_status lf_passed_add_array(lf_passed *passed, const char *name, const lf_array *array, int fd,
                              lf_error *err)
{
    passed_file *file;
    lf_status status = check_array_name(passed, name, err);
    if (status == LF_OK)
        status = check_array_file(name, array, fd, err);
    if (status == LF_OK)
        status = add(passed, name, fd, &file, err);
    if (status == LF_OK)
        file->array = *array;
    return status;
}

lf_status lf_passed_open_array(lf_passed *passed, const char *name, const lf_array *wanted,
                               lf_array *out, int *out_fd, lf_error *err)
{
    const int i = strchr(name, '/') ? -1 : find_name(passed, name);
    char is[LF_ARRAY_TEXT], needs[LF_ARRAY_TEXT];
    if (i < 0)
        return lf_error_set(err, LF_E_IO, name,
                            "no array of this name was passed; pass it in \"arrays\" of the call");
    const passed_file *file = passed->file[i];
    atomic_store(&passed->opened[i], true);
    if (wanted && !lf_array_is(&file->array, wanted))
        return lf_error_set(err, LF_E_FORMAT, name, "the array has %s; expected %s",
                            lf_array_text(&file->array, is), lf_array_text(wanted, needs));
    const int fd = fcntl(file->fd, F_DUPFD_CLOEXEC, 0);
    if (fd < 0)
        return lf_error_set(err, LF_E_IO, name, "cannot open: %s", lf_errno_text(errno));
    *out = file->array;
    *out_fd = fd;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- joins -- */

/* Counts the files of older to keep: those not named by newer; `opened`: only those that were
 * opened. */
static int count(const lf_passed *older, const lf_passed *newer, bool opened)
{
    int n = 0;
    for (int i = 0; older && i < older->n; i++)
        n += (!opened || atomic_load(&older->opened[i])) &&
             find_name(newer, older->file[i]->path) < 0;
    return n;
}

lf_status lf_passed_join(const lf_passed *older, const lf_passed *newer, lf_passed **out,
                         lf_error *err)
{
    const int n = newer ? newer->n : 0;
    const bool crowded = n + count(older, newer, false) > LF_MAX_PASSED;
    if (n + count(older, newer, crowded) > LF_MAX_PASSED)
        return lf_error_set(err, LF_E_ARG, newer ? newer->file[0]->path : "",
                            "more than %d files were passed to this scene; reload it (scene.load) "
                            "or start quiltd with --allow-path DIR",
                            LF_MAX_PASSED);
    lf_passed *joined = lf_passed_create();
    if (!joined)
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    for (int i = 0; i < n; i++)
        share(joined, newer->file[i]);
    for (int i = 0; older && i < older->n; i++)
        if ((!crowded || atomic_load(&older->opened[i])) &&
            find_name(newer, older->file[i]->path) < 0)
            share(joined, older->file[i]);
    *out = joined;
    return LF_OK;
}

void lf_passed_drop_unopened(lf_passed *passed, const lf_passed *newer)
{
    int kept = 0;
    for (int i = 0; i < passed->n; i++) {
        const bool opened = atomic_load(&passed->opened[i]);
        if (!opened && find_name(newer, passed->file[i]->path) >= 0) {
            file_unref(passed->file[i]);
            continue;
        }
        passed->file[kept] = passed->file[i];
        atomic_store(&passed->opened[kept++], opened);
    }
    passed->n = kept;
}

/* ----------------------------------------------------------------------------------- opening -- */

/* Opens a separate open file description. */
static int reopen(int fd)
{
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    return open(link, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
}

static lf_status fail_errno(lf_error *err, const char *path, const char *what)
{
    return lf_error_set(err, LF_E_IO, path, "%s: %s", what, lf_errno_text(errno));
}

static bool write_all(int fd, const char *data, size_t n)
{
    for (size_t done = 0; done < n;) {
        const ssize_t written = write(fd, data + done, n - done);
        if (written < 0 && errno != EINTR)
            return false;
        done += written > 0 ? (size_t)written : 0;
    }
    return true;
}

/* pread, because the offset is shared with the client. */
static lf_status copy_bytes(passed_file *file, int to, char *chunk, lf_error *err)
{
    for (off_t at = 0;;) {
        bool (*stopped)(void) = atomic_load(&is_stopped);
        if (stopped && stopped())
            return lf_error_set(err, LF_E_CANCELLED, file->path, "reading was stopped");
        const ssize_t got = pread(file->fd, chunk, COPY_BYTES, at);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return fail_errno(err, file->path, "cannot read");
        if (got == 0)
            return LF_OK;
        at += got;
        file->copied += (uint64_t)got;
        if (atomic_fetch_add(&n_copied, (uint64_t)got) + (uint64_t)got > LF_MAX_PASSED_COPY)
            return lf_error_set(err, LF_E_FORMAT, file->path,
                                "quiltd's user may not read the file, and copies of such files "
                                "exceed %d MiB; make it readable with chmod o+r",
                                (int)(LF_MAX_PASSED_COPY >> 20));
        if (!write_all(to, chunk, (size_t)got))
            return fail_errno(err, file->path, "cannot be copied into memory");
    }
}

/* Copies once; called under the lock. */
static lf_status make_copy(passed_file *file, lf_error *err)
{
    if (file->copy >= 0)
        return LF_OK;
    char *chunk = lf_calloc(1, COPY_BYTES);
    const int fd = memfd_create("quiltd-passed", MFD_CLOEXEC);
    lf_status status = !chunk   ? lf_error_set(err, LF_E_NOMEM, file->path, "out of memory")
                       : fd < 0 ? fail_errno(err, file->path, "cannot be copied into memory")
                                : copy_bytes(file, fd, chunk, err);
    lf_free(chunk);
    if (status == LF_OK)
        file->copy = fd;
    else
        drop_copy(file, fd);
    return status;
}

static lf_status open_copy(passed_file *file, int *out_fd, lf_error *err)
{
    pthread_mutex_lock(&file->lock);
    lf_status status = make_copy(file, err);
    const int fd = status == LF_OK ? reopen(file->copy) : -1;
    if (status == LF_OK && fd < 0)
        status = fail_errno(err, file->path, "cannot open");
    pthread_mutex_unlock(&file->lock);
    if (status == LF_OK)
        *out_fd = fd;
    return status;
}

lf_status lf_passed_open(lf_passed *passed, const char *path, int *out_fd, lf_error *err)
{
    const int i = find(passed, path);
    if (i < 0)
        return lf_error_set(err, LF_E_PATH, path, "was not passed");
    passed_file *file = passed->file[i];
    atomic_store(&passed->opened[i], true);
    const int fd = reopen(file->fd);
    if (fd < 0 && errno != EACCES && errno != EPERM && errno != ELOOP)
        return fail_errno(err, path, "cannot open");
    if (fd < 0)
        return open_copy(file, out_fd, err);
    *out_fd = fd;
    return LF_OK;
}
