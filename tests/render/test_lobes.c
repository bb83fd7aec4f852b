/* Phase functions of two lobes: mixtures of Henyey and Greenstein's, and droplets of water.
 * Integrals over the sphere and mean cosines in closed form, samples against values by chi-square;
 * and pictures of a fog of two lobes, which is that of two fogs in one place that share its
 * density, a lobe each: both integrators against these by vpt, and droplets by mvpt against vpt;
 * blocks of 16 x 16 pixels of each view by Welch's test, replicates being seeds. Negative controls:
 * another share or g is rejected. */
#include "tests/testing.h"

#include "render/transport/path/phase.h"
#include "render/transport/sampler.h"
#include "tests/scene_file.h"
#include "tests/stat/chi2.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 3, tile = 16, tiles = n_views * 4 + 1, n_volumes = 8 };

#define LEVEL lf_sidak(LF_FALSE_ALARM, 8 * tiles)

/* Two mixtures, one of them without a first lobe, and droplets of so many micrometres. */
static lf_volume volume_of(int i)
{
    static const lf_volume mixtures[] = {{.g = 0.85f, .second = {0.3f, -0.4f, 0.0f}},
                                         {.g = 0.0f, .second = {0.5f, 0.7f, 0.0f}},
                                         {.g = -0.2f, .second = {1.0f, 0.6f, 0.0f}}};
    static const double diameters[] = {5, 8, 12, 25, 50};
    lf_volume volume = i < 3 ? mixtures[i] : (lf_volume){0};
    if (i >= 3)
        lf_phase_droplets(diameters[i - 3], &volume);
    return volume;
}

/* Draine's: g (1 + alpha (3 + 2 g^2) / 5) / (1 + alpha (1 + 2 g^2) / 3). */
static double mean_cosine(const lf_volume *v)
{
    double g = (double)v->second.g, a = (double)v->second.alpha, s = (double)v->second.share,
           second = g * (1 + a * (3 + 2 * g * g) / 5) / (1 + a * (1 + 2 * g * g) / 3);
    return (1 - s) * (double)v->g + s * second;
}

/* By the angle to the axis, finest at the forward end: theta = pi t^3. */
static void integrals_are_closed_forms(void **state)
{
    (void)state;
    const lf_vec3 axis = lf_v3(0.0f, 0.0f, 1.0f);
    enum { steps = 40000 };
    for (int i = 0; i < n_volumes; i++) {
        lf_volume v = volume_of(i);
        double sum = 0.0, cosine = 0.0;
        for (int j = 0; j < steps; j++) {
            double t = (j + 0.5) / steps, theta = M_PI * t * t * t,
                   ring = 2 * M_PI * sin(theta) * M_PI * 3 * t * t / steps;
            lf_vec3 w = lf_v3((float)sin(theta), 0.0f, (float)cos(theta));
            double value = (double)lf_volume_phase(&v, axis, w);
            sum += value * ring;
            cosine += value * ring * cos(theta);
        }
        lf_assert_close(sum, 1.0, 0, 1e-3);
        lf_assert_close(cosine, mean_cosine(&v), 0, 1e-3);
    }
}

/* The figures of a cloud's droplet, from the formulas by hand. */
static void droplets_are_those_of_the_fit(void **state)
{
    (void)state;
    lf_volume v = {0};
    lf_phase_droplets(10.0, &v);
    lf_assert_close(v.g, 0.98817669, 0, 1e-6);
    lf_assert_close(v.second.g, 0.55567125, 0, 1e-6);
    lf_assert_close(v.second.alpha, 21.9955209, 0, 1e-5);
    lf_assert_close(v.second.share, 0.48195543, 0, 1e-6);
}

typedef struct setup {
    lf_volume drawn, claimed;
    lf_vec3 w;
} setup;

static bool draw(const void *context, const float u[3], lf_vec3 *w)
{
    const setup *s = context;
    *w = lf_volume_phase_sample(&s->drawn, s->w, u);
    return true;
}

static double pdf(const void *context, lf_vec3 w)
{
    const setup *s = context;
    return (double)lf_volume_phase(&s->claimed, s->w, w);
}

static double p_value(const setup *s, double *mass)
{
    double width_of = 1.0 - fmax(fabs((double)s->drawn.g), fabs((double)s->drawn.second.g)),
           warp = fmax(0.1, log(4.0 / (width_of * width_of)));
    lf_chi2_sphere q = {draw, pdf, s, s->w, 2.0, warp, 40, 20, 400000, lf_test_seed()};
    return lf_chi2_sphere_p(&q, mass);
}

static void samplers_follow_their_values(void **state)
{
    (void)state;
    for (int i = 0; i < n_volumes; i++) {
        setup s = {volume_of(i), volume_of(i), lf_v3(0.48f, -0.6f, 0.64f)};
        double mass, p = p_value(&s, &mass);
        if (!(p > lf_sidak(LF_FALSE_ALARM, n_volumes)) || fabs(mass - 1.0) > 2e-3)
            fail_msg("%d: p %g, integral %g", i, p, mass);
    }
    setup wrong = {volume_of(0), volume_of(0), lf_v3(0.48f, -0.6f, 0.64f)};
    wrong.claimed.second.share = 0.33f;
    assert_true(p_value(&wrong, NULL) < 1e-6);
    wrong = (setup){volume_of(5), volume_of(5), wrong.w};
    wrong.claimed.second.g *= 0.95f;
    assert_true(p_value(&wrong, NULL) < 1e-6);
}

static void corners_of_the_unit_square_give_unit_directions(void **state)
{
    (void)state;
    for (int i = 0; i < n_volumes; i++) {
        lf_volume v = volume_of(i);
        for (int j = 0; j < 8; j++) {
            const float end = 0x1.fffffep-1f,
                        u[3] = {j & 1 ? end : 0.0f, j & 2 ? end : 0.0f, j & 4 ? end : 0.0f};
            assert_true(fabsf(lf_length(lf_volume_phase_sample(&v, lf_v3(0, 1, 0), u)) - 1.0f) <
                        1e-5f);
        }
    }
}

/* One fog in the place of the two of two-lobes. */
#define ONE(phase)                                                                                 \
    lf_test_scene_patched("two-lobes", "{'volumes': {'a': {'density': 2, " phase "}, 'b': null}}")

static void pictures(const char *text, const char *integrator, uint64_t salt, lf_blocks out[2])
{
    lf_test_two_answers(lf_test_scene(text), integrator, width, height, tile, salt, out);
}

/* b, and another that differs, against a by vpt. */
static void compare(const char *a, const char *b, const char *other)
{
    lf_blocks truth[2], seen[2];
    pictures(a, "vpt", 1, truth);
    for (int i = 0; i < 3; i++) {
        pictures(i < 2 ? b : other, i == 1 ? "vpt" : "mvpt", 2, seen);
        lf_test_assert_answers(seen, &truth[1], LEVEL, i < 2);
    }
    for (int j = 0; j < 2; j++)
        lf_blocks_finish(&truth[j]);
}

static void two_lobes_are_two_fogs(void **state)
{
    (void)state;
    compare(lf_test_scene_text("two-lobes"), ONE("'g': 0.6, 'second_g': -0.5, 'second_share': 0.3"),
            ONE("'g': 0.6, 'second_g': -0.5, 'second_share': 0.4"));
}

static void droplets_are_the_same_by_both_integrators(void **state)
{
    (void)state;
    compare(ONE("'g': null, 'droplets': 8"), ONE("'g': null, 'droplets': 8"), ONE("'g': 0.8"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integrals_are_closed_forms),
        cmocka_unit_test(droplets_are_those_of_the_fit),
        cmocka_unit_test(samplers_follow_their_values),
        cmocka_unit_test(corners_of_the_unit_square_give_unit_directions),
        cmocka_unit_test(two_lobes_are_two_fogs),
        cmocka_unit_test(droplets_are_the_same_by_both_integrators),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
