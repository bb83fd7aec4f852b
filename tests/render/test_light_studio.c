/* The studio as a scene's light: its room and boxes have the radiance that is written down, turned
 * and scaled as the keys say, and a white card in it is as bright as it is to be. */
#include "tests/testing.h"

#include "render/transport/light/light_kind.h"
#include "tests/stat/fixture.h"

#define DEGREES (M_PI / 180.0)

static lf_scene *studio(const char *keys)
{
    char text[512];
    snprintf(text, sizeof text,
             "{\"quiltd\": 1, \"meshes\": {\"m\": {\"shape\": \"cube\"}}, "
             "\"lights\": {\"studio\": {\"type\": \"studio\"%s}}}",
             keys);
    return lf_test_scene(text);
}

/* What comes from an azimuth (0: -z, 90: +x) and elevation, of the red channel; the same in all. */
static double seen(const lf_scene *scene, double azimuth, double elevation)
{
    const double a = azimuth * DEGREES, e = elevation * DEGREES;
    const lf_vec3 w = lf_v3((float)(sin(a) * cos(e)), (float)sin(e), (float)(-cos(a) * cos(e)));
    const lf_light *light = &scene->lights[0];
    float pdf;
    const lf_vec3 radiance = light->kind->escape(light, w, &pdf);
    lf_assert_close((double)radiance.y, (double)radiance.x, 1e-5, 0);
    lf_assert_close((double)radiance.z, (double)radiance.x, 1e-5, 0);
    return (double)radiance.x;
}

static void room_and_boxes_are_as_written(void **state)
{
    (void)state;
    lf_scene *scene = studio("");
    lf_assert_close(seen(scene, 60, -90), 0.10, 0.02, 0);
    lf_assert_close(seen(scene, 60, -0.3), 0.17, 0.02, 0);
    lf_assert_close(seen(scene, -122, 42), 0.17 + 0.19 * sin(42 * DEGREES) + 6.6, 0.02, 0);
    lf_assert_close(seen(scene, 112, 20), 0.17 + 0.19 * sin(20 * DEGREES) + 1.2, 0.02, 0);
    lf_scene_unref(scene);
}

static void it_turns_and_is_scaled(void **state)
{
    (void)state;
    lf_scene *scene = studio(""), *turned = studio(", \"rotate\": 30, \"scale\": 2");
    for (int azimuth = -170; azimuth < 180; azimuth += 45)
        lf_assert_close(seen(turned, azimuth - 30, -40), 2.0 * seen(scene, azimuth, -40), 0.02, 0);
    lf_assert_close(seen(turned, -122 - 30, 42), 2.0 * seen(scene, -122, 42), 0.02, 0);
    lf_scene_unref(scene);
    lf_scene_unref(turned);
}

/* Irradiance / pi of a card that faces the large box, summed here over the hemisphere. */
static void a_white_card_is_as_bright_as_documented(void **state)
{
    (void)state;
    lf_scene *scene = studio("");
    const double a = -122 * DEGREES, e = 42 * DEGREES,
                 n[3] = {sin(a) * cos(e), sin(e), -cos(a) * cos(e)};
    double sum = 0.0;
    for (int y = -89; y < 90; y += 2)
        for (int x = -179; x < 180; x += 2) {
            const double u = x * DEGREES, v = y * DEGREES,
                         cosine = n[0] * sin(u) * cos(v) + n[1] * sin(v) - n[2] * cos(u) * cos(v);
            if (cosine > 0.0)
                sum += cosine * seen(scene, x, y) * cos(v) * 4.0 * DEGREES * DEGREES / M_PI;
        }
    lf_assert_close(sum, 1.2, 0.05, 0);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(room_and_boxes_are_as_written),
        cmocka_unit_test(it_turns_and_is_scaled),
        cmocka_unit_test(a_white_card_is_as_bright_as_documented),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
