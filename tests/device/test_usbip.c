/* The USB/IP server over a socket pair, driven as the kernel drives it, and as nobody should. */
#include "tests/testing.h"

#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/socket.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/model/usb_model.h"
#include "device/model/usbip.h"
#include "device/model/vhci.h"
#include "device/usb/gud.h"

enum {
    WIDTH = 64,
    HEIGHT = 32,
    SUBMIT = 1,
    UNLINK = 2,
    RET_SUBMIT = 3,
    RET_UNLINK = 4,
    HEADER = 48,
    RECORD = 312,
    RUNS = 64
};

typedef struct fixture {
    lf_model_hid *hid;
    lf_model_gud *gud;
    lf_usbip_device device;
    lf_usbip *usbip;
    int fd;         /* the host's end */
    uint64_t now;   /* the server's clock */
    lf_status last; /* of the last run */
} fixture;

static fixture *connect_to(const lf_model_hid_faults *hid_faults,
                           const lf_model_gud_faults *gud_faults, bool imported)
{
    static const uint8_t rgb888 = LF_GUD_RGB888;
    const lf_model_gud_options options = {
        .width = WIDTH, .height = HEIGHT, .formats = &rgb888, .n_formats = 1};
    fixture *f = calloc(1, sizeof *f);
    int ends[2];
    assert_non_null(f);
    lf_assert_ok(lf_model_hid_create("\0\0\0\2{}", 6, hid_faults, &f->hid), NULL);
    lf_assert_ok(lf_model_gud_create(&options, gud_faults, &f->gud), NULL);
    lf_assert_ok(lf_model_create(f->hid, f->gud, &f->device.model), NULL);
    f->device.gud = f->gud;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    f->fd = ends[0];
    assert_int_equal(fcntl(f->fd, F_SETFL, O_NONBLOCK), 0);
    lf_assert_ok(lf_usbip_create(&f->device, ends[1], imported, &f->usbip), NULL);
    return f;
}

static void end(fixture *f)
{
    lf_usbip_destroy(f->usbip);
    assert_false(f->device.taken);
    lf_model_destroy(f->device.model);
    lf_model_gud_destroy(f->gud);
    lf_model_hid_destroy(f->hid);
    close(f->fd);
    free(f);
}

/* Runs the server until it has nothing to do at this time. */
static lf_status run(fixture *f)
{
    struct pollfd p;
    for (int i = 0; i < RUNS; i++) {
        f->last = lf_usbip_run(f->usbip, f->now, NULL);
        if (f->last != LF_OK)
            return f->last;
        int ms = lf_usbip_poll(f->usbip, f->now, &p);
        if (ms != 0 && poll(&p, 1, 0) == 0)
            return LF_OK;
    }
    fail_msg("the server does not come to rest");
    return LF_E_TIMEOUT;
}

static void put32(uint8_t *at, uint32_t v)
{
    v = htobe32(v);
    memcpy(at, &v, 4);
}

static uint32_t get32(const uint8_t *at)
{
    uint32_t v;
    memcpy(&v, at, 4);
    return be32toh(v);
}

static void send_all(fixture *f, const void *data, size_t n)
{
    const uint8_t *from = data;
    while (n > 0) {
        ssize_t sent = send(f->fd, from, n, MSG_NOSIGNAL);
        if (sent < 0 && errno == EAGAIN) {
            lf_assert_ok(run(f), NULL);
            continue;
        }
        assert_true(sent > 0);
        from += sent;
        n -= (size_t)sent;
    }
}

static void make_header(uint8_t header[HEADER], uint32_t command, uint32_t seqnum, bool in,
                        uint32_t endpoint)
{
    memset(header, 0, HEADER);
    put32(header, command);
    put32(header + 4, seqnum);
    put32(header + 8, LF_USBIP_DEVID);
    put32(header + 12, in);
    put32(header + 16, endpoint);
}

static void submit(fixture *f, uint32_t seqnum, bool in, uint32_t endpoint, const uint8_t *setup,
                   const void *data, uint32_t n)
{
    uint8_t header[HEADER];
    make_header(header, SUBMIT, seqnum, in, endpoint);
    put32(header + 24, n);
    put32(header + 32, 0xffffffff);
    if (setup)
        memcpy(header + 40, setup, 8);
    send_all(f, header, sizeof header);
    if (!in && n > 0)
        send_all(f, data, n);
}

static void unlink_urb(fixture *f, uint32_t seqnum, uint32_t which)
{
    uint8_t header[HEADER];
    make_header(header, UNLINK, seqnum, false, 0);
    put32(header + 20, which);
    send_all(f, header, sizeof header);
}

/* What the host has got; -1 when there is nothing (now). */
static ssize_t get(fixture *f, void *out, size_t n)
{
    size_t got = 0;
    while (got < n) {
        ssize_t r = recv(f->fd, (uint8_t *)out + got, n - got, 0);
        if (r <= 0)
            return got > 0 ? (ssize_t)got : r;
        got += (size_t)r;
    }
    return (ssize_t)got;
}

static bool silent(fixture *f)
{
    uint8_t byte;
    run(f);
    return get(f, &byte, 1) < 0 && errno == EAGAIN;
}

typedef struct reply {
    uint32_t command, seqnum;
    int status;
    uint32_t n;
} reply;

/* The next answer; its data (IN) to out[max]. */
static reply next_reply(fixture *f, bool in, void *out, size_t max)
{
    uint8_t header[HEADER];
    if (f->last == LF_OK)
        run(f);
    assert_int_equal(get(f, header, sizeof header), HEADER);
    reply r = {get32(header), get32(header + 4), (int32_t)get32(header + 20), get32(header + 24)};
    for (int i = 8; i < 20; i++)
        assert_int_equal(header[i], 0); /* device, direction and endpoint are not repeated */
    if (r.command == RET_SUBMIT && in && r.n > 0) {
        assert_true(r.n <= max);
        assert_int_equal(get(f, out, r.n), r.n);
    }
    return r;
}

static void expect(fixture *f, uint32_t command, uint32_t seqnum, int status)
{
    reply r = next_reply(f, false, NULL, 0);
    assert_int_equal(r.command, command);
    assert_int_equal(r.seqnum, seqnum);
    assert_int_equal(r.status, status);
}

static const uint8_t ask_page[8] = {0x21, 9, 0, 3, 0, 0, LF_MODEL_FEATURE, 0};

/* SET_REPORT for a page, with its answer taken. */
static void ask(fixture *f, uint32_t seqnum, uint8_t page)
{
    uint8_t data[LF_MODEL_FEATURE] = {0, 0, page};
    submit(f, seqnum, false, 0, ask_page, data, sizeof data);
}

/* Makes the display ready and announces `rows` rows from the top; the answers are taken. */
static void announce(fixture *f, uint32_t rows)
{
    const uint8_t set_buffer[8] = {0x41, 0x60, 0, 0, 1, 0, 25, 0};
    uint8_t data[25] = {0};
    data[8] = WIDTH;
    data[12] = (uint8_t)rows;
    uint32_t bytes = rows * WIDTH * 3;
    for (int i = 0; i < 4; i++)
        data[16 + i] = (uint8_t)(bytes >> (8 * i));
    submit(f, 900, false, 0, set_buffer, data, sizeof data);
    expect(f, RET_SUBMIT, 900, 0);
}

static void light(fixture *f)
{
    const uint8_t get_modes[8] = {0xc1, 0x55, 0, 0, 1, 0, 24, 0},
                  on[8] = {0x41, 0x63, 0, 0, 1, 0, 1, 0};
    const uint8_t check[8] = {0x41, 0x61, 0, 0, 1, 0, 46, 0},
                  commit[8] = {0x41, 0x62, 0, 0, 1, 0, 0, 0};
    const uint8_t display[8] = {0x41, 0x64, 0, 0, 1, 0, 1, 0}, one = 1;
    /* mode, format, connector, backlight, rotation */
    uint8_t state[46] = {[24] = LF_GUD_RGB888, [26] = 12, [28] = 100, [36] = 50, [38] = 1};
    submit(f, 800, true, 0, get_modes, NULL, 24);
    assert_int_equal(next_reply(f, true, state, 24).n, 24);
    submit(f, 801, false, 0, check, state, sizeof state);
    submit(f, 802, false, 0, on, &one, 1);
    submit(f, 803, false, 0, commit, NULL, 0);
    submit(f, 804, false, 0, display, &one, 1);
    for (uint32_t i = 801; i < 805; i++)
        expect(f, RET_SUBMIT, i, 0);
    assert_true(lf_model_gud_lit(f->gud));
}

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

/* --------------------------------------------------------------------------- hostile clients -- */

static void nonsense_ends_the_connection(void **state)
{
    (void)state;
    static const struct {
        bool imported;
        size_t at; /* in a good header */
        uint32_t value;
    } cases[] = {
        {false, 0, 0x01060000 | 0x8005},
        {false, 0, 0x01118009},
        {true, 0, 0},
        {true, 0, RET_SUBMIT},
        {true, 8, 0x00020001},
        {true, 12, 2},
        {true, 16, 16},
        {true, 32, 8},
        {true, 0, 0xffffffff},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fixture *f = connect_to(NULL, NULL, cases[i].imported);
        uint8_t header[HEADER];
        make_header(header, SUBMIT, 1, true, 1);
        put32(header + cases[i].at, cases[i].value);
        send_all(f, header, sizeof header);
        lf_assert_status(run(f), LF_E_FORMAT, NULL);
        end(f);
    }
}

static void a_claim_of_4_gib_is_not_believed(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t header[HEADER];
    uint64_t before = lf_alloc_count();
    make_header(header, SUBMIT, 1, false, 2);
    put32(header + 24, UINT32_MAX);
    send_all(f, header, sizeof header);
    expect(f, RET_SUBMIT, 1, -ENOMEM);
    assert_int_equal(lf_alloc_count(), before);
    end(f);
}

/* What was refused is read over: the message behind it is understood. */
static void refused_data_is_skipped(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t *data = calloc(1, LF_USBIP_MAX_TRANSFER + 1);
    assert_non_null(data);
    submit(f, 1, false, 2, NULL, data, LF_USBIP_MAX_TRANSFER + 1);
    expect(f, RET_SUBMIT, 1, -ENOMEM);
    ask(f, 2, 0);
    expect(f, RET_SUBMIT, 2, 0);
    free(data);
    end(f);
}

static void waiting_transfers_are_bounded(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    for (uint32_t i = 0; i < LF_USBIP_MAX_URBS; i++) {
        submit(f, 1 + i, true, 1, NULL, NULL, LF_MODEL_INPUT);
        lf_assert_ok(run(f), NULL);
    }
    assert_true(silent(f));
    submit(f, 5000, true, 1, NULL, NULL, LF_MODEL_INPUT);
    expect(f, RET_SUBMIT, 5000, -ENOMEM);
    unlink_urb(f, 5001, 1);
    expect(f, RET_UNLINK, 5001, -ECONNRESET);
    submit(f, 5002, true, 1, NULL, NULL, LF_MODEL_INPUT);
    assert_true(silent(f));
    end(f);
}

static void waiting_bytes_are_bounded(void **state)
{
    (void)state;
    const lf_model_gud_faults slow = {.bytes_per_s = 1};
    fixture *f = connect_to(NULL, &slow, true);
    uint8_t *data = calloc(1, LF_USBIP_MAX_TRANSFER);
    assert_non_null(data);
    for (uint32_t i = 0; i < LF_USBIP_MAX_WAITING / LF_USBIP_MAX_TRANSFER; i++)
        submit(f, 1 + i, false, 2, NULL, data, LF_USBIP_MAX_TRANSFER);
    assert_true(silent(f));
    submit(f, 100, false, 2, NULL, data, 1);
    expect(f, RET_SUBMIT, 100, -ENOMEM);
    free(data);
    end(f);
}

/* A peer that never reads is not read from for ever, and gets all its answers once it does. */
static void a_peer_that_does_not_read_is_waited_for(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    const uint8_t setup[8] = {0x80, 6, 0, 1, 0, 0, 18, 0};
    uint8_t header[HEADER], d[18];
    uint32_t sent = 0, got = 0;
    make_header(header, SUBMIT, 0, true, 0);
    put32(header + 24, 18);
    memcpy(header + 40, setup, 8);
    for (int stuck = 0; stuck < 3; run(f)) {
        put32(header + 4, sent);
        ssize_t n = send(f->fd, header, sizeof header, 0);
        stuck = n < 0 ? stuck + 1 : 0;
        sent += n == (ssize_t)sizeof header;
        assert_true(n < 0 || n == (ssize_t)sizeof header);
        assert_true(sent < 1000000);
    }
    while (got < sent) {
        reply r = next_reply(f, true, d, sizeof d);
        assert_int_equal(r.seqnum, got);
        got++;
    }
    assert_true(silent(f));
    end(f);
}

static void noise_never_hurts(void **state)
{
    (void)state;
    uint64_t random = lf_test_seed();
    for (int round = 0; round < 300; round++) {
        fixture *f = connect_to(NULL, NULL, round % 4 != 0);
        for (int message = 0; message < 40 && f->last == LF_OK; message++) {
            uint8_t header[HEADER];
            make_header(header, SUBMIT + (uint32_t)message % 2, (uint32_t)message, message & 2,
                        (uint32_t)message % 3);
            put32(header + 24, message % 5 ? 200 : 0);
            for (int i = 0; i < 3; i++) {
                random = random * 6364136223846793005u + 1442695040888963407u;
                header[(random >> 33) % (message % 3 ? 8 : HEADER) + (message % 3 ? 40 : 0)] =
                    (uint8_t)(random >> 50);
            }
            if (send(f->fd, header, sizeof header, MSG_NOSIGNAL) < 0)
                break;
            run(f);
        }
        end(f);
    }
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
        cmocka_unit_test(nonsense_ends_the_connection),
        cmocka_unit_test(a_claim_of_4_gib_is_not_believed),
        cmocka_unit_test(refused_data_is_skipped),
        cmocka_unit_test(waiting_transfers_are_bounded),
        cmocka_unit_test(waiting_bytes_are_bounded),
        cmocka_unit_test(a_peer_that_does_not_read_is_waited_for),
        cmocka_unit_test(noise_never_hurts),
        cmocka_unit_test(the_first_free_port_is_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
