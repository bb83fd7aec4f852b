/* quiltimport: meshes, their instances, and their images. */
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/instances_read.h"
#include "render/import/reader/maps.h"
#include "render/import/reader/mesh_read.h"
#include "render/transport/surface/surface.h"

static uint32_t place_of(const lf_surface_kind *kind)
{
    uint32_t i = 0;
    while (lf_surface_kinds[i] != kind)
        i++;
    return i;
}

static void put_textures(const lf_texture_set *from, lf_parcel_material *out)
{
    for (int i = 0; i < LF_SLOTS; i++) {
        const lf_texture *t = &from->slot[i];
        out->texture[i] = (lf_parcel_texture){.picture = t->picture,
                                              .wrap_u = t->wrap_u,
                                              .wrap_v = t->wrap_v,
                                              .set = t->set,
                                              .nearest = t->nearest,
                                              .finest = t->finest,
                                              .scale = t->scale};
        memcpy(out->texture[i].map, t->map, sizeof t->map);
    }
}

static lf_status put_materials(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < data->n_materials && status == LF_OK; i++) {
        const lf_material *m = &data->materials[i];
        lf_parcel_material out = {.kind = place_of(m->kind),
                                  .cover = (uint32_t)m->cover,
                                  .is_solid = m->is_solid,
                                  .emits_by_colours = m->tint == LF_TINT_ALL};
        memcpy(out.name, data->names[i], sizeof out.name);
        if (data->textures)
            put_textures(&data->textures[i], &out);
        status = lf_parcel_append(parcel, LF_PARCEL_MATERIALS, &out, 1, err);
    }
    for (int i = 0; i < data->n_materials && status == LF_OK; i++)
        status = lf_parcel_append(parcel, LF_PARCEL_SCALARS, &data->materials[i].p,
                                  LF_PRINCIPLED_FLOATS, err);
    return status;
}

static lf_status put_pictures(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < data->n_pictures && status == LF_OK; i++) {
        const lf_texels *p = &data->pictures[i];
        const lf_parcel_picture out = {(uint32_t)p->width, (uint32_t)p->height};
        status = lf_parcel_append(parcel, LF_PARCEL_PICTURES, &out, 1, err);
    }
    for (int i = 0; i < data->n_pictures && status == LF_OK; i++) {
        const lf_texels *p = &data->pictures[i];
        status = lf_parcel_append(parcel, LF_PARCEL_TEXELS, p->rgba,
                                  4 * (size_t)p->width * (size_t)p->height, err);
    }
    return status;
}

/* Vertex data for materials. */
static lf_status put_looks(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    size_t n = (size_t)data->n_vertices;
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_CHOICES, data->triangle_material,
                                     (size_t)data->n_triangles, err);
    if (status == LF_OK)
        status = put_materials(parcel, data, err);
    if (status == LF_OK)
        status =
            lf_parcel_put(parcel, LF_PARCEL_UVS, data->uvs, 2 * n * (size_t)data->n_uv_sets, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_COLOURS, data->colours, 4 * n, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_TANGENTS, data->tangents, 4 * n, err);
    return status == LF_OK ? put_pictures(parcel, data, err) : status;
}

/* Lines without the file name that precedes each. */
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

static lf_status put_lights(lf_parcel_writer *parcel, const lf_punctuals *lights, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < lights->n && status == LF_OK; i++) {
        const lf_punctual *from = &lights->open[i];
        lf_parcel_light out = {.outer = from->outer, .inner = from->inner, .kind = from->kind};
        memcpy(out.position, from->position, sizeof out.position);
        memcpy(out.direction, from->direction, sizeof out.direction);
        memcpy(out.intensity, from->intensity, sizeof out.intensity);
        status = lf_parcel_append(parcel, LF_PARCEL_LIGHTS, &out, 1, err);
    }
    return status;
}

static lf_status put_cameras(lf_parcel_writer *parcel, const lf_file_cameras *cameras,
                             lf_error *err)
{
    _Static_assert(sizeof((lf_parcel_camera *)0)->name == LF_FILE_CAMERA_NAME, "names fit");
    lf_status status = LF_OK;
    for (int i = 0; i < cameras->n && status == LF_OK; i++) {
        const lf_file_camera *from = &cameras->open[i];
        lf_parcel_camera out = {
            .fov_y = from->fov_y, .number = (uint32_t)from->number, .parallel = from->parallel};
        memcpy(out.position, from->position, sizeof out.position);
        memcpy(out.look, from->look, sizeof out.look);
        memcpy(out.up, from->up, sizeof out.up);
        memcpy(out.name, from->name, sizeof out.name);
        memcpy(out.node_name, from->node_name, sizeof out.node_name);
        status = lf_parcel_append(parcel, LF_PARCEL_CAMERAS, &out, 1, err);
    }
    return status;
}

/* The parts of instanced meshes. */
static lf_status put_parts(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    _Static_assert(sizeof(lf_mesh_part) == 4 * sizeof(uint32_t), "four numbers");
    size_t n = (size_t)data->n_instances;
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_INSTANCES, data->places, 12 * n, err);
    if (status == LF_OK)
        status =
            lf_parcel_put(parcel, LF_PARCEL_PARTS, data->parts, 4 * (size_t)data->n_parts, err);
    return status == LF_OK ? lf_parcel_put(parcel, LF_PARCEL_PART_OF, data->part_of, n, err)
                           : status;
}

static lf_status put_mesh(lf_parcel_writer *parcel, const lf_mesh_data *data, lf_error *err)
{
    size_t v = 3 * (size_t)data->n_vertices, t = (size_t)data->n_triangles;
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_POSITIONS, data->positions, v, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_NORMALS, data->normals, v, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_TRIANGLES, data->triangles, 3 * t, err);
    if (status == LF_OK && (data->n_materials > 0 || data->uvs))
        status = put_looks(parcel, data, err);
    if (status == LF_OK && data->span > 0)
        status = lf_parcel_put(parcel, LF_PARCEL_SPAN, &data->span, 1, err);
    if (status == LF_OK)
        status = put_lights(parcel, &data->lights, err);
    if (status == LF_OK)
        status = put_cameras(parcel, &data->cameras, err);
    if (status == LF_OK && data->n_instances > 0)
        status = put_parts(parcel, data, err);
    return status == LF_OK ? put_warnings(parcel, &data->warnings, err) : status;
}

static lf_status read_instances(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                                lf_error *err)
{
    lf_instance_list places = {0};
    lf_status status = lf_instances_read(request->path, fd, &places, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_INSTANCES, places.map, 12 * places.n, err);
    lf_instance_list_finish(&places);
    return status;
}

static lf_status read_texture(int fd, lf_parcel_writer *parcel, lf_error *err)
{
    lf_texels texels = {0};
    const lf_mesh_data one = {.n_pictures = 1, .pictures = &texels};
    lf_status status = lf_map_decode(fd, &texels, err);
    if (status == LF_OK)
        status = put_pictures(parcel, &one, err);
    lf_free(texels.rgba);
    return status;
}

static lf_status read_mesh(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                           lf_error *err)
{
    if (request->kind == LF_IMPORT_INSTANCES)
        return read_instances(request, fd, parcel, err);
    if (request->kind == LF_IMPORT_TEXTURE)
        return read_texture(fd, parcel, err);
    lf_mesh_desc desc = {.file = request->path,
                         .material = request->materials ? -1 : 0,
                         .normals = (lf_normals)request->normals,
                         .emits = request->emits,
                         .wants = {.uvs = request->wants_uvs, .tangents = request->wants_tangents},
                         .variant = request->variant[0] ? request->variant : NULL,
                         .clip = {.name = request->clip[0] ? request->clip : NULL,
                                  .number = (int)request->clip_number,
                                  .chosen = request->clip_chosen,
                                  .once = request->once,
                                  .seconds = request->seconds_in}};
    lf_mesh_data data = {0};
    for (int i = 0; i < LF_MESH_N_ARRAYS; i++)
        desc.arrays.name[i] = (request->arrays & 1U << i) != 0 ? lf_mesh_array_keys[i] : NULL;
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
