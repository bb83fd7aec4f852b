#include "daemon/parts/library_list.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "daemon/media/movie.h"
#include "daemon/wire/rpc.h"
#include "quilt/quilt.h"
#include "render/render.h"

/* The start of a JSON file, in which a scene has its key "quiltd". */
#define HEAD_BYTES 16384

#define FOLDER "folder"
#define ENVIRONMENT "environment"

typedef struct item {
    char *name;
    bool is_folder;
    const char *kind;
    int64_t bytes; /* of a folder 0 */
    double modified;
} item;

typedef struct listing {
    const lf_roots *roots;
    const char *folder; /* canonical */
    int fd;             /* of the folder; not owned */
    bool for_show;      /* files for a slideshow alone */
    item items[LF_LIBRARY_ENTRIES];
    int n;
    bool more;
} listing;

/* ------------------------------------------------------------------------------------- kinds -- */

static bool is_float_ending(const char *ending)
{
    for (int i = 0; lf_image_float_ending(i); i++)
        if (strcasecmp(ending + 1, lf_image_float_ending(i)) == 0)
            return true;
    return false;
}

/* By the name; NULL: not shown. */
static const char *kind_of_name(const char *name)
{
    int columns, rows;
    double aspect;
    const char *image = lf_image_ending(name);
    if (lf_movie_ending(name))
        return "video";
    if (image && lf_layout_from_name(name, &columns, &rows, &aspect))
        return "quilt";
    if (image)
        return is_float_ending(image) ? ENVIRONMENT : "image";
    return lf_path_has_ending(name, ".json") ? "scene" : lf_alone_kind(name);
}

static bool has_scene_head(const char *head, size_t n)
{
    size_t at = n >= 3 && memcmp(head, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    while (at < n && isspace((unsigned char)head[at]))
        at++;
    return at < n && head[at] == '{' && memmem(head, n, "\"quiltd\"", 8);
}

/* Whether a JSON file looks like a scene; other programs' files do not. */
static bool is_scene(const lf_roots *roots, const char *path)
{
    int fd;
    char *head = lf_calloc(HEAD_BYTES, 1);
    bool is = false;
    if (head && lf_roots_open(roots, path, &fd, NULL) == LF_OK) {
        ssize_t n = pread(fd, head, HEAD_BYTES, 0);
        is = n > 0 && has_scene_head(head, (size_t)n);
        close(fd);
    }
    lf_free(head);
    return is;
}

/* ------------------------------------------------------------------------------------ a name -- */

/* A link is followed only within the roots. */
static bool follow_link(const lf_roots *roots, const char *path, struct stat *st)
{
    int fd;
    lf_status status = lf_roots_open(roots, path, &fd, NULL);
    if (status == LF_E_FORMAT)
        status = lf_roots_open_folder(roots, path, &fd, NULL);
    if (status != LF_OK)
        return false;
    bool followed = fstat(fd, st) == 0;
    close(fd);
    return followed;
}

/* False: it is not listed. */
static bool look_at(const listing *l, const char *name, item *out)
{
    struct stat st;
    char *path = lf_path_join(l->folder, name);
    bool listed = path && fstatat(l->fd, name, &st, AT_SYMLINK_NOFOLLOW) == 0;
    if (listed && S_ISLNK(st.st_mode))
        listed = follow_link(l->roots, path, &st);
    const bool is_folder = listed && S_ISDIR(st.st_mode);
    const char *kind = is_folder ? FOLDER : kind_of_name(name);
    listed = listed && kind && (is_folder || S_ISREG(st.st_mode)) &&
             !(l->for_show && (is_folder || strcmp(kind, ENVIRONMENT) == 0));
    if (listed && strcmp(kind, "scene") == 0)
        listed = is_scene(l->roots, path);
    lf_free(path);
    if (listed)
        *out = (item){.is_folder = is_folder,
                      .kind = kind,
                      .bytes = is_folder ? 0 : (int64_t)st.st_size,
                      .modified = (double)st.st_mtim.tv_sec + 1e-9 * (double)st.st_mtim.tv_nsec};
    return listed;
}

/* Folders first, then by name; numbers within names by their value. */
static int compare(const item *a, const item *b)
{
    if (a->is_folder != b->is_folder)
        return a->is_folder ? -1 : 1;
    const int order = strverscmp(a->name, b->name);
    return order != 0 ? order : strcmp(a->name, b->name);
}

/* Keeps the first entries. */
static bool insert(listing *l, const item *what, const char *name)
{
    item in = *what;
    in.name = lf_strdup(name);
    int low = 0, high = l->n;
    if (!in.name)
        return false;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (compare(&in, &l->items[middle]) < 0)
            high = middle;
        else
            low = middle + 1;
    }
    if (l->n == LF_LIBRARY_ENTRIES) {
        l->more = true;
        if (low == l->n) {
            lf_free(in.name);
            return true;
        }
        lf_free(l->items[--l->n].name);
    }
    memmove(&l->items[low + 1], &l->items[low], (size_t)(l->n - low) * sizeof in);
    l->items[low] = in;
    l->n++;
    return true;
}

static lf_status fail_memory(const char *folder, lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
}

static lf_status look_at_all(listing *l, DIR *dir, const lf_cancel *cancel, lf_error *err)
{
    const struct dirent *entry;
    item found;
    while (errno = 0, (entry = readdir(dir))) {
        if (atomic_load(cancel))
            return lf_error_set(err, LF_E_CANCELLED, l->folder, "cancelled");
        if (entry->d_name[0] == '.' || !look_at(l, entry->d_name, &found))
            continue;
        if (!insert(l, &found, entry->d_name))
            return fail_memory(l->folder, err);
    }
    return errno == 0 ? LF_OK
                      : lf_error_set(err, LF_E_IO, l->folder, "cannot be listed: %s",
                                     lf_errno_text(errno));
}

/* ---------------------------------------------------------------------------------- together -- */

/* NULL: the name is not UTF-8, or out of memory. */
static json_t *entry_json(const char *name, const char *path, const item *of)
{
    return json_pack("{s:s, s:s, s:s, s:I, s:f}", "name", name, "path", path, "kind", of->kind,
                     "bytes", (json_int_t)of->bytes, "modified", of->modified);
}

static void add_entry(json_t *entries, json_t *entry, size_t *bytes, bool *more)
{
    if (!entry)
        return;
    const size_t n = json_dumpb(entry, NULL, 0, JSON_COMPACT);
    if (*bytes + n <= LF_LIBRARY_BYTES)
        (void)json_array_append(entries, entry);
    else
        *more = true;
    *bytes += n;
    json_decref(entry);
}

static json_t *items_json(listing *l)
{
    json_t *entries = json_array();
    size_t bytes = 0;
    for (int i = 0; i < l->n; i++) {
        char *path = lf_path_join(l->folder, l->items[i].name);
        json_t *entry = path ? entry_json(l->items[i].name, path, &l->items[i]) : NULL;
        add_entry(entries, entry, &bytes, &l->more);
        lf_free(path);
    }
    return entries;
}

/* The roots that are folders; entries NULL: only their names. */
static json_t *roots_json(const lf_roots *roots, json_t *entries)
{
    json_t *names = json_array();
    for (int i = 0; i < roots->n_roots; i++) {
        const char *root = roots->root[i], *slash = strrchr(root, '/');
        struct stat st;
        if (stat(root, &st) != 0 || !S_ISDIR(st.st_mode))
            continue;
        const item of = {.kind = FOLDER, .modified = (double)st.st_mtim.tv_sec};
        json_t *entry = entry_json(slash && slash[1] ? slash + 1 : root, root, &of);
        if (entry)
            (void)json_array_append_new(names, json_string(root));
        if (entry && entries)
            (void)json_array_append(entries, entry);
        json_decref(entry);
    }
    return names;
}

static lf_status list_folder(listing *l, const char *folder, const lf_cancel *cancel, lf_error *err)
{
    char *real = NULL;
    lf_status status = lf_roots_resolve(l->roots, folder, &real, err);
    if (status == LF_OK)
        status = lf_roots_open_folder(l->roots, real, &l->fd, err);
    if (status != LF_OK) {
        lf_free(real);
        return status;
    }
    DIR *dir = fdopendir(l->fd);
    l->folder = real;
    if (!dir)
        close(l->fd);
    status = dir ? look_at_all(l, dir, cancel, err) : fail_memory(folder, err);
    if (dir)
        closedir(dir);
    return status;
}

static void destroy(listing *l)
{
    for (int i = 0; i < l->n; i++)
        lf_free(l->items[i].name);
    lf_free((char *)(uintptr_t)l->folder);
    lf_free(l);
}

lf_status lf_library_list_of(const lf_roots *roots, const char *folder, const lf_cancel *cancel,
                             json_t **out, lf_error *err)
{
    listing *l = lf_calloc(1, sizeof *l);
    json_t *entries = NULL, *names = NULL;
    if (!l)
        return fail_memory(folder ? folder : "", err);
    l->roots = roots;
    lf_status status = folder ? list_folder(l, folder, cancel, err) : LF_OK;
    if (status == LF_OK) {
        entries = folder ? items_json(l) : json_array();
        names = roots_json(roots, folder ? NULL : entries);
        *out = json_pack("{s:o, s:o, s:o, s:b}", "folder",
                         l->folder ? lf_rpc_text(l->folder) : json_null(), "folders", names,
                         "entries", entries, "more", (int)l->more);
        status = *out ? LF_OK : fail_memory(folder ? folder : "", err);
    }
    destroy(l);
    return status;
}

/* ---------------------------------------------------------------------------- for slideshows -- */

void lf_library_files_finish(lf_library_files *files)
{
    for (int i = 0; i < files->n; i++)
        lf_free(files->path[i]);
    lf_free((void *)files->path);
    lf_free(files->folder);
    *files = (lf_library_files){0};
}

static bool is_utf8(const char *name)
{
    json_t *text = json_string(name);
    json_decref(text);
    return text;
}

static lf_status take_files(const listing *l, lf_library_files *out)
{
    *out = (lf_library_files){.folder = lf_strdup(l->folder),
                              .path = lf_calloc((size_t)l->n + 1, sizeof *out->path),
                              .more = l->more};
    for (int i = 0; i < l->n && out->path && out->folder; i++) {
        if (!is_utf8(l->items[i].name))
            continue;
        out->path[out->n] = lf_path_join(l->folder, l->items[i].name);
        if (!out->path[out->n])
            return LF_E_NOMEM;
        out->n++;
    }
    return out->path && out->folder ? LF_OK : LF_E_NOMEM;
}

lf_status lf_library_files_of(const lf_roots *roots, const char *folder, const lf_cancel *cancel,
                              lf_library_files *out, lf_error *err)
{
    lf_library_files files = {0};
    listing *l = lf_calloc(1, sizeof *l);
    if (!l)
        return fail_memory(folder, err);
    l->roots = roots;
    l->for_show = true;
    lf_status status = list_folder(l, folder, cancel, err);
    if (status == LF_OK && take_files(l, &files) != LF_OK)
        status = fail_memory(folder, err);
    if (status == LF_OK && files.n == 0)
        status = lf_error_set(err, LF_E_FORMAT, folder,
                              "nothing in the folder can be shown; put pictures, quilts, scenes or "
                              "models into it");
    if (status == LF_OK)
        *out = files;
    else
        lf_library_files_finish(&files);
    destroy(l);
    return status;
}
