/* What tests of the simulated panel share: a small panel, frames, and what lies in its folder. */
#ifndef LF_TESTS_SIM_TESTING_H
#define LF_TESTS_SIM_TESTING_H

#include "tests/device/device_testing.h"

#include <inttypes.h>

#include "base/image_io.h"
#include "device/sim/sim.h"

enum { WIDTH = 96, HEIGHT = 128 };

static inline lf_calibration small_panel(void)
{
    lf_calibration c = device_lens(WIDTH, HEIGHT);
    strcpy(c.serial, "TEST-1");
    return c;
}

static inline lf_status try_open(const char *dir, const char *options, lf_device **out)
{
    char spec[PATH_MAX + 64];
    lf_calibration c = small_panel();
    snprintf(spec, sizeof spec, "sim:%s%s", dir, options);
    return lf_device_open(spec, &c, out, NULL);
}

static inline lf_device *open_sim(const char *dir, const char *options)
{
    lf_device *device = NULL;
    lf_assert_ok(try_open(dir, options, &device), NULL);
    return device;
}

/* A frame that differs in every pixel from those of other seeds. */
static lf_image8 make_frame(int seed)
{
    lf_image8 frame = {0};
    lf_assert_ok(lf_image8_init(&frame, WIDTH, HEIGHT, 3), NULL);
    for (int y = 0; y < HEIGHT; y++)
        for (int i = 0; i < WIDTH * 3; i++)
            frame.data[(size_t)y * frame.stride + (size_t)i] = (uint8_t)(seed * 37 + y * 5 + i * 3);
    return frame;
}

static const lf_rect whole = {0, 0, WIDTH, HEIGHT};

static inline lf_status push_seed(lf_device *device, int seed)
{
    lf_image8 frame = make_frame(seed);
    lf_status status = device->ops->push(device, &frame, &whole, 1, (uint64_t)seed);
    lf_image8_finish(&frame);
    return status;
}

/* To its end. */
static inline lf_device_event show(lf_device *device, int seed)
{
    lf_assert_ok(push_seed(device, seed), NULL);
    return device_outcome(device);
}

static inline void wait_for_files(lf_device *device)
{
    lf_assert_ok(device->ops->flush(device, DEVICE_WAIT_MS), NULL);
}

static inline bool file_shows(const char *path, const lf_image8 *expected)
{
    lf_image8 got = {0};
    if (lf_image8_read(path, NULL, &got, NULL) != LF_OK)
        return false;
    bool equal =
        got.width == expected->width && got.height == expected->height && got.channels == 3;
    for (int y = 0; equal && y < got.height; y++)
        equal = memcmp(got.data + (size_t)y * got.stride,
                       expected->data + (size_t)y * expected->stride, (size_t)got.width * 3) == 0;
    lf_image8_finish(&got);
    return equal;
}

static inline bool panel_shows(const char *dir, int seed)
{
    lf_image8 frame = make_frame(seed);
    bool equal = file_shows(lf_test_path(dir, "panel.png"), &frame);
    lf_image8_finish(&frame);
    return equal;
}

/* Lines of a log that read as they should; -1 when one does not, 0 when there is no file. */
static inline int read_lines(const char *path, lf_sim_update *out, int max)
{
    FILE *file = fopen(path, "r");
    char line[512];
    int n = 0;
    while (file && fgets(line, sizeof line, file) && n >= 0) {
        lf_sim_update u;
        int end = 0;
        sscanf(line,
               "{\"seq\":%" SCNu64
               ",\"x\":%d,\"y\":%d,\"width\":%d,\"height\":%d,\"bytes\":%" SCNu64
               ",\"time_ns\":%" SCNu64 "}%n",
               &u.seq, &u.rect.x, &u.rect.y, &u.rect.width, &u.rect.height, &u.bytes, &u.time_ns,
               &end);
        if (end == 0 || strcmp(line + end, "\n") != 0 || n == max)
            n = -1;
        else
            out[n++] = u;
    }
    if (file)
        fclose(file);
    return n;
}

static inline bool exists(const char *dir, const char *name)
{
    return access(lf_test_path(dir, name), F_OK) == 0;
}

#endif
