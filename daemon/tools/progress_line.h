/* The line on a terminal that says how far a program is. */
#ifndef LF_DAEMON_PROGRESS_LINE_H
#define LF_DAEMON_PROGRESS_LINE_H

#include "base/import/import.h"

/* Zeroed: never drawn. Thread: one at a time, but for lf_progress_line_reading. */
typedef struct lf_progress_line {
    bool on;             /* stderr is a terminal */
    const char *program; /* what the line begins with */
    double last;         /* when it was drawn; 0 = not there */
} lf_progress_line;

/* Draws it, at most ten times a second. */
void lf_progress_line_draw(lf_progress_line *line, const char *text);
void lf_progress_line_clear(lf_progress_line *line);
/* For lf_import_watch, context an lf_progress_line: of files that are read at once, whichever has
 * been for longest says so first. */
void lf_progress_line_reading(void *context, const lf_import_progress *progress);

#endif
