/* A HID device that answers as the input says. Every answer begins with a byte: 0..68 = a packet of
 * so many bytes, which follow; 69 = nothing; 70 = gone; 71..253 = a whole reply to the last
 * request, whose page follows; 254 and 255 = a request is refused. Behind the end of the input
 * there is nothing. Whatever it says: an end, in time, and no command but "read a page". */
#include "tests/fuzz/fuzz.h"

#include <string.h>

#include "device/hid/hid.h"

enum { NOTHING = 69, GONE = 70, REFUSED = 254 };

typedef struct device {
    const uint8_t *data;
    size_t size;
    uint8_t request[LF_HID_FEATURE];
    uint64_t now_ms;
    int n_sent;
} device;

static void take(device *d, uint8_t *out, size_t n)
{
    size_t have = n < d->size ? n : d->size;
    memset(out, 0, n);
    if (have > 0)
        memcpy(out, d->data, have);
    d->data += have;
    d->size -= have;
}

static int device_send(void *context, const uint8_t *report, size_t n)
{
    static const uint8_t zeros[LF_HID_FEATURE];
    device *d = context;
    lf_fuzz_require(n == LF_HID_FEATURE && report[0] == 0 && report[1] == 0);
    lf_fuzz_require(memcmp(report + 4, zeros, LF_HID_FEATURE - 4) == 0);
    memcpy(d->request, report, n);
    d->n_sent++;
    if (d->size == 0 || d->data[0] < REFUSED)
        return (int)n;
    take(d, (uint8_t[1]){0}, 1);
    return -1;
}

static int device_read(void *context, uint8_t *out, size_t max, int timeout_ms)
{
    device *d = context;
    uint8_t kind = NOTHING, packet[LF_HID_REPORT];
    lf_fuzz_require(timeout_ms >= 0 && max == LF_HID_REPORT);
    if (d->size > 0)
        take(d, &kind, 1);
    if (kind == GONE)
        return -1;
    if (kind == 0 || kind == NOTHING || kind >= REFUSED) {
        d->now_ms += (uint64_t)timeout_ms;
        return 0;
    }
    d->now_ms++;
    if (kind < NOTHING) {
        take(d, out, kind);
        return kind;
    }
    memcpy(packet, d->request, 4);
    take(d, packet + 4, LF_HID_PAGE);
    memcpy(out, packet, sizeof packet);
    return sizeof packet;
}

static uint64_t device_now(void *context)
{
    return ((const device *)context)->now_ms;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    device d = {.data = data, .size = size};
    lf_hid_link link = {device_send, device_read, device_now, NULL, &d};
    lf_calibration c = {0};
    lf_error err = {0};
    lf_status status = lf_hid_read_calibration(&link, &lf_hid_patient, "fuzz", &c, &err);
    if (status != LF_OK) {
        lf_fuzz_require(err.what[0] != 0);
        lf_fuzz_require_text(err.what);
    } else {
        lf_fuzz_require(c.pitch >= 1 && c.screen_width_px >= 1 && c.screen_height_px >= 1);
    }
    lf_fuzz_require(d.now_ms <= (uint64_t)(lf_hid_patient.total_ms + lf_hid_patient.reply_ms));
    lf_fuzz_require(d.n_sent <= 2 * lf_hid_patient.attempts * (LF_HID_MAX_JSON / LF_HID_PAGE + 1));
    return 0;
}
