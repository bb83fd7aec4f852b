/* Loops of surfaces over views and segments: every instruction set answers the bits of their
 * formulas, written here one view and one segment at a time, without boxes. */
#include "tests/testing.h"

#include "render/plane/kernel.h"
#include "tests/render/fans.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { WIDTH = 40, HEIGHT = 30 };

/* ------------------------------------------------------------------------------------- views -- */

/* A pivot somewhere before the cameras, which may be outside of some frames. */
static lf_projection make_projection(const lf_rig *rig, uint64_t *seed)
{
    lf_projection of = {.rig = rig,
                        .z = 0.3f + 6.0f * lf_test_uniform(seed),
                        .lx = lf_test_uniform(seed) < 0.5f ? 0.0f
                                                           : 0.2f * lf_test_uniform(seed) - 0.1f,
                        .surface = lf_test_uniform(seed) < 0.5f,
                        .nx = 2.0f * lf_test_uniform(seed) - 1.0f};
    of.x = (3.0f * lf_test_uniform(seed) - 1.5f) * of.z;
    of.nyz = (2.0f * lf_test_uniform(seed) - 1.2f) * of.z;
    of.yz2 = (1.0f + lf_test_uniform(seed)) * of.z * of.z;
    return of;
}

static lf_rig make_rig(uint64_t *seed)
{
    lf_rig rig = {.n_views = 1 + (int)(255.0f * lf_test_uniform(seed)),
                  .width = 1 + (int)(300.0f * lf_test_uniform(seed)),
                  .distance = 3.0f + lf_test_uniform(seed),
                  .focus = 2.0f + 3.0f * lf_test_uniform(seed),
                  .x0 = -0.5f - lf_test_uniform(seed)};
    rig.dx = -2.0f * rig.x0 / (float)rig.width;
    const float still = lf_test_uniform(seed) < 0.5f ? 1.0f : 0.0f;
    for (int k = 0; k < LF_MAX_LANES; k++)
        rig.b[k] = k < rig.n_views
                       ? -1.0f + 2.0f * ((float)k + lf_test_uniform(seed)) / (float)rig.n_views
                       : rig.b[k - 1];
    for (int k = 0; k < LF_MAX_LANES; k++)
        rig.skew[k] = rig.b[k] * still;
    return rig;
}

static int lanes_of(const lf_rig *rig)
{
    return (rig->n_views + LF_LANES - 1) / LF_LANES * LF_LANES;
}

static void views_are_projected_by_their_formula(void **state)
{
    (void)state;
    uint64_t seed = 5;
    int seen = 0, outside = 0;
    for (int trial = 0; trial < 1000; trial++) {
        lf_rig rig = make_rig(&seed);
        lf_projection of = make_projection(&rig, &seed);
        float inverse_z = 1.0f / of.z, lens = of.lx * rig.distance / rig.focus,
              per_pixel = 1.0f / rig.dx;
        for (int i = 0; lf_kernels_at(i); i++) {
            float x0[LF_MAX_LANES], slope[LF_MAX_LANES], z_end[LF_MAX_LANES], h[LF_MAX_LANES];
            int column[LF_MAX_LANES];
            const lf_projected out = {x0, slope, z_end, column, h};
            lf_kernels_at(i)->fans->project(&of, lanes_of(&rig), &out);
            for (int k = 0; k < lanes_of(&rig); k++) {
                float c = rig.b[k] + of.lx, dx = of.x - c, s = dx * inverse_z;
                float u = (rig.skew[k] + lens + rig.distance * s - rig.x0) * per_pixel;
                float wanted = of.surface ? -(of.nx * dx + of.nyz) : sqrtf(dx * dx + of.yz2);
                bool in_frame = u >= 0.0f && u < (float)rig.width && k < rig.n_views;
                assert_true(x0[k] == c && slope[k] == s && z_end[k] == of.z);
                assert_true(column[k] == (in_frame ? (int)u : 0));
                assert_true(h[k] == (in_frame && wanted > 0.0f ? wanted : 0.0f));
                seen += h[k] > 0.0f;
                outside += !in_frame;
            }
        }
    }
    assert_true(seen > 10000 && outside > 10000);
}

static void without_media_densities_are_those_of_no_depth(void **state)
{
    (void)state;
    uint64_t seed = 6;
    for (int trial = 0; trial < 1000; trial++) {
        float scale[LANES], tau[LANES] = {0}, d[2][LANES];
        int n = LF_LANES * (1 + trial % (LANES / LF_LANES));
        for (int k = 0; k < n; k++)
            scale[k] =
                trial % 10 == 0 || lf_test_uniform(&seed) < 0.3f
                    ? 0.0f
                    : ldexpf(lf_test_uniform(&seed), (int)(60.0f * lf_test_uniform(&seed)) - 30);
        float sum = lf_kernels_c.densities(n, scale, tau, d[0]);
        for (int i = 0; lf_kernels_at(i); i++) {
            float own = lf_kernels_at(i)->fans->densities(n, scale, d[1]);
            assert_memory_equal(&own, &sum, sizeof sum);
            assert_memory_equal(d[0], d[1], sizeof *d[0] * (size_t)n);
        }
    }
}

/* ------------------------------------------------------------------------------------- lobes -- */

static void fill(uint64_t *seed, int n, float from, float to, float *out)
{
    for (int k = 0; k < n; k++)
        out[k] = from + (to - from) * lf_test_uniform(seed);
}

static lf_vec3 some_direction(uint64_t *seed)
{
    float w[3];
    fill(seed, 3, -1.0f, 1.0f, w);
    return lf_normalize(lf_v3(w[0], w[1], w[2] + 2.0f));
}

static void cosines_and_phases_are_those_of_each_ray(void **state)
{
    (void)state;
    uint64_t seed = 7;
    for (int trial = 0; trial < 300; trial++) {
        float slope[LANES], own[LANES], g = 1.98f * lf_test_uniform(&seed) - 0.99f,
                                        my = lf_test_uniform(&seed) - 0.5f;
        const int n = LF_LANES * (1 + trial % (LANES / LF_LANES));
        fill(&seed, n, -1.0f, 1.0f, slope);
        const lf_vec3 w = some_direction(&seed);
        const lf_fan_axis axis = {w.x, my * w.y + w.z, 1.0f + my * my};
        const float sign = copysignf(1.0f, g), to[3] = {sign * w.x, sign * w.y, sign * w.z};
        for (int i = 0; lf_kernels_at(i); i++) {
            float first[LANES];
            lf_kernels_at(i)->fans->cosines(&axis, n, slope, own);
            for (int k = 0; k < n; k++) {
                const lf_vec3 ray = lf_normalize(lf_v3(slope[k], my, 1.0f));
                lf_assert_close((double)own[k], (double)lf_dot(ray, w), 0.0, 1e-6);
            }
            lf_kernels_at(i)->fans->phases(g, to, my, n, slope, own);
            for (int k = 0; k < n; k++) {
                const lf_vec3 ray = lf_normalize(lf_v3(slope[k], my, 1.0f));
                lf_assert_close((double)own[k], (double)lf_phase_between(g, ray, w), 1e-4, 0.0);
            }
            lf_kernels_c.fans->phases(g, to, my, n, slope, first);
            assert_memory_equal(own, first, sizeof *own * (size_t)n);
        }
    }
}

/* Media whose channels differ or not; media, whose channels share a lobe, or surfaces. */
static void what_a_pivot_sends_is_the_sum_over_its_directions(void **state)
{
    (void)state;
    uint64_t seed = 8;
    for (int trial = 0; trial < 300; trial++) {
        float density[3][LANES], lobe[3][LANES], pdf_of[LANES], z[LANES], before[LANES];
        const int n = LF_LANES * (1 + trial % (LANES / LF_LANES));
        const float *const received[3] = {density[0], density[trial % 2], density[trial % 2 * 2]};
        const lf_fan_lobes f = {.f = {lobe[0], lobe[trial % 3], lobe[trial % 3]}};
        for (int c = 0; c < 3; c++) {
            fill(&seed, n, 0.0f, 2.0f, density[c]);
            fill(&seed, n, 0.0f, 3.0f, lobe[c]);
        }
        fill(&seed, n, 0.0f, 1.0f, pdf_of);
        fill(&seed, n, 0.0f, 1.0f, before);
        fill(&seed, n, -1.0f, 1.0f, z);
        const float channel[3] = {lf_test_uniform(&seed), lf_test_uniform(&seed), -0.5f};
        const lf_vec3 radiance = lf_v3(channel[0], channel[1], channel[2]);
        const lf_fan_share share = {trial % 3 ? pdf_of : NULL, trial % 5 ? z : NULL, 0.7f, 0.3f};
        for (int i = 0; lf_kernels_at(i); i++) {
            const lf_fans *fans = lf_kernels_at(i)->fans;
            lf_sent sent;
            memset(&sent, 0, sizeof sent);
            memcpy(sent.n[1], before, sizeof *before * (size_t)n);
            memcpy(sent.w2, before, sizeof *before * (size_t)n);
            fans->collect(n, received, &f, radiance, &sent);
            fans->collect_shares(n, density[0], &share, &sent);
            float sum[LF_LANES] = {0}, total = 0.0f;
            for (int k = 0; k < n; k++) {
                float own = share.lobe ? share.drawn * pdf_of[k] : 0.0f;
                for (int c = 0; c < 3; c++) {
                    const float y = received[c][k] * f.f[c][k] * channel[c];
                    assert_true(sent.n[c][k] == (c == 1 ? before[k] + y : y));
                }
                own = share.z && z[k] <= 0.0f ? share.blind : own;
                assert_true(sent.w2[k] == before[k] + density[0][k] * own);
                sum[k % LF_LANES] += density[0][k] * pdf_of[k];
            }
            for (int l = 0; l < LF_LANES; l++)
                total += sum[l];
            assert_true(fans->pdf(n, density[0], pdf_of) == total);
        }
    }
}

/* ---------------------------------------------------------------------------------- segments -- */

typedef struct bench {
    lf_scene *scene;
    lf_renderer *renderer;
    lf_section section;
    lf_row_plane plane;
    lf_tracer tracer;
    uint64_t seed;
} bench;

static const lf_rig *rig_of(const bench *b)
{
    return &lf_test_rows(b->renderer)->rig;
}

static void set_up(bench *b, const char *text)
{
    *b = (bench){.scene = lf_test_scene(text), .seed = 17};
    b->renderer = lf_test_renderer(b->scene, "mvpt", WIDTH, HEIGHT, NULL);
    b->tracer.scene = b->scene;
    assert_int_equal(lf_section_init(&b->section, lf_test_rows(b->renderer)->triangles.longest, 0),
                     LF_OK);
}

static void tear_down(bench *b)
{
    lf_section_finish(&b->section);
    lf_renderer_destroy(b->renderer);
    lf_scene_unref(b->scene);
}

static void cut(bench *b, int row)
{
    const float lens[2] = {lf_test_uniform(&b->seed), lf_test_uniform(&b->seed)};
    lf_rig_row_plane(rig_of(b), (float)row + lf_test_uniform(&b->seed), lens, &b->plane);
    lf_section_cut(&b->section, &lf_test_rows(b->renderer)->triangles, b->scene, rig_of(b), row,
                   &b->plane, LF_CUT_ALL);
}

/* The positions from which a segment hides the point. */
static void interval(const lf_section_leaf *leaf, int i, const lf_question *q, float *lo, float *hi)
{
    float d0 = leaf->d0[i] - q->d, d1 = leaf->d1[i] - q->d, s0 = leaf->s0[i] - q->s,
          s1 = leaf->s1[i] - q->s;
    float cut_at = s0 + (s1 - s0) * ((q->behind - d0) / (d1 - d0));
    float c0 = (d0 < q->behind ? cut_at : s0) / lf_max(d0, q->behind), c1 = s1 / d1;
    bool hides = d1 > q->behind && leaf->triangle[i] != q->on;
    *lo = hides ? lf_min(c0, c1) : INFINITY;
    *hi = hides ? lf_max(c0, c1) : -INFINITY;
}

/* What every segment says, one after the other. */
static void hide_plainly(const lf_section *section, const lf_question *q, int n, float *scale)
{
    for (int s = 0; s < LF_SECTION_WIDE * section->n_leaves; s++) {
        float lo, hi;
        interval(&section->leaves[s / LF_SECTION_WIDE], s % LF_SECTION_WIDE, q, &lo, &hi);
        for (int k = 0; k < n; k++)
            scale[k] = q->c[k] >= lo && q->c[k] <= hi ? 0.0f : scale[k];
    }
}

static void assert_intervals(const lf_fans *fans, const lf_section *section, const lf_question *q)
{
    for (int l = 0; l < section->n_leaves; l++) {
        float lo[LF_SECTION_WIDE], hi[LF_SECTION_WIDE];
        unsigned reaching = fans->intervals(&section->leaves[l], q, lo, hi);
        for (int i = 0; i < LF_SECTION_WIDE; i++) {
            float from, to;
            interval(&section->leaves[l], i, q, &from, &to);
            bool reaches = from <= q->c[q->last] && to >= q->c[q->first];
            assert_true(lo[i] == from && hi[i] == to);
            assert_true((reaching >> i & 1u) == (unsigned)reaches);
            /* its box says no less */
            assert_true(!reaches || fans->meets(&section->nodes[l / LF_SECTION_WIDE], q) >>
                                            (l % LF_SECTION_WIDE) &
                                        1u);
        }
    }
}

/* Asks who sees a point; how many views a surface hides it from. */
static int ask(bench *b, float lx, lf_vec3 p, const lf_hit *on)
{
    int n = lanes_of(rig_of(b)), hidden = 0;
    float c[LF_MAX_LANES], before[LF_MAX_LANES], wanted[LF_MAX_LANES], scale[LF_MAX_LANES];
    for (int k = 0; k < n; k++) {
        c[k] = rig_of(b)->b[k] + lx;
        before[k] = k < rig_of(b)->n_views && lf_test_uniform(&b->seed) < 0.9f
                        ? lf_test_uniform(&b->seed)
                        : 0.0f;
    }
    const lf_row_cut of = {&b->section, &lf_test_rows(b->renderer)->triangles, b->scene, rig_of(b),
                           &b->plane};
    lf_question q = lf_section_ask(&of, p, on, n, c, scale);
    memcpy(scale, before, sizeof before);
    memcpy(wanted, before, sizeof before);
    if (!lf_question_narrow(&q))
        return 0;
    hide_plainly(&b->section, &q, n, wanted);
    for (int i = 0; lf_kernels_at(i); i++) {
        lf_question own = q;
        memcpy(scale, before, sizeof before);
        assert_intervals(lf_kernels_at(i)->fans, &b->section, &q);
        lf_kernels_at(i)->fans->hide(&b->section, &own);
        assert_memory_equal(scale, wanted, sizeof *scale * (size_t)n);
    }
    for (int k = 0; k < n; k++)
        hidden += before[k] > 0.0f && scale[k] == 0.0f;
    return hidden;
}

static void nearest_plainly(const lf_section *section, float s, int n, const float *c, float *d,
                            int *segment)
{
    for (int k = 0; k < n; k++) {
        d[k] = -LF_SECTION_FAR;
        segment[k] = -1;
        for (int at = 0; at < LF_SECTION_WIDE * section->n_leaves; at++) {
            const lf_section_leaf *leaf = &section->leaves[at / LF_SECTION_WIDE];
            int i = at % LF_SECTION_WIDE;
            float d0 = leaf->d0[i], d1 = leaf->d1[i], to0 = (leaf->s0[i] - s) - c[k] * d0,
                  to1 = (leaf->s1[i] - s) - c[k] * d1, there = d0 + (d1 - d0) * (to0 / (to0 - to1));
            if (d1 > -LF_SECTION_FAR && (to0 >= 0.0f) != (to1 >= 0.0f) && there > d[k]) {
                d[k] = there;
                segment[k] = at;
            }
        }
    }
}

/* Along a fan through a point of the window; how many views meet a surface. */
static int look(bench *b, float s, float lx)
{
    int n = lanes_of(rig_of(b)), met = 0, segment[2][LF_MAX_LANES];
    float c[LF_MAX_LANES], d[2][LF_MAX_LANES];
    for (int k = 0; k < n; k++)
        c[k] = rig_of(b)->b[k] + lx;
    nearest_plainly(&b->section, s, n, c, d[0], segment[0]);
    for (int i = 0; lf_kernels_at(i); i++) {
        lf_kernels_at(i)->fans->nearest(&b->section, s, n, c, d[1], segment[1]);
        assert_memory_equal(d[0], d[1], sizeof *d[0] * (size_t)n);
        assert_memory_equal(segment[0], segment[1], sizeof *segment[0] * (size_t)n);
    }
    for (int k = 0; k < n; k++)
        met += segment[0][k] >= 0;
    return met;
}

/* Points on surfaces and on the way there, and fans. */
static void assert_section(const char *text)
{
    bench b;
    int hidden = 0, met = 0;
    set_up(&b, text);
    for (int row = 0; row < HEIGHT; row++) {
        cut(&b, row);
        for (int i = 0; i < 20; i++) {
            const lf_rig *rig = rig_of(&b);
            int view = (int)(lf_test_uniform(&b.seed) * (float)rig->n_views);
            float lx = (2.0f * lf_test_uniform(&b.seed) - 1.0f) * b.plane.lens_chord,
                  xw = rig->x0 + lf_test_uniform(&b.seed) * (float)WIDTH * rig->dx,
                  slope = (xw - rig->b[view]) / rig->distance - lx / rig->focus;
            lf_vec3 eye = lf_rig_point(rig, rig->b[view] + lx, b.plane.ly, 0.0f),
                    w = lf_rig_direction(rig, slope, b.plane.my, 1.0f);
            lf_hit hit;
            bool found = lf_trace_surface(&b.tracer, eye, w, INFINITY, &hit);
            if (found)
                hidden += ask(&b, lx, hit.p, &hit);
            float way = lf_test_uniform(&b.seed) * (found ? hit.t : 2.0f * rig->distance);
            hidden += ask(&b, lx, lf_madd(eye, way, w), NULL);
            met += look(&b, xw / rig->distance, lx);
        }
    }
    assert_true(hidden > 100 && met > 100);
    tear_down(&b);
}

/* Balls, a mirror, a lamp and the ground; a room that surrounds the cameras. */
static void sections_answer_what_every_segment_says(void **state)
{
    (void)state;
    assert_section(lf_test_scene_views("lamp", 45));
    assert_section(lf_test_scene_patched(
        "lamp", "{'camera': {'views': 13, 'lens_radius': 0.15, 'focus_distance': 4}}"));
    assert_section(lf_test_scene_views("inside-a-ball", 45));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_are_projected_by_their_formula),
        cmocka_unit_test(without_media_densities_are_those_of_no_depth),
        cmocka_unit_test(cosines_and_phases_are_those_of_each_ray),
        cmocka_unit_test(what_a_pivot_sends_is_the_sum_over_its_directions),
        cmocka_unit_test(sections_answer_what_every_segment_says),
    };
    return cmocka_run_group_tests_name("fans", tests, NULL, lf_test_finish);
}
