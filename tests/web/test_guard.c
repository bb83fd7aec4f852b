/* What a request must be: each rule with a request that keeps it and one that breaks it. */
#include "tests/testing.h"

#include "daemon/web/guard.h"

enum { PORT = 8033 };

static lf_guard_request good(void)
{
    return (lf_guard_request){.target = "/", .host = "127.0.0.1:8033", .hosts = 1};
}

static int check(const lf_guard_request *request)
{
    const char *why = NULL;
    lf_error err = {0};
    lf_guard guard;
    lf_assert_ok(lf_guard_init(&guard, PORT, &err), &err);
    int status = lf_guard_check(&guard, request, &why);
    assert_int_equal(status != 0, why ? 1 : 0);
    return status;
}

static void one_host_of_ours_is_needed(void **state)
{
    (void)state;
    static const char *const ours[] = {"localhost:8033", "127.0.0.1:8033", "[::1]:8033"};
    static const char *const others[] = {"evil.test:8033", "localhost",       "localhost:8034",
                                         "LOCALHOST:8033", "localhost.:8033", "127.0.0.1:8033 ",
                                         "127.0.0.2:8033", "localhost:80330", ""};
    lf_guard_request r = good();
    for (size_t i = 0; i < sizeof ours / sizeof ours[0]; i++) {
        r.host = ours[i];
        assert_int_equal(check(&r), 0);
    }
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        r.host = others[i];
        assert_int_equal(check(&r), 421);
    }
    r = good();
    r.hosts = 2;
    assert_int_equal(check(&r), 421);
    r = good();
    r.host = NULL;
    r.hosts = 0;
    assert_int_equal(check(&r), 421);
}

/* The name is looked at before all else: nothing is answered to another one. */
static void the_host_comes_first(void **state)
{
    (void)state;
    lf_guard_request r = good();
    r.host = "evil.test:8033";
    r.origin = "http://evil.test:8033";
    r.origins = 1;
    r.lengths = 2;
    assert_int_equal(check(&r), 421);
}

static void a_public_name_is_reached_by_https_alone(void **state)
{
    (void)state;
    static const struct {
        const char *host, *origin;
        int status;
    } cases[] = {
        {"panel.local", NULL, 0},
        {"panel.local", "https://panel.local", 0},
        {"127.0.0.1:8033", "http://127.0.0.1:8033", 0},
        {"panel.local", "http://panel.local", 403},
        {"panel.local", "https://evil.test", 403},
        {"127.0.0.1:8033", "https://panel.local", 403},
        {"127.0.0.1:8033", "https://127.0.0.1:8033", 403},
        {"panel.local:8033", NULL, 421},
        {"evil.panel.local", NULL, 421},
        {"", NULL, 421},
    };
    lf_error err = {0};
    lf_guard guard;
    const char *why = NULL;
    lf_assert_ok(lf_guard_init(&guard, PORT, &err), &err);
    lf_guard_request r = good();
    r.host = "panel.local";
    assert_int_equal(lf_guard_check(&guard, &r, &why), 421);
    lf_assert_ok(lf_guard_set_public(&guard, "https://panel.local:443", &err), &err);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        r.host = cases[i].host;
        r.origin = cases[i].origin;
        r.origins = r.origin ? 1 : 0;
        assert_int_equal(lf_guard_check(&guard, &r, &why), cases[i].status);
        assert_int_equal(lf_guard_is_public(&guard, &r), strcmp(r.host, "panel.local") == 0);
    }
}

static void a_public_origin_is_https_and_a_name(void **state)
{
    (void)state;
    static const char *const good_ones[] = {"https://a", "https://panel.home.arpa:8443",
                                            "https://localhost:8443", "https://localhost"};
    static const char *const bad[] = {"panel.local",
                                      "http://panel.local",
                                      "https://",
                                      "https://panel.local/",
                                      "https://Panel.local",
                                      "https://a:0",
                                      "https://a:65536",
                                      "https://a:",
                                      "https://a b",
                                      "https://127.0.0.1:8033",
                                      "https://localhost:8033",
                                      "https://.",
                                      "https://.a",
                                      "https://a.",
                                      "https://-a",
                                      "https://a-",
                                      "https://a:08443",
                                      ""};
    lf_guard guard;
    lf_error err = {0};
    lf_assert_ok(lf_guard_init(&guard, PORT, &err), &err);
    for (size_t i = 0; i < sizeof good_ones / sizeof good_ones[0]; i++) {
        lf_assert_ok(lf_guard_set_public(&guard, good_ones[i], &err), &err);
        assert_string_equal(guard.public_origin, good_ones[i]);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(lf_guard_set_public(&guard, bad[i], &err), LF_E_ARG);
    lf_assert_ok(lf_guard_init(&guard, 80, &err), &err);
    lf_assert_status(lf_guard_set_public(&guard, "https://localhost:443", &err), LF_E_ARG, &err);
}

static void an_origin_is_ours_by_the_same_name(void **state)
{
    (void)state;
    static const char *const others[] = {"http://evil.test:8033",
                                         "null",
                                         "http://localhost:8033",
                                         "https://127.0.0.1:8033",
                                         "http://127.0.0.1:8033/",
                                         "http://127.0.0.1",
                                         ""};
    lf_guard_request r = good();
    r.origins = 1;
    r.origin = "http://127.0.0.1:8033";
    assert_int_equal(check(&r), 0);
    r.origins = 2;
    assert_int_equal(check(&r), 403);
    r.origins = 1;
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        r.origin = others[i];
        assert_int_equal(check(&r), 403);
    }
}

static void what_two_readers_understand_differently_is_refused(void **state)
{
    (void)state;
    lf_guard_request r = good();
    r.length = "0";
    r.lengths = 1;
    assert_int_equal(check(&r), 0);
    r.lengths = 2;
    assert_int_equal(check(&r), 400);
    r.lengths = 1;
    r.encoded = true;
    assert_int_equal(check(&r), 400);
    r = good();
    r.encoded = true;
    assert_int_equal(check(&r), 400);
    r = good();
    r.target = "http://127.0.0.1:8033/";
    assert_int_equal(check(&r), 400);
    r = good();
    r.zero = true;
    assert_int_equal(check(&r), 400);
    r = good();
    r.cookie = "a=b";
    r.cookies = 2;
    assert_int_equal(check(&r), 400);
}

static void a_body_is_refused(void **state)
{
    (void)state;
    lf_guard_request r = good();
    r.lengths = 1;
    r.length = "1";
    assert_int_equal(check(&r), 413);
    r.length = "1073741824";
    assert_int_equal(check(&r), 413);
}

static void a_body_has_a_length_within_its_limit(void **state)
{
    (void)state;
    static const struct {
        const char *length;
        int status;
    } rows[] = {{NULL, 411}, {"0", 0},    {"1000", 0}, {"1001", 413}, {"99999999999999999999", 400},
                {"", 400},   {"+1", 400}, {"-1", 400}, {"1,1", 400},  {"0x10", 400}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        lf_guard_request r = good();
        r.takes_body = true;
        r.body_limit = 1000;
        r.too_long = "too long";
        r.length = rows[i].length;
        r.lengths = r.length ? 1 : 0;
        assert_int_equal(check(&r), rows[i].status);
        r.encoded = true; /* a coded body has no length that all readers agree on */
        assert_int_equal(check(&r), 400);
    }
}

/* A page sends its origin with every PUT; the cookie alone may come from anywhere. */
static void a_cookie_writes_only_with_an_origin(void **state)
{
    (void)state;
    lf_guard guard;
    lf_error err = {0};
    char cookie[128], token[64];
    lf_assert_ok(lf_guard_init(&guard, PORT, &err), &err);
    snprintf(cookie, sizeof cookie, "%s=%s", guard.cookie, guard.session.text);
    snprintf(token, sizeof token, "Bearer %s", guard.token.text);
    lf_guard_request r = good();
    assert_false(lf_guard_may_write(&guard, &r));
    r.cookie = cookie;
    r.cookies = 1;
    assert_false(lf_guard_may_write(&guard, &r));
    r.origin = "http://127.0.0.1:8033";
    r.origins = 1;
    assert_true(lf_guard_may_write(&guard, &r));
    r.cookie = NULL;
    r.cookies = 0;
    assert_false(lf_guard_may_write(&guard, &r));
    r.authorization = token;
    r.authorizations = 1;
    assert_true(lf_guard_may_write(&guard, &r));
    r.origins = 0;
    assert_true(lf_guard_may_write(&guard, &r));
}

static void a_secret_equals_itself_alone(void **state)
{
    (void)state;
    lf_secret a, b;
    lf_error err = {0};
    lf_assert_ok(lf_secret_draw(&a, &err), &err);
    lf_assert_ok(lf_secret_draw(&b, &err), &err);
    assert_int_equal(strlen(a.text), LF_SECRET_DIGITS);
    assert_int_equal(strspn(a.text, "0123456789abcdef"), LF_SECRET_DIGITS);
    assert_string_not_equal(a.text, b.text);
    assert_true(lf_secret_equals(&a, a.text, LF_SECRET_DIGITS));
    assert_false(lf_secret_equals(&a, b.text, LF_SECRET_DIGITS));
    assert_false(lf_secret_equals(&a, a.text, LF_SECRET_DIGITS - 1));
    assert_false(lf_secret_equals(&a, "", 0));
    char twice[2 * LF_SECRET_DIGITS + 1];
    snprintf(twice, sizeof twice, "%s%s", a.text, a.text);
    assert_false(lf_secret_equals(&a, twice, 2 * LF_SECRET_DIGITS));
    for (int i = 0; i < LF_SECRET_DIGITS; i++) {
        char other[LF_SECRET_DIGITS + 1];
        memcpy(other, a.text, sizeof other);
        other[i] ^= 1;
        assert_false(lf_secret_equals(&a, other, LF_SECRET_DIGITS));
    }
}

static void the_cookie_is_found_among_others(void **state)
{
    (void)state;
    lf_guard guard;
    lf_error err = {0};
    char text[256];
    lf_guard_request r = good();
    lf_assert_ok(lf_guard_init(&guard, PORT, &err), &err);
    static const struct {
        const char *before, *between, *after;
        bool found;
    } rows[] = {{"", "=", "", true},
                {"a=b; ", "=", "", true},
                {"", "=", "; c=d", true},
                {"x", "=", "", false},
                {"", "=", "0", false},
                {"", " ", "", false},
                {"a=", "=", "", false},
                {"", "=0", "", false},
                {"a=b, ", "=", "", false},
                /* a server on another port has set the first, for one path */
                {"quiltweb-8033=x; ", "=", "", true},
                {"", "=", "; quiltweb-8033=x", true}};
    r.cookie = text;
    r.cookies = 1;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        snprintf(text, sizeof text, "%s%s%s%s%s", rows[i].before, guard.cookie, rows[i].between,
                 guard.session.text, rows[i].after);
        assert_int_equal(lf_guard_has_cookie(&guard, &r), rows[i].found);
    }
    /* the token is no cookie, and the cookie no token */
    snprintf(text, sizeof text, "%s=%s", guard.cookie, guard.token.text);
    assert_false(lf_guard_has_cookie(&guard, &r));
    snprintf(text, sizeof text, "Bearer %s", guard.session.text);
    r.authorization = text;
    assert_false(lf_guard_has_token(&guard, &r));
    snprintf(text, sizeof text, "Bearer %s", guard.token.text);
    assert_true(lf_guard_has_token(&guard, &r));
}

static void a_page_connects_with_its_cookie_and_a_program_with_the_token(void **state)
{
    (void)state;
    lf_guard guard;
    lf_error err = {0};
    char cookie[128], token[64];
    lf_assert_ok(lf_guard_init(&guard, PORT, &err), &err);
    snprintf(cookie, sizeof cookie, "%s=%s", guard.cookie, guard.session.text);
    snprintf(token, sizeof token, "Bearer %s", guard.token.text);
    lf_guard_request page = good(), program = good();
    page.origin = "http://127.0.0.1:8033";
    page.origins = 1;
    assert_false(lf_guard_may_connect(&guard, &page));
    page.cookie = cookie;
    page.cookies = 1;
    assert_true(lf_guard_may_connect(&guard, &page));
    assert_false(lf_guard_may_connect(&guard, &program));
    program.cookie = cookie; /* without an origin nobody knows whose page it is */
    program.cookies = 1;
    assert_false(lf_guard_may_connect(&guard, &program));
    program.authorization = token;
    program.authorizations = 1;
    assert_true(lf_guard_may_connect(&guard, &program));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_host_of_ours_is_needed),
        cmocka_unit_test(the_host_comes_first),
        cmocka_unit_test(a_public_name_is_reached_by_https_alone),
        cmocka_unit_test(a_public_origin_is_https_and_a_name),
        cmocka_unit_test(an_origin_is_ours_by_the_same_name),
        cmocka_unit_test(what_two_readers_understand_differently_is_refused),
        cmocka_unit_test(a_body_is_refused),
        cmocka_unit_test(a_body_has_a_length_within_its_limit),
        cmocka_unit_test(a_cookie_writes_only_with_an_origin),
        cmocka_unit_test(a_secret_equals_itself_alone),
        cmocka_unit_test(the_cookie_is_found_among_others),
        cmocka_unit_test(a_page_connects_with_its_cookie_and_a_program_with_the_token),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
