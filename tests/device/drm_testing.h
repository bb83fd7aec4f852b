/* What the tests of the drm device share: opening it over the fake kernel, and pictures. */
#ifndef LF_TESTS_DEVICE_DRM_TESTING_H
#define LF_TESTS_DEVICE_DRM_TESTING_H

#include "tests/device/device_testing.h"
#include "tests/device/fake_kms.h"

#include "device/device_table.h"

static inline lf_status drm_try(const char *argument, lf_device **out, lf_error *err)
{
    lf_calibration c = device_lens(FAKE_WIDTH, FAKE_HEIGHT);
    return lf_drm_open(&lf_fake_calls, argument, &c, out, err);
}

static inline lf_device *drm_open(void)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_ok(drm_try("", &device, &err), &err);
    return device;
}

static inline void drm_refuses(const char *argument, lf_status expected, const char *words)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_status(drm_try(argument, &device, &err), expected, &err);
    assert_null(device);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" does not say \"%s\"", err.what, words);
    lf_fake_nothing_is_left();
}

static const lf_rect drm_whole = {0, 0, FAKE_WIDTH, FAKE_HEIGHT};

static inline lf_image8 drm_frame(void)
{
    lf_image8 frame = {0};
    lf_assert_ok(lf_image8_init(&frame, FAKE_WIDTH, FAKE_HEIGHT, 3), NULL);
    return frame;
}

static inline void drm_scribble(lf_image8 *frame, const lf_rect *r, int seed)
{
    for (int y = r->y; y < r->y + r->height; y++)
        for (int i = r->x * 3; i < (r->x + r->width) * 3; i++)
            frame->data[(size_t)y * frame->stride + (size_t)i] =
                (uint8_t)(seed * 37 + y * 5 + i * 3);
}

static inline void drm_end(lf_device *device, lf_image8 *frame)
{
    lf_image8_finish(frame);
    lf_device_destroy(device);
    lf_fake_nothing_is_left();
}

#endif
