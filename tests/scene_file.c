#include "tests/scene_file.h"

#include "render/render.h"
#include "tests/testing.h"

/* What the test has been given, so that it need not free it. */
typedef struct kept_text {
    struct kept_text *next;
    char *text;
} kept_text;

static kept_text *kept;

json_t *lf_test_json(const char *name, const char *text)
{
    char *copy = strdup(text);
    assert_non_null(copy);
    for (char *c = copy; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    json_error_t err;
    json_t *doc = json_loads(copy, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &err);
    free(copy);
    if (!doc)
        fail_msg("%s: line %d: %s", name, err.line, err.text);
    return doc;
}

json_t *lf_test_scene_document(const char *name)
{
    char file[NAME_MAX];
    snprintf(file, sizeof file, "tests/scenes/%s.json", name);
    const char *path = lf_test_source(file);
    json_error_t err;
    json_t *doc = json_load_file(path, JSON_REJECT_DUPLICATES, &err);
    if (!doc)
        fail_msg("%s: line %d: %s", path, err.line, err.text);
    return doc;
}

/* Takes the document. */
static const char *text_of(json_t *doc)
{
    kept_text *one = malloc(sizeof *one);
    assert_non_null(one);
    *one = (kept_text){kept, json_dumps(doc, 0)};
    assert_non_null(one->text);
    json_decref(doc);
    kept = one;
    return one->text;
}

const char *lf_test_scene_text(const char *name)
{
    return text_of(lf_test_scene_document(name));
}

const char *lf_test_scene_patched(const char *name, const char *patch, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, patch);
    int length = vasprintf(&text, patch, args);
    va_end(args);
    assert_true(length >= 0);
    json_t *changes = lf_test_json(name, text);
    json_t *doc = lf_test_scene_document(name);
    if (!json_is_object(changes) || !lf_json_merge_into(doc, changes))
        fail_msg("%s: not a patch: %s", name, text);
    json_decref(changes);
    free(text);
    return text_of(doc);
}

const char *lf_test_scene_views(const char *name, int views)
{
    return lf_test_scene_patched(name, "{'camera': {'views': %d}}", views);
}
