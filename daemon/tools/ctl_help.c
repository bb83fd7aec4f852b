#include "daemon/tools/ctl_help.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/former.h"
#define WIDTH 100
#define COLUMN 26 /* column at which descriptions start */

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static void append(char *buf, size_t size, const char *between, const char *text)
{
    const size_t used = strlen(buf);
    snprintf(buf + used, size - used, "%s%s", used > 0 ? between : "", text);
}

/* Appends a number or word of a schema, as a user types it. */
static void append_value(char *buf, size_t size, const char *between, const json_t *value)
{
    char text[64];
    if (json_is_integer(value))
        snprintf(text, sizeof text, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        snprintf(text, sizeof text, "%.6g", json_real_value(value));
    else if (json_is_boolean(value))
        snprintf(text, sizeof text, "%s", json_is_true(value) ? "true" : "false");
    else
        snprintf(text, sizeof text, "%s", json_is_string(value) ? json_string_value(value) : "");
    append(buf, size, between, text);
}

static const char *placeholder(const char *type)
{
    static const char *const words[][2] = {{"integer", "N"},          {"number", "NUMBER"},
                                           {"boolean", "true|false"}, {"array", "LIST"},
                                           {"object", "JSON"},        {"string", "TEXT"}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcmp(type, words[i][0]) == 0)
            return words[i][1];
    return type;
}

/* The possible values of "key=". */
static void name_value(const json_t *schema, char *buf, size_t size)
{
    const json_t *items = json_object_get(schema, "items"), *type = json_object_get(schema, "type");
    json_t *words = json_object_get(schema, "enum"), *word;
    size_t i;
    buf[0] = '\0';
    if (!words && items)
        words = json_object_get(items, "enum");
    json_array_foreach(words, i, word)
    {
        append_value(buf, size, "|", word);
    }
    if (words && items)
        append(buf, size, "", ",...");
    if (words)
        return;
    json_array_foreach((json_t *)(uintptr_t)type, i, word)
    {
        if (json_is_string(word))
            append(buf, size, "|", placeholder(json_string_value(word)));
    }
    if (json_integer_value(json_object_get(schema, "maxItems")) == 3)
        append(buf, size, "", "X,Y,Z");
    else if (json_is_string(type))
        append(buf, size, "", placeholder(json_string_value(type)));
}

/* "degrees", "0.01 to 1 times". */
static void name_range(const json_t *schema, char *buf, size_t size)
{
    const json_t *low = json_object_get(schema, "minimum"),
                 *high = json_object_get(schema, "maximum");
    buf[0] = '\0';
    if (low && !high)
        append(buf, size, "", "at least");
    if (low)
        append_value(buf, size, " ", low);
    if (low && high)
        append_value(buf, size, " to ", high);
    const char *unit = text_of(schema, "unit");
    if (unit[0] != '\0' && strcmp(unit, "count") != 0)
        append(buf, size, " ", unit);
}

static void describe(const json_t *schema, bool required, char *buf, size_t size)
{
    const json_t *fallback = json_object_get(schema, "default");
    char range[128];
    buf[0] = '\0';
    append(buf, size, "", text_of(schema, "description"));
    name_range(schema, range, sizeof range);
    if (range[0] != '\0')
        append(buf, size, "; ", range);
    if (required)
        append(buf, size, " ", "(required)");
    else if (fallback)
        append_value(buf, size, " (default ", fallback);
    if (!required && fallback)
        append(buf, size, "", ")");
}

/* Prints text wrapped from COLUMN on; the first line starts at the cursor. */
static void print_wrapped(const char *text)
{
    size_t at = COLUMN;
    while (*text != '\0') {
        const size_t n = strcspn(text, " ");
        if (at > COLUMN && at + 1 + n > WIDTH) {
            printf("\n%*s", COLUMN, "");
            at = COLUMN;
        }
        at += (size_t)printf("%s%.*s", at > COLUMN ? " " : "", (int)n, text);
        text += n + strspn(text + n, " ");
    }
    putchar('\n');
}

static void print_row(const char *name, const char *text)
{
    const int n = printf("  %s", name);
    if (n + 2 > COLUMN)
        printf("\n%*s", COLUMN, "");
    else
        printf("%*s", COLUMN - n, "");
    print_wrapped(text);
}

static bool is_required(const json_t *schema, const char *key)
{
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(schema, "required"), i, name)
    {
        if (json_is_string(name) && strcmp(json_string_value(name), key) == 0)
            return true;
    }
    return false;
}

static void print_parameters(const json_t *schema)
{
    const char *key;
    json_t *property;
    json_object_foreach(json_object_get(schema, "properties"), key, property)
    {
        char value[512], name[600], text[1024];
        if (lf_former_name_of(property))
            continue;
        const bool is_json = strcmp(text_of(property, "type"), "object") == 0;
        name_value(property, value, sizeof value);
        snprintf(name, sizeof name, "%s%s=%s", key, is_json ? ":" : "", value);
        describe(property, is_required(schema, key), text, sizeof text);
        print_row(name, text);
    }
}

static void print_fields(const char *prefix, const json_t *schema)
{
    const char *key;
    json_t *property;
    json_object_foreach(json_object_get(schema, "properties"), key, property)
    {
        char name[256], text[1024];
        const json_t *items = json_object_get(property, "items");
        snprintf(name, sizeof name, "%s%s", prefix, key);
        describe(property, false, text, sizeof text);
        print_row(name, text);
        snprintf(name, sizeof name, "%s%s%s.", prefix, key, items ? "[]" : "");
        print_fields(name, items ? items : property);
    }
}

void lf_ctl_print_method(const char *name, const json_t *entry)
{
    const json_t *params = json_object_get(entry, "params"),
                 *result = json_object_get(entry, "result");
    printf("quiltctl %s: %s\n", name, text_of(entry, "summary"));
    printf("\nExample: quiltctl %s\n", text_of(entry, "example"));
    if (json_object_size(json_object_get(params, "properties")) > 0)
        printf("\nParameters:\n");
    print_parameters(params);
    if (json_object_size(json_object_get(result, "properties")) > 0)
        printf("\nAnswer:\n");
    print_fields("", result);
}

void lf_ctl_print_methods(const json_t *hello)
{
    const char *name, *key;
    json_t *entry, *property;
    printf("quiltd %s, protocol %lld\n", text_of(hello, "version"),
           (long long)json_integer_value(json_object_get(hello, "protocol")));
    json_object_foreach(json_object_get(hello, "methods"), name, entry)
    {
        printf("%-20s %s\n", name, text_of(entry, "summary"));
        json_object_foreach(json_object_get(json_object_get(entry, "params"), "properties"), key,
                            property)
        {
            char value[512], range[128];
            if (lf_former_name_of(property))
                continue;
            name_value(property, value, sizeof value);
            name_range(property, range, sizeof range);
            printf("    %s=%s%s%s\n", key, value, range[0] != '\0' ? "  " : "", range);
        }
    }
    printf("Notifications (subscribe):\n");
    json_object_foreach(json_object_get(hello, "events"), name, entry)
    {
        printf("%-20s %s\n", name, text_of(entry, "summary"));
    }
    printf("For details: quiltctl METHOD --help\n");
}
