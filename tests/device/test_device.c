/* The table: specs, list, auto, and the device that shows nothing. */
#include "tests/testing.h"

#include <unistd.h>

#include "device/device_table.h"

static void bad_specs_are_refused_with_a_reason(void **state)
{
    (void)state;
    char long_spec[600];
    memset(long_spec, 'x', sizeof long_spec - 1);
    memcpy(long_spec, "sim:", 4);
    long_spec[sizeof long_spec - 1] = 0;
    const char *bad[] = {"",
                         "sims:/tmp",
                         "si",
                         ":",
                         "none:x",
                         "usb:x",
                         "usb:1",
                         "drm:x",
                         "drm:card0",
                         "drms",
                         "auto:x",
                         "sim",
                         "sim:",
                         "sim:,latency=1",
                         "sim:/tmp/x,latency",
                         "sim:/tmp/x,latency=",
                         "sim:/tmp/x,latency=-1",
                         "sim:/tmp/x,latency=1e3",
                         "sim:/tmp/x,latency=99999999999999999999999",
                         "sim:/tmp/x,latencies=1",
                         "sim:/tmp/x,late=1",
                         "sim:/tmp/x,stall=0",
                         "sim:/tmp/x,stall=1:",
                         "sim:/tmp/x,stall=1:x",
                         "sim:/tmp/x,stall=:5",
                         "sim:/tmp/x,error=0",
                         "sim:/tmp/x,unplug=0",
                         "sim:/tmp/x,bandwidth=0",
                         "sim:/tmp/x,rotate=0",
                         "sim:/tmp/x,eye=",
                         "sim:/tmp/x,eye=nan",
                         "sim:/tmp/x,eye=91",
                         "sim:/tmp/x,eye=1-",
                         "sim:/tmp/x,",
                         "sim:/tmp/x,,",
                         long_spec};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_device *device = NULL;
        lf_error err = {0};
        lf_status status = lf_device_open(bad[i], NULL, &device, &err);
        if (status != LF_E_ARG)
            print_error("spec \"%s\"\n", bad[i]);
        lf_assert_status(status, LF_E_ARG, &err);
        assert_null(device);
        assert_true(err.what[0] != 0);
    }
    assert_int_not_equal(access("/tmp/x,", F_OK), 0);
}

static void none_takes_and_counts_everything(void **state)
{
    (void)state;
    lf_device *device = NULL;
    lf_device_info info;
    lf_device_counters counters;
    lf_assert_ok(lf_device_open("none", NULL, &device, NULL), NULL);
    assert_null(device->ops->calibration(device));
    assert_int_equal(device->ops->poll_fd(device), -1);
    const lf_rect rects[] = {{0, 0, 10, 20}, {5, 5, 1, 1}};
    for (uint64_t i = 0; i < 3; i++) {
        assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
        lf_assert_ok(device->ops->push(device, NULL, rects, 2, i), NULL);
    }
    lf_assert_ok(device->ops->flush(device, 0), NULL);
    device->ops->counters(device, &counters);
    assert_int_equal(counters.updates, 6);
    assert_int_equal(counters.bytes, 3 * 3 * 201);
    assert_int_equal(counters.errors, 0);
    device->ops->info(device, &info);
    assert_string_equal(info.spec, "none");
    assert_string_equal(info.problem, "");
    assert_string_equal(info.calibration_from, "");
    lf_device_destroy(device);
    lf_device_destroy(NULL);
}

static void all_kinds_are_in_the_table(void **state)
{
    (void)state;
    static const char *const kinds[] = {"drm", "window", "usb", "sim", "none"};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        bool found = false;
        for (int i = 0; lf_device_table[i]; i++)
            found = found || strcmp(lf_device_table[i]->kind, kinds[k]) == 0;
        if (!found)
            fail_msg("%s is not there", kinds[k]);
    }
}

static void list_has_what_can_be_opened(void **state)
{
    (void)state;
    lf_device_info list[8];
    int n = lf_device_list(list, 8);
    assert_in_range(n, 1, 8);
    assert_string_equal(list[n - 1].spec, "none");
    assert_string_equal(list[n - 1].kind, "none");
    assert_int_equal(lf_device_list(list, 0), 0);
}

static void without_a_panel_none_is_found(void **state)
{
    (void)state;
    static const lf_device_ops *const no_panels[] = {&lf_sim_ops, &lf_none_ops, NULL};
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_status(lf_device_find_in(no_panels, "", NULL, &device, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "no panel was found; "));
    assert_null(device);
}

/* A kind with panels of which one is in use. Opens as a "none" whose problem is the name. */
static lf_status fake_open(const char *argument, const lf_calibration *calibration,
                           lf_device **out_device, lf_error *err)
{
    (void)calibration;
    if (strcmp(argument, "taken") == 0)
        return lf_error_set(err, LF_E_BUSY, argument, "another program has it");
    if (strcmp(argument, "unmeasured") == 0)
        return lf_error_set(err, LF_E_NODEV, argument, "its calibration is not known");
    return lf_none_create(argument, out_device, err);
}

static int probe_n(lf_device_info *out, int max, int n)
{
    static const char *const specs[] = {"fake:taken", "fake:free", "fake:free too"};
    n = n < max ? n : max;
    for (int i = 0; i < n; i++) {
        out[i] = (lf_device_info){.kind = "fake", .model = "a panel"};
        snprintf(out[i].spec, sizeof out[i].spec, "%s", specs[i]);
    }
    return n;
}

static int probe_unmeasured(lf_device_info *out, int max)
{
    assert_true(max > 0);
    *out = (lf_device_info){.spec = "fake:unmeasured", .kind = "fake", .model = "a panel"};
    return 1;
}

static int probe_unknown(lf_device_info *out, int max)
{
    int n = probe_n(out, max, 2);
    for (int i = 0; i < n; i++) {
        out[i].model[0] = 0;
        snprintf(out[i].problem, sizeof out[i].problem, "it does not say what it is");
    }
    return n;
}

static int probe_one(lf_device_info *out, int max)
{
    return probe_n(out, max, 1);
}

static int probe_two(lf_device_info *out, int max)
{
    return probe_n(out, max, 2);
}

static int probe_open(lf_device_info *out, int max)
{
    int n = probe_n(out, max, 3);
    memmove(out, out + 1, (size_t)(n - 1) * sizeof *out);
    return n - 1;
}

static void assert_finds(const lf_device_ops *const table[], const char *first,
                         const char *expected)
{
    lf_device *device = NULL;
    lf_device_info info;
    lf_error err = {0};
    lf_assert_ok(lf_device_find_in(table, first, NULL, &device, &err), &err);
    device->ops->info(device, &info);
    assert_string_equal(info.problem, expected);
    lf_device_destroy(device);
}

static void assert_finds_none(const lf_device_ops *const table[], const char *first,
                              lf_status status, const char *why)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_status(lf_device_find_in(table, first, NULL, &device, &err), status, &err);
    assert_string_equal(err.what, why);
    assert_null(device);
}

static void the_first_panel_that_opens_is_found(void **state)
{
    (void)state;
    const lf_device_ops two = {.kind = "fake", .probe = probe_two, .open = fake_open};
    const lf_device_ops one = {.kind = "fake", .probe = probe_one, .open = fake_open};
    const lf_device_ops unknown = {.kind = "fake", .probe = probe_unknown, .open = fake_open};
    const lf_device_ops *const with_free[] = {&lf_sim_ops, &two, &lf_none_ops, NULL};
    const lf_device_ops *const all_taken[] = {&one, NULL}, *const no_panels[] = {&unknown, NULL};
    const lf_device_ops *const taken_and_unknown[] = {&one, &unknown, NULL};
    assert_finds(with_free, "", "free");
    assert_finds_none(all_taken, "", LF_E_BUSY,
                      "fake:taken cannot be used: another program has it");
    assert_finds_none(no_panels, "", LF_E_NODEV, "it does not say what it is");
    assert_finds_none(taken_and_unknown, "", LF_E_BUSY,
                      "fake:taken cannot be used: another program has it");
}

/* Looking for it again and again would have its drive mounted each time. */
static void a_panel_without_a_calibration_waits_for_what_is_plugged_in(void **state)
{
    (void)state;
    const lf_device_ops unmeasured = {.kind = "fake", .probe = probe_unmeasured, .open = fake_open};
    const lf_device_ops unknown = {.kind = "fake", .probe = probe_unknown, .open = fake_open};
    const lf_device_ops taken = {.kind = "fake", .probe = probe_one, .open = fake_open};
    const lf_device_ops *const alone[] = {&unmeasured, &unknown, NULL}, *const with_taken[] = {
                                                                            &unmeasured, &taken,
                                                                            NULL};
    assert_finds_none(alone, "", LF_E_NODEV,
                      "fake:unmeasured cannot be used: its calibration is not known");
    assert_finds_none(with_taken, "", LF_E_BUSY,
                      "fake:taken cannot be used: another program has it");
}

/* What was there before may be another thing by now: an ordinary monitor on the panel's output. */
static void what_was_there_last_comes_first_only_while_it_is_a_panel(void **state)
{
    (void)state;
    const lf_device_ops open = {.kind = "fake", .probe = probe_open, .open = fake_open};
    const lf_device_ops unknown = {.kind = "fake", .probe = probe_unknown, .open = fake_open};
    const lf_device_ops *const with_two[] = {&open, NULL}, *const no_panels[] = {&unknown, NULL};
    assert_finds(with_two, "", "free");
    assert_finds(with_two, "fake:free too", "free too");
    /* it could be opened by this name, and is not listed */
    assert_finds(with_two, "fake:monitor", "free");
    assert_finds(with_two, "fakes:free too", "free");
    assert_finds_none(no_panels, "fake:free", LF_E_NODEV, "it does not say what it is");
}

static void texts_are_sanitised_and_cut_between_characters(void **state)
{
    (void)state;
    char out[8];
    lf_device_text(out, sizeof out, "a\n\x1b\x7f");
    assert_string_equal(out, "a???");
    lf_device_text(out, sizeof out, "\xc3\xa4\xff\xc3");
    assert_string_equal(out, "\xc3\xa4??");
    lf_device_text(out, sizeof out, "123456\xc3\xa4");
    assert_string_equal(out, "123456");
    lf_device_text(out, sizeof out, "\xc0\xaf\xed\xa0\x80");
    assert_string_equal(out, "?????");
    lf_device_text(out, sizeof out, "\xc2\x85\xf0\x9f\x98\x80");
    assert_string_equal(out, "??\xf0\x9f\x98\x80");
}

static void a_spec_says_what_its_kind_is_like(void **state)
{
    (void)state;
    const struct {
        const char *spec;
        bool is_auto, is_panel, is_hardware;
    } facts[] = {{"auto", true, true, true},         {"drm:HDMI-A-1", false, true, true},
                 {"window", false, true, true},      {"usb:1-1", false, true, true},
                 {"sim:/tmp/x", false, true, false}, {"none", false, false, false},
                 {"simulated", false, true, true},   {"autos", false, true, true}};
    for (size_t i = 0; i < sizeof facts / sizeof *facts; i++) {
        assert_int_equal(lf_device_is_auto(facts[i].spec), facts[i].is_auto);
        assert_int_equal(lf_device_is_panel(facts[i].spec), facts[i].is_panel);
        assert_int_equal(lf_device_is_hardware(facts[i].spec), facts[i].is_hardware);
    }
    assert_true(lf_device_has_kind("usb:1-1", "usb"));
    assert_false(lf_device_has_kind("usb:1-1", "usbip"));
    assert_false(lf_device_has_kind("usbip:1-1", "usb"));
}

static void only_a_device_that_may_be_the_same_is_closed_first(void **state)
{
    (void)state;
    char folder[] = "/tmp/test_device.XXXXXX", ours[64], link_spec[72], link[48];
    assert_non_null(mkdtemp(folder));
    snprintf(ours, sizeof ours, "sim:%s,latency=1", folder);
    snprintf(link, sizeof link, "%s/itself", folder);
    snprintf(link_spec, sizeof link_spec, "sim:%s", link);
    assert_int_equal(symlink(".", link), 0);
    assert_true(lf_device_same(ours, link_spec));
    assert_true(lf_device_same(ours, "auto"));
    assert_false(lf_device_same(ours, "sim:/"));
    assert_false(lf_device_same(ours, "sim:/nowhere"));
    assert_false(lf_device_same(ours, "usb:1-1"));
    assert_true(lf_device_same("usb:1-1", "usb"));
    assert_false(lf_device_same("usb:1-1", "drm"));
    assert_int_equal(unlink(link), 0);
    assert_int_equal(rmdir(folder), 0);
}

static void a_spec_says_which_folder_it_writes_into(void **state)
{
    (void)state;
    size_t n = 0;
    const char *spec = "sim:/tmp/x,latency=1";
    assert_ptr_equal(lf_device_folder(spec, &n), spec + 4);
    assert_int_equal(n, 6);
    assert_non_null(lf_device_folder("sim:", &n));
    assert_int_equal(n, 0);
    const char *const nowhere[] = {"sim", "none", "auto", "usb:1-1", "sims:/tmp"};
    for (size_t i = 0; i < sizeof nowhere / sizeof *nowhere; i++)
        assert_null(lf_device_folder(nowhere[i], &n));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_specs_are_refused_with_a_reason),
        cmocka_unit_test(none_takes_and_counts_everything),
        cmocka_unit_test(all_kinds_are_in_the_table),
        cmocka_unit_test(list_has_what_can_be_opened),
        cmocka_unit_test(without_a_panel_none_is_found),
        cmocka_unit_test(the_first_panel_that_opens_is_found),
        cmocka_unit_test(a_panel_without_a_calibration_waits_for_what_is_plugged_in),
        cmocka_unit_test(what_was_there_last_comes_first_only_while_it_is_a_panel),
        cmocka_unit_test(a_spec_says_what_its_kind_is_like),
        cmocka_unit_test(only_a_device_that_may_be_the_same_is_closed_first),
        cmocka_unit_test(a_spec_says_which_folder_it_writes_into),
        cmocka_unit_test(texts_are_sanitised_and_cut_between_characters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
