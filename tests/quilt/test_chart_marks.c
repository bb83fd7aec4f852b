/* The marks and patches of charts, found in the printed file. */
#include "tests/testing.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <math.h>

#include "quilt/chart/reading.h"
#include "tests/quilt/printed.h"

static lf_print marked_chart(double dpi)
{
    return (lf_print){.lpi = 60.0,
                      .chart_range = 0.5,
                      .chart_step = 0.1,
                      .dpi = dpi,
                      .width_mm = 190.0,
                      .height_mm = 140.0,
                      .bits = 8};
}

static const json_t *part_of(const lf_printed *p, const char *key)
{
    return json_object_get(json_object_get(p->manifest, "chart"), key);
}

static double number_at(const json_t *list, size_t i)
{
    return json_number_value(json_array_get(list, i));
}

/* The tag of the manifest with this number. */
static const json_t *tag_of(const lf_printed *p, int id)
{
    const json_t *tags = part_of(p, "tags");
    for (size_t i = 0; i < json_array_size(tags); i++)
        if (json_integer_value(json_object_get(json_array_get(tags, i), "id")) == id)
            return json_array_get(tags, i);
    fail_msg("tag %d is not in the manifest", id);
    return NULL;
}

/* Corners in mm: to the right of the print's middle, down from its top. */
static void expect_corners(const lf_printed *p, const apriltag_detection_t *tag, double dot,
                           bool turned)
{
    const json_t *known = tag_of(p, tag->id), *at = json_object_get(known, "left_top_mm");
    const double side = json_number_value(json_object_get(known, "side_mm"));
    for (int corner = 0; corner < 4; corner++) {
        const double x = number_at(at, 0) + (corner == 1 || corner == 2) * side,
                     y = number_at(at, 1) + (corner < 2) * side;
        const double px = tag->p[corner][0] * dot, py = tag->p[corner][1] * dot;
        /* a chart for horizontal lenses is turned clockwise */
        const double right = turned ? py - 0.5 * p->height * dot : px - 0.5 * p->width * dot,
                     down = turned ? p->width * dot - px : py;
        lf_assert_close(right, x, 0.0, 1.5 * dot);
        lf_assert_close(down, y, 0.0, 1.5 * dot);
    }
}

static void expect_tags(const lf_print *print, int n)
{
    lf_printed p;
    lf_printed_chart(print, &p);
    uint8_t *grey = calloc((size_t)p.width, (size_t)p.height);
    assert_non_null(grey);
    for (size_t i = 0; i < (size_t)p.width * (size_t)p.height; i++)
        grey[i] = (uint8_t)p.value[3 * i];
    image_u8_t image = {p.width, p.height, p.width, grey};
    apriltag_detector_t *detector = apriltag_detector_create();
    apriltag_family_t *family = tag36h11_create();
    apriltag_detector_add_family_bits(detector, family, 0);
    zarray_t *found = apriltag_detector_detect(detector, &image);
    assert_int_equal(zarray_size(found), n);
    assert_int_equal(json_array_size(part_of(&p, "tags")), n);
    for (int i = 0; i < n; i++) {
        apriltag_detection_t *tag;
        zarray_get(found, i, &tag);
        expect_corners(&p, tag, 25.4 / print->dpi, print->horizontal);
    }
    apriltag_detections_destroy(found);
    apriltag_detector_destroy(detector);
    tag36h11_destroy(family);
    free(grey);
    lf_printed_finish(&p);
}

static void tags_are_where_the_manifest_says(void **state)
{
    lf_print print = marked_chart(600.0);
    (void)state;
    print.height_mm = 90.0;
    print.chart_step = 0.25;
    expect_tags(&print, 6);
    print.height_mm = 140.0;
    print.chart_step = 0.1;
    print.dpi = 300.0;
    print.width_mm = 110.0; /* without those in the middle */
    expect_tags(&print, 4);
    print.horizontal = true;
    print.width_mm = 140.0;
    print.height_mm = 190.0;
    expect_tags(&print, 6);
}

static int ink_at(const lf_printed *p, double right, double top, int dx, int dy)
{
    const double dot = 25.4 / 600.0;
    const int x = (int)floor(right / dot + 0.5 * p->width) + dx, y = (int)(top / dot) + dy;
    return lf_printed_at(p, x, y, 0);
}

static void single_pixels_alternate_in_both_axes(void **state)
{
    const lf_print print = marked_chart(600.0);
    lf_printed p;
    (void)state;
    lf_printed_chart(&print, &p);
    const json_t *place = json_object_get(part_of(&p, "patches_mm"), "pixels");
    const double x = number_at(place, 0), y = number_at(place, 1) + 1.0;
    assert_int_equal(json_array_size(place), 4);
    for (int i = 0; i < 20; i++)
        for (int j = 0; j < 20; j++) {
            const int across = ink_at(&p, x + 1.0, y, i, j),
                      next = ink_at(&p, x + 1.0, y, i + 1, j);
            assert_true(across + next == 255 && across * next == 0);
            const int down = ink_at(&p, x + 6.0, y, i, j), below = ink_at(&p, x + 6.0, y, i, j + 1);
            assert_true(down + below == 255 && down * below == 0);
        }
    lf_printed_finish(&p);
}

static void each_code_patch_is_white_in_its_own_eighth(void **state)
{
    const lf_print print = marked_chart(600.0);
    const double dot = 25.4 / 600.0, pitch = 25.4 / 60.0;
    lf_printed p;
    bool seen[8] = {false};
    (void)state;
    lf_printed_chart(&print, &p);
    const json_t *place = json_object_get(part_of(&p, "patches_mm"), "crosstalk");
    const int y = (int)((number_at(place, 1) + 1.0) / dot);
    for (int patch = 0; patch < 8; patch++) {
        const double left = number_at(place, 0) + number_at(place, 2) * patch / 8.0;
        double cosine = 0.0, sine = 0.0, light = 0.0;
        for (int i = 0; i < 120; i++) { /* twelve lenses of ten dots */
            const int x = (int)ceil((left + 0.3) / dot + 0.5 * p.width) + i;
            const double at = (x + 0.5 - 0.5 * p.width) * dot / pitch;
            const double v = lf_printed_linear(&p, x, y, 0);
            cosine += v * cos(2.0 * M_PI * at), sine += v * sin(2.0 * M_PI * at), light += v;
        }
        lf_assert_close(light / 120.0, 0.125, 0.0, 0.001);
        /* the middle of the white stripe, in stripes of a cell from its left end */
        const double stripe = 8.0 * (atan2(sine, cosine) / (2.0 * M_PI) + 0.5) - 0.5;
        const int view = 7 - (int)lround(stripe);
        lf_assert_close(stripe, round(stripe), 0.0, 0.1); /* pixels alias a little */
        assert_in_range(view, 0, 7);
        seen[view] = true;
    }
    for (int view = 0; view < 8; view++)
        assert_true(seen[view]);
    lf_printed_finish(&p);
}

static void what_does_not_fit_is_told(void **state)
{
    lf_print print = marked_chart(600.0);
    lf_image_notes notes = {0};
    lf_printed p;
    (void)state;
    lf_chart_note(&print, &notes);
    assert_int_equal(notes.length, 0);
    print.width_mm = 100.0;
    print.height_mm = 100.0;
    lf_chart_note(&print, &notes);
    assert_non_null(strstr(notes.text, "no room for its phase patches"));
    notes = (lf_image_notes){0};
    print.height_mm = 40.0;
    lf_chart_note(&print, &notes);
    assert_non_null(strstr(notes.text, "no room for the marks"));
    lf_printed_chart(&print, &p);
    assert_int_equal(json_array_size(json_object_get(p.manifest, "warnings")), 1);
    assert_int_equal(json_array_size(part_of(&p, "tags")), 0);
    lf_printed_finish(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tags_are_where_the_manifest_says),
        cmocka_unit_test(single_pixels_alternate_in_both_axes),
        cmocka_unit_test(each_code_patch_is_white_in_its_own_eighth),
        cmocka_unit_test(what_does_not_fit_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
