/* Units of scenes and of files: a scene in other units, and a file in other units than its scene,
 * are the same scene expressed another way. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "render/import/scene/mesh_import.h"
#include "render/transport/path/path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 12, HEIGHT = 10, VIEWS = 3, VALUES = 3 * VIEWS * WIDTH * HEIGHT };

static void render(lf_scene *scene, float out[VALUES])
{
    lf_renderer *renderer = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, NULL);
    lf_test_cycles(renderer, 8);
    assert_int_equal(lf_renderer_fill_holes(renderer, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_resolve(renderer, LF_ESTIMATOR_MWIS, out, NULL), LF_OK);
    lf_renderer_destroy(renderer);
}

static void render_text(const char *folder, const char *text, float out[VALUES])
{
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    render(scene, out);
    lf_scene_unref(scene);
}

#define REST                                                                                       \
    "'camera': { 'fov_y': 30, 'views': 3 }, 'lights': { 's': { 'type': 'distant', 'direction': "   \
    "[-1, -2, -3], 'angle': 1 }, 'e': { 'type': 'environment', 'radiance': 0.2 } }"

#define WEDGE                                                                                      \
    "{ %s 'meshes': { 'wedge': { 'file': 'wedge.obj', %s 'transform': { 'scale': %s, 'rotate': "   \
    "[0, 40, 0], 'translate': [0.1, 0.2, 0.3] } }, 'ball': { 'shape': 'sphere', 'transform': { "   \
    "'scale': 0.5 } } }, " REST " }"

/* A wedge of 20 inches beside a ball of a metre: as said in inches, and as scaled by hand. */
static void a_mesh_in_inches_stands_beside_one_in_metres(void **state)
{
    static float inches[VALUES], by_hand[VALUES], wrong[VALUES];
    lf_test_write(*state, "wedge.obj",
                  "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    char text[1024];
    snprintf(text, sizeof text, WEDGE, "'units': 'm',", "'units': 'in',", "1");
    render_text(*state, text, inches);
    snprintf(text, sizeof text, WEDGE, "", "", "0.0254");
    render_text(*state, text, by_hand);
    assert_memory_equal(inches, by_hand, sizeof inches);
    snprintf(text, sizeof text, WEDGE, "'units': 'cm',", "'units': 'cm',", "0.0254");
    render_text(*state, text, by_hand); /* the file's are the scene's: nothing is scaled */
    assert_memory_equal(inches, by_hand, sizeof inches);
    snprintf(text, sizeof text, WEDGE, "'units': 'm',", "'units': 'ft',", "1");
    render_text(*state, text, wrong); /* a negative control */
    assert_memory_not_equal(inches, wrong, sizeof inches);
}

#define GRID                                                                                       \
    "{ 'volumes': { 'v': { 'file': 'patterns.vdb', 'scale': 3, %s 'transform': { 'scale': %s } } " \
    "}, " REST " }"

static void a_grid_in_centimetres_is_one_scaled_by_a_hundredth(void **state)
{
    (void)state;
    static float said[VALUES], by_hand[VALUES], wrong[VALUES];
    char folder[PATH_MAX], text[1024];
    snprintf(folder, sizeof folder, "%s", lf_test_built("testdata"));
    snprintf(text, sizeof text, GRID, "'units': 'cm',", "1");
    render_text(folder, text, said);
    snprintf(text, sizeof text, GRID, "", "0.01");
    render_text(folder, text, by_hand);
    assert_memory_equal(said, by_hand, sizeof said);
    snprintf(text, sizeof text, GRID, "", "0.02");
    render_text(folder, text, wrong);
    assert_memory_not_equal(said, wrong, sizeof said);
}

static void mean_of(const char *text, double out[3])
{
    static float picture[VALUES];
    render_text(".", text, picture);
    out[0] = out[1] = out[2] = 0.0;
    for (int i = 0; i < VALUES; i++)
        out[i % 3] += (double)picture[i] * 3.0 / VALUES;
}

static void a_scene_in_millimetres_is_that_in_metres(void **state)
{
    (void)state;
    double metres[3], millimetres[3], wrong[3], plain[3];
    mean_of(lf_test_scene_text("in-metres"), metres);
    mean_of(lf_test_scene_patched("in-metres", "{'units': null}"), plain);
    assert_memory_equal(metres, plain, sizeof plain);
    mean_of(lf_test_scene_text("in-millimetres"), millimetres);
    for (int i = 0; i < 3; i++)
        lf_assert_close(millimetres[i], metres[i], 2e-3, 0);
    mean_of(lf_test_scene_patched("in-millimetres", "{'units': null}"),
            wrong); /* lamps a thousand times farther away */
    assert_true(wrong[0] < 0.5 * metres[0]);
}

/* What arrives a foot away from a lamp of 1 W sr^-1, in W m^-2. */
static void a_lamp_shines_on_square_metres_whatever_the_units(void **state)
{
    (void)state;
    const float u[3] = {0.3f, 0.4f, 0.6f};
    lf_scene *scene = lf_test_scene("{ 'units': 'ft', 'lights': { 'p': { 'type': 'point' } } }");
    lf_light_sample s;
    assert_true(lf_light_draw(scene, lf_v3(0.0f, -1.0f, 0.0f), u, &s));
    lf_assert_close(s.radiance.x, 1.0 / (0.3048 * 0.3048), 1e-6, 0);
    lf_scene_unref(scene);
}

static void units_that_nobody_knows_are_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "{\"units\": \"parsec\"}",
        "{\"units\": 2}",
        "{\"meshes\": {\"m\": {\"shape\": \"cube\", \"units\": \"in\"}}}",
        "{\"volumes\": {\"v\": {\"shape\": \"box\", \"units\": \"in\"}}}",
    };
    static const char *const words[] = {"expected one of mm, cm, m, km, in, ft", "string",
                                        "a shape has no units", "unknown key"};
    for (int i = 0; i < 4; i++) {
        lf_scene *scene = NULL;
        lf_error err;
        json_t *doc = json_loads(wrong[i], 0, NULL);
        assert_int_equal(lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, &err),
                         LF_E_FORMAT);
        if (!strstr(err.what, words[i]))
            fail_msg("%s: %s", wrong[i], err.what);
        json_decref(doc);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_mesh_in_inches_stands_beside_one_in_metres),
        cmocka_unit_test(a_grid_in_centimetres_is_one_scaled_by_a_hundredth),
        cmocka_unit_test(a_scene_in_millimetres_is_that_in_metres),
        cmocka_unit_test(a_lamp_shines_on_square_metres_whatever_the_units),
        cmocka_unit_test(units_that_nobody_knows_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
