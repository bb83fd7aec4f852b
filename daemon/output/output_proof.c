/* Proofs of prints: the print is written to a file without a name, and looked at through its sheet
 * from places across the range of its views. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/output/output_internal.h"
#include "quilt/proof/print_file.h"
#include "quilt/proof/simulate.h"

/* Pixels of the print, at most: 512 MiB with 8 bits. */
#define MOST_PIXELS 1.8e8
#define MOST_HEIGHT 600

static const char *const endings[] = {".png", NULL};

/* A file that no name leads to; -1 with errno. */
static int open_nameless(void)
{
    const char *folder = getenv("TMPDIR");
    const int fd = open(folder ? folder : "/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd < 0)
        return memfd_create("proof", MFD_CLOEXEC);
    return fd;
}

/* The print without its page: of copies, which are all alike, one is seen. */
static lf_print one_copy(const lf_print *print)
{
    lf_print alone = *print;
    alone.sheet.columns = alone.sheet.rows = 0;
    alone.sheet.paper_width_mm = alone.sheet.paper_height_mm = 0.0;
    alone.sheet.label = NULL;
    return alone;
}

/* Writes the print into a nameless file, which the caller closes. */
static lf_status write_print(const lf_output_request *request, const lf_output_source *source,
                             int *out_fd, lf_error *err)
{
    lf_outfile files[2] = {{.fd = -1}, {.fd = -1}};
    lf_output_request quiet = *request;
    const lf_print alone = one_copy(request->print);
    lf_status status = LF_OK;
    quiet.path = "proof.tif";
    quiet.print = &alone;
    quiet.progress = NULL;
    for (int i = 0; i < 2 && status == LF_OK; i++) {
        const int fd = open_nameless();
        status = fd < 0 ? lf_error_set(err, LF_E_IO, "proof", "cannot write a temporary file: %s",
                                       lf_errno_text(errno))
                        : lf_outfile_adopt(&files[i], fd, err);
        if (status != LF_OK && fd >= 0)
            close(fd);
    }
    if (status == LF_OK)
        status = lf_output_print.write(&quiet, source, files, err);
    if (status == LF_OK) {
        *out_fd = fcntl(files[0].fd, F_DUPFD_CLOEXEC, 0);
        if (*out_fd < 0)
            status = lf_error_set(err, LF_E_IO, "proof", "%s", lf_errno_text(errno));
    }
    for (int i = 0; i < 2; i++)
        if (files[i].fd >= 0)
            close(files[i].fd);
    return status;
}

/* One pixel per lens, or less. */
static lf_status size_of(const lf_proof_sheet *sheet, int *out_width, int *out_height,
                         lf_error *err)
{
    lf_status status = lf_proof_size(sheet, 0, out_width, out_height, err);
    if (status == LF_OK && *out_height > MOST_HEIGHT)
        status = lf_proof_size(sheet, *out_width * MOST_HEIGHT / *out_height + 1, out_width,
                               out_height, err);
    return status;
}

static lf_status see_all(const lf_output_request *request, const lf_proof_sheet *sheet,
                         lf_print_file *file, int width, int height, float *out, lf_error *err)
{
    const size_t size = 3 * (size_t)width * (size_t)height;
    const double range = LF_OUTPUT_PROOF_BEYOND * lf_proof_view_range(sheet, sheet->distance_mm);
    for (int i = 0; i < LF_OUTPUT_PROOF_EYES; i++) {
        const double at_mm = range * ((double)i / (LF_OUTPUT_PROOF_EYES - 1) - 0.5);
        const lf_eye eye = {sheet->horizontal ? 0.0 : at_mm, sheet->horizontal ? at_mm : 0.0,
                            sheet->distance_mm};
        lf_image32 image;
        const lf_status status =
            lf_proof_picture(file, sheet, &eye, width, height, request->cancel, &image, err);
        if (status != LF_OK)
            return status;
        memcpy(out + (size_t)i * size, image.data, size * sizeof *out);
        lf_image32_finish(&image);
        output_progress(request, (i + 0.5) / LF_OUTPUT_PROOF_EYES);
    }
    return LF_OK;
}

/* The images as a column; the first is at the bottom, as in a quilt. */
static lf_status write_column(const lf_output_request *request, int width, int height,
                              const float *data, lf_outfile *files, lf_error *err)
{
    const size_t row = 3 * (size_t)width;
    const double aspect = (double)width / height;
    lf_output_request column = *request;
    column.exposure = 0.0;
    column.tonemap = NULL;
    column.layout = (lf_layout){.columns = 1,
                                .rows = LF_OUTPUT_PROOF_EYES,
                                .n_views = LF_OUTPUT_PROOF_EYES,
                                .view_width = width,
                                .view_height = height,
                                .aspect = aspect};
    const lf_output_source source = {.is_float = true,
                                     .views32 = {.n_views = LF_OUTPUT_PROOF_EYES,
                                                 .width = width,
                                                 .height = height,
                                                 .view_stride = row * (size_t)height,
                                                 .row_stride = row,
                                                 .data = data},
                                     .aspect = aspect};
    return output_quilt_write(&column, &source, files, err);
}

static lf_status see_print(const lf_output_request *request, int fd, lf_outfile *files,
                           lf_error *err)
{
    char path[32];
    lf_print_file *file = NULL;
    lf_proof_sheet sheet;
    int width = 0, height = 0;
    float *data = NULL;
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    lf_proof_sheet_of(request->print, &sheet, NULL);
    lf_status status = size_of(&sheet, &width, &height, err);
    if (status == LF_OK)
        status = lf_print_file_open(path, NULL, &file, err);
    if (status == LF_OK) {
        data = lf_calloc((size_t)LF_OUTPUT_PROOF_EYES * (size_t)width * (size_t)height,
                         3 * sizeof *data);
        status = data ? see_all(request, &sheet, file, width, height, data, err)
                      : lf_error_set(err, LF_E_NOMEM, "proof", "out of memory");
    }
    if (status == LF_OK)
        status = write_column(request, width, height, data, files, err);
    lf_free(data);
    lf_print_file_close(file);
    return status;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    lf_print_shape shape;
    int fd = -1;
    lf_print_shape_of(request->print, &shape);
    if ((double)shape.raster_width * shape.raster_height > MOST_PIXELS)
        return lf_error_set(err, LF_E_ARG, "proof",
                            "the print has over 180 million pixels; export it and use quiltrender "
                            "--simulate");
    lf_status status = write_print(request, source, &fd, err);
    if (status == LF_OK)
        status = see_print(request, fd, files, err);
    if (fd >= 0)
        close(fd);
    return status;
}

const lf_output_kind lf_output_proof = {.name = "proof",
                                        .what = "a proof of a print",
                                        .endings = endings,
                                        .option = "simulate",
                                        .asks = "lpi, width and height (mm)",
                                        .n_files = 1,
                                        .check_print = lf_print_check,
                                        .write = write_files};
