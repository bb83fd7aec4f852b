/* What every shape of homogeneous volumes promises (render/scene/shape.h). */
#include "tests/testing.h"

#include "render/scene/shape.h"

static float uniform(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (float)(*seed >> 40) * 0x1p-24f;
}

static void draw_point(uint64_t *seed, float half, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = half * (2.0f * uniform(seed) - 1.0f);
}

static bool contains(lf_volume_kind shape, const float o[3], const float d[3], float t)
{
    const float p[3] = {o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]};
    return lf_shape_contains(shape, p);
}

static int n_shapes(void)
{
    int n = 0;
    while (lf_volume_shapes[n])
        n++;
    return n;
}

static void a_line_is_inside_where_its_interval_says(void **state)
{
    (void)state;
    uint64_t seed = 1;
    for (int s = 0; s < n_shapes(); s++) {
        const lf_volume_kind shape = LF_VOLUME_GRID + 1 + (lf_volume_kind)s;
        int n_met = 0, n_missed = 0;
        for (int line = 0; line < 20000; line++) {
            float o[3], d[3], from, to;
            draw_point(&seed, 3.0f, o);
            draw_point(&seed, 1.0f, d);
            if (line % 4 == 0)
                d[line / 4 % 3] = 0.0f; /* along faces */
            lf_shape_interval(shape, o, d, &from, &to);
            const bool met = from < to;
            n_met += met;
            n_missed += !met;
            for (int i = 0; i < 8; i++) {
                /* points of the line anywhere, and about the ends */
                float t = i < 4 ? 40.0f * uniform(&seed) - 20.0f
                                : (i % 2 ? from : to) + 0.02f * (uniform(&seed) - 0.5f);
                float gap = lf_min(fabsf(t - from), fabsf(t - to));
                if (fabsf(t) < 1e3f && (met || gap > 1e-2f) && gap > 1e-4f)
                    assert_int_equal(contains(shape, o, d, t), met && t > from && t < to);
            }
        }
        assert_true(n_met > 1000 && n_missed > 1000);
    }
}

static void a_shape_reaches_as_far_as_its_farthest_point(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (int s = 0; s < n_shapes(); s++) {
        const lf_volume_kind shape = LF_VOLUME_GRID + 1 + (lf_volume_kind)s;
        for (int map = 0; map < 10; map++) {
            float row[3], p[3];
            double farthest = 0.0;
            draw_point(&seed, 2.0f, row);
            for (int i = 0; i < 100000; i++) {
                draw_point(&seed, 1.0f, p);
                double x = fabs((double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                                (double)row[2] * (double)p[2]);
                farthest = lf_shape_contains(shape, p) ? fmax(farthest, x) : farthest;
            }
            const double exact[3] = {(double)row[0], (double)row[1], (double)row[2]};
            double reach = lf_shape_reach(shape, exact);
            assert_true(farthest <= reach * (1.0 + 1e-6));
            assert_true(farthest > 0.9 * reach);
        }
    }
}

static void shapes_differ_and_a_grid_is_none(void **state)
{
    (void)state;
    const float corner[3] = {0.9f, 0.9f, 0.9f}, o[3] = {0, 0, 0}, d[3] = {1, 0, 0};
    float from, to;
    assert_string_equal(lf_volume_shapes[LF_VOLUME_SPHERE - 1], "sphere");
    assert_string_equal(lf_volume_shapes[LF_VOLUME_BOX - 1], "box");
    assert_true(lf_shape_contains(LF_VOLUME_BOX, corner));
    assert_false(lf_shape_contains(LF_VOLUME_SPHERE, corner));
    assert_false(lf_shape_contains(LF_VOLUME_GRID, o));
    lf_shape_interval(LF_VOLUME_GRID, o, d, &from, &to);
    assert_true(from >= to);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_is_inside_where_its_interval_says),
        cmocka_unit_test(a_shape_reaches_as_far_as_its_farthest_point),
        cmocka_unit_test(shapes_differ_and_a_grid_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
