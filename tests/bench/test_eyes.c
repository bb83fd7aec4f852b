/* What eyes see of pictures whose errors are known in closed form, on a small panel. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "bench/eyes.h"

enum { VIEWS = 9, WIDTH = 24, HEIGHT = 32, FLOATS = VIEWS * WIDTH * HEIGHT * 3 };

/* Display light of a code, so that a panel shows it as it is. */
static float light(int code)
{
    float table[256];
    lf_srgb_light(table);
    return table[code];
}

static lf_calibration small_panel(void)
{
    lf_calibration c;
    lf_calibration_portrait(&c);
    c.screen_width_px = 192;
    c.screen_height_px = 256;
    return c;
}

static lf_eyes *make_eyes(lf_pool *pool, double epsilon)
{
    const lf_calibration panel = small_panel();
    const lf_film_settings film = {.tonemap = "srgb"};
    lf_render_settings settings = {.width = WIDTH, .height = HEIGHT};
    settings.camera.n_views = VIEWS;
    settings.camera.aspect = 0.75;
    lf_eyes *eyes = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_eyes_create(&panel, &settings, &film, epsilon, pool, &eyes, &err), &err);
    return eyes;
}

/* [row][view][column][3], all of one value. */
static float *flat(float value)
{
    float *picture = lf_calloc(FLOATS, sizeof *picture);
    assert_non_null(picture);
    for (int i = 0; i < FLOATS; i++)
        picture[i] = value;
    return picture;
}

static void set_view(float *picture, int view, float value)
{
    for (int row = 0; row < HEIGHT; row++)
        for (int i = 0; i < 3 * WIDTH; i++)
            picture[(row * VIEWS + view) * 3 * WIDTH + i] = value;
}

typedef struct fixture {
    lf_pool *pool;
    lf_eyes *eyes;
} fixture;

static const double epsilon = 0.01;

static int set_up(void **state)
{
    static fixture f;
    lf_assert_ok(lf_pool_create(2, &f.pool), NULL);
    f.eyes = make_eyes(f.pool, epsilon);
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    lf_eyes_destroy(f->eyes);
    lf_pool_destroy(f->pool);
    return 0;
}

static void the_reference_itself_has_no_error(void **state)
{
    const fixture *f = *state;
    float *picture = flat(light(100));
    double rel_mse = 1, flicker = 1;
    for (int view = 0; view < VIEWS; view++)
        set_view(picture, view, light(40 + 20 * view));
    lf_eyes_set_reference(f->eyes, picture, picture);
    lf_eyes_look(f->eyes, picture, &rel_mse, &flicker);
    assert_true(rel_mse == 0 && flicker == 0);
    assert_true(lf_eyes_change(f->eyes, picture) == 0);
    lf_free(picture);
}

/* Every eye sees the whole panel in one light, so e is the same everywhere. */
static void a_constant_offset_has_its_own_error(void **state)
{
    const fixture *f = *state;
    const double r = (double)light(128), x = (double)light(140), y = (double)light(150),
                 scale = r * r + epsilon;
    float *reference = flat(light(128)), *picture = flat(light(140)), *next = flat(light(150));
    double rel_mse, flicker;
    lf_eyes_set_reference(f->eyes, reference, reference);
    lf_eyes_look(f->eyes, picture, &rel_mse, &flicker);
    lf_assert_close(rel_mse, (x - r) * (x - r) / scale, 1e-5, 0);
    lf_assert_close(flicker, 0, 0, 1e-12);
    lf_assert_close(lf_eyes_change(f->eyes, next), (y - x) * (y - x) / scale, 1e-5, 0);
    /* the same picture again: nothing changes, and what was looked at last is still remembered */
    assert_true(lf_eyes_change(f->eyes, picture) == 0);
    lf_free(reference);
    lf_free(picture);
    lf_free(next);
}

/* Two halves that are off by d to either side have a mean without error, whose own is (d / 2)^2 in
 * each; it is taken off the error of a picture that is one of them, d away from the mean. */
static void what_the_reference_adds_is_subtracted(void **state)
{
    const fixture *f = *state;
    const double a = (double)light(120), b = (double)light(136), r = 0.5 * (a + b),
                 half = 0.5 * (a - b);
    float *first = flat(light(120)), *second = flat(light(136));
    double rel_mse, flicker;
    lf_eyes_set_reference(f->eyes, first, second);
    lf_eyes_look(f->eyes, first, &rel_mse, &flicker);
    /* (a - r)^2 is as large as the square of half the difference */
    lf_assert_close(rel_mse, 0, 0, 1e-5 * half * half / (r * r + epsilon));
    lf_assert_close(flicker, 0, 0, 1e-12);
    lf_free(first);
    lf_free(second);
}

/* An error that lies in the middle view alone is seen by one eye of the middle place, hardly by the
 * other, and by nobody at the other places: a step of about e at one place of three, while the
 * error is e^2 at one eye of six. */
static void errors_of_single_views_flicker(void **state)
{
    const fixture *f = *state;
    const double r = (double)light(128), x = (double)light(180),
                 e2 = (x - r) * (x - r) / (r * r + epsilon);
    float *reference = flat(light(128)), *picture = flat(light(128));
    double rel_mse, flicker, rel_mse_all, flicker_all;
    set_view(picture, VIEWS / 2, light(180));
    lf_eyes_set_reference(f->eyes, reference, reference);
    lf_eyes_look(f->eyes, picture, &rel_mse, &flicker);
    print_message("relMSE %g, flicker %g, e^2 %g\n", rel_mse, flicker, e2);
    assert_true(rel_mse > 0.05 * e2 && rel_mse < e2 / 3);
    assert_true(flicker > rel_mse && flicker < e2);
    for (int view = 0; view < VIEWS; view++)
        set_view(picture, view, light(180));
    lf_eyes_look(f->eyes, picture, &rel_mse_all, &flicker_all);
    assert_true(rel_mse_all > rel_mse && flicker_all < 1e-3 * flicker);
    lf_free(reference);
    lf_free(picture);
}

static void a_panel_without_lenses_is_refused(void **state)
{
    const fixture *f = *state;
    const lf_film_settings film = {.tonemap = "srgb"};
    lf_render_settings settings = {.width = WIDTH, .height = HEIGHT};
    lf_calibration panel = small_panel();
    lf_eyes *eyes = NULL;
    lf_error err = {0};
    settings.camera.n_views = VIEWS;
    settings.camera.aspect = 0.75;
    panel.slope = 0.5;
    lf_assert_status(lf_eyes_create(&panel, &settings, &film, epsilon, f->pool, &eyes, &err),
                     LF_E_ARG, &err);
    assert_null(eyes);
    lf_eyes_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_itself_has_no_error),
        cmocka_unit_test(a_constant_offset_has_its_own_error),
        cmocka_unit_test(what_the_reference_adds_is_subtracted),
        cmocka_unit_test(errors_of_single_views_flicker),
        cmocka_unit_test(a_panel_without_lenses_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
