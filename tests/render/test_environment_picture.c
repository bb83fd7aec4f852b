/* Pictures of the sky that say more than their pixels: cubes, colours of other primaries, numbers
 * that are not finite; and what is told of them. */
#include "tests/base/exr_bytes.h"

#include "render/transport/light/light_kind.h"
#include "tests/stat/fixture.h"

static lf_scene *scene_of(const char *folder, const char *file, const lf_scene *previous)
{
    char text[512];
    snprintf(text, sizeof text, "{'lights': {'e': {'type': 'environment', 'file': '%s'}}}", file);
    return lf_test_scene_in(folder, text, previous);
}

static lf_vec3 seen(const lf_scene *scene, double x, double y, double z)
{
    double n = sqrt(x * x + y * y + z * z);
    float pdf;
    return scene->lights[0].kind->escape(
        &scene->lights[0], lf_v3((float)(x / n), (float)(y / n), (float)(z / n)), &pdf);
}

static void assert_seen(lf_vec3 c, double r, double g, double b, double tolerance)
{
    lf_assert_close((double)c.x, r, 0, tolerance);
    lf_assert_close((double)c.y, g, 0, tolerance);
    lf_assert_close((double)c.z, b, 0, tolerance);
}

/* ------------------------------------------------------------------------------------- cubes -- */

static const unsigned char CUBE = 1;

static void write_cube(const char *folder, int side, float (*at)(int c, int x, int y))
{
    const exr_part_bytes part = {.channels = {"B", "G", "R"},
                                 .type = EXR_FLOAT,
                                 .at = at,
                                 .data = {0, 0, side - 1, 6 * side - 1},
                                 .attributes = {{"envmap", "envmap", &CUBE, 1}}};
    exr_write(lf_test_path(folder, "cube.exr"), &part, 1);
}

enum { SIDE = 8 };

/* One colour a face: 1 + its number, and odd digits. */
static float face_colour(int c, int x, int y)
{
    (void)x;
    return (float)(1 + y / SIDE) * (c == 0 ? 0.1f : c == 1 ? 0.3f : 0.7f);
}

static void each_face_is_seen_in_its_direction_and_even(void **state)
{
    static const double axes[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                      {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    write_cube(*state, SIDE, face_colour);
    lf_scene *scene = scene_of(*state, "cube.exr", NULL);
    assert_null(lf_scene_warning(scene, 0));
    for (int face = 0; face < 6; face++)
        for (int i = 0; i < 400; i++) {
            double d[3], u = (i % 20 - 9.5) * 0.1, v = (i / 20 - 9.5) * 0.1;
            for (int k = 0; k < 3; k++)
                d[k] = axes[face][k];
            d[face / 2 == 0] = u;
            d[face / 2 == 2 ? 1 : 2] = v;
            lf_vec3 c = seen(scene, d[0], d[1], d[2]);
            float expected = (float)(1 + face);
            assert_true(c.x == expected * 0.7f && c.y == expected * 0.3f && c.z == expected * 0.1f);
        }
    lf_scene_unref(scene);
}

/* Pixels of the corners in ImfEnvmap.h's drawing, whose number's bits say on which sides they lie;
 * between them a face's numbers are those of the point on the cube. */
static float corner_colour(int c, int x, int y)
{
    static const int corners[6][4] = {{3, 7, 1, 5}, {6, 2, 4, 0}, {6, 7, 2, 3},
                                      {0, 1, 4, 5}, {7, 6, 5, 4}, {2, 3, 0, 1}};
    int corner = corners[y / 2][2 * (y % 2) + x];
    return (float)(corner >> (2 - c) & 1);
}

static void faces_are_turned_as_openexr_draws_them(void **state)
{
    write_cube(*state, 2, corner_colour);
    lf_scene *scene = scene_of(*state, "cube.exr", NULL);
    for (int i = 0; i < 2000; i++) {
        double z = 1 - 2 * (i + 0.5) / 2000, r = sqrt(1 - z * z), phi = i * 2.399963;
        double d[3] = {r * cos(phi), z, r * sin(phi)};
        double most = fmax(fabs(d[0]), fmax(fabs(d[1]), fabs(d[2])));
        assert_seen(seen(scene, d[0], d[1], d[2]), (d[0] / most + 1) / 2, (d[1] / most + 1) / 2,
                    (d[2] / most + 1) / 2, 0.01);
    }
    lf_scene_unref(scene);
}

/* One bright pixel of 96 x 96 on a face, whose centre lies on its middle: what arrives from it is
 * its radiance times the solid angle of the pyramid that interpolation makes of it, (2 / 96)^2. */
static float sun_colour(int c, int x, int y)
{
    (void)c;
    return x == 48 && y == 48 ? 1000 : 0;
}

static void a_sun_on_a_cube_keeps_its_light(void **state)
{
    enum { BIG = 97 };
    write_cube(*state, BIG, sun_colour);
    lf_scene *scene = scene_of(*state, "cube.exr", NULL);
    const lf_environment *e = scene->lights[0].environment;
    double sum = 0;
    for (int y = 0; y < e->height; y++)
        for (int x = 0; x < e->width; x++)
            sum += (double)e->rgb[3 * ((size_t)y * (size_t)e->width + (size_t)x)] *
                   (cos(M_PI * y / e->height) - cos(M_PI * (y + 1) / e->height)) * 2 * M_PI /
                   e->width;
    lf_assert_close(sum, 1000 * (2.0 / 96) * (2.0 / 96), 0.01, 0);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------- colours, warnings -- */

static void write_sky(const char *folder, const char *name, const exr_part_bytes *part)
{
    exr_write(lf_test_path(folder, name), part, 1);
}

static void assert_one_line(const lf_scene *scene, const char *words)
{
    if (!lf_scene_warning(scene, 0) || !strstr(lf_scene_warning(scene, 0), words))
        fail_msg("no line says \"%s\"", words);
    assert_null(lf_scene_warning(scene, 1));
}

static void what_a_sky_says_in_vain_is_told_once_and_again_when_shared(void **state)
{
    const float luminance[1] = {80};
    const exr_part_bytes part = {.channels = {"B", "G", "R"},
                                 .value = {0.1f, 0.1f, 0.8f},
                                 .type = EXR_FLOAT,
                                 .attributes = {{"whiteLuminance", "float", luminance, 4}}};
    write_sky(*state, "sky.exr", &part);
    lf_scene *scene = scene_of(*state, "sky.exr", NULL),
             *again = scene_of(*state, "sky.exr", scene);
    assert_ptr_equal(scene->lights[0].environment, again->lights[0].environment);
    lf_scene_unref(scene);
    assert_one_line(again, "sky.exr: ignored whiteLuminance 80");
    assert_seen(seen(again, 1, 2, 3), 0.8, 0.1, 0.1, 1e-7);
    lf_scene_unref(again);
}

static void a_sky_of_other_primaries_is_converted(void **state)
{
    const float ap1[8] = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    const exr_part_bytes part = {.channels = {"B", "G", "R"},
                                 .value = {0.1f, 0.1f, 0.8f},
                                 .type = EXR_HALF,
                                 .attributes = {{"chromaticities", "chromaticities", ap1, 32}}};
    write_sky(*state, "sky.exr", &part);
    lf_scene *scene = scene_of(*state, "sky.exr", NULL);
    assert_null(lf_scene_warning(scene, 0));
    assert_seen(seen(scene, 1, 2, 3), 1.2935, 0.0088, 0.0832, 5e-4);
    lf_scene_unref(scene);
}

static void an_infinite_sun_is_as_bright_as_a_half_can_be(void **state)
{
    const exr_part_bytes part = {.channels = {"B", "G", "R"},
                                 .value = {1, 1, 1},
                                 .first = {2, INFINITY, NAN},
                                 .odd = true,
                                 .type = EXR_HALF};
    write_sky(*state, "sky.exr", &part);
    lf_scene *scene = scene_of(*state, "sky.exr", NULL);
    const float *rgb = scene->lights[0].environment->rgb;
    assert_true(rgb[0] == 0 && rgb[1] == 65504 && rgb[2] == 2 && rgb[3] == 1);
    assert_one_line(scene, "sky.exr: 1 pixel is not finite");
    lf_scene_unref(scene);
}

/* The small inputs of the audit, each with its right value. */
static void the_cases_come_out_right(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double rgb[3], tolerance;
    } cases[] = {
        {"cases/exr_chromaticities/rec709.json", {0.8, 0.1, 0.1}, 0.001},
        {"cases/exr_chromaticities/acescg.json", {0.8, 0.1, 0.1}, 0.001},
        {"cases/exr_chromaticities/xyz.json", {0.8, 0.1, 0.1}, 0.012},
        {"cases/hdr_primaries/plain.json", {0.78125, 0.09765625, 0.09765625}, 0},
        {"cases/hdr_primaries/rec2020.json", {1.2328, 0.0125, 0.0852}, 0.0005},
        {"cases/exr_envmap_cube/px.json", {1, 0, 0}, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *path = lf_test_shared(cases[i].name);
        lf_scene *scene = NULL;
        lf_error err;
        if (!path)
            skip();
        lf_assert_ok(lf_scene_load(path, NULL, NULL, &scene, &err), &err);
        assert_null(lf_scene_warning(scene, 0));
        assert_seen(seen(scene, 1, 0.1, 0.2), cases[i].rgb[0], cases[i].rgb[1], cases[i].rgb[2],
                    cases[i].tolerance);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_face_is_seen_in_its_direction_and_even),
        cmocka_unit_test(faces_are_turned_as_openexr_draws_them),
        cmocka_unit_test(a_sun_on_a_cube_keeps_its_light),
        cmocka_unit_test(what_a_sky_says_in_vain_is_told_once_and_again_when_shared),
        cmocka_unit_test(a_sky_of_other_primaries_is_converted),
        cmocka_unit_test(an_infinite_sun_is_as_bright_as_a_half_can_be),
        cmocka_unit_test(the_cases_come_out_right),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
