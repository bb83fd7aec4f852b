#include "render/import/scene/geometry_build.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/sandbox/import_group.h"
#include "render/import/scene/geometry_textures.h"
#include "render/import/scene/scene_tangents.h"
#include "render/scene/embree_commit.h"
#include "render/scene/instances.h"
#include "render/transport/surface/surface.h"

/* ----------------------------------------------------------------------------------- sharing -- */

static json_t *lamp_key(const lf_mesh_desc *mesh)
{
    json_t *key = json_pack("[s, s, f]", mesh->name, mesh->shape->name, mesh->area);
    bool done = key;
    for (int i = 0; i < 12 && done; i++)
        done = json_array_append_new(key, json_real(mesh->transform.m[i / 4][i % 4])) == 0;
    if (done)
        return key;
    json_decref(key);
    return NULL;
}

static bool is_gltf(const char *file)
{
    return file && (lf_path_has_ending(file, ".gltf") || lf_path_has_ending(file, ".glb"));
}

json_t *lf_geometry_key(const json_t *doc, const lf_scene_desc *desc, const char *folder)
{
    json_t *list = json_array(), *mesh;
    const char *name;
    int number = 0;
    json_object_foreach(json_object_get(doc, "meshes"), name, mesh)
    {
        json_t *copy = json_copy(mesh);
        json_t *clip = json_object_get(json_object_get(mesh, "animation"), "clip");
        const lf_mesh_desc *said = &desc->meshes[number++];
        /* decides about copies of meshes that may have instances */
        bool emits = said->emits && (lf_instances_are_given(&said->places) || is_gltf(said->file));
        if (json_object_get(mesh, "material"))
            json_object_set_new(copy, "material", json_true());
        json_object_del(copy, "materials");
        if (emits)
            json_object_set_new(copy, "shines", json_true());
        if (said->wants.uvs)
            json_object_set_new(copy, "wants", lf_scene_tangents_key(desc, said));
        json_object_del(copy, "animation");
        json_object_del(copy, "catcher");
        if (!said->stands)
            json_object_del(copy, "ground");
        json_object_del(copy, "lights");
        if (clip)
            json_object_set(copy, "animation", clip);
        if (json_array_append_new(list, json_pack("[s, o]", name, copy)) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    for (int i = 0; i < desc->n_meshes; i++) {
        if (desc->meshes[i].lamp && json_array_append_new(list, lamp_key(&desc->meshes[i])) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return json_pack("{s:s, s:o}", "folder", folder, "meshes", list);
}

json_t *lf_geometry_key_between(json_t *open, json_t *close)
{
    if (!open || !close || json_equal(open, close)) {
        json_decref(close);
        return open;
    }
    return json_pack("{s:o, s:o}", "open", open, "close", close);
}

static lf_status open_again(const lf_mesh_file *file, const lf_roots *roots, int *out_fd)
{
    lf_array array;
    return file->is_array ? lf_passed_open_array(roots ? roots->passed : NULL, file->path, NULL,
                                                 &array, out_fd, NULL)
                          : lf_file_open(file->path, roots, LF_MESH_MAX_BYTES, out_fd, NULL, NULL);
}

static bool file_is_unchanged(const lf_mesh_file *file, const lf_roots *roots)
{
    int fd;
    if (open_again(file, roots, &fd) != LF_OK)
        return false;
    struct stat info;
    bool same = fstat(fd, &info) == 0 && info.st_size == file->size && info.st_ino == file->inode &&
                info.st_mtim.tv_sec == file->modified.tv_sec &&
                info.st_mtim.tv_nsec == file->modified.tv_nsec;
    close(fd);
    return same;
}

/* The motion of mesh i. */
static lf_mesh_motion motion_of(lf_ends ends, int i, double span)
{
    return (lf_mesh_motion){span, lf_clip_moment(&ends[0]->meshes[i].clip, span),
                            lf_clip_moment(&ends[1]->meshes[i].clip, span)};
}

bool lf_geometry_matches(const lf_geometry *geometry, const json_t *key, lf_ends ends,
                         const lf_roots *roots)
{
    if (!json_equal(geometry->key, key))
        return false;
    for (int i = 0; i < geometry->n_meshes; i++) {
        lf_mesh_motion was = geometry->motions[i], is = motion_of(ends, i, was.span);
        if (is.moment != was.moment || is.close != was.close)
            return false;
    }
    for (int i = 0; i < geometry->n_files; i++)
        if (!file_is_unchanged(&geometry->files[i], roots))
            return false;
    return true;
}

/* ---------------------------------------------------------------------------------- building -- */

/* vertices NULL: no effect. */
static void grow_box(lf_box *box, const float *vertices, const lf_mesh_data *data)
{
    lf_vec3 min = box->min, max = box->max;
    for (size_t c = 0; vertices && c < 3 * (size_t)data->n_triangles; c++) {
        const float *p = vertices + 3 * (size_t)data->triangles[c];
        min = lf_v3(lf_min(min.x, p[0]), lf_min(min.y, p[1]), lf_min(min.z, p[2]));
        max = lf_v3(lf_max(max.x, p[0]), lf_max(max.y, p[1]), lf_max(max.z, p[2]));
    }
    *box = (lf_box){min, max};
}

/* Relative to the origin. One float of padding: Embree reads 16 bytes at the last vertex. NULL =
 * out of memory. */
static float *local_vertices(const double origin[3], const double *positions, int n)
{
    float *vertices = lf_calloc(3 * (size_t)n + 1, sizeof *vertices);
    for (size_t i = 0; vertices && i < 3 * (size_t)n; i++)
        vertices[i] = (float)(positions[i] - origin[i % 3]);
    return vertices;
}

/* Takes over the arrays of the shutter's close. */
static lf_status take_close(const lf_geometry *geometry, lf_mesh_data *data, lf_mesh *mesh)
{
    if (!data->close.positions)
        return LF_OK;
    const float *vertices =
        local_vertices(geometry->origin, data->close.positions, data->n_vertices);
    if (!vertices)
        return LF_E_NOMEM;
    mesh->close = (lf_mesh_close){vertices, data->close.normals, data->close.tangents};
    data->close.normals = data->close.tangents = NULL;
    return LF_OK;
}

/* The origin of a part: the middle of its box. */
static void middle_of(const lf_mesh_data *data, int part, double out[3])
{
    const lf_mesh_part whole = lf_mesh_data_part(data, part);
    double own[2][3];
    lf_mesh_data_own_bounds(data, &whole, own);
    for (int i = 0; i < 3; i++)
        out[i] = 0.5 * (own[0][i] + own[1][i]);
}

/* For an instanced mesh: its parts relative to their middles. NULL = out of memory. */
static float *own_vertices(const lf_mesh_data *data)
{
    const double world[3] = {0};
    float *vertices = local_vertices(world, data->positions, data->n_vertices);
    for (int i = 0; vertices && i < (data->n_parts > 0 ? data->n_parts : 1); i++) {
        const lf_mesh_part part = lf_mesh_data_part(data, i);
        double middle[3];
        middle_of(data, i, middle);
        for (size_t v = part.first_vertex; v < (size_t)part.first_vertex + part.n_vertices; v++)
            for (size_t axis = 0; axis < 3; axis++)
                vertices[3 * v + axis] = (float)(data->positions[3 * v + axis] - middle[axis]);
    }
    return vertices;
}

static bool allocate_instances(const lf_mesh_data *data, lf_instances *instances)
{
    instances->n_parts = data->n_parts > 0 ? data->n_parts : 1;
    instances->parts = lf_calloc((size_t)instances->n_parts, sizeof *instances->parts);
    instances->map = lf_calloc((size_t)data->n_instances, sizeof *instances->map);
    instances->part_of =
        data->n_parts > 0 ? lf_calloc((size_t)data->n_instances, sizeof *instances->part_of) : NULL;
    return instances->parts && instances->map && (data->n_parts == 0 || instances->part_of);
}

static void put_place(const lf_geometry *geometry, const lf_affine *place, const double middle[3],
                      float out[3][4])
{
    double at[3];
    lf_affine_point(place, middle, at);
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            out[row][column] = (float)place->m[row][column];
        out[row][3] = (float)(at[row] - geometry->origin[row]);
    }
}

static lf_status take_instances(lf_geometry *geometry, const lf_mesh_data *data, lf_mesh *mesh)
{
    lf_instances *instances = lf_calloc(1, sizeof *instances);
    mesh->instances = instances;
    if (!instances || !allocate_instances(data, instances))
        return LF_E_NOMEM;
    double(*middle)[3] = lf_calloc((size_t)instances->n_parts, sizeof *middle);
    if (!middle)
        return LF_E_NOMEM;
    for (int i = 0; i < instances->n_parts; i++) {
        const lf_mesh_part part = lf_mesh_data_part(data, i);
        instances->parts[i].first = part.first_triangle;
        instances->parts[i].n = part.n_triangles;
        middle_of(data, i, middle[i]);
    }
    for (int i = 0; i < data->n_instances; i++) {
        uint32_t part = data->n_parts > 0 ? data->part_of[i] : 0;
        put_place(geometry, &data->places[i], middle[part], instances->map[i]);
        if (instances->part_of)
            instances->part_of[i] = part;
    }
    lf_free(middle);
    instances->n = data->n_instances;
    instances->first = geometry->n_instances;
    geometry->n_instances += (uint32_t)data->n_instances;
    return lf_instances_build(instances, mesh, geometry->device);
}

/* Takes over the arrays of data; materials are numbered from first_material. */
static lf_status take_mesh(lf_geometry *geometry, lf_mesh_data *data, unsigned id,
                           int first_material)
{
    lf_mesh *mesh = &geometry->meshes[id];
    const bool instances = data->n_instances > 0 && data->n_triangles > 0;
    float *vertices = instances
                          ? own_vertices(data)
                          : local_vertices(geometry->origin, data->positions, data->n_vertices);
    if (!vertices)
        return LF_E_NOMEM;
    for (int t = 0; data->triangle_material && t < data->n_triangles; t++)
        data->triangle_material[t] = (uint16_t)(data->triangle_material[t] + first_material);
    *mesh = (lf_mesh){
        .geom_id = id,
        .n_vertices = data->n_vertices,
        .n_triangles = data->n_triangles,
        .vertices = vertices,
        .triangles = data->triangles,
        .normals = data->normals,
        .triangle_material = data->triangle_material,
        .box = {lf_v3(INFINITY, INFINITY, INFINITY), lf_v3(-INFINITY, -INFINITY, -INFINITY)},
        .uvs = data->uvs,
        .colours = data->colours,
        .tangents = data->tangents};
    lf_status status = take_close(geometry, data, mesh);
    grow_box(&mesh->box, mesh->vertices, data);
    grow_box(&mesh->box, mesh->close.vertices, data);
    if (instances && status == LF_OK)
        status = take_instances(geometry, data, mesh);
    data->triangles = NULL;
    data->normals = NULL;
    data->triangle_material = NULL;
    data->uvs = data->colours = data->tangents = NULL;
    return status;
}

/* Moves materials, file notes and warnings of all meshes into the geometry. */
static lf_status take_lists(lf_geometry *geometry, lf_mesh_data *data, int n)
{
    int n_materials = 0, n_files = 0;
    for (int i = 0; i < n; i++) {
        n_materials += data[i].n_materials;
        n_files += data[i].n_files;
    }
    geometry->materials = lf_calloc((size_t)n_materials, sizeof *geometry->materials);
    geometry->files = lf_calloc((size_t)n_files, sizeof *geometry->files);
    geometry->material_names = lf_calloc((size_t)n_materials, sizeof *geometry->material_names);
    geometry->first_material = lf_calloc((size_t)n + 1, sizeof *geometry->first_material);
    if (!geometry->materials || !geometry->files || !geometry->material_names ||
        !geometry->first_material)
        return LF_E_NOMEM;
    for (int i = 0; i < n; i++) {
        lf_warnings_add_all(&geometry->warnings, &data[i].warnings);
        if (data[i].n_materials)
            memcpy(geometry->materials + geometry->n_materials, data[i].materials,
                   (size_t)data[i].n_materials * sizeof *data[i].materials);
        if (data[i].names)
            memcpy(geometry->material_names + geometry->n_materials, data[i].names,
                   (size_t)data[i].n_materials * sizeof *data[i].names);
        geometry->first_material[i + 1] = geometry->n_materials + data[i].n_materials;
        memcpy(geometry->files + geometry->n_files, data[i].files,
               (size_t)data[i].n_files * sizeof data[i].files[0]);
        for (int j = 0; j < data[i].n_files; j++)
            geometry->files[geometry->n_files + j].mesh = i;
        geometry->n_materials += data[i].n_materials;
        geometry->n_files += data[i].n_files;
        data[i].n_files = 0;
    }
    lf_status status = lf_geometry_take_textures(geometry, data, n);
    for (int i = 0; i < n_materials && status == LF_OK; i++)
        lf_material_prepare(&geometry->materials[i]);
    return status;
}

/* The mesh's triangles for Embree. If there are large ones, a copy in which those are degenerate;
 * true: success. */
static bool share_triangles(const lf_mesh *mesh, const lf_large *large, RTCGeometry shape)
{
    const size_t size = 3 * sizeof(uint32_t), n = (size_t)mesh->n_triangles;
    uint32_t at = 0, *copy = NULL;
    while (at < large->n && large->triangles[at].mesh < mesh->geom_id)
        at++;
    if (at == large->n || large->triangles[at].mesh != mesh->geom_id) {
        rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh->triangles, 0, size, n);
        return true;
    }
    copy = rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, size, n);
    if (!copy)
        return false;
    memcpy(copy, mesh->triangles, size * n);
    for (; at < large->n && large->triangles[at].mesh == mesh->geom_id; at++) {
        uint32_t *corner = copy + 3 * (size_t)large->triangles[at].triangle;
        corner[1] = corner[2] = corner[0];
    }
    return true;
}

static bool attach_mesh(lf_geometry *geometry, const lf_mesh *mesh)
{
    const float *const vertices[] = {mesh->vertices, mesh->close.vertices};
    const unsigned times = mesh->close.vertices ? 2 : 1;
    RTCGeometry shape = rtcNewGeometry(geometry->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!shape)
        return false;
    rtcSetGeometryTimeStepCount(shape, times);
    for (unsigned i = 0; i < times; i++)
        rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3, vertices[i],
                                   0, 3 * sizeof(float), (size_t)mesh->n_vertices);
    if (!share_triangles(mesh, &geometry->large, shape)) {
        rtcReleaseGeometry(shape);
        return false;
    }
    rtcSetGeometryBuildQuality(shape, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(geometry->embree, shape, mesh->geom_id);
    rtcReleaseGeometry(shape);
    return rtcGetDeviceError(geometry->device) == RTC_ERROR_NONE;
}

/* Embree and our code round the position of a moving vertex separately: bound of the difference. */
static float moving_error(const lf_geometry *geometry)
{
    float most = 0.0f;
    for (int i = 0; i < geometry->n_meshes; i++) {
        const lf_box *box = &geometry->meshes[i].box;
        const float ends[] = {box->min.x, box->min.y, box->min.z,
                              box->max.x, box->max.y, box->max.z};
        for (int j = 0; geometry->meshes[i].close.vertices && j < 6; j++)
            most = lf_max(most, fabsf(ends[j]));
    }
    return 2.4e-7f * most;
}

/* Rays are rounded once more in the space of an instance. */
static float instances_error(const lf_geometry *geometry)
{
    float most = 0.0f;
    for (int i = 0; i < geometry->n_meshes; i++) {
        const lf_instances *instances = geometry->meshes[i].instances;
        if (instances)
            most = lf_max(most, instances->reach);
    }
    return 5e-7f * most;
}

static lf_status build_bvh(lf_geometry *geometry, lf_error *err)
{
    if (lf_large_pick(geometry->meshes, geometry->n_meshes, &geometry->large, &geometry->offset) !=
        LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "meshes", "out of memory");
    geometry->offset += moving_error(geometry) + instances_error(geometry);
    for (int i = 0; i < geometry->n_meshes; i++)
        if (!(geometry->meshes[i].instances
                  ? lf_instances_attach(&geometry->meshes[i], geometry->device, geometry->embree)
                  : attach_mesh(geometry, &geometry->meshes[i])))
            return lf_error_set(err, LF_E_NOMEM, "meshes", "Embree cannot attach mesh %d", i);
    if (geometry->large.n > 0 && !lf_large_attach(&geometry->large, geometry->device,
                                                  geometry->embree, (unsigned)geometry->n_meshes))
        return lf_error_set(err, LF_E_NOMEM, "meshes", "Embree cannot attach the large triangles");
    return lf_embree_commit(geometry->embree, geometry->device, err);
}

/* Moves all mesh data except Embree's BVH. */
static lf_status take_meshes(lf_geometry *geometry, lf_mesh_data *data, lf_ends ends)
{
    const int n = ends[0]->n_meshes;
    double bounds[2][3] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    int first_material = 0;
    for (int i = 0; i < n; i++) {
        lf_mesh_data_bounds(&data[i], bounds);
        geometry->n_meshes++;
        lf_status status = take_mesh(geometry, &data[i], (unsigned)i, first_material);
        if (status != LF_OK)
            return status;
        geometry->motions[i] = motion_of(ends, i, data[i].span);
        geometry->lights[i] = data[i].lights;
        geometry->cameras[i] = data[i].cameras;
        data[i].lights = (lf_punctuals){0};
        data[i].cameras = (lf_file_cameras){0};
        first_material += data[i].n_materials;
    }
    memcpy(geometry->bounds, bounds, sizeof bounds);
    return take_lists(geometry, data, n);
}

lf_status lf_geometry_build(lf_mesh_data *data, lf_ends ends, const double origin[3], json_t *key,
                            lf_geometry **out_geometry, lf_error *err)
{
    lf_geometry *geometry;
    lf_status status = lf_geometry_create(ends[0]->n_meshes, origin, key, &geometry, err);
    if (status != LF_OK)
        return status;
    status = take_meshes(geometry, data, ends);
    if (status == LF_E_NOMEM)
        lf_error_set(err, LF_E_NOMEM, "meshes", "out of memory");
    if (status == LF_OK)
        status = build_bvh(geometry, err);
    if (status == LF_E_CANCELLED)
        (void)lf_import_say_stopped("meshes", err);
    if (status != LF_OK)
        lf_geometry_unref(geometry);
    else
        *out_geometry = geometry;
    return status;
}
