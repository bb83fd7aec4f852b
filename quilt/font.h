/* Private to quilt/: a small font for text on panels. A glyph is 5 x 9 squares: 7 above the
 * baseline, 2 below it. Pure functions. */
#ifndef LF_QUILT_FONT_H
#define LF_QUILT_FONT_H

#include <stdint.h>

enum { LF_FONT_COLUMNS = 5, LF_FONT_ASCENT = 7, LF_FONT_ROWS = 9 };

/* The rows of a printable ASCII character from the top; the leftmost square is the highest of five
 * bits. '?' for any other character. */
const uint8_t *lf_font_rows(char character);
/* Converts UTF-8 to the font's characters: Latin letters lose their accents, other characters
 * become '?', control characters become blanks. out has `size` bytes, with its end. */
void lf_font_ascii(const char *text, char *out, unsigned size);

#endif
