/* Base samples by expected counts a pixel: under a map whose tiles expect from 1/16 to 16, with
 * pixels that nobody reads, the weights still arrive as n q in every pixel that is read, native and
 * shared answers agree with uniform vpt, and leaving c_k out is caught. amvpt, which makes its map
 * from a pilot, stays unbiased for mis and cv at fixed budgets. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum {
    width = 24,
    height = 16,
    n_views = 7,
    pixels = n_views * width * height,
    block = 8,
    blocks_of_all = n_views * 6 + 1
};

/* Weights: three scenes, W and W'; agreement: two scenes of three pictures and two of amvpt's two
 * answers. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 16 * blocks_of_all)
#define CERTAIN 1e-9

static lf_pool *pool;

/* Neighbouring tiles expect anything between 1/16 and 16, 1 on average over their logarithm; a
 * third of the view pixels of the right half is read by nobody when some are unread. */
static void make_map(lf_counts *counts, uint64_t **out_wanted, bool all_read)
{
    assert_int_equal(lf_counts_init(counts, n_views, width, height), LF_OK);
    size_t tiles = (size_t)counts->tiles_down * (size_t)counts->tiles_across * height;
    for (size_t i = 0; i < tiles; i++)
        counts->tile[i] = exp2f((float)(lf_hash64(17, i) % 9) - 4.0f);
    size_t words = lf_counts_words(counts);
    *out_wanted = calloc(words * height, sizeof **out_wanted);
    for (size_t row = 0; row < height; row++) {
        for (size_t i = 0; i < n_views * width; i++) {
            bool read = all_read || i % width < width / 2 || lf_hash64(row, i) % 3 > 0;
            (*out_wanted)[row * words + i / 64] |= (uint64_t)read << (i % 64);
        }
    }
    counts->wanted = *out_wanted;
}

static bool is_read(const lf_counts *counts, int pixel)
{
    size_t row = (size_t)pixel / (n_views * width), i = (size_t)pixel % (n_views * width);
    return counts->wanted[row * lf_counts_words(counts) + i / 64] >> (i % 64) & 1;
}

/* Visits of all sizes. */
static void schedule(lf_renderer *r)
{
    for (int i = 0; i < 4; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 1 + i, NULL, NULL, NULL), LF_OK);
    lf_test_passes(r, 2 * n_views);
}

/* Smallest p of W - n q and W' - n q over blocks of what is read; also that nothing arrives
 * elsewhere. */
static void p_of_weights(const char *text, unsigned faults, int replicates, double out_p[2])
{
    static double d[2][pixels], q[pixels], zero[pixels];
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
    lf_blocks blocks[2];
    lf_counts counts;
    uint64_t *wanted;
    make_map(&counts, &wanted, false);
    for (int second = 0; second < 2; second++)
        lf_blocks_init(&blocks[second], n_views, width, height, block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_rows(r)->plan.counts = &counts;
        r->faults = faults;
        schedule(r);
        for (int second = 0; second < 2; second++) {
            lf_test_weights(r, second, d[second], q);
            for (int i = 0; i < pixels; i++) {
                double n = r->film.rows[i / (n_views * width)].n[0] +
                           r->film.rows[i / (n_views * width)].n[1];
                if (!is_read(&counts, i))
                    assert_true(fabs(d[second][i] + q[i]) * n < 1e-6 * n);
                d[second][i] = is_read(&counts, i) ? d[second][i] : 0.0;
            }
            lf_blocks_add(&blocks[second], d[second]);
        }
    }
    for (int second = 0; second < 2; second++) {
        out_p[second] = lf_blocks_p(&blocks[second], zero, 0.0, NULL);
        lf_blocks_finish(&blocks[second]);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    lf_counts_finish(&counts);
    free(wanted);
}

static void case_20_weights_are_n_q_whatever_the_counts(void **state)
{
    (void)state;
    const char *const scenes[] = {
        lf_test_scene_views("mixed", 7),
        lf_test_scene_patched("fogs", "{'camera': {'views': 7, 'lens_radius': 0.1}}"),
        lf_test_scene_views("lamp", 7)};
    for (int i = 0; i < 3; i++) {
        double p[2];
        p_of_weights(scenes[i], 0, 24, p);
        print_message("scene %d: p of W %.3g, of W' %.3g\n", i, p[0], p[1]);
        assert_true(p[0] > LEVEL && p[1] > LEVEL);
    }
}

static void counts_left_out_of_the_sums_are_caught(void **state)
{
    (void)state;
    double p[2];
    p_of_weights(lf_test_scene_views("mixed", 7), LF_FAULT_NO_COUNTS, 12, p);
    print_message("p of W %.3g, of W' %.3g\n", p[0], p[1]);
    assert_true(p[0] < CERTAIN && p[1] < CERTAIN);
}

/* Pictures by both unbiased answers. */
static void pictures(lf_scene *scene, const char *integrator, const lf_counts *counts,
                     uint64_t seed, int passes, lf_blocks out[2])
{
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, pool);
    for (int i = 0; i < 2; i++)
        lf_blocks_init(&out[i], n_views, width, height, block);
    for (int k = 0; k < 24; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + seed, (uint64_t)k));
        lf_test_rows(r)->plan.counts = counts;
        lf_test_passes(r, passes);
        for (int i = 0; i < 2; i++) {
            double *picture = lf_test_picture(r, i ? LF_ESTIMATOR_CV : LF_ESTIMATOR_MIS);
            lf_blocks_add(&out[i], picture);
            free(picture);
        }
    }
    if (lf_test_rows(r)->plan.sharing->adaptive) {
        double least = 16.0, most = 0.0;
        for (int i = 0;
             i < lf_test_rows(r)->counts.tiles_down * lf_test_rows(r)->counts.tiles_across * height;
             i++) {
            least = fmin(least, (double)lf_test_rows(r)->counts.tile[i]);
            most = fmax(most, (double)lf_test_rows(r)->counts.tile[i]);
        }
        print_message("counts from %.3g to %.3g\n", least, most);
        assert_true(lf_test_rows(r)->mapped && most > 2.0 * least);
    }
    lf_renderer_destroy(r);
}

static void assert_agreement(const char *text)
{
    static const struct {
        const char *name, *integrator;
        bool map;
        int cycles; /* what the power takes */
    } ways[] = {{"mvpt under a map", "mvpt", true, 3},
                {"vpt under a map", "vpt", true, 8},
                {"amvpt", "amvpt", false, 5}};
    lf_scene *scene = lf_test_scene(text);
    lf_blocks native[2], other[2];
    lf_counts counts;
    uint64_t *wanted;
    make_map(&counts, &wanted, true);
    pictures(scene, "vpt", NULL, 100, 5 * n_views, native);
    for (int i = 0; i < 3; i++) {
        pictures(scene, ways[i].integrator, ways[i].map ? &counts : NULL, 200 + (uint64_t)i,
                 ways[i].cycles * n_views, other);
        for (int e = 0; e < 2; e++) {
            double p = lf_blocks_welch(&other[e], &native[0], NULL);
            double moved = lf_blocks_welch_injected(&other[e], &native[0], blocks_of_all - 1, 1.02);
            print_message("%s, %s: p %.3g, 2 %% too bright %.3g\n", ways[i].name, e ? "cv" : "mis",
                          p, moved);
            assert_true(p > LEVEL && moved < LEVEL);
            lf_blocks_finish(&other[e]);
        }
    }
    for (int e = 0; e < 2; e++)
        lf_blocks_finish(&native[e]);
    lf_scene_unref(scene);
    lf_counts_finish(&counts);
    free(wanted);
}

static void unbiased_answers_agree_with_uniform_vpt(void **state)
{
    (void)state;
    assert_agreement(lf_test_scene_views("mixed", 7));
    assert_agreement(lf_test_scene_views("lamp", 7));
}

/* Given its map a row is as under any fixed map: no random number of its own may have made it. */
static void a_rows_map_does_not_hear_of_its_own_pilot(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 7));
    lf_renderer *r = lf_test_renderer(scene, "amvpt", width, height, pool);
    lf_test_passes(r, 2 * n_views);
    lf_counts before, after;
    assert_int_equal(lf_counts_init(&before, n_views, width, height), LF_OK);
    assert_int_equal(lf_counts_init(&after, n_views, width, height), LF_OK);
    assert_int_equal(lf_adaptive_map(&r->film, pool, &before), LF_OK);
    const size_t row = 11;
    for (int half = 0; half < 2; half++) {
        lf_film_half sums = lf_film_at(&r->film, (int)row, half);
        for (int i = 0; i < n_views * width; i++)
            sums.scattered[i].n[0] *= 1.0f + 3.0f * (float)(half + i % 2);
    }
    assert_int_equal(lf_adaptive_map(&r->film, pool, &after), LF_OK);
    size_t n = (size_t)before.tiles_down * (size_t)before.tiles_across;
    assert_memory_equal(before.tile + row * n, after.tile + row * n, n * sizeof *before.tile);
    assert_memory_not_equal(before.tile + (row + 1) * n, after.tile + (row + 1) * n,
                            n * sizeof *before.tile);
    lf_counts_finish(&before);
    lf_counts_finish(&after);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* The map of a film whose pilot marked no mirrors: of a scene that has none, and of one that has (a
 * film that was restored). */
static void map_of_unmarked(const char *text, bool has_delta, lf_counts *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "amvpt", width, height, pool);
    lf_test_passes(r, 2 * n_views);
    assert_true(r->film.layout.has_native && r->film.layout.has_delta == has_delta);
    assert_int_equal(lf_counts_init(out, n_views, width, height), LF_OK);
    assert_int_equal(lf_adaptive_map(&r->film, pool, out), LF_OK);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Bulbs in fog give native samples too, which is no reason to spend samples everywhere. */
static void counts_fall_where_there_is_a_bulb_and_no_mirror(void **state)
{
    (void)state;
    const char *const scenes[] = {lf_test_scene_text("lit-from-within"),
                                  lf_test_scene_views("lamp", 7)};
    for (int mirrors = 0; mirrors < 2; mirrors++) {
        lf_counts counts;
        float least = INFINITY;
        map_of_unmarked(scenes[mirrors], mirrors, &counts);
        size_t n = (size_t)counts.tiles_down * (size_t)counts.tiles_across * height;
        for (size_t i = 0; i < n; i++)
            least = fminf(least, counts.tile[i]);
        if (mirrors)
            assert_true(least >= 1.0f);
        else
            assert_true(least < 0.5f);
        lf_counts_finish(&counts);
    }
}

static int set_up(void **state)
{
    (void)state;
    return lf_pool_create(1, &pool) == LF_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    lf_pool_destroy(pool);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(case_20_weights_are_n_q_whatever_the_counts),
        cmocka_unit_test(counts_left_out_of_the_sums_are_caught),
        cmocka_unit_test(unbiased_answers_agree_with_uniform_vpt),
        cmocka_unit_test(counts_fall_where_there_is_a_bulb_and_no_mirror),
        cmocka_unit_test(a_rows_map_does_not_hear_of_its_own_pilot),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
