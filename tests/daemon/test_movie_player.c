/* Videos by a clock that the test sets: frames in order and to the byte, each due once, shown or
 * dropped; and whatever ffmpeg does, the last frame stays and one line says why. */
#include "tests/daemon/movies.h"

#include <dirent.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "base/log.h"
#include "base/thread.h"
#include "daemon/media/player.h"

/* A machine under a sanitizer may be slow. */
#define PATIENCE_S 600
#define FRAME_BYTES (3 * MOVIE_WIDTH * MOVIE_HEIGHT)

static const char *folder;
static char *path_before;

/* ------------------------------------------------------------------------- clock and waiting -- */

static _Atomic uint64_t clock_ns = 1000;

/* A script has got stuck: waits end at once, with nothing. */
static bool is_stuck(void)
{
    return access(lf_test_path(folder, "stuck"), F_OK) == 0;
}

uint64_t __wrap_lf_time_now_ns(void);
uint64_t __wrap_lf_time_now_ns(void)
{
    return atomic_load(&clock_ns);
}

int __real_ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout,
                 const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout,
                 const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout, const sigset_t *mask)
{
    const struct timespec soon = {.tv_nsec = 20000};
    return __real_ppoll(fds, n, is_stuck() ? &soon : timeout, mask);
}

int __real_poll(struct pollfd *fds, nfds_t n, int timeout);
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout);
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout)
{
    return __real_poll(fds, n, is_stuck() ? 0 : timeout);
}

static void advance(double seconds)
{
    atomic_fetch_add(&clock_ns, (uint64_t)llround(seconds * 1e9));
}

static void nap(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
}

static lf_player_status status_of(lf_player *player)
{
    lf_player_status now;
    lf_player_get_status(player, &now);
    return now;
}

/* Until n frames were due. */
static lf_player_status await_due(lf_player *player, uint64_t n)
{
    lf_player_status now = status_of(player);
    for (int i = 0; i < PATIENCE_S * 500 && now.due < n && !now.failed; i++, nap())
        now = status_of(player);
    assert_false(now.failed);
    assert_int_equal(now.due, n);
    return now;
}

static lf_player_status await_failure(lf_player *player)
{
    lf_player_status now = status_of(player);
    for (int i = 0; i < PATIENCE_S * 500 && !now.failed; i++, nap())
        now = status_of(player);
    assert_true(now.failed);
    return now;
}

/* -------------------------------------------------------------------------------- a fixture -- */

static _Atomic int n_news;

static void on_news(void *context)
{
    (void)context;
    atomic_fetch_add(&n_news, 1);
}

static lf_status open_tiles(const char *path, int columns, int rows, const lf_photo *photo,
                            lf_player **out, lf_error *err)
{
    const lf_photo plain = {0};
    return lf_player_create(path, NULL, columns, rows, photo ? photo : &plain, NULL, out, err);
}

static lf_player *play(const char *path, bool once)
{
    lf_player *player;
    lf_error err;
    lf_assert_ok(open_tiles(path, 3, 2, NULL, &player, &err), &err);
    lf_player_set_once(player, once);
    lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
    return player;
}

/* Differences of these views from a frame of movies.h. */
static int differences(const lf_views8 *views, int frame)
{
    int n = 0;
    for (int v = 0; v < views->n_views; v++) {
        for (int y = 0; y < views->height; y++) {
            const uint8_t *row = lf_views8_row(views, v, y);
            for (int x = 0; x < views->width; x++) {
                uint8_t rgb[3];
                movie_pixel(frame, v % MOVIE_COLUMNS * MOVIE_VIEW_WIDTH + x,
                            (MOVIE_ROWS - 1 - v / MOVIE_COLUMNS) * MOVIE_VIEW_HEIGHT + y, rgb);
                n += memcmp(rgb, row + 3 * x, 3) != 0;
            }
        }
    }
    return n;
}

static void assert_takes(lf_player *player, int frame)
{
    lf_views8 views;
    assert_true(lf_player_take(player, &views));
    assert_int_equal(views.n_views, 6);
    assert_int_equal(views.width, MOVIE_VIEW_WIDTH);
    assert_int_equal(views.height, MOVIE_VIEW_HEIGHT);
    assert_int_equal(differences(&views, frame), 0);
    assert_int_not_equal(differences(&views, frame + 1), 0);
}

static int count_descriptors(void)
{
    DIR *dir = opendir("/proc/self/fd");
    int n = 0;
    assert_non_null(dir);
    while (readdir(dir))
        n++;
    closedir(dir);
    return n;
}

static void assert_no_child(void)
{
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
}

/* ----------------------------------------------------------------------------------- playing -- */

/* Two rounds and a half, also for a video that is shorter than ffmpeg's start takes. */
static void frames_come_in_order_and_to_the_byte(void **state)
{
    (void)state;
    const int before = count_descriptors();
    const char *path = movie_make(folder, "v.mp4", 12, 10, MOVIE_LOSSLESS);
    lf_player *player = play(path, false);
    lf_player_status now = status_of(player);
    assert_int_equal(now.width, MOVIE_WIDTH);
    assert_int_equal(now.height, MOVIE_HEIGHT);
    lf_assert_close(now.fps, 10, 1e-12, 0);
    lf_assert_close(now.duration, 1.2, 1e-9, 0);
    for (int k = 0; k < 30; k++) {
        now = await_due(player, (uint64_t)k + 1);
        assert_int_equal(now.frame, k % 12);
        assert_int_equal(now.rounds, k / 12);
        lf_assert_close(now.seconds, k % 12 / 10.0, 1e-9, 1e-12);
        assert_takes(player, k % 12);
        lf_views8 views;
        assert_false(lf_player_take(player, &views)); /* only once */
        advance(0.1);
    }
    now = status_of(player);
    assert_int_equal(now.dropped, 0);
    assert_true(atomic_load(&n_news) >= 29);
    lf_player_destroy(player);
    assert_no_child();
    assert_int_equal(count_descriptors(), before);
}

static void a_frame_is_not_shown_before_its_time(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 5, 10, MOVIE_LOSSLESS), false);
    lf_views8 views;
    assert_takes(player, 0);
    advance(0.0999);
    for (int i = 0; i < 100; i++, nap())
        assert_false(lf_player_take(player, &views));
    advance(0.0001);
    (void)await_due(player, 2);
    assert_takes(player, 1);
    lf_player_destroy(player);
}

static void frames_that_nobody_takes_are_dropped_and_the_newest_wins(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 12, 10, MOVIE_LOSSLESS), false);
    for (uint64_t k = 1; k < 6; k++) {
        advance(0.1);
        (void)await_due(player, k + 1);
    }
    assert_takes(player, 5);
    const lf_player_status now = status_of(player);
    assert_int_equal(now.due, 6);
    assert_int_equal(now.taken, 1);
    assert_int_equal(now.dropped, 5);
    lf_player_destroy(player);
}

static void late_frames_are_dropped_and_counted(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 12, 10, MOVIE_LOSSLESS), false);
    assert_takes(player, 0);
    advance(0.5); /* frames 1 to 5 are due */
    lf_player_status now = await_due(player, 6);
    assert_takes(player, 5);
    now = status_of(player);
    assert_int_equal(now.taken, 2);
    assert_int_equal(now.dropped, 4);
    /* then it is in time again */
    advance(0.1);
    (void)await_due(player, 7);
    assert_takes(player, 6);
    lf_player_destroy(player);
}

static void the_last_frame_stays_if_it_plays_once(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 3, 10, MOVIE_LOSSLESS), true);
    for (int k = 0; k < 3; k++) {
        (void)await_due(player, (uint64_t)k + 1);
        assert_takes(player, k);
        assert_false(status_of(player).ended);
        advance(0.1);
    }
    for (int i = 0; i < PATIENCE_S * 500 && !status_of(player).ended; i++, nap())
        ;
    const lf_player_status now = status_of(player);
    assert_true(now.ended);
    assert_int_equal(now.rounds, 1);
    assert_int_equal(now.frame, 2);
    assert_int_equal(now.due, 3);
    assert_no_child(); /* it needs no ffmpeg any more */
    lf_player_destroy(player);
}

static void a_video_of_one_frame_is_a_picture(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 1, 10, MOVIE_LOSSLESS), false);
    assert_takes(player, 0);
    advance(3);
    for (int i = 0; i < PATIENCE_S * 500 && !status_of(player).ended; i++, nap())
        ;
    assert_int_equal(status_of(player).due, 1);
    assert_int_equal(status_of(player).rounds, 1);
    assert_no_child();
    lf_player_destroy(player);
}

static void a_pause_holds_the_frame_and_the_clock(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 5, 10, MOVIE_LOSSLESS), false);
    lf_views8 views;
    assert_takes(player, 0);
    lf_player_pause(player, true);
    advance(100);
    for (int i = 0; i < 100; i++, nap())
        assert_false(lf_player_take(player, &views));
    assert_true(status_of(player).paused);
    lf_player_pause(player, false);
    advance(0.1);
    (void)await_due(player, 2);
    assert_takes(player, 1);
    assert_int_equal(status_of(player).dropped, 0);
    lf_player_destroy(player);
}

/* A player that is paused before its start shows its first frame. */
static void it_may_start_paused(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    lf_views8 views;
    const char *path = movie_make(folder, "v.mp4", 5, 10, MOVIE_LOSSLESS);
    lf_assert_ok(open_tiles(path, 3, 2, NULL, &player, &err), &err);
    lf_player_pause(player, true);
    lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
    assert_takes(player, 0);
    advance(1);
    for (int i = 0; i < 50; i++, nap())
        assert_false(lf_player_take(player, &views));
    lf_player_destroy(player);
}

/* Its frames come at the mean rate; each is there as long as it was. */
static void a_variable_rate_becomes_a_steady_one(void **state)
{
    (void)state;
    movie_write_raw(folder, "frames.raw", 0, 4, MOVIE_WIDTH, MOVIE_HEIGHT);
    movie_run(folder,
              MOVIE_FFMPEG "-f rawvideo -pix_fmt rgb24 -s %dx%d -r 10 -i frames.raw "
                           "-vf \"setpts='if(lt(N,2),N,N+4)/10/TB'\" -vsync vfr " MOVIE_LOSSLESS
                           " vfr.mp4",
              MOVIE_WIDTH, MOVIE_HEIGHT);
    lf_player *player = play(lf_test_path(folder, "vfr.mp4"), true);
    const double fps = status_of(player).fps;
    assert_true(fps > 3 && fps < 6);
    int last = 0;
    bool seen[4] = {true};
    assert_takes(player, 0);
    while (!status_of(player).ended) {
        lf_views8 views;
        if (!lf_player_take(player, &views)) {
            advance(0.01);
            nap();
            continue;
        }
        int frame = last;
        while (frame < 4 && differences(&views, frame) != 0)
            frame++;
        assert_true(frame < 4); /* never backwards */
        seen[frame] = true;
        last = frame;
    }
    assert_true(seen[1] && seen[3]);
    lf_player_destroy(player);
}

/* ------------------------------------------------------------------------------------ shapes -- */

/* As a picture of this size: the padding at the right and at the top is left out, with a note. */
static void padding_is_left_out_as_of_pictures(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    lf_views8 views;
    char line[512];
    size_t at = 0;
    movie_write_raw(folder, "frames.raw", 3, 1, 74, 65);
    movie_run(folder, MOVIE_FFMPEG "-f rawvideo -pix_fmt rgb24 -s 74x65 -r 10 -i frames.raw "
                                   "-c:v ffv1 -pix_fmt bgr0 odd.mkv");
    lf_assert_ok(open_tiles(lf_test_path(folder, "odd.mkv"), 3, 2, NULL, &player, &err), &err);
    assert_true(lf_image_notes_next(&lf_player_movie(player)->notes, &at, line, sizeof line));
    assert_string_equal(line, "74x65 pixels are no multiple of 3x2 views; 2 columns at the right "
                              "and 1 rows at the top are left out");
    lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
    assert_true(lf_player_take(player, &views));
    uint8_t rgb[3];
    movie_pixel(3, 0, 33, rgb); /* view 0: bottom left */
    assert_memory_equal(lf_views8_row(&views, 0, 0), rgb, 3);
    movie_pixel(3, 71, 32, rgb); /* last view: top right */
    assert_memory_equal(lf_views8_row(&views, 5, 31) + 3 * 23, rgb, 3);
    lf_player_destroy(player);
}

/* The same pixels as a picture that is read with the same options. */
static void assert_as_picture(const char *video, const char *picture, const lf_photo *photo)
{
    lf_player *player;
    lf_quilt_file quilt;
    lf_error err;
    lf_views8 views;
    lf_assert_ok(open_tiles(video, 3, 2, photo, &player, &err), &err);
    lf_assert_ok(lf_quilt_read_photo(picture, NULL, 3, 2, photo, &quilt, &err), &err);
    lf_photo_cut(photo, &quilt);
    lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
    assert_true(lf_player_take(player, &views));
    const lf_layout *layout = &lf_player_movie(player)->layout;
    assert_int_equal(layout->columns, quilt.layout.columns);
    assert_int_equal(layout->view_width, quilt.layout.view_width);
    assert_int_equal(layout->view_height, quilt.layout.view_height);
    lf_assert_close(layout->aspect, quilt.layout.aspect, 1e-9, 0);
    assert_int_equal(views.n_views, quilt.views8.n_views);
    assert_int_equal(views.width, quilt.views8.width);
    assert_int_equal(views.height, quilt.views8.height);
    for (int v = 0; v < views.n_views; v++)
        for (int y = 0; y < views.height; y++)
            assert_memory_equal(lf_views8_row(&views, v, y), lf_views8_row(&quilt.views8, v, y),
                                (size_t)views.width * 3);
    lf_quilt_finish(&quilt);
    lf_player_destroy(player);
}

static void views_are_rotated_and_cut_as_of_pictures(void **state)
{
    (void)state;
    static const lf_photo photos[] = {{.rotate = LF_TURN_NONE},
                                      {.rotate = LF_TURN_90},
                                      {.rotate = LF_TURN_180},
                                      {.rotate = LF_TURN_270},
                                      {.rotate = LF_TURN_AUTO, .frame = 1.5},
                                      {.mode = LF_PHOTO_FILL, .frame = 0.6},
                                      {.mode = LF_PHOTO_FILL, .frame = 1.2, .rotate = LF_TURN_90}};
    char video[PATH_MAX], picture[PATH_MAX];
    snprintf(video, sizeof video, "%s", movie_make(folder, "v.mp4", 1, 10, MOVIE_LOSSLESS));
    snprintf(picture, sizeof picture, "%s", movie_frame_png(folder, "p.png", 0));
    for (size_t i = 0; i < sizeof photos / sizeof photos[0]; i++)
        assert_as_picture(video, picture, &photos[i]);
}

/* A camera's word about its own orientation applies to the whole picture. */
static void a_rotated_video_is_upright(void **state)
{
    (void)state;
    lf_player *player;
    lf_error err;
    lf_views8 views;
    (void)movie_make(folder, "v.mp4", 1, 10, MOVIE_LOSSLESS);
    movie_run(folder, MOVIE_FFMPEG "-i v.mp4 -c copy -metadata:s:v:0 rotate=270 r.mp4 2> /dev/null "
                                   "|| true");
    lf_assert_ok(open_tiles(lf_test_path(folder, "r.mp4"), 1, 1, NULL, &player, &err), &err);
    if (lf_player_movie(player)->info.orientation == 1) {
        print_message("this ffmpeg writes no rotation in this way\n");
        lf_player_destroy(player);
        skip();
    }
    const int orientation = lf_player_movie(player)->info.orientation;
    lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
    assert_true(lf_player_take(player, &views));
    assert_int_equal(views.width, MOVIE_HEIGHT);
    assert_int_equal(views.height, MOVIE_WIDTH);
    uint8_t rgb[3];
    movie_pixel(0, orientation == 6 ? 0 : MOVIE_WIDTH - 1, orientation == 6 ? MOVIE_HEIGHT - 1 : 0,
                rgb); /* its top left corner */
    assert_memory_equal(views.data, rgb, 3);
    lf_player_destroy(player);
}

/* ----------------------------------------------------------------------------------- colours -- */

/* Constants of a matrix: luma of red and blue. */
typedef struct colours {
    const char *name;
    double red, blue;
} colours;

/* The codes of a colour, and the colour of codes. */
static void encode(const colours *c, bool full, const double rgb[3], uint8_t yuv[3])
{
    const double y = c->red * rgb[0] + (1 - c->red - c->blue) * rgb[1] + c->blue * rgb[2],
                 chroma[2] = {(rgb[2] - y) / (2 * (1 - c->blue)),
                              (rgb[0] - y) / (2 * (1 - c->red))};
    yuv[0] = (uint8_t)lround(full ? 255 * y : 16 + 219 * y);
    for (int k = 0; k < 2; k++)
        yuv[1 + k] = (uint8_t)fmin(255, round(128 + (full ? 255 : 224) * chroma[k]));
}

static void decode(const colours *c, bool full, const uint8_t yuv[3], double rgb[3])
{
    const double y = full ? yuv[0] / 255.0 : (yuv[0] - 16) / 219.0,
                 cb = (yuv[1] - 128) / (full ? 255.0 : 224.0),
                 cr = (yuv[2] - 128) / (full ? 255.0 : 224.0);
    rgb[0] = y + 2 * (1 - c->red) * cr;
    rgb[2] = y + 2 * (1 - c->blue) * cb;
    rgb[1] = (y - c->red * rgb[0] - c->blue * rgb[2]) / (1 - c->red - c->blue);
}

enum { SIDE = 16 }; /* patches beside each other, and above */

/* Writes patches of 8x8 pixels as planes of 4:2:0. */
static void write_patches(const colours *c, bool full, uint8_t code[SIDE * SIDE][3])
{
    FILE *file = fopen(lf_test_path(folder, "yuv.raw"), "w");
    assert_non_null(file);
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double rgb[3] = {i % 5 / 4.0, i / 5 % 5 / 4.0, i / 25 % 5 / 4.0};
        encode(c, full, rgb, code[i]);
    }
    for (int plane = 0; plane < 3; plane++) {
        const int side = plane == 0 ? 8 : 4;
        for (int y = 0; y < SIDE * side; y++)
            for (int x = 0; x < SIDE * side; x++)
                fputc(code[y / side * SIDE + x / side][plane], file);
    }
    assert_int_equal(fclose(file), 0);
}

/* The largest difference between the middles of the patches and a standard, in codes. */
static double colour_error(const lf_views8 *views, const colours *c, bool full,
                           uint8_t code[SIDE * SIDE][3])
{
    double most = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const uint8_t *got =
            lf_views8_row(views, 0, i / SIDE * 8 + 4) + (size_t)(3 * (i % SIDE * 8 + 4));
        double rgb[3];
        decode(c, full, code[i], rgb);
        for (int k = 0; k < 3; k++)
            most = fmax(most, fabs(got[k] - 255 * fmin(1, fmax(0, rgb[k]))));
    }
    return most;
}

/* ffmpeg's fast conversion is within three codes; another matrix or range is off by many. */
static void colours_are_those_of_the_standards(void **state)
{
    (void)state;
    static const colours standards[] = {{"bt709", 0.2126, 0.0722}, {"smpte170m", 0.299, 0.114}};
    for (int i = 0; i < 4; i++) {
        const colours *c = &standards[i / 2], *other = &standards[1 - i / 2];
        const bool full = i % 2;
        uint8_t code[SIDE * SIDE][3];
        lf_player *player;
        lf_error err;
        lf_views8 views;
        write_patches(c, full, code);
        movie_run(folder,
                  MOVIE_FFMPEG "-f rawvideo -pix_fmt yuv420p -s %dx%d -r 10 -i yuv.raw "
                               "-color_range %s -colorspace %s -c:v ffv1 c.mkv",
                  8 * SIDE, 8 * SIDE, full ? "pc" : "tv", c->name);
        lf_assert_ok(open_tiles(lf_test_path(folder, "c.mkv"), 1, 1, NULL, &player, &err), &err);
        lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
        assert_true(lf_player_take(player, &views));
        assert_true(colour_error(&views, c, full, code) < 4);
        assert_true(colour_error(&views, other, full, code) > 8);
        assert_true(colour_error(&views, c, !full, code) > 8);
        lf_player_destroy(player);
    }
}

/* ----------------------------------------------------------------------------------- failing -- */

static void install(const char *name, const char *script)
{
    assert_int_equal(chmod(lf_test_write(folder, name, script), 0755), 0);
}

static void uninstall(const char *name)
{
    (void)unlink(lf_test_path(folder, "stuck"));
    assert_int_equal(unlink(lf_test_path(folder, name)), 0);
}

#define DELIVERS(n) "#!/bin/sh\nhead -c " #n " \"${0%/*}/frames.raw\"\n"
#define ONE_FRAME DELIVERS(13824)
#define STUCK "touch \"${0%/*}/stuck\"\n"

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
         "ffmpeg has delivered nothing for 60 s; try the file with ffplay", LF_E_TIMEOUT},
        {"#!/bin/sh\n" STUCK "kill -STOP $$\n",
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
        {ONE_FRAME STUCK "kill -STOP $$\n",
         "ffmpeg has been stopped (signal 19) for 60 s, so the video is abandoned", LF_E_TIMEOUT},
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

static void a_video_that_changes_its_size_stops(void **state)
{
    (void)state;
    movie_run(folder,
              MOVIE_FFMPEG "-f lavfi -i testsrc2=s=72x64:r=10 -frames:v 3 -c:v libx264 -bf 0 "
                           "a.264 && " MOVIE_FFMPEG
                           "-f lavfi -i testsrc2=s=96x96:r=10 -frames:v 3 -c:v libx264 -bf 0 "
                           "b.264 && cat a.264 b.264 > ab.264 && " MOVIE_FFMPEG
                           "-r 10 -i ab.264 -c copy size.mkv 2> /dev/null");
    lf_player *player = play(lf_test_path(folder, "size.mkv"), false);
    for (int k = 1; k < 3; k++) {
        advance(0.1);
        for (int i = 0; i < 20; i++)
            nap();
    }
    const lf_player_status now = await_failure(player);
    lf_assert_status(now.err.status, LF_E_FORMAT, &now.err);
    assert_non_null(strstr(now.err.what, "its pictures change their size or format after frame"));
    assert_true(now.due <= 3);
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
        {"echo /proc/$$/fd/[4-9] | sed 's,/proc/[0-9]*,,'", "/fd/[4-9]"},
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

static int set_up(void **state)
{
    char path[PATH_MAX + 8192];
    if (!movie_programs_exist()) {
        print_message("ffmpeg is not installed\n");
        return -1;
    }
    folder = *state = lf_test_folder();
    lf_log_init("test", LF_LOG_ERROR);
    signal(SIGPIPE, SIG_IGN);
    snprintf(path, sizeof path, "%s:%s", folder, getenv("PATH"));
    path_before = strdup(path);
    setenv("PATH", path, 1);
    return 0;
}

static int tear_down(void **state)
{
    free(path_before);
    return lf_test_folder_teardown(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_come_in_order_and_to_the_byte),
        cmocka_unit_test(a_frame_is_not_shown_before_its_time),
        cmocka_unit_test(frames_that_nobody_takes_are_dropped_and_the_newest_wins),
        cmocka_unit_test(late_frames_are_dropped_and_counted),
        cmocka_unit_test(the_last_frame_stays_if_it_plays_once),
        cmocka_unit_test(a_video_of_one_frame_is_a_picture),
        cmocka_unit_test(a_pause_holds_the_frame_and_the_clock),
        cmocka_unit_test(it_may_start_paused),
        cmocka_unit_test(a_variable_rate_becomes_a_steady_one),
        cmocka_unit_test(padding_is_left_out_as_of_pictures),
        cmocka_unit_test(views_are_rotated_and_cut_as_of_pictures),
        cmocka_unit_test(a_rotated_video_is_upright),
        cmocka_unit_test(colours_are_those_of_the_standards),
        cmocka_unit_test(a_bad_ffmpeg_is_told_in_one_line),
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
