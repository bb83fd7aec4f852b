/* Conversion between linear floats and 8 bits. */
#include "base/alloc.h"
#include "daemon/output/output_internal.h"

typedef struct tone_job {
    const lf_tone *tone;
    const lf_output_source *source;
    uint8_t *out; /* [row][view][column][3] */
} tone_job;

static void tone_row(void *context, int row, int worker)
{
    const tone_job *job = context;
    const lf_views32 *in = &job->source->views32;
    size_t width = (size_t)in->width;
    uint8_t *out = job->out + (size_t)row * (size_t)in->n_views * width * 3;
    (void)worker;
    for (int view = 0; view < in->n_views; view++, out += width * 3) {
        const float *linear = lf_views32_row(in, view, row);
        if (job->source->reconstructed)
            lf_tone_dither(job->tone, job->source->first_view + view, row, width, linear, out);
        else
            lf_tone_map(job->tone, width, linear, out);
    }
}

/* Runs fn for every row, on the job's pool if it has one. */
static lf_status run_rows(const lf_output_request *request, int n_rows, lf_pool_fn fn,
                          void *context, lf_error *err)
{
    if (request->pool) {
        if (lf_pool_run(request->pool, n_rows, fn, context, request->cancel) == LF_OK)
            return LF_OK;
        return lf_error_set(err, LF_E_CANCELLED, request->path, "cancelled");
    }
    for (int row = 0; row < n_rows; row++)
        fn(context, row, 0);
    return output_check_cancel(request, err);
}

lf_status output_views8(const lf_output_request *request, const lf_output_source *source,
                        lf_views8 *out, uint8_t **out_buffer, lf_error *err)
{
    const lf_views32 *in = &source->views32;
    lf_tone *tone = NULL;
    *out_buffer = NULL;
    *out = source->views8;
    if (!source->is_float)
        return LF_OK;
    lf_status status =
        lf_tone_create(request->exposure, request->tonemap ? request->tonemap : "srgb", &tone, err);
    if (status != LF_OK)
        return status;
    size_t row_size = (size_t)in->n_views * (size_t)in->width * 3;
    uint8_t *buffer = lf_calloc((size_t)in->height, row_size);
    status = buffer ? LF_OK : lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    if (status == LF_OK) {
        tone_job job = {tone, source, buffer};
        status = run_rows(request, in->height, tone_row, &job, err);
    }
    lf_tone_destroy(tone);
    if (status != LF_OK) {
        lf_free(buffer);
        return status;
    }
    *out_buffer = buffer;
    *out = (lf_views8){in->n_views, in->width, in->height, (size_t)in->width * 3, row_size, buffer};
    return LF_OK;
}

lf_views32 output_views32(const lf_output_source *source, float light[256])
{
    const lf_views8 *in = &source->views8;
    if (source->is_float)
        return source->views32;
    lf_srgb_light(light);
    return (lf_views32){.n_views = in->n_views,
                        .width = in->width,
                        .height = in->height,
                        .view_stride = in->view_stride,
                        .row_stride = in->row_stride,
                        .codes = in->data,
                        .light = light};
}

lf_output_source output_middle(const lf_output_source *source, int n, lf_layers32 *layers)
{
    lf_output_source some = *source;
    lf_views8 *v8 = &some.views8;
    lf_views32 *v32 = &some.views32;
    if (!source->is_float) {
        v8->data += (size_t)((v8->n_views - n + 1) / 2) * v8->view_stride;
        v8->n_views = n;
        return some;
    }
    const int first = (v32->n_views - n + 1) / 2;
    if (v32->codes)
        v32->codes = lf_views32_codes(v32, first, 0);
    else
        v32->data = lf_views32_row(v32, first, 0);
    if (v32->layers) {
        *layers = *v32->layers;
        layers->data = lf_layers32_row(v32->layers, first, 0);
        v32->layers = layers;
    }
    v32->n_views = n;
    some.first_view += first;
    return some;
}
