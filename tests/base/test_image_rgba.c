/* Pictures that lie on surfaces, out of files in memory. */
#include "tests/base/pictures.h"

#include <webp/encode.h>
#include <zlib.h>

#include "base/alloc.h"
#include "base/image_rgba.h"

typedef struct picture {
    uint8_t *rgba;
    int width, height;
} picture;

static picture decode(const void *data, size_t n)
{
    picture p = {0};
    lf_error err;
    lf_assert_ok(lf_image_rgba_decode(data, n, "a picture", &p.rgba, &p.width, &p.height, &err),
                 &err);
    return p;
}

static picture decode_file(const char *path)
{
    size_t n;
    char *data = lf_picture_bytes(path, &n);
    picture p = decode(data, n);
    lf_free(data);
    return p;
}

static void refuse(const void *data, size_t n, const char *what)
{
    picture p = {0};
    lf_error err = {0};
    lf_assert_status(lf_image_rgba_decode(data, n, "a picture", &p.rgba, &p.width, &p.height, &err),
                     LF_E_FORMAT, &err);
    assert_true(!p.rgba && !p.width && !p.height);
    assert_string_equal(err.where, "a picture");
    if (!strstr(err.what, what))
        fail_msg("\"%s\" does not say \"%s\"", err.what, what);
}

/* Rows of 8 pixels, each row the same. */
static void assert_row(const picture *p, int y, const uint8_t *expected, int n)
{
    for (int x = 0; x < p->width; x++)
        assert_memory_equal(p->rgba + 4 * (size_t)(y * p->width + x), expected + 4 * (x % n), 4);
}

static void palettes_and_greys_keep_what_is_clear(void **state)
{
    const char *path = lf_test_path(*state, "kind.png");
    const png_color_16 clear = {.gray = 2};
    uint8_t rows[8][64];
    for (int interlaced = 0; interlaced < 2; interlaced++) {
        memset(rows, 0x1b, sizeof rows); /* 0 1 2 3 of two bits */
        lf_picture_png(path, 8, 8, 2, PNG_COLOR_TYPE_PALETTE, interlaced, NULL, &rows[0][0], 64);
        picture p = decode_file(path);
        assert_true(p.width == 8 && p.height == 8);
        assert_row(&p, 3, (uint8_t[]){1, 2, 3, 255, 50, 60, 70, 0, 255, 0, 128, 7, 9, 9, 9, 255},
                   4);
        lf_free(p.rgba);
        lf_picture_png(path, 8, 8, 2, PNG_COLOR_TYPE_GRAY, interlaced, &clear, &rows[0][0], 64);
        p = decode_file(path);
        assert_row(&p, 7,
                   (uint8_t[]){0, 0, 0, 255, 85, 85, 85, 255, 170, 170, 170, 0, 255, 255, 255, 255},
                   4);
        lf_free(p.rgba);
    }
}

static void sixteen_bits_are_rounded_and_alpha_multiplies_nothing(void **state)
{
    const char *path = lf_test_path(*state, "deep.png");
    const uint16_t samples[4] = {0x0180, 0x7fff, 0xff7f, 0x1234};
    uint8_t rows[1][64], expected[4];
    for (int x = 0; x < 8; x++)
        for (int c = 0; c < 4; c++) {
            rows[0][x * 8 + c * 2] = (uint8_t)(samples[c] >> 8);
            rows[0][x * 8 + c * 2 + 1] = (uint8_t)samples[c];
            expected[c] = (uint8_t)floor(samples[c] / 257.0 + 0.5);
        }
    lf_picture_png(path, 8, 1, 16, PNG_COLOR_TYPE_RGBA, false, NULL, &rows[0][0], 64);
    picture p = decode_file(path);
    assert_row(&p, 0, expected, 1);
    lf_free(p.rgba);
    /* grey and alpha, and colours of which one is clear */
    lf_picture_png(path, 8, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA, false, NULL,
                   (uint8_t[]){9, 1, 9, 1, 9, 1, 9, 1, 9, 1, 9, 1, 9, 1, 9, 1}, 16);
    p = decode_file(path);
    assert_row(&p, 0, (uint8_t[]){9, 9, 9, 1}, 1);
    lf_free(p.rgba);
    lf_picture_png(path, 2, 1, 8, PNG_COLOR_TYPE_RGB, false,
                   &(png_color_16){.red = 4, .green = 5, .blue = 6}, (uint8_t[]){1, 2, 3, 4, 5, 6},
                   6);
    p = decode_file(path);
    assert_row(&p, 0, (uint8_t[]){1, 2, 3, 255, 4, 5, 6, 0}, 2);
    lf_free(p.rgba);
}

/* What a gAMA chunk says of them changes no number. */
static void numbers_stay_as_they_are_whatever_gamma_a_file_tells(void **state)
{
    const char *path = lf_test_path(*state, "gamma.png");
    FILE *file = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    assert_non_null(file);
    png_init_io(png, file);
    png_set_IHDR(png, info, 1, 1, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_gAMA(png, info, 1.0);
    png_write_info(png, info);
    png_write_row(png, (uint8_t[]){40, 80, 160});
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
    picture p = decode_file(path);
    assert_row(&p, 0, (uint8_t[]){40, 80, 160, 255}, 1);
    lf_free(p.rgba);
}

static void a_jpeg_is_covered_everywhere(void **state)
{
    const char *path = lf_test_path(*state, "a.jpg");
    for (int components = 1; components <= 3; components += 2) {
        lf_picture_jpeg(path, 90, 70, components, components == 1 ? JCS_GRAYSCALE : JCS_RGB);
        picture p = decode_file(path);
        lf_image8 same = lf_picture_load8(path);
        assert_true(p.width == 90 && p.height == 70);
        for (int i = 0; i < 90 * 70; i++) {
            assert_memory_equal(p.rgba + 4 * i, same.data + 3 * i, 3);
            assert_int_equal(p.rgba[4 * i + 3], 255);
        }
        lf_image8_finish(&same);
        lf_free(p.rgba);
    }
}

static void a_webp_comes_back_as_it_was(void **state)
{
    (void)state;
    enum { W = 31, H = 17 };
    uint8_t rgba[W * H * 4], *file;
    uint64_t seed = 3;
    for (size_t i = 0; i < sizeof rgba; i++)
        rgba[i] = i % 4 == 3 ? 200 : (uint8_t)lf_picture_random(&seed);
    size_t n = WebPEncodeLosslessRGBA(rgba, W, H, 4 * W, &file);
    picture p = decode(file, n);
    assert_true(p.width == W && p.height == H);
    assert_memory_equal(p.rgba, rgba, sizeof rgba);
    lf_free(p.rgba);
    for (size_t cut = 12; cut < n; cut += 7)
        refuse(file, cut, "WebP: the file is damaged or cut off");
    WebPFree(file);
    n = WebPEncodeRGB(rgba, W, H, 3 * W, 90, &file);
    p = decode(file, n);
    assert_true(p.width == W && p.height == H && p.rgba[3] == 255);
    lf_free(p.rgba);
    WebPFree(file);
}

static void what_is_cut_off_is_refused_wherever(void **state)
{
    static const char *const names[] = {"cut.png", "cut.jpg"};
    lf_image8 image = lf_picture_noise(40, 30);
    lf_picture_save_png(lf_test_path(*state, names[0]), &image, 6, NULL, 0);
    lf_picture_jpeg(lf_test_path(*state, names[1]), 40, 30, 3, JCS_RGB);
    lf_image8_finish(&image);
    for (size_t i = 0; i < 2; i++) {
        size_t n;
        char *data = lf_picture_bytes(lf_test_path(*state, names[i]), &n);
        for (size_t cut = 0; cut + 16 < n; cut += 11) {
            char *exact = malloc(cut + 1); /* so that a sanitizer sees what is read behind it */
            assert_non_null(exact);
            memcpy(exact, data, cut);
            refuse(exact, cut, "");
            free(exact);
        }
        lf_free(data);
    }
}

/* A header that promises more pixels than there may be, or than so few bytes hold. */
static void sizes_that_are_lies_are_refused(void **state)
{
    const char *path = lf_test_path(*state, "size.png");
    lf_image8 image = lf_picture_noise(3, 2);
    size_t n;
    lf_picture_save_png(path, &image, 6, NULL, 0);
    lf_image8_finish(&image);
    char *data = lf_picture_bytes(path, &n);
    static const struct {
        uint32_t width, height;
        const char *what;
    } cases[] = {
        {0, 2, "PNG"}, {70000, 2, "PNG"}, {65536, 65536, "at most"}, {20000, 20000, "do not fit"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const uint32_t size[2] = {__builtin_bswap32(cases[i].width),
                                  __builtin_bswap32(cases[i].height)};
        memcpy(data + 16, size, 8);
        const uint32_t sum =
            __builtin_bswap32((uint32_t)crc32(0, (const unsigned char *)data + 12, 17));
        memcpy(data + 29, &sum, 4);
        refuse(data, n, cases[i].what);
    }
    lf_free(data);
}

/* A WebP's are 28 bits behind its signature. */
static void a_webp_of_a_few_bytes_asks_for_no_gigabyte(void **state)
{
    (void)state;
    const uint32_t size = 16382u | 16382u << 14;
    uint8_t *file;
    size_t n = WebPEncodeLosslessRGB((uint8_t[]){1, 2, 3}, 1, 1, 3, &file);
    assert_true(n > 25 && memcmp(file + 12, "VP8L", 4) == 0 && file[20] == 0x2f);
    memcpy(file + 21, &size, 4);
    refuse(file, n, "16383x16383 pixels do not fit into a file of");
    WebPFree(file);
}

static void other_files_are_named_or_said_to_be_none(void **state)
{
    (void)state;
    static const char ktx2[] = "\xabKTX 20\xbb\r\n\x1a\nand more";
    refuse(ktx2, sizeof ktx2 - 1, "KTX2 images are not supported");
    refuse("", 0, "not an image; expected PNG, JPEG or WebP");
    refuse("BM and a bitmap", 15, "not an image");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(palettes_and_greys_keep_what_is_clear),
        cmocka_unit_test(sixteen_bits_are_rounded_and_alpha_multiplies_nothing),
        cmocka_unit_test(numbers_stay_as_they_are_whatever_gamma_a_file_tells),
        cmocka_unit_test(a_jpeg_is_covered_everywhere),
        cmocka_unit_test(a_webp_comes_back_as_it_was),
        cmocka_unit_test(what_is_cut_off_is_refused_wherever),
        cmocka_unit_test(sizes_that_are_lies_are_refused),
        cmocka_unit_test(a_webp_of_a_few_bytes_asks_for_no_gigabyte),
        cmocka_unit_test(other_files_are_named_or_said_to_be_none),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
