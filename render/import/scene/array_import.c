#include "render/import/scene/array_import.h"

#include <errno.h>
#include <sys/mman.h>

#include "base/errno_text.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "render/import/scene/file_identity.h"
#include "render/scene/grid.h"

/* The middle of the array is at the origin. */
static void centred_map(const int64_t size[3], double out[12])
{
    for (int i = 0; i < 12; i++) {
        const int axis = i / 4;
        out[i] = i % 5 == 0 ? 1.0 : i % 4 == 3 ? -0.5 * (double)(size[axis] - 1) : 0.0;
    }
}

static lf_status import_values(const float *values, const char *name, const int64_t size[3],
                               lf_grid **out_grid, lf_error *err)
{
    double map[12];
    lf_error problem;
    centred_map(size, map);
    lf_status status =
        lf_grid_from_array(size, map, values, lf_import_is_stopped, out_grid, &problem);
    if (status == LF_E_CANCELLED)
        return lf_import_say_stopped(name, err);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, name, "%s", problem.what);
}

lf_status lf_array_import(int fd, const char *name, const int64_t size[3], lf_grid **out_grid,
                          lf_error *err)
{
    lf_digest digest;
    lf_grid *grid = NULL;
    lf_status status = lf_file_digest(fd, name, &digest, err);
    if (status != LF_OK)
        return status;
    const size_t bytes = (size_t)size[0] * (size_t)size[1] * (size_t)size[2] * sizeof(float);
    void *values = mmap(NULL, bytes, PROT_READ, MAP_SHARED, fd, 0);
    if (values == MAP_FAILED)
        return lf_error_set(err, errno == ENOMEM ? LF_E_NOMEM : LF_E_IO, name,
                            "cannot be mapped: %s", lf_errno_text(errno));
    status = import_values(values, name, size, &grid, err);
    munmap(values, bytes);
    if (status != LF_OK)
        return status;
    grid->digest = digest;
    *out_grid = grid;
    return LF_OK;
}
