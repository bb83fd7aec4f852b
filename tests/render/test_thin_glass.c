/* Panes: smooth grey sheets, through which views share what is behind. Closed forms of one and of
 * two; and the same scenes with panes as surfaces like others, whose light goes on as a delta lobe,
 * natively and each view alone. */
#include "tests/testing.h"

#include "render/transport/surface/surface.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 3, tile = 8, blocks_of_all = n_views * 12 + 1 };

/* Two scenes, three answers and weights; injected mistakes besides. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 2 * 5 * blocks_of_all)
#define CERTAIN 1e-9

/* Patches of sheet-of-glass. */
static const char *const windows[] = {
    "{'camera': {'views': {'track': {'count': 3, 'length': 1.5}}, 'lens_radius': 0.1, "
    "'focus_distance': 4.2}}",
    "{'volumes': {'fog': {'shape': 'box', 'density': 0.5, 'g': 0.3, "
    "'transform': {'scale': 1.4}}}}"};

static void as_other_surfaces(lf_scene *scene)
{
    for (int i = 0; i < scene->n_materials; i++)
        scene->materials[i].glass.is_thin = false;
    scene->traits &= ~LF_TRAITS_SEEN_THROUGH;
}

static void schedule(lf_renderer *r)
{
    lf_test_passes(r, 5 * n_views);
}

static const char *window(int i)
{
    return lf_test_scene_patched("sheet-of-glass", "%s", windows[i]);
}

static void pictures(const char *text, bool thin_glass, lf_estimator estimator, uint64_t seed,
                     lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(text);
    assert_true(lf_has(scene, LF_TRAITS_SEEN_THROUGH));
    if (!thin_glass)
        as_other_surfaces(scene);
    lf_renderer *r = lf_test_renderer(scene, thin_glass ? "mvpt" : "vpt", width, height, NULL);
    lf_test_pictures(r, schedule, estimator, 16, seed, tile, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void panes_are_what_delta_lobes_would_be(void **state)
{
    (void)state;
    static const lf_estimator answers[] = {LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV, LF_ESTIMATOR_MWIS};
    for (int i = 0; i < 2; i++) {
        lf_blocks truth;
        int where = 0;
        pictures(window(i), false, LF_ESTIMATOR_MIS, 1000, &truth);
        for (int a = 0; a < 3; a++) {
            lf_blocks mine;
            pictures(window(i), true, answers[a], 2000, &mine);
            double p = lf_blocks_welch(&mine, &truth, &where);
            if (!(p > LEVEL))
                fail_msg("window %d, answer %d, block %d: %.5g +- %.2g, alone %.5g +- %.2g, p %.2g",
                         i, a, where, mine.moments[where].mean,
                         lf_moments_error(&mine.moments[where]), truth.moments[where].mean,
                         lf_moments_error(&truth.moments[where]), p);
            assert_true(lf_blocks_welch_injected(&mine, &truth, blocks_of_all - 1, 1.03) < LEVEL);
            lf_blocks_finish(&mine);
        }
        lf_blocks_finish(&truth);
    }
}

static void panes_weigh_as_everything_that_is_met(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++)
        lf_test_assert_weights(window(i), width, height, schedule, 16, tile, LEVEL);
}

static double fresnel(double cosine)
{
    double c = sqrt(1.0 - (1.0 - cosine * cosine) / 2.25),
           s = (cosine - 1.5 * c) / (cosine + 1.5 * c), p = (1.5 * cosine - c) / (1.5 * cosine + c);
    return 0.5 * (s * s + p * p);
}

/* n panes between the camera and a wall that shines and reflects nothing, and nothing else: with r
 * of one, both faces, n of them let through (1 - r)/(1 + (n - 1) r). Near black mistakes of 1 %
 * would show: a pane without the angle is one. */
static void a_stack_of_panes_lets_through_what_it_must(void **state)
{
    (void)state;
    static const char *const integrators[] = {"vpt", "mvpt"};
    for (int c = 0; c < 4; c++) {
        int n = 1 + c / 2;
        lf_scene *scene = lf_test_scene(lf_test_scene_patched(
            "stacked-sheets", "%s", n > 1 ? "{}" : "{'meshes': {'b': null}}"));
        lf_renderer *r = lf_test_renderer(scene, integrators[c % 2], 12, 10, NULL);
        lf_test_cycles(r, 64);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS), worst = 0.0, sum = 0.0, all = 0.0;
        for (int k = 0; k < 10 * 3 * 12; k++) {
            double mx, my;
            lf_test_slopes(r, k / 12 % 3, k % 12 + 0.5, k / 36 + 0.5, &mx, &my);
            double f = fresnel(1.0 / sqrt(1.0 + mx * mx + my * my)), one = 2.0 * f / (1.0 + f),
                   want = (1.0 - one) / (1.0 + (n - 1) * one);
            worst = fmax(worst, fabs(picture[k] - want));
            sum += picture[k];
            all += want;
        }
        print_message("%s, %d panes: mean %.5f, must be %.5f, worst pixel off by %.2g\n",
                      integrators[c % 2], n, sum / 360, all / 360, worst);
        lf_assert_close(sum, all, 1e-3, 0);
        assert_true(worst < (n > 1 ? 0.05 : 1e-3));
        free(picture);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

/* The sun of no size, which no path of delta lobes would find, through one pane and two. */
static void the_sun_shines_through_windows(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("sheet-over-floor"));
    lf_tracer tracer = {.scene = scene, .rng = 7};
    float passed =
        lf_trace_passed(&tracer, lf_v3(0.0f, 0.5f, 0.0f), lf_v3(-0.6f, 0.8f, 0.0f), INFINITY);
    double f = fresnel(0.8);
    lf_assert_close((double)passed, 0.9 * (1.0 - f) / (1.0 + f), 1e-5, 0);
    /* A ray is stopped as often as that. */
    int met = 0;
    lf_hit hit;
    for (int i = 0; i < 100000; i++)
        met += lf_trace_surface(&tracer, lf_v3(0.0f, 0.5f, 0.0f), lf_v3(-1.2f, 1.6f, 0.0f),
                                INFINITY, &hit);
    lf_assert_close(met / 1e5, 1.0 - (double)passed, 0, 5.0 * 0.5 / sqrt(1e5));
    lf_scene_unref(scene);
}

static void what_is_no_pane(void **state)
{
    (void)state;
    static const struct {
        float roughness, transmission, metallic, red, coat_roughness;
        bool solid, thin;
    } cases[] = {{0, 1, 0, 1, 0, false, true},     {0.1f, 1, 0, 1, 0, false, false},
                 {0, 0.9f, 0, 1, 0, false, false}, {0, 1, 0.1f, 1, 0, false, false},
                 {0, 1, 0, 0.5f, 0, false, false}, {0, 1, 0, 1, 0.3f, false, false},
                 {0, 1, 0, 1, 0, true, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_material m = {.kind = &lf_surface_principled,
                         .albedo = {cases[i].red, 1.0f, 1.0f},
                         .roughness = cases[i].roughness,
                         .ior = 1.5f,
                         .specular = 1.0f,
                         .specular_tint = {1.0f, 1.0f, 1.0f},
                         .metallic = cases[i].metallic,
                         .coat = 0.5f,
                         .coat_roughness = cases[i].coat_roughness,
                         .transmission = cases[i].transmission,
                         .is_solid = cases[i].solid};
        lf_material_prepare(&m);
        assert_int_equal(m.glass.is_thin, cases[i].thin);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_no_pane),
        cmocka_unit_test(the_sun_shines_through_windows),
        cmocka_unit_test(a_stack_of_panes_lets_through_what_it_must),
        cmocka_unit_test(panes_are_what_delta_lobes_would_be),
        cmocka_unit_test(panes_weigh_as_everything_that_is_met),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
