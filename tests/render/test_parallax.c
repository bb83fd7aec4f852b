/* Where points land in the views: what the rig's geometry says, to a fraction of a pixel. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/render.h"

enum { VIEWS = 9, WIDTH = 120, HEIGHT = 40 };

/* Three glowing balls: red on the window plane, green in front of it, blue behind, one above the
 * other. */
static const char SCENE[] = "{\"quiltd\":1,"
                            "\"camera\":{\"target\":[0.1,0,0],\"position\":[0.1,0,6],\"fov_y\":14,"
                            "\"aspect\":3,\"views\":9,\"cone\":30},"
                            "\"meshes\":{"
                            "\"on\":{\"shape\":\"sphere\",\"material\":\"red\",\"transform\":{"
                            "\"scale\":0.08,\"translate\":[0.3,0,0]}},"
                            "\"front\":{\"shape\":\"sphere\",\"material\":\"green\",\"transform\":{"
                            "\"scale\":0.08,\"translate\":[0.3,0.3,1]}},"
                            "\"behind\":{\"shape\":\"sphere\",\"material\":\"blue\",\"transform\":{"
                            "\"scale\":0.08,\"translate\":[0.3,-0.3,-1.5]}}},"
                            "\"materials\":{"
                            "\"red\":{\"type\":\"diffuse\",\"albedo\":0,\"emission\":[1,0,0]},"
                            "\"green\":{\"type\":\"diffuse\",\"albedo\":0,\"emission\":[0,1,0]},"
                            "\"blue\":{\"type\":\"diffuse\",\"albedo\":0,\"emission\":[0,0,1]}}}";

/* By the scene's own arc of cameras, or on a track. */
static float *render(lf_render_settings *settings, double track, bool own_windows)
{
    lf_error err;
    lf_scene *scene = NULL;
    lf_pool *pool = NULL;
    lf_renderer *renderer = NULL;
    json_t *doc = json_loads(SCENE, 0, NULL);
    float *out = lf_calloc((size_t)VIEWS * WIDTH * HEIGHT * 3, sizeof *out);
    assert_non_null(doc);
    assert_non_null(out);
    lf_assert_ok(lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, &err), &err);
    *settings = (lf_render_settings){
        .camera = *lf_scene_camera(scene), .width = WIDTH, .height = HEIGHT, .seed = 5};
    settings->camera.track = track;
    settings->camera.own_windows = own_windows;
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

/* Mean film column of a colour in a view. */
static double centre(const float *picture, int view, int channel)
{
    double sum = 0.0, weighted = 0.0;
    for (int row = 0; row < HEIGHT; row++) {
        for (int column = 0; column < WIDTH; column++) {
            double v = (double)
                picture[(((size_t)row * VIEWS + (size_t)view) * WIDTH + (size_t)column) * 3 +
                        (size_t)channel];
            sum += v;
            weighted += v * (column + 0.5);
        }
    }
    assert_true(sum > 1.0);
    return weighted / sum;
}

/* The rig's own words: the window is D wide of the line of cameras, view k sits at D tan(a_k), or
 * at its place on a track, where windows may go along with the cameras (scene.md, camera). */
static double predicted(const lf_camera *camera, int view, double x, double z)
{
    double distance = 6.0, height = 2.0 * distance * tan(0.5 * camera->fov_y),
           width = height * camera->aspect;
    double b = distance * tan(((view + 0.5) / VIEWS - 0.5) * camera->cone);
    if (camera->track > 0.0)
        b = (view / (VIEWS - 1.0) - 0.5) * camera->track;
    double on_window = b + (x - b) * distance / (distance - z);
    if (camera->track > 0.0 && camera->own_windows)
        on_window -= b;
    return (on_window / width + 0.5) * WIDTH;
}

static void points_land_where_the_rig_says(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 1.0, -1.5};
    for (int way = 0; way < 3; way++) {
        lf_render_settings settings;
        float *picture = render(&settings, way > 0 ? 2.0 : 0.0, way == 2);
        for (int view = 0; view < VIEWS; view++) {
            for (int channel = 0; channel < 3; channel++)
                lf_assert_close(centre(picture, view, channel),
                                predicted(&settings.camera, view, 0.2, z[channel]), 0.0, 0.15);
        }
        lf_free(picture);
    }
}

static void depth_moves_points_against_each_other(void **state)
{
    (void)state;
    lf_render_settings settings;
    float *picture = render(&settings, 0.0, false);
    double moved[3];
    for (int channel = 0; channel < 3; channel++)
        moved[channel] = centre(picture, VIEWS - 1, channel) - centre(picture, 0, channel);
    lf_assert_close(moved[0], 0.0, 0.0, 0.1);
    assert_true(moved[1] < -5.0);
    assert_true(moved[2] > 5.0);
    lf_free(picture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_land_where_the_rig_says),
        cmocka_unit_test(depth_moves_points_against_each_other),
    };
    return cmocka_run_group_tests_name("parallax", tests, NULL, NULL);
}
