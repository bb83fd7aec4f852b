#include "render/import/reader/gltf_material.h"

#include <math.h>
#include <string.h>

/* Of dielectrics, where nothing is said. */
#define USUAL_REFLECTANCE 0.04f

static void lose(lf_said *said, lf_lost what, bool lost)
{
    if (lost)
        said->lost |= 1u << what;
}

static bool take_colour(const json_t *object, const char *key, lf_vec3 *out)
{
    double c[3];
    if (!lf_gltf_numbers(object, key, 3, c))
        return false;
    *out = lf_v3((float)c[0], (float)c[1], (float)c[2]);
    return true;
}

static void take_base(const json_t *object, const char *key, lf_said *said)
{
    double c[4];
    if (!lf_gltf_numbers(object, key, 4, c))
        return;
    said->albedo = lf_v3((float)c[0], (float)c[1], (float)c[2]);
    said->alpha = (float)c[3];
}

static void take_texture(const lf_gltf *gltf, const json_t *object, const char *key, lf_slot slot,
                         lf_said *said)
{
    lf_lost why = LF_LOST_KINDS;
    said->textures.slot[slot] = lf_gltf_texture(gltf, object, key, &why);
    lose(said, why, why < LF_LOST_KINDS);
    said->lacks_base = said->lacks_base || (why < LF_LOST_KINDS && slot == LF_SLOT_BASE);
    lose(said, LF_LOST_GLOW, why < LF_LOST_KINDS && slot == LF_SLOT_EMISSION);
}

static void take_metallic_roughness(const lf_gltf *gltf, const json_t *pbr, lf_said *said)
{
    take_base(pbr, "baseColorFactor", said);
    said->metallic = lf_gltf_number(pbr, "metallicFactor", 1);
    said->roughness = lf_gltf_number(pbr, "roughnessFactor", 1);
    take_texture(gltf, pbr, "baseColorTexture", LF_SLOT_BASE, said);
    take_texture(gltf, pbr, "metallicRoughnessTexture", LF_SLOT_METAL_ROUGH, said);
}

static void take_emission(const lf_gltf *gltf, const json_t *json, lf_said *said)
{
    const json_t *strong = lf_gltf_extension(json, "KHR_materials_emissive_strength");
    take_colour(json, "emissiveFactor", &said->emission);
    said->emission = lf_scale(said->emission, lf_gltf_number(strong, "emissiveStrength", 1));
    take_texture(gltf, json, "emissiveTexture", LF_SLOT_EMISSION, said);
}

static void take_cover(const json_t *json, lf_said *said)
{
    const char *mode = lf_gltf_text(json, "alphaMode");
    said->cover = strcmp(mode, "MASK") == 0    ? LF_COVER_MASK
                  : strcmp(mode, "BLEND") == 0 ? LF_COVER_BLEND
                                               : LF_COVER_OPAQUE;
    if (*mode && said->cover == LF_COVER_OPAQUE && strcmp(mode, "OPAQUE") != 0)
        said->lost |= 1u << LF_LOST_ALPHA_MODE;
    said->alpha_cutoff = lf_gltf_number(json, "alphaCutoff", 0.5f);
}

/* -------------------------------------------------------------------------------- extensions -- */

static void take_specular(const lf_gltf *gltf, const json_t *json, lf_said *said)
{
    const json_t *index = lf_gltf_extension(json, "KHR_materials_ior"),
                 *specular = lf_gltf_extension(json, "KHR_materials_specular");
    said->ior = lf_gltf_number(index, "ior", 1.5f);
    said->specular = lf_gltf_number(specular, "specularFactor", 1);
    take_colour(specular, "specularColorFactor", &said->specular_tint);
    take_texture(gltf, specular, "specularTexture", LF_SLOT_SPECULAR, said);
    take_texture(gltf, specular, "specularColorTexture", LF_SLOT_SPECULAR_TINT, said);
}

static void take_coat_and_sheen(const lf_gltf *gltf, const json_t *json, lf_said *said)
{
    const json_t *coat = lf_gltf_extension(json, "KHR_materials_clearcoat"),
                 *sheen = lf_gltf_extension(json, "KHR_materials_sheen");
    said->coat = lf_gltf_number(coat, "clearcoatFactor", 0);
    said->coat_roughness = lf_gltf_number(coat, "clearcoatRoughnessFactor", 0);
    take_colour(sheen, "sheenColorFactor", &said->sheen);
    said->sheen_roughness = lf_gltf_number(sheen, "sheenRoughnessFactor", 0);
    take_texture(gltf, coat, "clearcoatTexture", LF_SLOT_COAT, said);
    take_texture(gltf, coat, "clearcoatRoughnessTexture", LF_SLOT_COAT_ROUGH, said);
    if (said->coat > 0)
        take_texture(gltf, coat, "clearcoatNormalTexture", LF_SLOT_COAT_NORMAL, said);
    take_texture(gltf, sheen, "sheenColorTexture", LF_SLOT_SHEEN, said);
    take_texture(gltf, sheen, "sheenRoughnessTexture", LF_SLOT_SHEEN_ROUGH, said);
}

static void take_brush(const lf_gltf *gltf, const json_t *json, lf_said *said)
{
    const json_t *brush = lf_gltf_extension(json, "KHR_materials_anisotropy");
    const float turn = lf_gltf_number(brush, "anisotropyRotation", 0);
    said->anisotropy = lf_gltf_number(brush, "anisotropyStrength", 0);
    said->anisotropy_rotation[0] = cosf(turn);
    said->anisotropy_rotation[1] = sinf(turn);
    if (said->anisotropy > 0)
        take_texture(gltf, brush, "anisotropyTexture", LF_SLOT_BRUSH, said);
}

/* What lets nothing through absorbs as much as there is. */
static float absorbed(float colour, float distance)
{
    if (!(colour > 0))
        return (float)LF_MAX_RADIANCE;
    return -logf(fminf(fmaxf(colour, 1e-6f), 1.0f)) / distance;
}

static void take_volume(const lf_gltf *gltf, const json_t *json, float scale, lf_said *said)
{
    const json_t *through = lf_gltf_extension(json, "KHR_materials_transmission"),
                 *volume = lf_gltf_extension(json, "KHR_materials_volume");
    float distance = lf_gltf_number(volume, "attenuationDistance", 0) * scale;
    lf_vec3 colour = lf_v3(1, 1, 1);
    said->transmission = lf_gltf_number(through, "transmissionFactor", 0);
    take_texture(gltf, through, "transmissionTexture", LF_SLOT_TRANSMISSION, said);
    said->is_solid = lf_gltf_number(volume, "thicknessFactor", 0) > 0;
    take_colour(volume, "attenuationColor", &colour);
    if (said->is_solid && distance > 0)
        said->absorption = lf_v3(absorbed(colour.x, distance), absorbed(colour.y, distance),
                                 absorbed(colour.z, distance));
}

static float reflectance_of(float index)
{
    float r = (index - 1) / (index + 1);
    return r * r;
}

static bool is_glass(const lf_said *said)
{
    return said->transmission > 0 || said->textures.slot[LF_SLOT_TRANSMISSION].picture > 0;
}

/* An index of 0, which reflects all, and a tint above 1, f0 = min(f0 tint, 1), become the index of
 * what reflects as much and the tint that is left to say. Of glass the index turns light as well,
 * so that of a tint above 1 it stays. */
static void take_reflectance(lf_said *said)
{
    const lf_vec3 tint = said->specular_tint;
    const bool all = said->ior == 0;
    if (!all && !(lf_max3(tint) > 1 && said->ior > 1 && !is_glass(said)))
        return;
    lf_vec3 f0 = lf_scale(tint, all ? 1 : reflectance_of(said->ior));
    float most = lf_max3(f0), root = sqrtf(fminf(fmaxf(most, 0), 1));
    said->ior =
        root < 1 ? fminf((1 + root) / (1 - root), (float)LF_MAX_INDEX) : (float)LF_MAX_INDEX;
    if (!(most > 0)) {
        said->specular = 0;
        said->specular_tint = lf_v3(1, 1, 1);
        return;
    }
    if (said->textures.slot[LF_SLOT_SPECULAR_TINT].picture == 0)
        f0 = lf_v3(fminf(f0.x, 1), fminf(f0.y, 1), fminf(f0.z, 1));
    said->specular_tint = lf_scale(f0, 1 / reflectance_of(said->ior));
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
static void take_glossiness(const lf_gltf *gltf, const json_t *old, lf_said *said)
{
    lf_vec3 specular = lf_v3(1, 1, 1);
    *said = (lf_said){.name = said->name,
                      .is_metallic = true,
                      .p = lf_principled_usual(),
                      .lost = said->lost | 1u << LF_LOST_GLOSSINESS};
    said->albedo = lf_v3(1, 1, 1);
    take_base(old, "diffuseFactor", said);
    take_colour(old, "specularFactor", &specular);
    take_texture(gltf, old, "diffuseTexture", LF_SLOT_BASE, said);
    said->roughness = 1 - lf_gltf_number(old, "glossinessFactor", 1);
    if (json_object_get(old, "specularGlossinessTexture")) { /* the factors are 1 for its sake */
        specular = lf_v3(USUAL_REFLECTANCE, USUAL_REFLECTANCE, USUAL_REFLECTANCE);
        said->roughness = fmaxf(said->roughness, 0.5f);
    }
    float rest = 1 - fminf(lf_max3(specular), 1.0f),
          metallic = solve_metallic(brightness(said->albedo), brightness(specular), rest);
    metallic = share(metallic);
    lf_vec3 left = lf_v3(USUAL_REFLECTANCE, USUAL_REFLECTANCE, USUAL_REFLECTANCE),
            dull =
                lf_scale(said->albedo, rest / (1 - USUAL_REFLECTANCE) / fmaxf(1 - metallic, 1e-3f)),
            shiny = lf_scale(lf_sub(specular, lf_scale(left, 1 - metallic)),
                             1 / fmaxf(metallic, 1e-3f));
    said->metallic = metallic;
    said->albedo = lf_madd(lf_scale(dull, 1 - metallic * metallic), metallic * metallic, shiny);
    /* what the model below has no room for is no word of the file */
    said->albedo = lf_v3(share(said->albedo.x), share(said->albedo.y), share(said->albedo.z));
}

/* ------------------------------------------------------------------------------ what is lost -- */

/* What an extension says that is not read; LF_LOST_KINDS: nothing. */
typedef struct known_extension {
    const char *name;
    lf_lost lost;
    const char *if_factor; /* only where this is not 0 */
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

static void lose_extensions(const json_t *json, lf_said *said)
{
    const char *name, *key;
    json_t *extension, *value;
    json_t *all = json_object_get(json, "extensions");
    json_object_foreach(all, name, extension)
    {
        const known_extension *known = find_extension(name);
        if (!known) /* gltf_extensions.c tells of it */
            continue;
        if (known->lost < LF_LOST_KINDS)
            lose(said, known->lost, lf_gltf_number(extension, known->if_factor, 0) != 0);
        else
            json_object_foreach(extension, key, value)
                lose(said, LF_LOST_MORE_TEXTURES, is_lost_texture(key));
    }
    lose(said, LF_LOST_OCCLUSION, json_is_object(json_object_get(json, "occlusionTexture")));
}

/* Of a material without a name, too, that is there for nothing but to be named. */
static bool says_nothing(const json_t *json)
{
    static const char *const words[] = {"emissiveFactor", "emissiveTexture", "normalTexture",
                                        "extensions", "alphaMode"};
    bool said = lf_gltf_text(json, "name")[0] ||
                json_object_size(json_object_get(json, "pbrMetallicRoughness")) > 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        said = said || json_object_get(json, words[i]);
    return !said;
}

lf_said lf_gltf_said(const lf_gltf *gltf, uint32_t number, float scale)
{
    const json_t *json = lf_gltf_element(gltf->json, "materials", number),
                 *old = lf_gltf_extension(json, "KHR_materials_pbrSpecularGlossiness");
    lf_said said = lf_said_begin(lf_gltf_text(json, "name"));
    said.is_none = says_nothing(json);
    said.is_metallic = true;
    said.albedo = lf_v3(1, 1, 1);
    take_metallic_roughness(gltf, json_object_get(json, "pbrMetallicRoughness"), &said);
    take_specular(gltf, json, &said);
    if (old)
        take_glossiness(gltf, old, &said);
    take_emission(gltf, json, &said);
    take_cover(json, &said);
    take_coat_and_sheen(gltf, json, &said);
    take_volume(gltf, json, scale, &said);
    take_reflectance(&said);
    take_brush(gltf, json, &said);
    take_texture(gltf, json, "normalTexture", LF_SLOT_NORMAL, &said);
    lose_extensions(json, &said);
    return said;
}

void lf_gltf_unlight(const lf_gltf *gltf, uint32_t number, bool coloured, lf_said *said)
{
    if (!lf_gltf_extension(lf_gltf_element(gltf->json, "materials", number), "KHR_materials_unlit"))
        return;
    said->metallic = 0;
    said->specular = 0;
    if (said->lacks_base) { /* white all over would be worse */
        lose(said, LF_LOST_UNLIT_TEXTURE, true);
        return;
    }
    said->is_metallic = false;
    said->glows_by_colours = coloured;
    said->emission = said->albedo;
    said->albedo = lf_v3(0, 0, 0);
    said->textures.slot[LF_SLOT_EMISSION] = said->textures.slot[LF_SLOT_BASE];
    if (said->cover == LF_COVER_OPAQUE)
        said->textures.slot[LF_SLOT_BASE] = (lf_texture){0};
    said->lost &= ~(1u << LF_LOST_GLOW);
}
