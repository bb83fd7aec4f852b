/* EXIF's orientations: whichever of the eight ways a picture is stored in, it is read the same way
 * up. The stored pixels are made by the words of EXIF (which visual sides row 0 and column 0 are),
 * not by turning. */
#include <zlib.h>

#include "base/alloc.h"
#include "base/image_rgba.h"
#include "tests/base/image_metadata.h"

enum { WIDTH = 24, HEIGHT = 16, BLOCK = 8 };

static char *folder;

/* Of the picture the right way up: 3 x 2 blocks, no two alike. */
static const uint8_t colours[2][3][3] = {{{250, 10, 10}, {10, 250, 10}, {10, 10, 250}},
                                         {{240, 240, 20}, {20, 240, 240}, {120, 120, 120}}};

static const uint8_t *colour_at(int x, int y)
{
    return colours[y / BLOCK][x / BLOCK];
}

/* EXIF 2.32, tag 0x0112: the visual sides at which row 0 and column 0 lie. */
static const struct {
    char row, column;
} sides[9] = {{' ', ' '}, {'t', 'l'}, {'t', 'r'}, {'b', 'r'}, {'b', 'l'},
              {'l', 't'}, {'r', 't'}, {'r', 'b'}, {'l', 'b'}};

/* Moves (x, y) to where index i from a visual side lies. */
static void go(char side, int i, int *x, int *y)
{
    switch (side) {
    case 't':
        *y = i;
        break;
    case 'b':
        *y = HEIGHT - 1 - i;
        break;
    case 'l':
        *x = i;
        break;
    default:
        *x = WIDTH - 1 - i;
        break;
    }
}

static lf_image8 stored(int orientation)
{
    const bool upright = orientation < 5;
    lf_image8 image = {0};
    assert_int_equal(lf_image8_init(&image, upright ? WIDTH : HEIGHT, upright ? HEIGHT : WIDTH, 3),
                     LF_OK);
    for (int row = 0; row < image.height; row++)
        for (int column = 0; column < image.width; column++) {
            int x = 0, y = 0;
            go(sides[orientation].row, row, &x, &y);
            go(sides[orientation].column, column, &x, &y);
            memcpy(image.data + (size_t)row * image.stride + 3 * (size_t)column, colour_at(x, y),
                   3);
        }
    return image;
}

/* A TIFF whose only entry is the orientation. */
static size_t exif(uint8_t *to, int orientation, bool big)
{
    static const uint8_t little_tiff[26] = {'I', 'I', '*', 0, 8, 0, 0, 0, 1, 0, 0x12, 1, 3, 0, 1};
    static const uint8_t big_tiff[26] = {'M', 'M',  0,    '*', 0, 0, 0, 8, 0,
                                         1,   0x01, 0x12, 0,   3, 0, 0, 0, 1};
    memcpy(to, big ? big_tiff : little_tiff, 26);
    to[big ? 19 : 18] = (uint8_t)orientation;
    return 26;
}

static void write_with(const char *path, const void *plain, size_t n, size_t at, const void *part,
                       size_t part_bytes)
{
    uint8_t *whole = lf_calloc(n + part_bytes, 1);
    assert_non_null(whole);
    memcpy(whole, plain, at);
    memcpy(whole + at, part, part_bytes);
    memcpy(whole + at + part_bytes, (const uint8_t *)plain + at, n - at);
    lf_picture_write(path, whole, n + part_bytes);
    lf_free(whole);
}

static void write_jpeg(const char *path, const lf_image8 *image)
{
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr manager;
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = (JDIMENSION)image->width;
    jpeg.image_height = (JDIMENSION)image->height;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    jpeg_start_compress(&jpeg, TRUE);
    for (int y = 0; y < image->height; y++)
        jpeg_write_scanlines(&jpeg, (JSAMPROW[]){image->data + (size_t)y * image->stride}, 1);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_int_equal(fclose(file), 0);
}

/* The EXIF becomes an APP1 behind the beginning of a JPEG. */
static const char *jpeg_of(const lf_image8 *image, const uint8_t *tiff, size_t n)
{
    const char *path = lf_test_path(folder, "a.jpg");
    uint8_t segment[128] = {0xff, 0xe1, 0, (uint8_t)(n + 8), 'E', 'x', 'i', 'f'};
    size_t size;
    memcpy(segment + 10, tiff, n);
    write_jpeg(path, image);
    char *plain = lf_picture_bytes(path, &size);
    write_with(path, plain, size, 2, segment, n + 10);
    lf_free(plain);
    return path;
}

static void put_be32(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* ... and an eXIf behind the header of a PNG. */
static const char *png_of(const lf_image8 *image, const uint8_t *tiff, size_t n)
{
    const char *path = lf_test_path(folder, "a.png");
    uint8_t chunk[128] = {0, 0, 0, 0, 'e', 'X', 'I', 'f'};
    size_t size;
    put_be32(chunk, (uint32_t)n);
    memcpy(chunk + 8, tiff, n);
    put_be32(chunk + 8 + n, (uint32_t)crc32(0, chunk + 4, (uInt)n + 4));
    lf_picture_save_png(path, image, 6, NULL, 0);
    char *plain = lf_picture_bytes(path, &size);
    write_with(path, plain, size, 33, chunk, n + 12);
    lf_free(plain);
    return path;
}

static bool is_upright(const lf_image8 *image, int tolerance)
{
    if (image->width != WIDTH || image->height != HEIGHT)
        return false;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            for (int c = 0; c < 3; c++)
                if (abs(image->data[(size_t)y * image->stride + 3 * (size_t)x + (size_t)c] -
                        colour_at(x, y)[c]) > tolerance)
                    return false;
    return true;
}

typedef const char *(*writer)(const lf_image8 *image, const uint8_t *tiff, size_t n);

static void assert_all_ways(writer write, int tolerance)
{
    for (int orientation = 1; orientation <= 8; orientation++)
        for (int big = 0; big < 2; big++) {
            uint8_t tiff[64];
            lf_image_metadata meta;
            lf_image8 from = stored(orientation);
            const char *path = write(&from, tiff, exif(tiff, orientation, big));
            lf_image8 image = lf_codes_metadata(path, &meta), silent = lf_picture_load8(path);
            if (!is_upright(&image, tolerance) || !is_upright(&silent, tolerance))
                fail_msg("%s: orientation %d", path, orientation);
            lf_metadata_notes(&meta, NULL);
            lf_image8_finish(&image);
            lf_image8_finish(&silent);
            lf_image8_finish(&from);
        }
}

static void a_jpeg_is_read_the_way_up_that_it_says(void **state)
{
    (void)state;
    assert_all_ways(jpeg_of, 6);
}

static void a_png_is_read_the_way_up_that_it_says(void **state)
{
    (void)state;
    assert_all_ways(png_of, 0);
}

static void as_floats_it_is_turned_too(void **state)
{
    (void)state;
    uint8_t tiff[64];
    lf_image8 from = stored(6);
    lf_image32 image = lf_picture_load32(png_of(&from, tiff, exif(tiff, 6, true)));
    assert_true(image.width == WIDTH && image.height == HEIGHT);
    assert_true(image.data[0] > 0.9f && image.data[1] < 0.1f); /* red, at the top left */
    lf_image32_finish(&image);
    lf_image8_finish(&from);
}

/* glTF 2.0 wants what is stored; the control of those above as well. */
static void a_texture_is_not_turned(void **state)
{
    (void)state;
    uint8_t tiff[64], *rgba;
    int width, height;
    size_t size;
    lf_error err;
    lf_image8 from = stored(6);
    char *bytes = lf_picture_bytes(png_of(&from, tiff, exif(tiff, 6, false)), &size);
    lf_assert_ok(lf_image_rgba_decode(bytes, size, "a.png", &rgba, &width, &height, &err), &err);
    assert_true(width == HEIGHT && height == WIDTH);
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++)
        assert_memory_equal(rgba + 4 * i, from.data + 3 * i, 3);
    lf_free(rgba);
    lf_free(bytes);
    lf_image8_finish(&from);
}

/* Under the sanitizers every read outside of the block is found. */
static void hostile_exif_is_read_without_harm(void **state)
{
    (void)state;
    uint64_t seed = 5;
    lf_image8 from = stored(1);
    for (int i = 0; i < 400; i++) {
        uint8_t tiff[64];
        size_t n = exif(tiff, 6, i % 2);
        for (int k = 0; k < 1 + i % 3; k++)
            tiff[lf_picture_random(&seed) % n] = (uint8_t)(lf_picture_random(&seed) >> 8);
        if (i % 4 == 3)
            n = lf_picture_random(&seed) % n;
        lf_image8 image = lf_picture_load8((i % 8 < 4 ? png_of : jpeg_of)(&from, tiff, n));
        assert_int_equal(image.width * image.height, WIDTH * HEIGHT);
        lf_image8_finish(&image);
    }
    lf_image8_finish(&from);
}

static int setup(void **state)
{
    int rc = lf_test_folder_setup(state);
    folder = *state;
    return rc;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_jpeg_is_read_the_way_up_that_it_says),
        cmocka_unit_test(a_png_is_read_the_way_up_that_it_says),
        cmocka_unit_test(as_floats_it_is_turned_too),
        cmocka_unit_test(a_texture_is_not_turned),
        cmocka_unit_test(hostile_exif_is_read_without_harm),
    };
    return cmocka_run_group_tests(tests, setup, lf_test_folder_teardown);
}
