/* Everything that a PNG can say of its picture: docs/reference/formats/images.md, row by row. */
#include <zlib.h>

#include "base/alloc.h"
#include "tests/base/icc_bytes.h"
#include "tests/base/image_metadata.h"
#include "tests/formats.h"

static char *folder;

static const char *file(void)
{
    return lf_test_path(folder, "a.png");
}

/* Pictures of 4 x 2, of rows alike. */
static void write_kind(int depth, int color, bool interlaced, const png_color_16 *clear,
                       const uint8_t *row)
{
    uint8_t rows[2][64];
    for (int y = 0; y < 2; y++)
        memcpy(rows[y], row, 64);
    lf_picture_png(file(), 4, 2, depth, color, interlaced, clear, &rows[0][0], 64);
}

static void expect(const uint8_t rgb[3], const char *told)
{
    lf_image_metadata meta;
    lf_image8 image = lf_codes_metadata(file(), &meta);
    lf_metadata_notes(&meta, told);
    assert_true(image.width == 4 && image.height == 2);
    assert_memory_equal(image.data, rgb, 3);
    assert_memory_equal(image.data + image.stride, rgb, 3);
    lf_image8_finish(&image);
}

/* A kind of pixels, and what the first becomes. */
typedef struct kind_case {
    int depth, color;
    bool interlaced, clears;
    uint8_t row[64];
    uint8_t rgb[3];
    const char *told;
} kind_case;

static void kind(const lf_format_row *row)
{
    const kind_case *c = row->with;
    const png_color_16 clear = {.gray = 7, .red = 1, .green = 2, .blue = 3};
    assert_int_equal(strcmp(row->verdict, "warned") == 0, !!c->told);
    write_kind(c->depth, c->color, c->interlaced, c->clears ? &clear : NULL, c->row);
    expect(c->rgb, c->told);
}

static const kind_case grey = {8, PNG_COLOR_TYPE_GRAY, false, false, {77}, {77, 77, 77}, NULL};
static const kind_case bits = {2, PNG_COLOR_TYPE_GRAY, false, false, {0x80}, {170, 170, 170}, NULL};
static const kind_case rgb = {8, PNG_COLOR_TYPE_RGB, false, false, {1, 2, 4}, {1, 2, 4}, NULL};
static const kind_case sixteen = {
    16, PNG_COLOR_TYPE_RGB, false, false, {1, 0, 2, 200, 4, 0}, {1, 3, 4}, NULL};
/* the first of four colours */
static const kind_case palette = {2, PNG_COLOR_TYPE_PALETTE, false, false, {0x00}, {1, 2, 3}, NULL};
static const kind_case passes = {8, PNG_COLOR_TYPE_RGB, true, false, {1, 2, 4}, {1, 2, 4}, NULL};
static const kind_case opaque = {8,
                                 PNG_COLOR_TYPE_RGBA,
                                 false,
                                 false,
                                 {1, 2, 4, 255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255},
                                 {1, 2, 4},
                                 NULL};
static const kind_case clear = {8,
                                PNG_COLOR_TYPE_RGBA,
                                false,
                                false,
                                {1, 2, 4, 9, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255},
                                {1, 2, 4},
                                "2 pixels are not opaque"};
static const kind_case keyed = {
    8,         PNG_COLOR_TYPE_RGB,       false, true, {1, 2, 3, 9, 9, 9, 9, 9, 9, 9, 9, 9},
    {1, 2, 3}, "2 pixels are not opaque"};

/* ------------------------------------------------------------------------------------ chunks -- */

static size_t put_chunk(uint8_t *to, const char *type, const void *data, size_t n)
{
    icc_put(to, (uint32_t)n);
    memcpy(to + 4, type, 4);
    memcpy(to + 8, data, n);
    icc_put(to + 8 + n, (uint32_t)crc32(0, to + 4, (uInt)n + 4));
    return n + 12;
}

/* A picture of one colour with this chunk behind its header. */
static void write_chunks(const char *const *types, const void *const *data, const size_t *sizes,
                         int count)
{
    static uint8_t whole[1 << 16];
    const uint8_t row[64] = {1, 2, 4, 1, 2, 4, 1, 2, 4, 1, 2, 4};
    size_t n;
    write_kind(8, PNG_COLOR_TYPE_RGB, false, NULL, row);
    char *plain = lf_picture_bytes(file(), &n);
    memcpy(whole, plain, 33);
    size_t at = 33;
    for (int i = 0; i < count; i++)
        at += put_chunk(whole + at, types[i], data[i], sizes[i]);
    memcpy(whole + at, plain + 33, n - 33);
    lf_picture_write(file(), whole, at + n - 33);
    lf_free(plain);
}

static void write_chunk(const char *type, const void *data, size_t n)
{
    write_chunks(&type, &data, &n, 1);
}

typedef struct chunk_case {
    const void *data;
    size_t n;
    const char *told;
    const char *type; /* NULL: the row's name */
} chunk_case;

static const uint8_t codes[3] = {1, 2, 4};

static void chunk(const lf_format_row *row)
{
    const chunk_case *c = row->with;
    assert_int_equal(strcmp(row->verdict, "warned") == 0, !!c->told);
    write_chunk(c->type ? c->type : row->name, c->data, c->n);
    expect(codes, c->told);
}

static void expect_said(double pixel_aspect, int orientation)
{
    lf_image_metadata meta;
    lf_image8 image = lf_codes_metadata(file(), &meta);
    lf_metadata_is(&meta, pixel_aspect, orientation);
    lf_image8_finish(&image);
}

/* tests/base/test_image_orientation.c looks at the pixels */
static void orientation(const lf_format_row *row)
{
    const chunk_case *c = row->with;
    write_chunk(c->type, c->data, c->n);
    expect_said(0, 6);
}

static void oblong_pixels(const lf_format_row *row)
{
    chunk(row);
    expect_said(2, 0);
}

#define BYTES(...)                                                                                 \
    (const uint8_t[]){__VA_ARGS__}, sizeof(const uint8_t[])                                        \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
#define BE(x) (uint8_t)((x) >> 24), (uint8_t)((x) >> 16), (uint8_t)((x) >> 8), (uint8_t)(x)

static const chunk_case srgb = {BYTES(0), NULL, NULL};
static const chunk_case gamma_usual = {BYTES(BE(45455)), NULL, "gAMA"};
static const chunk_case gamma_other = {BYTES(BE(100000)), "gAMA 1 is not applied", "gAMA"};
static const chunk_case chrm_usual = {
    BYTES(BE(31270), BE(32900), BE(64000), BE(33000), BE(30000), BE(60000), BE(15000), BE(6000)),
    NULL, "cHRM"};
static const chunk_case chrm_other = {
    BYTES(BE(31270), BE(32900), BE(64000), BE(33000), BE(21000), BE(71000), BE(15000), BE(6000)),
    "cHRM", "cHRM"};
static const chunk_case cicp_usual = {BYTES(1, 13, 0, 1), NULL, "cICP"};
static const chunk_case cicp_other = {BYTES(9, 16, 0, 1), "cICP 9/16/0/1", "cICP"};
static const chunk_case upright = {
    BYTES('I', 'I', '*', 0, 8, 0, 0, 0, 1, 0, 0x12, 1, 3, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0),
    NULL, "eXIf"};
static const chunk_case turned = {
    BYTES('M', 'M', 0, '*', 0, 0, 0, 8, 0, 1, 1, 0x12, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0),
    NULL, "eXIf"};
static const chunk_case odd = {
    BYTES('M', 'M', 0, '*', 0, 0, 0, 8, 0, 1, 1, 0x12, 0, 3, 0, 0, 0, 1, 0, 9, 0, 0, 0, 0, 0, 0),
    "unknown EXIF orientation 9", "eXIf"};
static const chunk_case no_exif = {BYTES('M', 'M', 0, '*', 0, 0, 0, 99), "the EXIF data is damaged",
                                   "eXIf"};
/* a folder of one entry that leads to another of one */
static const chunk_case adobe_rgb = {BYTES('M', 'M', 0, '*', 0, 0, 0, 8, 0, 1, 0x87, 0x69, 0, 4, 0,
                                           0, 0, 1, BE(26), BE(0), 0, 1, 0xa0, 1, 0, 3, 0, 0, 0, 1,
                                           0, 2, 0, 0, BE(0)),
                                     "EXIF colour space 2 (Adobe RGB)", "eXIf"};
static const chunk_case oblong = {BYTES(BE(100), BE(200), 0), NULL, NULL};
static const chunk_case sliver = {BYTES(BE(0), BE(200), 0),
                                  "pHYs is not a valid pixel aspect ratio", "pHYs"};
static const chunk_case no_shape = {BYTES(BE(0), BE(0), 0), NULL, "pHYs"};
static const chunk_case animation = {BYTES(BE(5), BE(0)), "animation of 5 frames", NULL};
static const chunk_case stereo = {BYTES(0), "side by side", NULL};
static const chunk_case calibration = {BYTES('x', 0, BE(0), BE(255), 0, 2, 'm', 0, '0', 0, '1'),
                                       "pCAL", NULL};
static const chunk_case significant = {BYTES(5, 6, 5), NULL, NULL};
static const chunk_case background = {BYTES(0, 9, 0, 9, 0, 9), NULL, NULL};
static const chunk_case when = {BYTES(2026 >> 8, 2026 & 255, 11, 28, 10, 0, 0), NULL, NULL};
static const chunk_case words = {BYTES('T', 'i', 't', 'l', 'e', 0, 'x'), NULL, NULL};
static const chunk_case other_words = {BYTES('T', 0, 0, 0, 0, 0, 'x'), NULL, NULL};
static const chunk_case offset = {BYTES(BE(10), BE(10), 0), NULL, NULL};
static const chunk_case scale = {BYTES(1, '1', 0, '1'), NULL, NULL};
static const chunk_case suggested = {BYTES('p', 0, 8, 1, 2, 3, 255, 0, 1), NULL, NULL};
static const chunk_case light_level = {BYTES(BE(10000000), BE(4000000)), NULL, NULL};
static const chunk_case mastering = {BYTES(0x8a, 0x48, 0x39, 8, 0x21, 0x34, 0x9b, 0xaa, 0x19, 0x96,
                                           8, 0xfc, 0x3d, 0x13, 0x40, 0x42, BE(10000000), BE(1)),
                                     NULL, NULL};
static const chunk_case histogram = {BYTES(0, 1, 0, 2), NULL, NULL};
static const chunk_case foreign_bytes = {BYTES(1, 2, 3, 4), NULL, NULL};
static const chunk_case foreign = {BYTES(1, 2, 3), NULL, "prVt"};

static void icc(bool srgb_profile, const char *told)
{
    uint8_t profile[ICC_BYTES], packed[1024] = "name";
    size_t n = icc_make(profile, srgb_profile);
    uLongf length = sizeof packed - 6;
    assert_int_equal(compress(packed + 6, &length, profile, (uLong)n), Z_OK);
    write_chunk("iCCP", packed, 6 + length);
    expect(codes, told);
}

static void icc_usual(const lf_format_row *row)
{
    (void)row;
    icc(true, NULL);
}

static void icc_other(const lf_format_row *row)
{
    (void)row;
    icc(false, "the ICC profile (iCCP) is not applied");
}

/* The strongest alone counts. */
static void outdone(const lf_format_row *row)
{
    (void)row;
    const uint8_t gamma[4] = {BE(100000)}, perceptual[1] = {0}, cicp[4] = {1, 13, 0, 1};
    const char *const a[] = {"sRGB", "gAMA"}, *const b[] = {"cICP", "gAMA"};
    const void *const with_srgb[] = {perceptual, gamma}, *const with_cicp[] = {cicp, gamma};
    write_chunks(a, with_srgb, (const size_t[]){1, 4}, 2);
    expect(codes, NULL);
    write_chunks(b, with_cicp, (const size_t[]){4, 4}, 2);
    expect(codes, NULL);
}

static void critical(const lf_format_row *row)
{
    (void)row;
    write_chunk("CgBI", "\1\2\3\4", 4);
    lf_picture_refused(file(), "PNG");
}

static const lf_format_row rows[] = {
    {"greyscale", "used", kind, &grey},
    {"1, 2 and 4 bits", "used", kind, &bits},
    {"truecolour", "used", kind, &rgb},
    {"16 bits", "used", kind, &sixteen},
    {"PLTE", "used", kind, &palette},
    {"interlace", "used", kind, &passes},
    {"alpha of opaque pixels", "ignored", kind, &opaque},
    {"alpha", "warned", kind, &clear},
    {"tRNS", "warned", kind, &keyed},
    {"sRGB", "used", chunk, &srgb},
    {"gAMA of 1/2.2", "ignored", chunk, &gamma_usual},
    {"gAMA", "warned", chunk, &gamma_other},
    {"cHRM of Rec. 709", "ignored", chunk, &chrm_usual},
    {"cHRM", "warned", chunk, &chrm_other},
    {"iCCP of sRGB", "used", icc_usual, NULL},
    {"iCCP", "warned", icc_other, NULL},
    {"cICP 1/13/0/1", "used", chunk, &cicp_usual},
    {"cICP", "warned", chunk, &cicp_other},
    {"one of these beside a stronger", "ignored", outdone, NULL},
    {"eXIf of an upright picture", "ignored", chunk, &upright},
    {"eXIf orientation", "used", orientation, &turned},
    {"eXIf orientation above 8", "warned", chunk, &odd},
    {"eXIf that is broken", "warned", chunk, &no_exif},
    {"eXIf colour space", "warned", chunk, &adobe_rgb},
    {"pHYs", "used", oblong_pixels, &oblong},
    {"pHYs beyond 1:100", "warned", chunk, &sliver},
    {"pHYs of zeros", "ignored", chunk, &no_shape},
    {"acTL", "warned", chunk, &animation},
    {"sTER", "warned", chunk, &stereo},
    {"pCAL", "warned", chunk, &calibration},
    {"mDCV", "ignored", chunk, &mastering},
    {"cLLI", "ignored", chunk, &light_level},
    {"sBIT", "ignored", chunk, &significant},
    {"bKGD", "ignored", chunk, &background},
    {"hIST", "ignored", chunk, &histogram},
    {"sPLT", "ignored", chunk, &suggested},
    {"dSIG", "ignored", chunk, &foreign_bytes},
    {"gIFg", "ignored", chunk, &foreign_bytes},
    {"gIFx", "ignored", chunk, &foreign_bytes},
    {"tIME", "ignored", chunk, &when},
    {"tEXt", "ignored", chunk, &words},
    {"zTXt", "ignored", chunk, &other_words},
    {"iTXt", "ignored", chunk, &other_words},
    {"oFFs", "ignored", chunk, &offset},
    {"sCAL", "ignored", chunk, &scale},
    {"other chunks", "ignored", chunk, &foreign},
    {"other critical chunks", "refused", critical, NULL},
};

static void what_a_png_says(void **state)
{
    folder = *state;
    lf_formats_walk("images.md", "PNG", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_a_png_says)};
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
