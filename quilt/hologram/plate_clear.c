/* Files of an earlier plate in a folder. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "quilt/hologram/plate.h"

/* A walk over the files of a plate. */
typedef struct walk {
    const char *folder;
    bool removes; /* otherwise it stops at the first file */
    char found[LF_PLATE_NAME];
    lf_status status;
    lf_error *err;
} walk;

/* A name such as r007.png: prefix, three digits or more, and one of the endings. */
static bool is_numbered(const char *name, const char *prefix, const char *const *endings)
{
    const size_t n = strlen(prefix);
    if (strncmp(name, prefix, n) != 0)
        return false;
    const size_t digits = strspn(name + n, "0123456789");
    for (int i = 0; digits >= 3 && endings[i]; i++)
        if (strcmp(name + n + digits, endings[i]) == 0)
            return true;
    return false;
}

static bool goes_on(const walk *w)
{
    return w->status == LF_OK && (w->removes || w->found[0] == '\0');
}

static void take(walk *w, int dir, const char *within, const char *name)
{
    if (w->found[0] == '\0')
        snprintf(w->found, sizeof w->found, "%.20s%.40s", within, name);
    if (w->removes && unlinkat(dir, name, 0) != 0 && errno != ENOENT)
        w->status = lf_error_set(w->err, LF_E_IO, w->folder, "cannot remove %s%s: %s", within, name,
                                 lf_errno_text(errno));
}

static DIR *open_folder(int parent, const char *name)
{
    const int fd = openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    if (fd >= 0 && !dir)
        close(fd);
    return dir;
}

/* The files with this prefix in one folder, which is removed if nothing is left. */
static void sweep(walk *w, int parent, const char *name, const char *prefix,
                  const char *const *endings)
{
    char within[64];
    DIR *dir = open_folder(parent, name);
    if (!dir)
        return;
    snprintf(within, sizeof within, "%s/", name);
    for (const struct dirent *e = readdir(dir); e && goes_on(w); e = readdir(dir))
        if (is_numbered(e->d_name, prefix, endings))
            take(w, dirfd(dir), within, e->d_name);
    closedir(dir);
    if (w->removes)
        unlinkat(parent, name, AT_REMOVEDIR);
}

/* The folders of rows in a folder. */
static void sweep_rows(walk *w, int parent, const char *name, const char *const *endings)
{
    static const char *const plain[] = {"", NULL};
    DIR *dir = open_folder(parent, name);
    if (!dir)
        return;
    for (const struct dirent *e = readdir(dir); e && goes_on(w); e = readdir(dir))
        if (is_numbered(e->d_name, "r", plain))
            sweep(w, dirfd(dir), e->d_name, "c", endings);
    closedir(dir);
}

/* What says that a plate is there goes first. */
static void walk_all(walk *w)
{
    static const char *const pictures[] = {".png", ".tif", ".exr", NULL},
                             *const rows[] = {".raw", ".json", NULL},
                             *const wholes[] = {"manifest.json", "plate.raw"};
    DIR *dir = open_folder(AT_FDCWD, w->folder);
    if (!dir)
        return;
    const int fd = dirfd(dir);
    for (int i = 0; i < 2 && goes_on(w); i++)
        if (faccessat(fd, wholes[i], F_OK, 0) == 0)
            take(w, fd, "", wholes[i]);
    if (goes_on(w))
        sweep(w, fd, "rows", "r", rows);
    if (goes_on(w))
        sweep_rows(w, fd, "views", pictures);
    if (goes_on(w))
        sweep(w, fd, "views", "view_", pictures);
    if (goes_on(w))
        sweep_rows(w, fd, "hogels", pictures);
    if (w->removes)
        unlinkat(fd, "hogels", AT_REMOVEDIR);
    closedir(dir);
}

lf_status lf_plate_clear(const char *folder, lf_error *err)
{
    walk w = {.folder = folder, .removes = true, .err = err};
    walk_all(&w);
    return w.status;
}

bool lf_plate_has_files(const char *folder, char out[static LF_PLATE_NAME])
{
    walk w = {.folder = folder};
    walk_all(&w);
    memcpy(out, w.found, sizeof w.found);
    return w.found[0] != '\0';
}

lf_status lf_plate_remove_file(const char *folder, const char *name, lf_error *err)
{
    char *path = lf_path_join(folder, name);
    lf_status status = LF_OK;
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (unlink(path) != 0 && errno != ENOENT)
        status = lf_error_set(err, LF_E_IO, path, "cannot remove it: %s", lf_errno_text(errno));
    lf_free(path);
    return status;
}
