/* quiltrender from outside: cameras that fit what they see, that see nothing, in lists and in
 * grids. */
#include "tests/daemon/quiltrender.h"

#define SMALL "--spp 1 --quilt 2x1 --view-size 12x16"

/* What is framed does not ask how far away the camera was. */
static void a_camera_that_fits_is_where_another_one_would_be(void **state)
{
    const qr_files *f = *state;
    char scene[2][PATH_MAX], text[512];
    for (int i = 0; i < 2; i++) {
        snprintf(text, sizeof text,
                 "{\"camera\": {\"position\": [0, 0, %d], \"views\": 2}, \"volumes\": {\"fog\": "
                 "{\"shape\": \"sphere\", \"transform\": {\"translate\": [3, 7, 0]}}}, \"lights\": "
                 "{\"sky\": {\"type\": \"environment\", \"radiance\": 1, \"visible\": false}}}",
                 i ? 24 : 6);
        snprintf(scene[i], PATH_MAX, "%s", lf_test_write(f->folder, i ? "b.json" : "a.json", text));
    }
    qr_succeed("%s -o %s/near.png --fit " SMALL, scene[0], f->folder);
    qr_succeed("%s -o %s/far.png --fit " SMALL, scene[1], f->folder);
    qr_succeed("%s -o %s/missed.png " SMALL, scene[0], f->folder);
    lf_quilt_file fits[2], missed;
    static const char *const names[] = {"near_qs2x1a0.75.png", "far_qs2x1a0.75.png"};
    for (int i = 0; i < 2; i++)
        lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, names[i]), NULL, 0, 0, &fits[i], NULL),
                     NULL);
    lf_assert_ok(
        lf_quilt_read(lf_test_path(f->folder, "missed_qs2x1a0.75.png"), NULL, 0, 0, &missed, NULL),
        NULL);
    for (int y = 0; y < 16; y++)
        assert_memory_equal(lf_views8_row(&fits[0].views8, 0, y),
                            lf_views8_row(&fits[1].views8, 0, y), 3 * 12);
    assert_true(lf_views8_row(&fits[0].views8, 0, 8)[3 * 6] > 20);
    assert_true(lf_views8_row(&missed.views8, 0, 8)[3 * 6] == 0);
    for (int i = 0; i < 2; i++)
        lf_quilt_finish(&fits[i]);
    lf_quilt_finish(&missed);
}

/* A thing by its name, a wrong one by another; what looks like a file is none. */
static void a_camera_fits_one_thing(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_succeed("--fit fog %s -o %s/fit_a.png " SMALL " --views 2", f->scene, f->folder);
    qr_run(&o, "--fit %s -o %s/fit_b.png " SMALL " --views 2", f->scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "--fit: the ground \"ground\" is not framed"));
    qr_succeed("%s --fit=ground -o %s/fit_c.png " SMALL " --views 2", f->scene, f->folder);
    lf_quilt_file fits[3];
    for (int i = 0; i < 3; i++) {
        char name[32];
        snprintf(name, sizeof name, "fit_%c_qs2x1a0.75.png", 'a' + i);
        lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, name), NULL, 0, 0, &fits[i], NULL),
                     NULL);
    }
    /* the ground is left out where nothing is named */
    bool same[2] = {true, true};
    for (int i = 0; i < 2; i++)
        for (int y = 0; y < 16; y++)
            same[i] = same[i] && memcmp(lf_views8_row(&fits[0].views8, 0, y),
                                        lf_views8_row(&fits[i + 1].views8, 0, y), 3 * 12) == 0;
    assert_true(same[0] && !same[1]);
    for (int i = 0; i < 3; i++)
        lf_quilt_finish(&fits[i]);
    qr_run(&o, "%s --fit fgo -o %s/fit_d.png " SMALL " --views 2", f->scene, f->folder);
    assert_int_equal(o.code, 2);
    assert_non_null(
        strstr(o.err, "the scene has no mesh or volume \"fgo\"; did you mean \"fog\"?"));
}

/* A scene of that camera and light, and what is said of its picture. */
static void assert_told(const qr_files *f, const char *camera, const char *light, const char *words)
{
    char text[600];
    qr_outcome o;
    snprintf(text, sizeof text,
             "{\"camera\": {%s}, \"meshes\": {\"ball\": {\"shape\": \"sphere\"}}, \"lights\": "
             "{\"l\": {%s}}}",
             camera, light);
    const char *scene = lf_test_write(f->folder, "told.json", text);
    qr_run(&o, "%s -o %s/told.png " SMALL " --views 2", scene, f->folder);
    assert_int_equal(o.code, 0);
    if (words ? !strstr(o.err, words) : strstr(o.err, "camera sees") || strstr(o.err, "the image "))
        fail_msg("expected %s: %s", words ? words : "nothing", o.err);
}

static void a_picture_in_which_nothing_is_seen_is_told(void **state)
{
    static const char sky[] = "\"type\": \"environment\", \"radiance\": 1",
                      dim[] = "\"type\": \"environment\", \"radiance\": 0.0001, \"visible\": false",
                      dusk[] = "\"type\": \"environment\", \"radiance\": 0.003, \"visible\": false";
    assert_told(*state, "\"position\": [0, 0, 9]", sky, NULL);
    assert_told(*state, "\"position\": [0, 0, 9]", dusk, NULL);
    assert_told(*state, "\"position\": [0, 0, 9]", dim,
                "told.json: the image is black in all views");
    assert_told(*state, "\"target\": [50, 0, 0], \"position\": [50, 0, 9]", sky,
                "told.json: the camera sees no mesh and no volume of the scene; use --fit");
    assert_told(*state, "\"position\": [0, 0, 0.1], \"cone\": 1",
                "\"type\": \"point\", \"position\": [9, 9, 9], \"intensity\": 1e9",
                "told.json: the image is black in all views");
}

/* The camera of the fog, turned or not, with its views placed so. */
static const char *placed(const char *folder, const char *name, double height, const char *views)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{\"include\": \"fog.json\", \"camera\": {\"position\": [0, %g, 6], \"target\": "
             "[0, %g, 0], \"views\": %s}}",
             height, height, views);
    return lf_test_write(folder, name, text);
}

/* Cameras listed one by one make quilts and folders, the same for any number of threads; what needs
 * a rig says so. */
static void cameras_in_a_list_are_views(void **state)
{
    static const char *const refused[][2] = {
        {"x.png --views 3", "--views: is not supported with a list, path or circle of cameras"},
        {"x.png --preset portrait", "--preset: is not supported"},
        {"x.exr --aov depth", "--aov: is not supported"},
        {"x.exr --reconstruct on", "--denoise on: is not supported"},
        {"x_%04d.png --turntable 3", "--turntable: is not supported"},
        {"x.png --fit", "do not form a rig"},
        {"x.png --rgbd right", "need an arc, a track or a grid"}};
    const qr_files *f = *state;
    char list[PATH_MAX];
    lf_quilt_file quilts[2];
    qr_outcome o;
    snprintf(list, sizeof list, "%s",
             placed(f->folder, "list.json", 0,
                    "{\"list\": [{\"position\": [-2, 0, 6]}, {\"position\": [2, 1, 5]}, "
                    "{\"position\": [0, 5, 1]}, {\"position\": [0, 1, -6]}]}"));
    for (int i = 0; i < 2; i++) {
        qr_succeed(
            "%s -o %s/list%d.exr --spp 2 --view-size 12x16 --seed 5 --quilt 2x2 --threads %d", list,
            f->folder, i, 1 + 2 * i);
        lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, i ? "list1_qs2x2a0.75.exr"
                                                             : "list0_qs2x2a0.75.exr"),
                                   NULL, 0, 0, &quilts[i], NULL),
                     NULL);
        assert_int_equal(quilts[i].views32.n_views, 4);
    }
    for (int i = 0; i < 4 * 16; i++)
        assert_memory_equal(lf_views32_row(&quilts[0].views32, i / 16, i % 16),
                            lf_views32_row(&quilts[1].views32, i / 16, i % 16),
                            12 * 3 * sizeof(float));
    qr_succeed("%s -o %s/views/ --spp 1 --view-size 12x16", list, f->folder);
    assert_int_equal(access(lf_test_path(f->folder, "views/view_003.exr"), R_OK), 0);
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        qr_run(&o, "%s -o %s/%s", list, f->folder, refused[i][0]);
        qr_assert_fails(&o, 2, refused[i][1]);
    }
    qr_run(&o, "%s -o %s/x.png --integrator amvpt", list, f->folder);
    qr_assert_fails(&o, 1, "one of mvpt, vpt");
    for (int i = 0; i < 2; i++)
        lf_quilt_finish(&quilts[i]);
}

/* A row of a grid whose windows go along is a track from higher up, to the last bit; lower rows
 * come first. */
static void rows_of_a_grid_are_tracks(void **state)
{
    const qr_files *f = *state;
    char grid[PATH_MAX], track[PATH_MAX];
    lf_quilt_file whole, alone;
    snprintf(grid, sizeof grid, "%s",
             placed(f->folder, "grid.json", 0,
                    "{\"grid\": {\"columns\": 3, \"rows\": 3, \"width\": 1, \"height\": 1, "
                    "\"window\": \"own\"}}"));
    qr_succeed("%s -o %s/grid.exr --spp 2 --view-size 12x16 --seed 5 --aov samples", grid,
               f->folder);
    lf_assert_ok(
        lf_quilt_read(lf_test_path(f->folder, "grid_qs3x3a0.75.exr"), NULL, 0, 0, &whole, NULL),
        NULL);
    assert_int_equal(whole.views32.n_views, 9);
    qr_outcome o;
    qr_run(&o, "%s -o %s/grid.exr --stats %s/s.json", grid, f->folder, f->folder);
    qr_assert_fails(&o, 2, "--stats: supports one row of cameras");
    qr_run(&o, "%s -o %s/grid.exr --views 3", grid, f->folder);
    qr_assert_fails(&o, 2, "the scene has a grid of 3 x 3 cameras");
    snprintf(track, sizeof track, "%s",
             placed(f->folder, "plate.json", 0,
                    "{\"grid\": {\"columns\": 100, \"rows\": 50, \"width\": 1, \"height\": 1}}"));
    qr_run(&o, "%s -o %s/plate.png", track, f->folder);
    qr_assert_fails(&o, 2, "5000 views do not fit into the 64x64 tiles of a quilt");
    qr_run(&o, "%s -o %s/grid.mp4", grid, f->folder);
    qr_assert_fails(&o, 2, "a camera grid cannot become a video of views");
    for (uint64_t row = 0; row < 3; row++) {
        snprintf(track, sizeof track, "%s",
                 placed(f->folder, "track.json", 0.5 * (double)row - 0.5,
                        "{\"track\": {\"count\": 3, \"length\": 1}}"));
        qr_succeed("%s -o %s/track.exr --spp 2 --view-size 12x16 --quilt 3x1 --seed %llu", track,
                   f->folder, (unsigned long long)(5 + row * UINT64_C(0x9e3779b97f4a7c15)));
        lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, "track_qs3x1a0.75.exr"), NULL, 0, 0,
                                   &alone, NULL),
                     NULL);
        for (int i = 0; i < 3 * 16; i++)
            assert_memory_equal(lf_views32_row(&whole.views32, (int)row * 3 + i / 16, i % 16),
                                lf_views32_row(&alone.views32, i / 16, i % 16),
                                12 * 3 * sizeof(float));
        lf_quilt_finish(&alone);
    }
    lf_quilt_finish(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_camera_that_fits_is_where_another_one_would_be),
        cmocka_unit_test(a_camera_fits_one_thing),
        cmocka_unit_test(a_picture_in_which_nothing_is_seen_is_told),
        cmocka_unit_test(cameras_in_a_list_are_views),
        cmocka_unit_test(rows_of_a_grid_are_tracks),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
