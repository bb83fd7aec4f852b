/* make docs: writes the tables of lf_table_pages into the pages. */
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "tests/docs/tables.h"

static int fail(const char *page, const char *what)
{
    fprintf(stderr, "tables: %s: %s\n", page, what);
    return 1;
}

static int write_page(lf_table_source *source, const char *page)
{
    char *text = NULL, name[128];
    size_t size = 0;
    lf_error err = {0};
    if (lf_file_read(page, NULL, 1 << 22, &text, &size, &err) != LF_OK)
        return fail(page, err.what);
    source->page = text;
    char *filled = lf_tables_fill(source, name, sizeof name);
    int code = filled ? 0 : fail(page, name);
    if (code == 0 && name[0] != '\0') {
        FILE *out = fopen(page, "w");
        if (!out || fputs(filled, out) < 0)
            code = fail(page, "cannot be written");
        if (out && fclose(out) != 0)
            code = fail(page, "cannot be written");
        printf("%s\n", page);
    }
    free(filled);
    lf_free(text);
    return code;
}

/* In the source tree; the folder of the programs. */
int main(int argc, char *argv[])
{
    if (argc != 2)
        return fail("usage", "make_tables FOLDER");
    lf_tables_init();
    lf_table_source source = {.build = argv[1]};
    source.schema = json_load_file("docs/scene.schema.json", JSON_REJECT_DUPLICATES, NULL);
    if (!source.schema)
        return fail("docs/scene.schema.json", "cannot be read");
    char *scene = NULL;
    size_t size = 0;
    lf_error err = {0};
    if (lf_file_read(lf_table_scene_page, NULL, 1 << 22, &scene, &size, &err) != LF_OK)
        return fail(lf_table_scene_page, err.what);
    source.scene_page = scene;
    int code = 0;
    for (int i = 0; lf_table_pages[i] && code == 0; i++)
        code = write_page(&source, lf_table_pages[i]);
    json_decref(source.schema);
    lf_free(scene);
    return code;
}
