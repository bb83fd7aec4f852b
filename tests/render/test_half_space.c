/* What a half-space that scatters isotropically sends back from under a sun: Chandrasekhar's H
 * functions (Radiative Transfer, 1960, section 33), computed here from their integral equation. The
 * law knows optical depths alone: a homogeneous shape obeys it, a grid with a sharp face, and one
 * whose density rises linearly over a voxel of several mean free paths. Replicates are seeds. Every
 * block of every view is tested, and the whole picture; its standard error is below what each case
 * says, and five of those would be seen. With QUILTD_LONG=1 it is below 0.3 of that. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/h_function.h"

enum { width = 16, height = 12, n_views = 3, block = 8, blocks_of_all = n_views * 4 + 1 };
enum { replicates = 16, comparisons = 14 };

#define LEVEL lf_sidak(LF_FALSE_ALARM, comparisons *blocks_of_all)

/* ----------------------------------------------------------------------------------------- H -- */

/* His tables, to the digits that he gives, and the integral that is known in closed form. */
static void h_is_what_its_author_computed(void **state)
{
    (void)state;
    static const struct {
        double albedo, mu, h;
    } table[] = {{1, 1, 2.9078}, {1, 0.5, 2.0128}, {1, 0.05, 1.1366}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        lf_h_function h;
        double mean = 0;
        lf_h_make(&h, table[i].albedo);
        for (int k = 0; k < LF_H_NODES; k++)
            mean += h.weight[k] * h.value[k];
        lf_assert_close(mean, 2 / table[i].albedo * (1 - sqrt(1 - table[i].albedo)), 1e-6, 0);
        lf_assert_close(lf_h_at(&h, table[i].mu), table[i].h, 0, 1e-4);
    }
}

/* ------------------------------------------------------------------------------- half-spaces -- */

/* A form of half-space. */
typedef struct half_space {
    const char *voxels; /* how they are interpolated; NULL = none, a shape */
    double albedo, sun; /* cosine of the sun to the face's normal */
    double precision;   /* of the mean of a picture */
    int cycles;
} half_space;

/* 1 from the sun across its rays: mu_0/pi of a white diffuse ground. */
static double *truth_of(const lf_renderer *r, const half_space *s)
{
    static const double place[2] = {0.2113248654051871, 0.7886751345948129};
    /* of the unit vectors ahead and upwards of the camera, whose third one is level */
    const double d = sqrt(8 * 8 + 1 + 4 * 4), ahead_z = -4 / d, up_z = sqrt(8 * 8 + 1) / d;
    lf_h_function h;
    lf_h_make(&h, s->albedo);
    double *out = malloc(sizeof *out * n_views * width * height), *p = out,
           at_sun = lf_h_at(&h, s->sun);
    for (int row = 0; row < height; row++)
        for (int view = 0; view < n_views; view++)
            for (int column = 0; column < width; column++, p++) {
                *p = 0;
                for (int i = 0; i < 4; i++) {
                    double mx, my;
                    lf_test_slopes(r, view, column + place[i & 1], row + place[i >> 1], &mx, &my);
                    double mu = -(ahead_z + my * up_z) / sqrt(1 + mx * mx + my * my);
                    *p += 0.25 * s->albedo / (4 * M_PI) * s->sun / (s->sun + mu) * lf_h_at(&h, mu) *
                          at_sun;
                }
            }
    return out;
}

/* A box; or 8^3 voxels (block() in scenes/make_test_vdb.cc), 4 mean free paths thick and 100 wide.
 */
static char *volume_of(const half_space *s)
{
    char path[PATH_MAX], *text = NULL;
    assert_non_null(realpath(lf_test_built("testdata/block.vdb"), path));
    if (s->voxels)
        assert_true(asprintf(&text,
                             "'shape': null, 'file': '%s', 'interpolation': '%s', 'transform': "
                             "{'scale': [100, 100, 4], "
                             "'translate': [-350, -350, -30]}, ",
                             path, s->voxels) > 0);
    else
        assert_non_null(text = strdup(""));
    return text;
}

static lf_scene *scene_of(const half_space *s)
{
    char *volume = volume_of(s);
    lf_scene *scene =
        lf_test_scene(lf_test_scene_patched("half-space",
                                            "{'volumes': {'ground': {%s'albedo': %.17g}}, "
                                            "'lights': {'sun': {'direction': [%.17g, 0, %.17g]}}}",
                                            volume, s->albedo, sqrt(1 - s->sun * s->sun), -s->sun));
    free(volume);
    return scene;
}

static void render(const half_space *s, const char *integrator, lf_blocks *out, double **out_truth)
{
    lf_scene *scene = scene_of(s);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_cycles(r, lf_test_long() ? 16 * s->cycles : s->cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    *out_truth = truth_of(r, s);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static double mean_of(const double *picture)
{
    double sum = 0;
    for (int i = 0; i < n_views * width * height; i++)
        sum += picture[i] / (n_views * width * height);
    return sum;
}

static void assert_half_space(const half_space *s)
{
    static const char *const integrators[] = {"vpt", "mvpt"};
    /* slices are what takes long */
    for (int i = s->voxels && !lf_test_long() ? 1 : 0; i < 2; i++) {
        lf_blocks blocks;
        double *truth;
        int where = 0;
        render(s, integrators[i], &blocks, &truth);
        const lf_moments *all = &blocks.moments[blocks.n - 1];
        double p = lf_blocks_p(&blocks, truth, 2e-4, &where),
               error = lf_moments_error(all) / all->mean;
        print_message("albedo %g, sun at %g, %s: %.5f of the truth, +- %.5f\n", s->albedo, s->sun,
                      integrators[i], all->mean / mean_of(truth), error);
        if (!(p > LEVEL))
            fail_msg("block %d is %.6g +- %.2g, p %.2g", where, blocks.moments[where].mean,
                     lf_moments_error(&blocks.moments[where]), p);
        assert_true(error < (lf_test_long() ? 0.3 : 1) * s->precision);
        lf_blocks_finish(&blocks);
        free(truth);
    }
}

static void a_homogeneous_half_space_reflects_as_chandrasekhar_says(void **state)
{
    (void)state;
    static const half_space cases[] = {
        {NULL, 0.5, 0.05, 1.2e-3, 32},
        {NULL, 0.9, 0.3, 1.2e-3, 32},
        {NULL, 0.99, 1, 2e-3, 16},
        {NULL, 0.999, 0.1, 3e-3, 16}, /* the paths are a hundred times as long: make verify alone */
    };
    for (size_t i = 0; i < (lf_test_long() ? 4 : 3); i++)
        assert_half_space(&cases[i]);
}

static void a_half_space_of_voxels_reflects_as_chandrasekhar_says(void **state)
{
    (void)state;
    static const half_space cases[] = {
        /* make verify alone */
        {"nearest", 0.9, 0.1, 6e-3, 8},
        {"linear", 0.9, 0.1, 6e-3, 8},
        {"linear", 0.6, 1, 2.5e-3, 16},
    };
    for (size_t i = 0; i < (lf_test_long() ? 3 : 2); i++)
        assert_half_space(&cases[i]);
}

/* Negative control: half a per cent less scatters. */
static void another_albedo_is_rejected(void **state)
{
    (void)state;
    const half_space s = {NULL, 0.9, 0.3, 1, 16};
    half_space other = s;
    lf_blocks blocks;
    double *truth;
    other.albedo = 0.8955;
    render(&other, "mvpt", &blocks, &truth);
    free(truth);
    lf_scene *scene = scene_of(&s);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    truth = truth_of(r, &s);
    assert_true(lf_blocks_p(&blocks, truth, 2e-4, NULL) < LEVEL);
    free(truth);
    lf_blocks_finish(&blocks);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(h_is_what_its_author_computed),
        cmocka_unit_test(a_homogeneous_half_space_reflects_as_chandrasekhar_says),
        cmocka_unit_test(a_half_space_of_voxels_reflects_as_chandrasekhar_says),
        cmocka_unit_test(another_albedo_is_rejected),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
