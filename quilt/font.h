/* Private to quilt: a small font for texts on panels. A glyph is 5 x 9 squares: 7 above the
 * baseline, 2 below it. Pure functions. */
#ifndef LF_QUILT_FONT_H
#define LF_QUILT_FONT_H

#include <stdint.h>

enum { LF_FONT_COLUMNS = 5, LF_FONT_ASCENT = 7, LF_FONT_ROWS = 9 };

/* The rows of a printable ASCII character from the top, the leftmost square the highest of five
 * bits; those of '?' for any other character. */
const uint8_t *lf_font_rows(char character);
/* UTF-8 to what the font has: accents of Latin letters are left out, what else there is becomes
 * '?', control characters become blanks. out holds size bytes, its end included. */
void lf_font_ascii(const char *text, char *out, unsigned size);

#endif
