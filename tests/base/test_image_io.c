#include "tests/testing.h"

#include <dirent.h>
#include <fcntl.h>

#include <ImfCRgbaFile.h>
#include <jpeglib.h>
#include <openexr.h>
#include <png.h>

#include "base/alloc.h"
#include "base/image_io.h"

static int make_folder(void **state)
{
    *state = lf_test_folder();
    return 0;
}

static int remove_folder(void **state)
{
    lf_test_folder_remove(*state);
    return 0;
}

/* Numbers that differ from test to test but not from run to run. */
static uint32_t random_bits(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 33);
}

static float smooth(int x, int y, int c)
{
    return (float)(0.4 + 0.3 * sin(0.11 * x + c) * cos(0.07 * y - c));
}

static void write_bytes(const char *path, const void *data, size_t n)
{
    unlink(path);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

static char *read_bytes(const char *path, size_t *n)
{
    char *data;
    lf_error err;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 26, &data, n, &err), &err);
    return data;
}

static bool holds(const char *path, const char *word)
{
    size_t n;
    char *data = read_bytes(path, &n);
    bool found = memmem(data, n, word, strlen(word)) != NULL;
    lf_free(data);
    return found;
}

/* Without the fsync of a file that is to last, and not by truncation, after which ext4 syncs of its own accord: there are
 * thousands of them here. */
static lf_outfile open_scratch(const char *path)
{
    unlink(path);
    lf_outfile file = {.fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600), .borrowed = true};
    assert_true(file.fd >= 0);
    return file;
}

static void save_png(const char *path, const lf_image8 *image, int level, const lf_attribute *attributes, int n)
{
    lf_outfile file = open_scratch(path);
    lf_error err;
    lf_assert_ok(lf_png_write(&file, image, level, attributes, n, &err), &err);
    assert_int_equal(close(file.fd), 0);
}

static void save_exr(const char *path, const lf_image32 *image, const lf_attribute *attributes, int n)
{
    lf_outfile file = open_scratch(path);
    lf_error err;
    lf_assert_ok(lf_exr_write(&file, image, attributes, n, &err), &err);
    assert_int_equal(close(file.fd), 0);
}

static lf_image8 noise8(int width, int height)
{
    lf_image8 image = {0};
    uint64_t seed = 7;
    assert_int_equal(lf_image8_init(&image, width, height, 3), LF_OK);
    for (size_t i = 0; i < image.stride * (size_t)height; i++)
        image.data[i] = (uint8_t)random_bits(&seed);
    return image;
}

static lf_image32 load32(const char *path)
{
    lf_image32 image = {0};
    lf_error err;
    lf_assert_ok(lf_image32_read(path, NULL, &image, &err), &err);
    assert_int_equal(image.channels, 3);
    return image;
}

static lf_image8 load8(const char *path)
{
    lf_image8 image = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(path, NULL, &image, &err), &err);
    assert_int_equal(image.channels, 3);
    return image;
}

static void assert_refused32(const char *path, const char *word)
{
    lf_image32 image = {0};
    lf_error err = {0};
    lf_assert_status(lf_image32_read(path, NULL, &image, &err), LF_E_FORMAT, &err);
    assert_null(image.data);
    assert_string_equal(err.where, path);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

/* --------------------------------------------------------------------------------------------------------- shapes -- */

static void shapes_over_the_limits_are_refused(void **state)
{
    (void)state;
    lf_image8 a = {0};
    lf_image32 b = {0};
    const int bad[][3] = {{0, 1, 3}, {1, 0, 3}, {65537, 1, 3}, {1, 65537, 1}, {1, 1, 0}, {1, 1, 5}, {65536, 65536, 3}, {-4, 4, 3}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(lf_image8_init(&a, bad[i][0], bad[i][1], bad[i][2]), LF_E_ARG);
        assert_int_equal(lf_image32_init(&b, bad[i][0], bad[i][1], bad[i][2]), LF_E_ARG);
        assert_null(a.data);
        assert_null(b.data);
    }
    assert_int_equal(lf_image8_init(&a, 65536, 2, 4), LF_OK);
    assert_int_equal(a.stride, 65536 * 4);
    lf_image8_finish(&a);
    lf_image8_finish(&a);
    lf_image32_finish(&b);
}

/* ------------------------------------------------------------------------------------------------------------ PNG -- */

static void a_png_comes_back_as_it_was_at_every_level(void **state)
{
    const char *path = lf_test_path(*state, "a.png");
    lf_image8 image = noise8(61, 37);
    for (int level = 1; level <= 9; level++) {
        save_png(path, &image, level, NULL, 0);
        lf_image8 back = load8(path);
        assert_int_equal(back.width, 61);
        assert_int_equal(back.height, 37);
        assert_memory_equal(back.data, image.data, image.stride * 37);
        lf_image8_finish(&back);
    }
    lf_image8_finish(&image);
}

static void a_png_says_srgb_and_carries_its_texts(void **state)
{
    const char *path = lf_test_path(*state, "a.png");
    lf_image8 image = noise8(3, 2);
    const lf_attribute attributes[] = {{"Software", "quiltd 1"}, {"Title", "W\xc3\xb6lkchen"}};
    save_png(path, &image, 1, attributes, 2);
    assert_true(holds(path, "sRGB"));
    assert_true(holds(path, "tEXtSoftware"));
    assert_true(holds(path, "quiltd 1"));
    assert_true(holds(path, "iTXtTitle"));
    assert_true(holds(path, "W\xc3\xb6lkchen"));
    assert_false(holds(path, "gAMA"));
    lf_image8_finish(&image);
}

/* Writes rows of any kind of PNG by libpng itself. */
static void make_png(const char *path, int width, int height, int depth, int color, bool interlaced, uint8_t *rows, size_t stride)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, color,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_color palette[4] = {{1, 2, 3}, {50, 60, 70}, {255, 0, 128}, {9, 9, 9}};
    png_byte alpha[4] = {255, 0, 7, 255};
    if (color == PNG_COLOR_TYPE_PALETTE) {
        png_set_PLTE(png, info, palette, 4);
        png_set_tRNS(png, info, alpha, 4, NULL);
    }
    png_write_info(png, info);
    png_bytep pointers[16];
    for (int y = 0; y < height; y++)
        pointers[y] = rows + (size_t)y * stride;
    png_write_image(png, pointers);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
}

static void every_kind_of_png_becomes_rgb(void **state)
{
    const char *path = lf_test_path(*state, "kind.png");
    const uint8_t palette[4][3] = {{1, 2, 3}, {50, 60, 70}, {255, 0, 128}, {9, 9, 9}};
    uint8_t rows[8][64];
    for (int interlaced = 0; interlaced < 2; interlaced++) {
        memset(rows, 0x1b, sizeof rows); /* indices 0 1 2 3 of two bits */
        make_png(path, 8, 8, 2, PNG_COLOR_TYPE_PALETTE, interlaced, &rows[0][0], 64);
        lf_image8 image = load8(path);
        for (int x = 0; x < 8; x++)
            assert_memory_equal(image.data + 3 * image.stride + 3 * (size_t)x, palette[x % 4], 3);
        lf_image8_finish(&image);
        make_png(path, 8, 8, 2, PNG_COLOR_TYPE_GRAY, interlaced, &rows[0][0], 64);
        image = load8(path);
        for (int x = 0; x < 8; x++)
            for (int c = 0; c < 3; c++)
                assert_int_equal(image.data[7 * image.stride + 3 * (size_t)x + (size_t)c], 85 * (x % 4));
        lf_image8_finish(&image);
        /* 16 bits are rounded, alpha is dropped */
        const uint16_t samples[4] = {0x0180, 0x7fff, 0xff7f, 0x1234};
        for (int x = 0; x < 8; x++)
            for (int c = 0; c < 4; c++) {
                rows[0][x * 8 + c * 2] = (uint8_t)(samples[c] >> 8);
                rows[0][x * 8 + c * 2 + 1] = (uint8_t)samples[c];
            }
        make_png(path, 8, 1, 16, PNG_COLOR_TYPE_RGBA, interlaced, &rows[0][0], 64);
        image = load8(path);
        for (int c = 0; c < 3; c++)
            assert_int_equal(image.data[15 + c], (int)floor(samples[c] / 257.0 + 0.5));
        lf_image8_finish(&image);
    }
}

static void eight_bit_pictures_are_decoded_from_srgb(void **state)
{
    const char *path = lf_test_path(*state, "ramp.png");
    lf_image8 image = {0};
    assert_int_equal(lf_image8_init(&image, 256, 1, 3), LF_OK);
    for (int i = 0; i < 768; i++)
        image.data[i] = (uint8_t)(i / 3);
    save_png(path, &image, 6, NULL, 0);
    lf_image32 linear = load32(path);
    for (int i = 0; i < 256; i++) {
        double s = i / 255.0;
        lf_assert_close((double)linear.data[3 * i], s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4), 1e-6, 0);
    }
    lf_image32_finish(&linear);
    lf_image8_finish(&image);
}

/* ----------------------------------------------------------------------------------------------------------- JPEG -- */

static void make_jpeg(const char *path, int width, int height, int components, J_COLOR_SPACE space)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr manager;
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = components;
    jpeg.in_color_space = space;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 98, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    uint8_t row[1024];
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++)
            for (int c = 0; c < components; c++)
                row[x * components + c] = (uint8_t)(255 * (double)smooth(x, y, c));
        JSAMPROW pointer = row;
        jpeg_write_scanlines(&jpeg, &pointer, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_int_equal(fclose(file), 0);
}

static void a_jpeg_is_read_as_rgb(void **state)
{
    const char *path = lf_test_path(*state, "a.jpg");
    for (int components = 1; components <= 3; components += 2) {
        make_jpeg(path, 90, 70, components, components == 1 ? JCS_GRAYSCALE : JCS_RGB);
        lf_image8 image = load8(path);
        assert_int_equal(image.width, 90);
        assert_int_equal(image.height, 70);
        for (int i = 0; i < 90 * 70; i++)
            for (int c = 0; c < 3; c++)
                lf_assert_close(image.data[3 * i + c], 255 * (double)smooth(i % 90, i / 90, components == 1 ? 0 : c), 0, 6);
        lf_image8_finish(&image);
    }
}

static void a_jpeg_that_is_cut_off_or_cmyk_is_refused(void **state)
{
    const char *path = lf_test_path(*state, "a.jpg");
    make_jpeg(path, 90, 70, 4, JCS_CMYK);
    assert_refused32(path, "4 components");
    make_jpeg(path, 90, 70, 3, JCS_RGB);
    size_t n;
    char *data = read_bytes(path, &n);
    write_bytes(path, data, n / 2);
    assert_refused32(path, "JPEG");
    lf_free(data);
}

/* ------------------------------------------------------------------------------------------------------------ EXR -- */

static void an_exr_comes_back_bit_for_bit(void **state)
{
    const char *path = lf_test_path(*state, "a.exr");
    lf_image32 image = {0};
    uint64_t seed = 3;
    assert_int_equal(lf_image32_init(&image, 53, 41, 3), LF_OK);
    for (int i = 0; i < 53 * 41 * 3; i++)
        image.data[i] = (float)random_bits(&seed) * 1e-9f - 0.5f;
    const float special[] = {0, -0.0f, 1e-42f, -3e38f, 3e38f, 1e-38f, 65504.5f};
    memcpy(image.data, special, sizeof special);
    const lf_attribute attributes[] = {{"integrator", "mvpt"}, {"a_name_of_more_than_thirty_one_characters", "W\xc3\xb6lkchen"}};
    save_exr(path, &image, attributes, 2);
    lf_image32 back = load32(path);
    assert_int_equal(back.width, 53);
    assert_int_equal(back.height, 41);
    assert_memory_equal(back.data, image.data, 53 * 41 * 3 * sizeof(float));
    lf_image32_finish(&back);
    ImfInputFile *file = ImfOpenInputFile(path);
    assert_non_null(file);
    const char *value;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ImfHeaderStringAttribute(ImfInputHeader(file), attributes[i].name, &value), 1);
        assert_string_equal(value, attributes[i].value);
    }
    ImfCloseInputFile(file);
    const char *second = lf_test_path(*state, "b.exr");
    save_exr(second, &image, attributes, 2);
    size_t n[2];
    char *bytes[2] = {read_bytes(path, &n[0]), read_bytes(second, &n[1])};
    assert_int_equal(n[0], n[1]);
    assert_memory_equal(bytes[0], bytes[1], n[0]);
    lf_free(bytes[0]);
    lf_free(bytes[1]);
    lf_image32_finish(&image);
}

/* OpenEXRCore 3.1 writes a block that shrinks by nothing in a way that no reader understands; about one in a hundred of these is
 * such a one. */
static void blocks_whose_compressed_bytes_are_as_many_as_the_plain_come_back(void **state)
{
    const char *path = lf_test_path(*state, "block.exr");
    uint64_t seed = 4;
    for (int width = 4; width < 16; width++) {
        for (int n = 0; n <= 12 * width; n++) {
            lf_image32 image = {0};
            assert_int_equal(lf_image32_init(&image, width, 1, 3), LF_OK);
            for (int i = 0; i < n; i++)
                ((uint8_t *)image.data)[i] = (uint8_t)(random_bits(&seed) & 0x3f);
            save_exr(path, &image, NULL, 0);
            lf_image32 back = load32(path);
            assert_memory_equal(back.data, image.data, (size_t)width * 12);
            lf_image32_finish(&back);
            lf_image32_finish(&image);
        }
    }
}

/* Windows are {x0, y0, x1, y1}, ends included. */
static void make_half_exr(const char *path, const int display[4], const int data[4], int compression, int channels, bool tiled)
{
    ImfHeader *header = ImfNewHeader();
    ImfHeaderSetDisplayWindow(header, display[0], display[1], display[2], display[3]);
    ImfHeaderSetDataWindow(header, data[0], data[1], data[2], data[3]);
    ImfHeaderSetCompression(header, compression);
    int width = data[2] - data[0] + 1, height = data[3] - data[1] + 1;
    ImfRgba *pixels = calloc((size_t)width * (size_t)height, sizeof *pixels);
    assert_non_null(pixels);
    for (int i = 0; i < width * height; i++) {
        int x = data[0] + i % width, y = data[1] + i / width;
        ImfFloatToHalf(smooth(x, y, 0), &pixels[i].r);
        ImfFloatToHalf(smooth(x, y, 1), &pixels[i].g);
        ImfFloatToHalf(smooth(x, y, 2), &pixels[i].b);
        ImfFloatToHalf(1, &pixels[i].a);
    }
    const ImfRgba *origin = (const ImfRgba *)((intptr_t)pixels - (data[0] + (intptr_t)data[1] * width) * (intptr_t)sizeof *pixels);
    if (tiled) {
        ImfTiledOutputFile *file = ImfOpenTiledOutputFile(path, header, channels, 20, 12, IMF_MIPMAP_LEVELS, IMF_ROUND_DOWN);
        if (!file)
            fail_msg("%s", ImfErrorMessage());
        assert_true(ImfTiledOutputSetFrameBuffer(file, origin, 1, (size_t)width));
        assert_true(ImfTiledOutputWriteTiles(file, 0, (width + 19) / 20 - 1, 0, (height + 11) / 12 - 1, 0, 0));
        ImfCloseTiledOutputFile(file);
    } else {
        ImfOutputFile *file = ImfOpenOutputFile(path, header, channels);
        if (!file)
            fail_msg("%s", ImfErrorMessage());
        assert_true(ImfOutputSetFrameBuffer(file, origin, 1, (size_t)width));
        assert_true(ImfOutputWritePixels(file, height));
        ImfCloseOutputFile(file);
    }
    ImfDeleteHeader(header);
    free(pixels);
}

static float half_of(float value)
{
    ImfHalf half;
    ImfFloatToHalf(value, &half);
    return ImfHalfToFloat(half);
}

/* What make_half_exr put into the data window, and black around it. */
static void assert_windowed(const char *path, const int display[4], const int data[4], double tolerance)
{
    lf_image32 image = load32(path);
    assert_int_equal(image.width, display[2] - display[0] + 1);
    assert_int_equal(image.height, display[3] - display[1] + 1);
    for (int i = 0; i < image.width * image.height; i++) {
        int x = display[0] + i % image.width, y = display[1] + i / image.width;
        bool inside = x >= data[0] && x <= data[2] && y >= data[1] && y <= data[3];
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)image.data[3 * i + c], inside ? (double)half_of(smooth(x, y, c)) : 0, 0, tolerance);
    }
    lf_image32_finish(&image);
}

static void every_compression_is_read_in_lines_and_tiles(void **state)
{
    const char *path = lf_test_path(*state, "c.exr");
    const int window[4] = {0, 0, 96, 298}; /* over DWAB's 256 lines, and no multiple of a block's or tile's side */
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; compression++) {
        bool lossy = compression >= IMF_B44_COMPRESSION;
        for (int tiled = 0; tiled < 2; tiled++) {
            make_half_exr(path, window, window, compression, IMF_WRITE_RGBA, tiled);
            assert_windowed(path, window, window, lossy ? 0.02 : 0);
        }
    }
}

static void pictures_of_every_small_size_are_read(void **state)
{
    const char *path = lf_test_path(*state, "s.exr");
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; compression++) {
        for (int k = 0; k < 50; k++) {
            const int window[4] = {0, 0, k % 7 + 19 * (k % 2), k / 7 + 10 * (k % 3)};
            make_half_exr(path, window, window, compression, IMF_WRITE_RGB, k % 2);
            assert_windowed(path, window, window, compression >= IMF_B44_COMPRESSION ? 0.02 : 0);
        }
    }
}

static void the_data_window_is_placed_in_the_display_window(void **state)
{
    const char *path = lf_test_path(*state, "w.exr");
    const int windows[][2][4] = {
        {{0, 0, 63, 47}, {10, 5, 40, 30}},  /* inside */
        {{0, 0, 63, 47}, {-8, -6, 70, 60}}, /* all around */
        {{0, 0, 63, 47}, {50, 40, 90, 80}}, /* over a corner */
        {{-20, -10, 30, 30}, {-25, -5, 5, 20}} /* negative origin */,
        {{0, 0, 63, 47}, {100, 100, 120, 110}} /* beside it */,
    };
    const int compressions[] = {IMF_ZIP_COMPRESSION, IMF_DWAA_COMPRESSION};
    for (size_t i = 0; i < sizeof windows / sizeof windows[0]; i++) {
        for (int k = 0; k < 4; k++) {
            make_half_exr(path, windows[i][0], windows[i][1], compressions[k / 2], IMF_WRITE_RGB, k % 2);
            assert_windowed(path, windows[i][0], windows[i][1], k / 2 ? 0.02 : 0);
        }
    }
}

static void luminance_and_chroma_are_read(void **state)
{
    const char *path = lf_test_path(*state, "y.exr");
    const int window[4] = {0, 0, 63, 47};
    const int compressions[] = {IMF_PIZ_COMPRESSION, IMF_DWAB_COMPRESSION};
    for (int k = 0; k < 2; k++) {
        make_half_exr(path, window, window, compressions[k], IMF_WRITE_Y, false);
        lf_image32 image = load32(path);
        for (int i = 0; i < 64 * 48; i++) {
            double r = (double)smooth(i % 64, i / 64, 0), g = (double)smooth(i % 64, i / 64, 1),
                   b = (double)smooth(i % 64, i / 64, 2);
            lf_assert_close((double)image.data[3 * i], 0.2126 * r + 0.7152 * g + 0.0722 * b, 0.02, 0);
            assert_true(image.data[3 * i] == image.data[3 * i + 1] && image.data[3 * i] == image.data[3 * i + 2]);
        }
        lf_image32_finish(&image);
        make_half_exr(path, window, window, compressions[k], IMF_WRITE_YC, false);
        assert_windowed(path, window, window, 0.05); /* colour at half the resolution */
    }
}

#define CORE_WIDTH 38
#define CORE_HEIGHT 35

/* What channel `name` has in make_core_exr's files. */
static uint32_t core_value(char name, int x, int y)
{
    return (uint32_t)(10000 * name + 97 * y + x * x);
}

/* Files by the Core, with other types and names of channels than the C interface of the C++ library writes. */
static void make_core_exr(const char *path, const char *const names[], int n, exr_pixel_type_t type, exr_compression_t compression)
{
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t exr;
    int part;
    int32_t lines;
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup), EXR_ERR_SUCCESS);
    assert_int_equal(exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part), EXR_ERR_SUCCESS);
    assert_int_equal(exr_initialize_required_attr_simple(exr, part, CORE_WIDTH, CORE_HEIGHT, compression), EXR_ERR_SUCCESS);
    for (int c = 0; c < n; c++)
        assert_int_equal(exr_add_channel(exr, part, names[c], type, EXR_PERCEPTUALLY_LINEAR, 1, 1), EXR_ERR_SUCCESS);
    assert_int_equal(exr_write_header(exr), EXR_ERR_SUCCESS);
    assert_int_equal(exr_get_scanlines_per_chunk(exr, part, &lines), EXR_ERR_SUCCESS);
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    static uint32_t whole[8][CORE_HEIGHT * CORE_WIDTH];
    static float real[8][CORE_HEIGHT * CORE_WIDTH];
    for (int y = 0; y < CORE_HEIGHT; y += lines) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_write_scanline_chunk_info(exr, part, y, &chunk), EXR_ERR_SUCCESS);
        if (y == 0)
            assert_int_equal(exr_encoding_initialize(exr, part, &chunk, &encode), EXR_ERR_SUCCESS);
        else
            assert_int_equal(exr_encoding_update(exr, part, &chunk, &encode), EXR_ERR_SUCCESS);
        for (int c = 0; c < encode.channel_count; c++) {
            for (int i = 0; i < chunk.height * CORE_WIDTH; i++) {
                whole[c][i] = core_value(encode.channels[c].channel_name[0], i % CORE_WIDTH, y + i / CORE_WIDTH);
                real[c][i] = (float)whole[c][i] + 0.25f;
            }
            encode.channels[c].encode_from_ptr = type == EXR_PIXEL_UINT ? (const uint8_t *)whole[c] : (const uint8_t *)real[c];
            encode.channels[c].user_pixel_stride = 4;
            encode.channels[c].user_line_stride = 4 * CORE_WIDTH;
        }
        if (y == 0)
            assert_int_equal(exr_encoding_choose_default_routines(exr, part, &encode), EXR_ERR_SUCCESS);
        assert_int_equal(exr_encoding_run(exr, part, &encode), EXR_ERR_SUCCESS);
    }
    exr_encoding_destroy(exr, &encode);
    assert_int_equal(exr_finish(&exr), EXR_ERR_SUCCESS);
}

/* Channels names[0..2] of such a file, up to a relative error. */
static void assert_core_values(const char *path, const char *names, double add, double tolerance)
{
    lf_image32 image = load32(path);
    assert_int_equal(image.width, CORE_WIDTH);
    assert_int_equal(image.height, CORE_HEIGHT);
    for (int i = 0; i < CORE_WIDTH * CORE_HEIGHT; i++)
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)image.data[3 * i + c], core_value(names[c], i % CORE_WIDTH, i / CORE_WIDTH) + add, tolerance,
                            0);
    lf_image32_finish(&image);
}

static void channels_are_found_by_name_and_converted(void **state)
{
    const char *path = lf_test_path(*state, "n.exr");
    const char *const all[] = {"A", "B", "G", "R", "Y", "Z"}, *const grey[] = {"A", "Y"};
    for (exr_compression_t compression = EXR_COMPRESSION_NONE; compression <= EXR_COMPRESSION_PXR24; compression++) {
        double tolerance = compression == EXR_COMPRESSION_PXR24 ? 1.0 / 65536 : 0; /* 24 bits of a float */
        make_core_exr(path, all, 6, EXR_PIXEL_UINT, compression);
        assert_core_values(path, "RGB", 0, 0);
        make_core_exr(path, all, 6, EXR_PIXEL_FLOAT, compression);
        assert_core_values(path, "RGB", 0.25, tolerance);
        make_core_exr(path, grey, 2, EXR_PIXEL_UINT, compression);
        assert_core_values(path, "YYY", 0, 0);
        make_core_exr(path, grey, 2, EXR_PIXEL_FLOAT, compression);
        assert_core_values(path, "YYY", 0.25, tolerance);
    }
}

static void an_exr_without_colour_is_refused(void **state)
{
    const char *path = lf_test_path(*state, "n.exr");
    const char *const depth[] = {"Z"}, *const layer[] = {"l.B", "l.G", "l.R"}, *const two[] = {"G", "R"};
    make_core_exr(path, depth, 1, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_refused32(path, "channels R, G, B");
    make_core_exr(path, layer, 3, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_refused32(path, "channels R, G, B");
    make_core_exr(path, two, 2, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_refused32(path, "channels R, G, B");
}

static void what_is_not_finite_is_refused(void **state)
{
    const char *path = lf_test_path(*state, "nan.exr");
    lf_image32 image = {0};
    assert_int_equal(lf_image32_init(&image, 5, 4, 3), LF_OK);
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        image.data[(2 * 5 + 3) * 3 + i] = bad[i];
        save_exr(path, &image, NULL, 0);
        assert_refused32(path, "pixel (3, 2)");
        image.data[(2 * 5 + 3) * 3 + i] = 3e38f;
        save_exr(path, &image, NULL, 0);
        lf_image32 back = load32(path);
        lf_image32_finish(&back);
    }
    lf_image32_finish(&image);
}

/* ------------------------------------------------------------------------------------------------------------ HDR -- */

static size_t hdr_header(char *to, const char *resolution, const char *more)
{
    return (size_t)sprintf(to, "#?RADIANCE\n# a comment\n%sFORMAT=32-bit_rle_rgbe\n\n%s\n", more, resolution);
}

static void flat_hdr_pixels_are_shared_exponents(void **state)
{
    const char *path = lf_test_path(*state, "a.hdr");
    char data[256];
    size_t n = hdr_header(data, "-Y 1 +X 4", "");
    const unsigned char pixels[] = {128, 64, 0, 129, 255, 1, 2, 128, 10, 20, 30, 0, 200, 100, 50, 140};
    memcpy(data + n, pixels, sizeof pixels);
    write_bytes(path, data, n + sizeof pixels);
    lf_image32 image = load32(path);
    const float expected[] = {1, 0.5f, 0, 255 / 256.0f, 1 / 256.0f, 2 / 256.0f, 0, 0, 0, 200 * 16.0f, 100 * 16.0f, 50 * 16.0f};
    assert_memory_equal(image.data, expected, sizeof expected);
    lf_image32_finish(&image);
    n = hdr_header(data, "-Y 1 +X 4", "EXPOSURE= 2\nEXPOSURE=2\nCOLORCORR=1 2 4\n");
    memcpy(data + n, pixels, sizeof pixels);
    write_bytes(path, data, n + sizeof pixels);
    image = load32(path);
    lf_assert_close((double)image.data[0], 0.25, 0, 0);
    lf_assert_close((double)image.data[1], 0.0625, 0, 0);
    lf_image32_finish(&image);
}

static void both_kinds_of_runs_are_unrolled(void **state)
{
    const char *path = lf_test_path(*state, "a.hdr");
    char data[512];
    size_t n = hdr_header(data, "-Y 2 +X 300", "");
    unsigned char *to = (unsigned char *)data + n;
    /* new: per component a literal of 2, then runs; the second line old: a pixel, repeated 1 * 43 and 256 times */
    const unsigned char head[] = {2, 2, 300 >> 8, 300 & 255};
    memcpy(to, head, 4);
    to += 4;
    for (int c = 0; c < 4; c++) {
        const unsigned char runs[] = {
            2,        (unsigned char)(10 + c), (unsigned char)(20 + c), 255, (unsigned char)(30 + c), 255, (unsigned char)(40 + c),
            128 + 44, (unsigned char)(50 + c)};
        memcpy(to, runs, sizeof runs);
        to += sizeof runs;
    }
    const unsigned char old[] = {8, 16, 32, 136, 1, 1, 1, 43, 1, 1, 1, 1};
    memcpy(to, old, sizeof old);
    to += sizeof old;
    write_bytes(path, data, (size_t)((char *)to - data));
    lf_image32 image = load32(path);
    for (int x = 0; x < 300; x++) {
        int base = x == 0 ? 10 : x == 1 ? 20 : x < 129 ? 30 : x < 256 ? 40 : 50;
        for (int c = 0; c < 3; c++) {
            lf_assert_close((double)image.data[3 * x + c], ldexp(base + c, base + 3 - 136), 0, 0);
            lf_assert_close((double)image.data[900 + 3 * x + c], 8 << c, 0, 0);
        }
    }
    lf_image32_finish(&image);
}

static void flipped_axes_are_turned_back(void **state)
{
    const char *path = lf_test_path(*state, "a.hdr");
    for (int k = 0; k < 8; k++) {
        bool columns = k & 4, x_down = k & 2, y_up = k & 1;
        char line[64], data[256];
        if (columns)
            sprintf(line, "%cX 3 %cY 2", x_down ? '-' : '+', y_up ? '+' : '-');
        else
            sprintf(line, "%cY 2 %cX 3", y_up ? '+' : '-', x_down ? '-' : '+');
        size_t n = hdr_header(data, line, "");
        for (int i = 0; i < 6; i++) {
            int x = columns ? i / 2 : i % 3, y = columns ? i % 2 : i / 3;
            unsigned char pixel[4] = {(unsigned char)((x_down ? 2 - x : x) + 3 * (y_up ? 1 - y : y) + 1), 0, 0, 136};
            memcpy(data + n, pixel, 4);
            n += 4;
        }
        write_bytes(path, data, n);
        lf_image32 image = load32(path);
        assert_int_equal(image.width, 3);
        assert_int_equal(image.height, 2);
        for (int i = 0; i < 6; i++)
            lf_assert_close((double)image.data[3 * i], i + 1, 0, 0);
        lf_image32_finish(&image);
    }
}

static void a_bad_hdr_says_what_is_wrong(void **state)
{
    const char *path = lf_test_path(*state, "bad.hdr");
    const char *const cases[][2] = {
        {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd", "32-bit_rle_rgbe"},
        {"#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\nabcd", "EXPOSURE"},
        {"#?RADIANCE\nEXPOSURE=nan\n\n-Y 1 +X 1\nabcd", "EXPOSURE"},
        {"#?RADIANCE\n\n-Y 1 +Z 1\nabcd", "resolution"},
        {"#?RADIANCE\n\n-Y 1 +X 1 0\nabcd", "resolution"},
        {"#?RADIANCE\n\n-Y 0 +X 1\nabcd", "0"},
        {"#?RADIANCE\n\n-Y 60000 +X 60000\nabcd", "60000x60000"},
        {"#?RADIANCE\n\n-Y 1 +X 2\nabcd", "too early"},
        {"#?RADIANCE\n\n-Y 1 +X 2\n\1\1\1\2", "before the first"},
        {"#?RADIANCE\n\n-Y 1 +X 2\nabcd\1\1\1\2", "longer than"},
        {"#?RADIANCE\nno end", "header"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        write_bytes(path, cases[i][0], strlen(cases[i][0]));
        assert_refused32(path, cases[i][1]);
    }
}

/* ------------------------------------------------------------------------------------------------------- outside -- */

static void kinds_are_told_by_contents(void **state)
{
    const char *path = lf_test_path(*state, "misnamed.txt");
    lf_image8 image = noise8(4, 4);
    lf_image_kind kind;
    lf_error err;
    save_png(path, &image, 1, NULL, 0);
    lf_assert_ok(lf_image_probe(path, NULL, &kind, &err), &err);
    assert_int_equal(kind, LF_IMAGE_8BIT);
    const int window[4] = {0, 0, 3, 3};
    make_half_exr(path, window, window, IMF_ZIP_COMPRESSION, IMF_WRITE_RGB, false);
    lf_assert_ok(lf_image_probe(path, NULL, &kind, &err), &err);
    assert_int_equal(kind, LF_IMAGE_FLOAT);
    lf_image8 wrong = {0};
    lf_assert_status(lf_image8_read(path, NULL, &wrong, &err), LF_E_FORMAT, &err);
    assert_null(wrong.data);
    lf_test_write(*state, "misnamed.txt", "{ \"quiltd\": 1 }");
    lf_assert_status(lf_image_probe(path, NULL, &kind, &err), LF_E_FORMAT, &err);
    lf_test_write(*state, "misnamed.txt", "");
    lf_assert_status(lf_image_probe(path, NULL, &kind, &err), LF_E_FORMAT, &err);
    lf_image8_finish(&image);
}

static void pictures_outside_the_roots_are_not_read(void **state)
{
    const char *path = lf_test_path(*state, "a.png");
    lf_image8 image = noise8(4, 4), back = {0};
    save_png(path, &image, 1, NULL, 0);
    lf_roots roots = {0};
    lf_error err;
    lf_assert_ok(lf_roots_add(&roots, "/usr", &err), &err);
    lf_assert_status(lf_image8_read(path, &roots, &back, &err), LF_E_PATH, &err);
    lf_assert_ok(lf_roots_add(&roots, *state, &err), &err);
    lf_assert_ok(lf_image8_read(path, &roots, &back, &err), &err);
    lf_roots_finish(&roots);
    lf_image8_finish(&back);
    lf_image8_finish(&image);
}

static void a_full_disk_is_an_error_of_io(void **state)
{
    (void)state;
    lf_image8 image = noise8(300, 300);
    lf_image32 floats = {0};
    assert_int_equal(lf_image32_init(&floats, 40, 40, 3), LF_OK);
    lf_error err;
    lf_outfile file = {.fd = open("/dev/full", O_WRONLY | O_CLOEXEC), .borrowed = true};
    assert_true(file.fd >= 0);
    lf_assert_status(lf_png_write(&file, &image, 1, NULL, 0, &err), LF_E_IO, &err);
    lf_assert_status(lf_exr_write(&file, &floats, NULL, 0, &err), LF_E_IO, &err);
    lf_outfile_abandon(&file);
    lf_image8_finish(&image);
    lf_image32_finish(&floats);
}

/* A few bytes must not be able to ask for gigabytes. */
static void headers_that_claim_too_much_are_refused(void **state)
{
    const char *path = lf_test_path(*state, "huge");
    lf_image8 image = noise8(8, 8);
    save_png(path, &image, 1, NULL, 0);
    size_t n;
    char *data = read_bytes(path, &n);
    data[18] = data[22] = 0x40; /* 16392 x 16392; the checksum of the header is wrong as well, so make it right */
    uint32_t crc = 0xffffffff;
    for (int i = 12; i < 29; i++) {
        crc ^= (unsigned char)data[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    for (int i = 0; i < 4; i++)
        data[29 + i] = (char)(~crc >> (24 - 8 * i));
    write_bytes(path, data, n);
    assert_refused32(path, "16392x16392");
    lf_free(data);
    lf_image8_finish(&image);
    const int display[4] = {0, 0, 20000, 20000}, window[4] = {0, 0, 3, 3};
    make_half_exr(path, display, window, IMF_ZIP_COMPRESSION, IMF_WRITE_RGB, false);
    assert_refused32(path, "20001x20001");
}

/* Whatever becomes of a file's bytes: pixels or one clear line. Seen under the sanitizers as well. */
static int fuzz(const char *path, const char *data, size_t n, int rounds)
{
    uint64_t seed = lf_test_seed();
    int n_refused = 0;
    char *copy = malloc(n);
    assert_non_null(copy);
    for (int round = 0; round < rounds; round++) {
        memcpy(copy, data, n);
        size_t length = n;
        if (round % 4 == 0)
            length = random_bits(&seed) % n;
        size_t reach = round % 3 == 0 ? n : n < 400 ? n : 400; /* headers are where the harm is */
        for (uint32_t k = 1 + random_bits(&seed) % 4; round % 4 && k > 0; k--)
            copy[random_bits(&seed) % reach] = (char)random_bits(&seed);
        write_bytes(path, copy, length);
        lf_image32 image = {0};
        lf_error err = {0};
        lf_status status = lf_image32_read(path, NULL, &image, &err);
        if (status == LF_OK) {
            assert_true(image.width > 0 && image.height > 0 && image.channels == 3);
        } else {
            assert_null(image.data);
            assert_int_equal(err.status, status);
            assert_true(err.what[0] && !strchr(err.what, '\n'));
            n_refused++;
        }
        lf_image32_finish(&image);
    }
    free(copy);
    return n_refused;
}

static void damaged_files_give_pixels_or_a_clear_line(void **state)
{
    const char *path = lf_test_path(*state, "fuzz");
    int rounds = lf_test_long() ? 20000 : 400;
    const int window[4] = {0, 0, 41, 33};
    lf_image8 image = noise8(31, 17);
    size_t n;
    save_png(path, &image, 6, NULL, 0);
    char *data = read_bytes(path, &n);
    assert_true(fuzz(path, data, n, rounds) > rounds / 4);
    lf_free(data);
    lf_image8_finish(&image);
    make_jpeg(path, 50, 40, 3, JCS_RGB);
    data = read_bytes(path, &n);
    assert_true(fuzz(path, data, n, rounds) > rounds / 10);
    lf_free(data);
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; compression++) {
        bool tiled = compression % 2;
        make_half_exr(path, window, window, compression, tiled || compression % 3 ? IMF_WRITE_RGBA : IMF_WRITE_YC, tiled);
        data = read_bytes(path, &n);
        assert_true(fuzz(path, data, n, rounds / 4) > rounds / 40);
        lf_free(data);
    }
    char hdr[512];
    n = hdr_header(hdr, "-Y 20 +X 4", "EXPOSURE=1\n");
    memset(hdr + n, 77, 320);
    assert_true(fuzz(path, hdr, n + 320, rounds) > rounds / 10);
}

static void real_pictures_are_read(void **state)
{
    (void)state;
    const struct {
        const char *name;
        int width, height;
        double mean;
    } files[] = {{"hdri/pmndrs_park.exr", 512, 256, 0.26938},
                 {"hdri/studio_small_03_1k.hdr", 1024, 512, 1.88191},
                 {"hdri/venice_sunset_1k.hdr", 1024, 512, 0.46476},
                 {"references/ref_sphere.exr", 120, 160, 0.60695},
                 {"references/ref_bunny_cloud64_v0.exr", 105, 140, 0.67796}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        const char *path = lf_test_shared(files[i].name);
        if (!path)
            skip();
        lf_image32 image = load32(path);
        assert_int_equal(image.width, files[i].width);
        assert_int_equal(image.height, files[i].height);
        double sum = 0;
        for (int k = 0; k < image.width * image.height * 3; k++)
            sum += (double)image.data[k];
        lf_assert_close(sum / (image.width * image.height * 3), files[i].mean, 1e-4, 0);
        lf_image32_finish(&image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_over_the_limits_are_refused),
        cmocka_unit_test(a_png_comes_back_as_it_was_at_every_level),
        cmocka_unit_test(a_png_says_srgb_and_carries_its_texts),
        cmocka_unit_test(every_kind_of_png_becomes_rgb),
        cmocka_unit_test(eight_bit_pictures_are_decoded_from_srgb),
        cmocka_unit_test(a_jpeg_is_read_as_rgb),
        cmocka_unit_test(a_jpeg_that_is_cut_off_or_cmyk_is_refused),
        cmocka_unit_test(an_exr_comes_back_bit_for_bit),
        cmocka_unit_test(blocks_whose_compressed_bytes_are_as_many_as_the_plain_come_back),
        cmocka_unit_test(every_compression_is_read_in_lines_and_tiles),
        cmocka_unit_test(pictures_of_every_small_size_are_read),
        cmocka_unit_test(the_data_window_is_placed_in_the_display_window),
        cmocka_unit_test(luminance_and_chroma_are_read),
        cmocka_unit_test(channels_are_found_by_name_and_converted),
        cmocka_unit_test(an_exr_without_colour_is_refused),
        cmocka_unit_test(what_is_not_finite_is_refused),
        cmocka_unit_test(flat_hdr_pixels_are_shared_exponents),
        cmocka_unit_test(both_kinds_of_runs_are_unrolled),
        cmocka_unit_test(flipped_axes_are_turned_back),
        cmocka_unit_test(a_bad_hdr_says_what_is_wrong),
        cmocka_unit_test(kinds_are_told_by_contents),
        cmocka_unit_test(pictures_outside_the_roots_are_not_read),
        cmocka_unit_test(a_full_disk_is_an_error_of_io),
        cmocka_unit_test(headers_that_claim_too_much_are_refused),
        cmocka_unit_test(damaged_files_give_pixels_or_a_clear_line),
        cmocka_unit_test(real_pictures_are_read),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
