/* libFuzzer: the bytes are what a GUD display answers. The first byte chooses what transfers on the
 * bulk endpoint come to; then, for each question in turn, a length (two bytes, little-endian) and
 * that many bytes. Nothing may crash, leak or go on for ever; a host that got so far as to start is
 * made to show rectangles. */
#include <string.h>

#include "device/usb/gud_host.h"
#include "tests/fuzz/fuzz.h"

enum { MAX_PIXELS = 1 << 20 };

typedef struct fuzz_link {
    lf_usb_link base;
    const uint8_t *data;
    size_t left;
    uint8_t manner;
    unsigned int transfers;
} fuzz_link;

static fuzz_link *fuzz_of(lf_usb_link *link)
{
    return (fuzz_link *)(void *)link;
}

/* Lengths that end beyond the data, and every so many questions of some manners, fail as USB does.
 */
static lf_usb_result fuzz_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                  uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    fuzz_link *f = fuzz_of(link);
    (void)request;
    (void)value;
    (void)timeout_ms;
    if (out_n)
        *out_n = 0;
    if (!in)
        return LF_USB_OK;
    if (f->left < 2)
        return LF_USB_GONE;
    size_t length = (size_t)(f->data[0] | f->data[1] << 8);
    f->data += 2;
    f->left -= 2;
    if (length > f->left)
        return LF_USB_STALL;
    size_t given = length < n ? length : n;
    if (given > 0)
        memcpy(data, f->data, given);
    f->data += length;
    f->left -= length;
    if (out_n)
        *out_n = given;
    return LF_USB_OK;
}

static void fuzz_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    (void)link;
    lf_fuzz_require(n > 0 && memchr(data, 0, n) != data + n); /* and all of it can be read */
}

static lf_usb_result fuzz_bulk_end(lf_usb_link *link, int timeout_ms)
{
    fuzz_link *f = fuzz_of(link);
    (void)timeout_ms;
    unsigned int every = f->manner % 16;
    return every > 0 && ++f->transfers % every == 0
               ? (lf_usb_result)(1 + f->manner / 16 % LF_USB_IO)
               : LF_USB_OK;
}

static void fuzz_cancel(lf_usb_link *link)
{
    (void)link;
}

static const lf_usb_link_ops fuzz_ops = {
    .control = fuzz_control,
    .bulk_begin = fuzz_bulk_begin,
    .bulk_end = fuzz_bulk_end,
    .cancel = fuzz_cancel,
    .close = fuzz_cancel,
};

static void show(lf_gud_host *host, int width, int height)
{
    lf_image8 frame = {0};
    const lf_rect rects[] = {{0, 0, width, height},
                             {width / 2, height / 2, width - width / 2, height - height / 2}};
    if ((long)width * height > MAX_PIXELS || lf_image8_init(&frame, width, height, 3) != LF_OK)
        return;
    for (int i = 0; i < 4; i++) {
        frame.data[(size_t)(height / 2) * frame.stride + (size_t)i] ^= 1;
        if (lf_gud_host_update(host, &frame, &rects[i % 2], 1, NULL) == LF_E_NODEV)
            break;
    }
    lf_image8_finish(&frame);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    if (n < 1)
        return 0;
    fuzz_link f = {.base.ops = &fuzz_ops, .data = data + 1, .left = n - 1, .manner = data[0]};
    lf_gud_host *host = NULL;
    lf_gud_mode mode;
    lf_error err = {0};
    if (lf_gud_host_open(&f.base, &host, &err) != LF_OK)
        return 0;
    /* frames of a GiB are allowed, but say nothing new and take long */
    if (lf_gud_host_preferred(host, &mode) && (long)mode.hdisplay * mode.vdisplay <= MAX_PIXELS &&
        lf_gud_host_choose(host, 0, 0, &err) == LF_OK) {
        if (lf_gud_host_start(host, &err) == LF_OK)
            show(host, mode.hdisplay, mode.vdisplay);
        lf_gud_host_stop(host);
    }
    lf_gud_host_destroy(host);
    return 0;
}
