/* quiltd plays quilt videos: what the panel and clients get of them, and that a bad one leaves the
 * picture. */
#include "tests/daemon/live_panel.h"
#include "tests/daemon/movies.h"
#include "tests/daemon/sender.h"

#include <dirent.h>

#define NAMED "_qs3x2a0.75"
#define LOSSY "-c:v libx264 -preset ultrafast -pix_fmt yuv444p"

static void begin_with(sender *s, const char *device)
{
    live_prepare(&s->l);
    live_start(&s->l, NULL, "--device", device ? device : s->l.sim, "--state", s->l.state,
               "--allow-path", s->l.folder, NULL);
    live_connect(&s->l, &s->c);
}

static const char *file_in(const sender *s, const char *name)
{
    return lf_test_path(s->l.folder, name);
}

/* A video of n frames in the folder. */
static void make(const sender *s, const char *name, int n, int fps)
{
    (void)movie_make(s->l.folder, name, n, fps, MOVIE_LOSSLESS);
}

static json_t *file_param(const sender *s, const char *name)
{
    return json_pack("{s:s}", "file", file_in(s, name));
}

static void load(sender *s, const char *name)
{
    assert_code(s, "scene.load", file_param(s, name), NULL, 0, 0, "");
}

static void set_paused(sender *s, bool paused)
{
    assert_int_equal(live_code(&s->c, "render.set", json_pack("{s:b}", "paused", (int)paused)), 0);
}

/* status.video as it is now. */
static json_t *video_now(sender *s)
{
    json_t *answer = live_call(&s->c, "status", NULL),
           *video = json_incref(json_object_get(json_object_get(answer, "result"), "video"));
    json_decref(answer);
    return video;
}

static json_int_t number_now(sender *s, const char *key)
{
    json_t *video = video_now(s);
    const json_int_t value = json_integer_value(json_object_get(video, key));
    assert_true(json_is_integer(json_object_get(video, key)));
    json_decref(video);
    return value;
}

/* Loads a video and pauses it at its first frame. The keys are taken over. */
static void load_held(sender *s, const char *name, json_t *keys)
{
    (void)json_object_set_new(keys, "file", json_string(file_in(s, name)));
    for (int i = 0; i < LIVE_PATIENCE_S; i++) {
        assert_code(s, "scene.load", json_incref(keys), NULL, 0, 0, "");
        set_paused(s, true);
        if (number_now(s, "frame") == 0)
            break;
    }
    json_decref(keys);
    assert_int_equal(number_now(s, "frame"), 0);
}

/* Until a number of status.video is at least this. */
static void await_number(sender *s, const char *key, json_int_t least)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && number_now(s, key) < least; i++)
        live_nap(20);
    assert_true(number_now(s, key) >= least);
}

/* Waits until every frame that was due has met its fate, and returns the number of the last. */
static json_int_t await_rest(sender *s)
{
    json_int_t frame = 0;
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20)) {
        json_t *video = video_now(s);
        frame = json_integer_value(json_object_get(video, "frame"));
        const json_int_t met = json_integer_value(json_object_get(video, "shown")) +
                               json_integer_value(json_object_get(video, "dropped"));
        json_decref(video);
        assert_true(met <= frame + 1);
        if (met == frame + 1)
            return frame;
    }
    fail_msg("frames were lost");
    return 0;
}

/* The panel shows frame k of the video to the byte, as it would show the picture. */
static void assert_panel(const sender *s, int frame)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s", movie_frame_png(s->l.folder, "frame" NAMED ".png", frame));
    live_wait_for_panel(&s->l, path);
    snprintf(path, sizeof path, "%s",
             movie_frame_png(s->l.folder, "other" NAMED ".png", frame + 1));
    assert_true(live_panel_differences(&s->l, path) > 0); /* a negative control */
}

static void the_panel_shows_the_frames_to_the_byte(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, NULL);
    make(&s, "v" NAMED ".mp4", 200, 20);
    load_held(&s, "v" NAMED ".mp4", json_object());
    live_wait(&s.c, "converged");
    assert_panel(&s, 0);
    set_paused(&s, false);
    await_number(&s, "frame", 5);
    set_paused(&s, true);
    const json_int_t frame = await_rest(&s);
    assert_true(frame >= 5 && frame < 199);
    assert_panel(&s, (int)frame);
    assert_string_equal(live_status_text(&s.c, "level"), "converged");
    lf_assert_close(live_number(&s.c, "status", NULL, "generation"), 1, 0, 0);
    json_t *video = video_now(&s);
    assert_string_equal(json_string_value(json_object_get(video, "file")),
                        file_in(&s, "v" NAMED ".mp4"));
    assert_int_equal(json_integer_value(json_object_get(video, "width")), MOVIE_WIDTH);
    assert_int_equal(json_integer_value(json_object_get(video, "height")), MOVIE_HEIGHT);
    lf_assert_close(json_number_value(json_object_get(video, "fps")), 20, 1e-9, 0);
    lf_assert_close(json_number_value(json_object_get(video, "duration")), 10, 1e-9, 0);
    lf_assert_close(json_number_value(json_object_get(video, "seconds")), (double)frame / 20, 1e-9,
                    1e-9);
    assert_true(json_is_true(json_object_get(video, "paused")));
    assert_true(json_is_null(json_object_get(video, "problem")));
    json_decref(video);
    end(&s);
}

/* A panel that takes two frames a second of a hundred. */
static void what_a_slow_panel_does_not_take_is_dropped_and_counted(void **state)
{
    (void)state;
    sender s;
    char slow[PATH_MAX];
    live_prepare(&s.l);
    snprintf(slow, sizeof slow, "%s,latency=500", s.l.sim);
    live_start(&s.l, NULL, "--device", slow, "--state", s.l.state, "--allow-path", s.l.folder,
               NULL);
    live_connect(&s.l, &s.c);
    make(&s, "v" NAMED ".mp4", 3000, 100);
    load(&s, "v" NAMED ".mp4");
    await_number(&s, "dropped", 60);
    await_number(&s, "shown", 3);
    while (!live_logged(&s.l, "most frames are dropped, because they come too fast"))
        live_nap(20);
    json_t *status = live_call(&s.c, "status", NULL);
    assert_int_equal(
        json_array_size(json_object_get(json_object_get(status, "result"), "warnings")), 1);
    json_decref(status);
    set_paused(&s, true);
    const json_int_t frame = await_rest(&s);
    assert_true(frame >= 22);
    assert_panel(&s, (int)frame); /* the newest won */
    end(&s);
}

/* The bytes of the views that are shown, as a quilt. */
static void get_frame(sender *s, uint8_t *out, size_t n)
{
    int fd = memfd_create("frame", MFD_CLOEXEC), copy = dup(fd);
    json_t *answer = call_with(s, "frame.get", json_pack("{s:s}", "format", "raw"), &fd, 1);
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(answer, "result"), "bytes")), n);
    json_decref(answer);
    assert_int_equal(pread(copy, out, n, 0), n);
    close(copy);
}

static void previews_and_exports_have_the_frame_that_is_shown(void **state)
{
    (void)state;
    sender s;
    static uint8_t expected[3 * MOVIE_WIDTH * MOVIE_HEIGHT], got[sizeof expected];
    lf_image8 image;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 200, 50);
    load(&s, "v" NAMED ".mp4");
    await_number(&s, "frame", 3);
    set_paused(&s, true);
    movie_paint((int)await_rest(&s), MOVIE_WIDTH, MOVIE_HEIGHT, expected);
    get_frame(&s, got, sizeof got);
    assert_memory_equal(got, expected, sizeof got);
    assert_int_equal(live_code(&s.c, "subscribe", json_pack("{s:[s]}", "events", "export")), 0);
    const json_int_t job = (json_int_t)live_number(
        &s.c, "export", json_pack("{s:s, s:s}", "kind", "quilt", "file", "out" NAMED ".png"),
        "job");
    assert_string_equal(live_job_end(&s.c, job), "done");
    lf_assert_ok(lf_image8_read(lf_test_path(s.l.exports, "out" NAMED ".png"), NULL, &image, NULL),
                 NULL);
    for (int y = 0; y < MOVIE_HEIGHT; y++)
        assert_memory_equal(image.data + (size_t)y * image.stride,
                            expected + (size_t)y * 3 * MOVIE_WIDTH, 3 * MOVIE_WIDTH);
    lf_image8_finish(&image);
    end(&s);
}

/* By the client's own clock, which covers more than the time between the first and the last. */
static void clients_hear_of_four_frames_a_second_at_most(void **state)
{
    (void)state;
    sender s;
    struct timespec from, to;
    int n = 0;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 100, 100);
    clock_gettime(CLOCK_MONOTONIC, &from);
    assert_int_equal(live_code(&s.c, "subscribe", json_pack("{s:[s]}", "events", "frame")), 0);
    load(&s, "v" NAMED ".mp4");
    for (; n < 6; n++) {
        json_t *message = live_receive(&s.c);
        assert_string_equal(json_string_value(json_object_get(message, "method")), "frame");
        json_decref(message);
    }
    clock_gettime(CLOCK_MONOTONIC, &to);
    const double seconds =
        (double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec);
    assert_true(n <= 1 + seconds / 0.25 + 1);
    assert_true(number_now(&s, "shown") > n);
    end(&s);
}

static void a_bad_video_leaves_the_picture(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, NULL);
    make(&s, "v" NAMED ".mp4", 3, 10);
    make(&s, "plain.mp4", 3, 10);
    load_held(&s, "v" NAMED ".mp4", json_object());
    lf_test_write(s.l.folder, "bad" NAMED ".mp4", "ffconcat version 1.0\nfile v" NAMED ".mp4\n");
    lf_test_write(s.l.folder, "text" NAMED ".webm", "no video at all");
    assert_code(&s, "scene.load", file_param(&s, "bad" NAMED ".mp4"), NULL, 0, -32002,
                "is not a video; expected MP4");
    assert_code(&s, "scene.load", file_param(&s, "text" NAMED ".webm"), NULL, 0, -32002,
                "is not a video; expected MP4");
    assert_code(&s, "scene.load", file_param(&s, "plain.mp4"), NULL, 0, -32002,
                "pass quilt=COLUMNSxROWS to scene.load");
    assert_code(&s, "time.play", json_pack("{s:i}", "to", 5), NULL, 0, -32000,
                "a video plays by itself; use render.set paused=true or false");
    assert_panel(&s, 0);
    assert_int_equal(number_now(&s, "frame"), 0);
    /* with tiles it is one */
    json_t *tiles = file_param(&s, "plain.mp4");
    (void)json_object_set_new(tiles, "quilt", json_string("1x1"));
    assert_code(&s, "scene.load", tiles, NULL, 0, 0, "");
    lf_assert_close(live_number(&s.c, "status", NULL, "views"), 1, 0, 0);
    end(&s);
}

/* The views that are shown of a file, loaded with these keys, which are taken over. */
static void get_views(sender *s, const char *name, json_t *keys, uint8_t *out, size_t n)
{
    if (lf_path_has_ending(name, ".mp4")) {
        load_held(s, name, keys);
    } else {
        (void)json_object_set_new(keys, "file", json_string(file_in(s, name)));
        assert_code(s, "scene.load", keys, NULL, 0, 0, "");
    }
    live_wait(&s->c, "converged");
    get_frame(s, out, n);
}

/* Depth, focus and zoom act on a frame as on a picture; without them it differs. */
static void frames_stand_as_pictures_do(void **state)
{
    (void)state;
    enum { N = 3 * MOVIE_WIDTH * MOVIE_HEIGHT };
    static uint8_t video[N], picture[N], plain[N];
    sender s;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 3, 10);
    (void)movie_frame_png(s.l.folder, "p" NAMED ".png", 0);
    get_views(&s, "v" NAMED ".mp4", json_pack("{s:f, s:f}", "focus", 0.04, "zoom", 1.5), video, N);
    get_views(&s, "p" NAMED ".png", json_pack("{s:f, s:f}", "focus", 0.04, "zoom", 1.5), picture,
              N);
    assert_memory_equal(video, picture, N);
    get_views(&s, "v" NAMED ".mp4", json_object(), plain, N);
    assert_memory_not_equal(video, plain, N);
    end(&s);
}

/* A video with depth at its right has the views of the same picture. */
static void a_video_with_depth_becomes_views(void **state)
{
    (void)state;
    sender s;
    live_prepare(&s.l);
    live_start(&s.l, NULL, "--device", "none", "--state", s.l.state, "--allow-path", s.l.folder,
               "--quilt", "3x2", "--views", "6", NULL);
    live_connect(&s.l, &s.c);
    enum { N = 3 * MOVIE_WIDTH * MOVIE_HEIGHT };
    static uint8_t video[N], picture[N], first[N];
    make(&s, "v.mp4", 3, 10);
    (void)movie_frame_png(s.l.folder, "p.png", 0);
    get_views(&s, "p.png", json_pack("{s:s}", "rgbd_in", "right"), picture, N);
    get_views(&s, "v.mp4", json_pack("{s:s}", "rgbd_in", "right"), video, N);
    assert_memory_equal(video, picture, N);
    while (!live_logged(&s.l, "v.mp4: the depth half has colours; it may not be depth"))
        live_nap(20); /* as that of a picture is told */
    memcpy(first, video, N);
    do { /* and its other frames move */
        set_paused(&s, false);
        live_nap(20);
        set_paused(&s, true);
    } while (number_now(&s, "frame") == 0);
    get_frame(&s, video, N);
    assert_memory_not_equal(video, first, N);
    end(&s);
}

/* It was once frozen at its first frame, and so was a slideshow. */
static void a_video_plays_though_something_was_paused_before(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 200, 20);
    set_paused(&s, true);
    load(&s, "v" NAMED ".mp4");
    await_number(&s, "frame", 2);
    set_paused(&s, false); /* of rendering, too */
    set_paused(&s, true);
    json_t *status = live_call(&s.c, "status", NULL);
    assert_true(json_is_true(json_object_get(json_object_get(status, "result"), "paused")));
    json_decref(status);
    (void)movie_frame_png(s.l.folder, "p" NAMED ".png", 0);
    load(&s, "p" NAMED ".png");
    status = live_call(&s.c, "status", NULL);
    assert_true(json_is_false(json_object_get(json_object_get(status, "result"), "paused")));
    json_decref(status);
    load(&s, "v" NAMED ".mp4");
    await_number(&s, "frame", 2);
    /* the pause of an entry is the slideshow's */
    assert_code(&s, "playlist.set",
                json_pack("{s:[{s:s, s:i}]}", "entries", "file", file_in(&s, "v" NAMED ".mp4"),
                          "seconds", 1000),
                NULL, 0, 0, "");
    assert_code(&s, "playlist.play", NULL, NULL, 0, 0, "");
    await_number(&s, "frame", 2);
    set_paused(&s, true);
    lf_assert_close(live_number(&s.c, "playlist.get", NULL, "index"), 0, 0, 0);
    json_t *list = live_call(&s.c, "playlist.get", NULL);
    assert_true(json_is_true(json_object_get(json_object_get(list, "result"), "paused")));
    json_decref(list);
    assert_code(&s, "playlist.play", json_pack("{s:i}", "index", 0), NULL, 0, 0, "");
    await_number(&s, "frame", 2);
    end(&s);
}

static void set_entries(sender *s, const char *const names[], int n)
{
    json_t *entries = json_array();
    for (int i = 0; i < n; i++)
        (void)json_array_append_new(entries, file_param(s, names[i]));
    assert_code(s, "playlist.set", json_pack("{s:o}", "entries", entries), NULL, 0, 0, "");
}

/* A video that was to play once loops when nothing follows it any more. */
static void a_video_of_the_slideshow_loops_when_it_is_alone(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 100, 50);
    (void)movie_frame_png(s.l.folder, "p" NAMED ".png", 3);
    static const char *const names[] = {"v" NAMED ".mp4", "p" NAMED ".png"};
    set_entries(&s, names, 2);
    assert_code(&s, "playlist.play", NULL, NULL, 0, 0, "");
    live_wait(&s.c, "converged");
    assert_code(&s, "playlist.pause", NULL, NULL, 0, 0, "");
    set_entries(&s, names, 1);
    assert_code(&s, "playlist.pause", json_pack("{s:b}", "paused", 0), NULL, 0, 0, "");
    await_number(&s, "shown", 120);
    /* and again, when the list stops */
    assert_code(&s, "playlist.pause", NULL, NULL, 0, 0, "");
    set_entries(&s, names, 2);
    assert_code(&s, "playlist.stop", NULL, NULL, 0, 0, "");
    await_number(&s, "shown", 240);
    end(&s);
}

/* One frame, so that it is shown as long as a picture. */
static void a_still_gif_of_the_slideshow_stands_as_a_picture(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 1, 20);
    movie_run(s.l.folder, MOVIE_FFMPEG "-i v" NAMED ".mp4 g" NAMED ".gif");
    make(&s, "w" NAMED ".mp4", 20, 20);
    static const char *const names[] = {"g" NAMED ".gif", "w" NAMED ".mp4"};
    set_entries(&s, names, 2);
    assert_code(&s, "playlist.play", NULL, NULL, 0, 0, "");
    live_wait(&s.c, "converged");
    live_nap(1000);
    json_t *video = video_now(&s);
    assert_string_equal(json_string_value(json_object_get(video, "file")),
                        file_in(&s, "g" NAMED ".gif"));
    json_decref(video);
    end(&s);
}

static void another_picture_ends_the_video(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 100, 50);
    load(&s, "v" NAMED ".mp4");
    await_number(&s, "shown", 2);
    char picture[PATH_MAX];
    snprintf(picture, sizeof picture, "%s", movie_frame_png(s.l.folder, "p" NAMED ".png", 3));
    assert_code(&s, "scene.load", json_pack("{s:s}", "file", picture), NULL, 0, 0, "");
    json_t *video = video_now(&s);
    assert_true(json_is_null(video));
    json_decref(video);
    load(&s, "v" NAMED ".mp4"); /* and back */
    await_number(&s, "shown", 2);
    end(&s);
}

/* The daemon's children that run this program. */
static int find_children(const sender *s, const char *program, pid_t *out, int most)
{
    DIR *dir = opendir("/proc");
    const struct dirent *entry;
    int n = 0;
    assert_non_null(dir);
    while ((entry = readdir(dir))) {
        char path[300], line[512] = "", name[64] = "";
        int parent = 0;
        snprintf(path, sizeof path, "/proc/%.20s/stat", entry->d_name);
        FILE *file = fopen(path, "r");
        if (file && fgets(line, sizeof line, file) &&
            sscanf(line, "%*d (%63[^)]) %*c %d", name, &parent) == 2 && parent == s->l.pid &&
            strcmp(name, program) == 0 && n < most)
            out[n++] = (pid_t)strtol(entry->d_name, NULL, 10);
        if (file)
            fclose(file);
    }
    closedir(dir);
    return n;
}

static int count_logged(const sender *s, const char *text)
{
    FILE *file = fopen(s->l.log, "r");
    char line[1024];
    int n = 0;
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        n += strstr(line, text) ? 1 : 0;
    (void)fclose(file);
    return n;
}

/* A video that fails in each round of the slideshow has one line, as an entry. */
static void a_failing_video_of_the_slideshow_has_one_line(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    movie_run(s.l.folder,
              MOVIE_FFMPEG "-f lavfi -i testsrc2=s=72x64:r=50 -frames:v 120 -c:v libx264 -bf 0 "
                           "a.264 && " MOVIE_FFMPEG
                           "-f lavfi -i testsrc2=s=96x96:r=50 -frames:v 3 -c:v libx264 -bf 0 "
                           "b.264 && cat a.264 b.264 > ab.264 && " MOVIE_FFMPEG
                           "-r 50 -i ab.264 -c copy bad" NAMED ".mkv 2> /dev/null");
    make(&s, "v" NAMED ".mp4", 4, 20);
    static const char *const names[] = {"v" NAMED ".mp4", "bad" NAMED ".mkv"};
    set_entries(&s, names, 2);
    assert_code(&s, "playlist.play", NULL, NULL, 0, 0, "");
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_number(&s.c, "status", NULL, "generation") >= 5)
            break;
    assert_true(live_number(&s.c, "status", NULL, "generation") >= 5);
    assert_int_equal(count_logged(&s, "its pictures change their size"), 1);
    end(&s);
}

static void a_killed_ffmpeg_leaves_the_last_frame_and_a_line(void **state)
{
    (void)state;
    sender s;
    pid_t pids[4];
    begin_with(&s, NULL);
    make(&s, "v" NAMED ".mp4", 3000, 20);
    load(&s, "v" NAMED ".mp4");
    await_number(&s, "shown", 2);
    assert_int_equal(find_children(&s, "ffmpeg", pids, 4), 1);
    assert_int_equal(kill(pids[0], SIGKILL), 0);
    json_t *video = video_now(&s);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && json_is_null(json_object_get(video, "problem"));
         i++) {
        json_decref(video);
        live_nap(20);
        video = video_now(&s);
    }
    assert_string_equal(json_string_value(json_object_get(video, "problem")),
                        "ffmpeg was ended by signal 9");
    json_decref(video);
    assert_panel(&s, (int)await_rest(&s));
    char line[PATH_MAX];
    snprintf(line, sizeof line, "%s: ffmpeg was ended by signal 9", file_in(&s, "v" NAMED ".mp4"));
    assert_int_equal(count_logged(&s, line), 1);
    assert_int_equal(find_children(&s, "ffmpeg", pids, 4), 0); /* no zombie */
    load(&s, "v" NAMED ".mp4");                                /* it plays again */
    await_number(&s, "shown", 2);
    end(&s);
}

/* A stopped ffmpeg delays neither another picture nor the end. */
static void a_stopped_ffmpeg_delays_nothing(void **state)
{
    (void)state;
    sender s;
    pid_t pids[4];
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 3000, 20);
    for (int i = 0; i < 2; i++) {
        load(&s, "v" NAMED ".mp4");
        await_number(&s, "shown", 2);
        assert_int_equal(find_children(&s, "ffmpeg", pids, 4), 1);
        assert_int_equal(kill(pids[0], SIGSTOP), 0);
    }
    end(&s); /* with exit status 0 */
    assert_int_equal(kill(pids[0], 0), -1);
    assert_int_equal(errno, ESRCH);
}

static void the_library_names_videos(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    make(&s, "scene/v" NAMED ".mp4", 3, 10);
    json_t *answer =
        live_call(&s.c, "library.list", json_pack("{s:s}", "folder", file_in(&s, "scene")));
    const json_t *entries = json_object_get(json_object_get(answer, "result"), "entries"), *entry;
    size_t i;
    int n = 0;
    json_array_foreach(
        entries, i,
        entry) if (strcmp(json_string_value(json_object_get(entry, "kind")), "video") == 0) n++;
    assert_int_equal(n, 1);
    json_decref(answer);
    end(&s);
}

/* A file that is encoded again while it plays. */
static void a_changed_file_is_read_again(void **state)
{
    (void)state;
    sender s;
    char video[PATH_MAX];
    live_prepare(&s.l);
    snprintf(video, sizeof video, "%s",
             movie_make(s.l.folder, "v" NAMED ".mp4", 3, 10, MOVIE_LOSSLESS));
    live_start(&s.l, video, "--device", "none", "--watch", "--state", s.l.state, NULL);
    live_connect(&s.l, &s.c);
    live_wait(&s.c, "converged");
    movie_run(s.l.folder, MOVIE_FFMPEG "-i v" NAMED ".mp4 -vf fps=5 " LOSSY
                                       " new.mp4 && mv new.mp4 v" NAMED ".mp4");
    double fps = 10; /* 0 while one video takes the place of the other */
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && (fps > 9 || fps < 1); i++, live_nap(20)) {
        json_t *now = video_now(&s);
        fps = json_number_value(json_object_get(now, "fps"));
        json_decref(now);
    }
    lf_assert_close(fps, 5, 1e-9, 0);
    lf_assert_close(live_number(&s.c, "status", NULL, "generation"), 2, 0, 0);
    end(&s);
}

static void quiltctl_tells_of_a_video(void **state)
{
    (void)state;
    sender s;
    begin_with(&s, "none");
    make(&s, "v" NAMED ".mp4", 3, 10);
    load_held(&s, "v" NAMED ".mp4", json_object());
    (void)await_rest(&s);
    assert_int_equal(live_run(&s.l, "quiltctl", "--socket", s.l.socket, "status", NULL), 0);
    assert_true(live_logged(&s.l, "  video      "));
    assert_true(
        live_logged(&s.l, "  position   0.0 of 0.3 s, frame 0 at 10 frames per second, paused"));
    assert_true(live_logged(&s.l, "  frames     1 shown, 0 dropped"));
    end(&s);
}

static int set_up(void **state)
{
    (void)state;
    if (movie_programs_exist())
        return 0;
    print_message("ffmpeg is not installed\n");
    return -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_panel_shows_the_frames_to_the_byte),
        cmocka_unit_test(what_a_slow_panel_does_not_take_is_dropped_and_counted),
        cmocka_unit_test(previews_and_exports_have_the_frame_that_is_shown),
        cmocka_unit_test(clients_hear_of_four_frames_a_second_at_most),
        cmocka_unit_test(a_bad_video_leaves_the_picture),
        cmocka_unit_test(frames_stand_as_pictures_do),
        cmocka_unit_test(a_video_with_depth_becomes_views),
        cmocka_unit_test(a_video_plays_though_something_was_paused_before),
        cmocka_unit_test(a_video_of_the_slideshow_loops_when_it_is_alone),
        cmocka_unit_test(a_still_gif_of_the_slideshow_stands_as_a_picture),
        cmocka_unit_test(another_picture_ends_the_video),
        cmocka_unit_test(a_failing_video_of_the_slideshow_has_one_line),
        cmocka_unit_test(a_killed_ffmpeg_leaves_the_last_frame_and_a_line),
        cmocka_unit_test(a_stopped_ffmpeg_delays_nothing),
        cmocka_unit_test(the_library_names_videos),
        cmocka_unit_test(a_changed_file_is_read_again),
        cmocka_unit_test(quiltctl_tells_of_a_video),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
