/* text: the common conventions of external text, for all text readers. A UTF-8 byte order mark at
 * the start is skipped. UTF-16 and UTF-32 are refused by name. Lines end in LF, CR LF or CR. A NUL
 * byte counts as a blank. One thread. */
#ifndef LF_BASE_TEXT_H
#define LF_BASE_TEXT_H

#include "base/status.h"

/* *out_mark: the length of a UTF-8 byte order mark at the start of these n bytes, or 0.
 * LF_E_FORMAT: text in another encoding; `where` is the file's name. */
LF_NODISCARD lf_status lf_text_begin(const char *bytes, size_t n, const char *where,
                                     size_t *out_mark, lf_error *err);
/* Replaces NUL bytes by blanks. */
void lf_text_blank(char *text, size_t n);
/* The index of the LF or CR that ends the first line; n if there is none. *likely ('\n' or '\r') is
 * searched for first, and becomes the one found. */
size_t lf_text_line_end(const char *text, size_t n, char *likely);

/* Applies all of this to a whole text, in place; *n may become smaller. Lines then end in LF or CR
 * LF. LF_E_FORMAT as for lf_text_begin. */
LF_NODISCARD lf_status lf_text_take(char *text, size_t *n, const char *where, lf_error *err);

#endif
