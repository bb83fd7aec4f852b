/* Private to quilt/print: small text on prints, in millimetres. Characters are 5 x 7 squares, one
 * square apart: digits, '.', ' ', '%', 'x' and the letters of "lpi", "dpi" and "mm". Pure
 * functions. */
#ifndef LF_QUILT_LABEL_H
#define LF_QUILT_LABEL_H

#include <stdbool.h>

double lf_label_width(const char *text, double height);
/* True if the point (x, y), from the top left corner of the text, is ink; false outside it and for
 * unknown characters. */
bool lf_label_ink(const char *text, double height, double x, double y);

#endif
