#include "base/param.h"

#include <assert.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/former.h"
#include "base/number.h"
#include "base/parse.h"

#define HELP_COLUMN 25
#define HELP_WIDTH 110
#define MAX_JOINED 8
#define WORDS_SIZE 256

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

const lf_param *lf_param_find(const lf_param *params, const char *option)
{
    for (const lf_param *row = params; !is_end(row); row = lf_param_next(row))
        if (row->option && strcmp(row->option, option) == 0)
            return row;
    return NULL;
}

bool lf_param_among(const lf_param *row, const char *names)
{
    if (!row->option || !names)
        return row->option;
    const size_t length = strlen(row->option);
    for (size_t n; *names != '\0'; names += n + strspn(names + n, " ")) {
        n = strcspn(names, " ");
        if (n == length && strncmp(names, row->option, n) == 0)
            return true;
    }
    return false;
}

/* The name of a value; NULL after the last, or if values have no names. */
static const char *word_of(const lf_param *row, int value)
{
    if (row->word_at)
        return row->word_at(value);
    return row->words ? row->words[value] : NULL;
}

/* True if only words are allowed. */
static bool has_words(const lf_param *row)
{
    return row->type != LF_PARAM_NUMBER && word_of(row, 0);
}

/* True if a number or a word is allowed. */
static bool is_mixed(const lf_param *row)
{
    return row->type == LF_PARAM_NUMBER && word_of(row, 0);
}

static int count_words(const lf_param *row)
{
    int n = 0;
    while (word_of(row, n))
        n++;
    return n;
}

/* ------------------------------------------------------------------------------------ fields -- */

static bool is_text(const lf_param *row)
{
    return row->type == LF_PARAM_TEXT || row->type == LF_PARAM_NAME;
}

static double *point_place(const lf_param *row, const void *object)
{
    return (double *)((uintptr_t)object + row->place);
}

/* A limit of the range that was converted to radians and back becomes exact again. */
static double settle(const lf_param *row, double degrees)
{
    if (fabs(degrees - row->low) <= 1e-9 * fabs(row->low))
        return row->low;
    return fabs(degrees - row->high) <= 1e-9 * fabs(row->high) ? row->high : degrees;
}

static void raster_at(const lf_param *row, const void *object, double out[2])
{
    memcpy(out, (const char *)object + row->place, 2 * sizeof *out);
    out[1] = out[1] == 0.0 ? out[0] : out[1];
}

static void put_raster(const lf_param *row, const double value[2], void *object)
{
    const double kept[2] = {value[0], value[1] == value[0] ? 0.0 : value[1]};
    memcpy((char *)object + row->place, kept, sizeof kept);
}

static double number_at(const lf_param *row, const void *object)
{
    const char *field = (const char *)object + row->place;
    switch (row->type) {
    case LF_PARAM_NUMBER:
    case LF_PARAM_RASTER:
        return *(const double *)(const void *)field;
    case LF_PARAM_ANGLE:
        return settle(row, *(const double *)(const void *)field * (180.0 / M_PI));
    case LF_PARAM_SWITCH:
        return *(const bool *)(const void *)field;
    default:
        return *(const int *)(const void *)field;
    }
}

static const char **text_place(const lf_param *row, const void *object)
{
    return (const char **)((uintptr_t)object + row->place);
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
    case LF_PARAM_NAME:
        *text_place(row, object) = word_of(row, (int)value);
        break;
    case LF_PARAM_LIST:
        *(unsigned *)(void *)field = (unsigned)value;
        break;
    case LF_PARAM_RASTER:
        put_raster(row, (double[2]){value, value}, object);
        break;
    default:
        *(int *)(void *)field = (int)value;
    }
}

static void put_initial(const lf_param *row, void *object)
{
    switch (row->type) {
    case LF_PARAM_TEXT:
    case LF_PARAM_NAME:
    case LF_PARAM_FILE:
        *text_place(row, object) = NULL;
        break;
    case LF_PARAM_POINT:
    case LF_PARAM_COLOUR:
    case LF_PARAM_DIRECTION:
        memcpy(point_place(row, object), row->point, sizeof row->point);
        break;
    default:
        assert(row->type != LF_PARAM_SEED && row->type != LF_PARAM_LIST); /* not in JSON */
        put_number(row, row->initial, object);
    }
}

void lf_param_defaults(const lf_param *params, void *object)
{
    for (const lf_param *row = params; !is_end(row); row++)
        if (row->name)
            put_initial(row, object);
}

/* ------------------------------------------------------------------------------------ values -- */

static int word_index(const lf_param *row, const char *text)
{
    for (int i = 0; word_of(row, i); i++)
        if (strcmp(word_of(row, i), text) == 0)
            return i;
    return -1;
}

/* The bits of "all", "none" or "word,word". */
static bool read_list(const lf_param *row, const char *text, double *out)
{
    const bool all = strcmp(text, "all") == 0;
    char word[64];
    unsigned bits = 0;
    if (all || strcmp(text, "none") == 0) {
        *out = all ? (double)((1u << count_words(row)) - 1) : 0.0;
        return true;
    }
    for (;; text++) {
        const size_t length = strcspn(text, ",");
        if (length >= sizeof word)
            return false;
        memcpy(word, text, length);
        word[length] = '\0';
        const int index = word_index(row, word);
        if (index < 0)
            return false;
        bits |= 1u << index;
        text += length;
        if (*text == '\0')
            break;
    }
    *out = bits;
    return true;
}

/* "N" or "NxM". */
static bool read_raster(const lf_param *row, const char *text, double out[2])
{
    double pair[2];
    if (lf_parse_pair("", text, 'x', row->low, row->high, pair, NULL) != LF_OK) {
        if (lf_parse_double("", text, row->low, row->high, &pair[0], NULL) != LF_OK)
            return false;
        pair[1] = pair[0];
    }
    memcpy(out, pair, sizeof pair);
    return true;
}

/* The value of a text; not for rasters. */
static bool read_value(const lf_param *row, const char *text, double *out)
{
    int index = word_of(row, 0) && text ? word_index(row, text) : -1;
    index = row->optional && !text ? (int)row->low : index;
    int64_t whole = 0;
    if (row->type == LF_PARAM_LIST)
        return text && read_list(row, text, out);
    if (has_words(row)) {
        *out = index;
        return index >= 0 && (row->type != LF_PARAM_WHOLE || lf_decimal_is(text, out));
    }
    if (index >= 0) {
        *out = index == 0 ? (double)INFINITY : -(double)INFINITY;
        return true;
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
    if (has_words(row) && row->type == LF_PARAM_WHOLE) {
        snprintf(text, sizeof text, "%.0f", value);
        return word_index(row, text) >= 0;
    }
    if (has_words(row) || row->type == LF_PARAM_SWITCH)
        return value >= 0.0 && value < (has_words(row) ? count_words(row) : 2);
    if (is_mixed(row) && isinf(value))
        return value > 0.0 || word_of(row, 1);
    return value >= row->low && value <= row->high; /* false for NaN */
}

/* Appends the words, comma-separated, with `last` (if not NULL) before the final one. */
static void join_words(const lf_param *row, const char *last, char *buf, size_t size)
{
    for (int i = 0; word_of(row, i); i++) {
        const size_t used = strlen(buf);
        const char *between = i == 0 ? "" : last && !word_of(row, i + 1) ? last : ", ";
        snprintf(buf + used, size - used, "%s%s", between, word_of(row, i));
    }
}

/* Describes the allowed values: "a number from 5 to 600", "none, lzw or deflate". */
static char *describe(const lf_param *row, char *buf, size_t size)
{
    const bool list = row->type == LF_PARAM_LIST;
    buf[0] = '\0';
    if (!has_words(row))
        snprintf(buf, size, "a%s number from %.10g to %.10g%s%s%s",
                 row->type == LF_PARAM_WHOLE ? " whole" : "", row->low, row->high,
                 row->unit ? " " : "", row->unit ? row->unit : "",
                 row->type == LF_PARAM_RASTER ? ", or two as XxY" : "");
    else if (list)
        snprintf(buf, size, "all, none or some of ");
    if (is_mixed(row))
        snprintf(buf + strlen(buf), size - strlen(buf), ", ");
    join_words(row, list ? NULL : " or ", buf, size);
    return buf;
}

/* -------------------------------------------------------------------------- the command line -- */

char *lf_param_argument(const lf_param *row, char *buf, size_t size)
{
    size_t used = 0;
    buf[0] = '\0';
    if (row->optional) {
        snprintf(buf, size, "[%s]", row->argument);
        return buf;
    }
    for (const lf_param *end = lf_param_next(row); row < end && used < size; row++)
        used +=
            (size_t)snprintf(buf + used, size - used, "%s%s", row->argument ? row->argument : "",
                             row->joined ? row->joined : "");
    return buf;
}

static lf_status refuse(const lf_param *row, const char *text, lf_error *err)
{
    char where[64], argument[64], expected[640], one[WORDS_SIZE];
    size_t used = 0;
    snprintf(where, sizeof where, "--%s", row->option);
    lf_param_argument(row, argument, sizeof argument);
    for (int i = 0; row->refused_at && row->refused_at(i); i++)
        if (strcmp(row->refused_at(i), text) == 0)
            return lf_error_set(err, LF_E_ARG, where, "%s %s", text, row->refusal);
    if (!row->joined)
        return lf_error_set(err, LF_E_ARG, where, "expects %s, not \"%s\"",
                            describe(row, one, sizeof one), text);
    for (const lf_param *r = row; r < lf_param_next(row) && used < sizeof expected; r++)
        used += (size_t)snprintf(expected + used, sizeof expected - used, ", %s %s", r->argument,
                                 describe(r, one, sizeof one));
    return lf_error_set(err, LF_E_ARG, where, "expects %s%s, not \"%s\"", argument, expected, text);
}

static bool read_part(const lf_param *row, const char *text, double value[2])
{
    return row->type == LF_PARAM_RASTER ? read_raster(row, text, value)
                                        : read_value(row, text, value);
}

/* Reads the parts of an option's text into value[0], value[1] …. */
static bool read_parts(const lf_param *row, const char *text, double (*value)[2])
{
    char part[64];
    for (; row->joined; row++, value++) {
        const char *cut = strstr(text, row->joined);
        const size_t n = cut ? (size_t)(cut - text) : sizeof part;
        if (n >= sizeof part)
            return false;
        memcpy(part, text, n);
        part[n] = '\0';
        if (!read_part(row, part, *value))
            return false;
        text = cut + strlen(row->joined);
    }
    return read_part(row, text, *value);
}

static lf_status take_seed(const lf_param *row, const char *text, void *object, lf_error *err)
{
    char where[64];
    snprintf(where, sizeof where, "--%s", row->option);
    return lf_parse_seed(where, text, (uint64_t *)((uintptr_t)object + row->place), err);
}

static lf_status take_parts(const lf_param *row, const char *text, void *object, lf_error *err)
{
    double value[MAX_JOINED][2] = {{0}};
    assert(lf_param_next(row) - row <= MAX_JOINED);
    if (!read_parts(row, text, value))
        return refuse(row, text, err);
    for (const lf_param *r = row; r < lf_param_next(row); r++)
        if (r->type == LF_PARAM_RASTER)
            put_raster(r, value[r - row], object);
        else
            put_number(r, value[r - row][0], object);
    return LF_OK;
}

lf_status lf_param_from_text(const lf_param *row, const char *text, void *object, lf_error *err)
{
    lf_status status = LF_OK;
    if (row->type == LF_PARAM_TEXT)
        *text_place(row, object) = text;
    else
        status = row->type == LF_PARAM_SEED ? take_seed(row, text, object, err)
                                            : take_parts(row, text, object, err);
    if (status == LF_OK && row->has)
        *((bool *)object + row->has) = true;
    return status;
}

/* The common unit of an option's rows; NULL: none. */
static const char *common_unit(const lf_param *row)
{
    const char *unit = row->joined ? row->unit : NULL;
    for (const lf_param *end = lf_param_next(row); unit && row < end; row++)
        if (!row->unit || strcmp(row->unit, unit) != 0)
            unit = NULL;
    return unit;
}

/* The words, with the default marked or a description of each. */
static void describe_words(const lf_param *row, char *buf, size_t size)
{
    for (int i = 0; word_of(row, i); i++) {
        const char *what = row->what_at ? row->what_at(i) : "";
        const size_t used = strlen(buf);
        snprintf(buf + used, size - used, "%s%s%s%s%s",
                 i == 0                ? ""
                 : row->what_at        ? "; "
                 : word_of(row, i + 1) ? ", "
                                       : " or ",
                 word_of(row, i), i == (int)row->initial ? " (default)" : "", *what ? ": " : "",
                 what);
    }
}

/* Help text, words, default number, or the common unit. */
static void describe_option(const lf_param *row, char *buf, size_t size)
{
    size_t used = (size_t)snprintf(buf, size, "%s", row->help ? row->help : "");
    if (used >= size)
        return;
    if (common_unit(row))
        snprintf(buf + used, size - used, ", in %s", common_unit(row));
    if (!has_words(row) && (row->joined || row->type == LF_PARAM_SWITCH || row->initial == 0.0))
        return;
    if (!has_words(row) || row->type == LF_PARAM_WHOLE) {
        snprintf(buf + used, size - used, " (%g)", row->initial);
        return;
    }
    if (row->help)
        snprintf(buf + used, size - used, ": ");
    if (row->type == LF_PARAM_LIST)
        join_words(row, NULL, buf, size);
    else
        describe_words(row, buf, size);
}

/* Prints text wrapped from HELP_COLUMN on. */
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

void lf_param_print_help(const lf_param *params, const char *names)
{
    char argument[64], help[2000];
    for (const lf_param *row = params; !is_end(row); row = lf_param_next(row)) {
        if (row->former || !lf_param_among(row, names))
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
    const bool worded = has_words(row) || (is_mixed(row) && json_is_string(value));
    if (row->type == LF_PARAM_POINT)
        return take_point(row, value, object);
    if (row->type == LF_PARAM_RASTER && json_is_string(value)) {
        double raster[2];
        if (!read_raster(row, json_string_value(value), raster))
            return false;
        put_raster(row, raster, object);
        return true;
    }
    if (row->type == LF_PARAM_TEXT) {
        if (json_is_string(value))
            *text_place(row, object) = json_string_value(value);
        return json_is_string(value);
    }
    if (worded && row->type != LF_PARAM_WHOLE) {
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
    char pointer[64], expected[WORDS_SIZE];
    for (const lf_param *row = params; !is_end(row); row++) {
        const json_t *value = row->name ? json_object_get(values, row->name) : NULL;
        if (!value || take_json(row, value, object))
            continue;
        snprintf(pointer, sizeof pointer, "/%s", row->name);
        return lf_error_set_at(err, LF_E_ARG, where, 0, pointer, "expected %s",
                               row->type == LF_PARAM_TEXT    ? "a string"
                               : row->type == LF_PARAM_POINT ? "three numbers"
                               : row->type == LF_PARAM_SWITCH && !has_words(row)
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
    char expected[WORDS_SIZE];
    for (const lf_param *row = params; !is_end(row); row++) {
        if (!row->name || is_text(row) || row->type == LF_PARAM_POINT)
            continue;
        double value = number_at(row, object), raster[2];
        if (row->type == LF_PARAM_RASTER) {
            raster_at(row, object, raster);
            value = is_allowed(row, value) ? raster[1] : value;
        }
        if (!is_allowed(row, value) && (row->required || value != row->initial))
            return lf_error_set(err, LF_E_ARG, where, "%s %g: expected %s", row->name, value,
                                describe(row, expected, sizeof expected));
    }
    return LF_OK;
}

/* One number as JSON number; two as the option's text. */
static json_t *raster_json(const lf_param *row, const void *object)
{
    double raster[2];
    raster_at(row, object, raster);
    if (raster[0] != raster[1])
        return json_sprintf("%.10gx%.10g", raster[0], raster[1]);
    return raster[0] == floor(raster[0]) ? json_integer((json_int_t)raster[0])
                                         : json_real(raster[0]);
}

static json_t *value_json(const lf_param *row, const void *object)
{
    if (row->type == LF_PARAM_RASTER)
        return raster_json(row, object);
    if (is_text(row)) {
        const char *text = *text_place(row, object);
        json_t *string = text ? json_string(text) : NULL;
        return string ? string : json_null(); /* a path that is not UTF-8 */
    }
    if (row->type == LF_PARAM_POINT) {
        const double *point = point_place(row, object);
        return json_pack("[f, f, f]", point[0], point[1], point[2]);
    }
    const double value = number_at(row, object);
    if (has_words(row) && row->type != LF_PARAM_WHOLE)
        return json_string(word_of(row, (int)value));
    if (is_mixed(row) && isinf(value))
        return json_string(word_of(row, value < 0.0));
    if (row->type == LF_PARAM_SWITCH)
        return json_boolean(value != 0.0);
    return row->type == LF_PARAM_WHOLE ? json_integer((json_int_t)value) : json_real(value);
}

json_t *lf_param_json(const lf_param *params, const void *object)
{
    json_t *out = json_object();
    bool ok = out;
    for (const lf_param *row = params; ok && !is_end(row); row++)
        if (row->name && !row->former)
            ok = json_object_set_new(out, row->name, value_json(row, object)) == 0;
    if (ok)
        return out;
    json_decref(out);
    return NULL;
}

static json_t *words_json(const lf_param *row)
{
    json_t *words = json_array();
    int64_t whole;
    for (int i = 0; words && word_of(row, i); i++)
        json_array_append_new(words,
                              row->type == LF_PARAM_WHOLE && lf_integer_is(word_of(row, i), &whole)
                                  ? json_integer(whole)
                                  : json_string(word_of(row, i)));
    return words;
}

static json_t *row_schema(const lf_param *row)
{
    const char *type = row->type == LF_PARAM_WHOLE                    ? "integer"
                       : has_words(row) || row->type == LF_PARAM_TEXT ? "string"
                       : row->type == LF_PARAM_SWITCH                 ? "boolean"
                                                                      : "number";
    if (has_words(row))
        return json_pack("{s:s, s:o}", "type", type, "enum", words_json(row));
    if (row->or_object)
        return json_pack("{s:[s, s], s:f, s:f, s:b}", "type", "integer", "object", "minimum",
                         row->low, "maximum", row->high, "additionalProperties", true);
    if (row->type == LF_PARAM_SWITCH || row->type == LF_PARAM_TEXT)
        return json_pack("{s:s}", "type", type);
    /* strings first, because quiltctl distinguishes text in this order */
    if (is_mixed(row) || row->type == LF_PARAM_RASTER)
        return json_pack("{s:[s, s], s:f, s:f}", "type", "string", type, "minimum", row->low,
                         "maximum", row->high);
    json_t *number =
        json_pack("{s:s, s:f, s:f}", "type", type, "minimum", row->low, "maximum", row->high);
    if (row->type != LF_PARAM_POINT)
        return number;
    return json_pack("{s:s, s:o, s:i, s:i}", "type", "array", "items", number, "minItems", 3,
                     "maxItems", 3);
}

/* The default value; NULL: none. */
static json_t *default_json(const lf_param *row)
{
    const double value = row->initial;
    if (row->required || row->has || is_text(row) || row->type == LF_PARAM_POINT ||
        row->or_object || !is_allowed(row, value))
        return NULL;
    if (has_words(row) && row->type != LF_PARAM_WHOLE)
        return json_string(word_of(row, (int)value));
    if (row->type == LF_PARAM_SWITCH)
        return json_boolean(value != 0.0);
    return value == floor(value) ? json_integer((json_int_t)value) : json_real(value);
}

static bool describe_schema(const lf_param *row, json_t *schema)
{
    const char *text = row->about ? row->about : row->help;
    json_t *initial = default_json(row);
    return (!text || json_object_set_new(schema, "description", json_string(text)) == 0) &&
           (!is_mixed(row) || json_object_set_new(schema, "words", words_json(row)) == 0) &&
           (!row->unit || json_object_set_new(schema, "unit", json_string(row->unit)) == 0) &&
           (!row->former || lf_former_mark(schema, row->former)) &&
           (!initial || json_object_set_new(schema, "default", initial) == 0);
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
    if (ok)
        return out;
    json_decref(out);
    return NULL;
}
