/* Prints for slanted lenses, for sheets seen from close by and for micro lenses, looked at through
 * their sheets by optics alone. */
#include "tests/testing.h"

#include <complex.h>

#include "base/alloc.h"
#include "quilt/lens.h"
#include "quilt/print/print.h"
#include "tests/quilt/optical_oracle_2d.h"
#include "tests/quilt/printed.h"

#define INDEX 1.56
static const double pi = 3.14159265358979323846;

/* ---------------------------------------------------------------------------------- pictures -- */

/* Light of two channels of a print. */
typedef struct picture {
    lf_raster_light channel[2];
    double *light;
} picture;

static picture picture_of(const lf_print *print, const lf_views32 *views)
{
    lf_printed printed;
    lf_printed_make(print, views, 0, &printed);
    const size_t n = (size_t)printed.width * (size_t)printed.height;
    picture out = {.light = malloc(2 * n * sizeof *out.light)};
    assert_non_null(out.light);
    for (size_t i = 0; i < 2 * n; i++)
        out.light[i] = lf_printed_linear(&printed, (int)(i % n % (size_t)printed.width),
                                         (int)(i % n / (size_t)printed.width), (int)(i / n));
    for (int c = 0; c < 2; c++)
        out.channel[c] =
            (lf_raster_light){printed.width, printed.height, 25.4 / print->dpi,
                              25.4 / lf_print_dpi_down(print), out.light + (size_t)c * n};
    lf_printed_finish(&printed);
    return out;
}

static int columns_of(const lf_print *print)
{
    return print->n_views / lf_print_view_rows(print);
}

/* Views of one colour each, a place on a circle: by the view's column or by its row. */
static picture coded(const lf_print *print, bool by_row)
{
    const int columns = columns_of(print), rows = print->n_views / columns;
    float *data = lf_calloc((size_t)print->n_views, 3 * sizeof *data);
    assert_non_null(data);
    for (int view = 0; view < print->n_views; view++) {
        const double turn =
            by_row ? (view / columns + 0.5) / rows : (view % columns + 0.5) / columns;
        data[3 * view] = (float)(0.5 + 0.5 * cos(2.0 * pi * turn));
        data[3 * view + 1] = (float)(0.5 + 0.5 * sin(2.0 * pi * turn));
    }
    const lf_views32 views = {print->n_views, 1, 1, 3, 3, data, NULL, NULL, NULL};
    const picture out = picture_of(print, &views);
    lf_free(data);
    return out;
}

/* ------------------------------------------------------------------------------ what is seen -- */

/* A print and the sheet and eyes that look at it. */
typedef struct look {
    lf_print print;
    lf_sheet_2d sheet;
    double distance;
    bool middle_only;   /* judges one eye, in front of the middle */
    bool swaps_rasters; /* looks at the print as if it had the raster of the other axis */
} look;

static look look_at(lf_print print, double thickness_mm, double distance_mm)
{
    static const lf_lenslets kinds[] = {[LF_LENS_LINEAR] = LF_CYLINDERS,
                                        [LF_LENS_SQUARE] = LF_SQUARE_LENSLETS,
                                        [LF_LENS_HEXAGONAL] = LF_HEXAGON_LENSLETS};
    const double enlarged = 1.0 + thickness_mm / (INDEX * distance_mm);
    return (look){print,
                  {kinds[print.optics.grid], 25.4 / print.lpi / enlarged, thickness_mm, INDEX,
                   print.optics.slant + (print.horizontal ? 90.0 : 0.0), print.phase_mm / enlarged,
                   print.optics.phase_down_mm / enlarged},
                  distance_mm,
                  false,
                  false};
}

/* Where the camera of a view stands, by similar triangles from its stripe. */
static lf_eye eye_of(const look *l, int view)
{
    const int columns = columns_of(&l->print), rows = l->print.n_views / columns;
    const double pitch = 25.4 / l->print.lpi, reach = INDEX * l->distance / l->sheet.thickness_mm;
    const double column = (view % columns - 0.5 * (columns - 1)) / columns,
                 row = (view / columns - 0.5 * (rows - 1)) / rows;
    if (l->print.optics.grid != LF_LENS_LINEAR) {
        const double height =
            l->print.optics.grid == LF_LENS_HEXAGONAL ? 2.0 / sqrt(3.0) * pitch : pitch;
        return (lf_eye){column * pitch * reach, -row * height * reach, l->distance};
    }
    const double moved = column * pitch * reach / cos(l->print.optics.slant * pi / 180.0);
    return l->print.horizontal ? (lf_eye){0.0, moved, l->distance}
                               : (lf_eye){moved, 0.0, l->distance};
}

/* What the eyes at all cameras see. Zones are 25ths of the print. */
typedef struct error {
    double drift; /* the largest distance of a zone's mean from the own view, in views */
    double clear; /* share of the own view's colour, on the average: 1 = no crosstalk */
} error;

#define ZONES 5

static double half_width(const lf_raster_light *r)
{
    return 0.5 * r->width * r->right_mm;
}

static double half_height(const lf_raster_light *r)
{
    return 0.5 * r->height * r->down_mm;
}

/* Calls visit for about n_most tops of lenses inside the raster, two lenses from its edges. */
static void each_top(const look *l, const lf_raster_light *r, int n_most,
                     void (*visit)(void *context, const double top[2]), void *context)
{
    const double edge = fmin(2.0 * l->sheet.pitch_mm, 0.25 * half_height(r));
    const double reach = hypot(half_width(r), half_height(r));
    const int last = (int)(reach / l->sheet.pitch_mm / 0.8) + 1;
    uint32_t random = 1;
    int done = 0;
    for (int tries = 0; tries < 200 * n_most && done < n_most; tries++) {
        double top[2];
        random = random * 1664525u + 1013904223u;
        const int i = (int)(random >> 8) % (2 * last + 1) - last;
        random = random * 1664525u + 1013904223u;
        const int j = (int)(random >> 8) % (2 * last + 1) - last;
        lf_lens_top(&l->sheet, i, j, j * reach / last, top);
        if (fabs(top[0]) > half_width(r) - edge || fabs(top[1]) > half_height(r) - edge)
            continue;
        visit(context, top);
        done++;
    }
    assert_true(done > n_most / 8);
}

typedef struct judging {
    const look *l;
    const picture *p;
    lf_eye eye;
    double complex own, sum, zone[ZONES][ZONES];
    int n, n_bins;
} judging;

static int zone_of(double at, double half)
{
    const int zone = (int)floor((at / half + 1.0) * 0.5 * ZONES);
    return zone < 0 ? 0 : zone >= ZONES ? ZONES - 1 : zone;
}

static void judge(void *context, const double top[2])
{
    judging *j = context;
    double at[2];
    lf_print_point(&j->l->sheet, &j->eye, top, at);
    const double spot = 0.5 * j->l->sheet.pitch_mm / j->n_bins;
    const double re = lf_spot_light(&j->l->sheet, &j->p->channel[0], at, spot),
                 im = lf_spot_light(&j->l->sheet, &j->p->channel[1], at, spot);
    const double complex seen = CMPLX(2.0 * re - 1.0, 2.0 * im - 1.0) * conj(j->own);
    j->sum += seen;
    j->zone[zone_of(top[1], half_height(&j->p->channel[0]))]
           [zone_of(top[0], half_width(&j->p->channel[0]))] += seen;
    j->n++;
}

/* What an eye sees, by columns or by rows of views. */
static error error_of_view(const look *l, const picture *p, int view, bool by_row)
{
    const int columns = columns_of(&l->print), rows = l->print.n_views / columns;
    const double turn = by_row ? (view / columns + 0.5) / rows : (view % columns + 0.5) / columns;
    judging j = {.l = l,
                 .p = p,
                 .eye = eye_of(l, view),
                 .own = cexp(CMPLX(0.0, 2.0 * pi * turn)),
                 .n_bins = by_row ? rows : columns};
    error e = {0};
    each_top(l, &p->channel[0], l->print.optics.grid != LF_LENS_LINEAR ? 250 : 600, judge, &j);
    for (int zone = 0; zone < ZONES * ZONES; zone++)
        e.drift =
            fmax(e.drift, fabs(carg(j.zone[zone / ZONES][zone % ZONES])) * j.n_bins / (2.0 * pi));
    e.clear = creal(j.sum) / j.n;
    return e;
}

/* Half a view from the rim of its lens's cell, or more: views in the corners of the rectangle about
 * a hexagon are not shown. */
static bool is_in_cell(const look *l, int view)
{
    if (l->print.optics.grid != LF_LENS_HEXAGONAL)
        return true;
    const int columns = columns_of(&l->print), rows = l->print.n_views / columns;
    const double u = fabs(view % columns - 0.5 * (columns - 1)) / columns,
                 v = fabs(view / columns - 0.5 * (rows - 1)) / rows * 2.0 / sqrt(3.0);
    return 0.5 * u + sqrt(0.75) * v < 0.5 - 0.5 / columns;
}

static bool is_judged(const look *l, int view)
{
    if (l->middle_only)
        return view == l->print.n_views / 2;
    /* a part of the many */
    return l->print.optics.grid == LF_LENS_LINEAR || (view * 5 % 3 == 0 && is_in_cell(l, view));
}

static error error_of(const look *l)
{
    error all = {0.0, 1.0};
    for (int by_row = 0; by_row < (l->print.optics.grid == LF_LENS_LINEAR ? 1 : 2); by_row++) {
        picture p = coded(&l->print, by_row);
        for (int c = 0; c < 2 && l->swaps_rasters; c++) {
            p.channel[c].right_mm = 25.4 / l->print.dpi_down;
            p.channel[c].down_mm = 25.4 / l->print.dpi;
        }
        for (int view = 0; view < l->print.n_views; view++) {
            if (!is_judged(l, view))
                continue;
            const error e = error_of_view(l, &p, view, by_row);
            all.drift = fmax(all.drift, e.drift);
            all.clear = fmin(all.clear, e.clear);
        }
        free(p.light);
    }
    return all;
}

/* ------------------------------------------------------------------------------------ sheets -- */

static lf_print print_of(double lpi, double dpi, double dpi_down, double width, double height,
                         int n_views)
{
    lf_print print = lf_print_sound();
    print.lpi = lpi;
    print.dpi = dpi;
    print.dpi_down = dpi_down;
    print.width_mm = width;
    print.height_mm = height;
    print.n_views = n_views;
    print.phase_mm = 0.07;
    return print;
}

static look slanted(double slant, bool horizontal, double dpi, double dpi_down)
{
    lf_print print = print_of(40.13, dpi, dpi_down, horizontal ? 10 : 30, horizontal ? 30 : 10, 8);
    print.optics.slant = slant;
    print.horizontal = horizontal;
    return look_at(print, 2.5, 400.0);
}

static look micro(lf_lens_grid grid, double slant, lf_stripes stripes)
{
    lf_print print = print_of(25.07, 600, 600, 24, 18, 64);
    print.optics.grid = grid;
    print.optics.slant = slant;
    print.optics.phase_down_mm = -0.11;
    print.stripes = stripes;
    return look_at(print, 6.0, 500.0);
}

static look exact(look l)
{
    l.print.optics.map = LF_MAP_EXACT;
    l.print.optics.thickness_mm = l.sheet.thickness_mm;
    l.print.optics.index = INDEX;
    l.print.optics.distance_mm = l.distance;
    return l;
}

/* As wide as A3, from close by. */
static look large(double slant, lf_lens_map map)
{
    lf_print print = print_of(40.13, 600, 600, 420, 6, 9);
    print.optics.slant = slant;
    print.optics.map = map;
    print.optics.thickness_mm = 0.9;
    print.optics.index = INDEX;
    print.optics.distance_mm = 220;
    look l = look_at(print, 0.9, 220.0);
    l.middle_only = true;
    return l;
}

static void assert_seen(const char *name, const look *l, double most)
{
    const error e = error_of(l);
    print_message("%s: off by up to %.3f views, clear %.2f\n", name, e.drift, e.clear);
    assert_true(e.drift < most);
    assert_true(e.clear > 0.75);
}

static void slanted_views_are_seen_from_their_cameras(void **state)
{
    (void)state;
    const struct {
        const char *name;
        look l;
    } cases[] = {
        {"straight", slanted(0, false, 600, 600)},
        {"right", slanted(12, false, 600, 600)},
        {"left", slanted(-26.565, false, 600, 600)},
        {"steep", slanted(55, false, 600, 600)},
        {"720 x 360", slanted(12, false, 720, 360)},
        {"400 x 1200", slanted(-8, false, 400, 1200)},
        {"horizontal", slanted(9, true, 600, 600)},
        {"horizontal, other way", slanted(-21, true, 600, 600)},
        {"horizontal, 360 x 720", slanted(9, true, 360, 720)},
        {"horizontal, exact", exact(slanted(9, true, 360, 720))},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_seen(cases[i].name, &cases[i].l, 0.15);
}

static void a_large_print_seen_close_needs_the_exact_map(void **state)
{
    (void)state;
    look l = large(0, LF_MAP_EXACT);
    assert_seen("A3", &l, 0.1);
    l = large(5, LF_MAP_AUTO);
    assert_seen("A3, slanted", &l, 0.1);
    for (int slant = 0; slant < 6; slant += 5) {
        l = large(slant, LF_MAP_UNIFORM);
        const double drift = error_of(&l).drift;
        print_message("uniform: off by up to %.3f views\n", drift);
        assert_true(drift > 0.4);
    }
}

static void micro_views_are_seen_from_their_cameras_both_ways(void **state)
{
    (void)state;
    const struct {
        const char *name;
        look l;
    } cases[] = {
        {"square", micro(LF_LENS_SQUARE, 0, LF_STRIPES_FRACTIONAL)},
        {"square, nearest", micro(LF_LENS_SQUARE, 0, LF_STRIPES_NEAREST)},
        {"square, turned", micro(LF_LENS_SQUARE, 3, LF_STRIPES_FRACTIONAL)},
        {"square, exact", exact(micro(LF_LENS_SQUARE, 0, LF_STRIPES_FRACTIONAL))},
        {"hexagonal, exact", exact(micro(LF_LENS_HEXAGONAL, 1, LF_STRIPES_NEAREST))},
        {"hexagonal", micro(LF_LENS_HEXAGONAL, 0, LF_STRIPES_FRACTIONAL)},
        {"hexagonal, nearest", micro(LF_LENS_HEXAGONAL, 0, LF_STRIPES_NEAREST)},
        {"hexagonal, turned", micro(LF_LENS_HEXAGONAL, -2, LF_STRIPES_FRACTIONAL)},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_seen(cases[i].name, &cases[i].l, 0.15);
}

static void other_sheets_do_not_show_the_views(void **state)
{
    (void)state;
    look cases[9] = {slanted(12, false, 600, 600),
                     slanted(12, false, 600, 600),
                     slanted(9, true, 600, 600),
                     slanted(12, false, 720, 360),
                     micro(LF_LENS_SQUARE, 0, LF_STRIPES_FRACTIONAL),
                     micro(LF_LENS_SQUARE, 0, LF_STRIPES_FRACTIONAL),
                     micro(LF_LENS_HEXAGONAL, 0, LF_STRIPES_FRACTIONAL),
                     micro(LF_LENS_HEXAGONAL, 0, LF_STRIPES_FRACTIONAL),
                     large(5, LF_MAP_EXACT)};
    cases[0].sheet.axis_deg = -12; /* leans the other way */
    cases[1].sheet.axis_deg += 90; /* swapped axes */
    cases[2].sheet.axis_deg = 81;  /* leans the other way */
    cases[3].swaps_rasters = true;
    cases[4].print.reverse = true; /* pictures under lenses are not turned */
    cases[5].sheet.kind = LF_HEXAGON_LENSLETS;
    cases[6].sheet.kind = LF_SQUARE_LENSLETS;
    cases[7].print.optics.grid = LF_LENS_SQUARE;
    cases[8].sheet.pitch_mm *= 1.001;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const error e = error_of(&cases[i]);
        print_message("control %zu: off by up to %.3f views, clear %.2f\n", i, e.drift, e.clear);
        assert_true(e.drift > 0.5);
    }
}

/* --------------------------------------------------------------------------------- positions -- */

enum { SIDE = 300 };

/* The same picture in all views: the first channel grows to the right, the second downwards. */
static picture graded(const lf_print *print)
{
    float *data = lf_calloc((size_t)SIDE * SIDE, 3 * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < SIDE * SIDE; i++) {
        data[3 * i] = (float)((i % SIDE + 0.5) / SIDE);
        data[3 * i + 1] = (float)((i / SIDE + 0.5) / SIDE);
    }
    const lf_views32 views = {print->n_views, SIDE, SIDE, 0,   3 * (size_t)SIDE,
                              data,           NULL, NULL, NULL};
    const picture out = picture_of(print, &views);
    lf_free(data);
    return out;
}

typedef struct placing {
    const look *l;
    const picture *p;
    lf_eye eye;
    double worst; /* mm */
} placing;

/* The picture lies on the print: its light tells where the eye sees what is in a lens. */
static void place(void *context, const double top[2])
{
    placing *p = context;
    const double enlarged = 1.0 + p->l->sheet.thickness_mm / (INDEX * p->l->distance);
    double at[2];
    lf_print_point(&p->l->sheet, &p->eye, top, at);
    for (int c = 0; c < 2; c++) {
        const lf_raster_light *r = &p->p->channel[c];
        const double seen = lf_spot_light(&p->l->sheet, r, at, 0.1 * p->l->sheet.pitch_mm) - 0.5,
                     there = enlarged * top[c];
        p->worst = fmax(p->worst, fabs(seen * 2.0 * (c ? half_height(r) : half_width(r)) - there));
    }
}

/* The largest error of a place that any eye sees, in lenses. */
static double misplaced(const look *l)
{
    picture p = graded(&l->print);
    double worst = 0.0;
    for (int view = 0; view < l->print.n_views; view += 3) {
        if (!is_in_cell(l, view))
            continue;
        placing job = {l, &p, eye_of(l, view), 0.0};
        if (l->middle_only)
            job.eye = (lf_eye){0.0, 0.0, l->distance};
        each_top(l, &p.channel[0], 200, place, &job);
        worst = fmax(worst, job.worst);
    }
    free(p.light);
    return worst / l->sheet.pitch_mm;
}

static look fine(look l)
{
    l.print.bits = 16;
    return l;
}

/* Straight edges then look straight: each lens shows the picture at its own axis. */
static void lenses_show_the_picture_where_they_are(void **state)
{
    (void)state;
    const struct {
        const char *name;
        look l;
    } cases[] = {
        {"straight", fine(slanted(0, false, 600, 600))},
        {"right", fine(slanted(12, false, 600, 600))},
        {"left", fine(slanted(-26.565, false, 600, 600))},
        {"720 x 360", fine(slanted(12, false, 720, 360))},
        {"horizontal", fine(slanted(9, true, 600, 600))},
        {"horizontal, other way", fine(slanted(-21, true, 360, 720))},
        {"exact", fine(large(5, LF_MAP_EXACT))},
        {"square", fine(micro(LF_LENS_SQUARE, 0, LF_STRIPES_FRACTIONAL))},
        {"square, turned", fine(micro(LF_LENS_SQUARE, 3, LF_STRIPES_FRACTIONAL))},
        {"hexagonal", fine(micro(LF_LENS_HEXAGONAL, 0, LF_STRIPES_FRACTIONAL))},
        {"hexagonal, turned", fine(micro(LF_LENS_HEXAGONAL, -2, LF_STRIPES_NEAREST))},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double worst = misplaced(&cases[i].l);
        print_message("%s: off by up to %.3f lenses\n", cases[i].name, worst);
        assert_true(worst < 0.25);
    }
    look wrong = fine(slanted(12, false, 600, 600));
    wrong.sheet.axis_deg = 0;
    assert_true(misplaced(&wrong) > 0.4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slanted_views_are_seen_from_their_cameras),
        cmocka_unit_test(a_large_print_seen_close_needs_the_exact_map),
        cmocka_unit_test(micro_views_are_seen_from_their_cameras_both_ways),
        cmocka_unit_test(other_sheets_do_not_show_the_views),
        cmocka_unit_test(lenses_show_the_picture_where_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
