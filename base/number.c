#include "base/number.h"

#include <locale.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define LONGEST_COPY 400

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A decimal number: as many digits as a word holds, and a power of ten. */
typedef struct decimal {
    uint64_t digits;
    int exponent;
    bool cut; /* there were more digits */
} decimal;

static const char *read_digits(const char *at, int step, decimal *d)
{
    for (; is_digit(*at); at++) {
        bool fits = d->digits <= (UINT64_MAX - 9) / 10;
        if (fits)
            d->digits = 10 * d->digits + (uint64_t)(*at - '0');
        d->cut = d->cut || !fits;
        if (abs(d->exponent) < 1 << 20)
            d->exponent += (fits ? 0 : 1) - step;
    }
    return at;
}

static const char *read_exponent(const char *at, int *exponent)
{
    const char *from = at + 1;
    bool minus = *from == '-';
    int value = 0;
    if (*from == '-' || *from == '+')
        from++;
    if (!is_digit(*from))
        return at;
    for (; is_digit(*from); from++)
        value = value < 100000 ? 10 * value + (*from - '0') : value;
    *exponent += minus ? -value : value;
    return from;
}

/* Converts with the library, in the C locale, which no program changes; the number ends at
 * `end`. */
static bool read_by_library(const char *text, const char *end, double *out)
{
    char copy[LONGEST_COPY], *comma;
    const size_t n = (size_t)(end - text);
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (n >= sizeof copy || !plain)
        return false;
    memcpy(copy, text, n);
    copy[n] = '\0';
    comma = strchr(copy, ',');
    if (comma)
        *comma = '.';
    *out = strtod_l(copy, NULL, plain);
    freelocale(plain);
    return true;
}

const char *lf_decimal_read(const char *text, const char *points, double *out)
{
    static const double tens[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                  1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *p = text;
    decimal d = {0};
    bool minus = *p == '-';
    if (*p == '-' || *p == '+')
        p++;
    const char *first = p;
    p = read_digits(p, 0, &d);
    bool some = p > first;
    if (*p == points[0] || (*p && *p == points[1])) {
        const char *behind = read_digits(p + 1, 1, &d);
        bool fraction = behind > p + 1;
        p = some || fraction ? behind : p;
        some = some || fraction;
    }
    if (!some)
        return NULL;
    if (*p == 'e' || *p == 'E')
        p = read_exponent(p, &d.exponent);
    if (!d.cut && d.digits < UINT64_C(1) << 53 && abs(d.exponent) <= 22) {
        /* both are exact, so there is a single rounding (Clinger 1990) */
        double v = (double)d.digits;
        v = d.exponent < 0 ? v / tens[-d.exponent] : v * tens[d.exponent];
        *out = minus ? -v : v;
        return p;
    }
    return read_by_library(text, p, out) ? p : NULL;
}

const char *lf_whole_read(const char *text, uint64_t *out)
{
    uint64_t value = 0;
    const char *at = text;
    for (; is_digit(*at); at++)
        if (__builtin_mul_overflow(value, UINT64_C(10), &value) ||
            __builtin_add_overflow(value, (uint64_t)(*at - '0'), &value))
            return NULL;
    if (at == text)
        return NULL;
    *out = value;
    return at;
}

bool lf_decimal_is(const char *text, double *out)
{
    double value;
    const char *end = lf_decimal_read(text, ".", &value);
    if (!end || *end != '\0' || !isfinite(value))
        return false;
    *out = value;
    return true;
}

bool lf_whole_is(const char *text, uint64_t *out)
{
    uint64_t value;
    const char *end = lf_whole_read(text, &value);
    if (!end || *end != '\0')
        return false;
    *out = value;
    return true;
}

bool lf_integer_is(const char *text, int64_t *out)
{
    uint64_t value;
    const bool minus = *text == '-';
    if (!lf_whole_is(text + (*text == '-' || *text == '+'), &value) ||
        value > (uint64_t)INT64_MAX + minus)
        return false;
    *out = minus ? (int64_t)(0 - value) : (int64_t)value;
    return true;
}
