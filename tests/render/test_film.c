/* The film's arithmetic: bytes a view pixel, sums that neither stagnate nor drift, means that stay
 * exact, the few bits of the halves' difference, and light that is known without being stored. */
#include "tests/testing.h"

#include "render/film/film.h"
#include "render/film/film_difference.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

static const lf_film_layout row_of_256 = {.n_views = 1, .width = 256, .height = 1, .has_w2 = true};

typedef struct bench {
    lf_film film;
    lf_film_sums sums;
} bench;

static void bench_init(bench *b, const lf_film_layout *layout)
{
    assert_int_equal(lf_film_init(&b->film, layout), LF_OK);
    int stream;
    assert_int_equal(lf_film_stream_at(&b->film, 0, 0, &stream), LF_OK);
    assert_int_equal(lf_film_sums_init(&b->sums, layout), LF_OK);
    lf_film_sums_begin(&b->sums);
}

static void bench_finish(bench *b)
{
    lf_film_sums_finish(&b->sums);
    lf_film_finish(&b->film);
}

/* Merges `visits` visits that all find what the sums hold. */
static void merge(bench *b, int half, int visits, double spp)
{
    for (int i = 0; i < visits; i++)
        lf_film_merge(&b->film, 0, 0, half, &b->sums, spp * b->film.n_views,
                      lf_hash64(lf_test_seed(), (uint64_t)i * 2 + (uint64_t)half));
}

static double bytes_a_pixel(bool w2, bool known, bool native)
{
    const lf_film_layout layout = {.n_views = 45,
                                   .width = 420,
                                   .height = 2,
                                   .has_w2 = w2,
                                   .has_native = native,
                                   .has_known = known};
    lf_film film = {0};
    assert_int_equal(lf_film_init(&film, &layout), LF_OK);
    double bytes = (double)film.data_bytes / (45 * 420 * 2);
    lf_film_finish(&film);
    return bytes;
}

static void a_view_pixel_takes_at_most_64_bytes(void **state)
{
    (void)state;
    lf_assert_close(bytes_a_pixel(false, false, false), 40, 1e-3, 0);
    lf_assert_close(bytes_a_pixel(true, false, false), 48, 1e-3, 0);
    lf_assert_close(bytes_a_pixel(false, true, false), 56, 1e-3, 0);
    lf_assert_close(bytes_a_pixel(true, true, false), 64, 1e-3, 0);
    lf_assert_close(bytes_a_pixel(true, true, true), 64, 1e-3, 0);
}

/* Ten million contributions of one: 222 222 visits of 45, whole numbers all the way. */
static void case_19_ten_million_ones_are_ten_million(void **state)
{
    (void)state;
    bench b;
    const lf_film_layout layout = {.n_views = 1, .width = 1, .height = 1};
    bench_init(&b, &layout);
    b.sums.half.scattered[0] = (lf_film_scattered){{45, 45, 45}, 45};
    merge(&b, 0, 222222, 1.0);
    lf_assert_close((double)lf_film_at(&b.film, 0, 0).scattered[0].w, 45.0 * 222222, 0, 0);
    lf_assert_close(b.film.rows[0].n[0], 222222, 0, 0);
    bench_finish(&b);
}

/* Mean and standard deviation of the relative error of W over 256 pixels that all get the same. */
static void relative_errors(const bench *b, double truth, double *out_mean, double *out_deviation)
{
    const lf_film_half half = lf_film_at(&b->film, 0, 0);
    double sum = 0, squares = 0;
    for (int i = 0; i < 256; i++) {
        double error = (double)half.scattered[i].w / truth - 1;
        sum += error;
        squares += error * error;
    }
    *out_mean = sum / 256;
    *out_deviation = sqrt(squares / 256);
}

/* The worst case of plain floats, the same awkward number again and again: sums of 2^17 of them,
 * and a tenth of 2^-24 of the sum, far below half a unit in the last place. The bound is film.h's;
 * unbiased: the mean within 4 standard errors. */
static void sums_neither_drift_nor_stagnate(void **state)
{
    (void)state;
    enum { visits = 1 << 17 };
    bench b;
    double error, deviation, bound = 0x1p-24 * sqrt(visits / 3.0);
    bench_init(&b, &row_of_256);
    const float x = 0.7f, tiny = 1e-8f;
    for (int i = 0; i < 256; i++)
        b.sums.half.scattered[i].w = x;
    merge(&b, 0, visits, 1.0);
    relative_errors(&b, visits * (double)x, &error, &deviation);
    print_message("2^17 times 0.7: relative error %.2g on average, %.2g a pixel, bound %.2g\n",
                  error, deviation, bound);
    assert_true(deviation < bound && fabs(error) < 4 * deviation / sqrt(256));
    double before = (double)lf_film_at(&b.film, 0, 0).scattered[0].w;
    float plain = 0, stuck = (float)before;
    for (int i = 0; i < visits; i++) {
        plain += x;
        stuck += tiny;
    }
    assert_true(fabs((double)plain / (visits * (double)x) - 1) > 20 * bound);
    assert_true((double)stuck == before); /* the test's own test */

    for (int i = 0; i < 256; i++) {
        lf_film_at(&b.film, 0, 0).scattered[i].w = 1.0f;
        b.sums.half.scattered[i].w = tiny;
    }
    merge(&b, 0, visits, 1.0);
    relative_errors(&b, 1 + visits * (double)tiny, &error, &deviation);
    print_message("2^17 times 1e-8 on top of 1: %.2g on average, %.2g a pixel\n", error, deviation);
    assert_true(deviation < bound && fabs(error) < 4 * deviation / sqrt(256));
    bench_finish(&b);
}

/* Stress case 19: ten million contributions, 1 and 1e8 in turn, 45 a visit. */
static void case_19_ones_beside_hundred_millions_are_kept(void **state)
{
    (void)state;
    enum { visits = 222222 };
    bench b;
    double error, deviation;
    bench_init(&b, &row_of_256);
    for (int i = 0; i < visits; i++) {
        for (int k = 0; k < 256; k += i == 0 ? 1 : 256)
            b.sums.half.scattered[k].w = 22 * 1e8f + 22;
        lf_film_merge(&b.film, 0, 0, 0, &b.sums, 1.0, lf_hash64(lf_test_seed(), (uint64_t)i));
    }
    relative_errors(&b, visits * (double)(22 * 1e8f + 22), &error, &deviation);
    print_message("1 and 1e8, ten million times: relative error %.2g on average, %.2g a pixel\n",
                  error, deviation);
    assert_true(deviation < 0x1p-24 * sqrt(visits / 3.0) &&
                fabs(error) < 4 * deviation / sqrt(256));
    bench_finish(&b);
}

static void what_is_constant_stays_exact(void **state)
{
    (void)state;
    bench b;
    const lf_film_layout layout = {.n_views = 2, .width = 3, .height = 1, .has_known = true};
    bench_init(&b, &layout);
    for (int i = 0; i < 6; i++) {
        b.sums.half.q[i] = 0.1f * (float)i;
        for (int c = 0; c < 3; c++)
            b.sums.known[i][c] = 0.3f + 0.7f * (float)c;
    }
    for (int i = 0; i < 1000; i++)
        merge(&b, i & 1, 1, i % 3 == 0 ? 1.0 : 2.0 / 45);
    for (int i = 0; i < 6; i++) {
        const lf_film_known *known = &lf_film_known_at(&b.film, 0)[i];
        for (int h = 0; h < 2; h++)
            assert_true(lf_film_at(&b.film, 0, h).q[i] == b.sums.half.q[i]);
        for (int c = 0; c < 3; c++)
            assert_true(known->b[c] == b.sums.known[i][c]);
        assert_int_equal(known->difference, 0);
    }
    bench_finish(&b);
}

/* Half 0 has found 1 and half 1 has found 3. A visit of half 0 finds 2, the mean of both. */
static void a_visit_that_finds_the_mean_brings_the_halves_nearer(void **state)
{
    (void)state;
    bench b;
    const lf_film_layout layout = {.n_views = 1, .width = 1, .height = 1, .has_known = true};
    const float found[3] = {1.0f, 3.0f, 2.0f};
    float difference[3];
    bench_init(&b, &layout);
    for (int v = 0; v < 3; v++) {
        for (int c = 0; c < 3; c++)
            b.sums.known[0][c] = found[v];
        merge(&b, v & 1, 1, 1.0);
    }
    const lf_film_known *known = lf_film_known_at(&b.film, 0);
    lf_difference_unpack(known->difference, difference);
    for (int c = 0; c < 3; c++) {
        lf_assert_close((double)known->b[c], 2.0, 1e-6, 0.0);
        lf_assert_close((double)difference[c], -1.5, 1e-2, 0.0);
    }
    bench_finish(&b);
}

/* Known light and delta lobes that change from visit to visit, against the same in double. The
 * difference's rounding adds about 1e-5 a visit to its mean square (film_difference.h). */
static void known_light_and_its_difference_follow_both_halves(void **state)
{
    (void)state;
    enum { visits = 400 };
    bench b;
    const lf_film_layout layout = {
        .n_views = 1, .width = 256, .height = 1, .has_known = true, .has_native = true};
    double n[2] = {0}, sum[2][256] = {{0}}, wrong = 0, squares = 0;
    bench_init(&b, &layout);
    for (int v = 0; v < visits; v++) {
        int half = v % 3 == 1;
        double weight = v % 5 == 0 ? 1.0 : 1.0 / 9;
        for (int i = 0; i < 256; i++) {
            float x = (float)(lf_hash64((uint64_t)v, (uint64_t)i) >> 40) * 0x1p-24f;
            for (int c = 0; c < 3; c++) {
                b.sums.known[i][c] = x;
                b.sums.native[i][c] = 2 * (float)weight * x * x;
            }
            sum[half][i] += weight * ((double)x + 2 * (double)x * (double)x);
        }
        n[half] += weight;
        lf_film_merge(&b.film, 0, 0, half, &b.sums, weight, lf_hash64(lf_test_seed(), (uint64_t)v));
    }
    for (int i = 0; i < 256; i++) {
        const lf_film_known *known = &lf_film_known_at(&b.film, 0)[i];
        float difference[3];
        lf_difference_unpack(known->difference, difference);
        double truth = sum[0][i] / n[0] - sum[1][i] / n[1];
        lf_assert_close((double)known->b[1], (sum[0][i] + sum[1][i]) / (n[0] + n[1]), 5e-6, 0);
        wrong += ((double)difference[1] - truth) * ((double)difference[1] - truth);
        squares += truth * truth;
    }
    print_message("difference between halves: %.2g of its mean square is rounding\n",
                  wrong / squares);
    assert_true(wrong / squares < 1e-5 * visits);
    bench_finish(&b);
}

static void differences_are_packed_without_bias(void **state)
{
    (void)state;
    const float large[3] = {1e-20f, -3.0f, 2.9f}, huge[3] = {INFINITY, 0, 1}, none[3] = {0, 0, 0},
                odd[3] = {1, NAN, 2};
    float x[3];
    double sum[3] = {0};
    assert_int_equal(lf_difference_pack(none, 0.9f), 0);
    assert_int_equal(lf_difference_pack(huge, 0.5f), 0);
    assert_int_equal(lf_difference_pack(odd, 0.5f), 0);
    for (int i = 0; i < 1000; i++) {
        lf_difference_unpack(lf_difference_pack(large, ((float)i + 0.5f) / 1000), x);
        for (int c = 0; c < 3; c++)
            sum[c] += (double)x[c] / 1000;
        assert_true(fabsf(x[1] + 3.0f) <= 3.0f / 64 && fabsf(x[2] - 2.9f) <= 3.0f / 64);
    }
    lf_assert_close(sum[1], -3, 1e-4, 0);
    lf_assert_close(sum[2], (double)2.9f, 1e-4, 0);
    for (int e = -90; e < 90; e++) {
        const float edge[3] = {ldexpf(127.9f / 128, e), -ldexpf(1.0f, e - 1), 0};
        lf_difference_unpack(lf_difference_pack(edge, 0.999f), x);
        lf_assert_close((double)x[0], (double)edge[0], 1.0 / 63, 0);
        lf_assert_close((double)x[1], (double)edge[1], 1.0 / 31, 0);
    }
}

/* All that 16 bits can be goes through unchanged, whatever the random number; what lies between two
 * is one of them, and on average itself. */
static void features_are_packed_without_bias(void **state)
{
    (void)state;
    enum { N = 1 << 16 };
    const float unit = 1.0f / 65535.0f;
    const lf_feature ends = {100.0f, 100.0f, 1.0f + 1e-6f, INFINITY},
                     x = {8.0f * 20000.25f * unit, 4.0f * 7.5f * unit, 65534.75f * unit, 0.7f};
    double sum[4] = {0};
    for (uint32_t i = 0; i < N; i++) {
        uint16_t v = (uint16_t)i;
        const lf_packed_feature all = {v, v, v, v < 0x7e00 ? v : 0};
        const lf_feature there = lf_feature_unpack(all);
        const uint32_t any = (uint32_t)lf_hash64(i, 3), last = UINT32_MAX;
        lf_packed_feature back = lf_feature_pack(&there, UINT32_C(1) << 31);
        assert_memory_equal(&back, &all, sizeof all);
        back = lf_feature_pack(&ends, i % 2 ? any : last);
        assert_true(back.nearness == 65535 && back.spread == 65535 && back.surface == 65535);
        assert_true(lf_feature_unpack(back).light < INFINITY);
        const lf_feature y = lf_feature_unpack(lf_feature_pack(&x, i << 16));
        assert_true(fabsf(y.nearness - x.nearness) < 8.0f * unit && fabsf(y.light - 0.7f) < 4e-3f);
        sum[0] += (double)y.nearness / N;
        sum[1] += (double)y.spread / N;
        sum[2] += (double)y.surface / N;
        sum[3] += (double)y.light / N;
    }
    lf_assert_close(sum[0], (double)x.nearness, 1e-6, 0.0);
    lf_assert_close(sum[1], (double)x.spread, 1e-5, 0.0);
    lf_assert_close(sum[2], (double)x.surface, 1e-6, 0.0);
    lf_assert_close(sum[3], (double)x.light, 1e-5, 0.0);
}

/* Over visits of any weight; what no ray has met says nothing. */
static void features_are_means_weighted_by_q(void **state)
{
    (void)state;
    enum { visits = 60, width = 200 };
    bench b;
    const lf_film_layout layout = {.n_views = 1, .width = width, .height = 1, .has_features = true};
    double total[width] = {0}, sum[4][width] = {{0}}, wrong[4] = {0};
    bench_init(&b, &layout);
    for (int v = 0; v < visits; v++) {
        double spp = v % 5 == 0 ? 1.0 : 1.0 / 9;
        for (size_t i = 0; i < width; i++) {
            float x = (float)(lf_hash64((uint64_t)v, (uint64_t)i) >> 40) * 0x1p-24f,
                  q = v % 4 == 3 ? 0.0f : (float)(i + 1) * x / width;
            const lf_feature f = {1.0f + x, 0.2f * x, x * x, 5.0f * x};
            lf_film_pivots(&b.sums, i, q);
            lf_film_note(&b.sums, i, f);
            double w = spp * (double)q, y = (double)f.nearness, z = (double)f.spread;
            total[i] += w;
            sum[0][i] += w * y;
            sum[1][i] += w * (y * y + z * z);
            sum[2][i] += w * (double)f.surface;
            sum[3][i] += w * (double)f.light;
        }
        lf_film_merge(&b.film, 0, 0, 1, &b.sums, spp, lf_hash64(lf_test_seed(), (uint64_t)v));
    }
    for (size_t i = 0; i < width; i++) {
        const lf_feature f = lf_feature_unpack(lf_film_at(&b.film, 0, 1).feature[i]);
        double y = sum[0][i] / total[i], z = sqrt(sum[1][i] / total[i] - y * y);
        lf_assert_close((double)f.nearness, y, 0.0, 2e-3);
        lf_assert_close((double)f.spread, z, 0.0, 2e-3);
        lf_assert_close((double)f.surface, sum[2][i] / total[i], 0.0, 3e-4);
        lf_assert_close((double)f.light, sum[3][i] / total[i], 0.1, 0.0);
        wrong[0] += ((double)f.nearness - y) / width;
        wrong[3] += ((double)f.light * total[i] / sum[3][i] - 1.0) / width;
    }
    print_message("features: %.2g of nearness and %.2g of light are rounding on average\n",
                  wrong[0], wrong[3]);
    assert_true(fabs(wrong[0]) < 1e-4 && fabs(wrong[3]) < 2.5e-3);
    bench_finish(&b);
}

/* Correction weights make q negative now and then: nothing is learnt there. */
static void features_are_never_drawn_away_from_what_was_met(void **state)
{
    (void)state;
    bench b;
    const lf_film_layout layout = {.n_views = 1, .width = 1, .height = 1, .has_features = true};
    const lf_feature f = {1.0f, 0.0f, 1.0f, 0.25f}, other = {4.0f, 0.0f, 0.0f, 8.0f};
    bench_init(&b, &layout);
    for (int i = 0; i < 3; i++) {
        lf_film_pivots(&b.sums, 0, i == 1 ? -0.4f : 0.5f);
        lf_film_note(&b.sums, 0, i == 1 ? other : f);
        merge(&b, 0, 1, 1.0);
    }
    const lf_feature x = lf_feature_unpack(lf_film_at(&b.film, 0, 0).feature[0]);
    lf_assert_close((double)x.nearness, 1.0, 2e-4, 0.0);
    assert_true(x.surface == 1.0f && x.light == 0.25f);
    bench_finish(&b);
}

static void features_that_are_constant_stay_exact(void **state)
{
    (void)state;
    bench b;
    const lf_film_layout layout = {.n_views = 1, .width = 2, .height = 1, .has_features = true};
    const lf_feature f = {8.0f * 0.2f, 4.0f * 0.6f, 1.0f, 0.25f};
    bench_init(&b, &layout);
    lf_film_pivots(&b.sums, 0, 0.3f);
    lf_film_note(&b.sums, 0, f);
    merge(&b, 0, 100000, 2.0 / 45);
    const lf_packed_feature *packed = lf_film_at(&b.film, 0, 0).feature;
    assert_int_equal(packed[0].surface, 65535);
    assert_int_equal(packed[0].light, 0x3e80);
    assert_true(abs(packed[0].nearness - 13107) <= 1 && abs(packed[0].spread - 39321) <= 1);
    assert_memory_equal(&packed[1], &(lf_packed_feature){0}, sizeof packed[1]);
    bench_finish(&b);
}

/* What scatters is as uneven as W, or as W', both of which are known to be q in the mean: nothing
 * is left of it. */
static void both_controls_take_out_what_they_explain(void **state)
{
    (void)state;
    const lf_film_layout layout = {.n_views = 1, .width = 16, .height = 1, .has_w2 = true};
    for (int second = 0; second < 2; second++) {
        bench b;
        float out[3 * 16];
        bench_init(&b, &layout);
        for (int i = 0; i < 16; i++) {
            float w = i % 2 ? 0.75f : 0.25f, w2 = i / 2 % 2 ? 0.625f : 0.375f,
                  n = 3.0f * (second ? w2 : w);
            b.sums.half.scattered[i] = (lf_film_scattered){{n, n, n}, w};
            b.sums.half.w2[i] = w2;
            b.sums.half.q[i] = 0.5f;
        }
        merge(&b, 0, 1, 1.0);
        merge(&b, 1, 1, 1.0);
        assert_int_equal(lf_film_resolve_row(&b.film, LF_ESTIMATOR_CV, 0, out, NULL), LF_OK);
        for (int i = 0; i < 3 * 16; i++)
            lf_assert_close((double)out[i], 1.5, 1e-6, 0);
        /* without them it is uneven */
        assert_int_equal(lf_film_resolve_row(&b.film, LF_ESTIMATOR_MIS, 0, out, NULL), LF_OK);
        assert_true(fabsf(out[0] - 1.5f) > 0.3f);
        bench_finish(&b);
    }
}

static void resolve_all(lf_renderer *r, lf_estimator estimator, float *out)
{
    assert_int_equal(lf_renderer_resolve(r, estimator, out, NULL), LF_OK);
}

/* One scene, its B stored and not: the same picture but for rounding. */
static void light_that_is_not_stored_is_the_same_light(void **state)
{
    (void)state;
    enum { views = 5, width = 16, height = 12, values = 3 * views * width * height };
    static float stored[values], implied[values];
    lf_pool *pool = NULL;
    assert_int_equal(lf_pool_create(1, &pool), LF_OK);
    lf_scene *scene = lf_test_scene(lf_test_scene_text("fog-over-ground"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
    assert_false(r->film.layout.has_known);
    json_t *skipped = lf_renderer_skipped(r);
    assert_non_null(json_object_get(skipped, "known-light"));
    json_decref(skipped);
    for (int e = LF_ESTIMATOR_MWIS; e <= LF_ESTIMATOR_CV; e++) {
        lf_test_reseed(r, 7);
        lf_test_passes(r, 2 * views);
        resolve_all(r, (lf_estimator)e, implied);

        lf_film_layout layout = r->film.layout;
        layout.has_known = true;
        lf_film_finish(&r->film);
        lf_film_sums_finish(&lf_test_rows(r)->workers[0].sums);
        assert_int_equal(lf_film_init(&r->film, &layout), LF_OK);
        assert_int_equal(lf_film_sums_init(&lf_test_rows(r)->workers[0].sums, &layout), LF_OK);
        lf_test_passes(r, 2 * views);
        resolve_all(r, (lf_estimator)e, stored);
        for (int i = 0; i < values; i++)
            lf_assert_close((double)stored[i], (double)implied[i], 1e-6, 1e-6);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    lf_pool_destroy(pool);
}

/* A picture that is wrong where two numbers of a visit hang together stops improving at some 100
 * passes; 16 times the passes are at least 8 times better here (15 and 26). */
static void the_error_goes_on_falling(void **state)
{
    (void)state;
    enum { views = 9, width = 16, height = 12 };
    static float picture[3 * views * width * height];
    lf_pool *pool = NULL;
    assert_int_equal(lf_pool_create(1, &pool), LF_OK);
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "fog-over-ground", "{'camera': {'views': 9}, 'volumes': {'fog': {'density': 4}}, "
                           "'meshes': null, 'materials': null}"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
    for (int e = LF_ESTIMATOR_MWIS; e <= LF_ESTIMATOR_MIS; e++) {
        lf_render_stats few, many;
        lf_test_reseed(r, lf_test_seed());
        lf_test_passes(r, 32 * views);
        resolve_all(r, (lf_estimator)e, picture);
        lf_renderer_stats(r, &few);
        lf_test_passes(r, 15 * 32 * views);
        resolve_all(r, (lf_estimator)e, picture);
        lf_renderer_stats(r, &many);
        print_message("%s: %.3g, with 16 times the passes %.3g\n",
                      lf_estimator_name((lf_estimator)e), few.rel_mse_estimate,
                      many.rel_mse_estimate);
        assert_true(many.rel_mse_estimate < few.rel_mse_estimate / 8);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    lf_pool_destroy(pool);
}

static bool stores(const char *text)
{
    lf_pool *pool = NULL;
    assert_int_equal(lf_pool_create(1, &pool), LF_OK);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", 4, 4, pool);
    bool known = r->film.layout.has_known;
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    lf_pool_destroy(pool);
    return known;
}

/* Suns with a disk, mirrors and lamps, black cards: B is no longer sky (1 - q). */
static void light_is_stored_where_it_is_not_implied(void **state)
{
    (void)state;
    assert_false(stores(lf_test_scene_views("fogs", 3)));
    assert_false(stores(lf_test_scene_views("bent", 3)));
    assert_true(stores(lf_test_scene_views("mixed", 3)));
    assert_true(stores(lf_test_scene_views("lamp", 3)));
    assert_true(stores(lf_test_scene_views("mist", 3)));
}

/* However they are rounded: a surface that fills a pixel does so for ever. */
static void ends_of_features_stay(void **state)
{
    (void)state;
    const lf_feature most = {LF_NEARNESS_MAX, 0.5f * LF_NEARNESS_MAX, 1.0f, 0.0f}, none = {0};
    for (uint32_t random = 0; random < 65536; random++) {
        lf_feature a = lf_feature_unpack(lf_feature_pack(&most, random << 16)),
                   b = lf_feature_unpack(lf_feature_pack(&none, random << 16));
        assert_true(memcmp(&a, &most, sizeof a) == 0 && memcmp(&b, &none, sizeof b) == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ends_of_features_stay),
        cmocka_unit_test(a_view_pixel_takes_at_most_64_bytes),
        cmocka_unit_test(case_19_ten_million_ones_are_ten_million),
        cmocka_unit_test(sums_neither_drift_nor_stagnate),
        cmocka_unit_test(case_19_ones_beside_hundred_millions_are_kept),
        cmocka_unit_test(what_is_constant_stays_exact),
        cmocka_unit_test(a_visit_that_finds_the_mean_brings_the_halves_nearer),
        cmocka_unit_test(known_light_and_its_difference_follow_both_halves),
        cmocka_unit_test(differences_are_packed_without_bias),
        cmocka_unit_test(features_are_packed_without_bias),
        cmocka_unit_test(features_are_means_weighted_by_q),
        cmocka_unit_test(features_are_never_drawn_away_from_what_was_met),
        cmocka_unit_test(features_that_are_constant_stay_exact),
        cmocka_unit_test(both_controls_take_out_what_they_explain),
        cmocka_unit_test(light_that_is_not_stored_is_the_same_light),
        cmocka_unit_test(the_error_goes_on_falling),
        cmocka_unit_test(light_is_stored_where_it_is_not_implied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
