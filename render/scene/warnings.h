/* Warnings about features of a scene's files that are not rendered, one line each. Loaders collect
 * them, and the loaded object keeps them. Private to render/ (lf_scene_warning returns the scene's
 * own). */
#ifndef LF_RENDER_WARNINGS_H
#define LF_RENDER_WARNINGS_H

#include "base/status.h"

#define LF_MAX_WARNINGS 64

/* Zeroed: none. */
typedef struct lf_warnings {
    int n;    /* lines kept */
    int more; /* lines that did not fit */
    char *line[LF_MAX_WARNINGS];
    char rest[64]; /* the line about the number of further lines */
} lf_warnings;

/* Adds the line "WHERE: WHAT", once if it repeats. Control characters are escaped; a line that is
 * too long is cut. Without memory the line is only counted, so that loading does not fail. */
void lf_warnings_add(lf_warnings *warnings, const char *where, const char *fmt, ...)
    LF_PRINTF(3, 4);
/* Adds "WHERE: 1 ONE" or "WHERE: N MANY"; no line if n is 0. */
void lf_warnings_count(lf_warnings *warnings, const char *where, long long n, const char *one,
                       const char *many);
/* Adds another collection's lines. */
void lf_warnings_add_all(lf_warnings *warnings, const lf_warnings *others);
/* Line `index`; the line about further ones is the last; NULL after it. Valid until the next
 * change. */
const char *lf_warnings_at(const lf_warnings *warnings, int index);
/* Accepts a zeroed struct; leaves it zeroed. */
void lf_warnings_finish(lf_warnings *warnings);

#endif
