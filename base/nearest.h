/* nearest: suggestions for unknown words. Pure functions. */
#ifndef LF_BASE_NEAREST_H
#define LF_BASE_NEAREST_H

/* The name among names (ended by NULL) that is nearest to word; NULL: none is near enough to
 * suggest. */
const char *lf_nearest_name(const char *word, const char *const names[]);

#endif
