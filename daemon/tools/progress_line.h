/* The line that says how far a program is: on a terminal one that is drawn over, in logs one now
 * and then. */
#ifndef LF_DAEMON_PROGRESS_LINE_H
#define LF_DAEMON_PROGRESS_LINE_H

#include "base/sandbox/import.h"

/* Between two lines of a log, seconds. */
#define LF_PROGRESS_INTERVAL 30.0

/* Zeroed: never drawn. Thread: one at a time, but for lf_progress_line_reading. */
typedef struct lf_progress_line {
    bool on;             /* stderr is a terminal */
    bool logs;           /* it is none: a line of the log (base/log.h) once in an interval */
    const char *program; /* what the line begins with, on a terminal */
    double interval;     /* of the log, seconds; the first line comes after one, too */
    double last;         /* when it was drawn, or an interval began; 0 = not there, or none has */
} lf_progress_line;

/* Draws it, at most ten times a second; or logs it, where the interval is over. */
void lf_progress_line_draw(lf_progress_line *line, const char *text);
/* Takes it off the terminal. */
void lf_progress_line_clear(lf_progress_line *line);
/* For lf_import_watch, context an lf_progress_line: of files that are read at once, whichever has
 * been for longest says so first. */
void lf_progress_line_reading(void *context, const lf_import_progress *progress);

#endif
