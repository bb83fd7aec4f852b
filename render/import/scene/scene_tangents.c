#include "render/import/scene/scene_tangents.h"

#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/material_parse.h"
#include "render/import/scene/tangents.h"

/* The mesh with the scene's materials in place of the file's. */
typedef struct stand_in {
    lf_mesh_data data;
    int *of_scene; /* [data.n_materials]; -1: the file's */
} stand_in;

static const lf_texture *normal_map(const lf_scene_desc *scene, int material)
{
    const lf_picture_desc *normal = &scene->pictures[material].slot[LF_SLOT_NORMAL][0];
    return normal->file ? &normal->texture : NULL;
}

static void release(stand_in *s, const lf_mesh_data *data)
{
    lf_free(s->of_scene);
    lf_free(s->data.materials);
    lf_free(s->data.textures);
    if (s->data.triangle_material != data->triangle_material)
        lf_free(s->data.triangle_material);
}

static bool allocate(const lf_mesh_desc *mesh, const lf_mesh_data *data, stand_in *out)
{
    const size_t n = mesh->material >= 0 ? 1 : (size_t)data->n_materials;
    *out = (stand_in){.data = *data, .of_scene = lf_calloc(n, sizeof *out->of_scene)};
    out->data.n_materials = (int)n;
    out->data.materials = lf_calloc(n, sizeof *out->data.materials);
    out->data.textures = lf_calloc(n, sizeof *out->data.textures);
    if (mesh->material >= 0)
        out->data.triangle_material =
            lf_calloc((size_t)data->n_triangles, sizeof *out->data.triangle_material);
    return out->of_scene && out->data.materials && out->data.textures &&
           out->data.triangle_material;
}

static void put_materials(const lf_scene_desc *scene, const lf_mesh_desc *mesh,
                          const lf_mesh_data *data, stand_in *s)
{
    for (int i = 0; i < s->data.n_materials; i++) {
        const int own = mesh->material >= 0 ? mesh->material
                        : data->names       ? lf_mesh_override(mesh, data->names[i])
                                            : -1;
        s->of_scene[i] = own;
        if (own < 0) {
            s->data.materials[i] = data->materials[i];
            s->data.textures[i] = data->textures ? data->textures[i] : (lf_texture_set){0};
            continue;
        }
        const lf_texture *map = normal_map(scene, own);
        s->data.materials[i] = scene->materials[own];
        if (map)
            s->data.textures[i].slot[LF_SLOT_NORMAL] = *map;
    }
}

/* So that they are recomputed. */
static void forget_tangents(stand_in *s)
{
    for (size_t c = 0; s->data.tangents && c < 3 * (size_t)s->data.n_triangles; c++)
        if (s->of_scene[s->data.triangle_material[c / 3]] >= 0)
            memset(s->data.tangents + 4 * (size_t)s->data.triangles[c], 0,
                   4 * sizeof *s->data.tangents);
}

lf_status lf_scene_tangents(const lf_scene_desc *scene, const lf_mesh_desc *mesh,
                            lf_mesh_data *data, lf_error *err)
{
    stand_in s;
    if (!mesh->wants.tangents || data->n_uv_sets == 0)
        return LF_OK;
    lf_status status = LF_E_NOMEM;
    if (allocate(mesh, data, &s)) {
        put_materials(scene, mesh, data, &s);
        forget_tangents(&s);
        status = lf_mesh_tangents(&s.data, err);
        data->tangents = s.data.tangents;
    } else {
        lf_error_set(err, status, mesh->name, "out of memory");
    }
    release(&s, data);
    return status;
}

static bool put_key(const lf_scene_desc *scene, int material, const char *name, json_t *key)
{
    const lf_texture *map = material >= 0 ? normal_map(scene, material) : NULL;
    return !map || json_object_set_new(key, name,
                                       json_pack("[f, f, f, f]", (double)map->map[0][0],
                                                 (double)map->map[0][1], (double)map->map[1][0],
                                                 (double)map->map[1][1])) == 0;
}

json_t *lf_scene_tangents_key(const lf_scene_desc *scene, const lf_mesh_desc *mesh)
{
    json_t *key = json_object();
    bool done = key && put_key(scene, mesh->material, "", key);
    for (int i = 0; i < mesh->n_overrides && done; i++)
        done = put_key(scene, mesh->overrides[i].material, mesh->overrides[i].name, key);
    if (done)
        return key;
    json_decref(key);
    return NULL;
}
