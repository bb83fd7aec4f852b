#include "tests/testing.h"

#include "render/transport/path/phase.h"
#include "render/transport/sampler.h"
#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"

static const float all_g[] = {0.0f, 1e-4f, 0.5f, -0.5f, 0.8f, 0.98f, -0.98f, 0.9999f, -0.9999f};
enum { n_g = (int)(sizeof all_g / sizeof *all_g) };

typedef struct setup {
    float g, pdf_g; /* what is drawn, and what is claimed */
    lf_vec3 w;
} setup;

static bool draw(const void *context, const float u[3], lf_vec3 *w)
{
    const setup *s = context;
    *w = lf_phase_sample(s->g, s->w, u);
    return true;
}

static double pdf(const void *context, lf_vec3 w)
{
    const setup *s = context;
    return (double)lf_phase_between(s->pdf_g, s->w, w);
}

/* e^warp spans the lobe's width squared: half the bins inside it. */
static double p_value(const setup *s, double *mass)
{
    double width = 1.0 - fabs((double)s->g), warp = fmax(0.1, log(4.0 / (width * width)));
    lf_vec3 axis = lf_scale(s->w, copysignf(1.0f, s->g));
    lf_chi2_sphere q = {draw, pdf, s, axis, 2.0, warp, 40, 20, 1000000, lf_test_seed()};
    return lf_chi2_sphere_p(&q, mass);
}

static void case_14_sampler_follows_the_phase_function(void **state)
{
    (void)state;
    const lf_vec3 directions[] = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, -1.0f}, {0.48f, -0.6f, 0.64f}};
    for (int i = 0; i < n_g; i++) {
        for (int j = 0; j < 3; j++) {
            double mass;
            setup s = {all_g[i], all_g[i], directions[j]};
            double p = p_value(&s, &mass);
            if (!(p > lf_sidak(LF_FALSE_ALARM, 3 * n_g)) || fabs(mass - 1.0) > 1e-3)
                fail_msg("g %g: p %g, integral %g", (double)all_g[i], p, mass);
        }
    }
}

static void a_wrong_g_is_rejected(void **state)
{
    (void)state;
    const float wrong[][2] = {
        {0.0f, 0.02f}, {0.5f, 0.515f}, {0.5f, -0.5f}, {0.98f, 0.981f}, {0.9999f, 0.999905f}};
    for (int i = 0; i < 5; i++) {
        setup s = {wrong[i][0], wrong[i][1], lf_v3(0.48f, -0.6f, 0.64f)};
        assert_true(p_value(&s, NULL) < 1e-6);
    }
}

static void mean_cosine_is_g(void **state)
{
    (void)state;
    for (int i = 0; i < n_g; i++) {
        lf_moments m = {0};
        lf_vec3 w = lf_v3(0.36f, 0.48f, -0.8f);
        for (uint32_t j = 0; j < 200000; j++) {
            lf_sampler s;
            float u[2];
            lf_sampler_init(&s, LF_SAMPLER_INDEPENDENT, lf_test_seed() + 17, j);
            lf_sampler_2d(&s, u);
            lf_vec3 d = lf_sub(lf_phase_sample(all_g[i], w, u), w);
            lf_moments_add(&m, 0.5 * (double)lf_dot(d, d));
        }
        assert_true(lf_p_mean(&m, 1.0 - (double)all_g[i]) > lf_sidak(LF_FALSE_ALARM, n_g));
    }
}

static void both_forms_agree_and_are_finite(void **state)
{
    (void)state;
    for (int i = 0; i < n_g; i++) {
        for (int j = 0; j <= 1000; j++) {
            float cosine = -1.0f + (float)j / 500.0f,
                  sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
            float a = lf_phase(all_g[i], cosine),
                  b = lf_phase_between(all_g[i], lf_v3(0.0f, 0.0f, 1.0f),
                                       lf_v3(sine, 0.0f, cosine));
            assert_true(isfinite(a) && a > 0.0f && isfinite(b) && b > 0.0f);
            if (fabsf(cosine) < 0.999f)
                assert_true(fabsf(a - b) < 1e-3f * a);
        }
    }
    float peak = lf_phase(0.9999f, 1.0f), expected = LF_INV_4PI * 1.9999f / (1e-4f * 1e-4f);
    assert_true(fabsf(peak / expected - 1.0f) < 2e-3f);
}

static void corners_of_the_unit_square_give_unit_directions(void **state)
{
    (void)state;
    for (int i = 0; i < n_g; i++) {
        for (int j = 0; j < 4; j++) {
            const float end = 0x1.fffffep-1f, u[2] = {j & 1 ? end : 0.0f, j & 2 ? end : 0.0f};
            lf_vec3 w = lf_phase_sample(all_g[i], lf_v3(0.0f, 1.0f, 0.0f), u);
            assert_true(fabsf(lf_length(w) - 1.0f) < 1e-5f);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(case_14_sampler_follows_the_phase_function),
        cmocka_unit_test(a_wrong_g_is_rejected),
        cmocka_unit_test(mean_cosine_is_g),
        cmocka_unit_test(both_forms_agree_and_are_finite),
        cmocka_unit_test(corners_of_the_unit_square_give_unit_directions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
