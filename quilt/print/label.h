/* Private to quilt/print: small text on prints, in millimetres. Characters are 5 x 7 squares, one
 * square apart; there are the digits, '.', ' ', '%', 'x' and the letters of "lpi", "dpi" and
 * "mm".
 * Pure functions. */
#ifndef LF_QUILT_LABEL_H
#define LF_QUILT_LABEL_H

#include <stdbool.h>

double lf_label_width(const char *text, double height);
/* Whether the point (x, y) from the top left corner of the text is ink; false outside of it and for
 * characters that there are not. */
bool lf_label_ink(const char *text, double height, double x, double y);

#endif
