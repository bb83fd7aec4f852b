/* The USB/IP server over a socket pair, driven as the kernel drives it. */
#include "tests/device/usbip_host.h"

#include "base/thread.h"
#include "device/model/vhci.h"

/* --------------------------------------------------------------------------------- handshake -- */

static void the_device_is_listed_and_then_the_connection_ends(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, false);
    uint8_t got[12 + RECORD + 8 + 1];
    send_all(f, "\x01\x11\x80\x05\0\0\0\0", 8);
    lf_assert_status(run(f), LF_E_NODEV, NULL);
    assert_int_equal(get(f, got, sizeof got), sizeof got - 1);
    assert_memory_equal(got, "\x01\x11\x00\x05\0\0\0\0\0\0\0\1", 12);
    assert_string_equal((const char *)got + 12 + 256, "1-1");
    assert_int_equal(get32(got + 12 + 288) << 16 | get32(got + 12 + 292), LF_USBIP_DEVID);
    assert_memory_equal(got + 12 + 300, "\x04\xd8\xef\x7e", 4);
    assert_int_equal(got[12 + 311], 2);
    assert_memory_equal(got + 12 + RECORD, "\x03\0\0\0\xff\0\0\0", 8);
    end(f);
}

static void an_unplugged_device_is_not_listed(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, false);
    lf_model *model = f->device.model;
    uint8_t got[13];
    f->device.model = NULL;
    send_all(f, "\x01\x11\x80\x05\0\0\0\0", 8);
    lf_assert_status(run(f), LF_E_NODEV, NULL);
    assert_int_equal(get(f, got, sizeof got), 12);
    assert_int_equal(get32(got + 8), 0);
    f->device.model = model;
    end(f);
}

static uint32_t import_status(fixture *f, const char *busid)
{
    uint8_t request[40] = {0x01, 0x11, 0x80, 0x03}, got[8];
    snprintf((char *)request + 8, 32, "%s", busid);
    send_all(f, request, sizeof request);
    run(f);
    assert_int_equal(get(f, got, sizeof got), 8);
    assert_memory_equal(got, "\x01\x11\x00\x03", 4);
    return get32(got + 4);
}

static void it_is_imported_once(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, false), second = {0};
    uint8_t record[RECORD];
    int ends[2];
    assert_int_equal(import_status(f, "1-1"), 0);
    assert_int_equal(get(f, record, sizeof record), RECORD);
    assert_true(lf_usbip_imported(f->usbip));
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    second.fd = ends[0];
    lf_assert_ok(lf_usbip_create(&f->device, ends[1], false, &second.usbip), NULL);
    assert_int_equal(import_status(&second, "1-1"), 1);
    lf_assert_status(second.last, LF_E_NODEV, NULL);
    lf_usbip_destroy(second.usbip);
    close(ends[0]);
    assert_true(f->device.taken);
    end(f);
}

static void another_name_is_not_imported(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, false);
    assert_int_equal(import_status(f, "1-2"), 1);
    assert_false(lf_usbip_imported(f->usbip));
    end(f);
}

/* --------------------------------------------------------------------------------- transfers -- */

static void descriptors_come_through(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    const uint8_t setup[8] = {0x80, 6, 0, 1, 0, 0, 64, 0},
                  unknown[8] = {0x80, 6, 0, 15, 0, 0, 64, 0};
    uint8_t d[64];
    submit(f, 7, true, 0, setup, NULL, 64);
    reply r = next_reply(f, true, d, sizeof d);
    assert_int_equal(r.seqnum, 7);
    assert_int_equal(r.status, 0);
    assert_int_equal(r.n, 18);
    assert_int_equal(d[0], 18);
    submit(f, 8, true, 0, unknown, NULL, 64);
    expect(f, RET_SUBMIT, 8, -EPIPE);
    end(f);
}

static void an_interrupt_transfer_waits_for_a_report(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t report[LF_MODEL_INPUT];
    submit(f, 1, true, 1, NULL, NULL, LF_MODEL_INPUT);
    assert_true(silent(f));
    ask(f, 2, 0);
    expect(f, RET_SUBMIT, 2, 0); /* the later one is answered first */
    reply r = next_reply(f, true, report, sizeof report);
    assert_int_equal(r.seqnum, 1);
    assert_int_equal(r.n, LF_MODEL_INPUT);
    assert_memory_equal(report + 4, "\0\0\0\2{}", 6);
    submit(f, 3, true, 1, NULL, NULL, LF_MODEL_INPUT);
    assert_true(silent(f));
    lf_model_hid_press(f->hid, 2);
    r = next_reply(f, true, report, sizeof report);
    assert_int_equal(r.seqnum, 3);
    assert_int_equal(report[0], 2);
    end(f);
}

static void an_unlinked_transfer_is_never_answered(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    submit(f, 1, true, 1, NULL, NULL, LF_MODEL_INPUT);
    unlink_urb(f, 2, 1);
    expect(f, RET_UNLINK, 2, -ECONNRESET);
    lf_model_hid_press(f->hid, 1);
    assert_true(silent(f));
    unlink_urb(f, 3, 1);
    expect(f, RET_UNLINK, 3, 0); /* it is not there any more */
    end(f);
}

static void a_rectangle_is_shown(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t row[WIDTH * 3];
    for (int i = 0; i < WIDTH * 3; i++)
        row[i] = (uint8_t)i;
    light(f);
    announce(f, 1);
    submit(f, 5, false, 2, NULL, row, sizeof row);
    reply r = next_reply(f, false, NULL, 0);
    assert_int_equal(r.status, 0);
    assert_int_equal(r.n, sizeof row);
    assert_int_equal(lf_model_gud_pixels(f->gud)[0], 2); /* B, G, R on the wire */
    assert_int_equal(lf_model_gud_pixels(f->gud)[2], 0);
    end(f);
}

static void a_slow_display_delays_nobody_else(void **state)
{
    (void)state;
    const lf_model_gud_faults slow = {.bytes_per_s = WIDTH * 3};
    fixture *f = connect_to(NULL, &slow, true);
    uint8_t row[WIDTH * 3] = {0};
    struct pollfd p;
    light(f);
    announce(f, 2);
    submit(f, 5, false, 2, NULL, row, sizeof row);
    submit(f, 6, false, 2, NULL, row, sizeof row);
    assert_true(silent(f));
    assert_int_equal(lf_usbip_poll(f->usbip, f->now, &p), 1000);
    ask(f, 7, 0);
    expect(f, RET_SUBMIT, 7, 0);
    f->now += LF_NS_PER_S - 1;
    assert_true(silent(f));
    f->now += 1;
    expect(f, RET_SUBMIT, 5, 0);
    assert_true(silent(f)); /* the second has begun only now */
    f->now += LF_NS_PER_S;
    expect(f, RET_SUBMIT, 6, 0);
    end(f);
}

static void a_display_that_hangs_is_freed_by_unlinking(void **state)
{
    (void)state;
    const lf_model_gud_faults hangs = {.hang_every = 1};
    fixture *f = connect_to(NULL, &hangs, true);
    uint8_t row[WIDTH * 3] = {0};
    light(f);
    announce(f, 1);
    submit(f, 5, false, 2, NULL, row, sizeof row);
    assert_true(silent(f));
    f->now += 1000 * LF_NS_PER_S;
    assert_true(silent(f));
    unlink_urb(f, 6, 5);
    expect(f, RET_UNLINK, 6, -ECONNRESET);
    end(f);
}

static void a_display_that_goes_takes_the_connection_with_it(void **state)
{
    (void)state;
    const lf_model_gud_faults goes = {.unplug_after = 1};
    fixture *f = connect_to(NULL, &goes, true);
    uint8_t row[WIDTH * 3] = {0};
    light(f);
    announce(f, 1);
    submit(f, 5, false, 2, NULL, row, sizeof row);
    run(f);
    if (f->last == LF_OK) {
        submit(f, 6, false, 2, NULL, row, sizeof row);
        run(f);
    }
    lf_assert_status(f->last, LF_E_NODEV, NULL);
    end(f);
}

static void a_host_that_goes_frees_the_device(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    submit(f, 1, true, 1, NULL, NULL, LF_MODEL_INPUT);
    assert_true(silent(f));
    shutdown(f->fd, SHUT_RDWR);
    lf_assert_status(run(f), LF_E_NODEV, NULL);
    end(f);
}

static void unplugging_ends_the_connection(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    lf_model *model = f->device.model;
    f->device.model = NULL;
    lf_assert_status(run(f), LF_E_NODEV, NULL);
    f->device.model = model;
    end(f);
}

/* Headers cut anywhere are put together. */
static void messages_may_come_in_pieces(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t header[HEADER], data[LF_MODEL_FEATURE] = {0};
    make_header(header, SUBMIT, 9, false, 0);
    put32(header + 24, sizeof data);
    memcpy(header + 40, ask_page, 8);
    for (size_t i = 0; i < sizeof header; i++) {
        send_all(f, header + i, 1);
        assert_true(silent(f));
    }
    for (size_t i = 0; i + 1 < sizeof data; i++) {
        send_all(f, data + i, 1);
        assert_true(silent(f));
    }
    send_all(f, data, 1);
    expect(f, RET_SUBMIT, 9, 0);
    end(f);
}

/* -------------------------------------------------------------------------------------- vhci -- */

static void the_first_free_port_is_taken(void **state)
{
    (void)state;
    char *dir = lf_test_folder(), text[64];
    int fd = -1, end_fd = -1;
    unsigned port, devid, speed;
    lf_error err;
    lf_test_write(dir, "status",
                  "hub port sta spd dev      sockfd local_busid\n"
                  "hs  0000 006 003 00010002 000003 1-1\n"
                  "ss  0001 004 000 00000000 000000 0-0\n"
                  "hs  0002 004 000 00000000 000000 0-0\n");
    const char *attach = lf_test_write(dir, "attach", "");
    lf_assert_ok(lf_vhci_attach(dir, &fd, &err), &err);
    FILE *file = fopen(attach, "r");
    assert_non_null(file);
    assert_non_null(fgets(text, sizeof text, file));
    fclose(file);
    assert_int_equal(sscanf(text, "%u %d %u %u", &port, &end_fd, &devid, &speed), 4);
    assert_int_equal(port, 2);
    assert_int_equal(devid, LF_USBIP_DEVID);
    assert_int_equal(speed, 3);
    assert_true(end_fd >= 0);
    close(fd);
    lf_test_write(dir, "status", "hs  0000 006 003 00010002 000003 1-1\n");
    lf_assert_status(lf_vhci_attach(dir, &fd, &err), LF_E_BUSY, &err);
    lf_assert_status(lf_vhci_attach("/nonexistent", &fd, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "modprobe vhci_hcd"));
    lf_test_folder_remove(dir);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_device_is_listed_and_then_the_connection_ends),
        cmocka_unit_test(an_unplugged_device_is_not_listed),
        cmocka_unit_test(it_is_imported_once),
        cmocka_unit_test(another_name_is_not_imported),
        cmocka_unit_test(descriptors_come_through),
        cmocka_unit_test(an_interrupt_transfer_waits_for_a_report),
        cmocka_unit_test(an_unlinked_transfer_is_never_answered),
        cmocka_unit_test(a_rectangle_is_shown),
        cmocka_unit_test(a_slow_display_delays_nobody_else),
        cmocka_unit_test(a_display_that_hangs_is_freed_by_unlinking),
        cmocka_unit_test(a_display_that_goes_takes_the_connection_with_it),
        cmocka_unit_test(a_host_that_goes_frees_the_device),
        cmocka_unit_test(unplugging_ends_the_connection),
        cmocka_unit_test(messages_may_come_in_pieces),
        cmocka_unit_test(the_first_free_port_is_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
