/* Options written back as words: quiltrender reads them as the same values. */
#include "tests/testing.h"

#include "daemon/output/options.h"
#include "daemon/output/render_words.h"

/* Reads words into an object by a table. */
static void read_back(const lf_render_words *words, const lf_param *params, void *object)
{
    for (int i = 0; i < words->n; i++) {
        char name[64];
        lf_error err;
        const char *word = words->list[i] + 2, *value = strchr(word, '=');
        snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
        const lf_param *row = lf_param_find(params, name);
        if (!row)
            fail_msg("%s is no option", words->list[i]);
        lf_assert_ok(lf_param_from_text(row, value ? value + 1 : NULL, object, &err), &err);
    }
}

static bool has_word(const lf_render_words *words, const char *word)
{
    for (int i = 0; i < words->n; i++)
        if (strcmp(words->list[i], word) == 0)
            return true;
    return false;
}

static void settings_come_back(void **state)
{
    (void)state;
    lf_render_words words = {0};
    lf_options options = {0};
    const lf_render_settings settings = {.integrator = lf_integrator_at(1)->name,
                                         .sampler = LF_SAMPLER_INDEPENDENT,
                                         .seed = UINT64_MAX,
                                         .max_depth = 7,
                                         .skip = LF_SKIP_PATHS | LF_SKIP_SURFACES,
                                         .light_paths = 300,
                                         .suffixes = 4};
    lf_render_words_settings(&words, &settings, LF_ESTIMATOR_CV, false);
    read_back(&words, lf_option_params, &options);
    assert_string_equal(options.integrator, settings.integrator);
    assert_int_equal(options.sampler, settings.sampler);
    assert_true(options.seed == settings.seed);
    assert_int_equal(options.max_depth, 7);
    assert_int_equal(options.tracing.skip, settings.skip);
    assert_true(options.tracing.has_light_paths && options.tracing.light_paths == 300);
    assert_int_equal(options.tracing.suffixes, lf_suffixes_word(4));
    assert_int_equal(lf_suffixes_word(4), 3);
    assert_int_equal(options.estimator, LF_ESTIMATOR_CV);
    assert_int_equal(options.denoise, LF_DENOISE_OFF);
    assert_false(words.failed);
    lf_render_words_finish(&words);
    /* nothing is said of what is usual, since --estimator alone turns denoising off */
    const lf_render_settings plain = {
        .skip = LF_SKIP_ALL, .light_paths = LF_LIGHT_PATHS_AUTO, .suffixes = LF_SUFFIXES_AUTO};
    lf_render_words_settings(&words, &plain, LF_ESTIMATOR_MWIS, true);
    assert_int_equal(words.n, 1);
    assert_string_equal(words.list[0], "--denoise=on");
    lf_render_words_finish(&words);
    const lf_render_settings none = {.skip = 0};
    lf_render_words_settings(&words, &none, LF_ESTIMATOR_MWIS, true);
    assert_true(has_word(&words, "--skip=none"));
    assert_true(has_word(&words, "--light-paths=none"));
    assert_true(has_word(&words, "--suffixes=1"));
    lf_render_words_finish(&words);
}

static void numbers_come_back_to_the_last_bit(void **state)
{
    (void)state;
    static const double numbers[] = {0.1, 1.0 / 3, -31.999999999999996, 1e-5, 2, 0};
    const lf_param *row = lf_param_find(lf_option_params, "exposure");
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        lf_render_words words = {0};
        lf_options options = {.exposure = numbers[i]}, back = {0};
        lf_render_words_row(&words, row, &options);
        read_back(&words, lf_option_params, &back);
        assert_true(back.exposure == numbers[i] && back.has_exposure);
        lf_render_words_finish(&words);
    }
    lf_render_words words = {0};
    const lf_options automatic = {.exposure = INFINITY}, own = {.exposure = -(double)INFINITY};
    lf_render_words_row(&words, row, &automatic);
    lf_render_words_row(&words, row, &own);
    assert_string_equal(words.list[0], "--exposure=auto");
    assert_string_equal(words.list[1], "--exposure=scene");
    lf_render_words_finish(&words);
}

/* A print has rows of several fields, two resolutions, switches with and without words, texts. */
static void a_print_comes_back(void **state)
{
    (void)state;
    lf_error err;
    lf_render_words words = {0};
    lf_print print, back;
    json_t *given = json_pack("{s:f, s:s, s:i, s:i, s:b, s:s, s:i, s:s, s:i}", "lpi", 60.13, "dpi",
                              "720x1440", "width", 190, "height", 277, "mirror", 1, "orientation",
                              "horizontal", "bits", 16, "label", "a 'b' c", "views", 12);
    lf_param_defaults(lf_print_params, &print);
    lf_param_defaults(lf_print_params, &back);
    lf_assert_ok(lf_param_from_json(lf_print_params, given, &print, "export", &err), &err);
    lf_render_words_given(&words, lf_print_params, given, &print);
    assert_true(has_word(&words, "--print=60.13@720x1440"));
    assert_true(has_word(&words, "--print-size=190x277"));
    assert_true(has_word(&words, "--mirror"));
    assert_true(has_word(&words, "--label=a 'b' c"));
    assert_int_equal(words.n, 6);
    read_back(&words, lf_print_params, &back);
    assert_string_equal(back.sheet.label, print.sheet.label);
    back.n_views = 12; /* quiltrender's --views is of another table */
    json_t *a = lf_param_json(lf_print_params, &print), *b = lf_param_json(lf_print_params, &back);
    assert_true(json_equal(a, b));
    json_decref(a);
    json_decref(b);
    json_decref(given);
    lf_render_words_finish(&words);
}

static void more_words_than_there_is_room_for_fail(void **state)
{
    (void)state;
    lf_render_words words = {0};
    for (int i = 0; i < LF_RENDER_WORDS; i++)
        lf_render_words_add(&words, "--word-%d", i);
    assert_false(words.failed);
    lf_render_words_add(&words, "more");
    assert_true(words.failed);
    assert_int_equal(words.n, LF_RENDER_WORDS);
    lf_render_words_finish(&words);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(settings_come_back),
        cmocka_unit_test(numbers_come_back_to_the_last_bit),
        cmocka_unit_test(a_print_comes_back),
        cmocka_unit_test(more_words_than_there_is_room_for_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
