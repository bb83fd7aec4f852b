/* Pages of docs/reference have the tables that the programs' own make. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "render/scene/camera.h"
#include "tests/docs/tables.h"

static lf_table_source source;
static char build[PATH_MAX];

static char *read_page(const char *name)
{
    char *text = NULL;
    size_t size = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(lf_test_source(name), NULL, 1 << 22, &text, &size, &err), &err);
    return text;
}

static void every_table_of_a_page_is_up_to_date(void **state)
{
    (void)state;
    char name[128];
    for (int i = 0; lf_table_pages[i]; i++) {
        char *text = read_page(lf_table_pages[i]);
        source.page = text;
        char *filled = lf_tables_fill(&source, name, sizeof name);
        if (!filled)
            fail_msg("%s: table \"%s\" has no end or is not known", lf_table_pages[i], name);
        if (name[0] != '\0')
            fail_msg("%s: table \"%s\" is not up to date: run `make docs`", lf_table_pages[i],
                     name);
        free(filled);
        lf_free(text);
    }
}

static void check_present(const char *page, const char *family, const char *(*name_at)(int index))
{
    char *text = read_page(page), marker[128];
    for (int i = 0; name_at(i); i++) {
        snprintf(marker, sizeof marker, "<!-- table: %s %s -->\n", family, name_at(i));
        if (!strstr(text, marker))
            fail_msg("%s: table \"%s %s\" is missing", page, family, name_at(i));
    }
    lf_free(text);
}

static void every_table_is_on_its_page(void **state)
{
    (void)state;
    check_present("docs/reference/protocol.md", "method", lf_table_method_at);
    check_present("docs/reference/options.md", "options", lf_table_options_at);
    check_present("docs/reference/scene-format.md", "scene", lf_table_scene_at);
}

/* Every option that --help lists has a row. */
static void every_option_of_help_is_on_the_page(void **state)
{
    (void)state;
    static const char *const programs[] = {"quiltd", "quiltrender"};
    char *page = read_page("docs/reference/options.md"), line[PATH_MAX + 64], head[200];
    for (int i = 0; i < 2; i++) {
        snprintf(line, sizeof line, "'%s/%s' --help", build, programs[i]);
        FILE *help = popen(line, "r");
        int n = 0;
        assert_non_null(help);
        while (fgets(line, sizeof line, help)) {
            if (strncmp(line, "  --", 4) != 0)
                continue;
            snprintf(head, sizeof head, "\n| `%.*s", (int)strcspn(line + 2, " \n["), line + 2);
            if (!strstr(page, head))
                fail_msg("docs/reference/options.md: %s of %s is missing", head + 4, programs[i]);
            n++;
        }
        assert_int_equal(pclose(help), 0);
        assert_true(n > 10);
    }
    lf_free(page);
}

/* Keys of the camera are described twice, for camera.set and for the schema. */
static void the_schema_describes_the_camera_as_its_rows_do(void **state)
{
    (void)state;
    const json_t *keys = json_object_get(
        json_object_get(json_object_get(source.schema, "$defs"), "camera"), "properties");
    for (const lf_param *row = lf_camera_params; row->name; row++) {
        const json_t *key = json_object_get(keys, row->name);
        const char *text = json_string_value(json_object_get(key, "description"));
        if (!text || strcmp(text, row->about) != 0)
            fail_msg("docs/scene.schema.json: camera.%s is not described as \"%s\"", row->name,
                     row->about);
    }
}

static void a_changed_cell_is_found(void **state)
{
    (void)state;
    char name[128];
    char *text = read_page("docs/reference/protocol.md"), *range = strstr(text, "-89 to 89");
    assert_non_null(range);
    range[1] = '9';
    source.page = text;
    char *filled = lf_tables_fill(&source, name, sizeof name);
    assert_string_equal(name, "method scene.load");
    assert_non_null(strstr(filled, "-89 to 89"));
    free(filled);
    source.page = "<!-- table: method none -->\n<!-- end -->\n";
    assert_null(lf_tables_fill(&source, name, sizeof name));
    assert_string_equal(name, "method none");
    lf_free(text);
}

static int begin(void **state)
{
    (void)state;
    snprintf(build, sizeof build, "%s", lf_test_built(""));
    source.build = build;
    source.schema =
        json_load_file(lf_test_source("docs/scene.schema.json"), JSON_REJECT_DUPLICATES, NULL);
    source.scene_page = read_page(lf_table_scene_page);
    lf_tables_init();
    return source.schema ? 0 : -1;
}

static int end(void **state)
{
    (void)state;
    json_decref(source.schema);
    lf_free((char *)(uintptr_t)source.scene_page);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_table_of_a_page_is_up_to_date),
        cmocka_unit_test(every_table_is_on_its_page),
        cmocka_unit_test(every_option_of_help_is_on_the_page),
        cmocka_unit_test(the_schema_describes_the_camera_as_its_rows_do),
        cmocka_unit_test(a_changed_cell_is_found),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
