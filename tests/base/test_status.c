#include "tests/testing.h"

#include "base/escape.h"

static void every_code_has_its_own_name_and_sign(void **state)
{
    (void)state;
    assert_string_equal(lf_status_name(LF_OK), "LF_OK");
    for (int i = 0; i >= LF_E_EXISTS; i--) {
        for (int j = 0; j > i; j--)
            assert_string_not_equal(lf_status_name((lf_status)i), lf_status_name((lf_status)j));
        assert_string_not_equal(lf_status_name((lf_status)i), "LF_E_UNKNOWN");
    }
    assert_string_equal(lf_status_name((lf_status)(LF_E_EXISTS - 1)), "LF_E_UNKNOWN");
    assert_string_equal(lf_status_name((lf_status)1), "LF_E_UNKNOWN");
}

static void an_error_reads_place_pointer_and_words(void **state)
{
    (void)state;
    lf_error err;
    char text[256];
    lf_assert_status(lf_error_set_at(&err, LF_E_FORMAT, "a.json", 7, "/camera/views",
                                     "%d views, expected 1 to %d", 999, 256),
                     LF_E_FORMAT, NULL);
    assert_string_equal(lf_error_format(&err, text, sizeof text),
                        "a.json:7: /camera/views: 999 views, expected 1 to 256");
    lf_error_set(&err, LF_E_IO, "b.vdb", "cannot open");
    assert_string_equal(lf_error_format(&err, text, sizeof text), "b.vdb: cannot open");
    lf_error_set(&err, LF_E_NOMEM, NULL, "out of memory");
    assert_string_equal(lf_error_format(&err, text, sizeof text), "out of memory");
    assert_int_equal(err.status, LF_E_NOMEM);
    assert_int_equal(err.line, 0);
}

static void an_error_may_be_absent(void **state)
{
    (void)state;
    lf_assert_status(lf_error_set(NULL, LF_E_BUSY, "x", "y"), LF_E_BUSY, NULL);
    lf_assert_status(lf_error_set_at(NULL, LF_E_ARG, "x", 1, "/y", "z"), LF_E_ARG, NULL);
}

static void an_error_may_be_made_from_itself(void **state)
{
    (void)state;
    lf_error err;
    lf_error_set_at(&err, LF_E_IO, "inner", 3, "/a", "no luck");
    lf_error_set_at(&err, LF_E_FORMAT, err.where, err.line, err.pointer, "outer: %s", err.what);
    assert_string_equal(err.where, "inner");
    assert_string_equal(err.pointer, "/a");
    assert_string_equal(err.what, "outer: no luck");
}

static void long_texts_are_cut_and_terminated(void **state)
{
    (void)state;
    char long_text[5000];
    memset(long_text, 'a', sizeof long_text - 1);
    long_text[sizeof long_text - 1] = 0;
    lf_error err;
    lf_error_set_at(&err, LF_E_ARG, long_text, 1, long_text, "%s", long_text);
    assert_int_equal(strlen(err.where), sizeof err.where - 1);
    assert_int_equal(strlen(err.pointer), sizeof err.pointer - 1);
    assert_int_equal(strlen(err.what), sizeof err.what - 1);
    char small[10];
    lf_error_format(&err, small, sizeof small);
    assert_int_equal(strlen(small), sizeof small - 1);
}

static void control_characters_are_escaped(void **state)
{
    (void)state;
    static const struct {
        const char *in, *out;
    } cases[] = {
        {"plain \"text\" \\ stays", "plain \"text\" \\ stays"},
        {"a\nb\tc\rd", "a\\nb\\tc\\rd"},
        {"\x1b[31mred\x7f", "\\x1b[31mred\\x7f"},
        {"\xc2\x9b"
         "31m",
         "\\x9b31m"}, /* C1 control sequence introducer */
        {"h\xc3\xb6her \xe2\x82\xac \xf0\x9f\x99\x82",
         "h\xc3\xb6her \xe2\x82\xac \xf0\x9f\x99\x82"},
        {"\xff\xc3(\xe2\x82", "\\xff\\xc3(\\xe2\\x82"}, /* not UTF-8 */
        {"\xc0\xaf", "\\xc0\\xaf"},                     /* overlong */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char out[64];
        assert_int_equal(lf_escape(out, sizeof out, cases[i].in), strlen(cases[i].out));
        assert_string_equal(out, cases[i].out);
    }
    lf_error err;
    lf_error_set(&err, LF_E_IO, "evil\nname", "%s", "\x1b]0;title");
    assert_string_equal(err.where, "evil\\nname");
    assert_string_equal(err.what, "\\x1b]0;title");
}

static void escapes_are_cut_between_characters(void **state)
{
    (void)state;
    for (size_t size = 1; size < 8; size++) {
        char out[8];
        size_t n = lf_escape(out, size, "\x01\xe2\x82\xac");
        assert_int_equal(n, size > 7 ? 7 : size > 4 ? 4 : 0);
        assert_int_equal(strlen(out), n);
    }
    char untouched = 'x';
    assert_int_equal(lf_escape(&untouched, 0, "a"), 0);
    assert_int_equal(untouched, 'x');
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_code_has_its_own_name_and_sign),
        cmocka_unit_test(an_error_reads_place_pointer_and_words),
        cmocka_unit_test(an_error_may_be_absent),
        cmocka_unit_test(an_error_may_be_made_from_itself),
        cmocka_unit_test(long_texts_are_cut_and_terminated),
        cmocka_unit_test(control_characters_are_escaped),
        cmocka_unit_test(escapes_are_cut_between_characters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
