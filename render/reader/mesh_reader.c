/* quiltimport: meshes. */
#include <string.h>

#include "base/reader/reader.h"
#include "render/reader/mesh_read.h"
#include "render/transport/surface.h"

static uint32_t place_of(const lf_surface_kind *kind)
{
    uint32_t i = 0;
    while (lf_surface_kinds[i] != kind)
        i++;
    return i;
}

static lf_status put_materials(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < data->n_materials && status == LF_OK; i++) {
        const lf_material *m = &data->materials[i];
        const lf_parcel_material out = {.kind = place_of(m->kind),
                                        .albedo = {m->albedo.x, m->albedo.y, m->albedo.z},
                                        .roughness = m->roughness,
                                        .ior = m->ior,
                                        .emission = {m->emission.x, m->emission.y, m->emission.z}};
        status = lf_parcel_append(parcel, LF_PARCEL_MATERIALS, &out, 1, err);
    }
    return status;
}

/* Lines without the name of the file that stands before each. */
static lf_status put_warnings(lf_parcel_writer *parcel, const lf_warnings *warnings, lf_error *err)
{
    lf_status status = LF_OK;
    const char *line;
    for (int i = 0; (line = lf_warnings_at(warnings, i)) && status == LF_OK; i++) {
        size_t before = strlen(LF_HERE ": ");
        line += strncmp(line, LF_HERE ": ", before) == 0 ? before : 0;
        status = lf_parcel_put(parcel, LF_PARCEL_WARNINGS, line, strlen(line), err);
        if (status == LF_OK)
            status = lf_parcel_put(parcel, LF_PARCEL_WARNINGS, "\n", 1, err);
    }
    return status;
}

static lf_status put_mesh(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    size_t v = 3 * (size_t)data->n_vertices, t = (size_t)data->n_triangles;
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_POSITIONS, data->positions, v, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_NORMALS, data->normals, v, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_TRIANGLES, data->triangles, 3 * t, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_CHOICES, data->triangle_material, t, err);
    if (status == LF_OK)
        status = put_materials(parcel, data, err);
    return status == LF_OK ? put_warnings(parcel, &data->warnings, err) : status;
}

static lf_status read_mesh(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                           lf_error *err)
{
    lf_mesh_desc desc = {.file = request->path,
                         .material = request->materials ? -1 : 0,
                         .normals = (lf_normals)request->normals};
    lf_mesh_data data = {0};
    memcpy(desc.transform.m, request->transform, sizeof request->transform);
    lf_status status = lf_mesh_read(&desc, fd, &data, err);
    if (status == LF_OK)
        status = put_mesh(parcel, &data, err);
    lf_mesh_data_finish(&data);
    return status;
}

int main(void)
{
    return lf_reader_main(&(lf_import_reader){.read = read_mesh});
}
