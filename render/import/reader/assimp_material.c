/* Converts Assimp's materials (3DS: Phong's model), and records lost features. */
#include "render/import/reader/assimp_material.h"

#include <assimp/material.h>
#include <assimp/scene.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"

static float clamp_unit(float v)
{
    return v > 0.0f ? fminf(v, 1.0f) : 0.0f; /* NaN gives 0 */
}

static bool get_colour(const struct aiMaterial *m, const char *key, unsigned type, unsigned index,
                       lf_vec3 *out)
{
    struct aiColor4D c;
    if (aiGetMaterialColor(m, key, type, index, &c) != aiReturn_SUCCESS)
        return false;
    *out = lf_v3(clamp_unit(c.r), clamp_unit(c.g), clamp_unit(c.b));
    return true;
}

static bool get_float(const struct aiMaterial *m, const char *key, unsigned type, unsigned index,
                      float *out)
{
    float v;
    if (aiGetMaterialFloatArray(m, key, type, index, &v, NULL) != aiReturn_SUCCESS || !isfinite(v))
        return false;
    *out = v;
    return true;
}

static lf_vec3 get_emission(const struct aiMaterial *m)
{
    struct aiColor4D c;
    if (aiGetMaterialColor(m, AI_MATKEY_COLOR_EMISSIVE, &c) != aiReturn_SUCCESS)
        return lf_v3(0, 0, 0);
    return lf_v3(c.r, c.g, c.b);
}

static bool has_texture(const struct aiMaterial *m, enum aiTextureType type)
{
    return aiGetMaterialTextureCount(m, type) > 0;
}

static bool has_textures(const struct aiMaterial *m)
{
    for (unsigned type = 1; type < aiTextureType_UNKNOWN; type++)
        if (has_texture(m, (enum aiTextureType)type))
            return true;
    return false;
}

static bool emits_by_texture(const struct aiMaterial *m)
{
    return has_texture(m, aiTextureType_EMISSIVE) || has_texture(m, aiTextureType_EMISSION_COLOR);
}

static void get_name(const struct aiMaterial *m, struct aiString *out)
{
    out->length = 0;
    out->data[0] = '\0';
    aiGetMaterialString(m, AI_MATKEY_NAME, out);
}

static bool is_white(const struct aiMaterial *m, const char *key, unsigned type, unsigned index)
{
    lf_vec3 c;
    return get_colour(m, key, type, index, &c) && c.x == 1.0f && c.y == 1.0f && c.z == 1.0f;
}

/* A material that Assimp invents for meshes without one: it has a name of Assimp's, or no name and
 * is all white. */
static bool is_made_up(const struct aiMaterial *m)
{
    struct aiString name;
    get_name(m, &name);
    if (name.length > 0)
        return strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) == 0;
    return !has_textures(m) && !(lf_max3(get_emission(m)) > 0.0f) &&
           is_white(m, AI_MATKEY_COLOR_DIFFUSE) && is_white(m, AI_MATKEY_COLOR_SPECULAR) &&
           is_white(m, AI_MATKEY_COLOR_AMBIENT);
}

/* ----------------------------------------------------------------------------- lost features -- */

static bool is_transparent(const struct aiMaterial *m)
{
    struct aiColor4D filter;
    float opacity;
    return (get_float(m, AI_MATKEY_OPACITY, &opacity) && opacity < 1.0f) ||
           has_texture(m, aiTextureType_OPACITY) ||
           (aiGetMaterialColor(m, AI_MATKEY_COLOR_TRANSPARENT, &filter) == aiReturn_SUCCESS &&
            !(filter.r == 1.0f && filter.g == 1.0f && filter.b == 1.0f));
}

static unsigned losses(const struct aiMaterial *m)
{
    return (has_textures(m) ? 1u << LF_LOST_TEXTURES : 0) |
           (emits_by_texture(m) ? 1u << LF_LOST_EMISSION : 0) |
           (is_transparent(m) ? 1u << LF_LOST_TRANSPARENCY : 0);
}

/* --------------------------------------------------------------------------------------- all -- */

static lf_source_material said_of(const struct aiMaterial *m)
{
    struct aiString name;
    get_name(m, &name);
    lf_source_material source = lf_source_material_begin(name.data);
    source.is_none = is_made_up(m);
    source.emission = get_emission(m);
    get_float(m, AI_MATKEY_REFRACTI, &source.ior);
    get_colour(m, AI_MATKEY_COLOR_DIFFUSE, &source.albedo);
    get_colour(m, AI_MATKEY_COLOR_SPECULAR, &source.highlight);
    get_float(m, AI_MATKEY_SHININESS, &source.exponent);
    source.lost = losses(m);
    return source;
}

static void mark_used(const struct aiScene *scene, bool *used)
{
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        const struct aiMesh *mesh = scene->mMeshes[i];
        if ((mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE) &&
            mesh->mMaterialIndex < scene->mNumMaterials)
            used[mesh->mMaterialIndex] = true;
    }
}

lf_status lf_mesh_materials(const struct aiScene *scene, lf_mesh_data *out, lf_error *err)
{
    bool used[LF_MAX_MATERIALS] = {false};
    size_t n = scene->mNumMaterials;
    lf_source_material *source =
        n > 0 && n <= LF_MAX_MATERIALS ? lf_calloc(n, sizeof *source) : NULL;
    for (size_t i = 0; source && i < n; i++)
        source[i] = said_of(scene->mMaterials[i]);
    if (source)
        mark_used(scene, used);
    lf_status status = LF_OK;
    for (size_t i = 0; source && i < n; i++)
        if (!source[i].name)
            status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (status == LF_OK)
        status = lf_source_materials_convert(source, source ? n : 0, used, out, err);
    for (size_t i = 0; source && i < n; i++)
        lf_free(source[i].name);
    lf_free(source);
    return status;
}
