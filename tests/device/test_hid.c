/* The calibration over HID: the simulated panel, every fault of it, EEPROMs that lie, and that
 * nothing but "read a page" is ever sent. Time is the link's: nothing here waits. */
#include "tests/testing.h"

#include <errno.h>

#include "base/alloc.h"
#include "base/file.h"
#include "device/hid/hid.h"
#include "device/model/model.h"

static const char good[] =
    "{\"configVersion\":\"1.0\",\"serial\":\"LKG-2K-TEST\",\"pitch\":{\"value\":47.5},"
    "\"slope\":{\"value\":-5.25},\"center\":{\"value\":0.375},\"viewCone\":{\"value\":40},"
    "\"DPI\":{\"value\":338},\"screenW\":{\"value\":2560.0},\"screenH\":{\"value\":1600}}";

/* A panel on a wire whose clock moves only while somebody waits. */
typedef struct wire {
    lf_model_hid *model;
    uint64_t now_ms;
    int unplug_after; /* so many packets read; 0 = never */
    int n_read, n_sent;
    int read_ms;   /* what every packet takes */
    bool trickles; /* every packet is one byte that comes just in time */
} wire;

static int wire_send(void *context, const uint8_t *report, size_t n)
{
    wire *w = context;
    w->n_sent++;
    assert_int_equal(n, LF_HID_FEATURE);
    assert_int_equal(report[0], 0);
    return lf_model_hid_feature(w->model, report + 1, n - 1) < 0 ? -1 : (int)n;
}

static int wire_read(void *context, uint8_t *out, size_t max, int timeout_ms)
{
    wire *w = context;
    assert_true(timeout_ms >= 0);
    if (w->trickles && timeout_ms > 0) {
        w->now_ms += (uint64_t)timeout_ms - 1;
        w->n_read++;
        out[0] = 0xff;
        return 1;
    }
    if (w->unplug_after > 0 && w->n_read >= w->unplug_after)
        return -1;
    int n = lf_model_hid_input(w->model, out, max);
    w->now_ms += (uint64_t)(n > 0 ? w->read_ms : timeout_ms);
    w->n_read += n > 0;
    return n > 0 ? n : 0;
}

static uint64_t wire_now(void *context)
{
    return ((const wire *)context)->now_ms;
}

static wire plug_in(const void *eeprom, size_t n, const lf_model_hid_faults *faults)
{
    wire w = {.now_ms = 5000};
    lf_assert_ok(lf_model_hid_create(eeprom, n, faults, &w.model), NULL);
    return w;
}

static wire plug_in_json(const char *json, size_t n, const lf_model_hid_faults *faults)
{
    uint8_t eeprom[LF_MODEL_EEPROM_MAX];
    size_t size = lf_model_hid_eeprom(json, n, eeprom, sizeof eeprom);
    assert_int_equal(size, n + 4);
    return plug_in(eeprom, size, faults);
}

static lf_status read_wire(wire *w, lf_calibration *out, lf_error *err)
{
    lf_hid_link link = {wire_send, wire_read, wire_now, NULL, w};
    lf_calibration before;
    memset(out, 0x5a, sizeof *out);
    before = *out;
    lf_status status = lf_hid_read_calibration(&link, &lf_hid_patient, "/dev/hidraw7", out, err);
    if (status != LF_OK)
        assert_memory_equal(out, &before, sizeof before);
    assert_int_equal(lf_model_hid_violations(w->model), 0);
    assert_true(w->now_ms - 5000 <=
                (uint64_t)lf_hid_patient.total_ms + 2 * (uint64_t)lf_hid_patient.rest_ms);
    return status;
}

static lf_calibration expected(void)
{
    lf_calibration c;
    lf_assert_ok(lf_calibration_parse(good, strlen(good), "good", &c, NULL), NULL);
    return c;
}

/* The panel of `good` with these faults gives its calibration all the same. */
static void assert_read_despite(const lf_model_hid_faults *faults)
{
    wire w = plug_in_json(good, strlen(good), faults);
    lf_calibration c, e = expected();
    lf_error err = {0};
    lf_assert_ok(read_wire(&w, &c, &err), &err);
    assert_memory_equal(&c, &e, sizeof c);
    lf_model_hid_destroy(w.model);
}

/* One clear line: this status, the device's name, and this word. */
static void assert_refused(wire *w, lf_status status, const char *word)
{
    lf_calibration c;
    lf_error err = {0};
    lf_assert_status(read_wire(w, &c, &err), status, &err);
    assert_string_equal(err.where, "/dev/hidraw7");
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
    lf_model_hid_destroy(w->model);
}

static void a_healthy_panel_tells_its_calibration(void **state)
{
    (void)state;
    wire w = plug_in_json(good, strlen(good), NULL);
    lf_calibration c, e = expected();
    lf_assert_ok(read_wire(&w, &c, NULL), NULL);
    assert_memory_equal(&c, &e, sizeof c);
    assert_int_equal(w.n_sent, (strlen(good) + 4 + 63) / 64);
    lf_model_hid_destroy(w.model);
}

static void every_length_of_text_is_read_to_its_end(void **state)
{
    (void)state;
    char text[512];
    lf_calibration e = expected();
    for (size_t blanks = 0; blanks < 130; blanks++) {
        size_t n = strlen(good) + blanks;
        memset(text, ' ', sizeof text);
        memcpy(text + blanks, good, strlen(good));
        wire w = plug_in_json(text, n, NULL);
        lf_calibration c;
        lf_assert_ok(read_wire(&w, &c, NULL), NULL);
        assert_memory_equal(&c, &e, sizeof c);
        assert_int_equal(w.n_sent, (n + 4 + 63) / 64);
        lf_model_hid_destroy(w.model);
    }
}

static void faults_that_pass_do_not_matter(void **state)
{
    (void)state;
    const lf_model_hid_faults faults[] = {
        {.split = true},
        {.stale = 1},
        {.stale = 40},
        {.mute_every = 2},
        {.mute_every = 3},
        {.stall_every = 2},
        {.stall_every = 3},
        {.short_every = 2},
        {.press_every = 1},
        {.press_every = 3},
        {.split = true, .press_every = 1, .stale = 3},
        {.split = true, .short_every = 3, .stall_every = 5},
        {.mute_every = 4, .stall_every = 3, .short_every = 5, .press_every = 2, .stale = 2},
    };
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
        assert_read_despite(&faults[i]);
}

static void faults_that_stay_end_in_one_clear_error(void **state)
{
    (void)state;
    const struct {
        lf_model_hid_faults faults;
        lf_status status;
        const char *word;
    } cases[] = {
        {{.mute_every = 1}, LF_E_TIMEOUT, "did not send calibration page"},
        {{.stall_every = 1}, LF_E_IO, "refused to send calibration page"},
        {{.short_every = 1}, LF_E_TIMEOUT, "did not send calibration page"},
        {{.wrong_echo = true}, LF_E_TIMEOUT, "did not send calibration page"},
        {{.stale = 1000}, LF_E_TIMEOUT, "did not send calibration page"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        wire w = plug_in_json(good, strlen(good), &cases[i].faults);
        assert_refused(&w, cases[i].status, cases[i].word);
        assert_int_equal(w.n_sent, lf_hid_patient.attempts);
    }
}

static void what_was_asked_before_is_dropped(void **state)
{
    (void)state;
    wire w = plug_in_json(good, strlen(good), NULL);
    uint8_t request[LF_MODEL_FEATURE] = {0};
    for (uint8_t page = 0; page < 20; page++) {
        request[2] = page;
        assert_int_equal(lf_model_hid_feature(w.model, request, sizeof request), LF_MODEL_FEATURE);
    }
    lf_model_hid_press(w.model, 5);
    lf_calibration c, e = expected();
    lf_assert_ok(read_wire(&w, &c, NULL), NULL);
    assert_memory_equal(&c, &e, sizeof c);
    lf_model_hid_destroy(w.model);
}

static void a_slow_panel_is_not_waited_for_for_ever(void **state)
{
    (void)state;
    lf_model_hid_faults faults = {.stale = 60};
    wire w = plug_in_json(good, strlen(good), &faults);
    w.read_ms = 900;
    lf_calibration c;
    lf_error err = {0};
    lf_hid_link link = {wire_send, wire_read, wire_now, NULL, &w};
    lf_assert_status(lf_hid_read_calibration(&link, &lf_hid_patient, "slow", &c, &err),
                     LF_E_TIMEOUT, &err);
    assert_true(w.n_read < 3 * 64);
    lf_model_hid_destroy(w.model);
}

static void replies_that_trickle_in_do_not_stretch_the_time(void **state)
{
    (void)state;
    wire w = plug_in_json(good, strlen(good), NULL);
    uint64_t began = w.now_ms;
    w.trickles = true;
    lf_calibration c;
    lf_error err = {0};
    lf_assert_status(read_wire(&w, &c, &err), LF_E_TIMEOUT, &err);
    assert_true(w.n_read > 3); /* it did trickle */
    assert_in_range(w.now_ms - began, 1, lf_hid_patient.total_ms + lf_hid_patient.rest_ms);
    lf_model_hid_destroy(w.model);
}

static void unplugging_is_told_as_such(void **state)
{
    (void)state;
    for (int packets = 1; packets < 4; packets++) {
        wire w = plug_in_json(good, strlen(good), NULL);
        w.unplug_after = packets;
        assert_refused(&w, LF_E_NODEV, "unplugged");
    }
}

static void blank_and_lying_lengths_are_refused(void **state)
{
    (void)state;
    const struct {
        uint8_t bytes[4];
        const char *word;
    } cases[] = {
        {{0xff, 0xff, 0xff, 0xff}, "blank"},
        {{0xff, 0xff, 0xff, 0xfe}, "4294967294 bytes"},
        {{0x80, 0, 0, 0}, "2147483648 bytes"},
        {{0, 0, 0, 0}, "0 bytes"},
        {{0, 0, 0x10, 0x01}, "4097 bytes"},
        {{0x7b, 0x22, 0x70, 0x69}, "damaged"},
        {{0, 0, 0x10, 0}, "EEPROM is damaged: not JSON"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        wire w = plug_in(cases[i].bytes, 4, NULL);
        assert_refused(&w, LF_E_FORMAT, cases[i].word);
    }
    wire w = plug_in(NULL, 0, NULL);
    assert_refused(&w, LF_E_FORMAT, "blank");
}

#define WITH(pitch)                                                                                \
    "{\"pitch\":" pitch ",\"slope\":-7,\"center\":0,\"DPI\":324,\"screenW\":1536,\"screenH\":"     \
    "2048}"

static void calibrations_that_no_panel_has_are_refused(void **state)
{
    (void)state;
    static char deep[LF_HID_MAX_JSON], cells[LF_HID_MAX_JSON];
    memset(deep, '[', sizeof deep - 1);
    strcpy(cells, "{\"pitch\":52,\"slope\":-7,\"center\":0,\"DPI\":324,\"screenW\":1536,"
                  "\"screenH\":2048,\"subpixelCells\":[{}");
    for (int i = 1; i < 1000; i++)
        strcat(cells, ",{}");
    strcat(cells, "]}");
    const struct {
        const char *text, *word;
    } cases[] = {
        {"{}", "expected a number from"},
        {WITH("0"), "a number from 1 to 1000"},
        {WITH("-52"), "a number from 1 to 1000"},
        {WITH("NaN"), "not JSON"},
        {WITH("1e999"), "not JSON"},
        {WITH("1e300"), "a number from 1 to 1000"},
        {WITH("99999999999999999999999999"), "not JSON"},
        {WITH("null"), "a number from 1 to 1000"},
        {WITH("{\"value\":{}}"), "a number from 1 to 1000"},
        {WITH("\"\\u001b[2J\""), "a number from 1 to 1000"},
        {"\x1b]0;owned\x07", "not JSON"},
        {"{\"\x1b[31m\":1}", "not JSON"},
        {deep, "not JSON"},
        {cells, "at most 16 cells"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        wire w = plug_in_json(cases[i].text, strlen(cases[i].text), NULL);
        assert_refused(&w, LF_E_FORMAT, cases[i].word);
    }
}

static void an_error_holds_no_control_characters(void **state)
{
    (void)state;
    static const char text[] = "{\"pitch\": \x1b[31m}";
    wire w = plug_in_json(text, sizeof text - 1, NULL);
    lf_calibration c;
    lf_error err = {0};
    lf_assert_status(read_wire(&w, &c, &err), LF_E_FORMAT, &err);
    for (const char *p = err.what; *p != 0; p++)
        assert_true((unsigned char)*p >= 0x20 && *p != 0x7f);
    lf_model_hid_destroy(w.model);
}

/* Random faults and EEPROMs: whatever happens, nothing else than a page is asked for (read_wire
 * looks), and it ends. */
static void only_pages_are_asked_for_over_every_fault(void **state)
{
    (void)state;
    uint64_t seed = lf_test_seed();
    int n_ok = 0;
    for (int round = 0; round < 3000; round++) {
        uint8_t eeprom[LF_MODEL_EEPROM_MAX];
        size_t n = lf_model_hid_eeprom(good, strlen(good), eeprom, sizeof eeprom);
        int random[10];
        for (int i = 0; i < 10; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            random[i] = (int)(seed >> 40);
        }
        lf_model_hid_faults faults = {.split = random[0] % 2 == 0,
                                      .stale = random[1] % 4,
                                      .mute_every = random[2] % 8,
                                      .stall_every = random[3] % 8,
                                      .short_every = random[4] % 8,
                                      .press_every = random[5] % 4,
                                      .wrong_echo = random[6] % 32 == 0};
        if (random[7] % 2 == 0)
            eeprom[(size_t)random[8] % n] ^= (uint8_t)random[9];
        wire w = plug_in(eeprom, n, &faults);
        lf_calibration c;
        n_ok += read_wire(&w, &c, NULL) == LF_OK;
        lf_model_hid_destroy(w.model);
    }
    assert_true(n_ok > 300 && n_ok < 2700);
}

/* The negative control of the violations above. */
static void the_model_counts_what_must_not_be_sent(void **state)
{
    (void)state;
    wire w = plug_in_json(good, strlen(good), NULL);
    uint8_t report[LF_MODEL_FEATURE + 1] = {0};
    assert_int_equal(lf_model_hid_feature(w.model, report, LF_MODEL_FEATURE), LF_MODEL_FEATURE);
    assert_int_equal(lf_model_hid_violations(w.model), 0);
    report[0] = 1;
    assert_int_equal(lf_model_hid_feature(w.model, report, LF_MODEL_FEATURE), -EPIPE);
    assert_int_equal(lf_model_hid_violations(w.model), 1);
    report[0] = 0;
    report[66] = 1;
    assert_int_equal(lf_model_hid_feature(w.model, report, LF_MODEL_FEATURE), -EPIPE);
    report[66] = 0;
    assert_int_equal(lf_model_hid_feature(w.model, report, LF_MODEL_FEATURE - 1), -EPIPE);
    assert_int_equal(lf_model_hid_feature(w.model, report, LF_MODEL_FEATURE + 1), -EPIPE);
    assert_int_equal(lf_model_hid_violations(w.model), 4);
    lf_model_hid_destroy(w.model);
}

static void the_model_gives_what_does_not_fit_later(void **state)
{
    (void)state;
    wire w = plug_in_json(good, strlen(good), NULL);
    uint8_t request[LF_MODEL_FEATURE] = {0}, out[LF_MODEL_INPUT];
    assert_int_equal(lf_model_hid_input(w.model, out, sizeof out), -EAGAIN);
    assert_int_equal(lf_model_hid_feature(w.model, request, sizeof request), LF_MODEL_FEATURE);
    assert_int_equal(lf_model_hid_input(w.model, out, 64), 64);
    assert_int_equal(lf_model_hid_input(w.model, out + 64, 64), 4);
    assert_memory_equal(out + 8, good, 60);
    assert_int_equal(lf_model_hid_input(w.model, out, sizeof out), -EAGAIN);
    lf_model_hid_destroy(w.model);
    uint8_t small[16];
    assert_int_equal(lf_model_hid_eeprom(good, 13, small, sizeof small), 0);
    assert_int_equal(lf_model_hid_eeprom(good, 12, small, sizeof small), 16);
    static uint8_t large[LF_MODEL_EEPROM_MAX + 1];
    lf_model_hid *none = NULL;
    lf_assert_status(lf_model_hid_create(large, sizeof large, NULL, &none), LF_E_ARG, NULL);
    assert_null(none);
}

static void real_calibrations_come_through_unchanged(void **state)
{
    (void)state;
    for (int i = 0; i < LF_TEST_CALIBRATIONS; i++) {
        const char *path = lf_test_calibration(i);
        if (!path)
            skip();
        char *text = NULL;
        size_t n = 0;
        lf_calibration from_file, from_hid;
        lf_error err = {0};
        lf_assert_ok(lf_calibration_load(path, &from_file, &err), &err);
        lf_assert_ok(lf_file_read(path, NULL, LF_CALIBRATION_MAX_BYTES, &text, &n, &err), &err);
        lf_model_hid_faults faults = {.split = i % 2 == 0, .press_every = 2};
        wire w = plug_in_json(text, n, &faults);
        lf_assert_ok(read_wire(&w, &from_hid, &err), &err);
        assert_memory_equal(&from_hid, &from_file, sizeof from_file);
        lf_model_hid_destroy(w.model);
        lf_free(text);
    }
}

static void a_path_that_is_no_panel_is_refused_with_a_reason(void **state)
{
    (void)state;
    lf_hid_link link = {0};
    lf_error err = {0};
    lf_assert_status(lf_hid_open("/nonexistent/hidraw0", &link, &err), LF_E_NODEV, &err);
    lf_assert_status(lf_hid_open("/dev/null", &link, &err), LF_E_IO, &err);
    assert_string_equal(err.where, "/dev/null");
    lf_hid_close(&link);
    lf_hid_place places[4];
    assert_in_range(lf_hid_list(places, 4), 0, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_healthy_panel_tells_its_calibration),
        cmocka_unit_test(every_length_of_text_is_read_to_its_end),
        cmocka_unit_test(faults_that_pass_do_not_matter),
        cmocka_unit_test(faults_that_stay_end_in_one_clear_error),
        cmocka_unit_test(what_was_asked_before_is_dropped),
        cmocka_unit_test(a_slow_panel_is_not_waited_for_for_ever),
        cmocka_unit_test(replies_that_trickle_in_do_not_stretch_the_time),
        cmocka_unit_test(unplugging_is_told_as_such),
        cmocka_unit_test(blank_and_lying_lengths_are_refused),
        cmocka_unit_test(calibrations_that_no_panel_has_are_refused),
        cmocka_unit_test(an_error_holds_no_control_characters),
        cmocka_unit_test(only_pages_are_asked_for_over_every_fault),
        cmocka_unit_test(the_model_counts_what_must_not_be_sent),
        cmocka_unit_test(the_model_gives_what_does_not_fit_later),
        cmocka_unit_test(real_calibrations_come_through_unchanged),
        cmocka_unit_test(a_path_that_is_no_panel_is_refused_with_a_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
