/* What the files of a scene hold and its pictures lack, as lines for people: collected while things
 * are loaded, kept by what was loaded; private to render/ (the scene's own are lf_scene_warning).
 */
#ifndef LF_RENDER_WARNINGS_H
#define LF_RENDER_WARNINGS_H

#include "base/status.h"

#define LF_MAX_WARNINGS 64

/* Zeroed: none. */
typedef struct lf_warnings {
    int n;    /* lines kept */
    int more; /* lines that had no room */
    char *line[LF_MAX_WARNINGS];
    char rest[64]; /* says how many more */
} lf_warnings;

/* Adds the line "WHERE: WHAT", once however often it comes; control characters are escaped, what is
 * too long is cut. Without memory the line is only counted: that is no reason to fail. */
void lf_warnings_add(lf_warnings *warnings, const char *where, const char *fmt, ...)
    LF_PRINTF(3, 4);
/* Adds "WHERE: 1 ONE" or "WHERE: N MANY"; nothing where n is 0. */
void lf_warnings_count(lf_warnings *warnings, const char *where, long long n, const char *one,
                       const char *many);
/* Adds another collection's lines. */
void lf_warnings_add_all(lf_warnings *warnings, const lf_warnings *others);
/* Line number index, the one about the rest last; NULL behind it. Valid until the next change. */
const char *lf_warnings_at(const lf_warnings *warnings, int index);
/* Accepts one that is all zero; leaves it so. */
void lf_warnings_finish(lf_warnings *warnings);

#endif
