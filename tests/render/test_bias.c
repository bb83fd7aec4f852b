/* The bias of mwis, measured: what it differs by from cv, which is unbiased, on one and the same
 * film, so that most of the noise cancels; over whole cycles n = 8 .. 64 (below, holes decide), the
 * mean over one view and over seeds, regressed on 1/n. mwis is consistent when the intercept is 0
 * within its standard error, and its bias falls as 1/n with the slope. An estimator with wrong
 * weights has an intercept. (One view, not all: what wrong weights take from one view they give to
 * another.) Standard errors are those of groups, each a regression of its own. QUILTD_LONG=1 takes
 * eight times the seeds. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 12, height = 8, views = 3, counts = 4, groups = 12 };

/* Four scenes' intercepts, each tested for being 0. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 4)
/* What a mistake must be rejected with. */
#define CERTAIN 1e-6

/* Relative to the view's mean. */
typedef struct line {
    lf_moments intercept, slope; /* over groups */
} line;

/* Mean over the first view of a picture [row][view][column]. */
static double first_view(const lf_renderer *r, lf_estimator estimator)
{
    double *picture = lf_test_picture(r, estimator), sum = 0.0;
    for (int row = 0; row < height; row++)
        for (int column = 0; column < width; column++)
            sum += picture[row * views * width + column];
    free(picture);
    return sum / (width * height);
}

/* Least squares of a + b/n, weighted by n^2: a difference of n cycles has a variance near 1/n^2.
 * Every seed is looked at after each n: what its cycles have in common cancels in part. */
static void add_group(lf_renderer *r, lf_estimator other, int group, line *out)
{
    double s = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, mean = 0.0;
    for (int k = 0; k < 2 * (lf_test_long() ? 8 : 1); k++) {
        lf_test_reseed(r, lf_hash64(lf_hash64(lf_test_seed(), (uint64_t)group), (uint64_t)k));
        for (int i = 0, done = 0; i < counts; i++) {
            const int n = 8 << i;
            const double weight = (double)n * n, x = 1.0 / n;
            lf_test_cycles(r, n - done);
            done = n;
            double y = first_view(r, LF_ESTIMATOR_MWIS) - first_view(r, other);
            mean = i == counts - 1 ? first_view(r, other) : mean;
            s += weight;
            sx += weight * x;
            sy += weight * y;
            sxx += weight * x * x;
            sxy += weight * x * y;
        }
    }
    double det = s * sxx - sx * sx;
    lf_moments_add(&out->intercept, (sxx * sy - sx * sxy) / det / mean);
    lf_moments_add(&out->slope, (s * sxy - sx * sy) / det / mean);
}

static line regress(const char *text, unsigned faults, lf_estimator other)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    line l = {.intercept = {0}};
    r->faults = faults;
    for (int group = 0; group < groups; group++)
        add_group(r, other, group, &l);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    print_message("mwis - %s: (%.2g +- %.2g) + (%.2g +- %.2g) / n of the mean\n",
                  lf_estimator_name(other), l.intercept.mean, lf_moments_error(&l.intercept),
                  l.slope.mean, lf_moments_error(&l.slope));
    return l;
}

/* Consistent; an intercept of 1 % of the mean would be seen. */
static void assert_consistent(const char *text)
{
    line l = regress(text, 0, LF_ESTIMATOR_CV);
    assert_true(lf_p_mean(&l.intercept, 0.0) > LEVEL);
    assert_true(lf_p_mean(&l.intercept, l.intercept.mean + 0.01) < LEVEL);
}

static void mwis_is_consistent_on_media_and_surfaces(void **state)
{
    (void)state;
    assert_consistent(lf_test_scene_views("mixed", 3));
}

static void mwis_is_consistent_on_overlapping_media(void **state)
{
    (void)state;
    assert_consistent(lf_test_scene_views("fogs", 3));
}

static void mwis_is_consistent_beside_a_lamp_and_a_mirror(void **state)
{
    (void)state;
    assert_consistent(lf_test_scene_views("lamp", 3));
}

static void mwis_is_consistent_behind_a_alpha(void **state)
{
    (void)state;
    assert_consistent(lf_test_scene_views("mist", 3));
}

/* Negative control: without h_k the weights do not tend to n q, and what mwis tends to is not what
 * mis does. */
static void wrong_weights_have_an_intercept(void **state)
{
    (void)state;
    line no_h = regress(lf_test_scene_views("mixed", 3), LF_FAULT_NO_H, LF_ESTIMATOR_MIS);
    line no_visibility =
        regress(lf_test_scene_views("mixed", 3), LF_FAULT_NO_VISIBILITY, LF_ESTIMATOR_MIS);
    assert_true(lf_p_mean(&no_h.intercept, 0.0) < CERTAIN);
    assert_true(lf_p_mean(&no_visibility.intercept, 0.0) < CERTAIN);
}

/* A card of one radiance before the dark, lit head-on, across the pixels: N/W is the same
 * everywhere, and the mean of the picture is the card's share of the window. What a pixel at its
 * rim shows although none of its film points has met the card would come on top, the more the fewer
 * visits there are: 1 % of the mean behind four visits. */

static void a_silhouette_has_no_rim_at_few_visits(void **state)
{
    (void)state;
    enum { across = 24, down = 18, replicates = 48, most = 8 };
    double side = 10 * tan(12 * M_PI / 180), truth = 0.5 / (side * side * 4 / 3);
    lf_scene *scene = lf_test_scene(lf_test_scene_text("card-in-the-dark"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", across, down, NULL);
    for (int cycles = 1; cycles <= most; cycles *= 2) {
        lf_moments mean = {0};
        for (int k = 0; k < replicates; k++) {
            lf_test_reseed(r, lf_hash64(lf_hash64(lf_test_seed(), (uint64_t)cycles), (uint64_t)k));
            lf_test_cycles(r, cycles);
            assert_int_equal(lf_renderer_fill_holes(r, NULL, NULL), LF_OK);
            double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS), sum = 0.0;
            for (int i = 0; i < 9 * across * down; i++)
                sum += picture[i];
            free(picture);
            lf_moments_add(&mean, sum / (9 * across * down));
        }
        print_message("%u visits: %.2g +- %.2g of the mean too bright\n",
                      r->film.rows[0].visits[0] + r->film.rows[0].visits[1], mean.mean / truth - 1,
                      lf_moments_error(&mean) / truth);
        assert_true(lf_p_mean(&mean, truth) > lf_sidak(LF_FALSE_ALARM, 4));
        assert_true(lf_p_mean(&mean, truth * 1.01) < CERTAIN);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mwis_is_consistent_on_media_and_surfaces),
        cmocka_unit_test(mwis_is_consistent_on_overlapping_media),
        cmocka_unit_test(mwis_is_consistent_beside_a_lamp_and_a_mirror),
        cmocka_unit_test(mwis_is_consistent_behind_a_alpha),
        cmocka_unit_test(wrong_weights_have_an_intercept),
        cmocka_unit_test(a_silhouette_has_no_rim_at_few_visits),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
