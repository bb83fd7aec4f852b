/* Samples of a plate: encodings, and headers of raw files. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/hologram/plate.h"

/* Pixels that are encoded at a time. */
#define RUN_PIXELS 256

static int channels_of(const lf_plate *plate)
{
    return plate->is_grey ? 1 : 3;
}

size_t lf_plate_pixel_bytes(const lf_plate *plate)
{
    return (size_t)channels_of(plate) * (plate->format == LF_PLATE_PNG ? 1 : 2);
}

/* ------------------------------------------------------------------------------------- halfs -- */

uint16_t lf_plate_half(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
    const uint32_t size = bits & 0x7fffffff;
    if (size > 0x7f800000)
        return 0;
    if (size >= 0x477ff000) /* rounds to more than 65504 */
        return sign | 0x7bff;
    if (size < 0x38800000) /* below 2^-14: a multiple of 2^-24 */
        return sign | (uint16_t)lrintf(fabsf(value) * 0x1p24F);
    const uint32_t rest = size & 0x1fff, half = (size >> 13) - (112u << 10);
    return sign | (uint16_t)(half + (rest > 0x1000 || (rest == 0x1000 && (half & 1))));
}

float lf_plate_half_value(uint16_t half)
{
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    const float size = exponent == 0 ? ldexpf((float)mantissa, -24)
                                     : ldexpf((float)(1024 + mantissa), exponent - 25);
    return half & 0x8000 ? -size : size;
}

/* ---------------------------------------------------------------------------------- encoding -- */

static double srgb_code(double light)
{
    return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
}

static void put_16(uint16_t value, uint8_t *out)
{
    out[0] = (uint8_t)(value & 0xff);
    out[1] = (uint8_t)(value >> 8);
}

static float luminance(const float *rgb)
{
    return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2];
}

/* Up to RUN_PIXELS pixels. */
static void encode_run(const lf_plate *plate, const lf_tone *tone, size_t n, const float *rgb,
                       uint8_t *out)
{
    float light[3 * RUN_PIXELS];
    const bool is_half = plate->format == LF_PLATE_EXR;
    const size_t channels = (size_t)channels_of(plate);
    if (is_half)
        memcpy(light, rgb, 3 * n * sizeof *rgb);
    else
        lf_tone_linear(tone, n, rgb, light);
    for (size_t i = 0; i < n && plate->is_grey; i++)
        light[i] = luminance(&light[3 * i]);
    for (size_t i = 0; i < n * channels; i++) {
        const double code = plate->is_grey ? (double)light[i] : srgb_code((double)light[i]);
        put_16(is_half ? lf_plate_half(light[i]) : (uint16_t)lrint(fmin(fmax(code, 0), 1) * 65535),
               out + 2 * i);
    }
}

void lf_plate_encode(const lf_plate *plate, const lf_tone *tone, size_t n, const float *rgb,
                     uint8_t *out)
{
    for (size_t at = 0; at < n; at += RUN_PIXELS)
        encode_run(plate, tone, n - at < RUN_PIXELS ? n - at : RUN_PIXELS, rgb + 3 * at,
                   out + at * lf_plate_pixel_bytes(plate));
}

/* ----------------------------------------------------------------------------------- headers -- */

static void put_number(uint64_t value, int bytes, uint8_t *out)
{
    for (int i = 0; i < bytes; i++)
        out[i] = (uint8_t)(value >> 8 * i & 0xff);
}

static void make_header(const lf_plate *plate, int order, const int size[4], uint64_t bytes,
                        uint8_t out[LF_PLATE_HEADER])
{
    const bool is_linear = plate->format == LF_PLATE_EXR || plate->is_grey;
    memset(out, 0, LF_PLATE_HEADER);
    memcpy(out, "LFPLATE1", 8);
    put_number(LF_PLATE_HEADER, 4, out + 8);
    put_number((uint64_t)order, 4, out + 12);
    for (int i = 0; i < 4; i++)
        put_number((uint64_t)size[i], 4, out + 16 + 4 * i);
    put_number((uint64_t)channels_of(plate), 4, out + 32);
    put_number((uint64_t)plate->format, 4, out + 36);
    put_number(is_linear, 4, out + 40);
    put_number(bytes, 8, out + 48);
}

uint64_t lf_plate_task_bytes(const lf_plate *plate)
{
    return (uint64_t)lf_plate_task_cameras(plate) * (uint64_t)plate->height *
           (uint64_t)plate->width * lf_plate_pixel_bytes(plate);
}

uint64_t lf_plate_field_bytes(const lf_plate *plate)
{
    return (uint64_t)lf_plate_tasks(plate) * lf_plate_task_bytes(plate);
}

void lf_plate_task_header(const lf_plate *plate, int task, uint8_t out[LF_PLATE_HEADER])
{
    const int size[4] = {task, lf_plate_task_cameras(plate), plate->height, plate->width};
    make_header(plate, 1, size, lf_plate_task_bytes(plate), out);
}

void lf_plate_field_header(const lf_plate *plate, uint8_t out[LF_PLATE_HEADER])
{
    const lf_plate_place n = lf_plate_size(plate);
    const int size[4] = {n.hy, n.hx, n.v, n.u};
    make_header(plate, 0, size, lf_plate_field_bytes(plate), out);
}
