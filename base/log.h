/* The log of the process. Library code logs only at debug level; the program that decides logs the
 * outcome once. Lines go to stderr as "NAME: WHAT", with sd-daemon level prefixes ("<3>") if stderr
 * is the journal ($JOURNAL_STREAM). Control characters are escaped. Thread safe: one write per
 * line. */
#ifndef LF_BASE_LOG_H
#define LF_BASE_LOG_H

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

/* Logs an error as one line at LF_LOG_ERROR. */
void lf_log_error(const lf_error *err);

#endif
