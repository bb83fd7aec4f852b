/* Pictures of another shape than the view, panel or print that they are laid onto. */
#include "tests/base/pictures.h"

#include <png.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "quilt/prints.h"
#include "tests/quilt/printed.h"

/* ------------------------------------------------------------------------------------ prints -- */

enum { SIDE = 100 };

/* Red in its right half, green in its lower half. */
static void fill_quarters(float *data)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        data[3 * i] = i % SIDE >= SIDE / 2;
        data[3 * i + 1] = i / SIDE >= SIDE / 2;
        data[3 * i + 2] = 0;
    }
}

typedef struct print_case {
    lf_photo photo;
    bool horizontal;
    /* places of the raster of 1200 x 600, and the channels there: "rgb", '-' is dark */
    struct {
        int x, y;
        const char *light;
    } at[4];
    const char *warning;
} print_case;

enum { LEFT = 1, RIGHT, TOP, BOTTOM };

/* A square on 2:1. Fitted it is 600 dots wide, with 300 of paper at each side; lenses are 10 dots
 * wide. Covering it is 1200 high, of which 600 are seen. */
static const print_case print_cases[] = {
    {{0}, false, {{290, 9, "rgb"}, {310, 9, "---"}, {890, 590, "rg-"}, {910, 9, "rgb"}}, "50.8 x"},
    {{0}, true, {{299, 9, "rgb"}, {300, 9, "---"}, {899, 590, "rg-"}, {900, 9, "rgb"}}, "50.8 x"},
    {{.position = LEFT},
     false,
     {{10, 9, "---"}, {310, 590, "rg-"}, {590, 9, "r--"}, {610, 9, "rgb"}},
     "25.4 mm left and right"},
    {{.position = RIGHT},
     false,
     {{590, 9, "rgb"}, {610, 9, "---"}, {910, 9, "r--"}, {1190, 590, "rg-"}},
     "25.4 mm left and right"},
    {{.mode = LF_PHOTO_FILL},
     false,
     {{10, 9, "---"}, {10, 290, "---"}, {10, 310, "-g-"}, {1190, 590, "rg-"}},
     "50 % of the image"},
    {{.mode = LF_PHOTO_FILL, .position = TOP},
     false,
     {{10, 9, "---"}, {10, 590, "---"}, {590, 590, "---"}, {610, 9, "r--"}},
     "50 % of the image"},
    {{.mode = LF_PHOTO_FILL, .position = BOTTOM},
     true,
     {{10, 9, "-g-"}, {10, 590, "-g-"}, {590, 590, "-g-"}, {610, 9, "rg-"}},
     "50 % of the image"},
};

static void assert_light(const lf_printed *printed, int x, int y, const char *light)
{
    for (int c = 0; c < 3; c++)
        if (fabs(lf_printed_linear(printed, x, y, c) - (light[c] == '-' ? 0 : 1)) > 1e-3)
            fail_msg("(%d, %d) channel %d is %g", x, y, c, lf_printed_linear(printed, x, y, c));
}

static void a_print_shows_it_whole_or_cut_where_it_is_said(void **state)
{
    float *data = lf_calloc((size_t)SIDE * SIDE * 3, sizeof *data);
    (void)state;
    assert_non_null(data);
    fill_quarters(data);
    const lf_views32 views = {1, SIDE, SIDE, 0, 3 * SIDE, data, NULL, NULL, NULL};
    for (size_t i = 0; i < sizeof print_cases / sizeof *print_cases; i++) {
        const print_case *c = &print_cases[i];
        lf_print print = lf_print_sound();
        lf_printed printed;
        lf_image_notes notes = {0};
        print.height_mm = 25.4;
        print.view_aspect = 1;
        print.n_views = 1;
        print.photo = c->photo;
        print.horizontal = c->horizontal;
        lf_printed_make(&print, &views, 0, &printed);
        for (int k = 0; k < 4; k++)
            assert_light(&printed, c->at[k].x, c->at[k].y, c->at[k].light);
        lf_printed_finish(&printed);
        lf_print_note_laid(&print, &views, &notes);
        notes.text[notes.length] = '\0';
        if (!strstr(notes.text, c->warning))
            fail_msg("case %zu: \"%s\"", i, notes.text);
    }
    lf_free(data);
}

/* What lies in the bleed is cut away anyway: the picture of a trimmed sheet covers the bleed. */
static void what_has_the_shape_of_the_trimmed_sheet_covers_the_bleed(void **state)
{
    (void)state;
    float *data = lf_calloc((size_t)SIDE * SIDE * 3, sizeof *data);
    const lf_views32 views = {1, SIDE, SIDE, 0, 3 * SIDE, data, NULL, NULL, NULL};
    lf_print print = lf_print_sound();
    lf_printed printed;
    lf_image_notes notes = {0};
    assert_non_null(data);
    print.height_mm = 25.4;
    print.bleed_mm = 3;
    print.n_views = 1;
    for (int i = 0; i < 2; i++) {
        print.view_aspect = i == 0 ? 2 : 2.0008; /* as a name rounds it */
        lf_printed_make(&print, &views, 0, &printed);
        for (int x = 0; x < printed.width; x++)
            assert_true(lf_printed_linear(&printed, x, 0, 0) == 0 &&
                        lf_printed_linear(&printed, x, printed.height - 1, 1) == 0);
        for (int y = 0; y < printed.height; y++)
            assert_true(lf_printed_linear(&printed, 0, y, 0) == 0 &&
                        lf_printed_linear(&printed, printed.width - 1, y, 1) == 0);
        lf_printed_finish(&printed);
    }
    lf_print_note_laid(&print, &views, &notes);
    notes.text[notes.length] = '\0';
    assert_null(strstr(notes.text, "cropped"));
    assert_null(strstr(notes.text, "border"));
    lf_free(data);
}

/* ----------------------------------------------------------------------------------- folders -- */

static const uint8_t red[3] = {200, 10, 10}, blue[3] = {10, 10, 200}, black[3] = {0, 0, 0},
                     white[3] = {255, 255, 255};

/* Red left, blue right. */
static void save_halves(const char *folder, const char *name, int width, int height)
{
    lf_image8 image = {0};
    assert_int_equal(lf_image8_init(&image, width, height, 3), LF_OK);
    for (int i = 0; i < width * height; i++)
        memcpy(image.data + (size_t)(i / width) * image.stride + 3 * (size_t)(i % width),
               i % width < width / 2 ? red : blue, 3);
    lf_picture_save_png(lf_test_path(folder, name), &image, 6, NULL, 0);
    lf_image8_finish(&image);
}

static const char *new_folder(const char *in, const char *name)
{
    const char *path = lf_test_path(in, name);
    assert_int_equal(mkdir(path, 0700), 0);
    return path;
}

static void read_folder(const char *folder, lf_photo photo, lf_quilt_file *q)
{
    lf_error err;
    lf_assert_ok(lf_quilt_read_photo(folder, NULL, 0, 0, &photo, q, &err), &err);
    q->notes.text[q->notes.length] = '\0';
}

static void assert_row(const lf_quilt_file *q, int view, int x0, int x1, const uint8_t rgb[3])
{
    for (int y = 0; y < q->layout.view_height; y++)
        for (int x = x0; x < x1; x++)
            assert_memory_equal(lf_views8_row(&q->views8, view, y) + 3 * x, rgb, 3);
}

static void assert_told(const lf_quilt_file *q, const char *line)
{
    if (!strstr(q->notes.text, line))
        fail_msg("\"%s\" is not in \"%s\"", line, q->notes.text);
}

static void pictures_of_other_sizes_are_laid_onto_the_first_s(void **state)
{
    const char *folder = new_folder(*state, "mixed");
    lf_quilt_file q = {0};
    save_halves(folder, "a1.png", 80, 40);
    save_halves(folder, "a2.png", 40, 40);
    save_halves(folder, "a3.png", 240, 120);
    save_halves(folder, "a10.png", 80, 40);
    read_folder(folder, (lf_photo){0}, &q);
    assert_true(q.layout.n_views == 4 && q.layout.view_width == 80 && q.layout.view_height == 40);
    assert_row(&q, 1, 0, 20, black);
    assert_row(&q, 1, 20, 40, red);
    assert_row(&q, 1, 40, 60, blue);
    assert_row(&q, 1, 60, 80, black);
    for (int view = 0; view < 4; view += view == 0 ? 2 : 1) {
        assert_row(&q, view, 0, 40, red);
        assert_row(&q, view, 40, 80, blue);
    }
    assert_told(&q, "2 of 4 images do not have the 80x40 pixels of a1.png: a2.png (40x40), a3.png "
                    "(240x120)");
    assert_told(&q, "1 of them are scaled down by more than 2, a3.png most, by 3");
    assert_null(strstr(q.notes.text, "of them are cropped"));
    lf_quilt_finish(&q);
    read_folder(folder, (lf_photo){.on_paper = true}, &q);
    assert_row(&q, 1, 0, 20, white);
    assert_row(&q, 1, 20, 40, red);
    assert_row(&q, 1, 60, 80, white);
    lf_quilt_finish(&q);
    read_folder(folder, (lf_photo){.position = RIGHT}, &q);
    assert_row(&q, 1, 0, 40, black);
    assert_row(&q, 1, 40, 60, red);
    lf_quilt_finish(&q);
    read_folder(folder, (lf_photo){.mode = LF_PHOTO_FILL}, &q);
    assert_row(&q, 1, 0, 39, red);
    assert_row(&q, 1, 41, 80, blue);
    assert_told(&q, "1 of them are cropped, a2.png most, by 50 %");
    lf_quilt_finish(&q);
}

/* However many they are, and whatever else files say. */
static void what_many_pictures_lose_is_told_in_a_line(void **state)
{
    char folder[PATH_MAX];
    lf_quilt_file q = {0};
    snprintf(folder, sizeof folder, "%s", new_folder(*state, "many"));
    save_halves(folder, "a.png", 80, 40);
    for (int i = 0; i < 60; i++) {
        char name[128];
        snprintf(name, sizeof name, "b%02d_with_a_name_that_is_as_long_as_those_of_cameras.png", i);
        save_halves(folder, name, 30 - i / 4, 10);
    }
    read_folder(folder, (lf_photo){0}, &q);
    assert_told(&q, "60 of 61 images do not have the 80x40 pixels of a.png: b00_with_");
    assert_told(&q, " ...; they are scaled to fit, with borders (photo fill crops them instead)");
    assert_told(&q, "60 of them are scaled up by more than 2, b");
    assert_told(&q, ".png most, by 4");
    lf_quilt_finish(&q);
}

static void one_that_cannot_be_read_is_named_once(void **state)
{
    const char *folder = new_folder(*state, "broken");
    lf_quilt_file q = {0};
    lf_error err;
    save_halves(folder, "a1.png", 80, 40);
    lf_test_write(folder, "a2.png", "no picture");
    lf_assert_status(lf_quilt_read(folder, NULL, 0, 0, &q, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.where, "broken/a2.png"));
    assert_null(strstr(err.what, "a2.png"));
}

static void pictures_are_turned_clockwise(void **state)
{
    const char *folder = new_folder(*state, "turned");
    static const struct {
        lf_turn rotate;
        double frame, aspect;
        const uint8_t *first; /* at the top left */
    } cases[] = {{LF_TURN_90, 0, 0.5, red},   {LF_TURN_180, 0, 2, blue},
                 {LF_TURN_270, 0, 0.5, blue}, {LF_TURN_AUTO, 0.7, 0.5, red},
                 {LF_TURN_AUTO, 1.7, 2, red}, {LF_TURN_AUTO, 0, 2, red}};
    save_halves(folder, "a1.png", 80, 40);
    save_halves(folder, "a2.png", 80, 40);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_quilt_file q = {0};
        read_folder(folder, (lf_photo){.rotate = cases[i].rotate, .frame = cases[i].frame}, &q);
        lf_assert_close(q.layout.aspect, cases[i].aspect, 0, 1e-12);
        assert_int_equal(q.layout.view_width, cases[i].aspect < 1 ? 40 : 80);
        assert_int_equal(q.layout.view_height, cases[i].aspect < 1 ? 80 : 40);
        for (int view = 0; view < 2; view++)
            assert_memory_equal(lf_views8_row(&q.views8, view, 0), cases[i].first, 3);
        assert_int_equal(q.notes.length, 0);
        lf_quilt_finish(&q);
    }
}

/* Upright and lying photos in one folder: auto turns those that differ from the first. */
static void auto_turns_what_differs_from_the_first(void **state)
{
    const char *folder = new_folder(*state, "both");
    lf_quilt_file q = {0};
    save_halves(folder, "a1.png", 80, 40);
    save_halves(folder, "a2.png", 40, 80);
    read_folder(folder, (lf_photo){.rotate = LF_TURN_AUTO}, &q);
    assert_int_equal(q.notes.length, 0);
    assert_memory_equal(lf_views8_row(&q.views8, 1, 0), red, 3);
    assert_memory_equal(lf_views8_row(&q.views8, 1, 39), blue, 3);
    lf_quilt_finish(&q);
}

/* ------------------------------------------------------------------------------------ panels -- */

static void a_panel_is_covered_by_what_is_cut_to_whole_pixels(void **state)
{
    const char *folder = new_folder(*state, "panel");
    lf_quilt_file q = {0};
    lf_photo photo = {.mode = LF_PHOTO_FILL, .frame = 1};
    save_halves(folder, "a1.png", 80, 40);
    for (int i = 0; i < 3; i++) {
        photo.position = (const int[]){0, LEFT, RIGHT}[i];
        read_folder(folder, photo, &q);
        lf_photo_cut(&photo, &q);
        assert_true(q.views8.width == 40 && q.views8.height == 40);
        assert_true(q.layout.view_width == 40 && q.layout.view_height == 40);
        lf_assert_close(q.layout.aspect, 1, 0, 0);
        assert_row(&q, 0, 0, 20, i == 2 ? blue : red);
        assert_row(&q, 0, 20, 40, i == 1 ? red : blue);
        q.notes.text[q.notes.length] = '\0';
        assert_told(&q, "50 % of the image");
        lf_quilt_finish(&q);
    }
    photo.mode = LF_PHOTO_FIT;
    for (int i = 0; i < 2; i++) {
        photo.position = i == 0 ? 0 : RIGHT; /* the panel's own business */
        read_folder(folder, photo, &q);
        lf_photo_cut(&photo, &q);
        assert_int_equal(q.views8.width, 80);
        assert_int_equal(q.notes.length > 0, i);
        lf_quilt_finish(&q);
    }
}

/* ------------------------------------------------------------------------------------ aspect -- */

static void save_view(const char *folder, const char *name, double aspect)
{
    enum { WIDTH = 64, HEIGHT = 32 };
    static uint8_t codes[WIDTH * HEIGHT * 3];
    static float light[WIDTH * HEIGHT * 3];
    const lf_views8 views8 = {1, WIDTH, HEIGHT, 0, 3 * WIDTH, codes};
    const lf_views32 views32 = {1, WIDTH, HEIGHT, 0, 3 * WIDTH, light, NULL, NULL, NULL};
    const lf_layout one = {1, 1, 1, WIDTH, HEIGHT, aspect};
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, name), true, &err), &err);
    if (strstr(name, ".exr"))
        lf_assert_ok(lf_view_write_exr(&file, &views32, 0, aspect, NULL, 0, &err), &err);
    else
        lf_assert_ok(lf_quilt_write_png(&file, &views8, &one, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
}

static void the_aspect_of_views_comes_back_from_their_pictures(void **state)
{
    static const char *const names[] = {"a.png", "a.exr"};
    for (int i = 0; i < 2; i++) {
        const char *folder = new_folder(*state, i ? "exr" : "png");
        static const double aspects[] = {1.6, 2, 0.75};
        for (int k = 0; k < 3; k++) {
            lf_quilt_file q = {0};
            save_view(folder, names[i], aspects[k]);
            read_folder(folder, (lf_photo){0}, &q);
            lf_assert_close(q.layout.aspect, aspects[k], 1e-6, 0);
            lf_quilt_finish(&q);
            read_folder(folder, (lf_photo){.aspect = 3, .rotate = LF_TURN_90}, &q);
            lf_assert_close(q.layout.aspect, 1 / 3.0, 1e-12, 0);
            lf_quilt_finish(&q);
        }
    }
}

/* That of the name wins over that of the pixels, and is won over by that which is asked for. */
static void the_aspect_of_a_quilt_is_that_which_is_said(void **state)
{
    lf_quilt_file q = {0};
    save_view(*state, "x_qs2x1a1.5.png", 1.6);
    save_view(*state, "x_qs2x1.png", 1.6);
    read_folder(lf_test_path(*state, "x_qs2x1a1.5.png"), (lf_photo){0}, &q);
    lf_assert_close(q.layout.aspect, 1.5, 0, 0);
    lf_quilt_finish(&q);
    read_folder(lf_test_path(*state, "x_qs2x1a1.5.png"), (lf_photo){.aspect = 1.7}, &q);
    lf_assert_close(q.layout.aspect, 1.7, 0, 0);
    lf_quilt_finish(&q);
    read_folder(lf_test_path(*state, "x_qs2x1.png"), (lf_photo){0}, &q);
    lf_assert_close(q.layout.aspect, 0.8, 1e-6, 0);
    lf_quilt_finish(&q);
}

static void transparent_parts_are_white_on_paper_and_ignored_elsewhere(void **state)
{
    (void)state;
    /* red: transparent, half covered and opaque; grey: a fifth covered */
    static const uint8_t pixels[4][4] = {
        {200, 0, 0, 0}, {200, 0, 0, 128}, {200, 0, 0, 255}, {50, 50, 50, 51}};
    char *folder = lf_test_folder();
    const char *path = lf_test_path(folder, "logo.png");
    png_image png = {.version = PNG_IMAGE_VERSION, .width = 4, .height = 1};
    png.format = PNG_FORMAT_RGBA;
    assert_true(png_image_write_to_file(&png, path, 0, pixels, 0, NULL));
    for (int on_paper = 0; on_paper < 2; on_paper++) {
        const lf_photo photo = {.on_paper = on_paper};
        lf_quilt_file quilt;
        lf_error err;
        lf_assert_ok(lf_quilt_read_photo(path, NULL, 1, 1, &photo, &quilt, &err), &err);
        const uint8_t *row = lf_views8_row(&quilt.views8, 0, 0);
        for (int i = 0; i < 4; i++)
            for (int c = 0; c < 3; c++) {
                const double cover = on_paper ? pixels[i][3] / 255.0 : 1.0;
                const double light =
                    cover * lf_srgb_to_linear(pixels[i][c] / 255.0) + (1.0 - cover);
                lf_assert_close(lf_srgb_to_linear(row[3 * i + c] / 255.0), light, 0.0, 0.005);
            }
        assert_non_null(strstr(quilt.notes.text, on_paper ? "3 pixels are not opaque; white paper"
                                                          : "alpha is ignored"));
        lf_quilt_finish(&quilt);
    }
    lf_test_folder_remove(folder);
}

/* 30 x 20 mm at 600 dpi is 709 x 472 pixels. */
static void sides_that_are_rounded_to_pixels_make_no_border(void **state)
{
    (void)state;
    static const float data[3] = {0};
    const lf_views32 views = {1, 1, 1, 3, 3, data, NULL, NULL, NULL};
    for (int turned = 0; turned < 2; turned++) {
        lf_image_notes notes = {0};
        char line[512];
        lf_print print = {.lpi = 60, .dpi = 600, .n_views = 1, .bits = 8};
        print.width_mm = turned ? 20 : 30;
        print.height_mm = turned ? 30 : 20;
        print.view_aspect = turned ? 2.0 / 3.0 : 1.5;
        lf_print_note_laid(&print, &views, &notes);
        for (size_t at = 0; lf_image_notes_next(&notes, &at, line, sizeof line);)
            assert_null(strstr(line, "borders"));
        print.view_aspect *= 1.02; /* negative control */
        notes = (lf_image_notes){0};
        size_t at = 0;
        lf_print_note_laid(&print, &views, &notes);
        assert_true(lf_image_notes_next(&notes, &at, line, sizeof line));
        assert_non_null(strstr(line, "borders"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_print_shows_it_whole_or_cut_where_it_is_said),
        cmocka_unit_test(what_has_the_shape_of_the_trimmed_sheet_covers_the_bleed),
        cmocka_unit_test(pictures_of_other_sizes_are_laid_onto_the_first_s),
        cmocka_unit_test(what_many_pictures_lose_is_told_in_a_line),
        cmocka_unit_test(one_that_cannot_be_read_is_named_once),
        cmocka_unit_test(pictures_are_turned_clockwise),
        cmocka_unit_test(auto_turns_what_differs_from_the_first),
        cmocka_unit_test(a_panel_is_covered_by_what_is_cut_to_whole_pixels),
        cmocka_unit_test(the_aspect_of_views_comes_back_from_their_pictures),
        cmocka_unit_test(the_aspect_of_a_quilt_is_that_which_is_said),
        cmocka_unit_test(transparent_parts_are_white_on_paper_and_ignored_elsewhere),
        cmocka_unit_test(sides_that_are_rounded_to_pixels_make_no_border),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
