/* Picture files of all formats: which it is, where they may lie, and whatever their bytes are. */
#include "tests/base/pictures.h"

#include <fcntl.h>

#include "base/alloc.h"

static void shapes_over_the_limits_are_refused(void **state)
{
    (void)state;
    lf_image8 a = {0};
    lf_image32 b = {0};
    const int bad[][3] = {{0, 1, 3}, {1, 0, 3}, {65537, 1, 3},     {1, 65537, 1},
                          {1, 1, 0}, {1, 1, 5}, {65536, 65536, 3}, {-4, 4, 3}};
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

static void kinds_are_told_by_contents(void **state)
{
    const char *path = lf_test_path(*state, "misnamed.txt");
    lf_image8 image = lf_picture_noise(4, 4);
    lf_image_kind kind;
    lf_error err;
    lf_picture_save_png(path, &image, 1, NULL, 0);
    lf_assert_ok(lf_image_probe(path, NULL, &kind, &err), &err);
    assert_int_equal(kind, LF_IMAGE_8BIT);
    const int window[4] = {0, 0, 3, 3};
    lf_picture_half_exr(path, window, window, IMF_ZIP_COMPRESSION, IMF_WRITE_RGB, false);
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

static void formats_that_are_not_read_are_named(void **state)
{
    static const struct {
        const char *head, *name;
    } cases[] = {{"II*\0........", "TIFF"},
                 {"MM\0*........", "TIFF"},
                 {"RIFF....WEBP", "WebP"},
                 {"\0\0\0\x18"
                  "ftypheic",
                  "HEIC"},
                 {"\0\0\0\x18"
                  "ftypmif1",
                  "HEIC"},
                 {"\0\0\0\x18"
                  "ftypavif",
                  "AVIF"},
                 {"\0\0\0\x18"
                  "ftypisom",
                  NULL},
                 {"XXXX....WEBP", NULL},
                 {"RIFF....AVI ", NULL}};
    char words[64];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *name = lf_image_foreign((const uint8_t *)cases[i].head, 12);
        assert_string_equal(name ? name : "", cases[i].name ? cases[i].name : "");
        assert_null(lf_image_foreign((const uint8_t *)cases[i].head, 3));
        FILE *file = fopen(lf_test_path(*state, "foreign.png"), "w");
        assert_non_null(file);
        assert_int_equal(fwrite(cases[i].head, 1, 12, file), 12);
        assert_int_equal(fclose(file), 0);
        lf_image_kind kind;
        lf_error err;
        const char *path = lf_test_path(*state, "foreign.png");
        assert_int_equal(lf_image_is_foreign(path, NULL), !!name);
        lf_assert_status(lf_image_probe(path, NULL, &kind, &err), LF_E_FORMAT, &err);
        snprintf(words, sizeof words, "is a %s image", name ? name : "");
        assert_non_null(strstr(err.what, name ? words : "not an image"));
    }
    assert_false(lf_image_is_foreign(lf_test_path(*state, "none.png"), NULL));
}

static void pictures_outside_the_roots_are_not_read(void **state)
{
    const char *path = lf_test_path(*state, "a.png");
    lf_image8 image = lf_picture_noise(4, 4), back = {0};
    lf_picture_save_png(path, &image, 1, NULL, 0);
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
    lf_image8 image = lf_picture_noise(300, 300);
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
    lf_image8 image = lf_picture_noise(8, 8);
    lf_picture_save_png(path, &image, 1, NULL, 0);
    size_t n;
    char *data = lf_picture_bytes(path, &n);
    /* 16392 x 16392; the checksum of the header is wrong as well, so make it right */
    data[18] = data[22] = 0x40;
    uint32_t crc = 0xffffffff;
    for (int i = 12; i < 29; i++) {
        crc ^= (unsigned char)data[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    for (int i = 0; i < 4; i++)
        data[29 + i] = (char)(~crc >> (24 - 8 * i));
    lf_picture_write(path, data, n);
    lf_picture_refused(path, "16392x16392");
    lf_free(data);
    lf_image8_finish(&image);
    const int display[4] = {0, 0, 20000, 20000}, window[4] = {0, 0, 3, 3};
    lf_picture_half_exr(path, display, window, IMF_ZIP_COMPRESSION, IMF_WRITE_RGB, false);
    lf_picture_refused(path, "20001x20001");
}

/* Whatever becomes of a file's bytes: pixels or one clear line. Seen under the sanitizers as well.
 */
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
            length = lf_picture_random(&seed) % n;
        size_t reach = round % 3 == 0 ? n : n < 400 ? n : 400; /* headers are where the harm is */
        for (uint32_t k = 1 + lf_picture_random(&seed) % 4; round % 4 && k > 0; k--)
            copy[lf_picture_random(&seed) % reach] = (char)lf_picture_random(&seed);
        lf_picture_write(path, copy, length);
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
    lf_image8 image = lf_picture_noise(31, 17);
    size_t n;
    lf_picture_save_png(path, &image, 6, NULL, 0);
    char *data = lf_picture_bytes(path, &n);
    assert_true(fuzz(path, data, n, rounds) > rounds / 4);
    lf_free(data);
    lf_image8_finish(&image);
    lf_picture_jpeg(path, 50, 40, 3, JCS_RGB);
    data = lf_picture_bytes(path, &n);
    assert_true(fuzz(path, data, n, rounds) > rounds / 10);
    lf_free(data);
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; compression++) {
        bool tiled = compression % 2;
        lf_picture_half_exr(path, window, window, compression,
                            tiled || compression % 3 ? IMF_WRITE_RGBA : IMF_WRITE_YC, tiled);
        data = lf_picture_bytes(path, &n);
        assert_true(fuzz(path, data, n, rounds / 4) > rounds / 40);
        lf_free(data);
    }
    char hdr[512];
    n = lf_picture_hdr_header(hdr, "-Y 20 +X 4", "EXPOSURE=1\n");
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
        lf_image32 image = lf_picture_load32(path);
        assert_int_equal(image.width, files[i].width);
        assert_int_equal(image.height, files[i].height);
        double sum = 0;
        for (int k = 0; k < image.width * image.height * 3; k++)
            sum += (double)image.data[k];
        lf_assert_close(sum / (image.width * image.height * 3), files[i].mean, 1e-4, 0);
        lf_image32_finish(&image);
    }
}

static void endings_are_those_of_the_formats(void **state)
{
    (void)state;
    static const char *const pictures[] = {".png", ".jpg", ".JPEG", ".exr", ".Hdr"};
    static const char *const others[] = {"a.tif", "png", "a.png.json", "exr.", "a.hdr/b", ""};
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++) {
        const char *path = lf_test_path("/a.b/c", pictures[i]), *ending = lf_image_ending(path);
        assert_ptr_equal(ending, path + strlen("/a.b/c/"));
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        assert_null(lf_image_ending(others[i]));
    assert_string_equal(lf_image_float_ending(0), "exr");
    assert_string_equal(lf_image_float_ending(1), "hdr");
    assert_null(lf_image_float_ending(2));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_over_the_limits_are_refused),
        cmocka_unit_test(kinds_are_told_by_contents),
        cmocka_unit_test(formats_that_are_not_read_are_named),
        cmocka_unit_test(endings_are_those_of_the_formats),
        cmocka_unit_test(pictures_outside_the_roots_are_not_read),
        cmocka_unit_test(a_full_disk_is_an_error_of_io),
        cmocka_unit_test(headers_that_claim_too_much_are_refused),
        cmocka_unit_test(damaged_files_give_pixels_or_a_clear_line),
        cmocka_unit_test(real_pictures_are_read),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
