/* The page needs nothing from elsewhere, and nothing that its policy forbids. */
#include "tests/testing.h"

#include "daemon/web/pages.h"

enum { MOST_BYTES = 200000 };

static const char *text_of(const lf_page *page)
{
    static char text[MOST_BYTES + 1];
    assert_true(page->n <= MOST_BYTES);
    memcpy(text, page->data, page->n);
    text[page->n] = '\0';
    assert_int_equal(strlen(text), page->n);
    return text;
}

static void all_pages_are_small(void **state)
{
    (void)state;
    size_t n = 0;
    for (int i = 0; lf_page_at(i); i++)
        n += lf_page_at(i)->n;
    assert_in_range(n, 1, MOST_BYTES);
}

static void nothing_comes_from_elsewhere(void **state)
{
    (void)state;
    static const char *const others[] = {
        "https://",  "//cdn",   "src=\"//", "url(",        "@import", "eval(",
        "innerHTML", " style=", "onclick=", "javascript:", "<style"};
    for (int i = 0; lf_page_at(i); i++) {
        const char *text = text_of(lf_page_at(i)), *name = lf_page_at(i)->path;
        for (size_t k = 0; k < sizeof others / sizeof others[0]; k++)
            if (strstr(text, others[k]))
                fail_msg("%s has %s", name, others[k]);
        /* a name of XML is no address */
        const char *http = strstr(text, "http:");
        if (http && strncmp(http, "http://www.w3.org/", 18) != 0)
            fail_msg("%s has an address", name);
    }
}

/* Each attribute and import names a page that is there. */
static void what_pages_name_is_there(void **state)
{
    (void)state;
    static const char *const marks[] = {" src=\"", " href=\"", " from \"."};
    int n = 0;
    for (int i = 0; lf_page_at(i); i++) {
        const char *text = text_of(lf_page_at(i));
        for (size_t k = 0; k < sizeof marks / sizeof marks[0]; k++)
            for (const char *at = text; (at = strstr(at, marks[k]));) {
                char path[64];
                at += strlen(marks[k]);
                snprintf(path, sizeof path, "%.*s", (int)strcspn(at, "\""), at);
                if (!lf_page_find(path))
                    fail_msg("%s names %s", lf_page_at(i)->path, path);
                n++;
            }
    }
    assert_true(n >= 6);
    assert_null(lf_page_find("/other.js"));
}

/* A script in the page itself would not run. */
static void scripts_are_files(void **state)
{
    (void)state;
    const char *text = text_of(lf_page_find("/"));
    int n = 0;
    for (const char *at = text; (at = strstr(at, "<script")); n++) {
        at = strchr(at, '>');
        assert_non_null(at);
        assert_memory_equal(at, "></script>", 10);
    }
    assert_int_equal(n, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_pages_are_small),
        cmocka_unit_test(nothing_comes_from_elsewhere),
        cmocka_unit_test(what_pages_name_is_there),
        cmocka_unit_test(scripts_are_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
