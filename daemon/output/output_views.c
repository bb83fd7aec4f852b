/* Folders of views: view_000.exr, view_001.exr, …, or .png. Each file becomes visible whole, and
 * none before all are written. */
#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/number.h"
#include "daemon/output/output_internal.h"

static char *name_of(const char *folder, int i, const char *ending)
{
    char name[32];
    snprintf(name, sizeof name, "view_%03d%s", i, ending);
    return lf_path_join(folder, name);
}

static char *exr_name(const char *folder, int i)
{
    return name_of(folder, i, ".exr");
}

static char *png_name(const char *folder, int i)
{
    return name_of(folder, i, ".png");
}

/* The number in "view_NNN" with this ending, otherwise -1. */
static int view_number(const char *name, const char *ending)
{
    uint64_t number;
    char again[32];
    if (strncmp(name, "view_", 5) != 0 || !lf_whole_read(name + 5, &number) || number > INT_MAX)
        return -1;
    snprintf(again, sizeof again, "view_%03d%s", (int)number, ending);
    return strcmp(name, again) == 0 ? (int)number : -1;
}

/* Counts or removes views numbered n and above, and views of the other kind: with them the folder
 * would be another light field. */
static int surplus(const char *folder, int n, const char *ending, const char *other, bool remove)
{
    DIR *dir = opendir(folder);
    int count = 0;
    if (!dir)
        return 0;
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        if (view_number(entry->d_name, ending) < n && view_number(entry->d_name, other) < 0)
            continue;
        count++;
        if (remove)
            unlinkat(dirfd(dir), entry->d_name, 0);
    }
    closedir(dir);
    return count;
}

static int exr_surplus(const char *folder, int n, bool remove)
{
    return surplus(folder, n, ".exr", ".png", remove);
}

static int png_surplus(const char *folder, int n, bool remove)
{
    return surplus(folder, n, ".png", ".exr", remove);
}

static lf_status write_exrs(const lf_output_request *request, const lf_output_source *source,
                            lf_outfile *files, lf_error *err)
{
    float light[256];
    const lf_views32 views = output_views32(source, light);
    output_attributes attributes;
    lf_status status = LF_OK;
    output_attributes_fill(&attributes, request->settings);
    for (int view = 0; view < views.n_views && status == LF_OK; view++) {
        status = output_check_cancel(request, err);
        if (status == LF_OK)
            status = lf_view_write_exr(&files[view], &views, view, source->aspect, attributes.list,
                                       attributes.n, err);
        output_progress(request, (view + 1.0) / (views.n_views + 1.0));
    }
    return status;
}

static lf_status write_pngs(const lf_output_request *request, const lf_output_source *source,
                            lf_outfile *files, lf_error *err)
{
    output_attributes attributes;
    lf_views8 views;
    uint8_t *buffer = NULL;
    lf_status status = output_views8(request, source, &views, &buffer, err);
    const int n = status == LF_OK ? views.n_views : 0;
    const lf_layout one = {1, 1, 1, views.width, views.height, source->aspect};
    output_attributes_fill(&attributes, request->settings);
    views.n_views = 1;
    for (int view = 0; view < n && status == LF_OK; view++, views.data += views.view_stride) {
        status = output_check_cancel(request, err);
        if (status == LF_OK)
            status =
                lf_quilt_write_png(&files[view], &views, &one, attributes.list, attributes.n, err);
        output_progress(request, (view + 1.0) / (n + 1.0));
    }
    lf_free(buffer);
    return status;
}

static const char *const endings[] = {"/", NULL};

const lf_output_kind lf_output_views = {.name = "views",
                                        .what = "a folder of views",
                                        .rendered = LF_RENDERED_VIEWS,
                                        .endings = endings,
                                        .is_linear = true,
                                        .file_name = exr_name,
                                        .write = write_exrs,
                                        .surplus = exr_surplus};

const lf_output_kind lf_output_pictures = {.name = "pictures",
                                           .what = "a folder of 8-bit views",
                                           .rendered = LF_RENDERED_VIEWS,
                                           .endings = endings,
                                           .option = "png",
                                           .file_name = png_name,
                                           .write = write_pngs,
                                           .surplus = png_surplus};
