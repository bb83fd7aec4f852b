#include "render/import/scene/instances_import.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/import/scene/mesh_repeat.h"

/* ---------------------------------------------------------------------------------- checking -- */

/* As lf_instances keeps it. */
static bool is_flat(const lf_affine *place)
{
    lf_affine kept, inverse;
    for (int i = 0; i < 12; i++)
        kept.m[i / 4][i % 4] = (double)(float)place->m[i / 4][i % 4];
    return !lf_affine_invert(&kept, &inverse);
}

static void map_box(const lf_affine *map, const double own[2][3], double out[2][3])
{
    for (int i = 0; i < 3; i++) {
        out[0][i] = out[1][i] = map->m[i][3];
        for (int j = 0; j < 3; j++) {
            const double a = map->m[i][j] * own[0][j], b = map->m[i][j] * own[1][j];
            out[0][i] += fmin(a, b);
            out[1][i] += fmax(a, b);
        }
    }
}

bool lf_instance_is_sound(const lf_affine *place, const double own[2][3])
{
    double box[2][3];
    map_box(place, own, box);
    return lf_is_within_reach((const double(*)[3])box) && !is_flat(place);
}

static lf_status refuse(const lf_affine *place, const double own[2][3], int number,
                        const char *where, lf_error *err)
{
    if (is_flat(place))
        return lf_error_set(err, LF_E_FORMAT, where,
                            "instance %d, counted from 0, has a singular transform: its inverse "
                            "does not exist or exceeds %g",
                            number, LF_MAX_INVERSE);
    double box[2][3], most = 0.0;
    map_box(place, own, box);
    for (int i = 0; i < 6; i++)
        most = fmax(most, fabs(box[i / 3][i % 3]));
    return lf_error_set(
        err, LF_E_FORMAT, where,
        "instance %d, counted from 0, has coordinates up to %g; expected at most %g", number, most,
        LF_MAX_REACH);
}

lf_status lf_instances_check(const lf_mesh_data *data, const char *where, lf_error *err)
{
    double own[2][3] = {{0}};
    int last = -1;
    for (int i = 0; i < data->n_instances && data->n_triangles > 0; i++) {
        const int number = data->n_parts > 0 && data->part_of ? (int)data->part_of[i] : 0;
        const lf_mesh_part part = lf_mesh_data_part(data, number);
        if (number != last)
            lf_mesh_data_own_bounds(data, &part, own);
        last = number;
        if (!lf_instance_is_sound(&data->places[i], (const double(*)[3])own))
            return refuse(&data->places[i], (const double(*)[3])own, i, where, err);
    }
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- placing -- */

/* Appends n instances after the instances of the mesh's file, grouped by part. */
static lf_status put(lf_mesh_data *data, const lf_affine *place, size_t n, const char *where,
                     lf_error *err)
{
    const size_t own = data->n_instances > 0 ? (size_t)data->n_instances : 1;
    if (own * n > LF_MAX_INSTANCES)
        return lf_error_set(err, LF_E_NOMEM, where,
                            "%zu instances are too many; expected at most %d", own * n,
                            LF_MAX_INSTANCES);
    lf_affine *all = lf_calloc(own * n, sizeof *all);
    uint32_t *part_of = data->part_of ? lf_calloc(own * n, sizeof *part_of) : NULL;
    if (!all || (data->part_of && !part_of)) {
        lf_free(all);
        lf_free(part_of);
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    }
    for (size_t i = 0; i < own * n; i++) {
        all[i] = place[i % n];
        if (data->n_instances > 0)
            all[i] = lf_affine_compose(&place[i % n], &data->places[i / n]);
        if (part_of)
            part_of[i] = data->part_of[i / n];
    }
    lf_free(data->places);
    lf_free(data->part_of);
    data->places = all;
    data->part_of = part_of;
    data->n_instances = (int)(own * n);
    return LF_OK;
}

lf_status lf_instances_take(const lf_parcel *parcel, const char *path, lf_mesh_data *data,
                            lf_error *err)
{
    size_t n;
    const double *numbers = lf_parcel_get(parcel, LF_PARCEL_INSTANCES, &n);
    if (!numbers || n % 12 != 0 || n / 12 > LF_MAX_INSTANCES)
        return lf_error_set(err, LF_E_FORMAT, path, "the reader's answer has no instances");
    for (size_t i = 0; i < n / 12; i++) {
        bool sound = true;
        for (int j = 0; j < 12; j++)
            sound = sound && fabs(numbers[12 * i + (size_t)j]) <= LF_MAX_COORDINATE;
        if (!sound)
            return lf_error_set(err, LF_E_FORMAT, path,
                                "the reader's answer has invalid instances");
    }
    return put(data, (const lf_affine *)(const void *)numbers, n / 12, path, err);
}

/* Reads a file of instances and records it in data. */
static lf_status read_file(const char *path, const lf_roots *roots, lf_instances_file *file,
                           lf_mesh_data *data, lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_INSTANCES};
    int fd = -1;
    if (strlen(path) >= sizeof request.path)
        return lf_error_set(err, LF_E_FORMAT, path, "the path is too long");
    memcpy(request.path, path, strlen(path) + 1);
    lf_status status = lf_file_open(path, roots, LF_MESH_MAX_BYTES, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = lf_mesh_note_file(data, path, fd, err);
    if (status == LF_OK)
        status = lf_import_run(&request, fd, path, NULL, NULL, &file->parcel, err);
    close(fd);
    if (status != LF_OK)
        return status;
    file->noted = *lf_mesh_noted(data, path);
    file->noted.path = lf_strdup(path);
    return file->noted.path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

static lf_status import_file(const char *path, const lf_roots *roots, lf_instances_file *file,
                             lf_mesh_data *data, lf_error *err)
{
    lf_status status = file->noted.path ? lf_mesh_note_same(data, &file->noted, err)
                                        : read_file(path, roots, file, data, err);
    return status == LF_OK ? lf_instances_take(&file->parcel, path, data, err) : status;
}

void lf_instances_file_close(lf_instances_file *file)
{
    lf_parcel_close(&file->parcel);
    lf_free(file->noted.path);
    *file = (lf_instances_file){0};
}

lf_status lf_instances_import(const lf_mesh_desc *desc, const char *folder, const lf_roots *roots,
                              bool emits, lf_instances_file *file, lf_mesh_data *data,
                              lf_error *err)
{
    lf_status status = LF_OK;
    if (desc->places.file) {
        char *path = lf_path_join(folder, desc->places.file);
        status = path ? import_file(path, roots, file, data, err) : LF_E_NOMEM;
        lf_free(path);
    } else if (desc->places.n > 0) {
        status = put(data, desc->places.map, (size_t)desc->places.n, desc->name, err);
    }
    if (status == LF_OK)
        status = lf_instances_check(data, desc->places.file ? desc->places.file : desc->name, err);
    if (status != LF_OK || data->n_instances == 0 || !emits)
        return status;
    const int places = data->n_instances, triangles = data->n_triangles;
    status = lf_mesh_repeat(data);
    if (status == LF_E_NOMEM)
        lf_error_set(err, status, desc->places.file ? desc->places.file : desc->name,
                     "%d instances of %d triangles with emission exceed the limit of %d copied "
                     "triangles; make the emissive part a mesh of its own",
                     places, triangles, LF_MAX_REPEATED);
    return status;
}
