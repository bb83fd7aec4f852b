/* Pictures with depth: of a light field whose depths are known, every code. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "daemon/output/output.h"

#define VIEWS 5
#define MIDDLE 2
#define WIDTH 20
#define HEIGHT 10
#define PIXELS (WIDTH * HEIGHT)

/* Pixel i of the middle view lies at 1/Z = 0.1 + 0.9 i / 199, so that nearness is linear in i; in
 * the other views everything lies at 77. Colours tell view, row and column. */
typedef struct fixture {
    char *folder;
    float film[HEIGHT][VIEWS][WIDTH][3];
    float beside[HEIGHT][VIEWS][WIDTH][3];
    lf_layers32 layers;
    lf_output_source source;
} fixture;

/* Other channels may lie beside the two, in any order. */
static const char *const names[] = {"coverage.A", "variance.R", "Z"};

static double nearness_at(int i)
{
    return 0.1 + 0.9 * i / (PIXELS - 1);
}

static int set_up(void **state)
{
    static fixture f;
    const lf_render_settings settings = {
        .camera = {.n_views = VIEWS, .aspect = 2}, .width = WIDTH, .height = HEIGHT};
    f.folder = lf_test_folder();
    *state = &f;
    for (int y = 0; y < HEIGHT; y++)
        for (int view = 0; view < VIEWS; view++)
            for (int x = 0; x < WIDTH; x++) {
                float *at = f.beside[y][view][x];
                at[0] = 1.0f;
                at[1] = 1000.0f;
                at[2] = view == MIDDLE ? (float)(1 / nearness_at(y * WIDTH + x)) : 77.0f;
                f.film[y][view][x][0] = view == MIDDLE ? 1.0f : 0.0f;
                f.film[y][view][x][1] = x % 2 ? 1.0f : 0.0f;
                f.film[y][view][x][2] = y % 2 ? 1.0f : 0.0f;
            }
    f.layers = (lf_layers32){3, names, (size_t)WIDTH * 3, (size_t)WIDTH * 3 * VIEWS,
                             &f.beside[0][0][0][0]};
    f.source = lf_output_from_film(&settings, &f.film[0][0][0][0]);
    f.source.views32.layers = &f.layers;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    lf_test_folder_remove(f->folder);
    return 0;
}

static lf_status try_writing(const fixture *f, const lf_rgbd_options *rgbd, lf_error *err)
{
    const lf_output_request request = {.kind = &lf_output_rgbd,
                                       .path = lf_test_path(f->folder, "d.png"),
                                       .overwrite = true,
                                       .rgbd = *rgbd};
    return lf_output_write(&request, &f->source, err);
}

static lf_image8 write_and_read(const fixture *f, const lf_rgbd_options *rgbd)
{
    lf_error err = {0};
    lf_image8 image = {0};
    lf_assert_ok(try_writing(f, rgbd, &err), &err);
    lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "d.png"), NULL, &image, &err), &err);
    return image;
}

static const uint8_t *pixel(const lf_image8 *image, int x, int y)
{
    return image->data + (size_t)y * image->stride + (size_t)x * 3;
}

/* The code of pixel i of the depth that begins at x, y; it is grey. */
static int depth_code(const lf_image8 *image, int x, int y, int i)
{
    const uint8_t *at = pixel(image, x + i % WIDTH, y + i / WIDTH);
    assert_int_equal(at[0], at[1]);
    assert_int_equal(at[0], at[2]);
    return at[0];
}

/* What is linear in 1/Z between two distances: the same sum in another form. */
static int expected_code(int i, double near, double far)
{
    double z = 1 / nearness_at(i);
    if (z <= near)
        return 255;
    if (z >= far)
        return 0;
    return (int)floor(255 * (near * (far - z)) / (z * (far - near)) + 0.5);
}

static void codes_are_linear_in_nearness(void **state)
{
    const fixture *f = *state;
    static const double ranges[][2] = {{1, 10}, {1.25, 6}, {0.5, 40}};
    for (size_t r = 0; r < sizeof ranges / sizeof ranges[0]; r++) {
        const double near = ranges[r][0], far = ranges[r][1];
        lf_image8 image = write_and_read(f, &(lf_rgbd_options){.near = near, .far = far});
        int linear_in_z = 0;
        assert_int_equal(image.width, 2 * WIDTH);
        assert_int_equal(image.height, HEIGHT);
        for (int i = 0; i < PIXELS; i++) {
            const double z = 1 / nearness_at(i);
            const int code = depth_code(&image, WIDTH, 0, i);
            assert_int_equal(code, expected_code(i, near, far));
            linear_in_z += code == (int)lround(255 * fmin(fmax((far - z) / (far - near), 0), 1));
        }
        assert_true(linear_in_z < PIXELS / 3); /* the check tells both laws apart */
        lf_image8_finish(&image);
    }
}

static void the_range_leaves_out_one_pixel_of_a_hundred_at_both_ends(void **state)
{
    const fixture *f = *state;
    /* of 200 depths in their order the 3rd and the 198th: pixels 197 and 2 */
    const double near = 1 / nearness_at(197), far = 1 / nearness_at(2);
    static const lf_rgbd_options given[] = {{0}, {.near = 2}, {.far = 5}};
    for (int k = 0; k < 3; k++) {
        lf_image8 image = write_and_read(f, &given[k]);
        for (int i = 0; i < PIXELS; i++)
            assert_int_equal(depth_code(&image, WIDTH, 0, i),
                             expected_code(i, k == 1 ? 2 : near, k == 2 ? 5 : far));
        lf_image8_finish(&image);
    }
}

static void all_that_is_nearer_than_near_is_near(void **state)
{
    const fixture *f = *state;
    lf_image8 image = write_and_read(f, &(lf_rgbd_options){.near = 20});
    for (int i = 0; i < PIXELS; i++)
        assert_int_equal(depth_code(&image, WIDTH, 0, i), 255);
    lf_image8_finish(&image);
}

static void depth_stands_where_it_is_asked_for_beside_the_middle_view(void **state)
{
    const fixture *f = *state;
    static const struct {
        const char *word;
        int width, height, depth_x, depth_y, view_x, view_y;
    } cases[] = {
        {"right", 2 * WIDTH, HEIGHT, WIDTH, 0, 0, 0},
        {"left", 2 * WIDTH, HEIGHT, 0, 0, WIDTH, 0},
        {"top", WIDTH, 2 * HEIGHT, 0, 0, 0, HEIGHT},
        {"bottom", WIDTH, 2 * HEIGHT, 0, HEIGHT, 0, 0},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        lf_rgbd_options rgbd = {.near = 1, .far = 10};
        lf_error err = {0};
        lf_assert_ok(
            lf_param_from_text(lf_param_find(lf_rgbd_params, "rgbd"), cases[k].word, &rgbd, &err),
            &err);
        lf_image8 image = write_and_read(f, &rgbd);
        assert_int_equal(image.width, cases[k].width);
        assert_int_equal(image.height, cases[k].height);
        for (int i = 0; i < PIXELS; i++) {
            const uint8_t *colour =
                pixel(&image, cases[k].view_x + i % WIDTH, cases[k].view_y + i / WIDTH);
            assert_int_equal(colour[0], 255);
            assert_int_equal(colour[1], i % WIDTH % 2 ? 255 : 0);
            assert_int_equal(colour[2], i / WIDTH % 2 ? 255 : 0);
            assert_int_equal(depth_code(&image, cases[k].depth_x, cases[k].depth_y, i),
                             expected_code(i, 1, 10));
        }
        lf_image8_finish(&image);
    }
}

static void near_is_black_where_that_is_asked_for(void **state)
{
    const fixture *f = *state;
    lf_rgbd_options rgbd = {.near = 1, .far = 10};
    lf_error err = {0};
    lf_assert_ok(lf_param_from_text(lf_param_find(lf_rgbd_params, "near-is"), "black", &rgbd, &err),
                 &err);
    lf_image8 image = write_and_read(f, &rgbd);
    for (int i = 0; i < PIXELS; i++)
        assert_int_equal(depth_code(&image, WIDTH, 0, i), 255 - expected_code(i, 1, 10));
    lf_image8_finish(&image);
}

static lf_output_request quilt_request(const fixture *f)
{
    return (lf_output_request){.kind = &lf_output_rgbd,
                               .path = lf_test_path(f->folder, "d.png"),
                               .overwrite = true,
                               .layout = {.columns = 3, .rows = 2, .n_views = VIEWS},
                               .rgbd = {.near = 1, .far = 100, .is_quilt = 1}};
}

/* Every view's tile: its colours (only the middle view has red) and its codes. */
static void a_quilt_stands_beside_a_quilt_of_depth(void **state)
{
    const fixture *f = *state;
    lf_output_request request = quilt_request(f);
    lf_error err = {0};
    lf_image8 image = {0};
    lf_assert_ok(lf_output_write(&request, &f->source, &err), &err);
    lf_assert_ok(lf_image8_read(request.path, NULL, &image, &err), &err);
    assert_int_equal(image.width, 2 * 3 * WIDTH);
    assert_int_equal(image.height, 2 * HEIGHT);
    for (int view = 0; view < VIEWS; view++) {
        const int x = view % 3 * WIDTH, y = (1 - view / 3) * HEIGHT;
        for (int i = 0; i < PIXELS; i++) {
            const uint8_t *colour = pixel(&image, x + i % WIDTH, y + i / WIDTH);
            assert_int_equal(colour[0], view == MIDDLE ? 255 : 0);
            assert_int_equal(colour[1], i % WIDTH % 2 ? 255 : 0);
            /* at 77 of 1 to 100: 255 (1/77 - 1/100) / (1 - 1/100) = 0.77 */
            assert_int_equal(depth_code(&image, 3 * WIDTH + x, y, i),
                             view == MIDDLE ? expected_code(i, 1, 100) : 1);
        }
    }
    for (int i = 0; i < PIXELS; i++) { /* the sixth tile has no view */
        assert_int_equal(pixel(&image, 2 * WIDTH + i % WIDTH, i / WIDTH)[1], 0);
        assert_int_equal(depth_code(&image, 5 * WIDTH, 0, i), 0);
    }
    lf_image8_finish(&image);
}

static void what_nothing_is_met_in_is_far_and_says_nothing_of_the_range(void **state)
{
    fixture *f = *state;
    float kept[HEIGHT][VIEWS][WIDTH][3];
    memcpy(kept, f->beside, sizeof kept);
    /* the upper half: nothing; half of the row below: little, and nearer than all else */
    for (int y = 0; y < HEIGHT / 2; y++)
        for (int x = 0; x < WIDTH; x++)
            f->beside[y][MIDDLE][x][0] = f->beside[y][MIDDLE][x][2] = 0.0f;
    for (int x = 0; x < WIDTH / 2; x++) {
        f->beside[HEIGHT / 2][MIDDLE][x][0] = 0.4f;
        f->beside[HEIGHT / 2][MIDDLE][x][2] = 0.01f;
    }
    /* 90 pixels are left, 110 to 199: the 2nd and the 89th of their order */
    const double near = 1 / nearness_at(198), far = 1 / nearness_at(111);
    for (int black = 0; black < 2; black++) {
        lf_image8 image = write_and_read(f, &(lf_rgbd_options){.near_is_black = black});
        for (int i = 0; i < PIXELS; i++) {
            const int code = i < 100 ? 0 : i < 110 ? 255 : expected_code(i, near, far);
            assert_int_equal(depth_code(&image, WIDTH, 0, i), black ? 255 - code : code);
        }
        lf_image8_finish(&image);
    }
    memcpy(f->beside, kept, sizeof kept);
}

static void rays_that_meet_nothing_are_far(void **state)
{
    fixture *f = *state;
    float kept[HEIGHT][VIEWS][WIDTH][3];
    memcpy(kept, f->beside, sizeof kept);
    for (int i = 0; i < PIXELS; i++) {
        f->beside[i / WIDTH][MIDDLE][i % WIDTH][0] = ((float)i + 0.3f) / PIXELS;
        f->beside[i / WIDTH][MIDDLE][i % WIDTH][2] = 4.0f;
    }
    lf_image8 image = write_and_read(f, &(lf_rgbd_options){.near = 4, .far = 40});
    for (int i = 0; i < PIXELS; i++) {
        const double share = fmax(((i + 0.3) / PIXELS - 0.1) / 0.9, 0);
        assert_int_equal(depth_code(&image, WIDTH, 0, i), (int)floor(255 * share + 0.5));
    }
    lf_image8_finish(&image);
    memcpy(f->beside, kept, sizeof kept);
}

static void a_plane_is_near_and_nothing_at_all_is_far(void **state)
{
    fixture *f = *state;
    float kept[HEIGHT][VIEWS][WIDTH][3];
    memcpy(kept, f->beside, sizeof kept);
    for (int covered = 1; covered >= 0; covered--) {
        for (int i = 0; i < PIXELS; i++) {
            float *at = f->beside[i / WIDTH][MIDDLE][i % WIDTH];
            at[0] = covered && i != 7 ? 1.0f : 0.0f;
            at[2] = covered && i != 7 ? 3.0f : 0.0f;
        }
        lf_image8 image = write_and_read(f, &(lf_rgbd_options){0});
        for (int i = 0; i < PIXELS; i++)
            assert_int_equal(depth_code(&image, WIDTH, 0, i), covered && i != 7 ? 255 : 0);
        lf_image8_finish(&image);
    }
    memcpy(f->beside, kept, sizeof kept);
}

static void no_depth_and_no_range_are_refused(void **state)
{
    fixture f = *(const fixture *)*state;
    static const char *const others[] = {"coverage.A", "variance.R", "normal.X"};
    lf_error err = {0};
    const lf_rgbd_options plain = {0};
    f.layers.names = others;
    f.source.views32.layers = &f.layers;
    assert_int_equal(try_writing(&f, &plain, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "no depth"));
    f.source.views32.layers = NULL;
    assert_int_equal(try_writing(&f, &plain, &err), LF_E_ARG);
    assert_int_equal(lf_rgbd_check(&(lf_rgbd_options){.near = 2, .far = 2}, "", &err), LF_E_ARG);
    lf_assert_ok(lf_rgbd_check(&(lf_rgbd_options){.near = 2}, "", &err), &err);
    lf_assert_ok(lf_rgbd_check(&(lf_rgbd_options){.far = 2}, "", &err), &err);
    lf_assert_ok(lf_rgbd_check(&(lf_rgbd_options){.near = 2, .far = 2.5}, "", &err), &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_are_linear_in_nearness),
        cmocka_unit_test(the_range_leaves_out_one_pixel_of_a_hundred_at_both_ends),
        cmocka_unit_test(all_that_is_nearer_than_near_is_near),
        cmocka_unit_test(depth_stands_where_it_is_asked_for_beside_the_middle_view),
        cmocka_unit_test(near_is_black_where_that_is_asked_for),
        cmocka_unit_test(a_quilt_stands_beside_a_quilt_of_depth),
        cmocka_unit_test(what_nothing_is_met_in_is_far_and_says_nothing_of_the_range),
        cmocka_unit_test(rays_that_meet_nothing_are_far),
        cmocka_unit_test(a_plane_is_near_and_nothing_at_all_is_far),
        cmocka_unit_test(no_depth_and_no_range_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
