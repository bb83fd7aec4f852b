#include "daemon/output/thumbnail.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/raster.h"

#define QUALITY 80

/* The part of a picture that is shown, with packed rows. */
typedef struct tile {
    int width, height;
    double aspect; /* width / height when displayed */
    const uint8_t *data8;
    const float *data32;
    void *copy; /* owned; NULL: the rows of the picture are packed already */
} tile;

/* Rows of the middle view, which are packed only if the quilt has one column. */
static lf_status take_rows(const lf_raster *p, int x, int y, tile *out)
{
    const size_t pixel = 3 * (p->data32 ? sizeof(float) : 1), row = (size_t)p->width * pixel,
                 n = (size_t)out->width * pixel;
    const char *data = p->data32 ? (const void *)p->data32 : p->data8;
    const char *from = data + (size_t)y * row + (size_t)x * pixel;
    if (out->width != p->width) {
        out->copy = lf_calloc((size_t)out->height, n);
        if (!out->copy)
            return LF_E_NOMEM;
        for (int i = 0; i < out->height; i++)
            memcpy((char *)out->copy + (size_t)i * n, from + (size_t)i * row, n);
        from = out->copy;
    }
    out->data8 = p->data32 ? NULL : (const void *)from;
    out->data32 = p->data32 ? (const void *)from : NULL;
    return LF_OK;
}

static lf_status cut_tile(const char *path, const lf_raster *p, tile *out, lf_error *err)
{
    int columns = 1, rows = 1;
    double aspect = 0;
    if (!lf_layout_from_name(path, &columns, &rows, &aspect))
        columns = rows = 1;
    if (columns > p->width || rows > p->height)
        return lf_error_set(err, LF_E_FORMAT, path, "%dx%d pixels are too few for %dx%d tiles",
                            p->width, p->height, columns, rows);
    const int middle = columns * rows / 2;
    const double pixel = p->meta.pixel_aspect > 0 ? p->meta.pixel_aspect : 1;
    *out = (tile){.width = p->width / columns, .height = p->height / rows};
    out->aspect = aspect > 0 ? aspect : pixel * out->width / out->height;
    lf_status status = take_rows(p, middle % columns * out->width,
                                 p->height - (middle / columns + 1) * out->height, out);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, path, "not enough memory for the image");
}

static int whole(double size, int most)
{
    return (int)fmin(fmax(round(size), 1), most);
}

static void choose_size(const tile *t, int width, int *out_width, int *out_height)
{
    const double most = fmin(t->height, 2.0 * width);
    double x = fmin(t->width, width), y = x / t->aspect;
    if (y > most) {
        y = most;
        x = y * t->aspect;
    }
    *out_width = whole(x, t->width);
    *out_height = whole(y, t->height);
}

/* The light of the small picture, and then its own exposure. */
static lf_status shrink_floats(const tile *t, int width, int height, uint8_t *out)
{
    const size_t n = (size_t)width * (size_t)height;
    const lf_views32 views = {.n_views = 1,
                              .width = t->width,
                              .height = t->height,
                              .row_stride = 3 * (size_t)t->width,
                              .data = t->data32};
    float *light = lf_calloc(n, 3 * sizeof *light);
    lf_meter *meter = lf_calloc(1, sizeof *meter);
    lf_tone *tone = NULL;
    lf_status status =
        light && meter ? lf_view_shrink32(&views, 0, width, height, light) : LF_E_NOMEM;
    if (status == LF_OK) {
        lf_meter_add(meter, n, light);
        status = lf_tone_create(lf_meter_exposure(meter), "srgb", &tone, NULL);
    }
    if (status == LF_OK)
        lf_tone_map(tone, n, light, out);
    lf_tone_destroy(tone);
    lf_free(meter);
    lf_free(light);
    return status;
}

static lf_status shrink(const tile *t, int width, int height, uint8_t *out)
{
    const lf_views8 views = {.n_views = 1,
                             .width = t->width,
                             .height = t->height,
                             .row_stride = 3 * (size_t)t->width,
                             .data = t->data8};
    return t->data32 ? shrink_floats(t, width, height, out)
                     : lf_view_shrink(&views, 0, width, height, out);
}

typedef struct small {
    int width;
    const uint8_t *rgb;
} small;

static void copy_row(void *context, int y, uint8_t *row)
{
    const small *s = context;
    const size_t n = 3 * (size_t)s->width;
    memcpy(row, s->rgb + (size_t)y * n, n);
}

lf_status lf_thumbnail_write(const char *path, const lf_roots *roots, int width, lf_outfile *file,
                             int *out_width, int *out_height, lf_error *err)
{
    lf_raster picture = {0};
    tile t = {0};
    lf_status status = lf_raster_open(path, roots, false, &picture, err);
    if (status == LF_OK)
        status = cut_tile(path, &picture, &t, err);
    if (status != LF_OK) {
        lf_raster_close(&picture);
        return status;
    }
    int x, y;
    choose_size(&t, width, &x, &y);
    uint8_t *rgb = lf_calloc((size_t)x * (size_t)y, 3);
    status = rgb ? shrink(&t, x, y, rgb) : LF_E_NOMEM;
    lf_free(t.copy);
    lf_raster_close(&picture);
    if (status != LF_OK)
        (void)lf_error_set(err, status, path, "not enough memory for the image");
    else
        status = lf_jpeg_write_rows(file, x, y, copy_row, &(small){x, rgb}, QUALITY, err);
    if (status == LF_OK) {
        *out_width = x;
        *out_height = y;
    }
    lf_free(rgb);
    return status;
}
