/* number: reads decimal numbers from external text: options, arguments, names, files. Independent
 * of the locale. Only decimal digits count: hexadecimal, "inf" and "nan" are not numbers. A number
 * does not start with blanks. Pure functions; out is untouched on failure. No other code reads
 * numbers with the C library's functions, except for the header of HDR pictures and texts of the
 * kernel and of quiltd itself (tests/style.sh). */
#ifndef LF_BASE_NUMBER_H
#define LF_BASE_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/* Reads the longest number at the start of a text, rounded to the nearest double: optional sign,
 * digits with an optional point, optional exponent (1, -.5, 1e-3). points: the accepted decimal
 * points, "." or ".,". Beyond the range of doubles it is infinity or 0. Returns the text after it;
 * NULL: no number. */
const char *lf_decimal_read(const char *text, const char *points, double *out);
/* Like lf_decimal_read for digits only, up to 2^64 - 1; a larger number is not read. */
const char *lf_whole_read(const char *text, uint64_t *out);

/* True if a whole text is a finite number, with "." as the point. */
bool lf_decimal_is(const char *text, double *out);
/* True if a whole text is digits; lf_integer_is: with an optional sign. */
bool lf_whole_is(const char *text, uint64_t *out);
bool lf_integer_is(const char *text, int64_t *out);

#endif
