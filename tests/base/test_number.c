/* Decimal numbers: what is read, to the last bit, and what is none. */
#include "tests/testing.h"

#include <locale.h>

#include "base/number.h"

static void a_number_is_rounded_as_the_compiler_rounds_it(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double value;
    } cases[] = {{"0", 0},
                 {"-0.5", -0.5},
                 {"+.5", .5},
                 {"5.", 5},
                 {"0005", 5},
                 {"1e3", 1e3},
                 {"1E-3", 1e-3},
                 {"1e+22", 1e22},
                 {"812.8", 812.8},
                 {"60.13", 60.13},
                 {"0.1", 0.1},
                 {"123456789012345678901234567890", 123456789012345678901234567890.0},
                 {"9007199254740993", 9007199254740992.0},
                 {"1.7976931348623157e308", 1.7976931348623157e308},
                 {"4.9e-324", 4.9e-324},
                 {"1e-400", 0},
                 {"2.2250738585072011e-308", 2.2250738585072011e-308}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double value = 7;
        if (!lf_decimal_is(cases[i].text, &value) || value != cases[i].value)
            fail_msg("%s: %.17g", cases[i].text, value);
    }
}

static void what_is_not_wholly_a_decimal_number_is_none(void **state)
{
    (void)state;
    static const char *const none[] = {
        "",    ".",    "-",     "+",        " 1",  "1 ",       "1,5",    "0x10", "0X1p3",
        "inf", "-nan", "nan",   "1e",       "1e+", "1e999",    "3.1+e2", "1..2", "1.2.3",
        "--1", "1e5.", "1_000", "\xd9\xa1", "1\n", "infinity", "1f",     "1e1e1"};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        double value = 7;
        uint64_t whole = 7;
        int64_t integer = 7;
        if (lf_decimal_is(none[i], &value) || value != 7)
            fail_msg("\"%s\" is %g", none[i], value);
        if (lf_whole_is(none[i], &whole) || lf_integer_is(none[i], &integer) || whole != 7 ||
            integer != 7)
            fail_msg("\"%s\" is whole", none[i]);
    }
}

static void whole_numbers_end_at_their_ranges(void **state)
{
    (void)state;
    uint64_t whole = 7;
    int64_t integer = 7;
    assert_true(lf_whole_is("18446744073709551615", &whole) && whole == UINT64_MAX);
    assert_false(lf_whole_is("18446744073709551616", &whole));
    assert_false(lf_whole_is("-1", &whole));
    assert_false(lf_whole_is("+1", &whole));
    assert_true(lf_integer_is("-9223372036854775808", &integer) && integer == INT64_MIN);
    assert_true(lf_integer_is("+9223372036854775807", &integer) && integer == INT64_MAX);
    assert_false(lf_integer_is("9223372036854775808", &integer));
    assert_false(lf_integer_is("-9223372036854775809", &integer));
    assert_false(lf_integer_is("1e9", &integer));
    assert_false(lf_integer_is("1.0", &integer));
}

static void what_is_behind_a_number_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *text, *points;
        double value;
        const char *rest;
    } cases[] = {{"3.1+e2", ".", 3.1, "+e2"}, {"0x10", ".", 0, "x10"},  {"1,5", ".", 1, ",5"},
                 {"1,5", ".,", 1.5, ""},      {"1e5x", ".", 1e5, "x"},  {"2e", ".", 2, "e"},
                 {"2ex", ".", 2, "ex"},       {"7.png", ".", 7, "png"}, {"1,2,3", ".,", 1.2, ",3"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double value;
        const char *rest = lf_decimal_read(cases[i].text, cases[i].points, &value);
        assert_non_null(rest);
        assert_string_equal(rest, cases[i].rest);
        assert_true(value == cases[i].value);
    }
}

/* A program that sets one: skipped with a word where the system has no other. */
static void no_locale_has_any_part_in_it(void **state)
{
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "fr_FR"};
    bool set = false;
    double value = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names && !set; i++)
        set = setlocale(LC_NUMERIC, names[i]);
    if (!set)
        print_message("no locale with a decimal comma is installed\n");
    assert_true(lf_decimal_is("0.1234567890123456789", &value) && value == 0.1234567890123456789);
    assert_false(lf_decimal_is("0,1", &value));
    setlocale(LC_NUMERIC, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_number_is_rounded_as_the_compiler_rounds_it),
        cmocka_unit_test(what_is_not_wholly_a_decimal_number_is_none),
        cmocka_unit_test(whole_numbers_end_at_their_ranges),
        cmocka_unit_test(what_is_behind_a_number_is_told),
        cmocka_unit_test(no_locale_has_any_part_in_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
