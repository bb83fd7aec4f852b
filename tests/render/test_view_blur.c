/* camera.view_blur: what a view is the mean of. An edge before a sky against its closed form, and
 * three wide views against fifteen pinhole views in the place of each. (Paths in such views:
 * test_brute_force, test_agreement.) */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 8 };

#define SKY "'lights': {'sky': {'type': 'environment', 'radiance': 1}}"

/* Means over the rows, [view][column]. Nothing scatters: what is seen is known light. */
static void columns_of(const char *text, int n_views, int cycles, double *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_test_cycles(r, cycles);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    for (int i = 0; i < n_views * width; i++) {
        out[i] = 0;
        for (int row = 0; row < height; row++)
            out[i] += picture[row * n_views * width + i] / height;
    }
    free(picture);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* ----------------------------------------------------------------------------------- an edge -- */

#define DISTANCE 5.0
#define FOV 20.0
#define CONE 30.0

/* Share of a pixel's film and of the line of cameras whose rays pass to the right of x = edge at
 * depth z: X = c + (X_w - c) z / D. */
static double beside(double z, double edge, int view, int column, double blur)
{
    enum { POINTS = 400 };
    double half = DISTANCE * tan(FOV / 2 * M_PI / 180), pixel = 2 * half / width, sum = 0;
    double step = DISTANCE * tan(CONE / 3 * M_PI / 180), b = (view - 1) * step;
    for (int i = 0; i < POINTS; i++) {
        double at = -half + (column + (i + 0.5) / POINTS) * pixel;
        /* the camera from which the ray meets the edge */
        double c = z == DISTANCE ? (at > edge ? -HUGE_VAL : HUGE_VAL)
                                 : (edge - at * z / DISTANCE) / (1 - z / DISTANCE);
        double right = blur > 0 ? (b + blur * step / 2 - c) / (blur * step) : c < b;
        double share = fmin(fmax(right, 0), 1);
        sum += z > DISTANCE ? 1 - share : share;
    }
    return sum / POINTS;
}

static double worst_difference(double z, double blur, double expected_blur)
{
    const double edge = 0.1;
    double out[3 * width], worst = 0;
    const char *text = lf_test_scene_patched(
        "wall-to-edge",
        "{'camera': {'fov_y': %g, 'cone': %g, 'view_blur': %g}, "
        "'meshes': {'wall': {'transform': {'translate': [%.17g, 0, %.17g]}}}}",
        FOV, CONE, blur, edge - 40, DISTANCE - z);
    columns_of(text, 3, 256, out);
    for (int i = 0; i < 3 * width; i++) {
        double is = beside(z, edge, i / width, i % width, expected_blur);
        worst = fmax(worst, fabs(out[i] - is));
    }
    return worst;
}

/* A tenth more or less would be seen, and so would points in the place of lines. */
static void an_edge_is_a_ramp_as_wide_as_the_step(void **state)
{
    (void)state;
    const double depths[] = {3.5, 7};
    for (int i = 0; i < 4; i++) {
        double z = depths[i % 2], blur = i < 2 ? 1 : 2.5;
        double right = worst_difference(z, blur, blur);
        print_message("depth %g, blur %g: %.4f off\n", z, blur, right);
        assert_true(right < 0.012);
        assert_true(worst_difference(z, blur, 1.1 * blur) > 0.015);
        assert_true(worst_difference(z, blur, 0.9 * blur) > 0.015);
        assert_true(worst_difference(z, blur, 0) > 0.2);
    }
}

static void the_window_stays_sharp(void **state)
{
    (void)state;
    assert_true(worst_difference(DISTANCE, 1, 0) < 0.012);
    assert_true(worst_difference(DISTANCE, 8, 0) < 0.012);
}

/* ------------------------------------------------------------------------------- up and down -- */

/* The same edge lying on its side, and rows of a grid in the place of views: of one of three. */
static double worst_of_rows(double z, double blur, double expected_blur, int row)
{
    const double edge = 0.1, step = DISTANCE * tan(CONE / 3 * M_PI / 180);
    double worst = 0;
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "wall-to-edge",
        "{'camera': {'fov_y': %g, 'cone': null, 'view_blur': %g, "
        "'views': {'grid': {'columns': 2, 'rows': 3, 'width': 1, 'height': %.17g}}}, "
        "'meshes': {'wall': {'transform': {'translate': [0, %.17g, %.17g]}}}}",
        FOV, blur, 2 * step, edge - 40, DISTANCE - z));
    lf_render_settings settings = {.camera = lf_camera_row(lf_scene_camera(scene), row),
                                   .width = 4,
                                   .height = width,
                                   .skip = LF_SKIP_ALL,
                                   .seed = lf_test_seed()};
    lf_renderer *r = lf_test_renderer(scene, "mvpt", 4, width, NULL);
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_test_cycles(r, 1024);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    for (int i = 0; i < width; i++)
        worst = fmax(
            worst, fabs(picture[(width - 1 - i) * 2 * 4] - beside(z, edge, row, i, expected_blur)));
    free(picture);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return worst;
}

/* 1024 heights of a row, and as many of its film: strata of 0.001. */
static void views_of_a_grid_are_means_over_cells(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const double z = i % 2 ? 7 : 3.5;
        const int row = i / 2;
        const double right = worst_of_rows(z, 1, 1, row);
        print_message("depth %g, row %d: %.4f off\n", z, row, right);
        assert_true(right < 0.015);
        assert_true(worst_of_rows(z, 1, 1.15, row) > 0.025);
        assert_true(worst_of_rows(z, 1, 0, row) > 0.2);
    }
    assert_true(worst_of_rows(DISTANCE, 1, 0, 0) < 0.015);
}

/* Of a row that stands so far above its place, without or with its cell: means over columns. */
static void heights_of(lf_scene *scene, const char *integrator, double above, bool cell, int cycles,
                       double out[width])
{
    lf_render_settings settings = {.camera = lf_camera_row(lf_scene_camera(scene), 1),
                                   .width = 4,
                                   .height = width,
                                   .integrator = integrator,
                                   .skip = LF_SKIP_ALL,
                                   .seed = lf_test_seed()};
    settings.camera.rise += above;
    settings.camera.view_blur = cell ? 1 : 0;
    lf_renderer *r = lf_test_renderer(scene, integrator, 4, width, NULL);
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_test_cycles(r, cycles);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    for (int i = 0; i < width; i++) {
        out[i] = 0;
        for (int k = 0; k < 2 * 4; k++)
            out[i] += picture[i * 2 * 4 + k] / 8;
    }
    free(picture);
    lf_renderer_destroy(r);
}

/* Windows of their own, fog before a bar: a cell is the mean of the cameras in it. */
static void cells_of_own_windows_are_means_of_their_cameras(void **state)
{
    (void)state;
    enum { each = 9 };
    lf_scene *scene = lf_test_scene(lf_test_scene_text("own-windows"));
    for (int i = 0; i < 2; i++) {
        const char *integrator = i ? "vpt" : "mvpt";
        double cell[width], mean[width] = {0}, one[width], worst = 0, contrast = 0;
        heights_of(scene, integrator, 0, true, 2048, cell);
        for (int k = 0; k < each; k++) {
            double row[width];
            heights_of(scene, integrator, 0.8 * ((k + 0.5) / each - 0.5), false, 256, row);
            for (int y = 0; y < width; y++)
                mean[y] += row[y] / each;
            if (k == each / 2)
                memcpy(one, row, sizeof one);
        }
        for (int y = 0; y < width; y++) {
            worst = fmax(worst, fabs(cell[y] - mean[y]));
            contrast = fmax(contrast, fabs(one[y] - mean[y]));
        }
        print_message("%s: %.4f off; the middle camera alone %.4f\n", integrator, worst, contrast);
        assert_true(worst < 0.02);
        assert_true(contrast > 0.1);
    }
    lf_scene_unref(scene);
}

/* -------------------------------------------------------------------------- pinholes between -- */

static const char *wide_voxels(int n_views, double blur, const char *vdb)
{
    return lf_test_scene_patched(
        "wide-voxels",
        "{'camera': {'views': %d, 'view_blur': %g}, 'volumes': {'v': {'file': '%s'}}}", n_views,
        blur, vdb);
}

/* Voxels far wider than the window behind it, and panes before them. Of three views the middle one,
 * or all, against the mean of so many of 45 pinhole views of the same rig, about each. */
static void assert_pinholes(double blur, int n_compared)
{
    enum { each = 15 };
    double lines[3 * width], points[3 * each * width], worst = 0, contrast = 0;
    char vdb[PATH_MAX];
    const int n = (int)(each * blur);
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), vdb));
    columns_of(wide_voxels(3, blur, vdb), 3, 240, lines);
    columns_of(wide_voxels(3 * each, 0.0, vdb), 3 * each, 16, points);
    for (int i = 0; i < n_compared * width; i++) {
        int view = n_compared == 1 ? 1 : i / width, first = view * each + each / 2 - n / 2;
        double mean = 0, is = lines[view * width + i % width],
               middle = points[(view * each + each / 2) * width + i % width];
        for (int k = 0; k < n; k++)
            mean += points[(first + k) * width + i % width] / n;
        worst = fmax(worst, fabs(is - mean));
        contrast = fmax(contrast, fabs(middle - mean));
    }
    print_message("blur %g: %.4f off; the middle pinhole alone %.4f\n", blur, worst, contrast);
    assert_true(worst < 0.01);
    assert_true(contrast > 0.1);
}

static void pinholes_in_the_place_of_lines_show_the_same(void **state)
{
    (void)state;
    assert_pinholes(1, 3);
    assert_pinholes(3, 1);
}

static void one_lens_at_a_time(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene("{'camera': {'view_blur': 1}}");
    lf_render_settings settings = {
        .camera = *lf_scene_camera(scene), .width = 8, .height = 8, .skip = LF_SKIP_ALL};
    lf_renderer *r = NULL;
    lf_pool *pool = NULL;
    lf_error err;
    assert_int_equal(lf_pool_create(1, &pool), LF_OK);
    settings.camera.lens_radius = 0.1;
    lf_assert_status(lf_renderer_create(scene, &settings, pool, &r, &err), LF_E_ARG, &err);
    settings.camera.lens_radius = 0;
    settings.camera.view_blur = 8.5;
    lf_assert_status(lf_renderer_create(scene, &settings, pool, &r, &err), LF_E_ARG, &err);
    assert_null(r);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_edge_is_a_ramp_as_wide_as_the_step),
        cmocka_unit_test(the_window_stays_sharp),
        cmocka_unit_test(views_of_a_grid_are_means_over_cells),
        cmocka_unit_test(cells_of_own_windows_are_means_of_their_cameras),
        cmocka_unit_test(pinholes_in_the_place_of_lines_show_the_same),
        cmocka_unit_test(one_lens_at_a_time),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
