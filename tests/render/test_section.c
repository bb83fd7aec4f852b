/* The meshes in a row's plane: which views see a point follows from segments as it does from rays,
 * on surfaces and off them, with lenses, in rooms around the cameras, far from the origin, tiny and
 * huge. */
#include "tests/testing.h"

#include "render/plane/section.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/uniform.h"

enum { width = 40, height = 30 };

/* A section, the plane that it lies in, and what asks it. */
typedef struct bench {
    lf_scene *scene;
    lf_renderer *renderer;
    lf_section section;
    lf_row_plane plane;
    lf_tracer tracer;
    bool strict; /* differences are looked into */
    uint64_t random;
} bench;

static void set_up(bench *b, const char *text)
{
    *b = (bench){.scene = lf_test_scene(text), .strict = true, .random = lf_test_seed()};
    b->renderer = lf_test_renderer(b->scene, "mvpt", width, height, NULL);
    b->tracer.scene = b->scene;
    assert_int_equal(lf_section_init(&b->section, lf_test_rows(b->renderer)->triangles.longest,
                                     lf_test_rows(b->renderer)->triangles.n_instances),
                     LF_OK);
}

static void tear_down(bench *b)
{
    lf_section_finish(&b->section);
    lf_renderer_destroy(b->renderer);
    lf_scene_unref(b->scene);
}

/* A plane of the row; the section's is moved by so many rows. */
static void cut(bench *b, int row, float moved)
{
    const lf_rig *rig = &lf_test_rows(b->renderer)->rig;
    const float lens[2] = {lf_test_uniform(&b->random), lf_test_uniform(&b->random)};
    float v = (float)row + (1.0f - moved) * lf_test_uniform(&b->random);
    lf_row_plane other;
    lf_rig_row_plane(rig, v, lens, &b->plane);
    lf_rig_row_plane(rig, v + moved, lens, &other);
    lf_section_cut(&b->section, &lf_test_rows(b->renderer)->triangles, b->scene, rig, row, &other,
                   LF_CUT_ALL);
}

static lf_row_cut cut_of(const bench *b)
{
    const lf_rows *rows = lf_test_rows(b->renderer);
    return (lf_row_cut){&b->section, &rows->triangles, b->scene, &rows->rig, &b->plane};
}

/* Positions of the cameras, and which of them look at the side of the surface that p is on. */
static void cameras(const bench *b, float lx, lf_vec3 p, const lf_hit *on, float *c, float *scale)
{
    const lf_rig *rig = &lf_test_rows(b->renderer)->rig;
    for (int k = 0; k < LF_MAX_LANES; k++) {
        c[k] = rig->b[k] + lx;
        lf_vec3 to = lf_sub(lf_rig_point(rig, c[k], b->plane.ly, 0.0f), p);
        bool faces = !on || lf_dot(on->ng, to) > 1e-2f * lf_length(to);
        scale[k] = k < rig->n_views && faces ? 1.0f : 0.0f;
    }
}

static bool sees(bench *b, float c, lf_vec3 p, const lf_hit *on)
{
    lf_vec3 eye = lf_rig_point(&lf_test_rows(b->renderer)->rig, c, b->plane.ly, 0.0f), o = p;
    if (on)
        o = lf_offset(b->scene, p, on->ng, lf_sub(eye, p), 0.0f);
    return !lf_trace_occluded(&b->tracer, o, lf_sub(eye, o), 1.0f - 1e-5f);
}

typedef struct tally {
    int64_t asked, hidden, edges, wrong;
} tally;

/* Where a triangle is met on the way from o to o + w, in double; a number that is not between 0 and
 * 1: nowhere. */
static double met(const lf_mesh *mesh, int triangle, const double o[3], const double w[3])
{
    double v[3][3], ab[3], ac[3], p[3], q[3], to[3], det = 0.0, u = 0.0, s = 0.0, t = 0.0;
    for (int i = 0; i < 3; i++) {
        lf_vec3 corner = lf_mesh_vertex(mesh, mesh->triangles[3 * triangle + i]);
        v[i][0] = (double)corner.x;
        v[i][1] = (double)corner.y;
        v[i][2] = (double)corner.z;
    }
    for (int i = 0; i < 3; i++) {
        ab[i] = v[1][i] - v[0][i];
        ac[i] = v[2][i] - v[0][i];
        to[i] = o[i] - v[0][i];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        p[i] = w[j] * ac[k] - w[k] * ac[j];
        q[i] = to[j] * ab[k] - to[k] * ab[j];
    }
    for (int i = 0; i < 3; i++) {
        det += ab[i] * p[i];
        u += to[i] * p[i];
        s += w[i] * q[i];
        t += ac[i] * q[i];
    }
    return u * det >= 0.0 && s * det >= 0.0 && (u + s) * det <= det * det ? t / det : -1.0;
}

/* A segment's triangle there is what the ray found, normals included. */
static bool is_described(const bench *b, int segment, const lf_hit *hit, lf_vec3 w)
{
    lf_hit own;
    lf_face face;
    const lf_row_cut of = cut_of(b);
    lf_section_face(&of, segment, &face);
    lf_face_hit(&face, hit->p, lf_normalize(w), &own);
    return &b->scene->materials[lf_section_material(&b->section, segment)] == hit->material &&
           own.material == hit->material && own.mesh == hit->mesh &&
           own.triangle == hit->triangle && own.front == hit->front &&
           fabsf(own.u - hit->u) + fabsf(own.v - hit->v) < 2e-3f &&
           lf_length(lf_sub(own.ng, hit->ng)) + lf_length(lf_sub(own.ns, hit->ns)) < 2e-3f;
}

/* The same question to every triangle in double, where rays need no offset; nearer than `behind` of
 * the way nothing counts. */
static bool sees_exactly(const bench *b, float c, lf_vec3 p, const lf_hit *on, double behind)
{
    lf_vec3 eye = lf_rig_point(&lf_test_rows(b->renderer)->rig, c, b->plane.ly, 0.0f);
    const double o[3] = {(double)p.x, (double)p.y, (double)p.z};
    const double w[3] = {(double)eye.x - o[0], (double)eye.y - o[1], (double)eye.z - o[2]};
    for (int m = 0; m < b->scene->n_meshes; m++) {
        for (int i = 0; i < b->scene->meshes[m].n_triangles; i++) {
            bool own = on && on->mesh == &b->scene->meshes[m] && (int)on->triangle == i;
            double t = own ? -1.0 : met(&b->scene->meshes[m], i, o, w);
            if (t > behind && t < 1.0)
                return false;
        }
    }
    return true;
}

/* Whether the answer holds there, or where an edge passes within a hundredth of the views'
 * distance, or of the row's height along the surface, or the point within the rounding of its
 * coordinates; what touches it may hide it or not. */
static bool holds_nearby(const bench *b, float c, lf_vec3 p, const lf_hit *on, bool seen)
{
    const lf_rig *rig = &lf_test_rows(b->renderer)->rig;
    float step = 0.01f * fabsf(rig->b[1] - rig->b[0]),
          z = lf_dot(lf_sub(p, rig->eye), rig->forward);
    lf_vec3 up = on ? lf_madd(rig->up, -lf_dot(rig->up, on->ng), on->ng) : rig->up;
    for (int i = 0; i < 27; i++) {
        float at = c + (float)(i % 3 - 1) * step,
              along = (float)(i / 3 % 3 - 1) * 0.01f * fabsf(rig->dy) * z / rig->distance;
        lf_vec3 moved = lf_madd(p, along, up);
        if (on)
            moved = lf_madd(moved,
                            (float)(i / 9 - 1) * 5e-7f *
                                (z + lf_max(fabsf(p.x), lf_max(fabsf(p.y), fabsf(p.z)))),
                            on->ng);
        if (sees_exactly(b, at, moved, on, 1e-7) == seen ||
            sees_exactly(b, at, moved, on, 1e-5) == seen)
            return true;
    }
    return false;
}

/* Asks for one point. */
static void ask(bench *b, float lx, lf_vec3 p, const lf_hit *on, tally *t)
{
    const lf_rig *rig = &lf_test_rows(b->renderer)->rig;
    float c[LF_MAX_LANES], wanted[LF_MAX_LANES], scale[LF_MAX_LANES];
    cameras(b, lx, p, on, c, wanted);
    memcpy(scale, wanted, sizeof scale);
    const lf_row_cut of = cut_of(b);
    lf_section_hide(&of, p, on, lf_rig_lanes(rig), c, scale);
    for (int k = 0; k < rig->n_views; k++) {
        if (!(wanted[k] > 0.0f)) {
            assert_true(scale[k] == 0.0f);
            continue;
        }
        bool seen = scale[k] > 0.0f;
        t->asked++;
        t->hidden += !seen;
        if (seen == sees(b, c[k], p, on))
            continue;
        bool edge = b->strict && holds_nearby(b, c[k], p, on, seen);
        t->edges += edge;
        t->wrong += !edge;
    }
}

/* Points that base rays find, on surfaces, and points on the way there. */
static tally compare(bench *b, float moved)
{
    const lf_rig *rig = &lf_test_rows(b->renderer)->rig;
    tally t = {0};
    for (int row = 0; row < height; row++) {
        cut(b, row, moved);
        for (int i = 0; i < 60; i++) {
            int view = (int)(lf_test_uniform(&b->random) * (float)rig->n_views);
            float lx = (2.0f * lf_test_uniform(&b->random) - 1.0f) * b->plane.lens_chord;
            float xw = rig->x0 + lf_test_uniform(&b->random) * (float)width * rig->dx,
                  slope = (xw - rig->b[view]) / rig->distance - lx / rig->focus;
            lf_vec3 eye = lf_rig_point(rig, rig->b[view] + lx, b->plane.ly, 0.0f);
            lf_vec3 w = lf_rig_direction(rig, slope, b->plane.my, 1.0f);
            lf_hit hit;
            bool found = lf_trace_surface(&b->tracer, eye, w, INFINITY, &hit);
            if (found)
                ask(b, lx, hit.p, &hit, &t);
            ask(b, lx,
                lf_madd(eye, lf_test_uniform(&b->random) * (found ? hit.t : 2.0f * rig->distance),
                        w),
                NULL, &t);
        }
    }
    return t;
}

static void assert_as_rays(const char *text)
{
    bench b;
    set_up(&b, text);
    tally t = compare(&b, 0.0f);
    if (t.wrong > 0 || t.edges > t.asked / 1000)
        fail_msg("of %lld answers %lld are wrong, and %lld at edges differ: %s", (long long)t.asked,
                 (long long)t.wrong, (long long)t.edges, text);
    assert_true(t.asked > 10000 && t.hidden > t.asked / 100 && t.hidden < t.asked);
    tear_down(&b);
}

/* Fans through points of the window: the rays of all views and columns find what Embree finds, but
 * at edges. */
static void assert_fans(bench *b)
{
    const lf_rig *rig = &lf_test_rows(b->renderer)->rig;
    int asked = 0, found = 0, wrong = 0, lanes = lf_rig_lanes(rig);
    for (int i = 0; i < 40 * height; i++) {
        float c[LF_MAX_LANES], z[LF_MAX_LANES];
        int segment[LF_MAX_LANES];
        if (i % 40 == 0)
            cut(b, i / 40, 0.0f);
        float lx = (2.0f * lf_test_uniform(&b->random) - 1.0f) * b->plane.lens_chord,
              xw = rig->x0 + lf_test_uniform(&b->random) * (float)width * rig->dx;
        for (int k = 0; k < lanes; k++)
            c[k] = rig->b[k] + lx;
        const lf_row_cut of = cut_of(b);
        const lf_lines lines = {
            xw / rig->distance + lx * (1.0f / rig->distance - 1.0f / rig->focus), lanes, c};
        lf_section_nearest(&of, &lines, z, segment);
        for (int k = 0; k < rig->n_views; k++) {
            lf_vec3 eye = lf_rig_point(rig, c[k], b->plane.ly, 0.0f);
            lf_vec3 w = lf_rig_direction(rig, (xw - rig->b[k]) / rig->distance - lx / rig->focus,
                                         b->plane.my, 1.0f);
            lf_hit hit;
            bool met = lf_trace_surface(&b->tracer, eye, w, INFINITY, &hit);
            bool same =
                met ? fabsf(z[k] - hit.t) <= 1e-4f * hit.t && is_described(b, segment[k], &hit, w)
                    : z[k] == INFINITY && segment[k] == -1;
            asked++;
            found += met;
            wrong += !same;
        }
    }
    if (wrong > asked / 2000)
        fail_msg("of %d rays %d are wrong", asked, wrong);
    assert_true(found > asked / 10);
}

#define THROUGH_LENSES "{'camera': {'views': 13, 'lens_radius': 0.15, 'focus_distance': 4}}"

static void fans_meet_what_rays_meet(void **state)
{
    (void)state;
    const char *const scenes[] = {lf_test_scene_views("lamp", 45),
                                  lf_test_scene_patched("lamp", THROUGH_LENSES),
                                  lf_test_scene_text("room")};
    for (int i = 0; i < 3; i++) {
        bench b;
        set_up(&b, scenes[i]);
        assert_fans(&b);
        tear_down(&b);
    }
}

/* Balls, a mirror, a lamp and the ground. */
static void surfaces_hide_as_rays_find(void **state)
{
    (void)state;
    assert_as_rays(lf_test_scene_views("lamp", 45));
    assert_as_rays(lf_test_scene_views("lamp", 7));
}

static void lenses_move_the_cameras_of_a_row(void **state)
{
    (void)state;
    assert_as_rays(lf_test_scene_patched("lamp", THROUGH_LENSES));
}

static void rooms_surround_the_cameras(void **state)
{
    (void)state;
    assert_as_rays(lf_test_scene_text("room"));
    assert_as_rays(lf_test_scene_patched(
        "room", "{'camera': {'position': [0, 0.2, 2], 'fov_y': 60, 'cone': 60, 'views': 9}}"));
}

/* Two balls and a ground, everything by s about (x, 0, -x). */
static void assert_scaled(double s, double x)
{
    assert_as_rays(lf_test_scene_patched(
        "two-balls",
        "{'camera': {'target': [%.17g, 0, %.17g], 'position': [%.17g, %.17g, %.17g]}, "
        "'meshes': {'ground': {'transform': {'scale': %g, 'translate': [%.17g, %.17g, %.17g]}}, "
        "'a': {'transform': {'scale': %g, 'translate': [%.17g, 0, %.17g]}}, "
        "'b': {'transform': {'scale': %g, 'translate': [%.17g, 0, %.17g]}}}}",
        x, -x, x, 0.6 * s, 5 * s - x, 4 * s, x, -s, -x, 0.6 * s, x - 0.5 * s, 0.3 * s - x, 0.4 * s,
        x + 0.6 * s, -0.4 * s - x));
}

static void scenes_far_away_tiny_and_huge(void **state)
{
    (void)state;
    assert_scaled(1.0, 1e6);
    assert_scaled(1e-4, 0.0);
    assert_scaled(1e5, 0.0);
}

/* What stands on it is a ten thousandth of the ground. */
static void a_small_box_on_a_large_ground(void **state)
{
    (void)state;
    static const char *const grounds[] = {"3000, 'rotate': [0, 20, 0]",
                                          "3000, 'rotate': [4, 20, -7]", "100000"};
    for (int i = 0; i < 3; i++)
        assert_as_rays(lf_test_scene_patched(
            "small-box", "{'meshes': {'ground': {'transform': {'scale': %s}}}}", grounds[i]));
}

/* A card between a point and the middle of the rig, both at known places: views b with |b (1 -
 * z_card / z)| < half its width are hidden. */
static void a_card_hides_the_views_behind_it(void **state)
{
    (void)state;
    bench b;
    set_up(&b, lf_test_scene_text("card-in-front"));
    const lf_rig *rig = &lf_test_rows(b.renderer)->rig;
    float c[LF_MAX_LANES], scale[LF_MAX_LANES];
    cut(&b, height / 2, 0.0f);
    lf_vec3 p = lf_rig_point(rig, 0.0f, b.plane.my * 8.0f, 8.0f);
    cameras(&b, 0.0f, p, NULL, c, scale);
    const lf_row_cut of = cut_of(&b);
    lf_section_hide(&of, p, NULL, 48, c, scale);
    int hidden = 0;
    for (int k = 0; k < 45; k++) {
        assert_true((scale[k] > 0.0f) == (fabsf(rig->b[k]) * (1.0f - 2.0f / 8.0f) > 0.31f));
        hidden += !(scale[k] > 0.0f);
    }
    assert_true(hidden > 5 && hidden < 40);
    tear_down(&b);
}

/* Every triangle that a plane of the row meets is in the row's list. */
static void lists_of_rows_are_complete(void **state)
{
    (void)state;
    bench b;
    set_up(&b,
           lf_test_scene_patched("lamp", "{'camera': {'lens_radius': 0.15, 'focus_distance': 4}}"));
    const lf_row_triangles *rows = &lf_test_rows(b.renderer)->triangles;
    size_t found = 0;
    for (int row = 0; row < height; row++) {
        for (int i = 0; i < 200; i++) {
            cut(&b, row, 0.0f);
            const lf_rig *rig = &lf_test_rows(b.renderer)->rig;
            float lx = (2.0f * lf_test_uniform(&b.random) - 1.0f) * b.plane.lens_chord,
                  xw = rig->x0 + lf_test_uniform(&b.random) * (float)width * rig->dx;
            lf_vec3 eye = lf_rig_point(rig, lx + rig->b[2], b.plane.ly, 0.0f);
            lf_hit hit;
            if (!lf_trace_surface(
                    &b.tracer, eye,
                    lf_rig_direction(rig, (xw - rig->b[2]) / rig->distance - lx / rig->focus,
                                     b.plane.my, 1.0f),
                    INFINITY, &hit))
                continue;
            bool listed = false;
            for (size_t at = rows->first[row]; at < rows->first[row + 1]; at++)
                listed |= rows->list[at].mesh == hit.mesh->geom_id &&
                          rows->list[at].triangle == hit.triangle;
            assert_true(listed);
            found++;
        }
    }
    assert_true(found > 2000);
    tear_down(&b);
}

/* What the comparison would say of a section through another part of the row. */
static void another_plane_is_noticed(void **state)
{
    (void)state;
    bench b;
    set_up(&b, lf_test_scene_views("lamp", 45));
    b.strict = false;
    tally t = compare(&b, 0.5f);
    assert_true(t.wrong > 100);
    tear_down(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_card_hides_the_views_behind_it),
        cmocka_unit_test(surfaces_hide_as_rays_find),
        cmocka_unit_test(lenses_move_the_cameras_of_a_row),
        cmocka_unit_test(rooms_surround_the_cameras),
        cmocka_unit_test(scenes_far_away_tiny_and_huge),
        cmocka_unit_test(lists_of_rows_are_complete),
        cmocka_unit_test(a_small_box_on_a_large_ground),
        cmocka_unit_test(another_plane_is_noticed),
        cmocka_unit_test(fans_meet_what_rays_meet),
    };
    return cmocka_run_group_tests_name("section", tests, NULL, lf_test_finish);
}
