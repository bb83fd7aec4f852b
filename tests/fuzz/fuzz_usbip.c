/* libFuzzer: the bytes are what a peer of the USB/IP server sends. The first byte says what the
 * simulated panel is like and into what pieces the rest is cut. Nothing may crash, leak or go on
 * for ever, and what the server sends must be USB/IP. */
#include <endian.h>
#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/thread.h"
#include "device/model/usb_model.h"
#include "device/model/usbip.h"
#include "device/usb/gud.h"
#include "tests/fuzz/fuzz.h"

enum { WIDTH = 16, HEIGHT = 8, REST = 1000, HEADER = 48 };

typedef struct fuzz_panel {
    lf_model_hid *hid;
    lf_model_gud *gud;
    lf_usbip_device device;
    lf_usbip *usbip;
    int fd; /* the peer's end */
    uint64_t now;
    bool imported_before, answered;
} fuzz_panel;

/* Bits of the first byte: 1 = the handshake is over, 2 = everything goes wrong every third time, 4
 * = a slow display; the rest chooses the size of the pieces. */
static void begin(fuzz_panel *p, uint8_t manner)
{
    static const uint8_t rgb888 = LF_GUD_RGB888;
    const lf_model_gud_options options = {.width = WIDTH,
                                          .height = HEIGHT,
                                          .formats = &rgb888,
                                          .n_formats = 1,
                                          .lz4 = true,
                                          .status_on_set = true};
    uint64_t every = manner & 2 ? 3 : 0;
    const lf_model_gud_faults gud_faults = {.stall_every = every,
                                            .fail_every = every,
                                            .hang_every = 2 * every,
                                            .bytes_per_s = manner & 4 ? 1000 : 0};
    const lf_model_hid_faults hid_faults = {
        .stall_every = (int)every, .mute_every = 2 * (int)every, .press_every = (int)every};
    int ends[2];
    lf_fuzz_require(lf_model_hid_create("\0\0\0\2{}", 6, &hid_faults, &p->hid) == LF_OK);
    lf_fuzz_require(lf_model_gud_create(&options, &gud_faults, &p->gud) == LF_OK);
    lf_fuzz_require(lf_model_create(p->hid, p->gud, &p->device.model) == LF_OK);
    p->device.gud = p->gud;
    p->imported_before = manner & 1;
    lf_fuzz_require(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) == 0);
    p->fd = ends[0];
    lf_fuzz_require(lf_usbip_create(&p->device, ends[1], p->imported_before, &p->usbip) == LF_OK);
}

static void end(fuzz_panel *p)
{
    lf_usbip_destroy(p->usbip);
    lf_fuzz_require(!p->device.taken);
    lf_model_destroy(p->device.model);
    lf_model_gud_destroy(p->gud);
    lf_model_hid_destroy(p->hid);
    close(p->fd);
}

/* An answer of the handshake, or to a URB: the first bytes tell. */
static void check_answer(const fuzz_panel *p, const uint8_t *data, size_t n)
{
    static const uint8_t list[4] = {0x01, 0x11, 0, 5}, import[4] = {0x01, 0x11, 0, 3};
    uint32_t command;
    lf_fuzz_require(n >= 8);
    memcpy(&command, data, sizeof command);
    if (!p->imported_before)
        lf_fuzz_require(memcmp(data, list, 4) == 0 || memcmp(data, import, 4) == 0);
    else
        lf_fuzz_require(n >= HEADER && (be32toh(command) == 3 || be32toh(command) == 4));
}

static void read_answers(fuzz_panel *p)
{
    static uint8_t data[1 << 18];
    for (ssize_t n; (n = recv(p->fd, data, sizeof data, 0)) > 0; p->answered = true)
        if (!p->answered)
            check_answer(p, data, (size_t)n);
}

/* Lets the server come to rest, at its own time; false when the connection is over. */
static bool run(fuzz_panel *p)
{
    for (int i = 0; i < REST; i++) {
        lf_error err = {0};
        struct pollfd waits;
        lf_status status = lf_usbip_run(p->usbip, p->now, &err);
        read_answers(p);
        if (status != LF_OK) {
            lf_fuzz_require(status == LF_E_NODEV || status == LF_E_FORMAT);
            lf_fuzz_require(status == LF_E_NODEV || err.what[0] != 0);
            return false;
        }
        int ms = lf_usbip_poll(p->usbip, p->now, &waits);
        lf_fuzz_require(ms >= -1);
        if (ms < 0 && poll(&waits, 1, 0) == 0)
            return true;
        p->now += ms > 0 ? (uint64_t)ms * LF_NS_PER_MS : 0;
    }
    lf_fuzz_require(!"the server does not come to rest");
    return false;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    static const size_t pieces[] = {SIZE_MAX, 48, 64, 7, 1};
    if (n < 1)
        return 0;
    fuzz_panel p = {0};
    begin(&p, data[0]);
    size_t piece = pieces[data[0] / 8 % (sizeof pieces / sizeof pieces[0])];
    bool goes_on = true;
    for (size_t at = 1; at < n && goes_on;) {
        size_t wanted = n - at < piece ? n - at : piece;
        ssize_t sent = send(p.fd, data + at, wanted, MSG_NOSIGNAL);
        lf_fuzz_require(sent > 0 || errno == EAGAIN);
        at += sent > 0 ? (size_t)sent : 0;
        goes_on = run(&p);
    }
    end(&p);
    return 0;
}
