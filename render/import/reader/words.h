/* Words and numbers of a line of text. A function that fails leaves *at unchanged. Independent of
 * the locale. */
#ifndef LF_RENDER_WORDS_H
#define LF_RENDER_WORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

static inline bool lf_is_blank(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static inline const char *lf_skip_blanks(const char *at)
{
    while (lf_is_blank(*at))
        at++;
    return at;
}

/* The next word of *at, with its length in *out_n: 0 at the end of the line. */
const char *lf_word(const char **at, size_t *out_n);
/* Whether a word of n bytes equals expected. */
bool lf_word_is(const char *word, size_t n, const char *expected);
/* lf_word_is, ignoring case. */
bool lf_word_reads(const char *word, size_t n, const char *expected);
/* The remaining line without surrounding blanks, in place. */
char *lf_rest(char *at);
/* Whether only blanks and a comment remain. */
bool lf_line_ends(const char *at);

/* Parses the next word as a number, as lf_decimal_read (base/number.h): 1, -.5, 1e-3, also with a
 * decimal comma (of programs that follow a locale). printf's forms of NaN and infinity (nan, -inf,
 * 1.#QNAN) give NaN or an infinity. */
bool lf_number(const char **at, double *out);
/* Parses n numbers. */
bool lf_numbers(const char **at, int n, double *out);
/* Parses an integer that ends at a blank, a slash or the end of the line. */
bool lf_integer(const char **at, int64_t *out);

#endif
