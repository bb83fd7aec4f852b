/* Charts read from simulated photos (photographed.h): 200 of them with QUILTD_LONG=1. */
#include "tests/testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/chart/reading.h"
#include "tests/quilt/photographed.h"

#define VIEWER_MM 400.0

static lf_print chart_of(void)
{
    return (lf_print){.lpi = 60.0,
                      .chart_range = 0.5,
                      .chart_step = 0.05,
                      .dpi = 600,
                      .dpi_down = 300,
                      .width_mm = 190.0,
                      .height_mm = 277.0,
                      .bits = 8};
}

static lf_printed printed;
static lf_paper paper;

static void make_paper(double spot_mm)
{
    lf_paper_finish(&paper);
    lf_paper_make(&printed, 25.4 / 600.0, 25.4 / 300.0, spot_mm, &paper);
}

static int print_it(void **state)
{
    const lf_print print = chart_of();
    (void)state;
    lf_printed_chart(&print, &printed);
    make_paper(0.1);
    return 0;
}

static int put_away(void **state)
{
    (void)state;
    lf_paper_finish(&paper);
    lf_printed_finish(&printed);
    return 0;
}

static lf_status read_photo(const lf_shot *shot, lf_chart_photo known, lf_chart_reading *out,
                            lf_error *err)
{
    const lf_print print = chart_of();
    uint8_t *data = lf_photograph(&paper, shot);
    known.data = data;
    known.width = shot->width;
    known.height = shot->height;
    const lf_status status = lf_chart_read(&print, &known, "photo.jpg", out, err);
    free(data);
    return status;
}

static lf_chart_photo known_of(const lf_shot *shot)
{
    return (lf_chart_photo){.focal_35mm = round(shot->focal_35mm), /* as EXIF has it */
                            .distance_mm = VIEWER_MM,
                            .thickness_mm = shot->thickness_mm,
                            .index = shot->index};
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Errors of one kind, of all photos. */
typedef struct spread {
    double error[200];
} spread;

static void tell(const char *what, const char *unit, spread *s, int n)
{
    qsort(s->error, (size_t)n, sizeof *s->error, by_size);
    print_message("%s: median %.5f, 95 %% below %.5f, worst %.5f %s\n", what, s->error[n / 2],
                  s->error[n * 95 / 100], s->error[n - 1], unit);
}

/* As usual, of a quarter of the pixels. */
static lf_shot mid_shot(uint64_t seed)
{
    lf_shot shot = lf_shot_usual(seed);
    shot.width = 1512;
    shot.height = 2016;
    shot.blur_px *= 0.5;
    return shot;
}

/* What a reading has wrong, and the errors that it states. */
typedef struct miss {
    double own, far, phase, skew;
    bool is_honest; /* all within four standard errors, hundreds of numbers */
} miss;

static miss miss_of(const lf_shot *shot, const lf_chart_reading *r)
{
    double eye[3];
    lf_shot_eye(shot, eye);
    miss m = {.own = fabs(r->camera_lpi - lf_shot_visual_lpi(shot, eye[2])),
              .far = fabs(r->visual_lpi - lf_shot_visual_lpi(shot, VIEWER_MM)),
              .phase = fabs(remainder(r->phase_mm - shot->phase_mm, 25.4 / shot->lpi)),
              .skew = fabs(r->skew_deg - shot->skew_deg)};
    m.is_honest = m.own < 4.0 * r->error_camera_lpi && m.far < 4.0 * r->error_lpi &&
                  m.phase < 4.0 * r->error_phase_mm && m.skew < 4.0 * r->error_skew_deg;
    if (getenv("QUILTD_SHOTS"))
        print_message("photo %3d: own %.5f +- %.5f, far %.5f +- %.5f, phase %.5f +- %.5f, skew "
                      "%.5f +- %.5f; tilt %4.1f to %3.0f, focal %.1f, %.2f thick, eye at %.0f\n",
                      (int)shot->seed, m.own, r->error_camera_lpi, m.far, r->error_lpi, m.phase,
                      r->error_phase_mm, m.skew, r->error_skew_deg, shot->tilt_deg,
                      shot->direction_deg, shot->focal_35mm, shot->thickness_mm, eye[2]);
    return m;
}

static void photos_give_pitch_phase_and_skew(void **state)
{
    const bool is_long = getenv("QUILTD_LONG");
    const int n = is_long ? 200 : 2;
    static spread own, far, phase, skew;
    int n_honest = 0, n_order = 0, n_far = 0, n_phase = 0;
    (void)state;
    for (int i = 0; i < n; i++) {
        const lf_shot shot = is_long ? lf_shot_usual((uint64_t)i) : mid_shot((uint64_t)i);
        lf_chart_reading r;
        lf_error err = {0};
        if (read_photo(&shot, known_of(&shot), &r, &err) != LF_OK)
            fail_msg("photo %d: %s", i, err.what);
        const miss m = miss_of(&shot, &r);
        own.error[i] = m.own, far.error[i] = m.far;
        phase.error[i] = m.phase, skew.error[i] = m.skew;
        n_honest += m.is_honest;
        n_far += m.far < 0.002;
        n_phase += m.phase < 0.01;
        assert_true(!r.is_reversed);
        n_order += r.has_order;
        assert_int_equal(r.n_crosstalk, 7);
    }
    tell("pitch at the camera's distance", "lpi", &own, n);
    tell("pitch at 400 mm", "lpi", &far, n);
    tell("phase", "mm", &phase, n);
    tell("skew", "degrees", &skew, n);
    print_message("%d of %d within four standard errors, %d within 0.002 lpi at 400 mm, %d within "
                  "0.01 mm; order of %d\n",
                  n_honest, n, n_far, n_phase, n_order);
    assert_true(own.error[n - 1] < 0.002);
    assert_true(skew.error[n - 1] < 0.01);
    /* a photo from straight in front does not tell the focal length, which EXIF data round */
    assert_true(n_far >= n - n / 50);
    assert_true(far.error[n - 1] < 0.005);
    assert_int_equal(n_phase, n);
    assert_true(n_honest >= n - n / 50);
    assert_true(n_order >= n * 2 / 3);
}

/* ------------------------------------------------------------------------------ wrong photos -- */

static lf_shot small_shot(uint64_t seed)
{
    lf_shot shot = lf_shot_usual(seed);
    shot.width = 1020;
    shot.height = 1360;
    shot.blur_px = 0.7;
    shot.noise = 0.003;
    shot.tilt_deg = 8.0;
    return shot;
}

static void is_refused(const lf_shot *shot, const lf_chart_photo *known, lf_status expected,
                       const char *words)
{
    lf_chart_reading r;
    lf_error err = {0};
    assert_int_equal(read_photo(shot, *known, &r, &err), expected);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" does not say \"%s\"", err.what, words);
}

static void wrong_photos_are_refused_in_words(void **state)
{
    const lf_shot sound = small_shot(5);
    const lf_chart_photo known = known_of(&sound);
    lf_chart_reading r;
    lf_error err = {0};
    (void)state;
    lf_assert_ok(read_photo(&sound, known, &r, &err), &err);
    lf_shot s;
    s = sound, s.sheets = LF_NO_SHEET, is_refused(&s, &known, LF_E_FORMAT, "no fringes");
    s = sound, s.sheets = LF_TURNED_SHEET, is_refused(&s, &known, LF_E_FORMAT, "by 90 degrees");
    s = sound, s.sheets = LF_TWO_SHEETS, is_refused(&s, &known, LF_E_FORMAT, "use one sheet");
    s = sound, s.skew_deg = 3.0, is_refused(&s, &known, LF_E_FORMAT, "2 degrees of their lines");
    s = sound, s.lpi = 64.0, is_refused(&s, &known, LF_E_FORMAT, "within 1.5 lpi of the bands");
    s = sound, s.gain = 3.0, s.vignette = 0.0, s.slope[0] = s.slope[1] = 0.0;
    is_refused(&s, &known, LF_E_FORMAT, "overexposed");
    s = sound, s.mirrored = true, is_refused(&s, &known, LF_E_FORMAT, "mirrored");
    s = sound, s.blur_px = 8.0, is_refused(&s, &known, LF_E_FORMAT, "no marks");
    s = sound, s.aim_mm[1] = 180.0, is_refused(&s, &known, LF_E_FORMAT, "marks are visible");
    s = sound, s.aim_mm[0] = 1e4, is_refused(&s, &known, LF_E_FORMAT, "no marks");
    s = sound, s.width = 480, s.height = 640, is_refused(&s, &known, LF_E_FORMAT, "pixels per mm");
    s = sound, s.tilt_deg = 0.2;
    lf_chart_photo unknown = known;
    unknown.focal_35mm = unknown.distance_mm = 0.0;
    is_refused(&s, &unknown, LF_E_ARG, "is needed");
}

static void a_photo_of_another_chart_is_refused(void **state)
{
    const lf_shot shot = small_shot(5);
    lf_print other = chart_of();
    lf_chart_photo known = known_of(&shot);
    lf_chart_reading r;
    lf_error err = {0};
    (void)state;
    other.chart_step = 0.1;
    uint8_t *data = lf_photograph(&paper, &shot);
    known.data = data, known.width = shot.width, known.height = shot.height;
    assert_int_equal(lf_chart_read(&other, &known, "photo.jpg", &r, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.what, "another chart"));
    other.width_mm = 120.0, other.height_mm = 50.0; /* without marks */
    other.chart_step = 0.1;
    assert_int_equal(lf_chart_read(&other, &known, "photo.jpg", &r, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "no marks"));
    free(data);
}

/* Optics that are not the sheet's give another phase or pitch: these photos can tell. */
static void wrong_optics_are_found_out(void **state)
{
    lf_shot shot = small_shot(1);
    lf_chart_reading right, wrong;
    lf_error err = {0};
    (void)state;
    shot.tilt_deg = 28.0, shot.direction_deg = 10.0, shot.thickness_mm = 0.9;
    lf_chart_photo known = known_of(&shot);
    known.distance_mm = 1000.0;
    lf_assert_ok(read_photo(&shot, known, &right, &err), &err);
    const double period = 25.4 / shot.lpi;
    assert_true(fabs(remainder(right.phase_mm - shot.phase_mm, period)) < 0.01);
    known.thickness_mm = 1e-6; /* no Snell */
    lf_assert_ok(read_photo(&shot, known, &wrong, &err), &err);
    assert_true(fabs(remainder(wrong.phase_mm - shot.phase_mm, period)) > 0.05);
    assert_true(fabs(wrong.visual_lpi - lf_shot_visual_lpi(&shot, 1000.0)) > 0.01);
    assert_true(fabs(right.skew_deg - shot.skew_deg) < 0.01);
    assert_true(fabs(right.skew_deg + shot.skew_deg) > 0.02); /* the sign of the skew */
    shot.tilt_deg = 2.0; /* the marks do not tell the focal length */
    known.thickness_mm = shot.thickness_mm;
    known.focal_35mm *= 1.5;
    lf_assert_ok(read_photo(&shot, known, &wrong, &err), &err);
    assert_true(fabs(wrong.visual_lpi - lf_shot_visual_lpi(&shot, 1000.0)) > 0.005);
}

/* The pixels of the code patches: from column `left`, `width` of them, rows from `top`. */
typedef struct patches {
    int left, width, top, height;
    float *before; /* [height][width] */
} patches;

static float *patch_row(const patches *p, int y)
{
    return paper.light + (size_t)(p->top + y) * (size_t)paper.width + p->left;
}

static void keep_codes(patches *p)
{
    const json_t *place = json_object_get(
        json_object_get(json_object_get(printed.manifest, "chart"), "patches_mm"), "crosstalk");
    double mm[4];
    for (size_t k = 0; k < 4; k++)
        mm[k] =
            json_number_value(json_array_get(place, k)) / (k % 2 ? paper.down_mm : paper.right_mm);
    assert_true(mm[2] > 200.0);
    *p = (patches){.left = (int)floor(mm[0] + 0.5 * paper.width),
                   .width = (int)mm[2],
                   .top = (int)mm[1],
                   .height = (int)mm[3]};
    p->before = malloc((size_t)p->width * (size_t)p->height * sizeof *p->before);
    assert_non_null(p->before);
    for (int y = 0; y < p->height; y++)
        memcpy(p->before + (size_t)y * (size_t)p->width, patch_row(p, y),
               (size_t)p->width * sizeof *p->before);
}

static void restore_codes(patches *p)
{
    for (int y = 0; y < p->height; y++)
        memcpy(patch_row(p, y), p->before + (size_t)y * (size_t)p->width,
               (size_t)p->width * sizeof *p->before);
    free(p->before);
}

/* The code patches as if views ran the other way under each lens. */
static void reverse_codes(const patches *p)
{
    const double pitch = 25.4 / 60.0 / paper.right_mm;
    for (int y = 0; y < p->height; y++)
        for (int i = 0; i < p->width; i++) {
            const double x = p->left + i + 0.5 - 0.5 * paper.width;
            const int from = (int)floor(2.0 * pitch * round(x / pitch) - x + 0.5 * paper.width);
            if (from >= p->left && from < p->left + p->width)
                patch_row(p, y)[i] =
                    p->before[(size_t)y * (size_t)p->width + (size_t)from - (size_t)p->left];
        }
}

/* A share of the light comes from `stripes` eighths of a lens further right. */
static void add_ghost(const patches *p, double share, double stripes)
{
    const int shift = (int)round(stripes / 8.0 * 25.4 / 60.0 / paper.right_mm * 16.0);
    for (int y = 0; y < p->height; y++)
        for (int i = 0; i < p->width; i++) {
            const double at = i + shift / 16.0;
            const int k = (int)floor(at);
            if (k < 0 || k + 1 >= p->width)
                continue;
            const float *before = p->before + (size_t)y * (size_t)p->width + k;
            const double ghost = (double)before[0] + (at - k) * (double)(before[1] - before[0]);
            patch_row(p, y)[i] =
                (float)((1.0 - share) * (double)patch_row(p, y)[i] + share * ghost);
        }
}

/* Views run from right to left under a lens, so a ghost from the right is one of lower views. In
 * this photo, a sharp spot and a ghost make the reversed order fit better. */
static void ghosts_are_on_their_side(void **state)
{
    const lf_shot shot = mid_shot(0);
    (void)state;
    make_paper(0.03);
    for (int right = 0; right < 2; right++) {
        patches codes;
        lf_chart_reading r;
        lf_error err = {0};
        keep_codes(&codes);
        add_ghost(&codes, 0.2, right ? 2.5 : -2.5);
        lf_assert_ok(read_photo(&shot, known_of(&shot), &r, &err), &err);
        restore_codes(&codes);
        const double lower = r.crosstalk[0] + r.crosstalk[1],
                     higher = r.crosstalk[5] + r.crosstalk[6];
        print_message("ghost from the %s: lower views %.3f, higher %.3f\n",
                      right ? "right" : "left", lower, higher);
        assert_true(!r.is_reversed);
        lf_assert_close(right ? lower : higher, 0.18, 0.0, 0.07);
        assert_true((right ? higher : lower) < 0.06);
    }
    make_paper(0.1);
}

static void views_in_reverse_are_found(void **state)
{
    const lf_shot shot = small_shot(9);
    lf_chart_reading r;
    lf_error err = {0};
    patches codes;
    (void)state;
    lf_assert_ok(read_photo(&shot, known_of(&shot), &r, &err), &err);
    assert_true(r.has_order && !r.is_reversed);
    /* a spot of two of eight views, seen from between them: own view, half of each neighbour */
    lf_assert_close(r.crosstalk[3], 0.48, 0.0, 0.08);
    lf_assert_close(r.crosstalk[2] + r.crosstalk[4], 0.5, 0.0, 0.08);
    keep_codes(&codes);
    reverse_codes(&codes);
    lf_assert_ok(read_photo(&shot, known_of(&shot), &r, &err), &err);
    assert_true(r.has_order && r.is_reversed);
    restore_codes(&codes);
}

static void an_unknown_thickness_is_told_and_leaves_the_pitch_at_the_camera(void **state)
{
    lf_shot shot = small_shot(3);
    lf_chart_photo known = known_of(&shot);
    lf_chart_reading r;
    lf_error err = {0};
    double eye[3];
    (void)state;
    shot.tilt_deg = 5.0;
    known.thickness_mm = known.index = known.distance_mm = 0.0;
    lf_assert_ok(read_photo(&shot, known, &r, &err), &err);
    lf_shot_eye(&shot, eye);
    const double error = fabs(r.visual_lpi - lf_shot_visual_lpi(&shot, eye[2]));
    assert_true(error < 0.004 && error < 3.0 * r.error_lpi);
    lf_assert_close(r.distance_mm, eye[2], 0.0, 0.03 * eye[2]);
    assert_true(r.mechanical_lpi == 0.0);
    assert_non_null(strstr(r.notes.text, "thickness is unknown"));
}

/* Charts for horizontal lenses lie turned; the camera's place is on the page. */
static void the_camera_of_a_horizontal_chart_is_on_the_page(void **state)
{
    const lf_print print = {.lpi = 60.0,
                            .chart_range = 0.5,
                            .chart_step = 0.1,
                            .dpi = 300,
                            .width_mm = 170.0,
                            .height_mm = 120.0,
                            .horizontal = true,
                            .bits = 8};
    const lf_shot shot = {.sheets = LF_TURNED_SHEET,
                          .lpi = 60.2,
                          .phase_mm = 0.07,
                          .skew_deg = 0.2,
                          .thickness_mm = 0.6,
                          .index = 1.56,
                          .distance_mm = 250.0,
                          .tilt_deg = 15.0,
                          .direction_deg = 50.0,
                          .focal_35mm = 28.0,
                          .width = 1200,
                          .height = 900,
                          .gain = 0.7,
                          .noise = 0.004};
    lf_printed turned;
    lf_paper page;
    lf_chart_reading r;
    lf_error err = {0};
    double eye[3];
    (void)state;
    lf_printed_chart(&print, &turned);
    lf_paper_make(&turned, 25.4 / 300.0, 25.4 / 300.0, 0.01, &page);
    uint8_t *data = lf_photograph(&page, &shot);
    lf_chart_photo known = known_of(&shot);
    known.data = data, known.width = shot.width, known.height = shot.height;
    lf_assert_ok(lf_chart_read(&print, &known, "photo.jpg", &r, &err), &err);
    lf_shot_eye(&shot, eye);
    for (int k = 0; k < 3; k++)
        lf_assert_close(r.camera_mm[k], eye[k], 0.0, 5.0);
    lf_assert_close(r.phase_mm, shot.phase_mm, 0.0, 0.01);
    lf_assert_close(r.skew_deg, shot.skew_deg, 0.0, 0.01);
    free(data);
    lf_paper_finish(&page);
    lf_printed_finish(&turned);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photos_give_pitch_phase_and_skew),
        cmocka_unit_test(wrong_photos_are_refused_in_words),
        cmocka_unit_test(a_photo_of_another_chart_is_refused),
        cmocka_unit_test(wrong_optics_are_found_out),
        cmocka_unit_test(an_unknown_thickness_is_told_and_leaves_the_pitch_at_the_camera),
        cmocka_unit_test(views_in_reverse_are_found),
        cmocka_unit_test(ghosts_are_on_their_side),
        cmocka_unit_test(the_camera_of_a_horizontal_chart_is_on_the_page)};
    return cmocka_run_group_tests(tests, print_it, put_away);
}
