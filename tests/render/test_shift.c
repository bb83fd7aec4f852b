/* The six mappings of null collisions (render/papers/shift.h) as pure functions: Jacobians against
 * finite differences, inverses and the chain rule, densities against the transmittances that they
 * stand for, the film's Jacobian; and mistakes, some of them printed, that these tests reject. */
#include "tests/testing.h"

#include "render/papers/shift.h"
#include "render/scene/vec_double.h"
#include "render/transport/sampler.h"
#include "tests/stat/stat.h"

enum { n_shifts = 6, pairs = 1000, most_nulls = 20 };

/* Independent numbers, 0..1. */
typedef struct source {
    uint64_t key, next;
} source;

static double number(source *s)
{
    return ((double)(lf_hash64(s->key, s->next++) >> 12) + 0.5) * 0x1p-52;
}

static double between(source *s, double a, double b)
{
    return a + (b - a) * number(s);
}

/* One to four media in any place, overlapping or not, of a majorant depth of 1e-3 to 30. */
static lf_majorant random_ray(source *s)
{
    lf_span spans[4] = {{0, 0, 0}};
    int n = 1 + (int)between(s, 0, 4);
    double end = between(s, 2, 10), wanted = exp(between(s, log(1e-3), log(30)));
    for (int i = 0; i < n; i++) {
        spans[i].begin = between(s, -0.5, 0.8 * end);
        spans[i].end = spans[i].begin + between(s, 0.5, 0.7 * end);
        spans[i].mu = between(s, 0.2, 2);
    }
    lf_majorant m;
    lf_majorant_make(&m, n, spans, end);
    for (int i = 0; i < n; i++)
        spans[i].mu *= wanted / m.depth;
    lf_majorant_make(&m, n, spans, end);
    return m;
}

/* Anywhere on the ray's media by one of the three coordinates, so that points lie near both ends.
 */
static lf_majorant_point random_point(source *s, const lf_majorant *m)
{
    lf_majorant_point p = {0};
    double u = number(s), least = exp(-m->depth);
    bool found = number(s) < 0.5 ? lf_majorant_at_length(m, u * m->length, &p)
                                 : lf_majorant_at_depth(m, -log1p(-u * (1 - least)), &p);
    assert_true(found);
    return p;
}

static bool shifted(const lf_shift *shift, const lf_majorant *from, const lf_majorant *to, double t,
                    double mu, double *out_t, double *out_mu)
{
    lf_majorant_point p;
    double jacobian;
    if (!shift->map(from, to, (lf_majorant_point){t, mu}, &p, &jacobian))
        return false;
    *out_t = p.t;
    *out_mu = p.mu;
    return true;
}

/* dt'/dt as its definition has it; false: the points on either side lie in other sections, or what
 * they differ by is rounded away. */
static bool difference(const lf_shift *shift, const lf_majorant *from, const lf_majorant *to,
                       lf_majorant_point p, double jacobian, double *out)
{
    double h = 1e-6, t[2], mu[2], l0 = lf_majorant_length(from, p.t - h),
           l1 = lf_majorant_length(from, p.t + h);
    bool inside = lf_close(l1 - l0, 2 * h, 1e-6, 0);
    for (int i = 0; i < from->n; i++)
        inside = inside && !(fabs(from->section[i].begin - p.t) <= h);
    if (!inside || !shifted(shift, from, to, p.t - h, p.mu, &t[0], &mu[0]) ||
        !shifted(shift, from, to, p.t + h, p.mu, &t[1], &mu[1]))
        return false;
    bool gap = !lf_close(lf_majorant_length(to, t[1]) - lf_majorant_length(to, t[0]), t[1] - t[0],
                         1e-6, 1e-15);
    *out = (t[1] - t[0]) / (2 * h);
    return mu[0] == mu[1] && !gap && jacobian * h > 1e-10;
}

/* Counts of points whose Jacobian, times `factor`, is that of finite differences to 1e-4, and not;
 * *out_skipped: that have none. */
static void count_jacobians(const lf_shift *shift, double factor, int *out_good, int *out_bad,
                            int *out_skipped)
{
    source s = {lf_test_seed() + 1, 0};
    *out_good = *out_bad = *out_skipped = 0;
    for (int pair = 0; pair < pairs; pair++) {
        lf_majorant from = random_ray(&s), to = random_ray(&s);
        int m = (int)between(&s, 0, most_nulls + 1);
        for (int q = 0; q < m; q++) {
            lf_majorant_point p = random_point(&s, &from), there;
            double jacobian, truth;
            if (!shift->map(&from, &to, p, &there, &jacobian))
                continue; /* copies leave the media */
            if (!difference(shift, &from, &to, p, jacobian, &truth))
                ++*out_skipped;
            else if (lf_close(factor * jacobian, truth, 1e-4, 0))
                ++*out_good;
            else
                ++*out_bad;
        }
    }
}

static void jacobians_are_those_of_finite_differences(void **state)
{
    (void)state;
    for (int i = 0; i < n_shifts; i++) {
        int good, bad, skipped;
        count_jacobians(lf_shift_at(i), 1.0, &good, &bad, &skipped);
        print_message("%s: %d points, %d without a difference\n", lf_shift_at(i)->name, good,
                      skipped);
        assert_int_equal(bad, 0);
        assert_true(good > 4000 && skipped < good / 5);
        count_jacobians(lf_shift_at(i), 1.01, &good, &bad, &skipped);
        assert_int_equal(good, 0);
    }
    assert_null(lf_shift_at(n_shifts));
}

/* The error that rounding t', t and what they are made of makes in t. */
static double rounding(const lf_majorant *from, lf_majorant_point p, lf_majorant_point there,
                       double jacobian)
{
    return 1e-14 * (p.t + from->depth / p.mu + there.t / jacobian);
}

static void forward_then_back_is_the_identity(void **state)
{
    (void)state;
    source s = {lf_test_seed() + 2, 0};
    int tried = 0;
    for (int pair = 0; pair < pairs; pair++) {
        lf_majorant from = random_ray(&s), to = random_ray(&s);
        lf_majorant_point p = random_point(&s, &from), there, back;
        for (int i = 0; i < n_shifts; i++) {
            const lf_shift *shift = lf_shift_at(i);
            double j, j_back;
            if (!shift->map(&from, &to, p, &there, &j))
                continue;
            double error = rounding(&from, p, there, j);
            assert_true(shift->map(&to, &from, there, &back, &j_back));
            lf_assert_close(lf_majorant_length(&from, back.t), lf_majorant_length(&from, p.t), 0,
                            error);
            if (error < 1e-9 && back.mu == p.mu)
                lf_assert_close(j * j_back, 1.0, 1e-7, 0);
            tried += error < 1e-9;
        }
    }
    assert_true(tried > 4 * pairs);
}

/* S_jk S_ij = S_ik, which is why weights do not depend on the target. */
static void shifts_compose(void **state)
{
    (void)state;
    source s = {lf_test_seed() + 3, 0};
    int both = 0;
    for (int pair = 0; pair < pairs; pair++) {
        lf_majorant ray[3] = {random_ray(&s), random_ray(&s), random_ray(&s)};
        lf_majorant_point p = random_point(&s, &ray[0]), middle, end, direct;
        for (int i = 0; i < n_shifts; i++) {
            const lf_shift *shift = lf_shift_at(i);
            double j1, j2, j;
            if (!shift->map(&ray[0], &ray[1], p, &middle, &j1) ||
                rounding(&ray[0], p, middle, j1) > 1e-9)
                continue;
            bool known = shift->map(&ray[1], &ray[2], middle, &end, &j2);
            assert_int_equal(known, shift->map(&ray[0], &ray[2], p, &direct, &j));
            if (!known || end.mu != direct.mu || rounding(&ray[0], p, direct, j) > 1e-9)
                continue;
            lf_assert_close(lf_majorant_depth(&ray[2], end.t), lf_majorant_depth(&ray[2], direct.t),
                            1e-6, 1e-9);
            lf_assert_close(j1 * j2, j, 1e-6, 0);
            both++;
        }
    }
    assert_true(both > 2 * pairs);
}

/* --------------------------------------------------------------------------------- densities -- */

/* A ray whose media are a part of their majorant, in waves. */
typedef struct medium {
    lf_majorant majorant;
    double least, most, wave;
} medium;

static double extinction(void *ray, double t)
{
    const medium *m = ray;
    double wave = sin(m->wave * t), mu = 0.0;
    for (int i = 0; i < m->majorant.n; i++)
        if (t >= m->majorant.section[i].begin && t <= m->majorant.section[i].end)
            mu = m->majorant.section[i].mu;
    return mu * (m->least + (m->most - m->least) * wave * wave);
}

/* int mu, and of that what is null below a length l of traversed medium, by the midpoint rule. */
static double optical_depth(medium *m, double reached, bool null)
{
    enum { steps = 2000 };
    double sum = 0.0;
    for (int i = 0; i < m->majorant.n; i++) {
        const lf_majorant_section *s = &m->majorant.section[i];
        double end = fmin(s->end, s->begin + fmax(reached - s->length, 0.0)),
               h = (end - s->begin) / steps;
        for (int k = 0; k < steps; k++) {
            double x = extinction(m, s->begin + (k + 0.5) * h);
            sum += h * (null ? s->mu - x : x);
        }
    }
    return sum;
}

/* Null collisions between the lens and a given pivot: a Poisson process of density mu_n. */
static int draw_nulls(source *s, medium *m, lf_null *out)
{
    int n = 0;
    for (double depth = -log(number(s)); depth < m->majorant.depth; depth -= log(number(s))) {
        lf_majorant_point p;
        assert_true(n < 64 && lf_majorant_at_depth(&m->majorant, depth, &p));
        double mu_t = extinction(m, p.t);
        if (number(s) * p.mu >= mu_t)
            out[n++] = (lf_null){p, mu_t};
    }
    return n;
}

/* What equations 2, 4, 10, 16 and 22 say as printed: the null probability of the shifted point in
 * both densities. */
static double printed_ratio(double ratio, const lf_shift *shift, medium *from, medium *to, int n,
                            const lf_null *nulls)
{
    for (int q = 0; q < n && ratio > 0.0; q++) {
        lf_majorant_point p;
        double jacobian;
        assert_true(shift->map(&from->majorant, &to->majorant, nulls[q].at, &p, &jacobian));
        ratio *= (1 - nulls[q].extinction / nulls[q].at.mu) / (1 - extinction(to, p.t) / p.mu);
    }
    return ratio;
}

static lf_moments ratios(const lf_shift *shift, medium *from, medium *to, bool printed)
{
    source s = {lf_test_seed() + 4, 0};
    lf_moments moments = {0};
    for (int i = 0; i < 20000; i++) {
        lf_null nulls[64];
        int n = draw_nulls(&s, from, nulls);
        double ratio =
            lf_shift_ratio(shift, &from->majorant, &to->majorant, n, nulls, extinction, to);
        lf_moments_add(&moments, printed ? printed_ratio(ratio, shift, from, to, n, nulls) : ratio);
    }
    return moments;
}

static medium make_medium(int n, const lf_span *spans, double least, double most, double wave)
{
    medium m = {.least = least, .most = most, .wave = wave};
    lf_majorant_make(&m.majorant, n, spans, 10.0);
    return m;
}

/* Two media that overlap and one apart, seen by two rays of another length in each; every
 * coordinate of the second ends first, so that copies reach all of it. */
static void two_media(medium out[2])
{
    const lf_span near[3] = {{1, 2.5, 0.9}, {2, 4, 0.6}, {6, 7, 0.7}},
                  far[3] = {{2, 3, 0.8}, {2.5, 3.5, 0.5}, {8, 8.6, 0.5}};
    out[0] = make_medium(3, near, 0.2, 0.7, 1.3);
    out[1] = make_medium(3, far, 0.3, 0.8, 2.1);
}

/* A chain of E[ratio | pivot] = T_j/T_i, mapped there and the other way where that reaches all. */
static void mean_ratios_are_those_of_transmittances(void **state)
{
    (void)state;
    double level = lf_sidak(0.5 * LF_FALSE_ALARM, 9), worst = 1.0;
    medium m[2];
    two_media(m);
    for (int i = 0; i < n_shifts; i++) {
        const lf_shift *shift = lf_shift_at(i);
        double tau[2] = {optical_depth(&m[0], 100, false), optical_depth(&m[1], 100, false)};
        bool copies = strstr(shift->name, "copy");
        for (int way = 0; way < (copies ? 1 : 2); way++) {
            lf_moments seen = ratios(shift, &m[way], &m[1 - way], false);
            double truth = exp(tau[way] - tau[1 - way]), p = lf_p_mean(&seen, truth);
            print_message("%s: %.4f +- %.4f for %.4f\n", shift->name, seen.mean,
                          lf_moments_error(&seen), truth);
            worst = fmin(worst, p);
            assert_true(p > level);
            seen = ratios(shift, &m[way], &m[1 - way], true);
            assert_true(lf_p_mean(&seen, truth) < 1e-9); /* as printed */
        }
    }
    if (!getenv("QUILTD_SEED")) /* three standard errors */
        assert_true(worst > lf_p_normal(3.0));
}

/* Where the target goes on, a copy misses what is behind: exp(tau_bar_i - tau_bar_j + int mu_n)
 * T_i^-1 over what it reaches is left. */
static void copies_reach_what_the_base_reaches(void **state)
{
    (void)state;
    medium m[2];
    two_media(m);
    lf_moments seen = ratios(&lf_shift_raw_copy, &m[1], &m[0], false);
    double reached = optical_depth(&m[0], m[1].majorant.length, true),
           truth = exp(optical_depth(&m[1], 100, false) - m[0].majorant.depth + reached);
    assert_true(lf_p_mean(&seen, truth) > 0.5 * LF_FALSE_ALARM);
    assert_true(lf_p_mean(&seen, exp(optical_depth(&m[1], 100, false) -
                                     optical_depth(&m[0], 100, false))) < 1e-9);
}

static double nothing(void *ray, double t)
{
    (void)ray, (void)t;
    return 0.0;
}

/* Thousands of nulls in thick media: sums of logarithms, not products of densities. */
static void ratios_of_long_chains_are_finite(void **state)
{
    (void)state;
    static lf_null nulls[4000];
    const lf_span a = {0, 10, 400}, b = {0, 10, 401};
    lf_majorant from, to;
    lf_majorant_make(&from, 1, &a, 10);
    lf_majorant_make(&to, 1, &b, 10);
    for (int q = 0; q < 4000; q++)
        nulls[q] = (lf_null){{(q + 0.5) / 400, 400}, 0};
    double truth = exp(4000 * log(401.0 / 400) - 10);
    for (int i = 0; i < 2; i++)
        lf_assert_close(lf_shift_ratio(i ? &lf_shift_raw_stretch : &lf_shift_optical_stretch, &from,
                                       &to, 4000, nulls, nothing, NULL),
                        truth, 1e-9, 0);
    /* the last ones alone move: 1 - C u = e^-a (1 - e^-d + e^-(10 + d)), d = b - a */
    double primary = -10;
    for (int q = 0; q < 4000; q++)
        primary -= log1p(-exp(-q - 0.5) + exp(-q - 10.5));
    lf_assert_close(
        lf_shift_ratio(&lf_shift_primary_stretch, &from, &to, 4000, nulls, nothing, NULL),
        exp(primary), 1e-6, 0);
}

/* Nothing on either ray leaves the ratio of vacuum, 1; a point that lands on no medium leaves 0. */
static void rays_without_media(void **state)
{
    (void)state;
    const lf_span span = {1, 2, 0.5};
    const lf_null null = {{1.5, 0.5}, 0.1};
    lf_majorant empty, full;
    lf_majorant_make(&empty, 0, NULL, 3);
    lf_majorant_make(&full, 1, &span, 3);
    for (int i = 0; i < n_shifts; i++) {
        const lf_shift *shift = lf_shift_at(i);
        lf_assert_close(lf_shift_ratio(shift, &empty, &empty, 0, NULL, nothing, NULL), 1, 0, 0);
        lf_assert_close(lf_shift_ratio(shift, &full, &empty, 0, NULL, nothing, NULL), exp(0.5),
                        1e-12, 0);
        lf_assert_close(lf_shift_ratio(shift, &full, &empty, 1, &null, nothing, NULL), 0, 0, 0);
    }
}

/* -------------------------------------------------------------------------------------- film -- */

/* Where the ray from the lens to a point meets the plane z = 1 before the camera's middle. */
static void project(const double lens[3], const double p[3], double film[3])
{
    for (int i = 0; i < 3; i++)
        film[i] = lens[i] + (p[i] - lens[i]) * (1 - lens[2]) / (p[2] - lens[2]);
}

/* Area on the film of a small parallelogram at the pivot. */
static double film_area(const double lens[3], const double p[3], const double side[2][3])
{
    double at[3], d[2][3];
    project(lens, p, at);
    for (int k = 0; k < 2; k++) {
        double moved[3] = {p[0] + side[k][0], p[1] + side[k][1], p[2] + side[k][2]};
        project(lens, moved, d[k]);
        lf_sub_double(d[k], at, d[k]);
    }
    return fabs(d[0][0] * d[1][1] - d[0][1] * d[1][0]);
}

static void film_jacobians_are_those_of_finite_differences(void **state)
{
    (void)state;
    const double axis[3] = {0, 0, 1}, lens[2][3] = {{-0.8, 0.1, 0}, {0.9, -0.1, 0}},
                 pivot[3] = {0.3, -0.4, 4}, normal[3] = {0.36, 0.48, -0.8}, h = 1e-6,
                 side[2][3] = {{0.8 * h, -0.6 * h, 0}, {0.48 * h, 0.64 * h, 0.6 * h}};
    double area[2], film[2][3], per_film[2];
    for (int i = 0; i < 2; i++) {
        project(lens[i], pivot, film[i]);
        area[i] = film_area(lens[i], pivot, side);
        per_film[i] = lf_shift_area(lens[i], film[i], axis, pivot, normal);
        lf_assert_close(per_film[i] * area[i], h * h, 1e-4, 0);
    }
    lf_assert_close(per_film[0] / per_film[1], area[1] / area[0], 1e-4, 0);
    /* equation 4 as printed: from a view to itself it is no identity */
    assert_false(lf_close(1 / (per_film[0] * per_film[0]), 1, 0.1, 0));
    /* a rectified rig: what rows/ takes for h */
    for (int i = 0; i < 2; i++)
        per_film[i] = lf_shift_area(lens[i], film[i], axis, pivot, NULL);
    double d[2][3];
    for (int i = 0; i < 2; i++)
        lf_sub_double(pivot, lens[i], d[i]);
    lf_assert_close(per_film[0] / per_film[1], lf_length_double(d[1]) / lf_length_double(d[0]),
                    1e-12, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jacobians_are_those_of_finite_differences),
        cmocka_unit_test(forward_then_back_is_the_identity),
        cmocka_unit_test(shifts_compose),
        cmocka_unit_test(mean_ratios_are_those_of_transmittances),
        cmocka_unit_test(copies_reach_what_the_base_reaches),
        cmocka_unit_test(ratios_of_long_chains_are_finite),
        cmocka_unit_test(rays_without_media),
        cmocka_unit_test(film_jacobians_are_those_of_finite_differences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
