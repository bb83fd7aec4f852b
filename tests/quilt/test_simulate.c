/* What an eye sees of a print file, against an oracle that follows single rays: from the eye to a
 * point of a lens, by Snell's law to the print, and the pixels at many points of the spot. It
 * shares no code with the simulation and goes the other way, from the lens to the print. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/proof/simulate.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

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

/* -------------------------------------------------------------------------------- the oracle -- */

typedef struct sheet {
    double lpi, distance, thickness, index; /* visual pitch from the distance */
    double phase, slant;                    /* mm, degrees clockwise */
    bool horizontal, mirror;
    double spot, ink;
} sheet;

/* Light of the print at a point seen from the front, mm from the middle. */
static double print_at(const lf_printed *p, const lf_print *print, const sheet *s, double x,
                       double y, int c)
{
    const double down = print->dpi_down > 0 ? print->dpi_down : print->dpi;
    double column = floor(x * print->dpi / 25.4 + 0.5 * p->width),
           row = floor(y * down / 25.4 + 0.5 * p->height);
    column = fmin(fmax(column, 0), p->width - 1);
    row = fmin(fmax(row, 0), p->height - 1);
    return lf_printed_linear(p, (int)(s->mirror ? p->width - 1 - column : column), (int)row, c);
}

/* Mean light of the spot of lens k, at mm v along it. */
static double spot_light(const lf_printed *p, const lf_print *print, const sheet *s, int k,
                         double v, const lf_eye *eye, int c)
{
    const double a = s->slant * acos(-1.0) / 180;
    const double mechanical = 25.4 / s->lpi / (1 + s->thickness / (s->index * s->distance));
    const double u = (k + s->phase * s->lpi / 25.4) * mechanical;
    /* unit vectors across and along the lenses */
    const double ax = s->horizontal ? -sin(a) : cos(a), ay = s->horizontal ? cos(a) : sin(a);
    const double bx = s->horizontal ? cos(a) : -sin(a), by = s->horizontal ? sin(a) : cos(a);
    const double px = u * ax + v * bx, py = u * ay + v * by;
    const double off = hypot(px - eye->x_mm, py - eye->y_mm);
    const double moved =
        off > 0 ? s->thickness * tan(asin(sin(atan(off / eye->distance_mm)) / s->index)) / off : 0;
    const double x = px + moved * (px - eye->x_mm), y = py + moved * (py - eye->y_mm);
    const double reach = 0.5 * s->spot + 4 * s->ink;
    double sum = 0, weights = 0;
    for (int i = 0; i < 200; i++) {
        const double d = reach * ((i + 0.5) / 100 - 1);
        const double w = s->ink > 0 ? erf((d + 0.5 * s->spot) / (s->ink * sqrt(2))) -
                                          erf((d - 0.5 * s->spot) / (s->ink * sqrt(2)))
                                    : 1.0;
        sum += w * print_at(p, print, s, x + d * ax, y + d * ay, c);
        weights += w;
    }
    return sum / weights;
}

/* Mean over the part of a lens from v0 to v1. */
static double part_light(const lf_printed *p, const lf_print *print, const sheet *s, int k,
                         double v0, double v1, const lf_eye *eye, int c)
{
    enum { N = 64 };
    double sum = 0;
    for (int i = 0; i < N; i++)
        sum += spot_light(p, print, s, k, v0 + (v1 - v0) * (i + 0.5) / N, eye, c);
    return sum / N;
}

/* -------------------------------------------------------------------------------- the prints -- */

/* Smooth along the lenses, any value from view to view and from lens to lens. */
static float waves(const void *context, int view, int row, int column, int c)
{
    const bool horizontal = *(const bool *)context;
    const int lens = horizontal ? row : column, along = horizontal ? column : row;
    return (float)(0.5 + 0.45 * sin(view * (2.1 + c) + lens * 0.7 + along * 0.02));
}

static void print_file(const lf_print *print, lf_printed *printed, lf_print_file **out)
{
    const char *path = lf_test_path(folder, "print.tif");
    lf_views32 views;
    lf_error err;
    lf_card_make(print, waves, &print->horizontal, &views);
    lf_printed_make(print, &views, 0, printed);
    lf_card_finish(&views);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(printed->file, 1, printed->file_size, file), printed->file_size);
    fclose(file);
    lf_assert_ok(lf_print_file_open(path, NULL, out, &err), &err);
}

/* A print of 20 mm across its lenses and 8 mm along them. */
static lf_print print_of(bool horizontal)
{
    lf_print print = lf_print_sound();
    print.lpi = 60.13;
    print.width_mm = horizontal ? 8 : 20;
    print.height_mm = horizontal ? 20 : 8;
    print.bleed_mm = 1;
    print.n_views = 6;
    print.bits = 16;
    print.horizontal = horizontal;
    print.optics.thickness_mm = 0.6;
    print.optics.index = 1.56;
    print.optics.distance_mm = 400;
    print.optics.map = LF_MAP_UNIFORM;
    return print;
}

static sheet sheet_of(const lf_print *print)
{
    return (sheet){.lpi = print->lpi,
                   .distance = print->optics.distance_mm,
                   .thickness = print->optics.thickness_mm,
                   .index = print->optics.index,
                   .phase = print->phase_mm,
                   .slant = print->optics.slant,
                   .horizontal = print->horizontal,
                   .mirror = print->mirror,
                   .spot = print->blur.spot_mm > 0 ? print->blur.spot_mm
                                                   : 25.4 / print->lpi / print->n_views / 2,
                   .ink = print->blur.ink_mm};
}

/* True if lens k lies on the print from v0 to v1. */
static bool is_inside(const lf_print *print, const sheet *s, int k, double v0, double v1)
{
    const double a = s->slant * acos(-1.0) / 180, u = k * 25.4 / s->lpi;
    const double ax = s->horizontal ? -sin(a) : cos(a), ay = s->horizontal ? cos(a) : sin(a);
    const double bx = s->horizontal ? cos(a) : -sin(a), by = s->horizontal ? sin(a) : cos(a);
    return fmax(fabs(u * ax + v0 * bx), fabs(u * ax + v1 * bx)) < 0.5 * print->width_mm &&
           fmax(fabs(u * ay + v0 * by), fabs(u * ay + v1 * by)) < 0.5 * print->height_mm;
}

/* The greatest difference between simulation and oracle over lenses and parts. */
static double worst_of(const lf_proof_light *light, const lf_printed *printed,
                       const lf_print *print, const sheet *s, const lf_eye *eye)
{
    double worst = 0;
    for (int along = 1; along < light->n_along - 1; along += 3)
        for (int i = 3; i < light->n - 3; i += 4)
            for (int c = 0; c < 3; c += 2) {
                const double low = light->along0_mm + along * light->along_mm;
                if (!is_inside(print, s, light->first + i, low, low + light->along_mm))
                    continue;
                const double expected = part_light(printed, print, s, light->first + i, low,
                                                   low + light->along_mm, eye, c);
                const double seen =
                    (double)light
                        ->light[3 * ((size_t)along * (size_t)light->n + (size_t)i) + (size_t)c];
                worst = fmax(worst, fabs(seen - expected));
            }
    return worst;
}

/* The same over several eyes, seen through a sheet that may be another than the print's. */
static double compare(const lf_print *print, const lf_print *under, const sheet *oracle)
{
    static const lf_eye eyes[] = {{0, 0, 400}, {31, -20, 400}, {-77, 50, 350}, {5, 140, 900}};
    double worst = 0;
    lf_printed printed;
    lf_print_file *file;
    lf_proof_sheet proofed;
    lf_proof_light light;
    lf_error err;
    print_file(print, &printed, &file);
    lf_proof_sheet_of(under, &proofed, NULL);
    for (size_t i = 0; i < sizeof eyes / sizeof *eyes; i++) {
        lf_assert_ok(lf_proof_see(file, &proofed, &eyes[i], 8, NULL, &light, &err), &err);
        worst = fmax(worst, worst_of(&light, &printed, print, oracle, &eyes[i]));
        lf_proof_light_finish(&light);
    }
    lf_print_file_close(file);
    lf_printed_finish(&printed);
    return worst;
}

static void assert_agrees(const lf_print *print, const char *what)
{
    const sheet oracle = sheet_of(print);
    const double worst = compare(print, print, &oracle);
    print_message("%s: worst difference %.4f\n", what, worst);
    if (!(worst < 0.01))
        fail_msg("%s: %g", what, worst);
}

/* ------------------------------------------------------------------------------------- tests -- */

static void agrees_with_single_rays_for_every_kind_of_print(void **state)
{
    (void)state;
    lf_print print = print_of(false);
    assert_agrees(&print, "vertical");
    print.phase_mm = 0.11;
    print.stripes = LF_STRIPES_NEAREST;
    assert_agrees(&print, "phase, nearest");
    print = print_of(false);
    print.dpi = 720;
    print.dpi_down = 360;
    print.reverse = true;
    assert_agrees(&print, "two rasters, reversed");
    print = print_of(false);
    print.mirror = true;
    print.phase_mm = -0.07;
    print.marks = true;
    assert_agrees(&print, "mirrored, with marks");
    print = print_of(false);
    print.blur.spot_mm = 0.07;
    print.blur.ink_mm = 0.02;
    assert_agrees(&print, "wide spot and ink");
}

static void agrees_for_horizontal_lenses(void **state)
{
    (void)state;
    lf_print print = print_of(true);
    assert_agrees(&print, "horizontal");
    print.dpi_down = 1200;
    print.phase_mm = 0.2;
    print.mirror = true;
    assert_agrees(&print, "horizontal, two rasters, mirrored");
}

/* A print of upright stripes under a sheet that leans: the simulation needs no slanted print. */
static void agrees_for_lenses_that_lean(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        lf_print print = print_of(i == 3);
        lf_print under = print;
        under.optics.slant = (const double[]){12, -20, 45, 7}[i];
        const sheet oracle = sheet_of(&under);
        const double worst = compare(&print, &under, &oracle);
        print_message("slant %g: worst difference %.4f\n", under.optics.slant, worst);
        assert_true(worst < 0.01);
    }
}

/* The same under a sheet of points: a square spot behind lens i of row j. */
static double point_light(const lf_printed *p, const lf_print *print, const sheet *s,
                          bool hexagonal, int i, int j, const lf_eye *eye)
{
    enum { N = 40 };
    const double mechanical = 25.4 / s->lpi / (1 + s->thickness / (s->index * s->distance));
    const double px = (i + (hexagonal && (j & 1) ? 0.5 : 0.0)) * mechanical;
    const double py = j * mechanical * (hexagonal ? sqrt(3) / 2 : 1);
    const double off = hypot(px - eye->x_mm, py - eye->y_mm);
    const double moved =
        off > 0 ? s->thickness * tan(asin(sin(atan(off / eye->distance_mm)) / s->index)) / off : 0;
    double sum = 0;
    for (int k = 0; k < N * N; k++)
        sum += print_at(p, print, s,
                        px + moved * (px - eye->x_mm) + s->spot * ((k % N + 0.5) / N - 0.5),
                        py + moved * (py - eye->y_mm) + s->spot * ((k / N + 0.5) / N - 0.5), 1);
    return sum / (N * N);
}

static void agrees_for_sheets_of_points(void **state)
{
    (void)state;
    const lf_eye eye = {31, -20, 400};
    lf_print print = print_of(false);
    lf_printed printed;
    lf_print_file *file;
    lf_error err;
    print_file(&print, &printed, &file);
    for (int hexagonal = 0; hexagonal < 2; hexagonal++) {
        lf_proof_sheet proofed;
        lf_proof_light seen;
        double worst = 0;
        print.optics.grid = hexagonal ? LF_LENS_HEXAGONAL : LF_LENS_SQUARE;
        print.optics.view_rows = 1;
        const sheet oracle = sheet_of(&print);
        lf_proof_sheet_of(&print, &proofed, NULL);
        lf_assert_ok(lf_proof_see(file, &proofed, &eye, 8, NULL, &seen, &err), &err);
        for (int row = 2; row < seen.n_along - 2; row++)
            for (int i = 3; i < seen.n - 3; i++) {
                const double expected = point_light(&printed, &print, &oracle, hexagonal,
                                                    seen.first + i, seen.first_row + row, &eye);
                const size_t at = (size_t)row * (size_t)seen.n + (size_t)i;
                worst = fmax(worst, fabs((double)seen.light[3 * at + 1] - expected));
            }
        print_message("%s: worst difference %.4f\n", hexagonal ? "hexagonal" : "square", worst);
        assert_true(worst < 0.012);
        lf_proof_light_finish(&seen);
    }
    lf_print_file_close(file);
    lf_printed_finish(&printed);
}

/* A picture has the light of its lenses where they are. */
static void a_picture_is_made_of_the_lenses(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        lf_print print = print_of(kind == 1);
        const lf_eye eye = {12, 3, 400};
        lf_printed printed;
        lf_print_file *file;
        lf_proof_sheet proofed;
        lf_proof_light seen;
        lf_image32 image;
        lf_error err;
        int width, height;
        print_file(&print, &printed, &file);
        print.optics.slant = kind == 2 ? 30 : 0;
        print.optics.grid = kind == 3 ? LF_LENS_HEXAGONAL : LF_LENS_LINEAR;
        lf_proof_sheet_of(&print, &proofed, NULL);
        lf_assert_ok(lf_proof_size(&proofed, 600, &width, &height, &err), &err);
        lf_assert_ok(lf_proof_picture(file, &proofed, &eye, width, height, NULL, &image, &err),
                     &err);
        lf_assert_ok(
            lf_proof_see(file, &proofed, &eye, kind == 1 ? width : height, NULL, &seen, &err),
            &err);
        /* the lens in the middle of the print is in the middle of the picture */
        const int along =
            kind == 3 ? -seen.first_row : (int)floor((0.01 - seen.along0_mm) / seen.along_mm);
        const int around = kind == 2 ? 1 : 0; /* parts that the pixel may touch */
        const float *middle =
            image.data + 3 * ((size_t)(height / 2) * (size_t)width + (size_t)(width / 2));
        double low = 1, high = 0;
        for (int i = along - around; i <= along + around; i++) {
            const size_t at = 3 * ((size_t)i * (size_t)seen.n + (size_t)-seen.first);
            low = fmin(low, (double)seen.light[at]);
            high = fmax(high, (double)seen.light[at]);
        }
        assert_true((double)middle[0] > low - 0.01 && (double)middle[0] < high + 0.01);
        lf_image32_finish(&image);
        lf_proof_light_finish(&seen);
        lf_print_file_close(file);
        lf_printed_finish(&printed);
    }
}

static void mistakes_of_callers_are_told(void **state)
{
    (void)state;
    lf_print print = print_of(false);
    lf_printed printed;
    lf_print_file *file;
    lf_proof_sheet proofed;
    lf_proof_light seen;
    lf_image32 image;
    lf_error err;
    int width, height;
    const lf_cancel cancel = 1;
    print_file(&print, &printed, &file);
    lf_proof_sheet_of(&print, &proofed, NULL);
    lf_assert_status(lf_proof_see(file, &proofed, &(lf_eye){0, 0, 1}, 8, NULL, &seen, &err),
                     LF_E_ARG, &err);
    lf_assert_status(lf_proof_see(file, &proofed, &(lf_eye){0, 0, 400}, 8, &cancel, &seen, &err),
                     LF_E_CANCELLED, &err);
    assert_null(seen.light);
    lf_assert_status(lf_proof_size(&proofed, 8192, &width, &height, &err), LF_E_ARG, &err);
    lf_assert_status(
        lf_proof_picture(file, &proofed, &(lf_eye){0, 0, NAN}, 8, 8, NULL, &image, &err), LF_E_ARG,
        &err);
    lf_print_file_close(file);
    lf_printed_finish(&printed);
}

static void a_wrong_sheet_is_seen(void **state)
{
    (void)state;
    const lf_print print = print_of(false);
    const sheet right = sheet_of(&print);
    lf_print under = print;
    under.lpi *= 1.001;
    assert_true(compare(&print, &under, &right) > 0.05);
    under = print;
    under.mirror = true;
    assert_true(compare(&print, &under, &right) > 0.05);
    under = print;
    under.phase_mm = 0.03;
    assert_true(compare(&print, &under, &right) > 0.05);
    under = print;
    under.optics.slant = 1;
    assert_true(compare(&print, &under, &right) > 0.05);
    under.optics.slant = 12;
    sheet left = sheet_of(&under);
    left.slant = -12;
    assert_true(compare(&print, &under, &left) > 0.05);
    under = print;
    under.optics.thickness_mm = 0.7;
    assert_true(compare(&print, &under, &right) > 0.05);
}

/* The older oracle (tests/quilt/optical_oracle.h), one row of pixels and lenses in a plane. */
static void agrees_with_the_oracle_in_a_plane(void **state)
{
    (void)state;
    const lf_print print = print_of(false);
    const lf_eye eye = {-40, 0, 400};
    lf_printed printed;
    lf_print_file *file;
    lf_proof_sheet proofed;
    lf_proof_light seen;
    lf_error err;
    int first, last;
    print_file(&print, &printed, &file);
    lf_proof_sheet_of(&print, &proofed, NULL);
    lf_assert_ok(lf_proof_see(file, &proofed, &eye, 1, NULL, &seen, &err), &err);
    const lf_sheet other = lf_sheet_for(print.lpi, 400, 0.6, 1.56, 0);
    double *light = lf_calloc((size_t)printed.width, sizeof *light);
    const int bleed = (int)lround(1 / 25.4 * 600);
    for (int x = 0; x < printed.width; x++)
        for (int y = bleed; y < printed.height - bleed; y++)
            light[x] += lf_printed_linear(&printed, x, y, 1) / (printed.height - 2 * bleed);
    lf_row_light row = lf_row_light_of(light, printed.width, 25.4 / 600);
    lf_lenses_inside(&other, &row, &first, &last);
    for (int k = first; k <= last; k++) {
        const double expected =
            lf_seen_through(&other, &row, k, eye.x_mm, 400, proofed.spot_mm, true);
        const size_t at = (size_t)(k - seen.first);
        if (fabs(k * 25.4 / print.lpi) > 0.5 * print.width_mm - 0.2)
            continue; /* bleed is cut off */
        lf_assert_close((double)seen.light[3 * at + 1], expected, 0, 0.01);
    }
    lf_row_light_finish(&row);
    lf_free(light);
    lf_proof_light_finish(&seen);
    lf_print_file_close(file);
    lf_printed_finish(&printed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_single_rays_for_every_kind_of_print),
        cmocka_unit_test(agrees_for_horizontal_lenses),
        cmocka_unit_test(agrees_for_lenses_that_lean),
        cmocka_unit_test(agrees_for_sheets_of_points),
        cmocka_unit_test(agrees_with_the_oracle_in_a_plane),
        cmocka_unit_test(a_picture_is_made_of_the_lenses),
        cmocka_unit_test(mistakes_of_callers_are_told),
        cmocka_unit_test(a_wrong_sheet_is_seen),
    };
    return cmocka_run_group_tests_name("what an eye sees of a print", tests, make_folder,
                                       remove_folder);
}
