/* A folder of views: view_000.exr, view_001.exr, … Each file becomes visible whole, and none before
 * all are written. */
#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

static char *file_name(const char *folder, int i)
{
    char name[32];
    snprintf(name, sizeof name, "view_%03d.exr", i);
    return lf_path_join(folder, name);
}

/* The number in "view_NNN.exr", else -1. */
static int view_number(const char *name)
{
    int number = -1;
    char again[32];
    if (sscanf(name, "view_%d", &number) != 1 || number < 0)
        return -1;
    snprintf(again, sizeof again, "view_%03d.exr", number);
    return strcmp(name, again) == 0 ? number : -1;
}

/* Views numbered n and above would make another light field of the folder: they are counted, or
 * removed. */
static int surplus(const char *folder, int n, bool remove)
{
    DIR *dir = opendir(folder);
    int count = 0;
    if (!dir)
        return 0;
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        if (view_number(entry->d_name) < n)
            continue;
        count++;
        if (remove)
            unlinkat(dirfd(dir), entry->d_name, 0);
    }
    closedir(dir);
    return count;
}

static lf_status write_all(const lf_output_request *request, const lf_views32 *views,
                           lf_outfile *files, lf_error *err)
{
    output_attributes attributes;
    lf_status status = LF_OK;
    output_attributes_fill(&attributes, request->settings);
    for (int view = 0; view < views->n_views && status == LF_OK; view++) {
        status = output_check_cancel(request, err);
        if (status == LF_OK)
            status =
                lf_view_write_exr(&files[view], views, view, attributes.list, attributes.n, err);
        output_progress(request, (view + 1.0) / (views->n_views + 1.0));
    }
    return status;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    float light[256];
    lf_views32 views = output_views32(source, light);
    return write_all(request, &views, files, err);
}

static const char *const endings[] = {"/", NULL};

const lf_output_kind lf_output_views = {.name = "views",
                                        .what = "a folder of views",
                                        .endings = endings,
                                        .file_name = file_name,
                                        .write = write_files,
                                        .surplus = surplus};
