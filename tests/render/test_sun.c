/* Suns of every size in pictures: the disk itself, its image in a mirror, and a plane that it
 * lights. Replicates are seeds; that 0.5 % would be seen is asserted beside every mean. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { side = 24, n_views = 2, replicates = 8 };

static const char *const integrators[] = {"mvpt", "vpt"};
static const double degrees[] = {1e-4, 0.02, 0.05, 0.53, 6.0};
enum { n_degrees = sizeof degrees / sizeof degrees[0], comparisons = 3 * n_degrees };

/* The view of these tests, slanted so that no coordinate is round: what the camera looks along is
 * -towards. */
static const double towards[3] = {0.48, 0.6, 0.64};

static double radius_of(double angle)
{
    return 0.5 * angle * M_PI / 180.0;
}

/* A sun of irradiance 2 travelling along direction, and what else there is. */
static lf_scene *scene_of(const char *meshes, double angle, const double direction[3])
{
    return lf_test_scene(lf_test_scene_patched(
        "sun-and-materials",
        "{'lights': {'sun': {'direction': [%.17g, %.17g, %.17g], 'angle': %.17g}}, 'meshes': {%s}}",
        direction[0], direction[1], direction[2], angle, meshes));
}

/* The mean over pictures that span 2 tan(half) of the camera's plane, divided by what it should be.
 */
static void assert_mean(lf_scene *scene, double half, const char *integrator, double truth)
{
    lf_renderer *r = NULL;
    lf_pool *pool = NULL;
    lf_moments mean = {0};
    lf_render_settings settings = {.skip = LF_SKIP_ALL,
                                   .camera = *lf_scene_camera(scene),
                                   .width = side,
                                   .height = side,
                                   .integrator = integrator};
    double zoom = 0.5 * tan(half) / tan(0.5 * settings.camera.fov_y);
    settings.window[0] = settings.window[1] = 0.5 - zoom;
    settings.window[2] = settings.window[3] = 0.5 + zoom;
    settings.seed = lf_test_seed();
    lf_assert_ok(lf_pool_create(1, &pool), NULL);
    lf_assert_ok(lf_renderer_create(scene, &settings, pool, &r, NULL), NULL);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_cycles(r, 16);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS), sum = 0.0;
        for (int i = 0; i < side * side * n_views; i++)
            sum += picture[i] / (side * side * n_views);
        lf_moments_add(&mean, sum / truth);
        free(picture);
    }
    if (!(lf_p_mean(&mean, 1.0) > lf_sidak(LF_FALSE_ALARM, comparisons) ||
          fabs(mean.mean - 1.0) < 2e-5))
        fail_msg("%s: %.5f +- %.5f of what it should be", integrator, mean.mean,
                 lf_moments_error(&mean));
    assert_true(lf_moments_error(&mean) < 1.2e-3);
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

/* Radiance E / (pi sin^2 a) over a disk of radius tan a in a square of side 2 tan(1.6 a). */
static double disk_in_window(double radius)
{
    return 2.0 / pow(2.0 * cos(radius) * tan(1.6 * radius), 2.0);
}

static void a_sun_is_seen_at_its_size(void **state)
{
    (void)state;
    for (int i = 0; i < n_degrees; i++) {
        double radius = radius_of(degrees[i]);
        assert_mean(scene_of("", degrees[i], towards), 1.6 * radius, integrators[i % 2],
                    disk_in_window(radius));
    }
}

static void a_mirror_shows_a_sun_at_its_size(void **state)
{
    (void)state;
    double x = M_PI / 6.0, z = M_PI / 9.0, normal[3] = {-sin(z) * cos(x), cos(z) * cos(x), sin(x)},
           direction[3];
    double along = normal[0] * towards[0] + normal[1] * towards[1] + normal[2] * towards[2];
    for (int i = 0; i < 3; i++)
        direction[i] = towards[i] - 2.0 * along * normal[i];
    /* The middle of one triangle: the normals of two differ by 1e-7. */
    const char *mirror = "'m': {'shape': 'quad', 'material': 'mirror', "
                         "'transform': {'rotate': [30, 0, 20], 'translate': [0.4, 0.1, 0]}}";
    for (int i = 0; i < n_degrees; i++) {
        double radius = radius_of(degrees[i]);
        assert_mean(scene_of(mirror, degrees[i], direction), 1.6 * radius, integrators[1 - i % 2],
                    disk_in_window(radius));
    }
}

/* E albedo cos / pi, as long as all of the disk is above the horizon. */
static void a_plane_gets_the_energy_of_a_sun(void **state)
{
    (void)state;
    const char *plane = "'m': {'shape': 'quad', 'material': 'grey', 'transform': {'scale': 50, "
                        "'rotate': [60, 0, 0]}}";
    const double normal[3] = {0.0, 0.5, 0.8660254037844386};
    double cosine = normal[1] * towards[1] + normal[2] * towards[2];
    for (int i = 0; i < n_degrees; i++) {
        double angle = i + 1 < n_degrees ? degrees[i] : 90.0;
        const double down[3] = {-towards[0], -towards[1], -towards[2]};
        assert_mean(scene_of(plane, angle, down), 0.05, integrators[i % 2],
                    2.0 * 0.5 * cosine / M_PI);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sun_is_seen_at_its_size),
        cmocka_unit_test(a_mirror_shows_a_sun_at_its_size),
        cmocka_unit_test(a_plane_gets_the_energy_of_a_sun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
