/* What the camera sees where it meets nothing: lights at infinity that are hidden from it, and
 * backdrops. Closed forms, then that a picture is the sum of what its light does and of what is
 * behind it. */
#include "tests/testing.h"

#include "render/renderer.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 18, n_views = 5, values = 3 * n_views * width * height, cycles = 8 };

#define RIG "'camera': { 'position': [1, 2, 5], 'fov_y': 40, 'aspect': 1.3333333333, 'views': 5 }"
#define GRADIENT "'backdrop': { 'top': [1, 2, 3], 'bottom': [3, 2, 0] }"

/* The picture of a scene, of a part of the window that begins at top. */
static void render_rolled(const char *text, double top, bool rolled, float out[values])
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.seed = 7;
    settings.window[1] = top;
    settings.camera.rolled = rolled;
    settings.window[2] = settings.window[3] = 1.0;
    assert_int_equal(lf_renderer_restart(r, scene, &settings, NULL), LF_OK);
    lf_test_cycles(r, cycles);
    assert_int_equal(lf_renderer_fill_holes(r, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, out, NULL), LF_OK);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void render(const char *text, double top, float out[values])
{
    render_rolled(text, top, false, out);
}

static void assert_everywhere(const float picture[values], double value, double tolerance)
{
    for (int i = 0; i < values; i++)
        lf_assert_close(picture[i], value, tolerance, 1e-6);
}

static void an_even_backdrop_is_seen_as_it_is_said(void **state)
{
    (void)state;
    static float picture[values];
    render("{ " RIG ", 'backdrop': 0.7 }", 0.0, picture);
    assert_everywhere(picture, (double)0.7f, 1e-6);
    render("{ " RIG ", 'backdrop': { 'top': 0.7, 'bottom': 0.7 } }", 0.0, picture);
    assert_everywhere(picture, (double)0.7f, 1e-6);
    render("{ " RIG " }", 0.0, picture);
    assert_everywhere(picture, 0.0, 0.0);
}

/* The rows of an image on its side are not one above the other. */
static void a_gradient_is_its_middle_in_an_image_on_its_side(void **state)
{
    (void)state;
    static float picture[values];
    render_rolled("{ " RIG ", " GRADIENT " }", 0.0, true, picture);
    for (int i = 0; i < values; i++)
        lf_assert_close((double)picture[i], ((const double[]){2.0, 2.0, 1.5})[i % 3], 1e-6, 1e-6);
}

/* Linear in the window's height, whatever is looked at: the film points of a visit are spread over
 * the row as a net, so that the mean over n of them is off by 1 / n of a row at most. */
static void a_gradient_is_linear_from_the_top_of_the_window_to_its_bottom(void **state)
{
    (void)state;
    static float picture[values];
    for (int part = 0; part < 2; part++) {
        double top = 0.5 * part, row_height = (1.0 - top) / height;
        render("{ " RIG ", " GRADIENT " }", top, picture);
        for (int i = 0; i < values / 3; i++) {
            double t = top + row_height * (i / (n_views * width) + 0.5), off = row_height / cycles;
            lf_assert_close(picture[3 * i], 1.0 + 2.0 * t, 0.0, 2.0 * off);
            lf_assert_close(picture[3 * i + 1], 2.0, 1e-6, 0.0);
            lf_assert_close(picture[3 * i + 2], 3.0 - 3.0 * t, 0.0, 3.0 * off);
        }
    }
}

/* But for how the film rounds. */
static void all_views_see_a_gradient_in_the_same_place(void **state)
{
    (void)state;
    static float picture[values];
    render("{ " RIG ", " GRADIENT " }", 0.0, picture);
    const int row = 3 * n_views * width;
    for (int i = 0; i < values; i++)
        lf_assert_close(picture[i], picture[i / row * row + i % 3], 1e-6, 0.0);
    assert_true(picture[0] < picture[values - 3]);
}

static void a_backdrop_stands_in_place_of_skies_and_suns(void **state)
{
    (void)state;
    static float picture[values];
#define LIGHTS(more)                                                                               \
    "'lights': { 'sky': { 'type': 'environment', 'radiance': 4" more                               \
    " }, 'sun': { 'type': 'distant', 'direction': [1, 2, 5], 'angle': 90" more " } }"
    render("{ " RIG ", 'backdrop': 0.2, " LIGHTS("") " }", 0.0, picture);
    assert_everywhere(picture, (double)0.2f, 1e-6);
    render("{ " RIG ", " LIGHTS(", 'visible': false") " }", 0.0, picture);
    assert_everywhere(picture, 0.0, 0.0);
    /* The negative control. */
    render("{ " RIG ", " LIGHTS("") " }", 0.0, picture);
    for (int i = 0; i < values; i++)
        assert_true(picture[i] > 4.0f);
}

/* Black fog that fills the picture: exp(-2) of the backdrop on the way straight through. */
static void media_take_of_a_backdrop_what_they_take_of_a_sky(void **state)
{
    (void)state;
    static float picture[values];
#define FOG                                                                                        \
    "{ 'camera': { 'fov_y': 1, 'aspect': 1.3333333333, 'cone': 0, 'views': 5 }, "                  \
    "'volumes': { 'fog': { 'shape': 'box', 'density': 1, 'albedo': 0 } }, %s }"
    const char *behind[] = {
        "'backdrop': 3", "'lights': { 'sky': { 'type': 'environment', 'radiance': 3 } }",
        "'backdrop': { 'top': 3, 'bottom': 3 }, 'lights': { 'sky': { 'type': 'environment', "
        "'radiance': 9 } }"};
    for (int i = 0; i < 3; i++) {
        char text[512];
        snprintf(text, sizeof text, FOG, behind[i]);
        render(text, 0.0, picture);
        assert_everywhere(picture, 3.0 * exp(-2.0), 2e-3);
    }
}

/* A white ball and a mirror in a hidden sky of 1 are as bright as it, before nothing. */
static void what_is_hidden_from_the_camera_lights_and_is_mirrored(void **state)
{
    (void)state;
    static const char *const materials[] = {"'albedo': 1",
                                            "'type': 'conductor', 'albedo': 1, 'roughness': 0"};
    static float picture[values];
    for (int m = 0; m < 2; m++) {
        render(lf_test_scene_patched("hidden-sky", "{'materials': {'m': {%s}}}", materials[m]), 0.0,
               picture);
        for (int i = 0; i < values / 3; i++) {
            /* The ball's rim is at a sine of 1/5; a pixel is 0.04 wide. */
            double y = tan(20.0 * M_PI / 180.0) *
                       (1.0 - 2.0 * (i / (n_views * width) + 0.5) / height),
                   x = tan(20.0 * M_PI / 180.0) * 4.0 / 3.0 *
                       (2.0 * (i % width + 0.5) / width - 1.0),
                   off = sqrt(x * x + y * y) - 1.0 / sqrt(24.0);
            if (off > 0.06)
                assert_true(picture[3 * i] == 0.0f);
            else if (off < -0.06)
                lf_assert_close(picture[3 * i], 1.0, 1e-3, 0.0);
        }
    }
}

/* Light is added: a scene before a backdrop is the scene before nothing and a black one before the
 * backdrop, visit by visit. */
static void a_picture_is_its_light_and_what_is_behind_it(void **state)
{
    (void)state;
    static float before[values], dark[values], unlit[values], seen[values];
    static const char *const lights[] = {"'radiance': 0.6", "'radiance': 0.6, 'visible': false"};
    double difference = 0.0;
    render(lf_test_scene_patched("mirror-and-fog", "{" GRADIENT "}"), 0.0, unlit);
    for (int i = 0; i < 4; i++) {
        const char *text = lf_test_scene_patched(
            "mirror-and-fog", "{'lights': {'sky': {'type': 'environment', %s}}%s}", lights[i % 2],
            i < 2 ? "" : ", " GRADIENT);
        render(text, 0.0, i == 0 ? seen : i == 1 ? dark : before);
        for (int k = 0; k < values && i >= 2; k++)
            lf_assert_close(before[k], (double)dark[k] + (double)unlit[k], 2e-4, 1e-4);
    }
    for (int k = 0; k < values; k++)
        difference = fmax(difference, fabs((double)seen[k] - (double)dark[k]));
    lf_assert_close(difference, 0.6, 1e-4, 0.0); /* where nothing is before the sky */
}

static void a_backdrop_makes_another_picture_and_another_exposure_does_not(void **state)
{
    (void)state;
    static const char *const texts[] = {"{ " RIG ", 'backdrop': 0.2 }",
                                        "{ " RIG ", 'backdrop': 0.2, 'film': { 'exposure': 1 } }",
                                        "{ " RIG ", 'backdrop': 0.3 }", "{ " RIG " }"};
    lf_scene *scene[4];
    lf_render_settings settings = {.width = width, .height = height};
    for (int i = 0; i < 4; i++)
        scene[i] = lf_test_scene(texts[i]);
    settings.camera = *lf_scene_camera(scene[0]);
    for (int i = 1; i < 4; i++)
        assert_true(lf_same_picture(scene[0], &settings, scene[i], &settings) == (i == 1));
    for (int i = 0; i < 4; i++)
        lf_scene_unref(scene[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_backdrop_is_seen_as_it_is_said),
        cmocka_unit_test(a_gradient_is_its_middle_in_an_image_on_its_side),
        cmocka_unit_test(a_gradient_is_linear_from_the_top_of_the_window_to_its_bottom),
        cmocka_unit_test(all_views_see_a_gradient_in_the_same_place),
        cmocka_unit_test(a_backdrop_stands_in_place_of_skies_and_suns),
        cmocka_unit_test(media_take_of_a_backdrop_what_they_take_of_a_sky),
        cmocka_unit_test(what_is_hidden_from_the_camera_lights_and_is_mirrored),
        cmocka_unit_test(a_picture_is_its_light_and_what_is_behind_it),
        cmocka_unit_test(a_backdrop_makes_another_picture_and_another_exposure_does_not),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
