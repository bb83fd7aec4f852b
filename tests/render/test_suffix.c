/* Suffixes in lanes. Their functions against libm; their bits, which are the same for every
 * instruction set and whatever jobs are run together; closed forms: a furnace, what is left of a
 * sky and of a sun behind a grid (its integral in double precision), also where the control says
 * anything; and the mean of whole suffixes, which is that of path.c, by Welch's test over suffixes
 * that leave the same places. Negative controls: what is added to each mean is rejected. */
#include "tests/testing.h"

#include "tests/render/suffixes.h"

/* --------------------------------------------------------------------------------- functions -- */

static void functions_are_libm_s_within_rounding(void **state)
{
    (void)state;
    for (int i = 0; i < 1 << 20; i++) {
        const float u = ((float)i + 0.5f) * 0x1p-20f, small = u * u * u * u;
        const lanes at = {u, small, 1.0f - 0x1p-24f, 0.5f * u};
        lanes sine, cosine, way = exponential_of(at);
        sine_cosine(at, &sine, &cosine);
        for (int k = 0; k < 4; k++) {
            const double x = (double)at[k], turn = 2.0 * 3.14159265358979323846 * x;
            /* 1 - u has been rounded */
            lf_assert_close((double)way[k], -log1p(-x), 0, 1e-7 / (1.0 - x) + 4e-7 * -log1p(-x));
            lf_assert_close((double)sine[k], sin(turn), 0, 3e-7);
            lf_assert_close((double)cosine[k], cos(turn), 0, 3e-7);
        }
    }
}

/* Mean, variance and correlation of neighbours of 2^20 numbers, of four streams whose keys differ
 * in one bit. */
static void random_numbers_are_even(void **state)
{
    (void)state;
    enum { n = 1 << 20 };
    const mask every = mask_of(15);
    lanes_random random = {0};
    lf_moments value[4] = {{0}}, square[4] = {{0}}, next[4] = {{0}}, beside = {0};
    lanes before = all(0.5f);
    begin_random(&random, every, (lanes_bits){1, 2, 3, 1}, (lanes_bits){7, 7, 7, 6});
    for (int i = 0; i < n; i++) {
        lanes u = draw_unit(&random, every);
        for (int k = 0; k < 4; k++) {
            lf_moments_add(&value[k], (double)u[k]);
            lf_moments_add(&square[k], (double)u[k] * (double)u[k]);
            lf_moments_add(&next[k], ((double)u[k] - 0.5) * ((double)before[k] - 0.5));
        }
        lf_moments_add(&beside, ((double)u[0] - 0.5) * ((double)u[3] - 0.5));
        before = u;
    }
    const double level = lf_sidak(LF_FALSE_ALARM, 13);
    for (int k = 0; k < 4; k++) {
        assert_true(lf_p_mean(&value[k], 0.5) > level);
        assert_true(lf_p_mean(&square[k], 1.0 / 3.0) > level);
        assert_true(lf_p_mean(&next[k], 0.0) > level);
    }
    assert_true(lf_p_mean(&beside, 0.0) > level);
}

/* -------------------------------------------------------------------------------------- bits -- */

static void bits_are_the_same_for_every_instruction_set_and_batch(void **state)
{
    (void)state;
    static const char text[] = SCENE("'albedo': [0.9, 0.7, 0.4], 'g': 0.6", SKY ", " SUN);
    assert_same_bits(make_scene(text, 25.0f), 0);
    assert_same_bits(make_short_scene(text, 25.0f), 0);
}

/* A grid in 16 bits is read where it lies; the same values as floats are in lanes shares of their
 * brick's largest, off by 2^-17 of that at most: a path that looks 10 to 100 of them up goes
 * another way once in a thousand paths, and weights of shadow rays are off by as little. With the
 * random numbers of another seed nearly all differ. */
static void sixteen_bits_are_read_where_they_lie(void **state)
{
    (void)state;
    static const char text[] = SCENE("'albedo': [0.9, 0.7, 0.4], 'g': 0.6", SKY ", " SUN);
    static jobs j[3];
    rig r = rig_of(make_short_scene(text, 25.0f));
    lf_grid *own = r.scene->volumes[0].grid, *floats = lf_test_grid(soft, 30, 17, 12);
    for (size_t i = 0; i < ((size_t)own->n_bricks + 1) * LF_BRICK_STRIDE; i++)
        floats->values[i] = lf_grid_stored(own, i);
    lf_grid_finish(floats);
    rig as_floats = rig_of(lf_test_grid_scene(text, floats, 0.1, 0.4, 25.0f, false));
    assert_true(!r.lanes.field->values && as_floats.lanes.field->values);
    draw_jobs(&r, 7, n_jobs, &j[0]);
    memcpy(&j[1], &j[0], sizeof j[0]);
    memcpy(&j[2], &j[0], sizeof j[0]);
    for (int i = 0; i < n_jobs; i++)
        j[2].random[0][i] ^= 1;
    trace(best(), &r, &j[0], 0, n_jobs, 40);
    trace(best(), &as_floats, &j[1], 0, n_jobs, 40);
    trace(best(), &r, &j[2], 0, n_jobs, 40);
    int differ[2] = {0, 0};
    for (int i = 0; i < n_jobs; i++)
        for (int k = 1; k < 3; k++)
            differ[k - 1] += !(fabsf(j[k].radiance[1][i] - j[0].radiance[1][i]) <=
                               1e-3f * (1.0f + fabsf(j[0].radiance[1][i])));
    print_message("other paths: %d of %d; by other numbers %d\n", differ[0], n_jobs, differ[1]);
    assert_in_range(differ[0], 0, n_jobs / 200);
    assert_in_range(differ[1], n_jobs / 2, n_jobs);
    drop_rig(&r);
    drop_rig(&as_floats);
}

/* ------------------------------------------------------------------------------ closed forms -- */

static void nothing_is_lost_in_a_furnace(void **state)
{
    (void)state;
    static jobs j;
    rig r = make_rig(
        SCENE("'albedo': 1, 'g': -0.5", "'sky': { 'type': 'environment', 'radiance': 1 }"), 30.0f);
    draw_jobs(&r, 2, n_jobs, &j);
    trace(best(), &r, &j, 0, n_jobs, 1 << 20);
    for (int i = 0; i < n_jobs; i++)
        for (int c = 0; c < 3; c++)
            assert_true(j.radiance[c][i] == 1.0f);
    drop_rig(&r);
}

/* What is asked of a rig: of its sun or of its sky; the difference, or that over the truth where
 * the truth is a few per cent. */
typedef enum asked { SKY_LEFT, SUN_LEFT, LITTLE_SUN_LEFT } asked;

/* Mean over jobs of estimate - truth, by n estimates of each. */
static void assert_left_behind(rig *r, asked of, const char *what, int rounds, double level)
{
    enum { places = 64, each = n_jobs / places };
    const bool sun = of != SKY_LEFT;
    static jobs j;
    lf_moments off = {0};
    draw_jobs(r, 3, n_jobs, &j);
    const lf_vec3 toward = lf_v3(r->lanes.toward[0], r->lanes.toward[1], r->lanes.toward[2]);
    double truth[places];
    for (int i = 0; i < n_jobs; i++)
        for (int a = 0; a < 3; a++) {
            j.q[a][i] = j.q[a][i % places];
            j.w[a][i] = j.w[a][i % places];
        }
    for (int i = 0; i < places; i++)
        truth[i] = left_beyond(r, j.p[i], sun ? toward : lf_v3(j.w[0][i], j.w[1][i], j.w[2][i]));
    uint64_t key = lf_hash64(lf_test_seed(), 4);
    for (int round = 0; round < rounds; round++) {
        for (int i = 0; i < n_jobs; i++)
            put_key(&j, i, key = lf_hash64(key, 5));
        if (sun)
            light(best(), r, &j, 0, n_jobs);
        else
            trace(best(), r, &j, 0, n_jobs, 1);
        for (int k = 0; k < each; k++) {
            double sum = 0.0;
            for (int i = 0; i < places; i++) {
                double seen =
                    (double)(sun ? j.left[k * places + i] : j.radiance[0][k * places + i]);
                if (of != LITTLE_SUN_LEFT)
                    sum += (seen - truth[i]) / places;
                else if (truth[i] > 0.01 && truth[i] < 0.1)
                    sum += (seen / truth[i] - 1.0) / places;
            }
            lf_moments_add(&off, sum);
        }
    }
    if (!(lf_p_mean(&off, 0.0) > level))
        fail_msg("%s: off by %.2g +- %.2g", what, off.mean, lf_moments_error(&off));
    /* what the test sees */
    if (!(lf_p_mean(&off, 0.02) < level))
        fail_msg("%s: %.2g is too much noise", what, lf_moments_error(&off));
}

static void light_and_sky_are_dimmed_as_the_integral_says(void **state)
{
    (void)state;
    const double level = lf_sidak(LF_FALSE_ALARM, 7);
    rig r = make_rig(SCENE("'albedo': 0.8, 'g': 0.3", SUN), 3.0f);
    size_t nodes = (size_t)r.lanes.field->nodes[0] * (size_t)r.lanes.field->nodes[1] *
                   (size_t)r.lanes.field->nodes[2];
    assert_left_behind(&r, SUN_LEFT, "the control as it is", 60, level);
    for (size_t i = 0; i < nodes; i++)
        r.lanes.field->left[i] = (uint16_t)lf_hash64(i, 0);
    assert_left_behind(&r, SUN_LEFT, "a control that says anything", 60, level);
    memset(r.lanes.field->left, 255, nodes * sizeof *r.lanes.field->left);
    assert_left_behind(&r, SUN_LEFT, "a control without shadows", 60, level);
    lf_free(r.lanes.field->left);
    r.lanes.field->left = NULL;
    assert_left_behind(&r, SUN_LEFT, "no control", 60, level);
    drop_rig(&r);
    /* all that comes through has passed the roulette */
    r = make_rig(SCENE("'albedo': 0.8, 'g': 0.3", SUN), 9.0f);
    lf_free(r.lanes.field->left);
    r.lanes.field->left = NULL;
    assert_left_behind(&r, LITTLE_SUN_LEFT, "deep, without a control", 60, level);
    drop_rig(&r);
    static const char sky[] =
        SCENE("'albedo': 0.8, 'g': 0.3", "'sky': { 'type': 'environment', 'radiance': 1 }");
    r = make_rig(sky, 3.0f);
    assert_left_behind(&r, SKY_LEFT, "sky", 60, level);
    drop_rig(&r);
    r = rig_of(make_short_scene(sky, 3.0f));
    assert_left_behind(&r, SKY_LEFT, "sky behind 16 bits", 60, level);
    drop_rig(&r);
}

/* Haze, and in each brick a voxel that is dense. */
static float specks(int x, int y, int z, float haze)
{
    return x % 8 == 3 && y % 8 == 3 && z % 8 == 3 ? 1.0f : haze;
}
static float dense_specks(int x, int y, int z)
{
    return specks(x, y, z, 0.02f / 50.0f);
}
static float solid_specks(int x, int y, int z)
{
    return specks(x, y, z, 0.02f / 2000.0f);
}

/* Shares of what a brick's densest voxel has cannot say what is thin beside a solid one: then
 * suffixes go one by one. */
static void what_is_thin_beside_the_dense_is_kept(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        lf_voxel_fn voxel;
        float most;
        bool served;
    } cases[] = {{"dense", dense_specks, 50.0f, true}, {"solid", solid_specks, 2000.0f, false}};
    const char *sky = SCENE("'albedo': 0.8", "'sky': { 'type': 'environment', 'radiance': 1 }");
    for (int i = 0; i < 2; i++) {
        lf_grid *grid = lf_test_grid(cases[i].voxel, 30, 17, 12);
        lf_scene *scene = lf_test_grid_scene(sky, grid, 0.1, 0.4, cases[i].most / 0.1f, false);
        rig r = {.scene = scene, .memory = calloc(1, sizeof *r.memory)};
        assert_non_null(r.memory);
        assert_int_equal(lf_pool_create(2, &r.pool), LF_OK);
        assert_int_equal(lf_lane_scene_init(&r.lanes, scene, NULL, r.pool), LF_OK);
        if (r.lanes.field)
            assert_left_behind(&r, SKY_LEFT, cases[i].what, 4, lf_sidak(LF_FALSE_ALARM, 2));
        assert_true(lf_lane_scene_serves(scene) == cases[i].served);
        drop_rig(&r);
    }
}

/* No ray leaves for a light that is not there: it would stand still, also where nothing is. */
static void nothing_is_traced_without_a_light(void **state)
{
    (void)state;
    static jobs j;
    rig r = make_rig(SCENE("'albedo': 0.8", SKY), 3.0f);
    draw_jobs(&r, 6, n_jobs, &j);
    for (int k = 0; lf_kernels_at(k); k++) {
        memset(j.left, 255, sizeof j.left);
        assert_true(light(lf_kernels_at(k)->suffixes, &r, &j, 0, n_jobs) == 0);
        for (int i = 0; i < n_jobs; i++)
            assert_true(j.left[i] == 0.0f);
    }
    drop_rig(&r);
}

/* ------------------------------------------------------------------------ the mean of path.c -- */

typedef struct means {
    lf_moments lanes, path;
} means;

/* A replicate: all jobs once, from the same places. */
static means compare(rig *r, int max_depth, int rounds)
{
    static jobs j;
    static double alone[n_jobs];
    means m;
    memset(&m, 0, sizeof m);
    for (int round = 0; round < rounds; round++) {
        double sum[2] = {0.0, 0.0};
        draw_jobs(r, 100 + (uint64_t)round, n_jobs, &j);
        trace(best(), r, &j, 0, n_jobs, max_depth);
        single(r, &j, max_depth, alone);
        for (int i = 0; i < n_jobs; i++) {
            for (int c = 0; c < 3; c++)
                sum[0] += (double)j.radiance[c][i] / n_jobs;
            sum[1] += alone[i] / n_jobs;
        }
        lf_moments_add(&m.lanes, sum[0]);
        lf_moments_add(&m.path, sum[1]);
    }
    return m;
}

/* The differences of replicates, which have their places in common. */
static void the_mean_is_that_of_single_paths(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        float sigma;
        int max_depth, rounds;
        double bias; /* relative, that would be seen */
    } cases[] = {
        {SCENE("'albedo': [0.9, 0.8, 0.6], 'g': 0", SKY), 12.0f, 1024, 60, 0.003},
        {SCENE("'albedo': [0.98, 0.95, 0.9], 'g': 0", SKY ", " SUN), 12.0f, 1024, 120, 0.006},
        {SCENE("'albedo': [0.9, 0.5, 0.3], 'g': 0.7", SKY ", " SUN), 6.0f, 1024, 60, 0.015},
        {SCENE("'albedo': [0.9, 0.5, 0.3], 'g': -0.6", SUN), 6.0f, 4, 120, 0.03},
        {SCENE("'albedo': 0.9, 'g': 0.98", SKY ", " SUN), 20.0f, 1024, 60, 0.05},
        {SCENE("'albedo': 0, 'g': 0", SKY ", " SUN), 6.0f, 1024, 60, 0.01},
    };
    enum { n = sizeof cases / sizeof *cases };
    const double level = lf_sidak(LF_FALSE_ALARM, n);
    for (int i = 0; i < n; i++) {
        rig r = make_rig(cases[i].text, cases[i].sigma);
        means m = compare(&r, cases[i].max_depth, cases[i].rounds), biased = m;
        double p = lf_p_welch(&m.lanes, &m.path);
        if (!(p > level))
            fail_msg("case %d: %.5g +- %.2g in lanes, %.5g +- %.2g alone", i, m.lanes.mean,
                     lf_moments_error(&m.lanes), m.path.mean, lf_moments_error(&m.path));
        biased.lanes.mean *= 1.0 + 2.0 * cases[i].bias;
        if (!(lf_p_welch(&biased.lanes, &biased.path) < level))
            fail_msg("case %d: %.2g and %.2g of %.5g is too much noise", i,
                     lf_moments_error(&m.lanes), lf_moments_error(&m.path), m.path.mean);
        drop_rig(&r);
    }
}

/* ------------------------------------------------------------------------------------- queue -- */

/* Of a small picture: pivots that may wait in the end. */
static int64_t waiting(rig *r, float sigma, float albedo)
{
    lf_renderer *renderer;
    r->scene->volumes[0].sigma_scale = r->scene->volumes[0].sigma_max = sigma;
    r->scene->volumes[0].albedo = lf_v3(albedo, albedo, albedo);
    renderer = lf_test_renderer(r->scene, "mvpt", 64, 2, r->pool);
    lf_render_settings settings = *lf_renderer_settings(renderer);
    settings.skip = LF_SKIP_ALL;
    settings.max_depth = 65536;
    lf_assert_ok(lf_renderer_restart(renderer, r->scene, &settings, NULL), NULL);
    lf_assert_ok(lf_renderer_passes(renderer, NULL, 90, false, NULL, NULL, NULL), NULL);
    const lf_rows *rows = renderer->state;
    assert_non_null(rows->queues);
    int64_t most = rows->queues[0].batch.most;
    lf_renderer_destroy(renderer);
    return most;
}

/* Paths bounce some hundred times. */
#define IN_A_WHITE_ROOM                                                                            \
    AMONG("'albedo': 1", SKY,                                                                      \
          "'room': { 'shape': 'cube', 'material': 'white', 'transform': { 'scale': 30 } } }, "     \
          "'materials': { 'white': { 'type': 'diffuse', 'albedo': 0.99 } ")

/* Batches are short where paths are long: nobody asks within one whether the visit is cancelled. */
static void few_wait_where_paths_are_long(void **state)
{
    (void)state;
    rig r = make_rig(SCENE("'albedo': 1", SKY), 4.0f);
    int64_t thin = waiting(&r, 4.0f, 0.5f), dense = waiting(&r, 600.0f, 1.0f);
    print_message("%d pivots wait in thin smoke, %d in dense white\n", (int)thin, (int)dense);
    assert_true(thin == LF_BATCH_PIVOTS);
    assert_true(dense >= 16 && dense < LF_BATCH_PIVOTS * 3 / 4);
    drop_rig(&r);
    /* what is traced one by one behind surfaces counts, too */
    r = rig_of(make_scene(IN_A_WHITE_ROOM, 4.0f));
    int64_t around = waiting(&r, 4.0f, 0.5f);
    print_message("%d wait in thin smoke in a white room\n", (int)around);
    assert_true(around >= 16 && around < LF_BATCH_PIVOTS * 3 / 4);
    drop_rig(&r);
}

/* ------------------------------------------------------------------------------------ scenes -- */

static void a_field_is_kept_while_grid_and_light_stay(void **state)
{
    (void)state;
    rig r = make_rig(SCENE("'albedo': 0.8", SKY ", " SUN), 3.0f);
    lf_lane_scene again;
    assert_int_equal(lf_lane_scene_init(&again, r.scene, &r.lanes, r.pool), LF_OK);
    assert_ptr_equal(again.field, r.lanes.field);
    lf_lane_scene_finish(&again);
    r.scene->volumes[0].albedo = lf_v3(0.1f, 0.2f, 0.3f);
    r.scene->volumes[0].sigma_scale = 5.0f;
    /* the field was made of this very scene: another stands for what it was */
    lf_scene other = *r.scene;
    lf_volume volume = r.scene->volumes[0];
    volume.sigma_scale = 3.0f;
    other.volumes = &volume;
    r.lanes.field->scene = &other;
    assert_int_equal(lf_lane_scene_init(&again, r.scene, &r.lanes, r.pool), LF_OK);
    assert_ptr_not_equal(again.field, r.lanes.field);
    assert_true(again.albedo[1] == 0.2f);
    lf_lane_scene_finish(&again);
    r.lanes.field->scene = r.scene;
    drop_rig(&r);
}

static void what_lanes_cannot_do_is_left_to_single_paths(void **state)
{
    (void)state;
    static const char *const others[] = {
        SCENE("'albedo': 0.8", SKY ", 'lamp': { 'type': 'point', 'position': [0, 5, 0] }"),
        SCENE("'albedo': 0.8", SUN ", 'moon': { 'type': 'distant', 'direction': [1, -1, 0] }"),
        SCENE("'albedo': 0.8, 'droplets': 20", SKY),
        "{ 'quiltd': 1, 'volumes': { 'v': { 'shape': 'box', 'density': 1 }, 'w': { 'shape': "
        "'sphere', 'density': 1 } }, 'lights': { " SKY " } }",
    };
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        lf_scene *scene = lf_test_grid_scene(others[i], lf_test_grid(soft, 9, 9, 9), 0.1, 0, 1, 0);
        if (lf_lane_scene_serves(scene))
            fail_msg("%s is served", others[i]);
        lf_scene_unref(scene);
    }
    lf_scene *cubes = lf_test_grid_scene(SCENE("'albedo': 0.8", SKY), lf_test_grid(soft, 9, 9, 9),
                                         0.1, 0, 1, true);
    assert_false(lf_lane_scene_serves(cubes));
    lf_scene_unref(cubes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_are_libm_s_within_rounding),
        cmocka_unit_test(random_numbers_are_even),
        cmocka_unit_test(bits_are_the_same_for_every_instruction_set_and_batch),
        cmocka_unit_test(sixteen_bits_are_read_where_they_lie),
        cmocka_unit_test(nothing_is_lost_in_a_furnace),
        cmocka_unit_test(light_and_sky_are_dimmed_as_the_integral_says),
        cmocka_unit_test(what_is_thin_beside_the_dense_is_kept),
        cmocka_unit_test(nothing_is_traced_without_a_light),
        cmocka_unit_test(the_mean_is_that_of_single_paths),
        cmocka_unit_test(few_wait_where_paths_are_long),
        cmocka_unit_test(a_field_is_kept_while_grid_and_light_stay),
        cmocka_unit_test(what_lanes_cannot_do_is_left_to_single_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
