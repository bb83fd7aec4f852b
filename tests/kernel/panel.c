/* The host's side of a panel that is plugged in, for the cases of make check-kernel: quiltd's own
 * readers over the unmodified libraries.
 *   panel eeprom FILE                   the EEPROM holds the calibration in FILE
 *   panel buttons N                     prints the names of the next N buttons that go down; says
 *                                       on stderr when they are watched
 *   panel draw WxH SEED N FILE.png      draws N random rectangles and writes what should be seen; N
 *                                       0: until it is unplugged
 *   panel same A.png B.png              both show the same
 * Prints nothing more when all is well. Exit status 0, 1 = not so, 2 = wrong usage, 3 = unplugged.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_io.h"
#include "device/hid/buttons.h"
#include "device/hid/hid.h"
#include "device/usb/gud_host.h"

enum {
    FAILED = 1,
    USAGE = 2,
    UNPLUGGED = 3,
    BUTTON_WAIT_MS = 20000,
    MAX_PLACES = 4,
    MAX_TRIES = 20
};

static int complain(const lf_error *err)
{
    char text[sizeof *err + 32];
    printf("%s\n", lf_error_format(err, text, sizeof text));
    return err->status == LF_E_NODEV ? UNPLUGGED : FAILED;
}

static lf_status open_hid(lf_hid_link *out, lf_error *err)
{
    lf_hid_place places[MAX_PLACES];
    if (lf_hid_list(places, MAX_PLACES) < 1)
        return lf_error_set(err, LF_E_NODEV, "hid", "no panel is there");
    return lf_hid_open(places[0].path, out, err);
}

static int eeprom(const char *path)
{
    lf_calibration expected = {0}, got = {0};
    lf_hid_link link = {0};
    lf_error err = {0};
    lf_status status = lf_calibration_load(path, &expected, &err);
    if (status == LF_OK)
        status = open_hid(&link, &err);
    if (status == LF_OK)
        status = lf_hid_read_calibration(&link, &lf_hid_patient, "hid", &got, &err);
    lf_hid_close(&link);
    if (status != LF_OK)
        return complain(&err);
    bool same = strcmp(expected.serial, got.serial) == 0 && expected.pitch == got.pitch &&
                expected.slope == got.slope && expected.center == got.center &&
                expected.dpi == got.dpi && expected.screen_width_px == got.screen_width_px &&
                expected.screen_height_px == got.screen_height_px &&
                expected.n_cells == got.n_cells;
    if (!same)
        printf("the EEPROM holds another calibration: serial %s, pitch %.17g\n", got.serial,
               got.pitch);
    return same ? 0 : FAILED;
}

static int buttons(int wanted)
{
    uint8_t report[LF_HID_REPORT], down = 0;
    lf_hid_link link = {0};
    lf_error err = {0};
    if (open_hid(&link, &err) != LF_OK)
        return complain(&err);
    fputs("buttons are watched\n", stderr);
    for (int seen = 0; seen < wanted;) {
        int got = lf_hid_read_report(&link, BUTTON_WAIT_MS, lf_hid_patient.rest_ms, report);
        if (got <= 0) {
            printf("%s after %d buttons\n", got == 0 ? "silence" : "unplugged", seen);
            lf_hid_close(&link);
            return got == 0 ? FAILED : UNPLUGGED;
        }
        for (int i = 0; i < LF_BUTTONS_N; i++) {
            if ((report[0] & ~down) >> i & 1) {
                puts(lf_button_name((lf_button)i));
                seen++;
            }
        }
        down = report[0];
    }
    lf_hid_close(&link);
    return 0;
}

static uint32_t draw_number(uint64_t *state, int below)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*state >> 33) % (uint32_t)below;
}

/* A rectangle anywhere, mostly small, filled with noise. */
static lf_rect scribble(lf_image8 *frame, uint64_t *state)
{
    int most = draw_number(state, 20) == 0 ? 400 : 60;
    lf_rect r = {.x = (int)draw_number(state, frame->width),
                 .y = (int)draw_number(state, frame->height)};
    r.width = 1 + (int)draw_number(state, frame->width - r.x < most ? frame->width - r.x : most);
    r.height = 1 + (int)draw_number(state, frame->height - r.y < most ? frame->height - r.y : most);
    for (int y = r.y; y < r.y + r.height; y++)
        for (int i = r.x * 3; i < (r.x + r.width) * 3; i++)
            frame->data[(size_t)y * frame->stride + (size_t)i] = (uint8_t)draw_number(state, 256);
    return r;
}

/* After a failure what the display shows is unknown: everything is given to it again, as the daemon
 * does. */
static lf_status update(lf_gud_host *host, const lf_image8 *frame, lf_rect rect, lf_error *err)
{
    const lf_rect whole = {0, 0, frame->width, frame->height};
    lf_status status = lf_gud_host_update(host, frame, &rect, 1, err);
    for (int i = 0; i < MAX_TRIES && (status == LF_E_IO || status == LF_E_TIMEOUT); i++)
        status = lf_gud_host_update(host, frame, &whole, 1, err);
    return status;
}

static lf_status draw_all(lf_gud_host *host, lf_image8 *frame, uint64_t seed, int n, lf_error *err)
{
    const lf_rect whole = {0, 0, frame->width, frame->height};
    lf_status status = lf_gud_host_start(host, err);
    if (status == LF_OK)
        status = update(host, frame, whole, err);
    for (int i = 0; status == LF_OK && (n == 0 || i < n); i++)
        status = update(host, frame, scribble(frame, &seed), err);
    return status;
}

static lf_status write_frame(const lf_image8 *frame, const char *path, lf_error *err)
{
    lf_outfile file;
    lf_status status = lf_outfile_open(&file, path, true, err);
    if (status != LF_OK)
        return status;
    status = lf_png_write(&file, frame, 1, NULL, 0, err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

static int draw(int width, int height, uint64_t seed, int n, const char *path)
{
    lf_usb_place place;
    lf_usb_link *link = NULL;
    lf_gud_host *host = NULL;
    lf_image8 frame = {0};
    lf_gud_host_counters counters = {0};
    lf_error err = {0};
    lf_status status = lf_usb_open("", &place, &link, &err);
    if (status == LF_OK)
        status = lf_gud_host_open(link, &host, &err);
    if (status == LF_OK)
        status = lf_gud_host_choose(host, width, height, &err);
    if (status == LF_OK)
        status = lf_image8_init(&frame, width, height, 3);
    if (status == LF_OK)
        status = draw_all(host, &frame, seed, n, &err);
    if (status == LF_OK)
        status = write_frame(&frame, path, &err);
    if (host)
        lf_gud_host_counters_get(host, &counters);
    fprintf(stderr,
            "bands %" PRIu64 ", compressed %" PRIu64 ", bytes %" PRIu64 ", failures %" PRIu64 "\n",
            counters.bands, counters.compressed, counters.bytes, counters.failures);
    lf_image8_finish(&frame);
    lf_gud_host_destroy(host);
    if (link)
        link->ops->close(link);
    return status == LF_OK ? 0 : complain(&err);
}

static int same(const char *a_path, const char *b_path)
{
    lf_image8 a = {0}, b = {0};
    lf_error err = {0};
    size_t differ = 0;
    if (lf_image8_read(a_path, NULL, &a, &err) != LF_OK ||
        lf_image8_read(b_path, NULL, &b, &err) != LF_OK) {
        lf_image8_finish(&a);
        return complain(&err);
    }
    bool shape = a.width == b.width && a.height == b.height;
    for (int y = 0; shape && y < a.height; y++)
        for (int i = 0; i < a.width * 3; i++)
            differ += a.data[(size_t)y * a.stride + (size_t)i] !=
                      b.data[(size_t)y * b.stride + (size_t)i];
    if (!shape || differ > 0)
        printf("%dx%d and %dx%d, %zu values differ\n", a.width, a.height, b.width, b.height,
               differ);
    lf_image8_finish(&a);
    lf_image8_finish(&b);
    return shape && differ == 0 ? 0 : FAILED;
}

int main(int argc, char *argv[])
{
    int width, height;
    if (argc == 3 && strcmp(argv[1], "eeprom") == 0)
        return eeprom(argv[2]);
    if (argc == 3 && strcmp(argv[1], "buttons") == 0)
        return buttons(atoi(argv[2]));
    if (argc == 4 && strcmp(argv[1], "same") == 0)
        return same(argv[2], argv[3]);
    if (argc == 6 && strcmp(argv[1], "draw") == 0 && sscanf(argv[2], "%dx%d", &width, &height) == 2)
        return draw(width, height, strtoull(argv[3], NULL, 10), atoi(argv[4]), argv[5]);
    fputs("usage: panel eeprom FILE | buttons N | draw WxH SEED N FILE.png | same A.png B.png\n",
          stderr);
    return USAGE;
}
