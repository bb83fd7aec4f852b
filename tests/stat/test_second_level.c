/* A prototype: suffixes shared by neighbouring pivots of a row, which are to each other what views
 * are to a pivot. Each pivot x_i has a second vertex x2_i, drawn by sigma_t phase T / r^2, and from
 * it one suffix; all of a group of M use it, weighed by the balance heuristic over the group (the
 * density that one pivot has for x2 and the direction behind it over the sum of all). World: a slab
 * of 8 mean free paths under a sun and an even sky, seen from above, where T is one exponential:
 * neither noise nor look-ups between pivots and second vertices.
 *
 * What decides whether it is built is how many suffixes of one pivot alone one that is shared
 * counts for, in the variance of a view pixel: docs/lab/performance.md, "What is left". With
 * QUILTD_LONG it prints that table. */
#include "tests/testing.h"

#include "render/transport/path/phase.h"
#include "render/transport/path/track.h"
#include "render/transport/sampler.h"
#include "tests/stat/stat.h"

enum { PASSES = 45, MAX_COLUMNS = 64, MAX_GROUP = 64 };

static const float slab = 8.0f, albedo = 0.99f, sky = 0.5f, sun = 4.0f;
static const lf_vec3 view = {0, 0, -1}, to_sun = {-0.6f, 0.3f, 0.742f};

typedef struct pivot {
    lf_vec3 x, x2, w2, w3; /* w2 leads to x2, w3 away from it */
    int column, block;
    bool inside;  /* x2 is in the slab */
    float behind; /* radiance that comes to x2 against w3 */
    float unlike; /* what is not shared: the sun at x, the sky that w2 sees */
    float alone, shared;
} pivot;

/* What is compared, for one pitch (mean free paths a column), phase function and size of group. */
typedef struct setup {
    float pitch, g;
    int columns, block, group; /* groups are of pivots of a block of columns */
    float dark; /* the share of the columns that the sun does not reach; 0: it is everywhere */
    bool wrong; /* a mistake: densities of directions, without T / r^2 */
} setup;

static lf_vec3 scattered(float g, lf_vec3 w, lf_tracer *t)
{
    const float u[2] = {lf_rng(t), lf_rng(t)};
    return lf_phase_sample(g, w, u);
}

static bool is_inside(lf_vec3 x)
{
    return x.z < 0.0f && x.z > -slab;
}

/* The sun at a point, as it scatters from w. */
static float lit(const setup *s, lf_vec3 x, lf_vec3 w)
{
    if (s->dark > 0.0f && x.x < s->dark * (float)s->columns * s->pitch)
        return 0.0f;
    const lf_vec3 from_sun = lf_scale(to_sun, 1.0f / sqrtf(lf_dot(to_sun, to_sun)));
    return albedo * sun * lf_phase_between(s->g, w, from_sun) * expf(x.z / from_sun.z);
}

/* Radiance that comes to x against w. */
static float arriving(const setup *s, lf_vec3 x, lf_vec3 w, lf_tracer *t)
{
    float beta = 1.0f, sum = 0.0f;
    for (;;) {
        x = lf_madd(x, lf_rng_exponential(t), w);
        if (!is_inside(x))
            return x.z >= 0.0f ? sum + beta * sky : sum;
        sum += beta * lit(s, x, w);
        beta *= albedo;
        if (beta < 0.4f) {
            if (lf_rng(t) > beta)
                return sum;
            beta = 1.0f;
        }
        w = scattered(s->g, w, t);
    }
}

/* Depths are a net over a column's pivots. */
static void draw_pivot(const setup *s, int column, int pass, lf_tracer *t, pivot *out)
{
    const float u = ((float)pass + lf_rng(t)) / PASSES, aside = lf_rng(t), along = lf_rng(t);
    *out = (pivot){.x = {((float)column + aside) * s->pitch, along * s->pitch,
                         logf(1.0f - u * (1.0f - expf(-slab)))},
                   .column = column,
                   .block = column / s->block};
    out->w2 = scattered(s->g, view, t);
    out->x2 = lf_madd(out->x, lf_rng_exponential(t), out->w2);
    out->inside = is_inside(out->x2);
    out->unlike = lit(s, out->x, view);
    if (!out->inside && out->x2.z >= 0.0f)
        out->unlike += albedo * sky;
    out->alone = out->shared = out->unlike;
    if (!out->inside)
        return;
    out->w3 = scattered(s->g, out->w2, t);
    out->behind = arriving(s, out->x2, out->w3, t);
    out->alone += albedo * (lit(s, out->x2, out->w2) + albedo * out->behind);
}

/* A pivot's second vertex, for all of its group. The sun there is weighed by the density of the
 * vertex alone, what is behind by that of the direction as well. */
static void share(const setup *s, pivot *group, int n, const pivot *from)
{
    float vertex[MAX_GROUP], path[MAX_GROUP], light[MAX_GROUP], vertices = 0.0f, paths = 0.0f;
    for (int i = 0; i < n; i++) {
        const lf_vec3 d = lf_sub(from->x2, group[i].x);
        const float r2 = lf_max(lf_dot(d, d), 1e-20f), r = sqrtf(r2);
        const lf_vec3 w = lf_scale(d, 1.0f / r);
        vertex[i] = lf_phase_between(s->g, view, w) * (s->wrong ? 1.0f : expf(-r) / r2);
        path[i] = vertex[i] * lf_phase_between(s->g, w, from->w3);
        light[i] = lit(s, from->x2, w);
        vertices += vertex[i];
        paths += path[i];
    }
    for (int i = 0; i < n; i++)
        group[i].shared +=
            albedo * (vertex[i] / vertices * light[i] + path[i] / paths * albedo * from->behind);
}

static int by_block_and_depth(const void *a, const void *b)
{
    const pivot *p = a, *q = b;
    return p->block != q->block ? p->block - q->block : (p->x.z > q->x.z) - (p->x.z < q->x.z);
}

/* All pivots of a sample; groups are neighbours in depth within a block. */
static void draw_row(const setup *s, lf_tracer *t, pivot *row)
{
    const int n = PASSES * s->columns;
    for (int i = 0; i < n; i++)
        draw_pivot(s, i % s->columns, i / s->columns, t, &row[i]);
    qsort(row, (size_t)n, sizeof *row, by_block_and_depth);
    for (int first = 0, size; first < n; first += size) {
        for (size = 1; size < s->group && first + size < n; size++)
            if (row[first + size].block != row[first].block)
                break;
        for (int i = 0; i < size; i++)
            if (row[first + i].inside)
                share(s, &row[first], size, &row[first + i]);
    }
}

/* View pixels. And whole rows, which are independent: what sharing adds to a sum that places weigh
 * (what neighbours owe each other would not be seen in a plain one). */
typedef struct outcome {
    lf_moments alone, shared, added;
} outcome;

static void measure(const setup *s, int n_rows, uint64_t seed, outcome *out)
{
    static pivot row[PASSES * MAX_COLUMNS];
    lf_tracer t = {.rng = lf_hash64(lf_test_seed(), seed)};
    *out = (outcome){0};
    for (int k = 0; k < n_rows; k++) {
        double alone[MAX_COLUMNS] = {0}, shared[MAX_COLUMNS] = {0}, added = 0.0;
        draw_row(s, &t, row);
        for (int i = 0; i < PASSES * s->columns; i++) {
            const pivot *p = &row[i];
            alone[p->column] += (double)p->alone / PASSES;
            shared[p->column] += (double)p->shared / PASSES;
            added += (double)p->x.x * ((double)p->shared - (double)p->alone);
        }
        for (int c = 0; c < s->columns; c++) {
            lf_moments_add(&out->alone, alone[c]);
            lf_moments_add(&out->shared, shared[c]);
        }
        lf_moments_add(&out->added, added / PASSES);
    }
}

/* How many suffixes of a pivot alone one that is shared counts for. A suffix's noise is nearly all
 * there is: 8 % (g = 0) are of second vertices that left the slab, which nobody can share. */
static double counts_for(const outcome *o)
{
    return lf_moments_variance(&o->alone) / lf_moments_variance(&o->shared);
}

static void what_is_shared_has_the_mean_of_what_is_not(void **state)
{
    (void)state;
    static const float g[] = {0.0f, 0.6f};
    const double level = lf_sidak(LF_FALSE_ALARM, 2);
    for (int i = 0; i < 2; i++) {
        const setup s = {
            .pitch = 0.23f, .g = g[i], .columns = 16, .block = 16, .group = 16, .dark = 0.5f};
        setup wrong = s;
        outcome o;
        wrong.wrong = true;
        measure(&s, 150, (uint64_t)i, &o);
        assert_true(lf_p_mean(&o.added, 0.0) > level);
        measure(&wrong, 150, (uint64_t)i, &o); /* a negative control */
        assert_true(lf_p_mean(&o.added, 0.0) < 1e-6);
    }
}

/* The variances of 2400 pixels and more are right to some 5 %. Columns as fine as in the last case
 * show that what is looked for would be found. */
static void at_the_pitch_of_a_panel_one_counts_for_less_than_three(void **state)
{
    (void)state;
    static const struct {
        setup s;
        double low, high;
    } cases[] = {{{.pitch = 1.6f, .columns = 16, .block = 8, .group = 8}, 0.5, 1.2},
                 {{.pitch = 0.23f, .columns = 16, .block = 16, .group = 16}, 1.2, 2.0},
                 {{.pitch = 0.07f, .columns = 16, .block = 16, .group = 16}, 2.0, 3.0},
                 {{.pitch = 0.02f, .columns = 32, .block = 32, .group = 64}, 4.0, 12.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        outcome o;
        measure(&cases[i].s, 150, 10 + i, &o);
        if (!(counts_for(&o) > cases[i].low && counts_for(&o) < cases[i].high))
            fail_msg("pitch %g, groups of %d: one counts for %.2f", (double)cases[i].s.pitch,
                     cases[i].s.group, counts_for(&o));
    }
}

static void the_table(void **state)
{
    (void)state;
    static const float pitches[] = {1.6f, 0.5f, 0.23f, 0.1f, 0.07f, 0.05f}, g[] = {0.0f, 0.6f};
    static const int groups[] = {8, 16, 64}, blocks[] = {8, 16, 32};
    if (!lf_test_long())
        skip();
    for (int i = 0; i < 2 * 6 * 3; i++) {
        const setup s = {.pitch = pitches[i / 3 % 6],
                         .g = g[i / 18],
                         .columns = 32,
                         .block = blocks[i % 3],
                         .group = groups[i % 3]};
        outcome o;
        measure(&s, 400, 100 + (uint64_t)i, &o);
        printf("g %.1f pitch %.2f, groups of %2d in %2d columns: %.2f\n", (double)s.g,
               (double)s.pitch, s.group, s.block, counts_for(&o));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_shared_has_the_mean_of_what_is_not),
        cmocka_unit_test(at_the_pitch_of_a_panel_one_counts_for_less_than_three),
        cmocka_unit_test(the_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
