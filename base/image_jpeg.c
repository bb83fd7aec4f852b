#include <errno.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <jerror.h>
#include <jpeglib.h>

#include "base/alloc.h"
#include "base/image_formats.h"
#include "base/image_profile.h"

#define BUFFER_BYTES (1 << 16)

/* libjpeg's error manager must be first, so that callbacks find the rest. */
typedef struct jpeg_session {
    struct jpeg_error_mgr manager;
    jmp_buf escape;
    bool damaged; /* a warning that means lost picture data */
    const lf_image_source *source;
    lf_error *err;
} jpeg_session;

static bool recognises_jpeg(const uint8_t *head, size_t n)
{
    return n >= 3 && head[0] == 0xff && head[1] == 0xd8 && head[2] == 0xff;
}

static _Noreturn void on_error(j_common_ptr jpeg)
{
    jpeg_session *s = (jpeg_session *)(void *)jpeg->err;
    char message[JMSG_LENGTH_MAX];
    s->manager.format_message(jpeg, message);
    (void)lf_error_set(s->err, LF_E_FORMAT, s->source->where, "JPEG: %s", message);
    longjmp(s->escape, 1);
}

/* libjpeg fills lost parts with grey and only warns; such a picture is refused. */
static void on_message(j_common_ptr jpeg, int level)
{
    jpeg_session *s = (jpeg_session *)(void *)jpeg->err;
    int code = s->manager.msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER ||
                      code == JWRN_HUFF_BAD_CODE || code == JWRN_MUST_RESYNC))
        s->damaged = true;
}

/* -------------------------------------------------------------------------- what is not used -- */

static bool begins(const struct jpeg_marker_struct *marker, int code, const char *word, size_t n)
{
    return marker->marker == code && marker->data_length >= n && memcmp(marker->data, word, n) == 0;
}

static void note_marker(const struct jpeg_decompress_struct *jpeg,
                        const struct jpeg_marker_struct *marker, lf_image_metadata *meta)
{
    lf_image_notes *notes = &meta->notes;
    const uint8_t *data = marker->data;
    size_t n = marker->data_length;
    if (begins(marker, JPEG_APP0 + 1, "Exif\0", 6))
        lf_exif_read(data + 6, n - 6, meta);
    /* the first part of a profile, after its number and the number of parts */
    if (begins(marker, JPEG_APP0 + 2, "ICC_PROFILE", 12) && n > 14 && data[12] == 1 &&
        !lf_icc_is_srgb(data + 14, n - 14))
        lf_image_note(notes, "the ICC profile is not applied; colours are read as %s",
                      jpeg->num_components == 4 ? "plain CMYK" : "sRGB");
    if (begins(marker, JPEG_APP0 + 2, "MPF", 4))
        lf_image_note(notes, "only the first image is read; further images (MPF) are ignored");
}

static void note_markers(const struct jpeg_decompress_struct *jpeg, const lf_image_source *source)
{
    if (!source->meta)
        return;
    for (const struct jpeg_marker_struct *m = jpeg->marker_list; m; m = m->next)
        note_marker(jpeg, m, source->meta);
    if (jpeg->saw_JFIF_marker && jpeg->X_density > 0 && jpeg->Y_density > 0)
        lf_image_metadata_aspect(source->meta, "the density",
                                 (double)jpeg->Y_density / jpeg->X_density);
}

/* ------------------------------------------------------------------------------------ pixels -- */

/* In place. Each ink absorbs light by its coverage. Adobe's programs store 255 for no ink, and mark
 * the file as theirs. */
static void row_from_cmyk(uint8_t *row, int width, int channels, bool inverted)
{
    for (int x = 0; x < width; x++) {
        const uint8_t *ink = row + 4 * (size_t)x;
        uint8_t *to = row + (size_t)channels * (size_t)x;
        unsigned black = inverted ? ink[3] : 255u - ink[3];
        uint8_t rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = (uint8_t)(((inverted ? ink[c] : 255u - ink[c]) * black + 127) / 255);
        memcpy(to, rgb, 3);
        if (channels == 4)
            to[3] = 255;
    }
}

/* CMYK needs a separate row, because it is wider than RGB. */
static void read_rows(struct jpeg_decompress_struct *jpeg, lf_image8 *out)
{
    const bool cmyk = jpeg->out_color_space == JCS_CMYK;
    JSAMPARRAY wide =
        cmyk ? jpeg->mem->alloc_sarray((j_common_ptr)jpeg, JPOOL_IMAGE, 4 * jpeg->output_width, 1)
             : NULL;
    while (jpeg->output_scanline < jpeg->output_height) {
        uint8_t *to = out->data + (size_t)jpeg->output_scanline * out->stride;
        JSAMPROW row = cmyk ? wide[0] : to;
        jpeg_read_scanlines(jpeg, &row, 1);
        if (!cmyk)
            continue;
        row_from_cmyk(row, out->width, out->channels, jpeg->saw_Adobe_marker);
        memcpy(to, row, (size_t)out->width * (size_t)out->channels);
    }
}

static void open_jpeg(struct jpeg_decompress_struct *jpeg, const jpeg_session *s, FILE *stream)
{
    jpeg_create_decompress(jpeg);
    if (stream)
        jpeg_stdio_src(jpeg, stream);
    else
        jpeg_mem_src(jpeg, s->source->data, (unsigned long)s->source->size_bytes);
    for (int i = 1; i <= 2 && s->source->meta; i++)
        jpeg_save_markers(jpeg, JPEG_APP0 + i, 0xffff);
    jpeg_read_header(jpeg, TRUE);
}

/* stream: NULL if the file is in memory. */
static lf_status decode(struct jpeg_decompress_struct *jpeg, jpeg_session *s, FILE *stream,
                        lf_image8 *out)
{
    if (setjmp(s->escape))
        return LF_E_FORMAT;
    open_jpeg(jpeg, s, stream);
    const int channels = s->source->channels;
    lf_status status = lf_image_check_shape(s->source, jpeg->image_width, jpeg->image_height,
                                            (size_t)channels, s->err);
    if (status != LF_OK)
        return status;
    if (jpeg->num_components != 1 && jpeg->num_components != 3 && jpeg->num_components != 4)
        return lf_error_set(s->err, LF_E_FORMAT, s->source->where,
                            "the JPEG has %d components; expected grey, RGB or CMYK",
                            jpeg->num_components);
    jpeg->out_color_space = jpeg->num_components == 4 ? JCS_CMYK
                            : channels == 4           ? JCS_EXT_RGBA
                                                      : JCS_RGB;
    jpeg->dct_method = JDCT_ISLOW;
    jpeg_start_decompress(jpeg);
    status = lf_image8_init(out, (int)jpeg->output_width, (int)jpeg->output_height, channels);
    if (status != LF_OK)
        return lf_error_set(s->err, status, s->source->where, "not enough memory for the image");
    read_rows(jpeg, out);
    note_markers(jpeg, s->source); /* markers are freed at the end */
    jpeg_finish_decompress(jpeg);
    if (s->damaged)
        return lf_error_set(s->err, LF_E_FORMAT, s->source->where,
                            "JPEG: the file is damaged or cut off");
    return LF_OK;
}

static lf_status decode_from(const lf_image_source *source, FILE *stream, lf_image8 *out,
                             lf_error *err)
{
    struct jpeg_decompress_struct jpeg = {0};
    jpeg_session s = {.source = source, .err = err};
    jpeg.err = jpeg_std_error(&s.manager);
    s.manager.error_exit = on_error;
    s.manager.emit_message = on_message;
    lf_image8 image = {0};
    lf_status status = decode(&jpeg, &s, stream, &image);
    jpeg_destroy_decompress(&jpeg);
    if (status == LF_OK)
        *out = image;
    else
        lf_image8_finish(&image);
    return status;
}

static lf_status read_jpeg(const lf_image_source *source, lf_image8 *out, lf_error *err)
{
    if (source->data)
        return decode_from(source, NULL, out, err);
    int fd = dup(source->fd);
    FILE *stream = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (!stream) {
        int cause = errno;
        if (fd >= 0)
            close(fd);
        return lf_error_set(err, LF_E_IO, source->where, "cannot read: %s", strerror(cause));
    }
    lf_status status = decode_from(source, stream, out, err);
    fclose(stream);
    return status;
}

static const char *const endings[] = {".jpg", ".jpeg", NULL};

const lf_image_format lf_format_jpeg = {.name = "JPEG",
                                        .endings = endings,
                                        .kind = LF_IMAGE_8BIT,
                                        .recognises = recognises_jpeg,
                                        .read8 = read_jpeg};

/* ------------------------------------------------------------------------------------- write -- */

typedef struct jpeg_writing {
    struct jpeg_error_mgr manager;
    struct jpeg_destination_mgr to;
    jmp_buf escape;
    lf_outfile *file;
    lf_status status;
    lf_error *err;
    JOCTET buffer[BUFFER_BYTES];
    uint8_t *row; /* [width][3] */
} jpeg_writing;

/* Keeps the first cause: a failed write has reported itself already. */
static _Noreturn void on_write_error(j_common_ptr jpeg)
{
    jpeg_writing *w = (jpeg_writing *)(void *)jpeg->err;
    char message[JMSG_LENGTH_MAX];
    w->manager.format_message(jpeg, message);
    if (w->status == LF_OK)
        w->status = lf_error_set(w->err, LF_E_IO, lf_outfile_name(w->file), "JPEG: %s", message);
    longjmp(w->escape, 1);
}

static void begin_buffer(j_compress_ptr jpeg)
{
    jpeg_writing *w = (jpeg_writing *)(void *)jpeg->err;
    w->to.next_output_byte = w->buffer;
    w->to.free_in_buffer = BUFFER_BYTES;
}

static void write_buffer(j_compress_ptr jpeg, size_t n)
{
    jpeg_writing *w = (jpeg_writing *)(void *)jpeg->err;
    w->status = lf_outfile_write(w->file, w->buffer, n, w->err);
    if (w->status != LF_OK)
        longjmp(w->escape, 1);
    begin_buffer(jpeg);
}

static boolean flush_buffer(j_compress_ptr jpeg)
{
    write_buffer(jpeg, BUFFER_BYTES); /* the whole buffer, whatever free_in_buffer says: libjpeg's
                                       * rule */
    return TRUE;
}

static void end_buffer(j_compress_ptr jpeg)
{
    const jpeg_writing *w = (const jpeg_writing *)(const void *)jpeg->err;
    write_buffer(jpeg, BUFFER_BYTES - w->to.free_in_buffer);
}

/* Colours at full resolution, because with 4:2:0 the colours of neighbouring tiles would mix. */
static void set_up_writing(struct jpeg_compress_struct *jpeg, int width, int height, int quality)
{
    jpeg->image_width = (JDIMENSION)width;
    jpeg->image_height = (JDIMENSION)height;
    jpeg->input_components = 3;
    jpeg->in_color_space = JCS_RGB;
    jpeg_set_defaults(jpeg);
    jpeg_set_quality(jpeg, quality, TRUE);
    jpeg->dct_method = JDCT_ISLOW;
    jpeg->optimize_coding = TRUE;
    for (int i = 0; i < jpeg->num_components; i++)
        jpeg->comp_info[i].h_samp_factor = jpeg->comp_info[i].v_samp_factor = 1;
}

static lf_status encode(struct jpeg_compress_struct *jpeg, jpeg_writing *w, lf_rows8_fn rows,
                        void *context, int quality, int width, int height)
{
    if (setjmp(w->escape))
        return w->status;
    jpeg_create_compress(jpeg);
    w->to = (struct jpeg_destination_mgr){.init_destination = begin_buffer,
                                          .empty_output_buffer = flush_buffer,
                                          .term_destination = end_buffer};
    jpeg->dest = &w->to;
    set_up_writing(jpeg, width, height, quality);
    jpeg_start_compress(jpeg, TRUE);
    while (jpeg->next_scanline < jpeg->image_height) {
        JSAMPROW row = w->row;
        rows(context, (int)jpeg->next_scanline, w->row);
        jpeg_write_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_compress(jpeg);
    return LF_OK;
}

lf_status lf_jpeg_write_rows(lf_outfile *file, int width, int height, lf_rows8_fn rows,
                             void *context, int quality, lf_error *err)
{
    if (width < 1 || width > JPEG_MAX_DIMENSION || height < 1 || height > JPEG_MAX_DIMENSION ||
        quality < 1 || quality > 100)
        return lf_error_set(err, LF_E_ARG, lf_outfile_name(file),
                            "cannot write a JPEG of %dx%d pixels with quality %d (at most %ld "
                            "pixels per side); write .png or .exr",
                            width, height, quality, JPEG_MAX_DIMENSION);
    struct jpeg_compress_struct jpeg = {0};
    jpeg_writing *w = lf_calloc(1, sizeof *w);
    uint8_t *row = w ? lf_calloc((size_t)width, 3) : NULL;
    lf_status status = LF_OK;
    if (!row) {
        status =
            lf_error_set(err, LF_E_NOMEM, lf_outfile_name(file), "not enough memory for libjpeg");
    } else {
        w->file = file;
        w->err = err;
        w->row = row;
        jpeg.err = jpeg_std_error(&w->manager);
        w->manager.error_exit = on_write_error;
        status = encode(&jpeg, w, rows, context, quality, width, height);
        jpeg_destroy_compress(&jpeg);
    }
    lf_free(row);
    lf_free(w);
    return status;
}
