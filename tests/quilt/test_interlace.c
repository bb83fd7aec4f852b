#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/quilt.h"

static lf_calibration panel(double pitch, double slope, double center, double dpi, int width,
                            int height)
{
    return (lf_calibration){.config_version = "3.0",
                            .pitch = pitch,
                            .slope = slope,
                            .center = center,
                            .dpi = dpi,
                            .screen_width_px = width,
                            .screen_height_px = height,
                            .inv_view = 1};
}

/* looking-glass.md section 2: values read off real devices, and templates. */
static lf_calibration panel_2k(void)
{
    return panel(47.56401443481445, -5.480000019073486, 0.374184787273407, 338, 2560, 1600);
}

static lf_calibration panel_portrait(void)
{
    return panel(52.594383239746094, -7.21152925491333, 0.40277382731437683, 324, 1536, 2048);
}

static lf_calibration panel_go(void)
{
    return panel(80.74475016919882, -6.6587766801719095, 0.47708486403293315, 491, 1440, 2560);
}

static lf_calibration panel_16p(void)
{
    lf_calibration c = panel(44.72, -7.45, 0, 283, 2160, 3840);
    const float cells[2][3][2] = {{{-0.25f, -0.31f}, {-0.25f, 0.28f}, {0.25f, 0}},
                                  {{0.25f, -0.31f}, {0.25f, 0.28f}, {-0.25f, 0}}};
    memcpy(c.cells, cells, sizeof cells);
    c.n_cells = 2;
    c.cell_pattern_mode = 4;
    return c;
}

static lf_calibration panel_16l(void)
{
    lf_calibration c = panel(44.72, -6.9, 0.5, 283, 3840, 2160);
    const float cells[2][3][2] = {{{-0.31f, 0.25f}, {0.28f, 0.25f}, {0, -0.25f}},
                                  {{-0.31f, -0.25f}, {0.28f, -0.25f}, {0, 0.25f}}};
    memcpy(c.cells, cells, sizeof cells);
    c.n_cells = 2;
    c.cell_pattern_mode = 2;
    return c;
}

static int view_of(const lf_calibration *c, int n, int x, int y, int channel)
{
    return lf_view_of_subpixel(c, n, LF_INVERT_AUTO, x, y, channel, NULL);
}

static void known_subpixels_show_the_known_views(void **state)
{
    (void)state;
    const struct {
        lf_calibration c;
        int n, view[3][3];
    } panels[] = {
        {panel_2k(), 45, {{14, 12, 10}, {23, 21, 19}, {20, 18, 16}}},
        {panel_portrait(), 48, {{16, 13, 10}, {34, 31, 29}, {7, 5, 2}}},
        {panel_go(), 66, {{26, 23, 19}, {1, 64, 60}, {58, 54, 51}}},
        {panel_16p(), 66, {{63, 64, 58}, {33, 34, 28}, {30, 30, 35}}},
        {panel_16l(), 49, {{23, 19, 20}, {18, 14, 15}, {1, 46, 0}}},
    };
    for (size_t i = 0; i < sizeof panels / sizeof panels[0]; i++) {
        const lf_calibration *c = &panels[i].c;
        const int at[3][2] = {
            {0, 0}, {100, 200}, {c->screen_width_px - 1, c->screen_height_px - 1}};
        for (int p = 0; p < 3; p++)
            for (int channel = 0; channel < 3; channel++)
                if (view_of(c, panels[i].n, at[p][0], at[p][1], channel) !=
                    panels[i].view[p][channel])
                    fail_msg("panel %zu, point %d, channel %d: view %d, expected %d", i, p, channel,
                             view_of(c, panels[i].n, at[p][0], at[p][1], channel),
                             panels[i].view[p][channel]);
    }
    double z;
    const double known[2][3] = {{14.2919, 12.2154, 10.1388}, {16.0093, 13.4367, 10.8640}};
    for (int channel = 0; channel < 3; channel++) {
        lf_view_of_subpixel(&panels[0].c, 45, LF_INVERT_AUTO, 0, 0, channel, &z);
        lf_assert_close(z, known[0][channel], 0, 5e-5);
        lf_view_of_subpixel(&panels[1].c, 48, LF_INVERT_AUTO, 0, 0, channel, &z);
        lf_assert_close(z, known[1][channel], 0, 5e-5);
    }
}

/* z N in extended precision, written from the formulas again and in another order. */
static long double place(const lf_calibration *c, int n, bool from_right, int x, int y, int channel)
{
    long double w = c->screen_width_px, s = c->slope, sign = c->flip_image_x ? -1 : 1;
    long double periods = c->pitch * w / c->dpi * fabsl(s) / sqrtl(1 + s * s);
    static const int patterns[5][4][2] = {/* [mode][y % 4][x % 2] */
                                          {{0, 0}, {0, 0}, {0, 0}, {0, 0}},
                                          {{0, 1}, {1, 0}, {0, 1}, {1, 0}},
                                          {{0, 1}, {0, 1}, {0, 1}, {0, 1}},
                                          {{0, 2}, {1, 3}, {2, 0}, {3, 1}},
                                          {{0, 0}, {1, 1}, {0, 0}, {1, 1}}};
    long double px = x + 0.5L, py = y + 0.5L;
    if (c->n_cells) {
        int cell = patterns[c->cell_pattern_mode][y % 4][x % 2] % c->n_cells;
        px += (long double)c->cells[cell][channel][0];
        py += (long double)c->cells[cell][channel][1];
    } else {
        px += sign * (c->flip_subp ? 2 - channel : channel) / 3;
    }
    long double phase = periods * (px / w + sign * py / (w * s)) - c->center;
    long double f = phase - floorl(phase);
    return (from_right ? 1 - f : f) * n;
}

static lf_calibration with_cells(lf_calibration c, int mode, int n_cells)
{
    for (int cell = 0; cell < n_cells; cell++)
        for (int channel = 0; channel < 3; channel++)
            for (int axis = 0; axis < 2; axis++)
                c.cells[cell][channel][axis] = (float)(0.07 * cell - 0.3 * channel + 0.2 * axis);
    c.cell_pattern_mode = mode;
    c.n_cells = n_cells;
    return c;
}

/* Panels of real pitch and every switch, small enough to look at each subpixel. */
#define N_VARIANTS 64
static lf_calibration variant(int i)
{
    lf_calibration c = i % 2 ? panel_portrait() : panel_2k();
    c.screen_width_px = 150 + i;
    c.screen_height_px = 97;
    if (i & 2)
        c.slope = -c.slope;
    c.flip_image_x = i >> 2 & 1;
    c.flip_subp = i >> 3 & 1;
    static const int n_cells[4] = {0, 1, 2, 5};
    return with_cells(c, i * 7 % 5, n_cells[i >> 4]);
}

static void the_formulas_agree_with_themselves_in_higher_precision(void **state)
{
    (void)state;
    int64_t n_close = 0;
    for (int i = 0; i < N_VARIANTS; i++) {
        lf_calibration c = variant(i);
        for (int y = 0; y < c.screen_height_px; y++) {
            for (int k = 0; k < 3 * c.screen_width_px; k++) {
                bool from_right = i % 3 != 0;
                long double z = place(&c, 45, from_right, k / 3, y, k % 3);
                int view = lf_view_of_subpixel(&c, 45, from_right ? LF_INVERT_YES : LF_INVERT_NO,
                                               k / 3, y, k % 3, NULL);
                bool close = fabsl(z - roundl(z)) < 1e-9L;
                n_close += close;
                if (!close && view != (int)z)
                    fail_msg("variant %d (%d, %d) channel %d: view %d, expected %Lf", i, k / 3, y,
                             k % 3, view, z);
            }
        }
    }
    assert_true(n_close < 10);
}

static void inversion_follows_the_rule_unless_it_is_forced(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        lf_calibration c = panel_portrait();
        c.inv_view = i & 1;
        if (i & 2)
            strcpy(c.config_version, "1.0");
        if (i & 4)
            strcpy(c.config_version, "");
        bool from_right = !(i == 2);
        int same = 0;
        for (int x = 0; x < 500; x++) {
            int yes = lf_view_of_subpixel(&c, 48, LF_INVERT_YES, x, 3, 0, NULL);
            int no = lf_view_of_subpixel(&c, 48, LF_INVERT_NO, x, 3, 0, NULL);
            assert_int_equal(view_of(&c, 48, x, 3, 0), from_right ? yes : no);
            assert_in_range(yes + no, 46, 48); /* mirrored views */
            same += yes == no;
        }
        assert_true(same < 50);
    }
}

/* -------------------------------------------------------------------------------- interlacer -- */

/* n_views stacked views of width x height, each a constant: its number's low byte (or high one). */
static uint8_t *constant_views(int n_views, int width, int height, int shift, lf_views8 *out)
{
    size_t pixels = (size_t)width * (size_t)height;
    uint8_t *data = lf_calloc((size_t)n_views, pixels * 3);
    assert_non_null(data);
    for (int k = 0; k < n_views; k++)
        memset(data + (size_t)k * pixels * 3, k >> shift & 255, pixels * 3);
    *out = (lf_views8){n_views, width, height, pixels * 3, (size_t)width * 3, data};
    return data;
}

static lf_image8 interlaced(const lf_calibration *c, const lf_views8 *views, double aspect,
                            lf_filter filter, lf_invert invert, lf_pool *pool)
{
    lf_interlacer *it;
    lf_error err;
    lf_image8 out = {0};
    assert_int_equal(lf_image8_init(&out, c->screen_width_px, c->screen_height_px, 3), LF_OK);
    memset(out.data, 0xee, out.stride * (size_t)out.height);
    lf_assert_ok(lf_interlacer_create(c, views->n_views, views->width, views->height, aspect,
                                      filter, invert, &it, &err),
                 &err);
    uint64_t before = lf_alloc_count();
    lf_interlace(it, views, &out, pool);
    assert_int_equal(lf_alloc_count(), before);
    lf_interlacer_destroy(it);
    return out;
}

/* Number of subpixels whose interlaced constant is not the formula's view. */
static int64_t mismatches(const lf_calibration *c, int n_views, lf_invert invert, lf_pool *pool)
{
    int64_t n = 0;
    for (int shift = 0; shift < 16; shift += 8) {
        lf_views8 views;
        uint8_t *data = constant_views(n_views, 2, 3, shift, &views);
        lf_image8 out = interlaced(c, &views, 0, LF_FILTER_NEAREST, invert, pool);
        for (int y = 0; y < out.height; y++)
            for (int i = 0; i < 3 * out.width; i++) {
                int view =
                    lf_view_of_subpixel(c, n_views, invert, i / 3, out.height - 1 - y, i % 3, NULL);
                n += out.data[(size_t)y * out.stride + (size_t)i] != (view >> shift & 255);
            }
        lf_image8_finish(&out);
        lf_free(data);
        if (n_views <= 256)
            break;
    }
    return n;
}

static void the_interlacer_matches_the_formulas_in_every_mode(void **state)
{
    (void)state;
    static const int n_views[] = {1, 2, 45, 48, 66, 256, 257, 1000};
    for (int i = 0; i < N_VARIANTS; i++) {
        lf_calibration c = variant(i);
        assert_int_equal(mismatches(&c, n_views[i % 8], (lf_invert)(i % 3), NULL), 0);
    }
}

static void the_interlacer_matches_the_formulas_on_whole_panels(void **state)
{
    (void)state;
    lf_pool *pool;
    assert_int_equal(lf_pool_create(2, &pool), LF_OK);
    lf_calibration portrait = panel_portrait(), landscape = panel_16l();
    assert_int_equal(mismatches(&portrait, 48, LF_INVERT_AUTO, pool), 0);
    assert_int_equal(mismatches(&landscape, 49, LF_INVERT_AUTO, pool), 0);
    lf_pool_destroy(pool);
}

/* The comparison sees what could go wrong. */
static void swapped_orders_are_noticed(void **state)
{
    (void)state;
    lf_calibration c = panel_portrait(), other = c;
    c.screen_height_px = other.screen_height_px = 300;
    other.flip_subp = 1;
    lf_views8 views;
    uint8_t *data = constant_views(48, 2, 2, 0, &views);
    lf_image8 right = interlaced(&c, &views, 0, LF_FILTER_NEAREST, LF_INVERT_AUTO, NULL);
    lf_image8 bgr = interlaced(&other, &views, 0, LF_FILTER_NEAREST, LF_INVERT_AUTO, NULL);
    lf_image8 inverted = interlaced(&c, &views, 0, LF_FILTER_NEAREST, LF_INVERT_NO, NULL);
    int64_t from_top = 0, swapped = 0, mirrored = 0, n = (int64_t)right.stride * right.height;
    for (int64_t i = 0; i < n; i++) {
        int x = (int)(i % (int64_t)right.stride / 3), y = (int)(i / (int64_t)right.stride);
        from_top += right.data[i] != view_of(&c, 48, x, y, (int)(i % 3));
        swapped += right.data[i] != bgr.data[i];
        mirrored += right.data[i] != inverted.data[i];
    }
    assert_true(from_top > n / 2);
    assert_true(mirrored > n / 2);
    assert_true(swapped > n / 2);
    /* and that only red and blue changed places, green stays */
    for (int64_t i = 0; i < n; i += 3) {
        assert_int_equal(right.data[i + 1], bgr.data[i + 1]);
        assert_int_equal(right.data[i], bgr.data[i + 2]);
        assert_int_equal(right.data[i + 2], bgr.data[i]);
    }
    lf_image8_finish(&right);
    lf_image8_finish(&bgr);
    lf_image8_finish(&inverted);
    lf_free(data);
}

/* Noise, as stacked views or in the film's order. */
static uint8_t *noise_views(int n_views, int width, int height, bool film, lf_views8 *out)
{
    size_t row = (size_t)width * 3, bytes = (size_t)n_views * (size_t)height * row;
    uint8_t *data = lf_calloc(bytes, 1);
    assert_non_null(data);
    *out = (lf_views8){n_views,
                       width,
                       height,
                       film ? row : row * (size_t)height,
                       film ? row * (size_t)n_views : row,
                       data};
    for (int k = 0; k < n_views; k++)
        for (int y = 0; y < height; y++)
            for (size_t i = 0; i < row; i++)
                data[(size_t)k * out->view_stride + (size_t)y * out->row_stride + i] =
                    (uint8_t)((((size_t)k * 7919 + (size_t)y * 104729 + i) * 2654435761u) >> 13);
    return data;
}

/* Sample of n that panel pixel i of `size` shows when the views take `share` of it; -1 = none. In
 * rationals of doubles small enough to be exact where share is 1. */
static int nearest(int i, int size, int n, double share)
{
    if (share == 1)
        return (int)((int64_t)(2 * i + 1) * n / (2 * size));
    double u = ((i + 0.5) / size - 0.5) / share + 0.5;
    return u * n < 0 || u * n >= n ? -1 : (int)(u * n);
}

static void nearest_copies_the_nearest_sample_unchanged(void **state)
{
    (void)state;
    static const int sizes[][2] = {{150, 97}, {420, 560}, {31, 17}, {1, 1}, {300, 50}};
    static const double aspects[] = {0, 150 / 97.0, 1.0, 2.5, 0.5};
    for (int i = 0; i < 25; i++) {
        lf_calibration c = variant(0);
        lf_views8 views;
        uint8_t *data = noise_views(45, sizes[i % 5][0], sizes[i % 5][1], i % 2, &views);
        double aspect = aspects[i / 5], ratio = aspect > 0 ? aspect / (150 / 97.0) : 1;
        lf_image8 out = interlaced(&c, &views, aspect, LF_FILTER_NEAREST, LF_INVERT_AUTO, NULL);
        for (int y = 0; y < 97; y++) {
            for (int k = 0; k < 450; k++) {
                int column = nearest(k / 3, 150, views.width, ratio < 1 ? ratio : 1);
                int row = nearest(y, 97, views.height, ratio > 1 ? 1 / ratio : 1), expected = 0;
                if (row >= 0 && column >= 0)
                    expected = lf_views8_row(&views, view_of(&c, 45, k / 3, 96 - y, k % 3),
                                             row)[column * 3 + k % 3];
                assert_int_equal(out.data[(size_t)y * out.stride + (size_t)k], expected);
            }
        }
        lf_image8_finish(&out);
        lf_free(data);
    }
}

static void views_are_fitted_into_the_panel_and_centred(void **state)
{
    (void)state;
    lf_calibration c = panel_portrait();
    lf_views8 views;
    uint8_t *data = constant_views(3, 4, 4, 0, &views);
    memset(data, 200, 3 * 4 * 4 * 3);
    const double aspects[] = {0.75, 0.7501, 1.5, 0.375};
    for (int i = 0; i < 4; i++) {
        lf_image8 out = interlaced(&c, &views, aspects[i], LF_FILTER_NEAREST, LF_INVERT_AUTO, NULL);
        int x0 = i == 3 ? 384 : 0, y0 = i == 2 ? 512 : 0;
        for (int y = 0; y < 2048; y += 1)
            for (int x = 0; x < 1536; x += 16 - (y == y0)) {
                bool inside = x >= x0 && x < 1536 - x0 && y >= y0 && y < 2048 - y0;
                assert_int_equal(out.data[(size_t)y * out.stride + (size_t)x * 3],
                                 inside ? 200 : 0);
            }
        lf_image8_finish(&out);
    }
    lf_free(data);
}

static void order_in_memory_rows_and_threads_make_no_difference(void **state)
{
    (void)state;
    lf_calibration c = variant(5);
    lf_pool *pool;
    assert_int_equal(lf_pool_create(3, &pool), LF_OK);
    for (int filter = 0; filter < 2; filter++) {
        lf_views8 stack, film;
        uint8_t *a = noise_views(12, 40, 30, false, &stack),
                *b = noise_views(12, 40, 30, true, &film);
        lf_image8 one = interlaced(&c, &stack, 1, (lf_filter)filter, LF_INVERT_AUTO, NULL);
        lf_image8 two = interlaced(&c, &film, 1, (lf_filter)filter, LF_INVERT_AUTO, pool);
        assert_memory_equal(one.data, two.data, one.stride * (size_t)one.height);
        lf_interlacer *it;
        lf_error err;
        lf_assert_ok(
            lf_interlacer_create(&c, 12, 40, 30, 1, (lf_filter)filter, LF_INVERT_AUTO, &it, &err),
            &err);
        memset(two.data, 0x55, two.stride * (size_t)two.height);
        lf_interlace_rows(it, &stack, &two, 20, 33);
        for (int y = 0; y < two.height; y++)
            for (size_t i = 0; i < two.stride; i++)
                assert_int_equal(two.data[(size_t)y * two.stride + i],
                                 y >= 20 && y < 33 ? one.data[(size_t)y * one.stride + i] : 0x55);
        lf_interlacer_destroy(it);
        lf_image8_finish(&one);
        lf_image8_finish(&two);
        lf_free(a);
        lf_free(b);
    }
    lf_pool_destroy(pool);
}

/* ------------------------------------------------------------------------------------ linear -- */

/* Bilinear sample with clamped borders, of a place in samples. */
static double sampled(const lf_views8 *v, int view, double x, double y, int channel)
{
    double sum = 0;
    for (int dy = 0; dy < 2; dy++)
        for (int dx = 0; dx < 2; dx++) {
            int i = (int)floor(x) + dx, j = (int)floor(y) + dy;
            double weight = (1 - fabs(x - i)) * (1 - fabs(y - j));
            i = i < 0 ? 0 : i >= v->width ? v->width - 1 : i;
            j = j < 0 ? 0 : j >= v->height ? v->height - 1 : j;
            sum += weight * lf_views8_row(v, view, j)[i * 3 + channel];
        }
    return sum;
}

static void linear_mixes_views_and_samples(void **state)
{
    (void)state;
    int n_inexact = 0;
    for (int i = 0; i < 12; i++) {
        lf_calibration c = variant(i * 5);
        lf_views8 views;
        int n_views = i == 0 ? 1 : 7 * i;
        uint8_t *data = noise_views(n_views, 33 + 20 * i, 20 + i * i, i % 2, &views);
        lf_image8 out = interlaced(&c, &views, 0, LF_FILTER_LINEAR, (lf_invert)(i % 3), NULL);
        for (int y = 0; y < out.height; y++) {
            for (int k = 0; k < 3 * out.width; k++) {
                double z;
                int view = lf_view_of_subpixel(&c, n_views, (lf_invert)(i % 3), k / 3,
                                               out.height - 1 - y, k % 3, &z);
                int after = view + 1 < n_views ? view + 1 : n_views - 1;
                double sx = (k / 3 + 0.5) * views.width / out.width - 0.5,
                       sy = (y + 0.5) * views.height / out.height - 0.5;
                double mixed = sampled(&views, view, sx, sy, k % 3) * (1 - (z - view)) +
                               sampled(&views, after, sx, sy, k % 3) * (z - view);
                int got = out.data[(size_t)y * out.stride + (size_t)k];
                if (fabs(mixed + 0.5 - round(mixed + 0.5)) < 1e-6) /* on the edge of two values */
                    n_inexact++;
                else
                    assert_int_equal(got, (int)floor(mixed + 0.5));
            }
        }
        lf_image8_finish(&out);
        lf_free(data);
    }
    assert_true(n_inexact < 2000);
}

static void what_cannot_be_interlaced_is_refused(void **state)
{
    (void)state;
    lf_calibration good = panel_portrait(), bad = good;
    lf_interlacer *it = NULL;
    lf_error err;
    lf_assert_status(
        lf_interlacer_create(&good, 0, 4, 4, 1, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    lf_assert_status(
        lf_interlacer_create(&good, 65536, 4, 4, 1, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    lf_assert_status(
        lf_interlacer_create(&good, 45, 0, 4, 1, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    lf_assert_status(
        lf_interlacer_create(&good, 45, 4, 4, NAN, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    lf_assert_status(
        lf_interlacer_create(&good, 45, 4, 4, -1, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    bad.slope = 0;
    lf_assert_status(
        lf_interlacer_create(&bad, 45, 4, 4, 1, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    bad = good;
    bad.screen_width_px = 0;
    lf_assert_status(
        lf_interlacer_create(&bad, 45, 4, 4, 1, LF_FILTER_NEAREST, LF_INVERT_AUTO, &it, &err),
        LF_E_ARG, &err);
    assert_null(it);
    lf_interlacer_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_subpixels_show_the_known_views),
        cmocka_unit_test(the_formulas_agree_with_themselves_in_higher_precision),
        cmocka_unit_test(inversion_follows_the_rule_unless_it_is_forced),
        cmocka_unit_test(the_interlacer_matches_the_formulas_in_every_mode),
        cmocka_unit_test(the_interlacer_matches_the_formulas_on_whole_panels),
        cmocka_unit_test(swapped_orders_are_noticed),
        cmocka_unit_test(nearest_copies_the_nearest_sample_unchanged),
        cmocka_unit_test(views_are_fitted_into_the_panel_and_centred),
        cmocka_unit_test(order_in_memory_rows_and_threads_make_no_difference),
        cmocka_unit_test(linear_mixes_views_and_samples),
        cmocka_unit_test(what_cannot_be_interlaced_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
