/* One view as a plain picture: the middle one, under the name that it was given. */
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
                            "the name says %dx%d tiles, but it is one view alone", columns, rows);
    *out_path = lf_strdup(path);
    return *out_path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

/* The right one of two, as in pictures with depth. */
static lf_output_source middle_of(const lf_output_source *source, lf_layers32 *layers)
{
    lf_output_source one = *source;
    lf_views8 *v8 = &one.views8;
    lf_views32 *v32 = &one.views32;
    if (!source->is_float) {
        v8->data += (size_t)(v8->n_views / 2) * v8->view_stride;
        v8->n_views = 1;
        return one;
    }
    const int middle = v32->n_views / 2;
    if (v32->codes)
        v32->codes = lf_views32_codes(v32, middle, 0);
    else
        v32->data = lf_views32_row(v32, middle, 0);
    if (v32->layers) {
        *layers = *v32->layers;
        layers->data = lf_layers32_row(v32->layers, middle, 0);
        v32->layers = layers;
    }
    v32->n_views = 1;
    return one;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    lf_layers32 layers;
    const lf_output_source one = middle_of(source, &layers);
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
                                        .what = "a picture of one view",
                                        .endings = output_quilt_endings,
                                        .option = "still",
                                        .n_files = 1,
                                        .complete = output_still_path,
                                        .write = write_files};
