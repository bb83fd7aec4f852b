/* What fills solid glass, against the same scenes expressed another way: glass of index 1 is not
 * there, and what fills it is then a volume of its shape. */
#include "tests/testing.h"

#include "render/transport/path/interior.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 2, tile = 8, blocks_of_all = n_views * 12 + 1 };
enum { CASES = 4 };
#define LEVEL lf_sidak(LF_FALSE_ALARM, CASES *blocks_of_all)
#define CERTAIN 1e-9

/* The glass with changes of what is in it, and filled with this; with nothing in it; and volumes in
 * its place. */
#define FILLED(meshes, volumes, fill)                                                              \
    "{'meshes': {" meshes "}, 'volumes': {" volumes "}, 'materials': {'fill': {" fill "}}}"
#define EMPTY(fill) FILLED(ALONE, "'fog': null", fill)
#define OPEN(meshes, volumes) "{'meshes': {" meshes "}, 'volumes': {" volumes "}}"
#define ALONE "'card': null, 'lamp': null"
#define FAR                                                                                        \
    "'cube': null, 'card': null, 'lamp': null, 'far': {'shape': 'quad', 'material': 'clay', "      \
    "'transform': {'translate': [0, -50, 0]}}"
#define BOX(medium)                                                                                \
    "{'shape': 'box', " medium ", 'transform': {'scale': [0.8, 0.6, 0.7], 'rotate': [0, 30, 0]}}"

static const struct {
    const char *filled, *open, *wrong; /* patches of filled-glass */
} cases[CASES] = {
    /* milk */
    {EMPTY("'scattering': [1.8, 1.4, 0.8], 'absorption': [0.2, 0.6, 1.2], 'g': 0.5"),
     OPEN(FAR, "'fog': null, 'milk': " BOX("'density': 2, 'albedo': [0.9, 0.7, 0.4], 'g': 0.5")),
     EMPTY("'scattering': [1.8, 1.4, 0.8], 'absorption': [0.2, 0.6, 1.2], 'g': 0")},
    /* things in coloured glass: between them, and a lamp's light sample */
    {FILLED("", "'fog': null", "'absorption': 1"),
     OPEN("'cube': null", "'fog': null, 'ink': " BOX("'density': 1, 'albedo': 0")),
     FILLED("", "'fog': null", "'absorption': 0.9")},
    /* smoke in clear glass, and in milk */
    {FILLED(ALONE, "", "'absorption': 0.001"), OPEN(FAR, ""), EMPTY("'absorption': 0.001")},
    {FILLED(ALONE, "", "'absorption': 0.5, 'scattering': 0.5"),
     OPEN(FAR, "'milk': " BOX("'density': 1, 'albedo': 0.5")),
     FILLED(ALONE, "", "'absorption': 0.6, 'scattering': 0.5")},
};

static void schedule(lf_renderer *r)
{
    lf_test_passes(r, 8 * n_views);
}

static void pictures(const char *name, const char *patch, const char *integrator, uint64_t seed,
                     lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(name, "%s", patch));
    lf_test_pictures_of(scene, integrator, width, height, schedule, seed, tile, out);
}

static void what_fills_glass_of_index_one_is_a_volume(void **state)
{
    (void)state;
    for (int i = 0; i < CASES; i++) {
        lf_blocks filled, open, wrong;
        int where = 0;
        pictures("filled-glass", cases[i].filled, i % 2 ? "mvpt" : "vpt", 1000, &filled);
        pictures("filled-glass", cases[i].open, "mvpt", 2000, &open);
        pictures("filled-glass", cases[i].wrong, "vpt", 3000, &wrong);
        double p = lf_blocks_welch(&filled, &open, &where);
        if (!(p > LEVEL))
            fail_msg("case %d, block %d: %.5g +- %.2g, as a volume %.5g +- %.2g, p %.2g", i, where,
                     filled.moments[where].mean, lf_moments_error(&filled.moments[where]),
                     open.moments[where].mean, lf_moments_error(&open.moments[where]), p);
        assert_true(lf_blocks_welch(&wrong, &open, NULL) < CERTAIN);
        lf_blocks_finish(&filled);
        lf_blocks_finish(&open);
        lf_blocks_finish(&wrong);
    }
}

/* Beer's law once, whether the face is met as a delta or as a lobe: a slab that is 2 thick and
 * hardly bends light. */
static void rough_faces_dim_as_smooth_ones_do(void **state)
{
    (void)state;
    static const char *const roughness[] = {"{}", "{'materials': {'glass': {'roughness': 0.05}}}"};
    for (int i = 0; i < 4; i++) {
        lf_blocks seen;
        lf_moments all = {0};
        pictures("glass-slab", roughness[i / 2], i % 2 ? "mvpt" : "vpt", 5, &seen);
        for (int b = 0; b < seen.n; b++)
            lf_moments_add(&all, seen.moments[b].mean);
        lf_assert_close(all.mean, exp(-2.0), 0.01, 0);
        lf_blocks_finish(&seen);
    }
}

/* Glass that scatters and absorbs nothing under an even sky is not seen, whatever its index and
 * however much each channel is scattered. */
static void what_scatters_all_is_not_seen_under_an_even_sky(void **state)
{
    (void)state;
    enum { N = 40000 };
    lf_scene *scene = lf_test_scene(lf_test_scene_text("milk-ball"));
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed() + 3};
    lf_event event = {.kind = LF_EVENT_SURFACE, .w = lf_v3(0.0f, 0.0f, -1.0f)};
    assert_true(lf_trace_surface(&tracer, lf_v3(0.2f, 0.3f, 4.0f), event.w, INFINITY, &event.hit));
    event.p = event.hit.p;
    lf_moments m[3] = {{0}};
    for (int i = 0; i < N; i++) {
        lf_vec3 l = lf_path_scattered(&tracer, &event, 1, 1024);
        lf_moments_add(&m[0], (double)l.x);
        lf_moments_add(&m[1], (double)l.y);
        lf_moments_add(&m[2], (double)l.z);
    }
    for (int c = 0; c < 3; c++) {
        print_message("%.4f +- %.4f\n", m[c].mean, lf_moments_error(&m[c]));
        /* Rough faces keep all within 0.5 %, of which a path meets a few. */
        lf_assert_close(m[c].mean, 1.0, 1e-2, 5.0 * lf_moments_error(&m[c]));
    }
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_scatters_all_is_not_seen_under_an_even_sky),
        cmocka_unit_test(rough_faces_dim_as_smooth_ones_do),
        cmocka_unit_test(what_fills_glass_of_index_one_is_a_volume),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
