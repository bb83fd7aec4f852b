/* Room on the disk, asked for before the first row. */
#include <string.h>
#include <sys/statvfs.h>

#include "base/alloc.h"
#include "quilt/print/print.h"
#include "quilt/print/sheet.h"

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

/* Pixels of the whole page, with copies, labels, marks and paper. */
static lf_status count_pixels(const lf_print *print, double *out, lf_error *err)
{
    lf_print_shape shape;
    lf_sheet sheet;
    lf_print_shape_of(print, &shape);
    const lf_status status = lf_sheet_init(&sheet, print, &shape, err);
    if (status == LF_OK)
        *out = (double)sheet.width * sheet.height;
    lf_sheet_finish(&sheet);
    return status;
}

/* The disk of a file's folder, or of the one in which the folder is made. */
static bool find_disk(const char *path, struct statvfs *out)
{
    char *folder = lf_path_folder(path), *parent = folder ? lf_path_folder(folder) : NULL;
    const bool known = parent && (statvfs(folder, out) == 0 || statvfs(parent, out) == 0);
    lf_free(folder);
    lf_free(parent);
    return known;
}

lf_status lf_print_check_room(const lf_print *print, lf_print_format format, const char *path,
                              lf_error *err)
{
    const bool is_set = print->frame_ppi > 0.0;
    const lf_print page = is_set ? lf_frame_set_print(print) : *print;
    struct statvfs disk;
    double pixels;
    const bool known = find_disk(path, &disk);
    const lf_status status = count_pixels(&page, &pixels, err);
    if (status != LF_OK || !known)
        return status;
    const double bytes = pixels * 3.0 * print->bits / 8.0 * (is_set ? print->n_views : 1);
    return check(&disk, least_bytes(print, is_set ? LF_PRINT_TIFF : format, bytes), path, err);
}
