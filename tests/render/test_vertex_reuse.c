/* Paths of a block of pixels (render/papers/vertex_reuse.h): where a path of one pixel goes in
 * another, with which Jacobian and for how much of the whole; and a furnace, whose pictures are
 * known, by blocks of columns and of views. */
#include "tests/testing.h"

#include "render/papers/papers.h"
#include "render/papers/vertex_reuse.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

/* Two pixels and a path of the first. */
typedef struct pair {
    lf_path_space space;
    lf_coarse_grid coarse;
    lf_camera_ray rays[2];
    lf_path_sample samples[2], out[2];
} pair;

/* Rough voxels in a fog that scatters forwards, lit by a sky, a sun, and a lamp within. */
static lf_scene *make_scene(void)
{
    return lf_test_grid_scene(
        lf_test_scene_patched("grid-in-fog",
                              "{'camera': {'views': 2, 'lens_radius': null, "
                              "'focus_distance': null}, 'lights': {'sun': {'irradiance': [3, 2.7, "
                              "2.2]}, 'lamp': {'type': 'point', 'position': [0.3, 0.9, 0.2], "
                              "'intensity': [2, 3, 4]}}}"),
        lf_test_grid(lf_test_rough, 9, 8, 7), 0.25, 0.4, 2.0f, false);
}

static void begin(pair *p, const lf_scene *scene, lf_pool *pool)
{
    lf_assert_ok(lf_coarse_grid_init(&p->coarse, scene, pool), NULL);
    p->space = (lf_path_space){scene, &p->coarse, 5};
}

/* Neighbours' rays, through a place near the middle, and a path that the first has kept; false: no
 * walk of it found one. */
static bool draw(pair *p, lf_tracer *rng)
{
    static lf_light_walk walk;
    lf_tracer tracer = {.scene = p->space.scene, .rng = lf_hash64(rng->rng, 1)};
    const lf_vec3 eye = {0, 0.6f, 5},
                  at = {1.4f * lf_rng(rng) - 0.7f, lf_rng(rng) - 0.5f, 0.4f * lf_rng(rng)};
    for (int i = 0; i < 2; i++) {
        const lf_vec3 beside = {0.1f * (float)i * lf_rng(rng), 0.03f * (float)i * lf_rng(rng), 0};
        p->rays[i] = (lf_camera_ray){.o = lf_madd(eye, 0.1f, beside),
                                     .w = lf_normalize(lf_sub(lf_add(at, beside), eye)),
                                     .from = i ? 0.02f : 0.0f};
        p->rays[i].depth =
            lf_coarse_grid_depth(&p->coarse, p->rays[i].o, p->rays[i].w, (double)INFINITY);
        p->samples[i] = (lf_path_sample){.m = i ? 5 : 2};
    }
    if (!(p->rays[0].depth > 0))
        return false;
    walk = (lf_light_walk){.ray = &p->rays[0], .u = (double)lf_rng_fine(rng), .random = rng->rng};
    lf_light_path_walk(&p->space, 1, &walk, &tracer);
    lf_path_sample_draw(2, &walk, 1, &tracer, &p->samples[0]);
    return p->samples[0].kept;
}

static void combine(pair *p)
{
    lf_tracer tracer = {.scene = p->space.scene, .rng = 1};
    const lf_block_pixel pixels[2] = {{&p->rays[0], &p->samples[0], &p->out[0]},
                                      {&p->rays[1], &p->samples[1], &p->out[1]}};
    lf_path_block_combine(&p->space, 2, pixels, &tracer);
}

typedef struct vec {
    double v[3];
} vec;

static vec wide(lf_vec3 a)
{
    return (vec){{(double)a.x, (double)a.y, (double)a.z}};
}

static vec along(vec o, double t, vec w)
{
    for (int i = 0; i < 3; i++)
        o.v[i] += t * w.v[i];
    return o;
}

static double dot(vec a, vec b)
{
    return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2];
}

static vec unit(vec a)
{
    return along((vec){{0}}, 1 / sqrt(dot(a, a)), a);
}

static vec cross(vec a, vec b)
{
    return (vec){{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2],
                  a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

/* Two directions across a unit one. */
static void across(vec w, vec out[2])
{
    const vec any = {{fabs(w.v[0]) < 0.5, fabs(w.v[0]) >= 0.5, 0}};
    out[0] = unit(cross(w, any));
    out[1] = cross(w, out[0]);
}

static vec first_vertex(const pair *p, int ray, const lf_light_path *path)
{
    return along(wide(p->rays[ray].o), (double)(path->vertex[0].z + p->rays[ray].from),
                 wide(p->rays[ray].w));
}

/* |d(w_1, z_2)' / d(w_1, z_2)| by central differences: x2 is moved along w1 and to its sides. */
static double jacobian(vec x1, vec w1, double z2, vec other)
{
    const double h = 1e-4;
    const vec x2 = along(x1, z2, w1), w = unit(along(x2, -1, other));
    vec sides[2], their[2], rows[3];
    across(w1, sides);
    across(w, their);
    for (int i = 0; i < 3; i++) {
        vec end[2];
        double z[2];
        for (int k = 0; k < 2; k++) {
            const double step = k ? -h : h;
            const vec turned = i < 2 ? unit(along(w1, step, sides[i])) : w1;
            end[k] = along(along(x1, z2 + (i == 2 ? step : 0), turned), -1, other);
            z[k] = sqrt(dot(end[k], end[k]));
            end[k] = unit(end[k]);
        }
        const vec change = along(end[0], -1, end[1]);
        rows[i] = (vec){{dot(change, their[0]) / (2 * h), dot(change, their[1]) / (2 * h),
                         (z[0] - z[1]) / (2 * h)}};
    }
    return fabs(dot(rows[0], cross(rows[1], rows[2])));
}

/* Joints nearer than this are rounded by more than is looked for: places have 5e-7. */
#define NEAREST 0.05

/* What the first of them has, and so the second: same z_1, same x_2, what it brings is what it is
 * said to bring, and W is by the Jacobian greater. false: the joint is too short to tell. */
static bool follow(const pair *p)
{
    const lf_path_sample *own = &p->out[0], *moved = &p->out[1];
    lf_tracer tracer = {.scene = p->space.scene};
    const lf_path_value value = lf_light_path_value(&p->space, &p->rays[1], &moved->path, &tracer);
    double turned = 1;
    lf_assert_close(lf_path_target(&moved->value), lf_path_target(&value), 2e-3, 1e-9);
    lf_assert_close(lf_path_target(&own->value), lf_path_target(&p->samples[0].value), 0, 0);
    assert_true(moved->path.n == own->path.n && moved->path.escape == own->path.escape &&
                memcmp(moved->path.vertex, own->path.vertex,
                       offsetof(lf_path_vertex, z) * (own->path.n == 1)) == 0);
    if (own->path.n > 1) {
        const vec x1 = first_vertex(p, 0, &own->path), other = first_vertex(p, 1, &moved->path),
                  w1 = unit(wide(own->path.vertex[0].w));
        const double z2 = (double)own->path.vertex[1].z;
        const vec x2 = along(x1, z2, w1), its = along(other, (double)moved->path.vertex[1].z,
                                                      wide(moved->path.vertex[0].w));
        for (int i = 0; i < 3; i++)
            lf_assert_close(its.v[i], x2.v[i], 0, 2e-6);
        turned = jacobian(x1, w1, z2, other);
        if (fmin(z2, (double)moved->path.vertex[1].z) < NEAREST)
            return false;
    }
    lf_assert_close(moved->weight / own->weight, turned, 1e-4, 0);
    return true;
}

/* Of each path that both find: as above, and what it counts where it was found, by M of the two,
 * and what it would count if the other had found it, come to the sum of M. Then back it is what it
 * was. */
static void a_path_goes_to_a_neighbour_with_its_jacobian(void **state)
{
    (void)state;
    static pair p;
    lf_scene *scene = make_scene();
    lf_pool *pool = NULL;
    lf_tracer rng = {.rng = lf_test_seed() + 30};
    int both = 0, second = 0;
    lf_assert_ok(lf_pool_create(1, &pool), NULL);
    begin(&p, scene, pool);
    for (int i = 0; i < 20000 && second < 1000; i++) {
        if (!draw(&p, &rng))
            continue;
        const lf_path_sample first = p.samples[0];
        combine(&p);
        assert_true(p.out[0].kept && p.out[0].m == 7);
        if (!p.out[1].kept)
            continue;
        both++;
        /* no pole: what the other has is bounded by what was drawn, however short the joint */
        assert_true(p.out[1].weight * lf_path_target(&p.out[1].value) <
                    1.001 / 5 * 2 * first.weight * lf_path_target(&first.value));
        if (!follow(&p))
            continue;
        second += first.path.n > 1;
        const double share = p.out[0].weight * 7 / first.weight;
        p.samples[1] = p.out[1];
        p.samples[1].m = 5;
        p.samples[0] = (lf_path_sample){.m = 2};
        const double given = p.out[1].weight;
        combine(&p);
        lf_assert_close(share + p.out[1].weight * 7 / given, 7, 1e-3, 0);
        lf_assert_close((double)p.out[0].path.vertex[0].z, (double)first.path.vertex[0].z, 0, 1e-7);
        lf_assert_close((double)p.out[0].path.vertex[1].z, (double)first.path.vertex[1].z,
                        first.path.n > 1 ? 1e-4 : 0, 1e-6);
        lf_assert_close((double)lf_dot(p.out[0].path.vertex[0].w, first.path.vertex[0].w), 1, 1e-5,
                        0);
    }
    print_message("%d paths, %d with a second vertex\n", both, second);
    assert_true(second == 1000 && both - second > 100);
    lf_coarse_grid_finish(&p.coarse);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

/* --------------------------------------------------------------------------------- a furnace -- */

enum { width = 32, height = 16, n_views = 4, tile = 16, tiles = n_views * 2 + 1 };

/* The whole is 1 to 1e-5, of which 1e-7 are paths with more than 16 vertices: the cells are those
 * of the box, so that each walk brings what it should, and what one pixel of a block has too much
 * the others lack. Tiles are 1 in the mean; 1 % is seen in half of them. */
static void a_furnace_is_white(const char *text, const char *integrator, uint64_t salt)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "vpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    const double level = lf_sidak(0.25 * LF_FALSE_ALARM, 4 * tiles);
    lf_blocks seen;
    int found = 0;
    settings.integrator = integrator;
    settings.max_depth = 16;
    for (settings.choices.of[LF_PAPERS_REUSE] = 0;
         strcmp(lf_reuse_name(settings.choices.of[LF_PAPERS_REUSE]), "vertices") != 0;)
        settings.choices.of[LF_PAPERS_REUSE]++;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_blocks_init(&seen, n_views, width, height, tile);
    for (int k = 0; k < 24; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, 4);
        lf_blocks_add_picture(&seen, r, LF_ESTIMATOR_MIS);
    }
    lf_assert_close(seen.moments[tiles - 1].mean, 1, 1e-5, 0);
    for (int j = 0; j < tiles - 1; j++) {
        if (!(lf_p_mean(&seen.moments[j], 1) > level))
            fail_msg("%s: block %d: %g +- %g", integrator, j, seen.moments[j].mean,
                     lf_moments_error(&seen.moments[j]));
        found += lf_p_mean(&seen.moments[j], 1.01) < level;
    }
    print_message("%s: %.8f; 1 %% seen in %d of %d tiles\n", integrator,
                  seen.moments[tiles - 1].mean, found, tiles - 1);
    assert_true(2 * found >= tiles - 1);
    lf_blocks_finish(&seen);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

#define FORWARDS "{'volumes': {'fog': {'g': 0.7}}}"

static void furnaces_are_white_by_blocks_of_columns(void **state)
{
    (void)state;
    a_furnace_is_white(lf_test_scene_text("fog-furnace"), "restir", 40);
    a_furnace_is_white(lf_test_scene_patched("fog-furnace", FORWARDS), "restir", 41);
}

static void furnaces_are_white_by_blocks_of_views(void **state)
{
    (void)state;
    a_furnace_is_white(lf_test_scene_text("fog-furnace"), "mvrestir", 42);
    a_furnace_is_white(lf_test_scene_patched("fog-furnace", FORWARDS), "mvrestir", 43);
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_path_goes_to_a_neighbour_with_its_jacobian),
        cmocka_unit_test(furnaces_are_white_by_blocks_of_columns),
        cmocka_unit_test(furnaces_are_white_by_blocks_of_views),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
