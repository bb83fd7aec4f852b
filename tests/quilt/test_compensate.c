/* Compensated prints looked at through the lens sheet that they are made for. The sheet, its spot
 * and its ink are those of the optical oracle, which shares no code with the compensation. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/print/compensate.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define DISTANCE_MM 400.0
#define THICKNESS_MM 0.6
#define INDEX 1.56
#define SPOT_MM 0.02
#define MOST_VIEWS 16
/* Parts of a pixel in which ink is spread. */
#define FINE 8

/* ------------------------------------------------------------------------------ what is seen -- */

/* A line of the print across the lenses, in its middle, with the dot gain and the ink of a
 * printer. */
static lf_row_light line_of(const lf_print *print, const lf_printed *printed, int c, double gain,
                            double ink_mm)
{
    const int n = (print->horizontal ? printed->height : printed->width) * FINE;
    const double step =
        25.4 / (print->horizontal && print->dpi_down > 0.0 ? print->dpi_down : print->dpi) / FINE;
    double *light = malloc((size_t)n * sizeof *light), *ink = malloc((size_t)n * sizeof *ink);
    assert_non_null(light);
    assert_non_null(ink);
    for (int i = 0; i < n; i++) {
        const double dark =
            1.0 - (print->horizontal
                       ? lf_printed_linear(printed, printed->width / 2, i / FINE, c)
                       : lf_printed_linear(printed, i / FINE, printed->height / 2, c));
        light[i] = 1.0 - fmin(dark + 4.0 * gain * dark * (1.0 - dark), 1.0);
    }
    const int reach = ink_mm > 0.0 ? (int)ceil(5.0 * ink_mm / step) : 0;
    for (int i = 0; i < n; i++) {
        double sum = 0.0, weights = 0.0;
        for (int d = -reach; d <= reach; d++) {
            const double weight = reach > 0 ? exp(-0.5 * pow(d * step / ink_mm, 2)) : 1.0;
            sum += weight * light[i + d < 0 ? 0 : i + d >= n ? n - 1 : i + d];
            weights += weight;
        }
        ink[i] = sum / weights;
    }
    const lf_row_light row = lf_row_light_of(ink, n, step);
    free(light);
    free(ink);
    return row;
}

/* A sheet and a printer. */
typedef struct reality {
    double gain, ink_mm, spot_mm;
    double beside_mm; /* where it lies, from where the print thinks that it lies */
} reality;

static double eye_of_view(const lf_print *print, int i)
{
    const int view = print->reverse ? print->n_views - 1 - i : i;
    return (view - 0.5 * (print->n_views - 1)) * (25.4 / print->lpi / print->n_views) * INDEX *
           DISTANCE_MM / THICKNESS_MM;
}

/* Calls see(context, view, lens number, light) for every eye and every lens inside. */
typedef void (*see_fn)(void *context, int view, int lens, double light);
static void look(const lf_print *print, const lf_views32 *views, int c, const reality *sheet_is,
                 see_fn see, void *context)
{
    const lf_sheet sheet = lf_sheet_for(print->lpi, DISTANCE_MM, THICKNESS_MM, INDEX,
                                        print->phase_mm + sheet_is->beside_mm);
    lf_printed printed;
    int first, last;
    lf_printed_make(print, views, 0, &printed);
    lf_row_light row = line_of(print, &printed, c, sheet_is->gain, sheet_is->ink_mm);
    lf_lenses_inside(&sheet, &row, &first, &last);
    assert_true(last - first > 30);
    for (int i = 0; i < print->n_views; i++)
        for (int k = first; k <= last; k++)
            see(context, i, k,
                lf_seen_through(&sheet, &row, k, eye_of_view(print, i), DISTANCE_MM,
                                sheet_is->spot_mm, false));
    lf_row_light_finish(&row);
    lf_printed_finish(&printed);
}

/* --------------------------------------------------------------------------------- crosstalk -- */

typedef struct crosstalk {
    double share[MOST_VIEWS]
                [MOST_VIEWS]; /* [eye at view i][view j is lighter], mean of the lenses */
    double own, ghost;        /* mean own share; largest share of another view, without sign */
} crosstalk;

typedef struct one_bright {
    crosstalk *crosstalk;
    double dark, bright;
    int lighter, n[MOST_VIEWS];
} one_bright;

static void add_share(void *context, int view, int lens, double light)
{
    one_bright *to = context;
    (void)lens;
    to->crosstalk->share[view][to->lighter] += (light - to->dark) / (to->bright - to->dark);
    to->n[view]++;
}

/* Views of one grey each: one of them bright, all others dark. */
static crosstalk crosstalk_of(const lf_print *print, const reality *sheet_is, double dark,
                              double bright)
{
    crosstalk out = {0};
    const int n = print->n_views;
    for (int j = 0; j < n; j++) {
        float data[3 * MOST_VIEWS];
        one_bright to = {.crosstalk = &out, .dark = dark, .bright = bright, .lighter = j};
        for (int i = 0; i < 3 * n; i++)
            data[i] = (float)(i / 3 == j ? bright : dark);
        const lf_views32 views = {n, 1, 1, 3, 3, data, NULL, NULL, NULL};
        look(print, &views, 1, sheet_is, add_share, &to);
        for (int i = 0; i < n; i++)
            out.share[i][j] /= to.n[i];
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            if (i == j)
                out.own += out.share[i][i] / n;
            else
                out.ghost = fmax(out.ghost, fabs(out.share[i][j]));
    return out;
}

/* No view shows more than 1 % that showed less before, and none shows more of what it did. */
static void assert_no_new_ghost(const crosstalk *off, const crosstalk *on, int n, double more)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            assert_true(i == j ||
                        fabs(on->share[i][j]) <= fmax(fabs(off->share[i][j]) + more, 0.01));
}

static lf_print sheet_print(double lpi, int n_views, double spot_mm, double ink_mm)
{
    lf_print print = lf_print_sound();
    print.lpi = lpi;
    print.width_mm = 60.0;
    print.height_mm = 1.0;
    print.n_views = n_views;
    print.bits = 16;
    print.blur.spot_mm = spot_mm;
    print.blur.ink_mm = ink_mm;
    return print;
}

static lf_print turned(lf_print print)
{
    const double width = print.width_mm;
    print.width_mm = print.height_mm;
    print.height_mm = width;
    print.horizontal = true;
    return print;
}

static void own_shares_rise_and_no_ghost_comes(void **state)
{
    (void)state;
    static const struct {
        double lpi;
        int n_views;
        lf_stripes stripes;
        double ink_mm;
        bool horizontal;
        double rise; /* of the own share, where it has room for it */
    } sheets[] = {
        {60.13, 10, LF_STRIPES_FRACTIONAL, 0.0, false, 1.3},
        {60.13, 8, LF_STRIPES_FRACTIONAL, 0.0, false, 1.18},
        {60.13, 8, LF_STRIPES_FRACTIONAL, 0.025, false, 1.5},
        {60.13, 10, LF_STRIPES_NEAREST, 0.0, false, 1.1},
        {40.07, 12, LF_STRIPES_FRACTIONAL, 0.025, false, 1.3},
        {75.31, 6, LF_STRIPES_FRACTIONAL, 0.025, false, 1.45},
        {60.13, 8, LF_STRIPES_NEAREST, 0.025, true, 1.3},
    };
    for (size_t s = 0; s < sizeof sheets / sizeof sheets[0]; s++) {
        const reality sheet = {.ink_mm = sheets[s].ink_mm, .spot_mm = SPOT_MM};
        lf_print print = sheet_print(sheets[s].lpi, sheets[s].n_views, SPOT_MM, sheets[s].ink_mm);
        print.stripes = sheets[s].stripes;
        if (sheets[s].horizontal)
            print = turned(print);
        const crosstalk off = crosstalk_of(&print, &sheet, 0.45, 0.55);
        print.compensation.on = true;
        const crosstalk on = crosstalk_of(&print, &sheet, 0.45, 0.55);
        print_message("%g lpi, %d views, ink %g: own share %.3f -> %.3f, ghost %.3f -> %.3f\n",
                      print.lpi, print.n_views, sheets[s].ink_mm, off.own, on.own, off.ghost,
                      on.ghost);
        assert_true(on.own >= sheets[s].rise * off.own);
        assert_true(1.0 - on.own < 0.3 * (1.0 - off.own));
        assert_true(on.ghost < 0.4 * off.ghost);
        assert_no_new_ghost(&off, &on, print.n_views, 0.0);
    }
}

/* Black and white have no room: nothing that is blacker than black can make up for a ghost. */
static void black_and_white_need_headroom(void **state)
{
    (void)state;
    const reality sheet = {.ink_mm = 0.025, .spot_mm = SPOT_MM};
    lf_print print = sheet_print(60.13, 8, SPOT_MM, 0.025);
    const crosstalk off = crosstalk_of(&print, &sheet, 0.0, 1.0);
    print.compensation.on = true;
    const crosstalk on = crosstalk_of(&print, &sheet, 0.0, 1.0);
    assert_true(on.own < 1.2 * off.own);
    assert_no_new_ghost(&off, &on, print.n_views, 0.03);
    print.compensation.headroom = 0.3;
    const crosstalk roomy = crosstalk_of(&print, &sheet, 0.0, 1.0);
    /* 0.3 is seen instead of black: the shares of 0.4 of the light */
    print_message("black and white: own share %.3f -> %.3f, with headroom %.3f\n", off.own, on.own,
                  (roomy.own - 0.3) / 0.4);
    assert_true((roomy.own - 0.3) / 0.4 > 1.4 * off.own);
    lf_assert_close(roomy.share[3][1], 0.3, 0.0, 0.02);
}

/* A blur that the sheet has not makes things worse. */
static void a_wrong_blur_makes_ghosts(void **state)
{
    (void)state;
    const reality sheet = {.spot_mm = SPOT_MM};
    lf_print print = sheet_print(60.13, 8, SPOT_MM, 0.0);
    const crosstalk off = crosstalk_of(&print, &sheet, 0.45, 0.55);
    print.compensation.on = true;
    print.blur.ink_mm = 0.04;
    const crosstalk on = crosstalk_of(&print, &sheet, 0.45, 0.55);
    assert_true(on.ghost > 1.5 * off.ghost);
}

/* -------------------------------------------------------------------------- measured kernels -- */

/* The share of view i + k at view i, as a chart under the sheet would show it. */
static void measure(const crosstalk *c, int n_views, lf_print_blur *blur)
{
    double sum = 0.0;
    blur->n_crosstalk = 2;
    for (int k = -2; k <= 2; k++) {
        double share = 0.0;
        for (int i = 2; i < n_views - 2; i++)
            share += fmax(c->share[i][i + k], 0.0) / (n_views - 4);
        blur->crosstalk[2 + k] = share;
        sum += share;
    }
    for (int k = 0; k < 5; k++)
        blur->crosstalk[k] /= sum;
}

/* The sheet lies 8 um beside where the print thinks, so that more of one neighbour is seen than of
 * the other. */
static void a_measured_crosstalk_is_taken_back(void **state)
{
    (void)state;
    const reality sheet = {.ink_mm = 0.02, .spot_mm = SPOT_MM, .beside_mm = 0.008};
    for (int round = 0; round < 2; round++) {
        lf_print print = sheet_print(60.13, 8, 0.0, 0.0);
        print.reverse = round;
        if (round)
            print = turned(print);
        const crosstalk off = crosstalk_of(&print, &sheet, 0.45, 0.55);
        measure(&off, print.n_views, &print.blur);
        assert_true(fabs(print.blur.crosstalk[1] - print.blur.crosstalk[3]) > 0.1);
        print.compensation.on = true;
        const crosstalk on = crosstalk_of(&print, &sheet, 0.45, 0.55);
        print_message("measured crosstalk: own share %.3f -> %.3f, ghost %.3f -> %.3f\n", off.own,
                      on.own, off.ghost, on.ghost);
        assert_true(on.own >= 1.3 * off.own);
        assert_true(on.ghost < 0.4 * off.ghost);
        assert_no_new_ghost(&off, &on, print.n_views, 0.0);

        for (int k = 0; k < 2; k++) {
            const double share = print.blur.crosstalk[k];
            print.blur.crosstalk[k] = print.blur.crosstalk[4 - k];
            print.blur.crosstalk[4 - k] = share;
        }
        const crosstalk mirrored = crosstalk_of(&print, &sheet, 0.45, 0.55);
        assert_true(mirrored.ghost > off.ghost);
    }
}

/* The crosstalk of a chart, which has 8 views, serves prints with more views and with fewer: a
 * sharp sheet stays sharp. */
static void a_chart_serves_prints_of_any_views(void **state)
{
    (void)state;
    static const struct {
        double dpi, spot_mm, ink_mm;
        int n_views;
        double ghost; /* left, at most */
    } of[] = {{1200.0, SPOT_MM, 0.0, 16, 0.03},
              {600.0, SPOT_MM, 0.0, 10, 0.02},
              {600.0, SPOT_MM, 0.012, 6, 0.02},
              {1200.0, SPOT_MM, 0.006, 12, 0.03}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        const reality sheet = {.ink_mm = of[i].ink_mm, .spot_mm = of[i].spot_mm};
        lf_print chart = sheet_print(60.1418, 8, 0.0, 0.0);
        chart.dpi = of[i].dpi;
        lf_print print = chart;
        print.n_views = of[i].n_views;
        const crosstalk of_chart = crosstalk_of(&chart, &sheet, 0.45, 0.55);
        measure(&of_chart, 8, &print.blur);
        print.blur.crosstalk_views = 8;
        const crosstalk off = crosstalk_of(&print, &sheet, 0.45, 0.55);
        print.compensation.on = true;
        const crosstalk on = crosstalk_of(&print, &sheet, 0.45, 0.55);
        print_message("chart for %d views: own share %.3f -> %.3f, ghost %.3f -> %.3f\n",
                      print.n_views, off.own, on.own, off.ghost, on.ghost);
        assert_true(1.0 - on.own < 0.3 * (1.0 - off.own));
        assert_true(on.ghost <= of[i].ghost);
        assert_no_new_ghost(&off, &on, print.n_views, 0.0);
    }
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* Views of a scene: things at three depths before a wall, from black to white. */
static float scene_value(const void *context, int view, int row, int column, int c)
{
    const lf_print *print = context;
    const double lens = print->horizontal ? row : column;
    double light = 0.5 + 0.5 * sin(0.21 * (lens - 0.3 * view)) * cos(0.037 * lens + c);
    for (int thing = 0; thing < 3; thing++) {
        const double at = lens - (thing - 1) * 0.7 * (view - 0.5 * print->n_views) - 13.0 * thing;
        if (fmod(at + 1000.0, 41.0) < 9.0)
            light = 0.1 + 0.4 * thing;
    }
    return (float)light;
}

/* A flip of two pictures. */
static float flip_value(const void *context, int view, int row, int column, int c)
{
    const lf_print *print = context;
    const double lens = print->horizontal ? row : column;
    return (float)(view < print->n_views / 2 ? 0.5 + 0.5 * sin(0.13 * lens + c)
                                             : 0.5 + 0.5 * cos(0.023 * lens * lens / 30.0));
}

/* Noise, the same in all rows. */
static float noise_value(const void *context, int view, int row, int column, int c)
{
    const lf_print *print = context;
    return lf_card_speckle(NULL, view, 0, print->horizontal ? row : column, c);
}

typedef float (*value_fn)(const void *context, int view, int row, int column, int c);

typedef struct error_sum {
    const lf_print *print;
    value_fn value;
    int first_lens, n;
    double squares, sum;
} error_sum;

static void add_error(void *context, int view, int lens, double light)
{
    error_sum *to = context;
    const int sample = lens - to->first_lens;
    const double room = to->print->compensation.headroom;
    const double wanted =
        room + (1.0 - 2.0 * room) * (double)to->value(to->print, view, sample, sample, 1);
    to->squares += (light - wanted) * (light - wanted);
    to->sum += fabs(light - wanted);
    to->n++;
}

typedef struct errors {
    double rms, mean;
} errors;

static errors errors_of(const lf_print *print, value_fn value, const reality *sheet)
{
    lf_print_shape shape;
    lf_views32 views;
    lf_print_shape_of(print, &shape);
    error_sum to = {.print = print, .value = value, .first_lens = shape.first_lens};
    lf_card_make(print, value, print, &views);
    look(print, &views, 1, sheet, add_error, &to);
    lf_card_finish(&views);
    return (errors){sqrt(to.squares / to.n), to.sum / to.n};
}

static void pictures_have_fewer_ghosts(void **state)
{
    (void)state;
    const value_fn values[] = {scene_value, flip_value, noise_value};
    const reality sheet = {.ink_mm = 0.015, .spot_mm = SPOT_MM};
    for (int i = 0; i < 6; i++) {
        lf_print print = sheet_print(60.13, 8, SPOT_MM, 0.015);
        if (i / 3)
            print = turned(print);
        const errors off = errors_of(&print, values[i % 3], &sheet);
        print.compensation.on = true;
        const errors on = errors_of(&print, values[i % 3], &sheet);
        print.compensation.headroom = 0.15;
        const errors roomy = errors_of(&print, values[i % 3], &sheet);
        print_message("picture %d: error %.4f -> %.4f, with headroom %.4f\n", i % 3, off.rms,
                      on.rms, roomy.rms);
        assert_true(on.rms < (i % 3 < 2 ? 0.6 : 0.8) * off.rms);
        assert_true(roomy.rms < 0.5 * on.rms);
    }
}

/* Views of noise, on any sheet: an eye never sees more wrong than without compensation. */
static void no_print_is_worse(void **state)
{
    (void)state;
    for (int round = 0; round < 12; round++) {
        lf_print print = sheet_print(40.0 + 5.3 * round, 0, SPOT_MM, round % 3 * 0.015);
        const reality sheet = {.ink_mm = print.blur.ink_mm, .spot_mm = SPOT_MM};
        print.n_views = 3 + (int)(0.3 + (600.0 / print.lpi - 3.0) * (round % 2 ? 1.0 : 0.6));
        print.stripes = round % 4 == 1 ? LF_STRIPES_NEAREST : LF_STRIPES_FRACTIONAL;
        if (round % 5 == 4)
            print = turned(print);
        const errors off = errors_of(&print, noise_value, &sheet);
        print.compensation.on = true;
        const errors on = errors_of(&print, noise_value, &sheet);
        assert_true(on.rms <= off.rms + 1e-5);
        assert_true(on.rms < 0.9 * off.rms || off.rms < 1e-4);
    }
}

/* ---------------------------------------------------------------------------------- dot gain -- */

static void dot_gain_is_undone(void **state)
{
    (void)state;
    for (int g = 0; g <= 45; g += 5)
        for (int i = 0; i <= 100; i++) {
            const double dark = 1.0 - lf_dot_gain_undone(0.01 * i, 0.01 * g);
            assert_true(dark >= -1e-12 && dark <= 1.0 + 1e-12);
            lf_assert_close(dark + 4.0 * 0.01 * g * dark * (1.0 - dark), 1.0 - 0.01 * i, 0.0,
                            1e-12);
        }
}

static void a_printer_with_dot_gain_shows_the_picture(void **state)
{
    (void)state;
    const reality sheet = {.gain = 0.18, .ink_mm = 0.0, .spot_mm = SPOT_MM};
    lf_print print = sheet_print(60.13, 6, SPOT_MM, 0.0);
    const errors off = errors_of(&print, scene_value, &sheet);
    print.compensation.on = true;
    print.compensation.headroom = 0.1;
    const errors without = errors_of(&print, scene_value, &sheet);
    print.blur.dot_gain = 0.18;
    const errors on = errors_of(&print, scene_value, &sheet);
    print_message("dot gain: error %.4f -> %.4f, crosstalk alone %.4f\n", off.rms, on.rms,
                  without.rms);
    assert_true(on.rms < 0.1 * off.rms);
    assert_true(without.rms > 0.5 * off.rms);
}

/* ------------------------------------------------------------------------------------- files -- */

static void off_changes_no_byte(void **state)
{
    (void)state;
    for (int round = 0; round < 2; round++) {
        lf_print plain = lf_print_odd();
        plain.horizontal = round;
        lf_print blurred = plain;
        blurred.blur = (lf_print_blur){.spot_mm = 0.03, .dot_gain = 0.2, .ink_mm = 0.02};
        lf_views32 card;
        lf_printed a, b, on;
        lf_card_make(&plain, lf_card_speckle, NULL, &card);
        lf_printed_make(&plain, &card, 0, &a);
        lf_printed_make(&blurred, &card, 0, &b);
        assert_int_equal(a.file_size, b.file_size);
        assert_memory_equal(a.file, b.file, a.file_size);
        assert_null(json_object_get(b.manifest, "compensation"));
        blurred.compensation.on = true;
        lf_printed_make(&blurred, &card, 0, &on);
        assert_memory_not_equal(a.value, on.value, sizeof *a.value * (size_t)a.width * 3);
        lf_printed_finish(&a);
        lf_printed_finish(&b);
        lf_printed_finish(&on);
        lf_card_finish(&card);
    }
}

static lf_print odd_compensated(bool horizontal)
{
    lf_print print = lf_print_odd();
    print.blur = (lf_print_blur){.spot_mm = 0.03, .dot_gain = 0.1, .ink_mm = 0.02};
    print.compensation.on = true;
    if (horizontal) {
        print = turned(print);
        print.width_mm = 3.3;
    }
    return print;
}

static void strips_do_not_change_the_print(void **state)
{
    (void)state;
    static const int strips[] = {1, 7, 64};
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        const lf_print print = odd_compensated(horizontal);
        lf_views32 card;
        lf_printed whole;
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        lf_printed_make(&print, &card, 0, &whole);
        for (size_t s = 0; s < sizeof strips / sizeof strips[0]; s++) {
            lf_printed other;
            lf_printed_make(&print, &card, strips[s], &other);
            lf_printed_assert_same(&whole, &other);
            assert_true(json_equal(json_object_get(whole.manifest, "compensation"),
                                   json_object_get(other.manifest, "compensation")));
            lf_printed_finish(&other);
        }
        lf_printed_finish(&whole);
        lf_card_finish(&card);
    }
}

/* Threads make strips in turn. */
static void threads_do_not_change_the_print(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(3, &pool), NULL);
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        const lf_print print = odd_compensated(horizontal);
        char *folder = lf_test_folder();
        lf_views32 card;
        lf_print_left left[2];
        char *bytes[2];
        size_t sizes[2];
        lf_error err;
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        for (int i = 0; i < 2; i++) {
            const lf_print_run run = {.pool = i ? pool : NULL, .out_left = &left[i]};
            const char *path = lf_test_path(folder, i ? "a.tif" : "b.tif");
            lf_outfile tiff, manifest;
            lf_assert_ok(lf_outfile_open(&tiff, path, false, &err), &err);
            lf_assert_ok(lf_outfile_open(&manifest, lf_test_path(folder, "c.json"), false, &err),
                         &err);
            lf_assert_ok(lf_print_write_strips(&print, &card, &run, 3, &tiff, &manifest, &err),
                         &err);
            lf_assert_ok(lf_outfile_commit(&tiff, false, &err), &err);
            lf_outfile_abandon(&manifest);
            lf_assert_ok(lf_file_read(path, NULL, UINT32_MAX, &bytes[i], &sizes[i], &err), &err);
        }
        assert_int_equal(sizes[0], sizes[1]);
        assert_memory_equal(bytes[0], bytes[1], sizes[0]);
        assert_memory_equal(&left[0].own_share, &left[1].own_share, 7 * sizeof left[0].own_share);
        lf_free(bytes[0]);
        lf_free(bytes[1]);
        lf_card_finish(&card);
        lf_test_folder_remove(folder);
    }
    lf_pool_destroy(pool);
}

/* A value that depends on the lens and the place along it, for either orientation. */
static float turning_value(const void *context, int view, int row, int column, int c)
{
    const lf_print *print = context;
    return 0.45F + 0.1F * (print->horizontal ? lf_card_speckle(NULL, view, column, row, c)
                                             : lf_card_speckle(NULL, view, row, column, c));
}

static void horizontal_lenses_are_vertical_ones_turned(void **state)
{
    (void)state;
    lf_print upright = odd_compensated(false);
    const lf_print across = turned(upright);
    lf_views32 cards[2];
    lf_printed a, b;
    int most = 0;
    lf_card_make(&upright, turning_value, &upright, &cards[0]);
    lf_card_make(&across, turning_value, &across, &cards[1]);
    lf_printed_make(&upright, &cards[0], 0, &a);
    lf_printed_make(&across, &cards[1], 0, &b);
    assert_int_equal(a.width, b.height);
    assert_int_equal(a.height, b.width);
    for (int y = 0; y < a.height; y++)
        for (int x = 0; x < a.width; x++)
            for (int c = 0; c < 3; c++) {
                const int differs = abs(lf_printed_at(&a, x, y, c) - lf_printed_at(&b, y, x, c));
                most = differs > most ? differs : most;
            }
    print_message("turned: differs by %d\n", most);
    assert_true(most <= 70); /* a thousandth: the parts of horizontal lenses end */
    lf_printed_finish(&a);
    lf_printed_finish(&b);
    lf_card_finish(&cards[0]);
    lf_card_finish(&cards[1]);
}

/* The manifest's numbers are what an eye sees. */
static void the_manifest_says_what_is_left(void **state)
{
    (void)state;
    const reality sheet = {.ink_mm = 0.015, .spot_mm = SPOT_MM};
    lf_print print = sheet_print(60.13, 8, SPOT_MM, 0.015);
    lf_views32 card;
    lf_printed printed;
    double ghost[2], worst[2], own[2], clamped;
    const errors off = errors_of(&print, noise_value, &sheet);
    const crosstalk share = crosstalk_of(&print, &sheet, 0.45, 0.55);
    print.compensation.on = true;
    const errors on = errors_of(&print, noise_value, &sheet);
    lf_card_make(&print, noise_value, &print, &card);
    for (size_t i = 0; i < (size_t)print.n_views * card.view_stride; i += 3) /* grey */
        ((float *)(uintptr_t)card.data)[i] = ((float *)(uintptr_t)card.data)[i + 2] =
            card.data[i + 1];
    lf_printed_make(&print, &card, 0, &printed);
    assert_int_equal(json_unpack(json_object_get(printed.manifest, "compensation"),
                                 "{s:{s:F, s:F}, s:{s:F, s:F}, s:{s:F, s:F}, s:F}",
                                 "own_share_before", "mean", &own[0], "worst", &own[1],
                                 "ghost_before", "mean", &ghost[0], "worst", &worst[0],
                                 "ghost_left", "mean", &ghost[1], "worst", &worst[1], "clamped",
                                 &clamped),
                     0);
    lf_assert_close(ghost[0], off.mean, 0.05, 0.0);
    lf_assert_close(ghost[1], on.mean, 0.05, 0.0);
    lf_assert_close(own[0], share.own, 0.0, 0.01);
    assert_true(own[1] < own[0] && worst[1] < worst[0] && worst[1] > ghost[1]);
    assert_true(clamped > 0.0 && clamped < 0.3);
    lf_printed_finish(&printed);
    lf_card_finish(&card);
}

/* ---------------------------------------------------------------------------------- mistakes -- */

static void assert_refused(const lf_print *print, const char *words)
{
    lf_error err;
    lf_assert_status(lf_print_check(print, NULL, &err), LF_E_ARG, NULL);
    assert_non_null(strstr(err.what, words));
    assert_null(strchr(err.what, '\n'));
}

static void mistakes_are_refused(void **state)
{
    (void)state;
    lf_print sound = lf_print_sound(), p;
    lf_error err;
    sound.compensation.on = true;
    p = sound, assert_refused(&p, "nothing is known");
    sound.blur.spot_mm = 0.02;
    lf_assert_ok(lf_print_check(&sound, NULL, &err), &err);
    p = sound, p.blur.ink_mm = 1.0, assert_refused(&p, "pixels cannot be compensated");
    p = sound, p.width_mm = 1.0, p.blur.ink_mm = 0.15, assert_refused(&p, "less than the print");
    p = sound, p.compensation.headroom = 0.5, assert_refused(&p, "headroom");
    p = sound, p.blur.n_crosstalk = 9, assert_refused(&p, "crosstalk");
    p = sound, p.blur.n_crosstalk = 1, assert_refused(&p, "crosstalk");
    p.blur.crosstalk[0] = -0.2, p.blur.crosstalk[1] = 1.0, p.blur.crosstalk[2] = 0.2;
    assert_refused(&p, "crosstalk");
    p.blur.crosstalk[0] = (double)NAN, assert_refused(&p, "crosstalk");
    p.blur.crosstalk[0] = 0.1, p.blur.crosstalk[1] = 0.7;
    lf_assert_ok(lf_print_check(&p, NULL, &err), &err);
    p = sound, p.sheet.columns = 2, p.sheet.rows = 1, assert_refused(&p, "one print");
    p = sound, p.frame_ppi = 300, assert_refused(&p, "frame set");
    p = sound, p.optics.slant = 5.0, assert_refused(&p, "straight linear lenses");
    /* off: nothing of it is asked */
    p = sound, p.compensation.on = false, p.blur.n_crosstalk = 9;
    lf_assert_ok(lf_print_check(&p, NULL, &err), &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_shares_rise_and_no_ghost_comes),
        cmocka_unit_test(black_and_white_need_headroom),
        cmocka_unit_test(a_wrong_blur_makes_ghosts),
        cmocka_unit_test(a_measured_crosstalk_is_taken_back),
        cmocka_unit_test(a_chart_serves_prints_of_any_views),
        cmocka_unit_test(pictures_have_fewer_ghosts),
        cmocka_unit_test(no_print_is_worse),
        cmocka_unit_test(dot_gain_is_undone),
        cmocka_unit_test(a_printer_with_dot_gain_shows_the_picture),
        cmocka_unit_test(off_changes_no_byte),
        cmocka_unit_test(strips_do_not_change_the_print),
        cmocka_unit_test(threads_do_not_change_the_print),
        cmocka_unit_test(horizontal_lenses_are_vertical_ones_turned),
        cmocka_unit_test(the_manifest_says_what_is_left),
        cmocka_unit_test(mistakes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
