/* Sums of moments and the fits made of them: seen from another place, as a linear function says,
 * and in coarser cells what finer ones have. */
#include "tests/render/reconstruct_testing.h"
#include "tests/scene_file.h"

#include "render/reconstruct/kernel.h"

static float pseudo(uint64_t i)
{
    return (float)(lf_hash64(lf_test_seed(), i) >> 40) * 0x1p-24f;
}

/* Sums over 200 places of a linear function, as seen from `from`. */
static lf_moments sums_of(const float from[3], const float slope[LF_FEATURES])
{
    lf_moments m = {.w = 0.0f};
    for (uint64_t i = 0; i < 200; i++) {
        float f[LF_FEATURES], x = 2.0f, w = 0.5f + pseudo(100 * i + 99);
        for (uint64_t j = 0; j < LF_FEATURES; j++) {
            f[j] = pseudo(100 * i + j) * (j == LF_VIEW ? 1.0f : 4.0f);
            x += slope[j] * f[j];
        }
        for (int j = 0; j < 3; j++)
            f[j] -= from[j];
        const float n[3] = {w * x, 2.0f * w * x, 3.0f * w};
        lf_reconstruct_kernels_c.add(&m, w, n, f);
    }
    return m;
}

static const float slopes[LF_FEATURES] = {0.3f, -0.2f, 0.5f, 0.1f, -0.4f, 0.6f, 0.2f, -0.1f};

static void sums_that_are_moved_are_those_from_there(void **state)
{
    (void)state;
    static const float here[3], there[3] = {1.5f, -2.0f, 0.75f};
    lf_moments from_here = sums_of(here, slopes), expected = sums_of(there, slopes), moved = {0};
    const float shift[LF_FEATURES] = {-there[0], -there[1], -there[2]};
    lf_reconstruct_kernels_c.move(&moved, &from_here, 2.0f, shift);
    lf_assert_close((double)moved.w, 2.0 * (double)expected.w, 1e-5, 0.0);
    for (int i = 0; i < LF_FEATURES; i++) {
        lf_assert_close((double)moved.wf[i], 2.0 * (double)expected.wf[i], 1e-4, 1e-2);
        for (int j = i; j < LF_FEATURES; j++)
            lf_assert_close((double)moved.wff[i][j], 2.0 * (double)expected.wff[i][j], 1e-4, 1e-1);
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)moved.nf[c][i], 2.0 * (double)expected.nf[c][i], 1e-4, 1e-1);
    }
}

/* Among others that have nothing. */
static void solve_one(const lf_moments *m, lf_plane out[3])
{
    static const lf_moments none = {.w = 0.0f};
    const lf_moments *lanes[LF_SOLVE_LANES];
    lf_plane other[LF_SOLVE_LANES][3], (*to[LF_SOLVE_LANES])[3];
    for (int l = 0; l < LF_SOLVE_LANES; l++) {
        lanes[l] = l == 5 ? m : &none;
        to[l] = &other[l];
    }
    lf_reconstruct_kernels_c.solve(lanes, 16.0, to);
    for (int l = 0; l < LF_SOLVE_LANES; l++)
        for (int i = 0; i < LF_FEATURES && l != 5; i++)
            assert_true(other[l][0].slope[i] == 0.0f && other[l][0].constant == 0.0f);
    memcpy(out, other[5], sizeof other[5]);
}

static void a_linear_function_is_found(void **state)
{
    (void)state;
    static const float here[3];
    lf_moments m = sums_of(here, slopes);
    lf_plane out[3];
    solve_one(&m, out);
    for (int i = 0; i < LF_FEATURES; i++) {
        /* the ridge and floors of variances draw slopes towards 0 by a few per cent */
        lf_assert_close((double)out[0].slope[i], (double)slopes[i], 0.1, 1e-3);
        lf_assert_close((double)out[1].slope[i], 2.0 * (double)out[0].slope[i], 1e-3, 1e-5);
        lf_assert_close((double)out[2].slope[i], 0.0, 0.0, 1e-4);
    }
    lf_assert_close((double)out[2].constant, 3.0, 1e-4, 0.0);
    m.wff[LF_VIEW][LF_VIEW] = -m.w; /* no sums: the constant is left */
    solve_one(&m, out);
    assert_true(out[0].slope[LF_PLACE] == 0.0f && out[0].slope[LF_LIGHT] == 0.0f);
    lf_assert_close((double)out[0].constant, (double)(m.n[0] / m.w), 1e-6, 0.0);
}

/* Of features that no place is part of, which moving leaves as they are: sums over all cells of a
 * level, in the order of the finest. */
static void sum_level(const lf_reconstruction *r, int level, double out[LF_FEATURES][LF_FEATURES])
{
    const lf_lattice *l = &r->level[level];
    memset(out, 0, LF_FEATURES * sizeof *out);
    for (int b = 0; b < l->n_bands; b++)
        for (int n = 0; n < l->bands[b].n; n++)
            for (int i = 3; i < LF_FEATURES; i++)
                for (int j = 3; j < LF_FEATURES; j++)
                    out[i][j] += (double)l->bands[b].sums[n].half[0][0].wff[i][j];
}

/* The sums of all levels, which the fit has given back. */
static void sum_up(lf_renderer *r)
{
    reconstruct_gather(r);
    for (int level = 1; level < LF_LEVELS; level++)
        for (int b = 0; b < r->shown->level[level].n_bands; b++)
            lf_assert_ok(lf_moments_coarsen(r->shown, level, b), NULL);
}

static void coarser_cells_have_what_finer_ones_have(void **state)
{
    (void)state;
    double finest[LF_FEATURES][LF_FEATURES], sum[LF_FEATURES][LF_FEATURES];
    lf_renderer *r = reconstruct_renderer(lf_test_scene_views("mixed", 9), 32, 24, NULL);
    reconstruct_visits(r, NULL, 3);
    lf_assert_ok(lf_renderer_fit(r, NULL), NULL);
    sum_up(r);
    sum_level(r->shown, 0, finest);
    assert_true(finest[LF_VIEW][LF_VIEW] > 0.0 && finest[LF_PIVOTS][LF_PIVOTS] > 1.0);
    for (int level = 1; level < LF_LEVELS; level++) {
        sum_level(r->shown, level, sum);
        for (int i = 3; i < LF_FEATURES; i++)
            for (int j = 3; j < LF_FEATURES; j++)
                lf_assert_close(sum[i][j], finest[i][j], 1e-4,
                                1e-5 * sqrt(finest[i][i] * finest[j][j]));
        for (int b = 0; b < r->shown->level[level].n_bands; b++)
            for (int n = 0; n < r->shown->level[level].bands[b].n; n++) {
                const lf_moments *m = &r->shown->level[level].bands[b].sums[n].half[0][0];
                for (int i = 0; i < LF_FEATURES; i++)
                    for (int j = 0; j < i; j++)
                        assert_true(m->wff[i][j] == m->wff[j][i]);
            }
    }
    lf_renderer_destroy(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_that_are_moved_are_those_from_there),
        cmocka_unit_test(a_linear_function_is_found),
        cmocka_unit_test(coarser_cells_have_what_finer_ones_have),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
