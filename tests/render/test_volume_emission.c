/* Volumes that emit, against pictures that are known: shapes that glow and absorb, in vacuum,
 * behind what absorbs, and before a surface; behind sheets and panes, and in glass; grids of a
 * known integral; furnaces in which emission makes up for what is absorbed, so that everything is
 * 1; the light that falls on a wall. By both integrators and every answer; replicates are seeds,
 * and blocks of 8 x 8 pixels are compared by Student's t. Negative controls: emission that is 1 %
 * off is rejected, wherever a test is statistical. */
#include "tests/testing.h"

#include "render/transport/light/volume_emission.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { width = 32, height = 24, n_views = 5, block = 8 };

#define CAMERA(more)                                                                               \
    "'quiltd': 1, 'camera': { 'position': [0, 0, 5], 'fov_y': 24, 'aspect': 1.3333333333, "        \
    "'views': 5, 'cone': 30" more " }"
#define LENS ", 'lens_radius': 0.2, 'focus_distance': 4.5"

static const lf_estimator estimators[] = {LF_ESTIMATOR_MWIS, LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};
static const char *const integrators[] = {"mvpt", "vpt"};

/* Blocks that are compared in all, at most. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 3 * 2 * 61 * 16)

/* Truth along the pinhole ray of these slopes; x0: where its camera stands along X. */
typedef double (*truth_fn)(double x0, double mx, double my);

/* Means over pixels, by points of a grid. */
static double *truth_picture(const lf_renderer *r, truth_fn truth)
{
    enum { side = 8 };
    const lf_rig *rig = &lf_test_rows(r)->rig;
    double *out = malloc(sizeof *out * n_views * width * height), *p = out;
    for (int row = 0; row < height; row++) {
        for (int view = 0; view < n_views; view++) {
            for (int column = 0; column < width; column++, p++) {
                *p = 0.0;
                for (int i = 0; i < side * side; i++) {
                    double mx, my;
                    lf_test_slopes(r, view, column + (i % side + 0.5) / side,
                                   row + (i / side + 0.5) / side, &mx, &my);
                    *p += truth((double)rig->b[view], mx, my) / (side * side);
                }
            }
        }
    }
    return out;
}

/* One answer: the truth holds, and one that is 1 % off does not. */
static void assert_answer(const lf_renderer *r, lf_estimator estimator, const lf_blocks *blocks,
                          const double *expected, double rounding)
{
    double off[n_views * width * height];
    int where = 0;
    double p = lf_blocks_p(blocks, expected, rounding, &where);
    if (!(p > LEVEL))
        fail_msg("%s %s: block %d is %.6g +- %.2g, p %.2g", lf_renderer_settings(r)->integrator,
                 lf_estimator_name(estimator), where, blocks->moments[where].mean,
                 lf_moments_error(&blocks->moments[where]), p);
    for (int i = 0; i < n_views * width * height; i++)
        off[i] = 1.01 * expected[i];
    assert_true(lf_blocks_p(blocks, off, rounding, NULL) < LEVEL);
}

/* Takes the scene. Answers of the same films, from `first` on: mwis is consistent only. */
static void assert_scene(lf_scene *scene, truth_fn truth, int passes, int replicates,
                         double rounding, int first)
{
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, integrators[i], width, height, NULL);
        double *expected = truth_picture(r, truth);
        lf_blocks blocks[3];
        for (int e = first; e < 3; e++)
            lf_blocks_init(&blocks[e], n_views, width, height, block);
        for (int k = 0; k < replicates; k++) {
            lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
            lf_test_passes(r, passes);
            for (int e = first; e < 3; e++)
                lf_blocks_add_picture(&blocks[e], r, estimators[e]);
        }
        for (int e = first; e < 3; e++) {
            assert_answer(r, estimators[e], &blocks[e], expected, rounding);
            lf_blocks_finish(&blocks[e]);
        }
        free(expected);
        lf_renderer_destroy(r);
    }
    lf_scene_unref(scene);
}

static void assert_known(const char *text, truth_fn truth, int passes, int replicates,
                         double rounding)
{
    assert_scene(lf_test_scene(text), truth, passes, replicates, rounding, 0);
}

/* ------------------------------------------------------------------------------------ shapes -- */

#define SLAB(density, albedo, more)                                                                \
    "'slab': { 'shape': 'box', 'density': " density ", 'albedo': " albedo ", "                     \
    "'emission': [2, 2, 2], 'transform': { 'scale': [60, 60, 0.5] }" more " }"

static double length_of(double mx, double my)
{
    return sqrt(1.0 + mx * mx + my * my);
}

/* The slab is 1 thick and faces the cameras. */
static double slab(double x0, double mx, double my)
{
    (void)x0;
    return 2.0 / 1.5 * (1.0 - exp(-1.5 * length_of(mx, my)));
}

static double slab_in_vacuum(double x0, double mx, double my)
{
    (void)x0;
    return 2.0 * length_of(mx, my);
}

static void a_slab_that_absorbs_and_emits_is_its_closed_form(void **state)
{
    (void)state;
    assert_known("{" CAMERA("") ", 'volumes': {" SLAB("1.5", "0", "") "} }", slab, 5, 4, 1e-4);
    assert_known("{" CAMERA("") ", 'volumes': {" SLAB("0", "1", "") "} }", slab_in_vacuum, 5, 4,
                 1e-4);
}

/* A lens changes the slopes of a pixel's rays, not their mean. */
static void a_slab_is_its_closed_form_through_a_lens(void **state)
{
    (void)state;
    assert_known("{" CAMERA(LENS) ", 'volumes': {" SLAB("0", "1", "") "} }", slab_in_vacuum, 5, 24,
                 1e-3);
}

/* The chord of the unit ball, 5 before the middle camera. */
static double chord(double x0, double mx, double my)
{
    double a = 1.0 + mx * mx + my * my, b = x0 * mx - 5.0, c = x0 * x0 + 24.0, d = b * b - a * c;
    return d > 0.0 ? 2.0 * sqrt(d / a) : 0.0;
}

static double ball(double x0, double mx, double my)
{
    return 2.0 / 3.0 * (1.0 - exp(-3.0 * chord(x0, mx, my)));
}

static void a_ball_that_absorbs_and_emits_is_its_closed_form(void **state)
{
    (void)state;
    assert_known("{" CAMERA("") ", 'volumes': { 'ball': { 'shape': 'sphere', 'density': 3, "
                                "'albedo': 0, 'emission': 2 } } }",
                 ball, 15, 32, 2e-3);
    assert_known("{" CAMERA("") ", 'volumes': { 'ball': { 'shape': 'sphere', 'density': 0, "
                                "'emission': 1 } } }",
                 chord, 15, 32, 2e-3);
}

/* Another slab, of half the depth, in the front half of the first and before it. */
static double slab_behind_smoke(double x0, double mx, double my)
{
    (void)x0;
    double s = length_of(mx, my), front = exp(-0.25 * s),
           both = 2.0 / 2.5 * (1.0 - exp(-2.5 * 0.5 * s)),
           rest = exp(-2.5 * 0.5 * s) * 2.0 / 1.5 * (1.0 - exp(-1.5 * 0.5 * s));
    return front * (both + rest);
}

static void a_slab_that_reaches_into_smoke_is_its_closed_form(void **state)
{
    (void)state;
    assert_known(
        "{" CAMERA("") ", 'volumes': {" SLAB(
            "1.5", "0",
            "") ", 'smoke': { 'shape': 'box', 'density': 1, 'albedo': 0, "
                "'transform': { 'scale': [60, 60, 0.375], 'translate': [0, 0, 0.375] } } } }",
        slab_behind_smoke, 5, 32, 1e-4);
}

/* A black wall in the middle of the slab. */
static double half_a_slab(double x0, double mx, double my)
{
    (void)x0;
    return 2.0 / 1.5 * (1.0 - exp(-1.5 * 0.5 * length_of(mx, my)));
}

static void a_surface_hides_what_is_behind_it(void **state)
{
    (void)state;
    assert_known(
        "{" CAMERA("") ", 'volumes': {" SLAB(
            "1.5", "0", "") "}, 'meshes': { 'wall': { 'shape': 'quad', 'material': 'black', "
                            "'transform': { 'scale': 60, 'rotate': [90, 0, 0] } } }, "
                            "'materials': { 'black': { 'albedo': 0 } } }",
        half_a_slab, 5, 4, 1e-4);
}

/* ------------------------------------------------------------------------------------- paths -- */

/* Emission (1 - albedo) sigma: in a white furnace every radiance is 1. */
static double one(double x0, double mx, double my)
{
    (void)x0, (void)mx, (void)my;
    return 1.0;
}

#define THROUGH_LENSES                                                                             \
    "{'camera': {'lens_radius': 0.2, 'focus_distance': 4.5}, 'volumes': {'fog': {'g': 0.6}}}"

static void emission_makes_up_for_absorption_in_a_furnace(void **state)
{
    (void)state;
    assert_scene(lf_test_scene(lf_test_scene_text("emissive-furnace")), one, 15, 32, 1e-4, 1);
    assert_scene(lf_test_scene(lf_test_scene_patched("emissive-furnace", THROUGH_LENSES)), one, 15,
                 32, 1e-4, 1);
}

/* A wall of albedo 1/2 behind a slab that is 1 thick: it receives pi (1 - 2 E3(1)). */
static double wall(double x0, double mx, double my)
{
    (void)x0;
    const double e3 = 0.10969196719776013, through = exp(-length_of(mx, my));
    return 1.0 - through + 0.5 * (1.0 - 2.0 * e3) * through;
}

#define WALL(z, scale)                                                                             \
    "'meshes': { 'wall': { 'shape': 'quad', 'transform': { 'scale': " scale ", 'rotate': [90, 0, " \
    "0], 'translate': [0, 0, " z "] } } }"

static void a_wall_is_lit_by_what_emits_before_it(void **state)
{
    (void)state;
    assert_known(lf_test_scene_text("emissive-slab-before-wall"), wall, 15, 48, 1e-3);
    /* another medium's density, its own is 0 */
    assert_known(
        lf_test_scene_patched(
            "emissive-slab-before-wall",
            "{'volumes': {'slab': {'density': 0, 'albedo': null}, 'smoke': {'shape': 'box', "
            "'density': 1, 'albedo': 0, 'transform': {'scale': [6000, 6000, 0.5]}}}}"),
        wall, 15, 48, 1e-3);
}

/* A ball of radius 1/2 in vacuum, 1 before a wall of albedo 1/2, seen beside the ball: irradiance
 * is the normal part of a field that falls as gravity's, of the ball's volume. */
static double lit_by_a_ball(double x0, double mx, double my)
{
    double x = x0 + 6.0 * mx, y = 6.0 * my, d = 1.0 + x * x + y * y;
    double a = 1.0 + mx * mx + my * my, b = x0 * mx - 5.0, c = x0 * x0 + 24.75, e = b * b - a * c;
    return 10.0 / 12.0 * pow(d, -1.5) + (e > 0.0 ? 10.0 * 2.0 * sqrt(e / a) : 0.0);
}

static void a_wall_is_lit_by_what_emits_in_vacuum(void **state)
{
    (void)state;
    assert_known(
        "{" CAMERA("") ", 'volumes': { 'ball': { 'shape': 'sphere', 'density': 0, "
                       "'emission': 10, 'transform': { 'scale': 0.5 } } }, " WALL("-1", "60") " }",
        lit_by_a_ball, 60, 48, 1e-3);
}

/* ------------------------------------------------------------------------------------- grids -- */

/* Makes the scene's flame a grid: `size` voxels of this edge about the origin, as
 * lf_test_grid_scene has it. Takes the grid. */
static void kindle(lf_scene *scene, lf_grid *grid, double voxel, double tilt, bool nearest,
                   lf_vec3 colour, double kelvin)
{
    lf_scene *other = lf_test_grid_scene("{" CAMERA("") ", " LF_TEST_VOLUMES("") "}", grid, voxel,
                                         tilt, 1.0f, nearest);
    assert_int_equal(scene->emissive.n, 1);
    scene->emissive.field[0] = other->volumes[0];
    scene->emissive.field[0].slice_cell = scene->emissive.field[0].voxel;
    other->volumes[0].grid = NULL;
    lf_scene_unref(other);
    assert_true(lf_volume_emission_init(&scene->emissive.light[0], colour, kelvin,
                                        (double)scene->emissive.field[0].sigma_max) > 0.0);
}

#define DARK(lens)                                                                                 \
    "{" CAMERA(lens) ", 'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0 }, 'w': { "  \
                     "'shape': 'box', 'density': 0, 'emission': 1 } } }"

/* Linear and nearest, straight and tilted: where emission is a multiple of extinction a ray finds
 * that multiple of 1 - T; the grid is wider than the picture. */
static void a_grid_that_absorbs_and_emits_is_its_closed_form(void **state)
{
    (void)state;
    for (int nearest = 0; nearest < 2; nearest++) {
        lf_scene *scene = lf_test_grid_scene(DARK(""), lf_test_grid(lf_test_full, 40, 32, 8), 0.125,
                                             0.0, 1.5f, nearest);
        kindle(scene, lf_grid_ref(scene->volumes[0].grid), 0.125, 0.0, nearest,
               lf_v3(2.0f, 2.0f, 2.0f), 0.0);
        assert_scene(scene, slab, 5, 48, 1e-4, 0);
    }
}

/* Voxels of another size and no density; black smoke of the shape's own, farther away than these.
 */
static void a_grid_in_vacuum_is_its_integral(void **state)
{
    (void)state;
    static const char *const lenses[] = {
        "{" CAMERA("") ", 'volumes': { 'w': { 'shape': 'box', 'density': 0, 'emission': 1 } } }",
        "{" CAMERA(LENS) ", 'volumes': { 'w': { 'shape': 'box', 'density': 0, 'emission': 1 } } }"};
    for (int i = 0; i < 4; i++) {
        lf_scene *scene = lf_test_scene(lenses[i / 2]);
        kindle(scene, lf_test_grid(lf_test_full, 24, 20, 4), 0.25, 0.0, i % 2,
               lf_v3(2.0f, 2.0f, 2.0f), 0.0);
        assert_scene(scene, slab_in_vacuum, 5, 32, 1e-3, 0);
    }
}

static double half_in_vacuum(double x0, double mx, double my)
{
    return 0.5 * slab_in_vacuum(x0, mx, my);
}

static void a_surface_hides_what_of_a_grid_is_behind_it(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("wall-in-emissive-box"));
    kindle(scene, lf_test_grid(lf_test_full, 40, 32, 8), 0.125, 0.0, false, lf_v3(2.0f, 2.0f, 2.0f),
           0.0);
    assert_scene(scene, half_in_vacuum, 5, 32, 1e-3, 0);
}

#define GRID_FURNACE(lens, g, more)                                                                \
    "{" CAMERA(lens) ", 'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0.6, 'g': " g  \
                     "}, 'w': { 'shape': 'box', 'density': 0, 'emission': 1 } }, 'lights': { "     \
                     "'sky': { 'type': "                                                           \
                     "'environment', 'radiance': 1 } }" more " }"

/* Voxels of every density, a third of them, two mean free paths each; the flame is a volume of its
 * own without any. */
static void a_grid_in_a_furnace_makes_up_for_what_it_absorbs(void **state)
{
    (void)state;
    for (int nearest = 0; nearest < 2; nearest++) {
        lf_scene *scene =
            lf_test_grid_scene(nearest ? GRID_FURNACE("", "0.5", "") : GRID_FURNACE(LENS, "0", ""),
                               lf_test_grid(lf_test_rough, 12, 10, 9), 0.15, 0.4, 12.0f, nearest);
        kindle(scene, lf_grid_ref(scene->volumes[0].grid), 0.15, 0.4, nearest,
               lf_v3(4.8f, 4.8f, 4.8f), 0.0);
        assert_scene(scene, one, 15, 32, 1e-4, 1);
    }
}

/* --------------------------------------------------------------------------- behind surfaces -- */

#define SHEET(name, z)                                                                             \
    "'" name "': { 'shape': 'quad', 'material': 'black', 'transform': { 'scale': 60, 'rotate': "   \
    "[90, 0, 0], 'translate': [0, 0, " z "] } }"
#define BLACK "'materials': { 'black': { 'albedo': 0 } }"

/* Lets so much of the scene's sheets be there, which stop light and send out none. */
static void thin_out(lf_scene *scene, float alpha)
{
    for (int i = 0; i < scene->n_materials; i++) {
        scene->materials[i].cover = LF_COVER_BLEND;
        scene->materials[i].alpha = alpha;
    }
    scene->traits |= LF_TRAIT_ALPHA;
}

/* A sheet of alpha 0.4 in the middle of the slab, another of 0.3 before it. */
static double slab_behind_sheets(double x0, double mx, double my)
{
    (void)x0;
    double half = 0.75 * length_of(mx, my), part = 2.0 / 1.5 * (1.0 - exp(-half));
    return 0.6 * (part + 0.6 * exp(-half) * part);
}

static void sheets_before_and_within_dim_what_is_behind_them(void **state)
{
    (void)state;
    static const char sheets[] = "{" CAMERA("") ", 'volumes': {" SLAB(
        "1.5", "0", "") "}, "
                        "'meshes': { " SHEET("a", "0") ", " SHEET("b", "0.9") " }, " BLACK " }";
    lf_scene *scene = lf_test_scene(sheets);
    thin_out(scene, 0.4f);
    assert_scene(scene, slab_behind_sheets, 5, 24, 1e-4, 0);
    for (int nearest = 0; nearest < 2; nearest++) {
        scene = lf_test_grid_scene(
            "{" CAMERA(
                "") ", 'volumes': { 'v': { 'shape': 'box', 'density': 1, 'albedo': 0 }, "
                    "'w': { 'shape': 'box', 'density': 0, 'emission': 1 } }, 'meshes': { " SHEET(
                        "a", "0") ", " SHEET("b", "0.9") " }, " BLACK " }",
            lf_test_grid(lf_test_full, 40, 32, 8), 0.125, 0.0, 1.5f, nearest);
        kindle(scene, lf_grid_ref(scene->volumes[0].grid), 0.125, 0.0, nearest,
               lf_v3(2.0f, 2.0f, 2.0f), 0.0);
        thin_out(scene, 0.4f);
        assert_scene(scene, slab_behind_sheets, 10, 32, 1e-4, 0);
    }
}

enum { STACK = LF_ALPHA_CROSSINGS_KEPT + 5 };

/* Sheets of alpha 0.06, evenly within the slab and as many before it: either more than a fan keeps.
 */
static double slab_in_a_stack(double x0, double mx, double my)
{
    double sum = 0.0, passed = pow(0.94, STACK);
    for (int i = 0; i <= STACK; i++, passed *= 0.94)
        sum += passed * (i == 0 || i == STACK ? 0.5 : 1.0) / STACK;
    return sum * slab_in_vacuum(x0, mx, my);
}

static void of_many_sheets_none_is_forgotten(void **state)
{
    (void)state;
    char text[STACK * 300 + 1000];
    for (int grid = 0; grid < 2; grid++) {
        char *at = text;
        at += sprintf(at, "{" CAMERA("") ", 'volumes': {" SLAB("0", "1", "") "}, " BLACK
                                                                             ", 'meshes': { ");
        for (int i = 0; i < STACK; i++)
            at +=
                sprintf(at, SHEET("a%d", "%.9g") ", " SHEET("b%d", "%.9g") "%s", i,
                        0.5 - (i + 0.5) / STACK, i, 1.5 + 0.05 * i, i + 1 < STACK ? ", " : " } }");
        lf_scene *scene = lf_test_scene(text);
        if (grid)
            kindle(scene, lf_test_grid(lf_test_full, 40, 32, 8), 0.125, 0.0, true,
                   lf_v3(2.0f, 2.0f, 2.0f), 0.0);
        thin_out(scene, 0.06f);
        assert_scene(scene, slab_in_a_stack, 5, 24, 1e-3, 0);
    }
}

static double fresnel(double cosine)
{
    double c = sqrt(1.0 - (1.0 - cosine * cosine) / 2.25),
           s = (cosine - 1.5 * c) / (cosine + 1.5 * c), p = (1.5 * cosine - c) / (1.5 * cosine + c);
    return 0.5 * (s * s + p * p);
}

static double tilt; /* of the pane, degrees about x */

/* A pane of albedo 0.9 through the origin, a small ball that shines 4 behind it: 9 from the camera.
 * What the pane reflects passes the ball by. */
static double ball_behind_a_pane(double x0, double mx, double my)
{
    const double radius = 0.4, turn = tilt * 0.017453292519943295;
    double a = 1.0 + mx * mx + my * my, b = x0 * mx - 9.0, c = x0 * x0 + 81.0 - radius * radius,
           d = b * b - a * c, cosine = (cos(turn) + my * sin(turn)) / sqrt(a),
           f = fresnel(fabs(cosine));
    return 0.9 * (1.0 - 2.0 * f / (1.0 + f)) * (d > 0.0 ? 2.0 * sqrt(d / a) : 0.0);
}

static void a_pane_dims_what_shines_behind_it_at_every_angle(void **state)
{
    (void)state;
    static const double tilts[] = {0.0, 30.0, 60.0, 75.0};
    for (int i = 0; i < 4; i++) {
        tilt = tilts[i];
        const char *text = lf_test_scene_patched(
            "ball-behind-sheet", "{'meshes': {'pane': {'transform': {'rotate': [%g, 0, 0]}}}}",
            90.0 + tilt);
        assert_known(text, ball_behind_a_pane, 5, 8, 1e-3);
    }
}

/* B of every fourth column, and between. */
static void coarse_frames_are_dimmed_too(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{" CAMERA("") ", 'volumes': {" SLAB(
        "1.5", "0", "") "}, "
                        "'meshes': { " SHEET("a", "0.8") ", " SHEET("b", "0.9") " }, " BLACK " }");
    thin_out(scene, 0.4f);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_assert_ok(lf_renderer_pass_coarse(r, NULL, -1, NULL, NULL, NULL), NULL);
    for (int row = 0; row < height; row++) {
        const lf_film_known *known = lf_film_known_at(&r->film, row);
        for (int k = 0; k < n_views * width; k++) {
            double mx, my;
            lf_test_slopes(r, k / width, k % width + 0.5, row + 0.5, &mx, &my);
            lf_assert_close((double)known[k].b[0], 0.36 * slab(0.0, mx, my), 0.01, 0.0);
        }
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* ---------------------------------------------------------------------------------- in glass -- */

/* The cube is 2 wide, what shines in it 1 thick, in its middle. */
static double shine_in_absorbing_glass(double x0, double mx, double my)
{
    (void)x0;
    double s = length_of(mx, my);
    return 2.0 / 1.5 * (exp(-0.75 * s) - exp(-2.25 * s));
}

static void glass_dims_what_shines_within_by_its_own_way(void **state)
{
    (void)state;
    const char *text = lf_test_scene_text("emissive-slab-in-glass");
    assert_known(text, shine_in_absorbing_glass, 5, 4, 1e-4);
    lf_scene *scene = lf_test_scene(text);
    kindle(scene, lf_test_grid(lf_test_full, 12, 12, 8), 0.125, 0.0, true, lf_v3(2.0f, 2.0f, 2.0f),
           0.0);
    assert_scene(scene, shine_in_absorbing_glass, 15, 24, 1e-4, 0);
}

/* Of three channels that absorb what they emit, and scatter. */
static void what_glass_absorbs_is_made_up_for_in_a_furnace(void **state)
{
    (void)state;
    static const char *const patches[] = {"{}",
                                          "{'materials': {'glass': {'scattering': [4, 1, 2]}}}"};
    for (int i = 0; i < 2; i++)
        assert_scene(
            lf_test_scene(lf_test_scene_patched("emissive-glass-furnace", "%s", patches[i])), one,
            15, 16, 1e-3, 1);
}

/* -------------------------------------------------------------------------------- black body -- */

static double hot; /* what the next truth is */

static double slab_as_hot(double x0, double mx, double my)
{
    (void)x0;
    return hot * length_of(mx, my);
}

/* A grid of temperature 1 that stands for 1800 K. */
static void a_grid_of_temperature_glows_as_a_black_body(void **state)
{
    (void)state;
    double rgb[3];
    lf_black_body(1800.0, rgb);
    hot = pow(1800.0 / LF_EMISSION_KELVIN, 4.0) *
          (0.5 * 3.0 * rgb[0] + 0.3 * 2.0 * rgb[1] + 0.2 * 1.0 * rgb[2]);
    lf_scene *scene = lf_test_scene("{" CAMERA("") ", 'volumes': { 'w': { 'shape': 'box', "
                                                   "'density': 0, 'emission': 1 } } }");
    kindle(scene, lf_test_grid(lf_test_full, 40, 32, 8), 0.125, 0.0, true, lf_v3(3.0f, 2.0f, 1.0f),
           1800.0);
    assert_scene(scene, slab_as_hot, 5, 32, 1e-3, 0);
}

/* x, y of a linear Rec. 709 colour. */
static void chromaticity(const double rgb[3], double out_xy[2])
{
    static const double xyz[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                     {0.2126729, 0.7151522, 0.0721750},
                                     {0.0193339, 0.1191920, 0.9503041}};
    double c[3] = {0.0}, sum = 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[i] += xyz[i][j] * rgb[j];
    for (int i = 0; i < 3; i++)
        sum += c[i];
    out_xy[0] = c[0] / sum;
    out_xy[1] = c[1] / sum;
}

/* The Planckian locus as published (Wyszecki and Stiles; illuminant A at 2856 K); the fit of the
 * observer is good to some thousandths. */
static void black_bodies_have_the_colours_of_the_planckian_locus(void **state)
{
    (void)state;
    static const double known[][3] = {{2856, 0.4476, 0.4074},
                                      {4000, 0.3805, 0.3768},
                                      {6500, 0.3135, 0.3237},
                                      {10000, 0.2807, 0.2884}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double rgb[3], xy[2];
        lf_black_body(known[i][0], rgb);
        chromaticity(rgb, xy);
        assert_true(fabs(xy[0] - known[i][1]) < 0.004 && fabs(xy[1] - known[i][2]) < 0.004);
    }
    for (double kelvin = 1.0; kelvin < 1e6; kelvin *= 1.5) {
        double rgb[3];
        lf_black_body(kelvin, rgb);
        assert_true(fabs(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2] - 1.0) < 1e-9);
        assert_true(rgb[0] >= 0.0 && rgb[1] >= 0.0 && rgb[2] >= 0.0);
        assert_true(kelvin > 5000.0 || (rgb[0] > rgb[1] && rgb[1] >= rgb[2]));
    }
}

/* The table between its steps, to a thousandth of the brightest. */
static void a_table_of_temperatures_is_what_it_stands_for(void **state)
{
    (void)state;
    lf_volume_emission light;
    const double kelvin = 30.0, most = 80.0;
    double brightest = lf_volume_emission_init(&light, lf_v3(2.0f, 2.0f, 2.0f), kelvin, most);
    for (double value = 0.5; value <= most; value += 0.37) {
        double rgb[3], power = 2.0 * pow(kelvin * value / LF_EMISSION_KELVIN, 4.0);
        lf_black_body(kelvin * value, rgb);
        lf_vec3 is = lf_emission_radiance(&light, (float)value);
        assert_true(fabs((double)is.x - power * rgb[0]) < 1e-3 * brightest);
        assert_true(fabs((double)is.y - power * rgb[1]) < 1e-3 * brightest);
        assert_true(fabs((double)is.z - power * rgb[2]) < 1e-3 * brightest);
    }
    assert_true(lf_emission_radiance(&light, 0.0f).x == 0.0f);
    assert_true(lf_emission_power(&light, 0.0f) == 0.0f && lf_emission_power(&light, 1.0f) > 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slab_that_absorbs_and_emits_is_its_closed_form),
        cmocka_unit_test(a_slab_is_its_closed_form_through_a_lens),
        cmocka_unit_test(a_ball_that_absorbs_and_emits_is_its_closed_form),
        cmocka_unit_test(a_slab_that_reaches_into_smoke_is_its_closed_form),
        cmocka_unit_test(a_surface_hides_what_is_behind_it),
        cmocka_unit_test(emission_makes_up_for_absorption_in_a_furnace),
        cmocka_unit_test(a_wall_is_lit_by_what_emits_before_it),
        cmocka_unit_test(a_wall_is_lit_by_what_emits_in_vacuum),
        cmocka_unit_test(a_grid_that_absorbs_and_emits_is_its_closed_form),
        cmocka_unit_test(a_grid_in_vacuum_is_its_integral),
        cmocka_unit_test(a_surface_hides_what_of_a_grid_is_behind_it),
        cmocka_unit_test(a_grid_in_a_furnace_makes_up_for_what_it_absorbs),
        cmocka_unit_test(sheets_before_and_within_dim_what_is_behind_them),
        cmocka_unit_test(of_many_sheets_none_is_forgotten),
        cmocka_unit_test(a_pane_dims_what_shines_behind_it_at_every_angle),
        cmocka_unit_test(coarse_frames_are_dimmed_too),
        cmocka_unit_test(glass_dims_what_shines_within_by_its_own_way),
        cmocka_unit_test(what_glass_absorbs_is_made_up_for_in_a_furnace),
        cmocka_unit_test(a_grid_of_temperature_glows_as_a_black_body),
        cmocka_unit_test(black_bodies_have_the_colours_of_the_planckian_locus),
        cmocka_unit_test(a_table_of_temperatures_is_what_it_stands_for),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
