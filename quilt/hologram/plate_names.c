/* Files of a plate: names, folders, and what is there. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "quilt/hologram/plate.h"

static const char *const endings[] = {
    [LF_PLATE_PNG] = "png", [LF_PLATE_TIFF] = "tif", [LF_PLATE_EXR] = "exr"};

#define FIELD_FILE "plate.raw"

char *lf_plate_picture_name(const lf_plate *plate, int i, int j)
{
    const lf_plate_place n = lf_plate_size(plate);
    const char *ending = endings[plate->format];
    char name[64];
    if (plate->form != LF_PLATE_VIEWS)
        snprintf(name, sizeof name, "hogels/r%04d/c%04d.%s", i, j, ending);
    else if (n.v == 1 || n.u == 1)
        snprintf(name, sizeof name, "views/view_%04d.%s", i * n.u + j, ending);
    else
        snprintf(name, sizeof name, "views/r%03d/c%04d.%s", i, j, ending);
    return lf_strdup(name);
}

static char *task_name(int task)
{
    char name[32];
    snprintf(name, sizeof name, "rows/r%03d.raw", task);
    return lf_strdup(name);
}

int lf_plate_task_files(const lf_plate *plate)
{
    return lf_plate_is_direct(plate) ? lf_plate_task_cameras(plate) : 1;
}

char *lf_plate_task_file(const lf_plate *plate, int task, int i)
{
    if (!lf_plate_is_direct(plate))
        return task_name(task);
    const lf_plate_sample camera = {lf_plate_task_row(plate, task),
                                    lf_plate_task_first(plate, task) + i, 0, 0};
    const lf_plate_picture picture = lf_plate_picture_of(plate, lf_plate_place_of(plate, camera));
    return lf_plate_picture_name(plate, picture.i, picture.j);
}

int lf_plate_n_files(const lf_plate *plate)
{
    int rows, columns;
    lf_plate_pictures(plate, &rows, &columns);
    return plate->form == LF_PLATE_RAW ? 1 : rows * columns;
}

char *lf_plate_file(const lf_plate *plate, int i)
{
    int rows, columns;
    if (i == lf_plate_n_files(plate))
        return lf_strdup("manifest.json");
    lf_plate_pictures(plate, &rows, &columns);
    return plate->form == LF_PLATE_RAW ? lf_strdup(FIELD_FILE)
                                       : lf_plate_picture_name(plate, i / columns, i % columns);
}

lf_status lf_plate_make_folders(const char *folder, const char *name, lf_error *err)
{
    char *path = lf_path_join(folder, name);
    lf_status status = path ? LF_OK : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    for (char *at = path ? path + strlen(path) - strlen(name) : NULL;
         status == LF_OK && (at = strchr(at, '/'));) {
        *at = '\0';
        if (mkdir(path, 0777) != 0 && errno != EEXIST)
            status = lf_error_set(err, LF_E_IO, path, "cannot make the folder: %s",
                                  lf_errno_text(errno));
        *at++ = '/';
    }
    lf_free(path);
    return status;
}

lf_status lf_plate_task_open(const lf_plate *plate, const char *folder, int task, int *out_fd,
                             lf_error *err)
{
    uint8_t expected[LF_PLATE_HEADER], header[LF_PLATE_HEADER];
    uint64_t size = 0;
    char *name = task_name(task), *path = name ? lf_path_join(folder, name) : NULL;
    int fd = -1;
    lf_status status = path ? lf_file_open(path, NULL, UINT64_MAX, &fd, &size, err)
                            : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    lf_plate_task_header(plate, task, expected);
    if (status == LF_OK && (size != LF_PLATE_HEADER + lf_plate_task_bytes(plate) ||
                            pread(fd, header, sizeof header, 0) != (ssize_t)sizeof header ||
                            memcmp(header, expected, sizeof header) != 0))
        status = lf_error_set(err, LF_E_FORMAT, path,
                              "is damaged or of another plate; remove it and run the command "
                              "again");
    if (status == LF_OK)
        *out_fd = fd;
    else if (fd >= 0)
        close(fd);
    lf_free(path);
    lf_free(name);
    return status;
}
