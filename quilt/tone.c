/* Table from floats to display codes, equal to the rounded formula to the bit. Codes only rise with
 * the value, so 255 thresholds define it. They are found once, by bisecting the formula over the
 * floats. A table over the leading bits of a float gives the code below its bucket and the start of
 * the next code. If channels are mixed first, the table is that of the sRGB curve alone. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/kernel/kernel.h"
#include "quilt/quilt.h"

#define INFINITY_BITS 0x7f800000
#define MAX_STOPS 64.0

/* The curve of one channel, for values > 0. */
typedef double (*curve_fn)(double x);
/* The mapping of a pixel, for values >= 0, to display light, which may exceed 0..1. */
typedef void (*mixture_fn)(const double scene[3], double out[3]);

typedef struct tone_curve {
    const char *name;
    curve_fn curve;
    mixture_fn mixture; /* if channels are mixed: replaces the curve */
} tone_curve;

struct lf_tone {
    double gain;
    const tone_curve *map;
    /* low: below every threshold, at a bucket's start; high: the last threshold */
    lf_tone_table table;
    uint32_t *entries;  /* owned, the table's */
    int32_t first[257]; /* [code] bits of the smallest float with this code; 256 is never reached */
    /* [code] the float that is exactly this code before rounding; codes per unit of a float below
     * and above it: 0 below black and beyond white */
    float centre[256], slope[256][2];
    const lf_quilt_kernels *kernels;
};

static double clamp(double x)
{
    return x;
}

/* K. Narkowicz's fit of the ACES curve (2015), per channel. */
static double filmic(double x)
{
    return x < 1e6 ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : 1;
}

/* S. Hill's fit of the ACES rendering and output transforms (2016), between its two matrices. */
static double aces(double x)
{
    return (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
}

/* From sRGB to the space of the fit, and back. */
static const double to_fit[3][3] = {
    {0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
static const double from_fit[3][3] = {
    {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};

static void aces_mixture(const double scene[3], double out[3])
{
    double fitted[3];
    for (int c = 0; c < 3; c++)
        fitted[c] =
            aces(to_fit[c][0] * scene[0] + to_fit[c][1] * scene[1] + to_fit[c][2] * scene[2]);
    for (int c = 0; c < 3; c++)
        out[c] =
            from_fit[c][0] * fitted[0] + from_fit[c][1] * fitted[1] + from_fit[c][2] * fitted[2];
}

/* Khronos' PBR Neutral tone mapper (2024): up to 0.8, colours stay unchanged, except for the 0.04
 * that surfaces reflect of a white room. Beyond that they move towards white. */
static void neutral_mixture(const double scene[3], double out[3])
{
    const double reflected = 0.04, start = 0.8 - reflected, desaturation = 0.15;
    const double least = fmin(scene[0], fmin(scene[1], scene[2])),
                 most = fmax(scene[0], fmax(scene[1], scene[2])),
                 offset =
                     least < 2 * reflected ? least - least * least / (4 * reflected) : reflected,
                 peak = most - offset;
    double scale = 1, white = 0, grey = 0;
    if (peak > start) {
        const double room = 1 - start;
        white = 1 - room * room / (peak + room - start);
        scale = white / peak;
        grey = 1 - 1 / (desaturation * (peak - white) + 1);
    }
    for (int c = 0; c < 3; c++)
        out[c] = (1 - grey) * scale * (scene[c] - offset) + grey * white;
}

static const tone_curve curves[] = {{"srgb", clamp, NULL},
                                    {"filmic", filmic, NULL},
                                    {"aces", NULL, aces_mixture},
                                    {"neutral", NULL, neutral_mixture}};

static double unit(double x)
{
    return x < 1 ? x > 0 ? x : 0 : 1;
}

/* Display light of a scene value, 0..1. */
static double display_light(const lf_tone *tone, double value)
{
    double x = value * tone->gain;
    return x > 0 ? unit(tone->map->curve(x)) : 0;
}

/* Display light of a pixel with mixed channels. The curve is constant beyond BRIGHT. */
static void lights_mixed(const lf_tone *tone, const float in[3], float out[3])
{
    enum { BRIGHT = 1000000 };
    double scene[3], light[3];
    for (int c = 0; c < 3; c++) {
        double x = (double)in[c] * tone->gain;
        scene[c] = x > 0 ? x < BRIGHT ? x : BRIGHT : 0;
    }
    tone->map->mixture(scene, light);
    for (int c = 0; c < 3; c++)
        out[c] = (float)unit(light[c]);
}

/* The code before rounding. */
static double display_level(const lf_tone *tone, double value)
{
    double light = tone->map->mixture ? unit(value) : display_light(tone, value);
    double srgb = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
    return 255 * srgb;
}

static int display_code(const lf_tone *tone, double value)
{
    return (int)floor(display_level(tone, value) + 0.5);
}

static float float_of(int32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static void find_thresholds(lf_tone *tone)
{
    tone->first[0] = 0;
    for (int code = 1; code < 256; code++) {
        int32_t below = tone->first[code - 1], at = INFINITY_BITS;
        while (at - below > 1) {
            int32_t middle = below + (at - below) / 2;
            if (display_code(tone, (double)float_of(middle)) >= code)
                at = middle;
            else
                below = middle;
        }
        tone->first[code] = at;
    }
    tone->first[256] = INT32_MAX;
}

/* The two floats are half a code apart. */
static float per_unit(float from, float to)
{
    return to > from ? (float)(0.5 / ((double)to - (double)from)) : 0;
}

/* For dithering, codes between thresholds and centres are linear in the value. The centre of 255 is
 * the start of white; TINY allows for rounding of the formula there. */
static void find_centres(lf_tone *tone)
{
    const double TINY = 1e-9;
    for (int code = 0; code < 256; code++) {
        int32_t below = code == 0 ? -1 : tone->first[code] - 1;
        int32_t at = code < 255 ? tone->first[code + 1] : INFINITY_BITS;
        while (at - below > 1) {
            int32_t middle = below + (at - below) / 2;
            if (display_level(tone, (double)float_of(middle)) >= code - TINY)
                at = middle;
            else
                below = middle;
        }
        tone->centre[code] = float_of(at);
        tone->slope[code][0] = per_unit(float_of(tone->first[code]), tone->centre[code]);
        if (code < 255)
            tone->slope[code][1] = per_unit(tone->centre[code], float_of(tone->first[code + 1]));
    }
}

/* True if each bucket has at most one threshold; thresholds rise, so it compares neighbours. */
static bool buckets_hold(const lf_tone *tone, int shift)
{
    for (int code = 1; code < 255; code++)
        if (tone->first[code] >> shift == tone->first[code + 1] >> shift)
            return false;
    return true;
}

static lf_status build_table(lf_tone *tone)
{
    int shift = 16;
    while (shift > 0 && !buckets_hold(tone, shift))
        shift--;
    int32_t first = (tone->first[1] - 1) >> shift, low = first << shift, high = tone->first[255];
    int32_t n = (high >> shift) - first + 1;
    tone->entries = lf_calloc((size_t)n, sizeof *tone->entries);
    if (!tone->entries)
        return LF_E_NOMEM;
    tone->table =
        (lf_tone_table){.entries = tone->entries, .low = low, .high = high, .shift = shift};
    int code = 0;
    for (int32_t b = 0; b < n; b++) {
        int32_t start = low + (b << shift), size = 1 << shift;
        while (tone->first[code + 1] <= start)
            code++;
        int32_t offset = tone->first[code + 1] - start;
        tone->entries[b] = (uint32_t)code | (uint32_t)(offset < size ? offset : size) << 8;
    }
    return LF_OK;
}

lf_status lf_tone_create(double exposure, const char *tonemap, lf_tone **out, lf_error *err)
{
    const tone_curve *map = NULL;
    for (size_t i = 0; i < sizeof curves / sizeof *curves && !map; i++)
        map = strcmp(tonemap, curves[i].name) == 0 ? &curves[i] : NULL;
    if (!map)
        return lf_error_set(err, LF_E_ARG, "tonemap",
                            "unknown name \"%s\"; expected srgb, filmic, aces or neutral", tonemap);
    if (!(fabs(exposure) <= MAX_STOPS))
        return lf_error_set(err, LF_E_ARG, "exposure", "%g stops; expected -%g to %g", exposure,
                            MAX_STOPS, MAX_STOPS);
    lf_tone *tone = lf_calloc(1, sizeof *tone);
    if (!tone)
        return lf_error_set(err, LF_E_NOMEM, "tonemap", "no memory");
    tone->gain = exp2(exposure);
    tone->map = map;
    tone->kernels = lf_quilt_kernels_get();
    find_thresholds(tone);
    find_centres(tone);
    if (build_table(tone) != LF_OK) {
        lf_tone_destroy(tone);
        return lf_error_set(err, LF_E_NOMEM, "tonemap", "no memory");
    }
    *out = tone;
    return LF_OK;
}

void lf_tone_destroy(lf_tone *tone)
{
    if (!tone)
        return;
    lf_free(tone->entries);
    lf_free(tone);
}

void lf_tone_map(const lf_tone *tone, size_t n, const float *in, uint8_t *out)
{
    enum { PIXELS = 128 };
    if (!tone->map->mixture) {
        tone->kernels->tone(&tone->table, 3 * n, in, out);
        return;
    }
    for (size_t i = 0; i < n; i += PIXELS) {
        float light[3 * PIXELS];
        size_t some = n - i < PIXELS ? n - i : PIXELS;
        lf_tone_linear(tone, some, in + 3 * i, light);
        tone->kernels->tone(&tone->table, 3 * some, light, out + 3 * i);
    }
}

/* Ordered dither after Bayer (1973): each of 0..63 once in 8x8 pixels. */
static const uint8_t bayer[8][8] = {
    {0, 32, 8, 40, 2, 34, 10, 42},  {48, 16, 56, 24, 50, 18, 58, 26},
    {12, 44, 4, 36, 14, 46, 6, 38}, {60, 28, 52, 20, 62, 30, 54, 22},
    {3, 35, 11, 43, 1, 33, 9, 41},  {51, 19, 59, 27, 49, 17, 57, 25},
    {15, 47, 7, 39, 13, 45, 5, 37}, {63, 31, 55, 23, 61, 29, 53, 21}};

static void dither(const lf_tone *tone, const float threshold[8], size_t n, const float *in,
                   uint8_t *codes)
{
    for (size_t i = 0; i < n; i++) {
        const float up = threshold[i & 7], down = up - 1;
        for (size_t at = 3 * i; at < 3 * i + 3; at++) {
            unsigned code = codes[at];
            float beyond = in[at] - tone->centre[code];
            float level = beyond * tone->slope[code][beyond >= 0];
            codes[at] = (uint8_t)(code + (level >= up) - (level < down));
        }
    }
}

void lf_tone_dither(const lf_tone *tone, int view, int row, size_t n, const float *in, uint8_t *out)
{
    enum { PIXELS = 128, ACROSS = 5, DOWN = 3 };
    float threshold[8], light[3 * PIXELS];
    for (int i = 0; i < 8; i++)
        threshold[i] =
            1 - ((float)bayer[(row + DOWN * view) & 7][(i + ACROSS * view) & 7] + 0.5f) / 64;
    for (size_t i = 0; i < n; i += PIXELS) {
        size_t some = n - i < PIXELS ? n - i : PIXELS;
        const float *from = in + 3 * i;
        if (tone->map->mixture) {
            lf_tone_linear(tone, some, from, light);
            from = light;
        }
        tone->kernels->tone(&tone->table, 3 * some, from, out + 3 * i);
        dither(tone, threshold, some, from, out + 3 * i);
    }
}

/* display_light where the curve changes nothing, for whole lines. */
static void lights_clamped(const lf_tone *tone, size_t n_values, const float *in, float *out)
{
    for (size_t i = 0; i < n_values; i++) {
        const double x = (double)in[i] * tone->gain;
        out[i] = (float)(x > 0 ? x < 1 ? x : 1 : 0);
    }
}

void lf_tone_linear(const lf_tone *tone, size_t n, const float *in, float *out)
{
    if (tone->map->curve == clamp) {
        lights_clamped(tone, 3 * n, in, out);
        return;
    }
    for (size_t i = 0; i < n && tone->map->mixture; i++)
        lights_mixed(tone, in + 3 * i, out + 3 * i);
    for (size_t i = 0; i < 3 * n && !tone->map->mixture; i++)
        out[i] = (float)display_light(tone, (double)in[i]);
}
