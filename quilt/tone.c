/* Display code of a float by table, bit for bit the rounded formula: codes only ever rise with the
 * value, so 255 thresholds say everything. They are found once by bisecting the formula over the
 * floats; a table over the leading bits of a float then gives the code below its bucket and where
 * in the bucket the next one begins. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/kernel/kernel.h"
#include "quilt/quilt.h"

#define INFINITY_BITS 0x7f800000
#define MAX_STOPS 64.0

struct lf_tone {
    double gain;
    bool filmic;
    /* low: below every threshold, at a bucket's start; high: the last threshold */
    lf_tone_table table;
    uint32_t *entries;  /* owned, the table's */
    int32_t first[257]; /* [code] bits of the smallest float that has it; 256 is never reached */
    const lf_quilt_kernels *kernels;
};

/* Display light of a scene value, 0..1. Filmic is K. Narkowicz's fit of the ACES curve (2015). */
static double display_light(const lf_tone *tone, double value)
{
    double x = value * tone->gain;
    if (!(x > 0))
        return 0;
    if (tone->filmic)
        x = x < 1e6 ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : 1;
    return x < 1 ? x : 1;
}

static int display_code(const lf_tone *tone, double value)
{
    double light = display_light(tone, value);
    double srgb = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
    return (int)floor(255 * srgb + 0.5);
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

/* At most one threshold in a bucket? Thresholds rise, so neighbours tell. */
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
    bool filmic = strcmp(tonemap, "filmic") == 0;
    if (!filmic && strcmp(tonemap, "srgb") != 0)
        return lf_error_set(err, LF_E_ARG, "tonemap",
                            "\"%s\" is not known (expected srgb or filmic)", tonemap);
    if (!(fabs(exposure) <= MAX_STOPS))
        return lf_error_set(err, LF_E_ARG, "exposure", "%g stops (expected -%g to %g)", exposure,
                            MAX_STOPS, MAX_STOPS);
    lf_tone *tone = lf_calloc(1, sizeof *tone);
    if (!tone)
        return lf_error_set(err, LF_E_NOMEM, "tonemap", "no memory");
    tone->gain = exp2(exposure);
    tone->filmic = filmic;
    tone->kernels = lf_quilt_kernels_get();
    find_thresholds(tone);
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
    tone->kernels->tone(&tone->table, 3 * n, in, out);
}

void lf_tone_linear(const lf_tone *tone, size_t n, const float *in, float *out)
{
    for (size_t i = 0; i < 3 * n; i++)
        out[i] = (float)display_light(tone, (double)in[i]);
}
