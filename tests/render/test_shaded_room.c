/* Light that arrives by walls alone: a room whose lamp is hidden from what the cameras see, held
 * against radiosity on a grid (tests/stat/radiosity.h), which shares no code with render/. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/shaded_room.h"

enum { width = 24, height = 18, block = 6, n_views = 5, blocks_of_views = 12 * n_views + 1 };

static const char *const integrators[] = {"mvpt", "vpt"};

/* blocks of two pictures with two integrators */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 2 * 2 * blocks_of_views)
/* relative error of the two finenesses extrapolated, by comparison with 6 and 8: at most 0.0008 */
#define ORACLE_ERROR 1e-3

/* Radiance of the wall at the back on a grid of points, x and y in -1..1. Radiosities of two
 * finenesses are extrapolated: their error is that of the square of a patch. */
enum { points = 25 };
typedef struct wall {
    lf_radiosity *direct;
    double indirect[points][points];
} wall;

static void wall_init(wall *w, int depth)
{
    const lf_room room = lf_shaded_room();
    const double n[3] = {0, 0, 1};
    memset(w, 0, sizeof *w);
    w->direct = lf_radiosity_solve(&room, 1, 1);
    for (int fineness = 2; fineness <= 3 && depth > 1; fineness++) {
        lf_radiosity *r = lf_radiosity_solve(&room, fineness, depth);
        double share = fineness == 3 ? 9.0 / 5.0 : -4.0 / 5.0;
        for (int j = 0; j < points; j++) {
            for (int i = 0; i < points; i++) {
                const double p[3] = {-0.85 + 1.7 * i / (points - 1), -0.85 + 1.3 * j / (points - 1),
                                     -1};
                w->indirect[j][i] += share * lf_radiosity_indirect(r, p, n);
            }
        }
        lf_radiosity_free(r);
    }
}

static double wall_radiance(const wall *w, double x, double y)
{
    const double p[3] = {x, y, -1}, n[3] = {0, 0, 1};
    double s = (x + 0.85) / 1.7 * (points - 1), t = (y + 0.85) / 1.3 * (points - 1);
    int i = (int)s, j = (int)t;
    assert_true(i >= 0 && i + 1 < points && j >= 0 && j + 1 < points);
    s -= i;
    t -= j;
    double indirect = (w->indirect[j][i] * (1.0 - s) + w->indirect[j][i + 1] * s) * (1.0 - t) +
                      (w->indirect[j + 1][i] * (1.0 - s) + w->indirect[j + 1][i + 1] * s) * t;
    return LF_SHADED_ROOM_BACK / M_PI * (lf_radiosity_direct(w->direct, p, n) + indirect);
}

/* Half a pixel's diagonal off its middle, four points each. */
static double *truth_picture(const lf_renderer *r, const wall *w)
{
    const double place[2] = {0.5 - sqrt(1.0 / 12.0), 0.5 + sqrt(1.0 / 12.0)}, distance = 6.4;
    double *out = malloc(sizeof *out * n_views * width * height), *p = out;
    for (int row = 0; row < height; row++) {
        for (int view = 0; view < n_views; view++) {
            for (int column = 0; column < width; column++, p++) {
                *p = 0.0;
                for (int i = 0; i < 4; i++) {
                    double mx, my, b = (double)lf_test_rows(r)->rig.b[view];
                    lf_test_slopes(r, view, column + place[i & 1], row + place[i >> 1], &mx, &my);
                    *p += 0.25 * wall_radiance(w, b + distance * mx, -0.2 + distance * my);
                }
            }
        }
    }
    return out;
}

/* p of all blocks against the radiosities, at most max_depth vertices. */
static double p_of(const char *text, const char *integrator, const wall *w, int cycles,
                   int *out_where, lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    double *truth = truth_picture(r, w);
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < 10; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    double p = lf_blocks_p(out, truth, ORACLE_ERROR, out_where);
    free(truth);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return p;
}

static void assert_radiosity(int depth, int cycles)
{
    wall w;
    wall_init(&w, depth);
    const char *text = lf_test_scene_patched("shaded-lamp", "{'render': {'max_depth': %d}}", depth);
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks;
        int where = 0;
        double p = p_of(text, integrators[i], &w, cycles, &where, &blocks);
        if (!(p > LEVEL))
            fail_msg("%s: block %d is %.6g +- %.2g, p %.2g", integrators[i], where,
                     blocks.moments[where].mean, lf_moments_error(&blocks.moments[where]), p);
        lf_blocks_finish(&blocks);
    }
    lf_radiosity_free(w.direct);
}

static void a_plate_hides_the_lamp(void **state)
{
    (void)state;
    assert_radiosity(1, 4);
}

static void walls_light_what_the_lamp_does_not_reach(void **state)
{
    (void)state;
    assert_radiosity(LF_SHADED_ROOM_DEPTH, 16);
}

/* Without the plate, and with a black floor. */
static void other_rooms_are_rejected(void **state)
{
    (void)state;
    static const char *const patches[] = {"{'meshes': {'plate': null}}",
                                          "{'materials': {'floor': {'albedo': 0}}}"};
    wall w;
    wall_init(&w, LF_SHADED_ROOM_DEPTH);
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks;
        const char *text = lf_test_scene_patched("shaded-lamp", "%s", patches[i]);
        double p = p_of(text, "mvpt", &w, 12, NULL, &blocks);
        if (!(p < 1e-6))
            fail_msg("%s: p %.2g", patches[i], p);
        lf_blocks_finish(&blocks);
    }
    lf_radiosity_free(w.direct);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plate_hides_the_lamp),
        cmocka_unit_test(walls_light_what_the_lamp_does_not_reach),
        cmocka_unit_test(other_rooms_are_rejected),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
