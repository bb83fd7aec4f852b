#include "render/import/scene/foreign_words.h"

#include <string.h>

#define GLASS "\"principled\" with \"transmission\": 1"

typedef struct foreign_word {
    const char *word, *here;
} foreign_word;

static const foreign_word materials[] = {
    {"glass", GLASS},
    {"dielectric", GLASS},
    {"refractive", GLASS},
    {"transparent", GLASS},
    {"rough_glass", GLASS " and a \"roughness\""},
    {"roughdielectric", GLASS " and a \"roughness\""},
    {"thindielectric", GLASS " and \"glass\": \"sheet\""},
    {"window", GLASS " and \"glass\": \"sheet\""},
    {"mirror", "\"conductor\" with \"roughness\": 0"},
    {"metal", "\"conductor\""},
    {"metallic", "\"conductor\""},
    {"roughconductor", "\"conductor\""},
    {"matte", "\"diffuse\""},
    {"lambert", "\"diffuse\""},
    {"lambertian", "\"diffuse\""},
    {"roughplastic", "\"plastic\""},
    {"glossy", "\"plastic\", or \"principled\""},
    {"pbr", "\"principled\""},
    {"disney", "\"principled\""},
    {"standard", "\"principled\""},
    {"uber", "\"principled\""},
    {"emission", "any type with an \"emission\""},
    {"emissive", "any type with an \"emission\""},
    {"light", "any type with an \"emission\""},
};

static const foreign_word lights[] = {
    {"sun", "\"distant\", or \"sky\" for a sun with its sky"},
    {"directional", "\"distant\""},
    {"infinite", "\"environment\""},
    {"hdri", "\"environment\" with a \"file\""},
    {"envmap", "\"environment\" with a \"file\""},
    {"dome", "\"environment\""},
    {"constant", "\"environment\" with a \"radiance\""},
    {"ambient", "\"environment\" with a \"radiance\""},
    {"bulb", "\"point\", or \"sphere\" with a \"radius\""},
    {"omni", "\"point\""},
    {"spotlight", "\"spot\""},
    {"area",
     "\"rectangle\", \"disk\" or \"sphere\"; a mesh emits light if its material has \"emission\""},
    {"quad", "\"rectangle\""},
    {"rect", "\"rectangle\""},
    {"mesh", "\"emission\" in the material of a mesh"},
};

/* A key of other renderers, or of another type of lights. */
typedef struct foreign_key {
    const char *type, *key, *here; /* type: NULL: any */
} foreign_key;

#define BY_POWER "\"intensity\", in W/sr (the power in W divided by 4 pi)"
#define COLOUR "three numbers, [red, green, blue], as its power, radiance or intensity"

static const foreign_key light_keys[] = {
    {"point", "power", BY_POWER},
    {"spot", "power", BY_POWER},
    {"point", "radiance", "\"intensity\", in W/sr"},
    {"spot", "radiance", "\"intensity\", in W/sr"},
    {"rectangle", "intensity", "\"power\", in W, or \"radiance\""},
    {"disk", "intensity", "\"power\", in W, or \"radiance\""},
    {"sphere", "intensity", "\"power\", in W, or \"radiance\""},
    {"distant", "intensity", "\"irradiance\", in W/m^2"},
    {"distant", "power", "\"irradiance\", in W/m^2"},
    {"distant", "radiance", "\"irradiance\", in W/m^2"},
    {"environment", "intensity", "\"radiance\", or \"scale\" of a \"file\""},
    {"environment", "power", "\"radiance\", or \"scale\" of a \"file\""},
    {"sky", "intensity", "\"scale\""},
    {"sky", "power", "\"scale\""},
    {"sky", "radiance", "\"scale\""},
    {NULL, "color", COLOUR},
    {NULL, "colour", COLOUR},
};

#define ALBEDO_PICTURE "\"albedo\": {\"file\": ...}"
#define NORMAL_MAP "\"normal\": {\"file\": ...}"

static const foreign_key material_keys[] = {
    {NULL, "color", "\"albedo\""},       {NULL, "colour", "\"albedo\""},
    {NULL, "base_color", "\"albedo\""},  {NULL, "diffuse", "\"albedo\""},
    {NULL, "reflectance", "\"albedo\""}, {NULL, "metalness", "\"metallic\""},
    {NULL, "emissive", "\"emission\""},  {NULL, "clearcoat", "\"coat\""},
    {NULL, "opacity", "\"alpha\""},      {NULL, "texture", ALBEDO_PICTURE},
    {NULL, "map", ALBEDO_PICTURE},       {NULL, "textures", ALBEDO_PICTURE},
    {NULL, "normal_map", NORMAL_MAP},    {NULL, "normalmap", NORMAL_MAP},
};

static void refuse_keys(lf_reader *reader, const lf_node *node, const foreign_key *keys, size_t n)
{
    const char *type = json_string_value(json_object_get(node->value, "type"));
    for (size_t i = 0; i < n; i++) {
        lf_node at = lf_node_child(node, keys[i].key);
        if (at.value && (!keys[i].type || (type && strcmp(type, keys[i].type) == 0)))
            lf_read_fail(reader, &at, "unknown key \"%s\"; use %s", keys[i].key, keys[i].here);
    }
}

static void refuse(lf_reader *reader, const lf_node *node, const foreign_word *words, size_t n)
{
    const char *type = json_string_value(json_object_get(node->value, "type"));
    lf_node at = lf_node_child(node, "type");
    for (size_t i = 0; type && i < n; i++)
        if (strcmp(type, words[i].word) == 0)
            lf_read_fail(reader, &at, "unknown type \"%s\"; use %s", type, words[i].here);
}

void lf_refuse_foreign_material(lf_reader *reader, const lf_node *material)
{
    refuse(reader, material, materials, sizeof materials / sizeof *materials);
    refuse_keys(reader, material, material_keys, sizeof material_keys / sizeof *material_keys);
}

void lf_refuse_foreign_light(lf_reader *reader, const lf_node *light)
{
    refuse(reader, light, lights, sizeof lights / sizeof *lights);
    refuse_keys(reader, light, light_keys, sizeof light_keys / sizeof *light_keys);
}
