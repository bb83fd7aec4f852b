/* Videos by a clock that the test sets: frames in order and to the byte, each due once, shown or
 * dropped; their shapes and colours. */
#include "tests/daemon/players.h"

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
    assert_int_equal(now.dropped, 5);
    lf_player_destroy(player);
}

static void a_frame_that_was_taken_stays_as_it_is(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 12, 10, MOVIE_LOSSLESS), false);
    lf_views8 views;
    assert_true(lf_player_take(player, &views));
    for (uint64_t k = 1; k < 6; k++) {
        advance(0.1);
        (void)await_due(player, k + 1);
    }
    assert_int_equal(differences(&views, 0), 0);
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

static void await_end(lf_player *player)
{
    for (int i = 0; i < PATIENCE_S * 500 && !status_of(player).ended; i++, nap())
        ;
    assert_true(status_of(player).ended);
}

/* However long it has stood at its end, no frame of the new round is late. */
static void a_video_that_has_ended_loops_as_soon_as_it_may(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 3, 10, MOVIE_LOSSLESS), true);
    for (int k = 0; k < 3; k++) {
        (void)await_due(player, (uint64_t)k + 1);
        assert_takes(player, k);
        advance(0.1);
    }
    await_end(player);
    const uint64_t dropped = status_of(player).dropped;
    advance(50);
    lf_player_set_once(player, false);
    for (uint64_t k = 3; k < 8; k++) {
        const lf_player_status now = await_due(player, k + 1);
        assert_false(now.ended);
        assert_int_equal(now.frame, k % 3);
        assert_int_equal(now.rounds, k / 3);
        assert_takes(player, (int)(k % 3));
        advance(0.1);
    }
    assert_int_equal(status_of(player).dropped, dropped);
    lf_player_set_once(player, true);
    for (int i = 0; i < PATIENCE_S * 500 && !status_of(player).ended; i++, nap())
        advance(0.1);
    const lf_player_status now = status_of(player);
    assert_true(now.ended && !now.still);
    assert_int_equal(now.frame, 2);
    assert_no_child();
    lf_player_destroy(player);
}

/* Its ffmpeg starts more slowly than a round lasts. */
static void a_short_video_has_one_ffmpeg_for_all_rounds(void **state)
{
    (void)state;
    static const char *const names[] = {"v.mp4", "v.gif"};
    for (int i = 0; i < 2; i++) {
        (void)movie_make(folder, "v.mp4", 4, 10, MOVIE_LOSSLESS);
        movie_run(folder, MOVIE_FFMPEG "-i v.mp4 v.gif");
        install_counter();
        lf_player *player = play(lf_test_path(folder, names[i]), false);
        for (uint64_t k = 0; k < 30; k++) {
            const lf_player_status now = await_due(player, k + 1);
            assert_int_equal(now.frame, k % 4);
            assert_int_equal(now.rounds, k / 4);
            if (i == 0)
                assert_takes(player, (int)k % 4);
            else
                assert_true(lf_player_take(player, &(lf_views8){0}));
            advance(0.1);
        }
        assert_int_equal(count_starts(), 2);
        lf_player_destroy(player);
        uninstall("ffmpeg");
    }
}

/* From the second round on its length is known: its end is far when the next ffmpeg starts. */
static void a_video_of_unknown_length_has_its_next_round_ahead(void **state)
{
    (void)state;
    (void)movie_make(folder, "v.mp4", 12, 10, MOVIE_LOSSLESS);
    movie_run(folder, MOVIE_FFMPEG "-i v.mp4 -c copy -f matroska - | cat > v.mkv");
    install_counter();
    lf_player *player = play(lf_test_path(folder, "v.mkv"), false);
    lf_assert_close(status_of(player).duration, 0, 0, 0);
    for (uint64_t k = 0; k < 16; k++) {
        (void)await_due(player, k + 1);
        assert_takes(player, (int)k % 12);
        advance(k < 15 ? 0.1 : 0);
    }
    for (int i = 0; i < 10000 && count_starts() < 3; i++)
        nap();
    assert_int_equal(count_starts(), 3);
    assert_int_equal(status_of(player).dropped, 0);
    lf_player_destroy(player);
    uninstall("ffmpeg");
}

/* True if its thread sleeps on. */
static bool sleeps(void)
{
    int before = -1;
    for (int i = 0; i < 20 && before != atomic_load(&n_waits); i++) {
        before = atomic_load(&n_waits);
        for (int k = 0; k < 100; k++)
            nap();
    }
    return before == atomic_load(&n_waits);
}

static void a_player_without_work_wakes_nobody(void **state)
{
    (void)state;
    lf_player *player = play(movie_make(folder, "v.mp4", 8, 10, MOVIE_LOSSLESS), true);
    lf_player_pause(player, true);
    assert_true(sleeps());
    lf_player_pause(player, false);
    for (int i = 0; i < PATIENCE_S * 500 && !status_of(player).ended; i++, nap())
        advance(0.1);
    assert_true(sleeps());
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
    assert_true(status_of(player).still);
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
            advance(0.002); /* not faster than the player's own waits */
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_come_in_order_and_to_the_byte),
        cmocka_unit_test(a_frame_is_not_shown_before_its_time),
        cmocka_unit_test(frames_that_nobody_takes_are_dropped_and_the_newest_wins),
        cmocka_unit_test(a_frame_that_was_taken_stays_as_it_is),
        cmocka_unit_test(late_frames_are_dropped_and_counted),
        cmocka_unit_test(the_last_frame_stays_if_it_plays_once),
        cmocka_unit_test(a_video_that_has_ended_loops_as_soon_as_it_may),
        cmocka_unit_test(a_short_video_has_one_ffmpeg_for_all_rounds),
        cmocka_unit_test(a_video_of_unknown_length_has_its_next_round_ahead),
        cmocka_unit_test(a_player_without_work_wakes_nobody),
        cmocka_unit_test(a_video_of_one_frame_is_a_picture),
        cmocka_unit_test(a_pause_holds_the_frame_and_the_clock),
        cmocka_unit_test(it_may_start_paused),
        cmocka_unit_test(a_variable_rate_becomes_a_steady_one),
        cmocka_unit_test(padding_is_left_out_as_of_pictures),
        cmocka_unit_test(views_are_rotated_and_cut_as_of_pictures),
        cmocka_unit_test(a_rotated_video_is_upright),
        cmocka_unit_test(colours_are_those_of_the_standards),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
