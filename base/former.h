/* Former names of options and parameters. They are read for two releases after their names were
 * replaced: the first release reads them in silence, later ones also log a line. Scene files are
 * not affected: their former keys are read for ever, in silence
 * (render/import/scene/former_keys.h). Any thread. */
#ifndef LF_BASE_FORMER_H
#define LF_BASE_FORMER_H

#include <stdbool.h>

struct json_t;

/* The release that replaced the names: MAJOR.MINOR. */
#define LF_FORMER_SINCE "0.2"

/* Whether a program of this version (MAJOR.MINOR.PATCH) is of a later release than the one that
 * replaced the names, and so logs their use. */
bool lf_former_is_logged(const char *version);

/* Logs a warning that `where` used `old`, the former name of `now`, if a program of this version
 * (LF_VERSION) does; once per name and process, because a client may call many times a second.
 * where: what the names belong to, "render.set", or NULL. True if it logged. */
bool lf_former_used(const char *version, const char *where, const char *old, const char *now);

/* Marks a JSON Schema as the one of a former name: "deprecated" (JSON Schema's word) and
 * "former_name_of". now: the current name; dashes become underscores. False: out of memory. */
bool lf_former_mark(struct json_t *schema, const char *now);
/* The current name, if a schema is the one of a former name; NULL: it is not. Borrowed. */
const char *lf_former_name_of(const struct json_t *schema);

#endif
