/* Words and numbers of a line of text. What does not fit says so and leaves *at where it was. No
 * locale has any part in it. */
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

/* The next word of *at, whose length is *out_n: 0 at the end of the line. */
const char *lf_word(const char **at, size_t *out_n);
/* Whether a word of n bytes is this one. */
bool lf_word_is(const char *word, size_t n, const char *expected);
/* The same whatever the case. */
bool lf_word_reads(const char *word, size_t n, const char *expected);
/* What is left of a line without blanks around it, in place. */
char *lf_rest(char *at);
/* Whether nothing but blanks and a comment is left of a line. */
bool lf_line_ends(const char *at);

/* The next word as a number, as lf_decimal_read (base/number.h) does: 1, -.5, 1e-3, with a comma
 * for the point (as programs write it that follow a locale), and what printf makes of what is none
 * (nan, -inf, 1.#QNAN), which gives NaN or an infinity. */
bool lf_number(const char **at, double *out);
/* n of them. */
bool lf_numbers(const char **at, int n, double *out);
/* A whole number that ends at a blank, a slash or the end of the line. */
bool lf_integer(const char **at, int64_t *out);

#endif
