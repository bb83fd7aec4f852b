/* Images on their way: sizes that are asked for, headers, and what quiltd may say of them. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "daemon/web/image.h"
#include "daemon/web/memory.h"

enum { COARSE = 1, COMPLETE = 2, CONVERGED = 3 };

static lf_web_image rendered(int columns, int rows, int width_px, int height_px)
{
    return (lf_web_image){.columns = columns,
                          .rows = rows,
                          .views = columns * rows,
                          .width_px = width_px,
                          .height_px = height_px};
}

static void levels_have_numbers(void **state)
{
    (void)state;
    assert_int_equal(lf_web_image_level("none"), 0);
    assert_int_equal(lf_web_image_level("coarse"), COARSE);
    assert_int_equal(lf_web_image_level("complete"), COMPLETE);
    assert_int_equal(lf_web_image_level("converged"), CONVERGED);
    assert_int_equal(lf_web_image_level("other"), 0);
    assert_int_equal(lf_web_image_level(NULL), 0);
}

static void images_are_half_as_wide_until_they_are_complete(void **state)
{
    (void)state;
    lf_web_image p = rendered(5, 9, 420, 560), unknown = {0};
    assert_int_equal(lf_web_image_width(&unknown, COARSE), 0);
    assert_int_equal(lf_web_image_width(&p, COARSE), 192); /* 256 high */
    p = rendered(5, 9, 401, 560);
    assert_int_equal(lf_web_image_width(&p, COARSE), 192); /* no height is a multiple of 8 */
    p = rendered(5, 9, 420, 560);
    /* 9 x 560 is above 4096: 455 pixels a view, 341 wide */
    assert_int_equal(lf_web_image_width(&p, COMPLETE), 336);
    p = rendered(5, 7, 420, 560);
    assert_int_equal(lf_web_image_width(&p, COMPLETE), 0);
    assert_int_equal(lf_web_image_width(&p, CONVERGED), 0);
    p = rendered(8, 6, 1024, 1024);
    assert_int_equal(lf_web_image_width(&p, COMPLETE), 512);
    assert_int_equal(lf_web_image_width(&p, COARSE), 512);
    p = rendered(1, 1, 9, 9);
    assert_int_equal(lf_web_image_width(&p, COARSE), 4);
    p = rendered(1, 1, 1, 1);
    assert_int_equal(lf_web_image_width(&p, COARSE), 1);
}

static void smaller_copies_are_like_the_rendered_image(void **state)
{
    (void)state;
    const lf_web_image p = rendered(5, 9, 421, 560);
    for (int width = 1; width <= 421; width++) {
        const lf_web_image down = rendered(5, 9, width, width * 560 / 421);
        const lf_web_image up = rendered(5, 9, width, (width * 560 + 420) / 421);
        assert_true(lf_web_image_is_like(&down, &p));
        assert_true(lf_web_image_is_like(&up, &p));
    }
    const lf_web_image others[] = {rendered(6, 9, 192, 256), rendered(5, 8, 192, 256),
                                   rendered(5, 9, 192, 192), rendered(5, 9, 192, 300)};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        assert_false(lf_web_image_is_like(&others[i], &p));
}

static void no_quilt_is_larger_than_a_texture(void **state)
{
    (void)state;
    for (int columns = 1; columns <= 16; columns++)
        for (int rows = 1; rows <= 16; rows++)
            for (int width = 16; width <= 4096; width *= 2) {
                lf_web_image p = rendered(columns, rows, width, width * 3 / 4);
                for (int level = COARSE; level <= CONVERGED; level++) {
                    int w = lf_web_image_width(&p, level);
                    w = w == 0 ? width : w;
                    assert_true(w <= width);
                    assert_true(w * columns <= LF_WEB_IMAGE_MAX_SIDE);
                    assert_true(w * 3 / 4 * rows <= LF_WEB_IMAGE_MAX_SIDE);
                }
            }
}

static void a_header_is_little_endian(void **state)
{
    (void)state;
    static const uint8_t expected[LF_WEB_IMAGE_HEADER] = {
        0x04, 0x03, 0x02, 0x01, 3, 1, 0x06, 0x05, 0x08, 0x07, 0x0a, 0x09, 0x0c, 0x0b, 0x0e, 0x0d};
    const lf_web_image p = {.generation = 0x01020304,
                            .level = CONVERGED,
                            .columns = 0x0506,
                            .rows = 0x0708,
                            .views = 0x090a,
                            .width_px = 0x0b0c,
                            .height_px = 0x0d0e};
    uint8_t header[LF_WEB_IMAGE_HEADER];
    lf_web_image_header(&p, header);
    assert_memory_equal(header, expected, sizeof header);
}

static json_t *result_of(int bytes)
{
    return json_pack("{s:i, s:s, s:i, s:i, s:i, s:i, s:i, s:i}", "generation", 5, "level", "coarse",
                     "columns", 2, "rows", 1, "views", 2, "width", 30, "height", 40, "bytes",
                     bytes);
}

static void a_message_is_the_header_and_the_file(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_web_image p;
    uint8_t *data = NULL;
    size_t n = 0;
    int fd = -1;
    json_t *result = result_of(5);
    lf_assert_ok(lf_memory_create(&fd, &err), &err);
    assert_int_equal(write(fd, "image", 5), 5);
    lf_assert_ok(lf_web_image_read(result, fd, &p, &err), &err);
    assert_int_equal(p.generation, 5);
    assert_int_equal(p.level, COARSE);
    assert_int_equal(p.width_px, 30);
    lf_assert_ok(lf_web_image_message(&p, fd, &data, &n, &err), &err);
    assert_int_equal(n, LF_WEB_IMAGE_HEADER + 5);
    assert_memory_equal(data + LF_WEB_IMAGE_HEADER, "image", 5);
    lf_free(data);
    json_decref(result);
    close(fd);
}

static void results_that_cannot_be_are_refused(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_web_image p;
    int fd = -1;
    static const char *const keys[] = {"columns", "rows", "views", "width", "height", "bytes"};
    lf_assert_ok(lf_memory_create(&fd, &err), &err);
    assert_int_equal(write(fd, "image", 5), 5);
    json_t *result = result_of(4);
    lf_assert_status(lf_web_image_read(result, fd, &p, &err), LF_E_FORMAT, &err);
    json_decref(result);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        for (int k = 0; k < 4; k++) {
            result = result_of(5);
            if (k == 3)
                json_object_del(result, keys[i]);
            else
                json_object_set_new(result, keys[i],
                                    k == 0   ? json_integer(0)
                                    : k == 1 ? json_integer((json_int_t)1 << 40)
                                             : json_string("5"));
            lf_assert_status(lf_web_image_read(result, fd, &p, &err), LF_E_FORMAT, &err);
            json_decref(result);
        }
    }
    close(fd);
}

/* A file that shrinks after the answer, and one that no browser should get. */
static void a_file_that_is_not_there_is_no_message(void **state)
{
    (void)state;
    lf_error err = {0};
    uint8_t *data = NULL;
    size_t n = 0;
    int fd = -1;
    lf_web_image p = {.bytes = 5};
    lf_assert_ok(lf_memory_create(&fd, &err), &err);
    lf_assert_status(lf_web_image_message(&p, fd, &data, &n, &err), LF_E_IO, &err);
    p.bytes = LF_WEB_IMAGE_MAX_BYTES + 1;
    lf_assert_status(lf_web_image_message(&p, fd, &data, &n, &err), LF_E_NOMEM, &err);
    assert_null(data);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_have_numbers),
        cmocka_unit_test(images_are_half_as_wide_until_they_are_complete),
        cmocka_unit_test(smaller_copies_are_like_the_rendered_image),
        cmocka_unit_test(no_quilt_is_larger_than_a_texture),
        cmocka_unit_test(a_header_is_little_endian),
        cmocka_unit_test(a_message_is_the_header_and_the_file),
        cmocka_unit_test(results_that_cannot_be_are_refused),
        cmocka_unit_test(a_file_that_is_not_there_is_no_message),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
