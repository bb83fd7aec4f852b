/* Optical depths of many rays at once (render/transport/lanes/depth.h): closed forms of boxes of
 * ones, the oracle of one ray (also where rays graze faces and edges, begin inside, end nowhere),
 * the same bits by every instruction set and whatever rays go together. Negative controls: rays
 * that are moved by a hundredth of a voxel are told from those that are not. */
#include "tests/testing.h"

#include "render/transport/lanes/depth.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { n_rays = 600 };

/* ------------------------------------------------------------------------------------- grids -- */

/* Lumps with nothing between, some bricks far apart. */
static float lumps(int x, int y, int z)
{
    const int sum = x / 11 + y / 9 + z / 13;
    return sum % 3 == 0 ? 0.2f + lf_test_rough(x, y, z) : 0.0f;
}

/* Only what is there is stored. */
static lf_grid *sparse(int nx, int ny, int nz)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {nx, ny, nz};
    lf_grid *grid = NULL;
    lf_assert_ok(lf_grid_create(size, identity, &grid, NULL), NULL);
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < nx * ny * nz; i++) {
            const int at[3] = {i % nx, i / nx % ny, i / nx / ny};
            const float value = lumps(at[0], at[1], at[2]);
            if (value > 0.0f && round == 0)
                lf_grid_mark(grid, at, at);
            else if (value > 0.0f)
                lf_grid_fill(grid, at, at, value);
        }
        if (round == 0)
            lf_assert_ok(lf_grid_allocate(grid, NULL), NULL);
    }
    lf_grid_finish(grid);
    return grid;
}

static lf_scene *grid_scene(lf_grid *grid, double voxel, bool nearest)
{
    return lf_test_grid_scene("{ " LF_TEST_VOLUMES("") " }", grid, voxel, 0.4, 2.0f, nearest);
}

/* Leans every axis of the volume's space on the others. */
static void shear(lf_scene *scene)
{
    lf_volume *v = &scene->volumes[0];
    for (int j = 0; j < 3; j++) {
        v->to_volume[0][j] += 0.4f * v->to_volume[1][j];
        v->to_volume[2][j] -= 0.7f * v->to_volume[0][j];
        v->to_volume[1][j] *= 1.3f;
    }
}

/* -------------------------------------------------------------------------------------- rays -- */

/* The point of the scene at a point of the volume, by Cramer's rule. */
static lf_vec3 at_voxel(const lf_volume *v, const double p[3])
{
    lf_affine to = lf_affine_identity(), back;
    double out[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            to.m[i][j] = (double)v->to_volume[i][j];
    assert_true(lf_affine_invert(&to, &back));
    lf_affine_point(&back, p, out);
    return lf_v3((float)out[0], (float)out[1], (float)out[2]);
}

static double random_unit(lf_tracer *t)
{
    return (double)lf_rng(t);
}

/* From anywhere about the grid and inside of it to points of it, ending there, before, behind and
 * nowhere. */
static void draw_rays(const lf_scene *scene, lf_depth_ray rays[n_rays])
{
    const lf_volume *v = &scene->volumes[0];
    lf_tracer t = {.rng = 77};
    for (int k = 0; k < n_rays; k++) {
        double from[3], to[3];
        for (int i = 0; i < 3; i++) {
            const double size = (double)v->grid->size[i];
            to[i] = (size + 1.0) * random_unit(&t) - 1.0;
            from[i] = k % 4 ? to[i] + 5.0 * size * (random_unit(&t) - 0.5)
                            : (size + 1.0) * random_unit(&t) - 1.0;
        }
        const lf_vec3 a = at_voxel(v, from), b = at_voxel(v, to);
        const float far = lf_length(lf_sub(b, a));
        const double ends[] = {(double)far, (double)INFINITY, 0.4 * (double)far, 3.0 * (double)far};
        rays[k] = (lf_depth_ray){a, lf_normalize(lf_sub(b, a)), ends[k / 4 % 4]};
    }
}

/* Along axes, diagonals of faces and of cells, from voxel centres, and from `off` beside them. */
static int straight_rays(const lf_scene *scene, double off, lf_depth_ray rays[n_rays])
{
    const lf_volume *v = &scene->volumes[0];
    int n = 0;
    for (int way = 0; way < 27; way++) {
        const int d[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
        for (int k = 0; k < 20 && way != 13; k++) {
            double from[3], to[3];
            for (int i = 0; i < 3; i++) {
                const int size = v->grid->size[i];
                const double middle = k % 4 == 0 ? 8 * (k / 4) - 1 : (k * (3 + 2 * i)) % size;
                from[i] = middle + off - 40.0 * d[i] * (k % 3);
                to[i] = from[i] + d[i];
            }
            const lf_vec3 a = at_voxel(v, from), b = at_voxel(v, to);
            rays[n++] = (lf_depth_ray){a, lf_normalize(lf_sub(b, a)),
                                       k % 2 ? (double)INFINITY : 50.0 * (double)v->voxel};
        }
    }
    return n;
}

/* ------------------------------------------------------------------------------ closed forms -- */

/* How much of a ray lies in the box lo .. hi of the volume's space. */
static double length_inside(const lf_volume *v, const lf_depth_ray *ray, double lo,
                            const double hi[3])
{
    const double w[3] = {(double)ray->w.x, (double)ray->w.y, (double)ray->w.z},
                 o[3] = {(double)ray->o.x, (double)ray->o.y, (double)ray->o.z};
    double from = 0.0, to = ray->end;
    for (int i = 0; i < 3; i++) {
        double d = 0.0, p = (double)v->to_volume[i][3];
        for (int j = 0; j < 3; j++) {
            d += (double)v->to_volume[i][j] * w[j];
            p += (double)v->to_volume[i][j] * o[j];
        }
        from = fmax(from, fmin((lo - p) / d, (hi[i] - p) / d));
        to = fmin(to, fmax((lo - p) / d, (hi[i] - p) / d));
    }
    return fmax(to - from, 0.0);
}

/* With edges a box of ones is homogeneous. */
static void ones_with_edges_are_lengths(void **state)
{
    (void)state;
    static lf_depth_ray rays[n_rays];
    double seen[n_rays], most = 0.0;
    lf_scene *scene = grid_scene(lf_test_grid(lf_test_full, 37, 14, 21), 0.1, true);
    const lf_volume *v = &scene->volumes[0];
    const double hi[3] = {36.5, 13.5, 20.5};
    lf_tracer tracer = {.scene = scene};
    shear(scene);
    draw_rays(scene, rays);
    lf_depths_along(&tracer, n_rays, rays, seen);
    for (int k = 0; k < n_rays; k++) {
        lf_assert_close(seen[k], 2.0 * length_inside(v, &rays[k], -0.5, hi), 1e-5, 1e-5);
        most = fmax(most, seen[k]);
    }
    assert_true(most > 2.0);
    lf_scene_unref(scene);
}

/* Interpolated, a row of n ones falls to 0 within a voxel at both ends: n in all. Beside the row,
 * in proportion. */
static void rows_of_ones_are_as_many(void **state)
{
    (void)state;
    enum { n = 37 };
    double seen[11];
    lf_depth_ray rays[11];
    lf_scene *scene = grid_scene(lf_test_grid(lf_test_full, n, 1, 1), 0.25, false);
    lf_tracer tracer = {.scene = scene};
    for (int k = 0; k < 11; k++) {
        const double off = 0.1 * k - 0.1;
        const lf_vec3 a = at_voxel(&scene->volumes[0], (double[3]){k % 2 ? -9 : 60, off, 0}),
                      b = at_voxel(&scene->volumes[0], (double[3]){k % 2 ? 60 : -9, off, 0});
        rays[k] = (lf_depth_ray){a, lf_normalize(lf_sub(b, a)), (double)INFINITY};
    }
    lf_depths_along(&tracer, 11, rays, seen);
    for (int k = 0; k < 11; k++)
        lf_assert_close(seen[k], 2.0 * 0.25 * n * (1.0 - fabs(0.1 * k - 0.1)), 0, 2e-5);
    lf_scene_unref(scene);
}

/* -------------------------------------------------------------------------------- the oracle -- */

/* The oracle's depth of a ray that is moved across, by so many voxels and one of many ways. */
static double moved(lf_tracer *one, const lf_depth_ray *r, double voxels, int way)
{
    const lf_vec3 up = lf_v3(0.3f, 1.0f, -0.2f), across = lf_normalize(lf_cross(r->w, up)),
                  aside = lf_madd(lf_scale(across, cosf(2.4f * (float)way)),
                                  sinf(2.4f * (float)way), lf_cross(r->w, across));
    const float by = (float)voxels * one->scene->volumes[0].voxel;
    return lf_depth_along(one, lf_madd(r->o, by, aside), r->w, r->end);
}

/* What rounding may make of a depth: 5e-6, and what rays have that run beside it, by 1e-5 voxels or
 * by what directions are rounded by. */
static double allowed_of(lf_tracer *one, const lf_depth_ray *r, double truth)
{
    const int *size = one->scene->volumes[0].grid->size;
    const double aside = fmax(1e-5, 1e-7 * fmax(size[0], fmax(size[1], size[2])));
    double apart = 0.0;
    for (int i = 1; i <= 8; i++)
        apart = fmax(apart, fabs(moved(one, r, 0.125 * i * aside, i) - truth));
    return 5e-6 * fmax(1.0, truth) + apart;
}

/* The largest error over what is allowed, and how many rays would be off if they were moved by a
 * hundredth of a voxel. */
static double worst_against_the_oracle(lf_scene *scene, int n, lf_depth_ray *rays, int *out_off)
{
    static double seen[n_rays];
    lf_tracer tracer = {.scene = scene}, one = {.scene = scene}, beside = one;
    double worst = 0.0, most = 0.0;
    *out_off = 0;
    lf_depths_along(&tracer, n, rays, seen);
    for (int k = 0; k < n; k++) {
        const lf_depth_ray *r = &rays[k];
        const double truth = lf_depth_along(&one, r->o, r->w, r->end),
                     allowed = allowed_of(&beside, r, truth);
        worst = fmax(worst, fabs(seen[k] - truth) / allowed);
        *out_off += fabs(seen[k] - moved(&beside, r, 0.01, k)) > allowed;
        most = fmax(most, truth);
    }
    assert_true(most > 0.5);
    assert_true(tracer.lookups > 0 && tracer.lookups <= one.lookups);
    return worst;
}

/* Kinds of grids: dense, with empty bricks, of one brick and of one voxel, long ones; in 32 bits
 * and in 16. */
static lf_grid *grid_of_kind(int kind)
{
    static const int sizes[][3] = {{23, 18, 11}, {70, 33, 50}, {7, 7, 7}, {1, 1, 1}, {1500, 9, 8}};
    const int *s = sizes[kind % 5];
    lf_grid *grid = kind % 5 == 1   ? sparse(s[0], s[1], s[2])
                    : kind % 5 == 3 ? lf_test_grid(lf_test_full, 1, 1, 1)
                                    : lf_test_grid(lf_test_rough, s[0], s[1], s[2]);
    if (kind >= 5) {
        lf_grid_shorten(grid, true);
        assert_true(grid->shorts && !grid->values);
    }
    return grid;
}

static void depths_are_those_of_the_oracle(void **state)
{
    (void)state;
    static lf_depth_ray rays[n_rays];
    for (int kind = 0; kind < 20; kind++) {
        lf_scene *scene =
            grid_scene(grid_of_kind(kind / 2), kind / 2 % 5 == 3 ? 1.0 : 0.1, kind % 2);
        int off = 0;
        shear(scene);
        draw_rays(scene, rays);
        const double worst = worst_against_the_oracle(scene, n_rays, rays, &off);
        print_message("grid %d, %s: within %.2f of what is allowed; moved by a hundredth of a "
                      "voxel, %d of %d are off\n",
                      kind / 2, kind % 2 ? "edges" : "interpolated", worst, off, n_rays);
        assert_true(worst < 1.0);
        assert_true(off > n_rays / 4);
        lf_scene_unref(scene);
    }
}

static void rays_may_graze_faces_and_edges(void **state)
{
    (void)state;
    static lf_depth_ray rays[n_rays];
    for (int kind = 0; kind < 12; kind++) {
        /* edges lie in the middle between voxels, where a ray is in either */
        const double off = kind / 2 % 3 == 0 ? 0.0 : kind / 2 % 3 == 1 ? 0.5 : 1e-6;
        lf_scene *scene = grid_scene(grid_of_kind(kind / 6), 0.125, kind % 2);
        int off_way = 0;
        const int n = straight_rays(scene, off, rays);
        if (kind % 2 && off == 0.5) {
            lf_scene_unref(scene);
            continue;
        }
        assert_true(worst_against_the_oracle(scene, n, rays, &off_way) < 1.0);
        assert_true(off_way > n / 8);
        lf_scene_unref(scene);
    }
}

/* Between voxels with edges a ray has what one just beside it has, on one side or another. */
static void rays_along_edges_are_in_a_voxel_beside(void **state)
{
    (void)state;
    lf_scene *scene = grid_scene(grid_of_kind(1), 0.125, true);
    lf_volume *v = &scene->volumes[0];
    lf_tracer tracer = {.scene = scene};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) { /* so that faces are numbers of the scene */
            v->to_volume[i][j] = i == j ? 8.0f : 0.0f;
            v->to_volume[i][3] = 0.0f;
        }
    for (int k = 0; k < 60; k++) {
        const float y = ((float)(k % 33) + 0.5f) / 8.0f, z = ((float)(k * 7 % 50) + 0.25f) / 8.0f,
                    x = k % 2 ? -1.0f : 20.0f;
        const lf_vec3 w = lf_v3(k % 2 ? 1.0f : -1.0f, 0.0f, 0.0f);
        const lf_depth_ray ray = {lf_v3(x, y, z), w, (double)INFINITY};
        double seen;
        lf_depths_along(&tracer, 1, &ray, &seen);
        const double above = lf_depth_along(&tracer, lf_v3(x, y + 0.01f, z), w, (double)INFINITY),
                     below = lf_depth_along(&tracer, lf_v3(x, y - 0.01f, z), w, (double)INFINITY);
        assert_true(lf_close(seen, above, 1e-5, 1e-5) || lf_close(seen, below, 1e-5, 1e-5));
    }
    lf_scene_unref(scene);
}

/* Beside shapes and other volumes. */
static void media_are_added_up(void **state)
{
    (void)state;
    static lf_depth_ray rays[n_rays];
    int off = 0;
    lf_scene *scene = lf_test_grid_scene(lf_test_scene_text("added-media"), grid_of_kind(0), 0.1,
                                         0.4, 3.0f, false);
    draw_rays(scene, rays);
    assert_true(worst_against_the_oracle(scene, n_rays, rays, &off) < 1.0);
    assert_true(off > n_rays / 2);
    lf_scene_unref(scene);
}

/* What is so thick that nothing is left may end early, above what is enough. */
static void nothing_is_left_behind_what_is_thick(void **state)
{
    (void)state;
    static lf_depth_ray rays[n_rays];
    double seen[n_rays];
    int thick = 0;
    lf_scene *scene = grid_scene(grid_of_kind(1), 0.1, false);
    lf_tracer tracer = {.scene = scene}, one = {.scene = scene};
    scene->volumes[0].sigma_scale = 400.0f;
    draw_rays(scene, rays);
    lf_depths_along(&tracer, n_rays, rays, seen);
    for (int k = 0; k < n_rays; k++) {
        const double truth = lf_depth_along(&one, rays[k].o, rays[k].w, rays[k].end);
        const bool ends = truth > LF_DEPTH_ENOUGH;
        if (ends)
            assert_true(seen[k] > LF_DEPTH_ENOUGH * 0.9999 && seen[k] < truth * 1.0001);
        else
            lf_assert_close(seen[k], truth, 1e-5, 1e-3);
        thick += ends;
    }
    assert_true(thick > n_rays / 4 && thick < n_rays);
    /* two a cell there */
    assert_true(2.5 * (double)tracer.lookups < (double)one.lookups);
    lf_scene_unref(scene);
}

/* -------------------------------------------------------------------------------------- bits -- */

static void bits_are_the_same_for_every_instruction_set_and_company(void **state)
{
    (void)state;
    static lf_depth_ray rays[n_rays];
    static double plain[n_rays], other[n_rays], alone[n_rays];
    assert_ptr_equal(lf_depth_kernel_at(0), &lf_depth_kernel_c);
    for (int kind = 0; kind < 20; kind++) {
        lf_scene *scene = grid_scene(grid_of_kind(kind / 2), 0.1, kind % 2);
        lf_tracer first = {.scene = scene};
        shear(scene);
        draw_rays(scene, rays);
        lf_depths_by(lf_depth_kernel_at(0), &first, n_rays, rays, plain);
        for (int i = 0; lf_depth_kernel_at(i); i++) {
            lf_tracer all_of = {.scene = scene}, some = {.scene = scene};
            lf_depths_by(lf_depth_kernel_at(i), &all_of, n_rays, rays, other);
            for (int k = 0, n = 1; k < n_rays; k += n, n = n % 19 + 1) {
                n = k + n < n_rays ? n : n_rays - k;
                lf_depths_by(lf_depth_kernel_at(i), &some, n, rays + k, alone + k);
            }
            assert_memory_equal(plain, other, sizeof plain);
            assert_memory_equal(plain, alone, sizeof plain);
            assert_int_equal(first.lookups, all_of.lookups);
            assert_int_equal(first.lookups, some.lookups);
        }
        lf_scene_unref(scene);
    }
}

/* What no camera sends ends, too. */
static void rays_that_are_none_end(void **state)
{
    (void)state;
    lf_scene *scene = grid_scene(grid_of_kind(1), 0.1, false);
    lf_tracer tracer = {.scene = scene};
    const lf_vec3 nowhere = lf_v3(NAN, 0.0f, 1.0f), here = lf_v3(0.1f, 0.0f, 0.1f),
                  still = lf_v3(0.0f, 0.0f, 0.0f), far = lf_v3(INFINITY, 0.0f, 0.0f);
    const lf_depth_ray rays[] = {{here, nowhere, 1.0},
                                 {nowhere, here, (double)INFINITY},
                                 {here, still, (double)INFINITY},
                                 {far, here, 4.0},
                                 {here, far, 2.0},
                                 {here, here, (double)NAN},
                                 {here, lf_v3(0, 1, 0), -1.0},
                                 {here, lf_v3(0, 1, 0), 0.0}};
    double seen[8];
    lf_depths_along(&tracer, 8, rays, seen);
    assert_true(seen[6] == 0.0 && seen[7] == 0.0);
    lf_depths_along(&tracer, 0, rays, seen);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ones_with_edges_are_lengths),
        cmocka_unit_test(rows_of_ones_are_as_many),
        cmocka_unit_test(depths_are_those_of_the_oracle),
        cmocka_unit_test(rays_may_graze_faces_and_edges),
        cmocka_unit_test(rays_along_edges_are_in_a_voxel_beside),
        cmocka_unit_test(media_are_added_up),
        cmocka_unit_test(nothing_is_left_behind_what_is_thick),
        cmocka_unit_test(bits_are_the_same_for_every_instruction_set_and_company),
        cmocka_unit_test(rays_that_are_none_end),
    };
    return cmocka_run_group_tests_name("depths", tests, NULL, lf_test_finish);
}
