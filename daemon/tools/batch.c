#include "daemon/tools/batch.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/list.h"
#include "base/log.h"
#include "daemon/tools/batch_words.h"

#define MOST_PICTURES 1000000
/* Names of pictures that failed, in the last line. */
#define MOST_NAMES 8

typedef struct batch {
    const lf_rendering *start;
    const lf_render_arguments *arguments;
    struct dirent **names;
    int n, n_made, n_kept, n_failed;
    double begun;
    lf_progress_line line;
    lf_batch_words words;
    char failed[1024]; /* the first names */
} batch;

/* ------------------------------------------------------------------------------------- names -- */

static int is_picture(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && lf_image_ending(entry->d_name);
}

/* Leaves out folders that are named like pictures. */
static void drop_folders(batch *b)
{
    int n = 0;
    for (int i = 0; i < b->n; i++) {
        char *path = lf_path_join(b->arguments->scene, b->names[i]->d_name);
        struct stat info;
        if (path && stat(path, &info) == 0 && S_ISDIR(info.st_mode))
            free(b->names[i]);
        else
            b->names[n++] = b->names[i];
        lf_free(path);
    }
    b->n = n;
}

static lf_status list_pictures(batch *b, lf_error *err)
{
    const char *folder = b->arguments->scene;
    b->n = scandir(folder, &b->names, is_picture, versionsort);
    if (b->n < 0) {
        b->n = 0;
        return lf_error_set(err, LF_E_IO, folder, "cannot read the folder: %s",
                            lf_errno_text(errno));
    }
    drop_folders(b);
    if (b->n == 0)
        return lf_error_set(err, LF_E_FORMAT, folder, "the folder has no images");
    if (b->n > MOST_PICTURES)
        return lf_error_set(err, LF_E_FORMAT, folder, "the folder has more than %d images",
                            MOST_PICTURES);
    return LF_OK;
}

/* Length of a name without its ending. */
static int stem_of(const char *name)
{
    return (int)(lf_image_ending(name) - name);
}

/* The name of an earlier picture with the same output; NULL: none. */
static const char *twin_of(const batch *b, int i)
{
    const char *name = b->names[i]->d_name;
    const int stem = stem_of(name);
    for (int k = i - 1; k >= 0; k--)
        if (stem_of(b->names[k]->d_name) == stem &&
            strncmp(b->names[k]->d_name, name, (size_t)stem) == 0)
            return b->names[k]->d_name;
    return NULL;
}

/* OUT/STEM with the ending of the kind; caller frees. NULL = out of memory. */
static char *out_of(const batch *b, const char *name)
{
    const char *ending = strrchr(b->arguments->out, '.');
    const size_t size = strlen(b->arguments->depth.batch) + strlen(name) + strlen(ending) + 2;
    char *out = lf_calloc(size, 1);
    if (out)
        snprintf(out, size, "%s%.*s%s", b->arguments->depth.batch, stem_of(name), name, ending);
    return out;
}

/* True if a quilt of this name may have the tiles of the options. */
static bool has_tiles(const batch *b, const char *file)
{
    const lf_options *o = &b->arguments->options;
    const lf_preset *preset = o->views == 0 ? lf_options_preset(o) : NULL;
    const int wanted[2] = {o->columns > 0 ? o->columns
                           : preset       ? preset->layout.columns
                                          : 0,
                           o->columns > 0 ? o->rows
                           : preset       ? preset->layout.rows
                                          : 0};
    int columns, rows;
    double aspect;
    return wanted[0] == 0 || (lf_layout_from_name(file, &columns, &rows, &aspect) &&
                              columns == wanted[0] && rows == wanted[1]);
}

/* True if the file is the output of this picture: named so, a quilt with its suffix. */
static bool is_output(const batch *b, const char *file, const char *name)
{
    const char *ending = strrchr(b->arguments->out, '.'), *own = strrchr(file, '.'),
               *suffix = lf_layout_suffix(file);
    const int stem = stem_of(name);
    if (!own || strcmp(own, ending) != 0 || strncmp(file, name, (size_t)stem) != 0)
        return false;
    const bool is_quilt =
        b->arguments->kind == &lf_output_quilt && b->arguments->options.views != 1;
    return is_quilt ? suffix && file + stem == suffix && has_tiles(b, file) : file + stem == own;
}

static bool is_made(const batch *b, const char *name)
{
    DIR *folder = opendir(b->arguments->depth.batch);
    const struct dirent *entry;
    bool found = false;
    while (folder && !found && (entry = readdir(folder)))
        found = is_output(b, entry->d_name, name);
    if (folder)
        closedir(folder);
    return found;
}

/* ----------------------------------------------------------------------------------- outputs -- */

static lf_status make(batch *b, const char *name, lf_error *err)
{
    lf_render_arguments arguments = *b->arguments;
    lf_rendering r = *b->start;
    char *scene = lf_path_join(arguments.scene, name), *out = out_of(b, name);
    lf_status status = scene && out ? LF_OK : lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    if (status == LF_OK) {
        arguments.scene = scene;
        arguments.out = out;
        r.arguments = &arguments;
        r.line = (lf_progress_line){0};
        b->words.image = scene;
        b->words.number++;
        lf_log_take(lf_batch_words_take, &b->words);
        status = lf_rendering_open(&r, err);
        if (status == LF_OK)
            status = lf_rendering_write(&r, err);
        lf_rendering_finish(&r);
        lf_log_take(NULL, NULL);
    }
    lf_free(scene);
    lf_free(out);
    return status;
}

static void show(batch *b, int i)
{
    char text[200], left[64] = "";
    const double seconds = lf_time_now() - b->begun;
    const int n_done = b->n_made + b->n_failed;
    if (n_done > 0)
        snprintf(left, sizeof left, ", about %.0f s left", seconds / n_done * (b->n - i));
    snprintf(text, sizeof text, "image %d of %d, %.80s%s", i + 1, b->n, b->names[i]->d_name, left);
    lf_progress_line_draw(&b->line, text);
}

/* Makes the i-th output; false: no other picture can succeed. */
static bool take(batch *b, int i, lf_error *err)
{
    const char *name = b->names[i]->d_name, *twin = twin_of(b, i);
    lf_status status;
    show(b, i);
    if (lf_layout_suffix(name)) {
        status = lf_error_set(err, LF_E_FORMAT, name,
                              "is named as a quilt; rename it, if it is an image with depth");
    } else if (twin) {
        status =
            lf_error_set(err, LF_E_ARG, name, "has the output of %s; rename one of them", twin);
    } else if (!b->arguments->frames.overwrite && is_made(b, name)) {
        b->n_kept++;
        return true;
    } else {
        status = make(b, name, err);
    }
    if (status == LF_OK) {
        b->n_made++;
        return true;
    }
    if (status == LF_E_CANCELLED || (status == LF_E_ARG && strncmp(err->where, "--", 2) == 0))
        return false;
    lf_progress_line_clear(&b->line);
    lf_log_error(err);
    if (b->n_failed++ < MOST_NAMES)
        lf_list_add(b->failed, sizeof b->failed, "%s", name);
    return true;
}

static int tell(batch *b)
{
    lf_progress_line_clear(&b->line);
    lf_batch_words_tell(&b->words);
    if (b->n_kept > 0)
        lf_log(LF_LOG_INFO,
               "%d of %d outputs exist and are kept, whatever their images and options; use "
               "--overwrite to make them again",
               b->n_kept, b->n);
    lf_log(LF_LOG_INFO, "wrote %d outputs to %s (%.0f s)", b->n_made, b->arguments->depth.batch,
           lf_time_now() - b->begun);
    if (b->n_failed == 0)
        return LF_EXIT_OK;
    char more[32] = "";
    if (b->n_failed > MOST_NAMES)
        snprintf(more, sizeof more, " and %d more", b->n_failed - MOST_NAMES);
    lf_log(LF_LOG_ERROR, "%s: %d of %d images failed: %s%s", b->arguments->scene, b->n_failed, b->n,
           b->failed, more);
    return LF_EXIT_FAILED;
}

static int run(batch *b, lf_error *err)
{
    if (mkdir(b->arguments->depth.batch, 0777) != 0 && errno != EEXIST) {
        lf_log(LF_LOG_ERROR, "%s: cannot make the folder: %s", b->arguments->depth.batch,
               lf_errno_text(errno));
        return LF_EXIT_FAILED;
    }
    for (int i = 0; i < b->n; i++) {
        if (!take(b, i, err)) {
            lf_progress_line_clear(&b->line);
            if (err->status == LF_E_ARG)
                return lf_usage_error(LF_RENDER_PROGRAM, err);
            lf_log_error(err);
            return LF_EXIT_FAILED;
        }
        if (atomic_load_explicit(b->start->cancel, memory_order_relaxed)) {
            (void)tell(b);
            lf_log(LF_LOG_ERROR, "interrupted; the same command continues");
            return LF_EXIT_FAILED;
        }
    }
    return tell(b);
}

int lf_batch_run(const lf_rendering *start)
{
    batch b = {
        .start = start, .arguments = start->arguments, .begun = lf_time_now(), .line = start->line};
    lf_error err = {0};
    int code = LF_EXIT_FAILED;
    if (list_pictures(&b, &err) == LF_OK)
        code = run(&b, &err);
    else
        lf_log_error(&err);
    for (int i = 0; i < b.n; i++)
        free(b.names[i]);
    free(b.names);
    return code;
}
