/* 16-bit TIFF pictures of a plate: little-endian, without compression. The file is the directory,
 * values that do not fit into it, the ICC profile, and the pixels. */
#include <assert.h>
#include <lcms2.h>
#include <string.h>

#include "base/alloc.h"
#include "base/version.h"
#include "quilt/hologram/plate.h"

enum {
    TIFF_ASCII = 2,
    TIFF_SHORT = 3,
    TIFF_LONG = 4,
    TIFF_RATIONAL = 5,
    TIFF_BYTES = 7,
    TIFF_ENTRIES = 15,
    TIFF_BITS = 8 + 2 + 12 * TIFF_ENTRIES + 4, /* values that do not fit into an entry */
    TIFF_RESOLUTIONS = TIFF_BITS + 6,
    TIFF_TEXT = TIFF_RESOLUTIONS + 16,
    TIFF_TEXT_BYTES = 32,
    TIFF_HEAD = TIFF_TEXT + TIFF_TEXT_BYTES,
    NO_UNIT = 1,
    CENTIMETRE = 3,
    MICRONS = 10000, /* in a centimetre */
};

typedef struct profile {
    uint8_t *bytes; /* released with lf_free */
    uint32_t size;
} profile;

/* ------------------------------------------------------------------------------- ICC profile -- */

static cmsHPROFILE linear_grey(cmsContext context)
{
    cmsToneCurve *line = cmsBuildGamma(context, 1.0);
    cmsHPROFILE made = line ? cmsCreateGrayProfileTHR(context, cmsD50_xyY(), line) : NULL;
    if (line)
        cmsFreeToneCurve(line);
    return made;
}

/* sRGB, or grey whose codes are light. The creation date is fixed, so that equal pictures are equal
 * files: 2000-01-01. */
static bool make_profile(bool is_grey, profile *out)
{
    static const uint8_t date[12] = {0x07, 0xd0, 0, 1, 0, 1};
    cmsContext context = cmsCreateContext(NULL, NULL);
    cmsHPROFILE made = is_grey ? linear_grey(context) : cmsCreate_sRGBProfileTHR(context);
    cmsUInt32Number size = 0;
    *out = (profile){0};
    if (made && cmsSaveProfileToMem(made, NULL, &size))
        out->bytes = lf_calloc(1, size + 1);
    const bool is_made = out->bytes && cmsSaveProfileToMem(made, out->bytes, &size);
    if (is_made) {
        memcpy(out->bytes + 24, date, sizeof date);
        out->size = size + (size & 1); /* pixels begin at an even place */
    }
    if (made)
        cmsCloseProfile(made);
    if (context)
        cmsDeleteContext(context);
    return is_made;
}

/* --------------------------------------------------------------------------------- directory -- */

static void put(uint32_t value, int bytes, uint8_t *out)
{
    for (int i = 0; i < bytes; i++)
        out[i] = (uint8_t)(value >> 8 * i & 0xff);
}

static uint8_t *put_entry(uint8_t *at, int tag, int type, uint32_t n, uint32_t value)
{
    put((uint32_t)tag, 2, at);
    put((uint32_t)type, 2, at + 2);
    put(n, 4, at + 4);
    put(value, 4, at + 8);
    return at + 12;
}

/* Only pixels of views are cells, which have a size. The fractions are exact: printers lay out by
 * them. */
static uint32_t put_resolutions(const lf_plate *plate, int width, int height, uint8_t *head)
{
    const bool is_known = plate->form == LF_PLATE_VIEWS && plate->microns[0] > 0;
    const int n[2] = {width, height};
    for (int i = 0; i < 2; i++) {
        put(is_known ? (uint32_t)n[i] * MICRONS : 1, 4, head + TIFF_RESOLUTIONS + 8 * i);
        put(is_known ? (uint32_t)plate->microns[i] : 1, 4, head + TIFF_RESOLUTIONS + 8 * i + 4);
    }
    return is_known ? CENTIMETRE : NO_UNIT;
}

static void put_head(const lf_plate *plate, int width, int height, uint32_t bytes,
                     uint32_t profile_size, uint8_t head[TIFF_HEAD])
{
    static const char program[] = "quiltd " LF_VERSION;
    const uint32_t channels = plate->is_grey ? 1 : 3,
                   unit = put_resolutions(plate, width, height, head);
    static_assert(sizeof program > 4 && sizeof program <= TIFF_TEXT_BYTES, "it has its place");
    memcpy(head, "II*\0\10", 5);
    put(TIFF_ENTRIES, 2, head + 8);
    uint8_t *at = head + 10;
    at = put_entry(at, 256, TIFF_LONG, 1, (uint32_t)width);
    at = put_entry(at, 257, TIFF_LONG, 1, (uint32_t)height);
    at = put_entry(at, 258, TIFF_SHORT, channels, channels == 1 ? 16 : TIFF_BITS);
    at = put_entry(at, 259, TIFF_SHORT, 1, 1);                     /* no compression */
    at = put_entry(at, 262, TIFF_SHORT, 1, channels == 1 ? 1 : 2); /* grey from black, or RGB */
    at = put_entry(at, 273, TIFF_LONG, 1, TIFF_HEAD + profile_size);
    at = put_entry(at, 274, TIFF_SHORT, 1, 1); /* top left */
    at = put_entry(at, 277, TIFF_SHORT, 1, channels);
    at = put_entry(at, 278, TIFF_LONG, 1, (uint32_t)height); /* one strip */
    at = put_entry(at, 279, TIFF_LONG, 1, bytes);
    at = put_entry(at, 282, TIFF_RATIONAL, 1, TIFF_RESOLUTIONS);
    at = put_entry(at, 283, TIFF_RATIONAL, 1, TIFF_RESOLUTIONS + 8);
    at = put_entry(at, 296, TIFF_SHORT, 1, unit);
    at = put_entry(at, 305, TIFF_ASCII, sizeof program, TIFF_TEXT);
    at = put_entry(at, 34675, TIFF_BYTES, profile_size, TIFF_HEAD);
    put(0, 4, at);
    for (int i = 0; i < 3; i++)
        put(16, 2, head + TIFF_BITS + 2 * i);
    memcpy(head + TIFF_TEXT, program, sizeof program);
}

lf_status lf_plate_tiff_write(const lf_plate *plate, lf_outfile *file, int width, int height,
                              const uint8_t *samples, lf_error *err)
{
    const size_t bytes = (size_t)width * (size_t)height * lf_plate_pixel_bytes(plate);
    uint8_t head[TIFF_HEAD] = {0};
    profile of = {0};
    if (!make_profile(plate->is_grey, &of)) {
        lf_free(of.bytes);
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    }
    lf_status status = LF_OK;
    if (bytes > UINT32_MAX - TIFF_HEAD - of.size)
        status = lf_error_set(err, LF_E_ARG, file->path, "is too large for a TIFF; use exr");
    if (status == LF_OK) {
        put_head(plate, width, height, (uint32_t)bytes, of.size, head);
        status = lf_outfile_write(file, head, sizeof head, err);
    }
    if (status == LF_OK)
        status = lf_outfile_write(file, of.bytes, of.size, err);
    lf_free(of.bytes);
    return status == LF_OK ? lf_outfile_write(file, samples, bytes, err) : status;
}
