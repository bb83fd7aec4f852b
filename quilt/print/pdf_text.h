/* Private to pdf.c: characters of a text. */
#ifndef LF_QUILT_PDF_TEXT_H
#define LF_QUILT_PDF_TEXT_H

#include <stdint.h>

/* The next character of UTF-8 text that is not at its end; *text moves behind it. '?' for invalid
 * bytes and for control characters. */
uint32_t lf_pdf_next_char(const char **text);
/* The same as a byte of WinAnsiEncoding; '?' for what Latin-1 lacks. */
unsigned lf_pdf_next_latin(const char **text);

#endif
