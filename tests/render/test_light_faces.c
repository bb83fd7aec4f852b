/* Rectangles, disks and balls that shine: closed forms of what arrives from them, the same scenes
 * with meshes in their place, their backs, and looking through those that are hidden. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/scene/geometry.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/path/path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { side = 24, n_views = 5, values = 3 * n_views * side * side };

/* ------------------------------------------------------------------------------ closed forms -- */

static float fraction(double x)
{
    return fminf((float)(x - floor(x)), 0x1.fffffep-1f);
}

/* Irradiance of a plane with normal +y at p, by points even in the three numbers that are drawn (a
 * lattice of powers of the root of x^4 = x + 1); *out_spread (may be NULL): relative variance of a
 * draw. */
static double irradiance(const lf_scene *scene, const double p[3], double *out_spread)
{
    enum { POINTS = 1 << 18 };
    double sum = 0.0, squares = 0.0;
    const lf_vec3 at = lf_v3((float)(p[0] - scene->origin[0]), (float)(p[1] - scene->origin[1]),
                             (float)(p[2] - scene->origin[2]));
    for (int i = 0; i < POINTS; i++) {
        const float u[3] = {fraction((i + 0.5) * 0.8191725133961645),
                            fraction((i + 0.5) * 0.6710436067037893),
                            fraction((i + 0.5) * 0.5497004779019703)};
        lf_light_sample s;
        if (!lf_light_draw(scene, at, u, &s) || !(s.wi.y > 0.0f))
            continue;
        double x = (double)(s.radiance.x * s.wi.y / s.pdf);
        sum += x;
        squares += x * x;
    }
    if (out_spread)
        *out_spread = squares * POINTS / (sum * sum) - 1.0;
    return sum / POINTS;
}

static void cross_of(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot_of(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Lambert (1760): irradiance from a polygon of radiance 1 that lies above the plane. */
static double polygon(double corner[][3], int n, const double p[3])
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        double a[3], b[3], c[3];
        for (int k = 0; k < 3; k++) {
            a[k] = corner[i][k] - p[k];
            b[k] = corner[(i + 1) % n][k] - p[k];
        }
        cross_of(a, b, c);
        double length = sqrt(dot_of(c, c));
        sum += atan2(length, dot_of(a, b)) * c[1] / length;
    }
    return fabs(0.5 * sum);
}

/* The corners of a rectangle as docs/reference/scene-format.md says, for directions that are not
 * vertical. */
static void corners_of(const double centre[3], const double direction[3], double width,
                       double height, double degrees, double out[4][3])
{
    double length = sqrt(dot_of(direction, direction)), up[3], across[3], d[3];
    for (int i = 0; i < 3; i++)
        d[i] = direction[i] / length;
    for (int i = 0; i < 3; i++)
        up[i] = (i == 1) - d[1] * d[i];
    length = sqrt(dot_of(up, up));
    for (int i = 0; i < 3; i++)
        up[i] /= length;
    cross_of(up, d, across);
    double c = cos(degrees * M_PI / 180.0), s = sin(degrees * M_PI / 180.0);
    for (int i = 0; i < 4; i++) {
        double x = (i == 1 || i == 2 ? 0.5 : -0.5) * width, y = (i > 1 ? 0.5 : -0.5) * height;
        for (int k = 0; k < 3; k++)
            out[i][k] =
                centre[k] + x * (c * across[k] + s * up[k]) + y * (c * up[k] - s * across[k]);
    }
}

static void a_plane_gets_from_a_rectangle_what_lamberts_formula_says(void **state)
{
    (void)state;
    static const struct {
        double position[3], direction[3], width, height, rotate;
    } cases[] = {{{0, 3, 0}, {0.2, -1, 0.1}, 1, 2, 0},
                 {{1, 2, -1}, {-1, -0.7, 0.5}, 0.5, 3, 35},
                 {{0, 1, 0}, {0.05, -1, 0}, 6, 2, -70},
                 {{-3, 1.5, 2}, {3, -1, -2}, 1.2, 0.7, 200}};
    static const double points[][3] = {{0, 0, 0}, {0.7, -0.5, -0.4}, {0.3, -2, 0.6}};
    for (int i = 0; i < 4; i++) {
        const double *at = cases[i].position, *d = cases[i].direction;
        char text[512];
        snprintf(text, sizeof text,
                 "{ 'lights': { 'l': { 'type': 'rectangle', 'position': [%g, %g, %g], 'direction': "
                 "[%g, %g, %g], 'width': %g, 'height': %g, 'rotate': %g, 'radiance': 2 } } }",
                 at[0], at[1], at[2], d[0], d[1], d[2], cases[i].width, cases[i].height,
                 cases[i].rotate);
        lf_scene *scene = lf_test_scene(text);
        double corner[4][3], turned[4][3];
        corners_of(at, d, cases[i].width, cases[i].height, cases[i].rotate, corner);
        corners_of(at, d, cases[i].height, cases[i].width, cases[i].rotate, turned);
        for (int k = 0; k < 3; k++) {
            double is = irradiance(scene, points[k], NULL),
                   want = 2.0 * polygon(corner, 4, points[k]);
            lf_assert_close(is, want, 2e-3, 0.0);
            /* A negative control: height for width. */
            if (i == 1)
                assert_true(fabs(2.0 * polygon(turned, 4, points[k]) / want - 1.0) > 4e-3);
        }
        lf_scene_unref(scene);
    }
}

/* pi L r^2 / (r^2 + d^2) on the axis, also right below the disk, and pi L r^2 / d^2 from a ball. */
static void disks_and_balls_give_their_closed_forms(void **state)
{
    (void)state;
    static const double distances[] = {20, 3, 1.2, 0.6};
    for (int i = 0; i < 4; i++) {
        double d = distances[i], r = 0.25, spread;
        char text[512];
        const double origin[3] = {0, 0, 0};
        for (int kind = 0; kind < 4; kind++) {
            const bool ball = kind % 2;
            double area = M_PI * r * r * (ball ? 4 : 1);
            snprintf(text, sizeof text,
                     "{ 'lights': { 'l': { 'type': '%s', 'position': [0, %g, 0], 'radius': %g, "
                     "'%s': %.17g } } }",
                     ball ? "sphere" : "disk", d, r, kind < 2 ? "radiance" : "power",
                     kind < 2 ? 3.0 : 3.0 * M_PI * area);
            lf_scene *scene = lf_test_scene(text);
            double is = irradiance(scene, origin, &spread);
            lf_assert_close(is, 3.0 * M_PI * r * r / (ball ? d * d : r * r + d * d), 2e-3, 0.0);
            assert_true(spread < 0.5);
            /* The negative control: by area half of a ball's points and more are on its far side.
             */
            lf_free(scene->lights[0].tree);
            scene->lights[0].tree = NULL;
            is = irradiance(scene, origin, &spread);
            lf_assert_close(is, 3.0 * M_PI * r * r / (ball ? d * d : r * r + d * d), 5e-3, 0.0);
            assert_true(!ball || spread > 1.5);
            lf_scene_unref(scene);
        }
    }
}

/* What a draw says of its density is what a ray that meets the point is told, from before, beside
 * and within; a tenth off would be seen. */
static void rays_that_meet_a_face_know_how_it_is_drawn(void **state)
{
    (void)state;
    static const char *const types[] = {"'rectangle'", "'disk'", "'sphere'"};
    static const lf_vec3 points[] = {
        {0.1f, -3.0f, 0.2f}, {1.5f, -0.2f, 0.0f}, {0.3f, -1.01f, 0.1f}, {0.0f, -40.0f, 9.0f}};
    int seen = 0;
    for (int i = 0; i < 3; i++) {
        char text[256];
        snprintf(text, sizeof text, "{ 'lights': { 'l': { 'type': %s, 'radiance': 1 } } }",
                 types[i]);
        lf_scene *scene = lf_test_scene(text);
        lf_tracer tracer = {.scene = scene, .rng = 5};
        for (int k = 0; k < 4 * 500; k++) {
            const lf_vec3 p = points[k % 4];
            const float u[3] = {lf_rng(&tracer), lf_rng(&tracer), lf_rng(&tracer)};
            lf_light_sample s;
            float pdf;
            if (!lf_light_draw(scene, p, u, &s))
                continue;
            bool front = lf_dot(s.normal, s.wi) < 0.0f;
            lf_hit hit = {.p = s.point,
                          .ng = front ? s.normal : lf_scale(s.normal, -1.0f),
                          .front = front,
                          .mesh = s.mesh,
                          .triangle = s.triangle,
                          .material = &scene->materials[s.mesh->material]};
            assert_true(front && lf_light_hit(scene, p, &hit, &pdf).x == 1.0f);
            lf_assert_close(pdf, s.pdf, 2e-3, 0.0);
            seen++;
        }
        lf_scene_unref(scene);
    }
    assert_true(seen > 4000);
}

/* Facets are as large as what they stand for, so that power is what is said: of the mesh itself. */
static void facets_lose_no_area(void **state)
{
    (void)state;
    static const char *const types[] = {"disk", "sphere"};
    for (int i = 0; i < 2; i++) {
        char text[256];
        snprintf(text, sizeof text,
                 "{ 'lights': { 'l': { 'type': '%s', 'position': [1, 2, 3], 'radius': 0.5, "
                 "'power': [1, 2, 3] } } }",
                 types[i]);
        lf_scene *scene = lf_test_scene(text);
        const lf_light *light = &scene->lights[0];
        assert_int_equal(scene->n_lights, 1);
        lf_assert_close(light->area, (i ? 4 : 1) * M_PI * 0.25, 1e-6, 0.0);
        lf_assert_close(lf_light_mesh.power(light, 1.0), 2.0, 1e-6, 0.0);
        lf_scene_unref(scene);
    }
}

/* ---------------------------------------------------------------------------------- pictures -- */

static void render(const char *text, const char *integrator, int cycles, float out[values])
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, side, side, NULL);
    lf_test_reseed(r, 11);
    lf_test_cycles(r, cycles);
    assert_int_equal(lf_renderer_fill_holes(r, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, out, NULL), LF_OK);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A lamp that is seen from its front alone. */
static void a_rectangle_is_an_emissive_quad_bit_by_bit(void **state)
{
    (void)state;
    static float rectangle[values], mesh[values], higher[values];
    render(lf_test_scene_text("under-rectangle"), "mvpt", 3, rectangle);
    render(lf_test_scene_patched("under-rectangle",
                                 "{'meshes': {'lamp': {'shape': 'quad', 'material': 'lamp', "
                                 "'transform': {'scale': [0.75, 1, 0.5], 'rotate': [0, 0, 180], "
                                 "'translate': [0.3, 2.5, 0.2]}}}, 'lights': null}"),
           "mvpt", 3, mesh);
    assert_memory_equal(rectangle, mesh, sizeof mesh);
    render(lf_test_scene_patched("under-rectangle",
                                 "{'lights': {'l': {'position': [0.3, 2.6, 0.2]}}}"),
           "mvpt", 3, higher);
    assert_memory_not_equal(rectangle, higher, sizeof mesh);
}

/* Straight before the camera, from before and from behind, and a ball from inside. */
static void only_the_front_shines(void **state)
{
    (void)state;
    static const struct {
        const char *light;
        float want;
    } cases[] = {{"'type': 'rectangle', 'direction': [0, 0, 1], 'width': 4, 'height': 4", 7},
                 {"'type': 'rectangle', 'direction': [0, 0, -1], 'width': 4, 'height': 4", 0},
                 {"'type': 'disk', 'direction': [0, 0, 1], 'radius': 3", 7},
                 {"'type': 'disk', 'direction': [0, 0, -1], 'radius': 3", 0},
                 {"'type': 'sphere', 'radius': 3", 7},
                 {"'type': 'sphere', 'radius': 30", 0}};
    static float picture[values];
    for (int i = 0; i < 6; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "{ 'camera': { 'position': [0, 0, 6], 'fov_y': 6, 'aspect': 1, 'views': 5, "
                 "'cone': 6 }, 'backdrop': 1, 'lights': { 'l': { %s, 'radiance': 7 } } }",
                 cases[i].light);
        render(text, "mvpt", 1, picture);
        for (int k = 0; k < values; k++)
            lf_assert_close(picture[k], (double)cases[i].want, 1e-6, 0.0);
    }
}

/* What it lights on the far side of a closed box: nothing. */
static void a_back_lights_nothing_and_mirrors_show_it_black(void **state)
{
    (void)state;
    static float picture[values];
    static const char *const materials[] = {"'albedo': 1",
                                            "'type': 'conductor', 'albedo': 1, 'roughness': 0",
                                            "'type': 'conductor', 'albedo': 1, 'roughness': 0.5"};
    for (int turned = 0; turned < 2; turned++)
        for (int m = 0; m < 3; m++) {
            const char *text = lf_test_scene_patched(
                "light-above-ground",
                "{'materials': {'m': {%s}}, 'lights': {'l': {'direction': [0, %d, 0]}}}",
                materials[m], turned ? 1 : -1);
            render(text, "mvpt", 2, picture);
            double sum = 0.0;
            for (int k = 0; k < values; k++)
                sum += (double)picture[k] / values;
            assert_true(turned ? sum == 0.0 : sum > 5.0);
        }
}

/* --------------------------------------------------------------------------- looking through -- */

/* The camera looks down through a rectangle at the ground that it lights: albedo / pi times
 * Lambert's formula, in the mean over blocks. Where the rectangle is seen the ground is dark. */
static void the_camera_looks_through_a_hidden_light(void **state)
{
    (void)state;
    enum { replicates = 8, block = 8 };
    static const char *const integrators[] = {"mvpt", "vpt"};
    for (int visible = 0; visible < 2; visible++) {
        const char *text = lf_test_scene_patched(
            "hidden-rectangle", "{'lights': {'l': {'visible': %s}}}", visible ? "true" : "false");
        for (int k = 0; k < 2; k++) {
            lf_scene *scene = lf_test_scene(text);
            lf_renderer *r = lf_test_renderer(scene, integrators[k], side, side, NULL);
            lf_blocks blocks;
            double truth[n_views * side * side],
                corner[4][3] = {{-1.2, 1, -1}, {1.2, 1, -1}, {1.2, 1, 1}, {-1.2, 1, 1}};
            for (int i = 0; i < n_views * side * side; i++) {
                double mx, my;
                lf_test_slopes(r, i / side % n_views, i % side + 0.5, i / side / n_views + 0.5, &mx,
                               &my);
                double b =
                    6.0 * tan(((i / side % n_views + 0.5) / n_views - 0.5) * 20.0 * M_PI / 180.0);
                const double p[3] = {b + 6.0 * mx, 0, -6.0 * my};
                truth[i] = 3.0 * 0.5 / M_PI * polygon(corner, 4, p);
            }
            lf_blocks_init(&blocks, n_views, side, side, block);
            for (int n = 0; n < replicates; n++) {
                lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)n));
                lf_test_cycles(r, 8);
                lf_blocks_add_picture(&blocks, r, LF_ESTIMATOR_MWIS);
            }
            int where = 0;
            double p = lf_blocks_p(&blocks, truth, 1e-3, &where);
            if (visible)
                assert_true(p < 1e-9); /* the negative control: a black back in the way */
            else if (!(p > lf_sidak(LF_FALSE_ALARM, 2 * blocks.n)))
                fail_msg("%s: block %d, p %.2g", integrators[k], where, p);
            lf_blocks_finish(&blocks);
            lf_renderer_destroy(r);
            lf_scene_unref(scene);
        }
    }
}

static void schedule(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

static void views_share_what_is_seen_through_a_hidden_light(void **state)
{
    (void)state;
    lf_test_assert_weights(lf_test_scene_text("behind-hidden-disk"), side, side, schedule, 12, 8,
                           LF_FALSE_ALARM);
    lf_scene *scene = lf_test_scene(lf_test_scene_text("behind-hidden-disk"));
    lf_blocks blocks[2];
    for (int k = 0; k < 2; k++) {
        lf_renderer *r = lf_test_renderer(scene, k ? "vpt" : "mvpt", side, side, NULL);
        lf_test_pictures(r, schedule, LF_ESTIMATOR_MIS, 16, (uint64_t)(20 + k), 8, &blocks[k]);
        lf_renderer_destroy(r);
    }
    int where = 0;
    double level = lf_sidak(LF_FALSE_ALARM, blocks[0].n),
           p = lf_blocks_welch(&blocks[0], &blocks[1], &where);
    if (!(p > level))
        fail_msg("block %d differs, p %.2g", where, p);
    assert_true(lf_blocks_welch_injected(&blocks[0], &blocks[1], blocks[0].n - 1, 1.02) < level);
    for (int k = 0; k < 2; k++)
        lf_blocks_finish(&blocks[k]);
    lf_scene_unref(scene);
}

/* What is beside the picture may be hidden or not. */
static void a_light_out_of_sight_may_as_well_be_hidden(void **state)
{
    (void)state;
    static float seen[values], hidden[values];
#define BESIDE(more)                                                                               \
    lf_test_scene_patched("under-rectangle",                                                       \
                          "{'meshes': {'ball': null}, 'lights': {'l': {'type': 'sphere', "         \
                          "'position': [0, 6, 0], 'width': null, 'height': null, 'radiance': "     \
                          "null, 'radius': 0.5, 'power': 50" more "}}}")
    render(BESIDE(""), "mvpt", 2, seen);
    render(BESIDE(", 'visible': false"), "mvpt", 2, hidden);
    assert_memory_equal(seen, hidden, sizeof seen);
}

/* ------------------------------------------------------------------------------------ scenes -- */

#define SHARED(more)                                                                               \
    "{ 'meshes': { 'm': { 'shape': 'cube' } }, 'lights': { 'p': { 'type': 'point' }, 'l': { "      \
    "'type': 'sphere', 'position': [0, 4, 0], " more " } } }"

static void what_does_not_move_a_face_leaves_the_geometry_shared(void **state)
{
    (void)state;
    lf_scene *first = lf_test_scene(SHARED("'radius': 1, 'radiance': 1")),
             *brighter = lf_test_scene_in(".", SHARED("'radius': 1, 'power': 9"), first),
             *hidden = lf_test_scene_in(".", SHARED("'radius': 1, 'radiance': 1, 'visible': false"),
                                        first),
             *larger = lf_test_scene_in(".", SHARED("'radius': 1.1, 'radiance': 1"), first);
    assert_ptr_equal(first->geometry, brighter->geometry);
    assert_ptr_equal(first->geometry, hidden->geometry);
    assert_ptr_not_equal(first->geometry, larger->geometry);
    assert_true(hidden->meshes[1].hidden && !first->meshes[1].hidden &&
                lf_has(hidden, LF_TRAIT_HIDDEN_MESHES) && !lf_has(first, LF_TRAIT_HIDDEN_MESHES));
    assert_int_equal(first->n_lights, 2);
    lf_assert_close(brighter->lights[1].radiance.x, 9.0 / (4.0 * M_PI * M_PI), 1e-6, 0.0);
    lf_scene_unref(first);
    lf_scene_unref(brighter);
    lf_scene_unref(hidden);
    lf_scene_unref(larger);
}

static void a_light_that_is_too_small_for_its_power_is_refused(void **state)
{
    (void)state;
    lf_scene *scene = NULL;
    lf_error err;
    json_t *doc = json_loads("{\"lights\": {\"l\": {\"type\": \"disk\", \"radius\": 1e-9, "
                             "\"power\": 1}}}",
                             0, NULL);
    assert_int_equal(lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, &err), LF_E_FORMAT);
    assert_string_equal(err.pointer, "/lights/l/power");
    json_decref(doc);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plane_gets_from_a_rectangle_what_lamberts_formula_says),
        cmocka_unit_test(disks_and_balls_give_their_closed_forms),
        cmocka_unit_test(rays_that_meet_a_face_know_how_it_is_drawn),
        cmocka_unit_test(facets_lose_no_area),
        cmocka_unit_test(a_rectangle_is_an_emissive_quad_bit_by_bit),
        cmocka_unit_test(only_the_front_shines),
        cmocka_unit_test(a_back_lights_nothing_and_mirrors_show_it_black),
        cmocka_unit_test(the_camera_looks_through_a_hidden_light),
        cmocka_unit_test(views_share_what_is_seen_through_a_hidden_light),
        cmocka_unit_test(a_light_out_of_sight_may_as_well_be_hidden),
        cmocka_unit_test(what_does_not_move_a_face_leaves_the_geometry_shared),
        cmocka_unit_test(a_light_that_is_too_small_for_its_power_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
