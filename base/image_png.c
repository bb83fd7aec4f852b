#include <errno.h>
#include <math.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <png.h>

#include "base/alloc.h"
#include "base/image_png.h"

/* State for libpng's callbacks. Its errors leave by longjmp, so nothing else may change between
 * setjmp and there. */
typedef struct png_session {
    png_structp png;
    png_infop info;
    const lf_image_source *source; /* reading */
    lf_outfile *file;              /* writing */
    uint64_t offset;
    lf_status status;
    lf_error *err;
} png_session;

static bool recognises_png(const uint8_t *head, size_t n)
{
    return n >= 8 && png_sig_cmp(head, 0, 8) == 0;
}

/* Keeps the first cause: a failed write has reported itself already. */
static void on_error(png_structp png, png_const_charp message)
{
    png_session *s = png_get_error_ptr(png);
    if (s->status == LF_OK) {
        const char *where = s->source ? s->source->where : lf_outfile_name(s->file);
        s->status = lf_error_set(s->err, LF_E_FORMAT, where, "PNG: %s", message);
    }
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

/* -------------------------------------------------------------------------------------- read -- */

static void copy_bytes(png_structp png, png_bytep to, size_t n)
{
    png_session *s = png_get_io_ptr(png);
    if (n > s->source->size_bytes - s->offset)
        png_error(png, "the file ends too early");
    memcpy(to, s->source->data + s->offset, n);
    s->offset += n;
}

static void read_bytes(png_structp png, png_bytep to, size_t n)
{
    png_session *s = png_get_io_ptr(png);
    while (n > 0) {
        ssize_t got = pread(s->source->fd, to, n, (off_t)s->offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            s->status =
                lf_error_set(s->err, LF_E_IO, s->source->where, "cannot read: %s", strerror(errno));
        if (got <= 0)
            png_error(png, "the file ends too early");
        to += got;
        n -= (size_t)got;
        s->offset += (uint64_t)got;
    }
}

/* Requests 3 channels (RGB) or 4 (with alpha, opaque if the file has none). */
static void ask_for_rgb8(png_structp png, png_infop info, int channels)
{
    int color = png_get_color_type(png, info);
    if (color == PNG_COLOR_TYPE_PALETTE)
        png_set_palette_to_rgb(png);
    else if (color == PNG_COLOR_TYPE_GRAY)
        png_set_expand_gray_1_2_4_to_8(png);
    png_set_scale_16(png);
    if (channels == 3)
        png_set_strip_alpha(png);
    else if (png_get_valid(png, info, PNG_INFO_tRNS))
        png_set_tRNS_to_alpha(png);
    else if (!(color & PNG_COLOR_MASK_ALPHA))
        png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
    if (!(color & PNG_COLOR_MASK_COLOR))
        png_set_gray_to_rgb(png);
}

static bool has_alpha(const png_session *s)
{
    return (png_get_color_type(s->png, s->info) & PNG_COLOR_MASK_ALPHA) ||
           png_get_valid(s->png, s->info, PNG_INFO_tRNS);
}

/* The code whose light is nearest. */
static uint8_t code_of(const float light[256], float value)
{
    int low = 0, high = 255;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        *(light[middle] <= value ? &low : &high) = middle;
    }
    return (uint8_t)(value - light[low] <= light[high] - value ? low : high);
}

/* Puts a pixel of four channels on white. */
static void put_on_white(const float light[256], uint8_t *pixel)
{
    const float cover = (float)pixel[3] / 255.0F;
    for (int c = 0; c < 3 && pixel[3] < 255; c++)
        pixel[c] = code_of(light, cover * light[pixel[c]] + (1.0F - cover));
}

/* Reduces four channels to three, in place. The allocation keeps its size. */
static void drop_alpha(const png_session *s, lf_image8 *out)
{
    size_t n = (size_t)out->width * (size_t)out->height, clear = 0;
    float light[256];
    lf_srgb_light(light);
    for (size_t i = 0; i < n; i++) {
        if (s->source->on_white)
            put_on_white(light, out->data + 4 * i);
        clear += out->data[4 * i + 3] < 255;
        memmove(out->data + 3 * i, out->data + 4 * i, 3);
    }
    out->channels = 3;
    out->stride = 3 * (size_t)out->width;
    if (clear > 0)
        lf_image_note(&s->source->meta->notes, "%zu %s not opaque; %s", clear,
                      clear == 1 ? "pixel is" : "pixels are",
                      s->source->on_white ? "white paper shows through" : "alpha is ignored");
}

static void note_chunks(const png_session *s)
{
    png_charp name = NULL;
    png_bytep profile = NULL;
    png_uint_32 size = 0;
    int method = 0;
    (void)png_get_iCCP(s->png, s->info, &name, &method, &profile, &size);
    lf_png_note(s->source, profile, size);
}

static lf_status read_rows(png_session *s, lf_image8 *out)
{
    if (setjmp(png_jmpbuf(s->png)))
        return s->status;
    png_set_read_fn(s->png, s, s->source->data ? copy_bytes : read_bytes);
    png_set_user_limits(s->png, 65536, 65536);
    png_read_info(s->png, s->info);
    int64_t width = png_get_image_width(s->png, s->info),
            height = png_get_image_height(s->png, s->info);
    /* only its values show whether dropping alpha loses anything */
    const bool looks = s->source->meta && has_alpha(s) && width * height <= (int64_t)1 << 29;
    const int channels = looks ? 4 : s->source->channels;
    s->status = lf_image_check_shape(s->source, width, height, (size_t)channels, s->err);
    if (s->status != LF_OK)
        return s->status;
    ask_for_rgb8(s->png, s->info, channels);
    int n_passes = png_set_interlace_handling(s->png);
    png_read_update_info(s->png, s->info);
    if (png_get_rowbytes(s->png, s->info) != (size_t)width * (size_t)channels)
        png_error(s->png, "unknown pixel format");
    s->status = lf_image8_init(out, (int)width, (int)height, channels);
    if (s->status != LF_OK)
        return lf_error_set(s->err, s->status, s->source->where, "not enough memory for the image");
    for (int pass = 0; pass < n_passes; pass++)
        for (int y = 0; y < out->height; y++)
            png_read_row(s->png, out->data + (size_t)y * out->stride, NULL);
    png_read_end(s->png, NULL);
    if (looks && s->source->channels == 3)
        drop_alpha(s, out);
    note_chunks(s);
    return LF_OK;
}

static lf_status read_png(const lf_image_source *source, lf_image8 *out, lf_error *err)
{
    png_session s = {.source = source, .err = err};
    lf_image8 image = {0};
    s.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &s, on_error, on_warning);
    s.info = s.png ? png_create_info_struct(s.png) : NULL;
    lf_status status =
        s.info ? read_rows(&s, &image)
               : lf_error_set(err, LF_E_NOMEM, source->where, "not enough memory for libpng");
    png_destroy_read_struct(&s.png, &s.info, NULL);
    if (status == LF_OK)
        *out = image;
    else
        lf_image8_finish(&image);
    return status;
}

static const char *const endings[] = {".png", NULL};

const lf_image_format lf_format_png = {.name = "PNG",
                                       .endings = endings,
                                       .kind = LF_IMAGE_8BIT,
                                       .recognises = recognises_png,
                                       .read8 = read_png};

/* ------------------------------------------------------------------------------------- write -- */

static void write_bytes(png_structp png, png_bytep from, size_t n)
{
    png_session *s = png_get_io_ptr(png);
    s->status = lf_outfile_write(s->file, from, n, s->err);
    if (s->status != LF_OK)
        png_error(png, "cannot write");
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

/* tEXt is Latin-1 by the standard; text beyond ASCII is written as iTXt, which is UTF-8. */
static void put_text(png_session *s, const lf_attribute *attribute)
{
    char key[80], value[1] = "";
    snprintf(key, sizeof key, "%s", attribute->name);
    bool ascii = true;
    for (const char *c = attribute->value; *c; c++)
        ascii = ascii && (unsigned char)*c < 0x80;
    png_text text = {.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE,
                     .key = key,
                     .lang = value,
                     .lang_key = value};
    char *copy = lf_strdup(attribute->value);
    if (!copy)
        png_error(s->png, "not enough memory for a text");
    text.text = copy;
    png_set_text(s->png, s->info, &text, 1);
    lf_free(copy);
}

/* Pixels per unit in pHYs: only the ratio of both numbers matters. */
#define PHYS_PER_UNIT 1000000

typedef struct png_job {
    int width, height, level;
    double pixel_aspect; /* 0: square */
    lf_rows8_fn rows;
    void *context;
    uint8_t *row; /* [width][3] */
    const lf_attribute *attributes;
    int n_attributes;
} png_job;

static lf_status write_rows(png_session *s, const png_job *job)
{
    if (setjmp(png_jmpbuf(s->png)))
        return s->status;
    png_set_write_fn(s->png, s, write_bytes, flush_nothing);
    png_set_compression_buffer_size(s->png, (size_t)1 << 17);
    png_set_compression_level(s->png, job->level);
    /* For live pictures, one fixed cheap filter: trying all five per row costs more than deflate's
     * fast levels. */
    png_set_filter(s->png, 0, job->level <= 3 ? PNG_FILTER_SUB : PNG_ALL_FILTERS);
    png_set_IHDR(s->png, s->info, (png_uint_32)job->width, (png_uint_32)job->height, 8,
                 PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(s->png, s->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (job->pixel_aspect > 0)
        png_set_pHYs(s->png, s->info, PHYS_PER_UNIT,
                     (png_uint_32)lround(job->pixel_aspect * PHYS_PER_UNIT),
                     PNG_RESOLUTION_UNKNOWN);
    for (int i = 0; i < job->n_attributes; i++)
        put_text(s, &job->attributes[i]);
    png_write_info(s->png, s->info);
    for (int y = 0; y < job->height; y++) {
        job->rows(job->context, y, job->row);
        png_write_row(s->png, job->row);
    }
    png_write_end(s->png, NULL);
    return LF_OK;
}

lf_status lf_png_write_oblong(lf_outfile *file, lf_png_size size, lf_rows8_fn rows, void *context,
                              int level, const lf_attribute *attributes, int n, lf_error *err)
{
    const int width = size.width, height = size.height;
    if (width < 1 || width > 65536 || height < 1 || height > 65536 || level < 1 || level > 9)
        return lf_error_set(err, LF_E_ARG, lf_outfile_name(file),
                            "cannot write a PNG of %dx%d pixels with level %d; expected 1 to 65536 "
                            "pixels per side, level 1 to 9",
                            width, height, level);
    png_session s = {.file = file, .err = err};
    png_job job = {.width = width,
                   .height = height,
                   .level = level,
                   .pixel_aspect = size.pixel_aspect,
                   .rows = rows,
                   .context = context,
                   .attributes = attributes,
                   .n_attributes = n};
    job.row = lf_calloc((size_t)width, 3);
    s.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &s, on_error, on_warning);
    s.info = s.png ? png_create_info_struct(s.png) : NULL;
    lf_status status = s.info && job.row ? write_rows(&s, &job)
                                         : lf_error_set(err, LF_E_NOMEM, lf_outfile_name(file),
                                                        "not enough memory for libpng");
    png_destroy_write_struct(&s.png, &s.info);
    lf_free(job.row);
    return status;
}

lf_status lf_png_write_rows(lf_outfile *file, int width, int height, lf_rows8_fn rows,
                            void *context, int level, const lf_attribute *attributes, int n,
                            lf_error *err)
{
    return lf_png_write_oblong(file, (lf_png_size){width, height, 0}, rows, context, level,
                               attributes, n, err);
}

static void copy_row(void *context, int y, uint8_t *row)
{
    const lf_image8 *image = context;
    memcpy(row, image->data + (size_t)y * image->stride, (size_t)image->width * 3);
}

lf_status lf_png_write(lf_outfile *file, const lf_image8 *image, int level,
                       const lf_attribute *attributes, int n, lf_error *err)
{
    if (image->channels != 3)
        return lf_error_set(err, LF_E_ARG, lf_outfile_name(file), "%d channels; expected 3",
                            image->channels);
    lf_image8 borrowed = *image;
    return lf_png_write_rows(file, image->width, image->height, copy_row, &borrowed, level,
                             attributes, n, err);
}
