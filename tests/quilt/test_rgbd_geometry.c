/* The geometry of pictures with depth: depth beyond the limit, fewer cameras, turns, quilts; and
 * depth halves without depth. */
#include "tests/testing.h"

#include "quilt/rgbd.h"

static const lf_standing standing = {.zoom = 1, .depthiness = 1};

/* A file of 8 centred cameras over 20 degrees. */
static lf_image_metadata file_of(double near)
{
    return (lf_image_metadata){.depth = {.near = near,
                                         .far = 9,
                                         .distance = 4,
                                         .fov_y = 30,
                                         .aspect = 0.75,
                                         .cone = 20,
                                         .views = 8,
                                         .centred = 1}};
}

static double degrees(double angle)
{
    return angle * M_PI / 180;
}

/* The code of the plane in the glass is the file's, or near and far points move the wrong way. */
static void too_much_depth_is_flattened_about_the_glass(void **state)
{
    (void)state;
    const double window = tan(degrees(15)) * 0.75, line = tan(degrees(10));
    for (double near = 0.2; near < 3; near += 0.1) {
        const lf_image_metadata meta = file_of(near);
        const lf_rgbd rgbd = lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, &meta);
        const double depth = 1 / near - 1 / 9.0, disparity = line / window * 4 * depth;
        assert_true(rgbd.is_known);
        assert_int_equal(rgbd.is_flattened, disparity > 4);
        lf_assert_close(rgbd.disparity, fmin(disparity, 4), 1e-12, 0);
        lf_assert_close(rgbd.plane, (1 / 4.0 - 1 / 9.0) / depth, 1e-12, 0);
    }
    const lf_image_metadata deep = file_of(0.2), shallow = file_of(2);
    assert_true(lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, &deep).is_flattened);
    assert_false(lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, &shallow).is_flattened);
}

/* Cameras of half the angle see the point where pinholes there see it. */
static void fewer_degrees_leave_the_pictures_camera_in_place(void **state)
{
    (void)state;
    const lf_image_metadata meta = file_of(2.5);
    lf_rgbd rgbd = lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, &meta);
    const double own = 4 * tan(degrees(20) * (4.5 / 8 - 0.5)), window = 8 * tan(degrees(15)) * 0.75;
    lf_rgbd_narrow(&rgbd, 0.5);
    for (int view = 0; view < 5; view++)
        for (double z = 2.5; z <= 9; z += 0.5) {
            const double b = 4 * tan(degrees(10) * ((view + 0.5) / 5 - 0.5)),
                         code = (1 / z - 1 / 9.0) / (1 / 2.5 - 1 / 9.0);
            lf_assert_close(lf_rgbd_shift(&rgbd, view, 5, code), (b - own) * (1 - 4 / z) / window,
                            1e-9, 1e-12);
        }
    rgbd = lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, NULL);
    lf_rgbd_narrow(&rgbd, 0.5);
    lf_assert_close(rgbd.disparity, 1.0 / 18, 1e-12, 0);
}

static void a_turned_picture_has_its_cameras_along_its_new_width(void **state)
{
    (void)state;
    const lf_image_metadata meta = file_of(2.5);
    const lf_rgbd upright = lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, &meta);
    assert_true(upright.offset > 0.01);
    for (int orientation = 1; orientation <= 8; orientation++) {
        lf_rgbd rgbd = upright, unknown = lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, NULL);
        const bool is_mirrored = orientation == 2 || orientation == 3;
        lf_rgbd_turn(&rgbd, orientation, 0.75);
        lf_rgbd_turn(&unknown, orientation, 0.75);
        lf_assert_close(unknown.disparity, 1.0 / 9, 1e-12, 0);
        lf_assert_close(rgbd.plane, upright.plane, 1e-12, 0);
        /* the same length in space; the new width is the height */
        lf_assert_close(rgbd.disparity, upright.disparity * (orientation > 4 ? 0.75 : 1), 1e-12, 0);
        lf_assert_close(rgbd.offset,
                        orientation > 4 ? 0
                        : is_mirrored   ? -upright.offset
                                        : upright.offset,
                        1e-12, 0);
    }
}

static void a_quilt_with_depth_tells_itself(void **state)
{
    (void)state;
    lf_image_depth depth = {.views = 4};
    assert_int_equal(lf_rgbd_tiles(&depth, 120, 160), 1); /* a file that does not say */
    depth.width = 60;
    depth.height = 80;
    assert_int_equal(lf_rgbd_tiles(&depth, 60, 80), 1);
    assert_int_equal(lf_rgbd_tiles(&depth, 120, 160), 4);
    assert_int_equal(lf_rgbd_tiles(&depth, 240, 80), 4);
    assert_int_equal(lf_rgbd_tiles(&depth, 120, 80), 1); /* too few for a quilt of four */
    assert_int_equal(lf_rgbd_tiles(&depth, 121, 160), 1);
    assert_int_equal(lf_rgbd_tiles(&depth, 30, 40), 1);
    depth.views = 5; /* a tile may be unused */
    assert_int_equal(lf_rgbd_tiles(&depth, 180, 160), 6);
}

/* ------------------------------------------------------------------------------------- looks -- */

enum { SIDE = 40 };

static uint8_t pixels[4 * SIDE * SIDE * 3];

/* A picture of bright colours with a depth of code 90. */
static lf_rgbd_picture flat_picture(lf_rgbd_in side)
{
    const bool beside = side == LF_RGBD_IN_RIGHT || side == LF_RGBD_IN_LEFT,
               first = side == LF_RGBD_IN_LEFT || side == LF_RGBD_IN_TOP;
    const int width = beside ? 2 * SIDE : SIDE, height = beside ? SIDE : 2 * SIDE;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const bool is_second = (beside ? x : y) >= SIDE;
            memset(pixels + 3 * (y * width + x), is_second == first ? 200 : 90, 3);
        }
    return (lf_rgbd_picture){width, height, 3 * (size_t)width, pixels, 0};
}

/* Sets the code of the depth half n pixels from the colours. */
static void set_code(const lf_rgbd_picture *p, lf_rgbd_in side, int n, int code)
{
    const int x = side == LF_RGBD_IN_RIGHT  ? SIDE + n
                  : side == LF_RGBD_IN_LEFT ? SIDE - 1 - n
                                            : 7,
              y = side == LF_RGBD_IN_BOTTOM ? SIDE + n
                  : side == LF_RGBD_IN_TOP  ? SIDE - 1 - n
                                            : 7;
    memset(pixels + (size_t)y * p->stride + 3 * x, code, 3);
}

static void a_depth_of_one_code_is_flat_though_jpeg_blurs_its_seam(void **state)
{
    (void)state;
    for (lf_rgbd_in side = LF_RGBD_IN_RIGHT; side <= LF_RGBD_IN_BOTTOM; side++) {
        const lf_rgbd rgbd = {.side = side};
        const lf_rgbd_picture p = flat_picture(side);
        assert_true(lf_rgbd_look_at(&rgbd, &p).is_flat);
        set_code(&p, side, 0, 130); /* a block of 16 pixels may lie across the seam */
        set_code(&p, side, 15, 100);
        set_code(&p, side, SIDE - 1, 92);
        assert_true(lf_rgbd_look_at(&rgbd, &p).is_flat);
        set_code(&p, side, 16, 93);
        assert_false(lf_rgbd_look_at(&rgbd, &p).is_flat);
        set_code(&p, side, 16, 90);
        set_code(&p, side, SIDE - 1, 87);
        assert_false(lf_rgbd_look_at(&rgbd, &p).is_flat);
    }
}

/* A small depth half has no inner part: all of it counts. */
static void a_small_depth_has_no_seam(void **state)
{
    (void)state;
    uint8_t data[64 * 3];
    const lf_rgbd rgbd = {.side = LF_RGBD_IN_RIGHT};
    const lf_rgbd_picture p = {64, 1, sizeof data, data, 0};
    memset(data, 90, sizeof data);
    assert_true(lf_rgbd_look_at(&rgbd, &p).is_flat);
    memset(data + 3 * 33, 130, 3);
    assert_false(lf_rgbd_look_at(&rgbd, &p).is_flat);
}

/* A plane that quiltd wrote is a picture with depth. */
static void a_plane_of_known_geometry_is_drawn(void **state)
{
    (void)state;
    const lf_rgbd_picture p = flat_picture(LF_RGBD_IN_RIGHT);
    lf_raster raster = {
        .width = p.width, .height = p.height, .data8 = pixels, .meta = file_of(2.5)};
    const lf_photo photo = {0};
    lf_rgbd_file file;
    lf_error err = {0};
    lf_assert_ok(lf_rgbd_file_take(&raster, "p", &standing, LF_RGBD_IN_RIGHT, &photo, &file, &err),
                 &err);
    assert_int_equal(file.notes.length, 0);
    raster.meta = file_of(0.2);
    lf_assert_ok(lf_rgbd_file_take(&raster, "p", &standing, LF_RGBD_IN_RIGHT, &photo, &file, &err),
                 &err);
    assert_non_null(strstr(file.notes.text, "too deep"));
    raster.meta.depth.width = SIDE / 4.0;
    raster.meta.depth.height = SIDE / 2.0;
    assert_int_equal(
        lf_rgbd_file_take(&raster, "p", &standing, LF_RGBD_IN_RIGHT, &photo, &file, &err),
        LF_E_FORMAT);
    assert_non_null(strstr(err.what, "quilt of 8 views"));
    raster.meta = (lf_image_metadata){0};
    assert_int_equal(
        lf_rgbd_file_take(&raster, "p", &standing, LF_RGBD_IN_RIGHT, &photo, &file, &err),
        LF_E_FORMAT);
    assert_non_null(strstr(err.what, "has no depth"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(too_much_depth_is_flattened_about_the_glass),
        cmocka_unit_test(fewer_degrees_leave_the_pictures_camera_in_place),
        cmocka_unit_test(a_turned_picture_has_its_cameras_along_its_new_width),
        cmocka_unit_test(a_quilt_with_depth_tells_itself),
        cmocka_unit_test(a_depth_of_one_code_is_flat_though_jpeg_blurs_its_seam),
        cmocka_unit_test(a_small_depth_has_no_seam),
        cmocka_unit_test(a_plane_of_known_geometry_is_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
