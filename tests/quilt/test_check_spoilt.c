/* The checklist on spoilt prints. Each is checked as it is, where the SHA-256 tells, and with the
 * manifest's SHA-256 set to the spoilt file's, as a careless tool would, where the named point must
 * tell. What no file can say about itself is checked once more, with the rows kept while it was
 * written. */
#include "tests/testing.h"

#include <tiffio.h>

#include "base/alloc.h"
#include "tests/quilt/checked.h"
#include "tests/quilt/printed.h"

/* What a file is spoilt from. */
typedef enum base_print {
    USUAL,
    NEAREST,
    MARKED,
    ACROSS,
    SIXTEEN,
    PACKED,
    BLED,
    SLANTED,
    EXACT
} base_print;

typedef struct spoilt_case {
    const char *name;
    base_print base;
    void (*spoil)(lf_checked *checked);
    /* The point (from 1) that must fail with the SHA-256 set right; 0: none does, and the rows kept
     * while it was written tell (points 9 and 17) */
    int point;
    bool keeps_hash; /* the file itself is unchanged */
} spoilt_case;

static lf_print base_of(base_print base)
{
    lf_print print = {.lpi = 60.13,
                      .dpi = 600,
                      .width_mm = 36,
                      .height_mm = 3,
                      .phase_mm = 0.02,
                      .n_views = 7,
                      .bits = 8};
    if (base == NEAREST)
        print.stripes = LF_STRIPES_NEAREST;
    if (base == MARKED) {
        print.marks = true;
        print.n_views = 10;
        print.bleed_mm = 1;
    }
    if (base == ACROSS) {
        print.horizontal = true;
        print.width_mm = 3;
        print.height_mm = 36;
    }
    if (base == SIXTEEN)
        print.bits = 16;
    if (base == PACKED)
        print.compress = LF_COMPRESS_DEFLATE;
    if (base == SLANTED)
        print.optics.slant = 10;
    if (base == EXACT) {
        print.optics.thickness_mm = 2;
        print.optics.distance_mm = 300;
    }
    if (base == BLED)
        print.bleed_mm = 2;
    return print;
}

/* --------------------------------------------------------------------------- spoiling pixels -- */

/* A value of the new picture, from the old one. */
typedef double (*pixel_fn)(const lf_saved *old, int x, int y, int c);

static void redraw(lf_checked *checked, int wider, int higher, pixel_fn pixel)
{
    lf_saved old, out;
    lf_saved_read(checked->tiff, &old);
    out = old;
    out.width = old.width + wider;
    out.height = old.height + higher;
    out.data = lf_calloc((size_t)out.width * (size_t)out.height,
                         (size_t)out.samples * (size_t)out.bits / 8);
    assert_non_null(out.data);
    for (int y = 0; y < out.height; y++)
        for (int x = 0; x < out.width; x++)
            for (int c = 0; c < out.samples; c++)
                lf_saved_set(&out, x, y, c, pixel(&old, x, y, c));
    lf_saved_write(&out, checked->tiff);
    lf_free(out.data);
    lf_saved_finish(&old);
}

static double at(const lf_saved *old, int x, int y, int c)
{
    x = x < 0 ? 0 : x >= old->width ? old->width - 1 : x;
    y = y < 0 ? 0 : y >= old->height ? old->height - 1 : y;
    return lf_saved_at(old, x, y, c);
}

static double between(const lf_saved *old, double x, double y, int c)
{
    const int left = (int)floor(x), top = (int)floor(y);
    const double right = x - left, down = y - top;
    return (1 - down) * ((1 - right) * at(old, left, top, c) + right * at(old, left + 1, top, c)) +
           down * ((1 - right) * at(old, left, top + 1, c) + right * at(old, left + 1, top + 1, c));
}

#define PIXEL(name, value)                                                                         \
    static double name##_pixel(const lf_saved *old, int x, int y, int c)                           \
    {                                                                                              \
        return value;                                                                              \
    }
#define REDRAWN(name, wider, higher, value)                                                        \
    PIXEL(name, value)                                                                             \
    static void name(lf_checked *checked)                                                          \
    {                                                                                              \
        redraw(checked, wider, higher, name##_pixel);                                              \
    }

static double middle_x(const lf_saved *old)
{
    return 0.5 * old->width - 0.5;
}

static double middle_y(const lf_saved *old)
{
    return 0.5 * old->height - 0.5;
}

static double jpeg_like(const lf_saved *old, int x, int y, int c)
{
    static const double pi = 3.14159265358979;
    double sum = 0;
    const int left = x & ~7;
    for (int k = 0; k < 8; k++) {
        double wave = 0;
        for (int i = 0; i < 8; i++)
            wave += at(old, left + i, y, c) * cos(pi * (i + 0.5) * k / 8);
        const double step = 3 + 2 * k, quantised = step * round(wave / step);
        sum += (k == 0 ? 0.125 : 0.25) * quantised * cos(pi * (x - left + 0.5) * k / 8);
    }
    return sum;
}

static double brighter(double code)
{
    return 255 * pow(code / 255, 0.9);
}

REDRAWN(resized, 0, 0, between(old, middle_x(old) + (x - middle_x(old)) / 1.001, y, c))
REDRAWN(resized_down, 0, 0, between(old, x, middle_y(old) + (y - middle_y(old)) / 1.001, c))
REDRAWN(resized_nearest, 0, 0,
        at(old, (int)lround(middle_x(old) + (x - middle_x(old)) / 1.003), y, c))
REDRAWN(shifted, 0, 0, at(old, x - 1, y, c))
REDRAWN(shifted_three, 0, 0, at(old, x + 3, y, c))
REDRAWN(shifted_half, 0, 0, between(old, x - 0.5, y, c))
REDRAWN(shifted_down, 0, 0, at(old, x, y - 1, c))
REDRAWN(mirrored, 0, 0, at(old, old->width - 1 - x, y, c))
REDRAWN(turned, 0, 0, at(old, old->width - 1 - x, old->height - 1 - y, c))
REDRAWN(flipped, 0, 0, at(old, x, old->height - 1 - y, c))
REDRAWN(like_jpeg, 0, 0, jpeg_like(old, x, y, c))
REDRAWN(seven_bits, 0, 0, 2 * floor(at(old, x, y, c) / 2))
REDRAWN(cropped, -1, 0, at(old, x, y, c))
REDRAWN(rows_lost, 0, -3, at(old, x, y, c))
REDRAWN(row_doubled, 0, 0, at(old, x, y > 40 ? y - 1 : y, c))
REDRAWN(row_inserted, 0, 1, at(old, x, y > 40 ? y - 1 : y, c))
REDRAWN(column_doubled, 0, 0, at(old, x > 400 ? x - 1 : x, y, c))
REDRAWN(sharpened, 0, 0,
        1.6 * at(old, x, y, c) - 0.3 * at(old, x - 1, y, c) - 0.3 * at(old, x + 1, y, c))
REDRAWN(blurred, 0, 0,
        0.5 * at(old, x, y, c) + 0.25 * at(old, x - 1, y, c) + 0.25 * at(old, x + 1, y, c))
REDRAWN(contrast, 0, 0, 127.5 + 1.15 * (at(old, x, y, c) - 127.5))
REDRAWN(brightened, 0, 0, brighter(at(old, x, y, c)))
REDRAWN(converted, 0, 0,
        0.8 * at(old, x, y, c) + 0.15 * at(old, x, y, (c + 1) % 3) +
            0.05 * at(old, x, y, (c + 2) % 3))
REDRAWN(noisy, 0, 0,
        at(old, x, y, c) + (int)((unsigned)(x * 7919 + y * 104729 + c * 31) * 2654435761u >> 30) -
            1)
REDRAWN(blank_bleed, 0, 0, x < 47 || x >= old->width - 47 ? 255 : at(old, x, y, c))
REDRAWN(no_marks, 0, 0, y < 100 ? 255 : at(old, x, y, c))
REDRAWN(half_bits, 0, 0, 257 * floor(at(old, x, y, c) / 257))

/* ------------------------------------------------------------ spoiling tags, bytes, manifest -- */

#define RESAVED(name, change)                                                                      \
    static void name(lf_checked *checked)                                                          \
    {                                                                                              \
        lf_saved saved;                                                                            \
        lf_saved_read(checked->tiff, &saved);                                                      \
        change;                                                                                    \
        lf_saved_write(&saved, checked->tiff);                                                     \
        lf_saved_finish(&saved);                                                                   \
    }

RESAVED(wrong_dpi, saved.dpi[0] = saved.dpi[1] = 300)
RESAVED(dpi_off, saved.dpi[0] = 599.9988)
RESAVED(in_centimetres, saved.unit = RESUNIT_CENTIMETER)
RESAVED(no_dpi, saved.unit = 0)
RESAVED(no_profile, (lf_free(saved.icc), saved.icc = NULL))
RESAVED(other_profile, ((uint8_t *)saved.icc)[saved.icc_size - 1] ^= 1)
RESAVED(broken_profile, memset(saved.icc, 0, 64))
RESAVED(orientation, saved.orientation = 6)
RESAVED(lossy, (saved.compression = COMPRESSION_JPEG, saved.photometric = PHOTOMETRIC_RGB))
RESAVED(other_compression, saved.compression = COMPRESSION_LZW)
RESAVED(nothing_kept, saved.compression = COMPRESSION_NONE)

static void alpha_added(lf_checked *checked)
{
    lf_saved old, out;
    lf_saved_read(checked->tiff, &old);
    out = old;
    out.samples = 4;
    out.extra = 1;
    out.data = lf_calloc((size_t)out.width * (size_t)out.height, 4);
    for (int y = 0; y < out.height; y++)
        for (int x = 0; x < out.width; x++)
            for (int c = 0; c < 4; c++)
                lf_saved_set(&out, x, y, c, c < 3 ? lf_saved_at(&old, x, y, c) : 255);
    lf_saved_write(&out, checked->tiff);
    lf_free(out.data);
    lf_saved_finish(&old);
}

static void eight_of_sixteen(lf_checked *checked)
{
    lf_saved old, out;
    lf_saved_read(checked->tiff, &old);
    out = old;
    out.bits = 8;
    out.data = lf_calloc((size_t)out.width * (size_t)out.height, 3);
    for (int y = 0; y < out.height; y++)
        for (int x = 0; x < out.width; x++)
            for (int c = 0; c < 3; c++)
                lf_saved_set(&out, x, y, c, lf_saved_at(&old, x, y, c) / 257.0);
    lf_saved_write(&out, checked->tiff);
    lf_free(out.data);
    lf_saved_finish(&old);
}

static void palette(lf_checked *checked)
{
    lf_saved old;
    uint16_t map[3][256];
    lf_saved_read(checked->tiff, &old);
    for (int i = 0; i < 256; i++)
        map[0][i] = map[1][i] = map[2][i] = (uint16_t)(257 * i);
    TIFF *tiff = TIFFOpen(checked->tiff, "w");
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)old.width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)old.height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE);
    TIFFSetField(tiff, TIFFTAG_COLORMAP, map[0], map[1], map[2]);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
    uint8_t *row = lf_calloc(1, (size_t)old.width);
    for (int y = 0; y < old.height; y++) {
        for (int x = 0; x < old.width; x++)
            row[x] = (uint8_t)lf_saved_at(&old, x, y, 1);
        assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)y, 0), 1);
    }
    lf_free(row);
    TIFFClose(tiff);
    lf_saved_finish(&old);
}

static void second_page(lf_checked *checked)
{
    const uint8_t row[3] = {1, 2, 3};
    TIFF *tiff = TIFFOpen(checked->tiff, "a");
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 1);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    assert_int_equal(TIFFWriteScanline(tiff, (void *)(uintptr_t)row, 0, 0), 1);
    TIFFClose(tiff);
}

static void truncated(lf_checked *checked)
{
    FILE *file = fopen(checked->tiff, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    assert_int_equal(truncate(checked->tiff, ftell(file) - 60000), 0);
    fclose(file);
}

/* In the middle of a row that was kept; rows begin behind the header. */
static void bit_flipped(lf_checked *checked)
{
    const long row = lf_print_witness_at(&checked->witness, 8),
               at = 8 + row * (long)checked->witness.row_bytes + 500;
    FILE *file = fopen(checked->tiff, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    const int byte = fgetc(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    fputc(byte ^ 1, file);
    fclose(file);
}

static void emptied(lf_checked *checked)
{
    assert_int_equal(truncate(checked->tiff, 0), 0);
}

/* Sets a member of the manifest; in both places if `also` names an option. */
static void edit_manifest(const lf_checked *checked, const char *part, const char *name,
                          const char *also, json_t *value)
{
    json_error_t json_error;
    json_t *root = json_load_file(checked->manifest, 0, &json_error);
    assert_non_null(root);
    if (also)
        json_object_set(json_object_get(root, "options"), also, value);
    if (value)
        json_object_set_new(json_object_get(root, part), name, value);
    else
        json_object_del(json_object_get(root, part), name);
    assert_int_equal(json_dump_file(root, checked->manifest, JSON_INDENT(2)), 0);
    json_decref(root);
}

static void manifest_pitch(lf_checked *checked)
{
    edit_manifest(checked, "lens", "lpi", NULL, json_real(60.14));
}

static void manifest_pitch_everywhere(lf_checked *checked)
{
    edit_manifest(checked, "lens", "lpi", "lpi", json_real(60.14));
    edit_manifest(checked, "lens", "pitch_mm", NULL, json_real(25.4 / 60.14));
}

static void manifest_slant(lf_checked *checked)
{
    edit_manifest(checked, "options", "slant", NULL, json_real(10.2));
}

static void manifest_distance(lf_checked *checked)
{
    edit_manifest(checked, "options", "distance", NULL, json_real(60));
}

static void manifest_phase(lf_checked *checked)
{
    edit_manifest(checked, "lens", "phase_mm", "phase", json_real(0.025));
}

static void manifest_views(lf_checked *checked)
{
    json_t *order = json_array();
    for (int view = 5; view >= 0; view--)
        json_array_append_new(order, json_integer(view));
    edit_manifest(checked, "stripes", "order", NULL, order);
    edit_manifest(checked, "stripes", "views", "views", json_integer(6));
}

static void manifest_order(lf_checked *checked)
{
    edit_manifest(checked, "stripes", "reverse", NULL, json_true());
}

static void manifest_incomplete(lf_checked *checked)
{
    edit_manifest(checked, "size", "trim_box_px", NULL, NULL);
}

static void manifest_gone(lf_checked *checked)
{
    assert_int_equal(unlink(checked->manifest), 0);
}

static void manifest_damaged(lf_checked *checked)
{
    assert_int_equal(truncate(checked->manifest, 300), 0);
}

static void copy_file(const char *from, const char *to)
{
    char *data = NULL;
    size_t size = 0;
    lf_error err;
    lf_assert_ok(lf_file_read(from, NULL, UINT32_MAX, &data, &size, &err), &err);
    FILE *file = fopen(to, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    fclose(file);
    lf_free(data);
}

/* Another print of the same size. */
static lf_checked other_print(const lf_checked *checked, bool reverse)
{
    lf_checked other;
    lf_print print = checked->print;
    if (reverse)
        print.reverse = !print.reverse;
    else
        print.lpi = 59.8;
    lf_checked_make(&print, lf_card_waves, false, &other);
    return other;
}

static void manifest_of_another(lf_checked *checked)
{
    lf_checked other = other_print(checked, false);
    copy_file(other.manifest, checked->manifest);
    lf_checked_finish(&other);
}

static void file_of_another(lf_checked *checked)
{
    lf_checked other = other_print(checked, false);
    copy_file(other.tiff, checked->tiff);
    lf_checked_finish(&other);
}

static void file_reversed(lf_checked *checked)
{
    lf_checked other = other_print(checked, true);
    copy_file(other.tiff, checked->tiff);
    lf_checked_finish(&other);
}

static void half_of_another(lf_checked *checked)
{
    lf_checked other = other_print(checked, false);
    lf_saved saved, rest;
    lf_saved_read(checked->tiff, &saved);
    lf_saved_read(other.tiff, &rest);
    for (int y = saved.height / 2; y < saved.height; y++)
        for (int x = 0; x < saved.width; x++)
            for (int c = 0; c < 3; c++)
                lf_saved_set(&saved, x, y, c, lf_saved_at(&rest, x, y, c));
    lf_saved_write(&saved, checked->tiff);
    lf_saved_finish(&saved);
    lf_saved_finish(&rest);
    lf_checked_finish(&other);
}

/* ------------------------------------------------------------------------------------- tests -- */

enum {
    SIZE = 1,
    RESOLUTION,
    RASTER,
    PROFILE,
    LOSSLESS,
    PITCH,
    PHASE,
    JITTER,
    ORDER,
    SHARE,
    RESAMPLED,
    VIEWS,
    DEPTH,
    EDGES,
    PDF,
    MANIFEST,
    SAME,
    STORED
};

/* clang-format off */
static const spoilt_case cases[] = {
    {"resized by 0.1 %", USUAL, resized, RESAMPLED, false},
    {"resized by 0.1 %, marks alone tell", MARKED, resized, PITCH, false},
    {"resized by 0.3 %, nearest pixel", NEAREST, resized_nearest, RESAMPLED, false},
    {"resized by 0.3 %, fractional, nearest pixel", USUAL, resized_nearest, RESAMPLED, false},
    {"horizontal, resized by 0.1 %", ACROSS, resized_down, RESAMPLED, false},
    {"16 bits, resized by 0.1 %", SIXTEEN, resized, RESAMPLED, false},
    {"shifted by a pixel", USUAL, shifted, PHASE, false},
    {"shifted by a pixel, nearest", NEAREST, shifted, PHASE, false},
    {"shifted by 3 pixels", USUAL, shifted_three, PHASE, false},
    {"shifted by a pixel, marks", MARKED, shifted, PHASE, false},
    {"shifted by half a pixel", USUAL, shifted_half, RESAMPLED, false},
    {"horizontal, shifted by a pixel", ACROSS, shifted_down, PHASE, false},
    {"mirrored", USUAL, mirrored, PHASE, false},
    {"turned by 180 degrees", USUAL, turned, PHASE, false},
    {"upside down", USUAL, flipped, 0, false},
    {"as by JPEG and back", USUAL, like_jpeg, RESAMPLED, false},
    {"as by JPEG and back, nearest", NEAREST, like_jpeg, RESAMPLED, false},
    {"8 to 7 bits", USUAL, seven_bits, RESAMPLED, false},
    {"8 of 16 bits", SIXTEEN, half_bits, RESAMPLED, false},
    {"stored with 8 bits", SIXTEEN, eight_of_sixteen, LOSSLESS, false},
    {"cropped by a column", USUAL, cropped, SIZE, false},
    {"rows lost", USUAL, rows_lost, SIZE, false},
    {"row inserted", USUAL, row_inserted, SIZE, false},
    {"row doubled", USUAL, row_doubled, 0, false},
    {"row doubled, marks", MARKED, row_doubled, EDGES, false},
    {"horizontal, row doubled", ACROSS, row_doubled, RESAMPLED, false},
    {"column doubled", USUAL, column_doubled, RESAMPLED, false},
    {"sharpened", USUAL, sharpened, RESAMPLED, false},
    {"sharpened, nearest", NEAREST, sharpened, RESAMPLED, false},
    {"blurred", USUAL, blurred, RESAMPLED, false},
    {"more contrast", USUAL, contrast, RESAMPLED, false},
    {"more contrast, nearest", NEAREST, contrast, 0, false},
    {"another gamma", USUAL, brightened, RESAMPLED, false},
    {"colours converted without a profile", USUAL, converted, RESAMPLED, false},
    {"noise of a step", USUAL, noisy, RESAMPLED, false},
    {"bleed blanked", BLED, blank_bleed, EDGES, false},
    {"marks removed", MARKED, no_marks, EDGES, false},
    {"300 dpi in the tags", USUAL, wrong_dpi, RESOLUTION, false},
    {"599.9988 dpi", USUAL, dpi_off, RESOLUTION, false},
    {"per centimetre", USUAL, in_centimetres, RESOLUTION, false},
    {"no resolution", USUAL, no_dpi, RESOLUTION, false},
    {"profile stripped", USUAL, no_profile, PROFILE, false},
    {"another profile", USUAL, other_profile, PROFILE, false},
    {"damaged profile", USUAL, broken_profile, PROFILE, false},
    {"orientation tag", USUAL, orientation, LOSSLESS, false},
    {"JPEG in the TIFF", USUAL, lossy, LOSSLESS, false},
    {"saved with LZW", USUAL, other_compression, LOSSLESS, false},
    {"saved without compression", PACKED, nothing_kept, LOSSLESS, false},
    {"alpha added", USUAL, alpha_added, LOSSLESS, false},
    {"palette", USUAL, palette, LOSSLESS, false},
    {"a second page", USUAL, second_page, LOSSLESS, false},
    {"truncated", USUAL, truncated, STORED, false},
    {"truncated, compressed", PACKED, truncated, STORED, false},
    {"empty", USUAL, emptied, STORED, false},
    {"a bit flipped in a kept row", USUAL, bit_flipped, 0, false},
    {"wrong pitch in the manifest", USUAL, manifest_pitch, MANIFEST, true},
    {"wrong pitch all over the manifest", USUAL, manifest_pitch_everywhere, PITCH, true},
    {"wrong pitch all over the manifest, marks", MARKED, manifest_pitch_everywhere, PITCH, true},
    {"phase off by 5 um", USUAL, manifest_phase, PHASE, true},
    {"phase off by 5 um, marks", MARKED, manifest_phase, PHASE, true},
    {"another slant", SLANTED, manifest_slant, RESAMPLED, true},
    {"slanted, shifted by a pixel", SLANTED, shifted, RESAMPLED, false},
    {"slanted, resized by 0.1 %", SLANTED, resized, RESAMPLED, false},
    {"another distance", EXACT, manifest_distance, RESAMPLED, true},
    {"exact, shifted by a pixel", EXACT, shifted, PHASE, false},
    {"another number of views", USUAL, manifest_views, RESAMPLED, true},
    {"order in the manifest", USUAL, manifest_order, MANIFEST, true},
    {"manifest incomplete", USUAL, manifest_incomplete, MANIFEST, true},
    {"no manifest", USUAL, manifest_gone, MANIFEST, true},
    {"manifest damaged", USUAL, manifest_damaged, MANIFEST, true},
    {"manifest of another print", USUAL, manifest_of_another, RESAMPLED, true},
    {"file of another print", USUAL, file_of_another, PITCH, false},
    {"half of another print", USUAL, half_of_another, RESAMPLED, false},
    {"file with reversed views", USUAL, file_reversed, 0, false},
};
/* clang-format on */

static void show(const spoilt_case *c, const lf_checked *checked, const char *how)
{
    char line[2048];
    print_message("%s (%s): %s\n", c->name, how,
                  lf_print_report_line(&checked->report, line, sizeof line));
}

/* The number of ways in which the checklist does not tell what it should. */
static int missed(const spoilt_case *c)
{
    const lf_print print = base_of(c->base);
    lf_checked checked;
    int n = 0;
    lf_checked_make(&print, lf_card_waves, false, &checked);
    c->spoil(&checked);
    if (!c->keeps_hash) {
        lf_checked_run(&checked, false);
        if (lf_checked_point(&checked, MANIFEST) != LF_CHECK_FAIL) {
            show(c, &checked, "as it is");
            n++;
        }
    }
    lf_checked_hash(&checked);
    lf_checked_run(&checked, false);
    if (c->point > 0 ? lf_checked_point(&checked, c->point) != LF_CHECK_FAIL
                     : lf_print_report_count(&checked.report, LF_CHECK_FAIL) > 0) {
        show(c, &checked, "SHA-256 set right");
        n++;
    }
    if (c->point == 0)
        lf_checked_run(&checked, true);
    if (c->point == 0 && (lf_checked_point(&checked, ORDER) != LF_CHECK_FAIL ||
                          lf_checked_point(&checked, SAME) != LF_CHECK_FAIL)) {
        show(c, &checked, "with its rows");
        n++;
    }
    lf_checked_finish(&checked);
    return n;
}

static void spoilt_prints_are_told(void **state)
{
    (void)state;
    int n = 0;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        n += missed(&cases[i]);
    assert_int_equal(n, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spoilt_prints_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
