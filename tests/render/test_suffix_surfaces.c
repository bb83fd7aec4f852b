/* Suffixes in lanes among surfaces. Closed forms: a furnace with white walls in it; what is left of
 * a sun behind half a roof, point by point; darkness under a whole one, also where the control says
 * anything. Bits are the same for every instruction set and whatever jobs are run together, and the
 * film for any number of threads. The mean of suffixes is that of path.c, in the whole and in each
 * piece of the grid; tests/render/test_brute_force.c holds a picture to what shares no code.
 * Negative controls: what is added to each mean is rejected, and a scene without its roof. */
#include "tests/render/suffixes.h"
#include "tests/scene_file.h"

#define WHITE "'sky': { 'type': 'environment', 'radiance': 1 }"
/* Floors and roofs of one material each, by their names. */
#define GROUND                                                                                     \
    "'ground': { 'shape': 'quad', 'material': 'clay', 'transform': { 'scale': 3, 'translate': "    \
    "[0, -1.1, 0] } }"
#define MADE                                                                                       \
    "'ball': { 'shape': 'sphere', 'material': 'made', 'transform': { 'scale': 0.6, 'translate': "  \
    "[0.5, 0.1, 0.2] } }"
/* Above the grid, in the sun's way. */
#define ROOF(scale, x)                                                                             \
    "'roof': { 'shape': 'quad', 'material': 'black', 'transform': { 'scale': " scale               \
    ", 'translate': [" x ", 2, 0] } }"
#define OF(made)                                                                                   \
    " }, 'materials': { 'clay': { 'type': 'diffuse', 'albedo': [0.8, 0.6, 0.4] }, 'black': { "     \
    "'type': 'diffuse', 'albedo': 0 }, 'made': { " made " } "
#define PLAIN OF("'type': 'diffuse'")

/* -------------------------------------------------------------------------------------- bits -- */

static void bits_are_the_same_for_every_instruction_set_and_batch(void **state)
{
    (void)state;
    assert_same_bits(make_scene(AMONG("'albedo': [0.9, 0.7, 0.4], 'g': 0.6", SKY ", " SUN,
                                      BALL ", " GROUND PLAIN),
                                25.0f),
                     LF_LANE_SURFACES);
    assert_same_bits(make_scene(AMONG("'albedo': [0.9, 0.7, 0.4], 'g': 0",
                                      SKY ", 'sun': { 'type': 'distant', "
                                          "'direction': [0.5, -0.7, -0.5], 'angle': 8 }",
                                      BALL ", " GROUND PLAIN),
                                25.0f),
                     LF_LANE_DISK | LF_LANE_SURFACES);
}

/* Of each of the file's three statistical tests, and of so many pieces of one. */
static double level(int pieces)
{
    return lf_sidak(LF_FALSE_ALARM / 3.0, pieces > 0 ? pieces : 1);
}

/* Pivots of a batch with suffixes by as many at a time as `most` says; until it is full they stay.
 */
static void fill(rig *r, int most, lf_suffix_batch *batch)
{
    uint64_t state = lf_hash64(lf_test_seed(), 9);
    lf_suffix_batch_init(batch, &r->lanes, best(), 3);
    for (int i = 0; i < 300; i++) {
        const lf_batch_pivot pivot = {.p = lf_v3(lf_test_uniform(&state) - 0.5f,
                                                 lf_test_uniform(&state) - 0.5f,
                                                 lf_test_uniform(&state) - 0.5f),
                                      .w = lf_v3(0.0f, 0.0f, -1.0f),
                                      .rng = lf_hash64(7, (uint64_t)i)};
        lf_sampler sampler;
        lf_sampler_init(&sampler, LF_SAMPLER_OWEN, pivot.rng, 0);
        assert_int_equal(lf_suffix_batch_add(batch, r->scene, &pivot, &sampler), i);
        batch->most = most;
        lf_suffix_batch_keep_up(batch, &r->tracer, 1024);
        assert_int_equal(batch->traced, (i + 1) / most * most);
        assert_true(batch->n == i + 1 && !lf_suffix_batch_is_full(batch));
    }
    lf_suffix_batch_trace(batch, &r->tracer, 1024);
    assert_int_equal(batch->traced, 300);
}

static void batches_traced_in_pieces_are_those_traced_at_once(void **state)
{
    (void)state;
    static lf_suffix_batch whole, pieces;
    rig r = make_rig(AMONG("'albedo': [0.9, 0.7, 0.4], 'g': 0.6", SKY ", " SUN, BALL), 9.0f);
    fill(&r, LF_BATCH_PIVOTS, &whole);
    fill(&r, 17, &pieces);
    for (int c = 0; c < 3; c++)
        assert_memory_equal(whole.radiance[c], pieces.radiance[c], 900 * sizeof(float));
    assert_memory_equal(whole.left, pieces.left, 300 * sizeof(float));
    float found = 0.0f;
    for (int i = 298; i < 300; i++) /* the last piece is 11 long */
        found += whole.left[i] + whole.radiance[0][3 * i] + whole.radiance[0][3 * i + 1];
    assert_true(found > 0.0f);
    drop_rig(&r);
}

/* Rows so wide that a visit has more pivots than a batch. */
static void films_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    enum { views = 2, width = 4000, height = 33 };
    static float seen[3][views * height * width * 3];
    static const int threads[] = {1, 2, 7};
    lf_scene *scene = make_scene(lf_test_scene_text("wide-rows"), 6.0f);
    for (int i = 0; i < 3; i++) {
        lf_pool *pool = NULL;
        lf_assert_ok(lf_pool_create(threads[i], &pool), NULL);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
        lf_render_settings settings = *lf_renderer_settings(r);
        settings.skip = LF_SKIP_ALL;
        lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
        assert_true(r->lanes && r->lanes->has == LF_LANE_SURFACES);
        lf_test_passes(r, views);
        const lf_rows *rows = r->state;
        const lf_batch_pivot *last = &rows->queues[0].batch.pivot[LF_BATCH_PIVOTS - 1];
        assert_true(i > 0 || last->rng != 0); /* a batch was full */
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, seen[i], NULL), NULL);
        lf_renderer_destroy(r);
        lf_pool_destroy(pool);
    }
    assert_memory_equal(seen[0], seen[1], sizeof seen[0]);
    assert_memory_equal(seen[0], seen[2], sizeof seen[0]);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------ closed forms -- */

/* What arrives in the mean, in the second channel. */
static lf_moments arriving(rig *r, uint64_t seed, int max_depth)
{
    static jobs j;
    lf_moments found = {0};
    for (uint64_t round = 0; round < 40; round++) {
        double sum = 0.0;
        draw_jobs(r, seed + round, n_jobs, &j);
        trace(best(), r, &j, 0, n_jobs, max_depth);
        for (int i = 0; i < n_jobs; i++)
            sum += (double)j.radiance[1][i] / n_jobs;
        lf_moments_add(&found, sum);
    }
    return found;
}

static lf_moments furnace(const char *text)
{
    rig r = make_rig(text, 10.0f);
    assert_true(r.lanes.has == LF_LANE_SURFACES);
    lf_moments seen = arriving(&r, 40, 1 << 20);
    drop_rig(&r);
    return seen;
}

#define WALLS(albedo)                                                                              \
    "'floor': { 'shape': 'quad', 'material': 'made', 'transform': { 'scale': 2, 'translate': "     \
    "[0, -0.3, 0] } }, 'wall': { 'shape': 'quad', 'material': 'made', 'transform': { 'scale': "    \
    "0.5, 'rotate': [90, 20, 0] } }" OF("'type': 'diffuse', 'albedo': " albedo)

static void nothing_is_lost_in_a_furnace_with_white_walls(void **state)
{
    (void)state;
    lf_moments white = furnace(AMONG("'albedo': 1, 'g': 0.5", WHITE, WALLS("1"))),
               grey = furnace(AMONG("'albedo': 1, 'g': 0.5", WHITE, WALLS("0.98")));
    /* to the rounding of each path: no light sample is drawn from an even sky */
    lf_assert_close(white.mean, 1.0, 0, 1e-6);
    assert_true(lf_moments_error(&white) < 1e-6 && lf_p_mean(&grey, 1.0) < level(0));
}

/* The roof of x > -1.4 at y = 2 hides the sun from those whose way to it comes through there. */
static void half_a_roof_hides_the_sun_from_whom_it_stands_before(void **state)
{
    (void)state;
    static jobs j;
    lf_moments off = {0};
    rig r = make_rig(AMONG("'albedo': 0.8", SUN, ROOF("3", "1.6") PLAIN), 3.0f);
    const lf_vec3 toward = lf_v3(r.lanes.toward[0], r.lanes.toward[1], r.lanes.toward[2]);
    int hidden = 0;
    draw_jobs(&r, 5, n_jobs, &j);
    for (int i = 0; i < n_jobs; i++)
        for (int a = 0; a < 3; a++)
            j.q[a][i] = j.q[a][i % 512];
    light(best(), &r, &j, 0, n_jobs);
    for (int i = 0; i < n_jobs; i++) {
        const lf_vec3 p = j.p[i % 512],
                      o = lf_v3((float)r.scene->origin[0], (float)r.scene->origin[1], 0.0f);
        const float x = o.x + p.x + (2.0f - o.y - p.y) / toward.y * toward.x + 1.4f;
        if (fabsf(x) < 1e-3f)
            continue;
        hidden += x > 0.0f;
        if (x > 0.0f)
            assert_true(j.left[i] == 0.0f);
        else
            lf_moments_add(&off, (double)j.left[i] - left_beyond(&r, p, toward));
    }
    print_message("%d of %d hidden; the others %.2g +- %.2g off\n", hidden, n_jobs, off.mean,
                  lf_moments_error(&off));
    assert_in_range(hidden, n_jobs / 5, n_jobs * 4 / 5);
    assert_true(lf_p_mean(&off, 0.0) > level(0));
    assert_true(lf_p_mean(&off, 0.03) < level(0));
    drop_rig(&r);
}

/* Where next to nothing collides a path has met nothing just when no ray meets the ball. */
static void what_meets_a_surface_has_not_escaped(void **state)
{
    (void)state;
    static jobs j;
    rig r = make_rig(
        AMONG("'albedo': 0.8",
              SKY ", 'sun': { 'type': 'distant', 'direction': [0, -1, 0], 'angle': 9 }", BALL),
        1e-7f);
    int met = 0;
    draw_jobs(&r, 6, n_jobs, &j);
    trace(best(), &r, &j, 0, n_jobs, 1);
    for (int i = 0; i < n_jobs; i++) {
        const lf_vec3 w = lf_v3(j.w[0][i], j.w[1][i], j.w[2][i]);
        const bool meets = lf_trace_occluded(&r.tracer, j.p[i], w, INFINITY);
        met += meets;
        assert_true(j.escaped[i] == (meets ? 0.0f : 1.0f));
    }
    assert_in_range(met, n_jobs / 10, n_jobs * 9 / 10);
    drop_rig(&r);
}

static void under_a_whole_roof_it_is_dark_whatever_the_control_says(void **state)
{
    (void)state;
    rig r = make_rig(AMONG("'albedo': 0.8", SUN, ROOF("9", "0") PLAIN), 3.0f);
    const lf_lane_field *field = r.lanes.field;
    const size_t nodes =
        (size_t)field->nodes[0] * (size_t)field->nodes[1] * (size_t)field->nodes[2];
    lf_moments dark = arriving(&r, 80, 1024), noisy, lit;
    assert_true(dark.mean == 0.0 && lf_moments_error(&dark) == 0.0);
    for (size_t i = 0; i < nodes; i++)
        field->left[i] = (uint16_t)lf_hash64(i, 0);
    noisy = arriving(&r, 80, 1024);
    drop_rig(&r);
    r = make_rig(AMONG("'albedo': 0.8", SUN, ROOF("0.01", "0") PLAIN), 3.0f);
    lit = arriving(&r, 80, 1024);
    drop_rig(&r);
    print_message("%.2g +- %.2g by a control that says anything, of %.4g in the sun\n", noisy.mean,
                  lf_moments_error(&noisy), lit.mean);
    assert_true(lf_p_mean(&noisy, 0.0) > level(0));
    assert_true(lf_p_mean(&noisy, 0.02 * lit.mean) < level(0));
}

/* ------------------------------------------------------------------------ the mean of path.c -- */

static void the_mean_among_surfaces_is_that_of_single_paths(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        float sigma;
        int max_depth, rounds;
        double bias; /* relative, that would be seen in the whole */
    } cases[] = {
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0", SKY ", " SUN, BALL ", " GROUND PLAIN), 4.0f,
         1024, 60, 0.01},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0.7", SKY ", " SUN,
               MADE ", " GROUND OF("'type': 'plastic', 'roughness': 0.2")),
         4.0f, 1024, 60, 0.02},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0.3", SKY ", " SUN,
               MADE ", " ROOF("3", "3") OF("'type': 'conductor', 'roughness': 0")),
         4.0f, 1024, 60, 0.02},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': -0.3", SKY,
               MADE OF("'type': 'principled', 'transmission': 1, 'roughness': 0, 'albedo': 1")),
         2.0f, 1024, 60, 0.01},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0.3", SKY ", " SUN,
               MADE OF("'type': 'principled', 'transmission': 1, 'roughness': 0.4, 'albedo': 1")),
         2.0f, 1024, 60, 0.02},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0", SKY ", " SUN,
               "'posts': { 'shape': 'cube', 'instances': [ { 'scale': 0.3, "
               "'translate': [-0.8, 0, 0] }, { 'scale': [0.2, 0.6, 0.3], 'rotate': [0, 30, 10], "
               "'translate': [0.6, 0, 0] } ] }"),
         4.0f, 1024, 60, 0.02},
        {AMONG("'albedo': [0.9, 0.8, 0.6], 'g': 0", SKY ", " SUN, BALL ", " GROUND PLAIN), 4.0f, 3,
         60, 0.01},
    };
    enum { n = sizeof cases / sizeof *cases };
    for (int i = 0; i < n; i++) {
        char name[64];
        rig r = make_rig(cases[i].text, cases[i].sigma);
        assert_true(r.lanes.has == LF_LANE_SURFACES);
        snprintf(name, sizeof name, "suffix_surfaces-%d", i);
        assert_mean_of_single_paths(&r, name, cases[i].max_depth, cases[i].rounds, cases[i].bias,
                                    level(n * LOOKS));
        drop_rig(&r);
    }
}

/* ------------------------------------------------------------------------------------ scenes -- */

/* Of more meshes than boxes the last holds the rest; all of each is in one of them. */
static void boxes_hold_all_meshes(void **state)
{
    (void)state;
    char text[4096];
    int length = snprintf(text, sizeof text,
                          "{ 'quiltd': 1, 'volumes': { 'v': { 'shape': 'box', 'density': 1 } }, "
                          "'lights': { " SKY " }, 'meshes': { ");
    for (int i = 0; i < 12; i++)
        length += snprintf(text + length, sizeof text - (size_t)length,
                           "%s'm%d': { 'shape': 'sphere', 'transform': { 'scale': 0.1, "
                           "'translate': [%g, %g, 40] } }",
                           i ? ", " : "", i, 0.3 * i - 1.5, 0.2 * (i % 3));
    snprintf(text + length, sizeof text - (size_t)length, " } }");
    rig r = make_rig(text, 3.0f);
    const lf_lane_boxes *boxes = &r.lanes.boxes;
    const lf_volume *v = &r.scene->volumes[0];
    assert_int_equal(boxes->n, LF_LANE_BOXES);
    for (int m = 0; m < r.scene->n_meshes; m++)
        for (int i = 0; i < r.scene->meshes[m].n_vertices; i++) {
            const lf_vec3 p = lf_mesh_vertex(&r.scene->meshes[m], (uint32_t)i);
            bool within = false;
            for (int b = 0; b < boxes->n; b++) {
                bool in = true;
                for (int a = 0; a < 3; a++) {
                    const float *row = v->to_volume[a],
                                q = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
                    in = in && q >= boxes->min[b][a] && q <= boxes->max[b][a];
                }
                within = within || in;
            }
            assert_true(within);
        }
    drop_rig(&r);
}

static void a_field_is_made_anew_for_other_meshes(void **state)
{
    (void)state;
    rig r = make_rig(AMONG("'albedo': 0.8", SUN, ROOF("9", "0") PLAIN), 3.0f);
    lf_lane_scene again;
    lf_scene without = *r.scene;
    assert_int_equal(lf_lane_scene_init(&again, r.scene, &r.lanes, r.pool), LF_OK);
    assert_ptr_equal(again.field, r.lanes.field);
    lf_lane_scene_finish(&again);
    without.geometry = NULL;
    r.lanes.field->scene = &without; /* what the field was made of */
    assert_int_equal(lf_lane_scene_init(&again, r.scene, &r.lanes, r.pool), LF_OK);
    assert_ptr_not_equal(again.field, r.lanes.field);
    lf_lane_scene_finish(&again);
    r.lanes.field->scene = r.scene;
    drop_rig(&r);
}

static void surfaces_that_ask_for_more_are_left_to_single_paths(void **state)
{
    (void)state;
    static const char *const others[] = {
        "'type': 'principled', 'transmission': 1, 'roughness': 0, 'absorption': 1",
        "'type': 'principled', 'subsurface': 1",
        "'type': 'principled', 'transmission': 1, 'roughness': 0, 'glass': 'sheet'",
        "'type': 'diffuse', 'emission': 1",
    };
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        char text[1024];
        snprintf(text, sizeof text, AMONG("'albedo': 0.8", SKY, MADE OF("%s")), others[i]);
        lf_scene *scene = make_scene(text, 3.0f);
        if (lf_lane_scene_serves(scene))
            fail_msg("%s is served", others[i]);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_are_the_same_for_every_instruction_set_and_batch),
        cmocka_unit_test(batches_traced_in_pieces_are_those_traced_at_once),
        cmocka_unit_test(films_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(nothing_is_lost_in_a_furnace_with_white_walls),
        cmocka_unit_test(half_a_roof_hides_the_sun_from_whom_it_stands_before),
        cmocka_unit_test(what_meets_a_surface_has_not_escaped),
        cmocka_unit_test(under_a_whole_roof_it_is_dark_whatever_the_control_says),
        cmocka_unit_test(the_mean_among_surfaces_is_that_of_single_paths),
        cmocka_unit_test(boxes_hold_all_meshes),
        cmocka_unit_test(a_field_is_made_anew_for_other_meshes),
        cmocka_unit_test(surfaces_that_ask_for_more_are_left_to_single_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
