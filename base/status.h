/* Status codes, and the error report that goes with them.
 *
 * Every function that can fail returns an lf_status. Functions that access files, devices or
 * clients take a last parameter lf_error * (may be NULL) and end with `return lf_error_set(err,
 * LF_E_IO, "scene.json", "cannot open: %s", ...)`. Report and return are one expression, so that no
 * path forgets either. Nothing here allocates or logs. Thread: all functions are thread safe; an
 * lf_error belongs to its caller. */
#ifndef LF_BASE_STATUS_H
#define LF_BASE_STATUS_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

typedef enum lf_status {
    LF_OK = 0,
    LF_E_NOMEM = -1,     /* out of memory, or over a stated limit of size */
    LF_E_ARG = -2,       /* an external argument is out of range */
    LF_E_STATE = -3,     /* not possible in the current state */
    LF_E_IO = -4,        /* the operating system returned an error */
    LF_E_FORMAT = -5,    /* the contents of a file or message are invalid */
    LF_E_PATH = -6,      /* the path is outside the readable or writable folders */
    LF_E_NODEV = -7,     /* no such device, or it was unplugged: normal, not a failure */
    LF_E_TIMEOUT = -8,   /* a device or peer did not answer in time */
    LF_E_CANCELLED = -9, /* stopped by request */
    LF_E_BUSY = -10,     /* in use by another process or client */
    LF_E_EXISTS = -11,   /* a file exists and overwriting was not requested */
} lf_status;

#define LF_NODISCARD __attribute__((warn_unused_result))
#define LF_PRINTF(f, a) __attribute__((format(printf, f, a)))

/* What went wrong and where, in one line. `where` is a file, address or option; line 0 = none;
 * pointer is a JSON pointer ("/camera/views"; empty = none). Strings are always terminated; control
 * characters are already escaped. */
typedef struct lf_error {
    lf_status status;
    int line;
    char where[512];
    char pointer[256];
    char what[512];
} lf_error;

/* Name of a code, e.g. "LF_E_FORMAT"; never NULL. */
const char *lf_status_name(lf_status status);

/* Fills *err (may be NULL), escaping control characters and cutting long text; returns status. */
lf_status lf_error_set(lf_error *err, lf_status status, const char *where, const char *fmt, ...)
    LF_PRINTF(4, 5);

/* As lf_error_set, with a line (0 = unknown) and a JSON pointer (NULL or "" = none). */
lf_status lf_error_set_at(lf_error *err, lf_status status, const char *where, int line,
                          const char *pointer, const char *fmt, ...) LF_PRINTF(6, 7);

/* For static analysers, which do not see across files: the returned status is the argument. */
#ifdef __clang_analyzer__
#define lf_error_set(err, status, ...) (lf_error_set((err), (status), __VA_ARGS__), (status))
#define lf_error_set_at(err, status, ...) (lf_error_set_at((err), (status), __VA_ARGS__), (status))
#endif

/* Writes "WHERE:LINE: /pointer: WHAT" (without absent parts) into buf; returns buf. */
char *lf_error_format(const lf_error *err, char *buf, size_t size);

#endif
