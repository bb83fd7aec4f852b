/* EDID: what is taken from a sound one, and that damaged ones give nothing. */
#include "tests/testing.h"

#include "device/find/edid.h"

enum { BLOCK = 128 };

static void set_descriptor(uint8_t *edid, int index, uint8_t tag, const char *text)
{
    uint8_t *d = edid + 54 + 18 * index;
    memset(d, 0, 18);
    d[3] = tag;
    memset(d + 5, ' ', 13);
    size_t n = strlen(text);
    memcpy(d + 5, text, n < 13 ? n : 13);
    if (n < 13)
        d[5 + n] = '\n';
}

static void set_checksum(uint8_t *edid)
{
    unsigned sum = 0;
    for (int i = 0; i < BLOCK - 1; i++)
        sum += edid[i];
    edid[BLOCK - 1] = (uint8_t)(256 - sum % 256);
}

/* A monitor of width x height with this name and serial number (NULL = none). */
static void make_edid(uint8_t edid[BLOCK], int width, int height, const char *name,
                      const char *serial)
{
    static const uint8_t header[8] = {0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0};
    memset(edid, 0, BLOCK);
    memcpy(edid, header, sizeof header);
    edid[54] = 1;
    edid[55] = 2;
    edid[56] = (uint8_t)width;
    edid[58] = (uint8_t)(width >> 8 << 4);
    edid[59] = (uint8_t)height;
    edid[61] = (uint8_t)(height >> 8 << 4);
    if (name)
        set_descriptor(edid, 1, 0xfc, name);
    if (serial)
        set_descriptor(edid, 3, 0xff, serial);
    set_checksum(edid);
}

static lf_edid parsed(const uint8_t *edid, size_t n)
{
    lf_edid out = {0};
    lf_error err = {0};
    lf_assert_ok(lf_edid_parse(edid, n, &out, &err), &err);
    return out;
}

static void name_serial_and_size_are_taken(void **state)
{
    (void)state;
    uint8_t edid[2 * BLOCK];
    make_edid(edid, 1536, 2048, "LKG-P00655", "P00655");
    memset(edid + BLOCK, 0xff, BLOCK); /* what follows the first block is not read */
    lf_edid e = parsed(edid, sizeof edid);
    assert_string_equal(e.name, "LKG-P00655");
    assert_string_equal(e.serial, "P00655");
    assert_int_equal(e.width_px, 1536);
    assert_int_equal(e.height_px, 2048);
    assert_true(lf_edid_is_panel(&e));
}

static void a_name_of_full_length_has_no_end_mark(void **state)
{
    (void)state;
    uint8_t edid[BLOCK];
    make_edid(edid, 2560, 1600, "LKG01Do12HjQE", NULL);
    lf_edid e = parsed(edid, sizeof edid);
    assert_string_equal(e.name, "LKG01Do12HjQE");
    assert_string_equal(e.serial, "");
    assert_true(lf_edid_is_panel(&e));
}

static void other_monitors_are_no_panels(void **state)
{
    (void)state;
    static const char *const names[] = {"DELL U2720Q", "", " LKG", "lkg-1", "LK", NULL};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        uint8_t edid[BLOCK];
        make_edid(edid, 3840, 2160, names[i], NULL);
        lf_edid e = parsed(edid, sizeof edid);
        assert_false(lf_edid_is_panel(&e));
        assert_int_equal(e.width_px, 3840);
    }
}

static void a_monitor_may_say_nothing(void **state)
{
    (void)state;
    uint8_t edid[BLOCK];
    make_edid(edid, 0, 0, NULL, NULL);
    memset(edid + 54, 0, 72);
    set_checksum(edid);
    lf_edid e = parsed(edid, sizeof edid), nothing = {0};
    assert_memory_equal(&e, &nothing, sizeof e);
}

static void a_size_is_taken_from_the_first_descriptor_only(void **state)
{
    (void)state;
    uint8_t edid[BLOCK];
    make_edid(edid, 800, 600, NULL, NULL);
    memcpy(edid + 72, edid + 54, 18);
    set_descriptor(edid, 0, 0xfc, "LKG-1");
    set_checksum(edid);
    lf_edid e = parsed(edid, sizeof edid);
    assert_string_equal(e.name, "LKG-1");
    assert_int_equal(e.width_px, 0);
    assert_int_equal(e.height_px, 0);
}

static void terminal_escapes_become_question_marks(void **state)
{
    (void)state;
    uint8_t edid[BLOCK];
    make_edid(edid, 1536, 2048, "LKG\x1b[31m\x07\xff\x80",
              "\x9b"
              "2J");
    lf_edid e = parsed(edid, sizeof edid);
    assert_string_equal(e.name, "LKG?[31m???");
    assert_string_equal(e.serial, "?2J");
}

static void assert_refused(const uint8_t *edid, size_t n, const char *word)
{
    lf_edid out, before;
    lf_error err = {0};
    memset(&out, 0x5a, sizeof out);
    before = out;
    lf_assert_status(lf_edid_parse(edid, n, &out, &err), LF_E_FORMAT, &err);
    assert_memory_equal(&out, &before, sizeof out);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

static void damaged_blocks_are_refused(void **state)
{
    (void)state;
    uint8_t edid[BLOCK];
    make_edid(edid, 1536, 2048, "LKG-P00655", NULL);
    for (size_t n = 0; n < BLOCK; n++) {
        uint8_t *copy = malloc(n + 1);
        assert_non_null(copy);
        memcpy(copy, edid, n);
        assert_refused(copy, n, "expected a multiple of 128");
        free(copy);
    }
    for (size_t i = 0; i < BLOCK; i++) {
        edid[i] ^= 0x10;
        assert_refused(edid, sizeof edid, i < 8 ? "header" : "checksum");
        edid[i] ^= 0x10;
    }
    parsed(edid, sizeof edid);
}

static void random_blocks_give_sane_values(void **state)
{
    (void)state;
    uint64_t seed = lf_test_seed();
    for (int round = 0; round < 5000; round++) {
        uint8_t edid[BLOCK];
        make_edid(edid, 1536, 2048, "LKG-P00655", "1");
        for (int i = 8; i < BLOCK - 1; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            if (seed >> 62 != 0)
                edid[i] = (uint8_t)(seed >> 40);
        }
        set_checksum(edid);
        lf_edid e = parsed(edid, sizeof edid);
        assert_in_range(e.width_px, 0, 4095);
        assert_in_range(e.height_px, 0, 4095);
        for (const char *p = e.name; *p != 0; p++)
            assert_true((unsigned char)*p >= 0x20 && *p != 0x7f);
        assert_true(strlen(e.name) <= 13 && strlen(e.serial) <= 13);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(name_serial_and_size_are_taken),
        cmocka_unit_test(a_name_of_full_length_has_no_end_mark),
        cmocka_unit_test(other_monitors_are_no_panels),
        cmocka_unit_test(a_monitor_may_say_nothing),
        cmocka_unit_test(a_size_is_taken_from_the_first_descriptor_only),
        cmocka_unit_test(terminal_escapes_become_question_marks),
        cmocka_unit_test(damaged_blocks_are_refused),
        cmocka_unit_test(random_blocks_give_sane_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
