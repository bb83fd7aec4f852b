/* A grid seen directly, and in a perfect mirror. The direct way draws from slices, with correction
 * weights, and shares between views; behind a mirror every view tracks the grid itself: what slices
 * leave in the picture is the difference. The camera stands at its own mirror image, so that grid
 * and sun are the same numbers in both. Single scattering, for more of it hides what edges do. What
 * is compared is the mean of the picture, by Welch's test over seeds; each case shows its power.
 * QUILTD_LONG=1 takes the shipped cloud at three densities as well, and an edge of one voxel under
 * a low sun, and knows either side to some 0.03 %. */
#include "tests/testing.h"

#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { height = 16, views = 3, replicates = 24, side = 20 };

typedef struct subject {
    const char *name;
    lf_voxel_fn voxels; /* NULL: the shipped cloud */
    float sigma;        /* of a full voxel, which is 1/64 wide */
    bool nearest;
    double sun;           /* its cosine against the line of sight */
    int width;            /* of the picture; wide where slices are dear */
    int direct, mirrored; /* native samples a pixel and seed, four times as many in the long form */
    double power;         /* the relative difference that is rejected */
} subject;

/* Voxels of every density in a ball. */
static float clump(int x, int y, int z)
{
    double m = 0.5 * (side - 1),
           r2 = ((x - m) * (x - m) + (y - m) * (y - m) + (z - m) * (z - m)) / (m * m);
    return (float)fmax(0.0, 1.0 - r2) *
           (float)(lf_hash64((uint64_t)(x + 1000 * y), (uint64_t)z) >> 40) * 0x1p-24f;
}

/* What a level set becomes: full, with an edge of one voxel. */
static float ball(int x, int y, int z)
{
    double m = 0.5 * (side - 1),
           r = sqrt((x - m) * (x - m) + (y - m) * (y - m) + (z - m) * (z - m));
    return (float)fmin(1.0, fmax(0.0, m - r));
}

static const subject subjects[] = {
    {"voxels of every density, linear", clump, 220, false, 0.9, 16, 24, 8, 0.005},
    {"voxels of every density, nearest", clump, 220, true, 0.9, 16, 24, 8, 0.005},
    {"an edge of one voxel", ball, 220, false, 0.4, 16, 12, 6, 0.01},
};

static const subject long_subjects[] = {
    {"cloud, 44, linear", NULL, 44, false, 0.2, 48, 40, 12, 0.0025},
    {"cloud, 220, linear", NULL, 220, false, 0.2, 48, 40, 12, 0.0025},
    {"cloud, 1100, linear", NULL, 1100, false, 0.2, 48, 40, 12, 0.0025},
    {"cloud, 44, nearest", NULL, 44, true, 0.2, 48, 40, 12, 0.0025},
    {"cloud, 220, nearest", NULL, 220, true, 0.2, 48, 40, 12, 0.0025},
    {"cloud, 1100, nearest", NULL, 1100, true, 0.2, 48, 40, 12, 0.0025},
    {"an edge of one voxel under a low sun", ball, 220, false, 0.2, 16, 100, 25, 0.0025},
};

enum {
    n_short = sizeof subjects / sizeof subjects[0],
    n_all = n_short + sizeof long_subjects / sizeof long_subjects[0]
};

#define LEVEL lf_sidak(LF_FALSE_ALARM, lf_test_long() ? n_all : n_short)
#define CERTAIN 1e-6

/* The mirror is a square through (0, 0, 3), its normal (1, 0, 1): what is at (x, y, z) is seen at
 * (3 - z, y, 3 - x). */
static lf_scene *make(const subject *s, bool mirrored)
{
    char volume[PATH_MAX + 128] = "";
    if (!s->voxels)
        snprintf(volume, sizeof volume,
                 "'shape': null, 'file': '%s', 'scale': %g, 'interpolation': '%s', "
                 "'transform': {'rotate': [0, 30, 0]}",
                 lf_test_built("../scenes/cloud.vdb"), (double)s->sigma,
                 s->nearest ? "nearest" : "linear");
    const char *text = lf_test_scene_patched(
        "mirror-pair",
        "{'camera': {%s'fov_y': %g}, 'volumes': {'v': {%s}}, %s'lights': {'sun': {'direction': "
        "[%.9f, -0.1, %.9f]}}}",
        mirrored ? "" : "'position': [0, 0, 5], 'target': [0, 0, 0], ", s->voxels ? 2.4 : 14.0,
        volume, mirrored ? "" : "'meshes': {'mirror': null}, 'render': {'max_depth': 1}, ",
        sqrt(1.0 - s->sun * s->sun), -s->sun);
    if (!s->voxels)
        return lf_test_scene(text);
    return lf_test_grid_scene(text, lf_test_grid(s->voxels, side, side, side), 1.0 / 64, 0.5,
                              s->sigma, s->nearest);
}

static lf_moments seen(const subject *s, bool mirrored, int cycles, unsigned faults)
{
    lf_scene *scene = make(s, mirrored);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", s->width, height, NULL);
    lf_blocks blocks;
    r->faults = faults;
    lf_blocks_init(&blocks, views, s->width, height, s->width);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + (uint64_t)mirrored, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(&blocks, r, LF_ESTIMATOR_CV);
    }
    lf_moments whole = blocks.moments[blocks.n - 1];
    lf_blocks_finish(&blocks);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return whole;
}

static void assert_pair(const subject *s)
{
    int more = lf_test_long() ? 4 : 1;
    lf_moments direct = seen(s, false, more * s->direct, 0),
               mirrored = seen(s, true, more * s->mirrored, 0), off = mirrored;
    double p = lf_p_welch(&direct, &mirrored);
    print_message("%s: direct %+.3f %%, standard errors %.3f and %.3f %%, p %.2g\n", s->name,
                  100.0 * (direct.mean / mirrored.mean - 1.0),
                  100.0 * lf_moments_error(&direct) / direct.mean,
                  100.0 * lf_moments_error(&mirrored) / mirrored.mean, p);
    assert_true(p > LEVEL);
    off.mean = direct.mean * (1.0 + s->power);
    assert_true(lf_p_welch(&direct, &off) < LEVEL);
    if (s->nearest)
        return; /* there is nothing to correct */
    lf_moments wrong = seen(s, false, (s->direct + 3) / 4, LF_FAULT_NO_CORRECTION);
    p = lf_p_welch(&wrong, &mirrored);
    print_message("    uncorrected %+.2f %%, p %.2g\n", 100.0 * (wrong.mean / mirrored.mean - 1.0),
                  p);
    assert_true(p < CERTAIN);
}

static void grids_are_as_bright_in_a_mirror(void **state)
{
    (void)state;
    for (int i = 0; i < n_short; i++)
        assert_pair(&subjects[i]);
}

static void the_cloud_and_a_sharp_edge_are_as_bright_in_a_mirror(void **state)
{
    (void)state;
    if (!lf_test_long()) {
        print_message("make verify alone\n");
        skip();
    }
    for (int i = 0; i < n_all - n_short; i++)
        assert_pair(&long_subjects[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grids_are_as_bright_in_a_mirror),
        cmocka_unit_test(the_cloud_and_a_sharp_edge_are_as_bright_in_a_mirror),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
