/* Output jobs: what is written is what was asked for, whole or not at all. */
#include "tests/testing.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "daemon/output/output.h"

#define VIEWS 6
#define WIDTH 10
#define HEIGHT 8

/* A light field whose every pixel says where it belongs, in 8 bits and, decoded, in floats. */
typedef struct fixture {
    char *folder;
    uint8_t bytes[VIEWS][HEIGHT][WIDTH][3];
    float film[HEIGHT][VIEWS][WIDTH][3]; /* the film's order */
    lf_output_source source8, source32;
    lf_layout layout;
} fixture;

static double linear_of(uint8_t value)
{
    double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static int set_up(void **state)
{
    static fixture f;
    lf_render_settings settings = {
        .camera = {.n_views = VIEWS, .aspect = 1.25}, .width = WIDTH, .height = HEIGHT};
    f.folder = lf_test_folder();
    for (int view = 0; view < VIEWS; view++) {
        for (int y = 0; y < HEIGHT; y++) {
            for (int x = 0; x < WIDTH; x++) {
                const uint8_t rgb[3] = {(uint8_t)(40 * view + 3), (uint8_t)(30 * y + 5),
                                        (uint8_t)(25 * x + 7)};
                for (int c = 0; c < 3; c++) {
                    f.bytes[view][y][x][c] = rgb[c];
                    f.film[y][view][x][c] = (float)linear_of(rgb[c]);
                }
            }
        }
    }
    f.source8 = (lf_output_source){.views8 = {VIEWS, WIDTH, HEIGHT, sizeof f.bytes[0],
                                              sizeof f.bytes[0][0], &f.bytes[0][0][0][0]},
                                   .aspect = 1.25};
    f.source32 = lf_output_from_film(&settings, &f.film[0][0][0][0]);
    f.layout = (lf_layout){3, 2, VIEWS, WIDTH, HEIGHT, 1.25};
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    lf_test_folder_remove(f->folder);
    return 0;
}

static int count_files(const char *folder)
{
    DIR *dir = opendir(folder);
    int n = 0;
    if (!dir)
        return -1;
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir))
        n += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return n;
}

static void read_quilt(const char *path, lf_quilt_file *quilt)
{
    lf_error err = {0};
    lf_assert_ok(lf_quilt_read(path, NULL, 0, 0, quilt, &err), &err);
    assert_int_equal(quilt->layout.n_views, VIEWS);
    assert_int_equal(quilt->layout.view_width, WIDTH);
    assert_int_equal(quilt->layout.view_height, HEIGHT);
}

static void assert_views8(const fixture *f, const lf_views8 *views)
{
    for (int view = 0; view < VIEWS; view++)
        for (int y = 0; y < HEIGHT; y++)
            assert_memory_equal(lf_views8_row(views, view, y), f->bytes[view][y],
                                sizeof f->bytes[view][y]);
}

static void assert_views32(const fixture *f, const lf_views32 *views)
{
    for (int view = 0; view < VIEWS; view++)
        for (int y = 0; y < HEIGHT; y++)
            assert_memory_equal(lf_views32_row(views, view, y), f->film[y][view],
                                sizeof f->film[y][view]);
}

static void png_quilts_of_both_sources_come_back_unchanged(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    for (int is_float = 0; is_float < 2; is_float++) {
        const char *path =
            lf_test_path(f->folder, is_float ? "a_qs3x2a1.25.png" : "b_qs3x2a1.25.png");
        lf_output_request request = {.kind = &lf_output_quilt, .path = path, .layout = f->layout};
        lf_quilt_file quilt = {0};
        lf_assert_ok(lf_output_write(&request, is_float ? &f->source32 : &f->source8, &err), &err);
        read_quilt(path, &quilt);
        assert_false(quilt.is_float);
        assert_views8(f, &quilt.views8);
        lf_quilt_finish(&quilt);
    }
}

static void write_grey(const fixture *f, bool reconstructed, int code[VIEWS])
{
    static float film[HEIGHT][VIEWS][WIDTH][3];
    const char *path = lf_test_path(f->folder, "grey_qs3x2a1.25.png");
    lf_output_request request = {
        .kind = &lf_output_quilt, .path = path, .overwrite = true, .layout = f->layout};
    lf_output_source source = f->source32;
    lf_quilt_file quilt = {0};
    lf_error err = {0};
    for (size_t i = 0; i < sizeof film / sizeof(float); i++)
        (&film[0][0][0][0])[i] = (float)(0.3 * linear_of(100) + 0.7 * linear_of(101));
    source.views32.data = &film[0][0][0][0];
    source.reconstructed = reconstructed;
    lf_assert_ok(lf_output_write(&request, &source, &err), &err);
    read_quilt(path, &quilt);
    for (int view = 0; view < VIEWS; view++) {
        code[view] = 0;
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++)
                code[view] += lf_views8_row(&quilt.views8, view, y)[3 * x];
    }
    lf_quilt_finish(&quilt);
}

/* A grey between two codes is rounded, and dithered where the picture is reconstructed. */
static void reconstructed_pictures_are_dithered(void **state)
{
    int code[VIEWS];
    write_grey(*state, false, code);
    for (int view = 0; view < VIEWS; view++)
        assert_int_equal(code[view], 101 * WIDTH * HEIGHT);
    write_grey(*state, true, code);
    for (int view = 0; view < VIEWS; view++) {
        assert_true(code[view] > 100 * WIDTH * HEIGHT);
        assert_true(code[view] < 101 * WIDTH * HEIGHT);
    }
}

static void exr_quilts_hold_the_floats_and_the_settings(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    const char *path = lf_test_path(f->folder, "c_qs3x2a1.25.exr");
    json_t *settings = json_pack("{s:s, s:i, s:f, s:n}", "scene", "a scene.json", "views", 6,
                                 "fov_y", 14.5, "unknown");
    lf_output_request request = {
        .kind = &lf_output_quilt, .path = path, .layout = f->layout, .settings = settings};
    lf_quilt_file quilt = {0};
    char text[4096];
    lf_assert_ok(lf_output_write(&request, &f->source32, &err), &err);
    read_quilt(path, &quilt);
    assert_true(quilt.is_float);
    assert_views32(f, &quilt.views32);
    lf_quilt_finish(&quilt);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t n = fread(text, 1, sizeof text, file);
    fclose(file);
    assert_non_null(memmem(text, n, "quiltd.scene", 12));
    assert_non_null(memmem(text, n, "a scene.json", 12));
    assert_non_null(memmem(text, n, "14.5", 4));
    assert_null(memmem(text, n, "quiltd.unknown", 14));
    json_decref(settings);
}

static void a_folder_of_views_is_the_light_field_and_nothing_else(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    char folder[PATH_MAX];
    lf_output_request request = {.kind = &lf_output_views, .path = folder};
    lf_quilt_file quilt = {0};
    snprintf(folder, sizeof folder, "%s/views/", f->folder);
    lf_assert_ok(lf_output_write(&request, &f->source32, &err), &err);
    assert_int_equal(count_files(folder), VIEWS);
    lf_assert_ok(lf_quilt_read(folder, NULL, 0, 0, &quilt, &err), &err);
    assert_true(quilt.is_float);
    assert_int_equal(quilt.layout.n_views, VIEWS);
    assert_views32(f, &quilt.views32);
    lf_quilt_finish(&quilt);

    assert_int_equal(lf_output_write(&request, &f->source32, &err), LF_E_EXISTS);
    request.overwrite = true;
    lf_output_source fewer = f->source32;
    fewer.views32.n_views = 4;
    lf_test_write(folder, "view_notes.txt", "mine");
    lf_assert_ok(lf_output_write(&request, &fewer, &err), &err);
    /* the two old views are gone, the user's file is not */
    assert_int_equal(count_files(folder), 4 + 1);
}

/* And takes the place of one whose pictures were of the other kind. */
static void a_folder_of_pictures_is_the_light_field_and_nothing_else(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    char folder[PATH_MAX];
    lf_output_request request = {.kind = &lf_output_pictures, .path = folder};
    lf_quilt_file quilt = {0};
    snprintf(folder, sizeof folder, "%s/pictures/", f->folder);
    lf_assert_ok(lf_output_write(&request, &f->source8, &err), &err);
    lf_assert_ok(lf_quilt_read(folder, NULL, 0, 0, &quilt, &err), &err);
    assert_false(quilt.is_float);
    assert_int_equal(quilt.layout.n_views, VIEWS);
    for (int view = 0; view < VIEWS; view++)
        for (int y = 0; y < f->source8.views8.height; y++)
            assert_memory_equal(lf_views8_row(&quilt.views8, view, y),
                                lf_views8_row(&f->source8.views8, view, y),
                                3 * (size_t)f->source8.views8.width);
    lf_quilt_finish(&quilt);
    request.kind = &lf_output_views;
    assert_int_equal(lf_output_write(&request, &f->source32, &err), LF_E_EXISTS);
    request.overwrite = true;
    lf_assert_ok(lf_output_write(&request, &f->source32, &err), &err);
    assert_int_equal(count_files(folder), VIEWS);
    lf_assert_ok(lf_quilt_read(folder, NULL, 0, 0, &quilt, &err), &err);
    assert_views32(f, &quilt.views32);
    lf_quilt_finish(&quilt);
}

static void a_panel_picture_is_the_interlaced_views(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    lf_calibration calibration;
    lf_interlacer *interlacer = NULL;
    lf_image8 expected = {0};
    lf_image8 got = {0};
    const char *path = lf_test_path(f->folder, "panel.png");
    lf_calibration_portrait(&calibration);
    calibration.screen_width_px = 64;
    calibration.screen_height_px = 48;
    lf_output_request request = {
        .kind = &lf_output_panel, .path = path, .calibration = &calibration};
    lf_assert_ok(lf_output_write(&request, &f->source32, &err), &err);
    lf_assert_ok(lf_interlacer_create(&calibration, VIEWS, WIDTH, HEIGHT, 1.25, LF_FILTER_NEAREST,
                                      LF_INVERT_AUTO, &interlacer, &err),
                 &err);
    lf_assert_ok(lf_image8_init(&expected, 64, 48, 3), NULL);
    lf_interlace(interlacer, &f->source8.views8, &expected, NULL);
    lf_assert_ok(lf_image8_read(path, NULL, &got, &err), &err);
    assert_int_equal(got.width, 64);
    assert_int_equal(got.height, 48);
    for (int y = 0; y < 48; y++)
        assert_memory_equal(got.data + (size_t)y * got.stride,
                            expected.data + (size_t)y * expected.stride, 64 * 3);
    lf_interlacer_destroy(interlacer);
    lf_image8_finish(&expected);
    lf_image8_finish(&got);
}

static lf_print small_print(void)
{
    return (lf_print){
        .lpi = 60, .dpi = 600, .width_mm = 12, .height_mm = 9, .n_views = 6, .bits = 8};
}

static void a_print_lies_beside_its_manifest(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    const lf_print print = small_print();
    const char *path = lf_test_path(f->folder, "p.tif");
    lf_output_request request = {.kind = &lf_output_print, .path = path, .print = &print};
    struct stat info;
    lf_assert_ok(lf_output_write(&request, &f->source8, &err), &err);
    assert_int_equal(stat(path, &info), 0);
    assert_true(info.st_size > 283 * 213 * 3 / 2);
    json_t *manifest = json_load_file(lf_test_path(f->folder, "p.json"), 0, NULL);
    assert_true(json_is_object(manifest));
    json_decref(manifest);
    assert_int_equal(lf_output_write(&request, &f->source8, &err), LF_E_EXISTS);
}

static void a_print_renders_what_its_window_says(void **state)
{
    (void)state;
    const double fov = 0.3;
    const lf_camera camera = {.position = {0, 0, 5},
                              .up = {0, 1, 0},
                              .fov_y = fov,
                              .aspect = 2,
                              .n_views = 45,
                              .cone = 0.5};
    lf_print print = small_print();
    lf_print_shape shape;
    print.bleed_mm = 3;
    lf_print_shape_of(&print, &shape);
    lf_render_settings settings = {.camera = camera};
    lf_output_print_view(&print, &settings);
    assert_int_equal(settings.camera.n_views, 6);
    assert_int_equal(settings.width, shape.view_width);
    assert_int_equal(settings.height, shape.view_height);
    lf_assert_close(settings.camera.aspect, 12.0 / 9, 1e-12, 0);
    lf_assert_close(settings.camera.fov_y, fov, 0, 0);
    /* the bleed lies above and below the scene's own angle, to half a pixel of the raster */
    lf_assert_close(settings.window[1], -3.0 / 9, 0, 25.4 / 600 / 9);
    lf_assert_close(settings.window[3], 1 + 3.0 / 9, 0, 25.4 / 600 / 9);
    lf_assert_close((settings.window[2] - settings.window[0]) * 12, settings.width * 25.4 / 60,
                    1e-9, 0);
    assert_true(settings.window[0] < 0 && settings.window[2] > 1);
}

static void horizontal_lenses_roll_the_rig(void **state)
{
    (void)state;
    const lf_camera camera = {.position = {0, 0, 5},
                              .up = {0, 1, 0},
                              .fov_y = 0.3,
                              .aspect = 2,
                              .n_views = 45,
                              .cone = 0.5};
    lf_print print = small_print();
    lf_render_settings settings = {.camera = camera};
    print.horizontal = true;
    lf_output_print_view(&print, &settings);
    assert_true(settings.camera.rolled);
    lf_assert_close(settings.camera.up[0], 1, 1e-12, 0); /* what was right is up */
    lf_assert_close(settings.camera.up[1], 0, 0, 1e-12);
    lf_assert_close(settings.camera.aspect, 9.0 / 12, 1e-12, 0);
    /* the rolled picture's height is the print's width, at the same scale */
    lf_assert_close(tan(settings.camera.fov_y / 2) / 12, tan(0.3 / 2) / 9, 1e-12, 0);
    lf_assert_close((settings.window[2] - settings.window[0]) * 9, settings.width * 25.4 / 60, 1e-9,
                    0);
}

/* Slanted lenses: the window is that of the samples, which reach beyond the picture. */
static void slanted_lenses_have_a_wider_window(void **state)
{
    (void)state;
    lf_print print = small_print();
    lf_print_shape shape;
    lf_render_settings settings = {
        .camera = {.position = {0, 0, 5}, .up = {0, 1, 0}, .fov_y = 0.3, .cone = 0.5}};
    print.optics.slant = 20;
    print.phase_mm = 0.05;
    lf_print_shape_of(&print, &shape);
    lf_output_print_view(&print, &settings);
    lf_output_print_rig(&print, &settings.camera);
    assert_int_equal(settings.camera.n_rows, 0);
    assert_true(settings.camera.track == 0);
    assert_int_equal(settings.width, shape.n_lenses);
    lf_assert_close(settings.window[0],
                    0.5 + (shape.first_across_mm - 0.5 * shape.step_across_mm) / 12, 1e-12, 0);
    lf_assert_close((settings.window[2] - settings.window[0]) * 12,
                    settings.width * 25.4 / 60 / cos(20 * M_PI / 180), 1e-9, 0);
}

/* Micro lenses: a grid of cameras as wide as the cone, and as high as a lens is. */
static void micro_lenses_have_a_grid_of_cameras(void **state)
{
    (void)state;
    lf_print print = small_print();
    const lf_camera camera = {.position = {0, 0, 5}, .up = {0, 1, 0}, .fov_y = 0.3, .cone = 0.5};
    print.optics.grid = LF_LENS_SQUARE;
    print.n_views = 24;
    print.optics.view_rows = 4;
    lf_render_settings settings = {.camera = camera};
    lf_output_print_view(&print, &settings);
    lf_output_print_rig(&print, &settings.camera);
    assert_int_equal(settings.camera.n_views, 6);
    assert_int_equal(settings.camera.n_rows, 4);
    lf_assert_close(settings.camera.track, 10 * tan(0.25) * 5 / 6, 1e-12, 0);
    lf_assert_close(settings.camera.rows_height, 10 * tan(0.25) * 3 / 4, 1e-12, 0);
    assert_false(settings.camera.own_windows);
    /* the middle of a sample is the middle of a lens, down too */
    const double lens = 25.4 / 60 / 9, top = settings.window[1] + 0.5 * lens;
    lf_assert_close((top - 0.5) / lens, round((top - 0.5) / lens), 0, 1e-9);
    print.optics.grid = LF_LENS_HEXAGONAL;
    settings.camera = camera;
    lf_output_print_view(&print, &settings);
    lf_output_print_rig(&print, &settings.camera);
    lf_assert_close(settings.camera.rows_height, 10 * tan(0.25) * 3 / 4 * 2 / sqrt(3), 1e-12, 0);
}

static void names_are_completed_and_contradictions_refused(void **state)
{
    static const struct {
        const lf_output_kind *kind;
        const char *path, *expected; /* NULL = refused */
    } cases[] = {
        {&lf_output_quilt, "out.png", "out_qs3x2a1.25.png"},
        {&lf_output_quilt, "a.b/out.exr", "a.b/out_qs3x2a1.25.exr"},
        {&lf_output_quilt, "out_qs3x2a1.25.png", "out_qs3x2a1.25.png"},
        {&lf_output_quilt, "out_qs3x2.png", "out_qs3x2.png"},
        {&lf_output_quilt, "out_qs2x3a1.25.png", NULL},
        {&lf_output_quilt, "out_qs3x2a0.75.png", NULL},
        {&lf_output_quilt, "out.jpg", "out_qs3x2a1.25.jpg"},
        {&lf_output_quilt, "out.JPEG", "out_qs3x2a1.25.JPEG"},
        {&lf_output_quilt, "out.gif", NULL},
        {&lf_output_still, "out.png", "out.png"},
        {&lf_output_still, "out_qs1x1a0.75.jpg", "out_qs1x1a0.75.jpg"},
        {&lf_output_still, "out_qs3x2a1.25.png", NULL},
        {&lf_output_still, "out/", NULL},
        {&lf_output_quilt, "out/", NULL},
        {&lf_output_quilt, "out", NULL},
        {&lf_output_views, "out/", "out/"},
        {&lf_output_views, "out.exr", NULL},
        {&lf_output_panel, "woven.png", "woven.png"},
        {&lf_output_panel, "woven.exr", NULL},
        {&lf_output_print, "p.tif", "p.tif"},
        {&lf_output_print, "p.TIFF", "p.TIFF"},
        {&lf_output_print, "p.pdf", "p.pdf"},
        {&lf_output_chart, "p.pdf", "p.pdf"},
        {&lf_output_frame_set, "p/", "p/"},
        {&lf_output_frame_set, "p.tif", NULL},
        {&lf_output_print, "p.png", NULL},
    };
    const fixture *f = *state;

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char *path = NULL;
        lf_error err = {0};
        lf_status status = lf_output_path(cases[i].kind, cases[i].path, &f->layout, &path, &err);
        print_message("%s\n", cases[i].path);
        assert_int_equal(status, cases[i].expected ? LF_OK : LF_E_ARG);
        if (cases[i].expected)
            assert_string_equal(path, cases[i].expected);
        lf_free(path);
    }
    char *manifest = lf_output_file_name(&lf_output_print, "a.b/print.tiff", 1);
    assert_string_equal(manifest, "a.b/print.json");
    lf_free(manifest);
    char *relief = lf_output_file_name(&lf_output_print, "a.b/print.tiff", 2);
    assert_string_equal(relief, "a.b/print_relief.tif");
    lf_free(relief);
    lf_print print = small_print();
    assert_int_equal(lf_output_n_files(&lf_output_print, &print, 9), 2);
    print.relief = true;
    assert_int_equal(lf_output_n_files(&lf_output_print, &print, 9), 3);
    assert_int_equal(lf_output_n_files(&lf_output_print, NULL, 9), 2);
    const lf_layout huge = {60, 60, 3600, 2000, 2000, 1};
    char *path = NULL;
    assert_int_equal(lf_output_path(&lf_output_quilt, "out.png", &huge, &path, NULL), LF_E_ARG);
}

static void cancelled_and_refused_jobs_publish_nothing(void **state)
{
    const fixture *f = *state;
    lf_cancel cancel = 1;
    lf_print print = small_print();
    lf_calibration calibration;
    const struct {
        const lf_output_kind *kind;
        const char *name;
    } cases[] = {{&lf_output_quilt, "x_qs3x2a1.25.png"},
                 {&lf_output_views, "x/"},
                 {&lf_output_panel, "x.png"},
                 {&lf_output_print, "x.tif"}};
    int before = count_files(f->folder);

    lf_calibration_portrait(&calibration);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_error err = {0};
        lf_output_request request = {.kind = cases[i].kind,
                                     .path = lf_test_path(f->folder, cases[i].name),
                                     .layout = f->layout,
                                     .print = &print,
                                     .calibration = &calibration,
                                     .cancel = &cancel};
        assert_int_equal(lf_output_write(&request, &f->source32, &err), LF_E_CANCELLED);
        assert_int_equal(count_files(f->folder), before);
    }
    lf_error err = {0};
    print.icc_path = "/nonexistent/profile.icc";
    lf_output_request request = {
        .kind = &lf_output_print, .path = lf_test_path(f->folder, "x.tif"), .print = &print};
    assert_int_not_equal(lf_output_write(&request, &f->source32, &err), LF_OK);
    request = (lf_output_request){.kind = &lf_output_quilt,
                                  .path = lf_test_path(f->folder, "nowhere/x_qs3x2a1.25.png"),
                                  .layout = f->layout};
    assert_int_equal(lf_output_write(&request, &f->source32, &err), LF_E_IO);
    request.path = lf_test_path(f->folder, "x_qs3x2a1.25.png");
    request.tonemap = "vivid";
    assert_int_equal(lf_output_write(&request, &f->source32, &err), LF_E_ARG);
    assert_int_equal(count_files(f->folder), before);
}

static bool is_open(int fd)
{
    return fcntl(fd, F_GETFD) != -1;
}

static void descriptors_are_written_and_closed(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    const char *path = lf_test_path(f->folder, "handed.png");
    int fd = open(path, O_RDWR | O_CREAT | O_TRUNC, 0600);
    lf_image8 image = {0};
    assert_true(fd >= 0);
    lf_output_request request = {.kind = &lf_output_quilt,
                                 .path = "/not/ours/handed.png",
                                 .fds = &fd,
                                 .n_fds = 1,
                                 .layout = f->layout};
    lf_assert_ok(lf_output_write(&request, &f->source8, &err), &err);
    assert_false(is_open(fd));
    lf_assert_ok(lf_image8_read(path, NULL, &image, &err), &err);
    assert_int_equal(image.width, 3 * WIDTH);
    lf_image8_finish(&image);

    /* too few for the job: refused, and closed all the same */
    lf_print print = small_print();
    fd = open(path, O_RDWR);
    request = (lf_output_request){
        .kind = &lf_output_print, .path = "p.tif", .fds = &fd, .n_fds = 1, .print = &print};
    assert_int_equal(lf_output_write(&request, &f->source8, &err), LF_E_ARG);
    assert_false(is_open(fd));

    /* one that cannot be written */
    fd = open(path, O_RDONLY);
    request = (lf_output_request){
        .kind = &lf_output_quilt, .path = "q.png", .fds = &fd, .n_fds = 1, .layout = f->layout};
    assert_int_not_equal(lf_output_write(&request, &f->source8, &err), LF_OK);
    assert_false(is_open(fd));

    int fds[VIEWS];
    for (int i = 0; i < VIEWS; i++) {
        char name[32];
        snprintf(name, sizeof name, "fd%d.exr", i);
        fds[i] = open(lf_test_path(f->folder, name), O_RDWR | O_CREAT | O_TRUNC, 0600);
        assert_true(fds[i] >= 0);
    }
    request =
        (lf_output_request){.kind = &lf_output_views, .path = "views/", .fds = fds, .n_fds = VIEWS};
    lf_assert_ok(lf_output_write(&request, &f->source8, &err), &err);
    for (int i = 0; i < VIEWS; i++)
        assert_false(is_open(fds[i]));
    lf_image32 view = {0};
    lf_assert_ok(lf_image32_read(lf_test_path(f->folder, "fd5.exr"), NULL, &view, &err), &err);
    for (int y = 0; y < HEIGHT; y++)
        assert_memory_equal(view.data + (size_t)y * WIDTH * 3, f->film[y][5], sizeof f->film[y][5]);
    lf_image32_finish(&view);
}

static void note_progress(void *context, double fraction)
{
    double *last = context;
    assert_true(fraction >= last[0] && fraction <= 1);
    last[0] = fraction;
}

static void progress_rises_to_one(void **state)
{
    const fixture *f = *state;
    lf_error err = {0};
    const lf_print print = small_print();
    const struct {
        const lf_output_kind *kind;
        const char *name;
    } cases[] = {{&lf_output_quilt, "r_qs3x2a1.25.png"},
                 {&lf_output_views, "r/"},
                 {&lf_output_print, "r.tif"}};

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double last = 0;
        lf_output_request request = {.kind = cases[i].kind,
                                     .path = lf_test_path(f->folder, cases[i].name),
                                     .layout = f->layout,
                                     .print = &print,
                                     .progress = note_progress,
                                     .context = &last};
        lf_assert_ok(lf_output_write(&request, &f->source32, &err), &err);
        lf_assert_close(last, 1, 0, 0);
    }
}

static void names_of_choices_are_known(void **state)
{
    const lf_output_kind *kind = &lf_output_quilt;
    const lf_param *filter = lf_param_find(lf_panel_params, "filter"),
                   *invert = lf_param_find(lf_panel_params, "invert");
    lf_panel_options panel = {0};
    lf_error err = {0};
    (void)state;
    lf_assert_ok(lf_output_kind_from_name("print", &kind, &err), &err);
    assert_ptr_equal(kind, &lf_output_print);
    assert_int_equal(lf_output_kind_from_name("film", &kind, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "quilt, still, views"));
    assert_ptr_equal(kind, &lf_output_print);
    lf_assert_ok(lf_param_from_text(filter, "linear", &panel, &err), &err);
    lf_assert_ok(lf_param_from_text(invert, "no", &panel, &err), &err);
    assert_int_equal(panel.filter, LF_FILTER_LINEAR);
    assert_int_equal(panel.invert, LF_INVERT_NO);
    lf_assert_ok(lf_param_from_text(invert, "yes", &panel, &err), &err);
    assert_int_equal(panel.invert, LF_INVERT_YES);
    assert_int_equal(lf_param_from_text(filter, "cubic", &panel, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "nearest or linear"));
}

/* What the command line, the socket and quiltctl count on. */
static void every_kind_says_all_that_is_asked_of_it(void **state)
{
    (void)state;
    int n = 0;
    for (; lf_output_kinds[n]; n++) {
        const lf_output_kind *kind = lf_output_kinds[n], *found = NULL;
        lf_error err = {0};
        char *path = NULL;
        assert_non_null(kind->write);
        assert_true(kind->endings[0] && lf_output_fits(kind, kind->endings[0]));
        assert_false(lf_output_fits(kind, "x.lfstate"));
        lf_assert_ok(lf_output_kind_from_name(kind->name, &found, &err), &err);
        assert_ptr_equal(found, kind);
        assert_int_equal(lf_output_path(kind, "x.lfstate", NULL, &path, &err), LF_E_ARG);
        assert_non_null(strstr(err.what, kind->what));
        assert_non_null(strstr(err.what, kind->endings[0]));
        /* more files than one have names of their own, and their folder is looked after */
        assert_true(kind->n_files == 1 || kind->file_name);
        assert_int_equal(!kind->surplus, kind->endings[0][0] != '/');
        assert_int_equal(!kind->check_print, !kind->asks);
        assert_true(kind->option || !(kind->check_print || kind->needs_panel || kind->is_drawn));
        for (int i = 0; i < n; i++) {
            const lf_output_kind *other = lf_output_kinds[i];
            assert_string_not_equal(other->name, kind->name);
            /* what only its ending asks for is asked for by one */
            for (int j = 0; !kind->option && kind->endings[j]; j++)
                assert_false(!other->option && lf_output_fits(other, kind->endings[j]));
        }
    }
    const lf_output_kind *none = NULL;
    lf_error err = {0};
    assert_int_equal(lf_output_kind_from_name("film", &none, &err), LF_E_ARG);
    for (int i = 0; i < n; i++)
        assert_non_null(strstr(err.what, lf_output_kinds[i]->name));
    assert_null(none);
}

static void settings_record_what_made_the_picture_and_not_the_run(void **state)
{
    const fixture *f = *state;
    lf_render_settings settings = {
        .camera = {.n_views = 6, .aspect = 0.75, .fov_y = M_PI / 12, .cone = M_PI / 4},
        .seed = UINT64_MAX};
    lf_film_settings film = {.exposure = 1.5, .tonemap = "filmic"};
    json_t *record =
        lf_output_settings("s.json", &settings, &f->layout, LF_ESTIMATOR_CV, false, 90, &film);
    assert_non_null(record);
    assert_string_equal(json_string_value(json_object_get(record, "seed")), "18446744073709551615");
    assert_string_equal(json_string_value(json_object_get(record, "integrator")), "mvpt");
    assert_string_equal(json_string_value(json_object_get(record, "estimator")), "cv");
    assert_string_equal(json_string_value(json_object_get(record, "tonemap")), "filmic");
    lf_assert_close(json_number_value(json_object_get(record, "fov_y")), 15, 1e-12, 0);
    lf_assert_close(json_number_value(json_object_get(record, "cone")), 45, 1e-12, 0);
    lf_assert_close(json_number_value(json_object_get(record, "passes")), 90, 0, 0);
    assert_null(json_object_get(record, "threads"));
    assert_null(json_object_get(record, "seconds"));
    json_decref(record);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_quilts_of_both_sources_come_back_unchanged),
        cmocka_unit_test(reconstructed_pictures_are_dithered),
        cmocka_unit_test(exr_quilts_hold_the_floats_and_the_settings),
        cmocka_unit_test(a_folder_of_views_is_the_light_field_and_nothing_else),
        cmocka_unit_test(a_folder_of_pictures_is_the_light_field_and_nothing_else),
        cmocka_unit_test(a_panel_picture_is_the_interlaced_views),
        cmocka_unit_test(a_print_lies_beside_its_manifest),
        cmocka_unit_test(a_print_renders_what_its_window_says),
        cmocka_unit_test(horizontal_lenses_roll_the_rig),
        cmocka_unit_test(slanted_lenses_have_a_wider_window),
        cmocka_unit_test(micro_lenses_have_a_grid_of_cameras),
        cmocka_unit_test(names_are_completed_and_contradictions_refused),
        cmocka_unit_test(cancelled_and_refused_jobs_publish_nothing),
        cmocka_unit_test(descriptors_are_written_and_closed),
        cmocka_unit_test(progress_rises_to_one),
        cmocka_unit_test(names_of_choices_are_known),
        cmocka_unit_test(every_kind_says_all_that_is_asked_of_it),
        cmocka_unit_test(settings_record_what_made_the_picture_and_not_the_run),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
