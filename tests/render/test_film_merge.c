/* Films of many files that become one. The oracles are one film that has everything, plain sums in
 * long double, and lf_film_mix. */
#include "tests/render/merged.h"

#include <float.h>
#include <math.h>

#include "render/film/film_difference.h"

/* ------------------------------------------------------------------------------------- bands -- */

static void bands_are_the_bytes_of_one_film(void **state)
{
    static const int parts[][3][3] = {{{0, 2, 1}, {2, 5, 1}, {5, 6, 1}},
                                      {{0, 6, 2}, {1, 6, 2}, {6, 6, 1}},
                                      {{0, 6, 3}, {1, 6, 3}, {2, 6, 3}}};
    static const int orders[][3] = {{0, 1, 2}, {2, 1, 0}, {1, 2, 0}};
    for (int flags = 0; flags < 128; flags += 5) {
        const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, flags);
        lf_film whole = films_empty(&layout);
        films_visit(&whole, 5, 1, 0, HEIGHT, 1, 4, false);
        films_write(&whole, lf_test_path(*state, "whole"));
        lf_film_finish(&whole);
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++)
                write_one(*state, i, &layout, 5, 1, parts[k][i][0], parts[k][i][1], parts[k][i][2],
                          4);
            for (int o = 0; o < 3; o++) {
                assert_merged(*state, orders[o], 3);
                films_assert_same(lf_test_path(*state, "out"), lf_test_path(*state, "whole"));
            }
        }
    }
}

static void what_files_hold_and_lack_is_told(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 2);
    lf_merging *m = NULL;
    lf_merging_total total;
    lf_merging_file found;
    int first, last;
    write_one(*state, 0, &layout, 9, 3, 4, 5, 1, 2);
    write_one(*state, 1, &layout, 9, 3, 1, 2, 1, 4);
    lf_assert_ok(lf_merging_create(&m, NULL), NULL);
    for (int i = 0; i < 2; i++) {
        int fd = open(nth(*state, i), O_RDONLY | O_CLOEXEC);
        lf_assert_ok(lf_merging_add(m, fd, nth(*state, i), 0, &found, NULL), NULL);
        close(fd);
    }
    assert_int_equal(found.n_views, VIEWS);
    assert_int_equal(found.width, WIDTH);
    assert_int_equal(found.height, HEIGHT);
    assert_int_equal(found.first_row, 1);
    assert_int_equal(found.last_row, 1);
    assert_int_equal(found.n_rows, 1);
    assert_true(found.least_passes == 4 * VIEWS && found.most_passes == 4 * VIEWS);
    assert_true(found.seed == 9 && found.stream == 3 && found.n_streams == 1);
    lf_assert_ok(lf_merging_arrange(m, &total, NULL), NULL);
    assert_true(total.n_files == 2 && total.n_rows == 2 && total.n_streams == 1);
    assert_true(total.first_row == 1 && total.last_row == 4);
    assert_true(total.least_row == 4 && total.least_passes == 2 * VIEWS);
    assert_true(total.most_row == 1 && total.most_passes == 4 * VIEWS);
    assert_true(lf_merging_at(m, 0) == 1 && lf_merging_at(m, 1) == 0);
    assert_int_equal(lf_merging_holder(m, 4), 0);
    assert_int_equal(lf_merging_holder(m, 1), 1);
    assert_int_equal(lf_merging_holder(m, 2), -1);
    assert_true(lf_merging_gap(m, 0, &first, &last) && first == 0 && last == 0);
    assert_true(lf_merging_gap(m, 1, &first, &last) && first == 2 && last == 3);
    assert_true(lf_merging_gap(m, 4, &first, &last) && first == 5 && last == 5);
    assert_false(lf_merging_gap(m, 6, &first, &last));
    lf_merging_destroy(m);
}

/* Visits of that many passes each to some rows, in that order of halves. */
static void visit_by(lf_film *film, int from, int end, int visits, int passes)
{
    lf_film_sums sums;
    int index;
    lf_assert_ok(lf_film_sums_init(&sums, &film->layout), NULL);
    lf_assert_ok(lf_film_stream_at(film, 5, 1, &index), NULL);
    for (int row = from; row < end; row++)
        for (int v = 0; v < visits; v++) {
            films_fill(&sums, &film->layout, (uint64_t)v);
            lf_film_merge(film, index, row, v % 2, &sums, passes, (uint64_t)v);
        }
    lf_film_sums_finish(&sums);
}

/* As of releases that divide passes into visits differently. */
static void rows_of_a_stream_in_other_visits_are_refused(void **state)
{
    static const struct {
        int visits, passes;
        bool fits;
    } lower[] = {{4, 6, true}, {2, 12, false}, {8, 3, false}, {8, 6, true}, {6, 4, false}};
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 35);
    for (size_t i = 0; i < sizeof lower / sizeof lower[0]; i++) {
        lf_film upper = films_empty(&layout), low = films_empty(&layout);
        visit_by(&upper, 0, 2, 4, 6);
        visit_by(&low, 2, HEIGHT, lower[i].visits, lower[i].passes);
        films_write(&upper, nth(*state, 0));
        films_write(&low, nth(*state, 1));
        if (lower[i].fits)
            assert_merged(*state, NULL, 2);
        else
            assert_refused(*state, 2, LF_E_STATE, "one is of another job; make both again");
        lf_film_finish(&upper);
        lf_film_finish(&low);
    }
}

/* Rows of other passes above them hide nothing. */
static void visits_are_compared_where_parts_meet(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 35);
    static const int visits[3][2] = {{2, 3}, {4, 6}, {2, 12}};
    for (int i = 0; i < 3; i++) {
        lf_film film = films_empty(&layout);
        visit_by(&film, 2 * i, 2 * i + 2, visits[i][0], visits[i][1]);
        films_write(&film, nth(*state, i));
        lf_film_finish(&film);
    }
    assert_refused(*state, 3, LF_E_STATE, "has row 4 in 2 visits, but ");
}

/* ----------------------------------------------------------------------------------- streams -- */

enum { STREAMS = 5 };

/* Films of different streams with different counts, whose first visits may be coarse; the last one
 * has the middle rows only. */
static void make_streams(lf_film films[STREAMS], const lf_film_layout *layout, bool coarse)
{
    for (int k = 0; k < STREAMS; k++) {
        const bool last = k == STREAMS - 1;
        films[k] = films_empty(layout);
        films_visit(&films[k], k < 3 ? 11 : 4, (uint32_t)k, last ? 2 : 0, last ? 4 : HEIGHT, 1,
                    2 + k, coarse && k != 1);
    }
}

static void finish_films(lf_film films[STREAMS])
{
    for (int k = 0; k < STREAMS; k++)
        lf_film_finish(&films[k]);
}

/* Whether x is the float below or above `exact`. */
static void assert_rounded(float x, long double exact)
{
    const float to = (float)exact;
    if (!(x == to || x == nextafterf(to, -INFINITY) || x == nextafterf(to, INFINITY)) ||
        fabsl((long double)x - exact) > (long double)FLT_EPSILON * fabsl(exact) + 1e-30L)
        fail_msg("%.9g for %.12Lg", (double)x, exact);
}

typedef struct expected {
    long double n[3], w, w2, q, pivots;
    long double weight, nearness, square, surface, light;
} expected;

/* Plain sums over the films of one pixel of a half. */
static expected expect_half(const lf_film films[STREAMS], int row, int half, size_t i)
{
    expected e = {0};
    long double count = 0.0L;
    for (int k = 0; k < STREAMS; k++) {
        if (!lf_film_visited(films[k].rows[row].visits))
            continue;
        const lf_film_half of = lf_film_at(&films[k], row, half);
        const long double n =
            (long double)(films[k].rows[row].n[half] - films[k].rows[row].coarse[half]);
        for (int c = 0; c < 3; c++)
            e.n[c] += (long double)of.scattered[i].n[c];
        e.w += (long double)of.scattered[i].w;
        e.w2 += of.w2 ? (long double)of.w2[i] : 0.0L;
        e.q += n * (long double)of.q[i];
        count += n;
        const long double weight = fmaxl(n * (long double)of.q[i], 0.0L);
        if (!of.feature || weight == 0.0L)
            continue;
        const lf_feature f = lf_feature_unpack(of.feature[i]);
        e.weight += weight;
        e.nearness += weight * (long double)f.nearness;
        e.square += weight * ((long double)f.nearness * (long double)f.nearness +
                              (long double)f.spread * (long double)f.spread);
        e.surface += weight * (long double)f.surface;
        e.light += weight * (long double)f.light;
    }
    e.pivots = e.q;
    e.q = count > 0.0L ? e.q / count : 0.0L;
    return e;
}

static void check_features(const expected *e, lf_packed_feature packed)
{
    const lf_feature f = lf_feature_unpack(packed);
    if (e->weight == 0.0L)
        return;
    const double nearness = (double)(e->nearness / e->weight),
                 variance = (double)(e->square / e->weight) - nearness * nearness;
    lf_assert_close((double)f.nearness, nearness, 0, 2.0 * 8 / 65535);
    lf_assert_close((double)f.spread, sqrt(fmax(variance, 0)), 0, 4.0 * 8 / 65535);
    lf_assert_close((double)f.surface, (double)(e->surface / e->weight), 0, 2.0 / 65535);
    lf_assert_close((double)f.light, (double)(e->light / e->weight), 0.01, 1e-6);
}

static void check_half(const lf_film films[STREAMS], const lf_film *sum, int row, int half)
{
    const lf_film_half of = lf_film_at(sum, row, half);
    for (size_t i = 0; i < (size_t)VIEWS * WIDTH; i++) {
        const expected e = expect_half(films, row, half, i);
        for (int c = 0; c < 3; c++)
            assert_rounded(of.scattered[i].n[c], e.n[c]);
        assert_rounded(of.scattered[i].w, e.w);
        if (of.w2)
            assert_rounded(of.w2[i], e.w2);
        assert_rounded(of.q[i], e.q);
        if (of.feature)
            check_features(&e, of.feature[i]);
    }
}

/* Known light: the mean of both halves, and their difference as far as its bits tell. */
static void check_known(const lf_film films[STREAMS], const lf_film *sum, int row)
{
    const lf_film_known *known = lf_film_known_at(sum, row);
    for (size_t i = 0; known && i < (size_t)VIEWS * WIDTH; i++) {
        float got[3];
        lf_difference_unpack(known[i].difference, got);
        for (int c = 0; c < 3; c++) {
            long double both = 0.0L, count = 0.0L, half[2] = {0.0L}, n_half[2] = {0.0L};
            for (int k = 0; k < STREAMS; k++) {
                if (!lf_film_visited(films[k].rows[row].visits))
                    continue;
                const lf_film_known *of = &lf_film_known_at(&films[k], row)[i];
                float d[3];
                lf_difference_unpack(of->difference, d);
                const double *n = films[k].rows[row].n, *coarse = films[k].rows[row].coarse;
                const long double a = (long double)(n[0] - coarse[0]),
                                  b = (long double)(n[1] - coarse[1]), x = (long double)of->b[c];
                both += (a + b) * x;
                count += a + b;
                n_half[0] += a;
                n_half[1] += b;
                half[0] += a > 0.0L ? a * (x + b / (a + b) * (long double)d[c]) : 0.0L;
                half[1] += b > 0.0L ? b * (x - a / (a + b) * (long double)d[c]) : 0.0L;
            }
            assert_rounded(known[i].b[c], both / count);
            lf_assert_close((double)got[c], (double)(half[0] / n_half[0] - half[1] / n_half[1]), 0,
                            0.03);
        }
    }
}

static void check_albedo(const lf_film films[STREAMS], const lf_film *sum, int row)
{
    const lf_packed_albedo *albedo = lf_film_albedo_at(sum, row);
    for (size_t i = 0; albedo && i < (size_t)VIEWS * WIDTH; i++) {
        double of[LF_ALBEDO_NUMBERS] = {0}, weights = 0;
        float got[LF_ALBEDO_NUMBERS], a[LF_ALBEDO_NUMBERS];
        for (int k = 0; k < STREAMS; k++) {
            const lf_film_row *counts = &films[k].rows[row];
            const lf_packed_albedo packed =
                lf_film_visited(counts->visits) ? lf_film_albedo_at(&films[k], row)[i] : 0;
            double weight = 0;
            for (int h = 0; h < 2 && packed; h++)
                weight +=
                    (counts->n[h] - counts->coarse[h]) * (double)lf_film_at(&films[k], row, h).q[i];
            lf_albedo_unpack(packed, a);
            for (int c = 0; c < LF_ALBEDO_NUMBERS && weight > 0; c++)
                of[c] += weight * (double)a[c];
            weights += weight > 0 ? weight : 0;
        }
        lf_albedo_unpack(albedo[i], got);
        for (int c = 0; c < LF_ALBEDO_NUMBERS && weights > 0; c++)
            lf_assert_close((double)got[c], of[c] / weights, 0, c == LF_ALBEDO_METAL ? 0.04 : 0.01);
    }
}

static void check_counts(const lf_film films[STREAMS], const lf_film *sum)
{
    for (int row = 0; row < HEIGHT; row++) {
        double n[2] = {0}, coarse[2] = {0}, passes = 0;
        uint32_t visits[2] = {0};
        for (int k = 0; k < STREAMS; k++) {
            const lf_film_row *of = &films[k].rows[row];
            for (int h = 0; h < 2; h++) {
                n[h] += of->n[h];
                coarse[h] += of->coarse[h];
                visits[h] += of->visits[h];
            }
            passes += of->passes;
            const lf_film_stream *own = &films[k].streams[0],
                                 *there = lf_film_find_stream(sum, own->seed, own->number);
            assert_non_null(there);
            assert_memory_equal(&there->rows[row], &own->rows[row], sizeof own->rows[row]);
        }
        assert_memory_equal(sum->rows[row].n, n, sizeof n);
        assert_memory_equal(sum->rows[row].coarse, coarse, sizeof coarse);
        assert_memory_equal(sum->rows[row].visits, visits, sizeof visits);
        assert_true(sum->rows[row].passes == passes);
    }
}

static void streams_are_the_plain_sums_rounded_once(void **state)
{
    for (int flags = 0; flags < 128; flags += 3) {
        const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, flags);
        lf_film films[STREAMS];
        make_streams(films, &layout, flags % 2);
        for (int k = 0; k < STREAMS; k++)
            films_write(&films[k], nth(*state, k));
        assert_merged(*state, NULL, STREAMS);
        lf_film sum = merged(*state);
        assert_int_equal(sum.n_streams, STREAMS);
        check_counts(films, &sum);
        for (int row = 0; row < HEIGHT; row++) {
            check_half(films, &sum, row, 0);
            check_half(films, &sum, row, 1);
            check_known(films, &sum, row);
            check_albedo(films, &sum, row);
        }
        lf_film_finish(&sum);
        finish_films(films);
    }
}

static void two_films_are_what_lf_film_mix_makes_of_them(void **state)
{
    for (int flags = 0; flags < 128; flags++) {
        const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, flags);
        lf_film films[STREAMS];
        make_streams(films, &layout, flags % 3 == 1);
        films_write(&films[0], nth(*state, 0));
        films_write(&films[4], nth(*state, 1));
        assert_merged(*state, NULL, 2);
        lf_film sum = merged(*state);
        lf_assert_ok(lf_film_mix(&films[0], &films[4], NULL), NULL);
        for (int row = 0; row < HEIGHT; row++) {
            for (int h = 0; h < 2; h++) {
                const lf_film_half a = lf_film_at(&sum, row, h), b = lf_film_at(&films[0], row, h);
                const size_t n = (size_t)VIEWS * WIDTH;
                assert_memory_equal(a.scattered, b.scattered, n * sizeof *a.scattered);
                assert_memory_equal(a.q, b.q, n * sizeof *a.q);
                if (a.w2)
                    assert_memory_equal(a.w2, b.w2, n * sizeof *a.w2);
            }
            const lf_film_known *a = lf_film_known_at(&sum, row),
                                *b = lf_film_known_at(&films[0], row);
            for (size_t i = 0; a && i < (size_t)VIEWS * WIDTH; i++)
                assert_memory_equal(a[i].b, b[i].b, sizeof a[i].b);
        }
        lf_film_finish(&sum);
        finish_films(films);
    }
}

/* Of streams whose visits of half 0 are all coarse: it has the means of half 1, as in one film. */
static void a_half_that_knows_nothing_borrows(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 34);
    const size_t n = (size_t)VIEWS * WIDTH;
    for (int i = 0; i < 2; i++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 8, (uint32_t)i, 0, HEIGHT, 1, 2, true);
        films_write(&film, nth(*state, i));
        lf_film_finish(&film);
    }
    assert_merged(*state, NULL, 2);
    lf_film sum = merged(*state);
    for (int row = 0; row < HEIGHT; row++) {
        const lf_film_half to = lf_film_at(&sum, row, 0), from = lf_film_at(&sum, row, 1);
        assert_true(sum.rows[row].coarse[0] == sum.rows[row].n[0] && sum.rows[row].n[0] == 2.0);
        assert_true(from.q[0] > 0.0f || from.q[1] > 0.0f);
        assert_memory_equal(to.q, from.q, n * sizeof *to.q);
        assert_memory_equal(to.feature, from.feature, n * sizeof *to.feature);
    }
    lf_film_finish(&sum);
}

static void any_order_gives_the_same_bytes(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 111);
    lf_film films[STREAMS];
    int order[STREAMS] = {0, 1, 2, 3, 4};
    make_streams(films, &layout, true);
    for (int k = 0; k < STREAMS; k++)
        films_write(&films[k], nth(*state, k));
    finish_films(films);
    assert_merged(*state, order, STREAMS);
    assert_int_equal(rename(lf_test_path(*state, "out"), lf_test_path(*state, "first")), 0);
    for (int i = 0; i < 40; i++) {
        const int a = i % STREAMS, b = (i * 7 + 3) % STREAMS, kept = order[a];
        order[a] = order[b];
        order[b] = kept;
        assert_merged(*state, order, STREAMS);
        films_assert_same(lf_test_path(*state, "out"), lf_test_path(*state, "first"));
    }
}

/* Sums that lie between two floats are rounded up as often as their distances say. */
static void rounding_has_no_bias(void **state)
{
    const lf_film_layout layout = {.n_views = 1, .width = 4096, .height = 2};
    for (int k = 0; k < 3; k++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 1, (uint32_t)k, 0, 2, 1, 2, false);
        for (int row = 0; row < 2; row++)
            for (size_t i = 0; i < 4096; i++)
                lf_film_at(&film, row, 0).scattered[i].w = k == 0 ? 1.0f : 0x1p-26f;
        films_write(&film, nth(*state, k));
        lf_film_finish(&film);
    }
    assert_merged(*state, NULL, 3);
    lf_film sum = merged(*state);
    int up = 0;
    for (int row = 0; row < 2; row++) {
        for (size_t i = 0; i < 4096; i++) {
            const float w = lf_film_at(&sum, row, 0).scattered[i].w;
            assert_true(w == 1.0f || w == 1.0f + 0x1p-23f);
            up += w > 1.0f;
        }
    }
    /* a quarter of 8192, with five standard deviations; twice rounded up by 1/8 it would be less */
    print_message("rounded up %d times of 8192\n", up);
    assert_true(abs(up - 2048) < 200);
    lf_film_finish(&sum);
}

static void constants_stay_exact(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 34);
    for (int k = 0; k < 3; k++) {
        lf_film film = films_empty(&layout);
        films_visit(&film, 1, (uint32_t)k, 0, HEIGHT, 1, 3 + 2 * k, false);
        for (int row = 0; row < HEIGHT; row++) {
            for (size_t i = 0; i < (size_t)VIEWS * WIDTH; i++) {
                lf_film_at(&film, row, 0).q[i] = lf_film_at(&film, row, 1).q[i] = 0.7f;
                lf_film_known_at(&film, row)[i] = (lf_film_known){{0.1f, 0.2f, 0.3f}, 0};
            }
        }
        films_write(&film, nth(*state, k));
        lf_film_finish(&film);
    }
    assert_merged(*state, NULL, 3);
    lf_film sum = merged(*state);
    for (size_t i = 0; i < (size_t)VIEWS * WIDTH; i++) {
        const lf_film_known *known = &lf_film_known_at(&sum, 1)[i];
        assert_true(lf_film_at(&sum, 1, 0).q[i] == 0.7f);
        assert_true(known->b[0] == 0.1f && known->b[1] == 0.2f && known->b[2] == 0.3f);
        assert_int_equal(known->difference, 0);
    }
    lf_film_finish(&sum);
}

/* In a sum, coarse visits know nothing where others do; where all are coarse, they do. */
static void coarse_visits_know_nothing_beside_others(void **state)
{
    const lf_film_layout layout = films_layout(VIEWS, WIDTH, HEIGHT, 34);
    for (int coarse = 0; coarse < 3; coarse++) {
        for (int k = 0; k < 2; k++) {
            lf_film film = films_empty(&layout);
            films_visit(&film, 1, (uint32_t)k, 0, HEIGHT, 1, 1, k < coarse);
            for (size_t i = 0; i < (size_t)VIEWS * WIDTH; i++)
                lf_film_at(&film, 0, 0).q[i] = (float)(1 + k);
            films_write(&film, nth(*state, k));
            lf_film_finish(&film);
        }
        assert_merged(*state, NULL, 2);
        lf_film sum = merged(*state);
        lf_assert_close((double)lf_film_at(&sum, 0, 0).q[0], coarse == 1 ? 2.0 : 1.5, 0, 0);
        assert_true(sum.rows[0].coarse[0] == coarse);
        lf_film_finish(&sum);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(bands_are_the_bytes_of_one_film),
        lf_test_in_folder(what_files_hold_and_lack_is_told),
        lf_test_in_folder(streams_are_the_plain_sums_rounded_once),
        lf_test_in_folder(rows_of_a_stream_in_other_visits_are_refused),
        lf_test_in_folder(visits_are_compared_where_parts_meet),
        lf_test_in_folder(a_half_that_knows_nothing_borrows),
        lf_test_in_folder(two_films_are_what_lf_film_mix_makes_of_them),
        lf_test_in_folder(any_order_gives_the_same_bytes),
        lf_test_in_folder(rounding_has_no_bias),
        lf_test_in_folder(constants_stay_exact),
        lf_test_in_folder(coarse_visits_know_nothing_beside_others),
    };
    return cmocka_run_group_tests_name("film_merge", tests, NULL, NULL);
}
