/* Proofs of prints with dot gain, ink and measured crosstalk, against a printer and a sheet of the
 * tests' own: the printer makes dots larger and spreads ink, the optical oracle looks. Compensated
 * prints are the hard ones: they look right only if proof and compensation mean the same. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/proof/simulate.h"
#include "quilt/proof/study.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define DISTANCE_MM 400.0
#define THICKNESS_MM 0.6
#define INDEX 1.56
/* Parts of a pixel in which ink is spread. */
#define FINE 8
#define VIEWS 8

static const char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = lf_test_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    lf_test_folder_remove((char *)(uintptr_t)folder);
    return 0;
}

/* A printer and a sheet. */
typedef struct reality {
    double gain, ink_mm, spot_mm;
    double beside_mm; /* where the sheet lies, from where the print thinks that it lies */
} reality;

/* A row of the print as it comes out of the printer. */
static lf_row_light line_of(const lf_printed *printed, const reality *is, double pixel_mm)
{
    const int n = printed->width * FINE, row = printed->height / 2;
    const double step = pixel_mm / FINE;
    double *light = lf_calloc((size_t)n, sizeof *light), *out = lf_calloc((size_t)n, sizeof *out);
    const int reach = (int)ceil(5.0 * is->ink_mm / step);
    for (int i = 0; i < n; i++) {
        const double ink = 1.0 - lf_printed_linear(printed, i / FINE, row, 1);
        light[i] = 1.0 - fmin(ink * (1.0 + 4.0 * is->gain * (1.0 - ink)), 1.0);
    }
    for (int i = 0; i < n; i++) {
        double sum = 0.0, weights = 0.0;
        for (int d = -reach; d <= reach; d++) {
            const int from = i + d < 0 ? 0 : i + d >= n ? n - 1 : i + d;
            const double weight = reach > 0 ? exp(-0.5 * pow(d * step / is->ink_mm, 2)) : 1.0;
            sum += weight * light[from];
            weights += weight;
        }
        out[i] = sum / weights;
    }
    const lf_row_light line = lf_row_light_of(out, n, step);
    lf_free(light);
    lf_free(out);
    return line;
}

static lf_print print_of(void)
{
    lf_print print = lf_print_sound();
    print.lpi = 60.13;
    print.width_mm = 60.0;
    print.height_mm = 1.0;
    print.n_views = VIEWS;
    print.bits = 16;
    print.optics.thickness_mm = THICKNESS_MM;
    print.optics.index = INDEX;
    print.optics.distance_mm = DISTANCE_MM;
    print.optics.map = LF_MAP_UNIFORM;
    return print;
}

static double eye_at(const lf_print *print, double view)
{
    const double off = (view - 0.5 * (VIEWS - 1)) * 25.4 / print->lpi / VIEWS;
    return DISTANCE_MM * tan(asin(INDEX * sin(atan(off / THICKNESS_MM))));
}

/* Any grey from lens to lens and view to view. */
static float greys(const void *context, int view, int row, int column, int c)
{
    const double range = *(const double *)context;
    const double noise = 43758.5453 * sin(12.9898 * column + 37.7 * view);
    (void)row;
    (void)c;
    return (float)(0.5 + range * (noise - floor(noise) - 0.5));
}

/* One view is lighter than all others. */
static float lighter(const void *context, int view, int row, int column, int c)
{
    (void)row;
    (void)column;
    (void)c;
    return view == *(const int *)context ? 0.55F : 0.45F;
}

typedef float (*value_fn)(const void *context, int view, int row, int column, int c);

static void make(const lf_print *print, value_fn fn, const void *context, lf_printed *printed)
{
    lf_views32 views;
    lf_card_make(print, fn, context, &views);
    lf_printed_make(print, &views, 0, printed);
    lf_card_finish(&views);
}

/* Mean and greatest difference of proof and reality, over eyes at views and between them. */
typedef struct off {
    double mean, worst;
} off;

static off compare(const lf_print *print, const reality *is, const lf_print *under)
{
    const double range = 0.6;
    const char *path = lf_test_path(folder, "print.tif");
    const lf_sheet sheet =
        lf_sheet_for(print->lpi, DISTANCE_MM, THICKNESS_MM, INDEX, print->phase_mm + is->beside_mm);
    off out = {0};
    int n = 0, first, last;
    lf_printed printed;
    lf_print_file *opened;
    lf_proof_sheet proofed;
    lf_error err;
    make(print, greys, &range, &printed);
    FILE *file = fopen(path, "wb");
    assert_int_equal(fwrite(printed.file, 1, printed.file_size, file), printed.file_size);
    fclose(file);
    lf_assert_ok(lf_print_file_open(path, NULL, &opened, &err), &err);
    lf_row_light line = line_of(&printed, is, 25.4 / print->dpi);
    lf_lenses_inside(&sheet, &line, &first, &last);
    lf_proof_sheet_of(under, &proofed, NULL);
    for (int i = 0; i < 2 * VIEWS - 1; i++) {
        const lf_eye eye = {eye_at(print, 0.5 * i), 0, DISTANCE_MM};
        lf_proof_light seen;
        lf_assert_ok(lf_proof_see(opened, &proofed, &eye, 1, NULL, &seen, &err), &err);
        for (int k = first + 2; k <= last - 2; k++) {
            const double expected =
                lf_seen_through(&sheet, &line, k, eye.x_mm, DISTANCE_MM, is->spot_mm, true);
            const double d = fabs((double)seen.light[3 * (k - seen.first) + 1] - expected);
            out.mean += d;
            out.worst = fmax(out.worst, d);
            n++;
        }
        lf_proof_light_finish(&seen);
    }
    out.mean /= n;
    lf_row_light_finish(&line);
    lf_print_file_close(opened);
    lf_printed_finish(&printed);
    return out;
}

static void dot_gain_and_ink_are_in_the_proof(void **state)
{
    (void)state;
    const reality is = {.gain = 0.15, .ink_mm = 0.02, .spot_mm = 0.02};
    for (int on = 0; on < 2; on++) {
        lf_print print = print_of();
        print.blur.spot_mm = is.spot_mm;
        print.blur.ink_mm = is.ink_mm;
        print.blur.dot_gain = is.gain;
        print.compensation.on = on;
        const off found = compare(&print, &is, &print);
        print_message("compensated %d: mean %.4f, worst %.4f\n", on, found.mean, found.worst);
        assert_true(found.worst < 0.01);
        lf_print without = print;
        without.blur.dot_gain = 0;
        assert_true(compare(&print, &is, &without).mean > 0.05);
        without = print;
        without.blur.ink_mm = 0;
        assert_true(compare(&print, &is, &without).mean > 0.01);
    }
}

/* The share of view i + k at view i, as a chart under the sheet shows it. */
static double measure(lf_print *print, const reality *is, int reach)
{
    const lf_sheet sheet =
        lf_sheet_for(print->lpi, DISTANCE_MM, THICKNESS_MM, INDEX, print->phase_mm + is->beside_mm);
    double share[VIEWS] = {0};
    for (int bright = 0; bright < VIEWS; bright++) {
        lf_printed printed;
        int first, last;
        make(print, lighter, &bright, &printed);
        lf_row_light line = line_of(&printed, is, 25.4 / print->dpi);
        lf_lenses_inside(&sheet, &line, &first, &last);
        for (int i = 0; i < VIEWS; i++)
            for (int k = first; k <= last; k++)
                share[(bright - i + VIEWS) % VIEWS] +=
                    (lf_seen_through(&sheet, &line, k, eye_at(print, i), DISTANCE_MM, is->spot_mm,
                                     true) -
                     0.45) /
                    0.1 / (last - first + 1) / VIEWS;
        lf_row_light_finish(&line);
        lf_printed_finish(&printed);
    }
    print->blur.n_crosstalk = reach;
    print->blur.crosstalk_views = VIEWS;
    for (int k = -reach; k <= reach; k++)
        print->blur.crosstalk[reach + k] = share[(k + VIEWS) % VIEWS];
    return share[0];
}

/* The sheet lies beside its place, so that more of one neighbour is seen than of the other. */
static void a_measured_crosstalk_is_in_the_proof(void **state)
{
    (void)state;
    const reality is = {.ink_mm = 0.02, .spot_mm = 0.02, .beside_mm = 0.008};
    for (int round = 0; round < 4; round++) {
        lf_print print = print_of();
        print.stripes = round % 2 ? LF_STRIPES_NEAREST : LF_STRIPES_FRACTIONAL;
        const double own = measure(&print, &is, 2);
        lf_print under = print;
        lf_proof_sheet sheet;
        print.compensation.on = round >= 2;
        lf_proof_sheet_of(&under, &sheet, NULL);
        const double told = lf_proof_own_view(&under, &sheet).mean;
        const off found = compare(&print, &is, &under);
        print_message("%d: own share %.3f told %.3f; mean %.4f, worst %.4f\n", round, own, told,
                      found.mean, found.worst);
        lf_assert_close(told, own, 0, 0.01);
        assert_true(found.mean < 0.005 && found.worst < 0.03);
        for (int k = 0; k < 2; k++) {
            const double share = under.blur.crosstalk[k];
            under.blur.crosstalk[k] = under.blur.crosstalk[4 - k];
            under.blur.crosstalk[4 - k] = share;
        }
        assert_true(compare(&print, &is, &under).mean > 0.02);
        under.blur.n_crosstalk = 0;
        assert_true(compare(&print, &is, &under).mean > 0.02);
    }
}

/* A fifth of the light comes from three views away. */
static void a_ghost_far_away_is_in_the_proof(void **state)
{
    (void)state;
    lf_print print = print_of();
    lf_proof_sheet sheet;
    print.blur.n_crosstalk = 3;
    print.blur.crosstalk[3] = 0.6;
    print.blur.crosstalk[2] = print.blur.crosstalk[4] = 0.1;
    print.blur.crosstalk[6] = 0.2; /* view i + 3 is to the left */
    lf_proof_sheet_of(&print, &sheet, NULL);
    double most = 0, at = 0;
    for (int k = 0; k < sheet.spots.n; k++)
        if (fabs(sheet.spots.right_mm[k]) > 0.1 && sheet.spots.share[k] > most) {
            most = sheet.spots.share[k];
            at = sheet.spots.right_mm[k];
        }
    lf_assert_close(most, 0.2, 0, 0.06);
    lf_assert_close(at, -3 * 25.4 / print.lpi / VIEWS, 0, 0.02);
    print.reverse = true;
    lf_proof_sheet_of(&print, &sheet, NULL);
    assert_true(sheet.spots.share[6] > 0.14);
    const lf_own_view own = lf_proof_own_view(&print, &sheet);
    lf_assert_close(own.mean, 0.6, 0, 0.03);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dot_gain_and_ink_are_in_the_proof),
        cmocka_unit_test(a_measured_crosstalk_is_in_the_proof),
        cmocka_unit_test(a_ghost_far_away_is_in_the_proof),
    };
    return cmocka_run_group_tests_name("blur in proofs", tests, make_folder, remove_folder);
}
