/* Room on the disk, asked for before the first row. */
#include <string.h>
#include <sys/statvfs.h>

#include "base/alloc.h"
#include "quilt/print/print.h"

/* The least share of the raster that a compressed file has: less is a blank page. */
#define COMPRESSED 0.1

/* An error if fewer bytes are free. Files in memory have no disk. */
static lf_status check(const struct statvfs *disk, double bytes, const char *where, lf_error *err)
{
    const double free_bytes = (double)disk->f_bavail * (double)disk->f_frsize;
    if (disk->f_blocks == 0 || free_bytes >= bytes)
        return LF_OK;
    return lf_error_set(err, LF_E_IO, where,
                        "needs %.3g GB, but %.3g GB are free on this disk; make room or choose "
                        "another folder",
                        1e-9 * bytes, 1e-9 * free_bytes);
}

static double least_bytes(const lf_print *print, lf_print_format format, double raster_bytes)
{
    const bool is_plain = format == LF_PRINT_TIFF && print->compress == LF_COMPRESS_NONE;
    return is_plain ? raster_bytes : COMPRESSED * raster_bytes;
}

lf_status lf_print_room_for(const lf_print *print, lf_print_format format, double raster_bytes,
                            const lf_outfile *file, lf_error *err)
{
    struct statvfs disk;
    if (fstatvfs(file->fd, &disk) != 0)
        return LF_OK;
    return check(&disk, least_bytes(print, format, raster_bytes), file->path ? file->path : "print",
                 err);
}

lf_status lf_print_check_room(const lf_print *print, lf_print_format format, const char *path,
                              lf_error *err)
{
    lf_print_shape shape;
    struct statvfs disk;
    char *folder = lf_path_folder(path);
    const bool known = folder && statvfs(folder, &disk) == 0;
    lf_free(folder);
    if (!known)
        return LF_OK;
    lf_print_shape_of(print, &shape);
    const double pixels = ((double)shape.raster_width + 2.0 * shape.margin_px) *
                          ((double)shape.raster_height + 2.0 * shape.margin_down_px);
    return check(&disk, least_bytes(print, format, pixels * 3.0 * print->bits / 8.0), path, err);
}
