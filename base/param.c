#include "base/param.h"

#include <assert.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parse.h"

#define HELP_COLUMN 25
#define HELP_WIDTH 110
#define MAX_JOINED 8

static bool is_end(const lf_param *row)
{
    return !row->name && !row->option;
}

const lf_param *lf_param_next(const lf_param *row)
{
    while (row->joined)
        row++;
    return row + 1;
}

/* ------------------------------------------------------------------------------------ fields -- */

static double *point_place(const lf_param *row, const void *object)
{
    return (double *)((uintptr_t)object + row->place);
}

/* An end of the range that was radians in between is that end again. */
static double settle(const lf_param *row, double degrees)
{
    if (fabs(degrees - row->low) <= 1e-9 * fabs(row->low))
        return row->low;
    return fabs(degrees - row->high) <= 1e-9 * fabs(row->high) ? row->high : degrees;
}

static double number_at(const lf_param *row, const void *object)
{
    const char *field = (const char *)object + row->place;
    switch (row->type) {
    case LF_PARAM_NUMBER:
        return *(const double *)(const void *)field;
    case LF_PARAM_ANGLE:
        return settle(row, *(const double *)(const void *)field * (180.0 / M_PI));
    case LF_PARAM_SWITCH:
        return *(const bool *)(const void *)field;
    default:
        return *(const int *)(const void *)field;
    }
}

static void put_number(const lf_param *row, double value, void *object)
{
    char *field = (char *)object + row->place;
    switch (row->type) {
    case LF_PARAM_NUMBER:
        *(double *)(void *)field = value;
        break;
    case LF_PARAM_ANGLE:
        *(double *)(void *)field = value * (M_PI / 180.0);
        break;
    case LF_PARAM_SWITCH:
        *(bool *)(void *)field = value != 0.0;
        break;
    default:
        *(int *)(void *)field = (int)value;
    }
}

static const char **text_place(const lf_param *row, const void *object)
{
    return (const char **)((uintptr_t)object + row->place);
}

void lf_param_defaults(const lf_param *params, void *object)
{
    for (const lf_param *row = params; !is_end(row); row++)
        if (row->type == LF_PARAM_TEXT)
            *text_place(row, object) = NULL;
        else if (row->type == LF_PARAM_POINT)
            memcpy(point_place(row, object), row->point, sizeof row->point);
        else if (row->name)
            put_number(row, row->initial, object);
}

/* ------------------------------------------------------------------------------------ values -- */

static int word_index(const lf_param *row, const char *text)
{
    for (int i = 0; row->words[i]; i++)
        if (strcmp(row->words[i], text) == 0)
            return i;
    return -1;
}

/* The value that a text stands for. */
static bool read_value(const lf_param *row, const char *text, double *out)
{
    const int index = row->words && text ? word_index(row, text) : -1;
    int64_t whole = 0;
    if (row->words) {
        *out = row->type == LF_PARAM_WHOLE && index >= 0 ? strtod(text, NULL) : index;
        return index >= 0;
    }
    if (row->type == LF_PARAM_SWITCH) {
        *out = 1.0;
        return !text;
    }
    if (row->type == LF_PARAM_NUMBER || row->type == LF_PARAM_ANGLE)
        return lf_parse_double("", text, row->low, row->high, out, NULL) == LF_OK;
    if (lf_parse_int("", text, (int64_t)row->low, (int64_t)row->high, &whole, NULL) != LF_OK)
        return false;
    *out = (double)whole;
    return true;
}

static bool is_allowed(const lf_param *row, double value)
{
    char text[32];
    int n = 0;
    if (row->words && row->type == LF_PARAM_WHOLE) {
        snprintf(text, sizeof text, "%.0f", value);
        return word_index(row, text) >= 0;
    }
    while (row->words && row->words[n])
        n++;
    if (row->words || row->type == LF_PARAM_SWITCH)
        return value >= 0.0 && value < (row->words ? n : 2);
    return value >= row->low && value <= row->high; /* never, for NaN */
}

/* What the value may be: "a number from 5 to 600", "none, lzw or deflate". */
static char *describe(const lf_param *row, char *buf, size_t size)
{
    size_t used = 0;
    buf[0] = '\0';
    if (!row->words)
        snprintf(buf, size, "a%s number from %.10g to %.10g%s%s",
                 row->type == LF_PARAM_WHOLE ? " whole" : "", row->low, row->high,
                 row->unit ? " " : "", row->unit ? row->unit : "");
    for (int i = 0; row->words && row->words[i] && used < size; i++)
        used += (size_t)snprintf(buf + used, size - used, "%s%s",
                                 i == 0              ? ""
                                 : row->words[i + 1] ? ", "
                                                     : " or ",
                                 row->words[i]);
    return buf;
}

/* ------------------------------------------------------------------------- the command line -- */

char *lf_param_argument(const lf_param *row, char *buf, size_t size)
{
    size_t used = 0;
    buf[0] = '\0';
    for (const lf_param *end = lf_param_next(row); row < end && used < size; row++)
        used +=
            (size_t)snprintf(buf + used, size - used, "%s%s", row->argument ? row->argument : "",
                             row->joined ? row->joined : "");
    return buf;
}

static lf_status refuse(const lf_param *row, const char *text, lf_error *err)
{
    char where[64], argument[64], expected[320], one[128];
    size_t used = 0;
    snprintf(where, sizeof where, "--%s", row->option);
    lf_param_argument(row, argument, sizeof argument);
    if (!row->joined)
        return lf_error_set(err, LF_E_ARG, where, "expects %s, not \"%s\"",
                            describe(row, one, sizeof one), text);
    for (const lf_param *r = row; r < lf_param_next(row) && used < sizeof expected; r++)
        used += (size_t)snprintf(expected + used, sizeof expected - used, ", %s %s", r->argument,
                                 describe(r, one, sizeof one));
    return lf_error_set(err, LF_E_ARG, where, "expects %s%s, not \"%s\"", argument, expected, text);
}

/* Reads the parts of an option's text into value[0], value[1] …. */
static bool read_parts(const lf_param *row, const char *text, double *value)
{
    char part[64];
    for (; row->joined; row++, value++) {
        const char *cut = strstr(text, row->joined);
        const size_t n = cut ? (size_t)(cut - text) : sizeof part;
        if (n >= sizeof part)
            return false;
        memcpy(part, text, n);
        part[n] = '\0';
        if (!read_value(row, part, value))
            return false;
        text = cut + strlen(row->joined);
    }
    return read_value(row, text, value);
}

lf_status lf_param_from_text(const lf_param *row, const char *text, void *object, lf_error *err)
{
    double value[MAX_JOINED];
    assert(lf_param_next(row) - row <= MAX_JOINED);
    if (row->type == LF_PARAM_TEXT) {
        *text_place(row, object) = text;
        return LF_OK;
    }
    if (!read_parts(row, text, value))
        return refuse(row, text, err);
    for (const lf_param *r = row; r < lf_param_next(row); r++)
        put_number(r, value[r - row], object);
    return LF_OK;
}

/* The unit of an option whose rows have one and the same; NULL: none. */
static const char *common_unit(const lf_param *row)
{
    const char *unit = row->joined ? row->unit : NULL;
    for (const lf_param *end = lf_param_next(row); unit && row < end; row++)
        if (!row->unit || strcmp(row->unit, unit) != 0)
            unit = NULL;
    return unit;
}

/* Help, the words with the initial one marked, the initial number, or the unit of all parts. */
static void describe_option(const lf_param *row, char *buf, size_t size)
{
    size_t used = (size_t)snprintf(buf, size, "%s", row->help ? row->help : "");
    if (used >= size)
        return;
    if (common_unit(row))
        snprintf(buf + used, size - used, ", in %s", common_unit(row));
    if (!row->words && (row->joined || row->type == LF_PARAM_SWITCH || row->initial == 0.0))
        return;
    if (!row->words || row->type == LF_PARAM_WHOLE) {
        snprintf(buf + used, size - used, " (%g)", row->initial);
        return;
    }
    for (int i = 0; row->words[i] && used < size; i++)
        used += (size_t)snprintf(buf + used, size - used, "%s%s%s",
                                 i > 0 && !row->words[i + 1] ? " or "
                                 : i > 0                     ? ", "
                                 : row->help                 ? ": "
                                                             : "",
                                 row->words[i], i == (int)row->initial ? " (default)" : "");
}

/* Prints words from HELP_COLUMN on, as many a line as fit. */
static void print_wrapped(const char *text)
{
    size_t column = HELP_COLUMN;
    while (*text != '\0') {
        const size_t n = strcspn(text, " ");
        if (column > HELP_COLUMN && column + 1 + n > HELP_WIDTH) {
            printf("\n%*s", HELP_COLUMN, "");
            column = HELP_COLUMN;
        }
        column += n + (column > HELP_COLUMN);
        printf("%s%.*s", column > HELP_COLUMN + n ? " " : "", (int)n, text);
        text += n;
        text += strspn(text, " ");
    }
    printf("\n");
}

void lf_param_print_help(const lf_param *params)
{
    char argument[64], help[400];
    for (const lf_param *row = params; !is_end(row); row = lf_param_next(row)) {
        if (!row->option)
            continue;
        const int n =
            printf("  --%s %s", row->option, lf_param_argument(row, argument, sizeof argument));
        if (n >= HELP_COLUMN)
            printf("\n%*s", HELP_COLUMN, "");
        else
            printf("%*s", HELP_COLUMN - n, "");
        describe_option(row, help, sizeof help);
        print_wrapped(help);
    }
}

/* -------------------------------------------------------------------------------------- JSON -- */

static bool take_point(const lf_param *row, const json_t *value, void *object)
{
    double point[3];
    for (size_t i = 0; i < 3; i++) {
        const json_t *number = json_array_get(value, i);
        point[i] = json_number_value(number);
        if (json_array_size(value) != 3 || !json_is_number(number) || !is_allowed(row, point[i]))
            return false;
    }
    memcpy(point_place(row, object), point, sizeof point);
    return true;
}

static bool take_json(const lf_param *row, const json_t *value, void *object)
{
    double number = 0.0;
    if (row->type == LF_PARAM_POINT)
        return take_point(row, value, object);
    if (row->type == LF_PARAM_TEXT) {
        if (json_is_string(value))
            *text_place(row, object) = json_string_value(value);
        return json_is_string(value);
    }
    if (row->words && row->type != LF_PARAM_WHOLE) {
        if (!json_is_string(value) || !read_value(row, json_string_value(value), &number))
            return false;
    } else if (row->type == LF_PARAM_SWITCH) {
        if (!json_is_boolean(value))
            return false;
        number = json_is_true(value);
    } else {
        number = json_number_value(value);
        if (!json_is_number(value) || !is_allowed(row, number) ||
            (row->type == LF_PARAM_WHOLE && number != floor(number)))
            return false;
    }
    put_number(row, number, object);
    return true;
}

lf_status lf_param_from_json(const lf_param *params, const json_t *values, void *object,
                             const char *where, lf_error *err)
{
    char pointer[64], expected[128];
    for (const lf_param *row = params; !is_end(row); row++) {
        const json_t *value = row->name ? json_object_get(values, row->name) : NULL;
        if (!value || take_json(row, value, object))
            continue;
        snprintf(pointer, sizeof pointer, "/%s", row->name);
        return lf_error_set_at(err, LF_E_ARG, where, 0, pointer, "expected %s",
                               row->type == LF_PARAM_TEXT    ? "a string"
                               : row->type == LF_PARAM_POINT ? "three numbers"
                               : row->type == LF_PARAM_SWITCH && !row->words
                                   ? "true or false"
                                   : describe(row, expected, sizeof expected));
    }
    return LF_OK;
}

const char *lf_param_missing(const lf_param *params, const json_t *values)
{
    for (const lf_param *row = params; !is_end(row); row++)
        if (row->required && !json_object_get(values, row->name))
            return row->name;
    return NULL;
}

lf_status lf_param_check(const lf_param *params, const void *object, const char *where,
                         lf_error *err)
{
    char expected[128];
    for (const lf_param *row = params; !is_end(row); row++) {
        if (!row->name || row->type == LF_PARAM_TEXT || row->type == LF_PARAM_POINT)
            continue;
        const double value = number_at(row, object);
        if (!is_allowed(row, value) && (row->required || value != row->initial))
            return lf_error_set(err, LF_E_ARG, where, "%s %g: expected %s", row->name, value,
                                describe(row, expected, sizeof expected));
    }
    return LF_OK;
}

static json_t *value_json(const lf_param *row, const void *object)
{
    if (row->type == LF_PARAM_TEXT) {
        const char *text = *text_place(row, object);
        json_t *string = text ? json_string(text) : NULL;
        return string ? string : json_null(); /* a path that is not UTF-8 */
    }
    if (row->type == LF_PARAM_POINT) {
        const double *point = point_place(row, object);
        return json_pack("[f, f, f]", point[0], point[1], point[2]);
    }
    const double value = number_at(row, object);
    if (row->words && row->type != LF_PARAM_WHOLE)
        return json_string(row->words[(int)value]);
    if (row->type == LF_PARAM_SWITCH)
        return json_boolean(value != 0.0);
    return row->type == LF_PARAM_WHOLE ? json_integer((json_int_t)value) : json_real(value);
}

json_t *lf_param_json(const lf_param *params, const void *object)
{
    json_t *out = json_object();
    bool ok = out;
    for (const lf_param *row = params; ok && !is_end(row); row++)
        if (row->name)
            ok = json_object_set_new(out, row->name, value_json(row, object)) == 0;
    if (!ok) {
        json_decref(out);
        return NULL;
    }
    return out;
}

static json_t *words_json(const lf_param *row)
{
    json_t *words = json_array();
    for (int i = 0; words && row->words[i]; i++)
        json_array_append_new(words, row->type == LF_PARAM_WHOLE
                                         ? json_integer(strtol(row->words[i], NULL, 10))
                                         : json_string(row->words[i]));
    return words;
}

static json_t *row_schema(const lf_param *row)
{
    const char *type = row->type == LF_PARAM_WHOLE    ? "integer"
                       : row->type == LF_PARAM_SWITCH ? "boolean"
                       : row->type == LF_PARAM_TEXT   ? "string"
                                                      : "number";
    if (row->words)
        return json_pack("{s:s, s:o}", "type", row->type == LF_PARAM_WHOLE ? "integer" : "string",
                         "enum", words_json(row));
    if (row->type == LF_PARAM_SWITCH || row->type == LF_PARAM_TEXT)
        return json_pack("{s:s}", "type", type);
    json_t *number =
        json_pack("{s:s, s:f, s:f}", "type", type, "minimum", row->low, "maximum", row->high);
    if (row->type != LF_PARAM_POINT)
        return number;
    return json_pack("{s:s, s:o, s:i, s:i}", "type", "array", "items", number, "minItems", 3,
                     "maxItems", 3);
}

static bool describe_schema(const lf_param *row, json_t *schema)
{
    if (!row->help && !row->unit)
        return true;
    return json_object_set_new(schema, "description",
                               json_sprintf("%s%s%s", row->help ? row->help : "",
                                            row->help && row->unit ? "; " : "",
                                            row->unit ? row->unit : "")) == 0;
}

json_t *lf_param_schema(const lf_param *params)
{
    json_t *out = json_object();
    bool ok = out;
    for (const lf_param *row = params; ok && !is_end(row); row++) {
        json_t *schema = row->name ? row_schema(row) : NULL;
        if (row->name)
            ok = json_object_set_new(out, row->name, schema) == 0 && describe_schema(row, schema);
    }
    if (!ok) {
        json_decref(out);
        return NULL;
    }
    return out;
}
