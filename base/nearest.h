/* nearest: what somebody may have meant who wrote a word that is unknown. Pure functions. */
#ifndef LF_BASE_NEAREST_H
#define LF_BASE_NEAREST_H

/* The name among names (ended by NULL) that is nearest to word, or NULL when none is near enough to
 * be meant. */
const char *lf_nearest_name(const char *word, const char *const names[]);

#endif
