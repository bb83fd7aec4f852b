/* The optical model against panels painted by the vendor's formulas, which are written out here
 * once more. */
#include "tests/testing.h"

#include "device/sim/optics.h"

enum { WIDTH = 384, HEIGHT = 512, VIEWS = 9 };

static lf_calibration small_panel(void)
{
    lf_calibration c;
    lf_calibration_portrait(&c);
    c.screen_width_px = WIDTH;
    c.screen_height_px = HEIGHT;
    c.center = 0.37;
    return c;
}

/* looking-glass.md sections 3.2 to 3.4; y from the bottom. */
static double vendor_z(const lf_calibration *c, int x, int y, int channel)
{
    double w = c->screen_width_px, h = c->screen_height_px;
    double pitch = c->pitch * w / c->dpi * cos(atan(1 / c->slope));
    double tilt = h / (w * c->slope) * (c->flip_image_x ? -1 : 1);
    double u = (x + 0.5) / w, v = (y + 0.5) / h;
    int stripe = (c->flip_image_x ? -1 : 1) * (c->flip_subp ? 2 - channel : channel);
    double t = u + stripe / (3 * w) + v * tilt;
    if (c->n_cells > 0) {
        int n[] = {0, (x + y) & 1, x % 2, (y + 2 * (x % 2)) % 4, y % 2};
        const float *offset = c->cells[n[c->cell_pattern_mode] % c->n_cells][channel];
        t = u + (double)offset[0] / w + (v + (double)offset[1] / h) * tilt;
    }
    double phase = t * pitch - c->center, f = phase - floor(phase);
    bool plain = strcmp(c->config_version, "1.0") == 0 && !c->inv_view;
    return plain ? f : 1 - f;
}

/* Every subpixel carries level[view]. */
static void paint(const lf_calibration *c, uint8_t level[VIEWS][3], lf_image8 *panel)
{
    assert_int_equal(lf_image8_init(panel, c->screen_width_px, c->screen_height_px, 3), LF_OK);
    for (int y = 0; y < c->screen_height_px; y++)
        for (int x = 0; x < c->screen_width_px; x++)
            for (int channel = 0; channel < 3; channel++) {
                int view = (int)(vendor_z(c, x, y, channel) * VIEWS);
                view = view >= VIEWS ? VIEWS - 1 : view;
                panel->data[(size_t)(c->screen_height_px - 1 - y) * panel->stride +
                            (size_t)(3 * x + channel)] = level[view][channel];
            }
}

/* Mean and spread (rms) over the middle of what is seen, 8 pixels of edge left out. */
typedef struct seen {
    double mean[3], spread;
} seen;

static seen look(const lf_calibration *c, double eye_deg, const lf_image8 *panel)
{
    lf_error err = {0};
    lf_sim_optics *optics = NULL;
    lf_assert_ok(lf_optics_create(c, eye_deg, &optics, &err), &err);
    lf_image8 view = {0};
    int width, height;
    lf_optics_size(optics, &width, &height);
    assert_int_equal(lf_image8_init(&view, width, height, 3), LF_OK);
    lf_optics_view(optics, panel, &view);
    seen s = {0};
    double square = 0, n = 0;
    for (int y = 8; y < height - 8; y++)
        for (int x = 8; x < width - 8; x++, n++)
            for (int channel = 0; channel < 3; channel++) {
                double v = view.data[(size_t)y * view.stride + (size_t)(3 * x + channel)];
                s.mean[channel] += v;
                square += v * v;
            }
    for (int channel = 0; channel < 3; channel++) {
        s.mean[channel] /= n;
        square -= n * s.mean[channel] * s.mean[channel];
    }
    s.spread = sqrt(fmax(0, square) / (3 * n));
    lf_image8_finish(&view);
    lf_optics_destroy(optics);
    return s;
}

/* View number as a grey ramp: 20, 45, … */
static void ramp(uint8_t level[VIEWS][3])
{
    for (int view = 0; view < VIEWS; view++)
        for (int channel = 0; channel < 3; channel++)
            level[view][channel] = (uint8_t)(20 + 25 * view);
}

/* A panel's picture of that ramp. */
static lf_image8 ramp_panel(const lf_calibration *c)
{
    uint8_t level[VIEWS][3];
    lf_image8 panel;
    ramp(level);
    paint(c, level, &panel);
    return panel;
}

static double seen_view(const lf_calibration *c, double eye_deg, const lf_image8 *panel)
{
    seen s = look(c, eye_deg, panel);
    return ((s.mean[0] + s.mean[1] + s.mean[2]) / 3 - 20) / 25;
}

static void eye_in_front_sees_the_middle_view(void **state)
{
    (void)state;
    lf_calibration c = small_panel();
    uint8_t level[VIEWS][3];
    memset(level, 0, sizeof level);
    memcpy(level[VIEWS / 2], (uint8_t[3]){250, 120, 60}, 3);
    lf_image8 panel;
    paint(&c, level, &panel);
    seen s = look(&c, 0, &panel);
    /* a view is 0.67 pixels wide here: 1.9 sigma of the spot on each side, so a little of the light
     * is lost */
    lf_assert_close(s.mean[0], 250, 0, 12);
    lf_assert_close(s.mean[1], 120, 0, 8);
    lf_assert_close(s.mean[2], 60, 0, 6);
    assert_true(s.spread < 8);
    lf_image8_finish(&panel);
}

static void eye_walks_through_the_views_from_the_left(void **state)
{
    (void)state;
    lf_calibration c = small_panel();
    lf_image8 panel = ramp_panel(&c);
    for (int view = 1; view < VIEWS - 1; view++) {
        double eye = ((view + 0.5) / VIEWS - 0.5) * c.view_cone_deg;
        lf_assert_close(seen_view(&c, eye, &panel), view, 0, 0.15);
    }
    lf_image8_finish(&panel);
}

/* The last views of the cone have the other end as a neighbour, so their light is looked at alone.
 */
static void ends_of_the_cone_are_seen_from_their_own_side(void **state)
{
    (void)state;
    lf_calibration c = small_panel();
    double outermost = (0.5 - 0.5 / VIEWS) * c.view_cone_deg;
    for (int right = 0; right <= 1; right++) {
        uint8_t level[VIEWS][3];
        lf_image8 panel;
        memset(level, 0, sizeof level);
        memset(level[right ? VIEWS - 1 : 0], 250, 3);
        paint(&c, level, &panel);
        assert_true(look(&c, right ? outermost : -outermost, &panel).mean[1] > 235);
        assert_true(look(&c, 0, &panel).mean[1] < 5);
        lf_image8_finish(&panel);
    }
}

static void views_repeat_beyond_the_cone(void **state)
{
    (void)state;
    lf_calibration c = small_panel();
    lf_image8 panel = ramp_panel(&c);
    lf_assert_close(seen_view(&c, c.view_cone_deg * 2 / VIEWS, &panel), 6, 0, 0.15);
    lf_assert_close(seen_view(&c, c.view_cone_deg * 2 / VIEWS + c.view_cone_deg, &panel), 6, 0,
                    0.15);
    lf_assert_close(seen_view(&c, c.view_cone_deg * 2 / VIEWS - c.view_cone_deg, &panel), 6, 0,
                    0.15);
    lf_image8_finish(&panel);
}

/* What is seen when the panel was made for `made` but looked at with the lens of `real`. */
static seen mismatch(const lf_calibration *made, const lf_calibration *real)
{
    lf_image8 panel = ramp_panel(made);
    seen s = look(real, 0, &panel);
    lf_image8_finish(&panel);
    return s;
}

static void wrong_calibrations_are_seen(void **state)
{
    (void)state;
    lf_calibration right = small_panel(), wrong = right;
    double spread = mismatch(&right, &right).spread;
    assert_true(spread < 4);
    wrong.slope = -right.slope;
    assert_true(mismatch(&wrong, &right).spread > 8 * spread);
    wrong = right;
    wrong.pitch *= 1.01;
    assert_true(mismatch(&wrong, &right).spread > 8 * spread);
    wrong = right;
    wrong.flip_subp = 1;
    seen swapped = mismatch(&wrong, &right), good = mismatch(&right, &right);
    assert_true(fabs(swapped.mean[0] - good.mean[0]) > 15);
    assert_true(fabs(swapped.mean[2] - good.mean[2]) > 15);
    wrong = right;
    wrong.center += 1.0 / VIEWS;
    lf_assert_close(fabs(mismatch(&wrong, &right).mean[1] - good.mean[1]), 25, 0, 3);
}

static void every_kind_of_panel_is_seen_right(void **state)
{
    (void)state;
    lf_calibration kinds[6];
    for (int i = 0; i < 6; i++)
        kinds[i] = small_panel();
    kinds[0].slope = 5.04;
    kinds[1].flip_image_x = 1;
    kinds[2].flip_subp = 1;
    strcpy(kinds[3].config_version, "1.0");
    kinds[3].inv_view = 0;
    for (int i = 4; i < 6; i++) {
        kinds[i].cell_pattern_mode = i == 4 ? 2 : 4;
        kinds[i].n_cells = 2;
        for (int cell = 0; cell < 2; cell++) {
            float sign = cell == 0 ? 1.0f : -1.0f;
            float landscape[3][2] = {
                {-0.31f, 0.25f * sign}, {0.28f, 0.25f * sign}, {0, -0.25f * sign}};
            float portrait[3][2] = {
                {-0.25f * sign, -0.31f}, {-0.25f * sign, 0.28f}, {0.25f * sign, 0}};
            memcpy(kinds[i].cells[cell], i == 4 ? landscape : portrait, sizeof landscape);
        }
    }
    for (int i = 0; i < 6; i++) {
        uint8_t level[VIEWS][3];
        ramp(level);
        lf_image8 panel;
        paint(&kinds[i], level, &panel);
        for (int view = 2; view <= 6; view += 2) {
            double eye = ((view + 0.5) / VIEWS - 0.5) * kinds[i].view_cone_deg;
            lf_assert_close(seen_view(&kinds[i], eye, &panel), view, 0, 0.2);
        }
        assert_true(look(&kinds[i], 0, &panel).spread < 5);
        lf_image8_finish(&panel);
    }
}

/* A picture that is the same in all views is seen in its place, the right way up. */
static void picture_stays_in_its_place(void **state)
{
    (void)state;
    lf_calibration c = small_panel();
    lf_image8 panel, view;
    lf_sim_optics *optics = NULL;
    int width, height;
    assert_int_equal(lf_image8_init(&panel, WIDTH, HEIGHT, 3), LF_OK);
    for (int y = 0; y < HEIGHT / 4; y++)
        memset(panel.data + (size_t)y * panel.stride, 200, (size_t)WIDTH / 2 * 3);
    lf_assert_ok(lf_optics_create(&c, 0, &optics, NULL), NULL);
    lf_optics_size(optics, &width, &height);
    lf_assert_close((double)width / height, (double)WIDTH / HEIGHT, 0.02, 0);
    assert_int_equal(lf_image8_init(&view, width, height, 3), LF_OK);
    lf_optics_view(optics, &panel, &view);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double down = (y + 0.5) / height - 0.25, right = (x + 0.5) / width - 0.5;
            if (fabs(down) < 0.04 || fabs(right) < 0.04)
                continue;
            int expected = down < 0 && right < 0 ? 200 : 0;
            assert_int_equal(view.data[(size_t)y * view.stride + (size_t)(3 * x + 1)], expected);
        }
    lf_optics_destroy(optics);
    lf_image8_finish(&view);
    lf_image8_finish(&panel);
}

static void lenses_that_cannot_be_resolved_are_refused(void **state)
{
    (void)state;
    lf_sim_optics *optics = NULL;
    lf_error err = {0};
    lf_calibration c = small_panel();
    c.pitch = 300;
    lf_assert_status(lf_optics_create(&c, 0, &optics, &err), LF_E_ARG, &err);
    c.pitch = 0.01;
    lf_assert_status(lf_optics_create(&c, 0, &optics, &err), LF_E_ARG, &err);
    c = small_panel();
    c.slope = 0.1;
    lf_assert_status(lf_optics_create(&c, 0, &optics, &err), LF_E_ARG, &err);
    assert_null(optics);
    lf_optics_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eye_in_front_sees_the_middle_view),
        cmocka_unit_test(eye_walks_through_the_views_from_the_left),
        cmocka_unit_test(ends_of_the_cone_are_seen_from_their_own_side),
        cmocka_unit_test(views_repeat_beyond_the_cone),
        cmocka_unit_test(wrong_calibrations_are_seen),
        cmocka_unit_test(every_kind_of_panel_is_seen_right),
        cmocka_unit_test(picture_stays_in_its_place),
        cmocka_unit_test(lenses_that_cannot_be_resolved_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
