#include "daemon/output/sent_quilt.h"

#include <errno.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/errno_text.h"

/* Its names in the list: raw pixels are an array, a picture is a file. */
#define RAW "quilt"
#define PICTURE "/quilt"

static lf_array shape_of(const lf_sent_quilt *quilt)
{
    return (lf_array){LF_ARRAY_UINT8, 3, {quilt->height, quilt->width, 3}};
}

lf_status lf_sent_quilt_add(const lf_sent_quilt *quilt, lf_passed *passed, int fd, lf_error *err)
{
    const lf_array shape = shape_of(quilt);
    return quilt->width > 0 ? lf_passed_add_array(passed, RAW, &shape, fd, err)
                            : lf_passed_add(passed, PICTURE, fd, err);
}

/* Maps raw pixels; their file is sealed. */
static lf_status map_raw(const lf_sent_quilt *quilt, lf_passed *passed, const char *name,
                         void **out, size_t *out_bytes, lf_error *err)
{
    lf_array shape = shape_of(quilt);
    const size_t bytes = (size_t)lf_array_bytes(&shape);
    int fd = -1;
    lf_status status = lf_passed_open_array(passed, RAW, &shape, &shape, &fd, err);
    if (status != LF_OK)
        return status;
    void *pixels = mmap(NULL, bytes, PROT_READ, MAP_SHARED, fd, 0);
    const int why = errno;
    close(fd);
    if (pixels == MAP_FAILED)
        return lf_error_set(err, why == ENOMEM ? LF_E_NOMEM : LF_E_IO, name, "cannot be mapped: %s",
                            lf_errno_text(why));
    *out = pixels;
    *out_bytes = bytes;
    return LF_OK;
}

static lf_status read_raw(const lf_sent_quilt *quilt, lf_passed *passed, const char *name,
                          const lf_photo *photo, lf_quilt_file *out, lf_error *err)
{
    void *pixels;
    size_t bytes;
    lf_status status = map_raw(quilt, passed, name, &pixels, &bytes, err);
    if (status != LF_OK)
        return status;
    const lf_raster picture = {.width = quilt->width, .height = quilt->height, .data8 = pixels};
    status = lf_quilt_cut(&picture, name, &quilt->tiles, photo, out, err);
    munmap(pixels, bytes);
    return status;
}

static lf_status check_file(int fd, const char *name, lf_error *err)
{
    struct stat info;
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, name, "cannot read: %s", lf_errno_text(errno));
    return (uint64_t)info.st_size <= LF_SENT_QUILT_BYTES
               ? LF_OK
               : lf_error_set(err, LF_E_FORMAT, name, "the file has more than %d MiB",
                              (int)(LF_SENT_QUILT_BYTES >> 20));
}

static lf_status check_picture(const lf_raster *p, const char *name, lf_error *err)
{
    const uint64_t bytes =
        (uint64_t)3 * (uint64_t)p->width * (uint64_t)p->height * (p->data32 ? sizeof(float) : 1);
    if (p->width > LF_SENT_QUILT_SIDE || p->height > LF_SENT_QUILT_SIDE)
        return lf_error_set(err, LF_E_FORMAT, name,
                            "the image has %dx%d pixels; expected at most %d per side", p->width,
                            p->height, LF_SENT_QUILT_SIDE);
    return bytes <= LF_SENT_QUILT_BYTES
               ? LF_OK
               : lf_error_set(err, LF_E_FORMAT, name,
                              "the pixels need %llu MiB; expected at most %d MiB",
                              (unsigned long long)(bytes >> 20), (int)(LF_SENT_QUILT_BYTES >> 20));
}

static lf_status decode(lf_passed *passed, const char *name, lf_raster *out, lf_error *err)
{
    int fd = -1;
    lf_status status = lf_passed_open(passed, PICTURE, &fd, err);
    if (status != LF_OK)
        return status;
    status = check_file(fd, name, err);
    if (status == LF_OK)
        status = lf_raster_import(fd, name, false, out, err);
    close(fd);
    return status == LF_OK ? check_picture(out, name, err) : status;
}

static lf_status read_picture(const lf_sent_quilt *quilt, lf_passed *passed, const char *name,
                              const lf_photo *photo, lf_quilt_file *out, lf_error *err)
{
    lf_raster picture = {0};
    lf_status status = decode(passed, name, &picture, err);
    if (status == LF_OK)
        status = lf_quilt_cut(&picture, name, &quilt->tiles, photo, out, err);
    lf_raster_close(&picture);
    return status;
}

lf_status lf_sent_quilt_read(const lf_sent_quilt *quilt, lf_passed *passed, const char *name,
                             const lf_photo *photo, lf_quilt_file *out, lf_error *err)
{
    return quilt->width > 0 ? read_raw(quilt, passed, name, photo, out, err)
                            : read_picture(quilt, passed, name, photo, out, err);
}

lf_status lf_sent_rgbd_open(const lf_sent_quilt *quilt, lf_passed *passed, const char *name,
                            const lf_photo *photo, lf_sent_rgbd *rgbd, lf_error *err)
{
    lf_status status;
    if (quilt->width > 0) {
        status = map_raw(quilt, passed, name, &rgbd->pixels, &rgbd->bytes, err);
        rgbd->raster =
            (lf_raster){.width = quilt->width, .height = quilt->height, .data8 = rgbd->pixels};
    } else {
        status = decode(passed, name, &rgbd->raster, err);
    }
    if (status != LF_OK)
        return status;
    return lf_rgbd_file_take(&rgbd->raster, name, rgbd->standing, rgbd->side, photo, &rgbd->file,
                             err);
}

void lf_sent_rgbd_close(lf_sent_rgbd *rgbd)
{
    lf_rgbd_file_close(&rgbd->file);
    if (rgbd->pixels)
        munmap(rgbd->pixels, rgbd->bytes);
    else
        lf_raster_close(&rgbd->raster);
    rgbd->pixels = NULL;
}
