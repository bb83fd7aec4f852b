/* quiltimport-vdb: volumes. Separate from meshes, because loading OpenVDB alone takes longer than
 * reading a mesh. */
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/vdb_read.h"
#include "render/scene/scene.h"

static lf_status put_bricks(lf_parcel_writer *parcel, const lf_grid *grid, lf_error *err)
{
    size_t n = (size_t)grid->bricks[0] * (size_t)grid->bricks[1] * (size_t)grid->bricks[2];
    lf_status status = LF_OK;
    for (size_t i = 0; i < n && status == LF_OK; i++) {
        uint32_t place = (uint32_t)i;
        if (grid->index[i])
            status = lf_parcel_append(parcel, LF_PARCEL_BRICKS, &place, 1, err);
    }
    return status == LF_OK ? lf_parcel_put(parcel, LF_PARCEL_VALUES, grid->values + LF_BRICK_STRIDE,
                                           (size_t)grid->n_bricks * LF_BRICK_STRIDE, err)
                           : status;
}

static lf_status put_grid(lf_parcel_writer *parcel, const lf_grid *grid, lf_error *err)
{
    const int64_t size[3] = {grid->size[0], grid->size[1], grid->size[2]};
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_SIZE, size, 3, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_MAP, grid->local_to_file, 12, err);
    if (status == LF_OK && grid->others)
        status =
            lf_parcel_put(parcel, LF_PARCEL_OTHERS, grid->others, strlen(grid->others) + 1, err);
    const lf_grid_odd *odd = &grid->odd;
    if (status == LF_OK && (odd->n_negative > 0 || odd->n_not_finite > 0 || odd->background != 0))
        status = lf_parcel_put(
            parcel, LF_PARCEL_ODD,
            (double[4]){odd->n_negative, odd->least, odd->n_not_finite, odd->background}, 4, err);
    return status == LF_OK ? put_bricks(parcel, grid, err) : status;
}

static lf_status put_names(int fd, lf_parcel_writer *parcel, lf_error *err)
{
    char names[LF_VDB_NAMES_BYTES];
    lf_status status = lf_vdb_list(fd, names, sizeof names, err);
    return status == LF_OK ? lf_parcel_put(parcel, LF_PARCEL_OTHERS, names, strlen(names) + 1, err)
                           : status;
}

static lf_status read_grid(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                           lf_error *err)
{
    if (request->lists)
        return put_names(fd, parcel, err);
    lf_grid *grid = NULL;
    lf_status status = lf_vdb_read(fd, request->grid, request->is_velocity != 0, &grid, err);
    if (status == LF_OK)
        status = put_grid(parcel, grid, err);
    lf_grid_unref(grid);
    return status;
}

int main(void)
{
    return lf_reader_main(&(lf_import_reader){.begin = lf_vdb_begin, .read = read_grid});
}
