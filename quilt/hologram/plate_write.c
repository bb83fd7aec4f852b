/* Writes the files of a plate: pictures of cameras, and pictures or a field made of them. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "quilt/hologram/plate.h"

/* Most bytes of samples that are in memory when pictures are made of those of all cameras, if one
 * row of pixels of every camera is not more. */
#define BAND_BYTES ((size_t)256 << 20)

/* Samples in memory of cameras [first_camera, …), counted row by row, and of pixel rows [y0, …). */
typedef struct samples {
    const uint8_t *data;
    size_t camera_bytes; /* from one camera to the next */
    int first_camera, y0;
} samples;

/* Pictures to write from samples in memory; items are numbered, each is written by one worker. */
typedef struct picture_job {
    const lf_plate *plate;
    const char *folder;
    samples from;
    int field;       /* descriptor of the raw file; -1: each picture is a file */
    bool of_cameras; /* an item is a camera; otherwise a pixel of all cameras */
    int done, total; /* items of other jobs, and of all */
    const lf_plate_run *run;
    pthread_mutex_t lock; /* of what follows */
    lf_status status;
    lf_error *err;
} picture_job;

/* A place in the picture of an item. */
static lf_plate_place place_of_item(const picture_job *job, int item)
{
    const lf_plate *p = job->plate;
    lf_plate_sample s = {0};
    if (job->of_cameras) {
        s.row = (job->from.first_camera + item) / p->columns;
        s.column = (job->from.first_camera + item) % p->columns;
    } else {
        s.y = job->from.y0 + item / p->width;
        s.x = item % p->width;
    }
    return lf_plate_place_of(p, s);
}

/* Copies the pixels of a picture to out, [rows][columns]. */
static void assemble(const picture_job *job, lf_plate_place place, lf_plate_picture picture,
                     uint8_t *out)
{
    const lf_plate *p = job->plate;
    const samples *from = &job->from;
    const size_t bytes = lf_plate_pixel_bytes(p);
    for (int y = 0; y < picture.rows; y++)
        for (int x = 0; x < picture.columns; x++, out += bytes) {
            const lf_plate_sample s = lf_plate_sample_at(p, lf_plate_pixel(p, place, y, x));
            const size_t camera = (size_t)(s.row * p->columns + s.column - from->first_camera),
                         pixel = (size_t)(s.y - from->y0) * (size_t)p->width + (size_t)s.x;
            memcpy(out, from->data + camera * from->camera_bytes + pixel * bytes, bytes);
        }
}

static lf_status write_at(int fd, const uint8_t *data, size_t n, uint64_t offset, lf_error *err)
{
    while (n > 0) {
        const ssize_t put = pwrite(fd, data, n, (off_t)offset);
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            return lf_error_set(err, LF_E_IO, "plate.raw", "cannot write: %s",
                                put == 0 ? "nothing was taken" : lf_errno_text(errno));
        data += put;
        n -= (size_t)put;
        offset += (uint64_t)put;
    }
    return LF_OK;
}

static lf_status write_picture(const picture_job *job, int item, lf_error *err)
{
    const lf_plate *p = job->plate;
    const lf_plate_place place = place_of_item(job, item);
    const lf_plate_picture picture = lf_plate_picture_of(p, place);
    const size_t bytes = (size_t)picture.rows * (size_t)picture.columns * lf_plate_pixel_bytes(p);
    uint8_t *pixels = lf_calloc(bytes, 1);
    char *name = NULL, *path = NULL;
    lf_status status = LF_E_NOMEM;
    if (pixels && job->field >= 0) {
        const uint64_t i =
            (uint64_t)picture.i * (uint64_t)lf_plate_size(p).hx + (uint64_t)picture.j;
        assemble(job, place, picture, pixels);
        status = write_at(job->field, pixels, bytes, LF_PLATE_HEADER + i * bytes, err);
    } else if (pixels && (name = lf_plate_picture_name(p, picture.i, picture.j)) &&
               (path = lf_path_join(job->folder, name))) {
        status = lf_plate_make_folders(job->folder, name, err);
        assemble(job, place, picture, pixels);
        if (status == LF_OK)
            status = lf_plate_picture_write(p, path, picture.columns, picture.rows, pixels, err);
    } else {
        status = lf_error_set(err, LF_E_NOMEM, job->folder, "out of memory");
    }
    lf_free(path);
    lf_free(name);
    lf_free(pixels);
    return status;
}

static void run_item(void *context, int item, int worker)
{
    picture_job *job = context;
    lf_error err = {0};
    pthread_mutex_lock(&job->lock);
    const bool goes_on = job->status == LF_OK;
    pthread_mutex_unlock(&job->lock);
    if (!goes_on)
        return;
    const lf_status status = write_picture(job, item, &err);
    pthread_mutex_lock(&job->lock);
    if (status != LF_OK && job->status == LF_OK) {
        job->status = status;
        if (job->err)
            *job->err = err;
    }
    job->done++;
    const double fraction = (double)job->done / job->total;
    pthread_mutex_unlock(&job->lock);
    if (worker == 0 && job->run->progress)
        job->run->progress(job->run->context, fraction);
}

static bool is_cancelled(const lf_plate_run *run)
{
    return run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed);
}

/* Writes n pictures. */
static lf_status write_pictures(picture_job *job, int n, lf_error *err)
{
    lf_status status = LF_OK;
    job->err = err;
    if (job->run->pool)
        status = lf_pool_run(job->run->pool, n, run_item, job, job->run->cancel);
    for (int i = 0; !job->run->pool && i < n && status == LF_OK; i++) {
        run_item(job, i, 0);
        status = is_cancelled(job->run) ? LF_E_CANCELLED : LF_OK;
    }
    if (job->status != LF_OK)
        return job->status;
    return status == LF_OK ? LF_OK : lf_error_set(err, status, job->folder, "cancelled");
}

/* ------------------------------------------------------------------------------------- tasks -- */

static lf_status write_task_file(const lf_plate *plate, const char *folder, int task,
                                 const uint8_t *data, lf_error *err)
{
    uint8_t header[LF_PLATE_HEADER];
    lf_outfile file;
    char *name = lf_plate_task_file(plate, task, 0),
         *path = name ? lf_path_join(folder, name) : NULL;
    lf_status status = path ? lf_plate_make_folders(folder, name, err)
                            : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (status == LF_OK)
        status = lf_outfile_open(&file, path, true, err);
    lf_free(path);
    lf_free(name);
    if (status != LF_OK)
        return status;
    lf_plate_task_header(plate, task, header);
    status = lf_outfile_write(&file, header, sizeof header, err);
    if (status == LF_OK)
        status = lf_outfile_write(&file, data, lf_plate_task_bytes(plate), err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

static lf_status write_task(const lf_plate *plate, const char *folder, int task,
                            const uint8_t *data, const lf_plate_run *run, lf_error *err)
{
    const int n = lf_plate_task_cameras(plate);
    if (!lf_plate_is_direct(plate))
        return write_task_file(plate, folder, task, data, err);
    picture_job job = {
        .plate = plate,
        .folder = folder,
        .from = {.data = data,
                 .camera_bytes = lf_plate_task_bytes(plate) / (size_t)n,
                 .first_camera = lf_plate_task_row(plate, task) * plate->columns +
                                 lf_plate_task_first(plate, task)},
        .field = -1,
        .of_cameras = true,
        .total = n,
        .run = run,
        .lock = PTHREAD_MUTEX_INITIALIZER,
    };
    return write_pictures(&job, n, err);
}

lf_status lf_plate_write_task(const lf_plate *plate, const char *folder, const json_t *facts,
                              int task, const uint8_t *data, const lf_plate_run *run, lf_error *err)
{
    lf_status status = lf_plate_receipt_remove(folder, task, err);
    if (status == LF_OK)
        status = write_task(plate, folder, task, data, run, err);
    return status == LF_OK ? lf_plate_receipt_write(plate, folder, facts, task, err) : status;
}

/* --------------------------------------------------------------------------- the whole plate -- */

/* Reads n cameras of a task from `first` on, and of each the pixel rows [y0, y0 + rows). */
static lf_status read_task(const lf_plate *plate, const char *folder, int task, int first, int n,
                           int y0, int rows, uint8_t *out, lf_error *err)
{
    const size_t row = (size_t)plate->width * lf_plate_pixel_bytes(plate),
                 wanted = row * (size_t)rows;
    int fd;
    lf_status status = lf_plate_task_open(plate, folder, task, &fd, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < n && status == LF_OK; i++) {
        const size_t at = ((size_t)(first + i) * (size_t)plate->height + (size_t)y0) * row;
        size_t done = 0;
        while (done < wanted && status == LF_OK) {
            const ssize_t got = pread(fd, out + (size_t)i * wanted + done, wanted - done,
                                      (off_t)(LF_PLATE_HEADER + at + done));
            if (got > 0)
                done += (size_t)got;
            else if (got == 0 || errno != EINTR)
                status = lf_error_set(err, LF_E_IO, folder, "cannot read rows/r%03d.raw: %s", task,
                                      got == 0 ? "it ends too early" : lf_errno_text(errno));
        }
    }
    close(fd);
    return status;
}

/* A picture is made of a pixel of all cameras: bands of their rows are read. */
static lf_status write_across(picture_job *job, uint8_t *band, int band_rows, lf_error *err)
{
    const lf_plate *p = job->plate;
    const int n = lf_plate_task_cameras(p);
    lf_status status = LF_OK;
    for (int y0 = 0; y0 < p->height && status == LF_OK; y0 += band_rows) {
        const int rows = p->height - y0 < band_rows ? p->height - y0 : band_rows;
        job->from.data = band;
        job->from.y0 = y0;
        job->from.camera_bytes = (size_t)rows * (size_t)p->width * lf_plate_pixel_bytes(p);
        for (int task = 0; task < lf_plate_tasks(p) && status == LF_OK; task++)
            status = is_cancelled(job->run)
                         ? lf_error_set(err, LF_E_CANCELLED, job->folder, "cancelled")
                         : read_task(p, job->folder, task, 0, n, y0, rows,
                                     band + (size_t)(task * n) * job->from.camera_bytes, err);
        if (status == LF_OK)
            status = write_pictures(job, rows * p->width, err);
    }
    return status;
}

/* A picture is that of a camera: groups of cameras are read. */
static lf_status write_along(picture_job *job, uint8_t *group, int group_cameras, lf_error *err)
{
    const lf_plate *p = job->plate;
    const int n = lf_plate_task_cameras(p);
    lf_status status = LF_OK;
    job->from.data = group;
    for (int task = 0; task < lf_plate_tasks(p); task++)
        for (int first = 0; first < n && status == LF_OK; first += group_cameras) {
            const int some = n - first < group_cameras ? n - first : group_cameras;
            status = read_task(p, job->folder, task, first, some, 0, p->height, group, err);
            job->from.first_camera = task * n + first;
            if (status == LF_OK)
                status = write_pictures(job, some, err);
        }
    return status;
}

static int most(size_t bytes_each, int n)
{
    const size_t fit = BAND_BYTES / bytes_each;
    return fit < 1 ? 1 : fit < (size_t)n ? (int)fit : n;
}

/* What is read at a time: cameras, or rows of pixels of all cameras. */
typedef struct portion {
    bool of_cameras;
    size_t bytes; /* of each */
    int n;        /* at a time */
} portion;

static portion portion_of(const lf_plate *plate)
{
    const size_t camera = lf_plate_task_bytes(plate) / (size_t)lf_plate_task_cameras(plate),
                 row =
                     camera / (size_t)plate->height * (size_t)plate->rows * (size_t)plate->columns;
    if (plate->form == LF_PLATE_RAW && plate->camera_is_cell)
        return (portion){true, camera, most(camera, lf_plate_task_cameras(plate))};
    return (portion){false, row, most(row, plate->height)};
}

size_t lf_plate_finish_memory(const lf_plate *plate)
{
    const portion read = portion_of(plate);
    return lf_plate_is_direct(plate) ? 0 : read.bytes * (size_t)read.n;
}

static lf_status write_whole(const lf_plate *plate, const char *folder, int field,
                             const lf_plate_run *run, lf_error *err)
{
    const portion read = portion_of(plate);
    const size_t camera = lf_plate_task_bytes(plate) / (size_t)lf_plate_task_cameras(plate);
    uint8_t *memory = lf_calloc(read.bytes, (size_t)read.n);
    picture_job job = {
        .plate = plate,
        .folder = folder,
        .from.camera_bytes = camera,
        .field = field,
        .of_cameras = read.of_cameras,
        .total = read.of_cameras ? plate->rows * plate->columns : plate->width * plate->height,
        .run = run,
        .lock = PTHREAD_MUTEX_INITIALIZER,
    };
    const lf_status status =
        !memory ? lf_error_set(err, LF_E_NOMEM, folder, "out of memory for a row of cameras")
        : read.of_cameras ? write_along(&job, memory, read.n, err)
                          : write_across(&job, memory, read.n, err);
    lf_free(memory);
    return status;
}

static lf_status write_field(const lf_plate *plate, const char *folder, const lf_plate_run *run,
                             lf_error *err)
{
    uint8_t header[LF_PLATE_HEADER];
    lf_outfile file;
    char *name = lf_plate_file(plate, 0), *path = name ? lf_path_join(folder, name) : NULL;
    lf_status status = path ? lf_outfile_open(&file, path, true, err)
                            : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    lf_free(path);
    lf_free(name);
    if (status != LF_OK)
        return status;
    lf_plate_field_header(plate, header);
    status = lf_outfile_write(&file, header, sizeof header, err);
    if (status == LF_OK)
        status = write_whole(plate, folder, file.fd, run, err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

/* The raw files of tasks are what their receipts say. */
static lf_status check_rows(const lf_plate *plate, const char *folder, const json_t *hashes,
                            const lf_plate_run *run, lf_error *err)
{
    json_t *files = json_array();
    lf_status status = LF_OK;
    for (int task = 0; task < lf_plate_tasks(plate) && status == LF_OK; task++) {
        char *name = lf_plate_task_file(plate, task, 0);
        if (!name)
            status = lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
        else if (is_cancelled(run))
            status = lf_error_set(err, LF_E_CANCELLED, folder, "cancelled");
        else
            status = lf_plate_add_file(
                folder, name, json_string_value(json_object_get(hashes, name)), files, err);
        lf_free(name);
    }
    json_decref(files);
    return status;
}

lf_status lf_plate_finish(const lf_plate *plate, const char *folder, const json_t *facts,
                          const lf_plate_run *run, lf_error *err)
{
    json_t *hashes = NULL;
    lf_status status = lf_plate_receipts(plate, folder, facts, &hashes, err);
    if (status == LF_OK && !lf_plate_is_direct(plate))
        status = check_rows(plate, folder, hashes, run, err);
    if (status == LF_OK && plate->form == LF_PLATE_RAW)
        status = write_field(plate, folder, run, err);
    else if (status == LF_OK && !lf_plate_is_direct(plate))
        status = write_whole(plate, folder, -1, run, err);
    if (status == LF_OK)
        status = lf_plate_manifest_write(plate, folder, facts, hashes, run, err);
    json_decref(hashes);
    return status;
}
