/* Voxels with edges are cut exactly: depths, collisions, weights, and the picture of a box. */
#include "tests/testing.h"

#include "render/plane/voxels.h"
#include "render/transport/sampler.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"
#include "tests/stat/uniform.h"

enum { NX = 21, NY = 13, NZ = 17, SIDE = 12 };

/* Empty bricks, and rough voxels in the others. */
static float patchy(int x, int y, int z)
{
    return x >= 7 && x < 15 ? 0.0f : lf_test_rough(x, y, z);
}

/* A plane through a grid, turned anyhow, and one ray in it, which now and then runs along an axis
 * or starts inside. */
static void draw_ray(lf_voxels *voxels, float *x0, float *slope, uint64_t *seed)
{
    const float size[3] = {NX, NY, NZ};
    float away = lf_test_uniform(seed) < 0.25f ? 0.0f : 40.0f;
    int along = (int)(8.0f * lf_test_uniform(seed)); /* this axis, if there is one */
    *x0 = 20.0f * lf_test_uniform(seed) - 10.0f;
    *slope = 2.0f * lf_test_uniform(seed) - 1.0f;
    for (int i = 0; i < 3; i++) {
        bool level = along < 3 && i != along;
        float point = (1.4f * lf_test_uniform(seed) - 0.2f) * size[i] - 0.5f,
              d = level ? 0.0f : 2.0f * lf_test_uniform(seed) - 1.0f;
        voxels->across[i] = level ? 0.0f : 2.0f * lf_test_uniform(seed) - 1.0f;
        voxels->depth[i] = d - *slope * voxels->across[i];
        voxels->origin[i] = point - away * d - *x0 * voxels->across[i];
    }
}

static int compare(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* The optical depth by definition, in double: all faces in order, and the voxel in the middle
 * between two. */
static double brute_depth(const lf_voxels *v, float x0, float slope, double z_end)
{
    static const int size[3] = {NX, NY, NZ};
    double o[3], d[3], z[NX + NY + NZ + 5], sum = 0.0;
    int n = 0;
    z[n++] = 0.0;
    for (int i = 0; i < 3; i++) {
        o[i] = (double)v->origin[i] + (double)x0 * (double)v->across[i];
        d[i] = (double)v->depth[i] + (double)slope * (double)v->across[i];
        for (int face = 0; face <= size[i]; face++) {
            double at = (face - 0.5 - o[i]) / d[i];
            if (d[i] != 0.0 && at > 0.0 && at < z_end)
                z[n++] = at;
        }
    }
    if (isfinite(z_end))
        z[n++] = z_end;
    qsort(z, (size_t)n, sizeof z[0], compare);
    for (int i = 0; i + 1 < n; i++) {
        int at[3];
        bool inside = true;
        for (int a = 0; a < 3; a++) {
            at[a] = (int)floor(o[a] + 0.5 * (z[i] + z[i + 1]) * d[a] + 0.5);
            inside = inside && at[a] >= 0 && at[a] < size[a];
        }
        if (inside)
            sum += (z[i + 1] - z[i]) * (double)patchy(at[0], at[1], at[2]);
    }
    return (double)v->sigma_scale * sum;
}

static void depths_and_collisions_are_those_of_a_walk_from_face_to_face(void **state)
{
    (void)state;
    enum { RAYS = 20000 };
    lf_grid *grid = lf_test_grid(patchy, NX, NY, NZ);
    lf_voxels voxels = {.grid = grid, .sigma_scale = 3.0f};
    uint64_t seed = 5;
    int met = 0, collided = 0, there = 0;
    for (int n = 0; n < RAYS; n++) {
        float x0, slope, z, end = n % 3 == 0 ? INFINITY : 60.0f * lf_test_uniform(&seed),
                            lanes[4][LF_LANES] = {{0}};
        draw_ray(&voxels, &x0, &slope, &seed);
        double truth = brute_depth(&voxels, x0, slope, (double)end), close = 2e-4 * (1.0 + truth);
        float depth = lf_voxels_march(&voxels, x0, slope, end, INFINITY, &z);
        met += truth > 0.1;
        lf_assert_close((double)depth, truth, 0.0, close);
        assert_true(z == end);
        float stop = 1.3f * lf_test_uniform(&seed) * depth,
              reached = lf_voxels_march(&voxels, x0, slope, end, stop, &z);
        assert_true(reached <= stop);
        if (reached == stop && z < end) {
            lf_assert_close(brute_depth(&voxels, x0, slope, (double)z), (double)stop, 0.0, close);
            collided++;
            there += lf_voxels_density(&voxels, x0 + slope * z, z) > 0.0f;
        } else {
            assert_true((double)stop > truth - close);
        }
        for (int k = 0; k < LF_LANES; k++) {
            lanes[0][k] = k < 5 ? x0 + 0.1f * (float)(5 - k) : x0;
            lanes[1][k] = slope;
            lanes[2][k] = end;
        }
        lf_voxels_depths(&voxels, LF_LANES, lanes[0], lanes[1], lanes[2], lanes[3]);
        for (int k = 5; k < LF_LANES; k++)
            assert_true(lanes[3][k] == depth);
    }
    assert_true(met > RAYS / 4 && collided > RAYS / 4);
    assert_true(there > collided - collided / 200); /* rounding may put a point beside its voxel */
    lf_grid_unref(grid);
}

static void a_ray_along_faces_is_in_a_voxel_beside_them(void **state)
{
    (void)state;
    lf_grid *grid = lf_test_grid(lf_test_full, NX, NY, NZ);
    lf_voxels voxels = {.grid = grid,
                        .sigma_scale = 1.0f,
                        .depth = {0.0f, 0.0f, 1.0f},
                        .across = {1.0f, 0.0f, 0.0f}};
    for (int x = 0; x <= NX; x++) {
        for (int y = 0; y <= NY; y++) {
            float z;
            voxels.origin[1] = (float)y - 0.5f;
            voxels.origin[2] = -10.5f;
            float depth = lf_voxels_march(&voxels, (float)x - 0.5f, 0.0f, INFINITY, INFINITY, &z);
            assert_true(x == NX || y == NY ? depth == 0.0f || depth == (float)NZ
                                           : depth == (float)NZ);
        }
    }
    lf_grid_unref(grid);
}

/* Voxels of one value, turned, or the box of their extent. */
static lf_scene *constant_scene(bool box, float albedo, const char *lights)
{
    const double voxel = 0.02, tilt = 0.5;
    char text[1024], shape[256];
    snprintf(shape, sizeof shape,
             "'volumes': { 'v': { 'shape': 'box', 'density': 6, 'albedo': %.9f, "
             "'transform': { 'rotate': [0, %.9f, 0], 'scale': [%.9f, %.9f, %.9f] } } }",
             (double)albedo, tilt * 180.0 / M_PI, NX * voxel / 2.0, NY * voxel / 2.0,
             NZ * voxel / 2.0);
    snprintf(text, sizeof text,
             "{ 'camera': { 'position': [0.3, 0.5, 5], 'fov_y': 5, 'aspect': 1, 'cone': 30, "
             "'views': 5 }, 'lights': { %s }, %s }",
             lights, box ? shape : LF_TEST_VOLUMES(""));
    if (box)
        return lf_test_scene(text);
    lf_scene *scene =
        lf_test_grid_scene(text, lf_test_grid(lf_test_full, NX, NY, NZ), voxel, tilt, 6.0f, true);
    scene->volumes[0].albedo = lf_v3(albedo, albedo, albedo);
    return scene;
}

/* What comes through, by the same seed: rays are the same. */
static void constant_voxels_are_as_deep_as_a_box(void **state)
{
    (void)state;
    double *picture[2], largest = 0.0;
    for (int i = 0; i < 2; i++) {
        lf_scene *scene =
            constant_scene(i == 1, 0.0f, "'sky': { 'type': 'environment', 'radiance': 1 }");
        lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
        lf_test_cycles(r, 4);
        picture[i] = lf_test_picture(r, LF_ESTIMATOR_MIS);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    for (int i = 0; i < SIDE * 5 * SIDE; i++) {
        lf_assert_close(picture[0][i], picture[1][i], 0.0, 2e-5);
        largest = fmax(largest, 1.0 - picture[1][i]);
    }
    assert_true(largest > 0.5);
    for (int i = 0; i < 2; i++)
        free(picture[i]);
}

/* ----------------------------------------------------------------------------------- weights -- */

enum { REPLICATES = 24, BLOCK = 4, BLOCKS = 5 * 9 + 1 };
#define LEVEL lf_sidak(LF_FALSE_ALARM, 9 * BLOCKS)

/* Rough voxels in a thin fog with a lens before them; or the cameras inside. */
static lf_scene *rough_scene(bool inside)
{
    const char *text = lf_test_scene_patched(
        "rough-voxels", "%s",
        inside ? "{'camera': {'position': [0, 0, 0.1], 'fov_y': 60, 'lens_radius': null, "
                 "'focus_distance': null}}"
               : "{}");
    lf_scene *scene =
        lf_test_grid_scene(text, lf_test_grid(lf_test_rough, 14, 14, 14), 0.02, 0.5, 100.0f, true);
    scene->volumes[0].albedo = lf_v3(0.9f, 0.8f, 0.5f);
    return scene;
}

static void whole_cycles(lf_renderer *r)
{
    lf_test_cycles(r, 6);
}

static void live(lf_renderer *r)
{
    for (int i = 0; i < 8; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 1 + i % 2, NULL, NULL, NULL), LF_OK);
}

/* The points that are drawn about it know the density of their voxel. */
static void a_lamp_in_constant_voxels_shines_as_in_a_box(void **state)
{
    (void)state;
    lf_blocks blocks[3];
    for (int i = 0; i < 3; i++) {
        lf_scene *scene = constant_scene(
            i == 0, 0.8f,
            "'lamp': { 'type': 'point', 'position': [0.03, 0.05, 0.02], 'intensity': 1 }");
        lf_renderer *r = lf_test_renderer(scene, i == 2 ? "vpt" : "mvpt", SIDE, SIDE, NULL);
        assert_int_equal(scene->equiangular.n, 1);
        lf_test_pictures(r, whole_cycles, LF_ESTIMATOR_MIS, REPLICATES, (uint64_t)i, BLOCK,
                         &blocks[i]);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    for (int i = 1; i < 3; i++) {
        double p = lf_blocks_welch(&blocks[0], &blocks[i], NULL),
               injected = lf_blocks_welch_injected(&blocks[0], &blocks[i], blocks[0].n - 1, 1.2);
        print_message("p %.2g; a factor of 1.2: %.2g\n", p, injected);
        assert_true(p > LEVEL && injected < LEVEL);
    }
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
}

static double weights_p(bool inside, lf_test_schedule schedule, unsigned faults)
{
    lf_blocks blocks[3];
    lf_scene *scene = rough_scene(inside);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    r->faults = faults;
    lf_test_weight_blocks(r, schedule, REPLICATES, BLOCK, blocks);
    double p = fmin(lf_blocks_p_zero(&blocks[0], NULL), lf_blocks_p_zero(&blocks[1], NULL));
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return p;
}

static void invariant_2_weights_are_n_q_among_voxels(void **state)
{
    (void)state;
    double cycles = weights_p(false, whole_cycles, 0), forced = weights_p(false, live, 0),
           within = weights_p(true, whole_cycles, 0);
    double wrong = weights_p(false, whole_cycles, LF_FAULT_SWAPPED_VIEWS);
    print_message("p %.2g, forced %.2g, inside %.2g; wrong %.2g\n", cycles, forced, within, wrong);
    assert_true(cycles > LEVEL && forced > LEVEL && within > LEVEL);
    assert_true(wrong < LEVEL);
}

static void both_integrators_find_the_same_light_among_voxels(void **state)
{
    (void)state;
    lf_blocks blocks[2];
    lf_scene *scene = rough_scene(false);
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, i ? "vpt" : "mvpt", SIDE, SIDE, NULL);
        lf_test_pictures(r, whole_cycles, LF_ESTIMATOR_MIS, REPLICATES, (uint64_t)i, BLOCK,
                         &blocks[i]);
        lf_renderer_destroy(r);
    }
    double p = lf_blocks_welch(&blocks[0], &blocks[1], NULL);
    print_message("p %.2g; a factor of 1.03: %.2g\n", p,
                  lf_blocks_welch_injected(&blocks[0], &blocks[1], blocks[0].n - 1, 1.03));
    assert_true(p > LEVEL);
    assert_true(lf_blocks_welch_injected(&blocks[0], &blocks[1], blocks[0].n - 1, 1.03) < LEVEL);
    for (int i = 0; i < 2; i++)
        lf_blocks_finish(&blocks[i]);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(depths_and_collisions_are_those_of_a_walk_from_face_to_face),
        cmocka_unit_test(a_ray_along_faces_is_in_a_voxel_beside_them),
        cmocka_unit_test(constant_voxels_are_as_deep_as_a_box),
        cmocka_unit_test(a_lamp_in_constant_voxels_shines_as_in_a_box),
        cmocka_unit_test(invariant_2_weights_are_n_q_among_voxels),
        cmocka_unit_test(both_integrators_find_the_same_light_among_voxels),
    };
    return cmocka_run_group_tests_name("voxels", tests, NULL, lf_test_finish);
}
