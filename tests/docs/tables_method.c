/* Parameters of a method of the socket, from its schema. */
#include <stdlib.h>
#include <string.h>

#include "daemon/server/methods.h"
#include "tests/docs/tables.h"

static json_t *schema_of(const char *method)
{
    for (int i = 0; lf_method_at(i); i++)
        if (strcmp(lf_method_at(i)->name, method) == 0)
            return lf_method_schema(i);
    return NULL;
}

const char *lf_table_method_at(int index)
{
    for (int i = 0; lf_method_at(i); i++)
        if (json_object_size(json_object_get(lf_method_schema(i), "properties")) > 0 &&
            index-- == 0)
            return lf_method_at(i)->name;
    return NULL;
}

static void print_type(const json_t *schema, FILE *out)
{
    const json_t *type = json_object_get(schema, "type"), *items = json_object_get(schema, "items");
    const json_t *least = json_object_get(schema, "minItems");
    size_t i;
    json_t *word;
    json_array_foreach(type, i, word)
    {
        fprintf(out, "%s%s", i > 0 ? " or " : "", json_string_value(word));
    }
    if (items && least)
        fprintf(out, "%d %ss", (int)json_integer_value(least),
                json_string_value(json_object_get(items, "type")));
    else if (items)
        fprintf(out, "array of %ss", json_string_value(json_object_get(items, "type")));
    else if (json_is_string(type))
        fputs(json_string_value(type), out);
}

static const json_t *words_of(const json_t *schema)
{
    const json_t *words = json_object_get(schema, "enum"),
                 *items = json_object_get(schema, "items");
    words = words ? words : json_object_get(schema, "words");
    return words ? words : json_object_get(items, "enum");
}

static void print_words(const json_t *words, FILE *out)
{
    size_t i;
    json_t *word;
    json_array_foreach(words, i, word)
    {
        fputs(i > 0 ? ", `" : "`", out);
        if (json_is_string(word))
            fputs(json_string_value(word), out);
        else
            lf_table_number(json_number_value(word), out);
        fputc('`', out);
    }
}

/* Words, numbers, how many: each after what is before it. */
static void print_range(const json_t *schema, FILE *out)
{
    const json_t *items = json_object_get(schema, "items");
    const json_t *of = json_object_get(items, "minimum") ? items : schema;
    const json_t *low = json_object_get(of, "minimum"), *high = json_object_get(of, "maximum"),
                 *most = json_object_get(schema, "maxItems");
    const char *unit = json_string_value(json_object_get(schema, "unit"));
    const json_t *words = words_of(schema);
    print_words(words, out);
    if (low) {
        fputs(words ? ", " : high ? "" : "from ", out);
        lf_table_number(json_number_value(low), out);
    }
    if (high) {
        fputs(" to ", out);
        lf_table_number(json_number_value(high), out);
    }
    if (unit && strcmp(unit, "count") != 0)
        fprintf(out, "%s%s", low ? " " : "", unit);
    if (most && !json_object_get(schema, "minItems"))
        fprintf(out, "%sat most %d", words ? "; " : "", (int)json_integer_value(most));
}

static bool is_required(const json_t *schema, const char *key)
{
    size_t i;
    json_t *word;
    json_array_foreach(json_object_get(schema, "required"), i, word)
    {
        if (strcmp(json_string_value(word), key) == 0)
            return true;
    }
    return false;
}

static void print_default(const json_t *schema, FILE *out)
{
    const json_t *value = json_object_get(schema, "default");
    if (json_is_string(value)) {
        fprintf(out, "`%s`", json_string_value(value));
    } else if (value) {
        char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(10));
        fprintf(out, "`%s`", text);
        free(text);
    }
}

bool lf_table_method(const lf_table_source *source, const char *name, FILE *out)
{
    json_t *schema = schema_of(name), *value;
    const char *key;
    if (!schema)
        return false;
    fputs("| parameter | type | range | default | meaning |\n|---|---|---|---|---|\n", out);
    json_object_foreach(json_object_get(schema, "properties"), key, value)
    {
        const char *text = json_string_value(json_object_get(value, "description"));
        char kept[1000], in_brackets[1000] = "";
        text = text ? text : "";
        if (!json_object_get(value, "default"))
            text = lf_table_default(text, kept, in_brackets, sizeof kept);
        fprintf(out, "| `%s` | ", key);
        print_type(value, out);
        fputs(" | ", out);
        print_range(value, out);
        fputs(" | ", out);
        if (is_required(schema, key))
            fputs("required", out);
        else if (json_object_get(value, "default"))
            print_default(value, out);
        else
            lf_table_text(source, in_brackets, NULL, out);
        fputs(" | ", out);
        lf_table_text(source, text, words_of(value), out);
        fputs(" |\n", out);
    }
    return true;
}
