/* The sky of a day: the model's own figures where they can be worked out by hand, its symmetries,
 * and what the renderer makes of it against sums over the model. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/transport/light/daylight.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

#define DEGREES (M_PI / 180.0)

/* Chromaticities and luminance of linear Rec. 709 (IEC 61966-2-1). */
static void xyY(const double rgb[3], double out[3])
{
    double x = 0.4124564 * rgb[0] + 0.3575761 * rgb[1] + 0.1804375 * rgb[2],
           y = 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2],
           z = 0.0193339 * rgb[0] + 0.1191920 * rgb[1] + 0.9503041 * rgb[2];
    out[0] = x / (x + y + z);
    out[1] = y / (x + y + z);
    out[2] = 179.0 * y;
}

/* The paper's appendix A.2, worked out apart from the program. With the sun at the horizon chi is 0
 * and 2.4192 - 0.2155 T is left; at the zenith the chromaticities are their last columns. */
static void the_zenith_is_as_the_paper_has_it(void **state)
{
    (void)state;
    static const struct {
        double turbidity, elevation, x, y, kcd;
    } cases[] = {
        {2, 90, 0.26674, 0.27720, 15.50067},  {2, 0, 0.28294, 0.30445, 1.98820},
        {6, 90, 0.28250, 0.29784, 57.17979},  {3, 30, 0.24493, 0.25257, 5.13916},
        {10, 60, 0.28458, 0.30828, 33.73974},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_daylight sky;
        double rgb[3], seen[3], e = cases[i].elevation * DEGREES;
        lf_daylight_init(&sky, cases[i].turbidity, e);
        lf_daylight_radiance(&sky, 1.0, sin(e), rgb);
        xyY(rgb, seen);
        lf_assert_close(seen[0], cases[i].x, 0, 1e-5);
        lf_assert_close(seen[1], cases[i].y, 0, 1e-5);
        lf_assert_close(1e-3 * seen[2], cases[i].kcd, 1e-6, 0);
    }
}

/* The ratio of two directions is that of Perez's formula alone: Y of turbidity 2, A = -1.1056, B =
 * -0.2833, C = 5.2797, D = -2.3359, E = 0.2363, the sun at the zenith. */
static void the_sky_falls_off_as_perez_has_it(void **state)
{
    (void)state;
    lf_daylight sky;
    double rgb[3], top[3], side[3];
    lf_daylight_init(&sky, 2.0, 0.5 * M_PI);
    lf_daylight_radiance(&sky, 1.0, 1.0, rgb);
    xyY(rgb, top);
    lf_daylight_radiance(&sky, 0.5, 0.5, rgb);
    xyY(rgb, side);
    double at_top = (1.0 - 1.1056 * exp(-0.2833)) * (1.0 + 5.2797 + 0.2363),
           at_side = (1.0 - 1.1056 * exp(-0.2833 / 0.5)) *
                     (1.0 + 5.2797 * exp(-2.3359 * M_PI / 3.0) + 0.2363 * 0.25);
    lf_assert_close(side[2] / top[2], at_side / at_top, 1e-6, 0);
}

/* A clear sun has about 10^5 lux at noon and is nearly white; low it is dimmer and red, in haze
 * more so. Without any air it would be 1.3 10^5 lux (128 klx is what the literature has). */
static void a_low_sun_is_dim_and_red(void **state)
{
    (void)state;
    double before[3] = {0}, rgb[3], seen[3];
    for (int degrees = 90; degrees >= 0; degrees -= 5) {
        lf_daylight_sun(2.0, degrees * DEGREES, rgb);
        xyY(rgb, seen);
        if (degrees == 90)
            assert_true(seen[2] > 0.9e5 && seen[2] < 1.2e5 && seen[0] > 0.32 && seen[0] < 0.36);
        else
            assert_true(seen[2] < before[2] && seen[0] > before[0]);
        assert_true(degrees > 0 || (rgb[0] > 20.0 * rgb[2] && seen[2] < 2e3));
        double clear = seen[2];
        lf_daylight_sun(6.0, degrees * DEGREES, rgb);
        xyY(rgb, before);
        assert_true(before[2] < clear && before[0] > seen[0]);
        memcpy(before, seen, sizeof before);
    }
}

static lf_scene *make_sky(const char *words)
{
    char text[512];
    snprintf(text, sizeof text, "{ 'lights': { 's': { 'type': 'sky'%s } } }", words);
    return lf_test_scene(text);
}

static lf_vec3 towards(double elevation, double azimuth)
{
    double e = elevation * DEGREES, a = azimuth * DEGREES;
    return lf_v3((float)(cos(e) * sin(a)), (float)sin(e), (float)(-cos(e) * cos(a)));
}

/* Radiance from infinity, the sky's and the sun's. */
static lf_vec3 look(const lf_scene *scene, lf_vec3 w)
{
    float pdf;
    return lf_light_escape(scene, w, &pdf);
}

static void the_two_sides_of_the_suns_plane_are_the_same(void **state)
{
    (void)state;
    lf_scene *scene = make_sky(", 'elevation': 25, 'azimuth': 70");
    for (int i = 0; i < 200; i++) {
        double elevation = 0.45 * i, off = 1.0 + 0.87 * i;
        lf_vec3 left = look(scene, towards(elevation, 70.0 - off)),
                right = look(scene, towards(elevation, 70.0 + off));
        lf_assert_close(left.x, (double)right.x, 1e-4, 0);
        lf_assert_close(left.z, (double)right.z, 1e-4, 0);
    }
    /* A negative control: about another plane they are not. */
    assert_true(fabsf(look(scene, towards(20, 40)).x - look(scene, towards(20, 60)).x) > 1.0f);
    lf_scene_unref(scene);
}

/* The picture against the model, off the horizon and the sun; and the disk of the sun where it is
 * said to be, with the radiance that makes up its irradiance. */
static void directions_find_what_the_model_has_there(void **state)
{
    (void)state;
    lf_scene *scene = make_sky(", 'elevation': 40, 'azimuth': -120, 'turbidity': 4, 'scale': 0.5");
    lf_daylight sky;
    double want[3], sun[3];
    lf_daylight_init(&sky, 4.0, 40.0 * DEGREES);
    lf_daylight_sun(4.0, 40.0 * DEGREES, sun);
    lf_vec3 middle = towards(40, -120), disk = look(scene, middle), beside;
    for (int i = 0; i < 300; i++) {
        lf_vec3 w = towards(2.0 + 0.29 * i, 37.0 * i);
        double cosine = (double)lf_dot(w, middle);
        if (cosine > cos(1.0 * DEGREES))
            continue;
        lf_daylight_radiance(&sky, (double)w.y, cosine, want);
        lf_vec3 found = look(scene, w);
        lf_assert_close(found.x, 0.5 * want[0], 0.01, 0);
        lf_assert_close(found.y, 0.5 * want[1], 0.01, 0);
        lf_assert_close(found.z, 0.5 * want[2], 0.01, 0);
    }
    beside = look(scene, towards(40.3, -120));
    double across = M_PI * pow(sin(0.5 * LF_SUN_ANGLE * DEGREES), 2.0);
    lf_assert_close(disk.x - beside.x, 0.5 * sun[0] / across, 1e-4, 0);
    lf_assert_close(disk.z - beside.z, 0.5 * sun[2] / across, 1e-4, 0);
    assert_true(disk.y > 1e3f * beside.y);
    lf_scene_unref(scene);
    scene = make_sky(", 'elevation': 40, 'azimuth': -120, 'turbidity': 4, 'sun': false");
    assert_int_equal(scene->n_lights, 1);
    assert_true(look(scene, middle).y < 1.1f * look(scene, towards(40.3, -120)).y);
    lf_scene_unref(scene);
}

/* Irradiance of a plane that looks up, by the midpoint rule over the model itself. */
static void sum_of_sky(const lf_daylight *sky, double out[3])
{
    enum { RINGS = 200, STEPS = 400 };
    out[0] = out[1] = out[2] = 0.0;
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < STEPS; j++) {
            double square = (i + 0.5) / RINGS, cosine = sqrt(1.0 - square), rgb[3],
                   phi = 2.0 * M_PI * (j + 0.5) / STEPS;
            lf_daylight_radiance(
                sky, cosine,
                cosine * sin(sky->elevation) + sqrt(square) * cos(sky->elevation) * cos(phi), rgb);
            for (int k = 0; k < 3; k++)
                out[k] += rgb[k] * M_PI / (RINGS * STEPS);
        }
}

/* A white plane seen from above sends back what it gets over pi; the ground below the horizon,
 * seen past it, its share of that. */
static void a_plane_has_the_light_of_the_sky_and_of_the_sun(void **state)
{
    (void)state;
    static const char *const words[] = {"true", "false"};
    for (int i = 0; i < 2; i++) {
        lf_scene *scene = lf_test_scene(
            lf_test_scene_patched("plane-under-sky", "{'lights': {'s': {'sun': %s}}}", words[i]));
        lf_daylight sky;
        double want[3], sun[3], sums[3] = {0};
        lf_daylight_init(&sky, 3.0, 20.0 * DEGREES);
        sum_of_sky(&sky, want);
        lf_daylight_sun(3.0, 20.0 * DEGREES, sun);
        for (int k = 0; k < 3; k++)
            want[k] += i == 0 ? sun[k] * sin(20.0 * DEGREES) : 0.0;
        lf_renderer *renderer = lf_test_renderer(scene, "vpt", 16, 16, NULL);
        float picture[3 * 256];
        lf_test_cycles(renderer, 32);
        assert_int_equal(lf_renderer_resolve(renderer, LF_ESTIMATOR_MWIS, picture, NULL), LF_OK);
        for (int k = 0; k < 3 * 256; k++)
            sums[k % 3] += (double)picture[k] / 256.0;
        for (int k = 0; k < 3; k++)
            lf_assert_close(sums[k], want[k] / M_PI, 0.005, 0);
        lf_vec3 ground = look(scene, towards(-30, 0));
        lf_assert_close(ground.x, 0.5 * want[0] / M_PI, 2e-3, 0);
        lf_assert_close(ground.z, 0.1 * want[2] / M_PI, 2e-3, 0);
        lf_renderer_destroy(renderer);
        lf_scene_unref(scene);
    }
}

static void a_sky_that_is_turned_or_dimmed_is_not_painted_anew(void **state)
{
    (void)state;
    lf_scene *first = make_sky("");
    const char *texts[] = {"'azimuth': 90, 'scale': 3, 'visible': false", "'elevation': 46",
                           "'turbidity': 3.5", "'ground': 0.3", "'sun': false"};
    for (int i = 0; i < 5; i++) {
        char text[256];
        snprintf(text, sizeof text, "{ 'lights': { 'other': { 'type': 'sky', %s } } }", texts[i]);
        lf_scene *second = lf_test_scene_in(".", text, first);
        assert_true((second->lights[0].environment == first->lights[0].environment) == (i == 0));
        lf_scene_unref(second);
    }
    lf_scene_unref(first);
}

static void a_sun_below_the_horizon_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "{\"lights\": {\"s\": {\"type\": \"sky\", \"elevation\": -1}}}",
        "{\"lights\": {\"s\": {\"type\": \"sky\", \"turbidity\": 1.5}}}",
        "{\"lights\": {\"s\": {\"type\": \"sky\", \"direction\": [0, -1, 0]}}}",
    };
    static const char *const words[] = {"out of range: 0 to 90", "out of range: 2 to 10",
                                        "unknown key \"direction\""};
    for (int i = 0; i < 3; i++) {
        lf_scene *scene = NULL;
        lf_error err;
        json_t *doc = json_loads(wrong[i], 0, NULL);
        assert_int_equal(lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, &err),
                         LF_E_FORMAT);
        assert_non_null(strstr(err.what, words[i]));
        json_decref(doc);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_zenith_is_as_the_paper_has_it),
        cmocka_unit_test(the_sky_falls_off_as_perez_has_it),
        cmocka_unit_test(a_low_sun_is_dim_and_red),
        cmocka_unit_test(the_two_sides_of_the_suns_plane_are_the_same),
        cmocka_unit_test(directions_find_what_the_model_has_there),
        cmocka_unit_test(a_plane_has_the_light_of_the_sky_and_of_the_sun),
        cmocka_unit_test(a_sky_that_is_turned_or_dimmed_is_not_painted_anew),
        cmocka_unit_test(a_sun_below_the_horizon_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
