/* Subsurface scattering: a half-space by Chandrasekhar's H function, furnaces, a cube against a
 * walk that shares no code with it, very short mean free paths against diffuse surfaces, and mvpt
 * against vpt. */
#include "tests/testing.h"

#include "render/transport/path/subsurface.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/h_function.h"

enum { width = 32, height = 24, n_views = 3, tile = 8, blocks_of_all = n_views * 12 + 1 };
#define LEVEL lf_sidak(LF_FALSE_ALARM, 2 * blocks_of_all)
#define CERTAIN 1e-9

static void albedos_are_those_of_a_half_space(void **state)
{
    (void)state;
    double worst = 0;
    for (int i = 0; i <= 50; i++) {
        lf_h_function h;
        float albedo = (float)i / 50, single = lf_subsurface_albedo(albedo, 0.0f);
        lf_h_make(&h, (double)single);
        worst = fmax(worst, fabs(lf_h_spherical_albedo(&h) - (double)albedo));
    }
    print_message("albedo off by %.5f at most\n", worst);
    assert_true(worst < 2.5e-3);
    lf_assert_close(lf_subsurface_albedo(1.0f, 0.5f), 1, 0, 1e-6);
    lf_assert_close(lf_subsurface_albedo(0.0f, 0.5f), 0, 0, 1e-6);
}

/* What a path that meets the body of a scene at o, along w, brings back, and the channels' mean. */
static void radiance(lf_scene *scene, lf_vec3 o, lf_vec3 w, int n, uint64_t salt, lf_moments out[4])
{
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed() + salt};
    lf_event event = {.kind = LF_EVENT_SURFACE, .w = w};
    assert_true(lf_trace_surface(&tracer, o, w, INFINITY, &event.hit));
    event.p = event.hit.p;
    memset(out, 0, 4 * sizeof *out);
    for (int i = 0; i < n; i++) {
        lf_vec3 l = lf_path_scattered(&tracer, &event, 1, 16);
        const float channel[3] = {l.x, l.y, l.z};
        for (int c = 0; c < 3; c++)
            lf_moments_add(&out[c], (double)channel[c]);
        lf_moments_add(&out[3], (double)(l.x + l.y + l.z) / 3);
    }
    for (int c = 0; c < 4; c++)
        print_message("%.4f +- %.4f ", out[c].mean, lf_moments_error(&out[c]));
    print_message("\n");
}

/* off: what else it may be off by, and the most that its standard error may be. */
static void expect(const lf_moments *m, double truth, double off, double error)
{
    lf_assert_close(m->mean, truth, off, 5.0 * lf_moments_error(m));
    assert_true(lf_moments_error(m) < error * truth);
}

#define SKY "'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }"

/* A face of a cube 2000 wide, whose channels walk 100 times as far as each other: each gives back
 * what the H function says of its own single-scattering albedo. */
static void a_half_space_gives_back_what_its_h_function_says(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{ 'meshes': { 'ground': { 'shape': 'cube', 'material': 'flesh', 'transform': { 'scale': "
        "1000 } } }, 'materials': { 'flesh': { 'type': 'principled', 'specular': 0, 'subsurface': "
        "1, 'albedo': [0.8, 0.5, 0.3], 'subsurface_radius': [5, 0.5, 0.05] } }, " SKY " }");
    lf_moments m[4];
    static const float albedo[3] = {0.8f, 0.5f, 0.3f};
    radiance(scene, lf_v3(0.2f, 0.3f, 2000.0f), lf_v3(0.0f, 0.0f, -1.0f), 60000, 1, m);
    for (int c = 0; c < 3; c++) {
        lf_h_function h;
        lf_h_make(&h, (double)lf_subsurface_albedo(albedo[c], 0.0f));
        expect(&m[c], lf_h_spherical_albedo(&h), 1e-4, 1e-2);
    }
    lf_scene_unref(scene);
}

/* White bodies, with whatever lies above or inside them, stones or lamps as bright as the sky, are
 * not seen under it. */
static void white_bodies_are_not_seen_under_an_even_sky(void **state)
{
    (void)state;
    static const char *const more[] = {
        "'specular': 0, 'subsurface_radius': 0.3", "'subsurface_radius': [0.03, 0.3, 3]",
        "'subsurface_radius': [0.2, 0.5, 2], 'g': 0.8, 'roughness': 0.05, 'coat': 1, "
        "'coat_roughness': 0.3",
        "'subsurface_radius': 0.3, 'roughness': 0, 'metallic': 0.3, 'sheen': 0.4"};
    for (size_t i = 0; i < sizeof more / sizeof *more; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_patched(
            "white-bodies", "{'materials': {'stone': {%s}, 'flesh': {'subsurface': %s, %s}}}",
            i % 2 ? "'albedo': 0, 'emission': 1" : "'albedo': 1", i == 1 ? "0.6" : "1", more[i]));
        lf_moments m[4];
        radiance(scene, lf_v3(0.2f, 0.3f, 4.0f), lf_v3(0.0f, 0.0f, -1.0f), 8000, 2 + i, m);
        for (int c = 0; c < 4; c++)
            expect(&m[c], 1, 5e-3, c < 3 ? 0.02 : 3e-3);
        lf_scene_unref(scene);
    }
}

/* ------------------------------------------------------------------------------- brute force -- */

/* One grey channel in the cube [-1, 1]^3, in double. */
typedef struct walker {
    uint64_t state;
    double p[3], w[3];
} walker;

static double uniform(walker *k)
{
    k->state ^= k->state << 13; /* Marsaglia 2003 */
    k->state ^= k->state >> 7;
    k->state ^= k->state << 17;
    return ((double)(k->state >> 11) + 0.5) * 0x1p-53;
}

static void turn(walker *k, double cosine)
{
    double phi = 2 * M_PI * uniform(k), sine = sqrt(fmax(1 - cosine * cosine, 0)), *w = k->w;
    double flat = hypot(w[0], w[1]), x = sine * cos(phi), y = sine * sin(phi), w0 = w[0], w1 = w[1],
           w2 = w[2];
    if (flat < 1e-9) {
        w[0] = x;
        w[1] = y;
        w[2] = copysign(cosine, w2);
        return;
    }
    w[0] = cosine * w0 + (x * w0 * w2 - y * w1) / flat;
    w[1] = cosine * w1 + (x * w1 * w2 + y * w0) / flat;
    w[2] = cosine * w2 - x * flat;
}

/* How far it is to a face, and which: axis, or axis + 3 on the upper side. */
static double way_out(const walker *k, int *face)
{
    double nearest = INFINITY;
    for (int i = 0; i < 3; i++) {
        double t = ((k->w[i] > 0 ? 1 : -1) - k->p[i]) / k->w[i];
        if (k->w[i] != 0 && t < nearest) {
            nearest = t;
            *face = i + 3 * (k->w[i] > 0);
        }
    }
    return nearest;
}

/* Irradiance at each face of what walks in at (0.3, -0.2) of the upper z face: by Henyey and
 * Greenstein's phase function, weighed by albedo^n. */
static double walked(walker *k, double radius, double albedo, double g, const double light[6])
{
    double weight = 1, start[3] = {0.3, -0.2, 1}, in[3] = {0, 0, -1};
    memcpy(k->p, start, sizeof start);
    memcpy(k->w, in, sizeof in);
    turn(k, sqrt(uniform(k)));
    for (;;) {
        int face = 0;
        double way = -log(uniform(k)) * radius, out = way_out(k, &face);
        if (way >= out)
            return weight * light[face];
        for (int i = 0; i < 3; i++)
            k->p[i] += way * k->w[i];
        weight *= albedo;
        double s = (1 - g * g) / (1 - g + 2 * g * uniform(k));
        turn(k, (1 + g * g - s * s) / (2 * g));
    }
}

static void a_cube_is_what_a_plain_walk_finds(void **state)
{
    (void)state;
    enum { N = 60000 };
    static const double albedo[3] = {0.9, 0.6, 0.95}, radius[3] = {1, 0.4, 0.2}, g = 0.4;
    /* radiosity of suns along -x and -z, of 1 and 2, and -y 0.5: over pi */
    const double light[6] = {0, 0, 0, 1 / M_PI, 0.5 / M_PI, 2 / M_PI};
    lf_scene *scene = lf_test_scene(lf_test_scene_text("subsurface-cube-in-suns"));
    lf_moments m[4];
    radiance(scene, lf_v3(0.3f, -0.2f, 4.0f), lf_v3(0.0f, 0.0f, -1.0f), N, 9, m);
    walker k = {.state = lf_test_seed() | 1};
    for (int c = 0; c < 3; c++) {
        lf_moments truth = {0}, wrong = {0};
        double single = (double)lf_subsurface_albedo((float)albedo[c], (float)g);
        for (int i = 0; i < N; i++)
            lf_moments_add(&truth, walked(&k, radius[c], single, g, light));
        for (int i = 0; i < N; i++)
            lf_moments_add(&wrong, walked(&k, 1.2 * radius[c], single, g, light));
        double p = lf_p_welch(&m[c], &truth);
        print_message("%.4f, brute force %.4f +- %.4f, p %.2g\n", m[c].mean, truth.mean,
                      lf_moments_error(&truth), p);
        assert_true(p > lf_sidak(LF_FALSE_ALARM, 3));
        assert_true(c > 0 || lf_p_welch(&m[c], &wrong) < 1e-6);
    }
    lf_scene_unref(scene);
}

/* ---------------------------------------------------------------------------------- pictures -- */

static void schedule(lf_renderer *r)
{
    lf_test_passes(r, 6 * n_views);
}

static void pictures(const char *text, const char *integrator, uint64_t seed, lf_blocks *out)
{
    lf_test_pictures_of(lf_test_scene(text), integrator, width, height, schedule, seed, tile, out);
}

/* The cube, with more words about its material. */
static const char *cube_of(const char *more)
{
    return lf_test_scene_patched("subsurface-cube", "{'materials': {'flesh': {%s}}}", more);
}

static void short_ways_are_a_diffuse_surface(void **state)
{
    (void)state;
    lf_blocks near, diffuse, far;
    pictures(cube_of("'subsurface': 1, 'subsurface_radius': 0.002"), "mvpt", 1, &near);
    pictures(lf_test_scene_text("subsurface-cube"), "mvpt", 2, &diffuse);
    pictures(cube_of("'subsurface': 1, 'subsurface_radius': 0.2"), "mvpt", 3, &far);
    const lf_moments *a = &near.moments[near.n - 1], *b = &diffuse.moments[diffuse.n - 1];
    print_message("%.5f +- %.5f, diffuse %.5f +- %.5f\n", a->mean, lf_moments_error(a), b->mean,
                  lf_moments_error(b));
    lf_assert_close(a->mean, b->mean, 3e-3, 4 * (lf_moments_error(a) + lf_moments_error(b)));
    for (int i = 0; i < near.n; i++)
        lf_assert_close(
            near.moments[i].mean, diffuse.moments[i].mean, 1e-2,
            5 * (lf_moments_error(&near.moments[i]) + lf_moments_error(&diffuse.moments[i])));
    assert_true(lf_blocks_welch(&far, &diffuse, NULL) < CERTAIN);
    lf_blocks_finish(&near);
    lf_blocks_finish(&diffuse);
    lf_blocks_finish(&far);
}

static void views_share_what_walks_in_subsurface(void **state)
{
    (void)state;
    lf_blocks one, all, wrong;
    int where = 0;
    pictures(lf_test_scene_text("subsurface-body"), "vpt", 11, &one);
    pictures(lf_test_scene_text("subsurface-body"), "mvpt", 12, &all);
    pictures(cube_of("'subsurface': 0.8, 'subsurface_radius': 0.3"), "mvpt", 13, &wrong);
    double p = lf_blocks_welch(&one, &all, &where);
    const lf_moments *a = &one.moments[where], *b = &all.moments[where];
    print_message("block %d: %.5f +- %.5f, shared %.5f +- %.5f, p %.2g\n", where, a->mean,
                  lf_moments_error(a), b->mean, lf_moments_error(b), p);
    assert_true(p > LEVEL);
    assert_true(lf_blocks_welch(&one, &wrong, NULL) < CERTAIN);
    lf_blocks_finish(&one);
    lf_blocks_finish(&all);
    lf_blocks_finish(&wrong);
    lf_test_assert_weights(lf_test_scene_text("subsurface-body"), width, height, schedule, 8, tile,
                           LEVEL);
}

/* ---------------------------------------------------------------------------------- warnings -- */

static int warnings_of(const char *shape, const char *transform)
{
    char text[1024];
    int n = 0;
    snprintf(text, sizeof text,
             "{ 'meshes': { 'body': { 'shape': '%s', 'material': 'flesh', 'transform': { %s } } }, "
             "'materials': { 'flesh': { 'type': 'principled', 'subsurface': 1 } }, " SKY " }",
             shape, transform);
    lf_scene *scene = lf_test_scene(text);
    for (; lf_scene_warning(scene, n); n++)
        print_message("%s\n", lf_scene_warning(scene, n));
    lf_scene_unref(scene);
    return n;
}

static void open_meshes_are_told(void **state)
{
    (void)state;
    assert_int_equal(warnings_of("quad", "'scale': 1"), 1);
    assert_int_equal(warnings_of("disk", "'scale': 1"), 1);
    assert_int_equal(warnings_of("cube", "'scale': 1"), 0);
    assert_int_equal(warnings_of("cube", "'scale': [-1, 1, 1], 'rotate': [10, 20, 30]"), 0);
    assert_int_equal(warnings_of("sphere", "'scale': [0.3, 1, 2], 'translate': [0.1, 0, 7]"), 0);
}

static void what_lets_light_through_has_no_subsurface(void **state)
{
    (void)state;
    lf_test_assert_refused(".",
                           "{'materials': {'m': {'type': 'principled', 'subsurface': 1, "
                           "'transmission': 0.5}}}",
                           "/materials/m/subsurface", "not both");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedos_are_those_of_a_half_space),
        cmocka_unit_test(a_half_space_gives_back_what_its_h_function_says),
        cmocka_unit_test(white_bodies_are_not_seen_under_an_even_sky),
        cmocka_unit_test(a_cube_is_what_a_plain_walk_finds),
        cmocka_unit_test(short_ways_are_a_diffuse_surface),
        cmocka_unit_test(views_share_what_walks_in_subsurface),
        cmocka_unit_test(open_meshes_are_told),
        cmocka_unit_test(what_lets_light_through_has_no_subsurface),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
