/* Videos: what ffmpeg is given, and that the file is there whole or not at all, whatever ffmpeg
 * does. A script takes its place; the last tests ask the real one, where it is installed. */
#include "tests/daemon/quiltrender.h"
#include "tests/scene_file.h"

#include <signal.h>
#include <sys/stat.h>
#include <time.h>

#define SIZE "--view-size 12x16 --views 4 --spp 1"
#define WIDE 24
#define HIGH 32
#define FRAMES 3

static char path_before[8192];

/* A program called ffmpeg, which is found before any other. */
static void pretend(const qr_files *f, const char *script)
{
    char path[PATH_MAX + sizeof path_before];
    assert_int_equal(chmod(lf_test_write(f->folder, "ffmpeg", script), 0755), 0);
    snprintf(path, sizeof path, "%s:%s", f->folder, path_before);
    setenv("PATH", path, 1);
}

static int set_up(void **state)
{
    snprintf(path_before, sizeof path_before, "%s", getenv("PATH"));
    return qr_set_up(state);
}

static int tear_down(void **state)
{
    setenv("PATH", path_before, 1);
    return qr_tear_down(state);
}

static char *read_text(const char *folder, const char *name, size_t *out_n)
{
    char *text = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(lf_test_path(folder, name), NULL, 1 << 24, &text, out_n, &err), &err);
    return text;
}

/* ------------------------------------------------------------------------------ in its place -- */

static void assert_pixels(const qr_files *f, const uint8_t *raw, int frame)
{
    char name[64];
    lf_quilt_file quilt = {0};
    lf_error err = {0};
    snprintf(name, sizeof name, "p_%04d_qs2x2a0.75.png", frame + 1);
    lf_assert_ok(lf_quilt_read(lf_test_path(f->folder, name), NULL, 0, 0, &quilt, &err), &err);
    for (int y = 0; y < HIGH; y++)
        for (int column = 0; column < 2; column++) {
            int view = 2 * (1 - y / (HIGH / 2)) + column;
            assert_memory_equal(raw + ((frame * HIGH + y) * WIDE + column * (WIDE / 2)) * 3,
                                lf_views8_row(&quilt.views8, view, y % (HIGH / 2)), WIDE / 2 * 3);
        }
    lf_quilt_finish(&quilt);
}

static void ffmpeg_gets_the_pixels_of_the_pictures_and_a_file_to_write_into(void **state)
{
    const qr_files *f = *state;
    size_t n = 0, size = 0;
    char script[2 * PATH_MAX];
    snprintf(script, sizeof script, "#!/bin/sh\nprintf '%%s ' \"$@\" >%s/words\ncat >&3\n",
             f->folder);
    pretend(f, script);
    qr_succeed("%s -o %s/p.png --turntable 3 " SIZE, f->scene, f->folder);
    qr_succeed("%s -o %s/v.mp4 --turntable 3 --fps 24 --crf 12 " SIZE, f->scene, f->folder);
    char *raw = read_text(f->folder, "v_qs2x2a0.75.mp4", &n);
    char *words = read_text(f->folder, "words", &size);
    assert_int_equal(n, FRAMES * WIDE * HIGH * 3);
    for (int frame = 0; frame < FRAMES; frame++)
        assert_pixels(f, (const uint8_t *)raw, frame);
    static const char *const expected[] = {"-video_size 24x32 ", "-framerate 24 ", "-crf 12 ",
                                           "-c:v libx264 ", "-pix_fmt yuv420p "};
    for (int i = 0; i < 5; i++)
        if (!strstr(words, expected[i]))
            fail_msg("%s is not in %s", expected[i], words);
    lf_free(raw);
    lf_free(words);
    qr_succeed("%s -o %s/v.mp4 --turntable 3 --codec h265 --pixel-format yuv444p " SIZE, f->scene,
               f->folder);
    words = read_text(f->folder, "words", &size);
    assert_non_null(strstr(words, "-c:v libx265 "));
    assert_non_null(strstr(words, "-pix_fmt yuv444p "));
    assert_non_null(strstr(words, "-framerate 30 "));
    lf_free(words);
}

/* An animation plays at its own speed; --fps sets another one. */
static void frames_of_a_scene_play_at_its_fps(void **state)
{
    const qr_files *f = *state;
    char script[2 * PATH_MAX], scene[PATH_MAX];
    size_t size = 0;
    snprintf(script, sizeof script, "#!/bin/sh\nprintf '%%s ' \"$@\" >%s/words\ncat >&3\n",
             f->folder);
    pretend(f, script);
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(f->folder, "slow.json",
                           "{\"include\": \"fog.json\", \"fps\": 12.5, \"camera\": {\"fov_y\": "
                           "{\"keys\": [[1, 20], [2, 30]]}}}"));
    static const char *const cases[][2] = {{"--frames 1:2", "-framerate 12.5 "},
                                           {"--frames 1:2 --fps 24", "-framerate 24 "},
                                           {"--turntable 2", "-framerate 30 "}};
    for (int i = 0; i < 3; i++) {
        qr_succeed("%s -o %s/f%d.mp4 %s " SIZE, scene, f->folder, i, cases[i][0]);
        char *words = read_text(f->folder, "words", &size);
        if (!strstr(words, cases[i][1]))
            fail_msg("%s: %s", cases[i][0], words);
        lf_free(words);
    }
}

static const char walked[] =
    "{ \"include\": \"%s\", \"camera\": { \"aspect\": 1.5, \"views\": { \"track\": { \"count\": 4, "
    "\"length\": 1 } } } }";

static void a_walk_is_a_video_of_the_views_of_one_job(void **state)
{
    const qr_files *f = *state;
    size_t n = 0, size = 0;
    char script[2 * PATH_MAX], text[PATH_MAX + sizeof walked], scene[PATH_MAX];
    qr_outcome o;
    snprintf(text, sizeof text, walked, f->scene);
    snprintf(scene, sizeof scene, "%s", lf_test_write(f->folder, "walked.json", text));
    snprintf(script, sizeof script, "#!/bin/sh\nprintf '%%s ' \"$@\" >%s/words\ncat >&3\n",
             f->folder);
    pretend(f, script);
    qr_succeed("%s -o %s/w.png --view-size 12x16 --spp 1 --quilt 4x1", scene, f->folder);
    qr_succeed("%s -o %s/w.mp4 --view-size 12x16 --spp 1 --fps 24", scene, f->folder);
    char *raw = read_text(f->folder, "w.mp4", &n);
    char *words = read_text(f->folder, "words", &size);
    lf_quilt_file quilt = {0};
    lf_error err = {0};
    lf_assert_ok(
        lf_quilt_read(lf_test_path(f->folder, "w_qs4x1a1.5.png"), NULL, 0, 0, &quilt, &err), &err);
    assert_int_equal(n, 4 * 16 * 12 * 3);
    for (int view = 0; view < 4; view++)
        for (int y = 0; y < 16; y++)
            assert_memory_equal(raw + (view * 16 + y) * 12 * 3,
                                lf_views8_row(&quilt.views8, view, y), 12 * 3);
    static const char *const expected[] = {"-video_size 12x16 ", "-framerate 24 ", ",setsar=2 "};
    for (int i = 0; i < 3; i++)
        if (!strstr(words, expected[i]))
            fail_msg("%s is not in %s", expected[i], words);
    lf_quilt_finish(&quilt);
    lf_free(raw);
    lf_free(words);
    /* an arc is none, nor is what a preset makes of it */
    qr_run(&o, "%s -o %s/v.mp4 " SIZE, f->scene, f->folder);
    qr_assert_fails(&o, 2, "a video needs --frames, --turntable, --wiggle, or");
    qr_run(&o, "%s -o %s/v.mp4 --preset portrait", scene, f->folder);
    qr_assert_fails(&o, 2, "a video needs --frames, --turntable, --wiggle, or");
}

/* What ffmpeg was given for a loop, and the words that it had. */
static uint8_t *loop(const qr_files *f, const char *scene, const char *out, const char *options,
                     size_t *out_n, char **out_words)
{
    size_t size = 0;
    char script[2 * PATH_MAX];
    snprintf(script, sizeof script, "#!/bin/sh\nprintf '%%s ' \"$@\" >%s/words\ncat >&3\n",
             f->folder);
    pretend(f, script);
    qr_succeed("%s -o %s/%s --wiggle%s", scene, f->folder, out, options);
    *out_words = read_text(f->folder, "words", &size);
    return (uint8_t *)read_text(f->folder, out, out_n);
}

/* Six views, so all of them: 0 to 5 and back to 1. */
static void a_loop_goes_there_and_back(void **state)
{
    const qr_files *f = *state;
    static const int views[] = {0, 1, 2, 3, 4, 5, 4, 3, 2, 1};
    const size_t frame = (size_t)WIDTH * HEIGHT * 3;
    size_t n = 0;
    char *words;
    lf_quilt_file quilt = {0};
    lf_error err = {0};
    lf_assert_ok(lf_quilt_read(f->quilt, NULL, 0, 0, &quilt, &err), &err);
    for (int mp4 = 0; mp4 < 2; mp4++) {
        uint8_t *raw = loop(f, f->quilt, mp4 ? "l.mp4" : "l.gif", "", &n, &words);
        assert_int_equal(n, (mp4 ? 20 : 10) * frame);
        for (size_t k = 0; k < n / frame; k++)
            for (int y = 0; y < HEIGHT; y++)
                assert_memory_equal(raw + k * frame + (size_t)y * WIDTH * 3,
                                    lf_views8_row(&quilt.views8, views[k % 10], y),
                                    (size_t)WIDTH * 3);
        assert_non_null(strstr(words, "-framerate 6 "));
        assert_non_null(strstr(words, mp4 ? "-c:v libx264 " : "-loop 0 "));
        assert_non_null(strstr(words, "scale=18:12:")); /* as the name says: a1.5 */
        lf_free(raw);
        lf_free(words);
    }
    uint8_t *raw = loop(f, f->quilt, "l.gif", " --views 3 --fps 10", &n, &words);
    assert_int_equal(n, 4 * frame);
    assert_memory_equal(raw, lf_views8_row(&quilt.views8, 2, 0), (size_t)WIDTH * 3);
    assert_non_null(strstr(words, "-framerate 10 "));
    lf_free(raw);
    lf_free(words);
    lf_quilt_finish(&quilt);
}

static void a_loop_of_a_scene_has_views_of_its_own(void **state)
{
    const qr_files *f = *state;
    size_t n = 0;
    char *words;
    uint8_t *raw = loop(f, f->scene, "s.gif", " --view-size 12x16 --spp 1", &n, &words);
    assert_int_equal(n, 46 * 12 * 16 * 3);
    assert_non_null(strstr(words, "-framerate 23 "));
    lf_free(raw);
    lf_free(words);
    raw = loop(f, f->scene, "s.mp4", " --view-size 12x16 --spp 1 --views 2", &n, &words);
    assert_int_equal(n, 2 * 2 * 12 * 16 * 3);
    lf_free(raw);
    lf_free(words);
}

static void a_failing_ffmpeg_is_one_line_and_leaves_the_file_that_was_there(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *script, *words;
    } cases[] = {
        {"#!/bin/sh\necho no such encoder >&2\necho more >&2\nexit 3\n",
         "ffmpeg: failed (exit status 3): no such encoder"},
        {"#!/bin/sh\ncat >&3\necho disk full >&2\nexit 1\n",
         "ffmpeg: failed (exit status 1): disk full"},
        {"#!/bin/sh\nkill -9 $$\n", "ffmpeg: was ended by signal 9"},
        {"#!/bin/sh\nexit 0\n", "ffmpeg: ended before the last frame"},
    };
    char scene[PATH_MAX]; /* of which there is nothing to warn */
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(f->folder, "ball.json",
                           "{\"camera\": {\"position\": [0,0,9], \"cone\": 2}, \"meshes\": "
                           "{\"ball\": {\"shape\": \"sphere\"}}, \"lights\": {\"sky\": "
                           "{\"type\": \"environment\", \"radiance\": 0.6}}}"));
    lf_test_write(f->folder, "v_qs2x2a0.75.mp4", "mine");
    pretend(f, cases[0].script);
    int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        qr_outcome o;
        size_t n = 0;
        lf_test_write(f->folder, "ffmpeg", cases[i].script);
        /* more than a pipe holds: it is noticed while frames are handed over */
        qr_run(&o, "%s -o %s/v.mp4 --turntable 3 --view-size 120x160 --views 4 --passes 1", scene,
               f->folder);
        qr_assert_fails(&o, 1, cases[i].words);
        char *text = read_text(f->folder, "v_qs2x2a0.75.mp4", &n);
        assert_string_equal(text, "mine");
        lf_free(text);
        assert_int_equal(qr_count_files(f->folder), before);
    }
}

static void without_ffmpeg_nothing_is_rendered(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    int before = qr_count_files(f->folder);
    setenv("PATH", f->folder, 1);
    qr_run(&o, "%s -o %s/v.mp4 --turntable 3 --view-size 120x160 --spp 1000000", f->scene,
           f->folder);
    qr_assert_fails(&o, 1, "ffmpeg: is not in PATH");
    assert_int_equal(qr_count_files(f->folder), before);
}

/* It is recognised by its first bytes, without ffmpeg. */
static void a_video_is_no_input(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    lf_test_write(f->folder, "in_qs1x1.gif", "GIF89a and so on");
    setenv("PATH", f->folder, 1);
    qr_run(&o, "%s/in_qs1x1.gif -o %s/o.png", f->folder, f->folder);
    qr_assert_fails(&o, 2, "is a video, which quiltd plays; take images from it with ffmpeg -i");
}

static void assert_gone(const char *pid_file)
{
    char text[32] = "";
    int fd = open(pid_file, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    qr_read_back(fd, text, sizeof text);
    assert_true(kill((pid_t)atoi(text), 0) != 0);
}

/* While it renders, while ffmpeg reads nothing, while ffmpeg does not end. */
static void a_terminated_video_leaves_nothing_within_two_seconds(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *script, *options;
    } cases[] = {
        {"#!/bin/sh\necho $$ >%s/pid\nexec cat >&3\n", "--view-size 120x160 --spp 100000"},
        {"#!/bin/sh\necho $$ >%s/pid\nexec sleep 60\n", "--view-size 120x160 --passes 1"},
        {"#!/bin/sh\ncat >&3\necho $$ >%s/pid\nexec sleep 60\n", "--view-size 12x16 --passes 1"},
    };
    char script[2 * PATH_MAX], line[3 * PATH_MAX], text[4096];
    pretend(f, "#!/bin/sh\n");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        int err = memfd_create("stderr", 0), out = memfd_create("stdout", 0);
        const char *rest = strstr(cases[i].script, "%s");
        snprintf(script, sizeof script, "%.*s%s%s", (int)(rest - cases[i].script), cases[i].script,
                 f->folder, rest + 2);
        lf_test_write(f->folder, "ffmpeg", script);
        int before = qr_count_files(f->folder);
        snprintf(line, sizeof line, "%s -o %s/v.mp4 --turntable 3 --views 4 %s", f->scene,
                 f->folder, cases[i].options);
        pid_t pid = qr_start(line, out, err, RLIM_INFINITY);
        const char *pid_file = lf_test_path(f->folder, "pid");
        for (int k = 0; k < 2000 && access(pid_file, F_OK) != 0; k++)
            qr_nap(0.01);
        qr_nap(0.3);
        double begun = lf_time_now();
        kill(pid, i == 1 ? SIGINT : SIGTERM);
        assert_int_equal(qr_ended(pid), 1);
        assert_true(lf_time_now() - begun < 2);
        qr_read_back(err, text, sizeof text);
        close(out);
        assert_non_null(strstr(text, "interrupted: nothing was written"));
        assert_gone(pid_file);
        assert_int_equal(unlink(pid_file), 0);
        assert_int_equal(qr_count_files(f->folder), before);
    }
}

/* ------------------------------------------------------------------------------ the real one -- */

static bool is_installed(const char *program)
{
    char command[64];
    snprintf(command, sizeof command, "%s -version >/dev/null 2>&1", program);
    return system(command) == 0; /* NOLINT(cert-env33-c): a test */
}

/* What a program prints. */
static void ask(char *out, size_t size, const char *fmt, ...) LF_PRINTF(3, 4);
static void ask(char *out, size_t size, const char *fmt, ...)
{
    char line[4 * PATH_MAX];
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    FILE *pipe = popen(line, "re"); /* NOLINT(cert-env33-c): a test */
    assert_non_null(pipe);
    out[fread(out, 1, size - 1, pipe)] = '\0';
    assert_int_equal(pclose(pipe), 0);
}

static void a_real_video_has_the_frames_in_the_right_colours(void **state)
{
    const qr_files *f = *state;
    char text[512], scene[PATH_MAX];
    if (!is_installed("ffmpeg") || !is_installed("ffprobe")) {
        print_message("ffmpeg is not installed\n");
        skip();
    }
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(f->folder, "red.json", lf_test_scene_text("red-wall")));
    qr_succeed("%s -o %s/p.png --turntable 8 --frames 1:3 --spp 16 --views 4 --view-size 48x64",
               scene, f->folder);
    qr_succeed("%s -o %s/v.mp4 --turntable 8 --frames 1:3 --spp 16 --views 4 --view-size 48x64",
               scene, f->folder);
    ask(text, sizeof text,
        "ffprobe -v error -count_frames -show_entries stream=codec_name,width,height,pix_fmt,"
        "nb_read_frames,color_space -of csv=p=0 %s/v_qs2x2a0.75.mp4",
        f->folder);
    assert_string_equal(text, "h264,96,128,yuv420p,bt709,3\n");
    uint8_t video[3], picture[3];
    ask(text, sizeof text,
        "ffmpeg -v error -i %s/v_qs2x2a0.75.mp4 -frames:v 1 -vf scale=1:1 -f "
        "rawvideo -pix_fmt rgb24 - | tee %s/mean >/dev/null",
        f->folder, f->folder);
    ask(text, sizeof text,
        "ffmpeg -v error -i %s/p_0001_qs2x2a0.75.png -vf scale=1:1 -f rawvideo "
        "-pix_fmt rgb24 - | tee %s/mean8 >/dev/null",
        f->folder, f->folder);
    size_t n = 0;
    char *a = read_text(f->folder, "mean", &n), *b = read_text(f->folder, "mean8", &n);
    memcpy(video, a, 3);
    memcpy(picture, b, 3);
    lf_free(a);
    lf_free(b);
    assert_true(picture[0] > picture[1] + 60);
    for (int i = 0; i < 3; i++)
        lf_assert_close(video[i], picture[i], 0, 3);
}

static void a_real_loop_has_the_frames_and_square_pixels(void **state)
{
    const qr_files *f = *state;
    char text[512];
    size_t n = 0;
    if (!is_installed("ffmpeg") || !is_installed("ffprobe")) {
        print_message("ffmpeg is not installed\n");
        skip();
    }
    qr_succeed("%s -o %s/l.gif --wiggle", f->large, f->folder);
    qr_succeed("%s -o %s/l.mp4 --wiggle", f->quilt, f->folder);
    ask(text, sizeof text,
        "ffprobe -v error -count_frames -show_entries stream=codec_name,width,height,"
        "nb_read_frames -of csv=p=0 %s/l.gif",
        f->folder);
    assert_string_equal(text, "gif,240,160,10\n");
    ask(text, sizeof text,
        "ffprobe -v error -count_frames -show_entries stream=codec_name,width,height,pix_fmt,"
        "nb_read_frames -of csv=p=0 %s/l.mp4",
        f->folder);
    assert_string_equal(text, "h264,18,12,yuv420p,20\n");
    char *gif = read_text(f->folder, "l.gif", &n);
    assert_non_null(memmem(gif, n, "NETSCAPE2.0\x03\x01\0\0", 15)); /* for ever */
    lf_free(gif);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            ffmpeg_gets_the_pixels_of_the_pictures_and_a_file_to_write_into, set_up, tear_down),
        cmocka_unit_test_setup_teardown(frames_of_a_scene_play_at_its_fps, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_loop_goes_there_and_back, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_loop_of_a_scene_has_views_of_its_own, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_walk_is_a_video_of_the_views_of_one_job, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(
            a_failing_ffmpeg_is_one_line_and_leaves_the_file_that_was_there, set_up, tear_down),
        cmocka_unit_test_setup_teardown(without_ffmpeg_nothing_is_rendered, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_video_is_no_input, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_terminated_video_leaves_nothing_within_two_seconds,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_real_loop_has_the_frames_and_square_pixels, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_real_video_has_the_frames_in_the_right_colours, set_up,
                                        tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
