/* nearest: suggestions for unknown words. Pure functions. */
#ifndef LF_BASE_NEAREST_H
#define LF_BASE_NEAREST_H

#include "base/status.h"

/* The name among names (ended by NULL) that is nearest to word; NULL: none is near enough to
 * suggest. */
const char *lf_nearest_name(const char *word, const char *const names[]);

/* Sets err to "WORD: unknown WHAT; did you mean NAME?", or "…; see --help" if no name is near.
 * Returns LF_E_ARG. */
lf_status lf_nearest_refuse(const char *word, const char *what, const char *const names[],
                            lf_error *err);

#endif
