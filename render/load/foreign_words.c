#include "render/load/foreign_words.h"

#include <string.h>

#define GLASS "\"principled\" with \"transmission\": 1"

static const struct {
    const char *word, *here;
} materials[] = {
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

void lf_refuse_foreign_material(lf_reader *reader, const lf_node *material)
{
    const char *type = json_string_value(json_object_get(material->value, "type"));
    lf_node at = lf_node_child(material, "type");
    for (size_t i = 0; type && i < sizeof materials / sizeof *materials; i++)
        if (strcmp(type, materials[i].word) == 0)
            lf_read_fail(reader, &at, "there is no \"%s\"; say %s", type, materials[i].here);
}
