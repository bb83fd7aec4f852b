#include "base/paths.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"

#define HANDLE (O_PATH | O_CLOEXEC)

const char *lf_hidden_home(const char *path)
{
    static const char *const homes[] = {"/home/", "/root/", "/run/user/"};
    bool beneath = false;
    for (int i = 0; i < 3; i++)
        beneath = beneath || strncmp(path, homes[i], strlen(homes[i])) == 0;
    /* /home of a sandbox is empty and inaccessible; any other can be entered */
    return beneath && access("/home", X_OK) != 0 && errno == EACCES
               ? " (the service cannot see home folders; put the file below /srv, or see PATHS in "
                 "quiltd(1))"
               : "";
}

lf_status lf_say_outside(const char *path, lf_error *err)
{
    return lf_error_set(err, LF_E_PATH, path,
                        "is outside the folders that quiltd may read; start quiltd with "
                        "--allow-path DIR%s",
                        lf_hidden_home(path));
}

static lf_status fail_errno(lf_error *err, const char *path, const char *what)
{
    int e = errno;
    const char *hint = lf_hidden_home(path);
    return lf_error_set(err, e == ENOMEM ? LF_E_NOMEM : LF_E_IO, path, "%s: %s%s", what,
                        lf_errno_text(e), hint);
}

static lf_status no_memory(lf_error *err, const char *path)
{
    return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

/* --------------------------------------------------------------------------------- mechanism -- */

static bool is_part(const char *part, size_t n)
{
    bool dots = (n == 1 && part[0] == '.') || (n == 2 && part[0] == '.' && part[1] == '.');
    return n > 0 && n <= NAME_MAX && !dots;
}

/* The form of names that both mechanisms treat equally. */
static bool is_canonical(const char *name)
{
    if (strcmp(name, ".") == 0)
        return true;
    for (;; name++) {
        size_t n = strcspn(name, "/");
        if (!is_part(name, n))
            return false;
        name += n;
        if (name[0] == '\0')
            return true;
    }
}

/* With O_PATH a link itself is opened, which is refused as with any other flag. */
static int refuse_link(int fd)
{
    struct stat st;
    if (fd >= 0 && fstat(fd, &st) == 0 && S_ISLNK(st.st_mode)) {
        close(fd);
        errno = ELOOP;
        return -1;
    }
    return fd;
}

int lf_beneath_walk(int folder_fd, const char *name, int flags)
{
    assert((flags & O_CREAT) == 0); /* no mode parameter */
    if (!is_canonical(name)) {
        errno = EXDEV;
        return -1;
    }
    int at = folder_fd;
    for (const char *slash; at >= 0 && (slash = strchr(name, '/')); name = slash + 1) {
        char part[NAME_MAX + 1] = {0};
        memcpy(part, name, (size_t)(slash - name));
        int next = openat(at, part, HANDLE | O_DIRECTORY | O_NOFOLLOW);
        int why = errno;
        if (at != folder_fd)
            close(at);
        errno = why;
        at = next;
    }
    if (at < 0)
        return -1;
    int fd = refuse_link(openat(at, name, flags | O_NOFOLLOW | O_CLOEXEC));
    int why = errno;
    if (at != folder_fd)
        close(at);
    errno = why;
    return fd;
}

int lf_beneath_open(int folder_fd, const char *name, int flags)
{
    struct open_how how = {.flags = (unsigned)(flags | O_CLOEXEC),
                           .resolve =
                               RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS};
    if (!is_canonical(name)) {
        errno = EXDEV;
        return -1;
    }
    int fd = (int)syscall(SYS_openat2, folder_fd, name, &how, sizeof how);
    return fd < 0 && (errno == ENOSYS || errno == EPERM) ? lf_beneath_walk(folder_fd, name, flags)
                                                         : refuse_link(fd);
}

/* Opens a folder by its canonical absolute name. */
static int open_root(const char *root)
{
    int top = open("/", HANDLE | O_DIRECTORY);
    int fd = top >= 0 ? lf_beneath_open(top, root[1] != '\0' ? root + 1 : ".", O_PATH | O_DIRECTORY)
                      : -1;
    int why = errno;
    if (top >= 0)
        close(top);
    errno = why;
    return fd;
}

/* The part of the canonical `path` after the canonical `root`; NULL = not inside. */
static const char *behind(const char *root, const char *path)
{
    size_t n = strcmp(root, "/") == 0 ? 0 : strlen(root);
    if (strncmp(path, root, n) != 0 || (path[n] != '/' && path[n] != '\0'))
        return NULL;
    return path[n] == '\0' || path[n + 1] == '\0' ? "." : path + n + 1;
}

/* True if opening a canonical name failed because it was replaced. */
static bool was_swapped(int why)
{
    return why == ELOOP || why == EXDEV || why == ENOTDIR;
}

/* Opens the canonical `path` inside the canonical `root`; -1 and errno. */
static int open_behind(const char *root, const char *path, int flags)
{
    int root_fd = open_root(root);
    int fd = root_fd >= 0 ? lf_beneath_open(root_fd, behind(root, path), flags) : -1;
    int why = errno;
    if (root_fd >= 0)
        close(root_fd);
    errno = why;
    return fd;
}

/* ------------------------------------------------------------------------------------- roots -- */

lf_status lf_roots_add(lf_roots *roots, const char *folder, lf_error *err)
{
    struct stat st;
    char real[PATH_MAX];
    if (!realpath(folder, real) || stat(real, &st) != 0)
        return fail_errno(err, folder, "cannot open the folder");
    if (!S_ISDIR(st.st_mode))
        return lf_error_set(err, LF_E_ARG, folder, "not a folder");
    for (int i = 0; i < roots->n_roots; i++)
        if (strcmp(roots->root[i], real) == 0)
            return LF_OK;
    if (roots->n_roots == LF_MAX_ROOTS)
        return lf_error_set(err, LF_E_ARG, folder, "too many folders; expected at most %d",
                            LF_MAX_ROOTS);
    char *copy = lf_strdup(real);
    if (!copy)
        return no_memory(err, folder);
    roots->root[roots->n_roots++] = copy;
    return LF_OK;
}

void lf_roots_finish(lf_roots *roots)
{
    for (int i = 0; i < roots->n_roots; i++)
        lf_free(roots->root[i]);
    *roots = (lf_roots){0};
}

/* The root that contains the canonical path; NULL = none. */
static const char *root_of(const lf_roots *roots, const char *path)
{
    for (int i = 0; i < roots->n_roots; i++)
        if (behind(roots->root[i], path))
            return roots->root[i];
    return NULL;
}

/* True inside a root, and for parents of a root: their existence is no secret. */
static bool is_known(const lf_roots *roots, const char *path)
{
    char real[PATH_MAX];
    if (!realpath(path, real))
        return false;
    for (int i = 0; i < roots->n_roots; i++)
        if (behind(roots->root[i], real) || behind(real, roots->root[i]))
            return true;
    return false;
}

/* Appends part[n] to the name `to`. ".." removes the part before it if that is an unknown folder.
 * False: too long. */
static bool add_part(const lf_roots *roots, char to[static PATH_MAX], const char *part, size_t n)
{
    size_t used = strlen(to);
    char *last = strrchr(to, '/');
    bool up = n == 2 && memcmp(part, "..", 2) == 0;
    if (up && last && last[1] != '\0' && strcmp(last, "/..") != 0 && !is_known(roots, to)) {
        *last = '\0';
        return true;
    }
    if (used + n + 2 > PATH_MAX)
        return false;
    snprintf(to + used, PATH_MAX - used, "/%.*s", (int)n, part);
    return true;
}

/* Folders outside the roots are not accessed to resolve "..": "FOLDER/.." is removed whether or not
 * FOLDER exists. Otherwise a name that returns to the roots would reveal FOLDER's existence. */
static bool leave_out_detours(const lf_roots *roots, const char *path, char out[static PATH_MAX])
{
    if (path[0] == '/')
        out[0] = '\0';
    else
        snprintf(out, PATH_MAX, ".");
    for (const char *part = path; part[0] != '\0';) {
        part += strspn(part, "/");
        size_t n = strcspn(part, "/");
        bool nothing = n == 0 || (n == 1 && part[0] == '.');
        if (!nothing && !add_part(roots, out, part, n))
            return false;
        part += n;
    }
    if (out[0] == '\0')
        snprintf(out, PATH_MAX, "/");
    return true;
}

/* True if a path that does not exist (or cannot be opened) would be inside the roots. The nearest
 * existing parent decides; a dangling link may lead outside. Otherwise two different errors would
 * reveal which files exist outside. */
static bool would_lie_beneath(const lf_roots *roots, const char *path)
{
    char above[PATH_MAX], real[PATH_MAX];
    struct stat st;
    snprintf(above, sizeof above, "%s", path);
    for (;;) {
        if (lstat(above, &st) == 0 && S_ISLNK(st.st_mode))
            return false;
        char *slash = strrchr(above, '/');
        if (!slash)
            return realpath(".", real) && root_of(roots, real);
        if (slash == above)
            return root_of(roots, "/");
        *slash = 0;
        if (realpath(above, real))
            return root_of(roots, real);
    }
}

/* Resolves path. LF_E_PATH: outside the roots, whether or not it exists; LF_E_IO and errno: it does
 * not exist. */
static lf_status find(const lf_roots *roots, const char *path, char real[static PATH_MAX])
{
    char plain[PATH_MAX];
    if (roots->n_roots == 0)
        return realpath(path, real) ? LF_OK : LF_E_IO;
    if (strlen(path) >= PATH_MAX)
        return LF_E_PATH;
    snprintf(plain, sizeof plain, "%s", path);
    if (strstr(path, "..") && !leave_out_detours(roots, path, plain))
        return LF_E_PATH;
    if (realpath(plain, real))
        return root_of(roots, real) ? LF_OK : LF_E_PATH;
    int why = errno;
    bool beneath = would_lie_beneath(roots, plain);
    errno = why;
    return beneath ? LF_E_IO : LF_E_PATH;
}

/* Sets the error, with the remedies of a daemon (closed). One is that the client that passed the
 * file has left. */
static lf_status outside(const lf_roots *roots, lf_error *err, const char *path)
{
    if (!roots->closed)
        return lf_error_set(
            err, LF_E_PATH, path,
            "outside the folders that may be read; allow one more with --allow-path DIR");
    return lf_error_set(err, LF_E_PATH, path,
                        "outside the folders that quiltd may read; load the scene with quiltctl, "
                        "again if needed, or start quiltd with --allow-path DIR");
}

static lf_status resolve(const lf_roots *roots, const char *path, char real[static PATH_MAX],
                         lf_error *err)
{
    lf_status status = find(roots, path, real);
    if (status == LF_E_IO)
        return fail_errno(err, path, "cannot open");
    return status == LF_OK ? LF_OK : outside(roots, err, path);
}

lf_status lf_roots_resolve(const lf_roots *roots, const char *path, char **out_path, lf_error *err)
{
    char real[PATH_MAX];
    lf_status status = resolve(roots, path, real, err);
    if (status != LF_OK && lf_passed_has(roots->passed, path) && lf_passed_name(path, real))
        status = LF_OK;
    if (status != LF_OK)
        return status;
    char *copy = lf_strdup(real);
    if (!copy)
        return no_memory(err, path);
    *out_path = copy;
    return LF_OK;
}

/* O_PATH does not open the file itself: devices are not triggered, FIFOs do not wait. */
static lf_status open_handle(const lf_roots *roots, const char *path, mode_t kind, int *out_handle,
                             lf_error *err)
{
    char real[PATH_MAX];
    struct stat st;
    assert(roots->n_roots > 0);
    lf_status status = resolve(roots, path, real, err);
    if (status != LF_OK)
        return status;
    int handle = open_behind(root_of(roots, real), real, HANDLE);
    if (handle < 0 && was_swapped(errno))
        return outside(roots, err, path);
    if (handle < 0)
        return fail_errno(err, path, "cannot open");
    if (fstat(handle, &st) != 0 || (st.st_mode & S_IFMT) != kind) {
        close(handle);
        return lf_error_set(err, LF_E_FORMAT, path,
                            kind == S_IFDIR ? "not a folder" : "not a regular file");
    }
    *out_handle = handle;
    return LF_OK;
}

/* Opens a file inside a root. */
static lf_status open_file(const lf_roots *roots, const char *path, int *out_fd, lf_error *err)
{
    char link[64];
    int handle;
    lf_status status = open_handle(roots, path, S_IFREG, &handle, err);
    if (status != LF_OK)
        return status;
    snprintf(link, sizeof link, "/proc/self/fd/%d", handle);
    int fd = open(link, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0)
        status = fail_errno(err, path, "cannot open");
    else
        *out_fd = fd;
    close(handle);
    return status;
}

lf_status lf_roots_open(const lf_roots *roots, const char *path, int *out_fd, lf_error *err)
{
    lf_status status = open_file(roots, path, out_fd, err);
    return status != LF_OK && lf_passed_has(roots->passed, path)
               ? lf_passed_open(roots->passed, path, out_fd, err)
               : status;
}

lf_status lf_roots_open_folder(const lf_roots *roots, const char *path, int *out_fd, lf_error *err)
{
    int handle = AT_FDCWD;
    lf_status status =
        roots && roots->n_roots > 0 ? open_handle(roots, path, S_IFDIR, &handle, err) : LF_OK;
    if (status != LF_OK)
        return status;
    int fd = openat(handle, handle >= 0 ? "." : path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        status = fail_errno(err, path, "cannot open the folder");
    else
        *out_fd = fd;
    if (handle >= 0)
        close(handle);
    return status;
}

/* ----------------------------------------------------------------------------------- writing -- */

/* Resolves the folder of the absolute `name`, whose last part begins at `last`. Like find. */
static lf_status find_folder(const char *root, const char *name, const char *last,
                             char real[static PATH_MAX])
{
    char above[PATH_MAX], copy[PATH_MAX];
    size_t n = (size_t)(last - name) - 1;
    if (n >= sizeof above)
        return LF_E_PATH;
    snprintf(copy, sizeof copy, "%s", root);
    const lf_roots roots = {.n_roots = 1, .root = {copy}};
    snprintf(above, sizeof above, "%.*s", n > 0 ? (int)n : 1, name);
    return find(&roots, above, real);
}

static bool is_link(int folder_fd, const char *name)
{
    struct stat st;
    return fstatat(folder_fd, name, &st, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(st.st_mode);
}

/* Opens the folder if `last` is a valid file or folder name; real: canonical. LF_E_PATH: invalid
 * name, folder not inside root, or replaced meanwhile; LF_E_IO and errno. */
static lf_status hold_folder(const char *root, const char *name, const char *last,
                             char real[static PATH_MAX], int *out_fd)
{
    lf_status status =
        is_part(last, strlen(last)) ? find_folder(root, name, last, real) : LF_E_PATH;
    if (status != LF_OK)
        return status;
    *out_fd = open_behind(root, real, O_PATH | O_DIRECTORY);
    if (*out_fd >= 0)
        return LF_OK;
    return was_swapped(errno) ? LF_E_PATH : LF_E_IO;
}

/* Control characters of ASCII and C1, and Unicode's ends of lines and paragraphs. */
static bool is_control(const unsigned char *c)
{
    return c[0] < ' ' || c[0] == 0x7f || (c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0) ||
           (c[0] == 0xe2 && c[1] == 0x80 && (c[2] == 0xa8 || c[2] == 0xa9));
}

lf_status lf_check_name(const char *path, lf_error *err)
{
    for (const unsigned char *c = (const unsigned char *)path; *c; c++)
        if (is_control(c))
            return lf_error_set(
                err, LF_E_ARG, path,
                "the name of an output must not contain control characters or line breaks");
    return LF_OK;
}

lf_status lf_check_stem(const char *path, const char *ending, lf_error *err)
{
    const char *slash = strrchr(path, '/'), *last = slash ? slash + 1 : path;
    const size_t n = strlen(last), m = strlen(ending);
    if (n <= m || strspn(last, ".") >= n - m)
        return lf_error_set(err, LF_E_ARG, path, "expected a file name before the ending %s",
                            ending);
    return lf_check_name(path, err);
}

/* folder "/" name, with the slash that a folder of views ends in. */
static char *join(const char *folder, const char *name, const char *slash)
{
    size_t size = strlen(folder) + strlen(name) + 3;
    char *joined = lf_calloc(size, 1);
    if (joined)
        snprintf(joined, size, "%s/%s%s", strcmp(folder, "/") == 0 ? "" : folder, name, slash);
    return joined;
}

/* Removes trailing slashes from name; true: there were some. */
static bool cut_slashes(char *name)
{
    size_t n = strlen(name);
    bool any = n > 1 && name[n - 1] == '/';
    while (n > 1 && name[n - 1] == '/')
        name[--n] = '\0';
    return any;
}

lf_status lf_held_name_open(const char *root, const char *option, const char *path,
                            lf_held_name *out, lf_error *err)
{
    char real[PATH_MAX];
    lf_status plain = lf_check_name(path, err);
    if (plain != LF_OK)
        return plain;
    char *name = path[0] == '/' ? lf_strdup(path) : join(root, path, "");
    if (!name)
        return no_memory(err, path);
    const char *slash = cut_slashes(name) ? "/" : "", *last = strrchr(name, '/') + 1;
    lf_held_name held = {.folder_fd = -1};
    lf_status status = hold_folder(root, name, last, real, &held.folder_fd);
    if (status == LF_E_IO)
        status = lf_error_set(err, LF_E_PATH, path, "its folder cannot be opened: %s",
                              lf_errno_text(errno));
    else if (status != LF_OK)
        status = lf_error_set(err, LF_E_PATH, path, "outside the %s %s", option, root);
    else if (is_link(held.folder_fd, last))
        status = lf_error_set(err, LF_E_PATH, path,
                              "symbolic links are not overwritten; use another name");
    if (status == LF_OK)
        held.path = join(real, last, slash);
    if (status == LF_OK && !held.path)
        status = no_memory(err, path);
    lf_free(name);
    if (status != LF_OK)
        lf_held_name_finish(&held);
    else
        *out = held;
    return status;
}

void lf_held_name_finish(lf_held_name *held)
{
    if (held->folder_fd >= 0)
        close(held->folder_fd);
    lf_free(held->path);
    *held = (lf_held_name){.folder_fd = -1};
}

char *lf_held_path(int folder_fd, const char *name)
{
    char folder[64];
    snprintf(folder, sizeof folder, "/proc/self/fd/%d", folder_fd);
    return join(folder, name, "");
}

lf_status lf_held_folder(int folder_fd, const char *name, int *out_fd, bool *out_made,
                         lf_error *err)
{
    bool made = mkdirat(folder_fd, name, 0777) == 0;
    if (!made && errno != EEXIST)
        return fail_errno(err, name, "cannot make the folder");
    int fd = lf_beneath_open(folder_fd, name, O_PATH | O_DIRECTORY);
    if (fd < 0)
        return fail_errno(err, name, "cannot open the folder");
    *out_fd = fd;
    *out_made = made;
    return LF_OK;
}
