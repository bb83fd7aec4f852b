#include "render/reader/words.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define LONGEST_NUMBER 128

const char *lf_word(const char **at, size_t *out_n)
{
    const char *word = lf_skip_blanks(*at), *end = word;
    while (*end && !lf_is_blank(*end))
        end++;
    *out_n = (size_t)(end - word);
    *at = end;
    return word;
}

bool lf_word_is(const char *word, size_t n, const char *expected)
{
    return strncmp(word, expected, n) == 0 && expected[n] == '\0';
}

bool lf_word_reads(const char *word, size_t n, const char *expected)
{
    return strncasecmp(word, expected, n) == 0 && expected[n] == '\0';
}

char *lf_rest(char *at)
{
    while (lf_is_blank(*at))
        at++;
    size_t n = strlen(at);
    while (n > 0 && lf_is_blank(at[n - 1]))
        n--;
    at[n] = '\0';
    return at;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A decimal number as its digits, as many as a word holds, and a power of ten. */
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

/* What printf writes for what is no number: nan, -nan(ind), inf, 1.#QNAN, -1.#INF. */
static bool read_unusual(const char *word, size_t n, double *out)
{
    bool minus = *word == '-';
    if (n > 0 && (*word == '-' || *word == '+')) {
        word++;
        n--;
    }
    if (n >= 3 && strncmp(word, "1.#", 3) == 0) {
        word += 3;
        n -= 3;
        *out = n >= 3 && strncasecmp(word, "inf", 3) == 0 ? (double)INFINITY : (double)NAN;
    } else if (n >= 3 && strncasecmp(word, "inf", 3) == 0) {
        *out = (double)INFINITY;
    } else if (n >= 3 && strncasecmp(word, "nan", 3) == 0) {
        *out = (double)NAN;
    } else {
        return false;
    }
    *out = minus ? -*out : *out;
    return true;
}

/* A number that is all of a word, by the library. */
static bool read_by_library(const char *word, size_t n, double *out)
{
    char text[LONGEST_NUMBER], *end, *comma;
    if (n == 0 || n >= sizeof text)
        return false;
    memcpy(text, word, n);
    text[n] = '\0';
    comma = strchr(text, ',');
    if (comma)
        *comma = '.';
    *out = strtod(text, &end);
    return *end == '\0';
}

bool lf_number(const char **at, double *out)
{
    static const double tens[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                  1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *word = lf_skip_blanks(*at), *p = word;
    decimal d = {0};
    bool minus = *p == '-';
    if (*p == '-' || *p == '+')
        p++;
    const char *first = p;
    p = read_digits(p, 0, &d);
    bool some = p > first;
    if (*p == '.' || *p == ',') {
        first = p + 1;
        p = read_digits(first, 1, &d);
        some = some || p > first;
    }
    if (some && (*p == 'e' || *p == 'E'))
        p = read_exponent(p, &d.exponent);
    if (!some || (*p && !lf_is_blank(*p))) {
        size_t n;
        p = word;
        word = lf_word(&p, &n);
        if (!read_unusual(word, n, out))
            return false;
    } else if (!d.cut && d.digits < UINT64_C(1) << 53 && abs(d.exponent) <= 22) {
        /* both are exact, so one rounding is all (Clinger 1990) */
        double v = (double)d.digits;
        v = d.exponent < 0 ? v / tens[-d.exponent] : v * tens[d.exponent];
        *out = minus ? -v : v;
    } else if (!read_by_library(word, (size_t)(p - word), out)) {
        return false;
    }
    *at = p;
    return true;
}

bool lf_numbers(const char **at, int n, double *out)
{
    const char *p = *at;
    for (int i = 0; i < n; i++)
        if (!lf_number(&p, &out[i]))
            return false;
    *at = p;
    return true;
}

bool lf_integer(const char **at, int64_t *out)
{
    const char *p = lf_skip_blanks(*at);
    bool minus = *p == '-';
    int64_t value = 0;
    if (*p == '-' || *p == '+')
        p++;
    if (!is_digit(*p))
        return false;
    for (; is_digit(*p); p++) {
        if (value > INT64_MAX / 10 - 1)
            return false;
        value = 10 * value + (*p - '0');
    }
    if (*p && *p != '/' && !lf_is_blank(*p))
        return false;
    *out = minus ? -value : value;
    *at = p;
    return true;
}
