#include "tests/base/pictures.h"

#include <fcntl.h>

#include "base/alloc.h"

uint32_t lf_picture_random(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 33);
}

float lf_picture_smooth(int x, int y, int c)
{
    return (float)(0.4 + 0.3 * sin(0.11 * x + c) * cos(0.07 * y - c));
}

void lf_picture_write(const char *path, const void *data, size_t n)
{
    unlink(path);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

char *lf_picture_bytes(const char *path, size_t *n)
{
    char *data;
    lf_error err;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 26, &data, n, &err), &err);
    return data;
}

/* Without the fsync of a file that is to last, and not by truncation, after which ext4 syncs of its
 * own accord: there are thousands of them here. */
static lf_outfile open_scratch(const char *path)
{
    unlink(path);
    lf_outfile file = {.fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600),
                       .borrowed = true};
    assert_true(file.fd >= 0);
    return file;
}

void lf_picture_save_png(const char *path, const lf_image8 *image, int level,
                         const lf_attribute *attributes, int n)
{
    lf_outfile file = open_scratch(path);
    lf_error err;
    lf_assert_ok(lf_png_write(&file, image, level, attributes, n, &err), &err);
    assert_int_equal(close(file.fd), 0);
}

void lf_picture_save_exr(const char *path, const lf_image32 *image, const lf_attribute *attributes,
                         int n)
{
    lf_outfile file = open_scratch(path);
    lf_error err;
    lf_assert_ok(lf_exr_write(&file, image, attributes, n, &err), &err);
    assert_int_equal(close(file.fd), 0);
}

lf_image8 lf_picture_noise(int width, int height)
{
    lf_image8 image = {0};
    uint64_t seed = 7;
    assert_int_equal(lf_image8_init(&image, width, height, 3), LF_OK);
    for (size_t i = 0; i < image.stride * (size_t)height; i++)
        image.data[i] = (uint8_t)lf_picture_random(&seed);
    return image;
}

lf_image32 lf_picture_load32(const char *path)
{
    lf_image32 image = {0};
    lf_error err;
    lf_assert_ok(lf_image32_read(path, NULL, &image, &err), &err);
    assert_int_equal(image.channels, 3);
    return image;
}

lf_image8 lf_picture_load8(const char *path)
{
    lf_image8 image = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(path, NULL, &image, &err), &err);
    assert_int_equal(image.channels, 3);
    return image;
}

void lf_picture_refused(const char *path, const char *word)
{
    lf_image32 image = {0};
    lf_error err = {0};
    lf_assert_status(lf_image32_read(path, NULL, &image, &err), LF_E_FORMAT, &err);
    assert_null(image.data);
    assert_string_equal(err.where, path);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

void lf_picture_jpeg(const char *path, int width, int height, int components, J_COLOR_SPACE space)
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
                row[x * components + c] = (uint8_t)(255 * (double)lf_picture_smooth(x, y, c));
        JSAMPROW pointer = row;
        jpeg_write_scanlines(&jpeg, &pointer, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_int_equal(fclose(file), 0);
}

void lf_picture_png(const char *path, int width, int height, int depth, int color, bool interlaced,
                    const png_color_16 *clear, uint8_t *rows, size_t stride)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, color,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_color palette[4] = {{1, 2, 3}, {50, 60, 70}, {255, 0, 128}, {9, 9, 9}};
    png_byte alpha[4] = {255, 0, 7, 255};
    if (color == PNG_COLOR_TYPE_PALETTE) {
        png_set_PLTE(png, info, palette, 4);
        png_set_tRNS(png, info, alpha, 4, NULL);
    } else if (!(color & PNG_COLOR_MASK_ALPHA) && clear) {
        png_set_tRNS(png, info, NULL, 0, clear);
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

void lf_picture_half_exr(const char *path, const int display[4], const int data[4], int compression,
                         int channels, bool tiled)
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
        ImfFloatToHalf(lf_picture_smooth(x, y, 0), &pixels[i].r);
        ImfFloatToHalf(lf_picture_smooth(x, y, 1), &pixels[i].g);
        ImfFloatToHalf(lf_picture_smooth(x, y, 2), &pixels[i].b);
        ImfFloatToHalf(1, &pixels[i].a);
    }
    const ImfRgba *origin =
        (const ImfRgba *)((intptr_t)pixels -
                          (data[0] + (intptr_t)data[1] * width) * (intptr_t)sizeof *pixels);
    if (tiled) {
        ImfTiledOutputFile *file = ImfOpenTiledOutputFile(path, header, channels, 20, 12,
                                                          IMF_MIPMAP_LEVELS, IMF_ROUND_DOWN);
        if (!file)
            fail_msg("%s", ImfErrorMessage());
        assert_true(ImfTiledOutputSetFrameBuffer(file, origin, 1, (size_t)width));
        assert_true(ImfTiledOutputWriteTiles(file, 0, (width + 19) / 20 - 1, 0,
                                             (height + 11) / 12 - 1, 0, 0));
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

size_t lf_picture_hdr_header(char *to, const char *resolution, const char *more)
{
    return (size_t)sprintf(to, "#?RADIANCE\n# a comment\n%sFORMAT=32-bit_rle_rgbe\n\n%s\n", more,
                           resolution);
}
