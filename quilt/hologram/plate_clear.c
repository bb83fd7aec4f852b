/* Files of an earlier plate in a folder. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/number.h"
#include "quilt/hologram/plate.h"

/* ------------------------------------------------------------------------------------- names -- */

/* Names such as c0007.png: a prefix, a number of so many digits, and one of the endings. */
typedef struct rule {
    const char *prefix;
    int digits; /* larger numbers have more */
    int below;  /* numbers are smaller than this */
    const char *const *endings;
} rule;

/* The names that a plate can have; no number is below 0. */
typedef struct names {
    rule views, view_row, view, hogel_row, hogel, row;
    bool has_field;
} names;

static const char *const plain[] = {"", NULL}, *const png[] = {".png", NULL},
                         *const tif[] = {".tif", NULL}, *const exr[] = {".exr", NULL},
                         *const pictures[] = {".png", ".tif", ".exr", NULL},
                         *const rows[] = {".raw", ".json", NULL};

static names names_of(int v, int u, int hy, int hx, const char *const *endings)
{
    const int64_t all = (int64_t)v * u;
    return (names){.views = {"view_", 4, (int)(all < INT_MAX ? all : INT_MAX), endings},
                   .view_row = {"r", 3, v, plain},
                   .view = {"c", 4, u, endings},
                   .hogel_row = {"r", 4, hy, plain},
                   .hogel = {"c", 4, hx, endings},
                   .row = {"r", 3, INT_MAX, rows}};
}

/* Of a plate of any size, form and format. */
static names any_names(void)
{
    names made = names_of(INT_MAX, INT_MAX, INT_MAX, INT_MAX, pictures);
    made.views.digits = made.view_row.digits = made.view.digits = 0;
    made.hogel_row.digits = made.hogel.digits = made.row.digits = 0;
    made.has_field = true;
    return made;
}

/* Both numbers of a member such as "directions": [u, v]; false: it has none. */
static bool read_pair(const json_t *plate, const char *key, int out[2])
{
    for (size_t i = 0; i < 2; i++) {
        const json_int_t n = json_integer_value(json_array_get(json_object_get(plate, key), i));
        if (n < 1 || n > INT_MAX)
            return false;
        out[i] = (int)n;
    }
    return true;
}

/* What plate.json says of its files; false: it is of no plate. */
static bool read_names(const json_t *plate, names *out)
{
    const char *form = json_string_value(json_object_get(plate, "form"));
    const json_t *samples = json_object_get(plate, "samples");
    const char *type = json_string_value(json_object_get(samples, "type"));
    int cells[2], directions[2];
    if (json_integer_value(json_object_get(plate, "quiltd_hologram")) != 1 || !form || !type ||
        !read_pair(plate, "hogels", cells) || !read_pair(plate, "directions", directions))
        return false;
    const bool is_views = strcmp(form, lf_plate_forms[LF_PLATE_VIEWS]) == 0,
               is_hogels = strcmp(form, lf_plate_forms[LF_PLATE_HOGELS]) == 0,
               is_byte = json_integer_value(json_object_get(samples, "bits")) == 8;
    const char *const *endings = strcmp(type, "half") == 0 ? exr : is_byte ? png : tif;
    *out = names_of(is_views ? directions[1] : 0, is_views ? directions[0] : 0,
                    is_hogels ? cells[1] : 0, is_hogels ? cells[0] : 0, endings);
    if (directions[0] == 1 || directions[1] == 1)
        out->view_row.below = 0;
    else
        out->views.below = 0;
    out->has_field = strcmp(form, lf_plate_forms[LF_PLATE_RAW]) == 0;
    return true;
}

static bool is_of(const rule *of, const char *name)
{
    const size_t n = strlen(of->prefix), wide = (size_t)of->digits;
    uint64_t number;
    if (strncmp(name, of->prefix, n) != 0)
        return false;
    const size_t digits = strspn(name + n, "0123456789");
    if (wide == 0 ? digits < 3 : digits < wide || (digits > wide && name[n] == '0'))
        return false;
    if (digits > 9 || !lf_whole_read(name + n, &number) || number >= (uint64_t)of->below)
        return false;
    for (int i = 0; of->endings[i]; i++)
        if (strcmp(name + n + digits, of->endings[i]) == 0)
            return true;
    return false;
}

/* -------------------------------------------------------------------------------------- walk -- */

/* A walk over the files of a plate. */
typedef struct walk {
    const char *folder;
    const names *names;
    bool removes; /* the files */
    bool stops;   /* at the first file */
    char found[LF_PLATE_NAME];
    lf_status status;
    lf_error *err;
} walk;

static bool goes_on(const walk *w)
{
    return w->status == LF_OK && (!w->stops || w->found[0] == '\0');
}

static void fail(walk *w, const char *what, const char *within, const char *name)
{
    const bool is_link = errno == ELOOP || errno == ENOTDIR;
    w->status = lf_error_set(w->err, LF_E_IO, w->folder, "cannot %s %s%s: %s", what, within, name,
                             is_link ? "it is a link or no folder" : lf_errno_text(errno));
}

static void take(walk *w, int dir, const char *within, const char *name)
{
    if (w->found[0] == '\0')
        snprintf(w->found, sizeof w->found, "%.30s%.30s", within, name);
    if (w->removes && unlinkat(dir, name, 0) != 0 && errno != ENOENT)
        fail(w, "remove", within, name);
}

/* NULL: it is not there, or the walk has failed. */
static DIR *open_folder(walk *w, int parent, const char *within, const char *name)
{
    const int follow = parent == AT_FDCWD ? 0 : O_NOFOLLOW,
              fd = openat(parent, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | follow);
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    if (!dir && errno != ENOENT)
        fail(w, "look into", within, name);
    if (fd >= 0 && !dir)
        close(fd);
    return dir;
}

static const struct dirent *next(walk *w, DIR *dir, const char *within)
{
    errno = 0;
    const struct dirent *e = goes_on(w) ? readdir(dir) : NULL;
    if (!e && errno != 0)
        fail(w, "read", within, "");
    return e;
}

/* The files of a rule in one folder, which is removed if nothing is left. */
static void sweep(walk *w, int parent, const char *outside, const char *name, const rule *of)
{
    char within[LF_PLATE_NAME];
    DIR *dir = goes_on(w) ? open_folder(w, parent, outside, name) : NULL;
    if (!dir)
        return;
    snprintf(within, sizeof within, "%.20s%.20s/", outside, name);
    for (const struct dirent *e; (e = next(w, dir, within));)
        if (is_of(of, e->d_name))
            take(w, dirfd(dir), within, e->d_name);
    closedir(dir);
    if (w->removes)
        unlinkat(parent, name, AT_REMOVEDIR);
}

/* The folders of rows in a folder, then files beside them. */
static void sweep_rows(walk *w, int parent, const char *name, const rule *row, const rule *picture)
{
    char within[LF_PLATE_NAME];
    DIR *dir = goes_on(w) ? open_folder(w, parent, "", name) : NULL;
    if (!dir)
        return;
    snprintf(within, sizeof within, "%.20s/", name);
    for (const struct dirent *e; (e = next(w, dir, within));)
        if (is_of(row, e->d_name))
            sweep(w, dirfd(dir), within, e->d_name, picture);
    closedir(dir);
    if (w->removes)
        unlinkat(parent, name, AT_REMOVEDIR);
}

/* What says that a plate is complete goes first. */
static void walk_all(walk *w)
{
    const names *n = w->names;
    const char *const wholes[] = {"manifest.json", n->has_field ? "plate.raw" : NULL};
    DIR *dir = open_folder(w, AT_FDCWD, "", w->folder);
    if (!dir)
        return;
    const int fd = dirfd(dir);
    for (int i = 0; i < 2 && wholes[i] && goes_on(w); i++)
        if (faccessat(fd, wholes[i], F_OK, AT_SYMLINK_NOFOLLOW) == 0)
            take(w, fd, "", wholes[i]);
    sweep(w, fd, "", "rows", &n->row);
    sweep_rows(w, fd, "views", &n->view_row, &n->view);
    sweep(w, fd, "", "views", &n->views);
    sweep_rows(w, fd, "hogels", &n->hogel_row, &n->hogel);
    closedir(dir);
}

lf_status lf_plate_clear(const char *folder, const json_t *plate, lf_error *err)
{
    names of = {0};
    if (!read_names(plate, &of))
        return lf_error_set(err, LF_E_EXISTS, folder, "is no plate that quiltd knows");
    walk w = {.folder = folder, .names = &of, .err = err};
    walk_all(&w); /* all folders can be read */
    w.removes = true;
    if (w.status == LF_OK)
        walk_all(&w);
    return w.status;
}

/* ----------------------------------------------------------------------------- what is there -- */

static json_t *load(const char *folder, const char *name)
{
    json_t *there = lf_plate_load(folder, name);
    names of;
    if (read_names(there, &of))
        return there;
    json_decref(there);
    return NULL;
}

static lf_status find_file(const char *folder, char out[static LF_PLATE_NAME], lf_error *err)
{
    const names any = any_names();
    walk w = {.folder = folder, .names = &any, .stops = true, .err = err};
    char *path = lf_path_join(folder, "plate.json");
    if (path && faccessat(AT_FDCWD, path, F_OK, AT_SYMLINK_NOFOLLOW) == 0)
        snprintf(w.found, sizeof w.found, "plate.json");
    else
        walk_all(&w);
    lf_free(path);
    memcpy(out, w.found, sizeof w.found);
    return w.status;
}

/* Tasks that begin at the same time may see plate.json late. */
lf_status lf_plate_find(const char *folder, json_t **out, bool *out_is_manifest, lf_error *err)
{
    char name[LF_PLATE_NAME] = "";
    *out = load(folder, "plate.json");
    *out_is_manifest = false;
    if (*out)
        return LF_OK;
    const lf_status status = find_file(folder, name, err);
    if (status != LF_OK || name[0] == '\0')
        return status;
    *out = load(folder, "plate.json");
    if (!*out && strcmp(name, "manifest.json") == 0) {
        *out = load(folder, name);
        *out_is_manifest = *out;
    }
    return *out ? LF_OK
                : lf_error_set(err, LF_E_EXISTS, folder,
                               "has %s, which is of no plate that quiltd knows; choose another "
                               "folder",
                               name);
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
