/* Cameras listed one by one, as scene files have them: lists, circles and paths, in closed form. */
#include "tests/testing.h"

#include "tests/stat/fixture.h"

/* What an entry does not say is the camera's own, and what asks for one camera has the middle one.
 */
static void a_list_is_what_it_says(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{'camera': {'target': [0, 1, 0], 'up': [0, 0, 1], 'fov_y': 30, 'views': {'list': "
        "[{'position': [3, 0, 0]}, {'position': [0, 4, 1], 'target': [0, 0, 1]}, {'position': "
        "[5, 5, 5], 'up': [0, 1, 0], 'fov_y': 60}]}}}");
    const lf_camera *c = lf_scene_camera(scene);
    const lf_view_camera *list = c->list;
    assert_true(c->n_views == 3 && lf_camera_views(c) == 3 && c->has_views);
    assert_true(list[0].position[0] == 3 && list[0].target[1] == 1 && list[0].up[2] == 1);
    assert_true(list[1].target[1] == 0 && list[1].target[2] == 1 && list[1].fov_y == M_PI / 6);
    assert_true(list[2].up[1] == 1 && list[2].up[2] == 0);
    lf_assert_close(list[2].fov_y, M_PI / 3, 1e-12, 0);
    assert_true(c->position[1] == 4 && c->target[2] == 1);
    lf_scene_unref(scene);
}

static void a_circle_goes_round_its_target(void **state)
{
    (void)state;
    static const double angles[] = {360, 90};
    for (int i = 0; i < 2; i++) {
        char text[256];
        snprintf(
            text, sizeof text,
            "{'camera': {'position': [3, 2, 1], 'target': [1, 1, 1], 'up': [0, 2, 0], 'views': "
            "{'circle': {'count': 9, 'angle': %g}}}}",
            angles[i]);
        lf_scene *scene = lf_test_scene(text);
        const lf_camera *c = lf_scene_camera(scene);
        const double step = (i == 0 ? angles[i] / 9 : angles[i] / 8) * M_PI / 180;
        assert_int_equal(c->n_views, 9);
        for (int k = 0; k < 9; k++) {
            /* to the right as the camera sees it: from x towards -z */
            const double a = (k - 4) * step, *p = c->list[k].position;
            lf_assert_close(p[0], 1 + 2 * cos(a), 0, 1e-12);
            lf_assert_close(p[1], 2, 0, 1e-12);
            lf_assert_close(p[2], 1 - 2 * sin(a), 0, 1e-12);
            assert_true(c->list[k].target[0] == 1 && c->list[k].fov_y == c->fov_y);
        }
        lf_scene_unref(scene);
    }
}

/* Through every camera that it is told; straight where these stand evenly on a line; and a closed
 * one comes back. */
static void a_path_goes_through_its_cameras(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{'camera': {'views': {'path': {'count': 7, 'through': [{'position': [0, 0, 5]}, "
        "{'position': [1, 2, 5]}, {'position': [2, 4, 5]}, {'position': [3, 6, 5]}]}}}}");
    const lf_camera *c = lf_scene_camera(scene);
    for (int k = 0; k < 7; k++) {
        lf_assert_close(c->list[k].position[0], 0.5 * k, 0, 1e-12);
        lf_assert_close(c->list[k].position[1], k, 0, 1e-12);
    }
    lf_scene_unref(scene);
    scene =
        lf_test_scene("{'camera': {'target': [0, 0, 0], 'views': {'path': {'count': 8, 'closed': "
                      "true, 'through': [{'position': [3, 0, 0]}, {'position': [0, 0, -3]}, "
                      "{'position': [-3, 0, 0]}, {'position': [0, 0, 3]}]}}}}");
    c = lf_scene_camera(scene);
    for (int k = 0; k < 8; k++) {
        const double *p = c->list[k].position, half = k % 2 ? 3 * 0.625 : 3 * (k % 4 == 0);
        lf_assert_close(fabs(p[0]), half, 0, 1e-12);
        lf_assert_close(fabs(p[2]), k % 2 ? half : 3 - half, 0, 1e-12);
    }
    lf_scene_unref(scene);
}

static void wrong_lists_are_refused_where_they_are_wrong(void **state)
{
    (void)state;
    static const char *const bad[][3] = {
        {"'views': {'list': []}", "/camera/views/list", "array of 1 to 256"},
        {"'views': {'list': 3}", "/camera/views/list", "array of 1 to 256"},
        {"'views': {'list': [{'target': [0, 0, 1]}]}", "/camera/views/list/0", "position"},
        {"'views': {'list': [{'position': [0, 0, 1], 'cone': 3}]}", "/camera/views/list/0/cone",
         "unknown key"},
        {"'views': {'list': [{'position': [0, 0, 1]}, {'position': [0, 0, 0]}]}",
         "/camera/views/list/1/position", "is at its target"},
        {"'views': {'list': [{'position': [0, 3, 0]}]}", "/camera/views/list/0/up",
         "view direction"},
        {"'views': {'list': [{'position': [0, 0, 1], 'fov_y': 170}]}", "/camera/views/list/0/fov_y",
         "160"},
        {"'views': {'path': {'through': [{'position': [0, 0, 1]}]}}", "/camera/views/path/through",
         "array of 2 to 256"},
        {"'views': {'path': {'count': 3, 'through': [{'position': [0, 0, 1]}, {'position': [0, 0, "
         "-1]}]}}",
         "/camera/views/path", "at view 1"},
        {"'views': {'circle': {'count': 300}}", "/camera/views/circle/count", "256"},
        {"'views': {'circle': {}, 'list': []}", "/camera/views", "or {\"circle\""},
        {"'view_blur': 1, 'views': {'circle': {}}", "/camera/view_blur", "cannot have view_blur"},
        {"'depthiness': 0.5, 'views': {'circle': {}}", "/camera/depthiness",
         "cannot have depthiness"},
        {"'position': [0, 0, 0], 'views': {'circle': {}}", "/camera/position", "is at its target"},
        {"'from': {'mesh': 'm'}, 'views': {'circle': {}}", "/camera/from", "one by one"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char text[512];
        snprintf(text, sizeof text, "{'camera': {%s}}", bad[i][0]);
        lf_test_assert_refused(".", text, bad[i][1], bad[i][2]);
    }
}

/* What listed cameras cannot do is said in a line. */
static void what_is_not_rendered_is_refused_by_name(void **state)
{
    (void)state;
    static const struct {
        const char *scene, *integrator, *words;
    } bad[] = {
        {"'materials': {'m': {'type': 'conductor', 'roughness': 0}}, 'meshes': {'b': {'shape': "
         "'sphere', 'material': 'm'}}",
         NULL, "mirrors"},
        {"'materials': {'m': {'type': 'principled', 'transmission': 1, 'roughness': 0.4}}, "
         "'meshes': {'b': {'shape': 'sphere', 'material': 'm'}}",
         NULL, "glass"},
        {"'volumes': {'v': {'shape': 'box', 'density': 1, 'sigma_t': [0.2, 0.5, 1]}}", NULL,
         "chromatic extinction"},
        {"'volumes': {'v': {'shape': 'box', 'density': 1, 'emission': 1}}", NULL, "emit"},
        {"'volumes': {}", "amvpt", "listed one by one; the scene has some; use one of mvpt, vpt"},
        {"'volumes': {}", "mvpt2022", "of mvpt, vpt"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char text[512];
        lf_error err;
        lf_renderer *r = NULL;
        lf_pool *pool = NULL;
        snprintf(text, sizeof text, "{'camera': {'views': {'circle': {'count': 3}}}, %s}",
                 bad[i].scene);
        lf_scene *scene = lf_test_scene(text);
        lf_render_settings settings = {.camera = *lf_scene_camera(scene),
                                       .width = 8,
                                       .height = 8,
                                       .integrator = bad[i].integrator};
        lf_assert_ok(lf_pool_create(1, &pool), NULL);
        lf_assert_status(lf_renderer_create(scene, &settings, pool, &r, &err), LF_E_ARG, &err);
        if (!strstr(err.what, bad[i].words))
            fail_msg("\"%s\" does not say \"%s\"", err.what, bad[i].words);
        lf_pool_destroy(pool);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_list_is_what_it_says),
        cmocka_unit_test(a_circle_goes_round_its_target),
        cmocka_unit_test(a_path_goes_through_its_cameras),
        cmocka_unit_test(wrong_lists_are_refused_where_they_are_wrong),
        cmocka_unit_test(what_is_not_rendered_is_refused_by_name),
    };
    return cmocka_run_group_tests_name("camera_list", tests, NULL, lf_test_finish);
}
