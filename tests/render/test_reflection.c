/* What catchers reflect: against closed forms, against the same floor as an ordinary mesh, and what
 * is not theirs to tell. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { SIDE = 8, VIEWS = 3, PIXELS = SIDE * SIDE * VIEWS };

#define SHINING                                                                                    \
    ", 'lamp': { 'shape': 'cube', 'material': 'shining', 'transform': { 'translate': [0, 6, -6] "  \
    "} }"
#define ASIDE                                                                                      \
    ", 'lamp': { 'shape': 'cube', 'material': 'shining', 'transform': { 'translate': [4, 6, -6] "  \
    "} }"
#define MIRROR "{ 'type': 'conductor', 'albedo': [0.9, 0.5, 0.1], 'roughness': 0 }"
#define PAPER "{ 'albedo': [0.8, 0.4, 0.2] }"
#define GLAZE "{ 'type': 'plastic', 'albedo': 0, 'roughness': 0, 'ior': 1.5 }"

/* The scene of this catcher ("true", "'reflection'") and its material, with more meshes (each
 * behind a comma) and with lights. */
static const char *oblique(const char *what, const char *material, const char *things,
                           const char *lights)
{
    return lf_test_scene_patched(
        "reflection-oblique",
        "{'materials': {'m': %s}, 'meshes': {'ground': {'catcher': %s}%s}, 'lights': {%s}}",
        material, what, things, lights);
}

/* The same, with members of the disk. */
static const char *under(const char *what, const char *material, const char *disk,
                         const char *lights)
{
    return lf_test_scene_patched("reflection-under-disk",
                                 "{'materials': {'m': %s}, 'meshes': {'ground': {'catcher': %s}, "
                                 "'disk': {%s}}, 'lights': {%s}}",
                                 material, what, disk, lights);
}

typedef struct told {
    double least[3], most[3], mean[3];
    double shadow;
} told;

static void tell(const char *text, int cycles, told *out)
{
    static float layers[4 * PIXELS];
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    lf_test_cycles(r, cycles);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_SHADOW | LF_LAYER_REFLECTION,
                                    layers, NULL),
                 NULL);
    *out = (told){{1e9, 1e9, 1e9}, {-1e9, -1e9, -1e9}, {0.0}, 0.0};
    for (int i = 0; i < PIXELS; i++) {
        out->shadow += (double)layers[4 * i] / PIXELS;
        for (int c = 0; c < 3; c++) {
            const double x = (double)layers[4 * i + 1 + c];
            out->least[c] = fmin(out->least[c], x);
            out->most[c] = fmax(out->most[c], x);
            out->mean[c] += x / PIXELS;
        }
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void assert_even(const told *t, const double expected[3], double relative)
{
    for (int c = 0; c < 3; c++) {
        lf_assert_close(t->least[c], expected[c], relative, 0);
        lf_assert_close(t->most[c], expected[c], relative, 0);
    }
}

static void assert_nothing(const told *t)
{
    for (int c = 0; c < 3; c++)
        assert_true(t->least[c] == 0.0 && t->most[c] == 0.0);
}

static double schlick(double r, double cosine)
{
    return r + (1.0 - r) * pow(1.0 - cosine, 5.0);
}

/* Unpolarised, of a dielectric of index 1.5. */
static double fresnel(double cosine)
{
    const double n = 1.5, t = sqrt(1.0 - (1.0 - cosine * cosine) / (n * n)),
                 s = (cosine - n * t) / (cosine + n * t), p = (n * cosine - t) / (n * cosine + t);
    return 0.5 * (s * s + p * p);
}

/* F L where the thing is mirrored, 0 where it is not. Within a pixel's width and the cone's degree
 * cosines differ by 1 %, of which F of glass makes 3 % and Schlick's less. */
static void a_mirror_sends_back_what_it_shows_by_fresnel(void **state)
{
    (void)state;
    const double cosine = M_SQRT1_2;
    const double metal[3] = {schlick(0.9, cosine), 2 * schlick(0.5, cosine),
                             4 * schlick(0.1, cosine)},
                 glaze[3] = {fresnel(cosine), 2 * fresnel(cosine), 4 * fresnel(cosine)};
    told t;
    tell(oblique("'reflection'", MIRROR, SHINING, ""), 1, &t);
    assert_even(&t, metal, 0.002);
    assert_true(t.most[0] - t.least[0] < 1e-3); /* no noise at all */
    tell(oblique("'reflection'", GLAZE, SHINING, ""), 1, &t);
    assert_even(&t, glaze, 0.03);
    for (int c = 0; c < 3; c++)
        lf_assert_close(t.mean[c], glaze[c], 0.003, 0);
    tell(oblique("'reflection'", MIRROR, ASIDE, ""), 4, &t);
    assert_nothing(&t);
    tell(oblique("true", MIRROR, SHINING, ""), 1, &t); /* a negative control: of shadows alone */
    assert_nothing(&t);
    tell(oblique("false", MIRROR, SHINING, ""), 1, &t);
    assert_nothing(&t);
}

/* The form factor of a disk: R^2 / (R^2 + h^2), here of a polygon of 128 corners, whose area is
 * 0.04 % less. */
static void paper_sends_back_albedo_times_form_factor(void **state)
{
    (void)state;
    told t;
    tell(under("'reflection'", PAPER, "'material': 'shining'", ""), 64, &t);
    lf_assert_close(t.mean[0], 0.8 * 0.5 * 1.0, 0.005, 0);
    lf_assert_close(t.mean[1], 0.4 * 0.5 * 2.0, 0.005, 0);
    lf_assert_close(t.mean[2], 0.2 * 0.5 * 4.0, 0.005, 0);
}

/* Light that a thing scatters: what a lamp of the lights sends up to a white disk, 1 / 0.5^2, comes
 * back over pi. The ground's own light is none of it: paths end at the disk, which they reach as
 * their second vertex; with one vertex less there is nothing. */
static void things_are_reflected_as_they_are_lit(void **state)
{
    (void)state;
    for (int depth = 1; depth <= 2; depth++) {
        char lights[128];
        told t;
        snprintf(lights, sizeof lights,
                 "'p': {'type': 'point', 'position': [0, 0.5, 0]}}, 'render': {'max_depth': %d",
                 depth);
        tell(under("'reflection'", "{ 'type': 'conductor', 'albedo': 0.5, 'roughness': 0 }",
                   "'material': 'white'", lights),
             16, &t);
        for (int c = 0; c < 3; c++)
            lf_assert_close(t.mean[c], depth == 2 ? 0.5 * 4.0 / M_PI : 0.0, 0.001, 0);
    }
}

/* The plate and what lights it: sky, suns, lamps of the lights, seen by the camera or not, and
 * other catchers, even such as shine. */
static void what_is_of_the_plate_is_not_reflected(void **state)
{
    (void)state;
    static const char *const materials[] = {MIRROR, PAPER, GLAZE,
                                            "{ 'type': 'plastic', 'roughness': 0.3 }"};
    static const char *const lights[] = {
        "'e': { 'type': 'environment', 'radiance': 1 }",
        "'s': { 'type': 'distant', 'direction': [0, -1, 1], 'angle': 5 }",
        "'r': { 'type': 'rectangle', 'radiance': 1, 'position': [0, 6, -6], "
        "'direction': [0, -1, 1], 'width': 4, 'height': 4 }",
        "'b': { 'type': 'sphere', 'radiance': 1, 'position': [0, 6, -6], 'visible': false }, "
        "'p': { 'type': 'point', 'position': [0, 3, 0] }",
    };
    told t;
    for (int m = 0; m < 4; m++)
        for (int l = 0; l < 4; l++) {
            tell(oblique("'reflection'", materials[m], "", lights[l]), 4, &t);
            assert_nothing(&t);
        }
    for (int i = 0; i < 4; i++) {
        const char *disk = i < 2 ? "'material': 'shining', 'catcher': 'reflection'"
                                 : "'material': 'shining', 'catcher': true";
        /* the camera sees the ground from between the two */
        tell(under("'reflection'", i % 2 ? PAPER : MIRROR, disk, ""), 4, &t);
        assert_nothing(&t);
    }
    tell(under("'reflection'", MIRROR, "'material': 'shining'", ""), 4, &t); /* negative controls */
    lf_assert_close(t.mean[0], 0.9, 1e-4, 0);
    tell(oblique("'reflection'", MIRROR,
                 ", 'card': { 'shape': 'cube', 'material': 'white', "
                 "'transform': { 'translate': [0, 6, -6] } }",
                 "'e': { 'type': 'environment', 'radiance': 1 }"),
         4, &t);
    assert_true(t.least[0] > 0.5);
}

/* Through fog that absorbs alone, 0.5 thick on the way from the camera and 0.5 on the way to what
 * is mirrored, which lies behind the camera. */
static void media_dim_both_ways(void **state)
{
    (void)state;
    told t;
    tell(lf_test_scene_text("reflection-in-fog"), 256, &t);
    lf_assert_close(t.mean[0], 0.5 * 3.0 * exp(-1.0), 0.01, 0);
}

/* A mesh that shines is a thing: of a catcher that reflects, its light is no light of the plate,
 * whose sun the disk hides. */
static void what_is_reflected_is_not_among_the_lights_of_shadows(void **state)
{
    (void)state;
#define SUN_BEHIND "'s': { 'type': 'distant', 'irradiance': 1 }"
    told t;
    tell(under("'reflection'", PAPER, "'material': 'shining'", SUN_BEHIND), 4, &t);
    lf_assert_close(t.shadow, 1.0, 1e-6, 0);
    /* of the lamp (mean of 1, 2, 4) pi / 2, in its light; of the sun 1, in the shade */
    tell(under("true", PAPER, "'material': 'shining'", SUN_BEHIND), 64, &t);
    lf_assert_close(t.shadow, 1.0 / (1.0 + 7.0 / 3.0 * M_PI / 2), 0.01, 0);
    tell(under("'reflection'", PAPER, "'material': 'white'", SUN_BEHIND), 4, &t);
    lf_assert_close(t.shadow, 1.0, 1e-6, 0);
}

/* ----------------------------------------------------------------------- as an ordinary mesh -- */

/* The scene with this catcher, a backdrop (BLACK or NO_BACKDROP), its material and lights. */
static const char *on_it(const char *what, const char *backdrop, const char *material,
                         const char *lights)
{
    return lf_test_scene_patched(
        "reflection-of-lamp-and-ball",
        "{%s'meshes': {'ground': {'catcher': %s}}, 'materials': {'m': %s}, 'lights': {%s}}",
        backdrop, what, material, lights);
}
#define BLACK ""
#define NO_BACKDROP "'backdrop': null, "

enum { REPLICATES = 32, ACROSS = 16 };

/* Pictures with what catchers get. */
static void pictures_of(const char *text, uint64_t salt, lf_blocks *out)
{
    static float rgb[3 * ACROSS * ACROSS * VIEWS];
    static double picture[ACROSS * ACROSS * VIEWS];
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", ACROSS, ACROSS, NULL);
    lf_blocks_init(out, VIEWS, ACROSS, ACROSS, 4);
    for (int k = 0; k < REPLICATES; k++) {
        lf_test_reseed(r, lf_hash64(salt, (uint64_t)k));
        lf_test_cycles(r, 8);
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MIS, rgb, NULL), NULL);
        lf_assert_ok(lf_renderer_catch(r, rgb, NULL), NULL);
        for (int i = 0; i < ACROSS * ACROSS * VIEWS; i++)
            picture[i] = 0.5 * (double)rgb[3 * i] + 0.3 * (double)rgb[3 * i + 1] +
                         0.2 * (double)rgb[3 * i + 2];
        lf_blocks_add(out, picture);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* The picture with a catcher before black is that of the ordinary floor, in blocks of 4 x 4 pixels
 * and as a whole: Welch's test at the program's false alarms, over 32 seeds. Power: a mean of the
 * whole picture that is 3 % too bright is rejected, and so is any of the controls. */
static void a_catcher_before_black_is_the_floor_itself(void **state)
{
    (void)state;
    static const char *const materials[] = {
        PAPER,
        "{ 'type': 'plastic', 'roughness': 0 }",
        "{ 'type': 'plastic', 'roughness': 0.15 }",
        "{ 'type': 'principled', 'metallic': 0.5, 'roughness': 0.5, 'coat': 1 }",
    };
    for (int i = 0; i < 4; i++) {
        lf_blocks a, b, control;
        int where = 0;
        pictures_of(on_it("'reflection'", BLACK, materials[i], ""), 100 + (uint64_t)i, &a);
        pictures_of(on_it("false", NO_BACKDROP, materials[i], ""), 200 + (uint64_t)i, &b);
        const double level = lf_sidak(LF_FALSE_ALARM, 4 * a.n), p = lf_blocks_welch(&a, &b, &where);
        if (!(p > level))
            fail_msg("floor %d, block %d differs, p %.2g", i, where, p);
        assert_true(lf_blocks_welch_injected(&a, &b, a.n - 1, 1.03) < level);
        if (i == 0) { /* of shadows alone; and one under a sky, whose light is the plate's */
            pictures_of(on_it("true", BLACK, PAPER, ""), 300, &control);
            assert_true(lf_blocks_welch(&control, &b, NULL) < level);
            lf_blocks_finish(&control);
            pictures_of(
                on_it("false", BLACK, PAPER, "'e': { 'type': 'environment', 'radiance': 0.1 }"),
                301, &control);
            assert_true(lf_blocks_welch(&a, &control, NULL) < level);
            lf_blocks_finish(&control);
        }
        lf_blocks_finish(&a);
        lf_blocks_finish(&b);
    }
}

/* A lamp that is mirrored aslant in nearly smooth glaze, from views that stand 17 degrees to each
 * side; itself it is out of the picture, which is of reflections alone: a mean of any view that is
 * 5 % off is rejected. */
static void outer_views_see_what_they_would_of_the_floor(void **state)
{
    (void)state;
    lf_blocks a, b;
    int where = 0;
    pictures_of(lf_test_scene_text("reflection-aslant"), 400, &a);
    pictures_of(
        lf_test_scene_patched("reflection-aslant",
                              "{'backdrop': null, 'meshes': {'ground': {'catcher': false}}}"),
        401, &b);
    const double level = lf_sidak(LF_FALSE_ALARM, a.n), p = lf_blocks_welch(&a, &b, &where);
    if (!(p > level))
        fail_msg("block %d differs, p %.2g", where, p);
    assert_true(lf_blocks_welch_injected(&a, &b, a.n - 1, 1.05) < level);
    lf_blocks_finish(&a);
    lf_blocks_finish(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mirror_sends_back_what_it_shows_by_fresnel),
        cmocka_unit_test(paper_sends_back_albedo_times_form_factor),
        cmocka_unit_test(things_are_reflected_as_they_are_lit),
        cmocka_unit_test(what_is_of_the_plate_is_not_reflected),
        cmocka_unit_test(media_dim_both_ways),
        cmocka_unit_test(what_is_reflected_is_not_among_the_lights_of_shadows),
        cmocka_unit_test(a_catcher_before_black_is_the_floor_itself),
        cmocka_unit_test(outer_views_see_what_they_would_of_the_floor),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
