/* secret: random texts that prove who calls, and their comparison. Thread: any. */
#ifndef LF_DAEMON_WEB_SECRET_H
#define LF_DAEMON_WEB_SECRET_H

#include "base/status.h"

/* 128 bits as hexadecimal digits, terminated. */
#define LF_SECRET_DIGITS 32
typedef struct lf_secret {
    char text[LF_SECRET_DIGITS + 1];
} lf_secret;

/* Draws a secret from the kernel's random numbers. LF_E_IO. */
LF_NODISCARD lf_status lf_secret_draw(lf_secret *out, lf_error *err);
/* True if text[n] is the secret. The time depends on n alone. */
bool lf_secret_equals(const lf_secret *secret, const char *text, size_t n);

#endif
