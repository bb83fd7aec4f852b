/* Volumes that flow by grids of velocity while the shutter is open: the grids of their steps
 * against closed forms, and against the same volume carried as a whole by its transform; every way
 * to say the same velocities; pictures against the mean of still ones, W and W' against n q, mvpt
 * against vpt by tiles, replicates being seeds. Negative controls: velocities turned round, and
 * twice as fast. The files are made by scenes/make_test_vdb.cc: a blob 1 - r^2 / 1.5^2 about (2,
 * 0.5, 0), in voxels of 1/4, one of temperatures in voxels of 1/2, velocities of (1.5, -0.5, 0.25),
 * of one turn about z in 2 pi seconds, and of (x, -y, 0) on faces. */
#include "tests/testing.h"

#include <limits.h>
#include <sched.h>

#include "render/scene/grid_flow.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { width = 32, height = 24, n_views = 3, tile = 8, tiles = n_views * 12 + 1 };

#define LEVEL lf_sidak(LF_FALSE_ALARM, 6 * tiles)
/* What a mistake must be rejected with. */
#define CERTAIN 1e-9

/* The way of a value in 2 seconds is of whole voxels, in both grids. */
static const double blob[3] = {2, 0.5, 0}, speed[3] = {1.5, -0.5, 0.25};

typedef struct said {
    double rate;                        /* frames a second */
    const char *file, *grid, *velocity; /* "" = none */
    double open, shutter;               /* frames */
    const char *more;                   /* of the volume */
} said;

static lf_scene *scene_after(const said *s, const char *transform, const lf_scene *previous)
{
    char path[PATH_MAX];
    assert_non_null(realpath(lf_test_built(s->file), path));
    const char *text = lf_test_scene_patched(
        "flowing-blob",
        "{'fps': %g, 'camera': {'shutter': %.17g, 'shutter_open': %.17g}, "
        "'volumes': {'v': {'file': '%s', 'grid': '%s'%s%s%s%s}}}",
        s->rate, s->shutter, s->open, path, s->grid, s->velocity[0] ? ", 'velocity': " : "",
        s->velocity, s->more, transform);
    return lf_test_scene_in(".", text, previous);
}

static lf_scene *scene_of(const said *s)
{
    return scene_after(s, "", NULL);
}

#define FLOWS 1, "testdata/flows.vdb", "density"
#define BAD_FLOWS 1, "testdata/bad_flows.vdb", "density"

/* The blob's own field, as far as voxels of this length resolve it. */
static double blob_at(const double p[3])
{
    double r2 = 0;
    for (int i = 0; i < 3; i++)
        r2 += (p[i] - blob[i]) * (p[i] - blob[i]);
    return fmax(1 - r2 / (1.5 * 1.5), 0);
}

/* What trilinear interpolation leaves of it at most: the second derivative is 2 / 1.5^2 a
 * dimension, and at the rim the slope is lost. */
static double coarse(double voxel)
{
    return 3 * voxel * voxel / 8 * 2 / (1.5 * 1.5) + 1e-4;
}

/* A volume as it is at a moment, at a point of the world. */
static double value_at(const lf_scene *scene, const lf_volume *volume, double time,
                       const double p[3])
{
    lf_volume moved = *volume;
    lf_volume_move(&moved, (float)time);
    return (double)lf_volume_sigma_t(&moved, lf_v3((float)(p[0] - scene->origin[0]),
                                                   (float)(p[1] - scene->origin[1]),
                                                   (float)(p[2] - scene->origin[2])));
}

/* Point n of a lattice of this spacing about the blob's way, which goes through 0. */
static void point(int n, double spacing, double out[3])
{
    const int in[3] = {n % 29, n / 29 % 23, n / 29 / 23};
    for (int i = 0; i < 3; i++)
        out[i] = spacing * (in[i] - 9);
}
enum { points = 29 * 23 * 19 };

/* ------------------------------------------------------------------------------------- grids -- */

static void whole_voxels_are_the_blob_carried_as_a_whole(void **state)
{
    (void)state;
    const said flowing = {FLOWS, "{'steps': 2}", 0, 4, ", 'emission': {'temperature_scale': 1500}"};
    lf_scene *flows = scene_of(&flowing);
    const said carried = {FLOWS, "", 0, 4, ""};
    /* Goes evenly, 4 seconds long. */
    lf_scene *goes = scene_after(
        &carried, ", 'transform': {'translate': {'keys': [[1, [0, 0, 0]], [5, [6, -2, 1]]]}}",
        NULL);
    assert_non_null(flows->volumes[0].steps);
    assert_int_equal(flows->volumes[0].steps->n, 2);
    assert_true(lf_has(flows, LF_TRAIT_MOTION));
    int there = 0;
    for (int step = 0; step < 2; step++)
        for (int n = 0; n < points; n++) {
            double p[3], time = (step + 0.5) / 2;
            point(n, 0.3, p);
            double a = value_at(flows, &flows->volumes[0], time, p),
                   b = value_at(goes, &goes->volumes[0], time, p);
            lf_assert_close(a, b, 0, 2e-5);
            /* all through its part of the shutter */
            assert_true(value_at(flows, &flows->volumes[0], time + 0.24, p) == a);
            assert_true(value_at(flows, &flows->volumes[0], time - 0.25, p) == a);
            there += b > 0.1;
        }
    assert_true(there > 500);
    lf_scene_unref(flows);
    lf_scene_unref(goes);
}

static void what_is_emitted_and_scattered_flows_along(void **state)
{
    (void)state;
    const said s = {
        FLOWS, "{'steps': 3}", -0.5, 2,
        ", 'emission': {'grid': 'temperature', 'temperature_scale': 1500}, 'albedo': {'red': "
        "'temperature', 'green': 'density', 'blue': 'density'}"};
    lf_scene *scene = scene_of(&s);
    const lf_volume *fields[] = {&scene->emissive.field[0], &scene->volumes[0].albedo_fields[0],
                                 &scene->volumes[0].albedo_fields[1]};
    for (int f = 0; f < 3; f++)
        for (int step = 0; step < 3; step++)
            for (int n = 0; n < points; n++) {
                double p[3], from[3], time = (step + 0.5) / 3, t = -0.5 + 2 * time;
                point(n, 0.25, p);
                for (int i = 0; i < 3; i++)
                    from[i] = p[i] - t * speed[i];
                if (blob_at(from) > 0.35) /* off the rim */
                    lf_assert_close(value_at(scene, fields[f], time, p), blob_at(from), 0,
                                    2 * coarse(f < 2 ? 0.5 : 0.25));
            }
    /* what it is drawn by holds at all times */
    for (int step = 0; step < 3; step++) {
        const lf_volume *v = &scene->volumes[0], *emissive = &scene->emissive.field[0];
        assert_true(v->steps->grid[step]->max_value > 0.95f);
        assert_true(v->steps->grid[step]->max_value <= v->sigma_max);
        assert_true(emissive->steps->grid[step]->max_value <= emissive->sigma_max);
    }
    lf_scene_unref(scene);
}

/* Of a map that turns and shears: velocities are the world's, and voxels lie elsewhere. */
static void a_grid_that_stands_askew_flows_as_well(void **state)
{
    (void)state;
    const said s = {1, "testdata/flows.vdb", "slant", "{'steps': 3}", -0.5, 2, ""};
    lf_scene *scene = scene_of(&s);
    int there = 0;
    for (int step = 0; step < 3; step++)
        for (int n = 0; n < points; n++) {
            double p[3], from[3], time = (step + 0.5) / 3, t = -0.5 + 2 * time;
            point(n, 0.25, p);
            for (int i = 0; i < 3; i++)
                from[i] = p[i] - t * speed[i];
            there += blob_at(from) > 0.35;
            if (blob_at(from) > 0.35)
                lf_assert_close(value_at(scene, &scene->volumes[0], time, p), blob_at(from), 0,
                                3 * coarse(0.25));
        }
    assert_true(there > 500);
    lf_scene_unref(scene);
}

/* A turn by semi-Lagrangian steps has a closed form: x - t J (x - t J x) = (1 - t^2) x - t J x; and
 * so has what goes apart along x and together along y, (x, -y, 0): (1 - t + t^2) x, (1 + t + t^2)
 * y. */
static void a_turn_is_its_closed_form(void **state)
{
    (void)state;
    static const char *const words[] = {"{'grid': 'turn', 'steps': 4}",
                                        "{'grid': 'faces', 'steps': 4}",
                                        "{'grid': 'tilted', 'steps': 4}"};
    const said quiet = {FLOWS, "", 0, 0, ""};
    lf_scene *before = scene_of(&quiet);
    for (int form = 0; form < 3; form++) {
        const said s = {FLOWS, words[form], 0, 0.32, ""};
        lf_scene *scene = scene_of(&s);
        double off = 0, still = 0;
        for (int step = 0; step < 4; step++)
            for (int n = 0; n < points; n++) {
                double p[3], time = (step + 0.5) / 4, t = 0.32 * time;
                point(n, 0.25, p);
                const bool turns = form != 1;
                const double from[3] = {turns ? (1 - t * t) * p[0] + t * p[1]
                                              : (1 - t + t * t) * p[0],
                                        turns ? (1 - t * t) * p[1] - t * p[0]
                                              : (1 + t + t * t) * p[1],
                                        p[2]},
                             turned[3] = {turns ? cos(t) * p[0] + sin(t) * p[1] : exp(-t) * p[0],
                                          turns ? cos(t) * p[1] - sin(t) * p[0] : exp(t) * p[1],
                                          p[2]};
                double value = value_at(scene, &scene->volumes[0], time, p);
                /* the lattice's points are voxels: one look-up of the grid as it was */
                lf_assert_close(value, value_at(before, &before->volumes[0], 0, from), 0, 1e-4);
                if (blob_at(turned) > 0.35) {
                    off = fmax(off, fabs(value - blob_at(turned)));
                    still = fmax(still, fabs(blob_at(p) - blob_at(turned)));
                }
            }
        print_message("off the turn: %.3f, standing still %.3f\n", off, still);
        /* the first order is off by t^2 / 2 of the radius, times the blob's slope of 1.33 */
        assert_true(off < coarse(0.25) + 1.34 * 0.5 * 0.28 * 0.28 * 3.6);
        assert_true(still > 3 * off);
        lf_scene_unref(scene);
    }
    lf_scene_unref(before);
}

/* Voxel by voxel. */
static double largest_difference(const lf_scene *a, const lf_scene *b, double *out_largest)
{
    double most = 0;
    *out_largest = 0;
    for (int step = 0; step < 4; step++)
        for (int n = 0; n < points; n++) {
            double p[3], time = (step + 0.5) / 4;
            point(n, 0.25, p);
            double x = value_at(a, &a->volumes[0], time, p),
                   y = value_at(b, &b->volumes[0], time, p);
            most = fmax(most, fabs(x - y));
            *out_largest = fmax(*out_largest, x);
        }
    return most;
}

static void every_way_to_say_the_same_velocities(void **state)
{
    (void)state;
    static const struct {
        double rate; /* all takes 2 seconds */
        const char *velocity;
        bool same;
    } cases[] = {
        {4, "{'grid': 'velocity', 'steps': 4}", true},
        {4, "{'grid': 'velocity', 'steps': 4, 'per': 'frame', 'scale': 0.25}", true},
        {4, "{'grid': 'velocity', 'steps': 4, 'per': 'frame'}", false},
        {1, "{'grid': 'velocity', 'steps': 4}", true},
        {1, "{'grid': 'vel', 'steps': 4}", true},
        {1, "{'x': 'vel.x', 'y': 'vel.y', 'z': 'vel.z', 'steps': 4}", true},
        {1, "{'x': 'u', 'y': 'velocity.y', 'z': 'vel.z', 'steps': 4, 'scale': 1, 'per': 'frame'}",
         true},
        {1, "{'grid': 'in_voxels', 'units': 'voxels', 'steps': 4}", true},
        /* negative controls */
        {1, "{'x': 'vel.y', 'y': 'vel.x', 'z': 'vel.z', 'steps': 4}", false},
        {1, "{'grid': 'velocity', 'steps': 4, 'scale': 2}", false},
        {1, "{'grid': 'velocity', 'steps': 4, 'scale': -1}", false},
        {1, "{'grid': 'in_voxels', 'steps': 4}", false},
        {1, "{'grid': 'turn', 'steps': 4}", false},
    };
    const said first = {FLOWS, "{'steps': 4}", -0.5, 2, ""};
    lf_scene *truth = scene_of(&first);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const said s = {cases[i].rate,        "testdata/flows.vdb", "density", cases[i].velocity,
                        -0.5 * cases[i].rate, 2 * cases[i].rate,    ""};
        lf_scene *scene = scene_of(&s);
        double largest, off = largest_difference(truth, scene, &largest);
        if ((off < 1e-4) != cases[i].same || largest < 0.9 || (!cases[i].same && off < 0.1))
            fail_msg("%s: %g off, of %g", cases[i].velocity, off, largest);
        lf_scene_unref(scene);
    }
    lf_scene_unref(truth);
}

/* By name alone there are 8 steps. */
static void a_name_is_enough(void **state)
{
    (void)state;
    const said s = {FLOWS, "'velocity'", -0.5, 1, ""};
    lf_scene *scene = scene_of(&s);
    assert_int_equal(scene->volumes[0].steps->n, 8);
    assert_ptr_equal(scene->volumes[0].grid, scene->volumes[0].steps->grid[4]);
    lf_scene_unref(scene);
}

/* Nothing is known of velocities there: everything stands still, to the bit. */
static void where_there_are_no_velocities_nothing_moves(void **state)
{
    (void)state;
    const said s = {FLOWS, "{'grid': 'far', 'steps': 3}", 0, 10, ""}, quiet = {FLOWS, "", 0, 0, ""};
    lf_scene *scene = scene_of(&s), *still = scene_of(&quiet);
    const lf_grid *was = still->volumes[0].grid;
    for (int step = 0; step < 3; step++) {
        const lf_grid *grid = scene->volumes[0].steps->grid[step];
        for (int z = -2; z <= was->size[2] + 1; z++)
            for (int y = -2; y <= was->size[1] + 1; y++)
                for (int x = -2; x <= was->size[0] + 1; x++)
                    assert_true(lf_grid_linear(grid, (float)x, (float)y, (float)z) ==
                                lf_grid_linear(was, (float)x, (float)y, (float)z));
    }
    assert_memory_equal(was->local_to_file, scene->volumes[0].grid->local_to_file,
                        sizeof was->local_to_file);
    lf_scene_unref(scene);
    lf_scene_unref(still);
}

/* Values to the bit, on one CPU and on all. */
static void the_number_of_cpus_changes_nothing(void **state)
{
    (void)state;
    const said s = {FLOWS, "{'grid': 'turn', 'steps': 5}", -0.5, 2, ""};
    cpu_set_t all, one;
    assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
    CPU_ZERO(&one);
    for (size_t i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; i++)
        if (CPU_ISSET(i, &all))
            CPU_SET(i, &one);
    lf_scene *scenes[2] = {scene_of(&s), NULL};
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    scenes[1] = scene_of(&s);
    assert_int_equal(sched_setaffinity(0, sizeof all, &all), 0);
    for (int step = 0; step < 5; step++) {
        const lf_grid *a = scenes[0]->volumes[0].steps->grid[step],
                      *b = scenes[1]->volumes[0].steps->grid[step];
        assert_ptr_not_equal(a, b);
        assert_int_equal(a->n_bricks, b->n_bricks);
        assert_memory_equal(a->values, b->values,
                            (size_t)a->n_bricks * LF_BRICK_STRIDE * sizeof *a->values);
    }
    lf_scene_unref(scenes[0]);
    lf_scene_unref(scenes[1]);
}

static void halves_are_rounded(void **state)
{
    (void)state;
    const said exact = {FLOWS, "{'steps': 4}", -0.5, 2, ""},
               half = {FLOWS, "{'steps': 4}", -0.5, 2, ", 'precision': 'half'"};
    lf_scene *a = scene_of(&exact), *b = scene_of(&half);
    double largest;
    assert_non_null(b->volumes[0].steps->grid[1]->shorts);
    assert_true(largest_difference(a, b, &largest) < 2 * 0x1p-11);
    lf_scene_unref(a);
    lf_scene_unref(b);
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* A bright and thick blob, which glows. */
#define LOOK                                                                                       \
    ", 'scale': 4, 'albedo': [0.9, 0.8, 0.7], 'g': 0.3, 'emission': {'grid': 'temperature', "      \
    "'temperature_scale': 1500, 'scale': 0.2}"

static lf_scene *flowing_scene(const char *velocity)
{
    const said s = {FLOWS, velocity, 1, 4, LOOK};
    return scene_after(&s, ", 'transform': {'scale': 0.35, 'translate': [-2.275, 0.35, -0.2]}",
                       NULL);
}

static int long_or(int replicates)
{
    return getenv("QUILTD_LONG") ? 8 * replicates : replicates;
}

static void six_cycles(lf_renderer *r)
{
    lf_test_cycles(r, 6);
}

static void blurred(const char *velocity, const char *integrator, uint64_t salt, lf_blocks *out)
{
    lf_scene *scene = flowing_scene(velocity);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_test_pictures(r, six_cycles, LF_ESTIMATOR_MIS, long_or(16), salt, tile, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* The mean of two still pictures, where its values have gone by 2 and by 4 seconds, as a whole: by
 * the transform, and without velocities. */
static void stills(uint64_t salt, lf_blocks *out)
{
    lf_renderer *r[2];
    lf_blocks_init(out, n_views, width, height, tile);
    for (int m = 0; m < 2; m++) {
        const said s = {FLOWS, "", 0, 0, LOOK};
        char transform[256];
        double t = 2.0 + 2.0 * m;
        snprintf(transform, sizeof transform,
                 ", 'transform': {'scale': 0.35, 'translate': [%.17g, %.17g, %.17g]}",
                 -2.275 + 0.35 * t * speed[0], 0.35 + 0.35 * t * speed[1],
                 -0.2 + 0.35 * t * speed[2]);
        lf_scene *scene = scene_after(&s, transform, NULL);
        r[m] = lf_test_renderer(scene, "vpt", width, height, NULL);
        lf_scene_unref(scene);
    }
    for (int k = 0; k < long_or(16); k++) {
        double mean[width * height * n_views] = {0};
        for (int m = 0; m < 2; m++) {
            lf_test_reseed(r[m], lf_hash64(lf_test_seed() + salt, (uint64_t)(2 * k + m)));
            lf_test_cycles(r[m], 6);
            double *picture = lf_test_picture(r[m], LF_ESTIMATOR_MIS);
            for (int i = 0; i < width * height * n_views; i++)
                mean[i] += picture[i] / 2;
            free(picture);
        }
        lf_blocks_add(out, mean);
    }
    lf_renderer_destroy(r[0]);
    lf_renderer_destroy(r[1]);
}

static void a_blurred_picture_is_the_mean_of_its_steps(void **state)
{
    (void)state;
    static const char *const wrong[] = {"{'steps': 2, 'scale': -1}", "{'steps': 2, 'scale': 2}",
                                        "{'steps': 1}"};
    lf_blocks still, open, native;
    int where = 0;
    stills(10, &still);
    blurred("{'steps': 2}", "mvpt", 20, &open);
    blurred("{'steps': 2}", "vpt", 30, &native);
    double p = lf_blocks_welch(&open, &still, &where),
           of_vpt = lf_blocks_welch(&native, &still, NULL),
           both = lf_blocks_welch(&open, &native, NULL);
    const lf_moments *a = &open.moments[where], *b = &still.moments[where];
    print_message("block %d: %.5g +- %.2g, stills %.5g +- %.2g, p %.2g; vpt %.2g, mvpt against vpt "
                  "%.2g\n",
                  where, a->mean, lf_moments_error(a), b->mean, lf_moments_error(b), p, of_vpt,
                  both);
    assert_true(p > LEVEL && of_vpt > LEVEL && both > LEVEL);
    /* 4 % of the whole picture would be seen. */
    assert_true(lf_blocks_welch_injected(&open, &still, tiles - 1, 1.04) < LEVEL);
    assert_true(lf_blocks_welch_injected(&open, &still, tiles - 1, 0.96) < LEVEL);
    lf_blocks_finish(&open);
    lf_blocks_finish(&native);
    for (int i = 0; i < 3; i++) {
        blurred(wrong[i], "mvpt", 40, &open);
        p = lf_blocks_welch(&open, &still, NULL);
        print_message("%s: p %.2g\n", wrong[i], p);
        assert_true(p < CERTAIN);
        lf_blocks_finish(&open);
    }
    lf_blocks_finish(&still);
}

static void weights_are_what_is_expected(void **state)
{
    (void)state;
    lf_blocks found[3];
    lf_scene *scene = flowing_scene("{'steps': 4}");
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_test_weight_blocks(r, six_cycles, long_or(16), tile, found);
    /* Where the blob's rim is a chance of 1e-12 it is never met, and W is 0 for good: tiles count
     * that expect ten collisions in a test of 16 replicates. */
    const double rare = 10.0 / (16 * 6 * tile * tile);
    double p = 1;
    int n = 0;
    for (int i = 0; i < tiles; i++)
        if (found[2].moments[i].mean > rare) {
            p = fmin(p,
                     fmin(lf_p_mean(&found[0].moments[i], 0), lf_p_mean(&found[1].moments[i], 0)));
            n++;
        }
    assert_true(n > 15);
    print_message("p %.2g\n", p);
    assert_true(p > LEVEL);
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&found[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void the_number_of_threads_changes_nothing(void **state)
{
    (void)state;
    lf_scene *scene = flowing_scene("'velocity'");
    double *one = lf_test_picture_by(scene, width, height, 1),
           *two = lf_test_picture_by(scene, width, height, 2);
    assert_memory_equal(one, two, width * height * n_views * sizeof *one);
    free(one);
    free(two);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------------- words -- */

static void what_is_no_velocity_is_refused_in_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *velocity, *words;
    } bad[] = {
        {"'frustum'", "not affine"},
        {"'wind'",
         "no vector grid \"wind\" (nor \"wind.x\", \".y\", \".z\"); the file has density"},
        {"'density'", "grid \"density\" is not a vector grid, but float (and no \"density.x\""},
        {"{'x': 'fast.x', 'y': 'gone', 'z': 'gone'}", "no grid \"gone\"; the file has"},
        {"{'x': 'fast', 'y': 'fast.y', 'z': 'fast.z'}",
         "of type Tree_vec3s_5_4_3; a component of a velocity is float, half or double"},
        {"{'grid': 'fast', 'x': 'fast.x'}", "expected one \"grid\", or x, y and z"},
        {"{'x': 'fast.x', 'y': 'fast.y'}", "\"z\" is missing"},
        {"{'y': 'fast.y'}", "expected one \"grid\", or x, y and z"},
        {"{'steps': 65}", "65 is out of range: 1 to 64"},
        {"{'unit': 'file'}", "unknown key"},
        {"3", "expected"},
    };
    char path[PATH_MAX], text[PATH_MAX + 512];
    assert_non_null(realpath(lf_test_built("testdata/bad_flows.vdb"), path));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(text, sizeof text,
                 "{\"camera\": {\"shutter\": 1}, \"volumes\": {\"v\": {\"file\": \"%s\", "
                 "\"velocity\": %s}}}",
                 path, bad[i].velocity);
        for (char *c = text; *c; c++)
            *c = *c == '\'' ? '"' : *c;
        json_t *doc = json_loads(text, 0, NULL);
        lf_error err = {0};
        lf_scene *scene = NULL;
        assert_non_null(doc);
        assert_int_equal(lf_scene_from_json(doc, "/", "t", NULL, NULL, &scene, &err), LF_E_FORMAT);
        if (!strstr(err.what, bad[i].words) || !strstr(err.pointer, "/volumes/v/velocity") ||
            strchr(err.what, '\n'))
            fail_msg("%s: %s: %s", bad[i].velocity, err.pointer, err.what);
        json_decref(doc);
    }
}

/* One voxel of 1 goes half a voxel on: two of 1/2. sum f^2 / sum f falls from 1 to 1/2, and the
 * scale says what that is in mean free paths. */
static void a_density_that_is_too_rough_to_flow_is_refused(void **state)
{
    (void)state;
    static const char velocity[] = "{'grid': 'steady', 'per': 'frame', 'steps': 1}";
    const said thin = {BAD_FLOWS, velocity, 0, 1, ", 'scale': 0.27"},
               still = {BAD_FLOWS, "{'grid': 'steady', 'scale': 0}", 0, 1, ", 'scale': 100"};
    lf_scene *scene = scene_of(&thin);
    lf_assert_close((double)scene->volumes[0].steps->lost, 0.5, 1e-6, 0.0);
    lf_scene_unref(scene);
    scene = scene_of(&still);
    assert_true(scene->volumes[0].steps->lost == 0.0f);
    lf_scene_unref(scene);
    char path[PATH_MAX], text[PATH_MAX + 512];
    assert_non_null(realpath(lf_test_built("testdata/bad_flows.vdb"), path));
    snprintf(text, sizeof text,
             "{'camera': {'shutter': 1}, 'volumes': {'v': {'file': '%s', 'scale': 0.29, "
             "'velocity': %s}}}",
             path, velocity);
    lf_test_assert_refused(".", text, "/volumes/v/velocity", "too rough for \"velocity\"");
}

/* Velocities of any size are taken: what they carry is gone, and nothing comes of what is not. */
static void what_is_too_fast_is_gone(void **state)
{
    (void)state;
    const said s = {BAD_FLOWS, "{'grid': 'fast', 'scale': 1e9}", 1, 1, ""};
    lf_scene *scene = scene_of(&s);
    for (int k = 0; k < 8; k++)
        assert_int_equal(scene->volumes[0].steps->grid[k]->n_bricks, 0);
    assert_true(scene->volumes[0].sigma_max == 0.0f);
    lf_scene_unref(scene);
}

/* Two thousand million million bricks, and twenty thousand of 64 steps. */
static void what_takes_too_much_memory_is_refused_before_it_does(void **state)
{
    (void)state;
    char path[PATH_MAX], text[PATH_MAX + 512];
    lf_error err = {0};
    lf_scene *scene = NULL;
    lf_grid_steps *steps = NULL;
    assert_non_null(realpath(lf_test_built("testdata/bad_flows.vdb"), path));
    snprintf(text, sizeof text,
             "{\"camera\": {\"shutter\": 1}, \"volumes\": {\"v\": {\"file\": \"%s\", "
             "\"velocity\": \"vast\"}}}",
             path);
    json_t *doc = json_loads(text, 0, NULL);
    assert_int_equal(lf_scene_from_json(doc, "/", "t", NULL, NULL, &scene, &err), LF_E_NOMEM);
    assert_non_null(strstr(err.what, "its velocities spread it over"));
    json_decref(doc);
    lf_grid *full = lf_test_grid(lf_test_full, 239, 239, 207),
            *one = lf_test_grid(lf_test_full, 1, 1, 1);
    lf_flow flow = {.component = {one, one, one}, .n = LF_MAX_STEPS};
    lf_assert_status(lf_grid_flow(full, &flow, &steps, &err), LF_E_NOMEM, &err);
    assert_non_null(strstr(err.what, "its 64 steps need 4.1 GiB, but the limit is 4 GiB"));
    lf_grid_unref(full);
    lf_grid_unref(one);
}

static int warnings_with(const lf_scene *scene, const char *words)
{
    int n = 0;
    for (int i = 0; i < scene->warnings.n; i++)
        n += !!strstr(scene->warnings.line[i], words);
    return n;
}

static void velocities_that_nothing_goes_by_are_told_once(void **state)
{
    (void)state;
    const said cases[] = {{FLOWS, "", 0, 0, ""},
                          {FLOWS, "", 0, 1, ""},
                          {FLOWS, "'velocity'", 0, 1, ""},
                          {FLOWS, "'velocity'", 0, 0, ""},
                          {1, "testdata/block.vdb", "density", "", 0, 1, ""},
                          {BAD_FLOWS, "'none'", 0, 1, ""}};
    static const int told[] = {0, 1, 0, 0, 0, 0}, unused[] = {1, 1, 1, 1, 0, 1};
    for (int i = 0; i < 6; i++) {
        lf_scene *scene = scene_of(&cases[i]);
        assert_int_equal(warnings_with(scene, "the shutter is open"), told[i]);
        assert_int_equal(warnings_with(scene, "unused grids: "), unused[i]);
        if (i == 0) /* as ever */
            assert_int_equal(warnings_with(scene, "unused grids: temperature, velocity"), 1);
        if (i == 1)
            assert_int_equal(warnings_with(scene, "not used: velocity, vel.x, vel.y, vel.z; set"),
                             1);
        assert_int_equal(
            warnings_with(scene, "velocity grids are empty: the volume \"v\" does not move"),
            i == 5);
        lf_scene_unref(scene);
    }
}

static void steps_are_shared_and_the_subject_knows_them(void **state)
{
    (void)state;
    const said open = {FLOWS, "'velocity'", 0, 1, ", 'emission': {}"},
               longer = {FLOWS, "'velocity'", 0, 2, ", 'emission': {}"},
               closed = {FLOWS, "'velocity'", 0, 0, ", 'emission': {}"},
               plain = {FLOWS, "", 0, 0, ", 'emission': {}"};
    lf_scene *a = scene_of(&open), *b = scene_after(&open, "", a), *c = scene_after(&longer, "", b),
             *d = scene_after(&closed, "", c), *e = scene_of(&plain);
    assert_ptr_equal(a->volumes[0].steps, b->volumes[0].steps);
    assert_ptr_equal(a->emissive.field[0].steps, b->emissive.field[0].steps);
    assert_ptr_not_equal(a->volumes[0].steps, c->volumes[0].steps);
    assert_ptr_not_equal(a->volumes[0].steps, a->emissive.field[0].steps);
    assert_true(json_equal(a->subject, b->subject));
    assert_false(json_equal(a->subject, c->subject));
    assert_true(json_equal(d->subject, e->subject));
    assert_false(lf_has(d, LF_TRAIT_MOTION) || d->volumes[0].steps);
    assert_string_equal(d->volumes[0].grid->digest.text, a->volumes[0].grid->digest.text);
    lf_scene *all[] = {a, b, c, d, e};
    for (int i = 0; i < 5; i++)
        lf_scene_unref(all[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_voxels_are_the_blob_carried_as_a_whole),
        cmocka_unit_test(what_is_emitted_and_scattered_flows_along),
        cmocka_unit_test(a_grid_that_stands_askew_flows_as_well),
        cmocka_unit_test(a_turn_is_its_closed_form),
        cmocka_unit_test(every_way_to_say_the_same_velocities),
        cmocka_unit_test(a_name_is_enough),
        cmocka_unit_test(where_there_are_no_velocities_nothing_moves),
        cmocka_unit_test(the_number_of_cpus_changes_nothing),
        cmocka_unit_test(halves_are_rounded),
        cmocka_unit_test(a_blurred_picture_is_the_mean_of_its_steps),
        cmocka_unit_test(weights_are_what_is_expected),
        cmocka_unit_test(the_number_of_threads_changes_nothing),
        cmocka_unit_test(what_is_no_velocity_is_refused_in_one_line),
        cmocka_unit_test(what_is_too_fast_is_gone),
        cmocka_unit_test(a_density_that_is_too_rough_to_flow_is_refused),
        cmocka_unit_test(what_takes_too_much_memory_is_refused_before_it_does),
        cmocka_unit_test(velocities_that_nothing_goes_by_are_told_once),
        cmocka_unit_test(steps_are_shared_and_the_subject_knows_them),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
