/* What the tests of GUD displays share: frames, and whether a display shows them. */
#ifndef LF_TESTS_GUD_TESTING_H
#define LF_TESTS_GUD_TESTING_H

#include "tests/testing.h"

#include "device/model/usb_model.h"
#include "device/usb/gud.h"

/* xorshift64*; state is never 0. */
static inline uint32_t gud_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (uint32_t)(*state * UINT64_C(2685821657736338717) >> 32);
}

static inline lf_image8 gud_frame(int width, int height)
{
    lf_image8 frame = {0};
    lf_assert_ok(lf_image8_init(&frame, width, height, 3), NULL);
    return frame;
}

/* Noise, or a colour: what does not shrink, and what does. */
static inline void gud_paint(lf_image8 *frame, lf_rect r, bool noise, uint64_t *random)
{
    uint32_t colour = gud_random(random);
    for (int y = r.y; y < r.y + r.height; y++)
        for (int i = r.x * 3; i < (r.x + r.width) * 3; i++)
            frame->data[(size_t)y * frame->stride + (size_t)i] =
                (uint8_t)(noise ? gud_random(random) : colour >> i % 3 * 8);
}

static inline lf_rect gud_random_rect(int width, int height, uint64_t *random)
{
    int w = 1 + (int)(gud_random(random) % (uint32_t)width),
        h = 1 + (int)(gud_random(random) % (uint32_t)height);
    if (gud_random(random) % 4 != 0) {
        w = 1 + w / 8;
        h = 1 + h / 8;
    }
    return (lf_rect){(int)(gud_random(random) % (uint32_t)(width - w + 1)),
                     (int)(gud_random(random) % (uint32_t)(height - h + 1)), w, h};
}

/* An 8-bit value as a display with so many levels shows it: to the nearest level, widened by
 * repeating its high bits. */
static inline uint8_t gud_level(uint8_t value, int bits)
{
    int max = (1 << bits) - 1, level = (int)lround(value / 255.0 * max);
    return (uint8_t)(level << (8 - bits) | level >> (2 * bits - 8));
}

/* How many bytes of r the model shows otherwise than the frame has them in this format. */
static inline int gud_differences(const lf_model_gud *gud, const lf_image8 *frame, lf_rect r,
                                  lf_gud_format format)
{
    const uint8_t *shown = lf_model_gud_pixels(gud);
    int n = 0;
    for (int y = r.y; y < r.y + r.height; y++)
        for (int i = r.x * 3; i < (r.x + r.width) * 3; i++) {
            uint8_t wanted = frame->data[(size_t)y * frame->stride + (size_t)i];
            if (format == LF_GUD_RGB565)
                wanted = gud_level(wanted, i % 3 == 1 ? 6 : 5);
            n += shown[((size_t)y * (size_t)frame->width) * 3 + (size_t)i] != wanted;
        }
    return n;
}

/* A display of this size with nothing remarkable about it. */
static inline lf_model_gud_options gud_options(int width, int height)
{
    static const uint8_t formats[] = {LF_GUD_RGB888};
    return (lf_model_gud_options){
        .width = width, .height = height, .formats = formats, .n_formats = 1};
}

static inline lf_model_gud *gud_model(const lf_model_gud_options *options,
                                      const lf_model_gud_faults *faults)
{
    lf_model_gud *gud = NULL;
    lf_assert_ok(lf_model_gud_create(options, faults, &gud), NULL);
    return gud;
}

static inline lf_model_gud_counters gud_counters(const lf_model_gud *gud)
{
    lf_model_gud_counters counters;
    lf_model_gud_counters_get(gud, &counters);
    return counters;
}

#endif
