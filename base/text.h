/* text: what texts of other programs have in common, whatever they say. All readers of text go by
 * this: a byte order mark of UTF-8 in front is none of it; UTF-16 and UTF-32 are refused by name;
 * lines end in LF, CR LF or CR; a NUL byte is a blank. One thread. */
#ifndef LF_BASE_TEXT_H
#define LF_BASE_TEXT_H

#include "base/status.h"

/* Bytes in front of the text that begins with these n: a mark of UTF-8, or none. LF_E_FORMAT: it is
 * text of another encoding, where being the file's name. */
LF_NODISCARD lf_status lf_text_begin(const char *bytes, size_t n, const char *where,
                                     size_t *out_mark, lf_error *err);
/* Makes blanks of NUL bytes. */
void lf_text_blank(char *text, size_t n);
/* Where the first line of a text ends: the place of its LF or CR, n where there is none. *likely
 * ('\n' or '\r') says what is looked for first, and becomes what was found. */
size_t lf_text_line_end(const char *text, size_t n, char *likely);

/* All of that to a whole text, in place; *n may become less. Lines end in LF or CR LF from here on.
 * LF_E_FORMAT as lf_text_begin. */
LF_NODISCARD lf_status lf_text_take(char *text, size_t *n, const char *where, lf_error *err);

#endif
