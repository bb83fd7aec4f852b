/* Former names of options, parameters and keys. They are read for two releases after their names
 * were replaced: the first release reads them in silence, later ones also log one line per use.
 * Scene files are not affected: their former keys are read for ever, in silence
 * (render/import/scene/former_keys.h). */
#ifndef LF_BASE_FORMER_H
#define LF_BASE_FORMER_H

#include <stdbool.h>

/* The release that replaced the names: MAJOR.MINOR. */
#define LF_FORMER_SINCE "0.2"

/* Whether a program of this version (MAJOR.MINOR.PATCH) is of a later release than the one that
 * replaced the names, and so logs their use. */
bool lf_former_is_logged(const char *version);

/* Logs a warning that `old` is a former name of `now`, if this version does. Both are as the user
 * writes them: "--lie", "reconstruct". Any thread. */
void lf_former_used(const char *old, const char *now);

#endif
