/* The middle view as a plain picture, under the given name. */
#include "base/alloc.h"
#include "daemon/output/output_internal.h"

lf_status output_still_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err)
{
    int columns = 0, rows = 0;
    double aspect = 0;
    (void)layout;
    if (lf_layout_from_name(path, &columns, &rows, &aspect) && (columns != 1 || rows != 1))
        return lf_error_set(err, LF_E_ARG, path,
                            "the name says %dx%d tiles, but the image is one view; change the name",
                            columns, rows);
    *out_path = lf_strdup(path);
    return *out_path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    lf_layers32 layers;
    const lf_output_source one = output_middle(source, 1, &layers);
    lf_output_request plain = *request;
    plain.layout = (lf_layout){
        .columns = 1,
        .rows = 1,
        .n_views = 1,
        .view_width = one.is_float ? one.views32.width : one.views8.width,
        .view_height = one.is_float ? one.views32.height : one.views8.height,
        .aspect = one.aspect,
    };
    return output_quilt_write(&plain, &one, files, err);
}

const lf_output_kind lf_output_still = {.name = "still",
                                        .what = "an image of one view",
                                        .rendered = LF_RENDERED_VIEW,
                                        .endings = output_quilt_endings,
                                        .option = "still",
                                        .n_files = 1,
                                        .complete = output_still_path,
                                        .write = write_files};
