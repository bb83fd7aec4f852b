/* Prints looked at through the lens sheet that they are made for (lenticular.md section 3, T1 to T5
 * and T7; numbers of 1.4). */
#include "tests/testing.h"

#include <complex.h>
#include <jpeglib.h>

#include "base/alloc.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define A4_WIDTH_MM 210.0
#define DISTANCE_MM 400.0
#define THICKNESS_MM 0.6
#define INDEX 1.56

static const double pi = 3.14159265358979323846;

/* ---------------------------------------------------------------------------- rows of prints -- */

/* Linear light of one row and channel. */
typedef struct light_row {
    int n;
    double pixel_mm;
    double *light;
} light_row;

static light_row row_of(const lf_printed *printed, double dpi, int y, int c)
{
    light_row row = {printed->width, 25.4 / dpi,
                     malloc((size_t)printed->width * sizeof *row.light)};
    assert_non_null(row.light);
    for (int x = 0; x < row.n; x++)
        row.light[x] = lf_printed_linear(printed, x, y, c);
    return row;
}

/* One row of a print whose views are each of one grey. */
static light_row grey_row(const lf_print *print, const double *grey)
{
    lf_print_shape shape;
    lf_printed printed;
    lf_print_shape_of(print, &shape);
    float *data = lf_calloc((size_t)print->n_views, 3 * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < 3 * print->n_views; i++)
        data[i] = (float)grey[i / 3];
    /* a view of one pixel is stretched over the print */
    const lf_views32 views = {print->n_views, 1, 1, 3, 3, data, NULL, NULL, NULL};
    lf_printed_make(print, &views, 0, &printed);
    const light_row row = row_of(&printed, print->dpi, printed.height / 2, 1);
    lf_printed_finish(&printed);
    lf_free(data);
    return row;
}

static lf_print a4_print(double lpi, int dpi, int n_views, lf_stripes stripes)
{
    lf_print print = lf_print_sound();
    print.lpi = lpi;
    print.dpi = dpi;
    print.width_mm = A4_WIDTH_MM;
    print.height_mm = 1.0;
    print.n_views = n_views;
    print.stripes = stripes;
    print.bits = 16;
    return print;
}

/* Spoils a row as a mistake or a careless print path would. */
typedef void (*spoil_fn)(light_row *row);

static void spoil_nothing(light_row *row)
{
    (void)row;
}

static void spoil_mirror(light_row *row)
{
    for (int a = 0, b = row->n - 1; a < b; a++, b--) {
        const double v = row->light[a];
        row->light[a] = row->light[b];
        row->light[b] = v;
    }
}

static void spoil_shift(light_row *row)
{
    memmove(row->light + 1, row->light, (size_t)(row->n - 1) * sizeof *row->light);
}

/* A driver that enlarges by 0.1 %, about the middle. */
static void spoil_resize(light_row *row)
{
    double *old = malloc((size_t)row->n * sizeof *old);
    assert_non_null(old);
    memcpy(old, row->light, (size_t)row->n * sizeof *old);
    for (int x = 0; x < row->n; x++) {
        const double s = (x + 0.5 - 0.5 * row->n) / 1.001 + 0.5 * row->n - 0.5;
        const int first = s < 0.0 ? 0 : s > row->n - 2.0 ? row->n - 2 : (int)s;
        row->light[x] = old[first] + (s - first) * (old[first + 1] - old[first]);
    }
    free(old);
}

static unsigned char code_of(double light)
{
    const double v = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
    return (unsigned char)lround(255.0 * fmin(fmax(v, 0.0), 1.0));
}

static void spoil_7_bits(light_row *row)
{
    for (int x = 0; x < row->n; x++)
        row->light[x] = lf_srgb_to_linear((code_of(row->light[x]) & 0xfe) / 255.0);
}

static unsigned char *jpeg_of(const unsigned char *codes, int width, int height,
                              unsigned long *out_size)
{
    struct jpeg_error_mgr errors;
    struct jpeg_compress_struct out = {.err = jpeg_std_error(&errors)};
    unsigned char *data = NULL, *line = malloc((size_t)width);
    assert_non_null(line);
    memcpy(line, codes, (size_t)width);
    jpeg_create_compress(&out);
    jpeg_mem_dest(&out, &data, out_size);
    out.image_width = (JDIMENSION)width;
    out.image_height = (JDIMENSION)height;
    out.input_components = 1;
    out.in_color_space = JCS_GRAYSCALE;
    jpeg_set_defaults(&out);
    jpeg_set_quality(&out, 90, TRUE);
    jpeg_start_compress(&out, TRUE);
    for (int y = 0; y < height; y++)
        jpeg_write_scanlines(&out, &line, 1);
    jpeg_finish_compress(&out);
    jpeg_destroy_compress(&out);
    free(line);
    return data;
}

static void spoil_jpeg(light_row *row)
{
    struct jpeg_error_mgr errors;
    struct jpeg_decompress_struct in = {.err = jpeg_std_error(&errors)};
    unsigned char *codes = malloc((size_t)row->n);
    unsigned long size = 0;
    assert_non_null(codes);
    for (int x = 0; x < row->n; x++)
        codes[x] = code_of(row->light[x]);
    unsigned char *data = jpeg_of(codes, row->n, 8, &size);
    jpeg_create_decompress(&in);
    jpeg_mem_src(&in, data, size);
    assert_int_equal(jpeg_read_header(&in, TRUE), JPEG_HEADER_OK);
    jpeg_start_decompress(&in);
    jpeg_read_scanlines(&in, &codes, 1);
    jpeg_destroy_decompress(&in);
    for (int x = 0; x < row->n; x++)
        row->light[x] = lf_srgb_to_linear(codes[x] / 255.0);
    free(codes);
    free(data);
}

/* ------------------------------------------------------------------------------ what is seen -- */

static double eye_of_view(int i, int n_views, double lpi, double distance_mm)
{
    return (i - 0.5 * (n_views - 1)) * (25.4 / lpi / n_views) * INDEX * distance_mm / THICKNESS_MM;
}

/* ---------------------------------------------------------------------------- T1: exact case -- */

/* An 8-bit code for each sample, in linear light. */
static unsigned char card_code(int view, int row, int column, int c)
{
    uint32_t h = (uint32_t)(view * 73 + row * 9176 + column * 51749 + c * 331) * 2654435761u;
    return (unsigned char)(h >> 24);
}

static float card_value(const void *context, int view, int row, int column, int c)
{
    (void)context;
    return (float)lf_srgb_to_linear(card_code(view, row, column, c) / 255.0);
}

/* How many samples of a 10-view card, 60.00 lpi on 600 dpi, are not seen as they were. */
static int samples_lost(const lf_print *print, spoil_fn spoil)
{
    const lf_sheet sheet = lf_sheet_for(60.0, DISTANCE_MM, THICKNESS_MM, INDEX, 0.0);
    lf_print_shape shape;
    lf_views32 card;
    lf_printed printed;
    int lost = 0, first, last;
    lf_print_shape_of(print, &shape);
    lf_card_make(print, card_value, NULL, &card);
    lf_printed_make(print, &card, 0, &printed);
    for (int i = 0; i < printed.height * 3; i++) {
        light_row row = row_of(&printed, 600, i / 3, i % 3);
        spoil(&row);
        lf_row_light light = lf_row_light_of(row.light, row.n, row.pixel_mm);
        lf_lenses_inside(&sheet, &light, &first, &last);
        assert_true(last - first > 100);
        for (int k = first; k <= last; k++) {
            for (int view = 0; view < 10; view++) {
                const double seen =
                    lf_seen_through(&sheet, &light, k, eye_of_view(view, 10, 60.0, DISTANCE_MM),
                                    DISTANCE_MM, 0.98 * row.pixel_mm, false);
                lost += fabs(seen - (double)card_value(NULL, view, i / 3, k - shape.first_lens,
                                                       i % 3)) > 1e-6;
            }
        }
        lf_row_light_finish(&light);
        free(row.light);
    }
    lf_printed_finish(&printed);
    lf_card_finish(&card);
    return lost;
}

static lf_print exact_print(lf_stripes stripes)
{
    lf_print print = lf_print_sound();
    print.n_views = 10;
    print.stripes = stripes;
    return print;
}

static void every_view_of_a_60_lpi_card_is_recovered_exactly(void **state)
{
    (void)state;
    const lf_print nearest = exact_print(LF_STRIPES_NEAREST),
                   fractional = exact_print(LF_STRIPES_FRACTIONAL);
    assert_int_equal(samples_lost(&nearest, spoil_nothing), 0);
    assert_int_equal(samples_lost(&fractional, spoil_nothing), 0);
}

static void a_spoiled_60_lpi_card_is_not_recovered(void **state)
{
    (void)state;
    static const spoil_fn spoils[] = {spoil_mirror, spoil_shift, spoil_resize, spoil_jpeg,
                                      spoil_7_bits};
    lf_print print = exact_print(LF_STRIPES_FRACTIONAL);
    for (size_t s = 0; s < sizeof spoils / sizeof spoils[0]; s++)
        assert_true(samples_lost(&print, spoils[s]) > 1000);
    print.reverse = true;
    assert_true(samples_lost(&print, spoil_nothing) > 1000);
}

/* ---------------------------------------------------------------------- T2: crosstalk matrix -- */

#define MOST_VIEWS 10

typedef struct crosstalk {
    int n_views;
    double mean[MOST_VIEWS][MOST_VIEWS]; /* [eye at view i][view j is white] over the lenses */
    double worst[MOST_VIEWS];            /* least own share of a lens */
} crosstalk;

static void look(const lf_print *print, const lf_sheet *sheet, double distance_mm,
                 const light_row *row, int white, crosstalk *out)
{
    lf_row_light light = lf_row_light_of(row->light, row->n, row->pixel_mm);
    const double spot = 0.5 * 25.4 / print->lpi / print->n_views;
    int first, last;
    lf_lenses_inside(sheet, &light, &first, &last);
    for (int i = 0; i < print->n_views; i++) {
        double sum = 0.0, least = 1.0;
        for (int k = first; k <= last; k++) {
            const double seen = lf_seen_through(
                sheet, &light, k, eye_of_view(i, print->n_views, print->lpi, distance_mm),
                distance_mm, spot, false);
            sum += seen;
            least = fmin(least, seen);
        }
        out->mean[i][white] = sum / (last - first + 1);
        if (i == white)
            out->worst[i] = least;
    }
    lf_row_light_finish(&light);
}

/* sheet_lpi is the visual pitch of the sheet at DISTANCE_MM; the eye is at distance_mm. */
static crosstalk crosstalk_of(const lf_print *print, double sheet_lpi, double distance_mm,
                              spoil_fn spoil)
{
    const lf_sheet sheet = lf_sheet_for(sheet_lpi, DISTANCE_MM, THICKNESS_MM, INDEX, 0.0);
    crosstalk out = {.n_views = print->n_views};
    for (int white = 0; white < print->n_views; white++) {
        double grey[MOST_VIEWS] = {0.0};
        grey[white] = 1.0;
        light_row row = grey_row(print, grey);
        spoil(&row);
        look(print, &sheet, distance_mm, &row, white, &out);
        free(row.light);
    }
    return out;
}

static double own_share(const crosstalk *c)
{
    double sum = 0.0;
    for (int i = 0; i < c->n_views; i++)
        sum += c->mean[i][i];
    return sum / c->n_views;
}

static double worst_lens(const crosstalk *c)
{
    double least = 1.0;
    for (int i = 0; i < c->n_views; i++)
        least = fmin(least, c->worst[i]);
    return least;
}

static int strongest(const crosstalk *c, int i)
{
    int best = 0;
    for (int j = 1; j < c->n_views; j++)
        best = c->mean[i][j] > c->mean[i][best] ? j : best;
    return best;
}

static bool in_order(const crosstalk *c)
{
    for (int i = 0; i < c->n_views; i++)
        if (strongest(c, i) != i)
            return false;
    return true;
}

static void each_eye_sees_mostly_its_own_view(void **state)
{
    (void)state;
    static const struct {
        int dpi, n_views;
        lf_stripes stripes;
        double mean, worst; /* lenticular.md section 1.4 */
    } rows[] = {
        {600, 10, LF_STRIPES_NEAREST, 0.870, 0.000},
        {600, 10, LF_STRIPES_FRACTIONAL, 0.722, 0.499},
        {600, 8, LF_STRIPES_NEAREST, 0.943, 0.698},
        {600, 8, LF_STRIPES_FRACTIONAL, 0.826, 0.624},
        {600, 6, LF_STRIPES_NEAREST, 0.991, 0.899},
        {600, 6, LF_STRIPES_FRACTIONAL, 0.920, 0.832},
        {1200, 10, LF_STRIPES_NEAREST, 1.000, 0.999},
        {1200, 10, LF_STRIPES_FRACTIONAL, 0.958, 0.937},
    };

    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        const lf_print print = a4_print(60.13, rows[r].dpi, rows[r].n_views, rows[r].stripes);
        const crosstalk c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_nothing);
        print_message("%d views, %d dpi, %s: own share %.3f, worst lens %.3f\n", rows[r].n_views,
                      rows[r].dpi, rows[r].stripes == LF_STRIPES_NEAREST ? "nearest" : "fractional",
                      own_share(&c), worst_lens(&c));
        assert_true(in_order(&c));
        assert_true(own_share(&c) >= rows[r].mean - 0.01);
        assert_true(worst_lens(&c) >= rows[r].worst - 0.01);
        for (int i = 0; i < c.n_views; i++) {
            double sum = 0.0;
            for (int j = 0; j < c.n_views; j++)
                sum += c.mean[i][j];
            lf_assert_close(sum, 1.0, 0.0, 2e-4);
        }
    }
}

static void mistakes_show_in_the_crosstalk(void **state)
{
    (void)state;
    lf_print print = a4_print(60.13, 600, 10, LF_STRIPES_FRACTIONAL);
    crosstalk c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_mirror);
    assert_false(in_order(&c));
    c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_shift);
    lf_assert_close(own_share(&c), 0.138, 0.0, 0.01);
    c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_resize);
    lf_assert_close(own_share(&c), 0.203, 0.0, 0.02);

    print.lpi = 60.00;
    c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_nothing);
    assert_true(own_share(&c) < 0.15);

    print.lpi = 60.13;
    print.phase_mm = 0.021;
    c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_nothing);
    lf_assert_close(own_share(&c), 0.50, 0.0, 0.02);

    print.phase_mm = 0.0;
    print.reverse = true;
    c = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_nothing);
    for (int i = 0; i < 10; i++)
        assert_int_equal(strongest(&c, i), 9 - i);
}

/* A print for one distance, looked at from twice as far (T7). */
static void the_wrong_distance_costs_what_optics_say(void **state)
{
    (void)state;
    const lf_print print = a4_print(60.13, 600, 10, LF_STRIPES_FRACTIONAL);
    const crosstalk at = crosstalk_of(&print, 60.13, DISTANCE_MM, spoil_nothing);
    const crosstalk beyond = crosstalk_of(&print, 60.13, 2.0 * DISTANCE_MM, spoil_nothing);
    lf_assert_close(own_share(&at), 0.722, 0.0, 0.01);
    lf_assert_close(own_share(&beyond), 0.415, 0.0, 0.02);
    assert_true(worst_lens(&beyond) < 0.05);
}

/* ------------------------------------------------------------------------- T3: lock-in meter -- */

typedef struct meter {
    double accumulated_um; /* over the width */
    double phase_um;       /* at the middle */
    double residual_um;    /* largest of a block */
} meter;

#define BLOCK_LENSES 20
#define MAX_BLOCKS 64

/* Phase of each block of lenses against a grating of the pitch that the sheet asks for. */
static int block_phases(const light_row *cosine, const light_row *sine, double pitch_mm,
                        double *out_x, double *out_phase)
{
    const double complex i = CMPLX(0.0, 1.0);
    const double half = 0.5 * cosine->n * cosine->pixel_mm, block_mm = BLOCK_LENSES * pitch_mm;
    const int n_blocks = (int)(2.0 * half / block_mm);

    assert_true(n_blocks > 4 && n_blocks <= MAX_BLOCKS);
    for (int b = 0; b < n_blocks; b++) {
        const double left = (b - 0.5 * n_blocks) * block_mm;
        const int first = (int)ceil((left + half) / cosine->pixel_mm - 0.5);
        const int end = (int)ceil((left + block_mm + half) / cosine->pixel_mm - 0.5);
        double complex sum = 0.0;

        for (int j = first; j < end; j++) {
            const double x = (j + 0.5) * cosine->pixel_mm - half;
            sum += (2.0 * cosine->light[j] - 1.0 + i * (2.0 * sine->light[j] - 1.0)) *
                   cexp(2.0 * pi * i * x / pitch_mm);
        }
        out_x[b] = left + 0.5 * block_mm;
        out_phase[b] = carg(-sum);
        if (b > 0)
            out_phase[b] += 2.0 * pi * round((out_phase[b - 1] - out_phase[b]) / (2.0 * pi));
    }
    return n_blocks;
}

static meter fit(const double *x, const double *phase, int n, double pitch_mm, double width_mm)
{
    const double um = pitch_mm / (2.0 * pi) * 1e3;
    double sx = 0.0, sp = 0.0, sxx = 0.0, sxp = 0.0;
    meter out = {0.0, 0.0, 0.0};
    for (int b = 0; b < n; b++) {
        sx += x[b];
        sp += phase[b];
        sxx += x[b] * x[b];
        sxp += x[b] * phase[b];
    }
    const double slope = (n * sxp - sx * sp) / (n * sxx - sx * sx), middle = (sp - slope * sx) / n;
    out.accumulated_um = slope * width_mm * um;
    out.phase_um = middle * um;
    for (int b = 0; b < n; b++)
        out.residual_um = fmax(out.residual_um, fabs(phase[b] - middle - slope * x[b]) * um);
    return out;
}

/* Views carry a complex code each, in two prints; what the print says is read against lpi. */
static meter measure(const lf_print *print, double lpi, spoil_fn spoil)
{
    double cosines[MOST_VIEWS], sines[MOST_VIEWS], x[MAX_BLOCKS], phase[MAX_BLOCKS];
    const double pitch_mm = 25.4 / lpi;
    for (int i = 0; i < print->n_views; i++) {
        cosines[i] = 0.5 + 0.5 * cos(2.0 * pi * (i + 0.5) / print->n_views);
        sines[i] = 0.5 + 0.5 * sin(2.0 * pi * (i + 0.5) / print->n_views);
    }
    light_row cosine = grey_row(print, cosines), sine = grey_row(print, sines);
    spoil(&cosine);
    spoil(&sine);
    const int n = block_phases(&cosine, &sine, pitch_mm, x, phase);
    const meter out = fit(x, phase, n, pitch_mm, print->width_mm);
    free(cosine.light);
    free(sine.light);
    print_message("accumulated %.3f um, phase %.3f um, residual %.3f um\n", out.accumulated_um,
                  out.phase_um, out.residual_um);
    return out;
}

static void pitch_and_phase_are_exact_over_a4(void **state)
{
    (void)state;
    const lf_print fractional = a4_print(60.13, 600, 10, LF_STRIPES_FRACTIONAL);
    const lf_print nearest = a4_print(60.13, 600, 10, LF_STRIPES_NEAREST);
    meter m = measure(&fractional, 60.13, spoil_nothing);
    assert_true(fabs(m.accumulated_um) < 1.0);
    assert_true(fabs(m.phase_um) < 1.0);
    assert_true(m.residual_um < 0.5);
    m = measure(&nearest, 60.13, spoil_nothing);
    assert_true(fabs(m.accumulated_um) <= 3.0);
    assert_true(fabs(m.phase_um) < 1.0);
    assert_true(m.residual_um < 21.2);
}

static void the_meter_reads_what_is_wrong(void **state)
{
    (void)state;
    lf_print print = a4_print(60.13, 600, 10, LF_STRIPES_FRACTIONAL);
    lf_assert_close(fabs(measure(&print, 60.14, spoil_nothing).accumulated_um), 34.92, 0.0, 0.1);
    lf_assert_close(fabs(measure(&print, 60.13, spoil_shift).phase_um), 42.33, 0.0, 0.1);
    lf_assert_close(fabs(measure(&print, 60.13, spoil_resize).accumulated_um), 210.0, 0.0, 1.0);
    print.phase_mm = 0.005;
    lf_assert_close(fabs(measure(&print, 60.13, spoil_nothing).phase_um), 5.0, 0.0, 0.05);
    print.phase_mm = 0.0;
    print.lpi = 60.00;
    assert_true(fabs(measure(&print, 60.13, spoil_nothing).accumulated_um) > 100.0);
}

/* ------------------------------------------------------------------------- T5: the eye moves -- */

/* Which view, as a fraction of the way from the first to the last, an eye at eye_mm sees on the
 * whole. */
static double view_seen(const lf_sheet *sheet, const lf_row_light *light, double eye_mm)
{
    int first, last;
    double sum = 0.0;
    lf_lenses_inside(sheet, light, &first, &last);
    for (int k = first; k <= last; k++)
        sum += lf_seen_through(sheet, light, k, eye_mm, DISTANCE_MM, 0.001, false);
    return sum / (last - first + 1);
}

static void views_rise_as_the_eye_moves_right_and_then_jump_back(void **state)
{
    (void)state;
    lf_print print = a4_print(60.00, 600, 10, LF_STRIPES_NEAREST);
    const lf_sheet sheet = lf_sheet_for(60.00, DISTANCE_MM, THICKNESS_MM, INDEX, 0.0);
    const double zone = 25.4 / 60.00 * INDEX * DISTANCE_MM / THICKNESS_MM;
    double grey[10], before = -1.0;
    print.width_mm = 101.6; /* an even raster: stripes are whole pixels */
    for (int i = 0; i < 10; i++)
        grey[i] = i / 9.0;
    const light_row row = grey_row(&print, grey);
    lf_row_light light = lf_row_light_of(row.light, row.n, row.pixel_mm);
    for (int step = 0; step < 200; step++) {
        const double seen = view_seen(&sheet, &light, ((step + 0.5) / 200.0 - 0.5) * zone);
        assert_true(seen >= before - 1e-9);
        before = seen;
        lf_assert_close(seen, floor(step / 20.0) / 9.0, 0.0, 1e-4);
    }
    lf_assert_close(view_seen(&sheet, &light, 0.49 * zone), 1.0, 0.0, 1e-4);
    lf_assert_close(view_seen(&sheet, &light, 0.51 * zone), 0.0, 0.0, 1e-4);
    lf_assert_close(view_seen(&sheet, &light, -0.51 * zone), 1.0, 0.0, 1e-4);
    lf_row_light_finish(&light);
    free(row.light);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_view_of_a_60_lpi_card_is_recovered_exactly),
        cmocka_unit_test(a_spoiled_60_lpi_card_is_not_recovered),
        cmocka_unit_test(each_eye_sees_mostly_its_own_view),
        cmocka_unit_test(mistakes_show_in_the_crosstalk),
        cmocka_unit_test(the_wrong_distance_costs_what_optics_say),
        cmocka_unit_test(pitch_and_phase_are_exact_over_a4),
        cmocka_unit_test(the_meter_reads_what_is_wrong),
        cmocka_unit_test(views_rise_as_the_eye_moves_right_and_then_jump_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
