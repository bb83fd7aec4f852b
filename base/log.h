/* The log of the process. Library code logs only at debug level; the program that decides logs the
 * outcome once. Lines go to stderr as "NAME: WHAT", with sd-daemon level prefixes ("<3>") if stderr
 * is the journal ($JOURNAL_STREAM). Control characters are escaped. Thread safe: one write per
 * line. */
#ifndef LF_BASE_LOG_H
#define LF_BASE_LOG_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

typedef enum lf_log_level {
    LF_LOG_ERROR = 3,
    LF_LOG_WARNING = 4,
    LF_LOG_INFO = 6,
    LF_LOG_DEBUG = 7
} lf_log_level;

/* Sets the program's name (must outlive the process) and the highest level shown (default
 * LF_LOG_INFO; the environment variable QUILTD_DEBUG=1 makes it LF_LOG_DEBUG). Call once before
 * threads start. */
void lf_log_init(const char *program, lf_log_level level);

void lf_log(lf_log_level level, const char *fmt, ...) LF_PRINTF(2, 3);

/* From now on lines up to the level shown go to taken, unescaped, on the thread that logs, instead
 * of to stderr and to the lines in memory. NULL: as before. Call while no other thread logs. */
void lf_log_take(void (*taken)(void *context, lf_log_level level, const char *text), void *context);

/* Logs an error as one line at LF_LOG_ERROR. */
void lf_log_error(const lf_error *err);

/* The last lines stay in memory, numbered from 1. */
#define LF_LOG_KEPT 200
#define LF_LOG_KEPT_TEXT 1024
typedef struct lf_log_line {
    int64_t number;
    double time; /* seconds since 1970, UTC */
    lf_log_level level;
    char text[LF_LOG_KEPT_TEXT]; /* escaped, without the program's name; cut if it is longer */
} lf_log_line;

/* Number of the last line; 0: none. */
int64_t lf_log_last(void);
/* Copies the line with this number. False: it is no longer kept, or not there yet. */
bool lf_log_line_at(int64_t number, lf_log_line *out);
/* From now on calls told after every line, on the thread that logs, under the log's lock: it must
 * neither log nor block. NULL: nobody is told; told is not running any more when this returns. */
void lf_log_tell(void (*told)(void *context), void *context);

#endif
