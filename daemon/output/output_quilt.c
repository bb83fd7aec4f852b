/* All views as tiles of one picture. */
#include <math.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

#define MAX_PICTURE_SIDE 65536
#define MAX_PICTURE_SAMPLES (INT64_C(1) << 31)

static lf_status check_quilt_size(const char *path, const lf_layout *layout, lf_error *err)
{
    int64_t width = (int64_t)layout->columns * layout->view_width;
    int64_t height = (int64_t)layout->rows * layout->view_height;
    if (width > MAX_PICTURE_SIDE || height > MAX_PICTURE_SIDE ||
        width * height * 3 > MAX_PICTURE_SAMPLES)
        return lf_error_set(err, LF_E_ARG, path,
                            "a quilt of %dx%d views of %dx%d pixels is too large for one image; "
                            "write a folder of views (OUT/)",
                            layout->columns, layout->rows, layout->view_width, layout->view_height);
    return LF_OK;
}

lf_status output_quilt_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err)
{
    int columns = 0;
    int rows = 0;
    double aspect = 0;
    lf_status status = check_quilt_size(path, layout, err);
    if (status != LF_OK)
        return status;
    if (lf_layout_from_name(path, &columns, &rows, &aspect)) {
        if (columns != layout->columns || rows != layout->rows)
            return lf_error_set(err, LF_E_ARG, path,
                                "the name says %dx%d tiles, but the quilt has %dx%d; change the "
                                "name or set --quilt",
                                columns, rows, layout->columns, layout->rows);
        if (aspect > 0 && fabs(aspect - layout->aspect) > 0.01 * layout->aspect)
            return lf_error_set(
                err, LF_E_ARG, path,
                "the name says aspect %g, but the views have %g; change the name or the aspect",
                aspect, layout->aspect);
        *out_path = lf_strdup(path);
    } else {
        *out_path = lf_layout_name(path, layout);
    }
    return *out_path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

static lf_status write_png(const lf_output_request *request, const lf_output_source *source,
                           lf_outfile *file, const output_attributes *attributes, lf_error *err)
{
    lf_views8 views;
    uint8_t *buffer = NULL;
    lf_status status = output_views8(request, source, &views, &buffer, err);
    if (status == LF_OK) {
        output_progress(request, 0.2);
        status = lf_quilt_write_png(file, &views, &request->layout, attributes->list, attributes->n,
                                    err);
    }
    lf_free(buffer);
    return status;
}

/* Without attributes, because pictures to share should not reveal how they were made. */
static lf_status write_jpeg(const lf_output_request *request, const lf_output_source *source,
                            lf_outfile *file, lf_error *err)
{
    lf_views8 views;
    uint8_t *buffer = NULL;
    const int quality = request->quality > 0 ? request->quality : LF_JPEG_QUALITY;
    lf_status status = output_views8(request, source, &views, &buffer, err);
    if (status == LF_OK) {
        output_progress(request, 0.2);
        status = lf_quilt_write_jpeg(file, &views, &request->layout, quality, err);
    }
    lf_free(buffer);
    return status;
}

static lf_status write_exr(const lf_output_request *request, const lf_output_source *source,
                           lf_outfile *file, const output_attributes *attributes, lf_error *err)
{
    float light[256];
    lf_views32 views = output_views32(source, light);
    output_progress(request, 0.2);
    return lf_quilt_write_exr(file, &views, &request->layout, attributes->list, attributes->n, err);
}

lf_status output_quilt_write(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    output_attributes attributes;
    output_attributes_fill(&attributes, request->settings);
    if (lf_path_has_ending(request->path, ".exr"))
        return write_exr(request, source, files, &attributes, err);
    return lf_path_has_ending(request->path, ".png")
               ? write_png(request, source, files, &attributes, err)
               : write_jpeg(request, source, files, err);
}

const char *const output_quilt_endings[] = {".png", ".exr", ".jpg", ".jpeg", NULL};

const lf_output_kind lf_output_quilt = {.name = "quilt",
                                        .what = "a quilt",
                                        .rendered = LF_RENDERED_VIEWS,
                                        .endings = output_quilt_endings,
                                        .has_tiles = true,
                                        .n_files = 1,
                                        .complete = output_quilt_path,
                                        .write = output_quilt_write};
