/* Meshes that are given once and stand in many places: what rays and rows find there is what they
 * find in copies, which share no code with it; places turned, stretched, sheared and mirrored. */
#include "tests/testing.h"

#include "render/plane/section_rays.h"
#include "tests/render/instances.h"
#include "tests/scene_file.h"

enum { width = 40, height = 30, tile = 8, views = 3 };

#define CERTAIN 1e-9

/* A camera that sees all of it, or a part. */
#define ALL ", 'fov_y': 24"
#define PART ", 'fov_y': 9"

/* ------------------------------------------------------------------------------------ scenes -- */

/* A scene whose places are instances, or copies. more: behind the camera's words. */
static lf_scene *scene_of(const char *shape, const char *material, bool copies, double moved,
                          const char *n_views, const char *more)
{
    static char text[1 << 16];
    double m[n_instances][12];
    char *at = text, *end = text + sizeof text;
    places(moved, m);
    at +=
        snprintf(at, (size_t)(end - at), "{'camera': {'views': %s%s}, 'meshes': {", n_views, more);
    for (int k = 0; k < n_instances; k++) {
        if (k == 0 || copies)
            at += snprintf(at, (size_t)(end - at),
                           "'a%d': { 'shape': '%s', 'material': '%s', '%s': %s", k, shape, material,
                           copies ? "transform" : "instances", copies ? "{ 'matrix': " : "[");
        for (int i = 0; i < 12; i++)
            at += snprintf(at, (size_t)(end - at), "%s%.17g", i == 0 ? "[" : ", ", m[k][i]);
        at += snprintf(at, (size_t)(end - at), "%s", copies ? ", 0, 0, 0, 1] } }" : "]");
        if (k + 1 < n_instances)
            at += snprintf(at, (size_t)(end - at), ", ");
    }
    snprintf(at, (size_t)(end - at), "%s}}", copies ? "" : "]}");
    return lf_test_scene(lf_test_scene_patched("instances-on-ground", "%s", text));
}

/* -------------------------------------------------------------------------------------- rays -- */

/* Of both scenes the ground is mesh 0. */
static bool same_place(const lf_scene *instances, const lf_hit *a, const lf_scene *copies,
                       const lf_hit *b)
{
    bool of_place = a->mesh == &instances->meshes[1];
    return b->mesh == &copies->meshes[of_place ? 1 + a->place : 0] && a->triangle == b->triangle;
}

/* How many of n rays differ, and of rays from where they arrive. */
static int differences(const lf_scene *instances, const lf_scene *copies, int n, int *out_found)
{
    lf_tracer a = {.scene = instances}, b = {.scene = copies};
    uint64_t random = lf_test_seed();
    int wrong = 0;
    *out_found = 0;
    for (int i = 0; i < n; i++) {
        lf_vec3 o = lf_scale(lf_normalize(point(&random, 1.0f)), 6.0f),
                w = lf_normalize(lf_sub(point(&random, 1.5f), o));
        lf_hit at, there;
        bool found = lf_trace_surface(&a, o, w, INFINITY, &at),
             wanted = lf_trace_surface(&b, o, w, INFINITY, &there);
        bool fits = found == wanted && (!found || same_place(instances, &at, copies, &there));
        if (fits && found && at.mesh == &instances->meshes[1])
            fits = same_hit(&at, &there, at.place % 2 == 1);
        wrong += !fits;
        *out_found += found && at.mesh == &instances->meshes[1];
        if (!fits || !found)
            continue;
        /* to other places, and back into its own */
        lf_vec3 to = lf_normalize(point(&random, 1.0f)),
                start = lf_offset(instances, at.p, at.ng, to, 4.0f);
        wrong += lf_trace_occluded(&a, start, to, 4.0f) != lf_trace_occluded(&b, start, to, 4.0f);
    }
    return wrong;
}

static void rays_find_what_they_find_in_copies(void **state)
{
    (void)state;
    static const char *const shapes[] = {"sphere", "cube"};
    for (int i = 0; i < 2; i++) {
        lf_scene *instances = scene_of(shapes[i], "glaze", false, 0.0, "3", ALL),
                 *copies = scene_of(shapes[i], "glaze", true, 0.0, "3", ALL),
                 *beside = scene_of(shapes[i], "glaze", true, 0.02, "3", ALL);
        int found;
        assert_true(lf_has(instances, LF_TRAIT_INSTANCES) && instances->n_meshes == 2 &&
                    copies->n_meshes == 25);
        int wrong = differences(instances, copies, 20000, &found);
        if (wrong > 10 || found < 3000)
            fail_msg("%d of %d hits are others (%s)", wrong, found, shapes[i]);
        /* one place of 24 is moved by a hundredth of the scene */
        assert_true(differences(instances, beside, 20000, &found) > 100);
        lf_scene_unref(instances);
        lf_scene_unref(copies);
        lf_scene_unref(beside);
    }
}

/* A sheet of leaves: rays that leave a surface do not find it again, however they are turned, and a
 * mesh that is far from its own origin is as exact as one at it. */
static void rays_leave_the_place_that_they_come_from(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{ 'quiltd': 1, 'meshes': { 'a': { 'shape': 'quad', 'transform': { 'translate': [5000, 0, "
        "-3000] }, 'instances': [{ 'rotate': [13, 29, 41], 'scale': 3, 'translate': [-9000, 0, "
        "7000] }, { 'rotate': [-70, 5, 0], 'scale': [2, 1, 0.5] }] } } }");
    const lf_instances *instances = scene->meshes[0].instances;
    lf_tracer tracer = {.scene = scene};
    uint64_t random = lf_test_seed();
    int again = 0, missed = 0;
    for (int i = 0; i < 20000; i++) {
        lf_hit at, hit;
        uint32_t place = (uint32_t)(i % instances->n);
        float u = (float)next_number(&random), v = (1.0f - u) * (float)next_number(&random);
        lf_vec3 w = lf_normalize(point(&random, 1.0f));
        lf_instance_hit(scene, &scene->meshes[0], (uint32_t)(i / 2 % 2), place, u, v, w, &at);
        if (fabsf(lf_dot(w, at.ng)) < 1e-3f)
            continue;
        lf_vec3 o = lf_offset(scene, at.p, at.ng, lf_scale(w, -1.0f), 0.0f);
        again += lf_trace_surface(&tracer, o, lf_scale(w, -1.0f), 100.0f, &hit);
        missed += fabsf(lf_dot(w, at.ng)) > 0.1f && u > 0.01f && v > 0.01f && u + v < 0.99f &&
                  !lf_trace_surface(&tracer, o, w, 100.0f, &hit);
    }
    assert_int_equal(again, 0);
    assert_int_equal(missed, 0);
    lf_scene_unref(scene);
}

/* -------------------------------------------------------------------------------------- rows -- */

/* The same rows of both scenes. */
typedef struct bench {
    lf_scene *scene[2];
    lf_renderer *renderer[2];
    lf_section section[2];
    lf_tracer tracer[2];
    lf_row_plane plane;
    uint64_t random;
} bench;

static const lf_row_triangles *lists(const bench *b, int i)
{
    return &lf_test_rows(b->renderer[i])->triangles;
}

static const lf_rig *rig_of(const bench *b)
{
    return &lf_test_rows(b->renderer[0])->rig;
}

static void set_up(bench *b, const char *material, double moved, const char *n_views,
                   const char *more)
{
    *b = (bench){.random = lf_test_seed()};
    for (int i = 0; i < 2; i++) {
        b->scene[i] = scene_of("cube", material, i == 1, i == 1 ? moved : 0.0, n_views, more);
        b->renderer[i] = lf_test_renderer(b->scene[i], "mvpt", width, height, NULL);
        b->tracer[i].scene = b->scene[i];
        lf_assert_ok(
            lf_section_init(&b->section[i], lists(b, i)->longest, lists(b, i)->n_instances), NULL);
        b->section[i].rays.tracer = &b->tracer[i];
    }
    assert_int_equal(lists(b, 0)->n_instances, n_instances);
    assert_memory_equal(b->scene[0]->origin, b->scene[1]->origin, sizeof b->scene[0]->origin);
}

static void tear_down(bench *b)
{
    for (int i = 0; i < 2; i++) {
        lf_section_finish(&b->section[i]);
        lf_renderer_destroy(b->renderer[i]);
        lf_scene_unref(b->scene[i]);
    }
}

/* by_rays: the first of them answers by rays. */
static void cut(bench *b, int row, lf_cut_what what, bool by_rays)
{
    const float lens[2] = {(float)next_number(&b->random), (float)next_number(&b->random)};
    lf_rig_row_plane(rig_of(b), (float)row + (float)next_number(&b->random), lens, &b->plane);
    for (int i = 0; i < 2; i++)
        lf_section_cut(&b->section[i], lists(b, i), b->scene[i], rig_of(b), row, &b->plane, what);
    b->section[0].rays.on = by_rays;
}

/* Views whose frame holds p. */
static void look(const bench *b, float lx, lf_vec3 p, float *c, float *scale)
{
    const lf_rig *rig = rig_of(b);
    lf_vec3 d = lf_sub(p, rig->eye);
    float x = lf_dot(d, rig->right), z = lf_dot(d, rig->forward);
    for (int k = 0; k < LF_MAX_LANES; k++) {
        c[k] = rig->b[k] + lx;
        float u = (rig->skew[k] + lx * rig->distance / rig->focus + rig->distance * (x - c[k]) / z -
                   rig->x0) /
                  rig->dx;
        scale[k] = k < rig->n_views && u >= 0.0f && u < (float)width ? 1.0f : 0.0f;
    }
}

static lf_row_cut cut_of(const bench *b, int i)
{
    return (lf_row_cut){&b->section[i], lists(b, i), b->scene[i], rig_of(b), &b->plane};
}

typedef struct tally {
    int asked, hidden, wrong;
} tally;

static void ask(bench *b, float lx, lf_vec3 p, const lf_hit *on, bool alphas, tally *t)
{
    float c[LF_MAX_LANES], scale[2][LF_MAX_LANES];
    for (int i = 0; i < 2; i++) {
        look(b, lx, p, c, scale[i]);
        const lf_row_cut of = cut_of(b, i);
        if (alphas)
            lf_alphas_before(&of, p, on ? &on[i] : NULL, 48, c, scale[i]);
        else
            lf_section_hide(&of, p, on ? &on[i] : NULL, 48, c, scale[i]);
    }
    look(b, lx, p, c, c);
    for (int k = 0; k < rig_of(b)->n_views; k++) {
        t->asked += c[k] > 0.0f;
        t->hidden += c[k] > 0.0f && scale[1][k] < 1.0f;
        t->wrong += fabsf(scale[0][k] - scale[1][k]) > 1e-3f;
    }
}

/* Points of base rays, on surfaces and on the way there. */
static tally hide(bench *b, lf_cut_what what, bool by_rays)
{
    const lf_rig *rig = rig_of(b);
    tally t = {0};
    for (int row = 0; row < height; row++) {
        cut(b, row, what, by_rays);
        for (int i = 0; i < 40; i++) {
            int view = (int)(next_number(&b->random) * rig->n_views);
            float lx = (2.0f * (float)next_number(&b->random) - 1.0f) * b->plane.lens_chord,
                  xw = rig->x0 + (float)next_number(&b->random) * (float)width * rig->dx;
            lf_vec3 eye = lf_rig_point(rig, rig->b[view] + lx, b->plane.ly, 0.0f),
                    w = lf_rig_direction(rig,
                                         (xw - rig->skew[view]) / rig->distance - lx / rig->focus,
                                         b->plane.my, 1.0f);
            lf_hit hit[2];
            bool found = lf_trace_next(&b->tracer[0], eye, w, 0.0f, INFINITY, &hit[0]) &&
                         lf_trace_next(&b->tracer[1], eye, w, 0.0f, INFINITY, &hit[1]) &&
                         same_place(b->scene[0], &hit[0], b->scene[1], &hit[1]);
            if (found)
                ask(b, lx, hit[0].p, hit, what == LF_CUT_ALPHAS, &t);
            float share = (float)next_number(&b->random);
            ask(b, lx, lf_madd(eye, share * (found ? hit[0].t : 2.0f * rig->distance), w), NULL,
                what == LF_CUT_ALPHAS, &t);
        }
    }
    return t;
}

/* Fans of all views; how many rays find something else. */
static tally fans(bench *b, bool by_rays)
{
    const lf_rig *rig = rig_of(b);
    tally t = {0};
    for (int i = 0; i < 20 * height; i++) {
        float c[LF_MAX_LANES], z[2][LF_MAX_LANES];
        int segment[2][LF_MAX_LANES];
        if (i % 20 == 0)
            cut(b, i / 20, LF_CUT_ALL, by_rays);
        float lx = (2.0f * (float)next_number(&b->random) - 1.0f) * b->plane.lens_chord,
              xw = rig->x0 + (float)next_number(&b->random) * (float)width * rig->dx;
        for (int k = 0; k < LF_MAX_LANES; k++)
            c[k] = rig->b[k] + lx;
        const lf_row_cut of[2] = {cut_of(b, 0), cut_of(b, 1)};
        const lf_lines lines = {xw / rig->distance + lx * (1.0f / rig->window - 1.0f / rig->focus),
                                48, c};
        for (int j = 0; j < 2; j++)
            lf_section_nearest(&of[j], &lines, z[j], segment[j]);
        for (int k = 0; k < rig->n_views; k++) {
            t.asked++;
            t.hidden += segment[1][k] >= 0;
            bool same = (segment[0][k] < 0) == (segment[1][k] < 0);
            if (same && segment[0][k] >= 0) {
                lf_face face[2];
                for (int j = 0; j < 2; j++)
                    lf_section_face(&of[j], segment[j][k], &face[j]);
                same = fabsf(z[0][k] - z[1][k]) <= 1e-4f * z[1][k] &&
                       face[0].triangle == face[1].triangle &&
                       face[1].mesh ==
                           &b->scene[1]->meshes[face[0].mesh->instances ? 1 + face[0].place : 0] &&
                       lf_length(lf_sub(face[0].n, face[1].n)) < 1e-4f &&
                       lf_section_material(&b->section[0], segment[0][k]) ==
                           lf_section_material(&b->section[1], segment[1][k]);
            }
            t.wrong += !same;
        }
    }
    return t;
}

static void assert_same(const char *what, const tally *t)
{
    if (t->wrong > t->asked / 1000)
        fail_msg("%s: of %d answers %d are others", what, t->asked, t->wrong);
    assert_true(t->asked > 10000 && t->hidden > t->asked / 50 && t->hidden < t->asked);
}

static void rows_find_what_they_find_in_copies(void **state)
{
    (void)state;
    static const char *const more[] = {PART, PART ", 'lens_radius': 0.1, 'focus_distance': 4",
                                       PART ", 'view_blur': 1", PART};
    for (int i = 0; i < 8; i++) {
        bench b;
        set_up(&b, "glaze", 0.0, i < 6 ? "45" : "{ 'track': { 'count': 45, 'length': 3 } }",
               more[i / 2]);
        tally t = hide(&b, LF_CUT_ALL, i % 2);
        assert_same(i % 2 ? "hidden, by rays" : "hidden", &t);
        t = fans(&b, i % 2);
        assert_same(i % 2 ? "nearest, by rays" : "nearest", &t);
        tear_down(&b);
    }
}

static void alphas_let_through_what_copies_do(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        bench b;
        set_up(&b, "pane", 0.0, "45", ALL);
        tally t = hide(&b, LF_CUT_ALPHAS, i);
        assert_same(i ? "veils, by rays" : "veils", &t);
        tear_down(&b);
    }
}

/* Whether the veils of a ray lie one behind the other, before z, and let this through. */
static bool let_through(const lf_alpha_crossings *ray, float z, float whole)
{
    float passed = 1.0f;
    bool is_in_order = true;
    for (int i = 0; i < ray->n; i++) {
        passed *= ray->passes[i];
        is_in_order = is_in_order && ray->z[i] < z && (i == 0 || ray->z[i] > ray->z[i - 1]);
    }
    return is_in_order && (ray->known < z || fabsf(whole - passed) <= 1e-5f);
}

/* Depths that rise, of rays of their own: what is counted on the way from one to the next is what
 * is counted up to each. */
static tally among_alphas(bench *b, bool by_rays)
{
    const lf_rig *rig = rig_of(b);
    static lf_alpha_walk walk;
    static lf_alpha_crossings kept[LF_MAX_LANES];
    tally t = {0};
    for (int i = 0; i < 4 * height; i++) {
        float c[LF_MAX_LANES], z[LF_MAX_LANES], end[LF_MAX_LANES], passed[LF_MAX_LANES];
        bool mirrors[LF_MAX_LANES] = {false};
        if (i % 4 == 0)
            cut(b, i / 4, LF_CUT_ALPHAS, by_rays);
        float s0 = rig->x0 + (float)next_number(&b->random) * (float)width * rig->dx;
        const lf_row_cut of = cut_of(b, 0);
        const lf_lines lines = {s0 / rig->distance, 48, c};
        for (int k = 0; k < 48; k++) {
            c[k] = rig->b[k < rig->n_views ? k : rig->n_views - 1];
            end[k] = (0.5f + (float)next_number(&b->random)) * rig->distance;
            passed[k] = 1.0f;
        }
        lf_alphas_begin(&walk, &of, &lines, end);
        for (int step = 1; step <= 20; step++) {
            if (step == 11) {
                lf_alphas_rewind(&walk);
                for (int k = 0; k < 48; k++)
                    passed[k] = 1.0f;
            }
            float whole[LF_MAX_LANES];
            for (int k = 0; k < 48; k++) {
                z[k] = end[k] * (float)(step % 11 + step / 11) / 10.0f;
                whole[k] = 1.0f;
            }
            lf_alphas_to(&walk, z, passed);
            lf_alphas_along(&of, &lines, z, whole, mirrors, step % 2 ? kept : NULL);
            for (int k = 0; k < rig->n_views; k++) {
                t.asked++;
                t.hidden += whole[k] < 1.0f;
                t.wrong += fabsf(whole[k] - passed[k]) > 1e-5f;
                t.wrong += step % 2 && !let_through(&kept[k], z[k], whole[k]);
            }
        }
    }
    return t;
}

static void alphas_are_counted_on_the_way(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        bench b;
        set_up(&b, "pane", 0.0, "45", ALL);
        tally t = among_alphas(&b, i);
        assert_same(i ? "veils on the way, by rays" : "veils on the way", &t);
        tear_down(&b);
    }
}

static void a_place_that_is_moved_is_found_out(void **state)
{
    (void)state;
    bench b;
    set_up(&b, "glaze", 0.05, "45", ALL);
    tally t = hide(&b, LF_CUT_ALL, false);
    assert_true(t.wrong > t.asked / 500);
    t = fans(&b, false);
    assert_true(t.wrong > t.asked / 500);
    tear_down(&b);
}

/* Hundreds of small cubes, most of them beside what the views see: none that a ray meets is left
 * out, be it before the window or behind it, to the left or to the right. */
static void what_is_beside_the_views_is_left_out_and_nothing_else(void **state)
{
    (void)state;
    enum { many = 1500 };
    static char text[1 << 17];
    uint64_t random = 17;
    char *at = text, *end = text + sizeof text;
    at += snprintf(at, (size_t)(end - at),
                   "{ 'quiltd': 1, 'camera': { 'position': [0, 0.6, 5], 'aspect': 1.3333333333, "
                   "'views': 9, 'cone': 40, 'lens_radius': 0.4, 'focus_distance': 5.5, 'fov_y': 9 "
                   "}, 'meshes': { 'a': { 'shape': 'cube', 'instances': [");
    for (int k = 0; k < many; k++) {
        double x = 5 * next_number(&random) - 2.5, y = 2 * next_number(&random) - 1;
        at +=
            snprintf(at, (size_t)(end - at), "%s{ 'scale': 0.03, 'translate': [%.5f, %.5f, %.5f] }",
                     k > 0 ? ", " : "", x, y, 7 * next_number(&random) - 4);
    }
    snprintf(at, (size_t)(end - at), "] } } }");
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    const lf_row_triangles *rows = &lf_test_rows(r)->triangles;
    const lf_rig *rig = &lf_test_rows(r)->rig;
    lf_tracer tracer = {.scene = scene};
    lf_section section;
    lf_row_plane plane;
    int wrong = 0, found = 0;
    size_t most = 0;
    lf_assert_ok(lf_section_init(&section, rows->longest, rows->n_instances), NULL);
    for (int i = 0; i < 60 * height; i++) {
        float c[LF_MAX_LANES], z[LF_MAX_LANES];
        int segment[LF_MAX_LANES];
        if (i % 60 == 0) {
            const float lens[2] = {0.5f, (float)next_number(&random)};
            lf_rig_row_plane(rig, (float)(i / 60) + 0.5f, lens, &plane);
            lf_section_cut(&section, rows, scene, rig, i / 60, &plane, LF_CUT_ALL);
            most = section.places.n > most ? section.places.n : most;
        }
        float lx = (2.0f * (float)next_number(&random) - 1.0f) * plane.lens_chord,
              xw = rig->x0 + (float)next_number(&random) * (float)width * rig->dx;
        for (int k = 0; k < LF_MAX_LANES; k++)
            c[k] = rig->b[k] + lx;
        const lf_row_cut of = {&section, rows, scene, rig, &plane};
        const lf_lines lines = {xw / rig->distance + lx * (1.0f / rig->window - 1.0f / rig->focus),
                                16, c};
        lf_section_nearest(&of, &lines, z, segment);
        for (int k = 0; k < rig->n_views; k++) {
            lf_vec3 o = lf_rig_point(rig, c[k], plane.ly, 0.0f),
                    w = lf_rig_direction(rig, (xw - rig->skew[k]) / rig->distance - lx / rig->focus,
                                         plane.my, 1.0f);
            lf_hit hit;
            bool met = lf_trace_next(&tracer, o, w, 0.0f, INFINITY, &hit);
            found += met;
            wrong += met != (segment[k] >= 0) || (met && fabsf(z[k] - hit.t) > 1e-4f * hit.t);
        }
    }
    if (wrong > found / 1000 || found < 3000)
        fail_msg("%d of %d are others", wrong, found);
    assert_true(most < many / 10);
    lf_section_finish(&section);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* ---------------------------------------------------------------------------------- pictures -- */

static void schedule(lf_renderer *r)
{
    lf_test_passes(r, 6 * views);
}

static void pictures(const char *material, bool copies, double moved, const char *integrator,
                     uint64_t seed, lf_blocks *out)
{
    lf_test_pictures_of(scene_of("cube", material, copies, moved, "3", ALL), integrator, width,
                        height, schedule, seed, tile, out);
}

/* Instances shared between views against copies that each view sees alone. */
static void pictures_are_those_of_copies(void **state)
{
    (void)state;
    static const char *const materials[] = {"glaze", "pane"};
    for (int i = 0; i < 2; i++) {
        lf_blocks truth, mine;
        int where = 0;
        pictures(materials[i], true, 0.0, "vpt", 1000, &truth);
        pictures(materials[i], false, 0.0, "mvpt", 2000, &mine);
        double p = lf_blocks_welch(&mine, &truth, &where);
        if (!(p > lf_sidak(LF_FALSE_ALARM, 2 * truth.n)))
            fail_msg("%s, block %d: %.5g +- %.2g, copies %.5g +- %.2g, p %.2g", materials[i], where,
                     mine.moments[where].mean, lf_moments_error(&mine.moments[where]),
                     truth.moments[where].mean, lf_moments_error(&truth.moments[where]), p);
        lf_blocks_finish(&mine);
        if (i == 0) {
            pictures(materials[i], false, 0.15, "mvpt", 3000, &mine);
            assert_true(lf_blocks_welch(&mine, &truth, &where) < CERTAIN);
            lf_blocks_finish(&mine);
        }
        lf_blocks_finish(&truth);
    }
}

static void lights_are_copies(void **state)
{
    (void)state;
    lf_scene *instances = scene_of("sphere", "glow", false, 0.0, "3", ALL),
             *copies = scene_of("sphere", "glow", true, 0.0, "3", ALL);
    double area[2] = {0};
    for (int i = 0; i < instances->n_lights; i++)
        area[0] += (double)instances->lights[i].area;
    for (int i = 0; i < copies->n_lights; i++)
        area[1] += (double)copies->lights[i].area;
    assert_false(lf_has(instances, LF_TRAIT_INSTANCES));
    assert_int_equal(instances->meshes[1].n_triangles, n_instances * copies->meshes[1].n_triangles);
    lf_assert_close(area[0], area[1], 1e-5, 0.0);
    lf_scene_unref(instances);
    lf_scene_unref(copies);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_find_what_they_find_in_copies),
        cmocka_unit_test(rays_leave_the_place_that_they_come_from),
        cmocka_unit_test(rows_find_what_they_find_in_copies),
        cmocka_unit_test(alphas_let_through_what_copies_do),
        cmocka_unit_test(alphas_are_counted_on_the_way),
        cmocka_unit_test(a_place_that_is_moved_is_found_out),
        cmocka_unit_test(what_is_beside_the_views_is_left_out_and_nothing_else),
        cmocka_unit_test(pictures_are_those_of_copies),
        cmocka_unit_test(lights_are_copies),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
