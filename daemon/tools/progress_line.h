/* Progress lines: redrawn in place on a terminal, logged at intervals otherwise. */
#ifndef LF_DAEMON_PROGRESS_LINE_H
#define LF_DAEMON_PROGRESS_LINE_H

#include "base/sandbox/import.h"

/* Time between two log lines, in seconds. */
#define LF_PROGRESS_INTERVAL 30.0

/* Zeroed: never drawn. Thread: one at a time, except lf_progress_line_reading. */
typedef struct lf_progress_line {
    bool on;             /* stderr is a terminal */
    bool logs;           /* stderr is not a terminal: one log line (base/log.h) per interval */
    const char *program; /* start of the line on a terminal */
    double interval;     /* log interval in seconds; the first line also comes after one */
    double last;         /* time of the last draw or start of the interval; 0 = not drawn, or not
                          * started */
} lf_progress_line;

/* Draws the line, at most ten times per second, or logs it if the interval is over. */
void lf_progress_line_draw(lf_progress_line *line, const char *text);
/* Removes the line from the terminal. */
void lf_progress_line_clear(lf_progress_line *line);
/* For lf_import_watch; context is an lf_progress_line. If several files are read at once, the one
 * that has taken longest is shown first. */
void lf_progress_line_reading(void *context, const lf_import_progress *progress);

#endif
