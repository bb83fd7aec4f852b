#include "base/image_io.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/image_formats.h"

#define MAX_SAMPLES ((int64_t)1 << 31)

static const lf_image_format *const formats[] = {&lf_format_png, &lf_format_jpeg, &lf_format_exr,
                                                 &lf_format_hdr};

#define N_FORMATS (sizeof formats / sizeof formats[0])

lf_status lf_image_check_shape(const lf_image_source *source, int64_t width, int64_t height,
                               size_t bytes_per_pixel, lf_error *err)
{
    if (width < 1 || width > LF_IMAGE_MAX_SIDE || height < 1 || height > LF_IMAGE_MAX_SIDE ||
        width * height * 3 > MAX_SAMPLES)
        return lf_error_set(
            err, LF_E_FORMAT, source->where,
            "the image has %lldx%lld pixels; expected 1 to %d per side and at most 2^31 samples",
            (long long)width, (long long)height, LF_IMAGE_MAX_SIDE);
    uint64_t bytes = (uint64_t)(width * height) * bytes_per_pixel;
    if (bytes > ((uint64_t)512 << 20) && bytes / 4096 > source->size_bytes)
        return lf_error_set(
            err, LF_E_FORMAT, source->where,
            "%lldx%lld pixels do not fit into a file of %llu bytes; the file is damaged",
            (long long)width, (long long)height, (unsigned long long)source->size_bytes);
    return LF_OK;
}

const char *lf_outfile_name(const lf_outfile *file)
{
    return file->path ? file->path : "output";
}

const char *lf_image_ending(const char *path)
{
    for (size_t i = 0; i < N_FORMATS; i++)
        for (const char *const *ending = formats[i]->endings; *ending; ending++)
            if (lf_path_has_ending(path, *ending))
                return path + strlen(path) - strlen(*ending);
    return NULL;
}

const char *lf_image_float_ending(int index)
{
    for (size_t i = 0; i < N_FORMATS; i++)
        for (const char *const *ending = formats[i]->endings; *ending; ending++)
            if (formats[i]->kind == LF_IMAGE_FLOAT && index-- == 0)
                return *ending + 1;
    return NULL;
}

/* "PNG or JPEG": all formats, or only one kind. */
static char *format_names(bool all, lf_image_kind kind, char *buf, size_t size)
{
    const char *names[N_FORMATS];
    size_t n = 0;
    for (size_t i = 0; i < N_FORMATS; i++)
        if (all || formats[i]->kind == kind)
            names[n++] = formats[i]->name;
    buf[0] = '\0';
    for (size_t i = 0; i < n; i++) {
        size_t used = strlen(buf);
        snprintf(buf + used, size - used, "%s%s",
                 i == 0       ? ""
                 : i + 1 == n ? " or "
                              : ", ",
                 names[i]);
    }
    return buf;
}

const char *lf_image_foreign(const uint8_t *head, size_t n)
{
    static const struct {
        size_t at, length;
        const char *magic, *name;
    } rows[] = {{0, 4, "II*\0", "TIFF"},    {0, 4, "MM\0*", "TIFF"},    {8, 4, "WEBP", "WebP"},
                {4, 8, "ftypheic", "HEIC"}, {4, 8, "ftypheix", "HEIC"}, {4, 8, "ftypheim", "HEIC"},
                {4, 8, "ftypheis", "HEIC"}, {4, 8, "ftypmif1", "HEIC"}, {4, 8, "ftypavif", "AVIF"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (rows[i].at + rows[i].length <= n &&
            memcmp(head + rows[i].at, rows[i].magic, rows[i].length) == 0)
            return rows[i].at == 8 && memcmp(head, "RIFF", 4) != 0 ? NULL : rows[i].name;
    return NULL;
}

bool lf_image_is_foreign(const char *path, const lf_roots *roots)
{
    uint8_t head[LF_IMAGE_HEAD_BYTES];
    int fd;
    if (lf_file_open(path, roots, UINT64_MAX, &fd, NULL, NULL) != LF_OK)
        return false;
    const ssize_t n = pread(fd, head, sizeof head, 0);
    close(fd);
    return n > 0 && lf_image_foreign(head, (size_t)n);
}

static lf_status recognise(const lf_image_source *source, const lf_image_format **out,
                           lf_error *err)
{
    uint8_t head[LF_IMAGE_HEAD_BYTES] = {0};
    char names[128];
    ssize_t n = pread(source->fd, head, sizeof head, 0);
    if (n < 0)
        return lf_error_set(err, LF_E_IO, source->where, "cannot read: %s", strerror(errno));
    for (size_t i = 0; i < N_FORMATS; i++) {
        if (formats[i]->recognises(head, (size_t)n)) {
            *out = formats[i];
            return LF_OK;
        }
    }
    if (lf_image_foreign(head, (size_t)n))
        return lf_error_set(err, LF_E_FORMAT, source->where,
                            "is a %s image, which quiltd does not read; convert it to PNG with "
                            "ffmpeg or ImageMagick",
                            lf_image_foreign(head, (size_t)n));
    return lf_error_set(err, LF_E_FORMAT, source->where, "not an image; expected %s",
                        format_names(true, LF_IMAGE_8BIT, names, sizeof names));
}

/* Examines an open file. meta: to be filled by the reader. */
static lf_status look_at(int fd, const char *path, lf_image_metadata *meta, lf_image_source *source,
                         const lf_image_format **format, lf_error *err)
{
    struct stat info;
    *meta = (lf_image_metadata){0};
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, path, "cannot read: %s", strerror(errno));
    if (!S_ISREG(info.st_mode) || (uint64_t)info.st_size > LF_IMAGE_MAX_BYTES)
        return lf_error_set(err, LF_E_FORMAT, path, "expected a regular file of at most 4 GiB");
    *source = (lf_image_source){
        .fd = fd, .size_bytes = (uint64_t)info.st_size, .where = path, .channels = 3, .meta = meta};
    return recognise(source, format, err);
}

/* On LF_OK the caller closes source->fd. */
static lf_status open_source(const char *path, const lf_roots *roots, lf_image_metadata *meta,
                             lf_image_source *source, const lf_image_format **format, lf_error *err)
{
    int fd;
    lf_status status = lf_file_open(path, roots, LF_IMAGE_MAX_BYTES, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = look_at(fd, path, meta, source, format, err);
    if (status != LF_OK)
        close(fd);
    return status;
}

lf_status lf_image_probe(const char *path, const lf_roots *roots, lf_image_kind *out_kind,
                         lf_error *err)
{
    lf_image_metadata meta;
    lf_image_source source;
    const lf_image_format *format;
    lf_status status = open_source(path, roots, &meta, &source, &format, err);
    if (status != LF_OK)
        return status;
    close(source.fd);
    *out_kind = format->kind;
    return LF_OK;
}

lf_status lf_image_probe_open(int fd, const char *path, lf_image_kind *out_kind, lf_error *err)
{
    lf_image_metadata meta;
    lf_image_source source;
    const lf_image_format *format;
    lf_status status = look_at(fd, path, &meta, &source, &format, err);
    if (status == LF_OK)
        *out_kind = format->kind;
    return status;
}

/* Rotates the image upright. */
static lf_status turn(const lf_image_source *source, lf_image8 *image, lf_error *err)
{
    lf_image_metadata *meta = source->meta;
    const bool swaps = lf_orientation_swaps(meta->orientation);
    lf_image8 turned = {0};
    if (meta->orientation < 2)
        return LF_OK;
    lf_status status = lf_image8_init(&turned, swaps ? image->height : image->width,
                                      swaps ? image->width : image->height, image->channels);
    if (status != LF_OK)
        return lf_error_set(err, status, source->where, "not enough memory for the image");
    lf_orient(meta->orientation, image->data, image->stride, image->width, image->height,
              (size_t)image->channels, turned.data);
    lf_image8_finish(image);
    *image = turned;
    if (swaps && meta->pixel_aspect > 0)
        meta->pixel_aspect = 1 / meta->pixel_aspect;
    return LF_OK;
}

static lf_status read8_upright(const lf_image_source *source, const lf_image_format *format,
                               lf_image8 *out, lf_error *err)
{
    lf_image8 image = {0};
    lf_status status = format->read8(source, &image, err);
    if (status == LF_OK)
        status = turn(source, &image, err);
    if (status == LF_OK)
        *out = image;
    else
        lf_image8_finish(&image);
    return status;
}

static lf_status read8_from(const lf_image_source *source, const lf_image_format *format,
                            lf_image8 *out, lf_error *err)
{
    char names[128];
    if (format->read8)
        return read8_upright(source, format, out, err);
    return lf_error_set(err, LF_E_FORMAT, source->where,
                        "%s images have floating-point pixels; expected %s", format->name,
                        format_names(false, LF_IMAGE_8BIT, names, sizeof names));
}

lf_status lf_image8_read(const char *path, const lf_roots *roots, lf_image8 *out, lf_error *err)
{
    lf_image_metadata meta;
    lf_image_source source;
    const lf_image_format *format;
    lf_status status = open_source(path, roots, &meta, &source, &format, err);
    if (status != LF_OK)
        return status;
    status = read8_from(&source, format, out, err);
    close(source.fd);
    return status;
}

lf_status lf_image8_read_metadata(int fd, const char *path, lf_image8 *out, lf_image_metadata *meta,
                                  lf_error *err)
{
    lf_image_source source;
    const lf_image_format *format;
    lf_status status = look_at(fd, path, meta, &source, &format, err);
    return status == LF_OK ? read8_from(&source, format, out, err) : status;
}

lf_status lf_image8_read_on_white(int fd, const char *path, lf_image8 *out, lf_image_metadata *meta,
                                  lf_error *err)
{
    lf_image_source source;
    const lf_image_format *format;
    const lf_status status = look_at(fd, path, meta, &source, &format, err);
    source.on_white = true;
    return status == LF_OK ? read8_from(&source, format, out, err) : status;
}

lf_status lf_image8_read_open(int fd, const char *path, lf_image8 *out, lf_error *err)
{
    lf_image_metadata meta;
    return lf_image8_read_metadata(fd, path, out, &meta, err);
}

static lf_status decode_srgb(const lf_image8 *in, const char *where, lf_image32 *out, lf_error *err)
{
    float linear[256];
    lf_srgb_light(linear);
    lf_status status = lf_image32_init(out, in->width, in->height, in->channels);
    if (status != LF_OK)
        return lf_error_set(err, status, where, "not enough memory for %dx%d pixels", in->width,
                            in->height);
    size_t n = (size_t)in->width * (size_t)in->channels;
    for (int y = 0; y < in->height; y++) {
        const uint8_t *row = in->data + (size_t)y * in->stride;
        float *to = out->data + (size_t)y * n;
        for (size_t i = 0; i < n; i++)
            to[i] = linear[row[i]];
    }
    return LF_OK;
}

static lf_status read32_from(const lf_image_source *source, const lf_image_format *format,
                             lf_image32 *out, lf_error *err)
{
    lf_image32 image = {0};
    lf_image8 encoded = {0};
    lf_status status;
    if (format->read32) {
        status = format->read32(source, &image, err);
    } else {
        status = read8_upright(source, format, &encoded, err);
        if (status == LF_OK)
            status = decode_srgb(&encoded, source->where, &image, err);
    }
    lf_image8_finish(&encoded);
    if (status == LF_OK)
        *out = image;
    else
        lf_image32_finish(&image);
    return status;
}

lf_status lf_image32_read(const char *path, const lf_roots *roots, lf_image32 *out, lf_error *err)
{
    lf_image_metadata meta;
    lf_image_source source;
    const lf_image_format *format;
    lf_status status = open_source(path, roots, &meta, &source, &format, err);
    if (status != LF_OK)
        return status;
    status = read32_from(&source, format, out, err);
    close(source.fd);
    return status;
}

lf_status lf_image32_read_metadata(int fd, const char *path, lf_image32 *out,
                                   lf_image_metadata *meta, lf_error *err)
{
    lf_image_source source;
    const lf_image_format *format;
    lf_status status = look_at(fd, path, meta, &source, &format, err);
    return status == LF_OK ? read32_from(&source, format, out, err) : status;
}

lf_status lf_image32_read_open(int fd, const char *path, lf_image32 *out, lf_error *err)
{
    lf_image_metadata meta;
    return lf_image32_read_metadata(fd, path, out, &meta, err);
}
