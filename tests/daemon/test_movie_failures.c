/* Whatever ffmpeg or a file does, the last frame stays and one line says why. */
#include "tests/daemon/players.h"

/* ----------------------------------------------------------------------------------- failing -- */

#define DELIVERS(n) "#!/bin/sh\nhead -c " #n " \"${0%/*}/frames.raw\"\n"
#define ONE_FRAME DELIVERS(13824)
#define STUCK "touch \"${0%/*}/stuck\"\n"
/* The mark comes after the stop, or waits would end at once while the script still runs. */
#define STOPS                                                                                      \
    "(until grep -q '^State:.T' /proc/$$/status; do sleep 0.01; done; " STUCK                      \
    ") > /dev/null 2>&1 &\nkill -STOP $$\n"

/* An ffmpeg that does something else: before the first frame the video is refused. */
static void a_bad_ffmpeg_is_told_in_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *script, *words;
        lf_status status;
    } cases[] = {
        {"#!/bin/sh\nexit 0\n", "ffmpeg ended after 0 frames; try the file with ffplay",
         LF_E_FORMAT},
        {DELIVERS(1000), "ffmpeg ended after 0 frames; try the file with ffplay", LF_E_FORMAT},
        {"#!/bin/sh\necho '[x @ 0x1] [warning] chatter' >&2\necho '[x @ 0x1] [error] no luck' >&2\n"
         "exit 3\n",
         "ffmpeg failed (exit status 3): no luck", LF_E_FORMAT},
        {"#!/bin/sh\nkill -9 $$\n", "ffmpeg was ended by signal 9", LF_E_FORMAT},
        {"#!/bin/sh\n" STUCK "exec sleep 1000\n",
         "ffmpeg has done nothing for 20 s; try the file with ffplay", LF_E_TIMEOUT},
        {"#!/bin/sh\n" STOPS,
         "ffmpeg has been stopped (signal 19) for 60 s, so the video is abandoned", LF_E_TIMEOUT},
    };
    const int before = count_descriptors();
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_make(folder, "v.mp4", 3, 10, MOVIE_LOSSLESS));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_player *player;
        lf_error err;
        install("ffmpeg", cases[i].script);
        lf_assert_status(open_tiles(path, 3, 2, NULL, &player, &err), cases[i].status, &err);
        assert_string_equal(err.where, path);
        assert_string_equal(err.what, cases[i].words);
        assert_no_child();
        uninstall("ffmpeg");
    }
    assert_int_equal(count_descriptors(), before);
}

/* An ffprobe that hangs holds the loads of others for a while only. */
static void an_ffprobe_that_hangs_is_abandoned(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_make(folder, "v.mp4", 3, 10, MOVIE_LOSSLESS));
    install("ffprobe", "#!/bin/sh\n" STUCK "exec sleep 1000\n");
    lf_assert_status(open_tiles(path, 3, 2, NULL, &player, &err), LF_E_TIMEOUT, &err);
    assert_string_equal(err.where, path);
    assert_string_equal(err.what, "ffprobe has done nothing for 20 s; try the file with ffplay");
    uninstall("ffprobe");
    assert_no_child();
}

/* Later the last frame stays. */
static void the_last_frame_stays_when_ffmpeg_fails(void **state)
{
    (void)state;
    static const struct {
        const char *script, *words;
        lf_status status;
    } cases[] = {
        {ONE_FRAME "kill -9 $$\n", "ffmpeg was ended by signal 9", LF_E_IO},
        {ONE_FRAME "echo '[fatal] it broke' >&2\nexit 1\n",
         "ffmpeg failed (exit status 1): it broke", LF_E_IO},
        {DELIVERS(14000), "ffmpeg ended after 1 frames; try the file with ffplay", LF_E_IO},
        {ONE_FRAME STUCK "exec sleep 1000\n",
         "ffmpeg has delivered nothing for 60 s; try the file with ffplay", LF_E_TIMEOUT},
        {ONE_FRAME STOPS, "ffmpeg has been stopped (signal 19) for 60 s, so the video is abandoned",
         LF_E_TIMEOUT},
    };
    const int before = count_descriptors();
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_make(folder, "v.mp4", 3, 10, MOVIE_LOSSLESS));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_views8 views;
        install("ffmpeg", cases[i].script);
        lf_player *player = play(path, false);
        assert_true(lf_player_take(player, &views));
        const lf_player_status now = await_failure(player);
        assert_string_equal(now.err.where, path);
        assert_string_equal(now.err.what, cases[i].words);
        lf_assert_status(now.err.status, cases[i].status, &now.err);
        assert_int_equal(differences(&views, 0), 0);
        lf_player_destroy(player);
        assert_no_child();
        uninstall("ffmpeg");
    }
    assert_int_equal(count_descriptors(), before);
}

/* An ffmpeg that a signal has stopped is ended at once with its player. */
static void a_stopped_ffmpeg_delays_no_end(void **state)
{
    (void)state;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_make(folder, "v.mp4", 3, 10, MOVIE_LOSSLESS));
    install("ffmpeg", ONE_FRAME "kill -STOP $$\n");
    lf_player_destroy(play(path, false));
    uninstall("ffmpeg");
    assert_no_child();
}

/* More frames than the pipe holds come before the change. */
static void a_video_that_changes_its_size_stops(void **state)
{
    (void)state;
    movie_run(folder,
              MOVIE_FFMPEG "-f lavfi -i testsrc2=s=72x64:r=10 -frames:v 120 -c:v libx264 -bf 0 "
                           "a.264 && " MOVIE_FFMPEG
                           "-f lavfi -i testsrc2=s=96x96:r=10 -frames:v 3 -c:v libx264 -bf 0 "
                           "b.264 && cat a.264 b.264 > ab.264 && " MOVIE_FFMPEG
                           "-r 10 -i ab.264 -c copy size.mkv 2> /dev/null");
    lf_player *player = play(lf_test_path(folder, "size.mkv"), false);
    lf_player_status now = status_of(player);
    for (int i = 0; i < PATIENCE_S * 500 && !now.failed; i++, nap()) {
        advance(0.1);
        now = status_of(player);
    }
    assert_true(now.failed);
    lf_assert_status(now.err.status, LF_E_FORMAT, &now.err);
    assert_non_null(strstr(now.err.what, "its pictures change their size or format after frame"));
    assert_true(now.due <= 120);
    lf_player_destroy(player);
}

/* Half a file: what is there is played, in a loop, and the log tells of it. */
static void a_video_that_ends_early_plays_what_is_there(void **state)
{
    (void)state;
    struct stat st;
    const char *path = movie_make(folder, "whole.mkv", 40, 10, "-c:v ffv1 -pix_fmt bgr0 -g 1");
    assert_int_equal(stat(path, &st), 0);
    assert_int_equal(truncate(path, st.st_size / 4), 0);
    lf_player *player = play(path, false);
    int64_t rounds = 0;
    while (rounds == 0) {
        const lf_player_status now = status_of(player);
        assert_false(now.failed);
        rounds = now.rounds;
        advance(0.05);
        nap();
    }
    lf_player_destroy(player);
}

/* A list of files under a video's name opens none of them. */
static void lists_of_files_are_no_videos(void **state)
{
    (void)state;
    static const char *const lists[] = {
        "ffconcat version 1.0\nfile other.mp4\n",
        "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nother.mp4\n#EXT-X-ENDLIST\n",
        "",
    };
    (void)movie_make(folder, "other.mp4", 3, 10, MOVIE_LOSSLESS);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        lf_player *player;
        lf_error err;
        const char *path = lf_test_write(folder, "list.mp4", lists[i]);
        lf_assert_status(open_tiles(path, 3, 2, NULL, &player, &err), LF_E_FORMAT, &err);
        assert_non_null(strstr(err.what, "is not a video"));
    }
}

/* The magic of MP4 before something that is none. */
static void a_video_that_cannot_be_read_is_told_in_ffmpegs_words(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    static const char head[] = {0, 0, 0, 24, 'f', 't', 'y', 'p', 'i', 's', 'o', 'm'};
    const char *path = lf_test_path(folder, "bad.mp4");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(head, 1, sizeof head, file), sizeof head);
    for (int i = 0; i < 5000; i++)
        fputc(i * 7 % 251, file);
    assert_int_equal(fclose(file), 0);
    lf_assert_status(open_tiles(path, 3, 2, NULL, &player, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "is not a video that ffmpeg can read: "));
    assert_null(strchr(err.what, '['));
}

static void without_tiles_the_name_is_refused(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    const char *path = movie_make(folder, "v.mp4", 1, 10, MOVIE_LOSSLESS);
    lf_assert_status(open_tiles(path, 0, 0, NULL, &player, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "no quilt suffix such as _qs8x6a0.75"));
    lf_assert_status(open_tiles(path, 64, 65, NULL, &player, &err), LF_E_FORMAT, &err);
    assert_string_equal(err.what, "72x64 pixels are too few for 64x65 views");
    const char *named = movie_make(folder, "v_qs3x2a0.75.mp4", 1, 10, MOVIE_LOSSLESS);
    lf_assert_ok(open_tiles(named, 0, 0, NULL, &player, &err), &err);
    assert_int_equal(lf_player_movie(player)->layout.n_views, 6);
    lf_assert_close(lf_player_movie(player)->layout.aspect, 0.75, 1e-12, 0);
    lf_player_destroy(player);
}

static void without_ffmpeg_the_package_is_named(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_make(folder, "v.mp4", 1, 10, MOVIE_LOSSLESS));
    setenv("PATH", "/nowhere", 1);
    lf_status status = open_tiles(path, 3, 2, NULL, &player, &err);
    setenv("PATH", path_before, 1);
    lf_assert_status(status, LF_E_IO, &err);
    assert_string_equal(err.where, "ffprobe");
    assert_string_equal(err.what, "is not in PATH; install the package ffmpeg, which plays videos");
}

/* It may read what it was given, and nothing of ours: its words, descriptors, limits and
 * environment, which a script writes to its messages. */
static void ffmpeg_gets_the_file_and_nothing_else(void **state)
{
    (void)state;
    static const struct {
        const char *command, *words;
    } cases[] = {
        {"echo $* | grep -o -e '-protocol_whitelist file -f mov -i /dev/fd/3'",
         "-protocol_whitelist file -f mov -i /dev/fd/3"},
        {"readlink /proc/$$/fd/3 | sed 's,.*/,,'", "v.mp4"},
        {"for i in 4 5 6 7 8 9; do [ -e /proc/$$/fd/$i ] && echo \"$i is open\"; done; echo none",
         "none"},
        {"echo \"file $(ulimit -f) core $(ulimit -c) open $(ulimit -n)\"",
         "file 128 core 0 open 64"},
        {"echo secret=$SECRET home=$HOME", "secret= home="},
    };
    lf_player *player;
    lf_error err;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_make(folder, "v.mp4", 1, 10, MOVIE_LOSSLESS));
    setenv("SECRET", "of-the-daemon", 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char script[1024], expected[256];
        snprintf(script, sizeof script, "#!/bin/sh\n{ %s; } >&2\nexit 9\n", cases[i].command);
        snprintf(expected, sizeof expected, "ffmpeg failed (exit status 9): %s", cases[i].words);
        install("ffmpeg", script);
        lf_assert_status(open_tiles(path, 3, 2, NULL, &player, &err), LF_E_FORMAT, &err);
        assert_string_equal(err.what, expected);
        uninstall("ffmpeg");
    }
    unsetenv("SECRET");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bad_ffmpeg_is_told_in_one_line),
        cmocka_unit_test(an_ffprobe_that_hangs_is_abandoned),
        cmocka_unit_test(the_last_frame_stays_when_ffmpeg_fails),
        cmocka_unit_test(a_stopped_ffmpeg_delays_no_end),
        cmocka_unit_test(a_video_that_changes_its_size_stops),
        cmocka_unit_test(a_video_that_ends_early_plays_what_is_there),
        cmocka_unit_test(lists_of_files_are_no_videos),
        cmocka_unit_test(a_video_that_cannot_be_read_is_told_in_ffmpegs_words),
        cmocka_unit_test(without_tiles_the_name_is_refused),
        cmocka_unit_test(without_ffmpeg_the_package_is_named),
        cmocka_unit_test(ffmpeg_gets_the_file_and_nothing_else),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
