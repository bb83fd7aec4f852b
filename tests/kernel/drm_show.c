/* Shows a known picture on a device, for the guest of make check-kernel:
 *   drm_show SPEC WIDTHxHEIGHT [PUSHES]
 * pushes whole frames of noise, then PUSHES times random rectangles with new noise, and says
 * "shown" with what it took. After that every line of its standard input is the name of a picture
 * (PPM) that is compared with what the panel must show now: "equal" or where it differs. Ends with
 * its input, or when the panel is unplugged ("gone"). Exit status 0, or the negated lf_status. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/thread.h"
#include "device/device.h"
#include "tests/kernel/ppm.h"

enum { FRAMES = 2, RECTS = 40, WAIT_MS = 60000 };

static uint64_t random_state = 88172645463325252U;

/* Marsaglia's xorshift64: the same numbers everywhere. */
static uint64_t random_next(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return random_state;
}

static int random_below(int n)
{
    return (int)(random_next() % (uint64_t)n);
}

static void fill(lf_image8 *frame, const lf_rect *r)
{
    for (int y = r->y; y < r->y + r->height; y++) {
        uint8_t *to = frame->data + (size_t)y * frame->stride + (size_t)r->x * 3;
        for (size_t left = (size_t)r->width * 3; left > 0;) {
            uint64_t noise = random_next();
            size_t n = left < sizeof noise ? left : sizeof noise;
            memcpy(to, &noise, n);
            to += n;
            left -= n;
        }
    }
}

static lf_rect random_rect(const lf_image8 *frame)
{
    lf_rect r = {random_below(frame->width), random_below(frame->height), 0, 0};
    int width = frame->width - r.x, height = frame->height - r.y;
    r.width = 1 + random_below(width < 200 ? width : 200);
    r.height = 1 + random_below(height < 200 ? height : 200);
    return r;
}

/* Waits for the end of the push under way. */
static lf_device_event outcome(lf_device *device)
{
    struct pollfd p = {.fd = device->ops->poll_fd(device), .events = POLLIN};
    while (poll(&p, 1, WAIT_MS) == 1) {
        lf_device_event event = device->ops->dispatch(device);
        if (event != LF_DEVICE_BUSY)
            return event;
    }
    return LF_DEVICE_BUSY;
}

/* *out_copied_s: what the caller of push waited for; the return value is what the event was. */
static lf_device_event push(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                            double *out_copied_s, double *out_shown_s)
{
    static uint64_t generation;
    double start = lf_time_now();
    if (device->ops->push(device, frame, rects, n, ++generation) != LF_OK)
        return LF_DEVICE_RETRY;
    *out_copied_s = lf_time_now() - start;
    lf_device_event event = outcome(device);
    *out_shown_s = lf_time_now() - start;
    return event;
}

static bool show(lf_device *device, lf_image8 *frame, int pushes)
{
    const lf_rect whole = {0, 0, frame->width, frame->height};
    double copied = 0, shown = 0;
    for (int i = 0; i < FRAMES; i++) { /* the first sets the mode */
        fill(frame, &whole);
        if (push(device, frame, &whole, 1, &copied, &shown) != LF_DEVICE_READY)
            return false;
        printf("whole frame: push %.1f ms, on the display after %.1f ms\n", copied * 1e3,
               shown * 1e3);
    }
    lf_device_counters before, after;
    device->ops->counters(device, &before);
    uint64_t changed = 0;
    double start = lf_time_now();
    for (int i = 0; i < pushes; i++) {
        lf_rect rects[RECTS];
        int n = 1 + random_below(RECTS);
        for (int k = 0; k < n; k++) {
            rects[k] = random_rect(frame);
            changed += (uint64_t)rects[k].width * (uint64_t)rects[k].height;
            fill(frame, &rects[k]);
        }
        if (push(device, frame, rects, n, &copied, &shown) != LF_DEVICE_READY)
            return false;
    }
    device->ops->counters(device, &after);
    printf("%d pushes: %llu rectangles, %llu pixels, %llu bytes written, %.2f s\n", pushes,
           (unsigned long long)(after.updates - before.updates), (unsigned long long)changed,
           (unsigned long long)(after.bytes - before.bytes), lf_time_now() - start);
    return true;
}

/* Until the input ends or the panel is gone. */
static void answer(lf_device *device, const lf_image8 *frame)
{
    struct pollfd p[2] = {{.fd = STDIN_FILENO, .events = POLLIN},
                          {.fd = device->ops->poll_fd(device), .events = POLLIN}};
    char line[4096];
    while (poll(p, 2, -1) >= 0) {
        if (p[1].revents != 0 && device->ops->dispatch(device) == LF_DEVICE_GONE) {
            printf("gone\n");
            return;
        }
        if (p[0].revents == 0)
            continue;
        if (!fgets(line, sizeof line, stdin))
            return;
        line[strcspn(line, "\n")] = 0;
        lf_ppm_compare(line, frame);
    }
}

int main(int argc, char **argv)
{
    lf_calibration calibration;
    lf_image8 frame = {0};
    lf_device *device = NULL;
    lf_device_info info;
    lf_error err = {0};
    char text[sizeof err + 32];
    lf_calibration_portrait(&calibration);
    if (argc < 3 ||
        sscanf(argv[2], "%dx%d", &calibration.screen_width_px, &calibration.screen_height_px) != 2)
        return 2;
    setvbuf(stdout, NULL, _IOLBF, 0);
    setvbuf(stdin, NULL, _IONBF, 0); /* or poll would not see what is in its buffer */
    lf_status status =
        lf_image8_init(&frame, calibration.screen_width_px, calibration.screen_height_px, 3);
    if (status == LF_OK)
        status = lf_device_open(argv[1], &calibration, &device, &err);
    if (status != LF_OK) {
        printf("%s: %s\n", lf_status_name(status), lf_error_format(&err, text, sizeof text));
        return -(int)status;
    }
    bool good = show(device, &frame, argc > 3 ? (int)strtol(argv[3], NULL, 10) : 0);
    device->ops->info(device, &info);
    printf("%s: %s, %s, %s; problem: \"%s\"\n", good ? "shown" : "failed", info.spec, info.model,
           info.output, info.problem);
    if (good)
        answer(device, &frame);
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    return good ? 0 : 1;
}
