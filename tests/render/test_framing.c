/* How a scene lies in the window: its box, its depth, and where the camera must stand, against
 * projections made here (docs/reference/scene-format.md, "camera": off-axis cameras on a line, at D
 * tan(a_i)). */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

static lf_render_settings settings_of(const lf_scene *scene, int width, int height)
{
    return (lf_render_settings){
        .camera = *lf_scene_camera(scene), .width = width, .height = height, .skip = LF_SKIP_ALL};
}

static void assert_bounds(const lf_scene *scene, const char *name, const double lo[3],
                          const double hi[3])
{
    double is[2][3];
    assert_true(lf_scene_bounds(scene, name, is));
    for (int i = 0; i < 3; i++) {
        lf_assert_close(is[0][i], lo[i], 0, 1e-5);
        lf_assert_close(is[1][i], hi[i], 0, 1e-5);
    }
}

static void bounds_are_those_of_what_is_there(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("three-things")),
             *none = lf_test_scene("{}");
    double is[2][3];
    assert_bounds(scene, "ball", (double[]){1.5, -.5, -.5}, (double[]){2.5, .5, .5});
    assert_bounds(scene, "cube", (double[]){-1, .5, -1.25}, (double[]){1, 1.5, -.75});
    assert_bounds(scene, "quad", (double[]){-2, -1, 1}, (double[]){2, -1, 5});
    assert_bounds(scene, NULL, (double[]){-2, -1, -1.25}, (double[]){2.5, 1.5, 5});
    assert_false(lf_scene_bounds(scene, "air", is));
    assert_false(lf_scene_bounds(scene, "sun", is));
    assert_false(lf_scene_bounds(none, NULL, is));
    lf_scene_unref(none);
    lf_scene_unref(scene);
}

static void bounds_far_away_lose_nothing(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        "{'meshes': {'a': {'shape': 'cube', 'transform': {'translate': [1000000, 7, 0]}}}}");
    assert_bounds(scene, NULL, (double[]){999999, 6, -1}, (double[]){1000001, 8, 1});
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------- projections -- */

/* The frame of a camera, by Gram and Schmidt. */
static void frame_of(const lf_camera *c, double right[3], double up[3], double forward[3],
                     double *out_distance)
{
    double d = 0, along = 0, n = 0;
    for (int i = 0; i < 3; i++)
        d += pow(c->target[i] - c->position[i], 2);
    d = sqrt(d);
    for (int i = 0; i < 3; i++)
        forward[i] = (c->target[i] - c->position[i]) / d;
    for (int i = 0; i < 3; i++)
        along += forward[i] * c->up[i];
    for (int i = 0; i < 3; i++)
        up[i] = c->up[i] - along * forward[i], n += up[i] * up[i];
    for (int i = 0; i < 3; i++)
        up[i] /= sqrt(n);
    for (int i = 0; i < 3; i++)
        right[i] = forward[(i + 1) % 3] * up[(i + 2) % 3] - forward[(i + 2) % 3] * up[(i + 1) % 3];
    *out_distance = d;
}

/* Where view k sees a point: -1..1 across and up the window; returns its depth. */
static double project(const lf_camera *c, int k, const double p[3], double out[2])
{
    double right[3], up[3], forward[3], distance, x = 0, y = 0, z = 0;
    frame_of(c, right, up, forward, &distance);
    for (int i = 0; i < 3; i++) {
        x += right[i] * (p[i] - c->position[i]);
        y += up[i] * (p[i] - c->position[i]);
        z += forward[i] * (p[i] - c->position[i]);
    }
    int n = c->n_views;
    double a = c->inclusive ? (double)k / (n - 1) - 0.5 : (k + 0.5) / n - 0.5,
           b = distance * tan(a * c->cone), half = distance * tan(c->fov_y / 2);
    out[0] = (b + (x - b) * distance / z) / (half * c->aspect);
    out[1] = y * distance / z / half;
    return z;
}

/* Pixels from view to view, on average over the rig, of a point. */
static double step_of(const lf_camera *c, int width, const double p[3])
{
    double first[2], last[2];
    (void)project(c, 0, p, first);
    (void)project(c, c->n_views - 1, p, last);
    return (last[0] - first[0]) / (c->n_views - 1) * width / 2;
}

/* ------------------------------------------------------------------------------------- depth -- */

static void assert_depth(const char *text, int width, const double nearest[3],
                         const double farthest[3])
{
    lf_scene *scene = lf_test_scene(text);
    lf_render_settings settings = settings_of(scene, width, width);
    lf_depth depth;
    double at[2];
    assert_true(lf_scene_depth(scene, &settings, &depth));
    lf_assert_close(depth.nearest, project(&settings.camera, 0, nearest, at), 1e-5, 0);
    lf_assert_close(depth.farthest, project(&settings.camera, 0, farthest, at), 1e-5, 0);
    lf_assert_close(depth.nearest_step, step_of(&settings.camera, width, nearest), 1e-4, 1e-5);
    lf_assert_close(depth.farthest_step, step_of(&settings.camera, width, farthest), 1e-4, 1e-5);
    lf_scene_unref(scene);
}

#define CAMERA "'camera': {'position': [0, 0, 10], 'fov_y': 20, 'aspect': 1, 'cone': 30, 'views': 9"

static void a_step_is_what_a_point_moves_by_from_view_to_view(void **state)
{
    (void)state;
    assert_depth("{" CAMERA "}, 'meshes': {'a': {'shape': 'cube'}}}", 300, (double[]){0.3, 0.1, 1},
                 (double[]){0, 0, -1});
    assert_depth("{" CAMERA ", 'placement': 'inclusive'}, 'volumes': {'a': {'shape': 'sphere', "
                 "'transform': {'scale': 0.5, 'translate': [0.2, 0, -4]}}, 'b': {'shape': 'box', "
                 "'transform': {'scale': 0.1, 'translate': [0, 1, 4]}}}}",
                 120, (double[]){0, 1, 4.1}, (double[]){0, 0, -4.5});
}

/* On the planes where the sharp depth ends, steps are the limit. */
static void the_sharp_depth_ends_where_steps_reach_the_limit(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{" CAMERA "}, 'meshes': {'a': {'shape': 'cube'}}}");
    for (int width = 60; width <= 960; width *= 4) {
        lf_render_settings settings = settings_of(scene, width, width);
        lf_depth depth;
        assert_true(lf_scene_depth(scene, &settings, &depth));
        const double near[3] = {0.1, 0.2, 10 - depth.sharp_from},
                     far[3] = {0.1, 0.2, 10 - depth.sharp_to};
        lf_assert_close(step_of(&settings.camera, width, near), -depth.limit, 1e-5, 0);
        lf_assert_close(step_of(&settings.camera, width, far), depth.limit, 1e-5, 0);
    }
    /* A narrow cone: all that is behind the window is sharp. */
    lf_render_settings settings = settings_of(scene, 300, 300);
    settings.camera.cone *= 0.05;
    lf_depth depth;
    assert_true(lf_scene_depth(scene, &settings, &depth));
    assert_true(isinf(depth.sharp_to) && depth.sharp_from > 0 && depth.sharp_from < 10);
    lf_scene_unref(scene);
}

/* A ground under a camera that looks along it: as near as the lower edge of the picture, as far as
 * it goes. What lies beside the picture does not count. */
static void only_what_is_in_the_picture_counts(void **state)
{
    (void)state;
    double near = 10 - 1 / tan(10 * M_PI / 180);
    assert_depth(
        "{" CAMERA "}, 'meshes': {'ground': {'shape': 'quad', 'transform': {'scale': 50, "
        "'translate': [0, -1, 0]}}, 'beside': {'shape': 'cube', 'transform': {'translate': "
        "[3, 0, 6]}}, 'behind': {'shape': 'cube', 'transform': {'translate': [0, 0, 14]}}}}",
        200, (double[]){0, -1, near}, (double[]){0, -1, -50});
}

static void what_begins_at_the_cameras_has_no_least_step(void **state)
{
    (void)state;
    lf_scene *scene =
                 lf_test_scene("{" CAMERA "}, 'volumes': {'air': {'shape': 'box', 'transform': "
                               "{'scale': 30}}}}"),
             *beside = lf_test_scene("{" CAMERA "}, 'meshes': {'a': {'shape': 'cube', 'transform': "
                                     "{'translate': [9, 0, 0]}}}}"),
             *one = lf_test_scene("{'camera': {'views': 1}, 'meshes': {'a': {'shape': 'cube'}}}");
    lf_render_settings settings = settings_of(scene, 100, 100), of_one = settings_of(one, 100, 100);
    lf_depth depth;
    assert_true(lf_scene_depth(scene, &settings, &depth));
    assert_true(depth.nearest_step < -1e6);
    assert_true(depth.farthest_step > 0);
    assert_false(lf_scene_depth(beside, &settings, &depth));
    assert_false(lf_scene_depth(one, &of_one, &depth));
    lf_scene_unref(scene);
    lf_scene_unref(beside);
    lf_scene_unref(one);
}

/* --------------------------------------------------------------------------------------- fit -- */

/* How far the corners of a box reach in the views: of the window's half, across and up. */
static void reach_of(const lf_camera *c, double bounds[2][3], double out[2])
{
    out[0] = out[1] = 0;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < c->n_views; k++) {
            const double p[3] = {bounds[i & 1][0], bounds[i >> 1 & 1][1], bounds[i >> 2][2]};
            double at[2];
            assert_true(project(c, k, p, at) > 0);
            out[0] = fmax(out[0], fabs(at[0]));
            out[1] = fmax(out[1], fabs(at[1]));
        }
}

static double largest_step(const lf_camera *c, int width, double bounds[2][3])
{
    double largest = 0;
    for (int i = 0; i < 8; i++) {
        const double p[3] = {bounds[i & 1][0], bounds[i >> 1 & 1][1], bounds[i >> 2][2]};
        largest = fmax(largest, fabs(step_of(c, width, p)));
    }
    return largest;
}

/* Every corner in every view is within the share, and one of them is at it; the side that is looked
 * at stays. */
static void assert_fits(const char *text, const char *name, double fill, double steps)
{
    enum { width = 90 };
    lf_scene *scene = lf_test_scene(text);
    lf_render_settings settings = settings_of(scene, width, 120);
    lf_camera fitted = settings.camera;
    lf_error err;
    double bounds[2][3], reach[2], frame[2][3][3], distance[2];
    assert_true(lf_scene_bounds(scene, name, bounds));
    lf_assert_ok(
        lf_camera_fit(scene, &settings, name, fill, steps, fitted.target, fitted.position, &err),
        &err);
    reach_of(&fitted, bounds, reach);
    double full = fmax(reach[0], reach[1]) / fill,
           deep = steps > 0 ? largest_step(&fitted, width, bounds) / steps : 0;
    assert_true(full < 1.0001 && deep < 1.0001 && (full > 0.9999 || deep > 0.9999));
    frame_of(&settings.camera, frame[0][0], frame[0][1], frame[0][2], &distance[0]);
    frame_of(&fitted, frame[1][0], frame[1][1], frame[1][2], &distance[1]);
    for (int i = 0; i < 3; i++) {
        lf_assert_close(fitted.target[i], (bounds[0][i] + bounds[1][i]) / 2, 0, 1e-6);
        lf_assert_close(frame[0][2][i], frame[1][2][i], 0, 1e-6);
        /* negative control: a hundredth nearer */
        fitted.position[i] += (fitted.target[i] - fitted.position[i]) / 100;
    }
    reach_of(&fitted, bounds, reach);
    assert_true(fmax(reach[0], reach[1]) > 1.005 * fill ||
                (steps > 0 && largest_step(&fitted, width, bounds) > 1.001 * steps));
    lf_scene_unref(scene);
}

#define LOOK(camera) lf_test_scene_patched("three-things", "{'camera': {" camera "}}")

static void what_is_framed_fills_its_share_of_all_views(void **state)
{
    (void)state;
    assert_fits(LOOK("'position': [0, 0, 5]"), NULL, 0.9, 0);
    assert_fits(LOOK("'position': [3, 4, 5], 'up': [0.2, 1, 0.1], 'fov_y': 30"), NULL, 1, 0);
    assert_fits(LOOK("'position': [-8, 1, 2], 'aspect': 2, 'placement': 'inclusive'"), "cube", 0.5,
                0);
    assert_fits(LOOK("'position': [0, 9, 1], 'cone': 70, 'views': 5"), "ball", 0.8, 0);
    assert_fits(LOOK("'position': [0, 0, 5], 'views': 1"), "quad", 0.8, 0);
}

/* How far the corners of a box reach in the window of all cameras of a grid: of its half. */
static double reach_of_grid(const lf_camera *c, double bounds[2][3])
{
    double right[3], up[3], forward[3], distance, reach = 0;
    const int rows = c->n_rows > 0 ? c->n_rows : 1, cameras = c->n_views * rows;
    frame_of(c, right, up, forward, &distance);
    const double half = distance * tan(c->fov_y / 2);
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < cameras; k++) {
            double x = 0, y = 0, z = 0;
            for (int a = 0; a < 3; a++) {
                const double p = bounds[i >> a & 1][a] - c->position[a];
                x += right[a] * p;
                y += up[a] * p;
                z += forward[a] * p;
            }
            const double across = ((double)(k % c->n_views) / (c->n_views - 1) - 0.5) * c->track,
                         above = rows > 1 ? ((double)(k / c->n_views) / (rows - 1) - 0.5) *
                                                c->rows_height
                                          : 0;
            assert_true(z > 0);
            reach = fmax(reach, fabs(across + (x - across) * distance / z) / (half * c->aspect));
            reach = fmax(reach, fabs(above + (y - above) * distance / z) / half);
        }
    return reach;
}

/* Pixels from camera to camera along a row, of the corner that moves most. */
static double largest_track_step(const lf_camera *c, int width, double bounds[2][3])
{
    double right[3], up[3], forward[3], distance, largest = 0;
    frame_of(c, right, up, forward, &distance);
    for (int i = 0; i < 8; i++) {
        double z = 0;
        for (int a = 0; a < 3; a++)
            z += forward[a] * (bounds[i >> a & 1][a] - c->position[a]);
        largest = fmax(largest, fabs(c->track / (c->n_views - 1) * (1 - distance / z)) * width /
                                    (2 * distance * tan(c->fov_y / 2) * c->aspect));
    }
    return largest;
}

/* Tracks and grids keep their size wherever they are. */
static void what_is_framed_fills_its_share_of_a_grid(void **state)
{
    static const char *const views[] = {
        "'track': {'count': 5, 'length': 3, 'window': 'shared'}",
        "'grid': {'columns': 5, 'rows': 4, 'width': 3, 'height': 2}",
        "'grid': {'columns': 3, 'rows': 9, 'width': 0.1, 'height': 9}",
        "'grid': {'columns': 2, 'rows': 1, 'width': 1e-6, 'height': 0}",
    };
    (void)state;
    for (size_t i = 0; i < sizeof views / sizeof *views; i++)
        for (int steps = 0; steps < 2; steps++) {
            char text[512];
            snprintf(text, sizeof text,
                     "{'camera': {'position': [1, 2, 5], 'fov_y': 30, 'aspect': 0.75, 'views': "
                     "{%s}}}",
                     views[i]);
            lf_scene *scene = lf_test_scene(lf_test_scene_patched("three-things", "%s", text));
            lf_render_settings settings = settings_of(scene, 90, 120);
            lf_camera fitted = settings.camera;
            lf_error err = {0};
            double bounds[2][3];
            assert_true(lf_scene_bounds(scene, "cube", bounds));
            lf_assert_ok(lf_camera_fit(scene, &settings, "cube", 0.9, steps, fitted.target,
                                       fitted.position, &err),
                         &err);
            const double reach = reach_of_grid(&fitted, bounds);
            assert_true(reach < 0.9001 && (steps || reach > 0.8999));
            if (steps)
                assert_true(largest_track_step(&fitted, 90, bounds) < 1.0001);
            /* negative control: a hundredth nearer */
            for (int a = 0; a < 3; a++)
                fitted.position[a] += (fitted.target[a] - fitted.position[a]) / 100;
            assert_true(steps || reach_of_grid(&fitted, bounds) > 0.903);
            lf_scene_unref(scene);
        }
}

/* The same, made smaller by its depth, or not. */
static void what_is_framed_is_no_deeper_than_asked(void **state)
{
    (void)state;
    assert_fits(LOOK("'position': [0, 0, 5]"), NULL, 0.9, 1);
    assert_fits(LOOK("'position': [1, 2, 5], 'views': 9, 'cone': 60"), "cube", 0.9, 0.7);
    assert_fits(LOOK("'position': [1, 2, 5]"), "ball", 0.9, 1000);
}

static void nothing_cannot_be_framed(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("three-things")),
             *none = lf_test_scene("{}");
    lf_render_settings settings = settings_of(scene, 90, 120);
    double target[3] = {7}, position[3] = {7};
    lf_error err;
#define REFUSED(of, name, fill, steps)                                                             \
    lf_assert_status(lf_camera_fit(of, &settings, name, fill, steps, target, position, &err),      \
                     LF_E_ARG, &err)
    REFUSED(none, NULL, 0.9, 0);
    REFUSED(scene, "air", 0.9, 0);
    REFUSED(scene, NULL, 0, 0);
    REFUSED(scene, NULL, 1.1, 0);
    REFUSED(scene, NULL, NAN, 0);
    REFUSED(scene, NULL, 0.9, -1);
    settings.camera.track = 1;
    settings.camera.own_windows = true;
    REFUSED(scene, NULL, 0.9, 0);
    assert_non_null(strstr(err.what, "cameras with windows of their own cannot be fitted"));
#undef REFUSED
    assert_true(target[0] == 7 && position[0] == 7);
    lf_scene_unref(scene);
    lf_scene_unref(none);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_are_those_of_what_is_there),
        cmocka_unit_test(bounds_far_away_lose_nothing),
        cmocka_unit_test(a_step_is_what_a_point_moves_by_from_view_to_view),
        cmocka_unit_test(the_sharp_depth_ends_where_steps_reach_the_limit),
        cmocka_unit_test(only_what_is_in_the_picture_counts),
        cmocka_unit_test(what_begins_at_the_cameras_has_no_least_step),
        cmocka_unit_test(what_is_framed_fills_its_share_of_all_views),
        cmocka_unit_test(what_is_framed_fills_its_share_of_a_grid),
        cmocka_unit_test(what_is_framed_is_no_deeper_than_asked),
        cmocka_unit_test(nothing_cannot_be_framed),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
