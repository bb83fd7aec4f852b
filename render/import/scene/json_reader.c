#include "render/import/scene/json_reader.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/nearest.h"
#include "base/sandbox/import.h"
#include "render/import/scene/former_keys.h"

lf_node lf_node_child(const lf_node *parent, const char *key)
{
    return (lf_node){parent, key, 0, json_object_get(parent->value, key)};
}

lf_node lf_node_item(const lf_node *parent, size_t index)
{
    return (lf_node){parent, NULL, index, json_array_get(parent->value, index)};
}

/* Appends one reference token, escaped by RFC 6901; cut when the buffer is full. */
static void append_token(char *out, size_t size, const lf_node *node)
{
    size_t at = strlen(out);
    if (!node->key) {
        snprintf(out + at, size - at, "/%zu", node->index);
        return;
    }
    if (at + 1 < size)
        out[at++] = '/';
    for (const char *c = node->key; *c && at + 2 < size; c++) {
        if (*c == '~' || *c == '/') {
            out[at++] = '~';
            out[at++] = *c == '~' ? '0' : '1';
        } else {
            out[at++] = *c;
        }
    }
    out[at] = '\0';
}

static void build_pointer(const lf_node *node, char *out, size_t size)
{
    if (!node->parent) {
        out[0] = '\0';
        return;
    }
    build_pointer(node->parent, out, size);
    append_token(out, size, node);
}

/* The value at node's path in another document; *depth: number of steps of the path that exist
 * there. */
static const json_t *same_in(const json_t *doc, const lf_node *node, int *depth)
{
    if (!node->parent)
        return doc;
    const json_t *parent = same_in(doc, node->parent, depth),
                 *found = node->key ? json_object_get(parent, node->key)
                                    : json_array_get(parent, node->index);
    *depth += found ? 1 : 0;
    return found;
}

/* The source document of a value. */
static lf_json_source source_of(const lf_reader *reader, const lf_node *node)
{
    lf_json_source best = {reader->where, reader->text, reader->size, NULL};
    int most = -1;
    for (int i = 0; i < reader->n_sources; i++) {
        int depth = 0;
        (void)same_in(reader->sources[i].doc, node, &depth);
        if (depth > most)
            best = reader->sources[i];
        most = depth > most ? depth : most;
    }
    return best;
}

static void report(lf_reader *reader, const lf_node *node, lf_status status, const char *what)
{
    if (reader->status != LF_OK)
        return;
    reader->status = status;
    char pointer[256];
    build_pointer(node, pointer, sizeof pointer);
    const lf_json_source from = source_of(reader, node);
    int line = from.text ? lf_json_line(from.text, from.size, pointer) : 0;
    lf_error_set_at(reader->err, status, from.where, line, pointer, "%s", what);
}

void lf_read_fail(lf_reader *reader, const lf_node *node, const char *fmt, ...)
{
    char what[512];
    va_list args;
    va_start(args, fmt);
    vsnprintf(what, sizeof what, fmt, args);
    va_end(args);
    report(reader, node, LF_E_FORMAT, what);
}

void lf_read_fail_with(lf_reader *reader, const lf_node *node, const lf_error *inner)
{
    char what[1100];
    lf_error_format(inner, what, sizeof what);
    report(reader, node, inner->status, what);
}

static const char *type_name(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "an array";
    case JSON_STRING:
        return "a string";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
    case JSON_FALSE:
        return "a boolean";
    case JSON_NULL:
        break;
    }
    return "null";
}

static bool is_among(const char *word, const char *const names[])
{
    for (; *names; names++)
        if (strcmp(word, *names) == 0)
            return true;
    return false;
}

void lf_join_names(const char *const names[], char *out, size_t size)
{
    out[0] = '\0';
    for (size_t at = 0; *names && at < size; names++) {
        snprintf(out + at, size - at, "%s%s", at ? ", " : "", *names);
        at += strlen(out + at);
    }
}

/* Documents may hold hundreds of thousands of objects and numbers. */
static bool is_stopped(lf_reader *reader, const lf_node *node)
{
    if (reader->status == LF_OK && lf_import_is_stopped())
        report(reader, node, LF_E_CANCELLED, "stopped");
    return reader->status == LF_E_CANCELLED;
}

bool lf_read_object(lf_reader *reader, const lf_node *node, const char *const keys[])
{
    if (reader->status != LF_OK || !node->value || is_stopped(reader, node))
        return false;
    if (!json_is_object(node->value)) {
        lf_read_fail(reader, node, "expected an object, found %s", type_name(node->value));
        return false;
    }
    const char *key;
    json_t *value;
    json_object_foreach(node->value, key, value)
    {
        if (is_among(key, keys))
            continue;
        lf_node child = lf_node_child(node, key);
        const char *now = lf_former_key_now(key), *meant = lf_nearest_name(key, keys);
        char list[400];
        lf_join_names(keys, list, sizeof list);
        if (now && is_among(now, keys))
            lf_read_fail(reader, &child, "is the former name of %s; give only one of them", now);
        else if (meant)
            lf_read_fail(reader, &child, "unknown key \"%s\"; did you mean \"%s\"?", key, meant);
        else
            lf_read_fail(reader, &child, "unknown key \"%s\"; expected one of %s", key, list);
        return false;
    }
    return true;
}

static bool number_in_range(lf_reader *reader, const lf_node *node, double lo, double hi,
                            double *out)
{
    if (is_stopped(reader, node))
        return false;
    if (!json_is_number(node->value)) {
        lf_read_fail(reader, node, "expected a number, found %s", type_name(node->value));
        return false;
    }
    double value = json_number_value(node->value);
    if (!(value >= lo && value <= hi)) {
        lf_read_fail(reader, node, "%.9g is out of range: %.9g to %.9g", value, lo, hi);
        return false;
    }
    *out = value;
    return true;
}

double lf_read_number(lf_reader *reader, const lf_node *parent, const char *key, double fallback,
                      double lo, double hi)
{
    lf_node node = lf_node_child(parent, key);
    double value = fallback;
    if (reader->status == LF_OK && node.value)
        number_in_range(reader, &node, lo, hi, &value);
    return value;
}

int lf_read_int(lf_reader *reader, const lf_node *parent, const char *key, int fallback, int lo,
                int hi)
{
    lf_node node = lf_node_child(parent, key);
    double value;
    if (reader->status != LF_OK || !node.value || !number_in_range(reader, &node, lo, hi, &value))
        return fallback;
    if (value != floor(value)) {
        lf_read_fail(reader, &node, "expected a whole number, found %.9g", value);
        return fallback;
    }
    return (int)value;
}

bool lf_read_numbers(lf_reader *reader, const lf_node *parent, const char *key, int n, double *out,
                     double lo, double hi)
{
    lf_node node = lf_node_child(parent, key);
    if (reader->status != LF_OK || !node.value)
        return false;
    if (!json_is_array(node.value) || json_array_size(node.value) != (size_t)n) {
        lf_read_fail(reader, &node, "expected an array of %d numbers, found %s%s", n,
                     type_name(node.value), json_is_array(node.value) ? " of another length" : "");
        return false;
    }
    double values[16];
    for (int i = 0; i < n; i++) {
        lf_node item = lf_node_item(&node, (size_t)i);
        if (!number_in_range(reader, &item, lo, hi, &values[i]))
            return false;
    }
    memcpy(out, values, (size_t)n * sizeof *out);
    return true;
}

bool lf_read_colour(lf_reader *reader, const lf_node *parent, const char *key, double out[3],
                    double lo, double hi)
{
    lf_node node = lf_node_child(parent, key);
    if (reader->status != LF_OK || !node.value)
        return false;
    if (json_is_array(node.value))
        return lf_read_numbers(reader, parent, key, 3, out, lo, hi);
    if (!json_is_number(node.value)) {
        lf_read_fail(reader, &node, "expected a number or an array of 3 numbers, found %s",
                     type_name(node.value));
        return false;
    }
    double grey;
    if (!number_in_range(reader, &node, lo, hi, &grey))
        return false;
    out[0] = out[1] = out[2] = grey;
    return true;
}

bool lf_read_bool(lf_reader *reader, const lf_node *parent, const char *key, bool fallback)
{
    lf_node node = lf_node_child(parent, key);
    if (reader->status != LF_OK || !node.value)
        return fallback;
    if (!json_is_boolean(node.value))
        lf_read_fail(reader, &node, "expected true or false, found %s", type_name(node.value));
    return json_is_true(node.value);
}

const char *lf_read_string(lf_reader *reader, const lf_node *parent, const char *key,
                           const char *fallback, size_t max)
{
    lf_node node = lf_node_child(parent, key);
    if (reader->status != LF_OK || !node.value)
        return fallback;
    if (!json_is_string(node.value)) {
        lf_read_fail(reader, &node, "expected a string, found %s", type_name(node.value));
        return fallback;
    }
    size_t length = json_string_length(node.value);
    if (length == 0 || length > max) {
        lf_read_fail(reader, &node, "expected a string of 1 to %zu bytes, found %zu", max, length);
        return fallback;
    }
    return json_string_value(node.value);
}

int lf_read_choice(lf_reader *reader, const lf_node *parent, const char *key,
                   const char *const names[], int fallback)
{
    const char *word = lf_read_string(reader, parent, key, NULL, 64);
    if (!word)
        return fallback;
    for (int i = 0; names[i]; i++)
        if (strcmp(word, names[i]) == 0)
            return i;
    lf_node node = lf_node_child(parent, key);
    char list[256];
    lf_join_names(names, list, sizeof list);
    const char *meant = lf_nearest_name(word, names);
    if (meant)
        lf_read_fail(reader, &node, "unknown value \"%s\"; did you mean \"%s\"?", word, meant);
    else
        lf_read_fail(reader, &node, "unknown value \"%s\"; expected one of %s", word, list);
    return fallback;
}
