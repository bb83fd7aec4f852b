/* Spot lights against closed forms: what arrives at a plane below one, and that the light of the
 * whole plane is the power that the cone sends out. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

static const struct {
    double angle, blend; /* of the cone, degrees; share of the half angle in which it fades */
} cones[] = {{45, 0.15}, {90, 0}, {20, 1}, {150, 0.5}, {1, 0.3}};
enum { N_CONES = 5 };

/* A spot of intensity 2 that stands `height` above the origin and points at it, and far below it a
 * ground that gives the scene a size; the axis is turned by `tilt` degrees about z. */
static lf_scene *make_spot(int cone, double height, double tilt)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{ 'lights': { 's': { 'type': 'spot', 'position': [0, %.17g, 0], 'direction': [%.17g, "
             "%.17g, 0], 'intensity': 2, 'angle': %g, 'blend': %g } } }",
             height, 3.0 * sin(tilt * M_PI / 180.0), -3.0 * cos(tilt * M_PI / 180.0),
             cones[cone].angle, cones[cone].blend);
    return lf_test_scene(text);
}

/* How much of the intensity goes along a direction `degrees` off the axis: the words of
 * docs/reference/scene-format.md. */
static double share(int cone, double degrees)
{
    double outer = 0.5 * cones[cone].angle, inner = outer * (1.0 - cones[cone].blend);
    if (degrees >= outer)
        return 0.0;
    if (degrees <= inner)
        return 1.0;
    double t = (cos(degrees * M_PI / 180.0) - cos(outer * M_PI / 180.0)) /
               (cos(inner * M_PI / 180.0) - cos(outer * M_PI / 180.0));
    return t * t * (3.0 - 2.0 * t);
}

/* Irradiance of a plane with normal +y at (x, 0, z). */
static double irradiance(const lf_scene *scene, double x, double z)
{
    const float u[3] = {0.3f, 0.4f, 0.6f};
    lf_light_sample s;
    if (!lf_light_draw(scene, lf_v3((float)x, 0.0f, (float)z), u, &s))
        return 0.0;
    assert_true(s.delta && s.pdf == 1.0f);
    return (double)(s.radiance.x * s.wi.y);
}

static void a_plane_below_a_spot_gets_what_the_cone_sends_there(void **state)
{
    (void)state;
    for (int cone = 0; cone < N_CONES; cone++) {
        const double height = 3.0, tilt = 25.0;
        lf_scene *scene = make_spot(cone, height, tilt);
        for (int i = 0; i < 200; i++) {
            double x = -4.0 + 0.05 * i, z = 0.3 * (i % 7), r2 = x * x + height * height + z * z;
            double along = (x * sin(tilt * M_PI / 180.0) + height * cos(tilt * M_PI / 180.0)) /
                           sqrt(r2),
                   off = acos(fmin(along, 1.0)) * 180.0 / M_PI;
            double want = 2.0 * share(cone, off) * height / (r2 * sqrt(r2));
            /* Next to the rim of a cone that does not fade one rounding decides. */
            if (fabs(off - 0.5 * cones[cone].angle) < 1e-3)
                continue;
            lf_assert_close(irradiance(scene, x, z), want, 2e-4, 1e-6);
        }
        lf_scene_unref(scene);
    }
}

/* Rings of a plane out to the rim, by the midpoint rule; the fall's closed form is pi I (inner +
 * outer versine), which is what the light is picked by. */
static void all_light_of_a_spot_arrives_on_a_plane(void **state)
{
    (void)state;
    enum { RINGS = 20000 };
    for (int cone = 0; cone < N_CONES; cone++) {
        lf_scene *scene = make_spot(cone, 1.0, 0.0);
        double outer = 0.5 * cones[cone].angle * M_PI / 180.0,
               inner = outer * (1.0 - cones[cone].blend), sum = 0.0;
        for (int i = 0; i < RINGS; i++) {
            double angle = outer * (i + 0.5) / RINGS, r = tan(angle),
                   wide = outer / RINGS / pow(cos(angle), 2.0);
            sum += irradiance(scene, r, 0.0) * 2.0 * M_PI * r * wide;
        }
        double power = M_PI * 2.0 * (2.0 - cos(inner) - cos(outer));
        lf_assert_close(sum, power, 1e-3, 0);
        lf_assert_close(lf_light_spot.power(&scene->lights[0], 5.0), power, 1e-5, 0);
        /* A negative control: a fall that were linear in the angle sends something else. */
        if (cones[cone].blend == 1.0)
            assert_true(fabs(2.0 * M_PI * 2.0 * (1.0 - sin(outer) / outer) - power) > 0.1 * power);
        lf_scene_unref(scene);
    }
}

/* Through the integrator: a white ground, seen from above, sends back what it gets over pi. */
static void a_ground_below_a_spot_has_its_radiance(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("spot-on-ground"));
    lf_renderer *renderer = lf_test_renderer(scene, "vpt", 4, 4, NULL);
    lf_test_cycles(renderer, 16);
    double *picture = lf_test_picture(renderer, LF_ESTIMATOR_MWIS), sum = 0.0;
    for (int i = 0; i < 16; i++)
        sum += picture[i] / 16.0;
    lf_assert_close(sum, 1.0 / M_PI, 0.02, 0);
    lf_free(picture);
    lf_renderer_destroy(renderer);
    lf_scene_unref(scene);
}

static void a_spot_whose_direction_has_no_length_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "{\"lights\": {\"s\": {\"type\": \"spot\", \"direction\": [0, 0, 0]}}}",
        "{\"lights\": {\"s\": {\"type\": \"spot\", \"angle\": 0}}}",
        "{\"lights\": {\"s\": {\"type\": \"spot\", \"blend\": 1.5}}}",
        "{\"lights\": {\"s\": {\"type\": \"spot\", \"cone\": 30}}}",
    };
    static const char *const words[] = {"must not be zero", "out of range: 0.1 to 180",
                                        "out of range: 0 to 1", "unknown key \"cone\""};
    for (int i = 0; i < 4; i++) {
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
        cmocka_unit_test(a_plane_below_a_spot_gets_what_the_cone_sends_there),
        cmocka_unit_test(all_light_of_a_spot_arrives_on_a_plane),
        cmocka_unit_test(a_ground_below_a_spot_has_its_radiance),
        cmocka_unit_test(a_spot_whose_direction_has_no_length_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
