/* Options written back as words of a command line. */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/number.h"
#include "base/param.h"

#define SHORT 192 /* numbers, words and lists of words */

static const void *field_of(const lf_param *row, const void *object)
{
    return (const char *)object + row->place;
}

static const char *word_at(const lf_param *row, int index)
{
    if (row->word_at)
        return row->word_at(index);
    return row->words ? row->words[index] : NULL;
}

static bool is_text(const lf_param *row)
{
    return row->type == LF_PARAM_TEXT || row->type == LF_PARAM_NAME;
}

/* Appends to a text; what has no room is left out. */
LF_PRINTF(3, 4) static void add(char *text, size_t size, const char *fmt, ...)
{
    const size_t used = strlen(text);
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(text + used, size - used, fmt, ap);
    va_end(ap);
}

/* The shortest text that reads back as the same number. */
static void add_number(const lf_param *row, double value, char *text, size_t size)
{
    char digits[40];
    double back = NAN;
    if (isinf(value)) {
        add(text, size, "%s", word_at(row, value < 0.0));
        return;
    }
    for (int n = 6; n <= 17 && back != value; n++) {
        snprintf(digits, sizeof digits, "%.*g", n, value);
        (void)lf_decimal_is(digits, &back);
    }
    add(text, size, "%s", digits);
}

static void add_raster(const lf_param *row, const double pair[2], char *text, size_t size)
{
    add_number(row, pair[0], text, size);
    if (pair[1] != 0.0 && pair[1] != pair[0]) {
        add(text, size, "x");
        add_number(row, pair[1], text, size);
    }
}

static void add_list(const lf_param *row, unsigned bits, char *text, size_t size)
{
    const char *between = "";
    if (bits == 0)
        add(text, size, "none");
    for (int i = 0; word_at(row, i); i++) {
        if (bits >> i & 1) {
            add(text, size, "%s%s", between, word_at(row, i));
            between = ",";
        }
    }
}

/* Not of texts. */
static void add_value(const lf_param *row, const void *object, char *text, size_t size)
{
    const void *field = field_of(row, object);
    const bool whole = row->type == LF_PARAM_WHOLE;
    switch (row->type) {
    case LF_PARAM_NUMBER:
        add_number(row, *(const double *)field, text, size);
        break;
    case LF_PARAM_RASTER:
        add_raster(row, field, text, size);
        break;
    case LF_PARAM_LIST:
        add_list(row, *(const unsigned *)field, text, size);
        break;
    case LF_PARAM_SEED:
        add(text, size, "%" PRIu64, *(const uint64_t *)field);
        break;
    case LF_PARAM_SWITCH:
        add(text, size, "%s", word_at(row, *(const bool *)field));
        break;
    default:
        if (whole)
            add(text, size, "%d", *(const int *)field);
        else
            add(text, size, "%s", word_at(row, *(const int *)field));
    }
}

char *lf_param_word(const lf_param *row, const void *object)
{
    char text[SHORT] = "";
    const char *value = text;
    if (is_text(row))
        value = *(const char *const *)field_of(row, object);
    else if (row->type == LF_PARAM_SWITCH && !row->words)
        value = NULL;
    else
        for (const lf_param *part = row, *end = lf_param_next(row); part < end; part++) {
            add_value(part, object, text, sizeof text);
            add(text, sizeof text, "%s", part->joined ? part->joined : "");
        }
    const size_t size = strlen(row->option) + (value ? strlen(value) : 0) + 4;
    char *word = lf_calloc(size, 1);
    if (word)
        snprintf(word, size, "--%s%s%s", row->option, value ? "=" : "", value ? value : "");
    return word;
}

static bool is_same(const lf_param *row, const void *object, const void *other)
{
    const void *a = field_of(row, object), *b = field_of(row, other);
    switch (row->type) {
    case LF_PARAM_TEXT:
    case LF_PARAM_NAME: {
        const char *x = *(const char *const *)a, *y = *(const char *const *)b;
        return x && y ? strcmp(x, y) == 0 : x == y;
    }
    case LF_PARAM_NUMBER:
    case LF_PARAM_ANGLE:
        return *(const double *)a == *(const double *)b;
    case LF_PARAM_RASTER:
        return memcmp(a, b, 2 * sizeof(double)) == 0;
    case LF_PARAM_SWITCH:
        return *(const bool *)a == *(const bool *)b;
    case LF_PARAM_SEED:
        return *(const uint64_t *)a == *(const uint64_t *)b;
    default:
        return *(const int *)a == *(const int *)b;
    }
}

bool lf_param_differs(const lf_param *row, const void *object, const void *other)
{
    const lf_param *end = lf_param_next(row);
    if (row->has)
        return *((const bool *)object + row->has);
    while (row < end && is_same(row, object, other))
        row++;
    return row < end;
}
