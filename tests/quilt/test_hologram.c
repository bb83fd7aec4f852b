/* Plates of holograms: indices against fields that are made from the definition, sample by sample,
 * and files against what the reference page says of them. */
#include <fcntl.h>
#include <sys/stat.h>

#include <lcms2.h>
#include <tiffio.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "quilt/hologram/plate.h"
#include "tests/testing.h"

#define ROWS 2
#define COLUMNS 3
#define WIDTH 5
#define HEIGHT 4
#define SAMPLES (ROWS * COLUMNS * WIDTH * HEIGHT)

static const char *const words[] = {"u", "v", "hx", "hy", "transpose", "rotate180"};
enum { N_WORDS = sizeof words / sizeof *words };

/* -------------------------------------------------------------------------------- definition -- */

/* A field by the reference page: value[((hy * n[1] + hx) * n[2] + v) * n[3] + u] names the camera
 * and pixel that it comes from, as one number. */
typedef struct field {
    int n[4]; /* Hy, Hx, V, U */
    int value[SAMPLES];
} field;

static int number_of(int row, int column, int y, int x)
{
    return ((row * COLUMNS + column) * HEIGHT + y) * WIDTH + x;
}

static int *at(field *f, int hy, int hx, int v, int u)
{
    return &f->value[((hy * f->n[1] + hx) * f->n[2] + v) * f->n[3] + u];
}

/* Eyes: the leftmost is u = 0 and the topmost row, which is the last of the cameras, is v = 0. */
static field of_eyes(void)
{
    field f = {.n = {HEIGHT, WIDTH, ROWS, COLUMNS}};
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++)
            for (int y = 0; y < HEIGHT; y++)
                for (int x = 0; x < WIDTH; x++)
                    *at(&f, y, x, ROWS - 1 - row, column) = number_of(row, column, y, x);
    return f;
}

/* Cells: what a camera sees at its right goes to an eye at the left, and what it sees above goes to
 * an eye below. */
static field of_cells(void)
{
    field f = {.n = {ROWS, COLUMNS, HEIGHT, WIDTH}};
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++)
            for (int y = 0; y < HEIGHT; y++)
                for (int x = 0; x < WIDTH; x++)
                    *at(&f, ROWS - 1 - row, column, HEIGHT - 1 - y, WIDTH - 1 - x) =
                        number_of(row, column, y, x);
    return f;
}

/* One flip of a written field. */
static field flipped(const field *f, const char *word)
{
    field from = *f, out = *f;
    const bool turns = strcmp(word, "transpose") == 0, half = strcmp(word, "rotate180") == 0;
    if (turns) {
        out.n[2] = f->n[3];
        out.n[3] = f->n[2];
    }
    for (int hy = 0; hy < f->n[0]; hy++)
        for (int hx = 0; hx < f->n[1]; hx++)
            for (int v = 0; v < f->n[2]; v++)
                for (int u = 0; u < f->n[3]; u++) {
                    const int down = strcmp(word, "hy") == 0 ? f->n[0] - 1 - hy : hy,
                              right = strcmp(word, "hx") == 0 ? f->n[1] - 1 - hx : hx,
                              v2 = half || strcmp(word, "v") == 0 ? f->n[2] - 1 - v : v,
                              u2 = half || strcmp(word, "u") == 0 ? f->n[3] - 1 - u : u;
                    *at(&out, down, right, turns ? u2 : v2, turns ? v2 : u2) =
                        *at(&from, hy, hx, v, u);
                }
    return out;
}

static lf_plate plate_of(bool camera_is_cell, const char *flips)
{
    lf_plate plate = {.columns = COLUMNS,
                      .rows = ROWS,
                      .width = WIDTH,
                      .height = HEIGHT,
                      .parts = 1,
                      .camera_is_cell = camera_is_cell};
    lf_error err = {0};
    lf_assert_ok(lf_plate_flips_read(flips, &plate.flips, &err), &err);
    return plate;
}

/* True if the plate's indices give this field, in both directions. */
static bool is_field(const lf_plate *plate, const field *f)
{
    field want = *f;
    const lf_plate_place n = lf_plate_size(plate);
    if (n.hy != f->n[0] || n.hx != f->n[1] || n.v != f->n[2] || n.u != f->n[3])
        return false;
    for (int hy = 0; hy < n.hy; hy++)
        for (int hx = 0; hx < n.hx; hx++)
            for (int v = 0; v < n.v; v++)
                for (int u = 0; u < n.u; u++) {
                    const lf_plate_place place = {hy, hx, v, u};
                    const lf_plate_sample s = lf_plate_sample_at(plate, place);
                    const lf_plate_place back = lf_plate_place_of(plate, s);
                    if (number_of(s.row, s.column, s.y, s.x) != *at(&want, hy, hx, v, u) ||
                        back.hy != hy || back.hx != hx || back.v != v || back.u != u)
                        return false;
                }
    return true;
}

/* ------------------------------------------------------------------------------------- tests -- */

static void indices_follow_the_definition(void **state)
{
    (void)state;
    const field eyes = of_eyes(), cells = of_cells();
    const lf_plate of_eye = plate_of(false, ""), of_cell = plate_of(true, "");
    assert_true(is_field(&of_eye, &eyes));
    assert_true(is_field(&of_cell, &cells));
    /* controls: a turn that is forgotten, and mirrored rows */
    const field turned = flipped(&cells, "rotate180"), upside = flipped(&eyes, "v");
    assert_false(is_field(&of_cell, &turned));
    assert_false(is_field(&of_eye, &upside));
}

/* Every list of up to three words, applied from left to right. */
static void flips_and_their_compositions_follow_the_definition(void **state)
{
    (void)state;
    int n_different = 0;
    for (int cells = 0; cells < 2; cells++)
        for (int k = 0; k < N_WORDS * N_WORDS * N_WORDS; k++) {
            const char *a = words[k % N_WORDS], *b = words[k / N_WORDS % N_WORDS],
                       *c = words[k / N_WORDS / N_WORDS];
            char list[64];
            const field plain = cells ? of_cells() : of_eyes(), one = flipped(&plain, a),
                        two = flipped(&one, b), three = flipped(&two, c);
            lf_plate plate = plate_of(cells, a);
            assert_true(is_field(&plate, &one));
            assert_false(is_field(&plate, &plain));
            snprintf(list, sizeof list, "%s,%s,%s", a, b, c);
            plate = plate_of(cells, list);
            if (!is_field(&plate, &three))
                fail_msg("%s of %s", list, cells ? "cells" : "eyes");
            snprintf(list, sizeof list, "%s,%s,%s", c, b, a);
            plate = plate_of(cells, list);
            n_different += !is_field(&plate, &three);
        }
    assert_true(n_different > 50); /* the order counts */
}

static void a_flip_twice_is_none(void **state)
{
    (void)state;
    const field plain = of_eyes();
    for (int i = 0; i < N_WORDS; i++) {
        char list[64];
        snprintf(list, sizeof list, "%s,%s", words[i], words[i]);
        const lf_plate plate = plate_of(false, list);
        assert_true(is_field(&plate, &plain));
    }
    lf_plate_flips flips;
    lf_error err = {0};
    static const char *const wrong[] = {"w", "u;v", ",u", "u v", "rotate18", "U", "hxhy"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(lf_plate_flips_read(wrong[i], &flips, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "unknown word \"hxhy\""));
}

/* ------------------------------------------------------------------------------------- files -- */

static const lf_plate_run plain_run;

/* Samples of a task, byte for byte another. */
static uint8_t byte_of(int number, int byte)
{
    return (uint8_t)((uint32_t)(number * 6 + byte) * 2654435761u >> 11);
}

/* Writes all tasks, the last row first, and finishes. order: of the cameras. */
static lf_status write_plate(const lf_plate *plate, const char *folder, const field *meaning,
                             lf_error *err)
{
    const int bytes = (int)lf_plate_pixel_bytes(plate), n = lf_plate_task_cameras(plate);
    field want = *meaning;
    uint8_t *samples = lf_calloc(lf_plate_task_bytes(plate), 1);
    json_t *facts = json_pack("{s:s}", "quiltd", "test");
    lf_status status = lf_plate_begin(plate, folder, facts, false, err);
    assert_non_null(samples);
    for (int task = lf_plate_tasks(plate) - 1; task >= 0 && status == LF_OK; task--) {
        assert_false(lf_plate_has_task(plate, folder, facts, task));
        for (int i = 0; i < n * plate->height * plate->width; i++) {
            const lf_plate_sample s = {lf_plate_task_row(plate, task),
                                       lf_plate_task_first(plate, task) +
                                           i / (plate->height * plate->width),
                                       i / plate->width % plate->height, i % plate->width};
            const lf_plate_place p = lf_plate_place_of(plate, s);
            for (int b = 0; b < bytes; b++)
                samples[i * bytes + b] = byte_of(*at(&want, p.hy, p.hx, p.v, p.u), b);
        }
        status = lf_plate_write_task(plate, folder, facts, task, samples, &plain_run, err);
        assert_true(status != LF_OK || lf_plate_has_task(plate, folder, facts, task));
    }
    if (status == LF_OK)
        status = lf_plate_finish(plate, folder, facts, &plain_run, err);
    assert_true(status != LF_OK || lf_plate_is_finished(plate, folder, facts));
    json_decref(facts);
    lf_free(samples);
    return status;
}

static uint64_t number_in(const uint8_t *bytes, int n)
{
    uint64_t number = 0;
    while (n-- > 0)
        number = number << 8 | bytes[n];
    return number;
}

/* The header is as the page says, and the samples are those of the field. */
static void check_raw(const char *path, const field *meaning, int channels, int type, int encoding)
{
    char *text = NULL;
    size_t size = 0;
    lf_error err = {0};
    field want = *meaning;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 20, &text, &size, &err), &err);
    const uint8_t *raw = (const uint8_t *)text;
    const int bytes = channels * (type == 0 ? 1 : 2);
    assert_memory_equal(raw, "LFPLATE1", 8);
    assert_int_equal(number_in(raw + 8, 4), 64);
    assert_int_equal(number_in(raw + 12, 4), 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(number_in(raw + 16 + 4 * i, 4), want.n[i]);
    assert_int_equal(number_in(raw + 32, 4), channels);
    assert_int_equal(number_in(raw + 36, 4), type);
    assert_int_equal(number_in(raw + 40, 4), encoding);
    assert_int_equal(number_in(raw + 48, 8), SAMPLES * bytes);
    assert_int_equal(size, 64 + SAMPLES * bytes);
    for (int i = 0; i < SAMPLES; i++)
        for (int b = 0; b < bytes; b++)
            assert_int_equal(raw[64 + i * bytes + b], byte_of(want.value[i], b));
    lf_free(text);
}

static const char *view_name(const char *folder, int v, int u)
{
    char name[64];
    snprintf(name, sizeof name, "views/r%03d/c%04d.png", v, u);
    return lf_test_path(folder, name);
}

static const char *hogel_name(const char *folder, int hy, int hx, const char *ending)
{
    char name[64];
    snprintf(name, sizeof name, "hogels/r%04d/c%04d.%s", hy, hx, ending);
    return lf_test_path(folder, name);
}

/* Pictures of one form, and one file, are the same samples, whoever the cameras are. */
static void all_forms_hold_the_field(void **state)
{
    const char *folder = *state;
    const field meaning =
        of_cells(); /* 2 x 3 cells of 4 x 5 directions, of both kinds of cameras */
    for (int cells = 0; cells < 2; cells++)
        for (int form = LF_PLATE_VIEWS; form <= LF_PLATE_RAW; form++) {
            lf_plate plate = plate_of(cells, "");
            char path[PATH_MAX];
            lf_error err = {0};
            field want = meaning;
            plate.form = (lf_plate_form)form;
            if (!cells) { /* eyes: as many as directions, and pixels as cells */
                plate.rows = HEIGHT;
                plate.columns = WIDTH;
                plate.height = ROWS;
                plate.width = COLUMNS;
            }
            snprintf(path, sizeof path, "%s/forms_%d_%d", folder, cells, form);
            lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
            if (form == LF_PLATE_RAW) {
                check_raw(lf_test_path(path, "plate.raw"), &meaning, 3, 0, 0);
                continue;
            }
            const bool is_view = form == LF_PLATE_VIEWS;
            for (int k = 0; k < SAMPLES; k++) {
                const int u = k % WIDTH, v = k / WIDTH % HEIGHT,
                          hx = k / (WIDTH * HEIGHT) % COLUMNS, hy = k / (WIDTH * HEIGHT * COLUMNS);
                lf_image8 image = {0};
                const char *file =
                    is_view ? view_name(path, v, u) : hogel_name(path, hy, hx, "png");
                lf_assert_ok(lf_image8_read(file, NULL, &image, &err), &err);
                assert_int_equal(image.width, is_view ? COLUMNS : WIDTH);
                assert_int_equal(image.height, is_view ? ROWS : HEIGHT);
                const uint8_t *pixel =
                    image.data + (size_t)(is_view ? hy : v) * image.stride + 3 * (is_view ? hx : u);
                for (int b = 0; b < 3; b++)
                    assert_int_equal(pixel[b], byte_of(*at(&want, hy, hx, v, u), b));
                lf_image8_finish(&image);
            }
        }
}

static void a_flipped_plate_is_written_flipped(void **state)
{
    const char *folder = *state;
    static const char *const lists[] = {"u", "hy,transpose", "rotate180,hx", "transpose,v"};
    for (int cells = 0; cells < 2; cells++)
        for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
            lf_plate plate = plate_of(cells, lists[i]);
            field meaning = cells ? of_cells() : of_eyes();
            char path[PATH_MAX], list[64], *rest = NULL;
            lf_error err = {0};
            snprintf(list, sizeof list, "%s", lists[i]);
            for (char *word = strtok_r(list, ",", &rest); word; word = strtok_r(NULL, ",", &rest))
                meaning = flipped(&meaning, word);
            plate.form = LF_PLATE_RAW;
            snprintf(path, sizeof path, "%s/flips_%d_%zu", folder, cells, i);
            lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
            check_raw(lf_test_path(path, "plate.raw"), &meaning, 3, 0, 0);
        }
}

/* One row of directions; a track in parts. */
static void one_row_of_directions_has_plain_names(void **state)
{
    const char *folder = *state;
    lf_plate plate = {.columns = 6, .rows = 1, .width = 5, .height = 4, .parts = 3};
    field meaning = {.n = {4, 5, 1, 6}};
    char path[PATH_MAX];
    lf_error err = {0};
    for (int i = 0; i < SAMPLES; i++)
        meaning.value[i] = i;
    snprintf(path, sizeof path, "%s/row", folder);
    assert_int_equal(lf_plate_tasks(&plate), 3);
    lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
    for (int u = 0; u < 6; u++) {
        lf_image8 image = {0};
        char name[64];
        snprintf(name, sizeof name, "views/view_%04d.png", u);
        lf_assert_ok(lf_image8_read(lf_test_path(path, name), NULL, &image, &err), &err);
        for (int k = 0; k < 20; k++)
            assert_int_equal(image.data[3 * k], byte_of(*at(&meaning, k / 5, k % 5, 0, u), 0));
        lf_image8_finish(&image);
    }
    assert_int_equal(access(lf_test_path(path, "rows/r002.json"), F_OK), 0);
    assert_int_not_equal(access(lf_test_path(path, "rows/r000.raw"), F_OK), 0);
    plate.form = LF_PLATE_RAW;
    snprintf(path, sizeof path, "%s/row_raw", folder);
    lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
    check_raw(lf_test_path(path, "plate.raw"), &meaning, 3, 0, 0);
}

/* Bytes of a sample as a half: finite, so that all of them can be read back. */
static float half_of(int number, int channel)
{
    const int bits = byte_of(number, 2 * channel) | (byte_of(number, 2 * channel + 1) << 8);
    const int exponent = bits >> 10 & 31;
    const double size = exponent == 0 ? (bits & 1023) * pow(2, -24)
                                      : (1024 + (bits & 1023)) * pow(2, exponent - 25);
    return (float)(bits & 0x8000 ? -size : size);
}

static void formats_keep_every_bit(void **state)
{
    const char *folder = *state;
    field meaning = of_cells();
    lf_error err = {0};
    char path[PATH_MAX];
    for (int grey = 0; grey < 2; grey++) {
        lf_plate plate = plate_of(true, "rotate180");
        meaning = of_cells();
        meaning = flipped(&meaning, "rotate180");
        plate.form = LF_PLATE_HOGELS;
        plate.is_grey = grey;
        plate.format = LF_PLATE_TIFF;
        snprintf(path, sizeof path, "%s/tiff_%d", folder, grey);
        lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
        TIFF *tiff = TIFFOpen(hogel_name(path, 1, 2, "tif"), "r");
        uint16_t bits = 0, channels = 0, row[3 * WIDTH];
        assert_non_null(tiff);
        TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
        TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
        assert_int_equal(bits, 16);
        assert_int_equal(channels, grey ? 1 : 3);
        for (int v = 0; v < HEIGHT; v++) {
            assert_int_equal(TIFFReadScanline(tiff, row, (uint32_t)v, 0), 1);
            for (int u = 0; u < WIDTH; u++)
                for (int c = 0; c < channels; c++)
                    assert_int_equal(row[u * channels + c],
                                     byte_of(*at(&meaning, 1, 2, v, u), 2 * c) |
                                         (byte_of(*at(&meaning, 1, 2, v, u), 2 * c + 1) << 8));
        }
        TIFFClose(tiff);
        plate.format = LF_PLATE_EXR;
        snprintf(path, sizeof path, "%s/exr_%d", folder, grey);
        lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
        lf_image32 image = {0};
        lf_assert_ok(lf_image32_read(hogel_name(path, 1, 2, "exr"), NULL, &image, &err), &err);
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            for (int c = 0; c < 3; c++) {
                const float want = half_of(*at(&meaning, 1, 2, k / WIDTH, k % WIDTH), grey ? 0 : c);
                if (fabsf(want) <= 65504) /* infinities and NaN are the reader's affair */
                    assert_true(image.data[3 * k + c] == want);
            }
        lf_image32_finish(&image);
        plate.form = LF_PLATE_RAW;
        snprintf(path, sizeof path, "%s/raw_%d", folder, grey);
        lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
        check_raw(lf_test_path(path, "plate.raw"), &meaning, grey ? 1 : 3, 2, 1);
    }
}

static void halfs_are_rounded_to_nearest(void **state)
{
    (void)state;
    for (uint32_t bits = 0; bits < 0x7c00; bits++) {
        const float value = lf_plate_half_value((uint16_t)bits),
                    next = bits < 0x7bff ? lf_plate_half_value((uint16_t)(bits + 1)) : 65536;
        assert_int_equal(lf_plate_half(value), bits);
        assert_int_equal(lf_plate_half(-value), bits | 0x8000);
        const float middle = value + 0.5F * (next - value);
        if (bits < 0x7bff) { /* ties go to even numbers */
            assert_int_equal(lf_plate_half(middle), bits + (bits & 1));
            assert_int_equal(lf_plate_half(nextafterf(middle, 0)), bits);
            assert_int_equal(lf_plate_half(nextafterf(middle, 1e9F)), bits + 1);
        }
    }
    assert_int_equal(lf_plate_half(1e30F), 0x7bff);
    assert_int_equal(lf_plate_half(-INFINITY), 0xfbff);
    assert_int_equal(lf_plate_half(NAN), 0);
}

/* The middle of the codes is 0.214 of the light in sRGB, and half of it in linear grey. */
static void check_profile(const void *bytes, uint32_t size, bool is_grey)
{
    const uint16_t in[3] = {32768, 32768, 32768};
    double xyz[3] = {0};
    cmsHPROFILE from = cmsOpenProfileFromMem(bytes, size), to = cmsCreateXYZProfile();
    assert_non_null(from);
    assert_int_equal(cmsGetColorSpace(from), is_grey ? cmsSigGrayData : cmsSigRgbData);
    cmsHTRANSFORM way =
        cmsCreateTransform(from, is_grey ? TYPE_GRAY_16 : TYPE_RGB_16, to, TYPE_XYZ_DBL,
                           INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOOPTIMIZE);
    assert_non_null(way);
    cmsDoTransform(way, in, xyz, 1);
    lf_assert_close(xyz[1], is_grey ? 0.5 : 0.2140, 0.005, 0);
    cmsDeleteTransform(way);
    cmsCloseProfile(to);
    cmsCloseProfile(from);
}

/* Resolution, and what codes mean. */
static void tiffs_say_size_and_colour(void **state)
{
    const char *folder = *state;
    const field cells = of_cells();
    lf_error err = {0};
    char path[PATH_MAX];
    for (int i = 0; i < 8; i++) {
        const bool is_view = i & 1, is_grey = i & 2, is_known = i & 4;
        lf_plate plate = plate_of(true, "");
        plate.form = is_view ? LF_PLATE_VIEWS : LF_PLATE_HOGELS;
        plate.format = LF_PLATE_TIFF;
        plate.is_grey = is_grey;
        plate.microns[0] = is_known ? 102000 : 0; /* of 3 x 2 cells */
        plate.microns[1] = is_known ? 2000000 : 0;
        snprintf(path, sizeof path, "%s/says_%d", folder, i);
        lf_assert_ok(write_plate(&plate, path, &cells, &err), &err);
        TIFF *tiff = TIFFOpen(is_view ? lf_test_path(path, "views/r003/c0004.tif")
                                      : hogel_name(path, 1, 2, "tif"),
                              "r");
        float across = 0, down = 0;
        uint16_t unit = 0;
        uint32_t size = 0;
        void *bytes = NULL;
        assert_non_null(tiff);
        assert_int_equal(TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &across), 1);
        assert_int_equal(TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &down), 1);
        assert_int_equal(TIFFGetField(tiff, TIFFTAG_RESOLUTIONUNIT, &unit), 1);
        const bool has_size = is_known && is_view; /* pixels of hogels are directions */
        assert_int_equal(unit, has_size ? RESUNIT_CENTIMETER : RESUNIT_NONE);
        lf_assert_close((double)across, has_size ? COLUMNS / 10.2 : 1, 1e-6, 0);
        lf_assert_close((double)down, has_size ? ROWS / 200.0 : 1, 1e-6, 0);
        assert_int_equal(TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &size, &bytes), 1);
        check_profile(bytes, size, is_grey);
        TIFFClose(tiff);
    }
}

/* 16 bits hold sRGB codes, and grey is linear luminance. */
static void samples_are_encoded_as_the_page_says(void **state)
{
    (void)state;
    static const float light[][3] = {{0, 0.25F, 1}, {0.002F, 2, -1}};
    lf_plate plate = plate_of(false, "");
    lf_tone *tone = NULL;
    lf_error err = {0};
    uint8_t out[12];
    plate.format = LF_PLATE_TIFF;
    lf_assert_ok(lf_tone_create(0, "srgb", &tone, &err), &err);
    lf_plate_encode(&plate, tone, 2, light[0], out);
    const double quarter = 1.055 * pow(0.25, 1 / 2.4) - 0.055;
    const double want[6] = {0, quarter, 1, 0.002 * 12.92, 1, 0};
    for (int i = 0; i < 6; i++)
        lf_assert_close((double)number_in(out + 2 * i, 2), want[i] * 65535, 0, 1);
    plate.is_grey = true;
    lf_plate_encode(&plate, tone, 2, light[0], out);
    lf_assert_close((double)number_in(out, 2), (0.7152 * 0.25 + 0.0722) * 65535, 0, 1);
    plate.format = LF_PLATE_EXR;
    lf_plate_encode(&plate, NULL, 2, light[0], out);
    lf_assert_close((double)lf_plate_half_value((uint16_t)number_in(out + 2, 2)),
                    0.2126 * 0.002 + 0.7152 * 2 - 0.0722, 1e-3, 0);
    lf_tone_destroy(tone);
}

/* --------------------------------------------------------------------------- what can happen -- */

/* The manifest's sums are those of sha256sum. */
static void the_manifest_names_every_file(void **state)
{
    const char *folder = *state;
    lf_plate plate = plate_of(false, "u");
    const field plain = of_eyes(), meaning = flipped(&plain, "u");
    lf_error err = {0};
    char path[PATH_MAX], command[2 * PATH_MAX];
    plate.form = LF_PLATE_HOGELS;
    snprintf(path, sizeof path, "%s/sums", folder);
    lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
    json_t *manifest = json_load_file(lf_test_path(path, "manifest.json"), 0, NULL);
    const json_t *files = json_object_get(manifest, "files");
    assert_int_equal(json_array_size(files), WIDTH * HEIGHT);
    assert_int_equal(json_array_size(json_object_get(manifest, "missing")), 0);
    assert_string_equal(json_string_value(json_object_get(manifest, "kind")), "V");
    assert_string_equal(json_string_value(json_object_get(manifest, "quiltd")), "test");
    assert_true(json_is_true(json_object_get(json_object_get(manifest, "flips"), "u")));
    assert_false(json_is_true(json_object_get(json_object_get(manifest, "flips"), "v")));
    FILE *list = fopen(lf_test_path(path, "sums"), "w");
    assert_non_null(list);
    for (size_t i = 0; i < json_array_size(files); i++) {
        const json_t *file = json_array_get(files, i);
        const char *name = json_string_value(json_object_get(file, "name"));
        struct stat facts;
        assert_int_equal(stat(lf_test_path(path, name), &facts), 0);
        assert_int_equal(facts.st_size, json_integer_value(json_object_get(file, "bytes")));
        fprintf(list, "%s  %s\n", json_string_value(json_object_get(file, "sha256")), name);
    }
    fclose(list);
    snprintf(command, sizeof command, "cd '%s' && sha256sum --quiet -c sums >sums.log 2>&1", path);
    assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c) */
    json_decref(manifest);
}

static void rows_of_another_plate_are_refused(void **state)
{
    const char *folder = *state;
    const lf_plate plate = plate_of(false, ""), other = plate_of(false, "u");
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_pack("{s:f}", "number", 0.1), *others = json_pack("{s:f}", "number", 0.2);
    snprintf(path, sizeof path, "%s/other", folder);
    lf_assert_ok(lf_plate_begin(&plate, path, facts, false, &err), &err);
    lf_assert_ok(lf_plate_begin(&plate, path, facts, false, &err), &err);
    assert_int_equal(lf_plate_begin(&other, path, facts, false, &err), LF_E_EXISTS);
    assert_non_null(strstr(err.what, "another \"flips\""));
    assert_int_equal(lf_plate_begin(&plate, path, others, false, &err), LF_E_EXISTS);
    assert_non_null(strstr(err.what, "another \"number\""));
    lf_assert_ok(lf_plate_begin(&other, path, facts, true, &err), &err);
    lf_assert_ok(lf_plate_begin(&other, path, facts, false, &err), &err);
    json_decref(facts);
    json_decref(others);
    facts = json_object();
    assert_int_equal(lf_plate_begin(&plate, lf_test_path(folder, "no/such"), facts, false, &err),
                     LF_E_IO);
    json_decref(facts);
}

static void damaged_rows_are_told(void **state)
{
    const char *folder = *state;
    lf_plate plate = plate_of(true, "");
    const field meaning = of_cells();
    lf_error err = {0};
    char path[PATH_MAX], row[PATH_MAX];
    json_t *facts = json_pack("{s:s}", "quiltd", "test");
    plate.form = LF_PLATE_VIEWS;
    snprintf(path, sizeof path, "%s/damaged", folder);
    snprintf(row, sizeof row, "%s", lf_test_path(path, "rows/r001.raw"));
    lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
    const int fd = open(row, O_RDWR | O_CLOEXEC);
    assert_true(fd >= 0);
    const off_t whole = lseek(fd, 0, SEEK_END);
    assert_int_equal(ftruncate(fd, whole - 1), 0);
    assert_false(lf_plate_has_task(&plate, path, facts, 1));
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_FORMAT);
    assert_int_equal(ftruncate(fd, whole), 0);
    assert_true(lf_plate_has_task(&plate, path, facts, 1));
    assert_int_equal(pwrite(fd, "x", 1, 20), 1); /* another number of cameras */
    assert_false(lf_plate_has_task(&plate, path, facts, 1));
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.where, "rows/r001.raw"));
    assert_int_equal(ftruncate(fd, 100), 0);
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_FORMAT);
    close(fd);
    assert_int_equal(unlink(row), 0);
    assert_int_equal(lf_plate_finish(&plate, path, facts, &plain_run, &err), LF_E_IO);
    assert_true(lf_plate_is_finished(&plate, path, facts));
    assert_int_equal(truncate(lf_test_path(path, "views/r000/c0001.png"), 60), 0);
    assert_false(lf_plate_is_finished(&plate, path, facts));
    assert_int_equal(unlink(lf_test_path(path, "views/r003/c0004.png")), 0);
    assert_false(lf_plate_is_finished(&plate, path, facts));
    json_decref(facts);
}

static void a_cancelled_plate_has_no_manifest(void **state)
{
    const char *folder = *state;
    lf_plate plate = plate_of(true, "");
    const field meaning = of_cells();
    lf_error err = {0};
    char path[PATH_MAX];
    json_t *facts = json_pack("{s:s}", "quiltd", "test");
    lf_cancel cancel = 1;
    const lf_plate_run run = {.cancel = &cancel};
    plate.form = LF_PLATE_RAW;
    snprintf(path, sizeof path, "%s/cancelled", folder);
    lf_assert_ok(write_plate(&plate, path, &meaning, &err), &err);
    assert_int_equal(unlink(lf_test_path(path, "plate.raw")), 0);
    assert_int_equal(unlink(lf_test_path(path, "manifest.json")), 0);
    assert_int_equal(lf_plate_finish(&plate, path, facts, &run, &err), LF_E_CANCELLED);
    assert_int_not_equal(access(lf_test_path(path, "plate.raw"), F_OK), 0);
    assert_int_not_equal(access(lf_test_path(path, "manifest.json"), F_OK), 0);
    json_decref(facts);
}

static int set_up(void **state)
{
    *state = lf_test_folder();
    return 0;
}

static int tear_down(void **state)
{
    lf_test_folder_remove(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(indices_follow_the_definition),
        cmocka_unit_test(flips_and_their_compositions_follow_the_definition),
        cmocka_unit_test(a_flip_twice_is_none),
        cmocka_unit_test(all_forms_hold_the_field),
        cmocka_unit_test(a_flipped_plate_is_written_flipped),
        cmocka_unit_test(one_row_of_directions_has_plain_names),
        cmocka_unit_test(formats_keep_every_bit),
        cmocka_unit_test(halfs_are_rounded_to_nearest),
        cmocka_unit_test(tiffs_say_size_and_colour),
        cmocka_unit_test(samples_are_encoded_as_the_page_says),
        cmocka_unit_test(the_manifest_names_every_file),
        cmocka_unit_test(rows_of_another_plate_are_refused),
        cmocka_unit_test(damaged_rows_are_told),
        cmocka_unit_test(a_cancelled_plate_has_no_manifest),
    };
    return cmocka_run_group_tests_name("hologram", tests, set_up, tear_down);
}
