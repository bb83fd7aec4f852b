/* Pictures with depth as views: against closed forms. test_rgbd_steps has what hides what. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/rgbd.h"

enum { WIDTH = 160, HEIGHT = 3, VIEWS = 9, PIXELS = WIDTH * HEIGHT };

/* A picture whose rows are equal, unless the test changes it: colours and codes per column. */
typedef struct fixture {
    uint8_t colour[WIDTH][3];
    double code[WIDTH];
    uint8_t data[HEIGHT * 2 * WIDTH * 3];
    uint8_t views[VIEWS][HEIGHT][WIDTH][3];
} fixture;

static fixture f;

static lf_layout layout_of(int n_views, int width, int height)
{
    return (lf_layout){.columns = n_views,
                       .rows = 1,
                       .n_views = n_views,
                       .view_width = width,
                       .view_height = height,
                       .aspect = (double)width / height};
}

static lf_rgbd rgbd_of(double disparity, double plane)
{
    return (lf_rgbd){.side = LF_RGBD_IN_RIGHT, .disparity = disparity, .plane = plane, .zoom = 1};
}

static lf_rgbd_picture draw_picture(void)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            uint8_t *to = f.data + 3 * (y * 2 * WIDTH + x);
            memcpy(to, f.colour[x], 3);
            memset(to + 3 * WIDTH, (int)lround(255 * f.code[x]), 3);
        }
    return (lf_rgbd_picture){2 * WIDTH, HEIGHT, 3 * 2 * WIDTH, f.data, 0};
}

static void draw(const lf_rgbd *rgbd)
{
    const lf_rgbd_picture picture = draw_picture();
    const lf_layout layout = layout_of(VIEWS, WIDTH, HEIGHT);
    lf_error err;
    lf_assert_ok(lf_rgbd_views(rgbd, &picture, &layout, NULL, "p", &f.views[0][0][0][0], &err),
                 &err);
}

/* How far a code moves in a view, in pixels: the closed form. */
static double shift_of(double disparity, double plane, int view, double code)
{
    return ((double)view / (VIEWS - 1) - 0.5) * disparity * WIDTH * (plane - code);
}

/* ------------------------------------------------------------------------------------ a step -- */

enum { BLOCK = 60, BLOCK_END = 90 };

static double light_of(uint8_t code)
{
    const double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

/* The column at which a white block begins (end false) or ends: by the light of its pixels. */
static double edge_of(int view, bool end)
{
    int first = 0;
    double sum = 0;
    while (f.views[view][1][first][0] == 0)
        first++;
    for (int x = first; x < WIDTH && f.views[view][1][x][0] > 0; x++)
        sum += light_of(f.views[view][1][x][0]);
    const double start = first + 1 - light_of(f.views[view][1][first][0]);
    return end ? start + sum : start;
}

static void make_block(double block, double ground)
{
    for (int x = 0; x < WIDTH; x++) {
        const bool inside = x >= BLOCK && x < BLOCK_END;
        memset(f.colour[x], inside ? 255 : 0, 3);
        f.code[x] = inside ? block : ground;
    }
}

/* In front of the glass it moves against the cameras, behind it with them. */
static void a_step_moves_as_its_depth_says(void **state)
{
    (void)state;
    static const double planes[] = {0.5, 0.9, -0.3};
    make_block(204 / 255.0, 51 / 255.0);
    for (size_t p = 0; p < sizeof planes / sizeof *planes; p++) {
        const lf_rgbd rgbd = rgbd_of(0.09, planes[p]);
        double farthest = 0;
        draw(&rgbd);
        for (int view = 0; view < VIEWS; view++) {
            const double shift = shift_of(0.09, planes[p], view, 0.8);
            lf_assert_close(edge_of(view, false), BLOCK + shift, 0, 0.13);
            lf_assert_close(edge_of(view, true), BLOCK_END + shift, 0, 0.13);
            farthest = fmax(farthest, fabs(shift));
        }
        assert_true(farthest > 0.6); /* or any sign would do */
    }
}

static void focus_moves_all_depths_alike(void **state)
{
    (void)state;
    make_block(204 / 255.0, 51 / 255.0);
    lf_rgbd rgbd = rgbd_of(0.09, 0.5);
    rgbd.focus = 0.03;
    draw(&rgbd);
    for (int view = 0; view < VIEWS; view++) {
        const double focus = (2.0 * view / (VIEWS - 1) - 1) * 0.03 * WIDTH;
        lf_assert_close(edge_of(view, false), BLOCK + shift_of(0.09, 0.5, view, 0.8) + focus, 0,
                        0.13);
    }
    rgbd.focus = 0;
    for (int view = 0; view < VIEWS; view++)
        lf_assert_close(lf_rgbd_shift(&rgbd, view, VIEWS, 0.8) * WIDTH,
                        shift_of(0.09, 0.5, view, 0.8), 1e-12, 1e-12);
    lf_assert_close(lf_rgbd_step(&rgbd, VIEWS), 0.09 * 0.5 / (VIEWS - 1), 1e-9, 0);
    rgbd.focus = 0.03;
    lf_assert_close(lf_rgbd_step(&rgbd, VIEWS), (0.09 * 0.5 + 0.06) / (VIEWS - 1), 1e-9, 0);
}

/* ------------------------------------------------------------------------------------- holes -- */

/* Columns tell their number and whether they are a front. Codes are fifths, so that with this
 * disparity and plane every shift is a whole number of pixels. */
#define WHOLE_DISPARITY (40.0 / WIDTH)
#define WHOLE_PLANE 0.4

static void number_columns(void)
{
    for (int x = 0; x < WIDTH; x++) {
        f.colour[x][0] = (uint8_t)x;
        f.colour[x][1] = (uint8_t)(255 - x);
        f.colour[x][2] = 77;
    }
}

static void make_blocks(uint32_t *seed)
{
    int x = 0;
    while (x < WIDTH) {
        *seed = *seed * 1664525 + 1013904223;
        const double code = (*seed >> 16) % 6 / 5.0;
        const int end = x + 7 + (int)((*seed >> 24) % 20);
        for (; x < end && x < WIDTH; x++)
            f.code[x] = code;
    }
}

/* A hole is as wide as the two sides of its step move apart, and repeats nothing of the rim. */
static void a_hole_is_as_wide_as_its_step_moves_apart(void **state)
{
    (void)state;
    const lf_rgbd rgbd = rgbd_of(WHOLE_DISPARITY, WHOLE_PLANE);
    number_columns();
    for (int x = 0; x < WIDTH; x++)
        f.code[x] = x >= BLOCK && x < BLOCK_END ? 0.8 : 0.2;
    draw(&rgbd);
    for (int view = 0; view < VIEWS; view++) {
        const int apart = (int)lround(shift_of(WHOLE_DISPARITY, WHOLE_PLANE, view, 0.2) -
                                      shift_of(WHOLE_DISPARITY, WHOLE_PLANE, view, 0.8));
        int again = 0;
        bool told[WIDTH] = {false};
        for (int x = 20; x < WIDTH - 20; x++) {
            const int column = f.views[view][1][x][0];
            again += told[column];
            told[column] = true;
        }
        assert_int_equal(again, abs(apart));
        if (apart > 0) /* the block moves left of its ground: the hole is at its right */
            for (int i = 0; i < apart; i++) {
                const int rim =
                    BLOCK_END + 1 + (int)lround(shift_of(WHOLE_DISPARITY, WHOLE_PLANE, view, 0.2));
                assert_int_equal(f.views[view][1][rim - 1 - i][0], BLOCK_END + 1 + 2 + i);
            }
    }
}

/* Beyond its sides the picture goes on mirrored, but no front appears twice. */
static void the_sides_go_on_without_fronts(void **state)
{
    (void)state;
    const lf_rgbd rgbd = rgbd_of(WHOLE_DISPARITY, WHOLE_PLANE);
    number_columns();
    for (int x = 0; x < WIDTH; x++)
        f.code[x] = x >= 2 && x < 8 ? 1 : 0;
    draw(&rgbd);
    const int left = (int)lround(shift_of(WHOLE_DISPARITY, WHOLE_PLANE, VIEWS - 1, 0)),
              right = (int)lround(shift_of(WHOLE_DISPARITY, WHOLE_PLANE, 0, 0));
    assert_true(left == 8 && right == -8);
    for (int i = 0; i < 8; i++)
        assert_int_equal(f.views[0][1][WIDTH - 1 - i][0], WIDTH - 8 + i);
    int fronts = 0; /* in view 0 its mirror image would move into the view */
    for (int x = 0; x < WIDTH; x++)
        fronts += f.views[0][1][x][0] >= 1 && f.views[0][1][x][0] <= 8;
    assert_int_equal(fronts, 8);
    for (int x = 0; x < 8; x++) { /* the front moved by -12 and is gone; nothing stands for it */
        const int column = f.views[VIEWS - 1][1][x][0];
        assert_true(column < 1 || column > 8);
    }
}

/* A front at the side that stands in the glass meets the hole that its mirror image left: the
 * ground fills it. */
static void a_hole_at_a_side_shows_no_front(void **state)
{
    (void)state;
    const lf_rgbd rgbd = rgbd_of(24.0 / WIDTH, 1);
    number_columns();
    for (int x = 0; x < WIDTH; x++)
        f.code[x] = x >= 2 && x < 8 ? 1 : 0;
    draw(&rgbd);
    for (int x = 0; x < WIDTH; x++) {
        const int column = f.views[VIEWS - 1][1][x][0];
        if (x >= 1 && x <= 8)
            assert_int_equal(column, x);
        else
            assert_true(column < 1 || column > 8);
    }
}

/* ---------------------------------------------------------------------------------- surfaces -- */

static double texture_at(double column)
{
    return 127 + 100 * sin(0.15 * column);
}

static double tilted(double column)
{
    return 0.2 + 0.6 * column / WIDTH;
}

static double curved(double column)
{
    return 0.5 + 0.25 * cos(4 * M_PI * column / WIDTH);
}

/* The largest difference of the views from a surface with this depth. */
static double error_of(double (*code)(double), double disparity, double plane)
{
    double most = 0;
    for (int view = 0; view < VIEWS; view++)
        for (double column = 30; column < WIDTH - 30; column += 0.25) {
            /* column is a place within the picture; the middle of pixel j is j + 1/2 */
            const double x = column + shift_of(disparity, plane, view, code(column)) - 0.5;
            const int j = (int)floor(x);
            const double t = x - j,
                         seen = (1 - t) * f.views[view][1][j][0] + t * f.views[view][1][j + 1][0];
            most = fmax(most, fabs(seen - texture_at(column)));
        }
    return most;
}

static void surfaces_are_where_their_depth_says(void **state)
{
    (void)state;
    double (*const depths[])(double) = {tilted, curved};
    for (int i = 0; i < 2; i++) {
        for (int x = 0; x < WIDTH; x++) {
            memset(f.colour[x], (int)lround(texture_at(x + 0.5)), 3);
            f.code[x] = depths[i](x + 0.5);
        }
        const lf_rgbd rgbd = rgbd_of(0.15, 0.4);
        draw(&rgbd);
        /* The slope is at most 100 * 0.15 a column: 1/8 column for the place of an edge, and 1/4
         * for pixels that are even where the texture is not. */
        const double slope = 100 * 0.15, tolerance = slope * (1 / 8.0 + 1 / 4.0);
        assert_true(error_of(depths[i], 0.15, 0.4) < tolerance);
        /* and the comparison would notice another sign, plane or surface: a column and more */
        assert_true(error_of(depths[i], -0.15, 0.4) > slope);
        assert_true(error_of(depths[i], 0.15, 0.6) > 0.8 * slope);
        assert_true(error_of(depths[1 - i], 0.15, 0.4) > 0.8 * slope);
    }
}

/* A soft edge of depth over several pixels is a step: nothing stretches over the hole. */
static void a_soft_edge_is_no_rubber(void **state)
{
    (void)state;
    const lf_rgbd rgbd = rgbd_of(WHOLE_DISPARITY, WHOLE_PLANE);
    number_columns();
    for (int x = 0; x < WIDTH; x++)
        f.code[x] = fmin(fmax((x - 78) / 4.0, 0), 1);
    draw(&rgbd);
    for (int view = 0; view < VIEWS; view++)
        for (int x = 1; x < WIDTH; x++) {
            const int a = f.views[view][1][x - 1][0], b = f.views[view][1][x][0];
            assert_true(f.views[view][1][x][0] + f.views[view][1][x][1] == 255);
            if (a == b) /* a pixel repeats only at the middle of a mirrored part */
                assert_true(x < 2 || f.views[view][1][x - 2][0] != a);
        }
}

/* ---------------------------------------------------------------------------------- geometry -- */

/* Points at known distances, seen by pinholes on a line through a window that all share. */
static void the_files_geometry_is_that_of_its_cameras(void **state)
{
    (void)state;
    for (int centred = 1; centred <= 2; centred++) {
        const lf_image_metadata meta = {.depth = {.near = 2.5,
                                                  .far = 9,
                                                  .distance = 4,
                                                  .fov_y = 30,
                                                  .aspect = 0.75,
                                                  .cone = 20,
                                                  .views = 8,
                                                  .centred = centred}};
        const lf_standing standing = {.zoom = 1, .depthiness = 1};
        const lf_rgbd rgbd = lf_rgbd_of(&standing, LF_RGBD_IN_RIGHT, &meta);
        const double window = 2 * 4 * tan(15 * M_PI / 180) * 0.75, cone = 20 * M_PI / 180;
        const double own = 4 * tan(cone * (centred == 1 ? 4.5 / 8 - 0.5 : 4.0 / 7 - 0.5));
        assert_true(rgbd.is_known);
        for (int view = 0; view < 5; view++)
            for (double z = 2.5; z <= 9; z += 0.5) {
                const double t = centred == 1 ? (view + 0.5) / 5 - 0.5 : view / 4.0 - 0.5,
                             b = 4 * tan(t * cone), x = 0.3;
                /* where the lines from both cameras to (x, z) meet the window */
                const double here = b + (x - b) * 4 / z, there = own + (x - own) * 4 / z,
                             code = (1 / z - 1 / 9.0) / (1 / 2.5 - 1 / 9.0);
                lf_assert_close(lf_rgbd_shift(&rgbd, view, 5, code), (here - there) / window, 1e-9,
                                1e-12);
            }
        /* one view is the picture */
        lf_assert_close(lf_rgbd_shift(&rgbd, 0, 1, 0.1), 0, 0, 1e-15);
    }
}

static void unknown_geometry_is_the_natural_one(void **state)
{
    (void)state;
    const lf_image_metadata damaged = {.depth = {.near = 3, .far = 2}};
    lf_standing standing = {0};
    lf_rgbd rgbd = lf_rgbd_of(&standing, LF_RGBD_IN_LEFT, &damaged);
    lf_assert_close(rgbd.disparity, 1.0 / 9, 1e-12, 0);
    assert_false(rgbd.is_known);
    /* a Portrait's quilt, whatever the focus: about a pixel from view to view */
    rgbd.plane = 0;
    assert_true(420 * lf_rgbd_step(&rgbd, 48) < 1.01);
    lf_param_defaults(lf_standing_params, &standing);
    lf_assert_close(lf_rgbd_of(&standing, LF_RGBD_IN_LEFT, NULL).disparity, 1.0 / 9, 1e-12, 0);
    standing.depthiness = 0;
    lf_assert_close(lf_rgbd_of(&standing, LF_RGBD_IN_LEFT, NULL).disparity, 0, 0, 0);
    standing.depthiness = 3;
    lf_assert_close(lf_rgbd_of(&standing, LF_RGBD_IN_LEFT, NULL).disparity, 1.0 / 3, 1e-12, 0);
}

/* ----------------------------------------------------------------------------------- layouts -- */

/* A colour whose hue is a code: red near, blue far. */
static void hue_of(double code, uint8_t rgb[3])
{
    const double sixth = 4 * (1 - code), up = sixth - floor(sixth);
    const int part = (int)fmin(floor(sixth), 3);
    const double rising = part == 3 && sixth >= 4 ? 1 : up;
    const double r[] = {1, 1 - rising, 0, 0}, g[] = {rising, 1, 1, 1 - rising},
                 b[] = {0, 0, rising, 1};
    rgb[0] = (uint8_t)lround(255 * r[part]);
    rgb[1] = (uint8_t)lround(255 * g[part]);
    rgb[2] = (uint8_t)lround(255 * b[part]);
}

static void every_side_and_code_gives_the_same_views(void **state)
{
    (void)state;
    static uint8_t other[HEIGHT * 2 * WIDTH * 3], views[VIEWS * PIXELS * 3];
    uint32_t seed = 3;
    lf_rgbd rgbd = rgbd_of(WHOLE_DISPARITY, WHOLE_PLANE);
    const lf_layout layout = layout_of(VIEWS, WIDTH, HEIGHT);
    number_columns();
    make_blocks(&seed);
    draw(&rgbd);
    for (int k = 0; k < 16; k++) {
        const bool above = k & 1, first = k & 2;
        rgbd.side = above ? (first ? LF_RGBD_IN_TOP : LF_RGBD_IN_BOTTOM)
                          : (first ? LF_RGBD_IN_LEFT : LF_RGBD_IN_RIGHT);
        rgbd.near_is_black = k & 4;
        rgbd.is_hue = k & 8;
        const lf_rgbd_picture p = {above ? WIDTH : 2 * WIDTH, above ? 2 * HEIGHT : HEIGHT,
                                   3 * (above ? WIDTH : 2 * WIDTH), other, 0};
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                const size_t half = above ? HEIGHT * p.stride : 3 * WIDTH,
                             at = (size_t)y * p.stride + 3 * (size_t)x;
                const double code = rgbd.near_is_black ? 1 - f.code[x] : f.code[x];
                uint8_t *depth = other + at + (first ? 0 : half);
                memcpy(other + at + (first ? half : 0), f.colour[x], 3);
                if (rgbd.is_hue)
                    hue_of(code, depth);
                else
                    memset(depth, (int)lround(255 * code), 3);
            }
        lf_error err;
        lf_assert_ok(lf_rgbd_views(&rgbd, &p, &layout, NULL, "p", views, &err), &err);
        assert_memory_equal(views, f.views, sizeof f.views);
        const lf_rgbd_look look = lf_rgbd_look_at(&rgbd, &p);
        assert_false(look.is_flat);
        assert_false(look.is_coloured);
        rgbd.is_hue = !rgbd.is_hue;
        assert_true(lf_rgbd_look_at(&rgbd, &p).is_coloured);
    }
}

/* Draws one view of another size. */
static void draw_one(lf_rgbd *rgbd, int width, int height, uint8_t *out)
{
    const lf_rgbd_picture picture = draw_picture();
    const lf_layout layout = layout_of(1, width, height);
    lf_error err;
    lf_assert_ok(lf_rgbd_views(rgbd, &picture, &layout, NULL, "p", out, &err), &err);
}

static void the_picture_is_placed_scaled_and_cut(void **state)
{
    (void)state;
    static uint8_t out[4 * WIDTH * 4 * HEIGHT * 3];
    lf_rgbd rgbd = rgbd_of(0.1, 0.5);
    number_columns();
    for (int x = 0; x < WIDTH; x++)
        f.code[x] = x < 70 ? 0 : 1;
    draw_one(&rgbd, WIDTH, HEIGHT, out); /* one view: the picture itself */
    for (int x = 0; x < WIDTH; x++)
        assert_memory_equal(out + 3 * (WIDTH + x), f.colour[x], 3);
    draw_one(&rgbd, WIDTH, 3 * HEIGHT, out); /* whole, with black above and below */
    assert_int_equal(out[3 * 80], 0);
    assert_int_equal(out[3 * (2 * WIDTH + 80) + 2], 0);
    assert_memory_equal(out + 3 * (4 * WIDTH + 80), f.colour[80], 3);
    assert_int_equal(out[3 * (6 * WIDTH + 80) + 2], 0);
    rgbd.photo.mode = LF_PHOTO_FILL; /* three times as large, cut at the sides */
    draw_one(&rgbd, WIDTH, 3 * HEIGHT, out);
    assert_int_equal(out[3 * (4 * WIDTH + 80) + 2], 77);
    lf_assert_close(out[3 * (4 * WIDTH)], WIDTH / 3.0, 0, 1);
    rgbd = rgbd_of(0.1, 0.5);
    rgbd.zoom = 2;
    rgbd.crop_x = 0.5; /* the middle is at 3/4 of the picture */
    draw_one(&rgbd, WIDTH, HEIGHT, out);
    lf_assert_close(out[3 * (WIDTH + WIDTH / 2)], 0.75 * WIDTH, 0, 1);
    lf_assert_close(out[3 * (WIDTH + WIDTH / 2 + 20)], 0.75 * WIDTH + 10, 0, 1);
    rgbd.zoom = 0.5;
    rgbd.crop_x = 0;
    draw_one(&rgbd, WIDTH, HEIGHT, out);
    assert_int_equal(out[3 * (WIDTH + 30) + 2], 0);
    assert_int_equal(out[3 * (WIDTH + 42) + 2], 77);
    rgbd.photo.on_paper = true;
    draw_one(&rgbd, WIDTH, HEIGHT, out);
    assert_int_equal(out[3 * (WIDTH + 30) + 2], 255);
    assert_int_equal(out[3 * (WIDTH + 42) + 2], 77);
    rgbd.photo.on_paper = false;
    rgbd.crop_x = 2;
    rgbd.zoom = 4;
    draw_one(&rgbd, WIDTH, HEIGHT, out); /* beyond the picture */
    for (int x = 0; x < WIDTH; x++)
        assert_int_equal(out[3 * (WIDTH + x) + 2], 0);
}

/* Black and white columns, four to a pixel: half of the light. */
static void smaller_views_are_averaged_in_light(void **state)
{
    (void)state;
    static uint8_t out[WIDTH * HEIGHT * 3];
    lf_rgbd rgbd = rgbd_of(0.1, 0.5);
    for (int x = 0; x < WIDTH; x++) {
        memset(f.colour[x], x % 2 ? 255 : 0, 3);
        f.code[x] = 0.4;
    }
    const lf_rgbd_picture picture = draw_picture();
    lf_layout layout = layout_of(1, WIDTH / 4, HEIGHT);
    layout.aspect = (double)WIDTH / HEIGHT;
    lf_error err;
    lf_assert_ok(lf_rgbd_views(&rgbd, &picture, &layout, NULL, "p", out, &err), &err);
    for (int i = 0; i < 3 * WIDTH / 4; i++)
        assert_int_equal(out[i], 188);
}

static void cutoff_brings_the_ground_up(void **state)
{
    (void)state;
    make_block(204 / 255.0, 51 / 255.0);
    lf_rgbd rgbd = rgbd_of(WHOLE_DISPARITY, WHOLE_PLANE);
    rgbd.cutoff = 0.8;
    number_columns();
    draw(&rgbd);
    for (int view = 0; view < VIEWS; view++)
        for (int x = 20; x < WIDTH - 20; x++)
            assert_int_equal(f.views[view][1][x][0],
                             x - lround(shift_of(WHOLE_DISPARITY, WHOLE_PLANE, view, 0.8)));
}

/* ---------------------------------------------------------------------------------- extremes -- */

static void threads_change_nothing(void **state)
{
    (void)state;
    static uint8_t views[VIEWS * PIXELS * 3];
    uint32_t seed = 11;
    const lf_rgbd rgbd = rgbd_of(0.13, 0.3);
    const lf_layout layout = layout_of(VIEWS, WIDTH, HEIGHT);
    number_columns();
    make_blocks(&seed);
    draw(&rgbd);
    const lf_rgbd_picture picture = draw_picture();
    for (int threads = 1; threads <= 3; threads++) {
        lf_pool *pool;
        lf_error err;
        lf_assert_ok(lf_pool_create(threads, &pool), NULL);
        lf_assert_ok(lf_rgbd_views(&rgbd, &picture, &layout, pool, "p", views, &err), &err);
        assert_memory_equal(views, f.views, sizeof views);
        lf_pool_destroy(pool);
    }
}

static void small_pictures_and_views_are_drawn(void **state)
{
    (void)state;
    static const int sizes[][2] = {{2, 1}, {2, 2}, {4, 1}, {2, 7}, {6, 3}};
    static const int views[][2] = {{1, 1}, {1, 5}, {2, 1}, {7, 3}};
    uint8_t data[64], out[5 * 7 * 5 * 3];
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)(37 * i + 20);
    for (size_t s = 0; s < 5; s++)
        for (size_t v = 0; v < 4; v++)
            for (int n = 1; n <= 5; n += 2)
                for (double disparity = 0; disparity < 17; disparity += 4) {
                    lf_rgbd rgbd = rgbd_of(disparity, 3);
                    rgbd.focus = disparity > 0 ? 1 : 0;
                    rgbd.photo.mode = LF_PHOTO_FILL;
                    const lf_rgbd_picture p = {sizes[s][0], sizes[s][1], 3 * (size_t)sizes[s][0],
                                               data, 0};
                    const lf_layout layout = layout_of(n, views[v][0], views[v][1]);
                    lf_error err;
                    memset(out, 0, sizeof out);
                    lf_assert_ok(lf_rgbd_views(&rgbd, &p, &layout, NULL, "p", out, &err), &err);
                    if (disparity < 4) /* every pixel is drawn */
                        for (int i = 0; i < n * views[v][0] * views[v][1] * 3; i++)
                            assert_true(out[i] > 0);
                }
}

static void assert_refused(const lf_rgbd *rgbd, int width, int height, const lf_layout *layout,
                           lf_status status, const char *words)
{
    const lf_rgbd_picture p = {width, height, 3 * (size_t)width, f.data, 0};
    lf_error err = {0};
    assert_int_equal(lf_rgbd_views(rgbd, &p, layout, NULL, "p", &f.views[0][0][0][0], &err),
                     status);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" does not say \"%s\"", err.what, words);
}

static void what_is_no_number_or_has_no_halves_is_refused(void **state)
{
    (void)state;
    const double wrong[] = {(double)NAN, (double)INFINITY};
    const lf_layout layout = layout_of(2, 4, 2);
    const lf_rgbd sound = rgbd_of(0.1, 0.5);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 9; k++) {
            lf_rgbd rgbd = sound;
            double *const fields[] = {&rgbd.disparity, &rgbd.plane,  &rgbd.offset,
                                      &rgbd.cone,      &rgbd.cutoff, &rgbd.focus,
                                      &rgbd.zoom,      &rgbd.crop_x, &rgbd.crop_y};
            *fields[k] = wrong[i];
            assert_refused(&rgbd, 4, 2, &layout, LF_E_ARG, "");
        }
    lf_rgbd rgbd = sound;
    assert_refused(&rgbd, 5, 2, &layout, LF_E_FORMAT, "has no depth: 5 columns");
    rgbd.side = LF_RGBD_IN_TOP;
    assert_refused(&rgbd, 4, 3, &layout, LF_E_FORMAT, "has no depth: 3 rows");
    const lf_layout none = {.n_views = 0, .view_width = 1, .view_height = 1, .aspect = 1};
    assert_refused(&sound, 4, 2, &none, LF_E_ARG, "no views");
}

static void names_and_options_say_where_the_depth_is(void **state)
{
    (void)state;
    lf_standing standing = {0};
    assert_true(lf_rgbd_named("/a/photo_rgbd.png"));
    assert_true(lf_rgbd_named("photo_RGBD.jpeg"));
    assert_false(lf_rgbd_named("/a_rgbd/photo.png"));
    assert_false(lf_rgbd_named("photo_rgbd2.png"));
    assert_false(lf_rgbd_named("_rgbd"));
    assert_int_equal(lf_rgbd_side_of(&standing, "a_rgbd.png"), LF_RGBD_IN_RIGHT);
    assert_int_equal(lf_rgbd_side_of(&standing, "a.png"), LF_RGBD_IN_OFF);
    standing.rgbd_in = LF_RGBD_IN_TOP;
    assert_int_equal(lf_rgbd_side_of(&standing, "a.png"), LF_RGBD_IN_TOP);
    standing.rgbd_in = LF_RGBD_IN_OFF;
    assert_int_equal(lf_rgbd_side_of(&standing, "a_rgbd.png"), LF_RGBD_IN_OFF);
    standing.focus = (double)NAN;
    lf_error err;
    assert_int_equal(lf_standing_check(&standing, "x", &err), LF_E_ARG);
    standing.focus = 1;
    lf_assert_ok(lf_standing_check(&standing, "x", &err), &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_moves_as_its_depth_says),
        cmocka_unit_test(focus_moves_all_depths_alike),
        cmocka_unit_test(a_hole_is_as_wide_as_its_step_moves_apart),
        cmocka_unit_test(the_sides_go_on_without_fronts),
        cmocka_unit_test(a_hole_at_a_side_shows_no_front),
        cmocka_unit_test(surfaces_are_where_their_depth_says),
        cmocka_unit_test(a_soft_edge_is_no_rubber),
        cmocka_unit_test(the_files_geometry_is_that_of_its_cameras),
        cmocka_unit_test(unknown_geometry_is_the_natural_one),
        cmocka_unit_test(every_side_and_code_gives_the_same_views),
        cmocka_unit_test(the_picture_is_placed_scaled_and_cut),
        cmocka_unit_test(smaller_views_are_averaged_in_light),
        cmocka_unit_test(cutoff_brings_the_ground_up),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(small_pictures_and_views_are_drawn),
        cmocka_unit_test(what_is_no_number_or_has_no_halves_is_refused),
        cmocka_unit_test(names_and_options_say_where_the_depth_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
