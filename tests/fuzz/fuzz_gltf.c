/* glTF as quiltimport reads it: a byte that chooses (also the moment of an animation), JSON up to a
 * zero, and the bytes of its buffer, which are every file beside it, too. Refused in words, or a
 * mesh whose every number is one that whoever takes it over accepts. */
#include "tests/fuzz/fuzz.h"

#include <math.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_read.h"

static const uint8_t *buffer;
static size_t n_buffer;

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    lf_fuzz_require(name[0]);
    *out_fd = lf_fuzz_file(buffer, n_buffer);
    return LF_OK;
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    return lf_ask_for_file(name, out_fd);
}

static void put_word(uint8_t *to, size_t word)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(word >> 8 * i);
}

/* A GLB of both; close it. */
static int make_glb(const uint8_t *json, size_t n_json)
{
    size_t text = (n_json + 3) / 4 * 4, rest = (n_buffer + 3) / 4 * 4, size = 28 + text + rest;
    uint8_t *glb = calloc(1, size);
    lf_fuzz_require(glb);
    memcpy(glb, "glTF\2", 5);
    put_word(glb + 8, size);
    put_word(glb + 12, text);
    memcpy(glb + 16, "JSON", 4);
    memset(glb + 20, ' ', text);
    memcpy(glb + 20, json, n_json);
    put_word(glb + 20 + text, rest);
    memcpy(glb + 24 + text, "BIN", 3);
    if (n_buffer > 0)
        memcpy(glb + 28 + text, buffer, n_buffer);
    int fd = lf_fuzz_file(glb, size);
    free(glb);
    return fd;
}

static void check_unit(const float *v)
{
    lf_fuzz_require(fabsf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1) < 1e-3f);
}

static void check_vertices(const lf_mesh_data *data)
{
    size_t n = (size_t)data->n_vertices;
    for (size_t i = 0; i < 3 * n; i++)
        lf_fuzz_require(fabs(data->positions[i]) <= LF_MAX_COORDINATE);
    for (size_t i = 0; i < 2 * n * (size_t)data->n_uv_sets; i++)
        lf_fuzz_require(fabsf(data->uvs[i]) <= LF_MAX_UV);
    for (size_t i = 0; data->colours && i < 4 * n; i++)
        lf_fuzz_require(data->colours[i] >= 0 && data->colours[i] <= 1);
    for (size_t i = 0; i < n && data->tangents; i++) {
        check_unit(data->tangents + 4 * i);
        lf_fuzz_require(fabsf(data->tangents[4 * i + 3]) == 1);
    }
}

static void check_triangles(const lf_mesh_data *data)
{
    lf_fuzz_require(data->n_triangles > 0);
    for (size_t i = 0; i < 3 * (size_t)data->n_triangles; i++) {
        lf_fuzz_require(data->triangles[i] < (uint32_t)data->n_vertices);
        if (data->normals)
            check_unit(data->normals + 3 * (size_t)data->triangles[i]);
    }
    for (int i = 0; data->triangle_material && i < data->n_triangles; i++)
        lf_fuzz_require(data->triangle_material[i] < data->n_materials);
}

static void check_materials(const lf_mesh_data *data)
{
    for (int i = 0; i < data->n_materials; i++) {
        const lf_material *m = &data->materials[i];
        lf_fuzz_require(m->ior >= 1 && m->ior <= (float)LF_MAX_INDEX && m->roughness >= 0 &&
                        m->roughness <= 1);
        lf_fuzz_require(m->metallic >= 0 && m->metallic <= 1 && m->cover < LF_COVERS);
        lf_fuzz_require(m->absorption.x >= 0 && isfinite(m->absorption.x));
        for (int slot = 0; data->textures && slot < LF_SLOTS; slot++) {
            const lf_texture *t = &data->textures[i].slot[slot];
            lf_fuzz_require(t->picture <= (uint32_t)data->n_pictures);
            lf_fuzz_require(t->picture == 0 || t->set < data->n_uv_sets);
            lf_fuzz_require(isfinite(t->map[0][0] + t->map[1][1] + t->scale));
        }
    }
}

static void check_lights(const lf_punctuals *lights)
{
    lf_fuzz_require(lights->n <= LF_MAX_PUNCTUAL);
    for (int i = 0; i < lights->n; i++) {
        const lf_punctual *light = &lights->open[i];
        const float d[3] = {(float)light->direction[0], (float)light->direction[1],
                            (float)light->direction[2]};
        if (light->kind != LF_PUNCTUAL_POINT)
            check_unit(d);
        lf_fuzz_require(light->inner >= 0 && light->inner <= light->outer && light->outer < 1.5708);
        for (int k = 0; k < 3; k++)
            lf_fuzz_require(light->intensity[k] >= 0 && light->intensity[k] <= LF_MAX_RADIANCE &&
                            fabs(light->position[k]) <= LF_MAX_COORDINATE);
    }
}

static void check_cameras(const lf_file_cameras *cameras)
{
    lf_fuzz_require(cameras->n <= LF_MAX_FILE_CAMERAS);
    for (int i = 0; i < cameras->n; i++) {
        const lf_file_camera *camera = &cameras->open[i];
        const float look[3] = {(float)camera->look[0], (float)camera->look[1],
                               (float)camera->look[2]},
                    up[3] = {(float)camera->up[0], (float)camera->up[1], (float)camera->up[2]};
        check_unit(look);
        check_unit(up);
        lf_fuzz_require(fabsf(look[0] * up[0] + look[1] * up[1] + look[2] * up[2]) < 1e-3f);
        lf_fuzz_require(camera->number >= 0 && camera->fov_y >= LF_FILE_CAMERA_LEAST_FOV &&
                        camera->fov_y <= LF_FILE_CAMERA_MOST_FOV);
        for (int k = 0; k < 3; k++)
            lf_fuzz_require(fabs(camera->position[k]) <= LF_MAX_COORDINATE);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_mesh_desc desc = {.file = "folder/mesh.glb", .transform = lf_affine_identity()};
    lf_mesh_data mesh = {0};
    lf_error err = {0};
    if (size == 0)
        return 0;
    const uint8_t *json = data + 1, *end = memchr(json, 0, size - 1);
    size_t n_json = end ? (size_t)(end - json) : size - 1;
    buffer = end ? end + 1 : json;
    n_buffer = end ? size - 2 - n_json : 0;
    desc.normals = (lf_normals)(data[0] % 3);
    desc.material = data[0] / 3 % 8 == 7 ? 0 : -1;
    desc.clip.seconds = 0.3 * (data[0] / 24);
    int fd = make_glb(json, n_json);
    if (lf_gltf_read(&desc, fd, &mesh, &err) == LF_OK) {
        check_triangles(&mesh);
        check_vertices(&mesh);
        check_materials(&mesh);
        check_lights(&mesh.lights);
        check_cameras(&mesh.cameras);
    } else {
        lf_fuzz_require(err.what[0]);
    }
    lf_mesh_data_finish(&mesh);
    close(fd);
    return 0;
}
