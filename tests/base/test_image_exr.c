/* Pictures as OpenEXR files: ours, and those of the C++ library and of the Core. */
#include "tests/base/pictures.h"

#include <fcntl.h>
#include <openexr.h>

#include "base/alloc.h"
#include "base/thread.h"

static void an_exr_comes_back_bit_for_bit(void **state)
{
    const char *path = lf_test_path(*state, "a.exr");
    lf_image32 image = {0};
    uint64_t seed = 3;
    assert_int_equal(lf_image32_init(&image, 53, 41, 3), LF_OK);
    for (int i = 0; i < 53 * 41 * 3; i++)
        image.data[i] = (float)lf_picture_random(&seed) * 1e-9f - 0.5f;
    const float special[] = {0, -0.0f, 1e-42f, -3e38f, 3e38f, 1e-38f, 65504.5f};
    memcpy(image.data, special, sizeof special);
    const lf_attribute attributes[] = {
        {"integrator", "mvpt"}, {"a_name_of_more_than_thirty_one_characters", "W\xc3\xb6lkchen"}};
    lf_picture_save_exr(path, &image, attributes, 2);
    lf_image32 back = lf_picture_load32(path);
    assert_int_equal(back.width, 53);
    assert_int_equal(back.height, 41);
    assert_memory_equal(back.data, image.data, 53 * 41 * 3 * sizeof(float));
    lf_image32_finish(&back);
    ImfInputFile *file = ImfOpenInputFile(path);
    assert_non_null(file);
    const char *value;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ImfHeaderStringAttribute(ImfInputHeader(file), attributes[i].name, &value),
                         1);
        assert_string_equal(value, attributes[i].value);
    }
    ImfCloseInputFile(file);
    const char *second = lf_test_path(*state, "b.exr");
    lf_picture_save_exr(second, &image, attributes, 2);
    size_t n[2];
    char *bytes[2] = {lf_picture_bytes(path, &n[0]), lf_picture_bytes(second, &n[1])};
    assert_int_equal(n[0], n[1]);
    assert_memory_equal(bytes[0], bytes[1], n[0]);
    lf_free(bytes[0]);
    lf_free(bytes[1]);
    lf_image32_finish(&image);
}

/* OpenEXRCore 3.1 writes a block that shrinks by nothing in a way that no reader understands; about
 * one in a hundred of these is such a one. */
static void blocks_whose_compressed_bytes_are_as_many_as_the_plain_come_back(void **state)
{
    const char *path = lf_test_path(*state, "block.exr");
    uint64_t seed = 4;
    for (int width = 4; width < 16; width++) {
        for (int n = 0; n <= 12 * width; n++) {
            lf_image32 image = {0};
            assert_int_equal(lf_image32_init(&image, width, 1, 3), LF_OK);
            for (int i = 0; i < n; i++)
                ((uint8_t *)image.data)[i] = (uint8_t)(lf_picture_random(&seed) & 0x3f);
            lf_picture_save_exr(path, &image, NULL, 0);
            lf_image32 back = lf_picture_load32(path);
            assert_memory_equal(back.data, image.data, (size_t)width * 12);
            lf_image32_finish(&back);
            lf_image32_finish(&image);
        }
    }
}

static float half_of(float value)
{
    ImfHalf half;
    ImfFloatToHalf(value, &half);
    return ImfHalfToFloat(half);
}

/* 34 chunks, the last of 3 lines: more than are compressed at once. */
static void threads_write_the_bytes_of_one(void **state)
{
    const char *path = lf_test_path(*state, "threads.exr");
    lf_image32 image = {0};
    size_t n, other;
    assert_int_equal(lf_image32_init(&image, 37, 33 * 16 + 3, 3), LF_OK);
    for (int i = 0; i < 37 * image.height * 3; i++)
        image.data[i] = lf_picture_smooth(i / 3 % 37, i / 3 / 37, i % 3);
    lf_picture_save_exr(path, &image, NULL, 0);
    char *alone = lf_picture_bytes(path, &n);
    for (int threads = 1; threads <= 7; threads += threads == 1 ? 1 : 5) {
        lf_error err;
        lf_pool *pool;
        lf_outfile file;
        lf_assert_ok(lf_pool_create(threads, &pool), NULL);
        lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
        file.pool = pool;
        lf_assert_ok(lf_exr_write(&file, &image, NULL, 0, &err), &err);
        lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
        char *together = lf_picture_bytes(path, &other);
        assert_int_equal(other, n);
        assert_memory_equal(together, alone, n);
        lf_free(together);
        file = (lf_outfile){.fd = open("/dev/full", O_WRONLY | O_CLOEXEC), .borrowed = true};
        file.pool = pool;
        lf_assert_status(lf_exr_write(&file, &image, NULL, 0, &err), LF_E_IO, &err);
        lf_outfile_abandon(&file);
        lf_pool_destroy(pool);
    }
    lf_free(alone);
    lf_image32_finish(&image);
}

/* What make_half_exr put into the data window, and black around it. */
static void assert_windowed(const char *path, const int display[4], const int data[4],
                            double tolerance)
{
    lf_image32 image = lf_picture_load32(path);
    assert_int_equal(image.width, display[2] - display[0] + 1);
    assert_int_equal(image.height, display[3] - display[1] + 1);
    for (int i = 0; i < image.width * image.height; i++) {
        int x = display[0] + i % image.width, y = display[1] + i / image.width;
        bool inside = x >= data[0] && x <= data[2] && y >= data[1] && y <= data[3];
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)image.data[3 * i + c],
                            inside ? (double)half_of(lf_picture_smooth(x, y, c)) : 0, 0, tolerance);
    }
    lf_image32_finish(&image);
}

static void every_compression_is_read_in_lines_and_tiles(void **state)
{
    const char *path = lf_test_path(*state, "c.exr");
    /* over DWAB's 256 lines, and no multiple of a block's or tile's side */
    const int window[4] = {0, 0, 96, 298};
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; compression++) {
        bool lossy = compression >= IMF_B44_COMPRESSION;
        for (int tiled = 0; tiled < 2; tiled++) {
            lf_picture_half_exr(path, window, window, compression, IMF_WRITE_RGBA, tiled);
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
            lf_picture_half_exr(path, window, window, compression, IMF_WRITE_RGB, k % 2);
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
            lf_picture_half_exr(path, windows[i][0], windows[i][1], compressions[k / 2],
                                IMF_WRITE_RGB, k % 2);
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
        lf_picture_half_exr(path, window, window, compressions[k], IMF_WRITE_Y, false);
        lf_image32 image = lf_picture_load32(path);
        for (int i = 0; i < 64 * 48; i++) {
            double r = (double)lf_picture_smooth(i % 64, i / 64, 0),
                   g = (double)lf_picture_smooth(i % 64, i / 64, 1),
                   b = (double)lf_picture_smooth(i % 64, i / 64, 2);
            lf_assert_close((double)image.data[3 * i], 0.2126 * r + 0.7152 * g + 0.0722 * b, 0.02,
                            0);
            assert_true(image.data[3 * i] == image.data[3 * i + 1] &&
                        image.data[3 * i] == image.data[3 * i + 2]);
        }
        lf_image32_finish(&image);
        lf_picture_half_exr(path, window, window, compressions[k], IMF_WRITE_YC, false);
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

/* Files by the Core, with other types and names of channels than the C interface of the C++ library
 * writes. */
static void make_core_exr(const char *path, const char *const names[], int n, exr_pixel_type_t type,
                          exr_compression_t compression)
{
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t exr;
    int part;
    int32_t lines;
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup), EXR_ERR_SUCCESS);
    assert_int_equal(exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part), EXR_ERR_SUCCESS);
    assert_int_equal(
        exr_initialize_required_attr_simple(exr, part, CORE_WIDTH, CORE_HEIGHT, compression),
        EXR_ERR_SUCCESS);
    for (int c = 0; c < n; c++)
        assert_int_equal(exr_add_channel(exr, part, names[c], type, EXR_PERCEPTUALLY_LINEAR, 1, 1),
                         EXR_ERR_SUCCESS);
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
                whole[c][i] = core_value(encode.channels[c].channel_name[0], i % CORE_WIDTH,
                                         y + i / CORE_WIDTH);
                real[c][i] = (float)whole[c][i] + 0.25f;
            }
            encode.channels[c].encode_from_ptr =
                type == EXR_PIXEL_UINT ? (const uint8_t *)whole[c] : (const uint8_t *)real[c];
            encode.channels[c].user_pixel_stride = 4;
            encode.channels[c].user_line_stride = 4 * CORE_WIDTH;
        }
        if (y == 0)
            assert_int_equal(exr_encoding_choose_default_routines(exr, part, &encode),
                             EXR_ERR_SUCCESS);
        assert_int_equal(exr_encoding_run(exr, part, &encode), EXR_ERR_SUCCESS);
    }
    exr_encoding_destroy(exr, &encode);
    assert_int_equal(exr_finish(&exr), EXR_ERR_SUCCESS);
}

/* Channels names[0..2] of such a file, up to a relative error. */
static void assert_core_values(const char *path, const char *names, double add, double tolerance)
{
    lf_image32 image = lf_picture_load32(path);
    assert_int_equal(image.width, CORE_WIDTH);
    assert_int_equal(image.height, CORE_HEIGHT);
    for (int i = 0; i < CORE_WIDTH * CORE_HEIGHT; i++)
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)image.data[3 * i + c],
                            core_value(names[c], i % CORE_WIDTH, i / CORE_WIDTH) + add, tolerance,
                            0);
    lf_image32_finish(&image);
}

static void channels_are_found_by_name_and_converted(void **state)
{
    const char *path = lf_test_path(*state, "n.exr");
    const char *const all[] = {"A", "B", "G", "R", "Y", "Z"}, *const grey[] = {"A", "Y"};
    for (exr_compression_t compression = EXR_COMPRESSION_NONE; compression <= EXR_COMPRESSION_PXR24;
         compression++) {
        /* 24 bits of a float */
        double tolerance = compression == EXR_COMPRESSION_PXR24 ? 1.0 / 65536 : 0;
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

/* core_value tells channels by the first letter of their names. */
static void the_only_layer_or_channel_is_the_picture(void **state)
{
    const char *path = lf_test_path(*state, "n.exr");
    const char *const depth[] = {"Z"}, *const mask[] = {"A"}, *const clear[] = {"A", "M"},
                      *const layer[] = {"1.A", "1.B", "1.G", "1.R"},
                      *const normals[] = {"C.B", "C.G", "C.R", "N.X", "N.Y", "N.Z"},
                      *const luminance[] = {"l.Y", "m.u"};
    make_core_exr(path, depth, 1, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_core_values(path, "ZZZ", 0.25, 0);
    make_core_exr(path, mask, 1, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_core_values(path, "AAA", 0.25, 0);
    make_core_exr(path, clear, 2, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_core_values(path, "MMM", 0.25, 0);
    make_core_exr(path, layer, 4, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_core_values(path, "111", 0.25, 0);
    make_core_exr(path, normals, 6, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_core_values(path, "CCC", 0.25, 0);
    make_core_exr(path, luminance, 2, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    assert_core_values(path, "lll", 0.25, 0);
}

static void an_exr_of_several_pictures_is_refused_with_their_names(void **state)
{
    const char *path = lf_test_path(*state, "n.exr");
    const char *const two[] = {"G", "R"}, *const normals[] = {"N.X", "N.Y", "N.Z"},
                      *const layers[] = {"a.B", "a.G", "a.R", "b.B", "b.G", "b.R"};
    make_core_exr(path, two, 2, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    lf_picture_refused(path, "none of the channels R, G, B and Y; found G, R;");
    make_core_exr(path, normals, 3, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    lf_picture_refused(path, "found N.X, N.Y, N.Z;");
    make_core_exr(path, layers, 6, EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP);
    lf_picture_refused(path, "found a.B, a.G, a.R, b.B, b.G, b.R;");
}

/* A float may be larger than any half: infinity is then as bright as the brightest. */
static void what_is_not_finite_is_clamped(void **state)
{
    const char *path = lf_test_path(*state, "nan.exr");
    const float bad[] = {NAN, INFINITY, -INFINITY}, good[][3] = {{0, 65504, 0}, {0, 3e38f, 0}};
    for (int k = 0; k < 2; k++) {
        lf_image32 image = {0};
        assert_int_equal(lf_image32_init(&image, 5, 4, 3), LF_OK);
        memcpy(image.data + (2 * 5 + 3) * 3, bad, sizeof bad);
        image.data[0] = k ? 3e38f : 7;
        image.data[1] = -3e38f;
        lf_picture_save_exr(path, &image, NULL, 0);
        lf_image32 back = lf_picture_load32(path);
        memcpy(image.data + (2 * 5 + 3) * 3, good[k], sizeof good[k]);
        assert_memory_equal(back.data, image.data, 5 * 4 * 3 * sizeof(float));
        lf_image32_finish(&back);
        lf_image32_finish(&image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_write_the_bytes_of_one),
        cmocka_unit_test(an_exr_comes_back_bit_for_bit),
        cmocka_unit_test(blocks_whose_compressed_bytes_are_as_many_as_the_plain_come_back),
        cmocka_unit_test(every_compression_is_read_in_lines_and_tiles),
        cmocka_unit_test(pictures_of_every_small_size_are_read),
        cmocka_unit_test(the_data_window_is_placed_in_the_display_window),
        cmocka_unit_test(luminance_and_chroma_are_read),
        cmocka_unit_test(channels_are_found_by_name_and_converted),
        cmocka_unit_test(the_only_layer_or_channel_is_the_picture),
        cmocka_unit_test(an_exr_of_several_pictures_is_refused_with_their_names),
        cmocka_unit_test(what_is_not_finite_is_clamped),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
