/* Escapes external text for one line of a log or terminal. */
#ifndef LF_BASE_ESCAPE_H
#define LF_BASE_ESCAPE_H

#include <stddef.h>

/* Copies text into buf[size], always terminated. Control characters (C0, DEL, and C1 in UTF-8) and
 * invalid bytes become \n, \t, \r or \xNN. Text that does not fit is cut between characters. buf
 * and text must not overlap. Returns the length written. */
size_t lf_escape(char *buf, size_t size, const char *text);

#endif
