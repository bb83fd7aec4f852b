#include "render/import/reader/words.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/number.h"

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

bool lf_line_ends(const char *at)
{
    at = lf_skip_blanks(at);
    return *at == '\0' || *at == '#';
}

/* printf's words for NaN and infinity: nan, -nan(ind), inf, infinity, 1.#QNAN, -1.#INF. Only whole
 * words, because an image may be called Nancy.png. */
static bool read_unusual(const char *word, size_t n, double *out)
{
    bool minus = *word == '-';
    if (n > 0 && (*word == '-' || *word == '+')) {
        word++;
        n--;
    }
    if (n >= 3 && strncmp(word, "1.#", 3) == 0)
        *out = n >= 6 && strncasecmp(word + 3, "inf", 3) == 0 ? (double)INFINITY : (double)NAN;
    else if (lf_word_reads(word, n, "inf") || lf_word_reads(word, n, "infinity"))
        *out = (double)INFINITY;
    else if (lf_word_reads(word, n, "nan") || (n > 4 && strncasecmp(word, "nan(", 4) == 0))
        *out = (double)NAN;
    else
        return false;
    *out = minus ? -*out : *out;
    return true;
}

bool lf_number(const char **at, double *out)
{
    const char *word = lf_skip_blanks(*at), *end = lf_decimal_read(word, ".,", out);
    if (!end || (*end && !lf_is_blank(*end))) {
        size_t n;
        end = word;
        word = lf_word(&end, &n);
        if (!read_unusual(word, n, out))
            return false;
    }
    *at = end;
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
    const bool minus = *p == '-';
    uint64_t value;
    p = lf_whole_read(p + (*p == '-' || *p == '+'), &value);
    if (!p || value > INT64_MAX || (*p && *p != '/' && !lf_is_blank(*p)))
        return false;
    *out = minus ? -(int64_t)value : (int64_t)value;
    *at = p;
    return true;
}
