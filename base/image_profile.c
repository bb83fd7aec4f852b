#include "base/image_profile.h"

#include <math.h>
#include <string.h>

/* --------------------------------------------------------------------------------------- ICC -- */

static double fixed(const uint8_t *p)
{
    return (int32_t)lf_be32(p) / 65536.0;
}

/* The element of a tag, of at least `least` bytes; NULL: not among these bytes. */
static const uint8_t *find_tag(const uint8_t *data, size_t size, const char *tag, size_t least,
                               size_t *out_size)
{
    uint32_t n = size >= 132 ? lf_be32(data + 128) : 0;
    for (uint32_t i = 0; i < n && 132 + 12 * ((size_t)i + 1) <= size; i++) {
        const uint8_t *entry = data + 132 + 12 * (size_t)i;
        size_t at = lf_be32(entry + 4), length = lf_be32(entry + 8);
        if (memcmp(entry, tag, 4) != 0)
            continue;
        *out_size = length;
        return at <= size && length <= size - at && length >= least ? data + at : NULL;
    }
    return NULL;
}

static bool has_colour(const uint8_t *data, size_t size, const char *tag, const double xyz[3])
{
    size_t n;
    const uint8_t *element = find_tag(data, size, tag, 20, &n);
    for (int i = 0; element && i < 3; i++)
        if (fabs(fixed(element + 8 + 4 * i) - xyz[i]) > 2e-3)
            return false;
    return element;
}

/* The light of code 0.5 by a table or parametric curve; negative: unknown. */
static double light_of_half(const uint8_t *curve, size_t size)
{
    if (memcmp(curve, "curv", 4) == 0) {
        uint32_t n = lf_be32(curve + 8);
        if (n == 0)
            return 0.5;
        if (n == 1 && size >= 14)
            return pow(0.5, (curve[12] << 8 | curve[13]) / 256.0);
        if (n > 1 && n <= 65536 && size >= 12 + 2 * (size_t)n) {
            const uint8_t *at = curve + 12 + 2 * (size_t)((n - 1) / 2);
            double low = at[0] << 8 | at[1], high = at[2] << 8 | at[3];
            return (n % 2 ? low : (low + high) / 2) / 65535;
        }
    } else if (memcmp(curve, "para", 4) == 0 && size >= 16) {
        int kind = curve[8] << 8 | curve[9];
        double g = fixed(curve + 12);
        if (kind == 0)
            return pow(0.5, g);
        if (kind <= 4 && size >= 24)
            return pow(fmax(fixed(curve + 16) * 0.5 + fixed(curve + 20), 0), g);
    }
    return -1;
}

bool lf_icc_is_srgb(const uint8_t *data, size_t size)
{
    /* adapted to D50 by Bradford, as in every sRGB profile */
    static const double red[3] = {0.4361, 0.2225, 0.0139}, green[3] = {0.3851, 0.7169, 0.0971},
                        blue[3] = {0.1431, 0.0606, 0.7141};
    size_t n;
    const uint8_t *curve = find_tag(data, size, "rTRC", 12, &n);
    return curve && memcmp(data + 16, "RGB ", 4) == 0 && has_colour(data, size, "rXYZ", red) &&
           has_colour(data, size, "gXYZ", green) && has_colour(data, size, "bXYZ", blue) &&
           fabs(light_of_half(curve, n) - 0.21404) < 0.005;
}

/* -------------------------------------------------------------------------------------- EXIF -- */

typedef struct tiff {
    const uint8_t *data;
    size_t size;
    bool big;
    bool is_broken; /* a directory ends past the data */
} tiff;

static uint32_t number(const tiff *t, size_t at, int bytes)
{
    uint32_t value = 0;
    for (int i = 0; i < bytes; i++)
        value = value << 8 | t->data[at + (size_t)(t->big ? i : bytes - 1 - i)];
    return value;
}

/* A tag with one short or long in the directory at `folder`; 0: missing. */
static uint32_t find_number(tiff *t, size_t folder, uint32_t tag)
{
    uint32_t n = folder + 2 <= t->size ? number(t, folder, 2) : 0;
    t->is_broken |= folder + 2 + 12 * (size_t)n > t->size;
    for (uint32_t i = 0; i < n; i++) {
        size_t entry = folder + 2 + 12 * (size_t)i;
        if (entry + 12 > t->size)
            return 0;
        if (number(t, entry, 2) == tag)
            return number(t, entry + 8, number(t, entry + 2, 2) == 3 ? 2 : 4);
    }
    return 0;
}

void lf_exif_read(const uint8_t *data, size_t size, lf_image_metadata *meta)
{
    enum { ORIENTATION = 0x0112, EXIF_FOLDER = 0x8769, COLOUR_SPACE = 0xa001, FOCAL_35MM = 0xa405 };
    tiff t = {data, size, size >= 2 && data[0] == 'M', false};
    if (size < 8 || (memcmp(data, "II*\0", 4) != 0 && memcmp(data, "MM\0*", 4) != 0)) {
        lf_image_note(&meta->notes, "the EXIF data is damaged; it is ignored");
        return;
    }
    uint32_t folder = number(&t, 4, 4), turn = find_number(&t, folder, ORIENTATION);
    uint32_t more = find_number(&t, folder, EXIF_FOLDER);
    uint32_t space = more ? find_number(&t, more, COLOUR_SPACE) : 0;
    const uint32_t focal = more ? find_number(&t, more, FOCAL_35MM) : 0;
    if (focal > 0 && focal <= LF_IMAGE_MAX_FOCAL)
        meta->focal_35mm = (int)focal;
    if (t.is_broken)
        lf_image_note(&meta->notes, "the EXIF data is damaged; its readable part is used");
    if (turn > 8)
        lf_image_note(&meta->notes, "unknown EXIF orientation %u; the image is not rotated", turn);
    else if (turn > 0 && meta->orientation == 0)
        meta->orientation = (int)turn;
    if (space > 1 && space != 0xffff) /* neither of the two values of EXIF: a profile's */
        lf_image_note(&meta->notes,
                      "EXIF colour space %u%s is not applied; colours are read as sRGB", space,
                      space == 2 ? " (Adobe RGB)" : "");
}
