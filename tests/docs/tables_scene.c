/* Keys of scene files: ranges and defaults from the tables that they are read by, where there are
 * such tables; all else from the schema. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "render/import/scene/member_read.h"
#include "render/render.h"
#include "render/scene/camera.h"
#include "render/transport/light/light_kind.h"
#include "render/transport/surface/surface.h"
#include "tests/docs/tables.h"

enum { MOST_PATH = 160 };

/* Tables, and where their objects are in the schema: one object, or variants of one. */
static const struct scene_table {
    const char *name, *path;
    const char *of; /* what a column that tells variants apart is called; NULL: there is none */
} scene_tables[] = {
    {"document", "properties", NULL},
    {"camera", "$defs/camera/properties", NULL},
    {"from", "$defs/camera/properties/from/properties", NULL},
    {"track", "$defs/views_on_a_track/properties/track/properties", NULL},
    {"grid", "$defs/views_in_a_grid/properties/grid/properties", NULL},
    {"path", "$defs/views_on_a_path/properties/path/properties", NULL},
    {"circle", "$defs/views_in_a_circle/properties/circle/properties", NULL},
    {"view", "$defs/view_camera/properties", NULL},
    {"film", "properties/film/properties", NULL},
    {"render", "properties/render/properties", NULL},
    {"backdrop", "properties/backdrop/anyOf/1/properties", NULL},
    {"transform", "$defs/transform/anyOf", NULL},
    {"volume", "$defs/volume/anyOf", "of"},
    {"emission", "$defs/volume/anyOf/0/properties/emission/properties", NULL},
    {"velocity", "$defs/volume/anyOf/0/properties/velocity/anyOf/1/properties", NULL},
    {"sequence", "$defs/sequence/properties", NULL},
    {"animation", "$defs/animation/properties", NULL},
    {"keyframes", "$defs/keyed/properties", NULL},
    {"mesh", "$defs/mesh/properties", NULL},
    {"material", "$defs/material/anyOf", "of"},
    {"texture", "$defs/picture/properties", NULL},
    {"texture transform", "$defs/picture_transform/properties", NULL},
    {"light", "$defs/light/anyOf", "type"},
};
enum { N_TABLES = sizeof scene_tables / sizeof *scene_tables };

const char *lf_table_scene_at(int index)
{
    return index < N_TABLES ? scene_tables[index].name : NULL;
}

/* ------------------------------------------------------------------------------------ schema -- */

/* "$defs/volume/anyOf/0/properties" */
static json_t *node_at(const json_t *root, const char *path)
{
    const json_t *node = root;
    while (*path != '\0') {
        char part[MOST_PATH];
        const size_t length = strcspn(path, "/");
        snprintf(part, sizeof part, "%.*s", (int)length, path);
        path += length + (path[length] == '/');
        node = json_is_array(node) ? json_array_get(node, (size_t)atoi(part))
                                   : json_object_get(node, part);
    }
    return (json_t *)(uintptr_t)node;
}

static const char *ref_of(const json_t *node)
{
    const char *ref = json_string_value(json_object_get(node, "$ref"));
    return ref ? ref + strlen("#/$defs/") : NULL;
}

static const json_t *def(const json_t *root, const char *name)
{
    return json_object_get(json_object_get(root, "$defs"), name);
}

/* A member of a node, of what it refers to, or of the first of its alternatives that has it. */
static const json_t *member(const json_t *root, const json_t *node, const char *name)
{
    const json_t *own = json_object_get(node, name);
    return own || !ref_of(node) ? own : member(root, def(root, ref_of(node)), name);
}

static bool is_keyed(const json_t *node)
{
    return ref_of(node) && strcmp(ref_of(node), "keyed") == 0;
}

/* The former name of a key, which the page does not list. */
static bool is_former(const json_t *node)
{
    return json_is_true(json_object_get(node, "deprecated"));
}

static bool is_required(const json_t *variant, const char *key)
{
    size_t i;
    json_t *word;
    json_array_foreach(json_object_get(variant, "required"), i, word)
    {
        if (strcmp(json_string_value(word), key) == 0)
            return true;
    }
    return false;
}

/* ------------------------------------------------------------------------------------- cells -- */

static bool is_type(const json_t *node, const char *type)
{
    const char *own = json_string_value(json_object_get(node, "type"));
    return own && strcmp(own, type) == 0;
}

/* What the page calls a definition by a word of its own. */
static const char *named_type(const char *ref)
{
    static const char *const names[][2] = {
        {"unit_colour", "colour"}, {"radiance", "colour"},    {"mean_free_path", "colour"},
        {"point", "point"},        {"plain_point", "point"},  {"transform", "transform"},
        {"picture", "texture"},    {"normal_map", "texture"}, {"glowing_picture", "texture"},
        {"view_camera", "camera"}};
    for (size_t i = 0; ref && i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i][0], ref) == 0)
            return names[i][1];
    return NULL;
}

static const char *text_type(const json_t *node)
{
    switch (json_integer_value(json_object_get(node, "maxLength"))) {
    case 128:
        return "name";
    case 256:
        return "grid";
    case 4095:
        return "file";
    default:
        return "text";
    }
}

static void type_of(const json_t *root, const json_t *node, char *buf, size_t size);

/* The types of all alternatives, each once; a number or three of them: a colour. */
static void type_of_any(const json_t *root, const json_t *any, char *buf, size_t size)
{
    size_t i, used = 0;
    json_t *each;
    buf[0] = '\0';
    json_array_foreach(any, i, each)
    {
        char one[64];
        if (is_keyed(each))
            continue;
        type_of(root, each, one, sizeof one);
        if (!strstr(buf, one) && used < size)
            used += (size_t)snprintf(buf + used, size - used, "%s%s", used > 0 ? " or " : "", one);
    }
    if (strcmp(buf, "number or 3 numbers") == 0)
        snprintf(buf, size, "colour");
}

static void type_of(const json_t *root, const json_t *node, char *buf, size_t size)
{
    const json_t *any = json_object_get(node, "anyOf"), *items = json_object_get(node, "items");
    const int least = (int)json_integer_value(json_object_get(node, "minItems"));
    const char *ref = ref_of(node), *named = named_type(ref);
    if (named)
        snprintf(buf, size, "%s", named);
    else if (ref)
        type_of(root, def(root, ref), buf, size);
    else if (any)
        type_of_any(root, any, buf, size);
    else if (json_object_get(node, "enum") || json_object_get(node, "const"))
        snprintf(buf, size, "word");
    else if (is_type(node, "string"))
        snprintf(buf, size, "%s", text_type(node));
    else if (is_type(node, "array") && least > 1 &&
             json_equal(json_object_get(node, "maxItems"), json_object_get(node, "minItems")))
        snprintf(buf, size, "%d numbers", least);
    else if (is_type(node, "array"))
        snprintf(buf, size, "list%s%s", named_type(ref_of(items)) ? " of " : "",
                 named_type(ref_of(items)) ? "cameras" : "");
    else
        snprintf(buf, size, "%s", json_string_value(json_object_get(node, "type")));
}

/* ".exr, .hdr" of "\.([eE][xX][rR]|[hH][dD][rR])$" */
static void print_endings(const char *pattern, FILE *out)
{
    char word[16] = "";
    size_t n = 0, optional = 0;
    bool first = true;
    for (const char *c = pattern + strspn(pattern, "\\.("); *c != '\0'; c++) {
        if (*c == '|' || *c == ')' || *c == '$') {
            for (int with = optional > 0 ? 0 : 1; with < 2 && n > 0; with++, first = false) {
                fprintf(out, "%s.", first ? "" : ", ");
                for (size_t i = 0; i < n; i++)
                    if (with || i != optional)
                        fputc(word[i], out);
            }
            n = optional = 0;
        } else if (*c == '[' && n < sizeof word) {
            word[n++] = c[1];
            c += strcspn(c, "]");
        } else if (*c == '?') {
            optional = n - 1;
        } else if (n < sizeof word) {
            word[n++] = *c;
        }
    }
}

static void print_words(const json_t *words, FILE *out)
{
    size_t i;
    json_t *word;
    json_array_foreach(words, i, word)
    {
        fprintf(out, "%s`\"%s\"`", i > 0 ? ", " : "", json_string_value(word));
    }
}

static void print_span(double low, double high, FILE *out)
{
    if (low == -high && low < 0.0) {
        fputs("±", out);
        lf_table_number(high, out);
        return;
    }
    lf_table_number(low, out);
    if (low == high)
        return;
    fputs(" to ", out);
    lf_table_number(high, out);
}

static void print_range(const json_t *root, const json_t *node, FILE *out);

/* Those of all alternatives, each once. */
static void print_range_of_any(const json_t *root, const json_t *any, FILE *out)
{
    size_t i, used = 0;
    json_t *each;
    char whole[400] = "";
    json_array_foreach(any, i, each)
    {
        char *one = NULL;
        size_t size;
        FILE *to = open_memstream(&one, &size);
        if (!is_keyed(each) && !(named_type(ref_of(each)) && i > 0))
            print_range(root, each, to);
        fclose(to);
        if (size > 0 && !strstr(whole, one) && used < sizeof whole)
            used += (size_t)snprintf(whole + used, sizeof whole - used, "%s%s",
                                     used > 0 ? "; " : "", one);
        free(one);
    }
    fputs(whole, out);
}

static void print_range(const json_t *root, const json_t *node, FILE *out)
{
    const json_t *any = json_object_get(node, "anyOf"), *items = json_object_get(node, "items");
    const json_t *low = json_object_get(node, "minimum"), *high = json_object_get(node, "maximum");
    const json_t *words = json_object_get(node, "enum"), *only = json_object_get(node, "const");
    const json_t *most = json_object_get(node, "maxItems"),
                 *least = json_object_get(node, "minItems");
    const char *pattern = json_string_value(json_object_get(node, "pattern")), *ref = ref_of(node);
    if (ref && strcmp(ref, "transform") != 0 && strcmp(ref, "instances") != 0)
        print_range(root, def(root, ref), out);
    else if (any)
        print_range_of_any(root, any, out);
    else if (words)
        print_words(words, out);
    else if (only)
        fprintf(out, "`\"%s\"`", json_string_value(only));
    else if (low && high)
        print_span(json_number_value(low), json_number_value(high), out);
    else if (pattern)
        print_endings(pattern, out);
    else if (items && least && most && !json_equal(least, most))
        fprintf(out, "%d to %d", (int)json_integer_value(least), (int)json_integer_value(most));
    else if (items && json_equal(least, most))
        print_range(root, items, out);
    else if (most)
        fprintf(out, "at most %d", (int)json_integer_value(most));
    else if (json_object_get(node, "maxProperties"))
        fprintf(out, "at most %d", (int)json_integer_value(json_object_get(node, "maxProperties")));
}

static void print_json(const json_t *value, FILE *out)
{
    size_t i;
    json_t *each;
    if (json_is_string(value))
        fprintf(out, "`\"%s\"`", json_string_value(value));
    else if (json_is_boolean(value))
        fputs(json_is_true(value) ? "true" : "false", out);
    else if (json_is_number(value))
        lf_table_number(json_number_value(value), out);
    json_array_foreach(value, i, each)
    {
        fputs(i > 0 ? " " : "", out);
        print_json(each, out);
    }
}

/* -------------------------------------------------------------------------- rows of lf_param -- */

static bool is_three(const lf_param *row)
{
    return row->type == LF_PARAM_POINT || row->type == LF_PARAM_DIRECTION ||
           row->type == LF_PARAM_COLOUR;
}

/* Whether a row says what its key is where nothing is said. NULL: it does not. */
static bool has_initial(const lf_param *row)
{
    if (!row || row->exclusive || row->type == LF_PARAM_FILE)
        return false;
    return is_three(row) || row->words || row->type == LF_PARAM_SWITCH ||
           (row->initial >= row->low && row->initial <= row->high);
}

static void print_initial(const lf_param *row, FILE *out)
{
    const bool grey = row->type == LF_PARAM_COLOUR && row->point[0] == row->point[1] &&
                      row->point[1] == row->point[2];
    for (int i = 0; is_three(row) && i < (grey ? 1 : 3); i++) {
        fputs(i > 0 ? " " : "", out);
        lf_table_number(row->point[i], out);
    }
    if (is_three(row))
        return;
    if (row->words && row->type != LF_PARAM_WHOLE)
        fprintf(out, "`\"%s\"`", row->words[(int)row->initial]);
    else if (row->type == LF_PARAM_SWITCH)
        fputs(row->initial != 0.0 ? "true" : "false", out);
    else
        lf_table_number(row->initial, out);
}

static bool has_span(const lf_param *row)
{
    return row->high > row->low && !row->words && row->type != LF_PARAM_SWITCH &&
           row->type != LF_PARAM_FILE;
}

/* -------------------------------------------------------------------------------------- rows -- */

static void print_cells(const lf_table_source *source, const json_t *node, const lf_param *row,
                        const char *needed, FILE *out)
{
    char type[128];
    const json_t *root = source->schema, *unit = member(root, node, "unit"),
                 *value = member(root, node, "default");
    const char *text = json_string_value(member(root, node, "description"));
    char kept[1000], in_brackets[1000] = "";
    type_of(root, node, type, sizeof type);
    fprintf(out, "%s | ", type);
    if (row && has_span(row))
        print_span(row->low, row->high, out);
    else
        print_range(root, node, out);
    if (unit)
        fprintf(out, " %s", json_string_value(unit));
    fputs(" | ", out);
    text = row && row->about ? row->about : text ? text : "";
    if (!value && !has_initial(row))
        text = lf_table_default(text, kept, in_brackets, sizeof kept);
    if (needed[0] != '\0')
        fputs(needed, out);
    else if (has_initial(row))
        print_initial(row, out);
    else if (value)
        print_json(value, out);
    else
        lf_table_text(source, in_brackets, NULL, out);
    fputs(" | ", out);
    lf_table_text(source, text, member(root, node, "enum"), out);
    fputs(" |\n", out);
}

static const lf_param *row_in(const lf_param *rows, const char *key)
{
    for (; rows && rows->name; rows++)
        if (strcmp(rows->name, key) == 0)
            return rows;
    return NULL;
}

/* ---------------------------------------------------------------------------------- variants -- */

static const char *const letters[] = {
    [0] = "diffuse", [1] = "conductor", [2] = "plastic", [3] = "principled"};

/* The row of a surface's key, and the kinds that have it: "c p l"; "all". */
static const lf_param *surface_row(const char *key, char *of, size_t size)
{
    const lf_param *row = NULL;
    size_t used = 0, n = 0;
    of[0] = '\0';
    for (int i = 0; lf_surface_kinds[i]; i++)
        for (const lf_param *const *at = lf_surface_kinds[i]->keys; *at; at++)
            if (strcmp((*at)->name, key) == 0) {
                used += (size_t)snprintf(of + used, size - used, "%s%s", used > 0 ? ", " : "",
                                         lf_surface_kinds[i]->name);
                row = *at;
                n++;
            }
    if (n == 0 || n == sizeof letters / sizeof *letters)
        snprintf(of, size, "all");
    return row;
}

static void print_materials(const lf_table_source *source, const json_t *variants, FILE *out)
{
    json_t *done = json_object(), *variant, *node;
    const char *key;
    char of[80];
    size_t i;
    json_array_foreach(variants, i, variant)
    {
        json_object_foreach(json_object_get(variant, "properties"), key, node)
        {
            if (json_object_get(done, key))
                continue;
            const lf_param *row = surface_row(key, of, sizeof of);
            json_object_set_new(done, key, json_true());
            fprintf(out, "| `%s` | %s | ", key, of);
            print_cells(source, node, row, "", out);
        }
    }
    json_decref(done);
}

static const char *kind_of(const json_t *variant)
{
    const json_t *type = json_object_get(json_object_get(variant, "properties"), "type");
    return json_string_value(json_object_get(type, "const"));
}

static const lf_param *light_row(const char *kind, const char *key)
{
    for (int i = 0; lf_light_kinds[i]; i++)
        if (strcmp(lf_light_kinds[i]->name, kind) == 0)
            return row_in(lf_light_kinds[i]->keys, key);
    return NULL;
}

/* "required", or of the keys of two ways to say it "this or `power`". */
static void need(const json_t *variants, const char *kind, const char *key, char *buf, size_t size)
{
    size_t i, n = 0, n_needed = 0;
    json_t *variant;
    const char *other = NULL;
    json_array_foreach(variants, i, variant)
    {
        if (strcmp(kind_of(variant), kind) != 0)
            continue;
        n++;
        n_needed += is_required(variant, key);
        if (!is_required(variant, key))
            other = json_string_value(json_array_get(json_object_get(variant, "required"), 1));
    }
    buf[0] = '\0';
    if (n_needed == n)
        snprintf(buf, size, "required");
    else if (n_needed > 0 && other)
        snprintf(buf, size, "this or `%s`", other);
}

static void print_lights(const lf_table_source *source, const json_t *variants, FILE *out)
{
    json_t *done = json_object(), *variant, *node;
    char at[80], needed[80];
    const char *key, *last = "";
    size_t i;
    json_array_foreach(variants, i, variant)
    {
        const char *kind = kind_of(variant);
        json_object_foreach(json_object_get(variant, "properties"), key, node)
        {
            snprintf(at, sizeof at, "%s %s", kind, key);
            if (json_object_get(done, at) || strcmp(key, "type") == 0)
                continue;
            json_object_set_new(done, at, json_true());
            fprintf(out, "| %s%s%s | `%s` | ", strcmp(last, kind) != 0 ? "`" : "",
                    strcmp(last, kind) != 0 ? kind : "", strcmp(last, kind) != 0 ? "`" : "", key);
            last = kind;
            need(variants, kind, key, needed, sizeof needed);
            print_cells(source, node, light_row(kind, key), needed, out);
        }
    }
    json_decref(done);
}

/* Keys of two variants, each called by the first key that it needs; those that both have alike
 * once. */
static void print_both(const lf_table_source *source, const json_t *variants, bool tell, FILE *out)
{
    size_t i;
    json_t *variant, *node;
    const char *key;
    json_array_foreach(variants, i, variant)
    {
        const char *first =
            json_string_value(json_array_get(json_object_get(variant, "required"), 0));
        const json_t *other = json_object_get(json_array_get(variants, 1 - i), "properties");
        json_object_foreach(json_object_get(variant, "properties"), key, node)
        {
            const bool same = json_equal(json_object_get(other, key), node);
            if (same && i > 0)
                continue;
            fprintf(out, "| `%s` | ", key);
            if (tell)
                fprintf(out, "%s | ", same ? "both" : first);
            print_cells(source, node, NULL, tell && is_required(variant, key) ? "required" : "",
                        out);
        }
    }
}

static void print_object(const lf_table_source *source, const struct scene_table *table,
                         const json_t *properties, FILE *out)
{
    char path[MOST_PATH];
    const char *key;
    json_t *node;
    const bool camera = strcmp(table->name, "camera") == 0;
    snprintf(path, sizeof path, "%s", table->path);
    char *slash = strrchr(path, '/');
    if (slash)
        *slash = '\0';
    const json_t *owner = node_at(source->schema, slash ? path : "");
    json_object_foreach((json_t *)(uintptr_t)properties, key, node)
    {
        if (is_former(node))
            continue;
        fprintf(out, "| `%s` | ", key);
        print_cells(source, node, camera ? row_in(lf_camera_params, key) : NULL,
                    is_required(owner, key) ? "required" : "", out);
    }
}

bool lf_table_scene(const lf_table_source *source, const char *name, FILE *out)
{
    int i = 0;
    while (i < N_TABLES && strcmp(scene_tables[i].name, name) != 0)
        i++;
    const json_t *node = i < N_TABLES ? node_at(source->schema, scene_tables[i].path) : NULL;
    if (!node)
        return false;
    const char *of = scene_tables[i].of;
    const bool lights = of && strcmp(of, "type") == 0;
    fprintf(out, lights ? "| type | key | type of value | range | default | meaning |\n"
                 : of   ? "| key | of | type | range | default | meaning |\n"
                        : "| key | type | range | default | meaning |\n");
    fputs(of ? "|---|---|---|---|---|---|\n" : "|---|---|---|---|---|\n", out);
    if (lights)
        print_lights(source, node, out);
    else if (strcmp(name, "material") == 0)
        print_materials(source, node, out);
    else if (json_is_array(node))
        print_both(source, node, of, out);
    else
        print_object(source, &scene_tables[i], node, out);
    return true;
}
