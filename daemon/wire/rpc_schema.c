#include "daemon/wire/rpc.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/former.h"
#include "base/nearest.h"
#include "base/number.h"

/* More than any method has. */
#define MAX_KEYS 64

typedef struct checker {
    const char *where;
    char pointer[256];
    lf_error *err;
} checker;

#define FAIL(c, ...) lf_error_set_at((c)->err, LF_E_ARG, (c)->where, 0, (c)->pointer, __VA_ARGS__)

static bool is_of_type(const json_t *value, const char *type)
{
    if (strcmp(type, "object") == 0)
        return json_is_object(value);
    if (strcmp(type, "array") == 0)
        return json_is_array(value);
    if (strcmp(type, "string") == 0)
        return json_is_string(value);
    if (strcmp(type, "boolean") == 0)
        return json_is_boolean(value);
    if (strcmp(type, "integer") == 0)
        return json_is_integer(value) ||
               (json_is_real(value) && json_real_value(value) == floor(json_real_value(value)) &&
                fabs(json_real_value(value)) < 9e15);
    if (strcmp(type, "number") == 0)
        return json_is_number(value);
    return strcmp(type, "null") == 0 && json_is_null(value);
}

static lf_status check_type(checker *c, const json_t *type, const json_t *value)
{
    if (!type)
        return LF_OK;
    if (json_is_string(type)) {
        const char *name = json_string_value(type);
        return is_of_type(value, name)
                   ? LF_OK
                   : FAIL(c, "expected %s %s", strchr("aio", name[0]) ? "an" : "a", name);
    }
    char names[128] = "";
    size_t i;
    json_t *member;
    json_array_foreach(type, i, member)
    {
        if (is_of_type(value, json_string_value(member)))
            return LF_OK;
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i > 0 ? " or " : "",
                 json_string_value(member));
    }
    return FAIL(c, "expected %s", names);
}

/* Words with an error text of their own: {word: text}. */
static lf_status check_refused(checker *c, const json_t *refused, const json_t *value)
{
    const char *word = json_string_value(value),
               *why = word ? json_string_value(json_object_get(refused, word)) : NULL;
    return why ? FAIL(c, "%s %s", word, why) : LF_OK;
}

static lf_status check_enum(checker *c, const json_t *allowed, const json_t *value)
{
    if (!allowed)
        return LF_OK;
    char names[256] = "";
    size_t i;
    json_t *member;
    json_array_foreach(allowed, i, member)
    {
        if (json_equal(member, value))
            return LF_OK;
        size_t used = strlen(names);
        if (json_is_integer(member))
            snprintf(names + used, sizeof names - used, "%s%lld", i > 0 ? ", " : "",
                     json_integer_value(member));
        else
            snprintf(names + used, sizeof names - used, "%s%s", i > 0 ? ", " : "",
                     json_string_value(member));
    }
    return FAIL(c, "expected one of %s", names);
}

static lf_status check_range(checker *c, const json_t *schema, const json_t *value)
{
    const json_t *minimum = json_object_get(schema, "minimum");
    const json_t *maximum = json_object_get(schema, "maximum");
    if (!json_is_number(value))
        return LF_OK;
    double number = json_number_value(value);
    if (minimum && !(number >= json_number_value(minimum)))
        return FAIL(c, "must be at least %g", json_number_value(minimum));
    if (maximum && !(number <= json_number_value(maximum)))
        return FAIL(c, "must be at most %g", json_number_value(maximum));
    return LF_OK;
}

static lf_status check(checker *c, const json_t *schema, json_t *value);

static lf_status check_member(checker *c, const json_t *schema, json_t *value, const char *name)
{
    size_t length = strlen(c->pointer);
    snprintf(c->pointer + length, sizeof c->pointer - length, "/%s", name);
    lf_status status = check(c, schema, value);
    c->pointer[length] = '\0';
    return status;
}

static lf_status check_items(checker *c, const json_t *schema, const json_t *value)
{
    const json_t *least = json_object_get(schema, "minItems");
    const json_t *most = json_object_get(schema, "maxItems");
    const json_int_t n = (json_int_t)json_array_size(value);
    const json_int_t low = json_integer_value(least), high = json_integer_value(most);
    if (least && most && low == high && n != low)
        return FAIL(c, "expected %lld elements, got %lld", low, n);
    if (least && n < low)
        return FAIL(c, "expected at least %lld elements, got %lld", low, n);
    if (most && n > high)
        return FAIL(c, "expected at most %lld elements, got %lld", high, n);
    const json_t *items = json_object_get(schema, "items");
    size_t i;
    json_t *element;
    json_array_foreach(value, i, element)
    {
        char name[24];
        snprintf(name, sizeof name, "%zu", i);
        lf_status status = items ? check_member(c, items, element, name) : LF_OK;
        if (status != LF_OK)
            return status;
    }
    return LF_OK;
}

static void list_keys(json_t *properties, char *out, size_t size)
{
    out[0] = '\0';
    const char *key;
    json_t *value;
    json_object_foreach(properties, key, value)
    {
        size_t used = strlen(out);
        if (!lf_former_name_of(value))
            snprintf(out + used, size - used, "%s%s", used > 0 ? ", " : "", key);
    }
}

const char *lf_nearest_key(const char *word, json_t *object)
{
    const char *names[MAX_KEYS + 1] = {NULL}, *key;
    json_t *value;
    int n = 0;
    json_object_foreach(object, key, value)
    {
        if (n < MAX_KEYS && !lf_former_name_of(value))
            names[n++] = key;
    }
    return lf_nearest_name(word, names);
}

static lf_status unknown_key(checker *c, json_t *properties, const char *key)
{
    char known[300];
    const char *meant = lf_nearest_key(key, properties);
    if (meant)
        return FAIL(c, "unknown key \"%s\"; did you mean \"%s\"?", key, meant);
    list_keys(properties, known, sizeof known);
    return known[0] != '\0' ? FAIL(c, "unknown key \"%s\"; known: %s", key, known)
                            : FAIL(c, "unknown key \"%s\"; this method has no parameters", key);
}

static lf_status check_properties(checker *c, const json_t *schema, json_t *value)
{
    json_t *properties = json_object_get(schema, "properties");
    bool open = json_is_true(json_object_get(schema, "additionalProperties"));
    const char *key;
    json_t *member;
    json_object_foreach(value, key, member)
    {
        const json_t *property = json_object_get(properties, key);
        if (!property && !open)
            return unknown_key(c, properties, key);
        lf_status status = property ? check_member(c, property, member, key) : LF_OK;
        if (status != LF_OK)
            return status;
    }
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(schema, "required"), i, name)
    {
        if (!json_object_get(value, json_string_value(name)))
            return FAIL(c, "\"%s\" is missing", json_string_value(name));
    }
    return LF_OK;
}

static lf_status check(checker *c, const json_t *schema, json_t *value)
{
    lf_status status = check_type(c, json_object_get(schema, "type"), value);
    if (status == LF_OK)
        status = check_refused(c, json_object_get(schema, "refused"), value);
    if (status == LF_OK)
        status = check_enum(c, json_object_get(schema, "enum"), value);
    if (status == LF_OK)
        status = check_range(c, schema, value);
    if (status == LF_OK && json_is_array(value))
        status = check_items(c, schema, value);
    if (status == LF_OK && json_is_object(value))
        status = check_properties(c, schema, value);
    return status;
}

lf_status lf_schema_check(const json_t *schema, json_t *value, const char *where, lf_error *err)
{
    checker c = {.where = where, .err = err};
    return check(&c, schema, value);
}

/* -------------------------------------------------------------------- command line arguments -- */

static const char *type_name(const json_t *schema)
{
    const json_t *type = json_object_get(schema, "type");
    const char *name = json_string_value(json_is_array(type) ? json_array_get(type, 0) : type);
    return name ? name : "string";
}

static json_t *number_of(const char *text, bool integer)
{
    int64_t whole;
    double value;
    if (integer)
        return lf_integer_is(text, &whole) ? json_integer(whole) : NULL;
    return lf_decimal_is(text, &value) ? json_real(value) : NULL;
}

static json_t *typed_value(const json_t *schema, const char *text);

/* The comma-separated values; NULL: one of them has the wrong type. */
static json_t *list_of(const json_t *items, const char *text)
{
    json_t *list = json_array();
    char *copy = strdup(text), *rest = *text ? copy : NULL;
    bool good = list && copy;
    for (const char *word; good && (word = strsep(&rest, ","));) {
        json_t *element = typed_value(items, word);
        good = element && json_array_append_new(list, element) == 0;
    }
    free(copy);
    if (!good)
        json_decref(list);
    return good ? list : NULL;
}

/* True if text is one of the blank-separated words. */
static bool is_word(const char *text, const char *words)
{
    const size_t n = strlen(text);
    for (const char *at = words; n > 0 && !strchr(text, ' ') && (at = strstr(at, text)); at++)
        if ((at == words || at[-1] == ' ') && (at[n] == ' ' || at[n] == '\0'))
            return true;
    return false;
}

/* NULL: the text is not of the type. */
static json_t *typed_value(const json_t *schema, const char *text)
{
    const char *type = type_name(schema);
    if (strcmp(type, "integer") == 0 || strcmp(type, "number") == 0)
        return number_of(text, type[0] == 'i');
    if (strcmp(type, "boolean") == 0) {
        const bool yes = is_word(text, "true yes on 1"), no = is_word(text, "false no off 0");
        return yes || no ? json_boolean(yes) : NULL;
    }
    if (strcmp(type, "array") == 0)
        return list_of(json_object_get(schema, "items"), text);
    if (strcmp(type, "object") == 0)
        return json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    return json_string(text);
}

/* An example of a value of the type. */
static const char *example_of(const json_t *schema)
{
    static const char *const examples[][2] = {
        {"integer", "a whole number in decimal digits, such as 12"},
        {"number", "a decimal number, such as 0.5 or 1e-3"},
        {"boolean", "true or false"},
        {"object", "a JSON object"}};
    const json_t *items = json_object_get(schema, "items");
    const char *type = type_name(schema);
    if (strcmp(type, "array") == 0)
        return strchr("in", type_name(items)[0]) ? "a list of decimal numbers such as 0,0.5,1"
                                                 : "a list of values separated by commas";
    for (size_t i = 0; i < sizeof examples / sizeof *examples; i++)
        if (strcmp(type, examples[i][0]) == 0)
            return examples[i][1];
    return type;
}

lf_status lf_schema_argument(const json_t *schema, const char *text, json_t *params, lf_error *err)
{
    const char *equals = strchr(text, '=');
    if (!equals && json_object_get(json_object_get(schema, "properties"), "file"))
        return lf_error_set(err, LF_E_ARG, text, "expected key=value; for a file pass file=%s",
                            text);
    if (!equals || equals == text)
        return lf_error_set(err, LF_E_ARG, text, "expected key=value or key:=JSON");
    bool raw = equals[-1] == ':';
    char key[64];
    size_t length = (size_t)(equals - text) - (raw ? 1 : 0);
    if (length == 0 || length >= sizeof key)
        return lf_error_set(err, LF_E_ARG, text, "expected key=value or key:=JSON");
    memcpy(key, text, length);
    key[length] = '\0';
    json_error_t error;
    const json_t *property = json_object_get(json_object_get(schema, "properties"), key);
    json_t *value = raw ? json_loads(equals + 1, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &error)
                        : typed_value(property, equals + 1);
    if (!value)
        return raw ? lf_error_set(err, LF_E_ARG, key, "not JSON: column %d: %s", error.column,
                                  error.text)
                   : lf_error_set(err, LF_E_ARG, key, "\"%s\" is not %s", equals + 1,
                                  example_of(property));
    return json_object_set_new(params, key, value) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, key, "out of memory");
}
