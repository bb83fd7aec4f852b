/* cv beside what is much brighter than its neighbours: without bias, and never much noisier than
 * mis. */
#include "tests/testing.h"

#include "render/film/film.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/uniform.h"

/* ------------------------------------------------------------------------------- closed form -- */

enum { across = 8, pixels = 3 * across, highlight = pixels - 1 };
#define Q 0.5f
/* One visit in four meets the highlight. */
#define HIGHLIGHT 300.0

/* A half of one sample: W is q times an exponential variable x, N half its square, which have the
 * means q and q. What the highlight sends has nothing to do with W. Where there is W', W is another
 * such variable, which N knows less of. */
static void draw_half(uint64_t *random, lf_film_half *half)
{
    for (int i = 0; i < pixels; i++) {
        double x = -log(lf_test_uniform53(random)), y = 0.5 * x * x,
               less = -log(lf_test_uniform53(random));
        if (i == highlight)
            y = lf_test_uniform53(random) < 0.25 ? 4 * HIGHLIGHT : 0;
        float n = (float)(y * (double)Q), w = (float)(x * (double)Q);
        half->scattered[i] = (lf_film_scattered){{n, n, n}, w};
        if (half->w2) {
            half->scattered[i].w = Q * (float)(0.5 * x + 0.5 * less);
            half->w2[i] = w;
        }
        half->q[i] = Q;
    }
}

/* Smallest p of the pixels' means of cv against the truth; *out_ratio: the mean squared error of
 * cv over that of mis, of those beside the highlight. same: both halves hold the same numbers,
 * so that each takes its coefficients from itself. */
static double least_p_of_cv(bool has_w2, bool same, int runs, double *out_ratio)
{
    const lf_film_layout layout = {.n_views = 3, .width = across, .height = 1, .has_w2 = has_w2};
    lf_film film = {0};
    lf_moments moments[pixels] = {{0}};
    double error[2] = {0}, least = 1;
    uint64_t random = lf_test_seed();
    lf_assert_ok(lf_film_init(&film, &layout), NULL);
    film.rows[0].n[0] = film.rows[0].n[1] = 1;
    film.rows[0].visits[0] = film.rows[0].visits[1] = 1;
    for (int run = 0; run < runs; run++) {
        float out[2][3 * pixels];
        for (int h = 0; h < 2; h++) {
            uint64_t before = random;
            lf_film_half half = lf_film_at(&film, 0, h);
            draw_half(&random, &half);
            random = same && h == 0 ? before : random;
        }
        lf_assert_ok(lf_film_resolve_row(&film, LF_ESTIMATOR_MIS, 0, out[0], NULL), NULL);
        lf_assert_ok(lf_film_resolve_row(&film, LF_ESTIMATOR_CV, 0, out[1], NULL), NULL);
        for (int i = 0; i < pixels; i++) {
            double truth = (double)Q * (i == highlight ? HIGHLIGHT : 1);
            lf_moments_add(&moments[i], (double)out[1][3 * i]);
            for (int k = 0; k < 2 && i != highlight; k++)
                error[k] += pow((double)out[k][3 * i] - truth, 2);
        }
    }
    for (int i = 0; i < pixels; i++)
        least = fmin(least, lf_p_mean(&moments[i], (double)Q * (i == highlight ? HIGHLIGHT : 1)));
    *out_ratio = error[1] / error[0];
    lf_film_finish(&film);
    return least;
}

static void cv_has_no_bias_beside_a_highlight(void **state)
{
    (void)state;
    for (int has_w2 = 0; has_w2 < 2; has_w2++) {
        double ratio, own, runs = lf_test_long() ? 2e6 : 1e5;
        double p = least_p_of_cv(has_w2, false, (int)runs, &ratio),
               control = least_p_of_cv(has_w2, true, (int)runs, &own);
        print_message("p %.2g, of coefficients from the same half %.2g; squared error %.2f of "
                      "mis\n",
                      p, control, ratio);
        assert_true(p > lf_sidak(LF_FALSE_ALARM, 2 * pixels));
        assert_true(control < 1e-9);
        assert_true(ratio < 1);
    }
}

/* -------------------------------------------------------------------------------- renderings -- */

enum { views = 5, width = 24, height = 32, values = 3 * views * width * height, most_runs = 40 };

static int less(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* By two references, whose noise does not enter. */
static double relative_mse(const float *x, float truth[2][values])
{
    double sum = 0;
    for (int i = 0; i < values; i++) {
        double t = 0.5 * ((double)truth[0][i] + (double)truth[1][i]);
        sum += ((double)x[i] - (double)truth[0][i]) * ((double)x[i] - (double)truth[1][i]) /
               (t * t + 1e-2);
    }
    return sum / values;
}

static void cv_is_no_noisier_than_mis_beside_highlights(void **state)
{
    (void)state;
    static float truth[2][values], picture[values];
    int runs = lf_test_long() ? most_runs : 12;
    double ratio[most_runs];
    lf_scene *scene = lf_test_scene(lf_test_scene_text("glints"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    for (int i = 0; i < 2; i++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), ~(uint64_t)i));
        lf_test_cycles(r, lf_test_long() ? 1024 : 128);
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MIS, truth[i], NULL), NULL);
    }
    for (int i = 0; i < runs; i++) {
        double error[2];
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)i));
        lf_test_cycles(r, 4);
        for (int k = 0; k < 2; k++) {
            lf_assert_ok(
                lf_renderer_resolve(r, k ? LF_ESTIMATOR_CV : LF_ESTIMATOR_MIS, picture, NULL),
                NULL);
            error[k] = relative_mse(picture, truth);
        }
        ratio[i] = error[1] / error[0];
    }
    qsort(ratio, (size_t)runs, sizeof *ratio, less);
    print_message("relMSE of cv over that of mis: %.2f (%.2f to %.2f)\n", ratio[runs / 2], ratio[0],
                  ratio[runs - 1]);
    assert_true(ratio[runs - 1] <= 1.2);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cv_has_no_bias_beside_a_highlight),
        cmocka_unit_test(cv_is_no_noisier_than_mis_beside_highlights),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
