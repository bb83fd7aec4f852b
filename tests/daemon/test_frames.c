/* Sequences: which frames there are, that each is the same whoever renders it, whole or not there,
 * and what becomes of those that are there already. */
#include "tests/daemon/quiltrender.h"
#include "tests/scene_file.h"

#include <signal.h>
#include <sys/stat.h>
#include <time.h>

#include "daemon/output/frames.h"

#define SIZE "--view-size 12x16 --views 4 --spp 1"

/* ------------------------------------------------------------------------------------- names -- */

static void assert_name(const char *path, int frame, const char *expected)
{
    char *name = lf_frames_path(path, frame);
    assert_non_null(name);
    assert_string_equal(name, expected);
    lf_free(name);
}

static void the_number_stands_in_its_place_or_before_the_suffix(void **state)
{
    (void)state;
    assert_name("turn.png", 7, "turn_0007.png");
    assert_name("turn_qs8x6a0.75.png", 7, "turn_0007_qs8x6a0.75.png");
    assert_name("turn_qs8x6a0.75.png", 12345, "turn_12345_qs8x6a0.75.png");
    assert_name("views/", 7, "views_0007/");
    assert_name("a.b/views/", 7, "a.b/views_0007/");
    assert_name("a.b/turn.exr", 0, "a.b/turn_0000.exr");
    assert_name("turn_%03d_qs8x6a0.75.png", 7, "turn_007_qs8x6a0.75.png");
    assert_name("%d/turn_%04d.png", 12, "12/turn_0012.png");
    assert_name("100%/turn.png", 1, "100%/turn_0001.png");
    assert_name("turn%20d%.png", 1, "turn%20d%_0001.png");
    assert_name("turn%s.png", 1, "turn%s_0001.png");
}

static void a_turntable_comes_round_in_equal_steps(void **state)
{
    (void)state;
    const lf_frames frames = {.turntable = 4, .first = 1, .last = 4};
    const lf_camera camera = {.target = {1, 0, 0}, .position = {1, 2, 5}, .up = {0, 3, 0}};
    static const double expected[4][3] = {{1, 2, 5}, {6, 2, 0}, {1, 2, -5}, {-4, 2, 0}};
    for (int i = 0; i < 4; i++) {
        json_t *patch = lf_frames_patch_turned(&frames, &camera, i + 1);
        const json_t *position = json_object_get(json_object_get(patch, "camera"), "position");
        for (size_t k = 0; k < 3; k++)
            lf_assert_close(json_real_value(json_array_get(position, k)), expected[i][k], 1e-12,
                            1e-12);
        json_decref(patch);
    }
}

static void frames_share_no_noise_and_the_first_has_the_seed(void **state)
{
    (void)state;
    assert_true(lf_frames_seed(5, 1) == 5);
    assert_true(lf_frames_seed(5, 3) == 7);
    assert_true(lf_frames_seed(5, 0) == 4);
    assert_true(lf_frames_seed(0, 0) == UINT64_MAX);
}

/* ------------------------------------------------------------------------------- wrong usage -- */

static const struct {
    const char *options, *words;
} wrong_usage[] = {
    {"-o %s/x.png --turntable 0", "--turntable: expects"},
    {"-o %s/x.png --turntable 4 --frames 3", "--frames: expects A:B"},
    {"-o %s/x.png --turntable 4 --frames 3:2", "3:2 ends before it begins"},
    {"-o %s/x.png --turntable 4 --frames 0:2",
     "is outside --turntable 4; expected frames within 1:4"},
    {"-o %s/x.png --turntable 4 --frames 2:5",
     "is outside --turntable 4; expected frames within 1:4"},
    {"-o %s/x.gif --wiggle --turntable 4", "--wiggle: cannot be combined with --turntable"},
    {"-o %s/x.png --turntable 4 --stats s.json", "--stats: cannot be combined with --turntable"},
    {"-o %s/x.png --turntable 4 --exposure auto", "--exposure: auto"},
    {"-o %s/x.png --turntable 4 --fps 25", "--fps: applies only to OUT.mp4"},
    {"-o %s/x.mp4", "a video needs --frames, --turntable, --wiggle, or"},
    {"-o %s/x.mp4 --turntable 4 --codec mpeg2", "--codec: expects h264 or h265"},
    {"-o %s/x.mp4 --turntable 4 --rgbd right", "the name of an image with depth must end in .png"},
    {"-o %s/x.mp4 --turntable 4 --views 6 --quilt 3x2 --view-size 11x16",
     "use --view-size 12x16 or --pixel-format yuv444p"},
    {"-o %s/x.mp4 --turntable 4 --views 6 --quilt 2x3 --view-size 11x15",
     "yuv420p cannot hold an image of 22x45 pixels, which has an odd side; use --view-size 11x16"},
    {"-o %s/x_qs5x9.mp4 --turntable 4 --views 6", "the name says 5x9"},
};

static void wrong_usage_is_one_line_and_exit_2(void **state)
{
    const qr_files *f = *state;
    int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof wrong_usage / sizeof wrong_usage[0]; i++) {
        char line[2 * PATH_MAX];
        qr_outcome o;
        const char *rest = strstr(wrong_usage[i].options, "%s") + 2;
        snprintf(line, sizeof line, "-o %s%s", f->folder, rest);
        print_message("%s\n", wrong_usage[i].options);
        qr_run(&o, "%s %s", f->scene, line);
        qr_assert_fails(&o, 2, wrong_usage[i].words);
    }
    qr_outcome o;
    qr_run(&o, "%s -o %s/x.png --turntable 4", f->quilt, f->folder);
    qr_assert_fails(&o, 2, "cannot be combined with one finished image");
    qr_run(&o, "--chart 60+-0.5/0.1@600 --print-size 60x60 -o %s/x.tif --turntable 4", f->folder);
    qr_assert_fails(&o, 2, "cannot be combined with --chart");
    assert_int_equal(qr_count_files(f->folder), before);
}

/* ------------------------------------------------------------------------------------ frames -- */

static void assert_same(const qr_files *f, const char *a, const char *b, bool same)
{
    char x[PATH_MAX], y[PATH_MAX];
    snprintf(x, sizeof x, "%s/%s", f->folder, a);
    snprintf(y, sizeof y, "%s/%s", f->folder, b);
    if (same)
        qr_assert_same_files(x, y);
    else
        qr_assert_different_files(x, y);
}

static void a_frame_is_the_same_alone_and_among_others_on_any_threads(void **state)
{
    const qr_files *f = *state;
    qr_succeed("%s -o %s/all.exr --turntable 3 --threads 2 " SIZE, f->scene, f->folder);
    qr_succeed("%s -o %s/one.exr --turntable 3 --frames 3:3 --threads 1 " SIZE, f->scene,
               f->folder);
    qr_succeed("%s -o %s/still.exr " SIZE, f->scene, f->folder);
    assert_same(f, "all_0003_qs2x2a0.75.exr", "one_0003_qs2x2a0.75.exr", true);
    assert_same(f, "all_0001_qs2x2a0.75.exr", "still_qs2x2a0.75.exr", true);
    assert_same(f, "all_0001_qs2x2a0.75.exr", "all_0002_qs2x2a0.75.exr", false);
    assert_false(qr_exists(f->folder, "one_0001_qs2x2a0.75.exr"));
    assert_false(qr_exists(f->folder, "all_0004_qs2x2a0.75.exr"));
}

/* The renderer of the frame before goes on with the next one: nothing of it may be left. */
static void nothing_of_a_frame_is_left_in_the_next_however_it_is_rendered(void **state)
{
    const qr_files *f = *state;
    static const char *const options[] = {"--reconstruct on", "--aov all", "--integrator amvpt",
                                          "--integrator vpt --estimator cv"};
    for (int i = 0; i < 4; i++) {
        char all[64], one[64];
        snprintf(all, sizeof all, "a%d_0002_qs2x2a0.75.exr", i);
        snprintf(one, sizeof one, "b%d_0002_qs2x2a0.75.exr", i);
        qr_succeed("%s -o %s/a%d.exr --turntable 5 --frames 1:2 %s " SIZE, f->scene, f->folder, i,
                   options[i]);
        qr_succeed("%s -o %s/b%d.exr --turntable 5 --frames 2:2 %s " SIZE, f->scene, f->folder, i,
                   options[i]);
        assert_same(f, all, one, true);
    }
}

static void frames_that_are_there_stay_and_those_that_lack_are_made(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char third[PATH_MAX];
    qr_succeed("%s -o %s/r.png --turntable 3 " SIZE, f->scene, f->folder);
    snprintf(third, sizeof third, "%s", lf_test_path(f->folder, "third.png"));
    assert_int_equal(rename(lf_test_path(f->folder, "r_0003_qs2x2a0.75.png"), third), 0);
    lf_test_write(f->folder, "r_0002_qs2x2a0.75.png", "mine");
    qr_run(&o, "%s -o %s/r.png --turntable 3 " SIZE, f->scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "2 of 3 frames exist and are kept"));
    assert_same(f, "r_0003_qs2x2a0.75.png", "third.png", true);
    lf_test_write(f->folder, "mine.png", "mine");
    assert_same(f, "r_0002_qs2x2a0.75.png", "mine.png", true);
    qr_run(&o, "%s -o %s/r.png --turntable 3 --overwrite " SIZE, f->scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_null(strstr(o.err, "exist and are kept"));
    qr_succeed("%s -o %s/again.png --turntable 3 " SIZE, f->scene, f->folder);
    assert_same(f, "r_0002_qs2x2a0.75.png", "again_0002_qs2x2a0.75.png", true);
}

/* A folder of which a view is missing is not there. */
static void folders_and_panels_are_frames_too(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_succeed("%s -o %s/views/ --turntable 2 " SIZE, f->scene, f->folder);
    assert_true(qr_exists(f->folder, "views_0002/view_003.exr"));
    assert_int_equal(unlink(lf_test_path(f->folder, "views_0001/view_002.exr")), 0);
    qr_run(&o, "%s -o %s/views/ --turntable 2 " SIZE, f->scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "1 of 2 frames exist and are kept"));
    assert_true(qr_exists(f->folder, "views_0001/view_002.exr"));
    qr_succeed("%s -o %s/woven_%%02d.png --panel %s --turntable 2 " SIZE, f->scene, f->folder,
               f->calibration);
    assert_true(qr_exists(f->folder, "woven_01.png"));
    assert_true(qr_exists(f->folder, "woven_02.png"));
}

/* Until a file is there. */
static void await_file(const char *path)
{
    for (int i = 0; i < 3000 && access(path, F_OK) != 0; i++)
        qr_nap(0.01);
    assert_int_equal(access(path, F_OK), 0);
}

static void an_interrupted_sequence_keeps_whole_frames_and_nothing_else(void **state)
{
    const qr_files *f = *state;
    char line[2 * PATH_MAX], text[4096];
    int before = qr_count_files(f->folder);
    int err = memfd_create("stderr", 0), out = memfd_create("stdout", 0);
    snprintf(line, sizeof line,
             "%s -o %s/t.png --turntable 100000 --view-size 12x16 --views 4 --spp 4", f->scene,
             f->folder);
    pid_t pid = qr_start(line, out, err, RLIM_INFINITY);
    await_file(lf_test_path(f->folder, "t_0002_qs2x2a0.75.png"));
    double begun = lf_time_now();
    kill(pid, SIGTERM);
    assert_int_equal(qr_ended(pid), 1);
    assert_true(lf_time_now() - begun < 2);
    qr_read_back(err, text, sizeof text);
    close(out);
    assert_non_null(strstr(text, "of 100000 frames were written"));
    int n = 0;
    char name[64];
    for (;; n++) {
        lf_quilt_file quilt = {0};
        lf_error error = {0};
        snprintf(name, sizeof name, "t_%04d_qs2x2a0.75.png", n + 1);
        if (!qr_exists(f->folder, name))
            break;
        lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, name), NULL, 0, 0, &quilt, &error),
                     &error);
        lf_quilt_finish(&quilt);
    }
    assert_true(n >= 2);
    assert_int_equal(qr_count_files(f->folder), before + n);
}

static char readers_before[PATH_MAX];

static int set_up(void **state)
{
    snprintf(readers_before, sizeof readers_before, "%s", getenv("QUILTIMPORT"));
    return qr_set_up(state);
}

static int tear_down(void **state)
{
    setenv("QUILTIMPORT", readers_before, 1);
    return qr_tear_down(state);
}

/* Readers that note each of their calls before they do as they are told. */
static void count_readers(const qr_files *f, const char *folder)
{
    static const char *const names[] = {"quiltimport", "quiltimport-vdb"};
    char script[4 * PATH_MAX], *real = realpath(lf_test_built("quiltimport"), NULL);
    assert_non_null(real);
    *strrchr(real, '/') = '\0';
    for (int i = 0; i < 2; i++) {
        snprintf(script, sizeof script, "#!/bin/sh\necho x >>%s/%s.calls\nexec %s/%s\n", f->folder,
                 names[i], real, names[i]);
        assert_int_equal(chmod(lf_test_write(folder, names[i], script), 0755), 0);
    }
    free(real);
    setenv("QUILTIMPORT", folder, 1);
}

static int count_calls(const qr_files *f, const char *reader)
{
    char name[64];
    struct stat st;
    snprintf(name, sizeof name, "%s.calls", reader);
    assert_int_equal(stat(lf_test_path(f->folder, name), &st), 0);
    return (int)st.st_size / 2;
}

static void link_grid(const qr_files *f, const char *name, const char *grid)
{
    char *real = realpath(lf_test_built(grid), NULL);
    assert_non_null(real);
    assert_int_equal(symlink(real, lf_test_path(f->folder, name)), 0);
    free(real);
}

/* Smoke of another file in every frame before a mesh that stays. */
static const char *write_smoke(const qr_files *f)
{
    link_grid(f, "smoke_01.vdb", "testdata/block.vdb");
    link_grid(f, "smoke_02.vdb", "testdata/patterns.vdb");
    link_grid(f, "smoke_03.vdb", "testdata/block.vdb");
    lf_test_write(f->folder, "tri.obj", "v -90 -90 -60\nv 90 -90 -60\nv 0 90 -60\nf 1 2 3\n");
    return lf_test_write(
        f->folder, "smoke.json",
        "{ \"camera\": { \"position\": [0,0,60], \"fov_y\": 60, \"cone\": 2 },\n"
        "  \"volumes\": { \"smoke\": { \"file\": \"smoke_%02d.vdb\", \"scale\": 0.1,\n"
        "    \"grid\": \"density\" } },\n"
        "  \"meshes\": { \"tri\": { \"file\": \"tri.obj\" } },\n"
        "  \"lights\": { \"sky\": { \"type\": \"environment\", \"radiance\": 1 } } }\n");
}

static void volumes_of_a_sequence_are_read_frame_by_frame_and_the_rest_once(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX], folder[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", write_smoke(f));
    snprintf(folder, sizeof folder, "%s", lf_test_path(f->folder, "readers"));
    assert_int_equal(mkdir(folder, 0777), 0);
    count_readers(f, folder);
    qr_run(&o, "%s -o %s/s.exr --frames 1:3 --threads 2 " SIZE, scene, f->folder);
    setenv("QUILTIMPORT", readers_before, 1);
    if (o.code != 0)
        fail_msg("%s", o.err);
    assert_int_equal(count_calls(f, "quiltimport"), 1);
    assert_int_equal(count_calls(f, "quiltimport-vdb"), 3);
    qr_succeed("%s -o %s/one.exr --frames 2:2 --threads 1 " SIZE, scene, f->folder);
    assert_same(f, "s_0002_qs2x2a0.75.exr", "one_0002_qs2x2a0.75.exr", true);
    assert_same(f, "s_0002_qs2x2a0.75.exr", "s_0001_qs2x2a0.75.exr", false);
    qr_succeed("%s -o %s/turned.exr --turntable 3 --frames 2:2 " SIZE, scene, f->folder);
    assert_same(f, "s_0002_qs2x2a0.75.exr", "turned_0002_qs2x2a0.75.exr", false);
    qr_succeed("%s -o %s/still.exr " SIZE, scene, f->folder);
    assert_same(f, "s_0001_qs2x2a0.75.exr", "still_qs2x2a0.75.exr", true);
}

static void a_turntable_reads_its_files_once(void **state)
{
    const qr_files *f = *state;
    char folder[PATH_MAX];
    write_smoke(f);
    snprintf(folder, sizeof folder, "%s", lf_test_path(f->folder, "readers"));
    assert_int_equal(mkdir(folder, 0777), 0);
    const char *still =
        lf_test_write(f->folder, "still.json", lf_test_scene_text("smoke-before-mesh"));
    count_readers(f, folder);
    qr_succeed("%s -o %s/s.exr --turntable 3 " SIZE, still, f->folder);
    setenv("QUILTIMPORT", readers_before, 1);
    assert_int_equal(count_calls(f, "quiltimport"), 1);
    assert_int_equal(count_calls(f, "quiltimport-vdb"), 1);
}

static void a_file_that_some_frame_lacks_is_told_before_any_is_rendered(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    qr_outcome o;
    snprintf(scene, sizeof scene, "%s", write_smoke(f));
    qr_run(&o, "%s -o %s/s.exr --frames 3:4 " SIZE, scene, f->folder);
    qr_assert_fails(&o, 1, "smoke.json: /volumes/smoke/file: frame 4: ");
    assert_non_null(strstr(o.err, "smoke_04.vdb: cannot open: No such file"));
    assert_non_null(strstr(o.err, "; use --frames 3:3"));
    assert_false(qr_exists(f->folder, "s_0003_qs2x2a0.75.exr"));
    qr_run(&o, "%s -o %s/s.exr --frames 4:4 " SIZE, scene, f->folder);
    qr_assert_fails(&o, 1, "smoke.json:2: /volumes/smoke/file: ");
    qr_run(&o, "%s -o %s/s.exr --frames 1:2 " SIZE, f->scene, f->folder);
    qr_assert_fails(&o, 2, "fog.json has no animation");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_number_stands_in_its_place_or_before_the_suffix),
        cmocka_unit_test(frames_share_no_noise_and_the_first_has_the_seed),
        cmocka_unit_test(a_turntable_comes_round_in_equal_steps),
        cmocka_unit_test_setup_teardown(wrong_usage_is_one_line_and_exit_2, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_frame_is_the_same_alone_and_among_others_on_any_threads,
                                        qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(
            nothing_of_a_frame_is_left_in_the_next_however_it_is_rendered, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(frames_that_are_there_stay_and_those_that_lack_are_made,
                                        qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(
            volumes_of_a_sequence_are_read_frame_by_frame_and_the_rest_once, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_turntable_reads_its_files_once, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_file_that_some_frame_lacks_is_told_before_any_is_rendered,
                                        qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(folders_and_panels_are_frames_too, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(an_interrupted_sequence_keeps_whole_frames_and_nothing_else,
                                        qr_set_up, qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
