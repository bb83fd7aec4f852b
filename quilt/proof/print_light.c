#include "quilt/proof/print_light.h"

#include <lcms2.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

#define BLOCK 256

struct lf_print_light {
    int channels, bits;
    cmsContext context;
    cmsHTRANSFORM transform; /* NULL: the table, or ideal inks */
    /* [3][levels][3]: the light that each channel adds, where channels add up (RGB profiles made of
     * curves and a matrix); NULL: they do not */
    float *table;
    char name[128], problem[160];
};

static void keep_complaint(cmsContext context, cmsUInt32Number code, const char *text)
{
    lf_print_light *light = cmsGetContextUserData(context);
    (void)code;
    if (light->problem[0] == '\0')
        snprintf(light->problem, sizeof light->problem, "%s", text);
}

static int levels(const lf_print_light *light)
{
    return light->bits == 16 ? 65536 : 256;
}

/* ---------------------------------------------------------------------------------- profiles -- */

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

static void name_profile(lf_print_light *light, cmsHPROFILE profile)
{
    if (cmsGetProfileInfoASCII(profile, cmsInfoDescription, "en", "US", light->name,
                               sizeof light->name) == 0)
        light->name[0] = '\0';
    light->name[sizeof light->name - 1] = '\0';
    for (char *c = light->name; *c != '\0'; c++)
        if (*c < 0x20 || *c > 0x7e)
            *c = '?';
    if (light->name[0] == '\0')
        snprintf(light->name, sizeof light->name, "unnamed");
}

static void make_transform(lf_print_light *light, const void *icc, size_t size)
{
    const cmsUInt32Number flags =
        cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE | cmsFLAGS_BLACKPOINTCOMPENSATION;
    cmsHPROFILE profile = cmsOpenProfileFromMemTHR(light->context, icc, (cmsUInt32Number)size);
    cmsHPROFILE scene = linear_rec709(light->context);
    const cmsColorSpaceSignature wanted = light->channels == 4 ? cmsSigCmykData : cmsSigRgbData;
    if (profile && cmsGetColorSpace(profile) != wanted)
        snprintf(light->problem, sizeof light->problem,
                 "the profile is for another colour space than the pixels");
    else if (profile && scene)
        light->transform = cmsCreateTransformTHR(
            light->context, profile, light->channels == 4 ? TYPE_CMYK_FLT : TYPE_RGB_FLT, scene,
            TYPE_RGB_FLT, INTENT_RELATIVE_COLORIMETRIC, flags);
    if (light->transform)
        name_profile(light, profile);
    if (profile)
        cmsCloseProfile(profile);
    if (scene)
        cmsCloseProfile(scene);
    if (!light->transform && light->problem[0] == '\0')
        snprintf(light->problem, sizeof light->problem, "not a usable ICC profile");
}

/* ------------------------------------------------------------------------------------- table -- */

static double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* Light of a device colour, 0..1 each. */
static void light_of(const lf_print_light *light, const float device[3], float out[3])
{
    if (light->transform)
        cmsDoTransform(light->transform, device, out, 1);
    else
        for (int c = 0; c < 3; c++)
            out[c] = (float)srgb_to_linear((double)device[c]);
}

/* True if the light of a colour is the sum of that of its channels, at many colours. */
static bool adds_up(const lf_print_light *light)
{
    float black[3];
    light_of(light, (const float[3]){0, 0, 0}, black);
    for (int i = 0; i < 125; i++) {
        const int step[3] = {i % 5, i / 5 % 5, i / 25};
        const float device[3] = {(float)step[0] / 4, (float)step[1] / 4, (float)step[2] / 4};
        float whole[3], sum[3] = {-2 * black[0], -2 * black[1], -2 * black[2]};
        light_of(light, device, whole);
        for (int c = 0; c < 3; c++) {
            float alone[3] = {0, 0, 0}, part[3];
            alone[c] = device[c];
            light_of(light, alone, part);
            for (int k = 0; k < 3; k++)
                sum[k] += part[k];
        }
        for (int k = 0; k < 3; k++)
            if (!(fabsf(sum[k] - whole[k]) < 2e-4F))
                return false;
    }
    return true;
}

static lf_status make_table(lf_print_light *light)
{
    const int n = levels(light);
    float black[3];
    light->table = lf_calloc(3 * (size_t)n, 3 * sizeof *light->table);
    if (!light->table)
        return LF_E_NOMEM;
    light_of(light, (const float[3]){0, 0, 0}, black);
    for (int c = 0; c < 3; c++)
        for (int v = 0; v < n; v++) {
            float *out = light->table + 3 * ((size_t)c * (size_t)n + (size_t)v);
            float device[3] = {0, 0, 0};
            device[c] = (float)v / (float)(n - 1);
            light_of(light, device, out);
            for (int k = 0; k < 3; k++)
                out[k] -= c == 0 ? 0.0F : black[k];
        }
    return LF_OK;
}

lf_status lf_print_light_create(int channels, int bits, const void *icc, size_t size,
                                lf_print_light **out)
{
    lf_print_light *light = lf_calloc(1, sizeof *light);
    lf_status status = LF_OK;
    if (!light)
        return LF_E_NOMEM;
    light->channels = channels;
    light->bits = bits;
    light->context = cmsCreateContext(NULL, light);
    if (!light->context) {
        lf_print_light_destroy(light);
        return LF_E_NOMEM;
    }
    cmsSetLogErrorHandlerTHR(light->context, keep_complaint);
    if (icc)
        make_transform(light, icc, size);
    else
        snprintf(light->problem, sizeof light->problem, "no colour profile is embedded");
    if (channels == 3 && (!light->transform || adds_up(light)))
        status = make_table(light);
    if (status != LF_OK) {
        lf_print_light_destroy(light);
        return status;
    }
    *out = light;
    return LF_OK;
}

void lf_print_light_destroy(lf_print_light *light)
{
    if (!light)
        return;
    if (light->transform)
        cmsDeleteTransform(light->transform);
    if (light->context)
        cmsDeleteContext(light->context);
    lf_free(light->table);
    lf_free(light);
}

const char *lf_print_light_name(const lf_print_light *light)
{
    return light->name;
}

const char *lf_print_light_problem(const lf_print_light *light)
{
    return light->transform ? NULL : light->problem;
}

/* -------------------------------------------------------------------------------- conversion -- */

static unsigned stored(const lf_print_light *light, const void *raw, size_t i)
{
    return light->bits == 16 ? ((const uint16_t *)raw)[i] : ((const uint8_t *)raw)[i];
}

/* A light that profiles may put below black or above paper, or make not a number. */
static float cut(float v)
{
    return v > 0.0F ? v < 1.0F ? v : 1.0F : 0.0F;
}

static void by_table(const lf_print_light *light, const void *raw, size_t n, float *out)
{
    const size_t levels_3 = 3 * (size_t)levels(light);
    for (size_t i = 0; i < n; i++) {
        const float *red = light->table + 3 * (size_t)stored(light, raw, 3 * i),
                    *green = light->table + levels_3 + 3 * (size_t)stored(light, raw, 3 * i + 1),
                    *blue = light->table + 2 * levels_3 + 3 * (size_t)stored(light, raw, 3 * i + 2);
        for (int k = 0; k < 3; k++)
            out[3 * i + (size_t)k] = cut(red[k] + green[k] + blue[k]);
    }
}

static void by_transform(const lf_print_light *light, const void *raw, size_t n, float *out)
{
    const size_t channels = (size_t)light->channels;
    /* Little CMS counts ink in percent. */
    const float scale = (channels == 4 ? 100.0F : 1.0F) / (float)(levels(light) - 1);
    float device[4 * BLOCK];
    for (size_t at = 0; at < n; at += BLOCK) {
        const size_t n_block = n - at < BLOCK ? n - at : BLOCK;
        for (size_t i = 0; i < n_block * channels; i++)
            device[i] = scale * (float)stored(light, raw, at * channels + i);
        cmsDoTransform(light->transform, device, out + 3 * at, (cmsUInt32Number)n_block);
        for (size_t i = 0; i < 3 * n_block; i++)
            out[3 * at + i] = cut(out[3 * at + i]);
    }
}

/* Each ink takes its share of one colour, and black its share of all. */
static void by_ideal_inks(const lf_print_light *light, const void *raw, size_t n, float *out)
{
    const float scale = 1.0F / (float)(levels(light) - 1);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < 3; k++)
            out[3 * i + k] = (1.0F - scale * (float)stored(light, raw, 4 * i + k)) *
                             (1.0F - scale * (float)stored(light, raw, 4 * i + 3));
}

void lf_print_light_decode(const lf_print_light *light, const void *raw, size_t n, float *out)
{
    if (light->table)
        by_table(light, raw, n, out);
    else if (light->transform)
        by_transform(light, raw, n, out);
    else
        by_ideal_inks(light, raw, n, out);
}
