#include "daemon/engine/folder.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "daemon/media/movie.h"
#include "quilt/quilt.h"

static bool is_shown_by_name(const char *name)
{
    int columns, rows;
    double aspect;
    if (name[0] == '.')
        return false;
    return lf_path_has_ending(name, ".json") ||
           ((lf_image_ending(name) || lf_movie_ending(name)) &&
            lf_layout_from_name(name, &columns, &rows, &aspect));
}

static int to_show(const struct dirent *entry)
{
    return is_shown_by_name(entry->d_name) ? 1 : 0;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

/* Index of the entry `step` (not 0) after `name`, which may be missing. */
static int neighbour(struct dirent *const *entries, int n, const char *name, int step)
{
    int at = 0;
    while (at < n && strcmp(entries[at]->d_name, name) < 0)
        at++;
    bool there = at < n && strcmp(entries[at]->d_name, name) == 0;
    int next = at + step % n - (step > 0 && !there ? 1 : 0);
    return (next % n + n) % n;
}

static lf_status list_folder(const char *folder, const lf_roots *roots,
                             struct dirent ***out_entries, int *out_n, lf_error *err)
{
    int fd;
    lf_status status = lf_roots_open_folder(roots, folder, &fd, err);
    if (status != LF_OK)
        return status;
    *out_n = scandirat(fd, ".", out_entries, to_show, by_name);
    if (*out_n < 0)
        status = lf_error_set(err, LF_E_IO, folder, "cannot be read: %s", lf_errno_text(errno));
    close(fd);
    return status;
}

lf_status lf_folder_neighbour(const char *file, int step, const lf_roots *roots, char **out_path,
                              lf_error *err)
{
    const char *slash = strrchr(file, '/');
    const char *name = slash ? slash + 1 : file;
    if (!slash)
        return lf_error_set(err, LF_E_ARG, file,
                            "the scene was sent without a file, so no file is next to it");
    char *folder = lf_path_folder(file);
    if (!folder)
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    struct dirent **entries = NULL;
    int n = 0;
    lf_status status = list_folder(folder, roots, &entries, &n, err);
    if (status != LF_OK) {
        lf_free(folder);
        return status;
    }
    char *path = n > 0 ? lf_path_join(folder, entries[neighbour(entries, n, name, step)]->d_name)
                       : lf_strdup(file);
    for (int i = 0; i < n; i++)
        free(entries[i]);
    free(entries);
    lf_free(folder);
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    *out_path = path;
    return LF_OK;
}
