/* The manual pages say what the tables of parameters say. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "daemon/output/frames.h"
#include "daemon/output/hologram.h"
#include "daemon/output/options.h"
#include "daemon/output/output.h"
#include "daemon/output/video.h"
#include "daemon/server/methods.h"
#include "daemon/tools/print_check.h"
#include "daemon/tools/render_arguments.h"
#include "daemon/tools/simulate.h"
#include "render/papers/papers.h"

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

/* The line that begins what a page says of an option; NULL = it says nothing. */
static const char *find_option(const char *page, const char *option)
{
    char head[64], line[400];
    const size_t length = (size_t)snprintf(head, sizeof head, "--%s", option);
    for (const char *at = page; (at = strstr(at, ".TP\n"));) {
        at += 4;
        snprintf(line, sizeof line, "%.*s", (int)strcspn(at, "\n"), at);
        for (const char *found = line; (found = strstr(found, head)); found++)
            if (strchr(" ,", found[length]))
                return at;
    }
    return NULL;
}

static const char *word_of(const lf_param *row, int index)
{
    if (row->word_at)
        return row->word_at(index);
    return row->words ? row->words[index] : NULL;
}

/* What --help calls the text, or the words, must follow where the option stands. */
static void check_option(const char *page, const lf_param *row, bool words)
{
    char head[64], argument[32];
    if (row->former)
        return;
    const char *at = find_option(page, row->option);
    const char *end = at ? strstr(at, ".TP") : NULL;
    if (!at)
        fail_msg("--%s is missing", row->option);
    for (int i = 0; words && word_of(row, i); i++) {
        const char *word = strstr(at, word_of(row, i));
        if (!word || (end && word > end))
            fail_msg("--%s: %s is missing", row->option, word_of(row, i));
    }
    if (word_of(row, 0))
        return; /* they stand for what the text is called */
    snprintf(head, sizeof head, "--%s", row->option);
    lf_param_argument(row, argument, sizeof argument);
    at = strstr(at, head) + strlen(head);
    at += strspn(at, " ");
    if (strncmp(at, argument, strlen(argument)) != 0)
        fail_msg("%s: not followed by %s", head, argument);
}

static void every_option_of_a_print_stands_in_the_manual_of_quiltrender(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1"), *guide = read_page("docs/guide/prints.md");
    char head[64];
    for (const lf_param *row = lf_print_params; row->name || row->option;
         row = lf_param_next(row)) {
        if (!row->option)
            continue;
        snprintf(head, sizeof head, "--%s", row->option);
        if (!strstr(guide, head))
            fail_msg("%s is missing in the guide", head);
        check_option(page, row, true);
    }
    for (const lf_param *row = lf_profile_params; row->option; row++)
        check_option(page, row, true);
    check_option(page, lf_check_params, true);
    lf_free(page);
    lf_free(guide);
}

static void every_key_of_a_profile_stands_in_the_manual_of_quiltprint(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltprint.1");
    const lf_param *const tables[] = {lf_profile_rows(LF_PROFILE_LENS),
                                      lf_profile_rows(LF_PROFILE_PRINTER), lf_calibration_rows};
    char name[64];
    for (int i = 0; i < 3; i++)
        for (const lf_param *row = tables[i]; row->name; row++) {
            snprintf(name, sizeof name, " %s", row->name);
            if (!strstr(page, name))
                fail_msg("%s is missing", row->name);
        }
    lf_free(page);
}

static void every_shared_option_stands_in_the_manuals(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1"), *daemon = read_page("docs/man/quiltd.1");
    for (const lf_param *row = lf_option_params; row->option; row = lf_param_next(row)) {
        if (strcmp(row->option, "calibration") != 0)
            check_option(page, row, true);
        if (!lf_param_among(
                row, "panel aov png still quality fit light-paths suffixes target-denoised-error"))
            check_option(daemon, row, false); /* whose page leaves words to the other's */
    }
    for (const lf_param *row = lf_integrator_params(); row->option; row = lf_param_next(row)) {
        check_option(page, row, true);
        assert_null(find_option(daemon, row->option));
    }
    for (const lf_param *row = lf_panel_params; row->option; row++)
        check_option(page, row, true);
    for (const lf_param *row = lf_response_params; row->option; row = lf_param_next(row)) {
        check_option(page, row, true);
        check_option(daemon, row, true);
    }
    assert_null(find_option(page, "calibration"));
    assert_null(find_option(daemon, "panel"));
    lf_free(page);
    lf_free(daemon);
}

static void every_option_of_photos_stands_in_the_manuals(void **state)
{
    (void)state;
    const lf_param *const tables[] = {lf_photo_params, lf_picture_params};
    char *page = read_page("docs/man/quiltrender.1"), *daemon = read_page("docs/man/quiltd.1"),
         *guide = read_page("docs/guide/prints.md");
    for (int i = 0; i < 2; i++)
        for (const lf_param *row = tables[i]; row->option; row++) {
            char head[64];
            snprintf(head, sizeof head, "`--%s ", row->option);
            check_option(page, row, true);
            check_option(daemon, row, false);
            assert_non_null(strstr(guide, head));
        }
    lf_free(page);
    lf_free(daemon);
    lf_free(guide);
}

/* The other way: what is told of is in a table, or the program's own. */
static void the_manual_of_quiltrender_tells_of_no_option_that_is_not_there(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1"), option[64];
    const char *at = strstr(page, ".SS What");
    int n = 0;
    assert_non_null(at);
    while ((at = strstr(at, ".TP\n"))) {
        at = strstr(at, "--") + 2;
        snprintf(option, sizeof option, "%.*s", (int)strcspn(at, " ,\n"), at);
        const lf_param own = {.option = option};
        if (!lf_param_find(lf_print_params, option) && !lf_param_find(lf_check_params, option) &&
            !lf_param_find(lf_profile_params, option) && !lf_param_find(lf_option_params, option) &&
            !lf_param_find(lf_panel_params, option) && !lf_param_find(lf_response_params, option) &&
            !lf_param_find(lf_rgbd_params, option) && !lf_param_find(lf_frames_params, option) &&
            !lf_param_find(lf_video_params, option) && !lf_param_find(lf_photo_params, option) &&
            !lf_param_find(lf_picture_params, option) && !lf_param_find(lf_alone_params, option) &&
            !lf_param_find(lf_integrator_params(), option) &&
            !lf_param_find(lf_standing_params, option) &&
            !lf_param_find(lf_simulate_params, option) && !lf_param_find(lf_state_params, option) &&
            !lf_param_find(lf_hologram_params, option) &&
            !lf_param_among(&own, "passes spp time state state-info stats files plan json "
                                  "task-minutes task-memory read-chart chart-file help completion"))
            fail_msg("--%s is in no table", option);
        n++;
    }
    assert_true(n > 25);
    lf_free(page);
}

static void every_option_of_holograms_stands_in_the_manual_of_quiltrender(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1");
    for (const lf_param *row = lf_hologram_params; row->option; row = lf_param_next(row))
        check_option(page, row, true);
    lf_free(page);
}

static void every_option_of_depth_stands_in_the_manual_of_quiltrender(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1"), *daemon = read_page("docs/man/quiltd.1");
    for (const lf_param *row = lf_rgbd_params; row->name; row++)
        check_option(page, row, true);
    for (const lf_param *row = lf_standing_params; row->name; row++) {
        check_option(page, row, true);
        check_option(daemon, row, false);
    }
    lf_free(page);
    lf_free(daemon);
}

static void every_option_of_sequences_and_videos_stands_in_the_manual_of_quiltrender(void **state)
{
    (void)state;
    char *page = read_page("docs/man/quiltrender.1");
    for (const lf_param *row = lf_frames_params; row->option; row = lf_param_next(row))
        check_option(page, row, true);
    for (const lf_param *row = lf_video_params; row->option; row = lf_param_next(row))
        check_option(page, row, true);
    for (const lf_param *row = lf_simulate_params; row->option; row = lf_param_next(row))
        check_option(page, row, true);
    for (const lf_param *row = lf_state_params; row->option; row = lf_param_next(row))
        check_option(page, row, true);
    lf_free(page);
}

/* The line of a page that lists the kinds names this one. */
static bool is_listed(const char *page, const char *head, const char *name)
{
    const char *at = strstr(page, head);
    char line[256], word[64];
    assert_non_null(at);
    snprintf(line, sizeof line, "|%.*s|", (int)strcspn(at + strlen(head), "\n,"),
             at + strlen(head));
    for (char *c = line; *c != '\0'; c++)
        *c = *c == ' ' || *c == '\n' ? '|' : *c;
    snprintf(word, sizeof word, "|%s|", name);
    return strstr(line, word);
}

static const json_t *parameters_of(const char *method)
{
    int i = 0;
    while (strcmp(lf_method_at(i)->name, method) != 0)
        i++;
    return json_object_get(lf_method_schema(i), "properties");
}

static void every_kind_of_output_stands_in_the_manuals_and_the_schema(void **state)
{
    (void)state;
    char *page = read_page("docs/reference/protocol.md"), *ctl = read_page("docs/man/quiltctl.1");
    const json_t *names = json_object_get(json_object_get(parameters_of("export"), "kind"), "enum");
    const char *kinds = strstr(page, "\n## Export kinds\n");
    char row[64];
    int n = 0;
    assert_non_null(kinds);
    for (; lf_output_kinds[n]; n++) {
        const char *name = lf_output_kinds[n]->name;
        snprintf(row, sizeof row, "\n| `%s` |", name);
        if (!strstr(kinds, row) || !is_listed(ctl, ".B export\n.BR ", name))
            fail_msg("%s is missing", name);
        assert_string_equal(json_string_value(json_array_get(names, (size_t)n)), name);
    }
    assert_string_equal(json_string_value(json_array_get(names, (size_t)n)), "state");
    assert_int_equal(json_array_size(names), n + 1);
    lf_free(page);
    lf_free(ctl);
}

/* A copy (lf_free) of what stands between two texts of a page. */
static char *part_of(const char *page, const char *from, const char *to)
{
    const char *at = strstr(page, from), *end = at ? strstr(at + strlen(from), to) : NULL;
    if (!at || !end)
        fail_msg("%s is missing", from);
    char *part = lf_strdup(at + strlen(from));
    part[end - at - (ptrdiff_t)strlen(from)] = '\0';
    return part;
}

static void every_method_and_its_parameters_stand_in_the_protocol(void **state)
{
    (void)state;
    char *page = read_page("docs/reference/protocol.md"), *manual = read_page("docs/man/quiltd.1");
    char head[64], row[64];
    for (int i = 0; lf_method_at(i); i++) {
        const char *method = lf_method_at(i)->name, *key;
        json_t *properties = json_object_get(lf_method_schema(i), "properties"), *value;
        snprintf(head, sizeof head, "\n### %s\n", method);
        snprintf(row, sizeof row, ".B %s\n", method);
        if (!strstr(page, head) || !strstr(manual, row))
            fail_msg("%s is missing", method);
        if (json_object_size(properties) == 0)
            continue;
        snprintf(head, sizeof head, "<!-- table: method %s -->", method);
        char *table = part_of(page, head, "<!-- end -->");
        json_object_foreach(properties, key, value)
        {
            snprintf(row, sizeof row, "\n| `%s` |", key);
            if (!strstr(table, row))
                fail_msg("%s of %s is missing", key, method);
        }
        lf_free(table);
    }
    lf_free(page);
    lf_free(manual);
}

/* The rows of a table, "a.b" for a key of an object and "a[]" for an element of an array. */
static void check_fields(const char *table, const char *path, const json_t *schema)
{
    const json_t *items = json_object_get(schema, "items");
    json_t *properties = json_object_get(schema, "properties"), *value;
    const char *key;
    char name[128], row[160];
    snprintf(row, sizeof row, "\n| `%s` |", path);
    if (items) {
        snprintf(name, sizeof name, "%s[]", path);
        check_fields(table, name, items);
    } else if (!properties && !strstr(table, row)) {
        fail_msg("%s is missing", path);
    }
    json_object_foreach(properties, key, value)
    {
        snprintf(name, sizeof name, "%s%s%s", path, path[0] ? "." : "", key);
        check_fields(table, name, value);
    }
}

static void every_field_of_status_stands_in_the_protocol(void **state)
{
    (void)state;
    char *page = read_page("docs/reference/protocol.md"),
         *table = part_of(page, "\n## Status fields\n", "\n## ");
    const json_t *status = json_object_get(json_object_get(lf_methods_json(), "status"), "result");
    assert_true(json_object_size(json_object_get(status, "properties")) > 40);
    check_fields(table, "", status);
    lf_free(table);
    lf_free(page);
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_option_of_a_print_stands_in_the_manual_of_quiltrender),
        cmocka_unit_test(every_key_of_a_profile_stands_in_the_manual_of_quiltprint),
        cmocka_unit_test(every_shared_option_stands_in_the_manuals),
        cmocka_unit_test(every_option_of_photos_stands_in_the_manuals),
        cmocka_unit_test(the_manual_of_quiltrender_tells_of_no_option_that_is_not_there),
        cmocka_unit_test(every_option_of_holograms_stands_in_the_manual_of_quiltrender),
        cmocka_unit_test(every_option_of_depth_stands_in_the_manual_of_quiltrender),
        cmocka_unit_test(every_option_of_sequences_and_videos_stands_in_the_manual_of_quiltrender),
        cmocka_unit_test(every_kind_of_output_stands_in_the_manuals_and_the_schema),
        cmocka_unit_test(every_method_and_its_parameters_stand_in_the_protocol),
        cmocka_unit_test(every_field_of_status_stands_in_the_protocol),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
