/* Flips: which image each stripe shows, and what an eye sees of the others through the sheet. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/print/flip.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define LPI 60.0
#define DPI 600
#define DISTANCE 400.0
#define THICKNESS 0.6
#define INDEX 1.56

static const double pitch = 25.4 / LPI, pixel = 25.4 / DPI;

static lf_print flip_print(int n_views, int guard, lf_guard_kind kind, int morph)
{
    lf_print print = lf_print_sound();
    print.width_mm = 25.4;
    print.height_mm = 1.0;
    print.n_views = n_views;
    print.bits = 16;
    print.sheet.guard = guard;
    print.sheet.guard_kind = kind;
    print.sheet.morph = morph;
    return print;
}

static void expect_stripes(const lf_print *print, int n_images, const char *expected)
{
    char text[128];
    assert_int_equal(lf_flip_check(print, n_images, "test", NULL), LF_OK);
    assert_string_equal(lf_flip_text(print, n_images, text, sizeof text), expected);
}

static void guards_are_between_all_frames_also_of_two_lenses(void **state)
{
    (void)state;
    lf_print print = flip_print(6, 1, LF_GUARD_WHITE, 0);
    expect_stripes(&print, 2, "0 0 - 1 1 -");
    print.sheet.guard = 2; /* half of the last guards are at the beginning */
    expect_stripes(&print, 2, "- 0 - - 1 -");
    print.sheet.guard_kind = LF_GUARD_REPEAT;
    expect_stripes(&print, 2, "0 0 0 1 1 1");
    print.n_views = 7;
    expect_stripes(&print, 2, "0 0 0 1 1 1 1");
    print.sheet.guard = 1;
    print.sheet.guard_kind = LF_GUARD_BLACK;
    print.n_views = 9;
    expect_stripes(&print, 3, "0 0 - 1 1 - 2 2 -");
    print.sheet.morph = 1;
    print.n_views = 10;
    expect_stripes(&print, 3, "0 - 0.5 - 1 - 1.5 - 2 -");
}

static void blends_are_in_equal_steps_and_evenly_chosen(void **state)
{
    (void)state;
    lf_print print = flip_print(9, 0, LF_GUARD_REPEAT, 3);
    expect_stripes(&print, 3, "0 0.25 0.5 0.75 1 1.25 1.5 1.75 2");
    print.n_views = 3;
    expect_stripes(&print, 2, "0 0.5 1");
    /* neither guards nor blends: the images as without */
    print.sheet.morph = 0;
    print.n_views = 5;
    for (int i = 0; i < 5; i++) {
        const lf_stripe_content content = lf_flip_content(&print, 2, i);
        assert_int_equal(content.image, i < 2 ? 0 : 1);
        assert_true(content.blend == 0.0F && !content.neutral);
    }
}

/* Images of one colour each. */
static lf_printed printed_of(const lf_print *print, int n, const float (*colour)[3])
{
    lf_printed out;
    const lf_views32 views = {n, 1, 1, 3, 3, colour[0], NULL, NULL, NULL};
    lf_printed_make(print, &views, 0, &out);
    return out;
}

static void blends_are_of_linear_light_in_closed_form(void **state)
{
    (void)state;
    static const float colour[2][3] = {{0.0F, 1.0F, 0.2F}, {1.0F, 0.5F, 0.4F}};
    const lf_print print = flip_print(5, 0, LF_GUARD_REPEAT, 3);
    lf_printed printed = printed_of(&print, 2, colour);
    /* a lens is 10 pixels, a stripe two; from left to right 4 to 0 */
    const int left = printed.width / 2 - 5;
    for (int m = 0; m < 10; m++)
        for (int c = 0; c < 3; c++) {
            const double share = (4 - m / 2) / 4.0;
            lf_assert_close(lf_printed_linear(&printed, left + m, 5, c),
                            (1.0 - share) * (double)colour[0][c] + share * (double)colour[1][c],
                            0.0, 3e-5);
        }
    lf_printed_finish(&printed);
}

/* The most light of the other frame, as a share of both, in an eye that sees its own frame with at
 * least half of the strength that the frame has where it is best. */
static double ghost(const lf_print *print, double spot)
{
    static const float colour[2][3] = {{1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}};
    lf_printed printed = printed_of(print, 2, colour);
    double light[2][1000], best = 0.0, seen[2][200], worst = 0.0;
    assert_true(printed.width < 1000);
    for (int x = 0; x < printed.width; x++)
        for (int c = 0; c < 2; c++)
            light[c][x] = lf_printed_linear(&printed, x, 5, c);
    const lf_sheet sheet = lf_sheet_for(LPI, DISTANCE, THICKNESS, INDEX, 0.0);
    for (int c = 0; c < 2; c++) {
        lf_row_light row = lf_row_light_of(light[c], printed.width, pixel);
        for (int e = 0; e < 200; e++) {
            const double eye = (e - 99.5) / 200.0 * pitch * INDEX * DISTANCE / THICKNESS;
            seen[c][e] = lf_seen_through(&sheet, &row, 3, eye, DISTANCE, spot, false);
        }
        lf_row_light_finish(&row);
    }
    for (int e = 0; e < 200; e++)
        best = fmax(best, seen[0][e]);
    for (int e = 0; e < 200; e++)
        if (seen[0][e] > 0.5 * best)
            worst = fmax(worst, seen[1][e] / (seen[0][e] + seen[1][e]));
    lf_printed_finish(&printed);
    return worst;
}

static void guards_keep_the_frames_apart(void **state)
{
    (void)state;
    const double stripe = pitch / 10.0;
    const lf_print without = flip_print(10, 0, LF_GUARD_BLACK, 0),
                   with = flip_print(10, 2, LF_GUARD_BLACK, 0),
                   repeated = flip_print(10, 2, LF_GUARD_REPEAT, 0);
    assert_true(ghost(&with, 1.9 * stripe) < 1e-6);
    assert_true(ghost(&with, 4.0 * stripe) < 0.3);
    /* negative controls */
    assert_true(ghost(&without, 1.9 * stripe) > 0.4);
    assert_true(ghost(&without, 4.0 * stripe) > 0.4);
    assert_true(ghost(&repeated, 1.9 * stripe) > 0.4);
}

static void guards_are_paper_white_or_black(void **state)
{
    (void)state;
    static const float colour[2][3] = {{0.3F, 0.3F, 0.3F}, {0.6F, 0.6F, 0.6F}};
    for (int kind = LF_GUARD_WHITE; kind <= LF_GUARD_BLACK; kind++) {
        const lf_print print = flip_print(10, 1, (lf_guard_kind)kind, 0);
        lf_printed printed = printed_of(&print, 2, colour);
        /* stripes 0 0 0 0 - 1 1 1 1 -, from the right */
        const int right = printed.width / 2 + 4;
        for (int i = 0; i < 10; i++)
            lf_assert_close(lf_printed_linear(&printed, right - i, 5, 1),
                            i % 5 == 4 ? (kind == LF_GUARD_WHITE ? 1.0 : 0.0)
                                       : (double)colour[i / 5][1],
                            0.0, 3e-5);
        lf_printed_finish(&printed);
    }
}

static void a_lens_gets_as_many_stripes_as_give_all_frames_the_same(void **state)
{
    (void)state;
    lf_print print = flip_print(0, 1, LF_GUARD_WHITE, 0);
    lf_error err;
    assert_int_equal(lf_print_choose_views(&print, 3, "test", NULL, NULL), LF_OK);
    assert_int_equal(print.n_views, 6); /* of the 8 that a lens shows without ghosts */
    print.n_views = 0;
    print.sheet.guard = 0;
    print.sheet.morph = 2;
    assert_int_equal(lf_print_choose_views(&print, 2, "test", NULL, NULL), LF_OK);
    assert_int_equal(print.n_views, 4);
    print.n_views = 5;
    assert_int_equal(lf_print_choose_views(&print, 2, "test", NULL, &err), LF_E_ARG);
    print.n_views = 0;
    print.sheet.guard = 2;
    assert_int_equal(lf_print_choose_views(&print, 3, "test", NULL, &err), LF_E_ARG);
    assert_string_equal(err.what, "guard: 7 frames with 2 guard stripes each need 21 stripes per "
                                  "lens, but it has 8; use fewer of them");
    assert_int_equal(print.n_views, 0);
    print.n_views = 20;
    assert_int_equal(lf_print_choose_views(&print, 3, "test", NULL, &err), LF_E_ARG);
}

/* More images than stripes: which are shown. As many: nothing to tell. */
static void images_that_are_shown_are_told(void **state)
{
    (void)state;
    char text[128];
    lf_print print = flip_print(7, 0, LF_GUARD_REPEAT, 0);
    expect_stripes(&print, 24, "1 5 8 12 15 18 22");
    expect_stripes(&print, 7, "");
    expect_stripes(&print, 2, "");
    assert_string_equal(lf_print_layout_text(&print, 24, text, sizeof text),
                        "images under a lens: 1 5 8 12 15 18 22 (7 of 24)");
    assert_string_equal(lf_print_layout_text(&print, 7, text, sizeof text), "");
    print = flip_print(6, 1, LF_GUARD_WHITE, 0);
    assert_string_equal(lf_print_layout_text(&print, 2, text, sizeof text),
                        "images under a lens: 0 0 - 1 1 -");
}

static void notes_tell_of_frames_that_are_lost_uneven_or_seen_by_one_eye(void **state)
{
    (void)state;
    char line[512];
    size_t at = 0;
    lf_image_notes notes = {0};
    lf_print print = flip_print(5, 0, LF_GUARD_REPEAT, 8);
    lf_flip_note(&print, 2, &notes);
    assert_true(lf_image_notes_next(&notes, &at, line, sizeof line));
    assert_non_null(strstr(line, "5 of 10 frames are shown"));
    assert_true(lf_image_notes_next(&notes, &at, line, sizeof line));
    assert_non_null(strstr(line, "--orientation horizontal"));
    print = flip_print(7, 1, LF_GUARD_WHITE, 0);
    print.horizontal = true;
    lf_flip_note(&print, 2, &notes);
    assert_true(lf_image_notes_next(&notes, &at, line, sizeof line));
    assert_non_null(strstr(line, "5 stripes do not divide evenly among 2 frames; 6 views"));
    assert_false(lf_image_notes_next(&notes, &at, line, sizeof line));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_that_are_shown_are_told),
        cmocka_unit_test(guards_are_between_all_frames_also_of_two_lenses),
        cmocka_unit_test(blends_are_in_equal_steps_and_evenly_chosen),
        cmocka_unit_test(blends_are_of_linear_light_in_closed_form),
        cmocka_unit_test(guards_keep_the_frames_apart),
        cmocka_unit_test(guards_are_paper_white_or_black),
        cmocka_unit_test(a_lens_gets_as_many_stripes_as_give_all_frames_the_same),
        cmocka_unit_test(notes_tell_of_frames_that_are_lost_uneven_or_seen_by_one_eye),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
