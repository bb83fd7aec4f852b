/* What is taken from ffprobe's words, and from the first bytes of a file. */
#include "tests/testing.h"

#include "daemon/media/probe.h"

static lf_status parse(const char *json, lf_movie_info *out, lf_error *err)
{
    return lf_probe_parse(json, strlen(json), "v.mp4", out, err);
}

#define STREAM(more) "{\"streams\":[{\"width\":64,\"height\":48" more "}],\"format\":{}}"

static lf_movie_info good(const char *json)
{
    lf_movie_info info;
    lf_error err;
    lf_assert_ok(parse(json, &info, &err), &err);
    return info;
}

static void its_words_become_a_video(void **state)
{
    (void)state;
    const lf_movie_info info =
        good("{\"programs\":[],\"streams\":[{\"codec_name\":\"h264\",\"width\":3360,"
             "\"height\":2240,\"sample_aspect_ratio\":\"4:3\",\"color_space\":\"smpte170m\","
             "\"r_frame_rate\":\"30/1\",\"avg_frame_rate\":\"30/1\",\"duration\":\"2.500000\","
             "\"nb_frames\":\"75\",\"side_data_list\":[{},{\"rotation\":-90}]}],"
             "\"format\":{\"duration\":\"9.0\"}}");
    assert_int_equal(info.width, 3360);
    assert_int_equal(info.height, 2240);
    lf_assert_close(info.pixel_aspect, 4.0 / 3, 1e-12, 0);
    assert_int_equal(info.matrix, LF_MATRIX_BT601);
    assert_int_equal(info.rate, 30);
    assert_int_equal(info.per, 1);
    lf_assert_close(info.seconds, 2.5, 1e-12, 0); /* of the stream, not of the file */
    assert_int_equal(info.n_frames, 75);
    assert_int_equal(info.orientation, 6);
    assert_string_equal(info.codec, "h264");
}

static void what_is_not_said_has_a_usual_value(void **state)
{
    (void)state;
    const lf_movie_info info = good(STREAM(""));
    lf_assert_close(info.pixel_aspect, 1, 0, 0);
    assert_int_equal(info.rate, 25);
    assert_int_equal(info.per, 1);
    assert_int_equal(info.orientation, 1);
    lf_assert_close(info.seconds, 0, 0, 0);
    assert_int_equal(info.n_frames, 0);
    assert_string_equal(info.codec, "unknown");
    /* "0:1" is ffprobe's word for an unknown shape */
    lf_assert_close(good(STREAM(",\"sample_aspect_ratio\":\"0:1\"")).pixel_aspect, 1, 0, 0);
    assert_int_equal(good(STREAM(",\"nb_frames\":\"12\"")).n_frames, 12);
}

static void rates_are_the_mean_of_a_variable_rate(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        int rate, per;
    } cases[] = {
        {STREAM(",\"r_frame_rate\":\"30000/1001\",\"avg_frame_rate\":\"2997/100\""), 30000, 1001},
        {STREAM(",\"r_frame_rate\":\"90000/1\",\"avg_frame_rate\":\"1217/100\""), 1217, 100},
        {STREAM(",\"r_frame_rate\":\"60/1\",\"avg_frame_rate\":\"24/1\""), 24, 1},
        {STREAM(",\"r_frame_rate\":\"12/1\",\"avg_frame_rate\":\"0/0\""), 12, 1},
        {STREAM(",\"r_frame_rate\":\"1000/1\",\"avg_frame_rate\":\"0/0\""), 25, 1},
        {STREAM(",\"r_frame_rate\":\"1/1000\",\"avg_frame_rate\":\"-3/1\""), 25, 1},
        {STREAM(",\"r_frame_rate\":\"100/1\",\"avg_frame_rate\":\"0/0\",\"nb_frames\":\"2\","
                "\"duration\":\"0.080000\""),
         25, 1},
        {STREAM(",\"r_frame_rate\":\"100/1\",\"avg_frame_rate\":\"0/0\",\"nb_frames\":\"1\","
                "\"duration\":\"0.100000\""),
         10, 1},
        {STREAM(",\"r_frame_rate\":\"30\",\"avg_frame_rate\":\"30/1x\""), 25, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const lf_movie_info info = good(cases[i].words);
        assert_int_equal(info.rate * cases[i].per, cases[i].rate * info.per);
    }
}

static void untagged_colours_follow_the_size(void **state)
{
    (void)state;
    assert_int_equal(good(STREAM("")).matrix, LF_MATRIX_BT601);
    assert_int_equal(good("{\"streams\":[{\"width\":1280,\"height\":64}]}").matrix,
                     LF_MATRIX_BT709);
    assert_int_equal(good("{\"streams\":[{\"width\":64,\"height\":720}]}").matrix, LF_MATRIX_BT709);
    assert_int_equal(good(STREAM(",\"color_space\":\"bt709\"")).matrix, LF_MATRIX_BT709);
    assert_int_equal(good(STREAM(",\"color_space\":\"bt2020nc\"")).matrix, LF_MATRIX_BT2020);
}

static void quarter_turns_are_counted_clockwise(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        int orientation;
    } cases[] = {
        {STREAM(",\"side_data_list\":[{\"rotation\":90}]"), 8},
        {STREAM(",\"side_data_list\":[{\"rotation\":-180}]"), 3},
        {STREAM(",\"side_data_list\":[{\"rotation\":-270}]"), 8},
        {STREAM(",\"side_data_list\":[{\"rotation\":1e99}]"), 1},
        {STREAM(",\"side_data_list\":{\"rotation\":90}"), 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_int_equal(good(cases[i].words).orientation, cases[i].orientation);
}

static void other_words_are_refused_in_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *words, *part;
    } cases[] = {
        {"", "ffprobe's answer cannot be read"},
        {"[", "ffprobe's answer cannot be read"},
        {"[]", "has no video track"},
        {"{}", "has no video track"},
        {"{\"streams\":[]}", "has no video track"},
        {"{\"streams\":[{\"width\":0,\"height\":5}]}", "has no video track"},
        {"{\"streams\":[{\"width\":8193,\"height\":5}]}", "8193x5 pixels are too large"},
        {"{\"streams\":[{\"width\":5,\"height\":1e300}]}", "are too large"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_movie_info info;
        lf_error err;
        lf_assert_status(parse(cases[i].words, &info, &err), LF_E_FORMAT, &err);
        assert_string_equal(err.where, "v.mp4");
        assert_non_null(strstr(err.what, cases[i].part));
    }
}

static const char *demuxer(const char *head, size_t n)
{
    const char *name = lf_movie_demuxer((const uint8_t *)head, n);
    return name ? name : "";
}

static void a_file_is_a_video_by_its_first_bytes(void **state)
{
    (void)state;
    assert_string_equal(demuxer("\0\0\0\x20"
                                "ftypisom",
                                12),
                        "mov");
    assert_string_equal(demuxer("\x1a\x45\xdf\xa3....", 8), "matroska");
    assert_string_equal(demuxer("RIFF....AVI LIST", 16), "avi");
    assert_string_equal(demuxer("RIFF....WAVEfmt ", 16), "");
    assert_string_equal(demuxer("XXXX....AVI LIST", 16), "");
    assert_string_equal(demuxer("\0\0\0\x20"
                                "ftypheic",
                                12),
                        "");
    assert_string_equal(demuxer("GIF89a", 6), "gif");
    assert_string_equal(demuxer("GIF8", 4), "");
    assert_string_equal(demuxer("ffconcat version", 16), "");
    assert_string_equal(demuxer("#EXTM3U\n#EXTINF:", 16), "");
    assert_string_equal(demuxer("", 0), "");
    assert_true(lf_movie_ending("a.MP4") && lf_movie_ending("/x/b_qs8x6a0.75.webm"));
    assert_false(lf_movie_ending("a.png") || lf_movie_ending("mp4"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(its_words_become_a_video),
        cmocka_unit_test(what_is_not_said_has_a_usual_value),
        cmocka_unit_test(rates_are_the_mean_of_a_variable_rate),
        cmocka_unit_test(untagged_colours_follow_the_size),
        cmocka_unit_test(quarter_turns_are_counted_clockwise),
        cmocka_unit_test(other_words_are_refused_in_one_line),
        cmocka_unit_test(a_file_is_a_video_by_its_first_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
