/* number: decimal numbers out of texts that anybody wrote: options, arguments, names, files. No
 * locale has any part in it, and nothing but decimal digits counts: hexadecimal, "inf" and "nan"
 * are no numbers. Blanks in front are none of a number. Pure functions; out untouched on failure.
 * Nothing else in the house reads numbers by the C library's functions, but for the header of HDR
 * pictures and texts of the kernel's and of our own (tests/style.sh). */
#ifndef LF_BASE_NUMBER_H
#define LF_BASE_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/* The longest number that a text begins with, rounded to the nearest double: a sign or none,
 * digits with a point among them or none, an exponent or none (1, -.5, 1e-3). points: the
 * characters that may stand for the point, "." or ".,". Beyond the range of doubles it is an
 * infinity or 0. Returns what is behind it; NULL: there is none. */
const char *lf_decimal_read(const char *text, const char *points, double *out);
/* The same of digits alone, up to 2^64 - 1; more of them are no number. */
const char *lf_whole_read(const char *text, uint64_t *out);

/* Whether all of a text is a number, with "." for the point; finite. */
bool lf_decimal_is(const char *text, double *out);
/* Whether all of a text is digits; a sign or none in front of them. */
bool lf_whole_is(const char *text, uint64_t *out);
bool lf_integer_is(const char *text, int64_t *out);

#endif
