#include <errno.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <jerror.h>
#include <jpeglib.h>

#include "base/image_formats.h"

/* libjpeg's error manager first, so that its callbacks find the rest. */
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

/* libjpeg fills what is lost with grey and only warns; a picture with holes is refused. */
static void on_message(j_common_ptr jpeg, int level)
{
    jpeg_session *s = (jpeg_session *)(void *)jpeg->err;
    int code = s->manager.msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER ||
                      code == JWRN_HUFF_BAD_CODE || code == JWRN_MUST_RESYNC))
        s->damaged = true;
}

/* stream: NULL where the file is in memory. */
static lf_status decode(struct jpeg_decompress_struct *jpeg, jpeg_session *s, FILE *stream,
                        lf_image8 *out)
{
    if (setjmp(s->escape))
        return LF_E_FORMAT;
    jpeg_create_decompress(jpeg);
    if (stream)
        jpeg_stdio_src(jpeg, stream);
    else
        jpeg_mem_src(jpeg, s->source->data, (unsigned long)s->source->size_bytes);
    jpeg_read_header(jpeg, TRUE);
    const int channels = s->source->channels;
    lf_status status = lf_image_check_shape(s->source, jpeg->image_width, jpeg->image_height,
                                            (size_t)channels, s->err);
    if (status != LF_OK)
        return status;
    if (jpeg->num_components != 1 && jpeg->num_components != 3)
        return lf_error_set(s->err, LF_E_FORMAT, s->source->where,
                            "a JPEG of %d components (expected grey or RGB)", jpeg->num_components);
    jpeg->out_color_space = channels == 4 ? JCS_EXT_RGBA : JCS_RGB;
    jpeg->dct_method = JDCT_ISLOW;
    jpeg_start_decompress(jpeg);
    status = lf_image8_init(out, (int)jpeg->output_width, (int)jpeg->output_height, channels);
    if (status != LF_OK)
        return lf_error_set(s->err, status, s->source->where, "no memory for the picture");
    while (jpeg->output_scanline < jpeg->output_height) {
        JSAMPROW row = out->data + (size_t)jpeg->output_scanline * out->stride;
        jpeg_read_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_decompress(jpeg);
    if (s->damaged)
        return lf_error_set(s->err, LF_E_FORMAT, s->source->where, "JPEG: damaged or cut off");
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
