/* Materials, lights and their keys by the names of other renderers, and keys of other types:
 * refused with the words that they have here, which are taken. */
#include "tests/testing.h"

#include "render/render.h"

typedef struct foreign {
    const char *type, *said;
    const char *here; /* what those words are in a scene */
} foreign;

static const foreign materials[] = {
    {"glass", "use \"principled\" with \"transmission\": 1",
     "{'type': 'principled', 'transmission': 1}"},
    {"thindielectric", "and \"glass\": \"sheet\"",
     "{'type': 'principled', 'transmission': 1, 'glass': 'sheet'}"},
    {"mirror", "use \"conductor\" with \"roughness\": 0", "{'type': 'conductor', 'roughness': 0}"},
    {"matte", "use \"diffuse\"", "{'type': 'diffuse'}"},
    {"emissive", "any type with an \"emission\"", "{'emission': 1}"},
    {"velvet", "expected one of diffuse, conductor, plastic", "{}"},
};

static const foreign lights[] = {
    {"sun", "use \"distant\"", "{'type': 'distant', 'direction': [0, -1, 0], 'irradiance': 1}"},
    {"dome", "use \"environment\"", "{'type': 'environment', 'radiance': 1}"},
    {"omni", "use \"point\"", "{'type': 'point', 'intensity': 1}"},
    {"laser", "expected one of environment", "{'type': 'environment', 'radiance': 1}"},
};

static lf_status load(const char *section, const char *value, lf_error *err)
{
    char text[256];
    lf_scene *scene = NULL;
    snprintf(text, sizeof text, "{ '%s': { 'm': %s } }", section, value);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *doc = json_loads(text, 0, NULL);
    assert_non_null(doc);
    lf_status status = lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, err);
    lf_scene_unref(scene);
    json_decref(doc);
    return status;
}

static void assert_answered(const char *section, const foreign *words, int n)
{
    for (int i = 0; i < n; i++) {
        char value[64], pointer[64];
        lf_error err = {0};
        snprintf(value, sizeof value, "{'type': '%s'}", words[i].type);
        snprintf(pointer, sizeof pointer, "/%s/m/type", section);
        assert_int_equal(load(section, value, &err), LF_E_FORMAT);
        assert_string_equal(err.pointer, pointer);
        if (!strstr(err.what, words[i].said))
            fail_msg("%s: %s", words[i].type, err.what);
        lf_assert_ok(load(section, words[i].here, &err), &err);
    }
}

static void names_of_other_renderers_are_answered_in_words_that_are_taken(void **state)
{
    (void)state;
    assert_answered("materials", materials, (int)(sizeof materials / sizeof *materials));
    assert_answered("lights", lights, (int)(sizeof lights / sizeof *lights));
}

typedef struct foreign_key {
    const char *section, *value, *key, *said;
} foreign_key;

static void keys_of_other_things_are_answered_in_words_that_are_taken(void **state)
{
    (void)state;
    static const foreign_key keys[] = {
        {"lights", "{'type': 'point', 'power': 40}", "power", "use \"intensity\", in W/sr"},
        {"lights", "{'type': 'spot', 'power': 40}", "power", "divided by 4 pi"},
        {"lights", "{'type': 'sphere', 'radius': 1, 'intensity': 4}", "intensity",
         "use \"power\", in W, or \"radiance\""},
        {"lights", "{'type': 'distant', 'radiance': 4}", "radiance", "use \"irradiance\""},
        {"lights", "{'type': 'point', 'color': [1, 0, 0]}", "color", "[red, green, blue]"},
        {"materials", "{'color': [1, 0, 0]}", "color", "use \"albedo\""},
        {"volumes", "{'shape': 'box', 'velocity': 'vel'}", "velocity",
         "unknown key \"velocity\" of a shape; only a volume with a \"file\" has it"},
        {"volumes", "{'shape': 'sphere', 'scale': 2}", "scale", "has it; use \"density\""},
    };
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        char pointer[64];
        lf_error err = {0};
        snprintf(pointer, sizeof pointer, "/%s/m/%s", keys[i].section, keys[i].key);
        assert_int_equal(load(keys[i].section, keys[i].value, &err), LF_E_FORMAT);
        assert_string_equal(err.pointer, pointer);
        if (!strstr(err.what, keys[i].said))
            fail_msg("%s: %s", keys[i].value, err.what);
    }
    /* where a key is the right one it is taken */
    lf_error err = {0};
    lf_assert_ok(load("lights", "{'type': 'sphere', 'radius': 1, 'power': 4}", &err), &err);
    lf_assert_ok(load("lights", "{'type': 'sphere', 'radius': 1, 'radiance': 4}", &err), &err);
    lf_assert_ok(load("lights", "{'type': 'environment', 'radiance': 4}", &err), &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_other_renderers_are_answered_in_words_that_are_taken),
        cmocka_unit_test(keys_of_other_things_are_answered_in_words_that_are_taken),
    };
    return cmocka_run_group_tests_name("foreign words", tests, NULL, NULL);
}
