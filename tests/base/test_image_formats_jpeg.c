/* Everything that a JPEG can say of its picture: docs/reference/formats/images.md, row by row. */
#include "base/alloc.h"
#include "tests/base/icc_bytes.h"
#include "tests/base/image_metadata.h"
#include "tests/formats.h"

static char *folder;

static const char *file(void)
{
    return lf_test_path(folder, "a.jpg");
}

/* How a picture of 16 x 16 of one colour is coded, and what it becomes. */
typedef struct coding {
    int components;
    J_COLOR_SPACE in, coded;
    uint8_t from[4], rgb[3];
    bool progressive, arithmetic, subsampled, no_adobe;
    int restart;
} coding;

static void write_coding(const coding *c)
{
    FILE *out = fopen(file(), "wb");
    assert_non_null(out);
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr manager;
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, out);
    jpeg.image_width = jpeg.image_height = 16;
    jpeg.input_components = c->components;
    jpeg.in_color_space = c->in;
    jpeg_set_defaults(&jpeg);
    jpeg_set_colorspace(&jpeg, c->coded);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg.arith_code = c->arithmetic;
    jpeg.restart_interval = (unsigned)c->restart;
    if (!c->subsampled)
        jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    if (c->no_adobe)
        jpeg.write_Adobe_marker = FALSE;
    if (c->progressive)
        jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    uint8_t row[64];
    for (int i = 0; i < 16 * c->components; i++)
        row[i] = c->from[i % c->components];
    for (int y = 0; y < 16; y++)
        jpeg_write_scanlines(&jpeg, (JSAMPROW[]){row}, 1);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_int_equal(fclose(out), 0);
}

static void expect(const uint8_t rgb[3], const char *told)
{
    lf_image_metadata meta;
    lf_image8 image = lf_codes_metadata(file(), &meta);
    lf_metadata_notes(&meta, told);
    assert_true(image.width == 16 && image.height == 16);
    for (int i = 0; i < 3; i++)
        for (int at = i; at < 16 * 16 * 3; at += 3)
            assert_in_range(image.data[at], rgb[i] > 1 ? rgb[i] - 2 : 0, rgb[i] + 2);
    lf_image8_finish(&image);
}

static void code(const lf_format_row *row)
{
    const coding *c = row->with;
    write_coding(c);
    expect(c->rgb, NULL);
}

#define COLOUR                                                                                     \
    {200, 60, 30},                                                                                 \
    {                                                                                              \
        200, 60, 30                                                                                \
    }
static const coding grey = {1, JCS_GRAYSCALE, JCS_GRAYSCALE, {90}, {90, 90, 90}, .no_adobe = true};
static const coding ycc = {3, JCS_RGB, JCS_YCbCr, COLOUR, .subsampled = true};
static const coding rgb = {3, JCS_RGB, JCS_RGB, COLOUR, .restart = 0};
static const coding progressive = {3, JCS_RGB, JCS_YCbCr, COLOUR, .progressive = true};
static const coding arithmetic = {3, JCS_RGB, JCS_YCbCr, COLOUR, .arithmetic = true};
static const coding restarts = {3, JCS_RGB, JCS_YCbCr, COLOUR, .restart = 1};
/* 255 is no ink: 220 * 200 / 255, 100 * 200 / 255, 30 * 200 / 255 */
static const coding cmyk = {4,           JCS_CMYK, JCS_CMYK, {220, 100, 30, 200}, {173, 78, 24},
                            .restart = 0};
static const coding ycck = {4,           JCS_CMYK, JCS_YCCK, {220, 100, 30, 200}, {173, 78, 24},
                            .restart = 0};
/* 255 is all ink: 35 * 55 / 255, 155 * 55 / 255, 225 * 55 / 255 */
static const coding plain_cmyk = {4,           JCS_CMYK,        JCS_CMYK, {220, 100, 30, 200},
                                  {8, 33, 49}, .no_adobe = true};

/* ----------------------------------------------------------------------------------- markers -- */

/* The picture with another segment behind its beginning. */
static void insert(int marker, const void *data, size_t n)
{
    static uint8_t whole[1 << 16];
    size_t size;
    write_coding(&ycc);
    char *plain = lf_picture_bytes(file(), &size);
    memcpy(whole, plain, 2);
    whole[2] = 0xff;
    whole[3] = (uint8_t)marker;
    whole[4] = (uint8_t)((n + 2) >> 8);
    whole[5] = (uint8_t)(n + 2);
    memcpy(whole + 6, data, n);
    memcpy(whole + 6 + n, plain + 2, size - 2);
    lf_picture_write(file(), whole, size + n + 4);
    lf_free(plain);
}

typedef struct segment {
    int marker;
    const char *data;
    size_t n;
    const char *told;
} segment;

static void marker(const lf_format_row *row)
{
    const segment *s = row->with;
    assert_int_equal(strcmp(row->verdict, "warned") == 0, !!s->told);
    insert(s->marker, s->data, s->n);
    expect(ycc.rgb, s->told);
}

#define SEGMENT(marker, text, told)                                                                \
    {                                                                                              \
        marker, text, sizeof(text) - 1, told                                                       \
    }
#define TIFF_OF(tag, value) "II*\0\x8\0\0\0\1\0" tag "\3\0\1\0\0\0" value "\0\0\0\0\0\0\0"
static const segment upright = SEGMENT(0xe1, "Exif\0\0" TIFF_OF("\x12\1", "\1"), NULL);
static const segment turned = SEGMENT(0xe1, "Exif\0\0" TIFF_OF("\x12\1", "\6"), NULL);
static const segment odd =
    SEGMENT(0xe1, "Exif\0\0" TIFF_OF("\x12\1", "\x9"), "EXIF orientation 9 is unknown");
static const segment no_exif = SEGMENT(0xe1, "Exif\0\0II*\0\xff\0\0\0", "the EXIF is broken");
/* a folder of one entry that leads to another of one */
static const segment adobe_rgb =
    SEGMENT(0xe1,
            "Exif\0\0II*\0\x8\0\0\0\1\0\x69\x87\4\0\1\0\0\0\x1a\0\0\0\0\0\0\0\1\0\1\xa0\3\0\1\0\0\0"
            "\2\0\0\0\0\0\0\0",
            "EXIF colour space 2 (Adobe RGB)");
static const segment xmp = SEGMENT(0xe1, "http://ns.adobe.com/xap/1.0/\0<x/>", NULL);
static const segment mpf = SEGMENT(0xe2, "MPF\0II*\0\x8\0\0\0", "further pictures");
static const segment jfxx = SEGMENT(0xe0, "JFXX\0\x13\1\1\1\2\3", NULL);
static const segment photoshop = SEGMENT(0xed, "Photoshop 3.0\0", NULL);
static const segment comment = SEGMENT(0xfe, "words", NULL);
static const segment other = SEGMENT(0xe5, "whatever", NULL);

static void icc(bool srgb, const char *told)
{
    uint8_t segment_bytes[14 + ICC_BYTES] = "ICC_PROFILE\0\1\1";
    size_t n = icc_make(segment_bytes + 14, srgb);
    insert(0xe2, segment_bytes, 14 + n);
    expect(ycc.rgb, told);
}

static void icc_usual(const lf_format_row *row)
{
    (void)row;
    icc(true, NULL);
}

static void icc_other(const lf_format_row *row)
{
    (void)row;
    icc(false, "the ICC profile is not applied");
}

/* Changes the picture's bytes at a distance behind a marker. */
static void patch(int after, size_t distance, const char *bytes, size_t n)
{
    size_t size, at = 2;
    write_coding(&ycc);
    char *data = lf_picture_bytes(file(), &size);
    while ((uint8_t)data[at + 1] != after)
        at += 2 + ((size_t)(uint8_t)data[at + 2] << 8 | (uint8_t)data[at + 3]);
    memcpy(data + at + distance, bytes, n);
    lf_picture_write(file(), data, size);
    lf_free(data);
}

static void expect_said(double pixel_aspect, int orientation)
{
    lf_image_metadata meta;
    lf_image8 image = lf_codes_metadata(file(), &meta);
    lf_metadata_notes(&meta, NULL);
    lf_metadata_is(&meta, pixel_aspect, orientation);
    lf_image8_finish(&image);
}

static void density(const lf_format_row *row)
{
    (void)row;
    patch(0xe0, 12, "\0\1\0\2", 4);
    expect_said(2, 0);
}

static void no_density(const lf_format_row *row)
{
    (void)row;
    patch(0xe0, 12, "\0\1\2\0", 4);
    expect(ycc.rgb, "the density is no shape of pixels");
}

/* tests/base/test_image_orientation.c looks at the pixels */
static void orientation(const lf_format_row *row)
{
    marker(row);
    expect_said(0, 6);
}

static void square_density(const lf_format_row *row)
{
    (void)row;
    patch(0xe0, 12, "\0\x48\0\x48", 4);
    expect(ycc.rgb, NULL);
}

static void deep(const lf_format_row *row)
{
    (void)row;
    patch(0xc0, 4, "\x0c", 1);
    lf_picture_refused(file(), "JPEG");
}

static void lossless(const lf_format_row *row)
{
    (void)row;
    for (int kind = 0xc3; kind <= 0xcf; kind += 4) {
        const char marker[2] = {'\xff', (char)kind};
        patch(0xc0, 0, marker, 2);
        lf_picture_refused(file(), "JPEG");
    }
}

static void no_height(const lf_format_row *row)
{
    (void)row;
    patch(0xc0, 5, "\0\0", 2);
    lf_picture_refused(file(), "JPEG");
}

static void two_components(const lf_format_row *row)
{
    (void)row;
    lf_picture_jpeg(file(), 16, 16, 2, JCS_UNKNOWN);
    lf_picture_refused(file(), "2 components (expected grey, RGB or CMYK)");
}

static const lf_format_row rows[] = {
    {"greyscale", "used", code, &grey},
    {"YCbCr and subsampling", "used", code, &ycc},
    {"RGB", "used", code, &rgb},
    {"CMYK with Adobe's marker", "used", code, &cmyk},
    {"YCCK with Adobe's marker", "used", code, &ycck},
    {"CMYK without Adobe's marker", "used", code, &plain_cmyk},
    {"other numbers of components", "refused", two_components, NULL},
    {"SOF0, SOF1", "used", code, &ycc},
    {"SOF2", "used", code, &progressive},
    {"SOF9", "used", code, &arithmetic},
    {"SOF3, SOF7, SOF11, SOF15", "refused", lossless, NULL},
    {"12 bits", "refused", deep, NULL},
    {"DRI", "used", code, &restarts},
    {"DNL", "refused", no_height, NULL},
    {"JFIF density of square pixels", "ignored", square_density, NULL},
    {"JFIF density", "used", density, NULL},
    {"JFIF density beyond 1:100", "warned", no_density, NULL},
    {"JFXX", "ignored", marker, &jfxx},
    {"EXIF of an upright picture", "ignored", marker, &upright},
    {"EXIF orientation", "used", orientation, &turned},
    {"EXIF orientation above 8", "warned", marker, &odd},
    {"EXIF that is broken", "warned", marker, &no_exif},
    {"EXIF colour space", "warned", marker, &adobe_rgb},
    {"XMP", "ignored", marker, &xmp},
    {"ICC_PROFILE of sRGB", "used", icc_usual, NULL},
    {"ICC_PROFILE", "warned", icc_other, NULL},
    {"MPF", "warned", marker, &mpf},
    {"Photoshop", "ignored", marker, &photoshop},
    {"COM", "ignored", marker, &comment},
    {"other APPn", "ignored", marker, &other},
};

static void what_a_jpeg_says(void **state)
{
    folder = *state;
    lf_formats_walk("images.md", "JPEG", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_a_jpeg_says)};
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
