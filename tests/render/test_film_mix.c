/* Films of one picture that become one. */
#include "tests/render/added.h"
#include "tests/testing.h"

#include <math.h>

#include "render/film/film.h"
#include "render/film/film_difference.h"
#include "render/transport/sampler.h"

enum { WIDTH = 512, HEIGHT = 3, VISITS = 12 };

static const lf_film_layout whole = {.n_views = 1,
                                     .width = WIDTH,
                                     .height = HEIGHT,
                                     .has_w2 = true,
                                     .has_native = true,
                                     .has_known = true,
                                     .has_features = true};

/* What visit v of a stream finds at a pixel, in eighths when exact, else anything. */
static float value(uint32_t stream, int v, int pixel, bool exact)
{
    uint64_t bits = lf_hash64(lf_hash64(stream, (uint64_t)v), (uint64_t)pixel);
    return exact ? (float)(bits % 64) / 8 : (float)(bits >> 40) * 0x1p-24f;
}

static int half_of(int v)
{
    return v % 3 == 1;
}

/* What packing leaves as it is. */
static const lf_feature level = {.nearness = 8.0f, .surface = 1.0f, .light = 0.75f};

/* The visits of one stream to one row. */
static void accumulate(lf_film *film, uint32_t stream, int row, bool exact)
{
    lf_film_sums sums;
    int index;
    lf_assert_ok(lf_film_sums_init(&sums, &film->layout), NULL);
    lf_assert_ok(lf_film_stream_at(film, 17, stream, &index), NULL);
    for (int v = 0; v < VISITS; v++) {
        lf_film_sums_begin(&sums);
        for (int i = 0; i < WIDTH; i++) {
            size_t pixel = (size_t)i;
            float x = value(stream, v, i, exact), q = exact ? 0.25f : x;
            lf_film_scatter(&sums, pixel, x, 2 * x, 3 * x);
            lf_film_weigh(&sums, pixel, x);
            lf_film_weigh_direction(&sums, pixel, x);
            lf_film_pivots(&sums, pixel, q);
            lf_film_known_light(&sums, pixel, q, q, q);
            lf_film_note(&sums, pixel, exact ? level : (lf_feature){4 * x, x, x * x, 3 * x});
        }
        lf_film_merge(film, index, row, half_of(v), &sums, v % 2 ? 1.0 : 0.5,
                      lf_hash64(lf_hash64(stream, 99), (uint64_t)v));
    }
    lf_film_sums_finish(&sums);
}

static lf_film film_of(uint32_t stream, bool exact)
{
    lf_film film = {0};
    lf_assert_ok(lf_film_init(&film, &whole), NULL);
    for (int row = 0; row < HEIGHT; row++)
        accumulate(&film, stream, row, exact);
    return film;
}

static void assert_same_films(const lf_film *a, const lf_film *b)
{
    assert_int_equal(a->n_streams, b->n_streams);
    for (int i = 0; i < a->n_streams; i++) {
        assert_int_equal(a->streams[i].number, b->streams[i].number);
        assert_memory_equal(a->streams[i].rows, b->streams[i].rows,
                            HEIGHT * sizeof *a->streams[i].rows);
    }
    for (int row = 0; row < HEIGHT; row++) {
        assert_memory_equal(a->rows[row].n, b->rows[row].n, sizeof a->rows[row].n);
        assert_memory_equal(a->rows[row].visits, b->rows[row].visits, sizeof a->rows[row].visits);
        assert_true(a->rows[row].passes == b->rows[row].passes);
        assert_memory_equal(a->data + (size_t)row * a->row_bytes,
                            b->data + (size_t)row * b->row_bytes, lf_film_used_bytes(&whole));
    }
}

static void sums_that_floats_can_hold_are_those_of_one_film(void **state)
{
    (void)state;
    lf_film together = {0}, sum = film_of(0, true), other = film_of(1, true);
    lf_assert_ok(lf_film_init(&together, &whole), NULL);
    for (int row = 0; row < HEIGHT; row++)
        for (uint32_t stream = 0; stream < 2; stream++)
            accumulate(&together, stream, row, true);
    lf_assert_ok(added_film(&sum, &other, NULL), NULL);
    assert_same_films(&sum, &together);
    lf_film_finish(&together);
    lf_film_finish(&other);
    lf_film_finish(&sum);
}

/* Against the plain means of all visits: N, W, q and known light with its difference. */
static void means_and_differences_are_those_of_all_visits(void **state)
{
    (void)state;
    lf_film a = film_of(0, false), b = film_of(1, false);
    double wrong = 0, squares = 0;
    lf_assert_ok(added_film(&a, &b, NULL), NULL);
    for (int i = 0; i < WIDTH; i++) {
        double n[2] = {0}, sum[2] = {0}, mean[2] = {0}, near[2] = {0}, square[2] = {0};
        for (int k = 0; k < 2 * VISITS; k++) {
            int v = k % VISITS;
            double x = (double)value((uint32_t)(k / VISITS), v, i, false), w = v % 2 ? 1.0 : 0.5;
            n[half_of(v)] += w;
            sum[half_of(v)] += x;
            mean[half_of(v)] += w * x;
            near[half_of(v)] += w * x * 4 * x;
            square[half_of(v)] += w * x * 17 * x * x;
        }
        const lf_film_known *known = &lf_film_known_at(&a, 1)[i];
        float difference[3];
        lf_difference_unpack(known->difference, difference);
        for (int h = 0; h < 2; h++) {
            lf_film_half half = lf_film_at(&a, 1, h);
            lf_assert_close((double)half.scattered[i].w, sum[h], 1e-6, 0);
            lf_assert_close((double)half.scattered[i].n[2], 3 * sum[h], 1e-6, 0);
            lf_assert_close((double)half.w2[i], sum[h], 1e-6, 0);
            lf_assert_close((double)half.q[i], mean[h] / n[h], 1e-6, 0);
            const lf_feature f = lf_feature_unpack(half.feature[i]);
            double y = near[h] / mean[h];
            lf_assert_close((double)f.nearness, y, 0, 1e-3);
            lf_assert_close((double)f.spread, sqrt(square[h] / mean[h] - y * y), 0, 1e-3);
        }
        double truth = mean[0] / n[0] - mean[1] / n[1];
        lf_assert_close((double)known->b[1], (mean[0] + mean[1]) / (n[0] + n[1]), 1e-6, 0);
        wrong += ((double)difference[1] - truth) * ((double)difference[1] - truth);
        squares += truth * truth;
    }
    print_message("difference: %.2g of its mean square is rounding\n", wrong / squares);
    assert_true(wrong / squares < 1e-5 * 2 * VISITS);
    lf_film_finish(&a);
    lf_film_finish(&b);
}

/* One film holds 1, the other an eighth of the step between floats there. */
static void rounding_has_no_bias(void **state)
{
    (void)state;
    lf_film a = film_of(0, false), b = film_of(1, false);
    int up = 0;
    for (int i = 0; i < WIDTH; i++) {
        lf_film_at(&a, 0, 0).scattered[i].w = 1.0f;
        lf_film_at(&b, 0, 0).scattered[i].w = 0x1p-26f;
    }
    lf_assert_ok(added_film(&a, &b, NULL), NULL);
    for (int i = 0; i < WIDTH; i++) {
        float w = lf_film_at(&a, 0, 0).scattered[i].w;
        assert_true(w == 1.0f || w == 1.0f + 0x1p-23f);
        up += w > 1.0f;
    }
    double expected = WIDTH / 8.0, deviation = sqrt(WIDTH * 7.0 / 64);
    print_message("%d of %d rounded up, %.0f expected\n", up, WIDTH, expected);
    assert_true(fabs(up - expected) < 4 * deviation);
    lf_film_finish(&a);
    lf_film_finish(&b);
}

static void the_same_samples_and_other_pictures_are_refused(void **state)
{
    (void)state;
    lf_film a = film_of(0, true), before = film_of(0, true), b = film_of(1, true);
    lf_error err;
    lf_assert_status(added_film(&a, &before, &err), LF_E_STATE, &err);
    assert_non_null(strstr(err.what, "seed 17, stream 0 in row 0"));
    assert_same_films(&a, &before);
    b.picture[31] = 1;
    lf_assert_status(added_film(&a, &b, &err), LF_E_STATE, &err);
    assert_same_films(&a, &before);
    lf_film_finish(&a);
    lf_film_finish(&before);
    lf_film_finish(&b);
}

static void other_pictures_of_the_same_views_are_mixed(void **state)
{
    (void)state;
    lf_film a = film_of(0, true), sum = film_of(0, true), b = film_of(1, true);
    lf_error err;
    lf_assert_ok(added_film(&sum, &b, NULL), NULL);
    b.picture[31] = 1;
    lf_assert_ok(lf_film_mix(&a, &b, NULL), NULL);
    assert_same_films(&a, &sum);
    b.sky[1] = 0x1p-24f;
    lf_assert_status(lf_film_mix(&a, &b, &err), LF_E_STATE, &err);
    b.sky[1] = a.sky[1];
    b.layout.has_w2 = !b.layout.has_w2;
    lf_assert_status(lf_film_mix(&a, &b, &err), LF_E_STATE, &err);
    assert_non_null(strstr(err.what, "other views or another layout"));
    assert_same_films(&a, &sum);
    lf_film_finish(&a);
    lf_film_finish(&sum);
    lf_film_finish(&b);
}

/* As if row 1 had been visited so often by the film's only stream. */
static void pretend(lf_film *film, uint32_t visits, double n, double passes)
{
    film->rows[1].visits[0] = film->streams[0].rows[1].visits[0] = visits;
    film->rows[1].n[0] = film->streams[0].rows[1].n[0] = n;
    film->rows[1].passes = passes;
}

static void counts_that_have_no_sum_are_refused(void **state)
{
    (void)state;
    static const struct {
        uint32_t visits[2];
        double n, passes; /* of each */
        lf_status status;
    } cases[] = {{{UINT32_C(1) << 31, UINT32_C(1) << 31}, 1, 2, LF_E_STATE},
                 {{LF_FILM_MAX_VISITS, 1}, 1, 2, LF_E_STATE},
                 {{LF_FILM_MAX_VISITS - 1, 1}, 1, 2, LF_OK},
                 {{1, 1}, 5e11, 2, LF_E_STATE},
                 {{1, 1}, 4.9e11, 2, LF_OK},
                 {{1, 1}, 1, 5e14, LF_E_STATE},
                 {{1, 1}, 1, 4.9e14, LF_OK}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_film a = film_of(0, true), before = film_of(0, true), b = film_of(1, true);
        lf_error err;
        pretend(&a, cases[i].visits[0], cases[i].n, cases[i].passes);
        pretend(&before, cases[i].visits[0], cases[i].n, cases[i].passes);
        pretend(&b, cases[i].visits[1], cases[i].n, cases[i].passes);
        lf_assert_status(added_film(&a, &b, &err), cases[i].status, &err);
        if (cases[i].status == LF_OK) {
            assert_int_equal(a.rows[1].visits[0], cases[i].visits[0] + cases[i].visits[1]);
        } else {
            assert_non_null(strstr(err.what, "row 1"));
            assert_same_films(&a, &before);
        }
        lf_film_finish(&a);
        lf_film_finish(&before);
        lf_film_finish(&b);
    }
}

static const lf_film_layout dot = {.n_views = 1, .width = 1, .height = 1};

/* A film with a visit of each of these streams: first, first + step, … */
static lf_film film_of_streams(uint32_t first, uint32_t step, int n)
{
    lf_film film = {0};
    int index;
    lf_assert_ok(lf_film_init(&film, &dot), NULL);
    for (int i = 0; i < n; i++) {
        lf_assert_ok(lf_film_stream_at(&film, 5, first + step * (uint32_t)i, &index), NULL);
        lf_film_count(&film, index, 0, i % 2, 1);
    }
    return film;
}

static void streams_ascend_in_whatever_order_they_come(void **state)
{
    (void)state;
    enum { N = 257 };
    lf_film film = {0};
    int index;
    lf_assert_ok(lf_film_init(&film, &dot), NULL);
    /* N is a prime: every number comes once. */
    for (uint32_t i = 0; i < N; i++) {
        uint32_t number = 100 * i % N;
        assert_null(lf_film_find_stream(&film, number % 3, number));
        lf_assert_ok(lf_film_stream_at(&film, number % 3, number, &index), NULL);
        film.streams[index].rows[0].n[0] = number;
    }
    assert_int_equal(film.n_streams, N);
    for (uint32_t number = 0; number < N; number++) {
        const lf_film_stream *s = lf_film_find_stream(&film, number % 3, number);
        assert_non_null(s);
        assert_true(s->seed == number % 3 && s->number == number && s->rows[0].n[0] == number);
        lf_assert_ok(lf_film_stream_at(&film, number % 3, number, &index), NULL);
        assert_ptr_equal(&film.streams[index], s);
        assert_null(lf_film_find_stream(&film, number % 3 + 1, number));
    }
    for (int i = 1; i < N; i++) {
        const lf_film_stream *a = &film.streams[i - 1], *b = &film.streams[i];
        assert_true(a->seed < b->seed || (a->seed == b->seed && a->number < b->number));
    }
    lf_film_finish(&film);
}

static void more_streams_than_a_film_has_are_refused(void **state)
{
    (void)state;
    enum { MOST = LF_FILM_MAX_STREAMS };
    lf_film even = film_of_streams(0, 2, MOST / 2), odd = film_of_streams(1, 2, MOST / 2 + 1),
            same = film_of_streams(0, 2, MOST / 2), fits = film_of_streams(1, 2, MOST / 2);
    lf_error err;
    int index;
    lf_assert_status(added_film(&even, &odd, &err), LF_E_STATE, &err);
    assert_non_null(strstr(err.what, "more than 65536 random streams"));
    assert_int_equal(even.n_streams, MOST / 2);
    assert_memory_equal(even.rows[0].visits, same.rows[0].visits, sizeof even.rows[0].visits);
    lf_assert_ok(added_film(&even, &fits, &err), &err);
    assert_int_equal(even.n_streams, MOST);
    assert_int_equal(lf_film_stream_at(&even, 5, MOST, &index), LF_E_STATE);
    assert_int_equal(lf_film_stream_at(&even, 5, MOST - 1, &index), LF_OK);
    assert_int_equal(index, MOST - 1);
    lf_film_finish(&even);
    lf_film_finish(&odd);
    lf_film_finish(&same);
    lf_film_finish(&fits);
}

static void rows_of_one_film_alone_are_taken_as_they_are(void **state)
{
    (void)state;
    lf_film all = film_of(2, false), a = {0}, b = {0};
    lf_assert_ok(lf_film_init(&a, &whole), NULL);
    lf_assert_ok(lf_film_init(&b, &whole), NULL);
    accumulate(&a, 2, 1, false);
    accumulate(&b, 2, 0, false);
    accumulate(&b, 2, 2, false);
    lf_assert_ok(added_film(&a, &b, NULL), NULL);
    assert_same_films(&a, &all);
    lf_film_finish(&a);
    lf_film_finish(&b);
    lf_film_finish(&all);
}

/* The mark of a hole is no weight: it neither adds up, nor divides light that another film has. */
static void marks_of_holes_stay_marks(void **state)
{
    (void)state;
#define MARK LF_FILM_SETTLED
    static const struct {
        float from[2][2][2], to[2][2]; /* N and W of the halves: of both films, and of the sum */
    } cases[] = {{{{{0, MARK}, {0, 0}}, {{0, MARK}, {0, 0}}}, {{0, MARK}, {0, 0}}},
                 {{{{0, 0}, {0, MARK}}, {{0, MARK}, {0, 0}}}, {{0, MARK}, {0, 0}}},
                 {{{{0, 0}, {0, MARK}}, {{0.25f, 0}, {0.5f, 0}}}, {{0, 0}, {0, MARK}}},
                 {{{{0, MARK}, {0, 0}}, {{0.25f, 0}, {0.5f, 0.25f}}}, {{0.25f, 0}, {0.5f, 0.25f}}},
                 {{{{0.5f, 0.25f}, {0, 0}}, {{0, MARK}, {0, 0}}}, {{0.5f, 0.25f}, {0, 0}}},
                 {{{{0.25f, 0}, {0, 0}}, {{0.25f, 0}, {0.5f, 0}}}, {{0.5f, 0}, {0.5f, 0}}}};
    enum { CASES = sizeof cases / sizeof cases[0] };
    lf_film films[2] = {film_of(0, true), film_of(1, true)};
    for (int i = 0; i < 4 * CASES; i++) {
        const float *of = cases[i / 4].from[i / 2 % 2][i % 2];
        lf_film_at(&films[i / 2 % 2], 1, i % 2).scattered[i / 4] =
            (lf_film_scattered){.n = {of[0]}, .w = of[1]};
    }
    lf_assert_ok(added_film(&films[0], &films[1], NULL), NULL);
    for (int i = 0; i < 2 * CASES; i++) {
        const lf_film_scattered *sum = &lf_film_at(&films[0], 1, i % 2).scattered[i / 2];
        const float *to = cases[i / 2].to[i % 2];
        if (sum->n[0] != to[0] || sum->w != to[1])
            fail_msg("case %d, half %d: N %g, W %g", i / 2, i % 2, (double)sum->n[0],
                     (double)sum->w);
    }
    lf_film_finish(&films[0]);
    lf_film_finish(&films[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_that_floats_can_hold_are_those_of_one_film),
        cmocka_unit_test(means_and_differences_are_those_of_all_visits),
        cmocka_unit_test(rounding_has_no_bias),
        cmocka_unit_test(the_same_samples_and_other_pictures_are_refused),
        cmocka_unit_test(other_pictures_of_the_same_views_are_mixed),
        cmocka_unit_test(counts_that_have_no_sum_are_refused),
        cmocka_unit_test(streams_ascend_in_whatever_order_they_come),
        cmocka_unit_test(more_streams_than_a_film_has_are_refused),
        cmocka_unit_test(rows_of_one_film_alone_are_taken_as_they_are),
        cmocka_unit_test(marks_of_holes_stay_marks),
    };
    return cmocka_run_group_tests_name("film_mix", tests, NULL, NULL);
}
