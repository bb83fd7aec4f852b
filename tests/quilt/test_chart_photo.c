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
                      .width_mm = 190.0,
                      .height_mm = 277.0,
                      .bits = 8};
}

static lf_paper paper;

static int print_it(void **state)
{
    const lf_print print = chart_of();
    lf_printed printed;
    (void)state;
    lf_printed_chart(&print, &printed);
    lf_paper_make(&printed, 25.4 / 600.0, 25.4 / 600.0, 0.1, &paper);
    lf_printed_finish(&printed);
    return 0;
}

static int put_away(void **state)
{
    (void)state;
    lf_paper_finish(&paper);
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

static void photos_give_pitch_and_phase(void **state)
{
    enum { MOST = 200 };
    const int n = getenv("QUILTD_LONG") ? MOST : 4;
    double pitch[MOST] = {0}, phase[MOST] = {0}, skew[MOST] = {0};
    int within = 0, n_order = 0;
    (void)state;
    for (int i = 0; i < n; i++) {
        const lf_shot shot = lf_shot_usual((uint64_t)i);
        lf_chart_reading r;
        lf_error err = {0};
        const lf_status status = read_photo(&shot, known_of(&shot), &r, &err);
        if (status != LF_OK)
            fail_msg("photo %d: %s", i, err.what);
        const double period = 25.4 / shot.lpi;
        pitch[i] = fabs(r.visual_lpi - lf_shot_visual_lpi(&shot, VIEWER_MM));
        phase[i] = fabs(remainder(r.phase_mm - shot.phase_mm, period));
        skew[i] = fabs(r.skew_deg - shot.skew_deg);
        within += pitch[i] < 3.0 * r.error_lpi && phase[i] < 3.0 * r.error_phase_mm;
        n_order += r.has_order && !r.is_reversed;
        if (getenv("QUILTD_SHOTS"))
            print_message("%3d pitch %+.5f +- %.5f phase %+.5f +- %.5f skew %+.5f tilt %.1f to %.0f "
                          "f %.1f t %.2f fit %.3f\n",
                          i, r.visual_lpi - lf_shot_visual_lpi(&shot, VIEWER_MM), r.error_lpi,
                          remainder(r.phase_mm - shot.phase_mm, period), r.error_phase_mm,
                          r.skew_deg - shot.skew_deg, shot.tilt_deg, shot.direction_deg,
                          shot.focal_35mm, shot.thickness_mm, r.fit);
        assert_true(r.error_lpi > 0.0 && r.error_lpi < 0.01);
    }
    qsort(pitch, (size_t)n, sizeof *pitch, by_size);
    qsort(phase, (size_t)n, sizeof *phase, by_size);
    qsort(skew, (size_t)n, sizeof *skew, by_size);
    print_message("%d photos; median, 95 %%, worst: pitch %.5f %.5f %.5f lpi, phase %.5f %.5f %.5f "
                  "mm, skew %.5f %.5f %.5f degrees; %d within three standard errors, order of %d\n",
                  n, pitch[n / 2], pitch[n * 95 / 100], pitch[n - 1], phase[n / 2],
                  phase[n * 95 / 100], phase[n - 1], skew[n / 2], skew[n * 95 / 100], skew[n - 1],
                  within, n_order);
    assert_true(pitch[n - 1] < 0.002);
    assert_true(phase[n - 1] < 0.01);
    assert_true(skew[n - 1] < 0.01);
    assert_true(within >= n * 9 / 10);
    assert_int_equal(n_order, n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(photos_give_pitch_and_phase)};
    return cmocka_run_group_tests(tests, print_it, put_away);
}
