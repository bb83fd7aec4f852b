/* Where points land in the views: what the rig's geometry says, to a fraction of a pixel. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/plane/rig.h"
#include "render/render.h"
#include "tests/scene_file.h"

enum { VIEWS = 9, WIDTH = 120, HEIGHT = 40 };

/* By the scene's own arc of cameras, or on a track, which is the upper row of a grid 2 rise high.
 */
static float *render(lf_render_settings *settings, double track, double rise, bool own_windows)
{
    lf_error err;
    lf_scene *scene = NULL;
    lf_pool *pool = NULL;
    lf_renderer *renderer = NULL;
    json_t *doc = lf_test_scene_document("three-emissive-balls");
    float *out = lf_calloc((size_t)VIEWS * WIDTH * HEIGHT * 3, sizeof *out);
    assert_non_null(doc);
    assert_non_null(out);
    lf_assert_ok(lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, &err), &err);
    *settings = (lf_render_settings){
        .camera = *lf_scene_camera(scene), .width = WIDTH, .height = HEIGHT, .seed = 5};
    settings->camera.track = track;
    settings->camera.own_windows = own_windows;
    settings->camera.n_rows = 3;
    settings->camera.rows_height = 2.0 * rise;
    settings->camera = lf_camera_row(&settings->camera, 2);
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    lf_assert_ok(lf_renderer_create(scene, settings, pool, &renderer, &err), &err);
    lf_assert_ok(lf_renderer_passes(renderer, NULL, 64 * VIEWS, false, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_resolve(renderer, LF_ESTIMATOR_MIS, out, NULL), NULL);
    lf_renderer_destroy(renderer);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
    json_decref(doc);
    return out;
}

/* Mean film column and row of a colour in a view. */
static void centre(const float *picture, int view, int channel, double out[2])
{
    double sum = 0.0, along = 0.0, down = 0.0;
    for (int row = 0; row < HEIGHT; row++) {
        for (int column = 0; column < WIDTH; column++) {
            double v = (double)
                picture[(((size_t)row * VIEWS + (size_t)view) * WIDTH + (size_t)column) * 3 +
                        (size_t)channel];
            sum += v;
            along += v * (column + 0.5);
            down += v * (row + 0.5);
        }
    }
    assert_true(sum > 1.0);
    out[0] = along / sum;
    out[1] = down / sum;
}

/* Where an axis of the window, as wide and of as many pixels, has a point: x to the side of the
 * middle of the rig and z before the window, from a camera b to the side. Windows that go along
 * have their middle before the camera. */
static double landing(const lf_camera *camera, double b, double x, double z, double size,
                      int pixels)
{
    const double distance = 6.0, on_window = b + (x - b) * distance / (distance - z),
                 window = camera->track > 0.0 && camera->own_windows ? b : 0.0;
    return ((on_window - window) / size + 0.5) * pixels;
}

/* The rig's own words: the window is D wide of the line of cameras, view k sits at D tan(a_k), or
 * at its place on a track (scene-format.md, camera). */
static double place_of(const lf_camera *camera, int view)
{
    if (camera->track > 0.0)
        return (view / (VIEWS - 1.0) - 0.5) * camera->track;
    return 6.0 * tan(((view + 0.5) / VIEWS - 0.5) * camera->cone);
}

static void points_land_where_the_rig_says(void **state)
{
    (void)state;
    static const double y[3] = {0.0, 0.3, -0.3}, z[3] = {0.0, 1.0, -1.5};
    static const struct {
        double track, rise;
        bool own;
    } ways[] = {{0, 0, false},   {2, 0, false},    {2, 0, true},
                {2, 0.4, false}, {2, -0.6, false}, {2, 0.2, true}};
    for (size_t way = 0; way < sizeof ways / sizeof ways[0]; way++) {
        lf_render_settings settings;
        const lf_camera *camera = &settings.camera;
        float *picture = render(&settings, ways[way].track, ways[way].rise, ways[way].own);
        const double height = 12.0 * tan(0.5 * camera->fov_y);
        for (int view = 0; view < VIEWS; view++) {
            for (int channel = 0; channel < 3; channel++) {
                double at[2];
                centre(picture, view, channel, at);
                lf_assert_close(at[0],
                                landing(camera, place_of(camera, view), 0.2, z[channel],
                                        height * camera->aspect, WIDTH),
                                0.0, 0.15);
                lf_assert_close(at[1],
                                HEIGHT - landing(camera, ways[way].rise, y[channel], z[channel],
                                                 height, HEIGHT),
                                0.0, 0.15);
            }
        }
        lf_free(picture);
    }
}

/* A window that all rows share, and the backdrop in it, are where they are. */
static void a_backdrop_stays_in_its_window(void **state)
{
    (void)state;
    lf_render_settings settings = {.camera = {.position = {0, 0, 6},
                                              .up = {0, 1, 0},
                                              .fov_y = 0.3,
                                              .aspect = 1,
                                              .track = 2,
                                              .n_views = VIEWS,
                                              .n_rows = 3,
                                              .rows_height = 1.5},
                                   .width = WIDTH,
                                   .height = HEIGHT};
    const lf_camera grid = settings.camera;
    for (int row = 0; row < 3; row++) {
        lf_rig rig;
        lf_row_plane plane;
        settings.camera = lf_camera_row(&grid, row);
        lf_assert_ok(lf_rig_init(&rig, &settings, (double[3]){0}, NULL), NULL);
        for (int y = 0; y < HEIGHT; y++) {
            lf_rig_row_plane(&rig, (float)y + 0.5f, (float[2]){0.5f, 0.5f}, &plane);
            lf_assert_close((double)lf_rig_height_between(&rig, plane.my), (y + 0.5) / HEIGHT, 0.0,
                            1e-6);
        }
    }
}

static void depth_moves_points_against_each_other(void **state)
{
    (void)state;
    lf_render_settings settings;
    float *picture = render(&settings, 0.0, 0.0, false);
    double moved[3];
    for (int channel = 0; channel < 3; channel++) {
        double first[2], last[2];
        centre(picture, 0, channel, first);
        centre(picture, VIEWS - 1, channel, last);
        moved[channel] = last[0] - first[0];
    }
    lf_assert_close(moved[0], 0.0, 0.0, 0.1);
    assert_true(moved[1] < -5.0);
    assert_true(moved[2] > 5.0);
    lf_free(picture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_land_where_the_rig_says),
        cmocka_unit_test(a_backdrop_stays_in_its_window),
        cmocka_unit_test(depth_moves_points_against_each_other),
    };
    return cmocka_run_group_tests_name("parallax", tests, NULL, NULL);
}
