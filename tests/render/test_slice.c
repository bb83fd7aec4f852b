/* Media on a row's plane stand for the volumes: where they are dense, where the camera is inside,
 * where most of them is out of sight; and rays start on the right side of big triangles. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { SIDE = 12 };

#define NARROW "'camera': { 'position': [0, 0, 5], 'fov_y': 3, 'aspect': 1, 'cone': 0, 'views': 1 }"

/* Mean radiance of the picture after some whole cycles, and the renderer's counters. */
static double mean_of(const char *text, int cycles, lf_render_stats *out_stats)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    int views = lf_renderer_settings(r)->camera.n_views, n = views * SIDE * SIDE * 3;
    float *out = lf_calloc((size_t)n, sizeof *out);
    double sum = 0.0;
    assert_non_null(out);
    lf_test_passes(r, (int64_t)cycles * views);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MIS, out, NULL), NULL);
    for (int i = 0; i < n; i++)
        sum += (double)out[i];
    if (out_stats)
        lf_renderer_stats(r, out_stats);
    lf_free(out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return sum / n;
}

/* albedo E/(4 pi) m0/(m0 + mv): single scattering of a thick isotropic slab (Chandrasekhar 1950),
 * sun at cosine m0, seen at mv. */
static void scatters_at_its_surface(const char *density, int thickness)
{
    const char *text = lf_test_scene_patched(
        "slab-under-low-sun",
        "{'volumes': {'slab': {'density': %s, 'transform': {'scale': [40, 4, %d]}}}}", density,
        thickness);
    lf_assert_close(mean_of(text, 400, NULL), 10.0 / (4.0 * 3.14159265358979) * 0.199 / 1.199, 0.01,
                    0.0);
}

static void dense_media_scatter_at_their_surface(void **state)
{
    (void)state;
    scatters_at_its_surface("1.5", 2);
    scatters_at_its_surface("5", 2);
    scatters_at_its_surface("20", 2);
}

static void case_13_a_camera_inside_a_fog_sees_all_of_it(void **state)
{
    (void)state;
    double seen = mean_of(lf_test_scene_text("inside-large-fog"), 64, NULL);
    lf_assert_close(seen, exp(-2.5), 2e-3, 0.0);
}

/* Shapes know their rays' intervals: what holds at twenty mean free paths holds at ten thousand, at
 * any angle of the sun. */
static void case_08_shapes_have_no_resolution(void **state)
{
    (void)state;
    scatters_at_its_surface("400", 1);
    scatters_at_its_surface("5000", 1);
}

/* Interval of a ray of the row's plane inside a turned, stretched shape, against points tested one
 * by one. */
static void a_ray_knows_its_interval_inside_a_shape(void **state)
{
    (void)state;
    static const char *const shapes[] = {"sphere", "box"};
    for (int i = 0; i < 2; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "{ " NARROW ", 'volumes': { 'v': { 'shape': '%s', 'density': 3, 'transform': { "
                 "'scale': [1, 0.5, 0.7], 'rotate': [20, "
                 "30, 40], 'translate': [0.1, 0.05, 0] } } } }",
                 shapes[i]);
        lf_scene *scene = lf_test_scene(text);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
        const float lens[2] = {0.5f, 0.5f};
        lf_row_plane plane;
        lf_body body;
        lf_rig_row_plane(&lf_test_rows(r)->rig, 4.3f, lens, &plane);
        assert_true(lf_body_cut(&body, &scene->volumes[0], &lf_test_rows(r)->rig, &plane));
        for (int j = 0; j < 40; j++) {
            float x0 = 0.1f * (float)(j % 7) - 0.3f, slope = (0.05f * (float)(j - 20) - x0) / 5.0f,
                  step = 1e-3f;
            double inside = 0.0;
            for (float z = 2.0f; z < 8.0f; z += step) {
                lf_vec3 p =
                    lf_rig_point(&lf_test_rows(r)->rig, x0 + slope * z, plane.ly + plane.my * z, z);
                inside += lf_volume_sigma_t(&scene->volumes[0], p) > 0.0f ? (double)step : 0.0;
            }
            lf_assert_close((double)lf_body_depth(&body, x0, slope, INFINITY), 3.0 * inside, 0.0,
                            0.01);
            float half = lf_body_depth(&body, x0, slope, 5.0f), from, to;
            lf_body_interval(&body, x0, slope, &from, &to);
            lf_assert_close((double)half, 3.0 * (double)lf_max(lf_min(to, 5.0f) - from, 0.0f), 1e-6,
                            1e-6);
        }
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

static void volumes_out_of_sight_change_nothing(void **state)
{
    (void)state;
    static const char ball[] =
        "'ball': { 'shape': 'sphere', 'density': 2, 'albedo': 0, 'transform': { 'scale': 0.1 } }";
    static const char *const other[] = {
        ", 'behind': { 'shape': 'sphere', 'density': 1, 'albedo': 0, 'transform': { 'scale': 30, "
        "'translate': [0, 0, 60] } }",
        ", 'beside': { 'shape': 'sphere', 'density': 1, 'albedo': 0, 'transform': { 'scale': 3, "
        "'translate': [900, 0, 0] } }"};
    char text[1024];
    snprintf(text, sizeof text,
             "{ " NARROW
             ", 'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }, 'volumes': { %s } }",
             ball);
    double alone = mean_of(text, 4, NULL);
    assert_true(alone < 0.98);
    for (int i = 0; i < 2; i++) {
        snprintf(text, sizeof text,
                 "{ " NARROW ", 'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }, "
                 "'volumes': { %s%s } }",
                 ball, other[i]);
        lf_assert_close(mean_of(text, 4, NULL), alone, 1e-6, 0.0);
    }
}

static void case_12_a_big_plane_does_not_hide_itself(void **state)
{
    (void)state;
    lf_render_stats stats;
    (void)mean_of(lf_test_scene_text("big-plane"), 20, &stats);
    assert_true(stats.base_paths > 10000);
    assert_true((double)stats.base_hidden < 1e-4 * (double)stats.base_paths);
}

/* Of a volume that is wider than all that is seen a frame has what lies between the outermost rays,
 * at the far end of its depths: of views that share a window, and of views on a track. */
static void a_frame_is_as_wide_as_what_the_views_see(void **state)
{
    (void)state;
    static const char *const views[] = {
        "'cone': 0, 'views': 1", "'views': { 'track': { 'count': 3, 'length': 8 } }",
        "'views': { 'track': { 'count': 3, 'length': 8, 'window': 'shared' } }"};
    char vdb[PATH_MAX], text[PATH_MAX + 512];
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), vdb));
    for (int i = 0; i < 3; i++) {
        snprintf(text, sizeof text,
                 "{ 'camera': { 'position': [0, 0, 5], 'fov_y': 20, 'aspect': 1, %s }, 'volumes': "
                 "{ 'v': { 'file': '%s', 'transform': { 'scale': [8, 1, 0.1], 'translate': [-60, "
                 "0, 2] } } } }",
                 views[i], vdb);
        lf_scene *scene = lf_test_scene(text);
        const lf_render_settings settings = {
            .camera = *lf_scene_camera(scene), .width = SIDE, .height = SIDE};
        lf_slice_frame frame;
        lf_rig rig;
        lf_assert_ok(lf_rig_init(&rig, &settings, scene->origin, NULL), NULL);
        assert_true(lf_slice_frame_init(&frame, &scene->volumes[0], &rig, 1));
        const double near = (double)frame.z_min, far = near + (frame.nz - 2) * (double)frame.dz,
                     half = tan(M_PI / 18);
        /* the left edge of an outer camera's view, towards the window's or straight ahead */
        double left = HUGE_VAL;
        for (int k = 0; k < 4; k++) {
            const double b = i == 0 ? 0 : k < 2 ? -4 : 4, z = k % 2 ? near : far;
            left = fmin(left, b + z * (-half - (i == 2 ? b / 5 : 0)));
        }
        const double cell = (double)frame.dx;
        lf_assert_close((double)frame.x_min, left, 0, 3 * cell);
        assert_true((double)frame.x_min <= left + cell && left < -0.5);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dense_media_scatter_at_their_surface),
        cmocka_unit_test(case_08_shapes_have_no_resolution),
        cmocka_unit_test(a_ray_knows_its_interval_inside_a_shape),
        cmocka_unit_test(case_13_a_camera_inside_a_fog_sees_all_of_it),
        cmocka_unit_test(volumes_out_of_sight_change_nothing),
        cmocka_unit_test(a_frame_is_as_wide_as_what_the_views_see),
        cmocka_unit_test(case_12_a_big_plane_does_not_hide_itself),
    };
    return cmocka_run_group_tests_name("slice", tests, NULL, lf_test_finish);
}
