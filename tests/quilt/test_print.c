#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/print/print.h"
#include "tests/quilt/printed.h"

/* ----------------------------------------------------------------------------- what is asked -- */

static void assert_refused(const lf_print *print, const char *word)
{
    lf_error err;
    lf_assert_status(lf_print_check(print, NULL, &err), LF_E_ARG, NULL);
    assert_non_null(strstr(err.what, word));
    assert_null(strchr(err.what, '\n'));
}

static void options_out_of_range_are_refused_by_name(void **state)
{
    (void)state;
    const lf_print sound = lf_print_sound();
    lf_print p;
    lf_error err;
    lf_assert_ok(lf_print_check(&sound, NULL, &err), &err);
    p = sound, p.lpi = 0.0, assert_refused(&p, "lpi");
    p = sound, p.lpi = (double)NAN, assert_refused(&p, "lpi");
    p = sound, p.dpi = 0, assert_refused(&p, "dpi");
    p = sound, p.dpi = 1000000, assert_refused(&p, "dpi");
    p = sound, p.width_mm = -1.0, assert_refused(&p, "width");
    p = sound, p.height_mm = (double)INFINITY, assert_refused(&p, "height");
    p = sound, p.bleed_mm = -0.1, assert_refused(&p, "bleed");
    p = sound, p.phase_mm = (double)NAN, assert_refused(&p, "phase");
    p = sound, p.bits = 12, assert_refused(&p, "bits");
    p = sound, p.n_views = 0, assert_refused(&p, "views");
    p = sound, p.rolled = true, assert_refused(&p, "horizontal");
}

static void no_more_views_than_pixels_a_lens(void **state)
{
    (void)state;
    lf_print p = lf_print_sound();
    const char *warning = NULL;
    lf_error err;
    p.n_views = 10;
    lf_assert_ok(lf_print_check(&p, &warning, &err), &err);
    assert_non_null(warning);
    p.n_views = 11;
    assert_refused(&p, "views");
    /* a sheet of nominal 60 lpi measures a little more: 9.98 pixels a lens still hold ten views */
    p.lpi = 60.13;
    p.n_views = 10;
    lf_assert_ok(lf_print_check(&p, NULL, &err), &err);
    p.lpi = 64.0;
    assert_refused(&p, "views");
    p.lpi = 60.0;
    p.n_views = 8;
    lf_assert_ok(lf_print_check(&p, &warning, &err), &err);
    assert_null(warning);
}

/* ------------------------------------------------------------------------------------- shape -- */

/* But where a lens has fewer pixels than two clean views want. */
static void assert_no_default_ghosts(void)
{
    for (int i = 0; i < 2000; i++) {
        lf_print p = lf_print_sound();
        lf_error err = {0};
        const char *warning = NULL;
        p.dpi = 600;
        p.lpi = 10 + 0.11 * i;
        p.n_views = 0;
        lf_assert_ok(lf_print_choose_views(&p, 999, "export", NULL, &err), &err);
        lf_assert_ok(lf_print_check(&p, &warning, &err), &err);
        if (warning && p.n_views > 2)
            fail_msg("%g lpi: %d views, %s", p.lpi, p.n_views, warning);
        p.n_views++;
        lf_assert_ok(lf_print_check(&p, &warning, &err), &err);
        assert_non_null(warning); /* it is the most that there may be */
    }
}

static void nobody_s_views_are_those_of_a_lens_and_of_the_picture(void **state)
{
    (void)state;
    static const struct {
        double lpi;
        int asked, most, chosen; /* 0 = refused */
    } cases[] = {{60, 0, 99, 8},  {60.13, 0, 99, 7}, {60, 0, 7, 7},   {60, 0, 1, 1},
                 {250, 0, 99, 2}, {400, 0, 99, 2},   {401, 0, 5, 0},  {600, 0, 1, 1},
                 {600, 1, 5, 1},  {60, 12, 12, 12},  {60, 13, 12, 0}, {60, 3, 99, 3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_print p = lf_print_sound();
        lf_error err = {0};
        p.dpi = 600;
        p.lpi = cases[i].lpi;
        p.n_views = cases[i].asked;
        lf_assert_status(lf_print_choose_views(&p, cases[i].most, "export", "/views", &err),
                         cases[i].chosen > 0 ? LF_OK : LF_E_ARG, &err);
        assert_int_equal(p.n_views, cases[i].chosen > 0 ? cases[i].chosen : cases[i].asked);
        if (cases[i].chosen == 0)
            assert_string_equal(err.pointer, cases[i].asked > 0 ? "/views" : "");
    }
    assert_no_default_ghosts();
}

static void the_shape_holds_every_lens_that_touches_the_raster_and_no_other(void **state)
{
    (void)state;
    for (int i = 0; i < 200; i++) {
        lf_print print = lf_print_odd();
        lf_print_shape shape, rolled;
        print.phase_mm = -3.0 + 0.0301 * i;
        print.width_mm = 20.0 + 0.137 * i;
        lf_print_shape_of(&print, &shape);
        assert_int_equal(shape.raster_width, lround((print.width_mm + 2.6) * 720 / 25.4));
        const double pitch = 25.4 / print.lpi, half = 0.5 * shape.raster_width * 25.4 / 720;
        const double left = print.phase_mm + (shape.first_lens - 0.5) * pitch;
        const double right = left + shape.n_lenses * pitch;
        assert_true(left <= -half && left + pitch > -half);
        assert_true(right >= half && right - pitch < half);
        lf_assert_close(shape.window_center_x_mm, 0.5 * (left + right), 0.0, 1e-9);
        lf_assert_close(shape.window_width_mm, right - left, 0.0, 1e-9);
        lf_assert_close(shape.window_height_mm, shape.raster_height * 25.4 / 720, 0.0, 1e-12);
        assert_int_equal(shape.view_height, shape.raster_height);
        assert_int_equal(shape.view_width, shape.n_lenses);

        print.horizontal = print.rolled = true;
        const double width = print.width_mm;
        print.width_mm = print.height_mm;
        print.height_mm = width;
        lf_print_shape_of(&print, &rolled);
        assert_int_equal(rolled.view_width, shape.view_width);
        assert_int_equal(rolled.view_height, shape.view_height);
        assert_int_equal(rolled.raster_width, shape.raster_height);
        assert_true(rolled.window_center_x_mm == shape.window_center_x_mm);
    }
}

/* ----------------------------------------------------------------------------------- stripes -- */

/* The stripe at a place of the print, the long way: lens and view from millimetres. */
static double light_at(const lf_print *print, const lf_print_shape *shape, const lf_views32 *views,
                       double x_mm, int y, int c)
{
    const double pitch = 25.4 / print->lpi;
    const double lens = floor((x_mm - print->phase_mm) / pitch + 0.5);
    const double in_cell = (x_mm - print->phase_mm) / pitch + 0.5 - lens;
    const int view = print->n_views - 1 - (int)(in_cell * print->n_views);
    return (double)lf_views32_row(views, view, y)[3 * ((int)lens - shape->first_lens) + c];
}

static void every_pixel_is_the_mix_of_the_stripes_it_covers(void **state)
{
    (void)state;
    enum { SAMPLES = 400 };
    const lf_print print = lf_print_odd();
    const double pixel_mm = 25.4 / 720;
    lf_print_shape shape;
    lf_views32 card;
    lf_printed printed;

    lf_print_shape_of(&print, &shape);
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &printed);
    for (int x = 0; x < printed.width; x++) {
        const int y = x % printed.height, c = x % 3;
        double sum = 0.0;
        for (int s = 0; s < SAMPLES; s++)
            sum += light_at(&print, &shape, &card,
                            (x - 0.5 * printed.width + (s + 0.5) / SAMPLES) * pixel_mm, y, c);
        lf_assert_close(lf_printed_linear(&printed, x, y, c), sum / SAMPLES, 0.0, 2.0 / SAMPLES);
    }
    lf_printed_finish(&printed);
    lf_card_finish(&card);
}

static void a_nearest_pixel_is_the_stripe_at_its_middle_as_the_screen_shows_it(void **state)
{
    (void)state;
    lf_print print = lf_print_odd();
    lf_print_shape shape;
    lf_views32 card;
    lf_printed printed;
    lf_tone *tone = NULL;
    lf_error err;
    print.stripes = LF_STRIPES_NEAREST;
    print.bits = 8;
    lf_print_shape_of(&print, &shape);
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &printed);
    lf_assert_ok(lf_tone_create(0.0, "srgb", &tone, &err), &err);
    for (int y = 0; y < printed.height; y++) {
        for (int x = 0; x < printed.width; x++) {
            const double x_mm = (x + 0.5 - 0.5 * printed.width) * 25.4 / 720;
            float rgb[3];
            uint8_t expected[3];
            for (int c = 0; c < 3; c++)
                rgb[c] = (float)light_at(&print, &shape, &card, x_mm, y, c);
            lf_tone_map(tone, 1, rgb, expected);
            for (int c = 0; c < 3; c++)
                assert_int_equal(lf_printed_at(&printed, x, y, c), expected[c]);
        }
    }
    lf_tone_destroy(tone);
    lf_printed_finish(&printed);
    lf_card_finish(&card);
}

/* A middle on a border belongs to the stripe on its right: an odd raster of whole pixels a stripe.
 */
static void a_middle_on_a_border_belongs_to_the_right(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    lf_print_shape shape;
    lf_stripe_mix mix;
    print.n_views = 10;
    print.stripes = LF_STRIPES_NEAREST;
    print.width_mm = 25.4 * 601 / 600;
    lf_print_shape_of(&print, &shape);
    assert_int_equal(shape.raster_width, 601);
    for (int m = 0; m < 10; m++) {
        lf_stripe_mix_at(&print, &shape, 295 + m, &mix);
        assert_int_equal(mix.view[0], 9 - m);
        assert_int_equal(mix.lens[0] + shape.first_lens, 0);
    }
    lf_stripe_mix_at(&print, &shape, 294, &mix);
    assert_int_equal(mix.view[0], 0);
    assert_int_equal(mix.lens[0] + shape.first_lens, -1);
}

static void weights_of_a_pixel_sum_to_one_however_narrow_the_stripes(void **state)
{
    (void)state;
    static const double lpis[] = {5.0, 59.99, 60.0, 60.13, 63.1, 399.0, 401.0, 600.0};
    for (size_t i = 0; i < sizeof lpis / sizeof lpis[0]; i++) {
        lf_print print = lf_print_sound();
        lf_print_shape shape;
        print.lpi = lpis[i];
        print.n_views = (int)fmax(1.0, floor(600.0 / lpis[i] + 0.5));
        print.phase_mm = 0.0137;
        lf_print_shape_of(&print, &shape);
        for (int x = 0; x < shape.raster_width; x++) {
            lf_stripe_mix mix;
            lf_stripe_mix_at(&print, &shape, x, &mix);
            lf_assert_close((double)mix.weight[0] + (double)mix.weight[1] + (double)mix.weight[2],
                            1.0, 0.0, 1e-6);
            for (int slot = 0; slot < 3; slot++) {
                assert_in_range(mix.view[slot], 0, print.n_views - 1);
                assert_in_range(mix.lens[slot], 0, shape.n_lenses - 1);
                assert_true(mix.weight[slot] >= 0.0F);
            }
        }
    }
}

static void reverse_turns_the_cells_and_mirror_the_raster(void **state)
{
    (void)state;
    lf_print print = lf_print_odd();
    lf_views32 card, backwards;
    lf_printed plain, reversed, mirrored;
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &plain);
    /* the views the other way round, and the cells turned: the same print */
    backwards = card;
    float *data = lf_calloc((size_t)card.n_views * card.view_stride, sizeof *data);
    assert_non_null(data);
    for (int view = 0; view < card.n_views; view++)
        memcpy(data + (size_t)view * card.view_stride,
               lf_views32_row(&card, card.n_views - 1 - view, 0), card.view_stride * sizeof *data);
    backwards.data = data;
    print.reverse = true;
    lf_printed_make(&print, &backwards, 0, &reversed);
    lf_printed_assert_same(&plain, &reversed);
    print.reverse = false;
    print.mirror = true;
    lf_printed_make(&print, &card, 0, &mirrored);
    for (int y = 0; y < plain.height; y++)
        for (int x = 0; x < plain.width; x++)
            for (int c = 0; c < 3; c++)
                assert_int_equal(lf_printed_at(&mirrored, x, y, c),
                                 lf_printed_at(&plain, plain.width - 1 - x, y, c));
    lf_printed_finish(&plain);
    lf_printed_finish(&reversed);
    lf_printed_finish(&mirrored);
    lf_card_finish(&backwards);
    lf_card_finish(&card);
}

/* -------------------------------------------------------------------------------- horizontal -- */

static float turned_value(const void *context, int view, int row, int column, int c)
{
    (void)context;
    return lf_card_speckle(NULL, view, column, row, c);
}

static float rolled_value(const void *context, int view, int row, int column, int c)
{
    const int *n_along = context;
    return lf_card_speckle(NULL, view, *n_along - 1 - row, column, c);
}

static void horizontal_lenses_are_vertical_ones_transposed(void **state)
{
    (void)state;
    for (int stripes = 0; stripes < 2; stripes++) {
        lf_print vertical = lf_print_odd(), horizontal = lf_print_odd();
        lf_print_shape shape;
        lf_views32 card, turned, rolled;
        lf_printed a, b, c;
        vertical.stripes = horizontal.stripes = (lf_stripes)stripes;
        horizontal.width_mm = vertical.height_mm;
        horizontal.height_mm = vertical.width_mm;
        horizontal.horizontal = true;
        lf_card_make(&vertical, lf_card_speckle, NULL, &card);
        lf_printed_make(&vertical, &card, 0, &a);
        lf_card_make(&horizontal, turned_value, NULL, &turned);
        lf_printed_make(&horizontal, &turned, 0, &b);
        horizontal.rolled = true;
        lf_print_shape_of(&horizontal, &shape);
        lf_card_make(&horizontal, rolled_value, &shape.n_along, &rolled);
        lf_printed_make(&horizontal, &rolled, 0, &c);
        assert_int_equal(a.width, b.height);
        for (int y = 0; y < a.height; y++)
            for (int x = 0; x < a.width; x++)
                for (int ch = 0; ch < 3; ch++)
                    assert_int_equal(lf_printed_at(&a, x, y, ch), lf_printed_at(&b, y, x, ch));
        lf_printed_assert_same(&b, &c);
        lf_printed_finish(&a);
        lf_printed_finish(&b);
        lf_printed_finish(&c);
        lf_card_finish(&card);
        lf_card_finish(&turned);
        lf_card_finish(&rolled);
    }
}

/* ------------------------------------------------------------------------------------- bleed -- */

/* A value that depends on the lens's own number and on the row from the middle, whatever the bleed.
 */
static float place_value(const void *context, int view, int row, int column, int c)
{
    const lf_print_shape *shape = context;
    return lf_card_speckle(NULL, view, 1000 + row - shape->n_along / 2,
                           1000 + column + shape->first_lens, c);
}

static void bleed_continues_the_stripes(void **state)
{
    (void)state;
    for (int stripes = 0; stripes < 2; stripes++) {
        lf_print print = lf_print_sound();
        lf_print_shape shape;
        lf_views32 card;
        lf_printed without, with;
        const int bleed = 60;
        print.lpi = 60.13;
        print.stripes = (lf_stripes)stripes;
        lf_print_shape_of(&print, &shape);
        lf_card_make(&print, place_value, &shape, &card);
        lf_printed_make(&print, &card, 0, &without);
        lf_card_finish(&card);
        print.bleed_mm = 2.54;
        lf_print_shape_of(&print, &shape);
        lf_card_make(&print, place_value, &shape, &card);
        lf_printed_make(&print, &card, 0, &with);
        lf_card_finish(&card);
        assert_int_equal(with.width, without.width + 2 * bleed);
        assert_int_equal(with.height, without.height + 2 * bleed);
        for (int y = 0; y < without.height; y++)
            assert_memory_equal(without.value + (size_t)y * (size_t)without.width * 3,
                                with.value +
                                    ((size_t)(y + bleed) * (size_t)with.width + (size_t)bleed) * 3,
                                (size_t)without.width * 3 * sizeof *with.value);
        const json_t *box = json_object_get(json_object_get(with.manifest, "size"), "trim_box_px");
        lf_assert_close(json_number_value(json_array_get(box, 0)), 60.0, 0.0, 1e-9);
        lf_assert_close(json_number_value(json_array_get(box, 2)), 1260.0, 0.0, 1e-9);
        lf_printed_finish(&without);
        lf_printed_finish(&with);
    }
}

/* -------------------------------------------------------------------------------- resampling -- */

static void shrinking_is_an_area_average_and_growing_is_linear(void **state)
{
    (void)state;
    lf_axis_filter filter;
    /* 10 samples onto 4 of 2.5 each: sample 0 takes 0, 1 and half of 2 */
    lf_assert_ok(lf_axis_filter_init(&filter, 10, 4, 1.25, 2.5, 2.5), NULL);
    assert_int_equal(filter.first[0], 0);
    assert_int_equal(filter.n_taps[0], 3);
    lf_assert_close((double)filter.weight[0], 0.4, 0.0, 1e-6);
    lf_assert_close((double)filter.weight[2], 0.2, 0.0, 1e-6);
    assert_int_equal(filter.first[3], 7);
    for (int i = 0; i < 4; i++) {
        double sum = 0.0;
        for (int t = 0; t < filter.n_taps[i]; t++)
            sum += (double)filter.weight[i * filter.max_taps + t];
        lf_assert_close(sum, 1.0, 0.0, 1e-6);
    }
    lf_axis_filter_finish(&filter);

    /* 4 samples onto 8: middles at 0.25, 0.75, 1.25 ... ; the edge sample is held */
    lf_assert_ok(lf_axis_filter_init(&filter, 4, 8, 0.25, 0.5, 0.5), NULL);
    assert_int_equal(filter.n_taps[0], 1);
    assert_int_equal(filter.first[1], 0);
    lf_assert_close((double)filter.weight[filter.max_taps + 1], 0.25, 0.0, 1e-6);
    assert_int_equal(filter.first[7], 3);
    assert_int_equal(filter.n_taps[7], 1);
    lf_axis_filter_finish(&filter);

    /* far outside the source */
    lf_assert_ok(lf_axis_filter_init(&filter, 5, 2, -100.0, 300.0, 3.0), NULL);
    assert_int_equal(filter.first[0], 0);
    assert_int_equal(filter.first[1], 4);
    lf_axis_filter_finish(&filter);
}

/* Each view a ramp across, of its own height: where a picture of any size must put its light. */
static float ramp_value(const void *context, int view, int row, int column, int c)
{
    const int *size = context;
    (void)view;
    return c == 0   ? ((float)column + 0.5F) / (float)size[0]
           : c == 1 ? ((float)row + 0.5F) / (float)size[1]
                    : 0.25F;
}

static void pictures_of_any_size_cover_the_raster(void **state)
{
    (void)state;
    static const int sizes[][2] = {{40, 7}, {333, 200}, {2000, 31}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        lf_print print = lf_print_odd();
        const int width = sizes[s][0], height = sizes[s][1];
        float *data = lf_calloc((size_t)width * (size_t)height, 3 * sizeof *data);
        lf_printed printed;
        assert_non_null(data);
        for (int i = 0; i < 3 * width * height; i++)
            data[i] = ramp_value(sizes[s], 0, i / 3 / width, i / 3 % width, i % 3);
        const lf_views32 views = {1, width, height, 0, 3 * (size_t)width, data, NULL, NULL, NULL};
        lf_printed_make(&print, &views, 0, &printed);
        const double tolerance = 1.0 / width + 1.5 * (25.4 / print.lpi) / print.width_mm;
        for (int x = 0; x < printed.width; x++) {
            lf_assert_close(lf_printed_linear(&printed, x, 5, 0), (x + 0.5) / printed.width, 0.0,
                            tolerance);
            lf_assert_close(lf_printed_linear(&printed, x, 5, 2), 0.25, 0.0, 1e-4);
        }
        for (int y = 0; y < printed.height; y++)
            lf_assert_close(lf_printed_linear(&printed, 9, y, 1), (y + 0.5) / printed.height, 0.0,
                            1.0 / height);
        const json_t *source = json_object_get(printed.manifest, "source");
        assert_true(json_is_true(json_object_get(source, "resampled")));
        lf_printed_finish(&printed);
        lf_free(data);
    }
}

static void a_picture_keeps_its_aspect_and_is_cut(void **state)
{
    (void)state;
    lf_print print = lf_print_odd(); /* 34.3 x 4.5 mm with its bleed */
    const int size[2] = {100, 100};
    float *data = lf_calloc(10000, 3 * sizeof *data);
    lf_printed printed;
    assert_non_null(data);
    for (int i = 0; i < 30000; i++)
        data[i] = ramp_value(size, 0, i / 300, i / 3 % 100, i % 3);
    const lf_views32 views = {1, 100, 100, 0, 300, data, NULL, NULL, NULL};
    print.view_aspect = 1.0;
    print.photo.mode = LF_PHOTO_FILL;
    lf_printed_make(&print, &views, 0, &printed);
    const double visible = (double)printed.height / printed.width;
    lf_assert_close(lf_printed_linear(&printed, 3, 0, 1), 0.5 - 0.5 * visible, 0.0, 0.006);
    lf_assert_close(lf_printed_linear(&printed, 3, printed.height - 1, 1), 0.5 + 0.5 * visible, 0.0,
                    0.006);
    lf_printed_finish(&printed);
    lf_free(data);
}

/* Codes print as the light that they are, whichever way the lenses run and at any size. */
static void codes_print_as_their_light(void **state)
{
    enum { VIEWS = 5, WIDTH = 61, HEIGHT = 23, N = VIEWS * WIDTH * HEIGHT * 3 };
    (void)state;
    uint8_t *codes = lf_calloc(N, 1);
    float *data = lf_calloc(N, sizeof *data), light[256];
    assert_true(codes && data);
    lf_srgb_light(light);
    for (int i = 0; i < N; i++) {
        codes[i] = (uint8_t)(i * 7 + i / 61 * 29);
        data[i] = (float)lf_srgb_to_linear(codes[i] / 255.0);
    }
    const size_t row = (size_t)3 * WIDTH, view = row * HEIGHT;
    const lf_views32 floats = {VIEWS, WIDTH, HEIGHT, view, row, data, NULL, NULL, NULL},
                     coded = {VIEWS, WIDTH, HEIGHT, view, row, NULL, NULL, codes, light};
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = lf_print_odd();
        lf_printed a, b;
        print.horizontal = horizontal;
        lf_printed_make(&print, &floats, 0, &a);
        lf_printed_make(&print, &coded, 0, &b);
        lf_printed_assert_same(&a, &b);
        lf_printed_finish(&a);
        lf_printed_finish(&b);
    }
    lf_free(codes);
    lf_free(data);
}

static void stripes_take_views_evenly_from_more(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    float data[3 * 45];
    lf_printed printed;
    for (int i = 0; i < 3 * 45; i++)
        data[i] = (float)(i / 3) / 44.0F;
    const lf_views32 views = {45, 1, 1, 3, 3, data, NULL, NULL, NULL};
    print.n_views = 10;
    print.bits = 16;
    print.stripes = LF_STRIPES_NEAREST;
    lf_printed_make(&print, &views, 0, &printed);
    static const int shown[10] = {2, 6, 11, 15, 20, 24, 29, 33, 38, 42};
    const json_t *said = json_object_get(json_object_get(printed.manifest, "source"), "shown");
    for (int m = 0; m < 10; m++) {
        /* cell of the middle lens: pixels 595..604 of 1200 */
        lf_assert_close(lf_printed_linear(&printed, 595 + m, 0, 0), shown[9 - m] / 44.0, 0.0, 1e-4);
        assert_int_equal(json_integer_value(json_array_get(said, (size_t)m)), shown[m]);
    }
    lf_printed_finish(&printed);
}

/* sRGB's curve in double precision, over the whole range and beside the end of its straight part:
 * the nearest code, but where floats leave two as near (within 0.02 of half way). */
static void codes_are_the_nearest_of_8_and_16_bits(void **state)
{
    (void)state;
    enum { PIXELS = 1 << 14, N = 3 * PIXELS };
    static float light[N];
    static uint8_t code8[N];
    static uint16_t code16[N];
    lf_print print = lf_print_sound();
    lf_print_colour *colour;
    lf_error err = {0};
    for (int i = 0; i < N; i++)
        light[i] = i % 4 ? ((float)i + 0.5F) / N : 0.0031308F * (2.0F * (float)i / N);
    for (int bits = 8; bits <= 16; bits += 8) {
        print.bits = bits;
        lf_assert_ok(lf_print_colour_create(&print, &colour, &err), &err);
        lf_print_colour_encode(colour, PIXELS, light, bits == 8 ? (void *)code8 : (void *)code16);
        lf_print_colour_destroy(colour);
        for (int i = 0; i < N; i++) {
            const double v = (double)light[i],
                         exact = (bits == 8 ? 255.0 : 65535.0) *
                                 (v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055);
            lf_assert_close(bits == 8 ? code8[i] : code16[i], exact, 0.0, 0.52);
        }
    }
}

static void samples_that_are_no_numbers_count_as_black(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    static const float odd[6] = {NAN, INFINITY, -1.0F, 0.5F, 2.0F, 1e30F};
    const lf_views32 views = {2, 1, 1, 3, 3, odd, NULL, NULL, NULL};
    lf_printed printed;
    print.n_views = 2;
    print.stripes = LF_STRIPES_NEAREST;
    lf_printed_make(&print, &views, 0, &printed);
    for (int c = 0; c < 3; c++)
        assert_int_equal(lf_printed_at(&printed, 602, 0, c), 0);
    assert_int_equal(lf_printed_at(&printed, 598, 0, 0), 188);
    assert_int_equal(lf_printed_at(&printed, 598, 0, 1), 255);
    assert_int_equal(lf_printed_at(&printed, 598, 0, 2), 255);
    lf_printed_finish(&printed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_out_of_range_are_refused_by_name),
        cmocka_unit_test(no_more_views_than_pixels_a_lens),
        cmocka_unit_test(nobody_s_views_are_those_of_a_lens_and_of_the_picture),
        cmocka_unit_test(the_shape_holds_every_lens_that_touches_the_raster_and_no_other),
        cmocka_unit_test(every_pixel_is_the_mix_of_the_stripes_it_covers),
        cmocka_unit_test(a_nearest_pixel_is_the_stripe_at_its_middle_as_the_screen_shows_it),
        cmocka_unit_test(a_middle_on_a_border_belongs_to_the_right),
        cmocka_unit_test(weights_of_a_pixel_sum_to_one_however_narrow_the_stripes),
        cmocka_unit_test(reverse_turns_the_cells_and_mirror_the_raster),
        cmocka_unit_test(horizontal_lenses_are_vertical_ones_transposed),
        cmocka_unit_test(bleed_continues_the_stripes),
        cmocka_unit_test(shrinking_is_an_area_average_and_growing_is_linear),
        cmocka_unit_test(pictures_of_any_size_cover_the_raster),
        cmocka_unit_test(a_picture_keeps_its_aspect_and_is_cut),
        cmocka_unit_test(codes_print_as_their_light),
        cmocka_unit_test(stripes_take_views_evenly_from_more),
        cmocka_unit_test(codes_are_the_nearest_of_8_and_16_bits),
        cmocka_unit_test(samples_that_are_no_numbers_count_as_black),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
