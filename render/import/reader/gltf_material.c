#include "render/import/reader/gltf_material.h"

#include <math.h>
#include <string.h>

/* Of dielectrics, by default. */
#define USUAL_REFLECTANCE 0.04f

static void lose(lf_source_material *source, lf_lost what, bool lost)
{
    if (lost)
        source->lost |= 1u << what;
}

static bool take_colour(const json_t *object, const char *key, lf_vec3 *out)
{
    double c[3];
    if (!lf_gltf_numbers(object, key, 3, c))
        return false;
    *out = lf_v3((float)c[0], (float)c[1], (float)c[2]);
    return true;
}

static void take_base(const json_t *object, const char *key, lf_source_material *source)
{
    double c[4];
    if (!lf_gltf_numbers(object, key, 4, c))
        return;
    source->albedo = lf_v3((float)c[0], (float)c[1], (float)c[2]);
    source->alpha = (float)c[3];
}

static void take_texture(const lf_gltf *gltf, const json_t *object, const char *key, lf_slot slot,
                         lf_source_material *source)
{
    lf_lost why = LF_LOST_KINDS;
    source->textures.slot[slot] = lf_gltf_texture(gltf, object, key, &why);
    lose(source, why, why < LF_LOST_KINDS);
    source->lacks_base = source->lacks_base || (why < LF_LOST_KINDS && slot == LF_SLOT_BASE);
    lose(source, LF_LOST_EMISSION, why < LF_LOST_KINDS && slot == LF_SLOT_EMISSION);
}

static void take_metallic_roughness(const lf_gltf *gltf, const json_t *pbr,
                                    lf_source_material *source)
{
    take_base(pbr, "baseColorFactor", source);
    source->metallic = lf_gltf_number(pbr, "metallicFactor", 1);
    source->roughness = lf_gltf_number(pbr, "roughnessFactor", 1);
    take_texture(gltf, pbr, "baseColorTexture", LF_SLOT_BASE, source);
    take_texture(gltf, pbr, "metallicRoughnessTexture", LF_SLOT_METAL_ROUGH, source);
}

static void take_emission(const lf_gltf *gltf, const json_t *json, lf_source_material *source)
{
    const json_t *strong = lf_gltf_extension(json, "KHR_materials_emissive_strength");
    take_colour(json, "emissiveFactor", &source->emission);
    source->emission = lf_scale(source->emission, lf_gltf_number(strong, "emissiveStrength", 1));
    take_texture(gltf, json, "emissiveTexture", LF_SLOT_EMISSION, source);
}

static void take_cover(const json_t *json, lf_source_material *source)
{
    const char *mode = lf_gltf_text(json, "alphaMode");
    source->cover = strcmp(mode, "MASK") == 0    ? LF_COVER_MASK
                    : strcmp(mode, "BLEND") == 0 ? LF_COVER_BLEND
                                                 : LF_COVER_OPAQUE;
    if (*mode && source->cover == LF_COVER_OPAQUE && strcmp(mode, "OPAQUE") != 0)
        source->lost |= 1u << LF_LOST_ALPHA_MODE;
    source->alpha_cutoff = lf_gltf_number(json, "alphaCutoff", 0.5f);
}

/* -------------------------------------------------------------------------------- extensions -- */

static void take_specular(const lf_gltf *gltf, const json_t *json, lf_source_material *source)
{
    const json_t *index = lf_gltf_extension(json, "KHR_materials_ior"),
                 *specular = lf_gltf_extension(json, "KHR_materials_specular");
    source->ior = lf_gltf_number(index, "ior", 1.5f);
    source->specular = lf_gltf_number(specular, "specularFactor", 1);
    take_colour(specular, "specularColorFactor", &source->specular_tint);
    take_texture(gltf, specular, "specularTexture", LF_SLOT_SPECULAR, source);
    take_texture(gltf, specular, "specularColorTexture", LF_SLOT_SPECULAR_TINT, source);
}

static void take_coat_and_sheen(const lf_gltf *gltf, const json_t *json, lf_source_material *source)
{
    const json_t *coat = lf_gltf_extension(json, "KHR_materials_clearcoat"),
                 *sheen = lf_gltf_extension(json, "KHR_materials_sheen");
    source->coat = lf_gltf_number(coat, "clearcoatFactor", 0);
    source->coat_roughness = lf_gltf_number(coat, "clearcoatRoughnessFactor", 0);
    take_colour(sheen, "sheenColorFactor", &source->sheen);
    source->sheen_roughness = lf_gltf_number(sheen, "sheenRoughnessFactor", 0);
    take_texture(gltf, coat, "clearcoatTexture", LF_SLOT_COAT, source);
    take_texture(gltf, coat, "clearcoatRoughnessTexture", LF_SLOT_COAT_ROUGH, source);
    if (source->coat > 0)
        take_texture(gltf, coat, "clearcoatNormalTexture", LF_SLOT_COAT_NORMAL, source);
    take_texture(gltf, sheen, "sheenColorTexture", LF_SLOT_SHEEN, source);
    take_texture(gltf, sheen, "sheenRoughnessTexture", LF_SLOT_SHEEN_ROUGH, source);
}

static void take_anisotropy(const lf_gltf *gltf, const json_t *json, lf_source_material *source)
{
    const json_t *anisotropic = lf_gltf_extension(json, "KHR_materials_anisotropy");
    const float turn = lf_gltf_number(anisotropic, "anisotropyRotation", 0);
    source->anisotropy = lf_gltf_number(anisotropic, "anisotropyStrength", 0);
    source->anisotropy_rotation[0] = cosf(turn);
    source->anisotropy_rotation[1] = sinf(turn);
    if (source->anisotropy > 0)
        take_texture(gltf, anisotropic, "anisotropyTexture", LF_SLOT_ANISOTROPY, source);
}

/* An opaque colour absorbs at the upper limit. */
static float absorbed(float colour, float distance)
{
    if (!(colour > 0))
        return (float)LF_MAX_RADIANCE;
    return -logf(fminf(fmaxf(colour, 1e-6f), 1.0f)) / distance;
}

static void take_volume(const lf_gltf *gltf, const json_t *json, float scale,
                        lf_source_material *source)
{
    const json_t *through = lf_gltf_extension(json, "KHR_materials_transmission"),
                 *volume = lf_gltf_extension(json, "KHR_materials_volume");
    float distance = lf_gltf_number(volume, "attenuationDistance", 0) * scale;
    lf_vec3 colour = lf_v3(1, 1, 1);
    source->transmission = lf_gltf_number(through, "transmissionFactor", 0);
    take_texture(gltf, through, "transmissionTexture", LF_SLOT_TRANSMISSION, source);
    source->is_solid = lf_gltf_number(volume, "thicknessFactor", 0) > 0;
    take_colour(volume, "attenuationColor", &colour);
    if (source->is_solid && distance > 0)
        source->absorption = lf_v3(absorbed(colour.x, distance), absorbed(colour.y, distance),
                                   absorbed(colour.z, distance));
}

static float reflectance_of(float index)
{
    float r = (index - 1) / (index + 1);
    return r * r;
}

static bool is_glass(const lf_source_material *source)
{
    return source->transmission > 0 || source->textures.slot[LF_SLOT_TRANSMISSION].picture > 0;
}

/* An index of 0 (total reflection) and a tint above 1, f0 = min(f0 tint, 1), become an index with
 * the same reflectance and the remaining tint. For glass the index also determines refraction, so a
 * tint above 1 does not change it. */
static void take_reflectance(lf_source_material *source)
{
    const lf_vec3 tint = source->specular_tint;
    const bool all = source->ior == 0;
    if (!all && !(lf_max3(tint) > 1 && source->ior > 1 && !is_glass(source)))
        return;
    lf_vec3 f0 = lf_scale(tint, all ? 1 : reflectance_of(source->ior));
    float most = lf_max3(f0), root = sqrtf(fminf(fmaxf(most, 0), 1));
    source->ior =
        root < 1 ? fminf((1 + root) / (1 - root), (float)LF_MAX_INDEX) : (float)LF_MAX_INDEX;
    if (!(most > 0)) {
        source->specular = 0;
        source->specular_tint = lf_v3(1, 1, 1);
        return;
    }
    if (source->textures.slot[LF_SLOT_SPECULAR_TINT].picture == 0)
        f0 = lf_v3(fminf(f0.x, 1), fminf(f0.y, 1), fminf(f0.z, 1));
    source->specular_tint = lf_scale(f0, 1 / reflectance_of(source->ior));
}

static float brightness(lf_vec3 c)
{
    return sqrtf(0.299f * c.x * c.x + 0.587f * c.y * c.y + 0.114f * c.z * c.z);
}

/* The metallic share that gives a diffuse and a specular brightness: the quadratic equation that
 * the extension's own appendix has. */
static float solve_metallic(float diffuse, float specular, float rest)
{
    const float a = USUAL_REFLECTANCE;
    float b = diffuse * rest / (1 - a) + specular - 2 * a, c = a - specular;
    return specular < a ? 0 : (sqrtf(fmaxf(b * b - 4 * a * c, 0)) - b) / (2 * a);
}

static float share(float v)
{
    return fminf(fmaxf(v, 0), 1);
}

/* KHR_materials_pbrSpecularGlossiness, a model that glTF no longer has. */
static void take_glossiness(const lf_gltf *gltf, const json_t *old, lf_source_material *source)
{
    lf_vec3 specular = lf_v3(1, 1, 1);
    *source = (lf_source_material){.name = source->name,
                                   .is_metallic = true,
                                   .p = lf_principled_usual(),
                                   .lost = source->lost | 1u << LF_LOST_GLOSSINESS};
    source->albedo = lf_v3(1, 1, 1);
    take_base(old, "diffuseFactor", source);
    take_colour(old, "specularFactor", &specular);
    take_texture(gltf, old, "diffuseTexture", LF_SLOT_BASE, source);
    source->roughness = 1 - lf_gltf_number(old, "glossinessFactor", 1);
    if (json_object_get(old, "specularGlossinessTexture")) { /* the factors are 1 for its sake */
        specular = lf_v3(USUAL_REFLECTANCE, USUAL_REFLECTANCE, USUAL_REFLECTANCE);
        source->roughness = fmaxf(source->roughness, 0.5f);
    }
    float rest = 1 - fminf(lf_max3(specular), 1.0f),
          metallic = solve_metallic(brightness(source->albedo), brightness(specular), rest);
    metallic = share(metallic);
    lf_vec3 left = lf_v3(USUAL_REFLECTANCE, USUAL_REFLECTANCE, USUAL_REFLECTANCE),
            dull = lf_scale(source->albedo,
                            rest / (1 - USUAL_REFLECTANCE) / fmaxf(1 - metallic, 1e-3f)),
            shiny = lf_scale(lf_sub(specular, lf_scale(left, 1 - metallic)),
                             1 / fmaxf(metallic, 1e-3f));
    source->metallic = metallic;
    source->albedo = lf_madd(lf_scale(dull, 1 - metallic * metallic), metallic * metallic, shiny);
    /* values that the model below cannot hold are not reported */
    source->albedo =
        lf_v3(share(source->albedo.x), share(source->albedo.y), share(source->albedo.z));
}

/* ----------------------------------------------------------------------------- lost features -- */

/* Unsupported features of an extension; LF_LOST_KINDS: none. */
typedef struct known_extension {
    const char *name;
    lf_lost lost;
    const char *if_factor; /* only if this factor is not 0 */
} known_extension;

static const known_extension extensions[] = {
    {"KHR_materials_anisotropy", LF_LOST_KINDS, ""},
    {"KHR_materials_clearcoat", LF_LOST_KINDS, ""},
    {"KHR_materials_diffuse_transmission", LF_LOST_TRANSLUCENCE, "diffuseTransmissionFactor"},
    {"KHR_materials_dispersion", LF_LOST_DISPERSION, "dispersion"},
    {"KHR_materials_emissive_strength", LF_LOST_KINDS, ""},
    {"KHR_materials_ior", LF_LOST_KINDS, ""},
    {"KHR_materials_iridescence", LF_LOST_IRIDESCENCE, "iridescenceFactor"},
    {"KHR_materials_pbrSpecularGlossiness", LF_LOST_KINDS, ""},
    {"KHR_materials_sheen", LF_LOST_KINDS, ""},
    {"KHR_materials_specular", LF_LOST_KINDS, ""},
    {"KHR_materials_transmission", LF_LOST_KINDS, ""},
    {"KHR_materials_unlit", LF_LOST_KINDS, ""},
    {"KHR_materials_volume", LF_LOST_KINDS, ""},
};

static const known_extension *find_extension(const char *name)
{
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++)
        if (strcmp(extensions[i].name, name) == 0)
            return &extensions[i];
    return NULL;
}

/* Textures of the extensions that are read, which themselves are not. */
static bool is_lost_texture(const char *key)
{
    static const char *const lost[] = {"thicknessTexture", "specularGlossinessTexture"};
    bool any = false;
    for (size_t i = 0; i < sizeof lost / sizeof *lost; i++)
        any = any || strcmp(key, lost[i]) == 0;
    return any;
}

static void lose_extensions(const json_t *json, lf_source_material *source)
{
    const char *name, *key;
    json_t *extension, *value;
    json_t *all = json_object_get(json, "extensions");
    json_object_foreach(all, name, extension)
    {
        const known_extension *known = find_extension(name);
        if (!known) /* reported by gltf_extensions.c */
            continue;
        if (known->lost < LF_LOST_KINDS)
            lose(source, known->lost, lf_gltf_number(extension, known->if_factor, 0) != 0);
        else
            json_object_foreach(extension, key, value)
                lose(source, LF_LOST_MORE_TEXTURES, is_lost_texture(key));
    }
    lose(source, LF_LOST_OCCLUSION, json_is_object(json_object_get(json, "occlusionTexture")));
}

/* Also true for a material without a name, which exists only to be referenced. */
static bool says_nothing(const json_t *json)
{
    static const char *const words[] = {"emissiveFactor", "emissiveTexture", "normalTexture",
                                        "extensions", "alphaMode"};
    bool source = lf_gltf_text(json, "name")[0] ||
                  json_object_size(json_object_get(json, "pbrMetallicRoughness")) > 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        source = source || json_object_get(json, words[i]);
    return !source;
}

lf_source_material lf_gltf_source_material(const lf_gltf *gltf, uint32_t number, float scale)
{
    const json_t *json = lf_gltf_element(gltf->json, "materials", number),
                 *old = lf_gltf_extension(json, "KHR_materials_pbrSpecularGlossiness");
    lf_source_material source = lf_source_material_begin(lf_gltf_text(json, "name"));
    source.is_none = says_nothing(json);
    source.is_metallic = true;
    source.albedo = lf_v3(1, 1, 1);
    take_metallic_roughness(gltf, json_object_get(json, "pbrMetallicRoughness"), &source);
    take_specular(gltf, json, &source);
    if (old)
        take_glossiness(gltf, old, &source);
    take_emission(gltf, json, &source);
    take_cover(json, &source);
    take_coat_and_sheen(gltf, json, &source);
    take_volume(gltf, json, scale, &source);
    take_reflectance(&source);
    take_anisotropy(gltf, json, &source);
    take_texture(gltf, json, "normalTexture", LF_SLOT_NORMAL, &source);
    lose_extensions(json, &source);
    return source;
}

void lf_gltf_unlight(const lf_gltf *gltf, uint32_t number, bool coloured,
                     lf_source_material *source)
{
    if (!lf_gltf_extension(lf_gltf_element(gltf->json, "materials", number), "KHR_materials_unlit"))
        return;
    source->metallic = 0;
    source->specular = 0;
    if (source->lacks_base) { /* white all over would be worse */
        lose(source, LF_LOST_UNLIT_TEXTURE, true);
        return;
    }
    source->is_metallic = false;
    source->emits_by_colours = coloured;
    source->emission = source->albedo;
    source->albedo = lf_v3(0, 0, 0);
    source->textures.slot[LF_SLOT_EMISSION] = source->textures.slot[LF_SLOT_BASE];
    if (source->cover == LF_COVER_OPAQUE)
        source->textures.slot[LF_SLOT_BASE] = (lf_texture){0};
    source->lost &= ~(1u << LF_LOST_EMISSION);
}
