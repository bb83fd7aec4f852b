#include "render/import/scene/vdb_import.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/sandbox/import.h"
#include "render/scene/scene.h"

/* The section's elements if it has the expected number. */
static const void *exactly(const lf_parcel *parcel, lf_parcel_tag tag, size_t count)
{
    size_t n;
    const void *data = lf_parcel_get(parcel, tag, &n);
    return n == count ? data : NULL;
}

static lf_status take_others(const lf_parcel *parcel, lf_grid *grid)
{
    size_t n;
    const char *others = lf_parcel_get(parcel, LF_PARCEL_OTHERS, &n);
    return lf_grid_set_others(grid, others && others[n - 1] == '\0' ? others : "");
}

/* Numbers for messages only: no voxel depends on them. */
static void take_odd(const lf_parcel *parcel, lf_grid *grid)
{
    const double *odd = exactly(parcel, LF_PARCEL_ODD, 4);
    if (odd && odd[0] >= 0 && odd[1] <= 0 && odd[2] >= 0)
        grid->odd = (lf_grid_odd){
            .n_negative = odd[0], .least = odd[1], .n_not_finite = odd[2], .background = odd[3]};
}

static lf_status take_grid(const lf_parcel *parcel, bool is_signed, lf_grid **out_grid,
                           lf_error *err)
{
    const int64_t *size = exactly(parcel, LF_PARCEL_SIZE, 3);
    const double *map = exactly(parcel, LF_PARCEL_MAP, 12);
    lf_grid *grid = NULL;
    size_t n, n_values;
    const uint32_t *bricks = lf_parcel_get(parcel, LF_PARCEL_BRICKS, &n);
    const float *values = lf_parcel_get(parcel, LF_PARCEL_VALUES, &n_values);
    if (!size || !map || n_values % LF_BRICK_STRIDE != 0 || n_values / LF_BRICK_STRIDE != n)
        return lf_error_set(err, LF_E_FORMAT, "grid", "the reader's answer has no grid");
    lf_status status = lf_grid_create(size, map, &grid, err);
    if (status == LF_OK)
        status = lf_grid_put(grid, n, bricks, values, is_signed, err);
    if (status == LF_OK && take_others(parcel, grid) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "grid", "out of memory");
    if (status != LF_OK) {
        lf_grid_unref(grid);
        return status;
    }
    take_odd(parcel, grid);
    *out_grid = grid;
    return LF_OK;
}

static lf_status import(int fd, const char *path, const char *name, bool is_velocity,
                        lf_grid **out_grid, lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_GRID, .is_velocity = is_velocity};
    lf_parcel parcel = {0};
    lf_error problem;
    if (strlen(name) >= sizeof request.grid)
        return lf_error_set(err, LF_E_FORMAT, path, "the name of a grid has at most %zu bytes",
                            sizeof request.grid - 1);
    memcpy(request.grid, name, strlen(name) + 1);
    /* only for messages: the file is open already */
    snprintf(request.path, sizeof request.path, "%s", path);
    lf_status status = lf_import_run(&request, fd, path, NULL, NULL, &parcel, err);
    if (status != LF_OK)
        return status;
    status = take_grid(&parcel, is_velocity, out_grid, &problem);
    lf_parcel_close(&parcel);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, path, "grid %s: %s", name, problem.what);
}

lf_status lf_vdb_import_names(int fd, const char *path, char **out_names, lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_GRID, .lists = 1};
    lf_parcel parcel = {0};
    snprintf(request.path, sizeof request.path, "%s", path);
    lf_status status = lf_import_run(&request, fd, path, NULL, NULL, &parcel, err);
    if (status != LF_OK)
        return status;
    size_t n;
    const char *names = lf_parcel_get(&parcel, LF_PARCEL_OTHERS, &n);
    *out_names = lf_strdup(names && n > 0 && names[n - 1] == '\0' ? names : "");
    lf_parcel_close(&parcel);
    return *out_names ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

lf_status lf_vdb_import(int fd, const char *path, const char *name, lf_grid **out_grid,
                        lf_error *err)
{
    return import(fd, path, name, false, out_grid, err);
}

/* The reader before left the file at its end. */
static lf_status rewind_file(int fd, const char *path, lf_error *err)
{
    if (lseek(fd, 0, SEEK_SET) < 0)
        return lf_error_set(err, LF_E_IO, path, "cannot be read again: %s", strerror(errno));
    return LF_OK;
}

lf_status lf_vdb_import_velocity(int fd, const char *path, const char *const names[3],
                                 lf_grid *out[3], lf_error *err)
{
    lf_grid *grid[3] = {NULL};
    lf_status status = LF_OK;
    for (int i = 0; i < 3 && status == LF_OK; i++) {
        status = rewind_file(fd, path, err);
        if (status == LF_OK)
            status = import(fd, path, names[i], true, &grid[i], err);
    }
    for (int i = 0; i < 3; i++)
        if (status == LF_OK)
            out[i] = grid[i];
        else
            lf_grid_unref(grid[i]);
    return status;
}

lf_status lf_vdb_import_sum(int fd, const char *path, const char *names, lf_grid **out_grid,
                            lf_error *err)
{
    lf_grid *sum = NULL;
    lf_status status = LF_OK;
    for (const char *one = names; *one && status == LF_OK;) {
        char name[512];
        size_t n = strcspn(one, "\n");
        lf_grid *grid = NULL, *both = NULL;
        lf_error problem;
        snprintf(name, sizeof name, "%.*s", (int)n, one);
        status = rewind_file(fd, path, err);
        if (status == LF_OK)
            status = lf_vdb_import(fd, path, name, &grid, err);
        if (status != LF_OK)
            break;
        if (sum) {
            status = lf_grid_sum(sum, grid, &both, &problem);
            if (status == LF_OK && lf_grid_set_others(both, grid->others) != LF_OK)
                status = lf_error_set(&problem, LF_E_NOMEM, "grid", "out of memory");
            if (status != LF_OK)
                (void)lf_error_set(err, status, path, "grid %s: %s", name, problem.what);
            lf_grid_unref(grid);
            lf_grid_unref(sum);
            grid = both;
        }
        sum = grid;
        one += n + (one[n] == '\n');
    }
    if (status == LF_OK)
        *out_grid = sum;
    else
        lf_grid_unref(sum);
    return status;
}
