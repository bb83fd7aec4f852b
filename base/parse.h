/* parse: numbers from typed text. The whole text must be a number (base/number.h) within a range.
 * Pure functions; out is untouched on failure. */
#ifndef LF_BASE_PARSE_H
#define LF_BASE_PARSE_H

#include <stdint.h>

#include "base/status.h"

/* Parses a number within [low, high]; option names it in the error (LF_E_ARG). NaN and infinities
 * are refused. */
LF_NODISCARD lf_status lf_parse_int(const char *option, const char *text, int64_t low, int64_t high,
                                    int64_t *out, lf_error *err);
LF_NODISCARD lf_status lf_parse_double(const char *option, const char *text, double low,
                                       double high, double *out, lf_error *err);
/* Like lf_parse_int, into an int. */
LF_NODISCARD lf_status lf_parse_small(const char *option, const char *text, int low, int high,
                                      int *out, lf_error *err);
/* "A<separator>B", e.g. "420x560" or "60.13@600", each within [low, high]. */
LF_NODISCARD lf_status lf_parse_pair(const char *option, const char *text, char separator,
                                     double low, double high, double out[2], lf_error *err);
/* A size in memory: a positive number of bytes, or with K, M, G or T of 1024, 1024^2 … bytes; at
 * most 1e18. */
LF_NODISCARD lf_status lf_parse_bytes(const char *option, const char *text, double *out,
                                      lf_error *err);
/* Parses 0..2^64-1, decimal. */
LF_NODISCARD lf_status lf_parse_seed(const char *option, const char *text, uint64_t *out,
                                     lf_error *err);

#endif
