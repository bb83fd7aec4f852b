#include "render/load/places_import.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/load/mesh_repeat.h"

static lf_status take_list(const lf_places_desc *desc, lf_mesh_data *data)
{
    data->places = lf_calloc((size_t)desc->n, sizeof *data->places);
    if (!data->places)
        return LF_E_NOMEM;
    memcpy(data->places, desc->map, (size_t)desc->n * sizeof *data->places);
    data->n_places = desc->n;
    return LF_OK;
}

/* As if an enemy had written it (parcel.h). */
static lf_status take_parcel(const lf_parcel *parcel, const char *path, lf_mesh_data *data,
                             lf_error *err)
{
    size_t n;
    const double *numbers = lf_parcel_get(parcel, LF_PARCEL_PLACES, &n);
    if (!numbers || n % 12 != 0 || n / 12 > LF_MAX_PLACES)
        return lf_error_set(err, LF_E_FORMAT, path, "the reader's answer has no places");
    data->places = lf_calloc(n / 12, sizeof *data->places);
    if (!data->places)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    data->n_places = (int)(n / 12);
    memcpy(data->places, numbers, n * sizeof *numbers);
    for (int i = 0; i < data->n_places; i++) {
        const lf_affine *map = &data->places[i];
        lf_affine inverse;
        bool sound = lf_affine_invert(map, &inverse);
        for (int j = 0; j < 12; j++)
            sound = sound && fabs(map->m[j / 4][j % 4]) <= LF_MAX_COORDINATE;
        if (!sound)
            return lf_error_set(err, LF_E_FORMAT, path, "the reader's answer has no such place");
    }
    return LF_OK;
}

static lf_status import_file(const char *path, const lf_roots *roots, lf_mesh_data *data,
                             lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_PLACES};
    lf_parcel parcel = {0};
    int fd = -1;
    if (strlen(path) >= sizeof request.path)
        return lf_error_set(err, LF_E_FORMAT, path, "the path is too long");
    memcpy(request.path, path, strlen(path) + 1);
    lf_status status = lf_file_open(path, roots, LF_MESH_MAX_BYTES, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = lf_mesh_note_file(data, path, fd, err);
    if (status == LF_OK)
        status = lf_import_run(&request, fd, path, NULL, NULL, &parcel, err);
    if (status == LF_OK)
        status = take_parcel(&parcel, path, data, err);
    lf_parcel_close(&parcel);
    close(fd);
    return status;
}

lf_status lf_places_import(const lf_mesh_desc *desc, const char *folder, const lf_roots *roots,
                           bool emits, lf_mesh_data *data, lf_error *err)
{
    lf_status status = LF_OK;
    if (desc->places.file) {
        char *path = lf_path_join(folder, desc->places.file);
        status = path ? import_file(path, roots, data, err) : LF_E_NOMEM;
        lf_free(path);
    } else if (desc->places.n > 0) {
        status = take_list(&desc->places, data);
    }
    if (status != LF_OK || data->n_places == 0 || !emits)
        return status;
    const int places = data->n_places, triangles = data->n_triangles;
    status = lf_mesh_repeat(data);
    if (status == LF_E_NOMEM)
        lf_error_set(
            err, status, desc->places.file ? desc->places.file : desc->name,
            "%d instances of %d triangles, some of which shine, which is done by copies of "
            "at most %d triangles: give what shines as a mesh of its own",
            places, triangles, LF_MAX_REPEATED);
    return status;
}
