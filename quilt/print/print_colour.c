#include <lcms2.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "quilt/print/print.h"

#define MAX_PROFILE_BYTES (16U << 20)
#define BLOCK 512 /* pixels converted at once */

/* The 8-bit and 16-bit encoders index by the bits of the float, with a fixed number of bins per
 * octave. */
#define LOW8 0x1p-13F /* below the first rounding border, 0.5 / 255 / 12.92 */
#define LOW16 0x1p-9F /* below the end of the curve's linear part */
#define SHIFT8 16     /* 128 bins per octave: at most two code values per bin */
#define SHIFT16 13    /* 1024 bins per octave: linear interpolation is accurate to 3e-8 */
#define BINS8 (13 * 128 + 1)
#define BINS16 (9 * 1024 + 2)

struct lf_print_colour {
    int bits, channels;
    size_t profile_size;
    unsigned char *profile; /* released with lf_free */
    char name[128];
    cmsContext context;
    cmsHTRANSFORM transform; /* NULL = sRGB with the tables below */
    char complaint[256];     /* last message of Little CMS */
    uint8_t start8[BINS8];
    float border8[257]; /* code k begins here; the last is never reached */
    float curve16[BINS16];
};

/* -------------------------------------------------------------------------------- sRGB curve -- */

static double srgb_from_linear(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
}

static double linear_from_srgb(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static uint32_t float_bits(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static float float_of_bits(uint32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* The least float that rounds to code k or above; inverting the curve gives it within a few
 * floats. */
static float border_of(int k)
{
    float border = (float)linear_from_srgb((k - 0.5) / 255.0);
    while (255.0 * srgb_from_linear((double)border) < k - 0.5)
        border = nextafterf(border, 2.0F);
    while (255.0 * srgb_from_linear((double)nextafterf(border, 0.0F)) >= k - 0.5)
        border = nextafterf(border, 0.0F);
    return border;
}

static void make_curves(lf_print_colour *colour)
{
    for (int k = 1; k < 256; k++)
        colour->border8[k] = border_of(k);
    colour->border8[256] = 2.0F;
    int code = 0;
    for (uint32_t bin = 0; bin < BINS8; bin++) {
        const float low = float_of_bits(float_bits(LOW8) + (bin << SHIFT8));
        while (code < 255 && colour->border8[code + 1] <= low)
            code++;
        colour->start8[bin] = (uint8_t)code;
    }
    for (uint32_t bin = 0; bin < BINS16; bin++) {
        const float low = float_of_bits(float_bits(LOW16) + (bin << SHIFT16));
        colour->curve16[bin] = (float)(65535.0 * srgb_from_linear((double)low));
    }
}

static float clamped(float v)
{
    return v > 0.0F ? v < 1.0F ? v : 1.0F : 0.0F;
}

/* Without branches: light changes from stripe to stripe, so that none would be foreseen. A bin has
 * at most one border. */
static uint8_t encode8(const lf_print_colour *colour, float linear)
{
    float v = linear > LOW8 ? linear : LOW8; /* also for what is not a number */
    v = v < 1.0F ? v : 1.0F;
    const unsigned code = colour->start8[(float_bits(v) - float_bits(LOW8)) >> SHIFT8];
    return (uint8_t)(code + (v >= colour->border8[code + 1]));
}

static uint16_t encode16(const lf_print_colour *colour, float linear)
{
    const float v = clamped(linear);
    if (v <= 0.0031308F)
        return (uint16_t)(12.92F * 65535.0F * v + 0.5F);
    const uint32_t offset = float_bits(v) - float_bits(LOW16);
    const float *curve = colour->curve16 + (offset >> SHIFT16);
    const float fraction = (float)(offset & ((1U << SHIFT16) - 1)) * (1.0F / (1 << SHIFT16));

    return (uint16_t)(curve[0] + fraction * (curve[1] - curve[0]) + 0.5F);
}

static void encode_srgb(const lf_print_colour *colour, size_t n_values, const float *in, void *out)
{
    uint8_t *out8 = out;
    uint16_t *out16 = out;
    if (colour->bits == 8)
        for (size_t i = 0; i < n_values; i++)
            out8[i] = encode8(colour, in[i]);
    else
        for (size_t i = 0; i < n_values; i++)
            out16[i] = encode16(colour, in[i]);
}

/* ---------------------------------------------------------------------------------- profiles -- */

static void keep_complaint(cmsContext context, cmsUInt32Number code, const char *text)
{
    lf_print_colour *colour = cmsGetContextUserData(context);
    (void)code;
    if (colour->complaint[0] == '\0')
        snprintf(colour->complaint, sizeof colour->complaint, "%s", text);
}

static void name_profile(lf_print_colour *colour, cmsHPROFILE profile)
{
    if (cmsGetProfileInfoASCII(profile, cmsInfoDescription, "en", "US", colour->name,
                               sizeof colour->name) == 0)
        colour->name[0] = '\0';
    colour->name[sizeof colour->name - 1] = '\0';
    for (char *c = colour->name; *c != '\0'; c++)
        if (*c < 0x20 || *c > 0x7e)
            *c = '?';
    if (colour->name[0] == '\0')
        snprintf(colour->name, sizeof colour->name, "unnamed");
}

static lf_status make_srgb(lf_print_colour *colour, lf_error *err)
{
    cmsHPROFILE profile = cmsCreate_sRGBProfileTHR(colour->context);
    cmsUInt32Number size = 0;
    lf_status status = LF_E_NOMEM;
    colour->channels = 3;
    if (profile && cmsSaveProfileToMem(profile, NULL, &size)) {
        colour->profile = lf_calloc(1, size);
        colour->profile_size = size;
        if (colour->profile && cmsSaveProfileToMem(profile, colour->profile, &size))
            status = LF_OK;
    }
    if (status == LF_OK) {
        /* The creation date is fixed, so that equal prints do not differ: 2000-01-01. */
        static const unsigned char date[12] = {0x07, 0xd0, 0, 1, 0, 1};
        memcpy(colour->profile + 24, date, sizeof date);
        snprintf(colour->name, sizeof colour->name, "sRGB");
        make_curves(colour);
    }
    if (profile)
        cmsCloseProfile(profile);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, "print", "cannot make the sRGB profile");
}

static cmsHPROFILE linear_rec709(cmsContext context)
{
    const cmsCIExyY white = {0.3127, 0.3290, 1.0};
    const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.30, 0.60, 1.0}, {0.15, 0.06, 1.0}};
    cmsToneCurve *line = cmsBuildGamma(context, 1.0);
    cmsToneCurve *lines[3] = {line, line, line};
    cmsHPROFILE profile = line ? cmsCreateRGBProfileTHR(context, &white, &primaries, lines) : NULL;
    if (line)
        cmsFreeToneCurve(line);
    return profile;
}

/* Accepts RGB and CMYK profiles of devices that print or display. */
static lf_status check_profile(lf_print_colour *colour, cmsHPROFILE profile, const char *path,
                               lf_error *err)
{
    const cmsColorSpaceSignature space = cmsGetColorSpace(profile);
    const cmsProfileClassSignature kind = cmsGetDeviceClass(profile);
    if (space != cmsSigRgbData && space != cmsSigCmykData)
        return lf_error_set(err, LF_E_FORMAT, path,
                            "unsupported colour space of the profile; expected RGB or CMYK");
    if (kind != cmsSigDisplayClass && kind != cmsSigOutputClass && kind != cmsSigColorSpaceClass)
        return lf_error_set(err, LF_E_FORMAT, path,
                            "expected the profile of a display, a printer or a colour space");
    colour->channels = space == cmsSigCmykData ? 4 : 3;
    name_profile(colour, profile);
    return LF_OK;
}

static lf_status make_transform(lf_print_colour *colour, cmsHPROFILE profile, const char *path,
                                lf_error *err)
{
    const cmsUInt32Number flags =
        cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE | cmsFLAGS_BLACKPOINTCOMPENSATION;
    cmsHPROFILE scene = linear_rec709(colour->context);
    /* Floats on both sides, because 16 bits of linear light are too coarse in dark tones. */
    if (scene)
        colour->transform =
            cmsCreateTransformTHR(colour->context, scene, TYPE_RGB_FLT, profile,
                                  colour->channels == 4 ? TYPE_CMYK_FLT : TYPE_RGB_FLT,
                                  INTENT_RELATIVE_COLORIMETRIC, flags);
    if (scene)
        cmsCloseProfile(scene);
    if (!colour->transform)
        return lf_error_set(err, LF_E_FORMAT, path,
                            "colours cannot be converted to this profile: %s",
                            colour->complaint[0] ? colour->complaint : "no reason given");
    return LF_OK;
}

/* A message of lcms without the part that the error already contains. */
static const char *reason_of(const char *complaint)
{
    static const char said[] = "not an ICC profile, ";
    const bool again = strncasecmp(complaint, said, sizeof said - 1) == 0;
    return complaint + (again ? sizeof said - 1 : 0);
}

static lf_status load_profile(lf_print_colour *colour, const lf_print *print, lf_error *err)
{
    char *data = NULL;
    lf_status status = lf_file_read(print->icc_path, print->icc_roots, MAX_PROFILE_BYTES, &data,
                                    &colour->profile_size, err);
    if (status != LF_OK)
        return status;
    colour->profile = (unsigned char *)data;
    cmsHPROFILE profile =
        cmsOpenProfileFromMemTHR(colour->context, data, (cmsUInt32Number)colour->profile_size);
    if (!profile)
        return lf_error_set(err, LF_E_FORMAT, print->icc_path, "not an ICC profile%s%s",
                            colour->complaint[0] ? ": " : "", reason_of(colour->complaint));
    status = check_profile(colour, profile, print->icc_path, err);
    if (status == LF_OK)
        status = make_transform(colour, profile, print->icc_path, err);
    cmsCloseProfile(profile);
    return status;
}

lf_status lf_print_colour_create(const lf_print *print, lf_print_colour **out, lf_error *err)
{
    lf_print_colour *colour = lf_calloc(1, sizeof *colour);
    if (!colour)
        return lf_error_set(err, LF_E_NOMEM, "print", "out of memory");
    colour->bits = print->bits;
    colour->context = cmsCreateContext(NULL, colour);
    lf_status status = LF_E_NOMEM;
    if (colour->context) {
        cmsSetLogErrorHandlerTHR(colour->context, keep_complaint);
        status = print->icc_path ? load_profile(colour, print, err) : make_srgb(colour, err);
    } else {
        lf_error_set(err, status, "print", "out of memory");
    }
    if (status != LF_OK) {
        lf_print_colour_destroy(colour);
        return status;
    }
    *out = colour;
    return LF_OK;
}

void lf_print_colour_destroy(lf_print_colour *colour)
{
    if (!colour)
        return;
    if (colour->transform)
        cmsDeleteTransform(colour->transform);
    if (colour->context)
        cmsDeleteContext(colour->context);
    lf_free(colour->profile);
    lf_free(colour);
}

int lf_print_colour_channels(const lf_print_colour *colour)
{
    return colour->channels;
}

const char *lf_print_colour_name(const lf_print_colour *colour)
{
    return colour->name;
}

const void *lf_print_colour_profile(const lf_print_colour *colour, size_t *out_size)
{
    *out_size = colour->profile_size;
    return colour->profile;
}

/* -------------------------------------------------------------------------------- conversion -- */

static void quantise(const lf_print_colour *colour, size_t n_values, const float *device, void *out)
{
    const float scale = colour->channels == 4 ? 0.01F : 1.0F; /* Little CMS counts ink in percent */
    uint8_t *out8 = out;
    uint16_t *out16 = out;
    if (colour->bits == 8)
        for (size_t i = 0; i < n_values; i++)
            out8[i] = (uint8_t)(clamped(scale * device[i]) * 255.0F + 0.5F);
    else
        for (size_t i = 0; i < n_values; i++)
            out16[i] = (uint16_t)(clamped(scale * device[i]) * 65535.0F + 0.5F);
}

void lf_print_colour_encode(const lf_print_colour *colour, size_t n, const float *in, void *out)
{
    const size_t pixel_bytes = (size_t)colour->channels * (size_t)colour->bits / 8;
    float device[4 * BLOCK];
    if (!colour->transform) {
        encode_srgb(colour, 3 * n, in, out);
        return;
    }
    for (size_t i = 0; i < n; i += BLOCK) {
        const size_t n_block = n - i < BLOCK ? n - i : BLOCK;
        cmsDoTransform(colour->transform, in + 3 * i, device, (cmsUInt32Number)n_block);
        quantise(colour, n_block * (size_t)colour->channels, device,
                 (unsigned char *)out + i * pixel_bytes);
    }
}
