/* Materials by the names of other renderers: refused with the words that they have here, which are
 * taken. */
#include "tests/testing.h"

#include "render/render.h"

static const struct {
    const char *type, *said;
    const char *material; /* what those words are in a scene */
} words[] = {
    {"glass", "say \"principled\" with \"transmission\": 1",
     "{'type': 'principled', 'transmission': 1}"},
    {"thindielectric", "and \"glass\": \"sheet\"",
     "{'type': 'principled', 'transmission': 1, 'glass': 'sheet'}"},
    {"mirror", "say \"conductor\" with \"roughness\": 0", "{'type': 'conductor', 'roughness': 0}"},
    {"matte", "say \"diffuse\"", "{'type': 'diffuse'}"},
    {"emissive", "any type with an \"emission\"", "{'emission': 1}"},
    {"velvet", "expected one of diffuse, conductor, plastic", "{}"},
};

static lf_status load(const char *material, lf_error *err)
{
    char text[256];
    lf_scene *scene = NULL;
    snprintf(text, sizeof text, "{ 'materials': { 'm': %s } }", material);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_t *doc = json_loads(text, 0, NULL);
    assert_non_null(doc);
    lf_status status = lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, err);
    lf_scene_unref(scene);
    json_decref(doc);
    return status;
}

static void names_of_other_renderers_are_answered_in_words_that_are_taken(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        char material[64];
        lf_error err = {0};
        snprintf(material, sizeof material, "{'type': '%s', 'ior': 1.4}", words[i].type);
        assert_int_equal(load(material, &err), LF_E_FORMAT);
        assert_string_equal(err.pointer, "/materials/m/type");
        if (!strstr(err.what, words[i].said))
            fail_msg("%s: %s", words[i].type, err.what);
        lf_assert_ok(load(words[i].material, &err), &err);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_other_renderers_are_answered_in_words_that_are_taken),
    };
    return cmocka_run_group_tests_name("foreign words", tests, NULL, NULL);
}
