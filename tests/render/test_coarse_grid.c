/* The coarse grid of restir (render/papers/coarse_grid.h): rays through its cells against many
 * small steps, and many rays side by side, by every kernel, against one after the other. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/papers/coarse_grid.h"
#include "tests/stat/fixture.h"

/* Of the cells' own extinction, in many steps. */
static double stepped(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double end)
{
    enum { steps = 50000 };
    double sum = 0;
    for (int k = 0; k < steps; k++) {
        const double t = (k + 0.5) / steps * end, x = (double)o.x + t * (double)w.x,
                     y = (double)o.y + t * (double)w.y, z = (double)o.z + t * (double)w.z;
        if (x >= 0 && y >= 0 && z >= 0 && x < grid->n[0] && y < grid->n[1] && z < grid->n[2])
            sum += (double)lf_coarse_grid_sigma(grid, (const int[3]){(int)x, (int)y, (int)z}) *
                   end / steps;
    }
    return sum;
}

/* Room for a grid's cells, some of which are empty. */
static void fill_cells(lf_coarse_grid *grid, lf_tracer *rng)
{
    grid->sigma = lf_calloc(lf_cells_count(grid->n), sizeof *grid->sigma);
    assert_non_null(grid->sigma);
    for (int i = 0; i < grid->n[0] * grid->n[1] * grid->n[2]; i++) {
        const int cell[3] = {i % grid->n[0], i / grid->n[0] % grid->n[1],
                             i / grid->n[0] / grid->n[1]};
        grid->sigma[lf_cells_at(grid->n, cell)] =
            lf_cell_stored(i % 5 == 0 ? 0 : 0.5f + lf_rng(rng));
    }
}

/* From outside and from within, along the axes and any way, also from faces between cells and where
 * they end, which belong to the cells above them; with their ends where they please. */
static void cells_are_walked_from_face_to_face(void **state)
{
    (void)state;
    lf_tracer rng = {.rng = lf_test_seed() + 7};
    lf_coarse_grid grid = {.per_cell = {1, 1, 1}, .n = {3, 2, 6}};
    fill_cells(&grid, &rng);
    for (int i = 0; i < 400; i++) {
        float o[3], w[3] = {0, 0, 0};
        for (int k = 0; k < 3; k++)
            o[k] = (float)grid.n[k] * lf_rng(&rng);
        w[i % 3] = i % 2 ? 1.0f : -1.0f;
        if (i >= 100)
            o[i % 3] = i >= 200 ? floorf(o[i % 3]) : -5.0f * w[i % 3];
        for (int k = 0; i >= 300 && k < 3; k++)
            w[k] = lf_rng(&rng) - 0.5f;
        const lf_vec3 from = {o[0], o[1], o[2]}, along = lf_normalize(lf_v3(w[0], w[1], w[2]));
        const double end = i % 5 ? 12 : 0.3 + 4 * (double)lf_rng(&rng);
        lf_assert_close(lf_coarse_grid_depth(&grid, from, along, end),
                        stepped(&grid, from, along, end), 1e-3, 1e-3);
        o[(i + 1) % 3] = (float)grid.n[(i + 1) % 3];
        if (i < 300)
            assert_true(!(lf_coarse_grid_depth(&grid, lf_v3(o[0], o[1], o[2]), along, end) > 0));
    }
    lf_coarse_grid_finish(&grid);
}

/* There float and double may be in two cells. */
static bool near_a_face(const lf_coarse_grid *grid, const lf_coarse_ray *ray, double t)
{
    const double p[3] = {(double)ray->o.x + t * (double)ray->w.x,
                         (double)ray->o.y + t * (double)ray->w.y,
                         (double)ray->o.z + t * (double)ray->w.z};
    bool near = false;
    for (int i = 0; i < 3; i++) {
        const double place = (p[i] - grid->min[i]) * grid->per_cell[i];
        near = near || fabs(place - round(place)) < 1e-4;
    }
    return isfinite(t) && near;
}

/* Side by side rays come to what they come to alone (the coarse grid's own functions, in double),
 * by every kernel with the same bits: how deep, where a depth is reached and what the cell there
 * has. Some cells are empty, some rays pass by, start within, run along an axis or have an end.
 * Where a depth falls within 1e-4 cells of a face, only depths are compared. */
static void many_rays_are_those_of_one(void **state)
{
    (void)state;
    enum { n_rays = 700 };
    static lf_coarse_ray rays[n_rays];
    static lf_coarse_end seen[n_rays], others[n_rays];
    lf_tracer rng = {.rng = lf_test_seed() + 8};
    lf_coarse_grid grid = {.min = {-3, 1, 2}, .per_cell = {4, 5, 6}, .n = {37, 21, 30}};
    int hits = 0, missed = 0, compared = 0;
    fill_cells(&grid, &rng);
    for (int i = 0; i < n_rays; i++) {
        const lf_vec3 low = {-3, 1, 2}, side = {9.25f, 4.2f, 5};
        lf_vec3 o = lf_add(low, lf_mul(side, lf_v3(lf_rng(&rng), lf_rng(&rng), lf_rng(&rng)))),
                w = lf_v3(lf_rng(&rng) - 0.5f, lf_rng(&rng) - 0.5f, lf_rng(&rng) - 0.5f);
        w = i % 7 == 0 ? lf_v3(0, i % 2 ? 1 : -1, 0) : lf_normalize(w);
        rays[i] = (lf_coarse_ray){i % 3 ? o : lf_madd(o, -20, w), w,
                                  i % 5 ? (double)INFINITY : 20 + 4 * (double)lf_rng(&rng),
                                  i % 2 ? (double)INFINITY : (double)lf_rng_exponential(&rng)};
        if (i % 11 == 0)
            rays[i].o.x += 30;
    }
    for (int k = 0; lf_depth_kernel_at(k); k++) {
        lf_coarse_grid_trace(&grid, lf_depth_kernel_at(k), n_rays, rays, k ? others : seen);
        assert_true(k == 0 || memcmp(seen, others, sizeof seen) == 0);
    }
    for (int i = 0; i < n_rays; i++) {
        const lf_coarse_ray *ray = &rays[i];
        lf_coarse_point at = {.sigma = 0};
        double left = 0, whole = lf_coarse_grid_depth(&grid, ray->o, ray->w, ray->end);
        const bool stops =
            lf_coarse_grid_at_depth(&grid, ray->o, ray->w, fmin(ray->goal, 1e9), &at, &left) &&
            at.t < ray->end;
        hits += stops;
        missed += !(whole > 0);
        lf_assert_close(seen[i].depth, stops ? ray->goal : whole, 2e-5, 2e-5);
        if (near_a_face(&grid, ray, stops ? at.t : ray->end) || fabs(ray->goal - whole) < 1e-4)
            continue;
        compared++;
        lf_assert_close((double)seen[i].point.sigma, stops ? (double)at.sigma : 0, 1e-7, 0);
        if (stops)
            lf_assert_close(seen[i].point.t, at.t, 1e-5, 2e-5);
    }
    assert_true(hits > 100 && missed > 30 && compared > n_rays / 2);
    lf_coarse_grid_finish(&grid);
}

/* Depths at many distances of a ray are those at each; ends are equal, before the eye, behind the
 * grid and none at all. */
static void depths_on_the_way_are_those_of_each(void **state)
{
    (void)state;
    enum { most = 16 };
    lf_tracer rng = {.rng = lf_test_seed() + 9};
    lf_coarse_grid grid = {.min = {-1, -1, -1}, .per_cell = {5, 5, 5}, .n = {10, 9, 11}};
    fill_cells(&grid, &rng);
    for (int i = 0; i < 200; i++) {
        const lf_vec3 o = {lf_rng(&rng) - 2.5f * (float)(i % 2), lf_rng(&rng) - 0.5f, 0.1f},
                      w = lf_normalize(lf_v3(lf_rng(&rng), lf_rng(&rng) - 0.5f, lf_rng(&rng)));
        const int n = i % (most + 1);
        double ends[most], depths[most];
        for (int k = 0; k < n; k++)
            ends[k] = (k > 0 ? ends[k - 1] : -1) + (k % 3 ? 0.8 * (double)lf_rng(&rng) : 0);
        lf_coarse_grid_depths(&grid, o, w, n, ends, depths);
        for (int k = 0; k < n; k++)
            lf_assert_close(depths[k], ends[k] > 0 ? lf_coarse_grid_depth(&grid, o, w, ends[k]) : 0,
                            1e-12, 1e-12);
    }
    lf_coarse_grid_finish(&grid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_are_walked_from_face_to_face),
        cmocka_unit_test(many_rays_are_those_of_one),
        cmocka_unit_test(depths_on_the_way_are_those_of_each),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
