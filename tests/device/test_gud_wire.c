/* The GUD protocol's structures: what is written is read back, what must not be is refused. */
#include "tests/testing.h"

#include "device/usb/gud.h"

static lf_gud_descriptor good_descriptor(void)
{
    return (lf_gud_descriptor){
        .version = 1, .max_buffer_size = 0x12345678, .max_width = 4096, .max_height = 4096};
}

static void descriptors_lie_where_the_protocol_says(void **state)
{
    (void)state;
    lf_gud_descriptor d = good_descriptor(), back = {0};
    uint8_t bytes[LF_GUD_DESCRIPTOR_BYTES];
    d.flags = LF_GUD_FLAG_STATUS_ON_SET;
    d.compression = LF_GUD_COMPRESSION_LZ4;
    d.min_width = 7;
    lf_gud_descriptor_write(&d, bytes);
    const uint8_t expected[] = {0x4d, 0x61, 0x50, 0x1d, 1, 1, 0, 0,    0, 1,
                                0x78, 0x56, 0x34, 0x12, 7, 0, 0, 0,    0, 0x10,
                                0,    0,    0,    0,    0, 0, 0, 0x10, 0, 0};
    assert_memory_equal(bytes, expected, sizeof expected);
    lf_assert_ok(lf_gud_descriptor_read(bytes, sizeof bytes, &back, NULL), NULL);
    assert_int_equal(back.flags, d.flags);
    assert_int_equal(back.compression, d.compression);
    assert_int_equal(back.max_buffer_size, d.max_buffer_size);
    assert_int_equal(back.min_width, 7);
    assert_int_equal(back.max_height, 4096);
}

static void assert_descriptor_refused(const uint8_t *bytes, size_t n)
{
    lf_gud_descriptor out = {.flags = 77};
    lf_error err = {0};
    lf_assert_status(lf_gud_descriptor_read(bytes, n, &out, &err), LF_E_FORMAT, &err);
    assert_int_equal(out.flags, 77);
    assert_true(err.what[0] != 0);
}

static void descriptors_that_break_the_protocol_are_refused(void **state)
{
    (void)state;
    uint8_t good[LF_GUD_DESCRIPTOR_BYTES + 1] = {0}, bad[LF_GUD_DESCRIPTOR_BYTES + 1];
    lf_gud_descriptor d = good_descriptor();
    lf_gud_descriptor_write(&d, good);
    lf_assert_ok(lf_gud_descriptor_read(good, LF_GUD_DESCRIPTOR_BYTES, &d, NULL), NULL);
    for (size_t n = 0; n < LF_GUD_DESCRIPTOR_BYTES; n++)
        assert_descriptor_refused(good, n);
    assert_descriptor_refused(good, sizeof good);
    const struct {
        int at;
        uint8_t value;
    } wrong[] = {{0, 0}, {3, 0x1e}, {4, 0}, {4, 2}, {4, 255}, {14, 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        memcpy(bad, good, sizeof bad);
        bad[wrong[i].at] = wrong[i].value;
        if (wrong[i].at == 14)
            bad[19] = bad[18] = 0; /* the least width is above the greatest */
        assert_descriptor_refused(bad, LF_GUD_DESCRIPTOR_BYTES);
    }
    memcpy(bad, good, sizeof bad);
    bad[5] = LF_GUD_FLAG_FULL_UPDATE;
    bad[9] = LF_GUD_COMPRESSION_LZ4;
    assert_descriptor_refused(bad, LF_GUD_DESCRIPTOR_BYTES);
}

static void the_best_format_wins_wherever_it_stands(void **state)
{
    (void)state;
    uint8_t many[LF_GUD_MAX_FORMATS + 1];
    lf_gud_format format = LF_GUD_NO_FORMAT;
    lf_assert_ok(lf_gud_formats_choose((const uint8_t[]){0x01, 0x40, 0x80, 0x50}, 4, &format, NULL),
                 NULL);
    assert_int_equal(format, LF_GUD_RGB888);
    lf_assert_ok(lf_gud_formats_choose((const uint8_t[]){0x40, 0x80}, 2, &format, NULL), NULL);
    assert_int_equal(format, LF_GUD_XRGB8888);
    lf_assert_ok(lf_gud_formats_choose((const uint8_t[]){0x40, 0xff}, 2, &format, NULL), NULL);
    assert_int_equal(format, LF_GUD_RGB565);
    lf_assert_status(lf_gud_formats_choose((const uint8_t[]){0x01, 0x08, 0x81}, 3, &format, NULL),
                     LF_E_FORMAT, NULL);
    lf_assert_status(lf_gud_formats_choose(many, 0, &format, NULL), LF_E_FORMAT, NULL);
    memset(many, LF_GUD_RGB888, sizeof many);
    lf_assert_status(lf_gud_formats_choose(many, sizeof many, &format, NULL), LF_E_FORMAT, NULL);
    lf_assert_ok(lf_gud_formats_choose(many, LF_GUD_MAX_FORMATS, &format, NULL), NULL);
}

static void lists_are_bounded_and_whole(void **state)
{
    (void)state;
    uint8_t bytes[(LF_GUD_MAX_MODES + 1) * LF_GUD_MODE_BYTES] = {0};
    lf_gud_mode modes[LF_GUD_MAX_MODES];
    lf_gud_state properties = {0};
    int n = -1;
    lf_assert_ok(lf_gud_modes_read(bytes, sizeof bytes - LF_GUD_MODE_BYTES, modes, &n, NULL), NULL);
    assert_int_equal(n, LF_GUD_MAX_MODES);
    lf_assert_ok(lf_gud_modes_read(bytes, 0, modes, &n, NULL), NULL);
    assert_int_equal(n, 0);
    lf_assert_status(lf_gud_modes_read(bytes, sizeof bytes, modes, &n, NULL), LF_E_FORMAT, NULL);
    lf_assert_status(lf_gud_modes_read(bytes, LF_GUD_MODE_BYTES + 1, modes, &n, NULL), LF_E_FORMAT,
                     NULL);
    lf_assert_status(lf_gud_connectors_count(bytes, 0, &n, NULL), LF_E_FORMAT, NULL);
    lf_assert_status(lf_gud_connectors_count(bytes, 6, &n, NULL), LF_E_FORMAT, NULL);
    lf_assert_status(lf_gud_connectors_count(bytes, 33 * LF_GUD_CONNECTOR_BYTES, &n, NULL),
                     LF_E_FORMAT, NULL);
    lf_assert_ok(lf_gud_connectors_count(bytes, 32 * LF_GUD_CONNECTOR_BYTES, &n, NULL), NULL);
    assert_int_equal(n, 32);
    lf_assert_status(lf_gud_properties_read(bytes, 33 * LF_GUD_PROPERTY_BYTES, &properties, NULL),
                     LF_E_FORMAT, NULL);
    lf_assert_status(lf_gud_properties_read(bytes, 7, &properties, NULL), LF_E_FORMAT, NULL);
    assert_int_equal(properties.n_properties, 0);
}

static void states_give_known_properties_back(void **state)
{
    (void)state;
    uint8_t listed[4 * LF_GUD_PROPERTY_BYTES], bytes[LF_GUD_STATE_MAX_BYTES];
    const lf_gud_property properties[] = {{LF_GUD_PROPERTY_BACKLIGHT, 40},
                                          {999, 1},
                                          {LF_GUD_PROPERTY_ROTATION, 0x3f},
                                          {1, UINT64_MAX}};
    lf_gud_state s = {.mode = {.hdisplay = 640, .clock_khz = 25175, .flags = 5},
                      .format = LF_GUD_RGB888,
                      .connector = 3},
                 back;
    for (int i = 0; i < 4; i++)
        lf_gud_property_write(&properties[i], listed + i * LF_GUD_PROPERTY_BYTES);
    lf_assert_ok(lf_gud_properties_read(listed, sizeof listed, &s, NULL), NULL);
    size_t n = lf_gud_state_write(&s, bytes);
    assert_int_equal(n, LF_GUD_STATE_BYTES + 3 * LF_GUD_PROPERTY_BYTES);
    assert_true(lf_gud_state_read(bytes, n, &back));
    assert_int_equal(back.mode.hdisplay, 640);
    assert_int_equal(back.mode.clock_khz, 25175);
    assert_int_equal(back.mode.flags, 5);
    assert_int_equal(back.format, LF_GUD_RGB888);
    assert_int_equal(back.connector, 3);
    assert_int_equal(back.n_properties, 3);
    assert_int_equal(back.properties[0].value, 40);
    assert_int_equal(back.properties[1].value, LF_GUD_ROTATE_0);
    assert_true(back.properties[2].value == UINT64_MAX);
    assert_false(lf_gud_state_read(bytes, n - 1, &back));
    assert_false(lf_gud_state_read(bytes, LF_GUD_STATE_BYTES - 1, &back));
}

static void buffers_are_announced_in_25_bytes(void **state)
{
    (void)state;
    const lf_gud_buffer b = {1, 0x10000, 3, 4, 0xfffffffe, 1, 0x01020304};
    lf_gud_buffer back;
    uint8_t bytes[LF_GUD_BUFFER_BYTES];
    lf_gud_buffer_write(&b, bytes);
    assert_int_equal(bytes[6], 1);
    assert_int_equal(bytes[20], 1);
    assert_int_equal(bytes[21], 4);
    assert_true(lf_gud_buffer_read(bytes, sizeof bytes, &back));
    assert_int_equal(back.y, 0x10000);
    assert_true(back.length == 0xfffffffe);
    assert_int_equal(back.compressed_length, 0x01020304);
    assert_false(lf_gud_buffer_read(bytes, sizeof bytes - 1, &back));
}

static lf_gud_mode mode_of(int width, int height, uint32_t flags)
{
    return (lf_gud_mode){.hdisplay = (uint16_t)width, .vdisplay = (uint16_t)height, .flags = flags};
}

static void the_mode_of_the_calibration_is_chosen_else_the_preferred(void **state)
{
    (void)state;
    const lf_gud_descriptor d = good_descriptor();
    const lf_gud_mode modes[] = {mode_of(0, 0, LF_GUD_MODE_PREFERRED),
                                 mode_of(1920, 1080, 0),
                                 mode_of(1536, 2048, 0),
                                 mode_of(1280, 720, LF_GUD_MODE_PREFERRED),
                                 mode_of(1536, 2048, LF_GUD_MODE_PREFERRED),
                                 mode_of(65535, 65535, LF_GUD_MODE_PREFERRED),
                                 mode_of(8192, 100, LF_GUD_MODE_PREFERRED)};
    const int n = sizeof modes / sizeof *modes;
    lf_gud_mode m;
    lf_error err = {0};
    lf_assert_ok(lf_gud_mode_choose(&d, modes, n, 0, 0, &m, NULL), NULL);
    assert_int_equal(m.hdisplay, 1280);
    lf_assert_ok(lf_gud_mode_choose(&d, modes, n, 1536, 2048, &m, NULL), NULL);
    assert_true((m.flags & LF_GUD_MODE_PREFERRED) != 0);
    lf_assert_ok(lf_gud_mode_choose(&d, modes, 3, 0, 0, &m, NULL), NULL);
    assert_int_equal(m.hdisplay, 1920);
    /* beyond the descriptor's limits */
    lf_assert_status(lf_gud_mode_choose(&d, modes, n, 8192, 100, &m, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "1920x1080"));
    lf_assert_status(lf_gud_mode_choose(&d, modes, 1, 0, 0, &m, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "0x0"));
    lf_assert_status(lf_gud_mode_choose(&d, modes + 5, 1, 0, 0, &m, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "65535x65535"));
    lf_assert_status(lf_gud_mode_choose(&d, modes, 0, 0, 0, &m, &err), LF_E_FORMAT, &err);
}

static void an_edid_gives_the_mode_of_its_first_timing(void **state)
{
    (void)state;
    /* 1920x1080 at 60 Hz as CEA-861 has it: 148.5 MHz, 88 + 44 + 148, 4 + 5 + 36 */
    const uint8_t timing[] = {0x02, 0x3a, 0x80, 0x18, 0x71, 0x38, 0x2d, 0x40, 0x58,
                              0x2c, 0x45, 0,    0,    0,    0,    0,    0,    0x1e};
    uint8_t edid[128] = {0};
    lf_gud_mode m;
    assert_false(lf_gud_mode_from_edid(edid, sizeof edid, &m));
    memcpy(edid + 54, timing, sizeof timing);
    assert_true(lf_gud_mode_from_edid(edid, sizeof edid, &m));
    assert_int_equal(m.clock_khz, 148500);
    assert_int_equal(m.hdisplay, 1920);
    assert_int_equal(m.hsync_start, 2008);
    assert_int_equal(m.hsync_end, 2052);
    assert_int_equal(m.htotal, 2200);
    assert_int_equal(m.vdisplay, 1080);
    assert_int_equal(m.vsync_start, 1084);
    assert_int_equal(m.vsync_end, 1089);
    assert_int_equal(m.vtotal, 1125);
    assert_false(lf_gud_mode_from_edid(edid, 127, &m));
}

static void pixels_survive_but_for_565_which_rounds_to_the_nearest(void **state)
{
    (void)state;
    lf_image8 frame = {0};
    lf_assert_ok(lf_image8_init(&frame, 256, 3, 3), NULL);
    for (int y = 0; y < 3; y++)
        for (int i = 0; i < 256 * 3; i++)
            frame.data[(size_t)y * frame.stride + (size_t)i] = (uint8_t)(i / 3 + i % 3 * 85 + y);
    const lf_rect r = {0, 1, 256, 1};
    const uint8_t *row = frame.data + frame.stride;
    uint8_t wire[256 * 4], back[256 * 3];
    lf_gud_pixels_write(LF_GUD_RGB888, &frame, r, wire);
    assert_int_equal(wire[0], row[2]);
    assert_int_equal(wire[2], row[0]);
    lf_gud_pixels_read(LF_GUD_RGB888, wire, 256, back);
    assert_memory_equal(back, row, sizeof back);
    lf_gud_pixels_write(LF_GUD_XRGB8888, &frame, r, wire);
    lf_gud_pixels_read(LF_GUD_XRGB8888, wire, 256, back);
    assert_memory_equal(back, row, sizeof back);
    lf_gud_pixels_write(LF_GUD_RGB565, &frame, r, wire);
    lf_gud_pixels_read(LF_GUD_RGB565, wire, 256, back);
    for (int i = 0; i < 256 * 3; i++)
        /* half a step of 63 and of 31 */
        lf_assert_close(back[i], row[i], 0, i % 3 == 1 ? 2.1 : 4.2);
    lf_image8_finish(&frame);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descriptors_lie_where_the_protocol_says),
        cmocka_unit_test(descriptors_that_break_the_protocol_are_refused),
        cmocka_unit_test(the_best_format_wins_wherever_it_stands),
        cmocka_unit_test(lists_are_bounded_and_whole),
        cmocka_unit_test(states_give_known_properties_back),
        cmocka_unit_test(buffers_are_announced_in_25_bytes),
        cmocka_unit_test(the_mode_of_the_calibration_is_chosen_else_the_preferred),
        cmocka_unit_test(an_edid_gives_the_mode_of_its_first_timing),
        cmocka_unit_test(pixels_survive_but_for_565_which_rounds_to_the_nearest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
