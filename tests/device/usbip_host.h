/* A host of the USB/IP server, over a socket pair, for its tests. */
#ifndef LF_TESTS_USBIP_HOST_H
#define LF_TESTS_USBIP_HOST_H

#include "tests/testing.h"

#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/socket.h>

#include "device/model/usb_model.h"
#include "device/model/usbip.h"
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

static inline fixture *connect_to(const lf_model_hid_faults *hid_faults,
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

static inline void end(fixture *f)
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
static inline lf_status run(fixture *f)
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

static inline void put32(uint8_t *at, uint32_t v)
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

static inline void send_all(fixture *f, const void *data, size_t n)
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

static inline void make_header(uint8_t header[HEADER], uint32_t command, uint32_t seqnum, bool in,
                               uint32_t endpoint)
{
    memset(header, 0, HEADER);
    put32(header, command);
    put32(header + 4, seqnum);
    put32(header + 8, LF_USBIP_DEVID);
    put32(header + 12, in);
    put32(header + 16, endpoint);
}

static inline void submit(fixture *f, uint32_t seqnum, bool in, uint32_t endpoint,
                          const uint8_t *setup, const void *data, uint32_t n)
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

static inline void unlink_urb(fixture *f, uint32_t seqnum, uint32_t which)
{
    uint8_t header[HEADER];
    make_header(header, UNLINK, seqnum, false, 0);
    put32(header + 20, which);
    send_all(f, header, sizeof header);
}

/* What the host has got; -1 when there is nothing (now). */
static inline ssize_t get(fixture *f, void *out, size_t n)
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

static inline bool silent(fixture *f)
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
static inline reply next_reply(fixture *f, bool in, void *out, size_t max)
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

static inline void expect(fixture *f, uint32_t command, uint32_t seqnum, int status)
{
    reply r = next_reply(f, false, NULL, 0);
    assert_int_equal(r.command, command);
    assert_int_equal(r.seqnum, seqnum);
    assert_int_equal(r.status, status);
}

static const uint8_t ask_page[8] = {0x21, 9, 0, 3, 0, 0, LF_MODEL_FEATURE, 0};

/* SET_REPORT for a page, with its answer taken. */
static inline void ask(fixture *f, uint32_t seqnum, uint8_t page)
{
    uint8_t data[LF_MODEL_FEATURE] = {0, 0, page};
    submit(f, seqnum, false, 0, ask_page, data, sizeof data);
}

/* Makes the display ready and announces `rows` rows from the top; the answers are taken. */
static inline void announce(fixture *f, uint32_t rows)
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

static inline void light(fixture *f)
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

#endif
