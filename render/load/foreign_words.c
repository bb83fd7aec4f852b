#include "render/load/foreign_words.h"

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
     "\"rectangle\", \"disk\" or \"sphere\"; a mesh shines by the \"emission\" of its material"},
    {"quad", "\"rectangle\""},
    {"rect", "\"rectangle\""},
    {"mesh", "nothing: a mesh shines by the \"emission\" of its material"},
};

static void refuse(lf_reader *reader, const lf_node *node, const foreign_word *words, size_t n)
{
    const char *type = json_string_value(json_object_get(node->value, "type"));
    lf_node at = lf_node_child(node, "type");
    for (size_t i = 0; type && i < n; i++)
        if (strcmp(type, words[i].word) == 0)
            lf_read_fail(reader, &at, "there is no \"%s\"; say %s", type, words[i].here);
}

void lf_refuse_foreign_material(lf_reader *reader, const lf_node *material)
{
    refuse(reader, material, materials, sizeof materials / sizeof *materials);
}

void lf_refuse_foreign_light(lf_reader *reader, const lf_node *light)
{
    refuse(reader, light, lights, sizeof lights / sizeof *lights);
}
