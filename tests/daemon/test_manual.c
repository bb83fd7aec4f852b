/* The manual pages say what the tables of parameters say. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/quilt.h"

/* A manual page without roff's backslashes, quotes and font letters, as it would be read. */
static char *read_page(const char *name)
{
    char *text = NULL;
    size_t size = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(lf_test_source(name), NULL, 1 << 20, &text, &size, &err), &err);
    char *out = text;
    for (const char *c = text; *c != '\0'; c++)
        if (c[0] == '\\' && c[1] == 'f')
            c += 2;
        else if (*c != '\\' && *c != '"')
            *out++ = *c;
    *out = '\0';
    return text;
}

/* The words of a row must follow where the option stands. */
static void check_words(const lf_param *row, const char *at)
{
    const char *end = strstr(at, ".TP");
    for (int i = 0; row->words && row->words[i]; i++) {
        const char *word = strstr(at, row->words[i]);
        if (!word || (end && word > end))
            fail_msg("--%s: %s is missing", row->option, row->words[i]);
    }
}

static void every_option_of_a_print_stands_in_the_manual_of_quiltrender(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1"), *guide = read_page("docs/print.md");
    char head[64];
    for (const lf_param *row = lf_print_params; row->name || row->option; row++) {
        if (!row->option)
            continue;
        snprintf(head, sizeof head, "--%s", row->option);
        const char *at = strstr(page, head);
        if (!at || !strstr(guide, head))
            fail_msg("%s is missing", head);
        check_words(row, at);
    }
    lf_free(page);
    lf_free(guide);
}

/* The other way: what stands under Prints is in the table. */
static void the_manual_tells_of_no_option_of_prints_that_is_not_there(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1");
    char *at = strstr(page, ".SS Prints");
    assert_non_null(at);
    char *end = strstr(at + 1, ".SS ");
    int n = 0;
    assert_non_null(end);
    *end = '\0';
    while ((at = strstr(at, ".TP\n"))) {
        at = strstr(at, "--") + 2;
        const size_t length = strcspn(at, " \n");
        const lf_param *row = lf_print_params;
        while (row->help || row->name)
            if (row->option && strlen(row->option) == length &&
                strncmp(row->option, at, length) == 0)
                break;
            else
                row++;
        if (!row->option)
            fail_msg("--%.*s is in no table", (int)length, at);
        n++;
    }
    assert_true(n > 10);
    lf_free(page);
}

static void every_key_of_a_print_stands_in_the_manual_of_quiltd(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltd.1");
    const char *at = strstr(page, "a print\n");
    char word[64];
    assert_non_null(at);
    for (const lf_param *row = lf_print_params; row->name || row->option; row++) {
        snprintf(word, sizeof word, " %s ", row->name);
        const char *found = row->name ? strstr(at, word) : at;
        if (!found || found > at + 500)
            fail_msg("%s is missing", row->name);
    }
    lf_free(page);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_option_of_a_print_stands_in_the_manual_of_quiltrender),
        cmocka_unit_test(the_manual_tells_of_no_option_of_prints_that_is_not_there),
        cmocka_unit_test(every_key_of_a_print_stands_in_the_manual_of_quiltd),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
