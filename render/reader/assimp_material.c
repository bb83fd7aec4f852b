/* Assimp's materials made into ours, and what of them is lost on the way. */
#include "render/reader/assimp_material.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

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
    float strength = 1.0f;
    get_float(m, AI_MATKEY_EMISSIVE_INTENSITY, &strength);
    if (aiGetMaterialColor(m, AI_MATKEY_COLOR_EMISSIVE, &c) != aiReturn_SUCCESS)
        return lf_v3(0, 0, 0);
    float e[3] = {c.r * strength, c.g * strength, c.b * strength};
    for (int i = 0; i < 3; i++)
        e[i] = e[i] > 0.0f ? fminf(e[i], (float)LF_MAX_RADIANCE) : 0.0f;
    return lf_v3(e[0], e[1], e[2]);
}

/* glTF's metallic-roughness model: metals become conductors, the rest gets a coat unless it is
 * fully rough. */
static void convert_metallic(const struct aiMaterial *m, float metallic, lf_material *out)
{
    float roughness = 1.0f, ior = 1.5f;
    get_float(m, AI_MATKEY_ROUGHNESS_FACTOR, &roughness);
    get_float(m, AI_MATKEY_REFRACTI, &ior);
    get_colour(m, AI_MATKEY_BASE_COLOR, &out->albedo);
    out->roughness = clamp_unit(roughness);
    out->ior = fminf(fmaxf(ior, 1.0f), 3.0f);
    out->kind = metallic >= 0.5f          ? &lf_surface_conductor
                : out->roughness >= 0.99f ? &lf_surface_diffuse
                                          : &lf_surface_plastic;
}

/* Phong's Kd, Ks, Ns: a highlight without a diffuse part is a metal, with one a coat. */
static void convert_phong(const struct aiMaterial *m, lf_material *out)
{
    lf_vec3 specular = {0, 0, 0};
    float exponent = 0.0f, ior = 1.0f;
    get_colour(m, AI_MATKEY_COLOR_DIFFUSE, &out->albedo);
    get_colour(m, AI_MATKEY_COLOR_SPECULAR, &specular);
    get_float(m, AI_MATKEY_SHININESS, &exponent);
    get_float(m, AI_MATKEY_REFRACTI, &ior);
    if (!(lf_max3(specular) > 0.0f) || !(exponent > 0.0f))
        return;
    /* alpha = sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5), roughness = sqrt(alpha). */
    out->roughness = clamp_unit(powf(2.0f / (exponent + 2.0f), 0.25f));
    out->ior = ior > 1.0f ? fminf(ior, 3.0f) : 1.5f;
    out->kind = &lf_surface_plastic;
    if (!(lf_max3(out->albedo) > 0.0f)) {
        out->kind = &lf_surface_conductor;
        out->albedo = specular;
    }
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

static bool glows_by_texture(const struct aiMaterial *m)
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

/* What Assimp makes up for meshes without a material: by a name of its own (OBJ, STL, 3DS), or
 * nameless, with glTF's defaults or, for PLY, all white. A nameless material of a file that says
 * anything is none of these. */
static bool is_made_up(const struct aiMaterial *m)
{
    struct aiString name;
    float metallic, roughness;
    get_name(m, &name);
    if (name.length > 0)
        return strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) == 0;
    if (has_textures(m) || lf_max3(get_emission(m)) > 0.0f)
        return false;
    if (get_float(m, AI_MATKEY_METALLIC_FACTOR, &metallic))
        return metallic == 1.0f && get_float(m, AI_MATKEY_ROUGHNESS_FACTOR, &roughness) &&
               roughness == 1.0f && is_white(m, AI_MATKEY_BASE_COLOR);
    return is_white(m, AI_MATKEY_COLOR_DIFFUSE) && is_white(m, AI_MATKEY_COLOR_SPECULAR) &&
           is_white(m, AI_MATKEY_COLOR_AMBIENT);
}

static lf_material convert_material(const struct aiMaterial *m)
{
    lf_material out = {
        .kind = &lf_surface_diffuse, .albedo = {0.5f, 0.5f, 0.5f}, .roughness = 0.3f, .ior = 1.5f};
    float metallic;
    if (is_made_up(m))
        return out;
    if (get_float(m, AI_MATKEY_METALLIC_FACTOR, &metallic))
        convert_metallic(m, metallic, &out);
    else
        convert_phong(m, &out);
    if (!glows_by_texture(m)) /* which is black nearly everywhere */
        out.emission = get_emission(m);
    return out;
}

/* ------------------------------------------------------------------------------ what is lost -- */

static bool exceeds(const struct aiMaterial *m, const char *key, unsigned type, unsigned index,
                    float least)
{
    float v;
    return get_float(m, key, type, index, &v) && v > least;
}

static bool is_transparent(const struct aiMaterial *m)
{
    struct aiString mode = {0};
    struct aiColor4D filter;
    float opacity;
    aiGetMaterialString(m, AI_MATKEY_GLTF_ALPHAMODE, &mode);
    return (get_float(m, AI_MATKEY_OPACITY, &opacity) && opacity < 1.0f) ||
           exceeds(m, AI_MATKEY_TRANSMISSION_FACTOR, 0.0f) ||
           has_texture(m, aiTextureType_OPACITY) || has_texture(m, aiTextureType_TRANSMISSION) ||
           (aiGetMaterialColor(m, AI_MATKEY_COLOR_TRANSPARENT, &filter) == aiReturn_SUCCESS &&
            !(filter.r == 1.0f && filter.g == 1.0f && filter.b == 1.0f)) ||
           (mode.length > 0 && strcmp(mode.data, "OPAQUE") != 0 &&
            has_texture(m, aiTextureType_DIFFUSE));
}

static bool is_half_metal(const struct aiMaterial *m)
{
    float metallic;
    return get_float(m, AI_MATKEY_METALLIC_FACTOR, &metallic) && metallic > 0.0f && metallic < 1.0f;
}

static bool has_coat(const struct aiMaterial *m)
{
    return exceeds(m, AI_MATKEY_CLEARCOAT_FACTOR, 0.0f);
}

static bool has_sheen(const struct aiMaterial *m)
{
    lf_vec3 sheen;
    return get_colour(m, AI_MATKEY_SHEEN_COLOR_FACTOR, &sheen) && lf_max3(sheen) > 0.0f;
}

static bool has_thickness(const struct aiMaterial *m)
{
    return exceeds(m, AI_MATKEY_VOLUME_THICKNESS_FACTOR, 0.0f);
}

static bool is_brushed(const struct aiMaterial *m)
{
    return exceeds(m, AI_MATKEY_ANISOTROPY_FACTOR, 0.0f);
}

static bool has_specular_model(const struct aiMaterial *m)
{
    float v;
    return get_float(m, AI_MATKEY_GLOSSINESS_FACTOR, &v) ||
           (get_float(m, AI_MATKEY_SPECULAR_FACTOR, &v) && v != 1.0f);
}

static bool is_unlit(const struct aiMaterial *m)
{
    int model = 0;
    return aiGetMaterialIntegerArray(m, AI_MATKEY_SHADING_MODEL, &model, NULL) ==
               aiReturn_SUCCESS &&
           model == aiShadingMode_Unlit;
}

static const struct {
    bool (*lost)(const struct aiMaterial *m);
    const char *what;
} losses[] = {
    {has_textures, "textures are not read, the colours beside them alone count"},
    {glows_by_texture, "the texture of what glows is not read, so nothing of it does"},
    {is_transparent, "transparency is left out: opaque"},
    {is_half_metal, "metallic between 0 and 1 counts as the nearer of both"},
    {has_coat, "the clear coat is left out"},
    {has_sheen, "the sheen is left out"},
    {has_thickness, "the volume inside is left out"},
    {is_brushed, "anisotropy is left out"},
    {has_specular_model, "specular factors are left out"},
    {is_unlit, "unlit is not possible: lit as others are"},
};

/* Appends the name of the n-th material of a list, of which a few are told. */
static void list_name(const struct aiMaterial *m, unsigned number, int n, char *out, size_t size)
{
    enum { TOLD = 3 };
    size_t at = strlen(out);
    struct aiString name;
    get_name(m, &name);
    if (n < TOLD && name.length > 0)
        snprintf(out + at, size - at, "%s\"%.40s\"", n ? ", " : "", name.data);
    else if (n < TOLD)
        snprintf(out + at, size - at, "%snumber %u", n ? ", " : "", number);
    else if (n == TOLD)
        snprintf(out + at, size - at, " ...");
}

/* One line for everything that materials in use lose. */
static void warn(const struct aiScene *scene, const bool *used, lf_warnings *warnings)
{
    for (size_t i = 0; i < sizeof losses / sizeof *losses; i++) {
        char names[256] = "";
        int n = 0;
        for (unsigned m = 0; m < scene->mNumMaterials; m++)
            if (used[m] && losses[i].lost(scene->mMaterials[m]))
                list_name(scene->mMaterials[m], m, n++, names, sizeof names);
        if (n > 0)
            lf_warnings_add(warnings, LF_HERE, "%s %s: %s", n == 1 ? "material" : "materials",
                            names, losses[i].what);
    }
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
    if (scene->mNumMaterials == 0 || scene->mNumMaterials > LF_MAX_MATERIALS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%u materials; 1 to %d are possible",
                            scene->mNumMaterials, LF_MAX_MATERIALS);
    out->materials = lf_calloc(scene->mNumMaterials, sizeof *out->materials);
    if (!out->materials)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    out->n_materials = (int)scene->mNumMaterials;
    for (unsigned i = 0; i < scene->mNumMaterials; i++)
        out->materials[i] = convert_material(scene->mMaterials[i]);
    mark_used(scene, used);
    warn(scene, used, &out->warnings);
    return LF_OK;
}

/* The colour of what Assimp makes up for a name that no library has. */
static bool is_unsaid(const struct aiMaterial *m)
{
    lf_vec3 c;
    return !is_made_up(m) && get_colour(m, AI_MATKEY_COLOR_DIFFUSE, &c) && c.x == 0.6f &&
           c.y == 0.6f && c.z == 0.6f;
}

/* Whether the text of a library has the line "newmtl NAME". */
static bool is_defined(const char *text, const char *name)
{
    static const char blanks[] = " \t\r", key[] = "newmtl";
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += strspn(line, " \t\r\n");
        if (strncmp(line, key, sizeof key - 1) != 0)
            continue;
        const char *at = line + sizeof key - 1;
        at += strspn(at, blanks);
        if (strncmp(at, name, strlen(name)) != 0)
            continue;
        at += strlen(name);
        at += strspn(at, blanks);
        if (*at == '\n' || *at == '\0')
            return true;
    }
    return false;
}

/* All of a file as a text (lf_free); NULL: it cannot be read. */
static char *read_text(int fd)
{
    struct stat info;
    char *text = fstat(fd, &info) == 0 ? lf_calloc((size_t)info.st_size + 1, 1) : NULL;
    ssize_t n = text ? pread(fd, text, (size_t)info.st_size, 0) : -1;
    if (n >= 0)
        return text;
    lf_free(text);
    return NULL;
}

void lf_mesh_warn_of_libraries(const struct aiScene *scene, const lf_mesh_reading *reading,
                               lf_mesh_data *data)
{
    bool used[LF_MAX_MATERIALS] = {false};
    char names[256] = "";
    int n = 0;
    mark_used(scene, used);
    for (int i = 1; i < reading->n_files; i++) {
        char *text = read_text(reading->files[i].fd);
        if (!text)
            return;
        for (unsigned m = 0; m < scene->mNumMaterials; m++) {
            struct aiString name;
            get_name(scene->mMaterials[m], &name);
            used[m] = used[m] && is_unsaid(scene->mMaterials[m]) && !is_defined(text, name.data);
        }
        lf_free(text);
    }
    for (unsigned m = 0; m < scene->mNumMaterials && reading->n_files > 1; m++)
        if (used[m])
            list_name(scene->mMaterials[m], m, n++, names, sizeof names);
    if (n > 0)
        lf_warnings_add(&data->warnings, LF_HERE,
                        "%s %s: not in the file's material libraries, so it is grey",
                        n == 1 ? "material" : "materials", names);
}
